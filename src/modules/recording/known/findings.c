/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Faults of a recording: finds them (find_faults()), advises a window, and reports them. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include "modules/recording/known/known.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The judgement of a window costs 2 us a sample, thirty times as much as measuring a period. Of a
 * recording with more than ALL_JUDGED samples only every k-th one is judged, such that
 * SAMPLES_PER_SWING remain; if these are more than JUDGED_MAX, only 'data clean' judges. */
#define ALL_JUDGED 16384
#define JUDGED_MAX 32768
/* A swing is a motion to one side; a period has at least one, usually two. */
#define SAMPLES_PER_SWING 8
/* Samples a swing that are enough for measuring a period, and blocks whose scatter is compared. */
#define ENOUGH_FOR_PERIOD 4
#define SCATTER_BLOCKS 64

/* Returns the median over blocks of the standard deviation within a block. */
static double local_scatter(const struct series *series)
{
    double scatter[SCATTER_BLOCKS];
    for (size_t b = 0; b < SCATTER_BLOCKS; b++) {
        const size_t begin = b * series->n / SCATTER_BLOCKS,
                     end = (b + 1) * series->n / SCATTER_BLOCKS;
        double mean = 0, sum = 0;
        for (size_t i = begin; i < end; i++)
            mean += series->y[i] / (double)(end - begin);
        for (size_t i = begin; i < end; i++)
            sum += (series->y[i] - mean) * (series->y[i] - mean);
        scatter[b] = sqrt(sum / (double)(end - begin));
    }
    return values_quantile(scatter, SCATTER_BLOCKS, 0.5);
}

/* Counts swings to and fro that exceed the local scatter. At least half of all half periods do,
 * because half of the blocks have that scatter. */
static size_t count_swings(const struct series *series)
{
    const double min = local_scatter(series);
    double extreme = series->y[0];
    size_t swings = 0;
    for (size_t i = 0; i < series->n; i++) {
        const double y = series->y[i];
        const bool is_falling = swings % 2;
        if (is_falling ? y <= extreme : y >= extreme) {
            extreme = y;
        } else if (fabs(y - extreme) > min) {
            extreme = y;
            swings++;
        }
    }
    return swings;
}

/* Thins a long series to at least for_swing samples per swing, and to no fewer than ALL_JUDGED; the
 * samples are copied. Returns false if out of memory. */
static bool findings_series_thin(struct series *series, size_t for_swing, struct arena *arena)
{
    if (series->n <= ALL_JUDGED)
        return true;
    const size_t wanted = for_swing * count_swings(series);
    const size_t each = series->n / (wanted > ALL_JUDGED ? wanted : ALL_JUDGED);
    if (each <= 1)
        return true;
    const size_t n = series->n / each;
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    if (!t || !y)
        return false;
    for (size_t i = 0; i < n; i++) {
        t[i] = series->t[i * each];
        y[i] = series->y[i * each];
    }
    series->t = t;
    series->y = y;
    series->n = n;
    return true;
}

/* Returns the period [s] of a series, from thinned samples if these show it, or NAN with the reason
 * in *overview. */
static double find_period(const struct series *series, struct arena *arena,
                          struct overview *overview)
{
    struct series few = *series;
    struct period period;
    struct error ignored;
    const bool is_thin = findings_series_thin(&few, ENOUGH_FOR_PERIOD, arena) && few.n < series->n;
    if ((is_thin && series_period(&few, arena, &period, &ignored)) ||
        series_period(series, arena, &period, &ignored))
        return period.period.value;
    series_overview(series, arena, overview);
    return overview->period;
}

/* Inspects the whole recording for faults, in recording->findings, unless that is done. The period
 * [s] is measured if it is NAN. Returns false with the error if out of memory or cancelled. */
