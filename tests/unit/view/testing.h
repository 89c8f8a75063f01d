/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session told by commands, and its screen as text. */
#pragma once

#include "cmocka_testing.h"
#include <hooke/view.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char swing[] = "k = 2.1 N/m; gamma = 0.07; y0 = 4.2 cm; method verlet";

static bool take(void *context, struct text text)
{
    log_add(context, text);
    return true;
}

/* Executes a line; what it says goes into the log, as in front of a screen. */
static inline void tell(struct session *session, const char *line)
{
    struct reply reply;
    reply_init(&reply, (struct sink){take, take, &session->log});
    assert_true(command_exec(session, text_of(line), NULL, &reply));
    reply_free(&reply);
}

static inline struct session *begin(bool utf8, const char *line)
{
    struct session *session = session_create(&(struct front){.utf8 = utf8});
    assert_non_null(session);
    if (line)
        tell(session, line);
    return session;
}

/* The run of a session that has one. */
static inline struct run *current(const struct session *session)
{
    assert_true(session->runs.current >= 0);
    return session->runs.slot[session->runs.current]->run;
}

static inline struct prompt_line typed(const char *line)
{
    return (struct prompt_line){
        .prompt = TEXT("hooke> "), .line = text_of(line), .cursor = strlen(line)};
}

static inline struct canvas draw(const struct session *session, int width, int height)
{
    struct canvas canvas;
    struct prompt_line prompt = typed("");
    assert_true(canvas_init(&canvas, width, height));
    assert_true(screen_draw(session, &prompt, &canvas, NULL, NULL));
    return canvas;
}

/* The screen as lines; to be freed. */
static inline char *print(const struct session *session, int width, int height)
{
    struct canvas canvas = draw(session, width, height);
    struct buffer text = {0};
    canvas_print(&canvas, false, &text);
    assert_false(text.failed);
    canvas_free(&canvas);
    return text.data;
}

static inline bool shows(const struct session *session, int width, int height, const char *wanted)
{
    char *text = print(session, width, height);
    bool found = strstr(text, wanted) != NULL;
    free(text);
    return found;
}

#define assert_shows(session, width, height, wanted)                                               \
    do {                                                                                           \
        char *shown_ = print(session, width, height);                                              \
        if (!strstr(shown_, wanted))                                                               \
            fail_msg("no '%s' in\n%s", wanted, shown_);                                            \
        free(shown_);                                                                              \
    } while (0)

#define assert_hides(session, width, height, wanted)                                               \
    do {                                                                                           \
        char *shown_ = print(session, width, height);                                              \
        if (strstr(shown_, wanted))                                                                \
            fail_msg("'%s' in\n%s", wanted, shown_);                                               \
        free(shown_);                                                                              \
    } while (0)

/* Row `row` of the screen without trailing blanks; to be freed. */
static inline char *print_row(const struct session *session, int width, int height, int row)
{
    char *text = print(session, width, height), *line = text;
    for (int i = 0; i < row; i++)
        line = strchr(line, '\n') + 1;
    char *copy = strndup(line, strcspn(line, "\n"));
    free(text);
    assert_non_null(copy);
    return copy;
}
