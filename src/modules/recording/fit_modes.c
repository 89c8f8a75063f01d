/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command fit modes: fits several damped sines, and reports them as text and in the record. */
#include "modules/recording/fit_text.h"
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <stdio.h>

/* Default number of modes. */
#define MODES_USUAL 2

/* Values of a mode that are reported: in text (lead), in records (key), and as results for
 * expressions. */
static const struct mode_value {
    const char *lead, *key, *result;
    size_t offset;
    enum quantity quantity; /* QUANTITY_OTHER takes that of the series */
} of_mode[] = {
    {": f = ", "frequency", "fit_f", offsetof(struct normal_mode, frequency), QUANTITY_FREQUENCY},
    {"\n    gamma = ", "gamma", "fit_gamma", offsetof(struct normal_mode, gamma), QUANTITY_RATE},
    {"   A = ", "amplitude", "fit_amplitude", offsetof(struct normal_mode, amplitude),
     QUANTITY_OTHER},
    {"   phase = ", "phase", "fit_phase", offsetof(struct normal_mode, phase), QUANTITY_ANGLE},
};

/* Returns a value of a mode by its row. */
static struct measured value_of(const struct normal_mode *mode, const struct mode_value *value)
{
    return *(const struct measured *)(const void *)((const char *)mode + value->offset);
}

/* Returns the quantity of a value; `series` is that of the series. */
static enum quantity quantity_of(const struct mode_value *value, enum quantity series)
{
    return value->quantity == QUANTITY_OTHER ? series : value->quantity;
}

static void modes_measured_put(struct buffer *text, const char *name, struct measured value,
                               enum quantity quantity)
{
    buffer_put(text, text_of(name));
    buffer_measured(text, value, quantity, 6);
}

/* Returns 1/f with its uncertainty. */
static struct measured measured_inverse(struct measured f)
{
    return (struct measured){1 / f.value, f.uncertainty / (f.value * f.value)};
}

/* Appends splitting and beats of two modes, and the coupling of two equal oscillators that would
 * have these modes. */
static void put_coupling(const struct fit_summary *summary, struct buffer *text)
{
    const struct modes_fit *modes = summary->modes;
    modes_measured_put(text, "\n  splitting ", modes->splitting, QUANTITY_FREQUENCY);
    modes_measured_put(text, "   beats every ", measured_inverse(modes->splitting), QUANTITY_TIME);
    modes_measured_put(text,
                       "\n  if these are two equal coupled oscillators: kc/k = ", modes->coupling,
                       QUANTITY_NUMBER);
    if (isfinite(summary->k.value))
        modes_measured_put(text, "   kc = ", summary->k, QUANTITY_STIFFNESS);
    buffer_put(
        text,
        TEXT("\n  (k/m is the square of the slower omega0, (k + 2 kc)/m that of the faster)"));
}

/* Appends a block for each mode, then coupling, rms and offset. */
void put_modes(const struct fit_summary *summary, struct buffer *text)
{
    const struct modes_fit *modes = summary->modes;
    const enum quantity quantity = summary->subject->series.quantity;
    for (int k = 0; k < modes->modes; k++) {
        const struct normal_mode *mode = &modes->mode[k];
        buffer_format(text, "\n  mode %d", k + 1);
        for (const struct mode_value *v = of_mode; v < of_mode + COUNT_OF(of_mode); v++) {
            modes_measured_put(text, v->lead, value_of(mode, v), quantity_of(v, quantity));
            if (v == of_mode)
                modes_measured_put(text, "   T = ", measured_inverse(mode->frequency),
                                   QUANTITY_TIME);
        }
    }
    if (modes->modes == 2)
        put_coupling(summary, text);
    buffer_format(text, "\n  rms %s", SHOWN_QUANTITY(modes->fit.rms, quantity, 3));
    modes_measured_put(text, "   offset ", modes->fit.offset, quantity);
    buffer_format(text, "   (phases and offset at t = %.6g s)", modes->fit.t0);
}

