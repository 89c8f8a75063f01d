/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Dates and times of day, as instruments write them. Readers call stamp_seconds() for each cell,
 * then stamp_columns() once. */
#pragma once

#include <hooke/data.h>

/* A date, a time of day, or both. */
struct stamp {
    bool date, clock; /* parts that the stamp has */
    int64_t day;      /* [d] days since 1970-01-01, 0 without a date */
    /* [s] time of day in the zone in which it was written, or in UTC if the stamp names a zone. */
    double second;
};

/* Parses a stamp; the whole text has to be one. Examples: 2024-01-05T12:30:45.123Z, 2024/01/05
 * 12:30, 05.01.2024 12:30:45,12, 1/5/2024, 12:30:45.123, 12:30:45:123, 03:45.2 (minutes and
 * seconds), 1:30:45 PM, 0 00:00:01.234 (days elapsed), Fri Jan 05 12:30:45.123 2024. If day and
 * month could be exchanged, the day comes first before '.', the month before '/' and '-'. Returns
 * false if it is not a stamp. */
bool stamp_parse(struct text text, struct stamp *stamp);

/* Statistics of the stamps of a column, filled by stamp_seconds(). */
struct stamp_column {
    size_t count, clocks; /* numbers of stamps, and of stamps with a time of day */
    bool date;            /* all stamps have a date */
    int64_t first;        /* [d] day of the first stamp */
};

/* Returns the stamp in `field` as seconds since the midnight before the column's first stamp, or
 * NAN if it is not one; counts it in the column. */
double stamp_seconds(struct stamp_column *column, struct text field);
/* Turns columns of stamps into times in seconds from their first stamp, with a warning. A column of
 * dates is added to the times of day beside it; a clock without a date continues past midnight.
 * column has an entry for each column of the recording. */
void stamp_columns(struct recording *recording, const struct stamp_column *column);
