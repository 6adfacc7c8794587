"""No output is written over an input, and no two outputs are one file: whatever their names."""

import os
import shutil

from support.command import LONG, TINY, Command
from support.pictures import write_exr
from support.scene_texts import MESH_SCENE, OBJ, SPHERE
from support.settings import ROOT


class Overwriting(Command):
    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)
        self.write("mesh.json", MESH_SCENE)
        self.write("shape.obj", OBJ)
        self.path("folder").mkdir()
        os.symlink("folder", self.path("other"))

    def aliases(self, name, ending):
        """Other names of a file: itself, by a folder's link, a link, a link to a link, a hard link."""
        names = [f"symbolic{ending}", f"second{ending}", f"hard{ending}"]
        os.symlink(name, self.path(names[0]))
        os.symlink(names[0], self.path(names[1]))
        os.link(self.path(name), self.path(names[2]))
        yield from names
        for alias in names:
            self.path(alias).unlink()

    def refuse_all(self, input_file, *command, ending, option, **options):
        for alias in self.aliases(input_file, ending):
            with self.subTest(f"{option} {alias} -> {input_file}"):
                said = input_file if (self.path(input_file)).exists() else ""
                self.refuse(*command, option, alias, says=[alias, "is an input", os.path.basename(said)], **options)

    def test_scenes_and_meshes(self):
        # LONG: it is found before the work.
        self.refuse_all("scene.json", "render", "scene.json", *LONG, ending=".exr", option="-o")
        self.refuse_all("scene.json", "render", "scene.json", *LONG, ending=".json", option="--stats")
        self.refuse_all("scene.json", "compare", "scene.json", *LONG, ending=".exr", option="--error-image")
        self.refuse_all("scene.json", "watch", "scene.json", ending=".png", option="-o")
        self.refuse_all("shape.obj", "render", "mesh.json", *LONG, ending=".exr", option="-o")
        self.refuse_all("shape.obj", "render", "mesh.json", *LONG, ending=".json", option="--stats")
        self.refuse_all("shape.obj", "compare", "mesh.json", *LONG, ending=".exr", option="--error-image")
        self.refuse("render", "mesh.json", *LONG, "--stats", "shape.obj", says=["shape.obj", "is an input"])
        self.refuse("render", "mesh.json", *LONG, "-o", "exr:shape.obj", says=["shape.obj", "is an input"])

    def test_compared_pictures(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        write_exr(self.path("b.exr"), 2, 2, [(1, 1, 1)] * 4)
        for picture in ("a.exr", "b.exr"):
            self.refuse_all(picture, "compare", "a.exr", "b.exr", ending=".exr", option="--error-image")

    def test_a_file_behind_stdin_or_stdout(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        with open(self.path("a.exr"), "rb") as stdin:
            self.refuse("compare", "-", "a.exr", "--error-image", "a.exr", says="is an input", stdin=stdin)
        with open(self.path("scene.json"), "ab") as stdout:
            self.refuse("render", "scene.json", *LONG, "-o", "-", says=["<stdout>", "scene.json"], stdout=stdout)

    def test_what_is_told_into_an_input(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        for name, *arguments in (("scene.json", "render", "scene.json", *LONG, "-o", "out.exr"),
                                 ("a.exr", "compare", "a.exr", "a.exr", "--json")):  # fmt: skip
            with open(self.path(name), "ab") as stdout:
                self.refuse(*arguments, says=["<stdout> is the input", name], stdout=stdout)

    def test_a_device_takes_whatever_comes(self):
        self.do("render", "scene.json", *TINY, "--backend", "reference", "-o", "exr:/dev/null", "--stats", "/dev/null")

    def test_shaders(self):
        shutil.copytree(ROOT / "shaders", self.path("kernel"))
        self.write("kernel/extra.glsl", "// included in an odd spelling\n")
        main = self.path("kernel/whitted.comp")
        main.write_text(main.read_text() + '\n#/* here */include "extra.glsl"\n')
        shaders = ["--shaders", "kernel"]
        for name in ("kernel/whitted.comp", "kernel/shade.glsl", "kernel/layout.h"):
            self.refuse_all(name, "render", "scene.json", *LONG, *shaders, ending=".exr", option="-o")
            self.refuse("render", "scene.json", *LONG, *shaders, "--stats", name, says=[name, "is an input"])
            self.refuse("compare", "scene.json", *LONG, *shaders, "--error-image", f"exr:{name}", says="is an input")
            self.refuse("watch", "scene.json", *shaders, "-o", f"exr:{name}", says=[name, "is an input"])
        # Found by the compiler alone.
        self.refuse("render", "scene.json", *LONG, *shaders, "--stats", "kernel/extra.glsl", says="is an input")

    def test_turners_own_shaders(self):
        os.symlink(ROOT / "shaders/shade.glsl", self.path("link.exr"))
        before = (ROOT / "shaders/shade.glsl").read_bytes()
        try:
            for args in (["render", "scene.json", *LONG, "-o"], ["render", "scene.json", *LONG, "--stats"],
                         ["render", "scene.json", *LONG, "--backend", "reference", "--stats"],
                         ["compare", "scene.json", *LONG, "--error-image"], ["watch", "scene.json", "-o"]):
                with self.subTest(args):
                    self.refuse(*args, "link.exr", says=["link.exr", "is an input", "shade.glsl"])
        finally:
            if (ROOT / "shaders/shade.glsl").read_bytes() != before:
                (ROOT / "shaders/shade.glsl").write_bytes(before)

    def test_two_outputs_that_are_one_file_which_is_not_there_yet(self):
        os.symlink("new.exr", self.path("dangling.exr"))
        for a, b in (("a.exr", "a.exr"), ("a.exr", "./a.exr"), ("a.exr", "folder/../a.exr"), ("dangling.exr", "new.exr"),
                     ("folder/a.exr", "other/a.exr"), ("a.exr", self.path("a.exr")), ("a.png", "png:a.png")):
            with self.subTest(a=a, b=b):
                self.refuse("render", "scene.json", *LONG, "-o", a, "-o", b, says=["the output", "a" if a == b else str(b)[-5:]])
        self.refuse("render", "scene.json", *LONG, "-o", "a.exr", "--stats", "./a.exr", says=["a.exr", "./a.exr"])
        self.refuse("watch", "scene.json", "-o", "a.exr", "-o", "./a.exr", says=["a.exr", "./a.exr"])
        self.refuse("watch", "scene.json", "-o", "a.exr", "--keep", "./a.exr", says=["a.exr", "./a.exr"])

    def test_two_outputs_that_are_one_file(self):
        self.write("a.exr", b"was here before")
        os.symlink("a.exr", self.path("link.exr"))
        os.link(self.path("a.exr"), self.path("hard.exr"))
        for b in ("link.exr", "hard.exr"):
            self.refuse("render", "scene.json", *LONG, "-o", "a.exr", "-o", b, says=["a.exr", b, "one file"])

    def test_a_report_over_its_scene(self):
        self.path("out").mkdir()
        self.write("out/report.json", SPHERE)
        os.symlink("../shape.obj", self.path("out/report.csv"))
        options = ["--width", "8", "--max-samples", "1", "--repeats", "1", "-o", "out"]
        self.refuse("report", "out/report.json", *options, says=["out/report.json", "is an input"])
        self.refuse("report", "mesh.json", *options, says=["out/report.csv", "shape.obj"])
        self.path("out/report.csv").unlink()
        self.path("out/pictures").mkdir()
        os.symlink("../../scene.json", self.path("out/pictures/1-scene-converged.exr"))
        self.refuse("report", "scene.json", *options, "--exr", says=["converged.exr", "scene.json"])

    def test_a_copy_of_the_shaders_inside_of_them(self):
        inside = ROOT / "shaders/copy"
        os.symlink(ROOT / "shaders", self.path("link"))
        self.addCleanup(shutil.rmtree, inside, ignore_errors=True)
        for name in (inside, "link/copy"):
            self.refuse("shaders", "--copy", name, says=["copy", "elsewhere"])
            self.assertFalse(inside.exists())

    def test_a_copy_of_the_shaders_through_a_link_to_no_folder_yet(self):
        for name in ("copied", "copied/"):
            with self.subTest(name):
                os.symlink("new/kernel", self.path("copied"))
                self.do("shaders", "--copy", name)
                self.assertTrue(self.path("copied").is_symlink())
                self.assertTrue(self.path("new/kernel/whitted.comp").is_file())
                shutil.rmtree(self.path("new"))
                self.path("copied").unlink()

    def test_options_that_are_no_values(self):
        for args in (["--stats", "--quiet"], ["-o", "--quiet"], ["--stats", "-o"], ["--shaders", "--quiet"],
                     ["--device", "--quiet"], ["-o", "--width", "8"]):
            with self.subTest(args):
                self.refuse("render", "scene.json", *LONG, *args, says=[args[1], "./" + args[1]])
        self.refuse("compare", "scene.json", *LONG, "--error-image", "--json", says=["--json", "./--json"])
        self.refuse("report", "scene.json", "-o", "--quick", says=["--quick", "./--quick"])
