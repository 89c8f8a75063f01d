/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Two bodies: r'' = -gm r/|r|^3, from the pericentre of an ellipse with semi-major axis 1. No
 * units.
 *
 * The exact solution goes by Kepler's equation in the universal variable s (ds = sqrt(gm) dt/r),
 * which is the same for ellipses, parabolas and hyperbolas (Battin 1987, 4.5 and 4.6): with alpha =
 * 2/r0 - v0^2/gm = 1/a and sigma = r0.v0/sqrt(gm),
 *
 *   sqrt(gm) (t - t0) = r0 U1 + sigma U2 + U3,  r = r0 U0 + sigma U1 + U2
 *
 * where U0 … U3 are cos, sin, … of sqrt(alpha) s over powers of sqrt(alpha), free of cancellation
 * for small alpha s^2.
 */
#include <hooke/base/catalog.h>
#include "scene/model/forces.h"

#define PARAMS(P)                                                                                  \
    P(e, "", NUMBER, 0.5, AT_LEAST(0), "eccentricity of the orbit, 0 (circle) to below 1")         \
    P(gm, "", NUMBER, 1, ABOVE(0), "strength of the attraction")                                   \
    P(t0, "s", TIME, 0, UNBOUNDED_BELOW, "time at the start")

PARAM_PLACES(PARAMS);
static const struct param_row params[] = {PARAMS(PARAM_ROW)};
static const struct catalog param_table = CATALOG("parameter", params);

TERM_BIND(attraction)
{
    c[0] = param[P_gm];
    return true;
}
TERM_JACOBIAN(attraction)
{
    double r = fixed_hypot(y[0], y[1]), pull = c[0] / (r * r * r), x = y[0] / r, z = y[1] / r;
    jac[0] -= pull * (1 - 3 * x * x);
    jac[1] += pull * 3 * x * z;
    jac[4] += pull * 3 * x * z;
    jac[5] -= pull * (1 - 3 * z * z);
}
TERM_POTENTIAL(attraction)
{
    return -c[0] / fixed_hypot(y[0], y[1]);
}

static const struct term_row terms[] = {
    {.row = {"attraction", "", "r'' = -gm r/|r|^3", "Newton 1687, Principia I", NULL},
     .flags = TERM_CONSERVATIVE,
     .equation = {"-gm*x/(x^2+y^2)^1.5", "-gm*y/(x^2+y^2)^1.5"},
     .ordered = {"-gm/(x^2+y^2)^1.5*x", "-gm/(x^2+y^2)^1.5*y"},
     .force = FORCE_attraction,
     .bind = attraction_bind,
     .add = attraction_add,
     .jacobian = attraction_jacobian,
     .potential = attraction_potential},
};
static const struct catalog term_table = CATALOG("force term", terms);

static double period(const struct scene *scene)
{
    return TWO_PI / sqrt(scene->value[P_gm]);
}

static double E0(const struct scene *scene)
{
    return scene_start_energy(scene);
}

#define DERIVED_ROWS(ROW)                                                                          \
    ROW(period, "s", TIME, "period of the orbit, 2 pi/sqrt(gm)", "Kepler 1619", NULL, NULL)        \
    ROW(E0, "", NUMBER, "energy, -gm/2", "", NULL, NULL)

DERIVED_ROWS(MEASURED)
static const struct derived_row derived[] = {DERIVED_ROWS(DERIVED_ROW)};
static const struct catalog derived_table = CATALOG("derived quantity", derived);

/* Returns true if the orbit is an ellipse; otherwise sets an error. */
static bool coherent(const double *param, struct error *error)
{
    if (param[P_e] < 1)
        return true;
    return error_set(error, ERROR_COMMAND, "e must be < 1 (got %g): the orbit is an ellipse",
                     param[P_e]);
}

/* Sets the start at the pericentre and the natural sizes of the orbit. */
static void kepler_scales(const double *param, struct system *system)
{
    double e = param[P_e], speed = sqrt(param[P_gm]);
    system->t0 = param[P_t0];
    system->mass = 1;
    system->start[0] = 1 - e;
    system->start[3] = sqrt(param[P_gm] * (1 + e) / (1 - e));
    for (int i = 0; i < 4; i++)
        system->scale[i] = i < 2 ? 1 : scale_clamp(speed);
}

typedef long double real; /* private to this file, as in exact.c */

/* Computes U0 … U3 at s; the last by its series where s - sin s would cancel. */
static void universal(real alpha, real s, real u[4])
{
    real x = alpha * s * s, root = sqrtl(fabsl(alpha)), angle = root * s, half,
         term = s * s * s / 6;
    if (fabsl(x) < 1) {
        real sum[2] = {0, 0}, next = s * s / 2;
        for (int k = 0; k < 16; k++) {
            sum[0] += next;
            sum[1] += term;
            next *= -x / ((2 * k + 3) * (2 * k + 4));
            term *= -x / ((2 * k + 4) * (2 * k + 5));
        }
        u[2] = sum[0];
        u[3] = sum[1];
        u[1] = s - alpha * u[3];
        u[0] = 1 - alpha * u[2];
        return;
    }
    if (alpha > 0) {
        half = sinl(angle / 2);
        u[0] = 1 - 2 * half * half;
        u[1] = 2 * half * cosl(angle / 2) / root;
    } else {
        half = sinhl(angle / 2);
        u[0] = coshl(angle);
        u[1] = sinhl(angle) / root;
    }
    u[2] = 2 * half * half / fabsl(alpha);
    u[3] = (s - u[1]) / alpha;
}

