"""What is tested, and where: the sources this file lies in, and a build of them.

The tests that drive the programs are run from the folder tests, by modules, classes or methods:
    python3 -m unittest -v cli.render watch.edits.Shaders
Environment: TURNER_TEST_BUILD, the folder of the build (build); TURNER_TEST_MUTATIONS, the random edits of
watch.mutations (60).
"""

import os
import pathlib

TESTS = pathlib.Path(__file__).resolve().parent.parent
ROOT = TESTS.parent
SCENES = ROOT / "scenes"
BUILD = pathlib.Path(os.environ.get("TURNER_TEST_BUILD", ROOT / "build")).resolve()
PROGRAM = BUILD / "turner"
BENCH = BUILD / "tests/turner_bench"
SCREENS = BUILD / "tests/screens"  # what the browser showed
MUTATIONS = int(os.environ.get("TURNER_TEST_MUTATIONS", "60"))
