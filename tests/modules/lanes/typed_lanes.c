/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed scenes side by side: to the bit what each trajectory would do alone, for every method and
 * kind of scene. */
#include <hooke/base/catalog.h>
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/scene/typing.h"
#include "modules/lanes/lanes.h"

#include <stdlib.h>

enum { STEPS = 60, WORK = 4096 };
#define H 0.0123

/* Lines between semicolons, on top of the preset; the parameters named are other ones in each lane.
 */
struct typed_case {
    const char *name, *preset, *lines, *varied;
};

static const struct typed_case cases[] = {
    {"one equation", NULL, "var x = 1;param a = 2;x' = -a*x + sin(x)", "x0 a"},
    {"time", NULL, "var x = 1;param w = 3;param q = 0.5;x' = cos(w*t) - q*x^3 + exp(-t)", "x0 q"},
    {"another time in each", NULL, "var x = 1;param w = 3;x' = cos(w*t) - x", "w"},
    {"Lotka and Volterra", NULL, "var u = 2;var w = 1;param a = 1.5;u' = a*u - u*w;w' = u*w - w",
     "a w0"},
    {"Lorenz", NULL,
     "var x = 1;var y = 1;var z = 20;param r = 28;param s = 10;x' = s*(y - x);y' = x*(r - z) - "
     "y;z' = x*y - 8/3*z",
     "r x0"},
    {"spring", NULL, "var y = 0.5;param k = 40;y'' = -k*y", "k y0"},
    {"damped", NULL, "var y = 0.5;param k = 40;param g = 1;y'' = -k*y - g*y'", "g y0"},
    {"drag", NULL, "var y = 0.5;param k = 40;param c = 3;y'' = -k*y - c*y'*abs(y')", "c y0"},
    {"driven drag", NULL,
     "var y = 0.5;param k = 40;param c = 3;y'' = -k*y - c*y'*abs(y') + 3*cos(9*t)", "k y0"},
    {"friction", NULL, "var y = 0.5;param k = 40;param c = 0.5;y'' = -k*y - c*sign(y')", "c y0"},
    {"driven pendulum", NULL, "var th = 1;param f = 0.6;th'' = -9*sin(th) - 0.2*th' + f*cos(2*t)",
     "f th0"},
    {"Kepler", NULL,
     "var x = 1;var y = 0;var y' = 1;param g = 1;observe r = hypot(x, y);x'' = -g*x/r^3;y'' = "
     "-g*y/r^3",
     "g vy0"},
    {"chain", NULL,
     "var a = 1;var b = 0;var c = 0;var d = 0;param k = 20;param g = 0.3;a'' = k*(b - 2*a) - g*a';"
     "b'' = k*(a + c - 2*b);c'' = k*(b + d - 2*c) + sin(t);d'' = k*(c - 2*d) - g*d'^3",
     "k a0 vd0"},
    {"mixed orders", NULL, "var x = 1;var q = 0.2;param a = 3;x'' = -a*x + q;q' = -q*x", "a q0"},
    {"a variable as it stands", NULL, "var x = 1;var v = 0;param a = 3;x' = v;v' = 2 - a*x", "a"},
    {"repeated", NULL, "var x = 1;var y = 2;param a = 3;x' = a*x*y - 1;y' = a*x*y - 1", "a"},
    {"constant", NULL, "var x = 1;var y = 2;x'' = 3;y'' = 0", "x0"},
    {"blows up", NULL, "var x = 1;param a = 60;x' = a*x^2", "a x0"},
    {"force and potential", NULL,
     "var y = 1;param k = 30;param f = 1;y'' = -k*y;potential k*y^2/2;force f*cos(3*t)", "k f"},
    {"on a spring", "spring", "param b = 20;force -b*y^3", "b y0"},
    {"on a driven one", "driven", "param b = 20;force -b*y^3 + 0.1*sin(t)*v", "b gamma omega"},
    {"on one with drag", "drag", "param b = 20;force -b*y^3", "b C y0"},
    {"on a damped one", "damped", "param b = 20;force -b*y^3", "b gamma"},
    {"on a pendulum", "pendulum", "param b = 0.02;force b*cos(3*t) - b*theta'*abs(theta')",
     "b theta0"},
    {"looked at", "spring", "observe E = y^2", "k"},
};

static struct typed_models *models;
static struct system systems[LANE_COUNT];
static double rows[STEPS][2][LANE_COUNT];

static void type_lines(struct scene *scene, const char *lines)
{
    struct text rest = text_of(lines), line;
    struct error error = {0};
    while (text_split(&rest, ';', &line)) {
        const struct typed_line typed = typing_line(text_trim(line));
        const struct model *model = typed_add(models, scene->model, &typed, &error);
        if (!model)
            fail_msg("%.*s: %s", (int)line.len, line.data, error.text);
        scene_remodel(scene, model);
    }
}

