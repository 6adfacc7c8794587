"""How the error falls with the samples."""

import json
import statistics
import unittest

from support.reports import InFolder, curve
from support.settings import BUILD, PROGRAM, ROOT

RESULTS = BUILD / "tests/slopes"  # of scenes that have passed


class Slopes(InFolder):
    # Crops of 128 x 128 pixels in which an RMSE of 0.01 takes from 2 to 30 samples; the most samples that are measured.
    SCENES = {
        "spheres": ("scenes/spheres.json", 240, "56,3,184,131", 6),
        "glass": ("scenes/glass.json", 160, "16,16,144,144", 6),
        "balls": ("scenes/spd/balls.nff", 512, "192,192,320,320", 8),
        "gears": ("scenes/spd/gears.nff", 512, "192,192,320,320", 6),
        "cliff_hanger": ("scenes/cliff_hanger.json", 240, "56,3,184,131", 6),
    }

    def sweep(self, file, width, crop, most, *more, out="out"):
        return self.measure(ROOT / file, "--width", str(width), "--crop", crop, "--max-samples", str(most), "--repeats", "1",
                            "--no-cut-offs", *more, out=out)

    def check(self, name):
        file, width, crop, most = self.SCENES[name]
        result = RESULTS / f"{name}.json"
        result.unlink(missing_ok=True)
        report = self.sweep(file, width, crop, most, out=name)
        scene = report["scenes"][0]
        self.assertTrue(scene["converged"]["converged"])
        jitter, sobol = curve(scene, "jitter"), curve(scene, "sobol")
        saved = sobol["reaches"][0]["samples"] / jitter["reaches"][0]["samples"]
        print(f"{name}: slopes jitter {jitter['slope']:.3f}, sobol {sobol['slope']:.3f}; RMSE 0.01 at "
              f"{jitter['reaches'][0]['samples']:.2f} and {sobol['reaches'][0]['samples']:.2f} samples, {saved:.2f}")
        self.assertAlmostEqual(jitter["slope"], -0.75, delta=0.07)
        self.assertLessEqual(sobol["slope"], jitter["slope"] + 0.01)
        for c in (jitter, sobol):
            self.assertFalse(c["reaches"][0]["extrapolated"])
            self.assertGreater(c["reaches"][0]["samples"], 1)
        RESULTS.mkdir(parents=True, exist_ok=True)
        result.write_text(json.dumps({"samples of sobol beside jitter": saved}))

    def test_spheres(self):
        self.check("spheres")

    def test_glass(self):
        self.check("glass")

    def test_balls(self):
        self.check("balls")

    def test_gears(self):
        self.check("gears")

    def test_cliff_hanger(self):
        self.check("cliff_hanger")

    def test_random_samples_are_told_from_stratified_ones(self):
        shaders = self.shaders_with("sampling.glsl", "  if (SAMPLER == kSobol) {",
                                    "  if (SAMPLER == kJitter) return offset;\n  if (SAMPLER == kSobol) {")
        file, width, crop, most = self.SCENES["spheres"]
        report = self.sweep(file, width, crop, most, "--shaders", shaders)
        slope = curve(report["scenes"][0], "jitter")["slope"]
        print(f"random samples: slope {slope:.3f}")
        self.assertAlmostEqual(slope, -0.5, delta=0.07)


class WhatSobolSaves(unittest.TestCase):
    """After the tests above, whose results it reads."""

    def test_over_all_scenes(self):
        saved = []
        for name in Slopes.SCENES:
            result = RESULTS / f"{name}.json"
            self.assertTrue(result.exists(), f"report.slopes.Slopes.test_{name} has not passed")
            self.assertGreater(result.stat().st_mtime, PROGRAM.stat().st_mtime, f"{result} is of an older program")
            saved.append(json.loads(result.read_text())["samples of sobol beside jitter"])
        mean = statistics.geometric_mean(saved)
        print(f"sobol needs {mean:.3f} of the samples of jitter")
        self.assertLessEqual(mean, 0.8)
