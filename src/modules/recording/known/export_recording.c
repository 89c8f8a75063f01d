/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A recording as an exported table with t, y, v and energy. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "modules/recording/known/known.h"

#include <math.h>

/* Columns that a recording can be exported with. */
enum recorded { RECORDED_T, RECORDED_Y, RECORDED_V, RECORDED_ENERGY, RECORDED_COUNT };

/* Sets wanted[] for the columns to write: t, and the named ones or else y. Returns false with the
 * error for an unknown name. */
static bool list_recorded(const struct argument_value *column, bool wanted[RECORDED_COUNT],
                          struct error *error)
{
    static const char *const names[RECORDED_COUNT] = {"t", "y", "v", "energy"};
    wanted[RECORDED_T] = true;
    wanted[RECORDED_Y] = column->count == 0;
    for (int i = 0; i < column->count; i++) {
        const struct text name = column->item[i].text;
        bool known = false;
        for (int c = 0; c < RECORDED_COUNT; c++)
            if (text_is(name, names[c]))
                wanted[c] = known = true;
        if (known)
            continue;
        error_at(error, name, "a recording has no column '%.*s'", (int)name.len, name.data);
        return error_hint(error, "it has t, y, v, energy");
    }
    return true;
}

/* Adds keys that tell how velocity and energy were computed. */
static void add_motion_keys(struct keys *keys, const struct data_motion *motion, bool energy)
{
    keys_add_text(keys, "v", motion->how_v);
    if (energy)
        keys_add_text(keys, "energy", motion->how_k);
}

/* Adds the key "scale" for a voltage or a force: how its numbers convert to the current run. */
static void add_scale_key(struct keys *keys, const struct session *session,
                          struct recording *recording)
{
    const struct run *run = session_run(session);
    if (!run || !quantity_is_scaled(recording->column[recording->value].quantity))
        return;
    const struct data_distance data = run_data_distance(run, recording);
    if (!data.scaled || !isfinite(data.gain))
        return;
    struct buffer text = {0};
    put_scale(&data, run, &text);
    buffer_format(&text, " of run %d", run->number);
    keys_add(keys, "scale", &text);
}

/* Chooses the rows to write: *row becomes their indices, or NULL for all, and *rows their number.
 * Returns false if out of memory. */
static bool choose_rows(const struct series *series, const struct thinning *thinning,
                        struct arena *arena, size_t **row, size_t *rows)
{
    struct thinning counting = *thinning, keeping = *thinning;
    *rows = 0;
    *row = NULL;
    for (size_t i = 0; i < series->n; i++)
        *rows += thinning_keeps(&counting, i, series->t[i] - series->t[0]);
    if (*rows == series->n)
        return true;
    *row = arena_array(arena, *rows, sizeof **row);
    for (size_t i = 0, next = 0; *row && i < series->n; i++)
        if (thinning_keeps(&keeping, i, series->t[i] - series->t[0]))
            (*row)[next++] = i;
    return *row;
}

/* Returns the values of the chosen rows, or NULL if out of memory. */
static const double *take_rows(const double *value, const size_t *row, size_t rows,
                               struct arena *arena)
{
    if (!row)
        return value;
    double *taken = arena_array(arena, rows, sizeof *taken);
    for (size_t i = 0; taken && i < rows; i++)
        taken[i] = value[row[i]];
    return taken;
}

/* Makes the table of the current recording: keys that describe it, then the chosen columns and
 * rows. Returns false with the error. */
