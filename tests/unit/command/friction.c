/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * From a recording under each of the seven laws to the scene: what fit drag finds is adopted whole,
 * and the run with it lies on the data. The recordings are noisy runs of the scene itself, known to
 * rounding by steps of high order.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/command/testing.h"

#include "modules/solving/compute/solve.h"

static double noise(uint64_t *seed) /* standard normal, by Box and Muller */
{
    double u[2];
    for (int i = 0; i < 2; i++) {
        *seed = *seed * 6364136223846793005u + 1442695040888963407u;
        u[i] = ((double)(*seed >> 11) + 0.5) / 9007199254740992.0;
    }
    return sqrt(-2 * log(u[0])) * cos(6.28318530717958648 * u[1]);
}

static void set(struct scene *scene, const char *name, double value)
{
    struct error error;
    assert_true(scene_set(scene, param_index(name), (struct measured){value, 0}, &error));
}

/* 25 s of it, 50 samples a second. */
static void record(const char *name, double gamma, double C, double friction, double sigma,
                   uint64_t seed)
{
    struct scene scene;
    struct error error;
    struct buffer text = {0};
    scene_init(&scene, NULL);
    set(&scene, "gamma", gamma);
    set(&scene, "C", C);
    set(&scene, "friction", friction);
    set(&scene, "y0", 0.08);
    const struct run_settings settings = {.dt = 0.02};
    struct run *run = run_create(&scene, method_by_name(TEXT("dop853")), &settings, 25, &error);
    assert_non_null(run);
    const struct run_target target = {.t = 25, .steps = -1};
    run_advance(run, &target, 0, NULL);
    buffer_put(&text, TEXT("t [s],y [m]\n"));
    for (size_t i = 0; i < trace_count(run->trace); i++)
        buffer_format(&text, "%.4f,%.7f\n", trace_time(run->trace, i),
                      trace_state(run->trace, i)[0] + sigma * noise(&seed));
    write_file(name, text.data, text.len);
    buffer_free(&text);
    run_destroy(run);
}

static double number_behind(const char *text, const char *key)
{
    const char *at = strstr(text, key);
    if (!at)
        fail_msg("no %s in: %s", key, text);
    return strtod(at + strlen(key), NULL);
}

TEST(test_adopted_friction_lies_on_the_data)
{
    static const struct {
        double gamma, C, friction, sigma;
    } law[] = {
        {0, 0, 0.004, 2e-4},     {0, 0, 0.004, 1e-3},    {0, 0, 0.008, 2e-4},
        {0, 0, 0.015, 1e-3},     {0.05, 0, 0.004, 2e-4}, {0.05, 0, 0.004, 1e-3},
        {0.05, 0, 0.01, 2e-4},   {0.1, 0, 0.006, 5e-4},  {0, 60, 0.004, 2e-4},
        {0, 60, 0.008, 1e-3},    {0, 120, 0.006, 2e-4},  {0, 30, 0.012, 5e-4},
        {0.03, 0, 0, 2e-4},      {0.1, 0, 0, 5e-4},      {0.3, 0, 0, 1e-3},
        {0, 30, 0, 2e-4},        {0, 60, 0, 5e-4},       {0, 120, 0, 1e-3},
        {0.03, 60, 0, 2e-4},     {0.06, 90, 0, 5e-4},    {0.1, 60, 0, 1e-3},
        {0, 0, 0.015, 2e-4},     {0, 0, 0.015, 5e-4},    {0.04, 60, 0.004, 2e-4},
        {0.04, 60, 0.008, 1e-3}, {0.02, 90, 0.01, 5e-4}, {0.08, 30, 0.006, 2e-4},
    };
    for (size_t i = 0; i < COUNT_OF(law); i += is_long() ? 1 : 3) {
        struct bench bench;
        bench_open(&bench, false);
        type_ok(&bench, "set format json");
        record("rub.csv", law[i].gamma, law[i].C, law[i].friction, law[i].sigma, i + 1);
        type_ok(&bench, "m = 200 g; load rub.csv; fit drag");
        buffer_clear(&bench.out);
        type_ok(&bench, "adopt");
        const char *found = said(&bench.out);
        const double fit = number_behind(found, "\"rms_fit\":"),
                     run = number_behind(found, "\"rms_run\":");
        if (!(run <= 1.2 * fit && fit < 1.2 * law[i].sigma))
            fail_msg("recording %zu: rms of the run %g, of the fit %g, noise %g", i, run, fit,
                     law[i].sigma);
        const char *of = strstr(found, "\"friction\":");
        const double friction = of ? number_behind(of, "\"value\":") : 0;
        if (law[i].C == 0 && law[i].friction > 0 &&
            fabs(friction - law[i].friction) > (law[i].gamma > 0 ? 0.1 : 0.01) * law[i].friction)
            fail_msg("recording %zu: friction %g N, wanted %g", i, friction, law[i].friction);
        bench_close(&bench);
        remove("rub.csv");
    }
}

RUN_TESTS(enter_folder, leave_folder)
