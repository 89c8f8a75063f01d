/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The results of a sweep as text, maps and a table. */
#pragma once

#include <hooke/base/unit.h>
#include <hooke/report.h>
#include "modules/sweep/compute/sweep.h"

/* A sweep with its measures, as functions below need it. Pointers are borrowed. */
struct swept {
    const struct sweep *sweep;
    const struct sweep_measure *measure; /* [measures] those whose values the sweep has */
    const struct model *model;
    int measures;
    const struct sweep_section *section; /* NULL if measured over the duration */
    /* [attractors] attractors of the points, if they were measured */
    const struct sweep_attractor *attractor;
    int attractors;
};

/* Returns how many events of point i were kept at the section, or 1 without a section. */
int64_t swept_events(const struct swept *swept, int64_t i);
/* Returns measure m of point i at event k of the section (0 without one); m = -1 is the time of the
 * event [s]. */
double swept_value(const struct swept *swept, int64_t i, int64_t k, int m);
/* Returns the number of events after which the states of point i repeat, or NAN if they do not
 * within half of those that were kept. Only at a section. */
double swept_repeats(const struct swept *swept, int64_t i);
/* Returns the value of a parameter at point i. */
double swept_position(const struct sweep *sweep, int axis, int64_t i);
/* Returns the quantity of measure m. */
enum quantity swept_quantity(const struct swept *swept, int m);
/* Sets the smallest and largest of the finite values of a measure, HUGE_VAL and -HUGE_VAL if there
 * are none. */
void swept_range(const struct swept *swept, int m, double *low, double *high);
/* Returns the unit in which quantities of up to `max` are shown, or NULL if the quantity has no
 * choice of units. */
const struct unit *swept_unit(double max, enum quantity quantity);
/* Returns the name of that unit, or if it is NULL that of the quantity's SI unit. */
const char *swept_unit_name(const struct unit *unit, enum quantity quantity);
/* Makes an axis of a map: `count` values of a parameter, evenly from number `first` of the sweep's
 * axis on over `span` numbers. Memory is from the arena; value is NULL if out of memory. */
struct heat_axis swept_axis(const struct sweep *sweep, int axis, int64_t first, int64_t span,
                            int count, struct arena *arena);
/* Draws value(swept, i, m) for each point of a sweep over two parameters as a map in text, `height`
 * rows high. `heat` has title and unit. Points of other shards are gaps. Draws nothing if out of
 * memory. */
void swept_map(const struct session *session, const struct swept *swept, struct heat heat,
               double value(const struct swept *swept, int64_t i, int m), int m, int height,
               struct arena *arena, struct buffer *text);

/* Makes the table of results in the arena. Its columns are point, the parameters, the measures,
 * status. At a section each event has a row, with event number and t before the measures, and
 * behind them the first measure at the next event (NAN after the last) and repeats. A point without
 * events has one row of NAN. Returns false if out of memory. */
bool swept_table(const struct swept *swept, struct arena *arena, struct table *table);

/* Appends the sweep in at most `rows` lines, where figures are preferred to tables; 0 appends
 * everything. */
void sweep_text(const struct session *session, const struct swept *swept, int rows,
                struct arena *arena, struct buffer *text);
/* Appends a sweep at a section in the same way, and how many points have fewer events than
 * wanted. */
void diagram_text(const struct session *session, const struct swept *swept, int rows,
                  struct arena *arena, struct buffer *text);

/* Append a line such as "103 of 103 points in 0.1 s ...", and lines on points that failed or were
 * refused. */
void sweep_summary(const struct sweep *sweep, struct buffer *text);
void sweep_failures(const struct sweep *sweep, struct buffer *text);

/* Draws a map as text of at most width * height cells, with axes and a legend (heat.c). Returns
 * false if out of memory. */
bool heat_print(const struct heat *heat, int width, int height, const struct charset *charset,
                struct buffer *output);
