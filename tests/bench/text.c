/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers in and out, tables in and out, against what the C library does. */
#include "bench/bench.h"

#include <hooke/base/number.h>
#include <hooke/result.h>

#include "modules/recording/table/load.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define NUMBERS 100000
#define LINES 100000

static volatile double sink;

static double out_hooke(void *self)
{
    struct buffer *text = self;
    buffer_clear(text);
    const int64_t begin = clock_ns();
    for (int i = 0; i < NUMBERS; i++) {
        buffer_real(text, i / 3.0);
        buffer_char(text, '\n');
    }
    return (double)(clock_ns() - begin) / NUMBERS;
}

static double out_printf(void *self)
{
    char line[40];
    int length = 0;
    (void)self;
    const int64_t begin = clock_ns();
    for (int i = 0; i < NUMBERS; i++)
        length += snprintf(line, sizeof line, "%.17g\n", i / 3.0);
    sink = length;
    return (double)(clock_ns() - begin) / NUMBERS;
}

static void fill(struct buffer *text)
{
    buffer_clear(text);
    for (int i = 0; i < NUMBERS; i++)
        buffer_format(text, "%.3f\n", 20 + i * 1e-3);
}

static double in_hooke(void *self)
{
    struct text rest = buffer_text(self);
    const int64_t begin = clock_ns();
    while (rest.len > 0) {
        double value;
        size_t used;
        if (real_scan(rest, '.', &value, &used) != REAL_OK)
            return NAN;
        sink = value;
        rest = (struct text){rest.data + used + 1, rest.len - used - 1};
    }
    return (double)(clock_ns() - begin) / NUMBERS;
}

static double in_strtod(void *self)
{
    const struct buffer *text = self;
    char *at = text->data;
    const int64_t begin = clock_ns();
    for (int i = 0; i < NUMBERS; i++) {
        sink = strtod(at, &at);
        at++;
    }
    return (double)(clock_ns() - begin) / NUMBERS;
}

/* ---- tables: t, y, v ---- */

static double columns[3][LINES];

static double csv_hooke(void *self)
{
    const struct table_column column[] = {{.name = "t", .unit = "s", .value = columns[0]},
                                          {.name = "y", .unit = "m", .value = columns[1]},
                                          {.name = "v", .unit = "m/s", .value = columns[2]}};
    const struct table table = {.column = column, .columns = 3, .rows = LINES};
    struct buffer *text = self;
    buffer_clear(text);
    const int64_t begin = clock_ns();
    table_put(&table, table_csv, text);
    return (double)(clock_ns() - begin) / LINES;
}

static double csv_printf(void *self)
{
    FILE *file = fopen("/dev/null", "w");
    (void)self;
    if (!file)
        return NAN;
    const int64_t begin = clock_ns();
    for (int i = 0; i < LINES; i++)
        fprintf(file, "%.17g,%.17g,%.17g\n", columns[0][i], columns[1][i], columns[2][i]);
    const double ns = (double)(clock_ns() - begin) / LINES;
    fclose(file);
    return ns;
}

static double load_hooke(void *self)
{
    struct error error = {0};
    const struct load_options options = {0};
    const int64_t begin = clock_ns();
    struct recording *recording = recording_load(self, &options, &error);
    const double ns = (double)(clock_ns() - begin) / LINES;
    if (!recording)
        bench_die(self, error.text);
    recording_destroy(recording);
    return ns;
}

static double load_strtod(void *self)
{
    FILE *file = fopen(self, "r");
    char line[100];
    if (!file)
        return NAN;
    const int64_t begin = clock_ns();
    while (fgets(line, sizeof line, file)) {
        char *at;
        sink = strtod(line, &at);
        sink = strtod(at, &at);
    }
    const double ns = (double)(clock_ns() - begin) / LINES;
    fclose(file);
    return ns;
}

static void tables(struct buffer *text)
{
    char path[] = "/tmp/hooke-bench-XXXXXX";
    const int descriptor = mkstemp(path);
    FILE *file = descriptor < 0 ? NULL : fdopen(descriptor, "w");
    if (!file)
        bench_die(path, "cannot be written");
    fputs("Time\tDistance\ns\tcm\n", file);
    for (int i = 0; i < LINES; i++)
        fprintf(file, "%.2f\t%.3f\n", i * 0.02, 40 + 5 * cos(0.1 * i));
    fclose(file);
    struct arm arm[] = {ARM(csv_hooke, text), ARM(csv_printf, NULL), ARM(load_hooke, path),
                        ARM(load_strtod, path)};
    contest(arm, 4);
    unlink(path);
    table_begin("Tables", "ns a line");
    table_row("CSV out: t, y, v", &arm[0], "fprintf %.17g", &arm[1], 1);
    table_row("instrument file in, checked", &arm[2], "fgets, strtod", &arm[3], 1);
}

void bench_text(void)
{
    struct buffer out = {0}, in = {0};
    fill(&in);
    for (int i = 0; i < LINES; i++) {
        columns[0][i] = i * 0.01;
        columns[1][i] = 0.05 * cos(0.0866 * i);
        columns[2][i] = -0.433 * sin(0.0866 * i);
    }
    struct arm arm[] = {ARM(out_hooke, &out), ARM(out_printf, NULL), ARM(in_hooke, &in),
                        ARM(in_strtod, &in)};
    contest(arm, 4);
    table_begin("Numbers, round-trip exact", "ns a number");
    table_row("out, 17 digits needed", &arm[0], "snprintf %.17g", &arm[1], 1);
    table_row("in, three decimals", &arm[2], "strtod", &arm[3], 1);
    tables(&out);
    buffer_free(&out);
    buffer_free(&in);
}
