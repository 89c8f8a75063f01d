/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command adopt: takes the values of the last fit into the scene, and compares a run of it with
 * the recording. */
#include <hooke/base/unit.h>
#include <hooke/plot.h>
#include "modules/recording/fit_text.h"
#include <hooke/command/handler.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- what was taken ---- */

/* Largest number of adopted values, and of terms that the scene cannot represent. */
enum { ADOPTED_MAX = LIMIT_VARIABLES + 16, LEFT_OUT_MAX = 4 };

/* The state of an adoption. */
struct adoption {
    struct session *session;
    struct scene scene; /* the scene with the adopted values */
    struct adopted {
        char name[LIMIT_NAME + 1];
        struct measured value;
        enum quantity quantity;
    } taken[ADOPTED_MAX];
    int count;
    const char *left_out[LEFT_OUT_MAX];
    int left; /* number of terms that are left out */
    int data; /* index of the recording that was fitted, or -1 */
    /* The adopted motion starts where the fit does, so that it can be compared with the
     * recording. */
    bool as_on_data;
    struct inputs inputs; /* values that entered besides the fit */
    bool pendulum;        /* the scene is a pendulum, not a mass on a spring */
    bool unscaled;        /* true if the fit is in volts or newtons and their scale is unknown */
};

/* Sets a parameter of the scene and adds it to the list. Returns false with the error if it is
 * outside of its range. */
static bool adopt_value(struct adoption *a, const char *name, struct measured value,
                        struct error *error)
{
    const int index = scene_param(&a->scene, name);
    value.uncertainty = isfinite(value.uncertainty) ? value.uncertainty : 0;
    if (!scene_set(&a->scene, index, value, error))
        return false;
    if (a->count < ADOPTED_MAX) {
        struct adopted *taken = &a->taken[a->count++];
        snprintf(taken->name, sizeof taken->name, "%s", name);
        taken->value = value;
        taken->quantity = param_at(&a->scene, index)->quantity;
    }
    return true;
}

/* Makes the scene the session's, and stores it as adopted. */
static void store_adopted(const struct adoption *a)
{
    struct fits *fits = fits_made(a->session);
    a->session->setup.scene = a->scene;
    fits->adopted = (struct adopted_fit){.scene = a->scene, .statement = a->session->history.count};
    inputs_keep(&a->inputs, &fits->adopted.exact);
    memcpy(fits->adopted.subject, fits->fit_of, sizeof fits->adopted.subject);
}

/* Notes a term that the scene cannot represent. */
static void omit_term(struct adoption *a, const char *what)
{
    if (a->left < LEFT_OUT_MAX)
        a->left_out[a->left++] = what;
}

/* ---- the proof ---- */

#define RMS_RATIO_MAX 1.2 /* largest rms of the run relative to that of the fit */
/* Part of the amplitude that the run's own errors may add. */
#define RUN_ERROR_AMPLITUDE_FRACTION 1e-8
#define SMALL_SWING 0.1 /* [rad] wider swings are slower by more than amplitude^2/16 = 0.06 % */

/* Returns the rms difference between the recording and a run of the scene over the window of the
 * fit, or NAN if they cannot be compared or it was cancelled. */
static double rms_of_run(const struct adoption *a)
{
    const struct session *session = a->session;
    struct run *run =
        a->data >= 0 && a->as_on_data
            ? study_run(&a->scene, fits_of(session)->fit.window[1], session->front.cancel)
            : NULL;
    const double rms =
        run ? run_data_distance(run, session->recording[a->data]->recording).rms : NAN;
    run_destroy(run);
    return rms;
}

/* Warns that the run with the adopted values differs from the data by the given rms, with the
 * likely reason: what the scene cannot represent, or what the fit does not include. */
static void warn_apart(const struct adoption *a, double rms, struct reply *reply)
{
    const struct fit *fit = &fits_of(a->session)->fit;
    struct buffer text = {0};
    buffer_format(&text, "the rms of the run is %.2g times that of the fit: ", rms / fit->rms);
    if (a->left > 0)
        for (int i = 0; i < a->left; i++)
            buffer_format(&text, "%s%s", i ? ", " : "the scene cannot represent ", a->left_out[i]);
    else if (param_value(&a->scene, "C") > 0 && fit->drag.candidates == 0)
        buffer_put(
            &text,
            TEXT("the scene has quadratic drag, which this fit does not include (use 'fit drag')"));
    else if (param_value(&a->scene, "F0") > 0 || fabs(param_value(&a->scene, "k3")) > 0)
        buffer_put(&text, TEXT("the scene has forces that the fit does not include"));
    else
        buffer_put(&text, TEXT("the fitted curve is not a motion of this scene"));
    reply_warning(reply, "%s", text.data ? text.data : "");
    buffer_free(&text);
}

