#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Methods rank in hooke as loops by hand rank: instructions a step, counted by callgrind, so no clock and no noise.
# Where two loops differ by more than CLEAR, hooke's kernels must not be the other way round.
set -u
CLEAR=1.5
library=${LIBHOOKE:-build/libhooke.a}
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
skip() {
    echo "1..1"
    echo "ok 1 - ranking # SKIP $1"
    exit 0
}
[ "${CONFIG:-release}" = release ] || skip "what is counted is optimised code (CONFIG=release)"
command -v valgrind >/dev/null && command -v callgrind_annotate >/dev/null || skip "valgrind is not installed"
[ -r "$library" ] || skip "there is no $library"
CC=${CC:-gcc}
libraries=$(pkg-config --libs gsl 2>/dev/null || echo -lgsl -lgslcblas -lm)
sundials=
for name in cvode sunlinsoldense sunnonlinsolfixedpoint sunmatrixdense nvecserial; do
    sundials="$sundials -l:libsundials_$name.a"
done
build() { # libraries…
    $CC -std=c11 -O2 -D_GNU_SOURCE -Iinclude -Isrc -ffp-contract=off -o "$folder/ranking" tests/ranking/ranking.c \
        "$library" "$@" -lm -ldl 2>"$folder/errors"
}
# shellcheck disable=SC2086
build $libraries || build $sundials $libraries || { cat "$folder/errors"; echo "not ok 1 - ranking"; exit 1; }
echo "1..2"
valgrind --tool=callgrind --callgrind-out-file="$folder/counts" "$folder/ranking" >"$folder/said" 2>&1 ||
    { cat "$folder/said"; echo "not ok 1 - the loops are the same methods"; exit 1; }
echo "ok 1 - the loops are the same methods"
callgrind_annotate --inclusive=yes --threshold=100 "$folder/counts" |
    awk -v clear=$CLEAR '
        match($0, /:(loop|kernel)_[a-z]+_[a-z0-9_]+/) {
            name = substr($0, RSTART + 1, RLENGTH - 1)
            count = $1
            gsub(/,/, "", count)
            kind = name ~ /^loop/ ? "loop" : "kernel"
            sub(/^(loop|kernel)_/, "", name)
            scene = name
            sub(/_.*/, "", scene)
            cost[kind, name] = count + 0
            scenes[name] = scene
        }
        END {
            for (a in scenes) {
                cases++
                if (!cost["loop", a] || !cost["kernel", a]) {
                    print "# " a ": not counted"
                    wrong++
                }
                for (b in scenes)
                    if (scenes[a] == scenes[b] && cost["loop", a] > clear * cost["loop", b]) {
                        pairs++
                        if (cost["kernel", a] < cost["kernel", b]) {
                            printf "# %s and %s: by hand %d to %d, by hooke %d to %d\n", a, b, cost["loop", a],
                                cost["loop", b], cost["kernel", a], cost["kernel", b]
                            wrong++
                        }
                    }
            }
            printf "# %d cases, %d pairs that differ clearly\n", cases, pairs
            print (cases == 42 && pairs > 30 && !wrong ? "ok" : "not ok") " 2 - kernels rank as loops by hand"
        }'
