#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Ctrl-C at random times: the prompt is back within 100 ms, the session is what it was, the next command works.
# LONG=1: 280 commands on 2e6 rows and 1e6 steps; then the same in the program that ends itself where it is late.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
tool=$PWD/tests/cancel
if ! python3 -c 'import pty' 2>/dev/null; then
    echo "ok 1 - Ctrl-C # SKIP needs python3"; exit 0
fi
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
# What is not optimised, or is watched by a sanitizer, has so many times longer.
case ${CONFIG:-release} in release | clang | watch) limit=100 ;; *) limit=500 ;; esac
if [ -n "${LONG:-}" ]; then
    python3 "$tool/latency.py" --tap --limit $limit --trials 10 "$hooke" "$folder" || exit 1
    make -s CONFIG=watch build/watch/hooke >/dev/null || exit 1
    python3 "$tool/latency.py" --tap --limit 1000 --trials 2 build/watch/hooke "$folder"
else
    python3 "$tool/latency.py" --tap --limit $limit --trials 1 --rows 50000 --longest 0.2 --short "$hooke" "$folder"
fi
