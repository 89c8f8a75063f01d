/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Blocks that the sections of a report are made of: tables of values, tables of runs, figures. */
#include "modules/report/lab.h"

#include "modules/report/lab/material.h"

#include "modules/pictures/pictures.h"

#include <hooke/data.h>
#include <hooke/base/number.h>
#include <hooke/report.h>
#include <hooke/session/log.h>

#include <stdio.h>
#include <string.h>

#define TEXT_WIDTH 100      /* [cell] width of a figure as text */
#define TEXT_HEIGHT 28      /* [cell] height of a figure as text */
#define ALL_COLUMNS 1000000 /* [cell] width at which no curve is reduced to an envelope */
#define VALUE_DIGITS 6      /* most digits of values that were stated, or of simulations */
#define ALL_DIGITS 15       /* most digits of values of recordings: their uncertainty limits them */
#define FEW_DIGITS 4        /* digits of values that have no uncertainty and were not stated */

/* ---- values ---- */

/* Recognizes the sources that report_add_run() gives to parameters and settings. */
bool is_stated(const struct report_value *value)
{
    return strcmp(value->source, "parameter") == 0 || strcmp(value->source, "setting") == 0;
}

/* Appends the value with a number of digits that its uncertainty limits if it is that of a
 * recording. That of a simulation is only rounding, so it does not choose the digits. */
void say_value(struct document *document, const struct report_value *value)
{
    const bool recorded = text_starts(text_of(value->subject), TEXT("data "));
    int digits = is_stated(value) ? VALUE_DIGITS : FEW_DIGITS;
    if (value->value.uncertainty > 0)
        digits = recorded ? ALL_DIGITS : VALUE_DIGITS;
    document_measured(document, value->value, value->quantity, digits);
}

/* Writes the name of a value in words, with the description of a parameter in parentheses. */
void say_label(struct document *document, const struct report_value *value)
{
    static const char *const labels[][2] = {
        {"k", "spring constant k"},
        {"reynolds", "Reynolds number Re"},
        {"omega", "angular frequency omega"},
        {"gamma", "damping gamma"},
        {"tau", "1/e time of the amplitude tau"},
        {"period", "period T"},
        {"frequency", "frequency f"},
        {"amplitude", "amplitude A"},
        {"m", "mass m"},
        {"y0", "initial position y0"},
        {"v0", "initial velocity v0"},
        {"dt", "step dt"},
        {"drift", "error of the energy at the end"},
        {"energy", "energy, mean and spread"},
    };
    const char *said = value->name;
    for (size_t i = 0; i < COUNT_OF(labels) && !value->brief; i++)
        if (strcmp(labels[i][0], value->name) == 0)
            said = labels[i][1];
    document_say(document, "%s", said);
    if (value->brief)
        document_say(document, " (%s)", value->brief);
}

/* Opens a table with these column heads; the caller adds rows and closes it. */
static void open_table(struct document *document, const char *const *heads, int count)
{
    document_open(document, BLOCK_TABLE);
    document_open(document, BLOCK_ROW);
    for (int i = 0; i < count; i++)
        document_put(document, BLOCK_HEAD, heads[i]);
    document_heading_ends(document);
}

/* Writes two cells: the name, with its time if it has one, and the value. */
static void put_name_and_value(struct document *document, const struct report_value *v)
{
    document_open(document, BLOCK_CELL);
    say_label(document, v);
    if (isfinite(v->t)) {
        document_say(document, " at t = ");
        document_measured(document, (struct measured){v->t, 0}, QUANTITY_TIME, VALUE_DIGITS);
    }
    document_close(document, BLOCK_CELL);
    document_open(document, BLOCK_CELL);
    say_value(document, v);
    document_close(document, BLOCK_CELL);
}

/* Writes the table of all values at the end of the report, each with the line of session.hk that it
 * comes from. */
void put_all_values(struct report *report)
{
    static const char *const heads[] = {"quantity", "value", "of", "from", "by line of session.hk"};
    struct document *document = &report->document;
    if (report->values == 0)
        return;
    document_put(document, BLOCK_PART, "All values");
    open_table(document, heads, COUNT_OF(heads));
    for (int i = 0; i < report->values; i++) {
        const struct report_value *v = &report->value[i];
        struct text statement;
        const int line = history_script_line(report->session, v->statement, &statement);
        document_open(document, BLOCK_ROW);
        put_name_and_value(document, v);
        document_open(document, BLOCK_CELL);
        document_name(document, text_of(v->subject));
        document_close(document, BLOCK_CELL);
        document_put(document, BLOCK_CELL, v->source);
        document_open(document, BLOCK_CELL);
        if (line > 0) {
            document_say(document, "%d: ", report->head + line);
            document_name(document, statement);
        } else {
            document_say(document, v->statement ? "-" : "the scene itself");
        }
        document_close(document, BLOCK_CELL);
        document_close(document, BLOCK_ROW);
    }
    document_close(document, BLOCK_TABLE);
}

