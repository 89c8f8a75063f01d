/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Columns of dates and times of day as seconds that count from their first row. */
#include "modules/recording/table/stamp.h"
#include "modules/recording/table/table.h"

#include <math.h>
#include <stdio.h>

#define SECONDS_PER_DAY 86400.0 /* [s] */

/* The first stamp of a column sets the day from which seconds count. */
double stamp_seconds(struct stamp_column *column, struct text field)
{
    struct stamp stamp;
    if (!stamp_parse(field, &stamp))
        return NAN;
    if (column->count++ == 0)
        *column = (struct stamp_column){.count = 1, .date = stamp.date, .first = stamp.day};
    column->date &= stamp.date;
    column->clocks += stamp.clock;
    return (double)(stamp.day - column->first) * SECONDS_PER_DAY + stamp.second;
}

/* Returns true for a column of times of day. A date without time beside stamps with both is
 * midnight. */
static bool has_clock(const struct stamp_column *column)
{
    return column->clocks > 0 && (column->date || column->clocks == column->count);
}

/* Continues the times of a clock without date past midnight. Returns the number of midnights. */
static size_t pass_midnights(double *value, size_t rows)
{
    size_t midnights = 0;
    double previous = NAN;
    for (size_t i = 0; i < rows; i++) {
        if (isnan(value[i]))
            continue;
        const double now = value[i];
        midnights += previous - now > SECONDS_PER_DAY / 2;
        value[i] += SECONDS_PER_DAY * (double)midnights;
        previous = now;
    }
    return midnights;
}

/* Returns the column of dates that belongs to the column `clock` of times of day, or -1. */
static int dates_beside(const struct recording *recording, const struct stamp_column *column,
                        int clock)
{
    for (int i = 0; i < recording->columns; i++)
        if (i != clock && column[i].count > 0 && column[i].count >= column[clock].count / 2 &&
            !has_clock(&column[i]))
            return i;
    return -1;
}

/* Adds the dates to the times of day; an empty date repeats the one above. */
static void join_dates(struct recording *recording, int clock, int date)
{
    double *value = recording->column[clock].value, day = 0;
    for (size_t i = 0; i < recording->rows; i++) {
        day = isnan(recording->column[date].value[i]) ? day : recording->column[date].value[i];
        value[i] += day;
    }
}

/* Changes the times of column i to seconds from the first row, whose time of day is given in a
 * warning. */
static void count_from_first(struct recording *recording, int i)
{
    struct column *column = &recording->column[i];
    double first = NAN;
    for (size_t row = 0; row < recording->rows && isnan(first); row++)
        first = column->value[row];
    for (size_t row = 0; row < recording->rows; row++)
        column->value[row] -= first;
    snprintf(column->unit, sizeof column->unit, "s");
    column->quantity = QUANTITY_TIME;
    column->factor = 1;
    const double clock = fmod(first, SECONDS_PER_DAY);
    recording_warn(recording,
                   "%s contains dates or times of day; the time is counted in seconds from the "
                   "first, %02d:%02d:%06.3f",
                   column->name, (int)(clock / 3600), (int)(fmod(clock, 3600) / 60),
                   fmod(clock, 60));
}

/* Completes columns of time stamps: joins dates to times of day, continues past midnight, and
 * counts from the first row. Dates without a time of day become missing values. */
void stamp_columns(struct recording *recording, const struct stamp_column *column)
{
    for (int i = 0; i < recording->columns; i++) {
        if (column[i].count == 0 || !has_clock(&column[i]))
            continue;
        const int date = column[i].date ? -1 : dates_beside(recording, column, i);
        if (date >= 0)
            join_dates(recording, i, date);
        else if (!column[i].date)
            pass_midnights(recording->column[i].value, recording->rows);
        count_from_first(recording, i);
    }
    /* A date without a time of day is not the time of a sample. */
    for (int i = 0; i < recording->columns; i++)
        for (size_t row = 0; row < recording->rows && column[i].count > 0 && !has_clock(&column[i]);
             row++)
            recording->column[i].value[row] = NAN;
}
