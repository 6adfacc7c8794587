"""Edits of the shaders: picture and message of each."""

import os
import pathlib
import shutil

from support.editors import EDITORS, delete_and_write, write_and_rename, write_in_place
from support.patience import TIMEOUT, wait_until
from support.pictures import Exr, png_size
from support.session import HALF, SHADE, Session


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
            self.edit("whitted.comp", "weight * frame.background", "0.5 * weight * frame.background")
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
                    w.refused()
                    self.assertEqual(self.exr(), before)
                    if path.is_dir():
                        path.rmdir()
                    write_and_rename(path, text)
                    w.picture()
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

    def test_saves_in_quick_succession_end_in_the_last(self):
        """That they are one version is a matter of time: watch.timing."""
        with self.watch() as w:
            w.picture()
            w.figures()
            self.save_in_quick_succession()
            last = self.rendered()
            while self.exr() != last:
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
