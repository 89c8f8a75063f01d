/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the restoring force: a spring, a hardening or softening spring (Duffing 1918), or gravity
 * on a pendulum. If the period changes with the amplitude, no sine is near the whole recording, so
 * each force is fitted to the first periods, then to twice as many, and so on. */
#include "modules/recording/law/drag.h"

#include <gsl/gsl_cdf.h>

/* Periods and samples of the first window. */
enum { FIRST_PERIODS = 4, LEAST = 16 };

/* Variances that a step may promise to gain and yet be taken without evaluation: in the search, and
 * in the end. */
#define SEARCH_PROMISE_VARIANCES 100.0
#define FINAL_PROMISE_VARIANCES 1e-2
/* A search that did not converge is discarded if its sum of squares exceeds that of another force
 * by this number of variances. */
#define REFUTED_RSS_VARIANCES 100.0

const char *restoring_name(enum restoring_force force)
{
    static const char *const name[RESTORING_FORCES] = {[RESTORING_LINEAR] = "linear",
                                                       [RESTORING_CUBIC] = "Duffing",
                                                       [RESTORING_SINE] = "pendulum"};
    return name[force];
}

/* The first samples of all, with a straight line as baseline. */
struct first_samples {
    struct samples samples;
    struct law_samples law;
    size_t edge[2];
};

/* Sets *part to the first `target` samples. */
static void first_samples_take(const struct law_samples *whole, size_t target,
                               struct first_samples *part)
{
    part->samples = samples_part(whole->samples, 0, target);
    part->law = *whole;
    part->law.samples = &part->samples;
    part->edge[0] = 0;
    part->edge[1] = target;
    part->law.baseline = (struct baseline){.blocks = 1, .edge = part->edge, .terms = 2};
}

/* Starts a fit with the damped sine of these samples, or with `start` if none can be fitted or if
 * the samples are not positions. */
static void begin_law_fit(const struct law_samples *x, const struct equation *start,
                          struct law_fit *fit)
{
    *fit = (struct law_fit){.motion = *start, .omega = start->value[EQUATION_OMEGA]};
    fit->parameters = drag_indices(LAW_LINEAR, RESTORING_LINEAR, fit->index);
    const double t0 = x->samples->t[0];
    struct harmonic h = {.omega = fit->omega};
    h.origin = 0.5 * (t0 + x->samples->t[x->samples->n - 1]);
    if (start->order > 0 || !harmonic_fit(x->samples, FREE_GAMMA, &h, NULL))
        return;
    const double back = start->t0 - h.origin, e = exp(-0.5 * h.gamma * back);
    const double c = e * cos(h.omega * back), s = e * sin(h.omega * back), p = h.a * c + h.b * s,
                 q = h.b * c - h.a * s;
    fit->motion.value[EQUATION_START] = p;
    fit->motion.value[EQUATION_SPEED] = h.omega * q - 0.5 * h.gamma * p;
    fit->motion.value[EQUATION_OMEGA] = fit->omega = h.omega;
    fit->motion.value[EQUATION_RATE] = h.gamma;
}

/* Doubles the number of samples, up to n. */
static size_t next_length(size_t length, size_t n)
{
    return length > n / 2 ? n : 2 * length;
}

/* Fits the motion under that force in windows that grow from first_length samples to all, starting
 * from *first; *fit becomes the result. Returns false if it does not converge. */
static bool restoring_fit_grow(const struct law_samples *x, size_t first_length,
                               const struct law_fit *first, enum restoring_force force,
                               double rounding, struct law_fit *fit)
{
    const size_t n = x->samples->n;
    *fit = *first;
    fit->motion.force = force;
    fit->parameters = drag_indices(LAW_LINEAR | LAW_QUADRATIC, force, fit->index);
    if (force == RESTORING_SINE) { /* T = T0 (1 + A^2/16): Nayfeh & Mook 1979, 2.1 */
        const double a = hypot(fit->motion.value[EQUATION_START],
                               fit->motion.value[EQUATION_SPEED] / fit->omega);
        fit->motion.value[EQUATION_OMEGA] *= 1 + fmin(a * a, 4) / 16;
    }
    for (size_t length = first_length;; length = next_length(length, n)) {
        struct first_samples part;
        first_samples_take(x, length, &part);
        fit->omega = fit->motion.value[EQUATION_OMEGA];
        const struct law_fit previous = *fit;
        if (length == n)
            return law_descend(x, FINAL_PROMISE_VARIANCES, rounding, fit);
        /* Too few periods may not hold every parameter: more are tried from the same start. */
        if (!law_descend(&part.law, SEARCH_PROMISE_VARIANCES, rounding, fit))
            *fit = previous;
    }
}

