/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Pictures of studies. Boundaries of stability are those of closed forms; and what stands in a
 * study's table stands in its figure where the numbers beside the ticks put it, on screens and in
 * files, and nothing else does.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "unit/axes_testing.h"
#include "unit/command/testing.h"
#include "modules/pictures/svg_testing.h"
#include <hooke/base/file.h>
#include <hooke/plot/drawing.h>

#include <complex.h>

#define RK4_REAL 2.785293563405282 /* Hairer and Wanner (1996), IV.2 */
#define RK4_IMAGINARY 2.8284271247461903

/* ---- tables ---- */

static const struct table_column *column_of(const struct table *table, const char *name)
{
    for (int c = 0; c < table->columns; c++)
        if (strcmp(table->column[c].name, name) == 0)
            return &table->column[c];
    fail_msg("there is no column %s", name);
    return NULL;
}

struct points {
    const char *const *part, *const *curve;
    const double *x, *y;
    size_t rows;
};

static struct points points_of(const struct bench *bench, const char *kind, const char *x,
                               const char *y)
{
    const struct table *table = drawing_stored(bench->session, kind);
    assert_non_null(table);
    return (struct points){column_of(table, "part")->text, column_of(table, "curve")->text,
                           column_of(table, x)->value, column_of(table, y)->value, table->rows};
}

static bool is_of(const struct points *p, size_t i, const char *curve)
{
    return strcmp(p->curve[i], curve) == 0 && strcmp(p->part[i], "boundary") == 0 &&
           isfinite(p->x[i]);
}

/* ---- closed forms ---- */

static double complex of_euler(double complex z)
{
    return 1 + z;
}

static double complex of_heun(double complex z)
{
    return 1 + z + z * z / 2;
}

static double complex of_rk4(double complex z)
{
    return 1 + z + z * z / 2 + z * z * z / 6 + z * z * z * z / 24;
}

static double complex of_backward(double complex z)
{
    return 1 / (1 - z);
}

static double complex of_trapezoid(double complex z)
{
    return (1 + z / 2) / (1 - z / 2);
}

/* Padé (2, 3) of the exponential. */
static double complex of_radau5(double complex z)
{
    return (1 + 2 * z / 5 + z * z / 20) / (1 - 3 * z / 5 + 3 * z * z / 20 - z * z * z / 60);
}

static const struct {
    const char *method;
    double complex (*growth)(double complex z);
} forms[] = {{"euler", of_euler},
             {"heun", of_heun},
             {"rk4", of_rk4},
             {"backward-euler", of_backward},
             {"trapezoid", of_trapezoid},
             {"radau5", of_radau5}};

static void test_boundaries_are_those_of_closed_forms(void **state)
{
    (void)state;
    for (int star = 0; star < 2; star++) {
        struct bench bench;
        bench_open(&bench, false);
        type_ok(&bench, star ? "plot stars euler heun rk4 backward-euler trapezoid radau5"
                             : "plot stability euler heun rk4 backward-euler trapezoid radau5");
        const struct points p = points_of(&bench, star ? "star-boundary" : "boundary", "re", "im");
        for (size_t f = 0; f < COUNT_OF(forms); f++) {
            int found = 0;
            for (size_t i = 0; i < p.rows; i++) {
                if (!is_of(&p, i, forms[f].method))
                    continue;
                const double complex z = CMPLX(p.x[i], p.y[i]);
                const double growth = cabs(forms[f].growth(z)) * (star ? exp(-p.x[i]) : 1);
                if (fabs(growth - 1) > 1e-6)
                    fail_msg("%s: growth %.9g at %g %+g i", forms[f].method, growth, p.x[i],
                             p.y[i]);
                found++;
            }
            if (found < 40)
                fail_msg("%s has a boundary of %d points", forms[f].method, found);
        }
        bench_close(&bench);
    }
}

