/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Drag beside forces that no oscillator has: two coordinates of Henon and Heiles, or one of Duffing
 * (order of every splitting and drag variant), against RK4 in long double on forces written out
 * here.
 */
#include "cmocka_testing.h"

#include "numerics/method/testing.h"

typedef long double real;

enum { ONE = 1, TWO = 2 };

static const double GAMMA = 0.25, QUADRATIC = 0.75;

/* Henon, Heiles 1964 */
static void pair_add(const double *c, double t, const double *y, double *a)
{
    (void)c, (void)t;
    a[0] -= y[0] + 2 * y[0] * y[1];
    a[1] -= y[1] + y[0] * y[0] - y[1] * y[1];
}

static void drag_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] -= c[0] * y[1] + c[1] * fabs(y[1]) * y[1];
}

static void pair_drag_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] -= c[0] * y[2];
    a[1] -= c[0] * y[3];
}

static const struct term_row pair_row = {
    .row = {"pair", "", "", "", NULL}, .flags = TERM_CONSERVATIVE, .add = pair_add};
static const struct term_row drag_row = {
    .row = {"drag", "", "", "", NULL}, .flags = TERM_VELOCITY, .add = drag_add};
static const struct term_row pair_drag_row = {
    .row = {"drag", "", "", "", NULL}, .flags = TERM_VELOCITY, .add = pair_drag_add};

static struct system damped(int coordinates, double quadratic)
{
    struct system system = other_system(coordinates == ONE ? &duffing_row : &pair_row, 0.5);
    system.n = 2 * coordinates;
    system.scale[2] = system.scale[3] = 1;
    system.term[1] =
        (struct bound_term){coordinates == ONE ? &drag_row : &pair_drag_row, {GAMMA, quadratic}};
    system.terms = 2;
    system.velocity = true;
    system.conservative = false;
    system.oscillator =
        (struct oscillator){.damping = GAMMA, .quadratic = quadratic, .drag_whole = true};
    return system;
}

static void slope_at(int coordinates, real quadratic, const real *y, real *dy)
{
    const real *v = y + coordinates;
    for (int i = 0; i < coordinates; i++) {
        dy[i] = v[i];
        dy[coordinates + i] = -(real)GAMMA * v[i] - quadratic * fabsl(v[i]) * v[i];
    }
    if (coordinates == ONE) {
        dy[1] -= y[0] + y[0] * y[0] * y[0] / 2;
    } else {
        dy[2] -= y[0] + 2 * y[0] * y[1];
        dy[3] -= y[1] + y[0] * y[0] - y[1] * y[1];
    }
}

static void reference(int coordinates, real quadratic, double span, double *y)
{
    const int steps = 1 << 14, n = 2 * coordinates;
    const real part[] = {0.5L, 0.5L, 1}, fraction[] = {1, 2, 2, 1}, h = (real)span / steps;
    real z[4];
    for (int i = 0; i < n; i++)
        z[i] = (real)y[i];
    for (int s = 0; s < steps; s++) {
        real k[4][4], at[4], sum[4] = {0};
        memcpy(at, z, sizeof at);
        for (int stage = 0; stage < 4; stage++) {
            slope_at(coordinates, quadratic, at, k[stage]);
            for (int i = 0; i < n; i++) {
                sum[i] += fraction[stage] * k[stage][i];
                if (stage < 3)
                    at[i] = z[i] + h * part[stage] * k[stage][i];
            }
        }
        for (int i = 0; i < n; i++)
            z[i] += h / 6 * sum[i];
    }
    for (int i = 0; i < n; i++)
        y[i] = (double)z[i];
}

/*
 * Of errors far above rounding: from the last three, extrapolated; of high orders, for which double
 * leaves few, the mean slope. (What their order is method_words.c proves, here it is not lost.)
 */
static double order_of(const struct method *method, enum drag drag, int coordinates,
                       double quadratic)
{
    const double start[4] = {0.4, -0.3, 0.2, 0.1};
    /* quadratic drag: without a turning point inside */
    const double span = quadratic != 0 ? 1.5 : 6;
    struct system system = damped(coordinates, quadratic);
    double want[4], error[14] = {0};
    memcpy(want, start, sizeof want);
    reference(coordinates, (real)quadratic, span, want);
    int count = 0; /* of errors far above rounding */
    for (long n = 8; count < (int)COUNT_OF(error); n *= 2) {
        double y[4];
        memcpy(y, start, sizeof y);
        assert_int_equal(advance_as(method, drag, &system, 0, span / (double)n, n, y), STEP_OK);
        error[count] = distance(&system, y, want);
        if (error[count] < fmax(4e-13, 1e-14 * (double)n))
            break;
        count++;
    }
    assert_in_range(count, method->order > 4 ? 2 : 3, COUNT_OF(error));
    if (method->order > 4)
        return log2(error[0] / error[count - 1]) / (count - 1);
    return 2 * log2(error[count - 2] / error[count - 1]) -
           log2(error[count - 3] / error[count - 2]);
}

static void check(int coordinates, double quadratic, int *checked)
{
    struct system system = damped(coordinates, quadratic);
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int drag = DRAG_EXACT; drag < DRAG_COUNT; drag++) {
            const struct method *method = method_at(m);
            if (!method->splitting || !applies(method, &system, (enum drag)drag))
                continue;
            char what[80];
            snprintf(what, sizeof what, "%s drag %d, %d coordinates", method->row.name, drag,
                     coordinates);
            double order = order_of(method, (enum drag)drag, coordinates, quadratic);
            if (method->order <= 4)
                assert_near(what, order, drag == DRAG_EXPLICIT ? 1 : method->order, 0.05);
            else
                assert_above(what, order, method->order - 0.5);
            *checked += 1;
        }
}

TEST(test_linear_drag)
{
    int checked[2] = {0};
    check(ONE, 0, &checked[0]);
    check(TWO, 0, &checked[1]);
    assert_true(checked[0] >= 12 + 13 && checked[1] == checked[0]);
}

TEST(test_quadratic_drag)
{
    int checked = 0;
    check(ONE, QUADRATIC, &checked);
    assert_true(checked == 2 * 3 + 2 * 2); /* the symplectic Eulers have no exact variant for it */
}

/* Drag that is not known to act on each velocity alike is refused but for the explicit variant. */
TEST(test_unknown_drag)
{
    struct system system = damped(TWO, 0);
    system.oscillator.drag_whole = false;
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int drag = DRAG_EXACT; method_at(m)->splitting && drag < DRAG_COUNT; drag++)
            assert_int_equal(applies(method_at(m), &system, (enum drag)drag),
                             drag == DRAG_EXPLICIT && method_at(m)->order <= 2);
}

RUN_TESTS(NULL, NULL)
