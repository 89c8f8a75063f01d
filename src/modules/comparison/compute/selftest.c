/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checks of `selftest`: the order, area preservation, reversibility and stability limit that a
 * method's row claims, measured by running it for a few hundredths of a second. */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include "modules/comparison/compute/verify.h"

#include <stdlib.h>

#define ORDER_COST 250000 /* largest number of evaluations of one solve */
#define ORDER_NEAR 0.15   /* largest distance from the claimed order */
/* Orders above this leave few steps between the largest and rounding, so that later terms still
 * contribute. */
#define HIGH_ORDER 8
#define AREA_MAX 1e-10   /* largest deviation of the area factor from 1 */
#define RETURN_MAX 1e-9  /* largest distance from the start after running forth and back */
#define RETURN_STEPS 200 /* number of steps forth */

static const struct row checks[] = {
    [SELFTEST_ORDER] = {"order", "",
                        "the slope of the error on a Kepler orbit is the claimed order", "", NULL},
    [SELFTEST_AREA] = {"area", "", "symplectic: a step preserves areas (determinant 1)", "", NULL},
    [SELFTEST_REVERSAL] = {"reversal", "",
                           "symmetric: a step of h followed by one of -h returns to the start", "",
                           NULL},
    [SELFTEST_STABILITY] =
        {"stability", "",
         "runs below the stability limit stay bounded, runs above it grow as predicted", "", NULL},
};

const struct catalog selftest_catalog = CATALOG("check", checks);

/* A parameter of a preset that a check sets, in SI units. */
struct check_setting {
    const char *param;
    double value;
};

/* Binds a preset with some parameters set. Returns false if a parameter cannot have its value. */
static bool check_system_bind(const char *preset, const struct check_setting *set, int count,
                              struct system *system)
{
    struct scene scene;
    struct error ignored;
    scene_init(&scene, preset_by_name(text_of(preset)));
    for (int i = 0; i < count; i++)
        if (!scene_set(&scene, scene_param(&scene, set[i].param),
                       (struct measured){set[i].value, 0}, &ignored))
            return false;
    return scene_bind(&scene, system, &ignored);
}

/* ---- order: most of an orbit of eccentricity 0.1, where every order condition counts and the
 * answer is known ---- */

/* Measures the order on a Kepler orbit and fills in that check; methods without an order or that do
 * not apply are skipped. Returns false if out of memory or cancelled. */
static bool check_order(const struct method *method, const struct cancel *cancel,
                        struct selftest_row *row)
{
    const struct check_setting set[] = {{"e", 0.1}};
    struct system system;
    struct order order = {.choice = {method, DRAG_DEFAULT}, .claimed = method->order};
    struct error error;
    double state[STUDY_TIMES * 4];
    if (method->order == 0 || !check_system_bind("kepler", set, 1, &system) ||
        !method_applies(method, &system, &order.choice.drag, &error))
        return true;
    struct sweep_target target = {.system = &system,
                                  .span = 5,
                                  .state = state,
                                  .dt = {NAN, NAN},
                                  .max = ORDER_COST,
                                  .cancel = cancel};
    for (int k = SWEEP_STRIDE; k < STUDY_TIMES; k += SWEEP_STRIDE)
        system_exact(&system, system.t0, system.start,
                     system.t0 + target.span * k / (STUDY_TIMES - 1), state + k * system.n, NULL);
    for (int i = 0; i < system.n; i++)
        target.size[i] = 1;
    order.floor = 4e-16;
    if (!order_sweep(&target, &order, &error))
        return false;
    row->check[SELFTEST_ORDER].applies = true;
    row->check[SELFTEST_ORDER].value = order.slope;
    row->check[SELFTEST_ORDER].wanted = method->order;
    row->check[SELFTEST_ORDER].passed =
        order.slope > method->order - ORDER_NEAR &&
        order.slope < method->order + (method->order > HIGH_ORDER ? 2 : ORDER_NEAR);
    return true;
}

/* ---- geometry, on a pendulum (or, for what steps only closed forms, on a spring) ---- */

/* Binds the pendulum, or the spring for methods that only apply to it, with the drag variant of the
 * method. Returns false if the method applies to neither. */
static bool bind_swing(const struct method *method, struct system *system, enum drag *drag)
{
    const struct check_setting unit[] = {{"m", 1}, {"k", 1}, {"y0", 1}};
    struct error ignored;
    *drag = DRAG_DEFAULT;
    if (check_system_bind("pendulum", NULL, 0, system) &&
        method_applies(method, system, drag, &ignored))
        return true;
    *drag = DRAG_DEFAULT;
    return check_system_bind("spring", unit, 3, system) &&
           method_applies(method, system, drag, &ignored);
}

/* Makes `steps` steps of h [s] from y, which is replaced. `work` is the method's work memory.
 * Returns false if a step fails. */
static bool selftest_steps(const struct method *method, const struct system *system, enum drag drag,
                           double h, int steps, double *work, double *y)
{
    struct step step = {.system = system, .drag = drag, .h = h, .y = y, .work = work};
    for (int i = 0; i < steps; i++)
        if (method_step(method, &step) != STEP_OK)
            return false;
    return true;
}

