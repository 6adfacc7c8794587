"""turner render: pictures, files and options."""

import itertools
import json
import math
import shutil
import time

from support.command import SMALL, TINY, Command
from support.pictures import Exr, float32, png_size
from support.scene_texts import NFF, SPHERE
from support.settings import SCENES


class Render(Command):
    def test_without_o_writes_the_scenes_name_with_exr_here(self):
        self.write("there/my.scene.json", SPHERE)
        run = self.do("render", "there/my.scene.json")
        self.assertEqual(self.files(), ["my.scene.exr", "there/my.scene.json"], run)
        self.assertEqual(Exr(self.path("my.scene.exr")).display, (0, 0, 63, 47))

    def test_names_with_spaces_and_umlauts_are_names(self):
        self.write("Bild ü 1.json", SPHERE)
        self.do("render", "Bild ü 1.json", "--backend", "reference", "-o", "ä ö.exr")
        self.do("render", "Bild ü 1.json", "--backend", "reference")
        self.assertEqual(self.files(), sorted(["Bild ü 1.exr", "Bild ü 1.json", "ä ö.exr"]))

    def test_says_which_device_it_chose(self):
        device = json.loads(self.do("devices", "--json").out)[0]["name"]
        run = self.do("render", self.write("scene.json", SPHERE), *TINY, "-o", "a.exr")
        if len(json.loads(self.do("devices", "--json").out)) == 1:
            self.assertIn(device, run.out)
        self.assertIn("device: ", run.out)

    def test_o_may_repeat_and_each_ending_has_its_format(self):
        scene = self.write("scene.json", SPHERE)
        self.do("render", scene, "-o", "a.exr", "-o", "b.png", "-o", "C.EXR")
        self.assertEqual(self.files(), ["C.EXR", "a.exr", "b.png", "scene.json"])
        self.assertEqual(self.path("a.exr").read_bytes(), self.path("C.EXR").read_bytes())
        self.assertEqual(png_size(self.path("b.png")), (64, 48))

    def test_o_may_stand_before_and_behind_the_scene(self):
        scene = self.write("scene.json", SPHERE)
        reference = ["--backend", "reference", "--quiet"]
        self.do("render", *reference, "-o", "a.exr", scene)
        self.do("render", *reference, "-o", "b.exr", scene, "-o", "c.png")
        self.do("render", *reference, "--output", "d.exr", scene, "--output=e.png", *TINY)
        self.assertEqual(self.files(), ["a.exr", "b.exr", "c.png", "d.exr", "e.png", "scene.json"])

    def test_one_o_takes_one_file(self):
        self.refuse("render", self.write("scene.json", SPHERE), *TINY, "-o", "a.exr", "b.exr", says="b.exr")

    def test_an_existing_file_is_replaced_whole(self):
        scene = self.write("scene.json", SPHERE)
        self.write("a.exr", b"x" * 1_000_000)
        self.do("render", scene, "-o", "a.exr", "--backend", "reference")
        self.assertEqual(Exr(self.path("a.exr")).width, 64)
        self.assertEqual(self.files(), ["a.exr", "scene.json"])

    def test_files_depend_on_scene_options_and_device_alone(self):
        scene = SCENES / "spheres.json"
        self.do("render", scene, *SMALL, "-o", "first.exr", "-o", "first.png")
        # Elsewhere, another time, otherwise talkative, with figures, without validation.
        self.write("elsewhere/spheres.json", scene.read_bytes())
        time.sleep(1.1)
        options = ["--quiet", "--stats", "stats.json", "-o", "second.exr", "-o", "second.png"]
        self.do("render", "elsewhere/spheres.json", *SMALL, *options, env={"TURNER_VALIDATION": "0"})
        for kind in ("exr", "png"):
            first, second = (self.path(f"{name}.{kind}").read_bytes() for name in ("first", "second"))
            self.assertEqual(first, second, kind)

    def test_files_of_the_reference_repeat_too(self):
        for name in ("first", "second"):
            self.do("render", SCENES / "spheres.json", *SMALL, "--backend", "reference", "-o", f"{name}.exr")
        self.assertEqual(self.path("first.exr").read_bytes(), self.path("second.exr").read_bytes())

    def test_tiles_and_work_groups_never_change_a_byte(self):
        whole = self.picture(SCENES / "spheres.json", *SMALL).bytes
        for cut in (["--tile", "8", "--work-group", "32"], ["--tile", "64", "--work-group", "8"]):
            self.assertEqual(self.picture(SCENES / "spheres.json", *SMALL, *cut).bytes, whole, cut)
        for cut in (["--tile", "8"], ["--work-group", "128"], ["--work-group", "256"]):
            self.assertEqual(self.picture(SCENES / "spheres.json", *SMALL, *cut).bytes, whole, cut)

    def test_a_crop_is_the_part_of_the_full_picture_bit_for_bit(self):
        window = (13, 7, 50, 41)
        crop = ["--crop", ",".join(map(str, window))]
        for options in (["--samples", "2", "--sampler", "jitter", "--seed", "3"], ["--backend", "reference"]):
            with self.subTest(options):
                whole = self.picture(SCENES / "spheres.json", *SMALL, *options)
                part = self.picture(SCENES / "spheres.json", *SMALL, *options, *crop)
                self.assertEqual(part.display, (0, 0, 63, 47))
                self.assertEqual(part.data, (13, 7, 49, 40))
                self.assertEqual(part.bits(), whole.part(*window))
                self.assertNotEqual(part.bits(), whole.part(12, 7, 49, 41))

    def test_quiet_prints_nothing(self):
        scene = self.write("no_lights.json", "{}")
        run = self.do("render", scene, *TINY, "--quiet", "--stats", "stats.json")
        self.assertEqual(run.out + run.err, "", run)
        run = self.do("render", scene, *TINY, "--quiet", "--backend", "reference")
        self.assertEqual(run.out + run.err, "", run)

    def test_a_scene_without_lights_is_black_and_says_so(self):
        scene = json.loads(SPHERE)
        del scene["lights"]
        run = self.do("render", self.write("dark.json", json.dumps(scene)))
        self.assertRegex(run.out, r"no lights")
        self.assertNotRegex(run.out, r"no objects|no camera")
        # Clay reflects a fifth of the background; all the rest of it is black.
        pixel = Exr(self.path("dark.exr")).pixel(32, 22)
        for value, expected in zip(pixel, (0.05, 0.1, 0.2)):
            self.assertAlmostEqual(value, expected, 5)

    def test_a_scene_without_objects_is_its_background_and_says_so(self):
        scene = json.loads(SPHERE)
        del scene["spheres"]
        for backend in ("shader", "reference"):
            run = self.do("render", self.write("bare.json", json.dumps(scene)), "--backend", backend)
            self.assertRegex(run.out, r"no objects")
            self.assertNotRegex(run.out, r"no lights|no camera")
            picture = Exr(self.path("bare.exr"))
            self.assertEqual({picture.pixel(x, y) for x in range(64) for y in range(48)}, {(0.25, 0.5, 1)})

    def test_a_scene_without_camera_shows_its_objects_and_says_so(self):
        scene = json.loads(SPHERE)
        del scene["camera"]
        run = self.do("render", self.write("unseen.json", json.dumps(scene)))
        self.assertRegex(run.out, r"no camera")
        self.assertNotRegex(run.out, r"no lights|no objects")
        picture = Exr(self.path("unseen.exr"))
        self.assertNotEqual(picture.pixel(32, 24), (0.25, 0.5, 1))
        self.assertEqual(picture.pixel(0, 0), (0.25, 0.5, 1))

    def test_the_empty_scene_renders(self):
        run = self.do("render", self.write("empty.json", "{}"), "--width", "1", "--height", "1")
        for what in ("no lights", "no objects", "no camera"):
            self.assertIn(what, run.out)
        self.assertEqual(Exr(self.path("empty.exr")).pixel(0, 0), (0, 0, 0))

    def test_the_reference_renders_the_same_picture(self):
        shader = self.picture(SCENES / "spheres.json", *SMALL, "--backend", "shader").values()
        reference = self.picture(SCENES / "spheres.json", *SMALL, "--backend", "reference").values()
        self.assertNotEqual(shader, reference)  # float32 is not double
        square = sum((a - b) ** 2 for a, b in zip(shader, reference)) / len(shader)
        self.assertLess(math.sqrt(square), 1e-3)

    def test_geometry_tells_the_reference_which_scene_to_trace(self):
        scene = json.loads(SPHERE)
        # Far from the eye's unit the rounding to float32 shows, and is small.
        scene["spheres"][0].update(center=[0.1 + 1e6, 0.2, 0])
        scene["camera"].update(eye=[1e6 + 0.7, 0.3, 5], target=[1e6, 0, 0])
        name = self.write("far.json", json.dumps(scene))
        reference = ["--backend", "reference", "--geometry"]
        default = self.picture(name, "--backend", "reference")
        exact = self.picture(name, *reference, "exact")
        rounded = self.picture(name, *reference, "rounded")
        self.assertEqual(default.bits(), exact.bits())
        self.assertNotEqual(exact.bits(), rounded.bits())
        worst = max(abs(a - b) for a, b in zip(exact.values(), rounded.values()))
        self.assertLess(worst, 0.5)

    def test_the_seed_moves_jittered_samples_and_only_those(self):
        scene = self.write("scene.json", SPHERE)
        jitter = ["--sampler", "jitter", "--seed"]
        for backend in (["--backend", "shader"], ["--backend", "reference"]):
            one = self.picture(scene, *backend, *jitter, "1")
            self.assertEqual(self.picture(scene, *backend, *jitter, "1").bytes, one.bytes)
            self.assertNotEqual(self.picture(scene, *backend, *jitter, "2").bits(), one.bits())
        default = self.picture(scene, *backend, "--sampler", "jitter")
        self.assertEqual(default.bits(), self.picture(scene, *backend, *jitter, "0").bits())
        grid = self.picture(scene, *backend)
        self.assertNotEqual(grid.bits(), one.bits())
        seeded = self.picture(scene, *backend, "--sampler", "grid", "--seed", "4294967295")
        self.assertEqual(seeded.bits(), grid.bits())

    def test_min_weight_drops_faint_rays(self):
        reference = [SCENES / "spheres.json", *SMALL, "--backend", "reference"]
        default = self.stats(*reference)["rays"]
        counts = {w: self.stats(*reference, "--min-weight", w)["rays"] for w in ("0", "0.1", "0.5", "1")}
        self.assertEqual(counts["0"], default)
        order = [counts[w]["reflected"] + counts[w]["refracted"] for w in ("0", "0.1", "0.5", "1")]
        self.assertEqual(order, sorted(order, reverse=True))
        self.assertEqual(len(set(order)), 4)
        self.assertEqual(order[-1], 0)  # nothing in the scene mirrors all light
        self.assertEqual(counts["1"]["eye"], 64 * 48)
        shader = self.stats(SCENES / "spheres.json", *SMALL, "--min-weight", "0.5")["rays"]
        self.assertAlmostEqual(shader["reflected"] / counts["0.5"]["reflected"], 1, delta=0.005)

    def test_depth_counts_the_levels_of_the_tree(self):
        scene = SCENES / "spheres.json"
        for backend in ("shader", "reference"):
            eye_only = self.stats(scene, *SMALL, "--backend", backend, "--depth", "1")["rays"]
            self.assertEqual((eye_only["reflected"], eye_only["refracted"]), (0, 0), backend)
            two = self.stats(scene, *SMALL, "--backend", backend, "--depth", "2")["rays"]
            self.assertGreater(two["reflected"], 0, backend)
            # On the second level there is at most one ray of each kind for each eye ray.
            self.assertLessEqual(max(two["reflected"], two["refracted"]), two["eye"], backend)
        self.do("render", scene, *TINY, "--depth", "64", "-o", "deep.exr")

    def test_width_and_height_override_the_scenes(self):
        scene = self.write("scene.json", SPHERE)
        for options, size in (
            ([], (64, 48)),
            (["--width", "33"], (33, 48)),
            (["--height", "17"], (64, 17)),
            (["--width=1", "--height=1"], (1, 1)),
        ):
            picture = self.picture(scene, *options, "--backend", "reference")
            self.assertEqual((picture.width, picture.height), size, options)
        picture = self.picture(scene, "--width", "33", "--height", "17")
        self.assertEqual((picture.width, picture.height), (33, 17))

    def test_without_sizes_a_picture_is_512_by_512(self):
        picture = self.picture(self.write("empty.json", "{}"), "--backend", "reference")
        self.assertEqual(picture.display, (0, 0, 511, 511))

    def test_four_samples_are_the_mean_of_a_picture_twice_as_large(self):
        scene = [SCENES / "spheres.json", "--backend", "reference"]
        fine = self.picture(*scene, "--width", "128", "--height", "96")
        coarse = self.picture(*scene, *SMALL, "--samples", "2")
        for y, x in itertools.product(range(48), range(64)):
            four = [fine.pixel(2 * x + i, 2 * y + j) for i in (0, 1) for j in (0, 1)]
            for c in range(3):
                self.assertAlmostEqual(coarse.pixel(x, y)[c], sum(p[c] for p in four) / 4, delta=2e-6)
        shader = self.picture(SCENES / "spheres.json", *SMALL, "--samples", "2").values()
        far = sum(abs(a - b) > 1e-3 for a, b in zip(shader, coarse.values()))
        self.assertLess(far / len(shader), 0.01)

    def test_256_samples_a_side_are_taken(self):
        one = [self.write("scene.json", SPHERE), "--width", "1", "--height", "1", "--samples", "256"]
        shader, reference = (self.picture(*one, "--backend", backend) for backend in ("shader", "reference"))
        for a, b in zip(shader.values(), reference.values()):
            self.assertAlmostEqual(a, b, delta=1e-3)
        self.assertEqual(self.stats(*one, "--backend", "reference")["rays"]["eye"], 256 * 256)

    def test_an_nff_scene_renders(self):
        run = self.do("render", self.write("ball.nff", NFF))
        self.assertNotIn("note:", run.out)
        picture = Exr(self.path("ball.exr"))
        self.assertEqual((picture.width, picture.height), (64, 48))
        for value, expected in zip(picture.pixel(0, 0), (0.1, 0.2, 0.3)):
            self.assertEqual(value, float32(expected))
        figures = self.figures("ball.nff")
        self.assertLess(figures["rmse"], 1e-3)

    def test_a_mesh_renders_from_another_folder(self):
        # The mesh lies beside the scene, not beside the caller.
        stats = self.stats(SCENES / "spot.json", *SMALL)
        self.assertEqual(stats["primitives"], {"spheres": 1, "cones": 0, "triangles": 5858})

    def test_turners_own_scenes_are_found_from_everywhere(self):
        self.do("render", "scenes/spheres.json", *TINY, "--backend", "reference")
        self.assertEqual(self.files(), ["spheres.exr"])

    def test_a_scene_that_is_here_comes_before_turners_own(self):
        self.write("scenes/spheres.json", "{}")
        run = self.do("render", "scenes/spheres.json", *TINY, "--backend", "reference")
        self.assertIn("no objects", run.out)

    def test_shaders_may_be_elsewhere(self):
        shutil.copytree(SCENES.parent / "shaders", self.path("kernel"))
        scene = self.write("scene.json", SPHERE)
        self.assertEqual(self.picture(scene, "--shaders", "kernel").bytes, self.picture(scene).bytes)

    def test_a_part_of_a_gigantic_picture_renders(self):
        size = ["--width", "65536", "--height", "65536", "--crop", "32768,32768,32776,32776"]
        for backend in ("shader", "reference"):
            picture = self.picture(SCENES / "spheres.json", *size, "--backend", backend)
            self.assertEqual(picture.display, (0, 0, 65535, 65535))
            self.assertEqual(picture.data, (32768, 32768, 32775, 32775))

    def test_a_picture_one_pixel_high_renders(self):
        picture = self.picture(self.write("scene.json", SPHERE), "--width", "65536", "--height", "1")
        self.assertEqual(picture.data, (0, 0, 65535, 0))
