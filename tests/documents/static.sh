#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The static program does the whole lab, byte for byte as the other one does, in a root that holds
# nothing but it and the lab's files: no library, no locale, no terminfo, no /dev, no /proc.
# (tests/terminal/terminal/bare.c types at it there.) The long form runs `selftest` there, too.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
name='the static program'
if [ -z "${STATIC:-}" ]; then
    echo "ok 1 - $name # SKIP none belongs to this build (make static)"
    exit 0
fi
PATH=$PATH:/usr/sbin
enter='chroot'
[ "$(id -u)" -eq 0 ] || enter='unshare -r chroot'
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
root=$work/root
mkdir "$root" "$work/there"
cp "$STATIC" "$root/hooke"
if ! $enter "$root" /hooke --version >"$work/version" 2>"$work/err"; then
    if [ "$(id -u)" -ne 0 ] && ! unshare -r true 2>/dev/null; then
        echo "ok 1 - $name # SKIP neither root nor user namespaces: no other root can be entered"
        exit 0
    fi
fi
n=0 bad=0
ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    [ -z "${3:-}" ] || printf '%s\n' "$3" | head -15 | sed 's/^/#   /'
}

cmp -s "$work/version" <("$hooke" --version)
ok "it starts in an empty root" $? "$(cat "$work/version" "$work/err")"
said=$(LC_ALL=C readelf -lS "$STATIC" | grep -E 'INTERP|DYNAMIC|\.symtab|\.debug')
[ -z "$said" ]
ok "it asks for no interpreter and no library, and is stripped" $? "$said"
size=$(stat -c %s "$STATIC")
[ "$size" -le 7000000 ]
ok "it is one file of at most 7 MB" $? "$size bytes"

lab() { # where, command...
    local where=$1
    shift
    cp examples/lab/* "$where"
    (cd "$where" && env -i PATH="$PATH" LC_ALL=C.UTF-8 "$@" -n --size 80x24 --color never \
        -c 'set timing off' lab.hk >"$work/said" 2>&1)
}
lab "$work/there" "$hooke"
ok "the lab on this system" $? "$(tail -n 5 "$work/said")"
cp "$work/said" "$work/said-there"
for term in xterm-256color screen vt100; do
    rm -rf "${root:?}"/* && cp "$STATIC" "$root/hooke"
    lab "$root" env TERM=$term $enter "$root" /hooke
    ok "the whole lab in the empty root, TERM=$term" $? "$(tail -n 5 "$work/said")"
    cmp -s "$work/said" "$work/said-there"
    ok "says the same there" $? "$(diff "$work/said" "$work/said-there")"
    said=$(rm "$root/hooke" && diff -r "$root" "$work/there")
    [ -z "$said" ] && [ -s "$root/lab-report/report.md" ]
    ok "and writes the same files" $? "$said"
done
if [ -n "${LONG:-}" ]; then
    cp "$STATIC" "$root/hooke"
    said=$(env -i PATH="$PATH" $enter "$root" /hooke -n -c selftest 2>&1)
    ok "selftest passes there" $? "$said"
fi
echo "1..$n"
exit "$bad"
