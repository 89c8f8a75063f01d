#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Standard streams that are closed: no file of the user gets their numbers and what is said, and output that nobody can read is an error.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
n=0 bad=0

ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; [ -n "${3:-}" ] && printf '%s\n' "$3" | sed 's/^/#   /'; fi
}

# Every writer with every set of open descriptors: the files have the bytes that they have with all of them.
declare -A writers=(
    [record]='record r.hk; k = 5 N/m; show; run 1 s'
    [export]='run 1 s; export e.csv t,y; export e.json; show'
    [redirect]='run 1 s; runs > t.csv; show'
    [save]='k = 5 N/m; save s.hk; show'
    [plot]='run 1 s; plot position > p.svg; show'
    [screenshot]='run 1 s; screenshot s.txt; show'
    [report]='run 1 s; report d; show'
)
# Nothing to be said, and nowhere to say it: no error.
for name in "${!writers[@]}"; do
    mkdir "$name" "$name.whole"
    (cd "$name.whole" && "$hooke" -n -c "${writers[$name]}" >/dev/null 2>&1)
    ok "$name works" $?
    for closed in '<&-' '>&-' '2>&-' '<&- >&-' '>&- 2>&-' '<&- >&- 2>&-'; do
        rm -rf "${name:?}" && mkdir "$name"
        (cd "$name" && eval "exec </dev/null >/dev/null 2>/dev/null $closed" && exec "$hooke" -n -c "${writers[$name]}")
        got=$?
        case $closed in *' >&-'* | '>&-'*) wanted=4 ;; *) wanted=0 ;; esac
        [ "$got" -eq "$wanted" ] && diff -r "$name.whole" "$name" >diff.txt 2>&1
        ok "$name with $closed: status $wanted, the same files" $? "status $got; $(head -n 3 diff.txt)"
    done
done
"$hooke" -n -q -c 'k = 5 N/m' >&- 2>err.txt
ok "nothing to say with nowhere to say it is no error" $? "$(cat err.txt)"
for what in '--version' '--help' '-n -c show'; do
    # shellcheck disable=SC2086
    "$hooke" $what >&- 2>/dev/null
    [ $? -eq 4 ]
    ok "$what into a closed output ends with 4" $?
done
"$hooke" -n <&- >out.txt 2>err.txt
[ $? -eq 4 ] && grep -q 'cannot read standard input' err.txt
ok "commands from a closed input end with 4, and say so" $? "$(cat err.txt)"
# What is closed gives its descriptor back.
often=$(for _ in {1..60}; do printf 'record often.hk; record off; run 0.01 s; export often.csv --force; '; done)
(ulimit -n 40; "$hooke" -n -q -c "$often" >out.txt 2>err.txt)
ok "60 recordings and files under a limit of 40 descriptors" $? "$(head -n 3 err.txt)"
# The last step of a written program is the part of a step that hooke's is.
"$hooke" -n -q -c 'method rk4 dt=10ms; duration = 1.003 s; set record all; set kernel specialised; run; export own.csv t,y,v; export scene p.c'
${CC:-cc} -ffp-contract=off -o p p.c -lm 2>err.txt && ./p >p.csv &&
    paste -d, <(tail -n 1 p.csv) <(tail -n 1 own.csv) | awk -F, '{exit !($1 == $4 && $2 == $5 && $3 == $6)}'
ok "a program in C ends with a shorter step" $? "$(tail -n 1 p.csv own.csv; head -n 3 err.txt)"
echo "1..$n"
exit "$bad"
