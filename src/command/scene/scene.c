/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands scene, set (NAME = VALUE), unset and let. */
#ifndef COMMAND_ROWS
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/plot.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Appends NAME = VALUE of a parameter. */
static void put_param(const struct session *session, int param, struct buffer *text)
{
    const struct scene *scene = &session->setup.scene;
    const struct param_row *row = param_at(scene, param);
    const struct measured value = {scene->value[param], scene->uncertainty[param]};
    buffer_format(text, "%s = %s", row->row.name,
                  SHOWN_MEASURED(value, row->quantity, session->setup.settings.digits));
}

/* ---- scene ---- */

/* Returns true if the preset gives the parameter a value. */
static bool preset_sets(const struct preset *preset, const char *name)
{
    for (size_t i = 0; i < COUNT_OF(preset->value) && preset->value[i].param; i++)
        if (strcmp(preset->value[i].param, name) == 0)
            return true;
    return false;
}

/* Replies with the scene: preset, lines, parameters (of an oscillator m, k, gamma, y0, v0 and those
 * that the user or the preset has set), duration and events. */
static void reply_scene(const struct session *session, struct reply *reply)
{
    static const char always[] = " m k gamma y0 v0 ";
    const struct scene *scene = &session->setup.scene;
    struct buffer text = {0};
    buffer_format(&text, "%s: %s\n", scene->preset->row.name, scene->preset->row.brief);
    scene_lines(scene, "  ", &text);
    if (scene->model->n == 0)
        buffer_put(&text, TEXT("  no variable yet: 'var NAME = VALUE' makes one\n"));
    buffer_char(&text, ' ');
    for (int i = 0; i < (int)scene_params(scene)->count; i++) {
        const char *name = param_at(scene, i)->row.name;
        char padded[LIMIT_NAME + 3];
        snprintf(padded, sizeof padded, " %s ", name);
        if (is_oscillator(scene) && !strstr(always, padded) && !scene->chosen[i] &&
            !preset_sets(scene->preset, name))
            continue;
        buffer_char(&text, ' ');
        put_param(session, i, &text);
        buffer_char(&text, ' ');
    }
    while (text.len > 0 && text.data[text.len - 1] == ' ')
        text.len--;
    if (scene->preset->duration > 0) {
        const struct settings *settings = &session->setup.settings;
        buffer_format(&text, "\n  duration %s",
                      SHOWN_QUANTITY(scene->preset->duration, QUANTITY_TIME, 6));
        if (settings->duration != scene->preset->duration)
            buffer_format(&text, "; the setting duration is %s",
                          SHOWN_QUANTITY(settings->duration, QUANTITY_TIME, 6));
    }
    if (session->setup.events) {
        buffer_char(&text, '\n');
        events_save(session->setup.events, &text);
    }
    reply_text(reply, text_trim(buffer_text(&text)));
    buffer_free(&text);
}

/* Warns of the user's variables that are hidden by names of the new scene. */
static void warn_hidden(const struct session *session, struct reply *reply)
{
    for (int i = 0; i < session->setup.lets; i++) {
        const char *name = session->setup.let[i].name, *kind;
        if (name_is_taken(session, text_of(name), &kind))
            reply_warning(reply, "'%s' is a %s of %s: the variable of that name is hidden", name,
                          kind, session->setup.scene.preset->row.name);
    }
}

bool keep_own_scene(struct session *session, struct error *error)
{
    struct setup *setup = &session->setup;
    const struct preset *own = typed_preset(setup->scene.model);
    int i = 0;
    while (own && i < setup->owns && strcmp(setup->own[i]->row.name, own->row.name) != 0)
        i++;
    if (i == LIMIT_OWN)
        return error_set(error, ERROR_COMMAND, "%d scenes of your own exist already", LIMIT_OWN);
    if (own)
        setup->own[i] = own;
    setup->owns += own && i == setup->owns;
    return true;
}

