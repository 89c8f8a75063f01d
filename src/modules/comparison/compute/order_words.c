/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Explains a measured order on its scene in words. */
#include "modules/comparison/compute/verify.h"

#include <math.h>
#include <stdio.h>

#define PLATEAU_SPREAD 0.1 /* slopes that differ by less belong to one power of dt, */
#define PLATEAU_SLOPES 3   /* this many equal slopes are a range of their own, */
#define PLATEAU_APART 0.5  /* and if they differ by more from the claim, another order */

/* Returns the largest |eigenvalue| of the Jacobian [1/s] at a state, or 0. */
double system_fastest_rate(const struct system *system, double t, const double *y)
{
    struct mode mode[STABILITY_MODES];
    int count = 0;
    double max = 0, re[2], im;
    modes_at(system, t, y, mode, &count, STABILITY_MODES);
    for (int i = 0; i < count; i++) {
        mode_eigenvalues(&mode[i], re, &im);
        max = fmax(max, hypot(re[1], im));
    }
    return max;
}

/* Returns how turning points and switches affect the order, or NULL if they do not. `misses` is
 * true if another order than claimed was found, or none. */
static const char *explain_jumps(const struct system *system, const struct order *order,
                                 bool misses)
{
    const struct method *method = order->choice.method;
    const bool meets = method_meets_switches(method, system), turns = method_turns(method, system);
    if (misses && system->oscillator.friction != 0 && system->steps_across_kinks)
        return "dry friction jumps where the velocity is 0, so each turning point inside a step "
               "reduces the order";
    if (misses && system->switches > 0 && !meets && !turns)
        return "the forces switch (if, abs, sign, ...), and each switch inside a step reduces the "
               "order";
    if (order->verdict == ORDER_AGREES && system->switches > system->dry && system->pieces && meets)
        return "the forces switch (if, abs, sign, ...); the order is kept because steps end at the "
               "switches";
    if (order->verdict == ORDER_AGREES && system->pieces && system->dry)
        return "dry friction jumps where the velocity is 0; the order is kept because steps end at "
               "the turning points";
    if (misses && system->oscillator.quadratic != 0 && order->claimed > 2)
        return "quadratic drag has no second derivative where the velocity is 0, so turning points "
               "reduce higher orders";
    if (order->verdict == ORDER_AGREES && turns)
        return "drag has a kink where the velocity is 0; the order is kept because steps end at "
               "the turning points";
    return NULL;
}

/* Writes why another order was found, or none, as far as the sizes of steps and errors show it:
 * stiffness, no affordable step, slopes that still change, or a scene that is not smooth. */
static void explain_sizes(const struct system *system, struct order *order)
{
    const bool none = order->verdict == ORDER_NO_RANGE,
               explicit = !(order->choice.method->flags & METHOD_IMPLICIT);
    const double rate = system_fastest_rate(system, system->t0, system->start),
                 last = order->points ? order->point[order->points - 1].dt : NAN;
    double dt = NAN, best = HUGE_VAL;
    for (int i = 0; i < order->points; i++) {
        /* the step to judge is the finest one in the fit; without a fit the finest that is
         * asymptotic */
        if (order->point[i].fitted || (!order->fitted && order->point[i].error < ORDER_ERROR_MAX) ||
            isnan(dt))
            dt = order->point[i].dt;
        best = fmin(best, order->point[i].error);
    }
    char *words = order->words;
    const size_t size = sizeof order->words;
    if ((none && explicit && !(best < ORDER_ERROR_MAX) && rate * last > 0.5) || rate * dt > 1)
        snprintf(words, size,
                 "stiff: these steps do not resolve the fastest motion (%.2g 1/s), where methods "
                 "lose order or do not reach the end%s",
                 rate, explicit ? "; an implicit method may help" : "");
    else if (none && !(best < ORDER_ERROR_MAX))
        snprintf(words, size, "no affordable step gave an error below %.1g", ORDER_ERROR_MAX);
    else if (none)
        snprintf(words, size,
                 "too few of the affordable steps gave an error between %.1g and the limit set by "
                 "rounding and the reference (accurate to %.1g); a longer duration may help",
                 ORDER_ERROR_MAX, order->floor);
    else if (order->unsettled)
        snprintf(words, size,
                 "the slope still changes at the finest steps above rounding: a longer duration "
                 "may help, or the scene is not smooth");
    else
        snprintf(
            words, size,
            "the scene is not smooth enough, or these steps are still too coarse; try dt=RANGE");
}

/* Finds the longest range of equal slopes among points coarser than those of the fit. Returns its
 * number of slopes; *first is the index of its first point. */
static int find_plateau(const struct order *order, int *first)
{
    int longest = 0;
    for (int i = 1; i < order->points && !order->point[i].fitted; i++) {
        int n = 0;
        while (i + n < order->points && !order->point[i + n].fitted &&
               order->point[i + n].error < ORDER_ERROR_MAX &&
               fabs(order->point[i + n].slope - order->point[i].slope) < PLATEAU_SPREAD)
            n++;
        if (n > longest) {
            longest = n;
            *first = i - 1;
        }
    }
    return longest;
}

/* Writes where a stiff scene reduces the order of a method, though its finest steps have the
 * claimed order; leaves the words empty if it does not. */
static void explain_plateau(const struct system *system, struct order *order)
{
    int first = 0;
    const int slopes = find_plateau(order, &first);
    if (slopes < PLATEAU_SLOPES)
        return;
    const struct order_point *first_point = &order->point[first],
                             *last_point = &order->point[first + slopes];
    const double rate = system_fastest_rate(system, system->t0, system->start),
                 slope = log(first_point->error / last_point->error) /
                         log(first_point->dt / last_point->dt);
    if (!(rate * last_point->dt > 1) || !(fabs(slope - order->claimed) > PLATEAU_APART))
        return;
    snprintf(order->words, sizeof order->words,
             "order reduction: from dt = %.3g s to %.3g s, which do not resolve the fastest motion "
             "(%.2g 1/s), the slope is %.2f",
             first_point->dt, last_point->dt, rate, slope);
}

/* Writes into order->words why the scene spoils the order, or leaves them empty. */
void order_explain(const struct system *system, bool rests, struct order *order)
{
    const bool misses = order->verdict == ORDER_LOWER || order->verdict == ORDER_ERRATIC ||
                        order->verdict == ORDER_NO_RANGE;
    const struct method *method = order->choice.method;
    const char *jumps = explain_jumps(system, order, misses);
    const size_t size = sizeof order->words;
    order->switches = system->switches > system->dry;
    if (order->choice.drag == DRAG_EXPLICIT && method->drag != DRAG_EXPLICIT && system->velocity)
        snprintf(order->words, size, "with drag=explicit %s is of first order, not %d",
                 method->row.name, method->order);
    else if (order->verdict != ORDER_AGREES && rests)
        snprintf(order->words, size,
                 "the body is at rest at the end, so only the error of its position remains, which "
                 "may have another order; use a shorter duration for that of the motion");
    else if (jumps)
        snprintf(order->words, size, "%s", jumps);
    else if (misses)
        explain_sizes(system, order);
    else if (order->verdict == ORDER_HIGHER && system->linear && system->autonomous)
        snprintf(order->words, size,
                 "the scene is linear: there only the stability function of the method matters, "
                 "and its order is higher");
    else if (order->verdict == ORDER_AGREES)
        explain_plateau(system, order);
}
