/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Heat maps: which shade a value has, cells for points, what has no value, labels, the legend. */
#include "cmocka_testing.h"

#include "modules/sweep/swept.h"

#include <string.h>

static const double indices[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};

static struct heat heat_of(int nx, int ny, const double *value)
{
    return (struct heat){.title = "swing",
                         .unit = "mm",
                         .factor = 1e-3,
                         .x = {"omega", "rad/s", 1, indices, nx},
                         .y = {"gamma", "", 1, indices, ny},
                         .value = value};
}

static void expect(const struct heat *heat, int width, int height, const struct charset *charset,
                   const char *text)
{
    struct buffer out = {0};
    assert_true(heat_print(heat, width, height, charset, &out));
    assert_string_equal(out.data, text);
    buffer_free(&out);
}

/* Ten shades over equal parts of the range; the largest value has the last one. */
TEST(test_values_become_shades)
{
    const double value[] = {0,      0.0011, 0.0021, 0.0031, 0.0041, 0.0051,
                            0.0061, 0.0071, 0.0081, 0.0091, 0.01};
    const struct heat heat = heat_of(11, 1, value);
    expect(&heat, 13, 6, &charset_ascii,
           "swing [mm] over omega [rad/s] (right) and gamma (up)\n"
           "1| .:-=+*%@##\n"
           " +-----------\n"
           "  1   5   9\n"
           "0 [ ] 1 [.] \n2 [:] 3 [-] \n4 [=] 5 [+] \n6 [*] 7 [%] \n8 [@] 9 [#] \n10\n");
}

/* x runs to the right, y upwards; a point takes a whole number of cells. */
TEST(test_axes)
{
    const double value[] = {0, 1, 2, 3, 4, 5}; /* [x][y] */
    const struct heat heat = heat_of(3, 2, value);
    expect(
        &heat, 80, 9, &charset_ascii,
        "swing [mm] over omega [rad/s] (right) and gamma (up)\n"
        " |::::::::::::::::::::::::::**************************##########################\n" /* 1 3
                                                                                                5 */
        "2|::::::::::::::::::::::::::**************************##########################\n"
        " |                          ==========================@@@@@@@@@@@@@@@@@@@@@@@@@@\n" /* 0 2
                                                                                                4 */
        "1|                          ==========================@@@@@@@@@@@@@@@@@@@@@@@@@@\n"
        " +------------------------------------------------------------------------------\n"
        "  1                         2                         3\n"
        "0 [ ] 500 [.] 1000 [:] 1500 [-] 2000 [=] 2500 [+] 3000 [*] 3500 [%] 4000 [@] \n"
        "4500 [#] 5000\n");
}

TEST(test_no_value)
{
    const double some[] = {NAN, 0.001, INFINITY, 0.002}, none[] = {NAN, NAN, -INFINITY, NAN};
    struct heat heat = heat_of(4, 1, some);
    expect(&heat, 6, 6, &charset_block,
           "swing [mm] over omega [rad/s] (right) and gamma (up)\n"
           "1|x x\xE2\x96\x88\n"
           " +----\n"
           "  1\n"
           "1 [ ] \n1.167 [\xC2\xB7] \n1.333 [\xE2\x96\x91] \n1.5 [\xE2\x96\x92] \n1.667 "
           "[\xE2\x96\x93] \n1.833 [\xE2\x96\x88] \n"
           "2   x: no value\n");
    heat = heat_of(4, 1, none);
    expect(&heat, 6, 6, &charset_ascii,
           "swing [mm] over omega [rad/s] (right) and gamma (up)\n1|xxxx\n +----\n  1\nno point "
           "has a value\n");
}

/* All alike, and a single point: the lowest shade, no division by the span. */
TEST(test_one_value)
{
    const double value[] = {0.005, 0.005};
    for (int n = 1; n <= 2; n++) {
        const struct heat heat = heat_of(n, 1, value);
        struct buffer out = {0};
        assert_true(heat_print(&heat, 40, 10, &charset_ascii, &out));
        assert_non_null(strstr(out.data, "1|\n"));
        assert_non_null(strstr(out.data, "5 [ ] 5 [.]"));
        assert_null(strstr(out.data, "nan"));
        buffer_free(&out);
    }
}

/* More points than cells: a peak of one point is not lost. */
TEST(test_peaks_stay)
{
    enum { N = 1000 };
    static double value[N], x[N];
    for (int peak = 0; peak < N; peak += 37) {
        for (int i = 0; i < N; i++) {
            value[i] = i == peak;
            x[i] = i;
        }
        struct heat heat = heat_of(1, 1, value);
        heat.x.value = x;
        heat.x.count = N;
        struct buffer out = {0};
        assert_true(heat_print(&heat, 60, 10, &charset_ascii, &out));
        const char *line = strchr(out.data, '\n') + 1;
        const char *shade = strchr(line, '#');
        assert_non_null(shade);
        assert_int_equal(shade - line - 2, peak * 58 / N);
        buffer_free(&out);
    }
}

/* Whatever the room: no line longer than it but the first, none at all missing. */
TEST(test_any_size)
{
    double value[144];
    for (int i = 0; i < 144; i++)
        value[i] = i % 7 ? i * 1e-3 : NAN;
    const struct heat heat = heat_of(12, 12, value);
    for (int width = 20; width < 100; width += 7)
        for (int height = 1; height < 40; height += 3) {
            struct buffer out = {0};
            assert_true(heat_print(&heat, width, height, &charset_ascii, &out));
            int lines = 0;
            for (const char *at = strchr(out.data, '\n') + 1, *end; (end = strchr(at, '\n'));
                 /* the note behind the legend */
                 at = end + 1,
                            lines++)
                assert_true(end - at <= width + 20);
            assert_true(lines >= 4);
            buffer_free(&out);
        }
}

RUN_TESTS(NULL, NULL)
