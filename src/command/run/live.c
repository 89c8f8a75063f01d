/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands for a run in progress: pause, speed, change. */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>

#include <math.h>

/* Asks the run in progress to pause. */
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

/* Sets or shows the speed at which watched runs follow the clock. */
HANDLER(speed)
{
    UNUSED(error);
    const struct argument_value *factor = argument_value(args, "FACTOR");
    struct live *live = &session->live;
    if (factor->count || has_argument(args, "max"))
        live->speed = factor->count ? factor->item->value.value : HUGE_VAL;
    if (isinf(live->speed))
        reply_line(reply, "speed max: as fast as possible");
    else
        reply_line(reply, "speed %s: simulated seconds per second", SHOWN_SHORT(live->speed, 6));
    return true;
}

/* Sets a parameter or state variable of the current run, by the handler of set. */
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

COMMAND(pause, .group = "RUN", .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED)

COMMAND(speed, .group = "RUN", .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED,
        ARGUMENTS(WORD("max", TYPE_NONE, .group = 1),
                  PLACE("FACTOR", TYPE_VALUE, .quantity = QUANTITY_NUMBER, .group = 1)))

COMMAND(change, .group = "RUN", .flags = COMMAND_JUMPS | COMMAND_CHANGES | COMMAND_ANYTIME,
        .completes = COMPLETES_VALUES,
        ARGUMENTS(PLACE("NAME", TYPE_NAME, .flags = ARG_REQUIRED),
                  PLACE("VALUE", TYPE_REST, .flags = ARG_REQUIRED)))
