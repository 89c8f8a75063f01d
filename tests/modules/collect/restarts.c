/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Boards that restart while their lines are collected: their clocks jump back to 0 or to another
 * value. The judge is the clock that never stopped, by which the lines were made.
 */
#include "long_form.h"
#include "modules/collect/lines.h"
#include "modules/recording/data/fixture.h"
#include "unit/random_testing.h"

enum heading { HEADING_NONE, HEADING_FIRST, HEADING_AT_EACH_START, HEADINGS };
/* Lines that come as they are made, much faster (from a file), or all at once. */
enum arriving { ARRIVING_LIVE, ARRIVING_FAST, ARRIVING_AT_ONCE, ARRIVINGS };
enum { LINES_MIN = 8, LINES_MAX = 400, STARTS_MAX = 7 };

struct board {
    int lines, starts, start[STARTS_MAX]; /* rows in front of which it starts again */
    double from[STARTS_MAX + 1];          /* [steps] its clock at each start */
    double step;                          /* [s] */
    double per_second;                    /* counts of its clock */
    int decimals, values;                 /* of the stamps; columns beside them */
    char separator;
    bool counts_rows; /* a column in front counts from each start */
    enum heading heading;
    enum arriving arriving;
};

static int random_index(int n)
{
    return (int)(random_uniform() * n);
}

static struct board random_board(void)
{
    static const struct {
        double per_second;
        int decimals;
    } clocks[] = {{1, 3}, {1, 6}, {1000, 0}, {1000, 1}, {1e6, 0}};
    static const char separators[] = "\t,; ";
    const int clock = random_index((int)COUNT_OF(clocks));
    struct board b = {
        .lines = LINES_MIN + random_index(LINES_MAX - LINES_MIN),
        .starts = 1,
        .step = (1 + random_index(50)) * 2e-3,
        .per_second = clocks[clock].per_second,
        .decimals = clocks[clock].decimals,
        .values = 1 + random_index(3),
        .separator = separators[random_index((int)sizeof separators - 1)],
        .counts_rows = random_index(4) == 0,
        .heading = (enum heading)random_index(HEADINGS),
        .arriving = (enum arriving)random_index(ARRIVINGS),
    };
    if (b.lines > 100)
        b.starts += random_index(STARTS_MAX);
    /* A row alone and its repetition are the same; two rows between two headings may be anything.
     */
    const int each = (b.lines - 3) / b.starts;
    for (int i = 0; i < b.starts; i++)
        b.start[i] = 3 + i * each + random_index(i + 1 < b.starts ? each - 3 : each);
    for (int i = 0, rows = 0; i <= b.starts; i++) {
        /* Each start after the first lies behind the last stamp before it. */
        b.from[i] = i == 0 ? random_index(2) * random_index(50000) : 0;
        if (i > 0 && random_index(2) > 0)
            b.from[i] = random_index((int)b.from[i - 1] + rows);
        rows = (i < b.starts ? b.start[i] : b.lines) - (i > 0 ? b.start[i - 1] : 0) - 1;
    }
    return b;
}

/* Returns true where a start cannot be told from something else by anybody: where a counter is full
 * at about that count, or in the last line, where it may be a garbled stamp. */
static bool is_ambiguous(const struct board *b)
{
    static const double full[] = {256, 65536, 4294967296, 4294967.296, 4294.967296};
    const int last = b->start[b->starts - 1];
    const double step = b->step * b->per_second;
    for (int i = 0; i < b->starts; i++) {
        const int rows = b->start[i] - (i > 0 ? b->start[i - 1] : 0);
        for (size_t k = 0; k < COUNT_OF(full); k++)
            if (fabs((b->from[i] + rows) * step - full[k]) < 20 * step)
                return true;
    }
    return last == b->lines - 1 && b->from[b->starts] > 0;
}

static void put_heading(const struct board *b, double arrival, struct buffer *file)
{
    struct buffer line = {0};
    if (b->counts_rows)
        buffer_format(&line, "n%c", b->separator);
    buffer_format(&line, "%s",
                  b->per_second < 2      ? "Time(s)"
                  : b->per_second < 2000 ? "Time(ms)"
                                         : "Time(us)");
    for (int i = 0; i < b->values; i++)
        buffer_format(&line, "%cy%d", b->separator, i + 1);
    collected_put(file, arrival, buffer_text(&line));
    buffer_free(&line);
}

