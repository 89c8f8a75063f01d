/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Figures as promises: no peak lost, circles round, labels apart, any size, any magnitude. */
#include "cmocka_testing.h"

#include <hooke/figure.h>

#include <math.h>
#include <stdlib.h>
#include "long_form.h"

#define PI 3.14159265358979323846
#define MANY 1000000

static const struct charset *const charsets[] = {&charset_ascii, &charset_block, &charset_braille};

static uint64_t random_state = 88172645463325252U;

static double uniform(void) /* [0, 1) xorshift64, Marsaglia 2003 */
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (double)(random_state >> 11) / 9007199254740992.0;
}

static bool dot_lit(const struct canvas *canvas, int column, int row)
{
    static const uint32_t bit[4][2] = {{0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}};
    const struct cell *cell = &canvas->cell[row / 4 * canvas->width + column / 2];
    return cell->codepoint > 0x2800 && cell->codepoint <= 0x28FF &&
           (cell->codepoint & bit[row % 4][column % 2]);
}

/* A figure on a canvas of its own, and where everything is. */
static void draw(const struct figure *figure, struct canvas *canvas, int width, int height,
                 const struct charset *charset, struct figure_layout *layout)
{
    assert_true(canvas_init(canvas, width, height));
    figure_layout(figure, width, height, charset, layout);
    assert_true(figure_draw(figure, canvas, 0, 0, width, height, charset));
}

TEST(test_spike_of_one_sample)
{
    static double x[MANY], y[MANY];
    struct curve curve = {.x = x, .y = y, .n = MANY};
    struct figure figure = {.x = {.label = "t"}, .y = {.label = "y"}, .curve = &curve, .curves = 1};
    (void)state;
    for (int i = 0; i < MANY; i++)
        x[i] = i;
    for (int trial = 0; trial < 30; trial++) {
        int at = (int)(uniform() * MANY), column, row;
        double peak = trial % 2 ? 1 : -1;
        struct figure_layout layout;
        struct canvas canvas;
        y[at] = peak;
        draw(&figure, &canvas, 80, 24, charsets[trial % 3], &layout);
        assert_true(figure_cell(&layout, x[at], y[at], &column, &row));
        const struct cell *cell = &canvas.cell[(layout.top + row) * 80 + layout.left + column];
        assert_int_not_equal(cell->codepoint, ' ');
        assert_int_equal(cell->style, STYLE_CURVE_1);
        canvas_free(&canvas);
        y[at] = 0;
    }
}

/* In every dot column the extremes of the samples are lit, to a dot. */
TEST(test_extremes_of_each_column)
{
    enum { N = 20000, ROWS = 23, COLUMNS = 40 };
    static double x[N], y[N];
    struct curve curve = {.x = x, .y = y, .n = N};
    struct figure figure = {.curve = &curve, .curves = 1};
    struct figure_layout layout;
    struct canvas canvas;
    (void)state;
    for (int i = 0; i < N; i++) {
        x[i] = i;
        y[i] = sin(i * 0.0007) + 0.3 * uniform();
    }
    draw(&figure, &canvas, COLUMNS, ROWS, &charset_braille, &layout);
    int across = 2 * layout.columns - 1, down = 4 * layout.rows - 1;
    double low[2 * COLUMNS], high[2 * COLUMNS];
    for (int c = 0; c <= across; c++) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
    }
    for (int i = 0; i < N; i++) {
        int c = (int)(scale_fraction(&layout.x, x[i]) * across + 0.5);
        double r = (1 - scale_fraction(&layout.y, y[i])) * down;
        low[c] = fmin(low[c], r);
        high[c] = fmax(high[c], r);
    }
    for (int c = 0; c <= across; c++) {
        int first = -1, last = -1;
        for (int r = 0; r <= down; r++) {
            if (dot_lit(&canvas, 2 * layout.left + c, 4 * layout.top + r)) {
                first = first < 0 ? r : first;
                last = r;
            }
        }
        if (first < 0 || fabs(first - low[c]) > 1 || fabs(last - high[c]) > 1)
            fail_msg("dot column %d: rows %d to %d drawn, samples from %.2f to %.2f", c, first,
                     last, low[c], high[c]);
    }
    canvas_free(&canvas);
}

