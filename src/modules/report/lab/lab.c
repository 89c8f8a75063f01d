/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The numbers and data files of a report: collects values from measurements, fits and runs, and
 * writes values.csv, runs.csv, run-N.csv and recording-N.csv. */
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>
#include <hooke/base/unit.h>
#include <hooke/base/fields.h>
#include <hooke/base/folder_file.h>
#include <hooke/base/numeric.h>
#include "modules/report/lab.h"

#include "modules/recording/known/known.h"
#include "modules/recording/fits.h"
#include <hooke/report.h>
#include <hooke/session/log.h>

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define FIT_VALUES 16    /* largest number of reported values of one fit */
#define RUN_VALUES 8     /* largest number of reported values of one run besides its parameters */
#define OWN_NAME_MAX 200 /* [byte] longest name of a copied recording; file systems allow 255 */

/* Returns true if a report writes a file of this name, so that a new report may replace it. */
bool report_owns(const char *name)
{
    static const char *const names[] = {"report.md",  "report.html", "report.tex",
                                        "session.hk", "values.csv",  "runs.csv"};
    static const char *const starts[] = {"figure-", "run-", "recording-"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (strcmp(name, names[i]) == 0)
            return true;
    for (size_t i = 0; i < COUNT_OF(starts); i++)
        if (text_starts(text_of(name), text_of(starts[i])) && name[strlen(starts[i])] >= '0' &&
            name[strlen(starts[i])] <= '9')
            return true;
    return false;
}

/* Writes one file of the report, into the folder or to report->put, and counts it. Returns false
 * with *error if `content` ran out of memory or writing failed. */
bool report_put(struct report *report, const char *name, const struct buffer *content,
                struct error *error)
{
    report->files++;
    if (content->failed)
        return error_memory(error);
    return report->put ? report->put(report->context, name, buffer_text(content), error)
                       : folder_put(report->folder, name, buffer_text(content), error);
}

/* ---- values ---- */

/* Compares bits, so that NAN equals itself. */
static bool same_double(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* Adds a value to report->value, which has room for it. Leaves out values that are not finite, and
 * those that repeat an earlier one in name, subject, source, time and number. */
static void report_add_value(struct report *report, struct report_value value)
{
    if (!isfinite(value.value.value))
        return;
    for (int i = 0; i < report->values; i++) {
        const struct report_value *v = &report->value[i];
        if (strcmp(v->name, value.name) == 0 && strcmp(v->subject, value.subject) == 0 &&
            strcmp(v->source, value.source) == 0 &&
            same_double(v->value.value, value.value.value) && same_double(v->t, value.t))
            return;
    }
    report->value[report->values++] = value;
}

/* Returns factor * x with its uncertainty. */
static struct measured measured_scaled(double factor, struct measured x)
{
    return (struct measured){factor * x.value, fabs(factor) * x.uncertainty};
}

/* Returns the time 2/gamma in which the amplitude falls to 1/e, with its uncertainty. */
static struct measured decay_time(struct measured gamma)
{
    double least;
    return measured_reciprocal(2, gamma, &least);
}

/* Adds the result m of one `measure` statement to the report's values. A decay becomes the damping
 * rate gamma and, unless it is that of the energy, also tau = 2/gamma, the time in which the
 * amplitude falls to 1/e. */
static void add_measurement(struct report *report, const struct measurement *m)
{
    const bool decay = strcmp(m->quantity, "decay") == 0;
    struct report_value value = {m->quantity, m->value, m->unit,      m->source,
                                 "measured",  m->t,     m->statement, NULL};
    if (decay)
        value.name = "gamma";
    value.source = m->energy && m->unit != QUANTITY_ENERGY ? "measured, energy" : value.source;
    report_add_value(report, value);
    if (decay && !m->energy)
        report_add_value(report, (struct report_value){"tau", decay_time(m->value), QUANTITY_TIME,
                                                       m->source, "2/gamma, measured", NAN,
                                                       m->statement, NULL});
}

/* Adds the values of a stored fit to the report's values. `source` names the fit and its window; it
 * is not copied. */
static void add_fit(struct report *report, const struct stored_fit *stored, const char *source)
{
    const struct fit *fit = &stored->fit;
    const struct measured rms = {fit->rms, 0};
    /* The law that was fitted has no such term: no damping was measured, nor is it zero. */
    const bool linear = fit->drag.candidates == 0 || (fit->drag.best & LAW_LINEAR);
    const struct measured gamma = linear ? fit->gamma : (struct measured){NAN, NAN};
    const struct {
        const char *name;
        struct measured value;
        enum quantity quantity;
    } rows[FIT_VALUES] = {
        {"period", fit->period, QUANTITY_TIME},
        {"frequency", measured_scaled(1 / (2 * PI), fit->omega), QUANTITY_FREQUENCY},
        {"omega", fit->omega, QUANTITY_ANGULAR_FREQUENCY},
        {"amplitude", fit->amplitude, stored->quantity},
        {"phase", fit->phase, QUANTITY_ANGLE},
        {"offset", fit->offset, stored->quantity},
        {"k", stored->k, QUANTITY_STIFFNESS},
        {"gamma", gamma, QUANTITY_RATE},
        {"tau", decay_time(gamma), QUANTITY_TIME},
        {"gamma of the first half", fit->halves[0], QUANTITY_RATE},
        {"gamma of the second half", fit->halves[1], QUANTITY_RATE},
        {"rms of the residuals", rms, stored->quantity},
    };
    for (size_t i = 0; i < COUNT_OF(rows) && rows[i].name; i++)
        report_add_value(report, (struct report_value){rows[i].name, rows[i].value,
                                                       rows[i].quantity, stored->subject, source,
                                                       NAN, stored->statement, NULL});
}

/* Adds the values of a run to the report: parameters that influence its motion, step or tolerance,
 * energies and largest errors. `subject` ("run 3") names the run in each row; the pointer is kept,
 * so that the text must live as long as the report. */
static void report_add_run(struct report *report, const struct run_slot *slot, const char *subject)
{
    const struct run *run = slot->run;
    struct ledger ledger;
    struct run_errors errors;
    const struct scene *scene = &run->scene;
    const bool lab = is_oscillator(scene);
    run_ledger(run, &ledger);
    run_errors(run, &errors);
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        if (param_matters(scene, i) || param_is_start(scene, i))
            report_add_value(report,
                             (struct report_value){param_at(scene, i)->row.name,
                                                   {scene->value[i], scene->uncertainty[i]},
                                                   param_at(scene, i)->quantity,
                                                   subject,
                                                   "parameter",
                                                   NAN,
                                                   slot->origin[i],
                                                   lab ? NULL : param_at(scene, i)->row.brief});
    struct {
        const char *name;
        double value;
        enum quantity quantity;
        const char *source;
    } rows[] = {
        {"dt", run->settings.dt, QUANTITY_TIME, "setting"},
        {"energy at the start", ledger.initial, QUANTITY_ENERGY, "run"},
        {"energy at the end", ledger.final, QUANTITY_ENERGY, "run"},
        {run->plan.ledger ? "largest error of the energy balance" : "largest error of the energy",
         ledger.error_max, QUANTITY_NUMBER, "run"},
        {"largest error of the motion", errors.max, QUANTITY_NUMBER, "run"},
    };
    if (run->plan.adaptive) {
        rows[0].name = "tol";
        rows[0].value = run->settings.tol;
        rows[0].quantity = QUANTITY_NUMBER;
    }
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        report_add_value(report, (struct report_value){rows[i].name,
                                                       {rows[i].value, 0},
                                                       rows[i].quantity,
                                                       subject,
                                                       rows[i].source,
                                                       NAN,
                                                       slot->statement,
                                                       NULL});
}

/* Fills report->value with everything that was measured, fitted or set. Returns false with *error
 * if out of memory. */
bool collect_values(struct report *report, struct error *error)
{
    const struct session *session = report->session;
    /* a decay gives two values, gamma and tau */
    const size_t capacity = 2 * (size_t)session->measurements +
                            FIT_VALUES * (size_t)fits_of(session)->stored_fits +
                            (PARAM_MAX + RUN_VALUES) * (size_t)session->runs.count;
    report->value = arena_array(report->arena, capacity + 1, sizeof *report->value);
    if (!report->value)
        return error_memory(error);
    for (int i = 0; i < session->measurements; i++)
        add_measurement(report, &session->measurement[i]);
    for (int i = 0; i < fits_of(session)->stored_fits; i++) {
        const struct fit *fit = &fits_of(session)->stored_fit[i].fit;
        char source[96];
        snprintf(source, sizeof source, "fit %s, %.6g..%.6g s", fit->model, fit->window[0],
                 fit->window[1]);
        const char *stored = arena_text(report->arena, text_of(source));
        if (!stored)
            return error_memory(error);
        add_fit(report, &fits_of(session)->stored_fit[i], stored);
    }
    for (int i = 0; i < session->runs.count; i++) {
        char subject[32];
        snprintf(subject, sizeof subject, "run %d", session->runs.slot[i]->run->number);
        const char *stored = arena_text(report->arena, text_of(subject));
        if (!stored)
            return error_memory(error);
        report_add_run(report, session->runs.slot[i], stored);
    }
    return true;
}

/* Returns the first measured or computed value of that name and subject (NULL matches any subject),
 * or NULL. Parameters are not searched. */
const struct report_value *find_value(const struct report *report, const char *name,
                                      const char *subject)
{
    for (int i = 0; i < report->values; i++)
        if (strcmp(report->value[i].name, name) == 0 &&
            (!subject || strcmp(report->value[i].subject, subject) == 0) &&
            strcmp(report->value[i].source, "parameter") != 0)
            return &report->value[i];
    return NULL;
}

/* ---- files for programs ---- */

/* Writes a table as CSV, directly to the folder if the report has one, so that a long table is
 * never held in memory. Returns false with *error on failure or Ctrl-C. */
static bool put_table(struct report *report, const char *name, const struct table *table,
                      struct error *error)
{
    struct buffer content = {0};
    struct writer file;
    struct table cancellable = *table;
    cancellable.cancel = report->session->front.cancel;
    if (!report->put) {
        report->files++;
        return folder_file_open(report->folder, name, &file, error) &&
               table_send(&cancellable, table_csv, &file, error);
    }
    table_put(&cancellable, table_csv, &content);
    const bool ok =
        (!cancelled(cancellable.cancel) || error_set(error, ERROR_CANCELLED, "stopped")) &&
        report_put(report, name, &content, error);
    buffer_free(&content);
    return ok;
}

/* Writes values.csv, which has each value with unit, uncertainty, subject, source, and the line of
 * session.hk whose statement gave it. */
static bool write_values(struct report *report, struct error *error)
{
    enum { NAME, UNIT, OF, SOURCE, STATEMENT, TEXTS, VALUE = 0, UNCERTAINTY, AT, LINE, NUMBERS };
    const size_t n = (size_t)report->values;
    const char **text[TEXTS];
    double *number[NUMBERS];
    bool ok = true;
    for (int i = 0; i < TEXTS; i++)
        ok = (text[i] = arena_array(report->arena, n + 1, sizeof *text[i])) && ok;
    for (int i = 0; i < NUMBERS; i++)
        ok = (number[i] = arena_array(report->arena, n + 1, sizeof *number[i])) && ok;
    if (!ok)
        return error_memory(error);
    for (size_t i = 0; i < n; i++) {
        const struct report_value *v = &report->value[i];
        text[NAME][i] = v->name;
        text[UNIT][i] = quantity_unit(v->quantity);
        text[OF][i] = v->subject;
        text[SOURCE][i] = v->source;
        number[VALUE][i] = v->value.value;
        number[UNCERTAINTY][i] = v->value.uncertainty;
        number[AT][i] = v->t;
        struct text statement = TEXT("");
        const int line = history_script_line(report->session, v->statement, &statement);
        text[STATEMENT][i] = arena_text(report->arena, statement);
        /* session.hk begins with comments, report->head lines */
        number[LINE][i] = line ? report->head + line : NAN;
        if (!text[STATEMENT][i])
            return error_memory(error);
    }
    const struct table_column columns[] = {
        {.name = "name", .unit = "", .text = text[NAME]},
        {.name = "value", .unit = "", .value = number[VALUE]},
        {.name = "uncertainty", .unit = "", .value = number[UNCERTAINTY]},
        {.name = "unit", .unit = "", .text = text[UNIT]},
        {.name = "t", .unit = "s", .value = number[AT]},
        {.name = "of", .unit = "", .text = text[OF]},
        {.name = "source", .unit = "", .text = text[SOURCE]},
        {.name = "line", .unit = "", .value = number[LINE]},
        {.name = "statement", .unit = "", .text = text[STATEMENT]},
    };
    return put_table(report, "values.csv",
                     &(struct table){.column = columns, .columns = COUNT_OF(columns), .rows = n},
                     error);
}

/* Writes runs.csv, the table of `export FILE table` and, for runs that have a recording to compare
 * with, its name and the rms distance. Returns true without a file if there are no runs. */
static bool write_run_table(struct report *report, struct error *error)
{
    const struct session *session = report->session;
    struct export export = {.arena = report->arena};
    if (session->runs.count == 0)
        return true;
    if (!export_run_table(session, &export, error))
        return false;
    const int columns = export.table.columns;
    struct table_column *column = arena_array(report->arena, (size_t)columns + 2, sizeof *column);
    const char **data = arena_array(report->arena, (size_t)session->runs.count, sizeof *data);
    double *rms = arena_array(report->arena, (size_t)session->runs.count, sizeof *rms);
    if (!column || !rms || !data)
        return error_memory(error);
    memcpy(column, export.table.column, (size_t)columns * sizeof *column);
    for (int i = 0; i < session->runs.count; i++) {
        const int index = recording_beside(report, i, PLOT_POSITION);
        struct recording *recording = index < 0 ? NULL : session->recording[index]->recording;
        rms[i] = recording ? run_data_distance(session->runs.slot[i]->run, recording).rms : NAN;
        data[i] = recording ? recording->name : "";
    }
    column[columns] = (struct table_column){.name = "rms_from_data", .unit = "", .value = rms};
    export.table.column = column;
    column[columns + 1] = (struct table_column){.name = "data", .unit = "", .text = data};
    export.table.columns = columns + 2;
    export.table.keys = 0; /* those are the parameters of now, not of each run */
    return put_table(report, "runs.csv", &export.table, error);
}

static bool is_file(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISREG(st.st_mode);
}

/* Copies the file of recording `index` into the report's folder, so that its session can be
 * repeated wherever the folder is moved. A file that has changed since it was loaded, or is
 * missing, is left out, which is no error. Returns false with *error if the copy cannot be written.
 */
static bool put_own_file(struct report *report, int index, struct error *error)
{
    const struct recording *recording = report->session->recording[index]->recording;
    const struct text file = text_last_component(text_of(recording->path));
    struct buffer name = {0}, content = {0};
    struct error ignored;
    bool ok = true;
    buffer_format(&name, "recording-%d-%.*s", index + 1, (int)file.len, file.data);
    if (recording->sum != 0 && is_file(recording->path) && name.len < OWN_NAME_MAX &&
        file_read(recording->path, SUMMED_BYTES, &content, &ignored) &&
        bytes_sum(buffer_text(&content)) == recording->sum)
        ok = report_put(report, buffer_view(&name), &content, error);
    buffer_free(&name);
    buffer_free(&content);
    return ok;
}

/* Writes the recorded rows of a run as run-N.csv. Memory is of `arena`, which the caller resets. */
static bool write_run_rows(struct report *report, int index, struct arena *arena,
                           struct error *error)
{
    struct export export = {.arena = arena};
    struct item item = {.index = index};
    const struct argument_value run = {.count = 1, .item = &item}, none = {.count = 0};
    char name[64];
    snprintf(name, sizeof name, "run-%d.csv", report->session->runs.slot[index]->run->number);
    return export_runs(report->session, &run, &none, &none, &export, error) &&
           put_table(report, name, &export.table, error);
}

/* Writes the rows of a recording as recording-N.csv, and a copy of the file that it was loaded
 * from. Resets `arena` in between. */
static bool write_recording_rows(struct report *report, int index, struct arena *arena,
                                 struct error *error)
{
    struct export export = {.arena = arena};
    char name[64];
    report->view->current_recording = index;
    snprintf(name, sizeof name, "recording-%d.csv", index + 1);
    const bool ok = export_recording(report->view, &export, error) &&
                    put_table(report, name, &export.table, error);
    arena_reset(arena); /* the file is as large as its rows */
    return ok && put_own_file(report, index, error);
}

/* Writes the data files of all runs and recordings that appear in a figure. Returns false with
 * *error on failure. */
static bool write_data(struct report *report, struct error *error)
{
    const struct session *session = report->session;
    struct arena arena = {0};
    bool ok = true;
    for (int i = 0; i < session->runs.count && ok; i++) {
        ok = !report->run_shown[i] || write_run_rows(report, i, &arena, error);
        arena_reset(&arena);
    }
    for (int i = 0; i < session->recordings && ok; i++) {
        ok = !report->recording_shown[i] || write_recording_rows(report, i, &arena, error);
        arena_reset(&arena);
    }
    return ok;
}

bool write_tables(struct report *report, struct error *error)
{
    return write_values(report, error) && write_run_table(report, error) &&
           write_data(report, error);
}
