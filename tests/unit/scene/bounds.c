/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of expressions contain what they bound; searches that go by them find every root. */
#include "long_form.h"
#include "unit/scene/testing.h"

#include "scene/formula/outer.h"

#include <math.h>
#include <stdlib.h>

/* As text that ends. */
static const char *shown(struct buffer *text)
{
    buffer_put(text, TEXT(""));
    return text->data;
}

static bool find(const void *context, struct text name, int *slot)
{
    (void)context;
    *slot = name.len == 1 && name.data[0] >= 'a' && name.data[0] <= 'c' ? name.data[0] - 'a' : -1;
    return *slot >= 0;
}

static double load(const void *context, int slot)
{
    return ((const double *)context)[slot];
}

/* ---- random expressions ---- */

static void write_random(uint64_t *seed, int depth, struct buffer *text)
{
    static const char *const one[] = {"sin",  "cos",  "tan",  "asin",  "acos", "atan", "sinh",
                                      "cosh", "tanh", "sqrt", "cbrt",  "exp",  "log",  "log10",
                                      "abs",  "sign", "step", "floor", "ceil", "round"};
    static const char *const two[] = {"atan2", "hypot", "min", "max", "mod"};
    static const char *const power[] = {"2", "3",   "-1",   "0.5", "-1.5",
                                        "4", "2.3", "(-2)", "0",   "a"};
    const int kind = depth == 0 ? (int)(4 * random_unit(seed)) : 4 + (int)(14 * random_unit(seed));
    if (kind < 3) {
        buffer_char(text, (char)('a' + kind));
    } else if (kind == 3) {
        buffer_format(text, "(%.3g)", random_between(seed, -3, 3));
    } else if (kind < 8) {
        buffer_char(text, '(');
        write_random(seed, depth - 1, text);
        buffer_char(text, "+-*/"[kind - 4]);
        write_random(seed, depth - 1, text);
        buffer_char(text, ')');
    } else if (kind < 13) {
        buffer_format(text, "%s(", one[(size_t)(random_unit(seed) * (double)COUNT_OF(one))]);
        write_random(seed, depth - 1, text);
        buffer_char(text, ')');
    } else if (kind < 15) {
        buffer_format(text, "%s(", two[(size_t)(random_unit(seed) * (double)COUNT_OF(two))]);
        write_random(seed, depth - 1, text);
        buffer_char(text, ',');
        write_random(seed, depth - 1, text);
        buffer_char(text, ')');
    } else if (kind == 15) {
        buffer_put(text, TEXT("if("));
        write_random(seed, depth - 1, text);
        buffer_put(text, TEXT("<"));
        write_random(seed, depth - 1, text);
        buffer_char(text, ',');
        write_random(seed, depth - 1, text);
        buffer_char(text, ',');
        write_random(seed, depth - 1, text);
        buffer_char(text, ')');
    } else {
        buffer_char(text, '(');
        write_random(seed, depth - 1, text);
        buffer_format(text, ")^%s", power[(size_t)(random_unit(seed) * (double)COUNT_OF(power))]);
    }
}

/* Sums, products, quotients and powers of names and numbers. */
static void write_rational(uint64_t *seed, int depth, struct buffer *text)
{
    const int kind = (int)((depth == 0 ? 4 : 9) * random_unit(seed));
    if (depth == 0 && kind == 3) {
        buffer_format(text, "(%.3g)", random_between(seed, -3, 3));
    } else if (depth == 0) {
        buffer_char(text, (char)('a' + kind));
    } else {
        buffer_char(text, '(');
        write_rational(seed, depth - 1, text);
        if (kind == 8) {
            buffer_format(text, "^(%d)", (int)random_between(seed, -3, 4));
        } else {
            buffer_char(text, "+-*////"[kind % 7]);
            write_rational(seed, depth - 1, text);
        }
        buffer_char(text, ')');
    }
}