/* Runs the scene with the adopted values, compares the run with the recording, and adds text and
 * record `adopt` to the reply, with a warning if they disagree. `text` already lists the adopted
 * values. */
static void reply_adoption(const struct adoption *a, struct buffer *text, struct reply *reply)
{
    const struct fit *fit = &fits_of(a->session)->fit;
    const double rms = rms_of_run(a), allowed = RMS_RATIO_MAX * fit->rms +
                                                RUN_ERROR_AMPLITUDE_FRACTION * fit->amplitude.value;
    const struct recording *recording =
        a->data >= 0 ? a->session->recording[a->data]->recording : NULL;
    const enum quantity quantity =
        recording ? recording->column[recording->value].quantity : QUANTITY_LENGTH;
    if (isfinite(rms)) {
        buffer_format(text, "\nrms of the run %s, of the fit %s", SHOWN_QUANTITY(rms, quantity, 3),
                      SHOWN_QUANTITY(fit->rms, quantity, 3));
        const struct method *method = a->session->setup.method;
        if (!a->session->setup.method_chosen && method->order < 4)
            buffer_format(text, " (exact integration; %s is less accurate, so use 'method rk4')",
                          method->row.name);
    }
    inputs_put(&a->inputs, text);
    reply_text(reply, buffer_text(text));
    reply_begin(reply, "adopt");
    reply_object(reply, "parameters");
    for (int i = 0; i < a->count; i++)
        reply_measured(reply, a->taken[i].name, a->taken[i].value, a->taken[i].quantity);
    reply_close(reply);
    reply_array(reply, "left_out");
    for (int i = 0; i < a->left; i++)
        reply_string(reply, NULL, a->left_out[i]);
    reply_close(reply);
    inputs_reply(&a->inputs, reply);
    reply_real(reply, "rms_fit", fit->rms);
    reply_real(reply, "rms_run", rms);
    if (isfinite(rms))
        reply_bool(reply, "agrees", rms <= allowed);
    else
        reply_null(reply, "agrees");
    reply_end(reply);
    if (recording && recorded_bare(recording)) {
        struct buffer lacks = {0};
        put_bare(recording, &lacks);
        reply_warning(
            reply,
            "%s %s: its numbers were taken as metres or radians ('load FILE unit=cm' changes that)",
            recording->name, buffer_view(&lacks));
        buffer_free(&lacks);
    }
    if (rms > allowed)
        warn_apart(a, rms, reply);
}

/* Appends the adopted values. */
static void put_taken(const struct adoption *a, struct buffer *text)
{
    for (int i = 0; i < a->count; i++) {
        buffer_put(text, i ? TEXT("  ") : TEXT(""));
        put_value(text, a->taken[i].name, a->taken[i].value, a->taken[i].quantity, a->data >= 0);
    }
}

/* Returns how often a position was differentiated to give the quantity, or a negative number for
 * others. Numbers without a unit count as positions. */
static int derivative_order(enum quantity quantity)
{
    return quantity == QUANTITY_OTHER ? 0 : quantity_order(quantity);
}

/* Returns true for an angle and its derivatives by time. */
static bool is_turning(enum quantity quantity)
{
    return quantity == QUANTITY_ANGLE || quantity == QUANTITY_ANGULAR_FREQUENCY ||
           quantity == QUANTITY_ANGULAR_ACCELERATION;
}

/* Returns the index of the recording that was fitted, or -1 if there was none or it was removed. */
static int fitted_recording(const struct session *session)
{
    const struct text source = text_of(fits_of(session)->fit_of);
    return text_starts(source, TEXT("data "))
               ? session_find_recording(session, text_after(source, 5))
               : -1;
}

/* Executes `adopt` after `fit scene`: sets the fitted parameters, the zero of the recording and
 * their uncertainties in the session's scene, and replies. Returns false with *error for fits of
 * modes or formulas, or of another scene. */
