"""Parameters of the shaders: their values change while the scene is watched, without a compilation."""

import json
import os
import subprocess

from support.command import without_progress
from support.editors import write_and_rename, write_in_place
from support.patience import TIMEOUT, wait_until
from support.pictures import Exr
from support.processes import memory_of
from support.session import BALL, SHADE, Session
from support.settings import PROGRAM

PARAMS = """PARAM(float, share, 1.0, 0.0, 1.0, "of all light")
PARAM(vec3, tint, vec3(1.0))  // a colour
PARAM(bool, inverted,
      false);
"""
SHARED = "return share * (inverted ? 1.0 - tint : tint) * E * brdf * dot(surface.Ns, L);"


class Sessions(Session):
    def fails(self, *args):
        command = [str(PROGRAM), *args]
        return subprocess.run(command, cwd=self.folder, env=self.environment(), capture_output=True, text=True)


class Params(Sessions):
    def setUp(self):
        super().setUp()
        self.edit("shade.glsl", SHADE, SHARED)
        kernel = self.path("kernel/shade.glsl")
        kernel.write_text(PARAMS + kernel.read_text())

    def write_params(self, values, editor=write_in_place):
        editor(self.path("params.json"), json.dumps(values).encode())

    def set_on_command_line(self, values):
        options = []
        for name, value in values.items():
            numbers = value if isinstance(value, list) else [value]
            options += ["--set", name + "=" + ",".join(json.dumps(number) for number in numbers)]
        return options

    def assert_shows(self, values, w):
        self.assertEqual(self.exr(), self.rendered(*self.set_on_command_line(values)), w)

    def test_a_file_of_values_is_followed(self):
        self.write_params({})
        with self.watch("--params", "params.json") as w:
            w.picture()
            self.assertEqual(w.figures()["params"], {"share": 1, "tint": [1, 1, 1], "inverted": False}, w)
            for values, changed in (
                ({"share": 0.5}, ["share"]),
                ({"share": 0.5, "tint": [1, 0.5, 0]}, ["tint"]),
                ({"tint": [1, 0.5, 0.25], "inverted": True}, ["share", "tint", "inverted"]),
                ({}, ["tint", "inverted"]),
            ):
                self.write_params(values, write_and_rename)
                w.picture()
                figures = w.figures()
                self.assertEqual(figures["changed"], changed, w)
                self.assertEqual(figures["seconds"]["glslang"] + figures["seconds"]["optimiser"], 0, w)
                self.assertEqual(figures["params"], {"share": 1, "tint": [1, 1, 1], "inverted": False} | values, w)
                self.assert_shows(values, w)
            w.stays_quiet()

    def test_lines_of_standard_input_add_up(self):
        ours, theirs = os.pipe()
        with self.watch("--params", "-", stdin=ours) as w:
            os.close(ours)
            w.picture()
            w.figures()
            os.write(theirs, b'{"share": 0.25}\n')
            w.picture()
            self.assert_shows({"share": 0.25}, w)
            os.write(theirs, b'{"tint": [0, 1, 0]}\n{"inver')
            w.picture()
            os.write(theirs, b'ted": true}\n')
            w.picture()
            self.assert_shows({"share": 0.25, "tint": [0, 1, 0], "inverted": True}, w)
            os.close(theirs)
            w.stays_quiet()
            # The shaders are followed as before.
            self.edit("shade.glsl", "share * (inv", "0.5 * share * (inv")
            w.picture()
            self.assert_shows({"share": 0.25, "tint": [0, 1, 0], "inverted": True}, w)

    def test_what_is_wrong_is_told_and_the_picture_stays(self):
        self.write_params({"share": 0.5})
        with self.watch("--params", "params.json") as w:
            w.picture()
            before = self.exr()
            for values, message in (
                ({"sahre": 0.5}, "sahre: the shaders have no parameter of this name; did you mean share?"),
                ({"share": 2}, "share: found 2; must be from 0 to 1"),
                ({"share": [1, 2]}, "share: found 2 numbers; share is a float: must be a number"),
                ({"inverted": 1}, "inverted: found a number; inverted is a bool: must be true or false"),
            ):
                self.write_params(values)
                refused = w.refused()
                self.assertIn(message, refused["diagnoses"][0]["message"], w)
                self.assertTrue(refused["diagnoses"][0]["file"].endswith("params.json"), w)
                self.assertEqual(self.exr(), before)
            self.path("params.json").write_text('{"share": ')
            trouble = w.wait("trouble")
            self.assertIn("params.json", trouble["diagnoses"][0]["file"], w)
            self.write_params({"share": 0.25})
            w.picture()
            self.assert_shows({"share": 0.25}, w)

    def test_a_wrong_file_at_the_start_is_refused(self):
        for text, says in ((None, "cannot"), ("{", "params.json:1"), ('{"share": "x"}', "must be a number")):
            if text is not None:
                self.path("params.json").write_text(text)
            run = self.fails("watch", "scene.json", "--shaders", "kernel", "--params", "params.json", "-o", "out.exr")
            self.assertEqual(run.returncode, 2, run)
            self.assertIn(says, run.stderr, run)

    def test_the_scene_the_command_line_and_the_file_come_in_this_order(self):
        self.write_scene(BALL | {"params": {"share": 0.25, "tint": [0.5, 0.5, 0.5]}})
        self.write_params({"inverted": True})
        with self.watch("--params", "params.json", "--set", "share=0.75") as w:
            w.picture()
            self.assertEqual(w.figures()["params"], {"share": 0.75, "tint": [0.5, 0.5, 0.5], "inverted": True}, w)
            self.write_params({"share": 0.125})
            w.picture()
            self.assertEqual(w.figures()["params"]["share"], 0.125, w)

    def test_values_stand_in_the_picture_and_in_kept_versions(self):
        self.write_params({"share": 0.5})
        with self.watch("--params", "params.json", "--keep", "kept") as w:
            w.picture()
            kept = w.figures()["kept"]
            self.assertEqual(json.loads((self.path(kept) / "params.json").read_text())["share"], 0.5)
            self.assertIn(b"share=0.5 tint=1,1,1 inverted=false", Exr(self.path(kept) / "picture.exr").attributes["turner:params"])
            self.write_params({"share": 0.75})
            w.picture()
            self.assertEqual(json.loads((self.path(w.figures()["kept"]) / "params.json").read_text())["share"], 0.75)

    def test_an_edit_and_a_value_at_once_show_both(self):
        self.write_params({})
        with self.watch("--params", "params.json") as w:
            w.picture()
            self.edit("shade.glsl", "share * (inv", "0.5 * share * (inv")
            self.write_params({"share": 0.5})
            self.assertTrue(wait_until(lambda: self.exr() == self.rendered("--set", "share=0.5"), TIMEOUT), w)

    def test_thousands_of_values_leave_nothing(self, changes=300):
        """The renderer's memory once its pipelines are there, and after all changes; the watcher's too."""
        ours, theirs = os.pipe()
        with self.watch("--params", "-", stdin=ours, outputs=["out.exr"]) as w:
            os.close(ours)
            w.picture()
            w.figures()
            for i in range(changes):
                os.write(theirs, b'{"share": %f}\n' % ((i % 1000 + 1) / 1001))
                w.picture()
                if i == changes // 3:
                    before = [memory_of(w.process.pid)[0], memory_of(w.worker())[0]]
            after = [memory_of(w.process.pid)[0], memory_of(w.worker())[0]]
            os.close(theirs)
            for b, a in zip(before, after):
                self.assertLess(a, 1.02 * b + 1024, f"{before} {after}")


