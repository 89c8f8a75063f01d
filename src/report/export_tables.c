/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables with a row for each measurement, method, point or run. */
#include <hooke/report.h>

#include <math.h>

bool export_measurements(const struct session *session, struct export *export, struct error *error)
{
    struct keys keys;
    if (session->measurements == 0) {
        error_set(error, ERROR_COMMAND, "there is no measurement to export");
        return error_hint(error, "type: measure period");
    }
    if (!columns_table(&measurement_columns, session->measurement, (size_t)session->measurements,
                       export->arena, &export->table))
        return error_memory(error);
    if (!keys_begin(&keys, export, error))
        return false;
    keys_add_scene(&keys, &session->setup.scene);
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

void keep_study(struct session *session, const struct result_columns *columns, const void *rows,
                size_t count, const char *method, const char *reference)
{
    struct arena arena = {0};
    struct export export = {.arena = &arena};
    struct keys keys;
    struct error ignored;
    struct buffer duration = {0};
    bool ok = columns_table(columns, rows, count, &arena, &export.table) &&
              keys_begin(&keys, &export, &ignored);
    if (ok) {
        buffer_exact(&duration, (struct measured){session->setup.settings.duration, 0},
                     QUANTITY_TIME);
        if (method)
            keys_add_text(&keys, "method", method);
        keys_add(&keys, "duration", &duration);
        if (reference && reference[0])
            keys_add_text(&keys, "reference", reference);
        keys_add_scene(&keys, &session->setup.scene);
        ok = keys_finish(&keys, &export, &ignored);
    }
    if (!ok) {
        arena_reset(&arena);
        return;
    }
    arena_reset(&session->study_arena);
    session->study_arena = arena;
    session->study = export.table;
    session_studied(session, STUDIED_TABLE);
}

static bool export_kept(const struct session *session, struct export *export, struct error *error)
{
    (void)error;
    export->table = session->study;
    return true;
}

bool export_run_table(const struct session *session, struct export *export, struct error *error)
{
    struct run_row *row = arena_array(export->arena, (size_t)session->runs + 1, sizeof *row);
    struct keys keys;
    if (session->runs == 0) {
        error_set(error, ERROR_COMMAND, "there is no run for a table");
        return error_hint(error, "type: compare euler verlet");
    }
    for (int i = 0; row && i < session->runs; i++)
        row[i] = (struct run_row){session->run[i], i == session->current_run};
    if (!row ||
        !columns_table(&run_columns, row, (size_t)session->runs, export->arena, &export->table))
        return error_memory(error);
    if (!keys_begin(&keys, export, error))
        return false;
    keys_add_scene(&keys, &session->setup.scene);
    return keys_finish(&keys, export, error);
}

bool export_study(const struct session *session, struct export *export, struct error *error)
{
    static bool (*const writes[])(const struct session *, struct export *, struct error *) = {
        [STUDIED_NONE] = export_run_table,
        [STUDIED_PRECISION] = export_precision,
        [STUDIED_SWEEP] = export_sweep,
        [STUDIED_TABLE] = export_kept,
    };
    return writes[session->studied_runs == session->next_run ? session->studied : STUDIED_NONE](
        session, export, error);
}
