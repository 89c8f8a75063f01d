#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What is found of lines while they come: the last live fit is the fit of the same lines.
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
swing() { # seed rate seconds: time and distance of a damped swing, T = 0.7255 s, with noise of 0.03 cm
    awk -v seed="$1" -v rate="$2" -v s="$3" 'BEGIN { srand(seed); print "time (s),distance (cm)"
        for (i = 0; i < rate * s; i++) { t = i / rate
            noise = 0.03 * sqrt(-2 * log(1 - rand())) * cos(6.283185307 * rand())
            printf "%.4f,%.3f\n", t, 30 + 5 * exp(-0.05 * t) * cos(8.66 * t) + noise } }'
}
quantity() { # key kind file: value and uncertainty
    sed -n "s/.*\"kind\":\"$2\".*\"$1\":{\"value\":\([^,]*\),\"uncertainty\":\([^,]*\),.*/\1 \2/p" "$3" | head -n 1
}
agree() { # of two quantities within the uncertainty of the second
    awk -v a="$1" -v b="$2" 'BEGIN { n = split(a, x, " "); split(b, y, " "); d = x[1] - y[1]
        exit !(n == 2 && y[2] > 0 && d * d <= y[2] * y[2]) }'
}

raw() { grep -v '^#' "$1" | cut -f 2-; }

good=0
rate=200
[ -n "${LONG:-}" ] && rate=1000
for seed in 1 2 3 4 5 6 7 8 9 10; do
    swing $seed $rate 10 | "$hooke" -n --format json -c "m = 200 g; fit damped --live; collect - to=$seed.txt; fit damped" >$seed.json 2>&1
    agree "$(quantity period live-fit $seed.json)" "$(quantity period fit $seed.json)" &&
        agree "$(quantity k live-fit $seed.json)" "$(quantity k fit $seed.json)" && good=$((good + 1))
done
[ $good -eq 10 ]
ok "10 seeds: T and k of the live fit within the uncertainty of the fit of the same lines after 10 s" $? "$good agree; $(cat 1.json)"
"$hooke" -n --format json -c "m = 200 g; load 3.txt; fit damped" >loaded.json 2>&1
[ "$(quantity period fit 3.json)" = "$(quantity period fit loaded.json)" ]
ok "and load and fit say the same" $? "$(cat loaded.json)"
swing 1 1000 40 | "$hooke" -n --format json -c "fit damped --live; collect - to=long.txt; fit damped" >long.json 2>&1
live=$(quantity period live-fit long.json)
awk -v a="$live" -v b="$(quantity period fit long.json)" 'BEGIN { split(a, x, " "); split(b, y, " "); d = (x[1] - y[1]) / x[2]
    exit !(x[2] > 0 && d * d < 9 && x[2] < 3 * y[2]) }'
ok "40000 lines are thinned, and its uncertainty knows" $? "$(cat long.json)"
{ swing 1 100 8 | head -n 60; sleep 0.4; swing 1 100 8 | tail -n +61; sleep 0.4; } | # all of it is read before it ends
    "$hooke" -n --format json -c "fit damped --live; collect - to=late.txt; fit damped" >late.json 2>&1
[ -n "$(quantity period fit late.json)" ] && [ "$(quantity period live-fit late.json)" = "$(quantity period fit late.json)" ]
ok "the last live fit is of the last lines, also where they came in the second after another" $? "$(cat late.json)"
swing 1 100 0.5 | "$hooke" -n -c "fit damped --live; collect - to=early.txt" >early.out 2>&1
grep -q '^live fit to t = 0.49 s: not determined$' early.out
ok "half a second determines nothing" $? "$(cat early.out)"
awk 'BEGIN { for (i = 0; i < 1000; i++) printf "21:59:%07.4f;%.3f\n", 50 + i / 200, 30 + 5 * cos(8.66 * i / 200) }' |
    "$hooke" -n --format json -c "fit damped --live; collect - to=clock.txt; fit damped" >clock.json 2>&1
agree "$(quantity period live-fit clock.json)" "$(quantity period fit clock.json)"
ok "so it is where the clock tells the time of day" $? "$(cat clock.json)"
"$hooke" -n -c 'fit sine --live' >out.txt 2>&1
[ $? -eq 1 ] && grep -q 'works only with a damped sine' out.txt
ok "--live works only with a damped sine only" $? "$(cat out.txt)"
"$hooke" -n -c 'fit --live window=0:3' >out.txt 2>&1
[ $? -eq 1 ] && grep -q 'cannot have other arguments' out.txt
ok "and all of it" $? "$(cat out.txt)"
# ---- calibrated
held() { awk 'BEGIN { srand(3); print "time (s),distance (cm)"; for (i = 0; i < 500; i++) { t = i / 50
    printf "%.3f,%.3f\n", t, (t < 4 ? 19.6 : t < 5 ? 19.6 + 19.5 * (t - 4) : 39.1) + 0.02 * (rand() - 0.5) } }'; }
held | "$hooke" -n -c 'collect - to=raw.txt; calibrate y 20 cm 40 cm at=0.5:3.5,6:9' >cal.out 2>&1
grep -q '^y: a reading of 19.6.* cm means 20 cm, and 39.1.* cm means 40 cm; 1.0256.* cm for each cm$' cal.out
ok "two windows of a recording are its two points" $? "$(cat cal.out)"
held | "$hooke" -n -c 'calibrate y 19.6 cm 20 cm 39.1 cm 40 cm; collect - to=true.txt; zero; save set.hk' >true.out 2>&1
grep -q '^calibrated: 19.6 cm 20 cm 39.1 cm 40 cm' true.out && grep -q '^# calibration: 19.6 cm 20 cm 39.1 cm 40 cm$' true.txt
ok "what is collected later is true, and its file says how" $? "$(cat true.out)"
[ "$(raw true.txt | sed -n 2p)" = "$(held | sed -n 2p)" ]
ok "its lines are as they came" $?
grep -q '^calibrate y 19.6 cm -' set.hk
ok "zero shifts it, and what is saved has it" $? "$(cat set.hk)"
"$hooke" -n -c 'load true.txt' >loaded.out 2>&1
grep -q '^calibrated: 19.6 cm 20 cm' loaded.out
ok "load knows it" $? "$(cat loaded.out)"
awk 'BEGIN { for (i = 0; i < 200; i++) printf "%.2f,%d\n", i / 100, 512 + (i % 2) * 318 }' |
    "$hooke" -n --format json -c 'calibrate y 512 20 cm 830 40 cm; collect - to=counts.txt' >counts.json 2>&1
grep -q '"unit":"cm"' counts.json
ok "counts become centimetres" $? "$(cat counts.json)"
"$hooke" -n -c 'load raw.txt; calibrate y 20 cm 40 cm at=1:2,2:3' >out.txt 2>&1
[ $? -eq 1 ] && grep -q 'both times, so there is only one point' out.txt
ok "two readings that are one are refused" $? "$(cat out.txt)"
held | "$hooke" -n -c 'calibrate y 5 V 20 cm 9 V 40 cm; collect - to=volts.txt' >out.txt 2>&1
grep -q 'was calibrated in V but is now in cm' out.txt && [ "$(raw volts.txt | wc -l)" -eq 501 ]
ok "so is a calibration of another quantity, and the lines are kept" $? "$(cat out.txt)"
echo "1..$n"
exit "$bad"
