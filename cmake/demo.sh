#!/bin/sh
# From a clean clone to a picture: installs what is missing, builds, renders scenes/spheres.json.
set -eu
cd "$(dirname "$0")/.."

cmake/setup.sh
cmake --preset release >build.log 2>&1 || { cat build.log >&2; exit 1; }
cmake --build --preset release --target turner
rm -f build.log
build/turner render scenes/spheres.json -o spheres.exr -o spheres.png
echo "The picture: $PWD/spheres.png, and in linear float32: $PWD/spheres.exr"
