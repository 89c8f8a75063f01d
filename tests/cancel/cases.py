# SPDX-License-Identifier: GPL-3.0-or-later
"""What can take long: recordings of 2e6 rows (ROWS), runs of 1e6 steps, and what is done with them."""
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
TOPS = LORENZ + "; event top when z falling do record; set record all; run 1000 --force"
ROBERTSON = ("var x = 1; var y = 0; var z = 0; x' = -0.04*x + 1e4*y*z; "
             "y' = 0.04*x - 1e4*y*z - 3e7*y^2; z' = 3e7*y^2")
FIXED = "euler verlet rk4 ab4 bdf2 tr-bdf2 radau5 gauss4"
PLOTS = "position energy phase velocity error residual spectrum orbit acceleration envelope period"
DRAWN = {"svg": "a.svg", "pdf": "a.pdf", "png": "a.png", "txt": "a.txt"}

# name, what is set up, the command, what follows each trial, and what an interrupted one may leave:
# "" nothing but what the whole command leaves; "+" runs, which it keeps
CASES = [
    ("load", "", "load big.txt", "data drop big", ""),
    ("load 100 MB", "", "load huge.csv", "data drop huge", ""),
    ("load csv", "", "load big.csv", "data drop big", ""),
    ("load tsv", "", "load big.tsv", "data drop big", ""),
    ("load json", "", "load big.json", "data drop big", ""),
    ("load comma", "", "load comma.csv", "data drop comma", ""),
    ("load zip", "", "load big.zip", "data drop big", ""),
    ("load xlsx", "", "load big.xlsx", "data drop big", ""),
    ("load preview", "", "load big.txt --preview", "", ""),
    ("data clean", RECORDING, "data clean", "", ""),
    ("data clean apply", RECORDING, "data clean apply", "data restore", ""),
    ("data window", RECORDING, "data window 1:1999", "data restore", ""),
    ("data list", RECORDING, "data", "", ""),
    ("data zero", RECORDING, "data zero 20 cm", "", ""),
    ("data restore", RECORDING, "data restore", "", ""),
    ("data join", RECORDING + "; load speed.txt", "data join speed", "", ""),
    ("data drop", RECORDING, "data drop big", "load big.txt; m = 200 g", ""),
    ("adopt", FITTED, "adopt", "undo", ""),
    ("band", BANDED, "plot position --band", "", ""),
    ("export band", BANDED, "export a.csv --band --force", "", ""),
    ("report", LAID, "report handed --force", "", ""),
    ("repeat fits", RECORDING + "; load big.txt as=two", "measure repeat big two what=decay", "", ""),
    ("run", "scene damped; method verlet dt=1ms; set record all", "run 1000 s --force", "drop all", "+"),
    ("run long", "scene pendulum; method radau5 dt=1ms", "run 3000 s --force", "drop all", "+"),
    ("run adaptive", CHAOS + "; method dop853; tol = 1e-10", "run 2000", "drop all", "+"),
    ("run until", "scene pendulum; method rk4 dt=1ms; duration = 1000 s", "run until theta > 10 rad", "drop all", "+"),
    ("run events", LORENZ + "; event top when z falling do record", "run 1000 --force", "drop all", "+"),
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
    ("plot against", STEPS, "plot v against y", "", ""),
    ("plot at event", TOPS, "plot x at top", "", ""),
    ("plot next", TOPS, "plot z against z at top --next", "", ""),
    ("plot full log", STEPS, "plot y,v --full --log", "", ""),
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
    ("save", STEPS, "save a.hk --force", "", ""),
    ("save data", LAID, "save a.hk --force", "", ""),
    ("source", "", "source long.hk", "drop all", "+"),
    ("compare", "scene pendulum; duration = 1000 s", "compare euler rk4 tr-bdf2 radau5 dt=1ms --force",
     "drop all", "+"),
    ("compare closed", "scene damped; duration = 1000 s", "compare " + FIXED + " dt=1ms --force", "drop all", "+"),
    ("compare adaptive", CHAOS + "; duration = 50; tol = 1e-12",
     "compare dop853 dopri5 odex rodas5p adams bdf --force", "drop all", "+"),
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
    ("sweep map", "scene pendulum; method dopri5; duration = 60 s", "sweep y0=0.1:3:0.01 gamma=0.1:1:0.1", "", ""),
    ("sweep long points", "scene pendulum; method radau5 dt=1ms; duration = 3000 s", "sweep gamma=0.1:1:0.1 --force",
     "", ""),
    ("lyapunov", CHAOS, "lyapunov over 1e6", "", ""),
    ("sweep threads", CHAOS + "; method radau5; duration = 300", "sweep rho=20:30:0.1 --threads 2", "", ""),
    ("plan", LORENZ, "plan", "", ""),
    ("timing full", "timing full; scene pendulum; duration = 100 s", "compare rk4 radau5 dt=1ms --force", "drop all",
     "+"),
    ("lab", "", "lab", "lab off", "+"),
    ("lab resonance", "", "lab resonance", "lab off", "+"),
    ("check", "lab", "check 1", "", "+"),
]
for _what in ("period", "frequency", "period windows=8", "amplitude windows=6", "decay", "spectrum", "spring", "k",
              "repeat big windows=20"):
    CASES.append(("measure %s data" % _what, RECORDING, "measure " + _what, "", ""))
