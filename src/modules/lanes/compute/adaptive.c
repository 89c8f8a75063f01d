/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Adaptive steps in lanes, of explicit Runge-Kutta methods whose last slope is the first of the
 * next step (FSAL): rk_error.h and adapt_body.h in vectors, each lane with its own controller. All
 * lanes attempt a step at once; a rejected lane tries again from its old state while the others
 * continue. First and last steps, steps across turning points and attempts without a finite result
 * are made for one lane alone, by method_adapt(). */
#define UNROLL
#include "modules/lanes/compute/state.h"

#include <hooke/base/numeric.h>

#include "method/control/adapt_body.h"

bool lanes_adapt_fit(const struct method *method, const struct system *system, enum drag drag,
                     double h)
{
    return method->flags & METHOD_ADAPTIVE && method->tableau && method->tableau->fsal &&
           system->switches == 0 && system->order == 2 && lanes_fit(method, system, drag, h);
}

/* ---- one lane alone ---- */

/* Returns t, or t_end if both are equal within rounding, as at the end of a run. */
static double end_of_step(double t, double t_end)
{
    const double larger = fabs(t) > fabs(t_end) ? fabs(t) : fabs(t_end);
    return fabs(t - t_end) <= 4 * DBL_EPSILON * larger ? t_end : t;
}

/* Makes an accepted step of one lane by method_adapt(), with the lane's controller, and writes
 * state, slope and controller back. `first` marks the first step, which has no slope yet. The lane
 * has failed if the step fails or becomes too short, or if its state is too far out. */
static void step_alone(struct lanes *lanes, int lane, bool first)
{
    struct lane_control *const own = &lanes->control;
    const struct method *method = lanes->method;
    const int n = lanes->n, last = (method->tableau->stages - 1) * n;
    double y[LIMIT_VARIABLES];
    struct step step = {.system = lanes->system[lane],
                        .t = own->t[lane],
                        .y = y,
                        .work = lanes->work,
                        .warm = !first};
    struct controller control = {.tol = own->tol[lane],
                                 .elapsed = own->elapsed[lane],
                                 .sampled = own->sampled[lane],
                                 .sampling = !first,
                                 .h = own->h[lane],
                                 .t_low = own->t_low[lane],
                                 .last = own->last[lane],
                                 .previous = own->previous[lane],
                                 .rejected = own->rejected[lane] != 0};
    lane_get(n, lanes->y, lane, y);
    lane_get(n, lanes->k, lane, lanes->work + last);
    lane_get(n, lanes->excess, lane, control.excess);
    method_choose_kernels(method, &step, true);
    /* A step that is too small a fraction of the time since the start fails, too. */
    bool good = method_adapt(method, &step, &control, own->t_end) == STEP_OK && step.warm &&
                !(fabs(control.h) < own->creep * fabs(step.t - lanes->t0));
    for (int i = 0; i < n; i++)
        good = good && fabs(y[i]) <= lane_farthest;
    own->t[lane] = end_of_step(step.t, own->t_end);
    own->steps[lane]++;
    lanes->evals[lane] += step.cost.evals;
    own->failed[lane] = -(lane_mask)!good;
    own->running[lane] = -(lane_mask)(good && own->t[lane] != own->t_end);
    own->elapsed[lane] = control.elapsed;
    own->sampled[lane] = control.sampled;
    own->h[lane] = control.h;
    own->t_low[lane] = control.t_low;
    own->last[lane] = control.last;
    own->previous[lane] = control.previous;
    own->rejected[lane] = 0;
    lane_put(n, y, lane, lanes->y);
    lane_put(n, lanes->work + last, lane, lanes->k);
    lane_put(n, control.excess, lane, lanes->excess);
}

/* Prepares adaptive steps and makes the first step of the lanes 0..used-1 (see lanes.h). */
void lanes_control(struct lanes *lanes, int used, const double *tol, double t_end, double creep)
{
    struct lane_control *const own = &lanes->control;
    const struct method *method = lanes->method;
    const int k = method->embedded + 1, n = lanes->n;
    lanes->adapts = true;
    /* - */
    lanes_march(lanes, 0, NULL); /* prepares */
    *own = (struct lane_control){.t_end = t_end,
                                 .creep = lanes->system[0]->linear ? 0 : creep,
                                 .aims = aim_factor(method),
                                 .by_error = -0.5 / k * explicit.b1,
                                 .by_previous = -0.5 / k * explicit.b2,
                                 .by_ratio = explicit.a,
                                 .elementary = -0.5 / k};
    memset(lanes->excess, 0, (size_t)n * LANE_COUNT * sizeof *lanes->excess);
    for (int lane = 0; lane < used; lane++) {
        const struct system *system = lanes->system[lane];
        const struct controller wanted = {.tol = tol[lane]};
        const double max = largest_estimate(method, controller_tolerance(&wanted));
        own->tol[lane] = tol[lane];
        own->accepted[lane] = 1 / (n * max * max);
        own->t[lane] = lanes->t0;
        own->h[lane] = lanes->own_h[lane];
        for (int i = 0; i < n; i++) {
            const double given = system->atol[i] / controller_tolerance(&wanted);
            lanes->given[i * LANE_COUNT + lane] = given < DBL_MAX ? given : DBL_MAX;
        }
        lane_put(n, system->scale, lane, lanes->min);
        step_alone(lanes, lane, true);
    }
}

