#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The report of both sessions of the lab: every number of its table of values is found again in what its session.hk says when it is run,
# nothing is loaded from outside, and its LaTeX compiles where there is one.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
lab=$(realpath examples/lab)
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
cp "$lab"/*.hk "$lab"/*.txt .
n=0 bad=0

ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; [ -n "${3:-}" ] && printf '%s\n' "$3" | head -n 8 | sed 's/^/#   /'; fi
}
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; }

sed -i '/^report/d' lab.hk
printf '%s\n' 'note \input{x} $a$ %b & _d' 'report new --latex' >>lab.hk
"$hooke" -f lab.hk >out.txt 2>err.txt
ok "the lab has a report" $? "$(tail -n 3 err.txt)"
! grep -q 'not included' out.txt
ok "that lacks nothing" $? "$(grep 'not included' out.txt)"

# Parameters are looked up where they hold: after each statement.
awk '{ print } !/^#/ { print "show all" }' new/session.hk >asked.hk
for run in 1 2 3 4; do echo "measure energy of run $run"; done >>asked.hk
"$hooke" --format json -f asked.hk 2>/dev/null | grep -oE '[-0-9.e+]+' | sort -u >said.txt
# name,value,uncertainty,unit,t [s],of,source,…: a frequency of a fit is its omega / 2 pi, tau is 2 / gamma.
awk -F, 'NR == FNR { said[$1] = 1; next }
    /^#/ || $1 == "name" { next }
    { n++ }
    $1 == "omega" { omega[$6 $7 $8] = $2 }
    $1 == "gamma" { gamma[$6, $2] = 1 }
    # The uncertainties of the halves are in the text of the fit, not in its record.
    ($2 in said) && ($3 == "" || $3 == 0 || ($3 in said) || $1 ~ /^gamma of the/) { next }
    $1 == "frequency" { later[NR] = $0; next }
    $1 == "tau" { later[NR] = $0; next }
    { print "not said: " $0 }
    END {
        for (i in later) {
            split(later[i], v, ",")
            found = 0
            if (v[1] == "frequency") { d = v[2] * 2 * 3.14159265358979323846 / omega[v[6] v[7] v[8]] - 1; found = d < 1e-12 && d > -1e-12 }
            else for (k in gamma) { split(k, g, SUBSEP); d = g[2] * v[2] / 2 - 1; found = found || (g[1] == v[6] && d < 1e-12 && d > -1e-12) }
            if (!found) print "not said: " later[i]
        }
        if (n < 90) print "only " n " values"
    }' said.txt new/values.csv >missing.txt
[ ! -s missing.txt ] && [ -s new/values.csv ]
ok "every value is said again by session.hk" $? "$(cat missing.txt)"
# The line of each is the one that it names.
awk -F'\t' 'NR == FNR { line[FNR] = $0; next } { if (index(line[$1], $2) != 1) print }' new/session.hk \
    <(grep -oE ',[0-9]+,[^,"]+$' new/values.csv | sed 's/^,//; s/,/\t/') >wrong.txt
[ ! -s wrong.txt ] && [ "$(grep -cE ',[0-9]+,' new/values.csv)" -gt 80 ]
ok "on the line that the table gives" $? "$(cat wrong.txt)"
# No value is printed with more digits than its uncertainty has: both end at the same place.
grep -oE '[0-9.]+ ± [0-9.]+' new/report.md | awk '{
    a = index($1, ".") ? length($1) - index($1, ".") : 0
    b = index($3, ".") ? length($3) - index($3, ".") : 0
    if (a != b) print
    n++
} END { if (n < 50) print "only " n + 0 }' >digits.txt
[ ! -s digits.txt ]
ok "values end where their uncertainties do" $? "$(cat digits.txt)"
! grep -q '^#.*_' new/report.md
ok "headings are words, not names of the source" $? "$(grep '^#.*_' new/report.md)"
! grep -qE '[0-9]*[.][0-9]{9,}' new/report.md
ok "and none has nine decimals" $? "$(grep -E '[0-9]*[.][0-9]{9,}' new/report.md)"

loads=$(grep -oE '(src|href|url)[=(]"?[^" )>]{1,40}' new/report.html | grep -vE '^src="data:image/svg|^href="[A-Za-z0-9-]+[.](csv|hk)')
[ -z "$loads" ]
ok "the HTML loads nothing" $? "$loads"
empty=$(grep -oE '<img alt="[^"]{0,60}' new/report.html | awk 'length($0) < 60')
[ -z "$empty" ] && [ "$(grep -c '<img' new/report.html)" -gt 10 ]
ok "its figures have words" $? "$empty"
grep -oE '<h[1-6]' new/report.html | tr -dc '1-6\n' | awk '$1 > last + 1 { print "h" $1 " after h" last } { last = $1 }' >order.txt
[ ! -s order.txt ] && grep -q '<html lang="en">' new/report.html
ok "its headings are in order, its language is said" $? "$(cat order.txt)"

! grep -qF '\input' new/report.tex
ok "nothing typed is a command of LaTeX" $?
if ! ls new/*.pdf >/dev/null 2>&1; then
    grep -q 'text only' err.txt
    ok "without cairo the figures of the LaTeX are text, and it says so" $?
fi
opened=$(grep -oE '\\begin[{][a-z]+' new/report.tex | wc -l) closed=$(grep -oE '\\end[{][a-z]+' new/report.tex | wc -l)
[ "$opened" -eq "$closed" ] && [ "$(grep -cE '\\SI[{][-0-9.e+ ]+[}][{]' new/report.tex)" -gt 50 ]
ok "the LaTeX closes what it opens and has its values by siunitx" $? "$opened $closed"
if command -v pdflatex >/dev/null && kpsewhich siunitx.sty longtable.sty booktabs.sty >/dev/null 2>&1; then
    (cd new && timeout 400 pdflatex -interaction=nonstopmode -halt-on-error report.tex >../tex.log 2>&1)
    ok "it compiles" $? "$(grep -A3 '^!' tex.log)"
else
    skip "it compiles" "no pdflatex with siunitx"
fi
echo "1..$n"
exit "$bad"
