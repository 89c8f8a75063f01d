#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# collect from pipes: every line that is sent arrives, once; what is broken is counted; what ends it early keeps what came.
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
# In the background: whoever kills it kills no shell around it, which would leave it writing to the next reader of the pipe.
sensor() { exec "$hooke" --simulate-sensor "$@"; }
value() { sed -n "s/.*\"$1\":\"\{0,1\}\([^,\"}]*\).*/\1/p" "$2" | head -n 1; } # of the record
raw() { grep -v '^#' "$1" | cut -f 2-; }
is() { # name wanted got
    [ "$2" = "$3" ]
    ok "$1" $? "wanted $2, got $3"
}
fit_of() { grep '"kind":"fit"' "$1" | sed 's/"of":"[^"]*"//'; }
# Until the file has it; a minute at most, however slow the machine is.
await() { # text file
    for _ in $(seq 600); do
        grep -q "$1" "$2" 2>/dev/null && return
        sleep 0.1
    done
}
# What a machine that stands still for a moment may spoil is done again: a fault spoils all of them.
attempts() { # command...
    for _ in 1 2 3 4 5 6 7 8; do "$@" && return; done
    return 1
}
mkfifo pipe
await 'has sent nothing' silent.txt | "$hooke" -n -c 'collect -' >silent.txt 2>&1 &
(printf '\377\376\375'; await 'no line end' endless.out) | "$hooke" -n -c 'collect - to=endless.txt' >endless.out 2>&1 &
waiting="$(jobs -p)"

# ---- all of it, once
seconds=${LONG:+600}
seconds=${seconds:-1.5}
lines=$(awk -v s="$seconds" 'BEGIN { print s * 1000 }')
sensor spring rate=1000 noise=0.03cm gamma=0.1 quirks=off time=s for="$seconds" >pipe &
source=$!
"$hooke" -n --format json -c 'collect pipe to=all.txt; fit damped' >all.json 2>all.err
wait $!
is "$lines lines at 1000 a second: none is lost" "$lines" "$(value rows all.json)"
is "none is invented" "$((${lines%.*} + 1))" "$(raw all.txt | wc -l)"
is "none is garbled" 0 "$(value garbled all.json)"
is "the clock is the device's" device "$(value clock all.json)"
is "it ends with the pipe" ok "$(value status all.json)"
"$hooke" -n --format json -c 'load all.txt; fit damped' >again.json 2>&1
is "load gives the same fit" "$(fit_of all.json)" "$(fit_of again.json)"

# ---- without a clock, with quirks
without_clock() {
    rm -f swing-*.txt
    sensor spring rate=500 noise=0.03cm gamma=0.1 time=none for=1.9s >pipe &
    "$hooke" -n -c 'collect pipe unit=cm as=swing for=1.7s; fit damped' >none.txt 2>&1
    wait $!
    period=$(sed -n 's/^  T = \([0-9.]*\) .*/\1/p' none.txt)
    awk -v t="${period:-0}" 'BEGIN { exit !(t > 0.7245 && t < 0.7266) }' && # 2 pi sqrt(m/k) = 0.72552 s; 1.7 s hold two periods
        grep -q 'with a jitter of' none.txt
}
# Did sender or reader miss the processor for more than 10 ms? The times of arrival in the file say so.
arrivals_have_gaps() { grep -v '^#' "$1" | awk '{ if (NR > 1 && $1 - before > 0.01) gaps++; before = $1 } END { exit !gaps }'; }
for attempt in 1 2 3; do
    without_clock && status=0 && break
    status=1
    arrivals_have_gaps swing-1.txt || break
done
# Where the lines did not arrive in time, three times, they need to be warned of.
warns_of_gaps() { [ "$status" -ne 0 ] && arrivals_have_gaps swing-1.txt && grep -q 'warning: .*\(with a jitter of\|arrive unevenly\)' none.txt; }
[ "$status" -eq 0 ] || warns_of_gaps
ok "the period by the line through the arrivals, and their jitter" $? "$(cat none.txt)"
relative() { sed -n "s/.*$1\([0-9.]*\) +- \([0-9.]*\).*/\1 \2/p" none.txt | head -n 1; }
awk -v t="$(relative '  T = ')" -v f="$(relative 'arrivals, ')" 'BEGIN { split(t, x, " "); split(f, y, " ")
    exit !(y[2] > 0 && x[2] / x[1] > 0.8 * y[2] / y[1]) }' && grep -q 'including the uncertainty of the sampling rate' none.txt ||
    warns_of_gaps
ok "the uncertainty of T has that of the rate in it, and says so" $? "$(cat none.txt)"
grep -q '3 skipped before the first sample' none.txt
ok "text at the start is told" $? "$(cat none.txt)"
[ -e swing-1.txt ]
ok "as= names the file" $?

