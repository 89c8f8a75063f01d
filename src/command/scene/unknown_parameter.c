/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is said of a name that is no parameter. */
#include "command/internal.h"

static void put_params(const struct scene *scene, struct buffer *text)
{
    for (size_t i = 0; i < scene_params(scene)->count; i++)
        buffer_format(text, " %s", param_at(scene, (int)i)->row.name);
}

bool unknown_parameter(const struct session *session, struct text name, struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    const struct catalog *const catalogs[] = {scene_params(scene), scene_derived(scene),
                                              &setting_catalog};
    const int shown = (int)(name.len < 80 ? name.len : 80);
    struct suggestion near = {.wanted = name};
    if (catalog_find(&command_catalog, name)) {
        error_at(error, name, "'%.*s' is a command, not a parameter", shown, name.at);
        return error_hint(error, "type it without '=': %.*s ...", shown, name.at);
    }
    if (model_variable(scene->model, name) >= 0) {
        error_at(error, name, "'%.*s' is what moves, not a parameter", shown, name.at);
        return error_hint(
            error,
            "'show scene' lists the parameters, also those of the start; 'change %.*s VALUE' makes "
            "the current run jump",
            shown, name.at);
    }
    for (size_t c = 0; c < COUNT_OF(catalogs); c++)
        for (size_t i = 0; i < catalogs[c]->count; i++)
            suggestion_offer(&near, catalog_row(catalogs[c], i)->name);
    for (int i = 0; i < session->setup.lets; i++)
        suggestion_offer(&near, session->setup.let[i].name);
    const bool elsewhere = model_with(name) != NULL;
    if (scene->model != &oscillator_model) { /* it has few */
        struct buffer text = {0};
        put_params(scene, &text);
        error_at(error, name, "%s has no parameter '%.*s'; it has%s", scene->preset->row.name,
                 shown, name.at, buffer_view(&text));
        buffer_free(&text);
    } else if (elsewhere) {
        error_at(error, name, "%s has no parameter '%.*s'", scene->preset->row.name, shown,
                 name.at);
    } else {
        error_at(error, name, "unknown parameter '%.*s'", shown, name.at);
    }
    if (hint_other_model(session, name, error))
        return false;
    suggestion_hint(&near, error);
    return error_hint(
        error, near.count ? "('show all' lists the parameters)"
                          : "'show all' lists the parameters; 'let NAME = value' makes a variable");
}
