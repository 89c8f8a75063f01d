/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command measure: period, frequency, decay, energy, drift, Reynolds number, spring constant,
 * spectrum. Each measurement adds text and a record to the reply, a result for expressions, and a
 * row to the session's list. */
#ifndef COMMAND_ROWS
#include "modules/recording/fit_text.h"
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>
#include "modules/recording/measuring.h"

#include <hooke/base/numeric.h>
#include <hooke/plot.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- what every measurement leaves behind: a record, a result, a row of the list ---- */

struct measurement *measure_latest(const struct measuring *m)
{
    return &m->session->measurement[m->session->measurements - 1];
}

/* Marks the measurement as one of an energy if its subject is. */
bool measure_keep(struct measuring *m, const char *name, struct measured value, enum quantity unit,
                  double periods)
{
    if (!session_add_measurement(m->session, name, m->subject.name, value, unit, periods, m->error))
        return false;
    measure_latest(m)->energy = m->subject.energy;
    return true;
}

/* Begins a record of the quantity that was asked for. */
static void begin_measure_record(struct measuring *m, struct measured value, enum quantity unit,
                                 double periods)
{
    measure_begin(m, m->quantity, value, unit, periods);
}

/* Reports the values that entered the latest measurement: in the text, the open record and the
 * report. */
static void put_inputs(struct measuring *m, const struct inputs *inputs, struct buffer *text)
{
    inputs_put(inputs, text);
    inputs_reply(inputs, m->reply);
    inputs_keep(inputs, &measure_latest(m)->exact);
}

/* Appends the predicted value and the deviation, such as "   theory 1.9390 s (-0.09 %)"; nothing if
 * theory is NAN. */
static void put_theory(struct buffer *text, double value, double theory, enum quantity unit)
{
    if (!isfinite(theory))
        return;
    const double percent = 100 * (value - theory) / theory;
    buffer_format(text, "   theory %s (%+.2f %%)", SHOWN_VALUE(theory, unit, 5),
                  fabs(percent) < 0.005 ? 0.0 : percent);
}

/* Returns the period [s] that the scene predicts, or NAN. For a recording the scene counts only if
 * its k was set or adopted. */
static double theory_period(const struct measuring *m)
{
    const struct scene *scene = subject_scene(m->session, m->subject.run);
    const bool known = scene && (m->subject.run || param_chosen(scene, "k"));
    const bool driven = scene && fabs(param_value(scene, "F0")) > 0; /* then it follows the drive */
    const bool narrows =
        scene && scene->model != &oscillator_model && fabs(param_value(scene, "gamma")) > 0;
    return known && !driven && !narrows ? scene_period(scene) : NAN;
}

bool measure_say(struct measuring *m, struct buffer *text)
{
    reply_text(m->reply, buffer_text(text));
    buffer_free(text);
    return true;
}

/* ---- the quantities ---- */

/* Returns 1/x with its uncertainty. */
static struct measured measured_inverse(struct measured x)
{
    return (struct measured){1 / x.value, x.uncertainty / (x.value * x.value)};
}

/* Returns the part of a series from which its period was read, or all if that is most of it. */
static struct series swinging_part(const struct series *s, const struct period *p)
{
    static const double most = 0.8;
    const double span = s->t[s->n - 1] - s->t[0];
    return p->last - p->first < most * span ? series_window(*s, p->first, p->last) : *s;
}

/* Warns if two estimates of one period disagree: at least one of them assumes a wrong motion. */
static void warn_contradiction(struct measuring *m, struct measured period, struct measured alike)
{
    static const double doubtful = 4; /* standard deviations */
    const double apart = alike.value - period.value,
                 sigma = hypot(alike.uncertainty, period.uncertainty);
    if (fabs(apart) > doubtful * sigma)
        reply_warning(m->reply,
                      "the period by autocorrelation is %.2g s %s than by the other method (%.2g "
                      "standard deviations): the motion is not one steady oscillation, or the "
                      "window contains something else",
                      fabs(apart), apart > 0 ? "longer" : "shorter", fabs(apart) / sigma);
}

