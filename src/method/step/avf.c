/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The average vector field method: y' = y + h times the mean of f on the straight line from y to
 * y'. The work of the mean force along the line is the difference of the potentials, so that energy
 * is conserved. Source: Quispel, McLaren 2008, J. Phys. A
 * 41:045206.
 *
 * The mean is computed by Gauss's quadrature with six nodes. It is exact for polynomials of degree
 * 11 or less along the line, and to rounding for smooth forces if the line is not longer than their
 * natural length.
 */
#include "method/step/newton.h"

/* Nodes of the quadrature. */
#define GAUSS_NODES 6

/* Nodes on [0, 1], the first half; the other is its mirror image (Abramowitz, Stegun 1964, table
 * 25.4). */
static const double node[GAUSS_NODES / 2] = {0.033765242898423986093849222753003,
                                             0.16939530676686774316930020249005,
                                             0.38069040695840154568474913915964};
static const double weight[GAUSS_NODES / 2] = {0.085662246189585172520148071086366,
                                               0.18038078652406930378491675691886,
                                               0.23395696728634552369493517199478};

/* The middle of the line represents all nodes in the Jacobian; for linear systems it is the mean
 * itself. */
static const double half[] = {1. / 2}, one[] = {1}, two[] = {2};
static const struct implicit_tableau middle = {
    .stages = 1, .c = half, .a = half, .b = one, .d = one, .real = 2, .left = two, .right = one};

/* Adds w f(t + c h, y + c z) to sum. */
static void add_node(struct step *step, double t, double h, double c, double w, const double *y,
                     const double *z, double *node_state, double *sum)
{
    int n = step->system->n;
    double slope[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        node_state[i] = y[i] + c * z[i];
    system_derivative(step->system, t + c * h, node_state, slope);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        sum[i] += w * slope[i];
}

/* Computes residual [n] = h (mean of f over the segment from y to y + z) - z, for a
 * newton_residual_function. A linear f has its mean in the middle; otherwise Gauss's rule is used.
 * `scratch` is work space. */
static void mean_residual(const struct newton *equations, struct step *step, int n, double t,
                          double h, const double *y, const double *z, double *scratch,
                          double *residual)
{
    (void)equations;
    for (int i = 0; i < n; i++)
        residual[i] = -0.0;
    if (step->system->linear) {
        add_node(step, t, h, 1. / 2, 1, y, z, scratch, residual);
    } else {
        for (int k = 0; k < GAUSS_NODES / 2; k++) {
            add_node(step, t, h, node[k], weight[k], y, z, scratch, residual);
            add_node(step, t, h, 1 - node[k], weight[k], y, z, scratch, residual);
        }
    }
    for (int i = 0; i < n; i++)
        residual[i] = h * residual[i] - z[i];
}

/* The work array holds increments [n], then the solver's work. */
size_t avf_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)n + newton_capacity(1, n);
}

/* Takes a step: solves z = h (mean of f) for the increment z, from 0. */
enum step_status avf_step(const struct method *method, struct step *step)
{
    (void)method;
    const struct newton mean = newton_of(&middle, mean_residual, step->system);
    int n = step->system->n;
    double *z = step->work, *own = z + n;
    if (!step->warm)
        newton_forget(own);
    memset(z, 0, (size_t)n * sizeof *z);
    enum step_status status = newton_solve(&mean, step, step->t, step->h, step->y, z, own);
    return status == STEP_OK ? step_increase(step, z) : status;
}
