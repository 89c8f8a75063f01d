/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Newton's iteration for the stages of implicit methods. newton_of() describes the equations;
 * newton_solve() solves them; newton_filter() applies the same matrix to an error estimate. */
#pragma once

#include "method/step/step.h"

/*
 * The equations for the increments z [stages][n] of all stages over y. The Jacobian of `residual`
 * is that of h sum_j a_ij f(t + c_j h, y + z_j) - z_i, as far as convergence needs it.
 */
struct newton;
/* Computes the Jacobian jac [n][n] at t and y; forces is data of the function. */
typedef void jacobian_function(const void *forces, double t, const double *y, double *jac);
/* Computes `residual` [stages][n] of the equations at z; scratch has [stages][n]. */
typedef void newton_residual_function(const struct newton *equations, struct step *step, int n,
                                      double t, double h, const double *y, const double *z,
                                      double *scratch, double *residual);

/* The equations of one step's stages. */
struct newton {
    const struct implicit_tableau *tableau;
    newton_residual_function *residual; /* newton_stages() or the method's own */
    slope_function *slope;
    jacobian_function *jacobian;
    const void *forces; /* data of the last two functions */
};

extern const struct implicit_tableau newton_euler; /* one stage: z = h f(t, y + z) */

/* Returns the equations for a system; see struct newton. */
struct newton newton_of(const struct implicit_tableau *tableau, newton_residual_function *residual,
                        const struct system *system);
newton_residual_function newton_stages;

/*
 * Solves the equations. z is a guess, which the solution replaces (undefined unless STEP_OK). The
 * solution is as exact as rounding allows or, in steps of method_adapt(), as exact as the tolerance
 * asks for. A linear system takes one solve. work has newton_capacity() doubles that belong to
 * these equations. They keep the factors of the matrix from call to call and step to step, where
 * that changes nothing (linear systems) or little (adaptive steps); newton_forget() discards them.
 */
enum step_status newton_solve(const struct newton *equations, struct step *step, double t, double h,
                              const double *y, double *z, double *work);
size_t newton_capacity(int stages, int n);
void newton_forget(double *work);

/*
 * Finds the solution that is reached from h = 0 in shorter and shorter parts of h, each of which
 * contracts: the one that belongs to y. z receives it, and is unchanged if there is none (the
 * branch turns back before h). weight [n] holds 1/size of each variable. Source: Deuflhard 2011,
 * Newton Methods for Nonlinear Problems, 5.1.
 */
bool newton_follow(const struct newton *equations, struct step *step, int n, double t, double h,
                   const double *y, double *z, const double *weight, double *work);

/* Replaces x [n] by (real - h J)^-1 x. J is taken at y, unless the factors for this h exist.
 * Returns false if the matrix is singular. */
bool newton_filter(const struct implicit_tableau *tableau, struct step *step, double t, double h,
                   const double *y, double *x, double *work);

/*
 * Solves z = h f(t, y + z) and gives y + z as well: in closed form for the oscillator, else by
 * newton_solve() with newton_euler.
 */
enum step_status newton_stage(struct step *step, double t, double h, const double *y, double *z,
                              double *sum, double *work);
