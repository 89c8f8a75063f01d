/* SPDX-License-Identifier: GPL-3.0-or-later */
/* fit, adopt */
#ifndef COMMAND_ROWS
#include "fit_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The mass on the spring, if somebody has said what it is. */
static bool known_mass(const struct scene *scene, struct measured *mass)
{
    const int m = scene_param(scene, "m");
    if (!scene->given[m])
        return false;
    *mass = (struct measured){scene->value[m], scene->uncertainty[m]};
    return true;
}

static void keep_fit(struct session *session, const struct subject *subject, const struct fit *fit,
                     const struct measured *k)
{
    const enum quantity quantity = subject->series.quantity;
    const struct measured unknown = {NAN, NAN};
    const struct {
        const char *name;
        struct measured value;
        enum quantity quantity;
    } results[] = {
        {"fit_period", fit->period, QUANTITY_TIME}, {"fit_omega", fit->omega, QUANTITY_ANGULAR_FREQUENCY},
        {"fit_gamma", fit->gamma, QUANTITY_RATE},   {"fit_amplitude", fit->amplitude, quantity},
        {"fit_phase", fit->phase, QUANTITY_ANGLE},  {"fit_offset", fit->offset, quantity},
        {"fit_rms", {fit->rms, 0}, quantity},       {"fit_k", k ? *k : unknown, QUANTITY_STIFFNESS},
    };
    session_drop_curve(session);
    session->fit = *fit;
    session->has_fit = true;
    session->fit_zero = subject->recording ? subject->recording->zero : 0;
    struct kept_fit kept = {.fit = *fit, .quantity = quantity, .k = k ? *k : unknown};
    memcpy(kept.of, subject->name, sizeof kept.of);
    session_keep_fit(session, &kept);
    memcpy(session->fit_of, subject->name, sizeof session->fit_of);
    for (size_t i = 0; i < COUNT_OF(results); i++)
        if (isfinite(results[i].value.value))
            session_set_result(session, results[i].name, results[i].value, results[i].quantity);
}

static const struct row kinds[] = {
    {"damped", "", "y = c + A exp(-gamma t/2) cos(omega t + phase): the default", "", NULL},
    {"sine", "", "the same without damping", "", NULL},
    {"drag", "", "linear, quadratic, mixed drag and dry friction, and which of them it is", "", NULL},
    {"scene", "", "the scene's own equation of motion, integrated", "", NULL},
};

const struct catalog fit_kind_catalog = CATALOG("fit", kinds);

static bool not_converged(const char *why, struct error *error)
{
    error_set(error, ERROR_NUMERICAL, "the fit %s", why);
    return error_hint(error, "choose a window where the motion is regular: fit window=FROM:TO");
}

static bool fit_motion(const struct asked_fit *asked, const char *name, struct error *error)
{
    static const char *const others[] = {"free", "NAME", "bootstrap", "robust"};
    struct session *session = asked->session;
    const struct subject *subject = asked->subject;
    struct arena *arena = asked->given->arena;
    struct fit fit = {0};
    for (size_t i = 0; i < COUNT_OF(others); i++)
        if (is_given(asked->given, others[i])) {
            error->where = given_for(asked->given, others[i])->where;
            error_set(error, ERROR_COMMAND, "'fit %s' needs no starts and frees what it needs", name);
            return error_hint(error, "that belongs to 'fit scene' and 'fit EXPR'");
        }
    const struct fit_model *model = (const struct fit_model *)(const void *)catalog_find(&fit_catalog, text_of(name));
    if (!model->fit(&subject->series, arena, session->front.cancel, &fit, error))
        return false;
    struct measured mass, stiffness = {NAN, NAN};
    const struct scene *scene = &session->setup.scene;
    /* Neither is the motion of something else that of a spring. */
    const bool spring = scene->model == &oscillator_model &&
                        (!subject->run || subject->run->system.model == &oscillator_model);
    const bool with_k = spring && known_mass(scene, &mass);
    if (with_k)
        stiffness = fit_stiffness(&fit, mass);
    if (fit.converged)
        keep_fit(session, subject, &fit, with_k ? &stiffness : NULL);
    struct told_fit told = {.subject = subject, .model = fit.model, .motion = &fit, .k = stiffness, .spring = spring};
    for (int i = 0; i < fit.warnings; i++)
        fit_tell_warning(&told, "%s", fit.warning[i]);
    reply_fit(&told, arena, asked->reply);
    char why[64];
    snprintf(why, sizeof why, "did not converge in %d iterations", fit.iterations);
    return fit.converged || not_converged(why, error);
}

HANDLER(fit)
{
    const struct given *model = given_for(given, "MODEL"), *run = given_for(given, "run"), *to = given_for(given, "to");
    struct subject subject;
    /* Recordings are what is fitted, unless there is none or a run is named. */
    struct item current = {.index = session->current_recording};
    const struct given data = to->count || current.index < 0 ? *to : (struct given){.count = 1, .item = &current};
    const bool formula = model->count && !model->item->row;
    if (!subject_open(session, run, &data, given_for(given, "window"), false, formula ? 2 : 8, given->arena, &subject,
                      error))
        return false;
    const struct asked_fit asked = {session, given, &subject, reply};
    if (formula)
        return fit_a_formula(&asked, model->item->text, error);
    const char *name = model->count ? model->item->row->name : kinds[0].name;
    return strcmp(name, "scene") == 0 ? fit_the_scene(&asked, error) : fit_motion(&asked, name, error);
}

