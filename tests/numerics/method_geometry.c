/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Reversibility, area and energy: each flag of each row is verified both ways, so every method without the flag is a
 * negative control. The systems are the undamped spring and Duffing's q'' = -q - q^3 / 2 (which `exact` cannot step).
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "method_testing.h"

static struct system unit_spring(void)
{
    struct system system = SPRING({"m", 1}, {"k", 1}, {"y0", 1});
    return system;
}

static struct system nonlinear_for(const struct method *method)
{
    struct system system = duffing(0.5);
    return applies(method, &system, DRAG_DEFAULT) ? system : unit_spring();
}

static bool has(const struct method *method, enum method_flag flag)
{
    return method->flags & flag;
}

/* n steps of h, then n steps of -h: distance from the start. */
static double return_error(const struct method *method, const struct system *system, double h, long n)
{
    const double start[2] = {1, 0.2};
    double y[2] = {start[0], start[1]};
    if (advance(method, system, h, n, y) != STEP_OK || advance(method, system, -h, n, y) != STEP_OK)
        return HUGE_VAL;
    return distance(system, y, start);
}

static void test_reversal(void **state)
{
    (void)state;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system linear = unit_spring(), nonlinear = nonlinear_for(method);
        double on_spring = return_error(method, &linear, 0.1, 100000);
        double on_duffing = return_error(method, &nonlinear, 0.1, 10000);
        if (has(method, METHOD_SYMMETRIC)) {
            assert_below(method->row.name, on_spring, 1e-10);
            assert_below(method->row.name, on_duffing, 1e-10);
        } else {
            assert_above(method->row.name, fmin(on_spring, on_duffing), 1e-8);
        }
    }
}

/* Drag does not spoil the symmetry of the exact and implicit variants; explicit drag does. */
static void test_reversal_with_drag(void **state)
{
    (void)state;
    struct system system = SPRING({"m", 1}, {"k", 1}, {"gamma", 0.01}, {"C", 0.01}, {"rho", 1}, {"area", 1}, {"y0", 1});
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int drag = DRAG_EXACT; drag < DRAG_COUNT; drag++) {
            const struct method *method = method_at(m);
            if (!applies(method, &system, (enum drag)drag))
                continue;
            double y[2] = {1, 0.2};
            assert_int_equal(advance_as(method, (enum drag)drag, &system, 0, 0.1, 200, y), STEP_OK);
            assert_int_equal(advance_as(method, (enum drag)drag, &system, 0, -0.1, 200, y), STEP_OK);
            double back = distance(&system, y, (double[]){1, 0.2});
            if (has(method, METHOD_SYMMETRIC) && drag != DRAG_EXPLICIT)
                assert_below(method->row.name, back, 1e-12);
            else
                assert_above(method->row.name, back, 1e-6);
        }
}

/* xorshift64*, uniform in [-1, 1] */
static double next_random(uint64_t *seed)
{
    *seed ^= *seed >> 12;
    *seed ^= *seed << 25;
    *seed ^= *seed >> 27;
    return (double)((*seed * 0x2545f4914f6cdd1dull) >> 11) / 4503599627370496.0 - 1;
}

/* Determinant of the one-step map at y by central differences of sixth order. */
static double area_factor(const struct method *method, const struct system *system, double h, const double y[2])
{
    static const double weight[] = {45. / 60, -9. / 60, 1. / 60};
    const double delta = 0.01;
    double jacobian[2][2] = {{0}};
    for (int column = 0; column < 2; column++)
        for (int k = 1; k <= 3; k++)
            for (int sign = -1; sign <= 1; sign += 2) {
                double z[2] = {y[0], y[1]};
                z[column] += sign * k * delta;
                assert_int_equal(advance(method, system, h, 1, z), STEP_OK);
                for (int row = 0; row < 2; row++)
                    jacobian[row][column] += sign * weight[k - 1] * z[row] / delta;
            }
    return jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
}

static void test_area(void **state)
{
    (void)state;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system system = nonlinear_for(method);
        uint64_t seed = 88172645463325252u;
        double largest = 0;
        for (int i = 0; i < 1000; i++) {
            double y[2] = {1.5 * next_random(&seed), 1.5 * next_random(&seed)};
            largest = fmax(largest, fabs(area_factor(method, &system, 0.3, y) - 1));
        }
        if (has(method, METHOD_SYMPLECTIC))
            assert_below(method->row.name, largest, 1e-11);
        else
            assert_above(method->row.name, largest, 1e-8);
    }
}

/* Largest |E - E0| / E0 within n steps; HUGE_VAL if a step fails. */
static double energy_error(const struct method *method, const struct system *system, double h, long n, double energy,
                           double *y)
{
    double largest = 0;
    for (long i = 0; i < n; i++) {
        if (advance(method, system, h, 1, y) != STEP_OK)
            return HUGE_VAL;
        double now = system_kinetic(system, y) + system_potential(system, y);
        largest = fmax(largest, fabs(now / energy - 1));
    }
    return largest;
}

/* The last 1000 steps are not worse than the first 1000; methods neither symplectic nor symmetric drift. */
static void test_energy_stays_bounded(void **state)
{
    (void)state;
    const char *long_form = getenv("LONG");
    const long n = long_form && *long_form ? 1000000 : 100000;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system system = duffing(0.5);
        if (!applies(method, &system, DRAG_DEFAULT))
            continue;
        double y[2] = {1, 0.2}, energy = system_kinetic(&system, y) + system_potential(&system, y);
        double first = energy_error(method, &system, 0.1, 1000, energy, y);
        double middle = advance(method, &system, 0.1, n - 2000, y) == STEP_OK ? 0 : HUGE_VAL;
        double last = fmax(middle, energy_error(method, &system, 0.1, 1000, energy, y));
        if (has(method, METHOD_SYMPLECTIC))
            assert_below(method->row.name, last / first, 1.01);
        else if (!has(method, METHOD_SYMMETRIC))
            assert_above(method->row.name, last, fmin(10 * first, 0.5));
    }
}

static void test_linear_energy_is_kept(void **state)
{
    (void)state;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system system = unit_spring();
        double y[2] = {1, 0.2};
        double largest = energy_error(method, &system, 0.5, 1000, 0.52, y);
        if (has(method, METHOD_ENERGY))
            assert_below(method->row.name, largest, 1e-12);
        else
            assert_above(method->row.name, largest, 1e-6);
    }
}

/* The invariants of the discrete flows: v^2 + q^2 (1 - x^2/4) for Verlet, v^2 + q^2 -+ x q v for the symplectic Eulers.
 */
static void test_modified_invariants(void **state)
{
    (void)state;
    const struct {
        const char *name;
        double q2, qv;
    } rows[] = {{"verlet", 1 - 0.16 / 4, 0}, {"symplectic-euler", 1, 0.4}, {"symplectic-euler-kick", 1, -0.4}};
    struct system system = unit_spring();
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        double y[2] = {1, 0.2}, first = 0.04 + rows[i].q2 + rows[i].qv * 0.2;
        for (int n = 0; n < 1000; n++) {
            assert_int_equal(advance(method_named(rows[i].name), &system, 0.4, 1, y), STEP_OK);
            assert_near(rows[i].name, y[1] * y[1] + rows[i].q2 * y[0] * y[0] + rows[i].qv * y[0] * y[1], first, 1e-13);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reversal),
        cmocka_unit_test(test_reversal_with_drag),
        cmocka_unit_test(test_area),
        cmocka_unit_test(test_energy_stays_bounded),
        cmocka_unit_test(test_linear_energy_is_kept),
        cmocka_unit_test(test_modified_invariants),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
