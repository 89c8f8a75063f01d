/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Parses dates and times of day (stamp_parse()). A scan_ function moves the cursor past what it
 * reads. */
#include "modules/recording/table/stamp.h"

#include <string.h>
#include <strings.h>

/* Position in the text of a stamp. */
struct stamp_scan {
    const char *cursor, *end;
};

static bool stamp_take_char(struct stamp_scan *s, char c)
{
    const bool found = s->cursor < s->end && *s->cursor == c;
    s->cursor += found;
    return found;
}

static void scan_blanks(struct stamp_scan *s)
{
    while (s->cursor < s->end && *s->cursor == ' ')
        s->cursor++;
}

/* Reads up to `max` digits. Returns their number. */
static int scan_digits(struct stamp_scan *s, int max, int64_t *value)
{
    int count = 0;
    for (*value = 0; count < max && s->cursor < s->end && is_digit_char(*s->cursor); count++)
        *value = 10 * *value + (*s->cursor++ - '0');
    return count;
}

/* Returns the days since 1970-01-01 (Hinnant 2013, chrono-compatible low-level date algorithms). */
static int64_t days_from_civil(int64_t y, int64_t m, int64_t d)
{
    y -= m <= 2;
    const int64_t era = (y >= 0 ? y : y - 399) / 400, of_era = y - era * 400;
    const int64_t of_year = (153 * (m > 2 ? m - 3 : m + 9) + 2) / 5 + d - 1;
    return era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
}

/* Reads a date with '-', '/' or '.', of years 1900 to 9999, into *stamp; day and month are told
 * apart by size and mark. Returns false, with the cursor unchanged, if it is not one. */
static bool scan_date(struct stamp_scan *s, struct stamp *stamp)
{
    struct stamp_scan saved = *s;
    int64_t first, second, third;
    const int wide = scan_digits(s, 4, &first);
    const char mark = s->cursor < s->end ? *s->cursor : '\0';
    if (wide == 0 || !strchr("-/.", mark) || !mark || !stamp_take_char(s, mark) ||
        scan_digits(s, 2, &second) == 0 || !stamp_take_char(s, mark) ||
        scan_digits(s, 4, &third) == 0 || (s->cursor < s->end && is_digit_char(*s->cursor))) {
        *s = saved;
        return false;
    }
    int64_t year = first, month = second, day = third;
    if (wide < 3) {
        year = third < 100 ? 2000 + third : third;
        day = first;
        const bool month_first =
            (mark == '/' || mark == '-') ? second > 12 || first <= 12 : second > 12;
        if (month_first) {
            month = first;
            day = second;
        }
    }
    if (year < 1900 || year > 9999 || month < 1 || month > 12 || day < 1 || day > 31) {
        *s = saved;
        return false;
    }
    stamp->date = true;
    stamp->day = days_from_civil(year, month, day);
    return true;
}

/* Reads the digits after a decimal mark. One division gives the nearest double: 0.123 is
 * 123/1000. */
