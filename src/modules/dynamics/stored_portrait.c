/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The cache of the phase portrait: panes draw the stored one until the scene or the plane has
 * changed. */
#include "modules/dynamics/dynamics_results.h"

#include <string.h>

struct stored_portrait *stored_portrait(const struct session *session)
{
    struct dynamics_part *part = session_part(session, &dynamics_module);
    return part ? &part->portrait : NULL;
}

/* Compares model, parameters, variables and kind of lines, but not the region. */
bool portrait_is_of(const struct stored_portrait *stored, const struct portrait_request *request)
{
    const struct portrait_request *made = &stored->request;
    return stored && stored->known && stored->scene.model == request->scene->model &&
           memcmp(stored->scene.value, request->scene->value,
                  request->scene->model->params->count * sizeof(double)) == 0 &&
           memcmp(made->variable, request->variable, sizeof made->variable) == 0 &&
           made->energy == request->energy;
}

/* Returns true if both requests have bitwise the same region, state and time. */
static bool same_place(const struct portrait_request *a, const struct portrait_request *b)
{
    return memcmp(a->box, b->box, sizeof a->box) == 0 &&
           memcmp(a->all, b->all, sizeof a->all) == 0 &&
           memcmp(a->state, b->state, sizeof a->state) == 0 &&
           memcmp(&a->t, &b->t, sizeof a->t) == 0;
}

/* Makes the portrait again if anything in the request differs from the stored one. */
const struct portrait *session_portrait(const struct session *session,
                                        const struct portrait_request *request, struct error *error)
{
    struct stored_portrait *stored = stored_portrait(session);
    if (!stored) {
        error_memory(error);
        return NULL;
    }
    if (portrait_is_of(stored, request) && same_place(&stored->request, request))
        return &stored->portrait;
    stored_portrait_clear(stored);
    if (!portrait_make(request, &stored->portrait, error))
        return NULL;
    stored->request = *request;
    stored->scene = *request->scene;
    stored->request.scene = &stored->scene;
    stored->request.cancel = NULL;
    stored->known = !stored->portrait.cancelled;
    return &stored->portrait;
}

void stored_portrait_clear(struct stored_portrait *stored)
{
    portrait_free(&stored->portrait);
    stored->known = false;
}
