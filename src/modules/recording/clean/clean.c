/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Faults of a recording, found without a model of the whole. Only single samples that cannot belong
 * to the motion are masked; other faults are reported and left to the user. Flat tops are kept,
 * because fits treat them as censored. */
#include "modules/recording/clean/clean.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <math.h>
#include <stdio.h>

#define FAR_OFF 6.0               /* robust standard deviations of a bad sample */
#define FAR_OFF_BESIDE 3.0        /* the same next to a bad sample, on the same side */
#define FAR_OFF_MIN 0.01          /* [amplitudes] smaller deviations are harmless */
#define GAP_MEDIAN_STEPS 1.5      /* median steps, as the loader counts them */
#define SHOULDER_MIN 3            /* consecutive samples of a shoulder; fewer are spikes */
#define STUCK_MIN 5               /* consecutive equal samples */
#define STUCK_MOVES 8.0           /* noises or steps by which the motion goes on meanwhile */
#define AMPLITUDE_SEEN_SCALES 6.0 /* typical scales from which on an amplitude is no noise */
#define LEVELS_FEW 100            /* levels in the swing below which the steps are coarse */

/* Records the size of a fault if it is the largest of its kind. */
static void note_size(struct finding *finding, double size)
{
    finding->size = fmax(isnan(finding->size) ? 0 : finding->size, size);
}

/* ---- times ---- */

/* Computes the median step and notes longer steps as gaps. */
static void find_gaps(struct cleaning *c)
{
    struct finding *gaps = &c->findings->finding[FINDING_GAPS];
    for (size_t i = 0; i + 1 < c->n; i++)
        c->sorted[i] = c->t[i + 1] - c->t[i];
    c->step = values_quantile(c->sorted, c->n - 1, 0.5);
    for (size_t i = 0; i + 1 < c->n; i++)
        if (c->t[i + 1] - c->t[i] > GAP_MEDIAN_STEPS * c->step) {
            clean_note(gaps, c->t[i], 1);
            note_size(gaps, c->t[i + 1] - c->t[i]);
        }
}

/* Notes missing values, and what the loader has dropped. */
static void find_missing(struct cleaning *c)
{
    struct finding *missing = &c->findings->finding[FINDING_MISSING];
    for (size_t i = 0; i < c->n; i++) {
        if (!isnan(c->y[i]))
            continue;
        c->excluded[i] = 1;
        missing->count++;
        if (i == 0 || !c->excluded[i - 1])
            clean_note(missing, c->t[i], 0);
    }
    c->findings->finding[FINDING_REPEATED].count = c->recording->repeated;
    c->findings->finding[FINDING_BACKWARD].count = c->recording->backward;
}

/* ---- values ---- */

/* Finds the sensor's step, of which nearly all differences are multiples, in the numbers of the
 * file. */
static void find_steps(struct cleaning *c)
{
    const struct column *column = &c->recording->column[c->recording->value];
    double quantum = HUGE_VAL, previous = NAN;
    size_t n = 0;
    for (size_t i = 0; i < c->n; i++) {
        const double now = column->value[i], step = fabs(now - previous);
        if (isnan(c->y[i]))
            continue;
        quantum = step > 0 && step < quantum ? step : quantum;
        previous = now;
        c->sorted[n++] = c->y[i];
    }
    c->sorted_count = n;
    if (n == 0 || !sort_values(c->sorted, n, c->residual, c->cancel))
        return;
    c->swing = c->sorted[(size_t)(0.995 * (double)(n - 1) + 0.5)] -
               c->sorted[(size_t)(0.005 * (double)(n - 1) + 0.5)];
    previous = NAN;
    for (size_t i = 0, others = 0; i < c->n; i++) {
        const double multiple = (column->value[i] - previous) / quantum;
        others += fabs(multiple - nearbyint(multiple)) > 0.01;
        if (100 * others > n)
            return;
        previous = isnan(c->y[i]) ? previous : column->value[i];
    }
    c->quantum = isfinite(quantum) ? quantum * fabs(column->factor) : 0;
    if (c->quantum * LEVELS_FEW > c->swing && c->quantum < c->swing) {
        struct finding *steps = &c->findings->finding[FINDING_QUANTISED];
        steps->count = n;
        steps->size = c->quantum;
    }
}

