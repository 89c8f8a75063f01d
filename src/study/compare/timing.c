/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How long solves take: chained, batched, warmed up, interleaved at random, minimum and median. */
#include "study/compare/solve.h"

#include <hooke/base/numeric.h>

#include <gsl/gsl_statistics_double.h>
#include <stdlib.h>
#include <string.h>

static const struct row timing_rows[] = {
    [TIMING_OFF] = {"off", "", "no times are measured", "", NULL},
    [TIMING_QUICK] = {"quick", "", "5 samples of at least 0.2 ms", "", NULL},
    [TIMING_FULL] = {"full", "", "15 samples of at least 1 ms", "", NULL},
};

const struct catalog timing_catalog = CATALOG("timing", timing_rows);

double timing_step_ns(const struct timing_result *time, int64_t steps)
{
    return steps > 0 ? time->minimum / (double)steps * 1e9 : NAN;
}

void buffer_step_time(struct buffer *text, double ns)
{
    buffer_format(text, isfinite(ns) ? ns < 1000 ? "%.3g" : "%.0f" : "-", ns);
}

/* A sample lasts at least, all samples of one solve together at most, but one is always taken. */
static const struct protocol {
    int samples;
    double sample_seconds, budget_seconds;
} protocols[] = {
    [TIMING_OFF] = {0, 0, 0},
    [TIMING_QUICK] = {5, 2e-4, 0.02},
    [TIMING_FULL] = {TIMING_SAMPLES, 1e-3, 2.0},
};

/* One solver on the bench. */
struct timed_solver {
    struct solver *solver;
    int64_t batch;  /* solves a sample */
    double seconds; /* of a sample, expected */
    int quota;
    double sample[TIMING_SAMPLES];
    int samples;
};

/* Seconds for `batch` solves, each starting from a state that depends on the result of the one
 * before. */
static double time_batch(struct solver *s, int64_t batch, const struct cancel *cancel)
{
    double first = s->system->start[0];
    const int64_t begin = clock_ns();
    for (int64_t i = 0; i < batch; i++) {
        solver_start(s);
        s->y[0] = first;
        if (solver_run(s, NULL, cancel) != STOP_END)
            return NAN;
        /* Too small to change the number, but the processor must wait for it. */
        first = s->system->start[0] + 1e-300 * s->y[0];
    }
    return clock_seconds(begin);
}

static int quota(const struct protocol *protocol, double each, double seconds)
{
    const double max = fmin(each, protocol->budget_seconds) / seconds;
    return max >= protocol->samples ? protocol->samples : max > 1 ? (int)max : 1;
}

/* The same share of time for all, as large as the budget allows: only solves that take long lose
 * samples. */
static void share_out(struct timed_solver *bench, int count, const struct protocol *protocol,
                      double budget)
{
    double low = 0, high = protocol->budget_seconds;
    for (int turn = 0; turn < 40; turn++) {
        const double each = turn == 0 ? high : (low + high) / 2;
        double total = 0;
        for (int i = 0; i < count; i++)
            total += quota(protocol, each, bench[i].seconds) * bench[i].seconds;
        if (budget <= 0 || total <= budget)
            low = each;
        else
            high = each;
    }
    for (int i = 0; i < count; i++)
        bench[i].quota = quota(protocol, low, bench[i].seconds);
}

static void shuffle(int *order, int count, uint64_t *state)
{
    for (int i = count - 1; i > 0; i--) {
        const int j = (int)(random_fraction(state) * (i + 1)), keep = order[i];
        order[i] = order[j];
        order[j] = keep;
    }
}

static void summarize(struct timed_solver *bench, const struct protocol *protocol,
                      struct timing_result *result)
{
    if (bench->samples == 0)
        return;
    result->samples = bench->samples;
    result->few = bench->samples < protocol->samples;
    result->median = gsl_stats_median(bench->sample, 1, (size_t)bench->samples);
    result->minimum = bench->sample[0];
    for (int i = 0; i < bench->samples; i++)
        bench->sample[i] = fabs(bench->sample[i] - result->median);
    result->spread = gsl_stats_median(bench->sample, 1, (size_t)bench->samples) / result->median;
}

static void run_rounds(struct timed_solver *bench, int *order, int count,
                       const struct protocol *protocol, const struct cancel *cancel)
{
    uint64_t state = 88172645463325252u; /* the same order on every machine */
    for (int round = 0; round < protocol->samples; round++) {
        shuffle(order, count, &state);
        for (int i = 0; i < count && !cancelled(cancel); i++) {
            struct timed_solver *b = &bench[order[i]];
            const double seconds =
                b->samples < b->quota ? time_batch(b->solver, b->batch, cancel) : NAN;
            if (!isnan(seconds))
                b->sample[b->samples++] = seconds / (double)b->batch;
        }
    }
}

void time_solvers(struct solver *solver, struct timing_result *result, int count,
                  enum timing timing, double seconds, const struct cancel *cancel)
{
    const struct protocol *protocol = &protocols[timing];
    for (int i = 0; i < count; i++)
        result[i] = (struct timing_result){.minimum = NAN, .median = NAN, .spread = NAN};
    struct timed_solver *bench = calloc((size_t)count + 1, sizeof *bench);
    int *order = calloc((size_t)count + 1, sizeof *order);
    if (bench && order && protocol->samples > 0) {
        double warming = 0;
        for (int i = 0; i < count; i++) {
            const double once = time_batch(&solver[i], 1, cancel); /* warm-up */
            const bool short_one = once < protocol->sample_seconds;
            bench[i].solver = &solver[i];
            bench[i].batch =
                short_one ? (int64_t)(protocol->sample_seconds / fmax(once, 1e-8)) + 1 : 1;
            bench[i].seconds = fmax(once, 1e-8) * (double)bench[i].batch;
            warming += isnan(once) ? 0 : once;
            order[i] = i;
        }
        share_out(bench, count, protocol, seconds > 0 ? fmax(seconds - warming, 1e-9) : 0);
        run_rounds(bench, order, count, protocol, cancel);
        for (int i = 0; i < count; i++)
            summarize(&bench[i], protocol, &result[i]);
    }
    free(bench);
    free(order);
}
