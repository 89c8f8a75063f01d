/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The error for a name that is no parameter, with what it is instead. */
#include <hooke/command/handler.h>
#include <hooke/module.h>

#include <stdio.h>

/* Appends the names of the scene's parameters. */
static void put_params(const struct scene *scene, struct buffer *text)
{
    for (size_t i = 0; i < scene_params(scene)->count; i++)
        buffer_format(text, " %s", param_at(scene, (int)i)->row.name);
}

/* Returns true, with the error set, if the name is known as something else: a command, variable or
 * observable. */
static bool other_kind(const struct session *session, struct text name, struct text value,
                       struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    const int shown = (int)(name.len < 80 ? name.len : 80), said = (int)value.len;
    const char *start = start_of(session, name);
    if (catalog_find(&command_catalog, name)) {
        error_at(error, name, "'%.*s' is a command, not a parameter", shown, name.data);
        error_hint(error, "type it without '=': '%.*s %.*s'", shown, name.data, said, value.data);
    } else if (model_variable(scene->model, name) >= 0) {
        error_at(error, name, "'%.*s' is a variable, not a parameter", shown, name.data);
        if (start)
            error_hint(error, "'%s = %.*s' sets its initial value", start, said, value.data);
        error_hint(error, "'change %.*s VALUE' changes it in the current run", shown, name.data);
    } else if (start) {
        error_at(error, name, "%s has no parameter '%.*s'", scene->preset->row.name, shown,
                 name.data);
        error_hint(error, "what moves here is %s: '%s = %.*s' sets its initial value",
                   scene->model->variable[0].name, start, said, value.data);
        hint_other_model(session, name, error);
    } else if (catalog_find(&observable_catalog, name)) {
        error_at(error, name, "'%.*s' is computed by a run and is not a parameter", shown,
                 name.data);
        error_hint(error, "'let %.*s_1 = %.*s' makes a variable with another name", shown,
                   name.data, said, value.data);
    }
    return error->code != ERROR_NONE;
}

/* Sets the error for a name that is no parameter: it names a left-out module or the other kind of
 * the name, else similar names. Returns false. */
bool unknown_parameter(const struct session *session, struct text name, struct text value,
                       struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    const struct catalog *const catalogs[] = {scene_params(scene), scene_derived(scene),
                                              &setting_catalog};
    const int shown = (int)(name.len < 80 ? name.len : 80);
    struct suggestion suggestion = {.wanted = name};
    char what[64];
    snprintf(what, sizeof what, "set %.*s", shown, name.data);
    if (!module_is_in(what, name, error))
        return false;
    value = text_trim(value);
    if (other_kind(session, name, value.len ? value : TEXT("VALUE"), error))
        return false;
    for (size_t c = 0; c < COUNT_OF(catalogs); c++)
        for (size_t i = 0; i < catalogs[c]->count; i++)
            suggestion_offer(&suggestion, catalog_row(catalogs[c], i)->name);
    for (int i = 0; i < session->setup.lets; i++)
        suggestion_offer(&suggestion, session->setup.let[i].name);
    const bool elsewhere = model_with(name) != NULL;
    if (scene->model != &oscillator_model) { /* few enough to list them all */
        struct buffer text = {0};
        put_params(scene, &text);
        error_at(error, name, "%s has no parameter '%.*s'; it has%s", scene->preset->row.name,
                 shown, name.data, buffer_view(&text));
        buffer_free(&text);
    } else if (elsewhere) {
        error_at(error, name, "%s has no parameter '%.*s'", scene->preset->row.name, shown,
                 name.data);
    } else {
        error_at(error, name, "unknown parameter '%.*s'", shown, name.data);
        error->unknown = "parameter";
    }
    if (hint_other_model(session, name, error))
        return false;
    suggestion_hint(&suggestion, error);
    error_hint(error, suggestion.count ? "('show all' lists the parameters)"
                                       : "'show all' lists the parameters");
    return value.len > 0 && error_hint(error, "'let %.*s = %.*s' makes a variable", shown,
                                       name.data, (int)value.len, value.data);
}
