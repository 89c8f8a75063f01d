#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The generated parts of the README are what the program writes, every example runs, every example of the help runs,
# the sample recordings are what their generator makes.
set -u
hooke=${HOOKE:-build/hooke}
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; [ -n "${3:-}" ] && printf '%s\n' "$3" | head -15 | sed 's/^/#   /'; fi; }

difference=$(scripts/reference check "$hooke"); ! grep -q '^not ok' <<<"$difference"
ok "README.md is what the program writes (make reference)" $? "$difference"
[ "$(wc -l <README.md)" -le 250 ]
ok "README.md is a front door: at most 250 lines" $? "$(wc -l <README.md) lines"

# Numbers that the text states.
count() { "$hooke" --format json -c "list $1" | grep -vc '"yardstick":true'; }
grep -q "all $(count methods) integrators" README.md && grep -q " $(count formats) instruments' formats" README.md
ok "README.md counts the methods and formats that there are" $? "$(count methods), $(count formats)"

folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
scripts/make-recordings "$folder"
cmp -s "$folder/bare.txt" examples/lab/bare.txt && cmp -s "$folder/disk.txt" examples/lab/disk.txt
ok "the sample recordings are what scripts/make-recordings makes" $?

# From anywhere, and writing nowhere else.
top=$PWD
program=$(realpath "$hooke")
mkdir "$folder/elsewhere"
for example in examples/*.hk examples/*/*.hk; do
    [ -f "$example" ] || continue
    said=$(cd "$folder/elsewhere" && "$program" --batch --safe "$top/$example" 2>&1)
    status=$?
    if [ "$status" -ne 0 ] && grep -q 'built without cairo' <<<"$said"; then
        n=$((n + 1)); echo "ok $n - $example runs # SKIP built without cairo"
    else
        ok "$example runs" "$status" "$(tail -5 <<<"$said")"
    fi
done

# Examples of the help: each pair of lines is pasted into a session that has a recording, a fit and a run.
cp examples/lab/bare.txt examples/lab/disk.txt examples/typed/pulse.ode "$folder"
cd "$folder" || exit 2
mkdir -p examples/lab && cp bare.txt disk.txt examples/lab/
failed=
names=$("$program" --format json -c 'list commands' | sed -E 's/^\{"kind":"command","name":"([^"]*)".*/\1/')
for name in $names; do
    case $name in panes | plain | collect | calibrate | zero) continue ;; esac # refused without a terminal, a sensor
    "$program" -c "help $name" | sed -n '/^examples:/,/^see also/p' | sed -n 's/^  //p' >"$name.hk"
    [ -s "$name.hk" ] || { failed+="$name has no examples"$'\n'; continue; }
    if ! said=$("$program" --batch -k -c 'load examples/lab/bare.txt; m = 200 g; fit damped; method rk4 dt=10ms; run 10 s; run 10 s; checkpoint start' "$name.hk" 2>&1 >/dev/null); then
        failed+="$name: $(grep -m2 error <<<"$said" | tr '\n' ' ')"$'\n'
    fi
done
cd "$top" || exit 2
[ -z "$failed" ]
ok "the examples of every command's help run" $? "$failed"

echo "1..$n"
exit "$bad"
