#!/bin/sh
# Installs what is missing, builds, runs all tests on lavapipe under the Vulkan validation layers; but for two groups:
# `tests/run.sh timing` runs those that measure time, one after the other, on a machine that should do nothing else;
# `tests/run.sh long` those that take some five minutes each and guard figures that seldom move.
# usage: tests/run.sh [timing|long] [arguments of ctest]    TURNER_PRESET=debug|sanitize tests/run.sh: another build
#        TURNER_DEVICE=SwiftShader tests/run.sh: by a second driver, which takes hours, since it compiles slowly
set -eu
cd "$(dirname "$0")/.."

case "${1-}" in
  timing) shift; set -- --label-regex '^timing$' --parallel 1 "$@" ;;
  long) shift; set -- --label-regex '^long$' --parallel "$(nproc)" "$@" ;;
  *) set -- --label-exclude '^(timing|long)$' --parallel "$(nproc)" "$@" ;;
esac
preset=${TURNER_PRESET:-release}
# The report's page is tested in a browser.
cmake/setup.sh chromium chromium-driver python3-selenium fonts-dejavu-core
cmake --preset "$preset"
cmake --build --preset "$preset"
TURNER_DEVICE=${TURNER_DEVICE:-llvmpipe}
export TURNER_DEVICE
if [ "$TURNER_DEVICE" = SwiftShader ]; then
  # A driver that no folder of the loader's names: the browser brings it.
  VK_DRIVER_FILES=$(dpkg-query -L chromium-common | grep '/vk_swiftshader_icd.json$')
  export VK_DRIVER_FILES
fi
ctest --preset "$preset" "$@"
