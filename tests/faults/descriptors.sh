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
echo "1..$n"
exit "$bad"
