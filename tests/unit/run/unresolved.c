/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces that repeat between the points of a step are said to be missed, and no others are. */
#include "unit/run/fixture.h"

#include <hooke/base/numeric.h>
#include <hooke/run/unresolved.h>
#include <hooke/scene/typed.h>

#include "unit/scene/typing.h"

static bool misses(const char *force, const char *method, double dt, double end, double *shorter)
{
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct scene scene = spring();
    const struct typed_line typed = typing_line(text_of(force));
    const struct model *model = typed_add(models, scene.model, &typed, &error);
    assert_non_null(model);
    scene_remodel(&scene, model);
    struct run *run = start(&scene, method, (struct run_settings){.dt = dt}, end);
    go_to(run, end);
    const bool missed = run_force_unresolved(run, shorter);
    run_destroy(run);
    typed_destroy(models);
    return missed;
}

/* 20 frequencies, 3 forms and 4 methods; steps of whole periods and of a twentieth. */
static void test_steps_of_whole_periods(void **state)
{
    (void)state;
    static const char *const methods[] = {"euler", "heun", "rk4", "gauss6"};
    for (int i = 0; i < 20; i++)
        for (size_t form = 0; form < 3; form++) {
            const double f = pow(10, 0.3 + 0.2 * i), period = 1 / f;
            const char *method = methods[(i + (int)form) % (int)COUNT_OF(methods)];
            char force[80];
            double shorter, none;
            snprintf(force, sizeof force,
                     form == 0   ? "force 0.1*sin(%.17g*t)^2"
                     : form == 1 ? "force 0.1*cos(%.17g*t)"
                                 : "force 0.1 + y*sin(%.17g*t + 1)",
                     2 * PI * f);
            if (!misses(force, method, (1 + i % 3) * period, 60 * period, &shorter))
                fail_msg("%s, %s: nothing is said", force, method);
            if (!(shorter < 0.5 * period))
                fail_msg("%s, %s: dt <= %g is no help", force, method, shorter);
            if (misses(force, method, period / 20, 10 * period, &none))
                fail_msg("%s, %s: a twentieth of a period is enough", force, method);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_steps_of_whole_periods)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
