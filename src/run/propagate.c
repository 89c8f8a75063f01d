/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Propagator of a linear scene of two variables without drive, for steps of fixed size. Every
 * one-step method is y' = M y + s. M is found by stepping the unit vectors, once; then a block of
 * steps is M, M^2, … M^BLOCK_STEPS times the state at its beginning, all independent of one
 * another. No forces are evaluated.
 *
 * Powers are taken in long double, and the state at a block's end is computed in it, so that the
 * determinant of a symplectic method is 1 to 1e-18 and nothing drifts. Against the step-by-step
 * path the states differ by a few eps a step in units of the amplitude. Blocks begin at multiples
 * of BLOCK_STEPS steps of the grid, so a run that is interrupted and continued gives the same bits.
 */
#include "run/private.h"

#include <math.h>
#include <stdlib.h>

#define STATE_SIZE 2 /* Numbers of a state: position and velocity. */
#define BLOCK_STEPS 32

typedef long double real;

struct propagator {
    /* The state after j + 1 steps from (q, v) is q first[j] + v second[j] + shift[j], where first
     * and second are the columns of M^(j+1); each has two numbers. */
    double first[BLOCK_STEPS * STATE_SIZE], second[BLOCK_STEPS * STATE_SIZE],
        shift[BLOCK_STEPS * STATE_SIZE];
    real last[STATE_SIZE][STATE_SIZE + 1];    /* those of the last step with all digits */
    double reach[STATE_SIZE][STATE_SIZE + 1]; /* largest magnitudes of first, second and shift */
    double max[STATE_SIZE];    /* largest magnitudes at beginnings of blocks in the last call */
    double h;                  /* [s] */
    double anchor[STATE_SIZE]; /* state at the beginning of the block */
    int64_t anchored;          /* step of the grid at the anchor; -1 if there is none */
};

/* Makes one step of h from y [2], which becomes the new state. Returns false if out of memory or if
 * the step fails. */
static bool method_step_apply(const struct run *run, double h, double *y)
{
    struct step step = {
        .system = &run->system, .drag = run->settings.drag, .t = run->system.t0, .h = h, .y = y};
    step.work = malloc(method_work_size(run->method, STATE_SIZE) * sizeof *step.work);
    bool fine = step.work && method_step(run->method, &step) == STEP_OK;
    free(step.work);
    return fine;
}

/* Half of the bound is left to rounding. */
bool propagator_within(const struct propagator *p, const double *bound)
{
    bool is_bounded = true;
    for (int k = 0; k < STATE_SIZE; k++)
        is_bounded = is_bounded && p->reach[k][0] * p->max[0] + p->reach[k][1] * p->max[1] +
                                           p->reach[k][STATE_SIZE] <=
                                       bound[k] / 2;
    return is_bounded;
}

double propagator_step(const struct propagator *propagator)
{
    return propagator->h;
}

/* Finds the matrix and the shift of one step by steps of the method, and then their powers. */
struct propagator *propagator_create(const struct run *run, double h)
{
    double shift[STATE_SIZE] = {0}, column[STATE_SIZE][STATE_SIZE] = {{1, 0}, {0, 1}};
    if (!method_step_apply(run, h, shift) || !method_step_apply(run, h, column[0]) ||
        !method_step_apply(run, h, column[1]))
        return NULL;
    real m[STATE_SIZE][STATE_SIZE], power[STATE_SIZE][STATE_SIZE] = {{1, 0}, {0, 1}},
                                    sum[STATE_SIZE] = {0};
    for (int i = 0; i < STATE_SIZE; i++)
        for (int j = 0; j < STATE_SIZE; j++)
            m[i][j] = (real)column[j][i] - (real)shift[i];
    if (run->method->flags & METHOD_SYMPLECTIC && run->system.conservative) {
        real determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        /* else it is all rounding */
        real scale = fabsl(determinant - 1) < 1e-6L ? 1 / sqrtl(determinant) : 1;
        for (int i = 0; i < STATE_SIZE; i++)
            for (int j = 0; j < STATE_SIZE; j++)
                m[i][j] *= scale;
    }
    struct propagator *p = malloc(sizeof *p);
    if (!p)
        return NULL;
    *p = (struct propagator){.anchored = -1, .h = h};
    for (int step = 0; step < BLOCK_STEPS; step++) {
        real next[STATE_SIZE][STATE_SIZE], next_sum[STATE_SIZE];
        for (int i = 0; i < STATE_SIZE; i++) {
            for (int j = 0; j < STATE_SIZE; j++)
                next[i][j] = m[i][0] * power[0][j] + m[i][1] * power[1][j];
            next_sum[i] = m[i][0] * sum[0] + m[i][1] * sum[1] + (real)shift[i];
        }
        memcpy(power, next, sizeof power);
        memcpy(sum, next_sum, sizeof sum);
        for (int i = 0; i < STATE_SIZE; i++) {
            p->first[step * STATE_SIZE + i] = (double)power[i][0];
            p->second[step * STATE_SIZE + i] = (double)power[i][1];
            p->shift[step * STATE_SIZE + i] = (double)sum[i];
            const double size[] = {fabs(p->first[step * STATE_SIZE + i]),
                                   fabs(p->second[step * STATE_SIZE + i]), fabs((double)sum[i])};
            for (int j = 0; j <= STATE_SIZE; j++)
                p->reach[i][j] =
                    size[j] <= p->reach[i][j] || isnan(p->reach[i][j]) ? p->reach[i][j] : size[j];
        }
    }
    for (int i = 0; i < STATE_SIZE; i++) {
        p->last[i][0] = power[i][0];
        p->last[i][1] = power[i][1];
        p->last[i][STATE_SIZE] = sum[i];
    }
    return p;
}

