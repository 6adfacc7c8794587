"""Deaths of the processes, and Ctrl-C at any moment."""

import json
import os
import random
import re
import signal
import subprocess
import time

from support.command import CRASH
from support.editors import EDITORS, write_and_rename
from support.patience import PATIENCE, wait_until
from support.pictures import Exr, png_size
from support.processes import children_of
from support.session import BALL, HALF, LARGE, SHADE, Session
from support.settings import PROGRAM, ROOT


class Survival(Session):
    def test_a_renderer_that_dies_while_it_waits(self):
        with self.watch() as w:
            w.picture()
            w.figures()
            w.wait("reference")
            for number, (old, new) in ((signal.SIGKILL, (SHADE, HALF)), (signal.SIGSEGV, (HALF, SHADE))):
                worker = w.worker()
                os.kill(worker, number)
                self.assertTrue(wait_until(lambda: w.worker() != worker), "another one takes its place")
                self.edit("shade.glsl", old, new)
                w.picture()
                w.figures()
                self.assert_shows_the_sources(w)

    def test_a_renderer_that_dies_at_work(self):
        with self.watch("--samples", "20") as w:
            w.picture()
            w.figures()
            w.wait("reference")
            before = self.exr()
            for number in (signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT):
                write_and_rename(self.path("scene.json"), json.dumps(LARGE).encode())
                w.wait("coarse", version=w.version + 1)
                os.kill(w.worker(), number)
                event = w.refused()
                # Of one that takes more than a second to die, as on a busy machine, the signal is not known.
                reason = f"signal {int(number)}" + ("" if self.holds_times else "|does not end")
                self.assertRegex(event["diagnoses"][0]["message"], reason, w)
                self.assertEqual(self.exr(), before)
                write_and_rename(self.path("scene.json"), json.dumps(BALL, indent=1).encode())
                w.picture()
                self.assertEqual(self.exr(), before)

    def test_a_renderer_that_is_stopped(self):
        """As by a debugger; a hanging driver looks the same."""
        with self.watch("--timeout", "1") as w:
            w.picture()
            w.figures()
            w.wait("reference")
            before = self.exr()
            os.kill(w.worker(), signal.SIGSTOP)
            self.edit("shade.glsl", SHADE, HALF)
            time.sleep(1)
            # Another text than the first: where a busy machine shows the watcher both edits at once, they are a version.
            self.edit("shade.glsl", HALF, SHADE + "  // again")
            w.picture()
            self.assertEqual(self.exr(), before)
            os.kill(w.worker(), signal.SIGSTOP)
            self.edit("shade.glsl", SHADE, HALF)
            time.sleep(0.5)
            w.interrupt(most=2)

    def test_a_reference_that_dies(self):
        with self.watch("--samples", "8", "--width", "640", "--height", "480") as w:
            w.picture()
            w.figures()
            self.assertTrue(wait_until(lambda: len(children_of(w.process.pid)) == 2), w)
            os.kill(children_of(w.process.pid)[1], signal.SIGKILL)
            w.wait("trouble")
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()

    def test_a_watcher_that_is_killed_leaves_no_process(self):
        for wait in (0.1, 0.5, 1.5):
            with self.watch("--samples", "8", "--width", "640", "--height", "480") as w:
                time.sleep(wait)
                w.kill()
        # Just when the reference has begun and is to pause.
        for _ in range(4):
            with self.watch() as w:
                w.picture()
                w.figures()
                self.save("shade.glsl", self.source("shade.glsl").read_bytes() + b"// saved\n")
                time.sleep(0.01)
                w.kill()

    def test_ctrl_c_at_any_moment(self):
        chance = random.Random(20)
        self.copy_shaders("spare")
        for i in range(20):
            moment = chance.uniform(0, 1.8)
            scene = chance.choice(["scene.json", ROOT / "scenes/spheres.json"])
            with self.subTest(moment=moment, scene=scene):
                for name in ("out.exr", "out.png"):
                    self.path(name).unlink(missing_ok=True)
                options = ["--width", "160", "--height", "120", "--samples", "2", "--keep", "kept"]
                with self.watch(*options, scene=scene) as w:
                    if chance.random() < 0.6:
                        time.sleep(moment / 2)
                        text = (self.path("spare") / "shade.glsl").read_text()
                        self.save("shade.glsl", text.replace(SHADE, f"return {1 + i}.0 * E;"), chance.choice(EDITORS))
                        time.sleep(moment / 2)
                    else:
                        time.sleep(moment)
                    if not w.text:
                        w.wait("watching")  # before, Ctrl-C ends it as it ends every process
                    w.interrupt()
                shown = w.events[-1]["version"]
                self.assertEqual(self.path("out.exr").exists(), w.count("coarse") + w.count("picture") > 0 or shown is not None, w)
                if self.path("out.exr").exists():
                    self.assertEqual(Exr(self.path("out.exr")).width, 160)
                    self.assertEqual(png_size(self.path("out.png")), (160, 120))
                    coarse = "turner:coarse" in Exr(self.path("out.exr")).attributes
                    self.assertEqual(coarse, shown is None, w)

    def test_nobody_reads_what_it_says(self):
        """Several times, as what is left depends on the moment."""
        texts = [(SHADE, HALF), (HALF, SHADE)]
        for i, flags in enumerate([["--json"], []] * 4):
            with self.subTest(flags=flags, i=i):
                command = [str(PROGRAM), "watch", "scene.json", "--shaders", "kernel", "-o", "out.exr", *flags]
                errors = self.path("errors").open("w+")
                self.addCleanup(errors.close)
                process = subprocess.Popen(
                    command, cwd=self.folder, env=self.environment(), stdout=subprocess.PIPE, stderr=errors
                )
                while not re.search(b'SPIR-V|"same_code"', line := process.stdout.readline()):
                    self.assertTrue(line, "it has ended by itself")
                process.stdout.close()
                self.edit("shade.glsl", *texts[i % 2])
                try:
                    process.wait(PATIENCE)
                except subprocess.TimeoutExpired:
                    process.kill()
                    self.fail("it watches on although nobody reads")
                self.check_nobody_left()
                self.assertIn(process.returncode, (1, -signal.SIGPIPE))
                errors.seek(0)
                self.assertNotRegex(errors.read(), CRASH)
                Exr(self.path("out.exr"))
                self.assertEqual(self.temporary_files(), [])
