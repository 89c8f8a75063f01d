/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command method: the integrator, its step or tolerance, and its drag variant. */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>

/* Replies with the method that the next run uses. */
static void reply_method(const struct session *session, struct reply *reply)
{
    const struct setup *setup = &session->setup;
    const struct method *method = setup->method;
    const struct run_settings settings = session_run_settings(session);
    struct buffer *text = reply_buffer(reply);
    buffer_put(text, text_of(method->row.name));
    if (method->order > 0)
        buffer_format(text, ", order %d", method->order);
    if (settings.tol > 0) {
        buffer_format(text, ", adaptive, tol = %s", SHOWN_SHORT(settings.tol, 6));
        put_tol_floor(text, settings.tol);
    } else {
        buffer_format(text, ", dt = %s",
                      SHOWN_VALUE(settings.dt, QUANTITY_TIME, setup->settings.digits));
    }
    if (setup->drag != DRAG_DEFAULT)
        buffer_format(text, ", drag %s", catalog_row(&drag_catalog, (size_t)setup->drag - 1)->name);
}

/* Returns true if the method has the drag variant; otherwise sets an error with those that it
 * has. */
static bool check_drag(const struct method *method, const struct item *item, struct error *error)
{
    const enum drag drag = (enum drag)(item->index + 1);
    if (method->drags & (1u << drag))
        return true;
    error_at(error, item->text, "%s has no variant with %s drag", method->row.name,
             item->row->name);
    for (enum drag i = DRAG_EXACT; i < DRAG_COUNT; i++)
        if (method->drags & (1u << i))
            error_hint(error, "drag=%s", catalog_row(&drag_catalog, (size_t)i - 1)->name);
    return error->hint[0] ? false
                          : error_hint(error, "this method evaluates drag as part of the force");
}

/* Chooses the method; dt= gives it fixed steps, tol= lets it adapt them. */
HANDLER(method)
{
    const struct argument_value *name = argument_value(args, "NAME"),
                                *dt = argument_value(args, "dt"),
                                *tol = argument_value(args, "tol"),
                                *drag = argument_value(args, "drag");
    struct setup *setup = &session->setup;
    const struct method *method = name->count ? method_from(name->item->row) : setup->method;
    if (drag->count && !check_drag(method, drag->item, error))
        return false;
    if (tol->count && !(method->flags & METHOD_ADAPTIVE)) {
        error_at(error, tol->where,
                 "%s has no error estimate: it cannot adapt its step to a tolerance",
                 method->row.name);
        return error_hint(error, "give dt=, or choose a method from 'list methods adaptive'");
    }
    if (tol->count && tol->item->value.value >= 1)
        return error_at(error, tol->item->text, "tol must be a number between 0 and 1");
    if (name->count || dt->count || tol->count || drag->count) {
        if (dt->count && !tol->count)
            setup->fixed = true;
        else
            setup->fixed = tol->count || name->count ? false : setup->fixed;
        if (drag->count)
            setup->drag = (enum drag)(drag->item->index + 1);
        else
            setup->drag = name->count ? DRAG_DEFAULT : setup->drag;
        setup->method = method;
        setup->method_chosen |= name->count > 0;
        if (dt->count)
            setup->settings.dt = dt->item->value.value, setup->settings.dt_chosen = true;
        if (tol->count)
            setup->settings.tol = tol->item->value.value, setup->settings.tol_chosen = true;
        session_changed(session);
        reply_inapplicable(session, reply);
    }
    reply_method(session, reply);
    return true;
}
#endif

COMMAND(method, .group = "METHOD", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("NAME", TYPE_CHOICE, .choices = &method_catalog),
                  KEY("dt", TYPE_VALUE, .quantity = QUANTITY_TIME),
                  KEY("tol", TYPE_VALUE, .quantity = QUANTITY_NUMBER),
                  KEY("drag", TYPE_CHOICE, .choices = &drag_catalog)))
