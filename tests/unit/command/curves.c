/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Curves of very different size in one figure: each is drawn over all of its time, or the frame
 * says where it leaves. */
#include "cmocka_testing.h"

#include <hooke/language.h>
#include <hooke/plot.h>
#include "modules/pictures/svg_testing.h"
#include "unit/command/testing.h"

#define EDGE 0.0111 /* [axis lengths] that a curve may stick out without a word */

static const enum plot_kind kinds[] = {PLOT_ENERGY, PLOT_POSITION, PLOT_VELOCITY, PLOT_PHASE};

/* What was found of all curves of a figure. */
struct seen {
    size_t outside, blank; /* samples beyond the axes; inside, but without ink */
    int drawn;             /* curves that are in some panel */
    int panels;
    bool log;
    bool said; /* the frame says that something leaves */
};

/* There or in a cell beside it: a line between samples takes the dots that it passes, not those
 * nearest to them. */
static bool is_ink(const struct canvas *canvas, int x, int y)
{
    for (int i = 0; i < 9; i++) {
        const struct cell *cell = &canvas->cell[(y + i / 3 - 1) * canvas->width + x + i % 3 - 1];
        if (cell->codepoint != ' ' && (cell->style >= STYLE_CURVE_1 || cell->style == STYLE_BOLD))
            return true;
    }
    return false;
}

static void look_at_panel(const struct figure_panel *panel, const struct canvas *canvas,
                          const struct charset *charset, struct seen *seen)
{
    const struct figure *figure = &panel->figure;
    struct figure_layout layout;
    figure_layout(figure, panel->width, panel->height, charset, &layout);
    seen->log |= layout.y.log;
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        if (figure->part && curve->panel != figure->panel)
            continue;
        seen->drawn++;
        for (size_t i = 0; i < curve->n; i++) {
            const double x = scale_fraction(&layout.x, curve->x[i]),
                         y = scale_fraction(&layout.y, curve->y[i]);
            int column, row;
            if (!(x >= -EDGE && x <= 1 + EDGE && y >= -EDGE && y <= 1 + EDGE))
                seen->outside++;
            else if (figure_cell(&layout, curve->x[i], curve->y[i], &column, &row))
                seen->blank +=
                    !is_ink(canvas, panel->x + layout.left + column, panel->y + layout.top + row);
        }
    }
}

static struct seen look_at(const struct figure *figure, int width, int height,
                           const struct charset *charset)
{
    struct seen seen = {0};
    struct figure_panel panel[PANELS_MAX];
    struct canvas canvas;
    struct buffer text = {0};
    assert_true(canvas_init(&canvas, width, height));
    assert_true(figure_draw(figure, &canvas, 0, 0, width, height, charset));
    seen.panels = figure_panels(figure, width, height, charset, panel);
    for (int i = 0; i < seen.panels; i++)
        look_at_panel(&panel[i], &canvas, charset, &seen);
    canvas_print(&canvas, false, &text);
    seen.said = strstr(said(&text), "leave") || strstr(said(&text), "outside");
    buffer_free(&text);
    canvas_free(&canvas);
    return seen;
}

static struct figure figure_of(struct bench *bench, enum plot_kind kind,
                               const struct charset *charset, int width,
                               const struct figure_range *y, struct arena *arena)
{
    static const int runs[] = {0, 1, 2, 3};
    struct figure figure;
    struct error error = {0};
    const struct figure_request request = {.kind = kind,
                                           .run = runs,
                                           .runs = bench->session->runs.count,
                                           .recording = -1,
                                           .window = {0, NAN},
                                           .width = width,
                                           .charset = charset,
                                           .trail = HUGE_VAL,
                                           .y = y};
    if (!session_figure(bench->session, &request, arena, &figure, &error))
        fail_msg("%s", error.text);
    return figure;
}

static const char *const setups[] = {
    "method euler; run 10 s; method symplectic-euler; run 10 s",
    "method symplectic-euler; run 10 s; method euler; run 10 s; method backward-euler; run 10 s",
    "method rk4; run 10 s; y0 = 3 m; run 10 s",
    "gamma = 0.4; method euler dt=30ms; run 20 s; method verlet; run 5 s",
    "scene pendulum; method euler; run 30 s; method verlet; run 30 s",
};

