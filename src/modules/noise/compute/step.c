/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The methods for additive noise, one step of each, and the growth that a step causes. */
#include "modules/noise/compute/forcing.h"

#include <hooke/base/catalog.h>
#include <hooke/base/elementary.h>
#include <hooke/base/numeric.h>
#include <hooke/run.h>

#include <string.h>

/* Computes the rates dydt [n] without noise, with the stated damping. */
static void find_slope(const struct noise_forcing *forcing, double t, const double *y, double *dydt)
{
    system_derivative(&forcing->system, t, y, dydt);
    if (forcing->system.order == 2)
        for (int i = 0; i < forcing->count; i++)
            dydt[forcing->first + i] -= forcing->extra[i] * y[forcing->first + i];
}

/* Euler-Maruyama (Maruyama 1955): strong and weak order 1 for additive noise. */
static void step_euler(struct noise_stepper *stepper, double t, double *y, const double *noise)
{
    const struct noise_forcing *forcing = stepper->forcing;
    find_slope(forcing, t, y, stepper->slope);
    for (int i = 0; i < forcing->system.n; i++)
        y[i] += stepper->h * stepper->slope[i];
    for (int i = 0; i < forcing->count; i++)
        y[forcing->first + i] += forcing->strength[i] * noise[i];
}

/* Stochastic Heun (Kloeden, Platen 1992, section 15.1): weak order 2 for additive noise. */
static void step_heun(struct noise_stepper *stepper, double t, double *y, const double *noise)
{
    const struct noise_forcing *forcing = stepper->forcing;
    const double h = stepper->h;
    double *slope = stepper->slope, *next = stepper->next, *predicted = stepper->predicted;
    find_slope(forcing, t, y, slope);
    for (int i = 0; i < forcing->system.n; i++)
        predicted[i] = y[i] + h * slope[i];
    for (int i = 0; i < forcing->count; i++)
        predicted[forcing->first + i] += forcing->strength[i] * noise[i];
    find_slope(forcing, t + h, predicted, next);
    for (int i = 0; i < forcing->system.n; i++)
        y[i] += h / 2 * (slope[i] + next[i]);
    for (int i = 0; i < forcing->count; i++)
        y[forcing->first + i] += forcing->strength[i] * noise[i];
}

/* Computes the accelerations a [count] of all forces but linear damping, which BAOAB solves
 * exactly. */
static void find_force(const struct noise_forcing *forcing, double t, const double *y, double *a)
{
    if (!forcing->other_drag) {
        system_force(&forcing->system, t, y, a);
        return;
    }
    system_acceleration(&forcing->system, t, y, a);
    for (int i = 0; i < forcing->count; i++)
        a[i] += (forcing->gamma[i] - forcing->extra[i]) * y[forcing->first + i];
}

/* Advances the velocities in y by half a step at fixed positions, under the deterministic forces
 * except linear damping: exactly, or by the midpoint rule if these forces depend on velocity. The
 * force of the previous kick is reused if stepper->warm says that it belongs to this state. */
static void kick_half(struct noise_stepper *stepper, double t, double *y)
{
    const struct noise_forcing *forcing = stepper->forcing;
    const double h = stepper->h / 2;
    const int first = forcing->first, count = forcing->count;
    double *a = stepper->slope, *middle = stepper->predicted;
    if (!stepper->warm || forcing->other_drag)
        find_force(forcing, t, y, a);
    if (forcing->other_drag) {
        memcpy(middle, y, (size_t)forcing->system.n * sizeof *y);
        for (int i = 0; i < count; i++)
            middle[first + i] += h / 2 * a[i];
        find_force(forcing, t, middle, a);
    }
    for (int i = 0; i < count; i++)
        y[first + i] += h * a[i];
    stepper->warm = true;
}

/* Makes a step of BAOAB, in which noise and linear damping act between two half drifts (Leimkuhler,
 * Matthews 2013, Appl. Math. Res. eXpress 2013:34, eq. 12). */
static void step_baoab(struct noise_stepper *stepper, double t, double *y, const double *noise)
{
    const struct noise_forcing *forcing = stepper->forcing;
    const double h = stepper->h;
    const int first = forcing->first, count = forcing->count;
    kick_half(stepper, t, y);
    for (int i = 0; i < count; i++) {
        double *v = &y[first + i];
        y[i] += h / 2 * *v;
        *v = stepper->keep[i] * *v + stepper->kick[i] * noise[i];
        y[i] += h / 2 * *v;
    }
    stepper->warm = false;
    kick_half(stepper, t + h, y);
}

static const struct noise_method methods[] = {
    {{"euler-maruyama", "", "explicit Euler with noise, strong and weak order 1",
      "Maruyama 1955, Rend. Circ. Mat. Palermo 4:48", NULL},
     false,
     step_euler},
    {{"heun-stochastic", "", "Heun with the same noise in both stages, weak order 2",
      "Kloeden, Platen 1992, section 15.1", NULL},
     false,
     step_heun},
    {{"baoab", "", "splitting with exact damping and noise, weak order 2, one force per step",
      "Leimkuhler, Matthews 2013, Appl. Math. Res. eXpress 2013:34", NULL},
     true,
     step_baoab},
};

const struct catalog noise_method_catalog = CATALOG("method for noise", methods);

const struct noise_method *noise_method_at(size_t index)
{
    return &methods[index];
}

const struct noise_method *noise_method_natural(const struct noise_forcing *forcing)
{
    for (size_t i = COUNT_OF(methods); i-- > 0;)
        if (forcing->system.order == 2 || !methods[i].needs_velocity)
            return &methods[i];
    return &methods[0];
}

