#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A stack of 160 KiB, with what the system, the start and the libraries take of it, is enough for every command: of its own none uses more
# than 144 KiB (tests/unit/command/scripts.c measures each statement of tests/cli). What nests is limited, in formulas, scripts and files.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
here=$(pwd)
if [ "${CONFIG:-}" = asan ]; then
    echo "ok 1 - every command with a small stack # SKIP sanitizers have larger frames"
    echo "1..1"
    exit 0
fi
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
n=0 bad=0
lives() { # name line [status]
    local name=$1 got
    n=$((n + 1))
    (ulimit -s 160 && exec "$hooke" -n -k -c "$2") >out.txt 2>err.txt
    got=$?
    if [ "$got" -lt 128 ] && { [ -z "${3:-}" ] || [ "$got" -eq "$3" ]; }; then
        echo "ok $n - $name"
    else
        bad=1
        echo "not ok $n - $name"
        echo "#   status $got: $(tail -c 200 err.txt | tr '\n' ' ')"
    fi
}

of="load $here/examples/lab/bare.txt; m = 200 g"
lives "a run, what is measured and shown of it" "$of; run 5 s; measure period; measure amplitude; plot position; plot spectrum > p.svg; describe; screenshot; cursor" 0
lives "fits" "$of; fit damped; fit drag; fit law; fit scene; fit modes"
lives "studies" "compare euler rk4; precision rk4 radau5; order rk4; stability rk4 radau5; stress rk4 radau5" 0
lives "stiff, chaotic and typed scenes" "scene stiff-vanderpol; method radau5; run 1 s; reset; scene kepler; method dop853; run 1 s; scene henon-heiles; run 1 s; var x = 1; x' = -x^3; method rodas5p; run 1 s; method bdf2; run 1 s" 0
lives "a sweep in threads" "sweep k=10:20:0.5 measure=period; sweep k=10:20:2 gamma=0:1:0.2 measure=amplitude" 0
lives "tables out and in" "run 5 s; export a.csv; load a.csv; data clean; plot position data a > a.svg; save s.hk; record r.hk; k = 5; source s.hk"

nested() { # open close count
    printf "%${3}s" '' | sed "s/ /$1/g"
    printf 1
    printf "%${3}s" '' | sed "s/ /$2/g"
}
for depth in 190 100000; do
    lives "parentheses, $depth deep" "print $(nested '(' ')' "$depth" | head -c 60000)"
    lives "powers, $depth" "print $(nested '2^' '' "$depth" | head -c 60000)"
    lives "minus signs, $depth" "print $(nested '-' '' "$depth" | head -c 60000)"
done
nested '[' ']' 200000 >deep.json
nested '{"a":' '}' 100000 >keys.json
{ echo '<?xml version="1.0"?>'; nested '<a>' '<\/a>' 100000; } >deep.xml
for file in deep.json keys.json deep.xml; do
    lives "$file" "load $file" 1
done
echo 'source self.hk' >self.hk
lives "a script that reads itself" 'source self.hk' 1
formula=$(for i in $(seq 1 400); do printf ' + sin(x*%d)*y' "$i"; done)
lives "a long formula" "var x = 1; var y = 0; x' = y; y' = -x$formula; method rk4 dt=0.01; run 0.1 s; method radau5; run 0.1 s"
echo "1..$n"
exit $bad
