"""One run of `turner watch`, and what it must keep when it ends."""

import json
import re
import signal
import subprocess
import threading
import time

from support.command import CRASH
from support.patience import PATIENCE, TIMEOUT, wait_until
from support.processes import children_of, seconds_of_threads, state_of
from support.settings import PROGRAM


class Watched:
    """One run of `turner watch` in a folder; what it prints is read by threads, each event with the time of its line."""

    def __init__(self, test, *args, env=None, json_lines=True, **options):
        self.test, self.json_lines = test, json_lines
        self.args = ["watch", *map(str, args), *(["--json"] if json_lines else [])]
        self.events, self.text, self.errors = [], [], []
        self.changed = threading.Condition()
        self.version = 0  # the last that is known
        self.process = subprocess.Popen(
            [str(PROGRAM), *self.args],
            cwd=test.folder,
            env=test.environment(env),
            stdin=options.pop("stdin", subprocess.DEVNULL),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            **options,
        )
        self.threads = [
            threading.Thread(target=self._read, args=(stream, take), daemon=True)
            for stream, take in ((self.process.stdout, self._take_line), (self.process.stderr, self.errors.append))
        ]
        for thread in self.threads:
            thread.start()

    def _read(self, stream, take):
        for line in stream:
            now = time.monotonic()
            with self.changed:
                take(line.decode(errors="replace").rstrip("\n"))
                if self.events and "at" not in self.events[-1]:
                    self.events[-1]["at"] = now
                self.changed.notify_all()
        with self.changed:
            self.changed.notify_all()

    def _take_line(self, line):
        self.text.append(line)
        if self.json_lines:
            self.events.append(json.loads(line))

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None and self.process.returncode is None:
            self.interrupt()
        elif self.process.poll() is None:
            self.kill()
        for thread in self.threads:
            thread.join(PATIENCE)
        self.process.stdout.close()
        self.process.stderr.close()

    def __str__(self):
        end = f"exit code {self.process.returncode}"
        return f"$ turner {' '.join(self.args)}\n{end}\n--- stdout\n{self.out}\n--- stderr\n{self.err}"

    @property
    def out(self):
        return "\n".join(self.text)

    @property
    def err(self):
        return "\n".join(self.errors)

    # --- what it says ---

    def wait(self, *kinds, version=None, since=0, seconds=TIMEOUT, must=True):
        """The first event of a kind, of a version if it is named, among those since an index."""
        end = time.monotonic() + seconds
        with self.changed:
            while True:
                for event in self.events[since:]:
                    if event["event"] in kinds and version in (None, event.get("version")):
                        return event
                left = end - time.monotonic()
                gone = self.process.poll() is not None and not any(t.is_alive() for t in self.threads)
                if left <= 0 or gone:
                    break
                self.changed.wait(min(left, 0.5))
        if must:
            self.test.fail(f"no {' or '.join(kinds)} of version {version} within {seconds} s\n{self}")
        return None

    def wait_for_error(self, pattern, seconds=TIMEOUT):
        self.test.assertTrue(wait_until(lambda: re.search(pattern, self.err, re.M), seconds), f"{pattern}\n{self}")

    def outcome(self, seconds=TIMEOUT):
        """The picture or refusal of the next version that is not interrupted."""
        while True:
            event = self.wait("picture", "refused", "superseded", version=self.version + 1, seconds=seconds)
            self.version += 1
            if event["event"] != "superseded":
                return event

    def picture(self, **options):
        event = self.outcome(**options)
        self.test.assertEqual(event["event"], "picture", self)
        return event

    def refused(self, **options):
        event = self.outcome(**options)
        self.test.assertEqual(event["event"], "refused", self)
        return event

    def figures(self):
        """All that is told of the last version."""
        return self.wait("version", version=self.version)

    def stays_quiet(self, seconds=1):
        """No new version."""
        event = self.wait("coarse", "picture", "refused", "superseded", version=self.version + 1, seconds=seconds, must=False)
        self.test.assertIsNone(event, self)

    def count(self, kind):
        return sum(event["event"] == kind for event in self.events)

    # --- its processes ---

    def worker(self):
        """The child that renders. The other one, while it lives, is the reference's: it is younger as long as no
        renderer has died, and stands still while anything else works."""
        active = []  # once looked at: in the next moment it may have died

        def is_active():
            active[:] = (child for child in children_of(self.process.pid) if state_of(child) in ("R", "S", "D"))
            return active

        self.test.assertTrue(wait_until(is_active), self)
        return active[0]

    def wait_for_work(self, act, threads=1, seconds=0.3):
        """Acts, then waits until so many of the renderer's threads have worked so long at it, beside the first thread,
        which compiles, where more than one is asked for. The renderer must be idle before."""
        before = seconds_of_threads(self.worker())
        act()

        def is_busy():
            worker = self.worker()
            spent = [s - before.get(t, 0) for t, s in seconds_of_threads(worker).items() if threads == 1 or t != worker]
            return sum(s >= seconds for s in spent) >= threads

        self.test.assertTrue(wait_until(is_busy, TIMEOUT), self)

    def is_alive(self):
        return self.process.poll() is None

    def interrupt(self, code=130, most=10):
        """Ctrl-C, and what must be true then: within so many seconds, where times count."""
        self.test.assertTrue(self.is_alive(), f"it has ended by itself\n{self}")
        started = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.test.fail(f"Ctrl-C did not end it within {PATIENCE} s\n{self}")
        seconds = time.monotonic() - started
        for thread in self.threads:
            thread.join(PATIENCE)
        self.test.assertEqual(self.process.returncode, code, self)
        self.check_nothing_left()
        if self.json_lines:
            self.test.assertEqual(self.events[-1]["event"], "stopped", self)
        self.test.check_takes(seconds, most, self)

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.test.check_nobody_left(self)

    def check_nothing_left(self):
        self.test.check_nobody_left(self)
        self.test.assertEqual(self.test.temporary_files(), [], self)
        # A worker's end is told in these words; a crash of the watcher is not.
        self.test.assertNotRegex(re.sub(r"was ended by signal \d+ \([^)]*\)", "", self.err), CRASH, self)
