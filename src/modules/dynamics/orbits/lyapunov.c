/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lyapunov exponents (lyapunov_find): means of the tangents' growth over bins of equal time, their
 * errors, and checks that they must satisfy. */
#include "modules/dynamics/chaos.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "modules/dynamics/orbits/average.h"
#include "modules/dynamics/orbits/dimension.h"
#include "modules/dynamics/orbits/tangents.h"

#define EVALUATIONS_DEFAULT 2000000 /* evaluations if no duration is given */
#define PILOT_DIVISOR 10            /* one part in this number of them precedes the averages */
#define TIME_BINS_MIN 4096          /* number of bins; for a drive there may be twice as many */
#define BIN_STEPS 16                /* smallest number of steps in a bin, if steps are known */
#define FORCED_BINS 512             /* smallest number of bins for a drive */
#define MAP_PERIODS 8               /* periods over which the map is examined */
#define AT_REST 1e-9 /* rate, relative to the largest exponent, below which the motion rests */
/* Volumes are conserved if their rate is below this part of the largest exponent. */
#define VOLUME_ROUNDING 1e-12

/* State of lyapunov_find(). */
struct exponents_search {
    const struct lyapunov_request *request;
    struct lyapunov *found;
    struct tangents t;
    double t0, period;     /* [s] start, and period of the drive or 0 */
    bool timed;            /* driven, but not periodically */
    int parts, times;      /* A bin is 1/parts or `times` periods. */
    double bin;            /* [s] length of a bin */
    size_t bins, done;     /* number of bins, and of finished ones */
    double *series;        /* [count + 1][bins]: exponents, divergence; then as many for work */
    enum tangents_end end; /* reason why the last advance has ended */
};

/* Advances by `span` [s]. Returns false, with s->end, if that is not possible. */
static bool advance_tangents(struct exponents_search *s, double t_begin, double span)
{
    s->end = tangents_advance(&s->t, t_begin, span);
    tangents_unwind(&s->t);
    return s->end == TANGENTS_OK;
}

/* Reports the fraction that is done; 2 ends the report. */
static void report_exponents(const struct exponents_search *s, double fraction)
{
    if (s->request->progress)
        s->request->progress(s->request->context, fraction);
}

/* Returns the largest of 1, 2 or 5 times a power of ten that is at most x. */
static double round_down(double x)
{
    const double power = pow(10, floor(log10(x) + 1e-9)), digit = x / power;
    if (digit >= 5 * (1 - 1e-9))
        return power * 5;
    return digit >= 2 * (1 - 1e-9) ? power * 2 : power;
}

/* ---- the time before averages are taken ---- */

/* Returns the time [s] in which a variable changes by its natural size at the present state. */
static double state_timescale(const struct exponents_search *s)
{
    const struct system *system = &s->t.field.system;
    double rate[LIMIT_VARIABLES], most = 0;
    system_derivative(system, s->t0, s->t.y, rate);
    for (int i = 0; i < s->t.n; i++)
        most = fmax(most, fabs(rate[i]) / s->t.field.size[i]);
    return most > 0 && isfinite(1 / most) ? 1 / most : 1;
}

/* Advances for a tenth of the default number of evaluations, when no time was given. Returns false
 * if the motion ends or if cancelled. */
static bool advance_default(struct exponents_search *s)
{
    double span = s->period > 0 ? s->period : state_timescale(s);
    while (tangents_evals(&s->t) < EVALUATIONS_DEFAULT / PILOT_DIVISOR) {
        if (!advance_tangents(s, s->timed ? s->t0 + s->t.elapsed : s->t0, span))
            return false;
        report_exponents(s, (double)tangents_evals(&s->t) / EVALUATIONS_DEFAULT);
        if (!(s->period > 0) && 4 * tangents_evals(&s->t) < EVALUATIONS_DEFAULT / PILOT_DIVISOR)
            span *= 2;
    }
    return true;
}

/* Advances for the time `skip` [s], or for whole periods of the drive. Returns false if the motion
 * ends or if cancelled. */