/* Begins an empty typed scene. Returns false with the error set. */
static bool new_scene(struct session *session, const struct argument_value *name,
                      struct error *error)
{
    const struct text as = name->count ? name->item->text : TEXT("");
    if (peek_name(as).len < as.len)
        return error_at(error, as, "a name begins with a letter and has letters, digits, _ and -");
    if (name->count && (text_is(as, "new") || catalog_find(&preset_catalog, as)))
        return error_at(error, as, "'%.*s' is already used", (int)as.len, as.data);
    const struct model *model = typed_new(session->definitions.models, as, error);
    if (!model)
        return false;
    struct setup *setup = &session->setup;
    const struct scene previous = setup->scene;
    scene_init(&setup->scene, typed_preset(model));
    settings_of_scene(&setup->settings, setup->scene.preset);
    if (keep_own_scene(session, error))
        return true;
    setup->scene = previous;
    return false;
}

/* Chooses a preset or begins a typed scene; then describes it. */
HANDLER(scene)
{
    const struct argument_value *name = argument_value(args, "NAME|new"),
                                *as = argument_value(args, "NAME");
    if (name->count) {
        const struct model *previous = session->setup.scene.model;
        const struct preset *preset = preset_from(name->item->row);
        if (preset && as->count)
            return error_at(
                error, as->where,
                "only one name is possible; 'scene new NAME' begins a scene of your own");
        session->execution.said_assumed = false;
        if (preset)
            scene_init(&session->setup.scene, preset);
        else if (!new_scene(session, as, error))
            return false;
        settings_of_scene(&session->setup.settings, session->setup.scene.preset);
        /* events may use names that the new scene lacks */
        if (session->setup.scene.model != previous)
            session->setup.events = NULL;
        session->view.starts = 0;
        session_changed(session);
        warn_hidden(session, reply);
    }
    reply_scene(session, reply);
    return true;
}

/* ---- set, unset, let ---- */

/* Returns the text after NAME, without the "=" of an assignment. */
struct parser value_parser(struct session *session, const struct arguments *args)
{
    struct text value = argument_value(args, "VALUE")->item->text;
    if (value.len > 0 && value.data[0] == '\'') /* part of a velocity's name */
        value = text_after(value, 1);
    text_skip_blanks(&value);
    if (value.len > 0 && value.data[0] == '=')
        value = text_after(value, 1);
    return (struct parser){session, args->scope, args->arena, value};
}

bool read_value(struct parser *parser, const char *what, enum quantity quantity, struct item *item,
                struct error *error)
{
    return parse_value(parser, what, quantity, item, error) && refuse_rest(parser, item, error);
}

/* Replies with the value that was set, unless an event sets it (often). Frees the text. */
static void reply_set(const struct session *session, struct buffer *text, struct reply *reply)
{
    if (!session->execution.passing)
        reply_text(reply, buffer_text(text));
    buffer_free(text);
}

/* Returns the variable of the current run's state with that name, if it may be set, or -1. */
static int state_named(const struct session *session, struct text name, struct text value)
{
    const struct run *run = session_run(session);
    if (!run || (!session->execution.reacting && !session->live.changing))
        return -1;
    name.len += value.len > 0 && value.data == name.data + name.len && value.data[0] == '\'';
    return model_state(run->system.model, name);
}

/* Changes the parameter in a run in progress, too. On failure restores the scene, returns false. */
static bool bind_param(struct session *session, int param, const struct scene *previous,
                       double *start_time, struct error *error)
{
    if (live_bind(session, param, start_time, error))
        return true;
    session->setup.scene = *previous;
    return false;
}

