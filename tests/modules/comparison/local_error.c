/* SPDX-License-Identifier: GPL-3.0-or-later */
/* taylor: leading terms of local errors against closed forms. */
#include "cmocka_testing.h"

#include <math.h>
#include <string.h>

#include <hooke/base/cancel.h>

#include "modules/comparison/compute/local_error.h"
#include "unit/scene/typing.h"
#include "modules/solving/testing.h"

static struct local_error measure(const struct scene *scene, const char *name, double t)
{
    const struct local_error_request request = {scene, {method_named(name), DRAG_DEFAULT}, t, NULL};
    struct local_error result;
    struct error error = {0};
    if (!study_local_error(&request, &result, &error))
        fail_msg("%s: %s", name, error.text);
    return result;
}

static double factorial(int n)
{
    return n < 2 ? 1 : n * factorial(n - 1);
}

/* Linear scenes: one step is a rational function R(z) of the matrix, whose expansion differs from
 * that of exp(z) by a known term. An explicit method with as many stages as its order lacks the
 * term of the next power; Pade's approximation (j, k) has (-1)^(k+1) j! k!/((j+k)! (j+k+1)!). */
TEST(test_linear_scenes_have_the_terms_of_expansions)
{
    static const struct {
        const char *name;
        int j, k; /* degrees of numerator and denominator */
    } cases[] = {
        {"euler", 1, 0},
        {"heun", 2, 0},
        {"midpoint", 2, 0},
        {"kutta3", 3, 0},
        {"rk4", 4, 0},
        {"rk38", 4, 0},
        {"trapezoid", 1, 1},
        {"backward-euler", 0, 1},
        {"implicit-midpoint", 1, 1},
        {"gauss4", 2, 2},
        {"radau3", 1, 2},
        {"radau5", 2, 3},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        for (int damped = 0; damped < 2; damped++) {
            const struct scene scene = scene_with(damped ? "damped" : "spring", NO_SETTINGS);
            const struct local_error result = measure(&scene, cases[i].name, NAN);
            const int j = cases[i].j, k = cases[i].k, q = j + k + 1;
            const double multiple =
                (k % 2 ? 1 : -1) * factorial(j) * factorial(k) / (factorial(j + k) * factorial(q));
            for (int v = 0; v < 2; v++) {
                const struct leading_error *leading = &result.leading[v];
                assert_int_equal(leading->exponent, q);
                close_to(leading->coefficient / leading->derivative, multiple,
                         1e-3 * fabs(multiple));
                /* Iterations of implicit methods leave too few digits for the fractions of high
                 * orders. */
                assert_true(leading->denominator > 0 || (k > 0 && q > 3));
                if (leading->denominator > 0)
                    close_to((double)leading->numerator / leading->denominator, multiple, 1e-15);
            }
        }
}

/* Any scene: Euler's methods lack half the second derivative, symplectic Euler has it twice in one
 * of the two. */
TEST(test_euler_methods_on_scenes_that_are_not_linear)
{
    static const char *const scenes[] = {"pendulum", "kepler", "henon-heiles", "duffing",
                                         "vanderpol"};
    static const struct {
        const char *name;
        int position, velocity; /* numerators over 2 */
    } cases[] = {{"euler", -1, -1}, {"backward-euler", 1, 1}};
    for (size_t s = 0; s < COUNT_OF(scenes); s++)
        for (size_t i = 0; i < COUNT_OF(cases); i++) {
            const struct scene scene = scene_with(scenes[s], NO_SETTINGS);
            const struct local_error result = measure(&scene, cases[i].name, NAN);
            for (int v = 0; v < result.n; v++) {
                assert_int_equal(result.leading[v].exponent, 2);
                assert_int_equal(result.leading[v].denominator, 2);
                assert_int_equal(result.leading[v].numerator,
                                 v < result.n / 2 ? cases[i].position : cases[i].velocity);
            }
        }
    const struct scene pendulum = scene_with("pendulum", NO_SETTINGS);
    const struct local_error mixed = measure(&pendulum, "symplectic-euler", NAN),
                             verlet = measure(&pendulum, "verlet", NAN);
    assert_int_equal(mixed.leading[0].numerator * mixed.leading[1].numerator, -1);
    assert_int_equal(verlet.leading[0].denominator, 6);
    assert_int_equal(verlet.leading[1].denominator, 12);
}

/* The leading term of the local error is a fraction (1/denominator) of a derivative of the solution
 * only if the ratio of the two is the same at all states. It is not for rk4 on the pendulum, nor
 * for verlet with drag: the denominator is 0, which means that there is no such fraction. */
TEST(test_no_fraction_where_there_is_none)
{
    const struct scene pendulum = scene_with("pendulum", NO_SETTINGS),
                       damped = scene_with("damped", NO_SETTINGS);
    const struct local_error rk4 = measure(&pendulum, "rk4", NAN),
                             verlet = measure(&damped, "verlet", NAN);
    for (int v = 0; v < 2; v++) {
        assert_int_equal(rk4.leading[v].exponent, 5);
        assert_int_equal(rk4.leading[v].denominator, 0);
        assert_int_equal(verlet.leading[v].exponent, 3);
        assert_int_equal(verlet.leading[v].denominator, 0);
    }
}

/* The coefficient is the limit of the printed errors over dt^q, and the errors are those of a step
 * from the printed state. */
TEST(test_errors_are_those_of_the_step)
{
    const struct scene scene = scene_with("spring", NO_SETTINGS);
    const struct local_error result = measure(&scene, "euler", 1);
    const double omega2 = 75, omega = sqrt(omega2), y = 0.05 * cos(omega),
                 v = -0.05 * omega * sin(omega);
    close_to(result.state[0], y, 1e-14);
    close_to(result.state[1], v, 1e-13);
    for (int k = 0; k < result.points; k++) {
        const double dt = result.dt[k];
        close_to(result.error[k][0], y + dt * v - 0.05 * cos(omega * (1 + dt)), 1e-14);
        close_to(result.error[k][1], v - dt * omega2 * y + 0.05 * omega * sin(omega * (1 + dt)),
                 1e-13);
    }
    close_to(result.leading[0].derivative, -omega2 * y, 1e-8);
    close_to(result.leading[1].derivative, -omega2 * v, 1e-7);
}

/* At the start of the lab's run the velocity is 0, and so is its second derivative. */
TEST(test_a_derivative_that_vanishes_raises_the_power)
{
    const struct scene scene = scene_with("spring", NO_SETTINGS);
    const struct local_error result = measure(&scene, "euler", 0);
    assert_int_equal(result.leading[0].exponent, 2);
    assert_int_equal(result.leading[1].exponent, 3);
    const struct local_error exact = measure(&scene, "exact", NAN);
    assert_int_equal(exact.leading[0].exponent, 0);
}

/* Late times have few digits left for dt: no power is read off their rounding. A search that is
 * cancelled says so. */
TEST(test_late_times_and_cancellation)
{
    const struct scene spring = scene_with("spring", NO_SETTINGS),
                       pendulum = scene_with("pendulum", NO_SETTINGS);
    const struct local_error late = measure(&spring, "euler", 1e9);
    for (int v = 0; v < 2; v++)
        assert_true(late.leading[v].exponent == 2 || late.leading[v].exponent < 1);
    const struct cancel cancel = {1};
    const struct local_error_request request = {
        &pendulum, {method_named("euler"), DRAG_DEFAULT}, 1000, &cancel};
    struct local_error result;
    struct error error = {0};
    assert_false(study_local_error(&request, &result, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
}

TEST(test_methods_without_single_steps_are_refused)
{
    const struct scene scene = scene_with("spring", NO_SETTINGS);
    const struct local_error_request request = {
        &scene, {method_named("ab4"), DRAG_DEFAULT}, NAN, NULL};
    struct local_error result;
    struct error error = {0};
    assert_false(study_local_error(&request, &result, &error));
    assert_non_null(strstr(error.text, "earlier steps"));
}

RUN_TESTS(NULL, NULL)
