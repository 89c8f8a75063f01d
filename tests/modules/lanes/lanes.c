/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Many trajectories side by side: to the bit what each would do alone, for every method and kind
 * that there is. */
#include "cmocka_testing.h"

#include <hooke/base/catalog.h>
#include <hooke/method.h>
#include "long_form.h"
#include "modules/lanes/lanes.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 150
#define H 0.0123

enum { SHARED_CLOCK, OWN_STEP, OWN_CLOCK, CLOCKS }; /* the last: another t0, too */

static double lane_step(int clock, int lane)
{
    return clock == SHARED_CLOCK ? H : H * (1 + 0.0037 * lane);
}

/* Each lane another oscillator of the same kind. `alike`: driven by the same force. */
static void lane_scene(unsigned which, int lane, bool alike, int clock, struct system *system)
{
    static const struct {
        const char *name;
        double value;
    } terms[] = {{"gamma", 0.3}, {"C", 2},     {"k3", 200},   {"F0", 0.1},
                 {"mu", 2},      {"omega", 7}, {"phase", 0.4}};
    struct scene scene;
    struct error error = {0};
    scene_init(&scene, NULL);
    for (size_t i = 0; i < COUNT_OF(terms); i++) {
        const bool time = i >= 5;
        const double value = terms[i].value * (time && alike ? 1 : 1 + 0.01 * lane);
        if (time || which & 1u << i)
            assert_true(scene_set(&scene, scene_param(&scene, terms[i].name),
                                  (struct measured){value, 0}, &error));
    }
    assert_true(
        scene_set(&scene, scene_param(&scene, "k"), (struct measured){15 + 0.3 * lane, 0}, &error));
    assert_true(scene_set(&scene, scene_param(&scene, "y0"),
                          (struct measured){0.05 - 0.002 * lane, 0}, &error));
    const double t0 = clock == OWN_CLOCK ? 0.7 - 0.03 * lane : 0.7;
    assert_true(scene_set(&scene, scene_param(&scene, "t0"), (struct measured){t0, 0}, &error));
    assert_true(scene_bind(&scene, system, &error));
}

static struct system systems[LANE_COUNT];
static double rows[STEPS][2][LANE_COUNT];

/* False: this method and these forces do not go in lanes. */
static bool compare(struct lanes *lanes, const struct method *method, unsigned which,
                    enum drag drag, bool alike, int clock)
{
    struct error error;
    for (int lane = 0; lane < LANE_COUNT; lane++)
        lane_scene(which, lane, alike, clock, &systems[lane]);
    if (!method_applies(method, &systems[0], &drag, &error))
        return false;
    if (!lanes_fit(method, &systems[0], drag, H))
        return false;
    assert_true(lanes_begin(lanes, method, drag, &systems[0], H));
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        assert_true(lanes_alike(&systems[0], &systems[lane]));
        lanes_set_step(lanes, lane, &systems[lane], lane_step(clock, lane));
    }
    /* In pieces, some of them without rows. */
    for (int64_t done = 0, piece = 1; done < STEPS; done += piece, piece = piece * 5 % 43) {
        piece = piece < STEPS - done ? piece : STEPS - done;
        memset(rows[done], 0, (size_t)piece * sizeof rows[0]);
        lanes_march(lanes, piece, piece % 2 ? &rows[done][0][0] : NULL);
        for (int lane = 0; lane < LANE_COUNT && piece % 2 == 0; lane++) {
            double y[2];
            lanes_state(lanes, lane, y);
            rows[done + piece - 1][0][lane] = y[0];
            rows[done + piece - 1][1][lane] = y[1];
        }
    }
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        double work[64], y[2] = {systems[lane].start[0], systems[lane].start[1]}, row[STEPS][2];
        struct step step = {.system = &systems[lane],
                            .drag = drag,
                            .h = lane_step(clock, lane),
                            .y = y,
                            .work = work};
        const struct march march = {&step, systems[lane].t0, 0, STEPS, &row[0][0]};
        enum step_status status;
        assert_true(method_work_size(method, 2) <= COUNT_OF(work));
        const int64_t taken = method_turning_march(method, NULL, &march, &status);
        for (int i = 0; i < taken; i++) {
            const bool written = rows[i][0][0] != 0 || rows[i][1][0] != 0;
            if (written && (memcmp(&rows[i][0][lane], &row[i][0], sizeof(double)) != 0 ||
                            memcmp(&rows[i][1][lane], &row[i][1], sizeof(double)) != 0))
                fail_msg("%s, forces %u, lane %d, step %d: %.17g, %.17g side by side, %.17g, %.17g "
                         "alone",
                         method->row.name, which, lane, i, rows[i][0][lane], rows[i][1][lane],
                         row[i][0], row[i][1]);
        }
        if (taken == STEPS)
            assert_int_equal(lanes_evals(lanes, lane), step.cost.evals);
    }
    return true;
}

