"""Runs the benchmark on small pictures: the tracers must agree, and the JSON must hold what was measured."""

import json
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

from support.settings import BENCH, SCENES


def run(*arguments):
    return subprocess.run([str(a) for a in (BENCH, *arguments)], capture_output=True, text=True, timeout=600)


def check_scene(scene, kinds):
    rays, peer = scene["rays"], scene["embree_rays"]
    assert rays["eye"] == peer["eye"] == 64 * 64, scene
    for kind in kinds:
        assert rays[kind] > 0 and peer[kind] > 0, (kind, scene)
    assert 0 <= scene["bad_pixels"] <= 0.03 and scene["disagreements"] == [], scene
    for side in ("turner", "embree"):
        seconds, = scene[f"{side}_seconds"]
        speed = sum(rays.values() if side == "turner" else peer.values()) / seconds / 1e6
        assert math.isclose(scene[f"{side}_mrays_per_second"]["median"], speed, rel_tol=1e-9), scene
    ratio = scene["ratio"]
    assert ratio["min"] == ratio["median"] == ratio["max"] > 0, scene
    for field in ("build_seconds", "embree_commit_seconds", "bytes_per_primitive", "embree_bytes_per_primitive"):
        assert scene[field] > 0, field
    for kind in ("eye", "reflected", "refracted", "shadow"):
        assert set(scene["work_per_ray"][kind]) == {"nodes", "primitives"}, scene
    assert "roofline_share" in scene


class Bench(unittest.TestCase):
    def test_scenes_are_measured_and_the_tracers_agree(self):
        with tempfile.TemporaryDirectory() as folder:
            written = os.path.join(folder, "bench.json")
            done = run(SCENES / "spheres.json", "bumpy-1000", "--width", 64, "--height", 64,
                       "--runs", 1, "--povray", "--json", written)
            assert done.returncode == 0, done.stdout + done.stderr
            for text in ("| spheres.json |", "| bumpy-1000 |", "geometric mean", "not an NFF scene"):
                assert text in done.stdout, (text, done.stdout)
            with open(written, encoding="utf-8") as file:
                result = json.load(file)
            for field in ("device", "driver", "cpu", "embree"):
                assert result[field], field
            spheres, bumpy = result["scenes"]
            check_scene(spheres, ("reflected", "refracted", "shadow"))
            check_scene(bumpy, ("reflected", "shadow"))
            assert bumpy["triangles"] == 962 and bumpy["spheres"] == 0
            ratios = [scene["ratio"]["median"] for scene in (spheres, bumpy)]
            assert math.isclose(result["geometric_mean"], math.sqrt(ratios[0] * ratios[1]), rel_tol=1e-9)
            assert result["minimum"] == min(ratios)

    def test_a_mesh_is_written_and_measured(self):
        with tempfile.TemporaryDirectory() as folder:
            # The mesh of bumpy-1000 as a file, which is a scene of its own.
            mesh = os.path.join(folder, "bumpy.obj")
            done = run("--write-obj", mesh, "--triangles", 1000)
            assert done.returncode == 0, done.stderr
            lines = pathlib.Path(mesh).read_text(encoding="utf-8").splitlines()
            assert sum(line.startswith("f ") for line in lines) == 962
            done = run(mesh, "--width", 32, "--height", 32, "--runs", 1)
            assert done.returncode == 0 and "| bumpy.obj | 964 |" in done.stdout, done.stdout + done.stderr

    def test_wrong_input_is_refused(self):
        for wrong in (["no such scene"], ["spheres", "--runs", "0"], ["spheres", "--device", "no such device"],
                      ["spheres", "--json", "/no/such/folder/x.json"],
                      ["--price", "no such scene"], ["--price", "spheres", "--price-rays", "0"]):
            done = run(*wrong)
            assert done.returncode == 2 and done.stderr, (wrong, done)


class Price(unittest.TestCase):
    def test_parts_are_found_and_what_they_are_for_is_not_there_without_them(self):
        """Every part of the kernel that is replaced must still be found in it."""
        with tempfile.TemporaryDirectory() as folder:
            written = os.path.join(folder, "price.json")
            done = run("--price", SCENES / "glass.json", "--width", 32, "--height", 32, "--runs", 1,
                       "--price-rays", 20000, "--json", written)
            assert done.returncode == 0, done.stdout + done.stderr
            with open(written, encoding="utf-8") as file:
                switches = {switch["name"]: switch for switch in json.load(file)["switches"]}
            assert len(switches) == 11, switches.keys()
            for name, switch in switches.items():
                assert name in done.stdout, name
                # glass.json has neither spheres that the eye is near nor such that are far away, nor glass in glass.
                scene_names = [scene["scene"] for scene in switch["scenes"]]
                assert scene_names == ([] if name.startswith(("compensated", "solids")) else ["glass.json"]), switch
                for scene in switch["scenes"]:
                    assert scene["ratio"]["median"] > 0 and scene["rays"] > 32 * 32, scene
                    if name != "offset and exclusion":
                        assert abs(scene["rays_without"] / scene["rays"] - 1) < 0.05, scene
            for name in ("watertight edge test", "compensated spheres near the eye", "compensated spheres far away",
                         "start offset by its error bound", "offset and exclusion", "Snell's law with twice the digits",
                         "solids of glass in one another"):
                assert any(f["without"] > 10 * f["with"] for f in switches[name]["failures"]), switches[name]
