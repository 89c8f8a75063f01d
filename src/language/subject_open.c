/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Opens the subject of `measure` and `fit`: turns a run or a recording into a series of one
 * quantity over ascending times. */

#include <hooke/run.h>
#include <hooke/data.h>
#include <hooke/language.h>
#include <hooke/session/series_tools.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Fills a series, allocated from the arena, with the first variable of a run or its energy, in
 * ascending time also for runs backwards. Returns false with an error if out of memory or if the
 * energy cannot be computed. */
bool run_series(const struct run *run, bool energy, struct arena *arena, struct series *series,
                struct error *error)
{
    const size_t n = trace_count(run->trace);
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    if (!t || !y)
        return error_memory(error);
    const struct observable *energy_of = observable_energy(&run->system);
    if (energy && !run_column(run, energy_of, y, error))
        return false;
    if (!energy)
        run_variable_column(run, 0, y);
    for (size_t i = 0; i < n; i++)
        t[i] = trace_time(run->trace, i);
    /* A run backwards in time is reversed. */
    if (n > 1 && t[n - 1] < t[0])
        for (size_t i = 0; i < n / 2; i++) {
            const double a = t[i], b = y[i];
            t[i] = t[n - 1 - i];
            y[i] = y[n - 1 - i];
            t[n - 1 - i] = a;
            y[n - 1 - i] = b;
        }
    *series = (struct series){t,
                              y,
                              n,
                              energy ? observable_quantity(energy_of, &run->system)
                                     : system_variable(&run->system, 0).quantity,
                              run->cancel,
                              0};
    return true;
}

/* Measures the period of a run by the module `recording`; returns false if that module is left out
 * or there is no period. */
bool run_period(const struct run *run, struct arena *arena, struct measured *period)
{
    const struct series_tools *tools = series_tools();
    return tools && tools->run_period(run, arena, period);
}

/* Returns false with an error that begins with `what` if the scene is not an oscillator with mass
 * and spring. */
bool needs_spring(const struct scene *scene, const char *what, struct error *error)
{
    if (is_oscillator(scene))
        return true;
    error_set(error, ERROR_COMMAND,
              "%s needs the mass and the spring of an oscillator, but the scene is %s", what,
              scene->preset->row.name);
    return error_hint(error, "type: scene spring");
}

/* Turns the subject's series into the energy of a recording, from its velocity and the mass and
 * spring constant known for it, and notes in subject->how where they come from. Returns false with
 * an error if one of them is unknown. */
static bool recording_energy_series(const struct session *session, struct arena *arena,
                                    struct subject *subject, struct error *error)
{
    struct data_motion motion;
    if (!series_tools()->motion(session, subject->recording, &subject->series, true, arena, &motion,
                                error))
        return false;
    snprintf(subject->how, sizeof subject->how, "%s; %s", motion.how_k, motion.how_v);
    subject->mass = motion.mass;
    subject->k = motion.k;
    subject->noise = motion.noise;
    return motion_series(&motion, true, -HUGE_VAL, HUGE_VAL, arena, &subject->series, error);
}

/* Sets the ends of a window of time; an end that was left open (NAN) becomes infinite. */
static void window_ends(const struct argument_value *window, double end[2])
{
    const double *range = window->item->range;
    end[0] = isnan(range[0]) ? -HUGE_VAL : range[0];
    end[1] = isnan(range[1]) ? HUGE_VAL : range[1];
}

/* Returns the part of a series in the argument's window of time, whose ends may be open (NAN), or
 * all of it if no window was given. */
static struct series series_in_window(struct series series, const struct argument_value *window)
{
    double end[2];
    if (!window || !window->count)
        return series;
    window_ends(window, end);
    return series_window(series, end[0], end[1]);
}

/* Makes a run the subject. Returns false with an error if fewer than `min` samples are in the
 * window, or if the series cannot be computed. */
