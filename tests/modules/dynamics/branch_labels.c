/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What branches call stable against runs: of points of branches of equilibria, orbits and
 * responses a difference dies where the label says so, and grows where it does not. The runs are
 * classical Runge-Kutta ones, which nothing else here uses.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

#include <hooke/base/numeric.h>

#define SMALL 1e-6
#define PERIODS 60 /* of a run at most */
#define ENOUGH 30  /* times, that a difference grows or shrinks */

static struct typed_models *models;

struct labelled_branch {
    const char *lines[10], *param;
    double from, to, start;
    enum solution_kind kind;
    int n;
    double state[4], period;
    enum special leave; /* the branch that leaves the first such point */
};

#define REST SOLUTION_EQUILIBRIUM
#define LORENZ                                                                                     \
    {                                                                                              \
        "var x = 1", "var y = 1", "var z = 1", "param r = 0.5", "x' = 10*(y-x)", "y' = x*(r-z)-y", \
            "z' = x*y-8/3*z"                                                                       \
    }
#define ROSSLER                                                                                    \
    {                                                                                              \
        "var x = 1", "var y = 1", "var z = 1", "param c = 2.5", "x' = -y-z", "y' = x+0.2*y",       \
            "z' = 0.2+z*(x-c)"                                                                     \
    }

static const struct labelled_branch branches[] = {
    {LORENZ, "r", 0, 30, 0.5, REST, 3, {0}, 0, SPECIAL_NONE},
    {LORENZ, "r", 0, 30, 0.5, REST, 3, {0}, 0, SPECIAL_CROSSING},
    {LORENZ, "r", 15, 30, 20, REST, 3, {7.118, 7.118, 19}, 0, SPECIAL_HOPF},
    {{"var x = 1", "var y = 0", "param m = 1", "x' = y", "y' = m*(1-x^2)*y-x"},
     "m",
     0.05,
     4,
     1,
     SOLUTION_ORBIT,
     2,
     {2.008619860875, 0},
     6.6633,
     SPECIAL_NONE},
    {{"var x = 1", "var y = 1", "param b = 1", "x' = 1-(b+1)*x+x^2*y", "y' = b*x-x^2*y"},
     "b",
     0.5,
     3,
     1,
     REST,
     2,
     {1, 1},
     0,
     SPECIAL_HOPF},
    {{"var x = 1", "var y = 1", "param b = 1", "x' = -x+0.08*y+x^2*y", "y' = b-0.08*y-x^2*y"},
     "b",
     0.1,
     1,
     0.3,
     REST,
     2,
     {0.3, 1.8},
     0,
     SPECIAL_HOPF},
    {{"var x = 1", "var y = 1", "param m = -1", "x' = m*x-2*y+x*(x^2+y^2)-x*(x^2+y^2)^2",
      "y' = 2*x+m*y+y*(x^2+y^2)-y*(x^2+y^2)^2"},
     "m",
     -1,
     1,
     -0.5,
     REST,
     2,
     {0},
     0,
     SPECIAL_HOPF},
    {{"var x = 1", "param h = 0", "x' = h+x-x^3"}, "h", -1, 1, 0, REST, 1, {1}, 0, SPECIAL_NONE},
    {{"var x = 1", "var v = 0", "param w = 0.6", "x' = v", "v' = -0.1*v-x-x^3+0.3*cos(w*t)"},
     "w",
     0.6,
     2.5,
     0.6,
     SOLUTION_RESPONSE,
     2,
     {0.4, 0},
     0,
     SPECIAL_NONE},
    {{"var q = 1", "var v = 0", "param g = 0.9", "q' = v", "v' = -v/2-sin(q)+g*cos(2*t/3)"},
     "g",
     0.9,
     1.1,
     0.99,
     SOLUTION_RESPONSE,
     2,
     {-1.07195, 1.89723},
     0,
     SPECIAL_NONE},
    {{"var q = 1", "var v = 0", "param g = 0.9", "q' = v", "v' = -v/2-sin(q)+g*cos(2*t/3)"},
     "g",
     0.9,
     1.1,
     0.99,
     SOLUTION_RESPONSE,
     2,
     {-1.07195, 1.89723},
     0,
     SPECIAL_CROSSING},
    {{"var x = 0", "var v = 0", "param q = 0.1", "x' = v", "v' = -0.2*v-(1-2*q*cos(2*t))*x-x^3"},
     "q",
     0,
     0.5,
     0.1,
     SOLUTION_RESPONSE,
     2,
     {0},
     0,
     SPECIAL_NONE},
    {{"var x = 0", "var v = 0", "param q = 0.1", "x' = v", "v' = -0.2*v-(1-2*q*cos(2*t))*x-x^3"},
     "q",
     0,
     0.5,
     0.1,
     SOLUTION_RESPONSE,
     2,
     {0},
     0,
     SPECIAL_DOUBLING},
    {ROSSLER, "c", 2, 4.5, 2.5, SOLUTION_ORBIT, 3, {4.5, 0, 1.2}, 5.749, SPECIAL_NONE},
    {ROSSLER, "c", 2, 4.5, 2.5, SOLUTION_ORBIT, 3, {4.5, 0, 1.2}, 5.749, SPECIAL_DOUBLING},
};

