/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Evaluates the points of a precision study: slopes of curves, costs of an error, the fastest
 * methods, predicted costs, and the default methods. */
#include "modules/comparison/compute/errors.h"

#include <hooke/base/numeric.h>

#include <gsl/gsl_fit.h>
#include <gsl/gsl_statistics_double.h>
#include <stdlib.h>
#include <string.h>

/* ---- slopes ---- */

/* number of steps per order after which a multistep method shows its order */
#define STARTED_STEPS 32
#define BAND_TOP 0.05 /* errors above this are not yet asymptotic */
/* errors below this many times the accuracy of the reference include rounding */
#define BAND_BOTTOM 30.0
#define ROUNDING_ERROR_MAX 1e-8 /* largest error at which rounding may reduce the slope */
#define FIT_POINTS_MAX 4        /* number of points in the fit of a dt sweep, the finest */
#define FIT_POINTS_MIN 3
#define PRECISION_POINTS 64 /* largest number of points of a curve that are fitted */

/* Returns the logarithm of the point's step or tolerance. */
static double log_setting(const struct precision_point *point)
{
    return log(point->tol > 0 ? point->tol : point->dt);
}

/* Returns the median of the local orders of points [begin, end) after the first, or NAN if there
 * are none. */
static double typical_order(const struct precision_point *point, int begin, int end)
{
    double order[PRECISION_POINTS];
    int count = 0;
    for (int i = begin + 1; i < end && count < (int)COUNT_OF(order); i++)
        if (!isnan(point[i].order))
            order[count++] = point[i].order;
    return values_quantile(order, (size_t)count, 0.5);
}

/* Returns true for few steps of a multistep method, many of which its starter made, so that the
 * error is not yet its own. */
static bool is_mostly_started(const struct precision_curve *curve,
                              const struct precision_point *point)
{
    const struct method *method = curve->choice.method;
    return (method->flags & METHOD_MULTISTEP) && point->steps < STARTED_STEPS * method->order;
}

/* Returns the number of points that are asymptotic, and sets *first to the index of the first in
 * precision->point. They follow the last error above BAND_TOP (or failure) and end before an error
 * falls below the accuracy of the reference times BAND_BOTTOM. Below ROUNDING_ERROR_MAX they end
 * where the error falls less than half as fast as it typically does; the point before that is left
 * out, too, as it has some of the rounding already. */
static int find_asymptotic(const struct precision *precision, const struct precision_curve *curve,
                           int *first)
{
    const struct precision_point *point = precision->point + curve->first;
    const double bottom = fmax(BAND_BOTTOM * precision->reference.accuracy, 1e-13);
    /* `best` is the point with the smallest error; beyond it errors may rise again by rounding */
    int begin = 0, end = 0, best = 0;
    for (int i = 1; i < curve->count; i++)
        if (precision_meaningful(&point[i]) &&
            !(precision_meaningful(&point[best]) && point[best].errors.max <= point[i].errors.max))
            best = i;
    for (int i = 0; i < curve->count && i <= best; i++)
        if (!precision_meaningful(&point[i]) || point[i].errors.max >= BAND_TOP ||
            is_mostly_started(curve, &point[i]))
            begin = i + 1;
    for (end = begin; end < curve->count; end++)
        if (!precision_meaningful(&point[end]) || point[end].errors.max < bottom)
            break;
    const double typical = typical_order(point, begin, end);
    for (int i = begin + 1; i < end; i++) {
        if (point[i - 1].errors.max < ROUNDING_ERROR_MAX && point[i].order < 0.5 * typical) {
            end = i - 1;
            break;
        }
    }
    if (!curve->adaptive && end - begin > FIT_POINTS_MAX)
        begin = end - FIT_POINTS_MAX;
    *first = curve->first + begin;
    return end - begin;
}

