#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Tables and drawings for people are made only where they are shown: not with -q, not beside records in JSON.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
skip() {
    echo "1..1"
    echo "ok 1 - drawings that are dropped # SKIP $1"
    exit 0
}
[ "${CONFIG:-release}" != asan ] || skip "valgrind cannot run a program with sanitizers"
command -v valgrind >/dev/null || skip "valgrind is not installed"
here=$(mktemp -d) && cd "$here" || exit 2
trap 'rm -rf "$here"' EXIT
export HOME=$here XDG_CONFIG_HOME=$here XDG_DATA_HOME=$here XDG_CACHE_HOME=$here
n=0 bad=0
check() { # title condition
    n=$((n + 1))
    if [ "$2" = 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; fi
}
made() { # option...: whether the command lines of $lines make a table or a drawing
    valgrind -q --tool=callgrind --callgrind-out-file=counts "$hooke" -n "$@" -c "$lines" >said 2>&1
    grep -qE '^c?fn=.*(text_table_put|figure_draw)' counts
}
while read -r lines; do
    name=${lines##*; }
    made
    check "$name: it has a table or a drawing" $?
    ! made -q
    check "$name: none with -q" $?
    ! made --format json
    check "$name: none beside records" $?
done <<EOF
sweep k=1:3:1 measure=amplitude
duration = 1 s; compare euler rk4 --force
duration = 1 s; precision rk4 dt=10ms:100ms
stability rk4
duration = 1 s; order rk4 dt=10ms:100ms
scene pendulum; equilibria
scene damped; method rk4 dt=10ms; run 20 s; fit drag
EOF
echo "1..$n"
exit $bad