static const struct expr *random_expr(uint64_t *seed, struct arena *arena, struct buffer *text)
{
    const struct expr_scope scope = {.find = find};
    struct error error = {0};
    size_t used;
    buffer_clear(text);
    write_random(seed, 1 + (int)(3 * random_unit(seed)), text);
    const struct expr *expr = expr_compile(buffer_text(text), &scope, arena, &used, &error);
    if (!expr)
        fail_msg("%s: %s", shown(text), error.text);
    return expr;
}

/* a, b, c as parabolas in x about 0, and their bounds for |x| <= r. */
struct names {
    double c[3][3];
};

static void names_at(const struct names *names, double x, double *value)
{
    for (int i = 0; i < 3; i++)
        value[i] = names->c[i][0] + x * (names->c[i][1] + x * names->c[i][2]);
}

static struct jet name_jet(const double *c, double a, double b)
{
    const double p = c[0] + a * (c[1] + a * c[2]), q = c[0] + b * (c[1] + b * c[2]),
                 at = -c[1] / (2 * c[2]);
    const double turn = c[2] != 0 && at > a && at < b ? c[0] + at * (c[1] + at * c[2]) : p;
    const double ga = c[1] + 2 * a * c[2], gb = c[1] + 2 * b * c[2],
                 near = 1e-14 * (fabs(p) + fabs(q) + fabs(c[1]));
    return (struct jet){{fmin(fmin(p, q), turn) - near, fmax(fmax(p, q), turn) + near},
                        {fmin(ga, gb) - near, fmax(ga, gb) + near},
                        {2 * c[2], 2 * c[2]}};
}

static double value_at(const struct expr *expr, const struct names *names, double x)
{
    double value[3];
    names_at(names, x, value);
    const struct expr_scope scope = {.context = value, .load = load};
    return expr_value(expr, &scope);
}

/* hypot(NaN, infinity) is infinite. */
static bool inside(struct interval bounds, double value, double slack)
{
    return value != value || (isinf(value) && interval_empty(bounds)) ||
           (bounds.lo - slack <= value && value <= bounds.hi + slack);
}

static bool in_outer(struct outer bounds, double value)
{
    if (!bounds.has_gap)
        return inside(bounds.interval, value, 0);
    return value != value || value <= bounds.interval.lo || value >= bounds.interval.hi;
}

/* Bounds of a rational expression near a pole are all numbers but a gap, an open interval. Values
 * at corners and random points of the box must lie within the bounds. */
TEST(test_gaps)
{
    uint64_t seed = 9;
    struct buffer text = {0};
    const int count = is_long() ? 100000 : 5000;
    long gaps = 0;
    for (int k = 0; k < count; k++) {
        const struct expr_scope scope = {.find = find};
        struct arena arena = {0};
        struct error error = {0};
        size_t used;
        double from[3], to[3];
        struct jet jet[3];
        buffer_clear(&text);
        write_rational(&seed, 1 + (int)(3 * random_unit(&seed)), &text);
        const struct expr *expr = expr_compile(buffer_text(&text), &scope, &arena, &used, &error);
        if (!expr)
            fail_msg("%s: %s", shown(&text), error.text);
        for (int i = 0; i < 3; i++) {
            from[i] = random_between(&seed, -2, 1);
            to[i] = from[i] + pow(10, random_between(&seed, -3, 0.5));
            jet[i] = jet_number(0);
            jet[i].value = (struct interval){from[i], to[i]};
            jet[i].slope = interval_point(1);
        }
        const struct outer bounds = expr_outer(expr, jet);
        gaps += bounds.has_gap;
        for (int point = 0; point < 20; point++) {
            double value[3];
            for (int i = 0; i < 3; i++)
                value[i] = point < 8 ? (point >> i & 1 ? to : from)[i]
                                     : random_between(&seed, from[i], to[i]);
            const struct expr_scope at = {.context = value, .load = load};
            const double f = expr_value(expr, &at);
            if (!in_outer(bounds, f))
                fail_msg("%s: %.17g is not in %s%.17g, %.17g", shown(&text), f,
                         bounds.has_gap ? "all but " : "", bounds.interval.lo, bounds.interval.hi);
        }
        arena_reset(&arena);
    }
    buffer_free(&text);
    print_message("%ld of %d have a gap\n", gaps, count);
    assert_true(gaps > count / 20);
}

