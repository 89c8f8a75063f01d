/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The contract of method_step() for every row: costs, memory, failure, reuse, no allocation,
 * symmetries to the bit. */
#include "cmocka_testing.h"

#include "numerics/method/testing.h"

/* ---- counting allocations: through the sanitizer's hook, or in front of glibc's own functions
 * ---- */

static volatile long allocations;

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define HAS_HOOKS
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define HAS_HOOKS
#endif

#ifdef HAS_HOOKS
int __sanitizer_install_malloc_and_free_hooks(void (*allocated)(const volatile void *, size_t),
                                              void (*freed)(const volatile void *));
static void allocated(const volatile void *block, size_t size)
{
    (void)block, (void)size;
    allocations = allocations + 1;
}
static void freed(const volatile void *block)
{
    (void)block;
}
static int start_counting(void **state)
{
    (void)state;
    return __sanitizer_install_malloc_and_free_hooks(allocated, freed) > 0 ? 0 : -1;
}
#else
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);

void *malloc(size_t size)
{
    allocations = allocations + 1;
    return __libc_malloc(size);
}
void *calloc(size_t count, size_t size)
{
    allocations = allocations + 1;
    return __libc_calloc(count, size);
}
void *realloc(void *old, size_t size)
{
    allocations = allocations + 1;
    return __libc_realloc(old, size);
}
static int start_counting(void **state)
{
    (void)state;
    return 0;
}
#endif

/* As much as the method can take: quadratic drag, else linear drag, else none. */
static struct system rich_system(const struct method *method)
{
    const struct system systems[] = {
        SPRING({"gamma", 0.4}, {"C", 2}, {"area", 0.1}, {"F0", 0.1}, {"g", 0.3}),
        SPRING({"gamma", 0.4}, {"F0", 0.1}, {"g", 0.3}), SPRING({"F0", 0.1}, {"g", 0.3}),
        SPRING({"g", 0.3})};
    return first_fit(method, systems, COUNT_OF(systems));
}

static void test_nothing_is_allocated(void **state)
{
    (void)state;
    static double work[WORK_CAPACITY];
    long before = allocations;
    void *volatile block = malloc(1);
    free(block);
    if (allocations == before) {
        print_message("another tool (valgrind) owns the allocator\n");
        skip();
    }
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        struct system systems[] = {rich_system(method), duffing(1)};
        for (size_t s = 0; s < COUNT_OF(systems); s++) {
            enum drag drag = DRAG_DEFAULT;
            struct error error;
            if (!method_applies(method, &systems[s], &drag, &error))
                continue;
            double y[2] = {0.05, 0}, inside[2];
            struct step step = step_begin(&systems[s], drag, 0, 0.01, y, work);
            struct controller controller = {.tol = 1e-6};
            before = allocations;
            for (int i = 0; i < 10; i++)
                assert_int_equal(method_step(method, &step), STEP_OK);
            method_dense(method, &step, (double[]){0.05, 0}, 0.5, inside);
            if (method->flags & METHOD_ADAPTIVE)
                assert_int_equal(method_adapt(method, &step, &controller, 9), STEP_OK);
            assert_int_equal(allocations, before);
        }
    }
}

static void test_costs(void **state)
{
    (void)state;
    static double work[WORK_CAPACITY];
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        /* Implicit methods need one solve where the scene is linear. */
        struct system system = method->flags & METHOD_IMPLICIT ? SPRING({"gamma", 0.4}, {"g", 0.3})
                                                               : rich_system(method);
        enum drag drag = DRAG_DEFAULT;
        struct error error;
        assert_true(method_applies(method, &system, &drag, &error));
        double y[2] = {0.05, 0};
        /* the others are stable there */
        double h = method->flags & METHOD_MULTISTEP ? 1. / 64 : 0.25;
        struct step step = step_begin(&system, drag, 2, h, y, work);
        assert_int_equal(method_step(method, &step), STEP_OK);
        assert_true(step.warm && step.t == 2 + h);
        struct cost cold = step.cost;
        if (method->flags & METHOD_MULTISTEP) /* starts by another method */
            for (int i = 0; i < 8; i++, cold = step.cost)
                assert_int_equal(method_step(method, &step), STEP_OK);
        else
            assert_in_range(cold.evals, method->evals, method->evals + 1);
        assert_int_equal(method_step(method, &step), STEP_OK);
        assert_int_equal(step.cost.evals - cold.evals, method->evals);
        assert_int_equal(step.cost.solves > 0,
                         !!(method->flags & (METHOD_IMPLICIT | METHOD_EXACT)));
        assert_int_equal(step.cost.rejected, 0);
    }
}

