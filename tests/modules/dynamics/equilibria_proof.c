/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Equilibria of random scenes whose zeros are known: products of linear factors with close pairs
 * and double zeros, in rotated coordinates too, and rational ones with poles. Whatever is said to
 * be proven must be so, and regular zeros are found beside what cannot be decided.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

#include <hooke/base/numeric.h>

enum { ZEROS_MAX = 16, LINE_MAX = 600 };

static struct typed_models *models;

/* Zeros of a scene, and how far from them what is found may be. */
struct known_zeros {
    int n, count;
    double state[ZEROS_MAX][2], tolerance;
    bool twofold[ZEROS_MAX]; /* not simple: no proof is possible */
};

static double between(uint64_t *seed, double from, double to)
{
    return from + (to - from) * random_fraction(seed);
}

static struct equilibria find(char line[][LINE_MAX], const struct known_zeros *known, double range)
{
    const char *lines[] = {"var x = 0.1", line[0], known->n == 2 ? line[1] : NULL, line[2], NULL};
    struct scene scene;
    struct error error = {0};
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    struct equilibria_request request = {.scene = &scene};
    for (int i = 0; i < known->n; i++) {
        request.box[i][0] = -range;
        request.box[i][1] = range;
    }
    struct equilibria found;
    if (!equilibria_find(&request, &found, &error))
        fail_msg("%s: %s", line[0], error.text);
    return found;
}

/* Fails unless each zero found is a known one, none is found twice (except degenerate ones, which
 * are `twofold`), every simple one is found, and a list that claims to be complete has all and no
 * degenerate one. With proof_expected, it has to claim that. */
static void judge(char line[][LINE_MAX], const struct known_zeros *known,
                  const struct equilibria *found, bool proof_expected)
{
    bool taken[ZEROS_MAX] = {false};
    int twofold = 0;
    for (int k = 0; k < found->count; k++) {
        int best = -1;
        double least = HUGE_VAL;
        for (int j = 0; j < known->count; j++) {
            const double apart = hypot(found->solution[k].state[0] - known->state[j][0],
                                       found->solution[k].state[1] - known->state[j][1]);
            if (apart < least && (!taken[j] || known->twofold[j])) {
                least = apart;
                best = j;
            }
        }
        const bool degenerate = best >= 0 && known->twofold[best];
        if (!(least < (degenerate ? 1e-6 : known->tolerance)))
            fail_msg("%s | %s: %.17g, %.17g is no zero (by %g)", line[0], line[1],
                     found->solution[k].state[0], found->solution[k].state[1], least);
        taken[best] = true;
    }
    for (int j = 0; j < known->count; j++) {
        twofold += known->twofold[j];
        if (!taken[j] && !known->twofold[j])
            fail_msg("%s | %s: %.17g, %.17g is missing (%s)", line[0], line[1], known->state[j][0],
                     known->state[j][1], found->reason);
    }
    if (found->complete && (twofold > 0 || found->count != known->count))
        fail_msg("%s | %s: proven, %d of %d", line[0], line[1], found->count, known->count);
    if (proof_expected && !found->complete)
        fail_msg("%s | %s: %s", line[0], line[1], found->reason);
}

static void add_zero(struct known_zeros *known, double x, double y, bool twofold)
{
    known->state[known->count][0] = x;
    known->state[known->count][1] = y;
    known->twofold[known->count++] = twofold;
}

/* Pairs 1e-8 to 1e-6 apart, beside another zero. */
TEST(test_pairs)
{
    uint64_t seed = 3;
    for (int k = 0; k < (is_long() ? 2000 : 60); k++) {
        struct known_zeros known = {.n = 1, .tolerance = 1e-9};
        char line[3][LINE_MAX] = {""};
        const double a = between(&seed, -4, 4), b = a + pow(10, between(&seed, -8, -6)),
                     c = between(&seed, -4, 4);
        add_zero(&known, a, 0, false);
        add_zero(&known, b, 0, false);
        add_zero(&known, c, 0, false);
        snprintf(line[0], LINE_MAX, "x' = %.3g*(x-(%.17g))*(x-(%.17g))*(x-(%.17g))",
                 pow(10, between(&seed, -3, 3)), a, b, c);
        struct equilibria found = find(line, &known, 5);
        judge(line, &known, &found, true);
        equilibria_free(&found);
    }
}