/* Braille dots of a cell twice as high as wide are squares; other shapes through `aspect`. */
static void check_circle(int width, int height, double aspect, double factor, int n)
{
    static double x[2000], y[2000];
    struct curve curve = {.x = x, .y = y, .n = (size_t)n};
    struct figure figure = {.curve = &curve, .curves = 1, .equal = true, .aspect = aspect};
    struct figure_layout layout;
    struct canvas canvas;
    double min = INFINITY, max = 0, center_x, center_y;

    figure.y.factor = factor;
    for (int i = 0; i < n; i++) {
        x[i] = 3 + 0.04 * cos(2 * PI * i / (n - 1));
        y[i] = factor * (-1 + 0.04 * sin(2 * PI * i / (n - 1)));
    }
    draw(&figure, &canvas, width, height, &charset_braille, &layout);
    center_x = scale_fraction(&layout.x, 3) * (2 * layout.columns - 1);
    center_y = (1 - scale_fraction(&layout.y, -factor)) * (4 * layout.rows - 1);
    int dots = 0;
    for (int c = 0; c < 2 * layout.columns; c++) {
        for (int r = 0; r < 4 * layout.rows; r++) {
            if (!dot_lit(&canvas, 2 * layout.left + c, 4 * layout.top + r))
                continue;
            double radius = hypot((c - center_x) / 2, (r - center_y) / 4 * aspect);
            min = fmin(min, radius);
            max = fmax(max, radius);
            dots++;
        }
    }
    if (dots < 20 || max - min > 0.8 || max < 0.3 * fmin(layout.columns, aspect * layout.rows))
        fail_msg("%dx%d aspect %g: %d dots, radius %.2f to %.2f columns", width, height, aspect,
                 dots, min, max);
    canvas_free(&canvas);
}

TEST(test_equal_axes_draw_round_circles)
{
    check_circle(30, 15, 2, 1, 1000);
    check_circle(30, 15, 2, 13.7, 1000); /* v in units of omega0 */
    check_circle(80, 24, 2, 1, 2000);
    check_circle(40, 40, 2, 1, 2000);
    check_circle(60, 24, 1.7, 1, 60); /* few samples: straight lines between them */
}

/* The y labels' marks and the x labels are all there, each apart from the next. */
static void check_labels(const struct figure *figure, int width, int height)
{
    struct figure_layout layout;
    struct canvas canvas;
    draw(figure, &canvas, width, height, &charset_braille, &layout);
    if (layout.x_labels) {
        const struct cell *row = &canvas.cell[(height - 2) * width];
        int labels = 0, blanks = 2;
        for (int c = 1; c < width - 1; c++) {
            blanks = row[c].codepoint == ' ' ? blanks + 1 : 0;
            if (blanks == 0 && row[c - 1].codepoint == ' ')
                labels++;
            else if (blanks == 0 && c == 1)
                labels++;
            if (blanks == 1 && c + 1 < width - 1 && row[c + 1].codepoint != ' ')
                fail_msg("%dx%d: labels too near", width, height);
        }
        if (labels != layout.x_ticks.count)
            fail_msg("%dx%d x %g..%g: %d labels of %d", width, height, layout.x.first_value,
                     layout.x.last_value, labels, layout.x_ticks.count);
    }
    if (layout.y_labels) {
        int marks = 0;
        for (int r = 0; r < layout.rows; r++)
            marks += canvas.cell[(layout.top + r) * width + layout.left - 1].codepoint == 0x2524;
        if (marks != layout.y_ticks.count || marks < 2)
            fail_msg("%dx%d y %g..%g: %d marks of %d", width, height, layout.y.first_value,
                     layout.y.last_value, marks, layout.y_ticks.count);
    }
    canvas_free(&canvas);
}

