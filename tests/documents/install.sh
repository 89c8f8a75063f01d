#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# `make install` brings the program, the library, its headers, the manual, the examples with their
# recordings and the completion, for everyone; what is installed works from another folder; `make
# uninstall` leaves nothing.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
top=$(dirname "$hooke")
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

# The build that is under test, as it is.
building=(TOP="${top#"$PWD/"}" CONFIG="${CONFIG:-release}" DESTDIR="$work/root" PREFIX=/opt/hooke)
case $top in */plain | */plain-*) building+=(OPTIONAL=no) ;; esac
mkdir "$work/root"
said=$(umask 077 && make -s "${building[@]}" install 2>&1)
ok "make install" $? "$said"

there=$work/root/opt/hooke
missing=
for file in bin/hooke lib/libhooke.{a,so,so.0} lib/pkgconfig/hooke.pc include/hooke/hooke.h share/bash-completion/completions/hooke \
    share/vim/vimfiles/{syntax,ftdetect}/hooke.vim share/nano/hooke.nanorc \
    share/man/man1/hooke.1 share/man/man7/hooke-{language,methods,lab}.7 \
    share/hooke/examples/lab/{bare,disk}.txt; do
    [ -s "$there/$file" ] || missing+="$file "
done
shopt -s globstar
for layer in base result scene method run data analysis figure study; do
    for file in include/hooke/$layer.h include/hooke/$layer/*.h; do
        [ ! -e "$file" ] || cmp -s "$file" "$there/$file" || missing+="$file "
    done
done
for file in examples/**; do
    [ -d "$file" ] || cmp -s "$file" "$there/share/hooke/$file" || missing+="$file "
done
[ -z "$missing" ]
ok "everything is there" $? "missing: $missing"
closed=$(find "$there" ! -perm -o=r)
[ -z "$closed" ]
ok "and everyone can read it, whatever the umask" $? "$closed"

# Elsewhere, with nothing of the source tree in reach, by the installed program; the library's headers need nothing else.
mkdir "$work/elsewhere"
cat >"$work/elsewhere/user.c" <<'C'
#include <hooke/hooke.h>
#include <stdio.h>

int main(void)
{
    return printf("%zu methods\n", method_catalog.count) < 0;
}
C
said=$(cd "$work/elsewhere" && ${CC:-gcc} -std=c11 -I"$there/include" user.c -c -o user.o 2>&1)
ok "a program compiles with the installed headers" $? "$said"
export PATH=$there/bin:$PATH
failed=
for example in lab/lab tour typed/return-map typed/vanderpol; do
    script=$there/share/hooke/examples/$example.hk
    said=$(cd "$work/elsewhere" && hooke --batch --safe "$script" 2>&1) ||
        grep -q 'built without cairo' <<<"$said" || failed+="$example: $(tail -n 3 <<<"$said")"$'\n'
done
[ -z "$failed" ]
ok "installed examples run from another folder" $? "$failed"
[ -s "$work/elsewhere/lab-report/report.md" ] && [ -s "$work/elsewhere/second-session.csv" ]
ok "and write into it" $? "$(ls "$work/elsewhere")"

# Completion, as bash calls it.
completed() { # the words up to the cursor
    HOME=$work bash --norc -c '
        . "$1"
        shift
        COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
        _hooke
        printf "%s\n" "${COMPREPLY[@]}"' \
        bash "$there/share/bash-completion/completions/hooke" "$@" 2>"$work/err"
}
commands=$(hooke --format json -c 'list commands' |
    sed -E 's/^\{"kind":"command","name":"([^"]*)".*/\1/')
[ -n "$commands" ] && [ "$(completed hooke -c '')" = "$commands" ]
ok "after -c every command of the catalog is completed" $? \
    "$(completed hooke -c '' | diff - <(echo "$commands"); cat "$work/err")"
[ "$(completed hooke -c "'m = 200 g; meas")" = "m = 200 g; measure" ]
ok "and at the statement that stands last" $? "$(completed hooke -c "'m = 200 g; meas")"
missing=
for option in $(hooke --help | grep -oE -- '^ +-.*' | sed -E 's/  [a-z"].*//' |
    grep -oE -- '-{1,2}[A-Za-z][a-z-]*'); do
    completed hooke - | grep -qxFe "$option" || missing+="$option "
done
[ -z "$missing" ] && [ "$(completed hooke - | wc -l)" -ge 25 ]
ok "every option is completed" $? "missing: $missing"
[ "$(completed hooke --charset b)" = $'block\nbraille' ] &&
    [ "$(completed hooke --format j)" = json ]
ok "and what options take" $? "$(completed hooke --charset b)"
said=$(cd "$work/elsewhere" && touch mine.hk && completed hooke m && completed hooke -f l)
[ "$said" = $'mine.hk\nlab-report' ]
ok "and command files" $? "$said"

said=$(make -s "${building[@]}" uninstall 2>&1)
ok "make uninstall" $? "$said"
left=$(find "$work/root" ! -type d; find "$work/root" -name 'hooke' -path '*/*/opt/hooke/*/*')
[ -z "$left" ]
ok "leaves nothing" $? "$left"
echo "1..$n"
exit "$bad"
