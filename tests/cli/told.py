"""What is only told never ends the work; what is printed as a result must arrive."""

import os
import signal
import subprocess

from support.command import DONE, FAILED, SMALL, TINY, Command
from support.pictures import Exr, write_exr
from support.scene_texts import SPHERE
from support.settings import PROGRAM, SCENES

REFERENCE = ["--backend", "reference"]
# Seconds: so long that progress is told on what is no terminal.
PROGRESS = ["--width", "200", "--height", "150", "--samples", "16", *REFERENCE]


class Told(Command):
    def setUp(self):
        super().setUp()
        self.write("scene.json", SPHERE)

    def code(self, *args, **options):
        """The exit code of a run whose descriptors are not pipes to us."""
        command = [str(PROGRAM), *map(str, args)]
        return subprocess.run(command, cwd=self.folder, env=self.environment(None), timeout=180, **options).returncode

    def shell(self, script):
        """The exit code of a shell's last command; turner is $T."""
        environment = self.environment({"T": str(PROGRAM)})
        command = ["bash", "-o", "pipefail", "-c", script]
        return subprocess.run(command, cwd=self.folder, env=environment, timeout=180, capture_output=True, text=True)

    def test_progress_on_a_full_disk_does_not_end_a_render(self):
        with open("/dev/full", "w") as full:
            code = self.code("render", SCENES / "spheres.json", *PROGRESS, "-o", "out.exr", stdout=full, stderr=full)
        self.assertEqual(code, DONE)
        self.assertEqual(Exr(self.path("out.exr")).width, 200)

    def test_what_was_loaded_and_written_does_not_end_a_render(self):
        for backend in ("shader", "reference"):
            with self.subTest(backend), open("/dev/full", "w") as full:
                args = ["render", "scene.json", *SMALL, "--backend", backend, "-o", "out.exr", "--stats", "stats.json"]
                self.assertEqual(self.code(*args, stdout=full, stderr=full), DONE)
                self.assertEqual(Exr(self.path("out.exr")).width, 64)
                self.assertGreater(self.path("stats.json").stat().st_size, 0)
                self.path("out.exr").unlink()

    def test_a_reader_that_leaves_does_not_end_a_render(self):
        run = self.shell(f'"$T" render "{SCENES}/spheres.json" {" ".join(PROGRESS)} -o out.exr 2>&1 | head -c 1')
        self.assertEqual((run.returncode, run.stderr), (DONE, ""))
        self.assertEqual(Exr(self.path("out.exr")).width, 200)

    def test_a_result_that_nobody_reads_is_a_failure(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        for command in ("compare a.exr a.exr --json", "devices"):
            with self.subTest(command):
                run = self.shell(f'"$T" {command} | (exec <&-; sleep 1)')
                self.assertEqual(run.returncode, FAILED, run)
                self.assertIn("Broken pipe", run.stderr)

    def test_the_error_image_is_written_before_the_figures_fail(self):
        write_exr(self.path("a.exr"), 2, 2, [(0, 0, 0)] * 4)
        with open("/dev/full", "w") as full:
            run = self.run_turner("compare", "a.exr", "a.exr", "--error-image", "error.exr", stdout=full)
        self.assertEqual(run.code, FAILED, run)
        self.check_message(run, says="No space left on device")
        self.assertEqual(Exr(self.path("error.exr")).width, 2)

    def test_an_output_that_fails_does_not_keep_the_others(self):
        self.path("full.exr").symlink_to("/dev/full")
        outputs = ["-o", "full.exr", "-o", "out.exr", "--stats", "stats.json"]
        run = self.run_turner("render", "scene.json", *TINY, *REFERENCE, *outputs)
        self.assertEqual(run.code, FAILED, run)
        self.check_message(run, says=["full.exr", "No space left on device"])
        self.assertEqual(Exr(self.path("out.exr")).width, 8)
        self.assertGreater(self.path("stats.json").stat().st_size, 0)

    def test_closed_descriptors_are_no_place_for_a_file(self):
        """A file that got the number 1 or 2 would have the lines in it that are told."""
        witness = self.do("render", "scene.json", *SMALL, "-o", "witness.exr") and self.path("witness.exr").read_bytes()
        for closed in (">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            with self.subTest(closed):
                run = self.shell(f'"$T" render scene.json {" ".join(SMALL)} -o out.exr {closed}')
                self.assertEqual(run.returncode, DONE, run)
                self.assertEqual(self.path("out.exr").read_bytes(), witness)
                os.mkfifo(self.path("fifo.exr"))
                render = f'"$T" render scene.json {" ".join(SMALL)} -o fifo.exr {closed}'
                run = self.shell(f"{render} & cat fifo.exr > out.exr; wait $!")
                self.assertEqual(run.returncode, DONE, run)
                self.assertEqual(self.path("out.exr").read_bytes(), witness)
                self.path("fifo.exr").unlink()

    def test_results_on_a_closed_stdout_are_a_failure(self):
        for command in ("devices", "--help", "--version"):
            with self.subTest(command):
                run = self.shell(f'"$T" {command} >&-')
                self.assertEqual(run.returncode, FAILED, run)
                self.assertIn("Bad file descriptor", run.stderr)

    def stalled(self):
        """Both ends of a pipe that takes no more."""
        ours, theirs = os.pipe()
        self.addCleanup(os.close, ours)
        os.set_blocking(theirs, False)
        try:
            while True:
                os.write(theirs, bytes(4096))
        except BlockingIOError:
            os.set_blocking(theirs, True)
        return ours, theirs

    def test_a_stderr_that_takes_no_more_is_waited_for_until_ctrl_c(self):
        for act in ("read", "interrupt"):
            with self.subTest(act):
                ours, theirs = self.stalled()
                command = [str(PROGRAM), "render", "missing.json"]
                process = subprocess.Popen(command, cwd=self.folder, stderr=theirs, stdout=subprocess.DEVNULL)
                os.close(theirs)
                self.addCleanup(process.kill)
                with self.assertRaises(subprocess.TimeoutExpired):
                    process.wait(1)
                if act == "read":
                    os.read(ours, 1 << 16)
                else:
                    process.send_signal(signal.SIGINT)
                self.assertEqual(process.wait(60), 2)
