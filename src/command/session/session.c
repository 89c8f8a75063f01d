/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands source, record, history, timing, clear and quit. */
#include <hooke/run/timing.h>

#ifndef COMMAND_ROWS
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/command/handler.h>
#include <hooke/session/log.h>

/* Executes the lines of a file. */
HANDLER(source)
{
    char *path = script_path(args->where, argument_value(args, "FILE")->item->text, args->arena);
    static const struct source prompt = {.name = NULL};
    if (!path)
        return error_memory(error);
    /* Whatever goes wrong inside was reported where it happened; the error stays without a code. */
    return script_file(session, path, args->where ? args->where : &prompt, reply);
}

/* Appends executed commands to a file from now on, or ends that. */
HANDLER(record)
{
    const struct text name = argument_value(args, "FILE")->item->text;
    char *path = arena_text(args->arena, name);
    if (!path)
        return error_memory(error);
    if (text_is(name, "off")) {
        if (session->transcript.fd < 0)
            return error_set(error, ERROR_COMMAND, "no commands are being recorded");
        reply_line(reply, "commands are no longer written to %s", session->transcript.path);
        return record_close(session, error);
    }
    if (text_is(name, "auto") || text_is(name, "all") || text_is(name, "every")) {
        error_at(error, name, "'%s' is a value of 'set record', not a file name", path);
        return error_hint(error,
                          "'set record %s' sets how much of a run is kept; 'record ./%s' "
                          "writes commands to a file of that name",
                          path, path);
    }
    if (!record_open(session, path, error)) {
        error->where = name;
        return false;
    }
    struct buffer shown = {0};
    safe_text(&shown, name, false);
    reply_line(reply, "commands are appended to %s", buffer_view(&shown));
    buffer_free(&shown);
    return true;
}

/* Returns true if `rest` contains `wanted`; an empty text is contained in every one. */
static bool text_contains(struct text rest, struct text wanted)
{
    for (; rest.len >= wanted.len; rest = text_after(rest, 1)) {
        if (text_starts(rest, wanted))
            return true;
        if (rest.len == 0)
            break;
    }
    return false;
}

/* Lists the last typed lines, or those that contain a text. */
HANDLER(history)
{
    const struct argument_value *what = argument_value(args, "WHAT");
    const struct text word = what->count ? what->item->text : TEXT("");
    const bool search = word.len > 0 && word.data[0] == '/';
    double max = 50;
    if (word.len > 0 && !search && (real_parse(word, &max) != REAL_OK || max < 1)) {
        error_at(error, word, "'history' takes a number of lines, or /TEXT");
        return error_hint(error, "for example history 20, or history /run");
    }
    const struct history *log = &session->history;
    int number = log->lines_gone;
    for (size_t i = log->first; i < log->count; i++) {
        const struct entry *entry = history_entry(session, i);
        const struct text line = text_trim(history_text(session, entry));
        if (!history_is_typed(session, entry))
            continue;
        number++;
        if (search ? !text_contains(line, text_after(word, 1)) : number <= log->lines - max)
            continue;
        struct buffer text = {0};
        buffer_format(&text, "%5d  ", number);
        safe_text(&text, line, false);
        reply_text(reply, buffer_text(&text));
        buffer_free(&text);
    }
    return true;
}

/* Sets or shows how carefully studies measure computing times. */
HANDLER(timing)
{
    UNUSED(error);
    const struct argument_value *how = argument_value(args, "HOW");
    if (how->count) {
        session->setup.settings.timing = how->item->index;
        session_changed(session);
    }
    const struct row *row = catalog_row(&timing_catalog, (size_t)session->setup.settings.timing);
    reply_line(reply, "timing %s: %s", row->name, row->brief);
    return true;
}

/* Clears the screen of the front end. */
HANDLER(clear)
{
    UNUSED(args);
    UNUSED(reply);
    UNUSED(error);
    if (session->front.clear)
        session->front.clear(session->front.context);
    return true;
}

/* Leaves the program after this line. */
HANDLER(quit)
{
    UNUSED(args);
    UNUSED(reply);
    UNUSED(error);
    session->execution.quit = true;
    return true;
}
#endif

COMMAND(source, .group = "SESSION", .flags = COMMAND_NESTS,
        ARGUMENTS(PLACE("FILE", TYPE_FILE, .flags = ARG_REQUIRED)))

COMMAND(record, .group = "SESSION", .flags = COMMAND_UNRECORDED | COMMAND_ANYTIME,
        ARGUMENTS(PLACE("FILE", TYPE_FILE, .flags = ARG_REQUIRED)))

COMMAND(history, .group = "SESSION", .flags = COMMAND_UNRECORDED | COMMAND_ANYTIME,
        ARGUMENTS(PLACE("WHAT", TYPE_TEXT)))

COMMAND(timing, .group = "SESSION", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("HOW", TYPE_CHOICE, .choices = &timing_catalog)))

COMMAND(clear, .group = "SESSION", .flags = COMMAND_UNRECORDED | COMMAND_ANYTIME)

COMMAND(quit, .row.alias = "q exit", .group = "SESSION",
        .flags = COMMAND_UNRECORDED | COMMAND_ANYTIME)
