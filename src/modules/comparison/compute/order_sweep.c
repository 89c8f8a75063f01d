/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The study behind `order`: solves with fixed steps from coarse to fine, and fits the slope of the
 * errors where it is constant. */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include "modules/comparison/compute/verify.h"

#include <float.h>
#include <stdlib.h>

#define ROUNDING_ERROR_MAX 1e-6 /* largest error at which a slope near 0 is caused by rounding */
#define SLOPE_IDLE 0.3          /* slope below which a smaller step gains nothing */
#define ROUNDING_FACTOR 10      /* errors below this many times the rounding bend the line */
/* Number of points in the fit, and one more for orders from FINE_SWEEP_ORDER on. */
#define FIT_POINTS 4
#define FIT_POINTS_MIN 3
/* A slope agrees with the claimed order if it is nearer than ORDER_DISTANCE_MAX, as orders are
 * whole numbers or halves, or than AGREES_SHARE of the order, as high orders come to rounding after
 * few steps. */
#define ORDER_DISTANCE_MAX 0.25
#define AGREES_SHARE 0.05
#define GUARD_MAX 0.3 /* a wider guard band does not distinguish an order from the next */
/* Slopes that come this much nearer to the claim within a window are still approaching it. */
#define SLOPE_APPROACH_MIN 0.03
/* Errors may show traces of rounding below this many times its level. */
#define ROUNDING_SUSPECT_FACTOR 300
#define SETTLED_SPREAD 0.1    /* slopes that differ by less belong to one power of dt */
#define SETTLED_CHANGE 0.35   /* largest last change of slopes that approach a limit, */
#define SETTLED_SHRINKING 0.8 /* and its largest ratio to the change before */
#define SLOPE_KINK 0.02       /* a larger change after equal slopes is caused by rounding */
#define COST_MAX 6e6          /* largest cost of one solve */
/* Lowest order at which each step is 1/sqrt(2) of the one before instead of half, as its error
 * falls fast. */
#define FINE_SWEEP_ORDER 5

static const struct row verdicts[] = {
    [ORDER_AGREES] = {"as claimed", "", "the slope is that of the claimed order", "", NULL},
    [ORDER_LOWER] = {"lower", "", "the error falls more slowly than claimed", "", NULL},
    [ORDER_HIGHER] = {"higher", "", "the error falls faster than claimed", "", NULL},
    [ORDER_ERRATIC] = {"erratic", "", "the slope changes from step to step, so no order is given",
                       "", NULL},
    [ORDER_NO_RANGE] = {"no range", "", "no range of steps with a constant slope", "", NULL},
    [ORDER_EXACT] = {"exact", "", "only rounding errors", "", NULL},
};

const struct catalog order_verdict_catalog = CATALOG("verdict", verdicts);

/* ---- the sweep ---- */

/*
 * Returns the root of the mean square distance from the known states at the quarters of the span,
 * over all variables in units of their amplitudes. A single time or variable would not do: its
 * error has zeros as a function of the step, next to which slopes mean nothing. Fewer than four
 * steps are compared at the end only.
 */
static double state_distance(const struct sweep_target *target, int64_t steps, const double *grid)
{
    const int n = target->system->n, stride = steps % 4 ? STUDY_TIMES - 1 : SWEEP_STRIDE;
    double sum = 0;
    int count = 0;
    for (int k = stride; k < STUDY_TIMES; k += stride)
        for (int i = 0; i < n; i++, count++) {
            const double distance = (grid[k * n + i] - target->state[k * n + i]) / target->size[i];
            sum += distance * distance;
        }
    return sqrt(sum / count);
}

/* Solves with the step of a point and fills in its error, which is NAN if the end was not reached.
 * *cost is what it took. Returns false if out of memory. */
static bool solve_point(const struct sweep_target *target, const struct method_choice *choice,
                        double *grid, struct order_point *point, int64_t *cost)
{
    const struct run_settings settings = {
        .dt = point->dt, .drag = choice->drag, .compensated = true};
    struct error ignored;
    struct solver solver;
    *cost = 0;
    point->error = point->slope = NAN;
    if (!method_fits(choice->method, target->system, choice->drag, point->dt, &ignored)) {
        point->refused = true;
        return true;
    }
    if (!solver_init(&solver, target->system, choice->method, &settings, target->span))
        return false;
    solver.max = target->max;
    point->stop = solver_run(&solver, grid, target->cancel);
    point->steps = solver.steps;
    point->turns = solver.step.cost.turns;
    *cost = solver_cost(&solver) + solver.steps;
    if (point->stop == STOP_END)
        point->error = state_distance(target, solver.steps, grid);
    solver_free(&solver);
    return true;
}

