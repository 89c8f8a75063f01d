/* SPDX-License-Identifier: GPL-3.0-or-later */
/* roots_find(): all zeros of a function on an interval. An interval is halved until bounds exclude
 * 0 from it, or bounds of the slope leave one sign change at most, or bounds of the second
 * derivative at most two (Moore 1966, Interval Analysis; Hansen, Walster 2004, Global Optimization
 * Using Interval Analysis, chapter 9). root_between() finds a zero between two signs. */
#include <hooke/scene/interval.h>

#include <float.h>

/* Rounding error of a bound, relative to the terms that it is made of. */
#define BOUND_ROUNDING (64 * DBL_EPSILON)
#define INTERVALS_PER_ROOT 64 /* Intervals that each root adds to the budget of the search. */
#define TOUCH_SEPARATION 1e-7 /* Touches that are nearer to each other count as one. */
#define BISECTION_DEPTH_MAX 64
#define ROOTS_MAX 100000 /* Number of roots at which one search ends. */

/* An interval from a to b, with the function's values at its ends. */
struct root_interval {
    double a, b, fa, fb;
};

static int sign_of(double value)
{
    return (value > 0) - (value < 0);
}

static double root_value(const struct root_search *roots, double x)
{
    return roots->value(roots->context, x);
}

/* Passes a zero, with the sign behind it, to the caller's root_report(), which may stop the search.
 */
static void root_report(struct root_search *roots, double x, int sign)
{
    roots->count++;
    roots->stopped = !roots->found(roots->context, x, sign) || roots->stopped;
}

/* Finds a zero between a and b, at which the function has the values fa and fb with different
 * signs, to within `min` in x, by inverse quadratic interpolation where it is safe, else by
 * bisection (Chandrupatla 1997). Returns a point at which the value is 0 or has the sign of fb. */
double root_between(double (*value)(void *context, double x), void *context, double a, double fa,
                    double b, double fb, double min)
{
    double x = b, f = fb, other = a, f_other = fa, t = 0.5; /* the root is between x and other */
    for (int i = 0; i < 200 && f != 0; i++) {
        const double trial = x + t * (other - x), now = value(context, trial);
        double last = x, f_last = f;
        if (!((trial > x && trial < other) || (trial < x && trial > other)))
            break;
        if ((now < 0) != (f < 0) || now == 0) {
            last = other;
            f_last = f_other;
            other = x;
            f_other = f;
        }
        x = trial;
        f = now;
        const double width = fabs(other - x), fraction = width > 0 ? min / (2 * width) : 1;
        if (fraction > 0.5)
            break;
        const double xi = (x - other) / (last - other), phi = (f - f_other) / (f_last - f_other);
        t = 0.5;
        if (1 - sqrt(1 - xi) < phi && phi < sqrt(xi))
            t = f / (f_other - f) * (f_last / (f_other - f_last)) +
                (last - x) / (other - x) * (f / (f_last - f)) * (f_other / (f_last - f_other));
        t = fmin(fmax(t, fraction), 1 - fraction);
    }
    return f == 0 || (f < 0) == (fb < 0) ? x : other;
}

/* Returns the point behind the sign change in s. */
static double root_locate(const struct root_search *roots, const struct root_interval *s)
{
    return s->fa == 0
               ? s->a
               : root_between(roots->value, roots->context, s->a, s->fa, s->b, s->fb, roots->min);
}

/* Handles an interval in which the sign changes once at most: finds that, and sets the sign at its
 * end. */
static void root_interval_pass(struct root_search *roots, const struct root_interval *s)
{
    const int end_sign = sign_of(s->fb);
    if (end_sign == 0)
        return;
    if (roots->sign != 0 && end_sign != roots->sign)
        root_report(roots, root_locate(roots, s), end_sign);
    roots->sign = end_sign;
}

