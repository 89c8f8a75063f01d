# SPDX-License-Identifier: GPL-3.0-or-later
# What guesses.sh and tasks.sh share: TAP, and what the program answers.
count=0
ok() { count=$((count + 1)); echo "ok $count - $1"; }
bad() { count=$((count + 1)); echo "not ok $count - $1"; printf '%s\n' "$2" | tail -n 8 | sed 's/^/#   /'; }

# ask ARRAY SIZE [SKIPPED]: one process says what it thinks of each of them in turn, always from the same start. Into answer; of lines
# that begin with SKIPPED nothing.
ask() {
    local -n statements=$1
    local i line
    for i in "${!statements[@]}"; do
        printf 'restore start\necho @@ %d\n%s\necho @@ 0\n' "$((i + 1))" "${statements[i]}"
    done >statements
    answer=()
    i=0
    while IFS= read -r line; do
        if [[ $line == '@@ '* ]]; then i=${line#@@ }
        elif [[ -z ${3:-} || $line != "$3"* ]]; then answer[i == 0 ? ${#statements[@]} : i - 1]+="$line "$'\n'; fi
    done < <("$hooke" -n -k --size "$2" -c 'checkpoint start' statements 2>&1)
}
