/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The energy balance of motions that are right is 0, however long the steps are: 200 random linear
 * scenes solved in closed form (overdamped ones among them, and steps up to three periods) and 60
 * with a force that jumps in time, whose states are checked against a closed form, too.
 */
#include "unit/run/fixture.h"

#include <hooke/base/numeric.h>
#include <hooke/scene/typed.h>

#include <stdio.h>

#include "unit/scene/typing.h"

static uint64_t seed = 2463534242u;

static double uniform(double from, double to)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return from + (to - from) * (double)(seed >> 11) * 0x1p-53;
}

static double decades(double from, double to)
{
    return pow(10, uniform(from, to));
}

static void test_closed_forms_balance(void **state)
{
    (void)state;
    int unknown = 0;
    for (int i = 0; i < 200; i++) {
        struct scene scene = spring();
        const double k = decades(-1, 3), mass = decades(-2, 1), omega = sqrt(k / mass),
                     gamma = omega * decades(-3, 8), dt = decades(-2, 0.5) * 2 * PI / omega;
        set(&scene, "k", k);
        set(&scene, "m", mass);
        set(&scene, "gamma", gamma);
        if (i % 2) {
            set(&scene, "F0", k * 0.05 * uniform(0.1, 1));
            set(&scene, "omega", omega * uniform(0.1, 3));
        }
        struct run *run = start(&scene, "exact", (struct run_settings){.dt = dt}, 150 * dt);
        struct ledger ledger;
        go_to(run, 150 * dt);
        run_ledger(run, &ledger);
        unknown += isnan(ledger.error_max);
        if (ledger.error_max > 2e-8)
            fail_msg("%d: k = %g, m = %g, gamma/omega = %g, dt/T = %g: %g", i, k, mass,
                     gamma / omega, dt * omega / (2 * PI), ledger.error_max);
        run_destroy(run);
    }
    assert_in_range(unknown, 0, 3);
}

/* y'' = -k/m y + F/m sign(sin(w t + phase)), from one jump to the next. */
static void solve_jumping(double omega, double centre, double w, double phase, double end,
                          double *y)
{
    double t = 0;
    while (t < end) {
        const double half = floor((w * t + phase) / PI * (1 + 1e-15) + 1e-12),
                     next = fmin(end, ((half + 1) * PI - phase) / w),
                     c = fmod(half, 2) != 0 ? -centre : centre, angle = omega * (next - t),
                     q = y[0] - c, v = y[1] / omega;
        y[0] = c + q * cos(angle) + v * sin(angle);
        y[1] = omega * (v * cos(angle) - q * sin(angle));
        t = next;
    }
}

static void test_jumping_forces_balance(void **state)
{
    (void)state;
    static const char *const methods[] = {"gauss6", "dop853",  "yoshida8",
                                          "dopri5", "rodas5p", "radau5"};
    const double k = 15, omega = sqrt(75), end = 6;
    for (int i = 0; i < 60; i++) {
        struct error error = {0};
        struct typed_models *models = typed_create(&error);
        struct scene scene = spring();
        const double force = uniform(0.01, 0.5), w = uniform(0.5, 20), phase = uniform(0, 3);
        char line[120];
        snprintf(line, sizeof line, "force %.17g*sign(sin(%.17g*t + %.17g))", force, w, phase);
        const struct typed_line typed = typing_line(text_of(line));
        const struct model *model = typed_add(models, scene.model, &typed, &error);
        assert_non_null(model);
        scene_remodel(&scene, model);
        const char *method = methods[i % (int)COUNT_OF(methods)];
        const bool adaptive = i % 2;
        const struct run_settings settings = {.dt = 4e-3, .tol = adaptive ? 1e-12 : 0};
        struct run *run = start(&scene, method, settings, end);
        struct ledger ledger;
        double y[] = {0.05, 0};
        go_to(run, end);
        run_ledger(run, &ledger);
        solve_jumping(omega, force / k, w, phase, end, y);
        const double apart = hypot(run->y[0] - y[0], (run->y[1] - y[1]) / omega);
        if (apart > 1e-8)
            fail_msg("%d: %s, %s: the state is off by %g", i, method, line, apart);
        if (!(ledger.error_max <= 1e-7))
            fail_msg("%d: %s, %s: the balance is off by %g", i, method, line, ledger.error_max);
        run_destroy(run);
        typed_destroy(models);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_forms_balance),
        cmocka_unit_test(test_jumping_forces_balance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
