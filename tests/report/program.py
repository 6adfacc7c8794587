"""turner report: figures that hold together, commands, names, refusals."""

import csv
import json
import math
import os
import pathlib
import shutil
import subprocess

from support.reports import SMALL, InFolder, device, load, point, run
from support.settings import PROGRAM, ROOT


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

    def test_what_is_told_does_not_end_a_report(self):
        # So long that progress is told.
        options = ["--width", "64", "--max-samples", "4", "--repeats", "2", "--no-cut-offs", "-o", self.folder / "out"]
        with open("/dev/full", "w") as full:
            command = [str(PROGRAM), "report", ROOT / "scenes/spheres.json", *options]
            done = subprocess.run(command, stdout=full, stderr=full)
        self.assertEqual(done.returncode, 0)
        self.assertEqual(len(load(self.folder / "out")["scenes"]), 1)

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
