/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands that type scenes, line by line: var, param, NAME' = EXPR (equation), force, potential,
 * observe. */
#ifndef COMMAND_ROWS
#include <hooke/base/statement.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>

#include <stdio.h>
#include <string.h>

/* Skips the "=" that has to come first. Returns false with the error set if it is missing. */
static bool skip_equals(struct text *rest, const char *usage, struct error *error)
{
    text_skip_blanks(rest);
    if (rest->len == 0 || rest->data[0] != '=') {
        error_at(error, (struct text){rest->data, rest->len > 0}, "'=' is missing");
        return error_usage(error, usage);
    }
    *rest = text_behind(*rest, 1);
    return true;
}

/* ---- lines of a scene ---- */

/* Returns true unless the name would hide a setting; then sets an error. */
static bool name_is_free(struct text name, struct error *error)
{
    if (!catalog_find(&setting_catalog, name))
        return true;
    error_at(error, name, "'%.*s' cannot be used: it is the name of a setting", (int)name.len,
             name.data);
    return error_hint(error, "choose another name, as %.*s_1", (int)name.len, name.data);
}

/* Returns true if the scene can have a typed parameter of that name. The start-up scene, if nobody
 * has changed it, gives up its parameters; other scenes keep theirs, which sets an error. */
static bool name_makes_room(const struct session *session, struct text name, struct text value,
                            struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    struct scene fresh;
    size_t i = 0;
    if (!typed_base_has(scene->model, name))
        return true;
    scene_init(&fresh, NULL);
    while (i < scene_params(&fresh)->count && !scene->chosen[i])
        i++;
    if (scene->preset == fresh.preset && i == scene_params(&fresh)->count &&
        session->runs.count == 0 && session->recordings == 0)
        return true;
    error_at(error, name, "%s already has '%.*s'", scene->preset->row.name, (int)name.len,
             name.data);
    return error_hint(error, "'%.*s = %.*s' sets it; 'scene new' begins an empty scene",
                      (int)name.len, name.data, (int)value.len, value.data);
}

/* Makes the typed model the scene's. begins means that it is a new scene, which drops the events of
 * the previous one. Returns false with the error set and the scene unchanged. */
static bool use_model(struct session *session, const struct model *model, bool begins,
                      struct reply *reply, struct error *error)
{
    struct setup *setup = &session->setup;
    const struct scene previous = setup->scene;
    scene_remodel(&setup->scene, model);
    if (!keep_own_scene(session, error)) {
        setup->scene = previous;
        return false;
    }
    settings_of_scene(&setup->settings, setup->scene.preset);
    if (begins && model->n == 0)
        reply_line(reply, "a new scene begins; var NAME = VALUE makes a variable");
    if (begins && setup->events) {
        setup->events = NULL;
        reply_line(reply, "the events of the previous scene were removed");
    }
    session_changed(session);
    return true;
}

/* Returns true unless the line is a potential that is not that of the forces; then sets an error.
 * If the scene is not complete yet, that is tested later. */
static bool potential_fits(const struct scene *scene, const struct model *model,
                           const struct typed_line *line, struct error *error)
{
    struct scene candidate = *scene;
    struct system system;
    struct error why = {0}, ignored;
    scene_remodel(&candidate, model);
    if (line->kind != TYPED_POTENTIAL || scene_bind(&candidate, &system, &why) ||
        !scene_bind(scene, &system, &ignored))
        return true;
    *error = why;
    error->where = line->expr;
    return false;
}

/* Adds a line to the scene and replies with it; uncertainty is that of its value, or 0 if there is
 * none. Returns false with the error set. */
static bool add_line(struct session *session, const struct typed_line *line, double uncertainty,
                     struct reply *reply, struct error *error)
{
    const struct model *previous = session->setup.scene.model, *model;
    struct buffer text = {0};
    if (!(model = typed_add(session->definitions.models, previous, line, error)) ||
        !potential_fits(&session->setup.scene, model, line, error) ||
        !use_model(session, model, !typed_base(model) && typed_base(previous), reply, error))
        return false;
    typed_describe(line, &text);
    if (uncertainty > 0) {
        text.len = (size_t)((const char *)memchr(text.data, '=', text.len) - text.data) + 2;
        buffer_measured(&text, (struct measured){line->value, uncertainty}, line->quantity,
                        session->setup.settings.digits);
    }
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}

/* Returns true if the events of the next run can still be compiled. */
static bool events_know(struct session *session, struct arena *arena, struct error *error)
{
    const struct names names = {.session = session, .expects_run = true, .saved_only = true};
    const struct expr_scope scope = names_scope(&names);
    const struct event *event;
    int count;
    return events_compile(session->setup.events, &scope, arena, &event, &count, error);
}

/* Removes a line, unless an event uses its name; `what` describes it in the reply if it has no
 * name. Returns false with the error set. */
