/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The real recordings, where HOOKE_DATA has them: each is read with the right columns, units, rows
 * and rate, or refused for the right reason. They belong to others and are not part of the project.
 */
#include "modules/recording/data/fixture.h"

static const char *data_folder(void)
{
    const char *folder = getenv("HOOKE_DATA");
    return folder && *folder ? folder : "../shared/data";
}

static bool no_data(void)
{
    if (access(data_folder(), R_OK) == 0)
        return false;
    print_message("no real recordings in %s (HOOKE_DATA)\n", data_folder());
    return true;
}

static struct recording *load(const char *file, const char *options, struct error *error)
{
    char path[1000];
    struct load_options load_options = fixture_options(options);
    snprintf(path, sizeof path, "%s/%s", data_folder(), file);
    *error = (struct error){0};
    return recording_load(path, &load_options, error);
}

static const struct expected {
    const char *file, *options, *format, *value, *unit;
    size_t rows, dropped, missing; /* missing: values among the rows */
    double t0, t1, rate;           /* [s] [1/s] */
    char separator, decimal;
    int header_lines;
} readable[] = {
    {"uoft-pandhi/position data.txt", "", "motion-sensor", "Distance", "cm", 724, 0, 0, 0.43, 7.66,
     100, '\t', '.', 2},
    {"uoft-pandhi/velocity data.txt", "", "motion-sensor", "Velocity", "cm/s", 724, 0, 1, 0.43,
     7.66, 100, '\t', '.', 2},
    {"uoft-pandhi/damped position.txt", "", "motion-sensor", "Distance", "cm", 12172, 0, 0, 0,
     121.71, 100, '\t', '.', 2},
    {"uoft-pandhi/damped velocity.txt", "", "motion-sensor", "Velocity", "cm/s", 12172, 0, 1, 0,
     121.71, 100, '\t', '.', 2},
    {"uoft-travelwithwind/position.txt", "", "motion-sensor", "Distance", "cm", 523, 0, 0, 0, 8.7,
     60, '\t', '.', 2},
    {"uoft-travelwithwind/velocity.txt", "", "motion-sensor", "Velocity", "cm/s", 523, 0, 1, 0, 8.7,
     60, '\t', '.', 2},
    {"uoft-travelwithwind/position_damped.txt", "", "motion-sensor", "Distance", "cm", 6479, 0, 0,
     0, 107.967, 60, '\t', '.', 2},
    {"uoft-travelwithwind/velocity_damped.txt", "", "motion-sensor", "Velocity", "cm/s", 6481, 0, 1,
     0, 108, 60, '\t', '.', 2},
    {"uoft-pankaj/undamped_point_data.txt", "", "motion-sensor", "Distance", "cm", 1451, 0, 0, 5.04,
     19.54, 100, '\t', '.', 2},
    {"uoft-pankaj/undamped_point_data_set2.txt", "", "motion-sensor", "Distance", "cm", 978, 0, 0,
     0.49, 10.26, 100, '\t', '.', 2},
    {"uoft-pankaj/damped_point_data.txt", "", "motion-sensor", "Distance", "cm", 4241, 0, 0, 6.63,
     49.03, 100, '\t', '.', 2},
    {"uoft-kamjha/position_osc.txt", "", "motion-sensor", "Distance", "cm", 690, 0, 0, 1.27, 8.16,
     100, '\t', '.', 2},
    {"uoft-kamjha/velocity_osc.txt", "", "motion-sensor", "Velocity", "cm/s", 690, 0, 1, 1.27, 8.16,
     100, '\t', '.', 2},
    {"uoft-kamjha/position_drag_osc2[3835].txt", "", "motion-sensor", "Distance", "cm", 1372, 0, 0,
     11.888, 22.856, 125, '\t', '.', 2},
    {"uoft-kamjha/velocity_drag_osc2[3836].txt", "", "motion-sensor", "Velocity", "cm/s", 947, 0, 1,
     56.28, 63.848, 125, '\t', '.', 2},
    {"pasco-mattia04/Oscillazioni pretensionata_cd_5e7masse.csv", "rate=100", "capstone",
     "Position Run #1", "mm", 1875, 0, 0, 0, 18.74, 100, ';', ',', 1},
    {"pasco-mattia04/Oscillazioni pretensionata_cd_5e7masse.csv", "rate=100 run=2", "capstone",
     "Position Run #2", "mm", 2384, 0, 0, 0, 23.83, 100, ';', ',', 1},
    {"pasco-mattia04/Oscillazioni pretensionata_cd_5e7masse.csv", "rate=100 y=2", "capstone",
     "Position Run #2", "mm", 2384, 0, 0, 0, 23.83, 100, ';', ',', 1},
    {"pasco-mattia04/Oscillazioni pretensionata_rete_5e7masse.csv", "rate=100", "capstone",
     "Position Run #1", "mm", 1993, 0, 0, 0, 19.92, 100, ';', ',', 1},
    {"pasco-mattia04/Oscillazioni non_pretensionata_cd_3e1masse.csv", "rate=100", "capstone",
     "Position Run #1", "mm", 3058, 0, 0, 0, 30.57, 100, ';', ',', 1},
    {"pasco-mattia04/Oscillazioni non_pretensionata_cd_3e1masse.csv", "rate=100 run=2", "capstone",
     "Position Run #2", "mm", 2558, 0, 0, 0, 25.57, 100, ';', ',', 1},
    {"pasco-mattia04/Oscillazioni non_pretensionata_rete_3e1masse.csv", "rate=100", "capstone",
     "Position Run #1", "mm", 3457, 0, 0, 0, 34.56, 100, ';', ',', 1},
    {"pasco-mattia04/Forzante ad omega potenza 10e16.csv", "rate=100", "capstone",
     "Position Run #2", "mm", 9408, 0, 0, 0, 94.07, 100, ';', ',', 1},
    {"pasco-mattia04/Forzante ad omega potenza 10e16.csv", "rate=100 run=3", "capstone",
     "Position Run #3", "mm", 12088, 0, 0, 0, 120.87, 100, ';', ',', 1},
    {"pasco-mattia04/stima tempo caratteristico.csv", "rate=100", "capstone", "Position Run #1",
     "mm", 3039, 0, 0, 0, 30.38, 100, '\n', ',', 1},
    {"pasco-mattia04/Misure k statiche pretensionata.csv", "rate=100", "capstone",
     "Position Run #1", "mm", 1048, 0, 0, 0, 10.47, 100, ';', ',', 1},
    {"pasco-mattia04/Misure k statiche pretensionata.csv", "rate=100 run=3", "capstone",
     "Position Run #3", "mm", 1854, 0, 0, 0, 18.53, 100, ';', ',', 1},
    {"pasco-mattia04/Misure k statiche non_pretensionata.csv", "rate=100", "capstone",
     "Position Run #1", "mm", 1275, 0, 0, 0, 12.74, 100, ';', ',', 1},
    {"phyphox-facufer9/Dinam_190g.csv", "", "phyphox", "Acceleration y", "m/s^2", 500, 0, 0,
     18.02134299, 30.34013492, 40.5, ',', '.', 1},
    {"phyphox-facufer9/Dinam_253g.csv", "", "phyphox", "Acceleration y", "m/s^2", 500, 0, 0,
     13.15808854, 25.4768881, 40.5, ',', '.', 1},
    {"phyphox-facufer9/Dinam_278g.csv", "", "phyphox", "Acceleration y", "m/s^2", 500, 0, 0,
     16.36748167, 28.68628289, 40.5, ',', '.', 1},
    {"phyphox-facufer9/Dinam_342g.csv", "", "phyphox", "Acceleration y", "m/s^2", 500, 0, 0,
     14.07157102, 26.39043075, 40.5, ',', '.', 1},
    {"phyphox-facufer9/Datos_Resorte.csv", "", "phyphox", "Acceleration y", "m/s^2", 500, 0, 0,
     25.35961318, 37.68150324, 40.5, ',', '.', 1},
    {"phyphox-facufer9/Raw Data.csv", "", "phyphox", "Acceleration z", "m/s^2", 424, 0, 0, 0,
     10.4434988, 40.5, ',', '.', 1},
    {"semicolon-stecu/experiment_1.csv", "unit=mm", "hand-made", "column 2", "mm", 250, 0, 0, 0,
     2.49, 100, ';', ',', 0},
    {"semicolon-stecu/experiment_1-dotdecimal.csv", "unit=mm", "hand-made", "column 2", "mm", 250,
     0, 0, 0, 2.49, 100, ';', '.', 0},
    {"semicolon-stecu/experiment_2.csv", "unit=mm", "hand-made", "column 2", "mm", 250, 0, 0, 0,
     2.49, 100, ';', ',', 0},
    {"semicolon-stecu/experiment_3.csv", "unit=mm", "hand-made", "column 2", "mm", 250, 0, 0, 0,
     2.49, 100, ';', ',', 0},
    {"tracker-jiarui/8047.txt", "", "tracker", "x", "", 4206, 0, 0, 0, 140.22500000000002, 30, '\t',
     '.', 1},
    {"tracker-jiarui/8048.txt", "", "tracker", "x_{1}", "", 4005, 0, 0, 0, 133.52333333333334, 30,
     '\t', '.', 1},
    {"tracker-jiarui/8054.txt", "", "tracker", "x_{1}", "", 4100, 0, 0, 0, 136.69000000000003, 30,
     '\t', '.', 2},
    {"tracker-jiarui/8055.txt", "", "tracker", "x", "", 4223, 0, 0, 0, 140.79166666666666, 30, '\t',
     '.', 2},
    {"tracker-jiarui/AAAtAmp3.txt", "", "hand-made", "column 2", "", 9944, 0, 0, 0,
     331.5733333333334, 30, '\t', '.', 0},
    {"tracker-jiarui/8047peaks.txt", "", "table", "amplitude", "", 58, 0, 0, 1.2, 139.1, 0.413, ' ',
     '.', 1},
    {"vernierformat-amellinger/test1.txt", "", "vernier-text", "Top", "m", 400, 0, 0, 0.021, 8.1,
     49.4, '\t', '.', 6},
    {"microbit-es2/data_697.txt", "tunit=ms", "hand-made", "column 2", "", 413, 2, 0, 0.01, 9.81,
     42, '\t', '.', 0},
    {"microbit-es2/data_913.txt", "tunit=ms", "hand-made", "column 2", "", 433, 6, 0, 0, 4.976,
     86.8, '\t', '.', 0},
    {"lvm-ladisk/multi_time_column.lvm", "y=Voltage", "labview", "Voltage", "Volts", 3, 0, 0, 0,
     3.90625e-5, 51200, '\t', '.', 23},
    {"lvm-ladisk/no_decimal_separator.lvm", "", "labview", "ax", "g", 4, 0, 0, 0, 7.5e-4, 4000,
     '\t', '.', 22},
    {"lvm-ladisk/with_comments.lvm", "y=Volume", "labview", "Volume (ml)", "ml", 9, 0, 0, 0,
     9.723275, 0.823, '\t', '.', 23},
    {"lvm-ladisk/with_empty_fields.lvm", "", "labview", "Dev0/Ai0", "", 7, 0, 0, 0, 0.006, 1000,
     '\t', '.', 23},
    {"lvm-ladisk/short.lvm", "", "labview", "Response (Trigger)", "m/s^2", 10, 0, 0, 0, 3.515625e-4,
     25600, '\t', ',', 23},
    {"lvm-ladisk/short_new_line_end.lvm", "y=2", "labview", "Excitation (Trigger)", "Newtons", 10,
     0, 0, 0, 3.515625e-4, 25600, '\t', ',', 23},
    {"lvm-ladisk/long_single_header_multi_ch.lvm", "", "labview", "m_2", "m/s^2", 16384, 0, 0, 0,
     16.006191, 1023.54, '\t', '.', 22},
};

