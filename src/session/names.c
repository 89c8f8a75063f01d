/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names in expressions: which quantity a name means and its value. State and observables of the
 * current run come first, then parameters and derived quantities of the scene, settings, variables,
 * results. Parameters that a user has typed come before observables. */
#include <hooke/run.h>
#include <hooke/base/unit.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <math.h>
#include <string.h>

/* Kinds of names, and where their index points to. */
enum name_kind {
    NAME_STATE,
    NAME_OBSERVED,
    NAME_OBSERVABLE,
    NAME_PARAM,
    NAME_DERIVED,
    NAME_SETTING,
    NAME_LET,
    NAME_RESULT
};

/* A slot, by which compiled expressions refer to a name, is kind << SLOT_KIND | index. */
#define SLOT_KIND 16

/* Finds a variable or result by name and sets *index. Returns false if there is none. */
static bool in_values(const struct named_value *values, int count, struct text name, int *index)
{
    for (int i = 0; i < count; i++)
        if (text_is(name, values[i].name)) {
            *index = i;
            return true;
        }
    return false;
}

/* Returns true if the row is a setting with a number as value, not a choice. */
static bool setting_is_number(const struct row *row)
{
    const struct setting *setting = setting_from(row);
    return setting && setting->max > 0;
}

/* Finds a row by name and sets *index. Returns false if there is none. */
static bool in_catalog(const struct catalog *catalog, struct text name, int *index)
{
    const struct row *row = catalog_find(catalog, name);
    if (row)
        *index = catalog_index(catalog, row);
    return row != NULL;
}

/* Returns the run whose state and observables the names mean; NULL if there is none yet. */
static const struct run *run_of(const struct names *names)
{
    return names->run || names->expects_run ? names->run : session_run(names->session);
}

/* Returns true if state and observables have names: there is a run, or one is expected. */
static bool has_state(const struct names *names)
{
    return names->expects_run || run_of(names);
}

/* Returns the model whose state and observables the names mean: the run's or, if there is no run,
 * the scene's. */
static const struct model *state_model(const struct names *names)
{
    const struct run *run = run_of(names);
    return run ? run->system.model : names->session->setup.scene.model;
}

/* Finds a state variable of the model and sets *index. Returns false if there is none. */
static bool in_state(const struct model *model, struct text name, int *index)
{
    *index = model_variable(model, name);
    return *index >= 0;
}

/* Returns the scene whose parameters the names mean; for a run in progress its scene with the
 * changes so far, which is kept until the journal grows. */
static const struct scene *scene_of(const struct names *names)
{
    struct in_force *force = names->in_force;
    if (!force)
        return &names->session->setup.scene;
    if (!force->known || force->last != force->slot->last) {
        journal_scene(force->slot, true, &force->scene);
        force->last = force->slot->last;
        force->known = true;
    }
    return &force->scene;
}

/* Returns true if the observable needs an energy that the run does not have, because its typed
 * forces have no potential. */
static bool lacks_energy(const struct run *run, const struct observable *observable)
{
    return run && observable && observable->needs & NEED_ENERGY && run->system.order == 2 &&
           !run->system.energy;
}

/* Finds the newest result that the program prints as T or A, and sets *index. Returns false if
 * there is none. */
static bool in_letters(const struct session *session, struct text name, int *index)
{
    static const struct {
        const char *letter, *result;
    } printed[] = {
        {"T", "fit_period"},    {"T", "measured_period"},    {"T", "fit_T"},
        {"A", "fit_amplitude"}, {"A", "measured_amplitude"}, {"A", "fit_A"},
    };
    for (*index = session->results.count - 1; *index >= 0; --*index)
        for (size_t i = 0; i < COUNT_OF(printed); i++)
            if (text_is(name, printed[i].letter) &&
                strcmp(session->results.value[*index].name, printed[i].result) == 0)
                return true;
    return false;
}

