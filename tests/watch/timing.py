"""From the save to the moment at which the line that tells of the picture was read."""

import itertools
import shutil
import statistics
import sys
import time

from support.editors import write_and_rename
from support.session import SHADE, Session
from support.settings import ROOT


class Timing(Session):
    """From the save to the moment at which the line that tells of the picture was read. Run it alone."""

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
