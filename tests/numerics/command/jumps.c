/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Stated errors of runs whose events make the state or a parameter jump, against the closed forms
 * between the events: errors of the moments count, too.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/command/testing.h"

#include <hooke/run/opinion.h>

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

/* ---- a ball that falls in any gravity, with restitution b ---- */

static void ball_text(const double *p, char *text)
{
    const double g = pow(10, p[0]);
    snprintf(text, TEXT_MAX,
             "var x = 1; var v = 0; x' = v; v' = -%.17g-%.17g*v; event e when x falling do "
             "'v = -%.17g*v; continue'",
             g, p[2] * sqrt(g), p[1]);
}

static struct state ball_flow(const double *p, double d, double t, struct state s)
{
    (void)t;
    const double g = pow(10, p[0]), k = p[2] * sqrt(g), fall = -g / k, part = -expm1(-k * d);
    return (struct state){s.x + fall * d + (s.v - fall) * part / k, s.v + (fall - s.v) * part, 0};
}

static double above_floor(const double *p, double t, struct state s)
{
    (void)p;
    (void)t;
    return s.x;
}

static struct state ball_jump(const double *p, double t, struct state s)
{
    (void)t;
    return (struct state){0, -p[1] * s.v, 0};
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
    {"ball",
     ball_text,
     ball_flow,
     above_floor,
     ball_jump,
     at_one,
     {{-3, 6}, {0.7, 1}, {0.05, 0.7}},
     1.6,
     5,
     1e-3},
};

/* Returns what times of the row are in units of [s]: a ball's follow from its gravity. */
static double time_unit(const struct system_row *row, const double *p)
{
    return row->flow == ball_flow ? pow(10, -p[0] / 2) : 1;
}

/* Returns the first time up to `end` at which the event's function falls through 0, or NAN. */
static double first_event(const struct system_row *row, const double *p, double t, struct state s,
                          double end)
{
    const double unit = time_unit(row, p), scan = 0.004 * unit; /* far below the time between two */
    double before = t + row->look * unit;
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

TEST(errors_count_the_moments)
{
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
        const double end = uniform(row->shortest, row->longest) * time_unit(row, p),
                     tol = pow(10, uniform(-9, -4));
        row->text(p, text);
        bench_open(&b, false);
        type_ok(&b, text);
        snprintf(line, TEXT_MAX, "method %s tol=%.17g; set opinion warn; run %.17g", method, tol,
                 end);
        type_ok(&b, line);
        struct run *run = session_run(b.session);
        run_second_opinion(run, OPINION_DEMANDED, NULL);
        const int events = follow(row, p, end, &s, &size);
        const double off_x = fabs(run->y[0] - s.x) / size.x,
                     off_v = size.v > 0 ? fabs(run->y[1] - s.v) / size.v : 0;
        const double error = fmax(off_x, off_v), told = run->opinion.error;
        assert_true(run_opinion_known(run) && run->opinion.t == run->t);
        known += events > 0;
        const bool fine = fmax(error, told) < rounding || (told >= error / 5 && told <= error * 5);
        good += fine;
        low += told < error / 10 && error > rounding;
        double below[LIMIT_VARIABLES];
        run_below_tolerance(run, below);
        for (int k = 0; k < run->system.n; k++)
            if (below[k] > 0 && fabs(run->y[k]) > 20 * fmax(told, tol) * (k ? size.v : size.x))
                fail_msg("%s: no digit of %g is certain, by an error of %g", text, run->y[k], told);
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

/* What a run has said of its error. */
struct told {
    bool lost;    /* no digit is certain */
    double error; /* NAN: not known */
    double x, v;  /* the first two variables */
};

/* What it says by itself, or when more work is demanded. */
static struct told run_told(const char *text, enum opinion_effort effort)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "set opinion warn");
    type_ok(&b, text);
    struct run *run = session_run(b.session);
    run_second_opinion(run, effort, NULL);
    const struct told told = {!isnan(run->opinion.lost), run_opinion_error(run), run->y[0],
                              run->y[1]};
    bench_close(&b);
    return told;
}

/* Counts of runs. */
struct tally {
    int known, good, low;
};

