/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Exact propagators of linear scenes and their derivatives: exponentials of block matrices (Van
 * Loan 1978, IEEE Trans. AC-23:395). */
#include <hooke/base/numeric.h>

#include "modules/recording/scene/linear.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Different step lengths that are prepared; variables; size of the block matrix. */
enum { STEPS_MOST = 24, BLOCK = LIMIT_VARIABLES / 2, AUGMENTED = 2 * BLOCK + 1 };

#define SAME_STEP_RELATIVE 1e-9        /* relative difference up to which steps are equal */
#define TIME_ROUNDING_RELATIVE 4.4e-16 /* relative rounding of a time */

/* The propagator of one step length, in the notation of linear.h. */
struct linear_propagator {
    double dt;
    bool ready;        /* base and direction are computed */
    double *base;      /* [n][n + 1]: E | e */
    double *direction; /* [directions][n][n + 1]: F_j | f_j */
};

struct linear_motion {
    struct linear_propagator step[STEPS_MOST];
    int steps, last; /* number of steps; the one that was used last */
    int n, directions;
    const struct variation *variation;
    /* A and b of the motion; B_j and c_j of all directions, one below the other. */
    double a[BLOCK * BLOCK], b[BLOCK];
    double coupling[LIMIT_VARIABLES * BLOCK], c[LIMIT_VARIABLES];
    double scratch[3][AUGMENTED * AUGMENTED]; /* 100 kB: too much for a stack */
    double storage[];                         /* values of the propagators */
};

/* Number of values of a propagator at most. */
static const size_t storage_each = (size_t)LIMIT_VARIABLES * (BLOCK + 1);

/* Returns true if a step length is the wanted one within rounding, at the time t. */
static bool same_step(double dt, double wanted, double t)
{
    return fabs(dt - wanted) <= SAME_STEP_RELATIVE * dt + TIME_ROUNDING_RELATIVE * fabs(t);
}

/* Returns the index of a step of the wanted length, or -1 if there is none. */
static int find_step(const struct linear_motion *m, double wanted, double t)
{
    if (m->last < m->steps && same_step(m->step[m->last].dt, wanted, t))
        return m->last;
    for (int k = 0; k < m->steps; k++)
        if (same_step(m->step[k].dt, wanted, t))
            return k;
    return -1;
}

/* Sets up step k with length dt in its place in the storage; it has to be prepared before use. */
static void step_position(struct linear_motion *m, int k, double dt)
{
    struct linear_propagator *p = &m->step[k];
    p->dt = dt;
    p->base = m->storage + (size_t)k * storage_each;
    p->direction = p->base + m->n * (m->n + 1);
    p->ready = false;
}

/* Collects the different step lengths between t0 and the times t [n], in m->step. Returns false if
 * they are too many. */
static bool collect_steps(struct linear_motion *m, double t0, const double *t, size_t n)
{
    double t_reached = t0;
    for (size_t i = 0; i < n; i++) {
        const double wanted = t[i] - t_reached;
        if (!(wanted > TIME_ROUNDING_RELATIVE * fabs(t[i])))
            continue;
        int k = find_step(m, wanted, t[i]);
        if (k < 0 && m->steps == STEPS_MOST)
            return false;
        if (k < 0) {
            k = m->steps++;
            step_position(m, k, wanted);
        }
        t_reached += m->step[k].dt;
        m->last = k;
    }
    return true;
}

struct linear_motion *linear_motion_create(double t0, const double *t, size_t n)
{
    struct linear_motion *m = calloc(1, sizeof *m + STEPS_MOST * storage_each * sizeof(double));
    if (m && !collect_steps(m, t0, t, n)) {
        free(m);
        return NULL;
    }
    return m;
}

/* Reads the matrices of the linear system off its derivatives at unit states: y' = A y + b, and for
 * `directions` sensitivities S_j' = A S_j + B_j y + c_j. */
