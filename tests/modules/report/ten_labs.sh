#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The guided lab with ten pairs of recordings of one's own, at a terminal: what is handed in against values that hooke has not
# computed. Three orders: as offered; masses before the recordings, which are loaded before `lab`; everything typed, in other units.
# Real recordings are those of HOOKE_DATA, with the reference values of their documentation; without them they are left out.
set -u
hooke=$PWD/${HOOKE:-build/hooke}
data=$(realpath -m "${HOOKE_DATA:-../shared/data}")
folder=$(mktemp -d) || exit 2
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
XDG_STATE_HOME=$folder/state XDG_CONFIG_HOME=$folder/config TERM=xterm python3 - "$hooke" "$data" <<'END'
import csv, fcntl, math, os, pty, random, re, select, shutil, struct, sys, termios, time

HOOKE, DATA = sys.argv[1:3]
PATIENCE = 300 # [s] of the clock: the machine may be busy

class Prompt:
    def __init__(self, folder):
        self.said = b""
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
            os.execv(HOOKE, [HOOKE, "-n", "--plain", "--color", "never"])
        self.wait(0, False)

    def wait(self, begun, echoes=True):
        end = time.time() + PATIENCE
        while time.time() < end:
            new = re.sub(rb"\x1b\[[0-9;?]*[A-Za-z]", b"", self.said[begun:])
            if (b"\n" in new or not echoes) and re.search(rb"(hooke|lab \d+/\d+)> $", new):
                return new.decode().replace("\r", "")
            if select.select([self.fd], [], [], 1)[0]:
                self.said += os.read(self.fd, 65536)
        raise SystemExit("no prompt after:\n" + self.said[begun:].decode())

    def type(self, line):
        begun = len(self.said)
        os.write(self.fd, line.encode() + b"\r")
        self.last = self.wait(begun)
        return self.last

    def enter(self): # takes what is offered, asking for it if it is not shown
        while "next (Enter)" not in self.last:
            before = self.last
            if self.type("") == before:
                raise SystemExit("nothing is offered after:\n" + before)
        return self.type("")

    def step(self):
        found = re.findall(r"lab (\d+)/\d+> $", self.last)
        return int(found[0]) if found else 0

    def end(self):
        os.write(self.fd, b"\x04")
        try:
            while os.read(self.fd, 65536):
                pass
        except OSError:
            pass
        os.waitpid(self.pid, 0)

def read(said, pattern):
    found = re.findall(pattern, said)
    if not found:
        raise SystemExit(f"no {pattern} in:\n{said}")
    return float(found[-1])

def right(p, line, step):
    said = p.type(line)
    if "right" not in said or p.step() != step:
        raise SystemExit(f"'{line}' at step {step - 1} is not right:\n{said}")

T, K, DE, RE = r"\nT = ([\d.]+) ", r"\nk = ([\d.]+) .*\(m = ", r"dE/E0 = ([\d.]+) at", r"\nRe = ([\d.]+) "
TAU, GAMMA = r"\n1/e time of the amplitude tau = ([\d.]+) ", r"\ngamma = ([\d.]+) .*exp\(-gamma t/2\); "
FALLS = r"\ngamma = ([\d.]+) .*energy falls"

def as_offered(p, bare, disk, m, m_disk):
    p.type("lab seed=4")
    p.type(f"load {bare}")
    right(p, f"check {read(p.enter(), T)} s", 3)
    p.type(f"m = {m} +- 0.1 g")
    right(p, f"check {read(p.enter(), K)} N/m", 4)
    p.enter()
    p.enter()
    right(p, f"check {read(p.enter(), DE)}", 7)
    p.enter()
    if p.step() != 8:
        raise SystemExit("step 7:\n" + p.last)
    right(p, f"check {read(p.enter(), RE)}", 9)
    p.type(f"load {disk}")
    right(p, f"check {read(p.enter(), TAU)} s", 11)
    p.type(f"m = {m_disk} +- 0.1 g")
    p.enter()
    right(p, f"check {read(p.enter(), FALLS)} 1/s", 13)

