/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Tables of the kinds that strangers sent and that were not read, or not whole, with random numbers
 * of rows and columns, separators and decimal marks. What the generator wrote has to come back. The
 * controls look like these kinds and are none.
 */
#include "modules/recording/data/fixture.h"

enum { ROWS_MAX = 700, FILES_OF_A_KIND = 40 };

struct file {
    uint64_t random;
    struct buffer text;
    char separator, decimal;
    double step; /* [s] */
    int rows;
    double t[ROWS_MAX], y[ROWS_MAX]; /* as they should be read, t from 0 */
    const char *options;
    int time, value;   /* columns, from 0 */
    const char *said;  /* part of a warning; NULL: none is asked for */
    const char *named; /* the value's column; NULL: not looked at */
};

static uint64_t next(struct file *f) /* xorshift64*, Vigna 2016 */
{
    f->random ^= f->random >> 12;
    f->random ^= f->random << 25;
    f->random ^= f->random >> 27;
    return f->random * 2685821657736338717u;
}

static int between(struct file *f, int low, int high)
{
    return low + (int)(next(f) % (uint64_t)(high - low + 1));
}

static double noise(struct file *f)
{
    return (double)(next(f) % 10000) / 10000 - 0.5;
}

static void put_real(struct file *f, double x, int digits)
{
    char number[64];
    snprintf(number, sizeof number, "%.*f", digits, x);
    for (char *c = number; *c; c++)
        buffer_char(&f->text, *c == '.' ? f->decimal : *c);
}

static void put_separator(struct file *f)
{
    buffer_char(&f->text, f->separator);
}

static void put_y(struct file *f, int i)
{
    put_real(f, f->y[i], 3);
}

static void end_row(struct file *f)
{
    buffer_put(&f->text, TEXT("\n"));
}

/* A damped motion of three decimals, evenly sampled at whole milliseconds. */
static void begin(struct file *f, uint64_t seed)
{
    static const struct {
        char separator, decimal;
    } dialects[] = {{',', '.'}, {';', '.'}, {';', ','}, {'\t', '.'}, {'\t', ','}};
    *f = (struct file){.random = 88172645463325252u + seed * 7919, .options = "", .value = 1};
    for (int i = 0; i < 8; i++)
        next(f);
    const int dialect = between(f, 0, 4);
    f->separator = dialects[dialect].separator;
    f->decimal = dialects[dialect].decimal;
    f->rows = between(f, 60, ROWS_MAX);
    f->step = 1e-3 * between(f, 5, 50);
    for (int i = 0; i < ROWS_MAX; i++) {
        f->t[i] = f->step * i;
        f->y[i] =
            1e-3 *
            nearbyint(1e3 * (25 + 4 * cos(7.3 * f->t[i]) * exp(-0.05 * f->t[i]) + 0.05 * noise(f)));
    }
}

/* ---- kinds: each writes the file, and what is to be read from it where it differs ---- */

static void names(struct file *f, const char *more)
{
    buffer_format(&f->text, "Time (s)%cPosition (cm)%s\n", f->separator, more);
}

/* Formulas beside some rows: the others are shorter, or have fewer numbers than they. */
static void formula_beside(struct file *f)
{
    const int first = next(f) % 2 ? 0 : between(f, 0, 30), last = first + between(f, 3, 29),
              blanks = between(f, 1, 2), each = next(f) % 4 ? 0 : between(f, 2, 3);
    if (next(f) % 2)
        names(f, "");
    for (int i = 0; i < f->rows; i++) {
        const bool beside = each ? i % each == 0 : i >= first && i < last;
        put_real(f, f->t[i], 3);
        put_separator(f);
        put_y(f, i);
        for (int k = 0; k < blanks && beside; k++)
            put_separator(f);
        if (beside)
            put_real(f, f->y[i] / 9.8, 4);
        end_row(f);
    }
}

