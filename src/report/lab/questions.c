/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The questions of the lab sheet, each with what it rests on and an empty place for the answer. */
#include <hooke/report/lab.h>

#include <hooke/report.h>

#include <string.h>

#define KIND(kind) (1u << PLOT_##kind)

static const struct question {
    int number;
    enum section section;
    const char *words;
    const char *method;    /* of a run that it is about; NULL: any */
    const char *needs;     /* a value without which it has nothing to rest on; NULL: none */
    unsigned figures;      /* kinds, of its section and those before it */
    const char *values[4]; /* that it rests on */
} questions[] = {
    {1,
     SECTION_RECORDING,
     "From Hooke's law to the equation of motion, and the approximations on the way",
     NULL,
     NULL,
     KIND(POSITION),
     {NULL}},
    {3, SECTION_RECORDING, "The spring constant", NULL, "period", KIND(POSITION), {"period", "k"}},
    {2, SECTION_SIMULATION, "The scheme of forward Euler, derived", "euler", NULL, 0, {NULL}},
    {4,
     SECTION_SIMULATION,
     "What forward Euler shows, and whether that was to be expected",
     "euler",
     NULL,
     KIND(POSITION) | KIND(VELOCITY) | KIND(PHASE),
     {NULL}},
    {5,
     SECTION_ENERGY,
     "What the energy suggests",
     "euler",
     NULL,
     KIND(ENERGY),
     {"energy", "drift"}},
    {6,
     SECTION_ENERGY,
     "Why the phase plot should be an ellipse, and why it is not one",
     "euler",
     NULL,
     KIND(PHASE),
     {NULL}},
    {7,
     SECTION_ENERGY,
     "The leading error of the method, from the Taylor expansion of y(t + dt)",
     "euler",
     NULL,
     KIND(POSITION) | KIND(ENERGY),
     {NULL}},
    {8,
     SECTION_SCHEMES,
     "What the other schemes change in energy and phase plot",
     "euler",
     NULL,
     KIND(ENERGY) | KIND(PHASE),
     {NULL}},
    {9,
     SECTION_DRAG,
     "The Reynolds number of this system, and what it says of the drag",
     NULL,
     "reynolds",
     0,
     {"reynolds"}},
    {10,
     SECTION_DAMPED_SIMULATION,
     "What damping does to the energy",
     NULL,
     NULL,
     KIND(ENERGY),
     {"gamma"}},
};

static void put_rests(struct report *report, const struct question *q)
{
    struct document *document = &report->document;
    const bool damped = q->section >= SECTION_DRAG;
    bool begun = false;
    for (int i = 0; i < report->figures; i++) {
        const struct report_figure *figure = &report->figure[i];
        if (!(q->figures & 1u << figure->kind) || figure->section > q->section ||
            (figure->section >= SECTION_DRAG) != damped ||
            (q->section != SECTION_RECORDING && figure->section == SECTION_RECORDING))
            continue;
        if (!begun)
            document_open(document, BLOCK_PARAGRAPH);
        document_say(document, begun ? ", figure %d" : "It rests on figure %d", i + 1);
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
            if (strcmp(v->name, q->values[k]) != 0 || strcmp(v->source, "parameter") == 0)
                continue;
            if (!begun)
                document_open(document, BLOCK_LIST);
            begun = true;
            document_open(document, BLOCK_ITEM);
            document_say(document, "%s = ", v->name);
            say_measured(document, v->value, v->quantity);
            document_say(document, " (%s, ", v->source);
            document_name(document, text_of(v->of));
            document_say(document, ")");
            document_close(document, BLOCK_ITEM);
        }
    if (begun)
        document_close(document, BLOCK_LIST);
}

void put_questions(struct report *report, enum section section, const struct run *first)
{
    for (size_t i = 0; i < COUNT_OF(questions); i++) {
        const struct question *q = &questions[i];
        bool offered = q->section == section && (!q->needs || find_value(report, q->needs));
        if (offered && q->method)
            offered =
                first && catalog_find(&method_catalog, text_of(q->method)) == &first->method->row;
        if (!offered)
            continue;
        document_open(&report->document, BLOCK_TOGETHER);
        document_open(&report->document, BLOCK_QUESTION);
        document_say(&report->document, "Q%d. %s", q->number, q->words);
        document_close(&report->document, BLOCK_QUESTION);
        put_rests(report, q);
        document_answer(&report->document);
        document_close(&report->document, BLOCK_TOGETHER);
    }
}
