"""Times of the watch, on a machine that does nothing else."""

import itertools
import shutil
import statistics
import sys
import time

from support.editors import write_and_rename, write_in_place
from support.session import MAIN, SHADE, Session
from support.settings import ROOT
from watch import harm, scenes, survival


class Timing(Session):
    """From the save to the moment at which the line that tells of the picture was read."""

    VALIDATION = "0"
    SIZE = ["--width", "512", "--height", "512"]
    EDITS = 5
    ROUNDS = 3  # others use the machine too: the median of one must keep to the bars

    def setUp(self):
        super().setUp()
        shutil.copy(ROOT / "scenes/spheres.json", self.path("scene.json"))

    def render_seconds(self):
        """Of `turner render`, with warm caches."""
        seconds = []
        for _ in range(self.EDITS):
            started = time.monotonic()
            self.turner("render", "scene.json", *self.SIZE, "--shaders", "kernel", "-o", "alone.exr", "--quiet")
            seconds.append(time.monotonic() - started)
        return statistics.median(seconds)

    def measure(self, save):
        """Medians of the seconds to the coarse picture, to the full one, and of its trace."""
        coarse, full, trace = [], [], []
        with self.watch(*self.SIZE, outputs=["out.exr"]) as w:
            w.picture()
            w.figures()
            w.wait("reference")
            for i in range(self.EDITS):
                before = self.path("out.exr").stat().st_mtime_ns
                started = time.monotonic()
                save(i)
                event = w.picture()
                self.assertNotEqual(self.path("out.exr").stat().st_mtime_ns, before)
                trace.append(w.figures()["seconds"]["trace"])
                # Where both are ready at once there is no coarse one.
                coarse.append(w.wait("coarse", "picture", version=w.version)["at"] - started)
                full.append(event["at"] - started)
        return statistics.median(coarse), statistics.median(full), statistics.median(trace)

    def check(self, what, save, to_coarse, beyond_render):
        for _ in range(self.ROUNDS):
            coarse, full, trace = self.measure(save)
            render = self.render_seconds()
            print(
                f"\n{what}: coarse picture after {coarse:.3f} s (at most {to_coarse:g}), full one after {full:.3f} s: "
                f"{full - trace:.3f} s beyond its trace, {full - render:.3f} s beyond turner render (at most {beyond_render:g})",
                file=sys.stderr,
            )
            if coarse <= to_coarse and full - render <= beyond_render:
                return
        self.fail("too slow in every round")

    def test_an_edited_shader(self):
        text = self.source("shade.glsl").read_text()
        factors = itertools.count(1)

        def save(_):
            self.save("shade.glsl", text.replace(SHADE, SHADE.replace("E", f"0.{next(factors):03} * E", 1)))

        self.check("a shader", save, 1.5, 1.5)

    def test_an_edited_scene(self):
        text = self.path("scene.json").read_text()
        places = itertools.count(1)

        def save(_):
            write_and_rename(self.path("scene.json"), text.replace("[-6, 9, 7]", f"[-6, 9, {7 + next(places) / 8}]").encode())

        self.check("a scene", save, 1.5, 0.2)

    def test_a_value_of_a_parameter(self):
        """Shown within 0.15 s beside its trace: the median of twenty."""
        self.edit("shade.glsl", SHADE, "return share * E * brdf * dot(surface.Ns, L);")
        kernel = self.source("shade.glsl")
        kernel.write_text("PARAM(float, share, 1.0)\n" + kernel.read_text())
        self.path("params.json").write_text("{}")
        for _ in range(self.ROUNDS):
            beyond = []
            with self.watch(*self.SIZE, "--params", "params.json", outputs=["out.exr", "out.png"]) as w:
                w.picture()
                w.figures()
                w.wait("reference")
                for i in range(20):
                    started = time.monotonic()
                    write_in_place(self.path("params.json"), b'{"share": 0.%02d}' % (i + 10))
                    shown = w.picture()["at"]
                    beyond.append(shown - started - w.figures()["seconds"]["trace"])
                    time.sleep(0.1)
            seconds = statistics.median(beyond)
            print(f"\na value: shown {seconds:.3f} s after it was saved, beside its trace (at most 0.15)", file=sys.stderr)
            if seconds <= 0.15:
                return
        self.fail("too slow in every round")


class Moments(Session):
    """What takes less than the quiet time is one change; what takes twice the work is told to take longer."""

    def test_saves_in_quick_succession_are_one_version(self):
        with self.watch() as w:
            w.picture()
            w.figures()
            self.save_in_quick_succession()
            w.picture()
            self.assert_shows_the_sources(w)
            w.stays_quiet()
            self.assertEqual(w.count("superseded"), 0, w)
            # A change that is taken back at once is none to be seen.
            self.edit("shade.glsl", "0.5 * E", "wrong(")
            time.sleep(0.06)
            self.edit("shade.glsl", "wrong(", "0.5 * E")
            time.sleep(1)
            self.assertEqual(w.count("refused"), 0, w)
            self.assert_shows_the_sources(w)

    def test_a_file_that_is_gone_for_a_moment_was_not_deleted(self):
        with self.watch() as w:
            w.picture()
            w.figures()
            for name in ("shade.glsl", "whitted.comp"):
                text = self.source(name).read_text()
                self.source(name).unlink()
                time.sleep(0.06)
                self.save(name, text + "// saved\n", write_in_place)
                w.picture()

    def test_twice_the_work_takes_longer(self):
        """A picture that is large enough for times to mean something."""
        with self.watch("--width", "400", "--height", "300", "--samples", "2") as w:
            w.picture()
            w.figures()
            work = "for (int i = 0; i < 60; ++i) E = fract(E * 1.37 + 0.01 * sin(E));\n  "
            self.edit("whitted.comp", MAIN, MAIN + " vec3 E = vec3(gl_WorkGroupID) + float(frameInMemory.canaryLength); " + work + "if (E.x == 7.0) return;")
            w.picture()
            self.assertGreater(w.figures()["trace"]["ratio"], 1.05, w)


class Bars(Session):
    """Tests of other modules, with bars for what they take."""

    holds_times = True
    test_a_kernel_that_hangs_is_killed_after_the_timeout = harm.Harm.test_a_kernel_that_hangs_is_killed_after_the_timeout
    test_a_newer_save_and_ctrl_c_do_not_wait_for_a_kernel_that_hangs = (
        harm.Harm.test_a_newer_save_and_ctrl_c_do_not_wait_for_a_kernel_that_hangs
    )
    check_survives = harm.Harm.check_survives
    test_what_compilers_do_not_like = harm.Harm.test_what_compilers_do_not_like
    save_scene = scenes.Scenes.save_scene
    test_a_newer_save_interrupts_a_long_render = scenes.Scenes.test_a_newer_save_interrupts_a_long_render
    test_ctrl_c_during_a_long_render = scenes.Scenes.test_ctrl_c_during_a_long_render_leaves_the_last_good_picture
    test_a_renderer_that_dies_at_work = survival.Survival.test_a_renderer_that_dies_at_work
    test_a_renderer_that_is_stopped = survival.Survival.test_a_renderer_that_is_stopped
    test_ctrl_c_at_any_moment = survival.Survival.test_ctrl_c_at_any_moment
