/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Wild echoes are rejected as such and never taken for flat tops, which are still found. */
#include <string.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

static bool warns_of_clipping(const struct fit *fit)
{
    for (int i = 0; i < fit->warnings; i++)
        if (strstr(fit->warning[i], "clipped"))
            return true;
    return false;
}

static struct truth swing(void)
{
    struct truth truth = {.amplitude = 40,
                          .offset = 300,
                          .period = random_between(0.5, 2),
                          .rate = random_between(30, 100),
                          .noise = random_between(0.2, 1),
                          .phase = random_between(-3, 3)};
    truth.span = truth.period * random_between(5, 15);
    truth.gamma = random_between(0.3, 3) / truth.span;
    return truth;
}

TEST(wild_echoes_are_no_flat_tops)
{
    static const double ranges[][2] = {{0, 400}, {310, 800}, {310, 800}, {320, 2000}};
    const int runs = is_long() ? 1000 : 120;
    int judged = 0, covered = 0;
    double worst = 0;
    random_state = 141;
    for (int run = 0; run < runs; run++) {
        const struct truth truth = swing();
        const double share = random_between(0.05, 0.11),
                     *range = ranges[run % (int)COUNT_OF(ranges)];
        struct synthetic s = synthetic_make(&truth);
        struct error error = {0};
        struct fit fit;
        for (size_t i = 0; i < s.series.n; i++)
            if (random_uniform() < share)
                s.y[i] = random_between(range[0], range[1]);
        if (fit_named("damped", &s.series, &fit, &error)) {
            const double off = fabs(fit.gamma.value - truth.gamma) / fit.gamma.uncertainty;
            if (warns_of_clipping(&fit))
                fail_msg("run %d: echoes from %g to %g are called flat tops", run, range[0],
                         range[1]);
            judged++;
            covered += off <= 1.96;
            worst = fmax(worst, off);
        }
        synthetic_free(&s);
    }
    print_message("%d of %d covered, worst %.1f, %d refused\n", covered, judged, worst,
                  runs - judged);
    assert_true(judged >= 0.9 * runs && covered >= 0.9 * judged && worst < 5);
}

TEST(flat_tops_are_found)
{
    const int runs = is_long() ? 600 : 60;
    int found = 0, covered = 0, refused = 0;
    random_state = 142;
    for (int run = 0; run < runs; run++) {
        struct truth truth = swing();
        truth.gamma = random_between(0.1, 0.3) / truth.span;
        truth.clip =
            random_between(0.85, 0.97) * truth.amplitude * exp(-0.5 * truth.gamma * truth.span);
        struct synthetic s = synthetic_make(&truth);
        struct error error = {0};
        struct fit fit;
        if (!fit_named("damped", &s.series, &fit, &error)) {
            found += strstr(error.text, "clipped") != NULL;
            refused++;
        } else {
            found += warns_of_clipping(&fit);
            covered +=
                fabs(fit.amplitude.value - truth.amplitude) <= 2.6 * fit.amplitude.uncertainty;
        }
        synthetic_free(&s);
    }
    print_message("flat tops found in %d of %d, %d covered, %d refused\n", found, runs, covered,
                  refused);
    assert_true(found >= 0.97 * runs && covered >= 0.9 * (runs - refused) && refused < 0.3 * runs);
}

/* Ceilings of long recordings are looked for in some of their rows first. */
TEST(flat_tops_are_found_in_many_rows)
{
    const int runs = is_long() ? 40 : 6;
    random_state = 31;
    for (int run = 0; run < runs; run++) {
        struct truth truth = swing();
        truth.rate = 70000 / truth.span;
        truth.gamma = random_between(0.1, 0.3) / truth.span;
        truth.clip =
            random_between(0.9, 0.97) * truth.amplitude * exp(-0.5 * truth.gamma * truth.span);
        struct synthetic s = synthetic_make(&truth);
        struct error error = {0};
        struct fit fit;
        assert_true(fit_named("damped", &s.series, &fit, &error));
        assert_true(warns_of_clipping(&fit));
        assert_true(fabs(fit.amplitude.value - truth.amplitude) < 4 * fit.amplitude.uncertainty);
        assert_true(fabs(fit.gamma.value - truth.gamma) < 4 * fit.gamma.uncertainty);
        synthetic_free(&s);
    }
}

RUN_TESTS(NULL, NULL)
