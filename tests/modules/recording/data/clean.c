/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What cleaning finds in recordings whose faults are known, and that it finds nothing where nothing
 * is wrong. */
#include "long_form.h"
#include "modules/recording/data/fixture.h"
#include "unit/random_testing.h"

#define ROWS_MAX 8000
#define PERIOD 0.7226 /* [s] */

struct made {
    size_t n;
    double rate, amplitude, gamma, noise; /* [Hz] [cm] [1/s] [cm] */
    double y[ROWS_MAX];                   /* [cm] NAN: an empty cell */
    double t[ROWS_MAX];
    uint64_t seed;
};

static void make(struct made *m)
{
    for (size_t i = 0; i < m->n; i++) {
        m->t[i] = (double)i / m->rate;
        m->y[i] = 21.6 +
                  m->amplitude * exp(-0.5 * m->gamma * m->t[i]) *
                      cos(6.283185307179586 / PERIOD * m->t[i] + 1) +
                  m->noise * normal_from(&m->seed);
    }
}

/* As the motion sensor prints it, to 0.001 cm, unless told otherwise. */
static struct recording *recorded(const struct made *m, double step)
{
    struct buffer text = {0};
    buffer_put(&text, TEXT("Time (s)\tDistance (cm)\n"));
    for (size_t i = 0; i < m->n; i++)
        if (isnan(m->y[i]))
            buffer_format(&text, "%.4f\t\n", m->t[i]);
        else
            buffer_format(&text, "%.4f\t%.3f\n", m->t[i], step * nearbyint(m->y[i] / step));
    buffer_char(&text, '\0');
    assert_false(text.failed);
    struct recording *recording = fixture_good(text.data, "");
    buffer_free(&text);
    return recording;
}

static const struct findings *inspected(struct recording *recording)
{
    struct error error;
    assert_true(recording_inspect(recording, PERIOD, "", &error));
    return recording->findings;
}

static void assert_only(const struct findings *f, int expected, const char *what)
{
    for (int k = 0; k < FINDINGS; k++)
        if (k != expected && f->finding[k].count > 0)
            fail_msg("%s: %s found in %zu samples at %g s, size %g", what,
                     catalog_row(&finding_catalog, (size_t)k)->name, f->finding[k].count,
                     f->finding[k].first[0], f->finding[k].size);
}

TEST(nothing_is_found_where_nothing_is_wrong)
{
    static const double noises[] = {0, 0.01, 0.03, 0.1, 0.3}, rates[] = {20, 60, 125},
                        gammas[] = {0, 0.03, 0.3};
    static const double seconds[] = {4, 10, 60};
    static struct made m;
    const bool full = is_long();
    int tried = 0;
    for (int repeat = 0; repeat < (full ? 20 : 1); repeat++)
        for (size_t i = 0;
             i < COUNT_OF(noises) * COUNT_OF(rates) * COUNT_OF(gammas) * COUNT_OF(seconds); i++) {
            m = (struct made){.noise = noises[i % 5],
                              .rate = rates[i / 5 % 3],
                              .gamma = gammas[i / 15 % 3],
                              .amplitude = 5.2,
                              .seed = 1000 + i + 1000 * (uint64_t)repeat};
            m.n = (size_t)(m.rate * seconds[i / 45]);
            if (m.gamma * seconds[i / 45] > 6) /* gone before the end */
                continue;
            char what[100];
            snprintf(what, sizeof what, "noise %g cm, %g Hz, gamma %g, %g s", m.noise, m.rate,
                     m.gamma, seconds[i / 45]);
            make(&m);
            struct recording *recording = recorded(&m, 0.001);
            assert_only(inspected(recording), -1, what);
            recording_destroy(recording);
            tried++;
        }
    print_message("%d recordings\n", tried);
}

