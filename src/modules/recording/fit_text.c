/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits as text: head, table of laws or parameters, verdicts; and reply_fit(), which adds text,
 * record and warnings to a reply. */
#include "modules/recording/fit_text.h"
#include <hooke/base/numeric.h>
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#define CORRELATION_STRONG 0.95 /* correlation of parameters that is reported */
/* Correlation above which the data cannot distinguish two parameters. */
#define CORRELATION_COMPLETE 0.999999
#define AUTOCORRELATION_NOTABLE 0.3 /* correlation of neighbouring residuals that is reported */
/* Digits beyond which an uncertainty is not shown, as it is rounding of a simulation. */
#define EXACT_DIGITS 12

void fit_add_warning(struct fit_summary *summary, const char *format, ...)
{
    if (summary->warnings == FIT_WARNINGS)
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(summary->warning[summary->warnings++], sizeof summary->warning[0], format, arguments);
    va_end(arguments);
}

/* Says nothing if the ends of the series are found to be as its inside. */
void fit_add_window(struct fit_summary *summary, enum window_law law, struct arena *arena)
{
    struct window_advice advice;
    if (summary->motion &&
        series_ends_as_inside(&summary->subject->series, TWO_PI / summary->motion->omega.value))
        return;
    advise_window(summary->subject, law, NAN, arena, &advice);
    if (advice.text[0])
        fit_add_warning(summary, "%s", advice.text);
}

/* Adds warnings about correlated residuals, parameters that cannot be told apart, and bounds. */
void fit_add_residuals(struct fit_summary *summary)
{
    const struct curve_fit *curve = summary->curve;
    if (curve->autocorrelation > AUTOCORRELATION_NOTABLE)
        fit_add_warning(summary,
                        "neighbouring residuals are correlated (%.2f): the curve lacks something, "
                        "or the recording sways; the uncertainties are widened accordingly",
                        curve->autocorrelation);
    for (int i = 0; i < curve->parameters; i++)
        for (int j = 0; j < i; j++)
            if (fabs(curve->correlation[i][j]) > CORRELATION_COMPLETE)
                fit_add_warning(summary,
                                "the data cannot tell %s and %s apart, because both change the "
                                "curve in the same way; keep one of them fixed",
                                summary->name[j], summary->name[i]);
    for (int j = 0; j < curve->parameters; j++)
        if (curve->bound[j])
            fit_add_warning(summary,
                            "%s is at the limit of its allowed range and has no uncertainty",
                            summary->name[j]);
}

/* A value that is measured shows the digits that its uncertainty warrants, any other six. */
void put_value(struct buffer *text, const char *name, struct measured value, enum quantity quantity,
               bool measured)
{
    const int digits = measured && value.uncertainty > 0 ? EXACT_DIGITS : 6;
    buffer_format(text, "%s = %s", name,
                  isfinite(value.value) ? SHOWN_MEASURED(value, quantity, digits) : "unknown");
}

/* If zero is not excluded for the rate, only a lower limit of the value is known. */
void put_reciprocal(struct buffer *text, const char *name, double top, struct measured rate,
                    enum quantity quantity, bool measured)
{
    double least;
    const struct measured value = measured_reciprocal(top, rate, &least);
    if (isfinite(least))
        buffer_format(text, "%s > %s", name, SHOWN_QUANTITY(least, quantity, 2));
    else if (isfinite(value.value))
        put_value(text, name, value, quantity, measured);
}

void put_pace(const struct series *series, struct buffer *text)
{
    static const double pace_negligible = 1e-5; /* relative */
    if (series->pace > pace_negligible)
        buffer_format(text, "\n  (including the uncertainty of the sampling rate, %.2g %%)",
                      100 * series->pace);
}

