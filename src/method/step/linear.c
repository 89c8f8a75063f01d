/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Linear stability: the one-step matrix of a method on q'' + 2 zeta q' + q = 0 (or + 0, or - q) and
 * the largest step that does not grow. The frequency is 1, so that h is x = omega dt and the state
 * is already the scaled one.
 */
#include "method/step/step.h"

#include <stdlib.h>

/* Growth above 1 up to which it counts as rounding. */
static const double GROWTH_ROUNDING = 1e-12;

/* Range of the search for the largest stable step; the first value is divided by zeta > 1. */
static const double X_FIRST = 1e-4, X_LAST = 1e8;

/* Returns the next x of the search. Steps are fine near pi, where splittings have narrow
 * windows. */
static double next_x(double x)
{
    if (x > 3.05 && x < 3.25)
        return x * 1.00005;
    return x * (x > 0.3 && x < 30 ? 1.003 : 1.03);
}

/* A method on the linear equation. */
struct linear_scene {
    const struct method *method;
    enum drag drag;
    double zeta;
    enum stiffness_sign sign;
    struct system system;
};

/* Returns 1, 0 or -1. */
double stiffness_sign_value(enum stiffness_sign sign)
{
    if (sign == STIFFNESS_ZERO)
        return 0;
    return sign == STIFFNESS_POSITIVE ? 1 : -1;
}

/* Prepares the method on the equation with frequency 1. Returns false if it cannot step it. */
static bool oscillation_init(struct linear_scene *oscillation, const struct method *method,
                             enum drag drag, double zeta, enum stiffness_sign sign)
{
    const struct {
        const char *name;
        double value;
    } args[] = {{"m", 1}, {"k", stiffness_sign_value(sign)}, {"gamma", 2 * zeta}};
    struct scene scene;
    struct error ignored;
    scene_init(&scene, NULL);
    for (size_t i = 0; i < COUNT_OF(args); i++)
        if (!scene_set(&scene, param_index(args[i].name), (struct measured){args[i].value, 0},
                       &ignored))
            return false;
    if (!scene_bind(&scene, &oscillation->system, &ignored))
        return false;
    oscillation->method = method;
    oscillation->drag = drag;
    oscillation->zeta = zeta;
    oscillation->sign = sign;
    return !(method->flags & METHOD_EXTERNAL) &&
           method_applies(method, &oscillation->system, &oscillation->drag, &ignored);
}

/* Computes the one-step matrix, whose columns are the images of the unit vectors; NaN if the step
 * fails or memory runs out. */
static void amplify(const struct linear_scene *oscillation, double x, double matrix[4])
{
    double *work = malloc((method_work_size(oscillation->method, 2) + 1) * sizeof *work);
    for (int column = 0; column < 2; column++) {
        double y[2] = {column == 0, column == 1};
        struct step step = {.system = &oscillation->system,
                            .drag = oscillation->drag,
                            .h = x,
                            .y = y,
                            .work = work};
        const bool ok = work && method_step(oscillation->method, &step) == STEP_OK;
        matrix[column] = ok ? y[0] : NAN;
        matrix[2 + column] = ok ? y[1] : NAN;
    }
    free(work);
}

/* Computes the one-step matrix. Returns false for methods without one, and if a step fails. */
bool method_amplification(const struct method *method, enum drag drag, double x, double zeta,
                          double matrix[4])
{
    struct linear_scene oscillation;
    if (method->growth || !oscillation_init(&oscillation, method, drag, zeta, STIFFNESS_POSITIVE))
        return false;
    amplify(&oscillation, x, matrix);
    return !isnan(matrix[0]) && !isnan(matrix[1]);
}

/* Returns the larger absolute eigenvalue of m [2][2]. */
double matrix_spectral_radius(const double m[4])
{
    double mean = (m[0] + m[3]) / 2, half = (m[0] - m[3]) / 2;
    double split = half * half + m[1] * m[2]; /* the eigenvalues are mean +- sqrt(split) */
    return split >= 0 ? fabs(mean) + sqrt(split) : sqrt(mean * mean - split);
}

/* Returns the growth per step at x, by the method's own function or by the one-step matrix. */
static double growth_factor(const struct linear_scene *oscillation, double x)
{
    if (oscillation->method->growth)
        return oscillation->method->growth(oscillation->method, x, oscillation->zeta,
                                           oscillation->sign);
    double matrix[4];
    amplify(oscillation, x, matrix);
    return matrix_spectral_radius(matrix);
}

double method_growth_signed(const struct method *method, enum drag drag, double x, double zeta,
                            enum stiffness_sign sign)
{
    struct linear_scene oscillation;
    return oscillation_init(&oscillation, method, drag, zeta, sign) ? growth_factor(&oscillation, x)
                                                                    : NAN;
}

double method_growth(const struct method *method, enum drag drag, double x, double zeta)
{
    return method_growth_signed(method, drag, x, zeta, STIFFNESS_POSITIVE);
}

/* Returns the growth per step less 1, which is positive if the step grows; HUGE_VAL if it fails. */
static double growth_excess(const struct linear_scene *oscillation, double x)
{
    double radius = growth_factor(oscillation, x);
    return isnan(radius) ? HUGE_VAL : radius - 1;
}

/* Returns the largest stable x = omega dt: goes up in x until growth exceeds the margin, then
 * bisects. */
double method_stable_limit_signed(const struct method *method, enum drag drag, double zeta,
                                  enum stiffness_sign sign)
{
    struct linear_scene oscillation;
    if (!oscillation_init(&oscillation, method, drag, zeta, sign))
        return NAN;
    double low = 0, high = X_FIRST / fmax(1, fabs(zeta));
    while (growth_excess(&oscillation, high) <= GROWTH_ROUNDING) {
        low = high;
        high = next_x(high);
        if (high > X_LAST)
            return HUGE_VAL;
    }
    if (low == 0)
        return 0;
    /* growth like x^q from 0 on also reaches the margin; then it exceeds rounding a little below,
     * and no step is stable */
    double previous = growth_excess(&oscillation, 0.9 * low), margin = GROWTH_ROUNDING;
    if (previous > GROWTH_ROUNDING / 10)
        return 0;
    if (previous < -GROWTH_ROUNDING) { /* decay turns into growth, so that the limit is where growth
                                          is exactly 1 */
        margin = 0;
        low *= 0.9;
    }
    while (high - low > 1e-14 * high) {
        double x = low + (high - low) / 2;
        if (x == low || x == high)
            break;
        *(growth_excess(&oscillation, x) <= margin ? &low : &high) = x;
    }
    return low;
}

/* Returns the largest omega dt at which the method is stable for a spring (positive stiffness) with
 * the damping ratio zeta. */
double method_stable_limit(const struct method *method, enum drag drag, double zeta)
{
    return method_stable_limit_signed(method, drag, zeta, STIFFNESS_POSITIVE);
}
