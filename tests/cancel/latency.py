#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C at random times: how long each command takes to give the prompt back.

usage: latency.py HOOKE FOLDER [TRIALS [NAME ...]]

FOLDER receives the recordings (2e6 rows, and 1e8 bytes) that it does not have yet. The program runs at a
prompt in a pseudo-terminal; a command is first run to its end, at most 30 s, then TRIALS times with
Ctrl-C after a time uniform in its length. Latencies are from the byte to the next prompt, in ms.
Status 1: a 99th percentile (of few trials: the largest) is above 100 ms.
"""
import math
import os
import pty
import random
import select
import signal
import sys
import time

LIMIT_MS = 100
LONGEST = 30.0
PROMPT = b"hooke> "

RECORDING = "load big.txt; m = 200 g"
FITTED = RECORDING + "; fit damped; adopt"
STEPS = "scene damped; gamma = 0.01; method verlet dt=1ms; set record all; run 1000 s --force"
DRIVEN = "scene duffing-driven; method rk4 dt=1ms; set record all; run 1000 s --force"
LORENZ = "scene lorenz; method rk4 dt=1ms"
# name, what is set up once, the command, what follows each trial
CASES = [
    ("load", "", "load big.txt", "drop data"),
    ("load 100 MB", "", "load huge.csv", "drop data"),
    ("data clean", RECORDING, "data clean", ""),
    ("data clean apply", RECORDING, "data clean apply", "data restore"),
    ("data window", RECORDING, "data window 1:1999", "data restore"),
    ("data list", RECORDING, "data", ""),
    ("data zero", RECORDING, "data zero 20 cm", ""),
    ("data restore", RECORDING, "data restore", ""),
    ("data join", RECORDING + "; load big.txt", "data join big", ""),
    ("measure period data", RECORDING, "measure period", ""),
    ("measure frequency data", RECORDING, "measure frequency", ""),
    ("measure period windows", RECORDING, "measure period windows=8", ""),
    ("measure amplitude data", RECORDING, "measure amplitude windows=6", ""),
    ("measure decay data", RECORDING, "measure decay", ""),
    ("measure spectrum data", RECORDING, "measure spectrum", ""),
    ("measure spring data", RECORDING, "measure spring", ""),
    ("measure repeat data", RECORDING, "measure repeat big windows=20", ""),
    ("measure k data", RECORDING, "measure k", ""),
    ("fit damped", RECORDING, "fit damped", ""),
    ("fit sine", RECORDING, "fit sine", ""),
    ("fit drag", RECORDING, "fit drag", ""),
    ("fit law", RECORDING, "fit law", ""),
    ("fit modes", RECORDING, "fit modes 2", ""),
    ("fit formula", RECORDING, "fit a*exp(-b*t)*cos(w*t+p)+c b=0.001 w=8.7", ""),
    ("fit robust", RECORDING, "fit a*exp(-b*t)*cos(w*t+p)+c b=0.001 w=8.7 --robust", ""),
    ("fit bootstrap", RECORDING, "fit damped --bootstrap 50", ""),
    ("fit scene", FITTED, "fit scene", ""),
    ("adopt", FITTED, "adopt", ""),
    ("plot data", RECORDING, "plot position", ""),
    ("plot residual", FITTED + "; method verlet dt=10ms; run 1000 s --force", "plot residual", ""),
    ("plot spectrum data", RECORDING, "plot spectrum", ""),
    ("plot period data", RECORDING, "plot period", ""),
    ("plot svg data", RECORDING, "plot position > a.svg --force", ""),
    ("plot png data", RECORDING, "plot position > a.png --force", ""),
    ("export data", RECORDING, "export - data", ""),
    ("export data file", RECORDING, "export a.csv data --force", ""),
    ("report", FITTED + "; method verlet dt=1ms; run 1000 s --force", "report handed --force", ""),
    ("band", FITTED + "; method verlet dt=1ms; run 1000 s --force", "plot position --band", ""),
    ("run", "scene damped; method verlet dt=1ms; set record all", "run 1000 s --force", "drop all"),
    ("run long", "scene pendulum; method radau5 dt=1ms", "run 3000 s --force", "drop all"),
    ("run adaptive", "scene lorenz; method dop853; tol = 1e-10", "run 2000", "drop all"),
    ("run until", "scene pendulum; method rk4 dt=1ms", "run until theta > 10 rad", "drop all"),
    ("continue", STEPS, "continue 1000 s --force", "back 1000000"),
    ("step", STEPS, "step 1000000", "back 1000000"),
    ("back", STEPS, "back 900000", "continue"),
    ("reset", STEPS, "reset", "continue"),
    ("change", STEPS, "change gamma = 0.02", "undo"),
    ("undo", STEPS + "; m = 300 g", "undo", "redo"),
    ("runs", STEPS, "runs", ""),
    ("use", STEPS, "use 1", ""),
    ("drop", STEPS, "drop all", "run 1000 s --force"),
    ("show", STEPS, "show", ""),
    ("print", STEPS, "print y", ""),
    ("list", STEPS, "list runs", ""),
    ("list measurements", STEPS, "list measurements", ""),
    ("measure period run", STEPS, "measure period", ""),
    ("measure amplitude run", STEPS, "measure amplitude", ""),
    ("measure decay run", STEPS, "measure decay", ""),
    ("measure energy run", STEPS, "measure energy", ""),
    ("measure drift run", STEPS, "measure drift", ""),
    ("measure spectrum run", STEPS, "measure spectrum", ""),
    ("measure reynolds run", STEPS, "measure reynolds", ""),
    ("fit damped run", STEPS, "fit damped", ""),
    ("cursor", STEPS, "cursor", "cursor off"),
    ("cursor periods", STEPS + "; cursor", "cursor periods 300", ""),
    ("cursor next", STEPS + "; cursor", "cursor next", ""),
    ("cursor chaotic", DRIVEN, "cursor", "cursor off"),
    ("plot run", STEPS, "plot position", ""),
    ("plot energy", STEPS, "plot energy", ""),
    ("plot phase", STEPS, "plot phase", ""),
    ("plot error", STEPS, "plot error", ""),
    ("plot envelope", STEPS, "plot envelope", ""),
    ("plot period run", STEPS, "plot period", ""),
    ("plot against", STEPS, "plot v against y", ""),
    ("plot spectrum run", STEPS, "plot spectrum", ""),
    ("screenshot", STEPS, "screenshot", ""),
    ("export run", STEPS, "export - ", ""),
    ("export run file", STEPS, "export a.csv --force", ""),
    ("export run json", STEPS, "export a.json --force", ""),
    ("export table", STEPS, "export a.csv table --force", ""),
    ("save", STEPS, "save a.hk --force", ""),
    ("compare", "scene pendulum; duration = 1000 s", "compare euler rk4 tr-bdf2 radau5 dt=1ms --force",
     "drop all"),
    ("compare closed", "scene damped; duration = 1000 s", "compare euler verlet tr-bdf2 dt=1ms --force", "drop all"),
    ("precision", "scene pendulum; duration = 100 s", "precision rk4 verlet radau5 dopri5", ""),
    ("order", "scene pendulum; duration = 100 s", "order radau5", ""),
    ("selftest", "", "selftest", ""),
    ("stability", "scene damped", "stability radau5", ""),
    ("stability all", "scene pendulum", "stability rk4", ""),
    ("stress", "", "stress", ""),
    ("sweep", "scene driven; method rk4; duration = 600 s", "sweep omega=6:12:0.01", ""),
    ("sweep map", "scene pendulum; method dopri5; duration = 60 s", "sweep y0=0.1:3:0.01 gamma=0.1:1:0.1", ""),
    ("sweep threads", "scene lorenz; method radau5; duration = 300", "sweep rho=20:30:0.1 --threads 2", ""),
    ("plan", LORENZ, "plan", ""),
    ("source", "", "source a.hk", "drop all"),
    ("event", LORENZ + "; event top when z falling do record; set record all; run 1000 --force", "list events", ""),
    ("poincare", LORENZ + "; event top when z falling do record; set record all; run 1000 --force",
     "plot x at top", ""),
]


def recordings(folder):
    """2e6 rows of a damped sine in noise with missed echoes, and 1e8 bytes of a sine."""
    rng = random.Random(1)
    for name, rows, head, row in (
        ("big.txt", 2000000, "t (s)\ty (cm)\n", None),
        ("huge.csv", 5300000, "t (s),y (cm)\n", "%.6f,%.7f\n"),
    ):
        path = os.path.join(folder, name)
        if os.path.exists(path):
            continue
        with open(path, "w") as out:
            out.write(head)
            for i in range(rows):
                t = i * 0.001
                if row:
                    out.write(row % (t, 20 + 5 * math.cos(8.7 * t)))
                else:
                    y = 20 + 5 * math.exp(-t / 1500) * math.cos(8.7 * t) + rng.gauss(0, 0.02)
                    out.write("%.3f\t%.4f\n" % (t, y + 3 * (i % 1000 == 7)))
    with open(os.path.join(folder, "a.hk"), "w") as out:
        out.write("scene pendulum; method rk4 dt=1ms\nrun 3000 s --force\n")


class Prompt:
    def __init__(self, program, folder):
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.environ.update(TERM="dumb", HOOKE_AUTOSAVE="100000", XDG_STATE_HOME=folder, LC_ALL="C.UTF-8")
            os.execv(program, [program, "-n", "--plain", "--size", "80x20"])
        self.tail = b""

    def wait(self, seconds):
        """True: the prompt came."""
        end = time.monotonic() + seconds
        while True:
            left = end - time.monotonic()
            if left <= 0 or not select.select([self.fd], [], [], left)[0]:
                return False
            try:
                self.tail = (self.tail + os.read(self.fd, 1 << 16))[-64:]
            except OSError:
                return False
            if self.tail.endswith(PROMPT):
                return True

    def send(self, line):
        self.tail = b""
        os.write(self.fd, line.encode() + b"\r")
        # the echo ends in a prompt's look only if the line did
        time.sleep(0.002)

    def do(self, line, seconds=LONGEST):
        self.send(line)
        return self.wait(seconds)

    def interrupt(self, seconds=20.0):
        start = time.monotonic()
        os.kill(self.pid, signal.SIGINT)
        return (time.monotonic() - start) * 1e3 if self.wait(seconds) else float("inf")

    def end(self):
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        os.close(self.fd)


def measure(program, folder, case, trials, rng):
    name, before, command, after = case
    at = Prompt(program, folder)
    at.wait(5)
    for line in filter(None, before.split("; ")):
        if not at.do(line, 120):
            at.end()
            return None
    start = time.monotonic()
    whole = at.do(command)
    length = time.monotonic() - start
    latencies = []
    if not whole:
        latencies.append(at.interrupt())
    for _ in range(trials):
        if latencies and latencies[-1] == float("inf"):
            break
        if after:
            at.send(after)
            time.sleep(0.05)
            if not at.tail.endswith(PROMPT) and not at.wait(10):
                at.interrupt()
        at.send(command)
        if at.wait(rng.uniform(0, min(length, 10.0))):
            latencies.append(0.0)
            continue
        latencies.append(at.interrupt())
    at.end()
    return length, sorted(latencies)


def main():
    program, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
    trials = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    only = sys.argv[4:]
    os.makedirs(folder, exist_ok=True)
    recordings(folder)
    rng = random.Random(7)
    bad = 0
    print("%-24s %8s %8s %8s %8s" % ("command", "whole s", "p50 ms", "p90 ms", "p99 ms"))
    for case in CASES:
        if only and case[0] not in only:
            continue
        found = measure(program, folder, case, trials, rng)
        if not found:
            print("%-24s cannot be set up" % case[0])
            bad += 1
            continue
        length, all_of = found
        at = [all_of[min(len(all_of) - 1, int(q * len(all_of)))] for q in (0.5, 0.9, 0.99)]
        bad += at[2] > LIMIT_MS
        print("%-24s %8.2f %8.1f %8.1f %8.1f%s"
              % (case[0], length, *at, "  <<" if at[2] > LIMIT_MS else ""), flush=True)
    sys.exit(bad > 0)


main()
