"""turner render --stats: keys, and counts of rays."""

from support.command import SMALL, TINY, Command
from support.scene_texts import NFF
from support.settings import SCENES


class Statistics(Command):
    KEYS = {
        "device": {"name": str, "driver": str, "type": str},
        "primitives": {"spheres": int, "cones": int, "triangles": int},
        "rays": {"eye": int, "reflected": int, "refracted": int, "shadow": int},
        "seconds": {k: float for k in ("load", "build", "compile", "upload", "trace", "readback", "total")},
    }

    def test_stats_have_the_promised_keys_and_consistent_figures(self):
        for backend in ("shader", "reference"):
            with self.subTest(backend):
                stats = self.stats(SCENES / "spheres.json", *SMALL, "--samples", "2", "--backend", backend)
                self.check_stats(stats, eye=64 * 48 * 4)

    def check_stats(self, stats, eye):
        self.assertIsInstance(stats["scene"], str)
        self.assertIn("spheres", stats["scene"])
        self.assertIsInstance(stats["options"], dict)
        for group, kinds in self.KEYS.items():
            self.assertLessEqual(set(kinds), set(stats[group]), group)
            for key, kind in kinds.items():
                value = stats[group][key]
                self.assertIsInstance(value, (int, float) if kind is float else kind, f"{group}.{key}")
                self.assertNotIsInstance(value, bool)
                if kind is not str:
                    self.assertGreaterEqual(value, 0, f"{group}.{key}")
                else:
                    self.assertNotEqual(value, "", f"{group}.{key}")
        self.assertEqual(stats["primitives"], {"spheres": 10, "cones": 0, "triangles": 2})
        rays, seconds = stats["rays"], stats["seconds"]
        self.assertEqual(rays["eye"], eye)
        self.assertGreater(min(rays["reflected"], rays["refracted"], rays["shadow"]), 0)
        self.assertGreater(seconds["trace"], 0)
        parts = sum(seconds[k] for k in ("load", "build", "compile", "upload", "trace", "readback"))
        self.assertLessEqual(parts, seconds["total"] * 1.001)
        total = sum(rays[k] for k in ("eye", "reflected", "refracted", "shadow"))
        self.assertAlmostEqual(stats["mrays_per_second"] * seconds["trace"] * 1e6 / total, 1, 6)
        self.assertEqual(stats["options"]["samples"], 2)

    def test_the_reference_neither_compiles_nor_uploads_nor_reads_back(self):
        seconds = self.stats(SCENES / "spheres.json", *SMALL, "--backend", "reference")["seconds"]
        self.assertEqual([seconds[k] for k in ("compile", "upload", "readback")], [0, 0, 0])

    def test_the_shader_compiles_and_uploads_and_reads_back(self):
        seconds = self.stats(SCENES / "spheres.json", *SMALL)["seconds"]
        self.assertGreater(min(seconds[k] for k in ("compile", "upload", "readback")), 0)

    def test_shader_and_reference_count_the_same_rays(self):
        size = ["--width", "96", "--height", "54"]
        shader = self.stats(SCENES / "spheres.json", *size)["rays"]
        reference = self.stats(SCENES / "spheres.json", *size, "--backend", "reference")["rays"]
        self.assertEqual(shader["eye"], reference["eye"])
        for kind, count in reference.items():
            self.assertLessEqual(abs(shader[kind] - count), 0.0005 * count, f"{kind}: {shader[kind]} and {count}")

    def test_counts_do_not_depend_on_tiles_or_work_groups(self):
        scene = SCENES / "spheres.json"
        self.assertEqual(
            self.stats(scene, *SMALL, "--tile", "8", "--work-group", "32")["rays"], self.stats(scene, *SMALL)["rays"]
        )

    def test_a_crop_counts_its_own_rays(self):
        for backend in ("shader", "reference"):
            stats = self.stats(SCENES / "spheres.json", *SMALL, "--crop", "10,10,30,20", "--backend", backend)
            self.assertEqual(stats["rays"]["eye"], 200, backend)

    def test_cones_are_counted(self):
        cone = '{ "base": [0, 0, 0], "base_radius": 1, "apex": [0, 2, 0], "apex_radius": 0.5, "material": "m" }'
        scene = self.write("cones.json", '{ "materials": { "m": {} }, "cones": [' + ", ".join([cone] * 3) + "] }")
        inward = self.write("inward.nff", NFF + "c\n0 0 0 -1\n0 1 0 -1\n")
        for backend in ("shader", "reference"):
            stats = self.stats(scene, *TINY, "--backend", backend)
            self.assertEqual(stats["primitives"], {"spheres": 0, "cones": 3, "triangles": 0}, backend)
            stats = self.stats(inward, *TINY, "--backend", backend)
            self.assertEqual(stats["primitives"], {"spheres": 1, "cones": 1, "triangles": 2}, backend)

    def test_stats_are_there_for_an_empty_scene(self):
        stats = self.stats(self.write("empty.json", "{}"), *TINY)
        self.assertEqual(stats["primitives"], {"spheres": 0, "cones": 0, "triangles": 0})
        self.assertEqual(stats["rays"], {"eye": 64, "reflected": 0, "refracted": 0, "shadow": 0})