TEST(test_lanes_give_the_same_bits)
{
    struct lanes *lanes = lanes_create();
    assert_non_null(lanes);
    int compared = 0;
    for (unsigned which = 0; which < 32; which++)
        for (size_t m = 0; m < method_catalog.count; m++)
            for (enum drag drag = DRAG_DEFAULT; drag < DRAG_COUNT; drag++)
                for (int alike = 0;
                     alike < (which & 8 ? 2 : 1) && (is_long() || (which + m) % 3 == 0); alike++)
                    for (int clock = 0; clock < (is_long() || (which + m) % 9 == 0 ? CLOCKS : 1);
                         clock++) {
                        compared += compare(lanes, method_at(m), which, drag, alike, clock);
                    }
    print_message("# %d combinations of method, drag and forces\n", compared);
    assert_true(compared > (is_long() ? 450 : 150));
    lanes_destroy(lanes);
}

/* ---- extremes ---- */

static uint64_t drawn_state = 5;

static double drawn(void)
{
    drawn_state = drawn_state * 0x5851F42D4C957F2D + 0x14057B7EF767814F;
    return (double)(drawn_state >> 11) * 0x1p-53;
}

/* 10^from … 10^to; at times 0, at times of the other sign where that may be */
static double drawn_size(double from, double to, double negative)
{
    const double size = pow(10, from + (to - from) * drawn());
    return drawn() < 0.05 ? 0 : drawn() < negative ? -size : size;
}

/* Forces up to what no number holds, of an oscillator or a pendulum. */
static bool wild_scene(const struct scene *of, unsigned which, double reach, struct system *system)
{
    static const struct {
        const char *name;
        double from, to, negative; /* powers of ten; share of those below 0 */
    } terms[] = {{"gamma", -3, 2, 0.1}, {"C", 0, 4, 0},        {"k3", 0, 4, 0.2},
                 {"F0", -2, 1, 0.2},    {"mu", -2, 2, 0.3},    {"omega", -1, 3, 0},
                 {"phase", -2, 1, 0.5}, {"k", -1, 3, 0.1},     {"y0", -3, 1, 0.5},
                 {"v0", -3, 1, 0.5},    {"theta0", -2, 2, 0.5}};
    struct scene scene = *of;
    struct error error = {0};
    for (size_t i = 0; i < COUNT_OF(terms); i++) {
        const int param = scene_param(&scene, terms[i].name);
        if (param < 0 || (i < 5 && !(which & 1u << i)))
            continue;
        double value = drawn_size(terms[i].from, terms[i].to + reach, terms[i].negative);
        value = value == 0 && (i < 5 || i == 7) ? 0.1 : value; /* all have the same forces */
        if (!scene_set(&scene, param, (struct measured){value, 0}, &error))
            scene_set(&scene, param, (struct measured){fabs(value), 0}, &error);
    }
    return scene_bind(&scene, system, &error);
}

static bool same_state(const double *a, const double *b)
{
    return memcmp(a, b, 2 * sizeof *a) == 0;
}

/* False: they do not go in lanes. */
static bool compare_wild(struct lanes *lanes, const struct method *method, enum drag drag, double h,
                         int64_t *failed)
{
    struct error error;
    if (!method_applies(method, &systems[0], &drag, &error))
        return false;
    for (int lane = 0; lane < LANE_COUNT; lane++)
        if (!lanes_fit(method, &systems[lane], drag, h) ||
            !method_fits(method, &systems[lane], drag, h, &error) ||
            !lanes_alike(&systems[0], &systems[lane]))
            return false;
    assert_true(lanes_begin(lanes, method, drag, &systems[0], h));
    for (int lane = 0; lane < LANE_COUNT; lane++)
        lanes_set(lanes, lane, &systems[lane]);
    lanes_march(lanes, STEPS, &rows[0][0][0]);
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        double work[64], y[2] = {systems[lane].start[0], systems[lane].start[1]}, row[STEPS][2];
        struct step step = {.system = &systems[lane], .drag = drag, .h = h, .y = y, .work = work};
        const struct march march = {&step, systems[lane].t0, 0, STEPS, &row[0][0]};
        enum step_status status;
        assert_true(method_work_size(method, 2) <= COUNT_OF(work));
        const int64_t done = method_turning_march(method, NULL, &march, &status);
        for (int i = 0; i < done; i++) {
            const double here[2] = {rows[i][0][lane], rows[i][1][lane]};
            if (!same_state(here, row[i]))
                fail_msg("%s, lane %d, step %d of %.17g s: %.17g, %.17g side by side, %.17g, "
                         "%.17g alone",
                         method->row.name, lane, i, h, here[0], here[1], row[i][0], row[i][1]);
        }
        double end[2];
        lanes_state(lanes, lane, end);
        if (done < STEPS && isfinite(end[0]) && isfinite(end[1]))
            fail_msg("%s, lane %d, steps of %.17g s: %.17g, %.17g after step %d failed alone",
                     method->row.name, lane, h, end[0], end[1], (int)done);
        if (done == STEPS)
            assert_int_equal(lanes_evals(lanes, lane), step.cost.evals);
        *failed += done < STEPS;
    }
    return true;
}

