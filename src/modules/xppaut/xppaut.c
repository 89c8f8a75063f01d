/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module xppaut: `load scene FILE.ode` makes a typed scene from XPPAUT's file, with its method,
 * times and events. */
#include "modules/xppaut/ode_file.h"
#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>
#include <hooke/module.h>

#include <stdio.h>
#include <string.h>

#define FILE_MAX ((size_t)1 << 22) /* [byte] */

/* Returns true if the program needs the name for a setting. */
static bool is_setting(struct text name)
{
    return catalog_find(&setting_catalog, name);
}

/* Makes the scene's name from that of the file, without folders and ".ode"; characters that names
 * cannot have become -. Appends "-ode" if the program has a scene of that name, or for "new". */
static void scene_name_of(struct text file, char name[LIMIT_SYMBOL + 1])
{
    static const char mark[] = "-ode";
    struct text base = text_last_component(file);
    size_t len = 0;
    if (base.len > 4 && text_is((struct text){base.data + base.len - 4, 4}, ".ode"))
        base.len -= 4;
    if (base.len == 0 || !is_name_start(base.data[0]))
        name[len++] = 'o';
    for (size_t i = 0; i < base.len && len + sizeof mark <= LIMIT_SYMBOL; i++)
        name[len++] = is_name_char(base.data[i]) ? base.data[i] : '-';
    name[len] = '\0';
    if (catalog_find(&preset_catalog, text_of(name)) || text_is(text_of(name), "new"))
        memcpy(name + len, mark, sizeof mark);
}

/* Prefixes the error with "FILE: ", since its position is in that file. */
static bool name_file_in_error(struct text file, struct error *error)
{
    char text[sizeof error->text], name[SAFE_NAME_SIZE];
    memcpy(text, error->text, sizeof text);
    snprintf(error->text, sizeof error->text, "%s: %.400s", safe_name(file, name), text);
    if (error->code != ERROR_CANCELLED)
        error->code = ERROR_IO;
    error->where = file;
    return false;
}

/* Prefixes the error's text with the name of the line of the scene in which error->where lies, if
 * there is one. */
static void name_line_in_error(const struct ode_scene *scene, struct error *error)
{
    char text[sizeof error->text];
    const struct typed_line *line = scene->line, *end = line + scene->lines;
    while (line < end && !(error->where.data >= line->expr.data &&
                           error->where.data <= line->expr.data + line->expr.len))
        line++;
    if (!error->where.data || line == end)
        return;
    memcpy(text, error->text, sizeof text);
    snprintf(error->text, sizeof error->text, "%.*s: %.400s", (int)line->name.len, line->name.data,
             text);
}

/* ---- the set-up ---- */

/* Sets how often rows are recorded: every so many steps, or times if the method adapts. Returns
 * false with an error. */
static bool set_record(struct settings *settings, const struct ode_scene *scene, bool adapts,
                       struct error *error)
{
    const struct row *row = catalog_find(&setting_catalog, TEXT("record"));
    char every[REAL_TEXT_SIZE + 32], time[REAL_TEXT_SIZE];
    real_format(scene->dt * scene->every, time);
    if (adapts)
        snprintf(every, sizeof every, "every %s s", time);
    else
        snprintf(every, sizeof every, "every %d", scene->every);
    return (!adapts && scene->every == 1) ||
           (setting_from(row))->parse(settings, text_of(every), error);
}

/* Sets method, steps, tolerance and duration of the set-up as the file has them. Steps are fixed
 * unless both the method and the file's method adapt them. Returns false with an error. */
