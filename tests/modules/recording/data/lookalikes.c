/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One motion in every dialect (scripts/make-recordings --formats): 21.64 cm + 5.2 cm exp(-0.05 t)
 * cos(8.695 t), 50 samples in a second, a second run of 3 cm where the format has runs. Each format
 * reads the same numbers.
 */
#include "modules/recording/data/fixture.h"

#define FOLDER "tests/fuzz/corpus/recording"

static const struct {
    const char *file, *options, *format, *value;
    size_t rows;
    /* [s] [cm] of the first displacement; [cm] to which it is printed */
    double t0, amplitude, precision;
    int runs;
} cases[] = {
    {"motion-sensor", "", "motion-sensor", "Distance", 60, 0, 5.2, 5e-4, 0},
    {"motion-index", "rate=50", "motion-index", "Distance", 60, 0, 5.2, 5e-4, 0},
    {"capstone-eu", "", "capstone", "Position, Ch P1 Run #1", 60, 0, 5.2, 5e-4, 2},
    {"capstone-eu", "run=2", "capstone", "Position, Ch P1 Run #2", 40, 0, 3, 5e-4, 2},
    {"capstone-us", "rate=50", "capstone", "Position Run #1", 60, 0, 5.2, 5e-6, 2},
    {"capstone-us", "rate=50 run=2", "capstone", "Position Run #2", 40, 0, 3, 5e-6, 2},
    {"vernier-text", "", "vernier-text", "Position", 60, 0, 5.2, 5e-4, 2},
    {"vernier-text", "run=2", "vernier-text", "Position", 40, 0, 3, 5e-4, 2},
    {"graphical-analysis", "", "graphical-analysis", "Latest: Position", 60, 0, 5.2, 5e-4, 2},
    {"graphical-analysis", "run=1", "graphical-analysis", "Run 1: Position", 40, 0, 3, 5e-4, 2},
    {"tracker", "unit=cm", "tracker", "x_{1}", 60, 0, 5.2, 1e-12, 1},
    {"labview-no", "", "labview", "Position (Trigger)", 60, 0, 5.2, 5e-7, 2},
    {"labview-no", "run=2", "labview", "Position (Trigger)", 40, 0, 3, 5e-7, 2},
    {"labview-multi", "", "labview", "Position", 60, 0, 5.2, 5e-7, 1},
    {"cassy", "", "cassy", "Weg s_A1", 60, 0, 5.2, 5e-6, 0},
    {"picoscope", "", "picoscope", "Channel A", 60, -0.5, 5.2, 5e-9, 0},
    {"oscilloscope", "unit=cm", "oscilloscope", "CH1", 60, 0, 5.2, 5e-6, 0},
    {"tektronix", "unit=cm", "tektronix", "CH1", 60, 0, 5.2, 5e-7, 0},
    {"labelled", "", "labelled", "distance", 60, 0, 5.2, 5e-4, 0},
    {"hand-made", "tunit=ms unit=cm", "hand-made", "column 2", 60, 0, 5.2, 5e-4, 0},
    {"table", "", "table", "x", 60, 0, 5.2, 5e-4, 0},
    {"collected", "unit=cm", "collected", "column 1", 60, 0, 5.2, 5e-4, 0},
};

static struct recording *load(const char *file, const char *written, struct error *error)
{
    char path[200];
    struct load_options options = fixture_options(written);
    snprintf(path, sizeof path, FOLDER "/%s", file);
    *error = (struct error){0};
    return recording_load(path, &options, error);
}

TEST(every_dialect_holds_the_motion)
{
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct error error;
        struct recording *r = load(cases[i].file, cases[i].options, &error);
        if (!r)
            fail_msg("%s %s: %s", cases[i].file, cases[i].options, error.text);
        const struct column *value = &r->column[r->value];
        if (strcmp(r->format, cases[i].format) || strcmp(value->name, cases[i].value) ||
            r->rows != cases[i].rows || r->dropped != 0 || r->runs != cases[i].runs ||
            value->quantity != QUANTITY_LENGTH)
            fail_msg("%s %s: %s, %s [%s], %zu rows, %zu dropped, %d runs", cases[i].file,
                     cases[i].options, r->format, value->name, value->unit, r->rows, r->dropped,
                     r->runs);
        if (!near(r->rate, 50, 1e-9))
            fail_msg("%s: %.17g Hz", cases[i].file, r->rate);
        for (size_t k = 0; k < r->rows; k++) {
            const double t = 0.02 * (double)k, y = 21.64 + cases[i].amplitude * exp(-0.05 * t) *
                                                               cos(8.695 * t); /* [cm] */
            if (!near(r->t[k], cases[i].t0 + t, 1e-12) ||
                !near(100 * r->y[k], y, 1.001 * cases[i].precision + 1e-12))
                fail_msg("%s %s: row %zu: t = %.17g, y = %.17g cm, not %.17g", cases[i].file,
                         cases[i].options, k, r->t[k], 100 * r->y[k], y);
        }
        recording_destroy(r);
    }
}

/* phyphox measures the acceleration; of its axes the one that moves most is taken, and never the
 * absolute value. */
TEST(the_axis_that_moves)
{
    struct error error;
    struct recording *r = load("phyphox", "", &error);
    assert_non_null(r);
    assert_string_equal(r->format, "phyphox");
    assert_string_equal(r->column[r->value].name, "Acceleration y");
    assert_int_equal(r->column[r->value].quantity, QUANTITY_ACCELERATION);
    for (size_t k = 0; k < r->rows; k++)
        assert_true(
            near(r->y[k], -0.756 * 5.2 * exp(-0.001 * (double)k) * cos(0.1739 * (double)k), 1e-8));
    recording_destroy(r);
    assert_non_null(r = load("phyphox", "y=2", &error));
    assert_string_equal(r->column[r->value].name, "Acceleration x");
    recording_destroy(r);
}

/* Every row of the table has a dialect here, so that a new format brings its look-alike. */
TEST(every_format_has_one)
{
    for (size_t i = 0; i < format_catalog.count; i++) {
        const char *name = catalog_row(&format_catalog, i)->name;
        bool found = strcmp(name, "phyphox") == 0;
        for (size_t k = 0; k < COUNT_OF(cases); k++)
            found |= strcmp(cases[k].format, name) == 0;
        if (!found)
            fail_msg("no look-alike of %s", name);
    }
}

RUN_TESTS(fixture_setup, fixture_teardown)
