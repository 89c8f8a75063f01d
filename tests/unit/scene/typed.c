/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed scenes: what a line makes, what is refused and where, what a bound system computes. */
#include "cmocka_testing.h"

#include "unit/scene/fixture.h"
#include "unit/cpu_time.h"

#include <pthread.h>
#include <stdlib.h>

static void type(struct fixture *f, const char *const *lines)
{
    assert_true(type_scene(f->models, &f->scene, lines));
}

static const struct preset *preset(const char *name)
{
    return preset_by_name(text_of(name));
}

static void bind(struct fixture *f)
{
    if (!scene_bind(&f->scene, &f->system, &f->error))
        fail_msg("%s (%s)", f->error.text, f->error.hint);
}

static void set(struct fixture *f, const char *name, double value)
{
    const int index = scene_param(&f->scene, name);
    assert_true(index >= 0);
    assert_true(scene_set(&f->scene, index, (struct measured){value, 0}, &f->error));
}

static bool near(double a, double b, double tolerance)
{
    if (fabs(a - b) <= tolerance * fmax(1, fmax(fabs(a), fabs(b))))
        return true;
    print_message("%.17g is not %.17g\n", a, b);
    return false;
}

static double random_between(double min, double max)
{
    return min + (max - min) * rand() / RAND_MAX;
}

/* ---- making ---- */

static void test_first_order(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var y1 = 2", "var y2 = 0", "param mu = 1000", "y1' = y2",
                  "y2' = mu*(1 - y1^2)*y2 - y1", "observe E = y1^2 + y2^2", "observe half = E/2"));
    bind(f);
    assert_int_equal(f->system.order, 1);
    assert_int_equal(f->system.n, 2);
    assert_true(f->system.autonomous && !f->system.linear && !f->system.conservative);
    double y[] = {2, 1}, dydt[2], jac[4];
    system_derivative(&f->system, 0, y, dydt);
    system_jacobian(&f->system, 0, y, jac);
    assert_true(dydt[0] == 1 && dydt[1] == -3002);
    assert_true(jac[0] == 0 && jac[1] == 1 && jac[2] == -4001 && jac[3] == -3000);
    assert_int_equal(model_observed(f->scene.model), 2);
    assert_string_equal(model_observed_variable(f->scene.model, 0).name, "E");
    assert_true(system_observe(&f->system, 0, 0, y) == 5 &&
                system_observe(&f->system, 1, 0, y) == 2.5);
    set(f, "mu", 1); /* a name is a reference */
    set(f, "y1_0", 3);
    bind(f);
    system_derivative(&f->system, 0, y, dydt);
    assert_true(dydt[1] == -5 && f->system.start[0] == 3 && f->system.start[1] == 0);
}

static void test_second_order(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 1", "var x' = 0.5", "param k = 4", "param c = 0.1", "param m = 2",
                  "x'' = (-k*x - c*x'*abs(x'))/m", "potential k*x^2/2"));
    bind(f);
    const struct system *s = &f->system;
    assert_int_equal(s->order, 2);
    assert_int_equal(s->n, 2);
    assert_true(s->start[0] == 1 && s->start[1] == 0.5 && s->mass == 2 && s->velocity && s->kinks);
    assert_string_equal(f->scene.model->variable[1].name, "vx");
    assert_int_equal(model_state(f->scene.model, TEXT("x'")), 1);
    assert_int_equal(model_state(f->scene.model, TEXT("vx")), 1);
    assert_int_equal(model_state(f->scene.model, TEXT("x''")), -1);
    double y[] = {3, -2}, a[1], force[1], drag[1];
    system_acceleration(s, 0, y, a);
    system_force(s, 0, y, force);
    system_drag(s, 0, y, drag);
    assert_true(near(a[0], -5.8, 1e-15) && near(force[0], -6, 1e-15) && near(drag[0], 0.2, 1e-15));
    assert_true(a[0] == force[0] + drag[0]);
    assert_true(near(system_potential(s, y), 18, 1e-15) && near(system_kinetic(s, y), 4, 1e-15));
    assert_true(near(system_power(s, 0, y), 2 * 0.2 * -2, 1e-14));
    assert_true(near(system_dissipation(s, 0, y), 2 * 0.2 * -2, 1e-14));
    set(f, "c", 0); /* the term is gone: conservative, no velocity */
    bind(f);
    assert_int_equal(s->terms, 1);
    assert_true(!s->velocity && !s->kinks && s->conservative && s->linear);
}

