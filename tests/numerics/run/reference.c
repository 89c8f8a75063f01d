/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The table of reference solutions (references.csv beside the recordings) against what the scenes
 * give when they are run: each problem as a scene, by methods of at least two families, at every
 * time of the table.
 */
#include <hooke/run.h>
#include <hooke/scene/formula.h>
#include "numerics/references.h"

/*
 * A problem of the table as a scene, and who solves it how well: some ten times what the method
 * reaches at its tightest useful tolerance, and no less than ten times that, which is what step
 * control promises. What limits it is said with each: where nothing is, the rounding of some
 * thousand steps.
 */
struct known {
    const char *problem, *parameters; /* a part of them */
    const char *preset;
    struct {
        const char *name;
        double value;
    } set[12];
    struct attempt by[6];
};

#define UNIT                                                                                       \
    {"m", 1}, {"k", 1},                                                                            \
    {                                                                                              \
        "y0", 1                                                                                    \
    }
#define QUADRATIC(b, c)                                                                            \
    UNIT, {"C", (b)}, {"rho", 1}, {"area", 1},                                                     \
    {                                                                                              \
        "gamma", (c)                                                                               \
    }
#define NOTHING                                                                                    \
    {                                                                                              \
        NULL, 0                                                                                    \
    }
#define HALF_PI 1.57079632679489661923

