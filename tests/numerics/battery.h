/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Oscillators and kinked systems as typed scenes, with their solutions: closed forms, or (exact
 * NULL) what two methods of different kinds agree to.
 */
#pragma once

#include "long_form.h"
#include "unit/run/fixture.h"
#include "unit/scene/typing.h"

#include <float.h>
#include <stdlib.h>

/* A scene of lines "var x = 1;x'' = -x". */
static inline struct scene typed_scene(struct typed_models *models, const char *lines)
{
    struct scene scene;
    struct text rest = text_of(lines), line;
    struct error error = {0};
    scene_init(&scene, NULL);
    while (text_split(&rest, ';', &line)) {
        const struct typed_line typed = typing_line(text_trim(line));
        const struct model *model = typed_add(models, scene.model, &typed, &error);
        if (!model)
            fail_msg("%.*s: %s (%s)", (int)line.len, line.data, error.text, error.hint);
        scene_remodel(&scene, model);
    }
    return scene;
}

/* The run at t, however it stopped; most: steps, < 0: any number. */
static inline struct run *reach_within(const struct scene *scene, const char *method, double tol,
                                       double first, double t, int64_t max)
{
    const struct run_settings settings = {.dt = first, .tol = tol};
    struct run *run = start(scene, method, settings, t);
    const struct run_target target = {.t = t, .steps = max};
    assert_false(run_advance(run, &target, 0, NULL));
    return run;
}

static inline struct run *reach(const struct scene *scene, const char *method, double tol,
                                double first, double t)
{
    return reach_within(scene, method, tol, first, t, -1);
}

/* ---- closed forms ---- */

/* Closed forms in long double, of arguments that are double: clang warns of each. */
#pragma GCC diagnostic ignored "-Wdouble-promotion"

/*
 * sn, cn, dn at u for the modulus k and its complement, by the arithmetic-geometric mean
 * (Abramowitz, Stegun 1964, 16.4), in extended precision.
 */
struct jacobi {
    long double sn, cn, dn;
};

static inline struct jacobi jacobi_at(long double u, long double k, long double complement)
{
    enum { LEVELS = 12 };
    long double a[LEVELS + 1], c[LEVELS + 1], b = complement;
    a[0] = 1;
    c[0] = k;
    for (int i = 0; i < LEVELS; i++) {
        a[i + 1] = (a[i] + b) / 2;
        c[i + 1] = (a[i] - b) / 2;
        b = sqrtl(a[i] * b);
    }
    long double phi = ldexpl(a[LEVELS] * u, LEVELS);
    for (int i = LEVELS; i > 0; i--)
        phi = (phi + asinl(c[i] / a[i] * sinl(phi))) / 2;
    const long double sn = sinl(phi);
    return (struct jacobi){sn, cosl(phi), sqrtl(1 - k * k * sn * sn)};
}

/* theta'' = -sin(theta) from rest: sin(theta/2) = k cd(t), k = sin(theta0/2). */
static inline double pendulum_angle(double theta0, double t)
{
    const long double k = sinl((long double)theta0 / 2);
    const struct jacobi at = jacobi_at(t, k, cosl((long double)theta0 / 2));
    return (double)(2 * asinl(k * at.cn / at.dn));
}

/* x'' = -a x - b x^3 from rest at A: A cn over the middle, A cd where the spring softens, A dn in
 * one of two wells. */
static inline double duffing_place(double a, double b, double A, double t)
{
    const long double square = (long double)A * A;
    if (b < 0) {
        const long double w2 = a + b * square / 2, m = -b * square / (2 * w2);
        const struct jacobi at = jacobi_at(sqrtl(w2) * t, sqrtl(m), sqrtl(1 - m));
        return (double)(A * at.cn / at.dn);
    }
    if (a + b * square / 2 < 0) {
        const long double w2 = b * square / 2, m = 2 + a / w2;
        return (double)(A * jacobi_at(sqrtl(w2) * t, sqrtl(m), sqrtl(1 - m)).dn);
    }
    const long double w2 = a + b * square, m = b * square / (2 * w2);
    return (double)(A * jacobi_at(sqrtl(w2) * t, sqrtl(m), sqrtl(1 - m)).cn);
}