/* Passes x as a touch of 0 to the caller, if it counts as one and is not the same as the last. */
static void touch_report(struct root_search *roots, double x)
{
    if (!roots->touches || (roots->touched && x - roots->last_touch <= TOUCH_SEPARATION))
        return;
    if (roots->touches(roots->context, x)) {
        roots->touched = true;
        roots->last_touch = x;
        root_report(roots, x, 0);
    }
}

/* Returns the middle of the bounds of the slope at x. */
static double slope_at(const struct root_search *roots, double x)
{
    const struct interval slope = roots->bounds(roots->context, x, x).slope;
    return slope.lo + (slope.hi - slope.lo) / 2;
}

#define GOLDEN_SECTION 0.3819660112501051

/* Returns true, with *x, if the function passes 0 near *x, which is about its extreme value. Bounds
 * of slopes may be too wide to tell where that is; with a second derivative of at least `bend` it
 * is within a distance that follows, which is searched by values alone (golden section; Kiefer
 * 1953). */
static bool crosses_near_extreme(const struct root_search *roots, const struct root_interval *s,
                                 double bend, double *x)
{
    const struct interval slope = roots->bounds(roots->context, *x, *x).slope;
    const double max = fmax(fabs(slope.lo), fabs(slope.hi)), radius = 2 * max / bend;
    double a = fmax(s->a, *x - radius), b = fmin(s->b, *x + radius);
    double p = a + GOLDEN_SECTION * (b - a), q = b - GOLDEN_SECTION * (b - a);
    double fp = roots->sign * root_value(roots, p), fq = roots->sign * root_value(roots, q);
    if (roots->sign * root_value(roots, *x) > max * max / bend)
        return false;
    for (int i = 0; i < 100 && p > a && q > p && b > q && b - a > roots->min; i++) {
        *x = fp < fq ? p : q;
        if (fmin(fp, fq) < 0)
            return true;
        if (fp < fq) {
            b = q;
            q = p;
            fq = fp;
            p = a + GOLDEN_SECTION * (b - a);
            fp = roots->sign * root_value(roots, p);
        } else {
            a = p;
            p = q;
            fp = fq;
            q = b - GOLDEN_SECTION * (b - a);
            fq = roots->sign * root_value(roots, q);
        }
    }
    return false;
}

/* Returns true if the function, whose values at both ends of *s have the same sign, has the other
 * sign at its extreme between them. Sets *x to a point where it has, or, if it returns false, to
 * the point tried last, near the extreme. The extreme is found by regula falsi on the slope. */
static bool crosses_at_extreme(const struct root_search *roots, const struct root_interval *s,
                               double *x)
{
    double a = s->a, b = s->b, ga = roots->sign * slope_at(roots, a),
           gb = roots->sign * slope_at(roots, b);
    *x = ga >= 0 ? a : b;
    if (ga >= 0 || gb <= 0)
        return roots->sign * root_value(roots, *x) < 0;
    for (int i = 0; i < 100 && b - a > roots->min; i++) {
        double trial = i % 3 == 2 ? a + (b - a) / 2 : a + (b - a) * (ga / (ga - gb));
        if (!(trial > a && trial < b))
            trial = a + (b - a) / 2;
        if (!(trial > a && trial < b))
            break;
        *x = trial;
        const double f = roots->sign * root_value(roots, trial),
                     g = roots->sign * slope_at(roots, trial);
        if (f < 0)
            return true;
        if (!roots->touches && f > fabs(g) * (b - a) &&
            f > BOUND_ROUNDING * (fabs(s->fa) + fabs(s->fb)))
            return false;
        if (g == 0)
            return false;
        if (g < 0) {
            a = trial;
            ga = g;
            gb /= 2;
        } else {
            b = trial;
            gb = g;
            ga /= 2;
        }
    }
    return false;
}

/* Handles an interval that begins at a zero, where the second derivative has the sign `bend` and
 * the slope the other one: the function returns to 0 inside of the interval. Returns false if it
 * does not. */
