#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Habits that make the source hard to read do not spread: scripts/lint-words counts them, limits are in tests/data/words.txt.
set -u
if ! command -v python3 >/dev/null; then
    printf '1..2\nok 1 - counts # SKIP python3 is not installed\nok 2 - findings # SKIP python3 is not installed\n'
    exit 0
fi
tree=$(mktemp -d) || exit 2
trap 'rm -rf "$tree"' EXIT
bad=0
if counts=$(scripts/lint-words 2>&1); then echo "ok 1 - no count is above its limit"; else
    bad=1
    echo "not ok 1 - no count is above its limit"
    grep -v 'limit.*)$' <<<"$counts" | sed 's/^/# /'
    echo "# scripts/lint-words KIND lists the findings of a kind"
fi

# One finding of each kind but two: three quarters of the lines of the header, and the name of a function in four files.
mkdir -p "$tree"/{src,include,tests/data}
cat >"$tree/src/one.c" <<'END'
#define LADDER 3 /* Of a spectrum: its lines. */
#define LADDER_STEPS 4
#define ROW(x) x
/* At the edge of the range. */
static int next_state(int state)
{
    return state > 1 ? 1 : state < 0 ? 0 : state;
}
/* Whether it fits. */
int fits(int from, int begin)
{
    return from < begin && puts("nobody has set the duration"); /* -1: none */
}
/* Is it there? "No?" is not asked. */
END
for copy in two three four; do grep -A3 '^static' "$tree/src/one.c" | sed 's/ ? 1.*/;/' >"$tree/src/$copy.c"; done
printf '/* Returns x. x: a length */\nint header_function(int x);\nint y;\nint z;\n' >"$tree/include/one.h"
kinds="macros statics short of openings relatives questions telegrams phrases prepositions conditionals bare"
for kind in $kinds; do echo "$kind 0"; done >"$tree/tests/data/words.txt"
found=$(cd "$tree" && "$OLDPWD/scripts/lint-words")
got=$(awk '{printf "%s%s", sep, ($1 ~ /^(prep|cond|bare)/ ? ($2 > 0 ? "some" : "none") : $2) ($NF == "ABOVE" ? "" : " allowed"); sep = " "}' <<<"$found")
if [ "$got" = "1 1 1 1 1 1 1 1 1 some some some" ]; then echo "ok 2 - each kind is found, and fails above its limit"; else
    bad=1
    echo "not ok 2 - each kind is found, and fails above its limit"
    sed 's/^/# /' <<<"$found"
fi
echo 1..2
exit $bad
