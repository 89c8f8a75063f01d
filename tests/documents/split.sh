#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Results for programs: several tables in CSV, on standard output and as files; JSON holds objects only.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
n=0 bad=0
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
ok() { # name status
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else echo "not ok $n - $1"; bad=1; fi
}

work='run 0.02 s; run 0.03 s; compare euler rk4; measure period; export - t,y'
"$hooke" -n --format csv -c "$work" >all.csv 2>/dev/null
ok "exit status" $?
# a reader that takes blank lines as the end of a table and # as comments
awk -F, 'BEGIN {RS = ""} {tables++; n = split($0, line, "\n"); width = 0
    for (i = 1; i <= n; i++) {if (line[i] ~ /^#/) continue; gsub(/"[^"]*"/, "q", line[i]); w = gsub(/,/, ",", line[i]) + 1; if (width && w != width) bad = 1; width = w}}
    END {exit !(tables == 4 && !bad)}' all.csv
ok "four tables, each of one width, a blank line between" $?
[ "$(grep -c '^# \(compare\|measure\|export\)$' all.csv)" -eq 3 ]
ok "a comment says which begins" $?
[ "$(head -c 4 all.csv)" = kind ]
ok "the first one begins at once" $?

"$hooke" -n --format csv --split out -c "$work" >rest 2>err
ok "--split: exit status" $?
[ "$(cd out && echo *)" = "001-run.csv 002-compare.csv 003-measure.csv 004-export.csv" ]
ok "--split: a file a table" $?
[ ! -s rest ]
ok "--split: nothing on standard output" $?
cmp -s <(sed '/^$/d; /^# \(compare\|measure\|export\)$/d' all.csv | sed 's/,[^,]*e-[0-9]*,[^,]*//g' | cut -c1-40) \
    <(cat out/* | sed 's/,[^,]*e-[0-9]*,[^,]*//g' | cut -c1-40)
ok "--split: the same tables" $?
"$hooke" -n --format csv --split out -c "$work" >/dev/null 2>err
[ $? -ne 0 ] && [ "$(ls out | wc -l)" -eq 4 ] && grep -q "out" err
ok "--split: a folder that is there is not touched" $?
(trap '' XFSZ; ulimit -f 1; "$hooke" -n --format csv --split full -c "$work" >/dev/null 2>&1)
[ $? -eq 4 ] && [ -z "$(ls -A | grep full)" ]
ok "--split: nothing is left where there is no room" $?
mkdir inside && (cd inside && "$hooke" -n --safe --format csv --split ../beside -c "$work" >/dev/null 2>&1)
[ $? -ne 0 ] && [ ! -e beside ]
ok "--split: confined by --safe" $?

# every statement of a list, in JSON: objects only, no table as a string
"$hooke" -n --format json -c "$work; export - table of compare; export - table of runs; list methods stiff; order rk4; stability rk4; plan; runs; sweep k=10:20:5 measure=amplitude" >all.json 2>/dev/null
grep -qv '^{.*}$' all.json
[ $? -eq 1 ] && ! grep -q '"kind":"data"' all.json && ! grep -q '\\nt,y\|\\n[0-9.]*,[0-9.]*\\n' all.json
ok "JSON: objects only, no CSV in a string" $?
[ "$(grep -c '^{"kind":"row","t":' all.json)" -eq "$(grep -c '^[0-9.]*,' out/004-export.csv)" ]
ok "JSON: export - gives each row as an object" $?

# a program reads the exit status: -q estimates no errors, and says so
lorenz="var x=1; var y=1; var z=20; x'=10*(y-x); y'=x*(28-z)-y; z'=x*y-8/3*z; method dopri5 tol=1e-6"
status_of() { "$hooke" -n "$@" >out.txt 2>err; echo $?; }
[ "$(status_of -c "$lorenz; run 60 s")" -eq 3 ] && grep -q 'no digit is certain' err
ok "exit status 3: no digit is left of a chaotic run" $?
[ "$(status_of -q -c "$lorenz; run 60 s")" -eq 0 ] && [ ! -s err ]
ok "exit status 0 under -q, which looks for failures alone" $?
[ "$(status_of -q -c "$lorenz; set opinion full; run 60 s")" -eq 3 ] && [ "$(status_of -q --format json -c "$lorenz; run 60 s")" -eq 3 ]
ok "exit status 3 under -q with set opinion full, and of records" $?
"$hooke" --help | grep -q -- "-q, --quiet .*do not estimate errors of runs" && "$hooke" -n -c 'help run' | tr -s '\n ' ' ' | grep -q "Under hooke -q the error of an adaptive run is not estimated"
ok "--help and help run say that -q estimates no error" $?

for statement in "runs" "compare euler rk4" "order rk4" "stability rk4" "precision rk4" "sweep k=10:20:5 measure=amplitude" "measure period" "list methods" "stress euler"; do
    name=$(tr -cd 'a-z' <<<"$statement").csv
    "$hooke" -n -c "run 5 s; $statement > $name" >/dev/null 2>err && [ -s "$name" ]
    ok "$statement > FILE" $?
done
echo "1..$n"
exit "$bad"