/* Marks equal values in a row while the motion continues, or for half a period if there is noise
 * elsewhere; not at the ends, where the body may rest. The first of them may be right. */
static void find_stuck(struct cleaning *c)
{
    const double min = STUCK_MOVES * fmax(c->typical, c->quantum);
    for (size_t first = 0, stop; first < c->n; first = stop) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (stop = first; stop < c->n && (stop == first || c->y[stop] == c->y[first]); stop++) {
            low = c->model[stop] < low ? c->model[stop] : low;
            high = c->model[stop] > high ? c->model[stop] : high;
        }
        const bool end = first == 0 || stop == c->n, many = stop - first >= STUCK_MIN;
        const bool lasts =
            c->t[stop - 1] - c->t[first] > 0.5 * c->period && c->typical > c->quantum;
        if (end || !many || c->excluded[first] || !(high - low > min || lasts))
            continue;
        for (size_t i = first + 1; i < stop; i++) {
            c->findings->mask[i] = 1 + FINDING_STUCK;
            c->excluded[i] = 1;
        }
    }
}

/* ---- the ends ---- */

/* Returns the k-th stretch from one end. */
static const struct local *from_end(const struct cleaning *c, bool end, size_t k)
{
    return &c->local[end ? c->locals - 1 - k : k];
}

/* Returns the usual factor by which the visible amplitude falls in a period. */
static double usual_fall(struct cleaning *c)
{
    const double min = AMPLITUDE_SEEN_SCALES * c->typical;
    size_t n = 0;
    for (size_t k = 0; k + 1 < c->locals; k++)
        if (c->local[k].fitted && c->local[k + 1].fitted && c->local[k].amplitude > min)
            c->per_local[n++] = c->local[k + 1].amplitude / c->local[k].amplitude;
    return n > 0 ? fmin(values_quantile(c->per_local, n, 0.5), 1) : 1;
}

/* Returns the number of samples of a stretch that are far off its fit. */
static size_t count_far_off(const struct cleaning *c, const struct local *local)
{
    size_t count = 0;
    const double min = FAR_OFF * fmax(c->typical, local->scale);
    for (size_t i = local->begin; i < local->end; i++)
        count += !c->excluded[i] && fabs(c->residual[i]) > min;
    return count;
}

/* Returns true for a stretch that has samples (no gap), but too few good ones for a fit. */
static bool lacks_good_samples(const struct cleaning *c, const struct local *local)
{
    return !local->fitted && 2 * (double)(local->end - local->begin) * c->step > c->period;
}

/* Returns the smallest ratio (at most 1) of a period's amplitude to larger ones on both sides. In
 * motion that waxes and wanes, such as beats, a small amplitude at an end is no disturbance. */
static double deepest_wane(struct cleaning *c)
{
    double peak = 0, next_max = 0, deepest = 1;
    for (size_t k = c->locals; k-- > 0;) {
        c->per_local[k] = next_max;
        next_max = fmax(next_max, c->local[k].fitted ? c->local[k].amplitude : 0);
    }
    for (size_t k = 0; k < c->locals; k++) {
        const double nearby = fmin(peak, c->per_local[k]), here = c->local[k].amplitude;
        if (!c->local[k].fitted)
            continue;
        deepest =
            nearby > AMPLITUDE_SEEN_SCALES * c->typical ? fmin(deepest, here / nearby) : deepest;
        peak = fmax(peak, here);
    }
    return deepest;
}

/* Returns how many periods at the start (or, with `end`, at the end) of the recording are not a
 * free oscillation: their amplitude is much smaller than further inside, no sine fits or, with
 * `rests`, the motion has come to rest. `fall` is the usual ratio of amplitudes of successive
 * periods. Periods with too few samples for a fit count only if so many at the end would be
 * improbable by chance. Returns 0 if two thirds or more would be bad. */
