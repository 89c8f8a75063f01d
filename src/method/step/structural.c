/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The methods of structural dynamics (Newmark, HHT, generalised alpha, Wilson): one scheme for y''
 * = F(t, y, v) that carries the acceleration a from step to step. With tau = theta h and values y+,
 * v+, a+ at t + tau:
 *
 *   y+ = y + tau v + tau^2 ((1/2 - beta) a + beta a+)
 *   v+ = v + tau ((1 - gamma) a + gamma a+)
 *   (1 - alpha_m) a+ + alpha_m a = F at the fraction 1 - alpha_f of the way from y, v to y+, v+
 *   a' = a + (a+ - a) / theta, and y', v' by the first lines over h.
 *
 * Source: Newmark 1959; Wilson 1973 (theta); Hilber, Hughes, Taylor 1977 (alpha_f); Chung, Hulbert
 * 1993 (both alphas).
 */
#include "method/step/newton_body.h"

/* Parameters of the scheme. */
struct structural {
    double theta, alpha_m, alpha_f, beta, gamma;
};

/* Relative increment above which rounding loses so many digits that a linear system needs a second
 * solve. */
static const double SOLVE_TWICE_MIN = 8;

/*
 * Returns the size of work, which holds the acceleration [n/2], a+, its increment, F and factors,
 * the state's increment (in place of F), the Jacobian, and the memory of newton_follow().
 */
size_t structural_work(const struct method *method, int n)
{
    (void)method;
    return 4 * (size_t)(n / 2) + LU_ROOM(n / 2) + 2 * (size_t)n + (size_t)n * (size_t)n +
           newton_capacity(1, n);
}

/* Computes the LU factors [d x d], d = n/2, of (1 - alpha_m) - (1 - alpha_f) (beta tau^2 dF/dy +
 * gamma tau dF/dv), the Newton matrix of a step of length tau, with derivatives at time t and
 * `state` [n]. jacobian [n x n] is work space. Returns false if the matrix is singular. */
static bool factor_matrix(const struct structural *s, struct step *step, double t, double tau,
                          const double *state, double *jacobian, double *factors)
{
    int n = step->system->n, d = n / 2;
    double part = 1 - s->alpha_f, by_position = part * s->beta * tau * tau,
           by_velocity = part * s->gamma * tau;
    system_jacobian(step->system, t, state, jacobian);
    step->cost.jacobians++;
    for (int i = 0; i < d; i++) {
        const double *row = jacobian + (d + i) * n;
        for (int j = 0; j < d; j++)
            factors[i * d + j] =
                (i == j ? 1 - s->alpha_m : 0) - (by_position * row[j] + by_velocity * row[d + j]);
    }
    return lu_factor(d, factors);
}

/* Returns the largest of the state's increments that belong to the increment `move` of the
 * acceleration, relative to the sizes of variables; NaN if one is NaN. */
static double move_size(const struct step *step, double by_position, double by_velocity,
                        const double *move)
{
    int n = step->system->n, d = n / 2;
    double largest = 0;
    for (int i = 0; i < n; i++) {
        const double increment = i < d ? by_position * move[i] : by_velocity * move[i - d];
        double size = fabs(increment) / fmax(step->system->scale[i], fabs(step->y[i]));
        if (!(size <= largest))
            largest = size;
    }
    return largest;
}

/* ---- the solution that belongs to the start ---- */

/* Data of the equation of a step for the state's increment z over h, in which a+ is expressed by
 * the increment of the velocities. */
struct increment {
    const struct structural *structural;
    const struct system *system;
    const double *y, *a; /* [n], [n/2] */
};

/* Sets y_mid to the fraction 1 - alpha_f of the way from y to y_end. */
static void structural_midpoint(const struct increment *increment, const double *y_end,
                                double *y_mid)
{
    for (int i = 0; i < increment->system->n; i++)
        y_mid[i] =
            increment->y[i] + (1 - increment->structural->alpha_f) * (y_end[i] - increment->y[i]);
}

/*
 * Computes the residual of the equations, for a newton_residual_function:
 *
 * z_y = h (v + beta/gamma z_v) + h^2 (1/2 - beta/gamma) a,  z_v = h (a + gamma (F - a) / (1 -
 * alpha_m))
 */
