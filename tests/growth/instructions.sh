#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Ten times the work costs at most twelve times the instructions, start-up left out: what the last line, row or point costs is what the
# first one cost. Counted by valgrind, not timed.
#   instructions.sh [ROW:COUNT...]
set -u
limit=12
hooke=$(realpath "${HOOKE:-build/hooke}")
skip_all() { echo "ok 1 - growth of instructions # SKIP $1"; echo 1..1; exit 0; }
[ "${CONFIG:-release}" = asan ] && skip_all "not under the sanitizers"
command -v valgrind >/dev/null || skip_all "no valgrind"
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2

ms() { echo "$(($1 / 1000)).$(printf %03d $(($1 % 1000))) s"; } # so many milliseconds
lines() { for ((i = 0; i < $1; i++)); do echo "$2"; done; }
numbered() { for ((i = 0; i < $1; i++)); do echo "$2 $((i % 97 + 1))"; done; }
recording() { awk -v count="$1" 'BEGIN {for (i = 0; i < count; i++) printf "%.2f %.9f\n", i / 100, exp(-i / 4e4) * cos(i / 12)}'; }
sprung() { echo "scene $1; method $2; run $(ms $(($3 + 1)))"; } # that many steps of 1 ms, and one

# Each row prints the script that does the work so often; with 0, what has to be there before.
steps_linear() { sprung damped 'verlet dt=1ms' "$1"; }
steps() { sprung drag 'rk4 dt=1ms' "$1"; }
steps_driven() { sprung driven 'verlet dt=1ms' "$1"; }
steps_thinned() { echo 'set record every 100'; sprung duffing 'rk4 dt=1ms' "$1"; }
steps_even() { echo 'set record every 10 ms'; sprung drag 'rk4 dt=1ms' "$1"; }
steps_typed() { echo "var x = 1; var z = 0; x'' = z - 2*x; z'' = x - 2*z; method rk4 dt=1ms; run $(ms $(($1 + 1)))"; }
steps_adaptive() { echo "scene kepler; method dop853; run $(($1 + 1)) s"; }
step_lines() { sprung drag 'rk4 dt=1ms' 0; lines "$1" step; }
step_lines_linear() { sprung damped 'verlet dt=1ms' 0; lines "$1" step; }
step_lines_driven() { sprung driven 'rk4 dt=1ms' 0; lines "$1" step; }
back_lines() { sprung drag 'rk4 dt=1ms' 3000; lines "$1" back; }
continue_lines() { sprung duffing 'rk4 dt=1ms' 0; lines "$1" 'continue 3 ms'; }
continue_lines_linear() { sprung damped 'verlet dt=1ms' 0; lines "$1" 'continue 3 ms'; }
continue_lines_driven() { sprung driven 'rk4 dt=1ms' 0; lines "$1" 'continue 3 ms'; }
pulse() { echo "var x = 0; var v = 0; x' = v; v' = exp(-((t - 500)/1e-4)^2) - x; method rk4 dt=1ms; run 1 ms"; }
step_lines_pulse() { pulse; lines "$1" step; }
step_lines_opinion() { echo 'scene spring; method dop853; run 30 s'; lines "$1" step; }
continue_lines_opinion() { echo 'scene damped; method dop853; run 30 s'; lines "$1" 'continue 50 ms'; }
continue_lines_second() { echo 'scene pendulum; method dop853; run 30 s'; lines "$1" 'continue 50 ms'; }
continue_lines_pulse() { pulse; lines "$1" 'continue 3 ms'; }
change_lines() { sprung drag 'rk4 dt=1ms' 10; numbered "$1" 'change k'; }
set_lines() { numbered "$1" 'set m'; }
runs() { lines "$1" 'run 20 ms'; }
export_rows() { sprung drag 'rk4 dt=1ms' "$1"; echo 'export rows.csv t,y,v,energy --force'; }
export_json() { sprung damped 'verlet dt=1ms' "$1"; echo 'export rows.json --force'; }
measure_rows() { sprung damped 'rk4 dt=1ms' $((2000 + $1)); echo 'measure period; measure amplitude'; }
load_rows() { recording $((400 + $1)) >rows.txt; echo 'load rows.txt'; }
fit_rows() { recording $((400 + $1)) >rows.txt; echo 'load rows.txt; fit damped'; }
fit_scene_rows() { recording $((400 + $1)) >rows.txt; echo 'load rows.txt; scene damped; fit scene'; }
fit_drag_rows() { recording $((400 + $1)) >rows.txt; echo 'load rows.txt; fit drag'; }
clean_rows() { recording $((400 + $1)) >rows.txt; echo 'load rows.txt; data clean'; }
measure_recording() { recording $((400 + $1)) >rows.txt; echo 'load rows.txt; measure period'; }
plot_rows() { sprung drag 'verlet dt=1ms' $((1000 + $1)); echo 'plot position; plot energy'; }
sweep_points() { echo "scene driven; method rk4 dt=10ms; duration = 1 s"; [ "$1" -eq 0 ] || echo "sweep omega=1:$1:1 measure=max --threads 1"; }

# name, and how much of the work is done once; then ten times that.
rows='steps_linear:20000 steps:5000 steps_driven:5000 steps_thinned:20000 steps_even:5000 steps_typed:5000 steps_adaptive:30
    step_lines:100 step_lines_linear:100 step_lines_driven:100 back_lines:10
    continue_lines:50 continue_lines_linear:50 continue_lines_driven:50
    step_lines_pulse:20 continue_lines_pulse:20
    step_lines_opinion:50 continue_lines_opinion:50 continue_lines_second:50
    change_lines:50 runs:20 set_lines:100
    export_rows:500 export_json:500 measure_rows:2000 load_rows:1000 fit_rows:500 fit_scene_rows:500 fit_drag_rows:500
    clean_rows:1000 measure_recording:1000 plot_rows:3000 sweep_points:50'

# The instructions of a script on its standard input; what the script says is left in said.txt.
instructions() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$hooke" -n -q -f script.hk >out.txt 2>said.txt || return 1
    awk '/Collected :/ {print $4}' said.txt
}

n=0 bad=0
for row in ${*:-$rows}; do
    name=${row%:*} amount=${row#*:}
    n=$((n + 1))
    "$name" 0 >script.hk && none=$(instructions) &&
        "$name" "$amount" >script.hk && once=$(instructions) &&
        "$name" $((10 * amount)) >script.hk && more=$(instructions) ||
        { bad=1; echo "not ok $n - $name"; grep -v '^==' said.txt | head -n 5 | sed 's/^/#   /'; continue; }
    # Less than an instruction for each is no measurement of anything.
    verdict=$(awk -v none="$none" -v once="$once" -v more="$more" -v amount="$amount" -v limit="$limit" 'BEGIN {
        each = (once - none) / amount
        good = each >= 1 && more - none <= limit * (once - none)
        printf "%s %.0f instructions each, ten times the work %.1f times as many", good ? "ok" : "bad", each, (more - none) / (once - none)
    }')
    if [ "${verdict%% *}" = ok ]; then echo "ok $n - $name: ${verdict#* }"; else bad=1; echo "not ok $n - $name: ${verdict#* }"; fi
done
echo "1..$n"
exit "$bad"