static const struct {
    const char *file, *says;
} refused[] = {
    {"pasco-mattia04/Forzante ad omega potenza 10e16.csv", "no time column"},
    {"pasco-mattia04/stima tempo caratteristico.csv", "rate=100"},
    {"pasco-mattia04/Oscillazioni pretensionata_cd_5e7masse.csv", "no time column"},
    {"tracker-jiarui/PeriodVsLength.txt", "no time column"},
    {"tracker-jiarui/QfactorVsLength.txt", "no time column"},
};

TEST(recordings_are_read)
{
    if (no_data())
        skip();
    for (size_t i = 0; i < COUNT_OF(readable); i++) {
        const struct expected *e = &readable[i];
        struct error error;
        struct recording *r = load(e->file, e->options, &error);
        if (!r)
            fail_msg("%s: %s", e->file, error.text);
        const struct column *value = &r->column[r->value];
        size_t missing = 0;
        for (size_t row = 0; row < r->rows; row++)
            missing += isnan(r->y[row]) ? 1 : 0;
        if (strcmp(r->format, e->format) || strcmp(value->name, e->value) ||
            strcmp(value->unit, e->unit))
            fail_msg("%s: read as %s, %s [%s]", e->file, r->format, value->name, value->unit);
        if (e->rows > 0 &&
            (r->rows != e->rows || r->dropped != e->dropped || missing != e->missing))
            fail_msg("%s: %zu rows, %zu dropped, %zu missing", e->file, r->rows, r->dropped,
                     missing);
        /* rounded stamps give way to the line through them, which is within half a digit */
        const double half = r->pace > 0 ? 0.5e-3 : 1e-9;
        if (e->rows > 0 && (!near(r->t[0], e->t0, half) || !near(r->t[r->rows - 1], e->t1, half)))
            fail_msg("%s: %.17g to %.17g s", e->file, r->t[0], r->t[r->rows - 1]);
        if (!near(r->rate, e->rate, 1e-3 * e->rate))
            fail_msg("%s: %.17g Hz", e->file, r->rate);
        if (r->separator != e->separator || r->decimal != e->decimal ||
            r->header_lines != e->header_lines)
            fail_msg("%s: separator %d decimal %c header %d", e->file, r->separator, r->decimal,
                     r->header_lines);
        recording_destroy(r);
    }
}