static bool leaves_zero(struct root_search *roots, const struct root_interval *s, int bend)
{
    const int previous_sign = roots->sign;
    double x;
    if (s->fa != 0 || sign_of(s->fb) != bend || !(bend * slope_at(roots, s->a) < 0))
        return false;
    roots->sign = bend;
    const bool dips = crosses_at_extreme(roots, s, &x);
    roots->sign = previous_sign;
    if (!dips)
        return false;
    const double fx = root_value(roots, x);
    root_interval_pass(roots, &(struct root_interval){s->a, x, 0, fx});
    root_interval_pass(roots, &(struct root_interval){x, s->b, fx, s->fb});
    return true;
}

/* Searches an interval on which the second derivative has one sign, so that there are two zeros at
 * most. */
static void bent_interval_search(struct root_search *roots, const struct root_interval *s,
                                 const struct interval *second)
{
    const int end_sign = sign_of(s->fb);
    const bool is_convex = second->lo > 0;
    if (leaves_zero(roots, s, is_convex ? 1 : -1))
        return;
    if (roots->sign == 0 || end_sign == -roots->sign || (roots->sign > 0) != is_convex) {
        root_interval_pass(roots, s);
        return;
    }
    double x;
    const bool crosses_zero =
        crosses_at_extreme(roots, s, &x) ||
        crosses_near_extreme(roots, s, fmin(fabs(second->lo), fabs(second->hi)), &x);
    if (!crosses_zero) {
        touch_report(roots, x);
        return;
    }
    if (roots->touches && roots->touches(roots->context, x)) {
        touch_report(roots, x);
        return;
    }
    const double fx = root_value(roots, x);
    root_interval_pass(roots, &(struct root_interval){s->a, x, s->fa, fx});
    root_interval_pass(roots, &(struct root_interval){x, s->b, fx, s->fb});
}

/* Returns bounds of the value, narrowed by what follows from the values at both ends and the bounds
 * of the slope. */
static struct interval value_bounds(const struct jet *jet, const struct root_interval *s)
{
    struct interval value = jet->value;
    const double w = s->b - s->a, fall_rate = -jet->slope.lo, rise_rate = jet->slope.hi;
    if (!(fall_rate > 0 && rise_rate > 0 && fall_rate + rise_rate < HUGE_VAL))
        return value;
    const double sum = fall_rate + rise_rate, max = fall_rate * rise_rate * w;
    const double lo = (s->fa * rise_rate + s->fb * fall_rate - max) / sum,
                 hi = (s->fa * fall_rate + s->fb * rise_rate + max) / sum;
    const double slack = BOUND_ROUNDING * (fabs(s->fa) + fabs(s->fb) + max / sum);
    if (lo - slack > value.lo)
        value.lo = lo - slack;
    if (hi + slack < value.hi)
        value.hi = hi + slack;
    return value;
}

/* Handles a sign change between the last interval and the beginning of s, as at a jump. */
static void begin_sign_enter(struct root_search *roots, const struct root_interval *s)
{
    const int begin_sign = sign_of(s->fa);
    if (begin_sign != 0 && roots->sign != 0 && begin_sign != roots->sign)
        root_report(roots, s->a, begin_sign);
    roots->sign = begin_sign != 0 ? begin_sign : roots->sign;
}

/* Reports the adjacent intervals *all that no bound decides as a single one, and empties it. The
 * values in it differ from 0 by errors only: if the sign behind it differs from that before, the
 * function changes sign once; otherwise it may touch 0. */
static void pass_undecided(struct root_search *roots, struct root_interval *all)
{
    if (!(all->b > all->a))
        return;
    begin_sign_enter(roots, all);
    const int previous_sign = roots->sign;
    root_interval_pass(roots, all);
    if (roots->sign == previous_sign)
        touch_report(roots, all->a + (all->b - all->a) / 2);
    all->b = all->a;
}