bool find_faults(struct recording *recording, double period, struct arena *arena,
                 struct error *error)
{
    struct recording whole = *recording; /* its arrays are shared: nothing of it is changed */
    struct series series;
    struct overview overview = {.period = NAN, .reason = "it has fewer than 8 samples"};
    struct error ignored;
    if (recording->findings)
        return true;
    recording_restore(&whole);
    const bool enough = recording_series(&whole, arena, 8, &series, &ignored);
    if (enough && !(period > 0))
        period = find_period(&series, arena, &overview);
    if (cancelled(recording->cancel))
        return error_set(error, ERROR_CANCELLED, "stopped");
    if (!recording_inspect(recording, period, period > 0 ? "" : overview.reason, error))
        return false;
    const struct findings *f = recording->findings;
    const bool narrow =
        f->window[0] > recording->t[0] || f->window[1] < recording->t[recording->rows - 1];
    if (enough && narrow && isnan(f->rests) && series_beats(&series, arena))
        recording_keep_ends(recording);
    return true;
}

/* Judges a series as find_faults() judges a recording, which it makes of the series in *as and
 * *column. Returns NULL if out of memory. */
static const struct findings *run_findings(const struct series *series, double period,
                                           struct recording *as, struct column *column,
                                           struct arena *arena)
{
    struct error ignored;
    *column = (struct column){.name = "y", .quantity = series->quantity, .factor = 1};
    *as = (struct recording){
        .rows = series->n, .column = column, .columns = 1, .time = -1, .cancel = series->cancel};
    column->value = as->y = arena_array(arena, series->n, sizeof *as->y);
    as->t = arena_array(arena, series->n, sizeof *as->t);
    if (!as->y || !as->t)
        return NULL;
    memcpy(as->y, series->y, series->n * sizeof *as->y);
    memcpy(as->t, series->t, series->n * sizeof *as->t);
    return find_faults(as, period, arena, &ignored) ? as->findings : NULL;
}

/* Judges a recording, or a run, that 'data clean' has not judged, from thinned samples, of which it
 * makes a recording in *as and *column. Returns NULL if these are too many or if out of memory. */
static const struct findings *thinned_findings(const struct subject *subject, double period,
                                               struct recording *as, struct column *column,
                                               struct arena *arena)
{
    struct series series = subject->series;
    struct error ignored;
    *as = (struct recording){0};
    if (subject->recording) {
        struct recording whole =
            *subject->recording; /* its arrays are shared: nothing of it is changed */
        recording_restore(&whole);
        if (!recording_series(&whole, arena, 8, &series, &ignored))
            return NULL;
    }
    return findings_series_thin(&series, SAMPLES_PER_SWING, arena) && series.n <= JUDGED_MAX
               ? run_findings(&series, period, as, column, arena)
               : NULL;
}

/* Writes to advice->text which end of the window (start, end or both) is not part of the free
 * oscillation, and a better window. */
static void put_advice(const struct findings *f, const struct series *series, bool start, bool end,
                       struct window_advice *advice)
{
    const double t_begin = start ? f->window[0] : series->t[0];
    const double t_end = end ? f->window[1] : series->t[series->n - 1];
    const char *side = start ? "start of the window is" : "end of the window is";
    if (end && !start && isfinite(f->rests))
        snprintf(advice->text, sizeof advice->text,
                 "it is at rest from %.6g s on; try window=%.6g:%.6g", f->rests, t_begin, t_end);
    else
        snprintf(advice->text, sizeof advice->text,
                 "the %s not a free oscillation (rest, hand or release); try window=%.6g:%.6g",
                 start && end ? "start and the end of the window are" : side, t_begin, t_end);
}

/* Sets advice->text to a warning if an end of the subject's window is not a free oscillation,
 * otherwise to "". Judges the whole recording or a thinned one and compares the ends with the
 * result. `law` tells whether a rest at the end is part of the fitted law. */
