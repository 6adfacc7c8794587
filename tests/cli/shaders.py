"""Shaders with faults."""

import json
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

    def test_check_takes_what_is_sound(self):
        run = self.do("shaders", "--check", "kernel")
        self.assertIn("kernel: sound; compiles to the same as turner's own sources", run.out)
        self.edit("shade.glsl", lambda lines: lines.append("float mine() { return 1.0; }"))
        self.edit("whitted.comp", lambda lines: lines.insert(self.line_of("whitted.comp", "void addLight(") , "  LACKS(Lights, mine() > 2.0);"))
        run = self.do("shaders", "--check", "kernel", SCENES / "diffuse.json")
        self.assertIn("kernel: sound; edited", run.out)
        self.assertIn("REFLECTION is compiled out: no material of this scene reflects", run.out)
        result = json.loads(self.do("shaders", "--check", "kernel", "--json").out)
        self.assertEqual((result["sound"], result["edited"], result["diagnoses"]), (True, True, []))

    def test_check_refuses_what_is_not(self):
        place = self.line_of("shade.glsl", "float q = 0.5")
        self.edit("shade.glsl", lambda lines: lines.__setitem__(place - 1, lines[place - 1].replace("0.5", "oops")))
        run = self.run_turner("shaders", "--check", "kernel", "--json")
        self.assertEqual(run.code, 2, run)
        self.assertRegex(run.err, rf"^kernel/shade\.glsl:{place}:15: error: .*oops")
        result = json.loads(run.out)
        self.assertFalse(result["sound"])
        self.assertEqual([(d["file"], d["line"], d["column"]) for d in result["diagnoses"]], [("kernel/shade.glsl", place, 15)])
        # What no compiler sees.
        self.edit("shade.glsl", lambda lines: lines.__setitem__(place - 1, lines[place - 1].replace("oops", "0.5")))
        self.edit("layout.h", lambda lines: lines.__setitem__(slice(None), [line.replace("kGrid = 0u", "kGrid = 1u") for line in lines]))
        self.refuse("shaders", "--check", "kernel", faults=None, says="kGrid is 1u here, but 0u")

    def test_check_shows_warnings(self):
        place = self.line_of("whitted.comp", "#extension GL_GOOGLE")
        self.edit("whitted.comp", lambda lines: lines.insert(place, "#extension GL_TURNER_no_such_thing : warn"))
        run = self.do("shaders", "--check", "kernel")
        self.assertRegex(run.out, r"kernel/whitted\.comp:\d+: warning: .*no_such_thing")
        # They are told each time, though the kernel might be found in the cache.
        for _ in range(2):
            run = self.do("render", "scene.json", *TINY, "--shaders", "kernel", "-o", "out.exr")
            self.assertIn(": warning: ", run.out)

    def test_check_and_copy_do_not_mix(self):
        for args in ([], ["--check", "kernel", "--copy", "new"], ["--copy", "new", "--json"], ["--copy", "new", "scene.json"]):
            self.refuse("shaders", *args, says="--check DIR")

    def test_a_folder_of_another_version_is_refused_by_render(self):
        self.edit("layout.h", lambda lines: lines.__setitem__(slice(None), [line.replace("kGrid = 0u", "kGrid = 1u") for line in lines]))
        self.refuse_kernel(faults=None, says="kGrid is 1u here, but 0u")

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
