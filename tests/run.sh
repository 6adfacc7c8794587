#!/bin/sh
# Installs what is missing, builds, runs all tests on lavapipe under the Vulkan validation layers.
# usage: tests/run.sh [arguments of ctest]      TURNER_PRESET=debug|sanitize tests/run.sh: another build
set -eu
cd "$(dirname "$0")/.."

preset=${TURNER_PRESET:-release}
# The report's page is tested in a browser.
cmake/setup.sh chromium chromium-driver python3-selenium fonts-dejavu-core
cmake --preset "$preset"
cmake --build --preset "$preset"
TURNER_DEVICE=${TURNER_DEVICE:-llvmpipe} ctest --preset "$preset" --parallel "$(nproc)" "$@"
