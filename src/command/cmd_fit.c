/* SPDX-License-Identifier: GPL-3.0-or-later */
/* fit, adopt */
#ifndef COMMAND_ROWS
#include "choices.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void put(struct buffer *text, const char *name, struct measured value, enum quantity quantity)
{
    buffer_format(text, "%s = ", name);
    if (isfinite(value.value))
        buffer_measured(text, value, quantity, 6);
    else
        buffer_put(text, TEXT("unknown"));
}

/* The mass on the spring, if somebody has said what it is. */
static bool known_mass(const struct scene *scene, struct measured *mass)
{
    const int m = scene_param(scene, "m");
    if (!scene->given[m])
        return false;
    *mass = (struct measured){scene->value[m], scene->uncertainty[m]};
    return true;
}

static struct measured quotient(double numerator, struct measured x)
{
    return (struct measured){numerator / x.value, fabs(numerator / x.value) * fabs(x.uncertainty / x.value)};
}

static void reply_fit_text(const struct subject *subject, const struct fit *fit, const struct measured *k, bool spring,
                           struct reply *reply)
{
    const enum quantity quantity = subject->series.quantity;
    struct buffer text = {0};
    buffer_format(&text, "fit %s to %s, %.6g..%.6g s: %zu samples used, %zu rejected\n  ", fit->model, subject->name,
                  fit->window[0], fit->window[1], fit->used, fit->rejected);
    put(&text, "T", fit->period, QUANTITY_TIME);
    put(&text, "   omega", fit->omega, QUANTITY_ANGULAR_FREQUENCY);
    if (isfinite(fit->gamma.value)) {
        put(&text, "\n  gamma", fit->gamma, QUANTITY_RATE);
        buffer_put(&text, TEXT("   (amplitude falls as exp(-gamma t/2), energy as exp(-gamma t))\n  "));
        if (fit->gamma.value > 0) {
            put(&text, "tau", quotient(2, fit->gamma), QUANTITY_TIME);
            put(&text, "   Q",
                (struct measured){fit->omega.value / fit->gamma.value,
                                  fit->omega.value / fit->gamma.value *
                                      fabs(fit->gamma.uncertainty / fit->gamma.value)},
                QUANTITY_NUMBER);
        } else {
            buffer_put(&text, TEXT("no decay"));
        }
    }
    put(&text, "\n  A", fit->amplitude, quantity);
    put(&text, "   phase", fit->phase, QUANTITY_ANGLE);
    buffer_format(&text, " at t = %.6g s", fit->t0);
    put(&text, "   offset", fit->offset, quantity);
    if (k)
        put(&text, "\n  k", *k, QUANTITY_STIFFNESS);
    buffer_put(&text, k ? TEXT("   rms ") : TEXT("\n  rms "));
    buffer_quantity(&text, fit->rms, quantity, 3);
    if (isfinite(fit->halves[0].value) && isfinite(fit->halves[1].value)) {
        put(&text, "\n  halves: gamma", fit->halves[0], QUANTITY_RATE);
        buffer_put(&text, TEXT(" and "));
        buffer_measured(&text, fit->halves[1], QUANTITY_RATE, 4);
    }
    const char *law = drag_law_name(fit->preferred);
    if (law) {
        buffer_format(&text, "\n  drag law of the envelope: %s (BIC linear ", law);
        buffer_short(&text, fit->evidence[0], 6);
        buffer_put(&text, TEXT(", quadratic "));
        buffer_short(&text, fit->evidence[1], 6);
        buffer_put(&text, TEXT(", mixed "));
        buffer_short(&text, fit->evidence[2], 6);
        buffer_char(&text, ')');
    }
    if (!k && spring)
        buffer_put(&text, TEXT("\n  (set the mass, for example m = 200 g, to get k)"));
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
}

