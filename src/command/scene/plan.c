/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command plan: what the next run will compute, and what it costs. */
#ifndef COMMAND_ROWS
#include <hooke/module.h>
#include <hooke/plot.h>
#include <hooke/run/price.h>
#include <hooke/command/handler.h>

/* Appends to `text` the predicted work of a run with these settings and its parts, one per feature
 * that costs time (steps, events, second opinion). settings->opinion is translated to the effort 0
 * (off), 1 (auto) or 2 (full). */
static void plan_prices(const struct session *session, const struct system *system,
                        const struct run_settings *settings, const struct plan *plan,
                        struct buffer *text)
{
    const struct setup *setup = &session->setup;
    const int opinion = setup->settings.opinion;
    int effort;
    if (opinion == OPINIONS_OFF)
        effort = 0;
    else
        effort = opinion == OPINIONS_FULL ? 2 : 1;
    const struct run_scenario scenario = {.scene = &setup->scene,
                                          .system = system,
                                          .method = setup->method,
                                          .settings = settings,
                                          .plan = plan,
                                          .span = setup->settings.duration,
                                          .opinion = effort,
                                          .events = setup->events != NULL,
                                          .cancel = session->front.cancel};
    struct run_work work;
    run_work_count(&scenario, &work);
    run_prices_describe(&scenario, &work, text);
}

/* Describes method, error estimate, events, figures and predicted work of a run. */
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
    struct buffer *text = reply_buffer(reply);
    plan_describe(&setup->scene, &system, setup->method, &settings, &plan, text);
    plan_opinion(session, &system, &plan, text);
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->plan)
            module_list[i]->plan(session, text);
    events_plan(setup->events, text);
    const enum plot_kind focus = view_focus(&session->view);
    if (plot_row(focus)->planned && plot_offered(session, focus))
        buffer_put(text, text_of(plot_row(focus)->planned));
    plan_prices(session, &system, &settings, &plan, text);
    if (module_left_out[0])
        modules_put(text);
    return true;
}
#endif

COMMAND(plan, .group = "SCENE", .flags = COMMAND_ANYTIME)