static bool advance_skip(struct exponents_search *s, double skip)
{
    double pieces = 32, span = skip / pieces;
    if (s->period > 0) {
        pieces = ceil(skip / s->period * (1 - 1e-12));
        span = s->period;
    }
    for (double i = 0; i < pieces && skip > 0; i++) {
        if (!advance_tangents(s, s->timed ? s->t0 + s->t.elapsed : s->t0, span))
            return false;
        report_exponents(s, 0.1 * i / pieces);
    }
    return true;
}

/* Sets the length and number of bins from the duration asked for. */
static void choose_bins(struct exponents_search *s, double duration)
{
    const double step = s->t.steps > 0 ? s->t.elapsed / (double)s->t.steps : 0;
    s->parts = s->times = 1;
    if (s->period > 0) {
        const double periods = fmax(1, round(duration / s->period));
        if (periods < FORCED_BINS)
            s->parts = (int)ceil(FORCED_BINS / periods);
        if (s->parts > 1 && step > 0)
            s->parts = (int)fmax(1, fmin(s->parts, floor(s->period / step / BIN_STEPS)));
        if (periods > TIME_BINS_MIN)
            s->times = (int)(periods / TIME_BINS_MIN);
        s->bins = (size_t)(periods * s->parts / s->times);
        s->bin = s->period * s->times / s->parts;
        return;
    }
    const double fine = step > 0 ? duration / step / BIN_STEPS : TIME_BINS_MIN / 4;
    s->bins = (size_t)fmax(2 * AVERAGE_BATCHES, fmin(TIME_BINS_MIN, floor(fine)));
    s->bin = duration / (double)s->bins;
}

/* Advances to the state from which means are taken, and sets the duration and the bins. Returns
 * false if the motion ends, if cancelled or if out of memory. */
static bool begin_exponents(struct exponents_search *s)
{
    const struct lyapunov_request *r = s->request;
    double duration = r->duration;
    const double skip = r->skip >= 0 ? r->skip : duration / 10;
    const bool unasked = duration == 0 && r->skip < 0;
    if (!(unasked ? advance_default(s) : advance_skip(s, skip)))
        return false;
    s->found->skip = s->t.elapsed;
    if (duration == 0 && !unasked && !advance_default(s))
        return false;
    if (duration == 0) {
        const double unit = s->period > 0 ? s->period : 1;
        duration = unit * round_down((PILOT_DIVISOR - 1) * s->t.elapsed / unit);
        s->found->skip = s->t.elapsed;
    }
    choose_bins(s, duration);
    s->series = malloc(2 * (size_t)(s->t.count + 1) * s->bins * sizeof *s->series);
    return s->series;
}

/* ---- the time that averages are taken over ---- */

/* Advances through bin b and stores its mean rates. Returns false if the motion ends or if
 * cancelled. */
static bool advance_bin(struct exponents_search *s, size_t b)
{
    struct tangents *t = &s->t;
    bool fine = true;
    memset(t->growth, 0, sizeof t->growth);
    t->divergence = 0;
    for (int k = 0; fine && k < s->times; k++) {
        const double part = (double)(b % (size_t)s->parts);
        if (s->period > 0)
            fine = advance_tangents(s, s->t0 + part * s->period / s->parts, s->period / s->parts);
        else
            fine = advance_tangents(s, s->timed ? s->t0 + t->elapsed : s->t0, s->bin);
    }
    for (int j = 0; fine && j < t->count; j++)
        s->series[(size_t)j * s->bins + b] = t->growth[j] / s->bin;
    if (fine)
        s->series[(size_t)t->count * s->bins + b] = t->divergence / s->bin;
    return fine;
}

/* Advances through all bins. Returns false if the motion ends or if cancelled. */
static bool advance_all_bins(struct exponents_search *s)
{
    for (s->done = 0; s->done < s->bins; s->done++) {
        if (!advance_bin(s, s->done))
            return false;
        if (s->done % 16 == 0)
            report_exponents(s, 0.1 + 0.9 * (double)s->done / (double)s->bins);
    }
    return true;
}

/* ---- exponents from the bins ---- */

