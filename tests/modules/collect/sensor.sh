#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The simulated sensor: paced, seeded, with quirks that are told, and with the scene's own period.
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
sensor() { "$hooke" --simulate-sensor "$@"; }

begin=$(date +%s%N)
sensor spring rate=500 noise=0.03cm seed=3 gamma=0.1 for=1.5s >one.txt &
sensor spring rate=500 noise=0.03cm seed=3 gamma=0.1 for=1.5s >same.txt &
sensor spring rate=500 noise=0.03cm seed=4 gamma=0.1 for=1.5s >other.txt &
sensor pendulum rate=500 time=none quirks=off for=0.02s >angle.txt
wait
took=$((($(date +%s%N) - begin) / 1000000))
[ "$took" -ge 1490 ]
ok "1.5 s of it take 1.5 s" $? "$took ms"
cmp -s one.txt same.txt
ok "a seed gives the same bytes" $?
! cmp -s one.txt other.txt
ok "another gives others" $?
head -n 3 one.txt | grep -q 'ranging sensor'
ok "it chats at the start" $?
[ "$(wc -l <angle.txt)" -eq 11 ] && head -n 2 angle.txt | tail -n 1 | grep -q '^90\.000'
ok "without quirks a heading and the values: 90 degrees of the pendulum" $? "$(cat angle.txt)"
"$hooke" -n -c 'load one.txt; fit damped' >fit.txt 2>&1
period=$(sed -n 's/^  T = \([0-9.]*\).*/\1/p' fit.txt)
awk -v t="${period:-0}" 'BEGIN { exit !(t > 0.7250 && t < 0.7260) }' # 2 pi sqrt(m/k) of the spring: 0.72552 s
ok "the fit finds the scene's period" $? "$(cat fit.txt)"
sensor spring rate=500 | head -n 5 >/dev/null
[ "${PIPESTATUS[0]}" -eq 0 ]
ok "it ends when nobody reads any more" $?
if [ -c /dev/full ]; then
    sensor spring rate=500 for=1s >/dev/full 2>err.txt
    [ $? -eq 4 ] && grep -q 'cannot write standard output' err.txt
    ok "a line that cannot be written is an error" $? "$(cat err.txt)"
fi
for wrong in nowhere 'spring rate=1e9' 'spring noise=3s' 'spring quirks=no' 'spring kk=1' 'spring rate'; do
    # shellcheck disable=SC2086
    sensor $wrong for=1 >out.txt 2>err.txt
    [ $? -eq 2 ] && [ -s err.txt ]
    ok "'$wrong' is refused" $? "$(cat out.txt err.txt)"
done
echo "1..$n"
exit "$bad"
