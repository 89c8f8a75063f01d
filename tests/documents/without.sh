#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Modules can be left out: the program without any and without each of two, chosen by the day (LONG=1: without each), builds without a
# warning, holds none of their symbols, says of their words which module they belong to, with status 2, and passes the scenarios
# and the tests of rows that are left.
set -u
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; sed 's/^/#   /' "$work/log" | tail -12; fi; }
skip() { echo "ok 1 - modules that are left out # SKIP $1"; echo "1..1"; exit 0; }
case ${CONFIG:-release}-${HOOKE:-build/hooke} in
release-build/hooke) optional=yes built=build/release-without ;;
release-build/plain/hooke) optional=no built=build/plain-without ;;
*) skip "of the release build" ;;
esac
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
unset MAKEFLAGS MAKEOVERRIDES MFLAGS TOP CONFIG

mapfile -t modules < <(for path in src/modules/*/; do basename "$path"; done)
day=$(date +%-j)
chosen=("${modules[$((day % ${#modules[@]}))]}" "${modules[$(((day + ${#modules[@]} / 2) % ${#modules[@]}))]}")
[ -z "${LONG:-}" ] || chosen=("${modules[@]}")

# What functions and tables a module has that others can see.
symbols() { # objects...
    nm "$@" 2>/dev/null | awk '$2 ~ /^[TDRB]$/ {print $3}' | sort -u
}

without() { # NAME, or all
    local name=$1 folder test needed count
    local -a left=("$name")
    # Those that need it are left out, too, and those that need these.
    for (( count = 0; count < ${#left[@]}; )); do
        count=${#left[@]}
        mapfile -t left < <(for module in "${modules[@]}"; do
            for needed in $module $(sed -n 's/^ *\.needs = "\(.*\)",$/\1/p' "src/modules/$module/$module.c"); do
                [[ " ${left[*]} " != *" $needed "* ]] || { echo "$module"; break; }
            done
        done)
    done
    [ "$name" != all ] || left=("${modules[@]}")
    folder=$built/$(if [ "$name" = all ]; then echo all; else tr ' ' '+' <<<"${left[*]}"; fi)
    make -j"$(nproc)" OPTIONAL=$optional WITHOUT="$([ "$name" = all ] && echo all || echo "${left[*]}")" WERROR=1 "$folder/hooke" "$folder"/tests/unit/command/{scripts,catalog,rows} >"$work/log" 2>&1
    ok "without $name it is built" $?
    for module in "${left[@]}"; do
        comm -12 <(symbols build/release/modules/"$module"/*.o build/release/modules/"$module"/*/*.o) <(symbols "$folder/hooke" "$folder/libhooke.a") >"$work/log"
        [ ! -s "$work/log" ]
        ok "and has no symbol of $module" $?
        while IFS=, read -r word of; do
            "$folder/hooke" -n -c "$word" >"$work/log" 2>&1
            [ $? -eq 2 ] && grep -q "'$word' belongs to the module $of, which this program was built without" "$work/log"
            ok "without $name: $word" $?
            ! "$folder/hooke" -n -c "help $word" 2>&1 | grep "there is no help" >"$work/log"
            ok "without $name: help $word explains another thing of that name, or whose it is" $?
        done < <(sed -n 's/^MISSING("\([a-z]*\)", "\(.*\)")$/\1,\2/p' "$folder/lists/missing.def" | grep ",$module$")
        for word in $(sed -n "s/^MISSING(\"\(--[a-z-]*\)\", \"$module\")$/\1/p" "$folder/lists/missing.def"); do
            "$folder/hooke" "$word" >"$work/log" 2>&1
            [ $? -eq 2 ] && grep -q "'$word' belongs to the module $module, which this program was built without" "$work/log"
            ok "without $name: $word" $?
        done
    done
    "$folder/hooke" -n -c "scene spring; method verlet; run 2 s; step 3; undo; plot position; export $work/$name.csv; print y" >"$work/log" 2>&1
    ok "without $name the spring runs" $?
    "$folder/hooke" -n -c plan >"$work/log" 2>&1
    grep -q "^modules   $([ "$name" = all ] && echo none || printf '%s\n' "${modules[@]}" | grep -vxF "$(printf '%s\n' "${left[@]}")" | xargs)$" "$work/log"
    ok "without $name: plan names those that are in" $?
    for test in scripts catalog rows; do
        [ "$test" = scripts ] && [ "$name" != all ] && [ -z "${LONG:-}" ] && continue # nearly a minute
        "$folder/tests/unit/command/$test" >"$work/log" 2>&1
        ok "without $name: unit/command/$test" $?
    done
}

# The linker makes what is hidden local: functions of the library can be seen in its archive only.
for module in "${modules[@]}"; do
    symbols build/release/modules/"$module"/*.o build/release/modules/"$module"/*/*.o >"$work/log"
    seen=$(comm -12 "$work/log" <(symbols "${HOOKE:-build/hooke}" "${LIBHOOKE:-build/libhooke.a}") | wc -l)
    [ "$((2 * seen))" -gt "$(wc -l <"$work/log")" ]
    ok "most symbols of $module are seen in the whole program" $?
done

for name in "${chosen[@]}" all; do without "$name"; done
echo "1..$n"
exit $bad
