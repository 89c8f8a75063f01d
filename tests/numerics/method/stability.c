/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear stability: limits against independent tables and closed forms, one-step matrices, and the
 * A and L flags. */
#include "cmocka_testing.h"

#include "numerics/method/testing.h"

#define RT2 0.70710678118654752

static const double zetas[] = {0, 0.001, 0.01, 0.05, 0.1, 0.2, 0.5, RT2, 1, 2, 5, 10, 100};

struct row_of_limits {
    const char *methods[3];
    enum drag drag;
    double limit[COUNT_OF(zetas)];
};

/* Computed with 40 digits from the one-step matrices and characteristic polynomials. */
/* clang-format off */
static const struct row_of_limits limits[] = {
    {{"euler"},
     DRAG_DEFAULT,
     {0, 0.0020000002, 0.02, 0.1, 0.2, 0.4, 1, 1.4142136, 2, 0.53589838, 0.20204103, 0.10025126, 0.01000025}},
    {{"symplectic-euler", "symplectic-euler-kick"},
     DRAG_EXPLICIT,
     {2, 1.998001, 1.9801, 1.9024984, 1.8099751, 1.6396078, 1.236068, 1.0352762, 0.82842712, 0.47213595,
      0.19803903, 0.099751242, 0.00999975}},
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
    {{"verlet", "position-verlet"},
     DRAG_IMPLICIT,
     {2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2}},
    {{"verlet", "position-verlet"},
     DRAG_EXACT,
     {2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2}},
    {{"position-verlet"},
     DRAG_EXPLICIT,
     {2, 1.998001, 1.9801, 1.9024984, 1.8099751, 1.6396078, 1.236068, 1.0352762, 0.82842712, 0.47213595,
      0.19803903, 0.099751242, 0.00999975}},
    {{"midpoint", "heun", "ralston"},
     DRAG_DEFAULT,
     {0, 0.20132884, 0.44400333, 0.8, 1.0497546, 1.3939076, 2, 2.1831059, 2, 0.53589838, 0.20204103, 0.10025126,
      0.01000025}},
    {{"kutta3", "bogacki-shampine"},
     DRAG_DEFAULT,
     {1.7320508, 1.7389875, 1.7964875, 1.9879832, 2.1540485, 2.3695849, 2.521659, 2.3747458, 2.5127453, 0.67328808,
      0.25383883, 0.12595294, 0.012564041}},
    {{"rk4", "rk38"},
     DRAG_DEFAULT,
     {2.8284271, 2.8305407, 2.8485701, 2.9097997, 2.950853, 2.9400877, 2.6225425, 2.7043535, 2.7852936, 0.74631716,
      0.28137179, 0.13961459, 0.013926816}},
    {{"dopri5"},
     DRAG_DEFAULT,
     {0.99718901, 1.3809078, 1.8721301, 2.4025609, 2.6814071, 3.0007419, 3.3989915, 3.2966448, 3.3065679,
      0.8859922, 0.33403119, 0.1657438, 0.016533253}},
    {{"tsit5"},
     DRAG_DEFAULT,
     {0.47797887, 1.3397249, 1.9165666, 2.5013382, 2.7779402, 3.0768413, 3.5359977, 3.4834531, 3.506847,
      0.93965682, 0.35426349, 0.17578291, 0.017534673}},
    {{"dop853"},
     DRAG_DEFAULT,
     {5.9603598, 5.968294, 6.0316947, 6.2034212, 6.2810117, 6.3025285, 6.7659368, 6.5113629, 6.3936515, 1.7131738,
      0.64588997, 0.3204858, 0.031969057}},
    {{"ab2"},
     DRAG_DEFAULT,
     {0, 0.15774638, 0.3322819, 0.53883642, 0.6491695, 0.7654366, 0.91082008, 0.95834281, 1, 0.26794919,
      0.10102051, 0.050125629, 0.005000125}},
    {{"ab3"},
     DRAG_DEFAULT,
     {0.72362723, 0.72328548, 0.72024018, 0.70734453, 0.6925631, 0.66666667, 0.60842062, 0.57872739, 0.54545455,
      0.1461541, 0.055102099, 0.027341252, 0.0027273409}},
    {{"ab4"},
     DRAG_DEFAULT,
     {0.42998708, 0.4297425, 0.42756286, 0.41831851, 0.40767484, 0.38889031, 0.34620696, 0.32438066, 0.3,
      0.080384758, 0.030306154, 0.015037689, 0.0015000375}},
    {{"ab5"},
     DRAG_DEFAULT,
     {0, 0.22395724, 0.22306068, 0.21920773, 0.21467185, 0.20641297, 0.18650663, 0.17575899, 0.16333938,
      0.043766656, 0.016500628, 0.0081874893, 0.00081671733}},
    {{"abm2"},
     DRAG_DEFAULT,
     {1.2871885, 1.2879781, 1.2948009, 1.3202259, 1.3444246, 1.378911, 1.4392328, 1.4727985, 2, 0.53589838,
      0.20204103, 0.10025126, 0.01000025}},
    {{"abm3"},
     DRAG_DEFAULT,
     {0, 1.1640762, 1.1627511, 1.1574834, 1.1522165, 1.1455905, 1.1545619, 1.1939996, 1.7287836, 0.46322616,
      0.17464261, 0.086656364, 0.0086441339}},
    {{"abm4"},
     DRAG_DEFAULT,
     {0, 0.38156841, 0.76012949, 0.91733906, 0.91010314, 0.89990144, 0.89947663, 0.9311285, 1.2848163, 0.34426548,
      0.1297928, 0.064402223, 0.0064242419}},
    {{"abm5"},
     DRAG_DEFAULT,
     {0.25871175, 0.48779009, 0.68970232, 0.69984634, 0.69496013, 0.68801136, 0.68849871, 0.71230246, 0.94691703,
      0.25372565, 0.095658046, 0.047464812, 0.0047347035}},
};
/* clang-format on */

