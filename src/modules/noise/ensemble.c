/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command ensemble: follows many paths of the scene with noise, and replies their
 * statistics. */
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include "modules/noise/setup.h" /* also needed for the rows */

#ifndef COMMAND_ROWS
#include <stdlib.h>

enum { ENSEMBLE_INTERVALS = 200, ENSEMBLE_SHOWN = 4 };

/* The ensemble of one command with all that the reply needs. */
struct answer {
    const struct noise_setup *setup;
    struct path_request request;
    struct path_column column;
    struct variable shown;
    struct ensemble ensemble;
    struct ensemble_row *row;        /* [ensemble.rows] */
    struct measured kinetic, virial; /* [J] m<v^2> and -<(y - <y>) F> at the end; NAN */
    /* change at the end if the step is halved, relative to the spread; NAN if unknown */
    double half_step;
};

/* ---- checks at the end of the paths ---- */

/* Returns the mean of a variable over the paths that reach the end. */
static struct measured mean_at_end(const struct answer *answer, int variable, double *scratch)
{
    size_t count = 0;
    const int n = answer->setup->forcing.system.n;
    for (int64_t path = 0; path < answer->ensemble.paths; path++)
        if (!isnan(answer->ensemble.end[path * n]))
            scratch[count++] = answer->ensemble.end[path * n + variable];
    return noise_mean_of(scratch, count);
}

/* Computes the means at the end, over paths and coordinates, of m v^2 (answer->kinetic) and, if an
 * equilibrium is possible, of -(y - <y>) F (answer->virial), which are kT in equilibrium. They are
 * NAN without velocities or temperature. */
static void find_temperature(struct answer *answer, double *scratch)
{
    const struct noise_forcing *forcing = &answer->setup->forcing;
    const struct system *system = &forcing->system;
    const int n = system->n, half = n / 2;
    const bool rests = system->autonomous && !forcing->other_drag;
    answer->kinetic = answer->virial = (struct measured){NAN, NAN};
    if (system->order != 2 || isnan(forcing->energy))
        return;
    double middle[LIMIT_VARIABLES];
    for (int i = 0; i < half; i++)
        middle[i] = mean_at_end(answer, i, scratch).value;
    for (int which = 0; which <= rests; which++) {
        size_t count = 0;
        for (int64_t path = 0; path < answer->ensemble.paths; path++) {
            const double *y = answer->ensemble.end + path * n;
            double force[LIMIT_VARIABLES], sum = 0;
            if (isnan(y[0]))
                continue;
            system_force(system, system->t0 + answer->request.grid.span, y, force);
            for (int i = 0; i < half; i++) {
                const double mass = system->mass * (system->ratio[i] > 0 ? system->ratio[i] : 1);
                const double v = y[half + i];
                sum += mass * (which ? -(y[i] - middle[i]) * force[i] : v * v);
            }
            scratch[count++] = sum / half;
        }
        const struct measured mean = noise_mean_of(scratch, count);
        const double share = (double)count / (double)(count - 1);
        if (!which)
            answer->kinetic = mean;
        else if (count > 1) /* <y> is the mean of the same paths, as in a variance */
            answer->virial = (struct measured){mean.value * share, mean.uncertainty * share};
    }
}

/* Sets answer->half_step to the error of the step size: how much halving the step changes the end
 * of a path, in standard deviations of the ensemble, for the variable that changes most. It is
 * measured on a few paths with the same noise, and NAN if there are too few or some diverged.
 * `scratch` has room for a value per path. */
static void find_half_step(struct answer *answer, double *scratch)
{
    /* Takes at most a tenth of the work. */
    enum { SHARE = 20, PATHS_MAX = 20 };
    const int64_t few = answer->ensemble.paths / SHARE;
    const int n = answer->setup->forcing.system.n;
    double distance[LIMIT_VARIABLES];
    answer->half_step = NAN;
    if (few == 0 || answer->ensemble.diverged ||
        !noise_path_half_step(&answer->request, answer->ensemble.end,
                              few < PATHS_MAX ? few : PATHS_MAX, distance))
        return;
    for (int i = 0; i < n; i++) {
        const double root = sqrt((double)answer->ensemble.paths);
        const double spread = mean_at_end(answer, i, scratch).uncertainty * root;
        if (spread > 0)
            answer->half_step =
                fmax(isnan(answer->half_step) ? 0 : answer->half_step, distance[i] / spread);
    }
}

/* ---- text and records ---- */

static enum quantity row_quantity(const void *row)
{
    return ((const struct ensemble_row *)row)->quantity;
}