/* Finds the meaning of a name, in the order at the top of this file, and sets *slot to its kind and
 * index. names->saved_only leaves out variables and results, which a saved session lacks. Returns
 * false if it has no meaning. */
static bool find_name(const struct names *names, struct text name, int *slot)
{
    const struct session *session = names->session;
    const struct scene *scene = scene_of(names);
    const struct model *moving = state_model(names);
    const bool moves = has_state(names);
    const struct run *run = names->run ? names->run : session_run(session);
    enum name_kind kind;
    int index = 0;
    if (moves && in_state(moving, name, &index))
        kind = NAME_STATE;
    else if (moves && (index = model_observation(moving, name)) >= 0)
        kind = NAME_OBSERVED;
    else if (scene->model->typed && in_catalog(scene_params(scene), name, &index))
        kind = NAME_PARAM;
    else if (moves && model_observable(moving, name) &&
             !lacks_energy(run, model_observable(moving, name)) &&
             in_catalog(&observable_catalog, name, &index))
        kind = NAME_OBSERVABLE;
    else if (in_catalog(scene_params(scene), name, &index))
        kind = NAME_PARAM;
    else if (in_catalog(scene_derived(scene), name, &index))
        kind = NAME_DERIVED;
    else if (setting_is_number(catalog_find(&setting_catalog, name)) &&
             in_catalog(&setting_catalog, name, &index))
        kind = NAME_SETTING;
    else if (!names->saved_only && in_values(session->setup.let, session->setup.lets, name, &index))
        kind = NAME_LET;
    else if (!names->saved_only &&
             in_values(session->results.value, session->results.count, name, &index))
        kind = NAME_RESULT;
    else if (names->letters && in_letters(session, name, &index))
        kind = NAME_RESULT;
    else
        return false;
    *slot = (int)kind << SLOT_KIND | index;
    return true;
}

/* Implements find of struct expr_scope; context is a struct names. */
static bool scope_find(const void *context, struct text name, int *slot)
{
    return find_name(context, name, slot);
}

/* Returns the value of a setting that is a number. */
static double setting_number(const struct settings *settings, const struct setting *setting)
{
    double value;
    memcpy(&value, (const char *)settings + setting->offset, sizeof value);
    return value;
}

/* Returns value, uncertainty and quantity of the name with this slot, as find_name() numbers them
 * (kind and index); the value is NAN if it needs a run and there is none. */
static struct named_value slot_value(const struct names *names, int slot)
{
    const struct session *session = names->session;
    const struct run *run = names->run ? names->run : session_run(session);
    const size_t index = (size_t)(slot & ((1 << SLOT_KIND) - 1));
    const struct setup *setup = &session->setup;
    const struct scene *scene = scene_of(names);
    struct named_value value = {.value = NAN, .quantity = QUANTITY_OTHER};
    const struct model *moving = state_model(names);
    switch ((enum name_kind)(slot >> SLOT_KIND)) {
    case NAME_STATE:
        value.quantity = moving->variable[index].quantity;
        if (run && run->system.model == moving)
            value.value = run->y[index];
        break;
    case NAME_OBSERVED:
        value.quantity = model_observed_variable(moving, (int)index).quantity;
        if (run && run->system.model == moving)
            value.value = run_observed(run, (int)index);
        break;
    case NAME_OBSERVABLE: {
        const struct observable *observable = observable_at(index);
        value.quantity = model_quantity(moving, observable);
        if (run)
            value.value = run_observable(run, observable);
        break;
    }
    case NAME_PARAM:
        value.value = scene->value[index];
        value.uncertainty = scene->uncertainty[index];
        value.quantity = param_at(scene, (int)index)->quantity;
        break;
    case NAME_DERIVED: {
        const struct derived_row *derived =
            (const struct derived_row *)(const void *)catalog_row(scene_derived(scene), index);
        const struct measured measured = derived->value(scene);
        value.value = measured.value;
        value.uncertainty = measured.uncertainty;
        value.quantity = derived->quantity;
        break;
    }
    case NAME_SETTING: {
        const struct setting *setting = setting_at(index);
        value.value = setting_number(&setup->settings, setting);
        value.quantity = setting->quantity;
        break;
    }
    case NAME_LET:
        return setup->let[index];
    case NAME_RESULT:
        return session->results.value[index];
    }
    return value;
}