/* Sets the number of steps of point i of the sweep, from coarse to fine: multiples of 4 that grow
 * by factors of 2, or of sqrt 2 for high orders. Returns false beyond the range. */
static bool steps_at(const struct sweep_target *target, int order, int i, double *steps)
{
    const double each = order >= FINE_SWEEP_ORDER ? sqrt(2) : 2, span = fabs(target->span);
    const bool wanted = !isnan(target->dt[0]);
    const double first = wanted ? span / fmax(target->dt[0], target->dt[1]) : 4;
    const double last = wanted ? span / fmin(target->dt[0], target->dt[1]) : 4e9;
    *steps = nearbyint(first * pow(each, i));
    if (*steps > 4)
        *steps = 4 * nearbyint(*steps / 4);
    return *steps >= 1 && *steps <= fmax(last, first) * (1 + 1e-9) + 2;
}

/* Returns the local order between two points. */
static double log_slope(const struct order_point *coarse, const struct order_point *fine)
{
    return log(coarse->error / fine->error) / log(coarse->dt / fine->dt);
}

/* Returns true if the error stops falling at point i by rounding: its slope is near 0 and no finer
 * point has an error far below that of the point before. */
static bool gains_nothing(const struct order *order, int i)
{
    const double previous_error = order->point[i - 1].error;
    bool gains = !(previous_error < ROUNDING_ERROR_MAX && order->point[i].slope < SLOPE_IDLE);
    for (; !gains && i < order->points; i++)
        gains = order->point[i].error < previous_error / ROUNDING_FACTOR;
    return !gains;
}

/* Returns the index of the last point before rounding stops the error from falling, or the number
 * of points if none does. */
static int rounding_begin(const struct order *order)
{
    int i = 1;
    while (i < order->points && !gains_nothing(order, i))
        i++;
    return i < order->points ? i - 1 : order->points;
}

/* Returns the error below which rounding contributes: well above the errors where it stops the
 * fall. */
static double rounding_level(const struct order *order)
{
    const double level = fmax(ORDER_ROUNDING, ORDER_ACCURACIES * order->floor);
    const int begin = rounding_begin(order);
    return begin == order->points
               ? level
               : fmax(level, ROUNDING_FACTOR *
                                 fmax(order->point[begin].error, order->point[begin + 1].error));
}

/* ---- the fit ---- */

/* A fitted line: its slope, the uncertainty of the slope, and R^2. */
struct order_line {
    double slope, guard, r2;
};

/*
 * Fits log error = a + p log dt + c dt by least squares, the last term for what follows the leading
 * one. `guard` is the larger of the standard error and half of the change by that term. With three
 * points c = 0, and `guard` is the largest distance of a local slope from that of the line.
 */
static struct order_line order_line_fit(const struct order_point *point, int n)
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
    /* determinant of the normal equations, and the slope without the last term */
    const double free = xx * hh - xh * xh, plain = xy / xx;
    const double bend = n > FIT_POINTS_MIN ? (hy * xx - xy * xh) / free : 0;
    struct order_line line = {.slope = (xy - bend * xh) / xx, .r2 = xy * xy / (xx * yy)};
    if (n > FIT_POINTS_MIN) {
        const double rest = fmax(0, yy - line.slope * xy - bend * hy);
        line.guard =
            fmax(sqrt(rest / (n - FIT_POINTS_MIN) * hh / free), fabs(line.slope - plain) / 2);
    }
    for (int i = 1; i < n && n == FIT_POINTS_MIN; i++)
        line.guard = fmax(line.guard, fabs(log_slope(&point[i - 1], &point[i]) - line.slope));
    return line;
}

/* Returns the relative uncertainty of a point's error, caused by the reference and by rounding. */
static double point_noise(const struct order *order, const struct order_point *point)
{
    return fmax(ORDER_ROUNDING, ORDER_ACCURACIES * order->floor) / ORDER_ACCURACIES / point->error;
}

/* Returns true if the slopes within a window of n points are equal within SETTLED_SPREAD, or
 * approach a limit in ever smaller changes. *rest is how far the last slope may be from the
 * limit. */
static bool slopes_settle(const struct order *order, const struct order_point *point, int n,
                          double *rest)
{
    const double ratio = point[n - 2].dt / point[n - 1].dt,
                 noise = 2 * point_noise(order, &point[n - 1]) / log(ratio),
                 last = point[n - 1].slope, change = fabs(last - point[n - 2].slope),
                 change_before =
                     n > FIT_POINTS_MIN ? fabs(point[n - 2].slope - point[n - 3].slope) : 0;
    double spread = 0;
    for (int i = 1; i < n - 1; i++)
        spread = fmax(spread, fabs(point[i].slope - last));
    *rest = fmax(noise, change / (ratio - 1));
    if (spread <= SETTLED_SPREAD + noise)
        return true;
    return change <= SETTLED_CHANGE && change <= SETTLED_SHRINKING * change_before + noise;
}

