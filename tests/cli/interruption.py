"""Ctrl-C, a termination and a hang-up during long work."""

import contextlib
import os
import pty
import re
import select
import signal
import subprocess
import time

from support.command import DONE, ERROR, HUNG_UP, INTERRUPTED, LONG, PROMPT, TERMINATED, TIMEOUT, Command, Run
from support.patience import wait_until
from support.pictures import Exr
from support.processes import processor_seconds
from support.settings import PROGRAM, SCENES


class Interruption(Command):
    def setUp(self):
        super().setUp()
        self.write("out.exr", b"was here before")
        self.write("stats.json", b"was here before")

    @contextlib.contextmanager
    def started(self, *args, terminal, **options):
        """A run whose stderr is a terminal or a pipe; yields the process and the end that we read."""
        ours, theirs = pty.openpty() if terminal else os.pipe()
        command = [str(PROGRAM), *map(str, args)]
        process = subprocess.Popen(
            command,
            cwd=self.folder,
            env=self.environment(None),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=theirs,
            **options,
        )
        os.close(theirs)
        try:
            yield process, ours
        finally:
            if process.poll() is None:
                process.kill()
            process.wait()
            os.close(ours)

    def read_until(self, end, pattern, seconds):
        """What arrives up to the pattern, the end of the stream, or the end of our patience."""
        text = ""
        deadline = time.monotonic() + seconds
        while not (pattern and re.search(pattern, text)):
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([end], [], [], left)[0]:
                break
            try:
                block = os.read(end, 4096)
            except OSError:  # how a terminal says that nobody writes any more
                break
            if not block:
                break
            text += block.decode(errors="replace")
        return text

    def interrupt(self, process, end, before, text, most=PROMPT, by=signal.SIGINT, code=INTERRUPTED):
        process.send_signal(by)
        start = time.monotonic()
        try:
            process.wait(timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            self.fail(f"{by!r} was not noticed within {TIMEOUT} s\n{text}")
        seconds = time.monotonic() - start
        rest = self.read_until(end, None, 1)
        run = Run(process.args[1:], process.returncode, "", text + rest, seconds)
        self.assertEqual(run.code, code, run)
        self.check_sane(run)
        self.assertEqual(len(ERROR.findall(rest)), 1, run)
        self.assertIn("interrupted", rest, run)
        self.check_takes(seconds, most, run)
        self.assertEqual(self.snapshot(), before, run)

    def interrupt_render(self, *args, terminal, shows, **how):
        before = self.snapshot()
        with self.started(*args, terminal=terminal) as (process, end):
            # Once there is progress, the work has begun.
            text = self.read_until(end, shows, TIMEOUT)
            self.assertRegex(text, shows)
            self.interrupt(process, end, before, text, **how)
        return text

    def test_ctrl_c_ends_a_render_and_a_terminal_shows_one_line_that_renews_itself(self):
        args = ["render", SCENES / "spheres.json", *LONG, "-o", "out.exr", "--stats", "stats.json"]
        text = self.interrupt_render(*args, terminal=True, shows=r"\r *tracing: .*\r *tracing: ")
        self.assertRegex(text, r"\d+ %, [0-9.e+-]+ Msamples/s, \d+ s left")
        self.assertNotIn("\n", text)

    def test_ctrl_c_ends_the_reference_and_a_log_gets_plain_lines(self):
        args = ["render", SCENES / "spheres.json", *LONG, "--backend", "reference", "-o", "out.exr"]
        text = self.interrupt_render(*args, terminal=False, shows=r"(?m)^reference: .*\n")
        self.assertRegex(text, r"\d+ %, [0-9.e+-]+ Msamples/s, \d+ s left")
        self.assertNotIn("\r", text)

    def test_ctrl_c_ends_a_comparison(self):
        args = ["compare", SCENES / "spheres.json", *LONG, "--error-image", "out.exr"]
        self.interrupt_render(*args, terminal=True, shows=r"tracing: ")

    def test_ctrl_c_ends_pixels_of_many_samples(self):
        # A single pixel takes seconds here: Ctrl-C must be noticed within it.
        many = ["--width", "4096", "--height", "4096", "--samples", "256", "-o", "out.exr", "--quiet", "--backend"]
        for backend in ("shader", "reference"):
            with self.subTest(backend):
                before = self.snapshot()
                args = ["render", SCENES / "deep_glass.json", *many, backend]
                with self.started(*args, terminal=False) as (process, end):
                    self.assertEqual(self.read_until(end, None, 1.5), "")
                    # As long as it takes alone to begin.
                    wait_until(lambda: processor_seconds(process.pid) > 1.5, TIMEOUT)
                    self.interrupt(process, end, before, "")

    def test_ctrl_c_ends_the_counting_of_rays(self):
        # Counting begins where tracing wipes its line, and takes as long again. Ctrl-C may take less, but so much that a
        # driver that compiles the counting kernel first has time for that.
        size = ["--width", "80", "--height", "60", "--samples", "40", "-o", "out.exr", "--stats", "stats.json"]
        before = self.snapshot()
        with self.started("render", SCENES / "spheres.json", *size, terminal=True) as (process, end):
            start = time.monotonic()
            text = self.read_until(end, r"tracing: .*\r +\r", 3 * TIMEOUT)
            took = time.monotonic() - start
            self.assertRegex(text, r"tracing: .*\r +\r")
            self.assertNotIn("\n", text, "nothing of it stays")
            time.sleep(0.2)
            self.interrupt(process, end, before, text, most=0.6 * took)

    def test_a_termination_and_a_hang_up_end_like_ctrl_c(self):
        args = ["render", SCENES / "spheres.json", *LONG, "-o", "out.exr", "--stats", "stats.json", "--backend"]
        for by, code in ((signal.SIGTERM, TERMINATED), (signal.SIGHUP, HUNG_UP)):
            for backend, shows in (("shader", "tracing: "), ("reference", "reference: ")):
                with self.subTest(by=by, backend=backend):
                    self.interrupt_render(*args, backend, terminal=True, shows=shows, by=by, code=code)

    def test_a_hang_up_that_is_ignored_stays_ignored(self):
        """As nohup has it."""
        quick = ["--width", "200", "--height", "150", "--samples", "8", "--backend", "reference"]
        ignore = lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)
        args = ["render", SCENES / "spheres.json", *quick, "-o", "new.exr"]
        with self.started(*args, terminal=True, preexec_fn=ignore) as (process, end):
            self.read_until(end, "reference: ", TIMEOUT)
            process.send_signal(signal.SIGHUP)
            process.send_signal(signal.SIGHUP)
            self.assertEqual(process.wait(TIMEOUT), DONE)
        self.assertEqual(Exr(self.path("new.exr")).width, 200)
