/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command show: values of names, settings, and summaries. */
#ifndef COMMAND_ROWS
#include <hooke/data.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/session/series_tools.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <string.h>

/* Value or text of a name, as a row of the record. */
struct shown {
    const char *name, *text; /* text is that of a setting, or NULL */
    double value, uncertainty;
    const char *unit;
};

/* Adds the value or text to a record. */
static void put_shown(struct reply *reply, const char *key, const void *row)
{
    const struct shown *shown = row;
    if (shown->text)
        reply_string(reply, key, shown->text);
    else
        reply_real(reply, key, shown->value);
}

#define AT(member) .offset = offsetof(struct shown, member)

static const struct result_column of_shown[] = {
    {.name = "name", .kind = COLUMN_NAME, AT(name)},
    {.name = "value", .record = put_shown},
    {.name = "uncertainty", AT(uncertainty)},
    {.name = "unit", .kind = COLUMN_NAME, AT(unit)},
};
static const struct result_columns shown_columns = RESULT_COLUMNS(of_shown, struct shown);

/* Replies NAME = VALUE, then the description in its column, and adds the record. */
static void shown_value_put(struct reply *reply, const struct shown *shown, const char *value,
                            const char *brief, const char *more)
{
    const int pad = 31 - text_width(text_of(shown->name)) - text_width(text_of(value)) - 3;
    reply_line(reply, "%s = %s%*s%s%s", shown->name, value, *brief && pad > 1 ? pad : *brief != 0,
               "", brief, more);
    reply_records(reply, "show", &shown_columns, shown, 1);
}

/* Replies with a named value, its uncertainty and unit, rounded to the setting `digits`; a value
 * that is not finite is shown as "undefined". `brief` describes the value. */
static void show_value(const struct session *session, const struct named_value *value,
                       const char *brief, struct reply *reply)
{
    const struct measured measured = {value->value, value->uncertainty};
    const struct shown shown = {value->name, NULL, value->value, value->uncertainty,
                                value->quantity == QUANTITY_OTHER ? NULL
                                                                  : quantity_unit(value->quantity)};
    shown_value_put(reply, &shown,
                    isfinite(value->value)
                        ? SHOWN_MEASURED(measured, value->quantity, session->setup.settings.digits)
                        : "undefined",
                    brief, "");
}

/* Shows the value of a row's name, if it has one at present. */
static void show_name(const struct session *session, const struct row *row, struct reply *reply)
{
    struct named_value value = {.quantity = QUANTITY_OTHER};
    if (!names_value(session, text_of(row->name), &value))
        return;
    const size_t len = strlen(row->name);
    memcpy(value.name, row->name, len < LIMIT_NAME ? len + 1 : LIMIT_NAME);
    show_value(session, &value, row->brief, reply);
}

/* Shows a setting, and that its value comes from the scene if the user has not set it. */
static void show_setting(const struct session *session, const struct setting *setting,
                         struct reply *reply)
{
    struct buffer value = {0};
    setting_show(setting, &session->setup.settings, &value);
    const bool natural = setting->natural && !setting_is_chosen(setting, &session->setup.settings);
    const struct shown shown = {setting->row.name, buffer_view(&value), NAN, NAN, NULL};
    shown_value_put(reply, &shown, shown.text, setting->row.brief,
                    natural ? "; from the scene, because it was not set" : "");
    buffer_free(&value);
}

static void show_catalog_values(const struct session *session, const struct catalog *catalog,
                                struct reply *reply)
{
    for (size_t i = 0; i < catalog->count; i++)
        show_name(session, catalog_row(catalog, i), reply);
}

/* Shows all settings, or only those of how results look. */
static void show_settings(const struct session *session, bool display_only, struct reply *reply)
{
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = setting_at(i);
        if (!display_only || setting->display || setting->plots)
            show_setting(session, setting, reply);
    }
}

/* Shows the scene: its lines, parameters and derived quantities. */
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

/* Shows the current run. */
static void show_run(const struct session *session, struct reply *reply)
{
    const struct run *run = session_run(session);
    if (run)
        reply_run(session, run, reply);
    else
        reply_line(reply, "no run");
}

