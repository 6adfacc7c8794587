#!/usr/bin/env python3
"""Holds scenes/scene.schema.json against the scenes: own ones pass, broken ones do not."""

import copy
import json
import pathlib
import re
import sys

import jsonschema

TESTS = pathlib.Path(__file__).resolve().parent
SCENES = TESTS.parent / "scenes"

# A string, or a comment: strings are matched first where they begin first, so a // inside one stays.
STRING_OR_COMMENT = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)

GOOD = {
    "background": [0, 0, 0],
    "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]},
    "lights": [{"position": [0, 5, 0]}],
    "materials": {"clay": {"diffuse": [1, 1, 1]}},
    "spheres": [{"center": [0, 0, 0], "material": "clay"}],
    "triangles": [{"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "material": "clay"}],
    "meshes": [{"file": "cow.obj", "material": "clay"}],
}

# Each breaks GOOD: the way to a value, and the value to put there.
BROKEN = [
    (["camra"], {}),
    (["background"], [0, 0]),
    (["background"], [0, 0, -1]),
    (["depth"], 0),
    (["depth"], 65),
    (["width"], 1.5),
    (["height"], 65537),
    (["camera", "fov"], 0),
    (["camera", "fov"], 180),
    (["camera", "up"], [0, 0, 0]),
    (["camera"], {"eye": [0, 0, 5]}),
    (["lights", 0, "falloff"], "linear"),
    (["materials", "clay", "reflect"], 1.1),
    (["materials", "clay"], {"transmit": 0.5, "ior": 0}),
    (["materials", "clay", "colour"], [1, 1, 1]),
    (["spheres", 0, "radius"], 0),
    (["spheres", 0, "center"], ["0", "0", "0"]),
    (["spheres", 0], {"center": [0, 0, 0]}),
    (["triangles", 0, "normals"], [[0, 0, 1], [0, 0, 0], [0, 0, 1]]),
    (["triangles", 0, "vertices"], [[0, 0, 0], [1, 0, 0]]),
    (["meshes", 0, "file"], "cow.ply"),
    (["meshes", 0, "scale"], -1),
]


def read_scene(path):
    text = path.read_text(encoding="utf-8")
    return json.loads(STRING_OR_COMMENT.sub(lambda m: m[0] if m[0].startswith('"') else " ", text))


def main():
    failures = []
    checks = 0

    def check(holds, claim):
        nonlocal checks
        checks += 1
        if not holds:
            failures.append(claim)

    schema = json.loads((SCENES / "scene.schema.json").read_text(encoding="utf-8"))
    kind = jsonschema.validators.validator_for(schema, default=None)
    check(kind is jsonschema.Draft202012Validator, "the schema names its draft")
    try:
        jsonschema.Draft202012Validator.check_schema(schema)
    except jsonschema.SchemaError as error:
        print(f"FAILED: the schema is not valid: {error.message}")
        return 1
    validator = jsonschema.Draft202012Validator(schema)

    scenes = sorted(path for path in SCENES.glob("*.json") if not path.name.endswith(".schema.json"))
    check(len(scenes) >= 10, "the folder of scenes is found")
    for path in scenes:
        faults = [f"{error.json_path}: {error.message}" for error in validator.iter_errors(read_scene(path))]
        check(not faults, f"{path.name} is a scene; {faults[:3]}")

    check(validator.is_valid({}), "the empty scene is a scene")
    check(validator.is_valid(GOOD), "the scene to be broken is a scene")
    for way, value in BROKEN:
        broken = copy.deepcopy(GOOD)
        place = broken
        for step in way[:-1]:
            place = place[step]
        place[way[-1]] = value
        check(not validator.is_valid(broken), f"{way} = {value} is refused")

    refused = [p for p in sorted((TESTS / "bad_scenes").glob("*.json")) if "// schema: refuses" in p.read_text()]
    check(len(refused) >= 15, "the folder of bad scenes is found")
    for path in refused:
        check(not validator.is_valid(read_scene(path)), f"bad_scenes/{path.name} is refused")

    for failure in failures:
        print(f"FAILED: {failure}")
    print(
        f"schema: {checks - len(failures)} of {checks} checks passed"
        f" ({len(scenes)} scenes, {len(BROKEN)} broken variations, {len(refused)} bad scenes)"
    )
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
