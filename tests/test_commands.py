#!/usr/bin/env python3
"""Drives the program as its users do: real commands, real files, exit codes and messages, interruptions and full disks.

    python3 test_commands.py --program build/turner --scenes scenes [options of unittest]

Every run is under the Vulkan validation layers. What every run must keep is checked by Command.check_sane: no crash, no
complaint of a sanitizer. What a failing run must keep is checked by Command.refuse: its exit code, one line on stderr
for each fault, and a folder that is byte for byte as it was. Whether pictures are right is other tests' business.
"""

import argparse
import array
import contextlib
import ctypes
import itertools
import json
import math
import os
import pathlib
import pty
import re
import resource
import select
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

TESTS = pathlib.Path(__file__).resolve().parent
PROGRAM = None  # set by main()
SCENES = None

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130

# Nothing here takes longer than a second or two; a sanitizer on a busy machine is slower by far.
TIMEOUT = 180  # seconds
# Ctrl-C must be noticed within a few seconds.
PATIENCE = 10  # seconds

SMALL = ["--width", "64", "--height", "48"]
TINY = ["--width", "8", "--height", "8"]
# Minutes of work: a fault that is found only after it runs into the timeout.
LONG = ["--width", "8000", "--height", "8000", "--samples", "16"]

SPHERE = """{
  "width": 64, "height": 48, "background": [0.25, 0.5, 1],
  "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "fov": 40 },
  "lights": [ { "position": [3, 5, 4] } ],
  "materials": { "clay": { "diffuse": [0.7, 0.6, 0.5], "reflect": 0.2 } },
  "spheres": [ { "center": [0.1, 0.2, 0], "radius": 1.1, "material": "clay" } ]
}
"""

# A matte floor under a mirror ball.
NFF = """# a ball on a floor
v
from 0 1.5 5
at 0 0.6 0
up 0 1 0
angle 40
hither 1
resolution 64 48
b 0.1 0.2 0.3
l 3 5 4
f 0.8 0.7 0.6 0.5 0.5 20 0 1
s 0 1 0 1
f 0.3 0.5 0.2 1 0 1 0 1
p 4
-4 0 4
4 0 4
4 0 -4
-4 0 -4
"""

OBJ = """v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3
"""

MESH_SCENE = '{ "materials": { "m": {} }, "meshes": [ { "file": "shape.obj", "material": "m" } ] }\n'

# Where a message says that it is one; --max-error: is an option.
ERROR = re.compile(r"(?<![-\w])error:")

# Signs that a run ended in a way nobody wrote a message for.
CRASH = re.compile(
    r"terminate called|what\(\):|Sanitizer|runtime error:|Assertion|core dumped|Segmentation|VUID-|Traceback|\?\?:0"
)


# --- pictures -------------------------------------------------------------------------------------------------------


class Exr:
    """An EXR file of ZIP or uncompressed scanlines with 32-bit channels: windows, attributes and pixels."""

    def __init__(self, path):
        self.bytes = pathlib.Path(path).read_bytes()
        magic, version = struct.unpack_from("<II", self.bytes)
        if magic != 20000630 or version & 0xFF != 2:
            raise ValueError(f"{path} is not an EXR file")
        at = 8
        self.attributes = {}
        while self.bytes[at] != 0:
            name, at = self._text(at)
            _, at = self._text(at)
            (size,) = struct.unpack_from("<I", self.bytes, at)
            self.attributes[name] = self.bytes[at + 4 : at + 4 + size]
            at += 4 + size
        self.data = struct.unpack("<4i", self.attributes["dataWindow"])  # first and last column and row
        self.display = struct.unpack("<4i", self.attributes["displayWindow"])
        self.width = self.data[2] - self.data[0] + 1
        self.height = self.data[3] - self.data[1] + 1
        self.rows = {}  # by y: three arrays of floats, for R, G, B
        self._read_blocks(at + 1)

    def _text(self, at):
        end = self.bytes.index(b"\0", at)
        return self.bytes[at:end].decode(), end + 1

    def _read_blocks(self, table):
        compression = self.attributes["compression"][0]
        lines = {0: 1, 2: 1, 3: 16}[compression]  # of a block, for no compression, ZIPS and ZIP
        blocks = (self.height + lines - 1) // lines
        for offset in struct.unpack_from(f"<{blocks}Q", self.bytes, table):
            y, size = struct.unpack_from("<ii", self.bytes, offset)
            packed = self.bytes[offset + 8 : offset + 8 + size]
            count = min(lines, self.data[3] + 1 - y)
            raw_size = count * 3 * 4 * self.width
            self._read_lines(y, count, packed if size == raw_size else unzip(packed))
        if len(self.rows) != self.height:
            raise ValueError("rows are missing")

    def _read_lines(self, y, count, raw):
        # A line holds its channels one after the other, in the order of their names: B, G, R.
        floats = array.array("f", raw)
        if sys.byteorder == "big":
            floats.byteswap()
        for line in range(count):
            start = line * 3 * self.width
            b, g, r = (floats[start + c * self.width : start + (c + 1) * self.width] for c in range(3))
            self.rows[y + line] = (r, g, b)

    def pixel(self, x, y):
        return tuple(channel[x - self.data[0]] for channel in self.rows[y])

    def values(self):
        """All values in a fixed order; equal pictures have equal values."""
        return [value for y in sorted(self.rows) for channel in self.rows[y] for value in channel]

    def bits(self):
        return b"".join(channel.tobytes() for y in sorted(self.rows) for channel in self.rows[y])

    def part(self, x0, y0, x1, y1):
        """The bits of a part of the picture."""
        left = self.data[0]
        return b"".join(c[x0 - left : x1 - left].tobytes() for y in range(y0, y1) for c in self.rows[y])


def unzip(packed):
    """Undoes OpenEXR's ZIP: deflate, then differences of neighbours, then even and odd bytes apart."""
    differences = zlib.decompress(packed)
    data = bytes(itertools.accumulate(differences, lambda last, d: (last + d - 128) & 0xFF))
    half = (len(data) + 1) // 2
    raw = bytearray(len(data))
    raw[0::2] = data[:half]
    raw[1::2] = data[half:]
    return bytes(raw)


def write_exr(path, width, height, pixels):
    """An uncompressed EXR; `pixels` are (r, g, b), row by row."""

    def attribute(name, kind, value):
        return f"{name}\0{kind}\0".encode() + struct.pack("<I", len(value)) + value

    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<i4xii", 2, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    header = struct.pack("<II", 20000630, 2)
    header += attribute("channels", "chlist", channels) + attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    size = 12 * width
    first = len(header) + 8 * height
    table = b"".join(struct.pack("<Q", first + y * (8 + size)) for y in range(height))
    lines = b""
    for y in range(height):
        row = pixels[y * width : (y + 1) * width]
        lines += struct.pack("<ii", y, size)
        lines += b"".join(struct.pack(f"<{width}f", *(pixel[c] for pixel in row)) for c in (2, 1, 0))
    pathlib.Path(path).write_bytes(header + table + lines)


def png_size(path):
    data = pathlib.Path(path).read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n" or data[-8:-4] != b"IEND":
        raise ValueError(f"{path} is not a whole PNG file")
    return struct.unpack_from(">II", data, 16)


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


# --- runs -----------------------------------------------------------------------------------------------------------


class Run:
    def __init__(self, args, code, out, err, seconds):
        self.args, self.code, self.out, self.err, self.seconds = args, code, out, err, seconds

    def __str__(self):
        end = f"exit code {self.code} after {self.seconds:.2f} s"
        return f"$ turner {' '.join(self.args)}\n{end}\n--- stdout\n{self.out}--- stderr\n{self.err}"


def without_superpowers():
    """Between fork and exec: takes from a superuser the right to write where modes forbid it."""
    if os.geteuid() != 0:
        return
    PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH = 24, 1, 2
    libc = ctypes.CDLL(None)
    for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
        libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)


def modes_bind(folder):
    """Whether without_superpowers() does its work here: a folder of mode 0555 is not writable."""
    probe = subprocess.run(["/usr/bin/test", "-w", str(folder)], preexec_fn=without_superpowers)
    return probe.returncode != 0


def say_not_possible(what):
    print(f"\nNOT POSSIBLE on this machine: {what}", file=sys.stderr)


def remove_comments(text):
    return re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*', lambda m: m[1] or "", text)