static void tally_add(struct tally *tally, const struct told *told, double error, double rounding,
                      const char *text)
{
    if (told->lost || isnan(told->error))
        return;
    tally->known++;
    const bool good = fmax(error, told->error) < rounding ||
                      (told->error >= error / 5 && told->error <= 5 * error);
    tally->good += good;
    if (!(told->error < error / 10 && error > rounding))
        return;
    tally->low++;
    print_message("# error %.2g, stated %.2g: %s\n", error, told->error, text);
}

/*
 * A spring that hardly reaches a wall, or hardly does not: x = sin(w t + 2 n arccos c) after n
 * elastic hits at x = -c. Errors that are as large as the dip decide whether it is hit at all.
 */
TEST(grazing_hits_are_not_known)
{
    static const char *const methods[] = {"dop853", "dopri5", "radau5", "rodas5p", "odex"};
    const int tries = is_long() ? 600 : 60;
    struct tally tally = {0}, brief = {0};
    int clear = 0, unknown = 0;
    for (int i = 0; i < tries; i++) {
        char text[TEXT_MAX];
        const double k = uniform(1, 16), w = sqrt(k), tol = pow(10, uniform(-9, -3)),
                     depth = pow(10, uniform(-9, -2)) * (i % 3 ? 1 : -1), c = 1 - depth,
                     end = uniform(3, 8), skip = depth > 0 ? acos(c) : 0;
        snprintf(text, TEXT_MAX,
                 "var x = 0; var v = %.17g; x' = v; v' = -%.17g*x; event e when x+%.17g falling do "
                 "'v = -1*v; continue'; method %s tol=%.17g; run %.17g",
                 w, k, c, methods[i % (int)COUNT_OF(methods)], tol, end);
        double phase = w * end;
        for (double hit = 1.5 * M_PI - skip; depth > 0 && phase > hit; hit += 2 * M_PI)
            phase += 2 * skip;
        const struct told told = run_told(text, OPINION_DEMANDED),
                          brief_told = run_told(text, OPINION_BRIEF);
        const double error = fmax(fabs(told.x - sin(phase)), fabs(told.v / w - cos(phase)));
        tally_add(&tally, &told, error, 1e-12, text);
        tally_add(&brief, &brief_told, error, 1e-12, text);
        if (fabs(depth) > 300 * tol) {
            clear++;
            unknown += isnan(told.error);
        }
    }
    print_message("# %d grazing runs: %d errors known, %d within a factor of 5, %d below a tenth\n",
                  tries, tally.known, tally.good, tally.low);
    assert_int_equal(tally.low + brief.low, 0);
    assert_true(tally.good >= tally.known * 0.9);
    assert_true(clear > tries / 6 && unknown <= clear / 10);
}

static double start_of_map(int64_t k, int m)
{
    const long double sine = sinl(acosl(-1) * (long double)k / m);
    return (double)(sine * sine);
}

/*
 * x = 4 x (1 - x) at each event: x = sin^2(2^n pi k / m), with 2^n k modulo m in integers. Rounding
 * errors double with each.
 */
TEST(maps_that_spread_rounding_are_told)
{
    const int tries = is_long() ? 300 : 40;
    struct tally tally = {0}, brief = {0};
    int lost = 0;
    for (int i = 0; i < tries; i++) {
        char text[TEXT_MAX];
        const int m = 1001 + 2 * (int)uniform(0, 4000), times = 3 + (int)uniform(0, 60);
        int64_t k = 1 + (int64_t)uniform(0, m - 1);
        snprintf(text, TEXT_MAX,
                 "var x = %.17g; var c = 0.5; x' = 0; c' = 1; event e when 1-c falling do "
                 "'c = 0; x = 4*x*(1-x); continue'; method dop853; run %d.25",
                 start_of_map(k, m), times);
        for (int n = 0; n < times; n++)
            k = 2 * k % m;
        const struct told told = run_told(text, OPINION_DEMANDED),
                          brief_told = run_told(text, OPINION_BRIEF);
        tally_add(&tally, &told, fabs(told.x - start_of_map(k, m)), 1e-12, text);
        tally_add(&brief, &brief_told, fabs(told.x - start_of_map(k, m)), 1e-12, text);
        lost += told.lost;
    }
    print_message(
        "# %d chaotic maps: %d lost, %d known, %d within a factor of 5, %d below a tenth\n", tries,
        lost, tally.known, tally.good, tally.low);
    assert_int_equal(tally.low + brief.low, 0);
    assert_true(lost > 0 && tally.known > tries / 2 && tally.good >= tally.known / 2);
}

RUN_TESTS(NULL, NULL)
