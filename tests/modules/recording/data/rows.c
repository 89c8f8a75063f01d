/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows: the fast way gives the bits of the slow one, and a table beyond the memory that is kept is
 * refused. */
#include "long_form.h"
#include "modules/recording/data/fixture.h"

static uint64_t next(uint64_t *state) /* xorshift64*, Vigna 2016 */
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 2685821657736338717u;
}

/* A number as instruments write it: 1 to 19 digits, a mark anywhere or nowhere, an exponent or
 * none. */
static size_t put_number(char *out, char decimal, uint64_t *state)
{
    size_t len = 0;
    const int digits = 1 + (int)(next(state) % 19), mark = (int)(next(state) % 24);
    if (next(state) % 3 == 0)
        out[len++] = "-+"[next(state) % 8 == 0];
    for (int i = 0; i < digits; i++) {
        if (i == mark)
            out[len++] = decimal;
        out[len++] = (char)('0' + next(state) % (next(state) % 2 ? 10 : 1));
    }
    if (mark == digits)
        out[len++] = decimal;
    if (next(state) % 4 == 0)
        len += (size_t)snprintf(out + len, 16, "%c%s%d", "eE"[next(state) % 2],
                                next(state) % 3 ? "-" : "",
                                (int)(next(state) % (next(state) % 2 ? 10 : 30)));
    return len;
}

TEST(numbers_keep_every_bit)
{
    enum { ROWS = 20000, COLUMNS = 4 };
    static const struct {
        char separator, decimal;
        const char *end;
    } dialects[] = {{'\t', '.', "\r\n"},
                    {';', ',', "\n"},
                    {',', '.', "\n"},
                    {' ', '.', "\n"},
                    {'\t', ',', "\r\r\n"}};
    double *expected = malloc(sizeof(double) * ROWS * COLUMNS);
    assert_non_null(expected);
    for (size_t d = 0; d < COUNT_OF(dialects); d++) {
        struct buffer text = {0};
        struct error error;
        uint64_t random = 88172645463325252u + d;
        char number[80];
        size_t used;
        for (int i = 0; i < ROWS * COLUMNS; i++) {
            const size_t len = put_number(number, dialects[d].decimal, &random);
            assert_int_equal(
                real_scan((struct text){number, len}, dialects[d].decimal, &expected[i], &used),
                REAL_OK);
            assert_int_equal(used, len);
            buffer_put(&text, next(&random) % 50 ? TEXT("") : TEXT(" "));
            buffer_put(&text, (struct text){number, len});
            if ((i + 1) % COLUMNS)
                buffer_char(&text, dialects[d].separator);
            else
                buffer_put(&text, text_of(dialects[d].end));
        }
        char options[80];
        snprintf(options, sizeof options, "rate=1 y=2 decimal=%c sep=%s", dialects[d].decimal,
                 dialects[d].separator == '\t'  ? "tab"
                 : dialects[d].separator == ' ' ? "blank"
                                                : (char[]){dialects[d].separator, '\0'});
        struct recording *r = fixture_load(text.data, text.len, options, &error);
        if (!r)
            fail_msg("%s: %s", options, error.text);
        if (r->columns != COLUMNS || r->rows != ROWS)
            fail_msg("%s: %d columns, %zu rows", options, r->columns, r->rows);
        for (int i = 0; i < ROWS * COLUMNS; i++)
            if (memcmp(&r->column[i % COLUMNS].value[i / COLUMNS], &expected[i], sizeof(double)) !=
                0)
                fail_msg("%s: line %u, row %d, column %d: %.17g, not %.17g", options,
                         r->line[i / COLUMNS], i / COLUMNS, i % COLUMNS,
                         r->column[i % COLUMNS].value[i / COLUMNS], expected[i]);
        recording_destroy(r);
        buffer_free(&text);
    }
    free(expected);
}

/* The first lines are long, the others short: there are more rows than they let expect. */
TEST(more_rows_than_expected)
{
    struct buffer text = {0};
    struct error error;
    for (int i = 0; i < 100000; i++)
        buffer_format(&text,
                      i < 100 ? "%d.00000000000000000000,%d.00000000000000000000\n" : "%d,%d\n", i,
                      i % 7);
    struct recording *r = fixture_load(text.data, text.len, "rate=1", &error);
    assert_non_null(r);
    assert_int_equal(r->rows, 100000);
    for (size_t i = 0; i < r->rows; i++)
        assert_true(r->t[i] == (double)i && r->y[i] == (double)(i % 7) && r->line[i] == i + 1);
    recording_destroy(r);
    buffer_free(&text);
}

/* 28 byte for a row of one column: what fits into 1 GiB is read, one row more is refused with the
 * number. */
TEST(memory_has_a_limit)
{
    const size_t max = ((size_t)1 << 30) / 28;
    struct error error;
    if (!is_long()) {
        print_message("takes 1 GiB: only in make check-all (LONG)\n");
        skip();
    }
    char *text = malloc(2 * (max + 1));
    assert_non_null(text);
    for (size_t i = 0; i <= max; i++)
        memcpy(text + 2 * i, i % 2 ? "1\n" : "2\n", 2);
    struct recording *r = fixture_load(text, 2 * max, "rate=1", &error);
    assert_non_null(r);
    assert_int_equal(r->rows, max);
    recording_destroy(r);
    assert_null(fixture_load(text, 2 * (max + 1), "rate=1", &error));
    assert_int_equal(error.code, ERROR_IO);
    assert_non_null(strstr(error.text, "38347922 rows of 1 columns"));
    assert_non_null(strstr(error.hint, "a part of it"));
    free(text);
}

RUN_TESTS(fixture_setup, fixture_teardown)
