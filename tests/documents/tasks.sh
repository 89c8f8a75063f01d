#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What newcomers ask: at most two commands, found by help, apropos or the hint of an error, solve it. A line is the
# task | what somebody types to find out | what the answer has to name | that, as it is then typed (it has to succeed).
set -u
. "$(dirname "$0")/ask.bash"
hooke=$(realpath "${HOOKE:-build/hooke}")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
"$hooke" -n -q -c 'scene damped; method rk4; run 30 s; export swing.csv t,y' >/dev/null || exit 2

mapfile -t lines < <(sed -n 's/ *| */|/gp' <<'TASKS'
see the velocity               | velocity              | plot velocity         | run; plot velocity
see position against time      | help                  | help start            | run; plot position
draw the phase plane           | apropos phase         | phase plot            | run; plot phase
is energy conserved            | dE/E0                 | plot energy-error     | method verlet; run; plot energy-error; measure drift
what is E                      | print E               | print energy          | run; print energy
period of the oscillation      | period                | measure period        | run; measure period
frequency of it                | frequency             | measure frequency     | run; measure frequency
how fast does it die out       | help damping          | measure decay         | scene damped; method rk4; run; measure decay
add friction                   | friction 10 mN        | friction = 10 mN      | friction = 10 mN; run
add air drag                   | apropos resistance    | C = 1                 | scene drag; C = 1; run
a damped spring                | apropos damped        | damped scene          | scene damped; run
a pendulum                     | apropos pendulum      | pendulum scene        | scene pendulum; run
choose a method                | solver                | method NAME           | method rk4
what methods are there         | methods               | list methods          | list methods
which method for stiff scenes  | apropos stiff         | radau5                | list methods stiff; scene stiff-damped; method radau5 tol=1e-6; run 1 s
which one is fastest           | fastest               | precision             | duration = 2 s; precision euler rk4
compare two methods            | help compare          | compare euler         | compare euler rk4; plot energy run all
the order of a method          | apropos order         | order command         | duration = 2 s; order rk4
largest stable step            | apropos stable        | stability command     | stability rk4
change the time step           | timestep              | dt =                  | dt = 5 ms
run for longer                 | help time             | run 20 s              | run 20 s
accuracy of an adaptive method | tolerance             | tol =                 | method dopri5; tol = 1e-8; run
set the mass                   | mass = 2 kg           | m =                   | m = 2 kg
set the spring constant        | stiffness             | k =                   | k = 20 N/m
set the start                  | initial               | y0 =                  | y0 = 5 cm; v0 = 0 cm/s
read my sensor's file          | open swing.csv        | load FILE             | load swing.csv
an Excel file                  | help excel            | help recording        | help recording
only part of a recording       | help recording        | data window           | load swing.csv; data window 2:20
fit a damped oscillation       | help fit              | fit damped            | load swing.csv; fit damped
which drag does the bob have   | help fit              | fit drag              | load swing.csv; fit drag
simulate what was fitted       | apropos fit           | adopt                 | load swing.csv; fit damped; adopt; run
save the plot                  | picture               | plot position > FILE.svg | run; plot position > p.txt --force
save the numbers               | table                 | export FILE.csv       | run; export run.csv --force
spectrum of a run              | fft                   | plot spectrum         | method rk4; run; plot spectrum
type my own equation           | ode                   | help equations        | scene new; var x = 1; x' = -x; run 1 s
resonance curve                | apropos resonance     | sweep omega           | scene driven; method rk4; duration = 9 s; sweep omega=6:12:1
take a command back            | help                  | undo                  | m = 1 kg; undo
save the session               | apropos save          | save command          | save s.hk --force
run a script                   | script                | source FILE.hk        | save s.hk --force; source s.hk
hand in                        | hand-in               | report FOLDER         | run; report handin --force
forget a run                   | delete                | drop                  | run; drop 1
what units are there           | units                 | list units            | list units
moment of the highest point    | help equations        | event top             | event top when v falling do record; method rk4; run; list events
see all values                 | help start            | show all              | show all
stop a run that goes on        | help stop             | paused                | run 1 s; stop
leave                          | close                 | quit                  | quit
duration in a sweep            | sweep gamma=0:1 duration=20 | duration =      | duration = 5 s; sweep gamma=0:1:0.5
zero at the resting position   | apropos zero          | data command          | load swing.csv; data zero 1 cm
are samples bad                | help data             | data clean            | load swing.csv; data clean
uncertainty of the mass        | uncertainty           | 200.0(1) g            | m = 200.0(1) g; print m
the mass as it is printed      | help set              | 200.0(1) g            | set m 200.0(1) g
period by theory               | theory                | print T0              | print T0
mean of several windows        | apropos scatter       | repeat quantity       | load swing.csv; measure repeat windows=4
read off moments               | apropos cursor        | cursor command        | run 5 s; cursor A 1 s
what the run leaves out        | apropos residual      | residual plot         | load swing.csv; fit damped; adopt; run; plot residual
what is in the file            | preview               | load FILE --preview   | load swing.csv --preview
how the amplitude falls        | apropos envelope      | envelope plot         | load swing.csv; plot envelope data swing
axes in print                  | xlabel                | xlabel=TEXT           | run; plot y ylabel=height > p.svg
velocity against position      | plot y over v         | against COLUMN        | run; plot v against y
error against run time         | efficiency            | precision euler       | duration = 1 s; precision euler rk4
error against the step         | convergence           | order rk4             | duration = 1 s; order rk4
stability limit                | apropos limit         | stability command     | stability euler
a stiff problem to try         | apropos stiff         | stiff-vanderpol scene | scene stiff-vanderpol; method radau5; run 1 s
is the method symplectic       | help verlet           | symplectic            | list methods symplectic
methods of fourth order        | help list             | order N               | list methods order 4
implicit methods               | apropos implicit      | implicit-midpoint method | list methods implicit
evaluations of the forces      | nfev                  | measure=evals         | method dopri5; duration = 1 s; sweep tol=1e-9:1e-3:x10 measure=evals
how wrong is an adaptive run   | apropos error         | opinion setting     | method dopri5; tol = 1e-8; run 5 s
the same step for all          | help compare          | dt=V,..               | compare euler rk4 dt=10ms,1ms
energy over a long time        | drift                 | measure drift         | method verlet; run; measure drift
effect of a parameter          | vary                  | sweep NAME=FROM:TO    | method rk4; sweep k=10:20:5 measure=period
results for a program          | json                  | set format json       | set format json; run 1 s
exit status                    | exit-status           | hooke FILE.hk         | save s.hk --force
csv to a file                  | csv                   | export FILE.csv       | run; export r.csv --force
table of a study to a file     | help sweep            | > FILE                | method rk4; sweep k=10:20:5 measure=period > k.csv
only some columns              | help export           | COLUMN..              | run; export c.csv t,energy --force
fewer rows                     | help export           | every=                | run; export c.csv every=100ms --force
write over a file              | overwrite             | --force               | run; export r.csv --force
no colours                     | nocolor               | set color never       | set color never; show
comments in a script           | comment               | '#' begins            | run 1 s # comment
save it, in a sentence         | save the plot         | plot position > FILE.svg | run; plot position > s.txt --force
which one, in a sentence       | which method for stiff | help methods         | help methods
two words                      | apropos save plot     | output                | run; plot position > q.txt --force
a sentence                     | i have a spring and a recording | help recording | load swing.csv
a question                     | how do I see the velocity? | plot velocity    | run; plot velocity
method given to run            | run symplectic-euler  | method symplectic-euler | method symplectic-euler; run
TASKS
)

