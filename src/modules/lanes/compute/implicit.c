/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fixed steps in lanes of implicit Runge-Kutta methods whose stages are solved one by one, for
 * scenes of one coordinate: irk_body.h, oscillator_stage() and motion_stage() on every lane. Lanes
 * iterate until all have converged; a lane whose iteration does not converge directly repeats the
 * whole step alone, by method_step(). */
#define UNROLL
#include "modules/lanes/compute/state.h"

#include <hooke/base/numeric.h>

#include "method/step/irk_body.h"
#include "method/step/newton_body.h"

/* variables (position and velocity), and most stages of such a method */
enum { N = 2, IMPLICIT_STAGES = 3 };

/* Loops over the lanes l. */
#define EACH_LANE for (int l = 0; l < LANE_COUNT; l++)

/* Work memory of a stage: the implicit step over h from y has the increment z and the result sum;
 * lanes whose step must be made alone; number of evaluations. */
struct lane_stage {
    double h[LANE_COUNT], y[N][LANE_COUNT], z[N][LANE_COUNT], sum[N][LANE_COUNT];
    lane_mask alone[LANE_COUNT];
    int64_t evals[LANE_COUNT];
};

/* Returns the mask of a lane: all bits set if `so`. */
static inline lane_mask mask_if(bool so)
{
    return -(lane_mask)so;
}

static inline bool is_infinite(double x)
{
    return !(fabs(x) <= DBL_MAX);
}

static bool any_is_set(const lane_mask *mask)
{
    lane_mask any = 0;
    EACH_LANE any |= mask[l];
    return any != 0;
}

static inline double larger_of(double a, double b)
{
    return a > b ? a : b;
}

/* Solves a stage of oscillators with linear and quadratic damping in closed form, with the
 * operations of oscillator_stage(). Lanes without a finite result are marked to be made alone. */
CLONES static void solve_closed(struct lanes *lanes, struct lane_time stage_time,
                                struct lane_stage *stage)
{
    double pull[LANE_COUNT];
    const bool dragged = lanes->dragged;
    memcpy(lanes->state, stage->y, sizeof stage->y);
    lanes_force(lanes, SUM_FORCE, stage_time, pull);
    for (int q = 0; q < LANE_COUNT / WIDE; q++) {
        const four h = fours(stage->h)[q], force = fours(pull)[q], y = fours(stage->y[0])[q],
                   previous = fours(stage->y[1])[q], damping = fours(lanes->damping)[q],
                   stiffness = fours(lanes->stiffness)[q], quadratic = fours(lanes->quadratic)[q];
        const four a = 1 + damping * h + stiffness * h * h, inverse = 1 / a,
                   r = previous + h * force, u = r * inverse;
        four v = u, drag = -(four){0}, lost = -(four){0};
        if (dragged) {
            /* Quadratic damping makes it a quadratic equation for the velocity. */
            const four bend = 4 * (quadratic * h * inverse) * inverse;
            v = 2 * u / (1 + four_root(1 + bend * four_magnitude(r)));
            drag = quadratic * h * four_magnitude(v);
            lost = drag * v;
        }
        const four restoring = h * (stiffness * h + damping) * v;
        const four_masks small = four_magnitude(a - 1 + drag) < 1;
        const four dq = h * v,
                   dv = four_either(small, v - previous, (h * force - restoring) - lost);
        fours(stage->z[0])[q] = dq;
        fours(stage->z[1])[q] = dv;
        fours(stage->sum[0])[q] = y + dq;
        fours(stage->sum[1])[q] = four_either(small, v, previous + dv);
        masks(stage->alone)[q] |= ~(four_magnitude(a) <= DBL_MAX) |
                                  ~(four_magnitude(r) <= DBL_MAX) | ~(four_magnitude(v) <= DBL_MAX);
        masks(stage->evals)[q] += 1;
    }
}

