#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Diagrams as whole commands, beside AUTO-07p and XPPAUT where these are installed: processor time of
the process with all that it starts (a compiler too, where the program needs one), and the numbers.

usage: continuation.py HOOKE"""
import csv, os, re, resource, shutil, subprocess, sys, tempfile

RUNS = 5
HOOKE = os.path.abspath(sys.argv[1])
AUTO, XPP = shutil.which("auto-07p"), shutil.which("xppaut")

FUNCTIONS = """
SUBROUTINE FUNC(NDIM,U,ICP,PAR,IJAC,F,DFDU,DFDP)
  IMPLICIT NONE
  INTEGER, INTENT(IN) :: NDIM, ICP(*), IJAC
  DOUBLE PRECISION, INTENT(IN) :: U(NDIM), PAR(*)
  DOUBLE PRECISION, INTENT(OUT) :: F(NDIM)
  DOUBLE PRECISION, INTENT(INOUT) :: DFDU(NDIM,*), DFDP(NDIM,*)
%s
END SUBROUTINE
SUBROUTINE STPNT(NDIM,U,PAR,T)
  IMPLICIT NONE
  INTEGER, INTENT(IN) :: NDIM
  DOUBLE PRECISION, INTENT(INOUT) :: U(NDIM), PAR(*)
  DOUBLE PRECISION, INTENT(IN) :: T
%s
END SUBROUTINE
""" + "".join(f"SUBROUTINE {name}\nEND SUBROUTINE\n" for name in ("BCND", "ICND", "FOPT", "PVLS"))
# tolerances that give the digits compared below
CONSTANTS = """NDIM=%d, IPS=%d, IRS=0, ILP=1, ISP=%d, ICP=%s, NMX=1000, NPR=1000, NTST=50, NCOL=4
IAD=3, ISW=1, IPLT=0, NBC=0, NINT=0, MXBF=10, IID=2, ITMX=9, ITNW=7, NWTN=3, JAC=0, NPAR=2
EPSL=1e-10, EPSU=1e-10, EPSS=1e-8, DS=%s, DSMIN=1e-6, DSMAX=%s, IADS=1, THL={11: 0.0}
"""

DUFFING = """var x = 1; var v = 0; param d = 0.1; param F = 0.3; param w = 0.8
x' = v; v' = -d*v-x-x^3+F*cos(w*t)
branch w=0.8:2.2 step=%s of response
"""
VDP = "var x = 2; var y = 0; param mu = 1; x' = y; y' = mu*(1-x^2)*y-x\n"

# name, script, a number in its output, its value to 12 digits by two other ways (dynamics.csv)
ROWS = [
    ("Lorenz, all of it to T = 16 s", """
var x = 1; var y = 1; var z = 1; param s = 10; param b = 8/3; param r = 0.5
x' = s*(y-x); y' = x*(r-z)-y; z' = x*y-b*z
equilibria
branch r=0:30
branch r=0:30 from BP1
branch r=0:30 from HB1
""", r"EP5 +end +r = (\S+)", 13.92655740752),
    ("Duffing, forced response", DUFFING % 0.05, r"LP2 +fold +w = (\S+)", 1.3242362007706),
    ("the same at 195 places", DUFFING % 0.0195, r"LP2 +fold +w = (\S+)", 1.3242362007706),
    ("van der Pol, an orbit", VDP + "orbit\n", r"T = (\S+) s", 6.66328685932313),
    ("its branch to mu = 10", VDP + "orbit\nbranch mu=1:10 of orbit 1\nuse EP2\norbit\n",
     r"(?s)EP2.*T = (\S+) s", 19.0783695669382),
]
AUTO_RUNS = {
    "Lorenz, all of it to T = 16 s": (
        "  F(1)=10d0*(U(2)-U(1))\n  F(2)=U(1)*(PAR(1)-U(3))-U(2)\n  F(3)=U(1)*U(2)-8d0/3d0*U(3)",
        "  PAR(1)=0d0\n  U=0d0", CONSTANTS % (3, 1, 2, "[1]", 0.09, 0.5), """
e = run('job', c='job', UZSTOP={1: [-1.0, 30.0]})
o = run(e('HB1'), IPS=2, ICP=[1, 11], DS=0.1, DSMAX=5.0, UZSTOP={11: 15.7}, SP=['LP0'])
print('NUMBER %.12f' % o('UZ1')['PAR(1)'])
"""),
    "Duffing, forced response": (
        "  DOUBLE PRECISION R\n  R=1d0-U(3)**2-U(4)**2\n  F(1)=U(2)\n"
        "  F(2)=-0.1d0*U(2)-U(1)-U(1)**3+PAR(2)*U(4)\n"
        "  F(3)=R*U(3)+PAR(1)*U(4)\n  F(4)=R*U(4)-PAR(1)*U(3)",
        "  DOUBLE PRECISION, PARAMETER :: TPI=8*ATAN(1d0)\n  PAR(1)=0.8d0\n  PAR(2)=0d0\n"
        "  PAR(11)=TPI/PAR(1)\n  U(1:2)=0d0\n  U(3)=SIN(TPI*T)\n  U(4)=COS(TPI*T)",
        CONSTANTS % (4, 2, 1, "[2,11]", 0.01, 0.1), """