/* Notes a value that is far from the usual one and was probably meant in another unit. */
static void note_slip(const struct session *session, int param, const struct item *item,
                      struct reply *reply)
{
    static const double far_ratio = 100; /* larger than every change that the lab asks for */
    const struct scene *scene = &session->setup.scene;
    const struct param_row *row = param_at(scene, param);
    const struct preset *preset = scene->preset;
    const bool bare = strspn(item->text.data, "0123456789.eE+-") >= item->text.len;
    double usual = row->initial, meant = 0;
    if (session->execution.reacting || session->execution.restoring || scene->model->typed)
        return;
    for (size_t i = 0; i < COUNT_OF(preset->value) && preset->value[i].param; i++)
        if (strcmp(preset->value[i].param, row->row.name) == 0)
            usual = preset->value[i].value;
    const double ratio = usual != 0 ? fabs(item->value.value / usual) : 1;
    if (bare && ratio >= far_ratio) {
        const struct unit *shown = unit_display(row->quantity, usual);
        struct buffer text = {0};
        if (shown && unit_convert(shown, row->quantity, item->value.value, &meant) &&
            fabs(log10(meant / usual)) < 1)
            buffer_format(&text, "; in %s: %s = %.*s %s", shown->row.name, row->row.name,
                          (int)item->text.len, item->text.data, shown->row.name);
        reply_note(reply, "  (%s times the scene's %s%s)",
                   SHOWN_QUANTITY(ratio, QUANTITY_NUMBER, 3),
                   SHOWN_QUANTITY(usual, row->quantity, 6), buffer_view(&text));
        buffer_free(&text);
    }
}

/* Sets a parameter and replies with it. Returns false with the error set. */
static bool set_param(struct session *session, int param, const struct item *item,
                      struct reply *reply, struct error *error)
{
    const struct scene previous = session->setup.scene;
    double start_time;
    if (!scene_set(&session->setup.scene, param, item->value, error) ||
        !bind_param(session, param, &previous, &start_time, error)) {
        error->where = item->text;
        return false;
    }
    struct buffer text = {0};
    put_param(session, param, &text);
    buffer_since(&text, start_time);
    reply_set(session, &text, reply);
    note_slip(session, param, item, reply);
    return true;
}

/* Sets a variable of the current run (a jump). Returns false with the error set. */
static bool set_state(struct session *session, int variable, struct parser *parser,
                      struct reply *reply, struct error *error)
{
    struct run *run = session_run(session);
    const struct variable moving = system_variable(&run->system, variable);
    const struct parser previous = *parser;
    struct item item = {0};
    struct buffer text = {0};
    double slope[LIMIT_VARIABLES + 1];
    if (!read_value(parser, moving.name, moving.quantity, &item, error))
        return false;
    const bool answers =
        run->plan.adaptive && find_slopes(&previous, run, moving.name, moving.quantity, slope);
    if (!live_kick(session, variable, item.value.value, error)) {
        error->where = item.text;
        return false;
    }
    if (answers)
        run_set_jump_slopes(run, slope);
    buffer_format(&text, "%s = %s", moving.name,
                  SHOWN_MEASURED(item.value, moving.quantity, session->setup.settings.digits));
    buffer_since(&text, run->t);
    reply_set(session, &text, reply);
    return true;
}

/* Sets the parameter that a derived quantity determines (k for T0), with its uncertainty. */
static bool set_derived(struct session *session, const struct derived_row *derived,
                        const struct item *item, struct reply *reply, struct error *error)
{
    struct scene *scene = &session->setup.scene;
    if (!derived->inverse) {
        error_at(error, item->text, "%s follows from the parameters and cannot be set",
                 derived->row.name);
        return error_hint(error, "'help %s' says from which", derived->row.name);
    }
    const double x = item->value.value, u = item->value.uncertainty;
    const double value = derived->inverse(scene, x), h = 1e-6 * fabs(x);
    const double slope =
        h > 0 ? (derived->inverse(scene, x + h) - derived->inverse(scene, x - h)) / (2 * h) : 0;
    if (!isfinite(value))
        return error_at(error, item->text, "%s cannot have this value here", derived->row.name);
    const int target = scene_param(scene, derived->target);
    const struct scene previous = *scene;
    double start_time;
    if (!scene_set(scene, target, (struct measured){value, u > 0 ? fabs(slope) * u : 0}, error) ||
        !bind_param(session, target, &previous, &start_time, error)) {
        error->where = item->text;
        return false;
    }
    struct buffer text = {0};
    buffer_format(&text, "%s = %s (", derived->row.name,
                  SHOWN_MEASURED(item->value, derived->quantity, session->setup.settings.digits));
    put_param(session, target, &text);
    buffer_char(&text, ')');
    buffer_since(&text, start_time);
    reply_set(session, &text, reply);
    return true;
}

