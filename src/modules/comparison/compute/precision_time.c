/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The timing of a precision study: all meaningful points side by side; long solves of fixed steps
 * are timed in part and scaled. */
#include "modules/comparison/compute/suspect.h"
#include <hooke/base/cancel.h>

#include <stdlib.h>

/* Number of steps that are timed in a longer solve of fixed steps. */
#define TIMED_STEPS_MAX 30000
/* largest relative difference of a scaled time from that of a whole solve */
#define PARTIAL_TIME_DIFFERENCE_MAX 0.15

/* Returns the settings with which a point is solved and timed. */
struct run_settings precision_settings(const struct precision *precision,
                                       const struct precision_point *point)
{
    return (struct run_settings){.dt = point->dt,
                                 .tol = point->tol,
                                 .drag = precision->curve[point->curve].choice.drag,
                                 .kernel =
                                     KERNEL_SPECIALISED, /* methods are compared, not matrices */
                                 .compensated = precision->compensated};
}

/* Times whole runs of the point that record every step. Returns the shortest of three [s], of one
 * if it lasts longer than 0.1 s, or NAN if none reaches the end. */
static double time_recording(const struct precision_request *request,
                             const struct precision *precision, const struct precision_point *point)
{
    struct run_settings settings = precision_settings(precision, point);
    double shortest = NAN;
    /* the energy balance is left out, so that recording alone is timed */
    settings.unbalanced = true;
    if (point->tol > 0) /* an adaptive run needs a first step */
        settings.dt = precision->duration / (STUDY_TIMES - 1);
    for (int i = 0; i < 3 && !(shortest > 0.1); i++) {
        struct error ignored;
        struct run *run = run_create(request->scene, precision->curve[point->curve].choice.method,
                                     &settings, precision->duration, &ignored);
        if (!run)
            return NAN;
        const struct run_target target = {.t = run->system.t0 + precision->duration, .steps = -1};
        const int64_t begin = clock_cpu_ns();
        while (run_advance(run, &target, 0, request->cancel)) {
        }
        if (run->stop == STOP_END)
            shortest = fmin(shortest, (double)(clock_cpu_ns() - begin) * 1e-9);
        run_destroy(run);
    }
    return shortest;
}

/* Limits the timed part of long solves with fixed steps to TIMED_STEPS_MAX steps, since the cost of
 * one step does not depend on their number. index[i] is the point of solver i. */
static void shorten_solves(const struct precision *precision, struct solver *solver,
                           const int *index, int count)
{
    for (int i = 0; i < count; i++)
        if (solver[i].tol == 0 && precision->point[index[i]].steps > TIMED_STEPS_MAX)
            solver[i].part = TIMED_STEPS_MAX;
}

/* Multiplies minimum and median by the factor. */
static void timing_multiply(struct timing_result *time, double factor)
{
    time->minimum *= factor;
    time->median *= factor;
}

/* The points of a study that are timed. */
struct timed_points {
    struct solver *solver;        /* [count] */
    struct timing_result *result; /* [count] */
    int *index;                   /* [count] index of the point in precision.point */
    int count;
};

/* Scales the times of shortened solves to whole ones, in proportion to evaluations, Jacobians and
 * solves of linear systems. */
static void scale_partial_times(struct precision *precision, const struct timed_points *timed)
{
    for (int i = 0; i < timed->count; i++) {
        struct precision_point *point = &precision->point[timed->index[i]];
        const struct solver *s = &timed->solver[i];
        if (s->part == 0 || isnan(point->time.minimum))
            continue;
        point->timed_steps = s->steps;
        timing_multiply(&point->time, solve_work(&point->cost, point->steps) /
                                          solve_work(&s->step.cost, s->steps));
    }
}

/* Times the first shortened point of each curve completely, too. If that differs by more than
 * PARTIAL_TIME_DIFFERENCE_MAX from the scaled time, the steps of the method do not all cost the
 * same here, and each point of the curve is timed completely. */
static void check_partial_times(struct precision *precision, const struct timed_points *timed,
                                const struct cancel *cancel)
{
    int curve = -1;
    bool differs = false;
    for (int i = 0; i < timed->count && !cancelled(cancel); i++) {
        struct precision_point *point = &precision->point[timed->index[i]];
        struct timing_result whole;
        if (timed->solver[i].part == 0 || isnan(point->time.minimum) ||
            (point->curve == curve && !differs))
            continue;
        timed->solver[i].part = 0;
        time_solvers(&timed->solver[i], &whole, 1, TIMING_QUICK, 1e-9, cancel);
        if (isnan(whole.minimum))
            continue;
        differs = (point->curve == curve && differs) ||
                  !(fabs(whole.minimum / point->time.minimum - 1) <= PARTIAL_TIME_DIFFERENCE_MAX);
        curve = point->curve;
        if (differs) {
            point->time = whole;
            point->timed_steps = 0;
        }
    }
}

/* Sets the time of a costly point to that of the one solve that measured its error; such a time is
 * not ranked. Returns true if the point is costly. */
static bool time_costly_point(struct precision_point *point)
{
    if (point->costly)
        point->time = (struct timing_result){.minimum = point->seconds,
                                             .median = point->seconds,
                                             .spread = NAN,
                                             .samples = 1,
                                             .few = true};
    return point->costly;
}

/* Measures the computing times of all meaningful points side by side, which takes about `seconds`,
 * and sets time and, if requested, recording of each point. With TIMING_QUICK costly points are
 * left out or timed in part. Returns false with *error if out of memory. */
bool precision_time(const struct precision_request *request, struct precision *precision,
                    double seconds, struct error *error)
{
    const size_t capacity = (size_t)precision->points + 1;
    struct timed_points timed = {.solver = calloc(capacity, sizeof *timed.solver),
                                 .result = calloc(capacity, sizeof *timed.result),
                                 .index = calloc(capacity, sizeof *timed.index)};
    const struct cancel *cancel = request->cancel;
    bool ok = timed.solver && timed.result && timed.index;
    for (int i = 0; ok && i < precision->points; i++) {
        const struct precision_point *point = &precision->point[i];
        const struct run_settings settings = precision_settings(precision, point);
        if (!precision_meaningful(point) ||
            (request->timing == TIMING_QUICK && time_costly_point(&precision->point[i])))
            continue;
        ok = solver_init(&timed.solver[timed.count], &precision->system,
                         precision->curve[point->curve].choice.method, &settings,
                         precision->duration);
        timed.index[timed.count++] = i;
    }
    if (ok) {
        if (request->timing == TIMING_QUICK)
            shorten_solves(precision, timed.solver, timed.index, timed.count);
        time_solvers(timed.solver, timed.result, timed.count, request->timing, seconds, cancel);
        for (int i = 0; i < timed.count; i++)
            precision->point[timed.index[i]].time = timed.result[i];
        scale_partial_times(precision, &timed);
        check_partial_times(precision, &timed, cancel);
        for (int i = 0; i < timed.count && request->recording && !cancelled(cancel); i++)
            precision->point[timed.index[i]].recording =
                time_recording(request, precision, &precision->point[timed.index[i]]);
    }
    for (int i = 0; i < timed.count; i++)
        solver_free(&timed.solver[i]);
    free(timed.solver);
    free(timed.result);
    free(timed.index);
    return ok || error_memory(error);
}
