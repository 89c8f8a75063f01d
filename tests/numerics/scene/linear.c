/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What typed equations are recognised as, and exact solutions of linear systems against closed
 * forms. */
#include <hooke/base/catalog.h>
#include "cmocka_testing.h"

#include "unit/scene/fixture.h"

#include <float.h>
#include <stdlib.h>

static void bind_lines(struct fixture *f, const char *const *lines)
{
    scene_init(&f->scene, NULL);
    assert_true(type_scene(f->models, &f->scene, lines));
    if (!scene_bind(&f->scene, &f->system, &f->error))
        fail_msg("%s: %s", lines[0], f->error.text);
}

static void set(struct scene *scene, const char *name, double value)
{
    struct error error;
    const int index = scene_param(scene, name);
    assert_true(index >= 0);
    if (!scene_set(scene, index, (struct measured){value, 0}, &error))
        fail_msg("%s = %g: %s", name, value, error.text);
}

static double random_between(double min, double max)
{
    return min + (max - min) * rand() / RAND_MAX;
}

/* Rounding of an ulp or so in the coefficients. */
static bool alike(double a, double b, double unit)
{
    if (fabs(a - b) <= 4 * DBL_EPSILON * fmax(unit, fmax(fabs(a), fabs(b))))
        return true;
    print_message("%.17g is not %.17g\n", a, b);
    return false;
}

/* ---- one oscillator ---- */

static bool same_oscillator(const struct system *a, const struct system *b)
{
    const struct oscillator *p = &a->oscillator, *q = &b->oscillator;
    const double along = p->drive * cos(p->phase) - q->drive * cos(q->phase),
                 across = p->drive * sin(p->phase) - q->drive * sin(q->phase);
    return p->whole == q->whole && p->drag_whole == q->drag_whole &&
           alike(p->stiffness, q->stiffness, 0) && alike(p->damping, q->damping, 0) &&
           alike(p->quadratic, q->quadratic, 0) && alike(p->gravity, q->gravity, 0) &&
           hypot(along, across) <= 4e-15 * fabs(q->drive) &&
           (q->drive == 0 || p->omega == q->omega) && a->linear == b->linear &&
           a->autonomous == b->autonomous && a->velocity == b->velocity && a->kinks == b->kinks &&
           alike(a->scale[0], b->scale[0], 0) && alike(a->scale[1], b->scale[1], 0);
}

static bool same_solution(const struct system *a, const struct system *b)
{
    bool fine = system_has_exact(a) == system_has_exact(b);
    for (int i = 0; fine && system_has_exact(a) && i < 10; i++) {
        const double t = a->t0 + random_between(-3, 20);
        double y[2], z[2], floor[2], low[2];
        system_exact(a, a->t0, a->start, t, y, floor);
        system_exact(b, b->t0, b->start, t, z, low);
        for (int j = 0; j < 2; j++) { /* a few ulps in each of five coefficients */
            if (!(fabs(y[j] - z[j]) <= 40 * fmax(floor[j], low[j]))) {
                print_message("t = %g: %.17g is not %.17g, floor %g\n", t, y[j], z[j], floor[j]);
                fine = false;
            }
        }
    }
    return fine;
}

/* The same motion as equations, as forces on an empty spring, as forces on top of half of it, and
 * built in. */