/* Fits slope and R^2 of a curve to its asymptotic points. */
void precision_fit(struct precision *precision, int c)
{
    struct precision_curve *curve = &precision->curve[c];
    const struct method *method = curve->choice.method;
    double x[PRECISION_POINTS], y[PRECISION_POINTS], start, cov, residual;
    int first, n = find_asymptotic(precision, curve, &first);
    n = n < PRECISION_POINTS ? n : PRECISION_POINTS;
    curve->expected = curve->adaptive ? 1 : method->order;
    if (method->order == 0)
        curve->expected = NAN;
    curve->slope = curve->r2 = NAN;
    curve->fitted = n >= FIT_POINTS_MIN ? n : 0;
    curve->differs = false;
    for (int i = 0; i < curve->count; i++)
        precision->point[curve->first + i].asymptotic = false;
    for (int i = 0; i < curve->fitted; i++) {
        struct precision_point *point = &precision->point[first + i];
        point->asymptotic = true;
        x[i] = log_setting(point);
        y[i] = log(point->errors.max);
    }
    const size_t fitted = (size_t)curve->fitted;
    const double spread = fitted ? gsl_stats_tss(y, 1, fitted) : 0;
    if (!(spread > 0) || !(gsl_stats_tss(x, 1, fitted) > 0))
        return;
    gsl_fit_linear(x, 1, y, 1, fitted, &start, &curve->slope, &cov, &cov, &cov, &residual);
    curve->r2 = 1 - residual / spread;
    curve->differs =
        fabs(curve->slope - curve->expected) > PRECISION_SLOPE * fmax(1, curve->expected / 6);
}

/* ---- the fastest for an error ---- */

/* Returns the value between a and b at the fraction `part` in logarithms, or b if one of them is
 * not positive. */
static double interpolate_log(double a, double b, double part)
{
    return a > 0 && b > 0 ? exp(log(a) + part * (log(b) - log(a))) : b;
}

/* Computes what an error costs with one method, between the points of its curve. */
bool precision_cost_at(const struct precision *precision, int c, double error,
                       struct precision_cost *cost)
{
    const struct precision_curve *curve = &precision->curve[c];
    const struct precision_point *coarse = NULL;
    for (int i = 0; i < curve->count; i++) {
        const struct precision_point *fine = &precision->point[curve->first + i];
        if (!precision_meaningful(fine) || error < precision->reference.accuracy) {
            coarse = NULL;
            continue;
        }
        /* the first point that reaches the error; interpolate towards the point before it */
        if (fine->errors.max <= error) {
            const double part =
                coarse && fine->errors.max > 0
                    ? log(coarse->errors.max / error) / log(coarse->errors.max / fine->errors.max)
                    : 1;
            coarse = coarse ? coarse : fine;
            *cost = (struct precision_cost){
                .curve = c,
                .path = fine->path,
                .evals =
                    interpolate_log((double)coarse->cost.evals, (double)fine->cost.evals, part),
                .minimum = interpolate_log(coarse->time.minimum, fine->time.minimum, part),
                .median = interpolate_log(coarse->time.median, fine->time.median, part),
                .timed = timing_is_sound(&coarse->time) && timing_is_sound(&fine->time),
            };
            return true;
        }
        coarse = fine;
    }
    return false;
}

/* Orders costs: timed ones by time before others, which are ordered by evaluations. */
static bool is_cheaper(const struct precision_cost *a, const struct precision_cost *b)
{
    if (!a->timed && !b->timed)
        return a->evals < b->evals;
    return a->timed && b->timed ? a->minimum < b->minimum : a->timed;
}

/* Reorders costs [count], sorted by cost, so that those that can be ranked come first, and returns
 * the number of these. Costs without reliable times cannot be ranked, nor those of methods with
 * general code that come after a method with specialised code. The order of the ranked ones is
 * kept. */
