/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands panes, plain and redraw, which the front end carries out. */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>

/* Asks the front end for a change. Returns false with the error set if there is no terminal. */
static bool change_front(const struct session *session, enum front_change change,
                         struct error *error)
{
    if (session->front.change)
        return session->front.change(session->front.context, change, error);
    return change == FRONT_REDRAW ||
           error_set(error, ERROR_COMMAND, "panes and prompt need a terminal");
}

/* Asks the front end to show panes. */
HANDLER(panes)
{
    UNUSED(args);
    UNUSED(reply);
    return change_front(session, FRONT_PANES, error);
}

/* Asks the front end for the plain prompt. */
HANDLER(plain)
{
    UNUSED(args);
    UNUSED(reply);
    return change_front(session, FRONT_PLAIN, error);
}

/* Asks the front end to draw the screen again. */
HANDLER(redraw)
{
    UNUSED(args);
    UNUSED(reply);
    return change_front(session, FRONT_REDRAW, error);
}
#endif

COMMAND(panes, .group = "SESSION", .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED)

COMMAND(plain, .group = "SESSION", .flags = COMMAND_UNRECORDED)

COMMAND(redraw, .group = "SESSION", .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED)