/* Reynolds numbers are reported under the heading of drag if the report has one. */
bool stands_in_section(const struct report *report, const struct report_value *value)
{
    return strcmp(value->source, "run") != 0 &&
           (strcmp(value->name, "reynolds") != 0 || !report_of_lab(report));
}

/* Writes a table of the values of one subject, either the stated ones (`parameters`) or the others.
 * Writes nothing if there are none. */
void put_values(struct report *report, const char *subject, bool parameters)
{
    static const char *const heads[] = {"quantity", "value", "from"};
    struct document *document = &report->document;
    bool begun = false;
    for (int i = 0; i < report->values; i++) {
        const struct report_value *v = &report->value[i];
        if (strcmp(v->subject, subject) != 0 || is_stated(v) != parameters ||
            !stands_in_section(report, v))
            continue;
        if (!begun)
            open_table(document, heads, COUNT_OF(heads));
        begun = true;
        document_open(document, BLOCK_ROW);
        put_name_and_value(document, v);
        document_put(document, BLOCK_CELL, v->source);
        document_close(document, BLOCK_ROW);
    }
    if (begun)
        document_close(document, BLOCK_TABLE);
}

/* ---- runs ---- */

/* Columns of the table of runs, in order. */
enum run_column {
    RUN_NUMBER,
    RUN_METHOD,
    RUN_STEP,
    RUN_STEPS,
    RUN_END,
    RUN_ENERGY,
    RUN_BALANCE,
    RUN_ERROR,
    RUN_STATUS
};

/* Writes the cell in `column` of the table of runs to the document, "-" if the value is unknown.
 * Returns true if it is known, by which columns without values can be explained. */
static bool put_run_cell(struct document *document, const struct run *run, enum run_column column)
{
    struct buffer text = {0};
    struct ledger ledger;
    struct run_errors errors;
    switch (column) {
    case RUN_NUMBER:
        buffer_format(&text, "%d", run->number);
        break;
    case RUN_METHOD:
        buffer_put(&text, text_of(run->method->row.name));
        break;
    case RUN_STEP:
        buffer_put(&text, run->plan.adaptive ? TEXT("tol ") : TEXT(""));
        if (run->plan.adaptive)
            buffer_short(&text, run->settings.tol, 4);
        else
            buffer_measured(&text, (struct measured){run->settings.dt, 0}, QUANTITY_TIME, 4);
        break;
    case RUN_STEPS:
        buffer_format(&text, "%lld", (long long)run->steps);
        break;
    case RUN_END:
        buffer_measured(&text, (struct measured){run->t, 0}, QUANTITY_TIME, VALUE_DIGITS);
        break;
    case RUN_ENERGY:
        run_ledger(run, &ledger);
        buffer_short(&text, ledger.final / ledger.initial, FEW_DIGITS);
        break;
    case RUN_BALANCE:
        run_ledger(run, &ledger);
        buffer_short(&text, ledger.error_max, 3);
        break;
    case RUN_ERROR:
        run_errors(run, &errors);
        buffer_short(&text, errors.max, 3);
        break;
    case RUN_STATUS:
        buffer_put(&text, text_of(run_status(run)));
        break;
    }
    const bool known = strcmp(buffer_view(&text), "nan") != 0;
    document_put(document, BLOCK_CELL, known ? buffer_view(&text) : "-");
    buffer_free(&text);
    return known;
}

/* Explains the headings of the columns that have a filled cell. */
static void put_meaning(struct document *document, const bool filled[RUN_STATUS + 1])
{
    static const char *const meaning[RUN_STATUS + 1] = {
        [RUN_ENERGY] = "E/E0: energy at the end divided by the energy at the start.",
        [RUN_BALANCE] = "energy error: largest |E - E0|/E0, or largest error of the balance |E - "
                        "E0 - work|/E0 if drag or drive do work.",
        [RUN_ERROR] = "max error: largest distance from the exact motion, in amplitudes.",
    };
    bool begun = false;
    for (int c = 0; c <= RUN_STATUS; c++) {
        if (!meaning[c] || !filled[c])
            continue;
        if (!begun)
            document_open(document, BLOCK_PARAGRAPH);
        document_say(document, "%s%s", begun ? " " : "", meaning[c]);
        begun = true;
    }
    if (begun)
        document_close(document, BLOCK_PARAGRAPH);
}

/* Writes a list of the names and notes that the user gave to the runs with these indices, or
 * nothing if there are none. */
