/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Times of a busy machine: precision with two and with eight busy processes beside it against the
 * same without them. What is not marked is right, and the fastest methods are the same. */
#include "cmocka_testing.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "modules/solving/compute/solve.h"

#include "modules/comparison/compute/verify.h"
#include "long_form.h"

/* How far a time may be off that was measured alone. */
static const double time_off_alone = 1.3;

/* Up to which ratio of their times two methods may change places, where the first was alone. */
static const double rank_off_alone = 1.3;

static const char *const names[] = {"euler",  "symplectic-euler", "verlet", "rk4",
                                    "pefrl",  "blanes-moan6",     "heun",   "midpoint",
                                    "dopri5", "dop853",           "tsit5",  "trapezoid"};

enum { METHODS = COUNT_OF(names), LOOPS_MAX = 8 };

static void study(struct scene *scene, struct precision *precision)
{
    struct method_choice choice[METHODS];
    struct error error = {0};
    for (int i = 0; i < METHODS; i++) {
        choice[i] = (struct method_choice){method_find(names[i]), DRAG_DEFAULT};
        assert_non_null(choice[i].method);
    }
    const struct precision_request request = {.scene = scene,
                                              .choice = choice,
                                              .choices = METHODS,
                                              .dt = {NAN, NAN},
                                              .tol = {NAN, NAN},
                                              .duration = 2,
                                              .timing = TIMING_QUICK};
    if (!study_precision(&request, precision, &error))
        fail_msg("%s", error.text);
}

static void begin_loops(pid_t *loop, int count)
{
    for (int i = 0; i < count; i++) {
        loop[i] = fork();
        assert_true(loop[i] >= 0);
        if (loop[i] == 0) {
            alarm(120);
            for (volatile unsigned n = 0;; n++) {
            }
        }
    }
}

static void end_loops(const pid_t *loop, int count)
{
    for (int i = 0; i < count; i++) {
        kill(loop[i], SIGKILL);
        waitpid(loop[i], NULL, 0);
    }
}

/* Returns by how much the method that `busy` takes for the fastest (or the best that ties with it)
 * is slower on the quiet machine than the fastest of those that both rank, for an error. */
static double rank_loss(const struct precision *quiet, const struct precision *busy, double error)
{
    struct precision_cost taken[METHODS], cost;
    double least = HUGE_VAL, fastest = HUGE_VAL;
    const int others = precision_fastest(busy, error, taken, NULL);
    for (int i = 0; i < others; i++) {
        if (!taken[i].timed || !precision_cost_at(quiet, taken[i].curve, error, &cost) ||
            !cost.timed)
            continue;
        fastest = fmin(fastest, cost.minimum);
        if (i == 0 || taken[i].tied)
            least = fmin(least, cost.minimum);
    }
    return isfinite(least) ? least / fastest : 1;
}

/* Returns by how much a time may be off: one measured beside others is said to be as far off as
 * they make it. */
static double time_off(const struct timing_result *time)
{
    return time->others <= TIMING_OTHERS ? time_off_alone : TIMING_CONTENTION;
}

/* Returns the number of sound times that are further off than they may be. */
static int compare_times(const struct precision *quiet, const struct precision *busy, int *compared)
{
    int wrong = 0;
    for (int i = 0; i < quiet->points && i < busy->points; i++) {
        const struct precision_point *a = &quiet->point[i], *b = &busy->point[i];
        if (a->curve != b->curve || a->steps != b->steps || !timing_is_sound(&a->time) ||
            !timing_is_sound(&b->time))
            continue;
        const double ratio = b->time.minimum / a->time.minimum,
                     off = fmax(time_off(&a->time), time_off(&b->time));
        ++*compared;
        if (ratio > off || ratio < 1 / off) {
            print_message("%s, %lld steps: %.3g of the quiet time, spread %.2g\n",
                          quiet->curve[a->curve].choice.method->row.name, (long long)a->steps,
                          ratio, b->time.spread);
            wrong++;
        }
    }
    return wrong;
}

TEST(test_busy)
{
    struct scene scene;
    struct precision quiet;
    int wrong = 0, compared = 0, misranked = 0;
    scene_init(&scene, NULL);
    study(&scene, &quiet);
    /* the tests may themselves run beside others */
    const double rank_off = quiet.point[quiet.points - 1].time.others > TIMING_OTHERS
                                ? TIMING_CONTENTION
                                : rank_off_alone;
    for (int round = 0; round < (is_long() ? 10 : 1); round++)
        for (int loops = 2; loops <= LOOPS_MAX; loops *= 4) {
            pid_t loop[LOOPS_MAX];
            struct precision busy;
            begin_loops(loop, loops);
            study(&scene, &busy);
            end_loops(loop, loops);
            wrong += compare_times(&quiet, &busy, &compared);
            for (double error = 1e-2; error > 1e-9; error /= 10) {
                const double loss = rank_loss(&quiet, &busy, error);
                if (loss > rank_off)
                    print_message("error %g, %d loops: %.3g times the fastest\n", error, loops,
                                  loss);
                misranked += loss > rank_off;
            }
            precision_free(&busy);
        }
    precision_free(&quiet);
    print_message("%d times compared, %d off, %d wrong winners\n", compared, wrong, misranked);
    assert_int_equal(wrong, 0);
    assert_int_equal(misranked, 0);
}

/* Three samples whose two shortest agree are sound, and nothing else is. */
TEST(test_sound_times)
{
    const struct timing_result one = {.minimum = 1, .samples = 1},
                               apart = {.minimum = 1, .samples = 5, .spread = 0.2},
                               sound = {.minimum = 1, .samples = 3, .spread = 0.01},
                               none = {.minimum = NAN, .samples = 0};
    assert_false(timing_is_sound(&one));
    assert_false(timing_is_sound(&apart));
    assert_true(timing_is_sound(&sound));
    assert_false(timing_is_sound(&none));
}

RUN_TESTS(NULL, NULL)
