#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# export scene: parameters and variables that are called like words of C, Python or Octave, functions of their libraries or
# what the programs use themselves. Every name that hooke takes compiles and runs, with hooke's numbers.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; fi; }
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; }
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
if ! command -v gcc >/dev/null; then
    skip "programs" "gcc is not installed"
    echo "1..$n"
    exit 0
fi

words='fabs puts fprintf fputs getc remove rename stdin stderr EOF BUFSIZ FILE NULL unix linux i386 errno M_PI NAN INFINITY HUGE_VAL
fmin fmax fma rint lround trunc nextafter isfinite isnan log1p log2 exp2 erfc tgamma lgamma sinf hypotl j0 y0 y1 gamma index memcpy strlen
uint64_t size_t off_t bool true asm typeof complex I double_t restrict inline nan exp10 getline dprintf popen fread_unlocked INT32_MAX
float len zip sum all enumerate list str int reversed bin self super lambda None True class yield async global import sys plt ulp frexp
zeros end endif otherwise switch until catch persistent parfor function global printf warning odeset ode45 events
row rows s tol slopes steps a a1 a7 y_at2 y_new v_new slope slope1 at h z keep half force force_y acceleration drag1 friction_most pull
inverse damping stiffness bend r lost quadratic change now state first last weight scale number more control turn good inside interval
stage_time error_most size SIZE STAGES VARIABLES EPSILON BLOCK moment swap adaptive_begin fixed_sin factor_log2 propagate_row derivatives
jacobian solve eliminate combine attempt print_row is_finite with_friction heaviside equations node matrix positions rest other'
printf '%s\n' $words | sort -u >words
: >taken
split -l 60 words part.
for part in part.*; do # which of them may be names at all
    while read -r word; do printf 'param %s = 1\n' "$word"; done <"$part" >try.hk
    "$hooke" -n -q -k try.hk 2>refused
    grep -vxFf <(grep -oE '^ *param \w+' refused | awk '{print $2}') "$part" >>taken
done
[ "$(wc -l <taken)" -gt 150 ]
ok "$(wc -l <taken) of $(wc -l <words) words may be names in scenes" $?

# All of a part at once in a force, and another part as variables of a scene of first order.
split -l 45 taken some.
scenes() { # part
    while read -r word; do printf 'param %s = 1.25\n' "$word"; done <"$1"
    printf 'var qq = 1\n'
    printf "qq'' = -qq - 0.01*qq'*(%s)*(1 + sin(0.1*qq))\n" "$(paste -sd+ "$1")"
}
flows() { # part: at most a dozen of it
    head -12 "$1" >few
    while read -r word; do printf 'var %s = 1\n' "$word"; done <few
    while read -r word; do printf "%s' = -0.1*%s - 0.01*(%s)\n" "$word" "$word" "$(paste -sd+ few)"; done <few
}
rows() { grep -v '^#' "$1" | tail -n +2 | cut -d, -f1-"$(tail -1 q.out | awk -F, '{print NF}')" | tail -1 |
    awk -F, '{for (i = 1; i <= NF; i++) printf "%.17g%s", $i, i < NF ? "," : "\n"}'; }
verdict() { # what, status, what a compiler or an interpreter says
    ok "$1" "$2"
    [ "$2" -eq 0 ] || grep -iE 'error' "$3" | head -3 | sed 's/^/#   /'
}
same() { # what hooke has, what the program has, tolerance
    awk -F, -v own="$1" -v tol="$3" '{ split(own, x, ","); for (i = 1; i <= NF; i++) { d = x[i] - $i; if (d*d > tol*tol) exit 1 } }
        END { exit NR == 0 }' <<<"$2"
}
check() { # what: q.hk
    local tol=1e-13
    grep -q tol= q.hk && tol=1e-5
    rm -f q.c q.py q.m q.csv
    "$hooke" -n -q -k q.hk >said 2>&1
    gcc -std=gnu11 -O2 -Wall -Wextra -Werror -ffp-contract=off -o q q.c -lm 2>gcc.err && ./q >q.out && same "$(rows q.csv)" "$(tail -1 q.out)" $tol
    verdict "$1: C" $? gcc.err
    if command -v python3 >/dev/null && { [ $tol = 1e-13 ] || python3 -c 'import scipy' 2>/dev/null; }; then
        python3 q.py >q.pout 2>p.err && same "$(rows q.csv)" "$(tail -1 q.pout)" $tol
        verdict "$1: Python" $? p.err
    fi
    [ -n "${LONG:-}" ] && [ -e q.m ] && command -v octave-cli >/dev/null || return
    octave-cli -q q.m >q.mout 2>m.err </dev/null && same "$(rows q.csv)" "$(tail -1 q.mout)" $tol
    verdict "$1: Octave" $? m.err
}
for part in some.*; do
    for method in "dopri5 tol=1e-8" "verlet dt=10ms drag=explicit" "backward-euler dt=10ms" "rk4 dt=10ms"; do
        { scenes "$part"; echo "duration = 0.3 s; method $method; set record all"
          printf '%s\n' 'export scene q.c' 'export scene q.py' 'export scene q.m' run 'export q.csv'; } >q.hk
        check "$part by $method"
    done
    for method in "dopri5 tol=1e-8" "backward-euler dt=10ms" "rk4 dt=10ms"; do
        { flows "$part"; echo "duration = 0.3 s; method $method; set record all"
          printf '%s\n' 'export scene q.c' 'export scene q.py' 'export scene q.m' run 'export q.csv'; } >q.hk
        check "$part as variables by $method"
    done
done
echo "1..$n"
exit "$bad"
