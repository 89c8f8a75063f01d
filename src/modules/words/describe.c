/* SPDX-License-Identifier: GPL-3.0-or-later */
/* describe */
#ifndef COMMAND_ROWS
#include <hooke/command/figure_arguments.h>

#include "modules/words/describe.h"

/* Executes `describe`: replies with sentences about the plot named by WHAT, or about the one in the
 * focus. The record "description" holds the plot's title and the text. */
HANDLER(describe)
{
    struct figure_request request = {.charset = &charset_braille, .width = WORDS_COLUMNS};
    struct figure figure;
    struct buffer text = {0};
    int width, height;
    session_size(session, &width, &height);
    if (argument_value(args, "WHAT")->count == 0)
        request.kind = view_focus(&session->view);
    else if (!choose_figure(args, &request, error))
        return false;
    if (!make_figure(session, args, &request, &figure, reply, error) ||
        !label_curves(session, &request, args->arena, &figure, error))
        return false;
    const bool ok = describe_figure(&figure, &text) || error_memory(error);
    if (ok) {
        reply_paragraph(reply, buffer_text(&text), width);
        reply_begin(reply, "description");
        reply_string(reply, "plot", figure.title);
        reply_string(reply, "text", text.data);
        reply_end(reply);
    }
    buffer_free(&text);
    return ok;
}
#endif

COMMAND(describe, .group = "PLOT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("WHAT", TYPE_COLUMN, .flags = ARG_MANY | ARG_OF, .choices = &plot_catalog),
                  FIGURE_ARGUMENTS))
