#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Sweeps into files: killed at random times and gone on with, put together from shards, damaged, no room: the bytes of
# an uninterrupted one, or a clear error and nothing lost.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; sed 's/^/# /' err 2>/dev/null | head -5; fi; }
folder=$(mktemp -d) || exit 2
trap 'cd /; chmod -R u+w "$folder"; rm -rf "$folder"' EXIT
cd "$folder" || exit 2
tries=4
[ -n "${LONG:-}" ] && tries=100
scene='scene driven; method rk4; duration = 2 s'
sweep='sweep omega=5:12:0.1 gamma=0.1:2:0.1 measure=amplitude,period,y'
run() { "$hooke" -n -q -c "$1" >out 2>err; }
# refused FILE PATTERN STATUS STATEMENT: with that message, and the file as it was.
refused() {
    cp "$1" before
    run "$4"
    [ $? -eq "$3" ] && grep -q "$2" err && cmp -s "$1" before
}

run "$scene; $sweep --resume whole.csv"
ok "a sweep into a file" $?
"$hooke" -n -q --format csv -c "$scene; $sweep" | sed '1d; s/^sweep,//' >rows
sed '/^#/d; /^point/d' whole.csv | cmp -s - rows
ok "its rows are those of the sweep that is printed" $?
seal='^# sweep [0-9a-f]\{16\}: 1420 points in all, at most 1 row each$'
tail -n 1 whole.csv | grep -q "$seal"
ok "the last line says that it is whole" $?
"$hooke" --check-sweep whole.csv | grep -q '1420 points of 1420: complete'
ok "--check-sweep says so, too" $?

# kill_often WHOLE TIMES: how long it takes here decides when it is killed, earlier each time; three
# threads or one.
kill_often() {
    killed=0 wrong=0
    start=$(date +%s%N)
    run "$scene; $sweep --resume timed.csv"
    took=$(($(date +%s%N) - start))
    rm -f timed.csv
    for try in $(seq "$2"); do
        rm -f part.csv
        for again in $(seq 40); do
            "$hooke" -n -q -c "$scene; $sweep --threads $((1 + try % 3)) --resume part.csv" >/dev/null 2>&1 &
            process=$!
            if [ "$again" -lt 4 ]; then
                sleep "$(awk -v r="$((RANDOM % 1000))" -v t="$took" -v a="$again" 'BEGIN {printf "%.4f", r / 1400 * t / a / a / 1e9}')"
                kill -9 $process 2>/dev/null
            fi
            if wait $process 2>/dev/null; then break; else killed=$((killed + 1)); fi
        done
        cmp -s part.csv "$1" || wrong=$((wrong + 1))
    done
    [ "$wrong" -eq 0 ]
    ok "killed and gone on with, the bytes are the same ($2 files, killed $killed times)" $?
}
kill_often whole.csv "$tries"
[ "$killed" -gt 0 ]
ok "they were killed" $?

# Any torn end: the file as it was in the middle, cut at any byte.
(ulimit -f 40 && trap '' XFSZ && exec "$hooke" -n -q -c "$scene; $sweep --resume some.csv") >out 2>err
wrong=0
for cut in 0 1 20 100 150 $(seq 207 3989 $(stat -c %s some.csv) | head -n $((tries * 5))); do
    head -c "$cut" some.csv >cut.csv
    run "$scene; $sweep --resume cut.csv" && cmp -s cut.csv whole.csv || wrong=$((wrong + 1))
done
[ "$wrong" -eq 0 ]
ok "cut anywhere, it is gone on with" $?

for shard in 1 2 3 4 5; do run "$scene; $sweep --shard $shard/5 --resume shard.$shard.csv" || break; done
cat shard.?.csv | cmp -s - whole.csv
ok "shards one after another (cat) are the whole, byte for byte" $?
tail -n 1 shard.3.csv | grep -q "$seal"
ok "the last line of a shard says that it is whole, too" $?
cat shard.[45].csv shard.[213].csv >merged.csv
"$hooke" --check-sweep merged.csv | grep -q '1 file, 1420 points of 1420: complete' && run "$scene; $sweep --resume merged.csv" && cmp -s merged.csv whole.csv
ok "in another order they have all points, and become it" $?
"$hooke" --check-sweep shard.5.csv shard.[1-4].csv >out && grep -q '5 files, 1420 points of 1420: complete' out
ok "each for itself, together they are checked" $?
cat shard.5.csv shard.2.csv >some.csv
"$hooke" --check-sweep some.csv >out
[ $? -eq 1 ] && grep -q 'points 0 to 285 are missing' out && grep -q 'points 572 to 1143 are missing' out
ok "shards that are missing are told" $?
run "$scene; $sweep --resume some.csv" && cmp -s some.csv whole.csv
ok "and computed" $?
cat shard.1.csv shard.2.csv shard.2.csv >twice.csv
"$hooke" --check-sweep twice.csv >out
[ $? -eq 1 ] && grep -q 'points 286 to 571 are present more than once' out
ok "a shard that is there twice is told" $?
refused twice.csv 'has point 286 twice' 4 "$scene; $sweep --resume twice.csv"
ok "and refused" $?
refused shard.2.csv 'has point 286 or later points that do not belong to this shard' 4 "$scene; $sweep --shard 3/5 --resume shard.2.csv"
ok "a shard is not taken for another one" $?
refused shard.2.csv 'belongs to another sweep, or to this sweep with another set-up' 4 "$scene; gamma = 1; $sweep --shard 2/5 --resume shard.2.csv"
ok "nor for that of another set-up" $?
refused shard.2.csv 'does not name the sweep that it belongs to' 4 "$scene; sweep --resume shard.2.csv"
ok "which sweep it is of, the first shard says" $?
# One that is not whole has its head. The limit of a process stands for a disk that is full.
(ulimit -f 10 && trap '' XFSZ && exec "$hooke" -n -q -c "$scene; $sweep --shard 3/5 --resume alone.csv") >out 2>err
refused alone.csv 'is shard 3/5 of this sweep, not 1/1' 4 "$scene; $sweep --resume alone.csv"
ok "until it is whole a shard is not taken for the whole" $?
run "$scene; sweep --resume alone.csv" && cmp -s alone.csv shard.3.csv
ok "and says itself which sweep and which shard it is" $?
before=$(stat -c '%i %Y' whole.csv)
run "$scene; $sweep --resume whole.csv" && [ "$(stat -c '%i %Y' whole.csv)" = "$before" ]
ok "what is whole is left alone" $?