static void tektronix_with_names(struct file *f)
{
    static const char *const settings[] = {"Record Length,2500", "Sample Interval,0.01",
                                           "Trigger Point,50",   "Source,CH1",
                                           "Vertical Units,V",   "Horizontal Units,s"};
    const int count = (int)COUNT_OF(settings);
    f->decimal = '.';
    f->separator = ',';
    for (int above = between(f, 0, 2); above > 0; above--)
        buffer_put(&f->text, above == 1 ? TEXT(",,,time,angle,\n") : TEXT(",,,,,\n"));
    for (int i = 0; i < f->rows; i++) {
        buffer_format(&f->text, "%s,,", i < count ? settings[i] : ",");
        put_real(f, f->t[i], 9);
        buffer_put(&f->text, TEXT(", "));
        put_y(f, i);
        buffer_put(&f->text, TEXT(",\n"));
    }
}

static void time_anywhere(struct file *f)
{
    const int others = between(f, 0, 2);
    f->time = between(f, 0, others + 1);
    f->value = f->time == 0 ? 1 : 0;
    f->options = f->value ? "y=2" : "y=1";
    f->said = "is taken as the time";
    for (int i = 0; i < f->rows; i++) {
        for (int c = 0; c < others + 2; c++) {
            if (c > 0)
                put_separator(f);
            if (c == f->time)
                put_real(f, f->t[i] + 2.5, 3);
            else if (c == f->value)
                put_y(f, i);
            else
                put_real(f, 5 * noise(f), 3);
        }
        end_row(f);
    }
}

static void labels_before(struct file *f)
{
    const bool two = next(f) % 2;
    f->time = two ? 2 : 1;
    f->value = f->time + 1;
    for (int i = 0; i < f->rows; i++) {
        buffer_format(&f->text, "run%c", f->separator);
        if (two)
            buffer_format(&f->text, "%s%c", i % 2 ? "left" : "right", f->separator);
        put_real(f, f->t[i], 3);
        put_separator(f);
        put_y(f, i);
        end_row(f);
    }
}

/* A clock of hundredths or tenths of a second repeats itself. */
static void repeated_stamps(struct file *f)
{
    f->step = 1e-3 * between(f, 4, 9);
    for (int i = 0; i < f->rows; i++) {
        f->t[i] = f->step * i;
        put_real(f, floor(100 * f->t[i] + 1e-9) / 100, 2);
        put_separator(f);
        put_y(f, i);
        end_row(f);
    }
    f->said = "all rows are kept";
}

static void thousands_in_one_column(struct file *f)
{
    f->separator = next(f) % 2 ? ';' : '\t';
    f->decimal = next(f) % 2 ? ',' : '.';
    f->step = 1e-3 * between(f, 10, 90);
    f->rows = between(f, 150, ROWS_MAX);
    /* Thousands only: the mark of the other column tells, if it is no group of three digits. */
    const int start = next(f) % 2 ? 0 : 1000 * between(f, 1, 20), digits = start ? 2 : 3;
    buffer_format(&f->text, "t (ms)%cx (cm)\n", f->separator);
    for (int i = 0; i < f->rows; i++) {
        f->t[i] = f->step * i;
        const int ms = (int)nearbyint(1e3 * f->t[i]) + start;
        if (ms >= 1000)
            buffer_format(&f->text, "%d%c%03d", ms / 1000, f->decimal == ',' ? '.' : ',',
                          ms % 1000);
        else
            buffer_format(&f->text, "%d", ms);
        put_separator(f);
        f->y[i] = 1e-2 * nearbyint(1e2 * f->y[i]);
        put_real(f, f->y[i], digits);
        end_row(f);
    }
    f->said = "separator of thousands";
}