/* The ends of the interval of stability on both axes. */
static void test_boundary_of_rk4_meets_the_axes_at_its_limits(void **state)
{
    (void)state;
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "m = 1 kg; k = 4 N/m; plot stability rk4 verlet");
    const struct points p = points_of(&bench, "boundary", "re", "im");
    double real = NAN, imaginary = 0, verlet = 0, marks[2] = {0, 0};
    for (size_t i = 0; i < p.rows; i++) {
        if (is_of(&p, i, "rk4") && p.y[i] == 0 && p.x[i] < -1)
            real = -p.x[i];
        if (is_of(&p, i, "rk4") && i > 0 && p.x[i] * p.x[i - 1] <= 0 && p.y[i] > 2)
            imaginary = p.y[i] + (p.y[i - 1] - p.y[i]) * p.x[i] / (p.x[i] - p.x[i - 1]);
        if (is_of(&p, i, "verlet"))
            verlet = fmax(verlet, hypot(p.x[i], p.y[i]));
        if (strcmp(p.part[i], "limit") == 0 && p.y[i] > 0)
            marks[p.y[i] < 2.5] = p.y[i];
    }
    assert_float_equal(real, RK4_REAL, 1e-6);
    assert_float_equal(imaginary, RK4_IMAGINARY, 1e-3);
    assert_float_equal(verlet, 2, 1e-3);
    assert_float_equal(marks[0], RK4_IMAGINARY, 1e-9);
    assert_float_equal(marks[1], 2, 1e-9);
    bench_close(&bench);
}

static void test_regions_of_damped_oscillators_are_those_of_closed_forms(void **state)
{
    (void)state;
    struct bench bench;
    int count[3] = {0};
    bench_open(&bench, false);
    type_ok(&bench, "scene damped; m = 1 kg; k = 4 N/m; gamma = 1.2 1/s; dt = 0.25 s");
    type_ok(&bench, "plot region euler verlet rk4");
    const struct points p = points_of(&bench, "region-boundary", "zeta", "omega_dt");
    for (size_t i = 0; i < p.rows; i++) {
        const double zeta = p.x[i], over = sqrt(fmax(0, zeta * zeta - 1));
        /* Of two real eigenvalues the larger one decides. */
        const double fast = zeta + over;
        if (is_of(&p, i, "euler")) {
            const double expected = zeta < 1 ? 2 * zeta : 2 / fast;
            if (fabs(zeta - 1) > 1e-3 && p.y[i] > 0.05)
                assert_float_equal(p.y[i], expected, 1e-6);
            count[0]++;
        } else if (is_of(&p, i, "verlet")) {
            assert_float_equal(p.y[i], 2, 1e-6);
            count[1]++;
        } else if (is_of(&p, i, "rk4")) {
            const double complex z =
                p.y[i] * (zeta < 1 ? CMPLX(-zeta, sqrt(1 - zeta * zeta)) : -fast);
            if (fabs(zeta - 1) > 1e-3)
                assert_float_equal(cabs(of_rk4(z)), 1, 1e-6);
            count[2]++;
        } else if (strcmp(p.part[i], "scene") == 0) {
            assert_float_equal(p.x[i], 0.3, 1e-12);
            assert_float_equal(p.y[i], 0.5, 1e-12);
        }
    }
    for (int i = 0; i < 3; i++)
        assert_in_range(count[i], 40, 1000);
    bench_close(&bench);
}

/* The line of each order has the slope that the study reports, and passes near its points. */
static void test_lines_of_orders_have_their_slopes(void **state)
{
    (void)state;
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "duration = 3 s; plot order euler verlet rk4");
    const struct table *table = drawing_stored(bench.session, "order");
    assert_non_null(table);
    const struct table_column *dt = column_of(table, "dt"), *line = column_of(table, "line"),
                              *error = column_of(table, "error"),
                              *order = column_of(table, "order");
    int pairs = 0;
    for (size_t i = 1; i < table->rows; i++) {
        if (!isfinite(line->value[i]) || !isfinite(line->value[i - 1]))
            continue;
        const double slope =
            log(line->value[i] / line->value[i - 1]) / log(dt->value[i] / dt->value[i - 1]);
        assert_float_equal(slope, order->value[i], 1e-9);
        assert_float_equal(slope, round(slope), 0.1);
        assert_float_equal(log(line->value[i] / error->value[i]), 0, 0.1);
        pairs++;
    }
    assert_in_range(pairs, 6, 100);
    bench_close(&bench);
}

/* With steps as long as those of the grid, the errors of both methods on the undamped spring have a
 * closed form: verlet turns by the angle whose cosine is 1 - x^2/2 in each step, euler by i x. */
