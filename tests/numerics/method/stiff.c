/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Implicit methods at work: orders on a stiff problem, van der Pol, the dissipation of structural
 * dynamics, the energy of the average vector field, costs, and equations without a solution.
 */
#include "cmocka_testing.h"

#include "numerics/method/testing.h"

/* ---- Prothero, Robinson 1974: y' = lambda (y - cos t) - sin t, y = cos t ---- */

static void prothero_add(const double *c, double t, const double *y, double *a)
{
    a[0] += c[0] * (y[0] - cos(t)) - sin(t);
}

static void prothero_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t, (void)y;
    jac[0] += c[0];
}

static const struct term_row prothero_row = {.row = {"prothero", "", "", "", NULL},
                                             .flags = TERM_LINEAR | TERM_TIME,
                                             .add = prothero_add,
                                             .jacobian = prothero_jacobian};

static struct system first_order(const struct term_row *row, double c0)
{
    struct system system = other_system(row, c0);
    system.n = system.order = 1;
    return system;
}

static double prothero_error(const struct method *method, const struct system *system, long n)
{
    double y[1] = {1};
    assert_int_equal(advance(method, system, 1. / (double)n, n, y), STEP_OK);
    return fabs(y[0] - cos(1));
}

/* Order reduction, as known: orders from h = 1/64 and 1/128, error at 1/128. */
TEST(test_stiff_orders)
{
    /* That of radau5 is 3.2e-17 at lambda = -1e8, below rounding; it goes with 1/lambda. */
    const struct {
        const char *name;
        double lambda, order, error;
    } known[] = {
        {"backward-euler", -1e8, 1, 2.1e-11},   {"trapezoid", -1e8, 2, 4.3e-14},
        {"implicit-midpoint", -1e8, 2, 3.5e-6}, {"gauss4", -1e8, 2, 7.8e-7},
        {"gauss6", -1e8, 4, 1.8e-12},           {"radau3", -1e8, 2, 5.7e-14},
        {"radau5", -1e5, 3, 3.2e-14},           {"sdirk2", -1e8, 1, 1.5e-11},
        {"tr-bdf2", -1e8, 2, 3.5e-14},
    };
    for (size_t i = 0; i < COUNT_OF(known); i++)
        for (int linear = 0; linear <= 1; linear++) {
            const struct method *method = method_named(known[i].name);
            struct system system = first_order(&prothero_row, known[i].lambda);
            system.linear = linear; /* else Newton's iteration has to find out */
            double coarse = prothero_error(method, &system, 64),
                   fine = prothero_error(method, &system, 128);
            if (getenv("VERBOSE"))
                print_message("%-18s order %.3f, error %.3g\n", known[i].name, log2(coarse / fine),
                              fine);
            assert_near(known[i].name, log2(coarse / fine), known[i].order, 0.1);
            assert_near(known[i].name, fine, known[i].error, 0.05 * known[i].error + 1e-15);
        }
}

/* ---- van der Pol, mu = 1000 ---- */

static void relaxation_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] += c[0] * (1 - y[0] * y[0]) * y[1] - y[0];
}

static void relaxation_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t;
    jac[0] -= 2 * c[0] * y[0] * y[1] + 1;
    jac[1] += c[0] * (1 - y[0] * y[0]);
}

static const struct term_row relaxation_row = {.row = {"van der Pol", "", "", "", NULL},
                                               .flags = TERM_VELOCITY,
                                               .add = relaxation_add,
                                               .jacobian = relaxation_jacobian};

/* Relative error of the position at t = 2000. */
static double relaxation_error(const char *name, double tol, struct cost *cost)
{
    static double work[WORK_CAPACITY];
    struct system system = other_system(&relaxation_row, 1000);
    double y[2] = {2, 0};
    struct step step = step_begin(&system, DRAG_DEFAULT, 0, 0, y, work);
    struct controller controller = {.tol = tol};
    while (step.t < 2000)
        assert_int_equal(method_adapt(method_named(name), &step, &controller, 2000), STEP_OK);
    assert_near(name, y[1], -8.9280970102481655e-4, 10 * tol);
    *cost = step.cost;
    return fabs(y[0] / 1.7061677321704650 - 1);
}