def mass_first(p, bare, disk, m, m_disk):
    p.type(f"m = {m} +- 0.1 g")
    p.type(f"load {bare}")
    p.type("lab seed=4")
    said = p.type("measure period; fit damped; measure k")
    right(p, f"check {read(said, T)} s", 3)
    right(p, f"check {read(said, K)} N/m", 4)
    p.type("length = 5 cm")
    p.enter()
    p.enter()
    right(p, f"check {1 + read(p.enter(), DE)}", 7)
    p.enter()
    said = p.enter()
    if "length = 4" in said or "length = 4" in p.type("print length"):
        raise SystemExit("the length was replaced:\n" + said)
    right(p, f"check {read(said, RE)}", 9)
    p.type(f"m = {m_disk} +- 0.1 g")
    p.type(f"load {disk}")
    right(p, f"check {read(p.enter(), GAMMA)} 1/s", 11)
    p.enter()
    right(p, f"check {read(p.enter(), FALLS)} 1/s", 13)

def all_typed(p, bare, disk, m, m_disk):
    p.type("lab seed=4")
    p.type(f"load {bare}")
    right(p, f"check ({1 / read(p.type('measure period'), T)}) Hz", 3)
    p.type("fit damped")
    p.type(f"m={m}(1)g")
    right(p, f"check {read(p.type('measure k'), K)} N/m", 4)
    p.type("measure amplitude")
    p.type("adopt amplitude; gamma = 0; method euler; dt = 10 ms")
    p.type("run 10 s")
    p.type("skip")
    right(p, f"check {read(p.type('measure drift'), DE)}", 7)
    p.type("compare euler symplectic-euler")
    p.type("length = 4 cm")
    right(p, f"check {read(p.type('measure reynolds'), RE)}", 9)
    p.type(f"load {disk}; m={m_disk}(1)g")
    right(p, f"check {read(p.type('measure decay'), TAU)} s", 11)
    p.type("fit damped; adopt")
    p.type("method rk4; run 20 s")
    right(p, f"check {read(p.type('measure decay of energy'), FALLS)} 1/s", 13)

def generated(folder, seed):
    """A spring of 0.01 % noise in mass; a sensor's noise, offset, header, window and rate differ."""
    r = random.Random(seed)
    k, m, amplitude, offset = r.uniform(13, 17), round(r.uniform(180, 220), 1), r.uniform(3, 6), r.uniform(19, 26)
    m_disk, g, rate = round(m + r.uniform(14, 18), 1), r.uniform(0.018, 0.035), r.choice([50, 60, 100, 125])
    decimal = "," if seed % 3 == 0 else "."
    truth = []
    for name, mass, gamma, span in ("bare", m, 0.008, r.uniform(7, 15)), ("disk", m_disk, g, r.uniform(45, 120)):
        omega = math.sqrt(k / (mass / 1000) - gamma ** 2 / 4)
        t0, phase = r.uniform(0, 60), r.uniform(0, 6)
        with open(f"{folder}/{name}-own.txt", "w") as out:
            out.write("Motion Sensor Data File Sep 20, 2018 1:40 PM\r\nTime (s)\tDistance (cm)\tDist Error (cm)\r\n")
            for i in range(int(span * rate)):
                t = i / rate
                y = offset + amplitude * math.exp(-gamma * t / 2) * math.cos(omega * t + phase) + r.gauss(0, 0.02)
                out.write(f"{t0 + t:.3f}\t{y:.3f}\t0.239\r\n".replace(".", decimal))
        truth.append((2 * math.pi / omega, gamma))
    # k is known as well as the mass is: to 0.05 %
    return m, m_disk, [(truth[0][0], 2e-4), (k, 0.03), (truth[1][0], 2e-4), (g, 0.1 * g)]

