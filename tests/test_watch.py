#!/usr/bin/env python3
"""Edits a copy of the shaders as editors do while `turner watch` looks on: picture, message and survival of each edit.

    python3 test_watch.py --program build/turner --root . [--mutations N] [options of unittest]

What every session must keep is checked by Watched when it ends: it lives until Ctrl-C, ends with 130, and leaves no
process and no temporary file behind. The witness for pictures is `turner render` with the same sources.
"""

import argparse
import collections
import contextlib
import itertools
import json
import os
import pathlib
import random
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from test_commands import CRASH, Exr, modes_bind, png_size, say_not_possible, without_superpowers

PROGRAM = None  # set by main()
ROOT = None
MUTATIONS = 60
CACHES = None  # of SPIR-V and of the driver's code, for all sessions

# Compilers under a sanitizer on a busy machine are slow; a sound run waits for none of this.
TIMEOUT = 120  # seconds
PATIENCE = 10  # seconds in which Ctrl-C must have ended everything

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

GCC = re.compile(r"^(?P<file>[^:\n]+):(?P<line>\d+):(?P<column>\d+): error: (?P<message>.+)$")


# --- processes ------------------------------------------------------------------------------------------------------


def children_of(pid):
    try:
        found = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except (FileNotFoundError, ProcessLookupError):
        return []
    return [int(child) for child in found]


def tree_of(pid):
    """The process and all that come of it."""
    return [pid] + [process for child in children_of(pid) for process in tree_of(child)]


