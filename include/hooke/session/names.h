/* SPDX-License-Identifier: GPL-3.0-or-later */
/* names: the names that expressions may use (parameters, state variables, observables, results,
 * settings, …), in the scope of a session. */
#pragma once

#include <hooke/session.h>

struct observable;

/* ---- parameters, variables and observables of a scene, by name ---- */

/* Appends the typed lines of a scene for people to read, each preceded by `prefix`. */
void scene_lines(const struct scene *scene, const char *prefix, struct buffer *text);
/* Appends the typed lines of a scene as commands, each followed by `end`, in an order in which each
 * name is defined before a line uses it. */
void scene_script(const struct scene *scene, const char *end, struct buffer *text);
/* atol_describe() appends the absolute tolerance of one variable, "atol y = 0.1 mm"; atol_script()
 * those of all variables for which the user has set one, each followed by `end`. */
void atol_describe(const struct scene *scene, int variable, struct buffer *text);
void atol_script(const struct scene *scene, const char *end, struct buffer *text);
/* Returns the index of a state variable, or -1 if there is none; y' is the velocity of y. */
int model_variable(const struct model *model, struct text name);
/* Returns the index of an observed quantity of a typed model, or -1 if there is none. */
int model_observation(const struct model *model, struct text name);
/* Returns the first built-in model with a parameter, derived quantity or variable of this name, or
 * NULL. */
const struct model *model_with(struct text name);
/* Returns the quantity of an observable in scenes of this model. */
enum quantity model_quantity(const struct model *model, const struct observable *observable);
/* Returns the observable of this name in scenes of this model, or NULL if there is none. In a typed
 * model `y` does not stand for the first coordinate, as it does in others. */
const struct observable *model_observable(const struct model *model, struct text name);
/* Returns true if the observable can be defined for scenes of this model. */
bool model_offers(const struct model *model, const struct observable *observable);
/* Adds a hint to `error` and returns true if the name belongs to another model than the scene's. */
bool hint_other_model(const struct session *session, struct text name, struct error *error);
/* Returns the user's scene with this name, or NULL if there is none. */
const struct preset *own_scene(const struct setup *setup, struct text name);
/* Returns the name of the parameter that is the initial value of the variable `name`, such as y0 of
 * y, or NULL if there is none. If no variable is called x, y, z, q or u, each of these names stands
 * for the first variable. */
const char *start_of(const struct session *session, struct text name);
/* Sets an error about an unknown parameter `name`; `value` is the text that followed it, such as "=
 * 5 cm", or empty. Always returns false. */
bool unknown_parameter(const struct session *session, struct text name, struct text value,
                       struct error *error);

/* ---- names in expressions ---- */

/* The scene of a run with all changes of parameters so far, which is found from the run's journal
 * when it is needed, and stored until the journal changes. */
struct in_force {
    const struct run_slot *slot;
    bool known; /* `scene` is valid for the journal whose last request is `last`. */
    const struct request *last;
    struct scene scene;
};

/* Describes a scope of names. Set `session`; all other members may be 0. It must outlive the scope
 * that names_scope() makes from it. */
struct names {
    const struct session *session;
    /* Run whose parameters are used, or NULL for the parameters of the set-up. */
    struct in_force *in_force;
    /* A run is about to start: names of its state variables and observables are accepted, although
     * there is no run yet. */
    bool expects_run;
    /* Variables (`let`) and results of the user are unknown names. For texts that a saved session
     * contains, where they would not have the same meaning. */
    bool saved_only;
    /* T and A stand for the newest period and amplitude, unless these letters have another meaning.
     * False where unknown names are allowed, as parameters of a fit are. */
    bool letters;
    const struct run *run; /* Source of state and observables; NULL stands for the current run. */
};

/* Returns the scope, which refers to *names. */
struct expr_scope names_scope(const struct names *names);
/* Returns the index of a parameter, or of a derived quantity if it sets *derived to true, for a
 * slot of a scope made by names_scope(); -1 if the slot is that of another name. */
int names_of_scene(int slot, bool *derived);
/* Improves the error of a failed compilation: if the unknown name is one that exists only after
 * another command (such as `run` or `fit`), the error gets a hint that names that command. Always
 * returns false. */
bool names_explain(const struct session *session, struct error *error);
/* Finds value, uncertainty and quantity of a name. Returns false if it is unknown. */
bool names_value(const struct session *session, struct text name, struct named_value *value);
/* Returns the quantity of a name in a scope made by names_scope(), or QUANTITY_OTHER if it is
 * unknown. */
enum quantity name_quantity(const struct expr_scope *scope, struct text name);
/* Calls offer() for every name with a short description, for completion and help. */
void names_each(const struct session *session,
                void (*offer)(void *context, const char *name, const char *brief), void *context);
/* Returns true if the name already has a meaning other than a variable of the user (`let`), and
 * sets *kind to its kind: "parameter", "setting", … */
bool name_is_taken(const struct session *session, struct text name, const char **kind);
/* Returns true if a scene defines this name (parameters, derived quantities, state variables,
 * observed quantities), and sets *kind to its kind. */
bool scene_has_name(const struct scene *scene, struct text name, const char **kind);
