/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A precision study as tables, figure and records. */
#ifndef HOOKE_COMMAND_PRECISION_TEXT_H
#define HOOKE_COMMAND_PRECISION_TEXT_H

#include "export.h"

#define LEVELS 13
/* Letter of a curve in tables and figure. */
char precision_letter(int curve);
/* One table a method; a wide one has more columns. */
void precision_tables(const struct precision *precision, int width, struct arena *arena, struct buffer *out);
/* "fastest method for error 1e-k", and where it is an undamped oscillator predicted against measured evaluations. */
void precision_summary(const struct precision *precision, struct arena *arena, struct buffer *out);
/* "a euler  b verlet …", in lines of that width. */
void precision_legend(const struct precision *precision, int width, struct buffer *out);
/* Error over time, both logarithmic (over evaluations where nothing was timed); memory from the arena. */
bool precision_figure(const struct precision *precision, struct arena *arena, struct figure *figure,
                      struct error *error);
void reply_precision(const struct precision *precision, struct reply *reply);
bool precision_table(const struct precision *precision, struct export *export, struct error *error);

#endif