static void put_run_notes(struct report *report, const int *run, int runs)
{
    struct document *document = &report->document;
    bool begun = false;
    for (int i = 0; i < runs; i++) {
        const struct run_slot *slot = report->session->runs.slot[run[i]];
        if (!slot->note && !slot->run->name[0])
            continue;
        if (!begun)
            document_open(document, BLOCK_LIST);
        begun = true;
        document_open(document, BLOCK_ITEM);
        document_say(document, "run %d", slot->run->number);
        if (slot->run->name[0]) {
            document_say(document, " ");
            document_name(document, text_of(slot->run->name));
        }
        if (slot->note) {
            document_say(document, ", note: ");
            document_name(document, text_of(slot->note));
        }
        document_close(document, BLOCK_ITEM);
    }
    if (begun)
        document_close(document, BLOCK_LIST);
}

/* Writes a table of the runs with these indices, with a line that explains its columns and the
 * user's notes. `distance` adds a last column with the rms distance from the recording of each
 * run. */
void put_runs(struct report *report, const int *run, int runs, bool distance)
{
    static const char *const heads[] = {
        "run",  "method",       "step",      "steps",  "to t",
        "E/E0", "energy error", "max error", "status", "rms from the data"};
    struct document *document = &report->document;
    bool filled[RUN_STATUS + 1] = {false};
    open_table(document, heads, (int)COUNT_OF(heads) - !distance);
    for (int i = 0; i < runs; i++) {
        const struct run *one = report->session->runs.slot[run[i]]->run;
        document_open(document, BLOCK_ROW);
        for (int c = RUN_NUMBER; c <= RUN_STATUS; c++)
            filled[c] |= put_run_cell(document, one, (enum run_column)c);
        const int data = distance ? recording_beside(report, run[i], PLOT_POSITION) : -1;
        if (data >= 0) {
            struct recording *recording = report->session->recording[data]->recording;
            document_open(document, BLOCK_CELL);
            const struct data_distance distance_found = run_data_distance(one, recording);
            document_measured(document, (struct measured){distance_found.rms, 0},
                              distance_found.quantity, 3);
            document_say(document, ", ");
            document_name(document, text_of(recording->name));
            document_close(document, BLOCK_CELL);
        } else if (distance) {
            document_put(document, BLOCK_CELL, "-");
        }
        document_close(document, BLOCK_ROW);
    }
    document_close(document, BLOCK_TABLE);
    put_meaning(document, filled);
    put_run_notes(report, run, runs);
}

/* ---- figures ---- */

/* Returns the index of the recording that a run is compared with in a plot of that kind: the one
 * that its parameters were fitted to if that is known, else the nearest; -1 if none can be drawn
 * beside it. */
int recording_beside(struct report *report, int run, enum plot_kind kind)
{
    const struct session *session = report->session;
    int nearest = -1;
    double min = HUGE_VAL;
    const int fitted = recording_of(report, session->runs.slot[run]->run);
    for (int i = 0; i < session->recordings; i++) {
        if (fitted >= 0 && i != fitted)
            continue;
        report->view->runs.current = run;
        report->view->current_recording = i;
        const struct data_distance data =
            run_data_distance(session->runs.slot[run]->run, session->recording[i]->recording);
        const double rms = data.rms * fabs(data.gain); /* volts beside metres */
        if (rms < min && figure_recording(report->view, kind) == i) {
            min = rms;
            nearest = i;
        }
    }
    return nearest;
}

/* Sets the time window of a figure to all of its runs, or to the used part of its recording,
 * instead of the part that the screen would show. */
static void choose_time_window(const struct session *session, struct figure_request *request)
{
    if (plot_is_plane(request->kind))
        return;
    double t_begin = HUGE_VAL, t_end = -HUGE_VAL;
    for (int i = 0; i < request->runs; i++) {
        const struct trace *trace = session->runs.slot[request->run[i]]->run->trace;
        const double a = trace_time(trace, 0), b = trace_time(trace, trace_count(trace) - 1);
        t_begin = fmin(t_begin, fmin(a, b));
        t_end = fmax(t_end, fmax(a, b));
    }
    if (request->runs == 0) {
        const struct recording *recording = session->recording[request->recording]->recording;
        t_begin = recording->window[0];
        t_end = recording->window[1];
    }
    if (t_begin < t_end) {
        request->window[0] = t_begin;
        request->window[1] = t_end;
    }
}

/* Writes "Figure N: …" with the runs and the recording in it. */
static void put_caption(struct report *report, const struct figure_request *request)
{
    struct document *document = &report->document;
    const struct session *session = report->session;
    document_open(document, BLOCK_PARAGRAPH);
    document_say(document, "Figure %d: %s of ", report->figures, plot_row(request->kind)->row.name);
    for (int i = 0; i < request->runs; i++) {
        const struct run *run = session->runs.slot[request->run[i]]->run;
        document_say(document, "%srun %d (%s)", i ? ", " : "", run->number, run->method->row.name);
    }
    if (request->recording >= 0) {
        document_say(document, "%srecording ", request->runs ? " and " : "");
        document_name(document, text_of(session->recording[request->recording]->recording->name));
    }
    document_say(document, ".");
    document_close(document, BLOCK_PARAGRAPH);
}