/* Every sample of every curve has its place in the figure, and ink. */
TEST(curves_of_different_size_are_whole)
{
    static const int sizes[][2] = {{80, 24}, {40, 12}, {100, 30}, {120, 16}, {51, 15}};
    static const struct charset *const charsets[] = {&charset_ascii, &charset_block,
                                                     &charset_braille};
    (void)state;
    for (size_t s = 0; s < COUNT_OF(setups); s++) {
        struct bench bench;
        bench_open(&bench, false);
        type_ok(&bench, setups[s]);
        for (size_t k = 0; k < COUNT_OF(kinds) * COUNT_OF(sizes) * 3; k++) {
            const enum plot_kind kind = kinds[k % COUNT_OF(kinds)];
            const int *size = sizes[k / COUNT_OF(kinds) % COUNT_OF(sizes)];
            const struct charset *charset = charsets[k / COUNT_OF(kinds) / COUNT_OF(sizes)];
            struct arena arena = {0};
            const struct figure figure = figure_of(&bench, kind, charset, size[0], NULL, &arena);
            const struct seen seen = look_at(&figure, size[0], size[1], charset);
            if (seen.outside || seen.blank || seen.said || seen.drawn != figure.curves ||
                (seen.panels < 2 && !seen.log && s < 3))
                fail_msg("%s: kind %d, %dx%d: %zu samples outside, %zu without ink, %d of %d "
                         "curves, %d panels",
                         setups[s], kind, size[0], size[1], seen.outside, seen.blank, seen.drawn,
                         figure.curves, seen.panels);
            arena_reset(&arena);
        }
        bench_close(&bench);
    }
}

/* On an axis that was asked for, a curve that leaves is named. */
TEST(what_leaves_is_said)
{
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, setups[0]);
    for (int i = 0; i < 60; i++) {
        const enum plot_kind kind = kinds[i % 4];
        const double top = pow(10, -2.5 + 0.1 * i);
        const struct figure_range range = {.end = {-top, top}, .quantity = QUANTITY_OTHER};
        struct arena arena = {0};
        const struct figure figure = figure_of(&bench, kind, &charset_ascii, 80, &range, &arena);
        const struct seen seen = look_at(&figure, 80, 24, &charset_ascii);
        if (seen.panels != 1 || seen.log || seen.said != (seen.outside > 0))
            fail_msg("kind %d up to %g: %zu samples outside, said: %d", kind, top, seen.outside,
                     seen.said);
        arena_reset(&arena);
    }
    bench_close(&bench);
}

/* ---- pictures ---- */

struct extent {
    double left, right, top, bottom; /* [pt] */
};

/* What the longest path of a color covers in an SVG file. */
static struct extent longest_path(const char *svg, const char *color)
{
    static struct svg_path path;
    struct svg_element element;
    struct extent longest = {0};
    for (const char *at = NULL; svg_next(svg, &at, &element, &path);) {
        struct extent all = {1e9, -1e9, 1e9, -1e9};
        if (element.is_text || strcmp(element.stroke, color) != 0 || path.circles > 0)
            continue;
        for (int i = 0; i < path.n; i++)
            all = (struct extent){fmin(all.left, path.x[i]), fmax(all.right, path.x[i]),
                                  fmin(all.top, path.y[i]), fmax(all.bottom, path.y[i])};
        if (all.right - all.left > longest.right - longest.left)
            longest = all;
    }
    return longest;
}

TEST(both_are_whole_in_pictures)
{
    static const char *const colors[] = {"#0072b2", "#1a1a1a"};
    (void)state;
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, setups[0]);
    for (size_t k = 0; k < COUNT_OF(kinds); k++) {
        char line[100];
        snprintf(line, sizeof line, "plot %s run 1 2 > figure-%zu.svg",
                 catalog_row(&plot_catalog, kinds[k])->name, k);
        if (!type(&bench, line) && strstr(said(&bench.err), "cairo")) {
            bench_close(&bench);
            skip(); /* built, or running, without it */
        }
        char name[40], *svg = NULL;
        snprintf(name, sizeof name, "figure-%zu.svg", k);
        FILE *file = fopen(name, "rb");
        size_t size = 0;
        assert_non_null(file);
        assert_true(getdelim(&svg, &size, '\0', file) > 0);
        assert_int_equal(fclose(file), 0);
        for (int c = 0; c < 2; c++) {
            const struct extent path = longest_path(svg, colors[c]);
            const bool plane = kinds[k] == PLOT_PHASE;
            const double wide = path.right - path.left, high = path.bottom - path.top;
            /* Of 640 x 400: two planes share the width, two panels the height; energy swings by 4 %
             * on its axis. */
            if (wide < (plane ? 200 : 550) ||
                high < (plane                     ? 200
                        : kinds[k] == PLOT_ENERGY ? 3
                                                  : 100) ||
                path.left < 0 || path.right > 640 || path.top < 0 || path.bottom > 400)
                fail_msg("%s: curve %d is %.0f x %.0f pt, from %.0f, %.0f", line, c + 1, wide, high,
                         path.left, path.top);
        }
        free(svg);
    }
    bench_close(&bench);
}

