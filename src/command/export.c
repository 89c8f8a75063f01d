/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "columns.h"
#include "data_motion.h"
#include "precision_text.h"
#include "sweep_text.h"
#include "journal.h"

#include <math.h>
#include <string.h>

#define KEYS_MOST (PARAM_MAX + 16 + 2 * LIMIT_RUNS)

/* ---- keys: what the numbers were made with ---- */

struct keys {
    struct arena *arena;
    struct table_key *key;
    int count;
    bool failed;
};

static void add_key(struct keys *keys, const char *name, struct buffer *value)
{
    const char *copy = value->failed ? NULL : arena_text(keys->arena, buffer_text(value));
    const char *key = arena_text(keys->arena, text_of(name));
    buffer_free(value);
    if (!copy || !key || keys->count == KEYS_MOST)
        keys->failed = true;
    else
        keys->key[keys->count++] = (struct table_key){key, copy};
}

static void add_text_key(struct keys *keys, const char *name, const char *text)
{
    struct buffer value = {0};
    buffer_put(&value, text_of(text));
    add_key(keys, name, &value);
}

static void put_method(const struct run *run, struct buffer *value)
{
    buffer_put(value, text_of(run->method->row.name));
    if (run->plan.adaptive) {
        buffer_put(value, TEXT(" tol="));
        buffer_real(value, run->settings.tol);
    } else {
        buffer_put(value, TEXT(" dt="));
        buffer_quantity(value, run->settings.dt, QUANTITY_TIME, 0);
    }
    if (run->settings.drag != DRAG_DEFAULT && run->system.velocity)
        buffer_format(value, " drag=%s", catalog_row(&drag_catalog, (size_t)run->settings.drag - 1)->name);
}

static void add_scene_keys(struct keys *keys, const struct scene *scene)
{
    add_text_key(keys, "scene", scene->preset->row.name);
    for (size_t i = 0; i < scene_params(scene)->count; i++) {
        const struct param_row *param = param_at(scene, (int)i);
        struct buffer value = {0};
        buffer_exact(&value, (struct measured){scene->value[i], scene->uncertainty[i]}, param->quantity);
        add_key(keys, param->row.name, &value);
    }
}

/* "gamma 0.1 1/s at t = 3.2 s; k 16 N/m at t = 4 s" */
static void add_changes(struct keys *keys, const char *name, const struct held_run *held)
{
    struct buffer value = {0};
    for (int i = 0; i < held->legs; i++) {
        const struct leg *leg = &held->leg[i];
        if (leg->kind != LEG_SET)
            continue;
        const struct param_row *param = param_at(&held->run->scene, leg->param);
        buffer_format(&value, "%s%s ", value.len ? "; " : "", param->row.name);
        buffer_exact(&value, leg->value, param->quantity);
        buffer_put(&value, TEXT(" at t = "));
        buffer_real(&value, leg->from_t);
        buffer_put(&value, TEXT(" s"));
    }
    if (value.len > 0 || value.failed)
        add_key(keys, name, &value);
}

static void add_run_keys(struct keys *keys, const struct session *session, const int *place, int count)
{
    const struct run *one = session->run[place[0]]->run;
    add_scene_keys(keys, &one->scene);
    for (int i = 0; i < count; i++) {
        const struct held_run *held = session->run[place[i]];
        struct buffer name = {0}, value = {0};
        if (count > 1)
            buffer_format(&name, "run %d", held->run->number);
        else
            buffer_put(&name, TEXT("method"));
        put_method(held->run, &value);
        if (count > 1 && held->run->name[0])
            buffer_format(&value, " (%s)", held->run->name);
        add_key(keys, buffer_view(&name), &value);
        buffer_clear(&name);
        if (count > 1)
            buffer_format(&name, "run %d ", held->run->number);
        buffer_put(&name, TEXT("changed"));
        add_changes(keys, buffer_view(&name), held);
        buffer_free(&name);
    }
    if (count == 1 && one->name[0])
        add_text_key(keys, "name", one->name);
    if (count == 1 && session->run[place[0]]->note)
        add_text_key(keys, "note", session->run[place[0]]->note);
}

static bool begin(struct keys *keys, struct export *export, struct error *error)
{
    *keys = (struct keys){.arena = export->arena};
    keys->key = arena_array(export->arena, KEYS_MOST, sizeof *keys->key);
    if (!keys->key)
        return error_memory(error);
    add_text_key(keys, "hooke", HOOKE_VERSION);
    return true;
}