/* Appends a description of the figure in words, based on all samples, not on the envelope that a
 * long one is drawn as; without the module of words its title. Returns false with *error. */
static bool put_figure_words(struct report *report, struct figure_request request,
                             struct buffer *words, struct error *error)
{
    struct arena arena = {0};
    struct figure figure;
    request.width = ALL_COLUMNS;
    const struct figure_words *spoken = charset_words();
    bool ok = session_figure(report->session, &request, &arena, &figure, error);
    if (ok && spoken)
        ok = spoken->describe(&figure, words) || error_memory(error);
    else if (ok)
        buffer_put(words, text_of(figure.title));
    arena_reset(&arena);
    return ok;
}

/* Writes the file name.end of the report. */
static bool put_figure_file(struct report *report, const char *name, const char *end,
                            const struct buffer *content, struct error *error)
{
    char file[64];
    snprintf(file, sizeof file, "%s.%s", name, end);
    return report_put(report, file, content, error);
}

/* Writes a figure as SVG and text, and as PDF for LaTeX if that can be drawn, and adds it to the
 * document with its description and caption. Returns false with *error on failure. */
static bool write_figure(struct report *report, const struct figure_request *request,
                         const struct figure *figure, const struct buffer *words,
                         struct error *error)
{
    char name[48];
    struct buffer text = {0}, svg = {0}, pdf = {0};
    struct error why = {0};
    struct figure untitled = *figure; /* the caption says it */
    untitled.title = NULL;
    snprintf(name, sizeof name, "figure-%02d-%s", report->figures,
             plot_row(request->kind)->row.name);
    bool ok = figure_print(figure, TEXT_WIDTH, TEXT_HEIGHT, &charset_ascii, false, &text) ||
              error_memory(error);
    ok = ok && figure_picture(&untitled, PICTURE_SVG, 0, 0, &svg, error) &&
         put_figure_file(report, name, "svg", &svg, error) &&
         put_figure_file(report, name, "txt", &text, error);
    if (report->latex && !report->no_pdf[0] && !picture_offered(PICTURE_PDF, &why))
        snprintf(report->no_pdf, sizeof report->no_pdf, "%s", why.text);
    const bool drawn = report->latex && !report->no_pdf[0];
    ok = ok && (!drawn || (figure_picture(&untitled, PICTURE_PDF, 0, 0, &pdf, error) &&
                           put_figure_file(report, name, "pdf", &pdf, error)));
    document_figure(&report->document,
                    &(struct document_picture){name, buffer_view(words), buffer_text(&svg),
                                               buffer_text(&text), drawn});
    put_caption(report, request);
    if (!ok && error->code != ERROR_IO) { /* that error names the file */
        why = *error;
        error_set(error, why.code, "%s: %s", name, why.text);
    }
    buffer_free(&text);
    buffer_free(&svg);
    buffer_free(&pdf);
    return ok;
}

/* Writes a figure of that kind for the runs with these indices and, unless negative, the recording
 * with that index. Counts the figure, so that questions can cite it, and marks what it shows, so
 * that write_data() writes their rows. Writes nothing if the kind does not fit the runs' scene.
 * Returns false with *error. */
bool put_figure(struct report *report, enum section section, enum plot_kind kind, const int *run,
                int runs, int recording, struct error *error)
{
    const struct session *session = report->session;
    struct figure_request request = {.kind = kind,
                                     .run = run,
                                     .runs = runs,
                                     .recording = recording,
                                     .window = {NAN, NAN},
                                     .width = PICTURE_COLUMNS,
                                     .charset = &charset_braille,
                                     .trail = HUGE_VAL};
    struct arena arena = {0}; /* frees what a figure takes for a long run */
    struct figure figure;
    struct buffer words = {0};
    if (runs > 0 && !plot_fits(kind, session->runs.slot[run[0]]->run->system.model))
        return true;
    if (report->figures == REPORT_FIGURES)
        return error_set(error, ERROR_COMMAND, "a report has at most %d figures", REPORT_FIGURES);
    choose_time_window(session, &request);
    /* One figure at a time: each takes 24 bytes a row. */
    bool ok = put_figure_words(report, request, &words, error) &&
              session_figure(session, &request, &arena, &figure, error);
    if (ok) {
        report->figure[report->figures++] = (struct report_figure){kind, section};
        for (int i = 0; i < runs; i++)
            report->run_shown[run[i]] = true;
        if (recording >= 0)
            report->recording_shown[recording] = true;
        ok = write_figure(report, &request, &figure, &words, error);
    }
    buffer_free(&words);
    arena_reset(&arena);
    return ok;
}