/* Implements load of struct expr_scope: the value of a slot at present. */
static double scope_load(const void *context, int slot)
{
    return slot_value(context, slot).value;
}

/* Offers every name that has a meaning, with its description; moving is the model of state and
 * observables. */
static void offer_names(const struct session *session, const struct model *moving,
                        void (*offer)(void *context, const char *name, const char *brief),
                        void *context)
{
    const struct scene *scene = &session->setup.scene;
    const struct catalog *const catalogs[] = {&observable_catalog, scene_params(scene),
                                              scene_derived(scene), &setting_catalog};
    for (int i = 0; i < moving->n; i++)
        if (!catalog_find(&observable_catalog, text_of(moving->variable[i].name)))
            offer(context, moving->variable[i].name, quantity_name(moving->variable[i].quantity));
    for (int i = 0; i < model_observed(moving); i++)
        offer(context, model_observed_variable(moving, i).name, "observed");
    for (size_t c = 0; c < COUNT_OF(catalogs); c++)
        for (size_t i = 0; i < catalogs[c]->count; i++) {
            const struct row *row = catalog_row(catalogs[c], i);
            const bool fits = c > 0 || model_offers(moving, observable_from(row));
            if (fits && (catalogs[c] != &setting_catalog || setting_is_number(row)))
                offer(context, row->name, row->brief);
        }
    for (int i = 0; i < session->setup.lets; i++)
        offer(context, session->setup.let[i].name, "variable");
    for (int i = 0; i < session->results.count; i++)
        offer(context, session->results.value[i].name, "result");
}

void names_each(const struct session *session,
                void (*offer)(void *context, const char *name, const char *brief), void *context)
{
    const struct run *run = session_run(session);
    offer_names(session, run ? run->system.model : session->setup.scene.model, offer, context);
}

/* Passes a name on to a struct suggestion, for offer_names(). */
static void suggest(void *context, const char *name, const char *brief)
{
    (void)brief;
    suggestion_offer(context, name);
}

/* Implements offer of struct expr_scope: candidates for a misspelled name. */
static void scope_offer(const void *context, struct suggestion *suggestion)
{
    const struct names *names = context;
    offer_names(names->session, state_model(names), suggest, suggestion);
    suggestion_offer(suggestion, "pi");
}

/* Implements moving of struct expr_scope: numbers what changes during a run (state, observations,
 * observables) as run_scope() does; -1 for what is constant. */
static int scope_moving(const void *context, int slot)
{
    const struct model *moving = state_model(context);
    const int index = slot & ((1 << SLOT_KIND) - 1);
    switch ((enum name_kind)(slot >> SLOT_KIND)) {
    case NAME_STATE:
        return index;
    case NAME_OBSERVED:
        return moving->n + index;
    case NAME_OBSERVABLE:
        return moving->n + model_observed(moving) + index;
    default:
        return -1;
    }
}

/* Implements quantity of struct expr_scope; that of an observation of a typed scene is unknown. */
static enum quantity scope_quantity(const void *context, int slot)
{
    return slot >> SLOT_KIND == NAME_OBSERVED ? QUANTITY_OTHER : slot_value(context, slot).quantity;
}

struct expr_scope names_scope(const struct names *names)
{
    return (struct expr_scope){names,       scope_find,   scope_load,
                               scope_offer, scope_moving, scope_quantity};
}

/* Returns the index of the parameter or derived quantity that a slot means, or -1. Sets *derived to
 * true for a derived quantity. */
int names_of_scene(int slot, bool *derived)
{
    const int kind = slot >> SLOT_KIND;
    *derived = kind == NAME_DERIVED;
    return *derived || kind == NAME_PARAM ? slot & ((1 << SLOT_KIND) - 1) : -1;
}

