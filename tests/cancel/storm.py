#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Storms of signals: Ctrl-C, Ctrl-Z and back, other sizes, many in a row while runs are computed and saved.

usage: storm.py [--rounds N] [--signals N] [--seed N] HOOKE FOLDER

At the plain prompt and in panes, under a shell that continues what is stopped. After each storm the prompt answers
within 10 s; a second later the program is killed, and the next one resumes what was there, runs and all. The last
round ends with `quit`: the terminal is as it was. Status 1: something was not.
"""
import argparse
import fcntl
import os
import pty
import random
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time

WORK = ("run 300 s --force", "compare euler rk4 verlet dt=2ms --force", "continue 100 s --force", "drop all",
        "back 1000", "change gamma = 0.02", "runs", "measure period", "help run", "plot position", "sweep gamma=0:1:0.05")


def shell(arguments, folder):
    """In the terminal's session: what is stopped goes on 5 ms later."""
    for number in (signal.SIGTTOU, signal.SIGINT, signal.SIGQUIT, signal.SIGTSTP):
        signal.signal(number, signal.SIG_IGN)
    program = os.fork()
    if program == 0:
        os.setpgid(0, 0)
        os.tcsetpgrp(0, os.getpid())
        for number in (signal.SIGTTOU, signal.SIGINT, signal.SIGQUIT, signal.SIGTSTP):
            signal.signal(number, signal.SIG_DFL)
        os.chdir(folder)
        os.execve(arguments[0], arguments, dict(os.environ, TERM="xterm-256color", LC_ALL="C.UTF-8",
                                                XDG_STATE_HOME=folder, HOOKE_AUTOSAVE="0.1"))
    while True:
        status = os.waitpid(program, os.WUNTRACED)[1]
        if not os.WIFSTOPPED(status):
            os._exit(os.waitstatus_to_exitcode(status) & 255)
        os.tcsetpgrp(0, os.getpid())
        time.sleep(0.005)
        os.tcsetpgrp(0, program)
        os.kill(program, signal.SIGCONT)


class Terminal:
    def __init__(self, arguments, folder):
        self.said = self.all = b""
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            try:
                shell(arguments, folder)
            finally:
                os._exit(127)
        self.modes = termios.tcgetattr(self.fd)
        self.over = False

    def read(self, seconds):
        """What comes in that time; answers what the program asks the terminal."""
        end = time.monotonic() + seconds
        while not self.over and select.select([self.fd], [], [], max(end - time.monotonic(), 0))[0]:
            try:
                more = os.read(self.fd, 1 << 16)
            except OSError:
                more = b""
            self.over = not more
            self.said += more
            self.all += more
            if b"\x1b[6n" in more:
                self.type("\x1b[1;1R")
            if b"\x1b[5n" in more:
                self.type("\x1b[0n")
            if b"\x1b[c" in more:
                self.type("\x1b[?1;2c")
            if time.monotonic() > end:
                return

    def type(self, keys):
        try:
            os.write(self.fd, keys.encode())
        except OSError:
            self.over = True

    def wait(self, pattern, seconds):
        end = time.monotonic() + seconds
        while not self.over and time.monotonic() < end:
            if re.search(pattern, self.said):
                return True
            self.read(0.05)
        return bool(re.search(pattern, self.said))

    def answers(self, number, seconds):
        self.type("print 5%03d0 + 1\r" % number)
        return self.wait(b"5%03d1" % number, seconds)

    def program(self):
        return os.tcgetpgrp(self.fd)

    def size(self, rng):
        fcntl.ioctl(self.fd, termios.TIOCSWINSZ, struct.pack("HHHH", rng.randint(6, 60), rng.randint(20, 200), 0, 0))


def storm(terminal, signals, rng):
    for _ in range(signals):
        act = rng.random()
        if act < 0.25:
            terminal.type(rng.choice(WORK) + "\r")
        elif act < 0.6:
            terminal.type("\x03" * rng.choice((1, 1, 2, 20)))
        elif act < 0.7:
            terminal.type("\x1a")
        elif act < 0.9:
            terminal.size(rng)
        else:
            try:
                os.killpg(terminal.program(), rng.choice((signal.SIGCONT, signal.SIGWINCH, signal.SIGINT)))
            except OSError:
                pass
        terminal.read(rng.choice((0, 0.001, 0.005, 0.03, 0.1)))


