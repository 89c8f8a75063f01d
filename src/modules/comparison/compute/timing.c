/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Measures how long solves take. Each solve starts from a state that depends on the last result,
 * several make one sample, and samples of all solvers are taken in random order. The clock is the
 * processor time of this thread, so that waiting for a processor does not count. */
#include "modules/comparison/compute/errors.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <fcntl.h>
#include <gsl/gsl_sort_double.h>
#include <gsl/gsl_statistics_double.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bool timing_is_sound(const struct timing_result *time)
{
    return !isnan(time->minimum) && time->samples >= TIMING_SAMPLES_MIN &&
           time->spread <= TIMING_SPREAD;
}

/* Writes how busy the machine was, if other threads ran beside the timed one. */
void timing_put_machine(double others, struct buffer *text)
{
    if (others > TIMING_OTHERS)
        buffer_format(
            text, "the machine is busy (%.2g other threads): times may be %.1f times too long\n",
            others, TIMING_CONTENTION);
}

double timing_step_ns(const struct timing_result *time, int64_t steps)
{
    return steps > 0 ? time->minimum / (double)steps * 1e9 : NAN;
}

/* Rules for each value of the setting `timing`. A sample lasts at least sample_seconds; all samples
 * of one solver together last at most budget_seconds, but TIMING_SAMPLES_MIN are always taken. */
static const struct protocol {
    int samples;
    double sample_seconds, budget_seconds;
} protocols[] = {
    [TIMING_OFF] = {0, 0, 0},
    [TIMING_QUICK] = {5, 2e-4, 0.02},
    [TIMING_FULL] = {TIMING_SAMPLES, 1e-3, 2.0},
};

/* Number of samples that may be added while the two shortest do not agree. */
enum { TIMING_SAMPLES_MORE = 10 };

/* A solver that is timed. */
struct timed_solver {
    struct solver *solver;
    int index;                                           /* index of the result */
    int64_t batch;                                       /* number of solves in a sample */
    double seconds;                                      /* [s] expected duration of a sample */
    int quota;                                           /* number of samples to take */
    double sample[TIMING_SAMPLES + TIMING_SAMPLES_MORE]; /* [samples] seconds per solve */
    int samples;
};

/* A step of a solve is at least two floating-point operations that wait for each other, of three
 * cycles each: 1 ns at 6 GHz. What seems to take less than half of that was not measured. */
static const double step_seconds_min = 0.5e-9;

/* Returns the processor time of `batch` solves, each starting from a state that depends on the
 * result of the one before; NAN if one fails. */
static double time_batch(struct solver *s, int64_t batch, const struct cancel *cancel)
{
    double first = s->system->start[0];
    const int64_t begin = clock_cpu_ns();
    for (int64_t i = 0; i < batch; i++) {
        solver_start(s);
        s->y[0] = first;
        if (solver_run(s, NULL, cancel) != STOP_END)
            return NAN;
        /* Too small to change the number, but the processor must wait for it. */
        first = s->system->start[0] + 1e-300 * s->y[0];
    }
    return (double)(clock_cpu_ns() - begin) * 1e-9;
}

/* Runs the solver to warm up, and finds how many solves make a sample. The number grows until a
 * sample is long enough, as a first solve may be slow for reasons of its own. A single solve longer
 * than first_sample_seconds needs no warming and becomes the first sample. Returns false if the
 * solve fails. */
static bool choose_batch(struct timed_solver *bench, double sample_seconds,
                         const struct cancel *cancel)
{
    static const double growth_max = 100, first_sample_seconds = 0.02;
    for (bench->batch = 1;;) {
        bench->seconds = time_batch(bench->solver, bench->batch, cancel);
        if (isnan(bench->seconds))
            return false;
        if (bench->seconds >= 0.7 * sample_seconds)
            break;
        const double factor = sample_seconds / fmax(bench->seconds, 1e-9);
        bench->batch = (int64_t)((double)bench->batch * fmin(fmax(factor, 1.5), growth_max)) + 1;
    }
    if (bench->batch == 1 && bench->seconds > first_sample_seconds)
        bench->sample[bench->samples++] = bench->seconds;
    return true;
}

/* Takes a sample; one that fails, as when cancelled, is dropped. */
static void add_sample(struct timed_solver *b, const struct cancel *cancel)
{
    const double seconds = time_batch(b->solver, b->batch, cancel);
    if (!isnan(seconds))
        b->sample[b->samples++] = seconds / (double)b->batch;
}

/* Sets the number of samples of each solver, fewer in proportion if all of them would take more
 * than `budget` [s], which 0 does not limit. */
static void set_quotas(struct timed_solver *bench, int count, const struct protocol *protocol,
                       double budget)
{
    double total = 0;
    for (int i = 0; i < count; i++)
        total += fmin(protocol->samples * bench[i].seconds, protocol->budget_seconds);
    const double share = budget > 0 && total > budget ? budget / total : 1;
    for (int i = 0; i < count; i++) {
        const double most =
            fmin(protocol->samples, protocol->budget_seconds / bench[i].seconds) * share;
        bench[i].quota = (int)fmin(fmax(most, TIMING_SAMPLES_MIN), protocol->samples);
    }
}