/* Computes the decay and the noise of the exact damping over a step, for BAOAB. */
void noise_stepper_begin(struct noise_stepper *stepper, const struct noise_forcing *forcing,
                         const struct noise_method *method, double h)
{
    *stepper = (struct noise_stepper){.forcing = forcing, .method = method, .h = h};
    for (int i = 0; i < forcing->count && method->needs_velocity; i++) {
        const double gamma = forcing->gamma[i];
        stepper->keep[i] = fixed_exp(-gamma * h);
        /* exact variance of the noise over the step; noise[] has variance h */
        const double variance = gamma == 0 ? h : -fixed_expm1(-2 * gamma * h) / (2 * gamma);
        stepper->kick[i] = forcing->strength[i] * sqrt(variance / h);
    }
}

/* Applies the step and checks that all variables are finite and within bounds. */
bool noise_stepper_step(struct noise_stepper *stepper, double t, double *y, const double *noise)
{
    const struct system *system = &stepper->forcing->system;
    stepper->method->step(stepper, t, y, noise);
    for (int i = 0; i < system->n; i++)
        if (!(fabs(y[i]) <= run_bound(system, i)))
            return false;
    return true;
}

/* ---- growth that a step makes ---- */

enum { GROWTH_SQUARINGS = 30 };

/* Returns the logarithm of the spectral radius of m [n][n], by repeated squaring (Gelfand 1941);
 * m and square [n][n] are overwritten. */
static double log_spectral_radius(int n, double *m, double *square)
{
    double sum = 0, share = 1;
    for (int k = 0; k < GROWTH_SQUARINGS; k++, share /= 2) {
        const double norm = matrix_norm(n, m);
        if (!(norm > 0))
            return -HUGE_VAL;
        sum += share * log(norm);
        for (int i = 0; i < n * n; i++)
            m[i] /= norm;
        matrix_multiply(n, m, m, square);
        memcpy(m, square, (size_t)(n * n) * sizeof *m);
    }
    return sum;
}

/* Computes the matrix m [n][n] that a step without noise applies to the scaled variables of a
 * linear scene, by steps from 0 and from each unit vector. */
void noise_step_matrix(struct noise_stepper *stepper, double *m)
{
    const struct system *system = &stepper->forcing->system;
    static const double silence[LIMIT_VARIABLES];
    const int n = system->n;
    for (int j = 0; j < n; j++) {
        double origin[LIMIT_VARIABLES] = {0}, unit[LIMIT_VARIABLES] = {0};
        unit[j] = system->scale[j];
        stepper->warm = false;
        stepper->method->step(stepper, system->t0, origin, silence);
        stepper->warm = false;
        stepper->method->step(stepper, system->t0, unit, silence);
        for (int i = 0; i < n; i++)
            m[i * n + j] = (unit[i] - origin[i]) / system->scale[i];
    }
}

/* Computes in spread [n][n] the covariance that unit increments of all noises add in one step to
 * the scaled variables of a linear scene. */
void noise_step_spread(struct noise_stepper *stepper, double *spread)
{
    const struct system *system = &stepper->forcing->system;
    const int n = system->n;
    memset(spread, 0, (size_t)(n * n) * sizeof *spread);
    for (int k = 0; k < stepper->forcing->count; k++) {
        double still[LIMIT_VARIABLES] = {0}, moved[LIMIT_VARIABLES] = {0};
        double noise[LIMIT_VARIABLES] = {0};
        stepper->warm = false;
        stepper->method->step(stepper, system->t0, still, noise);
        noise[k] = 1;
        stepper->warm = false;
        stepper->method->step(stepper, system->t0, moved, noise);
        for (int i = 0; i < n; i++)
            moved[i] = (moved[i] - still[i]) / system->scale[i];
        for (int i = 0; i < n * n; i++)
            spread[i] += moved[i / n] * moved[i % n];
    }
}

/* Returns the logarithm of the factor by which a step of h [s] makes a linear scene grow beyond the
 * exact solution or, if that decays, beyond a constant size: the difference between the logarithms
 * of the spectral radii of both (at least 0 for the exact one). Returns NAN if the scene is not
 * linear or too large. */
double noise_stepper_excess_growth(const struct noise_forcing *forcing,
                                   const struct noise_method *method, double h)
{
    const struct system *system = &forcing->system;
    const int n = system->n;
    if (!system->linear || n > GROWTH_VARIABLES)
        return NAN;
    double m[GROWTH_MATRIX] = {0}, work[2 * GROWTH_MATRIX];
    struct noise_stepper stepper;
    noise_stepper_begin(&stepper, forcing, method, h);
    noise_step_matrix(&stepper, m);
    const double stepped = log_spectral_radius(n, m, work);
    /* The slope of a linear scene is that of a long step of Euler's method. */
    static const double unit_time = 1;
    noise_stepper_begin(&stepper, forcing, noise_method_at(0), unit_time);
    noise_step_matrix(&stepper, m);
    for (int i = 0; i < n * n; i++)
        m[i] = (m[i] - (i % (n + 1) == 0)) * h;
    const double halvings = matrix_exponential(n, m, work);
    const double exact = log_spectral_radius(n, m, work) + halvings * log(2);
    return stepped - fmax(exact, 0);
}

/* Returns the largest step below h [s] whose excess growth per time is at most rate_max [1/s], by
 * bisection; 0 if there is none. */
double noise_stepper_stable_limit(const struct noise_forcing *forcing,
                                  const struct noise_method *method, double h, double rate_max)
{
    enum { BISECTIONS = 40 };
    double low = 0, high = h;
    for (int i = 0; i < BISECTIONS; i++) {
        const double middle = (low + high) / 2;
        if (noise_stepper_excess_growth(forcing, method, middle) <= rate_max * middle)
            low = middle;
        else
            high = middle;
    }
    return low;
}