static void test_mixed_orders(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 1", "var z = 5", "x'' = -x + z", "z' = -z + x'"));
    bind(f);
    assert_int_equal(f->system.order, 1);
    assert_int_equal(f->system.n, 3);
    assert_string_equal(f->scene.model->variable[2].name, "vx");
    double y[] = {1, 5, 7}, dydt[3];
    system_derivative(&f->system, 0, y, dydt);
    assert_true(dydt[0] == 7 && dydt[1] == 2 && dydt[2] == 4 && f->system.linear);
    assert_int_equal(model_state(f->scene.model, TEXT("x'")), 2);
    assert_int_equal(model_state(f->scene.model, TEXT("z'")), -1);
}

/* Two coordinates know each other's velocities before either has an equation. */
static void test_coupled(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var a = 1", "var b = 2", "a'' = -a + b'", "b'' = -b - a'"));
    bind(f);
    assert_int_equal(f->system.order, 2);
    double y[] = {1, 2, 3, 4}, acceleration[2];
    system_acceleration(&f->system, 0, y, acceleration);
    assert_true(acceleration[0] == 3 && acceleration[1] == -5);
}

/* ---- on top of a built-in scene ---- */

static void test_force(void **state)
{
    struct fixture *f = *state;
    scene_init(&f->scene, preset("damped"));
    set(f, "k", 7);
    struct system before;
    assert_true(scene_bind(&f->scene, &before, &f->error));
    type(f, LINES("param stiff = 40", "force -stiff*y^3 + 0.1*cos(2*t)"));
    assert_ptr_equal(typed_base(f->scene.model), &oscillator_model);
    assert_true(f->scene.value[scene_param(&f->scene, "k")] == 7 &&
                f->scene.preset == preset("damped"));
    bind(f);
    double y[] = {0.3, 0.7}, a[1], without[1];
    const double mass = f->scene.value[scene_param(&f->scene, "m")];
    system_acceleration(&f->system, 0.4, y, a);
    system_acceleration(&before, 0.4, y, without);
    assert_true(near(a[0], without[0] + (-40 * 0.027 + 0.1 * cos(0.8)) / mass, 1e-14));
    assert_true(!f->system.oscillator.whole && f->system.oscillator.drag_whole &&
                !f->system.autonomous);
    assert_false(system_has_exact(&f->system));
    type(f, LINES("force -stiff*y^3", "potential stiff*y^4/4"));
    bind(f);
    assert_true(
        near(system_potential(&f->system, y) - system_potential(&before, y), 10 * 0.0081, 1e-14));
    set(f, "stiff", 0);
    bind(f);
    assert_true(f->system.terms == before.terms && f->system.oscillator.whole);
    const struct model *plain = typed_remove(f->models, f->scene.model, TYPED_FORCE, TEXT(""),
                                             &f->error); /* and its potential */
    assert_non_null(plain);
    plain = typed_remove(f->models, plain, TYPED_PARAM, TEXT("stiff"), &f->error);
    assert_ptr_equal(plain, &oscillator_model);
}

static void test_observe_built_in(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("observe twice = 2*y + k + t"));
    bind(f);
    const double y[] = {3, 0}, k = f->scene.value[scene_param(&f->scene, "k")];
    assert_true(system_observe(&f->system, 0, 5, y) == 6 + k + 5);
    assert_true(f->system.oscillator.whole);
}

/* ---- refusals ---- */

static void refused(struct fixture *f, const char *line, const char *message, const char *where)
{
    const struct typed_line typed = typing_line(text_of(line));
    f->error = (struct error){0};
    if (typed_add(f->models, f->scene.model, &typed, &f->error))
        fail_msg("%s is taken", line);
    if (!strstr(f->error.text, message) && !strstr(f->error.hint, message))
        fail_msg("%s: %s (%s)", line, f->error.text, f->error.hint);
    const char *at = f->error.where.data;
    if (where && !(text_is(f->error.where, where) && at >= line && at < line + strlen(line)))
        fail_msg("%s: at '%.*s'", line, (int)f->error.where.len,
                 f->error.where.data ? f->error.where.data : "");
}

