"""Bars for times, which hold only on a machine that does nothing else."""


class Timed:
    """Of a test case. Its times count where a class sets `holds_times`: in cli.timing and watch.timing, which carry the
    label `timing`. Elsewhere only what happens counts, however long it takes."""

    holds_times = False

    def check_takes(self, seconds, most, about=""):
        if self.holds_times:
            self.assertLess(seconds, most, about)