/* Replies with a setting, and that the method does not use it if so. */
static void reply_setting(const struct session *session, const struct setting *setting,
                          struct reply *reply)
{
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%s = ", setting->row.name);
    setting_show(setting, &session->setup.settings, text);
    const struct method *method = session->setup.method;
    const struct run_settings now = session_run_settings(session);
    if (setting->use == USE_STEP && now.tol > 0)
        buffer_format(
            text, " (first step only: %s then chooses its steps; 'tol = off' gives fixed steps)",
            method->row.name);
    if (setting->use == USE_TOLERANCE) {
        put_tol_floor(text, now.tol);
        if (!(method->flags & METHOD_ADAPTIVE))
            buffer_format(text, " (only adaptive methods use it; %s has fixed steps)",
                          method->row.name);
    }
}

/* Sets a variable of the user and replies with it. Returns false with the error set. */
static bool set_let(struct session *session, struct text name, const struct item *item,
                    struct reply *reply, struct error *error)
{
    struct setup *setup = &session->setup;
    struct named_value *let = NULL;
    for (int i = 0; i < setup->lets; i++)
        if (text_is(name, setup->let[i].name))
            let = &setup->let[i];
    if (name.len > LIMIT_NAME)
        return error_at(error, name, "the name has more than %d letters", LIMIT_NAME);
    if (!let && setup->lets == LIMIT_LET)
        return error_at(error, name, "%d variables exist already", LIMIT_LET);
    if (!let)
        let = &setup->let[setup->lets++];
    *let = (struct named_value){.value = item->value.value,
                                .uncertainty = item->value.uncertainty,
                                .quantity = item->quantity};
    memcpy(let->name, name.data, name.len);
    session_changed(session);
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%s = %s", let->name,
                  SHOWN_MEASURED(item->value, item->quantity, setup->settings.digits));
    return true;
}

/* Sets NAME: variable of the run, parameter, derived quantity, setting or variable of let. */
HANDLER(set)
{
    const struct text name = argument_value(args, "NAME")->item->text;
    const struct catalog *params = scene_params(&session->setup.scene);
    struct parser parser = value_parser(session, args);
    struct item item = {0};
    const struct row *row;
    const int variable = state_named(session, name, argument_value(args, "VALUE")->item->text);
    const bool depends = variable < 0 && value_depends(session, &parser);
    bool ok;
    if (variable >= 0) {
        ok = set_state(session, variable, &parser, reply, error);
    } else if ((row = catalog_find(params, name))) {
        const struct param_row *param = (const struct param_row *)(const void *)row;
        ok = read_value(&parser, row->name, param->quantity, &item, error) &&
             set_param(session, catalog_index(params, row), &item, reply, error);
    } else if ((row = catalog_find(scene_derived(&session->setup.scene), name))) {
        const struct derived_row *derived = (const struct derived_row *)(const void *)row;
        ok = read_value(&parser, row->name, derived->quantity, &item, error) &&
             set_derived(session, derived, &item, reply, error);
    } else if ((row = catalog_find(&setting_catalog, name))) {
        const struct setting *setting = setting_from(row);
        struct settings changed = session->setup.settings;
        struct item *value = argument_value(args, "VALUE")->item;
        value->text = text_trim(parser.rest);
        ok = check_typed(session, setting, args->where, error) &&
             setting_read(setting, &parser, &changed, error);
        if (ok) {
            value->row = setting_choice(setting, &changed); /* the choice may be abbreviated */
            session->setup.settings = changed;
            setting_choose(setting, true, &session->setup.settings);
            reply_setting(session, setting, reply);
            if (setting->choices == &turning_catalog)
                reply_inapplicable(session, reply);
        }
    } else {
        int index = 0;
        while (index < session->setup.lets && !text_is(name, session->setup.let[index].name))
            index++;
        ok = index < session->setup.lets ? read_value(&parser, session->setup.let[index].name,
                                                      QUANTITY_OTHER, &item, error) &&
                                               set_let(session, name, &item, reply, error)
                                         : unknown_parameter(session, name, parser.rest, error);
    }
    if (ok && depends)
        forget_jump_slopes(session);
    if (ok)
        session_changed(session);
    return ok;
}

