#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Nothing is cut inside a word, a number or a sentence: each word of a small screen stands on the
# same screen at 250x70, or in what was said, and no mark of a cut is drawn.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
n=0 bad=0
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
"$PWD/scripts/make-recordings" "$folder" >/dev/null 2>&1
cd "$folder" || exit 2
cp bare.txt a-recording-with-a-long-name-of-a-file-2026-11-23.txt

spring='set timing off; m = 200 g; k = 15 N/m'
situations=(
    "screenshot"
    "$spring; run; screenshot"
    "$spring; method symplectic-euler; run 10 s; layout plot; screenshot"
    "$spring; compare euler symplectic-euler backward-euler rk4; screenshot"
    "$spring; compare euler rk4; layout quad; screenshot"
    "$spring; method verlet; run 9.6 s; cursor periods 4; screenshot"
    "$spring; method verlet; run 9.6 s; cursor crossing; cursor move 3; screenshot"
    "$spring; method verlet; run 9.6 s; cursor; layout log; screenshot"
    "load bare.txt; screenshot"
    "m = 200 g; load bare.txt; fit; adopt; run; screenshot"
    "m = 200 g; load disk.txt; data window 0:30; fit drag; screenshot"
    "load a-recording-with-a-long-name-of-a-file-2026-11-23.txt; measure period; screenshot"
    "$spring; run; focus spectrum full; screenshot"
    "$spring; run; focus envelope; screenshot"
    "$spring; run; layout stack; screenshot"
    "$spring; method euler dt=300ms; run 100 s; screenshot"
    "scene kepler; method dopri5 tol=1e-9; run 100 s; screenshot"
    "scene robertson; method radau5 tol=1e-8; run 40 s; screenshot"
    "scene pendulum; theta0 = 170 deg; method rk4; run 20 s; layout duo; screenshot"
    "scene duffing-driven; method rk4; run 30 s; window 5 s; screenshot"
    "$spring; run 1 s; name a-name-that-is-long-for-a-run; run 2 s; screenshot"
    "$spring; run 10 s; window 2:4; screenshot"
    "help cursor; screenshot"
    "$spring; run; help; layout log; screenshot"
)

words() { # of a screen: letters, digits and what belongs to numbers; frames and curves are none
    sed 's/[^][A-Za-z0-9_.+/^()=:,|<>…%#-]/ /g; s/[|<]/ /g' | tr ' ' '\n' | sed 's/^[-(:,.]*//; s/[-):,.]*$//' |
        grep -E '[A-Za-z]' | sort -u
}
small() { # words of a small screen that a large one does not have
    comm -23 <(words <"$1" | sed 's/[=(),:]/\n/g' | grep -E '[A-Za-z]' | sort -u) \
        <(words <"$2" | sed 's/[=(),:]/\n/g' | grep -E '[A-Za-z]' | sort -u)
}

screens=0
for charset in ascii braille; do
    for size in 80x24 40x12 60x16; do
        case ${LONG:-}$charset-$size in # the short form: each size once
            ascii-60x16 | ascii-80x24 | braille-40x12) continue ;;
        esac
        i=0
        for situation in "${situations[@]}"; do
            i=$((i + 1)) screens=$((screens + 1))
            "$hooke" -n -k --batch --charset $charset --size $size -c "$situation" 2>said >everything
            tail -n "${size#*x}" everything >screen
            "$hooke" -n -k --batch --charset $charset --size 250x70 -c "$situation" >wide 2>said.wide
            head -n "-${size#*x}" everything | cat - said said.wide >>wide
            echo "last 2 T, equal axes" >>wide # a caption of small phase plots
            cut=$(grep -nE '[^ ](…|>)$' screen | grep -v 'hooke>') # behind a blank: a line that goes on
            lost=$(small screen wide | sed 's/ *[>…]$//' |
                grep -vE '^[0-9.e+-]*(k|m|u|n|M|G)?[A-Za-z]{0,3}$|^[0-9.+]*[ox+*]+$' | tr '\n' ' ')
            if [ "$cut" ] || [ "$lost" ]; then
                n=$((n + 1)) bad=1
                echo "not ok $n - $size $charset, situation $i: $situation"
                [ -z "$cut" ] || printf '%s\n' "$cut" | sed 's/^/#   /'
                [ -z "$lost" ] || echo "#   not whole: $lost"
            fi
        done
    done
done
n=$((n + 1))
echo "ok $n - $screens screens were read"
echo "1..$n"
exit "$bad"
