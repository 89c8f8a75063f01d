/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Paths with noise against closed forms: the Ornstein-Uhlenbeck process (Uhlenbeck, Ornstein 1930),
 * a free particle, equipartition. Judged within standard errors that come from the same paths, with
 * controls that have to fail.
 */
#include "cmocka_testing.h"

#include "modules/noise/compute/orders.h"
#include "modules/noise/compute/random.h"
#include "unit/command/testing.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

/* Chance gives 4 standard errors once in 16000 times; seeds are fixed. */
#define STANDARD_ERRORS_MAX 4

struct paths {
    struct bench bench;
    struct noise_forcing forcing;
    struct path_request request;
    struct ensemble ensemble;
};

static double standard_errors(struct measured value, double expected)
{
    return fabs(value.value - expected) / value.uncertainty;
}

/* Follows paths of the scene that the line makes. */
static void follow(struct paths *p, const char *line, struct noise_request noise,
                   const char *method, double span, double dt, int64_t paths, double stronger)
{
    struct error error = {0};
    *p = (struct paths){.request = {.seed = 11}};
    bench_open(&p->bench, false);
    type_ok(&p->bench, line);
    if (!noise_forcing_bind(&p->bench.session->setup.scene, &noise, &p->forcing, &error))
        fail_msg("%s", error.text);
    for (int i = 0; i < p->forcing.count; i++)
        p->forcing.strength[i] *= stronger;
    p->request.forcing = &p->forcing;
    p->request.method = (const void *)catalog_find(&noise_method_catalog, text_of(method));
    assert_non_null(p->request.method);
    const struct path_column first = {.variable = 0};
    if (!noise_path_grid_make(&p->forcing, p->request.method, span, dt, 20, &p->request.grid,
                              &error) ||
        !noise_ensemble_follow(&p->request, &first, paths, (struct parallel){.threads = 2},
                               &p->ensemble, &error))
        fail_msg("%s", error.text);
}

static void finish(struct paths *p)
{
    noise_ensemble_free(&p->ensemble);
    bench_close(&p->bench);
}

/* The mean over the paths of a product of two variables at the end. */
static struct measured mean_product(const struct paths *p, int i, int j)
{
    const size_t n = (size_t)p->ensemble.paths;
    double *product = calloc(n, sizeof *product);
    assert_non_null(product);
    for (size_t k = 0; k < n; k++) {
        const double *end = p->ensemble.end + k * (size_t)p->forcing.system.n;
        product[k] = end[i] * end[j];
    }
    const struct measured mean = noise_mean_of(product, n);
    free(product);
    return mean;
}

static const struct noise_request half = {
    .energy = NAN, .gamma = NAN, .strength = {0.5}, .strengths = 1};

static struct noise_request bath(double energy)
{
    return (struct noise_request){.energy = energy, .gamma = NAN};
}

/* ---- random numbers ---- */