/* ---- adopt ---- */

static void put(struct buffer *text, const char *name, struct measured value, enum quantity quantity)
{
    buffer_format(text, "%s = ", name);
    if (isfinite(value.value))
        buffer_measured(text, value, quantity, 6);
    else
        buffer_put(text, TEXT("unknown"));
}


static bool adopt_value(struct scene *scene, const char *name, double value, double uncertainty, struct error *error)
{
    return scene_set(scene, scene_param(scene, name), (struct measured){value, isfinite(uncertainty) ? uncertainty : 0},
                     error);
}

/* How often the position was differentiated to give such a recording, -1: it is no motion. Numbers without a unit are
 * taken as positions. */
static int derivatives(enum quantity quantity)
{
    switch (quantity) {
    case QUANTITY_LENGTH:
    case QUANTITY_ANGLE:
    case QUANTITY_OTHER:
        return 0;
    case QUANTITY_VELOCITY:
        return 1;
    case QUANTITY_ACCELERATION:
        return 2;
    default:
        return -1;
    }
}

/* Place of the recording that was fitted, -1: it was none, or is gone. */
static int fitted_recording(const struct session *session)
{
    const struct text of = text_of(session->fit_of);
    return text_starts(of, TEXT("data ")) ? session_find_recording(session, (struct text){of.at + 5, of.len - 5}) : -1;
}

/* Of a fit of the scene: what was free, as it was fitted. */
static bool adopt_curve(struct session *session, const struct arguments *given, struct reply *reply,
                        struct error *error)
{
    struct scene scene = session->setup.scene;
    const struct scene *fitted = &session->fit_scene;
    if (!fitted->model) {
        error_set(error, ERROR_COMMAND, "a formula has nothing that the scene could take");
        return error_hint(error, "type: fit, or: fit scene");
    }
    if (fitted->model != scene.model)
        return error_set(error, ERROR_COMMAND, "the fit was one of %s, the scene is %s", fitted->preset->row.name,
                         scene.preset->row.name);
    if (is_given(given, "amplitude"))
        return error_set(error, ERROR_COMMAND, "'adopt amplitude' belongs to the fit of a damped oscillation");
    struct buffer text = {0};
    const int t0 = scene_param(fitted, "t0");
    for (int i = 0; i < (int)scene_params(&scene)->count; i++) {
        if (!session->fit_free[i] && (i != t0 || scene.value[i] == fitted->value[i]))
            continue;
        const struct measured value = {fitted->value[i], session->fit_free[i] ? fitted->uncertainty[i] : 0};
        if (!scene_set(&scene, i, value, error)) {
            buffer_free(&text);
            return false;
        }
        buffer_put(&text, text.len ? TEXT("  ") : TEXT(""));
        put(&text, param_at(&scene, i)->row.name, value, param_at(&scene, i)->quantity);
    }
    session->setup.scene = scene;
    const int data = fitted_recording(session);
    if (data >= 0 && session->fit.offset.value != 0) {
        struct recording *recording = session->recording[data]->recording;
        recording->zero = session->fit_zero + session->fit.offset.value;
        put(&text, "\nzero of the recording", (struct measured){recording->zero, 0},
            recording->column[recording->value].quantity);
        buffer_put(&text, TEXT(" (the offset of the fit)"));
    }
    session_changed(session);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}

