/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Which force pulls back: a spring, a hardening or softening one (Duffing 1918), or gravity on a pendulum. Where the
 * period changes with the amplitude no sine is near the whole recording: each force is fitted to its first periods,
 * then to twice as many, and so on.
 */
#include "drag.h"

#include <string.h>

enum { FIRST_PERIODS = 4, LEAST = 16 };

#define NEARLY 100.0 /* variances that a step may promise to be taken unseen */
#define FINALLY 1e-2
#define DECIDES 10.0 /* BIC against the spring */

static const struct row rows[] = {
    [RESTORING_LINEAR] = {"linear", "", "a spring", "omega0^2 y", NULL},
    [RESTORING_CUBIC] = {"Duffing", "", "a spring that hardens or softens", "omega0^2 y + beta y^3", NULL},
    [RESTORING_SINE] = {"pendulum", "", "gravity on a rod, y is the angle", "omega0^2 sin(y)", NULL},
};

_Static_assert(COUNT_OF(rows) == RESTORING_FORCES, "a row for each");

const struct catalog restoring_catalog = CATALOG("restoring force", rows);

const char *restoring_name(enum restoring_force force)
{
    return rows[force].name;
}

/* The first samples of the whole, with a line for a baseline. */
struct part {
    struct samples samples;
    struct law_samples law;
    size_t edge[2];
};

static void take(const struct law_samples *whole, size_t to, struct part *part)
{
    part->samples = samples_part(whole->samples, 0, to);
    part->law = *whole;
    part->law.samples = &part->samples;
    part->edge[0] = 0;
    part->edge[1] = to;
    part->law.baseline = (struct baseline){.blocks = 1, .edge = part->edge, .terms = 2};
}

/* Where the damped sine of the first periods begins. */
static void begin(const struct law_samples *x, const struct equation *start, struct law_fit *fit)
{
    *fit = (struct law_fit){.motion = *start, .omega = start->value[EQUATION_OMEGA]};
    fit->parameters = drag_places(LAW_LINEAR, RESTORING_LINEAR, fit->place);
    const double t0 = x->samples->t[0];
    struct harmonic h = {.omega = fit->omega};
    h.origin = 0.5 * (t0 + x->samples->t[x->samples->n - 1]);
    if (start->order > 0 || !harmonic_fit(x->samples, FREE_GAMMA, &h, NULL))
        return;
    const double back = start->t0 - h.origin, e = exp(-0.5 * h.gamma * back);
    const double c = e * cos(h.omega * back), s = e * sin(h.omega * back), p = h.a * c + h.b * s, q = h.b * c - h.a * s;
    fit->motion.value[EQUATION_START] = p;
    fit->motion.value[EQUATION_SPEED] = h.omega * q - 0.5 * h.gamma * p;
    fit->motion.value[EQUATION_OMEGA] = fit->omega = h.omega;
    fit->motion.value[EQUATION_RATE] = h.gamma;
}

/* The smaller of the whole and twice as much, that many samples. */
static size_t next_length(size_t to, size_t n)
{
    return to > n / 2 ? n : 2 * to;
}

/* The force from a first window on; false: lost on the way. */
static bool grow(const struct law_samples *x, size_t from, const struct law_fit *first, enum restoring_force force,
                 double rounding, struct law_fit *fit)
{
    const size_t n = x->samples->n;
    *fit = *first;
    fit->motion.force = force;
    fit->parameters = drag_places(LAW_LINEAR | LAW_QUADRATIC, force, fit->place);
    if (force == RESTORING_SINE) { /* T = T0 (1 + A^2/16): Nayfeh & Mook 1979, 2.1 */
        const double a = hypot(fit->motion.value[EQUATION_START], fit->motion.value[EQUATION_SPEED] / fit->omega);
        fit->motion.value[EQUATION_OMEGA] *= 1 + fmin(a * a, 4) / 16;
    }
    for (size_t to = from;; to = next_length(to, n)) {
        struct part part;
        take(x, to, &part);
        fit->omega = fit->motion.value[EQUATION_OMEGA];
        if (!law_descend(to < n ? &part.law : x, to < n ? NEARLY : FINALLY, rounding, fit))
            return false;
        if (to == n)
            return true;
    }
}

bool restoring_choose(const struct law_samples *x, const struct equation *start, double rounding, bool angle,
                      struct arena *arena, struct drag_fit *drag, struct law_fit *best)
{
    const double first_span = FIRST_PERIODS * TWO_PI / start->value[EQUATION_OMEGA];
    const size_t n = x->samples->n, to = samples_index(x->samples, x->samples->t[0] + first_span);
    const size_t from = to < LEAST ? (n < LEAST ? n : LEAST) : to < n ? to : n;
    double *residual = arena_array(arena, n, sizeof *residual), least = HUGE_VAL;
    struct law_fit first, fit[RESTORING_FORCES];
    struct part part;
    if (!residual)
        return false;
    take(x, from, &part);
    begin(&part.law, start, &first);
    law_descend(&part.law, NEARLY, rounding, &first);
    for (int i = 0; i < RESTORING_FORCES; i++) {
        const bool tried = i != RESTORING_SINE || angle;
        drag->restoring[i] = (struct restoring_candidate){.bic = NAN};
        if (tried && grow(x, from, &first, (enum restoring_force)i, rounding, &fit[i])) {
            drag->restoring[i].converged = true;
            least = fmin(least, fit[i].rss);
        }
    }
    int chosen = RESTORING_LINEAR;
    for (int i = 0; i < RESTORING_FORCES; i++) {
        struct restoring_candidate *c = &drag->restoring[i];
        if (!c->converged)
            continue;
        if (!law_residuals(x, &fit[i], residual, NULL, NULL))
            return false;
        double product = 0, square = 0;
        for (size_t k = 1; k < n; k++) {
            product += x->use[k] && x->use[k - 1] ? residual[k] * residual[k - 1] : 0;
            square += x->use[k] ? residual[k] * residual[k] : 0;
        }
        const double independent = (double)fit[i].used / autocorrelation_factor(square > 0 ? product / square : 0);
        const double noise = fmax(least, (double)fit[i].used * rounding);
        c->bic = fmax(2, independent) * log(fmax(fit[i].rss, noise) / noise) +
                 fit[i].parameters * log((double)fit[i].used);
    }
    for (int i = 1; i < RESTORING_FORCES; i++) {
        const struct restoring_candidate *c = &drag->restoring[i], *now = &drag->restoring[chosen];
        if (c->converged && (!now->converged || c->bic < now->bic - (chosen == RESTORING_LINEAR ? DECIDES : 0)))
            chosen = i;
    }
    drag->forces = RESTORING_FORCES;
    drag->force = (enum restoring_force)chosen;
    if (drag->restoring[chosen].converged)
        *best = fit[chosen];
    else
        *best = (struct law_fit){.motion = *start};
    return true;
}
