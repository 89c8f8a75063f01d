/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Kernels of typed scenes: the bits of the general step for each method and size, with and without
 * machine code. */
#include "unit/run/fixture.h"
#include "unit/scene/typing.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

/* Takes the place of the C library's: where a page cannot be made executable there is no machine
 * code. */
static bool refuses;
static int allowed, refused;

int mprotect(void *page, size_t size, int protection)
{
    if (protection & PROT_EXEC)
        ++*(refuses ? &refused : &allowed);
    if (refuses && protection & PROT_EXEC) {
        errno = EACCES;
        return -1;
    }
    return (int)syscall(SYS_mprotect, page, size, protection);
}

/* preset: what the lines are typed on top of, NULL: nothing. */
struct typed_case {
    const char *preset, *lines;
};

#define CHAIN(a, b, c)                                                                             \
    ";" #b "'' = k/m*(" #a " - 2*" #b " + " #c ") - 2*zeta*sqrt(k/m)*" #b "' + if(t < 1, F0/m, 0)"
static const struct typed_case cases[] = {
    /* one coordinate: of all kinds of forces, of some, of one */
    {NULL,
     "var x = 1;param k = 4;param c = 0.1;param F0 = 0.3;x'' = -k*x - c*x'*abs(x') + F0*cos(2*t)"},
    {NULL, "var x = 1;param k = 4;param m = 2;x'' = -k/m*x - k/m*x^3 + sin(t) - 0.2*x';potential "
           "k*x^2/2 + k*x^4/4"},
    {NULL, "var x = 1;param g = 9.81;param l = 0.5;x'' = -g/l*sin(x)"},
    {NULL, "var x = 1;var x' = 2;param c = 0.3;x'' = -c*x'*abs(x')"},
    {NULL, "var x = 1;param mu = 2;param z = 0;x'' = mu*(1 - x^2)*x' - x + z*exp(1e4*t)/x"},
    /* infinite, NaN, 0*x and -0: poles, roots of what becomes negative, overflow */
    {NULL, "var x = 1;x'' = -1/x^3 - 0*x'"},
    {NULL, "var x = 0.1;x'' = -sqrt(x)"},
    {NULL, "var x = 1;x'' = x^5 + 1e300*x*(x - x)"},
    {NULL, "var x = 0;var x' = 1;x'' = if(x > 0.2, log(x - 0.5), -0*x)"},
    {NULL, "var x = 0;x'' = -0*x + (x < 0)*1e3"},
    /* a plane */
    {NULL, "var x = 0.5;var y = 0;var y' = 1.7;param k = 1;x'' = -k*x/(x^2 + y^2)^1.5;y'' = "
           "-k*y/(x^2 + y^2)^1.5"},
    {NULL, "var x = 0;var y = 0;var x' = 0.24;var y' = 0.32;x'' = -(x + 2*x*y);y'' = -(y + (x^2 - "
           "y^2)) - 0.01*y'"},
    {NULL, "var x = 0.1;var y = 0;x'' = -x + 0.1*cos(t) - 0.1*x';y'' = -2*y - x*sin(t);potential "
           "x^2/2 + y^2"},
    /* first order: one to four */
    {NULL, "var x = 1;param tau = 2;x' = -x/tau + sin(t)"},
    {NULL, "var y1 = 2;var y2 = 0;param mu = 3;y1' = y2;y2' = mu*(1 - y1^2)*y2 - y1 + sin(t)"},
    {NULL, "var x = 1;var y = 1;x' = y;y' = x"},
    {NULL, "var x = 1;var y = 1;var z = 1;param s = 10;x' = s*(y - x);y' = x*(28 - z) - y;z' = x*y "
           "- 8/3*z"},
    {NULL, "var x = 2;var y = 1;var z = 0.5;x' = -x^2;y' = sqrt(z);z' = -x"},
    {NULL,
     "var a = 1;var b = 2;var c = 3;var d = 4;a' = b - a;b' = c*a - b;c' = sin(d);d' = -a*b*c*d"},
    /* three masses */
    {NULL,
     "var x = 1;var y = 0;var z = 0;param k = 3;param m = 2;param zeta = 0.1;param F0 = 0" CHAIN(
         z, x, y) CHAIN(x, y, z) CHAIN(y, z, x)},
    /* on top of built-in scenes */
    {"damped", "force -40*y^3 + 0.1*cos(2*t)"},
    {"drag", "force -40*y^3 - 0.1*v"},
    {"kepler", "force -0.01*x"},
    {"pendulum", "force 0.1*sin(3*t) - 0.01*omega^3"},
};

static void type_case(const struct typed_case *c, struct typed_models *models, struct scene *scene)
{
    struct text rest = text_of(c->lines), line;
    struct error error = {0};
    scene_init(scene, c->preset ? preset_by_name(text_of(c->preset)) : NULL);
    while (text_split(&rest, ';', &line)) {
        const struct typed_line typed = typing_line(text_trim(line));
        const struct model *model = typed_add(models, scene->model, &typed, &error);
        if (!model)
            fail_msg("%.*s: %s", (int)line.len, line.data, error.text);
        scene_remodel(scene, model);
    }
}

/* NULL: the method or the variant is refused. tol 0: fixed steps */
static struct run *run_of(const struct scene *scene, const struct method *by, enum drag drag,
                          double tol, enum kernel kernel)
{
    const struct run_settings settings = {
        .dt = 0.0123, .tol = tol, .drag = drag, .kernel = kernel, .record = {RECORD_ALL, 1, 0}};
    struct error error;
    return run_create(scene, by, &settings, HUGE_VAL, &error);
}