/* Computes the BLOCK_STEPS states after (y, v) into row. The last state is computed in long
 * double and rounded once, because the rounding of a matrix of doubles would add up from block
 * to block. */
static inline void block_compute(const struct propagator *p, double y, double v,
                                 double *restrict row)
{
    for (int i = 0; i < BLOCK_STEPS * STATE_SIZE; i++)
        row[i] = p->first[i] * y + p->second[i] * v + p->shift[i];
    for (int i = 0; i < STATE_SIZE; i++)
        row[(BLOCK_STEPS - 1) * STATE_SIZE + i] =
            (double)(p->last[i][0] * (real)y + p->last[i][1] * (real)v + p->last[i][STATE_SIZE]);
}

/* Returns the larger one of max and |x|. An x that is not a number is returned, too, so that a
 * state that is not finite cannot be overlooked. */
static inline double larger_magnitude(double max, double x)
{
    return fabs(x) <= max ? max : fabs(x);
}

/* Computes `count` blocks of states from y [2] on, each from the last state of the block before,
 * and notes the largest states in p->max. */
CLONES static void blocks_compute(struct propagator *p, const double *y, double *restrict row,
                                  int64_t count)
{
    double q = y[0], v = y[1];
    for (int64_t i = 0; i < count; i++, row += BLOCK_STEPS * STATE_SIZE) {
        p->max[0] = larger_magnitude(p->max[0], q);
        p->max[1] = larger_magnitude(p->max[1], v);
        block_compute(p, q, v, row);
        q = row[(BLOCK_STEPS - 1) * STATE_SIZE];
        v = row[(BLOCK_STEPS - 1) * STATE_SIZE + 1];
    }
}

bool propagator_knows(const struct propagator *p, int64_t step)
{
    return step % BLOCK_STEPS == 0 || p->anchored == step - step % BLOCK_STEPS;
}

int64_t propagator_block(int64_t step)
{
    return step - step % BLOCK_STEPS;
}

int64_t propagator_rest(int64_t step)
{
    return BLOCK_STEPS - step % BLOCK_STEPS;
}

void propagator_anchor(struct propagator *p, int64_t step, const double *y)
{
    p->anchored = step;
    memcpy(p->anchor, y, sizeof p->anchor);
}

struct propagator_place propagator_place(const struct propagator *p)
{
    return (struct propagator_place){p->h, {p->anchor[0], p->anchor[1]}, p->anchored};
}

void propagator_set_place(struct propagator *p, const struct propagator_place *place)
{
    propagator_anchor(p, place->anchored, place->anchor);
}

/* Computes whole blocks at once, and parts of blocks from the anchor. */
int64_t propagator_advance(struct propagator *p, int64_t first, int64_t count, double *y,
                           double *row)
{
    double block_state[BLOCK_STEPS * STATE_SIZE];
    int64_t done = 0;
    p->max[0] = p->max[1] = 0;
    while (done < count) {
        const int64_t inside = (first + done) % BLOCK_STEPS;
        int64_t taken = count - done;
        if (inside == 0) {
            propagator_anchor(p, first + done, y);
        } else if (p->anchored != first + done - inside) {
            break;
        }
        if (inside == 0 && taken >= BLOCK_STEPS) {
            taken -= taken % BLOCK_STEPS;
            blocks_compute(p, y, row + done * STATE_SIZE, taken / BLOCK_STEPS);
        } else {
            taken = taken < BLOCK_STEPS - inside ? taken : BLOCK_STEPS - inside;
            blocks_compute(p, p->anchor, block_state, 1);
            memcpy(row + done * STATE_SIZE, block_state + inside * STATE_SIZE,
                   (size_t)taken * STATE_SIZE * sizeof *row);
        }
        done += taken;
        memcpy(y, row + (done - 1) * STATE_SIZE, STATE_SIZE * sizeof *y);
    }
    return done;
}
