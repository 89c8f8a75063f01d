/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Special points where a branch begins, ends or turns by no more than rounding: none is lost, none
 * is made up, and none is contradicted.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

static struct typed_models *models;

struct landing {
    const char *lines[10], *param;
    double from, to;
    enum solution_kind kind;
    int n;
    double start, state[3];
    enum special special; /* all of this kind, and there are no others: */
    int count;
    double value;
};

static struct branch follow(const struct landing *l, const struct branch_point *leave)
{
    struct scene scene;
    struct branch branch;
    struct error error = {0};
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, l->lines));
    scene.value[scene_param(&scene, l->param)] = l->start;
    struct solution start = {
        .kind = l->kind, .n = l->n, .param = {l->start}, .multiple = l->kind == SOLUTION_RESPONSE};
    memcpy(start.state, l->state, sizeof l->state);
    const struct branch_request request = {.scene = &scene,
                                           .param = scene_param(&scene, l->param),
                                           .low = l->from,
                                           .high = l->to,
                                           .start = &start,
                                           .leave = leave};
    if (!branch_follow(&request, &branch, &error))
        fail_msg("%s: %s", l->lines[3] ? l->lines[3] : l->lines[2], error.text);
    branch_verify(&request, &branch);
    return branch;
}

static void check(const struct landing *l)
{
    struct branch branch = follow(l, NULL);
    int count = 0;
    for (int i = 0; i < branch.count; i++) {
        const struct branch_point *point = &branch.point[i];
        if (point->special == SPECIAL_NONE || point->special == SPECIAL_END)
            continue;
        count++;
        if (point->special != l->special || point->verified < 0 ||
            !(fabs(point->solution.param[0] - l->value) <= 1e-10))
            fail_msg("%s from %g: %d at %.17g, %d", l->lines[3] ? l->lines[3] : l->lines[2],
                     l->start, (int)point->special, point->solution.param[0], point->verified);
    }
    if (count != l->count)
        fail_msg("%s from %g: %d special points", l->lines[3] ? l->lines[3] : l->lines[2], l->start,
                 count);
    branch_free(&branch);
}

#define PITCHFORK                                                                                  \
    {                                                                                              \
        "var x = 0.1", "param r = 0", "x' = r*x-x^3"                                               \
    }
#define CROSSED                                                                                    \
    {                                                                                              \
        "var x = 0.1", "param r = 0", "x' = r*x-x^2"                                               \
    }
#define FOLD                                                                                       \
    {                                                                                              \
        "var x = 0.1", "param r = 0", "x' = r+x^2"                                                 \
    }
#define TURNING                                                                                    \
    {                                                                                              \
        "var x = 0.1", "var y = 0", "param r = 0", "x' = r*x-y-x^3", "y' = x+r*y-y^3"              \
    }
#define MATHIEU                                                                                    \
    {                                                                                              \
        "var x = 0", "var v = 0", "param a = 0", "x' = v", "v' = -(a-2*cos(2*t))*x"                \
    }
#define REST SOLUTION_EQUILIBRIUM

/* Starts on the point, ranges that end there, the point from the branch that only touches it. */
static void test_starts_and_ends(void **state)
{
    (void)state;
    static const struct landing landings[] = {
        {PITCHFORK, "r", -1, 1, REST, 1, 0, {0}, SPECIAL_CROSSING, 1, 0},
        {PITCHFORK, "r", -1, 1, REST, 1, -0.3, {0}, SPECIAL_CROSSING, 1, 0},
        {PITCHFORK, "r", -1, 0, REST, 1, -1, {0}, SPECIAL_CROSSING, 1, 0},
        {PITCHFORK, "r", 0, 1, REST, 1, 0, {0}, SPECIAL_CROSSING, 1, 0},
        {PITCHFORK, "r", -1, 1, REST, 1, 1, {1}, SPECIAL_CROSSING, 1, 0},
        {PITCHFORK, "r", 0.1, 1, REST, 1, 1, {0}, SPECIAL_NONE, 0, 0},
        {CROSSED, "r", -1, 1, REST, 1, 0, {0}, SPECIAL_CROSSING, 1, 0},
        {CROSSED, "r", -1, 0, REST, 1, -1, {-1}, SPECIAL_CROSSING, 1, 0},
        {FOLD, "r", -1, 1, REST, 1, 0, {0}, SPECIAL_FOLD, 1, 0},
        {FOLD, "r", -1, 0, REST, 1, -1, {-1}, SPECIAL_FOLD, 1, 0},
        {TURNING, "r", -1, 1, REST, 2, 0, {0}, SPECIAL_HOPF, 1, 0},
        {TURNING, "r", -1, 0, REST, 2, -1, {0}, SPECIAL_HOPF, 1, 0},
        {TURNING, "r", 0, 1, REST, 2, 1, {0}, SPECIAL_HOPF, 1, 0},
        {TURNING, "r", 1e-7, 1, REST, 2, 1, {0}, SPECIAL_NONE, 0, 0}};
    for (size_t i = 0; i < COUNT_OF(landings); i++)
        check(&landings[i]);
}