/* Measures the period of the subject. Returns false with the error. */
static bool read_period(struct measuring *m, struct period *p)
{
    const bool is_state = !m->subject.energy && !m->subject.column;
    if (!run_series_period(is_state ? m->subject.run : NULL, &m->subject.series, m->args->arena, p,
                           m->error))
        return false;
    m->period = p->period.value;
    return true;
}

/* Measures the period, once or in windows, compares it with theory and autocorrelation, and
 * replies. Returns false with the error. */
static bool measure_period(struct measuring *m)
{
    const struct argument_value *windows = argument_value(m->args, "windows");
    struct period p;
    struct measured alike = {NAN, NAN};
    struct buffer text = {0};
    if (windows->count) {
        if (measure_periods(m, (int)windows->item->value.value, &text))
            return measure_say(m, &text);
        buffer_free(&text);
        return false;
    }
    if (!read_period(m, &p) || !measure_keep(m, m->quantity, p.period, QUANTITY_TIME, p.periods))
        return false;
    put_value(&text, "T", p.period, QUANTITY_TIME, m->subject.recording);
    buffer_format(&text, " (%g period%s, %s)", p.periods, p.periods == 1 ? "" : "s", p.how);
    if (!m->subject.energy && !m->subject.column)
        put_theory(&text, p.period.value, theory_period(m), QUANTITY_TIME);
    const struct series swing = swinging_part(&m->subject.series, &p);
    if (m->subject.recording && series_correlation_period(&swing, &p, m->args->arena, &alike))
        put_value(&text, "\nautocorrelation: T", alike, QUANTITY_TIME, true);
    warn_contradiction(m, p.period, alike);
    put_pace(&m->subject.series, &text);
    begin_measure_record(m, p.period, QUANTITY_TIME, p.periods);
    reply_string(m->reply, "how", p.how);
    if (m->subject.recording)
        reply_measured(m->reply, "autocorrelation", alike, QUANTITY_TIME);
    reply_end(m->reply);
    if (p.warning[0])
        reply_warning(m->reply, "%s", p.warning);
    return measure_say(m, &text);
}

/* Measures frequency and angular frequency from the period and replies. Returns false with the
 * error. */
static bool measure_frequency(struct measuring *m)
{
    struct period p;
    if (!read_period(m, &p))
        return false;
    const struct measured f = measured_inverse(p.period);
    if (!measure_keep(m, m->quantity, f, QUANTITY_FREQUENCY, p.periods))
        return false;
    struct buffer text = {0};
    put_measured(&text, "f", f, QUANTITY_FREQUENCY);
    put_measured(&text, "   omega", (struct measured){2 * PI * f.value, 2 * PI * f.uncertainty},
                 QUANTITY_ANGULAR_FREQUENCY);
    buffer_format(&text, " (%g periods)", p.periods);
    if (!m->subject.energy && !m->subject.column)
        put_theory(&text, f.value, 1 / theory_period(m), QUANTITY_FREQUENCY);
    begin_measure_record(m, f, QUANTITY_FREQUENCY, p.periods);
    reply_end(m->reply);
    return measure_say(m, &text);
}

/* Measures gamma from readings of the amplitude or energy, with 1/e time, decrement and quality
 * factor, and replies. Returns false with the error. */
