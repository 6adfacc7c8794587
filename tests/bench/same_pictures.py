#!/usr/bin/env python3
"""Renders the scenes with two builds and compares their pictures, pixel for pixel: for a change that must not show.

    python3 tests/bench/same_pictures.py OLD/turner NEW/turner [--backend shader|reference] [--width 128] [SCENE...]

All scenes of scenes/ and scenes/spd/, if none are named, by shader and reference; grid 1, jitter 3 (seed 5), sobol 4, and
a crop. Each build reads its own shaders. Prints a line for each picture that differs, with the greatest difference of a
channel; exit code 1 if there is one.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from support.pictures import Exr

SCENES = pathlib.Path(__file__).resolve().parent.parent.parent / "scenes"
VARIANTS = {
    "grid 1": ["--samples", "1"],
    "jitter 3": ["--samples", "3", "--sampler", "jitter", "--seed", "5"],
    "sobol 4": ["--samples", "4", "--sampler", "sobol"],
    "crop": ["--samples", "2", "--crop", "20,30,77,101"],
}


def all_scenes():
    own = [path for path in SCENES.glob("*.json") if not path.name.endswith(".schema.json")]
    return sorted(own) + sorted(SCENES.glob("spd/*.nff"))


def render(program, scene, options):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "picture.exr"
        subprocess.run([program, "render", scene, "--quiet", "-o", path, *options], check=True)
        return Exr(path)


def difference(a, b):
    """The greatest of a channel; None where all bits are equal, those of NaN and of -0 too."""
    if a.data == b.data and all(a.rows[y][c].tobytes() == b.rows[y][c].tobytes() for y in a.rows for c in range(3)):
        return None
    if a.data != b.data:
        return float("inf")
    return max(abs(p - q) for y in a.rows for c in range(3) for p, q in zip(a.rows[y][c], b.rows[y][c]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("new", type=pathlib.Path)
    parser.add_argument("scenes", type=pathlib.Path, nargs="*")
    parser.add_argument("--backend", choices=["shader", "reference"])
    parser.add_argument("--width", type=int, default=128)
    options = parser.parse_intermixed_args()
    compared, different = 0, 0
    for scene in options.scenes or all_scenes():
        for backend in [options.backend] if options.backend else ["shader", "reference"]:
            for name, variant in VARIANTS.items():
                size = ["--width", str(options.width), "--height", str(options.width), "--backend", backend]
                found = difference(*(render(program.resolve(), scene.resolve(), size + variant)
                                     for program in (options.old, options.new)))
                compared += 1
                if found is not None:
                    different += 1
                    print(f"{scene.name}, {backend}, {name}: differs by {found:.3g}", flush=True)
    print(f"{compared} pictures, {different} differ")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
