/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The keys of a table: its lines "# key = value", which tell how its numbers were made. Call
 * keys_begin(), keys_add...(), keys_finish(). */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include <hooke/session/log.h>

#include <math.h>
#include <stdlib.h>

/* Room for the parameters, for other keys of a scene, and two keys for each run. */
#define KEYS_MAX (PARAM_MAX + 16 + 2 * LIMIT_RUNS)

/* Adds a key and frees the value. Sets keys->failed if out of memory. */
void keys_add(struct keys *keys, const char *name, struct buffer *value)
{
    const char *copy = value->failed ? NULL : arena_text(keys->arena, buffer_text(value));
    const char *key = arena_text(keys->arena, text_of(name));
    buffer_free(value);
    if (!copy || !key || keys->count == KEYS_MAX)
        keys->failed = true;
    else
        keys->key[keys->count++] = (struct table_key){key, copy};
}

void keys_add_text(struct keys *keys, const char *name, const char *text)
{
    struct buffer value = {0};
    buffer_put(&value, text_of(text));
    keys_add(keys, name, &value);
}

/* Appends the method of a run with its step or tolerance, such as "rk4 dt=10 ms". */
static void put_method(const struct run *run, struct buffer *value)
{
    buffer_put(value, text_of(run->method->row.name));
    if (run->plan.adaptive) {
        buffer_put(value, TEXT(" tol="));
        buffer_real(value, run->settings.tol);
    } else {
        buffer_format(value, " dt=%s", SHOWN_QUANTITY(run->settings.dt, QUANTITY_TIME, 0));
    }
    if (run->settings.drag != DRAG_DEFAULT && run->system.velocity)
        buffer_format(value, " drag=%s",
                      catalog_row(&drag_catalog, (size_t)run->settings.drag - 1)->name);
}

/* Adds the scene, its typed equations and tolerances as one line each, and all parameters. */
void keys_add_scene(struct keys *keys, const struct scene *scene)
{
    struct buffer lines = {0};
    keys_add_text(keys, "scene", scene->preset->row.name);
    scene_script(scene, "; ", &lines);
    if (lines.len > 0 || lines.failed) {
        lines.len -= lines.failed ? 0 : 2;
        keys_add(keys, "typed", &lines);
    }
    struct buffer atol = {0};
    atol_script(scene, "; ", &atol);
    if (atol.len > 0 || atol.failed) {
        atol.len -= atol.failed ? 0 : 2;
        keys_add(keys, "tolerances", &atol);
    }
    for (size_t i = 0; i < scene_params(scene)->count; i++) {
        const struct param_row *param = param_at(scene, (int)i);
        struct buffer value = {0};
        buffer_exact(&value, (struct measured){scene->value[i], scene->uncertainty[i]},
                     param->quantity);
        keys_add(keys, param->row.name, &value);
    }
}

/* Adds a key with the changes of parameters during a run: "gamma 0.1 1/s at t = 3.2 s; k 16 N/m at
 * t = 4 s; 12 by events". Adds nothing if there were none. */
static void add_changes(struct keys *keys, const char *name, const struct run_slot *slot)
{
    struct buffer value = {0};
    const struct request **list;
    int by_events = 0, count;
    if (!journal_list(slot->last, 0, &list, &count))
        value.failed = true;
    for (int i = 0; i < count; i++) {
        const struct request *request = list[i];
        const bool changes = request->kind == REQUEST_SET || request->kind == REQUEST_KICK;
        by_events += changes && request->by_event;
        if (!changes || request->by_event)
            continue;
        buffer_put(&value, value.len ? TEXT("; ") : TEXT(""));
        journal_put_change(slot->run, request, &value);
        buffer_put(&value, TEXT(" at t = "));
        buffer_real(&value, request->from_t);
        buffer_put(&value, TEXT(" s"));
    }
    free(list);
    if (by_events > 0)
        buffer_format(&value, "%s%d by events", value.len ? "; " : "", by_events);
    if (value.len > 0 || value.failed)
        keys_add(keys, name, &value);
}

/* Adds the scene of the first run, and the method and changes of each. */
void keys_add_runs(struct keys *keys, const struct session *session, const int *index, int count)
{
    const struct run *one = session->runs.slot[index[0]]->run;
    keys_add_scene(keys, &one->scene);
    for (int i = 0; i < count; i++) {
        const struct run_slot *slot = session->runs.slot[index[i]];
        struct buffer name = {0}, value = {0};
        if (count > 1)
            buffer_format(&name, "run %d", slot->run->number);
        else
            buffer_put(&name, TEXT("method"));
        put_method(slot->run, &value);
        if (count > 1 && slot->run->name[0])
            buffer_format(&value, " (%s)", slot->run->name);
        keys_add(keys, buffer_view(&name), &value);
        buffer_clear(&name);
        if (count > 1)
            buffer_format(&name, "run %d ", slot->run->number);
        buffer_put(&name, TEXT("changed"));
        add_changes(keys, buffer_view(&name), slot);
        buffer_free(&name);
    }
    if (count == 1 && one->name[0])
        keys_add_text(keys, "name", one->name);
    if (count == 1 && session->runs.slot[index[0]]->note)
        keys_add_text(keys, "note", session->runs.slot[index[0]]->note);
}

/* Begins the keys of an export with the version of the program. Returns false if out of memory. */
bool keys_begin(struct keys *keys, struct export *export, struct error *error)
{
    *keys = (struct keys){.arena = export->arena};
    keys->key = arena_array(export->arena, KEYS_MAX, sizeof *keys->key);
    if (!keys->key)
        return error_memory(error);
    keys_add_text(keys, "hooke", HOOKE_VERSION);
    return true;
}

bool keys_finish(const struct keys *keys, struct export *export, struct error *error)
{
    export->table.key = keys->key;
    export->table.keys = keys->count;
    return !keys->failed || error_memory(error);
}

/* Fills the keys of an export with the session's present scene. Returns false if out of memory. */
bool export_scene_keys(const struct session *session, struct export *export, struct error *error)
{
    struct keys keys;
    if (!keys_begin(&keys, export, error))
        return false;
    keys_add_scene(&keys, &session->setup.scene);
    return keys_finish(&keys, export, error);
}

/* Fills the keys of an export with the scene, method and changes of one run. Returns false if out
 * of memory. */
bool export_run_keys(const struct session *session, int index, struct export *export,
                     struct error *error)
{
    struct keys keys;
    if (!keys_begin(&keys, export, error))
        return false;
    keys_add_runs(&keys, session, &index, 1);
    return keys_finish(&keys, export, error);
}
