/* SPDX-License-Identifier: GPL-3.0-or-later */
/* selftest: every row passes, and rows that claim what they do not hold fail in the check
 * concerned. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>

#include "modules/comparison/compute/verify.h"
#include "modules/solving/testing.h"

TEST(test_every_row)
{
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        struct selftest_row row;
        if (method->flags & METHOD_EXTERNAL)
            continue;
        assert_true(selftest_method(method, NULL, &row));
        for (size_t c = 0; c < SELFTEST_CHECKS; c++)
            if (row.check[c].applies && !row.check[c].passed)
                fail_msg("%s: %s is %.10g, wanted %.10g", method->row.name,
                         catalog_row(&selftest_catalog, c)->name, row.check[c].value,
                         row.check[c].wanted);
        assert_true(row.passed);
        assert_true(row.check[SELFTEST_ORDER].applies || method->order == 0);
        assert_int_equal(row.check[SELFTEST_AREA].applies,
                         (method->flags & METHOD_SYMPLECTIC) != 0);
        assert_int_equal(row.check[SELFTEST_REVERSAL].applies,
                         (method->flags & METHOD_SYMMETRIC) != 0);
    }
}

static void fails(struct method method, enum selftest_check check)
{
    struct selftest_row row;
    assert_true(selftest_method(&method, NULL, &row));
    if (!row.check[check].applies || row.check[check].passed || row.passed)
        fail_msg("%s passes %s", method.row.name, catalog_row(&selftest_catalog, check)->name);
}

static double too_tame(const struct method *method, double x, double zeta, enum stiffness_sign sign)
{
    (void)method;
    return method_growth_signed(method_named("ab3"), DRAG_DEFAULT, x / 1.1, zeta, sign);
}

TEST(test_false_claims)
{
    struct method order = *method_named("rk4"), area = order, back = order, stable = order,
                  tame = *method_named("ab3");
    order.order = 5;
    fails(order, SELFTEST_ORDER);
    order.order = 3;
    fails(order, SELFTEST_ORDER);
    area.flags |= METHOD_SYMPLECTIC;
    fails(area, SELFTEST_AREA);
    back.flags |= METHOD_SYMMETRIC;
    fails(back, SELFTEST_REVERSAL);
    stable.flags |= METHOD_A_STABLE;
    fails(stable, SELFTEST_STABILITY);
    tame.growth = too_tame;
    fails(tame, SELFTEST_STABILITY);
}

TEST(test_cancelled)
{
    struct cancel cancel = {1};
    struct selftest_row row;
    assert_false(selftest_method(method_named("rk4"), &cancel, &row));
}

RUN_TESTS(NULL, NULL)