static void type_case(const struct typed_case *one, struct scene *scene)
{
    scene_init(scene, one->preset ? preset_by_name(text_of(one->preset)) : NULL);
    type_lines(scene, one->lines);
    struct error error;
    if (scene_param(scene, "t0") >= 0)
        assert_true(scene_set(scene, scene_param(scene, "t0"), (struct measured){0.7, 0}, &error));
}

static bool bind_lane(const struct typed_case *one, const struct scene *base, int lane,
                      struct system *system)
{
    struct scene scene = *base;
    struct error error = {0};
    struct text rest = text_of(one->varied), name;
    while (text_split(&rest, ' ', &name)) {
        char known[32];
        snprintf(known, sizeof known, "%.*s", (int)name.len, name.data);
        const int param = scene_param(&scene, known);
        if (param < 0)
            fail_msg("%s has no %s", one->name, known);
        scene.value[param] += 0.013 * lane;
    }
    if (!scene_bind(&scene, system, &error))
        fail_msg("%s: %s", one->name, error.text);
    return true;
}

/* By method_turning_march() until it fails; the first variable and its speed, as a sweep wants
 * them. */
static int alone(const struct method *method, enum drag drag, const struct system *system, double h,
                 double row[STEPS][2], double *y, int64_t *evals)
{
    static double work[WORK], state[STEPS * LIMIT_VARIABLES];
    const int n = system->n;
    memcpy(y, system->start, (size_t)n * sizeof *y);
    struct step step = {.system = system, .drag = drag, .h = h, .y = y, .work = work};
    const struct march march = {&step, system->t0, 0, STEPS, state};
    enum step_status status;
    assert_true(method_work_size(method, n) <= WORK);
    const int taken =
        (int)method_turning_march(method, method_kernel(method, system, drag), &march, &status);
    for (int i = 0; i < taken; i++) {
        double dydt[LIMIT_VARIABLES];
        system_derivative(system, system->t0 + (i + 1) * h, state + i * n, dydt);
        row[i][0] = state[i * n];
        row[i][1] = system->order == 2 ? state[i * n + n / 2] : dydt[0];
    }
    *evals = step.cost.evals;
    return taken;
}

static double lane_step(bool own, int lane)
{
    return own ? H * (1 + 0.0037 * lane) : H;
}

static bool same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

static void compare_lane(const struct typed_case *one, const struct lanes *lanes,
                         const struct method *method, enum drag drag, bool own, int lane)
{
    double row[STEPS][2], y[LIMIT_VARIABLES], state[LIMIT_VARIABLES];
    int64_t evals;
    const int taken = alone(method, drag, &systems[lane], lane_step(own, lane), row, y, &evals);
    for (int i = 0; i < taken; i++) {
        const bool written = rows[i][0][0] != 0 || rows[i][1][0] != 0;
        if (written && !(same(rows[i][0][lane], row[i][0]) && same(rows[i][1][lane], row[i][1])))
            fail_msg(
                "%s, %s, drag %d, lane %d, step %d: %.17g, %.17g side by side, %.17g, %.17g alone",
                one->name, method->row.name, (int)drag, lane, i, rows[i][0][lane], rows[i][1][lane],
                row[i][0], row[i][1]);
    }
    lanes_state(lanes, lane, state);
    bool finite = true;
    for (int k = 0; k < systems[0].n; k++) {
        finite = finite && isfinite(state[k]);
        if (taken == STEPS && !same(state[k], y[k]))
            fail_msg("%s, %s, lane %d: variable %d is %.17g, alone %.17g", one->name,
                     method->row.name, lane, k, state[k], y[k]);
    }
    if (finite && taken == STEPS && lanes_evals(lanes, lane) != evals)
        fail_msg("%s, %s, lane %d: %lld evaluations, alone %lld", one->name, method->row.name, lane,
                 (long long)lanes_evals(lanes, lane), (long long)evals);
    /* so that it is noticed */
    if (taken < STEPS)
        assert_false(finite);
}

/* False: this method and this scene do not go in lanes. own: each lane has its own step. */
static bool compare(struct lanes *lanes, const struct typed_case *one, const struct method *method,
                    enum drag drag, bool own)
{
    struct error error;
    if (!method_applies(method, &systems[0], &drag, &error) ||
        !lanes_fit(method, &systems[0], drag, H))
        return false;
    assert_true(lanes_begin(lanes, method, drag, &systems[0], H));
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        assert_true(lanes_alike(&systems[0], &systems[lane]));
        lanes_set_step(lanes, lane, &systems[lane], lane_step(own, lane));
    }
    double first[2][LANE_COUNT], dydt[LIMIT_VARIABLES];
    lanes_row(lanes, &first[0][0]);
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        const struct system *s = &systems[lane];
        system_derivative(s, s->t0, s->start, dydt);
        assert_true(first[0][lane] == s->start[0]);
        assert_true(first[1][lane] == (s->order == 2 ? s->start[s->n / 2] : dydt[0]));
    }
    /* In pieces, some of them without rows. */
    for (int done = 0, piece = 1; done < STEPS; done += piece, piece = piece * 5 % 23) {
        piece = piece < STEPS - done ? piece : STEPS - done;
        memset(rows[done], 0, (size_t)piece * sizeof rows[0]);
        lanes_march(lanes, piece, piece % 2 ? &rows[done][0][0] : NULL);
        if (piece % 2 == 0)
            lanes_row(lanes, &rows[done + piece - 1][0][0]);
    }
    for (int lane = 0; lane < LANE_COUNT; lane += 1 + (lane > 4 && !is_long()) * 6)
        compare_lane(one, lanes, method, drag, own, lane);
    return true;
}

