/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Rounding in long runs. On the spring a splitting is a product of shears and keeps a quadratic
 * form exactly; how far the form drifts is what rounding did. It must do so like a random walk
 * (Brouwer 1937, Astron. J. 46:149), and with compensated sums with steps smaller by h (Hairer,
 * McLachlan, Razakarivony 2008, BIT 48:231).
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "method/step/step.h"
#include "numerics/method/testing.h"

typedef long double real;

static const double H = 0.01;

enum { CONDITIONS = 32, POINTS = 14, FIRST = 1000 };

/* qq q^2 + qv q v + vv v^2, which the step's matrix leaves as it is. */
struct form {
    real qq, qv, vv;
};

static struct form form_of(const struct splitting *splitting)
{
    real m[2][2] = {{1, 0}, {0, 1}}; /* rows: q, v */
    for (int i = 0; i < splitting->count; i++) {
        double w = splitting_weight(splitting, i) * H; /* rounded as the step rounds it */
        bool kick = (i % 2 == 0) == splitting->kick_first;
        for (int column = 0; column < 2; column++)
            m[kick][column] += (kick ? -(real)w : (real)w) * m[!kick][column];
    }
    return (struct form){-m[1][0], m[0][0] - m[1][1], m[0][1]};
}

static real form_value(const struct form *form, const double *y, const double *low)
{
    real q = (real)y[0] + (low ? (real)low[0] : 0), v = (real)y[1] + (low ? (real)low[1] : 0);
    return form->qq * q * q + form->qv * q * v + form->vv * v * v;
}

/* The spring with unit coefficients. */
static struct system unit_spring(void)
{
    struct system system = SPRING({"m", 1}, {"k", 1});
    return system;
}

/* RMS of the form's relative drift after FIRST, 2 FIRST, 4 FIRST … steps. */
static void drift(const struct method *method, bool compensated, int conditions, int points,
                  double *rms)
{
    struct system system = unit_spring();
    struct form form = form_of(method->splitting);
    memset(rms, 0, (size_t)points * sizeof *rms);
    for (int c = 0; c < conditions; c++) {
        double work[64], y[2] = {cos(0.1 + c), sin(0.1 + c)}, low[2] = {0, 0};
        assert_true(method_work_size(method, 2) <= COUNT_OF(work));
        struct step step = step_begin(&system, DRAG_DEFAULT, 0, H, y, work);
        step.low = compensated ? low : NULL;
        real start = form_value(&form, y, step.low);
        for (long n = 0, p = 0; p < points; p++) {
            for (; n < (long)FIRST << p; n++)
                assert_int_equal(method_step(method, &step), STEP_OK);
            double off = (double)(form_value(&form, y, step.low) / start - 1);
            rms[p] += off * off / conditions;
        }
    }
    for (int p = 0; p < points; p++)
        rms[p] = sqrt(rms[p]);
}

TEST(test_every_splitting)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        double plain[6], compensated[6];
        if (!method->splitting)
            continue;
        drift(method, false, 6, 6, plain);
        drift(method, true, 6, 6, compensated);
        assert_below(method->row.name, compensated[5], 4e-16);
        assert_above(method->row.name, plain[5] / compensated[5], 10);
    }
}

static double slope_of(const double *rms, int points)
{
    double x = 0, y = 0, xx = 0, xy = 0;
    for (int p = 0; p < points; p++) {
        x += p, y += log2(rms[p]);
        xx += p * p, xy += p * log2(rms[p]);
    }
    return (points * xy - x * y) / (points * xx - x * x);
}

/* Verlet, 256 000 steps of 8 runs; in the long form 8 192 000 of 32. */
TEST(test_random_walk)
{
    const struct method *verlet = method_named("verlet");
    int conditions = is_long() ? CONDITIONS : 8, points = is_long() ? POINTS : 9;
    double plain[POINTS], compensated[POINTS];
    drift(verlet, false, conditions, points, plain);
    drift(verlet, true, conditions, points, compensated);
    double slope = slope_of(compensated, points);
    print_message("drift %.2g plain, %.2g compensated; slopes %.3f, %.3f\n", plain[points - 1],
                  compensated[points - 1], slope_of(plain, points), slope);
    assert_below("compensated", compensated[points - 1], 1.5e-15 * (is_long() ? 2 : 1));
    assert_above("plain", plain[points - 1], 50 * compensated[points - 1]);
    assert_near("slope", slope, 0.5, is_long() ? 0.15 : 0.3);
}

/* A step that fails leaves the low parts too; a low part that is there counts. */
TEST(test_low_parts)
{
    struct system system = unit_spring();
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!method->splitting)
            continue;
        double work[64], y[2] = {1, HUGE_VAL}, low[2] = {1e-17, -2e-17};
        struct step step = step_begin(&system, DRAG_DEFAULT, 0, H, y, work);
        step.low = low;
        assert_int_equal(method_step(method, &step), STEP_NONFINITE);
        assert_true(low[0] == 1e-17 && low[1] == -2e-17);

        double a[2] = {1, 0.25}, b[2] = {1, 0.25}, low_a[2] = {0, 0}, low_b[2] = {0x1p-45, 0x1p-46};
        struct step first = step_begin(&system, DRAG_DEFAULT, 0, H, a, work);
        first.low = low_a;
        assert_int_equal(method_step(method, &first), STEP_OK);
        struct step second = step_begin(&system, DRAG_DEFAULT, 0, H, b, work);
        second.low = low_b;
        assert_int_equal(method_step(method, &second), STEP_OK);
        for (int i = 0; i < 2; i++) { /* the difference at the start comes out at the end */
            double off = (b[i] - a[i]) + (low_b[i] - low_a[i]);
            assert_near(method->row.name, off, i == 0 ? 0x1p-45 : 0x1p-46, 0x1p-50);
        }
    }
}

/* One number: the sum is exact to twice the digits, whichever of the two is larger. */
TEST(test_step_add)
{
    double y = 1, low = 0, plain = 1;
    for (int i = 0; i < 1000000; i++) {
        step_add(&y, &low, 0x1p-60);
        step_add(&plain, NULL, 0x1p-60);
    }
    assert_true(plain == 1);
    assert_true((y - 1) + low == 1000000 * 0x1p-60);
    y = 0x1p-60, low = 0;
    step_add(&y, &low, 1);
    assert_true(y == 1 && low == 0x1p-60);
}

RUN_TESTS(NULL, NULL)
