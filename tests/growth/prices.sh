#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The prices that `plan` tells, against counts of instructions. LONG=1: quiet runs of six scenes by four methods.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
skip() {
    echo "1..1"
    echo "ok 1 - prices of plan # SKIP $1"
    exit 0
}
[ "${CONFIG:-release}" = release ] || skip "what is counted is optimised code (CONFIG=release)"
command -v valgrind >/dev/null && command -v callgrind_annotate >/dev/null || skip "valgrind is not installed"
command -v python3 >/dev/null || skip "needs python3"
exec python3 tests/growth/prices.py ${LONG:+--long} "$hooke"
