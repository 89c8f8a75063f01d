#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# export scene: programs of fixed steps in C print the bits of hooke's own steps where the equations call no functions of a
# library and are not solved by iteration, else they agree to 1e-13 of the amplitude, as those in Python and for Octave do.
# Programs whose steps follow the error agree to what they tolerate. XPPAUT agrees to what it prints, the LaTeX compiles. A
# sample; the long form takes every scene by six methods of fixed steps and by three whose steps follow the error, and
# typed ones. PROGRAMS=FILE keeps the table of differences.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
table=$(realpath -m "${PROGRAMS:-/dev/null}")
n=0 bad=0
ok() { n=$((n + 1)); if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; fi; }
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; }
have() { command -v "$1" >/dev/null; }
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
: >"$table"

declare -A typed=(
    [lorenz]="param s = 10; param r = 28; param b = 2.5; var x = 1; var y = 1; var z = 1; x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z"
    [coupled]="param k = 2; param c = 0.3; param a = 1.5; var y1 = 1; var y2 = 0; y1'' = -k*y1 - c*(y1 - y2); y2'' = -k*y2 + c*(y1 - y2) - a*y2^3 - 0.1*y2'"
    [driven-typed]="param w = 1.3; param gamma = 0.2; var q = 0.5; observe r = hypot(q, 1); q'' = -sin(q)/r - gamma*q' + exp(-q^2)*cos(w*t)"
    [whole]="param mu = 5; param off = 0; var u = 2; u'' = mu*(1 - u^2)*u' - u^1.5*off - u/(1 + u^4)^0.25"
    [pushed]="scene spring; gamma = 0.1; param p = 3; force -p*y^3 + 0.2*sin(2*t) - 0.01*y'*y^2"
    [words]="param weight = 2; param control = 1; param good = 0.7; param turn = 3; param state = 1.1; var inside = 1; inside'' = -weight*inside - control*good*inside' - turn*step(state) + sin(inside)"
    [single]="var x = 1; x' = -x^3 + sin(t)"
    [late]="scene driven; t0 = 100 s; gamma = 0.2; force -0.3*abs(v)*v"
    [worded]="param int = 2; param lambda = 1; param length = 0.7; var i = 1; i'' = -int*i - lambda*tanh(i)*log(1 + length + i^2) - atan2(i, 2)"
)
methods='euler symplectic-euler backward-euler verlet rk4 dopri5'
adaptive='dopri5 tsit5 bogacki-shampine'
sample='spring:euler driven:verlet duffing:backward-euler kepler:dopri5 drag:rk4 pushed:rk4'
adapted='drag:dopri5 driven-typed:dopri5 kepler:tsit5'
if [ -n "${LONG:-}" ]; then
    sample='' adapted=''
    for scene in $("$hooke" -n -c "list scenes" | awk '{print $1}') "${!typed[@]}"; do
        for method in $methods; do sample="$sample $scene:$method"; done
        for method in $adaptive; do adapted="$adapted $scene:$method"; done
    done
fi

# Rows of two files that differ; the largest difference over the largest number; how many rows each has.
compare() { # hooke's columns, the program's
    awk -F, '
        /^#/ { next }
        FNR == NR { if (rows++ > 0) line[rows] = $0; next }
        { if (other++ == 0) next
          if (other > rows) next
          split(line[other], a, ",")
          same = 1
          for (i = 1; i <= NF; i++) {
              x = a[i] + 0; y = $i + 0
              if (sprintf("%.17g", x) != sprintf("%.17g", y)) same = 0
              size = x < 0 ? -x : x; off = x - y; off = off < 0 ? -off : off
              if (i > 1 && size > largest) largest = size
              if (i > 1 && off > most) most = off
          }
          differ += !same }
        END { printf "%d %.2g %d %d\n", differ, (largest > 0 ? most/largest : 0), rows, other }' "$1" "$2"
}

# The largest difference that a program may have, of the largest number. What a scene does to roundings by itself: a planet
# that falls into its sun, steps that are unstable.
tolerated() { # scene method
    case $1:$2 in
    kepler:backward-euler) echo 1e-11 ;;
    kepler* | stiff-*) echo 1e-12 ;;
    *) echo 1e-13 ;;
    esac
}
own_columns() { cut -d, -f"1-$(head -1 "$2" | awk -F, '{print NF}')" "$1"; }
refused() { # name, words of the reason
    reason=$(grep -m 1 -E 'error|warning' "$1.said" | sed 's/.*\(error\|warning\): //' | cut -c 1-100)
    echo "$1 refused: $reason" >>"$table"
    [ -n "$reason" ] && grep -qE "$2" "$1.said"
    ok "$1 is refused with a reason ($reason)" $?
}

