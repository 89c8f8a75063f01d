#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# hooke --check DIR: a hand-in that is what its session gives, and ones that were changed.
set -u
hooke=$PWD/${HOOKE:-build/hooke} examples=$PWD/examples/lab
n=0 bad=0
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
ok() { # name status
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else echo "not ok $n - $1"; sed 's/^/# /' out; bad=1; fi
}
# checks DIR STATUS [PATTERN]: that status, and a line like that
checks() {
    "$hooke" -n --check "$1" >out 2>&1
    local status=$?
    [ $status -eq "$2" ] && { [ $# -lt 3 ] || grep -q -- "$3" out; }
}
changed() { # a fresh copy of the hand-in
    rm -rf bad
    cp -r good bad
}

cp "$examples/bare.txt" .
"$hooke" -n -c 'load bare.txt; m = 200.0(1) g; measure period; measure amplitude; fit damped; measure k
    adopt amplitude; gamma = 0; method euler dt=10ms; run 5 s; plot position; compare euler symplectic-euler; report good' >out 2>&1
ok "a hand-in" $?
ls -R >before
checks good 0 'all agree with session.hk'
ok "as it was written it agrees" $?
ls -R | cmp -s - before
ok "nothing is written" $?
changed
sed -i '0,/^Answer:/s//Answer: 0.7 s, since 2 pi sqrt(m\/k) is that./; s/^Name:/Name: N. N./' bad/report.md
checks bad 0
ok "answers change nothing" $?
changed
awk -F, -v OFS=, '/^period,/ && !done {$2 += 0.001; done = 1} {print}' good/values.csv >bad/values.csv
checks bad 1 'values.csv: a value: period of data bare (measured): the folder has 0.7241.*the session gives 0.7231' && [ "$(grep -c differs out)" -eq 1 ]
ok "a value" $?
awk -F, -v OFS=, '/^period,/ && !done {$2 += $3 / 2; done = 1} {print}' good/values.csv >bad/values.csv
checks bad 0
ok "a value within its uncertainty agrees" $?
awk -F, -v OFS=, '/^period,/ && !done {$3 /= 3; done = 1} {print}' good/values.csv >bad/values.csv
checks bad 1 'values.csv: a value: period'
ok "an uncertainty that is too small" $?
sed '/^amplitude,/d' good/values.csv >bad/values.csv
checks bad 1 'values.csv: it lacks: amplitude of data bare'
ok "a value that is not there" $?
sed 's/^amplitude,/width,/' good/values.csv >bad/values.csv
checks bad 1 'values.csv: the session does not give: width of data bare'
ok "a value of its own" $?
echo 'no table' >bad/values.csv
checks bad 1 'values.csv: it is not a table of values'
ok "no table" $?
changed
line=$(grep -n '^| period T' bad/report.md | head -1)
sed -i "${line%%:*}s/0\.723/0.733/" bad/report.md
checks bad 1 'report.md: this line is missing: | period T'
ok "a number in the report" $?
changed
figure=$(cd good && ls figure-*.svg | head -1) other=$(cd good && ls figure-*.svg | tail -1)
cp "good/$other" "bad/$figure"
checks bad 1 "$figure: the session gives a different figure" && [ "$(grep -c differs out)" -eq 1 ]
ok "a figure" $?
rm "bad/$figure"
checks bad 1 "$figure: it is missing"
ok "no figure" $?
changed
awk -F, -v OFS=, 'NR == 100 {$2 += 1e-6} {print}' good/recording-1.csv >bad/recording-1.csv
checks bad 1 'recording-1.csv: the session gives different data: y of row 9[0-9] is .*, the session gives '
ok "data" $?
changed
sed -i 's/dt=10ms/dt=20ms/' bad/session.hk
checks bad 1 'values.csv: a value: energy at the end of run 1'
ok "the session" $?
changed
sed -i 's/^fit damped/fit dampd/' bad/session.hk
checks bad 1 'session.hk: the session ends in an error'
ok "a session with an error" $?
changed
printf 'run 1 s\nplot position > evil.svg\nexport evil.csv\nrecord evil.hk\nreport evil\nsave evil.hk\nset format json\nquit\nrun 2 s\n' >>bad/session.hk
checks bad 1
! ls evil* >/dev/null 2>&1
ok "one that writes writes nothing" $?
changed
rm bad/session.hk
checks bad 2 'session.hk: it is missing'
ok "no session: exit status 2" $?
checks nowhere 2
ok "no folder: exit status 2" $?
(mkdir away && cd away && "$hooke" -n --check ../good >../out 2>&1)
[ $? -eq 0 ] && grep -q '^the file of bare was not found; recording-1-bare.txt was used instead' out && grep -q 'all agree' out
ok "where the recording is not, its copy in the hand-in is taken" $?
cmp -s bare.txt good/recording-1-bare.txt
ok "which is the file itself" $?
head -400 bare.txt >away/bare.txt
(cd away && "$hooke" -n --check ../good >../out 2>&1)
[ $? -eq 0 ] && grep -q '^the file of bare has other content here; recording-1-bare.txt was used instead' out && grep -q 'all agree' out
ok "also where another file has its name" $?
rm away/bare.txt
changed
sed -i '100s/[1-9]/0/' bad/recording-1-bare.txt
checks bad 1
ok "a copy that was changed" $?
changed
rm bad/recording-1-bare.txt
(cd away && "$hooke" -n --check ../bad >../out 2>&1)
[ $? -eq 0 ] && grep -q '^the file of bare was not found; recording-1.csv was used instead' out && grep -q 'all agree' out
ok "without a copy its export is taken" $?
checks bad 0 'all agree'
ok "as reports of earlier versions have none" $?
"$hooke" -n -q -c 'load bare.txt; m = 200.0(1) g; measure period; data window 4:9; measure period; data clean; measure amplitude; fit damped
    adopt; method rk4; run; report narrow' >out 2>&1
(cd away && "$hooke" -n --check ../narrow >../out 2>&1)
[ $? -eq 0 ] && grep -q '^the file of bare was not found; recording-1-bare.txt was used instead' out && grep -q 'all agree' out
ok "also where the session looked at wider windows before" $?
changed
rm bad/recording-1.csv
(cd away && "$hooke" -n --check ../bad >../out 2>&1)
[ $? -eq 1 ] && grep -q 'session.hk: the session ends in an error: .*bare.txt' out
ok "where it has none it says so" $?
changed
awk -F, -v OFS=, '/^[0-9]/ {$1 *= 1.01} {print}' good/recording-1.csv >bad/recording-1.csv
rm bad/recording-1-bare.txt
(cd away && "$hooke" -n --check ../bad >../out 2>&1)
[ $? -eq 1 ] && grep -q 'values.csv: a value: period of data bare' out
ok "one that was changed gives other values" $?
cp bare.txt good && (cd away && "$hooke" -n --check ../good >../out 2>&1)
ok "a recording beside session.hk is found" $?
changed
cp "good/$other" "bad/$figure"
"$hooke" -n --format json --check bad >out
[ $? -eq 1 ] && python3 -c 'import json, sys
[r] = [json.loads(line) for line in open("out")]
[d] = r["differences"]
sys.exit(not (r["kind"] == "check" and r["agrees"] is False and d["file"] == sys.argv[1] and r["values"] > 20))' "$figure"
ok "as JSON" $?

# ---- each file has to be there, and each folder is checked ----
changed
rm bad/report.md
checks bad 1 'report.md: it is missing'
ok "no report.md" $?
mkdir bad/report.md
checks bad 1 'report.md: it is a folder'
ok "a folder instead of report.md" $?
rmdir bad/report.md && mkfifo bad/report.md
checks bad 1 'report.md: it is not a file'
ok "a pipe instead of report.md" $?
sleep 20 >bad/report.md & writer=$!
(ulimit -t 5; exec timeout 15 "$hooke" -n --check bad >out 2>&1)
[ $? -eq 1 ] && grep -q 'report.md: it is not a file' out
ok "a pipe that somebody holds open keeps nobody waiting" $?
kill $writer; wait $writer 2>/dev/null
"$hooke" -n --check good ./good/ >out 2>&1 && ! grep -q 'its report is the same as that of' out
ok "a folder that is given twice is no copy of itself" $?
changed
sed -i 's/$/\r/' bad/report.md
"$hooke" -n --check good bad >out 2>&1
grep -q 'its report is the same as that of good' out
ok "a copy with other line ends is named" $?
changed
echo >>bad/figure-01-position.txt; for figure in bad/figure-*.svg; do echo >>"$figure"; break; done
"$hooke" -n --format csv --check bad >out 2>&1
python3 -c 'import csv
row = [r for r in csv.DictReader(line for line in open("out") if "," in line)][-1]
raise SystemExit(int(row["figures"]) - int(row["figures_agree"]) != 1)'
ok "a figure and its text are one figure" $?
changed
rm bad/report.html
"$hooke" -n --check good bad >out 2>&1
[ $? -eq 1 ] && grep -q '^good: .*: all agree' out && grep -q '^bad: .*: 1 difference' out
ok "two folders: each is checked" $?
"$hooke" -n --format json --check good good >out 2>&1 && [ "$(grep -c '"kind":"check"' out)" -eq 2 ]
ok "a record of each" $?
changed
sed -i 's/data:image/data: image/' bad/report.html
checks bad 1 'report.html: this line is missing' && ! grep -q '.\{300\}' out
ok "a long line is quoted in part" $?

# ---- a class ----
mkdir class
for name in a b c d e; do cp -r good class/$name; done
sed -i 's/^Name:/Name: B. Bee/; 0,/^Answer:/s//Answer: F = -k y/' class/b/report.md
rm class/c/report.html
rm class/d/session.hk && mkfifo class/d/session.hk
sed -i 's/^# Num/# My num/' class/e/report.md
sed -i 's/<div class="answer"><\/div>/<div class="answer">written<\/div>/' class/e/report.html
awk -F, -v OFS=, '/^period,/ {$2 += 0.001} {print}' good/values.csv >class/e/values.csv
"$hooke" -n --check class/*/ >out 2>&1
[ $? -eq 3 ] && grep -q '^5 hand-ins: 2 agree, 3 differ' out && [ "$(grep -c '^class/.: [0-9]* values' out)" -eq 5 ]
ok "a class: each folder is checked, the status says how many differ" $?
grep -q '^class/a: 10 answers are empty: Q1 Q3 .*Q10$' out && grep -q '^class/b: 9 answers are empty: Q3 ' out && ! grep -q '^class/e:.*empty' out
ok "empty answers are named" $?
grep -q '^class/b: apart from name and answers its report is the same as that of class/a' out && ! grep -q '^class/e: apart from' out
ok "a copy is named, under another name, too" $?
"$hooke" -n --format csv --check class/*/ >out 2>&1
python3 -c 'import csv, sys
rows = {r["folder"]: r for r in csv.DictReader(line for line in open("out") if "," in line and not line.startswith(("error", " ")))}
a, b, c, d, e = (rows["class/" + x] for x in "abcde")
ok = b["name"] == "B. Bee" and b["copy"] == "class/a" and b["answers"] == "1" and a["agrees"] == "true" and a["values"] == a["values_right"]
ok &= c["agrees"] == "false" and c["complete"] == "false" and d["agrees"] == "false" and e["complete"] == "true" and int(e["values"]) - int(e["values_right"]) == 2
sys.exit(not ok)'
ok "a class as CSV: a row for each" $?
changed
: >big && truncate -s 300M big && mv big bad/report.html
checks bad 1 'report.html: it cannot be read'
ok "a file that is too large" $?

# ---- where answers are written ----
changed
awk '{print} /Q3\./ {q = 3} q == 3 && /^Answer:/ {print ""; print "## My reasons"; print ""; print "It grows at every step."; q = 0}' good/report.md >bad/report.md
checks bad 0 '9 answers are empty: Q1 Q2 Q4'
ok "an answer under a heading of one's own" $?
awk '/Q3\./ {print; print ""; print "It grows at every step."; next} {print}' good/report.md >bad/report.md
checks bad 0 '9 answers are empty: Q1 Q2 Q4'
ok "an answer above the line for it" $?
awk '/Q3\./ {q = 1} q && /^Answer:/ {print "It grows."; q = 0; next} {print}' good/report.md >bad/report.md
checks bad 0 '9 answers are empty: Q1 Q2 Q4'
ok "an answer in place of the line for it" $?
awk '{print} /Q3\./ {q = 1} q && /^### / && !/Q3\./ {print ""; print "It grows."; q = 0}' good/report.md >bad/report.md
checks bad 0 '9 answers are empty: Q1 Q2 Q4'
ok "an answer below the next heading of the report" $?
(cd away && rm -f ../bad/recording-1-bare.txt && cp ../good/report.md ../bad/ && "$hooke" -n --check ../bad >../out 2>&1); grep -q '10 answers are empty' out
ok "the description of a recording from the folder is no answer" $?

# ---- the status ----
"$hooke" -n --check good bad nowhere good >out 2>&1
[ $? -eq 1 ] && "$hooke" -n --help | grep -q 'status: the number of hand-ins that differ, at most 125'
ok "the help says that the status is a number" $?
"$hooke" -n --check $(printf 'nowhere %.0s' $(seq 130)) >out 2>&1
[ $? -eq 125 ] && grep -q '^130 hand-ins: 0 agree, 130 differ' out
ok "130 that differ: 125, above which shells tell of signals" $?
"$hooke" -n --check $(printf 'nowhere %.0s' $(seq 124)) good >out 2>&1
[ $? -eq 124 ]
ok "124 that differ" $?

# ---- honest hand-ins, away from their recordings: units, digits, zeros ----
honest=8
[ "${LONG:-}" ] && honest=100
python3 - <<END
import math, random
kinds = [("cm", 3, 21.3), ("cm", 1, 40.0), ("mm", 0, 300), ("mm", 2, -12.5), ("m", 4, 0.213), ("m", 17, 0.213), ("in", 3, 8.4), ("cm", 15, 30)]
for i in range($honest):
    r = random.Random(i)
    unit, digits, offset = kinds[i % len(kinds)]
    amplitude, omega, gamma = offset * r.uniform(0.1, 0.3), r.uniform(5, 12), r.uniform(0.01, 0.3)
    with open(f"made-{i}.txt", "w") as out:
        out.write(f"Time (s)\tDistance ({unit})\n")
        for k in range(500):
            t = 0.02 * k + (r.gauss(0, 0.001) if i % 3 == 1 else 0)
            y = offset + amplitude * math.exp(-gamma * t / 2) * math.cos(omega * t) + r.gauss(0, 0.01 * abs(amplitude))
            if i % 2 and r.random() < 0.02: # as sensors send that see nothing
                y = 20 * offset
            out.write(f"{t:.{3 if i % 3 else 2}f}\t{y:.{digits}f}\n")
END
wrong=0
for i in $(seq 0 $((honest - 1))); do
    "$hooke" -n -q -c "load made-$i.txt; m = 200.0(1) g; measure period; fit damped; measure k; adopt; method rk4 dt=10ms; run 5 s
        plot position; report honest-$i" >>made.out 2>&1 || { wrong=$((wrong + 1)); continue; }
    (cd away && "$hooke" -n --check "../honest-$i" >../out 2>&1) || { wrong=$((wrong + 1)); cat out >>made.out; }
done
mv made.out out
[ $wrong -eq 0 ]
ok "$honest honest hand-ins away from their recordings agree" $?
"$hooke" -n --check honest-* >out 2>&1
ok "in place, too" $?
"$hooke" -n -q -c 'load bare.txt; plot position; report bare-of-values' >out 2>&1 && checks bare-of-values 0 'all agree'
ok "one without a value" $?

# ---- tampering: one number at a time, anywhere in a table ----
wrong=0
for i in $(seq 20); do
    changed
    file=$(cd good && ls recording-1.csv run-*.csv runs.csv values.csv | sed -n "$((i % 4 + 1))p")
    python3 - "good/$file" "bad/$file" "$i" <<'END'
import random, sys
r = random.Random(int(sys.argv[3]))
lines = open(sys.argv[1]).read().splitlines(True)
rows = [k for k, line in enumerate(lines) if line[0] != "#"][1:]
while True:
    k = r.choice(rows)
    cells = lines[k].rstrip("\n").split(",")
    c = r.randrange(len(cells))
    try:
        value = float(cells[c])
    except ValueError:
        continue
    if value != 0 and abs(value) < 1e300:
        break
cells[c] = repr(value * r.choice([1.1, 0.9, -1, 2, 10]))
lines[k] = ",".join(cells) + "\n"
open(sys.argv[2], "w").write("".join(lines))
END
    checks bad 1 "$file: " || { wrong=$((wrong + 1)); diff "good/$file" "bad/$file" >>left; }
done
[ $wrong -eq 0 ] || cat left >>out
[ $wrong -eq 0 ]
ok "20 numbers that were changed are found" $?
echo "1..$n"
exit $bad
