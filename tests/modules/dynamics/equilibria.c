/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Equilibria in a box: all of them, what is doubtful, and their types. */
#include "cmocka_testing.h"

#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

#include <hooke/base/numeric.h>

static struct typed_models *models;

static struct scene typed(const char *const *lines)
{
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    return scene;
}

#define TYPED(...) typed((const char *const[]){__VA_ARGS__, NULL})

/* Quadratic forms in rotated coordinates: zeros are known; none is missed, none invented. */
static void test_all_equilibria(void **state)
{
    (void)state;
    uint64_t seed = 11;
    for (int k = 0; k < 100; k++) {
        double a[2][3], m[4];
        char lines[4][400];
        int count[2], wanted = 0;
        for (int i = 0; i < 4; i++)
            m[i] = 3 * random_fraction(&seed) - 1.5;
        const double d = m[0] * m[3] - m[1] * m[2];
        if (fabs(d) < 0.2)
            continue;
        for (int i = 0; i < 2; i++) {
            count[i] = 1 + (int)(3 * random_fraction(&seed));
            int used = snprintf(lines[2 + i], sizeof lines[0], "%c' = 1", "xy"[i]);
            for (int j = 0; j < count[i]; j++) {
                a[i][j] = 4 * random_fraction(&seed) - 2;
                used += snprintf(lines[2 + i] + used, sizeof lines[0] - (size_t)used,
                                 "*(%.17g*x+(%.17g)*y-(%.17g))", m[2 * i], m[2 * i + 1], a[i][j]);
            }
        }
        const struct scene scene = TYPED("var x = 0.1", "var y = 0.1", lines[2], lines[3]);
        const struct equilibria_request request = {.scene = &scene, .box = {{-3, 3}, {-3, 3}}};
        struct equilibria found;
        struct error error = {0};
        assert_true(equilibria_find(&request, &found, &error));
        for (int i = 0; i < count[0]; i++)
            for (int j = 0; j < count[1]; j++) {
                const double x = (m[3] * a[0][i] - m[1] * a[1][j]) / d,
                             y = (m[0] * a[1][j] - m[2] * a[0][i]) / d;
                if (fabs(x) >= 3 || fabs(y) >= 3)
                    continue;
                wanted++;
                bool there = false;
                for (int l = 0; l < found.count; l++)
                    there = there || (fabs(found.solution[l].state[0] - x) < 1e-9 &&
                                      fabs(found.solution[l].state[1] - y) < 1e-9);
                assert_true(there);
            }
        assert_int_equal(found.count, wanted);
        assert_true(found.complete);
        equilibria_free(&found);
    }
}

/* What bounds do not decide is said, and where; of what they do not prove linear theory says
 * nothing. Zeros on the edge are inside, poles and jumps are none. */
static void test_doubtful_equilibria(void **state)
{
    (void)state;
    static const struct {
        const char *line, *near; /* NULL: proven that there are no others */
        int count, degenerate;
    } cases[] = {{"x' = x^2", "near x = 0, y = 0", 1, 1},
                 {"x' = (x-0.5)^2*(y+1)", "near x = 0.5, y = 0", 1, 1},
                 {"x' = x^2-1e-6", NULL, 2, 0},
                 {"x' = x^2+1e-6", NULL, 0, 0},
                 {"x' = abs(x)", "near x = 0, y = 0", 1, 1},
                 {"x' = abs(x)-x", "many places are left out", 0, 0}, /* all that are not below 0 */
                 {"x' = x*(x^2+y^2-0.25)", NULL, 3, 0},
                 {"x' = y*(x^2+y^2-0.25)", "many places are left out", 0, 0},
                 {"x' = 1/x", NULL, 0, 0}, /* a pole */
                 {"x' = 1/x-2", NULL, 1, 0},
                 {"x' = y/x-2*x", "near x = 0, y = 0", 0, 0},
                 {"x' = x^9/(x^2-0.01)", "near x = 0, y = 0", 1, 1},
                 {"x' = 2/(1/x)-1", NULL, 1, 0},
                 {"x' = tan(5*x)-1", "and elsewhere", 3, 0},
                 {"x' = if(x>0, x-0.5, x+0.5)", "near x = 0, y = 0", 2, 0},
                 {"x' = if(x>0, 1, -1)", "near x = 0, y = 0", 0, 0},
                 {"x' = sqrt(x)-0.5", NULL, 1, 0},
                 {"x' = sqrt(x)-2*x", "near x = 0, y = 0", 2, 1},
                 {"x' = tan(x)-x", "near x = 0, y = 0", 1, 1},
                 {"x' = log(x)", NULL, 1, 0},
                 {"x' = x-1", NULL, 1, 0},
                 {"x' = x-1.0001", NULL, 0, 0},
                 {"x' = (x+1)*(x-1)", NULL, 2, 0},
                 {"x' = sin(40*x)", NULL, 25, 0},
                 {"x' = exp(-1/(x^2+1e-9))", "many places are left out", 0, 0}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct scene scene = TYPED("var x = 0.1", "var y = 0.1", cases[i].line, "y' = -y");
        const struct equilibria_request request = {.scene = &scene, .box = {{-1, 1}, {-1, 1}}};
        struct equilibria found;
        struct error error = {0};
        int degenerate = 0;
        assert_true(equilibria_find(&request, &found, &error));
        for (int k = 0; k < found.count; k++)
            degenerate += found.form[k].type == EQUILIBRIUM_DEGENERATE;
        if (found.count != cases[i].count || degenerate != cases[i].degenerate ||
            found.complete != !cases[i].near ||
            (cases[i].near && !strstr(found.reason, cases[i].near)))
            fail_msg("%s: %d found, %d degenerate: %s", cases[i].line, found.count, degenerate,
                     found.reason);
        equilibria_free(&found);
    }
}

