/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command list: rows of catalogs, methods, measurements, events and others, each as a line and
 * a record. */
#ifndef COMMAND_ROWS
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>
#include "command/session/list_methods.h"

#include <math.h>
#include <stdio.h>

/* Begins a record with the members that every row has. */
static void record_names(const struct catalog *catalog, const struct row *row, struct reply *reply)
{
    reply_begin(reply, catalog->kind);
    reply_string(reply, "name", row->name);
    reply_string(reply, "unit", *row->unit ? row->unit : NULL);
    reply_string(reply, "brief", row->brief);
    reply_string(reply, "citation", *row->citation ? row->citation : NULL);
    reply_string(reply, "alias", row->alias);
}

/* Adds the record of a method; stable is its limit of omega0 dt. */
static void record_method(const struct row *row, double stable, struct reply *reply)
{
    const struct method *method = method_from(row);
    record_names(&method_catalog, row, reply);
    reply_int(reply, "order", method->order);
    reply_int(reply, "evals", method->evals);
    reply_bool(reply, "implicit", (method->flags & METHOD_IMPLICIT) != 0);
    reply_bool(reply, "symplectic", (method->flags & METHOD_SYMPLECTIC) != 0);
    reply_bool(reply, "adaptive", (method->flags & METHOD_ADAPTIVE) != 0);
    reply_bool(reply, "yardstick", (method->flags & METHOD_EXTERNAL) != 0);
    reply_real(reply, "stable_limit", stable);
    reply_string(reply, "formula", method->formula);
    reply_end(reply);
}

/* Replies with a row of a catalog: a line and a record. */
void reply_listed(const struct catalog *catalog, const struct row *row, struct reply *reply)
{
    char value[32] = "";
    if (catalog == &limit_catalog)
        snprintf(value, sizeof value, "%16.0f ", ((const struct limit *)(const void *)row)->value);
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%-22s %s%-7s %s", row->name, value, row->unit, row->brief);
    if (*row->citation)
        buffer_format(text, " (%s)", row->citation);
    record_names(catalog, row, reply);
    if (catalog == &command_catalog) {
        struct buffer usage = {0};
        command_usage(command_at(row), &usage);
        reply_string(reply, "group", command_at(row)->group);
        reply_string(reply, "usage", buffer_view(&usage));
        reply_string(reply, "text", command_at(row)->text);
        reply_string(reply, "examples", command_at(row)->examples);
        reply_string(reply, "see", command_at(row)->see);
        buffer_free(&usage);
    }
    if (catalog == &limit_catalog)
        reply_real(reply, "value", ((const struct limit *)(const void *)row)->value);
    reply_end(reply);
}

/* Lists the measurements that are kept. */
static void list_measurements(const struct session *session, struct reply *reply)
{
    if (session->measurements == 0)
        reply_line(reply, "no measurements");
    for (int i = 0; i < session->measurements; i++) {
        const struct measurement *m = &session->measurement[i];
        struct buffer text = {0};
        buffer_format(&text, "%3d  %-10s ", i + 1, m->quantity);
        buffer_measured(&text, m->value, m->unit, session->setup.settings.digits);
        if (isfinite(m->periods))
            buffer_format(&text, " (%g periods)", m->periods);
        buffer_format(&text, "  of %s", m->source);
        reply_text(reply, buffer_text(&text));
        buffer_free(&text);
        reply_records(reply, "measure", &measurement_columns, m, 1);
    }
}

/* Lists the columns of the scene's runs: variables, observations, and the observables that are
 * defined for it. */
static void list_observables(const struct model *model, struct reply *reply)
{
    for (int i = 0; i < model->n + model_observed(model); i++) {
        const bool observed = i >= model->n;
        const struct variable variable =
            observed ? model_observed_variable(model, i - model->n) : model->variable[i];
        if (!observed &&
            model == &oscillator_model) /* the observables below describe them better */
            continue;
        const struct row row = {variable.name, quantity_unit(variable.quantity),
                                observed ? "observed by the user" : "state variable", "", NULL};
        reply_listed(&observable_catalog, &row, reply);
    }
    for (size_t i = 0; i < observable_catalog.count; i++) {
        const struct row *row = catalog_row(&observable_catalog, i);
        const bool shadowed =
            model != &oscillator_model && (model_variable(model, text_of(row->name)) >= 0 ||
                                           model_observation(model, text_of(row->name)) >= 0);
        if (!shadowed && model_offers(model, observable_from(row)))
            reply_listed(&observable_catalog, row, reply);
    }
}

/* Lists what KIND asks for; runs are listed by their own command. */
HANDLER(list)
{
    static const struct catalog *const catalogs[] = {
        [LIST_COMMANDS] = &command_catalog, [LIST_SCENES] = &preset_catalog,
        [LIST_METHODS] = &method_catalog,   [LIST_SETTINGS] = &setting_catalog,
        [LIST_UNITS] = &unit_catalog,       [LIST_FUNCTIONS] = &function_catalog,
        [LIST_LIMITS] = &limit_catalog};
    const struct item *item = argument_value(args, "KIND")->item;
    const struct list_kind *what = (const struct list_kind *)(const void *)item->row;
    const enum listed kind = (enum listed)item->index;
    const struct argument_value *words = argument_value(args, "WORDS");
    if (words->count && kind != LIST_METHODS)
        return error_at(error, words->where, "only methods can be filtered: list methods stiff");
    if (kind == LIST_METHODS)
        return list_methods(words->count ? words->item->text : TEXT(""), session->front.cancel,
                            record_method, reply, error);
    if (kind == LIST_OBSERVABLES) {
        list_observables(session->setup.scene.model, reply);
    } else if (kind == LIST_MEASUREMENTS) {
        list_measurements(session, reply);
    } else if (kind == LIST_EVENTS) {
        reply_event_records(session, reply);
    } else if (what->list) {
        return what->list(session, args->arena, reply);
    } else if (kind < LIST_MEASUREMENTS) {
        const struct scene *scene = &session->setup.scene;
        const struct catalog *catalog;
        if (kind == LIST_PARAMETERS)
            catalog = scene_params(scene);
        else
            catalog = kind == LIST_DERIVED ? scene_derived(scene) : catalogs[kind];
        for (size_t i = 0; i < catalog->count; i++)
            reply_listed(catalog, catalog_row(catalog, i), reply);
        for (int i = 0; kind == LIST_SCENES && i < session->setup.owns; i++)
            reply_listed(catalog, &session->setup.own[i]->row, reply);
    } else {
        /* The list of runs is a command of its own. */
        const struct command *command = command_at(catalog_find(&command_catalog, TEXT("runs")));
        struct arguments none = {
            .command = command, .arena = args->arena, .scope = args->scope, .where = args->where};
        return command->handler(session, &none, reply, error);
    }
    return true;
}
#endif

COMMAND(list, .row.alias = "ls", .group = "SESSION",
        .flags = COMMAND_UNRECORDED | COMMAND_ANYTIME | COMMAND_TABLES,
        .completes = COMPLETES_KINDS,
        ARGUMENTS(PLACE("KIND", TYPE_CHOICE, .flags = ARG_REQUIRED, .choices = &list_catalog),
                  PLACE("WORDS", TYPE_REST)))
