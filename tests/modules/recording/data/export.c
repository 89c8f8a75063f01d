/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables out: what is written, that it reads back bit for bit, and that text cannot become anything
 * else. */
#include "long_form.h"
#include "modules/recording/data/fixture.h"

#include <hooke/base/file.h>
#include <hooke/result.h>

#include <locale.h>

static const double times[] = {0, 0.1, 0.30000000000000004}, indices[] = {0.05, NAN, -1e-300};
static const char *const notes[] = {"plain", "=1+1", "a,b \"c\"\n"};
static const struct table_key keys[] = {{"dt", "10 ms"}, {"note", "two\nlines"}};
static const struct table_column columns[] = {{"t", "s", times, NULL, false},
                                              {"y", "m", indices, NULL, false},
                                              {"say \"hi\"", "", NULL, notes, false}};
static const struct table small = {keys, 2, columns, 3, 3, NULL, 0};

TEST(csv_text)
{
    struct buffer text = {0};
    table_put(&small, table_csv, &text);
    assert_string_equal(
        text.data,
        "# dt = 10 ms\n# note = two\\x0alines\nt [s],y [m],\"say \"\"hi\"\"\"\n0,0.05,plain\n"
        "0.1,,\"'=1+1\"\n0.30000000000000004,-1e-300,\"a,b \"\"c\"\"\n\"\n");
    buffer_free(&text);
}

TEST(tsv_text)
{
    struct table table = small;
    struct buffer text = {0};
    table.keys = 0;
    table.columns = 2;
    table_put(&table, table_tsv, &text);
    assert_string_equal(text.data, "t [s]\ty [m]\n0\t0.05\n0.1\t\n0.30000000000000004\t-1e-300\n");
    buffer_free(&text);
}

TEST(json_text)
{
    struct buffer text = {0};
    table_put(&small, table_json, &text);
    assert_string_equal(
        text.data,
        "{\"keys\":{\"dt\":\"10 ms\",\"note\":\"two\\nlines\"},\"columns\":[\n"
        "{\"name\":\"t\",\"unit\":\"s\",\"values\":[0,0.1,0.30000000000000004]},\n"
        "{\"name\":\"y\",\"unit\":\"m\",\"values\":[0.05,null,-1e-300]},\n"
        "{\"name\":\"say \\\"hi\\\"\",\"unit\":\"\",\"values\":[\"plain\",\"=1+1\",\"a,b "
        "\\\"c\\\"\\n\"]}\n]}\n");
    buffer_clear(&text);
    buffer_json_text(&text, (struct text){"\x01\x1B\xFFé\0", 6});
    assert_string_equal(text.data, "\"\\u0001\\u001b\xEF\xBF\xBD\xC3\xA9\\u0000\"");
    buffer_clear(&text);
    buffer_json_real(&text, HUGE_VAL);
    buffer_json_real(&text, -0.5);
    assert_string_equal(text.data, "null-0.5");
    buffer_free(&text);
}

TEST(formulas_are_disarmed)
{
    static const char *const cells[] = {"=1", "+1", "-1", "@x", "\tx", "1-1"};
    static const char *const wanted[] = {"\"'=1\"", "\"'+1\"",  "\"'-1\"",
                                         "\"'@x\"", "\"'\tx\"", "1-1"};
    const struct table_column column = {"=name", "", NULL, cells, false};
    const struct table table = {NULL, 0, &column, 1, COUNT_OF(cells), NULL, 0};
    struct buffer text = {0};
    table_put(&table, table_csv, &text);
    struct text rest = buffer_text(&text), line;
    assert_true(text_split(&rest, '\n', &line) && text_is(line, "\"'=name\""));
    for (size_t i = 0; i < COUNT_OF(cells); i++)
        assert_true(text_split(&rest, '\n', &line) && text_is(line, wanted[i]));
    buffer_free(&text);
}

static uint64_t random_bits(uint64_t *state) /* Steele, Lea, Flood 2014: splitmix64 */
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static bool same_bits(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

/* Written, loaded again: every double the same, the unit and the comments understood. */
TEST(exported_tables_read_back)
{
    const size_t rows = is_long() ? 5000000 : 100000;
    double *t = calloc(rows, sizeof *t), *y = calloc(rows, sizeof *y), *z = calloc(rows, sizeof *z);
    assert_true(t && y && z);
    uint64_t seed = 20180920;
    for (size_t i = 0; i < rows; i++) {
        uint64_t bits = random_bits(&seed);
        t[i] = -1.7 + 0.1 * (double)i;
        memcpy(&y[i], &bits, sizeof bits);
        z[i] = (double)(random_bits(&seed) >> 11) * 0x1p-53;
    }
    y[0] = -0.0;
    y[1] = 5e-324;
    y[2] = 1.7976931348623157e308;
    const struct table_column column[] = {
        {"t", "s", t, NULL, false}, {"y", "m", y, NULL, false}, {"z", "m/s", z, NULL, false}};
    const struct table table = {keys, 2, column, 3, rows, NULL, 0};
    for (int tabs = 0; tabs < 2; tabs++) {
        table_format *format = tabs ? table_tsv : table_csv;
        struct error error = {0};
        const char *path = fixture_path(tabs ? "out.tsv" : "out.csv");
        if (!table_write(&table, format, path, (struct write_policy){0}, &error))
            fail_msg("%s", error.text);
        struct recording *r = recording_load(path, NULL, &error);
        if (!r)
            fail_msg("%s", error.text);
        assert_int_equal(r->rows, rows);
        assert_int_equal(r->columns, 3);
        assert_int_equal(r->time, 0);
        assert_int_equal(r->value, 1);
        assert_int_equal(r->header_lines, 3);
        assert_string_equal(r->column[2].unit, "m/s");
        for (size_t i = 0; i < rows; i++)
            if (!same_bits(r->t[i], t[i]) || !same_bits(r->column[1].value[i], y[i]) ||
                !same_bits(r->column[2].value[i], z[i]))
                fail_msg("row %zu: %a %a %a read as %a %a %a", i, t[i], y[i], z[i], r->t[i],
                         r->column[1].value[i], r->column[2].value[i]);
        assert_true(same_bits(r->y[0], -0.0) && same_bits(r->y[2], y[2]));
        recording_destroy(r);
        /* never over a file unasked */
        assert_false(table_write(&table, format, path, (struct write_policy){0}, &error));
    }
    free(t);
    free(y);
    free(z);
}

TEST(failures_are_reported)
{
    struct error error = {0};
    assert_false(table_write(&small, table_csv, fixture_path("no such folder/x.csv"),
                             (struct write_policy){0}, &error));
    assert_int_equal(error.code, ERROR_IO);
}

TEST(no_locale_matters)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    bool set = false;
    for (size_t i = 0; i < COUNT_OF(names) && !set; i++)
        set = setlocale(LC_ALL, names[i]) != NULL;
    if (!set) {
        print_message("no locale with a decimal comma is installed\n");
        skip();
    }
    csv_text(state);
    struct recording *r = fixture_good("t,y\n0.5,1.5\n1.5,2.5\n", "");
    assert_true(r->t[0] == 0.5 && r->y[1] == 2.5);
    recording_destroy(r);
    setlocale(LC_ALL, "C");
}

RUN_TESTS(fixture_setup, fixture_teardown)
