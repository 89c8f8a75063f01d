#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Adding something is one row in one place: each NAME.patch here adds a row of another kind. All of them
# together are applied to one copy of the tree, built (what they touch only, without optimisation) and
# asked for; with LONG=1 each is also built alone, and the tests that iterate over its kind are run.
#
# The head of a patch: "files: N" of the source that it may touch (1); "file: NAME CONTENT"; "say: COMMANDS"
# (json: as records), "expect: TEXT" in what they say, which the program without the row does not say;
# "never: TEXT"; "fails: COMMANDS"; "test: NAMES" of test programs.
# Of these some are of modules, as are some rows.
# needs "modules/comparison/"
# needs "modules/lanes/"
# needs "modules/recording/"
# needs "modules/resume/"
set -u
top=$PWD
here=$top/tests/rows
config=${CONFIG:-release}
n=0 bad=0
ok() { # name status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    [ -z "${3:-}" ] || printf '%s\n' "$3" | head -25 | sed 's/^/#   /'
}
skip() { echo "ok 1 - rows # SKIP $1"; echo "1..1"; exit 0; }
[ "$config" = release ] || [ "$config" = debug ] || skip "only of release and debug builds"
command -v patch >/dev/null || skip "patch is not installed"
[ -d "build/$config/base" ] || skip "there are no objects in build/$config"

# The program that is tested says which build it is; what make was told about it stays with that make.
unset MAKEFLAGS MAKEOVERRIDES MFLAGS MAKELEVEL TOP OPTIONAL WERROR CFLAGS_EXTRA
building=(CONFIG="$config" WERROR=1)
programs=build/$config
program=build/hooke
[ "$config" = release ] || program=build/$config/hooke
case ${HOOKE:-} in
    build/plain*)
        building+=(OPTIONAL=no)
        programs=$(dirname "$HOOKE")
        program=$HOOKE
        ;;
esac

folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/bin" "$folder/work"
printf '#!/bin/sh\nexec %s "$@" -O0 -g0 -U_FORTIFY_SOURCE\n' "${CC:-gcc}" >"$folder/bin/cc"
chmod +x "$folder/bin/cc"

# The sources, and the objects as they are, with their times: only what a row touches is built again.
copy_tree() {
    rm -rf "$folder/tree"
    mkdir "$folder/tree"
    cp -a Makefile src include scripts tests examples "$folder/tree"
    for part in $(printf '%s\n' "build/$config"/* "$programs"/* | sort -u); do
        mkdir -p "$folder/tree/$(dirname "$part")"
        case $part in
            */tests) [ -n "${LONG:-}" ] && cp -a "$part" "$folder/tree/$part" ;;
            */pages | */hooke | *.a) ;;
            *) cp -a "$part" "$folder/tree/$part" ;;
        esac
    done
}

head_of() { sed -n "s/^$2: //p" "$here/$1.patch"; } # patch key
build() { # goals...
    (cd "$folder/tree" && make -j2 CC="$folder/bin/cc" "${building[@]}" "$@" 2>&1) >"$folder/log"
}
say() { # program say|json commands: what it says, and its status
    (cd "$folder/work" && timeout 240 "$1" $([ "$2" = json ] && echo --format json) -c "$3" 2>&1)
}

asked() { # patch: is what it promises there, and was it not before?
    local patch=$1 key value said='' before='' status=0
    while IFS= read -r line; do
        case $line in ---*) break ;; esac
        key=${line%%: *} value=${line#*: }
        case $key in
            file) printf "${value#* }" | sed 's/%%/%/g' >"$folder/work/${value%% *}" ;;
            say | json)
                said=$(say "$folder/tree/$program" "$key" "$value")
                status=$?
                before=$(say "$top/${HOOKE:-$program}" "$key" "$value")
                ok "$patch: $value" $status "$said"
                ;;
            expect)
                grep -qF -- "$value" <<<"$said"
                ok "$patch: '$value' is said" $? "$said"
                ! grep -qF -- "$value" <<<"$before"
                ok "$patch: and was not before" $? "$before"
                ;;
            never)
                ! grep -qF -- "$value" <<<"$said"
                ok "$patch: '$value' is not said" $? "$said"
                ;;
            fails)
                said=$(say "$folder/tree/$program" say "$value")
                status=$?
                [ "$status" -gt 0 ] && [ "$status" -lt 124 ]
                ok "$patch: $value is refused" $? "status $status: $said"
                ;;
        esac
    done <"$here/$patch.patch"
}

kinds='runge-kutta splitting algorithm command argument-type format force preset observable fit plot setting stress unit function column'
copy_tree
for patch in $kinds; do
    [ -f "$here/$patch.patch" ] || { ok "there is a patch for $patch" 1; continue; }
    allowed=$(head_of "$patch" files)
    touched=$(sed -n 's/^+++ b\///p' "$here/$patch.patch" | sort -u)
    [ "$(grep -c . <<<"$touched")" -le "${allowed:-1}" ] && ! grep -qv '^src/' <<<"$touched"
    ok "$patch: a row in ${allowed:-1} file" $? "$touched"
    said=$(patch -p1 -s -N -d "$folder/tree" <"$here/$patch.patch" 2>&1)
    ok "$patch applies" $? "$said"
done
for file in "$here"/*.patch; do
    [[ " $kinds " == *" $(basename "$file" .patch) "* ]]
    ok "$(basename "$file") is known" $?
done
build "$program" "$programs/tests/unit/command/rows" "$programs/tests/modules/resume/grown"
ok "all rows are built together" $? "$(grep -E 'error|warning|\*\*\*' "$folder/log" || tail -5 "$folder/log")"
if [ "$bad" -eq 0 ]; then
    for patch in $kinds; do asked "$patch"; done
    said=$(CMOCKA_MESSAGE_OUTPUT=TAP "$folder/tree/$programs/tests/unit/command/rows" 2>&1)
    ok "each name has one meaning, is explained and completed" $? "$said"
    grown=$programs/tests/modules/resume/grown
    said=$(cd "$folder/work" && "$top/$grown" keep today.hks 2>&1 && "$folder/tree/$grown" read today.hks 2>&1)
    ok "a session of the program without the rows is read" $? "$said"
    for patch in ${LONG:+$kinds}; do
        copy_tree
        patch -p1 -s -N -d "$folder/tree" <"$here/$patch.patch"
        tests=$(head_of "$patch" test | sed "s|[^ ]*|$programs/tests/&|g")
        build "$program" $tests
        ok "$patch is built alone" $? "$(tail -5 "$folder/log")"
        for test in $tests; do
            said=$(cd "$folder/tree" && LONG='' HOOKE=$program CMOCKA_MESSAGE_OUTPUT=TAP timeout 1800 "$test" 2>&1)
            ok "$patch: $test" $? "$(grep -v '^ok' <<<"$said")"
        done
    done
fi
echo "1..$n"
exit "$bad"
