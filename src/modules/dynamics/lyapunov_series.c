/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command lyapunov for a recording or a run: the largest exponent and the correlation
 * dimension, found from the series alone, without the equations. */
#include <hooke/base/unit.h>
#include "modules/dynamics/series/series_exponent.h"
#include "modules/dynamics/handlers.h"

#include <math.h>

/* Appends the answer: exponent and dimension with their ranges, or why they are not determined.
 * `quantity` is that of the series. */
static void put_exponent(struct buffer *output, const char *name, const struct series_exponent *f,
                         enum quantity quantity)
{
    if (f->determined) {
        buffer_format(output,
                      "largest Lyapunov exponent of %s: %s, from %zu pairs of neighbours\n"
                      "distances grow exponentially from %s to %s, by a factor of %.3g\n",
                      name, SHOWN_MEASURED(f->value, QUANTITY_RATE, 6), f->pairs,
                      SHOWN_QUANTITY(f->t_begin, QUANTITY_TIME, 3),
                      SHOWN_QUANTITY(f->t_end, QUANTITY_TIME, 3), f->growth);
    } else
        buffer_format(output, "largest Lyapunov exponent of %s: not determined: %s\n", name,
                      f->reason);
    if (isfinite(f->dimension.value)) {
        buffer_format(output, "correlation dimension %s, at distances from %s to %s\n",
                      SHOWN_MEASURED(f->dimension, QUANTITY_NUMBER, 6),
                      SHOWN_QUANTITY(f->distance[0], quantity, 3),
                      SHOWN_QUANTITY(f->distance[1], quantity, 3));
    } else if (f->dimensions > 0)
        buffer_format(output, "correlation dimension: not determined: %s\n", f->dimension_reason);
    if (f->dimensions > 0)
        buffer_format(output,
                      "vectors of %d value%s, %s from one to the next; neighbours are farther "
                      "apart in time than %s",
                      f->dimensions, plural_s(f->dimensions),
                      SHOWN_QUANTITY(f->delay, QUANTITY_TIME, 3),
                      SHOWN_QUANTITY(f->theiler_window, QUANTITY_TIME, 3));
}

/* Adds the record `lyapunov`, with the keys that exponents of a scene have and those of the
 * series. */
static void reply_largest(const struct subject *subject, const struct series_exponent *f,
                          struct reply *reply)
{
    const struct series *s = &subject->series;
    reply_begin(reply, "lyapunov");
    reply_string(reply, "of", subject->name);
    reply_array(reply, "exponents");
    reply_exponent(reply, f->value.value, f->value.uncertainty);
    reply_close(reply);
    reply_quantity(reply, "sum", NAN, "1/s");
    reply_quantity(reply, "divergence", NAN, "1/s");
    reply_real(reply, "dimension", f->dimension.value);
    reply_real(reply, "dimension_uncertainty", f->dimension.uncertainty);
    reply_quantity(reply, "time", s->t[s->n - 1] - s->t[0], "s");
    reply_string(reply, "status", f->determined ? "ok" : "not determined");
    reply_string(reply, "reason", f->reason[0] ? f->reason : NULL);
    reply_quantity(reply, "delay", f->dimensions > 0 ? f->delay : NAN, "s");
    reply_int(reply, "values", f->dimensions);
    reply_quantity(reply, "from", f->determined ? f->t_begin : NAN, "s");
    reply_quantity(reply, "to", f->determined ? f->t_end : NAN, "s");
    reply_real(reply, "growth", f->determined ? f->growth : NAN);
    reply_int(reply, "pairs", (long long)f->pairs);
    reply_end(reply);
}

/* Arguments that only apply to scenes are refused. */
bool lyapunov_of_series(struct session *session, const struct arguments *args, struct reply *reply,
                        struct error *error)
{
    static const char *const of_scene[] = {"N", "over", "skip"};
    const struct argument_value *recording = argument_value(args, "RECORDING"),
                                *column = argument_value(args, "COLUMN"),
                                *window = argument_value(args, "window");
    struct subject subject;
    struct series_exponent found;
    for (size_t i = 0; i < COUNT_OF(of_scene); i++)
        if (argument_value(args, of_scene[i])->count)
            return error_at(
                error, argument_value(args, of_scene[i])->where,
                "%s applies to the exponents of the scene; of a series only the largest is found",
                of_scene[i]);
    if (!subject_open(session, argument_value(args, "run"),
                      recording->count ? recording : argument_value(args, "data"), window, false, 2,
                      args->arena, &subject, error) ||
        (column->count && !subject_column(&subject, column, window, args->arena, error)) ||
        !series_exponent(&subject.series, args->arena, &found, error))
        return false;
    put_exponent(reply_buffer(reply), subject.name, &found, subject.series.quantity);
    reply_largest(&subject, &found, reply);
    return true;
}
