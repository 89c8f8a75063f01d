/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The sections of a report, in the order of the lab sheet; each is there only if the session has
 * something for it. */
#include <hooke/report/lab.h>

#include <hooke/report.h>

#include <stdio.h>
#include <string.h>

/* What the session has, sorted by what it is for. */
struct material {
    int plain[LIMIT_RUNS], plains;       /* runs of a spring without drag and drive */
    int damped[LIMIT_RUNS], dampeds;     /* with them */
    int other[LIMIT_RUNS], others;       /* of something else */
    int scheme[REPORT_OVERLAY], schemes; /* of the plain ones: one a method, same step */
    bool decays[LIMIT_RECORDINGS];       /* recordings whose decay was measured */
};

static const struct run *run_at(const struct report *report, int index)
{
    return report->session->run[index]->run;
}

static bool is_method(const struct run *run, const char *name)
{
    return catalog_find(&method_catalog, text_of(name)) == &run->method->row;
}

/* ---- sorting ---- */

static void take_scheme(const struct report *report, struct material *m, int index)
{
    const struct run *run = run_at(report, index);
    if (m->schemes == REPORT_OVERLAY)
        return;
    for (int i = 0; i < m->schemes; i++)
        if (run_at(report, m->scheme[i])->method == run->method)
            return;
    const struct run *first = m->schemes ? run_at(report, m->scheme[0]) : run;
    if (run->plan.adaptive || first->plan.adaptive || run->settings.dt == first->settings.dt)
        m->scheme[m->schemes++] = index;
}

/* The lab's own methods first. */
static void choose_schemes(const struct report *report, struct material *m)
{
    static const char *const names[] = {"euler", "symplectic-euler", "backward-euler"};
    for (size_t k = 0; k < COUNT_OF(names); k++)
        for (int i = 0; i < m->plains; i++)
            if (is_method(run_at(report, m->plain[i]), names[k]))
                take_scheme(report, m, m->plain[i]);
    for (int i = 0; i < m->plains; i++)
        take_scheme(report, m, m->plain[i]);
}

static void sort_material(const struct report *report, struct material *m)
{
    const struct session *session = report->session;
    *m = (struct material){.plains = 0};
    for (int i = 0; i < session->runs; i++) {
        const struct run *run = run_at(report, i);
        if (trace_count(run->trace) < 2)
            continue;
        if (run->system.model != &oscillator_model)
            m->other[m->others++] = i;
        else if (run->plan.ledger)
            m->damped[m->dampeds++] = i;
        else
            m->plain[m->plains++] = i;
    }
    choose_schemes(report, m);
    for (int i = 0; i < session->recordings; i++) {
        int readings = 0;
        char of[LIMIT_NAME + 16];
        snprintf(of, sizeof of, "data %s", session->recording[i]->recording->name);
        for (int k = 0; k < report->values; k++) {
            const struct report_value *v = &report->value[k];
            if (strcmp(v->of, of) == 0 && strcmp(v->source, "measured") == 0)
                readings += strcmp(v->name, "gamma") == 0 ? 2 : isfinite(v->at);
        }
        m->decays[i] = readings >= 2;
    }
}

/* ---- sections ---- */

/* The laws that were compared, and what came of it. */
static void put_laws(struct document *document, const struct fit *fit)
{
    const char *law = drag_law_name(fit->preferred);
    if (!law)
        return;
    document_open(document, BLOCK_PARAGRAPH);
    document_say(document, "Law of damping (fit %s, integrated): %s; BIC", fit->model, law);
    for (int i = 0; i < fit->drag.candidates; i++)
        document_say(document, "%s %s %.6g", i ? "," : "",
                     drag_law_name(fit->drag.candidate[i].law), fit->drag.candidate[i].bic);
    document_say(document, ".");
    document_close(document, BLOCK_PARAGRAPH);
}