/* Newton's iteration counts what it does. */
static void test_costs_of_newton(void **state)
{
    (void)state;
    static double work[WORK_CAPACITY];
    struct system system = duffing(1);
    double y[2] = {1, 0};
    struct step step = step_begin(&system, DRAG_DEFAULT, 0, 0.1, y, work);
    assert_int_equal(method_step(method_named("backward-euler"), &step), STEP_OK);
    assert_in_range(step.cost.jacobians, 1, 10);
    assert_in_range(step.cost.solves, 3, 20);
    assert_in_range(step.cost.evals, step.cost.solves, step.cost.solves + 2);
}

/* Work memory: nothing beyond method_work_size() is touched, and what a cold step finds there does
 * not matter. */
static void test_work_memory(void **state)
{
    (void)state;
    static double work[2][WORK_CAPACITY];
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        struct system systems[] = {rich_system(method), duffing(1)};
        for (size_t s = 0; s < COUNT_OF(systems); s++) {
            enum drag drag = DRAG_DEFAULT;
            struct error error;
            if (!method_applies(method, &systems[s], &drag, &error))
                continue;
            size_t size = method_work_size(method, 2);
            assert_in_range(size, 1, WORK_CAPACITY / 2);
            double y[2][2];
            for (int k = 0; k < 2; k++) {
                double e[2];
                for (size_t i = 0; i < WORK_CAPACITY; i++)
                    work[k][i] = k ? 1e99 : NAN;
                y[k][0] = 0.05, y[k][1] = -0.1;
                struct step step = step_begin(&systems[s], drag, 0, 0.02, y[k], work[k]);
                step.error = e;
                for (int i = 0; i < 3; i++)
                    assert_int_equal(method_step(method, &step), STEP_OK);
            }
            assert_memory_equal(y[0], y[1], sizeof y[0]);
            for (size_t i = size; i < WORK_CAPACITY; i++)
                assert_true(work[1][i] == 1e99);
        }
    }
}

/* A step may depend on more than the state it begins with. */
static bool remembers(const struct method *method)
{
    static const char *const rows[] = {"hht", "generalised-alpha", "wilson-theta"};
    bool found = method->flags & METHOD_MULTISTEP;
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        found |= strcmp(method->row.name, rows[i]) == 0;
    return found;
}

/*
 * What a warm step reuses is what a cold one computes: the same bits (a clock that runs can differ
 * by its rounding), or, where the last stage's slope comes out of an equation that was solved, the
 * same within rounding.
 */
static void test_warm_equals_cold(void **state)
{
    (void)state;
    static double work[2][WORK_CAPACITY];
    const struct system systems[] = {SPRING({"gamma", 0.4}, {"C", 2}, {"area", 0.1}, {"g", 0.3}),
                                     SPRING({"gamma", 0.4}, {"g", 0.3}), SPRING({"g", 0.3})};
    for (size_t m = 0; m < own_methods(); m++)
        for (int variant = DRAG_DEFAULT; variant < DRAG_COUNT; variant++) {
            const struct method *method = method_at(m);
            const struct system system = first_fit(method, systems, COUNT_OF(systems));
            enum drag drag = (enum drag)variant;
            struct error error;
            if (remembers(method) || !method_applies(method, &system, &drag, &error))
                continue;
            double warm[2] = {0.05, 0.3}, cold[2] = {0.05, 0.3};
            struct step a = step_begin(&system, drag, 0, 0.03125, warm, work[0]);
            struct step b = step_begin(&system, drag, 0, 0.03125, cold, work[1]);
            for (int i = 0; i < 100; i++) {
                assert_int_equal(method_step(method, &a), STEP_OK);
                b.warm = false;
                assert_int_equal(method_step(method, &b), STEP_OK);
            }
            if (method->flags & METHOD_IMPLICIT) {
                assert_near(method->row.name, warm[0], cold[0], 1e-15);
                assert_near(method->row.name, warm[1], cold[1], 1e-14);
            } else {
                assert_memory_equal(warm, cold, sizeof warm);
            }
        }
}

