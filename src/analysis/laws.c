/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The laws of damping, and the choice among their fits. A law is claimed only where (1) every term it has is needed:
 * BIC and an F-test; (2) no other law that does not contain it fits about as well; (3) a further term could take only a
 * small share of the energy lost. Else the data do not distinguish.
 */
#include "law_fit.h"

#include <gsl/gsl_cdf.h>
#include <stdio.h>

#define DELTA_LEAST 6.0  /* of BIC, and */
#define DELTA_MORE 10.0  /* of BIC against a law that has more terms, and none of its own in common */
#define CHANCE_MOST 0.01 /* of the F-test, for a further term */
#define HIDDEN 0.05      /* chance below which a further term may be there although it is not shown to be */
#define SHARE_MOST 0.3   /* of the energy lost that a further term may take at most (two standard deviations) */

static const struct drag_law_row rows[] = {
    {{"linear", "", "viscous: the air at small speeds, eddy currents", "y'' + gamma y' + omega0^2 y = 0", NULL},
     LAW_LINEAR},
    {{"quadratic", "", "the air at larger speeds, a disk", "y'' + b|y'|y' + omega0^2 y = 0", NULL}, LAW_QUADRATIC},
    {{"linear+quadratic", "", "both", "y'' + gamma y' + b|y'|y' + omega0^2 y = 0", NULL}, LAW_LINEAR | LAW_QUADRATIC},
    {{"dry", "", "Coulomb friction, with sticking", "y'' + f sign(y') + omega0^2 y = 0", NULL}, LAW_DRY},
    {{"linear+dry", "", "a rail with air", "y'' + gamma y' + f sign(y') + omega0^2 y = 0", NULL}, LAW_LINEAR | LAW_DRY},
    {{"quadratic+dry", "", "a disk with a rubbing guide", "y'' + b|y'|y' + f sign(y') + omega0^2 y = 0", NULL},
     LAW_QUADRATIC | LAW_DRY},
    {{"linear+quadratic+dry", "", "all three", "y'' + gamma y' + b|y'|y' + f sign(y') + omega0^2 y = 0", NULL},
     LAW_LINEAR | LAW_QUADRATIC | LAW_DRY},
};

_Static_assert(COUNT_OF(rows) == DRAG_LAWS, "every sum of the three terms");

const struct catalog drag_law_catalog = CATALOG("law", rows);

const struct drag_rate drag_rates[DRAG_RATES] = {{"gamma", "1/s", "1/s"}, {"b", "1/m", ""}, {"f", "m/s^2", "1/s^2"}};

const char *drag_law_name(enum drag_law law)
{
    return law == LAW_NONE ? NULL : law >= LAW_UNDECIDED ? "not distinguishable" : rows[law - 1].row.name;
}

static enum drag_law law_at(int i)
{
    return rows[i].law;
}

static int terms(enum drag_law law)
{
    return !!(law & LAW_LINEAR) + !!(law & LAW_QUADRATIC) + !!(law & LAW_DRY);
}

static bool contains(enum drag_law law, enum drag_law part)
{
    return (law & part) == part;
}

static bool physical(const struct drag_candidate *c)
{
    for (int k = 0; k < DRAG_RATES; k++)
        if (c->law >> k & 1 && !(c->rate[k].value > 0))
            return false;
    return c->converged;
}

static double chance(const struct law_evidence *e, int small, int large)
{
    const double extra = terms(law_at(large)) - terms(law_at(small));
    const double gain = fmax(e->fit[small].rss - e->fit[large].rss, 0) / e->variance / extra;
    return gsl_cdf_fdist_Q(gain, extra, fmax(e->freedom - e->fit[large].parameters, 1));
}

/* The largest share of the loss that the terms which `large` has beyond `law` may take. */
static double share_beyond(const struct law_evidence *e, const struct drag_candidate *large, enum drag_law law)
{
    double all = 0, beyond = 0;
    for (int k = 0; k < DRAG_RATES; k++) {
        const bool further = large->law >> k & 1 && !(law >> k & 1);
        all += large->rate[k].value * e->loss[k];
        beyond += further ? (large->rate[k].value + 2 * large->rate[k].uncertainty) * e->loss[k] : 0;
    }
    return beyond / all;
}