TEST(test_labels_never_collide)
{
    int rounds = is_long() ? 100000 : 1000;
    (void)state;
    for (int i = 0; i < rounds; i++) {
        double size = pow(10, 200 * uniform() - 100), x[4], y[4];
        for (int k = 0; k < 4; k++) {
            x[k] = size * (k + uniform());
            y[k] = size * (uniform() - 0.5);
        }
        struct curve curve = {.x = x, .y = y, .n = 4};
        struct figure figure = {.x = {.label = "t", .unit = "s"},
                                .y = {.label = "y", .unit = "m"},
                                .curve = &curve,
                                .curves = 1};
        figure.equal = i % 5 == 0;
        figure.x.log = i % 7 == 0;
        figure.x.factor = i % 3 ? 1 : 0.01;
        int width = 20 + (int)(100 * uniform());
        check_labels(&figure, width, 7 + (int)(40 * uniform()));
    }
}

/* Nothing outside the rectangle is touched, whatever the size. */
TEST(test_every_size)
{
    static const int sizes[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,   10, 11,
                                12, 13, 15, 20, 25, 38, 50, 80, 100, 300};
    double x[200], y[200], wild[200];
    struct curve curve[] = {
        {.label = "verlet", .x = x, .y = y, .n = 200},
        {.label = "żółć 日本", .x = x, .y = wild, .n = 200, .panel = 1},
        {.label = "data", .x = x, .y = y, .n = 50, .points = true},
    };
    struct figure figure = {
        .title = "1",
        .x = {.label = "t", .unit = "s"},
        .y = {.label = "y", .unit = "cm", .factor = 0.01},
        .curve = curve,
        .curves = 3,
        .zero_line = true,
        .has_point = true,
        .point = {3, 0},
        .note = "14 periods: envelope",
        .caption = "2 T",
    };
    (void)state;
    for (int i = 0; i < 200; i++) {
        x[i] = i * 0.05;
        y[i] = 0.04 * cos(x[i]);
        wild[i] = 0.04 * exp(30 * x[i]);
    }
    y[100] = NAN;
    for (size_t w = 0; w < COUNT_OF(sizes); w++) {
        for (size_t h = 0; h < COUNT_OF(sizes); h++) {
            for (int kind = 0; kind < 6; kind++) {
                int width = sizes[w], height = sizes[h] > 100 ? 100 : sizes[h];
                struct canvas canvas;
                assert_true(canvas_init(&canvas, width + 2, height + 2));
                for (int i = 0; i < canvas.width * canvas.height; i++)
                    canvas.cell[i].codepoint = 'Z';
                figure.equal = kind >= 3;
                assert_true(figure_draw(&figure, &canvas, 1, 1, width, height, charsets[kind % 3]));
                for (int i = 0; i < canvas.width * canvas.height; i++) {
                    int column = i % canvas.width, row = i / canvas.width;
                    bool outside = column == 0 || row == 0 || column > width || row > height;
                    if ((canvas.cell[i].codepoint == 'Z') != outside)
                        fail_msg("%dx%d: cell %d,%d", width, height, column, row);
                }
                canvas_free(&canvas);
            }
        }
    }
    struct canvas small; /* partly and wholly beside the canvas */
    assert_true(canvas_init(&small, 10, 5));
    assert_true(figure_draw(&figure, &small, -20, -3, 80, 24, &charset_braille));
    assert_true(figure_draw(&figure, &small, 100, 100, 80, 24, &charset_block));
    assert_true(figure_draw(&figure, &small, 0, 0, 0, -1, &charset_ascii));
    canvas_free(&small);
}

/* Where there is one panel only its own curves set the range. */
TEST(test_one_diverging_run_does_not_flatten_the_others)
{
    double x[500], y[500], wild[500];
    struct curve curve[] = {{.x = x, .y = wild, .n = 500, .panel = 1}, {.x = x, .y = y, .n = 500}};
    struct figure figure = {.curve = curve, .curves = 2};
    struct figure_layout layout;
    struct canvas canvas;
    (void)state;
    for (int i = 0; i < 500; i++) {
        x[i] = i * 0.02;
        y[i] = cos(3 * x[i]);
        wild[i] = 1e-3 * exp(20 * x[i]);
    }
    draw(&figure, &canvas, 60, 20, &charset_ascii, &layout);
    assert_true(layout.y.last_value < 2 && layout.y.first_value > -2);
    int arrows = 0;
    for (int c = 0; c < layout.columns; c++)
        arrows += canvas.cell[layout.top * 60 + layout.left + c].codepoint == '^';
    assert_int_equal(arrows, 1);
    canvas_free(&canvas);
}

