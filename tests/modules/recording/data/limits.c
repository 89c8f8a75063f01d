/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sizes that are unreasonable, and bytes that are nonsense: an answer, in time, and no crash. */
#include "long_form.h"
#include "modules/recording/data/fixture.h"
#include "unit/cpu_time.h"

#include <sys/resource.h>

static double seconds_since(int64_t start)
{
    return 1e-9 * (double)(cpu_ns() - start);
}

/* A sanitizer takes a few times as long. */
#if defined(__SANITIZE_ADDRESS__)
#define SLOWER 10
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SLOWER 10
#endif
#endif
#ifndef SLOWER
#define SLOWER 1
#endif

static void columns(struct buffer *text, int count)
{
    for (int row = 0; row < 3; row++)
        for (int i = 0; i < count; i++)
            buffer_format(text, "%d%c", row + i % 10, i + 1 < count ? ',' : '\n');
}

TEST(the_column_limit_is_exact)
{
    struct buffer text = {0};
    struct error error;
    columns(&text, LIMIT_COLUMNS);
    struct recording *r = fixture_load(text.data, text.len, "rate=1", &error);
    assert_non_null(r);
    assert_int_equal(r->columns, LIMIT_COLUMNS);
    recording_destroy(r);
    buffer_clear(&text);
    columns(&text, LIMIT_COLUMNS + 1);
    assert_null(fixture_load(text.data, text.len, "rate=1", &error));
    assert_int_equal(error.code, ERROR_IO);
    assert_non_null(strstr(error.text, "more than 1024 columns"));
    buffer_free(&text);
}

TEST(a_million_columns)
{
    struct buffer text = {0};
    struct error error;
    columns(&text, 1000000);
    const char *path = fixture_file("wide.csv", text.data, text.len);
    int64_t start = cpu_ns();
    error = (struct error){0};
    assert_null(recording_load(path, NULL, &error));
    assert_true(seconds_since(start) < 10.0 * SLOWER);
    assert_non_null(strstr(error.text, "more than 1024 columns"));
    buffer_free(&text);
}

/* 100 MB without a line end, of each byte that could lead a scanner astray. */
TEST(a_very_long_line)
{
    const size_t size = 100000000;
    const char bytes[] = "1 ,\"\r\n#-";
    char *text = malloc(size);
    assert_non_null(text);
    for (size_t i = 0; bytes[i]; i++) {
        memset(text, bytes[i], size);
        fixture_file("long.txt", text, size);
        int64_t start = cpu_ns();
        struct error error = {0};
        assert_null(recording_load(fixture_path("long.txt"), NULL, &error));
        assert_int_equal(error.code, ERROR_IO);
        if (seconds_since(start) > 10.0 * SLOWER)
            fail_msg("0x%02x took %.2f s", (unsigned)bytes[i], seconds_since(start));
    }
    free(text);
    struct rusage usage;
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    if (SLOWER == 1) /* [KiB] with the 100 MB of this test itself */
        assert_true(usage.ru_maxrss < (256 + 100) * 1024L);
}

/* A table, then a line that is no row: dropped, not fatal, not slow. */
TEST(a_long_line_inside)
{
    struct buffer text = {0};
    struct error error;
    buffer_put(&text, TEXT("t,y\n0,1\n1,2\n2,4\n"));
    for (int i = 0; i < 2000000; i++)
        buffer_put(&text, TEXT("1,"));
    buffer_put(&text, TEXT("\n3,5\n"));
    struct recording *r = fixture_load(text.data, text.len, "", &error);
    assert_non_null(r);
    assert_int_equal(r->rows, 4);
    assert_int_equal(r->dropped, 1);
    recording_destroy(r);
    buffer_free(&text);
}

TEST(a_million_rows)
{
    struct buffer text = {0};
    struct error error = {0};
    buffer_put(&text, TEXT("Time (s)\tDistance (cm)\tDist Error (cm)\r\n"));
    for (int i = 0; i < 1000000; i++)
        buffer_format(&text, "%d.%02d\t2%d.%03d\t0.239\r\n", i / 100, i % 100, i % 7, i % 997);
    fixture_file("long.txt", text.data, text.len);
    int64_t start = cpu_ns();
    struct recording *r = recording_load(fixture_path("long.txt"), NULL, &error);
    assert_non_null(r);
    assert_true(seconds_since(start) < 10.0 * SLOWER);
    assert_int_equal(r->rows, 1000000);
    assert_int_equal(r->warnings, 0);
    assert_true(r->t[999999] == 9999.99);
    recording_destroy(r);
    buffer_free(&text);
}

