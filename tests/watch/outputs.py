"""Places of the pictures, and mistakes of the command line."""

import os
import signal
import subprocess
import threading

from support.patience import TIMEOUT, wait_until
from support.pictures import Exr, png_size
from support.rights import modes_bind, say_not_possible, without_superpowers
from support.session import BALL, HALF, SHADE, Session
from support.settings import PROGRAM, ROOT


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
                if not modes_bind(self.source("shade.glsl")):
                    return say_not_possible("a file that is closed to its owner")
                w.refused()
            finally:
                self.source("shade.glsl").chmod(0o644)
            w.wait_for_error("shade.glsl")
            w.picture()
            self.assertEqual(self.exr(), before)


class Overwriting(Session):
    """An input that an edit makes one is not written over either."""

    OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"

    def test_a_mesh_that_an_edited_scene_names(self):
        self.path("shape.obj").write_text(self.OBJ)
        with self.watch(outputs=("out.exr", "other.exr")) as w:
            w.picture()
            w.figures()
            before = self.exr()
            self.path("other.exr").unlink()
            self.path("other.exr").symlink_to("shape.obj")
            self.write_scene(BALL | {"meshes": [{"file": "shape.obj", "material": "clay"}]})
            refused = w.refused()
            self.assertEqual(refused["step"], "scene", w)
            self.assertIn("other.exr is an input, shape.obj", refused["diagnoses"][0]["message"], w)
            self.assertEqual(self.path("shape.obj").read_text(), self.OBJ)
            self.assertEqual(self.exr(), before)
            self.path("other.exr").unlink()
            self.write_scene(BALL | {"meshes": [{"file": "shape.obj", "material": "clay", "scale": 2}]})
            w.picture()
        self.assertEqual(self.path("shape.obj").read_text(), self.OBJ)

    def test_a_shader_that_an_edited_shader_includes(self):
        text = "// an include\n"
        self.source("more.glsl").write_text(text)
        with self.watch(outputs=("out.exr",)) as w:
            w.picture()
            w.figures()
            self.path("out.exr").unlink()
            self.path("out.exr").symlink_to("kernel/more.glsl")
            self.edit("shade.glsl", SHADE, HALF + '\n#include "more.glsl"\n')
            refused = w.refused()
            self.assertIn("is an input, kernel/more.glsl", refused["diagnoses"][0]["message"], w)
            self.assertEqual(self.source("more.glsl").read_text(), text)
            self.path("out.exr").unlink()
            self.edit("shade.glsl", HALF, SHADE)
            w.picture()
        self.assertEqual(self.source("more.glsl").read_text(), text)

    def test_an_output_that_becomes_a_link_to_an_input(self):
        text = self.path("scene.json").read_text()
        with self.watch(outputs=("out.exr",)) as w:
            w.picture()
            w.figures()
            self.path("out.exr").unlink()
            self.path("out.exr").symlink_to("scene.json")
            self.edit("shade.glsl", SHADE, HALF)
            w.outcome()
        self.assertEqual(self.path("scene.json").read_text(), text)


    def test_a_mesh_that_is_a_pipe_is_refused_and_not_waited_for(self):
        os.mkfifo(self.path("pipe.obj"))
        with self.watch(outputs=("out.exr",)) as w:
            w.picture()
            before = self.exr()
            self.write_scene(BALL | {"meshes": [{"file": "pipe.obj", "material": "clay"}]})
            self.assertIn("regular file", w.refused()["diagnoses"][0]["message"], w)
            self.assertEqual(self.exr(), before)


class Told(Session):
    def run_watch(self, by, code, **options):
        command = [str(PROGRAM), "watch", "scene.json", "--shaders", "kernel", "-o", "out.exr"]
        process = subprocess.Popen(command, cwd=self.folder, env=self.environment(), stdin=subprocess.DEVNULL,
                                   start_new_session=True, **options)
        self.addCleanup(process.kill)
        self.assertTrue(wait_until(self.path("out.exr").exists, TIMEOUT))
        before = self.exr()
        self.edit("shade.glsl", SHADE, HALF)
        self.assertTrue(wait_until(lambda: self.exr() != before and self.exr() == self.rendered(), TIMEOUT))
        self.assertIsNone(process.poll())
        os.killpg(process.pid, by)  # its children too, as a terminal does
        self.assertEqual(process.wait(TIMEOUT), code)
        self.check_nobody_left()
        self.assertEqual(self.temporary_files(), [])

    def test_a_full_disk_behind_what_is_told_does_not_end_it_and_sigterm_does(self):
        with open("/dev/full", "w") as full:
            self.run_watch(signal.SIGTERM, 143, stdout=full, stderr=full)

    def test_a_hang_up_ends_it_with_its_processes(self):
        """And none of them is said to have died. That it has ended is no error."""
        with open(self.path("errors"), "w") as errors:
            self.run_watch(signal.SIGHUP, 129, stdout=subprocess.DEVNULL, stderr=errors)
        errors = self.path("errors").read_text()
        self.assertNotIn("error", errors)

    def test_events_that_cannot_be_written_are_a_failure(self):
        with open("/dev/full", "w") as full:
            command = [str(PROGRAM), "watch", "scene.json", "--shaders", "kernel", "-o", "out.exr", "--json"]
            run = subprocess.run(command, cwd=self.folder, env=self.environment(), stdout=full, stderr=subprocess.PIPE,
                                 text=True, timeout=TIMEOUT)
        self.assertEqual(run.returncode, 1, run)
        self.assertIn("No space left on device", run.stderr)


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
