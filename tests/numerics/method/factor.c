/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The powers of the step-size control: as exact as they say, and in order. */
#include "cmocka_testing.h"

#include <math.h>

#include "method/control/factor.h"

static void assert_near(double is, double wanted, double within, double x)
{
    if (!(fabs(is - wanted) <= within))
        fail_msg("%.17g for %.17g, at %.17g", is, wanted, x);
}

TEST(test_log2)
{
    double last = -HUGE_VAL;
    for (double x = 1e-300; x < 1e300; x *= 1.0137) {
        const double log = factor_log2(x);
        assert_near(log, log2(x), 2e-9, x);
        assert_true(log > last);
        last = log;
    }
    assert_true(factor_log2(1) == 0);
}

TEST(test_exp2)
{
    double last = 0;
    for (double x = -999; x < 999; x += 0.0373) {
        const double power = factor_exp2(x);
        assert_near(power / exp2(x), 1, 1e-9, x);
        assert_true(power > last);
        last = power;
    }
    assert_true(factor_exp2(0) == 1);
    assert_true(factor_exp2(1e9) > 1e300 && factor_exp2(-1e9) < 1e-300); /* no nonsense beyond */
}

TEST(test_atan)
{
    for (double x = -30; x < 30; x += 0.00173)
        assert_near(factor_atan(x), atan(x), 1.2e-5, x);
    assert_true(factor_atan(0) == 0); /* a step that is just right stays as it is */
    assert_near(factor_atan(1e300), asin(1), 1e-9, 1e300);
}

TEST(test_limited)
{
    double last = 0;
    for (double x = -40; x < 40; x += 0.000713) {
        const double factor = factor_limited(x);
        assert_near(factor, 1 + atan(exp2(x) - 1), fabs(x) <= 0.5 ? 2e-7 : 1.2e-5, x);
        assert_true(factor > last - (fabs(x) <= 0.51 ? 0 : 1e-9));
        last = factor;
    }
    assert_true(factor_limited(0) == 1); /* a step that is just right stays as it is */
    assert_true(factor_limited(1e9) < 2.571 && factor_limited(-1e9) > 0.214);
}

RUN_TESTS(NULL, NULL)