/* Vectors of the authors' own tests (Random123, kat_vectors). */
TEST(philox_gives_the_known_blocks)
{
    static const struct {
        uint32_t counter[4], key[2], block[4];
    } known[] = {
        {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
        {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
         {0xffffffff, 0xffffffff},
         {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
        {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
         {0xa4093822, 0x299f31d0},
         {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
    };
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        uint32_t block[4];
        noise_philox_block(known[i].counter, known[i].key, block);
        assert_memory_equal(block, known[i].block, sizeof block);
    }
}

/* Moments 1 to 4 and the correlation of neighbours of 200000 numbers: those of a standard normal
 * distribution within 4 standard errors. */
TEST(normal_numbers_are_normal)
{
    enum { N = 200000, COUNT = 3 };
    static const double moment[4] = {0, 1, 0, 3}, variance[4] = {1, 2, 15, 96};
    double sum[4] = {0}, neighbours = 0, before = 0;
    for (uint64_t i = 0; i < N / COUNT; i++) {
        double normal[COUNT];
        noise_normal_numbers(5, i % 7, i / 7, COUNT, normal);
        for (int k = 0; k < COUNT; k++) {
            double power = 1;
            for (int m = 0; m < 4; m++)
                sum[m] += power *= normal[k];
            neighbours += normal[k] * before;
            before = normal[k];
        }
    }
    for (int m = 0; m < 4; m++)
        assert_true(fabs(sum[m] / N - moment[m]) < STANDARD_ERRORS_MAX * sqrt(variance[m] / N));
    assert_true(fabs(neighbours / N) < STANDARD_ERRORS_MAX / sqrt(N));
}

/* ---- closed forms ---- */

/* x' = -x + S xi: mean exp(-t), variance S^2/2 (1 - exp(-2 t)), covariance of two times exp(-lag)
 * times the variance at the first. */
TEST(ornstein_uhlenbeck)
{
    static const char *const method[] = {"euler-maruyama", "heun-stochastic"};
    /* Euler's own errors, of order dt, are below a third of a standard error at this step. */
    static const double dt[] = {0.002, 0.01};
    for (size_t m = 0; m < COUNT_OF(method); m++) {
        struct paths p;
        follow(&p, "scene new; var x = 1; x' = -x", half, method[m], 4, dt[m], 2000, 1);
        const size_t n = (size_t)p.ensemble.paths;
        double *value = calloc(n, sizeof *value);
        assert_non_null(value);
        for (size_t row = 1; row < p.ensemble.rows; row++) {
            const double t = noise_path_time(&p.request.grid, row);
            const double *x = p.ensemble.value + row * n;
            const double variance = 0.125 * (1 - exp(-2 * t));
            assert_true(standard_errors(noise_mean_of(x, n), exp(-t)) < STANDARD_ERRORS_MAX);
            for (size_t i = 0; i < n; i++)
                value[i] = (x[i] - exp(-t)) * (x[i] - exp(-t));
            assert_true(standard_errors(noise_mean_of(value, n), variance) < STANDARD_ERRORS_MAX);
            for (size_t later = row + 1; later < p.ensemble.rows; later += 3) {
                const double s = noise_path_time(&p.request.grid, later);
                for (size_t i = 0; i < n; i++)
                    value[i] = (x[i] - exp(-t)) * (p.ensemble.value[later * n + i] - exp(-s));
                assert_true(standard_errors(noise_mean_of(value, n), variance * exp(t - s)) <
                            STANDARD_ERRORS_MAX);
            }
        }
        free(value);
        finish(&p);
    }
}

/* v' = S xi without damping: <v^2> = S^2 t, <x^2> = S^2 t^3/3, <x v> = S^2 t^2/2. */
TEST(free_particle)
{
    for (size_t i = 0; i < noise_method_catalog.count; i++) {
        struct paths p;
        follow(&p, "scene new; var x = 0; var x' = 0; x'' = 0*x", half,
               noise_method_at(i)->row.name, 2, 0.01, 2000, 1);
        assert_true(standard_errors(mean_product(&p, 1, 1), 0.5) < STANDARD_ERRORS_MAX);
        assert_true(standard_errors(mean_product(&p, 0, 1), 0.5) < STANDARD_ERRORS_MAX);
        assert_true(standard_errors(mean_product(&p, 0, 0), 2.0 / 3) < STANDARD_ERRORS_MAX);
        finish(&p);
    }
}

/* ---- equipartition ---- */

/* The larger distance of m<v^2> and k<y^2> from kT in standard errors; prints what was found. */
static double equipartition(const char *method, double dt, int64_t paths, double stronger)
{
    const double kT = 1e-3, m = 0.2, k = 15;
    struct paths p;
    follow(&p, "scene damped; gamma = 2", bath(kT), method, 8, dt, paths, stronger);
    const struct measured v = mean_product(&p, 1, 1), y = mean_product(&p, 0, 0);
    const struct measured kinetic = {m * v.value, m * v.uncertainty};
    const struct measured spring = {k * y.value, k * y.uncertainty};
    print_message("%s, dt = %g s, noise times %g: m<v^2> = %.4f(%.4f) kT, k<y^2> = %.4f(%.4f) kT\n",
                  method, dt, stronger, kinetic.value / kT, kinetic.uncertainty / kT,
                  spring.value / kT, spring.uncertainty / kT);
    finish(&p);
    return fmax(standard_errors(kinetic, kT), standard_errors(spring, kT));
}

TEST(equipartition_holds)
{
    assert_true(equipartition("baoab", 0.02, 4000, 1) < STANDARD_ERRORS_MAX);
    assert_true(equipartition("heun-stochastic", 0.01, 4000, 1) < STANDARD_ERRORS_MAX);
    assert_true(equipartition("euler-maruyama", 0.0005, 800, 1) < STANDARD_ERRORS_MAX);
}

/* Controls: noise that is 10 % too strong, and Euler's with a step that is too large. */
TEST(equipartition_can_fail)
{
    assert_true(equipartition("baoab", 0.02, 4000, 1.1) > STANDARD_ERRORS_MAX);
    assert_true(equipartition("euler-maruyama", 0.02, 1000, 1) > STANDARD_ERRORS_MAX);
}

/* The covariance [2][2] in natural sizes to which a linear scene of one coordinate comes with
 * steps h: the sum of M^k S M^k^T over all k, by doubling. */
static void stationary_covariance(const struct noise_forcing *forcing, const char *method, double h,
                                  double *covariance)
{
    enum { DOUBLINGS = 40 };
    struct noise_stepper stepper;
    double m[4], square[4];
    noise_stepper_begin(&stepper, forcing,
                        (const void *)catalog_find(&noise_method_catalog, text_of(method)), h);
    noise_step_matrix(&stepper, m);
    noise_step_spread(&stepper, covariance);
    for (int k = 0; k < DOUBLINGS; k++) {
        double half_way[4], moved[4];
        matrix_multiply(2, m, covariance, half_way);
        const double transposed[4] = {m[0], m[2], m[1], m[3]};
        matrix_multiply(2, half_way, transposed, moved);
        for (int i = 0; i < 4; i++)
            covariance[i] += moved[i];
        matrix_multiply(2, m, m, square);
        memcpy(m, square, sizeof m);
    }
    for (int i = 0; i < 4; i++)
        covariance[i] *= h;
}

/*
 * Springs, dampings, masses, temperatures and steps up to 90 % of the stable one, at random.
 * BAOAB's positions have k<y^2> = kT for every step, its velocities m<v^2> = kT (1 - omega^2 h^2/4)
 * (Leimkuhler, Matthews 2013, section 4): no chance, so to rounding.
 */
TEST(baoab_is_exact_in_positions)
{
    enum { SCENES = 300 };
    uint64_t seed = 42;
    struct bench b;
    bench_open(&b, false);
    for (int i = 0; i < SCENES; i++) {
        struct error error = {0};
        struct noise_forcing forcing;
        struct buffer line = {0};
        double covariance[4];
        const double m = pow(10, 4 * random_fraction(&seed) - 2);
        const double k = pow(10, 6 * random_fraction(&seed) - 3);
        const double omega = sqrt(k / m), gamma = omega * pow(10, 3 * random_fraction(&seed) - 1.5);
        const double energy = pow(10, 8 * random_fraction(&seed) - 6);
        const double h = 1.8 / omega * (0.01 + 0.99 * random_fraction(&seed));
        buffer_format(&line, "scene spring; m = %.17g kg; k = %.17g N/m; gamma = %.17g 1/s", m, k,
                      gamma);
        type_ok(&b, buffer_view(&line));
        buffer_free(&line);
        const struct noise_request noise = bath(energy);
        assert_true(noise_forcing_bind(&b.session->setup.scene, &noise, &forcing, &error));
        stationary_covariance(&forcing, "baoab", h, covariance);
        const double *scale = forcing.system.scale;
        const double position = k * covariance[0] * scale[0] * scale[0] / energy;
        const double velocity = m * covariance[3] * scale[1] * scale[1] / energy;
        if (!(fabs(position - 1) < 1e-9) ||
            !(fabs(velocity / (1 - omega * omega * h * h / 4) - 1) < 1e-9))
            fail_msg("omega h = %g, gamma h = %g: %.12g, %.12g", omega * h, gamma * h, position,
                     velocity);
    }
    /* Heun's are not. */
    struct error error = {0};
    struct noise_forcing forcing;
    const struct noise_request noise = bath(1e-3);
    double covariance[4];
    type_ok(&b, "scene damped; gamma = 2");
    assert_true(noise_forcing_bind(&b.session->setup.scene, &noise, &forcing, &error));
    stationary_covariance(&forcing, "heun-stochastic", 0.02, covariance);
    assert_true(fabs(15 * covariance[0] * pow(forcing.system.scale[0], 2) / 1e-3 - 1) > 1e-3);
    bench_close(&b);
}

/* Coordinates with dampings of their own; a double well; a damping that was stated. */
TEST(equipartition_of_other_scenes)
{
    static const struct {
        const char *line;
        double gamma;
    } scene[] = {
        {"scene new; param m = 2; var x = 0; var x' = 0; var z = 1; var z' = 0;"
         "x'' = -x-2*x'; z'' = -4*z-z'",
         NAN},
        {"scene new; var x = 1; var x' = 0; x'' = x-x^3-1.5*x'", NAN},
        {"scene duffing", 1.5},
        {"scene duffing; gamma = 0.1", 1.5},
    };
    for (size_t i = 0; i < COUNT_OF(scene); i++) {
        struct paths p;
        struct noise_request noise = bath(0.5);
        noise.gamma = scene[i].gamma;
        follow(&p, scene[i].line, noise, "baoab", 15, 0.05, 2000, 1);
        const int n = p.forcing.system.n, coordinates = n / 2;
        for (int k = 0; k < coordinates; k++) {
            const struct measured v = mean_product(&p, coordinates + k, coordinates + k);
            assert_true(standard_errors(v, 0.5 / p.forcing.system.mass) < STANDARD_ERRORS_MAX);
        }
        finish(&p);
    }
}

/* ---- statistics ---- */

/* Sizes whose squares are out of the range of numbers; an even number has the mean of two as its
 * median. */
TEST(statistics_of_any_size)
{
    static const double size[] = {1, 1e-200, 1e200};
    const struct path_grid grid = {.h = 1, .steps = 1, .stride = 1};
    for (size_t i = 0; i < COUNT_OF(size); i++) {
        double value[] = {4 * size[i], 1 * size[i], 3 * size[i], 2 * size[i]};
        double scratch[2 * COUNT_OF(value)];
        const struct ensemble ensemble = {.paths = COUNT_OF(value), .rows = 1, .value = value};
        const struct ensemble_row row = noise_ensemble_statistics(&ensemble, &grid, 0, scratch);
        assert_true(fabs(row.mean / size[i] - 2.5) < 1e-15);
        assert_true(fabs(row.sd / size[i] - sqrt(5.0 / 3)) < 1e-15);
        assert_true(fabs(row.median / size[i] - 2.5) < 1e-15);
        assert_true(fabs(row.lower / size[i] - 1.75) < 1e-15);
        assert_true(fabs(row.high / size[i] - 3.85) < 1e-15);
    }
}

/* ---- what is stopped, and half the step ---- */

TEST(what_is_cancelled_is_an_error)
{
    struct paths p;
    struct cancel cancel = {0};
    struct error error = {0};
    const struct path_column first = {.variable = 0};
    double end[LIMIT_VARIABLES], distance[LIMIT_VARIABLES];
    follow(&p, "scene duffing", (struct noise_request){.energy = 1, .gamma = 1}, "baoab", 1, 0.1, 2,
           1);
    atomic_store(&cancel.requested, 1);
    p.request.cancel = &cancel;
    assert_int_equal(noise_path_follow(&p.request, 0, end, NULL, NULL), 0);
    assert_false(noise_path_half_step(&p.request, p.ensemble.end, 2, distance));
    noise_ensemble_free(&p.ensemble);
    assert_false(noise_ensemble_follow(&p.request, &first, 5, (struct parallel){.cancel = &cancel},
                                       &p.ensemble, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    const struct orders_request orders = {
        .forcing = &p.forcing, .span = 1, .dt = 0.1, .levels = 3, .paths = 10};
    struct method_orders found;
    error.code = ERROR_NONE;
    assert_false(noise_orders_measure(&orders, p.request.method,
                                      (struct parallel){.cancel = &cancel}, &found, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    finish(&p);
}

/* The distance of a path from the one with half the step and the same noise is proportional to dt,
 * as the strong order of baoab is 1 here: half the step halves it, within 0.25 of the factor 2. */
TEST(half_the_step_halves_the_distance)
{
    double distance[2][LIMIT_VARIABLES];
    for (int i = 0; i < 2; i++) {
        struct paths p;
        follow(&p, "scene damped; gamma = 2", bath(1e-3), "baoab", 2, 0.02 / (1 + i), 500, 1);
        assert_true(noise_path_half_step(&p.request, p.ensemble.end, 500, distance[i]));
        finish(&p);
    }
    for (int k = 0; k < 2; k++)
        assert_true(fabs(distance[0][k] / distance[1][k] - 2) < 0.25);
}

RUN_TESTS(NULL, NULL)
