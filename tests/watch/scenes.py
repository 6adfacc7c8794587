"""Edits of the scene and its meshes."""

import json
import pathlib
import time

from support.editors import EDITORS, write_and_rename, write_in_place
from support.pictures import Exr, png_size
from support.session import BALL, HALF, LARGE, SHADE, Session

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
            self.check_takes(w.picture()["at"] - started, 3, w)
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
            w.interrupt(most=2)
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