HANDLER(adopt)
{
    const struct fit *fit = &session->fit;
    if (!session->has_fit) {
        error_set(error, ERROR_COMMAND, "there is no fit to adopt yet");
        return error_hint(error, "type: fit");
    }
    if (session->fit_samples > 0)
        return adopt_curve(session, given, reply, error);
    struct scene scene = session->setup.scene;
    if (!needs_spring(&scene, "adopt", error))
        return false;
    const int m = scene_param(&scene, "m"), g = scene_param(&scene, "g");
    const struct measured mass = {scene.value[m], scene.uncertainty[m]}, stiffness = fit_stiffness(fit, mass);
    const bool decays = isfinite(fit->gamma.value);
    const double gamma = decays ? fit->gamma.value : 0, omega = fit->omega.value;
    struct named_value fitted = {.quantity = QUANTITY_LENGTH};
    names_value(session, TEXT("fit_amplitude"), &fitted);
    /* Each derivative of A exp(-gamma t/2) cos(omega t + phi) is the same, larger by `growth` and earlier by `turn`. */
    const int n = derivatives(fitted.quantity);
    const double growth = hypot(0.5 * gamma, omega), turn = atan2(omega, -0.5 * gamma);
    const double A = fit->amplitude.value / pow(growth, n), phi = fit->phase.value - n * turn;
    const bool at_rest = is_given(given, "amplitude");
    /* With gravity the motion is about the equilibrium, not about y = 0. */
    const double middle = -scene.value[m] * scene.value[g] / stiffness.value;
    const double y0 = (at_rest ? A : A * cos(phi)) + middle;
    const double v0 = at_rest ? 0 : A * (-0.5 * gamma * cos(phi) - omega * sin(phi));
    if (!adopt_value(&scene, "k", stiffness.value, stiffness.uncertainty, error) ||
        !adopt_value(&scene, "gamma", gamma, decays ? fit->gamma.uncertainty : 0, error))
        return false;
    const double spread = at_rest ? fit->amplitude.uncertainty / pow(growth, n) : 0;
    if (n >= 0 && (!adopt_value(&scene, "y0", y0, spread, error) || !adopt_value(&scene, "v0", v0, 0, error) ||
                   !adopt_value(&scene, "t0", at_rest ? 0 : fit->t0, 0, error)))
        return false;
    session->setup.scene = scene;
    const int data = fitted_recording(session);
    const double zero = session->fit_zero + fit->offset.value - (n == 0 ? middle : 0);
    if (data >= 0)
        session->recording[data]->recording->zero = zero;
    session_changed(session);

    struct buffer text = {0};
    put(&text, "k", stiffness, QUANTITY_STIFFNESS);
    put(&text, "  gamma", (struct measured){gamma, decays ? fit->gamma.uncertainty : 0}, QUANTITY_RATE);
    if (n >= 0) {
        put(&text, "  y0", (struct measured){y0, 0}, QUANTITY_LENGTH);
        put(&text, "  v0", (struct measured){v0, 0}, QUANTITY_VELOCITY);
        put(&text, "  t0", (struct measured){param_value(&scene, "t0"), 0}, QUANTITY_TIME);
    }
    if (data >= 0) {
        put(&text, "\nzero of the recording", (struct measured){zero, 0}, fitted.quantity);
        buffer_put(&text, TEXT(" (the offset of the fit)"));
    }
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    if (n < 0)
        reply_warning(reply, "y0, v0 and t0 stay: what was fitted (%s) is no position, velocity or acceleration",
                      quantity_name(fitted.quantity));
    if (!scene.given[m])
        reply_warning(reply,
                      "k was computed with the mass of the scene, which nobody has set: m = 200 g, then adopt again");
    if (param_value(&scene, "C") > 0 || param_value(&scene, "F0") > 0)
        reply_warning(reply, "the scene also has quadratic drag or a driving force, which the fit knows nothing of");
    return true;
}
#endif

COMMAND(fit, .row = {"fit", "", "fit an oscillation, the scene or a formula to a recording or a run", "", NULL},
        .group = "DATA",
        .text =
            "damped: y = c + A exp(-gamma t/2) cos(omega t + phase), t from the first sample of the window: gamma is "
            "that of\n"
            "y'' + gamma y' + omega0^2 y = 0. No guesses are needed. Both halves and the law of the envelope are "
            "always compared.\n"
            "drag: the whole oscillation under linear, quadratic, mixed drag and dry friction, and which it is.\n"
            "scene: the scene's equation, integrated. Free are the start, and k, gamma and the drag that is there "
            "unless you have\n"
            "given them without an uncertainty, or what free= says; NAME=VALUE changes a value for this fit, offset=0 "
            "holds the offset.\n"
            "EXPR: a formula in t; names that mean nothing yet, and those with free= or NAME=START, are its "
            "parameters. Their values\n"
            "are fit_NAME afterwards. --robust gives samples far off no weight; --bootstrap N makes the intervals "
            "from N synthetic fits.",
        .examples = "load bare.txt; m = 200 g; fit damped; adopt; fit scene free=k,gamma,y0,v0; adopt; run\n"
                    "load bare.txt; fit a*exp(-b*t)*cos(w*t+p)+c b=0.01 w=8.7",
        .see = "adopt measure load",
        ARGUMENTS(PLACE("MODEL", TYPE_MODEL, .choices = &fit_kind_catalog), WORD("to", TYPE_RECORDING, .group = 1),
                  WORD("run", TYPE_RUN, .group = 1), KEY("window", TYPE_RANGE, .quantity = QUANTITY_TIME),
                  KEY("free", TYPE_PARAM, .flags = ARG_MANY), KEY("NAME", TYPE_START, .flags = ARG_MANY | ARG_NEGATIVE),
                  OPTION("robust", TYPE_NONE), OPTION("bootstrap", TYPE_INTEGER)))

COMMAND(adopt, .row = {"adopt", "", "take what the last fit found into the scene: k, gamma, the start", "", NULL},
        .group = "DATA",
        .text = "y0, v0 and t0 are those of the fit at the first sample of its window, and the offset is taken off the "
                "recording, so that the\n"
                "run lies over the data. 'adopt amplitude' starts at y0 = A, v0 = 0, t0 = 0 instead, as on the sheet.\n"
                "Of 'fit scene' everything that was free is taken.",
        .examples = "load bare.txt; m = 200 g; fit; adopt; run\nadopt amplitude", .see = "fit run",
        .flags = COMMAND_CHANGES, ARGUMENTS(WORD("amplitude", TYPE_NONE)))
