# SPDX-License-Identifier: GPL-3.0-or-later
"""What can take long: recordings of 2e6 rows (--rows), runs of 1e6 steps, and action with them."""
import gzip
import math
import os
import random
import subprocess
import zipfile

RECORDING = "load big.txt; m = 200 g"
FITTED = RECORDING + "; fit damped; adopt"
STEPS = "scene damped; gamma = 0.01; method verlet dt=1ms; set record all; run 1000 s --force"
DRIVEN = "scene duffing-driven; method rk4 dt=1ms; set record all; run 1000 s --force"
CHAOS = ("var x = 1; var y = 1; var z = 1; param rho = 28; x' = 10*(y - x); y' = x*(rho - z) - y; "
         "z' = x*y - 8/3*z")
LORENZ = CHAOS + "; method rk4 dt=1ms"
LAID = FITTED + "; method verlet dt=1ms; run 1000 s --force"
BANDED = FITTED + "; method verlet dt=1ms; run 60 s"
TOPS = LORENZ + "; event top when x*y - 8/3*z falling do record; set record all; run 1000 --force"
LARGE = STEPS + "; " + RECORDING
ROBERTSON = ("var x = 1; var y = 0; var z = 0; x' = -0.04*x + 1e4*y*z; "
             "y' = 0.04*x - 1e4*y*z - 3e7*y^2; z' = 3e7*y^2")
KEPLER = "scene kepler; method rk4 dt=1ms; set record all; run 1000 --force"
RESUMED = "load ../big.txt; m = 200 g; fit a*cos(w*t)+c w=8.7; " + STEPS + "; run 500 s --force; run 1000 s --force"
HODGKIN = ("param Iext = 10; var v = 5; var m = 0.1; var h = 0.5; var n = 0.3; "
           "v' = Iext-120*m^3*h*(v-115)-36*n^4*(v+12)-0.3*(v-10.599); "
           "m' = 0.1*(25-v)/(exp((25-v)/10)-1)*(1-m)-4*exp(-v/18)*m; "
           "h' = 0.07*exp(-v/20)*(1-h)-h/(exp((30-v)/10)+1); "
           "n' = 0.01*(10-v)/(exp((10-v)/10)-1)*(1-n)-0.125*exp(-v/80)*n")
FIXED = "euler verlet rk4 ab4 bdf2 tr-bdf2 radau5 gauss4"
MANY = ("heun ralston kutta3 rk38 dop853 yoshida8 kahan-li8 backward-euler implicit-midpoint trapezoid sdirk2 gauss6 "
        "radau3 ros3p rodas5p ab5 abm5 bdf4 bdf6 avf")
PLOTS = "position energy phase velocity error residual spectrum acceleration envelope period"
DRAWN = {"svg": "a.svg", "pdf": "a.pdf", "png": "a.png", "txt": "a.txt"}

COUPLED = "; ".join(["var %s = 1" % a for a in "abcdef"] + [
    "%s' = sin(%s*%s) - %s^3 + cos(%s)" % (a, a, b, b, a) for a, b in zip("abcdef", "bcdefa")])
ADAPTIVE = "bogacki-shampine dopri5 tsit5 dop853 rodas4 rodas5p tr-bdf2 radau5 odex rkn43".split()
IMPLICIT = ("backward-euler implicit-midpoint trapezoid sdirk2 tr-bdf2 gauss4 gauss6 radau3 radau5 bdf4 avf hht rodas5p "
            "exact").split()

