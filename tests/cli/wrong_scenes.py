"""Wrong scenes: each fault is told with its place."""

import contextlib
import random

from support.command import DONE, TINY, WRONG_INPUT, Command
from support.rights import modes_bind, say_not_possible, without_superpowers
from support.scene_texts import MESH_SCENE, NFF, OBJ, SPHERE, remove_comments
from support.settings import SCENES, TESTS


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
            ('{ CLAY, "cones": [ §{ "base": [0,0,0], "base_radius": 0, "apex": [0,1,0], "apex_radius": 0, '
             '"material": "clay" } ] }', ["radii"]),
            ('{ CLAY, "cones": [ { "base": [0,0,0], "base_radius": §-1, "apex": [0,1,0], "apex_radius": 0, '
             '"material": "clay" } ] }', ["base_radius", "-1"]),
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
            (11, "f 0.8 0.7 0.6 0.5 0.5 20", ["f "]),
            (12, "s 0 1 0", ["s x y z"]),
            (12, "s 0 1 0 1 2", ["2"]),
            (12, "S 0 1 0 1", ["'S'", "'s'"]),
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
            (OBJ + "f 1 2 x\n", 5, ["'x'"]),
            (OBJ + "f 1/ 2/ 3/1/1/1\n", 5, ["corner"]),
            (OBJ + "v 1 2\nf 1 2 4\n", 5, ["v x y z"]),
            (OBJ + "v 1 2 nan\nf 1 2 4\n", 5, ["nan"]),
            (OBJ + "v 1 2 inf\nf 1 2 4\n", 5, ["inf"]),
            (OBJ + "v 1 2 1e400\nf 1 2 4\n", 5, ["1e400"]),
            (OBJ + "V 1 2 3\n", 5, ["'V'", "'v'"]),
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
