/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The motion of a mass on a spring under a law of damping,
 *     y'' + gamma y' + b |y'| y' + f sign(y') + omega^2 y = 0,
 * and its derivatives by everything in it. Between two turning points the sign of y' is constant and the solution is
 * analytic: Taylor series of it and of its variational equations (Moore 1966, Interval Analysis, ch. 11), in the time
 * unit 1/omega. At a turning point the friction jumps; the variations of y' jump with the acceleration (saltation:
 * Aizerman & Gantmakher 1958). Where the spring is weaker than the friction there, the motion ends.
 */
#include "internal.h"

#include <string.h>

enum { ORDER = 18, COLUMNS = 8, OF_START = 1, OF_SPEED, OF_OMEGA, OF_GAMMA, OF_B, OF_F };

#define STEP_MOST 1.2  /* [rad] */
#define ROUNDING 1e-17 /* share of the series that its last term may have */

struct solution {
    double g, b, f;               /* in the time unit 1/omega */
    double side;                  /* sign of the velocity, 0: at rest for good */
    double c[ORDER + 1][COLUMNS]; /* Taylor coefficients of y, and of its derivatives by the parameters */
};

/* Taylor coefficients from those of orders 0 and 1. */
static void expand(struct solution *s)
{
    double rate[ORDER][COLUMNS]; /* coefficients of the time derivatives */
    if (s->side == 0) {
        memset(s->c[1], 0, sizeof s->c - sizeof s->c[0]);
        return;
    }
    const double b = s->side * s->b;
    for (int k = 0; k + 2 <= ORDER; k++) {
        double product[COLUMNS] = {0}, over = 1.0 / ((k + 1) * (k + 2));
        for (int i = 0; i < COLUMNS; i++)
            rate[k][i] = (k + 1) * s->c[k + 1][i];
        for (int j = 0; j <= k; j++)
            for (int i = 0; i < COLUMNS; i++)
                product[i] += rate[j][0] * rate[k - j][i];
        for (int i = 0; i < COLUMNS; i++)
            s->c[k + 2][i] =
                -over * (s->c[k][i] + s->g * rate[k][i] + (i == 0 ? 1 : 2) * b * product[i]);
        s->c[k + 2][OF_OMEGA] -= over * 2 * s->c[k][0];
        s->c[k + 2][OF_GAMMA] -= over * rate[k][0];
        s->c[k + 2][OF_B] -= over * s->side * product[0];
        if (k == 0) {
            s->c[2][0] -= over * s->side * s->f;
            s->c[2][OF_F] -= over * s->side;
        }
    }
}

/* Of the first `columns` columns: the derivative by time of the given order, at x after the start of the step. */
static void evaluate(const struct solution *s, double x, int order, int columns, double *out)
{
    for (int i = 0; i < columns; i++)
        out[i] = 0;
    for (int k = ORDER; k >= order; k--) {
        const double factor = order == 0 ? 1 : order == 1 ? k : k * (k - 1);
        for (int i = 0; i < columns; i++)
            out[i] = out[i] * x + factor * s->c[k][i];
    }
}

static double speed(const struct solution *s, double x)
{
    double v;
    evaluate(s, x, 1, 1, &v);
    return v;
}

/* Where the velocity changes its sign in (0, h]: regula falsi (Illinois: Dowell & Jarratt 1971). */
static double turning_time(const struct solution *s, double h, double v)
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
static double direction(const struct solution *s)
{
    return fabs(s->c[0][0]) <= s->f ? 0 : -copysign(1, s->c[0][0]);
}

static void turn(struct solution *s)
{
    const double before = -s->c[0][0] - s->side * s->f, side = direction(s);
    const double ratio = side == 0 || before == 0 ? 0 : (-s->c[0][0] - side * s->f) / before;
    for (int i = 0; i < COLUMNS; i++)
        s->c[1][i] *= ratio;
    s->c[1][0] = 0;
    s->side = side;
}

/* The length of the step that the series allows. */
static double step_length(const struct solution *s)
{
    double size = 0, last = 0;
    for (int i = 0; i < COLUMNS; i++) {
        size = fmax(size, fmax(fabs(s->c[0][i]), fabs(s->c[1][i])));
        last = fmax(last, fmax(fabs(s->c[ORDER][i]), fabs(s->c[ORDER - 1][i])));
    }
    return last > 0 ? fmin(STEP_MOST, pow(ROUNDING * size / last, 1.0 / ORDER)) : STEP_MOST;
}

static void begin(const struct equation *e, struct solution *s)
{
    const double omega = e->value[EQUATION_OMEGA];
    *s = (struct solution){.g = e->value[EQUATION_RATE] / omega,
                           .b = e->value[EQUATION_RATE + 1],
                           .f = e->value[EQUATION_RATE + 2] / (omega * omega)};
    s->c[0][0] = e->value[EQUATION_START];
    s->c[1][0] = e->value[EQUATION_SPEED] / omega;
    s->c[0][OF_START] = s->c[1][OF_SPEED] = 1;
    s->side = s->c[1][0] != 0 ? copysign(1, s->c[1][0]) : direction(s);
    expand(s);
}

bool equation_solve(const struct equation *e, const double *t, size_t n, double *value, double *derivative)
{
    const double omega = e->value[EQUATION_OMEGA], grow = pow(omega, e->order);
    const double unit[COLUMNS] = {1, 1, 1 / omega, 1 / omega, 1 / omega, 1, 1 / (omega * omega)};
    const int columns = derivative ? EQUATION_PARAMETERS : 1;
    struct solution s;
    double at = 0, left = 1000 + 20 * omega * (n > 0 ? t[n - 1] - e->t0 : 0);
    if (!(omega > 0) || (n > 0 && t[0] < e->t0))
        return false;
    begin(e, &s);
    for (size_t i = 0; i < n; left--) {
        double h = s.side == 0 ? HUGE_VAL : step_length(&s), row[COLUMNS], next[COLUMNS];
        if (!(h > 1e-6) || left < 0)
            return false;
        const double v = s.side == 0 ? 0 : speed(&s, h);
        const bool turns = v * s.side < 0;
        if (turns)
            h = turning_time(&s, h, v);
        for (; i < n && (t[i] - e->t0) * omega <= at + h; i++) {
            evaluate(&s, s.side == 0 ? 0 : (t[i] - e->t0) * omega - at, e->order, columns, row);
            value[i] = e->value[EQUATION_OFFSET] + grow * row[0];
            if (!isfinite(value[i]))
                return false;
            if (!derivative)
                continue;
            double *out = derivative + i * EQUATION_PARAMETERS;
            for (int k = OF_START; k <= OF_F; k++)
                out[k - OF_START] = grow * unit[k] * row[k];
            out[EQUATION_OFFSET] = 1;
        }
        if (i == n)
            break;
        evaluate(&s, h, 0, COLUMNS, row);
        evaluate(&s, h, 1, COLUMNS, next);
        memcpy(s.c[0], row, sizeof row);
        memcpy(s.c[1], next, sizeof next);
        if (turns)
            turn(&s);
        at += h;
        expand(&s);
    }
    return true;
}