/* ---- failure ---- */

/* Not a number beyond q = c, and then only. */
static void wall_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] += y[0] > c[0] ? NAN : 1;
}
static void wall_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)c, (void)t, (void)y, (void)jac;
}
static const struct term_row wall_row = {
    .row = {"wall", "m/s^2", "", "", NULL}, .add = wall_add, .jacobian = wall_jacobian};

/* v' = exp(v): backward Euler has no solution once h exp(v) > 1/e. */
static void blow_add(const double *c, double t, const double *y, double *a)
{
    (void)c, (void)t;
    a[0] += exp(y[1]);
}
static void blow_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)c, (void)t;
    jac[1] += exp(y[1]);
}
static const struct term_row blow_row = {.row = {"blow", "m/s^2", "", "", NULL},
                                         .flags = TERM_VELOCITY,
                                         .add = blow_add,
                                         .jacobian = blow_jacobian};

static void assert_failure_restores(const struct method *method, const struct system *system,
                                    enum drag drag, double t, const double start[2], bool warm_up)
{
    static double work[WORK_CAPACITY];
    struct error error;
    if (!method_applies(method, system, &drag, &error))
        return;
    double y[2] = {start[0], start[1]};
    struct step step = step_begin(system, drag, t, 0.1, y, work);
    enum step_status status = STEP_OK;
    double before[2] = {start[0], start[1]}, t_before = t;
    for (int i = 0; i < 1000 && status == STEP_OK; i++) {
        memcpy(before, y, sizeof y);
        t_before = step.t;
        status = method_step(method, &step);
        assert_true(warm_up || status != STEP_OK);
    }
    if (status != STEP_NONFINITE && status != STEP_NO_SOLUTION)
        fail_msg("%s: the step did not fail (status %d)", method->row.name, status);
    assert_memory_equal(y, before, sizeof y);
    assert_true(step.t == t_before && !step.warm);
}

static void test_failure_restores(void **state)
{
    (void)state;
    struct system wall = other_system(&wall_row, 1);
    struct system spring_system = SPRING({NULL, 0});
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        if (!(method->flags & METHOD_EXACT)) {
            assert_failure_restores(method, &wall, DRAG_DEFAULT, 0, (double[]){0.03, 1}, true);
            assert_failure_restores(method, &wall, DRAG_DEFAULT, 0, (double[]){1.03, 1}, false);
        }
        assert_failure_restores(method, &spring_system, DRAG_DEFAULT, 0, (double[]){NAN, -0.0},
                                false);
        assert_failure_restores(method, &spring_system, DRAG_DEFAULT, 0, (double[]){0.5, HUGE_VAL},
                                false);
    }
}

static void test_no_solution(void **state)
{
    (void)state;
    static double work[WORK_CAPACITY];
    struct system system = other_system(&blow_row, 0);
    double y[2] = {0, 0};
    struct step step = step_begin(&system, DRAG_DEFAULT, 0, 0.3, y, work);
    assert_int_equal(method_step(method_named("backward-euler"), &step), STEP_OK); /* 0.3 < 1/e */
    double v = y[1];
    assert_near("root", v, 0.3 * exp(v), 1e-15);
    memset(y, 0, sizeof y);
    step = step_begin(&system, DRAG_DEFAULT, 0, 0.4, y, work);
    /* 0.4 > 1/e */
    assert_int_equal(method_step(method_named("backward-euler"), &step), STEP_NO_SOLUTION);
    assert_true(y[0] == 0 && y[1] == 0 && step.t == 0);

    /* In closed form: an unstable spring at the step where the matrix is singular, and drag with
     * nothing to hold on to.
     */
    struct system unstable = SPRING({"m", 1}, {"k", -1});
    double z[2] = {0.05, 0};
    step = step_begin(&unstable, DRAG_DEFAULT, 0, 1, z, work);
    assert_int_equal(method_step(method_named("backward-euler"), &step), STEP_NO_SOLUTION);
    assert_true(z[0] == 0.05 && z[1] == 0 && step.t == 0);
    assert_int_equal(advance(method_named("backward-euler"), &unstable, 0.5, 1, z), STEP_OK);
}

