/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command atol: absolute tolerances of single variables. */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>

#include <stdlib.h>

/* Lists the absolute tolerances that were set. */
static void list_atol(const struct session *session, struct reply *reply)
{
    struct buffer text = {0};
    atol_script(&session->setup.scene, "\n", &text);
    if (text.len > 0)
        text.len--;
    else
        buffer_put(
            &text,
            TEXT("no absolute tolerances: errors are relative to the size of each variable (tol)"));
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
}

/* Sets the error that name is not a variable of the scene. Returns false. */
static bool unknown_variable(const struct model *model, struct text name, struct error *error)
{
    struct buffer names = {0};
    for (int i = 0; i < model->n; i++)
        buffer_format(&names, "%s%s", i > 0 ? ", " : "", model->variable[i].name);
    error_at(error, name, "'%.*s' is not a variable of this scene",
             (int)(name.len < 64 ? name.len : 64), name.data);
    if (model->n == 0)
        error_hint(error, "'var NAME = VALUE' makes one");
    else
        error_hint(error, "its variables: %.100s", buffer_view(&names));
    buffer_free(&names);
    return false;
}

/* Sets or removes the tolerance of variable i and replies with it. Returns false with the error
 * set. */
static bool set_atol(struct session *session, int i, struct parser *parser, struct reply *reply,
                     struct error *error)
{
    struct scene *scene = &session->setup.scene;
    const struct variable *variable = &scene->model->variable[i];
    struct item item = {0};
    if (!text_is(text_trim(parser->rest), "off")) {
        if (!read_value(parser, variable->name, variable->quantity, &item, error))
            return false;
        if (!(item.value.value > 0))
            return error_at(error, item.text, "atol must be a number above 0, or off");
    }
    scene_set_atol(scene, i, item.value.value);
    session_changed(session);
    struct buffer *text = reply_buffer(reply);
    atol_describe(scene, i, text);
    if (!(session->setup.method->flags & METHOD_ADAPTIVE))
        buffer_format(text, " (only adaptive methods use it; %s has fixed steps)",
                      session->setup.method->row.name);
    return true;
}

/* Lists, sets or removes absolute tolerances. */
HANDLER(atol)
{
    const struct argument_value *name = argument_value(args, "NAME"),
                                *value = argument_value(args, "VALUE");
    struct scene *scene = &session->setup.scene;
    if (!name->count) {
        list_atol(session, reply);
        return true;
    }
    struct text wanted = name->item->text;
    if (text_is(wanted, "off") && !value->count) {
        for (int i = 0; i < scene->model->n; i++)
            scene_set_atol(scene, i, 0);
        session_changed(session);
        list_atol(session, reply);
        return true;
    }
    if (!value->count)
        return error_at(error, wanted, "atol %.*s needs a value, or off",
                        (int)(wanted.len < 64 ? wanted.len : 64), wanted.data);
    const struct text rest = value->item->text;
    wanted.len += rest.len > 0 && rest.data == wanted.data + wanted.len && rest.data[0] == '\'';
    const int i = model_variable(scene->model, wanted);
    struct parser parser = value_parser(session, args);
    return i < 0 ? unknown_variable(scene->model, wanted, error)
                 : set_atol(session, i, &parser, reply, error);
}
#endif

COMMAND(atol, .group = "METHOD", .flags = COMMAND_CHANGES, .completes = COMPLETES_ATOL,
        ARGUMENTS(PLACE("NAME", TYPE_NAME), PLACE("VALUE", TYPE_REST)))
