/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Times that are odd, rows that are cut, the part of a recording in use, and what is said about it.
 */
#include "modules/recording/data/fixture.h"
#include "unit/random_testing.h"

TEST(times_are_counted_not_differenced)
{
    struct buffer text = {0};
    buffer_put(&text, TEXT("Time (s)\tDistance (cm)\tDist Error (cm)\n"));
    for (int i = 0; i < 601; i++)
        buffer_format(&text, "%.3f\t%.3f\t0.239\n", i / 60.0, 20 + sin(i * 0.1));
    struct recording *r = fixture_good(text.data, "");
    assert_int_equal(r->rows, 601);
    assert_true(near(r->dt, 1 / 60.0, 1e-7)); /* the first difference is 0.017 */
    assert_true(near(r->rate, 60, 4e-4));
    assert_int_equal(r->warnings, 0);
    assert_int_equal(r->line[0], 2);
    assert_int_equal(r->line[600], 602);
    recording_destroy(r);
    buffer_free(&text);
}

/* At rest in whole numbers for longer than is looked at to choose the decimal mark. */
TEST(a_late_decimal_comma_is_seen)
{
    struct buffer text = {0};
    buffer_put(&text, TEXT("t [ms];y [mm]\n"));
    for (int i = 0; i < 1000; i++)
        buffer_format(&text, "%d;20%s\n", 10 * i, i < 900 ? "" : ",25");
    struct recording *r = fixture_good(text.data, "");
    assert_int_equal(r->decimal, ',');
    assert_int_equal(r->rows, 1000);
    assert_int_equal(r->warnings, 0);
    assert_true(r->column[1].value[999] == 20.25);
    recording_destroy(r);
    buffer_free(&text);
}

/* Programs leave out a time of day that is 0, and say only the date, in the first row, too. */
TEST(a_date_alone_beside_times_is_midnight)
{
    for (int first = 0; first <= 20; first += 10) {
        struct buffer text = {0};
        buffer_put(&text, TEXT("time;y [m]\n"));
        for (int i = 0; i < 100; i++) {
            const int s = i - first;
            buffer_format(&text, "2024-05-0%d", s < 0 ? 1 : 2);
            if (s != 0)
                buffer_format(&text, " %s:%02d",
                              s < 0    ? "23:59"
                              : s < 60 ? "00:00"
                                       : "00:01",
                              (s + 60) % 60);
            buffer_format(&text, ";%d\n", i * i % 7);
        }
        struct recording *r = fixture_good(text.data, "unit=m");
        assert_int_equal(r->rows, 100);
        assert_int_equal(r->dropped, 0);
        for (int i = 0; i < 100; i++)
            assert_true(r->t[i] == i);
        recording_destroy(r);
        buffer_free(&text);
    }
}

/* One line for each row; `t` in ms. */
static struct recording *with_times(const int *t, size_t n)
{
    struct buffer text = {0};
    buffer_put(&text, TEXT("t [ms],y [m]\n"));
    for (size_t i = 0; i < n; i++)
        buffer_format(&text, "%d,%d.5\n", t[i], (int)(i * i) % 7);
    struct recording *r = fixture_good(text.data, "");
    buffer_free(&text);
    return r;
}

static void assert_rising(const struct recording *r)
{
    for (size_t i = 1; i < r->rows; i++)
        assert_true(r->t[i] > r->t[i - 1]);
    for (size_t i = 0; i < r->rows; i++)
        assert_true(r->t[i] == r->column[0].value[i] / 1000);
}

TEST(a_clock_set_back_loses_the_overlap)
{
    const int t[] = {0, 10, 20, 30, 40, 25, 35, 45, 55, 65, 75, 85, 95};
    struct recording *r = with_times(t, COUNT_OF(t));
    assert_rising(r);
    assert_int_equal(r->rows, 11);
    assert_int_equal(r->dropped, 2);
    assert_int_equal(r->line[5], 9); /* 45, behind the two that are dropped */
    assert_true(fixture_warns(r, "2 rows go back in time: dropped (first: line 7)"));
    recording_destroy(r);
}

TEST(a_wild_time_loses_only_itself)
{
    const int t[] = {0, 10, 20, 9999, 40, 50, 60, 70, 80, 90, 100, 110};
    struct recording *r = with_times(t, COUNT_OF(t));
    assert_rising(r);
    assert_int_equal(r->rows, 11);
    assert_true(fixture_warns(r, "1 row goes back in time: dropped (first: line 5)"));
    recording_destroy(r);
}

