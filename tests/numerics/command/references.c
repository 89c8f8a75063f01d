/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The systems of references.csv, typed: each is a file of examples/problems that is executed here,
 * line by line as a user's would be, and what it makes is run by methods of at least two families
 * to every row of the table. The other files there have published digits of their own.
 */
#include "numerics/references.h"

#include "numerics/battery.h"

#include "unit/command/testing.h"

#define FILES "examples/problems/"

struct problem {
    const char *problem, *parameters; /* a part of them */
    const char *file, *lines;         /* after the file: other parameters */
    double min;                       /* errors are relative to this at least */
    struct attempt by[5];
};

/* Adaptive methods promise the tolerance for a step: at the end it is some ten to a hundred times
 * that. */
#define SMOOTH(bound)                                                                              \
    1,                                                                                             \
    {                                                                                              \
        {"dop853", 1e-14, bound}, {"gauss6", 0.01, bound}, {"odex", 1e-14, bound},                 \
            {"rodas5p", 1e-13, 100 * (bound)},                                                     \
        {                                                                                          \
            "cvode-adams", 1e-13, 1000 * (bound)                                                   \
        }                                                                                          \
    }
/* Close encounters: by adaptive steps only. */
#define CLOSE(bound)                                                                               \
    1,                                                                                             \
    {                                                                                              \
        {"dop853", 1e-14, bound}, {"odex", 1e-14, bound}, {"radau5", 1e-14, bound},                \
        {                                                                                          \
            "cvode-adams", 1e-13, 1000 * (bound)                                                   \
        }                                                                                          \
    }
/* By every method that is for them and adapts; by second order to a few digits, of values that
 * decay to two. */
#define STIFF(min, bound)                                                                          \
    min,                                                                                           \
    {                                                                                              \
        {"radau5", 1e-13, bound}, {"rodas5p", 1e-13, bound}, {"rodas4", 1e-11, 20 * (bound)},      \
            {"tr-bdf2", 1e-6, (min) > 0 ? 2e-5 : 2e-2},                                            \
        {                                                                                          \
            "cvode-bdf", 1e-13, 100 * (bound)                                                      \
        }                                                                                          \
    }

/* clang-format off */
static const struct problem problems[] = {
    {"vdpol", "mu=1000 unscaled", "vanderpol", "", STIFF(1e-3, 2e-12)},
    {"vdpol", "mu=1e6 unscaled", "vanderpol", "mu = 1e6", STIFF(1e-6, 2e-12)},
    {"vdpol", "eps=1e-6 ", "vanderpol-scaled", "", STIFF(1, 5e-11)},
    {"vdpol", "eps=1e-12 ", "vanderpol-scaled", "eps = 1e-12", STIFF(1, 2e-12)},
    {"vdp_mu1", "", "vanderpol", "mu = 1", SMOOTH(1e-12)},
    {"DETEST-E2", "", "vanderpol", "mu = 1", SMOOTH(1e-12)},
    {"orego", "", "oregonator", "", STIFF(1, 5e-11)},
    /* Relative to values that decay to 1e-8 and 1e-13, where the tolerance is one of 1 and 3.6e-5. */
    {"rober", "", "robertson", "", STIFF(0, 1e-6)},
    {"DETEST-A1", "", "detest-a1", "", SMOOTH(1e-13)},
    {"DETEST-A2", "", "detest-a2", "", SMOOTH(1e-13)},
    {"DETEST-A3", "", "detest-a3", "", SMOOTH(2e-13)},
    {"DETEST-A4", "", "detest-a4", "", SMOOTH(1e-13)},
    {"DETEST-A5", "", "detest-a5", "", SMOOTH(2e-13)},
    {"DETEST-B1", "", "detest-b1", "", SMOOTH(1e-12)},
    {"DETEST-B2", "", "detest-b2", "", SMOOTH(1e-13)},
    {"DETEST-B3", "", "detest-b3", "", SMOOTH(1e-13)},
    {"DETEST-B4", "", "detest-b4", "", SMOOTH(8e-13)},
    {"DETEST-B5", "", "detest-b5", "", SMOOTH(1e-13)},
    {"DETEST-C1", "", "detest-c1", "", SMOOTH(1e-13)},
    {"DETEST-C2", "", "detest-c2", "", SMOOTH(1e-13)},
    {"DETEST-C3", "", "detest-c3", "", SMOOTH(1e-13)},
    {"DETEST-E3", "", "detest-e3", "", SMOOTH(2e-12)},
    {"DETEST-E4", "", "detest-e4", "", SMOOTH(1e-13)},
    /* Three passes of the moon magnify errors by 1e6 together; till t = 10 there is one. */
    {"arenstorf", "mu=", "arenstorf", "", CLOSE(2e-9)},
    {"arenstorf_t10", "same", "arenstorf", "", CLOSE(4e-12)},
    {"kepler", "", "kepler", "", CLOSE(2e-9)},
    {"duffing_chaotic", "", "duffing", "", SMOOTH(5e-12)},
    {"duffing_free", "", "duffing", "delta = 0; force0 = 0; alpha = 1", SMOOTH(1e-11)},
    {"pendulum", "theta''", "pendulum", "", SMOOTH(5e-12)},
    {"quadratic_drag_oscillator", "qdrag_b0.1,", "quadratic-drag", "", SMOOTH(1e-11)},
    {"quadratic_drag_oscillator", "qdrag_b1,", "quadratic-drag", "b = 1", SMOOTH(1e-11)},
    {"quadratic_drag_oscillator", "lin0.05", "quadratic-drag", "g = 0.05", SMOOTH(1e-11)},
    {"damped_oscillator", "(undamped)", "damped", "gamma = 0", SMOOTH(5e-12)},
    {"damped_oscillator", "gamma=0.1 ", "damped", "", SMOOTH(1e-12)},
    {"damped_oscillator", "zeta=1+1e-12", "damped", "gamma = 2.000000000002", SMOOTH(1e-13)},
    {"damped_oscillator", "zeta=1-1e-12", "damped", "gamma = 1.999999999998", SMOOTH(1e-13)},
    {"damped_oscillator", "gamma=1e9", "damped", "gamma = 1e9", STIFF(1e-9, 2e-12)},
    {"damped_oscillator", "gamma=-0.1", "damped", "gamma = -0.1", SMOOTH(2e-13)},
    /* A million radians: what a step is off by 1e-14 of its phase is 1e-8 at the end. */
    {"damped_oscillator", "stiff spring", "damped", "gamma = 1; square = 1e12", 1,
     {{"dop853", -1e-7, 1e-7}, {"gauss6", 1e-7, 1e-4}, {"gauss6", 2e-8, 2e-7}}},
    {"forced_oscillator", "", "forced", "", SMOOTH(1e-12)},
    {"resonance", "", "resonance", "", SMOOTH(2e-12)},
    {"prothero_robinson", "", "prothero-robinson", "", STIFF(1, 2e-11)},
};
/* clang-format on */