/* Kepler's equation M = E - e sin E by bisection: [-pi, pi] holds it. From the pericentre, a = GM
 * = 1. */
static inline void kepler_place(double e, double t, double *x)
{
    const long double pi = acosl(-1), M = remainderl(t, 2 * pi);
    long double low = -pi, high = pi;
    for (int i = 0; i < 80; i++) {
        const long double middle = (low + high) / 2;
        if (middle - e * sinl(middle) < M)
            low = middle;
        else
            high = middle;
    }
    x[0] = (double)(cosl(low) - e);
    x[1] = (double)(sqrtl(1 - (long double)e * e) * sinl(low));
}

/* Of N between fixed ends the one at `at`, from (1, 0, …, 0): by frequencies (decays false) or
 * rates, in units of unit.
 */
static inline double chain_place(int N, int at, bool decays, double unit, double t)
{
    const long double pi = acosl(-1);
    long double sum = 0;
    for (int k = 1; k <= N; k++) {
        const long double w = 2 * sinl(k * pi / (2 * (N + 1)));
        sum += 2.0L / (N + 1) * sinl(k * pi / (N + 1)) * sinl(k * (at + 1) * pi / (N + 1)) *
               (decays ? expl(-w * w * unit * t) : cosl(w * sqrtl(unit) * t));
    }
    return (double)sum;
}

/* ---- oscillators ---- */

enum { CHAIN = 8, HEAT = 32 };

/* x [n]: the first variables, the others NAN */
static inline void exact_pendulum(double theta0, double t, double *x)
{
    *x = pendulum_angle(theta0, t);
}
static inline void exact_hard(double A, double t, double *x)
{
    *x = duffing_place(1, 1, A, t);
}
static inline void exact_soft(double A, double t, double *x)
{
    *x = duffing_place(1, -1, A, t);
}
static inline void exact_wells(double A, double t, double *x)
{
    *x = duffing_place(-1, 1, A, t);
}

static inline void exact_chain(double unit, double t, double *x)
{
    for (int i = 0; i < CHAIN; i++)
        x[i] = chain_place(CHAIN, i, false, unit, t);
}

static inline void exact_heat(double unit, double t, double *x)
{
    for (int i = 0; i < HEAT; i++)
        x[i] = chain_place(HEAT, i, true, unit, t);
}

struct swinging {
    const char *name, *lines; /* $: the parameter */
    double parameter, t;
    void (*exact)(double parameter, double t, double *x);
};

#define KEPLER                                                                                     \
    "var x = %.17g;var y = 0;var y' = %.17g;x'' = -x/(x^2+y^2)^1.5;y'' = -y/(x^2+y^2)^1.5"
#define ELASTIC                                                                                    \
    "var x = 1.2;var y = 0;param k = $;x'' = -k*x*(1-1/sqrt(x^2+y^2));y'' = "                      \
    "-k*y*(1-1/sqrt(x^2+y^2)) - 9.81"
#define VAN_DER_POL "var x = 2;param mu = $;x'' = mu*(1-x^2)*x' - x"