TEST(test_limits_table)
{
    for (size_t r = 0; r < COUNT_OF(limits); r++)
        for (size_t m = 0; m < 3 && limits[r].methods[m]; m++)
            for (size_t z = 0; z < COUNT_OF(zetas); z++) {
                char what[80];
                snprintf(what, sizeof what, "%s drag %d zeta %g", limits[r].methods[m],
                         limits[r].drag, zetas[z]);
                double want = limits[r].limit[z];
                double got = method_stable_limit(method_named(limits[r].methods[m]), limits[r].drag,
                                                 zetas[z]);
                assert_near(what, got, want, 1e-6 * want);
            }
}

/* ---- columns Im and Re: the limits without damping, and those of what only decays ---- */

static const struct {
    const char *name;
    double imaginary, real; /* NAN: not known */
} axes[] = {
    {"euler", 0, 2},
    {"midpoint", 0, 2},
    {"heun", 0, 2},
    {"ralston", 0, 2},
    {"kutta3", 1.7320508076, 2.512745327},
    {"bogacki-shampine", 1.7320508076, 2.512745327},
    {"rk4", 2.8284271247, 2.785293563},
    {"rk38", 2.8284271247, 2.785293563},
    {"dopri5", 0.997189009, 3.306567893},
    {"tsit5", 0.477978869, 3.506846994},
    {"dop853", 5.960359812, 6.393651523},
    {"symplectic-euler", 2, NAN},
    {"symplectic-euler-kick", 2, NAN},
    {"verlet", 2, NAN},
    {"position-verlet", 2, NAN},
    {"ruth3", 2.507481171, NAN},
    {"forest-ruth", 1.573401947, NAN},
    {"suzuki4", 2.720974539, NAN},
    {"mclachlan5", 3.035501218, NAN},
    {"pefrl", 2.989449546, NAN},
    {"blanes-moan4", 3.163465067, NAN},
    {"blanes-moan4s", 3.132823398, NAN},
    {"yoshida6", 2.269057996, NAN},
    {"kahan-li6", 2.532627388, NAN},
    {"blanes-moan6", 3.134247522, NAN},
    {"blanes-moan6-11", 3.141431088, NAN},
    {"blanes-moan6-14", 3.140925083, NAN},
    {"yoshida8", 3.393234268, NAN},
    {"kahan-li8", 3.096438680, NAN},
    {"ab2", 0, 1},
    {"ab3", NAN, 6. / 11},
    {"ab4", NAN, 0.3},
    {"ab5", 0, 90. / 551},
    {"abm2", NAN, 2},
    {"abm3", 0, NAN},
    {"abm4", 0, NAN},
    {"bdf3", 0, HUGE_VAL},
    {"bdf4", 0, HUGE_VAL},
    {"bdf5", 0.710807671, HUGE_VAL},
    {"bdf6", 0.843138162, HUGE_VAL},
};

TEST(test_limits_on_the_axes)
{
    /* the fast decay is exp(-fast t) */
    const double zeta = 100, fast = zeta + sqrt((zeta - 1) * (zeta + 1));
    for (size_t i = 0; i < COUNT_OF(axes); i++) {
        const struct method *method = method_named(axes[i].name);
        if (!isnan(axes[i].imaginary))
            assert_near(axes[i].name, method_stable_limit(method, DRAG_DEFAULT, 0),
                        axes[i].imaginary, 2e-9 * axes[i].imaginary);
        double damped = method_stable_limit(method, DRAG_DEFAULT, zeta) * fast;
        if (!isnan(axes[i].real))
            assert_near(axes[i].name, damped, axes[i].real, 1e-9 * axes[i].real);
    }
}

