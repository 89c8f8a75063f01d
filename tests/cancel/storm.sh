#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Many signals in a row while runs are computed and saved: nothing hangs, nothing is lost, the terminal is whole.
# LONG=1: 20 storms of 200 signals at the plain prompt, as many in panes.
set -u
if ! python3 -c 'import pty' 2>/dev/null; then
    echo "ok 1 - storms of signals # SKIP needs python3"; exit 0
fi
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
if [ -n "${LONG:-}" ]; then size="--rounds 20 --signals 200"; else size="--rounds 1 --signals 15"; fi
python3 tests/cancel/storm.py $size "${HOOKE:-build/hooke}" "$folder"