/* By classical Runge-Kutta steps, from the scene's t0. */
static void run(const struct system *system, double *y, double time, int steps)
{
    const int n = system->n;
    const double h = time / steps;
    for (int i = 0; i < steps; i++) {
        double k[4][4], z[4];
        for (int s = 0; s < 4; s++) {
            const double part = s == 0 ? 0 : s == 3 ? h : h / 2;
            for (int j = 0; j < n; j++)
                z[j] = y[j] + (s > 0 ? part * k[s - 1][j] : 0);
            system_derivative(system, system->t0 + i * h + part, z, k[s]);
        }
        for (int j = 0; j < n; j++)
            y[j] += h / 6 * (k[0][j] + 2 * k[1][j] + 2 * k[2][j] + k[3][j]);
    }
}

/* What is left of a difference, but for what goes along the orbit. */
static double apart(const struct system *system, const struct solution *s, const double *a,
                    const double *b)
{
    double rate[4], size = 0, along = 0, sum = 0;
    system_derivative(system, system->t0, s->state, rate);
    for (int i = 0; i < s->n; i++) {
        size += rate[i] * rate[i];
        along += rate[i] * (a[i] - b[i]);
    }
    for (int i = 0; i < s->n; i++) {
        const double off = a[i] - b[i] - (s->kind == SOLUTION_ORBIT ? along / size * rate[i] : 0);
        sum += off * off;
    }
    return sqrt(sum);
}

/* How much a random difference has grown after that time, the most of three. */
static double growth(const struct system *system, const struct solution *s, double time, int steps,
                     uint64_t *seed)
{
    double most = 0;
    for (int k = 0; k < 3; k++) {
        double y[2][4], before;
        for (int i = 0; i < s->n; i++) {
            y[0][i] = s->state[i];
            y[1][i] = s->state[i] + SMALL * (2 * random_fraction(seed) - 1);
        }
        before = apart(system, s, y[1], y[0]);
        for (int p = 0; p < 2; p++)
            run(system, y[p], time, steps);
        most = fmax(most, apart(system, s, y[1], y[0]) / before);
    }
    return most;
}

/* 1: as it is called, -1: not, 0: a run would last too long. */
static int judge(const struct scene *scene, int param, const struct solution *s, uint64_t *seed)
{
    struct scene there = *scene;
    struct system system;
    struct error error;
    double rate = -HUGE_VAL, fastest = 0; /* of the slowest to die or the fastest to grow */
    there.value[param] = s->param[0];
    assert_true(scene_bind_motion(&there, &system, &error));
    const bool rest = s->kind == SOLUTION_EQUILIBRIUM;
    for (int i = 0; i < s->values; i++) {
        const double size = hypot(s->value[i].re, s->value[i].im);
        rate = fmax(rate, rest ? s->value[i].re : log(fmax(size, 1e-9)));
        fastest = fmax(fastest, size);
    }
    const double times = log(ENOUGH) / fabs(rate), unit = rest ? TWO_PI / fastest : s->period;
    const double spans = rest ? times / unit : ceil(times);
    if (!(spans <= PERIODS))
        return 0;
    const double grown =
        growth(&system, s, spans * unit, (int)ceil(spans) * (is_long() ? 3000 : 1000), seed);
    return solution_stable(s) == (grown < 1) && (rate < 0) == solution_stable(s) ? 1 : -1;
}

static struct branch follow(const struct labelled_branch *l, const struct scene *scene)
{
    struct branch branch;
    struct error error = {0};
    struct solution start = {.kind = l->kind,
                             .n = l->n,
                             .param = {l->start},
                             .period = l->period,
                             .multiple = l->kind == SOLUTION_RESPONSE};
    struct branch_point left = {.special = SPECIAL_NONE};
    memcpy(start.state, l->state, sizeof l->state);
    struct branch_request request = {.scene = scene,
                                     .param = scene_param(scene, l->param),
                                     .low = l->from,
                                     .high = l->to,
                                     .start = &start};
    if (!branch_follow(&request, &branch, &error))
        fail_msg("%s: %s", l->lines[3], error.text);
    for (int i = branch.count - 1; i >= 0 && l->leave != SPECIAL_NONE; i--)
        if (branch.point[i].special == l->leave)
            left = branch.point[i];
    if (l->leave == SPECIAL_NONE)
        return branch;
    assert_int_equal(left.special, l->leave);
    branch_free(&branch);
    request.leave = &left;
    if (!branch_follow(&request, &branch, &error))
        fail_msg("%s: %s", l->lines[3], error.text);
    return branch;
}