class Declarations(Sessions):
    """What is wrong with a PARAM is told at its place, and by whatever compiles it."""

    def refuse(self, declaration, says):
        kernel = self.path("kernel/shade.glsl")
        text = kernel.read_text()
        kernel.write_text(declaration + "\n" + text)
        run = self.fails("render", "scene.json", "--shaders", "kernel", "-o", "out.exr", "--quiet")
        self.assertEqual(run.returncode, 2, run)
        lines = without_progress(run.stderr)
        self.assertEqual(len(lines), 1, run)
        self.assertIn("shade.glsl:1:1: error: ", lines[0])
        self.assertIn(says, lines[0])
        self.assertEqual(self.fails("shaders", "--check", "kernel").returncode, 2)
        kernel.write_text(text)

    def test_wrong_declarations(self):
        for declaration, says in (
            ("PARAM(double, a, 1.0)", "this is no parameter"),
            ("PARAM(float, a)", "this is no parameter"),
            ("PARAM(float, a, b)", "a: the default must be a number"),
            ("PARAM(vec3, a, vec3(1, 2))", "a: the default must be vec3(...)"),
            ("PARAM(bool, a, 1)", "a: the default must be true or false"),
            ("PARAM(float, a, 2.0, 0.0, 1.0)", "a: the default: found 2; must be from 0 to 1"),
            ("PARAM(int, a, 1.5)", "a whole number"),
            ("PARAM(float, a, 0.5, 1.0, 0.0)", "the lesser comes first"),
        ):
            with self.subTest(declaration):
                self.refuse(declaration, says)

    def test_a_name_is_declared_once_and_there_is_room_for_32(self):
        kernel = self.path("kernel/shade.glsl")
        text = kernel.read_text()
        kernel.write_text("PARAM(float, a, 1.0)\nPARAM(int, a, 1)\n" + text)
        run = self.fails("render", "scene.json", "--shaders", "kernel", "-o", "out.exr", "--quiet")
        self.assertIn("a is declared already", run.stderr)
        many = "".join(f"PARAM(uint, p{i}, {i}u)\n" for i in range(33))
        kernel.write_text(many + text)
        run = self.fails("render", "scene.json", "--shaders", "kernel", "-o", "out.exr", "--quiet")
        self.assertIn("shade.glsl:33:1: error: p32: there are 32 parameters already", run.stderr)
        kernel.write_text(many.replace("PARAM(uint, p32, 32u)\n", "") + text.replace(SHADE, "return vec3(uvec3(p31, p1, p2));"))
        self.turner("render", "scene.json", "--shaders", "kernel", "-o", "out.exr", "--set", "p2=7", "--quiet")
        self.assertEqual(Exr(self.path("out.exr")).pixel(36, 16), (31, 1, 7))
