/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Paths of curves of a million samples: few corners, every sample under the ink, no ink away from
 * the samples' line. */
#include "cmocka_testing.h"

#include "modules/pictures/path.h"
#include "long_form.h"

#include <stdio.h>
#include <stdlib.h>

#define MANY (is_long() ? 1000000 : 100000)
#define MOST 18000
#define PIXEL 0.75 /* [pt] 1/96 inch */
#define NEAR (0.3 * PIXEL)

static const struct path_limit limit = {.corners = MOST};

struct sheet {
    double *x, *y;
    size_t n;
    struct scale across, up;
    struct plot_area area;
};

static void sheet_init(struct sheet *s, size_t n)
{
    s->n = n;
    s->x = calloc(n + 1, sizeof *s->x);
    s->y = calloc(n + 1, sizeof *s->y);
    assert_true(s->x && s->y);
    s->across = scale_of(-1, 1, false);
    s->up = scale_of(-1, 1, false);
    s->area = (struct plot_area){&s->across, &s->up, 50, 30, 630, 350};
    for (size_t i = 0; i < n; i++)
        s->x[i] = -1 + 2 * (double)i / (double)n;
}

static void sheet_free(struct sheet *s)
{
    free(s->x);
    free(s->y);
}

static double random_part(void)
{
    static uint32_t random = 1;
    random = random * 1664525 + 1013904223;
    return (random >> 8) * 0x1p-24;
}

/* ---- distances ---- */

static double to_segment(double x, double y, const double a[2], const double b[2])
{
    const double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    const double part =
        square > 0 ? fmin(fmax(((x - a[0]) * dx + (y - a[1]) * dy) / square, 0), 1) : 0;
    return hypot(x - a[0] - part * dx, y - a[1] - part * dy);
}

/* [pt] From a place to the ink, which is wider than a line on a coarse grid. */
static double to_ink(const struct path *path, double x, double y)
{
    const struct corner *corner = path_corners(path);
    double nearest = HUGE_VAL;
    for (size_t i = 0; i < path_count(path); i++) {
        const struct corner *to = &corner[i], *at = to->begins ? to : to - 1;
        nearest =
            fmin(nearest, to_segment(x, y, (double[]){at->x, at->y}, (double[]){to->x, to->y}));
    }
    return fmax(nearest - path->width / 2, 0);
}

/* [pt] From a corner of the path to the line through the samples. */
static double to_samples(const struct sheet *s, double x, double y)
{
    double nearest = HUGE_VAL, before[2] = {NAN, NAN};
    for (size_t i = 0; i < s->n; i++) {
        const double at[2] = {plot_x(&s->area, s->x[i]), plot_y(&s->area, s->y[i])};
        if (!isnan(before[0]) && (fabs(at[0] - x) < 3 || (before[0] > x) != (at[0] > x)))
            nearest = fmin(nearest, to_segment(x, y, before, at));
        before[0] = isnan(at[1]) ? NAN : at[0];
        before[1] = at[1];
    }
    return nearest;
}

static bool in_plot(const struct sheet *s, double x, double y)
{
    return x >= s->area.left && x <= s->area.right && y >= s->area.top && y <= s->area.bottom;
}

struct found {
    size_t corners;
    double width;  /* [pt] of the pen of a coarse grid, or 0 */
    double hidden; /* [pt] of a sample, to the ink */
    double stray;  /* [pt] of a corner, to the samples' line */
};

static struct found measure(const struct sheet *s, bool dots)
{
    struct path path = {0};
    struct found found = {0};
    const struct curve curve = {.x = s->x, .y = s->y, .n = s->n};
    assert_true((dots ? path_of_dots : path_of_line)(&curve, &s->area, &limit, &path));
    found.corners = path_count(&path);
    found.width = path.width;
    const size_t every = s->n < 5000 ? 1 : s->n / (is_long() ? 3000 : 100) + 1;
    for (size_t i = 0; i < s->n; i += every) {
        const double x = plot_x(&s->area, s->x[i]), y = plot_y(&s->area, s->y[i]);
        if (in_plot(s, x, y))
            found.hidden = fmax(found.hidden, to_ink(&path, x, y));
    }
    const size_t step = 1 + found.corners / (is_long() ? 50 : 2);
    for (size_t i = step / 2; i < found.corners && !dots; i += step) {
        const struct corner *corner = &path_corners(&path)[i];
        if (in_plot(s, corner->x, corner->y))
            found.stray = fmax(found.stray, to_samples(s, corner->x, corner->y));
    }
    path_free(&path);
    return found;
}

