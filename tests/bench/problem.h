/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What competitors are given; odeint.cpp reads it as C++. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum { PROBLEM_MAX = 4 /* variables */, PROBLEM_CHECKS = 8 };

/* ---- fixed steps ---- */

/*
 * q'' = -k q - gamma q' - c |q'| q' - b q^3 + drive cos(omega t + phase) + mu (1 - (q narrow)^2)
 * q', or -k sin q, or -k q/|q|^3
 */
struct known {
    double k, gamma, c, b, drive, omega, phase, mu, narrow;
    double fade; /* of v by linear drag in half a step: for loops */
};

/* Steps first + 1 … first + count; state in and out; row [count][n] */
typedef void hand_loop(const struct known *known, double h, int64_t first, int64_t count,
                       double *state, double *row);

/* ---- adaptive solves ---- */

struct problem {
    const char *name;
    int n;
    double span;
    struct check {
        double t, y[PROBLEM_MAX];
        /* the state at these times, the last at the end of the span; t 0: no more */
    } check[PROBLEM_CHECKS];
    double unit[PROBLEM_MAX];  /* what errors there are measured in */
    double scale[PROBLEM_MAX]; /* of error norms: tol max(scale, |y|) */
    void (*slope)(double t, const double *y, double *dydt);
    void (*jacobian)(double t, const double *y, double *jac); /* [n][n] row-major */
};

/* From `start` over the span; the state at the end. False: it did not get there. */
typedef bool solve_function(const struct problem *problem, double tol, const double *start,
                            double *end);

#ifdef HAVE_BOOST /* odeint.cpp */
solve_function boost_fehlberg78, boost_dopri5, boost_rosenbrock4;
solve_function boost_recorded; /* dopri5, with the times and states of all steps in memory */
hand_loop *boost_loop(const char *method, const char *scene); /* NULL: none */
#endif
