#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds the two lists of `plan` against counts by callgrind: no clock, no noise.

usage: prices.py [--long] HOOKE

computed: the share of each part in the instructions of `run` is what the list says, to a factor of 1.5
          (parts below 3 % of the run are not compared).
left out: what computes it takes at most 0.5 % of the instructions of `run`, and a force whose
          coefficient is 0 no more than a scene that never had it.
screen:   at 80 columns `plan` of each built-in scene has at most 22 lines.
adaptive: a run takes at most 1.5 times the instructions of its steps with the second opinion, at
          most 1.1 times with -q; of runs of some hundred steps the set-up is left out.
quiet:    5e5 steps with -q take at most 1.1 times the instructions of the steps alone, runs of a
          lab's 10 s and of some hundred stiff steps at most what is listed.
memory:   a report of 1e6 rows takes at most 60 MB.
clean:    `data clean` takes at most so many instructions a row of a long recording, whatever is wrong.
"""
import math
import os
import random
import re
import subprocess
import sys
import tempfile

SCREEN_COLUMNS, SCREEN_LINES = 80, 22
FACTOR, SHARE_MIN, LEFT_OUT_MAX, QUIET_MAX, OPINION_MAX = 1.5, 3, 0.5, 1.1, 1.5

POLYNOMIAL = "scene new m; var y = 0.05; y'' = -75*y - 500*y^3"
# Parts: a pattern for the entries of the list, and the functions that compute them.
PARTS = [
    ("steps", r"^(\d|about \d|rows|energy balance, kept)", ["run_advance"]),
    ("singularities", "across", ["run_diagnose"]),
    ("pulses", "pulses", ["run_missed_burst"]),
    ("fast forces", "faster", ["reply_unresolved"]),
    ("energy", "of the summary|of a sample", ["run_ledger_brief"]),
    ("error", "second|closed form", ["run_second_opinion"]),
]
# Parts that are left out: a pattern for the entry, and the functions that would compute them.
ABSENT = [
    ("energy balance", "energy-error", ["run_ledger", "balance_block", "parts_potential"]),
    ("closed form", r"\bexact", ["system_exact"]),
    ("columns", "each", ["run_column", "run_observable", "system_energy"]),
    ("singularity", "singularity", ["run_follow_from"]),
    ("second solution", "second solution", ["run_second_opinion"]),
    ("stable dt", "stable dt", ["method_stable_limit"]),
]
# Entries of the other list that check_absent_forces() holds, and the remark at its end.
OTHERWISE = r"coefficient 0$|computed on demand$"
CASES = [
    "scene spring; method verlet",
    "scene drag; method rk4",
    "scene drag; method verlet; duration = 30 s",
    "scene driven; y0 = 1 cm; method rk4",
    "scene driven; method verlet; set record every 100; duration = 100 s",
    "scene driven; method verlet; set record every 0.5 s; duration = 100 s",
    "scene pendulum; method verlet",
    "scene vanderpol; method rk4",
    "scene kepler; method rk4",
    POLYNOMIAL + "; method rk4",
    POLYNOMIAL + "; method verlet; duration = 100 s",
    "scene drag; method gauss4",
    "scene drag; method dopri5",
    "scene driven; method dopri5",
    "scene pendulum; method dop853 tol=1e-9",
    "scene kepler; method dop853 tol=1e-9",
    "scene robertson; method rodas5p; duration = 1e5 s",
    "scene stiff-vanderpol; method radau5",
    "scene pendulum; method dopri5; set opinion off; duration = 100 s",
]
ADAPTIVE = [
    "scene vanderpol; mu = 1000; method rodas5p tol=1e-6; run 2000 s",
    "scene stiff-vanderpol; method radau5 tol=1e-6; run 2000 s",
    "scene kepler; method dop853 tol=1e-6; run 1000 s",
    "scene spring; method dopri5 tol=1e-9; run 100 s",
    "scene pendulum; method dopri5; run 1000 s",
    "scene pendulum; method dop853; run 1000 s",
]
MEMORY_MAX = 60
# Instructions of `data clean` a row, per fault.
CLEAN_ROWS = 40000
CLEAN = {"noise": 2900, "spikes": 3100, "flat tops": 4200}
# Short runs with -q, less their set-up: looks for singularities and resting variables have a least size.
SHORT = [
    ("scene spring; method verlet; run 10 s", 1.5),
    ("scene spring; method rk4 dt=1ms; run 10 s", 1.2),
    ("scene driven; method rk4; run 10 s", 1.1),
    ("scene drag; method rk4; run 10 s", 2.05),
    ("scene pendulum; method verlet; run 10 s", 3.3),
    ("scene robertson; method rodas5p tol=1e-6; run", 1.1),
]
QUIET = ["spring", "damped", "drag", "driven", "pendulum", "duffing"]


def counts(hooke, script, quiet):
    """Inclusive instructions of each function."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "counts")
        options = ["-q"] if quiet else []
        done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=" + out, hooke, "-n",
                               *options, "-c", script], capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit("not ok - %s: %s" % (script, done.stderr[-400:]))
        told = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", out],
                              capture_output=True, text=True, check=True).stdout
    found = {}
    for line in told.splitlines():
        match = re.match(r"\s*([\d,]+) \(.*?\)\s+\S*:(\w+)", line)
        if match:
            count = int(match.group(1).replace(",", ""))
            found[match.group(2)] = max(found.get(match.group(2), 0), count)
    return found


