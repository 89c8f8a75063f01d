/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Text files of Octave: vectors one below the other are columns, whatever else is among them. */
#include "modules/recording/data/fixture.h"

#include "long_form.h"
#include "unit/random_testing.h"

static const char *const head = "# Created by Octave 8.4.0, Sat Nov 28 11:00:00 2026 UTC <u@h>\n";

static void put_vector(struct buffer *out, const char *name, const double *value, size_t n,
                       bool is_row)
{
    buffer_format(out, "# name: %s\n# type: matrix\n# rows: %zu\n# columns: %zu\n", name,
                  is_row ? 1 : n, is_row ? n : 1);
    for (size_t i = 0; i < n; i++)
        buffer_format(out, " %.17g%s", value[i], is_row ? "" : "\n");
    buffer_put(out, TEXT("\n\n\n"));
}

static void put_other(struct buffer *out, int kind)
{
    static const char *const others[] = {
        "", "# name: g\n# type: scalar\n9.81\n\n\n",
        "# name: s\n# type: string\n# elements: 1\n# length: 5\nhello\n\n\n",
        "# name: p\n# type: matrix\n# rows: 1\n# columns: 2\n 3 4\n\n\n",
        "# name: z\n# type: complex scalar\n(1,2)\n\n\n"};
    buffer_put(out, text_of(others[kind % (int)COUNT_OF(others)]));
}

TEST(vectors_are_columns)
{
    static double t[400], y[400], w[400];
    const int runs = is_long() ? 2000 : 200;
    random_state = 51;
    for (int run = 0; run < runs; run++) {
        const size_t n = 20 + (size_t)(380 * random_uniform());
        const double step = 0.001 + 0.1 * random_uniform();
        struct buffer out = {0};
        for (size_t i = 0; i < n; i++) {
            t[i] = step * (double)i;
            y[i] = cos(0.2 * (double)i) + 0.01 * random_normal();
            w[i] = random_normal();
        }
        buffer_put(&out, text_of(head));
        put_other(&out, run);
        if (run % 7 == 0)
            buffer_format(&out,
                          "# name: t\n# type: %s\n# base, limit, increment\n0 %.17g %.17g\n\n\n",
                          run % 2 ? "range" : "double_range", t[n - 1], step);
        else
            put_vector(&out, "t", t, n, run % 2);
        put_other(&out, run / 5);
        put_vector(&out, "y", y, n, run % 3 == 0);
        if (run % 4 == 0)
            put_vector(&out, "w", w, n, run % 8 == 0);
        put_other(&out, run / 25);
        struct recording *r = fixture_good(out.data, "");
        if (r->rows != n || r->columns != (run % 4 == 0 ? 3 : 2))
            fail_msg("run %d: %zu of %zu rows, %d columns", run, r->rows, n, r->columns);
        for (size_t i = 0; i < n; i++)
            assert_true(fabs(r->t[i] - t[i]) < 1e-12 * (double)n && r->y[i] == y[i]);
        recording_destroy(r);
        buffer_free(&out);
    }
}

TEST(vectors_of_other_lengths_are_named)
{
    static const double t[] = {0, 1, 2, 3, 4, 5, 6, 7, 8}, y[] = {1, 2, 3, 2, 1, 2, 3, 2};
    struct buffer out = {0};
    struct error error;
    buffer_put(&out, text_of(head));
    put_vector(&out, "t", t, COUNT_OF(t), false);
    put_vector(&out, "y", y, COUNT_OF(y), true);
    struct recording *r = fixture_load(out.data, out.len, "", &error);
    assert_null(r);
    assert_non_null(strstr(error.text, "t (9 values) and y (8 values)"));
    assert_non_null(strstr(error.hint, "save -text FILE M"));
    buffer_free(&out);
}

/* More values than the text holds are no promise to make room for them. */
TEST(claims_are_not_believed)
{
    struct error error;
    static const char text[] =
        "# Created by Octave\n# name: t\n# type: matrix\n# rows: 100000000\n# columns: 1\n 1\n "
        "2\n\n"
        "# name: y\n# type: matrix\n# rows: 100000000\n# columns: 1\n 1\n 2\n";
    struct recording *r = fixture_load(text, sizeof text - 1, "", &error);
    assert_null(r);
}

RUN_TESTS(fixture_setup, fixture_teardown)
