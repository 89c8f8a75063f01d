/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The rows of the method table, and what is refused with a reason. */
#include "cmocka_testing.h"

#include "method/step/step.h"
#include "numerics/method/testing.h"

TEST(test_names_and_aliases)
{
    static const char *const same[][2] = {
        {"euler-cromer", "symplectic-euler"}, {"leapfrog", "verlet"}, {"velocity-verlet", "verlet"},
        {"crank-nicolson", "trapezoid"},      {"ode45", "dopri5"},    {"rk45", "dopri5"},
    };
    static const char *const names[] = {"euler",
                                        "backward-euler",
                                        "symplectic-euler",
                                        "symplectic-euler-kick",
                                        "midpoint",
                                        "heun",
                                        "rk4",
                                        "verlet",
                                        "position-verlet",
                                        "implicit-midpoint",
                                        "trapezoid",
                                        "dopri5",
                                        "exact"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        assert_string_equal(method_named(names[i])->row.name, names[i]);
    for (size_t i = 0; i < COUNT_OF(same); i++)
        assert_ptr_equal(method_named(same[i][0]), method_named(same[i][1]));
    for (size_t i = 0; i < method_catalog.count; i++) /* no name or alias twice */
        assert_ptr_equal(method_named(method_at(i)->row.name), method_at(i));
}

TEST(test_rows_are_complete)
{
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *m = method_at(i);
        assert_true(m->row.name && m->row.unit && m->row.brief && m->row.brief[0] &&
                    m->row.citation);
        assert_true(m->row.citation[0] || m->flags & METHOD_EXACT);
        assert_true(m->formula && m->formula[0]);
        int lines = 1;
        for (const char *c = m->formula; *c; c++)
            lines += *c == '\n';
        assert_in_range(lines, 1, 4);
        assert_true(m->step && m->work);
        assert_int_equal(m->order == 0, !!(m->flags & METHOD_EXACT));
        assert_int_equal(m->evals == 0, !!(m->flags & METHOD_EXACT));
        assert_int_equal(m->drag != DRAG_DEFAULT, m->drags != 0);
        assert_true(m->drag == DRAG_DEFAULT || m->drags & 1u << m->drag);
        assert_false(m->flags & METHOD_L_STABLE && !(m->flags & METHOD_A_STABLE));
        assert_in_range(method_work_size(m, LIMIT_VARIABLES), LIMIT_VARIABLES, 1 << 20);
        const bool yardstick = m->flags & METHOD_EXTERNAL;
        assert_true(yardstick == (m->adapt != NULL) && yardstick == (m->begin && m->end) &&
                    yardstick == (i >= own_methods()));
    }
}

/* What this build was made without is known by name, and nowhere else. */
TEST(test_absent_names)
{
    for (int i = 0; i < 2; i++) {
        const struct text name = i ? TEXT("cvode-bdf") : TEXT("cvode-adams");
        struct error error = {0};
        const bool absent = catalog_absent(&method_catalog, name, &error);
        assert_true(absent == (catalog_find(&method_catalog, name) == NULL));
        assert_true(absent == (strstr(error.text, "libsundials-dev") != NULL));
        assert_false(catalog_unknown(&method_catalog, name, &error));
        assert_true(absent == (strstr(error.text, "libsundials-dev") != NULL));
    }
    struct error error = {0};
    assert_false(catalog_absent(&method_catalog, TEXT("rk4"), &error) || error.text[0]);
}

TEST(test_drag_names)
{
    static const char *const names[] = {
        [DRAG_EXACT] = "exact", [DRAG_IMPLICIT] = "implicit", [DRAG_EXPLICIT] = "explicit"};
    assert_int_equal(drag_catalog.count, DRAG_COUNT - 1);
    for (int drag = DRAG_EXACT; drag < DRAG_COUNT; drag++)
        assert_string_equal(catalog_row(&drag_catalog, (size_t)drag - 1)->name, names[drag]);
}

static enum drag resolved(const char *name, const struct system *system, enum drag drag)
{
    struct error error = {0};
    if (!method_applies(method_named(name), system, &drag, &error))
        fail_msg("%s", error.text);
    return drag;
}

TEST(test_default_drag)
{
    struct system system = SPRING({"gamma", 0.25});
    assert_int_equal(resolved("symplectic-euler", &system, DRAG_DEFAULT), DRAG_EXPLICIT);
    assert_int_equal(resolved("symplectic-euler-kick", &system, DRAG_DEFAULT), DRAG_EXPLICIT);
    assert_int_equal(resolved("verlet", &system, DRAG_DEFAULT), DRAG_EXACT);
    assert_int_equal(resolved("position-verlet", &system, DRAG_DEFAULT), DRAG_EXACT);
    assert_int_equal(resolved("verlet", &system, DRAG_IMPLICIT), DRAG_IMPLICIT);
    assert_int_equal(resolved("rk4", &system, DRAG_DEFAULT), DRAG_DEFAULT);
}