static bool adopt_curve(struct session *session, const struct arguments *args, struct reply *reply,
                        struct error *error)
{
    struct scene scene = session->setup.scene;
    struct fits *fits = fits_made(session);
    const struct scene *fitted = &fits->fit_scene;
    if (fits->fit_modes > 0) {
        error_set(error, ERROR_COMMAND,
                  "a fit of several modes cannot be adopted by a scene with one spring and mass");
        return error_hint(error,
                          "type the equations of the coupled system, then: fit scene free=..");
    }
    if (!fitted->model) {
        error_set(error, ERROR_COMMAND,
                  "a fitted formula has no values that the scene could adopt");
        return error_hint(error, "type: fit, or: fit scene");
    }
    if (fitted->model != scene.model)
        return error_set(error, ERROR_COMMAND, "the fit belongs to %s, but the scene is %s",
                         fitted->preset->row.name, scene.preset->row.name);
    if (has_argument(args, "amplitude"))
        return error_set(error, ERROR_COMMAND,
                         "'adopt amplitude' works only after a fit of a damped oscillation");
    struct buffer text = {0};
    struct adoption a = {
        .session = session, .scene = scene, .data = fitted_recording(session), .as_on_data = true};
    const int t0 = scene_param(fitted, "t0");
    for (int i = 0; i < (int)scene_params(&scene)->count; i++) {
        if (!fits->fit_free[i] && (i != t0 || scene.value[i] == fitted->value[i]))
            continue;
        const struct measured value = {fitted->value[i],
                                       fits->fit_free[i] ? fitted->uncertainty[i] : 0};
        if (!adopt_value(&a, param_at(&scene, i)->row.name, value, error))
            return false;
    }
    inputs_use_motion(&a.inputs, fitted, fits->fit_free);
    store_adopted(&a);
    adopted_free(fits->fit_free, &fits->fit.covariance, &fits->adopted.known);
    put_taken(&a, &text);
    if (a.data >= 0 && fits->fit.offset.value != 0) {
        struct recording *recording = session->recording[a.data]->recording;
        recording->zero = fits->fit_zero + fits->fit.offset.value;
        put_value(&text, "\nzero of the recording", (struct measured){recording->zero, 0},
                  recording->column[recording->value].quantity, true);
        buffer_put(&text, TEXT(" (the offset of the fit)"));
    }
    session_changed(session);
    reply_adoption(&a, &text, reply);
    buffer_free(&text);
    return true;
}

/* ---- of an oscillation ---- */

/* Returns a coefficient of the scene that was computed from a fitted rate and these parameters,
 * with their uncertainties, and notes them as inputs. */
static struct measured converted_rate(struct adoption *a, struct measured rate, const char *names)
{
    struct inputs used = {.exacts = 0};
    inputs_use_params(&used, &a->scene, names);
    if (rate.value != 0)
        inputs_use_params(&a->inputs, &a->scene, names);
    return inputs_widen(&used, rate);
}

/* Adopts all rates of the fitted law of damping; a rate that the law lacks is set to 0. `value` are
 * the adopted values of the restoring force. Effects that the scene cannot represent are noted as
 * left out. Returns false with the error. */
static bool take_law(struct adoption *a, const struct fit *fit, const struct measured *value,
                     struct error *error)
{
    if (fit->drag.candidates == 0) {
        const bool decays = isfinite(fit->gamma.value);
        return adopt_value(a, "gamma", decays ? fit->gamma : (struct measured){0, 0}, error);
    }
    const struct drag_candidate *law = &fit->drag.candidate[fit->drag.best - 1];
    if (a->unscaled) {
        if (law->law & (LAW_QUADRATIC | LAW_DRY))
            omit_term(a, "quadratic drag and dry friction without a scale");
        if (fit->drag.force == RESTORING_CUBIC)
            omit_term(a, "a cubic spring without a scale");
        return adopt_value(a, "gamma", law->rate[0], error);
    }
    if ((fit->drag.force == RESTORING_CUBIC || param_value(&a->scene, "k3") != 0) &&
        scene_param(&a->scene, "k3") >= 0 &&
        !adopt_value(a, "k3", converted_rate(a, value[ADOPTED_CUBIC], "m"), error))
        return false;
    const bool quadratic = law->law & LAW_QUADRATIC, dry = law->law & LAW_DRY;
    if (!adopt_value(a, "gamma", law->rate[0], error))
        return false;
    if (quadratic && !(param_value(&a->scene, "rho") * param_value(&a->scene, "area") > 0))
        omit_term(a, a->pendulum ? "quadratic drag" : "quadratic drag (rho or area is 0)");
    else if ((quadratic || param_value(&a->scene, "C") > 0) &&
             !adopt_value(a, "C", converted_rate(a, value[ADOPTED_QUADRATIC], "m rho area"), error))
        return false;
    if (scene_param(&a->scene, "friction") < 0) {
        if (dry)
            omit_term(a, "dry friction");
        return true;
    }
    return !(dry || param_value(&a->scene, "friction") > 0) ||
           adopt_value(a, "friction",
                       converted_rate(a, value[ADOPTED_DRY], a->pendulum ? "m g" : "m"), error);
}

/* Adopts the spring constant of the fit, or the length of the pendulum. Returns false with the
 * error. */