/* Shows the current recording. */
static void show_data(const struct session *session, struct reply *reply)
{
    const struct recording *recording = session_recording(session);
    struct buffer *text = reply_buffer(reply);
    if (recording)
        series_tools()->describe(recording, text);
    else
        buffer_put(text, TEXT("no recording"));
}

/* Shows the files that were read, and the file of `record`. */
static void show_files(const struct session *session, struct reply *reply)
{
    for (int i = 0; i < session->recordings; i++) {
        struct buffer path = {0};
        safe_text(&path, text_of(session->recording[i]->recording->path), false);
        reply_line(reply, "read     %s (%s)", buffer_view(&path),
                   session->recording[i]->recording->name);
        buffer_free(&path);
    }
    reply_line(reply, "record   %s", session->transcript.path ? session->transcript.path : "off");
}

/* Shows the state line and the numbers of runs, recordings and measurements. */
static void show_summary(const struct session *session, struct reply *reply)
{
    struct buffer *text = reply_buffer(reply);
    session_state_line(session, text);
    buffer_format(text, "\n%d run%s, %d recording%s, %d measurement%s", session->runs.count,
                  plural_s(session->runs.count), session->recordings, plural_s(session->recordings),
                  session->measurements, plural_s(session->measurements));
}

/* Shows the variables and then the quantities derived from them. */
static void show_state(const struct session *session, const struct model *model,
                       struct reply *reply)
{
    for (int i = 0; i < model->n; i++) {
        const struct text name = text_of(model->variable[i].name);
        struct named_value value = {.quantity = QUANTITY_OTHER};
        /* y and v are observables, too */
        if (model == &oscillator_model || !names_value(session, name, &value))
            continue;
        memcpy(value.name, name.data, name.len + 1);
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
        if (!is_state && model_offers(model, observable_from(row)))
            show_name(session, row, reply);
    }
}

/* Shows every name that has a value. */
static void show_all(const struct session *session, struct reply *reply)
{
    show_scene(session, reply);
    show_settings(session, false, reply);
    for (int i = 0; i < session->setup.lets; i++)
        show_value(session, &session->setup.let[i], "variable", reply);
    for (int i = 0; i < session->results.count; i++)
        show_value(session, &session->results.value[i], "result", reply);
    if (session_run(session))
        show_state(session, session_run(session)->system.model, reply);
}

/* Shows a topic, a setting or a name; explains why a name has no value. */
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
        show_setting(session, setting_from(row), reply);
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
        memcpy(value.name, name.data, name.len < LIMIT_NAME ? name.len : LIMIT_NAME);
        if (row && !is_state)
            show_name(session, row, reply);
        else
            show_value(session, &value, "", reply);
        return true;
    }
    if (model_variable(scene->model, name) >= 0 || model_observation(scene->model, name) >= 0) {
        error_at(error, name, "'%.*s' has no value: there is no run of this scene yet",
                 (int)name.len, name.data);
        return error_hint(error, "type: run  ('show scene' lists the initial values)");
    }
    error_at(error, name, "unknown name '%.*s'", (int)(name.len < 80 ? name.len : 80), name.data);
    error->unknown = "name";
    if (hint_other_model(session, name, error))
        return false;
    struct suggestion suggestion = {.wanted = name};
    const struct catalog *const catalogs[] = {&show_catalog, scene_params(scene),
                                              scene_derived(scene), &setting_catalog};
    for (size_t c = 0; c < COUNT_OF(catalogs); c++)
        for (size_t i = 0; i < catalogs[c]->count; i++)
            suggestion_offer(&suggestion, catalog_row(catalogs[c], i)->name);
    suggestion_hint(&suggestion, error);
    return error_hint(error, "('show all' lists the names)");
}
#endif

COMMAND(show, .group = "SCENE", .flags = COMMAND_ANYTIME, .completes = COMPLETES_SHOWN,
        ARGUMENTS(PLACE("NAME", TYPE_NAME)))
