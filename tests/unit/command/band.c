/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * plot position --band: the band of an adopted fit against runs with parameters drawn from the
 * fit's covariance, the picture that holds it, and what has no band.
 */
#include "cmocka_testing.h"

#include "modules/pictures/svg_testing.h"
#include "long_form.h"
#include "unit/command/testing.h"

#include "modules/recording/fits.h"
#include "modules/solving/compute/solve.h"
#include <hooke/plot.h>

#define DT 0.02 /* [s] of the recordings and the runs */

static double uniform(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return ((double)(*seed >> 11) + 0.5) / 9007199254740992.0;
}

static double normal(uint64_t *seed)
{
    double sum = -6;
    for (int i = 0; i < 12; i++)
        sum += uniform(seed);
    return sum;
}

static struct equation motion_of(double gamma, double b, double f)
{
    return (struct equation){.value = {[EQUATION_START] = 0.05,
                                       [EQUATION_OMEGA] = 8.5,
                                       [EQUATION_RATE] = gamma,
                                       [EQUATION_RATE + 1] = b,
                                       [EQUATION_RATE + 2] = f}};
}

/* 8 s of y'' + gamma y' + b|y'|y' + f sign(y') + 72 y = 0 from 5 cm on, with noise. */
static void record(const char *name, double gamma, double b, double f, double noise, uint64_t seed)
{
    enum { SAMPLES = 400 };
    const struct equation motion = motion_of(gamma, b, f);
    double t[SAMPLES], y[SAMPLES];
    struct buffer text = {0};
    for (int i = 0; i < SAMPLES; i++)
        t[i] = i * DT;
    assert_true(equation_solve(&motion, t, SAMPLES, y, NULL));
    buffer_put(&text, TEXT("t [s],y [m]\n"));
    for (int i = 0; i < SAMPLES; i++)
        buffer_format(&text, "%.4f,%.7f\n", t[i], y[i] + noise * normal(&seed));
    write_file(name, text.data, text.len);
    buffer_free(&text);
}

/* ---- against draws ---- */

enum { DRAWS = 400, MOST = 8 };

/* covariance = L L^T; what is not positive within rounding becomes 0. */
static void factorise(const struct adopted_fit *adopted, double l[MOST][MOST])
{
    for (int i = 0; i < adopted->known.count; i++)
        for (int j = 0; j <= i; j++) {
            double sum = adopted->known.covariance[i * adopted->known.count + j];
            for (int k = 0; k < j; k++)
                sum -= l[i][k] * l[j][k];
            l[i][j] = i == j ? sqrt(fmax(sum, 0)) : l[j][j] > 0 ? sum / l[j][j] : 0;
        }
}