static const struct row unset_rows[] = {
    {"method", "", "method, its fixed step and its drag", "", NULL},
};
const struct catalog unset_catalog = CATALOG("choice", unset_rows);

/* Gives NAME its default value, or removes a variable of let. */
HANDLER(unset)
{
    const struct text name = argument_value(args, "NAME")->item->text;
    const struct catalog *params = scene_params(&session->setup.scene);
    const struct row *row = catalog_find(params, name);
    struct buffer text = {0};
    if (row) {
        const int param = catalog_index(params, row);
        const struct scene previous = session->setup.scene;
        double start_time;
        scene_unset(&session->setup.scene, param);
        if (!bind_param(session, param, &previous, &start_time, error))
            return false;
        put_param(session, param, &text);
        buffer_since(&text, start_time);
    } else if ((row = catalog_find(&setting_catalog, name))) {
        const struct setting *setting = setting_from(row);
        struct settings defaults;
        session_default_settings(&defaults);
        setting_copy(setting, &defaults, &session->setup.settings);
        setting_choose(setting, false, &session->setup.settings);
        settings_of_scene(&session->setup.settings, session->setup.scene.preset);
        buffer_format(&text, "%s = ", row->name);
        setting_show(setting, &session->setup.settings, &text);
    } else if (catalog_find(&unset_catalog, name)) {
        session_unset_method(&session->setup);
        buffer_format(&text, "method = %s", session->setup.method->row.name);
    } else {
        int index = 0;
        while (index < session->setup.lets && !text_is(name, session->setup.let[index].name))
            index++;
        if (index == session->setup.lets)
            return unknown_parameter(session, name, TEXT(""), error);
        buffer_format(&text, "%s is removed", session->setup.let[index].name);
        session->setup.let[index] = session->setup.let[--session->setup.lets];
    }
    session_changed(session);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}

/* Defines or changes a variable of the user. */
HANDLER(let)
{
    const struct text name = argument_value(args, "NAME")->item->text;
    const char *kind;
    if (name_is_taken(session, name, &kind)) {
        error_at(error, name, "'%.*s' cannot be used: it is the name of %s %s", (int)name.len,
                 name.data, strchr("aeiou", kind[0]) ? "an" : "a", kind);
        return error_hint(error, "choose another name for the variable, as %.*s_1", (int)name.len,
                          name.data);
    }
    struct parser parser = value_parser(session, args);
    struct item item = {0};
    const bool depends = value_depends(session, &parser);
    const bool ok = read_value(&parser, "the variable", QUANTITY_OTHER, &item, error) &&
                    set_let(session, name, &item, reply, error);
    if (ok && depends)
        forget_jump_slopes(session);
    return ok;
}
#endif

COMMAND(scene, .group = "SCENE", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("NAME|new", TYPE_SCENE), PLACE("NAME", TYPE_TEXT)))

COMMAND(set, .group = "SCENE", .flags = COMMAND_ASSIGNS | COMMAND_CHANGES | COMMAND_ANYTIME,
        .completes = COMPLETES_VALUES,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED),
                  PLACE("VALUE", TYPE_REST, .flags = ARG_REQUIRED)))

COMMAND(unset, .group = "SCENE", .flags = COMMAND_CHANGES | COMMAND_ANYTIME,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED, .choices = &unset_catalog)))

COMMAND(let, .group = "SCENE", .flags = COMMAND_CHANGES | COMMAND_ANYTIME,
        .completes = COMPLETES_VALUES,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED),
                  PLACE("VALUE", TYPE_REST, .flags = ARG_REQUIRED)))
