/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Repeated measurements of a quantity, in several recordings or windows: mean, scatter, and a test
 * of the uncertainties. */
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>
#include "modules/recording/measuring.h"

#include <math.h>
#include <stdio.h>

/* Probability of the scatter below which the stated uncertainties are called too small. */
#define CHANCE_SURPRISING 0.01
/* Smallest number of samples of one measurement. */
#define MIN_SAMPLES 8

/* The repeated values with their names. */
struct repeated {
    enum measurable what;
    enum quantity unit;
    int count, capacity;
    struct measured *value;
    char (*name)[LIMIT_NAME + 40];
};

/* ---- one value ---- */

/* Measures the quantity `what` once, in a series of a recording, in *value. k has no uncertainty of
 * the mass, which is the same each time. Returns false with the error. */
static bool repeat_value(struct measuring *m, const struct recording *recording,
                         enum measurable what, const struct series *series, struct arena *arena,
                         struct measured *value)
{
    struct period p;
    struct decay d;
    struct reading a;
    if (what == MEASURE_AMPLITUDE) {
        const double middle = 0.5 * (series->t[0] + series->t[series->n - 1]);
        const bool ok = series_amplitudes(series, arena, &middle, 1, 0, &a, m->error);
        *value = a.amplitude;
        return ok;
    }
    if (what == MEASURE_DECAY) {
        const bool ok = series_decay(series, arena, NULL, 0, &d, m->error);
        *value = d.gamma;
        return ok;
    }
    if (!series_period(series, arena, &p, m->error))
        return false;
    const double T = p.period.value, u = p.period.uncertainty;
    *value = p.period;
    if (what == MEASURE_FREQUENCY)
        *value = (struct measured){1 / T, u / (T * T)};
    if (what != MEASURE_K)
        return true;
    /* k = 4 pi^2 m/T^2: the mass is the same each time, so that it adds nothing to the scatter. */
    const struct scene *scene = &m->session->setup.scene;
    const double own = recording->mass.value, mass = own > 0 ? own : param_value(scene, "m");
    *value = (struct measured){4 * M_PI * M_PI * mass / (T * T), 0};
    value->uncertainty = 2 * value->value * u / T;
    return isfinite(mass) ||
           error_set(m->error, ERROR_COMMAND, "k needs the mass, for example: data mass 200 g");
}

/* Measures one series and adds its value to r under the name. Returns false with the error, which
 * is prefixed by the name. */
static bool repeated_add(struct measuring *m, struct repeated *r, const struct recording *recording,
                         const struct series *series, const char *name)
{
    /* The memory is freed after each recording, which is faster than all at once. */
    struct arena scratch = {0};
    const bool ok = repeat_value(m, recording, r->what, series, &scratch, &r->value[r->count]);
    arena_reset(&scratch);
    if (!ok) {
        struct error why = *m->error;
        return error_set(m->error, why.code, "%s: %s", name, why.text);
    }
    snprintf(r->name[r->count], sizeof r->name[0], "%s", name);
    r->count++;
    return true;
}

/* Returns the quantity of the values of `what`; of_series is that of the series, which amplitudes
 * have. */
static enum quantity repeat_unit(enum measurable what, enum quantity of_series)
{
    switch (what) {
    case MEASURE_PERIOD:
        return QUANTITY_TIME;
    case MEASURE_FREQUENCY:
        return QUANTITY_FREQUENCY;
    case MEASURE_DECAY:
        return QUANTITY_RATE;
    case MEASURE_K:
        return QUANTITY_STIFFNESS;
    default:
        return of_series;
    }
}

/* ---- all of them ---- */

/* Adds the values of one recording, as a whole or in `windows` windows. Returns false with the
 * error. */
static bool add_recording(struct measuring *m, struct repeated *r, struct recording *recording,
                          int windows)
{
    struct series series;
    if (!recording_series(recording, m->args->arena, MIN_SAMPLES, &series, m->error))
        return false;
    const enum quantity unit = repeat_unit(r->what, series.quantity);
    if (r->count > 0 && unit != r->unit)
        return error_set(m->error, ERROR_COMMAND, "%s and %s are different quantities",
                         recording->name, r->name[0]);
    r->unit = unit;
    struct subject subject = {.series = series, .recording = recording};
    struct window_advice advice;
    advise_window(&subject, WINDOW_LAW_SINE, NAN, m->args->arena, &advice);
    if (advice.text[0])
        reply_warning(m->reply, "%s: %s", recording->name, advice.text);
    if (windows == 1)
        return repeated_add(m, r, recording, &series, recording->name);
    const double t_begin = series.t[0], width = (series.t[series.n - 1] - t_begin) / windows;
    for (int i = 0; i < windows; i++) {
        char name[LIMIT_NAME + 40];
        const struct series part =
            series_window(series, t_begin + i * width, t_begin + (i + 1) * width);
        snprintf(name, sizeof name, "%s %.4g..%.4g s", recording->name, t_begin + i * width,
                 t_begin + (i + 1) * width);
        if (part.n < MIN_SAMPLES)
            return error_set(m->error, ERROR_COMMAND, "%s: fewer than %d samples", name,
                             MIN_SAMPLES);
        if (!repeated_add(m, r, recording, &part, name))
            return false;
    }
    return true;
}

/* Sets index[] to the recordings that are named; without a name to all, or only to the current one
 * if it is to be divided into windows. Returns their number. */
static int chosen_recordings(const struct measuring *m, bool windows, int *index)
{
    const struct session *session = m->session;
    const struct argument_value *named = argument_value(m->args, "RECORDING"),
                                *data = argument_value(m->args, "data");
    const struct argument_value *source = named->count ? named : data;
    int count = 0;
    for (int i = 0; i < source->count; i++)
        index[count++] = source->item[i].index;
    if (count > 0 || session->recordings == 0)
        return count;
    if (windows) {
        index[0] = session->current_recording;
        return 1;
    }
    for (; count < session->recordings; count++)
        index[count] = count;
    return count;
}

