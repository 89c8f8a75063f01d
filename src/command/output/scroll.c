/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command scroll: scrolls the log, searches it, and shows it on the whole screen. */
#ifndef COMMAND_ROWS
#include "command/finding.h"
#include <hooke/command/handler.h>

#include <math.h>
#include <string.h>

#define PAGE_WIDTH 80 /* [cell] size that is assumed without a screen */
#define PAGE_HEIGHT 24

static int width_of(const struct session *session)
{
    return session->front.width ? session->front.width : PAGE_WIDTH;
}

/* Scrolls so that line i, counted from the newest, is at the top. */
static void show_line(struct session *session, int i)
{
    const int height = session->front.height ? session->front.height : PAGE_HEIGHT,
              scroll = log_rows_newest(&session->log, i + 1, width_of(session)) - (height - 1);
    session->view.scroll = scroll > 0 ? scroll : 0;
    session->view.found = i;
}

/* Searches the word from the line behind the last one found, and from the oldest line after the
 * newest. Returns false with the error set if no line has it. */
static bool find_line(struct session *session, struct text word, struct error *error)
{
    const struct log *log = &session->log;
    for (int i = 1; i <= log->count; i++) {
        const int index = (session->view.found - i + 2 * log->count) % log->count;
        if (text_mentions(log_line(log, index), word)) {
            show_line(session, index);
            return true;
        }
    }
    return error_at(error, word, "no line has '%.*s'", (int)(word.len < 64 ? word.len : 64),
                    word.data);
}

/* Searches, opens or closes the reading of the log, or scrolls by rows within its length. */
HANDLER(scroll)
{
    UNUSED(reply);
    struct view *view = &session->view;
    const struct argument_value *rows = argument_value(args, "ROWS"),
                                *read = argument_value(args, "read"),
                                *word = argument_value(args, "find");
    if (word->count) {
        const size_t len = word->item->text.len < LIMIT_NAME ? word->item->text.len : LIMIT_NAME;
        memcpy(view->wanted, word->item->text.data, len);
        view->wanted[len] = '\0';
    }
    if (word->count || has_argument(args, "next"))
        return *view->wanted ? find_line(session, text_of(view->wanted), error)
                             : error_set(error, ERROR_COMMAND, "no search text yet");
    if (has_argument(args, "close")) {
        view->reading = false;
        view->scroll = 0;
        return true;
    }
    if (read->count) {
        const int lines = (int)fmin(read->item->value.value, session->log.count);
        view->reading = lines > 0;
        if (lines > 0)
            show_line(session, lines - 1);
        return true;
    }
    int max = log_rows_newest(&session->log, session->log.count, width_of(session));
    max -= max > 0;
    double scroll;
    if (has_argument(args, "home"))
        scroll = max;
    else
        scroll = has_argument(args, "end") ? 0 : view->scroll;
    if (rows->count)
        scroll += rows->item->value.value;
    if (scroll < 0)
        view->scroll = 0;
    else
        view->scroll = scroll > max ? max : (int)scroll;
    return true;
}
#endif

COMMAND(scroll, .group = "PLOT", .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED,
        ARGUMENTS(WORD("home", TYPE_NONE, .group = 1), WORD("end", TYPE_NONE, .group = 1),
                  WORD("read", TYPE_INTEGER, .group = 1), WORD("find", TYPE_REST, .group = 1),
                  WORD("next", TYPE_NONE, .group = 1), WORD("close", TYPE_NONE, .group = 1),
                  PLACE("ROWS", TYPE_INTEGER, .flags = ARG_NEGATIVE, .group = 1)))