static void stamps_before_lines(struct file *f)
{
    static const struct {
        const char *open, *close;
    } forms[] = {{"[2024-01-05 ", "] "},
                 {"[", "] "},
                 {"[0 ", "] "},
                 {"[Fri Jan 05 ", " 2024] "},
                 {"", " -> "}};
    const int form = between(f, 0, 4), start = between(f, 0, 80000000);
    const char marks[] = {';', '\t', ',', ' '};
    f->separator = marks[between(f, 0, form == 4 ? 2 : 3)];
    f->decimal = '.';
    for (int i = 0; i < f->rows; i++) {
        const int ms = start + (int)nearbyint(1e3 * f->t[i]);
        buffer_format(&f->text, "%s%02d:%02d:%02d.%03d%s", forms[form].open, ms / 3600000,
                      ms / 60000 % 60, ms / 1000 % 60, ms % 1000, forms[form].close);
        put_y(f, i);
        put_separator(f);
        put_real(f, noise(f), 2);
        end_row(f);
    }
    f->options = "y=2";
    f->said = "dates or times of day";
}

static void clock_set_back(struct file *f)
{
    const int jumps = between(f, 1, 2);
    double back = 0;
    names(f, "");
    for (int i = 0; i < f->rows; i++) {
        if (i > 0 && i % (f->rows / (jumps + 1)) == 0 && i + 10 < f->rows)
            back += 1e-3 * between(f, (int)(1e3 * f->step) + 1, (int)(5e3 * f->step));
        put_real(f, f->t[i] - back, 3);
        put_separator(f);
        put_y(f, i);
        end_row(f);
    }
    f->said = "the clock jumps back";
}

static void octave_matrix(struct file *f)
{
    f->separator = ' ';
    f->decimal = '.';
    buffer_format(&f->text,
                  "# Created by Octave 8.4.0, Fri Jan 05 12:30:45 2024 UTC <a@b>\n# name: swing\n"
                  "# type: matrix\n# rows: %d\n# columns: 2\n",
                  f->rows);
    for (int i = 0; i < f->rows; i++) {
        buffer_put(&f->text, TEXT(" "));
        put_real(f, f->t[i], 3);
        put_separator(f);
        put_y(f, i);
        end_row(f);
    }
    f->named = "swing 2";
}

static void unpadded_decimals(struct file *f)
{
    const int parts = next(f) % 2 ? 1000 : 1000000;
    f->rows = between(f, 250, ROWS_MAX);
    if (parts == 1000 && next(f) % 2) /* less than a second */
        f->rows = (int)(0.9 / f->step) > 8 ? (int)(0.9 / f->step) : 250;
    for (int i = 0; i < f->rows; i++) {
        const long all = (long)nearbyint(parts * f->t[i]);
        buffer_format(&f->text, "%ld%c%ld", all / parts, f->decimal, all % parts);
        put_separator(f);
        put_y(f, i);
        end_row(f);
    }
    f->said = "seem to lack leading zeros";
}

/* A counter of 8 bits that is full now and then, and nothing else. */
static void counts_alone(struct file *f)
{
    f->rows = between(f, 100, ROWS_MAX);
    f->value = 0;
    f->options = "rate=100";
    for (int i = 0; i < f->rows; i++) {
        f->t[i] = i / 100.0;
        f->y[i] = i % 256;
        buffer_format(&f->text, "%d\n", i % 256);
    }
}

/* ---- controls ---- */

/* Single short lines are garbled, not rows of another width. */
static void single_short_lines(struct file *f)
{
    int kept = 0;
    names(f, f->separator == ',' ? ",v (cm/s)" : "");
    for (int i = 0; i < f->rows; i++) {
        const bool cut = i % 10 == 7 && (i == 7 || next(f) % 2);
        put_real(f, f->t[i], 3);
        if (!cut || f->separator == ',')
            put_separator(f);
        if (!cut || f->separator == ',')
            put_y(f, i);
        if (!cut && f->separator == ',') {
            put_separator(f);
            put_real(f, noise(f), 3);
        }
        end_row(f);
        if (!cut) {
            f->t[kept] = f->t[i];
            f->y[kept++] = f->y[i];
        }
    }
    f->rows = kept;
    f->said = "lines dropped that are not";
}

