/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The diagram of random precision studies, read as a person reads it: from the numbers beside the
 * ticks. On screens of any size each setting has its method's letter where the axes put its error
 * and its work (or the letter of another setting that is there, too), and no letter stands anywhere
 * else. In a picture each setting has a mark of its method's colour there.
 */
#include "cmocka_testing.h"

#include "unit/axes_testing.h"
#include "unit/command/testing.h"
#include "modules/comparison/comparison.h"
#include "modules/pictures/svg_testing.h"
#include <hooke/plot/drawing.h>

#define STUDIES 30
/* [pt] a setting to the middle of the box around its mark: that of a triangle is off its centre */
#define MARK_NEAR 0.8

static const char *const methods[] = {"euler", "symplectic-euler", "verlet", "rk4",
                                      "pefrl", "dopri5",           "radau5", "heun"};

/* A study of one to four methods, over evaluations or time. */
static const struct precision *make_study(struct bench *bench, struct dice *dice, char told[400])
{
    static const char *const scenes[] = {"spring", "damped", "duffing", "pendulum"};
    int n = snprintf(told, 400, "scene %s; timing %s; duration = %.2g; precision%s",
                     scenes[dice_below(dice, 4)], dice_below(dice, 3) ? "off" : "quick",
                     dice_between(dice, 0.5, 5), dice_below(dice, 3) ? "" : " evaluations");
    const int count = 1 + dice_below(dice, 4), first = dice_below(dice, 8);
    for (int i = 0; i < count; i++)
        n += snprintf(told + n, 400 - (size_t)n, " %s", methods[(first + 3 * i) % 8]);
    if (dice_below(dice, 2))
        snprintf(told + n, 400 - (size_t)n, " dt=%.3g:%.3g", dice_between(dice, 1e-3, 1e-2),
                 dice_between(dice, 0.02, 0.5));
    type_ok(bench, told);
    const struct precision *precision = session_precision(bench->session);
    assert_non_null(precision);
    return precision;
}

/* What the point took, in the unit of the horizontal axis; NAN if it is not said. */
static double work_of(const struct precision *precision, const struct precision_point *point)
{
    bool timed = false;
    for (int i = 0; i < precision->points; i++)
        timed |= isfinite(precision->point[i].time.minimum);
    return timed && !precision->by_evals ? point->time.minimum : (double)point->cost.evals;
}

/* ---- on a screen ---- */

static bool stands_at(const struct reader *r, const double spot[4], uint32_t letter)
{
    for (int y = (int)ceil(spot[1] - spot[3] - 0.51); y <= floor(spot[1] + spot[3] + 0.51); y++)
        for (int x = (int)ceil(spot[0] - spot[2] - 0.51); x <= floor(spot[0] + spot[2] + 0.51); x++)
            if (cell_at(r->canvas, x, y) == letter)
                return true;
    return false;
}

static bool spot_of(const struct reader *r, const struct precision *precision, int i,
                    double spot[4])
{
    const struct precision_point *point = &precision->point[i];
    if (!precision_meaningful(point) || !(work_of(precision, point) > 0) ||
        !(point->errors.max > 2e-16))
        return false;
    spot[0] = read_place(&r->x, work_of(precision, point), &spot[2]);
    spot[1] = read_place(&r->y, point->errors.max, &spot[3]);
    return true;
}

/* Every setting has its letter, or one that covers it. */
static void check_settings(const struct reader *r, const struct precision *precision,
                           const char *told)
{
    for (int i = 0; i < precision->points; i++) {
        double spot[4], other[4];
        if (!spot_of(r, precision, i, spot))
            continue;
        bool found = stands_at(r, spot, (uint32_t)precision_letter(precision->point[i].curve));
        for (int k = 0; k < precision->points && !found; k++)
            found = k != i && spot_of(r, precision, k, other) &&
                    fabs(other[0] - spot[0]) < 2 + spot[2] + other[2] &&
                    fabs(other[1] - spot[1]) < 2 + spot[3] + other[3] &&
                    stands_at(r, spot, (uint32_t)precision_letter(precision->point[k].curve));
        if (!found)
            fail_msg("%s: no '%c' at column %g, row %g", told,
                     precision_letter(precision->point[i].curve), spot[0], spot[1]);
    }
}