static bool take_force(struct adoption *a, const struct measured *value, struct error *error)
{
    if (a->pendulum && !(param_value(&a->scene, "g") > 0))
        return error_set(error, ERROR_COMMAND,
                         "the length of a pendulum needs its gravity: g = 9.81 m/s^2");
    inputs_use_params(&a->inputs, &a->scene, a->pendulum ? "g" : "m g");
    return a->pendulum ? adopt_value(a, "length", value[ADOPTED_LENGTH], error)
                       : adopt_value(a, "k", value[ADOPTED_STIFFNESS], error);
}

/* Adopts the start of the motion at t0. */
static bool take_start(struct adoption *a, const struct measured *value, double t0,
                       struct error *error)
{
    const bool taken = a->pendulum ? adopt_value(a, "theta0", value[ADOPTED_ANGLE], error) &&
                                         adopt_value(a, "rate0", value[ADOPTED_TURNING], error)
                                   : adopt_value(a, "y0", value[ADOPTED_POSITION], error) &&
                                         adopt_value(a, "v0", value[ADOPTED_VELOCITY], error);
    return taken && adopt_value(a, "t0", (struct measured){t0, 0}, error);
}

/* Returns false with the error if the scene cannot represent the fit's restoring force. */
static bool can_have_spring(const struct scene *scene, const struct fit *fit, struct error *error)
{
    if (fit->drag.force != RESTORING_SINE)
        return needs_spring(scene, "adopt", error);
    error_set(error, ERROR_COMMAND, "the fit belongs to a pendulum, but the scene %s is not one",
              scene->preset->row.name);
    return error_hint(error, "type: scene pendulum; adopt");
}

/* Sets *scale to the position [m, rad] per unit of a fitted voltage or force: the value of the
 * option scale=, or the scale at which the fitted motion has the amplitude of the scene's, which is
 * 0 for a scene at rest. Returns false with the error. */
static bool find_scale(const struct adoption *a, const struct fit *fit,
                       const struct argument_value *args, double *scale, struct error *error)
{
    const enum quantity needs = a->pendulum ? QUANTITY_ANGLE : QUANTITY_LENGTH;
    if (args->count > 0) {
        *scale = args->item->value.value;
        if (args->item->quantity == needs && *scale != 0)
            return true;
        return error_at(error, args->item->text, "scale needs %s %s other than 0",
                        quantity_article(needs), quantity_name(needs));
    }
    *scale = adopted_scale_of(&a->scene, fit);
    return true;
}

/* Appends the scale, position per unit of `quantity`, and how it was found: by the option scale= if
 * `option`, otherwise from the scene's amplitude. */
static void put_scaled(const struct adoption *a, const struct fit *fit, double scale,
                       enum quantity quantity, bool option, struct buffer *text)
{
    const enum quantity position = a->pendulum ? QUANTITY_ANGLE : QUANTITY_LENGTH;
    const char *unit = quantity_unit(quantity);
    buffer_format(text, "\nwith 1 %s = %s", unit, SHOWN_QUANTITY(scale, position, 4));
    if (option)
        return;
    buffer_format(text,
                  ": the fitted amplitude is %s %s, not %s %s; the scene keeps its amplitude, %s "
                  "('adopt scale=..' sets what 1 %s is)",
                  quantity_article(quantity), quantity_name(quantity), quantity_article(position),
                  quantity_name(position),
                  SHOWN_QUANTITY(fit->amplitude.value * scale, position, 4), unit);
    if (fit->drag.candidates > 0 && (fit->drag.best & (LAW_QUADRATIC | LAW_DRY)))
        buffer_put(text, TEXT("\nquadratic drag and dry friction are computed with that scale"));
}

/* Warns of fitted values that the scene does not adopt, and of effects that the fit does not
 * include. `starts` means that the initial state was adopted, `scaled` that a voltage or force was
 * fitted, of which `quantity` is the quantity. */