static bool measure_decay(struct measuring *m)
{
    const struct argument_value *windows = argument_value(m->args, "windows");
    const int readings = windows->count ? (int)windows->item->value.value : 0;
    const enum quantity unit = m->subject.series.quantity;
    struct decay d;
    if (readings > (int)COUNT_OF(d.reading) || (windows->count && readings < 3))
        return error_at(m->error, windows->where, "the decay needs 3 to %zu readings",
                        COUNT_OF(d.reading));
    if (!series_decay(&m->subject.series, m->args->arena,
                      m->subject.energy ? &m->subject.noise : NULL, readings, &d, m->error) ||
        !measure_keep(m, "decay", d.gamma, QUANTITY_RATE, NAN))
        return false;
    session_set_result(m->session, "measured_gamma", d.gamma, QUANTITY_RATE);
    session_set_result(m->session, "measured_tau", d.tau, QUANTITY_TIME);
    session_set_result(m->session, "measured_Q", d.quality, QUANTITY_NUMBER);
    struct buffer text = {0};
    put_measured(&text, "gamma", d.gamma, QUANTITY_RATE);
    buffer_format(&text, " (%s; %d readings)",
                  m->subject.energy ? "energy falls as exp(-gamma t)"
                                    : "amplitude falls as exp(-gamma t/2)",
                  d.readings);
    const struct scene *scene = subject_scene(m->session, m->subject.run);
    const double gamma = scene ? param_value(scene, "gamma") : 0;
    if (gamma != 0) /* nothing is said where it is NAN */
        put_theory(&text, d.gamma.value, gamma, QUANTITY_RATE);
    const bool measured = m->subject.recording;
    put_reciprocal(&text, "\n1/e time of the amplitude tau", 2, d.gamma, QUANTITY_TIME, measured);
    put_measured(&text, "   decrement", d.decrement, QUANTITY_NUMBER);
    put_reciprocal(&text, "   Q", PI, d.decrement, QUANTITY_NUMBER, measured);
    put_measured(&text, m->subject.energy ? "   E at the start" : "   A at the start", d.initial,
                 unit);
    if (isfinite(d.halves[0]) && isfinite(d.halves[1]))
        buffer_format(&text, "\nhalves: gamma = %s and %s",
                      SHOWN_QUANTITY(d.halves[0], QUANTITY_RATE, 3),
                      SHOWN_QUANTITY(d.halves[1], QUANTITY_RATE, 3));
    begin_measure_record(m, d.gamma, QUANTITY_RATE, NAN);
    double least;
    measured_reciprocal(2, d.gamma, &least);
    reply_measured(m->reply, "tau", d.tau, QUANTITY_TIME);
    reply_real(m->reply, "tau_min", least);
    reply_measured(m->reply, "decrement", d.decrement, QUANTITY_NUMBER);
    reply_measured(m->reply, "Q", d.quality, QUANTITY_NUMBER);
    reply_measured(m->reply, "initial", d.initial, unit);
    reply_reals(m->reply, "halves", d.halves, 2, "");
    reply_array(m->reply, "readings");
    for (int i = 0; i < d.readings; i++) {
        reply_object(m->reply, NULL);
        reply_real(m->reply, "t", d.reading[i].t);
        reply_real(m->reply, "value", d.reading[i].amplitude.value);
        reply_real(m->reply, "uncertainty", d.reading[i].amplitude.uncertainty);
        reply_close(m->reply);
    }
    reply_end(m->reply);
    for (int i = 0; i < d.readings; i++) {
        buffer_format(&text, "\n  t = %.6g s   ", d.reading[i].t);
        put_measured(&text, m->subject.energy ? "E" : "A", d.reading[i].amplitude, unit);
    }
    return measure_say(m, &text);
}

/* Measures mean and spread of the energy over the window and replies. Returns false with the
 * error. */
static bool measure_energy(struct measuring *m)
{
    const struct series *s = &m->subject.series;
    const struct measured mean = series_mean(s);
    if (!measure_keep(m, m->quantity, mean, s->quantity, NAN))
        return false;
    const double first = s->y[0], last = s->y[s->n - 1];
    struct buffer text = {0};
    const bool kinetic = m->subject.run && !m->subject.run->system.energy;
    put_measured(&text, kinetic ? "Ekin" : "E", mean, s->quantity);
    buffer_format(&text, " (mean and spread over %.6g..%.6g s)   from %s to %s, a factor of %s",
                  s->t[0], s->t[s->n - 1], SHOWN_VALUE(first, s->quantity, 6),
                  SHOWN_VALUE(last, s->quantity, 6), SHOWN_SHORT(last / first, 6));
    if (m->subject.how[0])
        buffer_format(&text, "\n%s", m->subject.how);
    begin_measure_record(m, mean, s->quantity, NAN);
    reply_real(m->reply, "first", first);
    reply_real(m->reply, "last", last);
    reply_string(m->reply, "from", m->subject.how[0] ? m->subject.how : NULL);
    struct inputs inputs = {.exacts = 0};
    if (m->subject.recording) {
        inputs_use(&inputs, "m", m->subject.mass);
        inputs_use(&inputs, "k", m->subject.k);
    }
    put_inputs(m, &inputs, &text);
    reply_end(m->reply);
    return measure_say(m, &text);
}

