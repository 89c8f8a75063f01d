/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Content of a session, sorted by the question of the lab sheet that it answers. sort_material()
 * (lab.h) fills in the struct after collect_values(); sections.c, questions.c and lacks.c read
 * it. */
#pragma once

#include "modules/report/lab.h"

/* The runs and recordings of a session, by section of the report. A run is given by its index in
 * session->runs.slot, a recording by its index in session->recording. */
struct material {
    /* Runs of each section, and their number. Those of SECTION_SIMULATION were made with forward
     * Euler; SECTION_ENERGY is about the same runs, SECTION_SCHEMES has those of other methods. */
    int run[SECTION_COUNT][LIMIT_RUNS], runs[SECTION_COUNT];
    /* Run of forward Euler whose figures the report shows, or -1 if no run of it is suitable. */
    int euler;
    /* Runs that are drawn in one figure, at most one of each method, with the same scene and
     * step. */
    int scheme[REPORT_OVERLAY], schemes;
    bool decays[LIMIT_RECORDINGS]; /* true for recordings of the lab's second session: damped */
    int first, second; /* first recording of each session of the lab, or -1 if there is none */
};

/* Returns true if the subject of a value, such as "data disk" or "run 3", belongs to the damped
 * motion of the lab's second session. */
bool of_second_session(const struct report *report, const char *subject);
/* Returns the index of the recording whose fit gave the run its spring constant, or -1 if none
 * did. */
int recording_of(const struct report *report, const struct run *run);
/* Returns true if the value was set by the user, as a parameter or a setting, and not measured or
 * computed. */
bool is_stated(const struct report_value *value);
/* Returns true if the value is reported in the section of its run or recording, and not only in the
 * table of runs or under the heading of drag. */
bool stands_in_section(const struct report *report, const struct report_value *value);
/* Writes which runs, recordings or values a section lacks, each with the command that adds it. */
void put_lacks(struct report *report, enum section section);
/* Returns true if the run was made with the method of that name. */
bool is_method(const struct run *run, const char *name);
/* Returns true if the scene of the run has any drag or friction. */
bool is_damped(const struct run *run);
/* Returns true if both runs have the same model and bitwise the same parameters and start. */
bool same_motion(const struct run *a, const struct run *b);

/* Returns the run with that index in the session. */
static inline const struct run *run_at(const struct report *report, int index)
{
    return report->session->runs.slot[index]->run;
}
