/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Measured orders of the methods for noise; that results do not depend on threads; what a session
 * keeps of them. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>

#include "modules/noise/compute/orders.h"
#include "modules/resume/testing.h"

static const struct noise_request half = {
    .energy = NAN, .gamma = NAN, .strength = {0.5}, .strengths = 1};
static const struct noise_request bath = {.energy = 0.02, .gamma = NAN};

/* ---- orders ---- */

static struct method_orders orders_of(const char *line, struct noise_request noise,
                                      const char *method, double dt, int levels, int64_t paths,
                                      int threads)
{
    struct bench b;
    struct error error = {0};
    struct noise_forcing forcing;
    struct method_orders orders;
    bench_open(&b, false);
    type_ok(&b, line);
    assert_true(noise_forcing_bind(&b.session->setup.scene, &noise, &forcing, &error));
    const struct orders_request request = {
        .forcing = &forcing, .span = 1, .dt = dt, .levels = levels, .paths = paths, .seed = 3};
    if (!noise_orders_measure(&request,
                              (const void *)catalog_find(&noise_method_catalog, text_of(method)),
                              (struct parallel){.threads = threads}, &orders, &error))
        fail_msg("%s", error.text);
    bench_close(&b);
    print_message("%s: strong %.3f(%.3f), weak %.4f(%.4f)\n", method, orders.strong.value,
                  orders.strong.uncertainty, orders.weak.value, orders.weak.uncertainty);
    return orders;
}

/* Strong order 1 of all, since the noise is additive; weak order 1 of Euler, 2 of the others. */
TEST(orders_are_those_of_the_methods)
{
    static const struct {
        const char *line, *method;
        double dt, weak;
        int bath;
    } row[] = {
        {"scene damped; gamma = 2", "euler-maruyama", 0.01, 1, 1},
        {"scene damped; gamma = 2", "heun-stochastic", 0.01, 2, 1},
        {"scene damped; gamma = 2", "baoab", 0.05, 2, 1},
        {"scene new; var x = 1; x' = -x", "euler-maruyama", 0.1, 1, 0},
        {"scene new; var x = 1; x' = -x", "heun-stochastic", 0.1, 2, 0},
    };
    for (size_t i = 0; i < COUNT_OF(row); i++) {
        const struct method_orders found =
            orders_of(row[i].line, row[i].bath ? bath : half, row[i].method, row[i].dt, 5, 400, 2);
        assert_true(fabs(found.strong.value - 1) < fmax(0.05, 3 * found.strong.uncertainty));
        assert_true(found.strong.uncertainty < 0.2);
        assert_true(fabs(found.weak.value - row[i].weak) < fmax(0.02, 2 * found.weak.uncertainty));
        assert_true(found.weak.uncertainty < 0.1);
    }
}

/* What mean and covariance say of a linear scene is what paths say: the same laws, typed so that
 * the scene does not know that it is linear. */
TEST(moments_agree_with_paths)
{
    const struct method_orders linear =
        orders_of("scene new; var x = 1; x' = -x", half, "euler-maruyama", 0.25, 3, 10, 2);
    const struct method_orders paths = orders_of("scene new; var x = 1; x' = -if(x>1e9,2*x,x)",
                                                 half, "euler-maruyama", 0.25, 3, 5000, 2);
    assert_true(linear.weak_is_exact);
    assert_false(paths.weak_is_exact);
    for (int i = 0; i < 3; i++)
        assert_true(fabs(paths.level[i].weak.value - linear.level[i].weak.value) <
                    4 * paths.level[i].weak.uncertainty);
}

/* An order is not invented: a scene whose differences are chance has none. */
TEST(orders_that_chance_hides_are_not_known)
{
    const struct method_orders found =
        orders_of("scene new; var x = 0; x' = -sin(x)", half, "heun-stochastic", 0.02, 4, 20, 2);
    assert_true(isnan(found.weak.value));
}

/* ---- threads ---- */

TEST(bytes_do_not_depend_on_threads)
{
    static const int threads[] = {1, 2, 5};
    static const char *const line[] = {
        "format = json; ensemble 101 2 s of energy kT=1mJ rows=7 --threads %d",
        "format = json; noiseorder 0.5 s kT=1mJ dt=10ms paths=23 levels=3 --threads %d"};
    for (size_t i = 0; i < COUNT_OF(line); i++) {
        struct buffer first = {0};
        for (size_t k = 0; k < COUNT_OF(threads); k++) {
            struct bench b;
            struct buffer typed = {0};
            bench_open(&b, false);
            type_ok(&b, "scene duffing; gamma = 0.5");
            _Pragma("GCC diagnostic push") _Pragma("GCC diagnostic ignored \"-Wformat-nonliteral\"")
                buffer_format(&typed, line[i], threads[k]);
            _Pragma("GCC diagnostic pop") type_ok(&b, buffer_view(&typed));
            if (k == 0)
                buffer_put(&first, buffer_text(&b.out));
            assert_true(text_equal(buffer_text(&first), buffer_text(&b.out)));
            buffer_free(&typed);
            bench_close(&b);
        }
        assert_true(first.len > 100);
        buffer_free(&first);
    }
}

TEST(same_seed_same_bits)
{
    struct bench b;
    struct buffer first = {0};
    bench_open(&b, false);
    type_ok(&b, "scene damped; format = json; langevin 1 s kT=1mJ seed=4");
    buffer_put(&first, buffer_text(&b.out));
    type_ok(&b, "langevin 1 s kT=1mJ seed=4");
    assert_true(first.len > 1000 && strstr(said(&first), said(&b.out)));
    type_ok(&b, "langevin 1 s kT=1mJ seed=5");
    assert_null(strstr(said(&first), said(&b.out)));
    buffer_free(&first);
    bench_close(&b);
}

/* The curves of both plots are in the session's file. */
TEST(plots_come_back)
{
    struct bench b, again;
    bench_open(&b, false);
    type_ok(&b, "scene damped; langevin 1 s kT=1mJ; ensemble 20 1 s kT=1mJ");
    bench_resume(&b, &again);
    static const char *const plot[] = {"plot langevin", "plot ensemble"};
    for (size_t i = 0; i < COUNT_OF(plot); i++) {
        type_ok(&b, plot[i]);
        type_ok(&again, plot[i]);
        assert_true(b.out.len > 500 && text_equal(buffer_text(&b.out), buffer_text(&again.out)));
    }
    bench_close(&b);
    bench_close(&again);
}

static void count_call(void *context, int thread, int64_t index)
{
    (void)thread;
    (void)index;
    atomic_fetch_add((atomic_int *)context, 1);
}

TEST(items_are_done_once_or_cancelled)
{
    atomic_int done = 0;
    struct cancel cancel = {0};
    struct parallel parallel = {
        .threads = 3, .cancel = &cancel, .work = count_call, .context = &done};
    assert_int_equal(parallel_do(&parallel, 1000), 3);
    assert_int_equal(done, 1000);
    atomic_store(&cancel.requested, 1);
    parallel_do(&parallel, 1000);
    assert_int_equal(done, 1000);
}

RUN_TESTS(NULL, NULL)
