/* SPDX-License-Identifier: GPL-3.0-or-later */
/* order: fixed steps from coarse to fine, and the slope of the errors where it means something. */
#include "study/compare/verify.h"

#include <stdio.h>
#include <string.h>

#define TOP 0.1            /* errors above are not asymptotic */
#define ROUNDING 2e-14     /* errors below have rounding in them, compensated sums or not */
#define ROUNDING_FAR 1e-11 /* a reference that bad is in the way before rounding is */
#define ACCURACIES 30      /* so far above the accuracy of the reference a slope is to be trusted */
#define SMALL 1e-6         /* above it a slope near 0 is no rounding */
#define IDLE 0.3           /* the slope below which a smaller step gains nothing */
#define NOISE 10           /* times the error there: with less rounding bends the line */
#define WINDOW 4           /* points in the fit, one more where the steps are closer together */
#define LEAST 3
#define ALIKE 0.05   /* a guard band that narrow is that of one power */
#define ERRATIC 0.35 /* a guard band wider than that is no order at all */
#define COST_MAX 6e6 /* of one solve */
#define HIGH 6       /* from this order on the steps of the sweep are closer together */

static const struct row verdicts[] = {
    [ORDER_AGREES] = {"as claimed", "", "the slope is that of the claimed order", "", NULL},
    [ORDER_LOWER] = {"lower", "", "the error falls more slowly than claimed", "", NULL},
    [ORDER_HIGHER] = {"higher", "", "the error falls faster than claimed", "", NULL},
    [ORDER_ERRATIC] = {"erratic", "", "the slope changes from step to step: no order", "", NULL},
    [ORDER_NO_RANGE] = {"no range", "",
                        "no asymptotic part between the largest step that works and rounding", "",
                        NULL},
    [ORDER_EXACT] = {"exact", "", "no error but rounding", "", NULL},
};

const struct catalog order_verdict_catalog = CATALOG("verdict", verdicts);

/* ---- the sweep ---- */

static double state_distance(const struct sweep_target *target, const double *y)
{
    double max = 0;
    for (int i = 0; i < target->system->n; i++) {
        const double distance = fabs(y[i] - target->end[i]) / target->size[i];
        if (!(distance <= max))
            max = distance;
    }
    return max;
}

static bool solve_point(const struct sweep_target *target, const struct method_choice *by,
                        struct order_point *point, int64_t *cost)
{
    const struct run_settings settings = {.dt = point->dt, .drag = by->drag, .compensated = true};
    struct error ignored;
    struct solver solver;
    *cost = 0;
    point->error = point->slope = NAN;
    if (!method_fits(by->method, target->system, by->drag, point->dt, &ignored)) {
        point->refused = true;
        return true;
    }
    if (!solver_init(&solver, target->system, by->method, &settings, target->span))
        return false;
    solver.max = target->max;
    point->stop = solver_run(&solver, NULL, target->cancel);
    point->steps = solver.steps;
    point->turns = solver.step.cost.turns;
    *cost = solver_cost(&solver) + solver.steps;
    if (point->stop == STOP_END)
        point->error = state_distance(target, solver.y);
    solver_free(&solver);
    return true;
}

/* Whole numbers of steps, by factors of 2, of sqrt 2 where an error falls by 64 and more each time.
 */
static bool steps_at(const struct sweep_target *target, int order, int i, double *steps)
{
    const double each = order >= HIGH ? sqrt(2) : 2, span = fabs(target->span);
    const bool wanted = !isnan(target->dt[0]);
    const double first = wanted ? span / fmax(target->dt[0], target->dt[1]) : 4;
    const double last = wanted ? span / fmin(target->dt[0], target->dt[1]) : 4e9;
    *steps = nearbyint(first * pow(each, i));
    return *steps >= 1 && *steps <= last * (1 + 1e-9);
}

static double log_slope(const struct order_point *coarse, const struct order_point *fine)
{
    return log(coarse->error / fine->error) / log(coarse->dt / fine->dt);
}

