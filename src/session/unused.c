/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Frees typed scenes and lists of events that nothing uses any more: neither the set-up, runs and
 * results, nor undo and checkpoints. */
#include <hooke/run.h>
#include <hooke/session/events.h>
#include <hooke/module.h>
#include <hooke/scene/typed.h>

bool scene_uses(const struct scene *scene, const struct model *model)
{
    return scene->model && (scene->model == model || scene->preset->model == model);
}

/* Returns true if the set-up uses the model or the events; either may be NULL. */
bool setup_uses(const struct setup *setup, const struct model *model, const struct events *events)
{
    bool uses = (events && setup->events == events) || (model && scene_uses(&setup->scene, model));
    for (int i = 0; i < setup->owns && model && !uses; i++)
        uses = setup->own[i]->model == model;
    return uses;
}

bool run_slot_uses(const struct run_slot *slot, const struct model *model,
                   const struct events *events)
{
    return (events && slot->events == events) || (model && scene_uses(&slot->run->scene, model));
}

/* Returns true if set-up, runs, undo or checkpoints use the model or the events; either may be
 * NULL. */
static bool definition_is_used(const struct session *session, const struct model *model,
                               const struct events *events)
{
    bool used = setup_uses(&session->setup, model, events);
    for (int i = 0; i < session->runs.count && !used; i++)
        used = run_slot_uses(session->runs.slot[i], model, events);
    /* the latest first, where most definitions are used */
    for (int i = session->undo.undos + session->undo.redos; i-- > 0 && !used;)
        used = snapshot_uses(session->undo.state[i], model, events);
    for (int i = session->undo.checkpoints; i-- > 0 && !used;)
        used = snapshot_uses(session->undo.checkpoint[i], model, events);
    return used;
}

static bool events_are_used(const struct session *session, const struct events *events)
{
    return definition_is_used(session, NULL, events);
}

/* Returns true if the session (context) or a module's part of it uses the model. */
static bool model_is_used(const void *context, const struct model *model)
{
    const struct session *session = context;
    bool used = definition_is_used(session, model, NULL);
    for (int i = 0; i < session->parts->count && !used; i++) {
        const struct session_part *part = &session->parts->item[i];
        used = part->module->part_uses && part->module->part_uses(part->state, model);
    }
    return used;
}

void session_sweep(struct session *session)
{
    typed_sweep(session->definitions.models, model_is_used, session);
    events_sweep(session, events_are_used);
}
