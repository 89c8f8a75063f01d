/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The table of reference solutions, references.csv beside the recordings, and which families of
 * methods have reached each of its rows.
 */
#pragma once

#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include "long_form.h"
#include "unit/run/fixture.h"

#include <stdio.h>
#include <stdlib.h>

struct table_row {
    char problem[40], parameters[160], component[16];
    double t; /* NAN: the value is a period */
    double value;
    unsigned reached; /* family_of() of all that came to it */
};

/* Methods that have no code of their steps in common, as one bit; 0: a closed form, which is none.
 */
static inline unsigned family_of(const struct method *method)
{
    const bool is[] = {method->flags & METHOD_EXTERNAL,
                       method->tableau,
                       method->splitting,
                       method->nystrom,
                       method->implicit,
                       method->rosenbrock,
                       method->multistep};
    unsigned family = 0;
    while (family < COUNT_OF(is) && !is[family])
        family++;
    return method->flags & METHOD_EXACT ? 0 : 1u << family; /* the last: algorithms */
}

static inline int families(unsigned reached)
{
    int count = 0;
    for (; reached; reached &= reached - 1)
        count++;
    return count;
}

/* A method of the table, with a tolerance where it is adaptive, else a step; below 0: a step in any
 * case. */
struct attempt {
    const char *method;
    double by;
    double error; /* at most, relative to the size of the solution */
};

#define STEP_QUICK 9e-8 /* shorter ones are for the long form: up to t = 1 they are too many */

/* False: a yardstick that this build does not have, or too many steps for the quick form. */
static inline bool is_there(const struct attempt *attempt)
{
    struct error ignored;
    if (fabs(attempt->by) < STEP_QUICK && attempt->by > 1e-8 && !is_long())
        return false;
    return catalog_find(&method_catalog, text_of(attempt->method)) ||
           !catalog_absent(&method_catalog, text_of(attempt->method), &ignored);
}

static inline struct run_settings settings_of(const struct attempt *attempt)
{
    struct run_settings settings = {.dt = fabs(attempt->by),
                                    .record = {RECORD_EVERY, INT64_MAX, 0}};
    if (method_named(attempt->method)->flags & METHOD_ADAPTIVE && attempt->by > 0) {
        settings.dt = 1e-6;
        settings.tol = attempt->by;
    }
    return settings;
}

/* One field, without its quotes; *rest moves past the comma. */
static inline struct text field(struct text *rest)
{
    struct text got;
    if (rest->len > 0 && rest->data[0] == '"') {
        struct text quoted = {rest->data + 1, rest->len - 1};
        text_split(&quoted, '"', &got);
        *rest = quoted;
        struct text nothing;
        text_split(rest, ',', &nothing);
        return got;
    }
    return text_split(rest, ',', &got) ? got : (struct text){NULL, 0};
}

static inline void keep(char *to, size_t size, struct text from)
{
    snprintf(to, size, "%.*s", (int)from.len, from.data);
}

/* NULL: there is none. */
static inline struct table_row *read_table(size_t *count)
{
    char path[4096];
    struct buffer content = {0};
    struct error error;
    const char *data = getenv("HOOKE_DATA");
    snprintf(path, sizeof path, "%s/../references.csv", data ? data : "../shared/data");
    if (!file_read(path, 1 << 24, &content, &error)) {
        buffer_free(&content);
        return NULL;
    }
    struct table_row *table = calloc(2000, sizeof *table);
    assert_non_null(table);
    struct text rest = buffer_text(&content), line;
    *count = 0;
    for (text_split(&rest, '\n', &line); text_split(&rest, '\n', &line) && *count < 2000;) {
        struct table_row *row = &table[*count];
        size_t used;
        if (line.len == 0)
            continue;
        keep(row->problem, sizeof row->problem, field(&line));
        keep(row->parameters, sizeof row->parameters, field(&line));
        struct text t = field(&line);
        keep(row->component, sizeof row->component, field(&line));
        struct text value = field(&line);
        if (real_parse(t, &row->t) != REAL_OK)
            row->t = NAN;
        assert_int_equal(real_scan(value, '.', &row->value, &used), REAL_OK);
        ++*count;
    }
    buffer_free(&content);
    return table;
}

