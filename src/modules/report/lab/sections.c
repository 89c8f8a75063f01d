/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes the sections of a report, in the order of the lab sheet: text, figures and tables of the
 * runs and recordings that sort_material() assigned to each. write_sections() is the entry. */
#include "modules/report/lab/material.h"

#include "modules/recording/known/known.h"
#include "modules/recording/fits.h"
#include <hooke/report.h>

#include <stdio.h>
#include <string.h>

#define VALUE_DIGITS 6 /* largest number of significant digits */

/* ---- sections ---- */

/* Writes the rates of the best candidate: "b = 0.0788 ± 0.0015 1/m". */
static void put_rates(struct document *document, const struct stored_fit *stored,
                      const struct drag_candidate *best)
{
    document_say(document, "; of %s", drag_law_name(best->law));
    for (int k = 0; k < DRAG_RATES; k++) {
        const struct measured rate = best->rate[k];
        if (!(fabs(rate.value) > 0 || rate.uncertainty > 0))
            continue;
        document_say(document, ", %s = ", drag_rates[k].name);
        document_measured(document, rate, QUANTITY_OTHER, VALUE_DIGITS);
        document_say(document, " %s",
                     stored->quantity == QUANTITY_LENGTH ? drag_rates[k].unit : drag_rates[k].bare);
    }
}

/* Writes which laws of damping a fit compared, their BIC, and the rates of the best one. Writes
 * nothing if the fit compared none. */
static void put_damping_laws(struct document *document, const struct stored_fit *stored)
{
    const struct fit *fit = &stored->fit;
    const char *law = drag_law_name(fit->preferred);
    if (!law)
        return;
    document_open(document, BLOCK_PARAGRAPH);
    document_say(document, "Law of damping (fit %s, integrated): %s; BIC", fit->model, law);
    for (int i = 0; i < fit->drag.candidates; i++)
        document_say(document, "%s %s %.1f", i ? "," : "",
                     drag_law_name(fit->drag.candidate[i].law), fit->drag.candidate[i].bic);
    for (int i = 0; i < fit->drag.candidates; i++)
        if (fit->drag.candidate[i].law == fit->drag.best)
            put_rates(document, stored, &fit->drag.candidate[i]);
    document_say(document, ".");
    document_close(document, BLOCK_PARAGRAPH);
}

/* Writes the list of values that were stated without an uncertainty and used in the numbers of a
 * recording ("data disk"), each once. Writes nothing if there are none. */
static void put_exact_inputs(struct report *report, const char *subject)
{
    const struct session *session = report->session;
    struct document *document = &report->document;
    struct inputs inputs = {.exacts = 0};
    for (int i = 0; i < fits_of(session)->stored_fits; i++)
        if (strcmp(fits_of(session)->stored_fit[i].subject, subject) == 0)
            inputs_recall(&inputs, &fits_of(session)->stored_fit[i].exact);
    for (int i = 0; i < session->measurements; i++)
        if (strcmp(session->measurement[i].source, subject) == 0)
            inputs_recall(&inputs, &session->measurement[i].exact);
    if (strcmp(fits_of(session)->adopted.subject, subject) == 0)
        inputs_recall(&inputs, &fits_of(session)->adopted.exact);
    if (inputs.exacts == 0)
        return;
    document_open(document, BLOCK_PARAGRAPH);
    document_say(document, "Given without an uncertainty and taken as exact: ");
    for (int i = 0; i < inputs.exacts; i++)
        document_say(document, "%s%s", i ? ", " : "", inputs.exact[i]);
    document_say(document, ". Results that use them are less certain if they are not exact.");
    document_close(document, BLOCK_PARAGRAPH);
}

/* Writes the position that counts as zero for a recording, with the uncertainty of the fitted
 * offset if it is one, else without (it was stated). */
