#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Lessons in batch: right and wrong answers, all skipped, other numbers for each seed, lessons of one's own.
set -u
hooke=$PWD/${HOOKE:-build/hooke} page=$PWD/scripts/pages/hooke-lab.7
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
! does 'lab seed=9' && grep -q 'bare-9.txt exists' out && grep -q 'lab off; lab seed=10' out && [ "$(cat bare-9.txt)" = mine ]
ok "a file of that name stays" $?
T=$(period 7)
does "lab seed=7; load bare-7.txt; measure period; check $T s" && grep -q '^3/' out
ok "right: it goes on" $?
does "lab seed=7; load bare-7.txt; measure period; check 1.01*$T s" && grep -q '^not correct' out && ! grep -q '^3/' out
ok "wrong by 1 %: it stays" $?
does "lab seed=7; load bare-7.txt; measure period; check $T kg" && grep -q '^not correct: its unit is that of mass; this step takes time \[s\] or frequency \[Hz\] or angular frequency \[rad/s\]' out
ok "right, but for the unit: the kinds that it takes are named" $?
does "lab resonance; print omega0; check 8.7 kg" && grep -q 'takes angular frequency' out
ok "in other lessons, too" $?
"$hooke" -n -c 'lab seed=7; load bare-7.txt; check 0.5 s' >out 2>&1
[ $? -eq 1 ] && grep -q 'not yet' out
ok "not measured yet" $?
does 'lab seed=7; skip; measure period' || "$hooke" -n -c "load bare-7.txt; measure period; lab seed=7; skip; check $T s" >out 2>&1
[ $? -eq 1 ] && grep -q 'not yet' out
ok "what was measured before the step does not count" $?
does "lab seed=7; load bare-7.txt; again; hint; measure period; hint" && ! grep -v '^T = \|^autoc' out | grep -q "${T%?}"
ok "hint and again do not tell the value" $?
for lesson in lab resonance stiff; do
    steps=$("$hooke" -n -c "lab $lesson" | sed -n 's/^1\/\([0-9]*\):.*/\1/p')
    does "lab $lesson$(printf '; skip%.0s' $(seq "$steps"))" && grep -q 'the lesson is finished' out
    ok "$lesson: all of it skipped" $?
    ! does "lab $lesson$(printf '; skip%.0s' $(seq "$steps")); check 1" && grep -q 'no lesson is active' out
    ok "$lesson: nothing after the end" $?
done
! does 'check 1' && grep -q 'no lesson is active' out && ! does hint && ! does 'lab off; again'
ok "without a lesson" $?
# the commands of each step are ones that work: the whole lab as it tells to type it
for lesson in lab resonance stiff; do
    steps=$("$hooke" -n -c "lab $lesson seed=3" | sed -n 's/^1\/\([0-9]*\):.*/\1/p')
    work="lab $lesson seed=3"
    for step in $(seq "$steps"); do
        skips=$(for _ in $(seq 2 "$step"); do printf '; skip'; done)
        "$hooke" -n -c "lab $lesson seed=3$skips" >said
        type=$(sed -n 's/^  type: //p' said | tail -1)
        work="$work; $type"
        tail -1 said | grep -q 'then: check' && work="$work; skip"
    done
    does "$work" && ! grep -q 'error:' out && grep -q 'the lesson is finished' out
    ok "$lesson: what is to be typed works" $?
