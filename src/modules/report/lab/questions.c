/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The questions of the lab sheet: each is printed with the figures and values that its answer is
 * based on, and with an empty place for the answer. */
#include "modules/report/lab/material.h"

#include <hooke/base/statement.h>
#include <hooke/data.h>

#include <string.h>

#define KIND(kind) (1u << PLOT_##kind)

/* One question of the sheet, and the section of the report under which it is asked. */
static const struct question {
    int number;
    enum section section;
    const char *words;
    /* Set of KIND() bits: figures that the answer may cite, from its section or an earlier one. 0
     * means that the answer is derived on paper. */
    unsigned figures;
    const char *values[4]; /* names of values that the answer may cite */
} questions[] = {
    {1,
     SECTION_RECORDING,
     "Derivation of the equation of motion from Hooke's law, with its approximations",
     0,
     {NULL}},
    {3, SECTION_RECORDING, "The spring constant", KIND(POSITION), {"period", "k"}},
    {2, SECTION_SIMULATION, "Derivation of the scheme of forward Euler", 0, {NULL}},
    {4,
     SECTION_SIMULATION,
     "What forward Euler shows, and whether this was expected",
     KIND(POSITION) | KIND(VELOCITY) | KIND(PHASE),
     {NULL}},
    {5, SECTION_ENERGY, "What the energy shows", KIND(ENERGY), {"energy", "drift"}},
    {6,
     SECTION_ENERGY,
     "Why the phase plot should be an ellipse, and why it is not",
     KIND(PHASE),
     {NULL}},
    {7,
     SECTION_ENERGY,
     "The leading error of the method, from the Taylor expansion of y(t + dt)",
     0,
     {NULL}},
    {8,
     SECTION_SCHEMES,
     "How the other schemes change energy and phase plot",
     KIND(ENERGY) | KIND(PHASE),
     {NULL}},
    {9,
     SECTION_DRAG,
     "The Reynolds number of this system, and what it implies for the drag",
     0,
     {"reynolds"}},
    {10, SECTION_DAMPED_SIMULATION, "What damping does to the energy", KIND(ENERGY), {"gamma"}},
};

/* Writes what the answer to a question is based on: the numbers of the figures, as a sentence, then
 * the values, as a list. Writes nothing if the session has neither. */
static void put_evidence(struct report *report, const struct question *q)
{
    struct document *document = &report->document;
    const bool damped = q->section >= SECTION_DRAG;
    bool begun = false;
    for (int i = 0; i < report->figures; i++) {
        const struct report_figure *figure = &report->figure[i];
        /* Only earlier figures of the same session of the lab count; those of the recording are
         * cited only by questions on the recording. */
        if (!(q->figures & 1u << figure->kind) || figure->section > q->section ||
            (figure->section >= SECTION_DRAG) != damped ||
            (q->section != SECTION_RECORDING && figure->section == SECTION_RECORDING))
            continue;
        if (!begun)
            document_open(document, BLOCK_PARAGRAPH);
        document_say(document, begun ? ", figure %d" : "See figure %d", i + 1);
        begun = true;
    }
    if (begun) {
        document_say(document, ".");
        document_close(document, BLOCK_PARAGRAPH);
    }
    begun = false;
    for (int i = 0; i < report->values; i++)
        for (size_t k = 0; k < COUNT_OF(q->values) && q->values[k]; k++) {
            const struct report_value *v = &report->value[i];
            if (strcmp(v->name, q->values[k]) != 0 || strcmp(v->source, "parameter") == 0 ||
                (q->number != 9 && of_second_session(report, v->subject) != damped))
                continue;
            if (!begun)
                document_open(document, BLOCK_LIST);
            begun = true;
            document_open(document, BLOCK_ITEM);
            say_label(document, v);
            document_say(document, " = ");
            say_value(document, v);
            document_say(document, " (%s, ", v->source);
            document_name(document, text_of(v->subject));
            document_say(document, ")");
            document_close(document, BLOCK_ITEM);
        }
    if (begun)
        document_close(document, BLOCK_LIST);
}

/* Writes the questions of one section in the order of the table. */
void put_questions(struct report *report, enum section section)
{
    for (size_t i = 0; i < COUNT_OF(questions); i++) {
        const struct question *q = &questions[i];
        if (q->section != section)
            continue;
        document_open(&report->document, BLOCK_TOGETHER);
        document_open(&report->document, BLOCK_QUESTION);
        document_say(&report->document, "Q%d. %s", q->number, q->words);
        document_close(&report->document, BLOCK_QUESTION);
        put_evidence(report, q);
        document_answer(&report->document);
        document_close(&report->document, BLOCK_TOGETHER);
    }
}

/* ---- the figures of one question ---- */

/* Destination of a question's figures: each plot is a line of a script, whose file has the kind of
 * plot in its name if there are several. */