static void put_zero_position(struct report *report, const struct recording *recording,
                              const char *subject)
{
    struct measured zero = {recording->zero, 0};
    for (int i = 0; i < fits_of(report->session)->stored_fits; i++) {
        const struct stored_fit *stored = &fits_of(report->session)->stored_fit[i];
        if (strcmp(stored->subject, subject) == 0 &&
            fabs(stored->fit.offset.value - zero.value) < stored->fit.offset.uncertainty)
            zero.uncertainty = stored->fit.offset.uncertainty;
    }
    document_measured(&report->document, zero, recording->column[recording->value].quantity,
                      VALUE_DIGITS);
}

/* Writes recording number `index` to the report: description, figure, measured and fitted values
 * and, in the section of the damped recording, the laws of damping. Returns false with *error if
 * out of memory or the figure fails. */
static bool put_recording(struct report *report, int index, enum section section,
                          struct error *error)
{
    struct document *document = &report->document;
    const struct recording *recording = report->session->recording[index]->recording;
    struct buffer description = {0};
    char subject[LIMIT_NAME + 16];
    snprintf(subject, sizeof subject, "data %s", recording->name);
    recording_describe(recording, &description);
    struct text rest = buffer_text(&description), line;
    document_open(document, BLOCK_PARAGRAPH);
    document_say(document, "Recording ");
    document_name(document, text_of(recording->name));
    document_say(document, ", used from %.6g to %.6g s, with the zero at ", recording->window[0],
                 recording->window[1]);
    put_zero_position(report, recording, subject);
    document_say(document, ":");
    document_close(document, BLOCK_PARAGRAPH);
    document_open(document, BLOCK_LIST);
    while (text_split(&rest, '\n', &line))
        if (line.len > 0 && !text_starts(line, TEXT("columns: "))) {
            document_open(document, BLOCK_ITEM);
            document_name(document, line);
            document_close(document, BLOCK_ITEM);
        }
    document_close(document, BLOCK_LIST);
    const bool ok = !description.failed
                        ? put_figure(report, section, PLOT_POSITION, NULL, 0, index, error)
                        : error_memory(error);
    buffer_free(&description);
    put_values(report, subject, false);
    for (int i = 0; i < fits_of(report->session)->stored_fits; i++) {
        const struct stored_fit *stored = &fits_of(report->session)->stored_fit[i];
        if (strcmp(stored->subject, subject) == 0 && section == SECTION_DAMPED_RECORDING)
            put_damping_laws(document, stored);
    }
    put_exact_inputs(report, subject);
    return ok;
}

/* Writes all recordings with m->decays equal to `decays`. */
static bool put_recordings(struct report *report, const struct material *m, bool decays,
                           enum section section, struct error *error)
{
    for (int i = 0; i < report->session->recordings; i++)
        if (m->decays[i] == decays && !put_recording(report, i, section, error))
            return false;
    return true;
}

/* Writes the table of parameters and settings of a run. */
static void put_parameters(struct report *report, int index)
{
    char subject[32];
    snprintf(subject, sizeof subject, "run %d", run_at(report, index)->number);
    document_open(&report->document, BLOCK_PARAGRAPH);
    document_say(&report->document, "Parameters of %s (%s):", subject,
                 run_at(report, index)->method->row.name);
    document_close(&report->document, BLOCK_PARAGRAPH);
    put_values(report, subject, true);
}

/* Writes a table of measured values for each of the runs that has any. */
static void put_measured_values(struct report *report, const int *run, int runs)
{
    for (int i = 0; i < runs; i++) {
        char subject[32];
        snprintf(subject, sizeof subject, "run %d", run_at(report, run[i])->number);
        bool any = false;
        for (int k = 0; k < report->values; k++)
            any |= strcmp(report->value[k].subject, subject) == 0 &&
                   !is_stated(&report->value[k]) && stands_in_section(report, &report->value[k]);
        if (!any)
            continue;
        document_open(&report->document, BLOCK_PARAGRAPH);
        document_say(&report->document, "Measured on %s:", subject);
        document_close(&report->document, BLOCK_PARAGRAPH);
        put_values(report, subject, false);
    }
}

