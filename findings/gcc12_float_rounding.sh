#!/bin/sh
# A good engineer would guess: double d = (float)x rounds x to float, at every optimisation level (C17 6.3.1.5: a double
# that is demoted to float is rounded where float cannot hold it; on x86-64 FLT_EVAL_METHOD is 0, so nothing is wider
# than its type). Two such statements in a row do it twice.
# What happens instead: gcc 12.2, the compiler of Debian 12, drops both roundings at -O2 and -O3. The function below
# becomes a lone `ret`. Since version 12, -O2 turns neighbouring statements into vector operations (SLP), and there the
# pair of conversions double -> float -> double is taken for none. -fno-tree-slp-vectorize keeps it, as does gcc 11.3
# (-O2 and -O3) and clang 14.
# Source: C17 6.3.1.5 and 6.5.4; GCC manual 12.2, "Optimize Options": -ftree-slp-vectorize is enabled by -O2.
# Seen: gcc-12 12.2.0-14+deb12u1, x86-64.
# Usage: findings/gcc12_float_rounding.sh      exit code 0: as described; 1: no longer so; 2: something is missing
set -eu
command -v gcc-12 >/dev/null || { echo "missing: apt-get install gcc-12 libc6-dev" >&2; exit 2; }
echo "gcc-12 $(dpkg-query -W -f '${Version}' gcc-12) (described: 12.2.0-14+deb12u1)"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat >"$folder/round.c" <<'C'
void roundToFloat(double *p) {
  p[0] = (float)p[0];
  p[1] = (float)p[1];
}
C
cat >"$folder/main.c" <<'C'
#include <stdio.h>
void roundToFloat(double *p);
int main(void) {
  double p[2] = {0.1, 0.2};
  roundToFloat(p);
  printf("%.17g %.17g\n", p[0], p[1]);
  return 0;
}
C
gcc-12 -std=c17 -O1 -c "$folder/main.c" -o "$folder/main.o"
rounded="0.10000000149011612 0.20000000298023224"
kept="0.10000000000000001 0.20000000000000001"
status=0
expect() {  # flags, what the program prints
  gcc-12 -std=c17 $1 "$folder/round.c" "$folder/main.o" -o "$folder/round"
  printed=$("$folder/round")
  echo "$1: $printed"
  [ "$printed" = "$2" ] || { echo "  that is new: it was $2"; status=1; }
}
expect "-O1" "$rounded"
expect "-O2" "$kept"
expect "-O3" "$kept"
expect "-O2 -fno-tree-slp-vectorize" "$rounded"
exit $status
