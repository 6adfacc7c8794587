"""What a user may not do, where the tests run as the superuser."""

import ctypes
import os
import subprocess
import sys


def without_superpowers():
    """Between fork and exec: takes from a superuser the right to write where modes forbid it."""
    if os.geteuid() != 0:
        return
    PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH = 24, 1, 2
    libc = ctypes.CDLL(None)
    for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
        libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)


def modes_bind(folder):
    """Whether without_superpowers() does its work here: a folder of mode 0555 is not writable."""
    probe = subprocess.run(["/usr/bin/test", "-w", str(folder)], preexec_fn=without_superpowers)
    return probe.returncode != 0


def say_not_possible(what):
    print(f"\nNOT POSSIBLE on this machine: {what}", file=sys.stderr)