/* Writes parameters and figures of the chosen run of forward Euler (section 2). */
static bool simulation_section_put(struct report *report, const struct material *m,
                                   struct error *error)
{
    static const enum plot_kind kinds[] = {PLOT_POSITION, PLOT_VELOCITY, PLOT_PHASE};
    if (m->euler < 0)
        return true;
    put_parameters(report, m->euler);
    for (size_t i = 0; i < COUNT_OF(kinds); i++)
        if (!put_figure(report, SECTION_SIMULATION, kinds[i], &m->euler, 1, -1, error))
            return false;
    return true;
}

/* Section 3: energy of the chosen run of forward Euler, and the table of all of its runs. */
static bool energy_section_put(struct report *report, const struct material *m, struct error *error)
{
    const int *run = m->run[SECTION_SIMULATION], runs = m->runs[SECTION_SIMULATION];
    if (m->euler < 0)
        return true;
    if (!put_figure(report, SECTION_ENERGY, PLOT_ENERGY, &m->euler, 1, -1, error))
        return false;
    put_runs(report, run, runs, false);
    put_measured_values(report, run, runs);
    return true;
}

/* Returns true if the parameters of run[i] have not been printed yet: neither for m->euler, in
 * section 2, nor for an earlier run of the list. */
static bool is_first_of_its_motion(const struct report *report, const struct material *m,
                                   const int *run, int i)
{
    const struct run *this_run = run_at(report, run[i]);
    if (m->euler >= 0 && same_motion(run_at(report, m->euler), this_run))
        return false;
    for (int k = 0; k < i; k++)
        if (same_motion(run_at(report, run[k]), this_run))
            return false;
    return true;
}

/* Writes section 4, other methods beside forward Euler: figures in common, parameters of each
 * distinct motion, and a table of all undamped runs. Returns false with *error. */
static bool schemes_section_put(struct report *report, const struct material *m,
                                struct error *error)
{
    /* figures of symplectic Euler by itself, or of the only run */
    static const enum plot_kind alone[] = {PLOT_POSITION, PLOT_ENERGY, PLOT_PHASE};
    const enum section here = SECTION_SCHEMES;
    int *all = arena_array(report->arena, LIMIT_RUNS, sizeof *all), runs = 0;
    if (!all)
        return error_memory(error);
    if (m->runs[here] == 0)
        return true;
    for (int i = 0; i < m->schemes; i++)
        for (size_t k = 0; k < COUNT_OF(alone); k++)
            if ((is_method(run_at(report, m->scheme[i]), "symplectic-euler") || m->schemes == 1) &&
                !put_figure(report, here, alone[k], &m->scheme[i], 1, -1, error))
                return false;
    if (m->schemes > 1 &&
        (!put_figure(report, here, PLOT_ENERGY, m->scheme, m->schemes, -1, error) ||
         !put_figure(report, here, PLOT_PHASE, m->scheme, m->schemes, -1, error)))
        return false;
    /* the runs of sections 2 to 4, in the order in which they were made */
    for (int i = 0; i < report->session->runs.count; i++)
        for (int s = SECTION_SIMULATION; s <= SECTION_SCHEMES; s++)
            for (int k = 0; k < m->runs[s]; k++)
                if (m->run[s][k] == i)
                    all[runs++] = i;
    for (int i = 0; i < runs; i++)
        if (is_first_of_its_motion(report, m, all, i))
            put_parameters(report, all[i]);
    put_runs(report, all, runs, false);
    put_measured_values(report, m->run[here], m->runs[here]);
    return true;
}

/* Writes all measured Reynolds numbers, each with its regime of flow. */
static void put_reynolds(struct report *report)
{
    struct document *document = &report->document;
    if (!find_value(report, "reynolds", NULL))
        return;
    document_open(document, BLOCK_LIST);
    for (int i = 0; i < report->values; i++) {
        const struct report_value *v = &report->value[i];
        if (strcmp(v->name, "reynolds") != 0)
            continue;
        document_open(document, BLOCK_ITEM);
        say_label(document, v);
        document_say(document, " = ");
        say_value(document, v);
        document_say(document, ", %s, at the largest speed of ", reynolds_regime(v->value.value));
        document_name(document, text_of(v->subject));
        document_close(document, BLOCK_ITEM);
    }
    document_close(document, BLOCK_LIST);
}