/* Fits a force that was not found from its own start, from the answer of another force. Returns
 * false if it does not converge. */
static bool follow_force(const struct law_samples *x, const struct law_fit *other,
                         enum restoring_force force, double rounding, struct law_fit *fit)
{
    *fit = *other;
    fit->motion.force = force;
    fit->motion.value[EQUATION_CUBIC] = 0;
    fit->omega = fit->motion.value[EQUATION_OMEGA];
    fit->parameters = drag_indices(LAW_LINEAR | LAW_QUADRATIC, force, fit->index);
    return law_descend(x, FINAL_PROMISE_VARIANCES, rounding, fit);
}

/* ---- the choice, by the rule of the laws of damping ---- */

/* Fits of each force, and the variance and degrees of freedom with which they are compared. */
struct force_fits {
    struct law_fit fit[RESTORING_FORCES];
    double variance, freedom;
};

/* Returns the F-test p value of beta y^3 beside force `small`. */
static double cubic_chance(const struct force_fits *all, int small)
{
    const double gain =
        fmax(all->fit[small].rss - all->fit[RESTORING_CUBIC].rss, 0) / all->variance;
    return gsl_cdf_fdist_Q(gain, 1, fmax(all->freedom - all->fit[RESTORING_CUBIC].parameters, 1));
}

/* Returns true if force i did not converge or is refuted. The Duffing spring contains the linear
 * one, and nearly the pendulum, so that it is not refuted by them. */
static bool force_is_refuted(const struct force_fits *all, const struct drag_fit *drag, int i)
{
    const struct restoring_candidate *c = drag->restoring;
    if (!c[i].converged)
        return true;
    for (int j = 0; j < RESTORING_FORCES && i != RESTORING_CUBIC; j++)
        if (j != i && c[j].converged && c[i].bic - c[j].bic >= DELTA_MIN &&
            (j != RESTORING_CUBIC || cubic_chance(all, i) < CHANCE_MAX))
            return true;
    return false;
}

/* Returns true if beta y^3 may exist beside the simplest force: it is weakly significant, or may be
 * a considerable share of a spring's force. */
static bool cubic_remains(const struct force_fits *all, const struct drag_fit *drag, int simple)
{
    const struct law_fit *fit = &all->fit[RESTORING_CUBIC];
    if (!drag->restoring[RESTORING_CUBIC].converged || simple == RESTORING_CUBIC)
        return simple == RESTORING_CUBIC;
    const double omega = fit->motion.value[EQUATION_OMEGA],
                 a = hypot(fit->motion.value[EQUATION_START],
                           fit->motion.value[EQUATION_SPEED] / omega);
    const double max = fabs(fit->motion.value[EQUATION_CUBIC]) +
                       2 * sqrt(all->variance) * law_formal(fit, fit->parameters - 1);
    return cubic_chance(all, simple) < HIDDEN_TERM_CHANCE ||
           (simple == RESTORING_LINEAR && max * a * a > SHARE_MAX * omega * omega);
}

/* Returns true if the search for force i did not come near the residuals of another force. */
static bool force_is_far_off(const struct force_fits *all, int i, int other)
{
    return all->fit[i].rss - all->fit[other].rss > REFUTED_RSS_VARIANCES * all->variance;
}

/* Returns the simplest force that is not refuted: the spring, then the pendulum, which both have a
 * parameter less than Duffing's. */
static int simplest_force(const struct force_fits *all, const struct drag_fit *drag)
{
    static const int order[] = {RESTORING_LINEAR, RESTORING_SINE, RESTORING_CUBIC};
    for (size_t i = 0; i < COUNT_OF(order); i++)
        if (!force_is_refuted(all, drag, order[i]))
            return order[i];
    return RESTORING_LINEAR;
}