TEST(test_van_der_pol)
{
    struct cost cost;
    assert_below("radau5, seven digits", relaxation_error("radau5", 1e-8, &cost), 1e-7);
    assert_below("evaluations", (double)cost.evals, 20000);
    assert_below("Jacobians are kept", (double)cost.jacobians, 0.2 * (double)cost.solves);
    assert_below("radau5", relaxation_error("radau5", 1e-11, &cost), 1e-10);
    assert_below("tr-bdf2", relaxation_error("tr-bdf2", 1e-5, &cost), 1e-4);
}

/* ---- structural dynamics ---- */

/*
 * Frequency and damping of the oscillation that is left when a method's own modes have died out:
 * its sequence obeys q_n+1 = trace q_n - determinant q_n-1.
 */
static void measure(const struct method *method, double x, double *frequency, double *damping)
{
    static double work[WORK_CAPACITY];
    struct system system = SPRING({"m", 1}, {"k", 1}, {"y0", 1});
    double y[2] = {1, 0.3}, q[4];
    struct step step = step_begin(&system, DRAG_DEFAULT, 0, x, y, work);
    for (int i = 0; i < 200; i++) {
        if (i >= 100 && (i - 100) % 25 < 4)
            q[(i - 100) % 25] = y[0];
        assert_int_equal(method_step(method, &step), STEP_OK);
    }
    double below = q[1] * q[1] - q[0] * q[2];
    double trace = (q[1] * q[2] - q[0] * q[3]) / below,
           determinant = (q[2] * q[2] - q[1] * q[3]) / below;
    *frequency = acos(trace / 2 / sqrt(determinant)) / x - 1;
    *damping = log(determinant) / 2;
}

TEST(test_structural)
{
    const struct {
        const char *name;
        double frequency, damping, at_infinity; /* of x^2; of x^4; amplitude factor at x = 1e6 */
        double off; /* of that: a triple root is only known to a cube root of 1/x^2 */
    } known[] = {
        {"newmark", -1. / 12, 0, 1, 1e-9},
        {"avf", -1. / 12, 0, 1, 1e-9},
        {"generalised-alpha", -19. / 216, -1. / 1458, 0.8, 2e-4},
        {"wilson-theta", -109. / 600, -21. / 250, 0.778442, 1e-6},
    };
    const double x = 0.1;
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const struct method *method = method_named(known[i].name);
        /* the next terms, of x^2 relative, are extrapolated away */
        double frequency, damping, coarse, rough;
        measure(method, 2 * x, &coarse, &rough);
        measure(method, x, &frequency, &damping);
        frequency = (4 * frequency - coarse / 4) / 3 / (x * x);
        damping = (4 * damping - rough / 16) / 3 / (x * x * x * x);
        assert_near(known[i].name, frequency, known[i].frequency, 1e-4);
        assert_near(known[i].name, damping, known[i].damping, 2e-3 * fabs(known[i].damping) + 1e-8);
        assert_near(known[i].name, method_growth(method, DRAG_DEFAULT, 1e6, 0),
                    known[i].at_infinity, known[i].off);
    }
    assert_near("hht", method_growth(method_named("hht"), DRAG_DEFAULT, 1e6, 0), 0.9 / 1.1, 1e-6);
}

/* ---- average vector field ---- */

static void pendulum_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] -= c[0] * sin(y[0]);
}

static void pendulum_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t;
    jac[0] -= c[0] * cos(y[0]);
}

static double pendulum_potential(const double *c, const double *y)
{
    return c[0] * (1 - cos(y[0]));
}

static const struct term_row pendulum_row = {.row = {"pendulum", "", "", "", NULL},
                                             .flags = TERM_CONSERVATIVE,
                                             .add = pendulum_add,
                                             .jacobian = pendulum_jacobian,
                                             .potential = pendulum_potential};

/* Henon, Heiles 1964: V = (x^2 + y^2)/2 + c (x^2 y - y^3/3) */
static void galaxy_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] -= y[0] + c[0] * 2 * y[0] * y[1];
    a[1] -= y[1] + c[0] * (y[0] * y[0] - y[1] * y[1]);
}

static void galaxy_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t;
    jac[0] -= 1 + c[0] * 2 * y[1];
    jac[1] -= c[0] * 2 * y[0];
    jac[4] -= c[0] * 2 * y[0];
    jac[5] -= 1 - c[0] * 2 * y[1];
}

