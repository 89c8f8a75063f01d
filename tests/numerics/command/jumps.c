/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Stated errors of runs whose events make the state or a parameter jump, against the closed forms
 * between the events: errors of the moments count, too.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "long_form.h"
#include "unit/command/testing.h"

#include <hooke/run.h>

enum { TEXT_MAX = 600, EVENTS_MAX = 500 };

/* A state, and what an event may have changed beside it. */
struct state {
    double x, v, mode;
};

/* A system in its parameters p: the flow over d from (t, s), the event's function, the jump. */
struct system_row {
    const char *name;
    void (*text)(const double *p, char *text);
    struct state (*flow)(const double *p, double d, double t, struct state s);
    double (*event)(const double *p, double t, struct state s); /* falls through 0 */
    struct state (*jump)(const double *p, double t, struct state s);
    struct state (*start)(const double *p);
    struct {
        double low, high;
    } range[5];               /* of the parameters */
    double shortest, longest; /* [s] durations */
    double look;              /* [s] no event comes back within */
};

/* ---- a neuron that fires: x' = a - b x, back to c from 1 ---- */

static void fire_text(const double *p, char *text)
{
    snprintf(text, TEXT_MAX,
             "var x = %.17g; x' = %.17g-%.17g*x; event e when 1-x falling do 'x = %.17g; continue'",
             p[2], p[0], p[1], p[2]);
}

static struct state fire_flow(const double *p, double d, double t, struct state s)
{
    (void)t;
    const double rest = p[0] / p[1];
    return (struct state){rest + (s.x - rest) * exp(-p[1] * d), 0, 0};
}

static double below_one(const double *p, double t, struct state s)
{
    (void)p;
    (void)t;
    return 1 - s.x;
}

static struct state fire_jump(const double *p, double t, struct state s)
{
    (void)t;
    (void)s;
    return (struct state){p[2], 0, 0};
}

static struct state fire_start(const double *p)
{
    return (struct state){p[2], 0, 0};
}

/* ---- growth that is divided: x' = a x, x / b from 1 ---- */

static void growth_text(const double *p, char *text)
{
    snprintf(text, TEXT_MAX,
             "var x = 0.5; x' = %.17g*x; event e when 1-x falling do 'x = x/%.17g; continue'", p[0],
             p[1]);
}

static struct state growth_flow(const double *p, double d, double t, struct state s)
{
    (void)t;
    return (struct state){s.x * exp(p[0] * d), 0, 0};
}

static struct state growth_jump(const double *p, double t, struct state s)
{
    (void)t;
    return (struct state){s.x / p[1], 0, 0};
}

static struct state half(const double *p)
{
    (void)p;
    return (struct state){0.5, 0, 1};
}

/* ---- a spring before a wall: x'' = -a x, v = -b v at c ---- */

static void wall_text(const double *p, char *text)
{
    snprintf(text, TEXT_MAX,
             "var x = 1; var v = 0; x' = v; v' = -%.17g*x; "
             "event e when x-(%.17g) falling do 'v = -%.17g*v; continue'",
             p[0], p[2], p[1]);
}

static struct state wall_flow(const double *p, double d, double t, struct state s)
{
    (void)t;
    const double w = sqrt(p[0]), c = cos(w * d), sine = sin(w * d);
    return (struct state){s.x * c + s.v / w * sine, s.v * c - w * s.x * sine, 0};
}

static double above_wall(const double *p, double t, struct state s)
{
    (void)t;
    return s.x - p[2];
}

static struct state wall_jump(const double *p, double t, struct state s)
{
    (void)t;
    return (struct state){s.x, -p[1] * s.v, 0};
}

static struct state at_one(const double *p)
{
    (void)p;
    return (struct state){1, 0, 0};
}

/* ---- a ball on a table that shakes by b sin(c t), with restitution a ---- */

static void table_text(const double *p, char *text)
{
    snprintf(text, TEXT_MAX,
             "var x = 1; var v = 0; x' = v; v' = -%.17g; event e when x-%.17g*sin(%.17g*t) falling "
             "do 'v = -%.17g*v+%.17g*cos(%.17g*t); continue'",
             p[3], p[1], p[2], p[0], (1 + p[0]) * p[1] * p[2], p[2]);
}

static struct state table_flow(const double *p, double d, double t, struct state s)
{
    (void)t;
    return (struct state){s.x + s.v * d - p[3] * d * d / 2, s.v - p[3] * d, 0};
}

static double above_table(const double *p, double t, struct state s)
{
    return s.x - p[1] * sin(p[2] * t);
}

static struct state table_jump(const double *p, double t, struct state s)
{
    return (struct state){s.x, -p[0] * s.v + (1 + p[0]) * p[1] * p[2] * cos(p[2] * t), 0};
}

/* ---- a thermostat: x' = a (u - x), u = 0 from b on, 1 from c on ---- */

static void thermostat_text(const double *p, char *text)
{
    snprintf(text, TEXT_MAX,
             "var x = 0.5; param u = 1; x' = %.17g*(u-x); "
             "event h when %.17g-x falling do 'u = 0; continue'; "
             "event l when x-%.17g falling do 'u = 1; continue'",
             p[0], p[1], p[2]);
}

static struct state thermostat_flow(const double *p, double d, double t, struct state s)
{
    (void)t;
    return (struct state){s.mode + (s.x - s.mode) * exp(-p[0] * d), 0, s.mode};
}

