/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear stability: limits against independent tables and closed forms, one-step matrices, and the A and L flags. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "method_testing.h"

#define RT2 0.70710678118654752

static const double zetas[] = {0, 0.001, 0.01, 0.05, 0.1, 0.2, 0.5, RT2, 1, 2, 5, 10, 100};

struct row_of_limits {
    const char *methods[3];
    enum drag drag;
    double limit[COUNT_OF(zetas)];
};

/* Computed with 40 digits from the one-step matrices. */
static const struct row_of_limits limits[] = {
    {{"euler"},
     DRAG_DEFAULT,
     {0, 0.002, 0.02, 0.1, 0.2, 0.4, 1, 1.4142136, 2, 0.53589838, 0.20204103, 0.10025126, 0.01000025}},
    {{"symplectic-euler", "symplectic-euler-kick", "position-verlet"},
     DRAG_EXPLICIT,
     {2, 1.998001, 1.9801, 1.9024984, 1.8099751, 1.6396078, 1.236068, 1.0352762, 0.82842712, 0.47213595, 0.19803903,
      0.099751242, 0.00999975}},
    {{"symplectic-euler", "symplectic-euler-kick"},
     DRAG_IMPLICIT,
     {2, 2.002001, 2.0201, 2.1024984, 2.2099751, 2.4396078, 3.236068, 3.8637033, 4.8284271, 8.472136, 20.198039,
      40.099751, 400.01}},
    {{"symplectic-euler", "symplectic-euler-kick"},
     DRAG_EXACT,
     {2, 2.0000013, 2.0001333, 2.0033395, 2.0134315, 2.0549247, 2.3993573, 2.9208292, 4.0026703, 8, 20, 40, 400}},
    {{"verlet"},
     DRAG_EXPLICIT,
     {2, 1.9990013, 1.990125, 1.9531291, 1.9125723, 1.8514043, 2, 2.8284271, 2, 1, 0.4, 0.2, 0.02}},
    {{"verlet", "position-verlet"}, DRAG_IMPLICIT, {2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2}},
    {{"verlet", "position-verlet"}, DRAG_EXACT, {2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2}},
    {{"midpoint", "heun"},
     DRAG_DEFAULT,
     {0, 0.20132884, 0.44400333, 0.8, 1.0497546, 1.3939076, 2, 2.1831059, 2, 0.53589838, 0.20204103, 0.10025126,
      0.01000025}},
    {{"rk4"},
     DRAG_DEFAULT,
     {2.8284271, 2.8305407, 2.8485701, 2.9097997, 2.950853, 2.9400877, 2.6225425, 2.7043535, 2.7852936, 0.74631716,
      0.28137179, 0.13961459, 0.013926816}},
    {{"dopri5"},
     DRAG_DEFAULT,
     {0.99718901, 1.3809078, 1.8721301, 2.4025609, 2.6814071, 3.0007419, 3.3989915, 3.2966448, 3.3065679, 0.8859922,
      0.33403119, 0.1657438, 0.016533253}},
};

static void test_limits_table(void **state)
{
    (void)state;
    for (size_t r = 0; r < COUNT_OF(limits); r++)
        for (size_t m = 0; m < 3 && limits[r].methods[m]; m++)
            for (size_t z = 0; z < COUNT_OF(zetas); z++) {
                char what[80];
                snprintf(what, sizeof what, "%s drag %d zeta %g", limits[r].methods[m], limits[r].drag, zetas[z]);
                double want = limits[r].limit[z];
                double got = method_stable_limit(method_named(limits[r].methods[m]), limits[r].drag, zetas[z]);
                assert_near(what, got, want, 1e-6 * want);
            }
}