# recordings in the forms of instruments: the heading, a row, what load has to be told
FORMS = {
    "capstone.csv": ('"Time (s) Run #1";"Position (m) Run #1"\n', "%.3f;%.5f", ","),
    "runs.csv": ("Run 1: Time (s);Run 1: Position (m)\n", "%.3f;%.5f", ","),
    "vernier.txt": ("Vernier Format 2\nMotion readings\nData Set\nTime\tTop\nt\td\ns\tcm\n\n", "%.3f\t%.4f", "."),
    "labview.lvm": ("LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t1\t\nX0\t0.0E+0\t\n"
                    "Delta_X\t0.001\t\n***End_of_Header***\t\nX_Value\tAcc\tComment\n", "%.3f\t%.5f", "."),
    "cassy.lab": ("MIN=0\nSCALE=1\nt / s\tWeg / mm\n", "%.3f\t%.5f", ","),
    "picoscope.csv": ("Time,Channel A\n(s),(V)\n\n", "%.3f,%.5f", "."),
    "tracker.txt": ("mass_A\nt\tx\n", "%.3f\t%.5f", "."),
    "sensor.txt": ("Motion Sensor Data File\nTime (s)\tDistance (cm)\tDist Error (cm)\n", "%.3f\t%.3f\t0.239", "."),
    "hand.txt": ("", "%.3f %.5f", "."),
    "labelled.txt": ("", "t=%.3f s x=%.5f cm", "."),
    "words.log": ("", "Time: %.3f s, Distance: %.4f cm", "."),
    "phyphox.csv": ('"Time (s)","Distance (cm)"\n', "%.6E,%.6E", "."),
    "scope.csv": ("nr,time,ch1,ch2\n", "1,%.6f,%.5f,0.5", "."),
    "wide.csv": ("t," + ",".join("c%d" % i for i in range(40)) + "\n", "%.3f,%.4f" + ",1.5" * 39, "."),
}