static bool set_method(struct setup *setup, const struct ode_scene *scene, struct error *error)
{
    const struct row *row = catalog_find(&method_catalog, text_of(scene->method));
    const struct method *method = method_from(row);
    const bool adapts = (method->flags & METHOD_ADAPTIVE) && scene->adapts;
    struct settings *settings = &setup->settings;
    setup->method = method;
    setup->method_chosen = true;
    setup->drag = DRAG_DEFAULT;
    setup->fixed = !adapts;
    settings->dt = scene->dt;
    settings->duration = scene->total;
    settings->dt_chosen = settings->duration_chosen = true;
    if (scene->tol > 0) {
        settings->tol = scene->tol;
        settings->tol_chosen = true;
    }
    return set_record(settings, scene, adapts, error);
}

/* Adds the events of the file to the session. Returns false with an error that names the line. */
static bool add_events(struct session *session, const struct arguments *args,
                       const struct ode_scene *scene, struct error *error)
{
    for (int i = 0; i < scene->events; i++) {
        const struct ode_event *event = &scene->event[i];
        char name[32];
        struct buffer rule = {0};
        snprintf(name, sizeof name, "global%d", i + 1);
        buffer_format(&rule, "when %s do ", event->when);
        if (*event->commands)
            buffer_format(&rule, "'%s'", event->commands);
        else
            buffer_put(&rule, TEXT("stop"));
        char *text = rule.failed ? NULL : arena_text(args->arena, buffer_text(&rule));
        buffer_free(&rule);
        if (!text)
            return error_memory(error);
        if (event_add(session, args->arena, text_of(name), text_of(text), error))
            continue;
        char why[sizeof error->text];
        memcpy(why, error->text, sizeof why);
        snprintf(error->text, sizeof error->text, "line %d: %.400s", event->line, why);
        return false;
    }
    return true;
}

/* Makes the scene read from `file` the session's scene, with its method and events. Returns false
 * with an error; the caller then restores the set-up. */
static bool ode_scene_take(struct session *session, const struct arguments *args, struct text file,
                           const struct ode_scene *ode_scene, struct error *error)
{
    struct setup *setup = &session->setup;
    struct system *system = arena_alloc(args->arena, sizeof *system);
    char name[LIMIT_SYMBOL + 1];
    if (!system)
        return error_memory(error);
    scene_name_of(file, name);
    const struct model *model =
        typed_make(session->definitions.models, text_of(name), ode_scene->line, ode_scene->lines,
                   session->front.cancel, error);
    if (!model) {
        name_line_in_error(ode_scene, error);
        return false;
    }
    scene_init(&setup->scene, typed_preset(model));
    settings_of_scene(&setup->settings, setup->scene.preset);
    setup->events = NULL;
    if (ode_scene->t0 != 0 && !scene_set(&setup->scene, scene_param(&setup->scene, "t0"),
                                         (struct measured){ode_scene->t0, 0}, error))
        return false;
    return scene_bind(&setup->scene, system, error) && keep_own_scene(session, error) &&
           set_method(setup, ode_scene, error) && add_events(session, args, ode_scene, error);
}

/* ---- what is said ---- */

/* Returns the number of lines of a kind. */
static int count_of(const struct ode_scene *scene, enum typed_kind kind)
{
    int count = 0;
    for (int i = 0; i < scene->lines; i++)
        count += scene->line[i].kind == kind;
    return count;
}

/* Lists the sets of values that the file has. */
static void put_sets(const struct ode_scene *ode_scene, struct buffer *text)
{
    char name[SAFE_NAME_SIZE];
    for (int i = 0; i < ode_scene->sets; i++)
        buffer_format(text, "%s%s", i == 0 ? "\n  sets for set=NAME: " : " ",
                      safe_name(ode_scene->set[i], name));
}

/* Replies with what was read from an XPPAUT file: how many variables, parameters and events it has,
 * its method and duration, notes and warnings of the translation, and the record `scene`. */
