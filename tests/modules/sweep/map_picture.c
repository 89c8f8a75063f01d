/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Maps of sweeps in files and on screens: at each place, found by the numbers beside the ticks, is
 * the colour that the bar has at the height of its value, or the shade of the scale.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "unit/axes_testing.h"
#include "unit/command/testing.h"
#include "modules/pictures/svg_testing.h"
#include "modules/sweep/swept.h"
#include <hooke/base/file.h>
#include <hooke/plot/drawing.h>

#define BOXES 20000

struct box {
    double left, top, right, bottom;
    unsigned color;
};

struct sheet {
    struct box box[BOXES];
    int boxes;
    double middle; /* [pt] of the bar */
    struct read_axis x, y, bar;
};

static void add_boxes(struct sheet *sheet, const struct svg_path *path, unsigned color)
{
    for (int i = 0; i + 3 < path->n; i++) {
        if (path->joined[i] || !path->joined[i + 1] || !path->joined[i + 2] || !path->joined[i + 3])
            continue;
        assert_in_range(sheet->boxes, 0, BOXES - 1);
        struct box *box = &sheet->box[sheet->boxes++];
        *box = (struct box){HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL, color};
        for (int k = i; k < i + 4; k++) {
            box->left = fmin(box->left, path->x[k]);
            box->right = fmax(box->right, path->x[k]);
            box->top = fmin(box->top, path->y[k]);
            box->bottom = fmax(box->bottom, path->y[k]);
        }
    }
}

static void read_sheet(const char *svg, struct sheet *sheet)
{
    static struct svg_path path;
    struct svg_element element;
    struct read_axis *tick = NULL;
    double place = 0;
    int frames = 0;
    *sheet = (struct sheet){.x = {.unit = 1}, .y = {.unit = 1}, .bar = {.unit = 1}};
    for (const char *at = NULL; svg_next(svg, &at, &element, &path);) {
        if (element.is_text) {
            if (tick && tick->n < TICKS_MAX) {
                tick->at[tick->n] = place;
                tick->value[tick->n++] = svg_value(element.text);
            }
            tick = NULL;
        } else if (element.filled) {
            add_boxes(sheet, &path, (unsigned)strtoul(element.stroke + 1, NULL, 16));
        } else if (strcmp(element.stroke, "#000000") == 0 && path.n >= 4) {
            sheet->middle = (path.x[0] + path.x[1]) / 2;
            frames++;
        } else if (strcmp(element.stroke, "#000000") == 0 && path.n == 2) {
            const bool level = path.y[0] == path.y[1];
            tick = hypot(path.x[1] - path.x[0], path.y[1] - path.y[0]) < 3 ? NULL
                   : !level                                                ? &sheet->x
                   : frames > 1                                            ? &sheet->bar
                                                                           : &sheet->y;
            place = level ? path.y[0] : path.x[0];
        }
    }
    assert_int_equal(frames, 2);
}

/* Returns the colour at a place, the last that was drawn there. */
static unsigned color_at(const struct sheet *sheet, double x, double y)
{
    for (int i = sheet->boxes - 1; i >= 0; i--)
        if (x > sheet->box[i].left && x < sheet->box[i].right && y > sheet->box[i].top &&
            y < sheet->box[i].bottom)
            return sheet->box[i].color;
    return 0;
}

static const struct table_column *column_of(const struct bench *bench, int i)
{
    const struct table *table = drawing_stored(bench->session, "sweep");
    assert_non_null(table);
    return &table->column[i];
}

static const char *const sweeps[] = {
    "scene damped; sweep k=10:20:1 gamma=0.5:2:0.25 measure=period",
    "scene damped; sweep k=5:45:x1.3 gamma=0.5:2:0.3 measure=max",
    "scene driven; method verlet; sweep omega=6:12:0.5 gamma=0.02:3:x1.6",
};

static double color_distance(unsigned a, unsigned b)
{
    double square = 0;
    for (int shift = 0; shift < 24; shift += 8) {
        const double d = (double)(a >> shift & 255) - (double)(b >> shift & 255);
        square += d * d;
    }
    return sqrt(square);
}

static void draw_figure(struct bench *bench, struct arena *arena, struct figure *figure)
{
    struct error error;
    const struct figure_request request = {
        .kind = (enum plot_kind)catalog_index(&plot_catalog,
                                              catalog_find(&plot_catalog, TEXT("sweep"))),
        .recording = -1,
        .window = {NAN, NAN},
        .width = 80,
        .charset = &charset_braille};
    assert_true(session_figure(bench->session, &request, arena, figure, &error));
    assert_non_null(figure->heat);
}

