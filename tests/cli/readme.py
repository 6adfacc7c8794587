"""The examples of the README, in order, in an empty folder: each must end with exit code 0. One that ends with & watches
a scene: it must render a version, another one after each command of its block that follows, and end by Ctrl-C.
"""

import os
import pathlib
import re
import shlex
import signal
import subprocess
import tempfile
import unittest

from support.settings import PROGRAM, ROOT


def blocks(readme):
    """The commands in the README's blocks of shell code, a line each."""
    text = readme.read_text(encoding="utf-8")
    for block in re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        yield [line for line in block.splitlines() if line.strip()]


class Watcher:
    """A command that goes on beside the others of its block."""

    def __init__(self, command, **where):
        # Not through a shell, which would keep Ctrl-C from it.
        words = shlex.split(command.removesuffix("&"))
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, **where)
        self.version = 0

    def wait_for_next_version(self):
        self.version += 1
        for line in self.process.stdout:
            print(line, end="", flush=True)
            if line.startswith(f"version {self.version}") and ": in " in line:
                return
        raise AssertionError(f"it ended before version {self.version}")

    def end(self):
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(timeout=60)
        self.process.stdout.close()
        assert code == 130, f"exit code {code} after Ctrl-C"


def run_block(commands, **where):
    watcher = None
    for command in commands:
        print("$", command, flush=True)
        if command.endswith("&"):
            watcher = Watcher(command, **where)
        else:
            done = subprocess.run(command, shell=True, timeout=600, **where)
            assert done.returncode == 0, f"exit code {done.returncode}: {command}"
        if watcher:
            watcher.wait_for_next_version()
    if watcher:
        watcher.end()


class Readme(unittest.TestCase):
    def test_its_examples_run(self):
        examples = list(blocks(ROOT / "README.md"))
        count = sum(map(len, examples))
        self.assertGreaterEqual(count, 5, "has the README changed its form?")
        environment = dict(os.environ)
        environment["PATH"] = f"{PROGRAM.parent}:{environment['PATH']}"
        with tempfile.TemporaryDirectory() as folder:
            for commands in examples:
                run_block(commands, cwd=folder, env=environment)
            for name in ("spheres.png", "part.json", "witness.exr", "cow.png", "live.png", "report/report.html"):
                self.assertGreater((pathlib.Path(folder) / name).stat().st_size, 0, name)
