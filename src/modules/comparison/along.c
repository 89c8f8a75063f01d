/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The study behind `plot compare`: errors of methods against the reference at each time of the
 * common grid, as a table with one row per method and time. */
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/plot/drawing.h>
#include <hooke/report.h>
#include "modules/comparison/compute/errors.h"
#include "modules/comparison/comparison.h"
#include "modules/comparison/plots.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A row of that table. */
struct along_row {
    char curve[80]; /* "rk4", or "rk4 dt=10 ms" where a method has several settings */
    double t;       /* [s] */
    /* distance from the reference, in amplitudes; NAN at the start and where the run did not
     * arrive */
    double error;
};

#define MEMBER(member) .offset = offsetof(struct along_row, member)
static const struct result_column of_along[] = {
    {.name = "method", .kind = COLUMN_CHARS, MEMBER(curve)},
    {.name = "t", .quantity = QUANTITY_TIME, MEMBER(t)},
    {.name = "error", MEMBER(error)},
};
static const struct result_columns along_columns = RESULT_COLUMNS(of_along, struct along_row);

/* A method that takes part, with its fixed step or its tolerance. */
struct contestant {
    const struct method *method;
    double dt, tol; /* [s] and a number; NAN for the one that the method does not use */
    enum drag drag;
};

/* Returns the value in a row of the named column of numbers, or NAN if the table has no such
 * column. */
static double column_value(const struct table *table, const char *name, size_t row)
{
    const struct table_column *column = table_column_named(table, name);
    return column && column->value ? column->value[row] : NAN;
}

/* Returns the drag variant of the compared run, or DRAG_DEFAULT if the run is no longer kept. */
static enum drag drag_of_row(const struct session *session, const struct table *table, size_t row)
{
    char number[24];
    snprintf(number, sizeof number, "%.0f", column_value(table, "run", row));
    const int index = session_find_run(session, text_of(number));
    return index < 0 ? DRAG_DEFAULT : session->runs.slot[index]->run->settings.drag;
}

/* Returns the methods to compare, an array [*count] in the arena: the given ones with the session's
 * tol (adaptive methods) or dt, or, if `methods` is 0, those of the last `compare` with the
 * settings they had then. Returns NULL if out of memory. */
static struct contestant *choose_contestants(const struct session *session,
                                             const struct row *const *method, int methods,
                                             int *count, struct arena *arena)
{
    const struct settings *settings = &session->setup.settings;
    const struct table *last = methods ? NULL : drawing_stored(session, "compare");
    const size_t rows = last ? last->rows : 0;
    struct contestant *list = arena_array(arena, rows + (size_t)methods + 1, sizeof *list);
    *count = 0;
    for (size_t i = 0; list && i < rows; i++)
        list[(*count)++] =
            (struct contestant){method_find(last->column[0].text[i]), column_value(last, "dt", i),
                                column_value(last, "tol", i), drag_of_row(session, last, i)};
    for (int i = 0; list && i < methods; i++) {
        const struct method *one = method_from(method[i]);
        const bool adapts = one->flags & METHOD_ADAPTIVE && settings->tol > 0;
        struct contestant *added = &list[(*count)++];
        *added = (struct contestant){one, NAN, NAN, DRAG_DEFAULT};
        if (adapts)
            added->tol = settings->tol;
        else
            added->dt = settings->dt;
    }
    return list;
}

/* Writes the name of curve i of `count` to curve [80]: that of its method, with step or tolerance
 * if several curves have that method. */
static void name_curve(const struct contestant *contestants, int count, int i, char curve[80])
{
    const struct contestant *c = &contestants[i];
    bool again = false;
    for (int k = 0; k < count; k++)
        again |= k != i && contestants[k].method == c->method;
    if (!again)
        snprintf(curve, 80, "%s", c->method->row.name);
    else if (c->tol > 0)
        snprintf(curve, 80, "%s tol=%.3g", c->method->row.name, c->tol);
    else
        snprintf(curve, 80, "%s dt=%s", c->method->row.name,
                 SHOWN_QUANTITY(c->dt, QUANTITY_TIME, 4));
}

