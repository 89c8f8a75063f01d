#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Lessons in batch: right and wrong answers, all skipped, other numbers for each seed, lessons of one's own.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
n=0 bad=0
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
ok() { # name status
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else echo "not ok $n - $1"; sed 's/^/# /' out; bad=1; fi
}
does() { "$hooke" -n --safe -c "$1" >out 2>&1; }
period() { "$hooke" -n -c "load bare-$1.txt; measure period" | sed -n 's/^T = \([0-9.]*\) .*/\1/p'; }

does 'lab seed=7' && grep -q '^1/[0-9]*: ' out && grep -q 'type: load bare-7.txt' out && [ -s bare-7.txt ]
ok "a lesson begins and makes its recording" $?
cp bare-7.txt first
does 'lab seed=7' && cmp -s first bare-7.txt
ok "the same seed: the same recording, taken again" $?
does 'lab seed=8' && [ "$(period 7)" != "$(period 8)" ]
ok "another seed: another period" $?
echo mine >bare-9.txt
! does 'lab seed=9' && grep -q 'bare-9.txt exists' out && [ "$(cat bare-9.txt)" = mine ]
ok "a file of that name stays" $?
T=$(period 7)
does "lab seed=7; load bare-7.txt; check; measure period; check $T s" && grep -q '^3/' out
ok "right: it goes on" $?
does "lab seed=7; load bare-7.txt; check; measure period; check 1.01*$T s" && grep -q '^not that' out && ! grep -q '^3/' out
ok "wrong by 1 %: it stays" $?
does "lab seed=7; load bare-7.txt; check; measure period; check $T kg" && grep -q '^not that' out
ok "right, but for the unit" $?
"$hooke" -n -c 'lab seed=7; load bare-7.txt; check; check 0.5 s' >out 2>&1
[ $? -eq 1 ] && grep -q 'not yet' out
ok "not measured yet" $?
does 'lab seed=7; skip; measure period' || "$hooke" -n -c "load bare-7.txt; measure period; lab seed=7; skip; check $T s" >out 2>&1
[ $? -eq 1 ] && grep -q 'not yet' out
ok "what was measured before the step does not count" $?
does "lab seed=7; load bare-7.txt; check; again; hint; measure period; hint" && ! grep -v '^T = \|^autoc' out | grep -q "${T%?}"
ok "hint and again do not tell the value" $?
for lesson in lab resonance stiff; do
    steps=$("$hooke" -n -c "lab $lesson" | sed -n 's/^1\/\([0-9]*\):.*/\1/p')
    does "lab $lesson$(printf '; skip%.0s' $(seq "$steps"))" && grep -q 'the lesson is over' out
    ok "$lesson: all of it skipped" $?
    ! does "lab $lesson$(printf '; skip%.0s' $(seq "$steps")); check 1" && grep -q 'no lesson waits' out
    ok "$lesson: nothing after the end" $?
done
! does 'check 1' && grep -q 'no lesson waits' out && ! does hint && ! does 'lab off; again'
ok "without a lesson" $?
# the commands of each step are ones that work: the whole lab as it tells to type it
for lesson in lab resonance stiff; do
    steps=$("$hooke" -n -c "lab $lesson seed=3" | sed -n 's/^1\/\([0-9]*\):.*/\1/p')
    work="lab $lesson seed=3"
    for step in $(seq "$steps"); do
        skips=$(for _ in $(seq 2 "$step"); do printf '; skip'; done)
        type=$("$hooke" -n -c "lab $lesson seed=3$skips" | sed -n 's/^  type: //p' | tail -1)
        work="$work; $type; skip"
    done
    does "$work" && grep -q 'the lesson is over' out
    ok "$lesson: what is to be typed works" $?
done
[ -s lab-report-3/session.hk ] && ! grep -q '^\(lab\|skip\)' lab-report-3/session.hk && "$hooke" -n --check lab-report-3 >out 2>&1
ok "its report does not depend on the lesson" $?
printf '# mine\n#: Set the mass.\n#> m = 100 g\n#! in g\n#? value m\n#: $seed\n' >own.hk
does 'lab own.hk seed=5; m = 100 g; check 0.1 kg' && grep -q '^2/2: 5' out
ok "a lesson of one's own, with units" $?
printf '#: Set it.\r\n#> m = 100 g\r\n#? value m\r\n' >crlf.hk
does 'lab crlf.hk; m = 100 g; check 0.1 kg' && grep -q '  type: m = 100 g$' out && grep -q 'over' out
ok "lines that end in CR LF" $?
printf '#: \033]0;mine\a\n#> print 1\n#! \033[2J\n#? done print\n' >evil.hk
does 'lab evil.hk; hint; print 1; check' && ! grep -q "$(printf '[\033\a]')" out && grep -q 'mine' out
ok "a lesson does not command the terminal" $?
printf 'run 1\n' >none.hk
! does 'lab none.hk' && grep -q 'no steps' out && ! does 'lab nowhere' && grep -q 'lab, resonance, stiff' out
ok "a file without steps, no file" $?
"$hooke" -n --format json -c 'lab stiff; skip' >out && python3 -c 'import json
r = [json.loads(line) for line in open("out")]
assert [x["kind"] for x in r] == ["lesson"] * 2 and r[1]["step"] == 2 and r[1]["state"] == "waits"'
ok "as JSON" $?
echo "1..$n"
exit $bad
