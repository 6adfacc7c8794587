"""Outputs that cannot be written, full disks, and what a killed run has left."""

import contextlib
import fcntl
import os
import resource
import shutil
import subprocess

from support.command import FAILED, LONG, NO_DRIVER, TINY, Command
from support.pictures import Exr
from support.rights import modes_bind, say_not_possible, without_superpowers
from support.scene_texts import SPHERE


class Outputs(Command):
    """Places that cannot be written. All of them are found before a long render has begun."""

    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)
        self.long = ["render", "scene.json", *LONG]

    def refuse_place(self, place, says, **options):
        for option in ("-o", "--stats"):
            with self.subTest(f"{option} {place}"):
                run = self.refuse(*self.long, option, place, says=says, **options)
                self.assertNotIn("device:", run.out, "found before the work begins")
        if not str(place).endswith("/"):
            self.refuse("compare", "scene.json", *LONG, "--error-image", place, says=says, **options)
        # A good place does not help a bad one.
        self.refuse(*self.long, "-o", "good.exr", "-o", place, says=says, **options)

    def test_a_missing_folder_is_refused(self):
        self.refuse_place("nowhere/out.exr", "nowhere")

    def test_a_file_is_no_folder(self):
        self.refuse_place("scene.json/out.exr", "scene.json")

    def test_a_folder_is_no_file(self):
        self.path("out.exr").mkdir()
        self.refuse_place("out.exr", "folder")
        self.refuse(*self.long, "-o", "out.exr/", says="out.exr")

    def test_other_endings_are_refused_with_those_that_are_known(self):
        for name in ("out.jpg", "out.json", "out", "exr", ".exr.", "out.exr.tmp", "folder/", ".", "/"):
            with self.subTest(name):
                self.refuse(*self.long, "-o", name, says=[".exr", ".png"])

    def test_names_too_long_are_refused(self):
        self.refuse_place("x" * 300 + ".exr", "too long")

    def test_links_in_a_ring_are_refused(self):
        self.path("ring.exr").symlink_to("gnir.exr")
        self.path("gnir.exr").symlink_to("ring.exr")
        self.refuse_place("ring.exr", "ring.exr")

    def test_a_folder_without_permission_is_refused(self):
        self.path("locked").mkdir()
        self.path("locked").chmod(0o555)
        if not modes_bind(self.path("locked")):
            return say_not_possible("a folder that the user may not write")
        self.refuse_place("locked/out.exr", "locked", preexec_fn=without_superpowers)

    def test_a_file_without_permission_is_refused_and_stays(self):
        self.write("locked.exr", b"was here before")
        self.path("locked.exr").chmod(0o444)
        if not modes_bind(self.path("locked.exr")):
            return say_not_possible("a file that the user may not write")
        self.refuse_place("locked.exr", "locked.exr", preexec_fn=without_superpowers)

    def test_a_read_only_file_system_is_refused(self):
        with self.mounted("ro") as folder:
            if folder:
                self.refuse_place(f"{folder.name}/out.exr", folder.name)

    def test_existing_files_stay_as_they_were_when_a_run_fails(self):
        for name in ("out.exr", "out.png", "stats.json"):
            self.write(name, b"was here before")
        outputs = ["-o", "out.exr", "-o", "out.png", "--stats", "stats.json"]
        self.refuse("render", "missing.json", *outputs)
        self.refuse("render", "scene.json", *outputs, "--width", "0")
        self.refuse("render", "scene.json", *outputs, "--device", "no such device", faults=None)
        self.refuse("render", "scene.json", *outputs, "--shaders", "nowhere")
        self.refuse("render", "scene.json", *outputs, "--work-group", "1000000")
        self.refuse("render", "scene.json", *outputs, code=FAILED, env=NO_DRIVER)

    # --- full disks: the same promise for a device, a limit on the size of files, and a disk that is really full

    def test_a_full_device_behind_a_link_fails(self):
        for name in ("out.exr", "out.png"):
            self.path(name).symlink_to("/dev/full")
            for backend in ("shader", "reference"):
                run = self.refuse(
                    "render", "scene.json", "-o", name, "--backend", backend, code=FAILED, says=[name, "No space left"]
                )
                self.assertNotIn("wrote", run.out)

    def test_figures_on_a_full_device_fail(self):
        self.path("full.json").symlink_to("/dev/full")
        run = self.run_turner("render", "scene.json", "--backend", "reference", "--stats", "full.json", "-o", "out.exr")
        self.assertEqual(run.code, FAILED, run)
        self.check_message(run, 1, ["full.json", "No space left"])
        # The picture is there whole or not at all.
        if self.path("out.exr").exists():
            self.assertEqual(Exr(self.path("out.exr")).width, 64)
        self.assertEqual([name for name in self.files() if name.startswith(".")], [])

    def test_an_error_image_on_a_full_device_fails(self):
        self.do("render", "scene.json", "--backend", "reference", "-o", "a.exr")
        self.path("full.exr").symlink_to("/dev/full")
        args = ["compare", "a.exr", "a.exr", "--error-image", "full.exr"]
        self.refuse(*args, code=FAILED, says=["full.exr", "No space left"])

    def test_a_limit_on_the_size_of_files_fails_and_leaves_nothing(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

        self.write("out.exr", b"was here before")
        # A shell's `ulimit -f` sends a signal at the limit; where that is ignored, write() reports it.
        for signals in (False, True):
            for name in ("out.exr", "out.png", "new.exr"):
                with self.subTest(name, signals=signals):
                    args = ["render", "scene.json", "--width", "256", "--height", "256", "--backend", "reference"]
                    says = [name, "File too large"]
                    options = {"preexec_fn": limit, "restore_signals": signals}
                    run = self.refuse(*args, "-o", name, code=FAILED, says=says, **options)
                    self.assertNotIn("wrote", run.out)

    def test_a_full_disk_fails_and_leaves_nothing(self):
        with self.mounted("size=64k") as disk:
            if not disk:
                return
            (disk / "out.exr").write_bytes(b"was here before")
            (disk / "filler").write_bytes(bytes(48 * 1024))
            size = ["--width", "256", "--height", "256"]
            for backend in ("shader", "reference"):
                for name in ("out.exr", "new.exr"):
                    output = f"{disk.name}/{name}"
                    options = ["--backend", backend, "-o", output]
                    run = self.refuse(
                        "render", "scene.json", *size, *options, code=FAILED, says=[output, "No space left"]
                    )
                    self.assertNotIn("wrote", run.out)
            # With room again it works.
            (disk / "filler").unlink()
            self.do("render", "scene.json", *TINY, "--backend", "reference", "-o", f"{disk.name}/out.exr")
            self.assertEqual(sorted(p.name for p in disk.iterdir()), ["out.exr"])

    # --- replacing: the rights of the old file, the leavings of killed runs

    def render(self, *outputs, **options):
        args = [word for name in outputs for word in ("-o", name)]
        self.do("render", "scene.json", *TINY, "--backend", "reference", *args, **options)

    def test_a_replaced_file_keeps_its_rights(self):
        for mode in (0o600, 0o640, 0o664, 0o4755):
            with self.subTest(oct(mode)):
                self.write("out.exr", b"was here before")
                self.path("out.exr").chmod(mode)
                self.render("out.exr")
                self.assertEqual(oct(self.path("out.exr").stat().st_mode & 0o7777), oct(mode))

    def test_a_replaced_file_keeps_its_owner_and_group(self):
        self.write("out.exr", b"was here before")
        self.path("out.exr").chmod(0o640)
        if os.geteuid() != 0:
            return say_not_possible("a file of another owner")
        os.chown(self.path("out.exr"), 12345, 54321)
        self.render("out.exr")
        found = self.path("out.exr").stat()
        self.assertEqual((found.st_uid, found.st_gid, found.st_mode & 0o7777), (12345, 54321, 0o640))

    def test_a_new_file_has_the_rights_of_the_umask(self):
        self.render("out.exr", umask=0o027)
        self.assertEqual(oct(self.path("out.exr").stat().st_mode & 0o7777), oct(0o640))

    def test_what_a_killed_run_has_left_goes_with_the_next(self):
        ended = subprocess.Popen(["true"])
        ended.wait()
        gone, alive = ended.pid, os.getpid()
        left = [self.write(f".out.exr.turner-{gone}{end}", b"half a picture") for end in ("", "-1")]
        kept = [
            self.write(name, b"somebody's")
            for name in (
                f".out.exr.turner-{alive}",  # it lives
                f".out.exr.turner-{gone}-2",  # locked below: in another container it lives
                f".out.exr.turner-{gone}.bak",
                f".other.exr.turner-{gone}",  # of another target
                "out.exr.turner-1",
            )
        ]
        (self.path(f".out.exr.turner-{gone}-3")).mkdir()
        self.path(f".out.exr.turner-{gone}-4").symlink_to("scene.json")
        with open(self.path(kept[1])) as locked:
            fcntl.flock(locked, fcntl.LOCK_EX)
            self.render("out.exr")
        for name in left:
            self.assertFalse(self.path(name).exists(), name)
        for name in kept:
            self.assertEqual(self.path(name).read_bytes(), b"somebody's", name)
        self.assertEqual(self.path("scene.json").read_text(), SPHERE)
        self.assertTrue(self.path(f".out.exr.turner-{gone}-3").is_dir())
        self.assertTrue(self.path(f".out.exr.turner-{gone}-4").is_symlink())

    @contextlib.contextmanager
    def mounted(self, options):
        """A small file system in memory; none, with a word about it, where mounting is not allowed."""
        folder = self.path("disk")
        folder.mkdir()
        mount = None
        if os.geteuid() == 0 and shutil.which("mount"):
            command = ["mount", "-t", "tmpfs", "-o", options, "turner-test", str(folder)]
            mount = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        if mount is None or mount.returncode != 0:
            why = mount.stderr.decode().strip() if mount else "only the superuser can mount one"
            say_not_possible(f"a file system with the option {options} ({why})")
            yield None
            return
        try:
            yield folder
        finally:
            subprocess.run(["umount", str(folder)], check=True)
