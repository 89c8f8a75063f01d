#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Every way out of the program under valgrind: right status, no invalid access, nothing leaked.
set -u
hooke=${HOOKE:-build/hooke}
if [ "${CONFIG:-release}" = asan ] || ! command -v valgrind >/dev/null; then
    echo "ok 1 - ways out under valgrind # SKIP no valgrind, or a build with sanitizers of its own"
    echo "1..1"
    exit 0
fi
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
n=0 bad=0
checked=(valgrind -q --leak-check=full --errors-for-leak-kinds=definite --error-exitcode=99 --log-file="$folder/log")
memcheck() { "${checked[@]}" "$@"; }
leaves() { # name wanted-status command...
    local name=$1 wanted=$2 got
    shift 2
    "$@" >"$folder/out" 2>&1 </dev/null
    got=$?
    n=$((n + 1))
    if [ "$got" -eq "$wanted" ] && [ ! -s "$folder/log" ]; then echo "ok $n - $name ($wanted)"; else
        bad=1
        echo "not ok $n - $name: status $got, wanted $wanted"
        head -20 "$folder/log" | sed 's/^/#   /'
    fi
}
lab='load examples/lab/bare.txt; m = 200 g; fit damped; adopt; compare euler rk4; plot phase run all; undo 2; redo; screenshot'
leaves "the lab, then the end of input" 0 memcheck "$hooke" -c "$lab"
leaves "quit" 0 memcheck "$hooke" -c "run; quit"
leaves "a mistake" 1 memcheck "$hooke" -c "run; set gama 1"
leaves "an unknown option" 2 memcheck "$hooke" --nonsense
leaves "a diverged run" 3 memcheck "$hooke" -c "method verlet dt=0.5; run 2000 s"
leaves "no such file" 4 memcheck "$hooke" -c "load no-such-file.txt"
full_device() { memcheck "$hooke" -c 'run; print y' >/dev/full; }
leaves "a full device" 4 full_device
# The signal has to reach the program itself, not a shell around it. From the message on, which is not kept back, it computes.
terminated() {
    "${checked[@]}" "$hooke" -k -c 'set gama 1' -c 'method verlet; run 20000000 s --force' 2>"$folder/said" &
    local program=$!
    for ((i = 0; i < 600; i++)); do
        grep -q gama "$folder/said" && break
        sleep 0.05
    done
    sleep 0.1
    kill -TERM $program
    wait $program
}
leaves "terminated during a run" 143 terminated
echo "1..$n"
exit "$bad"