static void test_labels(void **state)
{
    (void)state;
    uint64_t seed = 5;
    int told = 0, stable = 0;
    const int each = is_long() ? 100 : 4;
    for (size_t k = 0; k < COUNT_OF(branches); k++) {
        const struct labelled_branch *l = &branches[k];
        struct scene scene;
        scene_init(&scene, NULL);
        assert_true(type_scene(models, &scene, l->lines));
        scene.value[scene_param(&scene, l->param)] = l->start;
        struct branch branch = follow(l, &scene);
        for (int i = 0; i < each; i++) {
            const int at = (int)(random_fraction(&seed) * branch.count);
            const struct solution *s = &branch.point[at].solution;
            const int verdict = judge(&scene, scene_param(&scene, l->param), s, &seed);
            if (verdict < 0)
                fail_msg("%s: %s = %.17g is not %s", l->lines[4], l->param, s->param[0],
                         solution_stable(s) ? "stable" : "unstable");
            told += verdict;
            stable += verdict && solution_stable(s);
        }
        branch_free(&branch);
    }
    print_message("%d labels, %d of them stable\n", told, stable);
    assert_true(told >= (is_long() ? 1000 : 40) && 4 * stable > told && 4 * stable < 3 * told);
}

/* ---- where a response jumps in sweeps of runs ---- */

static struct scene duffing(void)
{
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene,
                           (const char *const[]){"var x = 0", "var v = 0", "param w = 1", "x' = v",
                                                 "v' = -0.1*v-x-x^3+0.3*cos(w*t)", NULL}));
    return scene;
}

/* On from y, a period of the drive at a time, until it has settled (and y is that): true; or has
 * gone to another response. */
static bool settles(struct scene *scene, double w, double settled, double *y)
{
    struct system system;
    struct error error;
    double now[2] = {y[0], y[1]}, moved = HUGE_VAL;
    scene->value[scene_param(scene, "w")] = w;
    assert_true(scene_bind_motion(scene, &system, &error));
    for (long k = 0; k < 10000000 && moved > settled; k++) {
        const double before[2] = {now[0], now[1]};
        run(&system, now, TWO_PI / w, 300);
        moved = hypot(now[0] - before[0], now[1] - before[1]);
        if (hypot(now[0] - y[0], now[1] - y[1]) > 0.5)
            return false;
    }
    y[0] = now[0];
    y[1] = now[1];
    return true;
}

/* The frequency up to which a sweep from one end stays on its response. */
static double jump(double from, double to, double within)
{
    struct scene scene = duffing();
    double y[2] = {0, 0}, ok = from, step = (to - from) / 20;
    struct system system;
    struct error error;
    scene.value[scene_param(&scene, "w")] = from;
    assert_true(scene_bind_motion(&scene, &system, &error));
    run(&system, y, 100 * TWO_PI / from, 30000);
    while (fabs(step) > within) {
        double next[2] = {y[0], y[1]};
        if (settles(&scene, ok + step, 1e-3 * within, next)) {
            ok += step;
            y[0] = next[0];
            y[1] = next[1];
        } else {
            step /= 4;
        }
    }
    return ok;
}

/* Both folds of Duffing's response, by branches of two kinds with other steps (those of the drive,
 * and of an oscillator that takes its place, whose orbits have a period of their own), are where
 * sweeps up and down jump. */
static void test_jumps(void **state)
{
    (void)state;
    static const struct labelled_branch ways[] = {
        {{"var x = 1", "var v = 0", "param w = 0.8", "x' = v", "v' = -0.1*v-x-x^3+0.3*cos(w*t)"},
         "w",
         0.5,
         2.5,
         0.8,
         SOLUTION_RESPONSE,
         2,
         {0.7, 0.1},
         0,
         SPECIAL_NONE},
        {{"var x = 1", "var v = 0", "var p = 1", "var q = 0", "param w = 0.8", "x' = v",
          "v' = -0.1*v-x-x^3+0.3*p", "p' = p-w*q-p*(p^2+q^2)", "q' = w*p+q-q*(p^2+q^2)"},
         "w",
         0.6,
         2.2,
         0.8,
         SOLUTION_ORBIT,
         4,
         {0.8, 0.1, 1, 0},
         7.853981633974483,
         SPECIAL_NONE}};
    const double within = is_long() ? 1e-9 : 1e-4;
    const double jumps[] = {jump(1, 2, within), jump(2.2, 1, within)};
    for (size_t k = 0; k < COUNT_OF(ways); k++) {
        struct scene scene;
        int folds = 0;
        scene_init(&scene, NULL);
        assert_true(type_scene(models, &scene, ways[k].lines));
        struct branch branch = follow(&ways[k], &scene);
        for (int i = 0; i < branch.count; i++)
            if (branch.point[i].special == SPECIAL_FOLD) {
                const double at = branch.point[i].solution.param[0];
                close_to(at, folds == 0 ? 1.7797195242985731 : 1.3242362007705656, 1e-12);
                close_to(at, jumps[folds++ == 0 ? 0 : 1], is_long() ? 1e-8 : 4e-4);
            }
        assert_int_equal(folds, 2);
        branch_free(&branch);
    }
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_labels), cmocka_unit_test(test_jumps)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