static int separate_unranked(struct precision_cost *costs, int count)
{
    int ranked = 0;
    bool special = false;
    for (int i = 0; i < count; i++) {
        const struct precision_cost cost = costs[i];
        special |= cost.path == KERNEL_SPECIALISED;
        if (!cost.timed || (special && cost.path == KERNEL_GENERAL))
            continue;
        memmove(&costs[ranked + 1], &costs[ranked], (size_t)(i - ranked) * sizeof cost);
        costs[ranked++] = cost;
    }
    return ranked;
}

/* Returns the ratio up to which two times tie, which is larger if the machine was busy. */
static double tie_ratio(const struct precision *precision)
{
    for (int i = 0; i < precision->points; i++)
        if (precision->point[i].time.others > TIMING_OTHERS)
            return TIMING_CONTENTION;
    return PRECISION_TIE;
}

/* Lists the curves that reach an error, the fastest first, then those that are not ranked. */
int precision_fastest(const struct precision *precision, double error, struct precision_cost *costs,
                      int *others)
{
    int count = 0;
    for (int c = 0; c < precision->curves; c++) {
        struct precision_cost cost;
        if (!precision_cost_at(precision, c, error, &cost))
            continue;
        int index = count++;
        for (; index > 0 && is_cheaper(&cost, &costs[index - 1]); index--)
            costs[index] = costs[index - 1];
        costs[index] = cost;
    }
    const bool timed = count > 0 && costs[0].timed;
    const int ranked = timed ? separate_unranked(costs, count) : count;
    for (int i = 1; i < ranked; i++)
        costs[i].tied =
            costs[i].minimum <= fmax(costs[0].median, costs[0].minimum * tie_ratio(precision));
    if (others)
        *others = count - ranked;
    return ranked;
}

/* ---- prediction for the undamped oscillator ---- */

bool precision_predicts(const struct system *system)
{
    const struct oscillator *o = &system->oscillator;
    return system->order == 2 && system->n == 2 && system->linear && o->whole && o->stiffness > 0 &&
           o->damping == 0 && o->drive == 0;
}

/* Returns the largest error of the position after `radians` of an undamped oscillation in steps of
 * x radians, from (q, p) of length 1, or NAN if the matrix does not oscillate. M^n = r^n (cos n
 * theta + sin n theta B) is compared with the rotation by n x. To first order the position is wrong
 * by cos(.) (a q + f p) + sin(.) (a p - f q + d), where a is the growth, f the phase gained, and d
 * what the shape of B adds, which is not that of a rotation. The larger of the values at start and
 * end is returned. */
static double predicted_error(const double matrix[4], double x, double radians, double q, double p)
{
    const double mean = (matrix[0] + matrix[3]) / 2, half = (matrix[0] - matrix[3]) / 2;
    const double turn = -(half * half + matrix[1] * matrix[2]);
    if (!(turn > 0))
        return NAN;
    const double sine = sqrt(turn), theta = atan2(sine, mean), steps = radians / x;
    const double a = expm1(steps * 0.5 * log(mean * mean + turn)), f = steps * (theta - x);
    const double d = half / sine * q + (matrix[1] / sine - 1) * p;
    return fmax(fabs(d), hypot(a * q + f * p, a * p - f * q + d));
}

/* Predicts the number of evaluations with which curve c reaches an error: finds the step x (radians
 * of the oscillation) at which predicted_error() of the method's amplification matrix equals the
 * error. Returns NAN if the method has no such matrix or the scene is another (compare.h). */
