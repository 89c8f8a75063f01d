/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Statements that are left to offer of a command, after those that the student has typed. */
#define _GNU_SOURCE /* memmem */
#include "modules/report/lesson.h"
#include <hooke/base/statement.h>
#include <hooke/data.h>
#include <hooke/session/log.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* [s] of a damped recording that the damped simulation is compared with, as the sheet has it */
static const double compared_span = 20;

/* Stands for a mass that nobody but the student knows. */
#define UNKNOWN_MASS "MASS"

/* Returns true if the recording in use is none that the lesson has generated. */
static bool is_own_recording(const struct session *session)
{
    const struct lesson *lesson = session_lesson(session);
    const struct recording *recording = session_recording(session);
    char bare[64], disk[64];
    if (!recording || !lesson)
        return false;
    snprintf(bare, sizeof bare, "bare-%ld.txt", lesson->seed);
    snprintf(disk, sizeof disk, "disk-%ld.txt", lesson->seed);
    const struct text file = text_last_component(text_of(recording->path));
    return !text_is(file, bare) && !text_is(file, disk);
}

void lesson_readings(const struct recording *recording, struct buffer *output)
{
    const double t_begin = recording ? recording->window[0] : 0,
                 gap = (recording ? recording->window[1] - t_begin : 120) / 6;
    double unit = 1; /* [s] whole seconds where readings are far apart, as one would read them */
    int decimals = 0;
    for (; gap < 4 * unit && decimals < 2; decimals++)
        unit /= 10;
    for (int i = 0; i < 6; i++)
        buffer_format(output, "%s%.*f", i ? "," : "", decimals,
                      fmax(floor((t_begin + (i + 0.25) * gap) / unit), ceil(t_begin / unit)) *
                          unit);
}

void lesson_expand(const struct session *session, struct text text, bool is_command,
                   struct buffer *output)
{
    const struct recording *recording = session_recording(session);
    const double t_begin = recording ? recording->window[0] : 0;
    const double t_end = fmin(t_begin + compared_span, recording ? recording->window[1] : 120);
    const bool is_own = is_command && is_own_recording(session);
    const long seed = session_lesson(session)->seed;
    static const struct text names[] = {
        {"$bare_mass", 10}, {"$disk_mass", 10}, {"$readings", 9}, {"$window", 7}, {"$span", 5}};
    while (text.len > 0) {
        size_t i = 0;
        while (i < COUNT_OF(names) && !text_starts(text, names[i]))
            i++;
        if (i == COUNT_OF(names))
            buffer_char(output, text.data[0]);
        else if (i < 2 && is_own)
            buffer_put(output, TEXT(UNKNOWN_MASS));
        else if (i < 2)
            buffer_format(output, "%.1f", lesson_mass(seed, i == 1));
        else if (i == 2)
            lesson_readings(recording, output);
        else if (i == 3)
            buffer_format(output, "%g:%g", t_begin, t_end);
        else
            buffer_format(output, "%g", t_end - t_begin);
        const size_t len = i < COUNT_OF(names) ? names[i].len : 1;
        text = (struct text){text.data + len, text.len - len};
    }
}

/* Returns the name that a statement gives a value, or nothing. */
static struct text assigned_name(struct text statement)
{
    const struct text name = peek_name(statement);
    const struct text value = text_behind(statement, name.len);
    const bool assigns =
        name.len > 0 && text_starts(value, TEXT("=")) && !text_starts(value, TEXT("=="));
    return assigns ? name : TEXT("");
}

/* Finds the last line of the script that gives `name` a value. */
static bool find_assignment(struct text script, struct text name, struct text *found)
{
    struct text line;
    bool is_found = false;
    while (script.len > 0 && text_split(&script, '\n', &line))
        if (text_equal(assigned_name(line), name)) {
            *found = line;
            is_found = true;
        }
    return is_found;
}

