# SPDX-License-Identifier: GPL-3.0-or-later
# What Python programs need that Python has not: those functions that a program calls stand above it.
# The table of a method, size, derivatives(), jacobian() and step() are the program's.


def sign(x):
    return float((x > 0) - (x < 0))


def step(x):
    return float(x >= 0)


def mod(a, b):  # between 0 and b
    return a % b


def cbrt(x):
    return copysign(abs(x)**(1/3), x)


def round_half(x):  # halves away from 0
    return copysign(floor(abs(x) + 0.5), x)


def solve(t, h, s):  # z = h f(t, s + z)
    z, last = [0.0]*len(s), float("inf")
    for iteration in range(50):
        at = [a + b for a, b in zip(s, z)]
        rest = [h*r - x for r, x in zip(derivatives(t, at), z)]
        move = eliminate(h, jacobian(t, at), rest)
        z = [a + b for a, b in zip(z, move)]
        moved = max(abs(x)/max(abs(y), w) for x, y, w in zip(move, s, size))
        if moved < 1e-16 or (moved >= last and moved < 1e-10):
            return z
        last = moved
    return None


def eliminate(h, by, b):  # (1 - h J) x = b, by Gauss
    n = len(b)
    a = [[(i == k) - h*by[n*i + k] for k in range(n)] + [b[i]] for i in range(n)]
    for p in range(n):
        best = max(range(p, n), key=lambda i: abs(a[i][p]))
        a[p], a[best] = a[best], a[p]
        for i in range(p + 1, n):
            factor = a[i][p]/a[p][p]
            for k in range(p, n + 1):
                a[i][k] -= factor*a[p][k]
    x = [0.0]*n
    for i in reversed(range(n)):
        x[i] = (a[i][n] - sum(a[i][k]*x[k] for k in range(i + 1, n)))/a[i][i]
    return x


def turning_time(p, q):  # where v = 0 between two moments (time, v, a), by a cubic
    rise = q[1] - p[1]
    u = -p[1]/rise
    r = 1 - u
    x = (p[0] + (q[0] - p[0])*(u*u*(3 - 2*u)) +
         rise*u*r*(r/p[2] - u/q[2]))
    return x if (x - p[0])*(q[0] - x) > 0 else p[0] + (q[0] - p[0])/2


def turning_step(t, h, state):  # in pieces that meet where the velocity turns
    rest = h
    for piece in range(8):
        before, state = state, step(t, rest, state)
        near = 1e-8*abs(rest)
        if piece == 7 or not before[1]*state[1] < 0:
            return state
        first = (0.0, before[1], acceleration_at(t, before))
        last = (rest, state[1], acceleration_at(t + rest, state))
        x = turning_time(first, last)
        if abs(x) <= near or abs(rest - x) <= near:
            return state
        for attempt in range(12):
            state = step(t, x, before)
            here = (x, state[1], acceleration_at(t + x, state))
            if abs(here[1]) <= near*abs(here[2]) or attempt == 11:
                break
            if (here[1] < 0) == (first[1] < 0):
                first = here
            else:
                last = here
            x = turning_time(first, last)
        rest -= x
        t += x
    return state


def power(x, n):  # by multiplications, n whole or half of that
    whole = int(abs(n))
    result = 1.0
    for bit in bin(whole)[2:]:
        result = result*result*x if bit == "1" else result*result
    if abs(n) > whole:
        result *= sqrt(x)
    return 1/result if n < 0 else result


def log2_near(x):  # to 2e-9
    m, whole = frexp(x)
    if m < 0.7071067811865476:
        m, whole = 2*m, whole - 1
    s = (m - 1)/(m + 1)
    u = s*s
    series = ((0.961796693925976 + u*0.577078016355585) +
              u*u*(0.412198583111132 + u*0.320598897975325))
    return whole + s*(2.885390081777927 + u*series)


def exp2_near(x):  # to 1e-9
    x = min(max(x, -1000.0), 1000.0)
    f = x - round(x)
    g = f*f
    low = (1 + f*0.693147180559945) + g*(0.240226506959101 + f*0.0555041086648216)
    high = ((0.00961812910762848 + f*0.00133335581464284) +
            g*(0.000154035303933816 + f*1.52527338040598e-5) + g*g*1.32154867901443e-6)
    return 2.0**round(x)*(low + g*g*high)


def atan_near(x):  # to 1e-5
    z = 1/x if abs(x) > 1 else x
    u = z*z
    angle = z*(0.9998660 + u*(-0.3302995 + u*(0.1801410 + u*(-0.0851330 + u*0.0208351))))
    return angle if abs(x) <= 1 else copysign(1.5707963267948966, x) - angle


def limited(x):  # 1 + atan(2^x - 1)
    if not -0.5 <= x <= 0.5:
        return 1 + atan_near(exp2_near(x) - 1)
    u = x*x
    low = ((1 + 0.6931488410800936*x) +
           u*(0.240226502974211 - 0.0555933829372098*x))
    high = ((-0.1058275956503550 - 0.0320318947604718*x) +
            u*(0.0284870670868496 + 0.0239926464967005*x))
    return low + u*u*high