/* Sets *low and *high to an interval of s in which r0 U1 + sigma U2 + U3 = time has its root, and
 * returns an s in it to begin with. */
static real bracket(real alpha, real r0, real sigma, real time, real *low, real *high)
{
    real u[4];
    *low = *high = 0;
    if (alpha > 0) { /* E - e sin E differs from E by less than 1, at both ends */
        const real s = alpha * time, apart = 2 / sqrtl(alpha);
        *low = time > 0 && s < apart ? 0 : s - apart;
        *high = time < 0 && -s < apart ? 0 : s + apart;
        return s;
    }
    for (real reach = copysignl(1 / sqrtl(fabsl(alpha) + 1 / r0), time);; reach *= 2) {
        universal(alpha, reach, u);
        *(time > 0 ? high : low) = reach;
        if ((r0 * u[1] + sigma * u[2] + u[3] - time) * time >= 0 || !isfinite(u[3]))
            return *low + (*high - *low) / 2;
        *(time > 0 ? low : high) = reach;
    }
}

/* Computes U0 … U3 at the root s of r0 U1 + sigma U2 + U3 = time, which grows with s: Newton's
 * method, limited to the interval that contains the root. */
static void kepler_equation(real alpha, real r0, real sigma, real time, real u[4])
{
    /* relative error at which the next step has twice as many digits */
    static const real close = 1e-12L;
    real low, high, s = bracket(alpha, r0, sigma, time, &low, &high);
    bool found = false;
    for (int i = 0; i < 200; i++) {
        universal(alpha, s, u);
        if (found)
            break;
        real miss = r0 * u[1] + sigma * u[2] + u[3] - time, slope = r0 * u[0] + sigma * u[1] + u[2];
        *(miss > 0 ? &high : &low) = s;
        real next = s - miss / slope;
        found = fabsl(next - s) <= close * fabsl(s);
        if (!found && !(next > low && next < high))
            next = low + (high - low) / 2;
        s = next;
    }
}

/* Sets y [4] to the exact state at time t of the motion that starts in `start` at t0, also on
 * parabolas and hyperbolas. floor [4], unless NULL, receives the change by one ulp of the start,
 * below which differences mean nothing. */
static void exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor)
{
    const real gm = (real)system->term[0].c[0], x0 = (real)start[0], y0 = (real)start[1],
               root = sqrtl(gm), vx = (real)start[2] / root, vy = (real)start[3] / root,
               r0 = hypotl(x0, y0), v2 = vx * vx + vy * vy, alpha = 2 / r0 - v2,
               sigma = x0 * vx + y0 * vy, elapsed = (real)t - (real)t0;
    real time = root * elapsed, u[4];
    if (alpha > 0) { /* whole turns change nothing */
        const real turn = 2 * acosl(-1) / (alpha * sqrtl(alpha));
        time = remainderl(time, turn);
    }
    if (time == 0) {
        u[0] = 1;
        u[1] = u[2] = u[3] = 0;
    } else {
        kepler_equation(alpha, r0, sigma, time, u);
    }
    /* Lagrange's f and g, and their rates (Battin 1987, eq. 4.84). */
    real r = r0 * u[0] + sigma * u[1] + u[2], f = 1 - u[2] / r0, g = r0 * u[1] + sigma * u[2],
         f_rate = -u[1] / (r * r0), g_rate = 1 - u[2] / r;
    y[0] = (double)(f * x0 + g * vx);
    y[1] = (double)(f * y0 + g * vy);
    y[2] = (double)(root * (f_rate * x0 + g_rate * vx));
    y[3] = (double)(root * (f_rate * y0 + g_rate * vy));
    if (!floor)
        return;
    /*
     * An ulp in the start changes alpha by 2 eps (1/r0 + v0^2), alpha/a of it the period by 3/2 as
     * much, and so shifts the time along the orbit; it turns and stretches the orbit by a few ulp,
     * too.
     */
    const real eps = (real)DBL_EPSILON, stretch = alpha > 0 ? 3 * (1 / r0 + v2) / alpha : 4;
    const real shift = eps * stretch * fabsl(elapsed), turned = eps * (alpha > 0 ? stretch : 4);
    const real pull = gm / (r * r), speed = hypotl((real)y[2], (real)y[3]);
    for (int i = 0; i < 2; i++) {
        floor[i] = (double)(turned * r + shift * fabsl((real)y[2 + i]));
        floor[2 + i] = (double)(turned * speed + shift * pull * fabsl((real)y[i]) / r);
    }
}

static const struct variable variables[] = {{"x", QUANTITY_NUMBER},
                                            {"y", QUANTITY_NUMBER},
                                            {"vx", QUANTITY_NUMBER},
                                            {"vy", QUANTITY_NUMBER}};

const struct model kepler_model = {
    .row = {"kepler", "", "a planet around its sun", "Kepler 1609", NULL},
    .order = 2,
    .n = 4,
    .variable = variables,
    .params = &param_table,
    .terms = &term_table,
    .derived = &derived_table,
    .coherent = coherent,
    .begin = kepler_scales,
    .exact = exact,
};