/* Finds the finest run of points that are asymptotic and above rounding: *last is the index of the
 * finest one. Returns how many there are. */
static int usable_points(const struct order *order, int *last)
{
    const double level = rounding_level(order);
    int count = 0;
    *last = rounding_begin(order) - 1;
    while (*last >= 0 &&
           !(order->point[*last].error > level && order->point[*last].error < ORDER_ERROR_MAX))
        --*last;
    for (int i = *last;
         i >= 0 && order->point[i].error > level && order->point[i].error < ORDER_ERROR_MAX; i--)
        count++;
    return count;
}

/* Fits a line through the `size` points that end with point `last`, and stores it in the order.
 * Returns false, with the order unchanged, if their slopes have not settled or the line is too
 * uncertain. */
static bool fit_window(struct order *order, int last, int size)
{
    const struct order_point *first = &order->point[last + 1 - size], *finest = &order->point[last];
    double rest;
    if (!slopes_settle(order, first, size, &rest))
        return false;
    const struct order_line line = order_line_fit(first, size);
    const double ahead = fmax(fabs(line.slope - finest->slope), point_noise(order, finest)),
                 guard = fmax(line.guard, rest + ahead);
    if (!(line.slope > SLOPE_IDLE) || guard > GUARD_MAX)
        return false;
    order->slope = line.slope;
    order->guard = guard;
    order->r2 = line.r2;
    order->fitted = size;
    order->unsettled = false;
    for (int i = 0; i < order->points; i++)
        order->point[i].fitted = i > last - size && i <= last;
    return true;
}

/* Returns true if the slope changes at a point far more than at the one before it, as it does where
 * rounding begins. The relative share of rounding in an error that falls as h^p grows as h^-p; a
 * next term of the error changes the slope far more slowly. */
static bool has_kink(const struct order_point *point)
{
    const double change = fabs(point[0].slope - point[-1].slope),
                 previous_change = fabs(point[-1].slope - point[-2].slope),
                 growth = pow(point[-1].dt / point[0].dt, fabs(point[-1].slope) / 2);
    return change > SLOPE_KINK && change > fmax(2, growth) * previous_change;
}

/* Returns the error below which a point may have traces of rounding, which grows with the number of
 * steps. */
static double suspect_level(const struct order *order, const struct order_point *point)
{
    return ROUNDING_SUSPECT_FACTOR *
           fmax(rounding_level(order), DBL_EPSILON * (double)point->steps);
}

/* Fits a line through the finest points whose slopes have settled: as many as do, up to `size`.
 * Points near the level of rounding may be left out, as methods differ in how rounding affects
 * them. Returns false if the finest usable points were left out for another reason than a kink by
 * rounding. */
static bool choose_window(struct order *order, int size)
{
    int last;
    int usable = usable_points(order, &last);
    bool only_kinks = true;
    order->unsettled = usable >= FIT_POINTS_MIN;
    for (; usable >= FIT_POINTS_MIN; usable--, last--) {
        const struct order_point *finest = &order->point[last];
        const bool suspect = finest->error <= suspect_level(order, finest),
                   kink = usable > FIT_POINTS_MIN && suspect && has_kink(finest);
        for (int n = size < usable ? size : usable; n >= FIT_POINTS_MIN && !kink; n--)
            if (fit_window(order, last, n))
                return only_kinks;
        if (!suspect)
            break;
        only_kinks = only_kinks && kink;
    }
    return only_kinks;
}

/* Returns true if the slopes of the window approach the claimed order from one point to the next,
 * so that the leading term of the error, whose power is the order, does not yet dominate. */
static bool slopes_approach_claim(const struct order *order)
{
    const struct order_point *first = order->point;
    while (!first->fitted)
        first++;
    const double first_deviation = fabs(first[1].slope - order->claimed),
                 last_deviation = fabs(first[order->fitted - 1].slope - order->claimed);
    return first_deviation - last_deviation >
           SLOPE_APPROACH_MIN + 2 * point_noise(order, &first[order->fitted - 1]);
}

/* Removes the fitted line, so that the order counts as erratic. */
static void forget_window(struct order *order)
{
    order->unsettled = true;
    order->slope = order->guard = order->r2 = NAN;
    order->fitted = 0;
    for (int i = 0; i < order->points; i++)
        order->point[i].fitted = false;
}

/* Compares the fitted slope with the claimed order. A window that is not the finest above rounding,
 * has few points, or whose slopes still approach the claim, may confirm it but not refute it: its
 * line is removed then. */