static void increment_residual(const struct newton *equations, struct step *step, int n, double t,
                               double h, const double *y, const double *z, double *force,
                               double *residual)
{
    const struct increment *all = equations->forces;
    const struct structural *s = all->structural;
    const int d = n / 2;
    const double ratio = s->beta / s->gamma, *a = all->a;
    double y_end[LIMIT_VARIABLES], y_mid[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        y_end[i] = y[i] + z[i];
    structural_midpoint(all, y_end, y_mid);
    system_acceleration(all->system, t + equations->tableau->c[0] * h, y_mid, force);
    step->cost.evals++;
    for (int i = 0; i < d; i++) {
        residual[i] = h * (y[d + i] + ratio * z[d + i] + h * (1. / 2 - ratio) * a[i]) - z[i];
        residual[d + i] = h * (a[i] + s->gamma * (force[i] - a[i]) / (1 - s->alpha_m)) - z[d + i];
    }
}

/* Computes the Jacobian of what the equations multiply by h, at the end y_end of the step, for a
 * jacobian_function. */
static void increment_jacobian(const void *forces, double t, const double *y_end, double *jacobian)
{
    const struct increment *all = forces;
    const struct structural *s = all->structural;
    const int n = all->system->n, d = n / 2;
    double y_mid[LIMIT_VARIABLES] = {0};
    structural_midpoint(all, y_end, y_mid);
    system_jacobian(all->system, t, y_mid, jacobian);
    for (int i = 0; i < d; i++)
        for (int j = 0; j < n; j++) {
            jacobian[i * n + j] = j == d + i ? s->beta / s->gamma : 0;
            jacobian[(d + i) * n + j] *= s->gamma * (1 - s->alpha_f) / (1 - s->alpha_m);
        }
}

/* Finds the increment z [n] of a step of length tau [s] by continuing the solution from a step of
 * length 0 (newton_follow()), for steps in which Newton iterations fail or find another root. Sets
 * y_mid [n] to the state at the fraction 1 - alpha_f of the step, and ahead [n/2] to the
 * acceleration at the end, from (1 - alpha_m) ahead + alpha_m a = acceleration at y_mid. a [n/2] is
 * the acceleration at the start, `work` space for newton_follow(). Returns false if no solution is
 * found. */
static bool structural_follow(const struct structural *s, struct step *step, double tau,
                              const double *a, double *ahead, double *z, double *y_mid,
                              double *work)
{
    const int n = step->system->n;
    const double fraction = 1 - s->alpha_f;
    struct implicit_tableau tableau = newton_euler;
    tableau.c = &fraction;
    const struct increment all = {.structural = s, .system = step->system, .y = step->y, .a = a};
    const struct newton equations = {.tableau = &tableau,
                                     .residual = increment_residual,
                                     .jacobian = increment_jacobian,
                                     .forces = &all};
    double weight[LIMIT_VARIABLES] = {0};
    newton_weights(step_scale(step), n, step->y, weight);
    if (!newton_follow(&equations, step, n, step->t, tau, step->y, z, weight, work))
        return false;
    for (int i = 0; i < n; i++)
        y_mid[i] = step->y[i] + fraction * z[i];
    system_acceleration(step->system, step->t + fraction * tau, y_mid, ahead);
    step->cost.evals++;
    for (int i = 0; i < n / 2; i++)
        ahead[i] = (ahead[i] - s->alpha_m * a[i]) / (1 - s->alpha_m);
    return true;
}

/* ---- a step ---- */

/* Solves the implicit equations of a generalized-alpha step of length tau by Newton iterations. a
 * [n/2] is the acceleration at the start. The results are ahead [n/2], the acceleration at the end,
 * and z [n], the increment of the state; both are iterated side by side, so that neither is a
 * difference with the rounding of the other. The arrays continue with work space behind these
 * elements. Sets *is_near_root as newton_iterate() does: to false if the increments shrink too
 * slowly or a Newton matrix has a negative determinant, since the solution may then belong to
 * another root. Returns STEP_NO_SOLUTION if the iteration does not converge. */
static enum step_status structural_iterate(const struct structural *s, struct step *step,
                                           double tau, const double *a, double *ahead, double *z,
                                           bool *is_near_root)
{
    const struct system *system = step->system;
    const int n = system->n, d = n / 2;
    const double *y = step->y, t = step->t + (1 - s->alpha_f) * tau;
    const double by_position = s->beta * tau * tau, by_velocity = s->gamma * tau;
    double *move = ahead + d, *force = move + d, *factors = force + d, *y_mid = z + n,
           *jacobian = y_mid + n;
    for (int i = 0; i < d; i++) {
        ahead[i] = a[i];
        z[i] = tau * y[d + i] + tau * tau / 2 * a[i];
        z[d + i] = tau * a[i];
    }
    double last = HUGE_VAL;
    *is_near_root = true;
    for (int iteration = 0; iteration < ITERATIONS; iteration++) {
        for (int i = 0; i < n; i++)
            y_mid[i] = y[i] + (1 - s->alpha_f) * z[i];
        system_acceleration(system, t, y_mid, force);
        step->cost.evals++;
        for (int i = 0; i < d; i++) {
            move[i] = force[i] - ((1 - s->alpha_m) * ahead[i] + s->alpha_m * a[i]);
            if (!isfinite(move[i]))
                return iteration == 0 ? STEP_NONFINITE : STEP_NO_SOLUTION;
        }
        if (iteration == 0 && !factor_matrix(s, step, t, tau, y_mid, jacobian, factors))
            return STEP_NO_SOLUTION;
        *is_near_root = *is_near_root && !lu_negative(d, factors);
        lu_solve(d, factors, move);
        step->cost.solves++;
        for (int i = 0; i < d; i++) {
            ahead[i] += move[i];
            z[i] += by_position * move[i];
            z[d + i] += by_velocity * move[i];
        }
        double size = move_size(step, by_position, by_velocity, move);
        if (size > CONTRACTION_MAX * last && size > INCREMENT_STALL_RELATIVE)
            *is_near_root = false;
        if ((system->linear && size <= SOLVE_TWICE_MIN) || size <= DBL_EPSILON / 2 ||
            (size >= last && size <= INCREMENT_STALL_RELATIVE))
            return STEP_OK;
        if (!system->linear && size > JACOBIAN_REUSE_RATE * last) {
            for (int i = 0; i < n; i++)
                y_mid[i] = y[i] + (1 - s->alpha_f) * z[i];
            if (!factor_matrix(s, step, t, tau, y_mid, jacobian, factors))
                return STEP_NO_SOLUTION;
        }
        last = size;
    }
    *is_near_root = false;
    return last <= INCREMENT_STALL_RELATIVE ? STEP_OK : STEP_NO_SOLUTION;
}

/* Finds the solution that belongs to y. If the iteration may have found another one, the solution
 * is followed from h = 0. */
static enum step_status structural_solve(const struct structural *s, struct step *step, double tau,
                                         const double *a, double *ahead, double *z)
{
    const int n = step->system->n;
    bool is_near_root;
    const enum step_status status = structural_iterate(s, step, tau, a, ahead, z, &is_near_root);
    if (step->system->linear || status == STEP_NONFINITE || (status == STEP_OK && is_near_root))
        return status;
    return structural_follow(s, step, tau, a, ahead, z, z + n, z + 2 * n + n * n) ? STEP_OK
                                                                                  : status;
}

/* Takes a step; work holds the acceleration at its start, if it is warm, and receives that at its
 * end. */
static enum step_status structural_step(const struct structural *s, struct step *step)
{
    const int n = step->system->n, d = n / 2;
    const double h = step->h, *y = step->y;
    double *a = step->work, *ahead = a + d, *z = ahead + 3 * d + LU_ROOM(d);
    if (!step->warm) {
        system_acceleration(step->system, step->t, y, a);
        step->cost.evals++;
    }
    enum step_status status = structural_solve(s, step, s->theta * h, a, ahead, z);
    if (status != STEP_OK)
        return status;
    if (s->theta != 1)
        for (int i = 0; i < d; i++) {
            ahead[i] = a[i] + (ahead[i] - a[i]) / s->theta;
            z[i] = h * y[d + i] + h * h * ((1. / 2 - s->beta) * a[i] + s->beta * ahead[i]);
            z[d + i] = h * ((1 - s->gamma) * a[i] + s->gamma * ahead[i]);
        }
    memcpy(a, ahead, (size_t)d * sizeof *a);
    return step_increase(step, z);
}

/* Takes a step of Newmark's method with constant mean acceleration. */
enum step_status newmark_step(const struct method *method, struct step *step)
{
    (void)method;
    return structural_step(&(const struct structural){.theta = 1, .beta = 1. / 4, .gamma = 1. / 2},
                           step);
}

/* Takes a step with alpha_f = 0.1, so that beta = (1 + alpha_f)^2/4 and gamma = 1/2 + alpha_f. */
enum step_status hht_step(const struct method *method, struct step *step)
{
    (void)method;
    return structural_step(
        &(const struct structural){.theta = 1, .alpha_f = 0.1, .beta = 0.3025, .gamma = 0.6}, step);
}

/*
 * Takes a step of the method with rho = 0.8. alpha_m = (2 rho - 1)/(rho + 1), alpha_f = rho/(rho +
 * 1), beta = (1 - alpha_m + alpha_f)^2/4, gamma = 1/2 - alpha_m + alpha_f.
 */
enum step_status generalised_alpha_step(const struct method *method, struct step *step)
{
    (void)method;
    return structural_step(
        &(const struct structural){
            .theta = 1, .alpha_m = 1. / 3, .alpha_f = 4. / 9, .beta = 25. / 81, .gamma = 11. / 18},
        step);
}

/* Takes a step with linear acceleration up to 1.4 h. */
enum step_status wilson_theta_step(const struct method *method, struct step *step)
{
    (void)method;
    return structural_step(
        &(const struct structural){.theta = 1.4, .beta = 1. / 6, .gamma = 1. / 2}, step);
}

/* ---- growth per step, by the amplification matrix of position, velocity and acceleration ---- */

/* Adds the acceleration of q'' + c0 q' + c1 q = 0, as a term. */
static void oscillator_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    a[0] -= c[1] * y[0] + c[0] * y[1];
}

