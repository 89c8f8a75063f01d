/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Legends of pictures cover no ink, error bars stand where the data are, text figures have none. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/pictures/svg_testing.h"

#define CURVES 3
#define SAMPLES 400
#define PATHS 60

struct drawn {
    struct svg_path path[PATHS];
    struct svg_element element[PATHS];
    int paths;
    struct svg_element text[60];
    int texts;
    double left, right, top, bottom; /* of the frame */
    int frame;                       /* which path it is */
};

static void draw(const struct figure *figure, struct drawn *drawn)
{
    struct buffer svg = {0};
    struct error error = {0};
    struct svg_element element;
    assert_true(figure_picture(figure, PICTURE_SVG, 0, 0, &svg, &error));
    drawn->paths = drawn->texts = 0;
    drawn->frame = -1;
    for (const char *at = NULL; svg_next(svg.data, &at, &element, &drawn->path[drawn->paths]);) {
        struct svg_path *path = &drawn->path[drawn->paths];
        if (element.is_text) {
            assert_in_range(drawn->texts, 0, COUNT_OF(drawn->text) - 1);
            drawn->text[drawn->texts++] = element;
            continue;
        }
        if (strcmp(element.stroke, "#000000") == 0 && path->n == 4 && drawn->frame < 0) {
            drawn->frame = drawn->paths;
            drawn->left = path->x[0];
            drawn->right = path->x[1];
            drawn->top = path->y[0];
            drawn->bottom = path->y[2];
        }
        drawn->element[drawn->paths] = element;
        drawn->paths += drawn->frame < 0; /* ticks follow */
        assert_in_range(drawn->paths, 0, PATHS - 1);
    }
    buffer_free(&svg);
    assert_true(drawn->frame >= 0);
}

static const struct svg_element *find_text(const struct drawn *drawn, const char *text)
{
    for (int i = 0; i < drawn->texts; i++)
        if (strcmp(drawn->text[i].text, text) == 0)
            return &drawn->text[i];
    fail_msg("the picture does not say '%s'", text);
    return NULL;
}

static bool crosses(const struct svg_path *path, const struct svg_element *box)
{
    for (int i = 0; i < path->n; i++) {
        const int parts = path->joined[i] ? 200 : 0;
        for (int k = 0; k <= parts; k++) {
            const double part = parts ? (double)k / parts : 0,
                         x = path->x[i] - (parts ? part * (path->x[i] - path->x[i - 1]) : 0),
                         y = path->y[i] - (parts ? part * (path->y[i] - path->y[i - 1]) : 0);
            if (x > box->left && x < box->right && y > box->top && y < box->bottom)
                return true;
        }
    }
    return false;
}

static double random_part(void)
{
    static uint32_t random = 1;
    random = random * 1664525 + 1013904223;
    return (random >> 8) * 0x1p-24;
}

/* ---- legend ---- */

static struct {
    double x[SAMPLES], y[CURVES][SAMPLES];
    struct curve curve[CURVES];
} made;

static void make_curves(bool steady)
{
    static const char *const labels[CURVES] = {"backward-euler", "verlet", "data"};
    for (int c = 0; c < CURVES; c++) {
        const double size = random_part(), rate = 60 * random_part(), from = random_part() - 0.5,
                     fall = steady ? 0 : 4 * random_part() - 2,
                     rise = steady ? 0 : 2 * random_part() - 1;
        for (int i = 0; i < SAMPLES; i++) {
            const double t = (double)i / SAMPLES;
            made.x[i] = t;
            made.y[c][i] = from + rise * t + size * exp(fall * t) * cos(rate * t);
        }
        made.curve[c] = (struct curve){
            .label = labels[c], .x = made.x, .y = made.y[c], .n = SAMPLES, .points = c == 2};
        if (c == 2 && random_part() < 0.5)
            made.curve[c].n = 40;
    }
}

TEST(test_legend_covers_nothing)
{
    static struct drawn drawn;
    int inside = 0, above = 0;
    (void)state;
    for (int k = 0; k < (is_long() ? 500 : 60); k++) {
        make_curves(k % 5 == 0);
        const struct figure figure = {.title = k % 2 ? "position" : NULL,
                                      .x = {.label = "t"},
                                      .y = {.label = "y"},
                                      .curve = made.curve,
                                      .curves = 1 + k % CURVES,
                                      .zero_line = k % 4 == 0};
        draw(&figure, &drawn);
        int here = 0;
        for (int c = 0; c < figure.curves; c++) {
            const struct svg_element *label = find_text(&drawn, made.curve[c].label);
            here += label->top > drawn.top;
            for (int p = 0; p < drawn.frame; p++) /* what follows the frame are ticks and legend */
                if (label->top > drawn.top && crosses(&drawn.path[p], label))
                    fail_msg("figure %d: '%s' covers a curve", k, label->text);
        }
        assert_true(here == 0 || here == figure.curves);
        inside += here > 0;
        above += here == 0;
    }
    print_message("%d legends in the plot, %d above\n", inside, above);
    assert_true(inside > 5 && above > 5);
}