TEST(repeated_times_keep_the_first)
{
    const int t[] = {0,   10,  10,  20,  20,  20,  30,  40,  50,  60,  70,  80,  90,  100, 110,
                     120, 130, 140, 150, 160, 170, 180, 190, 200, 210, 220, 230, 240, 250, 260,
                     270, 280, 290, 300, 310, 320, 330, 340, 350, 360, 370, 380, 390, 400};
    struct recording *r = with_times(t, COUNT_OF(t));
    assert_rising(r);
    assert_int_equal(r->dropped, 3);
    assert_int_equal(r->line[1], 3);
    assert_int_equal(r->line[2], 5);
    assert_true(fixture_warns(r, "3 rows repeat the previous time: dropped (first: line 4)"));
    assert_false(fixture_warns(r, "uneven"));
    recording_destroy(r);
}

TEST(gaps_and_jitter_are_kept_and_said)
{
    const int t[] = {0, 10, 20, 50, 60, 70, 82, 90, 100, 110, 150};
    struct recording *r = with_times(t, COUNT_OF(t));
    assert_int_equal(r->rows, COUNT_OF(t));
    assert_true(near(r->dt, 0.015, 1e-15));
    assert_true(fixture_warns(
        r,
        "2 gaps between samples; the longest is 0.04 s instead of 0.01 s (first: after line 4)"));
    assert_true(fixture_warns(r, "2 of 10 steps differ"));
    recording_destroy(r);
}

TEST(rows_without_a_time_are_dropped)
{
    struct recording *r = fixture_good(
        "t,y\n0,1\n,2\n2,3\nNaN,4\n4,5\n5,5\n6,5\n7,5\n8,5\n9,5\n10,5\n11,5\n12,5\n", "");
    assert_int_equal(r->rows, 11);
    assert_int_equal(r->dropped, 2);
    assert_true(r->y[1] == 3);
    assert_true(fixture_warns(r, "2 rows have no time: dropped (first: line 3)"));
    recording_destroy(r);
}

/* Without a time column a dropped row still takes its time. */
TEST(a_dropped_row_takes_its_time)
{
    struct recording *r = fixture_good("a;pos\n1;1\n2;2\n3;3\n4\n5;5\n6;6\n", "rate=10 unit=m");
    assert_int_equal(r->rows, 5);
    assert_true(near(r->t[3], 0.4, 1e-15));
    assert_true(r->rate == 10);
    recording_destroy(r);
}

TEST(a_cut_last_row_is_dropped)
{
    static const struct {
        const char *text;
        size_t rows;
        const char *warning;
    } cases[] = {
        /* Whole, though nothing ends the line. */
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.2\t1.75", 3, NULL},
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.2\tNaN", 3, NULL},
        {"t\ty\n0\t-120\n1\t-100\n2\t44", 3, NULL},
        {"t\ty\n0\t-120\n1\t-120\n2\t-1\r", 3, NULL},
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.2\t1.7\n", 3, NULL},
        {"t;y;\n0.0;1.25;\n0.1;1.50;\n0.2;1.75;", 3, NULL},
        /* Cut. */
        {"t;y;\n0.0;1.25;\n0.1;1.50;\n0.2;1.7", 2, "the last line (4)"},
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.2\t1.7", 2,
         "the last line (4) seems to end inside a number ('1.7')"},
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.2\t1", 2, "the last line (4)"},
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.2\t-", 2, "the last line (4)"},
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.2\t", 2, "the last line (4)"},
        {"t\ty\n0.0\t1.25\n0.1\t1.50\n0.", 2, "the last line (4) is incomplete and was dropped"},
        {"t\ty\n0.0\t1.25E2\n0.1\t1.50E2\n0.2\t1.75E", 2, "the last line (4)"},
        {"t\ty\n0\t-148\n1\t-120\n2\t-1", 2, "('-1')"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct recording *r = fixture_good(cases[i].text, "");
        if (r->rows != cases[i].rows || r->dropped != 3 - cases[i].rows)
            fail_msg("%zu rows of\n%s", r->rows, cases[i].text);
        if (cases[i].warning)
            assert_true(fixture_warns(r, cases[i].warning));
        recording_destroy(r);
    }
}

/* A count of the rows is no time; the evenly rising numbers behind it are, what wanders upwards is
 * not. */