/* The energy of rk4 drifts by far less than 0.1 % of its value. Without a range (asked = 0) its
 * curve is a flat line on an axis that contains 0; with a range of its own width (asked = 1) the
 * curve crosses most of the axis, whose ticks are then relative to an offset. */
TEST(a_small_drift_is_not_drawn_from_top_to_bottom)
{
    static const struct figure_range narrow = {.end = {NAN, NAN}, .quantity = QUANTITY_OTHER};
    (void)state;
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "method rk4; run 10 s");
    for (int asked = 0; asked < 2; asked++) {
        struct arena arena = {0};
        const struct figure figure =
            figure_of(&bench, PLOT_ENERGY, &charset_braille, 80, asked ? &narrow : NULL, &arena);
        struct figure_layout layout;
        figure_layout(&figure, 80, 24, &charset_braille, &layout);
        const struct curve *curve = &figure.curve[0];
        const double from = scale_fraction(&layout.y, curve->y[0]),
                     to = scale_fraction(&layout.y, curve->y[curve->n - 1]);
        if (asked)
            assert_true(fabs(from - to) > 0.7 && layout.y_ticks.offset > 0);
        else
            assert_true(fabs(from - to) < 0.001 && layout.y.first_value <= 0 &&
                        layout.y_ticks.offset == 0);
        arena_reset(&arena);
    }
    bench_close(&bench);
}

/* Whether a curve holds a point at t that is at y to within a part of its size; of those there are
 * the nearest. */
static void assert_passes(const struct curve *curve, double t, double y, double within)
{
    size_t nearest = 0;
    for (size_t i = 1; i < curve->n; i++)
        if (fabs(curve->x[i] - t) < fabs(curve->x[nearest] - t))
            nearest = i;
    if (fabs(curve->x[nearest] - t) > 0.02 || fabs(curve->y[nearest] - y) > within)
        fail_msg("nearest to %g s: %g at %g s, not %g", t, curve->y[nearest], curve->x[nearest], y);
}

/* A ball that bounces moves along parabolas, and a spring that was changed on the way along the
 * sines of both. */
TEST(adaptive_runs_are_smooth_between_jumps)
{
    struct bench bench;
    struct arena arena = {0};
    bench_open(&bench, false);
    type_ok(&bench,
            "scene new; var y = 1 m; param r = 0.8; y'' = -9.81; "
            "event bounce when y falling do \"y' = -r*y'; continue\"; method dop853; run 1.1 s");
    struct figure figure = figure_of(&bench, PLOT_POSITION, &charset_braille, 80, NULL, &arena);
    const double fall = sqrt(2 / 9.81), speed = 0.8 * 9.81 * fall;
    for (double t = 0; t < 1.1; t += 0.05) { /* 0.02 s at 5 m/s */
        const double later = t - fall,
                     y = later < 0 ? 1 - 4.905 * t * t : speed * later - 4.905 * later * later;
        assert_passes(&figure.curve[0], t, y, 0.1);
    }
    /* the top, where no step ends */
    assert_passes(&figure.curve[0], fall + speed / 9.81, 0.64, 0.005);
    bench_close(&bench);
    bench_open(&bench, false);
    type_ok(&bench,
            "m = 1 kg; k = 1 N/m; y0 = 1 m; method dop853; run 1 s; change k 0; continue 1 s");
    figure = figure_of(&bench, PLOT_POSITION, &charset_braille, 80, NULL, &arena);
    for (double t = 0; t < 2; t += 0.1)
        assert_passes(&figure.curve[0], t, t < 1 ? cos(t) : cos(1) - sin(1) * (t - 1), 0.02);
    arena_reset(&arena);
    bench_close(&bench);
}

TEST(logarithmic_errors_are_sizes)
{
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "method rk4; run 10 s; plot error --log");
    assert_non_null(strstr(said(&bench.out), "|error| ["));
    assert_null(strstr(said(&bench.out), "493 values"));
    bench_close(&bench);
}

RUN_TESTS(enter_folder, leave_folder)