/* Permutes the indices at random. *state is that of the random numbers. */
static void shuffle_order(int *order, int count, uint64_t *state)
{
    for (int i = count - 1; i > 0; i--) {
        const int j = (int)(random_fraction(state) * (i + 1)), keep = order[i];
        order[i] = order[j];
        order[j] = keep;
    }
}

/* Sorts the samples and returns the relative difference of the second shortest from the shortest,
 * or HUGE_VAL for fewer than two. */
static double sample_disagreement(struct timed_solver *b)
{
    gsl_sort(b->sample, 1, (size_t)b->samples);
    return b->samples < 2 ? HUGE_VAL : b->sample[1] / b->sample[0] - 1;
}

/* Fills in the result from the samples; it stays NAN if there are none or if they are shorter than
 * a solve can be. */
static void summarize_samples(struct timed_solver *bench, const struct protocol *protocol,
                              struct timing_result *result)
{
    const int64_t steps = bench->solver->steps;
    if (bench->samples == 0)
        return;
    result->spread = sample_disagreement(bench);
    if (bench->sample[0] < step_seconds_min * (double)steps)
        return;
    result->samples = bench->samples;
    result->few = bench->samples < protocol->samples;
    result->minimum = bench->sample[0];
    result->median = gsl_stats_median_from_sorted_data(bench->sample, 1, (size_t)bench->samples);
}

/* Returns how many other threads of the machine run or wait for a processor right now, or 0 where
 * the system does not tell. */
static int others_running(void)
{
    /* "0.31 0.24 0.20 3/812 12345": 3 threads run, this one among them */
    char line[128];
    const int fd = open("/proc/loadavg", O_RDONLY | O_CLOEXEC);
    const ssize_t got = fd >= 0 ? read(fd, line, sizeof line - 1) : 0;
    int running = 0;
    if (fd >= 0)
        close(fd);
    line[got > 0 ? got : 0] = '\0';
    const char *slash = strchr(line, '/');
    if (!slash)
        return 0;
    const char *number = slash;
    while (number > line && number[-1] >= '0' && number[-1] <= '9')
        number--;
    for (; number < slash; number++)
        running = 10 * running + (*number - '0');
    return running > 1 ? running - 1 : 0;
}

/* Takes the samples of all solvers, in rounds of random order, and further ones of those whose
 * shortest samples disagree. Returns the mean number of other threads that ran meanwhile. */
static double run_rounds(struct timed_solver *bench, int *order, int count,
                         const struct protocol *protocol, const struct cancel *cancel)
{
    double others = others_running();
    uint64_t state = 88172645463325252u; /* the same order on every machine */
    for (int round = 0; round < protocol->samples; round++) {
        shuffle_order(order, count, &state);
        for (int i = 0; i < count && !cancelled(cancel); i++)
            if (bench[order[i]].samples == round && round < bench[order[i]].quota)
                add_sample(&bench[order[i]], cancel);
        others += others_running();
    }
    for (int round = 0; round < TIMING_SAMPLES_MORE; round++)
        for (int i = 0; i < count && !cancelled(cancel); i++)
            if (bench[i].samples >= TIMING_SAMPLES_MIN &&
                sample_disagreement(&bench[i]) > TIMING_SPREAD)
                add_sample(&bench[i], cancel);
    return others / (protocol->samples + 1);
}

/* Times solvers side by side, in rounds of random order. */
void time_solvers(struct solver *solver, struct timing_result *result, int count,
                  enum timing timing, double seconds, const struct cancel *cancel)
{
    const struct protocol *protocol = &protocols[timing];
    for (int i = 0; i < count; i++)
        result[i] = (struct timing_result){.minimum = NAN, .median = NAN, .spread = NAN};
    struct timed_solver *bench = calloc((size_t)count + 1, sizeof *bench);
    int *order = calloc((size_t)count + 1, sizeof *order), timed = 0;
    if (bench && order && protocol->samples > 0) {
        const int64_t begin = clock_cpu_ns();
        for (int i = 0; i < count; i++) {
            bench[timed].solver = &solver[i];
            bench[timed].index = i;
            if (choose_batch(&bench[timed], protocol->sample_seconds, cancel)) {
                order[timed] = timed;
                timed++;
            }
        }
        const double warming = (double)(clock_cpu_ns() - begin) * 1e-9;
        set_quotas(bench, timed, protocol, seconds > 0 ? fmax(seconds - warming, 1e-9) : 0);
        const double others = run_rounds(bench, order, timed, protocol, cancel);
        for (int i = 0; i < timed; i++) {
            summarize_samples(&bench[i], protocol, &result[bench[i].index]);
            result[bench[i].index].others = others;
        }
    }
    free(bench);
    free(order);
}
