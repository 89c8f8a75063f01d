/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Verdicts of runs on both sides of a special point, and their texts. */
#pragma once

/* Values of the member `verified` of a branch point. Those below 0 name what contradicts the
 * label. */
enum branch_verdict {
    VERDICT_CONFIRMED = 1,
    VERDICT_OPEN = 0,          /* nothing could be decided */
    VERDICT_SAME_GROWTH = -1,  /* stability is the same on both sides */
    VERDICT_OTHER_GROWTH = -2, /* runs do not grow as eigenvalues predict */
    VERDICT_NO_TURN = -3,      /* the parameter does not turn back at the fold */
    VERDICT_OTHER_SIDE = -4    /* solutions exist on the wrong side */
};

/* Returns what contradicts the label, as part of a sentence, or NULL if nothing does. */
const char *branch_contradiction(int verdict);