/* Computes the inverse of Newton's equation at lanes->state, with the operations of
 * motion_factor(); lanes without one are marked in `none`. */
CLONES static void newton_inverse(struct lanes *lanes, const double *h, double *inverse,
                                  lane_mask *none)
{
    double jacobian[N][LANE_COUNT];
    program_eval_lanes(lanes->slopes.program, jacobian[0], lanes->slopes.frame);
    EACH_LANE
    {
        inverse[l] = 1 / (1 - h[l] * (h[l] * jacobian[0][l] + jacobian[1][l]));
        none[l] |= mask_if(inverse[l] == 0 || is_infinite(inverse[l]));
    }
}

/* State of the Newton iteration of motion_stage(): increment x of the velocity, weight of the
 * error, inverse of the equation, size of the last correction and of the last residual. */
struct motion {
    double x[LANE_COUNT], weight[LANE_COUNT], inverse[LANE_COUNT], last[LANE_COUNT],
        residual[LANE_COUNT];
    /* lanes that still iterate, and lanes that need a new inverse */
    lane_mask active[LANE_COUNT], again[LANE_COUNT];
};

/* Sets positions and velocities of the lanes to the present iterate. */
CLONES static void set_iterate(const struct lane_stage *stage, const struct motion *m,
                               double *state)
{
    EACH_LANE
    {
        state[LANE_COUNT + l] = stage->y[1][l] + m->x[l];
        state[l] = stage->y[0][l] + stage->h[l] * state[LANE_COUNT + l];
    }
}

/* Makes one iteration in all active lanes, with the operations of motion_iterate(); a is the force
 * at the iterate. Lanes that converge become inactive, lanes that do not are marked to be made
 * alone. */
CLONES static void iterate_lanes(struct motion *m, struct lane_stage *stage, double *a, bool first)
{
    for (int q = 0; q < LANE_COUNT / 4; q++) {
        const four_masks active = masks(m->active)[q], begins = -(int64_t)first - (four_masks){0};
        const four last = fours(m->last)[q], x = fours(m->x)[q], inverse = fours(m->inverse)[q];
        const four rest = fours(stage->h)[q] * fours(a)[q] - x, weight = fours(m->weight)[q],
                   rest_size = four_magnitude(rest) * weight, move = rest * inverse,
                   size = four_magnitude(move) * weight;
        /* A lane has converged if its correction is negligible, has stalled at rounding, or if the
         * next one would be negligible. */
        const four_masks done = (size <= DBL_EPSILON / 2) |
                                ((size >= last) & (size <= INCREMENT_STALL_RELATIVE)) |
                                (~begins & (size * size <= INCREMENT_NEGLIGIBLE * last));
        /* A lane does not converge if the residual grows or is not finite, or if corrections shrink
         * too slowly. */
        const four_masks alone =
            (~(rest_size < fours(m->residual)[q]) & (last > INCREMENT_STALL_RELATIVE)) |
            (begins & ~(four_magnitude(rest) <= DBL_MAX)) |
            ((size > CONTRACTION_MAX * last) & (size > INCREMENT_STALL_RELATIVE)) |
            (done & ~(inverse > 0));
        masks(stage->evals)[q] += active & 1;
        masks(stage->alone)[q] |= active & alone;
        fours(m->x)[q] = four_either(active, x, x + move);
        masks(m->active)[q] = active & ~done & ~masks(stage->alone)[q];
        masks(m->again)[q] = masks(m->active)[q] & (size > JACOBIAN_REUSE_RATE * last);
        fours(m->last)[q] = size;
        fours(m->residual)[q] = rest_size;
    }
}