static bool remove_line(struct session *session, const struct arguments *args, enum typed_kind kind,
                        struct text name, const char *what, struct reply *reply,
                        struct error *error)
{
    const struct scene previous = session->setup.scene;
    const struct model *model =
        typed_remove(session->definitions.models, previous.model, kind, name, error);
    if (!model || !use_model(session, model, false, reply, error))
        return false;
    if (name.len > 0 && kind != TYPED_FORCE && !events_know(session, args->arena, error)) {
        const struct error why = *error;
        struct error ignored;
        use_model(session, previous.model, false, reply, &ignored);
        session->setup.scene = previous;
        error_at(error, name, "%.*s is used by an event", (int)name.len, name.data);
        return error_hint(error, "%s", why.hint);
    }
    const struct text removed = what ? text_of(what) : name;
    reply_line(reply, "%.*s is removed", (int)removed.len, removed.data);
    return true;
}

/* Returns the index of the parameter that such a line makes: its own, or the initial value x0 of x,
 * x1_0 of x1, vy0 of y'. */
static int param_of(const struct scene *scene, const struct typed_line *line)
{
    struct text name = line->name;
    char own[LIMIT_NAME + 8];
    const bool velocity = name.data[name.len - 1] == '\'';
    name.len -= velocity;
    const char last = name.data[name.len - 1];
    const char *end;
    if (line->kind == TYPED_PARAM)
        end = "";
    else
        end = last >= '0' && last <= '9' ? "_0" : "0";
    snprintf(own, sizeof own, "%s%.*s%s", velocity ? "v" : "", (int)name.len, name.data, end);
    return scene_param(scene, own);
}

/* Reads NAME = VALUE, or NAME' = VALUE of a variable, and adds the line. Returns false with the
 * error set. */
static bool add_value(struct session *session, const struct arguments *args, enum typed_kind kind,
                      const char *usage, struct reply *reply, struct error *error)
{
    struct typed_line line = {.kind = kind, .name = argument_value(args, "NAME")->item->text};
    struct text rest = argument_value(args, "= VALUE")->item->text;
    struct item item = {.quantity = QUANTITY_OTHER};
    if (kind == TYPED_VAR && rest.data[0] == '\'') {
        line.name.len++;
        rest = text_behind(rest, 1);
    }
    if (text_is(rest, "off"))
        return remove_line(session, args, kind, line.name, NULL, reply, error);
    if (!name_is_free(line.name, error) || !skip_equals(&rest, usage, error))
        return false;
    struct parser parser = {session, args->scope, args->arena, rest};
    if (!parse_value(&parser, kind == TYPED_PARAM ? "the parameter" : "the initial value",
                     QUANTITY_OTHER, &item, error) ||
        !refuse_rest(&parser, &item, error))
        return false;
    if (kind == TYPED_PARAM && !name_makes_room(session, line.name, item.text, error))
        return false;
    line.value = item.value.value;
    line.quantity = item.quantity == QUANTITY_OTHER ? QUANTITY_NUMBER : item.quantity;
    if (!add_line(session, &line, item.value.uncertainty, reply, error))
        return false;
    /* A value that was set before the line was typed again is no longer valid. */
    const int index = param_of(&session->setup.scene, &line);
    if (index >= 0)
        scene_unset(&session->setup.scene, index);
    return index < 0 || item.value.uncertainty == 0 ||
           scene_set(&session->setup.scene, index, item.value, error);
}

HANDLER(var)
{
    return add_value(session, args, TYPED_VAR, "var NAME = VALUE or var NAME off", reply, error);
}

HANDLER(param)
{
    return add_value(session, args, TYPED_PARAM, "param NAME = VALUE or param NAME off", reply,
                     error);
}

/* Executes y' = EXPR in the commands of an event: sets the velocity, by the handler of change. */
static bool set_velocity(struct session *session, const struct arguments *args,
                         const struct typed_line *line, struct reply *reply, struct error *error)
{
    const struct command *change = command_with(COMMAND_JUMPS);
    const char *end = line->expr.data + line->expr.len;
    struct item name = {.text = line->name},
                rest = {.text = {.data = line->name.data + line->name.len}};
    rest.text.len = (size_t)(end - rest.text.data);
    if (line->order != 1)
        return error_at(error, line->name, "an event cannot change the equation of %.*s",
                        (int)line->name.len, line->name.data);
    struct arguments changed = *args;
    changed.command = change;
    changed.value[0] = (struct argument_value){1, &name, name.text};
    changed.value[1] = (struct argument_value){1, &rest, rest.text};
    return change->handler(session, &changed, reply, error);
}

