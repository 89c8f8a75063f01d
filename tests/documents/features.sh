#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Nothing that users and their scripts can name appears or disappears without a line in features.txt, or in that of a module.
set -u
now=$(mktemp) && agreed=$(mktemp) || exit 2
trap 'rm -f "$now" "$agreed"' EXIT
# A word of a module's command that another module brings is in the file of that one, whether the command is in or not.
scripts/features agreed | awk '$1 == "command" {has[$2]} $1 != "word" || $2 in has' >"$agreed" && scripts/features >"$now" || { echo "not ok 1 - scripts/features"; exit 1; }
n=0 bad=0
check() { # title lines
    n=$((n + 1))
    if [ -z "$2" ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    head -n 20 <<<"$2" | sed 's/^/# /'
    echo "# where it is meant: scripts/features update"
}
# CVODE's methods are there where SUNDIALS is installed.
check "no feature has disappeared" "$(LC_ALL=C comm -23 "$agreed" "$now" | grep -v '^method cvode-')"
check "every feature is in the list" "$(LC_ALL=C comm -13 "$agreed" "$now" | grep -v '^method cvode-')"
exit $bad
