"""How long tests of the watch wait."""

import time

# Compilers under a sanitizer on a busy machine are slow; a sound run waits for none of this.
TIMEOUT = 120  # seconds
PATIENCE = 10  # seconds in which Ctrl-C must have ended everything


def wait_until(condition, seconds=PATIENCE):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True
