/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Special points of families whose points are known: pairs closer to each other than a step, what
 * runs say of them in ranges of all sizes, none where the parameter stands still, and where orbits
 * shrink to an equilibrium. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

#include <hooke/base/numeric.h>
#include "modules/dynamics/branches/verdict.h"

enum { LINE_MAX = 400 };

static struct typed_models *models;
static int verdicts[2]; /* open, confirmed */

static double between(uint64_t *seed, double from, double to)
{
    return from + (to - from) * random_fraction(seed);
}

/* Verified, too. */
static struct branch follow(const char *const *lines, double from, double to,
                            const struct solution *start)
{
    struct scene scene;
    struct branch branch;
    struct error error = {0};
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    const struct branch_request request = {.scene = &scene,
                                           .param = scene_param(&scene, "r"),
                                           .low = from,
                                           .high = to,
                                           .start = start};
    if (!branch_follow(&request, &branch, &error))
        fail_msg("%s: %s", lines[2], error.text);
    branch_verify(&request, &branch);
    return branch;
}

/* The special points are those, in that order, and no others. */
static void expect(const struct branch *branch, const char *line, enum special kind,
                   const double *wanted, int count, double tolerance)
{
    int found = 0;
    for (int i = 0; i < branch->count; i++) {
        const struct branch_point *point = &branch->point[i];
        if (point->special == SPECIAL_NONE || point->special >= SPECIAL_END)
            continue;
        if (found == count || point->special != kind ||
            fabs(point->solution.param[0] - wanted[found]) > tolerance)
            fail_msg("%s: a special point of kind %d at %.17g", line, (int)point->special,
                     point->solution.param[0]);
        if (point->verified < 0)
            fail_msg("%s: NO at %.17g: %s", line, point->solution.param[0],
                     branch_contradiction(point->verified));
        verdicts[point->verified > 0]++;
        found++;
    }
    if (found < count)
        fail_msg("%s: %d special points of %d", line, found, count);
}

/* r = a (x - c)^3/3 - e (x - c) + d: folds at x = c -+ s, s = sqrt(e/a), and r = d +- 2 e s/3. */
TEST(test_folds)
{
    uint64_t seed = 21;
    for (int k = 0; k < (is_long() ? 1000 : 80); k++) {
        char line[LINE_MAX];
        const double a = between(&seed, 0.3, 3), c = between(&seed, -0.5, 0.5),
                     d = between(&seed, -0.3, 0.3), e = pow(10, between(&seed, -5, -1.5)),
                     s = sqrt(e / a), range = pow(10, between(&seed, 0, 3));
        const double wanted[] = {d + 2 * e * s / 3, d - 2 * e * s / 3};
        double x = c - 3; /* where r is -1, by Newton's method from the left */
        for (int i = 0; i < 60; i++) {
            const double u = x - c;
            x -= (a * u * u * u / 3 - e * u + d + 1) / (a * u * u - e);
        }
        const struct solution start = {
            .kind = SOLUTION_EQUILIBRIUM, .n = 1, .param = {-1}, .state = {x}};
        snprintf(line, sizeof line, "x' = r-(%.17g*(x-(%.17g))^3/3-(%.17g)*(x-(%.17g))+(%.17g))", a,
                 c, e, c, d);
        struct branch branch = follow(
            (const char *const[]){"var x = 0", "param r = -1", line, NULL}, -range, range, &start);
        expect(&branch, line, SPECIAL_FOLD, wanted, 2, 1e-11 * range);
        branch_free(&branch);
    }
}

/* An equilibrium at 0 that is unstable while |r - d| < s, in one variable and in two. */
TEST(test_crossings)
{
    uint64_t seed = 22;
    for (int k = 0; k < (is_long() ? 500 : 40); k++) {
        char line[2][LINE_MAX];
        const bool turns = k % 2 == 1;
        const double d = between(&seed, -0.5, 0.5), s = pow(10, between(&seed, -3, -1)),
                     wanted[] = {d - s, d + s};
        const struct solution start = {
            .kind = SOLUTION_EQUILIBRIUM, .n = turns ? 2 : 1, .param = {-1}, .state = {0, 0}};
        snprintf(line[0], LINE_MAX, "x' = (%.17g-(r-(%.17g))^2)*x-x^3%s", s * s, d,
                 turns ? "-2*y" : "");
        snprintf(line[1], LINE_MAX, "y' = (%.17g-(r-(%.17g))^2)*y-y^3+2*x", s * s, d);
        const char *const lines[] = {"var x = 0",
                                     "param r = -1",
                                     turns ? "var y = 0" : line[0],
                                     turns ? line[0] : NULL,
                                     line[1],
                                     NULL};
        struct branch branch = follow(lines, -1, 1, &start);
        expect(&branch, line[0], turns ? SPECIAL_HOPF : SPECIAL_CROSSING, wanted, 2, 1e-9);
        branch_free(&branch);
    }
}

