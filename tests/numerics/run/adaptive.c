/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Every adaptive method on oscillators with known solutions, from tol 1e-3 to 1e-12 and from first
 * steps that are far too short to far too long: the error at the end is about the tolerance, or
 * something true is said. LONG=1 takes the whole matrix.
 */
#include "numerics/battery.h"

#define MOST 100   /* tol: a larger error is a matter for a word */
#define LEAST 1e-3 /* tol: a smaller one was paid for in vain */
#define NEAR 4 /* an estimate that is so near the truth, as a factor, says what there is to say */
/* of the variable's size: what a run may lose to it beyond its tolerance */
#define ROUNDING 1e-12
#define AGREED 0.1 /* of the tolerance: references that differ by more say nothing about it */

enum { METHODS = 128, RATIOS = 1500 };

static struct {
    double ratio[METHODS][RATIOS];
    int count[METHODS], dear[METHODS], above[METHODS], below[METHODS], silent[METHODS],
        untrue[METHODS];
} table;

/* The first is the one that others are compared with. */
static const double first_steps[] = {1e-6, 10, 1e-12, 1e-2, 1e6};

/* Where the solution is at t, and how far that is known. */
struct answer {
    double y[LIMIT_VARIABLES], known[LIMIT_VARIABLES];
};

/* Two integrations of different kinds. */
static bool integrate_twice(const struct scene *scene, double t, struct answer *answer)
{
    static const char *const names[] = {"dop853", "radau5", "odex", "rodas5p"};
    int found = 0;
    for (size_t i = 0; i < COUNT_OF(names) && found < 2; i++) {
        struct run *run = reach_within(scene, names[i], i == 1 ? 1e-14 : 1e-14, 1e-6, t, 3000000);
        if (run->stop == STOP_END && run->t == t) {
            for (int k = 0; k < run->system.n; k++) {
                answer->known[k] = found > 0 ? fabs(run->y[k] - answer->y[k]) : HUGE_VAL;
                if (found == 0)
                    answer->y[k] = run->y[k];
            }
            found++;
        }
        run_destroy(run);
    }
    return found == 2;
}

/* max_i |error_i| / (tol size_i), size_i: the largest value of the run; unknown: the same of the
 * answer. */
static double ratio_of(const struct run *run, const struct answer *answer, double tol,
                       double *unknown)
{
    double worst = 0;
    *unknown = 0;
    for (int k = 0; k < run->system.n; k++) {
        double size = fmax(run->controller.scale[k], fabs(answer->y[k]));
        if (isnan(answer->y[k]))
            continue;
        for (size_t i = 0; i < trace_count(run->trace); i++)
            size = fmax(size, fabs(trace_state(run->trace, i)[k]));
        const double off = fabs(run->y[k] - answer->y[k]) / (tol * size);
        worst = off <= worst ? worst : off; /* NAN, too */
        *unknown = fmax(*unknown, answer->known[k] / (tol * size));
    }
    return worst;
}

/* What is said, in tolerances: as the program asks for it after each run. */
static double said_of(struct run *run)
{
    run_second_opinion(run, OPINION_DEMANDED, NULL);
    return run->opinion.error / run->controller.tol;
}

static void report(const char *what, const struct swinging *o, const char *lines,
                   const struct run *run, double off, double said, double first)
{
    if (!getenv("VERBOSE") && strcmp(what, "silent") != 0)
        return;
    print_message(
        "%s: %s %g by %s, tol %g, first step %g: %s, %lld steps, error %.3g tol, said %.3g tol\n",
        what, o->name, o->parameter, run->method->row.name, run->settings.tol, first,
        stop_name(run->stop), (long long)run->steps, off, said);
    if (getenv("VERBOSE"))
        print_message("    %s; method %s tol=%g; dt = %g; run %g\n", lines, run->method->row.name,
                      run->settings.tol, first, o->t);
}