/* Adds the derivatives of that acceleration. */
static void oscillator_jacobian(const double *c, double t, const double *y, double *jac)
{
    (void)t, (void)y;
    jac[0] -= c[1];
    jac[1] -= c[0];
}

/* Returns the largest absolute eigenvalue of m [3][3]. Bisection finds one real root of the
 * characteristic polynomial r^3 - a r^2 + b r - c; the other two solve a quadratic equation. */
static double spectral_radius(const double m[9])
{
    double a = m[0] + m[4] + m[8];
    double b =
        (m[0] * m[4] - m[1] * m[3]) + (m[0] * m[8] - m[2] * m[6]) + (m[4] * m[8] - m[5] * m[7]);
    double c = m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
               m[2] * (m[3] * m[7] - m[4] * m[6]);
    double high = 1 + fmax(fabs(a), fmax(fabs(b), fabs(c))), low = -high; /* Cauchy's bound */
    if (!isfinite(high))
        return NAN;
    for (int i = 0; i < 200; i++) {
        double r = low + (high - low) / 2;
        *(((r - a) * r + b) * r - c < 0 ? &low : &high) = r;
    }
    double sum = a - low, product = b - low * sum, split = sum * sum / 4 - product;
    return fmax(fabs(low), split >= 0 ? fabs(sum) / 2 + sqrt(split) : sqrt(product));
}