static bool open_run(struct run *run, const struct argument_value *window, bool energy, size_t min,
                     struct arena *arena, struct subject *subject, struct error *error)
{
    subject->run = run;
    snprintf(subject->name, sizeof subject->name, "run %d", run->number);
    if (!run_series(run, energy, arena, &subject->series, error))
        return false;
    subject->series = series_in_window(subject->series, window);
    if (subject->series.n >= min)
        return true;
    error_set(error, ERROR_COMMAND, "%s has only %zu samples there; at least %zu are needed",
              subject->name, subject->series.n, min);
    if (window && window->count)
        error->where = window->where;
    return false;
}

/* Makes a recording the subject, in the argument's window or else its own. Returns false with an
 * error if fewer than `min` samples are in it, or if its energy is not known. */
static bool open_recording(const struct session *session, struct recording *recording,
                           const struct argument_value *window, bool energy, size_t min,
                           struct arena *arena, struct subject *subject, struct error *error)
{
    subject->recording = recording;
    snprintf(subject->name, sizeof subject->name, "data %s", recording->name);
    /* window= replaces the recording's own window for this command only; it is restored below. */
    const double old_window[2] = {recording->window[0], recording->window[1]};
    bool ok = true;
    if (window && window->count) {
        double end[2];
        window_ends(window, end);
        ok = recording_window(recording, end[0], end[1], error);
    }
    ok = ok && recording_series(recording, arena, min, &subject->series, error);
    recording->window[0] = old_window[0];
    recording->window[1] = old_window[1];
    if (!ok && window && window->count)
        error->where = window->where;
    return ok && (!energy || recording_energy_series(session, arena, subject, error));
}

/* Replaces the subject's series by another column of its run (a variable, an observed expression or
 * an observable), in ascending time. Returns false with an error for a recording or an unknown
 * column. */
bool subject_column(struct subject *subject, const struct argument_value *column,
                    const struct argument_value *window, struct arena *arena, struct error *error)
{
    const struct text name = column->item->text;
    const struct run *run = subject->run;
    struct chosen_column chosen;
    if (!run)
        return error_at(error, column->where, "a recording has no column '%.*s'", (int)name.len,
                        name.data);
    if (!chosen_find(run->system.model, name, &chosen, error))
        return false;
    const size_t n = trace_count(run->trace);
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    if (!t || !y)
        return error_memory(error);
    if (!chosen_values(run, &chosen, y, error))
        return false;
    const bool backwards = trace_time(run->trace, n - 1) < trace_time(run->trace, 0);
    for (size_t i = 0; i < n; i++)
        t[i] = trace_time(run->trace, backwards ? n - 1 - i : i);
    for (size_t i = 0; backwards && i < n / 2; i++) {
        const double last = y[n - 1 - i];
        y[n - 1 - i] = y[i];
        y[i] = last;
    }
    const struct series whole = {t,           y, n, chosen_variable(&run->system, &chosen).quantity,
                                 run->cancel, 0};
    subject->series = series_in_window(whole, window);
    subject->column = true;
    snprintf(subject->name, sizeof subject->name, "%.*s of run %d", (int)name.len, name.data,
             run->number);
    return true;
}

/* Opens the run or the recording that was given, else whichever is the latest. Returns false with
 * an error if there is none or if it has fewer than `min` samples in the window. */
bool subject_open(struct session *session, const struct argument_value *run,
                  const struct argument_value *data, const struct argument_value *window,
                  bool energy, size_t min, struct arena *arena, struct subject *subject,
                  struct error *error)
{
    *subject = (struct subject){.energy = energy};
    if (run && run->count)
        return open_run(session->runs.slot[run->item->index]->run, window, energy, min, arena,
                        subject, error);
    if (data && data->count)
        return open_recording(session, session->recording[data->item->index]->recording, window,
                              energy, min, arena, subject, error);
    struct run *latest = session_run(session);
    struct recording *recording = session_recording(session);
    if (recording && (session->data_is_latest || !latest))
        return open_recording(session, recording, window, energy, min, arena, subject, error);
    if (latest)
        return open_run(latest, window, energy, min, arena, subject, error);
    error_set(error, ERROR_COMMAND, "there is neither a run nor a recording yet");
    return error_hint(error, "type: run, or: load FILE");
}