/* Appends the first line: model, subject, window, numbers of samples. */
static void put_head(const struct fit_summary *summary, struct buffer *text)
{
    const struct series *series = &summary->subject->series;
    const size_t used = summary->motion ? summary->motion->used : summary->curve->used;
    const size_t rejected = summary->motion ? summary->motion->rejected : summary->curve->rejected;
    buffer_format(text, "fit %s to %s, %.6g..%.6g s: %zu samples used, %zu rejected",
                  summary->model, summary->subject->name, series->t[0], series->t[series->n - 1],
                  used, rejected);
}

/* ---- an oscillation ---- */

/* Adds a cell with a rate and its uncertainty in brackets, in the last two digits. The unit is in
 * the heading, so that a row of three fits in 80 columns. */
static void cell_rate(struct text_table *table, struct measured value)
{
    const double u = value.uncertainty;
    const int decimals = u > 0 && u < 10 ? 1 - (int)floor(log10(u)) : 0;
    if (!isfinite(value.value) || (value.value == 0 && !(u > 0)))
        cell_text(table, "-");
    else if (!(u > 0) || decimals > 9)
        cell_format(table, "%.4g", value.value);
    else
        cell_format(table, "%.*f(%.0f)", decimals, value.value, u * pow(10, decimals));
}

/* Returns the unit of rate k: for positions in metres 1/m for b and m/s^2 for f, for angles and
 * plain numbers the same without the metre. */
const char *fit_rate_unit(const struct fit_summary *summary, int k)
{
    const enum quantity quantity = summary->subject->series.quantity;
    const bool metres = quantity == QUANTITY_LENGTH || quantity == QUANTITY_VELOCITY ||
                        quantity == QUANTITY_ACCELERATION;
    return metres ? drag_rates[k].unit : drag_rates[k].bare;
}

/* Appends the restoring force, if the fit compared several. */
static void put_forces(const struct fit_summary *summary, struct buffer *text)
{
    const struct drag_fit *drag = &summary->motion->drag;
    if (drag->forces == 0)
        return;
    const bool decided = drag->forces_remaining == 1u << drag->force;
    buffer_format(text, "\n  restoring force: %s%s",
                  decided ? "" : "not distinguishable: ", restoring_name(drag->force));
    for (int i = 0; i < drag->forces && !decided; i++)
        if (i != (int)drag->force && drag->forces_remaining >> i & 1)
            buffer_format(text, " or %s", restoring_name((enum restoring_force)i));
    buffer_put(text, TEXT(" (BIC"));
    for (int i = 0; i < drag->forces; i++)
        if (drag->restoring[i].converged)
            buffer_format(text, " %s %.1f", restoring_name((enum restoring_force)i),
                          drag->restoring[i].bic);
    buffer_put(text, TEXT(")"));
    if (drag->force == RESTORING_CUBIC) {
        put_value(text, ", beta", drag->cubic, QUANTITY_OTHER, summary->subject->recording);
        buffer_put(text, TEXT(" (SI)"));
    }
    if (drag->force != RESTORING_LINEAR)
        buffer_put(text, TEXT("\n  T and omega apply to small amplitudes"));
}

/* Adds a row of the table of laws. */
static void law_cells(const struct drag_candidate *c, struct text_table *table)
{
    cell_text(table, drag_law_name(c->law));
    for (int k = 0; k < DRAG_RATES; k++)
        cell_rate(table, c->rate[k]);
    if (!c->converged)
        cell_text(table, "no fit");
    else
        cell_format(table, isfinite(c->bic) ? "%.1f" : "-", c->bic);
}

/* Sets rank [candidates] to the laws ordered by BIC, the preferred one first. */
static void rank_laws(const struct fit *fit, int *rank)
{
    const struct drag_fit *drag = &fit->drag;
    for (int i = 0; i < drag->candidates; i++) {
        const struct drag_candidate *c = &drag->candidate[i];
        int position = i;
        for (; position > 0; position--) {
            const struct drag_candidate *previous = &drag->candidate[rank[position - 1]];
            const bool first = c->law == fit->preferred ||
                               (previous->law != fit->preferred && c->bic < previous->bic);
            if (!first)
                break;
            rank[position] = rank[position - 1];
        }
        rank[position] = i;
    }
}

