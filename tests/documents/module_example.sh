#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The example of src/modules/README.md is a module: added to a copy of the tree it is built (what it touches only, without
# optimisation), its command works and is explained, its count comes back with the session, and it can be left out. What
# both documents of the source name is there.
set -u
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; printf '%s\n' "${3:-}" | tail -15 | sed 's/^/#   /'; fi; }
has() { grep -qF -- "$2" <<<"$said"; ok "$1" $? "$said"; } # name text

for document in src/README.md src/modules/README.md; do
    [ "$(wc -l <"$document")" -le 260 ] && ! LC_ALL=C.UTF-8 grep -qE '^.{101}' "$document"
    ok "$document: at most 260 lines of 100 characters" $? "$(wc -l <"$document") lines"
    # Paths; `NAME()` in `PATH`; and rows of questions, | … | `PATH`, `WORD` |.
    missing=$(grep -oE '`(src|include|tests|scripts)/[^` ]*`' "$document" | tr -d '`' | sort -u |
        while read -r path; do [ -e "$path" ] || [[ $path = *NAME* || $path = src/modules/example/* ]] || echo "$path"; done
        grep -oE '`[a-z_]+\(\)` in `src/[^` ]*`' "$document" | tr -d '`' | while read -r name _ path; do
            grep -q "\b${name%()}(" "$path" || echo "$name in $path"
        done
        sed -n 's/^| .* | `\(src[^`]*\)`, `\([^`]*\)` |$/\1 \2/p' "$document" | while read -r path word; do
            grep -qF "${word%)}" "$path" || echo "$word in $path"
        done)
    [ -z "$missing" ]
    ok "$document: the files and functions that it names are there" $? "$missing"
done
missing=$(for folder in src/*/; do grep -q "^| \`$(basename "$folder")\`" src/README.md || echo "$folder"; done)
[ -z "$missing" ]
ok "src/README.md: each layer has its line" $? "$missing"
[ "$(grep -c '^| .* | `src/[^|]*, `[^|]*` |$' src/README.md)" -eq 10 ]
ok "src/README.md: ten questions have their answers" $?

config=${CONFIG:-release}
case $config-${HOOKE:-build/hooke} in
release-build/hooke) optional=yes top=build made=build/release left=build/release-without ;;
release-build/plain/hooke) optional=no top=build/plain made=build/plain left=build/plain-without ;;
*) top='' ;;
esac
if [ ! "$top" ] || [ ! -d build/release/base ]; then
    echo "ok $((n + 1)) - the example is built # SKIP only with the objects of a release build"
    echo "1..$((n + 1))"
    exit "$bad"
fi
unset MAKEFLAGS MAKEOVERRIDES MFLAGS MAKELEVEL TOP OPTIONAL WERROR CFLAGS_EXTRA CONFIG
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
tree=$folder/tree
mkdir -p "$folder/bin" "$tree/build/release" "$tree/$made"
printf '#!/bin/sh\nexec %s "$@" -O0 -g0 -U_FORTIFY_SOURCE\n' "${CC:-gcc}" >"$folder/bin/cc"
chmod +x "$folder/bin/cc"
cp -a Makefile src include scripts tests examples "$tree"
cp -a build/*.def build/terminals build/texts "$tree/build"
for part in build/release/* $([ "$optional" = yes ] || echo build/plain/*); do
    [ "${part##*/}" = tests ] || cp -a "$part" "$tree/$part"
done

example=$tree/src/modules/example/example.c
mkdir -p "$(dirname "$example")" "$tree/tests/modules/example"
for block in c:example.c text:help.txt; do
    sed -n "/^\`\`\`${block%:*}\$/,/^\`\`\`\$/p" src/modules/README.md | sed '/^```/d' >"${example%/*}/${block#*:}"
done
cat >"$tree/tests/modules/example/example.c" <<'END'
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "modules/resume/testing.h"

static void its_count_comes_back(void **state)
{
    (void)state;
    struct bench b, again;
    bench_open(&b, false);
    type_ok(&b, "scene spring; method verlet; run 1 s; ekin; ekin; ekin");
    bench_resume(&b, &again);
    type_ok(&again, "ekin");
    assert_says(&again.out, "shown 4 times");
    bench_close(&b);
    bench_close(&again);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(its_count_comes_back)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
END
build() { (cd "$tree" && make -j2 CC="$folder/bin/cc" OPTIONAL=$optional WERROR=1 "$@" 2>&1); }
test=$made/tests/modules/example/example
said=$(build "$top/hooke" "$test")
ok "the example is built without a warning" $? "$said"
built=$(grep -c '^ *CC ' <<<"$said")
[ "$built" -ge 3 ] && [ "$built" -le 12 ] # its two files, those with lists of modules, up to two of build/*.def
ok "and little else with it" $? "$said"

run() { "$tree/$top/hooke" -n "$@" 2>&1; }
said=$(run -c 'scene spring; method verlet dt=1ms; y0 = 0; v0 = 1 m/s; run 1 s; back 1000; ekin; ekin')
ok "its command works" $? "$said"
has "it prints m v^2/2" "kinetic energy of run 1: 0.1 J, shown 1 times" # 0.2 kg, 1 m/s
has "and keeps a count" "shown 2 times"
said=$(run --format json -c 'scene spring; method verlet dt=1ms; y0 = 0; v0 = 1 m/s; run 1 s; back 1000; ekin' | tail -1)
has "its record has the names of its columns" '{"kind":"ekin","energy":0.1,"times":1}'
said=$(run -c ekin)
[ $? -eq 1 ] && grep -q 'error: there is no run yet' <<<"$said"
ok "it is refused without a run" $? "$said"
said=$(run -c 'help ekin')
has "help has its usage" "usage: ekin"
has "and its line" "the kinetic energy of the current run"
has "and its text" "At its present time."
said=$(run --version)
has "the program names the module" " example "
cp -a "${example%/*}/help.txt" "$folder"
for change in 's/command ekin/command other/' '$a# command other: none\n'; do
    sed "$change" "$folder/help.txt" >"${example%/*}/help.txt"
    said=$(build "$made/command/commands.o")
    [ $? -ne 0 ] && grep -q 'IS_COMMAND_other' <<<"$said"
    ok "a text without a command ends the build ($change)" $? "$said"
done
sed 's/command ekin/topic other/' "$folder/help.txt" >"${example%/*}/help.txt"
said=$(build "$made/command/commands.o")
[ $? -ne 0 ] && grep -q 'brief_ekin' <<<"$said"
ok "so does a command without a text" $? "$said"
cp "$folder/help.txt" "${example%/*}"
said=$("$tree/$test" 2>&1)
ok "its count is in the session's file" $? "$said"
said=$(cd "$tree" && scripts/check-layers $top/libhooke.a)
ok "it keeps the rules of includes and globals" $? "$(grep -A5 '^not ok' <<<"$said")"

said=$(build WITHOUT=example $left/example/hooke)
ok "it can be left out" $? "$said"
said=$("$tree/$left/example/hooke" -n -c ekin 2>&1)
[ $? -eq 2 ] && grep -qF "'ekin' belongs to the module example, which this program was built without" <<<"$said"
ok "then its command is refused with status 2 and the module's name" $? "$said"
echo "1..$n"
exit "$bad"
