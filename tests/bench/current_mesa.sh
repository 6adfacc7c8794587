#!/bin/sh
# Runs a command on the newest Mesa: in a Debian unstable root, which it makes, and where it builds Turner with the compiler and packages found there.
# usage: tests/current_mesa.sh [--machine-build] [FOLDER [COMMAND ...]]      as root; FOLDER is made if it is not there
#   FOLDER            where the root is kept (default: build/current-mesa); remove it for a newer Mesa
#   COMMAND           what to run, in the checkout (default: build/tests/turner_bench); build/ is there the root's own build
#   --machine-build   do not build: run this machine's build/ with this machine's libraries, only Vulkan and Mesa are the root's
set -eu

usage() {
  sed -n '2,6s/^# //p' "$0"
}

fail() {
  echo "current_mesa: error: $*" >&2
  exit 1
}

mounts_are_private=
if [ "${1:-}" = --mounts-are-private ]; then
  mounts_are_private=yes
  shift
fi
machine_build=
case ${1:-} in
  --machine-build)
    machine_build=yes
    shift
    ;;
  -h | --help)
    usage
    exit
    ;;
  -*)
    fail "unknown option $1; tests/current_mesa.sh --help tells what there is"
    ;;
esac

[ "$(id -u)" = 0 ] || fail "this needs root: it makes a Debian root with debootstrap, mounts folders in it and runs chroot; try it with sudo"

# In a mount namespace of its own no mount is seen outside, and all of them end with the last process, however that ends.
if [ -z "$mounts_are_private" ]; then
  exec unshare --mount --propagation private sh "$0" --mounts-are-private ${machine_build:+--machine-build} "$@"
fi

checkout=$(cd "$(dirname "$0")/.." && pwd -P)
root=${1:-$checkout/build/current-mesa}
[ $# = 0 ] || shift
[ $# != 0 ] || set -- build/tests/turner_bench
parent=$(dirname "$root")
mkdir -p "$parent" "$checkout/build"
parent=$(cd "$parent" && pwd -P)
root=${parent%/}/$(basename "$root")

# Runs a command whose messages matter only if it fails.
log=$(mktemp)
trap 'rm -f "$log"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
quietly() {
  if ! "$@" >"$log" 2>&1; then
    cat "$log" >&2
    fail "failed: $*; its messages are above"
  fi
}

debian_mirror() {
  apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' 'Component: main' | head -n 1
}

# The way to the packages is this machine's: its mirror, its proxies, its certificates, its opinion of old lists. The root appears under its name only
# when it is whole.
make_root() {
  command -v debootstrap >/dev/null || "$checkout/cmake/setup.sh" debootstrap
  # debootstrap knows no proxies that stand only in apt's configuration.
  eval "$(apt-config shell http_proxy Acquire::http::Proxy https_proxy Acquire::https::Proxy)"
  [ -z "${http_proxy:-}" ] || export http_proxy
  [ -z "${https_proxy:-}" ] || export https_proxy
  mirror=$(debian_mirror)
  if [ -z "$mirror" ]; then
    quietly apt-get update
    mirror=$(debian_mirror)
  fi
  [ -n "$mirror" ] || fail "the sources of apt on this machine name no Debian mirror; add one, or take a Debian machine"
  echo "current_mesa: making a Debian unstable root in $root; it takes some minutes" >&2
  rm -rf --one-file-system "$root.partial"
  quietly debootstrap --variant=minbase --include=mesa-vulkan-drivers,libvulkan1 unstable "$root.partial" "$mirror"
  mkdir -p "$root.partial/etc/ssl/certs" "$root.partial/build"
  if [ -e /etc/ssl/certs/ca-certificates.crt ]; then
    cp /etc/ssl/certs/ca-certificates.crt "$root.partial/etc/ssl/certs/"
  fi
  apt-config dump --no-empty | grep -E '^Acquire::(https?::|Check-|Retries)' >"$root.partial/etc/apt/apt.conf.d/90machine" || true
  echo "made by Turner's tests/current_mesa.sh" >"$root.partial/build/origin"
  mv "$root.partial" "$root"
}

if [ -e "$root" ] && ! rmdir "$root" 2>/dev/null; then
  [ -e "$root/build/origin" ] || fail "$root was not made by this script; name another folder, or remove that one"
fi
[ -e "$root" ] || make_root

# Folders have the same path inside and outside, for the build knows its sources by their path.
mount_folder() {
  mkdir -p "$root$1"
  mount --bind "$1" "$root$1"
}

mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount_folder /tmp
mount_folder "$checkout"

export HOME=/root LC_ALL=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
export TURNER_DEVICE="${TURNER_DEVICE:-llvmpipe}"

in_root() {
  chroot "$root" sh -c 'cd "$1" && shift && exec "$@"' sh "$checkout" "$@"
}

if [ -n "$machine_build" ]; then
  [ -x "$checkout/build/turner" ] || fail "there is no build in $checkout/build; make it with: cmake --preset release && cmake --build --preset release"
  libraries=/opt/machine-libraries
  mkdir -p "$root$libraries"
  mount -t tmpfs machine-libraries "$root$libraries"
  # What the root has under the same name stays the root's: Mesa and the loader need those.
  for library in $(ldd "$checkout/build/turner" "$checkout"/build/tests/turner_* 2>/dev/null | awk '$2 == "=>" && $3 ~ /^\// { print $3 }' | sort -u); do
    [ -e "$root$library" ] || cp -L "$library" "$root$libraries/"
  done
  export LD_LIBRARY_PATH="$libraries"
else
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  # One build for each checkout that uses the root.
  mkdir -p "$root/build$checkout"
  mount --bind "$root/build$checkout" "$root$checkout/build"
  in_root cmake/setup.sh >&2
  quietly in_root cmake --preset release
  quietly in_root cmake --build --preset release
fi

in_root "$@"
