"""Odd machines: no home, a tree that cannot be written, little memory, one core. The program works, or says in one line
what it lacks.
"""

import os
import pathlib
import resource
import shutil
import subprocess
import unittest

from support.command import FAILED, TINY, Command
from support.settings import BUILD, SCENES

# Mesa complains on stderr that it can keep no shaders.
QUIET_DRIVER = {"MESA_SHADER_CACHE_DISABLE": "true"}


def with_memory(mebibytes):
    """For preexec_fn: as `ulimit -v`."""
    bytes_ = mebibytes << 20
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (bytes_, bytes_))


class Machines(Command):
    def test_without_a_home(self):
        self.do("render", SCENES / "spheres.json", *TINY, "-o", "a.exr",
                env=QUIET_DRIVER | {"HOME": "", "XDG_CACHE_HOME": ""})  # fmt: skip

    def test_a_home_that_cannot_be_written(self):
        home = self.folder / "home"
        home.write_text("no folder")
        self.do("render", SCENES / "spheres.json", *TINY, "-o", "a.exr",
                env=QUIET_DRIVER | {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")})  # fmt: skip

    def test_one_core(self):
        core = min(os.sched_getaffinity(0))
        self.do("render", SCENES / "spheres.json", *TINY, "-o", "a.exr",
                preexec_fn=lambda: os.sched_setaffinity(0, {core}))  # fmt: skip
        self.do("compare", SCENES / "spheres.json", *TINY, preexec_fn=lambda: os.sched_setaffinity(0, {core}))

    @unittest.skipIf("sanitize" in BUILD.name, "a sanitizer reserves terabytes")
    def test_little_memory(self):
        """Whatever runs out of it first, the message is one line and names the limit."""
        for mebibytes in (96, 192, 256, 320, 384, 448, 512):
            with self.subTest(f"{mebibytes} MiB"):
                run = self.run_turner("render", SCENES / "spheres.json", *TINY, "-o", "a.exr",
                                      preexec_fn=with_memory(mebibytes), env={"TURNER_VALIDATION": "0"})  # fmt: skip
                self.assertEqual(run.code, FAILED, run)
                self.check_message(run, says=f"{mebibytes} MiB of memory: ulimit -v")
                self.assertEqual(self.files(), [])

    @unittest.skipIf("sanitize" in BUILD.name, "a sanitizer reserves terabytes")
    def test_the_reference_needs_little(self):
        self.do("render", SCENES / "spheres.json", *TINY, "-o", "a.exr", "--backend", "reference",
                preexec_fn=with_memory(512), env={"TURNER_VALIDATION": "0"})  # fmt: skip

    def test_an_installation_that_cannot_be_written(self):
        """As another user, for whom the superuser's rights do not count."""
        installed = self.folder / "installed"
        subprocess.run(["cmake", "--install", BUILD, "--prefix", installed], check=True, stdout=subprocess.DEVNULL)
        for path in [installed, *installed.rglob("*")]:
            path.chmod(path.stat().st_mode & ~0o222)
        self.addCleanup(lambda: subprocess.run(["chmod", "-R", "u+w", installed], check=True))
        work = self.folder / "work"
        work.mkdir(mode=0o777)
        work.chmod(0o777)
        self.folder.chmod(0o755)
        as_nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] if os.geteuid() == 0 else []
        self.assertTrue(shutil.which("setpriv"))
        run = subprocess.run(
            [*as_nobody, installed / "bin/turner", "render", "scenes/spheres.json", *TINY, "-o", "a.exr"],
            cwd=work, env=self.environment(QUIET_DRIVER | {"HOME": "/nonexistent", "XDG_CACHE_HOME": ""}),
            capture_output=True, text=True)  # fmt: skip
        self.assertEqual(run.returncode, 0, run)
        self.assertEqual([path.name for path in pathlib.Path(work).iterdir()], ["a.exr"])