def lists(hooke, script):
    """The entries of both lists: {words: percent or None}."""
    text = subprocess.run([hooke, "-n", "--color", "never", "-c", script + "; plan"], capture_output=True,
                          text=True, check=True).stdout
    text = re.sub(r"\n {10}", " ", text)
    both = []
    for heading in ("computed", "left out"):
        line = re.search("^%s +(.*)$" % heading, text, re.MULTILINE)
        entries = {}
        for entry in line.group(1).split("; ") if line else []:
            match = re.match(r"(.*?) (?:below )?([\d.e+]+) %(?: of the run)?$", entry)
            entries[match.group(1) if match else entry] = float(match.group(2)) if match else None
        both.append(entries)
    return both


class Verdicts:
    def __init__(self):
        self.count = self.bad = 0

    def say(self, good, words):
        self.count += 1
        self.bad += not good
        print("%s %d - %s" % ("ok" if good else "not ok", self.count, words), flush=True)


def check_case(hooke, script, verdicts):
    computed, left_out = lists(hooke, script)
    found = counts(hooke, script + "; run", quiet=False)
    whole, wrong = found["command_run"], []
    for name, pattern, functions in PARTS:
        said = sum(price or 0 for words, price in computed.items() if re.search(pattern, words))
        counted = 100 * sum(found.get(function, 0) for function in functions) / whole
        if max(said, counted) >= SHARE_MIN and not counted / FACTOR <= said <= FACTOR * counted:
            wrong.append("%s: %.2g %% said, %.2g %% counted" % (name, said, counted))
    for name, pattern, functions in ABSENT:
        # A part of it may be in the other list, under another name.
        elsewhere = name == "energy balance" and any("energy" in w or "dE/E0" in w for w in computed)
        elsewhere |= name == "closed form" and any("closed form" in w for w in computed)
        elsewhere |= name == "columns" and any("energy" in w or "dE/E0" in w for w in computed)
        counted = 100 * max(found.get(function, 0) for function in functions) / whole
        if any(re.search(pattern, words) for words in left_out) and not elsewhere and counted > LEFT_OUT_MAX:
            wrong.append("%s is left out: %.2g %% counted" % (name, counted))
    for words in left_out:
        if not any(re.search(pattern, words) for pattern in [OTHERWISE] + [absent[1] for absent in ABSENT]):
            wrong.append("nothing counts what is left out as '%s'" % words)
    verdicts.say(not wrong, "%s%s" % (script, "".join("\n#   " + line for line in wrong)))


def check_names(hooke, verdicts):
    """A function that goes by another name, or into its caller, would be counted as nothing."""
    told = subprocess.run(["nm", hooke], capture_output=True, text=True, check=True).stdout
    known = set(re.findall(r" [tT] (\w+)", told))
    missing = [function for part in PARTS + ABSENT for function in part[2] if function not in known]
    verdicts.say(not missing, "the functions that are counted exist%s" % "".join("\n#   no " + f for f in missing))


def check_absent_forces(hooke, verdicts):
    """A scene whose other forces were there and got the coefficient 0."""
    for off, bare in [("scene driven; F0 = 0; gamma = 0; y0 = 5 cm", "scene spring"),
                      ("scene drag; C = 0; gamma = 0", "scene spring"),
                      ("scene duffing; k3 = 0; gamma = 0; y0 = 5 cm", "scene spring")]:
        rest = "; set kernel specialised; method rk4 dt=10ms; run 100 s"
        with_it, without = (counts(hooke, script + rest, quiet=True)["run_advance"] for script in (off, bare))
        share = 100 * (with_it / without - 1)
        verdicts.say(share <= LEFT_OUT_MAX, "%s: %.2g %% more than %s" % (off, share, bare))