/* What the numbers of a recording took as exact, once for all of them. */
static void put_exact(struct report *report, const char *of)
{
    const struct session *session = report->session;
    struct document *document = &report->document;
    struct inputs inputs = {.exacts = 0};
    for (int i = 0; i < session->stored_fits; i++)
        if (strcmp(session->stored_fit[i].of, of) == 0)
            inputs_recall(&inputs, &session->stored_fit[i].exact);
    for (int i = 0; i < session->measurements; i++)
        if (strcmp(session->measurement[i].of, of) == 0)
            inputs_recall(&inputs, &session->measurement[i].exact);
    if (strcmp(session->adopted.of, of) == 0)
        inputs_recall(&inputs, &session->adopted.exact);
    if (inputs.exacts == 0)
        return;
    document_open(document, BLOCK_PARAGRAPH);
    document_say(document, "Stated without an uncertainty and taken as exact: ");
    for (int i = 0; i < inputs.exacts; i++)
        document_say(document, "%s%s", i ? ", " : "", inputs.exact[i]);
    document_say(document, ". What was computed with these is more uncertain if they are not.");
    document_close(document, BLOCK_PARAGRAPH);
}

static bool put_recording(struct report *report, int index, enum section section,
                          struct error *error)
{
    struct document *document = &report->document;
    const struct recording *recording = report->session->recording[index]->recording;
    struct buffer about = {0};
    char of[LIMIT_NAME + 16];
    snprintf(of, sizeof of, "data %s", recording->name);
    recording_describe(recording, &about);
    struct text rest = buffer_text(&about), line;
    document_open(document, BLOCK_PARAGRAPH);
    document_say(document, "Recording ");
    document_name(document, text_of(recording->name));
    document_say(document, ", of which %.6g to %.6g s are used, with the zero at ",
                 recording->window[0], recording->window[1]);
    say_measured(document, (struct measured){recording->zero, 0},
                 recording->column[recording->value].quantity);
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
    const bool ok = !about.failed
                        ? put_figure(report, section, PLOT_POSITION, NULL, 0, index, error)
                        : error_memory(error);
    buffer_free(&about);
    put_values(report, of, false);
    for (int i = 0; i < report->session->stored_fits; i++) {
        const struct stored_fit *stored = &report->session->stored_fit[i];
        if (strcmp(stored->of, of) == 0 && section == SECTION_DAMPED_RECORDING)
            put_laws(document, &stored->fit);
    }
    put_exact(report, of);
    return ok;
}

static bool put_recordings(struct report *report, const struct material *m, bool decays,
                           enum section section, struct error *error)
{
    for (int i = 0; i < report->session->recordings; i++)
        if (m->decays[i] == decays && !put_recording(report, i, section, error))
            return false;
    return true;
}

static void put_parameters(struct report *report, int index)
{
    char of[32];
    snprintf(of, sizeof of, "run %d", run_at(report, index)->number);
    document_open(&report->document, BLOCK_PARAGRAPH);
    document_say(&report->document, "Parameters of %s (%s):", of,
                 run_at(report, index)->method->row.name);
    document_close(&report->document, BLOCK_PARAGRAPH);
    put_values(report, of, true);
}

static void put_measured(struct report *report, const int *run, int runs)
{
    for (int i = 0; i < runs; i++) {
        char of[32];
        snprintf(of, sizeof of, "run %d", run_at(report, run[i])->number);
        bool any = false;
        for (int k = 0; k < report->values; k++)
            any |= strcmp(report->value[k].of, of) == 0 &&
                   strcmp(report->value[k].source, "parameter") != 0 &&
                   strcmp(report->value[k].source, "setting") != 0 &&
                   strcmp(report->value[k].source, "run") != 0;
        if (!any)
            continue;
        document_open(&report->document, BLOCK_PARAGRAPH);
        document_say(&report->document, "Measured on %s:", of);
        document_close(&report->document, BLOCK_PARAGRAPH);
        put_values(report, of, false);
    }
}

static bool simulation(struct report *report, const struct material *m, struct error *error)
{
    static const enum plot_kind kinds[] = {PLOT_POSITION, PLOT_VELOCITY, PLOT_PHASE};
    put_parameters(report, m->scheme[0]);
    for (size_t i = 0; i < COUNT_OF(kinds); i++)
        if (!put_figure(report, SECTION_SIMULATION, kinds[i], m->scheme, 1, -1, error))
            return false;
    return true;
}