# name, what is set up, the command, what follows each trial, and what an interrupted one may leave:
# "" nothing but what the whole command leaves; "+" runs, which it keeps; "=" anything: the next one goes on with it
CASES = [
    ("load", "", "load big.txt", "data drop big", ""),
    ("load 100 MB", "", "load huge.csv", "data drop huge", ""),
    ("load csv", "", "load big.csv", "data drop big", ""),
    ("load tsv", "", "load big.tsv", "data drop big", ""),
    ("load json", "", "load big.json", "data drop big", ""),
    ("load comma", "", "load comma.csv", "data drop comma", ""),
    ("load zip", "", "load big.zip", "data drop big", ""),
    ("load gz", "", "load big.txt.gz", "data drop big", ""),
    ("load utf-16", "", "load utf16.txt", "data drop utf16", ""),
    ("load clock", "", "load clock.csv", "data drop clock", ""),
    ("load xlsx", "", "load big.xlsx", "data drop big", ""),
    ("load preview", "", "load big.txt --preview", "", ""),
    ("collect", "", "collect beat.txt as=beat", "", "+"),
    ("data clean", RECORDING, "data clean", "", ""),
    ("data clean apply", RECORDING, "data clean apply", "data restore", ""),
    ("data window", RECORDING, "data window 1:1999", "data restore", ""),
    ("data list", RECORDING, "data", "", ""),
    ("data zero", RECORDING, "data zero 20 cm", "", ""),
    ("data restore", RECORDING, "data restore", "", ""),
    ("calibrate", RECORDING, "calibrate", "", ""),
    ("calibrate points", RECORDING, "calibrate y 19.6 cm 20 cm 39.1 cm 40 cm", "calibrate off", ""),
    ("calibrate at", RECORDING, "calibrate y 25 cm 15 cm at=0:0.05,0.33:0.39", "calibrate off", ""),
    ("zero", RECORDING, "zero", "calibrate off", ""),
    ("data join", RECORDING + "; load speed.txt; data use big", "data join speed", "", ""),
    ("data drop", RECORDING, "data drop big", "load big.txt; m = 200 g", ""),
    ("adopt", FITTED, "adopt", "undo", ""),
    ("band", BANDED, "plot position --band", "", ""),
    ("export band", BANDED, "export a.csv --band --force", "", ""),
    ("report", LAID, "report handed --force", "", ""),
    ("repeat fits", RECORDING + "; load big.txt as=two", "measure repeat big two what=decay", "", ""),
    ("run", "scene damped; method verlet dt=1ms; set record all", "run 1000 s --force", "drop all", "+"),
    ("--resume", "", "", "", ""),
    ("run long", "scene pendulum; method radau5 dt=1ms", "run 3000 s --force", "drop all", "+"),
    ("run adaptive", CHAOS + "; method dop853; tol = 1e-10", "run 2000", "drop all", "+"),
    ("run energy", "scene driven; method dop853 tol=1e-13", "run 1e5 s --force", "drop all", "+"),
    ("run energy stiff", "scene stiff-spring; method dopri5 tol=1e-8", "run 2 s --force", "drop all", "+"),
    ("run until", "scene pendulum; method rk4 dt=1ms; duration = 1000 s", "run until theta > 10 rad", "drop all", "+"),
    ("run events", LORENZ + "; event top when x*y - 8/3*z falling do record", "run 1000 --force", "drop all", "+"),
    ("run typed", "var x = 2; var y = 0; x' = y; y' = 5*(1 - x^2)*y - x; method rk4 dt=1ms",
     "run 1000 --force", "drop all", "+"),
    ("run odex", CHAOS + "; method odex; tol = 1e-12", "run 2000", "drop all", "+"),
    ("run robertson", ROBERTSON + "; method rodas5p tol=1e-12", "run 1e11 --force", "drop all", "+"),
    ("run robertson radau5", ROBERTSON + "; method radau5 dt=1ms", "run 1000 --force", "drop all", "+"),
    ("continue", STEPS, "continue 1000 s --force", "back 1000000", "+"),
    ("step", STEPS, "step 1000000", "back 1000000", "+"),
    ("back", STEPS, "back 900000", "continue", "+"),
    ("reset", STEPS, "reset", "continue", "+"),
    ("change", STEPS, "change gamma = 0.02", "undo", "+"),
    ("undo", STEPS + "; m = 300 g", "undo", "redo", "+"),
    ("undo run", STEPS, "undo", "redo", "+"),
    ("checkpoint", STEPS, "checkpoint", "", ""),
    ("restore", STEPS + "; checkpoint; m = 300 g", "restore", "undo", ""),
    ("runs", STEPS, "runs", "", ""),
    ("use", STEPS, "use 1", "", ""),
    ("drop", STEPS, "drop all", "run 1000 s --force", "+"),
    ("show", STEPS, "show", "", ""),
    ("print", STEPS, "print y", "", ""),
    ("list runs", STEPS, "list runs", "", ""),
    ("list measurements", STEPS, "list measurements", "", ""),
    ("list events", TOPS, "list events", "", ""),
    ("cursor", STEPS, "cursor", "cursor off", ""),
    ("cursor periods", STEPS + "; cursor", "cursor periods 300", "", ""),
    ("cursor next", STEPS + "; cursor", "cursor next", "", ""),
    ("cursor chaotic", DRIVEN, "cursor", "cursor off", ""),
    ("plot orbit", KEPLER, "plot orbit", "", ""),
    ("describe orbit", KEPLER, "describe orbit", "", ""),
    ("plot portrait", "scene pendulum; gamma = 0.1; start rate=3", "plot portrait", "plot portrait", ""),
    ("equilibria at poles", HODGKIN, "equilibria v=-20:120 m=0:1 h=0:1 n=0:1", "plot portrait", ""),
    ("plot against", STEPS, "plot v against y", "", ""),
    ("plot at event", TOPS, "plot x at top", "", ""),
    ("plot next", TOPS, "plot z against z at top --next", "", ""),
    ("plot full log", STEPS, "plot y,y --full --log", "", ""),
    ("screenshot", STEPS, "screenshot", "", ""),
    ("screenshot data", LAID, "screenshot", "", ""),
    ("export data", RECORDING, "export - data", "", ""),
    ("export data file", RECORDING, "export a.csv data --force", "", ""),
    ("export data json", RECORDING, "export a.json data --force", "", ""),
    ("export run", STEPS, "export -", "", ""),
    ("export run file", STEPS, "export a.csv --force", "", ""),
    ("export run json", STEPS, "export a.json --force", "", ""),
    ("export run md", STEPS, "export a.md --force", "", ""),
    ("export run html", STEPS, "export a.html --force", "", ""),
    ("export run tex", STEPS, "export a.tex --force", "", ""),
    ("export even", STEPS, "export a.csv every=2ms --force", "", ""),
    ("export table", STEPS, "export a.csv table --force", "", ""),
    ("export events", TOPS, "export a.csv events --force", "", ""),
    ("load scene", "", "load scene large.ode", "", ""),
    ("load scene notes", "", "load scene notes.ode", "", ""),
    ("save", STEPS, "save a.hk --force", "", ""),
    ("save data", LAID, "save a.hk --force", "", ""),
    ("source recorded", "", "source recorded.hk", "unset m", "+"),
    ("source runs", "", "source runs.hk", "drop all", "+"),
    ("source", "", "source long.hk", "drop all", "+"),
    ("compare", "scene pendulum; duration = 1000 s", "compare euler rk4 tr-bdf2 radau5 dt=1ms --force",
     "drop all", "+"),
    ("compare closed", "scene damped; duration = 1000 s", "compare " + FIXED + " dt=1ms --force", "drop all", "+"),
    ("compare many", "scene pendulum; duration = 200 s", "compare " + MANY + " dt=1ms --force", "drop all", "+"),
    ("compare many typed", CHAOS + "; duration = 20",
     "compare " + MANY.replace("yoshida8 kahan-li8", "rk4 dopri5").replace("avf", "bdf2") + " dt=1ms --force", "drop all", "+"),
    ("compare adaptive", CHAOS + "; duration = 50; tol = 1e-12",
     "compare dop853 dopri5 tsit5 odex rodas5p radau5 --force", "drop all", "+"),
    ("compare stiff", ROBERTSON + "; duration = 1000; tol = 1e-10", "compare radau5 rodas5p dopri5 --force",
     "drop all", "+"),
    ("compare recording", LAID + "; duration = 1000 s", "compare euler verlet rk4 dt=1ms --force", "drop all", "+"),
    ("precision", "scene pendulum; duration = 100 s", "precision rk4 verlet radau5 dopri5", "", ""),
    ("precision many", "scene pendulum", "precision", "", ""),
    ("precision recording", LAID, "precision rk4 verlet --recording", "", ""),
    ("references", CHAOS + "; duration = 100", "order rk4", "", ""),
    ("order", "scene pendulum; duration = 100 s", "order radau5", "", ""),
    ("selftest", "", "selftest", "", ""),
    ("stability", "scene damped", "stability radau5", "", ""),
    ("stability run", "scene pendulum; duration = 1000 s", "stability rk4 dt=1ms", "", ""),
    ("stress", "", "stress", "", ""),
    ("stress scene", CHAOS, "stress scene", "", ""),
    ("sweep", "scene driven; method rk4; duration = 600 s", "sweep omega=6:12:0.01", "", ""),
    ("sweep map", "scene pendulum; method dopri5; duration = 60 s", "sweep theta0=0.1:3:0.01 gamma=0.1:1:0.1", "", ""),
    ("sweep long points", "scene pendulum; method radau5 dt=1ms; duration = 3000 s", "sweep gamma=0.1:1:0.1 --force",
     "", ""),
    ("sweep file", "scene driven; method rk4; duration = 600 s", "sweep omega=6:12:0.0001 --resume swept.csv --force",
     "", ""),
    ("lyapunov", CHAOS, "lyapunov over 1e6", "", ""),
    ("lyapunov of a run", CHAOS + "; method rk4; dt = 0.01; run 10000", "lyapunov of x", "", ""),
    ("sweep typed", LORENZ + "; duration = 100", "sweep rho=20:30:0.05 measure=max(z) --force", "", ""),
    ("sweep typed map", CHAOS + "; param beta = 8/3; z' = x*y - beta*z; method dopri5; duration = 100",
     "sweep rho=20:30:0.5 beta=1:3:0.1 measure=mean --force", "", ""),
    ("sweep stiff", "var x = 2; var y = 0; param mu = 100; x' = y; y' = mu*(1 - x^2)*y - x; method rodas5p; "
     "duration = 1000", "sweep mu=1:1000:x1.05 --force", "", ""),
    ("sweep section", "scene pendulum-driven; method rk4; dt = 1 ms",
     "sweep F0=1:2:0.001 at v = 0 falling skip=1000 keep=1000 --force", "", ""),
    ("sweep strobe", "scene pendulum-driven; method dop853",
     "sweep F0=1:2:0.001 at period skip=1000 keep=1000 --force", "", ""),
    ("sweep attractor", CHAOS, "sweep rho=20:30:0.01 measure=attractor --force", "", ""),
    ("sweep tol", CHAOS + "; method dop853; duration = 100", "sweep tol=1e-13:1e-3:x1.2 measure=steps", "", ""),
    ("basins", "var x = 1; var v = 0; x' = v; v' = x-x^3-0.2*v+0.3*cos(t)", "basins x=-2:2:0.002 v=-2:2:0.002", "", ""),
    ("basins slow drive", "var x = 1; var v = 0; x' = v; v' = sin(3*x)-x^3-0.2*v+0.3*cos(0.01*t)",
     "basins x=-2:2:0.002 v=-2:2:0.002", "", ""),
    ("sweep threads", CHAOS + "; method radau5; duration = 300", "sweep rho=20:30:0.1 --threads 2", "", ""),
    ("orbit", CHAOS, "orbit", "", ""),
    ("orbit of a family", "scene pendulum", "orbit period=9 s", "", ""),
    ("branch", "var x = 2; var y = 0; param mm = 1; x' = y; y' = mm*(1-x^2)*y-x; orbit",
     "branch mm=0.1:20 of orbit step=0.001 max=20000", "", ""),
    ("plan", LORENZ, "plan", "", ""),
    ("equilibria", "var x = 1; var v = 0; param a = 3; x' = sin(a*v) - x*v^3; v' = cos(a*x*v) - v",
     "equilibria x=-30:30 v=-30:30", "", ""),
    ("equilibria of many", COUPLED, "equilibria " + " ".join("%s=-9:9" % name for name in "abcdef"), "", ""),
    ("equilibria zeros", "var x = 1; var y = 1; x' = abs(x) - x; y' = sin(1/y)*y^2", "equilibria x=-5:5 y=-5:5",
     "", ""),
    ("timing full", "timing full; scene pendulum; duration = 100 s", "compare rk4 radau5 dt=1ms --force", "drop all",
     "+"),
    ("lab", "", "lab", "lab off", "+"),
    ("lab resonance", "", "lab resonance", "lab off", "+"),
    ("hint", "lab resonance", "hint", "", ""),
    ("check", "lab resonance", "check 8.7 rad/s", "", "+"),
]
for _what in ("period", "frequency", "period windows=8", "amplitude windows=6", "decay", "spectrum", "k",
              "repeat big windows=20"):
    CASES.append(("measure %s data" % _what, RECORDING, "measure " + _what, "", ""))