TEST(the_rest_is_refused_with_a_reason)
{
    if (no_data())
        skip();
    for (size_t i = 0; i < COUNT_OF(refused); i++) {
        struct error error;
        struct recording *r = load(refused[i].file, "", &error);
        if (r)
            fail_msg("%s was read", refused[i].file);
        assert_int_equal(error.code, ERROR_IO);
        if (!strstr(error.text, refused[i].says))
            fail_msg("%s: %s", refused[i].file, error.text);
    }
}

/* The lab's own files need nothing said but for the missing first velocity; the micro:bit's faults
 * are all said. */
TEST(warnings_are_to_the_point)
{
    struct error error;
    if (no_data())
        skip();
    for (size_t i = 0; i < COUNT_OF(readable); i++)
        if (!strcmp(readable[i].format, "motion-sensor")) {
            struct recording *r = load(readable[i].file, "", &error);
            assert_non_null(r);
            assert_int_equal(r->warnings, readable[i].missing);
            recording_destroy(r);
        }
    struct recording *r = load("microbit-es2/data_913.txt", "", &error);
    assert_non_null(r);
    assert_true(fixture_warns(r, "the last line (439) seems to end inside a number ('-1')"));
    assert_true(fixture_warns(r, "5 rows go back in time: dropped (first: line 387)"));
    assert_true(fixture_warns(r, "gaps between samples"));
    assert_true(fixture_warns(r, "tunit=ms"));
    recording_destroy(r);
    assert_non_null(r = load("microbit-es2/data_697.txt", "", &error));
    assert_true(fixture_warns(r, "2 rows go back in time: dropped (first: line 186)"));
    recording_destroy(r);
}