/* Computes the Kaplan-Yorke dimension and its error, from the series that its derivatives combine.
 * order [count] are the indices of the sorted exponents. */
static void find_dimension(const struct exponents_search *s, const int *order)
{
    struct lyapunov *f = s->found;
    double slope[FIELD_VARIABLES], size = fabs(f->divergence) / f->n;
    f->dimension = (struct exponent){NAN, NAN};
    if (!f->determined)
        return;
    for (int i = 0; i < f->count; i++)
        size = fmax(size, fabs(f->exponent[i].value));
    if (f->count == f->n && f->divergence >= -VOLUME_ROUNDING * size) {
        f->dimension = (struct exponent){f->n, 0};
        return;
    }
    assert(s->series);
    f->dimension = (struct exponent){kaplan_yorke(f->exponent, f->count, f->n, size, slope), 0};
    double *mixed = s->series + (size_t)(f->count + 1) * s->bins;
    memset(mixed, 0, s->done * sizeof *mixed);
    for (int i = 0; i < f->count; i++) {
        f->dimension.error += f->regular ? fabs(slope[i]) * f->exponent[i].error : 0;
        for (size_t b = 0; b < s->done; b++)
            mixed[b] += slope[i] * s->series[(size_t)order[i] * s->bins + b];
    }
    if (!f->regular)
        f->dimension.error = average_scatter(mixed, s->done, f->batches);
}

/* Returns true if the motion has come to rest at an equilibrium. */
static bool has_come_to_rest(const struct exponents_search *s)
{
    double most = 1 / s->found->time;
    for (int j = 0; j < s->found->count; j++)
        most = fmax(most, fabs(s->found->exponent[j].value));
    return !s->timed && s->period == 0 && 1 / state_timescale(s) < AT_REST * most;
}

/* Sorts the exponents by falling value; order [count] becomes their indices before. */
static void exponents_sort(struct lyapunov *f, int *order)
{
    for (int i = 0; i < f->count; i++) {
        const struct exponent e = f->exponent[i];
        int j = i;
        for (; j > 0 && f->exponent[j - 1].value < e.value; j--) {
            f->exponent[j] = f->exponent[j - 1];
            order[j] = order[j - 1];
        }
        f->exponent[j] = e;
        order[j] = i;
    }
}

/* Computes all results from the finished bins. */
static void evaluate_exponents(struct exponents_search *s)
{
    struct lyapunov *f = s->found;
    const int count = f->count;
    double *scratch = s->series + (size_t)(count + 1) * s->bins, size = 0;
    struct average average[FIELD_VARIABLES + 1];
    int order[FIELD_VARIABLES];
    f->regular = f->determined = s->done > 0;
    f->batches = AVERAGE_MOST;
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j <= count; j++) {
            average_find(s->series + (size_t)j * s->bins, s->done, size, scratch, &average[j]);
            size = pass == 0 ? fmax(size, fabs(average[j].mean)) : size;
        }
    for (int j = 0; j < count; j++) {
        f->regular = f->regular && average[j].regular;
        f->determined = f->determined && average[j].batches >= AVERAGE_BATCHES;
        f->batches = average[j].batches < f->batches ? average[j].batches : f->batches;
    }
    f->determined = f->determined || f->regular;
    f->time = (double)s->done * s->bin;
    f->divergence = f->regular ? average[count].smooth : average[count].mean;
    f->sum = 0;
    for (int j = 0; j < count; j++)
        f->sum += f->regular ? average[j].smooth : average[j].mean;
    /* If volumes are known, the sum shows the error of the steps. Tangents that grow as powers of
     * the time have rates of about 1/time. */
    const double steps = fmax(count == f->n ? fabs(f->sum - f->divergence) : 0, TANGENT_TOL * size);
    for (int j = 0; j < count; j++) {
        const struct average *a = &average[j];
        f->exponent[j] = f->regular ? (struct exponent){a->smooth, a->spread + steps}
                                    : (struct exponent){a->mean, hypot(a->error, 1 / f->time)};
    }
    exponents_sort(f, order);
    f->rests = s->done > 0 && has_come_to_rest(s);
    find_dimension(s, order);
}

