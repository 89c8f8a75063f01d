/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The pendulum: a bob on a rigid rod, swinging or turning over, with damping and a driving force
 * along its path. */
#include <hooke/base/catalog.h>
#include "scene/model/forces.h"

#define PARAMS(P)                                                                                  \
    P(m, "kg", MASS, 0.2, ABOVE(0), "mass of the bob")                                             \
    P(length, "m", LENGTH, 1, ABOVE(0), "length of the rod")                                       \
    P(g, "m/s^2", ACCELERATION, 9.81, UNBOUNDED_BELOW, "gravity")                                  \
    P(gamma, "1/s", RATE, 0, UNBOUNDED_BELOW,                                                      \
      "linear damping of theta'' + gamma theta' + (g/length) sin theta = 0")                       \
    P(F0, "N", FORCE, 0, UNBOUNDED_BELOW,                                                          \
      "driving force F0 cos(omega t + phase) along the path of the bob")                           \
    P(omega, "rad/s", ANGULAR_FREQUENCY, 2, AT_LEAST(0), "angular frequency of the driving force") \
    P(phase, "rad", ANGLE, 0, UNBOUNDED_BELOW, "phase of the driving force at t = 0")              \
    P(friction, "N", FORCE, 0, AT_LEAST(0),                                                        \
      "dry friction along the path of the bob, against the motion")                                \
    P(theta0, "rad", ANGLE, 1, UNBOUNDED_BELOW, "angle from the vertical at t0")                   \
    P(rate0, "rad/s", ANGULAR_FREQUENCY, 0, UNBOUNDED_BELOW, "angular velocity at t0")             \
    P(t0, "s", TIME, 0, UNBOUNDED_BELOW, "time at the start")

PARAM_PLACES(PARAMS);
static const struct param_row params[] = {PARAMS(PARAM_ROW)};
static const struct catalog param_table = CATALOG("parameter", params);

TERM_BIND(weight)
{
    c[0] = param[P_g] / param[P_length];
    c[1] = param[P_m] * param[P_g] * param[P_length];
    return c[0] != 0;
}

TERM_BIND(damping)
{
    c[0] = param[P_gamma];
    c[1] = param[P_m] * param[P_length] * param[P_length];
    oscillator->damping += c[0];
    return c[0] != 0;
}

TERM_BIND(drive)
{
    c[0] = param[P_F0] / (param[P_m] * param[P_length]);
    c[1] = param[P_omega];
    c[2] = param[P_phase];
    c[3] = param[P_F0] * param[P_length];
    return c[0] != 0;
}

TERM_BIND(friction)
{
    c[0] = param[P_friction] / (param[P_m] * param[P_length]);
    c[1] = param[P_friction] * param[P_length];
    oscillator->friction += c[0];
    return c[0] != 0;
}

static const struct term_row terms[] = {
    {.row = {"weight", "rad/s^2", "weight: restoring acceleration (g/length) sin theta",
             "Huygens 1673", NULL},
     .flags = TERM_CONSERVATIVE,
     .equation = {"-g/length*sin(theta)"},
     .force = FORCE_weight,
     .bind = weight_bind,
     .add = weight_add,
     .jacobian = weight_jacobian,
     .potential = weight_potential,
     .text = weight_text},
    {.row = {"damping", "rad/s^2", "linear damping -gamma theta'", "Stokes 1851", NULL},
     .flags = TERM_LINEAR | TERM_VELOCITY,
     .equation = {"-gamma*theta'"},
     .force = FORCE_damping,
     .bind = damping_bind,
     .add = damping_add,
     .jacobian = damping_jacobian,
     .text = damping_text},
    {.row = {"drive", "rad/s^2", "driving force F = F0 cos(omega t + phase) along the path", "",
             NULL},
     .flags = TERM_LINEAR | TERM_TIME,
     .equation = {"F0/(m*length)*cos(omega*t+phase)"},
     .force = FORCE_drive,
     .bind = drive_bind,
     .add = drive_add,
     .text = drive_text},
    {.row = {"friction", "rad/s^2", "dry friction F = -friction sign(theta') along the path",
             "Coulomb 1785", NULL},
     .flags = TERM_VELOCITY | TERM_KINK | TERM_DRY,
     .equation = {"-friction/(m*length)*sign(theta')"},
     .bind = friction_bind,
     .add = friction_add},
};
static const struct catalog term_table = CATALOG("force term", terms);

