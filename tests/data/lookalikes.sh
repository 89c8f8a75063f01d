#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The look-alikes of every format are what their generator makes.
set -u
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
scripts/make-recordings --formats "$folder"
n=0 bad=0
for file in "$folder"/*; do
    n=$((n + 1))
    if cmp -s "$file" "tests/fuzz/corpus/recording/${file##*/}"; then
        echo "ok $n - ${file##*/}"
    else
        bad=1
        echo "not ok $n - ${file##*/} differs from what scripts/make-recordings --formats makes"
    fi
done
echo "1..$n"
exit $bad