static int count_cells(const struct canvas *canvas, uint32_t codepoint)
{
    int count = 0;
    for (int i = 0; i < canvas->width * canvas->height; i++)
        count += canvas->cell[i].codepoint == codepoint;
    return count;
}

/* A growing oscillation crosses the frame many times: one arrow a side. */
TEST(test_one_arrow_a_side)
{
    double x[500], y[500];
    struct curve curve = {.x = x, .y = y, .n = 500};
    struct figure figure = {
        .curve = &curve, .curves = 1, .y = {.first_value = -1, .last_value = 1, .fixed = true}};
    struct figure_layout layout;
    struct canvas canvas;
    (void)state;
    for (int i = 0; i < 500; i++) {
        x[i] = i * 0.02;
        y[i] = 0.1 * exp(0.5 * x[i]) * cos(5 * x[i]);
    }
    draw(&figure, &canvas, 60, 20, &charset_braille, &layout);
    assert_int_equal(count_cells(&canvas, 0x2191), 1);
    assert_int_equal(count_cells(&canvas, 0x2193), 1);
    canvas_free(&canvas);
}

/* Over a line, marks leave it visible; an outlier is still marked. Alone, every sample is. */
TEST(test_dense_data_over_a_line)
{
    double x[1000], y[1000], measured[1000];
    struct curve curve[] = {{.x = x, .y = y, .n = 1000},
                            {.x = x, .y = measured, .n = 1000, .points = true}};
    struct figure figure = {.curve = curve, .curves = 2};
    struct figure_layout layout;
    struct canvas canvas;
    int column, row;
    (void)state;
    for (int i = 0; i < 1000; i++) {
        x[i] = i * 0.01;
        measured[i] = y[i] = cos(x[i]);
    }
    measured[333] = 3;
    draw(&figure, &canvas, 60, 20, &charset_ascii, &layout);
    int over = count_cells(&canvas, 'o');
    assert_true(over > layout.columns / 6 && over < layout.columns / 2);
    assert_true(figure_cell(&layout, x[333], measured[333], &column, &row));
    assert_int_equal(canvas.cell[(layout.top + row) * 60 + layout.left + column].codepoint, 'o');
    canvas_free(&canvas);

    figure.curve = &curve[1];
    figure.curves = 1;
    draw(&figure, &canvas, 60, 20, &charset_ascii, &layout);
    for (int i = 0; i < 1000; i++) {
        assert_true(figure_cell(&layout, x[i], measured[i], &column, &row));
        assert_int_equal(canvas.cell[(layout.top + row) * 60 + layout.left + column].codepoint,
                         'o');
    }
    canvas_free(&canvas);
}

/* Rounding errors of a constant are not magnified to full height. */
TEST(test_nearly_constant)
{
    double x[3] = {0, 1, 2}, y[3] = {5, 5 + 2e-13, 5 - 2e-13};
    struct curve curve = {.x = x, .y = y, .n = 3};
    struct figure figure = {.curve = &curve, .curves = 1};
    struct figure_layout layout;
    (void)state;
    figure_layout(&figure, 60, 20, &charset_braille, &layout);
    assert_true(layout.y.first_value < 4.6 && layout.y.last_value > 5.4);
    assert_true(layout.gutter <= 4);
    y[1] = 5 + 1e-9;
    y[2] = 5 - 1e-9;
    figure_layout(&figure, 60, 20, &charset_braille, &layout);
    assert_true(layout.y.first_value > 5 - 3e-9 && layout.y.last_value < 5 + 3e-9);
    y[1] = 5.01;
    figure_layout(&figure, 60, 20, &charset_braille, &layout);
    assert_true(layout.y.first_value > 4.99 && layout.y.last_value < 5.02);
}