/* Steps that are far too long, forces that overflow, equations without a solution: the same bits
 * for as long as there are numbers, and none afterwards. */
TEST(test_extremes_give_the_same_bits)
{
    static const char *const methods[] = {
        "implicit-midpoint", "backward-euler", "trapezoid", "sdirk2", "tr-bdf2", "rk4", "dopri5",
        "symplectic-euler",  "verlet",         "pefrl"};
    const struct preset *pendulum = preset_by_name(text_of("pendulum"));
    struct lanes *lanes = lanes_create();
    int compared = 0;
    int64_t failed = 0;
    assert_true(lanes && pendulum);
    for (int trial = 0; trial < (is_long() ? 1500 : 150); trial++) {
        const struct row *row =
            catalog_find(&method_catalog, text_of(methods[trial % (int)COUNT_OF(methods)]));
        static const unsigned forces[] = {1 | 8, 0, 1, 2, 1 | 2, 4, 1 | 8 | 4, 16};
        const bool rod = trial % 7 == 0;
        const unsigned which = forces[(int)(drawn() * (rod ? 2 : COUNT_OF(forces)))];
        const double h = pow(10, -3 + 3.5 * drawn()), reach = trial % 4 == 0   ? 60
                                                              : trial % 4 == 1 ? 4
                                                                               : 0;
        struct scene scene;
        scene_init(&scene, rod ? pendulum : NULL);
        for (int lane = 0; lane < LANE_COUNT; lane++)
            while (!wild_scene(&scene, which, reach, &systems[lane])) {
            }
        assert_non_null(row);
        compared += compare_wild(lanes, method_from(row),
                                 trial % 5 == 0 ? DRAG_EXPLICIT : DRAG_DEFAULT, h, &failed);
    }
    print_message("# %d blocks of lanes, %lld lanes whose run ends early\n", compared,
                  (long long)failed);
    assert_true(compared > 80 && failed > 1000);
    lanes_destroy(lanes);
}

/* ---- steps whose size follows the error ---- */

enum { ATTEMPTS = 4000 };
static double attempts[ATTEMPTS][3][LANE_COUNT];

/* By single steps from a fresh controller: to the same end through the same states. */
static void compare_adapted(const struct lanes *lanes, const struct method *method, int lane,
                            double tol, double t_end, int rows_there)
{
    double work[64], y[2] = {systems[lane].start[0], systems[lane].start[1]};
    struct step step = {.system = &systems[lane], .t = systems[lane].t0, .y = y, .work = work};
    struct controller controller = {.tol = tol, .h = H};
    int64_t steps = 0, done, evals;
    double was[3] = {0};
    int row = 0;
    assert_true(method_work_size(method, 2) <= COUNT_OF(work));
    assert_true(lanes_adapted(lanes, lane, &done, &evals));
    while (step.t != t_end) {
        assert_int_equal(method_adapt(method, &step, &controller, t_end), STEP_OK);
        steps++;
        /* as in a run: so near is there */
        if (fabs(step.t - t_end) <= 4 * DBL_EPSILON * fmax(fabs(step.t), fabs(t_end)))
            step.t = t_end;
        /* rejected attempts leave everything as it was; a step below the rounding of t leaves t */
        const double now[3] = {step.t, y[0], y[1]};
        while (steps > 1 && memcmp(now, was, sizeof now) != 0 && row < rows_there - 1 &&
               attempts[row][0][lane] == was[0] && attempts[row][1][lane] == was[1] &&
               attempts[row][2][lane] == was[2])
            row++;
        memcpy(was, now, sizeof was);
        const double here[2] = {attempts[row][1][lane], attempts[row][2][lane]};
        if (!same_state(here, y) || attempts[row][0][lane] != step.t)
            fail_msg("%s tol %g, lane %d, step %lld: t = %.17g: %.17g, %.17g side by side, "
                     "%.17g: %.17g, %.17g alone",
                     method->row.name, tol, lane, (long long)steps, attempts[row][0][lane], here[0],
                     here[1], step.t, y[0], y[1]);
    }
    assert_int_equal(done, steps);
    assert_int_equal(evals, step.cost.evals);
}