/* Measures the error of a run's energy balance and replies. Returns false with the error, which
 * tells why a balance is unknown. */
static bool measure_drift(struct measuring *m)
{
    struct ledger ledger;
    if (!m->subject.run)
        return error_set(m->error, ERROR_COMMAND,
                         "'measure drift' (the error of the energy balance) works only for runs, "
                         "not for recordings");
    run_ledger(m->subject.run, &ledger);
    const struct measured drift = {ledger.error, 0};
    if (!isfinite(ledger.error) && isfinite(ledger.final) && ledger.initial != 0) {
        error_set(m->error, ERROR_NUMERICAL,
                  "the energy balance of %s is unknown: too many of its steps are too coarse to "
                  "compute the work, for example across jumps of a force",
                  m->subject.name);
        return error_hint(m->error, "try smaller steps, an adaptive method or a shorter run");
    }
    if (!isfinite(ledger.error))
        return error_set(m->error, ERROR_COMMAND, "%s has no energy", m->subject.name);
    if (!measure_keep(m, m->quantity, drift, QUANTITY_NUMBER, NAN))
        return false;
    struct buffer text = {0};
    const bool balanced = m->subject.run->plan.ledger;
    buffer_format(&text,
                  balanced ? "energy balance = %s at the end, max %s   ((E - E0 - work)/E0)"
                           : "dE/E0 = %s at the end, max %s   ((E - E0)/E0)",
                  SHOWN_SHORT(ledger.error, 4), SHOWN_SHORT(ledger.error_max, 4));
    begin_measure_record(m, drift, QUANTITY_NUMBER, NAN);
    reply_real(m->reply, "max", ledger.error_max);
    reply_end(m->reply);
    return measure_say(m, &text);
}

/* Sets *speed to the largest speed [m/s]: of a run as recorded, of a recording from amplitude and
 * period, else of the scene's future motion. Returns false with the error. */
static bool largest_speed(struct measuring *m, struct measured *speed)
{
    const struct series *s = &m->subject.series;
    if (!m->subject.run && !m->subject.recording) {
        /* These are the derived quantities of the scene. */
        struct named_value amplitude, omega0;
        if (names_value(m->session, TEXT("amplitude"), &amplitude) &&
            names_value(m->session, TEXT("omega0"), &omega0))
            *speed = (struct measured){amplitude.value * omega0.value, 0};
        return isfinite(speed->value) ||
               error_set(m->error, ERROR_COMMAND, "the scene does not oscillate (k > 0 is needed)");
    }
    if (m->subject.run) {
        const struct run *run = m->subject.run;
        *speed = (struct measured){run_speed_max(run, s->t[0], s->t[s->n - 1]), 0};
        return run->system.order == 2 ||
               error_set(m->error, ERROR_COMMAND, "%s has no velocity", m->subject.name);
    }
    struct period p;
    struct reading a;
    if (s->quantity != QUANTITY_LENGTH)
        return error_set(m->error, ERROR_COMMAND,
                         "the Reynolds number needs positions, but %s is not a position",
                         m->subject.name);
    if (!read_period(m, &p) || !series_amplitudes(s, m->args->arena, &s->t[0], 1, 0, &a, m->error))
        return false;
    speed->value = a.amplitude.value * 2 * PI / p.period.value;
    speed->uncertainty = speed->value * hypot(a.amplitude.uncertainty / a.amplitude.value,
                                              p.period.uncertainty / p.period.value);
    return true;
}

/* Measures the Reynolds number at the largest speed, with its regime of flow, and replies. Returns
 * false with the error. */