TEST(test_closed_forms)
{
    for (double zeta = 0.03; zeta < 8; zeta *= 1.7) {
        double euler = zeta <= 1 ? 2 * zeta : 2 * (zeta - sqrt(zeta * zeta - 1));
        assert_near("euler", method_stable_limit(method_named("euler"), DRAG_DEFAULT, zeta), euler,
                    1e-6 * euler);
        const struct method *symplectic = method_named("symplectic-euler");
        double root = sqrt(1 + zeta * zeta);
        assert_near("explicit", method_stable_limit(symplectic, DRAG_EXPLICIT, zeta),
                    2 * (root - zeta), 1e-6);
        assert_near("default", method_stable_limit(symplectic, DRAG_DEFAULT, zeta),
                    2 * (root - zeta), 1e-6);
        assert_near("implicit", method_stable_limit(symplectic, DRAG_IMPLICIT, zeta),
                    2 * (root + zeta), 1e-5 * root);
        /* Kicks with explicit drag in both halves: the smallest root of a cubic, if it comes before
         * 2/zeta. */
        double kick = method_stable_limit(method_named("verlet"), DRAG_EXPLICIT, zeta), x = kick;
        double cubic = zeta * x * x * x + (4 * zeta * zeta - 2) * x * x - 8 * zeta * x + 8;
        assert_near("two kicks", zeta <= 0.5 ? cubic : kick - 2 / zeta, 0, 1e-6);
        double exact = method_stable_limit(symplectic, DRAG_EXACT, zeta);
        assert_near("exact", exact * tanh(zeta * exact), 4 * zeta, 1e-5 * zeta);
    }
    assert_true(isnan(method_stable_limit(method_named("rk4"), DRAG_EXACT, 0.1)));
    assert_near("negative damping", method_stable_limit(method_named("rk4"), DRAG_DEFAULT, -0.1), 0,
                0);
}

/* Stable for every step, also heavily damped ones. */
static bool stable_everywhere(const struct method *method)
{
    for (size_t z = 0; z < COUNT_OF(zetas); z++)
        if (method_stable_limit(method, DRAG_DEFAULT, zetas[z]) < HUGE_VAL)
            return false;
    return true;
}

/* What is fast dies out within a few huge steps. */
static bool damps_at_infinity(const struct method *method)
{
    for (double zeta = 0.5; zeta < 3; zeta *= 2)
        if (!(method_growth(method, DRAG_DEFAULT, 1e7, zeta) < 1e-3))
            return false;
    return true;
}

TEST(test_stability_flags)
{
    for (size_t i = 0; i < own_methods(); i++) {
        const struct method *method = method_at(i);
        bool a = stable_everywhere(method);
        if (a != !!(method->flags & METHOD_A_STABLE))
            fail_msg("%s: A-stable is %d, the row says otherwise", method->row.name, a);
        bool l = a && damps_at_infinity(method);
        if (l != !!(method->flags & METHOD_L_STABLE))
            fail_msg("%s: L-stable is %d, the row says otherwise", method->row.name, l);
    }
}

static void assert_matrix(const char *name, enum drag drag, double x, double zeta,
                          const double want[4])
{
    double got[4];
    assert_true(method_amplification(method_named(name), drag, x, zeta, got));
    for (int i = 0; i < 4; i++)
        assert_near(name, got[i], want[i], 4e-15 * (1 + x * x));
}

TEST(test_one_step_matrices)
{
    for (double zeta = 0; zeta < 3; zeta += 0.37)
        for (double x = 0.01; x < 30; x *= 1.9) {
            double c = 2 * zeta * x, a = 1 + c + x * x, e = exp(-c), m = 1 + c / 2 + x * x / 4;
            assert_matrix("euler", DRAG_DEFAULT, x, zeta, (double[]){1, x, -x, 1 - c});
            assert_matrix("backward-euler", DRAG_DEFAULT, x, zeta,
                          (double[]){(1 + c) / a, x / a, -x / a, 1 / a});
            assert_matrix("symplectic-euler-kick", DRAG_EXPLICIT, x, zeta,
                          (double[]){1 - x * x, x * (1 - c), -x, 1 - c});
            double cayley[4] = {(1 + c / 2 - x * x / 4) / m, x / m, -x / m,
                                (1 - c / 2 - x * x / 4) / m};
            assert_matrix("implicit-midpoint", DRAG_DEFAULT, x, zeta, cayley);
            assert_matrix("trapezoid", DRAG_DEFAULT, x, zeta, cayley);
            double got[4];
            assert_true(method_amplification(method_named("verlet"), DRAG_EXACT, x, zeta, got));
            assert_near("verlet det", got[0] * got[3] - got[1] * got[2], e,
                        1e-14 * (1 + x * x) * (1 + x * x));
            assert_near("verlet trace", got[0] + got[3], (1 - x * x / 2) * (1 + e),
                        1e-14 * (1 + x * x));
        }
}

TEST(test_spectral_radius)
{
    assert_near("rotation", matrix_spectral_radius((double[]){0.6, 0.8, -0.8, 0.6}), 1, 1e-15);
    assert_near("real pair", matrix_spectral_radius((double[]){-3, 0, 7, 2}), 3, 1e-15);
    assert_near("hyperbolic", matrix_spectral_radius((double[]){0, 2, 2, 0}), 2, 1e-15);
}

RUN_TESTS(NULL, NULL)
