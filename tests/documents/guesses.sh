#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What people type who know another program, and what leads them on. A line is
# what they type (its last statement fails) | what the error has to name | that, filled in and typed | what it then says.
# Words in capitals stand for what is filled in. "=" : it is understood as it is.
set -u
. "$(dirname "$0")/ask.bash"
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
"$hooke" -n -q -c 'scene damped; method rk4; run 20 s; export swing.csv t,y' >/dev/null || exit 2

mapfile -t lines < <(sed -n 's/ *| */|/gp' <<'GUESSES'
# a student
m 0.3                     | 'm = 0.3'              | m = 0.3; print m              | 300 g
m: 0.3                    | 'm = 0.3'              | m = 0.3; print m              | 300 g
m := 0.3 kg               | 'm = 0.3 kg'           | m = 0.3 kg; print m           | 300 g
m=250g                    | =                      | m=250g; print m               | 250 g
m dt=1ms                  | 'dt = 1ms'             | dt = 1ms; print dt            | 1 ms
dt 5 ms                   | 'dt = 5 ms'            | dt = 5 ms; print dt           | 5 ms
set dt=5ms                | =                      | set dt=5ms; print dt          | 5 ms
mass = 0.2                | 'm = 200 g'            | m = 200 g; print m            | 200 g
mass 0.2                  | 'm = 200 g'            | m = 200 g; print m            | 200 g
m = 0,3 kg                | 0.3                    | m = 0.3 kg; print m           | 300 g
k = −15                   | - * /                  | k = -15; print k              | -15 N/m
m = 250 gram              | 250 g                  | m = 250 g; print m            | 250 g
m = 250 grams             | 250 g                  | m = 250 g; print m            | 250 g
m = 0.3 kilograms         | 0.3 kg                 | m = 0.3 kg; print m           | 300 g
m = 250 g g               | 250 g                  | m = 250 g; print m            | 250 g
run 10 sec                | 10 s                   | run 10 s                      | t = 10 s
run 10 seconds            | 10 s                   | run 10 s                      | t = 10 s
run 2 minutes             | 2 min                  | run 2 min                     | t = 120 s
run for 10 s              | 'run 10 s'             | run 10 s                      | t = 10 s
run t=10                  | 'run 20 s'             | run 20 s                      | t = 20 s
run 1000 steps            | 'run --steps 1000'     | run --steps 1000              | 1000 steps
run steps=1000            | 'run --steps           | run --steps 1000              | 1000 steps
step 10 ms                | 'run 10 ms'            | run 10 ms                     | t = 10 ms
run until t=1             | t >= 1                 | run until t >= 1              | t = 1 s
run dt=1ms                | 'dt = VALUE'           | dt = 1 ms; run 1 s            | 1000 steps
run duration=2            | 'duration = VALUE'     | duration = 2 s; run           | t = 2 s
run 1 s dt=1ms            | 'dt = VALUE'           | dt = 1 ms; run 1 s            | 1000 steps
y(0)=4cm                  | 'y0 = 4cm'             | y0 = 4cm; print y0            | 4 cm
x(0)=4cm                  | 'y0 = 4cm'             | y0 = 4cm; print y0            | 4 cm
v(0)=0.1                  | 'v0 = 0.1'             | v0 = 0.1; print v0            | 10 cm/s
y'(0)=0.1                 | 'v0 = 0.1'             | v0 = 0.1; print v0            | 10 cm/s
y[0] = 4 cm               | 'y0 = 4 cm'            | y0 = 4 cm; print y0           | 4 cm
x = 5                     | 'y0 = 5'               | y0 = 5; print y0              | 5 m
y = 5 cm                  | 'y0 = 5 cm'            | y0 = 5 cm; print y0           | 5 cm
simulate                  | 'run'                  | run                           | t = 10 s
compare dt=5 ms           | =                      | compare euler rk4 dt=5ms      | rk4
euler                     | 'method euler'         | method euler                  | euler
method = rk4              | 'method rk4'           | method rk4                    | rk4
method: rk4               | 'method rk4'           | method rk4                    | rk4
use rk4                   | 'method rk4'           | method rk4                    | rk4
run rk4                   | 'method rk4'           | method rk4; run 1 s           | rk4
scene harmonic            | 'scene spring'         | scene spring                  | spring
scene mass-spring         | 'scene spring'         | scene spring                  | spring
scene pendel              | 'scene pendulum'       | scene pendulum                | pendulum
scene simple pendulum     | 'scene pendulum'       | scene pendulum                | pendulum
run 5 s; plot x vs t      | it has y, v            | run 5 s; plot y vs t          | y [
run 5 s; plot energy vs time | in plots the time is t | run 5 s; plot energy vs t  | energy
run 1 s; show all > all.md | 'export FILE table'   | sweep k=10:20:5; export all.md table --force | rows of
run 5 s; plot y(t)        | 'plot y'               | run 5 s; plot y               | y [
run 5 s; plot position and velocity | plot velocity' | run 5 s; plot position; plot velocity | velocity
run 5 s; plot velocity, position | 'plot velocity' | run 5 s; plot velocity        | velocity
plot y                    | type: run              | run; plot y                   | y [
run 5 s; save plot.svg    | 'plot position > plot.svg' | run 5 s; plot position > plot.svg --force | plot.svg
run 5 s; save run.csv     | 'export run.csv'       | run 5 s; export run.csv --force | rows of t
save                      | save FILE              | save s.hk --force             | s.hk
quit()                    | 'quit'                 | help quit                     | quit
exit()                    | 'quit'                 | help quit                     | quit
help me                   | =                      | help me                       | topics
man run                   | 'help COMMAND'         | help run                      | usage: run
info                      | 'show'                 | show                          | spring
load swing.csv; fit linear | 'fit a + b*t'         | load swing.csv; fit a + b*t   | converged
list scene                | 'scenes'               | list scenes                   | pendulum
list method               | 'methods'              | list methods                  | euler
# of LoggerPro, Capstone
collect                   | 'load FILE'            | load swing.csv                | rows
load swing.csv; curve fit | 'fit damped'           | load swing.csv; fit damped    | gamma =
load swing.csv; linear fit | 'fit a + b*t'         | load swing.csv; fit a + b*t   | converged
open swing.csv            | 'load FILE'            | load swing.csv                | rows
read swing.csv            | 'load FILE'            | load swing.csv                | rows
# Python
import numpy as np        | 'list functions'       | list functions                | sqrt
from math import pi       | 'list functions'       | list functions                | sqrt
print 2**3                | 2^3                    | print 2^3                     | 8
print math.pi             | 'pi'                   | print pi                      | 3.14159
print np.sin(1)           | 'sin'                  | print sin(1)                  | 0.841471
print 2pi                 | 2*pi                   | print 2*pi                    | 6.28319
run 2pi                   | 2*pi                   | run 2*pi                      | t = 6.28319
print sin 3               | sin(x)                 | print sin(3)                  | 0.14112
print e                   | exp(1)                 | print exp(1)                  | 2.71828
print 9.81m/s2            | m/s^2                  | print 9.81 m/s^2              | 9.81 m/s^2
let g0 = 9.81 m/s2        | m/s^2                  | let g0 = 9.81 m/s^2; print g0 | 9.81 m/s^2
run 1 s; plt.plot(t, y)   | 'plot y against t'     | run 1 s; plot y against t     | y [
run 1 s; plt.show()       | 'show'                 | show                          | spring
run 1 s; plt.savefig("a.png") | 'plot position > FILE.svg' | run 1 s; plot position > a.txt --force | a.txt
odeint(f, y0, t)          | 'run'                  | run                           | t = 10 s
solve_ivp(f, [0, 10], y0) | 'run'                  | run                           | t = 10 s
def f(x):                 | x' = EXPR              | var x = 1; x' = -x; run 1 s   | t = 1 s
for i in range(10):       | 'sweep                 | method rk4; sweep k=10:20:5 measure=period | 15
a = 5                     | 'let a_1 = 5'          | let a_1 = 5; print a_1        | 5
len = 5                   | 'let len = 5'          | let len = 5; print len        | 5
# Matlab, Octave
solver ode45              | 'method NAME'          | method dopri5                 | dopri5
[t,y] = ode45(@f,[0 10],[1 0]) | 'method dopri5'   | method dopri5; run 1 s        | dopri5
tspan = [0 10]            | 'duration = 20 s'      | duration = 20 s; run          | t = 20 s
tspan=0:10                | 'duration = 20 s'      | duration = 20 s; run          | t = 20 s
hold on                   | 'plot position run all' | run 1 s; run 2 s; plot position run all | position
figure                    | 'plot position             | run; plot position            | position
legend on                 | 'plot position             | run; plot position            | position
run 9 s; xlim([0 5])      | 'plot y x=0:5'         | run 9 s; plot y x=0:5         | y [
run 9 s; axis tight       | 'plot y x=0:5'         | run 9 s; plot y x=0:5         | y [
run 9 s; grid on          | 'plot y --grid > FILE.svg' | run 9 s; plot y --grid > c.svg --force | c.svg
disp(k)                   | 'print k'              | print k                       | 15 N/m
printf("%g", k)           | 'print EXPR'           | print k                       | 15 N/m
clc                       | 'clear'                | clear                         |
whos                      | 'show all'             | show all                      | duration
max(1, 2)                 | 'print max(1, 2)'      | print max(1, 2)               | 2
if y > 0                  | 'run until             | run until y < 0               | t =
while y > 0               | 'run until             | run until y < 0               | t =
# gnuplot
run 9 s; set xrange [0:10] | 'plot y x=0:5'        | run 9 s; plot y x=0:5         | y [
run 9 s; plot "swing.csv" using 1:2 | 'load FILE'  | load swing.csv; plot position data swing | position
set term png              | 'plot position > FILE.svg' | run; plot position > b.txt --force | b.txt
set output "b.png"        | 'help output'          | help output                   | plot position > position.svg
set grid on               | 'plot y --grid > FILE.svg' | run 9 s; plot y --grid > c.svg --force | c.svg
unset key                 | 'plot position             | run; plot position            | position
replot                    | 'plot position'        | run; plot position            | position
set samples 1000          | 'record = all'         | record = all; show record     | all
# XPPAUT
init y=0.05               | 'y0 = 0.05'            | y0 = 0.05; print y0           | 5 cm
par gamma=0.2             | 'gamma = 0.2'          | gamma = 0.2; print gamma      | 0.2 1/s
par a=1                   | 'param a = 1'          | param a = 1; var x = 2; x' = -a*x; run 1 s; print x | 0.73
@ dt=.01                  | 'dt = .01'             | dt = .01; print dt            | 10 ms
@ total=40                | 'duration = 20 s'      | duration = 20 s; print duration | 20 s
done                      | 'run'                  | run                           | t = 10 s
aux e2=y^2                | 'observe e2 = y^2'     | observe e2 = y^2; run 1 s     | t = 1 s
var x = 1; dx/dt = -x     | x' = -x                | var x = 1; x' = -x; run 1 s   | t = 1 s
d2y/dt2 = -4*y            | y'' = -4*y             | var y = 1; y'' = -4*y; run 1 s | t = 1 s
var y = 1; y'' + y = 0    | y'' = EXPR             | var y = 1; y'' = -y; run 1 s  | t = 1 s
# names that nobody knows, wherever an expression stands
var x = 1; x' = -a*x      | 'param a = VALUE'      | var x = 1; param a = 2; x' = -a*x; run 1 s | t = 1 s
var x = 1; x' = -nu*x     | 'param nu = VALUE'     | var x = 1; param nu = 2; x' = -nu*x; run 1 s | t = 1 s
let nu = 2; var x = 1; x' = -nu*x | 'param nu = 2' | var x = 1; param nu = 2; x' = -nu*x; run 1 s | t = 1 s
force -nu*y^3             | 'param nu = VALUE'     | param nu = 2; force -nu*y^3; run 1 s | t = 1 s
observe q = nu*y          | 'param nu = VALUE'     | param nu = 2; observe q = nu*y; run 1 s | t = 1 s
var x = nu                | 'let nu = VALUE'       | let nu = 2; var x = nu        | var x = 2
param b = nu/2            | 'let nu = VALUE'       | let nu = 2; param b = nu/2    | param b = 1
let b = nu/2              | 'let nu = VALUE'       | let nu = 2; let b = nu/2      | b = 1
k = nu/2                  | 'let nu = VALUE'       | let nu = 2; k = nu/2          | k = 1 N/m
print nu/2                | 'let nu = VALUE'       | let nu = 2; print nu/2        | 1
run nu                    | 'let nu = VALUE'       | let nu = 2; run nu            | t = 2 s
run until y < nu          | 'let nu = VALUE'       | let nu = 0; run until y < nu  | t =
event low when y < nu do record | 'param nu = VALUE' | param nu = 0; event low when y - nu < 0 do record | event low
method rk4; sweep k=10:20:5 measure=nu | possible are amplitude | method rk4; sweep k=10:20:5 measure=amplitude | 15
method rk4; sweep k=10:20:nu | 'let nu = VALUE'    | let nu = 5; method rk4; sweep k=10:20:nu measure=period | 15
run 5 s; measure nu       | it is one of: period   | run 5 s; measure period       | T =
GUESSES
)

declare -a guess named typed says
for i in "${!lines[@]}"; do
    IFS='|' read -r 'guess[i]' 'named[i]' 'typed[i]' 'says[i]' <<<"${lines[i]}"
done

ask guess 900x12 '    ' # not what is quoted of the line, nor the marks under it
hints=("${answer[@]}")
ask typed 900x12 '    '
for i in "${!lines[@]}"; do
    name="${guess[i]}"
    hint=${hints[i]:-} reply=${answer[i]:-}
    if [[ ${named[i]} == '=' ]]; then
        [[ $hint != *error:* ]] || { bad "$name: is refused" "$hint"; continue; }
    else
        [[ $hint == *error:* ]] || { bad "$name: is taken" "$hint"; continue; }
        [[ $hint == *"${named[i]}"* ]] || { bad "$name: no ${named[i]} in the error" "$hint"; continue; }
        form=${named[i]//\'/} # up to what is filled in: NAME, VALUE, FILE
        form=${form%%[A-Z][A-Z]*}
        [[ ${named[i]} != "'"* || ${typed[i]} == *"${form% }"* ]] || { bad "$name: ${typed[i]} is not ${named[i]}" "$hint"; continue; }
        [[ ${named[i]} != "'$name'" ]] || { bad "$name: is what was typed" "$hint"; continue; }
    fi
    [[ $reply != *error:* && $reply == *"${says[i]}"* ]] || { bad "$name: ${typed[i]} does not say ${says[i]}" "$reply"; continue; }
    ok "$name"
done
echo "1..$count"
