/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Content of a session, sorted by the question of the lab that it answers. */
#pragma once

#include "modules/report/lab.h"

struct material {
    /* Places of the runs that stand in a section. Those of SECTION_SIMULATION are forward Euler's;
     * SECTION_ENERGY is about them, too, and SECTION_SCHEMES adds the other methods. */
    int run[SECTION_COUNT][LIMIT_RUNS], runs[SECTION_COUNT];
    /* place of the one that is looked at closely; -1 if there is none */
    int euler;
    int scheme[REPORT_OVERLAY], schemes; /* one a method: the same motion, the same step */
    bool decays[LIMIT_RECORDINGS];       /* recordings of the second session */
    int first, second;                   /* place of the first recording of each session; -1 */
};

/* Returns true if the subject of a value, such as "data disk" or "run 3", belongs to the damped
 * motion. */
bool of_second_session(const struct report *report, const char *subject);
/* Returns the recording whose fit gave the run its spring constant, or -1 if unknown. */
int recording_of(const struct report *report, const struct run *run);
/* A parameter or a setting. */
bool is_stated(const struct report_value *value);
/* It is told where what it is of is. */
bool stands_in_section(const struct report *report, const struct report_value *value);
/* Says under a heading what it lacks. */
void put_lacks(struct report *report, enum section section);
bool is_method(const struct run *run, const char *name);
bool is_damped(const struct run *run);
bool same_motion(const struct run *a,
                 const struct run *b); /* the same scene with the same values */

static inline const struct run *run_at(const struct report *report, int index)
{
    return report->session->runs.slot[index]->run;
}