TEST(the_time_behind_a_count)
{
    struct error error = {0};
    struct recording *r = fixture_good("1,0.02,40.1\n2,0.04,40.3\n3,0.06,40.2\n4,0.08,40.0\n", "");
    assert_int_equal(r->time, 1);
    assert_int_equal(r->value, 2);
    assert_true(r->t[3] == 0.08 && fixture_warns(r, "column 2 increases and is taken as the time"));
    recording_destroy(r);
    static const char wanders[] =
        "1,0.02,40.1\n2,0.021,40.3\n3,0.3,40.2\n4,0.31,40.0\n5,0.9,40.0\n";
    assert_null(fixture_load(wanders, strlen(wanders), "", &error));
    assert_non_null(strstr(error.text, "the file has sample numbers"));
}

/* Three digits behind the mark everywhere are decimals, unless the numbers go on so from 999. */
TEST(marks_between_thousands)
{
    struct recording *r = fixture_good("t;y\n0.999;1.234\n1.000;1.236\n1.001;1.235\n", "");
    assert_true(r->t[1] == 1 && r->y[0] == 1.234);
    recording_destroy(r);
    r = fixture_good("t;y\n999;1.234\n1.000;1.236\n1.001;1.235\n", "");
    assert_true(r->t[1] == 1000 && r->y[0] == 1234 &&
                fixture_warns(r, "'.' is read as a separator of thousands"));
    recording_destroy(r);
    r = fixture_good("t;y\n1;999\n2;999.125\n3;998.5\n", "");
    assert_true(r->y[0] == 999 && r->y[1] == 999.125);
    recording_destroy(r);
    r = fixture_good("t;y\n1;998\n2;999.125\n3;998\n", "");
    assert_true(r->y[0] == 998 && r->y[1] == 999.125);
    recording_destroy(r);
    r = fixture_good("t;y\n999;1.234\n1000;1.236\n1001;1.235\n", "decimal=.");
    assert_true(r->y[0] == 1.234);
    recording_destroy(r);
}

