#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A sweep in shards, each killed at random times and started again, gives the bytes of the whole.
set -u
hooke=${HOOKE:-build/hooke}
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; fi; }
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
shards=3 seconds=5
[ -n "${LONG:-}" ] && shards=23 seconds=20
scene="scene driven; method rk4; duration = $seconds s"
sweep='sweep omega=5:12:0.05 gamma=0.1:2:0.05 measure=amplitude,period,y'

for format in csv json; do
    "$hooke" --norc --quiet --format $format -c "$scene; $sweep" >"$folder/whole.$format"
    ok "the whole as $format" $?
    killed=0
    for shard in $(seq $shards); do
        # Killed after a random time, until it was fast enough; what is there then is thrown away, as a scheduler would.
        for try in $(seq 20); do
            "$hooke" --norc --quiet --format $format -c "$scene; $sweep --shard $shard/$shards --threads $((1 + try % 3))" \
                >"$folder/part.$shard" &
            process=$!
            sleep "0.00$((RANDOM % 9))"
            [ "$try" -lt 3 ] && kill -9 $process 2>/dev/null
            if wait $process 2>/dev/null; then break; else killed=$((killed + 1)); fi
        done
    done
    for shard in $(seq $shards); do cat "$folder/part.$shard"; done | cmp - "$folder/whole.$format"
    ok "$shards shards put together are the whole ($format, $killed killed on the way)" $?
    [ "$killed" -gt 0 ]
    ok "some were killed" $?
done
[ "$(grep -c '"kind":"sweep"' "$folder/whole.json")" -eq 5499 ]
ok "every point is there" $?

"$hooke" --norc --quiet --format csv -c "$scene; $sweep --threads 1" | cmp - "$folder/whole.csv"
ok "one thread: the same bytes" $?

# Ctrl-C: what is finished is kept, and said.
interrupted() { # seconds: a slow machine has not begun after one
    timeout -s INT "$1" "$hooke" --norc -c "$scene; dt = 0.1 ms; sweep k=1:20:0.00001 measure=y --force" >"$folder/out" 2>"$folder/err"
    [ $? -ne 0 ] && grep -q 'of 1900001 points finished' "$folder/err" && grep -q 'of 1900001 points in' "$folder/out"
}
interrupted 1 || interrupted 5 || interrupted 25
ok "interrupted: the finished points are kept" $?
echo "1..$n"
exit $bad
