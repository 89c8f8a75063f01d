/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The elastic pendulum: a bob on a spring that swings, in Cartesian coordinates from the pivot, y
 * up. With a stiff spring the fast vibration along it is what limits explicit methods, while the
 * swing is what one wants to see.
 */
#include <hooke/base/catalog.h>
#include "scene/model/model.h"

#define PARAMS(P)                                                                                  \
    P(m, "kg", MASS, 1, ABOVE(0), "mass of the bob")                                               \
    P(k, "N/m", STIFFNESS, 100, AT_LEAST(0), "spring constant")                                    \
    P(length, "m", LENGTH, 1, AT_LEAST(0), "length of the spring at rest")                         \
    P(g, "m/s^2", ACCELERATION, 9.81, UNBOUNDED_BELOW, "gravity")                                  \
    P(gamma, "1/s", RATE, 0, UNBOUNDED_BELOW, "linear damping F = -m gamma v")                     \
    P(theta0, "rad", ANGLE, 1, UNBOUNDED_BELOW, "angle from the vertical at t0")                   \
    P(stretch0, "m", LENGTH, 0, UNBOUNDED_BELOW, "elongation of the spring at t0")                 \
    P(rate0, "rad/s", ANGULAR_FREQUENCY, 0, UNBOUNDED_BELOW, "angular velocity at t0")             \
    P(t0, "s", TIME, 0, UNBOUNDED_BELOW, "time at the start")

PARAM_PLACES(PARAMS);
static const struct param_row params[] = {PARAMS(PARAM_ROW)};
static const struct catalog param_table = CATALOG("parameter", params);

/* the spring's force, F = -k (1 - length/r) (x, y) */
TERM_BIND(spring)
{
    c[0] = param[P_k] / param[P_m];
    c[1] = param[P_length];
    c[2] = param[P_k];
    return c[0] != 0;
}
TERM_ADD(spring)
{
    double pull = c[0] * (1 - c[1] / fixed_hypot(y[0], y[1]));
    a[0] -= pull * y[0];
    a[1] -= pull * y[1];
}
TERM_JACOBIAN(spring)
{
    double r = fixed_hypot(y[0], y[1]), ratio = c[1] / r, pull = c[0] * (1 - ratio), x = y[0] / r,
           z = y[1] / r;
    jac[0] -= pull + c[0] * ratio * x * x;
    jac[1] -= c[0] * ratio * x * z;
    jac[4] -= c[0] * ratio * x * z;
    jac[5] -= pull + c[0] * ratio * z * z;
}
TERM_POTENTIAL(spring)
{
    double stretch = fixed_hypot(y[0], y[1]) - c[1];
    return 0.5 * c[2] * stretch * stretch;
}

TERM_BIND(gravity)
{
    c[0] = param[P_g];
    c[1] = param[P_m];
    return c[0] != 0;
}
TERM_ADD(gravity)
{
    a[1] -= c[0];
}
TERM_POTENTIAL(gravity)
{
    return c[1] * c[0] * y[1];
}

TERM_BIND(damping)
{
    c[0] = param[P_gamma];
    c[1] = param[P_m];
    oscillator->damping += c[0];
    return c[0] != 0;
}
TERM_ADD(damping)
{
    a[0] -= c[0] * y[2];
    a[1] -= c[0] * y[3];
}
TERM_JACOBIAN(damping)
{
    jac[2] -= c[0];
    jac[7] -= c[0];
}

static const struct term_row terms[] = {
    {.row = {"spring", "m/s^2", "spring from the pivot, F = -k (r - length)", "Hooke 1678", NULL},
     .flags = TERM_CONSERVATIVE,
     .equation = {"-k/m*(1-length/hypot(x,y))*x", "-k/m*(1-length/hypot(x,y))*y"},
     .bind = spring_bind,
     .add = spring_add,
     .jacobian = spring_jacobian,
     .potential = spring_potential},
    {.row = {"gravity", "m/s^2", "weight F = -m g", "Galilei 1638", NULL},
     .flags = TERM_LINEAR | TERM_CONSERVATIVE,
     .equation = {NULL, "-g"},
     .bind = gravity_bind,
     .add = gravity_add,
     .potential = gravity_potential},
    {.row = {"damping", "m/s^2", "linear damping F = -m gamma v", "Stokes 1851", NULL},
     .flags = TERM_LINEAR | TERM_VELOCITY,
     .equation = {"-gamma*x'", "-gamma*y'"},
     .bind = damping_bind,
     .add = damping_add,
     .jacobian = damping_jacobian},
};
static const struct catalog term_table = CATALOG("force term", terms);

/* Returns true if k/m is a usable number; otherwise sets an error. */
static bool coherent(const double *param, struct error *error)
{
    if (isfinite(param[P_k] / param[P_m]) && param[P_m] >= DBL_MIN)
        return true;
    return error_set(error, ERROR_COMMAND, "k/m overflows: k = %g N/m, m = %g kg", param[P_k],
                     param[P_m]);
}

/* Sets the start and the natural sizes. The speed is that of a fall over the reach, or of a
 * vibration as wide as it starts. */
static void elastic_pendulum_scales(const double *param, struct system *system)
{
    double r = param[P_length] + param[P_stretch0], s = fixed_sin(param[P_theta0]),
           c = fixed_cos(param[P_theta0]);
    double speed = r * param[P_rate0], reach = fmax(fabs(r), param[P_length]);
    double stiffness = param[P_k] / param[P_m];
    /* extension of the spring by the weight */
    double sag = stiffness > 0 ? fabs(param[P_g]) / stiffness : 0;
    reach = scale_clamp(fmax(reach, sag));
    system->t0 = param[P_t0];
    system->mass = param[P_m];
    system->start[0] = r * s;
    system->start[1] = -r * c;
    system->start[2] = speed * c;
    system->start[3] = speed * s;
    double vibration = sqrt(stiffness) * fmax(fabs(param[P_stretch0]), sag);
    speed = scale_clamp(fmax(fabs(speed), fmax(sqrt(fabs(param[P_g]) * reach), vibration)));
    system->scale[0] = system->scale[1] = reach;
    system->scale[2] = system->scale[3] = speed;
}

static const struct variable variables[] = {{"x", QUANTITY_LENGTH},
                                            {"y", QUANTITY_LENGTH},
                                            {"vx", QUANTITY_VELOCITY},
                                            {"vy", QUANTITY_VELOCITY}};

const struct model elastic_pendulum_model = {
    .row = {"elastic-pendulum", "", "a bob that swings on a spring: two time scales",
            "Vitt, Gorelik 1933", NULL},
    .order = 2,
    .n = 4,
    .variable = variables,
    .params = &param_table,
    .terms = &term_table,
    .derived = &no_derived,
    .coherent = coherent,
    .begin = elastic_pendulum_scales,
};