TEST(test_few_rows)
{
    double x[2] = {0, 1}, y[2] = {-9.9, 9.9};
    struct curve curve = {.x = x, .y = y, .n = 2};
    (void)state;
    for (int height = 7; height < 14; height++) {
        for (double top = 1; top < 10; top += 0.3) {
            struct figure figure = {.curve = &curve,
                                    .curves = 1,
                                    .y = {.first_value = -top, .last_value = top, .fixed = true}};
            check_labels(&figure, 40, height);
        }
    }
}

TEST(test_scale_at_any_magnitude)
{
    for (int i = 0; i < 2000; i++) {
        double size = pow(10, 580 * uniform() - 285), x[2] = {0, 1},
               y[2] = {-size * uniform(), size};
        struct curve curve = {.x = x, .y = y, .n = 2};
        struct figure figure = {.curve = &curve, .curves = 1};
        struct figure_layout layout;
        figure.y.log = i % 2;
        if (figure.y.log)
            y[0] = y[1] * 1e-5 * uniform();
        figure_layout(&figure, 80, 24, &charset_braille, &layout);
        for (int k = 0; k < 2; k++) {
            const double fraction = scale_fraction(&layout.y, y[k]);
            assert_true(fraction >= 0 && fraction <= 1);
        }
    }
    struct curve all = {
        .x = (double[]){0, 1, 2}, .y = (double[]){-1.7e308, 1.7e308, 5e-324}, .n = 3};
    struct figure figure = {.curve = &all, .curves = 1, .y = {.factor = 1e-6}};
    struct buffer out = {0};
    assert_true(figure_print(&figure, 40, 12, &charset_ascii, false, &out));
    buffer_free(&out);
}

TEST(test_bad_fixed_ranges)
{
    static const double bad[][2] = {{1, 1}, {2, 1}, {0, 0}, {-1e308, 1e308}, {1, 1 + 1e-15}};
    double x[3] = {0, 1, 2}, y[3] = {1, 2, 3};
    struct curve curve = {.x = x, .y = y, .n = 3};
    struct figure figure = {.curve = &curve, .curves = 1};
    struct figure_layout layout;
    (void)state;
    for (size_t i = 0; i < COUNT_OF(bad); i++) { /* as if not fixed */
        figure.x = figure.y =
            (struct axis){.first_value = bad[i][0], .last_value = bad[i][1], .fixed = true};
        figure_layout(&figure, 40, 12, &charset_ascii, &layout);
        assert_true(layout.x.first_value == 0 && layout.x.last_value == 2 &&
                    layout.y.first_value <= 1 && layout.y.last_value >= 3);
    }
    figure.x = (struct axis){0};
    figure.y = (struct axis){.first_value = -1, .last_value = 1, .fixed = true, .log = true};
    figure_layout(&figure, 40, 12, &charset_ascii, &layout);
    assert_true(layout.y.first_value > 0 && layout.y.first_value <= 1 && layout.y.last_value >= 3);
}

/* y follows a fixed window of x. */
TEST(test_window)
{
    double x[5] = {0, 1, 2, 3, 4}, y[5] = {100, 1, 2, 3, 100};
    struct curve curve = {.x = x, .y = y, .n = 5};
    struct figure figure = {
        .curve = &curve, .curves = 1, .x = {.first_value = 1, .last_value = 3, .fixed = true}};
    struct figure_layout layout;
    int column, row;
    (void)state;
    figure_layout(&figure, 40, 12, &charset_ascii, &layout);
    assert_true(layout.y.last_value < 10);
    assert_true(figure_cell(&layout, 1, 1, &column, &row));
    assert_int_equal(column, 0);
    assert_true(figure_cell(&layout, 3, 1, &column, &row));
    assert_int_equal(column, layout.columns - 1);
    assert_false(figure_cell(&layout, 0.9, 1, &column, &row));
    assert_false(figure_cell(&layout, 2, NAN, &column, &row));
}

RUN_TESTS(NULL, NULL)
