/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands fit and adopt: dispatch to the kinds of fit, and fits of one oscillation. */
#include "modules/recording/fit/fit.h"
#ifndef COMMAND_ROWS
#include "modules/recording/fit_text.h"
#include "modules/recording/fits.h"
#include <hooke/command/handler.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

bool known_mass(const struct scene *scene, struct measured *mass)
{
    const int m = scene_param(scene, "m");
    if (m < 0 || !scene->chosen[m])
        return false;
    *mass = (struct measured){scene->value[m], scene->uncertainty[m]};
    return true;
}

/* Stores a fit of an oscillation in the session, for the report and as results (fit_period and so
 * on). k, the spring constant, is NULL if unknown; inputs are the values that were taken as
 * exact. */
static void keep_fit(struct session *session, const struct subject *subject, const struct fit *fit,
                     const struct measured *k, const struct inputs *inputs)
{
    const enum quantity quantity = subject->series.quantity;
    const struct measured unknown = {NAN, NAN};
    const struct {
        const char *name;
        struct measured value;
        enum quantity quantity;
    } results[] = {
        {"fit_period", fit->period, QUANTITY_TIME},
        {"fit_omega", fit->omega, QUANTITY_ANGULAR_FREQUENCY},
        {"fit_gamma", fit->gamma, QUANTITY_RATE},
        {"fit_amplitude", fit->amplitude, quantity},
        {"fit_phase", fit->phase, QUANTITY_ANGLE},
        {"fit_offset", fit->offset, quantity},
        {"fit_rms", {fit->rms, 0}, quantity},
        {"fit_k", k ? *k : unknown, QUANTITY_STIFFNESS},
    };
    struct fits *fits = fits_made(session);
    fits_drop_curve(fits);
    fits->fit = *fit;
    fits->has_fit = true;
    fits->fit_zero = subject->recording ? subject->recording->zero : 0;
    struct stored_fit stored = {.fit = *fit, .quantity = quantity, .k = k ? *k : unknown};
    inputs_keep(inputs, &stored.exact);
    memcpy(stored.subject, subject->name, sizeof stored.subject);
    session_store_fit(session, &stored);
    memcpy(fits->fit_of, subject->name, sizeof fits->fit_of);
    for (size_t i = 0; i < COUNT_OF(results); i++)
        if (isfinite(results[i].value.value))
            session_set_result(session, results[i].name, results[i].value, results[i].quantity);
}

/* Sets the error of a fit that did not converge. Returns false. */
static bool not_converged(const char *why, struct error *error)
{
    error_set(error, ERROR_NUMERICAL, "the fit %s", why);
    return error_hint(error, "choose a window where the motion is regular: fit window=FROM:TO");
}

/* Returns false with the error if there are arguments that the model has no use for: start values,
 * free=, bootstrap or robust outside of 'fit scene', or a number outside of 'fit modes'. */
static bool refuse_others(const struct fit_request *call, const struct fit_model *model,
                          struct error *error)
{
    static const char *const others[] = {"free", "NAME", "bootstrap", "robust"};
    const char *name = model->row.name;
    for (size_t i = 0; i < COUNT_OF(others) && model->kind != FIT_SCENE; i++)
        if (has_argument(call->args, others[i])) {
            error->where = argument_value(call->args, others[i])->where;
            error_set(error, ERROR_COMMAND,
                      "'fit %s' needs no start values and chooses its free parameters itself",
                      name);
            return error_hint(
                error,
                "only 'fit scene' and 'fit EXPR' take start values, free=, bootstrap and robust");
        }
    if (model->kind != FIT_MODES && has_argument(call->args, "COUNT")) {
        error_at(error, argument_value(call->args, "COUNT")->where, "'fit %s' cannot have a number",
                 name);
        return error_hint(error, "for several frequencies: fit modes 2");
    }
    return true;
}

/* Fits the subject by a model of oscillations, stores the fit and replies with it. The spring
 * constant is computed if the scene is a spring whose mass is known. Returns false with the error,
 * also if the fit does not converge. */