static void test_errors_along_the_run_are_those_of_closed_forms(void **state)
{
    (void)state;
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "m = 1 kg; k = 4 N/m; y0 = 1 m; dt = 10 ms; duration = 2.56 s");
    type_ok(&bench, "plot compare euler verlet");
    const struct table *table = drawing_stored(bench.session, "errors");
    assert_non_null(table);
    const double x = 0.02;
    int found = 0;
    for (size_t i = 0; i < table->rows; i++) {
        const double t = column_of(table, "t")->value[i], n = round(t / 0.01),
                     error = column_of(table, "error")->value[i], exact = cos(x * n);
        const bool euler = strcmp(column_of(table, "method")->text[i], "euler") == 0;
        const double wanted = euler ? creal(cpow(CMPLX(1, x), n)) : cos(n * acos(1 - x * x / 2));
        if (isnan(error)) {
            assert_float_equal(wanted, exact, 1e-14);
            continue;
        }
        assert_float_equal(error, fabs(wanted - exact), 1e-11);
        found++;
    }
    assert_in_range(found, 500, 512);
    bench_close(&bench);
}

/* ---- where they stand in a file ---- */

#define PATHS 40
#define POINTS 4000

struct drawn {
    double left, right, top, bottom; /* [pt] the frame */
    struct read_axis x, y;
    struct {
        double x[POINTS], y[POINTS];
        bool joined[POINTS];
        int n;
        bool shapes; /* marks, whose middle is meant */
    } path[PATHS];
    int paths;
};

/* Reads curves, which come before the frame, then the ticks and their labels behind it. */
static void read_picture(const char *svg, struct drawn *drawn)
{
    static struct svg_path path;
    struct svg_element element;
    struct read_axis *tick = NULL;
    double place = 0;
    bool framed = false;
    *drawn = (struct drawn){.x = {.unit = 1}, .y = {.unit = 1}};
    for (const char *at = NULL; svg_next(svg, &at, &element, &path);) {
        const bool black = strcmp(element.stroke, "#000000") == 0 && !element.filled;
        if (element.is_text) {
            if (tick && tick->n < TICKS_MAX) {
                tick->at[tick->n] = place;
                tick->value[tick->n++] = svg_value(element.text);
            }
            tick = NULL;
        } else if (!framed && black && path.n >= 4) {
            framed = true;
            drawn->left = path.x[0];
            drawn->right = path.x[1];
            drawn->top = path.y[0];
            drawn->bottom = path.y[2];
        } else if (framed && black && path.n == 2) {
            const bool vertical = path.y[0] == path.y[1];
            tick = hypot(path.x[1] - path.x[0], path.y[1] - path.y[0]) < 3 ? NULL
                   : vertical                                              ? &drawn->y
                                                                           : &drawn->x;
            place = vertical ? path.y[0] : path.x[0];
        } else if (!framed && element.stroke[0] == '#' && strcmp(element.stroke, "#595959") != 0 &&
                   strcmp(element.stroke, "#ffffff") != 0) {
            assert_in_range(drawn->paths, 0, PATHS - 1);
            assert_in_range(path.n, 0, POINTS - 1);
            for (int i = 0; i < path.n; i++) {
                drawn->path[drawn->paths].x[i] = path.x[i];
                drawn->path[drawn->paths].y[i] = path.y[i];
                drawn->path[drawn->paths].joined[i] = path.joined[i];
            }
            drawn->path[drawn->paths].n = path.n;
            drawn->path[drawn->paths++].shapes = path.closed || path.circles > 0;
        }
    }
    assert_true(framed);
}