/* Values are inside; so are slopes between two points, which are a slope somewhere, and second
 * differences. */
TEST(test_inclusion)
{
    uint64_t seed = 7;
    struct buffer text = {0};
    const int count = is_long() ? 100000 : 5000;
    long useful = 0;
    for (int k = 0; k < count; k++) {
        struct arena arena = {0};
        const struct expr *expr = random_expr(&seed, &arena, &text);
        struct names names;
        for (int i = 0; i < 9; i++)
            names.c[i / 3][i % 3] =
                i % 3 && random_unit(&seed) < 0.2 ? 0 : random_between(&seed, -3, 3);
        const double b = pow(10, random_between(&seed, -4, 0)), a = -b;
        struct jet jet[3], centre[3];
        for (int i = 0; i < 3; i++) {
            jet[i] = name_jet(names.c[i], a, b);
            centre[i] = name_jet(names.c[i], 0, 0);
        }
        const struct jet bounds = expr_jet(expr, jet), about = expr_jet_about(expr, jet, centre, b);
        const struct outer outer = expr_outer(expr, jet);
        useful += bounds.bend.lo > -HUGE_VAL && bounds.bend.hi < HUGE_VAL;
        for (int point = 0; point < 5; point++) {
            const double x = random_between(&seed, a, b), y = random_between(&seed, a, b),
                         m = x + (y - x) / 2;
            const double fx = value_at(expr, &names, x), fy = value_at(expr, &names, y);
            const double fm = value_at(expr, &names, m), w = (y - x) / 2;
            const double rounding = 1e-14 * (fabs(fx) + fabs(fy) + fabs(fm));
            if (!inside(about.value, fx, 0) || about.value.lo < bounds.value.lo ||
                about.value.hi > bounds.value.hi)
                fail_msg("%s: %.17g outside of %.17g .. %.17g about the centre", shown(&text), fx,
                         about.value.lo, about.value.hi);
            if (!in_outer(outer, fx))
                fail_msg("%s: %.17g in the gap or outside of %.17g .. %.17g", shown(&text), fx,
                         outer.interval.lo, outer.interval.hi);
            if (!inside(bounds.value, fx, 0))
                fail_msg("%s: %.17g outside of %.17g .. %.17g", shown(&text), fx, bounds.value.lo,
                         bounds.value.hi);
            if (isfinite(fx + fy + fm) && isfinite(bounds.slope.lo) && isfinite(bounds.slope.hi) &&
                !inside(bounds.slope, (fy - fx) / (y - x), 1e4 * rounding / fabs(y - x) + 1e-300))
                fail_msg("%s: slope %.17g outside of %.17g .. %.17g", shown(&text),
                         (fy - fx) / (y - x), bounds.slope.lo, bounds.slope.hi);
            if (isfinite(fx + fy + fm) && isfinite(bounds.bend.lo) && isfinite(bounds.bend.hi) &&
                !inside(bounds.bend, (fx - 2 * fm + fy) / (w * w),
                        1e4 * rounding / (w * w) + 1e-300))
                fail_msg("%s: bend %.17g outside of %.17g .. %.17g", shown(&text),
                         (fx - 2 * fm + fy) / (w * w), bounds.bend.lo, bounds.bend.hi);
        }
        arena_reset(&arena);
    }
    assert_true(useful > count / 5); /* bounds that say something */
    buffer_free(&text);
}

/* ---- roots ---- */

