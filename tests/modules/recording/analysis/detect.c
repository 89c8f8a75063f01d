/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What is an oscillation and what is not: synthetic recordings with a known truth. Things that do
 * not oscillate are never fitted as converged; clean oscillations are found with their period,
 * whatever drifts.
 */
#include <stdio.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/detect_recordings.h"

static int runs(void)
{
    return is_long() ? 60 : 5;
}

TEST(what_does_not_oscillate_is_refused)
{
    int fitted = 0;
    random_state = 61;
    for (size_t k = 0; k < COUNT_OF(still); k++) {
        int here = 0;
        for (int run = 0; run < runs(); run++) {
            struct drawn d = still[k].draw();
            const struct series series = {
                .t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
            struct fit fit;
            struct period period;
            struct arena arena = {0};
            struct error error = {0}, other = {0};
            const bool fitted_so = fit_named("damped", &series, &fit, &error);
            const bool measured_so = series_period(&series, &arena, &period, &other);
            here += fitted_so || measured_so;
            if (!fitted_so)
                assert_true(error.text[0] != 0);
            if (measured_so)
                print_message("%s has a period of %g s by %s\n", still[k].name, period.period.value,
                              period.how);
            arena_reset(&arena);
            free(d.t);
            free(d.y);
        }
        if (here > 0)
            print_message("%s: %d of %d fitted as an oscillation\n", still[k].name, here, runs());
        fitted += here;
    }
    assert_int_equal(fitted, 0);
}

TEST(every_clean_oscillation_is_found)
{
    int missed = 0, all = 0;
    random_state = 62;
    for (size_t k = 0; k < COUNT_OF(moving); k++) {
        int here = 0;
        char reason[200] = "";
        for (int run = 0; run < runs(); run++) {
            struct drawn d = moving[k].draw();
            const struct series series = {
                .t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
            struct arena arena = {0};
            struct overview o;
            series_overview(&series, &arena, &o);
            const bool found = o.oscillates && fabs(o.period / d.period - 1) < 0.03;
            if (!found)
                snprintf(reason, sizeof reason, "T %g for %g (%zu samples, %g periods), %.120s",
                         o.period, d.period, d.n, d.span / d.period, o.oscillates ? "" : o.reason);
            here += !found;
            all++;
            arena_reset(&arena);
            free(d.t);
            free(d.y);
        }
        if (here > 0)
            print_message("%s: %d of %d not found, the last: %s\n", moving[k].name, here, runs(),
                          reason);
        missed += here;
    }
    print_message("%d of %d oscillations missed\n", missed, all);
    assert_true(50 * missed <= all);
}

/* A fit that uses less than four fifths of the samples says so instead of "converged". */
TEST(no_fit_that_discards_much_is_called_converged)
{
    random_state = 63;
    for (size_t k = 0; k < COUNT_OF(moving); k++)
        for (int run = 0; run < runs() / 4; run++) {
            struct drawn d = moving[k].draw();
            const struct series series = {
                .t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
            struct fit fit;
            struct error error = {0};
            if (fit_named("damped", &series, &fit, &error) && fit.converged &&
                5 * fit.rejected > d.n)
                fail_msg("%s: %zu of %zu rejected, converged", moving[k].name, fit.rejected, d.n);
            free(d.t);
            free(d.y);
        }
}

RUN_TESTS(NULL, NULL)