static uint32_t next(uint32_t *seed) /* Marsaglia 2003: xorshift */
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    return *seed ^= *seed << 5;
}

static const char *const seeds[] = {
    "Motion Sensor Data File Sep 20, 2018 1:40 PM\r\nTime (s)\tDistance (cm)\tDist Error "
    "(cm)\r\n0.430\t16.500\t0.239\r\n0.440\t16.509"
    "\t0.239\r\n0.450\t16.565\t0.239",
    ("\xEF\xBB\xBF\"Time (s) Run #1\";\"Position (m) Run "
     "#1\"\r\n0,00;0,17\r\n0,01;0,18\r\n;\r\n0,02;0,19\r\n"),
    "# dt = 10 ms\nt [s],y [m]\n0,0.5\n1,-1e-300\n2,nan\n3,inf\n",
    "Sample\tDistance(cm)\n0\t20.5\t\n1\t20.6\t\n2\t20.7\t\n",
    "t (s)  x (cm)\n 0.0 1.5\n 0.1\t2.5\n# remark\n 0.2 3.5\n",
};

/* Everything that was loaded keeps its promises, whatever the bytes. */
static void check(const struct recording *r)
{
    assert_true(r->rows >= 2 && r->columns >= 1 && r->value >= 0 && r->value < r->columns &&
                r->time < r->columns);
    for (size_t i = 0; i < r->rows; i++) {
        assert_true(isfinite(r->t[i]) && (i == 0 || r->t[i] > r->t[i - 1]));
        assert_true(!isinf(r->y[i]));
        /* Some loggers write the newest row first. */
        assert_true(r->line[i] > 0 && (i == 0 || (r->line[i] > r->line[i - 1]) ==
                                                     (r->line[r->rows - 1] > r->line[0])));
    }
    struct buffer text = {0};
    recording_describe(r, &text);
    for (size_t i = 0; i < text.len; i++)
        assert_true((unsigned char)text.data[i] >= 0x20 || text.data[i] == '\n');
    buffer_free(&text);
}

TEST(random_bytes_are_answered)
{
    static const char letters[] = "0123456789.,;-+eE \t\t\n\n\r\"#()[]/_tynaifmsc\xB2\xC3\x1B";
    static const char *const options[] = {
        "", "rate=100", "sep=, decimal=.", "decimal=,", "t=1 y=2", "unit=mm tunit=ms", "y=x"};
    const int rounds = is_long() ? 1000000 : 3000 / SLOWER;
    uint32_t seed = 20180920;
    int loaded = 0;
    for (int round = 0; round < rounds; round++) {
        char text[400];
        const char *from = seeds[next(&seed) % COUNT_OF(seeds)];
        size_t len = strlen(from);
        memcpy(text, from, len);
        for (uint32_t edits = next(&seed) % 12; edits > 0; edits--) {
            size_t at = next(&seed) % len;
            const char byte = next(&seed) % 8 ? letters[next(&seed) % (sizeof letters - 1)]
                                              : (char)(next(&seed) & 0xFF);
            switch (next(&seed) % 4) {
            case 0:
                text[at] = byte;
                break;
            case 1:
                memmove(text + at, text + at + 1, len - at - 1);
                len -= len > 1;
                break;
            case 2:
                if (len < sizeof text) {
                    memmove(text + at + 1, text + at, len - at);
                    text[at] = byte;
                    len++;
                }
                break;
            default:
                len = next(&seed) % 16 ? len : at + 1;
            }
        }
        struct error error;
        struct recording *r =
            fixture_load(text, len, options[next(&seed) % COUNT_OF(options)], &error);
        if (r) {
            check(r);
            loaded++;
        } else {
            assert_true(error.code != ERROR_NONE && error.text[0]);
        }
        recording_destroy(r);
    }
    assert_true(loaded > rounds / 10 && loaded < rounds); /* both ways were taken */
}

RUN_TESTS(fixture_setup, fixture_teardown)
