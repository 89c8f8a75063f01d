#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Programs killed at random moments of their writing: whatever they leave behind is gone after the next start, and what they wrote is whole.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
export HOME=$work XDG_STATE_HOME=$work/state
n=0 bad=0
kills=$([ -n "${LONG:-}" ] && echo 125 || echo 3) # of each kind

ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; [ -n "${3:-}" ] && printf '%s\n' "$3" | sed 's/^/#   /'; fi
}

# A table of runs has the time that each took: of those only the names.
content() { if [ "$1" = split ]; then find . -type f | sort; else find . -type f -exec cksum {} + | sort; fi; }
many() { for _ in $(seq 1 "$1"); do printf '%s; ' "$2"; done; }
declare -A acts=(
    [export]="run 1 s; $(many 40 'export e.csv --force; runs > t.csv --force')"
    [save]="$(many 80 'save s.hk --force')"
    [report]="run 1 s; $(many 5 'report d --force')"
    [split]="run 1 s; $(many 10 'runs; list parameters')"
)
declare -A whole
for name in export save report split; do
    mkdir "$name"
    cd "$name" || exit 2
    command=("$hooke" -n -q -c "${acts[$name]}")
    [ "$name" = split ] && command+=(--format csv --split p)
    "${command[@]}" >/dev/null 2>&1
    ok "$name works" $?
    whole[$name]=$(content "$name")
    left=0 strays='' torn=''
    exec 3>&2 2>/dev/null # bash tells of each program that was killed
    for ((i = 0; i < kills; i++)); do
        [ "$name" = split ] && rm -rf p
        "${command[@]}" >/dev/null 2>&1 &
        child=$!
        sleep "0.$(printf '%03d' $((RANDOM % 150)))"
        kill -9 $child
        wait $child
        [ -n "$(find . -name '.hooke-*')" ] && left=$((left + 1))
        "$hooke" -n -q -c 'echo next' >/dev/null
        strays+=$(find "$work" -name '.hooke-*')
        now=$(content "$name")
        [ "$now" = "${whole[$name]}" ] || { [ "$name" = split ] && [ -z "$now" ]; } || torn+="$i: $now "
    done
    exec 2>&3
    [ -z "$strays" ]
    ok "$name killed $kills times, $left times with something left behind: gone after the next start" $? "$strays"
    [ -z "$torn" ]
    ok "$name: the old or the new one, whole" $? "$torn"
    cd ..
done

# The next writer in another folder does the same there.
mkdir elsewhere && touch elsewhere/.hooke-0badcafe.x.csv .hooke-0badcafe-mine
"$hooke" -n -q -c 'run 1 s; export elsewhere/e.csv'
[ "$(ls -A elsewhere)" = e.csv ] && [ -e .hooke-0badcafe-mine ]
ok "a writer sweeps the folder it writes to, and nothing of the user's" $? "$(ls -A elsewhere)"
echo "1..$n"
exit "$bad"