static bool finish(const struct keys *keys, struct export *export, struct error *error)
{
    export->table.key = keys->key;
    export->table.keys = keys->count;
    return !keys->failed || error_memory(error);
}

bool export_run_keys(const struct session *session, int place, struct export *export, struct error *error)
{
    struct keys keys;
    if (!begin(&keys, export, error))
        return false;
    add_run_keys(&keys, session, &place, 1);
    return finish(&keys, export, error);
}

/* ---- runs ---- */

/* Which rows of a run are written: mark[i], and how many. */
static size_t select_rows(const struct run *run, const struct given *every, bool *mark)
{
    const size_t n = trace_count(run->trace);
    const bool by_time = every->count && every->item->unit != NULL;
    const double step = every->count ? every->item->value.value : 1;
    size_t count = 0;
    int64_t next = 0;
    for (size_t i = 0; i < n; i++) {
        const double elapsed = fabs(trace_time(run->trace, i) - trace_time(run->trace, 0));
        const double place = by_time ? elapsed / step : (double)i / step;
        mark[i] = place >= (double)next - 1e-9 * (1 + fabs(place));
        if (mark[i])
            next = (int64_t)floor(place + 1e-6) + 1;
        count += mark[i];
    }
    return count;
}

static bool check_every(const struct given *every, struct error *error)
{
    if (every->count == 0)
        return true;
    const struct item *item = every->item;
    if (item->unit && item->unit->quantity != QUANTITY_TIME)
        return error_at(error, item->text, "every= takes a number of rows or a time, got '%.*s' (%s)",
                        (int)item->text.len, item->text.at, quantity_name(item->unit->quantity));
    if (item->unit || (item->value.value >= 1 && item->value.value == floor(item->value.value)))
        return true;
    error_at(error, item->text, "every= takes a whole number of rows, or a time with its unit");
    return error_hint(error, "for example every=10 or every=100ms");
}

static int list_runs(const struct session *session, const struct given *runs, int *place)
{
    int count = 0;
    for (int r = 0; r < session->runs; r++) {
        bool wanted = runs->count == 0 && r == session->current_run;
        for (int i = 0; i < runs->count; i++)
            wanted |= runs->item[i].index < 0 || runs->item[i].index == r;
        if (wanted)
            place[count++] = r;
    }
    return count;
}

static void add_column(struct chosen_column one, struct chosen_column *list, int *count)
{
    for (int i = 0; i < *count; i++)
        if (list[i].observable == one.observable && list[i].variable == one.variable)
            return;
    list[(*count)++] = one;
}

/* t first, then what was asked for, or the state, the energy and what is observed, each once. */
static bool list_columns(const struct model *model, const struct given *column, struct chosen_column *list, int *count,
                         struct error *error)
{
    struct chosen_column one;
    if (!chosen_find(model, TEXT("t"), &one, error))
        return false;
    add_column(one, list, count);
    for (int i = 0; i < column->count; i++) {
        if (!chosen_find(model, column->item[i].text, &one, error))
            return false;
        add_column(one, list, count);
    }
    for (int v = 0; v < model->n && !column->count; v++)
        add_column((struct chosen_column){NULL, v}, list, count);
    if (!column->count && model->order == 2 && chosen_find(model, TEXT("energy"), &one, error))
        add_column(one, list, count);
    for (int v = 0; v < model_observed(model) && !column->count; v++)
        add_column((struct chosen_column){NULL, model->n + v}, list, count);
    return true;
}

static bool same_model(const struct session *session, const int *place, int count, struct error *error)
{
    const struct run *first = session->run[place[0]]->run;
    for (int i = 1; i < count; i++) {
        const struct run *run = session->run[place[i]]->run;
        if (run->system.model == first->system.model)
            continue;
        error_set(error, ERROR_COMMAND, "run %d (%s) and run %d (%s) have different variables: not in one file",
                  first->number, first->scene.preset->row.name, run->number, run->scene.preset->row.name);
        return error_hint(error, "export FILE run %d", first->number);
    }
    return true;
}