class Adaptive:  # steps whose size follows the error
    def __init__(self, t, h, state):
        self.h, self.t, self.origin, self.t_low = h, t, t, 0.0
        self.last, self.aimed = 0.0, 0.0  # the last good step, the square of its error
        self.elapsed, self.excess = 0.0, [0.0]*len(state)
        self.rejected = False
        self.slope = [derivatives(t, state)]

    def begin(self, t, state):
        by = t - self.t
        self.t, self.state, self.failures = t, state, 0
        self.first = self.slope[-1]  # the last stage of a step is the first one of the next
        self.elapsed += by
        self.scale = []  # sizes along the run: the mean of the fourth root, to the fourth power
        for i, y in enumerate(state):
            mean = 1.0
            if abs(y) > size[i]:
                self.excess[i] += by*(sqrt(sqrt(abs(y)/size[i])) - 1)
            if self.excess[i] > 0:
                mean += self.excess[i]*(1/self.elapsed)
            mean *= mean
            mean *= mean
            self.scale.append(size[i]*mean if isfinite(size[i]*mean) else size[i])

    def attempt(self, end):
        rest = end - self.t
        self.to_end = self.cut = abs(self.h)*1.01 >= abs(rest)  # no sliver remains
        self.take(rest if self.to_end else self.h)

    def take(self, h):  # the state after h, and the square of its error by what is accepted
        self.taken, self.square = h, float("nan")
        try:
            k = [self.first]
            for c, weights in zip(stage_time[1:], stage_weight[1:]):
                after = []
                for i, y in enumerate(self.state):
                    change = -0.0
                    for w, slope in zip(weights, k):
                        if w != 0:
                            change += h*w*slope[i]
                    after.append(y + change)
                k.append(derivatives(self.t + c*h, after))
            total = [0.0, 0.0]
            for i, (y, z) in enumerate(zip(self.state, after)):
                error = -0.0
                for w, low, slope in zip(stage_weight[-1], weight_low, k):
                    if w != low:
                        error += (w - low)*slope[i]
                part = h*error/max(self.scale[i], abs(y), abs(z))
                total[i % 2] += part*part
        except (OverflowError, ValueError, ZeroDivisionError):
            return
        self.after, self.slope = after, k
        if all(isfinite(z) for z in after):
            self.square = (total[0] + total[1])*(1/(len(after)*error_most*error_most))

    def accepts(self, end):  # 1: the step was good; 0: the next try is shorter; -1: there is none
        h, half = self.taken, -0.5/error_order
        aimed = self.square*(1/(0.35*0.35))
        if not self.square <= 1:
            if isfinite(aimed):
                self.h = h*max(exp2_near(log2_near(aimed)*half), 0.2)
            else:
                self.h = h/4
                self.failures += 1
            self.rejected = True
            return -1 if self.failures > 20 or not abs(self.h) >= 4*ulp(self.t) else 0
        # by how much the next step is longer: a filter of the errors of the last two
        by, aimed = 1.0, max(aimed, 1e-8*1e-8)
        if self.aimed == 0:
            by = min(exp2_near(log2_near(aimed)*half), 10)
        elif aimed < 0.7*0.7 or aimed > 1.3*1.3 or abs(h/self.last) < 0.9:
            by = limited(log2_near(aimed)*(half*0.8) +
                         (log2_near(self.aimed)*(half*-0.4) - log2_near(abs(h/self.last))*-0.5))
        if self.rejected:
            by = min(by, 1)
        if not self.cut or abs(h*by) > abs(self.h):  # a cut one says nothing against a longer one
            self.aimed, self.last, self.h = aimed, h, h*by
        self.rejected = False
        by = h + self.t_low
        self.ends = self.t + by
        part = self.ends - self.t
        self.t_low = (self.t - (self.ends - part)) + (by - part)
        if self.to_end or self.ends > end:
            self.ends = end
        return 1

    def row(self, at):  # the state at a time in the step; None: it does not go so far
        near = 8*2.0**-52*max(abs(self.ends), abs(self.origin))
        if at - self.ends > near:
            return None
        if abs(at - self.ends) <= near:
            return self.after
        inside, share = [], (at - self.t)/self.taken
        for i, y in enumerate(self.after):
            rise, bend = -0.0, -0.0
            for b, d, slope in zip(stage_weight[-1], weight_inside, self.slope):
                if b != 0:
                    rise += b*slope[i]
                if d != 0:
                    bend += d*slope[i]
            first, last = self.first[i] - rise, rise - self.slope[-1][i]
            bent = last - first + (1 - share)*bend
            inside.append(y - self.taken*((1 - share)*(rise - share*(first + share*bent))))
        return inside


def turn(control):  # where the velocity turns in the step it is taken again, up to there
    h, t, v = control.taken, control.t, control.state[1]
    near = max(1e-8, 0.1*sqrt(error_most))*abs(h)
    if not isfinite(control.square) or not (v < 0 < control.after[1] or v > 0 > control.after[1]):
        return
    first = (0.0, v, acceleration_at(t, control.state))
    last = (h, control.after[1], acceleration_at(t + h, control.after))
    x = turning_time(first, last)
    if abs(x) <= near or abs(h - x) <= near:
        return
    control.to_end, control.cut = False, True
    for attempt in range(12):
        control.take(x)
        if not isfinite(control.square):
            return
        here = (x, control.after[1], acceleration_at(t + x, control.after))
        if abs(here[1]) <= near*abs(here[2]):
            return
        if (here[1] < 0) == (first[1] < 0):
            first = here
        else:
            last = here
        x = turning_time(first, last)