static void test_like_the_built_in(void **state)
{
    struct fixture *f = *state;
    static const char *const own[] = {"k", "c", "q", "w", "F", "o", "p"};
    struct scene built_in;
    struct system wanted;
    for (int i = 0; i < 300; i++) {
        double value[] = {random_between(-5, 40), random_between(-0.5, 3), random_between(0, 2),
                          random_between(-9, 9),  random_between(-2, 2),   random_between(0, 9),
                          random_between(-4, 4)};
        for (int k = 0; k < 5; k++)
            if (rand() % 3 == 0)
                value[k] = 0;
        if (rand() % 2)
            value[2] = 0;
        const double m = random_between(0.1, 3), y0 = random_between(-1, 1),
                     v0 = random_between(-1, 1);
        scene_init(&built_in, NULL);
        const struct {
            const char *name;
            double value;
        } given[] = {{"m", m},
                     {"k", value[0]},
                     {"gamma", value[1] / m},
                     {"C", value[2]},
                     {"rho", 1},
                     {"area", 1},
                     {"g", value[3] / m},
                     {"F0", value[4]},
                     {"omega", value[5]},
                     {"phase", value[6]},
                     {"y0", y0},
                     {"v0", v0},
                     {"t0", 0.5}};
        for (size_t k = 0; k < COUNT_OF(given); k++)
            set(&built_in, given[k].name, given[k].value);
        assert_true(scene_bind(&built_in, &wanted, &f->error));
        for (int form = 0; form < 4; form++) {
            static const char *const equation[] = {
                "y'' = (-k*y - c*y' - q*y'*abs(y') - w + F*cos(o*t + p))/m",
                "y'' = -(k/m*y) - (c + q*abs(y'))*y'/m + (F*sin(p + t*o + pi/2) - w)/m",
                "force -k*y - c*v - q*abs(v)*v - w + F*cos(o*t + p)",
                "force -0.5*(k*y + c*v + q*v*abs(v) + w) + 0.5*F*cos(-(o*t) - p)"};
            scene_init(&f->scene, NULL);
            struct error error = {0};
            const char *const begin[] = {form < 2 ? "var y = 0" : NULL, NULL};
            assert_true(type_scene(f->models, &f->scene, begin));
            for (size_t k = 0; k < COUNT_OF(own) + (form < 2); k++) {
                char line[40];
                if (form < 2 || strcmp(own[k], "k") != 0) {
                    snprintf(line, sizeof line, "param %s = 1", k < COUNT_OF(own) ? own[k] : "m");
                    const struct model *model = type_line(f->models, f->scene.model, line, &error);
                    assert_non_null(model);
                    scene_remodel(&f->scene, model);
                }
            }
            const char *text = equation[form];
            char forced[200];
            snprintf(forced, sizeof forced, "%s", text);
            for (char *at = forced; form >= 2 && *at; at++) /* k is the spring's own parameter */
                if (at[0] == 'k')
                    *at = 's';
            if (form >= 2) {
                const struct model *model =
                    type_line(f->models, f->scene.model, "param s = 1", &error);
                assert_non_null(model);
                scene_remodel(&f->scene, model);
            }
            const struct model *model = type_line(f->models, f->scene.model, forced, &error);
            if (!model)
                fail_msg("%s: %s", forced, error.text);
            scene_remodel(&f->scene, model);
            for (size_t k = 0; k < COUNT_OF(own); k++)
                set(&f->scene, form >= 2 && k == 0 ? "s" : own[k], value[k]);
            set(&f->scene, "m", m);
            set(&f->scene, "y0", y0);
            set(&f->scene, form < 2 ? "vy0" : "v0", v0);
            set(&f->scene, "t0", 0.5);
            if (form >= 2) {
                const double half = form == 3 ? 0.5 : 0;
                const struct {
                    const char *name;
                    double value;
                } rest[] = {{"k", half * value[0]},
                            {"gamma", half * value[1] / m},
                            {"C", half * value[2]},
                            {"rho", 1},
                            {"area", 1},
                            {"g", half * value[3] / m},
                            {"F0", half * value[4]},
                            {"omega", value[5]},
                            {"phase", value[6]}};
                for (size_t k = 0; k < COUNT_OF(rest); k++)
                    set(&f->scene, rest[k].name, rest[k].value);
            }
            assert_true(scene_bind(&f->scene, &f->system, &f->error));
            if (!same_oscillator(&f->system, &wanted) || !same_solution(&f->system, &wanted))
                fail_msg("%s with k %g c %g q %g w %g F %g o %g p %g", forced, value[0], value[1],
                         value[2], value[3], value[4], value[5], value[6]);
        }
    }
}