/* ---- the control, in vectors ---- */

/* Returns log2 of positive normal numbers by the same operations, and thus with the same bits, as
 * factor_log2(), which gives the series. x = 2^whole m, where the bits of sqrt(1/2),
 * 0x3fe6a09e667f3bcd, make 0.7 < m < 1.42. `whole` is converted to a double by adding it to the
 * bits of 1.5 * 2^52, whose last bit counts ones. */
INLINE four four_log2(four x)
{
    const double shift = 0x1.8p52;
    const four magic = shift - (four){0};
    const four_masks near_half = (four_masks)x - 0x3fe6a09e667f3bcd, whole = near_half >> 52;
    const four m = (four)((four_masks)x - (whole << 52));
    const four s = (m - 1) / (m + 1), u = s * s;
    const four series = (0.961796693925976 + u * 0.577078016355585) +
                        u * u * (0.412198583111132 + u * 0.320598897975325);
    return ((four)(whole + (four_masks)magic) - shift) + s * (2.885390081777927 + u * series);
}

/* Returns 2^x by the same operations as factor_exp2(). Adding 1.5 * 2^52 rounds x to an integer,
 * which is shifted into the exponent (1 has the bits 0x3ff0000000000000); the polynomial in the
 * remainder f is Taylor's series of 2^f. */
INLINE four four_exp2(four x)
{
    const four raised = four_either(x < -1000, x, -1000 - (four){0}),
               clamped = four_either(raised > 1000, raised, 1000 - (four){0});
    const double shift = 0x1.8p52;
    const four rounded = clamped + shift, f = clamped - (rounded - shift), g = f * f;
    const four power = (four)(((four_masks)rounded << 52) + 0x3ff0000000000000);
    const four low = (1 + f * 0.693147180559945) + g * (0.240226506959101 + f * 0.0555041086648216);
    const four high = (0.00961812910762848 + f * 0.00133335581464284) +
                      g * (0.000154035303933816 + f * 1.52527338040598e-5) +
                      g * g * 1.32154867901443e-6;
    return power * (low + g * g * high);
}

/* Returns atan, with the operations of factor_atan(). */
INLINE four four_atan(four x)
{
    const four size = four_either(x < 0, x, -x), z = four_either(size > 1, x, 1 / x), u = z * z;
    const four angle =
        z * (0.9998660 + u * (-0.3302995 + u * (0.1801410 + u * (-0.0851330 + u * 0.0208351))));
    const four quarter = 1.5707963267948966 - (four){0};
    return four_either(size <= 1, four_either(x < 0, quarter, -quarter) - angle, angle);
}

/* Returns the limited factor of a step, 1 + atan(2^x - 1), with the operations of factor_limited().
 */
INLINE four four_limited(four x)
{
    const four u = x * x;
    const four low =
        (1 + 0.6931488410800936 * x) + u * (0.240226502974211 - 0.0555933829372098 * x);
    const four high = (-0.1058275956503550 - 0.0320318947604718 * x) +
                      u * (0.0284870670868496 + 0.0239926464967005 * x);
    const four_masks is_small = (x >= -0.5) & (x <= 0.5);
    const four series = low + u * u * high;
    if (four_none(~is_small))
        return series;
    return four_either(is_small, 1 + four_atan(four_exp2(x) - 1), series);
}

/* Updates lanes->scale, the sizes that errors are relative to, in vector q of the lanes, as
 * update_sizes() does. */
INLINE void follow_sizes(struct lanes *lanes, int q)
{
    struct lane_control *const control = &lanes->control;
    const four t = fours(control->t)[q], dt = four_magnitude(t - fours(control->sampled)[q]),
               elapsed = fours(control->elapsed)[q] + dt, rate = 1 / elapsed;
    fours(control->sampled)[q] = t;
    fours(control->elapsed)[q] = elapsed;
    for (int i = 0, index = q; i < lanes->n; i++, index += LANE_COUNT / WIDE) {
        const four min = fours(lanes->min)[index], size = four_magnitude(fours(lanes->y)[index]),
                   given = fours(lanes->given)[index];
        four excess = fours(lanes->excess)[index], mean = 1 - (four){0};
        const four_masks larger = size > min;
        if (!four_none(larger))
            excess =
                four_either(larger, excess, excess + dt * (four_root(four_root(size / min)) - 1));
        mean = four_either(excess > 0, mean, mean + excess * rate);
        mean *= mean;
        mean *= mean;
        const four sized = min * mean, scale = four_either(sized < DBL_MAX, min, sized);
        fours(lanes->scale)[index] = four_either(given > 0, scale, given);
        fours(lanes->excess)[index] = excess;
    }
}

