#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The library as others use it: installed, found by pkg-config, from C, C++ and Python with numpy, where these are; what
# it shows of itself is what hooke/api.h declares; its columns are those of `export`.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
top=$(dirname "$hooke")
[ "${CONFIG:-release}" = asan ] && { echo "ok 1 - the library elsewhere # SKIP other programs bring no sanitizer"; echo "1..1"; exit; }
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
n=0 bad=0
ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    [ -z "${3:-}" ] || printf '%s\n' "$3" | head -15 | sed 's/^/#   /'
}
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; }

building=(TOP="${top#"$PWD/"}" CONFIG="${CONFIG:-release}" DESTDIR="$work/root" PREFIX=/opt/hooke)
case $top in */plain | */plain-*) building+=(OPTIONAL=no) ;; esac
said=$(make -s "${building[@]}" install 2>&1)
ok "make install" $? "$said"
there=$work/root/opt/hooke library=$work/root/opt/hooke/lib/libhooke.so.0
export PKG_CONFIG_PATH=$there/lib/pkgconfig LD_LIBRARY_PATH=$there/lib

declared=$(grep -oE '\bhooke_[a-z_]+\(' include/hooke/api.h | grep -vE 'hooke_open_flag' | tr -d '(' | sort -u)
shown=$(nm -D --defined-only "$library" | awk '$2 == "T" {sub(/@.*/, "", $3); print $3}' | sort)
[ -n "$declared" ] && [ "$declared" = "$shown" ]
ok "it shows what its header declares, and nothing else" $? "$(diff <(echo "$declared") <(echo "$shown"))"
[ "$(nm -D --defined-only "$library" | grep -c '@@HOOKE_0$')" -eq "$(wc -l <<<"$shown")" ]
ok "with its version" $?
readelf -d "$library" | grep -q 'SONAME.*\[libhooke.so.0\]'
ok "and its name" $?

cp examples/library/* "$work"
cd "$work" || exit 2
flags=$(pkg-config --define-variable=prefix="$there" --define-variable=libdir="$there/lib" --cflags --libs hooke 2>&1)
ok "pkg-config finds it" $? "$flags"
# shellcheck disable=SC2086
said=$(${CC:-gcc} -std=c11 -Wall -Wextra -Wpedantic -Werror pendulum.c $flags -o pendulum 2>&1 && ./pendulum)
ok "the example in C" $? "$said"
[ "$(grep -c ' deg  T = ' <<<"$said")" -eq 5 ] && grep -q '90 deg  T = 2.367842 ' <<<"$said"
ok "prints periods" $? "$said"
last=$("$hooke" -n -q -c 'scene pendulum; method rk4 dt=1ms; theta0 = 170 deg; run 20 s' -c 'export - t,theta' 2>/dev/null | tail -1)
grep -qF "t = ${last%,*} s, theta = ${last#*,} rad" <<<"$said"
ok "and the doubles of export" $? "$last"$'\n'"$(tail -1 <<<"$said")"
# shellcheck disable=SC2086
said=$(${CC:-gcc} -std=c11 pendulum.c $(pkg-config --define-variable=prefix="$there" --define-variable=libdir="$there/lib" --cflags hooke) "$there/lib/libhooke.a" \
    $(pkg-config --static --libs hooke | sed 's/-lhooke//') -o static 2>&1 && ./static)
ok "the same with the archive" $? "$said"

if command -v "${CXX:-g++}" >/dev/null; then
    printf '#include <hooke/api.h>\nint main() { hooke *lab = hooke_open(HOOKE_SAFE); hooke_close(lab); }\n' >user.cc
    # shellcheck disable=SC2086
    said=$("${CXX:-g++}" -Wall -Wextra -Werror user.cc $flags -o user 2>&1 && ./user)
    ok "C++ understands the header" $? "$said"
else
    skip "C++ understands the header" "no C++ compiler"
fi

python=
for candidate in /usr/bin/python3 python3; do
    "$candidate" -c 'import numpy' 2>/dev/null && { python=$candidate; break; }
done
if [ "$python" ]; then
    export PYTHONDONTWRITEBYTECODE=1 LIBHOOKE=$library
    said=$("$python" resonance.py 2>&1)
    ok "the example in Python" $? "$said"
    grep -q '^61 points, the largest amplitude 0.037.* m at omega = 8.7 rad/s$' <<<"$said" && grep -q "^column 9: .*'period'" <<<"$said"
    ok "finds the resonance and says what is wrong" $? "$said"
    said=$("$python" - "$hooke" <<'P' 2>&1
import gc, subprocess, sys
import numpy, hooke
lines = "scene pendulum; method rk4 dt=1ms; run 20 s"
lab = hooke.Session()
lab.run(lines)
table = lab.table("t theta rate energy")
csv = subprocess.run([sys.argv[1], "-n", "-q", "-c", lines, "-c", "export - t,theta,rate,energy"], capture_output=True, text=True).stdout
rows = [line.split(",") for line in csv.splitlines() if line and not line.startswith("#")]
names = [name.split()[0] for name in rows[0]]
columns = numpy.array([[float(x) for x in row] for row in rows[1:]]).T
assert len(columns[0]) == 20001
for name, column in zip(["t", "theta", "rate", "energy"], columns):
    assert (table[name] == column).all(), name
    assert not table[name].flags.owndata
theta = table["theta"]
total = theta.sum()
del table, lab
gc.collect()
assert theta.sum() == total # the memory lives as long as an array does
lab = hooke.Session(safe=True)
lab.run("k = 12 N/m")
assert lab["k"] == (12.0, 0.0)
try:
    lab["nothing"]
    raise AssertionError
except KeyError:
    pass
print("same")
P
)
    [ "$said" = same ]
    ok "arrays are the doubles of export, without a copy" $? "$said"
else
    skip "the example in Python" "no numpy"
fi
echo "1..$n"
exit "$bad"