/* Nearly an oscillator, and none. */
static void test_not_recognised(void **state)
{
    struct fixture *f = *state;
    static const char *const none[] = {"y'' = -y*y",
                                       "y'' = -y + 1e-9*y^3",
                                       "y'' = -max(y,0)",
                                       "y'' = -abs(y)",
                                       "y'' = -abs(y)*y'",
                                       "y'' = -y - y*y'",
                                       "y'' = -k*(1+0.1*t)*y",
                                       "y'' = -y - (1+t)*y'",
                                       "y'' = -sin(y)",
                                       "y'' = -y - sign(y')",
                                       "y'' = -y - 0.1*y'^2",
                                       "y'' = -y + cos(t)*cos(t)",
                                       "y'' = -y + cos(t^2)",
                                       "y'' = -y + cos(t)+cos(2*t)",
                                       "y'' = -y + t",
                                       "y'' = -y - step(y)",
                                       "y'' = -y - floor(y')",
                                       "y'' = -if(y,y,2*y)",
                                       "y'' = -y - abs(abs(y')-1)*y'",
                                       "y'' = -y + y'*abs(y')",
                                       "y'' = -y + exp(t)",
                                       "y'' = -1/y",
                                       "y'' = -y*(y < 1)",
                                       "y'' = -y + cos(y)",
                                       "y'' = -y - abs(y')",
                                       "y'' = -y - y'*abs(y'+1)",
                                       "y'' = -sqrt(y*y)"};
    for (size_t i = 0; i < COUNT_OF(none); i++) {
        bind_lines(f, LINES("var y = 0.5", "param k = 1", none[i]));
        if (f->system.oscillator.whole || system_has_exact(&f->system))
            fail_msg("%s is no oscillator", none[i]);
    }
    static const struct {
        const char *line;
        bool linear;
    } linear[] = {{"y'' = -y - sign(y')", false},
                  {"y'' = -y - step(y)", false},
                  {"y'' = -y + t", true},
                  {"y'' = -y + exp(t)", true},
                  {"y'' = -y*(1 + t)", false},
                  {"y'' = -if(k, y, y^2)", true},
                  {"y'' = -if(k-2, y, y^2)", false},
                  {"y'' = -y/(1 + k)", true},
                  {"y'' = -round(y)", false},
                  {"y'' = -y*y/y", false},
                  {"y'' = -(y < 1)*k", false}};
    for (size_t i = 0; i < COUNT_OF(linear); i++) {
        bind_lines(f, LINES("var y = 0.5", "param k = 1", linear[i].line));
        if (i != 5 &&
            f->system.linear !=
                linear[i].linear) /* a parameter in a condition is not known as it is written */
            fail_msg("%s: linear is %d", linear[i].line, f->system.linear);
    }
    /* What is recognised is so for the present parameters. */
    bind_lines(f, LINES("var y = 0.5", "param e = 0", "y'' = -y - e*y^3"));
    assert_true(f->system.oscillator.whole && system_has_exact(&f->system));
    set(&f->scene, "e", 1e-12);
    assert_true(scene_bind(&f->scene, &f->system, &f->error));
    assert_true(!f->system.oscillator.whole && !system_has_exact(&f->system));
    /* One that is whole keeps its drag apart: exact flows need no more than that. */
    bind_lines(f, LINES("var y = 0.5", "y'' = -y^3 - 0.1*y' - 0.2*abs(y')*y'"));
    assert_true(!f->system.oscillator.whole && f->system.oscillator.drag_whole && f->system.kinks);
    assert_true(f->system.oscillator.damping == 0.1 && f->system.oscillator.quadratic == 0.2);
    bind_lines(f, LINES("var y = 0.5", "y'' = -y - 0.1*y'^2"));
    assert_false(f->system.oscillator.drag_whole);
    /* not as has_kink() looks for it */
    bind_lines(f, LINES("var y = 0.5", "y'' = -y - 0.1*y'*abs(2*y')"));
    assert_true(f->system.kinks && f->system.oscillator.whole);
    /* Where a position cannot be told from the drag it is no oscillator in two parts, but linear
     * all the same. */
    bind_lines(f, LINES("var y = 0.5", "param k = 2", "y'' = -if(k, y + y', 0)"));
    assert_true(!f->system.oscillator.whole && !f->system.oscillator.drag_whole &&
                system_has_exact(&f->system));
    double y[2], wanted[2];
    system_exact(&f->system, 0, f->system.start, 3, y, NULL);
    bind_lines(f, LINES("var y = 0.5", "y'' = -y - y'"));
    system_exact(&f->system, 0, f->system.start, 3, wanted, NULL);
    assert_true(alike(y[0], wanted[0], 1) && alike(y[1], wanted[1], 1) && y[0] != 0.5);
    bind_lines(f, LINES("var a = 1", "var b = 2", "a'' = -a^3 - 0.5*a'", "b'' = -b - 0.5*b'"));
    assert_true(f->system.oscillator.drag_whole && f->system.oscillator.damping == 0.5);
    bind_lines(f, LINES("var a = 1", "var b = 2", "a'' = -a - 0.5*a'", "b'' = -b - 0.4*b'"));
    assert_true(!f->system.oscillator.drag_whole && !f->system.oscillator.whole);
    bind_lines(f, LINES("var a = 1", "var b = 2", "a'' = -a - 0.5*b'", "b'' = -b - 0.5*a'"));
    assert_false(f->system.oscillator.drag_whole);
}

