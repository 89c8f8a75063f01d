/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The state line while a recording is collected, and the suggestion to take a point of a
 * calibration. */
#include "modules/collect/collecting.h"

#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>

#include <math.h>

/* Appends a quantity with three digits, without the blank before its unit unless `blanks` is set.
 */
static void put_quantity(struct buffer *output, double value, enum quantity quantity, bool blanks)
{
    struct buffer text = {0};
    buffer_quantity(&text, value, quantity, 3);
    for (size_t i = 0; i < text.len; i++)
        if (blanks || text.data[i] != ' ')
            buffer_char(output, text.data[i]);
    buffer_free(&text);
}

/* Appends a fitted value such as " T=0.72553(4)s", or nothing if it is not determined. */
static void put_fitted(struct buffer *output, const char *name, struct measured value,
                       const char *unit, bool blanks)
{
    if (!isfinite(value.value) || !(value.uncertainty > 0))
        return;
    buffer_format(output, " %s=", name);
    buffer_parenthesis(output, value.value, value.uncertainty);
    buffer_format(output, "%s%s", blanks && unit[0] ? " " : "", unit);
}

/* Appends the values of the live fit. */
static void put_live_fit(struct buffer *output, const struct collecting *now, bool blanks)
{
    buffer_put(output, TEXT("  fit"));
    if (!isfinite(now->fit.period.value))
        buffer_put(output, TEXT(": not determined yet"));
    put_fitted(output, "T", now->fit.period, "s", blanks);
    put_fitted(output, "gamma", now->fit.gamma, "", blanks);
    put_fitted(output, "k", now->fit.k, "N/m", blanks);
}

/* Appends the state of the collection: time, lines, period or fit, amplitude, delay. */
static void put_collecting(struct buffer *output, const struct collecting *now, bool counts,
                           bool blanks)
{
    static const char *const words[] = {[COLLECT_WAITING] = "WAITING",
                                        [COLLECT_GOES_ON] = "COLLECTING",
                                        [COLLECT_PAUSED] = "PAUSED"};
    const bool fits = isfinite(now->fit.t);
    buffer_format(output, "%s %.1f s", words[now->state], now->seconds);
    if (counts)
        buffer_format(output, "  %llu lines", (unsigned long long)now->lines);
    if (now->period > 0 && !fits) {
        buffer_put(output, TEXT("  T="));
        put_quantity(output, now->period, QUANTITY_TIME, blanks);
    }
    if (now->amplitude > 0 && now->quantity != QUANTITY_OTHER) {
        buffer_put(output, TEXT(" A="));
        put_quantity(output, now->amplitude, now->quantity, blanks);
    }
    if (fits)
        put_live_fit(output, now, blanks);
    if (counts && now->growing.late > 0) {
        buffer_put(output, TEXT("  v "));
        put_quantity(output, now->growing.late, QUANTITY_TIME, blanks);
        buffer_put(output, TEXT(" late"));
    }
}

struct collecting *session_collecting(const struct session *session)
{
    const struct collect_part *part = session_part_if_made(session, &collect_module);
    return part ? part->now : NULL;
}

bool collect_state(const struct session *session, bool counts, bool blanks, struct buffer *output)
{
    if (session_collecting(session))
        put_collecting(output, session_collecting(session), counts, blanks);
    return session_collecting(session) != NULL;
}

/* Appends "calibrate take" and returns true if a calibration waits for a point. */
bool collect_next(const struct session *session, struct buffer *line)
{
    const bool waits = session_collecting(session) && session_collecting(session)->aim.waits;
    buffer_put(line, waits ? TEXT("calibrate take") : TEXT(""));
    return waits;
}