/* Writes an object for each mode, and the splitting and coupling if there are two. */
void reply_modes(const struct fit_summary *summary, struct reply *reply)
{
    const struct modes_fit *modes = summary->modes;
    const enum quantity quantity = summary->subject->series.quantity;
    reply_array(reply, "modes");
    for (int k = 0; k < modes->modes; k++) {
        reply_object(reply, NULL);
        for (const struct mode_value *v = of_mode; v < of_mode + COUNT_OF(of_mode); v++)
            reply_measured(reply, v->key, value_of(&modes->mode[k], v), quantity_of(v, quantity));
        reply_close(reply);
    }
    reply_close(reply);
    const struct measured none = {NAN, NAN};
    const bool two = modes->modes == 2;
    reply_if_known(reply, "splitting", two ? modes->splitting : none, QUANTITY_FREQUENCY);
    reply_if_known(reply, "coupling", two ? modes->coupling : none, QUANTITY_NUMBER);
    reply_if_known(reply, "kc", summary->k, QUANTITY_STIFFNESS);
}

/* Sets fit_frequency1, fit_gamma1 and so on: results that expressions can use. */
static void keep_results(struct session *session, const struct modes_fit *modes,
                         enum quantity quantity)
{
    for (int k = 0; k < modes->modes; k++)
        for (const struct mode_value *v = of_mode; v < of_mode + COUNT_OF(of_mode); v++) {
            char name[LIMIT_NAME + 1];
            snprintf(name, sizeof name, "%s%d", v->result, k + 1);
            session_set_result(session, name, value_of(&modes->mode[k], v),
                               quantity_of(v, quantity));
        }
    if (modes->modes == 2) {
        session_set_result(session, "fit_splitting", modes->splitting, QUANTITY_FREQUENCY);
        session_set_result(session, "fit_coupling", modes->coupling, QUANTITY_NUMBER);
    }
    session_set_result(session, "fit_offset", modes->fit.offset, quantity);
    session_set_result(session, "fit_rms", (struct measured){modes->fit.rms, 0}, quantity);
}

/* Returns the requested number of modes, or 0 with the error. */
static int modes_of(const struct arguments *args, struct error *error)
{
    const struct argument_value *count = argument_value(args, "COUNT");
    const double modes = count->count ? count->item->value.value : MODES_USUAL;
    if (modes >= 1 && modes <= MODES_MAX)
        return (int)modes;
    error_at(error, count->where, "'fit modes' takes 1 to %d modes", MODES_MAX);
    return 0;
}

/* Returns the coupling spring kc, or NAN if the mass of an oscillator is unknown or if there are
 * not two modes. */
static struct measured coupling_spring(const struct modes_fit *modes, const struct measured *mass)
{
    if (!mass || modes->modes != 2)
        return (struct measured){NAN, NAN};
    const double kc = mass->value * modes->stiffness.value;
    return (struct measured){kc, hypot(mass->value * modes->stiffness.uncertainty,
                                       mass->uncertainty * modes->stiffness.value)};
}

/* Fits a sum of damped modes, replies with them and stores the result. `mass`, NULL if unknown,
 * gives the spring constant of the coupling. Returns false with the error, also if the fit does not
 * converge. */
bool fit_the_modes(const struct fit_request *call, const struct measured *mass, struct error *error)
{
    struct modes_fit modes;
    struct session *session = call->session;
    struct arena *arena = call->args->arena;
    const struct series *series = &call->subject->series;
    const int count = modes_of(call->args, error);
    if (count == 0 || !series_modes(series, count, arena, session->front.cancel, &modes, error))
        return false;
    struct fit_summary summary = {.subject = call->subject,
                                  .model = "modes",
                                  .motion = &modes.fit,
                                  .modes = &modes,
                                  .k = coupling_spring(&modes, mass)};
    if (modes.fit.converged) {
        if (!session_add_curve(call, modes.residual, &modes.fit, error))
            return false;
        fits_made(session)->fit_modes = modes.modes;
        keep_results(session, &modes, series->quantity);
    }
    for (int i = 0; i < modes.fit.warnings; i++)
        fit_add_warning(&summary, "%s", modes.fit.warning[i]);
    fit_add_window(&summary, WINDOW_LAW_SINE, arena);
    reply_fit(&summary, arena, call->reply);
    if (modes.fit.converged)
        return true;
    error_set(error, ERROR_NUMERICAL, "the fit did not converge in %d iterations",
              modes.fit.iterations);
    return error_hint(error, "choose a window where the motion is regular, or fit fewer modes");
}