static size_t bad_stretches(struct cleaning *c, bool end, bool rests, double fall)
{
    const double wane = deepest_wane(c);
    static const double chance_max = 0.05;
    size_t bad = 0, lacking = 0, lacking_there = 0;
    double largest = 0;
    for (size_t k = 0; k < c->locals; k++) {
        largest = fmax(largest, c->local[k].fitted ? c->local[k].amplitude : 0);
        lacking += lacks_good_samples(c, &c->local[k]);
    }
    for (; 3 * bad < 2 * c->locals; bad++) {
        const struct local *s = from_end(c, end, bad);
        double inside = 0, faded = 1;
        for (size_t k = bad + 1; k < c->locals && k < bad + 12; k++) {
            const struct local *other = from_end(c, end, k);
            faded *= end ? fall : 1;
            inside = fmax(inside, other->fitted ? faded * other->amplitude : 0);
        }
        if (!s->fitted) {
            lacking_there += lacks_good_samples(c, s);
            continue;
        }
        const bool still = s->amplitude < fmin(0.6, 0.8 * wane) * inside &&
                           inside > AMPLITUDE_SEEN_SCALES * c->typical;
        const bool rough = s->scale > fmax(0.3 * s->amplitude, 5 * c->typical) ||
                           4 * count_far_off(c, s) > s->end - s->begin;
        const bool gone =
            rests && s->amplitude < fmax(0.5 * fmax(s->scale, c->quantum), 0.002 * largest);
        if (!still && !rough && !gone)
            break;
    }
    const double share_inside = (double)(lacking - lacking_there) / (double)(c->locals - bad);
    if (lacking_there == bad && pow(share_inside, (double)bad) > chance_max)
        return 0;
    return 3 * bad < 2 * c->locals ? bad : 0;
}

/* Sets the window and notes what lies outside. */
static void find_ends(struct cleaning *c)
{
    const double fall = usual_fall(c);
    const struct motion_rows rows = {c->t, c->y, c->excluded, 0, c->n};
    const size_t rest = motion_rest(&rows, c->period);
    const size_t leading = bad_stretches(c, false, false, fall),
                 trailing = bad_stretches(c, true, rest < c->n, fall);
    if (leading + trailing >= c->locals)
        return;
    const size_t begin = leading > 0 ? c->local[leading].begin : 0;
    const size_t last = trailing > 0 ? c->local[c->locals - 1 - trailing].end : c->n;
    const size_t end = rest < c->n && rest > begin ? rest : last;
    c->findings->rests = end == rest && rest < c->n ? c->t[rest] : NAN;
    c->findings->window[0] = c->t[begin];
    c->findings->window[1] = c->t[end - 1];
    if (begin > 0)
        clean_note(&c->findings->finding[FINDING_START], c->t[0], begin);
    if (end < c->n)
        clean_note(&c->findings->finding[FINDING_END], c->t[end], c->n - end);
}

/* ---- bad echoes ---- */

/* Sets findings->mask to `mark` for samples far off the local fit, and for their neighbours on the
 * same side. A strong decay is off the linear amplitude of the fit: by half the square of its
 * change in a period, twice that at the ends, where the fit is one-sided. That is allowed. */
static void mark_far_off(struct cleaning *c, unsigned char mark)
{
    unsigned char *mask = c->findings->mask;
    const double loss = -log(usual_fall(c));
    for (size_t k = 0; k < c->locals; k++) {
        const struct local *s = &c->local[k];
        const double scale = fmax(s->scale, c->typical),
                     here = hypot(s->parameter[4], s->parameter[5]) / s->amplitude,
                     change = fmax(loss, s->fitted ? fmin(here, 1) : 0),
                     bend = 0.5 * change * change;
        const double allowance = k == 0 || k + 1 == c->locals ? 2 * bend : bend;
        const double min = fmax(
            FAR_OFF * scale, fmax(fmax(FAR_OFF_MIN, allowance) * s->amplitude, 1.5 * c->quantum));
        const double neighbour_min = FAR_OFF_BESIDE / FAR_OFF * min;
        for (size_t i = s->begin; i < s->end && s->fitted; i++) {
            const double r = c->residual[i];
            if (c->excluded[i] || !(fabs(r) > min))
                continue;
            mask[i] = mark;
            for (size_t j = i; j-- > 0 && !mask[j] && !c->excluded[j] &&
                               r * c->residual[j] > neighbour_min * fabs(r);)
                mask[j] = mark;
            for (size_t j = i + 1;
                 j < c->n && !c->excluded[j] && r * c->residual[j] > neighbour_min * fabs(r); j++)
                mask[j] = mark;
        }
    }
}

/* Moves the window inward past a hand or a release: at least SHOULDER_MIN marked samples at its
 * ends. */