void linear_motion_bind(struct linear_motion *m, const struct variation *v, int directions)
{
    const struct system *system = directions > 0 ? &v->whole : &v->base;
    const int n = v->base.n;
    double y[LIMIT_VARIABLES] = {0}, still[LIMIT_VARIABLES], rate[LIMIT_VARIABLES];
    m->n = n;
    m->directions = directions;
    m->variation = v;
    m->last = 0;
    system_derivative(system, v->base.t0, y, still);
    memcpy(m->b, still, (size_t)n * sizeof *still);
    memcpy(m->c, still + n, (size_t)(n * directions) * sizeof *still);
    for (int j = 0; j < n; j++) {
        y[j] = 1;
        system_derivative(system, v->base.t0, y, rate);
        y[j] = 0;
        for (int i = 0; i < n; i++)
            m->a[i * n + j] = rate[i] - still[i];
        for (int i = 0; i < n * directions; i++)
            m->coupling[i * n + j] = rate[n + i] - still[n + i];
    }
    for (int k = 0; k < m->steps; k++)
        step_position(m, k, m->step[k].dt);
}

/* Computes the propagator p of a step of p->dt: the exponential of [A 0 b; B A c; 0 0 0] dt
 * contains the matrices E and F of state and sensitivities and the constants e and f. */
static void prepare_linear_step(struct linear_motion *m, struct linear_propagator *p)
{
    double *x = m->scratch[0];
    const int n = m->n, blocks = m->directions > 0 ? m->directions : 1;
    const int all = m->directions > 0 ? 2 * n + 1 : n + 1;
    for (int block = 0; block < blocks; block++) {
        memset(x, 0, sizeof m->scratch[0]);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                x[i * all + j] = m->a[i * n + j] * p->dt;
                if (m->directions > 0) {
                    x[(n + i) * all + n + j] = x[i * all + j];
                    x[(n + i) * all + j] = m->coupling[(block * n + i) * n + j] * p->dt;
                }
            }
            x[i * all + all - 1] = m->b[i] * p->dt;
            if (m->directions > 0)
                x[(n + i) * all + all - 1] = m->c[block * n + i] * p->dt;
        }
        const double power = matrix_exponential(all, x, m->scratch[1]);
        for (int i = 0; i < all * all && power != 0; i++)
            x[i] = ldexp(x[i], (int)power);
        for (int i = 0; i < n; i++) {
            double *e = p->base + i * (n + 1), *f = p->direction + (block * n + i) * (n + 1);
            memcpy(e, x + i * all, (size_t)n * sizeof *e);
            e[n] = x[i * all + all - 1];
            if (m->directions > 0) {
                memcpy(f, x + (n + i) * all, (size_t)n * sizeof *f);
                f[n] = x[(n + i) * all + all - 1];
            }
        }
    }
    p->ready = true;
}

/* ---- the motion ---- */

/* Advances the state of n variables and its `directions` sensitivities by one step. It is inlined
 * for constant n, which lets loops unroll. */
static inline __attribute__((always_inline)) void
propagator_advance(int n, int directions, const struct linear_propagator *p, double *state)
{
    double next[BLOCK];
    for (int block = directions; block >= 0;
         block--) { /* those by parameters first: they need y as it was */
        const double *f = p->direction + (block - 1) * n * (n + 1);
        double *s = state + block * n;
        for (int i = 0; i < n; i++) {
            double sum = block > 0 ? f[i * (n + 1) + n] : p->base[i * (n + 1) + n];
            for (int j = 0; j < n; j++) {
                sum += p->base[i * (n + 1) + j] * s[j];
                if (block > 0)
                    sum += f[i * (n + 1) + j] * state[j];
            }
            next[i] = sum;
        }
        for (int i = 0; i < n; i++)
            s[i] = next[i];
    }
}

/* Advances `state` from t_begin to t [s] by the propagator of a step of that length, which is taken
 * from m->step or prepared there. Returns the time reached, or t_begin if t is not later. */
double linear_motion_advance(struct linear_motion *m, double t_begin, double t, double *state)
{
    const double wanted = t - t_begin;
    if (!(wanted > TIME_ROUNDING_RELATIVE * fabs(t)))
        return t_begin;
    int k = find_step(m, wanted, t);
    if (k < 0) { /* a step that was not collected replaces another */
        k = m->steps < STEPS_MOST ? m->steps++ : (m->last + 1) % STEPS_MOST;
        step_position(m, k, wanted);
    }
    m->last = k;
    struct linear_propagator *p = &m->step[m->last];
    if (!p->ready)
        prepare_linear_step(m, p);
    if (m->n == 2)
        propagator_advance(2, m->directions, p, state);
    else
        propagator_advance(m->n, m->directions, p, state);
    return t_begin + p->dt;
}
