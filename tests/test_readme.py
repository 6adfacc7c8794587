"""Runs the examples of the README, in order, in an empty folder: each must end with exit code 0.

usage: test_readme.py --program PATH_TO_TURNER --readme README.md
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile


def examples(readme):
    """The commands in the README's blocks of shell code, a line each."""
    text = readme.read_text(encoding="utf-8")
    for block in re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        yield from (line for line in block.splitlines() if line.strip())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--readme", type=pathlib.Path, required=True)
    arguments = parser.parse_args()

    commands = list(examples(arguments.readme))
    assert len(commands) >= 5, f"only {len(commands)} examples found: has the README changed its form?"
    folder = tempfile.mkdtemp()
    try:
        environment = dict(os.environ)
        environment["PATH"] = f"{arguments.program.resolve().parent}:{environment['PATH']}"
        for command in commands:
            print("$", command, flush=True)
            done = subprocess.run(command, shell=True, cwd=folder, env=environment, timeout=600)
            if done.returncode != 0:
                sys.exit(f"exit code {done.returncode}: {command}")
        missing = [name for name in ("spheres.png", "part.json", "witness.exr", "cow.png",
                                "report/report.html")
                   if not os.path.getsize(os.path.join(folder, name))]
        assert not missing, missing
    finally:
        shutil.rmtree(folder)
    print(f"{len(commands)} examples ran")


main()