static void test_closed_forms(void **state)
{
    (void)state;
    for (double zeta = 0.03; zeta < 8; zeta *= 1.7) {
        double euler = zeta <= 1 ? 2 * zeta : 2 * (zeta - sqrt(zeta * zeta - 1));
        assert_near("euler", method_stable_limit(method_named("euler"), DRAG_DEFAULT, zeta), euler, 1e-6 * euler);
        const struct method *symplectic = method_named("symplectic-euler");
        double root = sqrt(1 + zeta * zeta);
        assert_near("explicit", method_stable_limit(symplectic, DRAG_EXPLICIT, zeta), 2 * (root - zeta), 1e-6);
        assert_near("default", method_stable_limit(symplectic, DRAG_DEFAULT, zeta), 2 * (root - zeta), 1e-6);
        assert_near("implicit", method_stable_limit(symplectic, DRAG_IMPLICIT, zeta), 2 * (root + zeta), 1e-5 * root);
        double exact = method_stable_limit(symplectic, DRAG_EXACT, zeta);
        assert_near("exact", exact * tanh(zeta * exact), 4 * zeta, 1e-5 * zeta);
    }
    assert_true(isnan(method_stable_limit(method_named("rk4"), DRAG_EXACT, 0.1)));
    assert_near("negative damping", method_stable_limit(method_named("rk4"), DRAG_DEFAULT, -0.1), 0, 0);
}

/* Stable for every step, also heavily damped ones. */
static bool stable_everywhere(const struct method *method)
{
    for (size_t z = 0; z < COUNT_OF(zetas); z++)
        if (method_stable_limit(method, DRAG_DEFAULT, zetas[z]) < HUGE_VAL)
            return false;
    return true;
}

/* What is fast dies out within one huge step. */
static bool damps_at_infinity(const struct method *method)
{
    double matrix[4];
    for (double zeta = 0.5; zeta < 3; zeta *= 2)
        if (!method_amplification(method, DRAG_DEFAULT, 1e6, zeta, matrix) || matrix_spectral_radius(matrix) > 1e-3)
            return false;
    return true;
}

static void test_stability_flags(void **state)
{
    (void)state;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        bool a = stable_everywhere(method);
        if (a != !!(method->flags & METHOD_A_STABLE))
            fail_msg("%s: A-stable is %d, the row says otherwise", method->row.name, a);
        bool l = a && damps_at_infinity(method);
        if (l != !!(method->flags & METHOD_L_STABLE))
            fail_msg("%s: L-stable is %d, the row says otherwise", method->row.name, l);
    }
}

static void assert_matrix(const char *name, enum drag drag, double x, double zeta, const double want[4])
{
    double got[4];
    assert_true(method_amplification(method_named(name), drag, x, zeta, got));
    for (int i = 0; i < 4; i++)
        assert_near(name, got[i], want[i], 4e-15 * (1 + x * x));
}

static void test_one_step_matrices(void **state)
{
    (void)state;
    for (double zeta = 0; zeta < 3; zeta += 0.37)
        for (double x = 0.01; x < 30; x *= 1.9) {
            double c = 2 * zeta * x, a = 1 + c + x * x, e = exp(-c), m = 1 + c / 2 + x * x / 4;
            assert_matrix("euler", DRAG_DEFAULT, x, zeta, (double[]){1, x, -x, 1 - c});
            assert_matrix("backward-euler", DRAG_DEFAULT, x, zeta, (double[]){(1 + c) / a, x / a, -x / a, 1 / a});
            assert_matrix("symplectic-euler-kick", DRAG_EXPLICIT, x, zeta,
                          (double[]){1 - x * x, x * (1 - c), -x, 1 - c});
            double cayley[4] = {(1 + c / 2 - x * x / 4) / m, x / m, -x / m, (1 - c / 2 - x * x / 4) / m};
            assert_matrix("implicit-midpoint", DRAG_DEFAULT, x, zeta, cayley);
            assert_matrix("trapezoid", DRAG_DEFAULT, x, zeta, cayley);
            double got[4];
            assert_true(method_amplification(method_named("verlet"), DRAG_EXACT, x, zeta, got));
            assert_near("verlet det", got[0] * got[3] - got[1] * got[2], e, 1e-14 * (1 + x * x) * (1 + x * x));
            assert_near("verlet trace", got[0] + got[3], (1 - x * x / 2) * (1 + e), 1e-14 * (1 + x * x));
        }
}

static void test_spectral_radius(void **state)
{
    (void)state;
    assert_near("rotation", matrix_spectral_radius((double[]){0.6, 0.8, -0.8, 0.6}), 1, 1e-15);
    assert_near("real pair", matrix_spectral_radius((double[]){-3, 0, 7, 2}), 3, 1e-15);
    assert_near("hyperbolic", matrix_spectral_radius((double[]){0, 2, 2, 0}), 2, 1e-15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_spectral_radius), cmocka_unit_test(test_one_step_matrices),
        cmocka_unit_test(test_limits_table),    cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_stability_flags),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