/* Computes the inverses again, at the present iterate, for lanes that converge slowly. */
static void renew_inverses(struct lanes *lanes, struct motion *m, struct lane_stage *stage)
{
    double inverse[LANE_COUNT];
    lane_mask none[LANE_COUNT] = {0};
    set_iterate(stage, m, lanes->state);
    newton_inverse(lanes, stage->h, inverse, none);
    EACH_LANE
    {
        m->inverse[l] = m->again[l] ? inverse[l] : m->inverse[l];
        stage->alone[l] |= m->again[l] & none[l];
        m->active[l] &= ~stage->alone[l];
    }
}

/* Solves one implicit stage in all lanes at once by Newton's method, with the operations and bits
 * of motion_stage(): sets the increments stage->z and the states stage->sum. stage->alone is a mask
 * of lanes that have not converged, or need newton_follow(), and must be computed one by one. */
static void solve_motion(struct lanes *lanes, struct lane_time stage_time, struct lane_stage *stage)
{
    struct motion m;
    double a[LANE_COUNT];
    EACH_LANE
    {
        const double *scale = lanes->system[l]->scale;
        const double by_position = stage->h[l] * (1 / larger_of(fabs(stage->y[0][l]), scale[0]));
        m.weight[l] = larger_of(1 / larger_of(fabs(stage->y[1][l]), scale[1]), by_position);
        m.x[l] = 0;
        m.last[l] = m.residual[l] = HUGE_VAL;
    }
    memcpy(lanes->state, stage->y, sizeof stage->y);
    newton_inverse(lanes, stage->h, m.inverse, stage->alone);
    EACH_LANE
    {
        stage->alone[l] |= mask_if(!(m.inverse[l] > 0));
        m.active[l] = ~stage->alone[l];
    }
    for (int i = 0; i < ITERATIONS && any_is_set(m.active); i++) {
        set_iterate(stage, &m, lanes->state);
        lanes_force(lanes, SUM_ALL, stage_time, a);
        iterate_lanes(&m, stage, a, i == 0);
        if (any_is_set(m.again))
            renew_inverses(lanes, &m, stage);
    }
    EACH_LANE
    {
        stage->alone[l] |= m.active[l];
        stage->z[1][l] = m.x[l];
        stage->z[0][l] = stage->h[l] * (stage->y[1][l] + m.x[l]);
        for (int i = 0; i < N; i++)
            stage->sum[i][l] = stage->y[i][l] + stage->z[i][l];
    }
}

/* ---- steps ---- */

/* Computes base = y + h sum_j w_j k_j of all lanes, skipping weights that are 0. */
CLONES static void stage_base(const double *w, int count, const double *h,
                              double (*k)[N][LANE_COUNT], const double *y,
                              double (*base)[LANE_COUNT])
{
    for (int i = 0; i < N; i++)
        EACH_LANE
        {
            double sum = -0.0;
            for (int j = 0; j < count; j++)
                if (w[j] != 0)
                    sum += w[j] * k[j][i][l];
            base[i][l] = y[i * LANE_COUNT + l] + h[l] * sum;
        }
}

/* Takes the step of one lane by method_step(), from the state in lanes->y and its slope in
 * `previous`; writes the new state to stage->sum and the last slope to `last`. The state is NAN if
 * the step fails. */
static void step_lane_alone(struct lanes *lanes, int lane, double (*previous)[LANE_COUNT],
                            struct lane_stage *stage, double (*last)[LANE_COUNT])
{
    double y[N], *const slope = lanes->work + (lanes->method->implicit->stages - 1) * N;
    struct step step = {.system = lanes->system[lane],
                        .t = lanes->own_t0[lane] + (double)lanes->step * lanes->own_h[lane],
                        .h = lanes->own_h[lane],
                        .y = y,
                        .work = lanes->work,
                        .warm = lanes->step > 0};
    memset(lanes->work, 0, method_work_size(lanes->method, N) * sizeof *lanes->work);
    lane_get(N, lanes->y, lane, y);
    lane_get(N, previous[0], lane, slope);
    const bool good =
        isfinite(y[0]) && isfinite(y[1]) && method_step(lanes->method, &step) == STEP_OK;
    stage->evals[lane] = step.cost.evals;
    for (int i = 0; i < N && !good; i++)
        y[i] = NAN;
    lane_put(N, y, lane, stage->sum[0]);
    lane_put(N, slope, lane, last[0]);
}