/* A test that comes near 0 and turns back has not passed it. */
TEST(test_none)
{
    uint64_t seed = 23;
    for (int k = 0; k < (is_long() ? 500 : 40); k++) {
        char line[LINE_MAX];
        const double a = between(&seed, 0.3, 3), e = pow(10, between(&seed, -7, -1));
        double x = -2;
        for (int i = 0; i < 60; i++)
            x -= (a * x * x * x / 3 + e * x + 1) / (a * x * x + e);
        const struct solution start = {
            .kind = SOLUTION_EQUILIBRIUM, .n = 1, .param = {-1}, .state = {x}};
        snprintf(line, sizeof line, "x' = r-(%.17g*x^3/3+%.17g*x)", a, e);
        struct branch branch =
            follow((const char *const[]){"var x = 0", "param r = -1", line, NULL}, -1, 1, &start);
        expect(&branch, line, SPECIAL_FOLD, NULL, 0, 0);
        branch_free(&branch);
    }
}

/* r exp(k (x - c)) = 1: the parameter goes to 0, and stands still there, but for rounding. */
TEST(test_standing_parameter)
{
    uint64_t seed = 24;
    for (int k = 0; k < (is_long() ? 500 : 40); k++) {
        char line[LINE_MAX];
        const double rate = between(&seed, 0.5, 8), c = between(&seed, -1, 1);
        const struct solution start = {
            .kind = SOLUTION_EQUILIBRIUM, .n = 1, .param = {1}, .state = {c}};
        snprintf(line, sizeof line, "x' = r*exp(%.17g*(x-(%.17g)))-1", rate, c);
        struct branch branch = follow((const char *const[]){"var x = 0", "param r = 1", line, NULL},
                                      k % 2 ? 0 : -between(&seed, 0, 2), 1, &start);
        expect(&branch, line, SPECIAL_FOLD, NULL, 0, 0);
        branch_free(&branch);
    }
}

/* Circles of radius sqrt((r - a)(b - r)), which are equilibria at a and at b. */
TEST(test_shrinking)
{
    uint64_t seed = 25;
    for (int k = 0; k < (is_long() ? 200 : 10); k++) {
        char line[2][LINE_MAX];
        const double a = between(&seed, -1, -0.3), b = between(&seed, 0.3, 1),
                     omega = between(&seed, 0.5, 3), radius = sqrt(-a * b);
        const struct solution start = {.kind = SOLUTION_ORBIT,
                                       .n = 2,
                                       .param = {0},
                                       .period = TWO_PI / omega,
                                       .state = {radius, 0}};
        for (int i = 0; i < 2; i++)
            snprintf(line[i], LINE_MAX, "%c' = ((r-(%.17g))*(%.17g-r)-x^2-y^2)*%c%c%.17g*%c",
                     "xy"[i], a, b, "xy"[i], "-+"[i], omega, "yx"[i]);
        const char *const lines[] = {"var x = 1", "var y = 0", "param r = 0",
                                     line[0],     line[1],     NULL};
        struct branch branch = follow(lines, -2, 2, &start);
        const double ends[] = {branch.point[0].solution.param[0],
                               branch.point[branch.count - 1].solution.param[0]};
        for (int i = 0; i < 2; i++) {
            assert_string_equal(branch.ends[i], "it shrinks to an equilibrium");
            close_to(ends[i], i == 0 ? a : b, 1e-4);
        }
        branch_free(&branch);
    }
}

/* Nearly all of the labels above were confirmed, none contradicted. */
TEST(test_verdicts)
{
    print_message("%d labels confirmed, %d open\n", verdicts[1], verdicts[0]);
    assert_true(verdicts[1] > 20 * verdicts[0]);
}

static int set_up(void **state)
{
    struct error error;
    (void)state;
    models = typed_create(&error);
    return models ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    typed_destroy(models);
    return 0;
}

RUN_TESTS(set_up, tear_down)
