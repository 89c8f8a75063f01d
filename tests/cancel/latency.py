#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C at random times: how long each command takes to give the prompt back, and what it leaves.

usage: latency.py [--trials N] [--rows N] [--batch] [--short] [--tap] [--limit MS] [--longest S] [--verbose] HOOKE FOLDER [NAME ...]

Without --tap: a table of the whole time of each command [s] and, after Ctrl-C, p50, p99 and the worst latency [ms].

FOLDER receives the recordings that it does not have yet. The program runs at a prompt in a pseudo-terminal; a
command is first run to its end, at most 30 s (--longest), then N times (10) with Ctrl-C after a time uniform in its length.
Latencies are from the signal to the next prompt (--batch: to the end of the process), in ms, less what the
program and this script waited for a processor meanwhile. Afterwards the session has to be what it was before or
what the whole command leaves, and the next command has to work. What is late is tried again at the same times, at
most twice: only what is late each time counts, as others use the machine.
Status 1: a 99th percentile (of few trials: the largest) is above the limit (100 ms), a command was refused, or a
session was not sane.
"""
import argparse
import os
import pty
import random
import re
import select
import shutil
import signal
import sys
import time

import cases

INSTANT = 0.02 # [s] nobody can be too late there
PROMPT = re.compile(rb"(hooke|lab \d+/\d+)> $")
REFUSED = re.compile(rb"error: (?!no digit|t from)[^\r\n]*")
LOOKS = "show; list recordings; list measurements"
ENDED = re.compile(rb"(stopped|interrupted|paused|cancelled)[^\r\n]*")


def waited(pid):
    """[s] in the queue for a processor."""
    try:
        with open("/proc/%d/schedstat" % pid) as file:
            return int(file.read().split()[1]) * 1e-9
    except (OSError, IndexError):
        return 0.0


def is_asleep(pid):
    """It waits for something; one that has ended, too."""
    try:
        with open("/proc/%d/stat" % pid) as file:
            return file.read().rsplit(")", 1)[1].split()[0] not in "RD"
    except (OSError, IndexError):
        return True


class Program:
    def __init__(self, program, folder, *arguments):
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.environ.update(TERM="dumb", HOOKE_AUTOSAVE="100000", XDG_STATE_HOME=folder, LC_ALL="C.UTF-8")
            os.execv(program, [program, "-n", "--plain", "--size", "80x20", *arguments])
        self.said = b""
        self.over = False

    def wait(self, seconds, kept=1 << 13):
        """True: the prompt came, or the end."""
        end = time.monotonic() + seconds
        while True:
            left = end - time.monotonic()
            if left <= 0 or not select.select([self.fd], [], [], left)[0]:
                return False
            try:
                more = os.read(self.fd, 1 << 16)
            except OSError:
                more = b""
            self.over = self.over or not more
            self.said = (self.said + more)[-kept:]
            if self.over or PROMPT.search(self.said):
                return True

    def send(self, line):
        self.said = b""
        os.write(self.fd, line.encode() + b"\r")

    def do(self, line, seconds=30.0):
        self.send(line)
        return self.wait(seconds) and not self.over

    def interrupt(self, seconds=20.0):
        """Latencies [ms]."""
        self.said = b""
        before = waited(self.pid), waited(os.getpid())
        start = time.monotonic()
        os.kill(self.pid, signal.SIGINT)
        if not self.wait(seconds):
            return float("inf")
        wall = time.monotonic() - start
        queued = waited(self.pid) - before[0] if not self.over else 0.0
        return max(wall - max(queued, 0.0) - (waited(os.getpid()) - before[1]), 0.0) * 1e3

    def settle(self):
        """The signal may have come to the prompt that the command left: then it gives another one."""
        end = time.monotonic() + 20
        while not self.over and time.monotonic() < end:
            if select.select([self.fd], [], [], 0.02)[0]:
                self.wait(1)
            elif is_asleep(self.pid): # not kept from its work by others
                break

    def looks(self):
        """What the session holds, as it says itself."""
        self.do(LOOKS)
        return self.said.split(LOOKS.encode())[-1].replace(b"\r", b"").strip()

    def end(self):
        """The exit status."""
        if not self.over:
            os.kill(self.pid, signal.SIGKILL)
        status = os.waitpid(self.pid, 0)[1]
        os.close(self.fd)
        return status


class Result:
    def __init__(self):
        self.length = 0.0
        self.latencies = []
        self.said = set()
        self.wrong = []


def begin(program, folder, before, result):
    at = Program(program, folder)
    at.wait(5)
    for line in filter(None, before.split("; ")):
        if not at.do(line, 120) or REFUSED.search(at.said):
            result.wrong.append("set-up: %s: %r" % (line, at.said[-2500:]))
            break
    return at


def try_once(at, case, after_seconds, result):
    """False: the command was over before the interrupt came."""
    name, before, command, after, leaves = case
    held = at.looks()
    at.send(command)
    if at.wait(after_seconds):
        return False
    result.latencies.append(at.interrupt())
    at.settle()
    said = [m.group(0) for m in ENDED.finditer(at.said)]
    result.said.update(said)
    if at.over or result.latencies[-1] == float("inf"):
        result.wrong.append("died" if at.over else "hangs")
        return True
    now = at.looks()
    if leaves != "+" and said and now != held:
        result.wrong.append("changed: %r, was %r" % (now, held))
    if not at.do("print 2+3") or not re.search(rb"\r5\r\n", at.said):
        result.wrong.append("next: %r" % at.said)
    return True


def at_prompt(program, folder, case, trials, longest, rng, kept):
    """kept: the program of the last case, where this one goes on with it."""
    name, before, command, after, leaves = case
    result = Result()
    at = kept.pop() if kept else begin(program, folder, before, result)
    start = time.monotonic()
    if not at.over and not result.wrong:
        whole = at.do(command, longest)
        result.length = time.monotonic() - start
        if whole and REFUSED.search(at.said):
            result.wrong.append("refused: %r" % REFUSED.search(at.said).group(0))
        if not whole and not at.over:
            result.latencies.append(at.interrupt())
            at.settle()
    early = 0
    for _ in range(trials if result.length > INSTANT else 0):
        if early > 1: # what it found is kept: each trial from the beginning
            at.end()
            at = begin(program, folder, before, result)
        elif after and not at.do(after, 10):
            at.interrupt()
            at.settle()
        if result.wrong or at.over:
            break
        early += not try_once(at, case, rng.uniform(0, min(result.length, 10.0)), result)
    if at.over:
        result.wrong.append("died: %r" % at.said[-2500:])
    if leaves == "=" and not result.wrong:
        kept.append(at)
    else:
        at.end()
    return result


def at_start(program, folder, case, trials, longest, rng, kept):
    """Ctrl-C while --resume reads a session of 2.5e6 rows and a recording: the next start finds all of it."""
    result = Result()
    state = os.path.join(folder, "resumed")
    saved = os.path.join(state, "hooke")
    os.makedirs(state, exist_ok=True)
    begin(program, state, cases.RESUMED, result).end()
    name = sorted(os.listdir(saved))[-1]
    os.replace(os.path.join(saved, name), os.path.join(state, "kept"))

    def resume():
        shutil.rmtree(saved)
        os.mkdir(saved, 0o700)
        os.link(os.path.join(state, "kept"), os.path.join(saved, name))
        return Program(program, state, "--resume")

    start = time.monotonic()
    at = resume()
    at.wait(longest)
    result.length = time.monotonic() - start
    held = at.looks()
    at.end()
    for _ in range(trials):
        at = resume()
        if not at.wait(rng.uniform(0.01, result.length)):
            result.latencies.append(at.interrupt())
            result.said.update(m.group(0) for m in ENDED.finditer(at.said))
            if os.WIFSIGNALED(at.end()) and at.over:
                result.wrong.append("died: %r" % at.said[-2500:])
            at = Program(program, state, "--resume")
            at.wait(longest)
            if at.looks() != held:
                result.wrong.append("not as it was: %r" % at.said[-2500:])
        at.end()
    return result


def in_batch(program, folder, case, trials, longest, rng, kept):
    name, before, command, after, leaves = case
    result = Result()
    lines = [] if not before else ["-c", before]

    def whole(*arguments):
        start = time.monotonic()
        at = Program(program, folder, *arguments)
        at.wait(longest + 30)
        length = time.monotonic() - start
        if not at.over:
            at.interrupt()
        at.end()
        return length

    first = whole(*lines, "-c", "")
    result.length = max(whole(*lines, "-c", command) - first, 0.01)
    for _ in range(trials):
        at = Program(program, folder, *lines, "-c", command)
        if at.wait(first + rng.uniform(0, min(result.length, 10.0))):
            at.end()
            continue
        result.latencies.append(at.interrupt())
        status = at.end()
        if os.WIFSIGNALED(status):
            result.wrong.append("ended by signal %d" % os.WTERMSIG(status))
        if result.latencies[-1] == float("inf"):
            break
    return result


def main():
    ask = argparse.ArgumentParser()
    ask.add_argument("--trials", type=int, default=10)
    ask.add_argument("--rows", type=int, default=2000000)
    ask.add_argument("--limit", type=float, default=100)
    ask.add_argument("--longest", type=float, default=30.0)
    ask.add_argument("--batch", action="store_true")
    ask.add_argument("--short", action="store_true")
    ask.add_argument("--tap", action="store_true")
    ask.add_argument("--verbose", action="store_true", help="what the program said when it ended")
    ask.add_argument("hooke")
    ask.add_argument("folder")
    ask.add_argument("names", nargs="*")
    asked = ask.parse_args()
    program = os.path.abspath(asked.hooke)
    os.makedirs(asked.folder, exist_ok=True)
    only = asked.names or asked.short and cases.SHORT
    chosen = [case for case in cases.CASES if not only or case[0] in only]
    cases.recordings(program, asked.folder, asked.rows, [case[1] + case[2] for case in chosen])
    bad = 0
    kept = []
    if not asked.tap:
        print("%-40s %8s %8s %8s %8s" % ("command", "whole s", "p50 ms", "p99 ms", "worst ms"))
    for number, case in enumerate(chosen, 1):
        if kept and case[4] != "=":
            kept.pop().end()
        measure = at_start if case[0] == "--resume" else in_batch if asked.batch else at_prompt
        for _ in range(3):
            result = measure(program, asked.folder, case, asked.trials, asked.longest, random.Random(case[0]), kept)
            all_of = sorted(result.latencies) or [min(result.length, INSTANT) * 1e3]
            at = [all_of[min(len(all_of) - 1, int(q * len(all_of)))] for q in (0.5, 0.99, 1)]
            late = at[1] > asked.limit
            if not late or result.wrong:
                break
        bad += late or bool(result.wrong)
        if asked.tap:
            print("%sok %d - Ctrl-C in %s: %.0f ms%s"
                  % ("not " if late or result.wrong else "", number, case[0], at[1], " ".join(["", *result.wrong])),
                  flush=True)
            continue
        print("%-40s %8.2f %8.1f %8.1f %8.1f%s" % (case[0], result.length, *at, "  <<" if late else ""), flush=True)
        for line in result.wrong[:2]:
            print("    " + line[:2500])
        for line in sorted(result.said) if asked.verbose else ():
            print("    | " + line.decode(errors="replace"))
    if asked.tap:
        print("1..%d" % len(chosen))
    sys.exit(bad > 0)


main()