static void test_refusals(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 1", "var speed = 1", "param k = 4"));
    refused(f, "x'' = -k*xx", "did you mean 'x'", "xx");
    refused(f, "x'' = -k*spede", "'speed'", "spede");
    refused(f, "x'' = -k*x)", "ends before", ")");
    refused(f, "x'' = 2 +", "missing after '+'", NULL);
    refused(f, "z' = 1", "there is no variable 'z'", "z");
    refused(f, "var k = 1", "twice", NULL);
    refused(f, "param x0 = 1", "initial value of x: the parameter x0 needs another name", "x0");
    refused(f, "var t = 1", "already means something", "t");
    refused(f, "var sin = 1", "already means something", "sin");
    refused(f, "param 2x = 1", "letters", "2x");
    refused(f, "observe E = E + 1", "cannot be defined by itself", "E");
    refused(f, "x' = x + x'", "x has an equation of first order", "x'");
    refused(f, "var a_name_that_is_far_too_long_to_be_shown = 1", "at most", NULL);
    assert_false(scene_bind(&f->scene, &f->system, &f->error));
    assert_non_null(strstr(f->error.text, "x has no equation"));
    type(f, LINES("observe d = x", "observe above = d"));
    refused(f, "observe d = above", "above comes after d", "above");
    type(f, LINES("param vx0 = 3"));
    refused(f, "x'' = -x", "the parameter vx0 needs another name", "x");
    scene_remodel(&f->scene,
                  typed_remove(f->models, f->scene.model, TYPED_PARAM, TEXT("vx0"), &f->error));
    assert_null(typed_remove(f->models, f->scene.model, TYPED_VAR, TEXT("x"), &f->error));
    assert_string_equal(f->error.text, "x is still used by: observe d = x");
    type(f, LINES("x' = k", "speed' = x"));
    bind(f);
    refused(f, "potential x^2", "second order", NULL);
    type(f, LINES("x'' = -x", "speed'' = -speed"));
    refused(f, "potential x'^2", "positions only", "x'^2");
    type(f, LINES("potential x^2/2 + speed^2/2"));
    refused(f, "x' = 1", "second order", NULL);
}

static void test_potential_is_checked(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 1", "var y = 0.5", "param k = 3", "x'' = -k*x - 2*x*y - 0.1*x'",
                  "y'' = -y - x^2 + cos(t)", "potential k*x^2/2 + y^2/2 + x^2*y"));
    bind(f); /* drag and drive are work */
    assert_false(f->system.conservative);
    type(f, LINES("potential k*x^2/2 + y^2/2 + x^2*y/2"));
    assert_false(scene_bind(&f->scene, &f->system, &f->error));
    assert_non_null(strstr(f->error.text, "does not match the force: at x = "));
    type(f, LINES("potential k*x^2/2"));
    assert_false(scene_bind(&f->scene, &f->system, &f->error));
}

/* ---- values ---- */

static void test_jacobians(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 0.4", "var y = 0.3", "param k = 3",
                  "x'' = -k*sin(x)*cosh(y) - 0.3*x'*hypot(x', y')",
                  "y'' = -exp(-y)*log(2 + x^2) + sin(t*x) - y'^3 + atan2(x, 2 + y)"));
    bind(f);
    for (int round = 0; round < 200; round++) {
        double y[4], jac[16], t = random_between(0, 3);
        for (int i = 0; i < 4; i++)
            y[i] = random_between(-1, 1);
        system_jacobian(&f->system, t, y, jac);
        for (int j = 0; j < 4; j++) {
            double up[4], down[4], g[4], h[4];
            memcpy(up, y, sizeof up);
            memcpy(down, y, sizeof down);
            up[j] += 0x1p-17;
            down[j] -= 0x1p-17;
            system_derivative(&f->system, t, up, g);
            system_derivative(&f->system, t, down, h);
            for (int i = 0; i < 4; i++)
                assert_true(near(jac[4 * i + j], (g[i] - h[i]) / (up[j] - down[j]), 1e-7));
        }
    }
}

