/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Equilibria, orbits and branches against closed forms and published values. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include "unit/scene/typing.h"

#include <signal.h>
#include <sys/time.h>

#include <hooke/base/numeric.h>

static struct typed_models *models;

static struct scene typed(const char *const *lines)
{
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    return scene;
}

#define TYPED(...) typed((const char *const[]){__VA_ARGS__, NULL})

static struct branch follow(const struct scene *scene, const char *param, double from, double to,
                            const struct solution *start, const struct branch_point *leave,
                            double step)
{
    const struct branch_request request = {.scene = scene,
                                           .param = scene_param(scene, param),
                                           .low = from,
                                           .high = to,
                                           .start = start,
                                           .leave = leave,
                                           .step = step};
    struct branch branch;
    struct error error = {0};
    if (!branch_follow(&request, &branch, &error))
        fail_msg("%s", error.text);
    return branch;
}

/* The number-th special point of that kind along the branch; NULL: there are fewer. */
static const struct branch_point *special(const struct branch *branch, enum special kind,
                                          int number)
{
    for (int i = 0; i < branch->count; i++)
        if (branch->point[i].special == kind && --number == 0)
            return &branch->point[i];
    return NULL;
}

static void relative(double value, double wanted, double tolerance)
{
    close_to(value, wanted, tolerance * fabs(wanted));
}

static struct scene lorenz(void)
{
    return TYPED("var x = 0.1", "var y = 0.1", "var z = 0.1", "param s = 10",
                 "param b = 2.6666666666666665", "param r = 0.5", "x' = s*(y-x)", "y' = x*(r-z)-y",
                 "z' = x*y-b*z");
}

/* The pitchfork at r = 1 is found whatever the steps are, also where one lands on it; on the branch
 * that leaves it the Hopf point at 470/19 is subcritical. */
static void test_lorenz_equilibria(void **state)
{
    (void)state;
    const struct scene scene = lorenz();
    const struct solution origin = {.kind = SOLUTION_EQUILIBRIUM, .n = 3, .param = {0.5}};
    for (int k = 0; k < 20; k++) {
        /* 0.5 + 0.5 of 30 is the point itself */
        const double step = k == 0 ? 0.5 / 30 : 0.004 + 0.003 * k;
        struct branch branch = follow(&scene, "r", 0, 30, &origin, NULL, step);
        const struct branch_point *point = special(&branch, SPECIAL_CROSSING, 1);
        assert_non_null(point);
        assert_null(special(&branch, SPECIAL_CROSSING, 2));
        close_to(point->solution.param[0], 1, 1e-10);
        branch_free(&branch);
    }
    struct branch first = follow(&scene, "r", 0, 30, &origin, NULL, 0);
    struct branch second =
        follow(&scene, "r", 0, 30, NULL, special(&first, SPECIAL_CROSSING, 1), 0);
    const struct branch_point *hopf = special(&second, SPECIAL_HOPF, 1);
    assert_non_null(hopf);
    relative(hopf->solution.param[0], 470.0 / 19, 1e-12);
    assert_true(hopf->criticality > 0);
    branch_free(&second);
    branch_free(&first);
}

/* Orbits that are born at the Hopf point go to the homoclinic one at 13.926557407520 (Sparrow 1982:
 * 13.926). */
static void test_lorenz_orbits(void **state)
{
    (void)state;
    const struct scene scene = lorenz();
    const double c = sqrt(8.0 / 3 * 19);
    const struct solution rest = {
        .kind = SOLUTION_EQUILIBRIUM, .n = 3, .param = {20}, .state = {c, c, 19}};
    struct branch still = follow(&scene, "r", 15, 30, &rest, NULL, 0);
    struct branch orbits = follow(&scene, "r", 0, 30, NULL, special(&still, SPECIAL_HOPF, 1), 0);
    assert_int_equal(orbits.kind, SOLUTION_ORBIT);
    const struct solution *last = &orbits.point[orbits.count - 1].solution;
    assert_true(last->period > 15.7);
    close_to(last->param[0], 13.92655740752, 1e-8);
    /* near the saddle only the time spent there grows: 752260 where all of the orbit is stretched
     */
    assert_true(orbits.evals < 250000);
    for (int i = 0; i < orbits.count; i++)
        assert_int_not_equal(orbits.point[i].solution.unstable, 0);
    assert_null(special(&orbits, SPECIAL_DOUBLING, 1));
    assert_null(special(&orbits, SPECIAL_FOLD, 1));
    branch_free(&orbits);
    branch_free(&still);
}

