/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How long a solve takes: chained, batched, warmed up, minimum and median. */
#include <hooke/study.h>

#include <stdlib.h>
#include <string.h>

static const struct row timing_rows[] = {
    [TIMING_OFF] = {"off", "", "no times are measured", "", NULL},
    [TIMING_QUICK] = {"quick", "", "5 samples of at least 0.2 ms", "", NULL},
    [TIMING_FULL] = {"full", "", "15 samples of at least 1 ms", "", NULL},
};

const struct catalog timing_catalog = CATALOG("timing", timing_rows);

static const struct protocol {
    int samples;
    double sample_seconds,
        budget_seconds; /* a sample lasts at least, all of them together at most (but one is always taken) */
} protocols[] = {
    [TIMING_OFF] = {0, 0, 0},
    [TIMING_QUICK] = {5, 2e-4, 0.02},
    [TIMING_FULL] = {15, 1e-3, 2.0},
};

#define MAX_SAMPLES 15

struct solve {
    const struct system *system;
    const struct method *method;
    struct step step;
    double span, dt, tol;
    double y[LIMIT_VARIABLES];
};

/* One solve from the given start; the state at the end is in s->y. False: it stopped early. */
static bool solve_once(struct solve *s, const struct cancel *cancel)
{
    struct step *step = &s->step;
    step->t = s->system->t0;
    step->warm = false;
    double end = s->system->t0 + s->span;
    if (s->tol > 0) {
        struct controller controller = {.tol = s->tol};
        while (step->t != end) {
            if (method_adapt(s->method, step, &controller, end) != STEP_OK || cancelled(cancel)) {
                return false;
            }
        }
        return true;
    }
    double r = fabs(s->span) / s->dt;
    int64_t steps = (int64_t)r;
    if (fabs(r - (double)llround(r)) <= 4 * 2.220446049250313e-16 * r) {
        steps = llround(r);
    }
    step->h = s->span < 0 ? -s->dt : s->dt;
    for (int64_t i = 0; i < steps; i++) {
        step->t = s->system->t0 + (double)i * step->h;
        if (method_step(s->method, step) != STEP_OK || ((i & 1023) == 1023 && cancelled(cancel))) {
            return false;
        }
    }
    return true;
}

/* Seconds for `batch` solves, each starting from a state that depends on the result of the one before. */
static double time_batch(struct solve *s, int64_t batch, const struct cancel *cancel)
{
    double start[LIMIT_VARIABLES];
    size_t size = (size_t)s->system->n * sizeof(double);
    memcpy(start, s->system->start, size);
    int64_t begin = clock_ns();
    for (int64_t i = 0; i < batch; i++) {
        memcpy(s->y, start, size);
        if (!solve_once(s, cancel)) {
            return NAN;
        }
        start[0] = s->system->start[0] +
                   1e-300 * s->y[0]; /* too small to change the number, but the processor must wait for it */
    }
    return (double)(clock_ns() - begin) * 1e-9;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_of(double *values, int count)
{
    qsort(values, (size_t)count, sizeof values[0], by_value);
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

void time_solve(const struct system *system, const struct method *method, const struct run_settings *settings,
                double span, enum timing timing, const struct cancel *cancel, struct timing_result *result)
{
    *result = (struct timing_result){NAN, NAN, NAN, 0};
    struct protocol protocol = protocols[timing];
    if (protocol.samples == 0) {
        return;
    }
    double *work = malloc((method_work_size(method, system->n) + 1) * sizeof *work);
    if (!work) {
        return;
    }
    struct solve s = {.system = system, .method = method, .span = span, .dt = settings->dt, .tol = settings->tol};
    if (!(method->flags & METHOD_ADAPTIVE)) {
        s.tol = 0;
    }
    s.step = (struct step){.system = system, .drag = settings->drag, .y = s.y, .work = work};

    double once = time_batch(&s, 1, cancel); /* warm-up */
    int64_t batch = 1;
    if (once < protocol.sample_seconds) {
        batch = (int64_t)(protocol.sample_seconds / fmax(once, 1e-8)) + 1;
    }
    double sample[MAX_SAMPLES];
    double spent = 0;
    while (!isnan(once) && result->samples < protocol.samples &&
           (result->samples == 0 || spent < protocol.budget_seconds)) {
        double seconds = time_batch(&s, batch, cancel);
        if (isnan(seconds)) {
            break;
        }
        spent += seconds;
        sample[result->samples++] = seconds / (double)batch;
    }
    free(work);
    if (result->samples == 0) {
        return;
    }
    result->median = median_of(sample, result->samples);
    result->minimum = sample[0];
    for (int i = 0; i < result->samples; i++) {
        sample[i] = fabs(sample[i] - result->median);
    }
    result->spread = median_of(sample, result->samples) / result->median;
}
