/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Measures strong and weak orders: steps of several sizes are compared on the same Wiener paths. */
#include "modules/noise/compute/orders.h"

#include "modules/noise/compute/random.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <stdlib.h>
#include <string.h>

/* Data that the threads share. */
struct orders_work {
    const struct orders_request *request;
    const struct noise_method *method;
    const struct cancel *cancel;
    int64_t steps;         /* steps of the largest size */
    double *strong, *weak; /* [levels][paths] */
    double *increment;     /* [threads][fine steps][count] */
};

/* Returns the number of steps of the largest size. */
static int64_t largest_steps(const struct orders_request *request)
{
    const double steps = ceil(request->span / request->dt - 1e-9);
    return steps < 1 ? 1 : (int64_t)steps;
}

double noise_orders_bytes(const struct orders_request *request, int threads)
{
    const double fine = ldexp((double)largest_steps(request), request->levels);
    return sizeof(double) * (threads * fine * request->forcing->count +
                             2.0 * request->levels * (double)request->paths);
}

double noise_orders_steps(const struct orders_request *request)
{
    return 2 * ldexp((double)largest_steps(request), request->levels + 1) * (double)request->paths;
}

/* Fills in the increments [fine][count] of a Wiener path, each of variance h. */
static void fill_increments(const struct orders_work *work, int64_t path, int64_t fine, double h,
                            double *increment)
{
    const int count = work->request->forcing->count;
    for (int64_t i = 0; i < fine; i++)
        noise_normal_numbers(work->request->seed, (uint64_t)path, (uint64_t)i, count,
                             increment + i * count);
    const double root = sqrt(h);
    for (int64_t i = 0; i < fine * count; i++)
        increment[i] *= root;
}

/* Follows the path with steps of h [s], each with the sum of `together` fine increments of the
 * noise, or its mirror image (sign -1), to the end y [n], whose first variable becomes NAN if the
 * path diverges or if cancelled. */
static void follow_increments(const struct orders_work *work, const double *increment,
                              int64_t together, double h, int sign, double *y)
{
    enum { CANCEL_CHECK_STEPS = 1024 };
    const struct noise_forcing *forcing = work->request->forcing;
    const int count = forcing->count;
    struct noise_stepper stepper;
    noise_stepper_begin(&stepper, forcing, work->method, h);
    memcpy(y, forcing->system.start, (size_t)forcing->system.n * sizeof *y);
    const int64_t steps = (work->steps << work->request->levels) / together;
    for (int64_t i = 0; i < steps; i++, increment += together * count) {
        double noise[LIMIT_VARIABLES] = {0};
        for (int64_t k = 0; k < together * count; k++)
            noise[k % count] += sign * increment[k];
        if ((i % CANCEL_CHECK_STEPS == 0 && cancelled(work->cancel)) ||
            !noise_stepper_step(&stepper, forcing->system.t0 + (double)i * h, y, noise)) {
            y[0] = NAN;
            return;
        }
    }
}

/* Adds the differences at the end between two successive step sizes: of states (strong), of squares
 * (weak). */
static void add_differences(const struct system *system, const double *coarse, const double *fine,
                            double *strong, double *weak)
{
    for (int i = 0; i < system->n; i++) {
        const double a = coarse[i] / system->scale[i], b = fine[i] / system->scale[i];
        *strong += (a - b) * (a - b) / 2;
        *weak += (a * a - b * b) / 2;
    }
}

/* Measures path number `path` with steps of all sizes, each compared with half of it, and its
 * mirror image, which cancels statistical errors that are odd in the path. `context` is the struct
 * orders_work; `thread` chooses the scratch memory. */
static void measure_one(void *context, int thread, int64_t path)
{
    struct orders_work *work = context;
    const struct orders_request *request = work->request;
    const int levels = request->levels;
    const int64_t fine = work->steps << levels;
    const double h = request->span / (double)fine;
    double *increment = work->increment + thread * fine * request->forcing->count;
    fill_increments(work, path, fine, h, increment);
    for (int sign = -1; sign <= 1; sign += 2) {
        double coarse[LIMIT_VARIABLES], next[LIMIT_VARIABLES];
        follow_increments(work, increment, (int64_t)1 << levels, ldexp(h, levels), sign, coarse);
        for (int level = 0; level < levels; level++) {
            const int left = levels - level - 1;
            const size_t index = (size_t)level * (size_t)request->paths + (size_t)path;
            follow_increments(work, increment, (int64_t)1 << left, ldexp(h, left), sign, next);
            add_differences(&request->forcing->system, coarse, next, &work->strong[index],
                            &work->weak[index]);
            memcpy(coarse, next, sizeof coarse);
        }
    }
}

/* Returns the order of convergence, strong or weak, from the two finest levels whose differences
 * are significant: more than three standard errors and above rounding. Its uncertainty combines
 * chance with the change since the previous two levels. NAN if fewer than three levels are
 * significant. */
static struct measured find_order(const struct order_level *level, int levels, bool strong)
{
    enum { LEVELS_LEAST = 3 };
    static const double sigmas_min = 3;
    /* Differences of states and squares of natural size that may be nothing but rounding. */
    static const double rounding = 1e-12;
    double order[ORDER_LEVELS_MAX] = {0}, relative[ORDER_LEVELS_MAX] = {0};
    int n = 0;
    for (; n < levels; n++) {
        const struct measured value = strong ? level[n].strong : level[n].weak;
        if (!(fabs(value.value) > fmax(sigmas_min * value.uncertainty, rounding)))
            break;
        relative[n] = value.uncertainty / fabs(value.value);
        const struct order_level *previous = n ? &level[n - 1] : NULL;
        if (previous)
            order[n] = log2((strong ? previous->strong.value : previous->weak.value) / value.value);
    }
    if (n < LEVELS_LEAST || !isfinite(order[n - 1]) || !isfinite(order[n - 2]))
        return (struct measured){NAN, NAN};
    const double chance = hypot(relative[n - 1], relative[n - 2]) / log(2);
    return (struct measured){order[n - 1], hypot(chance, order[n - 1] - order[n - 2])};
}

