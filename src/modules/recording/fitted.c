/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The record of a fit, for programs and files. */
#include "modules/recording/fit_text.h"
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>

#include <assert.h>
#include <math.h>
#include <string.h>

/* Returns the value of the curve's parameter with that name, or NAN. */
static struct measured curve_parameter(const struct fit_summary *summary, const char *name)
{
    for (int j = 0; summary->curve && j < summary->curve->parameters; j++)
        if (summary->quantity[j] != QUANTITY_OTHER && strcmp(summary->name[j], name) == 0)
            return summary->curve->value[j];
    return (struct measured){NAN, NAN};
}

/* Adds the parameters of a curve and the pairs that are correlated to the record. */
static void reply_parameters(const struct fit_summary *summary, struct reply *reply)
{
    const struct curve_fit *curve = summary->curve;
    reply_array(reply, "parameters");
    for (int j = 0; curve && j < curve->parameters; j++) {
        reply_object(reply, NULL);
        reply_string(reply, "name", summary->name[j]);
        reply_real(reply, "value", curve->value[j].value);
        reply_real(reply, "uncertainty", curve->value[j].uncertainty);
        reply_string(reply, "unit",
                     summary->quantity[j] == QUANTITY_OTHER ? NULL
                                                            : quantity_unit(summary->quantity[j]));
        reply_real(reply, "low", curve->determined[j] ? curve->interval[j][0] : NAN);
        reply_real(reply, "high", curve->determined[j] ? curve->interval[j][1] : NAN);
        reply_close(reply);
    }
    reply_close(reply);
    reply_array(reply, "correlated");
    for (int i = 0; curve && i < curve->parameters; i++)
        for (int j = 0; j < i; j++)
            if (fit_correlated(curve, i, j)) {
                reply_object(reply, NULL);
                reply_string(reply, "a", summary->name[j]);
                reply_string(reply, "b", summary->name[i]);
                reply_real(reply, "r", curve->correlation[i][j]);
                reply_close(reply);
            }
    reply_close(reply);
}

/* Adds the rates of a law to the record. */
static void reply_rates(const struct fit_summary *summary, const struct drag_candidate *c,
                        struct reply *reply)
{
    for (int k = 0; k < DRAG_RATES; k++)
        if (c->law >> k & 1)
            reply_in_unit(reply, drag_rates[k].name, c->rate[k], fit_rate_unit(summary, k));
}

/* Adds the laws, their rates and the choice among them to the record. */
static void reply_laws(const struct fit_summary *summary, struct reply *reply)
{
    const struct drag_fit *drag = summary->motion ? &summary->motion->drag : NULL;
    reply_array(reply, "laws");
    for (int i = 0; drag && i < drag->candidates; i++) {
        const struct drag_candidate *c = &drag->candidate[i];
        reply_object(reply, NULL);
        reply_string(reply, "name", drag_law_name(c->law));
        reply_bool(reply, "converged", c->converged);
        reply_real(reply, "bic", c->bic);
        reply_object(reply, "parameters");
        reply_rates(summary, c, reply);
        reply_close(reply);
        reply_real(reply, "rms", c->rms);
        reply_close(reply);
    }
    reply_close(reply);
    const bool compared = drag && drag->candidates > 0;
    reply_array(reply, "remaining");
    for (int i = 0; compared && i < drag->candidates; i++)
        if (drag->remaining >> i & 1)
            reply_string(reply, NULL, drag_law_name(drag->candidate[i].law));
    reply_close(reply);
    const bool known =
        compared && (drag->forces == 0 || drag->forces_remaining == 1u << drag->force);
    reply_string(reply, "restoring", known ? restoring_name(drag->force) : NULL);
    const bool cubic = compared && drag->force == RESTORING_CUBIC;
    reply_if_known(reply, "beta", cubic ? drag->cubic : (struct measured){NAN, NAN},
                   QUANTITY_OTHER);
    reply_real(reply, "delta", compared ? drag->delta : NAN);
    reply_real(reply, "p_value", compared ? drag->p_value : NAN);
}

/* Values of the record that every kind of fit has. */
struct fit_record {
    const struct fit_summary *summary;
    struct fit fit; /* if a curve was fitted, only what it has */
    struct measured k;
    const char *preferred;
    double rms;
    int64_t used, rejected;
    bool converged;
};

/* Fills the record from a summary of either kind. */
static void fit_record_init(struct fit_record *record, const struct fit_summary *summary)
{
    static const struct measured none = {NAN, NAN};
    const struct curve_fit *curve = summary->curve;
    *record = (struct fit_record){.summary = summary,
                                  .fit = {.period = none,
                                          .omega = none,
                                          .amplitude = none,
                                          .phase = none,
                                          .gamma = curve_parameter(summary, "gamma"),
                                          .offset = curve_parameter(summary, "offset"),
                                          .halves = {none, none}},
                                  .k = summary->modes ? none : summary->k};
    if (curve)
        record->k = curve_parameter(summary, "k");
    if (summary->motion)
        record->fit = *summary->motion;
    assert(summary->motion || curve);
    const struct fit *fit = &record->fit;
    if (summary->motion && fit->preferred < LAW_UNDECIDED)
        record->preferred = drag_law_name(fit->preferred);
    record->rms = summary->motion ? fit->rms : curve->sigma;
    record->used = (int64_t)(summary->motion ? fit->used : curve->used);
    record->rejected = (int64_t)(summary->motion ? fit->rejected : curve->rejected);
    record->converged = summary->motion ? fit->converged : curve->converged;
}

