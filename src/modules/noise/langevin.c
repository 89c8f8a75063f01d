/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command langevin: follows one path of the scene with noise. */
#include "modules/noise/setup.h" /* also needed for the rows */

#ifndef COMMAND_ROWS
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/result.h>

enum { PATH_INTERVALS = 1000, SHOWN_VARIABLES = 6 };

/* Paths of more steps are not followed again with half the step. */
static const int64_t steps_checked = 100000;

/* Columns of the table of a path. */
struct path_table {
    int n;
    double *column[LIMIT_VARIABLES + 1]; /* [rows] t and the variables */
};

/* Stores one recorded state in the table; `context` is the struct path_table. */
static void keep_row(void *context, size_t row, double t, const double *y)
{
    struct path_table *table = context;
    table->column[0][row] = t;
    for (int i = 0; i < table->n; i++)
        table->column[i + 1][row] = y[i];
}

/* Makes a table of `rows` rows with columns for t and all variables, in the arena; path->column are
 * the columns to be filled. Returns false if out of memory. */
static bool make_table(const struct system *system, size_t rows, struct arena *arena,
                       struct path_table *path, struct table *table)
{
    path->n = system->n;
    struct table_column *column = arena_array(arena, (size_t)system->n + 1, sizeof *column);
    for (int i = 0; column && i <= system->n; i++) {
        const struct variable variable =
            i ? system_variable(system, i - 1) : (struct variable){"t", QUANTITY_TIME};
        path->column[i] = arena_array(arena, rows, sizeof(double));
        column[i] = (struct table_column){.name = arena_text(arena, text_of(variable.name)),
                                          .unit = quantity_unit(variable.quantity),
                                          .value = path->column[i]};
        if (!path->column[i] || !column[i].name)
            return false;
    }
    *table = (struct table){.column = column, .columns = system->n + 1, .rows = rows};
    return column != NULL;
}

/* Appends the description of a path that ends in state end [n]. distance [n] is the distance from
 * the end with half the step, or NULL if that was not computed. */
static void put_path(const struct noise_setup *setup, const struct path_grid *grid,
                     const double *end, const double *distance, struct reply *reply)
{
    const struct system *system = &setup->forcing.system;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "a path over %s: %s, %lld step%s of %s, %zu rows\n",
                  SHOWN_QUANTITY(grid->span, QUANTITY_TIME, 6), setup->method->row.name,
                  (long long)grid->steps, plural_s(grid->steps),
                  SHOWN_QUANTITY(grid->h, QUANTITY_TIME, 6), grid->rows);
    noise_setup_put(setup, text);
    buffer_put(text, TEXT("\nat the end"));
    for (int i = 0; i < system->n && i < SHOWN_VARIABLES; i++)
        buffer_format(text, "%s %s = %s", i ? "," : "", system_variable(system, i).name,
                      SHOWN_QUANTITY(end[i], system_variable(system, i).quantity, 6));
    for (int i = 0; distance && i < system->n && i < SHOWN_VARIABLES; i++)
        buffer_format(text, "%s%s",
                      i ? ", " : "\nwith half the step and the same noise the end differs by: ",
                      SHOWN_QUANTITY(distance[i], system_variable(system, i).quantity, 2));
}

/* Reads the number of rows and sets up the path. Returns false with *error. */
static bool read_request(struct session *session, const struct arguments *args,
                         const struct noise_setup *setup, struct path_request *request,
                         struct error *error)
{
    const int64_t intervals = noise_integer(args, "rows", PATH_INTERVALS + 1) - 1;
    if (intervals < 1 || intervals >= PATH_ROWS_MAX)
        return error_at(error, argument_value(args, "rows")->where, "rows=N must be 2 to %d",
                        PATH_ROWS_MAX);
    *request = (struct path_request){.forcing = &setup->forcing,
                                     .method = setup->method,
                                     .seed = setup->seed,
                                     .cancel = session->front.cancel};
    const struct path_grid *grid = &request->grid;
    return noise_path_grid_make(&setup->forcing, setup->method, setup->span, setup->dt,
                                (size_t)intervals, &request->grid, error) &&
           noise_check_cost(session, args, setup,
                            8.0 * (double)grid->rows * (setup->forcing.system.n + 1),
                            (double)grid->steps, error);
}

/* Follows the path, stores it as a table and replies. Returns false with *error if it diverges or
 * if cancelled. */
static bool answer_path(struct session *session, const struct noise_setup *setup,
                        const struct path_request *request, struct arena *arena,
                        struct reply *reply, struct error *error)
{
    const struct path_grid *grid = &request->grid;
    const struct system *system = &setup->forcing.system;
    struct path_table path;
    struct table table;
    double end[LIMIT_VARIABLES], distance[LIMIT_VARIABLES];
    if (!make_table(system, grid->rows, arena, &path, &table))
        return error_memory(error);
    const int64_t steps = noise_path_follow(request, 0, end, keep_row, &path);
    if (cancelled(session->front.cancel))
        return error_set(error, ERROR_CANCELLED, "stopped; no path was kept");
    if (steps < grid->steps)
        return error_set(error, ERROR_NUMERICAL,
                         "the path diverged at t = %.6g s; try a smaller dt",
                         grid->t0 + (double)(steps + 1) * grid->h);
    session_changed(session);
    const bool checked =
        grid->steps <= steps_checked && noise_path_half_step(request, end, 1, distance);
    put_path(setup, grid, end, checked ? distance : NULL, reply);
    noise_setup_warn(setup, reply);
    reply_table_rows(reply, "langevin", &table, 0, table.rows, true);
    noise_keep_table(setup, grid->h, "langevin", NULL, arena, &table, reply);
    return true;
}

/* Follows one path, with memory of an arena that the stored table takes over. */
HANDLER(langevin)
{
    const struct noise_setup *setup = noise_setup_read(session, args, error);
    struct path_request request = {.seed = 0};
    struct arena arena = {0};
    const bool ok = setup && read_request(session, args, setup, &request, error) &&
                    answer_path(session, setup, &request, &arena, reply, error);
    arena_reset(&arena);
    return ok;
}
#endif

COMMAND(langevin, .group = "NOISE", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .quantity = QUANTITY_TIME), NOISE_ARGUMENTS,
                  NOISE_METHOD, KEY("rows", TYPE_INTEGER)))