/* Writes up to REPORT_OVERLAY of the runs with these indices, each with parameters and figures,
 * beside its recording if shows_recording, then the energies of all in one figure. `here` is the
 * section. Returns false with *error. */
static bool put_each_run(struct report *report, enum section here, const int *run, int runs,
                         bool shows_recording, struct error *error)
{
    static const enum plot_kind kinds[] = {PLOT_POSITION, PLOT_ENERGY};
    const int shown = runs < REPORT_OVERLAY ? runs : REPORT_OVERLAY;
    for (int i = 0; i < shown; i++) {
        put_parameters(report, run[i]);
        for (size_t k = 0; k < COUNT_OF(kinds); k++)
            if (!put_figure(report, here, kinds[k], &run[i], 1,
                            shows_recording ? recording_beside(report, run[i], kinds[k]) : -1,
                            error))
                return false;
    }
    return shown < 2 || put_figure(report, here, PLOT_ENERGY, run, shown, -1, error);
}

/* Section 5: Reynolds numbers, and runs with other laws of drag. */
static bool drag_section_put(struct report *report, const struct material *m, struct error *error)
{
    const int *run = m->run[SECTION_DRAG], runs = m->runs[SECTION_DRAG];
    put_reynolds(report);
    if (runs == 0)
        return true;
    if (!put_each_run(report, SECTION_DRAG, run, runs, false, error))
        return false;
    put_runs(report, run, runs, false);
    put_measured_values(report, run, runs);
    return true;
}

/* Returns true if a subject ("data disk", "run 3") belongs to the second, damped session of the
 * lab: a recording by m->decays, a run by its section. */
bool of_second_session(const struct report *report, const char *subject)
{
    const struct material *m = report->material;
    const struct text name = text_of(subject);
    if (text_starts(name, TEXT("data "))) {
        const int index = session_find_recording(report->session, text_after(name, 5));
        return index >= 0 && m->decays[index];
    }
    for (int i = 0; i < m->runs[SECTION_DAMPED_SIMULATION]; i++) {
        char run[32];
        snprintf(run, sizeof run, "run %d",
                 run_at(report, m->run[SECTION_DAMPED_SIMULATION][i])->number);
        if (text_is(name, run))
            return true;
    }
    return false;
}

/* Writes a table of all values of gamma of the second session, so that those of the recording and
 * of the simulation can be compared. */
static void put_side_by_side(struct report *report)
{
    static const char *const heads[] = {"damping gamma", "of", "from"};
    struct document *document = &report->document;
    document_open(document, BLOCK_TABLE);
    document_open(document, BLOCK_ROW);
    for (size_t i = 0; i < COUNT_OF(heads); i++)
        document_put(document, BLOCK_HEAD, heads[i]);
    document_heading_ends(document);
    for (int i = 0; i < report->values; i++) {
        const struct report_value *v = &report->value[i];
        if (strcmp(v->name, "gamma") != 0 || !of_second_session(report, v->subject))
            continue;
        document_open(document, BLOCK_ROW);
        document_open(document, BLOCK_CELL);
        say_value(document, v);
        document_close(document, BLOCK_CELL);
        document_open(document, BLOCK_CELL);
        document_name(document, text_of(v->subject));
        document_close(document, BLOCK_CELL);
        document_put(document, BLOCK_CELL, v->source);
        document_close(document, BLOCK_ROW);
    }
    document_close(document, BLOCK_TABLE);
}

