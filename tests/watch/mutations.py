"""Random edits in a row."""

import collections
import sys
import time

from support.editors import EDITORS
from support.mutator import Mutator
from support.patience import TIMEOUT
from support.pictures import Exr, png_size
from support.processes import memory_of, tree_of
from support.session import BALL, Session
from support.settings import MUTATIONS


class Mutations(Session):
    VALIDATION = "0"
    SEED = 1
    RESTORES = 20  # edits after which the originals come back
    GROWTH = 0.02  # of the watcher's memory
    LEVEL = 300  # KiB that glibc holds from some edit on; in a short run that may be its last third

    def setUp(self):
        super().setUp()
        self.original = {path.name: path.read_bytes() for path in sorted(self.path("kernel").iterdir())}
        self.mutator = Mutator(self.SEED)
        self.chance = self.mutator.chance
        self.outcomes = collections.Counter()
        self.memory = []  # after each edit: RSS, its anonymous part and PSS of the watcher, PSS of all else

    def mutate_one(self):
        """Saves one file with a mutation of its original, or of what it is now."""
        name = self.chance.choice(list(self.original))
        now = self.source(name).read_bytes()
        way, text = self.mutator.mutate(now if self.chance.random() < 0.2 else self.original[name])
        self.save(name, text, self.chance.choice(EDITORS))
        return f"{way} in {name}", text != now

    def restore(self, names):
        changed = [name for name in names if self.source(name).read_bytes() != self.original[name]]
        for name in changed:
            self.save(name, self.original[name], self.chance.choice(EDITORS))
        return bool(changed)

    def check_picture(self, w, event, what):
        """Whole, and that of the last good version."""
        if event["event"] == "picture":
            self.good, self.good_version = self.exr(), w.version
            self.assertEqual(Exr(self.path("out.exr")).width, BALL["width"], what)
        else:
            self.assertEqual(self.exr(), self.good, f"{what}: the last good picture is gone\n{event}")
            self.assertTrue(event["diagnoses"], what)
        self.assertEqual(png_size(self.path("out.png")), (BALL["width"], BALL["height"]), what)
        outcome = event["event"] if event["event"] == "picture" else f"refused in {event['step']}"
        self.outcomes[outcome + (", endless" if event.get("endless") else "")] += 1

    def take_memory(self, w):
        watcher, *others = tree_of(w.process.pid)
        self.memory.append((*memory_of(watcher), sum(memory_of(process)[2] for process in others)))

    def test_random_edits_in_a_row_hurt_nothing(self):
        started = time.monotonic()
        with self.watch("--timeout", "2") as w:
            w.picture()
            w.figures()
            w.wait("reference")
            original = self.good = self.exr()
            self.good_version = w.version
            for edit in range(1, MUTATIONS + 1):
                # Mostly of one file at a time, sometimes of what was mutated before.
                stacked, interrupted = self.chance.random() < 0.3, self.chance.random() < 0.1
                if interrupted and self.good_version == w.version:
                    w.figures()  # nothing else is in work that could unite two saves
                what, changed = self.mutate_one()
                what = f"edit {edit}, seed {self.SEED}: {what}"
                if not stacked:
                    name = what.rpartition(" ")[2]
                    changed |= self.restore(n for n in self.original if n != name)
                if changed and interrupted:
                    # A newer save comes in between.
                    version = w.version + 1
                    time.sleep(self.chance.uniform(0.3, 1))
                    # Of the one file that is always among the sources: the mutation may have dropped an include.
                    self.save("whitted.comp", self.source("whitted.comp").read_bytes() + b"\n// %d\n" % edit)
                    saved = time.monotonic()
                    # The first save's version comes to its end before the second, or is given up for it; or both are one.
                    first = w.wait("picture", "refused", "superseded", version=version)
                    are_two = first["event"] == "superseded" or first["at"] < saved
                    event = w.wait("picture", "refused", version=version + 1, seconds=TIMEOUT if are_two else 30, must=are_two)
                    if not event:
                        # Where the disk holds the watcher up for as long as between the two saves, they are one to it.
                        self.outcomes["two saves seen as one"] += 1
                        self.save("whitted.comp", self.source("whitted.comp").read_bytes() + b"\n// once more\n")
                        event = w.wait("picture", "refused", version=version + 1)
                    w.version = version + 1
                    self.check_picture(w, event, what)
                elif changed:
                    self.check_picture(w, w.outcome(), what)
                if edit % self.RESTORES == 0 or edit == MUTATIONS:
                    if self.restore(self.original):
                        w.picture()
                        w.figures()
                        self.good_version = w.version
                    self.assertEqual(self.exr(), original, what)
                    self.good = original
                self.take_memory(w)
                if edit % 100 == 0:
                    print(f"{edit}: {time.monotonic() - started:.0f} s, {self.memory[-1]}", file=sys.stderr)
            self.report(time.monotonic() - started)

    def report(self, seconds):
        # From edit to edit the watcher's memory jumps between levels up to 800 KiB apart: what it holds for good is the
        # lower quartile of many values, after a third of them and at the end.
        third = max(1, MUTATIONS // 3)
        quartile = lambda values: [sorted(column)[len(column) // 4] for column in zip(*values)]
        rss, *parts = quartile(self.memory[third : 2 * third] or self.memory)
        last_rss, *last_parts = quartile(self.memory[-third:])
        told = ", ".join(f"{name} {count}" for name, count in sorted(self.outcomes.items()))
        print(
            f"\n{MUTATIONS} edits in {seconds:.0f} s: {told}\n"
            f"watcher: RSS {rss} -> {last_rss} KiB ({last_rss / rss - 1:+.2%}); "
            f"of it anonymous, its PSS, that of its children: {parts} -> {last_parts} KiB",
            file=sys.stderr,
        )
        allowed = rss * (1 + self.GROWTH) + (self.LEVEL if MUTATIONS < 500 else 0)
        self.assertLessEqual(last_rss, allowed, "the watcher's memory grows")
        self.assertLessEqual(self.outcomes["two saves seen as one"], 1 + MUTATIONS // 200, "saves are lost")
