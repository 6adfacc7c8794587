"""Errors in copies of the shaders are found in the figures."""

import shutil

from support.reports import InFolder, point
from support.settings import ROOT


class PlantedErrors(InFolder):
    PIXELS = "pixels[pixelAt] = packWord(sum / float(SAMPLES * SAMPLES), phase);"

    def measure_with(self, *shaders):
        report = self.measure(ROOT / "scenes/spheres.json", "--width", "160", "--max-samples", "2", "--repeats", "1",
                              "--no-cut-offs", *shaders)
        return report["scenes"][0]

    def of_shader(self, scene):
        return [p for p in scene["points"] if p["device"] != "reference"]

    def test_none_is_seen_where_none_is(self):
        for p in self.of_shader(self.measure_with()):
            self.assertLess(p["arithmetic"]["bad_pixels"], 4e-4, p["name"])
            self.assertLess(p["arithmetic"]["p999"], 1e-3, p["name"])
            self.assertLess(abs(p["arithmetic"]["mean_signed"]), 1e-5, p["name"])

    def test_one_pixel_in_a_thousand(self):
        shaders = self.shaders_with("whitted.comp", self.PIXELS, self.PIXELS.replace(
            "sum / float(SAMPLES * SAMPLES)",
            "sum / float(SAMPLES * SAMPLES) + ((pixel.x + 331u * pixel.y) % 900u == 0u ? 0.5 : 0.0)"))
        scene = self.measure_with("--shaders", shaders)
        self.assertEqual(scene["converged"]["device"], "reference")  # not from who is wrong
        for p in self.of_shader(scene):
            self.assertAlmostEqual(p["arithmetic"]["bad_pixels"], 1 / 900, delta=4e-4)
            self.assertGreater(p["arithmetic"]["p999"], 0.49)
            self.assertGreater(p["p999"], 0.3)
            self.assertLess(p["arithmetic"]["p99"], 1e-3)
        self.assertRegex(" ".join(scene["findings"]), r"puts at most 0\.1\d* % of a picture's pixels off")

    def test_a_nan(self):
        shaders = self.shaders_with("whitted.comp", self.PIXELS, self.PIXELS.replace(
            "sum / float(SAMPLES * SAMPLES)",
            "((pixel.x + 331u * pixel.y) % 900u == 0u ? vec3(uintBitsToFloat(0x7fc00000u)) : sum / float(SAMPLES * SAMPLES))"))
        scene = self.measure_with("--shaders", shaders)
        self.assertEqual(scene["converged"]["device"], "reference")
        for p in self.of_shader(scene):
            self.assertGreater(p["nan"], 5)
            self.assertEqual((p["rmse"], p["efficiency"], p["pareto"]), (None, None, False))
        self.assertTrue(any("pixels with a NaN" in s for s in scene["findings"]))
        self.assertFalse([c for c in scene["curves"] if c["device"] != "reference"])
        for p in scene["points"]:
            if p["device"] == "reference":
                self.assertEqual(p["nan"], 0)

    # Right in all pictures that are measured, wrong in the converged one: the reference must notice.
    def test_errors_at_many_samples_only(self):
        for wrong in ("vec3(0.02)", "vec3(pixel.x == 10u && pixel.y == 9u ? uintBitsToFloat(0x7fc00000u) : 0.0)"):
            with self.subTest(wrong):
                shutil.rmtree(self.folder / "shaders", ignore_errors=True)
                shaders = self.shaders_with("whitted.comp", self.PIXELS, self.PIXELS.replace(
                    "sum / float", f"(SAMPLES > 3 ? {wrong} : vec3(0)) + sum / float"))
                scene = self.measure_with("--shaders", shaders)
                self.assertEqual(scene["converged"]["device"], "reference")
                self.assertTrue(scene["converged"]["converged"])
                for p in scene["points"]:
                    self.assertEqual(p["nan"], 0)
                    self.assertLess(abs(p["mean_signed"]), 2e-3, p["name"])

    def test_a_bias(self):
        shaders = self.shaders_with("whitted.comp", self.PIXELS,
                                    self.PIXELS.replace("sum / float", "vec3(1e-3) + sum / float"))
        scene = self.measure_with("--shaders", shaders)
        self.assertEqual(scene["converged"]["device"], "reference")
        for p in self.of_shader(scene):
            self.assertAlmostEqual(p["arithmetic"]["mean_signed"], 1e-3, delta=2e-5)
            twin = point(scene, p["name"].replace(p["device"], "reference", 1))
            self.assertAlmostEqual(p["mean_signed"] - twin["mean_signed"], 1e-3, delta=2e-5)
        self.assertIn("a bias of at most +0.001,", " ".join(scene["findings"]))
