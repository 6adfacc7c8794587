#!/bin/sh
# Installs what turner needs from Debian packages: only what is missing, and nothing is printed if nothing is.
# usage: cmake/setup.sh [more packages]
set -eu

packages="
  g++ cmake ninja-build pkg-config
  libvulkan-dev mesa-vulkan-drivers vulkan-validationlayers
  glslang-dev glslang-tools spirv-tools libglm-dev libembree-dev libopenexr-dev libpng-dev
  libcli11-dev libfmt-dev rapidjson-dev libgeos-dev nettle-dev
  libgtest-dev libgmock-dev python3 python3-jsonschema
  $*"

if ! command -v dpkg-query >/dev/null; then
  echo "setup: this is not a Debian system; install the counterparts of these packages:" $packages >&2
  exit 1
fi

missing=
for package in $packages; do
  state=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
  [ "$state" = "install ok installed" ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" = 0 ]; then
  as_root=
elif command -v sudo >/dev/null; then
  as_root=sudo
else
  echo "setup: these packages are missing, and installing them needs root:$missing" >&2
  echo "setup: as root, run: apt-get install --no-install-recommends$missing" >&2
  exit 1
fi

echo "setup: installing$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
install() {
  $as_root apt-get update && $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing
}
if ! install >"$log" 2>&1; then
  cat "$log" >&2
  echo "setup: apt-get failed; its messages are above" >&2
  exit 1
fi
