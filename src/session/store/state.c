/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a session file has in its records of state, and scenes and events, which runs have, too. */
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/module.h>
#include <hooke/session/stored.h>

#include <stdlib.h>
#include <string.h>

/* ---- scenes ---- */

void store_put_scene(const struct scene *scene, const char *name, struct buffer *to)
{
    const size_t begun = field_begin(to, name), params = scene_params(scene)->count;
    const size_t script = field_begin(to, "script");
    scene_kind_script(scene, to);
    field_end(to, script);
    field_put_names(to, "names", scene_params(scene));
    field_put(to, "value", scene->value, params * sizeof *scene->value);
    field_put(to, "uncertainty", scene->uncertainty, params * sizeof *scene->uncertainty);
    field_put(to, "chosen", scene->chosen, params * sizeof *scene->chosen);
    field_put(to, "across", &scene->across, sizeof scene->across);
    field_put(to, "atol", scene->atol, sizeof scene->atol);
    field_end(to, begun);
}

void store_put_events(const struct events *events, struct buffer *to)
{
    const size_t begun = field_begin(to, "events");
    events_save(events, false, to);
    field_end(to, begun);
}

/* ---- recordings ---- */

static void put_loaded(const struct recording_slot *slot, struct buffer *to)
{
    const struct recording *recording = slot->recording;
    char *path = realpath(recording->path, NULL);
    const size_t begun = field_begin(to, "recording");
    field_text(to, "name", text_of(recording->name));
    field_text(to, "path", text_of(path ? path : recording->path));
    field_text(to, "options", text_of(slot->options));
    field_put(to, "sum", &slot->sum, sizeof slot->sum);
    field_put(to, "rows", &recording->rows, sizeof recording->rows);
    for (int i = 0; i < RECORDING_FIELDS; i++)
        field_put(to, recording_fields[i].name,
                  (const char *)recording + recording_fields[i].offset, recording_fields[i].bytes);
    field_end(to, begun);
    free(path);
}

/* ---- settings, lists, results ---- */

static void put_settings(const struct settings *settings, struct buffer *to)
{
    const size_t begun = field_begin(to, "settings");
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = setting_at(i);
        const bool chosen = setting_is_chosen(setting, settings);
        const struct row *choice = setting_choice(setting, settings);
        const size_t of = field_begin(to, setting->row.name);
        field_put(to, "chosen", &chosen, sizeof chosen);
        if (choice)
            field_text(to, "choice", text_of(choice->name));
        field_put(to, "value", (const char *)settings + setting->offset, setting->bytes);
        field_end(to, of);
    }
    field_end(to, begun);
}

/* Its bytes, without the address of a name that stands beside it: put_fit(). */
static void put_item(const struct store_array *array, const void *item, struct buffer *to)
{
    struct stored_fit fit;
    if (array->offset == offsetof(struct session, stored_fit)) {
        memcpy(&fit, item, sizeof fit);
        fit.fit.model = NULL;
        item = &fit;
    }
    buffer_put(to, (struct text){item, array->item});
}

static void put_arrays(const struct session *session, struct buffer *to)
{
    for (size_t i = 0; i < store_array_count; i++) {
        const struct store_array *array = &store_arrays[i];
        const char *at = (const char *)session + array->offset;
        const int count = *(const int *)(const void *)((const char *)session + array->count);
        const size_t item = array->item;
        if (array->max == 0)
            at = *(char *const *)(const void *)at;
        const size_t begun = field_begin(to, array->name);
        field_put(to, "item", &item, sizeof item);
        store_put_members(array->member, array->members, to);
        const size_t items = field_begin(to, "items");
        for (int k = 0; k < count; k++)
            put_item(array, at + (size_t)k * item, to);
        field_end(to, items);
        field_end(to, begun);
    }
}

static void put_fit(const struct session *session, struct buffer *to)
{
    if (session->has_fit)
        field_text(to, "fit_model", text_of(session->fit.model));
    const struct store_array *like = &store_arrays[STORE_FITS];
    struct stored_fit last = {.quantity = QUANTITY_NUMBER};
    memcpy(&last.fit, &session->fit, sizeof last.fit);
    const size_t begun = field_begin(to, "last_fit");
    store_put_members(like->member, like->members, to);
    const size_t item = field_begin(to, "items");
    put_item(like, &last, to);
    field_end(to, item);
    field_end(to, begun);
    for (int i = 0; i < session->stored_fits; i++)
        field_text(to, "stored_model", text_of(session->stored_fit[i].fit.model));
    if (session->fit_samples > 0)
        field_put(to, "fit_curve", &session->fit_curve_sum, sizeof session->fit_curve_sum);
    if (session->has_fit && session->fit_scene.model)
        store_put_scene(&session->fit_scene, "fit_scene", to);
    if (session->adopted.scene.model)
        store_put_scene(&session->adopted.scene, "adopted_scene", to);
}

static void put_tables(const struct session *session, struct buffer *to)
{
    for (int i = 0; i < session->found.count; i++) {
        const struct stored_table *of = session->found.of[i];
        const size_t begun = field_begin(to, "table");
        field_text(to, "kind", text_of(of->kind));
        const size_t text = field_begin(to, "csv");
        table_format(&of->table, TABLE_CSV, to);
        field_end(to, text);
        field_end(to, begun);
    }
    if (session->studied)
        field_text(to, "studied", text_of(session->studied));
}

static void put_lesson(const struct lesson *lesson, struct buffer *to)
{
    if (!lesson)
        return;
    const size_t begun = field_begin(to, "lesson");
    fields_put(to, store_lesson, store_lesson_count, lesson);
    field_text(to, "text", buffer_text(&lesson->text));
    field_end(to, begun);
}

void store_put_state(const struct session *session, struct buffer *to)
{
    const struct setup *setup = &session->setup;
    field_text(to, "version", text_of(HOOKE_VERSION));
    fields_put(to, store_session, store_session_count, session);
    for (int i = 0; i < session->recordings; i++)
        put_loaded(session->recording[i], to);
    for (int i = 0; i < setup->owns; i++) {
        struct scene scene;
        scene_init(&scene, setup->own[i]);
        store_put_scene(&scene, "own", to);
    }
    store_put_scene(&setup->scene, "scene", to);
    store_put_events(setup->events, to);
    field_text(to, "method", text_of(setup->method->row.name));
    if (setup->calibration.decided) {
        struct buffer points = {0};
        calibration_put(&setup->calibration, &points);
        field_text(to, "calibration", buffer_text(&points));
        buffer_free(&points);
    }
    put_settings(&setup->settings, to);
    put_arrays(session, to);
    put_fit(session, to);
    put_tables(session, to);
    for (int i = 0; i < session->parts->count; i++) {
        const struct session_part *part = &session->parts->item[i];
        if (part->module->store.put)
            part->module->store.put(part->state, to);
    }
    put_lesson(session->lesson, to);
    const size_t runs = field_begin(to, "runs");
    for (int i = 0; i < session->runs; i++)
        buffer_put(to,
                   (struct text){(const char *)&session->run[i]->id, sizeof session->run[i]->id});
    field_end(to, runs);
    const size_t view = field_begin(to, "view");
    fields_put(to, store_view, store_view_count, &session->view);
    if (session->view.focus)
        field_text(to, "focus", text_of(session->view.focus->name));
    field_end(to, view);
}