bool export_runs(const struct session *session, const struct given *runs, const struct given *column,
                 const struct given *every, struct export *export, struct error *error)
{
    struct arena *arena = export->arena;
    int place[LIMIT_RUNS];
    const int count = list_runs(session, runs, place);
    if (count == 0) {
        error_set(error, ERROR_COMMAND, "there is no run to export");
        return error_hint(error, "type: run; or: export FILE data");
    }
    struct keys keys;
    const struct system *system = &session->run[place[0]]->run->system;
    const struct model *model = system->model;
    if (!same_model(session, place, count, error) || !check_every(every, error) || !begin(&keys, export, error))
        return false;
    struct chosen_column *list =
        arena_array(arena, (size_t)column->count + (size_t)(model->n + model_observed(model)) + 2, sizeof *list);
    size_t rows = 0, largest = 0;
    bool **mark = arena_array(arena, (size_t)count, sizeof *mark);
    if (!list || !mark)
        return error_memory(error);
    for (int r = 0; r < count; r++) {
        const struct run *run = session->run[place[r]]->run;
        const size_t n = trace_count(run->trace);
        if (!(mark[r] = arena_array(arena, n, sizeof **mark)))
            return error_memory(error);
        rows += select_rows(run, every, mark[r]);
        largest = n > largest ? n : largest;
    }
    int columns = 0;
    if (!list_columns(model, column, list, &columns, error))
        return false;
    const int lead = count > 1;
    struct table_column *out = arena_array(arena, (size_t)(columns + lead), sizeof *out);
    double *work = arena_array(arena, largest, sizeof *work);
    if (!out || !work)
        return error_memory(error);
    for (int c = 0; c < columns + lead; c++) {
        double *value = arena_array(arena, rows, sizeof *value);
        size_t n = 0;
        if (!value)
            return error_memory(error);
        for (int r = 0; r < count; r++) {
            const struct run *run = session->run[place[r]]->run;
            if (c >= lead && !chosen_values(run, &list[c - lead], work, error))
                return false;
            for (size_t i = 0; i < trace_count(run->trace); i++)
                if (mark[r][i])
                    value[n++] = c < lead ? run->number : work[i];
        }
        out[c] = (struct table_column){.name = "run", .unit = "", .value = value};
        if (c < lead)
            continue;
        const struct variable variable = chosen_variable(system, &list[c - lead]);
        if (!(out[c].name = arena_text(arena, text_of(variable.name))))
            return error_memory(error);
        out[c].unit = chosen_unit(system, &list[c - lead]);
    }
    add_run_keys(&keys, session, place, count);
    export->table = (struct table){.column = out, .columns = columns + lead, .rows = rows};
    return finish(&keys, export, error);
}

/* ---- a recording ---- */

enum recorded { RECORDED_T, RECORDED_Y, RECORDED_V, RECORDED_ENERGY, RECORDED_COUNT };

/* t first, then what was asked for, or y, each once. */
static bool list_recorded(const struct given *column, bool wanted[RECORDED_COUNT], struct error *error)
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
        error_at(error, name, "a recording has no column '%.*s'", (int)name.len, name.at);
        return error_hint(error, "it has t, y, v, energy");
    }
    return true;
}

static void add_motion_keys(struct keys *keys, const struct data_motion *motion, bool energy)
{
    add_text_key(keys, "v", motion->how_v);
    if (energy)
        add_text_key(keys, "energy", motion->how_k);
}

bool export_recorded(const struct session *session, const struct given *column, struct export *export,
                     struct error *error)
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
    struct table_column *out = arena_array(export->arena, RECORDED_COUNT, sizeof *out);
    if (!out)
        return error_memory(error);
    if (!list_recorded(column, wanted, error) || !begin(&keys, export, error) ||
        !recording_series(recording, export->arena, 1, &series, error))
        return false;
    const bool moves = wanted[RECORDED_V] || wanted[RECORDED_ENERGY];
    if (moves &&
        !data_motion(session, recording, &series, wanted[RECORDED_ENERGY], export->arena, &motion, error))
        return false;
    const struct column *value = &recording->column[recording->value];
    add_text_key(&keys, "recording", recording->name);
    add_text_key(&keys, "file", recording->path);
    add_text_key(&keys, "column", value->name);
    struct buffer zero = {0}, cleaned = {0};
    buffer_exact(&zero, (struct measured){recording->zero, 0}, value->quantity);
    add_key(&keys, "zero", &zero);
    recording_describe_masked(recording, &cleaned);
    if (cleaned.len > 0) {
        cleaned.len--; /* the newline */
        add_key(&keys, "samples", &cleaned);
    }
    if (moves)
        add_motion_keys(&keys, &motion, wanted[RECORDED_ENERGY]);
    const struct table_column all[RECORDED_COUNT] = {
        {.name = "t", .unit = "s", .value = series.t},
        {.name = "y", .unit = quantity_unit(series.quantity), .value = series.y},
        {.name = "v", .unit = quantity_unit(QUANTITY_VELOCITY), .value = moves ? motion.v : NULL},
        {.name = "energy", .unit = quantity_unit(QUANTITY_ENERGY), .value = moves ? motion.energy : NULL}};
    int columns = 0;
    for (int c = 0; c < RECORDED_COUNT; c++)
        if (wanted[c])
            out[columns++] = all[c];
    export->table = (struct table){.column = out, .columns = columns, .rows = series.n};
    return finish(&keys, export, error);
}

