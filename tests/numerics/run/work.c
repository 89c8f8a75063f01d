/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The energy balance of motions that are right is 0, however long the steps are: 200 random linear
 * scenes solved in closed form (overdamped ones among them, and steps up to three periods) and 60
 * with a force that jumps in time and 60 with one that jumps in the state, whose states are checked
 * against a closed form, too.
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

TEST(test_closed_forms_balance)
{
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

TEST(test_jumping_forces_balance)
{
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

/* y'' = -omega^2 (y - centre s), s = sign(a y + b v - c), from one switch to the next: between them
 * y - centre s = R cos p and v = -omega R sin p, p growing as omega t. None of these slides. */
static void solve_switching(double omega, double centre, const double line[3], double end,
                            double *y)
{
    const double length = hypot(line[0], line[1] * omega), turned = atan2(line[1] * omega, line[0]);
    double t = 0, side = line[0] * y[0] + line[1] * y[1] - line[2];
    /* at rest on the line it moves to where it is drawn */
    double s = side != 0 ? copysign(1, side) : copysign(1, -line[1] * y[0]);
    while (t < end) {
        const double q = y[0] - centre * s, u = y[1] / omega, radius = hypot(q, u),
                     angle = atan2(-u, q),
                     level = (line[2] - line[0] * centre * s) / (length * radius);
        double next = 4 * PI;
        for (int k = -1; k <= 1 && fabs(level) < 1; k += 2) {
            const double ahead = fmod(k * acos(level) - turned - angle + 8 * PI, 2 * PI);
            if (ahead > 1e-9 && ahead < 2 * PI - 1e-9)
                next = fmin(next, ahead);
        }
        const bool ends = next > omega * (end - t);
        const double turn = ends ? omega * (end - t) : next;
        y[0] = centre * s + radius * cos(angle + turn);
        y[1] = -omega * radius * sin(angle + turn);
        t = ends ? end : t + turn / omega;
        s = -s;
    }
}

TEST(test_switching_forces_balance)
{
    static const char *const methods[] = {"gauss6", "dop853", "radau5", "dopri5", "rodas5p"};
    const double k = 15, omega = sqrt(75), end = 6;
    for (int i = 0; i < 60; i++) {
        struct error error = {0};
        struct typed_models *models = typed_create(&error);
        struct scene scene = spring();
        /* by position, velocity, both; dry friction that does not stop it, and what drives it */
        const int kind = i / 5 % 5;
        const double line[] = {kind == 0 || kind == 2, kind == 0 ? 0 : uniform(0.05, 0.2),
                               kind >= 3 ? 0 : uniform(-0.01, 0.01)},
                     force = kind == 3 ? uniform(-0.01, -0.003) : uniform(0.01, 0.2);
        char text[160];
        if (kind >= 3)
            snprintf(text, sizeof text, "force %.17g*sign(v)", force);
        else
            snprintf(text, sizeof text, "force %.17g*sign(%.17g*y + %.17g*v - %.17g)", force,
                     line[0], line[1], line[2]);
        const struct typed_line typed = typing_line(text_of(text));
        const struct model *model = typed_add(models, scene.model, &typed, &error);
        assert_non_null(model);
        scene_remodel(&scene, model);
        const char *method = methods[i % (int)COUNT_OF(methods)];
        const struct run_settings settings = {.dt = 4e-3, .tol = i % 5 % 2 ? 1e-12 : 0};
        struct run *run = start(&scene, method, settings, end);
        struct ledger ledger;
        double y[] = {0.05, 0};
        go_to(run, end);
        run_ledger(run, &ledger);
        solve_switching(omega, force / k, line, end, y);
        const double apart = hypot(run->y[0] - y[0], (run->y[1] - y[1]) / omega);
        if (apart > 1e-9)
            fail_msg("%d: %s, %s: the state is off by %g", i, method, text, apart);
        if (!(ledger.error_max <= 5e-8))
            fail_msg("%d: %s, %s: the balance is off by %g", i, method, text, ledger.error_max);
        run_destroy(run);
        typed_destroy(models);
    }
}

/* Quadratic drag bends where the body turns, and a force that depends on its place works there,
 * too: between the two parts of such a step the place counts as well as the velocity. */
TEST(test_work_by_place_where_drag_turns)
{
    for (int i = 0; i < 40; i++) {
        struct scene scene = spring();
        set(&scene, "C", uniform(10, 200));
        set(&scene, "mu", uniform(0.2, 3));
        set(&scene, "width", uniform(0.005, 0.03));
        const double dt = uniform(4e-3, 8e-3);
        struct run *run = start(&scene, "gauss6", (struct run_settings){.dt = dt}, 6);
        struct ledger ledger;
        go_to(run, 6);
        run_ledger(run, &ledger);
        if (!(ledger.error_max <= 2e-6))
            fail_msg("%d: dt = %g: the balance is off by %g", i, dt, ledger.error_max);
        run_destroy(run);
    }
}

RUN_TESTS(NULL, NULL)