/* Values at the ends of the range: recognised with finite coefficients, refused, or left to the
 * general way. */
static void test_extremes(void **state)
{
    struct fixture *f = *state;
    const double value[] = {0, -1, 1e300, -1e300, 1e-300, DBL_MAX, DBL_MIN};
    bind_lines(f, LINES("var y = 1e-10", "param k = 1", "param c = 0", "param m = 1",
                        "y'' = -k/m*y - c*y'"));
    assert_false(
        scene_set(&f->scene, scene_param(&f->scene, "k"), (struct measured){NAN, 0}, &f->error));
    for (size_t i = 0; i < COUNT_OF(value); i++)
        for (size_t j = 0; j < COUNT_OF(value); j++)
            for (int heavy = 0; heavy < 2; heavy++) {
                set(&f->scene, "k", value[i]);
                set(&f->scene, "c", value[j]);
                set(&f->scene, "m", heavy ? 1 : 1e-10);
                if (!scene_bind(&f->scene, &f->system, &f->error))
                    continue;
                const double stiffness = value[i] / (heavy ? 1 : 1e-10);
                assert_true(f->system.oscillator.whole == (isfinite(stiffness) != 0));
                assert_true(f->system.scale[0] > 0 && f->system.scale[1] > 0 &&
                            isfinite(f->system.scale[1]));
                if (f->system.oscillator.whole)
                    assert_true(f->system.oscillator.stiffness == stiffness &&
                                f->system.oscillator.damping == value[j]);
                if (system_has_exact(&f->system)) {
                    double y[2], floor[2];
                    system_exact(&f->system, 0, f->system.start, 1e-3, y, floor);
                    assert_false(isnan(y[0]) || isnan(floor[0]));
                }
            }
}

/* ---- linear systems ---- */

static void check(const struct system *system, double t, const double *wanted, double tolerance)
{
    double y[LIMIT_VARIABLES], floor[LIMIT_VARIABLES];
    assert_true(system_has_exact(system));
    system_exact(system, system->t0, system->start, t, y, floor);
    for (int i = 0; i < system->n; i++) {
        const double max = tolerance * fmax(system->scale[i], fabs(wanted[i]));
        if (!(fabs(y[i] - wanted[i]) <= max))
            fail_msg("%s at %g: %.17g is not %.17g (off by %.2g, allowed %.2g)",
                     system->model->variable[i].name, t, y[i], wanted[i], fabs(y[i] - wanted[i]),
                     max);
        assert_true(floor[i] >= 0 && floor[i] < 1e-9 * fmax(system->scale[i], fabs(wanted[i])));
    }
}

