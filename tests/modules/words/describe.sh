#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Questions about figures, answered from what `describe` says alone, against closed forms: the reader
# here sees words only.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
n=0 bad=0
recordings=$PWD/scripts/make-recordings
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2

ok() { # name status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    printf '%s\n' "${3:-}" | sed 's/^/#   /'
}
said=
read_figure() { # commands: the last of them describes
    said=$("$hooke" -n --format json -c "$1" 2>/dev/null | sed -n 's/^{"kind":"description".*"text":"\(.*\)"}$/\1/p' | tail -n 1)
}
number() { # text before it: the first number behind
    grep -oE -- "$1[-+0-9.e]+" <<<"$said" | head -n 1 | sed -E "s|^$1||" | grep -oE -- '[-+0-9.e]+' | sed 's/[.]$//' | head -n 1
}
near() { # question, text before the number, expected (an expression of awk), relative tolerance
    local got expected
    got=$(number "$2")
    expected=$(awk "BEGIN {pi = atan2(0, -1); printf \"%.17g\", $3}")
    awk -v got="$got" -v expected="$expected" -v tol="$4" \
        'BEGIN {if (got == "") exit 1; d = got - expected; if (d < 0) d = -d; if (expected < 0) expected = -expected; exit !(d <= tol * expected)}'
    ok "$1 $got (expected $expected)" $? "$said"
}
says() { # question, text
    grep -qF -- "$2" <<<"$said"
    ok "$1 $2" $? "$said"
}
never() {
    ! grep -qF -- "$2" <<<"$said"
    ok "$1 not: $2" $? "$said"
}

spring='m = 200 g; k = 15 N/m; y0 = 5 cm; gamma = 0 1/s'
w2='75' # k/m [1/s^2]

read_figure "$spring; method euler dt=10ms; run 10 s; describe energy"
near "by how much does the energy of forward Euler grow?" "by a factor of " "(1 + $w2 * 1e-4)^1000" 1e-3
near "how fast?" "exponentially at " "log(1 + $w2 * 1e-4) / 0.01" 1e-3
says "does it fall anywhere?" "rises throughout"

read_figure "$spring; method backward-euler dt=10ms; run 10 s; describe position"
near "how fast does backward Euler damp the position?" "exponentially at " "-log(1 + $w2 * 1e-4) / 0.02" 2e-3
says "does its amplitude grow?" "its amplitude shrinks"

read_figure "$spring; method symplectic-euler dt=10ms; run 10 s; describe position"
c="(1 - $w2 * 1e-4 / 2)"
near "what is the period of symplectic Euler?" "with a period of " "2 * pi * 0.01 / atan2(sqrt(1 - $c^2), $c)" 2e-4
says "is it bounded?" "its amplitude stays at"

read_figure "$spring; compare euler symplectic-euler backward-euler; describe energy run all"
says "whose energy is largest in the end?" "from top to bottom: euler, symplectic-euler, backward-euler."
says "which grows?" "euler rises throughout"
says "which dies?" "backward-euler falls throughout"

read_figure "$spring; method euler dt=10ms; run 2 s; describe phase"
says "does the phase plot of forward Euler close?" "spirals outwards"
read_figure "$spring; method symplectic-euler dt=1ms; run 2 s; describe phase"
says "and that of symplectic Euler?" "and closes"
says "which way does it go round?" "clockwise about the origin"
read_figure "$spring; method backward-euler dt=10ms; run 2 s; describe phase"
says "and that of backward Euler?" "spirals inwards"

read_figure "$spring; gamma = 0.2 1/s; method rk4 dt=1ms; run 20 s; describe energy"
near "how fast does a damped energy decay?" "exponentially at " "-0.2" 1e-2
read_figure "$spring; gamma = 0.2 1/s; method rk4 dt=1ms; run 20 s; describe position"
near "and its position?" "exponentially at " "-0.1" 1e-3
near "what is its period?" "with a period of " "2 * pi / sqrt($w2 - 0.01)" 2e-4
near "where does it start?" "It starts at " "5" 1e-9

read_figure "$spring; method rk4 dt=1ms; run 20 s; describe spectrum"
near "at which frequency is the line of the spectrum?" "highest [-+0-9.e]+ cm at f = " "sqrt($w2) / (2 * pi)" 5e-3

read_figure "scene kepler; method rk4 dt=1ms; run 62.9 s; describe orbit"
says "is Kepler's orbit closed?" "and closes"
near "how far is the planet at most, to the left?" "x from " "-1.5" 1e-3

read_figure "order rk4; precision rk4 verlet; describe error against evals of precision"
near "of which order is verlet?" "as evals to the power of " "-2" 1e-2

read_figure "scene pendulum; theta0 = 90 deg; method rk4 dt=1ms; run 30 s; describe position"
near "how long does a pendulum swing from 90 degrees?" "with a period of " "2.367841947" 2e-4
never "is that a small swing?" "2.006"

read_figure "$spring; method rk4 dt=1ms; run 5 s; method euler dt=1ms; run 5 s; describe position run 1 2"
near "how far is forward Euler from Runge and Kutta?" "euler by " "100 * 0.05 * (exp($w2 * 0.0005 * 4.7) - 1) " 0.06

"$recordings" "$folder" >/dev/null
read_figure "load disk.txt; describe"
says "does a recording with missed echoes grow?" "its amplitude shrinks"
near "from what amplitude?" "shrinks from " 5.08 1e-2
near "with what period?" "with a period of " 0.7525 1e-3
read_figure "load bare.txt; describe"
near "how often does a bob pass its middle in 10 s?" "crosses its centre " 28 1e-9

# the figure and its words cannot disagree: both are of the same curve
read_figure "$spring; gamma = 0.3 1/s; method rk4 dt=10ms; run 7 s; describe velocity"
low=$(number "v from ") high=$(number "v from [-+0-9.e]+ to ")
"$hooke" -n -c "$spring; gamma = 0.3 1/s; method rk4 dt=10ms; run 7 s; export v.csv" >/dev/null 2>&1
awk -F, -v low="$low" -v high="$high" '/^#/ {next} !c {for (i = 1; i <= NF; i++) if ($i ~ /^"?v/) c = i; next}
    {if ($c < min) min = $c; if ($c > max) max = $c} END {exit !(c && (low / 100 - min)^2 < 1e-8 && (high / 100 - max)^2 < 1e-8)}' v.csv
ok "the range of the velocity, $low to $high, is that of the exported column" $? "$said"

echo "1..$n"
exit "$bad"
