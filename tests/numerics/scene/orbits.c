/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The closed forms that models bring with them: they solve the equation, and known places of known
 * orbits. */
#include <hooke/base/catalog.h>
#include "unit/scene/testing.h"

#include <math.h>

static struct scene scene_of(const struct preset *preset)
{
    struct scene scene;
    scene_init(&scene, preset);
    return scene;
}

static struct system bind_or_fail(const struct scene *scene)
{
    struct system system;
    struct error error = {0};
    if (!scene_bind(scene, &system, &error))
        fail_msg("%s: %s", scene->preset->row.name, error.text);
    return system;
}

/* The exact solution goes through its start and its slope is the derivative, whatever the start. */
TEST(test_exact_solutions_satisfy_the_equation)
{
    uint64_t seed = 12;
    int seen = 0;
    for (size_t m = 0; scene_models[m]; m++) {
        if (!scene_models[m]->exact)
            continue;
        seen++;
        for (size_t i = 0; i < preset_catalog.count; i++) {
            struct scene scene = scene_of(preset_at(i));
            if (scene.model != scene_models[m])
                continue;
            if (scene_param(&scene, "lambda") >= 0)
                scene.value[scene_param(&scene, "lambda")] = -3;
            struct system system = bind_or_fail(&scene);
            assert_true(system_has_exact(&system));
            for (int round = 0; round < 200; round++) {
                double start[LIMIT_VARIABLES], at[LIMIT_VARIABLES], up[LIMIT_VARIABLES],
                    down[LIMIT_VARIABLES], f[LIMIT_VARIABLES], floor[LIMIT_VARIABLES],
                    t0 = random_between(&seed, -2, 2);
                for (int k = 0; k < system.n; k++)
                    start[k] = round ? system.scale[k] * random_between(&seed, -1.3, 1.3)
                                     : system.start[k];
                system_exact(&system, t0, start, t0, at, floor);
                for (int k = 0; k < system.n; k++)
                    assert_true(fabs(at[k] - start[k]) <= 1e-15 * fabs(start[k]) && floor[k] >= 0 &&
                                floor[k] < 1e-8);
                double t = t0 + random_between(&seed, -9, 9), rate = 0;
                system_exact(&system, t0, start, t, at, NULL);
                system_derivative(&system, t, at, f);
                for (int k = 0; k < system.n; k++)
                    rate = fmax(rate, fabs(f[k]) / fmax(system.scale[k], fabs(at[k])));
                /* near a collision t itself is too coarse */
                if (rate > 1e6)
                    continue;
                double h = 1e-5 / fmax(rate, 1);
                system_exact(&system, t0, start, t + h, up, NULL);
                system_exact(&system, t0, start, t - h, down, NULL);
                for (int k = 0; k < system.n; k++) {
                    double slope = (up[k] - down[k]) / (t + h - (t - h)),
                           size = fmax(fabs(at[k]), system.scale[k]);
                    if (!(fabs(slope - f[k]) <= 1e-5 * fmax(rate, 1) * size))
                        fail_msg("%s: variable %d at t = %g from %g: slope %.12g, wanted %.12g",
                                 preset_at(i)->row.name, k, t, t0, slope, f[k]);
                }
            }
        }
    }
    assert_true(seen >= 2);
}

TEST(test_kepler)
{
    struct scene scene =
        scene_of((const struct preset *)catalog_find(&preset_catalog, TEXT("kepler")));
    static const double pi = 3.14159265358979323846;
    double y[4], floor[4];
    for (double e = 0; e < 1; e += 0.099) {
        scene.value[scene_param(&scene, "e")] = e;
        struct system system = bind_or_fail(&scene);
        /* Half a turn: the apocentre; a hundred turns: back, as far as pi in double allows. */
        system_exact(&system, 0, system.start, pi, y, floor);
        assert_true(fabs(y[0] + 1 + e) <= 1e-15 + 2 * floor[0] &&
                    fabs(y[1]) <= 1e-15 + 2 * floor[1]);
        assert_true(fabs(y[3] + sqrt((1 - e) / (1 + e))) <= 1e-15 + 2 * floor[3]);
        system_exact(&system, 0, system.start, 200 * pi, y, floor);
        for (int k = 0; k < 4; k++)
            assert_true(fabs(y[k] - system.start[k]) <= 2 * floor[k] && floor[k] < 1e-5);
    }
    /* A quarter of a circle; a straight line away from the sun faster than it can hold; a parabola.
     */
    scene.value[scene_param(&scene, "e")] = 0;
    struct system system = bind_or_fail(&scene);
    system_exact(&system, 0, system.start, pi / 2, y, NULL);
    assert_true(fabs(y[0]) < 1e-15 && fabs(y[1] - 1) < 1e-15 && fabs(y[2] + 1) < 1e-15 &&
                fabs(y[3]) < 1e-15);
    double away[4] = {1, 0, 2, 0}; /* v^2 = 2 + 2/r: hyperbolic, alpha = -2 */
    system_exact(&system, 0, away, 1e3, y, NULL);
    assert_true(fabs(y[2] * y[2] - (2 + 2 / y[0])) < 1e-14 && y[1] == 0 && y[0] > 1400);
    /* Barker: t = (D + D^3/3)/sqrt 2 q^1.5 sqrt 2, D = tan(nu/2) */
    double parabola[4] = {1, 0, 0, sqrt(2)};
    double d = 2, t = sqrt(2) * (d + d * d * d / 3);
    system_exact(&system, 0, parabola, t, y, NULL);
    assert_true(fabs(y[0] - (1 - d * d)) < 1e-14 * 5 && fabs(y[1] - 2 * d) < 1e-14 * 5);
}

TEST(test_prothero_robinson)
{
    struct scene scene =
        scene_of((const struct preset *)catalog_find(&preset_catalog, TEXT("prothero-robinson")));
    struct system system = bind_or_fail(&scene);
    double y, floor, away = 3;
    system_exact(&system, 0, system.start, 10, &y, &floor);
    assert_true(fabs(y - cos(10)) < 1e-16 && floor < 3e-15);
    system_exact(&system, 0, &away, 1e-6, &y, NULL);
    assert_true(fabs(y - (1 + 2 * exp(-1))) < 1e-12);
    system_exact(&system, 0, &away, 10, &y, NULL);
    assert_true(y == cos(10));
}

RUN_TESTS(NULL, NULL)
