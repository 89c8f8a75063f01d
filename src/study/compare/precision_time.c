/* SPDX-License-Identifier: GPL-3.0-or-later */
/* precision: what the solves of its points take. */
#include "study/compare/suspect.h"

#include <stdlib.h>

#define LONG 0.02  /* [s] a solve; no second one is made for its time then */
#define PART 30000 /* steps that are timed of a longer solve of fixed steps */
#define PART_OFF 0.15

struct run_settings precision_settings(const struct precision *precision,
                                       const struct precision_point *point)
{
    return (struct run_settings){.dt = point->dt,
                                 .tol = point->tol,
                                 .drag = precision->curve[point->curve].by.drag,
                                 .kernel =
                                     KERNEL_SPECIALISED, /* methods are compared, not matrices */
                                 .compensated = precision->compensated};
}

static double time_recording(const struct precision_request *request,
                             const struct precision *precision, const struct precision_point *point)
{
    struct run_settings settings = precision_settings(precision, point);
    double shortest = NAN;
    settings.unbalanced = true; /* recording alone is timed */
    if (point->tol > 0)         /* a run wants a first guess */
        settings.dt = precision->duration / (STUDY_TIMES - 1);
    for (int i = 0; i < 3 && !(shortest > 0.1); i++) {
        struct error ignored;
        struct run *run = run_create(request->scene, precision->curve[point->curve].by.method,
                                     &settings, precision->duration, &ignored);
        if (!run)
            return NAN;
        const struct run_target target = {.t = run->system.t0 + precision->duration, .steps = -1};
        const int64_t begin = clock_ns();
        while (run_advance(run, &target, 0, request->cancel)) {
        }
        if (run->stop == STOP_END)
            shortest = fmin(shortest, clock_seconds(begin));
        run_destroy(run);
    }
    return shortest;
}

/* One that takes long was timed well enough when its error was measured. */
static bool taken_as_timed(struct precision_point *point)
{
    if (point->seconds < LONG || (point->tol == 0 && point->steps > PART))
        return false;
    point->time = (struct timing_result){point->seconds, point->seconds, 0, 1, true};
    return true;
}

/* Of fixed steps PART are timed: what one costs does not depend on how many there are. */
static void shorten(const struct precision *precision, struct solver *solver, const int *index,
                    int count)
{
    for (int i = 0; i < count; i++)
        if (solver[i].tol == 0 && precision->point[index[i]].steps > PART)
            solver[i].part = PART;
}

static void multiply(struct timing_result *time, double factor)
{
    time->minimum *= factor;
    time->median *= factor;
}

/*
 * Times of parts become those of whole solves, in proportion to what was evaluated. The first of
 * each curve is timed whole, too: where that differs by more than PART_OFF, the steps do not all
 * cost the same, and what it says holds.
 */
static void scale_up(struct precision *precision, struct solver *solver, const int *index,
                     int count, const struct cancel *cancel)
{
    double factor = 1;
    int curve = -1;
    for (int i = 0; i < count; i++) {
        struct precision_point *point = &precision->point[index[i]];
        const struct solver *s = &solver[i];
        if (s->part == 0 || isnan(point->time.minimum))
            continue;
        point->timed_steps = s->steps;
        multiply(&point->time,
                 solve_work(&point->cost, point->steps) / solve_work(&s->step.cost, s->steps));
        if (point->curve != curve) {
            struct timing_result whole;
            solver[i].part = 0;
            time_solvers(&solver[i], &whole, 1, TIMING_QUICK, LONG, cancel);
            curve = point->curve;
            factor = whole.minimum / point->time.minimum;
            factor = factor > 1 + PART_OFF || factor < 1 - PART_OFF ? factor : 1;
        }
        multiply(&point->time, factor);
    }
}

bool precision_time(const struct precision_request *request, struct precision *precision,
                    double seconds, struct error *error)
{
    const size_t capacity = (size_t)precision->points + 1;
    struct solver *solver = calloc(capacity, sizeof *solver);
    struct timing_result *result = calloc(capacity, sizeof *result);
    int *index = calloc(capacity, sizeof *index), count = 0;
    bool ok = solver && result && index;
    for (int i = 0; ok && i < precision->points; i++) {
        const struct precision_point *point = &precision->point[i];
        const struct run_settings settings = precision_settings(precision, point);
        if (!precision_meaningful(point))
            continue;
        if (request->timing == TIMING_QUICK && taken_as_timed(&precision->point[i]))
            continue;
        ok = solver_init(&solver[count], &precision->system,
                         precision->curve[point->curve].by.method, &settings, precision->duration);
        index[count++] = i;
    }
    if (ok) {
        if (request->timing == TIMING_QUICK)
            shorten(precision, solver, index, count);
        time_solvers(solver, result, count, request->timing, seconds, request->cancel);
        for (int i = 0; i < count; i++)
            precision->point[index[i]].time = result[i];
        if (request->timing == TIMING_QUICK)
            scale_up(precision, solver, index, count, request->cancel);
        for (int i = 0; i < count && request->recording && !cancelled(request->cancel); i++)
            precision->point[index[i]].recording =
                time_recording(request, precision, &precision->point[index[i]]);
    }
    for (int i = 0; i < count; i++)
        solver_free(&solver[i]);
    free(solver);
    free(result);
    free(index);
    return ok || error_memory(error);
}