/* Every letter of a method stands at one of its settings. Returns how many there are. */
static int check_letters(const struct reader *r, const struct precision *precision,
                         const char *told)
{
    int letters = 0;
    for (int y = r->top + 1; y < r->axis_row; y++)
        for (int x = r->first; x <= r->last; x++) {
            const struct cell *cell = &r->canvas->cell[y * r->canvas->width + x];
            bool found = false;
            if (cell->codepoint < 'a' || cell->codepoint > 'z' || cell->style == STYLE_BOLD)
                continue;
            for (int i = 0; i < precision->points && !found; i++) {
                double spot[4];
                found = precision_letter(precision->point[i].curve) == (char)cell->codepoint &&
                        spot_of(r, precision, i, spot) && fabs(spot[0] - x) < 0.51 + spot[2] &&
                        fabs(spot[1] - y) < 0.51 + spot[3];
            }
            if (!found)
                fail_msg("%s: '%c' at column %d, row %d, where no setting is", told,
                         (char)cell->codepoint, x, y);
            letters++;
        }
    return letters;
}

static void draw_study(struct bench *bench, struct arena *arena, const char *told,
                       struct figure *figure)
{
    struct error error = {0};
    const struct figure_request request = {
        .kind = (enum plot_kind)catalog_index(&plot_catalog,
                                              catalog_find(&plot_catalog, TEXT("precision"))),
        .recording = -1,
        .width = 80,
        .charset = &charset_braille};
    if (!session_figure(bench->session, &request, arena, figure, &error))
        fail_msg("%s: %s", told, error.text);
}

TEST(test_marks_on_screens)
{
    struct dice dice = {4711};
    int read = 0, letters = 0;
    for (int study = 0; study < STUDIES; study++) {
        struct bench bench;
        struct arena arena = {0};
        struct figure figure;
        struct canvas canvas;
        char told[400];
        bench_open(&bench, false);
        const struct precision *precision = make_study(&bench, &dice, told);
        draw_study(&bench, &arena, told, &figure);
        const int width = 40 + dice_below(&dice, 100), height = 12 + dice_below(&dice, 30);
        assert_true(canvas_init(&canvas, width, height));
        assert_true(figure_draw(&figure, &canvas, 0, 0, width, height,
                                dice_below(&dice, 2) ? &charset_braille : &charset_ascii));
        struct reader reader = {.canvas = &canvas,
                                .right = width - 1,
                                .bottom = height - 1,
                                .axis_row = height - 3,
                                .x.log = true};
        /* skip screens whose axis labels cannot be read: several per decade, or too few */
        if (read_x_axis(&reader, 1) && read_y_axis(&reader, 1, true)) {
            check_settings(&reader, precision, told);
            letters += check_letters(&reader, precision, told);
            read++;
        }
        canvas_free(&canvas);
        arena_reset(&arena);
        bench_close(&bench);
    }
    assert_true(read > STUDIES / 2 && letters > 5 * STUDIES);
}

/* ---- in a picture ---- */

#define MARKS_MAX 2000

struct marks {
    double x[MARKS_MAX], y[MARKS_MAX];
    int look[MARKS_MAX], n;
};

static int look_of(const char *stroke)
{
    static const char *const colors[] = {"#0072b2", "#1a1a1a", "#e69f00", "#009e73"};
    for (int i = 0; i < (int)COUNT_OF(colors); i++)
        if (strcmp(stroke, colors[i]) == 0)
            return i;
    return -1;
}