static double distance_to_segment(const double at[2], const double a[2], const double b[2])
{
    const double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    const double part =
        square > 0 ? fmin(1, fmax(0, ((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / square)) : 0;
    return hypot(at[0] - a[0] - part * dx, at[1] - a[1] - part * dy);
}

/* Returns how far a place is from the nearest ink; of marks any corner counts. */
static double distance_to_ink(const struct drawn *drawn, const double at[2], bool line)
{
    double min = HUGE_VAL;
    for (int p = 0; p < drawn->paths; p++)
        for (int i = 0; i < drawn->path[p].n; i++) {
            const double to[2] = {drawn->path[p].x[i], drawn->path[p].y[i]};
            const int before = line && drawn->path[p].joined[i] ? i - 1 : i;
            const double from[2] = {drawn->path[p].x[before], drawn->path[p].y[before]};
            if (!line || !drawn->path[p].shapes)
                min = fmin(min, distance_to_segment(at, from, to));
        }
    return min;
}

/* Returns how far a place is from the curves of the figure, where the axes put them. */
static double distance_to_figure(const struct drawn *drawn, const struct figure *figure,
                                 const double at[2])
{
    double min = HUGE_VAL, reach;
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        double before[2] = {NAN, NAN};
        for (size_t i = 0; i < curve->n; i++) {
            const double spot[2] = {read_place(&drawn->x, curve->x[i], &reach),
                                    read_place(&drawn->y, curve->y[i], &reach)};
            const bool joined = !curve->points && isfinite(before[0] + before[1]);
            if (isfinite(spot[0] + spot[1]))
                min = fmin(min, distance_to_segment(at, joined ? before : spot, spot));
            memcpy(before, spot, sizeof before);
        }
    }
    return min;
}

static void check_picture(const char *line, const struct figure *figure, struct drawn *drawn)
{
    enum { MARK = 6 /* [pt] what a corner of a mark is from its middle, at most */ };
    static const double ink = 0.3; /* [pt] */
    double reach;
    int seen = 0;
    drawn->x.unit = axis_unit(&figure->x);
    drawn->y.unit = axis_unit(&figure->y);
    drawn->x.log = figure->x.log;
    drawn->y.log = figure->y.log;
    assert_in_range(drawn->x.n, 2, TICKS_MAX);
    assert_in_range(drawn->y.n, 2, TICKS_MAX);
    assert_true(read_axis_is_even(&drawn->x, 0.02) && read_axis_is_even(&drawn->y, 0.02));
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        for (size_t i = 0; i < curve->n; i++) {
            const double spot[2] = {read_place(&drawn->x, curve->x[i], &reach),
                                    read_place(&drawn->y, curve->y[i], &reach)};
            if (!(spot[0] >= drawn->left && spot[0] <= drawn->right && spot[1] >= drawn->top &&
                  spot[1] <= drawn->bottom))
                continue;
            seen++;
            const double off = distance_to_ink(drawn, spot, !curve->points);
            if (off > (curve->points ? MARK : ink))
                fail_msg("%s: nothing at %g, %g, the next ink is %.2f pt away", line, curve->x[i],
                         curve->y[i], off);
        }
    }
    for (int p = 0; p < drawn->paths; p++)
        for (int i = 0; i < drawn->path[p].n; i++) {
            const double at[2] = {drawn->path[p].x[i], drawn->path[p].y[i]};
            const double off = distance_to_figure(drawn, figure, at);
            if (off > (drawn->path[p].shapes ? MARK : ink))
                fail_msg("%s: ink at %.2f, %.2f pt, %.2f pt from any curve", line, at[0], at[1],
                         off);
        }
    assert_in_range(seen, 8, 100000);
}

static const char *const plots[] = {
    "order euler verlet rk4",        "compare euler verlet rk4", "stability rk4 euler heun verlet",
    "stability backward-euler bdf2", "stars rk4 gauss4",         "region verlet rk4 euler",
};

static void make_figure_of(struct bench *bench, const char *line, int width, struct arena *arena,
                           struct figure *figure)
{
    const size_t len = strcspn(line, " ");
    struct figure_request request = {.recording = -1, .window = {NAN, NAN}, .width = width};
    struct error error = {0};
    const struct row *row = catalog_find(&plot_catalog, (struct text){line, len});
    assert_non_null(row);
    request.kind = (enum plot_kind)catalog_index(&plot_catalog, row);
    request.charset = &charset_braille;
    if (!session_figure(bench->session, &request, arena, figure, &error))
        fail_msg("%s: %s", line, error.text);
}

