/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Several recordings in one file: which exist, which is taken, how it is said. */
#include "modules/recording/data/fixture.h"

#define SIDE_BY_SIDE                                                                               \
    "\"Time (s) Run #2\";\"Position (m) Run #2\";\"Time (s) Run #3\";\"Position (m) Run "          \
    "#3\";\"Force (N) Run #3\"\n"                                                                  \
    "0;1,5;5;2,5;9\n1;1,6;6;2,6;8\n2;1,7;7;2,7;9\n;;8;2,8;7\n;;9;2,9;8\n"
#define LATEST                                                                                     \
    "Latest: Time (s),Latest: Position (m),Run 1: Time (s),Run 1: Position (m)\n"                  \
    "0,0.5,0,1.5\n0.05,0.6,0.05,1.6\n0.10,0.7,,\n"
#define SHARED_TIME                                                                                \
    "\"Time (s) Run #1\",\"Position (m) Run #1\",\"Position (m) Run "                              \
    "#2\"\n0,1.5,7.5\n1,1.6,7.6\n2,1.7,7.7\n"
#define EMPTY_FIRST                                                                                \
    "\"Time (s) Run #1\",\"Position (m) Run #1\",\"Time (s) Run #2\",\"Position (m) Run #2\"\n"    \
    ",,0,7.5\n,,1,7.6\n,,2,7.7\n"
#define VERNIER(name, first)                                                                       \
    "Vernier Format 2\nmotion.cmbl 1/2/2026\n" name "\nTime\tPosition\nt\tx\ns\tm\n\n0\t" first    \
    ".5\n1\t" first ".6\n2\t" first ".7\n"
#define SETS                                                                                       \
    "Vernier Format "                                                                              \
    "2\nsource\nbare\nTime\tPosition\nt\tx\ns\tm\n0\t1\n1\t2\n2\t4\n\ndisk\nTime\tPosition\nt\tx"  \
    "\ns\tcm\n0\t8\n1\t7\n"
#define SEGMENT(x0, first)                                                                         \
    "Channels\t1\t\nY_Unit_Label\tm\t\nX0\t" x0                                                    \
    "\t\nDelta_X\t0.5\t\n***End_of_Header***\t\t\nX_Value\tPos\tComment\n"                         \
    "\t" first ".5\n\t" first ".6\n\t" first ".7\n\n"
#define LABVIEW "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tNo\n***End_of_Header***\t\n\n"

static const struct {
    const char *text, *options, *value, *time;
    int runs, taken;
    size_t rows, dropped;
    double t0, y0, y1;
} cases[] = {
    {SIDE_BY_SIDE, "", "Position Run #2", "Time Run #2", 2, 0, 3, 0, 0, 1.5, 1.7},
    {SIDE_BY_SIDE, "run=3", "Position Run #3", "Time Run #3", 2, 1, 5, 0, 5, 2.5, 2.9},
    {SIDE_BY_SIDE, "run=3 y=Force", "Force Run #3", "Time Run #3", 2, 1, 5, 0, 5, 9, 8},
    {SIDE_BY_SIDE, "y=Force", "Force Run #3", "Time Run #3", 2, 1, 5, 0, 5, 9, 8},
    {SIDE_BY_SIDE, "y=Position", "Position Run #2", "Time Run #2", 2, 0, 3, 0, 0, 1.5, 1.7},
    {SIDE_BY_SIDE, "y=4", "Position Run #3", "Time Run #3", 2, 1, 5, 0, 5, 2.5, 2.9},
    {SIDE_BY_SIDE, "run=Run_#3", NULL, NULL, 0, 0, 0, 0, 0, 0, 0},
    {SIDE_BY_SIDE, "run=2 y=4", NULL, NULL, 0, 0, 0, 0, 0, 0, 0},
    {SIDE_BY_SIDE, "run=1", NULL, NULL, 0, 0, 0, 0, 0, 0,
     0}, /* the runs have numbers of their own */
    {LATEST, "", "Latest: Position", "Latest: Time", 2, 0, 3, 0, 0, 0.5, 0.7},
    {LATEST, "run=latest", "Latest: Position", "Latest: Time", 2, 0, 3, 0, 0, 0.5, 0.7},
    {LATEST, "run=1", "Run 1: Position", "Run 1: Time", 2, 1, 2, 0, 0, 1.5, 1.6},
    {LATEST, "run=1 y=position", "Run 1: Position", "Run 1: Time", 2, 1, 2, 0, 0, 1.5, 1.6},
    {SHARED_TIME, "run=2", "Position Run #2", "Time Run #1", 2, 1, 3, 0, 0, 7.5, 7.7},
    {EMPTY_FIRST, "", "Position Run #2", "Time Run #2", 2, 1, 3, 0, 0, 7.5, 7.7},
    {VERNIER("Run 1", "1") VERNIER("Run 2", "4"), "", "Position", "Time", 2, 0, 3, 0, 0, 1.5, 1.7},
    {VERNIER("Run 1", "1") VERNIER("Run 2", "4"), "run=2", "Position", "Time", 2, 1, 3, 0, 0, 4.5,
     4.7},
    {VERNIER("same", "1") VERNIER("same", "4"), "run=2", "Position", "Time", 2, 1, 3, 0, 0, 4.5,
     4.7},
    {SETS, "", "Position", "Time", 2, 0, 3, 0, 0, 1, 4},
    {SETS, "run=disk", "Position", "Time", 2, 1, 2, 0, 0, 0.08, 0.07},
    {SETS "stray words\n2\t6\n", "run=disk", "Position", "Time", 2, 1, 3, 1, 0, 0.08, 0.06},
    {LABVIEW SEGMENT("0", "1") SEGMENT("8", "2"), "", "Pos", "X_Value", 2, 0, 3, 0, 0, 1.5, 1.7},
    {LABVIEW SEGMENT("0", "1") SEGMENT("8", "2"), "run=2", "Pos", "X_Value", 2, 1, 3, 0, 8, 2.5,
     2.7},
    {LABVIEW SEGMENT("0", "1") SEGMENT("8", "2"), "run=3", NULL, NULL, 0, 0, 0, 0, 0, 0, 0},
    {"t,y\n0,1\n1,2\n", "run=1", NULL, NULL, 0, 0, 0, 0, 0, 0, 0},
    {"t_{1}\tx_{1}\tt_{2}\tx_{2}\n0\t1\t0\t4\n1\t2\t1\t5\n2\t3\t2\t7\n", "run=2", "x_{2}", "t_{2}",
     2, 1, 3, 0, 0, 4, 7},
};

