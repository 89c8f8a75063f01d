/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Exact solutions of q'' + gamma q' + w2 q = -g + f cos(omega t + phase), w2 and gamma of any sign. Other linear
 * systems: exact_linear.c.
 *
 * With the roots a, b of z^2 + gamma z + w2 every part of the solution is a divided difference of z -> exp(z t):
 *
 *   impulse response                 h(t) = E[a, b]
 *   from rest under exp(c t)         E[a, b, c]              (c = 0: a constant force, c = i omega: a drive)
 *   its velocity                     a E[a, b, c] + E[b, c]  (Leibniz)
 *
 * so that critical damping (a = b), resonance (c = a) and k = 0 (a = 0) are nothing but nodes that meet, for which
 * divided differences have a limit: close nodes take the Taylor series, distant ones the quotient, and neither cancels.
 * The idea is that of McCurdy, Ng, Parlett, Math. Comp. 43 (1984) 501.
 *
 * Everything is evaluated in long double: where it has 64 bits of mantissa and 15 of exponent (x86, and more elsewhere)
 * the result is good to half an ulp of the amplitude for phases up to 1000 and grows by 1e-19 per radian, and
 * amplitudes near both ends of double need no scaling.
 */
#include <complex.h>
#include <float.h>
#include <math.h>

#include "exact.h"

typedef long double real; /* private to this file, for the width of the formulas */
typedef complex long double node;

/* exp(z), held below overflow, still growing with the real part: growth ends as inf and not as a difference of two. */
static node exponential(node z)
{
    const real most = LDBL_MAX_EXP / 2;
    real x = creall(z);
    if (x > most)
        z += most * (1.1L - 0.1L * most / x) - x;
    return cexpl(z);
}

/*
 * Sum over k of h_k / (k + n)!, h_k the complete homogeneous symmetric polynomials of nodes whose sum is 0 and whose
 * other elementary symmetric polynomials are e2 and e3: h_k = -e2 h_(k-2) + e3 h_(k-3). For nodes within 1 of 0.
 */
static node taylor(node e2, node e3, int n)
{
    node h[3] = {1, 0, 0}, sum = 0; /* h_k, h_(k-1), h_(k-2) */
    real factorial = n;             /* n is 1 or 2 */
    for (int k = 0; k < 20; k++) {
        sum += h[0] / factorial;
        factorial *= k + n + 1;
        node next = -e2 * h[1] + e3 * h[2];
        h[2] = h[1], h[1] = h[0], h[0] = next;
    }
    return sum;
}

/* E[a, b]: divided difference of z -> exp(z t). */
static node divided2(node a, node b, real t)
{
    if (cabsl((a - b) * t) >= 1)
        return (exponential(a * t) - exponential(b * t)) / (a - b);
    node x = (a - b) / 2 * t;
    return t * exponential((a + b) / 2 * t) * taylor(-x * x, 0, 1);
}

/* E[a, b, c], divided along the longer way to c: if that is short, all three are near each other. */
static node divided3(node a, node b, node c, real t)
{
    if (cabsl(b - c) > cabsl(a - c)) {
        node keep = a;
        a = b, b = keep;
    }
    if (cabsl((a - c) * t) >= 1)
        return (divided2(a, b, t) - divided2(b, c, t)) / (a - c);
    node mean = (a + b + c) / 3;
    a = (a - mean) * t, b = (b - mean) * t, c = (c - mean) * t;
    return t * t * exponential(mean * t) * taylor(a * b + b * c + c * a, a * b * c, 2);
}

static bool is_oscillator(const struct system *system)
{
    return system->order == 2 && system->n == 2 && system->linear && system->oscillator.whole;
}

bool system_has_exact(const struct system *system)
{
    return (system->model && system->model->exact) || is_oscillator(system) || linear_has_exact(system);
}

void system_exact(const struct system *system, double t0, const double *start, double t, double *y, double *floor)
{
    if (system->model && system->model->exact) {
        system->model->exact(system, t0, start, t, y, floor);
        return;
    }
    if (!is_oscillator(system)) {
        linear_exact(system, t0, start, t, y, floor);
        return;
    }
    const struct oscillator *o = &system->oscillator;
    const real w2 = (real)o->stiffness, gamma = (real)o->damping, s = gamma / 2, gravity = (real)o->gravity;
    const real q0 = (real)start[0], v0 = (real)start[1], begin = (real)t0, elapsed = (real)t - begin;
    const real discriminant = fmal(-s, s, w2); /* one rounding: exact however near critical damping */
    const real r = sqrtl(fabsl(discriminant));

    /* The roots; a is the one of lesser magnitude where they are real. */
    node a, b;
    if (discriminant > 0) {
        a = -s + r * (node)I;
        b = conjl(a);
    } else {
        b = s >= 0 ? -(s + r) : r - s;
        a = b != 0 ? w2 / b : 0;
    }

    /* Free motion: q = q0 g + v0 h with g' = -w2 h; a constant force adds its step response. */
    real h = creall(divided2(a, b, elapsed));
    real g = creall(exponential(a * elapsed)) - creall(a) * h;
    real h_rate = creall(exponential(b * elapsed)) + creall(a) * h;
    real q = q0 * g + v0 * h;
    if (gravity != 0)
        q -= gravity * creall(divided3(a, b, 0, elapsed));
    real v = v0 * h_rate - (w2 * q0 + gravity) * h;

    /* The answer to the drive from rest, as a complex envelope. */
    node drive = 0, p = 0, p_rate = 0;
    if (o->drive != 0) {
        const real omega = (real)o->omega;
        node c = omega * (node)I;
        drive = (real)o->drive * cexpl((omega * begin + (real)o->phase) * (node)I);
        node from_rest = divided3(a, b, c, elapsed);
        p = drive * from_rest;
        p_rate = drive * (a * from_rest + divided2(b, c, elapsed));
        drive *= cexpl(c * elapsed);
    }
    y[0] = (double)(q + creall(p));
    y[1] = (double)(v + creall(p_rate));
    if (!floor)
        return;

    /*
     * A relative change eps of the time scale moves q by eps |t| v, v without the cancellation between its parts; where
     * v happens to be 0 the acceleration over a rate stands in, where that is 0 the velocity: together an envelope. A
     * change of one coefficient alone moves roots that nearly meet by more: by a factor |b| / 2r, and never by more
     * than |b t| / 6.
     */
    const real eps = (real)DBL_EPSILON, time = fabsl(elapsed), fast = cabsl(b);
    real a_free = -w2 * q - gamma * v - gravity, v_free = fabsl(v0 * h_rate) + fabsl((w2 * q0 + gravity) * h);
    real v_top = hypotl(v_free, a_free * fminl(1 / fast, time)), a_top = hypotl(a_free, cabsl(a) * v_free);
    real stretch = 1 + fast * fminl(0.5L / r, time / 6);
    real v_drive = cabsl(p_rate), a_drive = cabsl(drive - w2 * p - gamma * p_rate);
    floor[0] = (double)(eps * (fabsl(q) + cabsl(p) + time * stretch * (v_top + v_drive)));
    floor[1] = (double)(eps * (fabsl(v) + v_drive + time * stretch * (a_top + a_drive)));
}