/* Appends the table of the compared laws of damping, best first, and the verdict. */
static void put_laws(const struct fit_summary *summary, struct arena *arena, struct buffer *text)
{
    static const char *const names[DRAG_RATES] = {"gamma", "b", "f"};
    const struct drag_fit *drag = &summary->motion->drag;
    struct text_table table = {.arena = arena, .columns = 2 + DRAG_RATES, .gap = 2, .indent = 2};
    int rank[COUNT_OF(drag->candidate)];
    cell_text(&table, "law");
    for (int k = 0; k < DRAG_RATES; k++)
        cell_format(&table, "%s [%s]", names[k], fit_rate_unit(summary, k));
    cell_text(&table, "BIC");
    rank_laws(summary->motion, rank);
    for (int i = 0; i < drag->candidates; i++)
        law_cells(&drag->candidate[rank[i]], &table);
    buffer_char(text, '\n');
    text_table_put(&table, text);
    buffer_format(text, "  %s", drag->said);
    put_forces(summary, text);
}

/* Appends the values of an oscillation: period, damping, amplitude, phase, offset, rms, spring
 * constant, and the laws of damping if compared. */
static void put_motion(const struct fit_summary *summary, struct arena *arena, struct buffer *text)
{
    const struct fit *fit = summary->motion;
    const enum quantity quantity = summary->subject->series.quantity;
    put_value(text, "\n  T", fit->period, QUANTITY_TIME, summary->subject->recording);
    put_value(text, "   omega", fit->omega, QUANTITY_ANGULAR_FREQUENCY,
              summary->subject->recording);
    if (isfinite(fit->gamma.value)) {
        put_value(text, "\n  gamma", fit->gamma, QUANTITY_RATE, summary->subject->recording);
        buffer_put(text, TEXT("   (amplitude falls as exp(-gamma t/2))\n  "));
        if (fit->gamma.value + fit->gamma.uncertainty > 0) {
            put_reciprocal(text, "tau", 2, fit->gamma, QUANTITY_TIME, summary->subject->recording);
            put_reciprocal(text, "   Q", fit->omega.value, fit->gamma, QUANTITY_NUMBER,
                           summary->subject->recording);
        } else {
            const bool decays = fit->drag.best & (LAW_QUADRATIC | LAW_DRY);
            buffer_put(text,
                       decays ? TEXT("no linear damping; see the law below") : TEXT("no decay"));
        }
    }
    put_value(text, "\n  A", fit->amplitude, quantity, summary->subject->recording);
    put_value(text, "   offset", fit->offset, quantity, summary->subject->recording);
    put_value(text, "\n  phase", fit->phase, QUANTITY_ANGLE, summary->subject->recording);
    buffer_format(text, " at t = %.6g s", fit->t0);
    if (isfinite(summary->k.value))
        put_value(text, "\n  k", summary->k, QUANTITY_STIFFNESS, summary->subject->recording);
    buffer_format(text, "%s rms %s", isfinite(summary->k.value) ? "  " : "\n ",
                  SHOWN_QUANTITY(fit->rms, quantity, 3));
    if (isfinite(fit->halves[0].value) && isfinite(fit->halves[1].value)) {
        put_value(text, "\n  halves: gamma", fit->halves[0], QUANTITY_RATE,
                  summary->subject->recording);
        buffer_format(text, " and %s", SHOWN_MEASURED(fit->halves[1], QUANTITY_RATE, 4));
    }
    if (fit->drag.candidates > 0)
        put_laws(summary, arena, text);
    put_pace(&summary->subject->series, text);
    inputs_put(&summary->inputs, text);
    if (!isfinite(summary->k.value) && summary->spring)
        buffer_put(text, TEXT("\n  (set the mass, for example m = 200 g, to get k)"));
}

