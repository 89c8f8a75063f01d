/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The same problems by GSL's ODE drivers, with the same error norm; what they allocate is kept
 * between solves. */
#include "bench/bench.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <string.h>

static int slope(double t, const double *y, double *dydt, void *problem)
{
    ((const struct problem *)problem)->slope(t, y, dydt);
    return GSL_SUCCESS;
}

static int jacobian(double t, const double *y, double *jac, double *dfdt, void *problem)
{
    const struct problem *p = problem;
    p->jacobian(t, y, jac);
    memset(dfdt, 0, (size_t)p->n * sizeof *dfdt);
    return GSL_SUCCESS;
}

/* One driver is kept: solves of a contest come in batches with the same problem and tolerance. */
static bool solve(const gsl_odeiv2_step_type *type, const struct problem *problem, double tol,
                  const double *start, double *end)
{
    static struct {
        const gsl_odeiv2_step_type *type;
        struct problem problem;
        double tol;
        gsl_odeiv2_system system;
        gsl_odeiv2_driver *driver;
    } kept;
    if (!kept.driver || kept.type != type || kept.problem.slope != problem->slope ||
        kept.tol != tol) {
        if (kept.driver)
            gsl_odeiv2_driver_free(kept.driver);
        kept.type = type;
        kept.problem = *problem;
        kept.tol = tol;
        kept.system = (gsl_odeiv2_system){slope, jacobian, (size_t)problem->n, &kept.problem};
        kept.driver = gsl_odeiv2_driver_alloc_scaled_new(&kept.system, type, 1e-4, tol, tol, 1, 0,
                                                         kept.problem.scale);
        if (!kept.driver)
            return false;
    }
    double t = 0;
    memcpy(end, start, (size_t)problem->n * sizeof *end);
    gsl_set_error_handler_off();
    return gsl_odeiv2_driver_reset_hstart(kept.driver, 1e-4) == GSL_SUCCESS &&
           gsl_odeiv2_driver_apply(kept.driver, &t, problem->span, end) == GSL_SUCCESS;
}

bool gsl_rk8pd(const struct problem *problem, double tol, const double *start, double *end)
{
    return solve(gsl_odeiv2_step_rk8pd, problem, tol, start, end);
}

bool gsl_msbdf(const struct problem *problem, double tol, const double *start, double *end)
{
    return solve(gsl_odeiv2_step_msbdf, problem, tol, start, end);
}

bool gsl_bsimp(const struct problem *problem, double tol, const double *start, double *end)
{
    return solve(gsl_odeiv2_step_bsimp, problem, tol, start, end);
}

/* Each scene's terms, and no others; the library calls them through a pointer. */
#define LOOP(scene, value)                                                                         \
    static int scene(double t, const double *y, double *dydt, void *known)                         \
    {                                                                                              \
        const struct known *f = known;                                                             \
        (void)t;                                                                                   \
        dydt[0] = y[1];                                                                            \
        dydt[1] = value;                                                                           \
        return GSL_SUCCESS;                                                                        \
    }                                                                                              \
    static void scene##_loop(const struct known *known, double h, int64_t first, int64_t count,    \
                             double *state, double *row)                                           \
    {                                                                                              \
        rk4(scene, known, h, first, count, state, row);                                            \
    }

static void rk4(int (*force)(double, const double *, double *, void *), const struct known *known,
                double h, int64_t first, int64_t count, double *state, double *row)
{
    struct known copy = *known;
    const gsl_odeiv2_system system = {force, NULL, 2, &copy};
    gsl_odeiv2_step *step = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk4, 2);
    double error[2];
    for (int64_t i = 0; step && i < count; i++, row += 2) {
        gsl_odeiv2_step_apply(step, (double)(first + i) * h, h, state, error, NULL, NULL, &system);
        memcpy(row, state, 2 * sizeof *row);
    }
    gsl_odeiv2_step_free(step);
}

LOOP(duffing, -f->k *y[0] - f->b * y[0] * y[0] * y[0])
LOOP(drag, -f->k *y[0] - f->c * fabs(y[1]) * y[1])
LOOP(vanderpol, -f->k *y[0] + f->mu * (1 - y[0] * f->narrow * (y[0] * f->narrow)) * y[1])

hand_loop *gsl_loop(const char *method, const char *scene)
{
    (void)method;
    return strcmp(scene, "duffing") == 0          ? duffing_loop
           : strcmp(scene, "quadratic drag") == 0 ? drag_loop
                                                  : vanderpol_loop;
}