static bool fit_motion(const struct fit_request *call, const struct fit_model *model,
                       struct error *error)
{
    struct session *session = call->session;
    const struct subject *subject = call->subject;
    struct arena *arena = call->args->arena;
    struct fit fit = {0};
    if (!model->fit(&subject->series, arena, session->front.cancel, &fit, error))
        return false;
    struct measured mass, stiffness = {NAN, NAN};
    const struct scene *scene = &session->setup.scene;
    /* A spring constant has a meaning only for the motion of a spring. */
    const bool spring = scene->model == &oscillator_model &&
                        (!subject->run || subject->run->system.model == &oscillator_model);
    const bool with_k = spring && known_mass(scene, &mass);
    if (with_k)
        stiffness = fit_stiffness(&fit, mass);
    struct fit_summary summary = {
        .subject = subject, .model = fit.model, .motion = &fit, .k = stiffness, .spring = spring};
    if (with_k)
        inputs_use(&summary.inputs, "m", mass);
    if (fit.converged)
        keep_fit(session, subject, &fit, with_k ? &stiffness : NULL, &summary.inputs);
    for (int i = 0; i < fit.warnings; i++)
        fit_add_warning(&summary, "%s", fit.warning[i]);
    fit_add_window(&summary, fit.drag.candidates > 0 ? WINDOW_LAW_STICKS : WINDOW_LAW_SINE, arena);
    reply_fit(&summary, arena, call->reply);
    char why[64];
    snprintf(why, sizeof why, "did not converge in %d iterations", fit.iterations);
    return fit.converged || not_converged(why, error);
}

/* Sets fits->live, so that the recording which is being collected, or the next one, is fitted every
 * second. Returns false with the error for arguments that cannot be combined with --live. */
static bool fit_while_collecting(struct session *session, const struct arguments *args,
                                 struct reply *reply, struct error *error)
{
    const struct argument_value *model = argument_value(args, "MODEL");
    for (int i = 0; i < args->command->arguments; i++)
        if (args->value[i].count > 0 && &args->value[i] != model &&
            &args->value[i] != argument_value(args, "live"))
            return error_at(error, args->value[i].where,
                            "--live fits everything collected and cannot have other arguments");
    if (model->count && model->item->row != catalog_row(&fit_catalog, 0))
        return error_at(error, model->where,
                        "--live works only with a damped sine: fit damped --live");
    struct fits *fits = fits_make(session, error);
    if (!fits)
        return false;
    fits->live = true;
    reply_line(reply, session->growing
                          ? "fitted every second while data are collected; see the state line"
                          : "the next recording is fitted every second while it is collected");
    return true;
}

/* Opens the subject and calls the function for a formula or for the kind of the model. */
HANDLER(fit)
{
    if (added_argument(args, "live"))
        return fit_while_collecting(session, args, reply, error);
    const struct argument_value *model = argument_value(args, "MODEL"),
                                *run = argument_value(args, "run"),
                                *target = argument_value(args, "to");
    struct subject subject;
    /* The current recording is fitted, unless there is none or a run is named. */
    struct item current = {.index = session->current_recording};
    const struct argument_value data = target->count || current.index < 0
                                           ? *target
                                           : (struct argument_value){.count = 1, .item = &current};
    const bool formula = model->count && !model->item->row;
    if (!fits_make(session, error) ||
        !subject_open(session, run, &data, argument_value(args, "window"), false, formula ? 2 : 8,
                      args->arena, &subject, error))
        return false;
    const struct fit_request call = {session, args, &subject, reply};
    if (formula)
        return fit_a_formula(&call, model->item->text, error);
    const struct row *row = model->count ? model->item->row : catalog_row(&fit_catalog, 0);
    const struct fit_model *chosen = fit_model_from(row);
    if (!refuse_others(&call, chosen, error))
        return false;
    struct measured mass;
    if (chosen->kind == FIT_MODES)
        return fit_the_modes(&call, known_mass(&session->setup.scene, &mass) ? &mass : NULL, error);
    return chosen->kind == FIT_SCENE ? fit_the_scene(&call, error)
                                     : fit_motion(&call, chosen, error);
}

HANDLER(adopt)
{
    return adopt_fit(session, args, reply, error);
}
#endif

COMMAND(fit, .group = "DATA", .flags = COMMAND_TABLES | COMMAND_BESIDE,
        ARGUMENTS(PLACE("MODEL", TYPE_MODEL, .choices = &fit_catalog), PLACE("COUNT", TYPE_INTEGER),
                  WORD("to", TYPE_RECORDING, .group = 1), WORD("run", TYPE_RUN, .group = 1),
                  KEY("window", TYPE_RANGE, .quantity = QUANTITY_TIME),
                  KEY("free", TYPE_PARAM, .flags = ARG_MANY),
                  KEY("NAME", TYPE_START, .flags = ARG_MANY | ARG_NEGATIVE),
                  OPTION("robust", TYPE_NONE), OPTION("bootstrap", TYPE_INTEGER),
                  FIT_ARGUMENTS OPTION("full", TYPE_NONE)))

COMMAND(adopt, .group = "DATA", .flags = COMMAND_CHANGES | COMMAND_TABLES,
        ARGUMENTS(WORD("amplitude", TYPE_NONE),
                  KEY("scale", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_OTHER)))