/* Section 7: damped runs with their recordings, distances from them, and the table of gamma. */
static bool damped_simulation_section_put(struct report *report, const struct material *m,
                                          struct error *error)
{
    const enum section here = SECTION_DAMPED_SIMULATION;
    if (m->runs[here] == 0)
        return true;
    if (!put_each_run(report, here, m->run[here], m->runs[here], true, error))
        return false;
    put_runs(report, m->run[here], m->runs[here], true);
    put_side_by_side(report);
    put_measured_values(report, m->run[here], m->runs[here]);
    return true;
}

/* Writes the section for scenes that are not of the lab: up to REPORT_OVERLAY runs with position,
 * energy, and orbit or phase plot, and a table of all. Returns false with *error. */
static bool other_section_put(struct report *report, const struct material *m, struct error *error)
{
    static const enum plot_kind kinds[] = {PLOT_POSITION, PLOT_ENERGY};
    const int *run = m->run[SECTION_OTHER], runs = m->runs[SECTION_OTHER];
    const int shown = runs < REPORT_OVERLAY ? runs : REPORT_OVERLAY;
    for (int i = 0; i < shown; i++) {
        const bool plane = plot_fits(PLOT_ORBIT, run_at(report, run[i])->system.model);
        put_parameters(report, run[i]);
        for (size_t k = 0; k < COUNT_OF(kinds); k++)
            if (!put_figure(report, SECTION_OTHER, kinds[k], &run[i], 1, -1, error))
                return false;
        if (!put_figure(report, SECTION_OTHER, plane ? PLOT_ORBIT : PLOT_PHASE, &run[i], 1, -1,
                        error))
            return false;
    }
    put_runs(report, run, runs, false);
    put_measured_values(report, run, runs);
    return true;
}

/* Section 1: recordings of the lab's first session. */
static bool recording_section_put(struct report *report, const struct material *m,
                                  struct error *error)
{
    return put_recordings(report, m, false, SECTION_RECORDING, error);
}

/* Section 6: recordings of the lab's second session. */
static bool damped_recording_section_put(struct report *report, const struct material *m,
                                         struct error *error)
{
    return put_recordings(report, m, true, SECTION_DAMPED_RECORDING, error);
}

static const struct {
    const char *part; /* part of the report; its heading is written where the part changes */
    const char *title;
    bool (*put)(struct report *report, const struct material *m, struct error *error);
} sections[SECTION_COUNT] = {
    [SECTION_RECORDING] = {"First session: no damping", "1. The recording", recording_section_put},
    [SECTION_SIMULATION] = {"First session: no damping", "2. Forward Euler",
                            simulation_section_put},
    [SECTION_ENERGY] = {"First session: no damping", "3. Energy", energy_section_put},
    [SECTION_SCHEMES] = {"First session: no damping", "4. Better schemes", schemes_section_put},
    [SECTION_DRAG] = {"Second session: damping", "5. Drag", drag_section_put},
    [SECTION_DAMPED_RECORDING] = {"Second session: damping", "6. The damped recording",
                                  damped_recording_section_put},
    [SECTION_DAMPED_SIMULATION] = {"Second session: damping", "7. The damped simulation",
                                   damped_simulation_section_put},
    [SECTION_OTHER] = {"Other systems", "Runs", other_section_put},
};

/* ---- all of them ---- */

/* Writes the sections of the lab if the session has anything of it, then other runs. Returns false
 * with *error if a figure fails. */
bool write_sections(struct report *report, struct error *error)
{
    const struct material *m = report->material;
    const bool lab = report_of_lab(report);
    const char *part = "";
    for (int i = SECTION_RECORDING; i < SECTION_COUNT; i++) {
        if (i == SECTION_OTHER ? m->runs[SECTION_OTHER] == 0 : !lab)
            continue;
        if (strcmp(part, sections[i].part) != 0)
            document_put(&report->document, BLOCK_PART, sections[i].part);
        part = sections[i].part;
        document_put(&report->document, BLOCK_SECTION, sections[i].title);
        if (!sections[i].put(report, m, error))
            return false;
        if (i != SECTION_OTHER)
            put_lacks(report, (enum section)i);
        put_questions(report, (enum section)i);
    }
    return true;
}