/* Appends the last statement since that place of the log that gives `name` a value. */
static bool put_typed(const struct session *session, size_t first, struct text name,
                      struct buffer *output)
{
    struct buffer script = {0};
    struct text found = TEXT("");
    history_put(session, first, HISTORY_RECORD, &script);
    const bool is_found = find_assignment(buffer_text(&script), name, &found);
    buffer_put(output, found);
    buffer_free(&script);
    return is_found;
}

static bool is_typed(const struct session *session, size_t first, struct text name)
{
    struct buffer ignored = {0};
    const bool typed = put_typed(session, first, name, &ignored);
    buffer_free(&ignored);
    return typed;
}

/* Returns true if the script has this statement, and gives nothing a value after it. */
static bool is_done(struct text script, struct text statement)
{
    struct text line;
    bool done = false;
    while (script.len > 0 && text_split(&script, '\n', &line)) {
        if (assigned_name(line).len > 0)
            done = false;
        done |= text_equal(line, statement);
    }
    return done;
}

static bool has_command(struct text script, const char *command)
{
    struct text line;
    while (script.len > 0 && text_split(&script, '\n', &line))
        if (text_is(peek_word(line, ""), command))
            return true;
    return false;
}

/* Parameters that `adopt` gives other values. */
static const char *const adopted_names[] = {"k", "gamma", "y0", "v0"};

static bool is_adopted(struct text name)
{
    for (size_t i = 0; i < COUNT_OF(adopted_names); i++)
        if (text_is(name, adopted_names[i]))
            return true;
    return false;
}

size_t lesson_set_since(const struct session *session, struct text name)
{
    const struct lesson *lesson = session_lesson(session);
    struct lesson_step step;
    struct text statement;
    struct error ignored;
    for (int i = lesson->step - 1; i >= 0 && lesson_step(lesson, i, &step); i--)
        while (step.command.len > 0 && next_statement(&step.command, &statement, &ignored))
            if (text_equal(assigned_name(statement), name) ||
                (is_adopted(name) && text_is(peek_word(statement, ""), "adopt")))
                return lesson->passed[i];
    return 0;
}

static void put_statement(struct text statement, struct buffer *output)
{
    if (output->len > 0)
        buffer_put(output, TEXT("; "));
    buffer_put(output, statement);
}

/* Sets again what was typed and what `adopt` has replaced. */
static void put_typed_again(const struct session *session,
                            size_t (*typed_since)(const struct session *session, struct text name),
                            struct buffer *output)
{
    for (size_t i = 0; i < COUNT_OF(adopted_names); i++) {
        const struct text name = text_of(adopted_names[i]);
        struct buffer typed = {0};
        if (put_typed(session, typed_since(session, name), name, &typed))
            put_statement(buffer_text(&typed), output);
        buffer_free(&typed);
    }
}

void lesson_remaining(const struct session *session, struct text command, size_t begun,
                      size_t (*typed_since)(const struct session *session, struct text name),
                      struct buffer *output)
{
    struct buffer script = {0};
    struct text statement;
    struct error ignored;
    bool is_unknown = false;
    history_put(session, begun, HISTORY_RECORD, &script);
    while (!is_unknown && command.len > 0 && next_statement(&command, &statement, &ignored)) {
        const struct text name = assigned_name(statement);
        const struct text word = peek_word(statement, "");
        const char *step = memmem(statement.data, statement.len, " dt=", 4);
        if (name.len > 0
                ? is_typed(session, typed_since(session, name), name)
                : is_done(buffer_text(&script), statement) ||
                      (text_is(word, "method") && has_command(buffer_text(&script), "method")))
            continue;
        is_unknown = memmem(statement.data, statement.len, UNKNOWN_MASS, 4) != NULL;
        if (step && text_is(word, "method") && is_typed(session, begun, TEXT("dt")))
            statement.len = (size_t)(step - statement.data);
        if (!is_unknown)
            put_statement(statement, output);
        if (text_is(word, "adopt"))
            put_typed_again(session, typed_since, output);
    }
    if (is_unknown) /* the statements before a mass need it, too */
        buffer_clear(output);
    buffer_free(&script);
}
