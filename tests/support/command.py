"""Runs of the program as its users start it: real commands, real files.

Every run is under the Vulkan validation layers. What every run must keep is checked by Command.check_sane: no crash, no
complaint of a sanitizer. What a failing run must keep is checked by Command.refuse: its exit code, one line on stderr
for each fault, and a folder that is byte for byte as it was. Whether pictures are right is other tests' business.
"""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import time
import unittest

from support.pictures import Exr
from support.settings import PROGRAM
from support.timed import Timed

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130
TERMINATED, HUNG_UP = 143, 129

# Nothing here takes longer than a second or two; a sanitizer on a busy machine is slower by far.
TIMEOUT = 180  # seconds
# What is done at once, or ended by Ctrl-C, takes no longer.
PROMPT = 10  # seconds

SMALL = ["--width", "64", "--height", "48"]
TINY = ["--width", "8", "--height", "8"]
# Minutes of work: a fault that is found only after it runs into the timeout.
LONG = ["--width", "8000", "--height", "8000", "--samples", "16"]

# Where a message says that it is one; --max-error: is an option.
ERROR = re.compile(r"(?<![-\w])error:")

# Signs that a run ended in a way nobody wrote a message for.
CRASH = re.compile(
    r"terminate called|what\(\):|Sanitizer|runtime error:|Assertion|core dumped|Segmentation|VUID-|Traceback|\?\?:0"
)

# Vulkan finds no driver.
NO_DRIVER = {"VK_ICD_FILENAMES": "/nonexistent.json", "VK_DRIVER_FILES": "/nonexistent.json"}


class Run:
    def __init__(self, args, code, out, err, seconds):
        self.args, self.code, self.out, self.err, self.seconds = args, code, out, err, seconds

    def __str__(self):
        end = f"exit code {self.code} after {self.seconds:.2f} s"
        return f"$ turner {' '.join(self.args)}\n{end}\n--- stdout\n{self.out}--- stderr\n{self.err}"


def without_progress(text):
    """Lines of stderr; how far the work is, is told where it takes some seconds."""
    return [line for line in text.splitlines() if "Msamples/s" not in line]


class Command(Timed, unittest.TestCase):
    """Each test has a folder of its own, and is in it."""

    maxDiff = None

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="turner-commands-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def path(self, name):
        return self.folder / name

    def write(self, name, content):
        path = self.path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return name

    def files(self):
        return sorted(str(p.relative_to(self.folder)) for p in self.folder.rglob("*") if not p.is_dir())

    def snapshot(self):
        content = {}
        for path in self.folder.rglob("*"):
            name = str(path.relative_to(self.folder))
            if path.is_symlink():
                content[name] = os.readlink(path)
            elif path.is_file():
                path_mode = path.stat().st_mode
                content[name] = path.read_bytes() if path_mode & 0o400 else path.stat().st_size
            else:
                content[name] = "folder"
        return content

    def environment(self, changes):
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("TURNER_", "VK_"))}
        # The machine's own choice of drivers and layers stays.
        environment.update({k: v for k, v in os.environ.items() if k.startswith("VK_")})
        environment["TURNER_VALIDATION"] = "1"
        environment.update(changes or {})
        return environment

    def run_turner(self, *args, env=None, timeout=TIMEOUT, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, **options):
        args = [str(arg) for arg in args]
        start = time.monotonic()
        process = subprocess.run(
            [str(PROGRAM), *args],
            cwd=self.folder,
            env=self.environment(env),
            stdin=stdin,
            stdout=stdout,
            stderr=subprocess.PIPE,
            timeout=timeout,
            **options,
        )
        out, err = ((text or b"").decode(errors="replace") for text in (process.stdout, process.stderr))
        run = Run(args, process.returncode, out, err, time.monotonic() - start)
        self.check_sane(run)
        return run

    def check_sane(self, run):
        self.assertNotRegex(run.err + run.out, CRASH, run)
        self.assertIn(run.code, (DONE, FAILED, WRONG_INPUT, INTERRUPTED, TERMINATED, HUNG_UP), run)

    def do(self, *args, **options):
        """Runs what must succeed, without a word on stderr but progress."""
        run = self.run_turner(*args, **options)
        self.assertEqual(run.code, DONE, run)
        self.assertEqual(without_progress(run.err), [], run)
        return run

    def refuse(self, *args, code=WRONG_INPUT, says=(), faults=1, **options):
        """Runs what must fail, with as many lines on stderr as there are faults, and leave everything as it was."""
        before = self.snapshot()
        run = self.run_turner(*args, **options)
        self.assertEqual(run.code, code, run)
        self.assertEqual(self.snapshot(), before, run)
        self.check_message(run, faults, says)
        return run

    def check_message(self, run, faults=1, says=()):
        lines = without_progress(run.err)
        if faults is not None:
            self.assertEqual(len(lines), faults, f"{faults} line(s) on stderr\n{run}")
            for line in lines:
                self.assertEqual(len(ERROR.findall(line)), 1, f"each line says once that it is an error\n{run}")
                told = line
                for arg in filter(None, run.args):
                    told = told.replace(arg, "")
                self.assertLess(len(told), 300, f"a line for people\n{run}")
        self.assertNotRegex(run.out, ERROR, run)
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, run.err, run)

    def picture(self, *args, output="picture.exr", **options):
        """Renders into a file that is then gone; returns the picture."""
        self.do("render", *args, "--quiet", "-o", output, **options)
        exr = Exr(self.path(output))
        self.path(output).unlink()
        return exr

    def stats(self, *args):
        self.do("render", *args, "--quiet", "-o", "counted.exr", "--stats", "stats.json")
        return json.loads(self.path("stats.json").read_text())

    def figures(self, *args, code=DONE):
        run = self.run_turner("compare", *args, "--json")
        self.assertEqual(run.code, code, run)
        return json.loads(run.out)