/* A run with other parameters, at every tenth row. */
static void run_drawn(const struct run *like, const struct scene *scene, int variable, double *y,
                      size_t n)
{
    struct error error;
    const double end = trace_time(like->trace, trace_count(like->trace) - 1);
    struct run *run = run_create(scene, like->method, &like->settings, end, &error);
    const struct run_target target = {.t = end, .steps = -1};
    assert_non_null(run);
    while (run_advance(run, &target, 0, NULL))
        continue;
    assert_int_equal(trace_count(run->trace), trace_count(like->trace));
    for (size_t i = 0; i < n; i++)
        y[i] = trace_state(run->trace, 10 * i)[variable];
    run_destroy(run);
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void draw(const struct session *session, const struct run *run, int variable,
                 double *values[DRAWS], size_t n)
{
    const struct adopted_fit *adopted = &fits_of(session)->adopted;
    double l[MOST][MOST] = {{0}};
    uint64_t seed = 7;
    struct error error;
    assert_in_range(adopted->known.count, 3, MOST);
    factorise(adopted, l);
    for (int d = 0; d < DRAWS; d++) {
        double z[MOST];
        struct scene scene = run->scene;
        for (int i = 0; i < adopted->known.count; i++)
            z[i] = normal(&seed);
        for (int i = 0; i < adopted->known.count; i++) {
            double value = scene.value[adopted->known.index[i]];
            for (int j = 0; j <= i; j++)
                value += l[i][j] * z[j];
            assert_true(
                scene_set(&scene, adopted->known.index[i], (struct measured){value, 0}, &error));
        }
        run_drawn(run, &scene, variable, values[d], n);
    }
}

/*
 * Half the distance of the 2.5 and the 97.5 percentile. Of 400 draws it is uncertain by about 5 %
 * (order statistics of a normal distribution: sqrt(p q/N)/f is 0.13 standard deviations at each
 * end); allowed are four times as much.
 */
static void check_percentiles(const struct curve *curve, double *values[DRAWS], size_t n)
{
    double sorted[DRAWS], ratios = 0;
    for (size_t i = 0; i < n; i++) {
        for (int d = 0; d < DRAWS; d++)
            sorted[d] = values[d][i];
        qsort(sorted, DRAWS, sizeof *sorted, by_size);
        const double half = 0.5 * (sorted[DRAWS - 1 - DRAWS / 40] - sorted[DRAWS / 40]);
        const bool rests = half == 0 && curve->spread[10 * i] < 1e-12; /* held by dry friction */
        const double ratio = rests ? 1 : half / curve->spread[10 * i];
        ratios += ratio / (double)n;
        if (!(ratio > 0.8 && ratio < 1.2))
            fail_msg("t = %g s: percentiles +- %g, the band +- %g", curve->x[10 * i], half,
                     curve->spread[10 * i]);
    }
    assert_true(ratios > 0.9 && ratios < 1.1);
}

/* kept: from what the session keeps for its panes. */
static void draw_kind(struct bench *bench, enum plot_kind kind, bool kept, struct arena *arena,
                      struct figure *figure)
{
    const int index = bench->session->runs.current;
    const struct figure_request request = {.kind = kind,
                                           .run = &index,
                                           .runs = 1,
                                           .recording = -1,
                                           .window = {NAN, NAN},
                                           .width = 4000,
                                           .band = kept ? TEXT("") : TEXT("--band"),
                                           .stored_band = kept,
                                           .full = true};
    struct error error = {0};
    if (!session_figure(bench->session, &request, arena, figure, &error))
        fail_msg("no figure: %s", error.text);
    assert_non_null(figure->curve[0].spread);
}

static void draw_band(struct bench *bench, struct arena *arena, struct figure *figure)
{
    draw_kind(bench, PLOT_POSITION, false, arena, figure);
}

static void check_draws(const char *line, enum plot_kind kind)
{
    struct bench bench;
    struct arena arena = {0};
    struct figure figure;
    double *values[DRAWS];
    bench_open(&bench, false);
    type_ok(&bench, "m = 200 g; method rk4 dt=20ms");
    type_ok(&bench, line);
    type_ok(&bench, "adopt; run 12 s");
    draw_kind(&bench, kind, false, &arena, &figure);
    const struct run *run = bench.session->runs.slot[bench.session->runs.current]->run;
    const size_t n = trace_count(run->trace) / 10;
    assert_int_equal(figure.curve[0].n, trace_count(run->trace));
    for (int d = 0; d < DRAWS; d++) {
        values[d] = arena_array(&arena, n, sizeof *values[d]);
        assert_non_null(values[d]);
    }
    draw(bench.session, run, kind == PLOT_VELOCITY, values, n);
    check_percentiles(&figure.curve[0], values, n);
    arena_reset(&arena);
    bench_close(&bench);
}

TEST(test_band_holds_95_percent)
{
    record("damped.csv", 0.2, 0, 0, 2e-3, 1);
    record("disk.csv", 0, 2, 0, 1e-3, 2);
    record("rub.csv", 0, 0, 0.08, 1e-3, 4);
    check_draws("load damped.csv; fit", PLOT_POSITION);
    check_draws("load damped.csv; fit drag", PLOT_POSITION);
    check_draws("load damped.csv; fit scene free=k,gamma,y0,v0", PLOT_POSITION);
    check_draws("scene drag; C = 1; m = 200 g; load disk.csv; fit drag", PLOT_POSITION);
    check_draws("load rub.csv; fit drag", PLOT_POSITION);
    check_draws("g = 9.81 m/s^2; load damped.csv; fit", PLOT_POSITION);
    check_draws("load damped.csv; fit drag", PLOT_VELOCITY);
    check_draws("load rub.csv; fit drag", PLOT_VELOCITY);
}

/* ---- against what is true ---- */

/* Sum of ((run - truth)/standard deviation)^2 over the rows, which are counted. */
static void add_deviations(struct bench *bench, const struct equation *truth, double *square,
                           double *inside, double *count)
{
    struct arena arena = {0};
    struct figure figure;
    draw_band(bench, &arena, &figure);
    const struct curve *curve = &figure.curve[0];
    double *y = arena_array(&arena, curve->n, sizeof *y);
    assert_non_null(y);
    assert_true(equation_solve(truth, curve->x, curve->n, y, NULL));
    for (size_t i = 0; i < curve->n; i++) {
        const double z = (curve->y[i] - y[i]) / curve->spread[i];
        *square += 1.96 * 1.96 * z * z;
        *inside += fabs(z) < 1;
        ++*count;
    }
    arena_reset(&arena);
}

/*
 * Recordings that differ in their noise alone: runs of what was adopted scatter about the truth as
 * the band says. Each has four parameters, so the mean square of 40 recordings, 1, is uncertain by
 * sqrt(2/160) = 0.11, and the share inside, 0.95, by about 0.03; both get three times that. Half
 * of the run lies beyond the recording. Without the correlations of the fit the mean is 0.4.
 */
static void check_scatter(const char *scene, const char *fit, double gamma, double b, double f,
                          double noise)
{
    const uint64_t recordings = is_long() ? 40 : 16;
    const struct equation truth = motion_of(gamma, b, f);
    double square = 0, inside = 0, count = 0;
    for (uint64_t seed = 0; seed < recordings; seed++) {
        struct bench bench;
        bench_open(&bench, false);
        record("again.csv", gamma, b, f, noise, 100 + seed);
        type_ok(&bench, scene);
        type_ok(&bench, "m = 200 g; method rk4 dt=20ms; load again.csv");
        type_ok(&bench, fit);
        type_ok(&bench, "adopt; method dop853 tol=1e-9; run 16 s");
        add_deviations(&bench, &truth, &square, &inside, &count);
        bench_close(&bench);
    }
    if (!(square / count > 0.6 && square / count < 1.5 && inside / count > 0.86))
        fail_msg("%s: mean square %.3f, %.1f %% inside", fit, square / count, 100 * inside / count);
}

TEST(test_band_covers_the_truth)
{
    check_scatter("scene spring", "fit", 0.2, 0, 0, 2e-3);
    check_scatter("scene spring", "fit scene free=k,gamma,y0,v0", 0.2, 0, 0, 2e-3);
    check_scatter("scene drag; gamma = 0", "fit drag", 0, 2, 0, 1e-3);
}

/* ---- the picture ---- */

/* Height of an edge, points [first, last] of which x rises or falls, there; NAN: beyond its ends.
 */
static double edge_at(double (*point)[2], size_t first, size_t last, double x)
{
    for (size_t i = first; i < last; i++) {
        const double a = point[i][0], b = point[i + 1][0];
        if ((x >= a && x <= b) || (x >= b && x <= a))
            return a == b ? point[i][1]
                          : point[i][1] + (x - a) / (b - a) * (point[i + 1][1] - point[i][1]);
    }
    return NAN;
}

static char *file_text(const char *name)
{
    FILE *file = fopen(name, "rb");
    assert_non_null(file);
    char *text = calloc(1, 1 << 20);
    assert_non_null(text);
    assert_true(fread(text, 1, (1 << 20) - 1, file) > 0);
    fclose(file);
    return text;
}

/* Points of the longest path that is an area, or a line; the others are those of the legend. */
static size_t read_longest(const char *svg, bool area, double (*point)[2], size_t max)
{
    static struct svg_path path;
    struct svg_element element;
    size_t n = 0;
    for (const char *at = NULL; svg_next(svg, &at, &element, &path);) {
        const bool color = *element.stroke && strcmp(element.stroke, "#0072b2") == 0;
        if (element.is_text || path.circles > 0 ||
            (area ? !element.filled : element.filled || !color) || (size_t)path.n <= n ||
            (size_t)path.n > max)
            continue;
        n = (size_t)path.n;
        for (size_t i = 0; i < n; i++) {
            point[i][0] = path.x[i];
            point[i][1] = path.y[i];
        }
    }
    return n;
}

TEST(test_picture_has_the_curve_in_its_band)
{
    enum { MAX_POINTS = 20000 };
    static double band[MAX_POINTS][2], line[MAX_POINTS][2];
    struct bench bench;
    bench_open(&bench, false);
    record("wide.csv", 0.2, 0, 0, 1e-2, 3);
    type_ok(&bench, "m = 200 g; method rk4 dt=20ms; load wide.csv; fit; adopt; run 8 s");
    type_ok(&bench, "plot position --band > band.svg");
    assert_says(&bench.out, "95 % band of the fit: at most +- ");
    char *svg = file_text("band.svg");
    const size_t n = read_longest(svg, true, band, MAX_POINTS),
                 points = read_longest(svg, false, line, MAX_POINTS);
    size_t turn = 0, inside = 0;
    while (turn + 1 < n && band[turn + 1][0] >= band[turn][0])
        turn++;
    assert_true(n > 200 && points > 100);
    for (size_t i = 0; i < points; i++) {
        const double above = edge_at(band, 0, turn, line[i][0]),
                     below = edge_at(band, turn + 1, n - 1, line[i][0]);
        if (isnan(above + below))
            continue;
        if (!(line[i][1] > above && line[i][1] < below)) /* y grows downwards */
            fail_msg("x = %g: the curve at %g, the band from %g to %g", line[i][0], line[i][1],
                     above, below);
        inside++;
    }
    assert_true(inside > points * 9 / 10);
    free(svg);
    type_ok(&bench, "plot position > plain.svg");
    svg = file_text("plain.svg");
    assert_null(strstr(svg, " opacity="));
    free(svg);
    bench_close(&bench);
}

/* Cells of the band in both character sets, and its name; none without --band. */
TEST(test_text_has_the_band)
{
    struct bench bench;
    bench_open(&bench, false);
    record("wide.csv", 0.2, 0, 0, 1e-2, 3);
    type_ok(&bench, "m = 200 g; method rk4 dt=20ms; load wide.csv; fit; adopt; run 8 s");
    type_ok(&bench, "set charset ascii; plot position --band");
    assert_says(&bench.out, ": 95 % of the fit");
    type_ok(&bench, "set charset braille; plot position --band");
    assert_says(&bench.out, "\xE2\x96\x91 95 % of the fit");
    type_ok(&bench, "plot position");
    assert_null(strstr(said(&bench.out), "95 %"));
    assert_null(strstr(said(&bench.out), "\xE2\x96\x91"));
    bench_close(&bench);
}

static void take_offer(void *context, const char *candidate, const char *brief)
{
    (void)brief;
    *(bool *)context |= strcmp(candidate, "--band") == 0;
}

TEST(test_option_is_completed)
{
    const char *line = "plot position --ba";
    struct bench bench;
    bool offered = false;
    size_t start;
    bench_open(&bench, true);
    command_complete(bench.session, text_of(line), strlen(line), &start, take_offer, &offered);
    assert_true(offered);
    bench_close(&bench);
}

/* ---- what has none ---- */

static void refused(struct bench *bench, const char *line, const char *why)
{
    if (type(bench, line))
        fail_msg("'%s' was not refused", line);
    assert_says(&bench->err, why);
}

TEST(test_refusals)
{
    struct bench bench;
    bench_open(&bench, false);
    record("damped.csv", 0.2, 0, 0, 2e-3, 1);
    type_ok(&bench, "method rk4 dt=10ms; run 3 s");
    refused(&bench, "plot position --band", "there is no adopted fit");
    refused(&bench, "plot energy --band",
            "--band works only for positions and velocities over time");
    type_ok(&bench, "m = 200 g; load damped.csv; fit; adopt");
    refused(&bench, "plot position --band", "in run 1, and ");
    type_ok(&bench, "run 3 s; plot position --band");
    refused(&bench, "plot position run all --band", "needs exactly one run");
    refused(&bench, "plot y --band", "--band works only for positions and velocities over time");
    refused(&bench, "plot position data damped --band", "needs exactly one run");
    type_ok(&bench, "y0 = 3 cm; run 3 s");
    refused(&bench, "plot position --band", "y0 is 3 cm in run 3, and ");
    assert_says(&bench.err, "adopt; run; plot position --band");
    type_ok(&bench, "adopt; run 3 s; plot position --band");
    type_ok(&bench, "change k=20 N/m; continue 1 s");
    refused(&bench, "plot position --band", "the run was changed after its start");
    type_ok(&bench, "adopt; run 3 s; change k=20 N/m; continue 1 s; adopt; continue 1 s");
    refused(&bench, "plot position --band", "the run was changed after its start");
    type_ok(&bench, "adopt; run 3 s; change v=0; continue 1 s");
    refused(&bench, "plot position --band", "the run was changed after its start");
    type_ok(&bench, "scene pendulum; run 1 s");
    refused(&bench, "plot position --band", "belongs to another scene");
    bench_close(&bench);
}

/* ---- where else it is ---- */

/* Of each row the band of the plot is what the file says, and what the panes keep to 0.5 %. */
static void check_kept(struct bench *bench, enum plot_kind kind)
{
    struct arena arena = {0};
    struct figure asked, kept;
    draw_kind(bench, kind, false, &arena, &asked);
    draw_kind(bench, kind, true, &arena, &kept);
    assert_int_equal(asked.curve[0].n, kept.curve[0].n);
    double max = 0, apart = 0;
    for (size_t i = 0; i < asked.curve[0].n; i++) {
        max = fmax(max, asked.curve[0].spread[i]);
        apart = fmax(apart, fabs(asked.curve[0].spread[i] - kept.curve[0].spread[i]));
    }
    assert_true(max > 0 && apart < 0.005 * max);
    arena_reset(&arena);
}

TEST(test_panes_keep_the_band)
{
    struct bench bench;
    bench_open(&bench, false);
    record("damped.csv", 0.2, 0, 0, 2e-3, 1);
    record("rub.csv", 0, 0, 0.08, 1e-3, 4);
    const struct session *session = bench.session;
    type_ok(&bench, "m = 200 g; method rk4 dt=20ms; set band on; run 4 s");
    assert_null(fits_of(session)->band.half); /* nothing was adopted: nothing is found */
    type_ok(&bench, "set band off; load damped.csv; fit drag; adopt; run 8 s");
    assert_null(fits_of(session)->band.half);
    type_ok(&bench, "set band on");
    check_kept(&bench, PLOT_POSITION);
    check_kept(&bench, PLOT_VELOCITY);
    const double *before = fits_of(session)->band.half;
    type_ok(&bench, "print y; plot position");
    assert_ptr_equal(fits_of(session)->band.half, before); /* found once */
    type_ok(&bench, "y0 = 3 cm; run 8 s");
    assert_null(fits_of(session)->band.half); /* it is no run of the fit */
    type_ok(&bench, "load rub.csv; fit drag; adopt; method dop853; run 8 s");
    check_kept(&bench, PLOT_POSITION);
    bench_close(&bench);
}

/* `export FILE v --band` writes the band of a fitted run as two more columns, low and high, at the
 * distance from v that the plot shows. */
TEST(test_file_has_the_band)
{
    struct bench bench;
    struct arena arena = {0};
    struct figure figure;
    bench_open(&bench, false);
    record("damped.csv", 0.2, 0, 0, 2e-3, 1);
    type_ok(&bench, "m = 200 g; method rk4 dt=20ms; load damped.csv; fit; adopt; run 8 s");
    draw_kind(&bench, PLOT_VELOCITY, false, &arena, &figure);
    type_ok(&bench, "export out.csv v --band --force");
    assert_says(&bench.out, "401 rows of t,v,v_low,v_high");
    char *text = file_text("out.csv"),
         *row = strstr(text, "\nt [s],v [m/s],v_low [m/s],v_high [m/s]\n");
    assert_non_null(row);
    row = strchr(row + 1, '\n') + 1;
    for (int i = 0; i < 401; i++, row = strchr(row, '\n') + 1) {
        double t, v, low, high;
        assert_int_equal(sscanf(row, "%lf,%lf,%lf,%lf", &t, &v, &low, &high), 4);
        const double half = figure.curve[0].spread[i];
        assert_true(fabs(v - low - half) < 1e-12 && fabs(high - v - half) < 1e-12);
    }
    free(text);
    arena_reset(&arena);
    type_ok(&bench, "plan");
    assert_says(
        &bench.out,
        "band      95 % band of the adopted fit, only on request (--band, 'set band on'): 8 "
        "variational equations beside the 2 of the motion, once, to 1e-10");
    refused(&bench, "export - energy --band", "--band needs a column that is a state variable");
    refused(&bench, "export - data --band", "--band works only with columns of a run");
    type_ok(&bench, "y0 = 3 cm; plan");
    assert_null(strstr(said(&bench.out), "band      "));
    type_ok(&bench, "run 1 s");
    refused(&bench, "export - y --band", "y0 is 3 cm in run 2, and ");
    refused(&bench, "export - run all --band", "--band needs one run");
    bench_close(&bench);
}

RUN_TESTS(enter_folder, leave_folder)