/* clang-format off */
static const struct known known[] = {
    /* Errors add up in the phase: t eps and the tolerance of every step. */
    {"damped_oscillator", "(undamped)", "spring", {UNIT},
     {{"dop853", 1e-14, 5e-12}, {"odex", 1e-14, 2e-12}, {"gauss6", 0.02, 1e-13}, {"kahan-li8", 0.05, 1e-13},
      {"cvode-adams", 1e-14, 1e-9}}},
    {"damped_oscillator", "gamma=0.1 ", "spring", {UNIT, {"gamma", 0.1}},
     {{"dop853", 1e-14, 1e-13}, {"odex", 1e-14, 1e-13}, {"gauss6", 0.02, 1e-13}, {"kahan-li8", 0.05, 2e-13},
      {"cvode-adams", 1e-14, 2e-11}}},
    {"damped_oscillator", "zeta=1+1e-12", "spring", {UNIT, {"gamma", 2.000000000002}},
     {{"dop853", 1e-14, 1e-13}, {"rodas5p", 1e-13, 1e-12}, {"gauss6", 0.02, 1e-15}, {"kahan-li8", 0.05, 1e-15},
      {"cvode-bdf", 1e-14, 2e-12}}},
    {"damped_oscillator", "zeta=1-1e-12", "spring", {UNIT, {"gamma", 1.999999999998}},
     {{"dop853", 1e-14, 1e-13}, {"rodas5p", 1e-13, 1e-12}, {"gauss6", 0.02, 1e-15}, {"kahan-li8", 0.05, 1e-15},
      {"cvode-bdf", 1e-14, 2e-12}}},
    {"damped_oscillator", "gamma=1e9", "stiff-damped", {NOTHING},
     {{"radau5", 1e-13, 1e-12}, {"rodas5p", 1e-13, 1e-12}, {"cvode-bdf", 1e-13, 2e-12}}},
    /* A million radians: what a step is off by 1e-14 of its phase is 1e-8 at the end. */
    {"damped_oscillator", "stiff spring", "stiff-spring", {NOTHING},
     {{"kahan-li8", 1e-7, 1e-7}, {"gauss6", 1e-7, 1e-5}, {"gauss6", 2e-8, 2e-7}}},
    {"damped_oscillator", "gamma=-0.1", "spring", {UNIT, {"gamma", -0.1}},
     {{"dop853", 1e-14, 2e-13}, {"odex", 1e-14, 1e-13}, {"gauss6", 0.02, 2e-13}, {"kahan-li8", 0.05, 1e-13},
      {"cvode-adams", 1e-14, 5e-11}}},
    {"forced_oscillator", "", "spring", {UNIT, {"gamma", 0.1}, {"F0", 0.5}, {"omega", 1.2}},
     {{"dop853", 1e-14, 1e-12}, {"odex", 1e-14, 1e-12}, {"gauss6", 0.02, 5e-14}, {"kahan-li8", 0.05, 1e-13},
      {"cvode-adams", 1e-14, 1e-10}}},
    {"resonance", "", "resonance", {NOTHING},
     {{"dop853", 1e-14, 2e-12}, {"odex", 1e-14, 1e-12}, {"gauss6", 0.02, 1e-13}, {"kahan-li8", 0.05, 4e-14},
      {"cvode-adams", 1e-14, 1e-10}}},
    /* Turning points, where the drag has a kink, are located. */
    {"quadratic_drag_oscillator", "qdrag_b0.1,", "spring", {QUADRATIC(0.1, 0)},
     {{"dop853", 1e-14, 5e-13}, {"odex", 1e-14, 1e-13}, {"gauss6", 0.02, 5e-14}, {"cvode-adams", 1e-13, 2e-10}}},
    {"quadratic_drag_oscillator", "qdrag_b1,", "spring", {QUADRATIC(1, 0)},
     {{"dop853", 1e-14, 1e-13}, {"odex", 1e-14, 1e-13}, {"gauss6", 0.02, 2e-14}, {"cvode-adams", 1e-13, 2e-10}}},
    {"quadratic_drag_oscillator", "lin0.05", "spring", {QUADRATIC(0.1, 0.05)},
     {{"dop853", 1e-14, 2e-13}, {"odex", 1e-14, 2e-13}, {"gauss6", 0.02, 5e-14}, {"cvode-adams", 1e-13, 2e-10}}},
    /* Rounding, added up by the phase: odex 1.3e-13 to 1.4e-12 at 21 tolerances from 0.5e-14 to 2e-14, by no rule. */
    {"duffing_free", "", "duffing", {NOTHING},
     {{"dop853", 1e-14, 1e-11}, {"odex", 1e-14, 2e-12}, {"gauss6", 0.01, 1e-12}, {"kahan-li8", 0.02, 2e-12},
      {"rodas5p", 1e-13, 5e-10}, {"cvode-adams", 1e-13, 2e-10}}},
    /* Neighbours separate by thirty till then: test_chaos. */
    {"duffing_chaotic", "", "duffing-driven", {NOTHING},
     {{"dop853", 1e-14, 2e-12}, {"odex", 1e-14, 2e-12}, {"gauss6", 0.01, 5e-12}, {"kahan-li8", 0.02, 1e-11},
      {"cvode-adams", 1e-13, 5e-9}}},
    {"pendulum", "", "pendulum", {{"m", 1}, {"g", 1}, {"theta0", HALF_PI}},
     {{"dop853", 1e-14, 5e-12}, {"odex", 1e-14, 1e-12}, {"gauss6", 0.01, 5e-13}, {"kahan-li8", 0.02, 1e-13},
      {"cvode-adams", 1e-13, 2e-9}}},
    /* Sixteen passages by the sun, each with an error of energy and so of period, which the phase adds up. */
    {"kepler", "", "kepler-eccentric", {NOTHING},
     {{"dop853", 1e-14, 2e-10}, {"odex", 1e-14, 8e-10}, {"radau5", 1e-13, 2e-9}, {"kahan-li8", 0.001, 1e-9},
      {"cvode-adams", 1e-14, 1e-7}}},
    {"vdp_mu1", "", "vanderpol", {NOTHING},
     {{"dop853", 1e-14, 2e-13}, {"odex", 1e-14, 1e-13}, {"gauss6", 0.01, 5e-13}, {"rodas5p", 1e-13, 2e-12},
      {"cvode-adams", 1e-13, 2e-12}}},
    /* After each jump the phase remembers the jump's instant, not its error in y; 26 jumps till 11. */
    {"vdpol", "mu=1000 unscaled", "stiff-vanderpol", {NOTHING},
     {{"radau5", 1e-13, 2e-12}, {"rodas5p", 1e-13, 1e-12}, {"odex", 1e-12, 3e-11}, {"cvode-bdf", 1e-13, 1e-10}}},
    {"vdpol", "eps=1e-6 ", "stiff-vanderpol", {{"k", 1e6}, {"mu", 1e6}},
     {{"radau5", 1e-13, 3e-11}, {"rodas5p", 1e-13, 2e-10}, {"cvode-bdf", 1e-13, 5e-9}}},
    {"vdpol", "eps=1e-12", "stiff-vanderpol", {{"k", 1e12}, {"mu", 1e12}},
     {{"radau5", 1e-13, 1e-12}, {"rodas5p", 1e-13, 1e-12}, {"cvode-bdf", 1e-13, 5e-11}}},
    {"vdpol", "mu=1e6 unscaled", "stiff-vanderpol-1e6", {NOTHING},
     {{"radau5", 1e-13, 1e-12}, {"rodas5p", 1e-13, 1e-12}, {"cvode-bdf", 1e-13, 5e-11}}},
    /* cos t attracts: nothing adds up. Of any lambda: -1e6 here. */
    {"prothero_robinson", "", "prothero-robinson", {NOTHING},
     {{"radau5", 1e-13, 2e-11}, {"rodas5p", 1e-13, 1e-12}, {"cvode-bdf", 1e-13, 1e-12}}},
    {"prothero_robinson", "", "prothero-robinson", {{"lambda", -1}},
     {{"dop853", 1e-14, 1e-13}, {"gauss6", 0.01, 1e-14}, {"rodas5p", 1e-13, 1e-12}, {"cvode-adams", 1e-13, 1e-11}}},
    /* y1 and y2 decay to 1e-8 and 1e-13: in units of their scales, 1 and sqrt(k1/k2). */
    {"rober", "", "robertson", {NOTHING},
     {{"radau5", 1e-14, 5e-13}, {"rodas5p", 1e-14, 1e-13}, {"cvode-bdf", 1e-14, 1e-11}}},
    {"orego", "", "orego", {NOTHING},
     {{"radau5", 1e-13, 5e-11}, {"rodas5p", 1e-12, 5e-11}, {"cvode-bdf", 1e-14, 1e-10}}},
    {"DETEST-E2", "", "vanderpol", {NOTHING},
     {{"dop853", 1e-14, 2e-13}, {"odex", 1e-14, 1e-13}, {"gauss6", 0.01, 5e-13}, {"cvode-adams", 1e-13, 2e-12}}},
    {"DETEST-E3", "", "duffing", {{"k3", -1. / 6}, {"F0", 2}, {"omega", 2.78535}, {"phase", -HALF_PI}, {"y0", 0}},
     {{"dop853", 1e-14, 1e-12}, {"odex", 1e-14, 2e-12}, {"gauss6", 0.01, 5e-13}, {"kahan-li8", 0.02, 5e-13},
      {"cvode-adams", 1e-13, 5e-11}}},
    {"DETEST-E4", "", "spring", {QUADRATIC(0.4, 0), {"k", 0}, {"g", -0.032}, {"y0", 30}},
     {{"dop853", 1e-14, 1e-13}, {"odex", 1e-14, 1e-13}, {"gauss6", 0.01, 2e-15}, {"cvode-adams", 1e-13, 5e-12}}},
};
/* clang-format on */

