/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Verdicts of runs on both sides of a special point. */
#pragma once

/* The member `verified` of a branch point. Those below 0 name what contradicts the label. */
enum branch_verdict {
    VERDICT_CONFIRMED = 1,
    VERDICT_OPEN = 0, /* nothing could be decided */
    VERDICT_SAME_GROWTH = -1,
    VERDICT_OTHER_GROWTH = -2,
    VERDICT_NO_TURN = -3,
    VERDICT_OTHER_SIDE = -4
};

/* Returns what contradicts the label, as a part of a sentence; NULL if nothing does. */
const char *branch_contradiction(int verdict);
