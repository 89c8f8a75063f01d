#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Pictures written by the real program: whole files of the right kind, nothing overwritten, and what is said without cairo.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
echo 'leak:libfontconfig' >suppressions # it keeps offsets where the leak checker of AddressSanitizer looks for pointers
export LSAN_OPTIONS="suppressions=$work/suppressions:print_suppressions=0${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
n=0 bad=0

ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; [ -n "${3:-}" ] && printf '%s\n' "$3" | sed 's/^/#   /'; fi
}
status_is() { # name wanted command...
    local name=$1 wanted=$2 got
    shift 2
    "$@" >out.txt 2>err.txt
    got=$?
    [ "$got" -eq "$wanted" ]
    ok "$name" $? "status $got, wanted $wanted: $(head -c 300 err.txt)"
}

status_is "a name without a known end is refused" 1 "$hooke" -c 'run 1 s; plot position > figure.gif'
grep -q 'ends in .svg, .pdf or .png, or text in .txt' err.txt
ok "and told what there is" $? "$(cat err.txt)"
status_is "a name that is only an end is refused" 1 "$hooke" -c 'run 1 s; plot position > svg'

# of two panels: below the upper one's frame, which ends where the lower one's begins
status_is "two panels" 0 "$hooke" -c 'compare euler symplectic-euler dt=10ms; plot position run all > panels.svg'
legend=$(sed -n 's/^<text x="[0-9.]*" y="\([0-9.]*\)"[^>]*>symplectic-euler<.*/\1/p' panels.svg)
title=$(sed -n 's/^<text x="[0-9.]*" y="\([0-9.]*\)"[^>]*>position<.*/\1/p' panels.svg)
awk -v legend="$legend" -v title="$title" 'BEGIN {exit !(title > 0 && legend > title + 20)}'
ok "their legend stands in one of them" $? "title at $title, legend at $legend"
"$hooke" -n -c 'scene robertson; method radau5; run 100 s; plot y1,y2,y3 > names.svg' >out.txt 2>err.txt
! grep -qE '>y[123]<' names.svg && grep -q '>y₂<' names.svg
ok "its names are printed as on both axes" $? "$(grep -E '>y.?<' names.svg)"

status_is "an SVG needs no library" 0 "$hooke" -c 'run 1 s; plot position > try.svg'
grep -q '>position</text>' try.svg && grep -q '>t \[s\]</text>' try.svg
ok "its text is text" $?
# 20.2 % of the starts end in A: so many of its letters stand there, in any colour, and in the legend with their name
status_is "a map of basins" 0 "$hooke" -c "var x = 1; var v = 0; x' = v; v' = -x+x^3-0.2*v; basins x=-2:2:0.05 v=-2:2:0.05; \
    plot basins > basins.svg"
letters=$(grep -c '>A</text>' basins.svg)
[ "$letters" -gt 146 ] && [ "$letters" -lt 178 ]
ok "its letters cover as much as they have of the starts" $? "$letters of 800"
[ "$(grep -cE '>equilibrium at (0, 0 \(20.2 %\)|-?1, 0 \(0.0152 %\))<' basins.svg)" -eq 3 ] && grep -q '>escapes (79.8 %)<' basins.svg
ok "all that starts end in has its name" $? "$(grep -o '>[^<]*%[^<]*<' basins.svg)"

"$hooke" -c 'run 1 s; plot position > try.pdf' >out.txt 2>err.txt
if grep -q 'built without cairo' err.txt; then
    grep -q 'install libcairo2-dev' err.txt
    ok "a build without cairo says what to install" $? "$(cat err.txt)"
    [ ! -e try.pdf ]
    ok "and leaves no file" $?
    n=$((n + 1)); echo "ok $n - pictures # SKIP built without cairo"
    echo "1..$n"; exit "$bad"
fi