static bool is_expected(const char *file)
{
    for (size_t i = 0; i < COUNT_OF(readable); i++)
        if (!strcmp(readable[i].file, file))
            return true;
    for (size_t i = 0; i < COUNT_OF(refused); i++)
        if (!strcmp(refused[i].file, file))
            return true;
    return false;
}

/* No file lies there that the tables above leave out, but for its provenance, which is prose and no
 * table. */
TEST(every_file_is_expected)
{
    if (no_data())
        skip();
    DIR *top = opendir(data_folder());
    int files = 0;
    assert_non_null(top);
    for (struct dirent *group; (group = readdir(top));) {
        char path[600];
        snprintf(path, sizeof path, "%s/%s", data_folder(), group->d_name);
        DIR *folder = group->d_name[0] != '.' ? opendir(path) : NULL;
        for (struct dirent *entry; folder && (entry = readdir(folder));) {
            char file[600];
            struct error error;
            if (entry->d_name[0] == '.')
                continue;
            snprintf(file, sizeof file, "%s/%s", group->d_name, entry->d_name);
            if (!strcmp(entry->d_name, "PROVENANCE.txt")) {
                struct recording *r = load(file, "", &error);
                if (r || error.code != ERROR_IO || !strstr(error.text, "no table of numbers"))
                    fail_msg("%s: %s", file, r ? "read" : error.text);
            } else if (!is_expected(file)) {
                fail_msg("nothing is expected of %s", file);
            }
            files++;
        }
        if (folder)
            closedir(folder);
    }
    closedir(top);
    assert_true(files > 40);
}