# ---- what ends it early
sensor spring rate=500 quirks=off time=s seed=7 for=5s >reference.txt & # at least what those send that are killed
reference=$!
sensor spring rate=500 quirks=off time=s seed=7 for=30s >pipe 2>/dev/null &
source=$!
"$hooke" -n -c 'collect pipe to=int.txt; measure period' >int.out 2>&1 &
program=$!
until [ -e int.txt ] && [ "$(wc -l <int.txt)" -gt 900 ]; do sleep 0.05; done
"$hooke" -n -c 'collect pipe to=second.txt' >second.out 2>&1
grep -q 'another program is collecting from it' second.out && [ ! -e second.txt ]
ok "two do not share a pipe" $? "$(cat second.out)"
kill -INT $program
wait $program
is "Ctrl-C ends it, and is no failure" 0 $?
grep -q '(stopped)' int.out && grep -q '^T = ' int.out
ok "what came is kept and goes on being measured" $? "$(cat int.out)"
wait $source

times="0.2 0.5"
[ -n "${LONG:-}" ] && times=$(seq 0.1 0.01 2.1)
kept=0 killed=0
wait $reference
broken=0
kill_after() { # seconds; whether all that is older than a second is in the file
    rm -f killed.txt
    sensor spring rate=500 quirks=off time=s seed=7 for=5s >pipe &
    source=$!
    "$hooke" -n -c 'collect pipe to=killed.txt' >/dev/null 2>&1 &
    program=$!
    until [ -e killed.txt ] && [ "$(wc -l <killed.txt)" -gt 2 ]; do sleep 0.02; done
    begin=$(date +%s%N)
    sleep "$1"
    kill -KILL $program
    spent=$((($(date +%s%N) - begin) / 1000000))
    wait $program 2>/dev/null
    kill $source 2>/dev/null
    wait $source
    count=$(raw killed.txt | wc -l)
    raw killed.txt | head -n "$count" | cmp -s - <(tr -d '\r' <reference.txt | head -n "$count") || broken=$((broken + 1))
    [ "$count" -ge $(((spent - 1000) / 2)) ]
}
for time in $times; do
    killed=$((killed + 1))
    attempts kill_after "$time" && kept=$((kept + 1))
done
is "killed at $killed times: all that is older than a second is in the file" "$killed" "$kept"
is "what is in the file is what was sent" 0 "$broken"
before=$(raw killed.txt | wc -l)
sensor spring rate=500 quirks=off time=s seed=7 for=0.5s >pipe &
"$hooke" -n -c 'load killed.txt; collect continue' >continue.out 2>&1
wait $!
[ "$(raw killed.txt | wc -l)" -eq $((before + 251)) ]
ok "collect continue goes on with the file" $? "$before lines before: $(cat continue.out)"
sensor spring rate=500 quirks=off time=s seed=7 for=0.5s >pipe &
"$hooke" -n -c 'load int.txt; collect again' >again.out 2>&1
wait $!
[ -e pipe-1.txt ] && [ "$(raw pipe-1.txt | wc -l)" -eq 251 ]
ok "collect again begins another file" $? "$(cat again.out)"
sensor spring rate=1000 quirks=off time=s for=2s >pipe 2>/dev/null &
bash -c "ulimit -f 16; exec '$hooke' -n --format json -c 'collect pipe to=full.txt'" >full.json 2>full.err
is "a file that takes no more is a failure" 4 $?
is "and a status" full "$(value status full.json)"
grep -q 'what it contains is complete, but [0-9]* lines\? \(are\|is\) lost' full.err
ok "how many lines are lost is said" $? "$(cat full.err)"
raw full.txt | cmp -s - <(sensor spring rate=1000 quirks=off time=s for=1s | tr -d '\r' | head -n "$(raw full.txt | wc -l)")
ok "and has whole lines" $? "$(tail -n 2 full.txt)"

# ---- what ends at once
swing() { awk -v n="$1" 'BEGIN { for (i = 0; i < n; i++) printf "%d,%.3f\n", 20 * i, 20 + 5 * cos(0.174 * i) }'; }
whole=0
for i in $(seq 30); do
    swing 200 | "$hooke" -n -c "collect - to=once-$i.txt tunit=ms" >once.out 2>&1 && [ "$(raw "once-$i.txt" | wc -l)" -eq 200 ] &&
        grep -q ' 200 lines, 200 samples (ok)' once.out && whole=$((whole + 1))
done
is "what ends before anybody has looked is kept" 30 "$whole"

