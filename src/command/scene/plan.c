/* SPDX-License-Identifier: GPL-3.0-or-later */
/* plan */
#ifndef COMMAND_ROWS
#include <hooke/plot.h>
#include <hooke/run/price.h>
#include <hooke/command/handler.h>

static void plan_prices(const struct session *session, const struct system *system,
                        const struct run_settings *settings, const struct plan *plan,
                        struct buffer *text)
{
    const struct setup *setup = &session->setup;
    const int opinion = setup->settings.opinion;
    const struct run_scenario scenario = {.scene = &setup->scene,
                                          .system = system,
                                          .method = setup->method,
                                          .settings = settings,
                                          .plan = plan,
                                          .span = setup->settings.duration,
                                          .opinion = opinion == OPINIONS_OFF    ? 0
                                                     : opinion == OPINIONS_FULL ? 2
                                                                                : 1,
                                          .events = setup->events != NULL,
                                          .cancel = session->front.cancel};
    struct run_work work;
    run_work_count(&scenario, &work);
    run_prices_describe(&scenario, &work, text);
}

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
    const enum plot_kind focus = view_focus(&session->view);
    if (plot_row(focus)->planned && plot_offered(session, focus))
        buffer_put(&text, text_of(plot_row(focus)->planned));
    plan_prices(session, &system, &settings, &plan, &text);
    if (module_left_out[0])
        modules_put(&text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}
#endif

COMMAND(plan,
        .row = {"plan", "", "what will be computed for this scene and method, and what is left out",
                "", NULL},
        .group = "SCENE",
        .text = "Shows the forces that act, steps, memory, the predicted growth a step, and two "
                "lists: what 'run' computes and what it leaves out, with the price of each in "
                "percent of the run; of a program that was built without some modules, too, those "
                "that it has. Prices are counted in operations, not timed. The first steps "
                "are tried where their number, or that of their evaluations, is not known before.",
        .examples = "plan\nmethod verlet; plan", .see = "scene method run",
        .flags = COMMAND_ANYTIME)