static double galaxy_potential(const double *c, const double *y)
{
    return (y[0] * y[0] + y[1] * y[1]) / 2 + c[0] * (y[0] * y[0] * y[1] - y[1] * y[1] * y[1] / 3);
}

static const struct term_row galaxy_row = {.row = {"galaxy", "", "", "", NULL},
                                           .flags = TERM_CONSERVATIVE,
                                           .add = galaxy_add,
                                           .jacobian = galaxy_jacobian,
                                           .potential = galaxy_potential};

/* Largest relative change of the energy in 2000 steps. */
static double energy_change(const char *name, const struct system *system, double h)
{
    double y[4] = {0.4, 0.1, 0.1, 0.1}, largest = 0;
    double begin = system_kinetic(system, y) + system_potential(system, y);
    for (int i = 0; i < 2000; i++) {
        assert_int_equal(advance(method_named(name), system, h, 1, y), STEP_OK);
        largest = fmax(largest,
                       fabs((system_kinetic(system, y) + system_potential(system, y)) / begin - 1));
    }
    return largest;
}

TEST(test_energy_of_the_average_field)
{
    struct system systems[] = {duffing(5), other_system(&pendulum_row, 4),
                               other_system(&galaxy_row, 1)};
    systems[2].n = 4;
    systems[2].scale[2] = systems[2].scale[3] = 1;
    for (size_t i = 0; i < COUNT_OF(systems); i++) {
        assert_below("avf", energy_change("avf", &systems[i], 0.3), 1e-12);
        assert_above("implicit-midpoint", energy_change("implicit-midpoint", &systems[i], 0.3),
                     1e-6);
    }
}

/* A force without potential is refused, drag is not. */
TEST(test_potential_is_wanted)
{
    const struct method *avf = method_named("avf");
    struct system driven = SPRING({"F0", 1}, {"omega", 2}), damped = SPRING({"gamma", 0.1});
    struct error error = {0};
    enum drag drag = DRAG_DEFAULT;
    assert_false(method_applies(avf, &driven, &drag, &error));
    assert_true(strstr(error.text, "potential") != NULL);
    assert_true(method_applies(avf, &damped, &drag, &error));
    assert_true(applies(method_named("implicit-midpoint"), &driven, DRAG_DEFAULT));
}

/* ---- costs and failures ---- */

static bool family(const struct method *method)
{
    return method->implicit || !strcmp(method->row.name, "avf") ||
           !strcmp(method->row.name, "newmark");
}

/* A linear system: one solve for each set of equations, and one Jacobian for all steps of one size.
 */
TEST(test_linear_systems_take_one_solve)
{
    static double work[WORK_CAPACITY];
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!method->implicit)
            continue;
        struct system system = first_order(&prothero_row, -3);
        double y[1] = {1};
        struct step step = step_begin(&system, DRAG_DEFAULT, 0, 0.1, y, work);
        for (int i = 0; i < 10; i++)
            assert_int_equal(method_step(method, &step), STEP_OK);
        bool twice = !strcmp(method->row.name, "sdirk2") || !strcmp(method->row.name, "tr-bdf2");
        assert_int_equal(step.cost.solves, twice ? 20 : 10);
        assert_int_equal(step.cost.jacobians, 1);
        assert_in_range(step.cost.evals, 10 * method->evals, 10 * method->evals + 1);
    }
}

static void explosion_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] += c[0] * y[0] * y[0];
}

static void explosion_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t;
    jac[0] += c[0] * 2 * y[0];
}

static const struct term_row explosion_row = {
    .row = {"explosion", "", "", "", NULL}, .add = explosion_add, .jacobian = explosion_jacobian};

/* z = y + h z^2 has no solution for 4 h y > 1: said so, and the state is as it was, bit for bit. */
TEST(test_no_solution)
{
    static double work[WORK_CAPACITY];
    int failures = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system system = first_order(&explosion_row, 1);
        if (!family(method) || !applies(method, &system, DRAG_DEFAULT))
            continue;
        double y[1] = {1. / 3};
        struct step step = step_begin(&system, DRAG_DEFAULT, 0, 12, y, work);
        enum step_status status = method_step(method, &step);
        if (status == STEP_OK)
            continue;
        failures++;
        assert_int_equal(status, STEP_NO_SOLUTION);
        assert_true(y[0] == 1. / 3 && step.t == 0 && !step.warm);
    }
    assert_true(failures >= 5);
}

RUN_TESTS(NULL, NULL)