enum { ROOTS_MAX = 4096 };

struct problem {
    const struct expr *expr; /* in a, which is x */
    double at[ROOTS_MAX];
    int sign[ROOTS_MAX], count;
};

static double problem_value(void *context, double x)
{
    const struct problem *problem = context;
    const double value[3] = {x, 0, 0};
    const struct expr_scope scope = {.context = value, .load = load};
    return expr_value(problem->expr, &scope);
}

static struct jet problem_bounds(void *context, double a, double b)
{
    const struct problem *problem = context;
    const struct jet jet[3] = {
        {{a, b}, {1, 1}, {0, 0}}, {{0, 0}, {0, 0}, {0, 0}}, {{0, 0}, {0, 0}, {0, 0}}};
    return expr_jet(problem->expr, jet);
}

static bool problem_found(void *context, double x, int sign)
{
    struct problem *problem = context;
    assert_true(problem->count < ROOTS_MAX);
    problem->at[problem->count] = x;
    problem->sign[problem->count++] = sign;
    return true;
}

static bool problem_touches(void *context, double x)
{
    return fabs(problem_value(context, x)) < 1e-14;
}

static struct root_search search(struct problem *problem, bool touching)
{
    struct root_search search = {.context = problem,
                                 .value = problem_value,
                                 .bounds = problem_bounds,
                                 .found = problem_found,
                                 .touches = touching ? problem_touches : NULL,
                                 .min = 0x1p-52,
                                 .budget = 4000};
    const double f0 = problem_value(problem, 0);
    search.sign = (f0 > 0) - (f0 < 0);
    problem->count = 0;
    roots_find(&search, 0, f0, 1, problem_value(problem, 1));
    return search;
}

static void compile(struct problem *problem, const char *text, struct arena *arena)
{
    const struct expr_scope scope = {.find = find};
    struct error error = {0};
    size_t used;
    problem->expr = expr_compile(text_of(text), &scope, arena, &used, &error);
    if (!problem->expr)
        fail_msg("%s: %s", text, error.text);
}

TEST(test_roots)
{
    static const struct {
        const char *text;
        int passes, touches;
        bool unsure;
    } row[] = {
        {"sin(2000*a + 1)", 636, 0, false},
        {"(a-0.5)^2", 0, 1, false},
        {"(a-0.5)*(a-0.5)", 0, 1, false},
        {"(a-0.3)*(a-0.300001)", 2, 0, false},
        {"(a-0.3)*(a-0.300001)*(a-0.300002)", 3, 0, false},
        {"(a-0.3)^3", 1, 0, false},
        {"(a-0.3)^4", 0, 1, false},
        {"(a-0.25)^2*(a-0.5)", 1, 1, false},
        {"1 - cos(20*pi*a)", 0, 10, false}, /* at the ends, too; that at 0 is where it begins */
        {"exp(-1e4*(a-0.61234)^2) - 0.5", 2, 0, false},
        {"floor(3*a) - 1.5", 1, 0, false},
        {"1/(a-0.3)", 1, 0, false},
        {"abs(a-0.3) - 1e-9", 2, 0, false},
        {"sqrt(a-0.7) - 0.2", 1, 0, false},
        {"sqrt(-1-a)", 0, 0, false},
        {"max(a-0.2, 0.1-a) + 0.051", 0, 0, false},
        {"a^2 + 1e-12", 0, 0, false},
        {"mod(a, 0.1) - 0.05", 19, 0, false}};
    (void)state;
    static struct problem problem;
    for (size_t i = 0; i < COUNT_OF(row); i++) {
        struct arena arena = {0};
        compile(&problem, row[i].text, &arena);
        const struct root_search plain = search(&problem, false);
        if (problem.count != row[i].passes || plain.unsure != row[i].unsure)
            fail_msg("%s: %d roots, unsure %d", row[i].text, problem.count, plain.unsure);
        search(&problem, true);
        int touches = 0;
        for (int k = 0; k < problem.count; k++)
            touches += problem.sign[k] == 0;
        if (touches < row[i].touches || touches > row[i].touches + 1 ||
            problem.count - touches != row[i].passes)
            fail_msg("%s: touches %d times, passes %d", row[i].text, touches,
                     problem.count - touches);
        arena_reset(&arena);
    }
}

