/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Many trajectories side by side: to the bit what each would do alone, for every method and kind
 * that there is. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <hooke/method.h>
#include "long_form.h"
#include <string.h>

#define STEPS 150
#define H 0.0123

/* Each lane another oscillator of the same kind. `alike`: driven by the same force. */
static void lane_scene(unsigned which, int lane, bool alike, struct system *system)
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
    assert_true(scene_set(&scene, scene_param(&scene, "t0"), (struct measured){0.7, 0}, &error));
    assert_true(scene_bind(&scene, system, &error));
}

static struct system systems[LANES];
static double rows[STEPS][2][LANES];

/* False: this method and these forces do not go in lanes. */
static bool compare(struct lanes *lanes, const struct method *method, unsigned which,
                    enum drag drag, bool alike)
{
    struct error error;
    for (int lane = 0; lane < LANES; lane++)
        lane_scene(which, lane, alike, &systems[lane]);
    if (!method_applies(method, &systems[0], &drag, &error))
        return false;
    if (!lanes_fit(method, &systems[0], drag, H))
        return false;
    assert_true(lanes_begin(lanes, method, drag, &systems[0], H));
    for (int lane = 0; lane < LANES; lane++) {
        assert_true(lanes_alike(&systems[0], &systems[lane]));
        lanes_set(lanes, lane, &systems[lane]);
    }
    /* In pieces, some of them without rows. */
    int64_t evals[LANES];
    for (int64_t done = 0, piece = 1; done < STEPS; done += piece, piece = piece * 5 % 43) {
        piece = piece < STEPS - done ? piece : STEPS - done;
        memset(rows[done], 0, (size_t)piece * sizeof rows[0]);
        lanes_march(lanes, piece, piece % 2 ? &rows[done][0][0] : NULL);
        for (int lane = 0; lane < LANES && piece % 2 == 0; lane++) {
            double y[2];
            lanes_state(lanes, lane, y);
            rows[done + piece - 1][0][lane] = y[0];
            rows[done + piece - 1][1][lane] = y[1];
        }
    }
    for (int lane = 0; lane < LANES; lane++) {
        double work[64], y[2] = {systems[lane].start[0], systems[lane].start[1]}, row[STEPS][2];
        struct step step = {.system = &systems[lane], .drag = drag, .h = H, .y = y, .work = work};
        const struct march march = {&step, systems[lane].t0, 0, STEPS, &row[0][0]};
        enum step_status status;
        assert_true(method_work_size(method, 2) <= COUNT_OF(work));
        assert_int_equal(method_turning_march(method, NULL, &march, &status), STEPS);
        evals[lane] = step.cost.evals;
        for (int i = 0; i < STEPS; i++) {
            const bool written = rows[i][0][0] != 0 || rows[i][1][0] != 0;
            if (written && (memcmp(&rows[i][0][lane], &row[i][0], sizeof(double)) != 0 ||
                            memcmp(&rows[i][1][lane], &row[i][1], sizeof(double)) != 0))
                fail_msg("%s, forces %u, lane %d, step %d: %.17g, %.17g side by side, %.17g, %.17g "
                         "alone",
                         method->row.name, which, lane, i, rows[i][0][lane], rows[i][1][lane],
                         row[i][0], row[i][1]);
        }
        assert_int_equal(lanes_evals(lanes, lane), evals[lane]);
    }
    return true;
}

static void test_lanes_give_the_same_bits(void **state)
{
    (void)state;
    struct lanes *lanes = lanes_create();
    assert_non_null(lanes);
    int compared = 0;
    for (unsigned which = 0; which < 32; which++)
        for (size_t m = 0; m < method_catalog.count; m++)
            for (enum drag drag = DRAG_DEFAULT; drag < DRAG_COUNT; drag++)
                for (int alike = 0;
                     alike < (which & 8 ? 2 : 1) && (is_long() || (which + m) % 3 == 0); alike++)
                    compared += compare(
                        lanes, (const struct method *)(const void *)catalog_row(&method_catalog, m),
                        which, drag, alike);
    print_message("# %d combinations of method, drag and forces\n", compared);
    assert_true(compared > (is_long() ? 150 : 100));
    lanes_destroy(lanes);
}

/* What must go alone does. */
static void test_lanes_refuse(void **state)
{
    (void)state;
    const struct {
        const char *method;
        unsigned which;
        double h;
    } cases[] = {{"verlet", 1, -H}, {"gauss4", 0, H}, {"ab2", 0, H}, {"rk4", 16 | 8, H}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct row *row = catalog_find(&method_catalog, text_of(cases[i].method));
        struct system system;
        enum drag drag = DRAG_DEFAULT;
        struct error error;
        if (!row)
            continue;
        lane_scene(cases[i].which, 0, true, &system);
        assert_true(
            method_applies((const struct method *)(const void *)row, &system, &drag, &error));
        assert_false(
            lanes_fit((const struct method *)(const void *)row, &system, drag, cases[i].h));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lanes_give_the_same_bits),
        cmocka_unit_test(test_lanes_refuse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
