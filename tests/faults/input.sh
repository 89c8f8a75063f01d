#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Data on standard input and in pipes: read whole, to the end, once; refused where commands come from there.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
n=0 bad=0

says() { # name text file
    n=$((n + 1))
    if grep -qF "$2" "$3"; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; sed 's/^/#   /' "$3"; fi
}
awk 'BEGIN { for (i = 0; i < 4000; i++) printf "%.2f\t%.3f\n", 0.01 * i, 20 + 5 * cos(0.09 * i) }' >swing.txt # more than a pipe holds

cat swing.txt | "$hooke" -n -c 'load -' >out.txt 2>&1
says "load - reads a pipe to its end" "4000 rows" out.txt
"$hooke" -n -c 'load - y=2 unit=cm as=swing; save view.hk' <swing.txt >out.txt 2>&1
says "load - reads a file with options" "4000 rows" out.txt
says "save writes the same statement" "load - y=2" view.hk
cat swing.txt | "$hooke" -n view.hk >out.txt 2>&1
says "which a pipe repeats" "4000 rows" out.txt
"$hooke" -n -c 'load /dev/fd/5' 5< <(cat swing.txt) >out.txt 2>&1
says "a pipe is read once, from its beginning" "4000 rows" out.txt
echo 'load -' | "$hooke" -n >out.txt 2>&1
says "commands and data do not share standard input" "standard input already provides the commands" out.txt
sleep 0.3 | "$hooke" -n -c 'load -' >out.txt 2>&1
says "an empty input is said to be empty" "is empty" out.txt
echo "1..$n"
exit "$bad"