/* Normal modes: two and three like masses between walls. */
static void test_normal_modes(void **state)
{
    struct fixture *f = *state;
    const double times[] = {0, 0.1, 1, 7.5, 100, 1000, -30};
    bind_lines(f, LINES("var a = 1", "var b = 0", "param k = 2", "param j = 3",
                        "a'' = -k*a + j*(b - a)", "b'' = -k*b + j*(a - b)"));
    assert_true(f->system.linear && !f->system.oscillator.whole);
    for (size_t i = 0; i < COUNT_OF(times); i++) {
        const long double t = (long double)times[i], s = sqrtl(2), w = sqrtl(8),
                          c = cosl(s * t) / 2, d = cosl(w * t) / 2;
        const long double u = -s * sinl(s * t) / 2, v = -w * sinl(w * t) / 2;
        const double wanted[] = {(double)(c + d), (double)(c - d), (double)(u + v),
                                 (double)(u - v)};
        check(&f->system, times[i], wanted, 3e-16 + 1e-18 * fabs(times[i]));
    }
    bind_lines(f, LINES("var a = 1", "var b = 0", "var c = 0", "a'' = b - 2*a", "b'' = a - 2*b + c",
                        "c'' = b - 2*c"));
    for (size_t i = 0; i < COUNT_OF(times); i++) {
        const long double t = (long double)times[i],
                          w[] = {sqrtl(2 - sqrtl(2)), sqrtl(2), sqrtl(2 + sqrtl(2))};
        const long double shape[3][3] = {
            {0.25L, sqrtl(2) / 4, 0.25L}, {0.5L, 0, -0.5L}, {0.25L, -sqrtl(2) / 4, 0.25L}};
        double wanted[6] = {0};
        for (int k = 0; k < 3; k++)
            for (int j = 0; j < 3; j++) {
                wanted[j] += (double)(shape[k][j] * cosl(w[k] * t));
                wanted[3 + j] -= (double)(shape[k][j] * w[k] * sinl(w[k] * t));
            }
        check(&f->system, times[i], wanted, 6e-16 + 1e-18 * fabs(times[i]));
    }
}

/* The oscillator as two equations of first order, in every regime, with a constant force, against
 * its closed form. */
static void test_like_the_closed_form(void **state)
{
    struct fixture *f = *state;
    struct fixture second = *f;
    for (int i = 0; i < 300; i++) {
        const double k = random_between(-2, 9),
                     c = i % 3 ? random_between(-1, 4) : 2 * sqrt(fabs(k)),
                     g = i % 2 ? random_between(-9, 9) : 0, start = random_between(-1, 1);
        char lines[3][120];
        snprintf(lines[0], sizeof lines[0], "var y = %.17g", start);
        snprintf(lines[1], sizeof lines[1], "v' = (%.17g)*y + (%.17g)*v + (%.17g)", -k, -c, -g);
        snprintf(lines[2], sizeof lines[2], "y'' = (%.17g)*y + (%.17g)*y' + (%.17g)", -k, -c, -g);
        bind_lines(f, LINES(lines[0], "var v = 0.25", "y' = v", lines[1]));
        bind_lines(&second, LINES(lines[0], "var y' = 0.25", lines[2]));
        assert_true(!f->system.oscillator.whole && second.system.oscillator.whole);
        for (int j = 0; j < 5; j++) {
            const double t = random_between(-4, 30);
            double y[2], z[2], floor[2], low[2];
            system_exact(&f->system, 0, f->system.start, t, y, floor);
            system_exact(&second.system, 0, second.system.start, t, z, low);
            for (int n = 0; n < 2; n++)
                if (!(fabs(y[n] - z[n]) <= DBL_EPSILON * fabs(z[n]) + 2 * floor[n]))
                    fail_msg("k %g c %g g %g t %g: %.17g is not %.17g, floor %g", k, c, g, t, y[n],
                             z[n], floor[n]);
        }
    }
}