bool export_recorded(const struct session *session, const struct argument_value *column,
                     const struct argument_value *every, struct export *export, struct error *error)
{
    struct recording *recording = session_recording(session);
    bool wanted[RECORDED_COUNT] = {false};
    if (!recording) {
        error_set(error, ERROR_COMMAND, "there is no recording to export");
        return error_hint(error, "type: load FILE");
    }
    struct keys keys;
    struct series series;
    struct data_motion motion;
    struct thinning thinning;
    struct table_column *result = arena_array(export->arena, RECORDED_COUNT, sizeof *result);
    if (!result)
        return error_memory(error);
    if (!list_recorded(column, wanted, error) || !thinning_begin(&thinning, every, error) ||
        !keys_begin(&keys, export, error) ||
        !recording_series(recording, export->arena, 1, &series, error))
        return false;
    const bool moves = wanted[RECORDED_V] || wanted[RECORDED_ENERGY];
    if (moves && !data_motion(session, recording, &series, wanted[RECORDED_ENERGY], export->arena,
                              &motion, error))
        return false;
    const struct column *value = &recording->column[recording->value];
    keys_add_text(&keys, "recording", recording->name);
    keys_add_text(&keys, "file", recording->path);
    keys_add_text(&keys, "column", value->name);
    /* The keys let a reader of the table undo the conversion to SI and the subtraction of the
     * zero. */
    struct buffer zero = {0}, factor = {0}, cleaned = {0};
    buffer_exact(&zero, (struct measured){recording->zero, 0}, value->quantity);
    keys_add(&keys, "zero", &zero);
    buffer_real(&factor, value->factor);
    keys_add(&keys, "factor", &factor); /* SI value of a unit of the file */
    recording_describe_masked(recording, &cleaned);
    if (cleaned.len > 0) {
        cleaned.len--; /* the newline */
        keys_add(&keys, "samples", &cleaned);
    }
    add_scale_key(&keys, session, recording);
    if (moves)
        add_motion_keys(&keys, &motion, wanted[RECORDED_ENERGY]);
    const struct table_column all[RECORDED_COUNT] = {
        {.name = "t", .unit = "s", .value = series.t},
        {.name = "y", .unit = quantity_unit(series.quantity), .value = series.y},
        {.name = "v", .unit = quantity_unit(QUANTITY_VELOCITY), .value = moves ? motion.v : NULL},
        {.name = "energy",
         .unit = quantity_unit(QUANTITY_ENERGY),
         .value = moves ? motion.energy : NULL}};
    size_t rows, *row = NULL;
    int columns = 0;
    if (!choose_rows(&series, &thinning, export->arena, &row, &rows))
        return error_memory(error);
    for (int c = 0; c < RECORDED_COUNT; c++)
        if (wanted[c]) {
            result[columns] = all[c];
            if (!(result[columns++].value = take_rows(all[c].value, row, rows, export->arena)))
                return error_memory(error);
        }
    export->table = (struct table){.column = result, .columns = columns, .rows = rows};
    return keys_finish(&keys, export, error);
}

/* Replaces the table of an exported recording by one that has also the samples outside of the
 * window and the masked ones, if there are any, with a column `used` that is 0 for these. Returns
 * false with the error if out of memory or cancelled. */
static bool add_unused(const struct recording *recording, struct export *export,
                       struct error *error)
{
    const struct table_column *exported = export->table.column;
    const size_t n = recording->rows, used = export->table.rows;
    size_t present = 0;
    for (size_t i = 0; i < n; i++)
        present += isnan(recording->y[i]) ? 0 : 1;
    if (present == used)
        return true;
    struct table_column *all = arena_array(export->arena, 3, sizeof *all);
    double *t = arena_array(export->arena, n, sizeof *t),
           *y = arena_array(export->arena, n, sizeof *y),
           *taken = arena_array(export->arena, n, sizeof *taken);
    size_t rows = 0, next = 0;
    if (!all || !t || !y || !taken)
        return error_memory(error);
    for (size_t i = 0; i < n; i++) {
        if (cancelled_at(recording->cancel, i))
            return error_set(error, ERROR_CANCELLED, "stopped");
        if (isnan(recording->y[i]))
            continue;
        const bool is_used = next < used && !(recording->t[i] < exported[0].value[next]);
        t[rows] = recording->t[i];
        y[rows] = recording->y[i] - recording->zero;
        taken[rows++] = is_used;
        next += is_used;
    }
    all[0] = (struct table_column){.name = exported[0].name, .unit = exported[0].unit, .value = t};
    all[1] = (struct table_column){.name = exported[1].name, .unit = exported[1].unit, .value = y};
    all[2] = (struct table_column){.name = "used", .unit = "", .value = taken};
    export->table.column = all;
    export->table.columns = 3;
    export->table.rows = rows;
    return true;
}

bool export_recording(const struct session *session, struct export *export, struct error *error)
{
    const struct argument_value none = {.count = 0};
    return export_recorded(session, &none, &none, export, error) &&
           add_unused(session_recording(session), export, error);
}