refused whole.csv "belongs to another sweep: it has 'set-up = method rk4', but this is 'set-up = gamma = 1 1/s'" 4 "scene driven; gamma = 1; method rk4; duration = 2 s; sweep --resume whole.csv"
ok "another set-up is refused" $?
refused whole.csv 'belongs to another sweep' 4 "$scene; sweep omega=5:12:0.05 gamma=0.1:2:0.2 --resume whole.csv"
ok "other ranges are refused" $?
sed 's/duration 2 s/duration 3 s/' whole.csv >edited.csv
"$hooke" --check-sweep edited.csv >out 2>err
[ $? -eq 4 ]
ok "a changed head is noticed" $?
sed '1000d;1100,1110d' whole.csv >edited.csv
"$hooke" --check-sweep edited.csv >out
[ $? -eq 1 ] && grep -q 'point [0-9]* is missing' out && run "$scene; $sweep --resume edited.csv" && cmp -s edited.csv whole.csv
ok "rows that are missing are told, and computed" $?
sed '1000{p}' whole.csv >edited.csv
refused edited.csv 'a point above appears twice' 4 "$scene; $sweep --resume edited.csv"
ok "a row that is there twice is noticed" $?
cp whole.csv edited.csv && "$hooke" -n -q -c "$scene; gamma = 1; $sweep --shard 5/5 --resume other.csv" && cat other.csv >>edited.csv
refused edited.csv 'this belongs to another sweep than the lines before' 4 "$scene; $sweep --resume edited.csv"
"$hooke" --check-sweep shard.[1-4].csv other.csv >out 2>err
[ $? -eq 4 ] && grep -q 'other.csv, line [0-9]*: this belongs to another sweep' err
ok "shards of two sweeps are told apart" $?
head -c 3000 whole.csv >torn.csv && dd if=/dev/zero bs=100 count=1 2>/dev/null >>torn.csv
run "$scene; $sweep --resume torn.csv" && cmp -s torn.csv whole.csv
ok "zeros at the end, as after a loss of power, are cut" $?
printf 'my notes\n' >notes.csv
refused notes.csv 'line 1: this is not a row of a sweep' 4 "$scene; $sweep --resume notes.csv"
ok "another file is left as it is" $?
head -n 300 whole.csv >torn.csv && echo 'and a remark' >>torn.csv
refused torn.csv 'this is not a row of a sweep' 4 "$scene; $sweep --resume torn.csv"
ok "what somebody wrote at the end of an unfinished one is not lost" $?
printf '' >empty.csv
refused empty.csv 'does not name the sweep that it belongs to' 4 "$scene; sweep --resume empty.csv"
ok "an empty file without ranges" $?
run "$scene; sweep --resume none.csv"
[ $? -eq 4 ] && [ ! -e none.csv ]
ok "no file and no ranges" $?
ln -s whole.csv link.csv
run "$scene; $sweep --resume link.csv"
[ $? -eq 4 ] && grep -q 'symbolic link' err
ok "a link is refused" $?
sed -i '$d' shard.1.csv && flock shard.1.csv "$hooke" -n -q -c "$scene; $sweep --shard 1/5 --resume shard.1.csv" 2>err
[ $? -eq 4 ] && grep -q 'being written by another program' err
ok "two programs do not write one file" $?