/* A file that was put together from two exports that overlap holds some rows twice. */
static void overlapping_rows(struct file *f)
{
    const int cut = f->rows / 2, again = between(f, 2, cut / 4);
    names(f, "");
    for (int i = 0; i < f->rows + again; i++) {
        const int row = i < cut ? i : i - again;
        put_real(f, f->t[row], 3);
        put_separator(f);
        put_y(f, row);
        end_row(f);
    }
    f->said = again == 1 ? "back in time" : "dropped";
}

/* A number printed without zeros at its end is no unpadded one. */
static void short_decimals(struct file *f)
{
    for (int i = 0; i < f->rows; i++) {
        char number[32];
        snprintf(number, sizeof number, "%.6g", f->t[i]);
        for (char *c = number; *c; c++)
            buffer_char(&f->text, *c == '.' ? f->decimal : *c);
        put_separator(f);
        put_y(f, i);
        end_row(f);
    }
}

static const struct {
    const char *name;
    void (*write)(struct file *f);
} kinds[] = {
    {"formula beside some rows", formula_beside},
    {"TDS with names above", tektronix_with_names},
    {"time in any column", time_anywhere},
    {"labels before", labels_before},
    {"repeated stamps", repeated_stamps},
    {"thousands in one column", thousands_in_one_column},
    {"stamps before lines", stamps_before_lines},
    {"clock set back", clock_set_back},
    {"matrix of Octave", octave_matrix},
    {"decimals not padded", unpadded_decimals},
    {"counts alone", counts_alone},
    {"control: single short lines", single_short_lines},
    {"control: overlapping rows", overlapping_rows},
    {"control: short decimals", short_decimals},
};

/* ---- the judge ---- */

static const char *difference(const struct file *f, const struct recording *r)
{
    static char what[160];
    const double scale = r->column[r->value].factor, stamp = f->said ? 0.0101 : 1e-9;
    if (r->rows != (size_t)f->rows)
        snprintf(what, sizeof what, "%zu rows, not %d", r->rows, f->rows);
    else if (r->value != f->value && f->named == NULL)
        snprintf(what, sizeof what, "the value is column %d", r->value + 1);
    else if (f->named && strcmp(r->column[r->value].name, f->named) != 0)
        snprintf(what, sizeof what, "the value is called %s", r->column[r->value].name);
    else if (f->said && !fixture_warns(r, f->said))
        snprintf(what, sizeof what, "nothing says '%s'", f->said);
    else {
        const bool rounded = f->said && strcmp(f->said, "all rows are kept") == 0;
        for (int i = 0; i < f->rows; i++) {
            if (!near(r->t[i] - r->t[0], f->t[i] - f->t[0], rounded ? stamp : 1e-9))
                snprintf(what, sizeof what, "t[%d] = %.9g, not %.9g", i, r->t[i] - r->t[0],
                         f->t[i]);
            else if (!near(r->y[i], scale * f->y[i], 1e-9))
                snprintf(what, sizeof what, "y[%d] = %.9g, not %.9g", i, r->y[i], scale * f->y[i]);
            else
                continue;
            return what;
        }
        return NULL;
    }
    return what;
}

TEST(what_was_written_is_read)
{
    static struct file f;
    int failures = 0;
    for (size_t kind = 0; kind < COUNT_OF(kinds); kind++)
        for (uint64_t seed = 1; seed <= FILES_OF_A_KIND; seed++) {
            struct error error;
            begin(&f, seed + 1000 * kind);
            kinds[kind].write(&f);
            struct recording *r = fixture_load(f.text.data, f.text.len, f.options, &error);
            const char *wrong = r ? difference(&f, r) : error.text;
            if (wrong && failures++ < 20)
                print_message("%s, seed %d: %s\n%.*s\n", kinds[kind].name, (int)seed, wrong, 200,
                              f.text.data);
            recording_destroy(r);
            buffer_free(&f.text);
        }
    print_message("%zu files\n", COUNT_OF(kinds) * FILES_OF_A_KIND);
    assert_int_equal(failures, 0);
}

RUN_TESTS(fixture_setup, fixture_teardown)
