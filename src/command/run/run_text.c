/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The line that describes a run after each advance, and how a recording compares with it. */
#include <hooke/data.h>
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include <hooke/command/handler.h>

#include <math.h>

#define STANDARD_GRAVITY 9.80665 /* [m/s^2] */
#define NEAR_GRAVITY 0.05        /* relative error that a sensor may have */

/* Returns the mean [m/s^2] of a recorded acceleration if it is that of gravity, in either
 * direction, within the error of a sensor; else NAN. */
static double gravity_in(const struct recording *recording)
{
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < recording->rows; i++)
        if (isfinite(recording->y[i])) {
            sum += recording->y[i] - recording->zero;
            count++;
        }
    const double mean = sum / (double)count;
    const bool is_close = fabs(fabs(mean) - STANDARD_GRAVITY) < NEAR_GRAVITY * STANDARD_GRAVITY;
    return is_close && recording->column[recording->value].quantity == QUANTITY_ACCELERATION ? mean
                                                                                             : NAN;
}

/* Tells the user why a recording of the same time as the run is not compared with the run or, if
 * the recording has no unit, in which unit it is compared; also that an acceleration contains
 * gravity. */
static void reply_not_compared(const struct session *session, const struct run *run,
                               struct reply *reply)
{
    const struct recording *recording = session_recording(session);
    const struct variable first = system_variable(&run->system, 0);
    const bool bare = recording && recorded_bare(recording);
    const double gravity =
        recording && recorded_derivative(recording, run) == 2 ? gravity_in(recording) : NAN;
    if (recording && isfinite(gravity))
        reply_line(reply,
                   "%s contains gravity (mean %.4g m/s^2), which the rms includes; 'data zero %.6g "
                   "m/s^2' removes it",
                   recording->name, gravity, recording->zero + gravity);
    if (!recording || run->system.order != 2 || run->system.n != 2 ||
        (recorded_derivative(recording, run) >= 0 && !bare) ||
        !(fmin(run->system.t0, run->t) < recording->window[1] &&
          fmax(run->system.t0, run->t) > recording->window[0]))
        return;
    const struct column *value = &recording->column[recording->value];
    const char *needs = first.quantity == QUANTITY_ANGLE ? "deg" : "cm";
    if (!bare) {
        reply_line(reply, "%s is not compared with the run: it is %s %s, but %s is %s %s",
                   recording->name, quantity_article(value->quantity),
                   quantity_name(value->quantity), first.name, quantity_article(first.quantity),
                   quantity_name(first.quantity));
        return;
    }
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%s: %s ", recording->name, value->name);
    put_bare(recording, text);
    buffer_format(text, ": compared with the run as if in %s ('load FILE unit=%s' changes that)",
                  quantity_unit(first.quantity), needs);
}

/* Explains how a recording of a quantity that is no motion is scaled to the run. */
static void reply_scale(const struct session *session, const struct run *run,
                        const struct data_distance *data, struct reply *reply)
{
    if (!data->scaled || !isfinite(data->rms))
        return;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%s: ", session_recording(session)->name);
    if (isfinite(data->gain)) {
        buffer_put(text, TEXT("scaled: "));
        put_scale(data, run, text);
    } else {
        buffer_format(text, "not compared with the run: %s and %s are not proportional",
                      quantity_name(data->quantity), system_variable(&run->system, 0).name);
    }
}

/* Replies that most of the rms is a constant distance between recording and run, and what removes
 * it. */
static void reply_offset(const struct session *session, const struct data_distance *data,
                         struct reply *reply)
{
    if (!isfinite(data->rms) || !isfinite(data->offset))
        return;
    const struct recording *recording = session_recording(session);
    const enum quantity own = recording->column[recording->value].quantity;
    reply_line(reply,
               "%s is on average %s %s the run, which is most of the rms: 'fit' and 'adopt' find "
               "its zero; 'data zero %s' sets it",
               recording->name, SHOWN_QUANTITY(fabs(data->offset), data->quantity, 3),
               data->offset > 0 ? "above" : "below",
               SHOWN_QUANTITY(recording->zero + data->offset, own, 4));
}

/* Appends the largest relative error of the energy, or of the energy balance if drag or a drive
 * changes the energy. In long runs only some rows are sampled or, if even that would take too long,
 * the energy at the end is given instead. If a notable error comes from a peak of the energy during
 * the run, the peak is given, too. Appends nothing for a run that ends at a singularity. */
static void put_energy(const struct run *run, struct buffer *text)
{
    const double notable = 1e-3; /* relative to E0; smaller errors need no explanation */
    const bool balanced = run->plan.ledger;
    struct ledger ledger;
    run_ledger_brief(run, &ledger);
    if (run->stop == STOP_SINGULAR)
        return;
    if (!isfinite(ledger.error_max)) {
        if (run->steps > 0 && isfinite(ledger.factor) && balanced)
            buffer_format(text, ", E = %s E0", SHOWN_SHORT(ledger.factor, 3));
        else if (run->steps > 0 && isfinite(ledger.factor))
            buffer_format(text, ", dE/E0 %s at the end", SHOWN_SHORT(ledger.factor - 1, 2));
        return;
    }
    const char *error = SHOWN_SHORT(ledger.error_max, 2);
    if (balanced && ledger.error_max >= 1)
        buffer_format(text, ", energy balance wrong by %s times E0", error);
    else if (balanced)
        buffer_format(text, ", energy balance within %s of E0", error);
    else
        buffer_format(text, ", dE/E0 max %s%s", error,
                      isnan(ledger.work) ? " in sampled rows" : "");
    const double peak = ledger.error_max > notable ? run_energy_peak(run, &ledger) : NAN;
    if (!isnan(peak))
        buffer_format(text, " (E up to %s E0)", SHOWN_SHORT(peak, 2));
}

/* Replies with the run's line (time, steps, energy error, distance from the recording) and its
 * record. */
void reply_run(const struct session *session, const struct run *run, struct reply *reply)
{
    struct run_record record;
    if (reply->quiet && !reply_wants_records(reply))
        return;
    run_record_init(&record, session, run);
    const struct data_distance *data = &record.data;
    const int digits = session->setup.settings.digits;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "t = %s, %lld step%s, %s",
                  SHOWN_VALUE(run->t, QUANTITY_TIME, digits > 6 ? digits : 6),
                  (long long)run->steps, plural_s(run->steps), run->method->row.name);
    put_energy(run, text);
    if (run->cost.turns > 0)
        buffer_format(text, ", %lld extra step%s to end at %s", (long long)run->cost.turns,
                      plural_s(run->cost.turns),
                      run->system.switches > run->system.dry ? "switches" : "turning points");
    if (isfinite(record.rest))
        buffer_format(text, ", held by dry friction from %s on",
                      SHOWN_QUANTITY(record.rest, QUANTITY_TIME, 4));
    if (isfinite(data->rms)) {
        buffer_format(text, ", rms(%s-data) = %s", run_derivative(run, data->derivative).name,
                      SHOWN_QUANTITY(data->rms, data->quantity, 2));
        if (data->bad > 0)
            buffer_format(text, " (%zu bad sample%s left out)", data->bad,
                          plural_s((int64_t)data->bad));
    }
    reply_scale(session, run, data, reply);
    reply_offset(session, data, reply);
    reply_not_compared(session, run, reply);
    if (reply_wants_records(reply))
        reply_run_record(&record, reply);
}