/* Which variable a component is. */
static inline int index_of(const struct table_row *row)
{
    const char *name = row->component;
    if (name[0] == 'y' && name[1])
        return atoi(name + 1) - 1;
    return text_is(text_of(name), "v") || text_is(text_of(name), "omega");
}

/* A row of that problem; of its parameters a part is given. */
static inline bool is_of(const struct table_row *row, const char *problem, const char *parameters)
{
    return text_starts(text_of(row->problem), text_of(problem)) &&
           (!strstr(row->problem, "_drag") || strstr(problem, "_drag")) &&
           strstr(row->parameters, parameters);
}

/*
 * Largest error over the rows of the problem, in units of each value, or of `min` where that is
 * smaller (NAN: of what the scene holds to be the variable's size); -1: there are none. Marks them.
 */
static inline double worst_of(struct table_row *table, size_t rows, const char *problem,
                              const char *parameters, const struct scene *scene,
                              const struct attempt *by, double min)
{
    const unsigned family = family_of(method_named(by->method));
    double worst = -1, t = 0;
    struct run *run = start(scene, by->method, settings_of(by), HUGE_VAL);
    for (;;) {
        double next = HUGE_VAL;
        for (size_t i = 0; i < rows; i++)
            if (is_of(&table[i], problem, parameters) && table[i].t > t)
                next = fmin(next, table[i].t);
        if (isinf(next))
            break;
        t = next;
        go_to(run, t);
        if (run->stop != STOP_END)
            fail_msg("%s by %s: %s at t = %g", problem, by->method, stop_name(run->stop), run->t);
        for (size_t i = 0; i < rows; i++) {
            const int k = index_of(&table[i]);
            if (!is_of(&table[i], problem, parameters) || table[i].t != t)
                continue;
            assert_true(k < run->system.n);
            const double size = fmax(fabs(table[i].value), isnan(min) ? run->system.scale[k] : min);
            worst = fmax(worst, fabs(run->y[k] - table[i].value) / size);
            table[i].reached |= family;
        }
    }
    run_destroy(run);
    return worst;
}

/*
 * Largest error over the rows of the problem in units of tol and of each variable's size along the
 * run; NAN: more than `max` steps are needed, or there is no row.
 */
static inline double error_over_tol(const struct table_row *table, size_t rows, const char *problem,
                                    const char *parameters, const struct scene *scene,
                                    const char *method, double tol, int64_t max)
{
    const struct attempt by = {method, tol, 0};
    struct run *run = start(scene, method, settings_of(&by), HUGE_VAL);
    double worst = NAN;
    for (double t = 0; run->stop == STOP_NONE || run->stop == STOP_END;) {
        double next = HUGE_VAL;
        for (size_t i = 0; i < rows; i++)
            if (is_of(&table[i], problem, parameters) && table[i].t > t)
                next = fmin(next, table[i].t);
        if (isinf(next))
            break;
        t = next;
        struct run_target target = {.t = t, .steps = max - run->steps};
        assert_false(run_advance(run, &target, 0, NULL));
        if (run->t != t) {
            worst = NAN;
            break;
        }
        for (size_t i = 0; i < rows; i++) {
            const int k = index_of(&table[i]);
            if (!is_of(&table[i], problem, parameters) || table[i].t != t)
                continue;
            const double size = fmax(run->controller.scale[k], fabs(table[i].value));
            worst = fmax(worst, fabs(run->y[k] - table[i].value) / size / tol);
        }
    }
    run_destroy(run);
    return worst;
}

enum { TOLERANCES = 3, STEPS_MIN = 20000, RATIOS = 80 };

/* error/tol at the end of each problem that a method could solve: count[m][k] ratios for method m
 * of the catalog at tolerance k, of tried[m][k] problems. */
struct proportions {
    double ratio[128][TOLERANCES][RATIOS];
    int count[128][TOLERANCES], tried[128][TOLERANCES];
};

/* Returns tolerance k of TOLERANCES; only the long form uses more than the first. Methods of
 * low order would need too many steps for tighter ones. */