#define AT(member) .offset = offsetof(struct ensemble_row, member)
#define STATISTIC(member) .quantity_of = row_quantity, AT(member), .digits = 4

static const struct result_column of_row[] = {
    {.name = "t", .quantity = QUANTITY_TIME, AT(t), .digits = 4, .index = 1, .heading = "t"},
    {.name = "mean", STATISTIC(mean), .index = 2, .heading = "mean"},
    {.name = "sd", STATISTIC(sd), .index = 3, .heading = "sd"},
    {.name = "low", STATISTIC(low), .index = 4, .heading = "5 %"},
    {.name = "lower_quartile", STATISTIC(lower)},
    {.name = "median", STATISTIC(median), .index = 5, .heading = "median"},
    {.name = "upper_quartile", STATISTIC(upper)},
    {.name = "high", STATISTIC(high), .index = 6, .heading = "95 %"},
    {.name = "paths", .kind = COLUMN_COUNT, AT(paths)},
};
static const struct result_columns row_columns = RESULT_COLUMNS(of_row, struct ensemble_row);

/* Appends a table of a few rows, evenly spaced in time. */
static void put_rows(const struct answer *answer, struct arena *arena, struct buffer *text)
{
    struct text_table table = {.arena = arena, .gap = 3};
    struct ensemble_row shown[ENSEMBLE_SHOWN + 1];
    const size_t last = answer->ensemble.rows - 1;
    size_t count = 0;
    for (size_t i = 0, previous = SIZE_MAX; i <= ENSEMBLE_SHOWN; i++) {
        const size_t place = i * last / ENSEMBLE_SHOWN;
        if (place != previous)
            shown[count++] = answer->row[place];
        previous = place;
    }
    columns_text(&row_columns, shown, count, true, &table);
    text_table_put(&table, text);
}

/* Appends the temperatures and the effect of half the step at the end. */
static void put_end(const struct answer *answer, struct buffer *text)
{
    const enum quantity energy = noise_energy_quantity(answer->setup);
    if (!isnan(answer->kinetic.value))
        buffer_format(text, "m<v^2> at the end: %s\n", SHOWN_MEASURED(answer->kinetic, energy, 4));
    if (!isnan(answer->virial.value))
        buffer_format(text, "-<(y - <y>) F> at the end: %s; both are kT in equilibrium\n",
                      SHOWN_MEASURED(answer->virial, energy, 4));
    if (!isnan(answer->half_step))
        buffer_format(
            text,
            "with half the step and the same noise, paths end at most %.2g %% of the spread away\n",
            100 * answer->half_step);
}

/* Appends the answer's text: set-up, table of a few rows, and temperatures at the end. */
static void put_ensemble(const struct answer *answer, struct arena *arena, struct reply *reply)
{
    const struct path_grid *grid = &answer->request.grid;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%lld paths of %s over %s: %s, %lld step%s of %s\n",
                  (long long)answer->ensemble.paths, answer->shown.name,
                  SHOWN_QUANTITY(grid->span, QUANTITY_TIME, 6), answer->setup->method->row.name,
                  (long long)grid->steps, plural_s(grid->steps),
                  SHOWN_QUANTITY(grid->h, QUANTITY_TIME, 6));
    noise_setup_put(answer->setup, text);
    buffer_char(text, '\n');
    put_rows(answer, arena, text);
    put_end(answer, text);
}

/* Adds the record `ensemble` with set-up, temperatures and an array for each column. */
static void reply_ensemble(const struct answer *answer, struct reply *reply)
{
    reply_begin(reply, "ensemble");
    reply_int(reply, "n", answer->ensemble.paths);
    reply_string(reply, "of", answer->shown.name);
    reply_string(reply, "unit", quantity_unit(answer->shown.quantity));
    noise_setup_reply(answer->setup, &answer->request.grid, reply);
    reply_int(reply, "diverged", answer->ensemble.diverged);
    const enum quantity energy = noise_energy_quantity(answer->setup);
    reply_measured(reply, "kinetic", answer->kinetic, energy);
    reply_measured(reply, "virial", answer->virial, energy);
    reply_real(reply, "half_step", answer->half_step);
    for (const struct result_column *c = of_row; c->kind == COLUMN_REAL; c++) {
        reply_array(reply, c == of_row ? "times" : c->name);
        for (size_t i = 0; i < answer->ensemble.rows; i++)
            reply_real(reply, NULL, *(const double *)((const char *)&answer->row[i] + c->offset));
        reply_close(reply);
    }
    reply_end(reply);
}

/* ---- the command ---- */

/* Follows the paths and computes their statistics. Returns false with *error if all diverge, if out
 * of memory or cancelled. */