/* Returns the growth per step on an oscillation, by stepping three unit vectors; the acceleration
 * is part of the state. */
double structural_growth(const struct method *method, double x, double zeta,
                         enum stiffness_sign sign)
{
    static const struct term_row row = {.flags = TERM_LINEAR | TERM_VELOCITY,
                                        .add = oscillator_add,
                                        .jacobian = oscillator_jacobian};
    const struct system system = {.n = 2,
                                  .order = 2,
                                  .terms = 1,
                                  .term = {{&row, {2 * zeta, stiffness_sign_value(sign)}}},
                                  .linear = true,
                                  .autonomous = true,
                                  .velocity = true,
                                  .mass = 1,
                                  .scale = {1, 1}};
    double matrix[9];
    /* columns have units of 1, 1/x and 1/x^2, so that no entry is large */
    for (int column = 0; column < 3; column++) {
        double work[64], y[2] = {column == 0, column == 1 ? 1 / x : 0};
        struct step step = {.system = &system, .h = x, .y = y, .work = work, .warm = true};
        work[0] = column == 2 ? 1 / x / x : 0;
        if (method->step(method, &step) != STEP_OK)
            return NAN;
        matrix[column] = y[0];
        matrix[3 + column] = y[1] * x;
        matrix[6 + column] = work[0] * x * x;
    }
    return spectral_radius(matrix);
}
