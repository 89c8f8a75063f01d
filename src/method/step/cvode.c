/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * CVODE of SUNDIALS 6 behind the interface of a method, for comparison: one of its own steps at a
 * time, under its own control of order, step and error, with its dense solver and our exact
 * Jacobian.
 */
#include "method/step/step.h"

#ifdef HOOKE_SUNDIALS
#include <cvode/cvode.h>
#include <float.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#define STEPS_MOST 100000 /* limit of CVODE's steps in one of ours */

/* The solver's memory, made by cvode_begin(). */
struct cvode {
    SUNContext context;
    void *memory;
    N_Vector y, min; /* state in and out; absolute tolerances */
    SUNMatrix matrix;
    SUNLinearSolver linear;
    SUNNonlinearSolver fixed_point;
    const struct system *system;
    double tol;
    bool forward, wild;  /* wild means that a slope was not finite in this step */
    struct cost counted; /* cost since the last restart that has been added to the step's already */
};

/* Returns 0 if all numbers are finite; otherwise 1, which makes CVODE try a smaller step. */
static int check_finite(struct cvode *c, const double *x, int count_cost)
{
    for (int i = 0; i < count_cost; i++)
        if (!isfinite(x[i]))
            return c->wild = true;
    return 0;
}

/* Evaluates the right-hand side, for CVODE. */
static int slope(double t, N_Vector y, N_Vector f, void *data)
{
    struct cvode *c = data;
    system_derivative(c->system, t, N_VGetArrayPointer(y), N_VGetArrayPointer(f));
    return check_finite(c, N_VGetArrayPointer(f), c->system->n);
}

/* Evaluates the Jacobian, column by column, for CVODE. Returns -1 if out of memory. */
static int jacobian(double t, N_Vector y, N_Vector f, SUNMatrix matrix, void *data, N_Vector u,
                    N_Vector v, N_Vector w)
{
    (void)f, (void)u, (void)v, (void)w;
    struct cvode *c = data;
    const int n = c->system->n;
    double *rows = system_new_jacobian(c->system, t, N_VGetArrayPointer(y)),
           *columns = SUNDenseMatrix_Data(matrix);
    if (!rows)
        return -1;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            columns[j * n + i] = rows[i * n + j];
    free(rows);
    return check_finite(c, columns, n * n);
}

/* ---- memory ---- */

/* Frees the solver, also one that was made in part. */
void cvode_end(void *library)
{
    struct cvode *c = library;
    if (!c)
        return;
    CVodeFree(&c->memory);
    if (c->fixed_point)
        SUNNonlinSolFree(c->fixed_point);
    if (c->linear)
        SUNLinSolFree(c->linear);
    if (c->matrix)
        SUNMatDestroy(c->matrix);
    N_VDestroy(c->y);
    N_VDestroy(c->min);
    SUNContext_Free(&c->context);
    free(c);
}

/* Chooses fixed-point iteration for Adams and Newton's for backward differentiation, as CVODE's
 * manual recommends. Returns false if out of memory. */
static bool choose_solver(struct cvode *c, bool stiff, int n)
{
    if (!stiff)
        return (c->fixed_point = SUNNonlinSol_FixedPoint(c->y, 0, c->context)) &&
               CVodeSetNonlinearSolver(c->memory, c->fixed_point) == CV_SUCCESS;
    return (c->matrix = SUNDenseMatrix(n, n, c->context)) &&
           (c->linear = SUNLinSol_Dense(c->y, c->matrix, c->context)) &&
           CVodeSetLinearSolver(c->memory, c->linear, c->matrix) == CV_SUCCESS &&
           CVodeSetJacFn(c->memory, jacobian) == CV_SUCCESS;
}

/* Creates a solver for the size of the system. Returns NULL if out of memory. */
void *cvode_begin(const struct method *method, const struct step *step)
{
    const int n = step->system->n;
    const bool stiff = method->flags & METHOD_IMPLICIT;
    struct cvode *c = calloc(1, sizeof *c);
    if (!c)
        return NULL;
    c->system = step->system;
    if (SUNContext_Create(NULL, &c->context) == 0 && (c->y = N_VNew_Serial(n, c->context)) &&
        (c->min = N_VNew_Serial(n, c->context)) &&
        (c->memory = CVodeCreate(stiff ? CV_BDF : CV_ADAMS, c->context)) &&
        CVodeSetErrFile(c->memory, NULL) == CV_SUCCESS &&
        CVodeSetMaxHnilWarns(c->memory, -1) == CV_SUCCESS &&
        CVodeInit(c->memory, slope, 0, c->y) == CV_SUCCESS &&
        CVodeSetUserData(c->memory, c) == CV_SUCCESS && choose_solver(c, stiff, n))
        return c;
    cvode_end(c);
    return NULL;
}

/* ---- stepping ---- */

/* Restarts the solver at the step's t and y, without history. Returns false on failure. */
static bool solver_restart(struct cvode *c, const struct step *step, bool forward)
{
    const int n = step->system->n;
    double *min = N_VGetArrayPointer(c->min);
    memcpy(N_VGetArrayPointer(c->y), step->y, (size_t)n * sizeof *step->y);
    for (int i = 0; i < n; i++)
        min[i] = c->tol * step_scale(step)[i];
    c->system = step->system;
    c->forward = forward;
    c->counted = (struct cost){0};
    return CVodeReInit(c->memory, step->t, c->y) == CV_SUCCESS &&
           CVodeSVtolerances(c->memory, c->tol, c->min) == CV_SUCCESS;
}