/* Errors below this have rounding in them: far above the level from which on a smaller step gains
 * nothing. */
static double rounding_level(const struct order *order)
{
    double level = fmax(ROUNDING, ACCURACIES * order->floor);
    for (int i = 1; i < order->points; i++)
        if (order->point[i - 1].error < SMALL && order->point[i].slope < IDLE)
            level = fmax(level, NOISE * order->point[i - 1].error);
    return level;
}

/* ---- the fit ---- */

struct order_line {
    double slope, guard, r2;
};

/*
 * Least squares of log error = a + p log dt + c dt, the last term for what comes after the leading
 * one; with three points c = 0. guard: the standard error, half of what that term changes, or how
 * far local slopes are from a line.
 */
static struct order_line fit(const struct order_point *point, int n)
{
    double x = 0, y = 0, h = 0, xx = 0, xy = 0, yy = 0, xh = 0, hh = 0, hy = 0;
    for (int i = 0; i < n; i++) {
        x += log(point[i].dt) / n;
        y += log(point[i].error) / n;
        h += point[i].dt / point[0].dt / n;
    }
    for (int i = 0; i < n; i++) {
        const double dx = log(point[i].dt) - x, dy = log(point[i].error) - y,
                     dh = point[i].dt / point[0].dt - h;
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
        xh += dx * dh;
        hh += dh * dh;
        hy += dh * dy;
    }
    const double free = xx * hh - xh * xh, plain = xy / xx;
    const double bend = n > LEAST ? (hy * xx - xy * xh) / free : 0;
    struct order_line line = {.slope = (xy - bend * xh) / xx, .r2 = xy * xy / (xx * yy)};
    if (n > LEAST) {
        const double rest = fmax(0, yy - line.slope * xy - bend * hy);
        line.guard = fmax(sqrt(rest / (n - LEAST) * hh / free), fabs(line.slope - plain) / 2);
    }
    for (int i = 1; i < n && n == LEAST; i++)
        line.guard = fmax(line.guard, fabs(log_slope(&point[i - 1], &point[i]) - line.slope));
    return line;
}

/* From the fine end the first window that lies on a line; if there is none, the one that does best.
 */
static bool choose_window(struct order *order, int size)
{
    const double level = rounding_level(order);
    double best = HUGE_VAL;
    for (int first = order->points - size; first >= 0 && best > ALIKE; first--) {
        bool all = true;
        for (int i = first; i < first + size; i++)
            all &= order->point[i].error < TOP && order->point[i].error > level;
        const struct order_line line =
            all ? fit(order->point + first, size) : (struct order_line){NAN, NAN, NAN};
        if (!all || !(line.slope > IDLE) || !(line.guard < best))
            continue;
        best = line.guard;
        order->slope = line.slope;
        order->guard = line.guard;
        order->r2 = line.r2;
        order->fitted = size;
        for (int i = 0; i < order->points; i++)
            order->point[i].fitted = i >= first && i < first + size;
    }
    return best < HUGE_VAL;
}

static enum order_verdict judge(const struct order *order)
{
    bool exact = order->points > 0;
    for (int i = 0; i < order->points; i++)
        exact &= order->point[i].error <= fmax(1e-12, 10 * order->floor);
    if (exact)
        return ORDER_EXACT;
    if (order->fitted == 0)
        return ORDER_NO_RANGE;
    if (fabs(order->slope - order->claimed) <= ORDER_BAND)
        return ORDER_AGREES;
    if (order->guard > ERRATIC)
        return ORDER_ERRATIC;
    if (fabs(order->slope - order->claimed) <= 2 * order->guard)
        return ORDER_AGREES;
    return order->slope < order->claimed ? ORDER_LOWER : ORDER_HIGHER;
}