def living_in(folder):
    """Who has this working folder; of a process that nobody has waited for nothing is left to see."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if os.readlink(process / "cwd") == str(folder):
                found.append(int(process.name))
    return found


def memory_of(pid):
    """RSS, its anonymous part, and PSS in KiB; zeros where the process has just ended."""
    try:
        text = pathlib.Path(f"/proc/{pid}/smaps_rollup").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return 0, 0, 0
    return tuple(int(re.search(rf"^{name}:\s+(\d+) kB", text, re.M)[1]) for name in ("Rss", "Anonymous", "Pss"))


def wait_until(condition, seconds=PATIENCE):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


# --- editors --------------------------------------------------------------------------------------------------------


def write_in_place(path, data):
    """Two writes into the same file, as of a text that is longer than the editor's buffer."""
    with open(path, "wb", buffering=0) as file:
        file.write(data[: len(data) // 2])
        file.write(data[len(data) // 2 :])


def write_and_rename(path, data):
    new = path.with_name(f".{path.name}.swp")
    new.write_bytes(data)
    os.replace(new, path)


def move_away_and_write(path, data):
    backup = path.with_name(path.name + "~")
    if path.exists():
        os.replace(path, backup)
    path.write_bytes(data)
    backup.unlink(missing_ok=True)


def delete_and_write(path, data):
    path.unlink(missing_ok=True)
    path.write_bytes(data)


def overwrite_and_cut(path, data):
    with open(path, "r+b" if path.exists() else "w+b") as file:
        file.write(data)
        file.truncate()


EDITORS = [write_in_place, write_and_rename, move_away_and_write, delete_and_write, overwrite_and_cut]


# --- a session ------------------------------------------------------------------------------------------------------


class Watched:
    """One run of `turner watch` in a folder; what it prints is read by threads, each event with the time of its line."""

    def __init__(self, test, *args, env=None, json_lines=True, **options):
        self.test, self.json_lines = test, json_lines
        self.args = ["watch", *map(str, args), *(["--json"] if json_lines else [])]
        self.events, self.text, self.errors = [], [], []
        self.changed = threading.Condition()
        self.version = 0  # the last that is known
        self.process = subprocess.Popen(
            [str(PROGRAM), *self.args],
            cwd=test.folder,
            env=test.environment(env),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            **options,
        )
        self.threads = [
            threading.Thread(target=self._read, args=(stream, take), daemon=True)
            for stream, take in ((self.process.stdout, self._take_line), (self.process.stderr, self.errors.append))
        ]
        for thread in self.threads:
            thread.start()

    def _read(self, stream, take):
        for line in stream:
            now = time.monotonic()
            with self.changed:
                take(line.decode(errors="replace").rstrip("\n"))
                if self.events and "at" not in self.events[-1]:
                    self.events[-1]["at"] = now
                self.changed.notify_all()
        with self.changed:
            self.changed.notify_all()

    def _take_line(self, line):
        self.text.append(line)
        if self.json_lines:
            self.events.append(json.loads(line))

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None and self.process.returncode is None:
            self.interrupt()
        elif self.process.poll() is None:
            self.kill()
        for thread in self.threads:
            thread.join(PATIENCE)
        self.process.stdout.close()
        self.process.stderr.close()

    def __str__(self):
        end = f"exit code {self.process.returncode}"
        return f"$ turner {' '.join(self.args)}\n{end}\n--- stdout\n{self.out}\n--- stderr\n{self.err}"

    @property
    def out(self):
        return "\n".join(self.text)

    @property
    def err(self):
        return "\n".join(self.errors)

    # --- what it says ---

    def wait(self, *kinds, version=None, since=0, seconds=TIMEOUT, must=True):
        """The first event of a kind, of a version if it is named, among those since an index."""
        end = time.monotonic() + seconds
        with self.changed:
            while True:
                for event in self.events[since:]:
                    if event["event"] in kinds and version in (None, event.get("version")):
                        return event
                left = end - time.monotonic()
                gone = self.process.poll() is not None and not any(t.is_alive() for t in self.threads)
                if left <= 0 or gone:
                    break
                self.changed.wait(min(left, 0.5))
        if must:
            self.test.fail(f"no {' or '.join(kinds)} of version {version} within {seconds} s\n{self}")
        return None

    def wait_for_error(self, pattern, seconds=TIMEOUT):
        self.test.assertTrue(wait_until(lambda: re.search(pattern, self.err, re.M), seconds), f"{pattern}\n{self}")

    def outcome(self, seconds=TIMEOUT):
        """The picture or refusal of the next version that is not interrupted."""
        while True:
            event = self.wait("picture", "refused", "superseded", version=self.version + 1, seconds=seconds)
            self.version += 1
            if event["event"] != "superseded":
                return event

    def picture(self, **options):
        event = self.outcome(**options)
        self.test.assertEqual(event["event"], "picture", self)
        return event

    def refused(self, **options):
        event = self.outcome(**options)
        self.test.assertEqual(event["event"], "refused", self)
        return event

    def figures(self):
        """All that is told of the last version."""
        return self.wait("version", version=self.version)

    def stays_quiet(self, seconds=1):
        """No new version."""
        event = self.wait("coarse", "picture", "refused", "superseded", version=self.version + 1, seconds=seconds, must=False)
        self.test.assertIsNone(event, self)

    def count(self, kind):
        return sum(event["event"] == kind for event in self.events)

    # --- its processes ---

    def worker(self):
        """The oldest child renders; the other one, while it lives, is the reference's."""
        self.test.assertTrue(wait_until(lambda: children_of(self.process.pid)), self)
        return children_of(self.process.pid)[0]

    def is_alive(self):
        return self.process.poll() is None

    def interrupt(self, code=130):
        """Ctrl-C, and what must be true then."""
        self.test.assertTrue(self.is_alive(), f"it has ended by itself\n{self}")
        started = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.test.fail(f"Ctrl-C did not end it within {PATIENCE} s\n{self}")
        self.seconds_to_end = time.monotonic() - started
        for thread in self.threads:
            thread.join(PATIENCE)
        self.test.assertEqual(self.process.returncode, code, self)
        self.check_nothing_left()
        if self.json_lines:
            self.test.assertEqual(self.events[-1]["event"], "stopped", self)
        return self.seconds_to_end

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.test.check_nobody_left(self)

    def check_nothing_left(self):
        self.test.check_nobody_left(self)
        self.test.assertEqual(self.test.temporary_files(), [], self)
        # A worker's end is told in these words; a crash of the watcher is not.
        self.test.assertNotRegex(re.sub(r"was ended by signal \d+ \([^)]*\)", "", self.err), CRASH, self)


class Session(unittest.TestCase):
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
        environment["XDG_CACHE_HOME"] = CACHES
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

    def check_nobody_left(self, about=""):
        """No process works in this folder any more."""
        wait_until(lambda: not living_in(self.folder), 2)
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
        deadline = time.monotonic() + 2
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


# --- shaders --------------------------------------------------------------------------------------------------------


class Shaders(Session):
    def test_each_editors_manner_of_saving_is_one_version(self):
        with self.watch() as w:
            w.picture()
            full = Exr(self.path("out.exr"))
            texts = [HALF, SHADE] * len(EDITORS)
            for editor, (old, new) in zip(EDITORS, zip([SHADE, HALF] * len(EDITORS), texts)):
                with self.subTest(editor.__name__):
                    self.edit("shade.glsl", old, new, editor)
                    w.picture()
                    self.assertEqual(w.figures()["changed"], ["shade.glsl"], w)
                    self.assert_shows_the_sources(w)
            half = Exr(self.path("out.exr"))  # the number of editors is odd
            self.assertEqual(half.pixel(0, 0), full.pixel(0, 0), "the background is no light's")
            self.assertEqual(half.pixel(36, 16), tuple(0.5 * value for value in full.pixel(36, 16)))
            self.assertGreater(min(half.pixel(36, 16)), 0)
            self.assertEqual(png_size(self.path("out.png")), (64, 48))
            w.stays_quiet()

    def test_two_files_at_once_are_one_version(self):
        with self.watch() as w:
            w.picture()
            self.edit("shade.glsl", SHADE, HALF, write_in_place)
            self.edit("whitted.comp", "weight * xyz(frame.background)", "0.5 * weight * xyz(frame.background)")
            w.picture()
            self.assertEqual(sorted(w.figures()["changed"]), ["shade.glsl", "whitted.comp"], w)
            self.assertEqual(Exr(self.path("out.exr")).pixel(0, 0), (0.125, 0.25, 0.5))
            self.assert_shows_the_sources(w)
            w.stays_quiet()

    def test_a_syntax_error_and_its_mend(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            line = self.edit("shade.glsl", SHADE, "return E * brdf * dot(surface.Ns, L;")
            found = self.assert_diagnosis(w, w.refused(), "shade.glsl", line, "syntax error")
            self.assertEqual(found["source"][found["column"] - 1], ";", "the column is that of the token")
            self.assertEqual(self.exr(), before)
            self.assertEqual(w.wait("refused", version=2)["last_good"], 1)
            # Another mistake: a name that nobody knows.
            line = self.edit("shade.glsl", "return E * brdf * dot(surface.Ns, L;", "return E * brfd;")
            found = self.assert_diagnosis(w, w.refused(), "shade.glsl", line, "brfd")
            self.assertEqual(found["column"], found["source"].index("brfd") + 1)
            self.assertEqual(self.exr(), before)
            self.edit("shade.glsl", "return E * brfd;", HALF)
            w.picture()
            self.assertEqual(w.figures()["last_good"], 1, w)
            self.assert_shows_the_sources(w)

    def test_an_include_that_is_added_is_watched_too(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            # Named before it is there.
            text = self.source("shade.glsl").read_text().replace(SHADE, "return kTint * E * brdf * dot(surface.Ns, L);")
            self.save("shade.glsl", '#include "more/tint.glsl"\n' + text)
            self.assert_diagnosis(w, w.refused(), "shade.glsl", 1, "more/tint.glsl")
            self.assertEqual(self.exr(), before)
            self.source("more").mkdir()
            self.save("more/tint.glsl", "const float kTint = 0.5;\n", write_in_place)
            w.picture()
            self.assert_shows_the_sources(w)
            self.assertNotEqual(self.exr(), before)
            self.save("more/tint.glsl", "const float kTint = 0.5 +;\n")
            self.assert_diagnosis(w, w.refused(), "tint.glsl", 1, "syntax error")
            self.save("more/tint.glsl", "const float kTint = 1.0;\n", delete_and_write)
            w.picture()
            self.assertEqual(w.figures()["changed"], ["tint.glsl"], w)
            self.assertEqual(self.exr(), before, "a factor of 1")
            # A file that nobody includes any more is not watched any more.
            self.save("shade.glsl", self.source("shade.glsl").read_text().replace('#include "more/tint.glsl"', "const float kTint = 1.0;"))
            w.picture()
            w.figures()
            self.save("more/tint.glsl", "nonsense")
            w.stays_quiet()

    def test_an_include_of_itself_is_refused(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            text = self.source("light_buffer.glsl").read_text()
            self.save("light_buffer.glsl", text + '#include "light_buffer.glsl"\n')
            self.assert_diagnosis(w, w.refused(), "light_buffer.glsl")
            self.assertEqual(self.exr(), before)
            self.save("light_buffer.glsl", text)
            w.picture()
            self.assertEqual(self.exr(), before)

    def test_a_deleted_file_and_its_return(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            for name, includer in (("shade.glsl", "whitted.comp"), ("whitted.comp", "whitted.comp"), ("layout.h", "whitted.comp")):
                with self.subTest(name):
                    text = self.source(name).read_bytes()
                    self.source(name).unlink()
                    event = w.refused()
                    w.wait_for_error(name)
                    self.assertTrue(any(pathlib.Path(d["file"]).name == includer for d in event["diagnoses"]), w)
                    self.assertEqual(self.exr(), before)
                    self.save(name, text, write_in_place)
                    w.picture()
                    self.assertEqual(self.exr(), before)

    def test_the_whole_folder_goes_and_returns(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            os.rename(self.path("kernel"), self.path("elsewhere"))
            w.refused()
            self.assertEqual(self.exr(), before)
            shutil.copytree(self.path("elsewhere"), self.path("kernel.new"))
            os.rename(self.path("kernel.new"), self.path("kernel"))
            w.picture()
            self.assertEqual(self.exr(), before)
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()
            self.assert_shows_the_sources(w)

    def test_sources_may_be_symbolic_links(self):
        os.rename(self.source("shade.glsl"), self.path("real.glsl"))
        self.source("shade.glsl").symlink_to("../real.glsl")
        with self.watch() as w:
            w.picture()
            path = self.path("real.glsl")
            write_and_rename(path, path.read_text().replace(SHADE, HALF).encode())
            w.picture()
            self.assert_shows_the_sources(w)

    def test_what_is_no_file_of_text_is_refused_and_does_not_hang(self):
        def fifo(path):
            path.unlink()
            os.mkfifo(path)

        def folder(path):
            path.unlink()
            path.mkdir()

        def link_to_itself(path):
            path.unlink()
            path.symlink_to(path.name)

        def zeros(path):
            path.write_bytes(bytes(100_000))

        for replace in (folder, link_to_itself, zeros, fifo):
            with self.subTest(replace.__name__), self.watch() as w:
                w.picture()
                before = self.exr()
                for path in (self.source("shade.glsl"), self.source("whitted.comp"), self.path("scene.json")):
                    text = path.read_bytes()
                    replace(path)
                    w.refused(seconds=20)
                    self.assertEqual(self.exr(), before)
                    if path.is_dir():
                        path.rmdir()
                    write_and_rename(path, text)
                    w.picture(seconds=20)
                    self.assertEqual(self.exr(), before)

    def test_the_same_text_saved_again_is_no_version(self):
        with self.watch() as w:
            w.picture()
            w.figures()
            for editor in EDITORS:
                self.save("shade.glsl", self.source("shade.glsl").read_bytes(), editor)
            os.utime(self.source("whitted.comp"))
            w.stays_quiet()

    def test_a_scene_saved_again_without_a_change_is_no_version(self):
        with self.watch() as w:
            w.picture()
            w.figures()
            for editor in EDITORS:
                editor(self.path("scene.json"), self.path("scene.json").read_bytes())
            w.stays_quiet()

    def test_a_change_of_comments_leaves_the_code(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.edit("shade.glsl", SHADE, SHADE + "  // of one light")
            w.picture()
            told = w.figures()
            self.assertTrue(told["same_code"], w)
            self.assertEqual(told["changed_pixels"], 0)
            self.assertEqual((told["spirv"]["added"], told["spirv"]["removed"]), (0, 0))
            self.assertEqual(self.exr(), before)

    def test_saves_in_quick_succession_are_one_version(self):
        with self.watch() as w:
            w.picture()
            w.figures()
            text = self.source("shade.glsl").read_text()
            for factor in ("0.25", "0.75", "0.5"):
                self.save("shade.glsl", text.replace(SHADE, SHADE.replace("E", f"{factor} * E", 1)), write_in_place)
                time.sleep(0.06)
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

    def test_without_a_good_version_it_says_so_and_waits(self):
        line = self.edit("shade.glsl", SHADE, "return nothing;")
        with self.watch() as w:
            event = w.refused()
            self.assertIsNone(event["last_good"], w)
            self.assert_diagnosis(w, event, "shade.glsl", line, "nothing")
            self.assertFalse(self.path("out.exr").exists())
            self.edit("shade.glsl", "return nothing;", SHADE)
            w.picture()
            self.assert_shows_the_sources(w)
        self.edit("shade.glsl", SHADE, "return nothing;")
        with self.watch(outputs=("second.exr",), json_lines=False) as w:
            self.assertTrue(wait_until(lambda: "no picture yet, waiting" in w.out, TIMEOUT), w)


# --- what the host demands ------------------------------------------------------------------------------------------


class Layout(Session):
    def check_refused(self, name, old, new, file, says, step="check"):
        """Refused for this reason at the edited place; the picture stays, and comes back with the old text."""
        with self.watch() as w:
            w.picture()
            before = self.exr()
            text = self.source(name).read_bytes()
            line = self.edit(name, old, new)
            event = w.refused()
            self.assertEqual(event["step"], step, w)
            self.assert_diagnosis(w, event, file, line if file == name else None, says)
            self.assertEqual(self.exr(), before)
            self.save(name, text)
            w.picture()
            self.assertEqual(self.exr(), before)

    def test_a_binding_that_the_host_lacks(self):
        self.check_refused("whitted.comp", "binding = kBindPixels)", "binding = 12)", "whitted.comp", "12")

    def test_two_bindings_in_each_others_place(self):
        text = self.source("whitted.comp").read_text()
        text = text.replace("binding = kBindPixels", "binding = X").replace("binding = kBindState", "binding = kBindPixels")
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.save("whitted.comp", text.replace("binding = X", "binding = kBindState"))
            event = w.refused()
            self.assertEqual(event["step"], "check", w)
            self.assert_diagnosis(w, event, "whitted.comp")
            self.assertEqual(self.exr(), before)

    def test_a_work_group_of_another_size(self):
        self.check_refused("whitted.comp", "local_size_x_id = kSpecWorkGroup", "local_size_x = 7", "whitted.comp", "")

    def test_a_member_more_in_the_push_constants(self):
        old = "uint stride;         //"
        self.check_refused("layout.h", old, "uint more, stride;   //", "layout.h", "")

    def test_a_member_that_moves(self):
        self.check_refused("layout.h", "  uint unfinished;      //", "  uint room;\n  uint unfinished;      //", "layout.h", "")

    def test_a_constant_of_another_value(self):
        self.check_refused("layout.h", "kRefNone = 0xffffffffu;", "kRefNone = 0xfffffffdu;", "layout.h", "kRefNone")

    def test_a_binding_of_another_number(self):
        self.check_refused("layout.h", "kBindMaterials = 7u;", "kBindMaterials = 8u;", "layout.h", "kBindMaterials")

    def test_what_the_host_can_follow(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.edit("layout.h", "kLightBufferRows = 6u;", "kLightBufferRows = 6u;  // one for each face")
            w.picture()
            self.assertEqual(self.exr(), before)
            text = self.source("layout.h").read_text()
            self.save("layout.h", text.replace("TURNER_CONST kLightBufferRows", "TURNER_CONST kMine = 2u;\nTURNER_CONST kLightBufferRows"))
            w.picture()
            self.assertEqual(self.exr(), before)
            self.edit("shade.glsl", SHADE, SHADE.replace("E", "float(kMine) * E", 1))
            w.picture()
            self.assertNotEqual(self.exr(), before)
            self.assert_shows_the_sources(w)


# --- shaders that hurt ----------------------------------------------------------------------------------------------


# lavapipe ends the loops of an invocation after 65,535 turns in all: each of them must be long.
HANG = f"""
  float hang = float(frame.background.w);
  for (uint a = 0u; a < 60000u; ++a)
    for (uint b = 0u; b < 60000u; ++b) {{
      {"hang = fract(sin(hang) * 43758.5); " * 256}
    }}
  if (hang == 2.0) return;
"""
HANGING = ["--width", "256", "--height", "192"]


class Harm(Session):
    def check_survives(self, w, name, old, new, **expected):
        """An edit that hurts; then the picture is what it was before, and comes again with the old text."""
        before = self.exr()
        text = self.source(name).read_bytes()
        line = self.edit(name, old, new)
        event = w.outcome()
        after = self.exr()
        self.save(name, text)
        w.picture()
        self.assertEqual(self.exr(), before, w)
        for key, value in expected.items():
            self.assertEqual(event.get(key), value, w)
        if event["event"] == "refused":
            self.assertEqual(after, before, w)
            self.assertTrue(event["diagnoses"] and all(d["message"] for d in event["diagnoses"]), w)
        return event, line

    def test_an_endless_loop(self):
        with self.watch() as w:
            w.picture()
            for name, old, new in (
                ("shade.glsl", SHADE, f"while (E.x != 2e9) {{ E.y += 1.0; }}\n  {SHADE}"),
                ("whitted.comp", MAIN, f"{MAIN} for (uint i = 1u; i != 0u; i |= 1u) atomicAdd(status.unfinished, 0u);"),
                ("whitted.comp", "} while (phase != kDone && budget > 0);", "} while (true);"),
            ):
                with self.subTest(new):
                    event, line = self.check_survives(w, name, old, new, event="refused", endless=True)
                    (found,) = event["diagnoses"]
                    self.assertEqual(pathlib.Path(found["file"]).name, name, w)
                    self.assertRegex(found["message"], "endless loop", w)
                    self.assertAlmostEqual(found["line"], line, delta=3)
                    self.assert_gcc(w, name, found["line"], "endless loop")

    def test_a_kernel_that_writes_nothing(self):
        """Whatever is said of it: what lay in memory is no picture."""
        with self.watch() as w:
            w.picture()
            before = self.exr()
            for new in (f"{MAIN} return;", f"{MAIN} if (gl_WorkGroupID.x % 2u == 1u) return;"):
                with self.subTest(new):
                    self.edit("whitted.comp", MAIN, new)
                    event = w.outcome()
                    after = self.exr()
                    if event["event"] == "picture":
                        black = Exr(self.path("out.exr"))
                        known = {(0, 0, 0)} | {black.pixel(0, 0)}
                        self.assertTrue({black.pixel(x, 0) for x in range(64)} <= known, w)
                    else:
                        self.assertEqual(after, before)
                    self.edit("whitted.comp", new, MAIN)
                    w.picture()
                    self.assertEqual(self.exr(), before)

    def test_a_kernel_that_hangs_is_killed_after_the_timeout(self):
        with self.watch("--timeout", "1", *HANGING) as w:
            w.picture()
            w.figures()
            started = time.monotonic()
            before = self.exr()
            line = self.edit("whitted.comp", MAIN, MAIN + HANG)
            event = w.refused()
            self.assertTrue(1 <= event["at"] - started < 20, event["at"] - started)
            self.assertTrue(event["endless"], w)
            (found,) = event["diagnoses"]
            self.assertEqual(pathlib.Path(found["file"]).name, "whitted.comp")
            self.assertTrue(line <= found["line"] <= line + 6, w)
            self.assertIn("1 s", found["message"], w)
            self.assertEqual(self.exr(), before)
            self.edit("whitted.comp", MAIN + HANG, MAIN)
            w.picture()
            self.assertEqual(self.exr(), before)

    def test_a_newer_save_and_ctrl_c_do_not_wait_for_a_kernel_that_hangs(self):
        with self.watch(*HANGING) as w:
            w.picture()
            w.figures()
            before = self.exr()
            self.edit("whitted.comp", MAIN, MAIN + HANG)
            time.sleep(2.5)
            started = time.monotonic()
            self.edit("whitted.comp", MAIN + HANG, MAIN)
            self.assertLess(w.picture()["at"] - started, 5, w)
            self.edit("whitted.comp", MAIN, MAIN + HANG)
            time.sleep(2.5)
            self.assertLess(w.interrupt(), 2, w)
            self.assertEqual(self.exr(), before)

    def test_indices_out_of_range(self):
        with self.watch() as w:
            w.picture()
            table = "float table[3] = float[3](1.0, 1.0, 1.0);"
            for name, old, new in (
                # Known to the compiler.
                ("shade.glsl", SHADE, f"{table} return table[3] * E;"),
                # A local array; how far is known only when it runs.
                ("shade.glsl", SHADE, f"{table} return table[frame.background.w * 1000000u] * E;"),
                ("shade.glsl", SHADE, f"{table} table[frame.background.w * 100000u] = 2.0; return table[1] * E;"),
                # Buffers: read, written.
                ("shade.glsl", SHADE, "return E * xyz(ROW(materials, 0x0fffffffu));"),
                ("whitted.comp", "pixels[at] = packRow", "pixels[at + 0x03ffffffu] = packRow"),
                ("whitted.comp", "pixels[at] = packRow", "pixels[at * 4096u] = packRow"),
            ):
                with self.subTest(new):
                    self.check_survives(w, name, old, new)

    def test_what_compilers_do_not_like(self):
        laughs = "#define L0 (1.0 + 1.0)\n" + "".join(f"#define L{i} (L{i - 1} + L{i - 1})\n" for i in range(1, 40))
        with self.watch() as w:
            w.picture()
            for what, new in (
                ("deep brackets", "return E * " + "(" * 100_000 + "1.0" + ")" * 100_000 + ";"),
                ("deep blocks", "{" * 20_000 + "}" * 20_000 + SHADE),
                ("recursion", "return lightReflected(surface, V, lightPosition, E, material);"),
                ("a very long line", "return E * (" + " + ".join(["0.001"] * 20_000) + ");"),
            ):
                with self.subTest(what):
                    self.check_survives(w, "shade.glsl", SHADE, new)
            with self.subTest("macros without end"):
                w.figures()
                before = self.exr()
                text = self.source("shade.glsl").read_text()
                self.save("shade.glsl", laughs + text.replace(SHADE, "return E * L39;"))
                time.sleep(1)
                started = time.monotonic()
                self.save("shade.glsl", text)
                self.assertLess(w.picture()["at"] - started, 10, w)
                self.assertEqual(self.exr(), before)

    def test_a_compiler_that_crashes(self):
        """lavapipe 22.3 dies of it."""
        with self.watch() as w:
            w.picture()
            new = "shared uint far[64];\nvoid main() { far[frameInMemory.background.w * 0x1000000u] = 1u;"
            event, _ = self.check_survives(w, "whitted.comp", MAIN, new)
            if event["event"] == "picture":
                return say_not_possible("to make the driver crash")
            self.assertIn("signal", event["diagnoses"][0]["message"], w)

    def test_an_endless_loop_that_does_nothing(self):
        """A compiler may drop it; then the picture is that without it."""
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.edit("whitted.comp", MAIN, f"{MAIN} while (true) {{}}")
            w.outcome()
            self.assertEqual(self.exr(), before, w)

    def test_what_only_the_driver_sees(self):
        with self.watch() as w:
            w.picture()
            for what, new in (
                ("barriers that not all reach", f"if (E.x > 0.5) barrier();\n  {SHADE}"),
                ("too much shared memory", "return E;\n}\nshared float big[100000000];\nvoid useBig() { big[3] = 1.0;"),
                ("doubles", "return vec3(dvec3(E) * 2.0LF);"),
                ("NaN", "return E * sqrt(-E.x) * 0.0 / 0.0;"),
            ):
                with self.subTest(what):
                    self.check_survives(w, "shade.glsl", SHADE, new)


# --- scenes ---------------------------------------------------------------------------------------------------------

MESH = {
    "width": 64,
    "height": 48,
    "depth": 1,
    "background": [0.25, 0.5, 1],
    "camera": {"eye": [0.3, 0.3, 5], "target": [0.3, 0.3, 0], "fov": 30},
    "lights": [{"position": [3, 5, 4]}],
    "materials": {"m": {"diffuse": [0.7, 0.6, 0.5]}},
    "meshes": [{"file": "meshes/shape.obj", "material": "m"}],
}
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


class Scenes(Session):
    def save_scene(self, scene, editor=write_and_rename):
        editor(self.path("scene.json"), (scene if isinstance(scene, str) else json.dumps(scene, indent=1)).encode())

    def test_a_change_of_the_scene(self):
        with self.watch() as w:
            w.picture()
            for editor, background in zip(EDITORS, ([0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0.5])):
                with self.subTest(editor.__name__):
                    self.save_scene(BALL | {"background": background}, editor)
                    w.picture()
                    told = w.figures()
                    self.assertTrue(told["scene_changed"], w)
                    self.assertEqual(told["changed"], [])
                    self.assertEqual(Exr(self.path("out.exr")).pixel(0, 0), tuple(background))
                    self.assert_shows_the_sources(w)
            # The reference follows.
            w.wait("reference", version=w.version)

    def test_a_wrong_scene_and_its_mend(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            text = json.dumps(BALL, indent=1)
            for wrong, line, says in (
                (text.replace('"radius": 1.1', '"radius": -'), 1 + text[: text.index('"radius"')].count("\n"), ""),
                (text.replace('"radius"', '"raduis"'), 1 + text[: text.index('"radius"')].count("\n"), "raduis"),
                ("", None, ""),
            ):
                with self.subTest(says):
                    self.save_scene(wrong)
                    event = w.refused()
                    self.assertEqual(event["step"], "scene", w)
                    self.assertTrue(any(pathlib.Path(d["file"]).name == "scene.json" for d in event["diagnoses"]), w)
                    if line:
                        self.assert_diagnosis(w, event, "scene.json", line, says)
                    self.assertEqual(self.exr(), before)
            # The shaders are watched on; with them the scene is still wrong.
            self.edit("shade.glsl", SHADE, HALF)
            w.refused()
            self.assertEqual(self.exr(), before)
            self.save_scene(BALL)
            w.picture()
            self.assert_shows_the_sources(w)

    def test_a_deleted_scene_and_its_return(self):
        with self.watch() as w:
            w.picture()
            before = self.exr()
            self.path("scene.json").unlink()
            w.refused()
            w.wait_for_error("scene.json")
            self.assertEqual(self.exr(), before)
            self.save_scene(BALL, write_in_place)
            w.picture()
            self.assertEqual(self.exr(), before)

    def test_scene_and_shader_at_once_are_one_version(self):
        with self.watch() as w:
            w.picture()
            self.edit("shade.glsl", SHADE, HALF)
            self.save_scene(BALL | {"background": [1, 1, 1]})
            w.picture()
            told = w.figures()
            self.assertEqual((told["changed"], told["scene_changed"]), (["shade.glsl"], True), w)
            self.assert_shows_the_sources(w)
            w.stays_quiet(0.5)

    def test_a_mesh_that_changes(self):
        self.path("meshes").mkdir()
        obj = self.path("meshes/shape.obj")
        obj.write_text(OBJ)
        self.write_scene(MESH)
        with self.watch() as w:
            w.picture()
            before = self.exr()
            write_and_rename(obj, OBJ.replace("v 0 1 0", "v 0 0.5 0").encode())
            w.picture()
            self.assert_shows_the_sources(w)
            smaller = self.exr()
            self.assertNotEqual(smaller, before)
            write_in_place(obj, OBJ.replace("f 1 2 3", "f 1 2 4").encode())
            event = w.refused()
            self.assertEqual(event["step"], "scene")
            self.assert_diagnosis(w, event, "shape.obj", 4)
            self.assertEqual(self.exr(), smaller)
            obj.unlink()
            w.refused()
            write_in_place(obj, OBJ.encode())
            w.picture()
            self.assertEqual(self.exr(), before)

    def test_a_mesh_that_is_missing_at_the_start(self):
        self.write_scene(MESH)
        with self.watch() as w:
            self.assertIsNone(w.refused()["last_good"], w)
            self.path("meshes").mkdir()
            write_in_place(self.path("meshes/shape.obj"), OBJ.encode())
            w.picture()
            self.assert_shows_the_sources(w)

    def test_a_scene_of_another_size(self):
        with self.watch() as w:
            w.picture()
            self.save_scene(BALL | {"width": 33, "height": 17})
            w.picture()
            self.assertIsNone(w.figures()["changed_pixels"], w)
            self.assertEqual(png_size(self.path("out.png")), (33, 17))
            self.assert_shows_the_sources(w)

    def test_other_features_of_the_scene_are_other_code(self):
        glass = json.loads(json.dumps(BALL))
        glass["depth"] = 4
        glass["materials"]["clay"].update(transmit=0.8, ior=1.5, reflect=0.1)
        with self.watch() as w:
            w.picture()
            self.save_scene(glass)
            w.picture()
            self.assertGreater(w.figures()["rays"]["refracted"], 0, w)
            self.assert_shows_the_sources(w)

    def test_a_newer_save_interrupts_a_long_render(self):
        with self.watch("--samples", "20") as w:
            w.picture()
            before = self.exr()
            self.save_scene(LARGE)
            coarse = w.wait("coarse", version=2)
            self.assertTrue(Exr(self.path("out.exr")).attributes["turner:coarse"])
            started = time.monotonic()
            self.save_scene(BALL)
            w.wait("superseded", version=2)
            w.version = 2
            self.assertLess(w.picture()["at"] - started, 3, w)
            self.assertEqual(self.exr(), before)
            # A wrong one: the coarse picture of what was interrupted does not stay.
            self.save_scene(LARGE)
            w.wait("coarse", version=4)
            self.save_scene("{")
            w.wait("superseded", version=4)
            w.version = 4
            w.refused()
            self.assertEqual(self.exr(), before)

    def test_ctrl_c_during_a_long_render_leaves_the_last_good_picture(self):
        with self.watch("--samples", "20") as w:
            w.picture()
            before = self.exr()
            self.save_scene(LARGE)
            w.wait("coarse", version=2)
            self.assertLess(w.interrupt(), 2)
            self.assertEqual(self.exr(), before)
            self.assertEqual(w.events[-1]["version"], 1)

    def test_options_of_render_are_those_of_watch(self):
        options = ["--width", "40", "--height", "30", "--samples", "2", "--sampler", "jitter", "--seed", "3", "--crop", "3,4,30,20"]
        with self.watch(*options) as w:
            w.picture()
            self.assert_shows_the_sources(w, *options)
            self.save_scene(BALL | {"background": [1, 1, 1]})
            w.picture()
            self.assert_shows_the_sources(w, *options)


# --- what is told ---------------------------------------------------------------------------------------------------


class Figures(Session):
    def test_figures_of_a_change_with_a_known_effect(self):
        with self.watch() as w:
            w.picture()
            first = w.figures()
            self.assertEqual(first["last_good"], None)
            self.assertEqual(first["rays"]["eye"], 64 * 48)
            self.assertLess(w.wait("reference", version=1)["to_reference"]["rmse"], 1e-5)
            before = Exr(self.path("out.exr"))
            self.edit("shade.glsl", SHADE, SHADE.replace("E", "0.375 * E", 1))  # no other test has compiled it
            w.picture()
            told = w.figures()
            after = Exr(self.path("out.exr"))
            differences = [abs(a - b) for a, b in zip(before.values(), after.values())]
            lit = sum(before.pixel(x, y) != after.pixel(x, y) for x in range(64) for y in range(48))
            self.assertEqual(told["changed_pixels"], lit, w)
            self.assertAlmostEqual(told["to_last_good"]["max"], max(differences), 6)
            rms = (sum(d * d for d in differences) / len(differences)) ** 0.5
            self.assertAlmostEqual(told["to_last_good"]["rmse"], rms, 6)
            self.assertAlmostEqual(told["to_reference"]["rmse"], rms, 4)
            self.assertEqual(set(told["rays_change"].values()), {0})
            self.assertGreater(told["spirv"]["added"], 0)
            self.assertTrue(told["trace"]["interleaved"], w)
            self.assertGreater(told["trace"]["ratio"], 0)
            for name in ("glslang", "optimiser", "check", "pipeline"):
                self.assertGreater(told["seconds"][name], 0, name)

    def test_rays_that_are_no_longer_cast(self):
        with self.watch() as w:
            w.picture()
            shadow = w.figures()["rays"]["shadow"]
            self.assertGreater(shadow, 0)
            self.edit("whitted.comp", "bool faces = facesLight(surface, xyz(position));", "bool faces = false;")
            w.picture()
            self.assertEqual(w.figures()["rays_change"]["shadow"], -shadow, w)

    def test_twice_the_work_takes_longer(self):
        """A picture that is large enough for times to mean something."""
        with self.watch("--width", "400", "--height", "300", "--samples", "2") as w:
            w.picture()
            w.figures()
            work = "for (int i = 0; i < 60; ++i) E = fract(E * 1.37 + 0.01 * sin(E));\n  "
            self.edit("whitted.comp", MAIN, MAIN + " vec3 E = vec3(gl_WorkGroupID) + float(frameInMemory.background.w); " + work + "if (E.x == 7.0) return;")
            w.picture()
            self.assertGreater(w.figures()["trace"]["ratio"], 1.05, w)

    def test_lines_for_people_are_aligned(self):
        with self.watch(json_lines=False) as w:
            self.assertTrue(wait_until(lambda: re.search(r"^version 1: in out.exr, out.png after \d+\.\d\d s", w.out, re.M)), w)
            self.assertTrue(wait_until(lambda: re.search("^  reference ", w.out, re.M), TIMEOUT), w)
            self.edit("shade.glsl", SHADE, HALF)
            told = lambda: w.out.partition("version 2, shade.glsl changed")[2]
            self.assertTrue(wait_until(lambda: "SPIR-V" in told(), TIMEOUT), w)
            lines = told().splitlines()[1:]
            self.assertEqual([line.split()[0] for line in lines], ["compile", "trace", "picture", "reference", "rays", "SPIR-V"], w)
            columns = {len(re.match(r"  \S+ +", line)[0]) for line in lines}
            self.assertEqual(len(columns), 1, w)
            self.assertRegex(told(), r"\n  picture +\d+ pixels changed \(\d+ %\), rms \S+, max \S+\n")
            line = self.edit("shade.glsl", HALF, "return E + ;")
            self.assert_gcc(w, "shade.glsl", line, "syntax error")
            self.assertTrue(wait_until(lambda: "stays that of version 2" in w.out), w)
            self.edit("shade.glsl", "return E + ;", SHADE)
            self.assertTrue(wait_until(lambda: "version 4, shade.glsl changed" in w.out, TIMEOUT), w)

    def test_quiet_prints_only_errors(self):
        with self.watch("--quiet", json_lines=False) as w:
            self.assertTrue(wait_until(self.path("out.exr").exists, TIMEOUT), w)
            self.edit("shade.glsl", SHADE, "return E + ;")
            w.wait_for_error("syntax error")
            self.assertEqual(w.out, "")


class Kept(Session):
    def test_each_version_is_kept_whole(self):
        with self.watch("--keep", "kept") as w:
            w.picture()
            w.figures()
            w.wait("reference")
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()
            self.assertEqual(w.figures()["kept"], "kept/0002", w)
            self.edit("shade.glsl", HALF, "return wrong;")
            w.refused()
            self.edit("shade.glsl", "return wrong;", SHADE)
            w.picture()
            w.figures()
        self.assertEqual(sorted(p.name for p in self.path("kept").iterdir()), ["0001", "0002", "0004"])
        with self.watch("--keep", "kept") as w:
            w.version = 4
            w.picture()
            w.figures()
        self.assertEqual(sorted(p.name for p in self.path("kept").iterdir()), ["0001", "0002", "0004", "0005"])
        for number in ("0001", "0002", "0004", "0005"):
            kept = self.path("kept") / number
            self.assertEqual(sorted(p.name for p in kept.iterdir()), ["figures.json", "picture.exr", "scene", "shaders"])
            self.assertEqual(json.loads((kept / "figures.json").read_text())["version"], int(number))
            self.assertEqual((kept / "picture.exr").read_bytes(), self.rendered(shaders=kept / "shaders"), number)
        self.assertIsNotNone(json.loads(self.path("kept/0001/figures.json").read_text())["to_reference"])
        self.assertIn("0.5 * E", self.path("kept/0002/shaders/shade.glsl").read_text())

    def test_a_folder_that_cannot_be_written_is_told(self):
        self.path("kept").mkdir()
        with self.watch("--keep", "kept", preexec_fn=without_superpowers) as w:
            w.picture()
            w.figures()
            w.wait("reference")  # it changes the figures once more
            shutil.rmtree(self.path("kept"))
            self.path("kept").write_text("a file")
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()
            w.wait("trouble", version=2)
            self.path("kept").unlink()
            self.edit("shade.glsl", HALF, SHADE)
            w.picture()
            self.assertEqual(w.figures()["kept"], "kept/0003", w)


# --- processes and files ----------------------------------------------------------------------------------------------


class Survival(Session):
    def test_a_renderer_that_dies_while_it_waits(self):
        with self.watch() as w:
            w.picture()
            w.figures()
            w.wait("reference")
            for number, (old, new) in ((signal.SIGKILL, (SHADE, HALF)), (signal.SIGSEGV, (HALF, SHADE))):
                os.kill(w.worker(), number)
                time.sleep(0.1)
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
                self.assertIn(f"signal {int(number)}", event["diagnoses"][0]["message"])
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
            self.edit("shade.glsl", HALF, SHADE)
            w.picture(seconds=20)
            self.assertEqual(self.exr(), before)
            os.kill(w.worker(), signal.SIGSTOP)
            self.edit("shade.glsl", SHADE, HALF)
            time.sleep(0.5)
            self.assertLess(w.interrupt(), 2)

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


class Outputs(Session):
    def test_a_deleted_picture_comes_back_with_the_next_version(self):
        with self.watch() as w:
            w.picture()
            self.path("out.exr").unlink()
            self.path("out.png").unlink()
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()
            self.assert_shows_the_sources(w)
            self.assertEqual(png_size(self.path("out.png")), (64, 48))

    def test_the_picture_is_replaced_at_once(self):
        """A reader that looks all the time always sees a whole picture; who has the old one open keeps it."""
        with self.watch() as w:
            w.picture()
            before = self.exr()
            with open(self.path("out.exr"), "rb") as old:
                stop = threading.Event()
                broken = []

                def look():
                    while not stop.is_set():
                        try:
                            Exr(self.path("out.exr"))
                            png_size(self.path("out.png"))
                        except Exception as fault:
                            broken.append(fault)

                reader = threading.Thread(target=look)
                reader.start()
                for old_text, new_text in ((SHADE, HALF), (HALF, SHADE), (SHADE, "return E;"), ("return E;", SHADE)):
                    self.edit("shade.glsl", old_text, new_text)
                    w.picture()
                stop.set()
                reader.join()
                self.assertEqual(broken, [])
                self.assertEqual(old.read(), before)

    def test_a_folder_that_is_gone_or_closed_is_told(self):
        self.path("there").mkdir()
        with self.watch(outputs=("there/out.exr", "out.exr"), preexec_fn=without_superpowers) as w:
            w.picture()
            os.rename(self.path("there"), self.path("elsewhere"))
            self.edit("shade.glsl", SHADE, HALF)
            w.picture()
            trouble = w.wait("trouble", version=2)
            self.assertIn("there/out.exr", trouble["diagnoses"][0]["file"], w)
            self.assert_shows_the_sources(w)  # the other output
            os.rename(self.path("elsewhere"), self.path("there"))
            self.edit("shade.glsl", HALF, SHADE)
            w.picture()
            w.figures()
            self.assertEqual(self.path("there/out.exr").read_bytes(), self.exr())
            self.path("there").chmod(0o555)
            try:
                if not modes_bind(self.path("there")):
                    return say_not_possible("a folder that is closed to its owner")
                self.edit("shade.glsl", SHADE, HALF)
                w.picture()
                w.wait("trouble", version=w.version)
            finally:
                self.path("there").chmod(0o755)
            self.edit("shade.glsl", HALF, SHADE)
            w.picture()
            self.assertEqual(self.path("there/out.exr").read_bytes(), self.exr())

    def test_sources_that_may_not_be_read(self):
        with self.watch(preexec_fn=without_superpowers) as w:
            w.picture()
            before = self.exr()
            self.source("shade.glsl").chmod(0)
            try:
                if os.geteuid() == 0 and w.wait("refused", seconds=2, must=False) is None:
                    return say_not_possible("a file that is closed to its owner")
                w.refused()
            finally:
                self.source("shade.glsl").chmod(0o644)
            w.wait_for_error("shade.glsl")
            w.picture()
            self.assertEqual(self.exr(), before)


class Mistakes(Session):
    def refuse(self, *args, says):
        run = subprocess.run(
            [str(PROGRAM), "watch", *map(str, args)],
            cwd=self.folder,
            env=self.environment(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
        )
        self.assertEqual(run.returncode, 2, run)
        self.assertIn(says, run.stderr)
        self.assertEqual(self.temporary_files(), [])

    def test_of_the_command_line_end_it_at_once(self):
        shaders = ["--shaders", "kernel"]
        self.refuse("nowhere.json", *shaders, says="nowhere.json")
        self.refuse("scene.json", "--shaders", "nowhere", says="nowhere")
        self.refuse("scene.json", *shaders, "-o", "scene.json", says="scene.json")
        self.refuse("scene.json", *shaders, "-o", "no/folder.exr", says="no/folder.exr")
        self.refuse("scene.json", *shaders, "--timeout", "0", says="--timeout")
        self.refuse("scene.json", *shaders, "--timeout", "nan", says="--timeout")
        self.refuse("scene.json", *shaders, "--keep", "scene.json", says="scene.json")
        self.refuse("scene.json", *shaders, "--device", "no such device", says="no such device")
        self.refuse("scene.json", *shaders, "--width", "0", says="--width")

    def test_the_copy_of_the_shaders(self):
        for name in ("kernel", "scene.json"):
            run = subprocess.run([str(PROGRAM), "shaders", "--copy", name], cwd=self.folder, env=self.environment(), capture_output=True, text=True)
            self.assertEqual(run.returncode, 2, run)
            self.assertIn(name, run.stderr)
        for path in sorted((ROOT / "shaders").iterdir()):
            self.assertEqual(self.source(path.name).read_bytes(), path.read_bytes())


# --- figures of the program itself ------------------------------------------------------------------------------------


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


# --- random edits -------------------------------------------------------------------------------------------------------

TOKEN = re.compile(rb"[A-Za-z_]\w*|\.?\d[\w.]*|[^\w\s]")
LOOPS = [b"while (true) {}", b"for (;;) { status.limiter += 0u; }", b"for (uint i = 0u; i < 70000u; ++i) frame.media.x ^= i;"]


class Mutator:
    """Makes a wrong text of a right one, in one of many ways."""

    def __init__(self, seed):
        self.chance = random.Random(seed)
        self.ways = [
            self.delete_token,
            self.swap_tokens,
            self.change_token,
            self.change_token,
            self.change_token,
            self.change_number,
            self.change_number,
            self.duplicate_line,
            self.delete_line,
            self.move_line,
            self.insert_loop,
            self.cut,
            self.insert_bytes,
            self.insert_comment,
        ]

    def mutate(self, text):
        way = self.chance.choice(self.ways)
        return way.__name__, way(text)

    def token(self, text, wanted=TOKEN):
        found = list(wanted.finditer(text))
        return self.chance.choice(found) if found else re.match(b"", text)

    def replace(self, text, match, new):
        return text[: match.start()] + new + text[match.end() :]

    def delete_token(self, text):
        return self.replace(text, self.token(text), b"")

    def swap_tokens(self, text):
        a, b = sorted((self.token(text), self.token(text)), key=lambda match: match.start())
        if a.end() > b.start():
            return text
        return self.replace(self.replace(text, b, a[0]), a, b[0])

    def change_token(self, text):
        """Into another of its kind, so that much of it compiles."""
        old = self.token(text)
        kind = next(kind for kind in (rb"[A-Za-z_]\w*", rb"\.?\d[\w.]*", rb"") if re.match(kind, old[0]))
        kind = kind if kind else rb"[-+*/<>&|^=]"
        return self.replace(text, old, self.token(text, re.compile(kind))[0])

    def change_number(self, text):
        new = self.chance.choice([b"0", b"1", b"2u", b"0u", b"-1", b"0.5", b"1e30", b"0.0", b"64u", b"0xffffffffu"])
        return self.replace(text, self.token(text, re.compile(rb"\b\d[\w.]*")), new)

    def lines(self, text):
        lines = text.split(b"\n")
        return lines, self.chance.randrange(len(lines))

    def duplicate_line(self, text):
        lines, i = self.lines(text)
        return b"\n".join(lines[: i + 1] + lines[i:])

    def delete_line(self, text):
        lines, i = self.lines(text)
        return b"\n".join(lines[:i] + lines[i + 1 :])

    def move_line(self, text):
        lines, i = self.lines(text)
        lines.insert(self.chance.randrange(len(lines)), lines.pop(i))
        return b"\n".join(lines)

    def insert_loop(self, text):
        at = self.token(text, re.compile(rb"[;{]\n")).end()
        return text[:at] + self.chance.choice(LOOPS) + text[at:]

    def cut(self, text):
        return text[: self.chance.randrange(len(text) + 1)]

    def insert_bytes(self, text):
        at = self.chance.randrange(len(text) + 1)
        return text[:at] + self.chance.randbytes(self.chance.randrange(1, 40)) + text[at:]

    def insert_comment(self, text):
        at = self.token(text, re.compile(rb"\n")).end()
        return text[:at] + b"// %d\n" % self.chance.randrange(10**9) + text[at:]


class Mutations(Session):
    VALIDATION = "0"
    SEED = 1
    RESTORES = 20  # edits after which the originals come back
    GROWTH = 0.02  # of the watcher's memory

    def setUp(self):
        super().setUp()
        self.original = {path.name: path.read_bytes() for path in sorted(self.path("kernel").iterdir())}
        self.mutator = Mutator(self.SEED)
        self.chance = self.mutator.chance
        self.outcomes = collections.Counter()
        self.memory = []  # RSS, its anonymous part and PSS of the watcher, PSS of all else; at rest

    def mutate_one(self):
        """Saves one file with a mutation of its original, or of what it is now."""
        name = self.chance.choice(list(self.original))
        now = self.source(name).read_bytes()
        way, text = self.mutator.mutate(now if self.chance.random() < 0.2 else self.original[name])
        self.save(name, text, self.chance.choice(EDITORS))
        return f"{way} in {name}", text != now

    def restore(self, names):
        changed = [name for name in names if self.source(name).read_bytes() != self.original[name]]
        for name in changed:
            self.save(name, self.original[name], self.chance.choice(EDITORS))
        return bool(changed)

    def check_picture(self, w, event, what):
        """Whole, and that of the last good version."""
        if event["event"] == "picture":
            self.good, self.good_version = self.exr(), w.version
            self.assertEqual(Exr(self.path("out.exr")).width, BALL["width"], what)
        else:
            self.assertEqual(self.exr(), self.good, f"{what}: the last good picture is gone\n{event}")
            self.assertTrue(event["diagnoses"], what)
        self.assertEqual(png_size(self.path("out.png")), (BALL["width"], BALL["height"]), what)
        outcome = event["event"] if event["event"] == "picture" else f"refused in {event['step']}"
        self.outcomes[outcome + (", endless" if event.get("endless") else "")] += 1

    def take_memory(self, w):
        watcher, *others = tree_of(w.process.pid)
        self.memory.append((*memory_of(watcher), sum(memory_of(process)[2] for process in others)))

    def test_random_edits_in_a_row_hurt_nothing(self):
        started = time.monotonic()
        with self.watch("--timeout", "2") as w:
            w.picture()
            w.figures()
            w.wait("reference")
            original = self.good = self.exr()
            self.good_version = w.version
            for edit in range(1, MUTATIONS + 1):
                # Mostly of one file at a time, sometimes of what was mutated before.
                stacked, interrupted = self.chance.random() < 0.3, self.chance.random() < 0.1
                if interrupted and self.good_version == w.version:
                    w.figures()  # nothing else is in work that could unite two saves
                what, changed = self.mutate_one()
                what = f"edit {edit}, seed {self.SEED}: {what}"
                if not stacked:
                    name = what.rpartition(" ")[2]
                    changed |= self.restore(n for n in self.original if n != name)
                if changed and interrupted:
                    # A newer save comes in between.
                    version = w.version + 1
                    time.sleep(self.chance.uniform(0.3, 1))
                    # Of the one file that is always among the sources: the mutation may have dropped an include.
                    self.save("whitted.comp", self.source("whitted.comp").read_bytes() + b"\n// %d\n" % edit)
                    event = w.wait("picture", "refused", version=version + 1, seconds=10, must=False)
                    if not event:
                        # Where the disk holds the watcher up for as long as between the two saves, they are one to it.
                        self.outcomes["two saves seen as one"] += 1
                        self.save("whitted.comp", self.source("whitted.comp").read_bytes() + b"\n// once more\n")
                        event = w.wait("picture", "refused", version=version + 1)
                    w.version = version + 1
                    self.check_picture(w, event, what)
                elif changed:
                    self.check_picture(w, w.outcome(), what)
                if edit % self.RESTORES == 0 or edit == MUTATIONS:
                    if self.restore(self.original):
                        w.picture()
                        w.figures()
                        self.good_version = w.version
                    self.assertEqual(self.exr(), original, what)
                    self.good = original
                    self.take_memory(w)
                    if edit % 100 == 0:
                        print(f"{edit}: {time.monotonic() - started:.0f} s, {self.memory[-1]}", file=sys.stderr)
            self.report(time.monotonic() - started)

    def report(self, seconds):
        # Single values vary by some hundred KiB with what is held at the moment: medians, after a warm-up and at the end.
        first = min(len(self.memory) - 1, max(1, MUTATIONS // 20 // self.RESTORES))
        window = max(1, min(5, len(self.memory) // 4))
        middle = lambda values: [int(statistics.median(column)) for column in zip(*values)]
        rss, *parts = middle(self.memory[first : first + window])
        last_rss, *last_parts = middle(self.memory[-window:])
        told = ", ".join(f"{name} {count}" for name, count in sorted(self.outcomes.items()))
        print(
            f"\n{MUTATIONS} edits in {seconds:.0f} s: {told}\n"
            f"watcher: RSS {rss} -> {last_rss} KiB ({last_rss / rss - 1:+.2%}); "
            f"of it anonymous, its PSS, that of its children: {parts} -> {last_parts} KiB",
            file=sys.stderr,
        )
        self.assertLessEqual(last_rss, rss * (1 + self.GROWTH), "the watcher's memory grows")
        self.assertLessEqual(self.outcomes["two saves seen as one"], 1 + MUTATIONS // 200, "saves are lost")


def main():
    global PROGRAM, ROOT, MUTATIONS, CACHES
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="the program to test")
    parser.add_argument("--root", type=pathlib.Path, required=True, help="the folder of Turner's sources")
    parser.add_argument("--mutations", type=int, default=MUTATIONS, help="edits of the test of random edits")
    options, rest = parser.parse_known_args()
    PROGRAM, ROOT, MUTATIONS = options.program.resolve(), options.root.resolve(), options.mutations
    for path in (PROGRAM, ROOT / "scenes/spheres.json", ROOT / "shaders"):
        if not path.exists():
            parser.error(f"{path} does not exist")
    with tempfile.TemporaryDirectory(prefix="turner-caches-") as CACHES:
        unittest.main(argv=[sys.argv[0], *rest])


if __name__ == "__main__":
    main()