double precision_predict(const struct precision *precision, int c, double error)
{
    const struct precision_curve *curve = &precision->curve[c];
    const struct system *system = &precision->system;
    if (!precision_predicts(system) || curve->adaptive || curve->choice.method->evals == 0)
        return NAN;
    const double omega = sqrt(system->oscillator.stiffness), radians = omega * precision->duration;
    const double centre = -system->oscillator.gravity / system->oscillator.stiffness;
    /* start of the motion, scaled to the unit circle of the phase plane */
    double q = system->start[0] - centre, p = system->start[1] / omega, size = hypot(q, p);
    double previous_error = NAN, before_x = NAN, slope = NAN, found = NAN;
    if (!(size > 0))
        return NAN;
    /* Steps go from coarse to fine, until the matrix's own rounding shows. The last crossing
     * counts, because an earlier one is luck. Smaller errors are extrapolated by the last slope. */
    double x = 3;
    while (x > 1e-6) {
        double matrix[4];
        if (!method_amplification(curve->choice.method, curve->choice.drag, x, 0, matrix))
            return NAN;
        const double wrong = predicted_error(matrix, x, radians, q / size, p / size);
        if (wrong < 1e3 * 2.220446049250313e-16 * radians / x)
            break;
        if (wrong > 0 && wrong < 0.3)
            slope = log(previous_error / wrong) / log(before_x / x);
        if (wrong <= error && !(previous_error <= error))
            found = previous_error > error ? x * pow(error / wrong, 1 / slope) : x;
        previous_error = wrong;
        before_x = x;
        x /= 1.09;
    }
    if (!(previous_error <= error))
        found = before_x * pow(error / previous_error, 1 / slope);
    return curve->choice.method->evals * radians / found;
}

/* ---- the methods that are compared unless others are named ---- */

/* Candidates for scenes that are not stiff, in the order in which they are taken. */
static const char *const usual_methods[] = {"euler",
                                            "symplectic-euler",
                                            "verlet",
                                            "rk4",
                                            "pefrl",
                                            "blanes-moan6",
                                            "kahan-li8",
                                            "dopri5",
                                            "dop853",
                                            "odex",
                                            "gauss6",
                                            "radau5",
                                            "rodas5p",
                                            "tsit5",
                                            "implicit-midpoint",
                                            "trapezoid",
                                            "heun",
                                            "midpoint",
                                            "backward-euler"};
/* The same for stiff scenes. */
static const char *const stiff_methods[] = {
    "backward-euler", "trapezoid", "tr-bdf2", "bdf2",   "gauss4",    "radau5", "ros3p",
    "rodas4",         "rodas5p",   "dopri5",  "dop853", "cvode-bdf", "sdirk2", "implicit-midpoint"};

/* Norm of the Jacobian times duration from which a scene counts as stiff, in units of the natural
 * sizes. */
#define STIFFNESS_MIN 2e4

/* Returns true if stability alone limits the steps of explicit methods. */
bool precision_is_stiff(const struct system *system, double duration)
{
    const int n = system->n;
    double norm = 0, *jacobian = system_new_jacobian(system, system->t0, system->start);
    for (int i = 0; jacobian && i < n; i++) {
        double sum = 0;
        for (int j = 0; j < n; j++)
            sum += fabs(jacobian[i * n + j]) * system->scale[j] / system->scale[i];
        norm = fmax(norm, sum);
    }
    free(jacobian);
    return norm * duration > STIFFNESS_MIN;
}

/* Chooses methods that apply to the system, from a list for stiff systems or for others. */
int precision_defaults(const struct system *system, double duration, struct method_choice *choice,
                       void (*absent)(void *context, const char *method, const char *reason),
                       void *context)
{
    const bool is_stiff = precision_is_stiff(system, duration);
    const char *const *names = is_stiff ? stiff_methods : usual_methods;
    const size_t max = is_stiff ? COUNT_OF(stiff_methods) : COUNT_OF(usual_methods);
    int count = 0;
    for (size_t i = 0; i < max && count < PRECISION_DEFAULTS; i++) {
        struct error reason;
        struct method_choice candidate = {method_find(names[i]), DRAG_DEFAULT};
        if (!candidate.method)
            continue;
        if (method_applies(candidate.method, system, &candidate.drag, &reason))
            choice[count++] = candidate;
        else if (absent)
            absent(context, names[i], reason.text);
    }
    return count;
}
