/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The motion of a mass under a restoring force and a law of damping,
 *     y'' + gamma y' + b |y'| y' + f sign(y') + R(y) = 0,  R = omega^2 y, omega^2 y + beta y^3 or omega^2 sin(y),
 * and its derivatives by everything in it. Between two turning points the sign of y' is constant and the solution is
 * analytic: Taylor series of it and of its variational equations (Moore 1966, Interval Analysis, ch. 11), in the time
 * unit 1/omega. At a turning point the friction jumps; the variations of y' jump with the acceleration (saltation:
 * Aizerman & Gantmakher 1958). Where the spring is weaker than the friction there, the motion ends.
 */
#include "internal.h"

#include <string.h>

enum { ORDER = 18, COLUMNS = EQUATION_COLUMNS, OF_START = 1, OF_SPEED, OF_OMEGA, OF_GAMMA, OF_B, OF_F, OF_CUBIC };

#define STEP_MOST 1.2  /* [rad] */
#define ROUNDING 1e-17 /* share of the series that its last term may have */

_Static_assert((int)ORDER == (int)EQUATION_ORDER && (int)OF_CUBIC == (int)COLUMNS - 1, "a column for each parameter of the motion");

/* Coefficients of R/omega^2 and, of those from the second column on, of R' times the column, of order k. */
struct restoring {
    double slope[ORDER], sine[ORDER]; /* coefficients of R'/omega^2; of sin(y) */
    double cube[ORDER];               /* of y^2, then y^3 */
};

static void restore(const struct equation_walk *s, int k, struct restoring *r, double out[COLUMNS])
{
    if (s->force == RESTORING_LINEAR) {
        memcpy(out, s->c[k], sizeof s->c[k]);
        return;
    }
    if (s->force == RESTORING_SINE) { /* sin' = cos y', cos' = -sin y' */
        r->sine[k] = k == 0 ? sin(s->c[0][0]) : 0;
        r->slope[k] = k == 0 ? cos(s->c[0][0]) : 0;
        for (int j = 1; j <= k; j++) {
            r->sine[k] += j * s->c[j][0] * r->slope[k - j] / k;
            r->slope[k] -= j * s->c[j][0] * r->sine[k - j] / k;
        }
        out[0] = r->sine[k];
        r->cube[k] = 0;
    } else {
        double square = 0;
        for (int j = 0; j <= k; j++)
            square += s->c[j][0] * s->c[k - j][0];
        r->slope[k] = 3 * s->cubic * square + (k == 0);
        r->sine[k] = square;
        r->cube[k] = 0;
        for (int j = 0; j <= k; j++)
            r->cube[k] += r->sine[j] * s->c[k - j][0];
        out[0] = s->c[k][0] + s->cubic * r->cube[k];
    }
    for (int i = 1; i < COLUMNS; i++)
        out[i] = 0;
    for (int j = 0; j <= k; j++)
        for (int i = 1; i < COLUMNS; i++)
            out[i] += r->slope[j] * s->c[k - j][i];
}

static double restoring_at(const struct equation_walk *s, double y)
{
    return s->force == RESTORING_LINEAR ? y : s->force == RESTORING_SINE ? sin(y) : y + s->cubic * y * y * y;
}

/* Taylor coefficients from those of orders 0 and 1. */
static void expand(struct equation_walk *s)
{
    double rate[ORDER][COLUMNS], force[COLUMNS]; /* coefficients of the time derivatives; of what pulls back */
    struct restoring restoring;
    if (s->side == 0) {
        memset(s->c[1], 0, sizeof s->c - sizeof s->c[0]);
        return;
    }
    const double b = s->side * s->b;
    for (int k = 0; k + 2 <= ORDER; k++) {
        double product[COLUMNS] = {0}, over = 1.0 / ((k + 1) * (k + 2));
        for (int i = 0; i < COLUMNS; i++)
            rate[k][i] = (k + 1) * s->c[k + 1][i];
        for (int j = 0; j <= k && s->quadratic; j++)
            for (int i = 0; i < COLUMNS; i++)
                product[i] += rate[j][0] * rate[k - j][i];
        restore(s, k, &restoring, force);
        for (int i = 0; i < COLUMNS; i++)
            s->c[k + 2][i] = -over * (force[i] + s->g * rate[k][i] + (i == 0 ? 1 : 2) * b * product[i]);
        s->c[k + 2][OF_OMEGA] -= over * 2 * (s->force == RESTORING_SINE ? force[0] : s->c[k][0]);
        s->c[k + 2][OF_GAMMA] -= over * rate[k][0];
        s->c[k + 2][OF_B] -= over * s->side * product[0];
        s->c[k + 2][OF_CUBIC] -= s->force == RESTORING_CUBIC ? over * restoring.cube[k] : 0;
        if (k == 0) {
            s->c[2][0] -= over * s->side * s->f;
            s->c[2][OF_F] -= over * s->side;
        }
    }
}

/* Of the first `columns` columns: the derivative by time of the given order, at x after the start of the step. */
static void evaluate(const struct equation_walk *s, double x, int order, int columns, double *out)
{
    for (int i = 0; i < columns; i++)
        out[i] = 0;
    for (int k = ORDER; k >= order; k--) {
        const double factor = order == 0 ? 1 : order == 1 ? k : k * (k - 1);
        for (int i = 0; i < columns; i++)
            out[i] = out[i] * x + factor * s->c[k][i];
    }
}

static double speed(const struct equation_walk *s, double x)
{
    double v;
    evaluate(s, x, 1, 1, &v);
    return v;
}