/* Roessler's cascade, and one branch for each turn of it. */
static void test_doublings(void **state)
{
    (void)state;
    static const double at[] = {2.832445027862, 3.837358168410, 4.124214732075};
    const struct scene scene =
        TYPED("var x = 1", "var y = 1", "var z = 1", "param a = 0.2", "param b = 0.2",
              "param c = 2.5", "x' = -y-z", "y' = x+a*y", "z' = b+z*(x-c)");
    const struct solution start = {
        .kind = SOLUTION_ORBIT, .n = 3, .param = {2.5}, .period = 5.77, .state = {4.5, 0, 1.5}};
    struct branch branch = follow(&scene, "c", 1, 6, &start, NULL, 0);
    for (int k = 0; k < 3; k++) {
        const struct branch_point *point = special(&branch, SPECIAL_DOUBLING, 1);
        assert_non_null(point);
        relative(point->solution.param[0], at[k], 1e-11);
        struct branch next = follow(&scene, "c", 1, 6, NULL, point, 0);
        branch_free(&branch);
        branch = next;
    }
    branch_free(&branch);
}

/* Both folds of a forced Duffing oscillator's response (harmonic balance with 24 harmonics agrees).
 */
static void test_response(void **state)
{
    (void)state;
    const struct scene scene = TYPED("var x = 1", "var v = 0", "param d = 0.1", "param F = 0.3",
                                     "param w = 0.8", "x' = v", "v' = -d*v-x-x^3+F*cos(w*t)");
    const struct solution start = {
        .kind = SOLUTION_RESPONSE, .n = 2, .param = {0.8}, .multiple = 1, .state = {0.5, 0}};
    struct branch branch = follow(&scene, "w", 0.8, 2.2, &start, NULL, 0);
    const struct branch_point *high = special(&branch, SPECIAL_FOLD, 1),
                              *low = special(&branch, SPECIAL_FOLD, 2);
    assert_non_null(high);
    assert_non_null(low);
    assert_null(special(&branch, SPECIAL_FOLD, 3));
    relative(high->solution.param[0], 1.7797195242985731, 1e-12);
    relative(low->solution.param[0], 1.3242362007705656, 1e-12);
    relative(high->solution.top[0], 1.7222520193521275, 1e-8);
    relative(low->solution.top[0], 0.59283219109489081, 1e-8);
    /* 253392 where a fold is looked for below its rounding */
    assert_true(branch.evals < 180000);
    branch_free(&branch);
    /* towards a drive that stops it ends while its periods can be followed: minutes otherwise */
    branch = follow(&scene, "w", 0, 2, &start, NULL, 0);
    assert_string_equal(branch.ends[0], "the period grows without bound");
    assert_non_null(special(&branch, SPECIAL_FOLD, 2));
    assert_true(branch.evals < 2500000);
    branch_free(&branch);
}

/* van der Pol: period and multiplier, then the stiff one, by its asymptotic terms (Dorodnicyn 1947,
 * with the constant of Urabe 1960): what is left is of order mu^(-4/3). */
static void test_relaxation(void **state)
{
    (void)state;
    const struct scene scene =
        TYPED("var x = 2", "var y = 0", "param mm = 1", "x' = y", "y' = mm*(1-x^2)*y-x");
    const struct solution start = {
        .kind = SOLUTION_ORBIT, .n = 2, .param = {1}, .period = 6.66, .state = {2, 0}};
    const double mu = is_long() ? 1000 : 10;
    struct branch branch = follow(&scene, "mm", 1, mu, &start, NULL, 0);
    const struct solution *first = &branch.point[0].solution,
                          *last = &branch.point[branch.count - 1].solution;
    relative(first->period, 6.6632868593231302, 1e-12);
    relative(first->value[0].re, 8.596950636e-4, 1e-9);
    close_to(last->param[0], mu, 0);
    close_to(last->period,
             (3 - 2 * log(2)) * mu + 3 * 2.338107410459767 / cbrt(mu) -
                 (2 * log(mu) / 3 + 1.3233) / mu,
             3 / mu);
    branch_free(&branch);
}

