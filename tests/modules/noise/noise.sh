#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The program with noise: its panes, and files that do not depend on the number of threads.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; printf '%s\n' "${3:-}" | tail -25 | sed 's/^/#   /'; fi; }
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2

said=$("$hooke" -n -c 'scene damped; ensemble 100 2 s kT=1mJ; focus ensemble full' -c screenshot 2>&1)
grep -q 'ensemble y \[cm\] .* +- standard deviation' <<<"$said"
ok "a pane has the mean of an ensemble and its band" $? "$said"
said=$("$hooke" -n -c 'scene damped; langevin 2 s kT=1mJ; focus langevin full' -c screenshot 2>&1)
grep -q 'langevin y \[cm\]' <<<"$said"
ok "a pane has a path" $? "$said"
[ "$("$hooke" -n -c 'scene damped; plan' 2>&1 | grep -ciE 'langevin|ensemble|noise')" -eq 0 ]
ok "plan names no noise where none was asked for" $?

for threads in 1 2 5; do
    "$hooke" -n -q -c "scene pendulum; ensemble 77 1 s of energy kT=0.1 gamma=1 rows=5 --threads $threads" \
        -c "export $threads.csv table of ensemble" >/dev/null 2>&1
done
[ -s 1.csv ] && cmp -s 1.csv 2.csv && cmp -s 1.csv 5.csv
ok "the same file with 1, 2 and 5 threads" $? "$(wc -c ./*.csv)"
grep -q '^t.*mean.*sd.*low' 1.csv
ok "it has the statistics as columns" $? "$(head -8 1.csv)"
keys=$(grep -cxE '# (duration = 1 s|kT = 100 mJ|noise_gamma = 1 1/s|seed = 1|method = baoab|dt = 10 ms)' 1.csv)
[ "$keys" -eq 6 ]
ok "and its keys say how it was made" $? "$(head -20 1.csv)"
two="scene new; var x=0; var x'=0; var z=0; var z'=0; x''=-x-x'; z''=-z-2*z'; ensemble 10 1 s kT=1 rows=2"
"$hooke" -n -q -c "$two; export two.csv table of ensemble" >/dev/null 2>&1
keys=$(grep -cxE '# noise_gamma_v(x = 1|z = 2) 1/s' two.csv)
said=$("$hooke" -n --format json -c "$two" 2>&1)
[ "$keys" -eq 2 ] && grep -q '"gamma":\[1,2\],"noise":\[1.414213562373095[0-9]*,2\]' <<<"$said"
ok "dampings that differ are all named" $? "$said"
"$hooke" -n -q -c 'scene pendulum; langevin 1 s kT=0.1 gamma=1 seed=3; export a.csv table of langevin; langevin 1 s kT=0.1 gamma=1 seed=3; export b.csv table of langevin' >/dev/null 2>&1
[ -s a.csv ] && cmp -s a.csv b.csv
ok "the same seed gives the same file" $? "$(wc -c ./*.csv)"
"$hooke" -n -c 'scene pendulum; ensemble 10000 10000 s kT=0.1 gamma=1 --force' >out 2>&1 &
program=$!
# A start takes a hundredth of a second: then it has been computing for long.
until [ "$(awk '{print $14 + $15}' /proc/$program/stat 2>/dev/null || echo 99)" -ge 60 ]; do sleep 0.05; done
kill -INT $program
wait $program
[ $? -eq 130 ] && grep -q 'stopped; no ensemble was kept' out
ok "Ctrl-C ends an ensemble, with status 130" $? "$(cat out)"
echo "1..$n"
exit "$bad"