CASES.append(("measure spring data", "load big.txt; data mass 200 g; load big.txt as=two; data mass 300 g",
              "measure spring", "", ""))
CASES.append(("fit modes 2", "load modes.txt", "fit modes 2", "", ""))
for _what in ("period", "amplitude", "decay", "energy", "drift", "spectrum", "reynolds", "k", "period of v"):
    CASES.append(("measure %s run" % _what, STEPS, "measure " + _what, "", ""))
for _what in ("damped", "sine", "drag", "law", "a*exp(-b*t)*cos(w*t+p)+c b=0.001 w=8.7",
              "a*exp(-b*t)*cos(w*t+p)+c b=0.001 w=8.7 --robust",
              "a*cos(w*t+p)+c w=8.7 --bootstrap 50"):
    CASES.append(("fit %s" % _what, RECORDING, "fit " + _what, "", ""))
CASES.append(("fit scene", FITTED, "fit scene", "", ""))
for _what in ("damped", "drag"):
    CASES.append(("fit %s run" % _what, STEPS, "fit " + _what, "", ""))
for _what in PLOTS.split():
    CASES.append(("plot %s run" % _what, LAID if _what == "residual" else STEPS, "plot " + _what, "", ""))
    CASES.append(("describe %s run" % _what, LAID if _what == "residual" else STEPS, "describe " + _what, "", ""))