static bool energy(struct report *report, const struct material *m, struct error *error)
{
    if (!put_figure(report, SECTION_ENERGY, PLOT_ENERGY, m->scheme, 1, -1, error))
        return false;
    put_runs(report, m->scheme, 1, false);
    put_measured(report, m->plain, m->plains);
    return true;
}

static bool schemes(struct report *report, const struct material *m, struct error *error)
{
    const enum section here = SECTION_SCHEMES;
    for (int i = 1; i < m->schemes; i++)
        if (is_method(run_at(report, m->scheme[i]), "symplectic-euler") &&
            (!put_figure(report, here, PLOT_POSITION, &m->scheme[i], 1, -1, error) ||
             !put_figure(report, here, PLOT_PHASE, &m->scheme[i], 1, -1, error)))
            return false;
    if (!put_figure(report, here, PLOT_ENERGY, m->scheme, m->schemes, -1, error) ||
        !put_figure(report, here, PLOT_PHASE, m->scheme, m->schemes, -1, error))
        return false;
    put_runs(report, m->plain, m->plains, false);
    return true;
}

static bool drag(struct report *report, const struct material *m, struct error *error)
{
    struct document *document = &report->document;
    (void)m;
    (void)error;
    document_open(document, BLOCK_LIST);
    for (int i = 0; i < report->values; i++) {
        const struct report_value *v = &report->value[i];
        if (strcmp(v->name, "reynolds") != 0)
            continue;
        document_open(document, BLOCK_ITEM);
        document_say(document, "Re = ");
        say_measured(document, v->value, v->quantity);
        document_say(document, ", %s, at the largest speed of ", reynolds_regime(v->value.value));
        document_name(document, text_of(v->of));
        document_close(document, BLOCK_ITEM);
    }
    document_close(document, BLOCK_LIST);
    return true;
}

/* The damping by everything that says it. */
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
        if (strcmp(v->name, "gamma") != 0)
            continue;
        document_open(document, BLOCK_ROW);
        document_open(document, BLOCK_CELL);
        say_measured(document, v->value, v->quantity);
        document_close(document, BLOCK_CELL);
        document_open(document, BLOCK_CELL);
        document_name(document, text_of(v->of));
        document_close(document, BLOCK_CELL);
        document_put(document, BLOCK_CELL, v->source);
        document_close(document, BLOCK_ROW);
    }
    document_close(document, BLOCK_TABLE);
}

static bool damped_simulation(struct report *report, const struct material *m, struct error *error)
{
    static const enum plot_kind kinds[] = {PLOT_POSITION, PLOT_ENERGY};
    const int shown = m->dampeds < REPORT_OVERLAY ? m->dampeds : REPORT_OVERLAY;
    put_parameters(report, m->damped[0]);
    for (int i = 0; i < shown; i++)
        for (size_t k = 0; k < COUNT_OF(kinds); k++)
            if (!put_figure(report, SECTION_DAMPED_SIMULATION, kinds[k], &m->damped[i], 1,
                            recording_beside(report, m->damped[i], kinds[k]), error))
                return false;
    if (shown > 1 &&
        !put_figure(report, SECTION_DAMPED_SIMULATION, PLOT_ENERGY, m->damped, shown, -1, error))
        return false;
    put_runs(report, m->damped, m->dampeds, true);
    put_side_by_side(report);
    put_measured(report, m->damped, m->dampeds);
    return true;
}

static bool others(struct report *report, const struct material *m, struct error *error)
{
    static const enum plot_kind kinds[] = {PLOT_POSITION, PLOT_ENERGY};
    const int shown = m->others < REPORT_OVERLAY ? m->others : REPORT_OVERLAY;
    for (int i = 0; i < shown; i++) {
        const bool plane = plot_fits(PLOT_ORBIT, run_at(report, m->other[i])->system.model);
        put_parameters(report, m->other[i]);
        for (size_t k = 0; k < COUNT_OF(kinds); k++)
            if (!put_figure(report, SECTION_OTHER, kinds[k], &m->other[i], 1, -1, error))
                return false;
        if (!put_figure(report, SECTION_OTHER, plane ? PLOT_ORBIT : PLOT_PHASE, &m->other[i], 1, -1,
                        error))
            return false;
    }
    put_runs(report, m->other, m->others, false);
    put_measured(report, m->other, m->others);
    return true;
}