static void trim_ends(struct cleaning *c)
{
    struct findings *f = c->findings;
    size_t first = 0, last = c->n - 1, begin, end;
    while (c->t[first] < f->window[0])
        first++;
    while (c->t[last] > f->window[1])
        last--;
    for (begin = first; begin < last && f->mask[begin]; begin++)
        ;
    for (end = last; end > begin && f->mask[end]; end--)
        ;
    if (begin - first >= SHOULDER_MIN) {
        f->finding[FINDING_START].stretches = 0;
        clean_note(&f->finding[FINDING_START], c->t[0], begin - first);
        f->window[0] = c->t[begin];
    }
    if (last - end >= SHOULDER_MIN) {
        f->finding[FINDING_END].stretches = 0;
        clean_note(&f->finding[FINDING_END], c->t[end + 1], last - end);
        f->window[1] = c->t[end];
    }
}

/* Counts and names the masked stretches inside the window; outside, marks are removed. */
static void count_masked(struct cleaning *c)
{
    struct findings *f = c->findings;
    const unsigned char any = 1 + FINDING_SPIKES;
    for (size_t begin = 0, end; begin < c->n; begin = end) {
        const unsigned char kind = f->mask[begin];
        const double r = c->residual[begin];
        for (end = begin + 1;
             end < c->n && f->mask[end] == kind && (kind != any || r * c->residual[end] > 0);)
            end++;
        const bool outside = c->t[begin] < f->window[0] || c->t[end - 1] > f->window[1];
        if (kind == 0)
            continue;
        const bool is_shoulder = end - begin >= SHOULDER_MIN;
        const enum finding_kind own = is_shoulder ? FINDING_SHOULDERS : FINDING_SPIKES;
        const enum finding_kind found = kind != any ? (enum finding_kind)(kind - 1) : own;
        for (size_t i = begin; i < end; i++) {
            f->mask[i] = outside ? 0 : (unsigned char)(1 + found);
            if (!outside && found != FINDING_STUCK)
                note_size(&f->finding[found], fabs(c->residual[i]));
        }
        if (outside)
            continue;
        clean_note(&f->finding[found], c->t[begin], end - begin);
        f->masked += end - begin;
    }
}

/* ---- sway ---- */

#define SWAY_MIN 0.015 /* relative rms of a sway that is noted */
/* Stretches needed to see a sway. */
#define SWAY_STRETCHES 6
#define SWAY_TURNS 4 /* fewer sign changes may be a law of drag */

/* Subtracts from y [n] its projection on the basis vector. */
static void subtract_projection(double *y, const double *basis, size_t n)
{
    double projection = 0, square = 0;
    for (size_t i = 0; i < n; i++) {
        projection += y[i] * basis[i];
        square += basis[i] * basis[i];
    }
    for (size_t i = 0; i < n; i++)
        y[i] -= square > 0 ? projection / square * basis[i] : 0;
}

/* Notes a sway: the scatter of ln(local amplitude) about a parabola in time, if it exceeds the
 * noise. Returns false if out of memory. */
static bool find_sway(struct cleaning *c)
{
    struct findings *f = c->findings;
    double *y = arena_array(c->scratch, 4 * c->locals, sizeof *y), *one = y + c->locals,
           *line = one + c->locals, *curve = line + c->locals, first = NAN, last = NAN, square = 0,
           expected = 0;
    size_t n = 0, turns = 0;
    if (!y)
        return false;
    for (size_t k = 0; k < c->locals; k++) {
        const struct local *s = &c->local[k];
        if (!s->fitted || !(s->amplitude > 0) || s->t < f->window[0] || s->t > f->window[1])
            continue;
        const double noise = s->scale / s->amplitude;
        expected += noise * noise / fmax((double)(s->end - s->begin), 1);
        y[n] = log(s->amplitude);
        one[n] = 1;
        line[n] = s->t - c->t[0];
        curve[n] = line[n] * line[n];
        first = n++ == 0 ? s->t : first;
        last = s->t;
    }
    if (n < SWAY_STRETCHES)
        return true;
    subtract_projection(line, one, n);
    subtract_projection(curve, one, n);
    subtract_projection(curve, line, n);
    subtract_projection(y, one, n);
    subtract_projection(y, line, n);
    subtract_projection(y, curve, n);
    for (size_t i = 0; i < n; i++) {
        square += y[i] * y[i];
        turns += i > 0 && y[i] * y[i - 1] < 0;
    }
    const double sway = sqrt(square / (double)(n - 3)), noise = sqrt(expected / (double)n);
    if (sway > SWAY_MIN && sway > 3 * noise && turns >= SWAY_TURNS) {
        clean_note(&f->finding[FINDING_SWAY], first, n);
        f->finding[FINDING_SWAY].size = sway;
        f->sway_period = 2 * (last - first) / (double)turns;
    }
    return true;
}