for _what in ("position", "velocity", "energy", "phase", "spectrum", "envelope", "period"):
    CASES.append(("plot %s data" % _what, RECORDING, "plot " + _what, "", ""))
    CASES.append(("describe %s data" % _what, RECORDING, "describe " + _what, "", ""))
for _form, _file in DRAWN.items():
    CASES.append(("plot %s data" % _form, RECORDING, "plot position > %s --force" % _file, "", ""))
    CASES.append(("plot %s run" % _form, STEPS, "plot y,y > %s --full --force" % _file, "", ""))

for _form in ("c", "py", "m", "ode", "tex"):
    CASES.append(("export scene .%s" % _form, STEPS, "export scene a.%s --force" % _form, "", ""))
    CASES.append(("export large scene .%s" % _form, "load scene large.ode; method rk4 dt=10ms",
                  "export scene a.%s --force" % _form, "", ""))
CASES.append(("export scene slopes", "load scene large.ode; method backward-euler dt=10ms",
              "export scene a.c --force", "", ""))

for _file in FORMS:
    CASES.append(("load " + _file, "", "load " + _file, "data drop " + _file.split(".")[0], ""))
for _method in ADAPTIVE:
    _set_up = "scene pendulum" if _method == "rkn43" else CHAOS
    CASES.append(("run adaptive " + _method, _set_up + "; method %s tol=1e-11" % _method, "run 5000", "drop all", "+"))