# Steps of 10 ms for a while, one by one; where a method does not apply hooke itself refuses.
one() { # scene method
    local made=${typed[$1]:-scene $1} name=$1-$2 most
    most=$(tolerated "$1" "$2")
    {
        echo "${made//;/$'\n'}"
        printf '%s\n' "duration = ${LONG:+1}2.003 s" "method $2 dt=10ms" "set record all" "set kernel specialised" "export scene $name.c" \
            "export scene $name.py" "export scene $name.m" "run" "export $name.csv"
    } >"$name.hk"
    "$hooke" -n -q -k "$name.hk" >"$name.said" 2>&1
    if [ ! -e "$name.c" ]; then
        refused "$name" "is for equations of motion|velocity-dependent force|not written as a program|goes through|knows no such drag"
        return
    fi
    gcc -std=gnu11 -O2 -Wall -Wextra -Werror -ffp-contract=off -o "$name" "$name.c" -lm 2>"$name.gcc"
    ok "$name.c compiles without a warning" $?
    "./$name" >"$name.out" 2>/dev/null
    own_columns "$name.csv" "$name.out" >"$name.own"
    found=$(compare "$name.own" "$name.out")
    echo "$name C $found" >>"$table"
    if [ "$2" = backward-euler ] || grep -qE '\b(a?(sin|cos|tan)h?|atan2|exp|expm1|log|log10|pow|cbrt|hypot)\(' "$name.c"; then
        awk -v tolerated="$most" '{exit !($2 <= tolerated && $3 == $4 && $3 > 1)}' <<<"$found"
        ok "$name.c: to $most (differ, most, rows: $found)" $?
    else
        # Unstable steps may end a row earlier: hooke's velocities may grow a little further.
        awk '{exit !($1 == 0 && $3 - $4 <= ("'"$1"'" ~ /^stiff/) && $4 > 1)}' <<<"$found"
        ok "$name.c: hooke's bits (differ, most, rows: $found)" $?
    fi
    for language in Python Octave; do
        case $language in
        Python) have python3 && python3 "$name.py" >"$name.pout" 2>"$name.perr" || continue ;;
        Octave) [ -n "${LONG:-}" ] && have octave-cli && [ -e "$name.m" ] || continue
            octave-cli -q "$name.m" >"$name.pout" 2>"$name.perr" </dev/null ;;
        esac
        found=$(compare "$name.own" "$name.pout")
        echo "$name $language $found" >>"$table"
        awk -v tolerated="$most" '{exit !($2 <= tolerated && $4 > 1)}' <<<"$found"
        ok "$name in $language: to $most (differ, most, rows: $found)" $?
    done
}

# Steps that follow the error: C has the method's own pair, Python and Octave have those of their libraries, with the same
# tolerance of each step. The rows at even times are compared.
follows() { # scene method
    local made=${typed[$1]:-scene $1} name=$1-$2-tol duration="${LONG:+1}2.003 s" interval='70 ms' tol=1e-9 most=1000
    [ "$2" = bogacki-shampine ] && tol=1e-6
    # A planet close to its sun, stiff springs of a pendulum and chaos make ten times more of an error than others do.
    case $1 in kepler-eccentric | extreme-* | stiff-elastic-* | lorenz) most=10000 ;; esac
    # Stability, not the tolerance, makes steps of stiff scenes short: a second of them would take minutes.
    case $1 in
    stiff-spring | stiff-damped) duration='0.1003 ms' interval='1 us' ;;
    stiff-vanderpol-1e6) duration='1.003 ms' interval='30 us' ;;
    prothero-robinson) duration='10.03 ms' interval='0.1 ms' ;;
    stiff-* | extreme-wall) duration='2.003 s' ;;
    esac
    {
        echo "${made//;/$'\n'}"
        printf '%s\n' "duration = $duration" "method $2 tol=$tol" "set record every $interval" "export scene $name.c" \
            "export scene $name.py" "export scene $name.m" "method dop853 tol=1e-13" run "export $name.csv"
    } >"$name.hk"
    "$hooke" -n -q -k "$name.hk" >"$name.said" 2>&1
    if [ ! -e "$name.c" ]; then
        refused "$name" "turns, sticks and breaks away|jump or bend"
        return
    fi
    gcc -std=gnu11 -O2 -Wall -Wextra -Werror -o "$name" "$name.c" -lm 2>"$name.gcc"
    ok "$name.c compiles without a warning" $?
    for language in C Python Octave; do
        case $language in
        C) "./$name" >"$name.out" 2>/dev/null ;;
        Python) python3 -c 'import scipy' 2>/dev/null || continue
            python3 "$name.py" >"$name.out" 2>"$name.perr" ;;
        Octave) [ -n "${LONG:-}" ] && have octave-cli || continue
            octave-cli -q "$name.m" >"$name.out" 2>"$name.perr" </dev/null ;;
        esac
        own_columns "$name.csv" "$name.out" >"$name.own"
        found=$(compare "$name.own" "$name.out")
        echo "$name $language $found" >>"$table"
        awk -v most=$most -v tol=$tol '{exit !($2 <= most*tol && $3 == $4 && $4 > 1)}' <<<"$found"
        ok "$name in $language: to $most tolerances (differ, most, rows: $found)" $?
    done
}

