/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One spring with several masses: omega^2 + gamma^2/4 = k/(m + m_spring), so that T0^2 = (4
 * pi^2/k)(m + m_spring) is a straight line against m, where T0 is the period without damping.
 * m_spring is about a third of the spring's own mass (Rayleigh 1894). */
#include <hooke/command/handler.h>
#include "modules/recording/measuring.h"

#include <math.h>
#include <stdio.h>

#define FOUR_PI_SQUARED 39.47841760435743447534

/* A recording of one mass on the spring. */
struct hung {
    const struct recording *recording;
    struct measured period, square, k; /* T; T0^2 [s^2]; k from this mass alone */
};

/* Fits a damped sine to hung->recording and fills in its period, k and T0^2. Returns false with the
 * error, also if the fit does not converge. */
static bool fit_one(struct measuring *m, struct hung *hung)
{
    const struct fit_model *damped = fit_model_by_name(TEXT("damped"));
    const struct recording *recording = hung->recording;
    struct series series;
    struct fit fit = {0};
    if (!recording_series(recording, m->args->arena, 8, &series, m->error) ||
        !damped->fit(&series, m->args->arena, m->session->front.cancel, &fit, m->error))
        return false;
    if (!fit.converged)
        return error_set(m->error, ERROR_NUMERICAL, "the fit to %s did not converge",
                         recording->name);
    const struct measured mass = recording->mass;
    hung->period = fit.period;
    hung->k = fit_stiffness(&fit, mass);
    hung->square.value = FOUR_PI_SQUARED * mass.value / hung->k.value;
    hung->square.uncertainty =
        hypot(2 * hung->square.value * fit.period.uncertainty / fit.period.value,
              hung->square.value * mass.uncertainty / mass.value);
    return true;
}

/* Appends a line for each mass, with k compared with the first. */
static void put_each(struct buffer *text, const struct hung *hung, int count)
{
    for (int i = 0; i < count; i++) {
        const struct hung *h = &hung[i];
        buffer_format(text, "%s%-16s ", i ? "\n" : "", h->recording->name);
        put_measured(text, "m", h->recording->mass, QUANTITY_MASS);
        put_measured(text, "   T", h->period, QUANTITY_TIME);
        put_measured(text, "   m omega0^2", h->k, QUANTITY_STIFFNESS);
        if (i == 0)
            continue;
        const double difference = h->k.value - hung[0].k.value,
                     u = hypot(h->k.uncertainty, hung[0].k.uncertainty);
        buffer_format(text, "   %+.2f %%, %.2g sigma", 100 * difference / hung[0].k.value,
                      fabs(difference) / u);
    }
}

/* Adds the record of the measurement: k, effective mass of the spring, test of the line, and each
 * recording. */
static void reply_spring(struct measuring *m, const struct hung *hung, int count,
                         const struct line_fit *line, struct measured k, struct measured spring)
{
    measure_begin(m, m->quantity, k, QUANTITY_STIFFNESS, NAN);
    reply_measured(m->reply, "effective_mass", spring, QUANTITY_MASS);
    reply_real(m->reply, "chi2", line->chi2);
    reply_int(m->reply, "freedom", line->freedom);
    reply_array(m->reply, "recordings");
    for (int i = 0; i < count; i++) {
        reply_object(m->reply, NULL);
        reply_string(m->reply, "name", hung[i].recording->name);
        reply_measured(m->reply, "mass", hung[i].recording->mass, QUANTITY_MASS);
        reply_measured(m->reply, "period", hung[i].period, QUANTITY_TIME);
        reply_measured(m->reply, "k", hung[i].k, QUANTITY_STIFFNESS);
        reply_close(m->reply);
    }
    reply_close(m->reply);
    reply_end(m->reply);
}

/* Returns intercept/slope of a line, with regard to their correlation. */
static struct measured line_ratio(const struct line_fit *line)
{
    const double s = line->slope.value, value = line->intercept.value / s;
    const double us = line->slope.uncertainty, ui = line->intercept.uncertainty;
    return (struct measured){
        value, sqrt(fmax(ui * ui + value * value * us * us - 2 * value * line->covariance, 0)) / s};
}

/* Measures k and the effective mass of a spring: fits each recording with a known mass, then a line
 * through T0^2 against the masses, and replies. Returns false with the error. */
bool measure_spring(struct measuring *m)
{
    const struct session *session = m->session;
    struct hung hung[LIMIT_RECORDINGS];
    double mass[LIMIT_RECORDINGS];
    struct measured square[LIMIT_RECORDINGS];
    struct line_fit line;
    int count = 0;
    /* T0^2 and its uncertainty for each mass. */
    for (int i = 0; i < session->recordings; i++) {
        const struct recording *recording = session->recording[i]->recording;
        if (!(recording->mass.value > 0))
            continue;
        hung[count] = (struct hung){.recording = recording};
        if (!fit_one(m, &hung[count]))
            return false;
        mass[count] = recording->mass.value;
        square[count] = hung[count].square;
        count++;
    }
    if (count < 2) {
        error_set(m->error, ERROR_COMMAND,
                  "'measure spring' needs at least two recordings with a known mass, but there %s",
                  count ? "is one" : "is none");
        return error_hint(m->error, "type: data use NAME; data mass 200 g");
    }
    snprintf(m->subject.name, sizeof m->subject.name, "%d recordings", count);
    struct buffer text = {0};
    put_each(&text, hung, count);
    if (!line_fit(mass, square, count, &line) || !(line.slope.value > 0)) {
        buffer_put(&text, TEXT("\nT^2 does not grow with the mass: the recordings are not of one "
                               "spring, or the masses are wrong"));
        reply_text(m->reply, buffer_text(&text));
        buffer_free(&text);
        return error_set(m->error, ERROR_COMMAND, "these masses give no spring constant");
    }
    /* The slope of T0^2 against m is 4 pi^2/k, and the intercept over the slope the spring's
     * mass. */
    const struct measured k = {FOUR_PI_SQUARED / line.slope.value,
                               FOUR_PI_SQUARED * line.slope.uncertainty /
                                   (line.slope.value * line.slope.value)};
    const struct measured spring = line_ratio(&line);
    if (!session_add_measurement(m->session, m->quantity, m->subject.name, k, QUANTITY_STIFFNESS,
                                 NAN, m->error)) {
        buffer_free(&text);
        return false;
    }
    session_set_result(m->session, "measured_spring_mass", spring, QUANTITY_MASS);
    put_measured(&text, "\nT0^2 = (4 pi^2/k)(m + m_spring): k", k, QUANTITY_STIFFNESS);
    put_measured(&text, "   m_spring", spring, QUANTITY_MASS);
    if (line.freedom > 0)
        buffer_format(&text, "   (chi^2 = %.3g for %d)", line.chi2, line.freedom);
    else
        buffer_put(&text, TEXT("   (two masses only, so the line is not tested)"));
    reply_text(m->reply, buffer_text(&text));
    buffer_free(&text);
    reply_spring(m, hung, count, &line, k, spring);
    for (int i = 0; i < count; i++)
        if (!(hung[i].recording->mass.uncertainty > 0)) {
            reply_warning(
                m->reply,
                "the masses have no uncertainty; state it, for example: data mass 199.9 +- 0.1 g");
            break;
        }
    return true;
}
