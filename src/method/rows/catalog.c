/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The table of methods, made of the .def files of this folder and the texts of methods.txt, and
 * functions that apply to all methods. */
#include "method/rows/rows.h"

#include <hooke/base/catalog.h>
#include <hooke/base/numeric.h>
#include <hooke/scene/typed.h>

#include <assert.h>

#define METHOD_TEXT(id, known_as, says, explains, lines, from)                                     \
    static const char name_##id[] = known_as, brief_##id[] = says, formula_##id[] = lines,         \
                      source_##id[] = from;
#include "texts/method/rows/methods.def"
#undef METHOD_TEXT

/* clang-format off */
#define TEXTS_OF(id) \
    .row.name = name_##id, .row.unit = "", .row.brief = brief_##id, .row.citation = source_##id, \
    .formula = formula_##id
static const struct method methods[] = {
#define RUNGE_KUTTA(id, ...) \
    {TEXTS_OF(id), .step = rk_step, .work = rk_work, .index = AT(RK), __VA_ARGS__},
#include "method/rows/rk.def"
#define SPLITTING(id, ...) \
    {TEXTS_OF(id), .step = split_step, .work = split_work, .index = AT(SPLIT), __VA_ARGS__},
#include "method/rows/split.def"
#define NYSTROM(id, ...) \
    {TEXTS_OF(id), .step = nystrom_step, .work = nystrom_work, __VA_ARGS__},
#include "method/rows/nystrom.def"
#define IMPLICIT_RUNGE_KUTTA(id, ...) \
    {TEXTS_OF(id), .step = implicit_step, .work = implicit_work, .index = AT(IRK), __VA_ARGS__},
#include "method/rows/irk.def"
#define ROSENBROCK(id, ...) \
    {TEXTS_OF(id), .step = rosenbrock_step, .work = rosenbrock_work, .index = AT(ROSENBROCK), \
     __VA_ARGS__},
#include "method/rows/rosenbrock.def"
#define MULTISTEP(id, ...) \
    {TEXTS_OF(id), .step = multistep_step, .work = multistep_work, .growth = multistep_growth, \
     __VA_ARGS__},
#include "method/rows/multistep.def"
#define ALGORITHM(id, ...) {TEXTS_OF(id), .step = id##_step, __VA_ARGS__},
#include "method/rows/algorithms.def"
#ifdef HOOKE_SUNDIALS
#define YARDSTICK(id, ...) \
    {TEXTS_OF(id), .step = cvode_step, .work = state_work, .dense = cvode_dense, \
     .begin = cvode_begin, .end = cvode_end, .adapt = cvode_adapt, __VA_ARGS__},
#include "method/rows/cvode.def"
#endif
};

#ifdef HOOKE_SUNDIALS
/* Number of methods that this build lacks. */
enum { ABSENT = 0 };
#else
static const struct row absent[] = {
#define YARDSTICK(id, ...) \
    {name_##id, "", \
     "this program was built without SUNDIALS 6; install libsundials-dev and rebuild it", \
     "", NULL},
#include "method/rows/cvode.def"
};
enum { ABSENT = COUNT_OF(absent) };
#endif

#define METHOD_TEXT(...) +1
_Static_assert(COUNT_OF(methods) + ABSENT == 0
#include "texts/method/rows/methods.def"
    , "methods.txt has a text without a row");
/* clang-format on */

const struct catalog method_catalog = {
    .kind = "method",
    .rows = methods,
    .count = COUNT_OF(methods),
    .stride = sizeof methods[0],
#ifndef HOOKE_SUNDIALS
    .absent = absent,
    .absences = COUNT_OF(absent),
#endif
};

const struct method *method_by_name(struct text name)
{
    return (const struct method *)(const void *)catalog_find(&method_catalog, name);
}

const struct method *method_at(size_t i)
{
    return (const struct method *)(const void *)catalog_row(&method_catalog, i);
}

const struct method *method_from(const struct row *row)
{
    return (const struct method *)(const void *)row;
}

const struct method *method_find(const char *name)
{
    return method_by_name(text_of(name));
}

static const struct row drags[] = {
    {"exact", "", "drag alone is solved exactly: no limit on the step, no loss of order", "", NULL},
    {"implicit", "", "the step uses the drag at its new velocity, solved in closed form", "", NULL},
    {"explicit", "",
     "the step uses the drag at its old velocity: first order, smaller stable steps", "", NULL},
};

const struct catalog drag_catalog = CATALOG("drag variant", drags);

/* Returns false with the error set if the method cannot take steps of h: external ones, which have
 * no fixed steps, and unstable splittings. */
bool method_fits(const struct method *method, const struct system *system, enum drag drag, double h,
                 struct error *error)
{
    if (method->flags & METHOD_EXTERNAL) {
        error_set(error, ERROR_COMMAND,
                  "%s chooses its steps itself and cannot take steps of a given size",
                  method->row.name);
        return error_hint(error, "give tol instead of dt");
    }
    return !method->splitting || split_fits(method, system, drag, h, error);
}