static bool make_answer(struct session *session, const struct arguments *args,
                        struct answer *answer, struct error *error)
{
    struct ensemble *ensemble = &answer->ensemble;
    const int64_t paths = noise_integer(args, "N", 0);
    if (!noise_ensemble_follow(&answer->request, &answer->column, paths,
                               noise_parallel(session, args), ensemble, error))
        return false;
    if (ensemble->diverged == paths)
        return error_set(error, ERROR_NUMERICAL, "all paths diverged; try a smaller dt");
    double *scratch = arena_array(args->arena, 2 * (size_t)paths, sizeof *scratch);
    answer->row = arena_array(args->arena, ensemble->rows, sizeof *answer->row);
    if (!scratch || !answer->row)
        return error_memory(error);
    for (size_t i = 0; i < ensemble->rows; i++) {
        if (cancelled(session->front.cancel))
            return error_set(error, ERROR_CANCELLED, "stopped; no ensemble was kept");
        answer->row[i] = noise_ensemble_statistics(ensemble, &answer->request.grid, i, scratch);
        answer->row[i].quantity = answer->shown.quantity;
    }
    find_temperature(answer, scratch);
    find_half_step(answer, scratch);
    return true;
}

/* Runs the command `ensemble` after its set-up is read: reads N and rows, follows the paths,
 * replies with the summary and keeps the table as a result. Returns false with *error if an
 * argument is out of range, the cost is not allowed, or following fails. */
static bool answer_ensemble(struct session *session, const struct arguments *args,
                            struct answer *answer, struct reply *reply, struct error *error)
{
    const struct noise_setup *setup = answer->setup;
    const int64_t paths = noise_integer(args, "N", 0);
    const int64_t intervals = noise_integer(args, "rows", ENSEMBLE_INTERVALS + 1) - 1;
    if (paths < 2 || paths >= UINT32_MAX)
        return error_at(error, argument_value(args, "N")->where,
                        "N is the number of paths, at least 2");
    if (intervals < 1 || intervals >= PATH_ROWS_MAX)
        return error_at(error, argument_value(args, "rows")->where, "rows=N must be 2 to %d",
                        PATH_ROWS_MAX);
    answer->request = (struct path_request){.forcing = &setup->forcing,
                                            .method = setup->method,
                                            .seed = setup->seed,
                                            .cancel = session->front.cancel};
    struct path_grid *grid = &answer->request.grid;
    const struct parallel parallel = noise_parallel(session, args);
    if (!noise_path_grid_make(&setup->forcing, setup->method, setup->span, setup->dt,
                              (size_t)intervals, grid, error) ||
        !noise_check_cost(session, args, setup, noise_ensemble_bytes(&answer->request, paths),
                          (double)grid->steps * (double)paths / parallel_threads(&parallel, paths),
                          error) ||
        !make_answer(session, args, answer, error))
        return false;
    session_changed(session);
    if (answer->ensemble.diverged)
        reply_warning(reply,
                      "%lld of %lld paths diverged and are left out from then on; dt is too large",
                      (long long)answer->ensemble.diverged, (long long)paths);
    noise_setup_warn(setup, reply);
    if (reply_wants_text(reply))
        put_ensemble(answer, args->arena, reply);
    reply_ensemble(answer, reply);
    struct arena arena = {0};
    struct table table;
    if (columns_table(&row_columns, answer->row, answer->ensemble.rows, &arena, &table))
        noise_keep_table(setup, grid->h, "ensemble", answer->shown.name, &arena, &table, reply);
    return true;
}

/* Runs the command `ensemble`: reads its set-up and the observed column, follows and answers
 * (answer_ensemble()), and frees both. */
HANDLER(ensemble)
{
    struct answer answer = {.setup = noise_setup_read(session, args, error)};
    const bool ok =
        answer.setup &&
        noise_column(session, args, answer.setup, &answer.column, &answer.shown, error) &&
        answer_ensemble(session, args, &answer, reply, error);
    noise_ensemble_free(&answer.ensemble);
    if (answer.column.run)
        run_destroy(answer.column.run);
    return ok;
}
#endif

COMMAND(ensemble, .group = "NOISE", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("N", TYPE_INTEGER, .flags = ARG_REQUIRED),
                  PLACE("DURATION", TYPE_VALUE, .quantity = QUANTITY_TIME), WORD("of", TYPE_COLUMN),
                  NOISE_ARGUMENTS, NOISE_METHOD, KEY("rows", TYPE_INTEGER),
                  OPTION("threads", TYPE_INTEGER)))