void advise_window(const struct subject *subject, enum window_law law, double period,
                   struct arena *arena, struct window_advice *advice)
{
    const struct series *s = &subject->series;
    struct recording as;
    struct column column;
    struct error ignored;
    advice->text[0] = 0;
    if (s->n < 8 || subject->energy || subject->column || series_ends_as_inside(s, period))
        return;
    const bool whole = subject->recording &&
                       (subject->recording->findings || subject->recording->rows <= ALL_JUDGED);
    /* The period of a part may differ from that of the whole, which 'data clean' would find. */
    const bool is_all = !subject->recording ||
                        (s->t[0] == subject->recording->t[0] && s->n == subject->recording->rows);
    const double all = is_all ? period : NAN;
    const bool looked = whole && find_faults(subject->recording, all, arena, &ignored);
    const struct findings *f =
        looked ? subject->recording->findings : thinned_findings(subject, all, &as, &column, arena);
    const struct recording *judged = looked ? subject->recording : &as;
    const double step =
        f ? (judged->t[judged->rows - 1] - judged->t[0]) / (double)(judged->rows - 1) : 0;
    const bool inside = f && f->window[1] > s->t[0] && f->window[0] < s->t[s->n - 1];
    const bool start = inside && s->t[0] < f->window[0] - 1.5 * step && f->window[0] > judged->t[0];
    const bool end = inside && s->t[s->n - 1] > f->window[1] + 1.5 * step &&
                     f->window[1] < judged->t[judged->rows - 1];
    if (start || (end && !(law == WINDOW_LAW_STICKS && isfinite(f->rests))))
        put_advice(f, s, start, end, advice);
    if (!looked)
        arena_reset(&as.arena);
}

void reply_advice(const struct subject *subject, double period, struct arena *arena,
                  struct reply *reply)
{
    struct window_advice advice;
    advise_window(subject, WINDOW_LAW_SINE, period, arena, &advice);
    if (advice.text[0])
        reply_warning(reply, "%s", advice.text);
}

/* Returns the row of a kind of finding. */
static const struct finding_row *row_of(size_t kind)
{
    return (const struct finding_row *)(const void *)catalog_row(&finding_catalog, kind);
}

/* Adds a cell with the times of the first stretches: "4.38, 11.2, 30.04 … s". */
static void cell_positions(struct text_table *table, const struct finding *finding)
{
    struct buffer text = {0};
    for (int i = 0; i < FINDING_STRETCHES && isfinite(finding->first[i]); i++) {
        buffer_put(&text, i ? TEXT(", ") : TEXT(""));
        buffer_short(&text, finding->first[i], 6);
    }
    if (text.len > 0)
        buffer_put(&text, finding->stretches > FINDING_STRETCHES ? TEXT(" ... s") : TEXT(" s"));
    cell_take(table, &text);
}

/* Appends the size of the finding of this kind with its unit, e.g. the length of a gap [s] or the
 * height of a spike, or nothing if it has none. */
static void put_size(struct buffer *text, const struct recording *recording, size_t kind)
{
    const struct finding *finding = &recording->findings->finding[kind];
    const enum quantity quantity = recording->column[recording->value].quantity;
    if (!isfinite(finding->size))
        return;
    if (kind == FINDING_SWAY) {
        buffer_format(text, "%.1f %% rms", 100 * finding->size);
        if (isfinite(recording->findings->sway_period))
            buffer_format(text, " every %.3g s", recording->findings->sway_period);
        return;
    }
    const struct text bound = kind == FINDING_QUANTISED ? TEXT("of ") : TEXT("up to ");
    buffer_put(text, kind == FINDING_CLIPPED ? TEXT("at ") : bound);
    buffer_quantity(text, finding->size, kind == FINDING_GAPS ? QUANTITY_TIME : quantity, 3);
}