static struct found expect_close(const struct sheet *s, const char *what)
{
    const struct found found = measure(s, false);
    print_message("%-24s %5zu corners, pen %g, samples within %.3f pt, corners within %.3f pt\n",
                  what, found.corners, found.width, found.hidden, found.stray);
    if (found.corners > MOST + 2)
        fail_msg("%s: %zu corners", what, found.corners);
    if (!(found.hidden <= NEAR && found.stray <= NEAR))
        fail_msg("%s: a sample %g pt away, a corner %g pt", what, found.hidden, found.stray);
    return found;
}

/* ---- shapes ---- */

TEST(test_waves)
{
    const double periods[] = {0.5, 13, 150, 1378, 20000.25, 0.4 * MANY};
    struct sheet s;
    (void)state;
    sheet_init(&s, (size_t)MANY);
    for (size_t k = 0; k < COUNT_OF(periods); k++) {
        char what[40];
        snprintf(what, sizeof what, "%g periods", periods[k]);
        for (size_t i = 0; i < s.n; i++)
            s.y[i] = 0.9 * exp(-0.8 * (s.x[i] + 1)) * cos(3.141592653589793 * periods[k] * s.x[i]);
        expect_close(&s, what);
    }
    sheet_free(&s);
}

TEST(test_planes)
{
    struct sheet s;
    (void)state;
    sheet_init(&s, (size_t)MANY);
    for (size_t i = 0; i < s.n; i++) { /* a spiral that fills a ring */
        const double t = (double)i / (double)s.n, size = 0.9 * exp(-t);
        s.x[i] = size * cos(8000 * t);
        s.y[i] = size * sin(8000 * t);
    }
    assert_true(expect_close(&s, "a spiral").width > 0);
    for (size_t i = 0; i < s.n; i++) { /* the same turn again and again */
        s.x[i] = 0.9 * cos(0.01 * (double)i);
        s.y[i] = 0.7 * sin(0.03 * (double)i + 0.2);
    }
    assert_true(expect_close(&s, "a limit cycle").width == 0);
    double x = 0.1, y = 0, v = 0;
    for (size_t i = 0; i < s.n; i++) { /* two wells and a drive (Moon, Holmes 1979), Euler's way */
        v += 0.01 * (y - y * y * y - 0.15 * v + 0.3 * cos(0.01 * (double)i));
        y += 0.01 * v;
        s.x[i] = y / 1.6;
        s.y[i] = v / 1.2;
    }
    expect_close(&s, "chaos");
    for (size_t i = 0; i < s.n; i++) {
        x += 0.01 * (random_part() - 0.5);
        y += 0.01 * (random_part() - 0.5);
        s.x[i] = 0.3 * x;
        s.y[i] = 0.3 * y;
    }
    expect_close(&s, "a random walk");
    sheet_free(&s);
}

TEST(test_noise)
{
    struct sheet s;
    (void)state;
    sheet_init(&s, (size_t)MANY);
    for (size_t i = 0; i < s.n; i++)
        s.y[i] = 2 * random_part() - 1;
    expect_close(&s, "noise");
    for (size_t i = 0; i < s.n; i++)
        s.y[i] *= 1e4; /* through the frame */
    expect_close(&s, "lines through the frame");
    /* The worst case, lone specks that nearly fill the plot: few corners all the same. */
    for (size_t i = 0; i < s.n; i++)
        s.y[i] = i % 2 ? NAN : 2 * random_part() - 1;
    struct path path = {0};
    const struct curve curve = {.x = s.x, .y = s.y, .n = s.n};
    assert_true(path_of_line(&curve, &s.area, &limit, &path));
    assert_in_range(path_count(&path), 4, MOST);
    path_free(&path);
    sheet_free(&s);
}

/* One sample of a million, wherever it is, on a line or a band, has its place within half a pixel.
 */