static void test_same_bits_as_built_in(void **state)
{
    struct fixture *f = *state;
    struct scene built_in;
    struct system wanted;
    scene_init(&built_in, preset("henon-heiles"));
    assert_true(scene_bind(&built_in, &wanted, &f->error));
    type(f, LINES("var x = 0", "var y = 0", "var x' = 0.24", "var y' = 0.32", "x'' = -(x + 2*x*y)",
                  "y'' = -(y + (x^2 - y^2))", "potential (x^2 + y^2)/2 + (x^2 - y^2/3)*y"));
    bind(f);
    assert_true(f->system.conservative && !f->system.velocity && f->system.order == 2 &&
                f->system.n == 4);
    for (int round = 0; round < 10000; round++) {
        double y[4], a[2], b[2];
        for (int i = 0; i < 4; i++)
            y[i] = random_between(-1, 1);
        system_acceleration(&f->system, 0, y, a);
        system_acceleration(&wanted, 0, y, b);
        assert_memory_equal(a, b, sizeof a);
        assert_true(near(system_potential(&f->system, y), system_potential(&wanted, y), 1e-15));
    }
}

/* A summand whose factor is 0 is absent even where the rest is infinite. */
static void test_absent(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 0", "param c = 0", "x'' = -x + c/x"));
    bind(f);
    double a[1], y[] = {0, 0};
    system_acceleration(&f->system, 0, y, a);
    assert_true(a[0] == 0 && f->system.linear);
    set(f, "c", 1);
    assert_false(scene_bind(&f->scene, &f->system, &f->error));
    assert_non_null(strstr(f->error.text, "x'' has no finite value at x = 0"));
}

static void test_scales(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 2", "param w = 1000", "x'' = -w^2*x"));
    bind(f);
    assert_true(near(f->system.scale[0], 2, 0.05) && near(f->system.scale[1], 2000, 0.05));
    type(f, LINES("var u = 0", "x'' = 0", "u'' = 0"));
    bind(f);
    for (int i = 0; i < 4; i++)
        assert_true(f->system.scale[i] > 0);
}

/* A run may be too short for what grows later: sizes are those after one time constant, not after
 * eight. */
static void test_scales_of_growth(void **state)
{
    struct fixture *f = *state;
    const char *const equations[] = {"x' = x", "x' = x - 1e-12*x^3"};
    for (size_t i = 0; i < COUNT_OF(equations); i++) {
        type(f, LINES("var x = 1", equations[i]));
        bind(f);
        assert_true(near(f->system.scale[0], 2.7, 0.5));
    }
    /* The mass falls off the potential's edge at 7.3 s: then it is at 1e3 and more. */
    type(f, LINES("var x = 0.08", "var y = 0", "var u = 0", "var w = 0.19", "x' = u", "y' = w",
                  "u' = -x - 2*x*y + 1.8*exp(-((t - 2.7)/0.3)^2)", "w' = -y - x^2 + y^2"));
    bind(f);
    for (int i = 0; i < 4; i++)
        assert_true(f->system.scale[i] < 10);
}

static void test_lines_come_back(void **state)
{
    struct fixture *f = *state;
    const char *const lines[] = {"var x = 0.5",
                                 "param k = 3",
                                 "x'' = -k*x",
                                 "potential k*x^2/2",
                                 "observe E = x'^2/2 + k*x^2/2",
                                 NULL};
    type(f, lines);
    assert_int_equal(typed_lines(f->scene.model), 5);
    for (int i = 0; lines[i]; i++) {
        struct buffer text = {0};
        typed_describe(typed_line(f->scene.model, i), &text);
        assert_string_equal(text.data, lines[i]);
        buffer_free(&text);
    }
    type(f, LINES("var x = 0.75"));
    assert_int_equal(typed_lines(f->scene.model), 5);
    assert_true(f->scene.value[scene_param(&f->scene, "x0")] == 0.75);
}

/* ---- limits ---- */