/* ---- all of it ---- */

/* Finds the faults that need a period. Returns false if out of memory or cancelled. */
static bool inspect_motion(struct cleaning *c)
{
    if (!clean_fit(c))
        return false;
    clean_clipped(c, true);
    clean_clipped(c, false);
    find_stuck(c);
    if (cancelled(c->cancel) || !clean_fit(c)) /* discards what was found so far */
        return false;
    find_ends(c);
    mark_far_off(c, 1 + FINDING_SPIKES);
    trim_ends(c);
    count_masked(c);
    return !cancelled(c->cancel) && find_sway(c);
}

/* Finds all faults of a recording. Returns false if out of memory or cancelled. */
static bool find_all_faults(struct recording *recording, double period, struct findings *f,
                            struct arena *scratch)
{
    const size_t n = recording->rows;
    struct cleaning c = {.recording = recording,
                         .findings = f,
                         .scratch = scratch,
                         .n = n,
                         .t = recording->t,
                         .y = recording->y,
                         .period = period,
                         .cancel = recording->cancel,
                         .excluded = arena_alloc(scratch, n),
                         .residual = arena_array(scratch, n, sizeof(double)),
                         .model = arena_array(scratch, n, sizeof(double)),
                         .sorted = arena_array(scratch, n, sizeof(double))};
    f->mask = arena_alloc(&recording->arena, n);
    f->window[0] = recording->t[0];
    f->window[1] = recording->t[n - 1];
    f->period = period;
    f->sway_period = f->rests = NAN;
    for (int k = 0; k < FINDINGS; k++) {
        f->finding[k].size = NAN;
        for (int i = 0; i < FINDING_STRETCHES; i++)
            f->finding[k].first[i] = NAN;
    }
    if (!c.excluded || !c.residual || !c.model || !c.sorted || !f->mask)
        return false;
    find_gaps(&c);
    find_missing(&c);
    if (cancelled(c.cancel))
        return false;
    find_steps(&c);
    if (cancelled(c.cancel))
        return false;
    const bool moves =
        period > 0 && recording->t[n - 1] - recording->t[0] >= 2 * period && c.swing > 0;
    return !moves || inspect_motion(&c);
}

bool recording_inspect(struct recording *recording, double period, const char *still,
                       struct error *error)
{
    struct arena scratch = {0};
    if (recording->findings)
        return true;
    struct findings *findings = arena_alloc(&recording->arena, sizeof *findings);
    const bool ok = findings && find_all_faults(recording, period, findings, &scratch);
    arena_reset(&scratch);
    if (cancelled(recording->cancel))
        return error_set(error, ERROR_CANCELLED, "stopped");
    if (!ok)
        return error_memory(error);
    snprintf(findings->still, sizeof findings->still, "%s", still);
    recording->findings = findings;
    return true;
}

void recording_keep_ends(struct recording *recording)
{
    if (!recording->findings)
        return;
    struct findings *f = arena_alloc(&recording->arena, sizeof *f);
    if (!f)
        return;
    *f = *recording->findings;
    f->window[0] = recording->t[0];
    f->window[1] = recording->t[recording->rows - 1];
    f->rests = NAN;
    f->finding[FINDING_START].count = f->finding[FINDING_END].count = 0;
    f->finding[FINDING_START].stretches = f->finding[FINDING_END].stretches = 0;
    recording->findings = f;
}

void recording_clean(struct recording *recording)
{
    const struct findings *f = recording->findings;
    const double first = recording->t[0], last = recording->t[recording->rows - 1];
    if (!f)
        return;
    recording->cleaned = true;
    if (recording->window[0] <= first && recording->window[1] >= last) {
        recording->window[0] = f->window[0];
        recording->window[1] = f->window[1];
    }
}
