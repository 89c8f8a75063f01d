#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What editors and the shell know of command files comes from the rows: vim colours what stands where,
# bash knows what completes, nano takes its file without a complaint. Editors that are not there are
# left out, with a word.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
n=0 bad=0
ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    [ -z "${3:-}" ] || printf '%s\n' "$3" | head -15 | sed 's/^/#   /'
}
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; }

for kind in bash vim nano; do
    scripts/reference $kind "$hooke" >"$work/hooke.$kind"
    ok "the file of $kind is written" $?
done
cp "$work/hooke.nano" "$work/hooke.nanorc"

cat >"$work/example.hk" <<'HK'
# of the lab
load bare.txt; m = 200.0 +- 0.1 g
method symplectic-euler dt=10ms
set gamma 0.2 1/s # weak
scene duffing-driven
x' = v - 2*sin(3*t); run --steps 20
event high when z > 40 do 'print t'
note "run 3 m"
runs = 3; compare euler rk4
HK
# LINE COLUMN GROUP (as :echo synIDattr(synID(...)) says it; - is none)
cat >"$work/wanted" <<'WANTED'
1 3 Comment
2 1 Command
2 6 -
2 16 Value
2 20 Number
2 33 Unit
3 1 Command
3 8 Method
3 15 Method
3 25 Value
3 28 Number
3 30 Unit
4 1 Command
4 5 Value
4 15 Unit
4 19 Comment
5 1 Command
5 7 Scene
5 16 Scene
6 1 -
6 6 -
6 12 Function
6 16 Number
6 22 Command
6 26 Option
6 34 Number
7 1 Command
7 28 Command
8 6 Text
8 7 Text
9 1 -
9 11 Command
9 19 Method
9 25 Method
WANTED
if command -v vim >/dev/null && vim --version | grep -q '+syntax'; then
    mkdir -p "$work/rt/syntax" && cp "$work/hooke.vim" "$work/rt/syntax"
    cat >"$work/ask.vim" <<'VIM'
set nocompatible
let &runtimepath = $WORK . '/rt,' . $VIMRUNTIME
syntax on
edit $WORK/example.hk
set syntax=hooke
let said = []
for line in readfile($WORK . '/wanted')
  let [l, c] = split(line)[0:1]
  let name = synIDattr(synID(l, c, 1), 'name')
  call add(said, l . ' ' . c . ' ' . (name ==# '' || name ==# 'hookeName' ? '-' : substitute(name, '^hooke', '', '')))
endfor
call writefile(said, $WORK . '/groups')
qall!
VIM
    said=$(WORK=$work HOME=$work timeout 240 vim -e -s -N -u NONE -i NONE -S "$work/ask.vim" 2>&1 </dev/null)
    ok "vim takes the syntax" $? "$said"
    said=$(diff "$work/wanted" "$work/groups" 2>&1)
    ok "and has each of $(wc -l <"$work/wanted") places in its group" $? "$said"
    # Every row is known: a file of each kind's names, one a line.
    "$hooke" --format json -c 'list commands' | sed -E 's/.*"name":"([^"]*)".*/\1 x/' >"$work/example.hk"
    awk '{print NR, 1, "Command"}' "$work/example.hk" >"$work/wanted"
    WORK=$work HOME=$work timeout 240 vim -e -s -N -u NONE -i NONE -S "$work/ask.vim" >/dev/null 2>&1 </dev/null
    said=$(diff "$work/wanted" "$work/groups" 2>&1)
    [ -z "$said" ] && [ "$(wc -l <"$work/groups")" -gt 80 ]
    ok "all commands are commands there" $? "$said"
else
    skip "vim's syntax" "vim with +syntax is not installed"
fi

said=$(cd "$work" && touch mine.hk && HOME=$work bash --norc -c '
    . ./hooke.bash && complete -p hooke && complete -p hooke | grep -q "_hooke hooke"
    COMP_WORDS=(hooke -c "comp") COMP_CWORD=2 && _hooke 2>/dev/null && echo "${COMPREPLY[@]}"' 2>&1)
[ "$said" = $'complete -F _hooke hooke\ncompare' ]
ok "bash completes by it" $? "$said"

if command -v nano >/dev/null && command -v script >/dev/null; then
    nano_says() { # what it writes to its terminal, with that file of rules
        (while sleep 0.3; do printf '\030'; done) 2>/dev/null | HOME=$work TERM=vt100 timeout 120 \
            script -qec "nano -f $1 $work/example.hk" /dev/null 2>&1
    }
    said=$(nano_says "$work/hooke.nanorc")
    [ -n "$said" ] && ! grep -qiE 'mistake|error|bad regex|not understood' <<<"$said"
    ok "nano takes its syntax" $? "$said"
    sed 's/^color cyan .*/color cyan "(("/' "$work/hooke.nanorc" >"$work/wrong.nanorc"
    nano_says "$work/wrong.nanorc" | grep -qiE 'mistake|error|bad regex|not understood'
    ok "as it would not where a pattern is wrong" $?
else
    skip "nano's syntax" "nano is not installed"
fi
echo "1..$n"
exit "$bad"