TEST(the_run_said_is_read)
{
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct error error;
        struct recording *r =
            fixture_load(cases[i].text, strlen(cases[i].text), cases[i].options, &error);
        if (!cases[i].value) {
            if (r || error.code != ERROR_COMMAND || !error.hint[0] || !error.where.data)
                fail_msg("%s in\n%s", r ? "read" : error.text, cases[i].text);
            continue;
        }
        if (!r)
            fail_msg("%s (%s) in\n%s", error.text, cases[i].options, cases[i].text);
        if (strcmp(r->column[r->value].name, cases[i].value) ||
            strcmp(r->column[r->time].name, cases[i].time) || r->runs != cases[i].runs ||
            r->taken != cases[i].taken || r->rows != cases[i].rows ||
            r->dropped != cases[i].dropped)
            fail_msg("%s, %s, run %d of %d, %zu rows, %zu dropped: %s in\n%s",
                     r->column[r->value].name, r->column[r->time].name, r->taken, r->runs, r->rows,
                     r->dropped, cases[i].options, cases[i].text);
        if (!near(r->t[0], cases[i].t0, 1e-12) || !near(r->y[0], cases[i].y0, 1e-12) ||
            !near(r->y[r->rows - 1], cases[i].y1, 1e-12))
            fail_msg("t %g, y %g … %g: %s in\n%s", r->t[0], r->y[0], r->y[r->rows - 1],
                     cases[i].options, cases[i].text);
        recording_destroy(r);
    }
}

TEST(what_there_is_is_said)
{
    struct buffer text = {0};
    struct recording *r = fixture_good(SIDE_BY_SIDE, "run=3");
    recording_describe(r, &text);
    assert_non_null(strstr(text.data, "runs: Run #2, Run #3 = used"));
    recording_destroy(r);
    buffer_clear(&text);
    assert_non_null(r = fixture_good(SHARED_TIME, "run=2"));
    assert_true(fixture_warns(r, "Run #2 has no times; those of 'Time Run #1' are used"));
    recording_destroy(r);
    assert_non_null(r = fixture_good(SETS, "run=disk"));
    assert_int_equal(r->header_lines, 4);
    assert_int_equal(r->line[0], 15);
    recording_destroy(r);
    buffer_free(&text);
}

/* Capstone writes up to 150 columns; each run has two here, each shorter than the one before. */
TEST(many_runs)
{
    struct buffer text = {0};
    struct error error;
    for (int run = 1; run <= 75; run++)
        buffer_format(&text, "%s\"Time (s) Run #%d\";\"Position (cm) Run #%d\"",
                      run > 1 ? ";" : "\xEF\xBB\xBF", run, run);
    for (int row = 0; row < 100; row++)
        for (int run = 1; run <= 75; run++) {
            buffer_put(&text, run > 1 ? TEXT(";") : TEXT("\r\n"));
            if (row < 101 - run)
                buffer_format(&text, "%d,%02d;%d,5", row / 50, row % 50 * 2, run);
            else
                buffer_put(&text, TEXT(";"));
        }
    struct recording *r = fixture_load(text.data, text.len, "run=60", &error);
    assert_non_null(r);
    assert_int_equal(r->columns, 150);
    assert_int_equal(r->runs, 75);
    assert_int_equal(r->rows, 41);
    assert_int_equal(r->dropped, 0);
    assert_string_equal(r->column[r->value].name, "Position Run #60");
    assert_true(near(r->y[40], 0.605, 1e-12));
    recording_destroy(r);
    buffer_free(&text);
}

RUN_TESTS(fixture_setup, fixture_teardown)