TEST(windows_and_series)
{
    struct error error = {0};
    struct series series;
    struct arena arena = {0};
    struct recording *r = fixture_good("t,y [cm]\n5,1\n6,2\n7,\n8,4\n9,5\n10,6\n", "");
    assert_true(r->window[0] == 5 && r->window[1] == 10 && r->zero == 0);
    assert_true(recording_series(r, &arena, 5, &series, &error));
    assert_int_equal(series.n, 5);
    assert_int_equal(series.quantity, QUANTITY_LENGTH);
    assert_true(series.t[2] == 8 && series.y[2] == 0.04);

    assert_true(recording_window(r, 6, 9, &error));
    r->zero = 0.01;
    assert_true(recording_series(r, &arena, 3, &series, &error));
    assert_int_equal(series.n, 3);
    assert_true(series.t[0] == 6 && series.t[2] == 9 && near(series.y[2], 0.04, 1e-15));
    assert_false(recording_series(r, &arena, 4, &series, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    assert_non_null(strstr(error.text, "3 samples"));

    assert_true(recording_window(r, NAN, 7.5, &error)); /* open at one end, and beyond the file */
    assert_true(r->window[0] == 5 && r->window[1] == 7.5);
    assert_true(recording_window(r, -3, 1e9, &error));
    assert_true(r->window[0] == 5 && r->window[1] == 10);
    assert_false(recording_window(r, 6.2, 6.8, &error));
    assert_false(recording_window(r, 9, 6, &error));
    assert_false(recording_window(r, 20, 30, &error));
    assert_non_null(strstr(error.text, "5 to 10 s"));
    assert_true(r->window[0] == 5 && r->window[1] == 10); /* a refused window changes nothing */

    assert_true(recording_window(r, 6, 9, &error));
    recording_restore(r);
    assert_true(r->window[0] == 5 && r->window[1] == 10 && r->zero == 0);
    arena_reset(&arena);
    recording_destroy(r);
    recording_destroy(NULL);
}

TEST(description_says_what_was_found)
{
    struct buffer text = {0};
    struct recording *r = fixture_good(
        "Motion Sensor Data File\nTime (s)\tDistance (cm)\tDist Error (cm)\n0.00\t20.5\t0.239\n"
        "0.02\t20.6\t0.239\n0.04\t20.7\t0.239\n0.06\t20.8\t0.239\nx\n",
        "");
    recording_describe(r, &text);
    assert_non_null(strstr(
        text.data,
        "file.txt: Distance [cm], 4 rows, 0..0.06 s, 50 Hz; tab, 2 header lines, 1 row dropped\n"));
    assert_non_null(
        strstr(text.data, "columns: 1 Time [s] = t, 2 Distance [cm] = y, 3 Dist Error [cm]"));
    assert_non_null(strstr(text.data, "tunit= rate= decimal= sep="));
    assert_non_null(strstr(
        text.data, "\nwarning: 1 line dropped that is not 3 numbers (first: line 7, 'x')\n"));
    recording_destroy(r);
    buffer_free(&text);
}

/* However bad a file is, the warnings stay few. */
TEST(warnings_are_few)
{
    struct buffer text = {0};
    buffer_put(&text, TEXT("t"));
    for (int i = 0; i < 30; i++)
        buffer_format(&text, ",c%d", i);
    for (int row = 0; row < 4; row++) {
        buffer_format(&text, "\n%d", row);
        for (int i = 0; i < 30; i++)
            buffer_put(&text, row == 3 ? TEXT(",oops") : row == 2 ? TEXT(",2") : TEXT(",1"));
    }
    buffer_put(&text, TEXT("\n4"));
    for (int i = 0; i < 30; i++)
        buffer_put(&text, TEXT(",1"));
    buffer_char(&text, '\n');
    struct recording *r = fixture_good(text.data, "");
    /* of 30 columns with a word, two units and a value missing */
    assert_int_equal(r->warnings, 11);
    assert_int_equal(r->unsaid, 23);
    assert_string_equal(r->warning[10], "and 23 more kinds");
    recording_destroy(r);
    buffer_free(&text);
}

/* Counters of 16 and 32 bits that become full, at any step, with a row missing here and there. */
TEST(full_counters_continue)
{
    static const struct {
        double full;
        const char *unit;
    } counters[] = {{65536, "ms"}, {4294967296, "us"}, {65536, "us"}};
    (void)state;
    random_state = 31;
    for (int run = 0; run < 60; run++) {
        const double full = counters[run % 3].full,
                     step = floor(full / (100 + 900 * random_uniform())),
                     start = floor(full * random_uniform()), factor = run % 3 == 0 ? 1e-3 : 1e-6;
        struct buffer text = {0};
        size_t rows = 0;
        double last = 0;
        buffer_format(&text, run % 2 ? "%s,y\n" : "t [%s];y [cm]\n", counters[run % 3].unit);
        for (int i = 0; i < 2000; i++) {
            if (i > 0 && random_uniform() < 0.01)
                continue;
            last = i * step;
            rows++;
            buffer_format(&text, run % 2 ? "%.0f,%.2f\n" : "%.0f;%.2f\n", fmod(start + last, full),
                          20 + sin(0.1 * i));
        }
        struct recording *r = fixture_good(text.data, "");
        assert_int_equal(r->rows, rows);
        assert_true(near(r->t[rows - 1] - r->t[0], last * factor, 1e-9 * last * factor));
        assert_true(fixture_warns(r, "overflowed"));
        recording_destroy(r);
        buffer_free(&text);
    }
}

/* Every cell has its unit with it, close or behind a blank; another one than before is no number.
 */
TEST(units_within_cells)
{
    static const struct {
        const char *unit;
        double factor;
    } times[] = {{"ms", 1e-3}, {"s", 1}, {"us", 1e-6}},
      lengths[] = {{"cm", 1e-2}, {"mm", 1e-3}, {"m", 1}};
    static const char *const separators[] = {",", ", ", ";", "\t"};
    (void)state;
    random_state = 32;
    for (int run = 0; run < 60; run++) {
        const int t = run % 3, y = run / 3 % 3, odd = run % 4 == 0 ? 50 : -1;
        const char *blank = run % 2 ? " " : "", *separator = separators[run % 4];
        struct buffer text = {0};
        if (run % 5 == 0)
            buffer_format(&text, "time%sdistance\n", separator);
        for (int i = 0; i < 100; i++)
            buffer_format(&text, "%d%s%s%s%.2f%s%s\n", 20 * i, blank, times[t].unit, separator,
                          20.25 + i % 7, blank, i == odd ? "km" : lengths[y].unit);
        struct recording *r = fixture_good(text.data, "");
        assert_int_equal(r->rows, 100);
        assert_true(near(r->t[99], 1980 * times[t].factor, 1e-9));
        assert_true(near(r->y[7], 20.25 * lengths[y].factor, 1e-12));
        assert_true(odd < 0 || (isnan(r->y[odd]) && fixture_warns(r, "km")));
        recording_destroy(r);
        buffer_free(&text);
    }
}

RUN_TESTS(fixture_setup, fixture_teardown)
