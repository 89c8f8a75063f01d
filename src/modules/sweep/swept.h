/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A sweep as text and as a table. */
#pragma once

#include <hooke/base/unit.h>
#include <hooke/report.h>
#include "modules/sweep/compute/sweep.h"

/* A sweep with the names of its measures. */
struct swept {
    const struct sweep *sweep;
    const struct sweep_measure *measure;
    const struct model *model;
    int measures;
    const struct sweep_section *section;     /* NULL if measured over the duration */
    const struct sweep_attractor *attractor; /* [attractors] if they were measured */
    int attractors;
};

/* Returns how many events of point i were kept at the section, or 1 where there is none. */
int64_t swept_events(const struct swept *swept, int64_t i);
/* Returns measure m of point i, at event k of the section; -1 is the time of the event. */
double swept_value(const struct swept *swept, int64_t i, int64_t k, int m);
/* Returns after how many events the states of point i come again, or NAN if not within half of
 * those that were kept. */
double swept_repeats(const struct swept *swept, int64_t i);
double swept_position(const struct sweep *sweep, int axis, int64_t i);
enum quantity swept_quantity(const struct swept *swept, int m);
/* Sets the smallest and largest of the finite values of a measure, HUGE_VAL and -HUGE_VAL if there
 * are none. */
void swept_range(const struct swept *swept, int m, double *low, double *high);
/* Returns the unit in which a quantity of up to that size is shown, or NULL. */
const struct unit *swept_unit(double max, enum quantity quantity);
const char *swept_unit_name(const struct unit *unit, enum quantity quantity);
/* `count` places of a parameter, evenly from number `first` of its axis on, of `span` numbers.
 * Returns value NULL if out of memory. */
struct heat_axis swept_axis(const struct sweep *sweep, int axis, int64_t first, int64_t span,
                            int count, struct arena *arena);
/* Draws a value for each point of a sweep over two parameters; `heat` has the title and the unit.
 * A shard has gaps where the others belong. */
void swept_map(const struct session *session, const struct swept *swept, struct heat heat,
               double value(const struct swept *swept, int64_t i, int m), int m, int height,
               struct arena *arena, struct buffer *text);

/*
 * Makes the table of results. Its columns are point, the parameters, the measures, status. At a
 * section each event has a row, with its number and t before the measures, and behind them the
 * first measure at the next event (NAN after the last) and repeats. A point without events has one
 * row of NAN. Returns false if out of memory.
 */
bool swept_table(const struct swept *swept, struct arena *arena, struct table *table);

/* Writes the sweep in at most `rows` lines, figures before tables; 0 writes everything. */
void sweep_text(const struct session *session, const struct swept *swept, int rows,
                struct arena *arena, struct buffer *text);
/* The same at a section. It also writes how many points have fewer events than wanted. */
void diagram_text(const struct session *session, const struct swept *swept, int rows,
                  struct arena *arena, struct buffer *text);

/* "103 of 103 points in 0.1 s ...", and what went wrong. */
void sweep_summary(const struct sweep *sweep, struct buffer *text);
void sweep_failures(const struct sweep *sweep, struct buffer *text);

/* Draws the map as text of at most width x height cells, with its legend (heat.c). Returns false if
 * out of memory. */
bool heat_print(const struct heat *heat, int width, int height, const struct charset *charset,
                struct buffer *output);