TEST(bad_echoes_are_masked_and_nothing_else)
{
    static struct made m;
    static bool bad[ROWS_MAX];
    m = (struct made){
        .n = 3000, .rate = 100, .amplitude = 5.2, .gamma = 0.02, .noise = 0.02, .seed = 7};
    make(&m);
    memset(bad, 0, sizeof bad);
    size_t spikes = 0, shoulders = 0;
    for (size_t i = 50; i + 300 < m.n; i += 97) {
        const bool shoulder = i % 5 == 0;
        for (size_t k = i; k < i + (shoulder ? 6 : 1); k++) {
            m.y[k] += shoulder ? 0.6 : 2.5;
            bad[k] = true;
        }
        *(shoulder ? &shoulders : &spikes) += shoulder ? 6 : 1;
    }
    struct recording *recording = recorded(&m, 0.001);
    const struct findings *f = inspected(recording);
    assert_int_equal(f->finding[FINDING_SPIKES].count, spikes);
    assert_int_equal(f->finding[FINDING_SHOULDERS].count, shoulders);
    assert_int_equal(f->finding[FINDING_SHOULDERS].stretches, shoulders / 6);
    assert_true(near(f->finding[FINDING_SPIKES].size, 0.025, 0.001) &&
                near(f->finding[FINDING_SPIKES].first[0], 1.47, 1e-9));
    for (size_t i = 0; i < m.n; i++)
        assert_int_equal(f->mask[i] != 0, bad[i]);

    /* Masked samples are left out, values are as they were, and everything comes back. */
    struct arena arena = {0};
    struct series series;
    struct error error;
    assert_true(recording_series(recording, &arena, 1, &series, &error));
    assert_int_equal(series.n, m.n);
    recording_clean(recording);
    assert_true(recording_series(recording, &arena, 1, &series, &error));
    assert_int_equal(series.n, m.n - spikes - shoulders);
    for (size_t i = 0, row = 0; i < series.n; i++) {
        while (bad[row])
            row++;
        assert_true(near(100 * series.y[i], m.y[row++], 0.00051));
    }
    struct buffer text = {0};
    recording_describe_masked(recording, &text);
    buffer_char(&text, '\0');
    assert_non_null(strstr(text.data, "of 3000 samples masked"));
    buffer_free(&text);
    recording_restore(recording);
    assert_true(recording_series(recording, &arena, 1, &series, &error));
    assert_int_equal(series.n, m.n);
    arena_reset(&arena);
    recording_destroy(recording);
}

TEST(flat_tops_are_found_and_kept)
{
    static const double noises[] = {0, 0.02, 0.05};
    static struct made m;
    for (size_t k = 0; k < COUNT_OF(noises); k++) {
        m = (struct made){
            .n = 1500, .rate = 100, .amplitude = 5.2, .gamma = 0.01, .noise = 0, .seed = 3 + k};
        make(&m);
        size_t clipped = 0;
        for (size_t i = 0; i < m.n; i++) {
            clipped += m.y[i] > 25;
            m.y[i] = fmin(m.y[i], 25) + noises[k] * normal_from(&m.seed);
        }
        struct recording *recording = recorded(&m, 0.001);
        const struct findings *f = inspected(recording);
        if (!near((double)f->finding[FINDING_CLIPPED].count, (double)clipped,
                  0.35 * (double)clipped) ||
            !near(f->finding[FINDING_CLIPPED].size, 0.25, 0.0015) || f->masked > 0)
            fail_msg("noise %g: %zu of %zu clipped at %g m, %zu masked", noises[k],
                     f->finding[FINDING_CLIPPED].count, clipped, f->finding[FINDING_CLIPPED].size,
                     f->masked);
        recording_destroy(recording);
    }
}

/* Seven rows a period in noise of a third of the amplitude and more, of which half are at rest. */
TEST(noise_is_no_flat_top)
{
    static struct made m;
    for (size_t k = 0; k < 24; k++) {
        m = (struct made){.n = 4000,
                          .rate = 7 / PERIOD,
                          .amplitude = 5,
                          .gamma = k % 2 ? 0.02 : 0,
                          .noise = 1.5 + 0.5 * (double)(k % 3),
                          .seed = 21 + k};
        make(&m);
        for (size_t i = 0; i < m.n / 2 && k % 4 == 3; i++)
            m.y[i] = 21.6 + m.noise * normal_from(&m.seed);
        struct recording *recording = recorded(&m, 0.001);
        const struct findings *f = inspected(recording);
        if (f->finding[FINDING_CLIPPED].count > 0)
            fail_msg("%zu: %zu of %zu clipped at %g m", k, f->finding[FINDING_CLIPPED].count, m.n,
                     f->finding[FINDING_CLIPPED].size);
        recording_destroy(recording);
    }
}

