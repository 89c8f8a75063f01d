/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Faster ways to the same steps: kernels to the bit, the propagator within rounding, both however a
 * run is cut up. */
#include "unit/run/fixture.h"

#include <float.h>

#define STEPS 1500

/* NULL: this method, drag or step is refused there. */
static struct run *run_of(const struct scene *scene, const struct method *method, enum drag drag,
                          enum kernel kernel, double dt)
{
    const struct run_settings settings = {
        .dt = dt, .drag = drag, .kernel = kernel, .record = {RECORD_ALL, 1, 0}};
    struct error error;
    return method->flags & METHOD_EXTERNAL ? NULL
                                           : run_create(scene, method, &settings, HUGE_VAL, &error);
}

static void in_pieces(struct run *run, int64_t steps)
{
    for (int64_t piece = 1;
         run->steps < steps && run->stop != STOP_DIVERGED && run->stop != STOP_NO_SOLUTION;
         piece = piece * 5 % 97)
        go_steps(run, piece < steps - run->steps ? piece : steps - run->steps);
}

static bool has_kernel(const struct run *run)
{
    return method_kernel(run->method, &run->system, run->settings.drag) != NULL;
}

/* More scenes than the presets show: every combination of terms that a shape knows, and some that
 * none knows. */
static void set_terms(struct scene *scene, unsigned which)
{
    static const struct {
        const char *name;
        double value;
    } terms[] = {{"gamma", 0.3}, {"C", 2}, {"k3", 200}, {"F0", 0.1}, {"mu", 2}, {"g", 1}};
    scene_init(scene, NULL);
    for (size_t i = 0; i < COUNT_OF(terms); i++)
        if (which & 1u << i)
            set(scene, terms[i].name, terms[i].value);
}

/* How many methods and drag variants have a kernel there; each gives the same bits. */
static int compare_kernels(const struct scene *scene)
{
    int special = 0;
    for (size_t m = 0; m < method_catalog.count; m++)
        for (enum drag drag = DRAG_DEFAULT; drag < DRAG_COUNT; drag++) {
            struct run *fast = run_of(scene, method_at(m), drag, KERNEL_SPECIALISED, 0.0123);
            if (fast && has_kernel(fast)) {
                struct run *general = run_of(scene, method_at(m), drag, KERNEL_GENERAL, 0.0123);
                go_steps(general, STEPS);
                in_pieces(fast, STEPS);
                assert_same_trace(fast, general);
                assert_int_equal(fast->stop, general->stop);
                if (general->stop != STOP_DIVERGED) { /* a kernel finds that out a little later */
                    if (fast->cost.evals != general->cost.evals)
                        fail_msg("%s, %s, drag %d: %lld evaluations, %lld in general, %lld steps",
                                 scene->preset ? scene->preset->row.name : "typed",
                                 method_at(m)->row.name, (int)drag, (long long)fast->cost.evals,
                                 (long long)general->cost.evals, (long long)general->steps);
                    assert_int_equal(fast->cost.solves, general->cost.solves);
                }
                run_destroy(general);
                special++;
            }
            if (fast)
                run_destroy(fast);
        }
    return special;
}

TEST(test_kernels_give_the_same_bits)
{
    int special = 0;
    for (unsigned which = 0; which < 64; which++) {
        struct scene scene;
        set_terms(&scene, which);
        special += compare_kernels(&scene);
    }
    print_message("# %d combinations of method and oscillator have a kernel\n", special);
    assert_true(special > 150);
}

TEST(test_kernels_of_models)
{
    static const char *const with_kernels[] = {"pendulum", "kepler", "henon-heiles"};
    int special = 0;
    for (size_t p = 0; p < preset_catalog.count; p++) {
        const struct preset *preset = preset_at(p);
        struct scene scene;
        scene_init(&scene, preset);
        const int here = compare_kernels(&scene);
        for (size_t i = 0; i < COUNT_OF(with_kernels); i++)
            if (strcmp(preset->row.name, with_kernels[i]) == 0) {
                assert_true(here >= 20);
                special++;
            }
    }
    assert_int_equal(special, COUNT_OF(with_kernels));
    struct scene driven;
    scene_init(&driven, preset_by_name(TEXT("pendulum")));
    set(&driven, "gamma", 0.3);
    set(&driven, "F0", 0.4);
    assert_true(compare_kernels(&driven) >= 20);
}