/* Computes the stages of one step from lanes->y; on entry k has the slopes of the previous step. */
static void implicit_stages(struct lanes *lanes, struct lane_stage *stage,
                            double (*k)[N][LANE_COUNT])
{
    const struct implicit_tableau *const tableau = lanes->method->implicit;
    const int stages = tableau->stages;
    const size_t size = sizeof stage->y;
    double own[LANE_COUNT];
    for (int s = 0; s < stages; s++) {
        const double *const row = tableau->a + s * stages;
        const struct lane_time stage_time = lanes_time(lanes, tableau->c[s], own);
        if (row[s] == 0 && tableau->fsal && lanes->step > 0) {
            memcpy(k[s], k[stages - 1], size);
            continue;
        }
        if (row[s] == 0) {
            memcpy(lanes->state, lanes->y, size);
            lanes_slope(lanes, stage_time, k[s][0]);
            EACH_LANE stage->evals[l]++;
            continue;
        }
        if (s > 0)
            stage_base(row, s, lanes->own_h, k, lanes->y, stage->y);
        else
            memcpy(stage->y, lanes->y, size);
        (lanes->closed ? solve_closed : solve_motion)(lanes, stage_time, stage);
        for (int i = 0; i < N; i++)
            EACH_LANE k[s][i][l] = stage->z[i][l] / stage->h[l];
    }
}

/* Takes one step in all lanes: computes the stages side by side, then repeats lane by lane those
 * that did not converge. k has the slopes of the previous step and receives those of this one.
 * Updates lanes->y and lanes->evals. */
static void step_lanes(struct lanes *lanes, struct lane_stage *stage, double (*k)[N][LANE_COUNT])
{
    const struct implicit_tableau *const tableau = lanes->method->implicit;
    const int stages = tableau->stages;
    double previous[N][LANE_COUNT];
    memcpy(previous, k[stages - 1], sizeof previous);
    EACH_LANE stage->alone[l] = stage->evals[l] = 0;
    implicit_stages(lanes, stage, k);
    if (!stiffly_accurate(tableau) && stages == 1) {
        const double share = tableau->b[0] / tableau->diagonal;
        for (int i = 0; i < N; i++)
            EACH_LANE stage->sum[i][l] = lanes->y[i * LANE_COUNT + l] + share * stage->z[i][l];
    } else if (!stiffly_accurate(tableau)) {
        stage_base(tableau->b, stages, lanes->own_h, k, lanes->y, stage->sum);
    }
    EACH_LANE if (stage->alone[l]) step_lane_alone(lanes, l, previous, stage, k[stages - 1]);
    EACH_LANE lanes->evals[l] += stage->evals[l];
    memcpy(lanes->y, stage->sum, sizeof stage->sum);
}

/* Makes `count` steps of an implicit method (see lanes_march()). */
void lanes_march_implicit(struct lanes *lanes, int64_t count, double *row)
{
    const struct implicit_tableau *const tableau = lanes->method->implicit;
    const size_t size = (size_t)tableau->stages * N * LANE_COUNT * sizeof(double);
    struct lane_stage stage;
    double k[IMPLICIT_STAGES][N][LANE_COUNT];
    memcpy(k, lanes->k, size);
    EACH_LANE stage.h[l] = tableau->diagonal * lanes->own_h[l];
    for (int64_t i = 0; i < count; i++) {
        step_lanes(lanes, &stage, k);
        lanes->step++;
        if (row)
            memcpy(row + 2 * i * LANE_COUNT, lanes->y, sizeof stage.y);
    }
    memcpy(lanes->k, k, size);
    memcpy(lanes->state, lanes->y, sizeof stage.y);
}
