#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Sources are as `make format` leaves them. Versions of clang-format differ, so the one that the tree was formatted by judges. What a
# trial leaves does not get into the tree.
echo 1..2
known='^(\.ci|include|src|tests|examples|scripts)/|^(\.clang-format|\.gitignore|LICENCE|Makefile|README\.md)$'
if stray=$(git ls-files 2>/dev/null) && [ "$stray" ]; then
    stray=$( (grep -vE "$known"; grep -E '^tests/cli/' <<<"$stray" | grep -v '\.hk$') <<<"$stray")
    [ "$stray" ] && echo "not ok 1 - files of unknown use in the tree: ${stray//$'\n'/ }" || echo "ok 1 - nothing stray in the tree"
else echo "ok 1 - nothing stray in the tree # SKIP not a git tree"; fi
if ! clang-format --version 2>/dev/null | grep -q ' version 14\.'; then
    echo "ok 2 - sources are formatted # SKIP clang-format 14 is not installed"
    exit 0
fi
off=$(find src include tests examples -name '*.[ch]' | xargs clang-format --dry-run -Werror 2>&1 | grep -oE '^[^:]+:[0-9]+' | sort -u | head -n 10)
if [ -z "$off" ]; then echo "ok 2 - sources are formatted"; else
    echo "not ok 2 - sources are formatted"
    sed 's/^/#   /' <<<"$off"
fi
[ -z "$off" ] && [ -z "${stray:-}" ]