/* Adds what the solver has spent since the last call to *cost. */
static void count_cost(struct cvode *c, struct cost *cost)
{
    long evals = 0, jacobians = 0, iterations = 0, refused = 0, unsolved = 0;
    CVodeGetNumRhsEvals(c->memory, &evals);
    CVodeGetNumErrTestFails(c->memory, &refused);
    CVodeGetNumStepSolveFails(c->memory, &unsolved);
    if (c->linear) { /* each iteration is one solve */
        CVodeGetNumJacEvals(c->memory, &jacobians);
        CVodeGetNumNonlinSolvIters(c->memory, &iterations);
    }
    const struct cost now = {.evals = evals,
                             .jacobians = jacobians,
                             .solves = iterations,
                             .rejected = refused + unsolved};
    cost->evals += now.evals - c->counted.evals;
    cost->jacobians += now.jacobians - c->counted.jacobians;
    cost->solves += now.solves - c->counted.solves;
    cost->rejected += now.rejected - c->counted.rejected;
    c->counted = now;
}

/* Translates CVODE's flag; moved tells if the time has changed. */
static enum step_status cvode_status(int flag, bool moved, bool wild)
{
    const bool done = flag == CV_SUCCESS || flag == CV_TSTOP_RETURN;
    if (done && moved)
        return STEP_OK;
    if (wild)
        return STEP_NONFINITE;
    return done || flag == CV_ERR_FAILURE || flag == CV_TOO_CLOSE || flag == CV_TOO_MUCH_ACC
               ? STEP_STALLED
               : STEP_NO_SOLUTION;
}

/* Takes one step of CVODE's own size towards t_end. Sets *t to the time reached; the state is in
 * c->y. */
static enum step_status solver_step(struct cvode *c, struct cost *cost, double t_begin,
                                    double t_end, double *t)
{
    const struct system *system = c->system;
    /* Only the sign and the size of the distance matter, for the first step. */
    const double natural = system->order == 2 ? system->scale[0] / system->scale[system->n / 2] : 1;
    const double towards = isfinite(t_end) ? t_end : t_begin + copysign(natural, t_end);
    c->wild = false;
    int flag = CVodeSetStopTime(c->memory, t_end);
    if (flag == CV_SUCCESS)
        flag = CVode(c->memory, towards, c->y, t, CV_ONE_STEP);
    count_cost(c, cost);
    return cvode_status(flag, *t != t_begin, c->wild);
}

/* Ends a step: copies state and error estimate if the state is finite. */
static enum step_status cvode_take_state(struct cvode *c, struct step *step)
{
    if (step->error) {
        CVodeGetEstLocalErrors(c->memory, c->min);
        memcpy(step->error, N_VGetArrayPointer(c->min),
               (size_t)step->system->n * sizeof *step->error);
    }
    return step_finish(step, N_VGetArrayPointer(c->y));
}

/* Takes one step of a length that CVODE chooses, towards t_end [s]. Restarts CVODE first if the
 * state was changed from outside (step->warm is false) or if the direction of time has changed.
 * Returns the status of the step. */
enum step_status cvode_adapt(const struct method *method, struct step *step,
                             struct controller *controller, double t_end)
{
    (void)method;
    struct cvode *c = step->library;
    const bool forward = t_end > step->t;
    double t = step->t;
    if (!c)
        return STEP_NO_SOLUTION;
    c->system = step->system; /* the system may have been frozen anew */
    c->tol = fmax(controller->tol, 10 * DBL_EPSILON);
    enum step_status status = STEP_OK;
    if ((!step->warm || forward != c->forward) && !solver_restart(c, step, forward))
        status = STEP_NO_SOLUTION;
    if (status == STEP_OK)
        status = solver_step(c, &step->cost, step->t, t_end, &t);
    if (status == STEP_OK)
        status = cvode_take_state(c, step);
    step->warm = status == STEP_OK;
    if (status != STEP_OK)
        return status;
    step->h = controller->last = t - step->t;
    step->t = t;
    CVodeGetCurrentStep(c->memory, &controller->h);
    return STEP_OK;
}

/* Steps over a given distance inside a step that was taken before, with as many of CVODE's steps as
 * the tolerance asks for. */
enum step_status cvode_step(const struct method *method, struct step *step)
{
    (void)method;
    struct cvode *c = step->library;
    const double end = step->t + step->h;
    double t = step->t;
    if (!c || c->tol == 0 || !solver_restart(c, step, step->h > 0))
        return STEP_NO_SOLUTION;
    for (int i = 0; t != end; i++) {
        enum step_status status =
            i < STEPS_MOST ? solver_step(c, &step->cost, t, end, &t) : STEP_STALLED;
        if (status != STEP_OK)
            return status;
    }
    return cvode_take_state(c, step);
}

/* Evaluates the polynomial of CVODE's history (Nordsieck's array), from which its next step
 * starts. */
void cvode_dense(const struct method *method, const struct step *step, double theta, double *y)
{
    (void)method;
    const struct cvode *c = step->library;
    const int n = step->system->n;
    const bool there =
        CVodeGetDky(c->memory, step->t - (1 - theta) * step->h, 0, c->y) == CV_SUCCESS;
    for (int i = 0; i < n; i++)
        y[i] = there ? N_VGetArrayPointer(c->y)[i] : NAN;
}
#endif
