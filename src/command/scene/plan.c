/* SPDX-License-Identifier: GPL-3.0-or-later */
/* plan */
#ifndef COMMAND_ROWS
#include <hooke/plot.h>
#include "command/internal.h"

HANDLER(plan)
{
    UNUSED(args);
    const struct setup *setup = &session->setup;
    const struct run_settings settings = session_run_settings(session);
    struct system system;
    struct plan plan;
    if (!scene_bind(&setup->scene, &system, error) ||
        !plan_make(&system, setup->method, &settings, setup->settings.duration, &plan, error))
        return false;
    struct buffer text = {0};
    plan_describe(&setup->scene, &system, setup->method, &settings, &plan, &text);
    plan_opinion(session, &system, &plan, &text);
    const struct reference *known =
        references_find(&session->references, &setup->scene, setup->settings.duration);
    if (known && !known->exact) {
        buffer_put(&text, TEXT("reference "));
        reference_describe(known, &text);
        buffer_put(&text, TEXT(": found before, for precision, compare and order\n"));
    }
    events_plan(setup->events, &text);
    band_plan(session, &system, &text);
    if (view_focus(&session->view) == PLOT_PORTRAIT && plot_offered(session, PLOT_PORTRAIT))
        buffer_put(&text, TEXT("portrait  arrows in each frame, its lines again only when a value "
                               "or the box changes\n"));
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}
#endif

COMMAND(plan,
        .row = {"plan", "", "what will be computed for this scene and method, and what is left out",
                "", NULL},
        .group = "SCENE",
        .text = "Nothing is run. Shows the forces that act, steps, memory, and the predicted "
                "growth a step.",
        .examples = "plan\nmethod verlet; plan", .see = "scene method run",
        .flags = COMMAND_ANYTIME)
