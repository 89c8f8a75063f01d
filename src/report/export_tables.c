/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables with a row for each measurement, method, point or run. */
#include <hooke/report.h>

#include <math.h>
#include <string.h>

bool export_measurements(const struct session *session, struct export *export, struct error *error)
{
    const size_t n = (size_t)session->measurements;
    struct arena *arena = export->arena;
    struct keys keys;
    const char **quantity = arena_array(arena, n, sizeof *quantity),
               **unit = arena_array(arena, n, sizeof *unit),
               **of = arena_array(arena, n, sizeof *of);
    double *value = arena_array(arena, n, sizeof *value),
           *spread = arena_array(arena, n, sizeof *spread),
           *periods = arena_array(arena, n, sizeof *periods);
    struct table_column *out = arena_array(arena, 6, sizeof *out);
    if (n == 0) {
        error_set(error, ERROR_COMMAND, "there is no measurement to export");
        return error_hint(error, "type: measure period");
    }
    if (!quantity || !unit || !of || !value || !spread || !periods || !out)
        return error_memory(error);
    if (!keys_begin(&keys, export, error))
        return false;
    for (size_t i = 0; i < n; i++) {
        const struct measurement *m = &session->measurement[i];
        quantity[i] = m->quantity;
        unit[i] = quantity_unit(m->unit);
        of[i] = m->of;
        value[i] = m->value.value;
        spread[i] = m->value.uncertainty;
        periods[i] = m->periods;
    }
    const struct table_column columns[] = {{.name = "quantity", .unit = "", .text = quantity},
                                           {.name = "value", .unit = "", .value = value},
                                           {.name = "uncertainty", .unit = "", .value = spread},
                                           {.name = "unit", .unit = "", .text = unit},
                                           {.name = "periods", .unit = "", .value = periods},
                                           {.name = "of", .unit = "", .text = of}};
    memcpy(out, columns, sizeof columns);
    keys_add_scene(&keys, &session->setup.scene);
    export->table = (struct table){.column = out, .columns = (int)COUNT_OF(columns), .rows = n};
    return keys_finish(&keys, export, error);
}

static bool export_precision(const struct session *session, struct export *export,
                             struct error *error)
{
    const struct precision *precision = session->precision;
    struct keys keys;
    struct buffer duration = {0}, reference = {0};
    const struct precision_row *rows = precision_rows(precision, export->arena);
    if (!rows || !columns_table(&precision_columns, rows, (size_t)precision->points, export->arena,
                                &export->table))
        return error_memory(error);
    if (!keys_begin(&keys, export, error))
        return false;
    buffer_exact(&duration, (struct measured){precision->duration, 0}, QUANTITY_TIME);
    reference_describe(&precision->reference, &reference);
    keys_add(&keys, "duration", &duration);
    keys_add(&keys, "reference", &reference);
    keys_add_scene(&keys, &precision->scene);
    return keys_finish(&keys, export, error);
}

static bool export_sweep(const struct session *session, struct export *export, struct error *error)
{
    const struct swept swept = {session->sweep, session->sweep_measure, session->sweep_scene.model};
    struct keys keys;
    if (!keys_begin(&keys, export, error) || !sweep_table(&swept, export, error))
        return false;
    keys_add_scene(&keys, &session->sweep_scene);
    return keys_finish(&keys, export, error);
}

static bool export_compared(const struct session *session, struct export *export,
                            struct error *error)
{
    const struct compared *compared = session->compared;
    const struct comparison *first = &compared->row[0].by;
    struct keys keys;
    struct buffer duration = {0}, reference = {0};
    if (!columns_table(&compared_columns, compared->row, (size_t)compared->rows, export->arena,
                       &export->table))
        return error_memory(error);
    if (!keys_begin(&keys, export, error))
        return false;
    buffer_exact(&duration, (struct measured){compared->duration, 0}, QUANTITY_TIME);
    keys_add(&keys, "duration", &duration);
    if (first->reference[0]) {
        buffer_format(&reference, "%s and %s, which agree to ", first->reference[0]->row.name,
                      first->reference[1]->row.name);
        buffer_short(&reference, first->errors.floor, 2);
        keys_add(&keys, "reference", &reference);
    } else if (isfinite(first->errors.max)) {
        keys_add_text(&keys, "reference", "the closed form");
    }
    keys_add_scene(&keys, &compared->scene);
    return keys_finish(&keys, export, error);
}

enum brief {
    BRIEF_RUN,
    BRIEF_DT,
    BRIEF_TOL,
    BRIEF_STEPS,
    BRIEF_T,
    BRIEF_ENERGY_ERROR,
    BRIEF_ERROR,
    BRIEF_COUNT
};

bool export_run_table(const struct session *session, struct export *export, struct error *error)
{
    static const char *const names[BRIEF_COUNT] = {"run", "dt",           "tol",  "steps",
                                                   "t",   "energy_error", "error"};
    static const char *const units[BRIEF_COUNT] = {"", "s", "", "", "s", "", ""};
    const size_t n = (size_t)session->runs;
    struct arena *arena = export->arena;
    struct keys keys;
    const char **method = arena_array(arena, n, sizeof *method),
               **status = arena_array(arena, n, sizeof *status);
    struct table_column *out = arena_array(arena, BRIEF_COUNT + 2, sizeof *out);
    double *value[BRIEF_COUNT];
    bool ok = method && status && out;
    if (n == 0) {
        error_set(error, ERROR_COMMAND, "there is no run for a table");
        return error_hint(error, "type: compare euler verlet");
    }
    for (int c = 0; c < BRIEF_COUNT; c++)
        ok = (value[c] = arena_array(arena, n, sizeof *value[c])) && ok;
    if (!ok)
        return error_memory(error);
    if (!keys_begin(&keys, export, error))
        return false;
    for (size_t i = 0; i < n; i++) {
        const struct run *run = session->run[i]->run;
        struct ledger ledger;
        struct run_errors errors;
        run_ledger(run, &ledger);
        run_errors(run, &errors);
        method[i] = run->method->row.name;
        status[i] = stop_name(run->stop);
        value[BRIEF_RUN][i] = run->number;
        value[BRIEF_DT][i] = run->plan.adaptive ? NAN : run->settings.dt;
        value[BRIEF_TOL][i] = run->plan.adaptive ? run->settings.tol : NAN;
        value[BRIEF_STEPS][i] = (double)run->steps;
        value[BRIEF_T][i] = run->t;
        value[BRIEF_ENERGY_ERROR][i] = ledger.error_max;
        value[BRIEF_ERROR][i] = errors.max;
    }
    for (int c = 0; c < BRIEF_COUNT; c++)
        out[c] = (struct table_column){.name = names[c], .unit = units[c], .value = value[c]};
    out[BRIEF_COUNT] = (struct table_column){.name = "method", .unit = "", .text = method};
    out[BRIEF_COUNT + 1] = (struct table_column){.name = "status", .unit = "", .text = status};
    keys_add_scene(&keys, &session->setup.scene);
    export->table = (struct table){.column = out, .columns = BRIEF_COUNT + 2, .rows = n};
    return keys_finish(&keys, export, error);
}

bool export_study(const struct session *session, struct export *export, struct error *error)
{
    static bool (*const writes[])(const struct session *, struct export *, struct error *) = {
        [STUDIED_NONE] = export_run_table,
        [STUDIED_PRECISION] = export_precision,
        [STUDIED_SWEEP] = export_sweep,
        [STUDIED_COMPARE] = export_compared,
    };
    return writes[session->studied_runs == session->next_run ? session->studied : STUDIED_NONE](
        session, export, error);
}
