"""Sessions of `turner watch` in a folder of their own, with a copy of the shaders that tests edit.

What every session must keep is checked by Watched when it ends: it lives until Ctrl-C, ends with 130, and leaves no
process and no temporary file behind. The witness for pictures is `turner render` with the same sources.
"""

import atexit
import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time
import unittest

from support.editors import write_and_rename, write_in_place
from support.patience import PATIENCE, TIMEOUT, wait_until
from support.processes import living_in
from support.settings import PROGRAM
from support.timed import Timed
from support.watched import Watched

# Of all features of the kernel it needs few, so that the driver compiles quickly.
BALL = {
    "width": 64,
    "height": 48,
    "depth": 1,
    "background": [0.25, 0.5, 1],
    "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov": 40},
    "lights": [{"position": [3, 5, 4]}],
    "materials": {"clay": {"diffuse": [0.7, 0.6, 0.5]}},
    "spheres": [{"center": [0.1, 0.2, 0], "radius": 1.1, "material": "clay"}],
}

LARGE = BALL | {"width": 1000, "height": 1000}  # takes long with some hundred samples in a pixel

# What tests edit: where a light's share is known, and where the kernel begins.
SHADE = "return E * brdf * dot(surface.Ns, L);"
HALF = "return 0.5 * E * brdf * dot(surface.Ns, L);"
MAIN = "void main() {"

# Of SPIR-V and of the driver's code, for all sessions of a run.
CACHES = tempfile.TemporaryDirectory(prefix="turner-caches-")
atexit.register(CACHES.cleanup)

GCC = re.compile(r"^(?P<file>[^:\n]+):(?P<line>\d+):(?P<column>\d+): error: (?P<message>.+)$")


class Session(Timed, unittest.TestCase):
    """Each test has a folder of its own, with a copy of the shaders and a scene."""

    maxDiff = None
    VALIDATION = "1"

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="turner-watch-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()
        self.path("tmp").mkdir()
        self.write_scene(BALL)
        self.copy_shaders("kernel")

    def path(self, name):
        return self.folder / name

    def environment(self, changes=None):
        environment = {k: v for k, v in os.environ.items() if not k.startswith("TURNER_")}
        environment["TURNER_DEVICE"] = os.environ.get("TURNER_DEVICE", "llvmpipe")
        environment["TURNER_VALIDATION"] = self.VALIDATION
        environment["TMPDIR"] = str(self.path("tmp"))
        environment["XDG_CACHE_HOME"] = CACHES.name
        environment.update(changes or {})
        return environment

    def turner(self, *args):
        run = subprocess.run(
            [str(PROGRAM), *map(str, args)],
            cwd=self.folder,
            env=self.environment(),
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
        )
        self.assertEqual(run.returncode, 0, f"$ turner {' '.join(map(str, args))}\n{run.stdout}\n{run.stderr}")
        return run

    def copy_shaders(self, name):
        self.turner("shaders", "--copy", name)

    def write_scene(self, scene, name="scene.json"):
        self.path(name).write_text(scene if isinstance(scene, str) else json.dumps(scene, indent=1))

    def watch(self, *options, scene="scene.json", shaders="kernel", outputs=("out.exr", "out.png"), **others):
        output = [word for name in outputs for word in ("-o", name)]
        return Watched(self, scene, "--shaders", shaders, *output, *options, **others)

    # --- edits ---

    def source(self, name):
        return self.path("kernel") / name

    def save(self, name, content, editor=write_and_rename):
        editor(self.source(name), content if isinstance(content, bytes) else content.encode())

    def edit(self, name, old, new, editor=write_and_rename):
        """Saves the file with one text in place of another; returns the number of its line."""
        text = self.source(name).read_text()
        self.assertEqual(text.count(old), 1, f"{old} in {name}")
        self.save(name, text.replace(old, new), editor)
        return text[: text.index(old)].count("\n") + 1

    def save_in_quick_succession(self):
        """Three times within the quiet time; the last text is HALF's."""
        text = self.source("shade.glsl").read_text()
        for factor in ("0.25", "0.75", "0.5"):
            self.save("shade.glsl", text.replace(SHADE, SHADE.replace("E", f"{factor} * E", 1)), write_in_place)
            time.sleep(0.06)

    def check_nobody_left(self, about=""):
        """No process works in this folder any more."""
        wait_until(lambda: not living_in(self.folder))
        left = living_in(self.folder)
        for process in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        self.assertEqual(left, [], f"processes are left\n{about}")

    # --- witnesses ---

    def exr(self):
        return self.path("out.exr").read_bytes()

    def rendered(self, *options, scene="scene.json", shaders="kernel"):
        """The same picture by `turner render`."""
        self.turner("render", scene, "--shaders", shaders, "--quiet", "-o", "witness.exr", *options)
        picture = self.path("witness.exr").read_bytes()
        self.path("witness.exr").unlink()
        return picture

    def assert_shows_the_sources(self, watched, *options, **others):
        self.assertEqual(self.exr(), self.rendered(*options, **others), f"not the picture that render makes\n{watched}")

    def temporary_files(self):
        made = [p for p in self.folder.rglob("*") if ".turner-" in p.name or p.parent == self.path("tmp")]
        return sorted(str(p.relative_to(self.folder)) for p in made)

    def assert_gcc(self, watched, file, line=None, says=""):
        """A diagnosis of this place is on stderr, with the source's line and a caret below."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            lines = list(watched.errors)
            for i, text in enumerate(lines[:-2]):
                place = GCC.match(text)
                if not place or pathlib.Path(place["file"]).name != file or says not in place["message"]:
                    continue
                if line is not None and int(place["line"]) != line:
                    continue
                self.assertRegex(lines[i + 2], r"^\s*\^$", watched)
                return place, lines[i + 1]
            time.sleep(0.02)
        self.fail(f"no diagnosis of {file}:{line} that says {says!r}\n{watched}")

    def assert_diagnosis(self, watched, event, file, line=None, says=""):
        """The same in the event and on stderr; and the source's line is that of the file."""
        places = [d for d in event["diagnoses"] if pathlib.Path(d["file"]).name == file and says in d["message"]]
        places = [d for d in places if line in (None, d["line"])]
        self.assertTrue(places, f"no diagnosis of {file}:{line} that says {says!r}\n{watched}")
        found = places[0]
        text = self.path(found["file"]).read_text()
        self.assertEqual(found["source"], text.splitlines()[found["line"] - 1], watched)
        self.assertTrue(1 <= found["column"] <= len(found["source"]) + 1, watched)
        self.assert_gcc(watched, file, found["line"], says)
        return found