def check_quiet(hooke, scenes, methods, verdicts):
    for scene in scenes:
        for method in methods:
            found = counts(hooke, "scene %s; method %s dt=10ms; run 5000 s" % (scene, method), quiet=True)
            ratio = found["command_run"] / found["run_advance"]
            verdicts.say(ratio <= QUIET_MAX, "%s by %s, 5e5 steps: %.3f times the steps alone" %
                         (scene, method, ratio))


def check_adaptive(hooke, verdicts):
    for script in ADAPTIVE:
        for quiet, limit in ((False, OPINION_MAX), (True, QUIET_MAX)):
            found = counts(hooke, script, quiet)
            ratio = (found["command_run"] - found["run_create"]) / found["run_advance"]
            verdicts.say(ratio <= limit, "%s%s: %.3f times the steps alone" %
                         (script, " (-q)" if quiet else "", ratio))


def recording(path, fault):
    """A damped sine of 72.26 rows a period with normal noise of 1 %."""
    random_numbers = random.Random(fault)
    with open(path, "w", encoding="ascii") as file:
        file.write("Time (s)\tDistance (cm)\n")
        for i in range(CLEAN_ROWS):
            y = 5 * math.exp(-1.5 * i / CLEAN_ROWS) * math.cos(2 * math.pi * i / 72.26 + 1)
            y = min(y, 2.4) if fault == "flat tops" else y
            y += 2.5 if fault == "spikes" and random_numbers.random() < 0.005 else 0
            file.write("%.2f\t%.3f\n" % (0.01 * i, y + random_numbers.gauss(0, 0.05)))


def check_clean(hooke, verdicts):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "rows.txt")
        for fault, limit in CLEAN.items():
            recording(path, fault)
            price = counts(hooke, "load %s; data clean" % path, quiet=True)["find_faults"] / CLEAN_ROWS
            verdicts.say(price <= limit, "data clean, %s: %.0f instructions a row" % (fault, price))


def check_short(hooke, verdicts):
    for script, limit in SHORT:
        found = counts(hooke, script, quiet=True)
        ratio = (found["command_run"] - found["run_create"]) / found["run_advance"]
        verdicts.say(ratio <= limit, "%s (-q): %.3f times the steps alone" % (script, ratio))


def check_memory(hooke, verdicts):
    with tempfile.TemporaryDirectory() as folder:
        script = "scene drag; method rk4 dt=10ms; run 10000 s; report %s" % os.path.join(folder, "out")
        child = subprocess.Popen([hooke, "-n", "-q", "-c", script])
        status, usage = os.wait4(child.pid, 0)[1:]
        mega = usage.ru_maxrss / 1e3
        verdicts.say(status == 0 and mega <= MEMORY_MAX, "report of 1e6 rows: %.1f MB" % mega)


def check_screen(hooke, verdicts):
    def said(script):
        return subprocess.run([hooke, "-n", "--color", "never", "-c", script], capture_output=True,
                              text=True).stdout
    tall, plans = [], 0
    for scene in re.findall(r"^(\S+)", said("list scenes"), re.MULTILINE):
        for method in ("verlet", "gauss4", "dopri5", "rodas5p"):
            text = said("scene %s; method %s; plan" % (scene, method))
            text = text[text.find("\nscene  "):] if "\nscene  " in text else ""
            lines = sum(1 + (len(line) - 1) // SCREEN_COLUMNS for line in text.splitlines() if line)
            plans += lines > 0
            if lines > SCREEN_LINES:
                tall.append("%s by %s: %d lines" % (scene, method, lines))
    verdicts.say(plans > 60 and not tall, "%d plans fit on the screen%s" %
                 (plans, "".join("\n#   " + line for line in tall)))


def main():
    hooke = sys.argv[-1]
    is_long = "--long" in sys.argv
    verdicts = Verdicts()
    check_names(hooke, verdicts)
    for script in CASES:
        check_case(hooke, script, verdicts)
    check_absent_forces(hooke, verdicts)
    check_adaptive(hooke, verdicts)
    check_clean(hooke, verdicts)
    check_memory(hooke, verdicts)
    check_short(hooke, verdicts)
    check_screen(hooke, verdicts)
    methods = ["euler", "symplectic-euler", "verlet", "rk4"]
    check_quiet(hooke, QUIET if is_long else QUIET[::2], methods if is_long else methods[1:3], verdicts)
    print("1..%d" % verdicts.count)
    return verdicts.bad > 0


sys.exit(main())
