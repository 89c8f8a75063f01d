#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The manual: everything that can be chosen by name is in a page, what the pages show was run, no
# heading stands twice.
set -u
hooke=${HOOKE:-build/hooke}
n=0 bad=0
ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    [ -z "${3:-}" ] || printf '%s\n' "$3" | head -15 | sed 's/^/#   /'
}
names() { "$hooke" --format json -c "$1" | sed -nE 's/^\{"kind":"[^"]*","name":"([^"]*)".*/\1/p'; }
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT

for page in hooke.1 hooke-language.7 hooke-methods.7 hooke-lab.7; do
    said=$(scripts/reference page $page "$hooke" 2>&1 >"$folder/$page")
    ok "what $page shows runs" $? "$said"
    twice=$(grep -E '^\.S[HS] ' "$folder/$page" | sort | uniq -d)
    [ -z "$twice" ]
    ok "$page has each heading once" $? "$twice"
    left=$(grep -nE '^@|@(VERSION|DATE)@' "$folder/$page")
    [ -z "$left" ]
    ok "$page has nothing to be filled in" $? "$left"
    if command -v mandoc >/dev/null; then
        said=$(mandoc -T lint -W warning "$folder/$page" 2>&1)
        ok "$page is well-formed" $? "$said"
    else
        n=$((n + 1)); echo "ok $n - $page is well-formed # SKIP mandoc is not installed"
    fi
done
mkdir "$folder/broken" && cp -R scripts examples "$folder/broken"
printf '@run\nset gama 1\n@end\n' >"$folder/broken/scripts/pages/hooke.1"
! "$folder/broken/scripts/reference" page hooke.1 "$hooke" >"$folder/out" 2>&1 &&
    grep -q 'status 1, wanted 0' "$folder/out"
ok "an example that fails is noticed" $? "$(cat "$folder/out")"

# What the tags of the pages say in bold: as a whole, and up to the first blank or parenthesis.
sed -n '/^\.TP/{n;p;}' "$folder"/hooke*.[17] | grep -oE '\\fB([^\\]|\\[^f])*' |
    sed -E 's/\\fB//; s/\\\(ha/^/g; s/\\-/-/g' |
    awk '{print; if (sub(/[ (].*/, "")) print}' >"$folder/tags"
sed -n '/^\.SS Plots/,/^\.SH EX/p; /^\.SS What/,/^\.SH/p' "$folder/hooke.1" |
    sed -n '/^\.TP/{n;p;}' | sed -E 's/^\\fB(.*)\\fR$/\1/' >"$folder/choices"
lists=0
for kind in commands scenes methods parameters derived observables settings units functions \
    formats limits; do
    missing=
    names "list $kind" >"$folder/names"
    while read -r name; do
        grep -qxFe "$name" "$folder/tags" || missing+="$name "
    done <"$folder/names"
    [ -s "$folder/names" ] && [ -z "$missing" ]
    ok "every one of the $kind is in a page" $? "missing: $missing"
    lists=$((lists + 1))
done
# Measurements, events, runs, recordings and what was found of the equations are the session's.
offered=$("$hooke" -c 'list nothing' 2>&1 | grep -oE 'one of: .*' | tr ',' '\n' |
    grep -cvE 'measurements|events|runs|recordings|equilibria|orbits|branches|points')
[ "$offered" -eq "$lists" ]
ok "there are no other lists" $? "$offered lists, $lists looked for"

without=
for command in measure plot focus layout fit; do
    offered=$("$hooke" -c "$command nothing" 2>&1 | sed -n 's/^  it is one of: //p' | tr -d ,)
    [ -n "$offered" ] || without+="$command offers nothing "
    for name in $offered; do
        case $command.$name in fit.scene | fit.modes) continue ;; esac # the text of fit has them
        grep -qxFe "$name" "$folder/choices" || without+="$command.$name "
    done
done
[ -z "$without" ]
ok "so is what can be measured, plotted, shown and fitted" $? "missing: $without"

without=
for scene in $(names 'list scenes'); do
    for name in $(names "scene $scene; list parameters"); do
        grep -qxFe "$name" "$folder/tags" || without+="$scene.$name "
    done
done
[ -z "$without" ]
ok "every parameter of every scene is in a page" $? "missing: $without"

# Of each method order, stability (where steps are its own) and source.
without=$(awk '
    /^\.SH/ {within = $0 == ".SH METHODS"}
    within && /^\.TP/ {getline; name = $1; order = stable = source = 0; names[++count] = name}
    within && /^(order|orders up to|exact)/ {seen[name] = seen[name] "o"}
    within && /^stability:/ {seen[name] = seen[name] "s"}
    within && /^source:/ {seen[name] = seen[name] "c"}
    END {
        for (i = 1; i <= count; i++)
            if (seen[names[i]] != "osc" && names[i] !~ /exact|cvode/) print names[i], seen[names[i]]
        if (count < 60) print count " methods"
    }' "$folder/hooke-methods.7")
[ -z "$without" ]
ok "each method has its order, stability and source" $? "$without"
echo "1..$n"
exit "$bad"
