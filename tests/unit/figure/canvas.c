/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Canvas: clipping, wide characters, what is printed. */
#include "cmocka_testing.h"

#include <math.h>

#include <hooke/figure.h>

static void expect(struct canvas *canvas, bool color, const char *text)
{
    struct buffer out = {0};
    canvas_print(canvas, color, &out);
    assert_false(out.failed);
    assert_string_equal(out.data, text);
    buffer_free(&out);
    canvas_free(canvas);
}

TEST(test_text_is_clipped)
{
    struct canvas canvas;
    (void)state;
    assert_true(canvas_init(&canvas, 6, 2));
    assert_int_equal(canvas_text(&canvas, 4, 0, TEXT("abc"), STYLE_PLAIN), 6);
    assert_int_equal(canvas_text(&canvas, -2, 1, TEXT("xyz"), STYLE_PLAIN), 1);
    canvas_text(&canvas, 0, 2, TEXT("below"), STYLE_PLAIN);
    canvas_put(&canvas, 0, -1, 'q', STYLE_PLAIN);
    expect(&canvas, false, "    ab\nz\n");
}

TEST(test_wide_characters)
{
    struct canvas canvas;
    (void)state;
    assert_true(canvas_init(&canvas, 7, 4));
    assert_int_equal(canvas_text(&canvas, 0, 0, TEXT("日本x"), STYLE_PLAIN), 5);
    canvas_text(&canvas, 6, 1, TEXT("日"), STYLE_PLAIN); /* half outside */
    canvas_text(&canvas, 0, 2, TEXT("日本"), STYLE_PLAIN);
    canvas_put(&canvas, 1, 2, 'a', STYLE_PLAIN);                 /* right half of the first */
    canvas_put(&canvas, 2, 2, 'b', STYLE_PLAIN);                 /* left half of the second */
    canvas_text(&canvas, 0, 3, TEXT("e\xCC\x81|"), STYLE_PLAIN); /* combining acute */
    expect(&canvas, false, "日本x\n\n ab\ne|\n");
}

TEST(test_controls_never_printed)
{
    struct canvas canvas;
    (void)state;
    assert_true(canvas_init(&canvas, 12, 1));
    canvas_text(&canvas, 0, 0,
                TEXT("a\033[2Jb\177\xC2\x9B"
                     "c\xFF"),
                STYLE_PLAIN);
    expect(&canvas, false, "a?[2Jb??c\xEF\xBF\xBD\n");
}

TEST(test_colors)
{
    struct canvas canvas;
    (void)state;
    assert_true(canvas_init(&canvas, 8, 3));
    canvas_text(&canvas, 0, 0, TEXT("ab"), STYLE_CURVE_1);
    /* a blank between does not end the colour */
    canvas_text(&canvas, 3, 0, TEXT("c"), STYLE_CURVE_1);
    canvas_text(&canvas, 4, 0, TEXT("d"), STYLE_PLAIN);
    canvas_text(&canvas, 0, 1, TEXT("e"), STYLE_DIM);
    canvas_text(&canvas, 1, 1, TEXT("f"), STYLE_ALERT);
    canvas_text(&canvas, 0, 2, TEXT("   "), STYLE_BOLD);
    expect(&canvas, true, "\033[34mab c\033[0md\n\033[2me\033[0m\033[31mf\033[0m\n\n");
}

/* Returns the luminance of a colour of the cube of 6 x 6 x 6 in the palette of 256 (WCAG 2). */
static double cube_luminance(int color)
{
    static const double weight[3] = {0.2126, 0.7152, 0.0722};
    const int level[3] = {(color - 16) / 36, (color - 16) / 6 % 6, (color - 16) % 6};
    double luminance = 0;
    for (int i = 0; i < 3; i++) {
        const double value = level[i] ? (55 + 40 * level[i]) / 255.0 : 0;
        luminance += weight[i] * pow((value + 0.055) / 1.055, 2.4);
    }
    return luminance;
}

TEST(colors_are_readable_on_white_and_on_black)
{
    (void)state;
    for (int style = STYLE_CURVE_1; style <= STYLE_ALERT; style++) {
        const int color = style_color((enum style)style, 256);
        const double luminance = cube_luminance(color);
        assert_true(color >= 16 && color < 232);
        assert_true(1.05 / (luminance + 0.05) >= 3);
        assert_true((luminance + 0.05) / 0.05 >= 3);
        /* neither yellow nor cyan */
        assert_int_not_equal(style_color((enum style)style, 8), 3);
        assert_int_not_equal(style_color((enum style)style, 8), 6);
        assert_int_equal(style_color((enum style)style, 0), -1);
    }
}

TEST(test_no_color_no_escape)
{
    struct canvas canvas;
    (void)state;
    assert_true(canvas_init(&canvas, 8, 1));
    for (int style = STYLE_PLAIN; style <= STYLE_ALERT; style++)
        canvas_put(&canvas, style, 0, 'x', (enum style)style);
    expect(&canvas, false, "xxxxxxxx\n");
}

TEST(test_empty_canvas)
{
    struct canvas canvas;
    (void)state;
    assert_true(canvas_init(&canvas, 0, -3));
    canvas_put(&canvas, 0, 0, 'x', STYLE_PLAIN);
    assert_int_equal(canvas.width, 0);
    assert_int_equal(canvas.height, 0);
    canvas_free(&canvas);
}

RUN_TESTS(NULL, NULL)