/* Diverging: the same last good state. */
TEST(test_kernels_stop_at_the_same_step)
{
    struct scene scene;
    scene_init(&scene, NULL);
    set(&scene, "C", 0.5);
    set(&scene, "F0", 1);
    set(&scene, "k3", 1000);
    static const char *const names[] = {"euler", "rk4", "verlet", "dopri5"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        struct run *fast = start(&scene, names[i], (struct run_settings){.dt = 0.5}, HUGE_VAL);
        struct run *general = start(
            &scene, names[i], (struct run_settings){.dt = 0.5, .kernel = KERNEL_GENERAL}, HUGE_VAL);
        go_steps(fast, 100000);
        go_steps(general, 100000);
        assert_int_equal(fast->stop, general->stop);
        assert_same_trace(fast, general);
        run_destroy(fast);
        run_destroy(general);
    }
}

/* ---- the propagator ---- */

TEST(test_propagator_within_rounding)
{
    int compared = 0;
    for (size_t p = 0; p < preset_catalog.count; p++)
        for (size_t m = 0; m < method_catalog.count; m++) {
            struct scene scene;
            scene_init(&scene, preset_at(p));
            struct run *fast = run_of(&scene, method_at(m), DRAG_DEFAULT, KERNEL_PROPAGATOR, 0.01);
            if (!fast)
                continue;
            if (fast->plan.propagates) {
                struct run *general =
                    run_of(&scene, method_at(m), DRAG_DEFAULT, KERNEL_GENERAL, 0.01);
                go_steps(fast, STEPS);
                go_steps(general, STEPS);
                assert_int_equal(fast->steps, general->steps);
                assert_int_equal(fast->stop, general->stop);
                /* Step by step, an implicit equation loses as many digits as the step is stiff. */
                const struct oscillator *o = &fast->system.oscillator;
                double stiff = fmax(1, 0.01 * fmax(sqrt(fabs(o->stiffness)), fabs(o->damping)));
                double size[2] = {fast->system.scale[0], fast->system.scale[1]};
                for (size_t i = 0; i < trace_count(fast->trace); i++) {
                    const double *a = trace_state(fast->trace, i),
                                 *b = trace_state(general->trace, i);
                    for (int k = 0; k < 2; k++) {
                        size[k] = fmax(size[k], fabs(b[k]));
                        double allowed = 16 * stiff * DBL_EPSILON * (double)(i + 1) * size[k];
                        if (!(fabs(a[k] - b[k]) <= allowed))
                            fail_msg(
                                "%s on %s, step %zu: %.17g and %.17g differ by %.2g, allowed %.2g",
                                method_at(m)->row.name, preset_at(p)->row.name, i, a[k], b[k],
                                fabs(a[k] - b[k]), allowed);
                    }
                }
                assert_int_equal(fast->cost.evals, 0);
                compared++;
                run_destroy(general);
            }
            run_destroy(fast);
        }
    print_message("# %d combinations of method and scene propagate\n", compared);
    assert_true(compared > 100);
}

TEST(test_propagator_in_pieces)
{
    static const char *const names[] = {"euler", "verlet", "rk4", "implicit-midpoint", "exact"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        struct scene scene;
        scene_init(&scene, NULL);
        set(&scene, "g", 9.81);
        set(&scene, "gamma", 0.1);
        const struct run_settings settings = {.dt = 0.01};
        struct run *whole = start(&scene, names[i], settings, HUGE_VAL);
        struct run *pieces = start(&scene, names[i], settings, HUGE_VAL);
        assert_true(whole->plan.propagates);
        go_steps(whole, STEPS);
        in_pieces(pieces, STEPS);
        assert_same_trace(pieces, whole);
        assert_true(run_back(pieces, 777));
        in_pieces(pieces, STEPS);
        assert_same_trace(pieces, whole);
        run_destroy(whole);
        run_destroy(pieces);
    }
}

/* Nothing drifts: the energy of a symplectic method stays where it was after 1e7 steps, as far as
 * rounding allows. */
TEST(test_propagator_does_not_drift)
{
    struct scene scene = spring();
    struct run *run =
        start(&scene, "implicit-midpoint",
              (struct run_settings){.dt = 0.01, .record = {RECORD_EVERY, 100000, 0}}, HUGE_VAL);
    go_steps(run, 10000000);
    double e0 = system_kinetic(&run->system, run->system.start) +
                system_potential(&run->system, run->system.start);
    double e = system_kinetic(&run->system, run->y) + system_potential(&run->system, run->y);
    print_message("# dE/E0 after 1e7 steps: %.2g\n", e / e0 - 1);
    assert_true(fabs(e / e0 - 1) < 1e-12);
    run_destroy(run);
}

RUN_TESTS(NULL, NULL)