static void test_largest(void **state)
{
    struct fixture *f = *state;
    char line[80];
    for (int i = 1; i <= LIMIT_VARIABLES; i++) {
        snprintf(line, sizeof line, "var y%d = %d", i, i == 1);
        type(f, LINES(line));
    }
    for (int i = 1; i <= LIMIT_VARIABLES; i++) {
        snprintf(line, sizeof line, "y%d' = y%d*y%d - y%d", i, i == 1 ? 64 : i - 1,
                 i == 64 ? 1 : i + 1, i);
        type(f, LINES(line));
    }
    bind(f);
    assert_int_equal(f->system.n, LIMIT_VARIABLES);
    double y[LIMIT_VARIABLES], dydt[LIMIT_VARIABLES], jac[LIMIT_VARIABLES * LIMIT_VARIABLES];
    for (int i = 0; i < LIMIT_VARIABLES; i++)
        y[i] = i + 1;
    system_derivative(&f->system, 0, y, dydt);
    system_jacobian(&f->system, 0, y, jac);
    assert_true(dydt[0] == 64 * 2 - 1 && dydt[63] == 63 * 1 - 64 && jac[63] == 2 && jac[0] == -1);
    refused(f, "var more = 1", "at most 64 variables", NULL);
    for (int i = 1; i <= LIMIT_OBSERVED; i++) {
        snprintf(line, sizeof line, "observe o%d = y1 + %d", i, i);
        type(f, LINES(line));
    }
    bind(f);
    assert_int_equal(model_observed(f->scene.model), LIMIT_OBSERVED);
    assert_true(system_observe(&f->system, LIMIT_OBSERVED - 1, 0, y) == 1 + LIMIT_OBSERVED);
    refused(f, "observe more = y1", "at most 192 observed quantities", NULL);
}

static void test_long_sum_is_quick(void **state)
{
    struct fixture *f = *state;
    static char line[40000];
    size_t at = (size_t)snprintf(line, sizeof line, "x'' = x");
    for (int i = 0; i < 700; i++)
        at += (size_t)snprintf(line + at, sizeof line - at, " - x*%d %c x'*%d", i,
                               i % 2 ? '+' : '-', i);
    type(f, LINES("var x = 1"));
    const int64_t begin = cpu_ns();
    refused(f, line, "operations", NULL);
    *strstr(line + 8000, " - x*") = '\0';
    type(f, LINES(line));
    bind(f);
    assert_true(cpu_ns() - begin < 1000000000);
    assert_int_equal(f->system.terms, 2);
}

/* ---- threads: the programs are made once for each set of zeros, whoever asks first ---- */

enum { THREADS = 4, ROUNDS = 200 };

static void *bind_often(void *context)
{
    struct fixture *f = context;
    struct scene scene = f->scene;
    uintptr_t wrong = 0;
    for (int i = 0; i < ROUNDS; i++) {
        struct system system;
        struct error error;
        double y[] = {2, 3}, a[1];
        scene.value[scene_param(&scene, "p")] = i & 1;
        scene.value[scene_param(&scene, "q")] = i >> 1 & 1;
        scene.value[scene_param(&scene, "r")] = i >> 2 & 1;
        if (!scene_bind(&scene, &system, &error))
            return context;
        system_acceleration(&system, 0, y, a);
        wrong += a[0] != -2.0 * (i & 1) - 4.0 * (i >> 1 & 1) - 3.0 * (i >> 2 & 1);
    }
    return wrong ? context : NULL;
}

static void test_threads(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 1", "param p = 1", "param q = 1", "param r = 1",
                  "x'' = -p*x - q*x^2 - r*x'", "potential p*x^2/2 + q*x^3/3"));
    pthread_t thread[THREADS];
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&thread[i], NULL, bind_often, f), 0);
    for (int i = 0; i < THREADS; i++) {
        void *wrong;
        assert_int_equal(pthread_join(thread[i], &wrong), 0);
        assert_null(wrong);
    }
}

/* ---- potentials that are found ---- */

/* Is the slope of the potential the force, in units of the mass, at random places? Differences are
 * good to 1e-7. */
static void check_slopes(struct fixture *f)
{
    const struct system *s = &f->system;
    const int rows = s->n / 2;
    for (int k = 0; k < 20; k++) {
        double y[LIMIT_VARIABLES] = {0}, a[LIMIT_VARIABLES];
        for (int i = 0; i < rows; i++)
            y[i] = random_between(0.3, 2) * fmax(s->scale[i], 0.1 * s->scale[0]) *
                   (rand() % 2 ? 1 : -1);
        system_force(s, 0, y, a);
        for (int i = 0; i < rows; i++) {
            const double h = 1e-4 * fabs(y[i]), at = y[i];
            y[i] = at + h;
            const double above = system_potential(s, y);
            y[i] = at - h;
            const double slope = (above - system_potential(s, y)) / (2 * h);
            y[i] = at;
            assert_true(near(-slope, s->mass * a[i], 1e-6));
        }
    }
}

