/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command lyapunov for the scene: exponents, checks of them, and their record. For runs and
 * recordings see lyapunov_series.c. */
#ifndef COMMAND_ROWS
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include "modules/dynamics/chaos.h"
#include "modules/dynamics/handlers.h"

#include <math.h>

#define ZERO_WITHIN_ERRORS 2 /* standard errors within which an exponent counts as 0 */

/* Appends a value with its error, or "not determined". */
static void put_measured(struct buffer *output, struct exponent value, enum quantity quantity)
{
    const double error = isfinite(value.error) ? value.error : 0;
    if (isfinite(value.value))
        buffer_measured(output, (struct measured){value.value, error}, quantity, 12);
    else
        buffer_put(output, TEXT("not determined"));
}

/* Returns the index of the exponent that is 0 within its error, as one has to be for an autonomous
 * flow that does not come to rest, or -1 if there is none. */
static int zero_of(const struct lyapunov *f)
{
    int zero = -1;
    for (int i = 0; i < f->count && f->period == 0 && !f->rests && f->determined; i++)
        if (fabs(f->exponent[i].value) <= ZERO_WITHIN_ERRORS * f->exponent[i].error &&
            (zero < 0 || fabs(f->exponent[i].value) < fabs(f->exponent[zero].value)))
            zero = i;
    return zero;
}

/* Appends a line for each exponent, and whether one is 0 as required. */
static void put_exponents(struct buffer *output, const struct lyapunov *f)
{
    const int zero = zero_of(f);
    for (int i = 0; i < f->count; i++) {
        buffer_format(output, "  %d  ", i + 1);
        put_measured(output, f->exponent[i], QUANTITY_RATE);
        if (i == zero)
            buffer_put(output, TEXT("   0 within its error, as required for a flow"));
        buffer_char(output, '\n');
    }
    if (zero < 0 && f->period == 0 && f->determined && f->count == f->n)
        buffer_put(output, f->rests
                               ? TEXT("the motion has come to rest, so no exponent has to be 0\n")
                               : TEXT("no exponent is 0 within its error: the motion escapes, or "
                                      "the time is too short\n"));
}

/* Appends what the exponents can be checked by: mean divergence, the stroboscopic map, pairs of
 * opposite sign; and the dimension that follows from them. */
static void put_checks(struct buffer *output, const struct lyapunov *f)
{
    if (f->count == f->n)
        buffer_format(output, "sum %.10g, mean divergence %.10g 1/s (difference %.1g)\n", f->sum,
                      f->divergence, fabs(f->sum - f->divergence));
    if (f->period > 0) {
        buffer_format(output, "a period of the drive (%.6g s):", f->period);
        for (int i = 0; i < f->count; i++)
            buffer_format(output, " %.5g", f->exponent[i].value * f->period);
        if (isfinite(f->strobe))
            buffer_format(output, "; equal to that of the stroboscopic map within %.1g",
                          f->strobe * f->period);
        buffer_char(output, '\n');
    }
    if (f->conservative && f->count == f->n) {
        double deviation = 0;
        for (int i = 0; i < f->n; i++)
            deviation =
                fmax(deviation, fabs(f->exponent[i].value + f->exponent[f->n - 1 - i].value));
        buffer_format(
            output, "energy is conserved: exponents form pairs of opposite sign, up to %.1g 1/s\n",
            deviation);
    }
    if (f->determined && isfinite(f->dimension.value)) {
        buffer_put(output, TEXT("Kaplan-Yorke dimension "));
        put_measured(output, f->dimension, QUANTITY_NUMBER);
        buffer_char(output, '\n');
    }
    if (f->regular)
        buffer_put(output, TEXT("regular motion: the means converge very fast\n"));
}

