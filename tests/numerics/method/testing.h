/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the tests of methods share: systems to integrate, and stepping with a fixed h. */
#pragma once

#include <float.h>
#include <hooke/base/catalog.h>
#include <hooke/method.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct measured;

enum { WORK_CAPACITY = 8192 };

static inline const struct method *method_named(const char *name)
{
    const struct method *method = method_by_name(text_of(name));
    assert_non_null(method);
    return method;
}

/* Rows that take steps of a given size: yardsticks do not, and stand last. */
static inline size_t own_methods(void)
{
    size_t count = method_catalog.count;
    while (count > 0 && method_at(count - 1)->flags & METHOD_EXTERNAL)
        count--;
    return count;
}

struct setting {
    const char *param;
    double value;
};

/* The spring with some parameters set (up to the NULL). */
static inline struct system spring(const struct setting *settings)
{
    struct scene scene;
    struct system system;
    struct error error = {0};
    scene_init(&scene, NULL);
    for (; settings && settings->param; settings++)
        if (!scene_set(&scene, param_index(settings->param), (struct measured){settings->value, 0},
                       &error))
            fail_msg("%s", error.text);
    if (!scene_bind(&scene, &system, &error))
        fail_msg("%s", error.text);
    return system;
}

#define SPRING(...) spring((const struct setting[]){__VA_ARGS__, {NULL, 0}})

/* A system of one term that is not the oscillator: implicit methods iterate, splittings see no
 * known drag. */
static inline struct system other_system(const struct term_row *row, double c0)
{
    struct system system = {.n = 2, .order = 2, .terms = 1, .mass = 1, .scale = {1, 1}};
    system.term[0] = (struct bound_term){row, {c0}};
    system.linear = row->flags & TERM_LINEAR;
    system.velocity = row->flags & TERM_VELOCITY;
    system.conservative = row->flags & TERM_CONSERVATIVE;
    system.autonomous = !(row->flags & TERM_TIME);
    return system;
}

/* Duffing: q'' = -q - c q^3. */
static inline void duffing_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] -= y[0] + c[0] * y[0] * y[0] * y[0];
}
static inline void duffing_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t;
    jac[0] -= 1 + 3 * c[0] * y[0] * y[0];
}
static inline double duffing_potential(const double *c, const double *y)
{
    return y[0] * y[0] / 2 + c[0] * y[0] * y[0] * y[0] * y[0] / 4;
}
static const struct term_row duffing_row = {.row = {"duffing", "m/s^2", "", "", NULL},
                                            .flags = TERM_CONSERVATIVE,
                                            .add = duffing_add,
                                            .jacobian = duffing_jacobian,
                                            .potential = duffing_potential};

static inline struct system duffing(double c)
{
    return other_system(&duffing_row, c);
}

static inline struct step step_begin(const struct system *system, enum drag drag, double t,
                                     double h, double *y, double *work)
{
    return (struct step){.system = system, .drag = drag, .t = t, .h = h, .y = y, .work = work};
}

/* n steps of h from t; fails the test if the method does not apply. */
static inline enum step_status advance_as(const struct method *method, enum drag drag,
                                          const struct system *system, double t, double h, long n,
                                          double *y)
{
    static double work[WORK_CAPACITY];
    struct error error = {0};
    if (!method_applies(method, system, &drag, &error))
        fail_msg("%s: %s", method->row.name, error.text);
    assert_true(method_work_size(method, system->n) <= WORK_CAPACITY);
    struct step step = step_begin(system, drag, t, h, y, work);
    for (long i = 0; i < n; i++) {
        step.t = t + (double)i * h;
        enum step_status status = method_step(method, &step);
        if (status != STEP_OK)
            return status;
    }
    return STEP_OK;
}

static inline enum step_status advance(const struct method *method, const struct system *system,
                                       double h, long n, double *y)
{
    return advance_as(method, DRAG_DEFAULT, system, 0, h, n, y);
}

static inline bool applies(const struct method *method, const struct system *system, enum drag drag)
{
    struct error error = {0};
    return method_applies(method, system, &drag, &error);
}

/* The first of the systems that the method can step; the last one must do. */
static inline struct system first_fit(const struct method *method, const struct system *systems,
                                      size_t count)
{
    for (size_t i = 0; i + 1 < count; i++)
        if (applies(method, &systems[i], DRAG_DEFAULT))
            return systems[i];
    return systems[count - 1];
}

/* Largest difference in units of the system's own scale. */
static inline double distance(const struct system *system, const double *a, const double *b)
{
    double largest = 0;
    for (int i = 0; i < system->n; i++)
        largest = fmax(largest, fabs(a[i] - b[i]) / system->scale[i]);
    return largest;
}

static inline void assert_near(const char *what, double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance) && got != want)
        fail_msg("%s: got %.12g, want %.12g +- %.3g", what, got, want, tolerance);
}

static inline void assert_below(const char *what, double got, double bound)
{
    if (!(got <= bound))
        fail_msg("%s: got %.6g, want at most %.6g", what, got, bound);
}

static inline void assert_above(const char *what, double got, double bound)
{
    if (!(got >= bound))
        fail_msg("%s: got %.6g, want at least %.6g", what, got, bound);
}
