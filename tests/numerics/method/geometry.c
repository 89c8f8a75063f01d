/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Reversibility, area, symplectic form and energy: each flag of each row is verified both ways, so
 * every method without the flag is a negative control (at a larger step, where its error is not
 * lost in rounding). The systems are the undamped spring, Duffing's q'' = -q - q^3 / 2 (which
 * `exact` cannot step) and that of Henon and Heiles.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "numerics/method/testing.h"

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
static double return_error(const struct method *method, const struct system *system, double h,
                           long n)
{
    const double start[2] = {1, 0.2};
    double y[2] = {start[0], start[1]};
    if (advance(method, system, h, n, y) != STEP_OK || advance(method, system, -h, n, y) != STEP_OK)
        return HUGE_VAL;
    return distance(system, y, start);
}

/* At steps where no method of the table is exact to rounding. */
static double coarse_return_error(const struct method *method, const struct system *system)
{
    double largest = 0;
    for (double h = 0.5; h <= 2 && largest < 1e-8; h *= 2)
        largest = return_error(method, system, h, 1000);
    return largest;
}

TEST(test_reversal)
{
    const long n = is_long() ? 100000 : 10000;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system linear = unit_spring(), nonlinear = nonlinear_for(method);
        if (has(method, METHOD_SYMMETRIC)) {
            assert_below(method->row.name, return_error(method, &linear, 0.1, n), 1e-10);
            assert_below(method->row.name, return_error(method, &nonlinear, 0.1, n / 10), 1e-10);
        } else {
            assert_above(method->row.name, coarse_return_error(method, &linear), 1e-8);
            assert_above(method->row.name, coarse_return_error(method, &nonlinear), 1e-8);
        }
    }
}

/* Duffing with linear damping: its drag is whole though the oscillator is not. */
static struct system damped_duffing(double gamma)
{
    struct system system = duffing(0.5);
    const struct term_row *row = (const void *)catalog_find(&term_catalog, text_of("damping"));
    assert_non_null(row);
    system.term[system.terms++] = (struct bound_term){row, {gamma, 1}};
    system.oscillator = (struct oscillator){.damping = gamma, .drag_whole = true};
    system.velocity = true;
    system.conservative = false;
    return system;
}

static void check_reversal_with_drag(const struct method *method, enum drag drag,
                                     const struct system *system)
{
    if (!applies(method, system, drag))
        return;
    double y[2] = {1, 0.2};
    assert_int_equal(advance_as(method, drag, system, 0, 0.1, 200, y), STEP_OK);
    assert_int_equal(advance_as(method, drag, system, 0, -0.1, 200, y), STEP_OK);
    double back = distance(system, y, (double[]){1, 0.2});
    if (has(method, METHOD_SYMMETRIC) && drag != DRAG_EXPLICIT)
        assert_below(method->row.name, back, 1e-12);
    else
        assert_above(method->row.name, back, 1e-6);
}

/* Drag does not spoil the symmetry of the exact and implicit variants; explicit drag does. */
TEST(test_reversal_with_drag)
{
    const struct system systems[] = {SPRING({"m", 1}, {"k", 1}, {"gamma", 0.01}, {"C", 0.01},
                                            {"rho", 1}, {"area", 1}, {"y0", 1}),
                                     SPRING({"m", 1}, {"k", 1}, {"gamma", 0.02}, {"y0", 1}),
                                     damped_duffing(0.02)};
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int drag = DRAG_EXACT; drag < DRAG_COUNT; drag++)
            for (size_t i = 0; i < COUNT_OF(systems); i++)
                check_reversal_with_drag(method_at(m), (enum drag)drag, &systems[i]);
}

/* xorshift64*, uniform in [-1, 1] */
static double next_random(uint64_t *seed)
{
    *seed ^= *seed >> 12;
    *seed ^= *seed << 25;
    *seed ^= *seed >> 27;
    return (double)((*seed * 0x2545f4914f6cdd1dull) >> 11) / 4503599627370496.0 - 1;
}

/* Several steps of a method that starts with those of another. */
static int steps_of(const struct method *method)
{
    return has(method, METHOD_MULTISTEP) ? 8 : 1;
}

/* Jacobian of the map over one step (steps_of) at y by central differences of sixth order; false: a
 * step failed. */