/* Adds an equation of first or second order; in an event, sets a velocity. */
HANDLER(equation)
{
    struct text rest = argument_value(args, "NAME' = EXPR")->item->text;
    struct typed_line line = {.kind = TYPED_EQUATION, .name = peek_name(rest)};
    rest = text_after(rest, line.name.len);
    while (rest.len > 0 && rest.data[0] == '\'') {
        line.order++;
        rest = text_after(rest, 1);
    }
    if (line.name.len == 0 || line.order < 1 || line.order > 2) {
        error_at(error, peek_word(argument_value(args, "NAME' = EXPR")->item->text, "="),
                 "an equation begins with NAME' or NAME''");
        return error_hint(error, "for example x' = y (first order) or y'' = -k*y (second order)");
    }
    if (!skip_equals(&rest, "NAME' = EXPR", error))
        return false;
    line.expr = rest;
    if (session->execution.reacting)
        return set_velocity(session, args, &line, reply, error);
    return add_line(session, &line, 0, reply, error);
}

/* Returns NAME of NAME = EXPR and moves *rest behind the '='; an empty text for EXPR alone. */
static struct text read_left_side(struct text *rest)
{
    const struct text name = peek_name(*rest), right = text_behind(*rest, name.len);
    if (name.len == 0 || right.len == 0 || right.data[0] != '=')
        return (struct text){rest->data, 0};
    *rest = text_behind(right, 1);
    return name;
}

/* Adds or removes a force, of one variable if it is named. */
HANDLER(force)
{
    struct text rest = argument_value(args, "EXPR|off")->item->text;
    struct text remainder = text_behind(rest, peek_name(rest).len);
    size_t primes = 0;
    while (primes < remainder.len && remainder.data[primes] == '\'')
        primes++;
    if (primes > 0 && text_starts(text_behind(remainder, primes), TEXT("="))) {
        error_at(error, (struct text){rest.data, (size_t)(remainder.data - rest.data) + primes},
                 "a force is an expression, not an equation");
        return error_hint(error,
                          "'force x = EXPR' adds to x''; to define x'' type only x'' = EXPR");
    }
    const struct text name = read_left_side(&rest);
    const struct typed_line line = {.kind = TYPED_FORCE, .name = name, .expr = rest};
    if (peek_name(rest).len > 0 &&
        text_is(text_behind(rest, peek_name(rest).len), "off")) /* force x off */
        return remove_line(session, args, TYPED_FORCE, peek_name(rest), "the force", reply, error);
    return text_is(rest, "off")
               ? remove_line(session, args, TYPED_FORCE, line.name, "the force", reply, error)
               : add_line(session, &line, 0, reply, error);
}

/* Adds or removes the potential of the forces. */
HANDLER(potential)
{
    const struct text rest = argument_value(args, "EXPR|off")->item->text;
    const struct typed_line line = {.kind = TYPED_POTENTIAL, .expr = rest};
    return text_is(rest, "off") ? remove_line(session, args, TYPED_POTENTIAL, TEXT(""),
                                              "the potential", reply, error)
                                : add_line(session, &line, 0, reply, error);
}

/* Adds or removes a quantity that runs record beside the state. */
HANDLER(observe)
{
    struct typed_line line = {.kind = TYPED_OBSERVE,
                              .name = argument_value(args, "NAME")->item->text};
    struct text rest = argument_value(args, "= EXPR")->item->text;
    if (text_is(rest, "off"))
        return remove_line(session, args, TYPED_OBSERVE, line.name, NULL, reply, error);
    if (!name_is_free(line.name, error) || !skip_equals(&rest, "observe NAME = EXPR", error))
        return false;
    line.expr = rest;
    return add_line(session, &line, 0, reply, error);
}
#endif

COMMAND(var, .group = "EQUATIONS", .flags = COMMAND_CHANGES, .completes = COMPLETES_VARIABLE,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED),
                  PLACE("= VALUE", TYPE_FORMULA, .flags = ARG_REQUIRED)))

COMMAND(param, .group = "EQUATIONS", .flags = COMMAND_CHANGES, .completes = COMPLETES_PARAMETER,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED),
                  PLACE("= VALUE", TYPE_FORMULA, .flags = ARG_REQUIRED)))

COMMAND(equation, .group = "EQUATIONS",
        .flags = COMMAND_EQUATES | COMMAND_IN_EVENTS | COMMAND_CHANGES,
        .completes = COMPLETES_EQUATION,
        ARGUMENTS(PLACE("NAME' = EXPR", TYPE_FORMULA, .flags = ARG_REQUIRED)))

COMMAND(force, .group = "EQUATIONS", .flags = COMMAND_CHANGES, .completes = COMPLETES_FORCE,
        ARGUMENTS(PLACE("EXPR|off", TYPE_FORMULA, .flags = ARG_REQUIRED)))

COMMAND(potential, .group = "EQUATIONS", .flags = COMMAND_CHANGES, .completes = COMPLETES_POTENTIAL,
        ARGUMENTS(PLACE("EXPR|off", TYPE_FORMULA, .flags = ARG_REQUIRED)))

COMMAND(observe, .group = "EQUATIONS", .flags = COMMAND_CHANGES, .completes = COMPLETES_OBSERVED,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED),
                  PLACE("= EXPR", TYPE_FORMULA, .flags = ARG_REQUIRED)))
