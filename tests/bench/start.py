# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the static program takes from start to end, beside an empty static one: in turn, so
that both meet the same machine; medians of ratios.  start.py PROGRAM FOLDER"""
import os
import statistics
import subprocess
import sys
import time

PAIRS = 400
program, folder = sys.argv[1:3]
empty = os.path.join(folder, "empty")
subprocess.run([os.environ.get("CC", "cc").split()[-1], "-O2", "-static", "-s", "-x", "c", "-", "-o", empty],
               input=b"int main(void) { return 0; }", check=True)
nowhere = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]


def seconds(*argv):
    begin = time.perf_counter()
    os.waitpid(os.posix_spawn(argv[0], argv, {"LC_ALL": "C.UTF-8"}, file_actions=nowhere), 0)
    return time.perf_counter() - begin


for arguments in (["--version"], ["-n", "-c", "quit"], ["-n", "-c", "print 1"]):
    pairs = [(seconds(program, *arguments), seconds(empty)) for _ in range(PAIRS)]
    ratio = statistics.median(a / b for a, b in pairs)
    own, other = (statistics.median(column) * 1e6 for column in zip(*pairs))
    print(f"start, static: {' '.join(arguments):14} {own:5.0f} us, empty program {other:4.0f} us: {ratio:.2f}")