static void read_marks(const char *svg, struct reader *r, struct marks *marks)
{
    static struct svg_path path;
    struct svg_element element;
    struct read_axis *tick = NULL;
    double place = 0;
    bool framed = false;
    marks->n = 0;
    for (const char *at = NULL; svg_next(svg, &at, &element, &path);) {
        const bool black = strcmp(element.stroke, "#000000") == 0 && !element.filled;
        if (element.is_text && tick && tick->n < TICKS_MAX) {
            tick->at[tick->n] = place;
            tick->value[tick->n++] = svg_value(element.text);
        }
        tick = NULL;
        if (element.is_text)
            continue;
        if (look_of(element.stroke) >= 0 && (element.filled || path.closed) && path.n > 0) {
            double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
            for (int i = 0; i < path.n; i++) {
                low[0] = fmin(low[0], path.x[i]);
                high[0] = fmax(high[0], path.x[i]);
                low[1] = fmin(low[1], path.y[i]);
                high[1] = fmax(high[1], path.y[i]);
            }
            assert_true(marks->n < MARKS_MAX);
            marks->look[marks->n] = look_of(element.stroke);
            marks->x[marks->n] = (low[0] + high[0]) / 2;
            marks->y[marks->n++] = (low[1] + high[1]) / 2;
        } else if (black && path.n >= 4) {
            framed = true;
        } else if (black && framed && path.n == 2) {
            const bool vertical = path.y[0] == path.y[1];
            const double length = fabs(vertical ? path.x[1] - path.x[0] : path.y[1] - path.y[0]);
            tick = length < 3 ? NULL : vertical ? &r->y : &r->x;
            place = vertical ? path.y[0] : path.x[0];
        }
    }
    r->x.log = r->y.log = true;
    r->x.unit = r->y.unit = 1;
}

static char *read_file(const char *name)
{
    FILE *file = fopen(name, "rb");
    char *content = NULL;
    size_t size = 0;
    assert_non_null(file);
    assert_true(getdelim(&content, &size, '\0', file) > 0);
    assert_int_equal(fclose(file), 0);
    return content;
}

TEST(test_marks_in_pictures)
{
    static struct marks marks;
    struct dice dice = {1174};
    int checked = 0;
    for (int study = 0; study < STUDIES; study++) {
        struct bench bench;
        struct reader reader = {.canvas = NULL};
        char told[400];
        bench_open(&bench, false);
        const struct precision *precision = make_study(&bench, &dice, told);
        type_ok(&bench, "plot precision > figure.svg --force");
        char *svg = read_file("figure.svg");
        read_marks(svg, &reader, &marks);
        for (int i = 0; i < precision->points && reader.x.n > 1 && reader.y.n > 1; i++) {
            double spot[4], nearest = HUGE_VAL;
            if (!spot_of(&reader, precision, i, spot))
                continue;
            for (int k = 0; k < marks.n; k++)
                if (marks.look[k] == precision->point[i].curve)
                    nearest = fmin(nearest, hypot(marks.x[k] - spot[0], marks.y[k] - spot[1]));
            if (!(nearest < MARK_NEAR))
                fail_msg("%s: %s has no mark at %.2f, %.2f pt: the next is %.2f pt away", told,
                         precision->curve[precision->point[i].curve].choice.method->row.name,
                         spot[0], spot[1], nearest);
            checked++;
        }
        free(svg);
        bench_close(&bench);
    }
    assert_true(checked > 5 * STUDIES);
}

/* ---- any study into a file ---- */

TEST(test_studies_draw_into_files)
{
    struct bench bench;
    bench_open(&bench, false);
    type_ok(&bench, "timing off; precision rk4 verlet dt=10ms:100ms > figure.svg --force");
    char *svg = read_file("figure.svg");
    assert_non_null(strstr(svg, "evaluations"));
    free(svg);
    assert_false(type(&bench, "precision rk4 dt=10ms:20ms > figure.svg"));
    assert_non_null(strstr(bench.err.data, "figure.svg exists"));
    bench_close(&bench);
}

RUN_TESTS(axes_folder_enter, axes_folder_leave)
