/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Strong and weak orders of a method for a scene, measured from steps of several sizes on the same
 * Wiener paths. */
#pragma once

#include "modules/noise/compute/paths.h"

enum { ORDER_LEVELS_MAX = 12 };

/* A measurement of orders. */
struct orders_request {
    const struct noise_forcing *forcing;
    double span, dt; /* [s] dt: the largest step, which is halved `levels` times */
    int levels;
    int64_t paths;
    uint64_t seed;
};

/*
 * Comparison of a step with half of it on the same Wiener path, at the end of the span, in natural
 * sizes of the variables. `strong` is the root mean square distance of the two, `weak` the
 * difference of the mean of the sum of squares of the variables. Both decrease with dt as the
 * errors themselves do.
 */
struct order_level {
    double dt; /* [s] */
    struct measured strong, weak;
};

/* The measured orders of one method. */
struct method_orders {
    const struct noise_method *method;
    struct order_level level[ORDER_LEVELS_MAX];
    int levels;
    /* NAN means that an order is not known: fewer than three levels are beyond three standard
     * errors. */
    struct measured strong, weak;
    bool weak_is_exact; /* the scene is linear: weak errors are free of chance */
};

/* Returns the memory that a measurement takes [byte]. */
double noise_orders_bytes(const struct orders_request *request, int threads);
/* Returns the number of steps that all paths of a method take together. */
double noise_orders_steps(const struct orders_request *request);
/* Measures the orders of a method. Returns false with *error if out of memory, cancelled, or if a
 * path diverged. The result does not depend on the number of threads. */
bool noise_orders_measure(const struct orders_request *request, const struct noise_method *method,
                          struct parallel parallel, struct method_orders *orders,
                          struct error *error);
