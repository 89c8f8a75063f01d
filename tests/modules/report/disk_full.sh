#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A report is a whole folder or none: the real program on full devices, outside --safe, without cairo, and with its system calls failing or
# killed there.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
cd "$work" || exit 2
echo 'leak:libfontconfig' >suppressions # it keeps offsets where the leak checker of AddressSanitizer looks for pointers
export LSAN_OPTIONS="suppressions=$work/suppressions:print_suppressions=0${LSAN_OPTIONS:+:$LSAN_OPTIONS}"
n=0 bad=0

ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; [ -n "${3:-}" ] && printf '%s\n' "$3" | sed 's/^/#   /'; fi
}
status_is() { # name wanted command...
    local name=$1 wanted=$2 got
    shift 2
    "$@" >out.txt 2>err.txt
    got=$?
    [ "$got" -eq "$wanted" ]
    ok "$name" $? "status $got, wanted $wanted: $(head -c 300 err.txt)"
}

script='compare euler symplectic-euler; report new'
status_is "a report is written" 0 "$hooke" -c "$script"
mv new expected
status_is "its script gives the same numbers" 0 "$hooke" -f expected/session.hk -c 'report new'
diff -r expected new >diff.txt
ok "and the same bytes" $? "$(head -n 5 diff.txt)"
status_is "an existing folder is not replaced without --force" 4 "$hooke" -c 'run 1 s; report new'
diff -r expected new >diff.txt
ok "it is unchanged" $? "$(head -n 5 diff.txt)"
status_is "with --force it is" 0 "$hooke" -c 'run 1 s; report new --force'
[ ! -e new/run-2.csv ] && [ -e new/run-1.csv ]
ok "by the new one" $?
mkdir mine && echo treasure >mine/thesis.tex
status_is "a folder of something else is not replaced with --force" 4 "$hooke" -c 'run 1 s; report mine --force'
grep -q treasure mine/thesis.tex
ok "what is in it stays" $?
status_is "a report without one of its figures is none" 4 bash -c "ulimit -f 3; exec '$hooke' -c 'run 10 s; report cut'"
grep -q 'cannot write cut/figure-01-.*[.]svg: File too large' err.txt && [ -z "$(ls -d cut .hooke-* 2>/dev/null)" ]
ok "it says which, and nothing is there" $? "$(cat err.txt; ls -A)"
mkdir confined
status_is "--safe confines reports to the current directory" 4 bash -c "cd confined && '$hooke' --safe -c 'run 1 s; report ../escaped'"
[ ! -e escaped ]
ok "nothing escaped" $?
if command -v xmllint >/dev/null; then
    xmllint --html --noout expected/report.html 2>err.txt
    ! grep 'error :' err.txt | grep -qvE 'Tag (figure|section|details|summary) invalid' # HTML 5, which it does not know
    ok "the HTML is well formed" $? "$(head -n 3 err.txt)"
    xmllint --noout expected/*.svg 2>err.txt
    ok "the pictures are XML" $? "$(head -n 3 err.txt)"
else
    n=$((n + 1)); echo "ok $n - the HTML is well formed # SKIP xmllint is not installed"
fi
missing=
for file in $(grep -o '\(href\|src\)="[^"]*"' expected/report.html | grep -v '="data:image/svg' | sed 's/.*="//; s/"//'); do
    [ -s "expected/$file" ] || missing="$missing $file"
done
[ -z "$missing" ]
ok "every link leads to a file" $? "$missing"

mkdir library
echo "no library" >library/libcairo.so.2
status_is "without cairo there is a report all the same" 0 env LD_LIBRARY_PATH="$work/library" "$hooke" -c 'run 1 s; report plain'
ls plain/*.svg >/dev/null 2>&1 && [ ! -s err.txt ]
ok "with its pictures: SVG needs no library" $? "$(cat err.txt)"
rm -rf new plain

# Without cairo, so that each call is one of the writer's: a font that cannot be closed is no torn folder.
export LD_LIBRARY_PATH="$work/library"
rm -rf expected
"$hooke" -c "$script" >/dev/null 2>&1
mv new expected
if ! strace -qq -o /dev/null true 2>/dev/null || [ "${CONFIG:-release}" = asan ]; then
    n=$((n + 1)); echo "ok $n - system calls failing and killed # SKIP strace cannot trace here"
    echo "1..$n"; exit "$bad"
fi
count_of() { # system call: how often the whole program makes it
    strace -f -qq -o trace.txt -e trace="$1" "$hooke" -c "$script" >/dev/null 2>&1
    rm -rf new
    grep -c "^[0-9]* *$1(" trace.txt
}
torn= lies= strays= tries=0
exec 3>&2 2>/dev/null # bash tells of each program that was killed
for call in mkdirat write fsync renameat2 close; do
    most=$(count_of "$call")
    every=$([ -n "${LONG:-}" ] && echo 1 || echo $((most / 4 + 1)))
    for at in $(seq 1 "$every" "$most"); do
        for fault in signal=KILL error=ENOSPC error=EIO; do
            { timeout 120 strace -f -qq -o trace.txt -e trace="$call" -e inject="$call:$fault:when=$at" "$hooke" -c "$script"; } >out.txt 2>err.txt
            status=$?
            tries=$((tries + 1))
            if [ -e new ] && ! diff -r expected new >/dev/null; then torn+="$call#$at:$fault "; fi
            [ "$status" -eq 0 ] && [ ! -e new ] && lies+="$call#$at:$fault "
            [ "$fault" != signal=KILL ] && ls -d .hooke-* >/dev/null 2>&1 && strays+="$call#$at:$fault "
            rm -rf new .hooke-*
        done
    done
done
exec 2>&3
[ -z "$torn" ]; ok "no torn folder in $tries injected faults" $? "$torn"
[ -z "$lies" ]; ok "no success claimed where nothing was written" $? "$lies"
[ -z "$strays" ]; ok "no stray folder after a failure" $? "$strays"
echo "1..$n"
exit "$bad"