for _what in ("period", "amplitude", "decay", "energy", "drift", "spectrum", "reynolds", "k", "period of energy"):
    CASES.append(("measure %s run" % _what, STEPS, "measure " + _what, "", ""))
for _what in ("damped", "sine", "drag", "law", "modes 2", "a*exp(-b*t)*cos(w*t+p)+c b=0.001 w=8.7",
              "a*exp(-b*t)*cos(w*t+p)+c b=0.001 w=8.7 --robust", "damped --bootstrap 50", "damped --robust"):
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
    CASES.append(("plot %s run" % _form, STEPS, "plot y,v,energy > %s --force" % _file, "", ""))

# what a short look takes, of fewer rows
SHORT = ("load", "data clean", "plot svg data", "compare", "run until")


def workbook(path, rows, ods):
    """An .xlsx or .ods as small as one can be."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        if ods:
            out.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
            name, number = "content.xml", '<table:table-cell office:value-type="float" office:value="%s"/>'
            word = "<table:table-cell><text:p>%s</text:p></table:table-cell>"
            row = "<table:table-row>%s</table:table-row>"
            begin = '<office:document-content><office:body><office:spreadsheet><table:table table:name="a">'
            end = "</table:table></office:spreadsheet></office:body></office:document-content>"
        else:
            out.writestr("xl/workbook.xml", '<workbook xmlns:r="r"><sheets><sheet name="a" sheetId="1" r:id="rId1"/>'
                         "</sheets></workbook>")
            out.writestr("xl/_rels/workbook.xml.rels", '<Relationships><Relationship Id="rId1" '
                         'Target="worksheets/sheet1.xml"/></Relationships>')
            name, number = "xl/worksheets/sheet1.xml", "<c><v>%s</v></c>"
            word, row = '<c t="inlineStr"><is><t>%s</t></is></c>', "<row>%s</row>"
            begin, end = "<worksheet><sheetData>", "</sheetData></worksheet>"
        with out.open(name, "w") as part:
            part.write((begin + row % (word % "t (s)" + word % "y (cm)")).encode())
            for i in range(min(rows, 1000000)):
                t = i * 0.001
                part.write((row % (number % ("%.3f" % t) + number % ("%.4f" % math.cos(8.7 * t)))).encode())
            part.write(end.encode())


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
    for name in ("big.xlsx", "big.ods"):
        if wanted(name):
            workbook(os.path.join(folder, name), rows, name.endswith("ods"))
    with open(os.path.join(folder, "long.hk"), "w") as out:
        out.write("scene pendulum; method rk4 dt=1ms\nrun 3000 s --force\n")