static enum order_verdict order_judge(struct order *order, bool finest)
{
    bool exact = order->points > 0;
    for (int i = 0; i < order->points; i++)
        exact &= order->point[i].error <= fmax(1e-12, 10 * order->floor);
    if (exact)
        return ORDER_EXACT;
    const double tolerance = fmax(ORDER_DISTANCE_MAX, AGREES_SHARE * order->claimed);
    if (order->fitted && fabs(order->slope - order->claimed) <= fmax(tolerance, 2 * order->guard))
        return ORDER_AGREES;
    if (order->fitted && (!finest || order->fitted < FIT_POINTS || slopes_approach_claim(order)))
        forget_window(order);
    if (order->fitted == 0)
        return order->unsettled ? ORDER_ERRATIC : ORDER_NO_RANGE;
    return order->slope < order->claimed ? ORDER_LOWER : ORDER_HIGHER;
}

/* Solves with ever smaller steps and appends points, until rounding, the budget or the range ends
 * it. grid [STUDY_TIMES][n] is memory for states. Returns false with an error if out of memory or
 * cancelled. */
static bool sweep_steps(const struct sweep_target *target, double *grid, struct order *order,
                        struct error *error)
{
    const bool wanted = !isnan(target->dt[0]);
    double steps, last = 0;
    int low = 0;
    for (int i = 0; order->points < ORDER_POINTS && steps_at(target, order->claimed, i, &steps);
         i++) {
        struct order_point point = {.dt = fabs(target->span) / steps};
        int64_t cost;
        if (steps == last)
            continue;
        last = steps;
        if (!solve_point(target, &order->choice, grid, &point, &cost))
            return error_memory(error);
        if (cancelled(target->cancel))
            return error_set(error, ERROR_CANCELLED, "stopped after %d step sizes", order->points);
        struct order_point *previous = order->points ? &order->point[order->points - 1] : NULL;
        if (previous)
            point.slope = log_slope(previous, &point);
        /* Only the last of the steps too coarse to reach the end is kept. */
        const bool instead = previous && !wanted && isnan(previous->error) && isnan(point.error);
        order->point[instead ? order->points - 1 : order->points] = point;
        order->points += !instead;
        /* number of points whose errors are rounding */
        low += point.error <= fmax(ORDER_ROUNDING, ORDER_ACCURACIES * order->floor);
        if (!wanted && (low > 1 || point.stop == STOP_FULL || 2 * cost > target->max))
            break;
    }
    return true;
}

/* Solves with ever smaller steps and fits the order. */
bool order_sweep(const struct sweep_target *target, struct order *order, struct error *error)
{
    double *grid = malloc((size_t)STUDY_TIMES * (size_t)target->system->n * sizeof *grid);
    order->points = order->fitted = 0;
    order->unsettled = false;
    order->slope = order->guard = order->r2 = NAN;
    if (!grid)
        return error_memory(error);
    const bool ok = sweep_steps(target, grid, order, error);
    free(grid);
    if (!ok)
        return false;
    const bool finest =
        choose_window(order, order->claimed >= FINE_SWEEP_ORDER ? FIT_POINTS + 1 : FIT_POINTS);
    order->verdict = order_judge(order, finest);
    return true;
}

/* ---- the study ---- */

/* Measures the order of a method: solves the scene with several step sizes, compares with a
 * reference, fits the slope, and explains what spoils it. Returns false with *error if the duration
 * is invalid, the method does not apply, or there is no reference. */
bool study_order(const struct order_request *request, struct order *order, struct error *error)
{
    struct system system;
    struct reference reference;
    *order = (struct order){.choice = request->choice, .slope = NAN, .guard = NAN, .r2 = NAN};
    if (request->choice.method->flags & METHOD_EXTERNAL)
        return error_set(error, ERROR_COMMAND,
                         "%s chooses its steps itself, so it has no order in dt",
                         request->choice.method->row.name);
    if (!(request->duration > 0) || !isfinite(request->duration))
        return error_set(error, ERROR_COMMAND, "the duration must be > 0 (got %.6g s)",
                         request->duration);
    if (!scene_bind(request->scene, &system, error) ||
        !method_applies(request->choice.method, &system, &order->choice.drag, error) ||
        !references_get(request->references, request->scene, &system, request->duration,
                        request->cancel, &reference, error))
        return false;
    const bool first = order->choice.drag == DRAG_EXPLICIT && system.velocity;
    order->claimed = first && request->choice.method->order > 1 ? 1 : request->choice.method->order;
    order->floor = reference.accuracy;
    order->reference_stored = reference.stored;
    struct sweep_target target = {.system = &system,
                                  .span = request->duration,
                                  .state = reference.y,
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
               rests = system.oscillator.friction != 0 &&
                       target.state[(STUDY_TIMES - 1) * system.n + 1] == 0;
    reference_free(&reference);
    if (ok)
        order_explain(&system, rests, order);
    return ok;
}