class Command(unittest.TestCase):
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

    def run_turner(self, *args, env=None, timeout=TIMEOUT, stdout=subprocess.PIPE, **options):
        args = [str(arg) for arg in args]
        start = time.monotonic()
        process = subprocess.run(
            [str(PROGRAM), *args],
            cwd=self.folder,
            env=self.environment(env),
            stdin=subprocess.DEVNULL,
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
        self.assertIn(run.code, (DONE, FAILED, WRONG_INPUT, INTERRUPTED), run)

    def do(self, *args, **options):
        """Runs what must succeed, without a word on stderr but progress."""
        run = self.run_turner(*args, **options)
        self.assertEqual(run.code, DONE, run)
        noise = [line for line in run.err.splitlines() if "Msamples/s" not in line]
        self.assertEqual(noise, [], run)
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
        lines = run.err.splitlines()
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


# --- render ---------------------------------------------------------------------------------------------------------


class Render(Command):
    def test_without_o_writes_the_scenes_name_with_exr_here(self):
        self.write("there/my.scene.json", SPHERE)
        run = self.do("render", "there/my.scene.json")
        self.assertEqual(self.files(), ["my.scene.exr", "there/my.scene.json"], run)
        self.assertEqual(Exr(self.path("my.scene.exr")).display, (0, 0, 63, 47))

    def test_names_with_spaces_and_umlauts_are_names(self):
        self.write("Bild ü 1.json", SPHERE)
        self.do("render", "Bild ü 1.json", "--backend", "reference", "-o", "ä ö.exr")
        self.do("render", "Bild ü 1.json", "--backend", "reference")
        self.assertEqual(self.files(), sorted(["Bild ü 1.exr", "Bild ü 1.json", "ä ö.exr"]))

    def test_says_which_device_it_chose(self):
        device = json.loads(self.do("devices", "--json").out)[0]["name"]
        run = self.do("render", self.write("scene.json", SPHERE), *TINY, "-o", "a.exr")
        if len(json.loads(self.do("devices", "--json").out)) == 1:
            self.assertIn(device, run.out)
        self.assertIn("device: ", run.out)

    def test_o_may_repeat_and_each_ending_has_its_format(self):
        scene = self.write("scene.json", SPHERE)
        self.do("render", scene, "-o", "a.exr", "-o", "b.png", "-o", "C.EXR")
        self.assertEqual(self.files(), ["C.EXR", "a.exr", "b.png", "scene.json"])
        self.assertEqual(self.path("a.exr").read_bytes(), self.path("C.EXR").read_bytes())
        self.assertEqual(png_size(self.path("b.png")), (64, 48))

    def test_o_may_stand_before_and_behind_the_scene(self):
        scene = self.write("scene.json", SPHERE)
        reference = ["--backend", "reference", "--quiet"]
        self.do("render", *reference, "-o", "a.exr", scene)
        self.do("render", *reference, "-o", "b.exr", scene, "-o", "c.png")
        self.do("render", *reference, "--output", "d.exr", scene, "--output=e.png", *TINY)
        self.assertEqual(self.files(), ["a.exr", "b.exr", "c.png", "d.exr", "e.png", "scene.json"])

    def test_one_o_takes_one_file(self):
        self.refuse("render", self.write("scene.json", SPHERE), *TINY, "-o", "a.exr", "b.exr", says="b.exr")

    def test_an_existing_file_is_replaced_whole(self):
        scene = self.write("scene.json", SPHERE)
        self.write("a.exr", b"x" * 1_000_000)
        self.do("render", scene, "-o", "a.exr", "--backend", "reference")
        self.assertEqual(Exr(self.path("a.exr")).width, 64)
        self.assertEqual(self.files(), ["a.exr", "scene.json"])

    def test_files_depend_on_scene_options_and_device_alone(self):
        scene = SCENES / "spheres.json"
        self.do("render", scene, *SMALL, "-o", "first.exr", "-o", "first.png")
        # Elsewhere, another time, otherwise talkative, with figures, without validation.
        self.write("elsewhere/spheres.json", scene.read_bytes())
        time.sleep(1.1)
        options = ["--quiet", "--stats", "stats.json", "-o", "second.exr", "-o", "second.png"]
        self.do("render", "elsewhere/spheres.json", *SMALL, *options, env={"TURNER_VALIDATION": "0"})
        for kind in ("exr", "png"):
            first, second = (self.path(f"{name}.{kind}").read_bytes() for name in ("first", "second"))
            self.assertEqual(first, second, kind)

    def test_files_of_the_reference_repeat_too(self):
        for name in ("first", "second"):
            self.do("render", SCENES / "spheres.json", *SMALL, "--backend", "reference", "-o", f"{name}.exr")
        self.assertEqual(self.path("first.exr").read_bytes(), self.path("second.exr").read_bytes())

    def test_tiles_and_work_groups_never_change_a_byte(self):
        whole = self.picture(SCENES / "spheres.json", *SMALL).bytes
        for cut in (["--tile", "8", "--work-group", "32"], ["--tile", "64", "--work-group", "8"]):
            self.assertEqual(self.picture(SCENES / "spheres.json", *SMALL, *cut).bytes, whole, cut)
        for cut in (["--tile", "8"], ["--work-group", "128"], ["--work-group", "256"]):
            self.assertEqual(self.picture(SCENES / "spheres.json", *SMALL, *cut).bytes, whole, cut)

    def test_a_crop_is_the_part_of_the_full_picture_bit_for_bit(self):
        window = (13, 7, 50, 41)
        crop = ["--crop", ",".join(map(str, window))]
        for options in (["--samples", "2", "--sampler", "jitter", "--seed", "3"], ["--backend", "reference"]):
            with self.subTest(options):
                whole = self.picture(SCENES / "spheres.json", *SMALL, *options)
                part = self.picture(SCENES / "spheres.json", *SMALL, *options, *crop)
                self.assertEqual(part.display, (0, 0, 63, 47))
                self.assertEqual(part.data, (13, 7, 49, 40))
                self.assertEqual(part.bits(), whole.part(*window))
                self.assertNotEqual(part.bits(), whole.part(12, 7, 49, 41))

    def test_quiet_prints_nothing(self):
        scene = self.write("no_lights.json", "{}")
        run = self.do("render", scene, *TINY, "--quiet", "--stats", "stats.json")
        self.assertEqual(run.out + run.err, "", run)
        run = self.do("render", scene, *TINY, "--quiet", "--backend", "reference")
        self.assertEqual(run.out + run.err, "", run)

    def test_a_scene_without_lights_is_black_and_says_so(self):
        scene = json.loads(SPHERE)
        del scene["lights"]
        run = self.do("render", self.write("dark.json", json.dumps(scene)))
        self.assertRegex(run.out, r"no lights")
        self.assertNotRegex(run.out, r"no objects|no camera")
        # Clay reflects a fifth of the background; all the rest of it is black.
        pixel = Exr(self.path("dark.exr")).pixel(32, 22)
        for value, expected in zip(pixel, (0.05, 0.1, 0.2)):
            self.assertAlmostEqual(value, expected, 5)

    def test_a_scene_without_objects_is_its_background_and_says_so(self):
        scene = json.loads(SPHERE)
        del scene["spheres"]
        for backend in ("shader", "reference"):
            run = self.do("render", self.write("bare.json", json.dumps(scene)), "--backend", backend)
            self.assertRegex(run.out, r"no objects")
            self.assertNotRegex(run.out, r"no lights|no camera")
            picture = Exr(self.path("bare.exr"))
            self.assertEqual({picture.pixel(x, y) for x in range(64) for y in range(48)}, {(0.25, 0.5, 1)})

    def test_a_scene_without_camera_shows_its_objects_and_says_so(self):
        scene = json.loads(SPHERE)
        del scene["camera"]
        run = self.do("render", self.write("unseen.json", json.dumps(scene)))
        self.assertRegex(run.out, r"no camera")
        self.assertNotRegex(run.out, r"no lights|no objects")
        picture = Exr(self.path("unseen.exr"))
        self.assertNotEqual(picture.pixel(32, 24), (0.25, 0.5, 1))
        self.assertEqual(picture.pixel(0, 0), (0.25, 0.5, 1))

    def test_the_empty_scene_renders(self):
        run = self.do("render", self.write("empty.json", "{}"), "--width", "1", "--height", "1")
        for what in ("no lights", "no objects", "no camera"):
            self.assertIn(what, run.out)
        self.assertEqual(Exr(self.path("empty.exr")).pixel(0, 0), (0, 0, 0))

    def test_the_reference_renders_the_same_picture(self):
        shader = self.picture(SCENES / "spheres.json", *SMALL, "--backend", "shader").values()
        reference = self.picture(SCENES / "spheres.json", *SMALL, "--backend", "reference").values()
        self.assertNotEqual(shader, reference)  # float32 is not double
        square = sum((a - b) ** 2 for a, b in zip(shader, reference)) / len(shader)
        self.assertLess(math.sqrt(square), 1e-3)

    def test_geometry_tells_the_reference_which_scene_to_trace(self):
        scene = json.loads(SPHERE)
        # Far from the eye's unit the rounding to float32 shows, and is small.
        scene["spheres"][0].update(center=[0.1 + 1e6, 0.2, 0])
        scene["camera"].update(eye=[1e6 + 0.7, 0.3, 5], target=[1e6, 0, 0])
        name = self.write("far.json", json.dumps(scene))
        reference = ["--backend", "reference", "--geometry"]
        default = self.picture(name, "--backend", "reference")
        exact = self.picture(name, *reference, "exact")
        rounded = self.picture(name, *reference, "rounded")
        self.assertEqual(default.bits(), exact.bits())
        self.assertNotEqual(exact.bits(), rounded.bits())
        worst = max(abs(a - b) for a, b in zip(exact.values(), rounded.values()))
        self.assertLess(worst, 0.5)

    def test_the_seed_moves_jittered_samples_and_only_those(self):
        scene = self.write("scene.json", SPHERE)
        jitter = ["--sampler", "jitter", "--seed"]
        for backend in (["--backend", "shader"], ["--backend", "reference"]):
            one = self.picture(scene, *backend, *jitter, "1")
            self.assertEqual(self.picture(scene, *backend, *jitter, "1").bytes, one.bytes)
            self.assertNotEqual(self.picture(scene, *backend, *jitter, "2").bits(), one.bits())
        default = self.picture(scene, *backend, "--sampler", "jitter")
        self.assertEqual(default.bits(), self.picture(scene, *backend, *jitter, "0").bits())
        grid = self.picture(scene, *backend)
        self.assertNotEqual(grid.bits(), one.bits())
        seeded = self.picture(scene, *backend, "--sampler", "grid", "--seed", "4294967295")
        self.assertEqual(seeded.bits(), grid.bits())

    def test_min_weight_drops_faint_rays(self):
        reference = [SCENES / "spheres.json", *SMALL, "--backend", "reference"]
        default = self.stats(*reference)["rays"]
        counts = {w: self.stats(*reference, "--min-weight", w)["rays"] for w in ("0", "0.1", "0.5", "1")}
        self.assertEqual(counts["0"], default)
        order = [counts[w]["reflected"] + counts[w]["refracted"] for w in ("0", "0.1", "0.5", "1")]
        self.assertEqual(order, sorted(order, reverse=True))
        self.assertEqual(len(set(order)), 4)
        self.assertEqual(order[-1], 0)  # nothing in the scene mirrors all light
        self.assertEqual(counts["1"]["eye"], 64 * 48)
        shader = self.stats(SCENES / "spheres.json", *SMALL, "--min-weight", "0.5")["rays"]
        self.assertAlmostEqual(shader["reflected"] / counts["0.5"]["reflected"], 1, delta=0.005)

    def test_depth_counts_the_levels_of_the_tree(self):
        scene = SCENES / "spheres.json"
        for backend in ("shader", "reference"):
            eye_only = self.stats(scene, *SMALL, "--backend", backend, "--depth", "1")["rays"]
            self.assertEqual((eye_only["reflected"], eye_only["refracted"]), (0, 0), backend)
            two = self.stats(scene, *SMALL, "--backend", backend, "--depth", "2")["rays"]
            self.assertGreater(two["reflected"], 0, backend)
            # On the second level there is at most one ray of each kind for each eye ray.
            self.assertLessEqual(max(two["reflected"], two["refracted"]), two["eye"], backend)
        self.do("render", scene, *TINY, "--depth", "64", "-o", "deep.exr")

    def test_width_and_height_override_the_scenes(self):
        scene = self.write("scene.json", SPHERE)
        for options, size in (
            ([], (64, 48)),
            (["--width", "33"], (33, 48)),
            (["--height", "17"], (64, 17)),
            (["--width=1", "--height=1"], (1, 1)),
        ):
            picture = self.picture(scene, *options, "--backend", "reference")
            self.assertEqual((picture.width, picture.height), size, options)
        picture = self.picture(scene, "--width", "33", "--height", "17")
        self.assertEqual((picture.width, picture.height), (33, 17))

    def test_without_sizes_a_picture_is_512_by_512(self):
        picture = self.picture(self.write("empty.json", "{}"), "--backend", "reference")
        self.assertEqual(picture.display, (0, 0, 511, 511))

    def test_four_samples_are_the_mean_of_a_picture_twice_as_large(self):
        scene = [SCENES / "spheres.json", "--backend", "reference"]
        fine = self.picture(*scene, "--width", "128", "--height", "96")
        coarse = self.picture(*scene, *SMALL, "--samples", "2")
        for y, x in itertools.product(range(48), range(64)):
            four = [fine.pixel(2 * x + i, 2 * y + j) for i in (0, 1) for j in (0, 1)]
            for c in range(3):
                self.assertAlmostEqual(coarse.pixel(x, y)[c], sum(p[c] for p in four) / 4, delta=2e-6)
        shader = self.picture(SCENES / "spheres.json", *SMALL, "--samples", "2").values()
        far = sum(abs(a - b) > 1e-3 for a, b in zip(shader, coarse.values()))
        self.assertLess(far / len(shader), 0.01)

    def test_256_samples_a_side_are_taken(self):
        one = [self.write("scene.json", SPHERE), "--width", "1", "--height", "1", "--samples", "256"]
        shader, reference = (self.picture(*one, "--backend", backend) for backend in ("shader", "reference"))
        for a, b in zip(shader.values(), reference.values()):
            self.assertAlmostEqual(a, b, delta=1e-3)
        self.assertEqual(self.stats(*one, "--backend", "reference")["rays"]["eye"], 256 * 256)

    def test_an_nff_scene_renders(self):
        run = self.do("render", self.write("ball.nff", NFF))
        self.assertNotIn("note:", run.out)
        picture = Exr(self.path("ball.exr"))
        self.assertEqual((picture.width, picture.height), (64, 48))
        for value, expected in zip(picture.pixel(0, 0), (0.1, 0.2, 0.3)):
            self.assertEqual(value, float32(expected))
        figures = self.figures("ball.nff")
        self.assertLess(figures["rmse"], 1e-3)

    def test_a_mesh_renders_from_another_folder(self):
        # The mesh lies beside the scene, not beside the caller.
        stats = self.stats(SCENES / "spot.json", *SMALL)
        self.assertEqual(stats["primitives"], {"spheres": 1, "triangles": 5858})

    def test_turners_own_scenes_are_found_from_everywhere(self):
        self.do("render", "scenes/spheres.json", *TINY, "--backend", "reference")
        self.assertEqual(self.files(), ["spheres.exr"])

    def test_a_scene_that_is_here_comes_before_turners_own(self):
        self.write("scenes/spheres.json", "{}")
        run = self.do("render", "scenes/spheres.json", *TINY, "--backend", "reference")
        self.assertIn("no objects", run.out)

    def test_shaders_may_be_elsewhere(self):
        shutil.copytree(SCENES.parent / "shaders", self.path("kernel"))
        scene = self.write("scene.json", SPHERE)
        self.assertEqual(self.picture(scene, "--shaders", "kernel").bytes, self.picture(scene).bytes)

    def test_a_part_of_a_gigantic_picture_renders(self):
        size = ["--width", "65536", "--height", "65536", "--crop", "32768,32768,32776,32776"]
        for backend in ("shader", "reference"):
            picture = self.picture(SCENES / "spheres.json", *size, "--backend", backend)
            self.assertEqual(picture.display, (0, 0, 65535, 65535))
            self.assertEqual(picture.data, (32768, 32768, 32775, 32775))

    def test_a_picture_one_pixel_high_renders(self):
        picture = self.picture(self.write("scene.json", SPHERE), "--width", "65536", "--height", "1")
        self.assertEqual(picture.data, (0, 0, 65535, 0))


# --- stats ----------------------------------------------------------------------------------------------------------


class Statistics(Command):
    KEYS = {
        "device": {"name": str, "driver": str, "type": str},
        "primitives": {"spheres": int, "triangles": int},
        "rays": {"eye": int, "reflected": int, "refracted": int, "shadow": int},
        "seconds": {k: float for k in ("load", "build", "compile", "upload", "trace", "readback", "total")},
    }

    def test_stats_have_the_promised_keys_and_consistent_figures(self):
        for backend in ("shader", "reference"):
            with self.subTest(backend):
                stats = self.stats(SCENES / "spheres.json", *SMALL, "--samples", "2", "--backend", backend)
                self.check_stats(stats, eye=64 * 48 * 4)

    def check_stats(self, stats, eye):
        self.assertIsInstance(stats["scene"], str)
        self.assertIn("spheres", stats["scene"])
        self.assertIsInstance(stats["options"], dict)
        for group, kinds in self.KEYS.items():
            self.assertLessEqual(set(kinds), set(stats[group]), group)
            for key, kind in kinds.items():
                value = stats[group][key]
                self.assertIsInstance(value, (int, float) if kind is float else kind, f"{group}.{key}")
                self.assertNotIsInstance(value, bool)
                if kind is not str:
                    self.assertGreaterEqual(value, 0, f"{group}.{key}")
                else:
                    self.assertNotEqual(value, "", f"{group}.{key}")
        self.assertEqual(stats["primitives"], {"spheres": 10, "triangles": 2})
        rays, seconds = stats["rays"], stats["seconds"]
        self.assertEqual(rays["eye"], eye)
        self.assertGreater(min(rays["reflected"], rays["refracted"], rays["shadow"]), 0)
        self.assertGreater(seconds["trace"], 0)
        parts = sum(seconds[k] for k in ("load", "build", "compile", "upload", "trace", "readback"))
        self.assertLessEqual(parts, seconds["total"] * 1.001)
        total = sum(rays[k] for k in ("eye", "reflected", "refracted", "shadow"))
        self.assertAlmostEqual(stats["mrays_per_second"] * seconds["trace"] * 1e6 / total, 1, 6)
        self.assertEqual(stats["options"]["samples"], 2)

    def test_the_reference_neither_compiles_nor_uploads_nor_reads_back(self):
        seconds = self.stats(SCENES / "spheres.json", *SMALL, "--backend", "reference")["seconds"]
        self.assertEqual([seconds[k] for k in ("compile", "upload", "readback")], [0, 0, 0])

    def test_the_shader_compiles_and_uploads_and_reads_back(self):
        seconds = self.stats(SCENES / "spheres.json", *SMALL)["seconds"]
        self.assertGreater(min(seconds[k] for k in ("compile", "upload", "readback")), 0)

    def test_shader_and_reference_count_the_same_rays(self):
        size = ["--width", "96", "--height", "54"]
        shader = self.stats(SCENES / "spheres.json", *size)["rays"]
        reference = self.stats(SCENES / "spheres.json", *size, "--backend", "reference")["rays"]
        self.assertEqual(shader["eye"], reference["eye"])
        for kind, count in reference.items():
            self.assertLessEqual(abs(shader[kind] - count), 0.0005 * count, f"{kind}: {shader[kind]} and {count}")

    def test_counts_do_not_depend_on_tiles_or_work_groups(self):
        scene = SCENES / "spheres.json"
        self.assertEqual(
            self.stats(scene, *SMALL, "--tile", "8", "--work-group", "32")["rays"], self.stats(scene, *SMALL)["rays"]
        )

    def test_a_crop_counts_its_own_rays(self):
        for backend in ("shader", "reference"):
            stats = self.stats(SCENES / "spheres.json", *SMALL, "--crop", "10,10,30,20", "--backend", backend)
            self.assertEqual(stats["rays"]["eye"], 200, backend)

    def test_stats_are_there_for_an_empty_scene(self):
        stats = self.stats(self.write("empty.json", "{}"), *TINY)
        self.assertEqual(stats["primitives"], {"spheres": 0, "triangles": 0})
        self.assertEqual(stats["rays"], {"eye": 64, "reflected": 0, "refracted": 0, "shadow": 0})


# --- compare --------------------------------------------------------------------------------------------------------


class Compare(Command):
    KEYS = "rmse rel_rmse mae max mean_signed p50 p99 p999 bad_pixels nan inf width height".split()

    def render_pair(self):
        """Two pictures that differ: without and with what mirrors and glasses show."""
        reference = ["--backend", "reference", "--quiet", *SMALL]
        self.do("render", SCENES / "spheres.json", *reference, "-o", "a.exr")
        self.do("render", SCENES / "spheres.json", *reference, "--depth", "1", "-o", "b.exr")

    def test_a_picture_equals_itself(self):
        self.render_pair()
        bounds = ["--max-rmse", "0", "--max-error", "0", "--max-bad-pixels", "0", "--threshold", "0"]
        zero = self.figures("a.exr", "a.exr", *bounds)
        self.assertEqual((zero.pop("width"), zero.pop("height")), (64, 48))
        self.assertEqual(set(zero.values()), {0})

    def test_json_is_exactly_the_promised_keys_and_nothing_else(self):
        self.render_pair()
        run = self.do("compare", "a.exr", "b.exr", "--json")
        self.assertEqual(list(json.loads(run.out)), self.KEYS)
        self.assertTrue(run.out.strip().startswith("{") and run.out.strip().endswith("}"), run)
        self.assertEqual(list(json.loads(self.do("compare", SCENES / "spheres.json", *TINY, "--json").out)), self.KEYS)

    def test_figures_are_those_of_a_minus_b(self):
        self.render_pair()
        figures = self.figures("a.exr", "b.exr", "--threshold", "0.05")
        a, b = Exr(self.path("a.exr")), Exr(self.path("b.exr"))
        pairs = list(zip(a.values(), b.values()))
        n = len(pairs)
        pixels = [
            max(abs(p - q) for p, q in zip(a.pixel(x, y), b.pixel(x, y))) for x in range(64) for y in range(48)
        ]
        expected = {
            "rmse": math.sqrt(math.fsum((p - q) ** 2 for p, q in pairs) / n),
            "rel_rmse": math.sqrt(math.fsum((p - q) ** 2 / (q * q + 0.01) for p, q in pairs) / n),
            "mae": math.fsum(abs(p - q) for p, q in pairs) / n,
            "max": max(pixels),
            "mean_signed": math.fsum(p - q for p, q in pairs) / n,
            "bad_pixels": sum(e > 0.05 for e in pixels) / len(pixels),
        }
        for name, value in expected.items():
            self.assertAlmostEqual(figures[name], value, delta=1e-12 + 1e-9 * abs(value), msg=name)
        for name, share in (("p50", 0.5), ("p99", 0.99), ("p999", 0.999)):
            below, at_most = (sum(t(e) for e in pixels) for t in (figures[name].__gt__, figures[name].__ge__))
            self.assertLessEqual(below, share * len(pixels) + 1, name)
            self.assertGreaterEqual(at_most, share * len(pixels) - 1, name)
        self.assertEqual((figures["nan"], figures["inf"], figures["width"], figures["height"]), (0, 0, 64, 48))
        # The other way round the sign turns.
        self.assertEqual(self.figures("b.exr", "a.exr")["mean_signed"], -figures["mean_signed"])

    def test_without_bounds_differences_are_no_failure(self):
        self.render_pair()
        run = self.do("compare", "a.exr", "b.exr")
        for word in ("rmse", "max", "bad pixels"):
            self.assertIn(word, run.out)

    def test_each_bound_holds_at_its_figure_and_fails_below(self):
        self.render_pair()
        threshold = ["--threshold", "0.05"]
        figures = self.figures("a.exr", "b.exr", *threshold)
        for option, name in (("--max-rmse", "rmse"), ("--max-error", "max"), ("--max-bad-pixels", "bad_pixels")):
            value = figures[name]
            self.assertGreater(value, 0)
            with self.subTest(option):
                self.assertEqual(self.figures("a.exr", "b.exr", *threshold, option, repr(value)), figures)
                below = repr(math.nextafter(value, 0))
                self.assertEqual(self.figures("a.exr", "b.exr", *threshold, option, below, code=FAILED), figures)
        # One broken bound is enough.
        self.figures("a.exr", "b.exr", "--max-rmse", "1000", "--max-error", "0", code=FAILED)

    def test_a_pixel_is_bad_above_the_threshold(self):
        write_exr(self.path("zero.exr"), 4, 1, [(0, 0, 0)] * 4)
        write_exr(self.path("steps.exr"), 4, 1, [(0, 0, 0), (0.25, 0, 0), (0, 0.5, 0), (0.5, 0.5, 0.75)])
        for threshold, share in (("0", 0.75), ("0.25", 0.5), ("0.5", 0.25), ("0.75", 0)):
            figures = self.figures("steps.exr", "zero.exr", "--threshold", threshold)
            self.assertEqual(figures["bad_pixels"], share, threshold)
        self.assertEqual(self.figures("steps.exr", "zero.exr")["max"], 0.75)

    def test_a_nan_fails_every_bound(self):
        write_exr(self.path("good.exr"), 3, 2, [(0.5, 0.5, 0.5)] * 6)
        for name, value in (("nan", math.nan), ("inf", math.inf)):
            write_exr(self.path("bad.exr"), 3, 2, [(0.5, 0.5, 0.5)] * 5 + [(0.5, value, 0.5)])
            for pair in (("good.exr", "bad.exr"), ("bad.exr", "good.exr"), ("bad.exr", "bad.exr")):
                figures = self.figures(*pair)
                self.assertEqual(figures[name], 1)
                for bound in ("--max-rmse", "--max-error", "--max-bad-pixels"):
                    self.figures(*pair, bound, "1e30", code=FAILED)

    def test_an_output_never_replaces_an_input(self):
        scene = self.write("scene.json", SPHERE)
        before = self.path(scene).read_bytes()
        self.refuse("render", scene, "--backend", "reference", "--stats", scene, says=["scene.json", "is an input"])
        os.symlink(scene, self.path("link.json"))
        self.refuse("render", scene, "--backend", "reference", "--stats", "link.json", says="is an input")
        self.assertEqual(self.path(scene).read_bytes(), before)
        self.render_pair()
        self.refuse("compare", "a.exr", "b.exr", "--error-image", "a.exr", says="is an input")

    def test_a_broken_bound_is_named(self):
        self.render_pair()
        run = self.run_turner("compare", "a.exr", "b.exr", "--max-error", "0", "--max-rmse", "1e9")
        self.assertEqual(run.code, FAILED, run)
        self.assertIn("--max-error", run.err)
        self.assertNotIn("--max-rmse", run.err)

    def test_the_error_image_is_the_absolute_difference(self):
        self.render_pair()
        self.do("compare", "a.exr", "b.exr", "--error-image", "error.exr")
        a, b, error = (Exr(self.path(name)).values() for name in ("a.exr", "b.exr", "error.exr"))
        self.assertEqual(error, [abs(float32(p - q)) for p, q in zip(a, b)])
        # It is there where it is needed most.
        self.figures("a.exr", "b.exr", "--max-error", "0", "--error-image", "broken.exr", code=FAILED)
        self.assertEqual(Exr(self.path("broken.exr")).values(), error)

    def test_unequal_windows_cannot_be_compared(self):
        scene = self.write("scene.json", SPHERE)
        reference = ["--backend", "reference", "--quiet"]
        self.do("render", scene, *reference, "-o", "whole.exr")
        self.do("render", scene, *reference, "--width", "65", "-o", "wider.exr")
        self.do("render", scene, *reference, "--crop", "0,0,32,48", "-o", "left.exr")
        self.do("render", scene, *reference, "--crop", "32,0,64,48", "-o", "right.exr")
        self.refuse("compare", "whole.exr", "wider.exr", says=["64", "65"])
        self.refuse("compare", "whole.exr", "left.exr", "--json")
        self.refuse("compare", "left.exr", "right.exr", "--error-image", "error.exr")

    def test_files_that_are_no_pictures_are_refused(self):
        self.render_pair()
        whole = self.path("a.exr").read_bytes()
        self.refuse("compare", "a.exr", "missing.exr", says="missing.exr")
        self.refuse("compare", "missing.exr", "a.exr", says="missing.exr")
        bad = {
            "empty.exr": b"",
            "text.exr": b"garbage\n",
            "magic.exr": whole[:4],
            "header.exr": whole[:200],
            "half.exr": whole[: len(whole) // 2],
            "short.exr": whole[:-1],
            "holes.exr": whole[:2000] + bytes(4000) + whole[6000:],
            "random.exr": bytes(i * i * 7 % 251 for i in range(5000)),
        }
        for name, content in bad.items():
            with self.subTest(name):
                self.refuse("compare", "a.exr", self.write(name, content), says=name)
        self.refuse("compare", ".", "a.exr")
        self.refuse("compare", "a.exr", SCENES / "spheres.json", says="spheres.json")

    def test_one_file_must_be_a_scene_and_three_are_too_many(self):
        self.render_pair()
        self.refuse("compare", "a.exr", says="a.exr")
        self.refuse("compare", "missing.json", says="missing.json")
        self.refuse("compare", "a.exr", "a.exr", "b.exr")
        self.refuse("compare")

    def test_a_scene_is_compared_within_bounds(self):
        scene = [SCENES / "spheres.json", *SMALL, "--samples", "2"]
        figures = self.figures(*scene, "--max-rmse", "0.001", "--max-bad-pixels", "0.01", "--threshold", "0.001")
        self.assertEqual((figures["width"], figures["height"]), (64, 48))
        self.assertGreater(figures["rmse"], 0)
        # The same run again gives the same figures, to the bit.
        value = figures["max"]
        self.assertEqual(self.figures(*scene, "--max-error", repr(value)), figures)
        self.figures(*scene, "--max-error", repr(math.nextafter(value, 0)), code=FAILED)

    def test_a_scene_is_compared_with_renders_options(self):
        options = ["--width", "32", "--height", "32", "--crop", "4,4,20,12", "--depth", "2", "--sampler", "jitter"]
        options += ["--seed", "5", "--samples", "2", "--geometry", "rounded", "--tile", "8", "--work-group", "32"]
        run = self.do("compare", SCENES / "spheres.json", *options, "--error-image", "error.exr")
        self.assertIn("device: ", run.out)
        self.assertEqual(Exr(self.path("error.exr")).data, (4, 4, 19, 11))

    OF_SAMPLING = ["own_error", "converged", "samples"]

    def test_three_errors_are_told_apart(self):
        scene = [SCENES / "spheres.json", *SMALL, "--samples", "2", "--decompose"]
        figures = self.figures(*scene)
        parts = figures["decompose"]
        self.assertEqual(list(figures), [*self.KEYS, "decompose"])
        self.assertEqual(list(parts), ["sampling", "arithmetic", "quantisation"])
        self.assertEqual(list(parts["sampling"]), [*self.KEYS, *self.OF_SAMPLING])
        for part in ("arithmetic", "quantisation"):
            self.assertEqual(list(parts[part]), self.KEYS)
        sampling = parts["sampling"]
        self.assertIs(sampling["converged"], True)
        self.assertLessEqual(sampling["own_error"], sampling["rmse"] / 4)
        self.assertEqual(sampling["samples"] % (2 * 8 * 8), 0)
        # Edges at 2 x 2 samples are rough; rounding is not.
        self.assertGreater(sampling["rmse"], 100 * parts["arithmetic"]["rmse"])
        self.assertGreater(parts["arithmetic"]["rmse"], 0)
        self.assertGreater(parts["quantisation"]["rmse"], 0)
        # Picture - exact = (picture - rounded) + (rounded - exact), whichever of the two is the usual figures' own.
        both = parts["arithmetic"]["mean_signed"] + parts["quantisation"]["mean_signed"]
        self.assertAlmostEqual(figures["mean_signed"], both, delta=1e-12)
        rounded = self.figures(*scene, "--geometry", "rounded")
        self.assertEqual(rounded["decompose"], parts)
        self.assertEqual({key: rounded[key] for key in self.KEYS}, parts["arithmetic"])

    def test_the_three_errors_keep_renders_options(self):
        crop = ["--width", "32", "--height", "32", "--crop", "4,4,20,12", "--depth", "2", "--min-weight", "0.3"]
        for sampler in (["grid"], ["jitter", "--seed", "4294967295"], ["sobol", "--samples", "6"]):
            parts = self.figures(SCENES / "glass.json", *crop, "--sampler", *sampler, "--decompose")["decompose"]
            for part in parts.values():
                self.assertEqual((part["width"], part["height"], part["nan"]), (16, 8, 0))
            # With another depth or weight on one side whole surfaces would differ.
            self.assertLess(parts["arithmetic"]["p50"], 1e-6)
            self.assertLess(parts["quantisation"]["p50"], 1e-6)
            self.assertLess(abs(parts["sampling"]["mean_signed"]), 0.05)

    def test_the_envelope_excuses_what_lies_at_edges(self):
        scene = [SCENES / "spheres.json", *SMALL, "--samples", "3", "--geometry", "rounded"]
        figures = self.figures(*scene, "--envelope")
        self.assertEqual(list(figures), [*self.KEYS, "envelope"])
        rule = figures["envelope"]
        self.assertEqual(list(rule), ["needed", "excused", "outside", "p99", "p999"])
        self.assertEqual(rule["needed"], self.figures(*scene, "--threshold", "1e-5")["bad_pixels"])
        self.assertEqual((rule["excused"], rule["outside"]), (rule["needed"], 0))
        self.assertLessEqual(rule["p999"], 1e-5)

    def test_the_three_errors_and_the_envelope_are_told_beside_the_usual_figures(self):
        lines = self.do("compare", SCENES / "spheres.json", *SMALL, "--decompose", "--envelope").out.splitlines()
        for word in ("rmse ", "bad pixels ", "sampling ", "arithmetic ", "quantisation ", "own error ", "envelope "):
            self.assertEqual(sum(line.startswith(word) for line in lines), 1, word)
        table = [line for line in lines if re.match("sampling|arithmetic|quantisation|  +rmse", line)]
        columns = [[match.start() for match in re.finditer(r"\S+", line)][-6:] for line in table]
        self.assertEqual(columns, [columns[0]] * 4)
        both = self.figures(SCENES / "spheres.json", *TINY, "--decompose", "--envelope")
        self.assertEqual(list(both), [*self.KEYS, "decompose", "envelope"])
        quiet = self.do("compare", SCENES / "spheres.json", *TINY, "--decompose", "--envelope", "--quiet")
        self.assertEqual(quiet.out + quiet.err, "")

    def test_two_pictures_have_no_three_errors_and_no_envelope(self):
        self.render_pair()
        for option in ("--decompose", "--envelope"):
            self.refuse("compare", "a.exr", "b.exr", option, says=[option, "scene"])
            self.refuse("compare", "a.exr", option, says="a.exr")

    def test_wrong_bounds_are_refused(self):
        self.render_pair()
        for option in ("--max-rmse", "--max-error", "--max-bad-pixels", "--threshold"):
            for value in ("-1", "x", "", "nan", "1e400"):
                with self.subTest(f"{option} {value}"):
                    self.refuse("compare", "a.exr", "b.exr", option, value, says=option)

    def test_an_error_image_that_cannot_be_written_is_refused_before_any_work(self):
        scene = [SCENES / "spheres.json", *LONG, "--error-image"]
        self.refuse("compare", *scene, "error.png", says=["error.png", ".exr"])
        self.refuse("compare", *scene, "nowhere/error.exr", says="nowhere")
        self.path("folder.exr").mkdir()
        self.refuse("compare", *scene, "folder.exr", says="folder.exr")


# --- devices --------------------------------------------------------------------------------------------------------


class Devices(Command):
    NO_DRIVER = {"VK_ICD_FILENAMES": "/nonexistent.json", "VK_DRIVER_FILES": "/nonexistent.json"}

    def devices(self):
        return json.loads(self.do("devices", "--json").out)

    def test_devices_are_listed_for_people_and_for_programs(self):
        devices = self.devices()
        self.assertGreaterEqual(len(devices), 1)
        text = self.do("devices").out
        self.assertEqual(len(text.splitlines()), len(devices))
        for i, device in enumerate(devices):
            self.assertEqual(device["index"], i)
            for key in ("name", "type", "driver"):
                self.assertIsInstance(device[key], str)
                self.assertIn(device[key], text)

    def test_a_device_is_chosen_by_index_and_by_a_part_of_its_name(self):
        scene = self.write("scene.json", SPHERE)
        devices = self.devices()
        last = devices[-1]
        for wanted in (str(last["index"]), last["name"], last["name"].upper()):
            run = self.do("render", scene, *TINY, "--device", wanted, "--stats", "stats.json")
            self.assertIn(last["name"], run.out)
            self.assertEqual(json.loads(self.path("stats.json").read_text())["device"]["name"], last["name"])
        part = last["name"][:5]
        if sum(part.lower() in device["name"].lower() for device in devices) == 1:
            self.assertIn(last["name"], self.do("render", scene, *TINY, "--device", part).out)
        self.do("compare", scene, *TINY, "--device", str(last["index"]), "--json")

    def test_an_unknown_device_is_refused_with_a_list_of_the_devices(self):
        scene = self.write("scene.json", SPHERE)
        devices = self.devices()
        for wanted in ("no such device", str(len(devices)), "-1", "99999999999999999999"):
            for command in ("render", "compare"):
                with self.subTest(f"{command} --device {wanted}"):
                    # The fault's line, then a line for each device.
                    run = self.refuse(command, scene, "--device", wanted, says=wanted, faults=None)
                    self.assertEqual(len(run.err.splitlines()), 1 + len(devices), run)
                    for device in devices:
                        self.assertIn(f"{device['index']}: {device['name']}", run.err)

    def test_the_environment_names_a_device_and_the_option_overrides_it(self):
        scene = self.write("scene.json", SPHERE)
        device = self.devices()[-1]
        named = {"TURNER_DEVICE": device["name"]}
        wrong = {"TURNER_DEVICE": "no such device"}
        self.assertIn(device["name"], self.do("render", scene, *TINY, env=named).out)
        self.path("scene.exr").unlink()
        self.refuse("render", scene, *TINY, env=wrong, says=["no such device", device["name"]], faults=None)
        self.refuse("compare", scene, *TINY, env=wrong, says=["no such device", device["name"]], faults=None)
        self.do("render", scene, *TINY, "--device", str(device["index"]), env=wrong)
        self.do("render", scene, *TINY, env={"TURNER_DEVICE": ""})

    def test_without_any_device_a_run_fails_and_says_what_to_install(self):
        scene = self.write("scene.json", SPHERE)
        for validation in ("1", "0"):
            environment = dict(self.NO_DRIVER, TURNER_VALIDATION=validation)
            for command in (["devices"], ["devices", "--json"], ["render", scene], ["compare", scene]):
                with self.subTest(f"{command} TURNER_VALIDATION={validation}"):
                    run = self.refuse(*command, code=FAILED, env=environment, says="mesa-vulkan-drivers")
                    self.assertNotIn("[", run.out)

    def test_the_reference_needs_no_device(self):
        scene = self.write("scene.json", SPHERE)
        self.do("render", scene, "--backend", "reference", "--stats", "stats.json", env=self.NO_DRIVER)
        self.write("a.exr", self.path("scene.exr").read_bytes())
        self.do("compare", "a.exr", "scene.exr", env=self.NO_DRIVER)

    def test_missing_validation_layers_fail_and_are_named(self):
        scene = self.write("scene.json", SPHERE)
        nowhere = {"VK_LAYER_PATH": "/nonexistent", "VK_ADD_LAYER_PATH": "/nonexistent"}
        self.refuse("render", scene, code=FAILED, env=nowhere, says="vulkan-validationlayers")


# --- the command line -----------------------------------------------------------------------------------------------


class CommandLine(Command):
    def test_version_and_help_are_no_errors(self):
        run = self.do("--version")
        self.assertRegex(run.out, r"^turner \d+\.\d+\.\d+\n$")
        for command in ([], ["render"], ["compare"], ["devices"]):
            texts = [self.do(*command, flag).out for flag in ("--help", "-h")]
            self.assertEqual(texts[0], texts[1])
            self.assertIn("Usage: " + " ".join(["turner", *command]), texts[0])
        self.assertEqual(self.files(), [])

    def test_every_command_is_there(self):
        overview = self.do("--help").out
        for command in ("render", "compare", "devices"):
            with self.subTest(command):
                self.assertRegex(overview, rf"(?m)^  {command} ")
                self.assertIn(f"turner {command}", self.do(command, "--help").out)

    def test_help_names_every_option_of_the_contract(self):
        options = "--width --height --samples --depth --sampler --seed --min-weight --geometry --device --crop"
        own = {
            "render": "-o --backend --stats",
            "compare": "--max-rmse --max-error --max-bad-pixels --threshold --error-image --json --decompose --envelope",
        }
        for command, names in own.items():
            text = self.do(command, "--help").out
            for name in f"{options} --shaders --quiet {names}".split():
                self.assertRegex(text, rf"(?m)(^|[ ,]){re.escape(name)}\b", f"{command} {name}")

    def test_unknown_commands_are_refused_with_the_nearest_one(self):
        self.refuse("rendr", "scene.json", says=["rendr", "did you mean", "render"])
        self.refuse("device", says=["device", "did you mean", "devices"])
        self.refuse("xyzzyxyzzy", says="xyzzyxyzzy")
        self.refuse("")

    def test_no_command_is_refused_with_the_commands(self):
        self.refuse(says=["render", "compare", "devices"])

    def test_unknown_options_are_refused_with_the_nearest_one(self):
        scene = self.write("scene.json", SPHERE)
        for args, wrong, right in (
            (["render", scene, "--widht", "64"], "--widht", "--width"),
            (["render", scene, "--sample=2"], "--sample", "--samples"),
            (["render", scene, "--max-rmse", "1"], "--max-rmse", None),
            (["compare", scene, "--max-rms", "1"], "--max-rms", "--max-rmse"),
            (["compare", scene, "--backend", "shader"], "--backend", None),
            (["devices", "--jsn"], "--jsn", "--json"),
            (["--versoin"], "--versoin", "--version"),
            (["render", scene, "-x"], "-x", None),
            (["render", scene, "another.json"], "another.json", None),
            (["devices", "extra"], "extra", None),
        ):
            with self.subTest(args):
                self.refuse(*args, says=[wrong, f"did you mean {right}"] if right else [wrong])

    def test_missing_values_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        valued = "--width --height --samples --depth --sampler --seed --min-weight --geometry --device --crop --shaders"
        for option in (valued + " --output --backend --stats --tile --work-group").split():
            with self.subTest(option):
                self.refuse("render", scene, option, says=option)
        self.refuse("render", scene, "-o", says="-o")
        for option in ("--max-rmse", "--max-error", "--max-bad-pixels", "--threshold", "--error-image"):
            with self.subTest(option):
                self.refuse("compare", scene, option, says=option)
        self.refuse("render", says="SCENE")

    def test_empty_values_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        for option in "--output --crop --shaders --stats --width --sampler --min-weight".split():
            with self.subTest(option):
                self.refuse("render", scene, *TINY, option, "")
        self.refuse("compare", scene, *TINY, "--error-image", "")
        self.refuse("render", "")

    def test_numbers_out_of_range_are_refused_with_the_range(self):
        scene = self.write("scene.json", SPHERE)
        for option, most in (("--width", "65536"), ("--height", "65536"), ("--samples", "256"), ("--depth", "64")):
            for value in ("0", "-1", "1000000", "99999999999999999999", "2.5", "1e2", "x", "nan", " ", "0x"):
                with self.subTest(f"{option} {value}"):
                    self.refuse("render", scene, option, value, says=[option, value, f"1 to {most}"])

    def test_whole_numbers_are_decimal(self):
        # A leading zero is not C's octal.
        scene = self.write("scene.json", SPHERE)
        picture = self.picture(scene, "--width", "010", "--height", "8", "--backend", "reference")
        self.assertEqual(picture.width, 10)

    def test_wrong_seeds_are_refused_with_the_range(self):
        scene = self.write("scene.json", SPHERE)
        for value in ("-1", "4294967296", "1.5", "x", "1e400"):
            with self.subTest(value):
                self.refuse("render", scene, *TINY, "--seed", value, says=["--seed", value, "4294967295"])

    def test_wrong_weights_are_refused_with_the_range(self):
        scene = self.write("scene.json", SPHERE)
        for value in ("-0.1", "1.1", "nan", "-nan", "inf", "1e400", "x", "0.5x"):
            with self.subTest(value):
                self.refuse("render", scene, *TINY, "--min-weight", value, says=["--min-weight", value, "0 to 1"])

    def test_wrong_choices_are_refused_with_the_choices(self):
        scene = self.write("scene.json", SPHERE)
        for option, choices in (
            ("--sampler", ("grid", "jitter", "sobol")),
            ("--backend", ("shader", "reference")),
            ("--geometry", ("exact", "rounded")),
        ):
            for value in ("middle", "0", "1"):
                with self.subTest(f"{option} {value}"):
                    run = self.refuse("render", scene, *TINY, option, value, says=[option, value, *choices])
                    self.assertNotRegex(run.err, r"->|FAILED|Check ", "a message for people")

    def test_wrong_crops_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        for crop in (
            *("1,2,3", "1,2,3,4,5", "0;0;8;8", "0,0,8,", "0, 0, 8, 8", "a,b,c,d", "0,0,nan,8", "0,0,8.5,8"),
            *("0,0,0,0", "10,10,10,20", "20,10,10,20", "0,0,65,48", "0,0,64,49", "-1,0,8,8"),
            "0,0,99999999999999999999,8",
        ):
            with self.subTest(crop):
                self.refuse("render", scene, f"--crop={crop}", says=["--crop", crop])

    def test_wrong_tiles_and_work_groups_are_refused(self):
        scene = self.write("scene.json", SPHERE)
        for value in ("0", "7", "-8", "1000000", "x"):
            with self.subTest(f"--tile {value}"):
                self.refuse("render", scene, "--tile", value, says=["--tile", value])
        for value in ("0", "-1", "1000000", "x", "1.5"):
            with self.subTest(f"--work-group {value}"):
                self.refuse("render", scene, "--work-group", value, says=value)

    def test_pictures_too_large_are_refused_at_once(self):
        for size in (["--width", "65536", "--height", "65536"], ["--width", "65536", "--height", "4097"]):
            for backend in ("shader", "reference"):
                args = ["render", SCENES / "spheres.json", *size, "--backend", backend]
                run = self.refuse(*args, says=["65536", "--crop"])
                self.assertLess(run.seconds, PATIENCE)
        whole = ["--width", "65536", "--height", "65536", "--crop", "0,0,65536,65536"]
        self.refuse("compare", SCENES / "spheres.json", *whole)
        self.refuse("render", self.write("huge.json", '{ "width": 65536, "height": 65536 }'))

    def test_figures_that_cannot_be_printed_are_a_failure(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        with open("/dev/full", "w") as full:
            compare = ["compare", "a.exr", "a.exr"]
            for command in (compare, [*compare, "--json"], ["devices", "--json"]):
                with self.subTest(command):
                    self.refuse(*command, code=FAILED, stdout=full, says="No space left on device")


# --- wrong scenes ---------------------------------------------------------------------------------------------------


class WrongScenes(Command):
    def refuse_scene(self, name, content, places, says=()):
        """The scene is refused with one line for each of `places`, which are FILE:LINE or FILE:LINE:COLUMN."""
        self.write(name, content)
        self.write("out.exr", b"was here before")
        for command in (["render", name, "-o", "out.exr"], ["compare", name]):
            run = self.refuse(*command, faults=len(places), says=says)
            self.assertEqual(run.out, "", run)
            for line, place in zip(run.err.splitlines(), places):
                self.assertTrue(line.startswith(place + ":"), f"expected at {place}\n{run}")
                self.assertRegex(line, r"^[^:]+:\d+:\d+: error: \S", run)

    def refuse_marked(self, text, says=()):
        """The same for a scene whose faults are marked: each with a § before its first character."""
        places = []
        while "§" in text:
            before, _, after = text.partition("§")
            places.append(f"bad.json:{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}")
            text = before + after
        self.refuse_scene("bad.json", text, places, says)

    def test_wrong_syntax_is_placed(self):
        for text in (
            "§",
            "  // nothing but a comment§",
            "{§",
            '{\n  "depth": 5,\n§}',
            '{ "depth" §5 }',
            '{ "depth": 5 §',
            '{ "depth": §}',
            "{ §depth: 5 }",
            "{ §'depth': 5 }",
            '{ "depth": 5 } §{}',
            '{ "background": [0, 0 §0] }',
            '{ "background": [0, 0, 0§',
            '{ "depth": 0§5x }',
            "{ /* never closed§",
            '{ "$schema": "never closed§',
        ):
            with self.subTest(text):
                self.refuse_marked(text)

    def test_bytes_that_are_no_text_are_refused(self):
        self.refuse_scene("bad.json", b'{ "materials": { "\xff\xfe": {} } }', ["bad.json:1"])
        self.refuse_scene("bad.json", bytes(range(256)) * 8, ["bad.json:1:1"])
        self.refuse_scene("bad.json", "[" * 100_000, ["bad.json:1"])

    def test_each_kind_of_fault_is_placed_and_named(self):
        clay = '"materials": { "clay": {} }'
        for text, says in (
            # types
            ('{ "depth": §"5" }', ["depth", '"5"']),
            ('{ "depth": §true }', ["depth", "true"]),
            ('{ "depth": §5.5 }', ["depth", "5.5", "1 to 64"]),
            ('{ "background": §1 }', ["background"]),
            ('{ "background": §[0, 0] }', ["background", "2"]),
            ('{ "background": [0, §null, 0] }', ["background[1]", "null"]),
            ('{ "spheres": §{} }', ["spheres"]),
            ("§[]", ["object"]),
            # unknown and double keys
            ('{ §"dpeth": 5 }', ["dpeth", "depth"]),
            ('{ "camera": { "eye": [0,0,1], "target": [0,0,0], §"fow": 45 } }', ["fow", "fov"]),
            ('{ "depth": 5,\n  §"depth": 6 }', ["depth", "twice", "line 1"]),
            ('{ "materials": { "a": {}, "b": {}, §"a": {} } }', ["twice"]),
            # ranges
            ('{ "depth": §0 }', ["depth", "0", "1 to 64"]),
            ('{ "depth": §1000000 }', ["depth", "1000000"]),
            ('{ "width": §0 }', ["width", "1 to 65536"]),
            ('{ "width": §-5 }', ["width", "-5"]),
            ('{ "width": §1000000 }', ["width", "1000000", "65536"]),
            ('{ "height": §1000000 }', ["height", "1000000", "65536"]),
            ('{ "background": [0, §-1, 0] }', ["background[1]", "-1"]),
            ('{ "camera": { "eye": [0,0,1], "target": [0,0,0], "fov": §0 } }', ["fov"]),
            ('{ "camera": { "eye": [0,0,1], "target": [0,0,0], "fov": §180 } }', ["fov", "180"]),
            ('{ "camera": §{ "eye": [0,0,1], "target": [0,0,1] } }', ["eye", "target"]),
            ('{ "camera": §{ "eye": [0,1,0], "target": [0,0,0] } }', ["up"]),
            ('{ "materials": { "a": { "reflect": §1.5 } } }', ["reflect", "1.5"]),
            ('{ "materials": { "a": §{ "reflect": 0.6, "transmit": 0.5 } } }', ["reflect", "transmit"]),
            ('{ "materials": { "a": { "transmit": 0.5, "ior": §0 } } }', ["ior"]),
            ('{ CLAY, "spheres": [ { "center": [0,0,0], "radius": §0, "material": "clay" } ] }', ["radius"]),
            ('{ "lights": [ { "position": [0, 0, 0], "falloff": §"linear" } ] }', ["linear", "inverse-square"]),
            # what is missing
            ('{ "camera": §{ "eye": [0,0,1] } }', ["target", "missing"]),
            ('{ CLAY, "spheres": [ §{ "center": [0,0,0] } ] }', ["material", "missing"]),
            ('{ CLAY, "spheres": [ { "center": [0,0,0], "material": §"caly" } ] }', ["caly", "clay"]),
            ('{ "spheres": [ { "center": [0,0,0], "material": §"clay" } ] }', ["clay", "no materials"]),
            ('{ CLAY, "meshes": [ { "file": §"gone.obj", "material": "clay" } ] }', ["gone.obj"]),
            ('{ CLAY, "meshes": [ { "file": §"cow.ply", "material": "clay" } ] }', ["cow.ply", ".obj"]),
            ('{ CLAY, "meshes": [ { "file": §".", "material": "clay" } ] }', ["meshes[0].file"]),
            # no numbers
            ('{ "background": [0, §NaN, 0] }', ["NaN"]),
            ('{ "background": [0, §nan, 0] }', ["nan"]),
            ('{ "background": [0, §Infinity, 0] }', ["Infinity"]),
            ('{ "background": [0, §-inf, 0] }', ["-inf"]),
            ('{ "background": [0, §1e400, 0] }', ["1e400", "too large"]),
            ('{ "lights": [ { "position": [0, §-1e400, 0] } ] }', ["-1e400", "too large"]),
        ):
            with self.subTest(text):
                self.refuse_marked(text.replace("CLAY", clay), says)

    def test_all_faults_are_told_at_once_in_the_order_of_their_places(self):
        self.refuse_marked(
            '{ §"widht": 64,\n  "depth": §0,\n  §"depth": 1,\n  "background": [0, §"x", §-1],\n  "lights": §5 }'
        )

    def test_the_collected_wrong_scenes_are_refused(self):
        scenes = sorted((TESTS / "bad_scenes").glob("*.json"))
        self.assertGreater(len(scenes), 30)
        for scene in scenes:
            with self.subTest(scene.name):
                # Whatever a fault's number of lines: each has its place.
                run = self.refuse("render", scene, "-o", "out.exr", faults=None)
                for line in run.err.splitlines():
                    self.assertRegex(line, r"^\S+:\d+:\d+: error: \S", run)

    def test_scenes_that_cannot_be_read_are_refused(self):
        self.refuse("render", "missing.json", says="missing.json")
        self.refuse("render", "nowhere/missing.json", says="nowhere/missing.json")
        self.refuse("render", ".", says=".json")
        self.path("folder.json").mkdir()
        self.refuse("render", "folder.json", says="folder.json")
        self.refuse("render", self.write("scene.txt", SPHERE), says=["scene.txt", ".json", ".nff"])
        self.refuse("render", self.write("scene", SPHERE), says=[".json", ".nff"])
        self.refuse("render", "x" * 300 + ".json", "-o", "out.exr", says="x" * 300)
        self.refuse("compare", "missing.json", says="missing.json")

    def test_a_scene_that_may_not_be_read_is_refused(self):
        self.write("secret.json", SPHERE)
        self.path("secret.json").chmod(0)
        if not modes_bind(self.path("secret.json")):
            return say_not_possible("a file that the user may not read")
        self.refuse("render", "secret.json", says="secret.json", preexec_fn=without_superpowers)

    def test_truncated_scenes_are_refused_wherever_they_end(self):
        whole = remove_comments((SCENES / "spheres.json").read_text()).rstrip()
        for part in range(1, 12):
            with self.subTest(part):
                content = whole[: len(whole) * part // 12]
                self.refuse_scene("cut.json", content, [f"cut.json:{content.count(chr(10)) + 1}"])

    def test_wrong_nff_is_placed(self):
        lines = NFF.splitlines()
        for number, replacement, says in (
            (3, "from 0 1.5", ["from"]),
            (3, "from 0 1.5 x", ["x"]),
            (3, "from 0 nan 5", ["nan"]),
            (3, "from 0 inf 5", ["inf"]),
            (3, "from 0 1e400 5", ["1e400"]),
            (6, "angle 180", ["angle"]),
            (8, "resolution 0 48", ["1 to 65536"]),
            (8, "resolution 1000000 48", ["1 to 65536"]),
            (9, "b 1 1", ["b r g b"]),
            (10, "l 3 5", ["l x y z"]),
            (11, "f 0.8 0.7 0.6 0.5 0.5 20 0", ["f "]),
            (12, "s 0 1 0", ["s x y z"]),
            (12, "s 0 1 0 1 2", ["2"]),
            (12, "q 0 1 0 1", ["'q'"]),
            (14, "p 2", ["2"]),
            (14, "p 1000000", []),
            (14, "p -3", ["-3"]),
            (14, "p x", ["x"]),
        ):
            with self.subTest(replacement):
                changed = lines[: number - 1] + [replacement] + lines[number:]
                # A polygon that announces too many corners is noticed at its beginning or at the end of the file.
                place = "bad.nff" if replacement == "p 1000000" else f"bad.nff:{number}"
                self.refuse_scene("bad.nff", "\n".join(changed) + "\n", [place], says)

    def test_truncated_nff_is_refused(self):
        for cut in ("at 0 0.6", "resolution 64", "b 0.1 0.2", "f 0.8 0.7 0.6 0.5 0.5 20", "s 0 1 0", "4 0 4\n4 0 -4\n"):
            with self.subTest(cut):
                content = NFF[: NFF.index(cut) + len(cut)]
                self.refuse("render", self.write("cut.nff", content), says="cut.nff:", faults=None)

    def test_wrong_obj_is_placed_in_its_own_file(self):
        self.write("mesh.json", MESH_SCENE)
        for content, line, says in (
            ("", 1, ["no faces"]),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", 4, ["no faces"]),
            (OBJ + "f 1 2 4\n", 5, ["4", "1 to 3"]),
            (OBJ + "f 1 2 0\n", 5, ["0"]),
            (OBJ + "f 1 2 -4\n", 5, ["-4"]),
            (OBJ + "f 1 2 99999999999999999999\n", 5, ["1 to 3"]),
            (OBJ + "f 1//1 2//1 3//1\n", 5, ["normal"]),
            (OBJ + "f 1 2\n", 5, ["2 corners"]),
            (OBJ + "f 1 2 x\n", 5, ["'x'"]),
            (OBJ + "f 1/ 2/ 3/1/1/1\n", 5, ["corner"]),
            (OBJ + "v 1 2\n", 5, ["v x y z"]),
            (OBJ + "v 1 2 nan\n", 5, ["nan"]),
            (OBJ + "v 1 2 inf\n", 5, ["inf"]),
            (OBJ + "v 1 2 1e400\n", 5, ["1e400"]),
            (OBJ + "vertex 1 2 3\n", 5, ["vertex"]),
            (b"\x80\x81garbage\n", 1, ["unknown"]),
        ):
            with self.subTest(content[-30:]):
                self.write("shape.obj", content)
                run = self.refuse("render", "mesh.json", "-o", "out.exr", says=says)
                self.assertRegex(run.err, rf"^shape\.obj:{line}:\d+: error: ")

    def test_faults_of_scene_and_mesh_are_told_together(self):
        self.write("shape.obj", OBJ + "f 1 2 9\nf 1 2 8\n")
        self.write("mesh.json", MESH_SCENE.replace("{", '{ "depth": 0,', 1))
        run = self.refuse("render", "mesh.json", faults=3)
        places = [line.split(": error:")[0].rsplit(":", 1)[0] for line in run.err.splitlines()]
        self.assertEqual(places, ["mesh.json:1", "shape.obj:5", "shape.obj:6"])

    def test_garbled_files_never_crash(self):
        # A tame generator: the same garbage everywhere, every time.
        state = 12345

        def random(n):
            nonlocal state
            state = (state * 1103515245 + 12345) % 2**31
            return (state >> 8) % n

        self.write("mesh.json", MESH_SCENE)
        sources = {"json": SPHERE, "nff": NFF, "obj": OBJ * 5}
        for kind, text in sources.items():
            for attempt in range(12):
                garbled = bytearray(text.encode())
                for _ in range(1 + attempt):
                    at = random(len(garbled))
                    garbled[at : at + random(3)] = bytes(random(256) for _ in range(random(3)))
                name = self.write("shape.obj" if kind == "obj" else f"garbled.{kind}", bytes(garbled))
                scene = "mesh.json" if kind == "obj" else name
                options = [*TINY, "--crop", "0,0,8,8", "--backend", "reference", "-o", "garbled.exr"]
                run = self.run_turner("render", scene, *options)
                self.assertIn(run.code, (DONE, WRONG_INPUT), f"{bytes(garbled)}\n{run}")
                if run.code == WRONG_INPUT:
                    self.assertRegex(run.err, r"^[^:\n]+:\d+:\d+: error: ", run)
                with contextlib.suppress(FileNotFoundError):
                    self.path("garbled.exr").unlink()
        self.assertEqual(self.files(), ["garbled.json", "garbled.nff", "mesh.json", "shape.obj"])


# --- wrong outputs --------------------------------------------------------------------------------------------------


class Outputs(Command):
    """Places that cannot be written. All of them are found before a long render has begun."""

    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)
        self.long = ["render", "scene.json", *LONG]

    def refuse_place(self, place, says, **options):
        for option in ("-o", "--stats"):
            with self.subTest(f"{option} {place}"):
                run = self.refuse(*self.long, option, place, says=says, **options)
                self.assertNotIn("device:", run.out, "found before the work begins")
        if not str(place).endswith("/"):
            self.refuse("compare", "scene.json", *LONG, "--error-image", place, says=says, **options)
        # A good place does not help a bad one.
        self.refuse(*self.long, "-o", "good.exr", "-o", place, says=says, **options)

    def test_a_missing_folder_is_refused(self):
        self.refuse_place("nowhere/out.exr", "nowhere")

    def test_a_file_is_no_folder(self):
        self.refuse_place("scene.json/out.exr", "scene.json")

    def test_a_folder_is_no_file(self):
        self.path("out.exr").mkdir()
        self.refuse_place("out.exr", "folder")
        self.refuse(*self.long, "-o", "out.exr/", says="out.exr")

    def test_other_endings_are_refused_with_those_that_are_known(self):
        for name in ("out.jpg", "out.json", "out", "exr", ".exr.", "out.exr.tmp", "folder/", ".", "/"):
            with self.subTest(name):
                self.refuse(*self.long, "-o", name, says=[".exr", ".png"])

    def test_names_too_long_are_refused(self):
        self.refuse_place("x" * 300 + ".exr", "too long")

    def test_links_in_a_ring_are_refused(self):
        self.path("ring.exr").symlink_to("gnir.exr")
        self.path("gnir.exr").symlink_to("ring.exr")
        self.refuse_place("ring.exr", "ring.exr")

    def test_a_folder_without_permission_is_refused(self):
        self.path("locked").mkdir()
        self.path("locked").chmod(0o555)
        if not modes_bind(self.path("locked")):
            return say_not_possible("a folder that the user may not write")
        self.refuse_place("locked/out.exr", "locked", preexec_fn=without_superpowers)

    def test_a_file_without_permission_is_refused_and_stays(self):
        self.write("locked.exr", b"was here before")
        self.path("locked.exr").chmod(0o444)
        if not modes_bind(self.path("locked.exr")):
            return say_not_possible("a file that the user may not write")
        self.refuse_place("locked.exr", "locked.exr", preexec_fn=without_superpowers)

    def test_a_read_only_file_system_is_refused(self):
        with self.mounted("ro") as folder:
            if folder:
                self.refuse_place(f"{folder.name}/out.exr", folder.name)

    def test_existing_files_stay_as_they_were_when_a_run_fails(self):
        for name in ("out.exr", "out.png", "stats.json"):
            self.write(name, b"was here before")
        outputs = ["-o", "out.exr", "-o", "out.png", "--stats", "stats.json"]
        self.refuse("render", "missing.json", *outputs)
        self.refuse("render", "scene.json", *outputs, "--width", "0")
        self.refuse("render", "scene.json", *outputs, "--device", "no such device", faults=None)
        self.refuse("render", "scene.json", *outputs, "--shaders", "nowhere")
        self.refuse("render", "scene.json", *outputs, "--work-group", "1000000")
        self.refuse("render", "scene.json", *outputs, code=FAILED, env=Devices.NO_DRIVER)

    # --- full disks: the same promise for a device, a limit on the size of files, and a disk that is really full

    def test_a_full_device_behind_a_link_fails(self):
        for name in ("out.exr", "out.png"):
            self.path(name).symlink_to("/dev/full")
            for backend in ("shader", "reference"):
                run = self.refuse(
                    "render", "scene.json", "-o", name, "--backend", backend, code=FAILED, says=[name, "No space left"]
                )
                self.assertNotIn("wrote", run.out)

    def test_figures_on_a_full_device_fail(self):
        self.path("full.json").symlink_to("/dev/full")
        run = self.run_turner("render", "scene.json", "--backend", "reference", "--stats", "full.json", "-o", "out.exr")
        self.assertEqual(run.code, FAILED, run)
        self.check_message(run, 1, ["full.json", "No space left"])
        # The picture is there whole or not at all.
        if self.path("out.exr").exists():
            self.assertEqual(Exr(self.path("out.exr")).width, 64)
        self.assertEqual([name for name in self.files() if name.startswith(".")], [])

    def test_an_error_image_on_a_full_device_fails(self):
        self.do("render", "scene.json", "--backend", "reference", "-o", "a.exr")
        self.path("full.exr").symlink_to("/dev/full")
        args = ["compare", "a.exr", "a.exr", "--error-image", "full.exr"]
        self.refuse(*args, code=FAILED, says=["full.exr", "No space left"])

    def test_a_limit_on_the_size_of_files_fails_and_leaves_nothing(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

        self.write("out.exr", b"was here before")
        # A shell's `ulimit -f` sends a signal at the limit; where that is ignored, write() reports it.
        for signals in (False, True):
            for name in ("out.exr", "out.png", "new.exr"):
                with self.subTest(name, signals=signals):
                    args = ["render", "scene.json", "--width", "256", "--height", "256", "--backend", "reference"]
                    says = [name, "File too large"]
                    options = {"preexec_fn": limit, "restore_signals": signals}
                    run = self.refuse(*args, "-o", name, code=FAILED, says=says, **options)
                    self.assertNotIn("wrote", run.out)

    def test_a_full_disk_fails_and_leaves_nothing(self):
        with self.mounted("size=64k") as disk:
            if not disk:
                return
            (disk / "out.exr").write_bytes(b"was here before")
            (disk / "filler").write_bytes(bytes(48 * 1024))
            size = ["--width", "256", "--height", "256"]
            for backend in ("shader", "reference"):
                for name in ("out.exr", "new.exr"):
                    output = f"{disk.name}/{name}"
                    options = ["--backend", backend, "-o", output]
                    run = self.refuse(
                        "render", "scene.json", *size, *options, code=FAILED, says=[output, "No space left"]
                    )
                    self.assertNotIn("wrote", run.out)
            # With room again it works.
            (disk / "filler").unlink()
            self.do("render", "scene.json", *TINY, "--backend", "reference", "-o", f"{disk.name}/out.exr")
            self.assertEqual(sorted(p.name for p in disk.iterdir()), ["out.exr"])

    @contextlib.contextmanager
    def mounted(self, options):
        """A small file system in memory; none, with a word about it, where mounting is not allowed."""
        folder = self.path("disk")
        folder.mkdir()
        mount = None
        if os.geteuid() == 0 and shutil.which("mount"):
            command = ["mount", "-t", "tmpfs", "-o", options, "turner-test", str(folder)]
            mount = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        if mount is None or mount.returncode != 0:
            why = mount.stderr.decode().strip() if mount else "only the superuser can mount one"
            say_not_possible(f"a file system with the option {options} ({why})")
            yield None
            return
        try:
            yield folder
        finally:
            subprocess.run(["umount", str(folder)], check=True)


# --- Ctrl-C ---------------------------------------------------------------------------------------------------------


class Interruption(Command):
    def setUp(self):
        super().setUp()
        self.write("out.exr", b"was here before")
        self.write("stats.json", b"was here before")

    @contextlib.contextmanager
    def started(self, *args, terminal):
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

    def interrupt(self, process, end, before, text, patience=PATIENCE):
        process.send_signal(signal.SIGINT)
        start = time.monotonic()
        try:
            process.wait(timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            self.fail(f"Ctrl-C was not noticed within {TIMEOUT} s\n{text}")
        seconds = time.monotonic() - start
        rest = self.read_until(end, None, 1)
        run = Run(process.args[1:], process.returncode, "", text + rest, seconds)
        self.assertEqual(run.code, INTERRUPTED, run)
        self.check_sane(run)
        self.assertEqual(len(ERROR.findall(rest)), 1, run)
        self.assertIn("interrupted", rest, run)
        self.assertLess(seconds, patience, run)
        self.assertEqual(self.snapshot(), before, run)

    def interrupt_render(self, *args, terminal, shows):
        before = self.snapshot()
        with self.started(*args, terminal=terminal) as (process, end):
            # Once there is progress, the work has begun.
            text = self.read_until(end, shows, TIMEOUT)
            self.assertRegex(text, shows)
            self.interrupt(process, end, before, text)
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
                    self.interrupt(process, end, before, "")

    def test_ctrl_c_ends_the_counting_of_rays(self):
        # Counting begins where tracing ends its line. It takes as long again, which is longer than Ctrl-C may take;
        # a driver that compiles the counting kernel first must have time for that.
        size = ["--width", "80", "--height", "60", "--samples", "40", "-o", "out.exr", "--stats", "stats.json"]
        before = self.snapshot()
        with self.started("render", SCENES / "spheres.json", *size, terminal=True) as (process, end):
            start = time.monotonic()
            text = self.read_until(end, r"tracing: .*\n", TIMEOUT)
            took = time.monotonic() - start
            self.assertRegex(text, r"tracing: .*\n")
            time.sleep(0.2)
            self.interrupt(process, end, before, text, patience=0.6 * took)


# --- shaders --------------------------------------------------------------------------------------------------------


class Shaders(Command):
    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)
        self.write("out.exr", b"was here before")
        shutil.copytree(SCENES.parent / "shaders", self.path("kernel"))

    def edit(self, name, change):
        path = self.path("kernel") / name
        lines = path.read_text().splitlines()
        change(lines)
        path.write_text("\n".join(lines) + "\n")

    def line_of(self, name, text):
        lines = (self.path("kernel") / name).read_text().splitlines()
        return 1 + next(i for i, line in enumerate(lines) if text in line)

    def refuse_kernel(self, *, faults=1, says=(), **options):
        args = ["scene.json", *TINY, "--shaders", "kernel"]
        self.refuse("compare", *args, faults=faults, says=says, **options)
        return self.refuse("render", *args, "-o", "out.exr", faults=faults, says=says, **options)

    def test_a_fault_in_an_include_is_placed_there_in_one_line(self):
        # A line of its own behind the first function's opening brace.
        place = self.line_of("shade.glsl", ") {")
        self.edit("shade.glsl", lambda lines: lines.insert(place, "  float broken = notDeclared;"))
        run = self.refuse_kernel(faults=None, says="notDeclared")
        self.assertRegex(run.err, rf"(?m)^kernel/shade\.glsl:{place + 1}: error: .*notDeclared")
        self.check_message(run, 1)

    def test_every_line_about_a_broken_kernel_has_a_place(self):
        self.edit("shade.glsl", lambda lines: lines.insert(0, "float a = one, b = two;\nfloat c = three;"))
        run = self.refuse_kernel(faults=None)
        for line in run.err.splitlines():
            self.assertRegex(line, r"^\S+:\d+: error: \S", run)
        self.assertIn("kernel/shade.glsl:1: error:", run.err)

    def test_a_fault_in_the_kernel_is_placed_there(self):
        place = self.line_of("whitted.comp", "void main()")
        self.edit("whitted.comp", lambda lines: lines.insert(place, "  notDeclared = 1;"))
        run = self.refuse_kernel(faults=None, says="notDeclared")
        self.assertRegex(run.err, rf"(?m)^kernel/whitted\.comp:{place + 1}: error: .*notDeclared")
        self.check_message(run, 1)

    def test_a_missing_include_is_named_with_the_line_that_wants_it(self):
        (self.path("kernel") / "shade.glsl").unlink()
        place = self.line_of("whitted.comp", '#include "shade.glsl"')
        run = self.refuse_kernel(faults=None, says="shade.glsl")
        self.assertRegex(run.err, rf"(?m)^kernel/whitted\.comp:{place}: error: .*shade\.glsl")
        self.check_message(run, 1)

    def test_an_include_of_itself_is_refused(self):
        self.write("kernel/loop.glsl", '#include "loop.glsl"\n')
        self.edit("whitted.comp", lambda lines: lines.append('#include "loop.glsl"'))
        run = self.refuse_kernel(faults=None, says="loop.glsl")
        self.assertRegex(run.err, r"loop\.glsl:1: error: ")

    def test_a_function_without_body_is_refused_in_one_line(self):
        self.edit("whitted.comp", lambda lines: lines.append("void nowhere();\nvoid user() { nowhere(); }"))
        place = self.line_of("whitted.comp", "void main()")
        self.edit("whitted.comp", lambda lines: lines.insert(place - 1, "void nowhere();"))
        self.edit("whitted.comp", lambda lines: lines.insert(place + 1, "  nowhere();"))
        run = self.refuse_kernel(says=["kernel/whitted.comp", "nowhere"])
        self.assertNotIn("ERROR", run.err)

    def test_an_empty_kernel_is_refused_in_one_line(self):
        self.write("kernel/whitted.comp", "")
        run = self.refuse_kernel(says="kernel/whitted.comp")
        self.assertNotIn("ERROR", run.err)

    def test_a_kernel_that_is_no_text_is_refused(self):
        self.write("kernel/whitted.comp", bytes(range(256)) * 16)
        self.refuse_kernel(faults=None, says="kernel/whitted.comp")

    def test_a_missing_kernel_is_named(self):
        (self.path("kernel") / "whitted.comp").unlink()
        self.refuse_kernel(says="kernel/whitted.comp")

    def test_a_missing_folder_of_shaders_is_named(self):
        shutil.rmtree(self.path("kernel"))
        self.refuse_kernel(says=["kernel", "--shaders"])
        self.write("kernel", "a file")
        self.refuse_kernel(says="kernel")


class ShaderCache(Command):
    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)
        # The driver's cache is empty too.
        self.caches = {"XDG_CACHE_HOME": str(self.path("cache")), "MESA_SHADER_CACHE_DIR": str(self.path("mesa"))}

    def render(self, **changes):
        """The picture's bytes and the seconds of compiling."""
        args = ["scene.json", *TINY, "--quiet", "-o", "a.exr", "--stats", "stats.json"]
        self.do("render", *args, env=self.caches | changes)
        return self.path("a.exr").read_bytes(), json.loads(self.path("stats.json").read_text())["seconds"]["compile"]

    def test_a_second_start_uses_what_the_first_has_compiled(self):
        picture, cold = self.render()
        (kept,) = self.path("cache/turner").iterdir()
        number = kept.stat().st_ino
        os.utime(kept, (0, 0))
        again, warm = self.render()
        self.assertEqual(again, picture)
        self.assertLess(warm, cold)
        self.assertEqual(list(self.path("cache/turner").iterdir()), [kept])
        self.assertGreater(kept.stat().st_mtime, 0, "marked as used")
        self.assertEqual(kept.stat().st_ino, number, "not written again")

    def test_a_damaged_or_unusable_cache_is_not_noticed(self):
        picture, _ = self.render()
        (kept,) = self.path("cache/turner").iterdir()
        whole = kept.read_bytes()
        kept.write_bytes(whole[: len(whole) // 2])
        self.assertEqual(self.render()[0], picture)
        self.assertEqual(kept.read_bytes(), whole)
        self.write("file", "not a folder")
        for nowhere in ("file", "no/such/folder"):
            self.assertEqual(self.render(XDG_CACHE_HOME=str(self.path(nowhere)))[0], picture, nowhere)
        self.assertEqual(self.render(XDG_CACHE_HOME="", HOME="")[0], picture)


def main():
    global PROGRAM, SCENES
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="the program to test")
    parser.add_argument("--scenes", type=pathlib.Path, required=True, help="the folder of Turner's scenes")
    options, rest = parser.parse_known_args()
    PROGRAM, SCENES = options.program.resolve(), options.scenes.resolve()
    for path in (PROGRAM, SCENES / "spheres.json", SCENES.parent / "shaders"):
        if not path.exists():
            parser.error(f"{path} does not exist")
    unittest.main(argv=[sys.argv[0], *rest])


if __name__ == "__main__":
    main()