static void compare_all(struct lanes *lanes, const struct typed_case *one)
{
    struct scene scene;
    type_case(one, &scene);
    for (int lane = 0; lane < LANE_COUNT; lane++)
        bind_lane(one, &scene, lane, &systems[lane]);
    scene.steps_across_kinks =
        systems[0].pieces; /* steps that end at switches are no matter for lanes */
    for (int lane = 0; lane < LANE_COUNT && scene.steps_across_kinks; lane++)
        bind_lane(one, &scene, lane, &systems[lane]);
    int compared = 0;
    for (size_t m = 0; m < method_catalog.count; m++)
        for (enum drag drag = DRAG_DEFAULT; drag < DRAG_COUNT; drag++) {
            const struct method *method = method_at(m);
            compared += compare(lanes, one, method, drag, false);
            compare(lanes, one, method, drag, true);
        }
    if (compared < (systems[0].order == 2 ? 17 : 11))
        fail_msg("%s: only %d methods and drags", one->name, compared);
}

TEST(test_lanes_give_the_same_bits)
{
    struct lanes *lanes = *state;
    for (size_t c = 0; c < COUNT_OF(cases); c++)
        compare_all(lanes, &cases[c]);
}

/* x1 … xn, each drawn to its neighbours. */
static void write_chain(struct buffer *lines, int count, const char *primes, const char *each)
{
    buffer_clear(lines);
    buffer_format(lines, "var x0 = 1;param k = 3");
    for (int i = 1; i <= count; i++)
        buffer_format(lines, ";var x%d = 0", i);
    for (int i = 0; i <= count; i++)
        buffer_format(lines, ";x%d%s = k*(%s%d - 2*x%d + x%d)%s", i, primes, i > 0 ? "x" : "0*x",
                      i > 0 ? i - 1 : 1, i, i < count ? i + 1 : 0, each);
}

TEST(test_many_variables)
{
    struct lanes *lanes = *state;
    struct buffer lines = {0};
    struct typed_case one = {"twenty", NULL, NULL, "k x0_0"};
    write_chain(&lines, 19, "'", " - 0.1*sin(x0)");
    one.lines = lines.data;
    compare_all(lanes, &one);
    one.name = "thirty-two coordinates";
    write_chain(&lines, 31, "''", "");
    one.lines = lines.data;
    compare_all(lanes, &one);
    buffer_free(&lines);
}

/* Lanes refuse a system that is too large and a negative step; two systems whose compiled programs
 * differ cannot share lanes. */
TEST(test_refusals)
{
    const struct method *rk4 = method_by_name(TEXT("rk4"));
    struct buffer lines = {0};
    struct scene scene;
    buffer_format(&lines, "var x = 1;param a = 1;x' = a");
    struct typed_case one = {"large", NULL, lines.data, "a"};
    type_case(&one, &scene);
    bind_lane(&one, &scene, 0, &systems[0]);
    bind_lane(&one, &scene, 1, &systems[1]);
    assert_true(lanes_fit(rk4, &systems[0], DRAG_DEFAULT, H) &&
                lanes_alike(&systems[0], &systems[1]));
    assert_false(lanes_fit(rk4, &systems[0], DRAG_DEFAULT, -H));
    scene.value[scene_param(&scene, "a")] = 0;
    bind_lane(&one, &scene, 0, &systems[1]);
    assert_false(lanes_alike(&systems[0], &systems[1]));
    for (int k = 0; k < 20; k++) {
        buffer_format(&lines, ";var z%d = 1;z%d' = x", k, k);
        for (int i = 0; i < 100; i++)
            buffer_format(&lines, " + %d.5*x*cos(%d.%d*x)", i, i, k);
    }
    one.lines = lines.data;
    type_case(&one, &scene);
    bind_lane(&one, &scene, 0, &systems[0]);
    assert_false(lanes_fit(rk4, &systems[0], DRAG_DEFAULT, H));
    buffer_free(&lines);
}

static int setup(void **state)
{
    struct error error;
    models = typed_create(&error);
    *state = lanes_create();
    return models && *state ? 0 : -1;
}

static int teardown(void **state)
{
    lanes_destroy(*state);
    typed_destroy(models);
    return 0;
}

RUN_TESTS(setup, teardown)