/* What an equilibrium is does not depend on the scene's start, which may be on it: then nothing
 * moves, and nothing shows how large the motion is. */
static void test_types_from_any_start(void **state)
{
    (void)state;
    static const struct {
        const char *x, *y;
        enum equilibrium_type type; /* of that at x = 1, y = 0 */
    } cases[] = {{"x' = y", "y' = 1-x-y^3", EQUILIBRIUM_DEGENERATE},
                 {"x' = y", "y' = 1-x", EQUILIBRIUM_CENTRE},
                 {"x' = y", "y' = 1-x^3", EQUILIBRIUM_CENTRE},
                 {"x' = y", "y' = 1-x+y^3", EQUILIBRIUM_DEGENERATE},
                 {"x' = y", "y' = 1-x-(x-1)^2*y", EQUILIBRIUM_DEGENERATE},
                 {"x' = y", "y' = x-1", EQUILIBRIUM_SADDLE},
                 {"x' = y", "y' = 1-x-0.1*y", EQUILIBRIUM_STABLE_FOCUS},
                 {"x' = y", "y' = 1-x-3*y", EQUILIBRIUM_STABLE_NODE},
                 {"x' = y-y^3*(x-1)", "y' = 1-x", EQUILIBRIUM_CENTRE},
                 {"x' = y*(2-x)", "y' = 1-x", EQUILIBRIUM_CENTRE},
                 {"x' = x-1-x*y", "y' = 2*y", EQUILIBRIUM_UNSTABLE_NODE},
                 {"x' = 1-x", "y' = -y^3", EQUILIBRIUM_DEGENERATE}};
    static const char *const starts[][2] = {{"var x = 1", "var y = 0"},
                                            {"var x = 1.4", "var y = 0.2"},
                                            {"var x = 1", "var y = 1e-9"},
                                            {"var x = 1.001", "var y = 0"}};
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        for (size_t k = 0; k < COUNT_OF(starts); k++) {
            const struct scene scene = TYPED(starts[k][0], starts[k][1], cases[i].x, cases[i].y);
            const struct equilibria_request request = {.scene = &scene,
                                                       .box = {{0.4, 1.6}, {-0.6, 0.6}}};
            struct equilibria found;
            struct error error = {0};
            assert_true(equilibria_find(&request, &found, &error));
            assert_int_equal(found.count, 1);
            if (found.form[0].type != cases[i].type)
                fail_msg("%s, %s from %s, %s: %s", cases[i].x, cases[i].y, starts[k][0],
                         starts[k][1],
                         catalog_row(&equilibrium_catalog, (size_t)found.form[0].type)->name);
            equilibria_free(&found);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_all_equilibria),
                                       cmocka_unit_test(test_doubtful_equilibria),
                                       cmocka_unit_test(test_types_from_any_start)};
    struct error error;
    models = typed_create(&error);
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
