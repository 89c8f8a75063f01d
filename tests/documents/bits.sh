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

scenes='pendulum pendulum-driven duffing-driven elastic-pendulum prothero-robinson drag' known='3735038046 178502'
fixed='rk4 dopri5 verlet pefrl gauss4 rodas5p bdf3' adaptive='dopri5 radau5'
masks='-FMA,-AVX2,-AVX512F,-FMA_Usable,-AVX2_Usable'
if [ -n "${LONG:-}" ]; then
    # 'exact' asks the C library for functions in long double, CVODE for pow: that is not promised.
    scenes=$("$hooke" -n -c "list scenes" | awk '{print $1}')
    fixed=$("$hooke" -n -c "list methods" | awk '/^[a-z]/ && !/^(method|stable|exact|cvode)/ {print $1}')
    adaptive=$("$hooke" -n -c "list methods" | awk '/yes/ && !/^cvode/ {print $1}')
    masks="$masks -FMA,-FMA4,-AVX2,-AVX,-SSE4_1,-SSE4_2,-XSAVE" known='1909827396 4631518'
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

# The functions themselves by every compiler: with FMA in the compiler's hands, with it where the machine has it, without.
cat >"$folder/many.c" <<'MANY'
#include <hooke/base/elementary.h>

#include <stdint.h>
#include <stdio.h>
#include <string.h>

static uint64_t state, hash = 0xCBF29CE484222325;

static double drawn(double from, double to)
{
    state = state * 0x5851F42D4C957F2D + 0x14057B7EF767814F;
    return from + (to - from) * ((double)(state >> 11) * 0x1p-53);
}

static void take(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ (value != value ? 1 : bits)) * 0x100000001B3;
}

int main(void)
{
    static double (*const one[])(double) = {fixed_sin,  fixed_cos,  fixed_tan,  fixed_asin, fixed_acos,
                                            fixed_atan, fixed_exp,  fixed_expm1, fixed_sinh, fixed_cosh,
                                            fixed_tanh, fixed_log,  fixed_log10, fixed_cbrt};
    static double (*const two[])(double, double) = {fixed_pow, fixed_atan2, fixed_hypot};
    static void (*const many[])(int, const double *, double *) = {fixed_sines, fixed_cosines, fixed_exponentials};
    static const double sizes[] = {1, 0.01, 4, 60, 700, 1e9};
    for (int i = 0; i < 6 * 4000; i++) {
        const double size = sizes[i % 6];
        for (unsigned f = 0; f < sizeof one / sizeof *one; f++)
            take(one[f](drawn(f > 10 ? 0 : -size, size)));
        for (unsigned f = 0; f < sizeof two / sizeof *two; f++) {
            const double first = drawn(0, size);
            take(two[f](first, drawn(-size, size)));
        }
        double x[70];
        for (int k = 0; k < 70; k++)
            x[k] = drawn(-size, size);
        many[i % 3](70, x, x);
        for (int k = 0; k < 70; k++)
            take(x[k]);
    }
    printf("%016llx\n", (unsigned long long)hash);
}
MANY
forms=("gcc -O0" "gcc -O2")
grep -qw fma /proc/cpuinfo 2>/dev/null && forms+=("gcc -O3 -mfma -mavx2")
if [ -n "${LONG:-}" ]; then
    forms+=("gcc -O1" "gcc -O3" "clang -O0" "clang -O1" "clang -O2" "clang -O3")
    grep -qw fma /proc/cpuinfo && forms+=("gcc -O0 -mfma" "gcc -O2 -mfma" "clang -O2 -mfma" "clang -O3 -mfma -mavx2")
fi
first=''
for form in "${forms[@]}"; do
    # shellcheck disable=SC2086
    if ! command -v "${form%% *}" >/dev/null; then
        ok "the same functions by $form # SKIP no such compiler" 0
    else
        $form -std=c11 -ffp-contract=off -Iinclude -Isrc -o "$folder/many" src/base/elementary/*.c "$folder/many.c" -lm &&
            found=$("$folder/many") && [ "$found" = "${first:=$found}" ]
        ok "the same functions by $form ($found)" $?
    fi
done
echo "1..$n"
exit "$bad"
