"""turner compare: figures, bounds, parts of the error."""

import json
import math
import os
import re

from support.command import FAILED, LONG, SMALL, TINY, Command
from support.pictures import Exr, float32, write_exr
from support.scene_texts import SPHERE
from support.settings import SCENES


class Compare(Command):
    KEYS = "rmse rel_rmse mae max mean_signed p50 p99 p999 bad_pixels nan inf width height".split()

    def render_pair(self):
        """Two pictures that differ: without and with what mirrors and glasses show."""
        reference = ["--backend", "reference", "--quiet", *SMALL]
        self.do("render", SCENES / "spheres.json", *reference, "-o", "a.exr")
        self.do("render", SCENES / "spheres.json", *reference, "--depth", "1", "-o", "b.exr")

    def test_a_picture_equals_itself(self):
        self.render_pair()
        bounds = ["--max-rmse", "0", "--max-error", "0", "--max-bad-pixels", "0", "--threshold", "0"]
        zero = self.figures("a.exr", "a.exr", *bounds)
        self.assertEqual((zero.pop("width"), zero.pop("height")), (64, 48))
        self.assertEqual(set(zero.values()), {0})

    def test_json_is_exactly_the_promised_keys_and_nothing_else(self):
        self.render_pair()
        run = self.do("compare", "a.exr", "b.exr", "--json")
        self.assertEqual(list(json.loads(run.out)), self.KEYS)
        self.assertTrue(run.out.strip().startswith("{") and run.out.strip().endswith("}"), run)
        self.assertEqual(list(json.loads(self.do("compare", SCENES / "spheres.json", *TINY, "--json").out)), self.KEYS)

    def test_figures_are_those_of_a_minus_b(self):
        self.render_pair()
        figures = self.figures("a.exr", "b.exr", "--threshold", "0.05")
        a, b = Exr(self.path("a.exr")), Exr(self.path("b.exr"))
        pairs = list(zip(a.values(), b.values()))
        n = len(pairs)
        pixels = [
            max(abs(p - q) for p, q in zip(a.pixel(x, y), b.pixel(x, y))) for x in range(64) for y in range(48)
        ]
        expected = {
            "rmse": math.sqrt(math.fsum((p - q) ** 2 for p, q in pairs) / n),
            "rel_rmse": math.sqrt(math.fsum((p - q) ** 2 / (q * q + 0.01) for p, q in pairs) / n),
            "mae": math.fsum(abs(p - q) for p, q in pairs) / n,
            "max": max(pixels),
            "mean_signed": math.fsum(p - q for p, q in pairs) / n,
            "bad_pixels": sum(e > 0.05 for e in pixels) / len(pixels),
        }
        for name, value in expected.items():
            self.assertAlmostEqual(figures[name], value, delta=1e-12 + 1e-9 * abs(value), msg=name)
        for name, share in (("p50", 0.5), ("p99", 0.99), ("p999", 0.999)):
            below, at_most = (sum(t(e) for e in pixels) for t in (figures[name].__gt__, figures[name].__ge__))
            self.assertLessEqual(below, share * len(pixels) + 1, name)
            self.assertGreaterEqual(at_most, share * len(pixels) - 1, name)
        self.assertEqual((figures["nan"], figures["inf"], figures["width"], figures["height"]), (0, 0, 64, 48))
        # The other way round the sign turns.
        self.assertEqual(self.figures("b.exr", "a.exr")["mean_signed"], -figures["mean_signed"])

    def test_without_bounds_differences_are_no_failure(self):
        self.render_pair()
        run = self.do("compare", "a.exr", "b.exr")
        for word in ("rmse", "max", "bad pixels"):
            self.assertIn(word, run.out)

    def test_each_bound_holds_at_its_figure_and_fails_below(self):
        self.render_pair()
        threshold = ["--threshold", "0.05"]
        figures = self.figures("a.exr", "b.exr", *threshold)
        for option, name in (("--max-rmse", "rmse"), ("--max-error", "max"), ("--max-bad-pixels", "bad_pixels")):
            value = figures[name]
            self.assertGreater(value, 0)
            with self.subTest(option):
                self.assertEqual(self.figures("a.exr", "b.exr", *threshold, option, repr(value)), figures)
                below = repr(math.nextafter(value, 0))
                self.assertEqual(self.figures("a.exr", "b.exr", *threshold, option, below, code=FAILED), figures)
        # One broken bound is enough.
        self.figures("a.exr", "b.exr", "--max-rmse", "1000", "--max-error", "0", code=FAILED)

    def test_a_pixel_is_bad_above_the_threshold(self):
        write_exr(self.path("zero.exr"), 4, 1, [(0, 0, 0)] * 4)
        write_exr(self.path("steps.exr"), 4, 1, [(0, 0, 0), (0.25, 0, 0), (0, 0.5, 0), (0.5, 0.5, 0.75)])
        for threshold, share in (("0", 0.75), ("0.25", 0.5), ("0.5", 0.25), ("0.75", 0)):
            figures = self.figures("steps.exr", "zero.exr", "--threshold", threshold)
            self.assertEqual(figures["bad_pixels"], share, threshold)
        self.assertEqual(self.figures("steps.exr", "zero.exr")["max"], 0.75)

    def test_a_nan_fails_every_bound(self):
        write_exr(self.path("good.exr"), 3, 2, [(0.5, 0.5, 0.5)] * 6)
        for name, value in (("nan", math.nan), ("inf", math.inf)):
            write_exr(self.path("bad.exr"), 3, 2, [(0.5, 0.5, 0.5)] * 5 + [(0.5, value, 0.5)])
            for pair in (("good.exr", "bad.exr"), ("bad.exr", "good.exr"), ("bad.exr", "bad.exr")):
                figures = self.figures(*pair)
                self.assertEqual(figures[name], 1)
                for bound in ("--max-rmse", "--max-error", "--max-bad-pixels"):
                    self.figures(*pair, bound, "1e30", code=FAILED)

    def test_an_output_never_replaces_an_input(self):
        scene = self.write("scene.json", SPHERE)
        before = self.path(scene).read_bytes()
        self.refuse("render", scene, "--backend", "reference", "--stats", scene, says=["scene.json", "is an input"])
        os.symlink(scene, self.path("link.json"))
        self.refuse("render", scene, "--backend", "reference", "--stats", "link.json", says="is an input")
        self.assertEqual(self.path(scene).read_bytes(), before)
        self.render_pair()
        self.refuse("compare", "a.exr", "b.exr", "--error-image", "a.exr", says="is an input")

    def test_a_broken_bound_is_named(self):
        self.render_pair()
        run = self.run_turner("compare", "a.exr", "b.exr", "--max-error", "0", "--max-rmse", "1e9")
        self.assertEqual(run.code, FAILED, run)
        self.assertIn("--max-error", run.err)
        self.assertNotIn("--max-rmse", run.err)

    def test_the_error_image_is_the_absolute_difference(self):
        self.render_pair()
        self.do("compare", "a.exr", "b.exr", "--error-image", "error.exr")
        a, b, error = (Exr(self.path(name)).values() for name in ("a.exr", "b.exr", "error.exr"))
        self.assertEqual(error, [abs(float32(p - q)) for p, q in zip(a, b)])
        # It is there where it is needed most.
        self.figures("a.exr", "b.exr", "--max-error", "0", "--error-image", "broken.exr", code=FAILED)
        self.assertEqual(Exr(self.path("broken.exr")).values(), error)

    def test_unequal_windows_cannot_be_compared(self):
        scene = self.write("scene.json", SPHERE)
        reference = ["--backend", "reference", "--quiet"]
        self.do("render", scene, *reference, "-o", "whole.exr")
        self.do("render", scene, *reference, "--width", "65", "-o", "wider.exr")
        self.do("render", scene, *reference, "--crop", "0,0,32,48", "-o", "left.exr")
        self.do("render", scene, *reference, "--crop", "32,0,64,48", "-o", "right.exr")
        self.refuse("compare", "whole.exr", "wider.exr", says=["64", "65"])
        self.refuse("compare", "whole.exr", "left.exr", "--json")
        self.refuse("compare", "left.exr", "right.exr", "--error-image", "error.exr")

    REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
    ACES = (0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767)
    ODD = (0.7, 0.3, 0.2, 0.7, 0.1, 0.05, 0.3333, 0.3333)

    def test_numbers_of_other_colours_cannot_be_compared(self):
        grey = [(0.5, 0.5, 0.5)] * 4
        for name, primaries in (("none", None), ("bt709", self.REC_709), ("aces", self.ACES), ("odd", self.ODD)):
            write_exr(self.path(f"{name}.exr"), 2, 2, grey, chromaticities=primaries)
        # A file that states none means Rec. 709; the rounded numbers of another writer are the same ones.
        write_exr(self.path("near.exr"), 2, 2, grey, chromaticities=[x + 1e-4 for x in self.REC_709])
        for a, b in (("none", "bt709"), ("bt709", "near"), ("aces", "aces"), ("odd", "odd")):
            self.assertEqual(self.figures(f"{a}.exr", f"{b}.exr")["max"], 0)
        for a, b, says in (("bt709", "aces", ["Rec. 709", "ACES (AP0)"]), ("odd", "none", ["red (0.7, 0.3)", "Rec. 709"])):
            self.refuse("compare", f"{a}.exr", f"{b}.exr", "--json", says=[f"{a}.exr", f"{b}.exr", "convert", *says])
        # The error image has the colours of both.
        self.do("compare", "aces.exr", "aces.exr", "--error-image", "error.exr")
        self.assertEqual(self.figures("error.exr", "error.exr")["max"], 0)
        self.refuse("compare", "error.exr", "none.exr", says="ACES")

    def test_pixels_of_other_shapes_cannot_be_compared(self):
        write_exr(self.path("square.exr"), 2, 2, [(0, 0, 0)] * 4)
        write_exr(self.path("wide.exr"), 2, 2, [(0, 0, 0)] * 4, aspect=2)
        self.refuse("compare", "square.exr", "wide.exr", says=["square.exr", "wide.exr", "aspect ratio 1", "2"])
        self.assertEqual(self.figures("wide.exr", "wide.exr")["max"], 0)

    def test_layers_and_luminance_are_refused_with_what_to_do(self):
        write_exr(self.path("layer.exr"), 2, 2, [(0, 0, 0)] * 4, names=["diffuse.B", "diffuse.G", "diffuse.R"])
        write_exr(self.path("luminance.exr"), 2, 2, [(0, 0, 0)] * 4, names=["BY", "RY", "Y"])
        self.refuse("compare", "layer.exr", "layer.exr", says=["diffuse.R", "layer 'diffuse'"])
        self.refuse("compare", "luminance.exr", "luminance.exr", says=["found BY, RY, Y", "luminance"])

    def test_files_that_are_no_pictures_are_refused(self):
        self.render_pair()
        whole = self.path("a.exr").read_bytes()
        self.refuse("compare", "a.exr", "missing.exr", says="missing.exr")
        self.refuse("compare", "missing.exr", "a.exr", says="missing.exr")
        bad = {
            "empty.exr": b"",
            "text.exr": b"garbage\n",
            "magic.exr": whole[:4],
            "header.exr": whole[:200],
            "half.exr": whole[: len(whole) // 2],
            "short.exr": whole[:-1],
            "holes.exr": whole[:2000] + bytes(4000) + whole[6000:],
            "random.exr": bytes(i * i * 7 % 251 for i in range(5000)),
        }
        for name, content in bad.items():
            with self.subTest(name):
                self.refuse("compare", "a.exr", self.write(name, content), says=name)
        self.refuse("compare", ".", "a.exr")
        self.refuse("compare", "a.exr", SCENES / "spheres.json", says="spheres.json")

    def test_one_file_must_be_a_scene_and_three_are_too_many(self):
        self.render_pair()
        self.refuse("compare", "a.exr", says="a.exr")
        self.refuse("compare", "missing.json", says="missing.json")
        self.refuse("compare", "a.exr", "a.exr", "b.exr")
        self.refuse("compare")

    def test_a_scene_is_compared_within_bounds(self):
        scene = [SCENES / "spheres.json", *SMALL, "--samples", "2"]
        figures = self.figures(*scene, "--max-rmse", "0.001", "--max-bad-pixels", "0.01", "--threshold", "0.001")
        self.assertEqual((figures["width"], figures["height"]), (64, 48))
        self.assertGreater(figures["rmse"], 0)
        # The same run again gives the same figures, to the bit.
        value = figures["max"]
        self.assertEqual(self.figures(*scene, "--max-error", repr(value)), figures)
        self.figures(*scene, "--max-error", repr(math.nextafter(value, 0)), code=FAILED)

    def test_a_scene_is_compared_with_renders_options(self):
        options = ["--width", "32", "--height", "32", "--crop", "4,4,20,12", "--depth", "2", "--sampler", "jitter"]
        options += ["--seed", "5", "--samples", "2", "--geometry", "rounded", "--tile", "8", "--work-group", "32"]
        run = self.do("compare", SCENES / "spheres.json", *options, "--error-image", "error.exr")
        self.assertIn("device: ", run.out)
        self.assertEqual(Exr(self.path("error.exr")).data, (4, 4, 19, 11))

    OF_SAMPLING = ["own_error", "converged", "samples"]

    def test_three_errors_are_told_apart(self):
        scene = [SCENES / "spheres.json", *SMALL, "--samples", "2", "--decompose"]
        figures = self.figures(*scene)
        parts = figures["decompose"]
        self.assertEqual(list(figures), [*self.KEYS, "decompose"])
        self.assertEqual(list(parts), ["sampling", "arithmetic", "quantisation"])
        self.assertEqual(list(parts["sampling"]), [*self.KEYS, *self.OF_SAMPLING])
        for part in ("arithmetic", "quantisation"):
            self.assertEqual(list(parts[part]), self.KEYS)
        sampling = parts["sampling"]
        self.assertIs(sampling["converged"], True)
        self.assertLessEqual(sampling["own_error"], sampling["rmse"] / 4)
        self.assertEqual(sampling["samples"] % (2 * 8 * 8), 0)
        # Edges at 2 x 2 samples are rough; rounding is not.
        self.assertGreater(sampling["rmse"], 100 * parts["arithmetic"]["rmse"])
        self.assertGreater(parts["arithmetic"]["rmse"], 0)
        self.assertGreater(parts["quantisation"]["rmse"], 0)
        # Picture - exact = (picture - rounded) + (rounded - exact), whichever of the two is the usual figures' own.
        both = parts["arithmetic"]["mean_signed"] + parts["quantisation"]["mean_signed"]
        self.assertAlmostEqual(figures["mean_signed"], both, delta=1e-12)
        rounded = self.figures(*scene, "--geometry", "rounded")
        self.assertEqual(rounded["decompose"], parts)
        self.assertEqual({key: rounded[key] for key in self.KEYS}, parts["arithmetic"])

    def test_the_three_errors_keep_renders_options(self):
        crop = ["--width", "32", "--height", "32", "--crop", "4,4,20,12", "--depth", "2", "--min-weight", "0.3"]
        for sampler in (["grid"], ["jitter", "--seed", "4294967295"], ["sobol", "--samples", "6"]):
            parts = self.figures(SCENES / "glass.json", *crop, "--sampler", *sampler, "--decompose")["decompose"]
            for part in parts.values():
                self.assertEqual((part["width"], part["height"], part["nan"]), (16, 8, 0))
            # With another depth or weight on one side whole surfaces would differ.
            self.assertLess(parts["arithmetic"]["p50"], 1e-6)
            self.assertLess(parts["quantisation"]["p50"], 1e-6)
            self.assertLess(abs(parts["sampling"]["mean_signed"]), 0.05)

    def test_the_envelope_excuses_what_lies_at_edges(self):
        scene = [SCENES / "spheres.json", *SMALL, "--samples", "3", "--geometry", "rounded"]
        figures = self.figures(*scene, "--envelope")
        self.assertEqual(list(figures), [*self.KEYS, "envelope"])
        rule = figures["envelope"]
        self.assertEqual(list(rule), ["needed", "excused", "outside", "p99", "p999"])
        self.assertEqual(rule["needed"], self.figures(*scene, "--threshold", "1e-5")["bad_pixels"])
        self.assertEqual((rule["excused"], rule["outside"]), (rule["needed"], 0))
        self.assertLessEqual(rule["p999"], 1e-5)

    def test_the_three_errors_and_the_envelope_are_told_beside_the_usual_figures(self):
        lines = self.do("compare", SCENES / "spheres.json", *SMALL, "--decompose", "--envelope").out.splitlines()
        for word in ("rmse ", "bad pixels ", "sampling ", "arithmetic ", "quantisation ", "own error ", "envelope "):
            self.assertEqual(sum(line.startswith(word) for line in lines), 1, word)
        table = [line for line in lines if re.match("sampling|arithmetic|quantisation|  +rmse", line)]
        columns = [[match.start() for match in re.finditer(r"\S+", line)][-6:] for line in table]
        self.assertEqual(columns, [columns[0]] * 4)
        both = self.figures(SCENES / "spheres.json", *TINY, "--decompose", "--envelope")
        self.assertEqual(list(both), [*self.KEYS, "decompose", "envelope"])
        quiet = self.do("compare", SCENES / "spheres.json", *TINY, "--decompose", "--envelope", "--quiet")
        self.assertEqual(quiet.out + quiet.err, "")

    def test_two_pictures_have_no_three_errors_and_no_envelope(self):
        self.render_pair()
        for option in ("--decompose", "--envelope"):
            self.refuse("compare", "a.exr", "b.exr", option, says=[option, "scene"])
            self.refuse("compare", "a.exr", option, says="a.exr")

    def test_wrong_bounds_are_refused(self):
        self.render_pair()
        for option in ("--max-rmse", "--max-error", "--max-bad-pixels", "--threshold"):
            for value in ("-1", "x", "", "nan", "1e400"):
                with self.subTest(f"{option} {value}"):
                    self.refuse("compare", "a.exr", "b.exr", option, value, says=option)

    def test_an_error_image_that_cannot_be_written_is_refused_before_any_work(self):
        scene = [SCENES / "spheres.json", *LONG, "--error-image"]
        self.refuse("compare", *scene, "error.png", says=["error.png", ".exr"])
        self.refuse("compare", *scene, "nowhere/error.exr", says="nowhere")
        self.path("folder.exr").mkdir()
        self.refuse("compare", *scene, "folder.exr", says="folder.exr")
