/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands of a lesson, step by step (lab, check, hint, skip, again). */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>
#include "modules/report/lesson.h"

#include <stdlib.h>
#include <string.h>

/* ---- taking part ---- */

static void say_step(const struct session *session, struct reply *reply)
{
    const struct lesson *lesson = session_lesson(session);
    struct lesson_step step;
    struct buffer text = {0};
    int width, height;
    session_size(session, &width, &height);
    const bool there = lesson_step(lesson, lesson->step, &step);
    if (!there) {
        reply_line(reply, "the lesson is over: 'lab seed=N' gives other numbers");
    } else {
        buffer_format(&text, "%d/%d: ", lesson->step + 1, lesson->steps);
        buffer_put(&text, step.says);
        reply_paragraph(reply, buffer_text(&text), width);
        reply_line(reply, "  type: %.*s", (int)step.command.len, step.command.data);
        if (!step.done)
            reply_line(reply, "  then: check VALUE   (or hint, skip)");
    }
    reply_begin(reply, "lesson");
    reply_int(reply, "step", lesson->step + 1);
    reply_int(reply, "steps", lesson->steps);
    reply_string(reply, "state", there ? "waits" : "over");
    reply_end(reply);
    buffer_free(&text);
}

static bool go_to(struct session *session, int step, struct reply *reply, struct error *error)
{
    struct lesson *lesson = session_lesson(session);
    lesson->step = step;
    lesson->begun = session->history.count;
    session_changed(session);
    if (!lesson_files(session, error))
        return false;
    say_step(session, reply);
    return true;
}

void lesson_label(const struct session *session, struct buffer *text)
{
    const struct lesson *lesson = session_lesson(session);
    if (lesson && lesson->step < lesson->steps)
        buffer_format(text, "lab %d/%d", lesson->step + 1, lesson->steps);
}

void lesson_follow(struct session *session, struct reply *reply)
{
    struct error error = {0};
    struct lesson_step step;
    const struct lesson *lesson = session_lesson(session);
    if (lesson && lesson_step(lesson, lesson->step, &step) && step.done &&
        lesson_done(session, step.wanted) && !go_to(session, lesson->step + 1, reply, &error))
        reply_warning(reply, "%s", error.text);
}

static bool need_lesson(const struct session *session, struct error *error)
{
    struct lesson_step step;
    if (session_lesson(session) &&
        lesson_step(session_lesson(session), session_lesson(session)->step, &step))
        return true;
    error_set(error, ERROR_COMMAND, "no lesson waits");
    return error_hint(error, "lab begins one");
}

HANDLER(lab)
{
    const struct argument_value *name = argument_value(args, "NAME"),
                                *seed = argument_value(args, "seed");
    if (name->count && text_is(name->item->text, "off")) {
        struct lesson *lesson = session_lesson(session);
        if (lesson)
            lesson_free(lesson);
        session_changed(session);
        reply_line(reply, "no lesson");
        return true;
    }
    const long number = seed->count ? (long)seed->item->value.value : 1;
    return lesson_open(session, name->count ? name->item->text : TEXT("lab"), number, args,
                       error) &&
           go_to(session, 0, reply, error);
}

/* A bare number is in the SI unit. */
static bool fits_unit(const struct item *item, enum quantity quantity)
{
    return item->quantity == QUANTITY_OTHER || item->quantity == QUANTITY_NUMBER ||
           quantity == QUANTITY_OTHER || item->quantity == quantity;
}

/* Nothing of the value that is wanted is told. */
HANDLER(check)
{
    const struct argument_value *value = argument_value(args, "VALUE");
    struct lesson_step step;
    struct named_value found = {.error_floor = 0};
    if (!need_lesson(session, error) ||
        !lesson_step(session_lesson(session), session_lesson(session)->step, &step))
        return false;
    if (step.done ? !lesson_done(session, step.wanted) : !lesson_found(session, &step, &found)) {
        error_set(error, ERROR_COMMAND, "not yet: that was not done since the step began");
        return error_hint(error, "type: %.*s", (int)step.command.len, step.command.data);
    }
    if (!step.done && !value->count)
        return error_set(error, ERROR_COMMAND, "check takes the value that you read");
    const double u = isfinite(found.uncertainty) ? 3 * found.uncertainty : 0;
    const double room = fmax(u, LESSON_DIGITS * fabs(found.value));
    if (!step.done && (!fits_unit(value->item, found.quantity) ||
                       !(fabs(value->item->value.value - found.value) <= room))) {
        reply_line(reply, "not that: it is farther off than the uncertainty ('hint' helps, 'again' "
                          "repeats what is to be done)");
        reply_begin(reply, "lesson");
        reply_int(reply, "step", session_lesson(session)->step + 1);
        reply_int(reply, "steps", session_lesson(session)->steps);
        reply_string(reply, "state", "wrong");
        reply_end(reply);
        return true;
    }
    reply_line(reply, "right");
    return go_to(session, session_lesson(session)->step + 1, reply, error);
}

HANDLER(hint)
{
    UNUSED(args);
    struct lesson_step step;
    if (!need_lesson(session, error) ||
        !lesson_step(session_lesson(session), session_lesson(session)->step, &step))
        return false;
    const struct text hint = step.hint.len ? step.hint : step.command;
    reply_line(reply, "%s%.*s", step.hint.len ? "" : "type: ", (int)hint.len, hint.data);
    return true;
}

HANDLER(skip)
{
    UNUSED(args);
    return need_lesson(session, error) &&
           go_to(session, session_lesson(session)->step + 1, reply, error);
}

HANDLER(again)
{
    UNUSED(args);
    return need_lesson(session, error) &&
           go_to(session, session_lesson(session)->step, reply, error);
}
#endif

COMMAND(lab, .group = "SESSION", .flags = COMMAND_UNRECORDED,
        ARGUMENTS(PLACE("NAME", TYPE_FILE), KEY("seed", TYPE_INTEGER)))

COMMAND(check, .group = "SESSION", .flags = COMMAND_UNRECORDED,
        ARGUMENTS(PLACE("VALUE", TYPE_EXPR)))

COMMAND(hint, .group = "SESSION", .flags = COMMAND_UNRECORDED)

COMMAND(skip, .group = "SESSION", .flags = COMMAND_UNRECORDED)

COMMAND(again, .group = "SESSION", .flags = COMMAND_UNRECORDED)