size_t state_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)n;
}

size_t method_work_size(const struct method *method, int n)
{
    return method->work(method, n);
}

bool method_begin(const struct method *method, struct step *step)
{
    step->library = method->begin ? method->begin(method, step) : NULL;
    return step->library || !method->begin;
}

void method_end(const struct method *method, struct step *step)
{
    if (method->end)
        method->end(step->library);
    step->library = NULL;
}

/* Checks that the system offers what the method needs: second order, an exact solution, forces
 * without velocity, a potential, a splitting. *drag is in and out: the wanted drag variant, or
 * DRAG_DEFAULT, which becomes the method's own default. Returns false with the error set if a need
 * is not met or the method lacks the variant. */
static bool check_needs(const struct method *method, const struct system *system, enum drag *drag,
                        struct error *error)
{
    const char *name = method->row.name;
    if (method->flags & METHOD_SECOND_ORDER && system->order != 2) {
        error_set(
            error, ERROR_COMMAND,
            "%s needs equations of motion y'' = a(t, y, y'), but this scene is of first order",
            name);
        return error_hint(error, "use rk4 or dopri5");
    }
    if (method->flags & METHOD_EXACT && !system_has_exact(system)) {
        error_set(error, ERROR_COMMAND,
                  "no exact solution is known for this scene, so '%s' cannot step it", name);
        return error_hint(error, "the scene must be linear, with constant coefficients; use dopri5 "
                                 "with a small tol instead");
    }
    if (method->flags & METHOD_NO_VELOCITY && system->velocity) {
        error_set(error, ERROR_COMMAND,
                  "%s needs y'' = a(t, y), but a force here depends on the velocity", name);
        return error_hint(error, "with damping or drag use verlet, rk4 or dopri5");
    }
    if (method->flags & METHOD_POTENTIAL && !system_has_potential(system)) {
        error_set(error, ERROR_COMMAND, "%s needs forces with a potential (drag is allowed)", name);
        return error_hint(error, "use implicit-midpoint or gauss4");
    }
    enum drag wanted = *drag == DRAG_DEFAULT ? method->drag : *drag;
    if (wanted != DRAG_DEFAULT && !(method->drags & 1u << wanted)) {
        const char *variant = drags[wanted - 1].name;
        if (!method->drags)
            return error_set(error, ERROR_COMMAND,
                             "%s has no drag variants: it treats drag like any other force", name);
        error_set(error, ERROR_COMMAND,
                  "%s has no drag=%s, because that would not have its order %d", name, variant,
                  method->order);
        return error_hint(error, "use %s drag=%s, or verlet drag=%s", name,
                          drags[method->drag - 1].name, variant);
    }
    if (method->splitting && !split_applies(method, system, wanted, error))
        return false;
    *drag = wanted;
    return true;
}

/* Returns true if the method can step the system, with the drag variant in *drag. Methods that meet
 * switches are tested with the frozen system that they step. */
bool method_applies(const struct method *method, const struct system *system, enum drag *drag,
                    struct error *error)
{
    if (!method_meets_switches(method, system))
        return check_needs(method, system, drag, error);
    struct system frozen; /* such methods step the system on its branches */
    double branch[LIMIT_SWITCHES];
    system_branches(system, system->t0, system->start, branch);
    system_freeze(system, branch, &frozen);
    return check_needs(method, &frozen, drag, error);
}

enum step_status method_step(const struct method *method, struct step *step)
{
    return step_take(method, step);
}

/* Returns the degree of the method's dense output, which is 3 for the cubic Hermite polynomial. */
int method_dense_degree(const struct method *method)
{
    if (!method->dense)
        return 3;
    if (method->tableau)
        return 3 + method->tableau->bends;
    if (method->implicit)
        return method->implicit->stages;
    return method->rosenbrock ? method->rosenbrock->degree + 1 : DENSE_DEGREE;
}

/* Computes the state at t + theta h after a step, by the method's dense output or else the cubic
 * Hermite polynomial. */
void method_dense(const struct method *method, const struct step *step, const double *y_begin,
                  double theta, double *y)
{
    if (method->dense) {
        method->dense(method, step, theta, y);
        return;
    }
    const struct system *system = step->system;
    double f0[LIMIT_VARIABLES], f1[LIMIT_VARIABLES], h = step->h;
    system_derivative(system, step->t - h, y_begin, f0);
    system_derivative(system, step->t, step->y, f1);
    for (int i = 0; i < system->n; i++)
        y[i] = hermite(theta, h, y_begin[i], f0[i], step->y[i], f1[i]);
}

/* Computes the dense output of variable i as a polynomial in theta. */
void method_polynomial(const struct method *method, const struct step *step, int i,
                       struct dense_polynomial *polynomial)
{
    assert(method->dense && (method->tableau || method->rosenbrock));
    if (method->tableau)
        rk_polynomial(method, step, i, polynomial);
    else
        rosenbrock_polynomial(method, step, i, polynomial);
}