static bool adapts(const struct method *method)
{
    struct error error;
    enum drag drag = DRAG_DEFAULT;
    bool fit = method_applies(method, &systems[0], &drag, &error);
    for (int lane = 0; lane < LANE_COUNT && fit; lane++)
        fit = lanes_adapt_fit(method, &systems[lane], drag, H) &&
              lanes_alike(&systems[0], &systems[lane]);
    return fit;
}

/* Forces of all sizes, tolerances, stretches of time; the lanes that do not get there are those
 * whose single steps do not either, or are left out for steps that creep. */
TEST(test_adaptive_lanes_give_the_same_bits)
{
    static const char *const methods[] = {"dopri5", "bogacki-shampine", "tsit5",
                                          "dop853", "rodas5p",          "rodas4"};
    const struct preset *pendulum = preset_by_name(text_of("pendulum"));
    struct lanes *lanes = lanes_create();
    int64_t compared = 0, left = 0;
    assert_true(lanes && pendulum);
    for (int trial = 0; trial < (is_long() ? 1500 : 60); trial++) {
        static const unsigned forces[] = {1 | 8, 0, 1, 2, 1 | 2, 4, 1 | 8 | 4, 16};
        const struct method *method =
            method_by_name(text_of(methods[trial % (int)COUNT_OF(methods)]));
        const bool rod = trial % 7 == 0;
        const unsigned which = forces[(int)(drawn() * (rod ? 2 : COUNT_OF(forces)))];
        const double tol = pow(10, -11 + 9 * drawn()), reach = trial % 9 == 8 ? 60 : 0;
        const int used = trial % 3 == 0 ? LANE_COUNT : 1 + (int)(drawn() * LANE_COUNT);
        struct scene scene;
        scene_init(&scene, rod ? pendulum : NULL);
        for (int lane = 0; lane < LANE_COUNT; lane++)
            while (!wild_scene(&scene, which, reach, &systems[lane])) {
            }
        assert_non_null(method);
        if (!adapts(method))
            continue;
        assert_true(lanes_begin(lanes, method, DRAG_DEFAULT, &systems[0], H));
        for (int lane = 0; lane < LANE_COUNT; lane++)
            lanes_set(lanes, lane, &systems[lane]);
        const double t_end = systems[0].t0 + pow(10, -1 + 1.5 * drawn());
        double tols[LANE_COUNT];
        for (int lane = 0; lane < LANE_COUNT; lane++)
            tols[lane] = trial % 5 == 0 ? tol * (1 + lane) : tol;
        lanes_control(lanes, used, tols, t_end, trial % 2 ? 1e-6 : 0);
        lanes_adapted_row(lanes, &attempts[0][0][0]);
        int there = 1;
        bool more = true;
        for (int piece = 1; more && there < ATTEMPTS; piece = piece * 5 % 43) {
            piece = piece < ATTEMPTS - there ? piece : ATTEMPTS - there;
            more = lanes_adapt(lanes, piece, &attempts[there][0][0]);
            there += piece;
        }
        for (int lane = 0; lane < used; lane++) {
            int64_t steps, evals;
            const bool done = lanes_adapted(lanes, lane, &steps, &evals);
            left += !done;
            compared += done;
            if (done)
                compare_adapted(lanes, method, lane, tols[lane], t_end, there);
        }
    }
    print_message("# %lld lanes, %lld more not to their end\n", (long long)compared,
                  (long long)left);
    assert_true(compared > 1000);
    lanes_destroy(lanes);
}

/* What must go alone does. */
TEST(test_lanes_refuse)
{
    const struct {
        const char *method;
        unsigned which;
        double h;
    } cases[] = {{"verlet", 1, -H}, {"gauss4", 0, H}, {"ab2", 0, H}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct row *row = catalog_find(&method_catalog, text_of(cases[i].method));
        struct system system;
        enum drag drag = DRAG_DEFAULT;
        struct error error;
        if (!row)
            continue;
        lane_scene(cases[i].which, 0, true, SHARED_CLOCK, &system);
        assert_true(method_applies(method_from(row), &system, &drag, &error));
        assert_false(lanes_fit(method_from(row), &system, drag, cases[i].h));
    }
}

RUN_TESTS(NULL, NULL)