/* Where the velocity changes its sign in (0, h]: regula falsi (Illinois: Dowell & Jarratt 1971). */
static double turning_time(const struct equation_walk *s, double h, double v)
{
    double low = 0, high = h, at_low = speed(s, 0), at_high = v;
    if (at_low == 0) { /* just turned: the other side is where it accelerates to */
        low = 1e-9 * h;
        at_low = speed(s, low);
        if (at_low * v > 0)
            return 0;
    }
    for (int i = 0; i < 60 && fabs(high - low) > 1e-15 * h; i++) {
        const double x = (low * at_high - high * at_low) / (at_high - at_low), at = speed(s, x);
        if (at == 0)
            return x;
        if (at * at_high < 0) {
            low = high;
            at_low = at_high;
        } else {
            at_low *= 0.5;
        }
        high = x;
        at_high = at;
    }
    return high;
}

/* The direction in which it goes on from v = 0, 0: it sticks. */
static double direction(const struct equation_walk *s)
{
    const double pull = restoring_at(s, s->c[0][0]);
    return fabs(pull) <= s->f ? 0 : -copysign(1, pull);
}

static void turn(struct equation_walk *s)
{
    const double pull = restoring_at(s, s->c[0][0]), before = -pull - s->side * s->f, side = direction(s);
    const double ratio = side == 0 || before == 0 ? 0 : (-pull - side * s->f) / before;
    for (int i = 0; i < COLUMNS; i++)
        s->c[1][i] *= ratio;
    s->c[1][0] = 0;
    s->side = side;
}

/* The length of the step that the series allows. */
static double step_length(const struct equation_walk *s)
{
    double size = 0, last = 0;
    for (int i = 0; i < COLUMNS; i++) {
        size = fmax(size, fmax(fabs(s->c[0][i]), fabs(s->c[1][i])));
        last = fmax(last, fmax(fabs(s->c[ORDER][i]), fabs(s->c[ORDER - 1][i])));
    }
    return last > 0 ? fmin(STEP_MOST, pow(ROUNDING * size / last, 1.0 / ORDER)) : STEP_MOST;
}

bool equation_begin(const struct equation *e, bool quadratic, struct equation_walk *s)
{
    const double omega = e->value[EQUATION_OMEGA];
    *s = (struct equation_walk){.force = e->force,
                                .order = e->order,
                                .quadratic = quadratic || e->value[EQUATION_RATE + 1] != 0,
                                .t0 = e->t0,
                                .omega = omega,
                                .offset = e->value[EQUATION_OFFSET],
                                .g = e->value[EQUATION_RATE] / omega,
                                .b = e->value[EQUATION_RATE + 1],
                                .f = e->value[EQUATION_RATE + 2] / (omega * omega),
                                .cubic = e->value[EQUATION_CUBIC] / (omega * omega)};
    if (!(omega > 0))
        return false;
    s->c[0][0] = e->value[EQUATION_START];
    s->c[1][0] = e->value[EQUATION_SPEED] / omega;
    s->c[0][OF_START] = s->c[1][OF_SPEED] = 1;
    s->side = s->c[1][0] != 0 ? copysign(1, s->c[1][0]) : direction(s);
    expand(s);
    return true;
}

/* Values at the samples [from, ..) that lie within the step; returns the first beyond it, n + 1: no number. */
static size_t within_step(const struct equation_walk *s, double h, const double *t, size_t from, size_t n,
                          double *value, double *derivative)
{
    const double over = 1 / s->omega, grow = s->order == 0 ? 1 : s->order == 1 ? s->omega : s->omega * s->omega;
    const double unit[COLUMNS] = {1, 1, over, over, over, 1, over * over, over * over};
    const int columns = derivative ? COLUMNS : 1;
    double row[COLUMNS];
    size_t i = from;
    for (; i < n && (t[i] - s->t0) * s->omega <= s->at + h; i++) {
        evaluate(s, s->side == 0 ? 0 : (t[i] - s->t0) * s->omega - s->at, s->order, columns, row);
        value[i] = s->offset + grow * row[0];
        if (!isfinite(value[i]))
            return n + 1;
        if (!derivative)
            continue;
        double *out = derivative + i * EQUATION_PARAMETERS;
        for (int k = OF_START; k < COLUMNS; k++)
            out[k - OF_START] = grow * unit[k] * row[k];
        out[EQUATION_OFFSET] = 1;
    }
    return i;
}

bool equation_values(struct equation_walk *s, const double *t, size_t n, double *value, double *derivative)
{
    double left = 1000 + 20 * (n > 0 ? (t[n - 1] - s->t0) * s->omega - s->at : 0);
    if (n > 0 && !((t[0] - s->t0) * s->omega >= s->at))
        return false;
    for (size_t i = 0; i < n; left--) {
        double h = s->side == 0 ? HUGE_VAL : step_length(s), row[COLUMNS], next[COLUMNS];
        if (!(h > 1e-6) || left < 0)
            return false;
        const double v = s->side == 0 ? 0 : speed(s, h);
        const bool turns = v * s->side < 0;
        if (turns)
            h = turning_time(s, h, v);
        i = within_step(s, h, t, i, n, value, derivative);
        if (i >= n)
            return i == n;
        evaluate(s, h, 0, COLUMNS, row);
        evaluate(s, h, 1, COLUMNS, next);
        memcpy(s->c[0], row, sizeof row);
        memcpy(s->c[1], next, sizeof next);
        if (turns)
            turn(s);
        s->at += h;
        expand(s);
    }
    return true;
}

bool equation_solve(const struct equation *e, const double *t, size_t n, double *value, double *derivative)
{
    struct equation_walk walk;
    return equation_begin(e, derivative != NULL, &walk) && equation_values(&walk, t, n, value, derivative);
}