/* Returns the determinant of the Jacobian of one step, computed by central differences of sixth
 * order, or NAN if a step fails. */
static double area_factor(const struct method *method, const struct system *system, enum drag drag,
                          double h, double *work)
{
    static const double weight[] = {45. / 60, -9. / 60, 1. / 60};
    const double delta = 0.01;
    double jac[4] = {0};
    for (int column = 0; column < 2; column++)
        for (int k = -3; k <= 3; k++) {
            double y[2] = {system->start[0], 0.3 * system->scale[1]};
            if (k == 0)
                continue;
            y[column] += k * delta * system->scale[column];
            if (!selftest_steps(method, system, drag, h, 1, work, y))
                return NAN;
            for (int r = 0; r < 2; r++)
                jac[2 * r + column] += copysign(weight[abs(k) - 1], weight[abs(k) - 1] * k) * y[r] /
                                       (delta * system->scale[column]);
        }
    return jac[0] * jac[3] - jac[1] * jac[2];
}

/* Checks that a symplectic method preserves area and that a symmetric one returns to its start.
 * Returns false if out of memory. */
static bool check_geometry(const struct method *method, struct selftest_row *row)
{
    struct system system;
    enum drag drag;
    if (!(method->flags & (METHOD_SYMPLECTIC | METHOD_SYMMETRIC)) ||
        !bind_swing(method, &system, &drag))
        return true;
    double *work = malloc((method_work_size(method, system.n) + 1) * sizeof *work);
    if (!work)
        return false;
    const double h = 0.3 * system.scale[0] / system.scale[1];
    if (method->flags & METHOD_SYMPLECTIC) {
        row->check[SELFTEST_AREA].applies = true;
        row->check[SELFTEST_AREA].value = area_factor(method, &system, drag, h, work) - 1;
        row->check[SELFTEST_AREA].passed = fabs(row->check[SELFTEST_AREA].value) <= AREA_MAX;
    }
    if (method->flags & METHOD_SYMMETRIC) {
        double y[2] = {system.start[0], system.start[1]};
        const bool there = selftest_steps(method, &system, drag, h, RETURN_STEPS, work, y);
        const bool back = there && selftest_steps(method, &system, drag, -h, RETURN_STEPS, work, y);
        const double away = fmax(fabs(y[0] - system.start[0]) / system.scale[0],
                                 fabs(y[1] - system.start[1]) / system.scale[1]);
        row->check[SELFTEST_REVERSAL].applies = true;
        row->check[SELFTEST_REVERSAL].value = back ? away : NAN;
        row->check[SELFTEST_REVERSAL].passed = back && away <= RETURN_MAX;
    }
    free(work);
    return true;
}

/* ---- stability: undamped where there is a limit, else with some damping ---- */

/* Checks by running that steps below the stability limit do not grow and steps above it do; methods
 * without a limit are run at one long step. */
static void check_stability(const struct method *method, struct selftest_row *row)
{
    struct method_choice choice = {method, DRAG_DEFAULT};
    struct mode mode = {.omega = 1};
    struct stability_check lower, upper;
    double limit = method->flags & METHOD_A_STABLE ? HUGE_VAL : mode_limit(&choice, &mode);
    if (limit == 0) {
        mode.zeta = 0.1;
        limit = mode_limit(&choice, &mode);
    }
    if (isnan(mode_growth(&choice, &mode, 1)) || isnan(limit))
        return;
    row->check[SELFTEST_STABILITY].applies = true;
    if (isinf(limit) || limit == 0) { /* a step of 30 is far beyond any limit, and below none */
        mode_check(&choice, &mode, 30, &upper);
        row->check[SELFTEST_STABILITY].passed =
            upper.agrees && (upper.measured > 1 + 1e-4) == (limit == 0);
    } else {
        const double aside = mode_aside(&choice, &mode, limit);
        mode_check(&choice, &mode, limit * (1 - aside), &lower);
        mode_check(&choice, &mode, limit * (1 + aside), &upper);
        row->check[SELFTEST_STABILITY].passed =
            lower.agrees && upper.agrees && lower.measured < 1 + 1e-5 && upper.measured > 1;
    }
    row->check[SELFTEST_STABILITY].value = upper.measured;
    row->check[SELFTEST_STABILITY].wanted = upper.predicted;
}

/* Checks the claims of one method's row. */
bool selftest_method(const struct method *method, const struct cancel *cancel,
                     struct selftest_row *row)
{
    *row = (struct selftest_row){.method = method, .passed = true};
    for (int i = 0; i < SELFTEST_CHECKS; i++)
        row->check[i].value = row->check[i].wanted = NAN;
    if (!check_order(method, cancel, row) || !check_geometry(method, row) || cancelled(cancel))
        return false;
    check_stability(method, row);
    for (int i = 0; i < SELFTEST_CHECKS; i++)
        row->passed &= !row->check[i].applies || row->check[i].passed;
    return !cancelled(cancel);
}