/* The drive's period as expressions show it. */
static void test_drive_period(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        double period;
    } cases[] = {{"v' = -x", 0},
                 {"v' = -x+w*cos(w*t+1)", TWO_PI / 2},
                 {"v' = -x*(1+sin(w*t)^2)+cos(3*t)", TWO_PI},
                 {"v' = -x+sin(t)*sin(sqrt(2)*t)", NAN},
                 {"v' = -x+t", NAN},
                 {"v' = -x+mod(t, 3)+0*t", 3},
                 {"v' = -x+cos(x*t)", NAN}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct scene scene =
            TYPED("var x = 0.1", "var v = 0.1", "param w = 2", "x' = v", cases[i].line);
        struct system system;
        struct error error = {0};
        assert_true(scene_bind(&scene, &system, &error));
        const double period = system_drive(&system);
        if (isnan(cases[i].period) ? !isnan(period) : fabs(period - cases[i].period) > 1e-12)
            fail_msg("%s: %g", cases[i].line, period);
    }
}

/* K(m) = pi/(2 agm(1, sqrt(1 - m))) */
static double elliptic(double m)
{
    double a = 1, b = sqrt(1 - m);
    for (int i = 0; i < 8; i++) {
        const double mean = (a + b) / 2;
        b = sqrt(a * b);
        a = mean;
    }
    return PI / (2 * a);
}

/* The member of a family with a period far from that of the start: its amplitude is known. */
static void test_families(void **state)
{
    (void)state;
    const struct scene pendulum = TYPED("var x = 1", "var v = 0", "x' = v", "v' = -sin(x)"),
                       duffing = TYPED("var x = 1", "var v = 0", "x' = v", "v' = -x-x^3");
    static const double amplitude[] = {0.01, 0.3, 2, 3};
    for (size_t i = 0; i < 2 * COUNT_OF(amplitude); i++) {
        const bool hard = i >= COUNT_OF(amplitude);
        const double a = amplitude[i % COUNT_OF(amplitude)] * (hard ? 3 : 1), w = sqrt(1 + a * a),
                     period = hard ? 4 * elliptic(a * a / (2 * w * w)) / w
                                   : 4 * elliptic(sin(a / 2) * sin(a / 2));
        const struct orbit_request request = {.scene = hard ? &duffing : &pendulum,
                                              .state = {1, 0},
                                              .period = period,
                                              .span = 20,
                                              .settles = true};
        struct found_orbit found;
        struct error error = {0};
        if (!orbit_find(&request, &found, &error))
            fail_msg("%s: %s", hard ? "Duffing" : "pendulum", error.text);
        assert_true(found.family);
        relative(found.solution.period, period, 1e-13);
        relative(found.solution.top[0], a, 1e-6 * fmin(1, 1e-3 / (a * a)) + 1e-8);
        orbit_free(&found);
    }
}

struct told {
    int count, stop; /* cancels there; 0: never */
    double least, last;
    struct cancel cancel;
};

static void listen(void *context, double fraction)
{
    struct told *told = context;
    told->least = fmin(told->least, fraction - told->last);
    told->last = fraction;
    if (++told->count == told->stop)
        atomic_store(&told->cancel.requested, 1);
}

