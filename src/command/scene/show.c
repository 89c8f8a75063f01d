/* SPDX-License-Identifier: GPL-3.0-or-later */
/* show */
#ifndef COMMAND_ROWS
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <string.h>

/* One named value, as a line and as a record. */
static void show_value(const struct session *session, const struct named_value *value,
                       const char *brief, struct reply *reply)
{
    const struct measured measured = {value->value, value->uncertainty};
    struct buffer text = {0};
    buffer_format(&text, "%s = ", value->name);
    if (isfinite(value->value))
        buffer_measured(&text, measured, value->quantity, session->setup.settings.digits);
    else
        buffer_put(&text, TEXT("undefined"));
    for (int pad = text_width(buffer_text(&text)); *brief && pad < 30; pad++)
        buffer_char(&text, ' ');
    buffer_format(&text, "%s%s", *brief ? " " : "", brief);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    reply_begin(reply, "show");
    reply_string(reply, "name", value->name);
    reply_real(reply, "value", value->value);
    reply_real(reply, "uncertainty", value->uncertainty);
    reply_string(reply, "unit",
                 value->quantity == QUANTITY_OTHER ? NULL : quantity_unit(value->quantity));
    reply_end(reply);
}

static void show_name(const struct session *session, const struct row *row, struct reply *reply)
{
    struct named_value value = {.quantity = QUANTITY_OTHER};
    if (!names_value(session, text_of(row->name), &value))
        return;
    const size_t len = strlen(row->name);
    memcpy(value.name, row->name, len < LIMIT_NAME ? len + 1 : LIMIT_NAME);
    show_value(session, &value, row->brief, reply);
}

static void show_setting(const struct session *session, const struct setting *setting,
                         struct reply *reply)
{
    struct buffer value = {0}, text = {0};
    setting_show(setting, &session->setup.settings, &value);
    buffer_format(&text, "%s = %s", setting->row.name, buffer_view(&value));
    for (int pad = text_width(buffer_text(&text)); pad < 31; pad++)
        buffer_char(&text, ' ');
    buffer_put(&text, text_of(setting->row.brief));
    if (setting->natural && !setting_is_chosen(setting, &session->setup.settings))
        buffer_put(&text, TEXT("; the scene's own, until it is set"));
    reply_text(reply, buffer_text(&text));
    reply_begin(reply, "show");
    reply_string(reply, "name", setting->row.name);
    reply_string(reply, "value", buffer_view(&value));
    reply_null(reply, "uncertainty");
    reply_null(reply, "unit");
    reply_end(reply);
    buffer_free(&value);
    buffer_free(&text);
}

static void show_catalog_values(const struct session *session, const struct catalog *catalog,
                                struct reply *reply)
{
    for (size_t i = 0; i < catalog->count; i++)
        show_name(session, catalog_row(catalog, i), reply);
}

static void show_settings(const struct session *session, bool display_only, struct reply *reply)
{
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = setting_at(i);
        if (!display_only || setting->display || setting->plots)
            show_setting(session, setting, reply);
    }
}

static void show_scene(const struct session *session, struct reply *reply)
{
    const struct row *preset = &session->setup.scene.preset->row;
    struct buffer lines = {0};
    reply_line(reply, "scene %s: %s", preset->name, preset->brief);
    scene_lines(&session->setup.scene, "  ", &lines);
    if (lines.len > 0)
        reply_text(reply, (struct text){lines.data, lines.len - 1});
    buffer_free(&lines);
    show_catalog_values(session, scene_params(&session->setup.scene), reply);
    show_catalog_values(session, scene_derived(&session->setup.scene), reply);
}

static void show_run(const struct session *session, struct reply *reply)
{
    const struct run *run = session_run(session);
    if (run)
        reply_run(session, run, reply);
    else
        reply_line(reply, "no run");
}

static void show_data(const struct session *session, struct reply *reply)
{
    const struct recording *recording = session_recording(session);
    struct buffer text = {0};
    if (recording)
        recording_describe(recording, &text);
    else
        buffer_put(&text, TEXT("no recording"));
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
}

static void show_files(const struct session *session, struct reply *reply)
{
    for (int i = 0; i < session->recordings; i++) {
        struct buffer path = {0};
        safe_text(&path, text_of(session->recording[i]->recording->path), false);
        reply_line(reply, "read     %s (%s)", buffer_view(&path),
                   session->recording[i]->recording->name);
        buffer_free(&path);
    }
    reply_line(reply, "record   %s", session->record_path ? session->record_path : "off");
}

static void show_summary(const struct session *session, struct reply *reply)
{
    struct buffer text = {0};
    session_state_line(session, &text);
    buffer_format(&text, "\n%d run%s, %d recording%s, %d measurement%s", session->runs,
                  session->runs == 1 ? "" : "s", session->recordings,
                  session->recordings == 1 ? "" : "s", session->measurements,
                  session->measurements == 1 ? "" : "s");
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
}

