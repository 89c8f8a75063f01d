/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Derives a scene's parameters from the fit of an oscillation, and their covariances from those of
 * the fit, to first order. */
#include "modules/recording/scene/scene_fit.h"

#include <math.h>

/* Names of the scene's parameters, in the order of enum adopted_value. */
static const char *const names[ADOPTED_VALUES] = {"k",  "k3", "gamma",  "C",      "friction",
                                                  "y0", "v0", "length", "theta0", "rate0"};

/* Sets start to position and velocity at the fit's t0. n is the number of times that a position was
 * differentiated to give the fitted quantity (2 for an acceleration). */
static void start_in_motion(const struct fit *fit, int n, struct measured start[2])
{
    if (fit->drag.candidates > 0) {
        start[0] = fit->drag.start;
        start[1] = fit->drag.speed;
        return;
    }
    /* Each derivative of A exp(-gamma t/2) cos(omega t + phi) has the same form, larger by the
     * factor `growth` and earlier by the phase `turn`. */
    const double half = isfinite(fit->gamma.value) ? 0.5 * fit->gamma.value : 0,
                 omega = fit->omega.value;
    const double growth = hypot(half, omega), turn = atan2(omega, -half);
    const double A = fit->amplitude.value / pow(growth, n), phi = fit->phase.value - n * turn;
    const double spread = fit->amplitude.uncertainty / pow(growth, n),
                 angle = A * fit->phase.uncertainty;
    start[0] = (struct measured){A * cos(phi), hypot(spread * cos(phi), angle * sin(phi))};
    start[1] = (struct measured){A * (-half * cos(phi) - omega * sin(phi)),
                                 omega * hypot(spread * sin(phi), angle * cos(phi))};
}

/* Sets start to position and velocity at the fit's t0 or, if at_rest, to its amplitude and zero. */
static void start_of(const struct fit *fit, int n, bool at_rest, struct measured start[2])
{
    start_in_motion(fit, n, start);
    if (!at_rest)
        return;
    const double half = isfinite(fit->gamma.value) ? 0.5 * fit->gamma.value : 0;
    const double growth = pow(hypot(half, fit->omega.value), n);
    start[0] =
        (struct measured){fit->amplitude.value / growth, fit->amplitude.uncertainty / growth};
    start[1] = (struct measured){0, 0};
}

/* Adds offset to parameter i of the fit, numbered as in its covariance: parameters of the equation
 * of motion if laws of damping were compared, of the damped sine otherwise. */
static void shift_parameter(struct fit *fit, int i, double offset)
{
    const double half = isfinite(fit->gamma.value) ? 0.5 * fit->gamma.value : 0;
    struct drag_fit *drag = &fit->drag;
    if (drag->candidates == 0) {
        struct measured *const sine[SINE_PARAMETERS] = {&fit->amplitude, &fit->phase, &fit->omega,
                                                        &fit->gamma};
        sine[i]->value += offset;
    } else if (i < EQUATION_OMEGA) {
        (i == EQUATION_START ? &drag->start : &drag->speed)->value += offset;
    } else if (i == EQUATION_OMEGA) { /* the fit's omega is the damped one */
        const double omega = hypot(fit->omega.value, half) + offset;
        fit->omega.value = sqrt(omega * omega - half * half);
    } else if (i == EQUATION_CUBIC) {
        drag->cubic.value += offset;
    } else {
        drag->candidate[drag->best - 1].rate[i - EQUATION_RATE].value += offset;
        if (i == EQUATION_RATE) { /* omega0 stays */
            const double omega = hypot(fit->omega.value, half), now = half + 0.5 * offset;
            fit->gamma.value = 2 * now;
            fit->omega.value = sqrt(omega * omega - now * now);
        }
    }
}

/* Returns a measured value multiplied by an exact, positive factor. */
static struct measured measured_times(struct measured value, double factor)
{
    return (struct measured){value.value * factor, value.uncertainty * factor};
}

/* Returns a parameter of the scene with its uncertainty, NAN if the scene does not have it. */
static struct measured param_measured(const struct scene *scene, const char *name)
{
    const int index = scene_param(scene, name);
    return index >= 0 ? (struct measured){scene->value[index], scene->uncertainty[index]}
                      : (struct measured){NAN, NAN};
}

/* Converts frequency, damping and start of the fit to the scene's parameters, in value. n is the
 * number of derivatives that the fitted quantity is of a position; at_rest starts at the amplitude
 * without velocity. */
void adopted_values(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    struct measured value[ADOPTED_VALUES])
{
    const struct measured mass = param_measured(scene, "m"), g = param_measured(scene, "g"),
                          none = {0};
    const double m = mass.value, drag = param_value(scene, "rho") * param_value(scene, "area") / m;
    const struct drag_candidate *law =
        fit->drag.candidates ? &fit->drag.candidate[fit->drag.best - 1] : NULL;
    const struct measured square = fit_stiffness(fit, (struct measured){1, 0});
    const double length = g.value / square.value;
    struct measured start[2];
    start_of(fit, n, at_rest, start);
    value[ADOPTED_STIFFNESS] = fit_stiffness(fit, mass);
    value[ADOPTED_CUBIC] = measured_times(fit->drag.cubic, m);
    value[ADOPTED_LINEAR] = law ? law->rate[0] : fit->gamma;
    value[ADOPTED_QUADRATIC] = law && drag > 0 ? measured_times(law->rate[1], 1 / drag) : none;
    value[ADOPTED_LENGTH] = (struct measured){
        length, length * hypot(square.uncertainty / square.value, g.uncertainty / g.value)};
    const double inertia = is_pendulum(scene) ? m * length : m;
    value[ADOPTED_DRY] = law ? measured_times(law->rate[2], inertia) : none;
    value[ADOPTED_POSITION] = value[ADOPTED_ANGLE] = start[0];
    value[ADOPTED_POSITION].value += -m * g.value / value[ADOPTED_STIFFNESS].value;
    value[ADOPTED_VELOCITY] = value[ADOPTED_TURNING] = start[1];
}