for _method in IMPLICIT:
    _set_up = "scene driven; gamma = 0.1" if _method in ("exact", "hht", "avf") else CHAOS
    CASES.append(("run implicit " + _method, _set_up + "; method %s dt=1ms" % _method, "run 2000 --force", "drop all",
                  "+"))
for _what in ("k = 5 N/m", "let q = 2*y", "observe p = m*v", "event top when v falling do record", "scene pendulum",
              "method rk4 dt=2ms", "unset gamma", "overlay run 1", "overlay off", "zoom 2", "pan 1 s",
              "range y -5cm:5cm", "window 5 s", "trail 3", "speed 2", "layout", "note good", "rename 1 first", "history",
              "help run", "help", "apropos energy", "list limits", "list methods", "list scenes", "echo hello",
              "checkpoint a", "scroll 5", "focus energy", "timing", "set record every 2", "var q = 1", "param c = 3",
              "recipe sweep", "show all", "list recordings", "data", "export - data every=1s", "export b.csv --force",
              "clear", "redraw", "record r.hk", "record off", "force -y", "pause",
              "lab off"):
    CASES.append((_what, LARGE, _what, "", "="))

# what a short look takes, of fewer rows
SHORT = ("load", "basins slow drive", "collect", "data clean", "plot svg data", "compare", "run until", "zero",
         "load scene", "export large scene .c")


