#!/bin/sh
# The README's two commands on a machine that has nothing: makes a fresh root of a Debian release in FOLDER, clones this
# checkout's HEAD into it, runs cmake/demo.sh there and then tests/run.sh, as root or as a user who has sudo. No part of
# CI: it downloads a system and takes as long as a first build and all tests do.
# usage, as root: tests/machines/fresh_debian.sh bookworm|trixie FOLDER [root|user] [demo|all] [arguments of tests/run.sh]
#   DEBIAN_MIRROR: where packages come from (http://deb.debian.org/debian); CXXFLAGS: for the build, such as -Werror
# FOLDER may hold the root of a run before: the clone is made anew, installed packages stay. The pictures of the demo are
# in FOLDER/demo.
set -eu
[ $# -ge 2 ] || { sed -n '2,/^set/s/^# \{0,1\}//p' "$0" >&2; exit 2; }
suite=$1 folder=$2 who=${3-root} what=${4-all}
shift $(($# < 4 ? $# : 4))
checkout=$(cd "$(dirname "$0")/../.." && pwd)
[ "$(id -u)" = 0 ] || { echo "fresh_debian: making a root needs root" >&2; exit 2; }
command -v debootstrap >/dev/null || { echo "fresh_debian: apt-get install debootstrap" >&2; exit 2; }

mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
if [ ! -e "$folder/etc/debian_version" ]; then
  debootstrap --variant=minbase --include=ca-certificates,git,sudo "$suite" "$folder" \
    "${DEBIAN_MIRROR:-http://deb.debian.org/debian}"
fi
cp /etc/resolv.conf "$folder/etc/resolv.conf"
# As an installer leaves it; the browser of the tests is asked at localhost.
[ -e "$folder/etc/hosts" ] || echo "127.0.0.1 localhost" >"$folder/etc/hosts"
chroot "$folder" dpkg-query -W git sudo >/dev/null 2>&1 || chroot "$folder" apt-get install -y git sudo
if [ "$who" = user ]; then
  chroot "$folder" id tester >/dev/null 2>&1 || chroot "$folder" useradd --create-home tester
  echo 'tester ALL=(ALL) NOPASSWD: ALL' >"$folder/etc/sudoers.d/tester"
  home=/home/tester
else
  home=/root
fi
rm -rf "$folder$home/turner" "$folder/demo"
git clone --quiet "$checkout" "$folder$home/turner"
[ "$who" = root ] || chroot "$folder" chown -R tester "$home/turner"

# As words of a shell, whatever is in them.
words=
for word; do words="$words '$(printf %s "$word" | sed "s/'/'\\\\''/g")'"; done
cat >"$folder/run-here" <<END
set -eu
cd $home/turner
export CXXFLAGS="${CXXFLAGS-}"
. /etc/os-release; echo "\$PRETTY_NAME, \$(id -un), \$(git log -1 --format='%h %s')"
cmake/demo.sh
[ $what = demo ] || tests/run.sh $words
END
# The mounts end with their namespace.
unshare --mount sh -euc '
  mount -t proc proc "$1/proc"
  mount --rbind /dev "$1/dev"
  if [ "$2" = user ]; then exec chroot "$1" su - tester -c "sh /run-here"; fi
  exec chroot "$1" env -i HOME=/root PATH="$PATH" LANG=C.UTF-8 sh /run-here' sh "$folder" "$who"
mkdir -p "$folder/demo"
cp "$folder$home/turner"/spheres.exr "$folder$home/turner"/spheres.png "$folder/demo"
chroot "$folder" dpkg-query -W -f '${Package} ${Version}\n' g++ libembree-dev mesa-vulkan-drivers glslang-dev libopenexr-dev
