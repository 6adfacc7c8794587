"""What is told of a version, and what is kept of it."""

import json
import re
import shutil

from support.patience import TIMEOUT, wait_until
from support.pictures import Exr
from support.rights import without_superpowers
from support.session import HALF, SHADE, Session


class Figures(Session):
    def test_figures_of_a_change_with_a_known_effect(self):
        with self.watch() as w:
            w.picture()
            first = w.figures()
            self.assertEqual(first["last_good"], None)
            self.assertEqual(first["rays"]["eye"], 64 * 48)
            self.assertLess(w.wait("reference", version=1)["to_reference"]["rmse"], 1e-5)
            before = Exr(self.path("out.exr"))
            self.edit("shade.glsl", SHADE, SHADE.replace("E", "0.375 * E", 1))  # no other test has compiled it
            w.picture()
            told = w.figures()
            after = Exr(self.path("out.exr"))
            differences = [abs(a - b) for a, b in zip(before.values(), after.values())]
            lit = sum(before.pixel(x, y) != after.pixel(x, y) for x in range(64) for y in range(48))
            self.assertEqual(told["changed_pixels"], lit, w)
            self.assertAlmostEqual(told["to_last_good"]["max"], max(differences), 6)
            rms = (sum(d * d for d in differences) / len(differences)) ** 0.5
            self.assertAlmostEqual(told["to_last_good"]["rmse"], rms, 6)
            self.assertAlmostEqual(told["to_reference"]["rmse"], rms, 4)
            self.assertEqual(set(told["rays_change"].values()), {0})
            self.assertGreater(told["spirv"]["added"], 0)
            self.assertTrue(told["trace"]["interleaved"], w)
            self.assertGreater(told["trace"]["ratio"], 0)
            for name in ("glslang", "optimiser", "check", "pipeline"):
                self.assertGreater(told["seconds"][name], 0, name)

    def test_rays_that_are_no_longer_cast(self):
        with self.watch() as w:
            w.picture()
            shadow = w.figures()["rays"]["shadow"]
            self.assertGreater(shadow, 0)
            self.edit("whitted.comp", "bool faces = facesLight(surface, light);", "bool faces = false;")
            w.picture()
            self.assertEqual(w.figures()["rays_change"]["shadow"], -shadow, w)

    def test_lines_for_people_are_aligned(self):
        with self.watch(json_lines=False) as w:
            self.assertTrue(wait_until(lambda: re.search(r"^version 1: in out.exr, out.png after \d+\.\d\d s", w.out, re.M)), w)
            self.assertTrue(wait_until(lambda: re.search("^  reference ", w.out, re.M), TIMEOUT), w)
            self.edit("shade.glsl", SHADE, HALF)
            told = lambda: w.out.partition("version 2, shade.glsl changed")[2]
            self.assertTrue(wait_until(lambda: "SPIR-V" in told(), TIMEOUT), w)
            lines = told().splitlines()[1:]
            self.assertEqual([line.split()[0] for line in lines], ["compile", "trace", "picture", "reference", "rays", "SPIR-V"], w)
            columns = {len(re.match(r"  \S+ +", line)[0]) for line in lines}
            self.assertEqual(len(columns), 1, w)
            self.assertRegex(told(), r"\n  picture +\d+ pixels changed \(\d+ %\), rms \S+, max \S+\n")
            line = self.edit("shade.glsl", HALF, "return E + ;")
            self.assert_gcc(w, "shade.glsl", line, "syntax error")
            self.assertTrue(wait_until(lambda: "stays that of version 2" in w.out), w)
            self.edit("shade.glsl", "return E + ;", SHADE)
            self.assertTrue(wait_until(lambda: "version 4, shade.glsl changed" in w.out, TIMEOUT), w)

    def test_quiet_prints_only_errors(self):
        with self.watch("--quiet", json_lines=False) as w:
            self.assertTrue(wait_until(self.path("out.exr").exists, TIMEOUT), w)
            self.edit("shade.glsl", SHADE, "return E + ;")
            w.wait_for_error("syntax error")
            self.assertEqual(w.out, "")


class Kept(Session):
    def test_each_version_is_kept_whole(self):
        with self.watch("--keep", "kept") as w:
            w.picture()
            w.figures()
            w.wait("reference")
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()
            self.assertEqual(w.figures()["kept"], "kept/0002", w)
            self.edit("shade.glsl", HALF, "return wrong;")
            w.refused()
            self.edit("shade.glsl", "return wrong;", SHADE)
            w.picture()
            w.figures()
        self.assertEqual(sorted(p.name for p in self.path("kept").iterdir()), ["0001", "0002", "0004"])
        with self.watch("--keep", "kept") as w:
            w.version = 4
            w.picture()
            w.figures()
        self.assertEqual(sorted(p.name for p in self.path("kept").iterdir()), ["0001", "0002", "0004", "0005"])
        for number in ("0001", "0002", "0004", "0005"):
            kept = self.path("kept") / number
            self.assertEqual(sorted(p.name for p in kept.iterdir()), ["figures.json", "picture.exr", "scene", "shaders"])
            self.assertEqual(json.loads((kept / "figures.json").read_text())["version"], int(number))
            self.assertEqual((kept / "picture.exr").read_bytes(), self.rendered(shaders=kept / "shaders"), number)
        self.assertIsNotNone(json.loads(self.path("kept/0001/figures.json").read_text())["to_reference"])
        self.assertIn("0.5 * E", self.path("kept/0002/shaders/shade.glsl").read_text())

    def test_a_folder_that_cannot_be_written_is_told(self):
        self.path("kept").mkdir()
        with self.watch("--keep", "kept", preexec_fn=without_superpowers) as w:
            w.picture()
            w.figures()
            w.wait("reference")  # it changes the figures once more
            shutil.rmtree(self.path("kept"))
            self.path("kept").write_text("a file")
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()
            w.wait("trouble", version=2)
            self.path("kept").unlink()
            self.edit("shade.glsl", HALF, SHADE)
            w.picture()
            self.assertEqual(w.figures()["kept"], "kept/0003", w)