/* Why the best law is not to be claimed: false, and the reason. */
static bool stands_against(const struct law_evidence *e, int best, int other, struct fit *out)
{
    struct drag_fit *drag = &out->drag;
    const struct drag_candidate *a = &drag->candidate[best], *b = &drag->candidate[other];
    const char *name = drag_law_name(b->law);
    const double over = b->bic - a->bic;
    if (contains(a->law, b->law)) {
        const double p = chance(e, other, best);
        if (over >= DELTA_LEAST && p < CHANCE_MOST)
            return true;
        snprintf(drag->said, sizeof drag->said,
                 "not distinguishable: %s is best, but lowers BIC by only %.3g against %s (%g needed), F-test p = %.1g",
                 drag_law_name(a->law), over, name, DELTA_LEAST, p);
    } else if (contains(b->law, a->law)) {
        if (terms(b->law) > terms(a->law) + 1)
            return true;
        const double p = chance(e, best, other), share = share_beyond(e, b, a->law);
        if (!(physical(b) && p < HIDDEN) && share < SHARE_MOST)
            return true;
        snprintf(drag->said, sizeof drag->said,
                 "not distinguishable: %s is best, but %s is not excluded (F-test p = %.1g; its further term could take "
                 "%.0f %% of the loss)",
                 drag_law_name(a->law), name, p, 100 * fmin(fabs(share), 1));
    } else {
        const double needed = terms(b->law) > terms(a->law) ? DELTA_MORE : DELTA_LEAST;
        if (!physical(b) || over >= needed)
            return true;
        snprintf(drag->said, sizeof drag->said,
                 "not distinguishable: BIC of %s is lower by only %.3g than that of %s (%g needed)",
                 drag_law_name(a->law), over, name, needed);
    }
    return false;
}

/* Among the laws that the data do not tell from the best, one with fewer terms. */
static int simplest(const struct law_evidence *e, int best, struct fit *out)
{
    int simple = best;
    for (int i = 0; i < DRAG_LAWS; i++)
        if (i != best && terms(law_at(i)) < terms(law_at(simple)) && physical(&out->drag.candidate[i]) &&
            !stands_against(e, best, i, out))
            simple = i;
    return simple;
}

/* The law with the least BIC among `others`, -1: none. */
static int next_best(const struct drag_fit *drag, int best, bool parts)
{
    int next = -1;
    for (int i = 0; i < DRAG_LAWS; i++) {
        const struct drag_candidate *c = &drag->candidate[i];
        const bool related = contains(drag->candidate[best].law, c->law);
        if (i != best && physical(c) && (!parts || related) && (next < 0 || c->bic < drag->candidate[next].bic))
            next = i;
    }
    return next;
}

int law_choose(const struct law_evidence *e, struct fit *out)
{
    struct drag_fit *drag = &out->drag;
    int best = -1, undecided = 0;
    for (int i = 0; i < DRAG_LAWS; i++)
        if (physical(&drag->candidate[i]) && (best < 0 || drag->candidate[i].bic < drag->candidate[best].bic))
            best = i;
    if (best < 0)
        best = LAW_LINEAR - 1;
    best = simplest(e, best, out);
    const struct drag_candidate *c = &drag->candidate[best];
    drag->best = c->law;
    for (int i = 0; i < DRAG_LAWS && !undecided; i++)
        undecided = i != best && drag->candidate[i].converged && !stands_against(e, best, i, out);
    const int next = next_best(drag, best, false), part = next_best(drag, best, true);
    drag->delta = next < 0 ? INFINITY : drag->candidate[next].bic - c->bic;
    drag->p_value = part >= 0   ? chance(e, part, best)
                    : next >= 0 && contains(law_at(next), c->law) ? chance(e, best, next)
                                                                  : NAN;
    out->preferred = undecided ? LAW_UNDECIDED : c->law;
    if (undecided)
        return best;
    if (part >= 0)
        snprintf(drag->said, sizeof drag->said,
                 "%s: its last term lowers BIC by %.3g against %s (%g needed), F-test p = %.1g (%g needed)",
                 drag_law_name(c->law), drag->candidate[part].bic - c->bic, drag_law_name(law_at(part)), DELTA_LEAST,
                 drag->p_value, CHANCE_MOST);
    else if (next >= 0)
        snprintf(drag->said, sizeof drag->said,
                 "%s: BIC is lower by %.3g than that of %s (%g needed); no further term is needed", drag_law_name(c->law),
                 drag->delta, drag_law_name(law_at(next)), DELTA_LEAST);
    else
        snprintf(drag->said, sizeof drag->said, "%s: every other law would have a negative coefficient",
                 drag_law_name(c->law));
    return best;
}