static void test_stiff(void **state)
{
    struct fixture *f = *state;
    /* 60 digits: mpmath */
    bind_lines(f, LINES("var a = 1", "var b = 2", "a' = -1e6*a + 1e6*b", "b' = a - 2*b"));
    check(&f->system, 3, (const double[]){0.09957448524565454443472, 0.0995743856712688732780418},
          2e-16);
    bind_lines(f, LINES("var a = 1", "var b = 2", "a' = -500000.5*a + 499999.5*b",
                        "b' = 499999.5*a - 500000.5*b"));
    check(&f->system, 3, (const double[]){0.07468060255179591446901, 0.07468060255179591446901},
          5e-14);
    /* what is fast is over, and nothing else is */
    bind_lines(f, LINES("var y = 1", "param k = 1e6", "y' = -k*(y - 3)"));
    check(&f->system, 1e-6, (const double[]){3 - 2 * exp(-1)}, 2e-16);
    check(&f->system, 100, (const double[]){3}, 1e-16);
    /* neither knows of the other */
    bind_lines(f, LINES("var a = 1", "var b = 1e-8", "a' = -1e9*a", "b' = 1e-3*b"));
    check(&f->system, 1000, (const double[]){0, 1e-8 * exp(1)}, 2e-16);
    /* nilpotent: a polynomial */
    bind_lines(f, LINES("var x = 1", "var v = 2", "x' = v", "v' = -9.81"));
    check(&f->system, 1e4, (const double[]){1 + 2e4 - 0.5 * 9.81 * 1e8, 2 - 9.81e4}, 2e-16);
    double y[2], floor[2];
    /* growth beyond double */
    bind_lines(f, LINES("var a = 1", "var b = 1", "a' = 5*a", "b' = -b"));
    for (double t = 1e3; t < 1e8; t *= 10) {
        system_exact(&f->system, 0, f->system.start, t, y, floor);
        assert_true(y[0] == HUGE_VAL && y[1] >= 0 && y[1] < 1e-15);
    }
    system_exact(&f->system, 0, f->system.start, 0, y, floor);
    assert_true(y[0] == 1 && y[1] == 1 && floor[0] < 4 * DBL_EPSILON);
}

/* A change of the coefficients by an ulp moves the solution by no more than the floor, and not by
 * much less. */
static void test_floor(void **state)
{
    struct fixture *f = *state;
    double tightest = 0;
    for (int i = 0; i < 100; i++) {
        struct scene scene;
        struct system system;
        char line[2][100];
        double c[6], t = random_between(0, 30);
        for (int k = 0; k < 6; k++)
            c[k] = random_between(-2, 0.3);
        snprintf(line[0], sizeof line[0], "a'' = s*(%.17g)*a + s*(%.17g)*b + (%.17g)*a'", c[0],
                 c[1], -fabs(c[2]));
        snprintf(line[1], sizeof line[1], "b'' = s*(%.17g)*a + s*(%.17g)*b + (%.17g)*b'", c[1],
                 c[3] - 2, -fabs(c[4]));
        bind_lines(f, LINES("var a = 1", "var b = -0.5", "param s = 1", line[0], line[1]));
        scene = f->scene;
        set(&scene, "s", 1 + 1024 * DBL_EPSILON);
        assert_true(scene_bind(&scene, &system, &f->error));
        double y[4], floor[4], other[4];
        system_exact(&f->system, 0, f->system.start, t, y, floor);
        system_exact(&system, 0, system.start, t, other, NULL);
        for (int k = 0; k < 4; k++) {
            const double change = fabs(other[k] - y[k]) / 1024;
            if (!(change <= 3 * floor[k] + DBL_EPSILON * fabs(y[k])))
                fail_msg("moved by %g, floor %g", change, floor[k]);
            tightest = fmax(tightest, change / floor[k]);
        }
    }
    assert_true(tightest > 0.1);
}

/* From t0 to t1, from there to t2, and back: the same solution. Sixteen variables have one,
 * seventeen none. */
