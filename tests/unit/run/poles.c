/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fixed steps across integrable poles of a force in time, against the integral in closed form. */
#include "unit/run/fixture.h"

#include <hooke/scene/typed.h>

#include "unit/scene/typing.h"

enum { RUNS = 240 };

/* Returns the velocity that a force |t - pole|^-power, or -log |t - pole|, gives a unit mass. */
static double pole_velocity(double power, double pole, double end)
{
    const double before = pole, after = end - pole;
    if (power == 0)
        return end - before * log(before) - after * log(after);
    return (pow(before, 1 - power) + pow(after, 1 - power)) / (1 - power);
}

/* 240 runs: 6 methods, powers from 0 (a logarithm) to 0.8, steps of 1 to 20 ms. A step across a
 * pole misses no more than what lies around the pole, and all such steps are counted. */
TEST(test_fixed_steps_across_integrable_poles)
{
    static const char *const methods[] = {"euler", "heun", "rk4", "gauss6", "radau5", "ab4"};
    static const double powers[] = {0, 0.1, 0.2, 0.3, 0.5, 0.8}, steps[] = {1e-3, 5e-3, 0.02};
    const double end = 2;
    for (int i = 0; i < RUNS; i++) {
        const double power = powers[i % (int)COUNT_OF(powers)],
                     dt = steps[i / 7 % (int)COUNT_OF(steps)],
                     /* away from the points of the steps, whose slopes have no bound near it */
            pole = dt * (floor((0.31 + 1.4 * fmod((i + 1) * 0.618033988749895, 1)) / dt) + 0.37);
        const char *method = methods[i / (int)COUNT_OF(powers) % (int)COUNT_OF(methods)];
        char force[80];
        struct error error = {0};
        struct typed_models *models = typed_create(&error);
        struct scene scene = spring();
        snprintf(force, sizeof force,
                 power == 0 ? "force -log(abs(t-%.17g))" : "force abs(t-%.17g)^-%g", pole, power);
        const struct typed_line typed = typing_line(text_of(force));
        const struct model *model = typed_add(models, scene.model, &typed, &error);
        assert_non_null(model);
        scene_remodel(&scene, model);
        set(&scene, "m", 1);
        set(&scene, "k", 0);
        struct run *run = start(&scene, method, (struct run_settings){.dt = dt}, end);
        go_to(run, end);
        /* the force from the pole to a step and a half on either side of it */
        const double right = pole_velocity(power, pole, end), reach = 1.5 * dt,
                     around = pole_velocity(power, reach, 2 * reach);
        if (!(fabs(run->y[1] - right) < around + 1e-3 * right))
            fail_msg("%s, %s, dt = %g: v = %.6g, right %.6g", force, method, dt, run->y[1], right);
        if (run->cost.poles != 1)
            fail_msg("%s, %s, dt = %g: %lld poles", force, method, dt, (long long)run->cost.poles);
        run_destroy(run);
        typed_destroy(models);
    }
}

RUN_TESTS(NULL, NULL)