/* Reads the arguments of `measure repeat` and measures all values into r. Returns false with the
 * error. */
static bool measure_all(struct measuring *m, struct repeated *r)
{
    const struct argument_value *windows = argument_value(m->args, "windows"),
                                *what = argument_value(m->args, "what");
    const int parts = windows->count ? (int)windows->item->value.value : 1;
    int *index = arena_array(m->args->arena, LIMIT_TOKENS + LIMIT_RECORDINGS, sizeof *index);
    r->what = what->count ? (enum measurable)what->item->index : MEASURE_PERIOD;
    if (r->what > MEASURE_DECAY && r->what != MEASURE_K)
        return error_at(m->error, what->where, "what= is period, frequency, amplitude, decay or k");
    const int recordings = index ? chosen_recordings(m, windows->count > 0, index) : 0;
    r->capacity = recordings * parts;
    if (index && (r->capacity < 2 || parts > LIMIT_TOKENS)) {
        error_set(m->error, ERROR_COMMAND,
                  "'measure repeat' needs at least two recordings, or windows of one");
        return error_hint(m->error,
                          "type: measure repeat NAME NAME .., or: measure repeat NAME windows=5");
    }
    r->value = arena_array(m->args->arena, (size_t)r->capacity + 1, sizeof *r->value);
    r->name = arena_array(m->args->arena, (size_t)r->capacity + 1, sizeof *r->name);
    if (!index || !r->value || !r->name)
        return error_memory(m->error);
    for (int i = 0; i < recordings; i++)
        if (!add_recording(m, r, m->session->recording[index[i]]->recording, parts))
            return false;
    return true;
}

/* ---- what is said ---- */

/* Appends mean, weighted mean, Birge ratio (scatter relative to the stated uncertainties) and the
 * value to quote. */
static void put_scatter(const struct repeated *r, const struct repeat *repeat, struct buffer *text)
{
    put_measured(text, "\nmean", repeat->mean, r->unit);
    buffer_format(text, "   scatter of a single %s", SHOWN_QUANTITY(repeat->scatter, r->unit, 2));
    put_measured(text, "\nweighted mean", repeat->weighted, r->unit);
    if (isfinite(repeat->birge)) {
        buffer_format(text, "   Birge ratio %.*f", repeat->birge < 10 ? 1 : 0, repeat->birge);
        buffer_format(text, repeat->chance < 0.0001 ? " (chance < 0.0001)" : " (chance %.2g)",
                      repeat->chance);
    }
    put_measured(text, "\nquote", repeat->quote, r->unit);
    buffer_format(text, "   95 %%: +- %s", SHOWN_QUANTITY(repeat->interval, r->unit, 2));
}

/* Warns if the scatter does not agree with the stated uncertainties. */
static void put_verdict(const struct repeat *repeat, struct reply *reply)
{
    if (repeat->chance < CHANCE_SURPRISING)
        reply_warning(reply,
                      "the values scatter %.*f times more than their uncertainties: these are too "
                      "small, or something changed between the measurements",
                      repeat->birge < 10 ? 1 : 0, repeat->birge);
    else if (repeat->chance > 1 - CHANCE_SURPRISING)
        reply_warning(reply,
                      "the values scatter only %.2g times as much as their uncertainties, which "
                      "are too large",
                      repeat->birge);
}

/* Adds the record of the repeated measurement. */
static void reply_repeat(struct measuring *m, const struct repeated *r, const struct repeat *repeat)
{
    measure_begin(m, m->quantity, repeat->quote, r->unit, NAN);
    reply_string(m->reply, "what", catalog_row(&quantity_catalog, (size_t)r->what)->name);
    reply_real(m->reply, "scatter", repeat->scatter);
    reply_real(m->reply, "birge", repeat->birge);
    reply_int(m->reply, "n", repeat->n);
    reply_real(m->reply, "interval", repeat->interval);
    reply_real(m->reply, "chance", repeat->chance);
    reply_measured(m->reply, "mean", repeat->mean, r->unit);
    reply_measured(m->reply, "weighted", repeat->weighted, r->unit);
    reply_array(m->reply, "values");
    for (int i = 0; i < r->count; i++) {
        reply_object(m->reply, NULL);
        reply_string(m->reply, "name", r->name[i]);
        reply_real(m->reply, "value", r->value[i].value);
        reply_real(m->reply, "uncertainty", r->value[i].uncertainty);
        reply_close(m->reply);
    }
    reply_close(m->reply);
    reply_end(m->reply);
}

/* Measures a quantity in several recordings or windows, and replies with the statistics of the
 * values. Returns false with the error. */
bool measure_repeat(struct measuring *m)
{
    struct repeated r = {.count = 0};
    struct repeat repeat;
    if (!measure_all(m, &r))
        return false;
    repeat_values(r.value, r.count, &repeat);
    const char *what = catalog_row(&quantity_catalog, (size_t)r.what)->name;
    snprintf(m->subject.name, sizeof m->subject.name, "%d values", r.count);
    if (!session_add_measurement(m->session, what, m->subject.name, repeat.quote, r.unit, NAN,
                                 m->error))
        return false;
    struct buffer *text = reply_buffer(m->reply);
    for (int i = 0; i < r.count; i++) {
        buffer_format(text, "%s%-24s ", i ? "\n" : "", r.name[i]);
        put_measured(text, what, r.value[i], r.unit);
    }
    put_scatter(&r, &repeat, text);
    reply_repeat(m, &r, &repeat);
    put_verdict(&repeat, m->reply);
    return true;
}