static bool measure_reynolds(struct measuring *m)
{
    struct measured speed = {NAN, 0};
    const struct scene *scene = m->subject.run ? &m->subject.run->scene : &m->session->setup.scene;
    if (!needs_spring(scene, "the Reynolds number", m->error) || !largest_speed(m, &speed))
        return false;
    struct inputs inputs = {.exacts = 0};
    inputs_use_params(&inputs, scene, "rho length eta");
    const struct measured re =
        inputs_widen(&inputs, (struct measured){scene_reynolds(scene, speed.value),
                                                scene_reynolds(scene, speed.uncertainty)});
    if (!measure_keep(m, m->quantity, re, QUANTITY_NUMBER, NAN))
        return false;
    struct buffer text = {0};
    put_measured(&text, "Re", re, QUANTITY_NUMBER);
    buffer_format(&text,
                  " (%s) at the largest speed %s; rho, length and eta are those of the scene",
                  reynolds_regime(re.value), SHOWN_MEASURED(speed, QUANTITY_VELOCITY, 4));
    begin_measure_record(m, re, QUANTITY_NUMBER, NAN);
    reply_string(m->reply, "regime", reynolds_regime(re.value));
    reply_measured(m->reply, "speed", speed, QUANTITY_VELOCITY);
    put_inputs(m, &inputs, &text);
    reply_end(m->reply);
    return measure_say(m, &text);
}

/* Measures the stiffness k = m (omega^2 + gamma^2/4), with gamma from the decay if that can be
 * measured, else 0, keeps the value and replies. The mass is the recording's own or, without one,
 * the scene's, and its uncertainty is included. Returns false with m->error. */
static bool measure_k(struct measuring *m)
{
    const struct scene *scene = m->subject.run ? &m->subject.run->scene : &m->session->setup.scene;
    struct period p;
    struct decay d;
    struct error ignored;
    if (!needs_spring(scene, "k", m->error))
        return false;
    const int index = scene_param(scene, "m");
    const struct recording *recording = m->subject.recording;
    const bool own = recording && recording->mass.value > 0;
    const double mass = own ? recording->mass.value : scene->value[index];
    const double u = own ? recording->mass.uncertainty : scene->uncertainty[index];
    if (!read_period(m, &p))
        return false;
    const bool decays = series_decay(&m->subject.series, m->args->arena, NULL, 0, &d, &ignored);
    const struct fit motion = {.omega = {2 * PI / p.period.value, 0},
                               .gamma = {decays ? d.gamma.value : 0, 0}};
    struct measured k = fit_stiffness(&motion, (struct measured){mass, 0});
    struct inputs inputs = {.exacts = 0};
    inputs_use(&inputs, "m", (struct measured){mass, u});
    k.uncertainty = k.value * 2 * p.period.uncertainty / p.period.value;
    k = inputs_widen(&inputs, k);
    if (!measure_keep(m, m->quantity, k, QUANTITY_STIFFNESS, p.periods))
        return false;
    struct buffer text = {0};
    put_measured(&text, "k", k, QUANTITY_STIFFNESS);
    put_measured(&text, " (m", (struct measured){mass, u}, QUANTITY_MASS);
    put_measured(&text, ", T", p.period, QUANTITY_TIME);
    buffer_char(&text, ')');
    put_pace(&m->subject.series, &text);
    if (m->subject.run)
        put_theory(&text, k.value, param_value(scene, "k"), QUANTITY_STIFFNESS);
    else if (!own && !scene->chosen[index])
        reply_warning(m->reply,
                      "m is not set, so the default mass is used; set it, for example m = 200 g");
    begin_measure_record(m, k, QUANTITY_STIFFNESS, p.periods);
    put_inputs(m, &inputs, &text);
    reply_end(m->reply);
    return measure_say(m, &text);
}

/* Replies with the lines of the spectrum; the strongest is the measurement. Returns false with the
 * error if no line is significant. */