/* What moves, then what follows from it. */
static void show_state(const struct session *session, const struct model *model,
                       struct reply *reply)
{
    for (int i = 0; i < model->n; i++) {
        const struct text name = text_of(model->variable[i].name);
        struct named_value value = {.quantity = QUANTITY_OTHER};
        /* y and v are observables, too */
        if (model == &oscillator_model || !names_value(session, name, &value))
            continue;
        memcpy(value.name, name.at, name.len + 1);
        show_value(session, &value, "state variable", reply);
    }
    for (int i = 0; i < model_observed(model); i++) {
        const struct variable observed = model_observed_variable(model, i);
        struct named_value value = {.quantity = QUANTITY_OTHER};
        if (!names_value(session, text_of(observed.name), &value))
            continue;
        memcpy(value.name, observed.name, sizeof observed.name);
        show_value(session, &value, "observed", reply);
    }
    for (size_t i = 0; i < observable_catalog.count; i++) {
        const struct row *row = catalog_row(&observable_catalog, i);
        const bool is_state =
            model != &oscillator_model && model_variable(model, text_of(row->name)) >= 0;
        if (!is_state && model_offers(model, (const struct observable *)(const void *)row))
            show_name(session, row, reply);
    }
}

static void show_all(const struct session *session, struct reply *reply)
{
    show_scene(session, reply);
    show_settings(session, false, reply);
    for (int i = 0; i < session->setup.lets; i++)
        show_value(session, &session->setup.let[i], "variable", reply);
    for (int i = 0; i < session->results; i++)
        show_value(session, &session->result[i], "result", reply);
    if (session_run(session))
        show_state(session, session_run(session)->system.model, reply);
}

HANDLER(show)
{
    const struct argument_value *what = argument_value(args, "NAME");
    const struct scene *scene = &session->setup.scene;
    struct named_value value = {.quantity = QUANTITY_OTHER};
    if (what->count == 0) {
        show_summary(session, reply);
        return true;
    }
    const struct text name = what->item->text;
    const struct row *row = catalog_find(&show_catalog, name);
    if (row) {
        switch ((enum show_topic)catalog_index(&show_catalog, row)) {
        case SHOW_ALL:
            show_all(session, reply);
            break;
        case SHOW_SCENE:
            show_scene(session, reply);
            break;
        case SHOW_RUN:
            show_run(session, reply);
            break;
        case SHOW_DATA:
            show_data(session, reply);
            break;
        case SHOW_PLOT:
            show_settings(session, true, reply);
            break;
        case SHOW_FILES:
            show_files(session, reply);
            break;
        }
        return true;
    }
    if ((row = catalog_find(&setting_catalog, name))) {
        show_setting(session, (const struct setting *)(const void *)row, reply);
        return true;
    }
    if (names_value(session, name, &value)) {
        const struct run *run = session_run(session);
        const struct catalog *const catalogs[] = {scene_params(scene), scene_derived(scene),
                                                  &observable_catalog};
        for (size_t i = 0; i < COUNT_OF(catalogs) && !row; i++)
            row = catalog_find(catalogs[i], name);
        /* `y` of two coordinates is not the first of them, which the observable means. */
        const bool is_state = run && run->system.model != &oscillator_model &&
                              (model_variable(run->system.model, name) >= 0 ||
                               model_observation(run->system.model, name) >= 0);
        memcpy(value.name, name.at, name.len < LIMIT_NAME ? name.len : LIMIT_NAME);
        if (row && !is_state)
            show_name(session, row, reply);
        else
            show_value(session, &value, "", reply);
        return true;
    }
    if (model_variable(scene->model, name) >= 0 || model_observation(scene->model, name) >= 0) {
        error_at(error, name, "'%.*s' has no value: there is no run of this scene yet",
                 (int)name.len, name.at);
        return error_hint(error, "type: run  ('show scene' lists where it starts)");
    }
    error_at(error, name, "unknown name '%.*s'", (int)(name.len < 80 ? name.len : 80), name.at);
    if (hint_other_model(session, name, error))
        return false;
    struct suggestion near = {.wanted = name};
    const struct catalog *const catalogs[] = {&show_catalog, scene_params(scene),
                                              scene_derived(scene), &setting_catalog};
    for (size_t c = 0; c < COUNT_OF(catalogs); c++)
        for (size_t i = 0; i < catalogs[c]->count; i++)
            suggestion_offer(&near, catalog_row(catalogs[c], i)->name);
    suggestion_hint(&near, error);
    return error_hint(error, "('show all' lists the names)");
}
#endif

COMMAND(show, .row = {"show", "", "show values: of a name, a group, or a summary", "", NULL},
        .group = "SCENE", .text = "Groups are all, scene, run, data, plot and files.",
        .examples = "show k\nshow all", .see = "set print list help", .flags = COMMAND_ANYTIME,
        .completes = COMPLETES_SHOWN, ARGUMENTS(PLACE("NAME", TYPE_NAME)))