static void test_pictures_are_where_their_axes_put_them(void **state)
{
    (void)state;
    static struct drawn drawn;
    for (size_t i = 0; i < COUNT_OF(plots); i++) {
        struct bench bench;
        struct arena arena = {0};
        struct figure figure;
        struct buffer svg = {0};
        struct error error;
        char line[200];
        bench_open(&bench, false);
        type_ok(&bench, "duration = 2 s; scene damped; gamma = 2 1/s; dt = 0.1 s");
        snprintf(line, sizeof line, "plot %s > figure.svg --force", plots[i]);
        type_ok(&bench, line);
        assert_true(file_read("figure.svg", 1 << 24, &svg, &error));
        read_picture(buffer_view(&svg), &drawn);
        make_figure_of(&bench, plots[i], 80, &arena, &figure);
        check_picture(plots[i], &figure, &drawn);
        buffer_free(&svg);
        arena_reset(&arena);
        bench_close(&bench);
    }
}

/* ---- where they stand on a screen ---- */

static void check_cells(const char *line, const struct figure *figure, int width, int height,
                        const struct charset *charset)
{
    struct canvas canvas;
    char problem[200];
    assert_true(canvas_init(&canvas, width, height));
    assert_true(figure_draw(figure, &canvas, 0, 0, width, height, charset));
    struct reader reader = {
        .canvas = &canvas, .right = width - 1, .bottom = height - 1, .axis_row = height - 3};
    assert_true(read_x_axis(&reader, axis_unit(&figure->x)));
    assert_true(read_y_axis(&reader, axis_unit(&figure->y), figure->y.log));
    reader.x.log = figure->x.log;
    if (!reader_agrees(&reader, figure, problem))
        fail_msg("%s, %dx%d: %s", line, width, height, problem);
    canvas_free(&canvas);
}

static void test_screens_are_where_their_axes_put_them(void **state)
{
    (void)state;
    static const int size[][2] = {{80, 24}, {40, 12}, {120, 40}};
    for (size_t i = 0; i < COUNT_OF(plots); i++) {
        struct bench bench;
        char line[200];
        bench_open(&bench, false);
        type_ok(&bench, "duration = 2 s; scene damped; gamma = 2 1/s; dt = 0.1 s");
        snprintf(line, sizeof line, "plot %s", plots[i]);
        type_ok(&bench, line);
        for (size_t k = 0; k < 2 * COUNT_OF(size); k++) {
            struct arena arena = {0};
            struct figure figure;
            const int *of = size[k / 2];
            make_figure_of(&bench, plots[i], of[0], &arena, &figure);
            check_cells(plots[i], &figure, of[0], of[1], k % 2 ? &charset_ascii : &charset_braille);
            arena_reset(&arena);
        }
        bench_close(&bench);
    }
}

static void count_offer(void *context, const char *candidate, const char *brief)
{
    int *const count = context;
    (void)brief;
    count[0]++;
    count[1] += method_by_name(text_of(candidate)) != NULL;
}

/* Behind the name of a study's plot stand methods, and nothing else; elsewhere none. */
static void test_methods_are_offered_behind_plots_of_studies(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        bool methods;
    } lines[] = {{"plot order ", true},
                 {"plot stability euler rk", true},
                 {"describe region ", true},
                 {"plot position ", false},
                 {"plot order --", false}};
    struct bench bench;
    bench_open(&bench, false);
    for (size_t i = 0; i < COUNT_OF(lines); i++) {
        int count[2] = {0, 0};
        size_t start;
        const struct text line = text_of(lines[i].line);
        command_complete(bench.session, line, line.len, &start, count_offer, count);
        if (count[0] == 0 || (lines[i].methods ? count[1] != count[0] : count[1] > 1))
            fail_msg("'%s': %d words, %d methods", lines[i].line, count[0], count[1]);
    }
    bench_close(&bench);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boundaries_are_those_of_closed_forms),
        cmocka_unit_test(test_boundary_of_rk4_meets_the_axes_at_its_limits),
        cmocka_unit_test(test_regions_of_damped_oscillators_are_those_of_closed_forms),
        cmocka_unit_test(test_lines_of_orders_have_their_slopes),
        cmocka_unit_test(test_errors_along_the_run_are_those_of_closed_forms),
        cmocka_unit_test(test_methods_are_offered_behind_plots_of_studies),
        cmocka_unit_test(test_pictures_are_where_their_axes_put_them),
        cmocka_unit_test(test_screens_are_where_their_axes_put_them),
    };
    return cmocka_run_group_tests(tests, axes_folder_enter, axes_folder_leave);
}
