/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings of runs of known truth, and scenes fitted to them. */
#pragma once

#include "modules/solving/testing.h"
#include "modules/recording/scene/scene_fit.h"
#include "unit/random_testing.h"

#include <stdlib.h>
#include <string.h>

struct recorded {
    double *t, *y;
    struct series series;
};

/* Every `every`th step of a run of the scene, with noise and an offset. variable: which one is
 * recorded. */
static inline struct recorded record(const struct scene *scene, int variable, double rate,
                                     double span, double noise, double offset)
{
    enum { FINER = 8 };
    struct error error = {0};
    const struct run_settings settings = {.dt = 1 / rate / FINER,
                                          .record = {RECORD_EVERY, FINER, 0}};
    struct run *run = run_create(scene, method_named("gauss6"), &settings, span, &error);
    assert_non_null(run);
    while (run_advance(
        run, &(struct run_target){.t = scene->value[scene_param(scene, "t0")] + span, .steps = -1},
        0, NULL))
        continue;
    const size_t n = trace_count(run->trace);
    struct recorded r = {malloc(n * sizeof(double)), malloc(n * sizeof(double)), {0}};
    assert_true(r.t && r.y && n > 100);
    for (size_t i = 0; i < n; i++) {
        r.t[i] = trace_time(run->trace, i);
        r.y[i] = trace_state(run->trace, i)[variable] + offset + noise * random_normal();
    }
    r.series = (struct series){
        .t = r.t, .y = r.y, .n = n, .quantity = system_variable(&run->system, variable).quantity};
    run_destroy(run);
    return r;
}

static inline void forget(struct recorded *r)
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
static inline struct fitted fit_to(const struct scene *scene, const struct series *series,
                                   const char *names, bool robust)
{
    struct fitted f = {.ok = false};
    int index[PARAM_MAX], fixed[PARAM_MAX], fixed_count, count = 0;
    struct text rest = text_of(names ? names : ""), name;
    if (!names)
        count = scene_fit_usual(scene, index, fixed, &fixed_count);
    while (names && text_split(&rest, ' ', &name) && name.len) {
        char word[LIMIT_NAME + 1] = "";
        memcpy(word, name.data, name.len);
        index[count] = scene_param(scene, word);
        assert_true(index[count++] >= 0);
    }
    const struct scene_fit_request request = {.scene = scene,
                                              .series = series,
                                              .free = index,
                                              .frees = count,
                                              .offset = true,
                                              .robust = robust};
    f.ok = study_fit_scene(&request, &f.arena, &f.fit, &f.error);
    return f;
}

static inline struct measured fitted_value(const struct fitted *f, const char *name)
{
    for (int j = 0; j < f->fit.curve.parameters; j++)
        if (strcmp(f->fit.name[j], name) == 0)
            return f->fit.curve.value[j];
    fail_msg("%s was not fitted", name);
    return (struct measured){NAN, NAN};
}

static inline void assert_converged(const struct fitted *f)
{
    if (!f->ok)
        fail_msg("%s", f->error.text);
    if (!f->fit.curve.converged)
        fail_msg("%s", f->fit.curve.said);
}

/* Within four of its standard uncertainties, which are no more than `max` of the value. */
static inline void assert_found(const struct fitted *f, const char *name, double truth, double max)
{
    const struct measured m = fitted_value(f, name);
    if (!(fabs(m.value - truth) <= 4 * m.uncertainty) ||
        (truth != 0 && !(m.uncertainty <= max * fabs(truth))))
        fail_msg("%s = %.10g +- %.2g, truth %.10g", name, m.value, m.uncertainty, truth);
}
