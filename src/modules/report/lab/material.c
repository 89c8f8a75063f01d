/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Decides which section of the lab report each recording and run belongs to, by method, scene, the
 * recording that its parameters come from, and comparisons. Damping alone does not decide, since
 * even the bare mass is damped a little and adopting its fit takes that over. */
#include "modules/report/lab/material.h"

#include "modules/recording/fits.h"
#include "modules/recording/known/known.h"
#include <hooke/base/numeric.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A recording that loses at least this fraction of its amplitude belongs to the second session. */
#define AMPLITUDE_LOSS_MIN 0.25
/* A recording is divided into this many parts of equal length; the amplitudes of the first and the
 * last are compared. */
#define RECORDING_PARTS 5
/* A recording counts as damped if its fitted gamma exceeds that of another one by this factor,
 * after three uncertainties were subtracted from it and added to the other. */
#define DAMPING_RATIO_MIN 2

bool is_method(const struct run *run, const char *name)
{
    return catalog_find(&method_catalog, text_of(name)) == &run->method->row;
}

/* ---- recordings ---- */

/* Returns the median absolute deviation of n values, a measure of amplitude that single missed
 * echoes do not change, or NAN if out of memory. */
static double median_deviation(struct arena *arena, const double *y, size_t n)
{
    double *values = arena_array(arena, n, sizeof *values);
    if (!values)
        return NAN;
    memcpy(values, y, n * sizeof *values);
    const double median = values_quantile(values, n, 0.5);
    for (size_t i = 0; i < n; i++)
        values[i] = fabs(values[i] - median);
    return values_quantile(values, n, 0.5);
}

/* Returns the fraction of the amplitude that is lost from the first part of the recording to the
 * last, or NAN if the recording is too short. */
static double amplitude_loss(const struct recording *recording)
{
    struct recording unwindowed = *recording;
    struct arena arena = {0};
    struct series series;
    struct error error = {0};
    double lost = NAN;
    unwindowed.window[0] = -HUGE_VAL;
    unwindowed.window[1] = HUGE_VAL;
    if (recording_series(&unwindowed, &arena, 4 * RECORDING_PARTS, &series, &error)) {
        const size_t n = series.n / RECORDING_PARTS;
        lost = 1 - median_deviation(&arena, series.y + series.n - n, n) /
                       median_deviation(&arena, series.y, n);
    }
    arena_reset(&arena);
    return lost;
}

/* Returns true if the user measured the decay of a recording, or at least two amplitudes at stated
 * times. */
static bool is_decay_measured(const struct report *report, int index)
{
    int readings = 0;
    char subject[LIMIT_NAME + 16];
    snprintf(subject, sizeof subject, "data %s",
             report->session->recording[index]->recording->name);
    for (int k = 0; k < report->values; k++) {
        const struct report_value *v = &report->value[k];
        if (strcmp(v->subject, subject) == 0 && strcmp(v->source, "measured") == 0)
            readings += strcmp(v->name, "gamma") == 0 ? 2 : isfinite(v->t);
    }
    return readings >= 2;
}

/* Returns true if the last fit of recording number `index` found a gamma that is larger, by
 * DAMPING_RATIO_MIN beyond three standard deviations, than that of some other recording. */
static bool is_damped_more(const struct report *report, int index)
{
    const struct session *session = report->session;
    struct measured gamma[LIMIT_RECORDINGS];
    for (int i = 0; i < session->recordings; i++) {
        gamma[i] = (struct measured){NAN, NAN};
        for (int k = 0; k < fits_of(session)->stored_fits; k++) {
            const struct stored_fit *fit = &fits_of(session)->stored_fit[k];
            const struct text subject = text_of(fit->subject);
            if (text_starts(subject, TEXT("data ")) && fit->fit.gamma.value > 0 &&
                text_is(text_after(subject, 5), session->recording[i]->recording->name))
                gamma[i] = fit->fit.gamma;
        }
    }
    for (int i = 0; i < session->recordings; i++)
        if (gamma[index].value - 3 * gamma[index].uncertainty >
            DAMPING_RATIO_MIN * (gamma[i].value + 3 * gamma[i].uncertainty))
            return true;
    return false;
}

/* Assigns recordings to the lab's two sessions (m->decays, first, second). A recording belongs to
 * the second session if much of its amplitude is lost, if a fit gives far more damping than that of
 * another one, or if its decay was measured and no other one of those falls more. If that holds for
 * all and some decay was measured, the others are of the first session. */