/* Appends the table of findings. Returns the number of kinds that were found. */
static size_t put_table(const struct recording *recording, struct arena *arena, struct buffer *text)
{
    static const char *const heads[] = {"found", "samples", "places", "size", "first at", "action"};
    struct text_table table = {.arena = arena, .columns = (int)COUNT_OF(heads), .gap = 2};
    size_t kinds = 0;
    for (size_t i = 0; i < COUNT_OF(heads); i++)
        cell_text(&table, heads[i]);
    for (size_t k = 0; k < FINDINGS; k++) {
        const struct finding *finding = &recording->findings->finding[k];
        struct buffer size = {0};
        if (finding->count == 0)
            continue;
        kinds++;
        cell_text(&table, row_of(k)->row.name);
        cell_count(&table, (int64_t)finding->count);
        if (finding->stretches > 0)
            cell_count(&table, (int64_t)finding->stretches);
        else
            cell_text(&table, "");
        put_size(&size, recording, k);
        cell_take(&table, &size);
        cell_positions(&table, finding);
        cell_text(&table, row_of(k)->done);
    }
    if (kinds > 0)
        text_table_put(&table, text);
    return kinds;
}

/* Adds the record `clean` to the reply: the recording, how many samples are masked, the window, and
 * an object for each kind of finding, with its number of samples and places, the times of the first
 * ones, and the remedy. */
static void reply_record(const struct recording *recording, struct reply *reply)
{
    static const char *const remedies[] = {[REMEDY_MASK] = "mask",
                                           [REMEDY_WINDOW] = "window",
                                           [REMEDY_KEEP] = "keep",
                                           [REMEDY_DROPPED] = "dropped"};
    const struct findings *f = recording->findings;
    reply_begin(reply, "clean");
    reply_string(reply, "name", recording->name);
    reply_bool(reply, "applied", recording->cleaned);
    reply_int(reply, "rows", (int64_t)recording->rows);
    reply_int(reply, "masked", (int64_t)f->masked);
    reply_reals(reply, "window", f->window, 2, "");
    reply_real(reply, "period", f->period);
    reply_array(reply, "findings");
    for (size_t k = 0; k < FINDINGS; k++) {
        const struct finding *finding = &f->finding[k];
        if (finding->count == 0)
            continue;
        reply_object(reply, NULL);
        reply_string(reply, "kind", row_of(k)->row.name);
        reply_int(reply, "samples", (int64_t)finding->count);
        reply_int(reply, "places", (int64_t)finding->stretches);
        reply_real(reply, "size", finding->size);
        reply_array(reply, "first");
        for (int i = 0; i < FINDING_STRETCHES && isfinite(finding->first[i]); i++)
            reply_real(reply, NULL, finding->first[i]);
        reply_close(reply);
        reply_string(reply, "remedy", remedies[row_of(k)->remedy]);
        reply_close(reply);
    }
    reply_close(reply);
    reply_end(reply);
}

/* Replies with the table of findings and what cleaning would do or did. */
void reply_findings(const struct recording *recording, struct arena *arena, struct reply *reply)
{
    const struct findings *f = recording->findings;
    const bool windowed =
        f->window[0] > recording->t[0] || f->window[1] < recording->t[recording->rows - 1];
    struct buffer *text = reply_buffer(reply);
    const size_t kinds = put_table(recording, arena, text);
    if (kinds == 0)
        buffer_format(text, "%s: no faults were found\n", recording->name);
    if (isnan(f->period))
        buffer_format(text, "it does not oscillate: %s; only times and step sizes were checked\n",
                      f->still);
    if (recording->cleaned)
        buffer_format(
            text, "%s: %zu of %zu samples masked, window %.6g..%.6g s; 'data restore' undoes this",
            recording->name, f->masked, recording->rows, recording->window[0],
            recording->window[1]);
    else if (f->masked > 0 || windowed)
        buffer_format(
            text,
            "'data clean apply' would mask %zu of %zu samples and use the window %.6g..%.6g s",
            f->masked, recording->rows, f->window[0], f->window[1]);
    else if (kinds > 0)
        buffer_put(text, TEXT("nothing needs to be masked"));
    reply_record(recording, reply);
}