done
[ -s lab-report-3/session.hk ] && ! grep -q '^\(lab\|skip\)' lab-report-3/session.hk && "$hooke" -n --check lab-report-3 >out 2>&1
ok "its report does not depend on the lesson" $?
printf '# mine\n#: Set the mass.\n#> m = 100 g\n#! in g\n#? value m\n#: $seed\n' >own.hk
does 'lab own.hk seed=5; m = 100 g; check 0.1 kg' && grep -q '^2/2: 5' out
ok "a lesson of one's own, with units" $?
printf '#: Set it.\r\n#> m = 100 g\r\n#? value m\r\n' >crlf.hk
does 'lab crlf.hk; m = 100 g; check 0.1 kg' && grep -q '  type: m = 100 g$' out && grep -q 'the lesson is finished' out
ok "lines that end in CR LF" $?
printf '#: \033]0;mine\a\n#> print 1\n#! \033[2J\n#? done print\n' >evil.hk
does 'lab evil.hk; hint; print 1' && ! grep -q "$(printf '[\033\a]')" out && grep -q 'mine' out
ok "a lesson does not command the terminal" $?
printf 'run 1\n' >none.hk
! does 'lab none.hk' && grep -q 'no steps' out && ! does 'lab nowhere' && grep -q 'lab, resonance, stiff' out
ok "a file without steps, no file" $?
printf '#: a\n#> run\n#? dun run\n' >dun.hk
! does 'lab dun.hk; run' && grep -q "line 3 of the lesson: '#? dun run'" out
ok "a lesson that waits for what is unknown is refused" $?
printf '#: a\n#> run\n#? done\n' >dun.hk
! does 'lab dun.hk' && grep -q 'line 3' out && printf '#@ board\n#: a\n' >dun.hk && ! does 'lab dun.hk' && grep -q 'bare, disk' out
ok "so are one that waits for nothing, and a recording that is unknown" $?
printf 'lab seed=7\nload bare-7.txt\nmeasure period\ncheck %s s\n' "$T" | "$hooke" -n >out 2>&1 && grep -q '^3/' out
ok "in a pipe what is done goes on" $?
does "lab seed=7; load bare-7.txt; lab" && [ "$(grep -c '^2/' out)" -eq 2 ] && ! does "lab seed=7; load bare-7.txt; lab seed=6" && grep -q 'is in progress at step 2' out && [ ! -e bare-6.txt ]
ok "a second lab does not begin anew" $?
cp bare-7.txt swing.txt
does "load swing.txt; lab seed=6; measure period; check $T s" && grep -q '^3/' out && [ ! -e bare-6.txt ]
ok "a recording of one's own that was loaded before is taken, and none is written" $?
skips=$(printf '; skip%.0s' $(seq 12))
does "lab seed=7; load bare-7.txt$skips; lab seed=3" && [ "$(tail -3 out | grep -c '^1/13\|type: load bare-3.txt')" -eq 2 ]
ok "after a lesson another seed has its own recording" $?
does "lab seed=7; load disk-7.txt$skips; lab seed=7" && tail -3 out | grep -q '^1/13' && does "lab seed=7; load bare-7.txt; lab off; lab seed=7" && grep -q 'bare-7, which is already loaded' out
ok "the recording with the disk is not that of the first step; that of this step is" $?
does "lab seed=7; load swing.txt$skips; lab seed=3" && grep -q 'swing, which is already loaded' out
ok "one's own recording is kept in the next lesson" $?
does "lab seed=7; load bare-7.txt; measure period; check (1/$T) Hz" && grep -q '^3/' out && does "lab seed=7; load bare-7.txt; measure period; check (2*pi/$T) rad/s" && grep -q '^3/' out
ok "a period said as a frequency" $?
does "lab seed=7; load bare-7.txt; measure period; check 1.01*$T +- 0.005 s" && grep -q '^3/' out && does "lab seed=7; load bare-7.txt; measure period; check 1.01*$T +- 0.001 s" && grep -q '^not correct' out
ok "a stated uncertainty is the tolerance" $?
! does "lab seed=7; load bare-7.txt; measure period; check 0.5 +- 0.4 s" && grep -q 'too large for a check' out
ok "unless it tells nothing" $?
vague="lab seed=7; load bare-7.txt; skip; m = 195.5 +- 0.1 g; measure k"
! does "$vague; check 15 +- 1.5 N/m" && grep -q 'too large for a check: above 2 %' out && does "$vague; check 16.6 +- 0.3 N/m" && grep -q '^4/' out
ok "10 % of a spring constant does not make each spring right, 2 % is taken" $?
does "$vague; check 14.9 +- 0.29 N/m" && grep -q '^not correct: outside the stated uncertainty' out
ok "nor does 2 %" $?
! does "lab seed=7; load bare-7.txt; measure period; check 0.5 +- 0.4 kg" 2>/dev/null; grep -q 'that of mass' out
ok "the unit comes before the uncertainty" $?
to_drift="lab seed=7$(printf '; skip%.0s' $(seq 5)); run 10 s; measure drift"
does "$to_drift; check 0.5 s" && grep -q 'takes a number without unit' out && ! grep -q 'unit or ' out
ok "a number without unit is named once" $?
to_tau="lab seed=7$(printf '; skip%.0s' $(seq 8)); load disk-7.txt; measure decay"
does "$to_tau" && tau=$(sed -n 's/.* tau = \([0-9.]*\) .*/\1/p' out | tail -1) && does "$to_tau; check $tau s" && grep -q '^11/' out && does "$to_tau; check (2/$tau) 1/s" && grep -q '^11/' out && does "$to_tau; check $tau 1/s" && grep -q '^not correct' out
ok "a decay as tau or gamma" $?
cp bare-7.txt mine.txt
to_k='lab seed=7; load mine.txt; skip; m = 200.0 +- 0.1 g; fit damped; measure k'
does "lab seed=7; load mine.txt; skip" && grep -q 'type: m = MASS +- 0.1 g; fit damped; measure k' out && does "$to_k" && k=$(sed -n 's/^k = \([0-9.]*\) .*(m =.*/\1/p' out) && does "$to_k; check $k N/m" && grep -q '^4/' out
ok "of one's own recording the mass is one's own" $?
! does "$to_k; m = 190 g; check $k N/m" && grep -q 'a parameter has changed' out
ok "a value measured with another mass does not count" $?
head -500 disk-7.txt >bare-5.txt
printf 'lab seed=5\nload bare-5.txt\nskip\n' | "$hooke" -n --keep-going >out 2>&1
grep -q 'type: m = MASS' out && ! grep -q 'm = [0-9]' out
ok "a file of one's own with a generated name: the mass is one's own" $?
does "$to_k; undo; check $k N/m" 2>/dev/null; grep -q 'the mass is not set: type: m = MASS' out && grep -q 'error: not yet' out
ok "a mass that was undone is asked for again, and its k does not count" $?
does "$to_k; undo; measure k; check $k N/m"; grep -q 'error: not yet' out
ok "nor does that of the scene's mass" $?
does "$to_k; undo; redo; measure k; check $k N/m" && grep -q '^4/' out
ok "redone it counts" $?
does "lab seed=7; load bare-7.txt; skip; measure k; check $k N/m"; grep -q 'error: not yet' out
ok "without the mass of the generated recording k does not count either" $?
figures="lab seed=7; load bare-7.txt; skip; skip; gamma = 0; method euler dt=10 ms; run 10 s"
does "$figures" && tr '\n' ' ' <out | grep -q "'lab figure 4' draws" && does "$figures; lab figure 4" && [ "$(grep -c '^hooke> plot \(position\|velocity\|phase\)' out)" -eq 3 ]
ok "the figures that a step names are drawn by one command" $?
# the lesson of the manual page
awk '/^\.EX$/ {lesson = 1; next} /^\.EE$/ {lesson = 0} lesson && /^#: [^T]/ {found = 1} lesson && found' "$page" >page.hk
does "lab page.hk; m = 200 g; k = 15 N/m; print omega0; check 8.66 rad/s" && grep -q "^2/2: How fast" out && grep -q 'the lesson is finished' out && [ -s page.hk ]
ok "the lesson that the manual shows" $?
"$hooke" -n --format json -c 'lab stiff; skip' >out && python3 -c 'import json
r = [json.loads(line) for line in open("out")]
assert [x["kind"] for x in r] == ["lesson"] * 2 and r[1]["step"] == 2 and r[1]["state"] == "waits"'
ok "as JSON" $?
echo "1..$n"
exit $bad