static void put_board(const struct board *b, struct buffer *file)
{
    static const double pace[] = {1, 1. / 37, 0};
    int begun = 0, start = 0;
    buffer_format(file, "%s\n", COLLECTED_HEAD);
    for (int k = 0; k < b->lines; k++) {
        const double t = k * b->step, arrival = 0.1 + t * pace[b->arriving];
        struct buffer line = {0};
        const bool starts = start < b->starts && k == b->start[start];
        if (starts) {
            begun = k;
            start++;
        }
        if ((k == 0 && b->heading != HEADING_NONE) ||
            (starts && b->heading == HEADING_AT_EACH_START))
            put_heading(b, arrival, file);
        if (b->counts_rows)
            buffer_format(&line, "%d%c", k - begun, b->separator);
        buffer_format(&line, "%.*f", b->decimals,
                      (b->from[start] + k - begun) * b->step * b->per_second);
        for (int i = 0; i < b->values; i++)
            buffer_format(&line, "%c%.4f", b->separator, 20 + 5 * cos(9 * t + i) + 0.01 * i);
        collected_put(file, arrival, buffer_text(&line));
        buffer_free(&line);
    }
}

static void describe_board(const struct board *b, char *out, size_t size)
{
    int len = snprintf(
        out, size, "%d lines of %g s, clock of %g, heading %d, arriving %d%s, %d values, starts",
        b->lines, b->step, b->per_second, (int)b->heading, (int)b->arriving,
        b->counts_rows ? ", counted" : "", b->values);
    for (int i = 0; i < b->starts; i++)
        len += snprintf(out + len, size - (size_t)len, " %d (from %g after %g)", b->start[i],
                        b->from[i + 1], b->from[i]);
}

/* Returns the number of rows that are missing, or whose time is wrong by more than half a step. */
static int rows_wrong(const struct board *b, char *why, size_t size)
{
    static const struct load_options none;
    struct buffer file = {0};
    struct error error = {0};
    put_board(b, &file);
    struct recording *r = collected_read(buffer_text(&file), &none, &error);
    int wrong = 0;
    if (!r) {
        snprintf(why, size, "%s", error.text);
        buffer_free(&file);
        return b->lines;
    }
    /* What the clock counts is known from the heading, or from lines that arrive as they are made.
     */
    const double factor = r->column[r->time].factor * b->per_second;
    const double unit = b->heading != HEADING_NONE || b->arriving == ARRIVING_LIVE ? 1 : factor;
    for (size_t i = 0; i < r->rows; i++)
        wrong += fabs((r->t[i] - r->t[0]) / unit - (double)i * b->step) > 0.5 * b->step ||
                 !isfinite(r->y[i]);
    wrong += b->lines - (int)r->rows;
    snprintf(why, size, "%zu of %d rows, %d wrong, factor %g", r->rows, b->lines, wrong, factor);
    recording_destroy(r);
    buffer_free(&file);
    return wrong;
}

TEST(every_row_of_a_board_that_restarts_is_kept)
{
    const int cases = is_long() ? 20000 : 600;
    int failures = 0, tried = 0;
    for (int i = 0; i < cases; i++) {
        char board[600], why[700];
        const struct board b = random_board();
        if (is_ambiguous(&b))
            continue;
        tried++;
        if (rows_wrong(&b, why, sizeof why) == 0)
            continue;
        describe_board(&b, board, sizeof board);
        if (failures++ < 10)
            print_error("case %d: %s: %s\n", i, board, why);
    }
    if (failures > 0)
        fail_msg("%d of %d boards", failures, tried);
}

/* A sawtooth beside another signal is no clock: its lines have the times of their arrivals. */
TEST(a_sawtooth_is_no_clock)
{
    static const struct load_options none;
    struct buffer file = {0};
    struct error error = {0};
    buffer_format(&file, "%s\n", COLLECTED_HEAD);
    for (int k = 0; k < 400; k++) {
        char line[60];
        snprintf(line, sizeof line, "%.2f,%.4f", 0.1 * ((k + 5) % 40), cos(0.18 * k));
        collected_put(&file, 0.02 * k, text_of(line));
    }
    struct recording *r = collected_read(buffer_text(&file), &none, &error);
    if (!r)
        fail_msg("%s", error.text);
    assert_int_equal(r->rows, 400);
    assert_int_equal(r->collected->clock, CLOCK_ARRIVAL);
    assert_true(fabs(r->t[399] - r->t[0] - 0.02 * 399) < 1e-6);
    recording_destroy(r);
    buffer_free(&file);
}

RUN_TESTS(fixture_setup, fixture_teardown)