static double fraction(struct stamp_scan *s)
{
    int64_t number;
    static const double decimal_power10[] = {1,   1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                             1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
    const int count = scan_digits(s, 15, &number);
    const double value = (double)number / decimal_power10[count];
    while (s->cursor < s->end && is_digit_char(*s->cursor)) /* digits beyond those of a double */
        s->cursor++;
    return value;
}

/* Reads "AM" or "PM" if it comes next, and converts *hour to 0 to 23. Returns false if the hour
 * before it is not from 1 to 12. */
static bool scan_noon(struct stamp_scan *s, int64_t *hour)
{
    scan_blanks(s);
    if (s->end - s->cursor < 2 || strncasecmp(s->cursor + 1, "m", 1) != 0 ||
        !strchr("aApP", *s->cursor))
        return true;
    const bool is_afternoon = strchr("pP", *s->cursor) != NULL;
    s->cursor += 2;
    if (*hour < 1 || *hour > 12)
        return false;
    *hour = *hour % 12 + 12 * is_afternoon;
    return true;
}

/* Reads a time zone if one comes next, such as Z, +01:00 or -0530, and corrects *second to UTC.
 * Returns false if it is malformed. */
static bool scan_zone(struct stamp_scan *s, double *second)
{
    int64_t hours, minutes = 0;
    if (stamp_take_char(s, 'Z') || s->cursor == s->end || !strchr("+-", *s->cursor))
        return true;
    const double sign = *s->cursor++ == '-' ? 1 : -1;
    if (scan_digits(s, 2, &hours) != 2)
        return false;
    stamp_take_char(s, ':');
    scan_digits(s, 2, &minutes);
    *second += sign * (double)(hours * 3600 + minutes * 60);
    return true;
}

/* Reads a time of day. Returns false if it is not one; the cursor is unchanged if there is no hour
 * and ':'. */
static bool scan_clock(struct stamp_scan *s, struct stamp *stamp)
{
    struct stamp_scan saved = *s;
    int64_t hour, minute, second = 0, thousandth;
    double part = 0;
    const int wide = scan_digits(s, 4, &hour);
    if (wide == 0 || !stamp_take_char(s, ':') || scan_digits(s, 2, &minute) == 0) {
        *s = saved;
        return false;
    }
    const bool seconds = stamp_take_char(s, ':');
    if (seconds && scan_digits(s, 2, &second) == 0)
        return false;
    const bool decimals = stamp_take_char(s, '.') || stamp_take_char(s, ',');
    if (decimals)
        part = fraction(s);
    else if (seconds && stamp_take_char(s, ':')) {
        if (scan_digits(s, 3, &thousandth) != 3)
            return false;
        part = (double)thousandth / 1000;
    }
    if (!seconds && decimals) { /* minutes and seconds */
        second = minute;
        minute = hour;
        hour = 0;
    } else if (minute > 59 || !scan_noon(s, &hour)) {
        return false;
    }
    if (second > 60)
        return false;
    stamp->clock = true;
    stamp->second = (double)(hour * 3600 + minute * 60 + second) + part;
    return true;
}

/* Reads a number of elapsed days before a time: 0 00:00:01.234. Returns false, with the cursor
 * unchanged, if there is none. */
static bool scan_days(struct stamp_scan *s, struct stamp *stamp)
{
    const struct stamp_scan saved = *s;
    int64_t days;
    if (scan_digits(s, 4, &days) > 0 && stamp_take_char(s, ' ') && s->end - s->cursor > 2 &&
        is_digit_char(*s->cursor)) {
        stamp->date = true;
        stamp->day = days;
        return true;
    }
    *s = saved;
    return false;
}

/* Reads "Fri Jan 05 12:30:45.123 2024", the form of C's ctime(). Returns false if it is not one. */
static bool scan_ctime(struct stamp_scan *s, struct stamp *stamp)
{
    static const char months[] = "JanFebMarAprMayJunJulAugSepOctNovDec";
    int64_t day, year, month = 1;
    if (s->end - s->cursor < 20 || s->cursor[3] != ' ' || s->cursor[7] != ' ')
        return false;
    while (month <= 12 && memcmp(months + 3 * (month - 1), s->cursor + 4, 3) != 0)
        month++;
    s->cursor += 8;
    scan_blanks(s);
    if (month > 12 || scan_digits(s, 2, &day) == 0 || !stamp_take_char(s, ' ') ||
        !scan_clock(s, stamp))
        return false;
    scan_blanks(s);
    if (scan_digits(s, 4, &year) != 4)
        return false;
    stamp->date = true;
    stamp->day = days_from_civil(year, month, day);
    return true;
}

/* Reads a time stamp, which fills the text, into *stamp: days, a date, a time of day and a zone, as
 * far as they exist, or the form of ctime(). Returns false if it is none. */
bool stamp_parse(struct text text, struct stamp *stamp)
{
    text = text_trim(text);
    struct stamp_scan s = {text.data, text.data + text.len};
    *stamp = (struct stamp){0};
    if (text.len < 4 || text.len > 40)
        return false;
    if (!is_digit_char(text.data[0]))
        return scan_ctime(&s, stamp) && s.cursor == s.end;
    if (scan_days(&s, stamp))
        return scan_clock(&s, stamp) && s.cursor == s.end;
    if (scan_date(&s, stamp) && s.cursor < s.end && !stamp_take_char(&s, 'T') &&
        !stamp_take_char(&s, '_')) {
        if (*s.cursor != ' ' && *s.cursor != ',')
            return false;
        s.cursor++;
        scan_blanks(&s);
    }
    if (s.cursor < s.end && (!scan_clock(&s, stamp) || !scan_zone(&s, &stamp->second)))
        return false;
    return s.cursor == s.end && (stamp->date || stamp->clock);
}