struct figure_lines {
    const struct report *report;
    struct text file; /* file of the figures; empty for the screen */
    bool several, is_forced;
    struct buffer *lines;
};

/* Appends " > FILE" and the end of a line. With several figures `kind` is inserted before the
 * extension of the file. */
static void put_destination(const struct figure_lines *figures, const char *kind)
{
    struct buffer name = {0}, *lines = figures->lines;
    const struct text file = figures->file;
    size_t end = file.len;
    while (end > 0 && file.data[end - 1] != '.' && file.data[end - 1] != '/')
        end--;
    end = end > 0 && file.data[end - 1] == '.' ? end - 1 : file.len;
    if (file.len > 0) {
        buffer_put(&name, (struct text){file.data, end});
        if (figures->several)
            buffer_format(&name, "-%s", kind);
        buffer_put(&name, text_after(file, end));
        buffer_put(lines, TEXT(" > "));
        buffer_quote(lines, buffer_text(&name));
        buffer_put(lines, figures->is_forced ? TEXT(" --force") : TEXT(""));
        lines->failed |= name.failed;
        buffer_free(&name);
    }
    buffer_char(lines, '\n');
}

/* Appends a command such as "plot energy run 1 2 > q8-energy.svg". */
static void put_figure_line(const struct figure_lines *figures, enum plot_kind kind, const int *run,
                            int runs, const char *recording)
{
    const char *name = plot_row(kind)->row.name;
    struct buffer *lines = figures->lines;
    buffer_format(lines, "plot %s", name);
    for (int i = 0; i < runs; i++)
        buffer_format(lines, "%s %d", i ? "" : " run", run_at(figures->report, run[i])->number);
    if (recording)
        buffer_format(lines, " data %s", recording);
    put_destination(figures, name);
}

/* Sets *run to the indices of the runs that a question is about. Returns their number, 0 if there
 * are none (or only one method to be compared). */
static int question_runs(const struct report *report, const struct question *q, const int **run)
{
    const struct material *m = report->material;
    *run = m->run[q->section];
    if (q->section == SECTION_SCHEMES) {
        *run = m->scheme;
        return m->schemes > 1 ? m->schemes : 0;
    }
    if (q->section == SECTION_SIMULATION || q->section == SECTION_ENERGY) {
        *run = &m->euler;
        return m->euler >= 0;
    }
    return m->runs[q->section] < REPORT_OVERLAY ? m->runs[q->section] : REPORT_OVERLAY;
}

/* Appends the commands that draw the figures of a question of the lab sheet, into `file` unless
 * that is empty; is_forced lets them replace files. Question 7 is answered by a table instead.
 * Returns false with *error if it needs a run or recording that is missing. */
bool question_figures(const struct report *report, int number, struct text file, bool is_forced,
                      struct buffer *lines, struct error *error)
{
    static const char *const missing[SECTION_COUNT] = {
        [SECTION_RECORDING] = "load FILE",
        [SECTION_SIMULATION] = "method euler; run",
        [SECTION_ENERGY] = "method euler; run",
        [SECTION_SCHEMES] = "compare euler symplectic-euler dt=10ms",
        [SECTION_DAMPED_SIMULATION] = "gamma = VALUE; run",
    };
    const struct question *q = NULL;
    for (size_t i = 0; i < COUNT_OF(questions); i++)
        if (questions[i].number == number)
            q = &questions[i];
    if (!q)
        return error_set(error, ERROR_COMMAND, "the lab sheet has questions 1 to 10");
    const struct figure_lines figures = {.report = report,
                                         .file = file,
                                         .several = (q->figures & (q->figures - 1)) != 0,
                                         .is_forced = is_forced,
                                         .lines = lines};
    if (number == 7) {
        buffer_put(lines, TEXT("taylor euler"));
        put_destination(&figures, "");
        return !lines->failed || error_memory(error);
    }
    if (!q->figures) {
        error_set(error, ERROR_COMMAND, "question %d does not ask for a figure", number);
        if (number == 9)
            error_hint(error, "'print Re' is the number that it asks for");
        return false;
    }
    const int *run;
    const int runs = question_runs(report, q, &run), first = report->material->first;
    const bool is_recorded = q->section == SECTION_RECORDING;
    if (is_recorded ? first < 0 : runs == 0) {
        error_set(error, ERROR_COMMAND, "question %d: there is no %s for its figure", number,
                  is_recorded ? "recording" : "run");
        return error_hint(error, "type: %s", missing[q->section]);
    }
    for (int kind = 0; kind < (int)plot_catalog.count; kind++)
        if (kind < 32 && q->figures & 1u << kind)
            put_figure_line(&figures, (enum plot_kind)kind, run, is_recorded ? 0 : runs,
                            is_recorded ? report->session->recording[first]->recording->name
                                        : NULL);
    return !lines->failed || error_memory(error);
}