# ---- what is waited for
trigger() { # file condition options
    rm -f "$1"
    swing 300 | "$hooke" -n --format json -c "collect - to=$1 tunit=ms $3 trigger=\"$2\" before=0.1s" >trigger.json 2>trigger.err
}
trigger came.txt 'y rising 22 cm' unit=cm
is "a trigger in what ended at once is found" 0.5 "$(value t_start trigger.json)" # 20 ms 30 at 22 cm - 0.1 s
trigger plain.txt 'y rising 22 cm' ''
is "numbers without a unit are in that of the trigger" 0.5 "$(value t_start trigger.json)"
trigger never.txt 'y rising 32 cm' unit=cm
is "one that never came is an error" 4 $?
is "and a status" untriggered "$(value status trigger.json)"
grep -q 'the trigger never happened: y rising 32 cm; y was 15 to 25 cm in 300 samples' trigger.err && [ "$(raw never.txt | wc -l)" -eq 300 ]
ok "what was seen instead is told, and kept" $? "$(cat trigger.json trigger.err)"
trigger who.txt 'z rising 22' ''
is "a column that is not there is refused" 1 $?
grep -q "no column is called 'z'" trigger.err
ok "and named" $? "$(cat trigger.json)"
trigger what.txt 'y rising 22 deg' unit=cm
grep -q 'is a length, but deg is not' trigger.err
ok "a length is not waited for in degrees" $? "$(cat trigger.json)"
{
    swing 300
    for _ in $(seq 2000); do [ -e gave-up.txt ] && [ "$(raw gave-up.txt | wc -l)" -eq 300 ] && break; sleep 0.05; done
    kill -INT "$(cat pid)"
    while kill -0 "$(cat pid)" 2>/dev/null; do sleep 0.05; done
} | {
    echo $BASHPID >pid
    exec timeout 120 "$hooke" -n -c 'collect - to=gave-up.txt tunit=ms trigger="y rising 99"; measure period' >gave-up.out 2>&1
}
grep -q 'the trigger never happened' gave-up.out && grep -q '^T = ' gave-up.out
ok "who gives up has what came" $? "$(cat gave-up.out)"

# ---- how long: from the first line or from the trigger, also where the device's clock has been going on before
hours() { # options: a clock that is at 7200 s
    rm -f hours.txt
    { sensor spring rate=200 quirks=off time=s for=3s 2>/dev/null | sed -u 's/^\([0-9]\.\)/720\1/' >pipe; } 2>/dev/null &
    source=$!
    eval "timeout 120 '$hooke' -n --format json -c 'collect pipe for=1s to=hours.txt $1'" >hours.json 2>hours.err
    wait $source
    awk -v a="$(value t_start hours.json)" -v b="$(value t_end hours.json)" -v want="$2" 'BEGIN {
        exit !(a >= 7200 && b - a > want - 0.01 && b - a < want + 0.001) }'
}
attempts hours '' 1 || arrivals_have_gaps hours.txt
ok "for=1s is a second of lines, and no more" $? "$(cat hours.json hours.err)"
attempts hours 'trigger="y falling 30 cm" before=0.1s' 1.1 || arrivals_have_gaps hours.txt
ok "also from a trigger on" $? "$(cat hours.json hours.err)"

# ---- what never comes, and what nobody can read
: >pipe &
"$hooke" -n -c 'collect pipe to=nothing.txt' >out.txt 2>&1
is "nothing is said to be nothing" 4 $?
[ ! -e nothing.txt ]
ok "and leaves no file" $?
wait $waiting
grep -q 'has sent nothing for 2 s' silent.txt
ok "who is silent is said to be" $? "$(cat silent.txt)"
grep -q 'no line end' endless.out
ok "who ends no line, too" $? "$(cat endless.out)"
{ for i in $(seq 60); do printf '%d,%d\n' "$((i * 10))" "$((i * 37 % 50))"; done; head -c 1000000 /dev/zero | tr '\0' 7
    printf '\n\0\0\0\n\033[2J\033]0;gone\007\n%070000d\n' 0; for i in $(seq 61 120); do printf '%d,%d\n' "$((i * 10))" "$((i * 37 % 50))"; done; } |
    "$hooke" -n --format json -c 'collect - to=broken.txt tunit=ms' >broken.json 2>broken.err
is "a line of 1e6 digits, NULs and sequences for the terminal are garbled" 4 "$(value garbled broken.json)"
is "what is around them is not" 120 "$(value rows broken.json)"
! LC_ALL=C grep -q $'[\001-\010\013-\037\177]' broken.txt broken.json broken.err
ok "nothing of them is written as it came" $?
for i in $(seq 0 99); do printf '%d,%d\n' "$((i * 10))" "$i"; done | # over before anything is looked at
    "$hooke" -n -c 'collect - to=few.txt tunit=ms trigger="y rising 50"' >few.out 2>&1
grep -q 'trigger: y at t = 0.5 s' few.out && grep -q 'few.txt: 100 lines' few.out
ok "what is over at once is all there, and triggers" $? "$(cat few.out)"
"$hooke" -n --safe -c 'collect /dev/zero' >out.txt 2>&1
grep -q 'safe does not allow devices' out.txt
ok "--safe does not allow devices" $? "$(cat out.txt)"
printf 'collect -\n1 2\n' | "$hooke" -n >out.txt 2>&1
grep -q 'already provides the commands' out.txt
ok "commands and lines do not share standard input" $? "$(cat out.txt)"
echo "1..$n"
exit "$bad"
