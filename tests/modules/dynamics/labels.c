/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Labels of equilibria against runs: of random planar systems whose zeros are known all are found,
 * none is invented, and what is called stable holds what starts beside it, what is not does not.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

#include <hooke/base/numeric.h>
#include <hooke/run.h>

#define ZEROS 2 /* of each factor */

static struct typed_models *models;

static double between(uint64_t *seed, double from, double to)
{
    return from + (to - from) * random_fraction(seed);
}

/* x' and y' are mixtures of (x - a)(x - b) and (y - c)(y - d): four zeros, at the corners of a
 * rectangle. */
static struct scene random_scene(uint64_t *seed, double corner[2][ZEROS])
{
    char line[2][256];
    struct scene scene;
    for (int k = 0; k < 2; k++) {
        corner[k][0] = between(seed, -2, -0.3);
        corner[k][1] = between(seed, 0.3, 2);
    }
    for (int k = 0; k < 2; k++)
        snprintf(line[k], sizeof line[k],
                 "%c' = (%.17g)*(x-(%.17g))*(x-(%.17g))+(%.17g)*(y-(%.17g))*(y-(%.17g))",
                 k ? 'y' : 'x', between(seed, -1, 1), corner[0][0], corner[0][1],
                 between(seed, -1, 1), corner[1][0], corner[1][1]);
    scene_init(&scene, NULL);
    assert_true(type_scene(
        models, &scene, (const char *const[]){"var x = 1", "var y = 0", line[0], line[1], NULL}));
    return scene;
}

/* How far from the equilibrium the flow takes a small circle around it in that time: the largest
 * and the smallest of 8 points, relative to the start (classical Runge-Kutta). */
static void flow(const struct system *system, const struct solution *at, double time, double far[2])
{
    const double small = 1e-6;
    const int steps = 4000;
    far[0] = HUGE_VAL;
    far[1] = 0;
    for (int p = 0; p < 8; p++) {
        double y[2] = {at->state[0] + small * cos(0.3 + p * 0.7853981633974483),
                       at->state[1] + small * sin(0.3 + p * 0.7853981633974483)};
        double distance = 1;
        for (int i = 0; i < steps && distance < 1e4; i++) {
            double k[4][2], z[2];
            const double h = time / steps;
            for (int s = 0; s < 4; s++) {
                const double part = s == 0 ? 0 : s == 3 ? h : h / 2;
                for (int j = 0; j < 2; j++)
                    z[j] = y[j] + (s > 0 ? part * k[s - 1][j] : 0);
                system_derivative(system, 0, z, k[s]);
            }
            for (int j = 0; j < 2; j++)
                y[j] += h / 6 * (k[0][j] + 2 * k[1][j] + 2 * k[2][j] + k[3][j]);
            distance = hypot(y[0] - at->state[0], y[1] - at->state[1]) / small;
        }
        far[0] = fmin(far[0], distance);
        far[1] = fmax(far[1], distance);
    }
}

static void check_label(const struct scene *scene, const struct solution *at,
                        const struct equilibrium_form *form)
{
    struct system system;
    struct error error = {0};
    double slowest = HUGE_VAL, fastest = 0, far[2];
    assert_true(scene_bind(scene, &system, &error));
    for (int i = 0; i < 2; i++) {
        slowest = fmin(slowest, fabs(at->value[i].re));
        fastest = fmax(fastest, hypot(at->value[i].re, at->value[i].im));
    }
    if (slowest < 0.02 * fastest) /* a run would last too long to say */
        return;
    flow(&system, at, 6 / slowest < 100 / fastest ? 6 / slowest : 100 / fastest, far);
    const bool stable =
        form->type == EQUILIBRIUM_STABLE_NODE || form->type == EQUILIBRIUM_STABLE_FOCUS;
    if (stable)
        assert_true(far[1] < 1);
    else
        assert_true(far[1] > 1.2 && solution_stable(at) == stable);
    if (form->type == EQUILIBRIUM_UNSTABLE_NODE || form->type == EQUILIBRIUM_UNSTABLE_FOCUS)
        assert_true(far[0] > 1);
    const double determinant = form->index;
    assert_true(determinant == (form->type == EQUILIBRIUM_SADDLE ? -1 : 1));
}

static void test_labels(void **state)
{
    (void)state;
    uint64_t seed = 41;
    int labels = 0;
    for (int s = 0; labels < (is_long() ? 1000 : 50); s++) {
        double corner[2][ZEROS];
        const struct scene scene = random_scene(&seed, corner);
        const struct equilibria_request request = {.scene = &scene, .box = {{-3, 3}, {-3, 3}}};
        struct equilibria found;
        struct error error = {0};
        if (!equilibria_find(&request, &found, &error))
            fail_msg("%s", error.text);
        assert_true(found.complete);
        assert_int_equal(found.count, ZEROS * ZEROS);
        for (int k = 0; k < found.count; k++) {
            close_to(found.solution[k].state[0], corner[0][k / ZEROS], 1e-12);
            close_to(fmin(fabs(found.solution[k].state[1] - corner[1][0]),
                          fabs(found.solution[k].state[1] - corner[1][1])),
                     0, 1e-12);
            check_label(&scene, &found.solution[k], &found.form[k]);
            labels++;
        }
        equilibria_free(&found);
    }
}

/* Published equilibria and eigenvalues: Roessler's inner one, Henon and Heiles' saddles. */
static void test_published(void **state)
{
    (void)state;
    struct error error = {0};
    struct scene scene;
    struct equilibria found;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene,
                           (const char *const[]){"var x = 1", "var y = 1", "var z = 1", "x' = -y-z",
                                                 "y' = x+0.2*y", "z' = 0.2+z*(x-5.7)", NULL}));
    const struct equilibria_request rossler = {.scene = &scene,
                                               .box = {{-20, 20}, {-50, 50}, {-10, 50}}};
    assert_true(equilibria_find(&rossler, &found, &error));
    assert_int_equal(found.count, 2);
    double re = NAN, im = NAN;
    for (int i = 0; i < 3; i++)
        if (found.solution[0].value[i].im > 0) {
            re = found.solution[0].value[i].re;
            im = found.solution[0].value[i].im;
        }
    close_to(re, 0.097000856088481103, 1e-14);
    close_to(im, 0.99519349102995343, 1e-14);
    equilibria_free(&found);
    const struct preset *stars = preset_by_name(TEXT("henon-heiles"));
    scene_init(&scene, stars);
    const struct equilibria_request henon = {.scene = &scene,
                                             .box = {{-2, 2}, {-2, 2}, {-1, 1}, {-1, 1}}};
    assert_true(equilibria_find(&henon, &found, &error));
    assert_true(found.complete);
    assert_int_equal(found.count, 4);
    close_to(found.solution[3].state[0], sqrt(0.75), 1e-15);
    close_to(found.solution[3].state[1], -0.5, 1e-15);
    for (int k = 0; k < 4; k++)
        assert_int_equal(found.form[k].type, k == 1 ? EQUILIBRIUM_CENTRE : EQUILIBRIUM_SADDLE);
    equilibria_free(&found);
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_labels),
                                       cmocka_unit_test(test_published)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
