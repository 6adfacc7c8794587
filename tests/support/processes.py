"""Processes as /proc shows them."""

import contextlib
import os
import pathlib
import re


def children_of(pid):
    try:
        found = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except (FileNotFoundError, ProcessLookupError):
        return []
    return [int(child) for child in found]


def tree_of(pid):
    """The process and all that come of it."""
    return [pid] + [process for child in children_of(pid) for process in tree_of(child)]


def living_in(folder):
    """Who has this working folder; of a process that nobody has waited for nothing is left to see."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if os.readlink(process / "cwd") == str(folder):
                found.append(int(process.name))
    return found


def memory_of(pid):
    """RSS, its anonymous part, and PSS in KiB; zeros where the process has just ended."""
    try:
        text = pathlib.Path(f"/proc/{pid}/smaps_rollup").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return 0, 0, 0
    return tuple(int(re.search(rf"^{name}:\s+(\d+) kB", text, re.M)[1]) for name in ("Rss", "Anonymous", "Pss"))


def state_of(pid):
    """R, S, D, T: stopped, Z: ended and not waited for; empty: gone."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return ""


def seconds_of_threads(pid):
    """Processor time of each thread, by its number."""
    seconds = {}
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*"):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            fields = (task / "stat").read_text().rpartition(")")[2].split()
            seconds[int(task.name)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return seconds


def processor_seconds(pid):
    return sum(seconds_of_threads(pid).values())