static void sort_recordings(const struct report *report, struct material *m)
{
    const int count = report->session->recordings;
    double fall[LIMIT_RECORDINGS], most = -HUGE_VAL;
    bool asked[LIMIT_RECORDINGS], any_asked = false, all = true;
    for (int i = 0; i < count; i++) {
        fall[i] = amplitude_loss(report->session->recording[i]->recording);
        asked[i] = is_decay_measured(report, i);
        any_asked |= asked[i];
        most = asked[i] ? fmax(most, fall[i]) : most;
    }
    for (int i = 0; i < count; i++) {
        m->decays[i] = fall[i] > AMPLITUDE_LOSS_MIN || (asked[i] && !(fall[i] < most)) ||
                       is_damped_more(report, i);
        all &= m->decays[i];
    }
    for (int i = 0; all && any_asked && i < count; i++)
        m->decays[i] = asked[i];
    m->first = m->second = -1;
    for (int i = count - 1; i >= 0; i--)
        *(m->decays[i] ? &m->second : &m->first) = i;
}

/* ---- runs ---- */

static bool same_bits(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* Returns the index of the recording that a run's parameters were fitted to, or -1 if there is
 * none. The fit is recognized by the bits of k, which `adopt` copied; the latest one wins. */
int recording_of(const struct report *report, const struct run *run)
{
    if (run->system.model != &oscillator_model)
        return -1;
    const struct session *session = report->session;
    const double k = param_value(&run->scene, "k");
    for (int i = fits_of(session)->stored_fits - 1; i >= 0; i--) {
        const struct stored_fit *fit = &fits_of(session)->stored_fit[i];
        const struct text subject = text_of(fit->subject);
        if (text_starts(subject, TEXT("data ")) && same_bits(fit->k.value, k))
            return session_find_recording(session, text_after(subject, 5));
    }
    return -1;
}

/* Returns true for the lab's scene, a linear spring without drive, cubic force or van der Pol
 * term. */
static bool is_spring(const struct run *run)
{
    static const char *const others[] = {"F0", "k3", "mu"};
    bool spring = run->system.model == &oscillator_model;
    for (size_t i = 0; spring && i < COUNT_OF(others); i++)
        spring = !(fabs(param_value(&run->scene, others[i])) > 0);
    return spring;
}

/* Returns true if the scene has quadratic drag or dry friction, which are not proportional to the
 * velocity. */
static bool has_other_drag(const struct run *run)
{
    return param_value(&run->scene, "C") > 0 || param_value(&run->scene, "friction") > 0;
}

bool is_damped(const struct run *run)
{
    return fabs(param_value(&run->scene, "gamma")) > 0 || has_other_drag(run);
}

/* Compares parameters and initial values bitwise. */
bool same_motion(const struct run *a, const struct run *b)
{
    if (a->system.model != b->system.model)
        return false;
    for (int i = 0; i < (int)scene_params(&a->scene)->count; i++)
        if (!same_bits(a->scene.value[i], b->scene.value[i]))
            return false;
    return true;
}

/* Returns true if another method integrated the same scene: in the same statement, or, if
 * `one_by_one`, in any other run. */
static bool is_compared(const struct session *session, int index, bool one_by_one)
{
    const struct run_slot *slot = session->runs.slot[index];
    for (int i = 0; i < session->runs.count; i++) {
        const struct run_slot *other = session->runs.slot[i];
        if (other->run->method != slot->run->method &&
            (other->statement == slot->statement ||
             (one_by_one && same_motion(other->run, slot->run))))
            return true;
    }
    return false;
}

/* Returns the section of the report to which the run with that index belongs. `laws` is true if any
 * run has drag that is not proportional to the velocity, so that the session compares laws of
 * drag. */
static enum section section_of(struct report *report, const struct material *m, int index,
                               bool laws)
{
    const struct run *run = run_at(report, index);
    const bool euler = is_method(run, "euler");
    const enum section plain = euler ? SECTION_SIMULATION : SECTION_SCHEMES;
    const int recording = is_spring(run) ? recording_of(report, run) : -1;
    if (!is_spring(run))
        return SECTION_OTHER;
    /* Damped runs count as undamped ones if methods are compared by them, or if Euler's run has no
     * damped recording that it could belong to. */
    if (!is_damped(run) || is_compared(report->session, index, recording < 0 && m->second < 0) ||
        (euler && m->second < 0))
        return plain;
    if (recording >= 0)
        return m->decays[recording] ? SECTION_DAMPED_SIMULATION : plain;
    if (has_other_drag(run))
        return m->second >= 0 && recording_beside(report, index, PLOT_POSITION) == m->second
                   ? SECTION_DAMPED_SIMULATION
                   : SECTION_DRAG;
    return laws && m->second < 0 ? SECTION_DRAG : SECTION_DAMPED_SIMULATION;
}

/* ---- schemes side by side ---- */

/* Returns true if the runs may share a figure: equal fixed steps, or one is adaptive. */
static bool same_step(const struct run *a, const struct run *b)
{
    return a->plan.adaptive || b->plan.adaptive || a->settings.dt == b->settings.dt;
}

/* Adds a run to m->scheme if it has the same motion and step as the first one there, its method is
 * not there yet, and REPORT_OVERLAY runs are not exceeded. */
static void add_scheme(const struct report *report, struct material *m, int index)
{
    const struct run *run = run_at(report, index), *first = run_at(report, m->scheme[0]);
    if (m->schemes == REPORT_OVERLAY || !same_motion(first, run) || !same_step(first, run))
        return;
    for (int i = 0; i < m->schemes; i++)
        if (run_at(report, m->scheme[i])->method == run->method)
            return;
    m->scheme[m->schemes++] = index;
}

/* Fills m->scheme with reference_run and runs of SECTION_SCHEMES that share its motion and step,
 * one of each method; the methods of the lab sheet come first. */
static void choose_schemes(const struct report *report, struct material *m, int reference_run)
{
    static const char *const names[] = {"symplectic-euler", "backward-euler"};
    const int *other = m->run[SECTION_SCHEMES], others = m->runs[SECTION_SCHEMES];
    m->schemes = 1;
    m->scheme[0] = reference_run;
    for (size_t k = 0; k < COUNT_OF(names); k++)
        for (int i = 0; i < others; i++)
            if (is_method(run_at(report, other[i]), names[k]))
                add_scheme(report, m, other[i]);
    for (int i = 0; i < others; i++)
        add_scheme(report, m, other[i]);
}

/* Chooses m->euler, the run of forward Euler that the most runs of other methods can be drawn
 * beside; among equals the one with the sheet's step of 0.01 s. Without such a run, m->scheme is
 * chosen around the best run of another method and m->euler remains -1. */
static void choose_euler(const struct report *report, struct material *m)
{
    int best = -1, most = -1;
    m->euler = -1;
    for (int i = 0; i < m->runs[SECTION_SIMULATION]; i++) {
        const int index = m->run[SECTION_SIMULATION][i];
        choose_schemes(report, m, index);
        /* one more method outweighs the sheet's step */
        const int worth = 2 * m->schemes + (run_at(report, index)->settings.dt == 0.01);
        if (worth > most)
            m->euler = index;
        most = worth > most ? worth : most;
    }
    for (int i = 0; m->euler < 0 && i < m->runs[SECTION_SCHEMES]; i++) {
        choose_schemes(report, m, m->run[SECTION_SCHEMES][i]);
        if (m->schemes > most) {
            most = m->schemes;
            best = m->run[SECTION_SCHEMES][i];
        }
    }
    m->schemes = 0;
    if (m->euler >= 0 || best >= 0)
        choose_schemes(report, m, m->euler >= 0 ? m->euler : best);
}

/* Assigns runs and recordings to the sections of the report and stores them in report->material.
 * Runs with fewer than two recorded rows are left out of all sections. Returns false with *error if
 * out of memory. */
bool sort_material(struct report *report, struct error *error)
{
    const struct session *session = report->session;
    struct material *m = arena_alloc(report->arena, sizeof *m);
    bool laws = false;
    if (!m)
        return error_memory(error);
    *m = (struct material){.euler = -1};
    report->material = m;
    sort_recordings(report, m);
    for (int i = 0; i < session->runs.count; i++)
        laws |= is_spring(run_at(report, i)) && has_other_drag(run_at(report, i));
    for (int i = 0; i < session->runs.count; i++) {
        if (trace_count(run_at(report, i)->trace) < 2)
            continue;
        const enum section s = section_of(report, m, i, laws);
        m->run[s][m->runs[s]++] = i;
    }
    choose_euler(report, m);
    return true;
}