# masses [g]; period, k, period with the disk, its gamma, and how far off they may be: the uncertainties of the reference values and of
# the masses, times three, and for gamma the law, which is not exponential
REAL = [
    ("uoft-pandhi/position data.txt", "uoft-pandhi/damped position.txt", 199.9, 216.6, [(0.72260, 0.001), (15.11, 0.05), (0.7526, 0.0006), (0.0241, 0.004)]),
    ("uoft-pankaj/undamped_point_data.txt", "uoft-pankaj/damped_point_data.txt", 200.0, 215.1, [(0.69325, 0.0002), (16.43, 0.03), (0.72275, 0.0003), (0.0175, 0.0045)]),
    ("uoft-travelwithwind/position.txt", "uoft-travelwithwind/position_damped.txt", 200, 216.7, [(0.7352, 0.006), (14.61, 0.24), (0.7649, 0.0012), (0.030, 0.006)]),
    ("uoft-kamjha/position_osc.txt", "uoft-kamjha/position_drag_osc2[3835].txt", 200, 216.6, [(0.68910, 0.0002), (16.63, 0.03), (0.7187, 0.0003), (0.0320, 0.0045)]),
]
ORDERS = [as_offered, mass_first, all_typed]
NAMES = ["period", "k", "period with the disk", "gamma"]

def handed_in(folder):
    with open(f"{folder}/lab-report-4/values.csv") as table:
        rows = list(csv.DictReader(line for line in table if not line.startswith("#")))
    def last(name, subject, source="measured"):
        found = [float(r["value"]) for r in rows if r["name"] == name and r["of"] == subject and r["source"].startswith(source)]
        return found[-1] if found else math.nan
    period = last("period", "data disk-own", "fit damped")
    return [last("period", "data bare-own"), last("k", "data bare-own"), period, last("gamma", "data disk-own")]

count = bad = 0
for i in range(10):
    folder = f"lab{i}"
    os.mkdir(folder)
    what = "generated"
    if i < len(REAL):
        bare, disk, m, m_disk, truth = REAL[i]
        what = bare.split("/")[0]
        if not os.path.exists(f"{DATA}/{bare}"):
            print(f"# {what}: no such recording here: left out")
            continue
        shutil.copy(f"{DATA}/{bare}", f"{folder}/bare-own.txt")
        shutil.copy(f"{DATA}/{disk}", f"{folder}/disk-own.txt")
    else:
        m, m_disk, truth = generated(folder, i)
    for order in ORDERS if os.environ.get("LONG") else [ORDERS[i % 3]]:
        count += 1
        p = Prompt(folder)
        try:
            order(p, "bare-own.txt", "disk-own.txt", m, m_disk)
            p.enter()
            said = p.said.decode()
            wrong = ["not the end"] if "the lesson is finished" not in said else []
            wrong += [said[max(0, said.find("error: ") - 300):][:600]] if "error: " in said else []
            for name, value, (wanted, room) in zip(NAMES, handed_in(folder), truth):
                if not abs(value - wanted) <= room:
                    wrong.append(f"{name} = {value}, wanted {wanted} +- {room}")
            if os.system(f"cd {folder} && '{HOOKE}' -n --check lab-report-4 >checked 2>&1"):
                wrong.append(open(f"{folder}/checked").read())
        except SystemExit as failure:
            wrong = [str(failure)]
        p.end()
        bad += bool(wrong)
        print(("not ok" if wrong else "ok"), count, "-", what, i, order.__name__.replace("_", " "))
        for text in wrong:
            print("# " + text.replace("\n", "\n# "))
        shutil.rmtree(f"{folder}/lab-report-4", ignore_errors=True)
        for made in "bare-4.txt", "disk-4.txt":
            if os.path.exists(f"{folder}/{made}"):
                os.remove(f"{folder}/{made}")
print(f"1..{count}")
sys.exit(bad > 0)
END