TEST(a_stuck_sensor_is_masked)
{
    static struct made m;
    m = (struct made){
        .n = 2000, .rate = 100, .amplitude = 5.2, .gamma = 0.02, .noise = 0.02, .seed = 5};
    make(&m);
    for (size_t i = 700; i < 712; i++)
        m.y[i] = m.y[699];
    for (size_t i = 1200; i < 1300; i++)
        m.y[i] = m.y[1199];
    struct recording *recording = recorded(&m, 0.001);
    const struct findings *f = inspected(recording);
    assert_int_equal(f->finding[FINDING_STUCK].count, 112);
    assert_int_equal(f->finding[FINDING_STUCK].stretches, 2);
    assert_true(near(f->finding[FINDING_STUCK].first[0], 7, 1e-9) &&
                near(f->finding[FINDING_STUCK].first[1], 12, 1e-9));
    assert_only(f, FINDING_STUCK, "stuck");
    recording_destroy(recording);
}

/* In steps of 1 cm equal values about a turning point are the motion; the rows lie where one
 * stretch meets the next. */
TEST(coarse_steps_are_not_stuck)
{
    for (size_t periods = 20; periods < 97; periods += 7) {
        struct made m = {
            .n = 73 * periods + 1, .rate = 100, .amplitude = 6, .noise = 0.05, .seed = periods};
        make(&m);
        struct recording *recording = recorded(&m, 1);
        const struct findings *f = inspected(recording);
        assert_int_equal(f->finding[FINDING_STUCK].count, 0);
        assert_int_equal(f->masked, 0);
        recording_destroy(recording);
    }
}

TEST(steps_gaps_and_empty_cells_are_said)
{
    static struct made m;
    m = (struct made){
        .n = 1500, .rate = 50, .amplitude = 5.2, .gamma = 0.02, .noise = 0.02, .seed = 9};
    make(&m);
    /* it went on meanwhile */
    for (size_t i = 500; i < m.n; i++)
        m.t[i] += 0.4;
    m.y[100] = m.y[101] = m.y[900] = NAN;
    for (size_t i = 0; i < m.n; i++)
        if (!isnan(m.y[i]))
            m.y[i] = 21.6 + 5.2 * exp(-0.01 * m.t[i]) * cos(6.283185307179586 / PERIOD * m.t[i]);
    struct recording *recording = recorded(&m, 1);
    const struct findings *f = inspected(recording);
    assert_true(near(f->finding[FINDING_QUANTISED].size, 0.01, 1e-9));
    assert_int_equal(f->finding[FINDING_GAPS].count, 1);
    assert_true(near(f->finding[FINDING_GAPS].size, 0.42, 1e-9) &&
                near(f->finding[FINDING_GAPS].first[0], 9.98, 1e-9));
    assert_int_equal(f->finding[FINDING_MISSING].count, 3);
    assert_int_equal(f->finding[FINDING_MISSING].stretches, 2);
    assert_int_equal(f->masked, 0);
    assert_int_equal(f->finding[FINDING_START].count + f->finding[FINDING_END].count, 0);
    recording_destroy(recording);

    m.n = 60;
    m.t[20] = m.t[19];
    m.t[40] = m.t[38] - 0.01;
    recording = recorded(&m, 0.001);
    f = inspected(recording);
    assert_int_equal(f->finding[FINDING_REPEATED].count, 1);
    assert_int_equal(f->finding[FINDING_BACKWARD].count, 1);
    recording_destroy(recording);
}

/* Held at the side for three seconds, released, and caught after 25 s. */
/* Strong decays without noise, and flat tops, in any phase: the fits at the ends are one-sided, or
 * have few samples, and that is no hand. */
TEST(ends_of_exact_motions_are_theirs)
{
    static struct made m;
    for (int i = 0; i < 200; i++) {
        const bool flat = i % 3 == 2;
        uint64_t seed = (uint64_t)i;
        m = (struct made){.n = 1000, .rate = 20 + 10 * (double)(i % 9), .seed = seed};
        const double phase = 6.283185307179586 * uniform_from(&seed);
        const double gamma = flat ? 0 : 8e-3 * m.rate * uniform_from(&seed); /* to e^-4 */
        for (size_t k = 0; k < m.n; k++) {
            m.t[k] = (double)k / m.rate;
            m.y[k] =
                30 * exp(-0.5 * gamma * m.t[k]) * cos(6.283185307179586 / PERIOD * m.t[k] + phase);
            m.y[k] = flat ? fmax(-24, fmin(m.y[k], 24)) : m.y[k];
        }
        struct recording *recording = recorded(&m, 1e-3);
        const struct findings *f = inspected(recording);
        if (f->finding[FINDING_START].count + f->finding[FINDING_END].count > 0)
            fail_msg("motion %d: window %g .. %g s", i, f->window[0], f->window[1]);
        recording_destroy(recording);
    }
}