/* Returns the largest difference [1/s] between exponents by the flow and by derivatives of the
 * stroboscopic map, over MAP_PERIODS periods from the same states and tangents; NAN if one cannot
 * be computed. */
static double compare_with_map(struct exponents_search *s)
{
    struct tangents *t = &s->t;
    const int n = t->n, count = t->count;
    double deviation[FIELD_VARIABLES] = {0}, worst = 0;
    for (int k = 0; k < MAP_PERIODS; k++) {
        struct flow_slopes slopes;
        double end[FIELD_VARIABLES], column[FIELD_VARIABLES * FIELD_VARIABLES] = {0},
                                                              diagonal[FIELD_VARIABLES];
        if (!field_flow(&t->field, s->t0, t->y, s->period, end, &slopes))
            return NAN;
        for (int j = 0; j < count; j++)
            for (int i = 0; i < n; i++)
                for (int l = 0; l < n; l++)
                    column[n * j + i] +=
                        slopes.by_start[i * n + l] * t->y[n * (j + 1) + l] / t->field.size[l];
        tangents_orthonormalise(n, count, column, diagonal);
        memset(t->growth, 0, sizeof t->growth);
        if (!advance_tangents(s, s->t0, s->period))
            return NAN;
        for (int j = 0; j < count; j++)
            deviation[j] += t->growth[j] - log(diagonal[j]);
    }
    for (int j = 0; j < count; j++)
        worst = fmax(worst, fabs(deviation[j]) / (MAP_PERIODS * s->period));
    return worst;
}

/* Returns the reason why the exponents are not determined or end early, or NULL. */
static const char *reason_of(const struct exponents_search *s)
{
    switch (s->end) {
    case TANGENTS_LEAVE:
        return "the motion escapes to infinity";
    case TANGENTS_JUMP:
        return "the equations jump, so tangents are unknown";
    case TANGENTS_STALL:
        return "no further step is possible";
    case TANGENTS_CANCELLED:
        return "stopped";
    case TANGENTS_OK:
        break;
    }
    return s->found->determined ? NULL : "the time is too short for 10 independent batches";
}

/* Lets the motion settle, averages over bins, compares with the stroboscopic map, and evaluates. */
bool lyapunov_find(const struct lyapunov_request *request, struct lyapunov *found,
                   struct error *error)
{
    const int64_t start_time = clock_ns();
    struct exponents_search *s = calloc(1, sizeof *s); /* large */
    *found = (struct lyapunov){.strobe = NAN};
    if (!s)
        return error_memory(error);
    s->request = request;
    s->found = found;
    if (!tangents_init(&s->t, request->scene, request->count, request->cancel, error)) {
        free(s);
        return false;
    }
    const struct system *system = &s->t.variation.base;
    found->n = s->t.n;
    found->count = s->t.count;
    found->period = field_drive(&s->t.field);
    found->conservative = system->conservative;
    s->t0 = system->t0;
    s->period = found->period > 0 ? found->period : 0;
    s->timed = isnan(found->period);
    if (begin_exponents(s) && advance_all_bins(s) && s->period > 0 && s->t.condition < 1e6)
        found->strobe = compare_with_map(s);
    const bool fine = s->series || s->end != TANGENTS_OK;
    found->condition = s->t.condition;
    for (int j = 0; j < found->count; j++)
        found->exponent[j] = (struct exponent){NAN, NAN};
    if (s->done > 0)
        evaluate_exponents(s);
    if (s->end == TANGENTS_LEAVE || s->end == TANGENTS_JUMP)
        found->determined = false;
    found->cancelled = s->end == TANGENTS_CANCELLED;
    found->reason = reason_of(s);
    found->method = s->t.method ? s->t.method->row.name : "";
    found->tol = s->t.controller.tol;
    found->evals = tangents_evals(&s->t) + s->t.field.evals;
    found->seconds = clock_seconds(start_time);
    report_exponents(s, 2);
    free(s->series);
    tangents_free(&s->t);
    free(s);
    return fine || error_memory(error);
}