static bool measure_spectrum(struct measuring *m)
{
    struct spectrum_peak found[PEAKS_EACH];
    struct figure_peaks peaks = {0};
    const int count = series_peaks(&m->subject.series, m->args->arena, found, PEAKS_EACH);
    if (count == 0)
        return error_set(m->error, ERROR_COMMAND, "the spectrum of %s has no significant line",
                         m->subject.name);
    if (!measure_keep(m, "frequency", found[0].frequency, QUANTITY_FREQUENCY, NAN))
        return false;
    for (; peaks.count < count; peaks.count++)
        peaks.peak[peaks.count] =
            (struct figure_peak){m->subject.name, found[peaks.count], m->subject.series.quantity};
    spectrum_report(&peaks, 1, m->reply);
    return true;
}

/* Opens the subject and calls the function of the quantity; advises a better window. */
HANDLER(measure)
{
    static bool (*const measures[])(struct measuring *) = {
        [MEASURE_PERIOD] = measure_period,       [MEASURE_FREQUENCY] = measure_frequency,
        [MEASURE_AMPLITUDE] = measure_amplitude, [MEASURE_DECAY] = measure_decay,
        [MEASURE_ENERGY] = measure_energy,       [MEASURE_DRIFT] = measure_drift,
        [MEASURE_REYNOLDS] = measure_reynolds,   [MEASURE_K] = measure_k,
        [MEASURE_SPRING] = measure_spring,       [MEASURE_SPECTRUM] = measure_spectrum,
        [MEASURE_REPEAT] = measure_repeat};
    const struct item *quantity = argument_value(args, "QUANTITY")->item;
    const enum measurable which = (enum measurable)quantity->index;
    const bool energy = has_argument(args, "energy") || which == MEASURE_ENERGY;
    const struct argument_value *column = argument_value(args, "COLUMN");
    if (column->count && (energy || which > MEASURE_DECAY) && which != MEASURE_SPECTRUM)
        return error_at(
            error, column->where,
            "only period, frequency, amplitude, decay and spectrum can be measured of a column");
    struct measuring m = {session, args, reply, {.run = NULL}, quantity->row->name, NAN, error};
    /* The Reynolds number can be asked for before anything has moved. */
    if (which == MEASURE_REYNOLDS && session->runs.count == 0 && session->recordings == 0) {
        snprintf(m.subject.name, sizeof m.subject.name, "the scene");
        return measures[which](&m);
    }
    if (which == MEASURE_SPRING || which == MEASURE_REPEAT)
        return measures[which](&m);
    const struct argument_value *named = argument_value(args, "RECORDING");
    if (named->count > 1)
        return error_at(error, named->where, "only 'measure repeat' takes several recordings");
    if (has_argument(args, "what"))
        return error_at(error, argument_value(args, "what")->where,
                        "what= works only with 'measure repeat'");
    if (!subject_open(session, argument_value(args, "run"),
                      named->count ? named : argument_value(args, "data"),
                      argument_value(args, "window"), energy, 2, args->arena, &m.subject, error) ||
        (column->count &&
         !subject_column(&m.subject, column, argument_value(args, "window"), args->arena, error)) ||
        !measures[which](&m))
        return false;
    if (m.subject.recording && which != MEASURE_SPECTRUM)
        reply_advice(&m.subject, m.period, args->arena, reply);
    return true;
}
#endif

COMMAND(
    measure, .group = "MEASURE", .flags = COMMAND_ANYTIME | COMMAND_TABLES,
    ARGUMENTS(PLACE("QUANTITY", TYPE_CHOICE, .flags = ARG_REQUIRED, .choices = &quantity_catalog),
              WORD("run", TYPE_RUN, .lead = "of", .group = 1),
              WORD("data", TYPE_RECORDING, .lead = "of", .group = 1),
              WORD("energy", TYPE_NONE, .lead = "of"),
              KEY("window", TYPE_RANGE, .quantity = QUANTITY_TIME),
              KEY("at", TYPE_VALUE, .flags = ARG_MANY | ARG_NEGATIVE, .quantity = QUANTITY_TIME),
              KEY("windows", TYPE_INTEGER), KEY("what", TYPE_CHOICE, .choices = &quantity_catalog),
              PLACE("RECORDING", TYPE_RECORDING, .flags = ARG_MANY, .lead = "of"),
              PLACE("COLUMN", TYPE_COLUMN, .lead = "of"), OPTION("full", TYPE_NONE)))
