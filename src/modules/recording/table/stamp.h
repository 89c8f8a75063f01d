/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Dates and times of day, as instruments write them. */
#pragma once

#include <hooke/data.h>

struct stamp {
    bool date, clock; /* parts that the stamp has */
    int64_t day;      /* [d] days since 1970-01-01, 0 without a date */
    /* [s] time of the day in the zone in which it was written, or in UTC if the stamp names a
     * zone */
    double second;
};

/*
 * 2024-01-05T12:30:45.123Z, 2024/01/05 12:30, 05.01.2024 12:30:45,12, 1/5/2024, 12:30:45.123,
 * 12:30:45:123, 03:45.2 (minutes and seconds), 1:30:45 PM, 0 00:00:01.234 (days that have passed),
 * Fri Jan 05 12:30:45.123 2024. Where day and month could be either, the day comes first before a
 * '.', the month before a '/'. The whole text has to be a stamp.
 */
bool stamp_parse(struct text text, struct stamp *stamp);

/* Stamps of a column. */
struct stamp_column {
    size_t count, clocks; /* stamps, and those with a time of day */
    bool date;            /* every one of them has a date */
    int64_t first;        /* day of the first stamp */
};

/* [s] since the midnight before the column's first stamp. */
double stamp_seconds(struct stamp_column *column, struct text field);
/* Columns of stamps become times in seconds from their first: a date beside a time of day is joined
 * with it, a clock that passes midnight goes on. Says so. */
void stamp_columns(struct recording *recording, const struct stamp_column *column);
