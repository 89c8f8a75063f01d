/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names of everything that expressions may use: parameters, variables, observables and others. */
#pragma once

#include <hooke/session.h>

struct observable;

/* ---- what a scene has, by name ---- */

/* Appends the scene's lines as typed, each after `prefix`. */
void scene_lines(const struct scene *scene, const char *prefix, struct buffer *text);
/* The same, each before `end`, in an order in which they can be typed: a line may use one that was
 * typed after it, where it has taken the place of another. */
void scene_script(const struct scene *scene, const char *end, struct buffer *text);
/* "atol y = 0.1 mm", of one variable; the absolute tolerances that were given, as scene_script().
 */
void atol_describe(const struct scene *scene, int variable, struct buffer *text);
void atol_script(const struct scene *scene, const char *end, struct buffer *text);
/* Returns the index of a variable, or -1 if there is none; y' is vy of a typed model. */
int model_variable(const struct model *model, struct text name);
/* Returns the index of an observation of a typed model, or -1 if there is none. */
int model_observation(const struct model *model, struct text name);
/* the first with such a parameter, derived quantity or variable */
const struct model *model_with(struct text name);
enum quantity model_quantity(const struct model *model, const struct observable *observable);
/* Returns NULL if there is none. In a typed model `y` is no other name of the first coordinate. */
const struct observable *model_observable(const struct model *model, struct text name);
/* as far as the model decides it */
bool model_offers(const struct model *model, const struct observable *observable);
/* Adds a hint if the name belongs to another model; returns false if it does not. */
bool hint_other_model(const struct session *session, struct text name, struct error *error);
/* Finds a scene of the user's own by its name; returns NULL if there is none. */
const struct preset *own_scene(const struct setup *setup, struct text name);
/* Returns the parameter that is the start of a variable, such as y0 of y, or NULL if there is none.
 * x, y, z, q and u stand for the first variable if no variable is called so. */
const char *start_of(const struct session *session, struct text name);
/* value: what it was to become, as `= 5 cm`, or nothing. False, always. */
bool unknown_parameter(const struct session *session, struct text name, struct text value,
                       struct error *error);

/* ---- names in expressions ---- */

/* The scene of a run that goes on, with what was changed on the way. */
struct in_force {
    const struct run_slot *slot;
    bool known; /* `scene` is there, as of this end of its journal */
    const struct request *last;
    struct scene scene;
};

struct names {
    const struct session *session;
    struct in_force *in_force; /* owner of the parameters; NULL for those of the set-up */
    /* state and observables are known although there is no run yet: it is about to start */
    bool expects_run;
    /* Excludes variables and results, so that the meaning is the same when a saved session is read
     * again. */
    bool saved_only;
    /* T and A may name the newest period and amplitude. Not where an unknown name has a meaning of
     * its own, such as a parameter of a fit. */
    bool letters;
    const struct run *run; /* owner of state and observables; NULL for the current run */
};

struct expr_scope names_scope(const struct names *names);
/* Returns the index of the scene's parameter, or derived quantity, in a slot of that scope, or -1
 * if the slot is something else. */
int names_of_scene(int slot, bool *derived);
/* Called after a failed compilation: explains what has to be done first if the unknown name is that
 * of something that does not exist yet. Always returns false. */
bool names_explain(const struct session *session, struct error *error);
/* Finds value, uncertainty and quantity of one name; returns false if it is unknown. */
bool names_value(const struct session *session, struct text name, struct named_value *value);
/* Returns the quantity of a name in a scope made by names_scope(), or QUANTITY_OTHER if it is
 * unknown. */
enum quantity name_quantity(const struct expr_scope *scope, struct text name);
/* Everything that can be named: offers candidates for completion and help. */
void names_each(const struct session *session,
                void (*offer)(void *context, const char *name, const char *brief), void *context);
bool name_is_taken(const struct session *session, struct text name, const char **kind);
/* Looks only at the scene: a parameter, a derived quantity, a variable or an observation. */
bool scene_has_name(const struct scene *scene, struct text name, const char **kind);