/* ---- symmetries, to the bit ---- */

static void test_symmetries(void **state)
{
    (void)state;
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        const struct system kinds[] = {SPRING({"gamma", 0.4}, {"C", 2}, {"area", 0.1}),
                                       SPRING({"gamma", 0.4}), SPRING({NULL, 0})};
        const struct system odd = first_fit(method, kinds, 3),
                            linear = first_fit(method, kinds + 1, 2);
        double y[2] = {0.05, 0.3}, mirrored[2] = {-0.05, -0.3}, later[2] = {0.05, 0.3},
               parts[2] = {0.05, 0.3};
        assert_int_equal(advance(method, &odd, 0.03, 100, y), STEP_OK);
        assert_int_equal(advance(method, &odd, 0.03, 100, mirrored), STEP_OK);
        assert_true(mirrored[0] == -y[0] && mirrored[1] == -y[1]);
        assert_int_equal(advance_as(method, DRAG_DEFAULT, &odd, 777, 0.03, 100, later), STEP_OK);
        assert_memory_equal(later, y, sizeof y);
        if (!remembers(method)) {
            assert_int_equal(advance(method, &odd, 0.03, 37, parts), STEP_OK);
            assert_int_equal(advance(method, &odd, 0.03, 63, parts), STEP_OK);
            assert_memory_equal(parts, y, sizeof y);
        }

        double plain[2] = {0.05, 0.3}, scaled[2] = {ldexp(0.05, 30), ldexp(0.3, 30)};
        assert_int_equal(advance(method, &linear, 0.03, 100, plain), STEP_OK);
        assert_int_equal(advance(method, &linear, 0.03, 100, scaled), STEP_OK);
        assert_true(scaled[0] == ldexp(plain[0], 30) && scaled[1] == ldexp(plain[1], 30));
    }
}

/* Error estimate: about the difference of the two orders, absent where there is none. */
static void test_error_estimate(void **state)
{
    (void)state;
    static double work[WORK_CAPACITY];
    for (size_t m = 0; m < own_methods(); m++) {
        const struct method *method = method_at(m);
        struct system system = rich_system(method);
        double size[2];
        enum drag drag = DRAG_DEFAULT;
        struct error error;
        assert_true(method_applies(method, &system, &drag, &error));
        for (int i = 0; i < 2; i++) {
            double y[2] = {0.05, 0}, e[2] = {-7, -7};
            struct step step = step_begin(&system, drag, 0,
                                          (method->embedded > 8 ? 0.1 : 0.01) * (2 - i), y, work);
            step.error = e;
            assert_int_equal(method_step(method, &step), STEP_OK);
            size[i] = hypot(e[0] / system.scale[0], e[1] / system.scale[1]);
            if (!(method->flags & METHOD_ADAPTIVE))
                assert_true(e[0] == -7 && e[1] == -7);
        }
        if (method->flags & METHOD_ADAPTIVE)
            assert_near(method->row.name, log2(size[0] / size[1]), method->embedded + 1, 0.3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_nothing_is_allocated, start_counting),
        cmocka_unit_test(test_costs),
        cmocka_unit_test(test_costs_of_newton),
        cmocka_unit_test(test_work_memory),
        cmocka_unit_test(test_warm_equals_cold),
        cmocka_unit_test(test_failure_restores),
        cmocka_unit_test(test_no_solution),
        cmocka_unit_test(test_symmetries),
        cmocka_unit_test(test_error_estimate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