kinds='position velocity phase energy error spectrum'
script='compare euler symplectic-euler verlet rk4'
for kind in $kinds; do
    for end in svg pdf png; do script="$script; plot $kind run all > $kind.$end"; done
done
status_is "every kind of plot becomes every kind of picture" 0 "$hooke" -c "$script"
whole() { # kind
    [ "$(head -c 5 "$1.pdf")" = %PDF- ] && [ "$(tail -c 6 "$1.pdf")" = %%EOF ] &&
        [ "$(head -c 4 "$1.png" | tail -c 3)" = PNG ] && tail -c 8 "$1.png" | grep -aq ^IEND &&
        grep -q '^<svg ' "$1.svg" && [ "$(tail -n 1 "$1.svg")" = '</svg>' ] && ! grep -qiE '[^a-z](nan|inf)[^a-z]' "$1.svg"
}
for kind in $kinds; do
    whole "$kind"
    ok "the pictures of $kind are whole" $?
done
if command -v xmllint >/dev/null; then
    xmllint --noout ./*.svg 2>err.txt
    ok "the SVGs are XML" $? "$(head -n 5 err.txt)"
else
    n=$((n + 1)); echo "ok $n - the SVGs are XML # SKIP xmllint is not installed"
fi
if command -v pdftotext >/dev/null; then
    said=$(pdftotext -layout position.pdf -)
    missing=
    for word in position euler symplectic-euler verlet rk4 '[cm]' '[s]' 10; do
        case $said in *"$word"*) ;; *) missing="$missing $word" ;; esac
    done
    [ -z "$missing" ]
    ok "the PDF says title, names, units and ticks" $? "missing:$missing"
else
    n=$((n + 1)); echo "ok $n - the PDF says title, names, units and ticks # SKIP pdftotext is not installed"
fi

mkdir again
(cd again && "$hooke" -c 'method verlet; run 1 s; plot position > a.pdf; plot position > a.png' >/dev/null)
status_is "the same figure gives the same files" 0 bash -c "'$hooke' -c 'method verlet; run 1 s; plot position > a.pdf; plot position > a.png' &&
    cmp a.pdf again/a.pdf && cmp a.png again/a.png"

echo "the old file" >kept.svg
cp kept.svg expected
status_is "an existing file is not replaced without --force" 4 "$hooke" -c 'run 1 s; plot position > kept.svg'
cmp -s kept.svg expected
ok "it is unchanged" $?
status_is "with --force it is replaced" 0 "$hooke" -c 'run 1 s; plot position > kept.svg --force'
grep -q '^<svg ' kept.svg
ok "by the picture" $?
status_is "a missing folder ends with 4" 4 "$hooke" -c 'run 1 s; plot position > no/such/folder.png'
mkdir confined
status_is "--safe confines pictures to the current directory" 4 \
    bash -c "cd confined && '$hooke' --safe -c 'run 1 s; plot position > ../escaped.png'"
[ ! -e escaped.png ]
ok "nothing escaped" $?

mkdir library
echo "no library" >library/libcairo.so.2
status_is "without a library that can be loaded the plot is refused" 1 \
    env LD_LIBRARY_PATH="$work/library" "$hooke" -c 'run 1 s; plot position > none.png'
grep -q 'libcairo.so.2 cannot be loaded' err.txt && grep -q 'install libcairo2' err.txt
ok "and told what to install" $? "$(cat err.txt)"
[ ! -e none.png ]
ok "no file is left" $?
status_is "all else works" 0 env LD_LIBRARY_PATH="$work/library" "$hooke" -c 'run 1 s; plot position; plot position > none.txt; plot position > none.svg'
if command -v readelf >/dev/null; then
    ! readelf -d "$hooke" | grep -q 'NEEDED.*cairo'
    ok "the program is not linked with cairo" $?
else
    n=$((n + 1)); echo "ok $n - the program is not linked with cairo # SKIP readelf is not installed"
fi

echo "1..$n"
exit "$bad"