/* Returns the expected sum of squares of the scaled variables at the end of the span after `steps`
 * steps, computed exactly, not from sample paths. A step of a linear scene is affine, y' = M y + N
 * dW + c(t), so that steps without noise give the mean, and the covariance follows from M and N. */
static double linear_moment(const struct orders_work *work, int64_t steps)
{
    const struct noise_forcing *forcing = work->request->forcing;
    const struct system *system = &forcing->system;
    const int n = system->n;
    const double h = work->request->span / (double)steps;
    struct noise_stepper stepper;
    static const double silence[LIMIT_VARIABLES];
    double mean[LIMIT_VARIABLES], m[GROWTH_MATRIX], spread[GROWTH_MATRIX], c[GROWTH_MATRIX] = {0};
    noise_stepper_begin(&stepper, forcing, work->method, h);
    noise_step_matrix(&stepper, m);
    noise_step_spread(&stepper, spread);
    memcpy(mean, system->start, sizeof mean);
    stepper.warm = false;
    for (int64_t i = 0; i < steps; i++) {
        double mc[GROWTH_MATRIX];
        noise_stepper_step(&stepper, system->t0 + (double)i * h, mean, silence);
        matrix_multiply(n, m, c, mc);
        for (int r = 0; r < n; r++)
            for (int k = 0; k < n; k++) {
                c[r * n + k] = h * spread[r * n + k];
                for (int q = 0; q < n; q++)
                    c[r * n + k] += mc[r * n + q] * m[k * n + q];
            }
    }
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += (mean[i] / system->scale[i] * mean[i] / system->scale[i] + c[i * n + i]) / 2;
    /* add_differences() adds half of each square, for a path and again for its mirror image. */
    return 2 * sum;
}

/* Replaces the weak differences of a linear scene by exact ones. */
static void find_linear_weak(const struct orders_work *work, struct method_orders *orders)
{
    double coarse = linear_moment(work, work->steps);
    for (int i = 0; i < orders->levels; i++) {
        const double fine = linear_moment(work, work->steps << (i + 1));
        orders->level[i].weak = (struct measured){coarse - fine, 0};
        coarse = fine;
    }
    orders->weak_is_exact = true;
}

/* Computes the levels (means over all paths) and from them the strong and the weak order of the
 * method. */
static void summarise_orders(const struct orders_work *work, struct method_orders *orders)
{
    const struct orders_request *request = work->request;
    orders->method = work->method;
    orders->levels = request->levels;
    for (int i = 0; i < request->levels; i++) {
        struct order_level *level = &orders->level[i];
        const size_t first = (size_t)i * (size_t)request->paths, n = (size_t)request->paths;
        const struct measured square = noise_mean_of(work->strong + first, n);
        const double distance = sqrt(square.value);
        level->dt = ldexp(request->span / (double)work->steps, -i);
        level->strong = (struct measured){distance, square.uncertainty / (2 * distance)};
        level->weak = noise_mean_of(work->weak + first, n);
    }
    if (request->forcing->system.linear && request->forcing->system.n <= GROWTH_VARIABLES)
        find_linear_weak(work, orders);
    orders->strong = find_order(orders->level, orders->levels, true);
    orders->weak = find_order(orders->level, orders->levels, false);
}

/* Measures the strong and weak order of a method: follows all paths with steps of all sizes in
 * threads, with the same noise, and summarises the errors in *orders. Returns false with *error,
 * and *orders zero, if a path diverges, if out of memory or if cancelled. */
bool noise_orders_measure(const struct orders_request *request, const struct noise_method *method,
                          struct parallel parallel, struct method_orders *orders,
                          struct error *error)
{
    const size_t cells = (size_t)request->levels * (size_t)request->paths;
    const size_t fine = (size_t)largest_steps(request) << request->levels;
    const size_t threads = (size_t)parallel_threads(&parallel, request->paths);
    struct orders_work work = {
        .request = request,
        .method = method,
        .cancel = parallel.cancel,
        .steps = largest_steps(request),
        .strong = calloc(cells, sizeof(double)),
        .weak = calloc(cells, sizeof(double)),
        .increment = calloc(threads * fine * (size_t)request->forcing->count, sizeof(double))};
    parallel.work = measure_one;
    parallel.context = &work;
    bool ok = work.strong && work.weak && work.increment;
    if (ok)
        parallel_do(&parallel, request->paths);
    else
        error_memory(error);
    if (parallel.progress)
        parallel.progress(parallel.progress_context, 2);
    if (ok && cancelled(parallel.cancel))
        ok = error_set(error, ERROR_CANCELLED, "stopped; no orders were measured");
    for (size_t i = 0; ok && i < cells; i++)
        if (isnan(work.strong[i]) || isnan(work.weak[i]))
            ok = error_set(error, ERROR_NUMERICAL, "%s diverged on one path; dt is too large",
                           method->row.name);
    *orders = (struct method_orders){0};
    if (ok)
        summarise_orders(&work, orders);
    free(work.strong);
    free(work.weak);
    free(work.increment);
    return ok;
}