declare -a task asked named typed
for i in "${!lines[@]}"; do
    IFS='|' read -r 'task[i]' 'asked[i]' 'named[i]' 'typed[i]' <<<"${lines[i]}"
done

ask asked 80x24
told=("${answer[@]}")
ask typed 80x24
for i in "${!lines[@]}"; do
    tr -s ' \n' ' ' <<<"${told[i]:-}" | grep -qF -- "${named[i]}" ||
        { bad "${task[i]}: '${asked[i]}' does not name '${named[i]}'" "${told[i]:-}"; continue; }
    [[ ${answer[i]:-} != *': error: '* ]] || { bad "${task[i]}: '${typed[i]}' fails" "${answer[i]}"; continue; }
    ok "${task[i]}"
done

# What the topics of help show can be pasted, line after line.
"$hooke" -n --size 200x60 -c help | awk '$1 == "help" && /^  / {print $2}' >topics
[ "$(wc -l <topics)" -ge 10 ] && ok 'ten topics' || bad 'ten topics' "$(cat topics)"
while read -r topic; do
    "$hooke" -n --size 1000x60 -c "help $topic" | tac | sed 1d | awk '/^  / {print; next} {exit}' | tac | grep -v '^  .*panes$' >"$topic.hk"
    # A build without cairo writes no pictures.
    sed -i 's/[.]svg/.txt/' "$topic.hk"
    if [ -s "$topic.hk" ] && "$hooke" -n -q --size 80x24 "$topic.hk" >answer 2>&1; then ok "help $topic: its lines run"
    else bad "help $topic: its lines fail" "$(cat answer)"; fi
done <topics
[ "$("$hooke" -n --size 80x24 -c help | wc -l)" -le 22 ] && ok 'help is one screen' || bad 'help is more than 22 lines' ''
echo "1..$count"