/* False: more steps would be needed than are allowed. */
static bool judge(const struct swinging *o, const char *lines, const struct scene *scene, size_t m,
                  const struct answer *answer, double tol, double first)
{
    struct run *run = reach_within(scene, catalog_row(&method_catalog, m)->name, tol, first, o->t,
                                   is_long() ? 300000 : 1000);
    double unknown = 0, off = 0, said = 0;
    const bool arrived = run->stop == STOP_END && run->t == o->t,
               dear = run->stop == STOP_END && !arrived;
    table.dear[m] += dear;
    if (arrived) {
        off = ratio_of(run, answer, tol, &unknown);
        said = said_of(run);
        const bool large = !(off <= fmax(MOST, ROUNDING / tol)) && !(unknown > AGREED * off),
                   small = off < LEAST;
        const bool warned = said > OPINION_WRONG, near = said > off / NEAR && said > MOST / NEAR;
        table.above[m] += large;
        table.below[m] += small;
        if ((large && !warned && !near) || isnan(said)) {
            table.silent[m]++;
            report("silent", o, lines, run, off, said, first);
        } else if (warned && off < MOST / (2 * NEAR)) {
            table.untrue[m]++;
            report("untrue", o, lines, run, off, said, first);
        } else if (small) {
            report("small", o, lines, run, off, said, first);
        }
    } else if (!dear) {
        report("failed", o, lines, run, NAN, NAN, first);
        table.above[m]++;
    }
    if (arrived && unknown < AGREED && table.count[m] < RATIOS && first == first_steps[0])
        table.ratio[m][table.count[m]++] = off;
    run_destroy(run);
    return !dear;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

TEST(test_oscillators)
{
    struct error error;
    struct typed_models *models = typed_create(&error);
    for (size_t i = 0; i < COUNT_OF(oscillators); i++) {
        const struct swinging *o = &oscillators[i];
        if (!is_long() && !o->exact &&
            i % 9 != 0) /* others take an integration to tolerances of rounding first */
            continue;
        static char lines[HEAT * 100];
        oscillator_lines(o, lines, sizeof lines);
        const struct scene scene = typed_scene(models, lines);
        struct answer answer = {0};
        struct system system;
        assert_true(scene_bind(&scene, &system, &error));
        if (o->exact) {
            for (int k = 0; k < LIMIT_VARIABLES; k++)
                answer.y[k] = NAN;
            o->exact(o->parameter, o->t, answer.y);
        } else if (!integrate_twice(&scene, o->t, &answer)) {
            print_message("%s %g: no reference\n", o->name, o->parameter);
            continue;
        }
        if (getenv("VERBOSE"))
            print_message("%s %g: %.17g known to %.2g\n", o->name, o->parameter, answer.y[0],
                          answer.known[0]);
        for (size_t m = 0; m < method_catalog.count; m++) {
            const struct method *method = method_at(m);
            enum drag drag = DRAG_DEFAULT;
            if (!(method->flags & METHOD_ADAPTIVE) ||
                !method_applies(method, &system, &drag, &error))
                continue;
            bool going = true; /* where a tolerance takes too many steps, so do those below it */
            for (int k = 3; k <= 12 && going; k += is_long() ? 1 : 4)
                for (size_t f = 0;
                     f < (is_long() ? COUNT_OF(first_steps) : 1 + (size_t)(k == 3)) && going; f++)
                    going = judge(o, lines, &scene, m, &answer, pow(10, -k), first_steps[f]);
        }
    }
    int silent = 0, untrue = 0, runs = 0;
    for (size_t m = 0; m < method_catalog.count; m++) {
        const int n = table.count[m];
        if (n == 0)
            continue;
        qsort(table.ratio[m], (size_t)n, sizeof(double), by_size);
        print_message("%-16s median %8.2g quartiles %8.2g %8.2g of %d; %d above %d tol, %d silent, "
                      "%d untrue, %d "
                      "below, %d too dear\n",
                      catalog_row(&method_catalog, m)->name, table.ratio[m][n / 2],
                      table.ratio[m][n / 4], table.ratio[m][3 * n / 4], n, table.above[m], MOST,
                      table.silent[m], table.untrue[m], table.below[m], table.dear[m]);
        silent += table.silent[m];
        untrue += table.untrue[m];
        runs += n;
    }
    typed_destroy(models);
    assert_int_equal(silent, 0);
    /* where an estimate ends early and its growth is taken on */
    assert_true(1000 * untrue <= runs);
    assert_true(runs > 150);
}

RUN_TESTS(NULL, NULL)