/* Solves once with a method and appends to rows [*n], for each of STUDY_TIMES times, the distance
 * from the reference, named `curve`. A distance of 0, which a logarithmic axis cannot show, is NAN.
 * Returns false with an error if the method does not apply to the scene or if out of memory. */
static bool add_errors(const struct system *system, const struct reference *reference,
                       const struct contestant *c, const char *curve, const struct cancel *cancel,
                       struct along_row *rows, size_t *n, struct error *error)
{
    struct run_settings settings = {.drag = c->drag, .kernel = KERNEL_SPECIALISED};
    if (c->tol > 0)
        settings.tol = c->tol;
    else
        settings.dt = c->dt;
    if (!method_applies(c->method, system, &settings.drag, error))
        return false;
    double *grid = malloc((size_t)STUDY_TIMES * (size_t)system->n * sizeof *grid);
    struct solver solver;
    const bool ok = grid && solver_init(&solver, system, c->method, &settings, reference->span);
    if (ok) {
        solver_run(&solver, grid, cancel);
        for (int k = 0; k < STUDY_TIMES; k++) {
            struct along_row *row = &rows[(*n)++];
            const double distance =
                grid_distance(reference, grid + k * system->n, reference->y + k * system->n);
            row->t = system->t0 + reference->span * k / (STUDY_TIMES - 1);
            row->error = distance > 0 && isfinite(grid[k * system->n]) ? distance : NAN;
            snprintf(row->curve, sizeof row->curve, "%s", curve);
        }
        solver_free(&solver);
    }
    free(grid);
    return ok || error_memory(error);
}

/* Solves with each contestant and stores the table of errors as the result "errors". Contestants
 * that do not apply are left out with a note. Returns false with an error if there is no reference,
 * if out of memory, or if cancelled. */
static bool reply_along(struct session *session, const struct contestant *contestants, int count,
                        struct arena *arena, struct reply *reply, struct error *error)
{
    const struct setup *setup = &session->setup;
    struct along_row *rows = arena_array(arena, (size_t)(count * STUDY_TIMES) + 1, sizeof *rows);
    struct reference reference;
    struct system system;
    char curve[80];
    size_t n = 0;
    if (!rows)
        return error_memory(error);
    if (!scene_bind(&setup->scene, &system, error) ||
        !references_get(session_references(session), &setup->scene, &system,
                        setup->settings.duration, session->front.cancel, &reference, error))
        return false;
    for (int i = 0; i < count && !cancelled(session->front.cancel); i++) {
        name_curve(contestants, count, i, curve);
        struct error reason = {0};
        if (!add_errors(&system, &reference, &contestants[i], curve, session->front.cancel, rows,
                        &n, &reason))
            reply_note(reply, "left out: %s", reason.text);
    }
    reference_free(&reference);
    if (cancelled(session->front.cancel))
        return error_set(error, ERROR_CANCELLED, "stopped");
    reply_result(session, reply, "errors", &along_columns, rows, n, NULL, NULL);
    return true;
}

/* Makes the table of errors of the compared or named methods along the run, which is then drawn.
 * `method` [methods] are the named ones; if there are none, those of the last `compare` are taken.
 * Returns false with an error, such as if there are none either. */
bool along_study(struct session *session, const struct row *const *method, int methods,
                 struct reply *reply, struct error *error)
{
    struct arena arena = {0};
    int count = 0;
    const struct contestant *contestants =
        choose_contestants(session, method, methods, &count, &arena);
    bool ok = false;
    if (!contestants) {
        error_memory(error);
    } else if (count == 0) {
        error_set(error, ERROR_COMMAND, "no methods were compared, and none is named");
        error_hint(error, "for example: plot compare euler rk4");
    } else {
        ok = reply_along(session, contestants, count, &arena, reply, error);
    }
    arena_reset(&arena);
    return ok;
}