/* Held at the ceiling of the sensor until it is let go; a gap later leaves out periods. */
TEST(a_clipped_rest_is_found_beside_a_gap)
{
    static struct made m;
    for (int i = 0; i < 20; i++) {
        uint64_t seed = 100 + (uint64_t)i;
        const double rate = 60, released = (2.2 + 0.3 * uniform_from(&seed)) * PERIOD,
                     gap = (8 + 4 * uniform_from(&seed)) * PERIOD;
        m = (struct made){.rate = rate, .seed = seed};
        for (size_t k = 0; k < 20 * (size_t)(rate * PERIOD); k++) {
            const double t = (double)k / rate, since = fmax(t - released, 0);
            if (t > gap && t < gap + 4.5 * PERIOD)
                continue;
            const double y = 10 * exp(-0.02 * since) * cos(6.283185307179586 / PERIOD * since);
            m.t[m.n] = t;
            m.y[m.n++] = fmin(y + 0.1 * normal_from(&m.seed), 7);
        }
        struct recording *recording = recorded(&m, 1e-3);
        const struct findings *f = inspected(recording);
        if (!(f->window[0] > released - PERIOD && f->window[0] < released + 2 * PERIOD))
            fail_msg("rest %d, until %g s: window %g .. %g s", i, released, f->window[0],
                     f->window[1]);
        recording_destroy(recording);
    }
}

TEST(rest_and_release_give_a_window)
{
    static struct made m;
    m = (struct made){
        .n = 3000, .rate = 100, .amplitude = 5.2, .gamma = 0.02, .noise = 0, .seed = 11};
    make(&m);
    for (size_t i = 0; i < m.n; i++) {
        const double s = m.t[i] - 3,
                     swing = 5.2 * exp(-0.01 * s) * cos(6.283185307179586 / PERIOD * s);
        m.y[i] = 21.6 + (s < 0 ? 5.2 : m.t[i] < 25 ? swing : 0) + 0.02 * normal_from(&m.seed);
    }
    struct recording *recording = recorded(&m, 0.001);
    const struct findings *f = inspected(recording);
    if (!(f->window[0] >= 2.9 && f->window[0] < 3 + 2 * PERIOD && f->window[1] > 25 - 2 * PERIOD &&
          f->window[1] <= 25.1) ||
        f->masked > 0)
        fail_msg("window %g..%g, %zu masked", f->window[0], f->window[1], f->masked);
    recording_clean(recording);
    assert_true(recording->window[0] == f->window[0] && recording->window[1] == f->window[1]);
    struct error error;
    recording_restore(recording);
    assert_true(recording_window(recording, 5, 8, &error)); /* somebody's own choice stays */
    recording_clean(recording);
    assert_true(recording->window[0] == 5 && recording->window[1] == 8);
    recording_destroy(recording);
}

TEST(sway_is_said_and_left)
{
    static struct made m;
    m = (struct made){
        .n = 3000, .rate = 100, .amplitude = 5.2, .gamma = 0.02, .noise = 0.02, .seed = 13};
    make(&m);
    for (size_t i = 0; i < m.n; i++)
        m.y[i] = 21.6 + (m.y[i] - 21.6) * (1 + 0.06 * sin(6.283185307179586 / 5 * m.t[i]));
    struct recording *recording = recorded(&m, 0.001);
    const struct findings *f = inspected(recording);
    assert_only(f, FINDING_SWAY, "sway");
    assert_true(near(f->finding[FINDING_SWAY].size, 0.06 / sqrt(2), 0.006));
    assert_true(near(f->sway_period, 5, 0.5));
    assert_int_equal(f->masked, 0);
    recording_destroy(recording);
}

RUN_TESTS(fixture_setup, fixture_teardown)
