#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds `load scene FILE.ode` against XPPAUT's own runs of the files that it brings.

    xppaut.py HOOKE FILE.ode..        prints a row for each: agrees, differs, refused (why), or what
                                      XPPAUT itself does not run; the last line counts them

Both integrate over the file's own total, by the same method at the same dt where steps are fixed.
Where XPPAUT adapts its steps, or finds events by a straight line between two of them, it gets finer
tolerances or steps in a last line of settings, which is the one that holds; it writes 8 digits.
What a run does with an error grows along chaotic motion: a second run of hooke from a start that
is off by as much as rounding, or as XPPAUT's tolerance, says by how much, and for how long there is anything to compare.
"""
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

DIGITS = 2e-6       # of the largest value of a column: XPPAUT computes with double, writes float
ADAPTED = 2e-4      # where it adapts its steps
NEAR = 1e-3         # from where on two starts count as apart
SHARE = 0.05        # of the run that has to be comparable,
LONG = 40           # or so many units of time
METHODS = "qgcs25 8".replace(" ", "")  # that adapt


def run(command, folder):
    return subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, timeout=300,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")


def rows_of(path, separator=None):
    rows = []
    with open(path, errors="replace") as file:
        for line in file:
            try:
                rows.append([float(word) for word in line.split(separator)])
            except ValueError:
                pass
    return rows


def settings(text):
    """What holds: the last of each name."""
    found = {}
    for line in text.lower().splitlines():
        for name, value in re.findall(r"([a-z_0-9]+)=([^ ,;}]+)", line if line.startswith("@") else ""):
            for full in "total", "dt", "nout", "njmp", "meth", "t0":
                if name.startswith(full) and not name.startswith(("dtm",)):
                    found[full] = value
    return found


def before_end(text, line):
    end = re.search(r"(?m)^d(one)?\s*$", text)
    return text[:end.start()] + line + "\ndone\n" if end else text + "\n" + line + "\ndone\n"


def xppaut(text, folder, name, fine, tight="1e-12"):
    """Its rows by the name of the set, "" where there are none; fine: more steps."""
    file = name + ".ode"
    at = settings(text)
    head = "@ toler=%s, atoler=%s, maxstor=200000, bound=1e12" % (tight, tight)
    if fine > 1:
        head += ", dt=%r, nout=%d" % (float(at.get("dt", 0.05)) / fine,
                                      fine * int(float(at.get("nout", at.get("njmp", 1)))))
    folder = tempfile.mkdtemp(dir=folder)
    with open(os.path.join(folder, file), "w") as out:
        out.write(before_end(re.sub(r"(?m)^only.*", "", text), head))
    said = run(["xppaut", file, "-silent"], folder).stdout
    files = [f for f in sorted(os.listdir(folder)) if f != file]
    if not files:
        lines = [line for line in said.splitlines() if re.search("rror|uplicate|Probably|missing", line)]
        return None, (lines or ["it writes nothing"])[-1].strip()[:70]
    return {("" if f == "output.dat" else f[:-4]): rows_of(os.path.join(folder, f)) for f in files}, ""


def hooke(program, folder, name, chosen, change=""):
    out = os.path.join(folder, "own.csv")
    if os.path.exists(out):
        os.remove(out)
    line = "set opinion off; load scene %s.ode%s; %s run; export own.csv" % (
        name, " set=" + chosen if chosen else "", change)
    done = run([program, "-n", "-c", line], folder)
    if not os.path.exists(out):
        found = re.search(r"error: (.*)", done.stdout)
        return None, (found.group(1) if found else done.stdout).strip()
    return rows_of(out, ","), done.stdout


def column_names(folder):
    with open(os.path.join(folder, "own.csv")) as file:
        for line in file:
            if not line.startswith("#"):
                return line.strip().split(",")
    return []


def at_time(rows, t, from_row):
    """The row at t, from that on which was looked at before."""
    while from_row + 1 < len(rows) and abs(rows[from_row + 1][0] - t) <= abs(rows[from_row][0] - t):
        from_row += 1
    return from_row


def compare(theirs, ours, other, variables, auxiliary, tolerated, folds):
    """The largest difference, in parts of what is tolerated, and until when there was something to
    compare."""
    columns = list(range(1, 1 + variables))
    own_columns = columns + list(range(len(ours[0]) - auxiliary, len(ours[0])))
    their_columns = list(range(1, 1 + variables + auxiliary))
    sizes = [max((abs(row[c]) for row in theirs if math.isfinite(row[c])), default=0) or 1 for c in their_columns]
    worst, apart, k, where = 0.0, [0.0] * len(sizes), 0, ""
    step = theirs[1][0] - theirs[0][0] if len(theirs) > 1 else 1
    seen = 0
    for row in theirs:
        k = at_time(ours, row[0], k)
        if abs(ours[k][0] - row[0]) > 1e-3 * abs(step) + 2e-7 * abs(row[0]):
            return math.inf, row[0], "no row at t = %g" % row[0]
        if k >= len(other):
            return worst, row[0], where
        for i, (own, their) in enumerate(zip(own_columns, their_columns)):
            apart[i] = max(apart[i], abs(ours[k][own] - other[k][own]))
            off = abs(ours[k][own] - row[their])
            if folds:
                off = abs(math.remainder(off, folds))
            if math.isnan(ours[k][own]) and math.isnan(row[their]):
                continue
            part = off / (tolerated * sizes[i] + 100 * apart[i])
            if not part <= worst:
                worst, where = part, "column %d at t = %g: %g, there %g" % (own, row[0], ours[k][own], row[their])
        if any(100 * a > NEAR * s for a, s in zip(apart, sizes)):
            return worst, row[0], where
        seen += 1
    return worst, theirs[-1][0], where


def judge(program, path):
    name = os.path.basename(path)[:-4]
    with open(path, errors="replace") as file:
        text = file.read()
    folder = tempfile.mkdtemp()
    try:
        ours, said = hooke_check(program, folder, name, text)
        theirs, why = xppaut(text, folder, name, 1)
        if theirs is None:
            return "not run by XPPAUT", "it: %s; hooke: %s" % (why, reason(said) if ours is None else "loads")
        if ours is None:
            return "refused", reason(said)
        if all(row[1:] == theirs[chosen][0][1:] for chosen in theirs for row in theirs[chosen]):
            text = moved(program, folder, name, text)
        verdict, word = "differs", ""
        for finer, tight in attempts(text):
            verdict, word = of_all_sets(program, folder, name, text, finer, tight)
            if verdict == "agrees":
                break
        return verdict, word
    finally:
        shutil.rmtree(folder)


def reason(said):
    return re.sub(r"^.*?\.ode: ", "", said)


def attempts(text):
    """How much finer its steps are, and its tolerance: not all of its methods go to the finest."""
    if re.search(r"(?mi)^ *g[lobal]* +[-+0-9]", text):
        return (100, "1e-10"), (1000, "1e-10")
    if re.search(r"(?mi)^ *special", text):  # what it writes of a network is of the last stage within the step
        return (1, "1e-12"), (20, "1e-12")
    return ((20, "1e-12"),) if settings(text).get("meth", "r")[0] == "y" else ((1, "1e-12"), (1, "1e-10"))


def moved(program, folder, name, text):
    """Nothing moves from where the file starts: from somewhere else, then."""
    said = run([program, "-n", "-c", "load scene %s.ode; scene" % name], folder).stdout
    starts = ["%s=%.2f" % (variable, 0.2 + 0.07 * i)
              for i, variable in enumerate(re.findall(r"(?m)^  var (\w+) =", said))]
    return "init %s\n" % ",".join(starts) + text


def of_all_sets(program, folder, name, text, finer, tight):
    theirs, why = xppaut(text, folder, name, finer, tight)
    if theirs is None:
        return "differs", why
    words = []
    for chosen, rows in theirs.items():
        part, word = one(program, folder, name, text, chosen, rows, finer > 1)
        words.append(word)
        if not part <= 1:
            return "differs", (chosen + " " + word).strip()
    return "agrees", words[0]


def hooke_check(program, folder, name, text):
    with open(os.path.join(folder, name + ".ode"), "w") as out:
        out.write(text)
    done = run([program, "-n", "-c", "load scene %s.ode" % name], folder)
    found = re.search(r"error: (.*)", done.stdout)
    return (None, found.group(1)) if found else (True, "")


def one(program, folder, name, text, chosen, theirs, finer):
    method = settings(text).get("meth", "r")
    if chosen:
        body = re.search(r"(?i)set +%s *\{([^}]*)\}" % re.escape(chosen), text.replace("\\\n", " "))
        found = re.search(r"(?i)meth[a-z]*=([^ ,;}]+)", body.group(1)) if body else None
        method = found.group(1) if found else method
    adapts = method[0] in METHODS or method[0] == "y"
    with open(os.path.join(folder, name + ".ode"), "w") as out:
        out.write(text)
    even = "set record every %.6g s;" % (theirs[1][0] - theirs[0][0]) if len(theirs) > 1 else ""
    changes = ["set turning off;"]
    if adapts or finer:  # XPPAUT's steps are finer, ours are not: something more exact then
        changes = (["tol = 1e-11;", "tol = 1e-8;"] if adapts and not finer else
                   ["method dop853 tol=1e-11;" + even])
    for change in changes:
        ours, said = hooke(program, folder, name, chosen, change)
        if ours is not None:
            break
    if ours is None:
        return math.inf, said[:100]
    names = column_names(folder)
    nudged, said = hooke(program, folder, name, chosen, nudge(program, folder, name, chosen, 1e-10 if adapts else 1e-13) + change)
    if nudged is None:
        return math.inf, said[:100]
    counts = re.search(r"(\d+) variables?", run([program, "-n", "-c", "load scene %s.ode" % name], folder).stdout)
    variables = int(counts.group(1))
    auxiliary = len(theirs[0]) - 1 - variables
    if auxiliary < 0 or auxiliary + variables + 1 > len(names):
        return math.inf, "it has %d columns" % len(theirs[0])
    folds = 2 * math.pi if re.search(r"(?mi)^@.*fold", text) else 0
    part, until, where = compare(theirs, ours, nudged, variables, auxiliary,
                                 ADAPTED if adapts or finer else DIGITS, folds)
    length = theirs[-1][0] - theirs[0][0]
    if until - theirs[0][0] < min(SHARE * length, LONG):
        return math.inf, "comparable until t = %g of %g only" % (until, theirs[-1][0])
    if part > 1:
        return part, where
    return part, "%.2g of what is tolerated, until t = %g of %g" % (part, until, theirs[-1][0])


def nudge(program, folder, name, chosen, by):
    """Starts that are off by so many parts."""
    said = run([program, "-n", "-c", "load scene %s.ode%s; scene" % (name, " set=" + chosen if chosen else "")],
               folder).stdout
    lines = ""
    for variable, value in re.findall(r"(?m)^  var (\w+) = (\S+)", said):
        start = variable + ("_0" if variable[-1].isdigit() else "0")
        lines += "%s = %r; " % (start, float(value) * (1 + by) if float(value) else by)
    return lines


def main():
    program = os.path.abspath(sys.argv[1])
    counts = {}
    for path in sys.argv[2:]:
        try:
            verdict, word = judge(program, path)
        except subprocess.TimeoutExpired:
            verdict, word = "differs", "it takes too long"
        counts[verdict] = counts.get(verdict, 0) + 1
        print("%-24s %-18s %s" % (os.path.basename(path), verdict, word), flush=True)
    print("%d files: %s" % (len(sys.argv) - 2, ", ".join("%d %s" % (n, v) for v, n in sorted(counts.items()))))
    return 1 if counts.get("differs") else 0


if __name__ == "__main__":
    sys.exit(main())