if have gcc; then
    have python3 || skip "the same in Python" "python3 is not installed"
    for pair in $sample; do one "${pair%%:*}" "${pair##*:}"; done
    for pair in $adapted; do follows "${pair%%:*}" "${pair##*:}"; done
else
    skip "programs in C and Python" "gcc is not installed"
fi

# Where C goes on with an infinity, Python's functions raise: the rows up to there are printed all the same.
if have python3; then
    printf '%s\n' "var x = 1" "x' = exp(x)" "duration = 2 s" "method rk4 dt=10ms" "set record all" "export scene blow.py" run \
        "export blow.csv" >blow.hk
    "$hooke" -n -q -k blow.hk >/dev/null 2>&1
    python3 blow.py >blow.pout 2>blow.perr
    found=$(compare <(cut -d, -f1,2 blow.csv) blow.pout)
    [ "${found#* }" = "0 39 39" ] && grep -q "diverged after t = 0.37" blow.perr
    ok "a solution that ends at t = 0.37 s in Python (differ, most, rows: $found)" $?
fi

# ---- other languages ----

state() { tail -n 1 "$1" | tr ',' ' '; }
close() { # two lines of numbers, tolerance
    awk -v a="$1" -v b="$2" -v tol="$3" 'BEGIN { k = split(a, x, " "); if (split(b, y, " ") < k) exit 1
        for (i = 1; i <= k; i++) { d = x[i] - y[i]; if (d < 0) d = -d; s = x[i] < 0 ? -x[i] : x[i]; if (d > tol*(1 + s)) exit 1 } }'
}
"$hooke" -n -q -c 'scene pendulum-driven; duration = 2 s; method rk4 dt=10ms; run; export own.csv t,theta,rate; export scene p.m; export scene p.ode; export scene p.tex' >/dev/null
ok "a scene for Octave, XPPAUT, LaTeX" $?
if [ -z "${LONG:-}" ]; then
    skip "Octave has the same end" "seconds to start: in the long form"
elif have octave-cli; then
    octave-cli -q p.m >p.out 2>p.err </dev/null
    close "$(state own.csv)" "$(state p.out)" 1e-13
    ok "Octave has the same end" $?
    "$hooke" -n -q -c 'scene duffing; duration = 3 s; method dopri5 tol=1e-9; run; export own45.csv t,y,v; export scene p45.m' >/dev/null
    octave-cli -q p45.m >p45.out 2>p45.err </dev/null
    close "$(state own45.csv)" "$(state p45.out)" 1e-6
    ok "ode45 has the same end" $?
else
    skip "Octave has the same end" "without octave-cli, an optional judge"
fi
if have xppaut; then
    timeout 120 xppaut p.ode -silent -outfile p.dat >/dev/null 2>&1 </dev/null
    close "$(state own.csv)" "$(state p.dat)" 1e-6
    ok "XPPAUT has the same end" $?
else
    skip "XPPAUT has the same end" "without xppaut, an optional judge"
fi
if have pdflatex && kpsewhich siunitx.sty >/dev/null; then
    "$hooke" -n -q -c "${typed[driven-typed]}; export scene q.tex" >/dev/null
    for name in p q; do
        timeout 240 pdflatex -interaction=batchmode $name.tex >/dev/null 2>&1 </dev/null
        ok "the equations compile ($name.tex)" $?
    done
else
    skip "the equations compile" "no pdflatex with siunitx"
fi
echo "1..$n"
exit "$bad"