def workbook(path, rows):
    """An .xlsx as small as one can be."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        out.writestr("xl/workbook.xml", '<workbook xmlns:r="r"><sheets><sheet name="a" sheetId="1" r:id="rId1"/>'
                     "</sheets></workbook>")
        out.writestr("xl/_rels/workbook.xml.rels", '<Relationships><Relationship Id="rId1" '
                     'Target="worksheets/sheet1.xml"/></Relationships>')
        word, row, number = '<c t="inlineStr"><is><t>%s</t></is></c>', "<row>%s</row>", "<c><v>%s</v></c>"
        with out.open("xl/worksheets/sheet1.xml", "w") as part:
            part.write(("<worksheet><sheetData>" + row % (word % "t (s)" + word % "y (cm)")).encode())
            for i in range(min(rows, 1000000)):
                t = i * 0.001
                part.write((row % (number % ("%.3f" % t) + number % ("%.4f" % math.cos(8.7 * t)))).encode())
            part.write(b"</sheetData></worksheet>")


def written(path, rows, heading, row, mark="."):
    with open(path, "w") as out:
        out.write(heading)
        for i in range(rows):
            line = row % (i * 0.001, 20 + 5 * math.cos(0.0087 * i))
            out.write((line if mark == "." else line.replace(".", mark)) + "\n")


def scenes(folder):
    """Files of XPPAUT: 60 equations of 600 operations, and a note for each of 19 000 lines."""
    names = ["x%d" % i for i in range(60)]
    with open(os.path.join(folder, "large.ode"), "w") as out:
        out.write("".join("par p%d=%g\n" % (i, 1 + i / 7) for i in range(60)))
        for i, name in enumerate(names):
            terms = ("p%d*sin(%s)*%s" % (k % 60, names[(i + k) % 60], names[(i + 7 * k) % 60]) for k in range(100))
            out.write("%s'=-%s+%s\n" % (name, name, "+".join(terms)))
        out.write("@ total=10, dt=0.01, meth=rk4\ndone\n")
    with open(os.path.join(folder, "notes.ode"), "w") as out:
        out.write("x'=-x\n" + "bdry x\n" * 19000 + "done\n")


def commands(folder):
    """Files with commands: a run, many lines that were recorded, many runs."""
    for name, text in (
        ("long.hk", "scene pendulum; method rk4 dt=1ms\nrun 3000 s --force\n"),
        ("recorded.hk", "scene damped\n" + "".join("m = %d g\n" % (100 + i % 900) for i in range(100000))),
        ("runs.hk", "scene pendulum; method rk4 dt=1ms\n" + "run 20 s\nmeasure period\n" * 200),
    ):
        with open(os.path.join(folder, name), "w") as out:
            out.write(text)


def recordings(program, folder, rows, names):
    """A damped sine in noise with missed echoes, in the formats that the cases ask for."""
    rng = random.Random(1)

    def wanted(name):
        return any(name in line for line in names) and not os.path.exists(os.path.join(folder, name))

    path = os.path.join(folder, "big.txt")
    if not os.path.exists(path):
        with open(path, "w") as out:
            out.write("t (s)\ty (cm)\n")
            for i in range(rows):
                t = i * 0.001
                y = 20 + 5 * math.exp(-t / 1500) * math.cos(8.7 * t) + rng.gauss(0, 0.02)
                out.write("%.3f\t%.4f\n" % (t, y + 3 * (i % 1000 == 7)))
    with open(path) as file:
        text = file.read()
    for name, change in (
        ("beat.txt", lambda: text[:40000]),
        ("big.csv", lambda: text.replace("\t", ",")),
        ("big.tsv", lambda: text.replace("t (s)\ty (cm)", "t\ty")),
        ("comma.csv", lambda: text.replace("\t", ";").replace(".", ",")),
        ("huge.csv", lambda: "t (s),y (cm)\n" + "".join(
            "%.6f,%.7f\n" % (i * 0.001, 20 + 5 * math.cos(0.0087 * i)) for i in range(rows * 53 // 20))),
    ):
        if wanted(name):
            with open(os.path.join(folder, name), "w") as out:
                out.write(change())
    if wanted("big.json"):
        subprocess.run([program, "-n", "-c", "load big.txt; export big.json data"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
    if wanted("big.zip"):
        with zipfile.ZipFile(os.path.join(folder, "big.zip"), "w", zipfile.ZIP_DEFLATED) as out:
            out.writestr("big.txt", text)
    if wanted("big.xlsx"):
        workbook(os.path.join(folder, "big.xlsx"), rows)
    if wanted("big.txt.gz"):
        with gzip.open(os.path.join(folder, "big.txt.gz"), "wt", compresslevel=1) as out:
            out.write(text)
    if wanted("utf16.txt"):
        with open(os.path.join(folder, "utf16.txt"), "w", encoding="utf-16") as out:
            out.write(text)
    if wanted("clock.csv"):
        with open(os.path.join(folder, "clock.csv"), "w") as out:
            out.write("Timestamp,Distance (cm)\n" + "".join(
                "2024-05-01T%02d:%02d:%06.3f,%.4f\n" % (i // 3600000, i // 60000 % 60, i % 60000 * 0.001,
                                                       20 + 5 * math.cos(0.0087 * i)) for i in range(rows)))
    if wanted("speed.txt"):
        written(os.path.join(folder, "speed.txt"), rows, "t (s)\tv (cm/s)\n", "%.3f\t%.4f")
    if wanted("modes.txt"):
        with open(os.path.join(folder, "modes.txt"), "w") as out:
            out.write("t (s)\ty (cm)\n" + "".join(
                "%.3f\t%.4f\n" % (t, 20 + 5 * math.cos(8.7 * t) + 3 * math.cos(11.3 * t + 1))
                for t in (i * 0.001 for i in range(rows))))
    for name, (heading, row, mark) in FORMS.items():
        if wanted(name):
            written(os.path.join(folder, name), rows, heading, row, mark)
    commands(folder)
    scenes(folder)