static inline double tolerance_of(const struct method *method, int k)
{
    static const double second[TOLERANCES] = {1e-4, 1e-3, 1e-5},
                        third[TOLERANCES] = {1e-5, 1e-4, 1e-6},
                        others[TOLERANCES] = {1e-6, 1e-4, 1e-8};
    return (method->order > 3 ? others : method->order > 2 ? third : second)[k];
}

/* Solves the problem by all adaptive methods that apply to it and adds their ratios. */
static inline void add_proportions(struct proportions *p, const struct table_row *table,
                                   size_t rows, const char *problem, const char *parameters,
                                   const struct scene *scene)
{
    struct system system;
    struct error error;
    assert_true(method_catalog.count <= COUNT_OF(p->ratio) && scene_bind(scene, &system, &error));
    for (size_t m = 0; m < method_catalog.count; m++) {
        const struct method *method = method_at(m);
        enum drag drag = DRAG_DEFAULT;
        if (!(method->flags & METHOD_ADAPTIVE) || !method_applies(method, &system, &drag, &error))
            continue;
        for (int k = 0; k < TOLERANCES; k++) {
            if (k > 0 && !is_long())
                continue;
            p->tried[m][k]++;
            const double off = error_over_tol(table, rows, problem, parameters, scene,
                                              method->row.name, tolerance_of(method, k), STEPS_MIN);
            if (getenv("VERBOSE"))
                print_message("%-16s %.0e %-26s %-14s %.2g\n", method->row.name,
                              tolerance_of(method, k), problem, parameters, off);
            if (!isnan(off))
                p->ratio[m][k][p->count[m][k]++] = off;
            assert_true(p->count[m][k] < RATIOS);
        }
    }
}

static inline int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/*
 * The error is about tol for every method, in the median over the problems. Where a tolerance needs
 * too many steps for many of them the others are the easy ones, and say nothing.
 *
 * The unit is tol times the size of the variable along the run: the mean of struct controller, or
 * the value at the end if that is larger. This is the stricter of the readings that a control by
 * sizes allows: by the largest value so far, which is what an absolute tolerance would be made of,
 * ratios are smaller. By the present value alone they are some ten times that: what decays, or
 * passes through 0, has fewer digits, and no tolerance promises them.
 */
static inline void assert_proportional(struct proportions *p)
{
    int wrong = 0, judged = 0;
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int k = 0; k < TOLERANCES; k++) {
            const struct method *method = method_at(m);
            double *ratio = p->ratio[m][k];
            const int n = p->count[m][k];
            if (n < 10 || 3 * n < 2 * p->tried[m][k])
                continue;
            qsort(ratio, (size_t)n, sizeof *ratio, by_size);
            const double median = ratio[n / 2];
            /* The control of a method from outside is its own: CVODE bounds the error of a step. */
            const double max = method->flags & METHOD_EXTERNAL ? 100 : 3;
            const bool bad = !(median >= 0.1 && median <= max);
            print_message(
                "# %-16s tol %.0e: median of error/tol %.2g, quartiles %.2g and %.2g, of %d%s\n",
                method->row.name, tolerance_of(method, k), median, ratio[n / 4], ratio[3 * n / 4],
                n, bad ? ": wrong" : "");
            wrong += bad;
            judged++;
        }
    assert_int_equal(wrong, 0);
    assert_true(judged >= 8);
}

/* The problems that only typed scenes express (command_references.c); run_reference.c runs the
 * others. */
static inline bool is_foreign(const struct table_row *row)
{
    return text_starts(text_of(row->problem), TEXT("arenstorf")) ||
           (text_starts(text_of(row->problem), TEXT("DETEST-")) && strchr("ABC", row->problem[7]));
}

/* None of the rows, but for those of problems that are foreign, was reached by fewer than two
 * families. */
static inline void assert_all_reached(const struct table_row *table, size_t count, bool foreign)
{
    size_t seen = 0;
    for (size_t i = 0; i < count; i++) {
        if (is_foreign(&table[i]) && !foreign)
            continue;
        seen++;
        if (families(table[i].reached) < 2)
            fail_msg("%s, %s, t = %g, %s: reached by %d famil%s of methods", table[i].problem,
                     table[i].parameters, table[i].t, table[i].component,
                     families(table[i].reached), families(table[i].reached) == 1 ? "y" : "ies");
    }
    assert_true(seen > 200);
}