static bool map_jacobian(const struct method *method, const struct system *system, double h,
                         const double *y, double jacobian[4][4])
{
    static const double weight[] = {45. / 60, -9. / 60, 1. / 60};
    const double delta = 0.01;
    int n = system->n;
    memset(jacobian, 0, 16 * sizeof **jacobian);
    for (int column = 0; column < n; column++)
        for (int k = 1; k <= 3; k++)
            for (int sign = -1; sign <= 1; sign += 2) {
                double z[4];
                memcpy(z, y, (size_t)n * sizeof *z);
                z[column] += sign * k * delta;
                if (advance(method, system, h, steps_of(method), z) != STEP_OK)
                    return false;
                for (int row = 0; row < n; row++)
                    jacobian[row][column] += sign * weight[k - 1] * z[row] / delta;
            }
    return true;
}

/*
 * Largest difference of J' Omega J from factor Omega at random places in a box; Omega pairs q_i
 * with v_i. For n = 2 that is the determinant, the change of area.
 */
static double form_error(const struct method *method, const struct system *system, double h,
                         double box, int indices, double factor)
{
    uint64_t seed = 88172645463325252u;
    int n = system->n, d = n / 2;
    double largest = 0;
    for (int i = 0; i < indices; i++) {
        double y[4], jacobian[4][4];
        for (int j = 0; j < n; j++)
            y[j] = box * next_random(&seed);
        if (!map_jacobian(method, system, h, y, jacobian))
            return HUGE_VAL;
        for (int row = 0; row < n; row++)
            for (int column = row + 1; column < n; column++) {
                double form = 0;
                for (int j = 0; j < d; j++)
                    form += jacobian[j][row] * jacobian[d + j][column] -
                            jacobian[d + j][row] * jacobian[j][column];
                largest = fmax(largest, fabs(form - (column == row + d ? factor : 0)));
            }
    }
    return largest;
}

TEST(test_area)
{
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system system = nonlinear_for(method);
        if (has(method, METHOD_SYMPLECTIC))
            assert_below(method->row.name, form_error(method, &system, 0.3, 1.5, 1000, 1), 1e-11);
        else
            assert_above(method->row.name, form_error(method, &system, 1, 1.5, 10, 1), 1e-8);
    }
}

/* Henon, Heiles 1964: q1'' = -q1 - 2 q1 q2, q2'' = -q2 - q1^2 + q2^2 */
static void henon_heiles_add(const double *c, double t, const double *y, double *a)
{
    (void)c, (void)t;
    a[0] -= y[0] + 2 * y[0] * y[1];
    a[1] -= y[1] + y[0] * y[0] - y[1] * y[1];
}

static void henon_heiles_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)c, (void)t;
    jac[0] -= 1 + 2 * y[1];
    jac[1] -= 2 * y[0];
    jac[4] -= 2 * y[0];
    jac[5] -= 1 - 2 * y[1];
}

static double henon_heiles_potential(const double *c, const double *y)
{
    (void)c;
    return (y[0] * y[0] + y[1] * y[1]) / 2 + y[0] * y[0] * y[1] - y[1] * y[1] * y[1] / 3;
}

static const struct term_row henon_heiles_row = {.row = {"henon-heiles", "", "", "", NULL},
                                                 .flags = TERM_CONSERVATIVE,
                                                 .add = henon_heiles_add,
                                                 .jacobian = henon_heiles_jacobian,
                                                 .potential = henon_heiles_potential};

/* With two coordinates keeping the volume is not enough. */
TEST(test_symplectic_form)
{
    struct system system = other_system(&henon_heiles_row, 0);
    system.n = 4;
    system.scale[2] = system.scale[3] = 1;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!applies(method, &system, DRAG_DEFAULT))
            continue;
        if (has(method, METHOD_SYMPLECTIC))
            assert_below(method->row.name, form_error(method, &system, 0.3, 0.3, 100, 1), 1e-11);
        else
            assert_above(method->row.name, form_error(method, &system, 1, 0.3, 10, 1), 1e-8);
    }
}

/* Linear damping shrinks areas by exp(-gamma h): splittings with exact drag do exactly that, others
 * do not. */
