/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables for people: cells made one by one, columns as wide as their widest cell. */
#ifndef HOOKE_COMMAND_TEXT_TABLE_H
#define HOOKE_COMMAND_TEXT_TABLE_H

#include "internal.h"

#define TABLE_COLUMNS_MOST 24

struct text_table {
    struct arena *arena;
    int columns, gap, indent;
    int most; /* [cell] the gap becomes as small as 1 to fit into that; 0: never */
    int cells, room;
    const char **cell; /* row by row, the heading first */
    bool failed;       /* no memory: cells are missing */
};

void cell_text(struct text_table *table, const char *text);    /* copied; NULL: an empty cell */
void cell_take(struct text_table *table, struct buffer *text); /* the same from a buffer, which is freed */
void cell_quantity(struct text_table *table, double value, enum quantity quantity, int digits); /* "-": not finite */
void cell_error(struct text_table *table, double value);                                        /* 1.3e-05 */
void cell_count(struct text_table *table, int64_t value);
void cell_seconds(struct text_table *table, double seconds); /* with us below a millisecond */
const char *cell_last(const struct text_table *table);       /* the cell just made */
void buffer_step_time(struct buffer *text, const struct timing_result *time, int64_t steps); /* [ns], no unit */
void text_table_put(const struct text_table *table, struct buffer *out);

#endif
