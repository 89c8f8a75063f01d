/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Random event functions, all methods, steps from a thousandth of the period to all of it: each
 * root is found once, at its time, or the run reports that events may be missing. Roots of
 * functions of time are known; those of the state are counted along rows between the steps, and
 * where a method follows the closed form, x = cos t, along that.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/scene/typing.h"
#include <hooke/base/catalog.h>
#include <hooke/run.h>

#include <math.h>
#include <stdlib.h>

enum { ROOTS_MAX = 512, TEXT_MAX = 400, ROWS_A_STEP = 64 };

static const double period = 2 * M_PI;

struct fixture {
    struct typed_models *models;
    struct scene scene;
    struct arena arena;
    struct error error;
    uint64_t seed;
    int missed, doubled, doubted, tried, roots;
};

static double uniform(struct fixture *f, double low, double high)
{
    f->seed = f->seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(f->seed >> 11) * 0x1p-53;
}

static int pick(struct fixture *f, int count)
{
    return (int)uniform(f, 0, count);
}

static int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    *state = f;
    if (!f)
        return -1;
    f->seed = 30;
    f->models = typed_create(&f->error);
    scene_init(&f->scene, NULL);
    const char *const lines[] = {"var x = 1", "x'' = -x", NULL};
    return f->models && type_scene(f->models, &f->scene, lines) ? 0 : -1;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    typed_destroy(f->models);
    arena_reset(&f->arena);
    free(f);
    return 0;
}

/* An event function: its text, and the function itself. */
struct function {
    enum { OF_TIME, OF_STATE, MIXED } kind;
    char text[TEXT_MAX];
    double root[4], a, b, c; /* OF_TIME: the product of t - root; else a form of a, b and c */
    int roots, form;
    bool touching;
};

static double value_of(const struct function *g, double t, double x, double v)
{
    switch (g->form) {
    case 0:
        return x - g->c;
    case 1:
        return (x - g->a) * (x - g->b);
    case 2:
        return (v + g->a * x) * (x - g->b) - g->c / 10;
    case 3:
        return x - g->a * t - g->c;
    case 4:
        return x * cos(3 * t) - g->c / 4;
    default:
        return (x - g->a) * (t - g->root[0]);
    }
}

static const char *const form_text[] = {"x - (%.17g)",
                                        "(x - (%.17g))*(x - (%.17g))",
                                        "(x' + (%.17g)*x)*(x - (%.17g)) - (%.17g)/10",
                                        "x - (%.17g)*t - (%.17g)",
                                        "x*cos(3*t) - (%.17g)/4",
                                        "(x - (%.17g))*(t - (%.17g))"};

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
static void write_text(struct function *g)
{
    const char *form = form_text[g->form];
    switch (g->form) {
    case 0:
    case 4:
        snprintf(g->text, TEXT_MAX, form, g->c);
        break;
    case 1:
        snprintf(g->text, TEXT_MAX, form, g->a, g->b);
        break;
    case 2:
        snprintf(g->text, TEXT_MAX, form, g->a, g->b, g->c);
        break;
    case 3:
        snprintf(g->text, TEXT_MAX, form, g->a, g->c);
        break;
    default:
        snprintf(g->text, TEXT_MAX, form, g->a, g->root[0]);
        break;
    }
}
#pragma GCC diagnostic pop