bool order_sweep(const struct sweep_target *target, struct order *order, struct error *error)
{
    const bool wanted = !isnan(target->dt[0]);
    double steps;
    int low = 0;
    order->points = order->fitted = 0;
    order->slope = order->guard = order->r2 = NAN;
    for (int i = 0; order->points < ORDER_POINTS && steps_at(target, order->claimed, i, &steps);
         i++) {
        struct order_point point = {.dt = fabs(target->span) / steps};
        int64_t cost;
        if (!solve_point(target, &order->by, &point, &cost))
            return error_memory(error);
        if (cancelled(target->cancel))
            return error_set(error, ERROR_CANCELLED, "stopped after %d step sizes", order->points);
        struct order_point *before = order->points ? &order->point[order->points - 1] : NULL;
        if (before)
            point.slope = log_slope(before, &point);
        /* Of the steps too coarse to arrive only the last is of interest. */
        const bool instead = before && !wanted && isnan(before->error) && isnan(point.error);
        order->point[instead ? order->points - 1 : order->points] = point;
        order->points += !instead;
        low += point.error <= fmax(ROUNDING, ACCURACIES * order->floor);
        if (!wanted && (low > 1 || point.stop == STOP_FULL || 2 * cost > target->max))
            break;
    }
    for (int size = order->claimed >= HIGH ? WINDOW + 1 : WINDOW;
         size >= LEAST && !choose_window(order, size); size--) {
    }
    order->verdict = judge(order);
    return true;
}

/* ---- the study ---- */

/* Fastest rate at the start [1/s]. */
static double fastest(const struct system *system)
{
    struct mode mode[STABILITY_MODES];
    int count = 0;
    double max = 0;
    modes_at(system, system->t0, system->start, mode, &count, STABILITY_MODES);
    for (int i = 0; i < count; i++)
        max = fmax(max, mode[i].omega * fmax(1, 2 * mode[i].zeta));
    return max;
}

/* What turning points and switches do to the order; NULL: nothing. misses: another one was found,
 * or none. */
static const char *explain_jumps(const struct system *system, const struct order *order,
                                 bool misses)
{
    const struct method *method = order->by.method;
    const bool meets = method_meets_switches(method, system), turns = method_turns(method, system);
    if (misses && system->oscillator.friction != 0 && system->across)
        return "dry friction jumps where the velocity is 0: each turning point that is crossed "
               "spoils the order";
    if (misses && system->switches > 0 && !meets && !turns)
        return "the forces switch (if, abs, sign, ...), and each switch that is crossed spoils "
               "the order";
    if (order->verdict == ORDER_AGREES && system->switches > system->dry && system->pieces && meets)
        return "the forces switch (if, abs, sign, ...): the order holds because steps end at the "
               "switches";
    if (order->verdict == ORDER_AGREES && system->pieces && system->dry)
        return "dry friction jumps where the velocity is 0: the order holds because steps end at "
               "the turning points";
    if (misses && system->oscillator.quadratic != 0 && order->claimed > 2)
        return "quadratic drag is smooth only up to its first derivative where the velocity is 0: "
               "each turning point spoils higher orders";
    if (order->verdict == ORDER_AGREES && turns)
        return "drag has a kink where the velocity is 0: the order holds because steps end at the "
               "turning points";
    return NULL;
}

