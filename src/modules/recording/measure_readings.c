/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Several readings together: the fall of the amplitude, and the dependence of the period on it. */
#include <hooke/base/number.h>
#include <hooke/command/handler.h>
#include "modules/recording/fit_text.h"
#include "modules/recording/measuring.h"

#include <math.h>
#include <stdio.h>

/* Smallest number of readings for a straight line. */
#define READINGS_MIN 3
#define DEPENDENCE_SEEN_SIGMAS 3.0 /* standard deviations of a significant dependence */
/* Relative difference of amplitudes below which a dependence cannot be seen. */
#define SAME_AMPLITUDE 1e-6

void put_measured(struct buffer *text, const char *name, struct measured value, enum quantity unit)
{
    if (isfinite(value.value))
        buffer_format(text, "%s = %s", name, SHOWN_MEASURED(value, unit, 6));
}

void measure_begin(struct measuring *m, const char *quantity, struct measured value,
                   enum quantity unit, double periods)
{
    struct measurement row = {.value = value, .unit = unit, .periods = periods};
    snprintf(row.quantity, sizeof row.quantity, "%s", quantity);
    snprintf(row.source, sizeof row.source, "%s", m->subject.name);
    reply_begin(m->reply, "measure");
    reply_columns(m->reply, &measurement_columns, &row);
}

/* Returns 2/x with its uncertainty: gamma from tau. */
static struct measured two_over(struct measured x)
{
    return (struct measured){2 / x.value, 2 * x.uncertainty / (x.value * x.value)};
}

/* Returns the time [s] in which the first reading falls to 1/e, on the straight line between the
 * two of the count logarithms log_a[] at times t[] around it, or NAN if it does not fall so far. */
static struct measured fall_to_e(const double *t, const struct measured *log_a, int count)
{
    const double wanted = log_a[0].value - 1;
    for (int i = 1; i < count; i++) {
        if (log_a[i].value > wanted)
            continue;
        const double rate = (log_a[i - 1].value - log_a[i].value) / (t[i] - t[i - 1]);
        const double part = (wanted - log_a[i].value) / (log_a[i - 1].value - log_a[i].value);
        const double sigma =
            hypot(part * log_a[i - 1].uncertainty, (1 - part) * log_a[i].uncertainty);
        return (struct measured){t[i] - (wanted - log_a[i].value) / rate - t[0],
                                 hypot(sigma, log_a[0].uncertainty) / rate};
    }
    return (struct measured){NAN, NAN};
}

/* Fits ln A of the readings by a straight line, finds the time to 1/e of the first reading, and
 * adds both decay rates to text and reply. Adds nothing for too few readings, or if they do not
 * fall. */
void measure_fall(struct measuring *m, const struct reading *reading, int count,
                  struct buffer *text)
{
    double *t = arena_array(m->args->arena, (size_t)count, sizeof *t);
    struct measured *log_a = arena_array(m->args->arena, (size_t)count, sizeof *log_a);
    struct line_fit line;
    if (!t || !log_a || count < READINGS_MIN)
        return;
    for (int i = 0; i < count; i++) {
        const struct measured a = reading[i].amplitude;
        t[i] = reading[i].t;
        log_a[i] = (struct measured){log(a.value), a.uncertainty / a.value};
    }
    if (!line_fit(t, log_a, count, &line) || !(line.slope.value - line.slope.uncertainty < 0))
        return;
    const struct measured gamma = {-2 * line.slope.value, 2 * line.slope.uncertainty};
    const struct measured tau = fall_to_e(t, log_a, count), by_e = two_over(tau);
    put_measured(text, "\ngamma", gamma, QUANTITY_RATE);
    buffer_put(text, TEXT(" from the line through ln A"));
    double least;
    const struct measured of_line = measured_reciprocal(2, gamma, &least);
    put_reciprocal(text, "   tau", 2, gamma, QUANTITY_TIME, m->subject.recording);
    if (isfinite(tau.value)) {
        put_measured(text, "\ngamma", by_e, QUANTITY_RATE);
        buffer_put(text, TEXT(" from the time to 1/e of the first reading"));
        put_measured(text, "   tau", tau, QUANTITY_TIME);
    } else {
        buffer_put(text, TEXT("\nthe amplitude does not fall to 1/e of the first reading"));
    }
    session_set_result(m->session, "measured_gamma", gamma, QUANTITY_RATE);
    session_set_result(m->session, "measured_tau", of_line, QUANTITY_TIME);
    measure_begin(m, "gamma", gamma, QUANTITY_RATE, NAN);
    reply_int(m->reply, "readings", count);
    reply_measured(m->reply, "tau", of_line, QUANTITY_TIME);
    reply_real(m->reply, "tau_min", least);
    reply_measured(m->reply, "time_to_1_e", tau, QUANTITY_TIME);
    reply_measured(m->reply, "gamma_of_1_e", by_e, QUANTITY_RATE);
    reply_end(m->reply);
}

/* Sets *reading_time to the *count times [s] of the readings, in the arena: the stated ones, the
 * middles of equal windows, or the start. Returns false with the error. */
static bool reading_times(struct measuring *m, double **reading_time, int *count)
{
    const struct argument_value *times = argument_value(m->args, "at"),
                                *windows = argument_value(m->args, "windows");
    const struct series *s = &m->subject.series;
    const int parts = windows->count ? (int)windows->item->value.value : 1;
    *count = times->count ? times->count : parts;
    if (*count > LIMIT_TOKENS)
        return error_at(m->error, windows->where, "at most %d readings", LIMIT_TOKENS);
    *reading_time = arena_array(m->args->arena, (size_t)*count, sizeof **reading_time);
    if (!*reading_time)
        return error_memory(m->error);
    const double t_begin = s->t[0], width = s->t[s->n - 1] - t_begin;
    for (int i = 0; i < *count; i++) {
        const double part = windows->count ? (i + 0.5) / *count : 0;
        (*reading_time)[i] = times->count ? times->item[i].value.value : t_begin + part * width;
    }
    return true;
}