/* Appends the whole answer. `chosen` means that the time was not given by the user. */
static void put_lyapunov(struct buffer *output, const struct session *session,
                         const struct lyapunov *f, bool chosen)
{
    if (f->time > 0) {
        buffer_format(output, "Lyapunov exponent%s over %s, after %s%s\n", plural_s(f->count),
                      SHOWN_QUANTITY(f->time, QUANTITY_TIME, 6),
                      SHOWN_QUANTITY(f->skip, QUANTITY_TIME, 6),
                      chosen ? " ('over T' was chosen for about 2e6 evaluations)" : "");
        put_exponents(output, f);
        put_checks(output, f);
    }
    if (f->reason)
        buffer_format(output, "%s: %s\n", f->determined ? "ends early" : "not determined",
                      f->reason);
    buffer_format(output,
                  "%lld evaluations by %s at tol = %.0e ('method', 'dt' and 'tol' do not matter "
                  "here)",
                  (long long)f->evals, f->method, f->tol);
    put_seconds(output, session, f->seconds);
}

/* Adds the record `lyapunov`. */
static void reply_lyapunov(const struct lyapunov *f, struct reply *reply)
{
    reply_begin(reply, "lyapunov");
    reply_array(reply, "exponents");
    for (int i = 0; i < f->count; i++)
        reply_exponent(reply, f->exponent[i].value, f->exponent[i].error);
    reply_close(reply);
    reply_quantity(reply, "sum", f->time > 0 ? f->sum : NAN, "1/s");
    reply_quantity(reply, "divergence", f->time > 0 ? f->divergence : NAN, "1/s");
    reply_real(reply, "dimension", f->dimension.value);
    reply_real(reply, "dimension_uncertainty", f->dimension.error);
    reply_quantity(reply, "time", f->time, "s");
    reply_quantity(reply, "skip", f->skip, "s");
    reply_string(reply, "status", f->determined ? "ok" : "not determined");
    reply_string(reply, "reason", f->reason);
    reply_bool(reply, "regular", f->regular);
    reply_quantity(reply, "strobe", f->strobe, "1/s");
    reply_int(reply, "batches", f->batches);
    reply_int(reply, "evals", f->evals);
    reply_end(reply);
}

/* Finds exponents of the scene, or of a run or recording if the arguments name one. */
HANDLER(lyapunov)
{
    const struct argument_value *count = argument_value(args, "N"),
                                *duration = argument_value(args, "over"),
                                *skip = argument_value(args, "skip");
    struct lyapunov_request request = {.scene = &session->setup.scene,
                                       .skip = -1,
                                       .cancel = session->front.cancel,
                                       .progress = report_fraction,
                                       .context = &session->front};
    if (count->count)
        request.count = (int)fmin(count->item->value.value, LIMIT_VARIABLES);
    if (duration->count)
        request.duration = duration->item->value.value;
    if (skip->count)
        request.skip = skip->item->value.value;
    static const char *const series[] = {"run", "data", "RECORDING", "COLUMN", "window"};
    struct lyapunov found;
    for (size_t i = 0; i < COUNT_OF(series); i++)
        if (argument_value(args, series[i])->count)
            return lyapunov_of_series(session, args, reply, error);
    if (skip->count && request.skip < 0)
        return error_at(error, skip->where, "skip= must be a time, or 0");
    if (!lyapunov_find(&request, &found, error))
        return false;
    if (count->count && request.count > found.n)
        return error_at(error, count->where, "the scene has %d exponent%s", found.n,
                        found.n == 1 ? "" : "s");
    if (found.cancelled && !(found.time > 0))
        return error_set(error, ERROR_CANCELLED, "stopped before any mean was computed");
    put_lyapunov(reply_buffer(reply), session, &found, !duration->count);
    reply_lyapunov(&found, reply);
    return !found.cancelled || error_set(error, ERROR_CANCELLED, "stopped");
}
#endif

COMMAND(lyapunov, .group = "DYNAMICS", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("RECORDING", TYPE_RECORDING, .lead = "of"), PLACE("N", TYPE_INTEGER),
                  WORD("over", TYPE_VALUE, .quantity = QUANTITY_TIME),
                  KEY("skip", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  WORD("run", TYPE_RUN, .lead = "of", .group = 1),
                  WORD("data", TYPE_RECORDING, .lead = "of", .group = 1),
                  KEY("window", TYPE_RANGE, .quantity = QUANTITY_TIME),
                  PLACE("COLUMN", TYPE_COLUMN, .lead = "of"), OPTION("full", TYPE_NONE)))