static void test_chain(void **state)
{
    struct fixture *f = *state;
    for (int n = 16; n <= 17; n++) {
        scene_init(&f->scene, NULL);
        char lines[40][64];
        const char *list[41];
        for (int i = 0; i < n; i++) {
            snprintf(lines[i], sizeof lines[i], "var q%d = %d", i, i % 3);
            snprintf(lines[n + i], sizeof lines[i], "q%d' = q%d - 1.%d*q%d + 0.5*q%d", i,
                     (i + 1) % n, i % 10, i, (i + n - 2) % n);
            list[i] = lines[i];
            list[n + i] = lines[n + i];
        }
        list[2 * n] = NULL;
        bind_lines(f, list);
        assert_true(f->system.linear);
        assert_true(system_has_exact(&f->system) == (n == 16));
        if (n > 16)
            break;
        double half[16], twice[16], whole[16], back[16];
        system_exact(&f->system, 0, f->system.start, 1.25, half, NULL);
        system_exact(&f->system, 1.25, half, 3, twice, NULL);
        system_exact(&f->system, 0, f->system.start, 3, whole, NULL);
        system_exact(&f->system, 3, whole, 1.25, back, NULL);
        for (int i = 0; i < n; i++) {
            assert_true(fabs(twice[i] - whole[i]) <= 4e-15 * f->system.scale[i]);
            assert_true(fabs(back[i] - half[i]) <= 2e-14 * f->system.scale[i]);
        }
    }
}

/* ---- derived quantities ---- */

static double derived(const struct scene *scene, const char *name)
{
    const struct row *row = catalog_find(scene_derived(scene), text_of(name));
    return row ? ((const struct derived_row *)(const void *)row)->value(scene).value : NAN;
}

static void test_derived(void **state)
{
    struct fixture *f = *state;
    bind_lines(f, LINES("var y = 1", "param k = 4", "param tau = 7", "y'' = -k*y - 0.5*y' - 2"));
    assert_true(derived(&f->scene, "omega0") == 2 && derived(&f->scene, "zeta") == 0.125);
    assert_true(derived(&f->scene, "equilibrium") == -0.5 &&
                derived(&f->scene, "amplitude") == 1.5);
    assert_null(catalog_find(scene_derived(&f->scene), TEXT("tau"))); /* it is the user's */
    assert_null(catalog_find(scene_derived(&f->scene), TEXT("Re")));
    set(&f->scene, "k", -4);
    assert_true(isnan(derived(&f->scene, "T0")));
    bind_lines(f, LINES("var y = 1", "y'' = -y^3"));
    assert_true(isnan(derived(&f->scene, "T0")) && isnan(derived(&f->scene, "Q")));
    bind_lines(f, LINES("force -5*y - 0.1*v"));
    const struct derived_row *T0 = (const struct derived_row *)(const void *)catalog_find(
        scene_derived(&f->scene), TEXT("T0"));
    assert_true(alike(derived(&f->scene, "omega0"), 10, 0) &&
                alike(derived(&f->scene, "Q"), 20, 0));
    /* the spring does the rest */
    assert_true(scene_set_derived(&f->scene, T0, (struct measured){0.5, 0}, &f->error));
    assert_true(alike(derived(&f->scene, "T0"), 0.5, 0));
    bind_lines(f, LINES("force -k*y")); /* k counts twice: it cannot be told so simply */
    assert_true(alike(derived(&f->scene, "omega0"), sqrt(150), 0));
    assert_false(scene_set_derived(&f->scene, T0, (struct measured){0.5, 0}, &f->error));
    bind_lines(f, LINES("force -5*y^3")); /* that of the spring alone */
    assert_true(alike(derived(&f->scene, "omega0"), sqrt(75), 0));
}

#define WITH_MODELS(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_MODELS(test_like_the_built_in),
        WITH_MODELS(test_not_recognised),
        WITH_MODELS(test_extremes),
        WITH_MODELS(test_normal_modes),
        WITH_MODELS(test_like_the_closed_form),
        WITH_MODELS(test_stiff),
        WITH_MODELS(test_floor),
        WITH_MODELS(test_chain),
        WITH_MODELS(test_derived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
