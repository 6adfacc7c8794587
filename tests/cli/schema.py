"""Compares scenes/scene.schema.json with the scenes: own ones pass, broken ones do not."""

import copy
import json
import re
import unittest

import jsonschema

from support.settings import SCENES, TESTS

# A string, or a comment: strings are matched first where they begin first, so a // inside one stays.
STRING_OR_COMMENT = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)

# Has every key that there is, so that a broken value is refused for itself and not for its key.
GOOD = {
    "$schema": "scene.schema.json",
    "background": [0, 0, 0],
    "depth": 4,
    "width": 64,
    "height": 48,
    "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 40},
    "lights": [{"position": [0, 5, 0], "color": [1, 1, 1], "falloff": "inverse-square"}],
    "params": {"softness": 0.3, "tint": [1, 0.5, 0], "on": True},
    "materials": {"clay": {"diffuse": [1, 1, 1], "specular": [0.1, 0.1, 0.1], "shininess": 9, "reflect": 0.2,
                           "transmit": 0.3, "ior": 1.5}},
    "spheres": [{"center": [0, 0, 0], "radius": 1, "material": "clay"}],
    "cones": [{"base": [0, 0, 0], "base_radius": 1, "apex": [0, 2, 0], "apex_radius": 0, "material": "clay"}],
    "triangles": [{"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "normals": [[0, 0, 1], [0, 0, 1], [0, 0, 1]],
                   "material": "clay"}],
    "meshes": [{"file": "cow.obj", "material": "clay", "scale": 2, "rotate": [0, 90, 0], "translate": [1, 2, 3]}],
}

# Each breaks GOOD: the way to a value, and the value to put there.
BROKEN = [
    (["camra"], {}),
    (["background"], [0, 0]),
    (["params", "softness"], "0.3"),
    (["params", "tint"], [1, 2, 3, 4, 5]),
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
    (["cones", 0, "base_radius"], -1),
    (["cones", 0, "apex_radius"], "1"),
    (["cones", 0, "apex"], [0, 1]),
    (["cones", 0, "radius"], 1),
    (["cones", 0], {"base": [0, 0, 0], "base_radius": 1, "apex": [0, 2, 0], "apex_radius": 0}),
    (["cones", 0], {"base": [0, 0, 0], "base_radius": 1, "apex": [0, 2, 0], "material": "clay"}),
    (["cones", 0], {"base": [0, 0, 0], "base_radius": 1, "apex_radius": 0, "material": "clay"}),
    (["triangles", 0, "normals"], [[0, 0, 1], [0, 0, 0], [0, 0, 1]]),
    (["triangles", 0, "vertices"], [[0, 0, 0], [1, 0, 0]]),
    (["meshes", 0, "file"], "cow.ply"),
    (["meshes", 0, "scale"], -1),
]


def read_scene(path):
    text = path.read_text(encoding="utf-8")
    return json.loads(STRING_OR_COMMENT.sub(lambda m: m[0] if m[0].startswith('"') else " ", text))


class Schema(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.schema = json.loads((SCENES / "scene.schema.json").read_text(encoding="utf-8"))
        cls.validator = jsonschema.Draft202012Validator(cls.schema)

    def test_it_names_its_draft_and_is_valid(self):
        kind = jsonschema.validators.validator_for(self.schema, default=None)
        self.assertIs(kind, jsonschema.Draft202012Validator)
        jsonschema.Draft202012Validator.check_schema(self.schema)

    def test_own_scenes_pass(self):
        scenes = sorted(path for path in SCENES.glob("*.json") if not path.name.endswith(".schema.json"))
        self.assertGreaterEqual(len(scenes), 10, "the folder of scenes is found")
        for path in scenes:
            with self.subTest(path.name):
                faults = [f"{error.json_path}: {error.message}" for error in self.validator.iter_errors(read_scene(path))]
                self.assertEqual(faults[:3], [])
        self.assertTrue(self.validator.is_valid({}), "the empty scene is a scene")
        self.assertTrue(self.validator.is_valid(GOOD), "the scene to be broken is a scene")

    def test_the_scene_to_be_broken_has_every_key(self):
        self.assertEqual(set(GOOD), set(self.schema["properties"]))
        objects = {name: set(kind["properties"]) for name, kind in self.schema["$defs"].items() if "properties" in kind}
        there = {"camera": GOOD["camera"], "light": GOOD["lights"][0], "material": GOOD["materials"]["clay"],
                 "sphere": GOOD["spheres"][0], "cone": GOOD["cones"][0], "triangle": GOOD["triangles"][0],
                 "mesh": GOOD["meshes"][0]}
        self.assertEqual({name: set(keys) for name, keys in there.items()}, objects)

    def test_broken_scenes_are_refused(self):
        for way, value in BROKEN:
            with self.subTest(f"{way} = {value}"):
                broken = copy.deepcopy(GOOD)
                place = broken
                for step in way[:-1]:
                    place = place[step]
                place[way[-1]] = value
                self.assertFalse(self.validator.is_valid(broken))

    def test_the_collected_wrong_scenes_are_refused(self):
        refused = [p for p in sorted((TESTS / "bad_scenes").glob("*.json")) if "// schema: refuses" in p.read_text()]
        self.assertGreaterEqual(len(refused), 15, "the folder of bad scenes is found")
        for path in refused:
            with self.subTest(path.name):
                self.assertFalse(self.validator.is_valid(read_scene(path)))