static bool any(void *context, double x, int sign)
{
    (void)context;
    return x >= 0 && sign <= 1;
}

/* What has no end of roots is not said to be complete. */
TEST(test_unsure)
{
    static const char *const text[] = {"sin(1/(a-0.5))", "a*sin(1e7*a)"};
    (void)state;
    static struct problem problem;
    for (size_t i = 0; i < COUNT_OF(text); i++) {
        struct arena arena = {0};
        compile(&problem, text[i], &arena);
        struct root_search found = {.context = &problem,
                                    .value = problem_value,
                                    .bounds = problem_bounds,
                                    .min = 0x1p-52,
                                    .budget = 100,
                                    .sign = 1};
        found.found = any;
        roots_find(&found, 0, problem_value(&problem, 0), 1, problem_value(&problem, 1));
        assert_true(found.unsure && found.unsure_from > 0 && found.unsure_from < 1);
        arena_reset(&arena);
    }
}

/* 200 random functions against so many looks that none of theirs is overlooked, as far as looks can
 * tell. */
TEST(test_random)
{
    enum { LOOKS = 200000 };
    const int problems = is_long() ? 200 : 40;
    uint64_t seed = 11;
    struct buffer text = {0};
    static struct problem problem;
    int roots = 0;
    for (int k = 0; k < problems; k++) {
        struct arena arena = {0};
        buffer_clear(&text);
        buffer_format(&text, "%.6g", random_between(&seed, -1, 1));
        const int terms = 2 + (int)(3 * random_unit(&seed));
        for (int i = 0; i < terms; i++) {
            const double c = random_between(&seed, -2, 2), w = random_between(&seed, 1, 60),
                         p = random_unit(&seed);
            switch ((int)(6 * random_unit(&seed))) {
            case 0:
                buffer_format(&text, " + (%.6g)*sin(%.6g*a + %.6g)", c, w, p);
                break;
            case 1:
                buffer_format(&text, " + (%.6g)*cos(%.6g*a^2 + %.6g)", c, w, p);
                break;
            case 2:
                buffer_format(&text, " + (%.6g)*exp(-%.6g*(a-%.6g)^2)", c, w, p);
                break;
            case 3:
                buffer_format(&text, " + (%.6g)*abs(sin(%.6g*a)-%.6g)", c, w, p);
                break;
            case 4:
                buffer_format(&text, " + (%.6g)*tanh(%.6g*(a-%.6g))", c, w, p);
                break;
            default:
                buffer_format(&text, " + (%.6g)*min(%.6g*a-7, %.6g)", c, w, p);
            }
        }
        compile(&problem, shown(&text), &arena);
        assert_false(search(&problem, false).unsure);
        int count = 0, sign = 0;
        for (int i = 0; i <= LOOKS; i++) {
            const double f = problem_value(&problem, (double)i / LOOKS);
            const int now = (f > 0) - (f < 0);
            count += now != 0 && sign != 0 && now != sign;
            sign = now != 0 ? now : sign;
        }
        if (count != problem.count)
            fail_msg("%s: %d roots, looks find %d", shown(&text), problem.count, count);
        for (int i = 1; i < problem.count; i++)
            assert_true(problem.at[i] >= problem.at[i - 1] &&
                        problem.sign[i] == -problem.sign[i - 1]);
        roots += count;
        arena_reset(&arena);
    }
    assert_true(roots > 4 * problems);
    buffer_free(&text);
}

RUN_TESTS(NULL, NULL)
