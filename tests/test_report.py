#!/usr/bin/env python3
"""Drives `turner report` as its users do: measures scenes, kills and resumes it, plants errors in copies of the shaders
and looks for them in the figures, opens the page in a browser.

    python3 test_report.py --program build/turner --root . --screens FOLDER [options of unittest]
"""

import argparse
import csv
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ROOT = SCREENS = None  # set by main()
TIMEOUT = 900

# Small and quick: a mirror and a glass ball are in it.
SMALL = ["--width", "48", "--max-samples", "3"]


def run(arguments, expected=0, **options):
    done = subprocess.run([str(PROGRAM), *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          timeout=TIMEOUT, **options)
    assert done.returncode == expected, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done


def no_constants(text):
    raise AssertionError(f"{text} in JSON")


def load(folder):
    return json.loads((folder / "report.json").read_text(), parse_constant=no_constants)


def point(scene, name):
    return next(p for p in scene["points"] if p["name"] == name)


def device(scene):
    return scene["devices"][0]["device"]


def curve(scene, sampler):
    return next(c for c in scene["curves"] if c["device"] == device(scene) and c["sampler"] == sampler)


class InFolder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="turner_report_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def measure(self, *arguments, out="out"):
        run(["report", *arguments, "-o", self.folder / out])
        return load(self.folder / out)

    # A copy of the shaders with a text in one of them replaced.
    def shaders_with(self, file, old, new):
        copy = self.folder / "shaders"
        shutil.copytree(ROOT / "shaders", copy)
        text = (copy / file).read_text()
        self.assertEqual(text.count(old), 1, f"'{old}' must stand once in {file}: the test must follow the shader")
        (copy / file).write_text(text.replace(old, new))
        return copy


class Report(InFolder):
    def test_figures_hold_together(self):
        scene_file = ROOT / "scenes/spheres.json"
        report = self.measure(scene_file, *SMALL, "--repeats", "2", "--exr")
        scene = report["scenes"][0]
        out = self.folder / "out"
        self.assertEqual(sorted(p.name for p in out.iterdir()), ["pictures", "report.csv", "report.html", "report.json"])
        self.assertEqual((scene["width"], scene["height"]), (48, 27))  # the scene's shape

        # Every sampler, depth and weight on every device.
        settings = {p["name"].split("-", 1)[1] for p in scene["points"] if p["device"] == "reference"}
        expected = {f"{s}-{n}x{n}" for s in ("grid", "jitter", "sobol") for n in (1, 2, 3)}
        expected |= {f"sobol-3x3-depth{d}" for d in range(1, scene["depth"])}
        expected |= {f"sobol-3x3-weight{w}" for w in ("0.3", "0.1", "0.03", "0.01")}
        self.assertEqual(settings, expected)
        self.assertEqual(len(scene["points"]), len(expected) * len(scene["devices"]))
        self.assertEqual([d["device"] for d in scene["devices"]][-1], "reference")

        # The converged picture is as good as it says.
        converged = scene["converged"]
        self.assertTrue(converged["converged"])
        least = min(p["rmse_of_seeds"][0] for p in scene["points"])
        self.assertLessEqual(converged["own_error"], 0.2501 * least)

        front = [p for p in scene["points"] if p["pareto"]]
        for p in scene["points"]:
            seconds, picture = p["seconds"], out / "pictures" / f"1-spheres-{p['name']}.exr"
            self.assertEqual(len(seconds["repeats"]), 2)
            self.assertAlmostEqual(seconds["median"], sum(seconds["repeats"]) / 2)
            self.assertAlmostEqual(p["rmse"], math.sqrt(sum(e * e for e in p["rmse_of_seeds"]) / 2))
            self.assertAlmostEqual(p["efficiency"] * p["rmse"] ** 2 * seconds["median"], 1)
            # Nothing beats what is on the front; something is as good as what is not.
            beaten = [q for q in front if q["seconds"]["median"] <= seconds["median"] and 0.99 * q["rmse"] <= p["rmse"]
                      and q is not p]
            self.assertEqual(bool(beaten), not p["pareto"], p["name"])
            # The picture is there, and its error is what compare says, less the converged picture's own.
            done = run(["compare", picture, out / "pictures/1-spheres-converged.exr", "--json"])
            rmse = json.loads(done.stdout)["rmse"]
            own = converged["own_error"]
            self.assertAlmostEqual(p["rmse_of_seeds"][0], math.sqrt(max(0, rmse * rmse - own * own)), places=6)
            if p["device"] == "reference":
                self.assertEqual((p["arithmetic"]["rmse"], p["quantisation"]["rmse"]), (0, 0))
            if "depth" not in p["name"] and "weight" not in p["name"]:
                self.assertEqual(p["cut_off"]["rmse"], 0)

        # Less depth loses more; the loss has one sign. (It may be nothing at the last levels.)
        losses = [point(scene, f"reference-sobol-3x3-depth{d}")["cut_off"] for d in range(1, scene["depth"])]
        self.assertEqual([x["rmse"] for x in losses], sorted((x["rmse"] for x in losses), reverse=True))
        self.assertGreater(losses[0]["rmse"], 0.01)
        self.assertTrue(all(x["mean_signed"] <= 0 for x in losses))
        weights = [point(scene, f"reference-sobol-3x3-weight{w}")["cut_off"]["rmse"] for w in ("0.3", "0.1", "0.03", "0.01")]
        self.assertEqual(weights, sorted(weights, reverse=True))

        with open(out / "report.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([r["command"] for r in rows], [p["command"] for p in scene["points"]])
        self.assertEqual([float(r["rmse"]) for r in rows], [p["rmse"] for p in scene["points"]])

    def test_commands_repeat_their_points(self):
        scene_file = ROOT / "scenes/glass.json"
        report = self.measure(scene_file, "--width", "40", "--max-samples", "2", "--repeats", "1", "--crop", "3,5,35,37",
                              "--exr")
        scene = report["scenes"][0]
        names = [f"{device(scene)}-sobol-2x2-depth3", f"{device(scene)}-jitter-2x2", "reference-sobol-2x2-weight0.03"]
        for name in names:
            command = point(scene, name)["command"].split()
            self.assertEqual(command[0], "turner")
            run(command[1:], cwd=self.folder)
            kept = self.folder / "out/pictures" / f"1-glass-{name}.exr"
            self.assertEqual((self.folder / f"glass-{name}.exr").read_bytes(), kept.read_bytes(), name)

    def test_a_scene_without_mirrors_or_errors(self):
        empty = self.folder / "nothing.json"
        empty.write_text('{ "width": 8, "height": 8, "background": [0.5, 0.5, 0.5] }')
        report = self.measure(empty, "--max-samples", "2", "--repeats", "1")
        scene = report["scenes"][0]
        self.assertEqual({p["rmse"] for p in scene["points"]}, {0})
        self.assertEqual({p["efficiency"] for p in scene["points"]}, {None})
        self.assertFalse([p for p in scene["points"] if "depth" in p["name"] or "weight" in p["name"]])
        self.assertIn("nothing to draw", (self.folder / "out/report.html").read_text())

    def test_two_scenes_of_one_name_stay_apart(self):
        for folder in ("a", "b"):
            (self.folder / folder).mkdir()
            shutil.copy(ROOT / "scenes/diffuse.json", self.folder / folder / "s.json")
        report = self.measure(self.folder / "a/s.json", self.folder / "b/s.json", "--width", "16", "--max-samples", "1",
                              "--repeats", "1")
        self.assertEqual(len(report["scenes"]), 2)
        self.assertEqual([s["scene"][-8:] for s in report["scenes"]], ["a/s.json", "b/s.json"])

    def test_names_that_are_hard(self):
        for name in ("-dash.json", "a 'b' \"c\".json", "</script><script>alert(1)</script>".replace("/", "\\") + ".json",
                     "x" * 200 + ".json", "\udcff.json"):
            with self.subTest(name):
                shutil.copy(ROOT / "scenes/diffuse.json", self.folder / name)
                run(["report", "--width", "8", "--max-samples", "1", "--repeats", "1", "-o", "out", "--", name],
                    cwd=self.folder)
                scene = load(self.folder / "out")["scenes"][0]
                if "\udcff" not in name:
                    command = point(scene, f"{device(scene)}-grid-1x1")["command"]
                    done = subprocess.run(["sh", "-c", command], cwd=self.folder, env={
                        **os.environ, "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}"}, stdout=subprocess.DEVNULL)
                    self.assertEqual(done.returncode, 0, command)
                page = (self.folder / "out/report.html").read_text()
                self.assertNotIn("<script>alert", page)

    def test_devices_of_one_name_are_told_apart(self):
        drivers = sorted(pathlib.Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
        self.assertTrue(drivers, "lavapipe is installed")
        copies = []
        for i in range(3):
            copies.append(self.folder / f"lvp_{i}.json")
            shutil.copy(drivers[0], copies[-1])
        environment = {key: value for key, value in os.environ.items() if key != "TURNER_DEVICE"}
        environment["VK_DRIVER_FILES"] = environment["VK_ICD_FILENAMES"] = ":".join(map(str, copies))
        run(["report", ROOT / "scenes/diffuse.json", "--width", "8", "--max-samples", "1", "--repeats", "1", "-o",
             self.folder / "out"], env=environment)
        scene = load(self.folder / "out")["scenes"][0]
        names = [d["device"] for d in scene["devices"]]
        self.assertEqual((len(names), len(set(names))), (4, 4))
        self.assertEqual(len({p["name"] for p in scene["points"]}), len(scene["points"]))
        commands = {p["command"].split(" -o ")[1].split(" ", 1)[1] for p in scene["points"]}
        self.assertEqual(len(commands), len(scene["points"]))

    def test_a_smooth_picture_does_not_take_for_ever(self):
        # Of one lit triangle the grid's error is of the last bits: nothing can be converged enough.
        smooth = self.folder / "smooth.json"
        smooth.write_text("""{ "camera": { "eye": [0, 0, 2], "target": [0, 0, 0] }, "width": 64, "height": 64,
          "lights": [ { "position": [1, 1, 3] } ], "materials": { "m": { "diffuse": [0.8, 0.8, 0.8] } },
          "triangles": [ { "vertices": [[-9, -9, 0], [9, -9, 0], [0, 20, 0]], "material": "m" } ] }""")
        scene = self.measure(smooth, "--width", "16", "--max-samples", "4", "--repeats", "1")["scenes"][0]
        if not scene["converged"]["converged"]:
            self.assertIn("CAUTION", scene["findings"][0])
            self.assertEqual(scene["converged"]["samples"], 2 * 24 * 24)

    def test_wrong_input_is_refused_and_nothing_written(self):
        out = self.folder / "out"
        scene = ROOT / "scenes/spheres.json"
        broken = self.folder / "broken.json"
        broken.write_text('{ "width": -1 }')
        (self.folder / "file").write_text("")
        for arguments, message in (
            ([], "SCENES"),
            ([self.folder / "none.json"], "none.json"),
            ([scene, broken], "broken.json:1:"),
            ([scene, "--crop", "0,0,9999,9999"], "--crop"),
            ([scene, "--max-samples", "0"], "--max-samples"),
            ([scene, "--quick", "--full"], "--full"),
            ([scene, "--device", "no such"], "no such"),
            ([scene, "--sampler", "jitter"], "--sampler"),
            ([scene, "--shaders", self.folder], "whitted.comp"),
        ):
            done = run(["report", *arguments, "-o", out], expected=2)
            self.assertIn(message, done.stderr)
            self.assertEqual(done.stderr.count("error: "), 1, done.stderr)
            self.assertFalse(out.exists())
        done = run(["report", scene, "-o", self.folder / "file"], expected=2)
        self.assertIn(str(self.folder / "file"), done.stderr)


class Interrupted(InFolder):
    ARGUMENTS = ["--width", "64", "--max-samples", "4", "--repeats", "3"]

    def start(self):
        process = subprocess.Popen([str(PROGRAM), "report", ROOT / "scenes/spheres.json", *self.ARGUMENTS, "-o",
                                    self.folder / "out"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        return process

    def journal(self):
        found = list((self.folder / "out/unfinished").glob("*/journal"))
        return found[0].read_text() if found else ""

    # Lets a report run until it has measured so much, then ends it.
    def interrupt_after(self, lines, how):
        process = self.start()
        before = time.monotonic()
        while self.journal().count("\n") < lines:
            self.assertIsNone(process.poll(), "it ended before it could be interrupted")
            self.assertLess(time.monotonic() - before, TIMEOUT)
            time.sleep(0.02)
        process.send_signal(how)
        output = process.communicate(timeout=60)
        return process.returncode, output

    def test_a_killed_report_goes_on_and_measures_nothing_twice(self):
        # Once in the first pass, once among the repeats.
        for lines in (9, 75):
            self.interrupt_after(lines, signal.SIGKILL)
        self.assertEqual([p.name for p in (self.folder / "out").iterdir()], ["unfinished"])
        measured = {}
        for line in self.journal().splitlines():
            if line.startswith("measured"):
                _, name, repeat, seconds, _ = line.split()
                measured[name, int(repeat)] = float(seconds)
        self.assertGreaterEqual(len(measured), 74)
        # A line that was cut short is measured again, and harms nothing.
        journal = next((self.folder / "out/unfinished").glob("*/journal"))
        journal.write_text(journal.read_text() + "measured 1-spheres-refer")

        done = run(["report", ROOT / "scenes/spheres.json", *self.ARGUMENTS, "-o", self.folder / "out"])
        self.assertIn(f"going on with {len(measured)} measurements", done.stdout)
        scene = load(self.folder / "out")["scenes"][0]
        for p in scene["points"]:
            self.assertEqual(len(p["seconds"]["repeats"]), 3, p["name"])
        # What was measured stands there with the times of then.
        checked = 0
        for (name, repeat), seconds in measured.items():
            name = name.removeprefix("1-spheres-")
            if name.startswith("rounded"):
                continue
            self.assertEqual(point(scene, name)["seconds"]["repeats"][repeat], seconds, name)
            checked += 1
        self.assertGreater(checked, 50)
        self.assertFalse((self.folder / "out/unfinished").exists())

    def test_ctrl_c_says_how_to_go_on(self):
        code, (_, error) = self.interrupt_after(5, signal.SIGINT)
        self.assertEqual(code, 130)
        self.assertRegex(error, r"interrupted after \d+ measurements; the same command goes on from there")
        self.assertFalse((self.folder / "out/report.html").exists())

    def test_two_at_once_are_refused(self):
        process = self.start()
        while self.journal().count("\n") < 2:
            self.assertIsNone(process.poll())
            time.sleep(0.02)
        done = run(["report", ROOT / "scenes/spheres.json", *self.ARGUMENTS, "-o", self.folder / "out"], expected=2)
        self.assertIn("another turner report", done.stderr)
        process.kill()
        process.communicate()


class Damaged(InFolder):
    ARGUMENTS = ["--width", "32", "--max-samples", "2", "--repeats", "1"]

    def test_pictures_that_are_lost_or_damaged_are_measured_again(self):
        scene = ROOT / "scenes/diffuse.json"
        process = subprocess.Popen([str(PROGRAM), "report", scene, *self.ARGUMENTS, "-o", self.folder / "out"],
                                   stdout=subprocess.DEVNULL)
        pictures = lambda: sorted((self.folder / "out/unfinished").glob("*/*.exr"))
        while len(pictures()) < 5:
            self.assertIsNone(process.poll())
            time.sleep(0.01)
        process.kill()
        process.wait()
        lost, cut, *_ = pictures()
        lost.unlink()
        os.truncate(cut, 100)
        report = self.measure(scene, *self.ARGUMENTS)
        self.assertEqual(len(report["scenes"][0]["points"]), 12)
        self.assertFalse((self.folder / "out/unfinished").exists())


class PlantedErrors(InFolder):
    PIXELS = "pixels[at] = packRow(sum / float(SAMPLES * SAMPLES), phase);"

    def measure_with(self, *shaders):
        report = self.measure(ROOT / "scenes/spheres.json", "--width", "160", "--max-samples", "2", "--repeats", "1",
                              *shaders)
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
                    if "depth" not in p["name"] and "weight" not in p["name"]:
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


class Slopes(InFolder):
    # Crops of 128 x 128 pixels in which an RMSE of 0.01 takes from 2 to 30 samples; the most samples that are measured.
    SCENES = {
        "spheres": ("scenes/spheres.json", 240, "56,3,184,131", 6),
        "glass": ("scenes/glass.json", 160, "16,16,144,144", 6),
        "balls": ("scenes/spd/balls.nff", 512, "192,192,320,320", 8),
        "gears": ("scenes/spd/gears.nff", 512, "192,192,320,320", 6),
        "cliff_hanger": ("scenes/cliff_hanger.json", 240, "56,3,184,131", 6),
    }

    def test_slopes_and_what_sobol_saves(self):
        logs = []
        for name, (file, width, crop, most) in self.SCENES.items():
            report = self.measure(ROOT / file, "--width", str(width), "--crop", crop, "--max-samples", str(most),
                                  "--repeats", "1", out=name)
            scene = report["scenes"][0]
            self.assertTrue(scene["converged"]["converged"], name)
            jitter, sobol = curve(scene, "jitter"), curve(scene, "sobol")
            saved = sobol["reaches"][0]["samples"] / jitter["reaches"][0]["samples"]
            print(f"{name}: slopes jitter {jitter['slope']:.3f}, sobol {sobol['slope']:.3f}; RMSE 0.01 at "
                  f"{jitter['reaches'][0]['samples']:.2f} and {sobol['reaches'][0]['samples']:.2f} samples, {saved:.2f}")
            self.assertAlmostEqual(jitter["slope"], -0.75, delta=0.07, msg=name)
            self.assertLessEqual(sobol["slope"], jitter["slope"] + 0.01, name)
            for c in (jitter, sobol):
                self.assertFalse(c["reaches"][0]["extrapolated"], name)
                self.assertGreater(c["reaches"][0]["samples"], 1, name)
            logs.append(math.log(saved))
        mean = math.exp(sum(logs) / len(logs))
        print(f"sobol needs {mean:.3f} of the samples of jitter")
        self.assertLessEqual(mean, 0.8)

    def test_random_samples_are_told_from_stratified_ones(self):
        shaders = self.shaders_with("camera.glsl", "  if (SAMPLER == kSobol) {",
                                    "  if (SAMPLER == kJitter) return offset;\n  if (SAMPLER == kSobol) {")
        file, width, crop, most = self.SCENES["spheres"]
        report = self.measure(ROOT / file, "--width", str(width), "--crop", crop, "--max-samples", str(most), "--repeats",
                              "1", "--shaders", shaders)
        slope = curve(report["scenes"][0], "jitter")["slope"]
        print(f"random samples: slope {slope:.3f}")
        self.assertAlmostEqual(slope, -0.5, delta=0.07)


class Page(unittest.TestCase):
    """The page in Chromium, by chromedriver."""

    @classmethod
    def setUpClass(cls):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="turner_report_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        run(["report", ROOT / "scenes/spheres.json", ROOT / "scenes/spot.json", "--width", "96", "--max-samples", "3",
             "--repeats", "2", "-o", cls.folder])
        # Alone: nothing beside it can be what makes it work.
        alone = cls.folder / "alone"
        alone.mkdir()
        shutil.move(cls.folder / "report.html", alone / "report.html")
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for argument in ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                         "--window-size=1200,1600", f"--user-data-dir={cls.folder / 'profile'}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        cls.addClassCleanup(cls.browser.quit)
        cls.address = (alone / "report.html").as_uri()

    def setUp(self):
        self.browser.get(self.address)
        self.scene = load(self.folder)["scenes"][0]
        self.section = self.find("section.scene")

    def tearDown(self):
        entries = self.browser.get_log("browser")
        self.assertEqual(entries, [], "the console is not empty")

    def find(self, selector, parent=None):
        return (parent or self.browser).find_element("css selector", selector)

    def find_all(self, selector, parent=None):
        return (parent or self.browser).find_elements("css selector", selector)

    def js(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def screenshot(self, name):
        SCREENS.mkdir(parents=True, exist_ok=True)
        self.browser.save_screenshot(str(SCREENS / f"{name}.png"))

    def show(self, element):
        self.js("arguments[0].scrollIntoView({block: 'center'})", element)

    def test_it_is_whole_and_loads_nothing(self):
        self.assertEqual(len(self.find_all("section.scene")), 2)
        loaded = self.js("return performance.getEntriesByType('resource').map(e => e.name)")
        self.assertEqual([name for name in loaded if not name.startswith("data:")], [])
        self.assertTrue(self.js("return [...document.images].every(i => i.complete && i.naturalWidth > 0)"))
        text = self.find("body").text
        for part in (self.scene["devices"][0]["name"], self.scene["devices"][0]["driver"], self.scene["findings"][0]):
            self.assertIn(part, text)
        for p in self.scene["points"]:
            self.assertIn(p["command"], text)
        self.screenshot("whole")

    def test_curves_are_drawn(self):
        charts = self.find_all("svg.chart", self.section)
        self.assertEqual(len(charts), 2)
        devices = len(self.scene["devices"])
        curves = self.find_all(".curve", charts[0])
        self.assertEqual(len(curves), 3 * devices)
        for line in curves:
            self.assertGreater(self.js("return arguments[0].getTotalLength()", line), 100)
        self.assertEqual(len({(c.get_attribute("stroke"), c.get_attribute("stroke-dasharray")) for c in curves}),
                         3 * devices)
        self.assertEqual({p.get_attribute("data-point") for p in self.find_all(".point", charts[0])},
                         {p["name"] for p in self.scene["points"]})
        self.assertEqual(len(self.find_all(".front", charts[0])), 1)
        # Where a point is drawn says its time and error: of two points the slower is to the right, the more wrong above.
        place = {}
        for element in self.find_all(".point", charts[0]):
            box = self.js("const b = arguments[0].lastElementChild.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]", element)
            place[element.get_attribute("data-point")] = box
        for a in self.scene["points"]:
            for b in self.scene["points"]:
                if a["seconds"]["median"] > 1.2 * b["seconds"]["median"]:
                    self.assertGreater(place[a["name"]][0], place[b["name"]][0])
                if a["rmse"] > 1.2 * b["rmse"]:
                    self.assertLess(place[a["name"]][1], place[b["name"]][1])

    def test_hovering_labels_a_point(self):
        from selenium.webdriver import ActionChains
        label = self.find("#label")
        self.assertFalse(label.is_displayed())
        chart = self.find("svg.chart", self.section)
        self.show(chart)
        name = f"{device(self.scene)}-sobol-3x3"
        mark = self.find(f".point[data-point='{name}']", chart)
        ActionChains(self.browser).move_to_element(mark).perform()
        self.assertTrue(label.is_displayed())
        self.assertIn("RMSE", label.text)
        self.screenshot("hover")
        ActionChains(self.browser).move_to_element(self.find("h1")).perform()
        self.assertFalse(label.is_displayed())
        # By keyboard too.
        self.js("arguments[0].focus()", mark)
        self.assertTrue(label.is_displayed())
        self.assertIn(f"{device(self.scene)}, sobol 3x3", label.text)
        self.assertIn(f"{point(self.scene, name)['rmse']:.3g}", label.text)

    def test_the_table_sorts(self):
        table = self.find("table.points", self.section)
        headers = [h.text for h in self.find_all("th", table)]
        for title, key in (("RMSE", lambda p: p["rmse"]), ("median time", lambda p: p["seconds"]["median"])):
            header = self.find_all("th", table)[headers.index(title)]
            self.show(header)
            expected = sorted(key(p) for p in self.scene["points"])
            for order in (expected, expected[::-1]):
                self.find("button", header).click()
                rows = self.js("return [...arguments[0].tBodies[0].rows].map(r => r.dataset.point)", table)
                self.assertEqual([key(point(self.scene, name)) for name in rows], order)
            self.assertEqual(header.get_attribute("aria-sort"), "descending")
        self.screenshot("sorted")
        # By words.
        self.find("button", self.find_all("th", table)[0]).click()
        rows = self.js("return [...arguments[0].tBodies[0].rows].map(r => r.cells[0].textContent)", table)
        self.assertEqual(len(rows), len(self.scene["points"]))
        self.assertLess(rows.index(f"{device(self.scene)}, grid 1x1"), rows.index("reference, grid 1x1"))

    def test_the_slider_divides_the_pictures(self):
        from selenium.webdriver import ActionChains
        compare = self.find(".compare", self.section)
        self.show(compare)
        right, slider = self.find("img.right", compare), self.find("input", compare)
        clip = lambda: self.js("return getComputedStyle(arguments[0]).clipPath", right)
        self.assertIn("50%", clip())
        width = compare.size["width"]
        ActionChains(self.browser).move_to_element(slider).click_and_hold().move_by_offset(int(width * 0.3), 0).release().perform()
        dragged = float(clip().rstrip(")").split()[-1].rstrip("%"))
        self.assertAlmostEqual(dragged, 80, delta=4)
        from selenium.webdriver.common.keys import Keys
        slider.send_keys(Keys.HOME)
        self.assertIn(" 0%", clip())
        self.screenshot("slider")

        # Another point, another pair of pictures.
        from selenium.webdriver.support.ui import Select
        left = self.find("img.left", compare)
        before = left.get_attribute("src"), right.get_attribute("src")
        which = Select(self.find("select.which", self.section))
        which.select_by_index(len(which.options) - 1)
        self.assertNotEqual(before, (left.get_attribute("src"), right.get_attribute("src")))
        Select(self.find("select.other", self.section)).select_by_value("converged")
        pictures = self.js("return JSON.parse(arguments[0].querySelector('script.pictures').textContent)", self.section)
        self.assertEqual(right.get_attribute("src"), pictures["converged"])

    def test_a_chosen_row_is_marked_in_the_charts(self):
        row = self.find("table.points tbody tr", self.section)
        self.show(row)
        self.find("td", row).click()
        name = row.get_attribute("data-point")
        self.assertEqual({e.get_attribute("data-point") for e in self.find_all(".chosen", self.section)}, {name})
        self.assertGreaterEqual(len(self.find_all(".point.chosen", self.section)), 1)

    def test_it_says_all_without_scripts(self):
        # The charts have titles, the pictures are there, the tables are full: in the source, before any script ran.
        source = (self.folder / "alone/report.html").read_text()
        body = source[:source.rindex("<script>")]
        self.assertEqual(body.count("<title>"), 1 + sum(body.count(c) for c in ("class='chart'", "class='point'")))
        self.assertIn("<img class='left'", body)
        self.assertIn("<td data-value=", body)


def main():
    global PROGRAM, ROOT, SCREENS
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--root", type=pathlib.Path, required=True)
    parser.add_argument("--screens", type=pathlib.Path, required=True)
    arguments, rest = parser.parse_known_args()
    PROGRAM, ROOT, SCREENS = (path.resolve() for path in (arguments.program, arguments.root, arguments.screens))
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)


main()