static void test_found_potentials(void **state)
{
    static const struct {
        const char *line[6];
        bool found, energy;
    } cases[] = {
        {{"var x = 1", "var y = 0", "x'' = y - 2*x", "y'' = x - 2*y + 1"}, true, true},
        {{"var x = 1", "var y = 0", "param m = 3", "x'' = -x^3 - 2*x*y^2",
          "y'' = -2*x^2*y - sin(y)"},
         true,
         true},
        {{"var x = 1", "var y = 0", "x'' = -x/(x^2 + y^2)^1.5", "y'' = -y/(x^2 + y^2)^1.5"},
         true,
         true},
        {{"var x = 1", "var y = 0", "var z = 0.5", "x'' = -x/(x^2 + y^2 + z^2)",
          "y'' = -y/(x^2 + y^2 + z^2)", "z'' = -z/(x^2 + y^2 + z^2)"},
         true,
         true},
        {{"var x = 1", "x'' = -1/x"}, true, true},
        {{"var x = 1", "x'' = -sin(x) + exp(-x) - x'"}, true, true},
        {{"var x = 1", "x'' = -x + cos(3*t)"}, true, true},
        {{"var x = 1", "x'' = cos(3*t) - x'*abs(x')"}, false, true},
        {{"var x = 1", "x'' = -x*cos(3*t)"}, false, false},
        {{"var x = 1", "x'' = -x - sin(x - t)"}, true, false},
        {{"var x = 1", "x'' = -x*(1 + x')"}, false, false},
        {{"var x = 1", "var y = 0", "x'' = y", "y'' = -x"}, false, false},
        {{"var x = 1", "var y = 0", "x'' = -y/(x^2 + y^2)", "y'' = x/(x^2 + y^2)"}, false, false},
        {{"var x = 1", "var y = 0", "x'' = if(y > 0.3, 1, 0) - x", "y'' = -2*y"}, false, false},
    };
    struct fixture *f = *state;
    for (size_t c = 0; c < COUNT_OF(cases); c++) {
        const char *line[7] = {NULL};
        memcpy(line, cases[c].line, sizeof cases[c].line);
        scene_init(&f->scene, NULL);
        type(f, line);
        bind(f);
        bool found = false;
        for (int i = 0; i < f->system.terms; i++)
            found |= f->system.term[i].row->potential != NULL;
        if (found != cases[c].found || f->system.energy != cases[c].energy)
            fail_msg("case %zu: potential %d, energy %d", c, found, f->system.energy);
        if (found && f->system.autonomous && !f->system.velocity)
            check_slopes(f);
        struct system motion;
        assert_true(scene_bind_motion(&f->scene, &motion, &f->error));
        for (int i = 0; i < motion.terms; i++)
            assert_null(motion.term[i].row->potential);
    }
}

/* In one coordinate a force with kinks and jumps has a potential that is continuous. */
static void test_potential_of_kinks(void **state)
{
    struct fixture *f = *state;
    type(f, LINES("var x = 1", "x'' = if(x > 0.3, -x, -4*x) - 0.2*sign(x)"));
    bind(f);
    assert_true(f->system.conservative && f->system.energy);
    for (double x = -2; x < 2; x += 0.01) {
        const double y[] = {x, 0}, x0 = fmin(x, 0.3);
        assert_true(near(system_potential(&f->system, y),
                         2 * x0 * x0 + (x > 0.3 ? (x * x - 0.09) / 2 : 0) + 0.2 * fabs(x), 1e-10));
    }
}

#define WITH_MODELS(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_MODELS(test_first_order),
        WITH_MODELS(test_second_order),
        WITH_MODELS(test_mixed_orders),
        WITH_MODELS(test_coupled),
        WITH_MODELS(test_force),
        WITH_MODELS(test_observe_built_in),
        WITH_MODELS(test_refusals),
        WITH_MODELS(test_potential_is_checked),
        WITH_MODELS(test_found_potentials),
        WITH_MODELS(test_potential_of_kinks),
        WITH_MODELS(test_jacobians),
        WITH_MODELS(test_same_bits_as_built_in),
        WITH_MODELS(test_absent),
        WITH_MODELS(test_scales),
        WITH_MODELS(test_scales_of_growth),
        WITH_MODELS(test_lines_come_back),
        WITH_MODELS(test_largest),
        WITH_MODELS(test_long_sum_is_quick),
        WITH_MODELS(test_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
