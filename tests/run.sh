#!/bin/sh
# Installs what is missing, builds, runs all tests on lavapipe under the Vulkan validation layers; but for those that
# measure time, which want a machine that does nothing else: `tests/run.sh timing` runs these, one after the other.
# usage: tests/run.sh [timing] [arguments of ctest]      TURNER_PRESET=debug|sanitize tests/run.sh: another build
set -eu
cd "$(dirname "$0")/.."

if [ "${1-}" = timing ]; then
  shift
  set -- --label-regex timing --parallel 1 "$@"
else
  set -- --label-exclude timing --parallel "$(nproc)" "$@"
fi
preset=${TURNER_PRESET:-release}
# The report's page is tested in a browser.
cmake/setup.sh chromium chromium-driver python3-selenium fonts-dejavu-core
cmake --preset "$preset"
cmake --build --preset "$preset"
TURNER_DEVICE=${TURNER_DEVICE:-llvmpipe} ctest --preset "$preset" "$@"