/* Returns h sum_j (w_j - u_j) k_j, the difference between two formulas with weights w and u
 * [stages] for steps of h [s]. k_j are the slopes lanes->k; `index` is the number of a vector of
 * lanes in each: that of its variable times LANE_COUNT / WIDE plus that of the vector in it. */
INLINE four weight_difference(const struct lanes *lanes, four h, const double *w, const double *u,
                              int index)
{
    const int stages = lanes->method->tableau->stages, stride = lanes->n * LANE_COUNT / WIDE;
    four sum = -(four){0};
    for (int j = 0; j < stages; j++)
        if (w[j] != u[j])
            sum += (w[j] - u[j]) * fours(lanes->k)[j * stride + index];
    return h * sum;
}

/* Returns the squared error estimate of vector q, with the operations of rk_estimate(). */
INLINE four error_estimate(const struct lanes *lanes, four h, int q)
{
    const struct tableau *tableau = lanes->method->tableau;
    four fine = {0}, coarse = {0};
    for (int i = 0, index = q; i < lanes->n; i++, index += LANE_COUNT / WIDE) {
        const four size = four_larger(four_larger(four_magnitude(fours(lanes->y)[index]),
                                                  four_magnitude(fours(lanes->state)[index])),
                                      fours(lanes->scale)[index]);
        const four error = weight_difference(lanes, h, tableau->b, tableau->b_hat, index) / size;
        fine += error * error;
        if (!tableau->rough)
            continue;
        const four rough = weight_difference(lanes, h, tableau->b, tableau->rough, index) / size;
        coarse += rough * rough;
    }
    if (!tableau->rough)
        return fine;
    return fine * four_either(fine > 0, (four){0}, fine / (fine + 0.01 * coarse));
}

/* Returns the next step as plan_next() and next_attempt() do, where `error` is the squared error
 * in units of the aim, at least MIN_ERROR. */
INLINE four four_next_step(struct lane_control *control, int q, four h, four error, four_masks good)
{
    const four one = 1 - (four){0}, log = four_log2(error),
               ratio = four_magnitude(h / fours(control->last)[q]);
    const four_masks changes =
        (error < KEEP_MIN * KEEP_MIN) | (error > KEEP_MAX * KEEP_MAX) | (ratio < STEADY_RATIO_MIN);
    four rho = one;
    if (!four_none(changes)) {
        const four history = four_log2(fours(control->previous)[q]) * control->by_previous -
                             four_log2(ratio) * control->by_ratio;
        rho = four_either(changes, one, four_limited(log * control->by_error + history));
    }
    rho = four_either(masks(control->rejected)[q] & ~(rho < 1), rho, one);
    if (four_none(~good))
        return h * rho;
    const four factor = four_exp2(log * control->elementary);
    return four_either(good, h * four_larger(factor, STEP_SHRINK_MIN - (four){0}), h * rho);
}

/* Marks lanes of vector q whose state after the attempt is not finite (*wild) or is far out (*far).
 */
INLINE void check_state(const struct lanes *lanes, int q, four_masks *wild, four_masks *far)
{
    *wild = *far = (four_masks){0};
    for (int i = 0, index = q; i < lanes->n; i++, index += LANE_COUNT / WIDE) {
        const four size = four_magnitude(fours(lanes->state)[index]);
        *wild |= ~(size <= DBL_MAX);
        *far |= size > lane_farthest;
    }
}

/* Returns the lanes of vector q whose velocity changes its sign in the attempt. */
INLINE four_masks velocity_crosses_zero(const struct lanes *lanes, int q)
{
    const int index = lanes->rows * LANE_COUNT / WIDE + q;
    const four previous = fours(lanes->y)[index], current = fours(lanes->state)[index];
    return ((previous < 0) & (current > 0)) | ((previous > 0) & (current < 0));
}

/* Stores `value` in those lanes of vector q of the array that `when` selects. */
INLINE void put_where(four_masks when, four value, int q, double *number)
{
    fours(number)[q] = four_either(when, fours(number)[q], value);
}

/* Accepts or rejects the attempt in vector q of the lanes and plans the next step. Lanes whose
 * attempt needs the scalar step keep their state and are marked in `alone`. */
