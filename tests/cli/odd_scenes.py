"""Scenes that are not quite right and render all the same: the picture is that of the right file, and a note says what
was odd, how often, and where first."""

import re

from support.command import TINY, Command
from support.pictures import Exr

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
WHOLE = SQUARE + "f 1 2 3 4\n"
FOLDED = "v 0 0 0\nv 1 0 0\nv 1 0 0.5\nv 0 1 0\n"
CROSSING = "v 0 0 0\nv 0.35 0.8 -0.11\nv 0.28 0.51 -0.07\nv -0.01 -0.23 -0.24\n"

SCENE = """{
  "width": 32, "height": 32, "background": [0, 0, 1],
  "camera": { "eye": [0.5, -2, 2.5], "target": [0.5, 0.4, 0], "fov": 40 },
  "lights": [ { "position": [0.5, -2, 3] } ],
  "materials": { "white": { "diffuse": [1, 1, 1] } },
  "meshes": [ { "file": "shape.obj", "material": "white" } ]
}
"""

NFF = """v
from 3 -2 -1
at 0.3 -0.3 -1
up 0 1 0
angle 45
hither 1
resolution 32 32
b 0 0 1
l 3 -2 -1 1 1 1
f 1 1 1 1 0 1 0 1
"""


class OddScenes(Command):
    def rendered(self, scene, *options):
        """The picture's values, and the notes; by the reference, which makes a picture sooner of what both are given."""
        run = self.do("render", scene, "--backend", "reference", "-o", "picture.exr", *options)
        notes = [line for line in run.out.splitlines() if ": note: " in line]
        return Exr(self.path("picture.exr")).values(), notes

    def mesh(self, content):
        self.write("shape.obj", content)
        return self.rendered(self.write("scene.json", SCENE))

    def test_odd_meshes_have_the_picture_of_the_right_ones(self):
        right = {}
        for odd, same, notes in (
            (FOLDED + "f 1 2 3 4\n", FOLDED + "f 1 2 3\nf 1 3 4\n", []),
            (CROSSING + "f 1 2 3 4\n", CROSSING + "f 1 2 3\nf 1 3 4\n", []),
            (SQUARE + "usemtl wood\\\nf 1 2 3\n# \\\nf 1 3 4\n", WHOLE, []),
            (WHOLE.replace("\n", "\r"), WHOLE, []),
            (WHOLE + "\x1a", WHOLE, []),
            (b"\xff\xfe" + WHOLE.encode("utf-16-le"), WHOLE, []),
            (WHOLE.encode("utf-16-be"), WHOLE, []),
            (WHOLE + "f 1 2\nf 3\n", WHOLE, ["shape.obj:6:1: note: 2 faces of fewer than 3 corners"]),
            (WHOLE.replace("0 1 0", "0 1 0 nan nan nan"), WHOLE, ["shape.obj:4:1: note: 1 vertex has something behind"]),
            (WHOLE + "v nan 0 0\n", WHOLE, ["shape.obj:6:1: note: 1 vertex is no place"]),
            (SQUARE + "vn nan nan nan\nvn 0 0 1\nf 1//2 2//2 3//2 4//2\n", WHOLE, ["shape.obj:5:1: note: 1 normal has no"]),
            (SQUARE + "vn 0 0 0\nf 1//1 2//1 3//1 4//1\n", WHOLE, ["shape.obj:5:1: note: 1 normal has no direction"]),
            (SQUARE + "f 1//1 2//2 3//3 4//4\n", WHOLE, ["shape.obj:5:1: note: 1 face lacks the normal"]),
            (SQUARE + "vw 1 0 0.5\nf 1 2 3 4\n", WHOLE, ["shape.obj:5:1: note: 1 unknown statement was passed over: 'vw'"]),
            (SQUARE + "f 1 2 4 3\nf 1 2 3 4\nf 1 2 4 3\nf 2 1 3 4\n", WHOLE, ["shape.obj:5:1: note: 3 faces cross"]),
        ):
            with self.subTest(odd):
                if same not in right:
                    right[same], none = self.mesh(same)
                    self.assertEqual(none, [])
                    self.assertGreater(sum(value == 0 for value in right[same]), 0)
                values, told = self.mesh(odd)
                self.assertEqual(values, right[same])
                self.assertEqual(len(told), len(notes), told)
                for line, start in zip(told, notes):
                    self.assertTrue(line.startswith(start), f"{line}\nexpected: {start}")

    def test_warped_polygons_of_nff_keep_all_corners(self):
        corners = ["0 0 0", "0 0 -2", "1 0 -1", "0 -1 0"]
        polygons = ["\n".join(["p %d" % len(c), *c]) + "\n" for c in (corners, corners[:3], [corners[0], *corners[2:]])]
        values, notes = self.rendered(self.write("warped.nff", NFF + polygons[0]))
        self.assertEqual(values, self.rendered(self.write("right.nff", NFF + polygons[1] + polygons[2]))[0])
        self.assertEqual(notes, [])

    def test_all_scene_formats_take_other_encodings(self):
        text = NFF + "s 0 0 -1 1\n"
        right, _ = self.rendered(self.write("ball.nff", text))
        for content in (text.replace("\n", "\r"), text.encode("utf-16"), text + "\x1a"):
            self.assertEqual(self.rendered(self.write("odd.nff", content)), (right, []))
        right, _ = self.mesh(WHOLE)
        for content in (SCENE.replace("\n", "\r"), SCENE.encode("utf-16"), SCENE.encode("utf-16-be"), SCENE + "\x1a"):
            self.assertEqual(self.rendered(self.write("odd.json", content)), (right, []))

    def test_notes_are_told_once_by_each_command_and_not_when_quiet(self):
        self.write("shape.obj", WHOLE + "vw\n" * 7)
        scene = self.write("scene.json", SCENE)
        note = "shape.obj:6:1: note: 7 unknown statements were passed over: 'vw', did you mean 'v'?; the first is here"
        for command in (["render", scene], ["compare", scene]):
            with self.subTest(command[0]):
                run = self.do(*command, *TINY)
                self.assertEqual(len(re.findall(re.escape(note), run.out + run.err)), 1, run)
                run = self.do(*command, *TINY, "--quiet")
                self.assertNotIn("note:", run.out + run.err)