static void test_colours_are_those_of_the_bar(void **state)
{
    (void)state;
    static struct sheet sheet;
    /* Two levels of 64 apart: the rounding of a level on the map and on the bar. */
    static const double near = 22;
    for (size_t s = 0; s < COUNT_OF(sweeps); s++) {
        struct bench bench;
        struct arena arena = {0};
        struct figure figure;
        struct buffer svg = {0};
        struct error error;
        double reach;
        int seen = 0;
        bench_open(&bench, false);
        type_ok(&bench, sweeps[s]);
        type_ok(&bench, "plot sweep > figure.svg --force");
        assert_true(file_read("figure.svg", 1 << 24, &svg, &error));
        read_sheet(buffer_view(&svg), &sheet);
        const struct table_column *x = column_of(&bench, 1), *y = column_of(&bench, 2),
                                  *value = column_of(&bench, 3);
        const size_t rows = drawing_stored(bench.session, "sweep")->rows;
        draw_figure(&bench, &arena, &figure);
        sheet.x.unit = axis_unit(&figure.x);
        sheet.x.log = figure.x.log;
        sheet.y.unit = axis_unit(&figure.y);
        sheet.y.log = figure.y.log;
        sheet.bar.unit = figure.heat->factor > 0 ? figure.heat->factor : 1;
        sheet.bar.log = heat_scale_of(figure.heat).log;
        assert_int_equal(figure.x.log, s == 1);
        assert_int_equal(figure.y.log, s == 2);
        for (size_t i = 0; i < rows; i++) {
            const double px = read_place(&sheet.x, x->value[i], &reach),
                         py = read_place(&sheet.y, y->value[i], &reach);
            if (isnan(value->value[i]))
                continue;
            const double bar = read_place(&sheet.bar, value->value[i], &reach);
            const unsigned here = color_at(&sheet, px, py),
                           there = color_at(&sheet, sheet.middle, bar);
            if (there && color_distance(here, there) > near)
                fail_msg("%s: colour %06x at %g, %g, that of the bar at %g is %06x", sweeps[s],
                         here, x->value[i], y->value[i], value->value[i], there);
            seen += there != 0;
        }
        assert_in_range(seen, 20, 10000);
        arena_reset(&arena);
        buffer_free(&svg);
        bench_close(&bench);
    }
}

/* Each cell has the shade of the largest value of the places in it. */
static void test_shades_are_those_of_the_scale(void **state)
{
    (void)state;
    struct bench bench;
    struct arena arena = {0};
    struct figure figure;
    struct canvas canvas;
    double reach;
    bench_open(&bench, false);
    type_ok(&bench, sweeps[0]);
    draw_figure(&bench, &arena, &figure);
    assert_true(canvas_init(&canvas, 80, 24));
    assert_true(figure_draw(&figure, &canvas, 0, 0, 80, 24, &charset_ascii));
    struct reader reader = {.canvas = &canvas, .right = 79, .bottom = 23, .axis_row = 21};
    assert_true(read_x_axis(&reader, axis_unit(&figure.x)));
    assert_true(read_y_axis(&reader, axis_unit(&figure.y), figure.y.log));
    const struct heat *heat = figure.heat;
    const struct heat_scale scale = heat_scale_of(heat);
    for (int i = 0; i < heat->x.count; i++)
        for (int k = 0; k < heat->y.count; k++) {
            const int column = (int)lround(read_place(&reader.x, heat->x.value[i], &reach)),
                      row = (int)lround(read_place(&reader.y, heat->y.value[k], &reach));
            const double value = heat->value[i * heat->y.count + k];
            if (cell_at(&canvas, column, row) != heat_glyph(heat, &scale, &charset_ascii, value))
                fail_msg("column %d, row %d is '%c', value %g", column, row,
                         (int)cell_at(&canvas, column, row), value);
        }
    canvas_free(&canvas);
    arena_reset(&arena);
    bench_close(&bench);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colours_are_those_of_the_bar),
        cmocka_unit_test(test_shades_are_those_of_the_scale),
    };
    return cmocka_run_group_tests(tests, axes_folder_enter, axes_folder_leave);
}
