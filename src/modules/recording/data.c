/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command data: lists, chooses, changes and cleans recordings. */
#ifndef COMMAND_ROWS
#include "modules/recording/known/known.h"
#include "modules/recording/recording_text.h"
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <stdio.h>

/* Tells the window and the zero of a recording. */
static void reply_window(const struct recording *recording, struct reply *reply)
{
    const enum quantity quantity = recording->column[recording->value].quantity;
    reply_line(reply, "%s: window %.6g..%.6g s, zero %s", recording->name, recording->window[0],
               recording->window[1], SHOWN_VALUE(recording->zero, quantity, 6));
}

/* Adds all recordings to the reply; the current one is marked by '*'. */
static void list_recordings(const struct session *session, struct reply *reply)
{
    if (session->recordings == 0)
        reply_line(reply, "no recordings");
    for (int i = 0; i < session->recordings; i++) {
        const struct recording *recording = session->recording[i]->recording;
        const struct column *value = &recording->column[recording->value];
        reply_line(reply, "%c %-16s %s [%s], %zu rows, %.6g..%.6g s, window %.6g..%.6g s",
                   i == session->current_recording ? '*' : ' ', recording->name, value->name,
                   value->unit, recording->rows, recording->t[0], recording->t[recording->rows - 1],
                   recording->window[0], recording->window[1]);
        reply_recording(recording, reply);
    }
}

/* Sets the zero of a recording, which is subtracted from its values. Returns false with the error
 * if the stated unit is of another quantity. */
static bool set_zero(struct session *session, struct recording *recording,
                     const struct arguments *args, struct error *error)
{
    const struct item *item = argument_value(args, "zero")->item;
    const enum quantity quantity = recording->column[recording->value].quantity;
    if (item->unit && quantity != QUANTITY_OTHER && item->quantity != quantity)
        return error_at(error, item->text,
                        "zero needs %s %s, the quantity of the recording, got '%.*s' (%s)",
                        quantity_article(quantity), quantity_name(quantity), (int)item->text.len,
                        item->text.data, quantity_name(item->quantity));
    recording->zero = item->value.value;
    session_changed(session);
    return true;
}

/* Sets the window of a recording; an open side extends to its end. Returns false with the error. */
static bool set_window(struct recording *recording, const struct argument_value *window,
                       struct error *error)
{
    const double *range = window->item->range;
    const double t_begin = isnan(range[0]) ? recording->t[0] : range[0];
    const double t_end = isnan(range[1]) ? recording->t[recording->rows - 1] : range[1];
    if (recording_window(recording, t_begin, t_end, error))
        return true;
    error->where = window->item->text;
    return false;
}

/* Lets a recording of positions use the velocities of another recording, instead of differences.
 * Returns false with the error if the quantities do not fit. */
static bool recording_join(const struct session *session, struct recording *recording,
                           const struct argument_value *args, struct error *error)
{
    const struct recording *velocity = session->recording[args->item->index]->recording;
    const enum quantity own = recording->column[recording->value].quantity,
                        its = velocity->column[velocity->value].quantity;
    if (velocity == recording || its != QUANTITY_VELOCITY || own != QUANTITY_LENGTH) {
        error_at(error, args->item->text,
                 "'data join' adds a recording of velocities to the current one of positions");
        return error_hint(
            error, "load position.txt as=y; load velocity.txt as=v; data use y; data join v");
    }
    snprintf(recording->velocity, sizeof recording->velocity, "%s", velocity->name);
    return true;
}

/* Tells the mass and the joined velocities of a recording, if it has them. */
static void reply_joined(const struct recording *recording, struct reply *reply)
{
    if (recording->mass.value > 0)
        reply_line(reply, "%s: mass %s", recording->name,
                   SHOWN_MEASURED(recording->mass, QUANTITY_MASS, 6));
    if (recording->velocity[0])
        reply_line(reply, "%s: velocities from %s", recording->name, recording->velocity);
}

/* Applies the arguments that change a recording. Returns false with the error. */
static bool recording_change(struct session *session, struct recording *recording,
                             const struct arguments *args, struct error *error)
{
    if (has_argument(args, "window") &&
        !set_window(recording, argument_value(args, "window"), error))
        return false;
    if (has_argument(args, "zero") && !set_zero(session, recording, args, error))
        return false;
    if (has_argument(args, "join") &&
        !recording_join(session, recording, argument_value(args, "join"), error))
        return false;
    if (has_argument(args, "mass"))
        recording->mass = argument_value(args, "mass")->item->value;
    if (has_argument(args, "restore"))
        recording_restore(recording);
    session_changed(session);
    return true;
}

static bool no_argument(const struct arguments *args)
{
    for (int i = 0; i < args->command->arguments; i++)
        if (args->value[i].count)
            return false;
    return true;
}

bool recording_list(struct session *session, struct arena *arena, struct reply *reply)
{
    UNUSED(arena);
    list_recordings(session, reply);
    return true;
}

/* Lists recordings, or drops, chooses, cleans or changes one. */
HANDLER(data)
{
    struct recording *recording = session_recording(session);
    const struct argument_value *use = argument_value(args, "use"),
                                *drop = argument_value(args, "drop");
    if (has_argument(args, "apply") && !has_argument(args, "clean"))
        return error_at(error, argument_value(args, "apply")->where,
                        "'apply' must follow 'clean': data clean apply");
    if (drop->count) {
        session_drop_recording(session, drop->item->index);
        list_recordings(session, reply);
        return true;
    }
    if (has_argument(args, "list") || no_argument(args)) {
        list_recordings(session, reply);
        return true;
    }
    if (use->count) {
        session->current_recording = use->item->index;
        session->data_is_latest = true;
        recording = session_recording(session);
    }
    if (!recording) {
        error_set(error, ERROR_COMMAND, "there is no recording yet");
        return error_hint(error, "type: load FILE");
    }
    if (has_argument(args, "clean")) {
        if (!find_faults(recording, NAN, args->arena, error))
            return false;
        if (has_argument(args, "apply")) {
            recording_clean(recording);
            session_changed(session);
        }
        reply_findings(recording, args->arena, reply);
        return true;
    }
    if (!recording_change(session, recording, args, error))
        return false;
    reply_window(recording, reply);
    reply_joined(recording, reply);
    reply_recording(recording, reply);
    return true;
}
#endif

COMMAND(data, .group = "DATA", .flags = COMMAND_CHANGES | COMMAND_TABLES,
        ARGUMENTS(WORD("list", TYPE_NONE, .group = 1), WORD("use", TYPE_RECORDING, .group = 1),
                  WORD("window", TYPE_RANGE, .quantity = QUANTITY_TIME, .group = 1),
                  WORD("zero", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_OTHER,
                       .group = 1),
                  WORD("clean", TYPE_NONE, .group = 1), WORD("apply", TYPE_NONE),
                  WORD("restore", TYPE_NONE, .group = 1),
                  WORD("mass", TYPE_VALUE, .quantity = QUANTITY_MASS, .group = 1),
                  WORD("join", TYPE_RECORDING, .group = 1),
                  WORD("drop", TYPE_RECORDING, .group = 1)))