INLINE void decide_step(struct lanes *lanes, int q)
{
    struct lane_control *const control = &lanes->control;
    const int last = (lanes->method->tableau->stages - 1) * lanes->n * LANE_COUNT / WIDE;
    const four t = fours(control->t)[q], h = fours(control->h)[q];
    const four_masks running = masks(control->running)[q];
    follow_sizes(lanes, q);
    const four square = error_estimate(lanes, h, q) * fours(control->accepted)[q],
               error = four_larger(square * control->aims, MIN_ERROR * MIN_ERROR - (four){0});
    const four_masks good = square <= 1;
    const four next = four_next_step(control, q, h, error, good);
    four_masks alone, far;
    check_state(lanes, q, &alone, &far);
    alone |= ~(square <= DBL_MAX) | ~(four_magnitude(next) <= DBL_MAX) |
             (fours(control->previous)[q] == 0) |
             (four_magnitude(h) * LAST_STEP_STRETCH >= four_magnitude(control->t_end - t)) |
             ~(next > lane_shortest_of_time * four_magnitude(t) + lane_shortest);
    if (lanes->turns)
        alone |= velocity_crosses_zero(lanes, q);
    /* `moves` are lanes that are decided here, `goes` those of them that are accepted. */
    const four_masks moves = running & ~alone, goes = moves & good;
    /* advance_clock() */
    const four step = h + fours(control->t_low)[q], sum = t + step, gone = sum - t,
               low = (t - (sum - gone)) + (step - gone);
    const four_masks failed =
        goes & (far | (next < control->creep * four_magnitude(sum - lanes->t0)));
    put_where(goes, sum, q, control->t);
    put_where(goes, low, q, control->t_low);
    put_where(goes, h, q, control->last);
    put_where(goes, error, q, control->previous);
    put_where(moves, next, q, control->h);
    masks(lanes->evals)[q] += moves & (lanes->method->tableau->stages - 1);
    masks(control->steps)[q] -= goes;
    masks(control->rejected)[q] = (masks(control->rejected)[q] | (moves & ~good)) & ~goes;
    masks(control->failed)[q] |= failed;
    masks(control->running)[q] = running & ~failed;
    masks(control->alone)[q] = running & alone;
    for (int i = 0, index = q; i < lanes->n; i++, index += LANE_COUNT / WIDE) {
        put_where(goes, fours(lanes->state)[index], index, lanes->y);
        put_where(goes, fours(lanes->k)[last + index], index, lanes->k);
    }
}

/* ---- attempts in all lanes ---- */

CLONES static void decide_all(struct lanes *lanes)
{
    for (int q = 0; q < LANE_COUNT / WIDE; q++)
        decide_step(lanes, q);
}

/* Attempts one step in all lanes that run: stages, decision, then the steps of single lanes. */
static void attempt_all(struct lanes *lanes)
{
    const struct tableau *tableau = lanes->method->tableau;
    struct lane_control *own = &lanes->control;
    double time[LANE_COUNT];
    for (int s = 1; s < tableau->stages; s++) {
        lanes_combine(&lanes->weights[s], own->h, lanes->n, lanes->k, lanes->y, lanes->state);
        for (int lane = 0; lane < LANE_COUNT; lane++)
            time[lane] = own->t[lane] + tableau->c[s] * own->h[lane];
        lanes_slope(lanes, (struct lane_time){.t = time}, lanes->k + s * lanes->n * LANE_COUNT);
    }
    decide_all(lanes);
    for (int lane = 0; lane < LANE_COUNT; lane++)
        if (own->alone[lane])
            step_alone(lanes, lane, false);
}

static bool any_runs(const struct lanes *lanes)
{
    for (int lane = 0; lane < LANE_COUNT; lane++)
        if (lanes->control.running[lane])
            return true;
    return false;
}

/* Attempts steps (see lanes.h); without `row` it ends as soon as no lane runs. */
bool lanes_adapt(struct lanes *lanes, int64_t attempts, double *row)
{
    for (int64_t i = 0; i < attempts; i++) {
        if (any_runs(lanes))
            attempt_all(lanes);
        else if (!row)
            return false;
        if (row)
            lanes_adapted_row(lanes, row + 3 * i * LANE_COUNT);
    }
    return any_runs(lanes);
}

/* Writes time, first variable and its derivative of every lane. */
void lanes_adapted_row(const struct lanes *lanes, double *row)
{
    const size_t size = LANE_COUNT * sizeof *row;
    memcpy(row, lanes->control.t, size);
    memcpy(row + LANE_COUNT, lanes->y, size);
    memcpy(row + 2 * LANE_COUNT, lanes->y + lanes->rows * LANE_COUNT, size);
}

/* Sets the numbers of steps and evaluations of a lane. Returns false if it has not arrived at
 * t_end. */
bool lanes_adapted(const struct lanes *lanes, int lane, int64_t *steps, int64_t *evals)
{
    *steps = lanes->control.steps[lane];
    *evals = lanes->evals[lane];
    return !lanes->control.failed[lane] && !lanes->control.running[lane];
}