static void expect_spikes(struct sheet *s, double periods, bool dots)
{
    struct path path = {0};
    size_t at[40];
    double worst = 0, beyond = 0;
    for (size_t i = 0; i < s->n; i++)
        s->y[i] = 0.2 * sin(3.141592653589793 * periods * s->x[i]);
    for (size_t i = 0; i < COUNT_OF(at); i++) {
        at[i] = (size_t)((double)i * (MANY - 20.0) / COUNT_OF(at) + 20 * random_part());
        s->y[at[i]] = (i % 2 ? 1 : -1) * (0.3 + 0.6 * random_part());
    }
    const struct curve curve = {.x = s->x, .y = s->y, .n = s->n};
    assert_true((dots ? path_of_dots : path_of_line)(&curve, &s->area, &limit, &path));
    for (size_t i = 0; i < COUNT_OF(at); i++) {
        const double x = plot_x(&s->area, s->x[at[i]]), y = plot_y(&s->area, s->y[at[i]]);
        const double away = i % 2 ? -1 : 1;
        worst = fmax(worst, to_ink(&path, x, y));
        for (size_t c = 0; c < path_count(&path); c++) { /* and there it ends */
            const struct corner *corner = &path_corners(&path)[c];
            if (fabs(corner->x - x) < 2)
                beyond = fmax(beyond, away * (corner->y - y));
        }
    }
    print_message("%g periods%s: spikes within %.3f pt, beyond them %.3f pt\n", periods,
                  dots ? " of dots" : "", worst, beyond);
    assert_true(worst <= 0.5 * PIXEL);
    assert_true(beyond <= 0.5 * PIXEL);
    path_free(&path);
}

/* A path that was thinned out still reaches each of 40 spikes to within half a pixel, and not
 * beyond them: on a constant, a slow and a fast oscillation (in periods), as a line and as dots. */
TEST(test_spikes)
{
    struct sheet s;
    (void)state;
    sheet_init(&s, (size_t)MANY);
    for (int dots = 0; dots < 2; dots++) {
        expect_spikes(&s, 0, dots);
        expect_spikes(&s, 20, dots);
        expect_spikes(&s, 20000, dots);
    }
    sheet_free(&s);
}

TEST(test_few_samples)
{
    struct sheet s;
    (void)state;
    sheet_init(&s, 9);
    s.n = 0;
    assert_int_equal(measure(&s, false).corners, 0);
    s.n = 1;
    assert_int_equal(measure(&s, false).corners, 2); /* a dot */
    s.n = 9;
    assert_int_equal(measure(&s, false).corners, 2);
    s.y[4] = NAN;
    assert_int_equal(measure(&s, false).corners, 4); /* no line across a gap */
    s.y[6] = INFINITY;
    s.y[5] = 0.5;
    assert_int_equal(measure(&s, false).corners, 6);
    s.y[2] = -1e308;
    assert_true(measure(&s, false).hidden < NEAR);
    for (size_t i = 0; i < s.n; i++)
        s.x[i] = NAN;
    assert_int_equal(measure(&s, false).corners, 0);
    assert_int_equal(measure(&s, true).corners, 0);
    sheet_free(&s);
}

TEST(test_dots)
{
    const struct {
        size_t n;
        double apart; /* [pt] to the nearest dot that is drawn */
    } cases[] = {{100, 0.001}, {10000, NEAR}, {30000, 6}, {100000, 6}, {(size_t)MANY, 6}};
    (void)state;
    for (size_t k = 0; k < COUNT_OF(cases); k++) {
        struct sheet s;
        sheet_init(&s, cases[k].n);
        for (size_t i = 0; i < s.n; i++)
            s.y[i] = 2 * random_part() - 1;
        const struct found found = measure(&s, true);
        print_message("%zu dots: %zu corners, within %.3f pt\n", s.n, found.corners, found.hidden);
        assert_in_range(found.corners, 1, MOST);
        assert_true(found.hidden <= cases[k].apart);
        sheet_free(&s);
    }
}

/* What meets a legend. */
TEST(test_meets)
{
    struct sheet s;
    struct path path = {0};
    (void)state;
    sheet_init(&s, (size_t)MANY);
    for (size_t i = 0; i < s.n; i++)
        s.y[i] = 0.5 * sin(62831.0 * s.x[i]);
    const struct curve band = {.x = s.x, .y = s.y, .n = s.n}, line = {.x = s.x, .y = s.y, .n = 2};
    assert_true(path_of_line(&band, &s.area, &limit, &path));
    assert_true(path_count(&path) > 1000);
    assert_true(path_meets(&path, 300, 180, 320, 200)); /* in the middle of the ink */
    assert_true(path_meets(&path, 300, 50, 320, 200));
    assert_false(path_meets(&path, 300, 40, 400, 100));
    path_free(&path);
    s.x[0] = s.y[0] = -1;
    s.x[1] = s.y[1] = 1;
    path = (struct path){0};
    assert_true(path_of_line(&line, &s.area, &limit, &path));
    assert_true(path_meets(&path, 300, 50, 400, 340));
    assert_false(path_meets(&path, 60, 40, 200, 200));
    assert_false(path_meets(&path, 400, 300, 600, 340));
    path_free(&path);
    sheet_free(&s);
}

RUN_TESTS(NULL, NULL)