static struct table_row *table;
static size_t rows;

/* The scene that the file and the lines make. */
static void type_file(struct bench *bench, const char *file, const char *lines)
{
    char line[200];
    bench_open(bench, false);
    snprintf(line, sizeof line, "source " FILES "%s.hk", file);
    type_ok(bench, line);
    type_ok(bench, lines);
}

static bool is_reached(const struct problem *p, const struct scene *scene, const struct attempt *by)
{
    const double worst = worst_of(table, rows, p->problem, p->parameters, scene, by, p->min);
    const bool good = worst >= 0 && worst <= by->error;
    if (!good || getenv("VERBOSE"))
        print_message("%-25s %-16s %-12s %6.0e  %.1e (%.0e)%s\n", p->problem, p->parameters,
                      by->method, by->by, worst, by->error, good ? "" : ": wrong");
    return good;
}

TEST(test_references_are_reached)
{
    int wrong = 0;
    if (!table)
        skip();
    for (size_t i = 0; i < COUNT_OF(problems); i++) {
        const struct problem *p = &problems[i];
        struct bench bench;
        type_file(&bench, p->file, p->lines);
        for (size_t k = 0; k < COUNT_OF(p->by) && p->by[k].method; k++)
            /* rodas4 is of rodas5p's family, and of lower order */
            if (is_there(&p->by[k]) && (is_long() || strcmp(p->by[k].method, "rodas4") != 0))
                wrong += !is_reached(p, &bench.session->setup.scene, &p->by[k]);
        bench_close(&bench);
    }
    assert_int_equal(wrong, 0);
}

/* Adds the errors on oscillators with closed forms, which magnify errors more than most problems of
 * the table. */
static void add_oscillators(struct proportions *p)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(oscillators); i++) {
        const struct swinging *o = &oscillators[i];
        struct table_row row[LIMIT_VARIABLES];
        size_t count = 0;
        double x[LIMIT_VARIABLES];
        char lines[HEAT * 100];
        if (!o->exact)
            continue;
        for (int k = 0; k < LIMIT_VARIABLES; k++)
            x[k] = NAN;
        o->exact(o->parameter, o->t, x);
        for (; count < LIMIT_VARIABLES && !isnan(x[count]); count++) {
            row[count] = (struct table_row){.t = o->t, .value = x[count]};
            snprintf(row[count].problem, sizeof row->problem, "%s", o->name);
            snprintf(row[count].component, sizeof row->component, "y%zu", count + 1);
        }
        oscillator_lines(o, lines, sizeof lines);
        const struct scene scene = typed_scene(models, lines);
        add_proportions(p, row, count, o->name, "", &scene);
    }
    typed_destroy(models);
}

/* The end errors of each adaptive method on all problems, in units of tol, have a median near 1
 * (assert_proportional()), on typed scenes, too. Skipped if the table of references is missing. */
TEST(test_errors_are_about_the_tolerance)
{
    static struct proportions proportions;
    if (!table)
        skip();
    for (size_t i = 0; i < COUNT_OF(problems); i++) {
        const struct problem *p = &problems[i];
        struct bench bench;
        type_file(&bench, p->file, p->lines);
        add_proportions(&proportions, table, rows, p->problem, p->parameters,
                        &bench.session->setup.scene);
        bench_close(&bench);
    }
    add_oscillators(&proportions);
    assert_proportional(&proportions);
}