enum { WAYS = 3, STEPS = 700 };

/*
 * Kernels with machine code in pieces, without, and the general step without: all the same. True:
 * there are kernels. A kernel finds out a little later that the motion is not finite: what it
 * counts is more then.
 */
static bool same_ways(const struct typed_case *c, const struct method *by, enum drag drag,
                      double tol)
{
    struct run *run[WAYS];
    struct typed_models *models[WAYS];
    bool there = true;
    for (int way = 0; way < WAYS; way++) {
        struct scene scene;
        struct error error;
        refuses = way > 0;
        models[way] = typed_create(&error);
        type_case(c, models[way], &scene);
        run[way] = run_of(&scene, by, drag, tol, way < 2 ? KERNEL_SPECIALISED : KERNEL_GENERAL);
        there = there && run[way];
        for (int64_t piece = 1;
             run[way] && run[way]->steps < STEPS && run[way]->stop != STOP_DIVERGED &&
             run[way]->stop != STOP_STALLED && (way == 0 || piece == 1);
             piece = piece * 5 % 97)
            go_steps(run[way],
                     way == 0 && piece < STEPS - run[way]->steps ? piece : STEPS - run[way]->steps);
    }
    refuses = false;
    if (there)
        there = tol > 0 ? method_step_kernel(by, &run[0]->system) != NULL
                        : method_kernel(by, &run[0]->system, run[0]->settings.drag) != NULL;
    for (int way = 1; way < WAYS; way++) {
        assert_true(!run[0] == !run[way]);
        if (!run[0])
            continue;
        if (run[0]->steps != run[way]->steps || run[0]->stop != run[way]->stop ||
            memcmp(run[0]->y, run[way]->y, sizeof run[0]->y) != 0)
            fail_msg("%s, %s, drag %d, tol %g, way %d: %lld and %lld steps, %.17g and %.17g",
                     c->lines, by->row.name, (int)drag, tol, way, (long long)run[0]->steps,
                     (long long)run[way]->steps, run[0]->y[0], run[way]->y[0]);
        assert_same_trace(run[0], run[way]);
        if (run[way]->stop != STOP_DIVERGED)
            assert_memory_equal(&run[0]->cost, &run[way]->cost, sizeof run[0]->cost);
    }
    for (int way = 0; way < WAYS; way++) {
        run_destroy(run[way]);
        typed_destroy(models[way]);
    }
    return there;
}

TEST(test_fixed_steps)
{
    int count = 0, splittings = 0;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        int here = 0;
        for (size_t m = 0; m < method_catalog.count; m++) {
            const struct method *by = method_at(m);
            for (enum drag drag = DRAG_DEFAULT; (by->tableau || by->splitting) && drag < DRAG_COUNT;
                 drag++) {
                const bool there = same_ways(&cases[i], by, drag, 0);
                here += there;
                splittings += there && by->splitting;
            }
        }
        if (here < 8)
            fail_msg("%s: %d kernels", cases[i].lines, here);
        count += here;
    }
    print_message("# %d combinations, %d of them with splittings\n", count, splittings);
    assert_true(splittings > 200);
}

/* Every adaptive method with a tableau has a kernel for each case, whose steps equal those of the
 * general code bit by bit. */
TEST(test_adaptive_steps)
{
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        for (size_t m = 0; m < method_catalog.count; m++) {
            const struct method *by = method_at(m);
            if (by->tableau && by->flags & METHOD_ADAPTIVE)
                if (!same_ways(&cases[i], by, DRAG_DEFAULT, 1e-7))
                    fail_msg("%s: no kernel for %s", cases[i].lines, by->row.name);
        }
}

/* Many variables, some frames too large for the small kernels. */
TEST(test_many_variables)
{
    struct buffer lines = {0};
    for (int i = 0; i < 40; i++)
        buffer_format(&lines, "%svar x%d = %s", i ? ";" : "", i, i == 7 ? "8.01" : "8");
    buffer_format(&lines, ";param F = 8");
    for (int i = 0; i < 40; i++)
        buffer_format(&lines, ";x%d' = (x%d - x%d)*x%d - x%d + F", i, (i + 1) % 40, (i + 38) % 40,
                      (i + 39) % 40, i);
    const struct typed_case ring = {NULL, lines.data};
    assert_true(same_ways(&ring, method_named("rk4"), DRAG_DEFAULT, 0));
    assert_true(same_ways(&ring, method_named("dopri5"), DRAG_DEFAULT, 0));
    assert_true(same_ways(&ring, method_named("dop853"), DRAG_DEFAULT, 1e-6));
    lines.len = 0;
    buffer_format(&lines, "var x = 0.3;x'' = -x");
    for (int i = 0; i < 600; i++)
        buffer_format(&lines, " - %d.5e-6*x^%d", i, 1 + i % 7);
    const struct typed_case sum = {NULL, lines.data};
    assert_true(same_ways(&sum, method_named("rk4"), DRAG_DEFAULT, 0));
    assert_true(same_ways(&sum, method_named("verlet"), DRAG_DEFAULT, 0));
    assert_true(same_ways(&sum, method_named("tsit5"), DRAG_DEFAULT, 1e-7));
    buffer_free(&lines);
}

/* What the tests before have run: the first way with machine code, the others without. */
TEST(test_refusing)
{
#if defined(__x86_64__) && defined(__linux__)
    assert_true(allowed > 100 && refused > allowed);
#else
    skip();
#endif
}

RUN_TESTS(NULL, NULL)