TEST(test_area_with_damping)
{
    struct system damped = damped_duffing(0.4), driven_away = damped_duffing(-0.4);
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        if (!applies(method, &damped, DRAG_DEFAULT))
            continue;
        bool exact = method->drag == DRAG_EXACT;
        double h = exact ? 0.3 : 1, factor = exp(-0.4 * h * steps_of(method));
        double shrinks = form_error(method, &damped, h, 1.5, 100, factor);
        double grows = form_error(method, &driven_away, h, 1.5, 100, 1 / factor);
        if (exact)
            assert_below(method->row.name, fmax(shrinks, grows), 1e-11);
        else
            assert_above(method->row.name, fmin(shrinks, grows), 1e-8);
    }
}

struct walk {
    struct step step;
    double y[2], work[WORK_CAPACITY];
};

static void walk_begin(struct walk *walk, const struct method *method, const struct system *system,
                       double h)
{
    struct error error;
    enum drag drag = DRAG_DEFAULT;
    assert_true(method_applies(method, system, &drag, &error));
    walk->y[0] = 1;
    walk->y[1] = 0.2;
    walk->step = step_begin(system, drag, 0, h, walk->y, walk->work);
}

/* Largest |E / E(1, 0.2) - 1| within n steps; HUGE_VAL if a step fails. */
static double energy_error(const struct method *method, struct walk *walk, long n)
{
    const struct system *system = walk->step.system;
    const double start[2] = {1, 0.2};
    double largest = 0, energy = system_kinetic(system, start) + system_potential(system, start);
    for (long i = 0; i < n; i++) {
        if (method_step(method, &walk->step) != STEP_OK)
            return HUGE_VAL;
        double now = system_kinetic(system, walk->y) + system_potential(system, walk->y);
        largest = fmax(largest, fabs(now / energy - 1));
    }
    return largest;
}

/* A step at which the energy error within some periods is far from rounding. */
static double telling_step(const struct method *method, const struct system *system)
{
    static struct walk walk;
    for (double h = 0.1; h < 1; h *= 1.25) {
        walk_begin(&walk, method, system, h);
        if (energy_error(method, &walk, 100) > 1e-8)
            return h;
    }
    return 1;
}

/* The last 1000 steps are not worse than the first 1000; methods neither symplectic nor symmetric
 * drift. */
TEST(test_energy_stays_bounded)
{
    static struct walk walk;
    const long n = is_long() ? 1000000 : 30000;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        struct system system = duffing(0.5);
        if (!applies(method, &system, DRAG_DEFAULT))
            continue;
        walk_begin(&walk, method, &system, telling_step(method, &system));
        double first = energy_error(method, &walk, 1000);
        double middle = energy_error(method, &walk, n - 2000) < HUGE_VAL ? 0 : HUGE_VAL;
        double last = fmax(middle, energy_error(method, &walk, 1000));
        if (has(method, METHOD_SYMPLECTIC))
            assert_below(method->row.name, last / first, 1.02);
        else if (!has(method, METHOD_SYMMETRIC))
            assert_above(method->row.name, last, fmin(10 * first, 0.5));
    }
}

TEST(test_linear_energy_is_kept)
{
    static struct walk walk;
    struct system system = unit_spring();
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        bool keeps = has(method, METHOD_ENERGY);
        walk_begin(&walk, method, &system, keeps ? 0.5 : 1);
        double largest = energy_error(method, &walk, 1000);
        if (keeps)
            assert_below(method->row.name, largest, 1e-12);
        else
            assert_above(method->row.name, largest, 1e-9);
    }
}

/* The invariants of the discrete flows: v^2 + q^2 (1 - x^2/4) for Verlet, v^2 + q^2 -+ x q v for
 * the symplectic Eulers.
 */
TEST(test_modified_invariants)
{
    const struct {
        const char *name;
        double q2, qv;
    } rows[] = {{"verlet", 1 - 0.16 / 4, 0},
                {"symplectic-euler", 1, 0.4},
                {"symplectic-euler-kick", 1, -0.4}};
    struct system system = unit_spring();
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        double y[2] = {1, 0.2}, first = 0.04 + rows[i].q2 + rows[i].qv * 0.2;
        for (int n = 0; n < 1000; n++) {
            assert_int_equal(advance(method_named(rows[i].name), &system, 0.4, 1, y), STEP_OK);
            assert_near(rows[i].name,
                        y[1] * y[1] + rows[i].q2 * y[0] * y[0] + rows[i].qv * y[0] * y[1], first,
                        1e-13);
        }
    }
}

RUN_TESTS(NULL, NULL)
