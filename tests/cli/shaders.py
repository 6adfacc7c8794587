"""Shaders with faults."""

import shutil

from support.command import TINY, Command
from support.scene_texts import SPHERE
from support.settings import SCENES


class Shaders(Command):
    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)
        self.write("out.exr", b"was here before")
        shutil.copytree(SCENES.parent / "shaders", self.path("kernel"))

    def edit(self, name, change):
        path = self.path("kernel") / name
        lines = path.read_text().splitlines()
        change(lines)
        path.write_text("\n".join(lines) + "\n")

    def line_of(self, name, text):
        lines = (self.path("kernel") / name).read_text().splitlines()
        return 1 + next(i for i, line in enumerate(lines) if text in line)

    def refuse_kernel(self, *, faults=1, says=(), **options):
        args = ["scene.json", *TINY, "--shaders", "kernel"]
        self.refuse("compare", *args, faults=faults, says=says, **options)
        return self.refuse("render", *args, "-o", "out.exr", faults=faults, says=says, **options)

    def test_a_fault_in_an_include_is_placed_there_in_one_line(self):
        # A line of its own behind the first function's opening brace.
        place = self.line_of("shade.glsl", ") {")
        self.edit("shade.glsl", lambda lines: lines.insert(place, "  float broken = notDeclared;"))
        run = self.refuse_kernel(faults=None, says="notDeclared")
        self.assertRegex(run.err, rf"(?m)^kernel/shade\.glsl:{place + 1}: error: .*notDeclared")
        self.check_message(run, 1)

    def test_every_line_about_a_broken_kernel_has_a_place(self):
        self.edit("shade.glsl", lambda lines: lines.insert(0, "float a = one, b = two;\nfloat c = three;"))
        run = self.refuse_kernel(faults=None)
        for line in run.err.splitlines():
            self.assertRegex(line, r"^\S+:\d+: error: \S", run)
        self.assertIn("kernel/shade.glsl:1: error:", run.err)

    def test_a_fault_in_the_kernel_is_placed_there(self):
        place = self.line_of("whitted.comp", "void main()")
        self.edit("whitted.comp", lambda lines: lines.insert(place, "  notDeclared = 1;"))
        run = self.refuse_kernel(faults=None, says="notDeclared")
        self.assertRegex(run.err, rf"(?m)^kernel/whitted\.comp:{place + 1}: error: .*notDeclared")
        self.check_message(run, 1)

    def test_a_missing_include_is_named_with_the_line_that_wants_it(self):
        (self.path("kernel") / "shade.glsl").unlink()
        place = self.line_of("whitted.comp", '#include "shade.glsl"')
        run = self.refuse_kernel(faults=None, says="shade.glsl")
        self.assertRegex(run.err, rf"(?m)^kernel/whitted\.comp:{place}: error: .*shade\.glsl")
        self.check_message(run, 1)

    def test_an_include_of_itself_is_refused(self):
        self.write("kernel/loop.glsl", '#include "loop.glsl"\n')
        self.edit("whitted.comp", lambda lines: lines.append('#include "loop.glsl"'))
        run = self.refuse_kernel(faults=None, says="loop.glsl")
        self.assertRegex(run.err, r"loop\.glsl:1: error: ")

    def test_a_function_without_body_is_refused_in_one_line(self):
        self.edit("whitted.comp", lambda lines: lines.append("void nowhere();\nvoid user() { nowhere(); }"))
        place = self.line_of("whitted.comp", "void main()")
        self.edit("whitted.comp", lambda lines: lines.insert(place - 1, "void nowhere();"))
        self.edit("whitted.comp", lambda lines: lines.insert(place + 1, "  nowhere();"))
        run = self.refuse_kernel(says=["kernel/whitted.comp", "nowhere"])
        self.assertNotIn("ERROR", run.err)

    def test_an_empty_kernel_is_refused_in_one_line(self):
        self.write("kernel/whitted.comp", "")
        run = self.refuse_kernel(says="kernel/whitted.comp")
        self.assertNotIn("ERROR", run.err)

    def test_a_kernel_that_is_no_text_is_refused(self):
        self.write("kernel/whitted.comp", bytes(range(256)) * 16)
        self.refuse_kernel(faults=None, says="kernel/whitted.comp")

    def test_a_missing_kernel_is_named(self):
        (self.path("kernel") / "whitted.comp").unlink()
        self.refuse_kernel(says="kernel/whitted.comp")

    def test_a_missing_folder_of_shaders_is_named(self):
        shutil.rmtree(self.path("kernel"))
        self.refuse_kernel(says=["kernel", "--shaders"])
        self.write("kernel", "a file")
        self.refuse_kernel(says="kernel")