static double omega0(const struct scene *scene)
{
    double g = scene->value[P_g];
    return g > 0 ? sqrt(g / scene->value[P_length]) : NAN;
}

static double T0(const struct scene *scene)
{
    return TWO_PI / omega0(scene);
}

/* Returns the period at the initial amplitude: T0 over the arithmetic-geometric mean of 1 and
 * cos(a/2), where a is the largest angle (Gauss). NaN if the pendulum turns over. */
static double period(const struct scene *scene)
{
    double s = fixed_sin(scene->value[P_theta0] / 2),
           turn = scene->value[P_rate0] / (2 * omega0(scene));
    /* sin^2 of half the largest angle is s^2 + turn^2, by conservation of energy */
    double a = 1, b = sqrt(1 - s * s - turn * turn);
    while (b > 0 && a - b > 4 * DBL_EPSILON * a) {
        double mean = (a + b) / 2;
        b = sqrt(a * b);
        a = mean;
    }
    return b > 0 ? T0(scene) / a : NAN;
}

static double E0(const struct scene *scene)
{
    return scene_start_energy(scene);
}

static double omega0_inverse(const struct scene *scene, double value)
{
    return value > 0 ? scene->value[P_g] / (value * value) : NAN;
}

static double T0_inverse(const struct scene *scene, double value)
{
    return omega0_inverse(scene, TWO_PI / value);
}

#define DERIVED_ROWS(ROW)                                                                          \
    ROW(omega0, "rad/s", ANGULAR_FREQUENCY, "angular frequency of small swings, sqrt(g/length)",   \
        "", omega0_inverse, "length")                                                              \
    ROW(T0, "s", TIME, "period of small swings, 2 pi/omega0", "Huygens 1673", T0_inverse,          \
        "length")                                                                                  \
    ROW(period, "s", TIME, "period at the initial amplitude, without damping and drive",           \
        "Gauss 1799", NULL, NULL)                                                                  \
    ROW(E0, "J", ENERGY, "energy at the start, measured from the lowest point", "", NULL, NULL)

DERIVED_ROWS(MEASURED)
static const struct derived_row derived[] = {DERIVED_ROWS(DERIVED_ROW)};
static const struct catalog derived_table = CATALOG("derived quantity", derived);

/* Returns true if the coefficients are usable numbers; otherwise sets an error. */
static bool coherent(const double *param, struct error *error)
{
    double inertia = param[P_m] * param[P_length] * param[P_length];
    if (isfinite(param[P_g] / param[P_length]) && isfinite(inertia) && inertia >= DBL_MIN)
        return true;
    return error_set(error, ERROR_COMMAND,
                     "g/length or m length^2 overflows: m = %g kg, length = %g m, g = %g m/s^2",
                     param[P_m], param[P_length], param[P_g]);
}

/* Sets the start and the natural sizes: a radian, or less if the swing is small; the response to
 * the drive is at most about a turn. */
static void pendulum_scales(const double *param, struct system *system)
{
    double rate = sqrt(fabs(param[P_g] / param[P_length])),
           drive = fabs(param[P_F0]) / (param[P_m] * param[P_length]);
    rate = rate > 0 ? rate : fmax(fabs(param[P_gamma]), param[P_omega]);
    rate = rate > 0 ? rate : 1;
    double angle = fmax(fabs(param[P_theta0]), fabs(param[P_rate0]) / rate);
    angle = fmin(fmax(angle, drive / (rate * rate)), 1);
    system->t0 = param[P_t0];
    system->mass = param[P_m] * param[P_length] * param[P_length];
    system->start[0] = param[P_theta0];
    system->start[1] = param[P_rate0];
    system->scale[0] = scale_clamp(angle);
    system->scale[1] = scale_clamp(fmax(angle * rate, fabs(param[P_rate0])));
}

static const struct variable variables[] = {{"theta", QUANTITY_ANGLE},
                                            {"rate", QUANTITY_ANGULAR_FREQUENCY}};

const struct model pendulum_model = {
    .row = {"pendulum", "", "theta'' = -(g/length) sin theta, with optional damping and drive",
            "Huygens 1673", NULL},
    .order = 2,
    .n = 2,
    .variable = variables,
    .params = &param_table,
    .terms = &term_table,
    .derived = &derived_table,
    .coherent = coherent,
    .begin = pendulum_scales,
};
