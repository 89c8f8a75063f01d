/* SPDX-License-Identifier: GPL-3.0-or-later */
/* describe */
#ifndef COMMAND_ROWS
#include <hooke/command/figure_arguments.h>

#include <hooke/figure/describe.h>

HANDLER(describe)
{
    struct figure_request request = {.charset = CHARSET_BRAILLE, .width = WORDS_COLUMNS};
    struct figure figure;
    struct buffer text = {0};
    int width, height;
    session_size(session, &width, &height);
    if (argument_value(args, "WHAT")->count == 0)
        request.kind = view_focus(&session->view);
    else if (!choose_figure(args, &request, error))
        return false;
    if (!make_figure(session, args, &request, &figure, error) ||
        !label_methods(session, &request, args->arena, &figure, error))
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

COMMAND(describe, .row = {"describe", "", "say in words and numbers what a plot shows", "", NULL},
        .group = "PLOT",
        .text =
            "Of the figure that 'plot' with the same words draws, read from its curves: what the "
            "axes hold, what each\n"
            "curve does (rises, oscillates, winds: period, amplitude, growth), where it is lowest "
            "and highest, how far\n"
            "apart curves are, and which is on top at the end. 'set charset words' says this in "
            "place of every plot.",
        .examples = "compare euler symplectic-euler; describe energy run all\n"
                    "describe phase window=0:10s",
        .see = "plot set", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("WHAT", TYPE_COLUMN, .flags = ARG_MANY | ARG_OF, .choices = &plot_catalog),
                  FIGURE_ARGUMENTS))