/* Where volumes are kept the product of two multipliers is 1 all along, which is no torus. */
static void test_conservative(void **state)
{
    (void)state;
    static const struct landing landings[] = {
        {MATHIEU, "a", -0.3, -0.2, SOLUTION_RESPONSE, 2, -0.25, {0}, SPECIAL_NONE, 0, 0},
        {MATHIEU,
         "a",
         1,
         3,
         SOLUTION_RESPONSE,
         2,
         2.5,
         {0},
         SPECIAL_DOUBLING,
         1,
         1.8591080725143635}};
    for (size_t i = 0; i < COUNT_OF(landings); i++)
        check(&landings[i]);
}

/* FitzHugh and Nagumo's canards: both folds, whatever the sizes are that the scene begins with, and
 * none that rounding makes (the scene is the same with v, w, I turned round: 1.75 - I). */
static void test_canards(void **state)
{
    (void)state;
    static const char *const sizes[][2] = {{"var v = -1.1", "var w = -0.5"},
                                           {"var v = 0.1", "var w = 0.1"},
                                           {"var v = 1", "var w = 0.7"}};
    for (size_t k = 0; k < (is_long() ? COUNT_OF(sizes) : 1); k++) {
        struct landing l = {.lines = {sizes[k][0], sizes[k][1], "param I = 0.1", "v' = v-v^3/3-w+I",
                                      "w' = 0.08*(v+0.7-0.8*w)"},
                            .param = "I",
                            .to = is_long() ? 2 : 0.4,
                            .n = 2,
                            .start = 0.1,
                            .state = {-1.137512, -0.5468903}};
        struct branch rests = follow(&l, NULL);
        const struct branch_point *hopf = NULL;
        for (int i = rests.count - 1; i >= 0; i--)
            if (rests.point[i].special == SPECIAL_HOPF)
                hopf = &rests.point[i];
        assert_non_null(hopf);
        close_to(hopf->solution.param[0], 0.3312813374547457, 1e-12);
        struct branch orbits = follow(&l, hopf);
        int folds = 0;
        for (int i = 0; i < orbits.count; i++)
            if (orbits.point[i].special == SPECIAL_FOLD) {
                const double at = orbits.point[i].solution.param[0];
                close_to(fmin(at, 1.75 - at), 0.324178522504, 1e-10);
                folds++;
            }
        assert_int_equal(folds, is_long() ? 2 : 1);
        branch_free(&orbits);
        branch_free(&rests);
    }
}

/* What winds into a rest as slowly as no exponential is no orbit. */
static void test_no_orbit(void **state)
{
    (void)state;
    static const double starts[] = {0.1, 0.5, 2};
    static const char *const lines[10] = TURNING;
    for (size_t i = 0; i < COUNT_OF(starts); i++) {
        struct scene scene;
        struct found_orbit orbit;
        struct error error = {0};
        scene_init(&scene, NULL);
        assert_true(type_scene(models, &scene, lines));
        struct orbit_request request = {
            .scene = &scene, .state = {starts[i], 0}, .span = 20, .settles = true};
        assert_false(orbit_find(&request, &orbit, &error));
        assert_non_null(strstr(error.text, starts[i] < 1 ? "dies away" : "does not return"));
        orbit_free(&orbit);
    }
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_starts_and_ends), cmocka_unit_test(test_conservative),
        cmocka_unit_test(test_canards), cmocka_unit_test(test_no_orbit)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