static int by_size(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* Roots on steps and off them, some of them close together or double. */
static void draw_of_time(struct fixture *f, struct function *g, double dt, double end)
{
    const int steps = (int)(end / dt), count = 1 + pick(f, 4);
    *g = (struct function){.kind = OF_TIME, .roots = count, .touching = pick(f, 4) == 0};
    for (int i = 0; i < count; i++) {
        const int way = pick(f, 5);
        if (way < 2)
            g->root[i] = (1 + pick(f, steps - 1)) * dt;
        else if (way == 2 && i > 0)
            g->root[i] = g->root[i - 1];
        else if (way == 3 && i > 0)
            g->root[i] = fmin(g->root[i - 1] + uniform(f, 1e-3, 1) * dt, 0.99 * end);
        else
            g->root[i] = uniform(f, 0.01, 0.99) * end;
    }
    qsort(g->root, (size_t)count, sizeof *g->root, by_size);
    int used = 0;
    for (int i = 0; i < count; i++)
        used += snprintf(g->text + used, (size_t)(TEXT_MAX - used), "%s(t - (%.17g))",
                         i > 0 ? "*" : "", g->root[i]);
    if (g->touching)
        snprintf(g->text + used, (size_t)(TEXT_MAX - used), " touching");
}

static void draw(struct fixture *f, struct function *g, double dt, double end)
{
    const int kind = pick(f, 3);
    if (kind == OF_TIME && end > 3 * dt) {
        draw_of_time(f, g, dt, end);
        return;
    }
    *g = (struct function){.kind = kind == MIXED ? MIXED : OF_STATE,
                           .form = kind == MIXED ? 3 + pick(f, 3) : pick(f, 3),
                           .a = uniform(f, -1, 1),
                           .b = uniform(f, -1, 1),
                           .c = uniform(f, -1, 1)};
    g->root[0] = pick(f, 2) ? (1 + pick(f, (int)(end / dt) - 1)) * dt : uniform(f, 0, end);
    write_text(g);
}

static struct run *go(struct fixture *f, const struct method *method, double dt, double tol,
                      double end, const char *event, double interval)
{
    struct run_settings settings = {.dt = dt, .tol = tol};
    if (interval > 0)
        settings.record = (struct recording_rule){.rule = RECORD_TIMES, .interval = interval};
    struct run *run = run_create(&f->scene, method, &settings, end, &f->error);
    if (!run)
        return NULL;
    struct expr_scope scope;
    struct event watched = {.stop = false};
    struct run_target target = {.t = end, .steps = -1, .event = &watched};
    assert_true(run_scope(run, &scope));
    if (event) {
        size_t used;
        if (!event_compile(text_of(event), &scope, &f->arena, &watched, &used, &f->error))
            fail_msg("%s: %s", event, f->error.text);
        target.events = 1;
    }
    while (run_advance(run, &target, 0, NULL)) {
    }
    return run;
}

/* Counts roots of odd multiplicity, and all others where touches are events. */
static int roots_of_time(const struct function *g, double *root)
{
    int count = 0;
    for (int i = 0, same; i < g->roots; i += same) {
        for (same = 1; i + same < g->roots && g->root[i + same] == g->root[i]; same++) {
        }
        if (same % 2 == 1 || g->touching)
            root[count++] = g->root[i];
    }
    return count;
}

/*
 * Finds between which rows the function changes its sign; returns -1 where they do not tell: a row
 * is nearly a root, or an extreme value between three rows is nearly 0.
 */
static int roots_of_rows(const struct function *g, const struct run *rows, bool closed, double *low,
                         double *high)
{
    double t[3] = {0}, y[3] = {0};
    int count = 0;
    for (size_t i = 0; i < trace_count(rows->trace); i++) {
        const double *s = trace_state(rows->trace, i), now = trace_time(rows->trace, i);
        t[0] = t[1], t[1] = t[2], t[2] = now;
        y[0] = y[1], y[1] = y[2];
        y[2] = closed ? value_of(g, now, cos(now), -sin(now)) : value_of(g, now, s[0], s[1]);
        if (i == 0 && fabs(y[2]) < 1e-9)
            return -1;
        if (i >= 1 && (y[1] < 0) != (y[2] < 0)) {
            if (count == ROOTS_MAX)
                return -1;
            low[count] = t[1], high[count++] = t[2];
        }
        const double bend = i >= 2 ? fabs(y[0] - 2 * y[1] + y[2]) : 0;
        if (i >= 1 && fmin(fabs(y[1]), fabs(y[2])) < (closed ? 1e-5 : 1e-12) + 2 * bend &&
            fabs(y[2] - y[1]) < 4 * bend)
            return -1;
        if (closed && fmin(fabs(y[1]), fabs(y[2])) < 1e-5)
            return -1;
    }
    return count;
}

static void judge(struct fixture *f, const struct function *g, const struct run *run, double dt,
                  const double *low, const double *high, int count, double slack)
{
    const size_t found = run_event_records(run);
    const bool doubt = run_event_doubt(run, 0).steps > 0;
    bool wrong = found != (size_t)count;
    for (int i = 0; i < count && !wrong; i++) {
        const double t = run_event_record(run, (size_t)i)->t;
        wrong = !(t >= low[i] - slack && t <= high[i] + slack);
    }
    f->tried++;
    f->roots += count;
    f->doubted += doubt;
    if (!wrong || doubt)
        return;
    f->missed += found <= (size_t)count;
    f->doubled += found > (size_t)count;
    print_message("# %s dt=%.17g tol=%g: %s: %zu found, %d there\n", run->method->row.name, dt,
                  run->plan.adaptive ? run->settings.tol : 0, g->text, found, count);
    for (size_t i = 0; i < found && i < 6; i++)
        print_message("#   %.17g %d\n", run_event_record(run, i)->t,
                      run_event_record(run, i)->direction);
    for (int i = 0; i < count && i < 6; i++)
        print_message("#   there: %.17g .. %.17g\n", low[i], high[i]);
}

static void try_function(struct fixture *f, const struct method *method, double dt)
{
    const double end = fmax(6 * dt, fmin(1.5 * period, 200 * dt));
    const double tol = pick(f, 2) && method->flags & METHOD_ADAPTIVE ? 1e-8 : 0;
    double low[ROOTS_MAX], high[ROOTS_MAX];
    struct function g;
    draw(f, &g, dt, end);
    struct run *run = go(f, method, dt, tol, end, g.text, 0), *rows = NULL;
    if (!run)
        return;
    int count = -1;
    if (stop_is_failure(run->stop)) {
    } else if (g.kind == OF_TIME) {
        count = roots_of_time(&g, low);
        memcpy(high, low, sizeof low);
    } else {
        const double interval = fmax(fmin(dt, period) / ROWS_A_STEP, period / 2000);
        rows = go(f, method, dt, tol, end, NULL, interval);
        count = rows ? roots_of_rows(&g, rows, method->order == 0, low, high) : -1;
    }
    if (count >= 0)
        judge(f, &g, run, dt, low, high, count, 1e-9 * (1 + end));
    run_destroy(rows);
    run_destroy(run);
    arena_reset(&f->arena);
}

static void test_random_functions(void **state)
{
    struct fixture *f = *state;
    const int each = is_long() ? 60 : 2;
    for (size_t k = 0; k < method_catalog.count; k++) {
        const struct method *method = method_at(k);
        if (method->flags & METHOD_EXTERNAL)
            continue;
        for (int i = 0; i < each; i++)
            try_function(f, method, period * pow(10, uniform(f, -3, 0)));
    }
    print_message("# %d runs, %d roots: %d missed, %d doubled, %d possibly incomplete\n", f->tried,
                  f->roots, f->missed, f->doubled, f->doubted);
    assert_int_equal(f->missed + f->doubled, 0);
    assert_true(f->tried > 60 && f->doubted * 10 < f->tried);
}

/*
 * The closed form dips below a level for a moment in each period, in steps from a thirtieth of the
 * period to twelve of them: polynomials that follow such steps to a few percent do not show it.
 */
static void test_short_dips(void **state)
{
    struct fixture *f = *state;
    const struct method *exact = method_by_name(TEXT("exact"));
    const int count = is_long() ? 2000 : 100;
    for (int i = 0; i < count; i++) {
        /* steps of whole periods begin, end and have their middle at the same state */
        const double dt = period * (i % 5 ? pow(10, uniform(f, -1.5, 1.1)) : 1 + pick(f, 12)),
                     depth = pow(10, uniform(f, -8, -1)), end = fmax(3 * dt, 8 * period),
                     half = acos(1 - depth);
        struct function g = {.kind = OF_STATE, .form = 0, .c = depth - 1};
        double root[ROOTS_MAX];
        int roots = 0;
        for (double middle = M_PI; middle - half < end; middle += period) {
            root[roots++] = middle - half;
            if (middle + half < end)
                root[roots++] = middle + half;
        }
        write_text(&g);
        struct run *run = go(f, exact, dt, 0, end, g.text, 0);
        assert_non_null(run);
        judge(f, &g, run, dt, root, root, roots, 1e-6);
        assert_int_equal(run_event_doubt(run, 0).steps, 0);
        run_destroy(run);
        arena_reset(&f->arena);
    }
    print_message("# %d dips: %d missed, %d doubled\n", f->roots / 2, f->missed, f->doubled);
    assert_int_equal(f->missed + f->doubled, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_random_functions, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_short_dips, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