/* ---- solving ---- */

static struct scene scene_for(const struct known *problem)
{
    struct scene scene;
    struct error error;
    const struct row *preset = catalog_find(&preset_catalog, text_of(problem->preset));
    assert_non_null(preset);
    scene_init(&scene, (const struct preset *)(const void *)preset);
    for (size_t i = 0; i < COUNT_OF(problem->set) && problem->set[i].name; i++)
        if (!scene_set(&scene, scene_param(&scene, problem->set[i].name),
                       (struct measured){problem->set[i].value, 0}, &error))
            fail_msg("%s: %s", problem->problem, error.text);
    return scene;
}

static struct table_row *table;
static size_t rows;

static int setup(void **state)
{
    (void)state;
    table = read_table(&rows);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    free(table);
    return 0;
}

/* Skips the test if the file with the references was not found. */
static void need_table(void)
{
    if (table)
        return;
    print_message("no references.csv beside HOOKE_DATA: nothing to compare with\n");
    skip();
}

/* In units of each variable's size. */
static double worst_error(const struct known *problem, const struct attempt *by)
{
    const struct scene scene = scene_for(problem);
    return worst_of(table, rows, problem->problem, problem->parameters, &scene, by, NAN);
}

static bool is_reached(const struct known *problem, const struct attempt *by)
{
    const double error = worst_error(problem, by);
    const bool good = error >= 0 && error <= by->error;
    if (!good || getenv("VERBOSE"))
        print_message("%-25s %-16s %-12s %6.0e  %.1e (%.0e)%s\n", problem->problem,
                      problem->parameters, by->method, by->by, error, by->error,
                      good ? "" : ": wrong");
    return good;
}

TEST(test_references_are_reached)
{
    need_table();
    int wrong = 0;
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const struct known *problem = &known[i];
        struct scene scene = scene_for(problem);
        struct system system;
        struct error error;
        assert_true(scene_bind(&scene, &system, &error));
        for (size_t k = 0; k < COUNT_OF(problem->by) && problem->by[k].method; k++)
            if (is_there(&problem->by[k]))
                wrong += !is_reached(problem, &problem->by[k]);
        /* One step: what is left is the rounding of the start and the coefficients, times their
         * conditioning. */
        if (system_has_exact(&system))
            wrong += !is_reached(problem, &(struct attempt){"exact", 1e9, 1e-11});
    }
    assert_int_equal(wrong, 0);
    /* The comparison can fail: another problem's solution is not this one's. */
    struct known other = known[0];
    other.set[1].value = 1.0001;
    assert_true(worst_error(&other, &other.by[0]) > 1e-5);
}