/* What lasts says how far it is; a branch that is stopped has its points, the last with a label. */
static void test_progress(void **state)
{
    (void)state;
    const struct scene scene =
        TYPED("var x = 2", "var y = 0", "param mm = 1", "x' = y", "y' = mm*(1-x^2)*y-x");
    const struct solution start = {
        .kind = SOLUTION_ORBIT, .n = 2, .param = {1}, .period = 6.66, .state = {2, 0}};
    struct error error = {0};
    for (int stop = 0; stop <= 8; stop += 8) {
        struct told told = {.stop = stop};
        const struct branch_request request = {.scene = &scene,
                                               .param = scene_param(&scene, "mm"),
                                               .low = 0.5,
                                               .high = 2,
                                               .start = &start,
                                               .cancel = &told.cancel,
                                               .progress = listen,
                                               .context = &told};
        struct branch branch;
        assert_true(branch_follow(&request, &branch, &error));
        branch_verify(&request, &branch);
        assert_true(told.least >= 0 && told.last <= 1 && told.count >= 8);
        assert_int_equal(branch.cancelled, stop > 0);
        assert_true(special(&branch, SPECIAL_END, 1) != NULL);
        if (stop > 0)
            assert_true(branch.count == stop && special(&branch, SPECIAL_END, 1) == branch.point);
        branch_free(&branch);
    }
    struct told orbit = {.stop = 0}, rests = {.stop = 0};
    const struct orbit_request request = {.scene = &scene,
                                          .state = {2, 0},
                                          .span = 20,
                                          .settles = true,
                                          .progress = listen,
                                          .context = &orbit};
    struct found_orbit found;
    assert_true(orbit_find(&request, &found, &error));
    assert_true(orbit.count > 0 && orbit.last == 0);
    orbit_free(&found);
    const struct scene many =
        TYPED("var x = 1", "var v = 0", "x' = sin(3*v)-x*v^3", "v' = cos(x*v)");
    const struct equilibria_request box = {
        .scene = &many, .box = {{-9, 9}, {-9, 9}}, .progress = listen, .context = &rests};
    struct equilibria equilibria;
    assert_true(equilibria_find(&box, &equilibria, &error));
    assert_true(rests.count > 3 && rests.least >= 0 && rests.last > 0.5 && rests.last <= 1);
    equilibria_free(&equilibria);
}

static struct cancel stopped;

static void on_alarm(int number)
{
    (void)number;
    atomic_store(&stopped.requested, 1);
}

/* Whatever it was at: the end is a label to go on from, and nothing is said of the motion there. */
static void test_stopped_anywhere(void **state)
{
    (void)state;
    const struct scene scene =
        TYPED("var x = 2", "var y = 0", "param mm = 1", "x' = y", "y' = mm*(1-x^2)*y-x");
    const struct solution start = {
        .kind = SOLUTION_ORBIT, .n = 2, .param = {1}, .period = 6.66, .state = {2, 0}};
    const struct branch_request request = {.scene = &scene,
                                           .param = scene_param(&scene, "mm"),
                                           .low = 0.5,
                                           .high = 2,
                                           .start = &start,
                                           .cancel = &stopped};
    uint64_t random = 5;
    double whole = 0;
    void (*before)(int) = signal(SIGALRM, on_alarm);
    for (int i = 0; i <= 60; i++) {
        struct branch branch;
        struct error error = {0};
        const double after = whole * random_fraction(&random); /* [s] */
        const struct itimerval moment = {.it_value = {.tv_usec = (long)(1e6 * after)}}, none = {0};
        atomic_store(&stopped.requested, 0);
        setitimer(ITIMER_REAL, &moment, NULL); /* the first is not stopped */
        const bool followed = branch_follow(&request, &branch, &error);
        setitimer(ITIMER_REAL, &none, NULL);
        if (!followed) {
            assert_int_equal(error.code, ERROR_CANCELLED);
            continue;
        }
        whole = i == 0 ? branch.seconds : whole;
        for (int side = 0; side < 2; side++) {
            const char *why = branch.ends[side];
            if (*why && strcmp(why, "cancelled") != 0 && strcmp(why, "end of the range") != 0)
                fail_msg("after %.4f of %.4f s: '%s'", after, whole, why);
            if (*why)
                assert_true(branch.point[side * (branch.count - 1)].special != SPECIAL_NONE);
        }
        branch_free(&branch);
    }
    signal(SIGALRM, before);
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lorenz_equilibria), cmocka_unit_test(test_lorenz_orbits),
        cmocka_unit_test(test_doublings),         cmocka_unit_test(test_response),
        cmocka_unit_test(test_relaxation),        cmocka_unit_test(test_drive_period),
        cmocka_unit_test(test_families),          cmocka_unit_test(test_progress),
        cmocka_unit_test(test_stopped_anywhere)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
