/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Kinds of findings with their remedies, and the sentence on masked samples. */
#include <hooke/base/catalog.h>
#include "modules/recording/clean/clean.h"

#define ROW(name, brief, remedy, done)                                                             \
    {                                                                                              \
        {name, "", brief, "", NULL}, remedy, done                                                  \
    }

static const struct finding_row rows[] = {
    [FINDING_SPIKES] = ROW("spikes", "missed echoes", REMEDY_MASK, "masked"),
    [FINDING_SHOULDERS] =
        ROW("shoulders", "double echoes, several samples in a row", REMEDY_MASK, "masked"),
    [FINDING_STUCK] = ROW("stuck", "repeated values during the motion", REMEDY_MASK, "masked"),
    [FINDING_CLIPPED] =
        ROW("clipped", "flat tops", REMEDY_KEEP, "kept; fits decide and report which to leave out"),
    [FINDING_QUANTISED] =
        ROW("steps", "few different values", REMEDY_KEEP, "kept; adds noise of step/sqrt(12)"),
    [FINDING_START] = ROW("start", "rest, hand or release before the free oscillation",
                          REMEDY_WINDOW, "left out by the window"),
    [FINDING_END] = ROW("end", "rest or hand after the free oscillation", REMEDY_WINDOW,
                        "left out by the window"),
    [FINDING_GAPS] = ROW("gaps", "gaps in time", REMEDY_KEEP, "kept; times are used unchanged"),
    [FINDING_MISSING] = ROW("missing", "rows without a value", REMEDY_KEEP, "left out"),
    [FINDING_REPEATED] =
        ROW("repeated", "rows that repeat the previous time", REMEDY_DROPPED, "dropped at loading"),
    [FINDING_BACKWARD] =
        ROW("backward", "rows whose time decreases", REMEDY_DROPPED, "dropped at loading"),
    [FINDING_SWAY] = ROW("sway", "the amplitude rises and falls, perhaps by sideways motion",
                         REMEDY_KEEP, "kept; gamma is less certain"),
};

const struct catalog finding_catalog = CATALOG("finding", rows);

/* Appends the number of masked samples of a cleaned recording in all, then by kind of fault, and
 * that of clipped ones. Appends nothing if it was not cleaned. */
void recording_describe_masked(const struct recording *recording, struct buffer *text)
{
    const struct findings *f = recording->findings;
    if (!recording->cleaned || !f)
        return;
    buffer_format(text, "cleaned: %zu of %zu samples masked", f->masked, recording->rows);
    int kinds = 0;
    for (size_t k = 0; k < FINDINGS; k++)
        if (rows[k].remedy == REMEDY_MASK && f->finding[k].count > 0)
            buffer_format(text, "%s%zu in %s", kinds++ ? ", " : " (", f->finding[k].count,
                          rows[k].row.name);
    buffer_put(text, kinds ? TEXT(")") : TEXT(""));
    if (f->finding[FINDING_CLIPPED].count > 0)
        buffer_format(text, "; %zu clipped", f->finding[FINDING_CLIPPED].count);
    buffer_put(text, TEXT("; 'data restore' undoes this\n"));
}
