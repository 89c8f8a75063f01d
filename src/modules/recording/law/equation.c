/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The motion of a mass under a restoring force and a law of damping, y'' + gamma y' + b |y'| y' + f
 * sign(y') + R(y) = 0 with R = omega^2 y, omega^2 y + beta y^3 or omega^2 sin(y), and its
 * derivatives by all parameters. Between two turning points the sign of y' is constant and the
 * solution is analytic: Taylor series of it and of its variational equations (Moore 1966, Interval
 * Analysis, ch. 11), in the time unit 1/omega. At a turning point the friction jumps, and the
 * variations of y' jump with the acceleration (saltation: Aizerman & Gantmakher 1958). If the
 * spring is weaker than the friction there, the motion ends. */
#include "modules/recording/series/internal.h"

#include <hooke/scene.h>

#include <string.h>

enum {
    /* Order of the Taylor series, number of columns, and the column of the derivative by each
     * parameter. */
    ORDER = 18,
    COLUMNS = EQUATION_COLUMNS,
    OF_START = 1,
    OF_SPEED,
    OF_OMEGA,
    OF_GAMMA,
    OF_B,
    OF_F,
    OF_CUBIC
};

/* [rad] Longest step. */
#define STEP_MAX 1.2
/* Relative size of the series' last term; the neglected terms are ten times smaller. */
#define STEP_ROUNDING_RELATIVE 1e-15

_Static_assert((int)ORDER == (int)EQUATION_ORDER && (int)OF_CUBIC == (int)COLUMNS - 1,
               "a column for each parameter of the motion");

/* The Taylor coefficients of one order, in all columns. */
typedef double row __attribute__((vector_size(COLUMNS * sizeof(double)), aligned(8), may_alias));

/* Taylor coefficients: of sin(y) or y^2, of the derivative R'(y)/omega^2, and of y^3. */
struct restoring {
    double first[ORDER], slope[ORDER], cube[ORDER];
};

/* Returns the Taylor coefficient of order k of R/omega^2, from those of the motion up to order k,
 * and stores the coefficients of its parts in *r. */
static double restoring_coefficient(const struct equation_walk *s, int k, struct restoring *r)
{
    const double(*c)[COLUMNS] = s->c;
    r->cube[k] = 0;
    if (s->force == RESTORING_SINE) { /* sin' = cos y', cos' = -sin y' */
        r->first[k] = k == 0 ? sin(c[0][0]) : 0;
        r->slope[k] = k == 0 ? cos(c[0][0]) : 0;
        for (int j = 1; j <= k; j++) {
            r->first[k] += j * c[j][0] * r->slope[k - j] / k;
            r->slope[k] -= j * c[j][0] * r->first[k - j] / k;
        }
        return r->first[k];
    }
    r->first[k] = 0;
    for (int j = 0; j <= k; j++)
        r->first[k] += c[j][0] * c[k - j][0];
    for (int j = 0; j <= k; j++)
        r->cube[k] += r->first[j] * c[k - j][0];
    r->slope[k] = 3 * s->cubic * r->first[k] + (k == 0);
    return c[k][0] + s->cubic * r->cube[k];
}

/* Returns the restoring force R/omega^2 at y. */
static double restoring_at(const struct equation_walk *s, double y)
{
    if (s->force == RESTORING_LINEAR)
        return y;
    return s->force == RESTORING_SINE ? sin(y) : y + s->cubic * y * y * y;
}

/* Computes the Taylor coefficients of the motion, by the equation of motion, from those of orders 0
 * and 1. */
static void expand_values(struct equation_walk *s)
{
    double rate[ORDER];
    struct restoring restoring;
    for (int k = 0; k + 2 <= ORDER; k++) {
        double product = 0;
        rate[k] = (k + 1) * s->c[k + 1][0];
        for (int j = 0; j <= k && s->quadratic; j++)
            product += rate[j] * rate[k - j];
        const double pull =
            s->force == RESTORING_LINEAR ? s->c[k][0] : restoring_coefficient(s, k, &restoring);
        const double friction = k == 0 ? s->side * s->f : 0;
        s->c[k + 2][0] =
            -(pull + s->g * rate[k] + s->side * s->b * product + friction) / ((k + 1) * (k + 2));
    }
}

/* Computes the Taylor coefficients of the motion and of all its derivatives by parameters: each
 * derivative solves the linear equation along the motion, driven by its parameter. */
static void expand_slopes(struct equation_walk *s)
{
    row rate[ORDER];
    struct restoring restoring;
    for (int k = 0; k + 2 <= ORDER; k++) {
        const row here = *(const row *)s->c[k];
        row product = {0}, pull = here;
        rate[k] = (k + 1) * *(const row *)s->c[k + 1];
        for (int j = 0; j <= k && s->quadratic; j++)
            product += rate[j][0] * rate[k - j];
        if (s->force != RESTORING_LINEAR) {
            const double value = restoring_coefficient(s, k, &restoring);
            pull -= pull;
            for (int j = 0; j <= k; j++)
                pull += restoring.slope[j] * *(const row *)s->c[k - j];
            pull[0] = value;
        }
        const double square = product[0], b = s->side * s->b;
        row sum = pull + s->g * rate[k] + 2 * b * product;
        sum[0] -= b * square;
        sum[OF_OMEGA] += 2 * (s->force == RESTORING_SINE ? pull[0] : here[0]);
        sum[OF_GAMMA] += rate[k][0];
        sum[OF_B] += s->side * square;
        sum[OF_CUBIC] += s->force == RESTORING_CUBIC ? restoring.cube[k] : 0;
        sum[0] += k == 0 ? s->side * s->f : 0;
        sum[OF_F] += k == 0 ? s->side : 0;
        sum *= -1.0 / ((k + 1) * (k + 2));
        *(row *)s->c[k + 2] = sum;
    }
}

/* Computes the Taylor series of the next step; at rest all higher coefficients are 0. */
static void expand_series(struct equation_walk *s)
{
    if (s->side == 0)
        memset(s->c[1], 0, sizeof s->c - sizeof s->c[0]);
    else if (s->slopes)
        expand_slopes(s);
    else
        expand_values(s);
}

/* Returns the factor of x^(k - order) in the derivative of x^k, for order 0, 1 or 2. */
static inline double power_factor(int k, int order)
{
    if (order == 0)
        return 1;
    return order == 1 ? k : k * (k - 1);
}

/* Computes in result [columns] the derivative by time of the given order, of the motion (1 column)
 * or with its derivatives by all parameters, at the scaled time x after the start of the step. */
static void evaluate_series(const struct equation_walk *s, double x, int order, int columns,
                            double *result)
{
    if (columns == 1) {
        double sum = 0;
        for (int k = ORDER; k >= order; k--)
            sum = sum * x + power_factor(k, order) * s->c[k][0];
        result[0] = sum;
        return;
    }
    row sum = {0};
    for (int k = ORDER; k >= order; k--)
        sum = sum * x + power_factor(k, order) * *(const row *)s->c[k];
    *(row *)result = sum;
}

/* Returns the velocity at x after the start of the step; for root_between(). */
static double step_velocity(void *walk, double x)
{
    double v;
    evaluate_series(walk, x, 1, 1, &v);
    return v;
}

/* Returns the time in (0, h] at which the velocity changes its sign; v is the velocity at h. */
static double turning_time(struct equation_walk *s, double h, double v)
{
    double low = 0, at_low = step_velocity(s, 0);
    if (at_low == 0) { /* the motion has just turned; its side is the one to which it accelerates */
        low = 1e-9 * h;
        at_low = step_velocity(s, low);
        if (at_low * v > 0)
            return 0;
    }
    return root_between(step_velocity, s, low, at_low, h, v, 1e-15 * h);
}

/* Returns the direction in which the motion continues from v = 0, or 0 if it sticks. */
static double next_direction(const struct equation_walk *s)
{
    const double pull = restoring_at(s, s->c[0][0]);
    return fabs(pull) <= s->f ? 0 : -copysign(1, pull);
}

/* Passes a turning point: applies the saltation to the derivatives and sets the next direction. */
static void equation_walk_turn(struct equation_walk *s)
{
    const double pull = restoring_at(s, s->c[0][0]), old_acceleration = -pull - s->side * s->f,
                 side = next_direction(s);
    const double ratio =
        side == 0 || old_acceleration == 0 ? 0 : (-pull - side * s->f) / old_acceleration;
    for (int i = 0; i < COLUMNS; i++)
        s->c[1][i] *= ratio;
    s->c[1][0] = 0;
    s->side = side;
}

/* Returns the length of the step that the series permits. */
static double step_length(const struct equation_walk *s)
{
    double size = 0, last = 0;
    for (int i = 0; i < (s->slopes ? COLUMNS : 1); i++) {
        const double first = fabs(s->c[0][i]) + fabs(s->c[1][i]),
                     end = fabs(s->c[ORDER][i]) + fabs(s->c[ORDER - 1][i]);
        size = first > size ? first : size;
        last = end > last ? end : last;
    }
    return last > 0 ? fmin(STEP_MAX, pow(STEP_ROUNDING_RELATIVE * size / last, 1.0 / ORDER))
                    : STEP_MAX;
}

/* Prepares *s for evaluations of the equation: scales it to the time unit 1/omega and expands the
 * first series. `slopes` tells which derivatives will be wanted. Returns false if omega is not
 * above 0. */
bool equation_begin(const struct equation *e, enum equation_slopes slopes, struct equation_walk *s)
{
    const double omega = e->value[EQUATION_OMEGA];
    *s = (struct equation_walk){.force = e->force,
                                .order = e->order,
                                .slopes = slopes != EQUATION_VALUES,
                                .quadratic =
                                    slopes == EQUATION_SLOPES || e->value[EQUATION_RATE + 1] != 0,
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
    s->side = s->c[1][0] != 0 ? copysign(1, s->c[1][0]) : next_direction(s);
    expand_series(s);
    return true;
}

/* Computes value and derivative (NULL for none) at the samples from `first` on that lie within the
 * step of length h. Returns the index of the first sample beyond it, or n + 1 if a value is not
 * finite. */
static size_t within_step(const struct equation_walk *s, double h, const double *t, size_t first,
                          size_t n, double *value, double *derivative)
{
    const double inverse_omega = 1 / s->omega, square = s->omega * s->omega;
    const double grow = ((const double[]){1, s->omega, square})[s->order];
    const double unit[COLUMNS] = {1,
                                  1,
                                  inverse_omega,
                                  inverse_omega,
                                  inverse_omega,
                                  1,
                                  inverse_omega * inverse_omega,
                                  inverse_omega * inverse_omega};
    const int columns = derivative ? COLUMNS : 1;
    double here[COLUMNS];
    size_t i = first;
    for (; i < n && (t[i] - s->t0) * s->omega <= s->phase + h; i++) {
        evaluate_series(s, s->side == 0 ? 0 : (t[i] - s->t0) * s->omega - s->phase, s->order,
                        columns, here);
        value[i] = s->offset + grow * here[0];
        if (!isfinite(value[i]))
            return n + 1;
        if (!derivative)
            continue;
        double *gradient = derivative + i * EQUATION_PARAMETERS;
        for (int k = OF_START; k < COLUMNS; k++)
            gradient[k - OF_START] = grow * unit[k] * here[k];
        gradient[EQUATION_OFFSET] = 1;
    }
    return i;
}

/* Computes value [n] and, unless NULL, derivative [n][EQUATION_PARAMETERS] at ascending times t
 * [n], which continue those of the last call, by Taylor steps. Returns false if the steps become
 * too short or too many, or if a value is not finite. */
bool equation_values(struct equation_walk *s, const double *t, size_t n, double *value,
                     double *derivative)
{
    /* The number of steps is limited, as dry friction may turn a small motion very often. */
    double left = 1000 + 20 * (n > 0 ? (t[n - 1] - s->t0) * s->omega - s->phase : 0);
    if (n > 0 && !((t[0] - s->t0) * s->omega >= s->phase))
        return false;
    for (size_t i = 0; i < n; left--) {
        double h = s->side == 0 ? HUGE_VAL : step_length(s), end[COLUMNS], next[COLUMNS];
        if (!(h > 1e-6) || left < 0)
            return false;
        const double v = s->side == 0 ? 0 : step_velocity(s, h);
        const bool turns = v * s->side < 0;
        if (turns)
            h = turning_time(s, h, v);
        i = within_step(s, h, t, i, n, value, derivative);
        if (i >= n)
            return i == n;
        const int columns = s->slopes ? COLUMNS : 1;
        evaluate_series(s, h, 0, columns, end);
        evaluate_series(s, h, 1, columns, next);
        memcpy(s->c[0], end, (size_t)columns * sizeof *end);
        memcpy(s->c[1], next, (size_t)columns * sizeof *next);
        if (turns)
            equation_walk_turn(s);
        s->phase += h;
        expand_series(s);
    }
    return true;
}

bool equation_solve(const struct equation *e, const double *t, size_t n, double *value,
                    double *derivative)
{
    struct equation_walk walk;
    return equation_begin(e, derivative ? EQUATION_SLOPES : EQUATION_VALUES, &walk) &&
           equation_values(&walk, t, n, value, derivative);
}
