# damped: linear damping: amplitude falls as exp(-gamma t/2), energy as exp(-gamma t)
#    y'' = -k/m*y - gamma*v
# by symplectic-euler: symplectic Euler, position first (lab eq. 12; Cromer's own order is symplectic-euler-kick)
# dt = 0.01 s, from t = 0 s to 10 s; written by hooke 0.1.0
# python3 FILE.py >run.csv, python3 FILE.py --plot
import sys

m = 0.2  # [kg] mass of the bob
k = 15.0  # [N/m] spring constant
gamma = 0.25  # [1/s] linear damping of y'' + gamma y' + omega0^2 y = 0

dt = 0.01  # [s] time step
steps = 1000


def force(y):
    return -k/m*y


def drag(v):
    return -gamma*v


t = 0.0  # [s]
y = 0.05  # [m]
v = 0.0  # [m/s]
rows = [(t, y, v)]
for i in range(steps):
    y = y + dt*v
    a = force(y)
    v = v + dt*(a + drag(v))
    if not (abs(y) <= 1e150 and abs(v) <= 1e150):
        print("diverged after t =", t, file=sys.stderr)
        break
    t = (i + 1)*dt
    rows.append((t, y, v))

if "--plot" in sys.argv:
    import matplotlib.pyplot as plt

    plt.plot([row[0] for row in rows], [row[1] for row in rows])
    plt.xlabel("t [s]")
    plt.ylabel("y [m]")
    plt.show()
else:
    print("t,y,v")
    for row in rows:
        print(*row, sep=",")
