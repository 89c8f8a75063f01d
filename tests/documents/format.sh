#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Sources are as `make format` leaves them. Versions of clang-format differ, so the one that the tree was formatted by judges.
echo 1..1
if ! clang-format --version 2>/dev/null | grep -q ' version 14\.' || ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
    echo "ok 1 - sources are formatted # SKIP no clang-format 14, or no repository"
    exit 0
fi
off=$(git ls-files '*.c' '*.h' | xargs clang-format --dry-run -Werror 2>&1 | grep -oE '^[^:]+:[0-9]+' | sort -u | head -n 10)
if [ -z "$off" ]; then echo "ok 1 - sources are formatted"; else
    echo "not ok 1 - sources are formatted"
    sed 's/^/#   /' <<<"$off"
    exit 1
fi
