#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Sources are as `make format` leaves them. Versions of clang-format differ, so the one that the tree was formatted by judges.
echo 1..1
if ! clang-format --version 2>/dev/null | grep -q ' version 14\.'; then
    echo "ok 1 - sources are formatted # SKIP clang-format 14 is not installed"
    exit 0
fi
off=$(find src include tests examples -name '*.[ch]' | xargs clang-format --dry-run -Werror 2>&1 | grep -oE '^[^:]+:[0-9]+' | sort -u | head -n 10)
if [ -z "$off" ]; then echo "ok 1 - sources are formatted"; else
    echo "not ok 1 - sources are formatted"
    sed 's/^/#   /' <<<"$off"
    exit 1
fi