static void assert_refused(const struct method *method, const struct system *system, enum drag drag,
                           const char *reason)
{
    struct error error = {0};
    enum drag asked = drag;
    if (method_applies(method, system, &drag, &error))
        fail_msg("%s was not refused (%s)", method->row.name, reason);
    assert_int_equal(error.code, ERROR_COMMAND);
    assert_int_equal(drag, asked);
    if (!strstr(error.text, reason) || !strstr(error.text, method->row.name))
        fail_msg("'%s' does not say '%s' of %s", error.text, reason, method->row.name);
}

/* A force that depends on velocity in its own way: v (1 - q^2). */
static void vanderpol_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] += c[0] * (1 - y[0] * y[0]) * y[1] - y[0];
}
static const struct term_row vanderpol_row = {
    .row = {"vanderpol", "m/s^2", "", "", NULL}, .flags = TERM_VELOCITY, .add = vanderpol_add};

TEST(test_refusals)
{
    struct system linear = SPRING({"gamma", 0.25}), quadratic = SPRING({"C", 1});
    struct system foreign = other_system(&vanderpol_row, 1), first = foreign;
    first.order = 1;
    assert_refused(method_named("rk4"), &linear, DRAG_EXACT, "no drag variants");
    assert_refused(method_named("exact"), &quadratic, DRAG_DEFAULT, "no exact solution");
    assert_refused(method_named("symplectic-euler"), &quadratic, DRAG_EXACT, "linear drag");
    assert_refused(method_named("verlet"), &foreign, DRAG_DEFAULT, "velocity-dependent");
    assert_refused(method_named("verlet"), &foreign, DRAG_IMPLICIT, "velocity-dependent");
    assert_true(applies(method_named("verlet"), &foreign, DRAG_EXPLICIT));
    assert_true(applies(method_named("symplectic-euler"), &foreign, DRAG_DEFAULT));
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        if (method->flags & METHOD_SECOND_ORDER)
            assert_refused(method, &first, DRAG_DEFAULT, "first order");
        else if (!(method->flags & METHOD_EXACT))
            assert_true(applies(method, &first, DRAG_DEFAULT));
    }

    struct method only_exact = *method_named("verlet");
    only_exact.drags = 1u << DRAG_EXACT;
    assert_refused(&only_exact, &linear, DRAG_EXPLICIT, "drag=explicit");
}

/* Splittings of an order above 2 step back and forth: of drag they take the linear one, exactly,
 * and not too much. */
TEST(test_splittings_of_higher_order)
{
    const double gamma = 0.25;
    const struct system free_of_drag = SPRING({NULL, 0}), linear = SPRING({"gamma", gamma}),
                        grows = SPRING({"gamma", -gamma}), quadratic = SPRING({"C", 1});
    struct error error = {0};
    int rows = 0;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        if (!method->splitting || method->order <= 2)
            continue;
        rows++;
        assert_true(applies(method, &free_of_drag, DRAG_DEFAULT));
        if (method->flags & METHOD_NO_VELOCITY) {
            assert_refused(method, &linear, DRAG_DEFAULT, "depends on the velocity");
            continue;
        }
        assert_int_equal(resolved(method->row.name, &linear, DRAG_DEFAULT), DRAG_EXACT);
        assert_refused(method, &quadratic, DRAG_DEFAULT, "diverge");
        assert_refused(method, &linear, DRAG_EXPLICIT, "drag=explicit");
        assert_refused(method, &linear, DRAG_IMPLICIT, "drag=implicit");

        double back = 0;
        for (int k = !method->splitting->kick_first; k < method->splitting->count; k += 2)
            back = fmax(back, -splitting_weight(method->splitting, k));
        assert_in_range((uint64_t)(100 * back), 3, 100);
        const double longest = 1 / (gamma * back);
        assert_true(method_fits(method, &linear, DRAG_EXACT, 0.99 * longest, &error));
        assert_true(method_fits(method, &linear, DRAG_EXACT, -0.99 * longest, &error));
        assert_true(method_fits(method, &free_of_drag, DRAG_EXACT, 100 * longest, &error));
        assert_false(method_fits(method, &grows, DRAG_EXACT, -1.01 * longest, &error));
        assert_false(method_fits(method, &linear, DRAG_EXACT, 1.01 * longest, &error));
        assert_non_null(strstr(error.text, method->row.name));
        assert_non_null(strstr(error.text, "backward substep"));
        assert_non_null(strstr(error.hint, "dt <= "));
    }
    assert_true(rows >= 15);
    assert_true(method_fits(method_named("verlet"), &linear, DRAG_EXACT, 1e9, &error));
    assert_true(method_fits(method_named("rk4"), &linear, DRAG_DEFAULT, 1e9, &error));
}

RUN_TESTS(NULL, NULL)