static double thermostat_event(const double *p, double t, struct state s)
{
    (void)t;
    return s.mode > 0 ? p[1] - s.x : s.x - p[2];
}

static struct state thermostat_jump(const double *p, double t, struct state s)
{
    (void)p;
    (void)t;
    return (struct state){s.x, 0, 1 - s.mode};
}

static const struct system_row systems[] = {
    {"fire",
     fire_text,
     fire_flow,
     below_one,
     fire_jump,
     fire_start,
     {{2, 4}, {0.3, 1.5}, {-0.3, 0.3}},
     5,
     20,
     0},
    {"growth",
     growth_text,
     growth_flow,
     below_one,
     growth_jump,
     half,
     {{0.5, 2}, {1.5, 6}},
     5,
     20,
     0},
    {"wall",
     wall_text,
     wall_flow,
     above_wall,
     wall_jump,
     at_one,
     {{1, 9}, {0.7, 1}, {-0.5, -0.1}},
     3,
     15,
     1e-3},
    {"table",
     table_text,
     table_flow,
     above_table,
     table_jump,
     at_one,
     {{0.5, 0.9}, {0.01, 0.04}, {2, 5}, {5, 10}},
     0.7,
     1.4,
     1e-3},
    {"thermostat",
     thermostat_text,
     thermostat_flow,
     thermostat_event,
     thermostat_jump,
     half,
     {{0.5, 3}, {0.6, 0.8}, {0.2, 0.4}},
     5,
     20,
     0},
};

/* Returns the first time up to `end` at which the event's function falls through 0, or NAN. */
static double first_event(const struct system_row *row, const double *p, double t, struct state s,
                          double end)
{
    static const double scan = 0.004; /* [s] far below the time between two events */
    double before = t + row->look;
    if (!(row->event(p, before, row->flow(p, before - t, t, s)) > 0))
        return NAN;
    while (before < end) {
        double low = before, high = fmin(before + scan, end);
        before = high;
        if (row->event(p, high, row->flow(p, high - t, t, s)) > 0)
            continue;
        for (double middle; middle = low + (high - low) / 2, middle > low && middle < high;)
            *(row->event(p, middle, row->flow(p, middle - t, t, s)) > 0 ? &low : &high) = middle;
        return high;
    }
    return NAN;
}

/* Follows the closed form to `end`; *size: the largest values. Returns the number of events. */
static int follow(const struct system_row *row, const double *p, double end, struct state *s,
                  struct state *size)
{
    double t = 0;
    int events = 0;
    *s = row->start(p);
    for (; events < EVENTS_MAX && t < end; events++) {
        const double at = first_event(row, p, t, *s, end), to = isnan(at) ? end : at;
        for (int k = 0; k <= 20; k++) {
            const struct state way = row->flow(p, (to - t) * k / 20, t, *s);
            size->x = fmax(size->x, fabs(way.x));
            size->v = fmax(size->v, fabs(way.v));
        }
        *s = row->flow(p, to - t, t, *s);
        t = to;
        if (isnan(at))
            return events;
        *s = row->jump(p, t, *s);
    }
    return events;
}

static uint64_t seed = 6;

static double uniform(double low, double high)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(seed >> 11) * 0x1p-53;
}

static void errors_count_the_moments(void **state)
{
    (void)state;
    static const char *const methods[] = {"dopri5", "tsit5",   "bogacki-shampine", "radau5",
                                          "rodas4", "rodas5p", "tr-bdf2",          "dop853"};
    static const double rounding = 1e-12;
    const int tries = is_long() ? 1000 : 60;
    int good = 0, low = 0, known = 0;
    for (int i = 0; i < tries; i++) {
        const struct system_row *row = &systems[i % (int)COUNT_OF(systems)];
        const char *method = methods[(int)uniform(0, COUNT_OF(methods))];
        struct bench b;
        char text[TEXT_MAX], line[TEXT_MAX];
        double p[5];
        struct state s, size = {0, 0, 0};
        for (int k = 0; k < 5; k++)
            p[k] = uniform(row->range[k].low, row->range[k].high);
        const double end = uniform(row->shortest, row->longest), tol = pow(10, uniform(-9, -4));
        row->text(p, text);
        bench_open(&b, false);
        type_ok(&b, text);
        snprintf(line, TEXT_MAX, "method %s tol=%.17g; set opinion warn; run %.17g", method, tol,
                 end);
        type_ok(&b, line);
        const struct run *run = session_run(b.session);
        const int events = follow(row, p, end, &s, &size);
        const double off_x = fabs(run->y[0] - s.x) / size.x,
                     off_v = size.v > 0 ? fabs(run->y[1] - s.v) / size.v : 0;
        const double error = fmax(off_x, off_v), told = run->opinion.error;
        assert_true(run_opinion_known(run) && run->opinion.t == run->t);
        known += events > 0;
        const bool fine = fmax(error, told) < rounding || (told >= error / 5 && told <= error * 5);
        good += fine;
        low += told < error / 10 && error > rounding;
        if (!fine)
            print_message("# %s by %s at tol = %.1e, %d events: error %.2g, stated %.2g\n",
                          row->name, method, tol, events, error, told);
        bench_close(&b);
    }
    print_message("# %d runs: %d within a factor of 5, %d below a tenth\n", tries, good, low);
    assert_int_equal(low, 0);
    assert_true(good >= tries * 0.95);
    assert_true(known > tries * 0.8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_count_the_moments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