# No room: what fits is kept, and the error says so. The limit of a process stands for a disk that is full.
(ulimit -f 60 && trap '' XFSZ && exec "$hooke" -n -q -c "$scene; $sweep --resume full.csv") >out 2>err
[ $? -eq 4 ] && grep -q 'cannot write full.csv' err
ok "no room: told" $?
run "$scene; $sweep --resume full.csv" && cmp -s full.csv whole.csv
ok "with room it goes on" $?
mkdir locked && cp whole.csv locked && sed -i '$d' locked/whole.csv && cp locked/whole.csv before && chmod a-w locked
if [ -w locked ]; then
    n=$((n + 1)) && echo "ok $n - a folder that cannot be written # SKIP this user may write everywhere"
else
    refused locked/whole.csv 'cannot write' 4 "$scene; $sweep --resume locked/whole.csv"
    ok "a folder that cannot be written" $?
fi
run "$scene; $sweep --resume /proc/sweep.csv"
[ $? -eq 4 ] && grep -q 'cannot write /proc/sweep.csv' err
ok "a place where there are no files" $?
(mkdir inside && cd inside && "$hooke" -n -q --safe -c "$scene; $sweep --resume ../outside.csv" >../out 2>../err)
[ $? -eq 4 ] && [ ! -e outside.csv ]
ok "--safe keeps it in the folder" $?

# Orbit diagrams: a point has as many rows as events.
scene='scene pendulum-driven; method rk4; dt = 50 ms; event top when v falling do record'
for sweep in 'sweep F0=1:1.1:0.01 at period skip=20 keep=15' 'sweep F0=1:1.1:0.01 at v = 0 falling skip=5 keep=7 measure=theta,energy' 'sweep F0=0:1.1:0.1 at top skip=9 keep=9 --threads 1'; do
    rm -f whole.csv part.csv shard.?.csv
    run "$scene; $sweep --resume whole.csv" && "$hooke" -n -q --format csv -c "$scene; $sweep" | sed '1d; s/^sweep,//' >rows && sed '/^#/d; /^point/d' whole.csv | cmp -s - rows
    ok "${sweep#sweep }: its rows are those that are printed" $?
    for shard in 1 2 3; do run "$scene; $sweep --shard $shard/3 --resume shard.$shard.csv" || break; done
    cat shard.?.csv | cmp -s - whole.csv && "$hooke" --check-sweep shard.?.csv | grep -q ' of 1[12]: complete, each'
    ok "shards one after another are the whole" $?
    (ulimit -f 4 && trap '' XFSZ && exec "$hooke" -n -q -c "$scene; $sweep --resume part.csv") >out 2>err
    [ -s part.csv ] && ! cmp -s part.csv whole.csv && run "$scene; sweep --resume part.csv" && cmp -s part.csv whole.csv
    ok "cut short it is gone on with, by what the file says" $?
    wrong=0
    for cut in $(seq 150 1999 $(stat -c %s whole.csv) | head -n $((tries * 2))); do
        head -c "$cut" whole.csv >part.csv && run "$scene; $sweep --resume part.csv" && cmp -s part.csv whole.csv || wrong=$((wrong + 1))
    done
    [ "$wrong" -eq 0 ]
    ok "cut anywhere" $?
done
sweep='sweep F0=1:1.1:0.001 at period skip=20 keep=100'
rm whole.csv && run "$scene; $sweep --resume whole.csv"
ok "a diagram of 101 values" $?
kill_often whole.csv $((tries > 4 ? tries : 1))

# Ctrl-C: what is finished is in the file.
scene='scene driven; method rk4; duration = 2 s'
sweep='sweep omega=5:12:0.1 gamma=0.1:2:0.1 measure=amplitude,period,y'
interrupted() { # seconds: a slow machine has not begun after one
    rm -f long.csv
    timeout -s INT "$1" "$hooke" -n -c "$scene; dt = 0.1 ms; sweep k=1:20:0.001 gamma=0:1:0.01 --resume long.csv --force" >out 2>err
    [ $? -ne 0 ] && grep -q 'stopped: long.csv has [0-9]* of 1919101 points' err && tail -n 1 long.csv | grep -q '^[0-9]*,.*,ok$'
}
interrupted 1 || interrupted 5 || interrupted 25
ok "interrupted: the finished points are in the file" $?

"$hooke" -n --format json -q -c "$scene; $sweep --shard 2/4 --dry-run" >out 2>err &&
    python3 - out <<'END'
import json, sys
cost = json.loads(open(sys.argv[1]).read())
assert cost["kind"] == "sweep-cost" and cost["points"] == 363 and cost["total"] == 1420, cost
assert cost["shards"] == 1 and 0 < cost["seconds"] < 60 and 60 < cost["bytes"] / 363 < 100, cost
assert abs(cost["seconds"] * cost["rate"] / 363 - 1) < 1e-9, cost
END
ok "--dry-run measures what a shard costs" $?
run "$scene; $sweep --shard 2/5 --resume fifth.csv"
size=$(stat -c %s fifth.csv)
"$hooke" -n --format csv -q -c "$scene; $sweep --shard 2/5 --dry-run" | awk -F, -v s="$size" 'NR == 2 {exit !($7 / s > 0.97 && $7 / s < 1.03)} NR == 1 && $7 != "bytes" {exit 1}'
ok "its bytes are within 3 % of the file's" $?
echo "1..$n"
exit $bad