/* The pendulum's period from rest at 90 degrees: a quarter of it to the bottom, by commands all the
 * way. */
TEST(test_period_of_the_pendulum)
{
    static const struct attempt by[] = {{"dop853", 1e-14, 1e-13}, {"odex", 1e-14, 1e-13}};
    (void)state;
    size_t row = 0;
    if (!table)
        skip();
    while (row < rows && !isnan(table[row].t))
        row++;
    assert_true(row < rows && is_of(&table[row], "pendulum", "theta0"));
    for (size_t k = 0; k < COUNT_OF(by); k++) {
        struct bench bench;
        char line[200];
        snprintf(line, sizeof line, "method %s tol=%g; reset; run until theta < 0", by[k].method,
                 by[k].by);
        type_file(&bench, "pendulum", line);
        const struct run *run = session_run(bench.session);
        assert_close(4 * run->t, table[row].value, by[k].error * table[row].value);
        table[row].reached |= family_of(run->method);
        bench_close(&bench);
    }
}

TEST(test_no_row_is_left_over)
{
    if (!table)
        skip();
    assert_all_reached(table, rows, true);
}

/* What is not in the table. */
static const struct {
    const char *file;
    double t;
    struct {
        const char *name;
        double value;
    } at[14];
    struct attempt by[4];
} published[] = {
    /* Mazzia, Magherini 2008, Test Set for Initial Value Problem Solvers. */
    {"hires",
     321.8122,
     {{"y1", 0.7371312573325668e-3},
      {"y2", 0.1442485726316185e-3},
      {"y3", 0.5888729740967575e-4},
      {"y4", 0.1175651343283149e-2},
      {"y5", 0.2386356198831331e-2},
      {"y6", 0.6238968252742796e-2},
      {"y7", 0.2849998395185769e-2},
      {"y8", 0.2850001604814231e-2}},
     {{"radau5", 1e-13, 1e-10}, {"rodas5p", 1e-13, 1e-10}, {"cvode-bdf", 1e-13, 1e-8}}},
    /* Mathematica's NDSolve with 32 digits. */
    {"brusselator",
     20,
     {{"y1", 0.49863707126834783}, {"y2", 4.5967803494520110}},
     {{"dop853", 1e-14, 1e-11},
      {"gauss6", 1e-2, 1e-11},
      {"odex", 1e-14, 1e-11},
      {"cvode-adams", 1e-13, 1e-8}}},
    {"pleiades",
     3,
     {{"x1", 0.3706139143970502e0},
      {"x2", 0.3237284092057233e1},
      {"x3", -0.3222559032418324e1},
      {"x4", 0.6597091455775310e0},
      {"x5", 0.3425581707156584e0},
      {"x6", 0.1562172101400631e1},
      {"x7", -0.7003092922212495e0},
      {"y1", -0.3943437585517392e1},
      {"y2", -0.3271380973972550e1},
      {"y3", 0.5225081843456543e1},
      {"y4", -0.2590612434977470e1},
      {"y5", 0.1198213693392275e1},
      {"y6", -0.2429682344935824e0},
      {"y7", 0.1091449240428980e1}},
     {{"dop853", 1e-14, 1e-10},
      {"odex", 1e-14, 1e-10},
      {"radau5", 1e-13, 1e-9},
      {"cvode-adams", 1e-13, 1e-6}}},
};

TEST(test_published_digits_are_reached)
{
    int wrong = 0;
    for (size_t i = 0; i < COUNT_OF(published); i++)
        for (size_t m = 0; m < COUNT_OF(published[i].by) && published[i].by[m].method; m++) {
            const struct attempt *by = &published[i].by[m];
            double worst = 0;
            struct bench bench;
            if (!is_there(by))
                continue;
            type_file(&bench, published[i].file, "");
            struct run *run =
                start(&bench.session->setup.scene, by->method, settings_of(by), HUGE_VAL);
            go_to(run, published[i].t);
            for (size_t k = 0; k < COUNT_OF(published[i].at) && published[i].at[k].name; k++) {
                const double value = published[i].at[k].value;
                int at = 0;
                while (at < run->system.n &&
                       !text_is(text_of(system_variable(&run->system, at).name),
                                published[i].at[k].name))
                    at++;
                assert_true(at < run->system.n);
                worst = fmax(worst, fabs(run->y[at] - value) / fabs(value));
            }
            if (worst > by->error || getenv("VERBOSE"))
                print_message("%-12s %-12s %6.0e  %.1e (%.0e)\n", published[i].file, by->method,
                              by->by, worst, by->error);
            wrong += worst > by->error;
            run_destroy(run);
            bench_close(&bench);
        }
    assert_int_equal(wrong, 0);
}

static int setup(void **state)
{
    (void)state;
    table = read_table(&rows);
    if (!table)
        print_message("no references.csv beside HOOKE_DATA: nothing to compare with\n");
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    free(table);
    return 0;
}

RUN_TESTS(setup, teardown)