static void reply_from(const struct session *session, const struct ode_scene *ode_scene,
                       struct text file, struct reply *reply)
{
    const struct setup *setup = &session->setup;
    const int variables = count_of(ode_scene, TYPED_VAR), params = count_of(ode_scene, TYPED_PARAM),
              observed = count_of(ode_scene, TYPED_OBSERVE);
    struct buffer text = {0};
    buffer_format(&text, "scene %s: %d variable%s, %d parameter%s, %d observed, %d event%s\n  ",
                  setup->scene.preset->row.name, variables, plural_s(variables), params,
                  plural_s(params), observed, ode_scene->events, plural_s(ode_scene->events));
    buffer_quantity(&text, ode_scene->total, QUANTITY_TIME, 6);
    buffer_format(&text, " by %s", ode_scene->method);
    if (setup->fixed) {
        buffer_put(&text, TEXT(", dt = "));
        buffer_quantity(&text, ode_scene->dt, QUANTITY_TIME, 6);
    }
    if (ode_scene->meant)
        buffer_format(&text, " (in the file: %s)", ode_scene->meant);
    buffer_put(&text, TEXT("; 'scene' shows its equations, 'run' runs it"));
    put_sets(ode_scene, &text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    for (int i = 0; i < ode_scene->notes; i++) {
        if (ode_scene->note[i].warns)
            reply_warning(reply, "%s", ode_scene->note[i].text);
        else
            reply_line(reply, "  %s", ode_scene->note[i].text);
    }
    char name[SAFE_NAME_SIZE];
    reply_begin(reply, "scene");
    reply_string(reply, "name", setup->scene.preset->row.name);
    reply_string(reply, "file", safe_name(file, name));
    reply_int(reply, "variables", variables);
    reply_int(reply, "parameters", params);
    reply_int(reply, "observed", observed);
    reply_int(reply, "events", ode_scene->events);
    reply_string(reply, "method", ode_scene->method);
    reply_real(reply, "duration", ode_scene->total);
    reply_real(reply, "dt", ode_scene->dt);
    reply_array(reply, "notes");
    for (int i = 0; i < ode_scene->notes; i++)
        reply_string(reply, NULL, ode_scene->note[i].text);
    reply_close(reply);
    reply_end(reply);
}

/* Reads an XPPAUT file and makes it the session's scene; `set` is the name of a set of values in
 * the file, in any case, or empty. Replies with a summary. Returns false with an error, and leaves
 * the session unchanged, if the file cannot be read or translated. */
static bool ode_load(struct session *session, const struct arguments *args, struct text file,
                     struct text set, struct reply *reply, struct error *error)
{
    char *path = script_path(args->where, file, args->arena);
    if (!path)
        return error_memory(error);
    struct buffer content = {0};
    char *lower = arena_text(args->arena, set);
    for (char *c = lower; c && *c; c++)
        *c = *c >= 'A' && *c <= 'Z' ? (char)(*c - 'A' + 'a') : *c;
    const struct ode_options options = {
        .set = text_of(lower), .taken = is_setting, .cancel = session->front.cancel};
    struct ode_scene ode_scene;
    struct setup *previous = arena_alloc(args->arena, sizeof *previous);
    if (!file_read(path, FILE_MAX, &content, error)) {
        error->where = file;
        return false;
    }
    bool fine = lower && previous;
    if (fine)
        *previous = session->setup;
    else
        error_memory(error);
    if (fine && !ode_read(buffer_text(&content), &options, args->arena, &ode_scene, error))
        fine = name_file_in_error(file, error);
    buffer_free(&content);
    if (fine && !ode_scene_take(session, args, file, &ode_scene, error)) {
        session->setup = *previous;
        fine = name_file_in_error(file, error);
    }
    if (!fine)
        return false;
    session->execution.said_assumed = false;
    session->view.starts = 0;
    session_changed(session);
    reply_from(session, &ode_scene, file, reply);
    return true;
}

const struct module xppaut_module = {
    .row = {"xppaut", "", "scenes from XPPAUT's .ode files", "", NULL},
    .needs = "recording",
    .reader =
        {
            .ending = "ode",
            .kind = "files of XPPAUT",
            .load = ode_load,
        },
};
