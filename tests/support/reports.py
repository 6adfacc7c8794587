"""Runs of `turner report`, and what its JSON says."""

import copy
import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from support.settings import PROGRAM, ROOT

TIMEOUT = 3600  # ctest ends it before, in most builds
# Small and quick: a mirror and a glass ball are in it.
SMALL = ["--width", "48", "--max-samples", "3"]


def run(arguments, expected=0, **options):
    done = subprocess.run([str(PROGRAM), *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          timeout=TIMEOUT, **options)
    assert done.returncode == expected, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done


def no_constants(text):
    raise AssertionError(f"{text} in JSON")


def load(folder):
    return json.loads((folder / "report.json").read_text(), parse_constant=no_constants)


def point(scene, name):
    return next(p for p in scene["points"] if p["name"] == name)


def device(scene):
    return scene["devices"][0]["device"]


def curve(scene, sampler):
    return next(c for c in scene["curves"] if c["device"] == device(scene) and c["sampler"] == sampler)


class InFolder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="turner_report_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def measure(self, *arguments, out="out"):
        run(["report", *arguments, "-o", self.folder / out])
        return load(self.folder / out)

    # A copy of the shaders with a text in one of them replaced.
    def shaders_with(self, file, old, new):
        copy = self.folder / "shaders"
        shutil.copytree(ROOT / "shaders", copy)
        text = (copy / file).read_text()
        self.assertEqual(text.count(old), 1, f"'{old}' must stand once in {file}: the test must follow the shader")
        (copy / file).write_text(text.replace(old, new))
        return copy
