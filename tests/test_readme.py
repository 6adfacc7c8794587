"""Runs the examples of the README, in order, in an empty folder: each must end with exit code 0. One that ends with &
watches a scene: it must render a version, another one after each command of its block that follows, and end by Ctrl-C.

usage: test_readme.py --program PATH_TO_TURNER --readme README.md
"""

import argparse
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile


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
        sys.exit(f"it ended before version {self.version}")

    def end(self):
        self.process.send_signal(signal.SIGINT)
        if self.process.wait(timeout=60) != 130:
            sys.exit(f"exit code {self.process.returncode} after Ctrl-C")


def run_block(commands, **where):
    watcher = None
    for command in commands:
        print("$", command, flush=True)
        if command.endswith("&"):
            watcher = Watcher(command, **where)
        else:
            done = subprocess.run(command, shell=True, timeout=600, **where)
            if done.returncode != 0:
                sys.exit(f"exit code {done.returncode}: {command}")
        if watcher:
            watcher.wait_for_next_version()
    if watcher:
        watcher.end()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--readme", type=pathlib.Path, required=True)
    arguments = parser.parse_args()

    examples = list(blocks(arguments.readme))
    count = sum(map(len, examples))
    assert count >= 5, f"only {count} examples found: has the README changed its form?"
    folder = tempfile.mkdtemp()
    try:
        environment = dict(os.environ)
        environment["PATH"] = f"{arguments.program.resolve().parent}:{environment['PATH']}"
        for commands in examples:
            run_block(commands, cwd=folder, env=environment)
        missing = [name for name in ("spheres.png", "part.json", "witness.exr", "cow.png", "live.png",
                                "report/report.html")
                   if not os.path.getsize(os.path.join(folder, name))]
        assert not missing, missing
    finally:
        shutil.rmtree(folder)
    print(f"{count} examples ran")


main()