def resumed(hooke, folder):
    out = subprocess.run([hooke, "-n", "--resume", "-c", "print mark; list runs"], cwd=folder, text=True,
                         env=dict(os.environ, XDG_STATE_HOME=folder, LC_ALL="C.UTF-8"), capture_output=True)
    return out.stdout + out.stderr


def kill(terminal):
    """A second after what was typed last, and when it is not kept from its work by others."""
    terminal.read(1)
    looks, end = 0, time.monotonic() + 20
    while looks < 5 and time.monotonic() < end:
        with open("/proc/%d/stat" % terminal.program()) as file:
            asleep = file.read().rsplit(")", 1)[1].split()[0] not in "RD"
        looks = looks + 1 if asleep else 0
        terminal.read(0.05)
    os.killpg(terminal.program(), signal.SIGKILL)
    os.waitpid(terminal.pid, 0)
    os.close(terminal.fd)
    return ""


def leave(terminal):
    """What is not as it was."""
    terminal.type("quit\r")
    end = time.monotonic() + 60
    while not os.waitpid(terminal.pid, os.WNOHANG)[0]:
        terminal.read(0.05)
        if time.monotonic() > end:
            return "it does not end: %r" % terminal.said[-300:]
    terminal.read(0.1)
    if termios.tcgetattr(terminal.fd)[:4] != terminal.modes[:4]:
        return "the terminal's modes are not as they were"
    for on, off in (("1049h", "1049l"), ("2004h", "2004l"), ("25l", "25h")):
        if terminal.all.rfind(b"\x1b[?" + on.encode()) > terminal.all.rfind(b"\x1b[?" + off.encode()):
            return "ESC [ ? %s is not taken back" % on
    os.close(terminal.fd)
    return ""


def one_round(hooke, folder, mode, number, signals, rng, last):
    """What is wrong."""
    subprocess.run(["rm", "-rf", os.path.join(folder, "hooke")])
    terminal = Terminal([hooke, "-n", *mode], folder)
    terminal.wait(b"hooke>", 60)
    terminal.read(0.5)
    terminal.type("speed max; scene damped\r")
    terminal.type("method rk4 dt=1ms; set record all; run 30 s\r")
    if not terminal.answers(number, 60):
        return "it does not begin: %r" % terminal.said[-300:]
    storm(terminal, signals, rng)
    fcntl.ioctl(terminal.fd, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    terminal.said = b""
    for _ in range(10): # keys before a Ctrl-C are thrown away; q leaves a long text
        for key in "\x03q\x03":
            terminal.type(key)
            terminal.read(0.2)
        terminal.type("let mark = %d\r" % number)
        if terminal.answers(number, 2):
            break
    else:
        return "it hangs: %r" % terminal.said[-300:]
    held = b""
    if "--plain" in mode:
        terminal.said = b""
        terminal.type("list runs\r")
        terminal.wait(b"hooke> $", 30)
        held = terminal.said.split(b"list runs", 1)[-1].split(b"\x1b[?2004h")[0].split(b"\x1b[?2004l")[-1]
    what = leave(terminal) if last else kill(terminal)
    said = resumed(hooke, folder)
    if not re.search(r"^%d$" % number, said, re.M) or held.decode().replace("\r", "").strip() not in said:
        return what or "lost: %s, was %s" % (said[-600:], held)
    return what


def main():
    ask = argparse.ArgumentParser()
    ask.add_argument("--rounds", type=int, default=2)
    ask.add_argument("--signals", type=int, default=60)
    ask.add_argument("--seed", type=int, default=1)
    ask.add_argument("hooke")
    ask.add_argument("folder")
    asked = ask.parse_args()
    hooke = os.path.abspath(asked.hooke)
    bad = 0
    modes = (("the plain prompt", ["--plain"]), ("panes", []))
    for test, (name, mode) in enumerate(modes, 1):
        wrong = []
        for number in range(1, asked.rounds + 1):
            rng = random.Random("%d %d %s" % (asked.seed, number, name))
            what = one_round(hooke, asked.folder, mode, number, asked.signals, rng, number == asked.rounds)
            if what:
                wrong.append("round %d: %s" % (number, what))
        bad += bool(wrong)
        print("%sok %d - storms of signals at %s%s" % ("not " if wrong else "", test, name,
                                                      "".join("\n# " + line for line in wrong)), flush=True)
    print("1..%d" % len(modes))
    sys.exit(bad > 0)


main()
