/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Scenes with dry friction fitted to recordings: are the stated uncertainties those that the values
 * scatter by? The derivatives by the parameters jump where the motion turns, and end where it
 * sticks.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/scene/fit_testing.h"

#define SIGMA 3e-4 /* [m] of the noise */
#define MOST 8     /* parameters that are looked at */

static int repetitions(void)
{
    return is_long() ? 1000 : 16;
}

/* The same motion, recorded again and again: root mean square of (value - truth)/stated, of each
 * parameter. */
static void scatter_of(const struct scene *truth, double span, const char *names,
                       double ratio[MOST], int *count)
{
    struct recorded r = record(truth, 0, 50, span, 0, 0.2);
    double *clean = malloc(r.series.n * sizeof *clean), sum[MOST] = {0};
    assert_non_null(clean);
    memcpy(clean, r.y, r.series.n * sizeof *clean);
    random_state = 127;
    for (int k = 0; k < repetitions(); k++) {
        for (size_t i = 0; i < r.series.n; i++)
            r.y[i] = clean[i] + SIGMA * random_normal();
        struct fitted f = fit_to(truth, &r.series, names, false);
        assert_converged(&f);
        *count = f.fit.curve.parameters - 1; /* without the offset */
        assert_true(*count <= MOST);
        for (int j = 0; j < *count; j++) {
            const struct measured m = f.fit.curve.value[j];
            const double true_value = truth->value[f.fit.index[j]];
            sum[j] += pow((m.value - true_value) / m.uncertainty, 2);
        }
        arena_reset(&f.arena);
    }
    for (int j = 0; j < *count; j++)
        ratio[j] = 1 / sqrt(sum[j] / repetitions());
    free(clean);
    forget(&r);
}

/* Within 10 %, or what chance leaves of so few (3 standard deviations of a standard deviation). */
TEST(uncertainties_are_the_scatter)
{
    const struct {
        const char *preset, *names;
        const struct setting *settings;
        double span;
    } cases[] = {
        {"spring", "k friction y0 v0",
         SETTINGS({"m", 0.2}, {"k", 15}, {"y0", 0.08}, {"friction", 0.004}), 10},
        {"spring", "k gamma friction y0 v0",
         SETTINGS({"m", 0.2}, {"k", 15}, {"y0", 0.08}, {"gamma", 0.05}, {"friction", 0.01}), 10},
        {"spring", "k friction y0",
         SETTINGS({"m", 0.2}, {"k", 15}, {"y0", 0.08}, {"friction", 0.03}), 14}, /* sticks */
    };
    const double max = fmax(0.1, 3 / sqrt(2.0 * repetitions()));
    for (size_t i = is_long() ? 0 : 1; i < COUNT_OF(cases);
         i++) { /* the first is part of the second */
        const struct scene truth = scene_with(cases[i].preset, cases[i].settings);
        double ratio[MOST];
        int count = 0;
        scatter_of(&truth, cases[i].span, cases[i].names, ratio, &count);
        for (int j = 0; j < count; j++) {
            print_message("%s: parameter %d of '%s': stated over scatter %.3f\n", cases[i].preset,
                          j + 1, cases[i].names, ratio[j]);
            assert_true(fabs(log(ratio[j])) < max);
        }
    }
}

RUN_TESTS(NULL, NULL)