/* Sets *value to value, uncertainty and quantity of a name. If it is a variable of the current run,
 * also sets value->error_floor: a value smaller than that has no certain digit. Returns false if
 * the name is unknown. */
bool names_value(const struct session *session, struct text name, struct named_value *value)
{
    const struct names names = {.session = session, .letters = true};
    int slot;
    if (!find_name(&names, name, &slot))
        return false;
    *value = slot_value(&names, slot);
    const struct run *run = session_run(session);
    if (run && slot >> SLOT_KIND == NAME_STATE && run->system.model == state_model(&names)) {
        double magnitude_floor[LIMIT_VARIABLES];
        run_below_tolerance(run, magnitude_floor);
        value->error_floor = magnitude_floor[slot & ((1 << SLOT_KIND) - 1)];
    }
    return true;
}

/* Replaces the error about the name error->where, if it exists elsewhere or later, by the reason
 * why it has no value here and by a hint. Always returns false. */
bool names_explain(const struct session *session, struct error *error)
{
    static const struct {
        const char *start, *command;
    } later[] = {{"measured_", "measure period"}, {"fit_", "fit"}};
    const struct text name = error->where;
    const struct names names = {.session = session};
    int slot;
    if (find_name(&names, name, &slot))
        return false;
    const struct model *model = session->setup.scene.model;
    if (lacks_energy(session_run(session), model_observable(model, name))) {
        error_at(error, name, "'%.*s' has no value: the typed forces have no potential",
                 (int)name.len, name.data);
        return error_hint(error, "the kinetic energy is called kinetic");
    }
    if (model_observable(model, name) || model_variable(model, name) >= 0 ||
        model_observation(model, name) >= 0) {
        error_at(error, name, "'%.*s' has no value: there is no run yet", (int)name.len, name.data);
        return error_hint(error, "type: run");
    }
    for (size_t i = 0; i < COUNT_OF(later); i++)
        if (text_starts(name, text_of(later[i].start)) && !error->hint[0])
            return error_hint(error, "type: %s (or another command that gives it a value)",
                              later[i].command);
    if (!error->hint[0])
        hint_other_model(session, name, error);
    return false;
}

/* Returns the quantity of a name, or QUANTITY_OTHER if it is unknown. */
enum quantity name_quantity(const struct expr_scope *scope, struct text name)
{
    int slot;
    return scope && find_name(scope->context, name, &slot)
               ? slot_value(scope->context, slot).quantity
               : QUANTITY_OTHER;
}

/* Returns true if the scene has that name, with its kind in *kind. */
bool scene_has_name(const struct scene *scene, struct text name, const char **kind)
{
    const struct catalog *const catalogs[] = {scene_params(scene), scene_derived(scene)};
    for (size_t i = 0; i < COUNT_OF(catalogs); i++)
        if (catalog_find(catalogs[i], name)) {
            *kind = catalogs[i]->kind;
            return true;
        }
    int index;
    *kind = "state variable";
    if (in_state(scene->model, name, &index))
        return true;
    *kind = "observed quantity";
    return model_observation(scene->model, name) >= 0;
}

/* Returns true if a variable of let cannot have that name, with the kind of its owner in *kind. */
bool name_is_taken(const struct session *session, struct text name, const char **kind)
{
    const struct catalog *const catalogs[] = {&setting_catalog, &observable_catalog,
                                              &function_catalog};
    int index;
    if (scene_has_name(&session->setup.scene, name, kind))
        return true;
    for (size_t i = 0; i < COUNT_OF(catalogs); i++)
        if (catalog_find(catalogs[i], name)) {
            *kind = catalogs[i]->kind;
            return true;
        }
    *kind = in_values(session->results.value, session->results.count, name, &index) ? "result"
                                                                                    : "constant";
    return text_is(name, "pi") ||
           in_values(session->results.value, session->results.count, name, &index);
}