/* Returns the summary of a record. */
static const struct fit_summary *summary_of(const void *row)
{
    return ((const struct fit_record *)row)->summary;
}

static const char *subject_of(const void *row)
{
    return summary_of(row)->subject->name;
}

static enum quantity series_quantity(const void *row)
{
    return summary_of(row)->subject->series.quantity;
}

static void put_window(struct reply *reply, const char *key, const void *row)
{
    const struct series *series = &summary_of(row)->subject->series;
    reply_reals(reply, key, (const double[]){series->t[0], series->t[series->n - 1]}, 2, "s");
}

static void put_halves(struct reply *reply, const char *key, const void *row)
{
    reply_object(reply, key);
    const struct measured *half = ((const struct fit_record *)row)->fit.halves;
    reply_reals(reply, "gamma", (const double[]){half[0].value, half[1].value}, 2, "1/s");
    reply_close(reply);
}

/* Adds the rates of the best law, or the parameters of a curve. */
static void put_law_or_parameters(struct reply *reply, const char *key, const void *row)
{
    const struct fit_summary *summary = summary_of(row);
    if (!summary->motion || summary->motion->drag.candidates == 0) {
        reply_parameters(summary, reply);
        return;
    }
    reply_object(reply, key);
    reply_rates(summary, &summary->motion->drag.candidate[summary->motion->drag.best - 1], reply);
    reply_close(reply);
    reply_array(reply, "correlated");
    reply_close(reply);
}

/* Adds laws and modes. */
static void put_candidates(struct reply *reply, const char *key, const void *row)
{
    (void)key;
    reply_laws(summary_of(row), reply);
    if (summary_of(row)->modes)
        reply_modes(summary_of(row), reply);
}

static void put_exact(struct reply *reply, const char *key, const void *row)
{
    (void)key;
    inputs_reply(&summary_of(row)->inputs, reply);
}

static void put_warnings(struct reply *reply, const char *key, const void *row)
{
    reply_array(reply, key);
    for (int i = 0; i < summary_of(row)->warnings; i++)
        reply_string(reply, NULL, summary_of(row)->warning[i]);
    reply_close(reply);
}

#define AT(member) .offset = offsetof(struct fit_record, member)
#define MEASURED(member, of) .kind = COLUMN_MEASURED, AT(member), .quantity = of

static const struct result_column of_fit[] = {
    {.name = "model",
     .kind = COLUMN_NAME,
     .pointer_offset = COLUMN_IN(struct fit_record, summary),
     .offset = offsetof(struct fit_summary, model)},
    {.name = "of", .kind = COLUMN_NAME, .text = subject_of},
    {.name = "period", MEASURED(fit.period, QUANTITY_TIME)},
    {.name = "omega", MEASURED(fit.omega, QUANTITY_ANGULAR_FREQUENCY)},
    {.name = "gamma", MEASURED(fit.gamma, QUANTITY_RATE)},
    {.name = "amplitude",
     .kind = COLUMN_MEASURED,
     AT(fit.amplitude),
     .quantity_of = series_quantity},
    {.name = "phase", MEASURED(fit.phase, QUANTITY_ANGLE)},
    {.name = "offset", .kind = COLUMN_MEASURED, AT(fit.offset), .quantity_of = series_quantity},
    {.name = "k", MEASURED(k, QUANTITY_STIFFNESS)},
    {.name = "rms", AT(rms), .quantity_of = series_quantity},
    {.name = "used", .kind = COLUMN_COUNT, AT(used)},
    {.name = "rejected", .kind = COLUMN_COUNT, AT(rejected)},
    {.name = "window", .record = put_window},
    {.name = "halves", .record = put_halves},
    {.name = "preferred", .kind = COLUMN_NAME, AT(preferred)},
    {.name = "parameters", .record = put_law_or_parameters},
    {.name = "laws", .record = put_candidates},
    {.name = "converged", .kind = COLUMN_BOOL, AT(converged)},
    {.name = "exact", .record = put_exact},
    {.name = "warnings", .record = put_warnings},
};

static const struct result_columns fit_columns = RESULT_COLUMNS(of_fit, struct fit_record);

void reply_fit_record(const struct fit_summary *summary, struct reply *reply)
{
    struct fit_record record;
    fit_record_init(&record, summary);
    reply_records(reply, "fit", &fit_columns, &record, 1);
}