static const struct swinging oscillators[] = {
    {"pendulum", "var x = $;x'' = -sin(x)", 0.2, 50, exact_pendulum},
    {"pendulum", "var x = $;x'' = -sin(x)", 1.5, 50, exact_pendulum},
    {"pendulum", "var x = $;x'' = -sin(x)", 2.9, 50, exact_pendulum},
    {"pendulum", "var x = $;x'' = -sin(x)", 3.1, 50, exact_pendulum},
    {"hard Duffing", "var x = $;x'' = -x - x^3", 3, 20, exact_hard},
    {"soft Duffing", "var x = $;x'' = -x + x^3", 0.9, 50, exact_soft},
    {"one of two wells", "var x = $;x'' = x - x^3", 1.2, 40, exact_wells},
    {"both of two wells", "var x = $;x'' = x - x^3", 1.5, 40, exact_wells},
    {"van der Pol", VAN_DER_POL, 0.1, 40, NULL},
    {"van der Pol", VAN_DER_POL, 5, 40, NULL},
    {"van der Pol", VAN_DER_POL, 100, 200, NULL},
    {"van der Pol", VAN_DER_POL, 1e4, 1e4, NULL},
    {"Kepler", KEPLER, 0, 20, kepler_place},
    {"Kepler", KEPLER, 0.6, 20, kepler_place},
    {"Kepler", KEPLER, 0.9, 20, kepler_place},
    {"Kepler", KEPLER, 0.99, 20, kepler_place},
    {"elastic pendulum", ELASTIC, 1e2, 10, NULL},
    {"elastic pendulum", ELASTIC, 1e4, 3, NULL},
    {"elastic pendulum", ELASTIC, 1e6, 0.5, NULL},
    {"Toda", "var x = $;x'' = 1 - exp(x)", 3, 40, NULL},
    {"Lotka-Volterra", "var x = 1;var y = 1;param b = $;x' = x*(1.5 - b*y);y' = y*(x - 3)", 1, 20,
     NULL},
    {"chain", NULL, 1, 40, exact_chain},
    {"heat", NULL, 1000, 0.1, exact_heat},
};

/* As commands. */
static inline void oscillator_lines(const struct swinging *o, char *lines, size_t size)
{
    const bool heat = o->exact == exact_heat;
    const int n = heat ? HEAT : CHAIN;
    size_t used = 0;
    if (o->exact == kepler_place)
        snprintf(lines, size, KEPLER, 1 - o->parameter,
                 sqrt((1 + o->parameter) / (1 - o->parameter)));
    else if (o->lines) {
        const int at = (int)strcspn(o->lines, "$");
        snprintf(lines, size, "%.*s%.17g%s", at, o->lines, o->parameter, o->lines + at + 1);
    }
    if (o->lines)
        return;
    for (int i = 1; i <= n; i++)
        used += (size_t)snprintf(lines + used, size - used, "var y%d = %d;", i, i == 1);
    for (int i = 1; i <= n; i++) {
        used += (size_t)snprintf(lines + used, size - used, "%sy%d'%s = %.17g*(-2*y%d",
                                 i > 1 ? ";" : "", i, heat ? "" : "'", o->parameter, i);
        if (i > 1)
            used += (size_t)snprintf(lines + used, size - used, " + y%d", i - 1);
        if (i < n)
            used += (size_t)snprintf(lines + used, size - used, " + y%d", i + 1);
        used += (size_t)snprintf(lines + used, size - used, ")");
    }
}

/* ---- closed forms of switched systems ---- */

/* x'' = -x for x > 0, -100 x below, from rest at 1: half periods of pi and pi/10. */
static inline double two_springs(double t)
{
    const double u = fmod(t + M_PI / 2, 1.1 * M_PI);
    return u < M_PI ? sin(u) : -sin(10 * (u - M_PI)) / 10;
}

/* x'' = -x - sign(x')/2 from rest at 10, before it sticks: half periods about -+1/2 take 1 off the
 * amplitude. */
static inline double dry(double t)
{
    const double half = floor(t / M_PI), amplitude = 9.5 - half, sign = fmod(half, 2) == 0 ? 1 : -1;
    return sign * (0.5 + amplitude * cos(t - half * M_PI));
}

/* x'' = -sign(x) from rest at 1: parabolas, quarter period sqrt(2). */
static inline double wedge(double t)
{
    const double quarter = sqrt(2), u = fmod(t + quarter, 4 * quarter),
                 v = fmod(u, 2 * quarter) - quarter;
    return (u < 2 * quarter ? 1 : -1) * (1 - v * v / 2);
}

static inline double jump(double t)
{
    return t < 3.3 ? t : 3.3 - 2 * (t - 3.3);
}

static inline double rectified(double t)
{
    const double whole = floor(t);
    return (2 * whole + 1 - cos(M_PI * (t - whole))) / M_PI;
}