static void warn_left(const struct adoption *a, const struct fit *fit, bool starts, bool scaled,
                      enum quantity quantity, struct reply *reply)
{
    if (a->unscaled && a->left > 1)
        reply_warning(reply, "the scene cannot represent %s, %s", a->left_out[0], a->left_out[1]);
    else if (a->unscaled && a->left > 0)
        reply_warning(reply, "the scene cannot represent %s", a->left_out[0]);
    if (!starts && scaled)
        reply_warning(reply,
                      "y0, v0 and t0 are unchanged: the scene is at rest and the size of 1 %s is "
                      "unknown ('adopt scale=..' sets it)",
                      quantity_unit(quantity));
    else if (!starts)
        reply_warning(reply,
                      "y0, v0 and t0 are unchanged: the fitted quantity (%s) is not a position, "
                      "velocity or acceleration",
                      quantity_name(quantity));
    if (a->pendulum && fit->drag.force != RESTORING_SINE && fit->amplitude.value > SMALL_SWING)
        reply_warning(
            reply,
            "the fit ignores that wide swings of a pendulum are slower; type: fit law; adopt");
    if (!a->pendulum && !param_chosen(&a->scene, "m"))
        reply_warning(reply, "k was computed with the default mass because m is not set; type for "
                             "example: m = 200 g; adopt");
    if ((fit->drag.candidates == 0 && param_value(&a->scene, "C") > 0) ||
        param_value(&a->scene, "F0") > 0)
        reply_warning(
            reply,
            "the scene also has quadratic drag or a driving force, which the fit does not include");
}

/* Adopts the last fit: restoring force, law of damping, initial state, and the offset as zero of
 * the recording, and replies. Returns false with the error. */
bool adopt_fit(struct session *session, const struct arguments *args, struct reply *reply,
               struct error *error)
{
    struct fits *fits = fits_made(session);
    if (!fits || !fits->has_fit) {
        error_set(error, ERROR_COMMAND, "there is no fit to adopt yet");
        return error_hint(error, "type: fit");
    }
    const struct fit *fit = &fits->fit;
    if (fits->fit_samples > 0)
        return adopt_curve(session, args, reply, error);
    const bool at_rest = has_argument(args, "amplitude");
    const struct argument_value *option = argument_value(args, "scale");
    double scale = 0;
    struct fit in_positions;
    struct adoption a = {
        .session = session, .scene = session->setup.scene, .data = fitted_recording(session)};
    struct named_value fitted = {.quantity = QUANTITY_LENGTH};
    names_value(session, TEXT("fit_amplitude"), &fitted);
    const bool scaled = quantity_is_scaled(fitted.quantity);
    a.pendulum = is_pendulum(&a.scene) && (scaled || is_turning(fitted.quantity));
    if (!a.pendulum && !can_have_spring(&a.scene, fit, error))
        return false;
    if (option->count > 0 && !scaled)
        return error_at(error, option->where,
                        "scale= applies to voltages and forces only, but %s %s was fitted",
                        quantity_article(fitted.quantity), quantity_name(fitted.quantity));
    if (scaled && !find_scale(&a, fit, option, &scale, error))
        return false;
    a.unscaled = scaled && scale == 0;
    if (scale != 0) {
        in_positions = *fit;
        adopted_scale(&in_positions, scale);
        fit = &in_positions;
    }
    const int n = scale != 0 ? 0 : derivative_order(fitted.quantity);
    a.as_on_data = n >= 0 && !at_rest;
    struct measured value[ADOPTED_VALUES];
    adopted_values(&a.scene, fit, n > 0 ? n : 0, at_rest, value);
    if (!take_force(&a, value, error) || !take_law(&a, fit, value, error) ||
        (n >= 0 && !take_start(&a, value, at_rest ? 0 : fit->t0, error)))
        return false;
    if ((fit->drift.value != 0 || fit->drag.wander > 0) && fit->drag.candidates > 0)
        omit_term(&a, "the drift of the offset");
    store_adopted(&a);
    adopted_motion(&a.scene, fit, n > 0 ? n : 0, at_rest, n >= 0, &fits->adopted.known);
    const double middle = a.pendulum ? 0
                                     : -param_value(&a.scene, "m") * param_value(&a.scene, "g") /
                                           value[ADOPTED_STIFFNESS].value;
    const double zero = fits->fit_zero + fits->fit.offset.value - (n == 0 && !scaled ? middle : 0);
    if (a.data >= 0)
        session->recording[a.data]->recording->zero = zero;
    session_changed(session);

    struct buffer text = {0};
    put_taken(&a, &text);
    if (a.data >= 0) {
        put_value(&text, "\nzero of the recording", (struct measured){zero, 0}, fitted.quantity,
                  true);
        buffer_put(&text, TEXT(" (the offset of the fit)"));
    }
    if (scale != 0)
        put_scaled(&a, &fits->fit, scale, fitted.quantity, option->count > 0, &text);
    if (fit->drag.candidates > 0 && fit->preferred == LAW_UNDECIDED)
        buffer_format(&text,
                      "\nthe data do not distinguish between the laws; the best one, %s, is taken",
                      drag_law_name(fit->drag.best));
    reply_adoption(&a, &text, reply);
    buffer_free(&text);
    warn_left(&a, fit, n >= 0, scaled, fitted.quantity, reply);
    return true;
}
