"""A report that is interrupted, killed or damaged goes on."""

import os
import signal
import subprocess
import time

from support.reports import TIMEOUT, InFolder, load, point, run
from support.settings import PROGRAM, ROOT


class Interrupted(InFolder):
    ARGUMENTS = ["--width", "64", "--max-samples", "4", "--repeats", "3"]

    def start(self):
        process = subprocess.Popen([str(PROGRAM), "report", ROOT / "scenes/spheres.json", *self.ARGUMENTS, "-o",
                                    self.folder / "out"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        return process

    def journal(self):
        found = list((self.folder / "out/unfinished").glob("*/journal"))
        return found[0].read_text() if found else ""

    # Lets a report run until it has measured so much, then ends it.
    def interrupt_after(self, lines, how):
        process = self.start()
        before = time.monotonic()
        while self.journal().count("\n") < lines:
            self.assertIsNone(process.poll(), "it ended before it could be interrupted")
            self.assertLess(time.monotonic() - before, TIMEOUT)
            time.sleep(0.02)
        process.send_signal(how)
        output = process.communicate(timeout=60)
        return process.returncode, output

    def test_a_killed_report_goes_on_and_measures_nothing_twice(self):
        # Once in the first pass, once among the repeats.
        for lines in (9, 75):
            self.interrupt_after(lines, signal.SIGKILL)
        self.assertEqual([p.name for p in (self.folder / "out").iterdir()], ["unfinished"])
        measured = {}
        for line in self.journal().splitlines():
            if line.startswith("measured"):
                _, name, repeat, seconds, _ = line.split()
                measured[name, int(repeat)] = float(seconds)
        self.assertGreaterEqual(len(measured), 74)
        # A line that was cut short is measured again, and harms nothing.
        journal = next((self.folder / "out/unfinished").glob("*/journal"))
        journal.write_text(journal.read_text() + "measured 1-spheres-refer")

        done = run(["report", ROOT / "scenes/spheres.json", *self.ARGUMENTS, "-o", self.folder / "out"])
        self.assertIn(f"going on with {len(measured)} measurements", done.stdout)
        scene = load(self.folder / "out")["scenes"][0]
        for p in scene["points"]:
            self.assertEqual(len(p["seconds"]["repeats"]), 3, p["name"])
        # What was measured stands there with the times of then.
        checked = 0
        for (name, repeat), seconds in measured.items():
            name = name.removeprefix("1-spheres-")
            if name.startswith("rounded"):
                continue
            self.assertEqual(point(scene, name)["seconds"]["repeats"][repeat], seconds, name)
            checked += 1
        self.assertGreater(checked, 50)
        self.assertFalse((self.folder / "out/unfinished").exists())

    def test_ctrl_c_says_how_to_go_on(self):
        code, (_, error) = self.interrupt_after(5, signal.SIGINT)
        self.assertEqual(code, 130)
        self.assertRegex(error, r"interrupted after \d+ measurements; the same command goes on from there")
        self.assertFalse((self.folder / "out/report.html").exists())

    def test_a_termination_and_a_hang_up_say_so_too(self):
        for by, code, lines in ((signal.SIGTERM, 143, 5), (signal.SIGHUP, 129, 30)):
            ended, (_, error) = self.interrupt_after(lines, by)
            self.assertEqual(ended, code)
            self.assertRegex(error, r"interrupted after \d+ measurements; the same command goes on from there")

    def test_two_at_once_are_refused(self):
        process = self.start()
        while self.journal().count("\n") < 2:
            self.assertIsNone(process.poll())
            time.sleep(0.02)
        done = run(["report", ROOT / "scenes/spheres.json", *self.ARGUMENTS, "-o", self.folder / "out"], expected=2)
        self.assertIn("another turner report", done.stderr)
        process.kill()
        process.communicate()


class Damaged(InFolder):
    ARGUMENTS = ["--width", "32", "--max-samples", "2", "--repeats", "1"]

    def test_pictures_that_are_lost_or_damaged_are_measured_again(self):
        scene = ROOT / "scenes/diffuse.json"
        process = subprocess.Popen([str(PROGRAM), "report", scene, *self.ARGUMENTS, "-o", self.folder / "out"],
                                   stdout=subprocess.DEVNULL)
        pictures = lambda: sorted((self.folder / "out/unfinished").glob("*/*.exr"))
        while len(pictures()) < 5:
            self.assertIsNone(process.poll())
            time.sleep(0.01)
        process.kill()
        process.wait()
        lost, cut, *_ = pictures()
        lost.unlink()
        os.truncate(cut, 100)
        report = self.measure(scene, *self.ARGUMENTS)
        self.assertEqual(len(report["scenes"][0]["points"]), 12)
        self.assertFalse((self.folder / "out/unfinished").exists())