static void reply_fit_record(const struct subject *subject, const struct fit *fit, const struct measured *k,
                             struct reply *reply)
{
    const enum quantity quantity = subject->series.quantity;
    reply_begin(reply, "fit");
    reply_string(reply, "model", fit->model);
    reply_string(reply, "of", subject->name);
    reply_measured(reply, "period", fit->period, QUANTITY_TIME);
    reply_measured(reply, "omega", fit->omega, QUANTITY_ANGULAR_FREQUENCY);
    reply_measured(reply, "gamma", fit->gamma, QUANTITY_RATE);
    reply_measured(reply, "amplitude", fit->amplitude, quantity);
    reply_measured(reply, "phase", fit->phase, QUANTITY_ANGLE);
    reply_measured(reply, "offset", fit->offset, quantity);
    if (k)
        reply_measured(reply, "k", *k, QUANTITY_STIFFNESS);
    else
        reply_null(reply, "k");
    reply_real(reply, "rms", fit->rms);
    reply_int(reply, "used", (int64_t)fit->used);
    reply_int(reply, "rejected", (int64_t)fit->rejected);
    reply_array(reply, "window");
    reply_real(reply, NULL, fit->window[0]);
    reply_real(reply, NULL, fit->window[1]);
    reply_close(reply);
    reply_object(reply, "halves");
    reply_array(reply, "gamma");
    reply_real(reply, NULL, fit->halves[0].value);
    reply_real(reply, NULL, fit->halves[1].value);
    reply_close(reply);
    reply_close(reply);
    reply_string(reply, "preferred", drag_law_name(fit->preferred));
    reply_bool(reply, "converged", fit->converged);
    reply_array(reply, "warnings");
    for (int i = 0; i < fit->warnings; i++)
        reply_string(reply, NULL, fit->warning[i]);
    reply_close(reply);
    reply_end(reply);
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
    session->fit = *fit;
    session->has_fit = true;
    session->fit_zero = subject->recording ? subject->recording->zero : 0;
    struct kept_fit kept = {.fit = *fit, .quantity = quantity, .k = k ? *k : unknown};
    snprintf(kept.of, sizeof kept.of, "%s", subject->name);
    session_keep_fit(session, &kept);
    snprintf(session->fit_of, sizeof session->fit_of, "%s", subject->name);
    for (size_t i = 0; i < COUNT_OF(results); i++)
        if (isfinite(results[i].value.value))
            session_set_result(session, results[i].name, results[i].value, results[i].quantity);
}

HANDLER(fit)
{
    const struct given *model = given_for(given, "MODEL"), *run = given_for(given, "run"), *to = given_for(given, "to");
    const struct row *row = model->count ? model->item->row : catalog_row(&fit_catalog, 0);
    struct subject subject;
    struct fit fit = {0};
    /* Recordings are what is fitted, unless there is none or a run is named. */
    struct item current = {.index = session->current_recording};
    const struct given data = to->count || current.index < 0 ? *to : (struct given){.count = 1, .item = &current};
    if (!subject_open(session, run, &data, given_for(given, "window"), false, 8, given->arena, &subject, error))
        return false;
    if (!((const struct fit_model *)(const void *)row)
             ->fit(&subject.series, given->arena, session->front.cancel, &fit, error))
        return false;
    struct measured mass, stiffness;
    const struct scene *scene = &session->setup.scene;
    /* Neither is the motion of something else that of a spring. */
    const bool spring = scene->model == &oscillator_model &&
                        (!subject.run || subject.run->system.model == &oscillator_model);
    const bool with_k = spring && known_mass(scene, &mass);
    if (with_k)
        stiffness = fit_stiffness(&fit, mass);
    const struct measured *k = with_k ? &stiffness : NULL;
    if (fit.converged)
        keep_fit(session, &subject, &fit, k);
    reply_fit_text(&subject, &fit, k, spring, reply);
    reply_fit_record(&subject, &fit, k, reply);
    for (int i = 0; i < fit.warnings; i++)
        reply_warning(reply, "%s", fit.warning[i]);
    if (fit.converged)
        return true;
    error_set(error, ERROR_NUMERICAL, "the fit did not converge in %d iterations", fit.iterations);
    return error_hint(error, "choose a window where the motion is regular: fit window=FROM:TO");
}

/* ---- adopt ---- */

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

HANDLER(adopt)
{
    const struct fit *fit = &session->fit;
    if (!session->has_fit) {
        error_set(error, ERROR_COMMAND, "there is no fit to adopt yet");
        return error_hint(error, "type: fit");
    }
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
    const struct text of = text_of(session->fit_of);
    const int data =
        text_starts(of, TEXT("data ")) ? session_find_recording(session, (struct text){of.at + 5, of.len - 5}) : -1;
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

COMMAND(fit, .row = {"fit", "", "fit a damped oscillation to a recording or a run", "", NULL}, .group = "DATA",
        .text =
            "y = c + A exp(-gamma t/2) cos(omega t + phase), t from the first sample of the window: gamma is that of\n"
            "y'' + gamma y' + omega0^2 y = 0. No guesses are needed. Both halves and the law of the envelope are "
            "always compared.",
        .examples = "load bare.txt; fit\nfit sine window=2:8", .see = "adopt measure load",
        ARGUMENTS(PLACE("MODEL", TYPE_CHOICE, .choices = &fit_catalog), WORD("to", TYPE_RECORDING, .group = 1),
                  WORD("run", TYPE_RUN, .group = 1), KEY("window", TYPE_RANGE, .quantity = QUANTITY_TIME)))

COMMAND(adopt, .row = {"adopt", "", "take k, gamma and the start from the last fit", "", NULL}, .group = "DATA",
        .text = "y0, v0 and t0 are those of the fit at the first sample of its window, and the offset is taken off the "
                "recording, so that the\n"
                "run lies over the data. 'adopt amplitude' starts at y0 = A, v0 = 0, t0 = 0 instead, as on the sheet.",
        .examples = "load bare.txt; m = 200 g; fit; adopt; run\nadopt amplitude", .see = "fit run",
        .flags = COMMAND_CHANGES, ARGUMENTS(WORD("amplitude", TYPE_NONE)))
