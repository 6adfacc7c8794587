"""How long tests wait for what must come: a sound run on a busy machine waits for none of this."""

import time

# Seconds: for a version, which compilers under a sanitizer make slowly; for what needs no work.
TIMEOUT = 240
PATIENCE = 60


def wait_until(condition, seconds=PATIENCE):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True