/* Reads the amplitude at each time, adds it to the session's measurements, and replies with
 * readings and decay. Returns false with the error. */
bool measure_amplitude(struct measuring *m)
{
    const enum quantity unit = m->subject.series.quantity;
    double *reading_time = NULL;
    int count;
    if (!reading_times(m, &reading_time, &count))
        return false;
    struct reading *readings = arena_array(m->args->arena, (size_t)count, sizeof *readings);
    if (!readings)
        return error_memory(m->error);
    if (!series_amplitudes(&m->subject.series, m->args->arena, reading_time, count, 0, readings,
                           m->error))
        return false;
    struct buffer text = {0};
    for (int i = 0; i < count; i++) {
        if (!measure_keep(m, m->quantity, readings[i].amplitude, unit, NAN)) {
            buffer_free(&text);
            return false;
        }
        measure_latest(m)->t = readings[i].t;
        put_measured(&text, i ? "\nA" : "A", readings[i].amplitude, unit);
        buffer_format(&text, " at t = %.6g s", readings[i].t);
        measure_begin(m, m->quantity, readings[i].amplitude, unit, NAN);
        reply_real(m->reply, "t", readings[i].t);
        reply_end(m->reply);
    }
    measure_fall(m, readings, count, &text);
    return measure_say(m, &text);
}

/* ---- the period against the amplitude ---- */

/* Adds to text and reply by how much the period changes from the smallest to the largest of `count`
 * amplitudes a[], if there are enough readings and the amplitudes differ. */
static void say_dependence(struct measuring *m, const double *a, const struct measured *period,
                           int count, struct buffer *text)
{
    struct line_fit line;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < count; i++) {
        low = fmin(low, a[i]);
        high = fmax(high, a[i]);
    }
    if (count < READINGS_MIN || !(high - low > SAME_AMPLITUDE * high) ||
        !line_fit(a, period, count, &line))
        return;
    const double at_low = line.intercept.value + line.slope.value * low,
                 percent = 100 * (high - low) / at_low;
    const struct measured change = {percent * line.slope.value, percent * line.slope.uncertainty};
    const double sigmas = fabs(change.value) / change.uncertainty;
    buffer_put(text, TEXT("\nfrom the smallest to the largest amplitude T changes by "));
    buffer_uncertain(text, change.value, change.uncertainty);
    buffer_format(
        text, " %%: %s (%.2g standard deviations)",
        sigmas < DEPENDENCE_SEEN_SIGMAS ? "not significant" : "T depends on the amplitude", sigmas);
    measure_begin(m, "period_change",
                  (struct measured){change.value / 100, change.uncertainty / 100}, QUANTITY_NUMBER,
                  NAN);
    reply_real(m->reply, "sigmas", sigmas);
    reply_reals(m->reply, "amplitudes", (const double[]){low, high}, 2, "");
    reply_end(m->reply);
}

/* Adds the period and amplitude of one window to text and reply, with the theory for that
 * amplitude. `first` omits the line end before it. */
static void say_reading(struct measuring *m, const struct period_reading *r, bool first,
                        struct buffer *text)
{
    const enum quantity unit = m->subject.series.quantity;
    const struct scene *scene =
        m->subject.energy || m->subject.column ? NULL : subject_scene(m->session, m->subject.run);
    const double theory = scene_period_at(scene, r->amplitude.value);
    put_measured(text, first ? "T" : "\nT", r->period, QUANTITY_TIME);
    put_measured(text, " at A", r->amplitude, unit);
    buffer_format(text, "   (%.6g..%.6g s)", r->t_begin, r->t_end);
    if (isfinite(theory))
        buffer_format(text, "   theory %.6g s (%+.3f %%)", theory,
                      100 * (r->period.value / theory - 1));
    measure_begin(m, m->quantity, r->period, QUANTITY_TIME, r->periods);
    reply_measured(m->reply, "amplitude", r->amplitude, unit);
    reply_real(m->reply, "t", r->t);
    reply_real(m->reply, "theory", theory);
    reply_end(m->reply);
}

/* Reads period and amplitude in `windows` equal windows, adds each to text and reply, then the
 * dependence on the amplitude. Returns false with the error. */
bool measure_periods(struct measuring *m, int windows, struct buffer *text)
{
    struct arena *arena = m->args->arena;
    double *a = arena_array(arena, (size_t)windows, sizeof *a);
    struct measured *period = arena_array(arena, (size_t)windows, sizeof *period);
    struct period_reading *reading = arena_array(arena, (size_t)windows, sizeof *reading);
    if (!a || !period || !reading)
        return error_memory(m->error);
    if (!series_period_readings(&m->subject.series, windows, arena, reading, m->error))
        return false;
    for (int i = 0; i < windows; i++) {
        if (!session_add_measurement(m->session, m->quantity, m->subject.name, reading[i].period,
                                     QUANTITY_TIME, reading[i].periods, m->error))
            return false;
        a[i] = reading[i].amplitude.value;
        period[i] = reading[i].period;
        say_reading(m, &reading[i], i == 0, text);
    }
    say_dependence(m, a, period, windows, text);
    return true;
}