TEST(both_forms_of_a_series_agree)
{
    struct error error;
    if (no_data())
        skip();
    struct recording *comma = load("semicolon-stecu/experiment_1.csv", "", &error);
    struct recording *point = load("semicolon-stecu/experiment_1-dotdecimal.csv", "", &error);
    assert_true(comma && point && comma->rows == point->rows);
    for (size_t i = 0; i < comma->rows; i++)
        assert_true(comma->t[i] == point->t[i] && comma->y[i] == point->y[i]);
    recording_destroy(comma);
    recording_destroy(point);
}

/* Offsets and amplitudes of the reference values, roughly: columns and units are the right ones. */
TEST(values_have_the_right_size)
{
    static const struct {
        const char *file;
        double offset, amplitude; /* [m] */
    } cases[] = {
        {"uoft-pandhi/position data.txt", 0.21629, 0.05144},
        {"uoft-travelwithwind/position.txt", 0.2454, 0.0828},
        {"uoft-pankaj/undamped_point_data.txt", 0.20718, 0.0310},
        {"uoft-pankaj/undamped_point_data_set2.txt", 0.20707, 0.00724},
        {"uoft-kamjha/position_osc.txt", 0.23198, 0.04118},
        {"uoft-kamjha/position_drag_osc2[3835].txt", 0.3259, 0.0473},
    };
    if (no_data())
        skip();
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct error error;
        struct series series;
        struct arena arena = {0};
        struct recording *r = load(cases[i].file, "", &error);
        assert_non_null(r);
        assert_true(recording_series(r, &arena, 100, &series, &error));
        assert_int_equal(series.quantity, QUANTITY_LENGTH);
        double mean = 0, squares = 0;
        for (size_t k = 0; k < series.n; k++)
            mean += series.y[k] / (double)series.n;
        for (size_t k = 0; k < series.n; k++)
            squares += (series.y[k] - mean) * (series.y[k] - mean) / (double)series.n;
        /* The amplitude of a sine is sqrt 2 times its standard deviation; sway, decay and outliers
         * make up 10 %. */
        if (!near(mean, cases[i].offset, 0.1 * cases[i].amplitude) ||
            !near(sqrt(2 * squares), cases[i].amplitude, 0.1 * cases[i].amplitude))
            fail_msg("%s: offset %g m, amplitude %g m", cases[i].file, mean, sqrt(2 * squares));
        arena_reset(&arena);
        recording_destroy(r);
    }
}

RUN_TESTS(fixture_setup, fixture_teardown)
