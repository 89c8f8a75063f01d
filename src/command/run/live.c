/* SPDX-License-Identifier: GPL-3.0-or-later */
/* pause, speed, change */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>

#include <math.h>

HANDLER(pause)
{
    UNUSED(args);
    UNUSED(error);
    if (session->live.state == LIVE_RUNNING)
        session->live.pausing = true;
    else
        reply_line(reply, "nothing is running");
    return true;
}

HANDLER(speed)
{
    UNUSED(error);
    const struct argument_value *factor = argument_value(args, "FACTOR");
    struct live *live = &session->live;
    if (factor->count || has_argument(args, "max"))
        live->speed = factor->count ? factor->item->value.value : HUGE_VAL;
    struct buffer text = {0};
    if (isinf(live->speed))
        buffer_put(&text, TEXT("speed max: as fast as possible"));
    else {
        buffer_put(&text, TEXT("speed "));
        buffer_short(&text, live->speed, 6);
        buffer_put(&text, TEXT(": simulated seconds a second"));
    }
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}

HANDLER(change)
{
    const struct text name = argument_value(args, "NAME")->item->text;
    const struct scene *scene = &session->setup.scene;
    const struct run *run = session_run(session);
    if (!catalog_find(scene_params(scene), name) && !catalog_find(scene_derived(scene), name) &&
        (!run || model_state(run->system.model, name) < 0))
        return unknown_parameter(session, name, TEXT(""), error);
    session->live.changing = true;
    const bool ok = command_set(session, args, reply, error);
    session->live.changing = false;
    return ok;
}
#endif

COMMAND(pause, .row = {"pause", "", "pause the run that goes on", "", NULL}, .group = "RUN",
        .text = "'continue' goes on to where the run was to end, with the same samples as without "
                "the pause. What "
                "stood after the run on\n"
                "its line or in its file is not executed.",
        .examples = "pause\nspeed 0.1", .see = "continue run step back speed",
        .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED)

COMMAND(speed, .row = {"speed", "", "how fast a watched run goes", "", NULL}, .group = "RUN",
        .text = "Simulated seconds a second, 1 in a new session; max: as fast as possible. Only of "
                "runs that are typed "
                "while the panes are\n"
                "shown; files, and programs without panes, always go as fast as possible. The "
                "samples do not depend on it.",
        .examples = "speed 0.25\nspeed max", .see = "run pause",
        .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED,
        ARGUMENTS(WORD("max", TYPE_NONE, .group = 1),
                  PLACE("FACTOR", TYPE_VALUE, .quantity = QUANTITY_NUMBER, .group = 1)))

COMMAND(change,
        .row = {"change", "", "change a parameter of the current run from here on", "", NULL},
        .group = "RUN",
        .text = "The scene and the current run get the value; the run goes on with it from the "
                "step where it stands. "
                "'set' does the same\n"
                "while a run goes on or is paused at the prompt. Of what moves, y or v, only the "
                "run gets it: a jump, "
                "whose energy counts as\n"
                "work. Exports say what was changed, and when.",
        .examples = "run to 3.2 s; change gamma 0.1 1/s; continue to 10 s\nrun 1 s; change v "
                    "-0.5*v; continue 1 s",
        .see = "set continue run event", .flags = COMMAND_JUMPS | COMMAND_CHANGES | COMMAND_ANYTIME,
        .completes = COMPLETES_VALUES,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED),
                  PLACE("VALUE", TYPE_REST, .flags = ARG_REQUIRED)))