/* In the plane: (u - a)(u - b) = 0 and v = c, with u, v rotated. */
TEST(test_pairs_in_the_plane)
{
    uint64_t seed = 4;
    for (int k = 0; k < (is_long() ? 500 : 40); k++) {
        struct known_zeros known = {.n = 2, .tolerance = 1e-8};
        char line[3][LINE_MAX] = {"var y = 0.1"};
        const double angle = between(&seed, 0.1, 1.4), co = cos(angle), si = sin(angle),
                     a = between(&seed, -2, 2), b = a + pow(10, between(&seed, -7.5, -6)),
                     c = between(&seed, -2, 2);
        add_zero(&known, co * a - si * c, si * a + co * c, false);
        add_zero(&known, co * b - si * c, si * b + co * c, false);
        snprintf(line[1], LINE_MAX, "x' = (%.17g*x+%.17g*y-(%.17g))*(%.17g*x+%.17g*y-(%.17g))", co,
                 si, a, co, si, b);
        snprintf(line[2], LINE_MAX, "y' = %.17g*y-%.17g*x-(%.17g)", co, si, c);
        struct equilibria found = find(line, &known, 5);
        judge(line, &known, &found, false);
        equilibria_free(&found);
    }
}

/* A double zero has no proof, but the simple ones beside it are found. */
TEST(test_double_zeros)
{
    uint64_t seed = 5;
    for (int k = 0; k < (is_long() ? 500 : 40); k++) {
        struct known_zeros known = {.n = 1, .tolerance = 1e-9};
        char line[3][LINE_MAX] = {""};
        const double a = between(&seed, -4, 4), c = a + between(&seed, 0.01, 1);
        add_zero(&known, a, 0, true);
        add_zero(&known, c, 0, false);
        if (k % 2 == 1)
            snprintf(line[0], LINE_MAX, "x' = (x-(%.17g))^2*(x-(%.17g))", a, c);
        else
            snprintf(line[0], LINE_MAX, "x' = (x^2-2*(%.17g)*x+(%.17g)^2)*(x-(%.17g))", a, a, c);
        struct equilibria found = find(line, &known, 6);
        judge(line, &known, &found, false);
        assert_false(found.complete);
        equilibria_free(&found);
    }
}

/* Quotients: what their poles leave undecided does not hide any zero. */
TEST(test_poles)
{
    uint64_t seed = 6;
    for (int k = 0; k < (is_long() ? 300 : 30); k++) {
        const bool plane = k % 2 == 1;
        struct known_zeros known = {.n = plane ? 2 : 1, .tolerance = 1e-9};
        char line[3][LINE_MAX] = {""};
        const double p = between(&seed, -2, 2), a = p + between(&seed, 0.02, 2),
                     b = p - between(&seed, 0.02, 2), c = between(&seed, -3, 3),
                     d = between(&seed, 0.5, 2);
        add_zero(&known, a, plane ? c + d * a : 0, false);
        add_zero(&known, b, plane ? c + d * b : 0, false);
        snprintf(line[plane], LINE_MAX, "x' = (x-(%.17g))*(x-(%.17g))/(x-(%.17g))", a, b, p);
        if (plane) {
            snprintf(line[0], LINE_MAX, "var y = 0.1");
            snprintf(line[2], LINE_MAX, "y' = %.17g+%.17g*x-y", c, d);
        }
        struct equilibria found = find(line, &known, 50);
        judge(line, &known, &found, true);
        equilibria_free(&found);
    }
}

/* Prey x and predators y of Rosenzweig and MacArthur: the equilibria are (0, 0), prey alone at
 * (K, 0), and both species at x = m/(1 - m), y = (1 - x/K)(1 + x). */
TEST(test_predators)
{
    uint64_t seed = 7;
    for (int k = 0; k < (is_long() ? 60 : 4); k++) {
        struct known_zeros known = {.n = 2, .tolerance = 1e-8};
        char line[3][LINE_MAX] = {"var y = 0.1"};
        const double K = between(&seed, 2, 10), m = between(&seed, 0.2, 0.6), x = m / (1 - m);
        add_zero(&known, 0, 0, false);
        add_zero(&known, K, 0, false);
        add_zero(&known, x, (1 - x / K) * (1 + x), false);
        snprintf(line[1], LINE_MAX, "x' = x*(1-x/%.17g)-x*y/(1+x)", K);
        snprintf(line[2], LINE_MAX, "y' = x*y/(1+x)-%.17g*y", m);
        struct equilibria found = find(line, &known, 50);
        judge(line, &known, &found, false);
        equilibria_free(&found);
    }
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