a = run('job', c='job', UZSTOP={2: 0.3})
b = run(a('UZ1'), ICP=[1, 11], DS=0.01, DSMAX=0.05, UZSTOP={1: 2.2}, SP=['LP', 'BP0'])
print('NUMBER %.12f' % b('LP2')['PAR(1)'])
"""),
    # from one period of the orbit: where it is born the branch is vertical
    "its branch to mu = 10": (
        "  F(1)=U(2)\n  F(2)=PAR(1)*(1d0-U(1)**2)*U(2)-U(1)", "  PAR(1)=1d0",
        CONSTANTS % (2, 2, 2, "[1,11]", 0.09, 1.0), """
o = run('job', c='job', dat='job', UZSTOP={1: 10.0}, SP=['LP0', 'BP0'])
print('NUMBER %.12f' % o('UZ1')['PERIOD'])
"""),
}


def timed(command, folder, ok=True):
    """Milliseconds of processor time, and what was printed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if ok and out.returncode:
        sys.exit(f"{command[0]} failed: {out.stdout[-300:]}{out.stderr[-300:]}")
    return 1e3 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime), out.stdout


def put(folder, name, text):
    with open(os.path.join(folder, name), "w") as file:
        file.write(text)


def off(text, pattern, exact):
    found = re.search(pattern, text)
    return abs(float(found.group(1)) / exact - 1) if found else float("nan")


def by_auto(folder, name):
    """(first, with the compiler; again; relative error)"""
    func, stpnt, constants, script = AUTO_RUNS[name]
    put(folder, "job.f90", FUNCTIONS % (func, stpnt))
    put(folder, "c.job", constants)
    put(folder, "job.auto", script)
    if "dat=" in script:
        put(folder, "vdp.hk", VDP + "orbit\nexport orbit.csv table\n")
        timed([HOOKE, "vdp.hk"], folder)
        with open(os.path.join(folder, "orbit.csv")) as file:
            rows = list(csv.reader(line for line in file if not line.startswith("#")))[1:]
        put(folder, "job.dat", "".join(" ".join(row) + "\n" for row in rows))
    times = [timed([AUTO, "job.auto"], folder) for _ in range(3)]
    exact = next(row[3] for row in ROWS if row[0] == name)
    return times[0][0], min(t for t, _ in times[1:]), off(times[0][1], r"NUMBER (\S+)", exact)


def by_xpp(folder):
    """A run of 200 s with its section: its AUTO part needs a screen."""
    put(folder, "job.ode", "x'=y\ny'=mu*(1-x^2)*y-x\npar mu=1\ninit x=2,y=0\n"
        "@ total=200,dt=0.05,meth=cvode,tol=1e-12,atol=1e-12,maxstor=100000\n"
        "@ poimap=section,poivar=y,poipln=0,poisgn=-1\ndone\n")
    t = min(timed([XPP, "job.ode", "-silent"], folder, False)[0] for _ in range(RUNS))
    with open(os.path.join(folder, "output.dat")) as file:
        at = [float(line.split()[0]) for line in file]
    return t, abs((at[-1] - at[-21]) / 20 / 6.66328685932313 - 1)


def main():
    print("\ncontinuation: whole commands, ms of processor time; in brackets how far a number is off")
    for name, program in (("auto-07p", AUTO), ("xppaut", XPP)):
        if not program:
            print(f"  {name} is not installed: not compared")
    for name, script, pattern, exact in ROWS:
        with tempfile.TemporaryDirectory() as folder:
            put(folder, "job.hk", script)
            runs = [timed([HOOKE, "job.hk"], folder) for _ in range(RUNS)]
            line = f"  {name:<30} {min(t for t, _ in runs):7.1f} ({off(runs[0][1], pattern, exact):.0e})"
            if AUTO and name in AUTO_RUNS:
                first, again, error = by_auto(folder, name)
                line += f"   AUTO-07p {again:7.1f} ({error:.0e}), compiled first {first:.1f}"
            if XPP and name == "van der Pol, an orbit":
                line += "   XPPAUT, a run %.1f (%.0e)" % by_xpp(folder)
            print(line)


main()
