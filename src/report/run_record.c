/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The record of a run for programs and files: its method, cost, present state, errors and energy
 * balance. */
#include <hooke/run/timing.h>
#include <hooke/base/unit.h>
#include <hooke/run/opinion.h>
#include <hooke/report.h>

#include <math.h>

/* Fills the fields of a record that are computed quickly; the others are completed when it is
 * written. */
void run_record_init(struct run_record *record, const struct session *session,
                     const struct run *run)
{
    *record = (struct run_record){
        .run = run,
        .number = run->number,
        .method = run->method->row.name,
        .dt = NAN,
        .tol = NAN,
        .y = NAN,
        .v = NAN,
        .rest = run_rest(run),
        .seconds = session->setup.settings.timing == TIMING_OFF ? NAN : run->seconds,
        .kinetic = NAN,
        .t = run->t,
        .steps = run->steps,
        .cost = run->cost,
        .data = run_data_distance(run, session_recording(session)),
        .status = run_status(run)};
    if (run->plan.adaptive)
        record->tol = run->settings.tol;
    else
        record->dt = run->settings.dt;
}

static bool is_mechanical(const void *row) /* second order, but not all forces have a potential */
{
    const struct system *system = &((const struct run_record *)row)->run->system;
    return system->order == 2 && !system->energy;
}

/* Returns true if the run was compared with a recording. */
static bool has_data(const void *row)
{
    return isfinite(((const struct run_record *)row)->data.rms);
}

/* Computes the fields that take long: energy balance, errors, and the second solution's estimates.
 */
static void run_record_complete(struct run_record *record)
{
    const struct run *run = record->run;
    const struct model *model = run->system.model;
    run_ledger(run, &record->ledger);
    /* The energies grow without bound at a singularity. */
    if (run->stop == STOP_SINGULAR)
        record->ledger.error_max = NAN;
    run_errors(run, &record->errors);
    run_below_tolerance(run, record->error_floor);
    if (is_mechanical(record))
        record->kinetic = run_observable(run, observable_energy(&run->system));
    const bool known = run_opinion_known(run);
    record->opinion_error = run_opinion_error(run);
    record->opinion_max = known ? run->opinion.max : NAN;
    record->opinion_t = known ? run->opinion.t : NAN;
    record->opinion_lost = known || !isnan(run_opinion_sunk(run)) ? run->opinion.lost : NAN;
    /* y and v remain unknown (NAN) if no digit of them is reliable. */
    const int variable[] = {model_variable(model, TEXT("y")), model_variable(model, TEXT("v"))};
    double *const value[] = {&record->y, &record->v};
    for (int i = 0; i < 2; i++)
        if (variable[i] >= 0 && !(record->error_floor[variable[i]] > 0))
            *value[i] = run->y[variable[i]];
}

/* Writes the state as an object; values without a reliable digit are null. */
static void put_state(struct reply *reply, const char *key, const void *row)
{
    const struct run *run = ((const struct run_record *)row)->run;
    const double *magnitude_floor = ((const struct run_record *)row)->error_floor;
    reply_object(reply, key);
    for (int i = 0; i < run->system.n; i++) {
        const struct variable variable = system_variable(&run->system, i);
        reply_quantity(reply, variable.name, magnitude_floor[i] > 0 ? NAN : run->y[i],
                       quantity_unit(variable.quantity));
    }
    reply_close(reply);
}

/* Writes the names of the variables without a reliable digit as an array. */
static void put_unreliable_variables(struct reply *reply, const char *key, const void *row)
{
    const struct run *run = ((const struct run_record *)row)->run;
    reply_array(reply, key);
    for (int i = 0; i < run->system.n; i++)
        if (((const struct run_record *)row)->error_floor[i] > 0)
            reply_string(reply, NULL, system_variable(&run->system, i).name);
    reply_close(reply);
}

#define AT(member) .offset = offsetof(struct run_record, member)
#define TIME_QUANTITY .quantity = QUANTITY_TIME

static const struct result_column of_run[] = {
    {.name = "run", .kind = COLUMN_INT, AT(number)},
    {.name = "method", .kind = COLUMN_NAME, AT(method)},
    {.name = "dt", AT(dt), TIME_QUANTITY},
    {.name = "tol", AT(tol)},
    {.name = "steps", .kind = COLUMN_COUNT, AT(steps)},
    {.name = "evals", .kind = COLUMN_COUNT, AT(cost.evals)},
    {.name = "turning_steps", .kind = COLUMN_COUNT, AT(cost.turns)},
    {.name = "t", AT(t), TIME_QUANTITY},
    {.name = "y", AT(y)},
    {.name = "v", AT(v)},
    {.name = "state", .record = put_state},
    {.name = "below_tolerance", .record = put_unreliable_variables},
    {.name = "energy", AT(ledger.final), .quantity = QUANTITY_ENERGY},
    {.name = "kinetic", AT(kinetic), .defined = is_mechanical, .quantity = QUANTITY_ENERGY},
    {.name = "energy_error", AT(ledger.error_max)},
    {.name = "error", AT(errors.max)},
    {.name = "error_estimate", AT(opinion_error)},
    {.name = "error_on_the_way", AT(opinion_max)},
    {.name = "estimated_to", AT(opinion_t), TIME_QUANTITY},
    {.name = "digits_lost_from", AT(opinion_lost), TIME_QUANTITY},
    {.name = "rest_from", AT(rest), TIME_QUANTITY},
    {.name = "rms_from_data", AT(data.rms), .defined = has_data},
    {.name = "data_gain", AT(data.gain), .defined = has_data},
    {.name = "data_at_zero", AT(data.at_zero), .defined = has_data},
    {.name = "status", .kind = COLUMN_NAME, AT(status)},
    {.name = "time", AT(seconds), TIME_QUANTITY},
};

static const struct result_columns columns = RESULT_COLUMNS(of_run, struct run_record);

void reply_run_record(struct run_record *record, struct reply *reply)
{
    run_record_complete(record);
    reply_records(reply, "run", &columns, record, 1);
}

/* Replies with the record of the current run, if there is one. */
void reply_current_run(const struct session *session, struct reply *reply)
{
    struct run_record record;
    if (!session_run(session))
        return;
    run_record_init(&record, session, session_run(session));
    reply_run_record(&record, reply);
}