/* Where there is room in a corner only, it is there; where a cloud fills the plot it is above. */
TEST(test_where_the_legend_is)
{
    static struct drawn drawn;
    const double x[] = {0, 1, 1, 0}, y[] = {0, 0, 1, 1};
    static double cloud[2][10 * SAMPLES];
    (void)state;
    for (int corner = 0; corner < 4; corner++) {
        double at[2][5];
        for (int i = 0; i < 4; i++) { /* a way around, but for that corner */
            at[0][i] = x[(corner + 1 + i) % 4];
            at[1][i] = y[(corner + 1 + i) % 4];
        }
        const struct curve curve = {.label = "way", .x = at[0], .y = at[1], .n = 3};
        const struct figure figure = {
            .x = {.label = "x", .fixed = true, .first_value = 0, .last_value = 1},
            .y = {.label = "y", .fixed = true, .first_value = 0, .last_value = 1},
            .plane = true,
            .curve = &curve,
            .curves = 1};
        draw(&figure, &drawn);
        const struct svg_element *label = find_text(&drawn, "way");
        assert_int_equal(label->left > (drawn.left + drawn.right) / 2, x[corner] > 0.5);
        assert_int_equal(label->top<(drawn.top + drawn.bottom) / 2, y[corner]> 0.5);
    }
    for (int i = 0; i < 10 * SAMPLES; i++) {
        cloud[0][i] = random_part();
        cloud[1][i] = random_part();
    }
    const struct curve curve = {
        .label = "cloud", .x = cloud[0], .y = cloud[1], .n = 10 * SAMPLES, .points = true};
    draw(&(struct figure){.x = {.label = "x"}, .y = {.label = "y"}, .curve = &curve, .curves = 1},
         &drawn);
    assert_true(find_text(&drawn, "cloud")->bottom < drawn.top);
}

/* ---- error bars ---- */

TEST(test_error_bars)
{
    static struct drawn drawn;
    double x[] = {1, 2, 3, 4, 5}, y[] = {2, 3, 1, 4, 2}, bar[] = {0.5, NAN, 0, 1.5, 0.25};
    struct curve curve = {.x = x, .y = y, .n = 5, .points = true};
    struct figure figure = {.x = {.label = "t", .fixed = true, .first_value = 0, .last_value = 6},
                            .y = {.label = "y", .fixed = true, .first_value = 0, .last_value = 6},
                            .curve = &curve,
                            .curves = 1};
    struct buffer text = {0}, with = {0};
    (void)state;
    assert_true(figure_print(&figure, 60, 20, &charset_braille, false, &text));
    draw(&figure, &drawn);
    const int paths = drawn.paths;
    curve.bar = bar;
    assert_true(figure_print(&figure, 60, 20, &charset_braille, false, &with));
    assert_string_equal(text.data, with.data);
    draw(&figure, &drawn);
    assert_true(drawn.paths > paths);
    int bars = 0, caps = 0;
    for (int p = 0; p < drawn.frame; p++) {
        const struct svg_path *path = &drawn.path[p];
        for (int i = 1; i < path->n && !drawn.element[p].filled; i++) {
            const double dx = path->x[i] - path->x[i - 1], dy = path->y[i] - path->y[i - 1],
                         height = drawn.bottom - drawn.top, width = drawn.right - drawn.left;
            if (!path->joined[i])
                continue;
            for (int k = 0; k < 5; k++) {
                const double at = drawn.left + x[k] / 6 * width,
                             low = drawn.bottom - (y[k] - bar[k]) / 6 * height,
                             high = drawn.bottom - (y[k] + bar[k]) / 6 * height;
                bars += bar[k] > 0 && fabs(path->x[i] - at) < 0.02 && dx == 0 &&
                        fabs(fmax(path->y[i], path->y[i - 1]) - low) < 0.02 &&
                        fabs(fmin(path->y[i], path->y[i - 1]) - high) < 0.02;
                caps += bar[k] > 0 && dy == 0 && fabs(path->x[i] - dx / 2 - at) < 0.02 &&
                        (fabs(path->y[i] - low) < 0.02 || fabs(path->y[i] - high) < 0.02);
            }
        }
    }
    assert_int_equal(bars, 3);
    assert_int_equal(caps, 6);
    figure.y = (struct axis){.label = "y"}; /* then they are seen whole: 4 + 1.5 */
    draw(&figure, &drawn);
    double highest = HUGE_VAL;
    for (int p = 0; p < drawn.frame; p++)
        for (int i = 0; i < drawn.path[p].n; i++)
            highest = fmin(highest, drawn.path[p].y[i]);
    assert_true(highest > drawn.top);
    buffer_free(&text);
    buffer_free(&with);
}

RUN_TESTS(NULL, NULL)
