/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What can be called by name: parameters, variables, observables, and all that expressions may use.
 */
#ifndef HOOKE_SESSION_NAMES_H
#define HOOKE_SESSION_NAMES_H

#include <hooke/session.h>

struct observable;

/* ---- what a scene has, by name ---- */

/* What was typed, a line each after `before`. */
void scene_lines(const struct scene *scene, const char *before, struct buffer *text);
/* The same, each before `end`, in an order in which they can be typed: a line may use one that was
 * typed after it, where it has taken the place of another. */
void scene_script(const struct scene *scene, const char *end, struct buffer *text);
/* "atol y = 0.1 mm", of one variable; the absolute tolerances that were given, as scene_script().
 */
void atol_describe(const struct scene *scene, int variable, struct buffer *text);
void atol_script(const struct scene *scene, const char *end, struct buffer *text);
/* place, -1: none; y' is vy of a typed model */
int model_variable(const struct model *model, struct text name);
/* place of what a typed model observes, -1: none */
int model_observation(const struct model *model, struct text name);
/* the first with such a parameter, derived quantity or variable */
const struct model *model_with(struct text name);
enum quantity model_quantity(const struct model *model, const struct observable *observable);
/* NULL: none. In what a user has typed `y` is no other name of the first coordinate. */
const struct observable *model_observable(const struct model *model, struct text name);
/* as far as the model decides it */
bool model_offers(const struct model *model, const struct observable *observable);
/* Says where the name belongs, if it is to another model; false: it does not. */
bool hint_other_model(const struct session *session, struct text name, struct error *error);
/* A scene of the user's own, by its name; NULL: there is none. */
const struct preset *own_scene(const struct setup *setup, struct text name);
/* The parameter that is the start of what moves, y0 of y; of x, too, where nothing is called so and
 * y moves; NULL: none. */
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
    struct in_force *in_force; /* whose parameters; NULL: those of the set-up */
    /* state and observables are known although there is no run yet: it is about to start */
    bool expects_run;
    /* without variables and results: what means the same when a saved session is read again */
    bool saved_only;
    const struct run *run; /* whose state and observables; NULL: those of the current run */
};

struct expr_scope names_scope(const struct names *names);
/* Of a slot of that scope: the place of a parameter, or a derived quantity, of the scene; -1: of
 * something else. */
int names_of_scene(int slot, bool *derived);
/* Value, uncertainty and quantity of one name; false: unknown. */
/* After a failed compilation: says what has to come first where the unknown name is that of
 * something not there yet. False, always. */
bool names_explain(const struct session *session, struct error *error);
bool names_value(const struct session *session, struct text name, struct named_value *value);
/* Of a name in a scope made by names_scope; QUANTITY_OTHER: unknown. */
enum quantity name_quantity(const struct expr_scope *scope, struct text name);
/* Everything that can be named: offers candidates for completion and help. */
void names_each(const struct session *session,
                void (*offer)(void *context, const char *name, const char *brief), void *context);
bool name_is_taken(const struct session *session, struct text name, const char **kind);
/* By the scene alone: a parameter, a derived quantity, a variable, what is observed. */
bool scene_has_name(const struct scene *scene, struct text name, const char **kind);

#endif
