#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The same bits on every machine: steps of scenes, of equations with each function, and sweeps, with all digits, are
# known numbers, whatever instructions the C library finds. The long form takes all scenes by all methods.
set -u
hooke=${HOOKE:-build/hooke}
n=0 bad=0
ok() { # name status
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else echo "not ok $n - $1"; bad=1; fi
}
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT

scenes='pendulum pendulum-driven duffing-driven elastic-pendulum prothero-robinson drag' known='296333448 178500'
fixed='rk4 dopri5 verlet pefrl gauss4 rodas5p bdf3' adaptive='dopri5 radau5'
masks='-FMA,-AVX2,-AVX512F,-FMA_Usable,-AVX2_Usable'
if [ -n "${LONG:-}" ]; then
    # 'exact' asks the C library for functions in long double, CVODE for pow: that is not promised.
    scenes=$("$hooke" -n -c "list scenes" | awk '{print $1}')
    fixed=$("$hooke" -n -c "list methods" | awk '/^[a-z]/ && !/^(method|stable|exact|cvode)/ {print $1}')
    adaptive=$("$hooke" -n -c "list methods" | awk '/yes/ && !/^cvode/ {print $1}')
    masks="$masks -FMA,-FMA4,-AVX2,-AVX,-SSE4_1,-SSE4_2,-XSAVE" known='2184676207 4631454'
fi
steps() { # settings of those with a fixed step
    local m
    for m in $fixed; do echo "method $m $1; run --steps 20; export -"; done
    for m in $adaptive; do echo "method $m tol=1e-7; run --steps 20; export -"; done
}
for scene in $scenes; do
    { echo "scene $scene"; steps ''; } >"$folder/$scene.hk"
done
equations=("y'' = -sin(y) + cos(2*t) - 0.1*tan(y/4)"
    "y'' = -sinh(y) + tanh(y')*exp(-t/3) - cosh(y/2)/9"
    "y'' = -asin(y/4) - acos(y/3) + atan(t) - atan2(y, 2 + t)"
    "y'' = -log(2 + y) - log10(1 + t) - cbrt(y) - hypot(y, t)/5"
    "y'' = -(y^2 + 1)^0.3*y - pow(2 + t, -1.7) - abs(y)^2.5"
    "y'' = cos(t + 1e9) - sin(3e7 + y)")
for i in "${!equations[@]}"; do
    { echo "scene new; var y = 1; ${equations[i]}"; steps dt=50ms; } >"$folder/typed-$i.hk"
done
cat >"$folder/sweep.hk" <<'SWEEPS'
scene pendulum; set duration 2 s; method rk4 dt=20ms; sweep theta0=0.1:3:0.05 measure=mean; export - table
scene duffing-driven; set duration 2 s; method rk4 dt=20ms; sweep omega=0.1:3:0.05 measure=mean; export - table
method verlet; sweep omega=0.1:3:0.05 measure=mean; export - table
SWEEPS

bits() { # GLIBC_TUNABLES
    local file
    for file in "$folder"/*.hk; do
        basename "$file"
        GLIBC_TUNABLES=$1 "$hooke" -q -n -k "$file" 2>/dev/null
    done
}
bits "" >"$folder/all"
for mask in $masks; do
    bits "glibc.cpu.hwcaps=$mask" | cmp -s - "$folder/all"
    ok "the same bits without $mask" $?
done
found=$(cksum <"$folder/all")
[ "$found" = "$known" ]
ok "they are the known ones, $known ($found)" $?
echo "1..$n"
exit "$bad"