/* The end errors of each adaptive method on all problems, in units of tol, have a median near 1
 * (assert_proportional()). */
TEST(test_errors_are_about_the_tolerance)
{
    static struct proportions proportions;
    need_table();
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const struct scene scene = scene_for(&known[i]);
        add_proportions(&proportions, table, rows, known[i].problem, known[i].parameters, &scene);
    }
    assert_proportional(&proportions);
}

/* The pendulum's period from rest at 90 degrees: 2 pi / agm(1, cos(theta0/2)); a quarter of it to
 * the bottom. */
TEST(test_period_of_the_pendulum)
{
    static const struct attempt by[] = {{"dop853", 1e-14, 1e-13},
                                        {"gauss6", 1e-2, 1e-13},
                                        {"kahan-li8", 1e-2, 1e-13},
                                        {"cvode-adams", 1e-13, 1e-11}};
    static const struct known pendulum = {"pendulum",
                                          "theta0",
                                          "pendulum",
                                          {{"m", 1}, {"g", 1}, {"theta0", HALF_PI}},
                                          {{NULL, 0, 0}}};
    struct table_row *row = NULL;
    need_table();
    for (size_t i = 0; i < rows; i++)
        if (isnan(table[i].t)) {
            assert_null(row);
            row = &table[i];
        }
    assert_non_null(row);
    assert_true(text_is(text_of("period"), row->component) &&
                is_of(row, pendulum.problem, pendulum.parameters));
    for (size_t k = 0; k < COUNT_OF(by); k++) {
        if (!is_there(&by[k]))
            continue;
        struct scene scene = scene_for(&pendulum);
        struct run *run = start(&scene, by[k].method, settings_of(&by[k]), HUGE_VAL);
        struct expr_scope scope;
        struct arena arena = {0};
        struct condition condition;
        struct error error;
        size_t used;
        assert_true(run_scope(run, &scope));
        assert_true(
            condition_compile(TEXT("theta < 0"), &scope, &arena, &condition, &used, &error));
        struct run_target target = {.t = 10, .steps = -1, .condition = &condition, .scope = &scope};
        assert_false(run_advance(run, &target, 0, NULL));
        assert_int_equal(run->stop, STOP_CONDITION);
        assert_close(4 * run->t, row->value, by[k].error * row->value);
        row->reached |= family_of(run->method);
        arena_reset(&arena);
        run_destroy(run);
    }
}

/*
 * Chaos: neighbours separate, and so does a solution from what rounding makes of it. At t = 50 by
 * some thirty, and the errors made on the way with them; by t = 400 all of them are gone, and two
 * good methods give two different answers.
 */
TEST(test_chaos)
{
    static const struct known chaos = {
        "duffing_chaotic", "", "duffing-driven", {NOTHING}, {{NULL, 0, 0}}};
    static const struct attempt by[] = {{"dop853", 1e-14, 0}, {"gauss6", 1e-2, 0}};
    const double away = 1e-9;
    double at[3][2];
    for (int k = 0; k < 3; k++) {
        struct scene scene = scene_for(&chaos);
        const int y0 = scene_param(&scene, "y0");
        struct error error;
        if (k == 2)
            assert_true(
                scene_set(&scene, y0, (struct measured){scene.value[y0] + away, 0}, &error));
        struct run *run = start(&scene, by[k % 2].method, settings_of(&by[k % 2]), HUGE_VAL);
        go_to(run, 50);
        at[k][0] = run->y[0];
        go_to(run, 400);
        at[k][1] = run->y[0];
        run_destroy(run);
    }
    const double growth = fabs(at[2][0] - at[0][0]) / away;
    if (getenv("VERBOSE"))
        print_message("neighbours separate by %.3g until t = 50\n", growth);
    assert_true(growth > 10 && growth < 1e5);
    assert_close(at[0][0], at[1][0], 1e-15 * growth * 50);
    assert_true(fabs(at[0][1] - at[1][1]) > 0.01);
}

TEST(test_no_row_is_left_over)
{
    need_table();
    assert_all_reached(table, rows, false);
}

RUN_TESTS(setup, teardown)
