/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Replies the numbers behind a phase portrait: separatrices and their crossings. */
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include "modules/dynamics/stored_portrait.h"

#include "modules/dynamics/handlers.h"
#include "modules/dynamics/plots.h"

/* Appends where a separatrix crosses the line variable = value through an equilibrium. */
static void put_crossing(struct buffer *text, const struct portrait_crossing *crossing,
                         const struct variable variable[2])
{
    const struct variable *axis = &variable[crossing->variable],
                          *other = &variable[!crossing->variable];
    buffer_format(text, ", %s = %s at %s = %s", other->name,
                  SHOWN_QUANTITY(crossing->other, other->quantity, 7), axis->name,
                  SHOWN_QUANTITY(crossing->value, axis->quantity, 4));
}

/* Adds the crossings of a separatrix as an array of the open record. */
static void reply_crossings(const struct separatrix *s, const struct variable variable[2],
                            struct reply *reply)
{
    reply_array(reply, "crossings");
    for (int i = 0; i < s->crossings; i++) {
        const struct portrait_crossing *crossing = &s->crossing[i];
        reply_object(reply, NULL);
        reply_real(reply, variable[crossing->variable].name, crossing->value);
        reply_real(reply, variable[!crossing->variable].name, crossing->other);
        reply_close(reply);
    }
    reply_close(reply);
}

/* Replies with the portrait that is shown, if there is one: a line and a record for each
 * separatrix, with the equilibrium at its other end and its crossings, then the cost, and a note if
 * the list of equilibria may be incomplete. */
void reply_portrait(const struct session *session, const struct figure_request *request,
                    struct reply *reply)
{
    UNUSED(request);
    const struct stored_portrait *stored = stored_portrait(session);
    if (!stored || !stored->request.scene)
        return;
    const struct portrait *portrait = &stored->portrait;
    const struct model *model = stored->request.scene->model;
    const struct system system = {.model = model, .n = model->n};
    const struct variable variable[2] = {system_variable(&system, stored->request.variable[0]),
                                         system_variable(&system, stored->request.variable[1])};
    for (int i = 0; i < portrait->separatrices; i++) {
        const struct separatrix *s = &portrait->separatrix[i];
        struct buffer *text = reply_buffer(reply);
        buffer_format(text, "separatrix of equilibrium %d, %s", s->equilibrium + 1,
                      s->stable ? "stable" : "unstable");
        if (s->target >= 0)
            buffer_format(text, ", %s equilibrium %d", s->stable ? "from" : "to", s->target + 1);
        for (int k = 0; k < s->crossings && k < 2; k++)
            put_crossing(text, &s->crossing[k], variable);
        reply_begin(reply, "separatrix");
        reply_int(reply, "n", i + 1);
        reply_int(reply, "equilibrium", s->equilibrium + 1);
        reply_bool(reply, "stable", s->stable);
        reply_string(reply, "end", s->end);
        reply_crossings(s, variable, reply);
        reply_end(reply);
    }
    struct buffer *cost = reply_buffer(reply);
    buffer_format(cost, "%lld evaluations", (long long)portrait->evals);
    put_seconds(cost, session, portrait->seconds);
    reply_own_solver(session, FLOW_SOLVER, reply);
    if (!portrait->found.complete && portrait->found.count > 0)
        reply_line(reply, "equilibria: may be incomplete (%s)", portrait->found.reason);
}