/* Computes the BIC of each restoring force in drag->restoring, allowing for slow phase changes in
 * the residuals of the best fit. Returns false if these residuals cannot be computed, or if
 * cancelled. */
static bool compare_forces(struct drag_fitting *f, struct force_fits *all, struct drag_fit *drag)
{
    int widest = -1;
    struct drag_factors factors;
    for (int i = 0; i < RESTORING_FORCES; i++)
        if (drag->restoring[i].converged && (widest < 0 || all->fit[i].rss < all->fit[widest].rss))
            widest = i;
    if (widest < 0)
        return true;
    if (!law_residuals(&f->samples, &all->fit[widest], f->motion->residual, NULL, NULL) ||
        !drag_factors(f, &all->fit[widest], &factors))
        return false;
    const double independent = fmax((double)all->fit[widest].used / factors.phase, 2);
    all->variance = factors.phase * fmax(factors.sigma * factors.sigma, f->rounding);
    all->freedom = factors.phase > DRAG_WIDENED && factors.windows >= DRAG_WINDOWS_MIN
                       ? factors.windows
                       : independent;
    for (int i = 0; i < RESTORING_FORCES; i++)
        if (drag->restoring[i].converged)
            drag->restoring[i].bic = (all->fit[i].parameters - FIRST_RATE) * log(independent) +
                                     (all->fit[i].rss - all->fit[widest].rss) / all->variance;
    return true;
}

/* Fits the restoring forces in growing windows, tries failed ones from the others' results, and
 * chooses the simplest that is not refuted; `angle` permits sin y. *best becomes its fit. Returns
 * false if the forces cannot be compared. */
bool restoring_choose(struct drag_fitting *f, bool angle, struct drag_fit *drag,
                      struct law_fit *best)
{
    const struct law_samples *x = &f->samples;
    const double first_span = FIRST_PERIODS * TWO_PI / f->start.value[EQUATION_OMEGA];
    const size_t n = x->samples->n,
                 span_length = samples_index(x->samples, x->samples->t[0] + first_span);
    const size_t wanted = span_length < LEAST ? LEAST : span_length;
    const size_t first_length = wanted < n ? wanted : n;
    struct law_fit first;
    struct force_fits all = {.variance = 1, .freedom = 1};
    struct first_samples part;
    unsigned every = 0;
    first_samples_take(x, first_length, &part);
    begin_law_fit(&part.law, &f->start, &first);
    law_descend(&part.law, SEARCH_PROMISE_VARIANCES, f->rounding, &first);
    for (int i = 0; i < RESTORING_FORCES; i++) {
        const bool tried = i != RESTORING_SINE || angle;
        every |= (unsigned)tried << i;
        drag->restoring[i] = (struct restoring_candidate){.bic = NAN};
        drag->restoring[i].converged =
            tried && restoring_fit_grow(x, first_length, &first, (enum restoring_force)i,
                                        f->rounding, &all.fit[i]);
    }
    for (int i = 0; i < RESTORING_FORCES; i++)
        for (int j = 0; j < RESTORING_FORCES && every >> i & 1 && !drag->restoring[i].converged;
             j++)
            drag->restoring[i].converged =
                drag->restoring[j].converged &&
                follow_force(x, &all.fit[j], (enum restoring_force)i, f->rounding, &all.fit[i]);
    if (!compare_forces(f, &all, drag))
        return false;
    const int chosen = simplest_force(&all, drag);
    drag->forces = RESTORING_FORCES;
    drag->force = (enum restoring_force)chosen;
    drag->forces_remaining = 1u << chosen;
    for (int i = 0; i < RESTORING_FORCES; i++) /* a force without a result is not excluded */
        drag->forces_remaining |=
            drag->restoring[i].converged || force_is_far_off(&all, i, chosen) ? 0 : every & 1u << i;
    for (int i = 0; i < RESTORING_FORCES; i++)
        if (i != chosen && drag->restoring[chosen].converged &&
            (i == RESTORING_CUBIC ? cubic_remains(&all, drag, chosen)
                                  : chosen != RESTORING_CUBIC && !force_is_refuted(&all, drag, i)))
            drag->forces_remaining |= 1u << i;
    *best =
        drag->restoring[chosen].converged ? all.fit[chosen] : (struct law_fit){.motion = f->start};
    return true;
}