/* ---- a curve ---- */

/* Appends the table of a curve's parameters with their 95 % intervals. */
static void put_parameters(const struct fit_summary *summary, struct arena *arena,
                           struct buffer *text)
{
    const struct curve_fit *curve = summary->curve;
    struct text_table table = {.arena = arena, .columns = 3, .gap = 3, .indent = 2};
    static const char *const heads[] = {"parameter", "value", "95 % interval"};
    for (size_t i = 0; i < COUNT_OF(heads); i++)
        cell_text(&table, heads[i]);
    for (int j = 0; j < curve->parameters; j++) {
        const double *range = curve->interval[j], half = 0.5 * (range[1] - range[0]);
        /* The interval gets two digits of its half width; for a run these are only rounding. */
        const double size = fmax(fabs(range[0]), fabs(range[1]));
        const int digits = summary->subject->recording && half > 0 && size > half
                               ? (int)fmin(fmax(3 + floor(log10(size / half)), 6), 15)
                               : 6;
        cell_text(&table, summary->name[j]);
        cell_text(&table, SHOWN_MEASURED(curve->value[j], summary->quantity[j],
                                         summary->subject->recording ? EXACT_DIGITS : 8));
        if (curve->bound[j] || !curve->determined[j])
            cell_text(&table, curve->bound[j] ? "at its limit" : "not determined");
        else
            cell_format(&table, "%s .. %s", SHOWN_QUANTITY(range[0], summary->quantity[j], digits),
                        SHOWN_QUANTITY(range[1], summary->quantity[j], digits));
    }
    buffer_char(text, '\n');
    text_table_put(&table, text);
}

/* Parameters that the data do not determine have no correlation to judge by. */
bool fit_correlated(const struct curve_fit *curve, int i, int j)
{
    return curve->determined[i] && curve->determined[j] &&
           fabs(curve->correlation[i][j]) > CORRELATION_STRONG;
}

/* Appends the parameters of a fitted curve, its residuals, and pairs of parameters that are
 * correlated. */
static void put_curve(const struct fit_summary *summary, struct arena *arena, struct buffer *text)
{
    const struct curve_fit *curve = summary->curve;
    put_parameters(summary, arena, text);
    buffer_format(text, "  residuals: standard deviation %s, correlation of neighbours %.2f; %s",
                  SHOWN_QUANTITY(curve->sigma, summary->subject->series.quantity, 3),
                  curve->autocorrelation, curve->said);
    if (curve->bootstrapped > 0)
        buffer_format(text, "\n  intervals from %d synthetic recordings", curve->bootstrapped);
    const char *separator = "\n  correlated: ";
    for (int i = 0; i < curve->parameters; i++)
        for (int j = 0; j < i; j++)
            if (fit_correlated(curve, i, j)) {
                buffer_format(text, "%s%s and %s %.3f", separator, summary->name[j],
                              summary->name[i], curve->correlation[i][j]);
                separator = ", ";
            }
    if (summary->fixed)
        buffer_format(text, "\n  fixed: %s", summary->fixed);
    inputs_put(&summary->inputs, text);
}

/* Appends the whole text of a fit. */
static void put_fit(const struct fit_summary *summary, struct arena *arena, struct buffer *text)
{
    put_head(summary, text);
    if (summary->modes)
        put_modes(summary, text);
    else
        (summary->motion ? put_motion : put_curve)(summary, arena, text);
}

void reply_fit(const struct fit_summary *summary, struct arena *arena, struct reply *reply)
{
    if (reply_wants_text(reply))
        put_fit(summary, arena, reply_buffer(reply));
    reply_fit_record(summary, reply);
    for (int i = 0; i < summary->warnings; i++)
        reply_warning(reply, "%s", summary->warning[i]);
}
