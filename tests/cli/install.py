"""A build is installed into an empty folder and used from there: the program must find its own shaders and scenes."""

import json
import os
import pathlib
import signal
import subprocess
import tempfile
import unittest

from support.settings import BUILD


class Install(unittest.TestCase):
    def watch_a_copy(self, program, folder, shaders):
        """Copies the installed shaders, edits the copy while it is watched, and ends by Ctrl-C."""
        copied = subprocess.run([program, "shaders", "--copy", "my"], cwd=folder, check=True, stdout=subprocess.PIPE,
                                text=True)
        self.assertIn(shaders, copied.stdout)
        command = [program, "watch", "scenes/spheres.json", "--shaders", "my", "--width", "32", "--height", "18", "--json"]
        with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as watching:
            try:
                for version in (1, 2):
                    told = next(e for e in map(json.loads, watching.stdout) if e["event"] in ("version", "refused"))
                    self.assertTrue(told["event"] == "version" and told["version"] == version, told)
                    source = folder / "my" / "shade.glsl"
                    source.write_text(source.read_text().replace("float q = 0.5", "float q = 0.1"))
                self.assertTrue(told["changed"] == ["shade.glsl"] and told["changed_pixels"] > 0, told)
                watching.send_signal(signal.SIGINT)
                self.assertEqual(watching.wait(timeout=60), 130)
            finally:
                watching.kill()

    def test_an_installed_program_works_alone(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        folder = pathlib.Path(temporary.name)
        prefix, elsewhere = folder / "prefix", folder / "elsewhere"
        elsewhere.mkdir()
        subprocess.run(["cmake", "--install", BUILD, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
        program = prefix / "bin" / "turner"
        done = subprocess.run([program, "render", "scenes/spheres.json", "--width", "32", "--height", "18"],
                              cwd=elsewhere, check=True, stdout=subprocess.PIPE, text=True, timeout=600)
        self.assertIn(str(prefix / "share/turner/scenes/spheres.json"), done.stdout)
        self.assertGreater(os.path.getsize(elsewhere / "spheres.exr"), 0)
        json.loads((prefix / "share/turner/scenes/scene.schema.json").read_text())

        self.watch_a_copy(program, elsewhere, str(prefix / "share/turner/shaders"))

        # Without its own shaders it must not pass silently to others': it falls back to the source tree it was built
        # from, and says what is wrong when an explicit folder is empty.
        refused = subprocess.run([program, "render", "scenes/spheres.json", "--shaders", str(elsewhere)],
                                 cwd=elsewhere, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        self.assertEqual(refused.returncode, 2, refused)
        self.assertIn("whitted.comp", refused.stderr)