/* Returns the position per unit of the fitted quantity for which the fitted motion has the
 * amplitude of the scene's start; 0 for a scene at rest. */
double adopted_scale_of(const struct scene *scene, const struct fit *fit)
{
    const bool pendulum = is_pendulum(scene);
    const double half = isfinite(fit->gamma.value) ? 0.5 * fit->gamma.value : 0;
    double y = param_value(scene, pendulum ? "theta0" : "y0");
    const double v = param_value(scene, pendulum ? "rate0" : "v0");
    /* Gravity moves the middle of the motion to -m g/k. */
    if (!pendulum) {
        const double m = param_value(scene, "m"), g = param_value(scene, "g");
        y += m * g / fit_stiffness(fit, (struct measured){m, 0}).value;
    }
    return hypot(y, (v + half * y) / fit->omega.value) / fit->amplitude.value;
}

/* Multiplies a measured value by a factor of either sign. */
static void scale_measured(struct measured *m, double factor)
{
    m->value *= factor;
    m->uncertainty *= fabs(factor);
}

/* Multiplies the fitted quantity by `scale`: all values, rates and covariances by their powers of
 * its unit. */
void adopted_scale(struct fit *fit, double scale)
{
    struct drag_fit *drag = &fit->drag;
    const bool law = drag->candidates > 0;
    double factor[CURVE_PARAMETERS];
    for (int i = 0; i < CURVE_PARAMETERS; i++)
        factor[i] = 1;
    factor[law ? EQUATION_START : SINE_AMPLITUDE] = scale;
    if (law) {
        factor[EQUATION_SPEED] = scale;
        factor[EQUATION_RATE + 1] = 1 / scale; /* y'' = -b |y'| y' */
        factor[EQUATION_RATE + 2] = scale;     /* y'' = -f */
        factor[EQUATION_CUBIC] = 1 / (scale * scale);
        scale_measured(&drag->start, scale);
        scale_measured(&drag->speed, scale);
        scale_measured(&drag->cubic, factor[EQUATION_CUBIC]);
        for (int k = 0; k < drag->candidates; k++)
            for (int r = 0; r < DRAG_RATES; r++)
                scale_measured(&drag->candidate[k].rate[r], factor[EQUATION_RATE + r]);
    }
    scale_measured(&fit->amplitude, scale);
    scale_measured(&fit->offset, scale);
    scale_measured(&fit->drift, scale);
    fit->rms *= fabs(scale);
    for (int i = 0; i < fit->covariance.n; i++)
        for (int j = 0; j < fit->covariance.n; j++)
            fit->covariance.entry[i][j] *= factor[i] * factor[j];
}

/* Computes the derivatives of all adopted values by parameter i of the fit, by central differences;
 * n and at_rest are passed to adopted_values(). They are 0 if the parameter has no uncertainty. */
static void slope_of(const struct scene *scene, const struct fit *fit, int i, int n, bool at_rest,
                     double slope[ADOPTED_VALUES])
{
    const double deviation = sqrt(fit->covariance.entry[i][i]), increment = 1e-2 * deviation;
    struct measured side[2][ADOPTED_VALUES];
    for (int s = 0; s < 2; s++) {
        struct fit moved = *fit;
        shift_parameter(&moved, i, s ? increment : -increment);
        adopted_values(scene, &moved, n, at_rest, side[s]);
    }
    for (int k = 0; k < ADOPTED_VALUES; k++)
        slope[k] = increment > 0 ? (side[1][k].value - side[0][k].value) / (2 * increment) : 0;
}

/* Fills *adopted with the parameters that adoption sets and their covariances, propagated from the
 * fit's by numerical derivatives. n and at_rest are those of adopted_values(); without `starts` the
 * initial state is left out. */
void adopted_motion(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    bool starts, struct scene_covariance *adopted)
{
    const int max = starts ? ADOPTED_VALUES : ADOPTED_POSITION;
    const struct fit_covariance *covariance = &fit->covariance;
    double slope[CURVE_PARAMETERS][ADOPTED_VALUES];
    int target[ADOPTED_VALUES];
    for (int i = 0; i < covariance->n; i++)
        slope_of(scene, fit, i, n, at_rest, slope[i]);
    for (int k = 0; k < max && covariance->n > 0; k++) {
        const int index = scene_param(scene, names[k]);
        double size = 0;
        for (int i = 0; i < covariance->n; i++)
            size += fabs(slope[i][k]) * covariance->entry[i][i];
        if (index < 0 || !(size > 0))
            continue;
        target[adopted->count] = k;
        adopted->index[adopted->count++] = index;
    }
    for (int k = 0; k < adopted->count; k++)
        for (int l = 0; l < adopted->count; l++)
            for (int i = 0; i < covariance->n; i++)
                for (int j = 0; j < covariance->n; j++)
                    adopted->covariance[k * adopted->count + l] +=
                        slope[i][target[k]] * covariance->entry[i][j] * slope[j][target[l]];
}

/* The covariance holds free parameters alone, in the order of the scene. */
void adopted_free(const bool *is_free, const struct fit_covariance *covariance,
                  struct scene_covariance *adopted)
{
    for (int i = 0; i < PARAM_MAX && adopted->count < covariance->n; i++)
        if (is_free[i])
            adopted->index[adopted->count++] = i;
    for (int k = 0; k < adopted->count; k++)
        for (int l = 0; l < adopted->count; l++)
            adopted->covariance[k * adopted->count + l] = covariance->entry[k][l];
}