/* What the sizes of steps and errors say where the order is another one, or none was found. */
static void explain_sizes(const struct system *system, struct order *order)
{
    const bool none = order->verdict == ORDER_NO_RANGE,
               over = none && !(order->by.method->flags & METHOD_IMPLICIT);
    const double rate = fastest(system),
                 last = order->points ? order->point[order->points - 1].dt : NAN;
    double dt = NAN, best = HUGE_VAL;
    char *out = order->words;
    const size_t size = sizeof order->words;
    for (int i = 0; i < order->points; i++) {
        dt = order->point[i].fitted || isnan(dt) ? order->point[i].dt : dt;
        best = fmin(best, order->point[i].error);
    }
    if (over && !(best < TOP) && rate * last > 0.5)
        snprintf(out, size,
                 "the scene's fastest rate is %.2g 1/s: steps that %s survives are too many to "
                 "afford; an implicit method would do",
                 rate, order->by.method->row.name);
    else if (rate * dt > 1)
        snprintf(out, size,
                 "stiff: these steps leave the fastest motion (%.2g 1/s) unresolved, where methods "
                 "lose order (order reduction)",
                 rate);
    else if (none && best < TOP && ACCURACIES * order->floor > ROUNDING_FAR)
        snprintf(out, size,
                 "the solution that errors are measured against is good to %.1g only: nothing is "
                 "left above that",
                 order->floor);
    else if (none && best < TOP)
        snprintf(
            out, size,
            "double precision leaves no asymptotic part on this scene, even with compensated "
            "sums: the error falls from above %.1g to rounding within two step sizes; a longer "
            "duration may help",
            TOP);
    else if (none)
        snprintf(out, size, "no step that could be afforded gave an error below %.1g", TOP);
    else
        snprintf(
            out, size,
            "the scene is not smooth enough, or these steps are still too coarse; try dt=RANGE");
}

static void explain(const struct system *system, bool rests, struct order *order)
{
    const bool misses = order->verdict == ORDER_LOWER || order->verdict == ORDER_ERRATIC ||
                        order->verdict == ORDER_NO_RANGE;
    const struct method *method = order->by.method;
    const char *jumps = explain_jumps(system, order, misses);
    const size_t size = sizeof order->words;
    order->switches = system->switches > system->dry;
    if (order->by.drag == DRAG_EXPLICIT && method->drag != DRAG_EXPLICIT && system->velocity)
        snprintf(order->words, size, "with drag=explicit %s is of first order, not %d",
                 method->row.name, method->order);
    else if (order->verdict != ORDER_AGREES && rests)
        snprintf(order->words, size,
                 "the body is at rest at the end: all that is left is the error of where, which "
                 "may be of another order; a duration that ends before shows that of the motion");
    else if (jumps)
        snprintf(order->words, size, "%s", jumps);
    else if (misses)
        explain_sizes(system, order);
}

bool study_order(const struct order_request *request, struct order *order, struct error *error)
{
    struct system system;
    struct reference reference;
    *order = (struct order){.by = request->by, .slope = NAN, .guard = NAN, .r2 = NAN};
    if (request->by.method->flags & METHOD_EXTERNAL)
        return error_set(error, ERROR_COMMAND, "%s chooses its steps itself: it has no order in dt",
                         request->by.method->row.name);
    if (!(request->duration > 0) || !isfinite(request->duration))
        return error_set(error, ERROR_COMMAND, "the duration must be > 0 (got %.6g s)",
                         request->duration);
    if (!scene_bind(request->scene, &system, error) ||
        !method_applies(request->by.method, &system, &order->by.drag, error) ||
        !references_get(request->references, request->scene, &system, request->duration,
                        request->cancel, &reference, error))
        return false;
    const bool first = order->by.drag == DRAG_EXPLICIT && system.velocity;
    order->claimed = first && request->by.method->order > 1 ? 1 : request->by.method->order;
    order->floor = reference.accuracy;
    order->reference_stored = reference.stored;
    struct sweep_target target = {.system = &system,
                                  .span = request->duration,
                                  .end = reference.y + (STUDY_TIMES - 1) * system.n,
                                  .dt = {request->dt[0], request->dt[1]},
                                  .max = (int64_t)(COST_MAX / system.n),
                                  .cancel = request->cancel};
    for (int i = 0; i < system.n; i++) {
        for (int k = 0; k < STUDY_TIMES; k++)
            target.size[i] = fmax(target.size[i], fabs(reference.y[k * system.n + i]));
        if (!(target.size[i] > 1e-18 * system.scale[i]))
            target.size[i] = system.scale[i];
    }
    const bool ok = order_sweep(&target, order, error),
               rests = system.oscillator.friction != 0 && target.end[1] == 0;
    reference_free(&reference);
    if (ok)
        explain(&system, rests, order);
    return ok;
}