static bool first_recordings(struct report *report, const struct material *m, struct error *error)
{
    return put_recordings(report, m, false, SECTION_RECORDING, error);
}

static bool damped_recordings(struct report *report, const struct material *m, struct error *error)
{
    return put_recordings(report, m, true, SECTION_DAMPED_RECORDING, error);
}

static const struct {
    const char *part; /* that begins here */
    const char *title;
    bool (*put)(struct report *report, const struct material *m, struct error *error);
} sections[SECTION_COUNT] = {
    [SECTION_RECORDING] = {"First session: no damping", "1. The recording", first_recordings},
    [SECTION_SIMULATION] = {"First session: no damping", "2. The simulation", simulation},
    [SECTION_ENERGY] = {"First session: no damping", "3. Energy", energy},
    [SECTION_SCHEMES] = {"First session: no damping", "4. Methods compared", schemes},
    [SECTION_DRAG] = {"Second session: damping", "5. Drag", drag},
    [SECTION_DAMPED_RECORDING] = {"Second session: damping", "6. The damped recording",
                                  damped_recordings},
    [SECTION_DAMPED_SIMULATION] = {"Second session: damping", "7. The damped simulation",
                                   damped_simulation},
    [SECTION_OTHER] = {"Other systems", "Runs", others},
};

static void find_sections(struct report *report, const struct material *m)
{
    for (int i = 0; i < report->session->recordings; i++)
        report->rested[m->decays[i] ? SECTION_DAMPED_RECORDING : SECTION_RECORDING] = true;
    report->rested[SECTION_SIMULATION] = report->rested[SECTION_ENERGY] = m->schemes > 0;
    report->rested[SECTION_SCHEMES] = m->schemes > 1;
    report->rested[SECTION_DRAG] = find_value(report, "reynolds") != NULL;
    report->rested[SECTION_DAMPED_SIMULATION] = m->dampeds > 0;
    report->rested[SECTION_OTHER] = m->others > 0;
}

bool write_sections(struct report *report, struct error *error)
{
    struct material *m = arena_alloc(report->arena, sizeof *m);
    const char *part = "";
    if (!m)
        return error_memory(error);
    sort_material(report, m);
    find_sections(report, m);
    for (int i = SECTION_RECORDING; i < SECTION_COUNT; i++) {
        if (!report->rested[i])
            continue;
        if (strcmp(part, sections[i].part) != 0)
            document_put(&report->document, BLOCK_PART, sections[i].part);
        part = sections[i].part;
        document_put(&report->document, BLOCK_SECTION, sections[i].title);
        if (!sections[i].put(report, m, error))
            return false;
        put_questions(report, (enum section)i, m->schemes ? run_at(report, m->scheme[0]) : NULL);
    }
    return true;
}

/* ---- what is missing ---- */

void report_missing(const struct report *report, void (*say)(void *context, const char *what),
                    void *context)
{
    static const struct {
        enum section section; /* 0: a value */
        const char *value, *what;
    } rows[] = {
        {SECTION_RECORDING, NULL, "the recording without damping (load FILE)"},
        {0, "period", "the period (measure period, or fit damped)"},
        {0, "k", "the spring constant (m = 200 g; fit damped)"},
        {SECTION_SIMULATION, NULL,
         "a simulation without damping (gamma = 0; method euler; run 10 s)"},
        {SECTION_SCHEMES, NULL, "methods compared (compare euler symplectic-euler)"},
        {SECTION_DRAG, NULL, "the Reynolds number (measure reynolds)"},
        {SECTION_DAMPED_RECORDING, NULL,
         "a damped recording with its decay (measure amplitude windows=6; measure decay)"},
        {SECTION_DAMPED_SIMULATION, NULL, "the damped simulation (fit damped; adopt; run)"},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        if (rows[i].section ? !report->rested[rows[i].section] : !find_value(report, rows[i].value))
            say(context, rows[i].what);
}
