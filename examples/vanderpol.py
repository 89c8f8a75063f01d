# typed: equations typed by the user
#    x'' = -x + mu*(1 - x^2)*vx
# by rk4: the classical Runge-Kutta method: fourth order, slightly dissipative
# dt = 0.01 s, from t = 0 s to 10 s; written by hooke 0.1.0
# python3 FILE.py >run.csv, python3 FILE.py --plot
import sys

mu = 2.0

dt = 0.01  # [s] time step
steps = 1000


def acceleration(x, vx):
    return -x + mu*(1 - x*x)*vx


t = 0.0  # [s]
x = 1.0
vx = 0.0
rows = [(t, x, vx)]
for i in range(steps):
    a1 = acceleration(x, vx)
    x_at2 = x + dt*0.5*vx
    vx_at2 = vx + dt*0.5*a1
    a2 = acceleration(x_at2, vx_at2)
    x_at3 = x + dt*0.5*vx_at2
    vx_at3 = vx + dt*0.5*a2
    a3 = acceleration(x_at3, vx_at3)
    x_at4 = x + dt*vx_at3
    vx_at4 = vx + dt*a3
    a4 = acceleration(x_at4, vx_at4)
    x = x + (dt*(1/6)*vx + dt*(1/3)*vx_at2 + dt*(1/3)*vx_at3 + dt*(1/6)*vx_at4)
    vx = vx + (dt*(1/6)*a1 + dt*(1/3)*a2 + dt*(1/3)*a3 + dt*(1/6)*a4)
    if not (abs(x) <= 1e150 and abs(vx) <= 1e150):
        print("diverged after t =", t, file=sys.stderr)
        break
    t = (i + 1)*dt
    rows.append((t, x, vx))

if "--plot" in sys.argv:
    import matplotlib.pyplot as plt

    plt.plot([row[0] for row in rows], [row[1] for row in rows])
    plt.xlabel("t [s]")
    plt.ylabel("x")
    plt.show()
else:
    print("t,x,vx")
    for row in rows:
        print(*row, sep=",")