bool export_recording(const struct session *session, struct export *export, struct error *error)
{
    return export_recorded(session, &(const struct given){.count = 0}, export, error);
}

/* ---- measurements, runs in brief ---- */

bool export_measurements(const struct session *session, struct export *export, struct error *error)
{
    const size_t n = (size_t)session->measurements;
    struct arena *arena = export->arena;
    struct keys keys;
    const char **quantity = arena_array(arena, n, sizeof *quantity), **unit = arena_array(arena, n, sizeof *unit),
               **of = arena_array(arena, n, sizeof *of);
    double *value = arena_array(arena, n, sizeof *value), *spread = arena_array(arena, n, sizeof *spread),
           *periods = arena_array(arena, n, sizeof *periods);
    struct table_column *out = arena_array(arena, 6, sizeof *out);
    if (n == 0) {
        error_set(error, ERROR_COMMAND, "there is no measurement to export");
        return error_hint(error, "type: measure period");
    }
    if (!quantity || !unit || !of || !value || !spread || !periods || !out)
        return error_memory(error);
    if (!begin(&keys, export, error))
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
    const struct table_column columns[] = {
        {.name = "quantity", .unit = "", .text = quantity},   {.name = "value", .unit = "", .value = value},
        {.name = "uncertainty", .unit = "", .value = spread}, {.name = "unit", .unit = "", .text = unit},
        {.name = "periods", .unit = "", .value = periods},    {.name = "of", .unit = "", .text = of}};
    memcpy(out, columns, sizeof columns);
    add_scene_keys(&keys, &session->setup.scene);
    export->table = (struct table){.column = out, .columns = (int)COUNT_OF(columns), .rows = n};
    return finish(&keys, export, error);
}

bool export_precision(const struct session *session, struct export *export, struct error *error)
{
    const struct precision *precision = session->precision;
    struct keys keys;
    struct buffer duration = {0}, reference = {0};
    if (!begin(&keys, export, error) || !precision_table(precision, export, error))
        return false;
    buffer_exact(&duration, (struct measured){precision->duration, 0}, QUANTITY_TIME);
    reference_describe(&precision->reference, &reference);
    add_key(&keys, "duration", &duration);
    add_key(&keys, "reference", &reference);
    add_scene_keys(&keys, &precision->scene);
    return finish(&keys, export, error);
}

bool export_sweep(const struct session *session, struct export *export, struct error *error)
{
    const struct swept swept = {session->sweep, session->sweep_measure, session->sweep_scene.model};
    struct keys keys;
    if (!begin(&keys, export, error) || !sweep_table(&swept, export, error))
        return false;
    add_scene_keys(&keys, &session->sweep_scene);
    return finish(&keys, export, error);
}

enum brief { BRIEF_RUN, BRIEF_DT, BRIEF_TOL, BRIEF_STEPS, BRIEF_T, BRIEF_ENERGY_ERROR, BRIEF_ERROR, BRIEF_COUNT };

bool export_run_table(const struct session *session, struct export *export, struct error *error)
{
    static const char *const names[BRIEF_COUNT] = {"run", "dt", "tol", "steps", "t", "energy_error", "error"};
    static const char *const units[BRIEF_COUNT] = {"", "s", "", "", "s", "", ""};
    const size_t n = (size_t)session->runs;
    struct arena *arena = export->arena;
    struct keys keys;
    const char **method = arena_array(arena, n, sizeof *method), **status = arena_array(arena, n, sizeof *status);
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
    if (!begin(&keys, export, error))
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
    add_scene_keys(&keys, &session->setup.scene);
    export->table = (struct table){.column = out, .columns = BRIEF_COUNT + 2, .rows = n};
    return finish(&keys, export, error);
}