/* Appends an interval to those that no bound decides. */
static void add_undecided(struct root_interval *all, const struct root_interval *s)
{
    if (!(all->b > all->a)) {
        *all = *s;
        return;
    }
    all->b = s->b;
    all->fb = s->fb;
}

/* Returns true if 0 is outside of the bounds. */
static bool excludes_zero(const struct interval *bound)
{
    return bound->lo > 0 || bound->hi < 0;
}

/* Returns true if the bounds at the single point x do not exclude a sign change: x is as near to a
 * jump as the errors of the value in which the function jumps. */
static bool is_undecided(struct root_search *roots, double x)
{
    const struct jet jet = roots->bounds(roots->context, x, x);
    roots->used++;
    return !interval_empty(jet.value) && !excludes_zero(&jet.value) && !excludes_zero(&jet.slope) &&
           !excludes_zero(&jet.bend);
}

/* Returns true if halving the interval at `middle` would decide nothing: it is too short, or all of
 * it is within the errors of one jump. */
static bool is_uncuttable(struct root_search *roots, const struct root_interval *s, double middle)
{
    static const double longest = 1e-3; /* longer ones may end near two jumps */
    return s->b - s->a <= roots->min || !(middle > s->a && middle < s->b) ||
           (s->b - s->a < longest && is_undecided(roots, middle) && is_undecided(roots, s->a) &&
            is_undecided(roots, s->b));
}

/* Evaluates bounds of the interval, and handles it completely if they decide how many zeros it
 * has at most. Then it also handles the undecided part before it. Returns false if they do not
 * decide. */
static bool interval_decide(struct root_search *roots, const struct root_interval *s,
                            struct root_interval *undecided)
{
    const struct jet jet = roots->bounds(roots->context, s->a, s->b);
    roots->used++;
    const struct interval value = value_bounds(&jet, s);
    const bool empty = interval_empty(jet.value), one = value.lo > roots->touch_tolerance ||
                                                        value.hi < -roots->touch_tolerance ||
                                                        jet.slope.lo >= 0 || jet.slope.hi <= 0;
    if (!empty && !one && !excludes_zero(&jet.bend))
        return false;
    pass_undecided(roots, undecided);
    begin_sign_enter(roots, s);
    if (!empty && one)
        root_interval_pass(roots, s);
    else if (!empty)
        bent_interval_search(roots, s, &jet.bend);
    return true;
}

/* Halves intervals on a stack until each is decided, in the order of x. */
void roots_find(struct root_search *roots, double a, double fa, double b, double fb)
{
    struct root_interval stack[BISECTION_DEPTH_MAX] = {{a, b, fa, fb}}, undecided = {0};
    int depth = 1;
    roots->used = roots->count = 0;
    roots->unsure = roots->stopped = roots->touched = false;
    while (depth > 0 && !roots->stopped) {
        const struct root_interval s = stack[--depth];
        if (interval_decide(roots, &s, &undecided))
            continue;
        const double middle = s.a + (s.b - s.a) / 2;
        if (depth + 2 > BISECTION_DEPTH_MAX || is_uncuttable(roots, &s, middle)) {
            add_undecided(&undecided, &s);
            continue;
        }
        if (roots->used > roots->budget + INTERVALS_PER_ROOT * roots->count ||
            roots->count >= ROOTS_MAX) {
            roots->unsure = true;
            roots->unsure_from = s.a;
            add_undecided(&undecided, &(struct root_interval){s.a, b, s.fa, fb});
            break;
        }
        const double fm = root_value(roots, middle);
        roots->nonzero = roots->nonzero || fm != 0;
        stack[depth++] = (struct root_interval){middle, s.b, fm, s.fb};
        stack[depth++] = (struct root_interval){s.a, middle, s.fa, fm};
    }
    if (!roots->stopped)
        pass_undecided(roots, &undecided);
}
