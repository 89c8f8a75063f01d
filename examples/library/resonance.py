"""A resonance curve and a run of it, with numpy: PYTHONPATH=. python3 resonance.py"""
import numpy

import hooke

lab = hooke.Session()
lab.run("scene driven; method rk4; sweep omega=6:12:0.1 measure=amplitude")
curve = lab.table("table of sweep")
peak = numpy.argmax(curve["amplitude"])
print(f"{len(curve['omega'])} points, the largest amplitude {curve['amplitude'][peak]:.4g} {curve.units['amplitude']} "
      f"at omega = {curve['omega'][peak]:.3g} {curve.units['omega']}")

lab.run(f"omega = {curve['omega'][peak]!r}; dt = 1ms; run 60 s")
run = lab.table("t y")
print(f"{len(run['t'])} rows, y at the end {run['y'][-1]!r} {run.units['y']}")
try:
    lab.run("measure periot")
except hooke.Error as error:
    print(f"column {error.column}: {error}")
