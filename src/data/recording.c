/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings: freeing them, choosing their window, and the window as a series. */
#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>
#include <hooke/data.h>

#include <math.h>
#include <stdlib.h>

/* Frees a recording with all memory that it owns; NULL is allowed. */
void recording_destroy(struct recording *recording)
{
    if (!recording)
        return;
    for (int i = 0; i < recording->columns && recording->column; i++)
        free(recording->column[i].value);
    free(recording->t);
    free(recording->y);
    free(recording->line);
    arena_reset(&recording->arena);
    free(recording);
}

/* ---- the window that measurements use ---- */

/* Makes all rows part of the window again and removes zero, cleaning and velocity column. */
void recording_restore(struct recording *recording)
{
    recording->window[0] = recording->t[0];
    recording->window[1] = recording->t[recording->rows - 1];
    recording->zero = 0;
    recording->cleaned = false;
    recording->velocity[0] = 0;
}

/* Sets the window that measurements use, limited to the recorded times; NAN means the first or the
 * last of them. Returns false with the error set if it holds no sample. */
bool recording_window(struct recording *recording, double t_begin, double t_end,
                      struct error *error)
{
    const double first = recording->t[0], last = recording->t[recording->rows - 1];
    t_begin = isnan(t_begin) || t_begin < first ? first : t_begin;
    t_end = isnan(t_end) || t_end > last ? last : t_end;
    size_t row = first_from(recording->t, recording->rows, t_begin);
    if (!(t_begin < t_end) || row >= recording->rows || recording->t[row] > t_end)
        return error_set(error, ERROR_COMMAND,
                         "no samples of %s in this window; it spans %.6g to %.6g s",
                         recording->name, first, last);
    recording->window[0] = t_begin;
    recording->window[1] = t_end;
    return true;
}

/* Copies the rows of the window that have a value and were not rejected by cleaning, less the zero,
 * into memory of the arena. Returns false with the error set if fewer than min remain, on
 * cancellation, or if out of memory. */
bool recording_series(const struct recording *recording, struct arena *arena, size_t min,
                      struct series *series, struct error *error)
{
    const size_t begin = first_from(recording->t, recording->rows, recording->window[0]);
    size_t end = first_from(recording->t, recording->rows, recording->window[1]), n = 0;
    end += end < recording->rows && recording->t[end] == recording->window[1];
    double *t = arena_array(arena, end - begin, sizeof *t),
           *y = arena_array(arena, end - begin, sizeof *y);
    if (!t || !y)
        return error_memory(error);
    for (size_t i = begin; i < end; i++) {
        if (cancelled_at(recording->cancel, i))
            return error_set(error, ERROR_CANCELLED, "stopped");
        if (!isnan(recording->y[i]) && !(recording->cleaned && recording->findings->mask[i])) {
            t[n] = recording->t[i];
            y[n++] = recording->y[i] - recording->zero;
        }
    }
    if (n < min)
        return error_set(error, ERROR_COMMAND,
                         "%s has %zu samples in the window %.6g:%.6g; at least %zu are needed",
                         recording->name, n, recording->window[0], recording->window[1], min);
    *series = (struct series){
        t, y, n, recording->column[recording->value].quantity, recording->cancel, recording->pace};
    const struct collected *known = recording->collected;
    if (known && known->clock == CLOCK_ARRIVAL && known->rate.uncertainty > 0)
        series->pace = known->rate.uncertainty / known->rate.value;
    return true;
}
