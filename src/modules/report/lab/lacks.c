/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds which recordings, runs and values the sections of a lab report lack, and the commands that
 * add them. */
#include "modules/report/lab/material.h"
#include <hooke/data.h>

#include <stdio.h>
#include <string.h>

/* Returns true if the session has a recording or a run of one of the lab's sections. Others get no
 * headings of the lab and no list of what is missing. */
bool report_of_lab(const struct report *report)
{
    const struct material *m = report->material;
    if (report->session->recordings > 0)
        return true;
    for (int s = SECTION_RECORDING; s < SECTION_OTHER; s++)
        if (m->runs[s] > 0)
            return true;
    return false;
}

/* ---- what is missing ---- */

/* One thing that the report lacks, with the commands that produce it. */
struct lack {
    enum section section;
    const char *what; /* noun phrase: "the period" */
    const char *type; /* commands to type, with "of data %s" or "to %s" for the recording */
    int recording;    /* index of the recording that replaces %s, or -1 to leave that phrase out */
    bool spring;      /* the commands need the scene "spring" */
};

#define LACKS_MAX 10 /* number of rows in find_lacks() */

/* Returns true if a value of that name was found for the recording, or for anything if recording is
 * -1. */
static bool has_value_of(const struct report *report, const char *name, int recording)
{
    char subject[LIMIT_NAME + 16];
    if (recording < 0)
        return find_value(report, name, NULL) != NULL;
    snprintf(subject, sizeof subject, "data %s",
             report->session->recording[recording]->recording->name);
    return find_value(report, name, subject) != NULL;
}

/* Fills lack[] with what the session lacks for the lab's report, each with commands that produce
 * it, in the order of the sections. Returns their number. */
static int find_lacks(const struct report *report, struct lack lack[LACKS_MAX])
{
    const struct material *m = report->material;
    const int first = m->first, second = m->second;
    bool euler = false, symplectic = false;
    for (int i = 0; i < m->schemes; i++) {
        euler |= is_method(run_at(report, m->scheme[i]), "euler");
        symplectic |= is_method(run_at(report, m->scheme[i]), "symplectic-euler");
    }
    const struct {
        bool there; /* true if the session has it */
        struct lack lack;
    } rows[LACKS_MAX] = {
        {first >= 0, {SECTION_RECORDING, "the recording without damping", "load FILE", -1, false}},
        {has_value_of(report, "period", first),
         {SECTION_RECORDING, "the period", "measure period of data %s", first, false}},
        {has_value_of(report, "amplitude", first),
         {SECTION_RECORDING, "the amplitude", "measure amplitude of data %s", first, false}},
        {has_value_of(report, "k", first),
         {SECTION_RECORDING, "the spring constant", "m = 200 g; fit damped to %s", first, true}},
        {m->euler >= 0 && (recording_of(report, run_at(report, m->euler)) >= 0 ||
                           !is_damped(run_at(report, m->euler))),
         {SECTION_SIMULATION, "forward Euler without damping",
          "gamma = 0; method euler dt=10ms; run 10 s", -1, true}},
        {euler && symplectic,
         {SECTION_SCHEMES, "forward and symplectic Euler with the same step",
          "gamma = 0; compare euler symplectic-euler dt=10ms", -1, true}},
        {find_value(report, "reynolds", NULL) != NULL,
         {SECTION_DRAG, "the Reynolds number", "measure reynolds", -1, true}},
        {second >= 0, {SECTION_DAMPED_RECORDING, "the damped recording", "load FILE", -1, false}},
        {has_value_of(report, "gamma", second) && second >= 0,
         {SECTION_DAMPED_RECORDING, "its decay",
          "measure amplitude windows=6 of data %s; measure decay of data %s", second, false}},
        {m->runs[SECTION_DAMPED_SIMULATION] > 0,
         {SECTION_DAMPED_SIMULATION, "the damped simulation",
          "fit damped to %s; adopt; method rk4 dt=10ms; run 20 s", second, true}},
    };
    int lacks = 0;
    for (size_t i = 0; i < LACKS_MAX; i++)
        if (!rows[i].there)
            lack[lacks++] = rows[i].lack;
    return lacks;
}

/* Appends the commands that produce what is lacking. Each %s becomes the name of the recording;
 * without a recording the phrase around it is left out. Sets the scene first if the commands need a
 * spring and another one is in use. */
static void put_commands(const struct report *report, const struct lack *lack,
                         struct buffer *output)
{
    static const char *const parts[] = {" of data %s", " to %s"};
    const char *cursor = lack->type;
    if (lack->spring && report->session->setup.scene.model != &oscillator_model)
        buffer_put(output, TEXT("scene spring; "));
    while (*cursor) {
        bool found = false;
        for (size_t i = 0; i < COUNT_OF(parts) && !found; i++) {
            const size_t len = strlen(parts[i]);
            if (strncmp(cursor, parts[i], len) != 0)
                continue;
            found = true;
            cursor += len;
            if (lack->recording < 0)
                break;
            buffer_put(output, (struct text){parts[i], len - 2});
            buffer_word(output,
                        text_of(report->session->recording[lack->recording]->recording->name));
        }
        if (!found)
            buffer_char(output, *cursor++);
    }
}

/* Calls say() for each missing thing; does nothing if the session has nothing of the lab. The texts
 * are valid during the call only. */
void report_missing(const struct report *report,
                    void (*say)(void *context, const char *what, const char *type), void *context)
{
    struct lack lack[LACKS_MAX];
    const int lacks = report_of_lab(report) ? find_lacks(report, lack) : 0;
    for (int i = 0; i < lacks; i++) {
        struct buffer type = {0};
        put_commands(report, &lack[i], &type);
        say(context, lack[i].what, buffer_view(&type));
        buffer_free(&type);
    }
}

/* Writes "Missing: …" for each thing that the section lacks. */
void put_lacks(struct report *report, enum section section)
{
    struct document *document = &report->document;
    struct lack lack[LACKS_MAX];
    const int lacks = find_lacks(report, lack);
    for (int i = 0; i < lacks; i++) {
        struct buffer type = {0};
        if (lack[i].section != section)
            continue;
        put_commands(report, &lack[i], &type);
        document_open(document, BLOCK_PARAGRAPH);
        document_say(document, "Missing: %s. Commands that produce it: ", lack[i].what);
        document_name(document, buffer_text(&type));
        document_close(document, BLOCK_PARAGRAPH);
        buffer_free(&type);
    }
    if (section == SECTION_ENERGY && report->material->euler < 0)
        document_put(document, BLOCK_PARAGRAPH,
                     "Missing: the energy of forward Euler, which comes from the run of part 2.");
}
