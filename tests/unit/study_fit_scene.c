/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes fitted to recordings of known truth: values, intervals, starts, held values, refusals. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>

#include "study_testing.h"

#include <stdlib.h>
#include <string.h>

static uint64_t random_state;

static double random_uniform(void) /* [0, 1): splitmix64 */
{
    uint64_t z = (random_state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static double random_normal(void) /* Box & Muller 1958 */
{
    const double u = 1 - random_uniform(), v = random_uniform();
    return sqrt(-2 * log(u)) * cos(6.283185307179586 * v);
}

struct recorded {
    double *t, *y;
    struct series series;
};

/* Every `every`th step of a run of the scene, with noise and an offset. variable: which one is recorded. */
static struct recorded record(const struct scene *scene, int variable, double rate, double span, double noise,
                              double offset)
{
    enum { FINER = 8 };
    struct error error = {0};
    const struct run_settings settings = {.dt = 1 / rate / FINER, .record = {RECORD_EVERY, FINER}};
    struct run *run = run_create(scene, method_named("gauss6"), &settings, span, &error);
    assert_non_null(run);
    while (run_advance(run, &(struct run_target){.t = scene->value[scene_param(scene, "t0")] + span, .steps = -1}, 0, NULL))
        continue;
    const size_t n = trace_count(run->trace);
    struct recorded r = {malloc(n * sizeof(double)), malloc(n * sizeof(double)), {0}};
    assert_true(r.t && r.y && n > 100);
    for (size_t i = 0; i < n; i++) {
        r.t[i] = trace_time(run->trace, i);
        r.y[i] = trace_state(run->trace, i)[variable] + offset + noise * random_normal();
    }
    r.series = (struct series){r.t, r.y, n, system_variable(&run->system, variable).quantity};
    run_destroy(run);
    return r;
}

static void forget(struct recorded *r)
{
    free(r->t);
    free(r->y);
}

struct fitted {
    struct arena arena;
    struct scene_fit fit;
    struct error error;
    bool ok;
};

/* names: "k gamma y0 v0", NULL: the usual ones. */
static struct fitted fit_to(const struct scene *scene, const struct series *series, const char *names, bool robust)
{
    struct fitted f = {.ok = false};
    int place[PARAM_MAX], held[PARAM_MAX], helds, count = 0;
    struct text rest = text_of(names ? names : ""), name;
    if (!names)
        count = scene_fit_usual(scene, place, held, &helds);
    while (names && text_split(&rest, ' ', &name) && name.len) {
        char word[LIMIT_NAME + 1] = "";
        memcpy(word, name.at, name.len);
        place[count] = scene_param(scene, word);
        assert_true(place[count++] >= 0);
    }
    const struct scene_fit_request request = {.scene = scene, .series = series, .free = place, .frees = count,
                                              .offset = true, .robust = robust};
    f.ok = study_fit_scene(&request, &f.arena, &f.fit, &f.error);
    return f;
}

static struct measured fitted_value(const struct fitted *f, const char *name)
{
    for (int j = 0; j < f->fit.curve.parameters; j++)
        if (strcmp(f->fit.name[j], name) == 0)
            return f->fit.curve.value[j];
    fail_msg("%s was not fitted", name);
    return (struct measured){NAN, NAN};
}

static void assert_converged(const struct fitted *f)
{
    if (!f->ok)
        fail_msg("%s", f->error.text);
    if (!f->fit.curve.converged)
        fail_msg("%s", f->fit.curve.said);
}

/* Within four of its standard uncertainties, which are no more than `most` of the value. */
static void assert_found(const struct fitted *f, const char *name, double truth, double most)
{
    const struct measured m = fitted_value(f, name);
    if (!(fabs(m.value - truth) <= 4 * m.uncertainty) || (truth != 0 && !(m.uncertainty <= most * fabs(truth))))
        fail_msg("%s = %.10g +- %.2g, truth %.10g", name, m.value, m.uncertainty, truth);
}

struct case_of {
    const char *preset;
    struct setting truth[10], start[10];
    double rate, span, noise;
    const char *found; /* parameters whose values are compared */
};

static const struct case_of cases[] = {
    {"damped",
     {{"k", 15.11}, {"gamma", 0.024}, {"y0", 0.05}, {"v0", 0.1}},
     {{"gamma", 0.1}, {"y0", 0.01}},
     100,
     40,
     1e-4,
     "k gamma y0 v0"},
    {"drag",
     {{"m", 0.2166}, {"k", 15.1}, {"gamma", 0.012}, {"C", 0.5}, {"y0", 0.051}, {"v0", -0.2}},
     {{"m", 0.2166}},
     100,
     60,
     2e-4,
     "k gamma C y0 v0"},
    {"duffing",
     {{"gamma", 0.02}, {"k3", 0.8}, {"k", 1.1}, {"y0", 1.3}, {"v0", 0.4}},
     {{"k3", 0.4}, {"y0", 1}},
     20,
     120,
     2e-3,
     "k k3 gamma y0 v0"},
    {"pendulum",
     {{"length", 0.83}, {"gamma", 0.03}, {"theta0", 1.8}, {"rate0", 0.3}},
     {{"length", 1}, {"theta0", 1}},
     50,
     60,
     3e-3,
     "length gamma theta0 rate0"},
    {"vanderpol", {{"mu", 1.2}, {"y0", 1.5}}, {{"mu", 1}}, 20, 60, 1e-2, "k mu width y0 v0"},
    {"driven",
     {{"gamma", 0.3}, {"F0", 0.025}, {"phase", 0.4}, {"y0", 0.01}},
     {{"F0", 0.02}},
     50,
     30,
     1e-4,
     "k gamma F0 phase y0 v0"},
};

static void known_truths_are_found(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct case_of *c = &cases[i];
        const struct scene truth = scene_with(c->preset, c->truth);
        struct scene start = scene_with(c->preset, c->start);
        random_state = 5 + i;
        struct recorded r = record(&truth, 0, c->rate, c->span, c->noise, 0.2);
        memset(start.given, 0, sizeof start.given); /* nothing is held */
        struct fitted f = fit_to(&start, &r.series, NULL, true);
        assert_converged(&f);
        struct text rest = text_of(c->found), name;
        while (text_split(&rest, ' ', &name) && name.len) {
            char word[LIMIT_NAME + 1] = "";
            memcpy(word, name.at, name.len);
            assert_found(&f, word, truth.value[scene_param(&truth, word)], 0.2);
        }
        close_to(f.fit.curve.sigma, c->noise, 0.1 * c->noise);
        arena_reset(&f.arena);
        forget(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_truths_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
