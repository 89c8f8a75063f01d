/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Curves beside each other are told apart by all readers: colours as seen with normal eyes, by
 * protanopes and deuteranopes (Machado, Oliveira, Fernandes 2009, severity 1: matrices on linear
 * RGB), and in grey print, as distances in CIE Lab (1976; 2.3 is just noticeable); and without any
 * colour by their dashes.
 */
#include "cmocka_testing.h"

#include "modules/pictures/style.h"

#include <math.h>
#include <string.h>

enum { NORMAL, PROTANOPE, DEUTERANOPE, SEEN };

static const double seen_by[SEEN][3][3] = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                           {{0.152286, 1.052583, -0.204868},
                                            {0.114503, 0.786281, 0.099216},
                                            {-0.003882, -0.048116, 1.051998}},
                                           {{0.367322, 0.860646, -0.227968},
                                            {0.280085, 0.672501, 0.047413},
                                            {-0.011820, 0.042940, 0.968881}}};

static double linear(double value) /* sRGB, IEC 61966-2-1 */
{
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

static double bent(double t)
{
    const double small = 6.0 / 29;
    return t > small * small * small ? cbrt(t) : t / (3 * small * small) + 4.0 / 29;
}

static void lab_of(const double *color, int eyes, double lab[3])
{
    static const double xyz[3][3] = {{0.4124 / 0.9505, 0.3576 / 0.9505, 0.1805 / 0.9505},
                                     {0.2126, 0.7152, 0.0722},
                                     {0.0193 / 1.089, 0.1192 / 1.089, 0.9505 / 1.089}};
    double rgb[3], f[3];
    for (int i = 0; i < 3; i++) {
        rgb[i] = 0;
        for (int k = 0; k < 3; k++)
            rgb[i] += seen_by[eyes][i][k] * linear(color[k]);
        rgb[i] = fmin(fmax(rgb[i], 0), 1);
    }
    for (int i = 0; i < 3; i++)
        f[i] = bent(xyz[i][0] * rgb[0] + xyz[i][1] * rgb[1] + xyz[i][2] * rgb[2]);
    lab[0] = 116 * f[1] - 16;
    lab[1] = 500 * (f[0] - f[1]);
    lab[2] = 200 * (f[1] - f[2]);
}

static double color_distance(size_t a, size_t b, int eyes)
{
    double p[3], q[3];
    lab_of(style_palette[a], eyes, p);
    lab_of(style_palette[b], eyes, q);
    return hypot(hypot(p[0] - q[0], p[1] - q[1]), p[2] - q[2]);
}

/* Of lightness: what a grey printer leaves. */
static double grey_distance(size_t a, size_t b)
{
    double p[3], q[3];
    lab_of(style_palette[a], NORMAL, p);
    lab_of(style_palette[b], NORMAL, q);
    return fabs(p[0] - q[0]);
}

TEST(test_colors)
{
    double all = HUGE_VAL, beside = HUGE_VAL, grey = HUGE_VAL, few = HUGE_VAL;
    (void)state;
    for (size_t a = 0; a < style_palette_count; a++) {
        for (size_t b = a + 1; b < style_palette_count; b++) {
            for (int eyes = 0; eyes < SEEN; eyes++) {
                all = fmin(all, color_distance(a, b, eyes));
                beside = fmin(beside, b == a + 1 ? color_distance(a, b, eyes) : HUGE_VAL);
            }
            grey = fmin(grey, b == a + 1 ? grey_distance(a, b) : HUGE_VAL);
            few = fmin(few, b < 4 ? grey_distance(a, b) : HUGE_VAL);
        }
    }
    print_message("any two colours %.1f, neighbours %.1f, in grey %.1f, the first four %.1f\n", all,
                  beside, grey, few);
    assert_true(all > 15);
    assert_true(beside > 25);
    assert_true(grey > 6);
    assert_true(few > 11);
}

/* Paper is white: a contrast of at least 2.2 to 1 (WCAG's ratio), dark enough for thin lines. */
TEST(test_paper)
{
    for (size_t i = 0; i < style_palette_count; i++) {
        const double *color = style_palette[i];
        const double light =
            0.2126 * linear(color[0]) + 0.7152 * linear(color[1]) + 0.0722 * linear(color[2]);
        assert_true(1.05 / (light + 0.05) > 2.2);
    }
}

/* Five lines in a row have dashes of their own, and colour and dashes come together again only
 * after 35. */
TEST(test_dashes)
{
    for (size_t a = 0; a < style_dashes_count; a++)
        for (size_t b = 0; b < a; b++)
            assert_false(style_dashes[a].n == style_dashes[b].n &&
                         memcmp(style_dashes[a].length, style_dashes[b].length,
                                sizeof style_dashes[a].length) == 0);
    assert_true(style_dashes_count >= 5);
    size_t same = 1;
    while (same % style_dashes_count || same % style_palette_count)
        same++;
    assert_int_equal(same, style_dashes_count * style_palette_count);
}

RUN_TESTS(NULL, NULL)
