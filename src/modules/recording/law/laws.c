/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The laws of damping, and the choice among their fits (law_choose()). A law remains possible
 * unless another one, which it does not contain, refutes it by BIC (and by an F-test, if that only
 * has further terms). A law that contains the simplest one remains as long as its further terms may
 * take a considerable share of the energy loss. A law is only claimed if it is the only one that
 * remains. */
#include <hooke/base/catalog.h>
#include "modules/recording/law/drag.h"

#include <gsl/gsl_cdf.h>
#include <stdio.h>

/* Difference of BIC that refutes a law with fewer terms than its rival, which does not contain
 * it. */
#define DELTA_MORE 10.0

static const struct drag_law_row rows[] = {
    {{"linear", "", "viscous: the air at small speeds, eddy currents",
      "y'' + gamma y' + omega0^2 y = 0", NULL},
     LAW_LINEAR},
    {{"quadratic", "", "the air at larger speeds, a disk", "y'' + b|y'|y' + omega0^2 y = 0", NULL},
     LAW_QUADRATIC},
    {{"linear+quadratic", "", "both", "y'' + gamma y' + b|y'|y' + omega0^2 y = 0", NULL},
     LAW_LINEAR | LAW_QUADRATIC},
    {{"dry", "", "Coulomb friction, with sticking", "y'' + f sign(y') + omega0^2 y = 0", NULL},
     LAW_DRY},
    {{"linear+dry", "", "an air track", "y'' + gamma y' + f sign(y') + omega0^2 y = 0", NULL},
     LAW_LINEAR | LAW_DRY},
    {{"quadratic+dry", "", "a disk with a rubbing guide",
      "y'' + b|y'|y' + f sign(y') + omega0^2 y = 0", NULL},
     LAW_QUADRATIC | LAW_DRY},
    {{"linear+quadratic+dry", "", "all three",
      "y'' + gamma y' + b|y'|y' + f sign(y') + omega0^2 y = 0", NULL},
     LAW_LINEAR | LAW_QUADRATIC | LAW_DRY},
};

_Static_assert(COUNT_OF(rows) == DRAG_LAWS, "every sum of the three terms");

const struct catalog drag_law_catalog = CATALOG("law", rows);

const struct drag_rate drag_rates[DRAG_RATES] = {
    {"gamma", "1/s", "1/s"}, {"b", "1/m", ""}, {"f", "m/s^2", "1/s^2"}};

const char *drag_law_name(enum drag_law law)
{
    if (law == LAW_NONE)
        return NULL;
    return law >= LAW_UNDECIDED ? "not distinguishable" : rows[law - 1].row.name;
}

/* Returns the law of row i. */
static enum drag_law law_at(int i)
{
    return rows[i].law;
}

/* Returns the number of terms of a law. */
static int law_terms(enum drag_law law)
{
    return !!(law & LAW_LINEAR) + !!(law & LAW_QUADRATIC) + !!(law & LAW_DRY);
}

/* Returns true if the law has all terms of `part`. */
static bool law_contains(enum drag_law law, enum drag_law part)
{
    return (law & part) == part;
}

/* Returns true if the fit converged with positive rates. */
static bool is_physical(const struct drag_candidate *c)
{
    for (int k = 0; k < DRAG_RATES; k++)
        if (c->law >> k & 1 && !(c->rate[k].value > 0))
            return false;
    return c->converged;
}

/* Returns the F-test p value of the terms that law `large` has beyond law `small`. */
static double term_chance(const struct law_evidence *e, int small, int large)
{
    const double extra = law_terms(law_at(large)) - law_terms(law_at(small));
    const double gain = fmax(e->fit[small].rss - e->fit[large].rss, 0) / e->variance / extra;
    return gsl_cdf_fdist_Q(gain, extra, fmax(e->freedom - e->fit[large].parameters, 1));
}

/* Returns the largest share of the energy loss that the rates which law c has beyond `part` may
 * take: at two standard deviations in the direction in which they grow most. Unless NULL, *there
 * tells whether no rate is negative at that point; if one is, the limit is a law with fewer rates,
 * which is judged separately. */
static double fraction_beyond(const struct law_evidence *e, const struct drag_candidate *c,
                              enum drag_law part, bool *there)
{
    const struct law_fit *fit = &e->fit[c->law - 1];
    double all = 0, excess = 0, variance = 0, weight[LAW_PARAMETERS] = {0},
           covariance[LAW_PARAMETERS] = {0};
    for (int k = 0, j = FIRST_RATE; k < DRAG_RATES; k++) {
        if (!(c->law >> k & 1))
            continue;
        weight[j] = part >> k & 1 ? 0 : e->loss[k];
        all += c->rate[k].value * e->loss[k];
        excess += c->rate[k].value * weight[j++];
    }
    for (int i = FIRST_RATE; i < fit->parameters; i++) {
        for (int j = FIRST_RATE; j < fit->parameters; j++)
            covariance[i] += fit->inverse[i][j] * weight[j] * e->variance;
        variance += weight[i] * covariance[i];
    }
    const double deviation = sqrt(fmax(variance, 0));
    for (int i = FIRST_RATE; i < fit->parameters && there; i++)
        if (fit->index[i] < EQUATION_CUBIC)
            *there = (i == FIRST_RATE || *there) &&
                     fit->motion.value[fit->index[i]] + 2 * covariance[i] / deviation > 0;
    return all > 0 ? fmax(excess + 2 * deviation, 0) / all : 1;
}

/* Returns the excess of BIC by which a law is refuted by a rival that it does not contain. */
static double bic_needed(enum drag_law law, enum drag_law rival)
{
    return law_contains(rival, law) || law_terms(law) <= law_terms(rival) ? DELTA_MIN : DELTA_MORE;
}

/* Returns true if law i is refuted by another that it does not contain: by BIC, and by the F-test
 * if that only has further terms. */
static bool law_is_refuted(const struct law_evidence *e, const struct drag_fit *drag, int i)
{
    const struct drag_candidate *c = &drag->candidate[i];
    for (int j = 0; j < DRAG_LAWS; j++) {
        const struct drag_candidate *rival = &drag->candidate[j];
        if (i != j && is_physical(rival) && !law_contains(c->law, rival->law) &&
            c->bic - rival->bic >= bic_needed(c->law, rival->law) &&
            (!law_contains(rival->law, c->law) || term_chance(e, i, j) < CHANCE_MAX))
            return true;
    }
    return false;
}

/* Returns the index of the law with the fewest rates, then the smallest BIC, of those that the data
 * do not refute, or -1 if all have a rate of the wrong sign. */
static int simplest_law(const struct law_evidence *e, const struct drag_fit *drag)
{
    int simple = -1;
    for (int i = 0; i < DRAG_LAWS; i++) {
        const struct drag_candidate *c = &drag->candidate[i];
        if (!is_physical(c) || law_is_refuted(e, drag, i))
            continue;
        const int more = simple < 0 ? -1 : law_terms(c->law) - law_terms(law_at(simple));
        if (more < 0 || (more == 0 && c->bic < drag->candidate[simple].bic))
            simple = i;
    }
    return simple;
}

/* Returns true if law i remains possible beside the simplest one, with index `simple`. A law that
 * contains the simplest is never refuted: it remains if its further terms may take a considerable
 * share of the loss, or are weakly significant. beside_others is true if other laws remain anyway,
 * so that the share need not be significant. */
static bool law_remains(const struct law_evidence *e, const struct drag_fit *drag, int simple,
                        int i, bool beside_others)
{
    const struct drag_candidate *c = &drag->candidate[i];
    const enum drag_law law = law_at(simple);
    if (i == simple || !c->converged)
        return i == simple;
    if (!law_contains(c->law, law))
        return is_physical(c) && !law_is_refuted(e, drag, i);
    bool there = false;
    const double fraction = fraction_beyond(e, c, law, &there);
    return (is_physical(c) && term_chance(e, simple, i) < HIDDEN_TERM_CHANCE) ||
           ((there || beside_others) &&
            fraction > SHARE_MAX * (law_terms(c->law) - law_terms(law)));
}

/* Returns a mask with bit i set if candidate i remains. If several do, all that contain the
 * simplest and may be present remain, and also the sum of all their terms. */
static unsigned remaining_laws(const struct law_evidence *e, const struct drag_fit *drag,
                               int simple)
{
    unsigned mask = 0, wide = 0, terms_of_all = 0;
    for (int i = 0; i < DRAG_LAWS; i++) {
        mask |= (unsigned)law_remains(e, drag, simple, i, false) << i;
        wide |= (unsigned)law_remains(e, drag, simple, i, true) << i;
        terms_of_all |= wide >> i & 1 ? (unsigned)law_at(i) : 0;
    }
    return mask == 1u << simple ? mask : wide | 1u << (terms_of_all - 1);
}

/* ---- in words ---- */

/* Returns the law with the smallest BIC besides `best`, or -1 if there is none; if `parts`, only of
 * laws that `best` contains. */
static int next_best(const struct drag_fit *drag, int best, bool parts)
{
    int next = -1;
    for (int i = 0; i < DRAG_LAWS; i++) {
        const struct drag_candidate *c = &drag->candidate[i];
        const bool related = law_contains(drag->candidate[best].law, c->law);
        if (i != best && is_physical(c) && (!parts || related) &&
            (next < 0 || c->bic < drag->candidate[next].bic))
            next = i;
    }
    return next;
}

/* Appends the laws that cannot be distinguished (`simple` is the index of the simplest,
 * drag->remaining the mask of all) and the reason: how close the BIC of the best rival is, or how
 * much a further term could explain. */
static void say_undecided(const struct law_evidence *e, int simple, const struct drag_fit *drag,
                          struct buffer *text)
{
    const enum drag_law law = law_at(simple);
    double fraction = 0;
    int rival = -1;
    buffer_format(text, "not distinguishable: %s", drag_law_name(law));
    for (int i = 0; i < DRAG_LAWS; i++) {
        const struct drag_candidate *c = &drag->candidate[i];
        if (i == simple || !(drag->remaining >> i & 1))
            continue;
        buffer_format(text, " or %s", drag_law_name(c->law));
        if (law_contains(c->law, law))
            fraction = fmax(fraction, fraction_beyond(e, c, law, NULL));
        else if (rival < 0 || c->bic < drag->candidate[rival].bic)
            rival = i;
    }
    if (rival >= 0) {
        const double bic_difference = drag->candidate[rival].bic - drag->candidate[simple].bic;
        buffer_format(text, " (BIC of %s is %s by only %.3g, %g needed",
                      drag_law_name(law_at(rival)), bic_difference < 0 ? "lower" : "higher",
                      fabs(bic_difference), bic_needed(law_at(rival), law));
    }
    if (fraction > 0)
        buffer_format(text, "%sa further term could explain %.0f %% of the energy loss",
                      rival < 0 ? " (" : "; ", 100 * fmin(fraction, 1));
    if (rival >= 0 || fraction > 0)
        buffer_char(text, ')');
}

/* Appends the evidence for the claimed law, candidate number `best`: by how much BIC is lower than
 * that of the next law or of the law with one term less, the F-test, and what a further term would
 * explain. */
static void say_claimed(const struct law_evidence *e, int best, const struct drag_fit *drag,
                        struct buffer *text)
{
    const struct drag_candidate *c = &drag->candidate[best];
    const int next = next_best(drag, best, false), part = next_best(drag, best, true);
    double fraction = 0;
    for (int i = 0; i < DRAG_LAWS; i++)
        if (law_terms(law_at(i)) == law_terms(c->law) + 1 && law_contains(law_at(i), c->law) &&
            drag->candidate[i].converged)
            fraction = fmax(fraction, fraction_beyond(e, &drag->candidate[i], c->law, NULL));
    if (part >= 0)
        buffer_format(text,
                      "%s: its last term lowers BIC by %.3g against %s (%g needed), F-test p = "
                      "%.1g (%g needed)",
                      drag_law_name(c->law), drag->candidate[part].bic - c->bic,
                      drag_law_name(law_at(part)), DELTA_MIN, drag->p_value, CHANCE_MAX);
    else if (next >= 0)
        buffer_format(text, "%s: BIC is lower by %.3g than that of %s", drag_law_name(c->law),
                      drag->delta, drag_law_name(law_at(next)));
    else
        buffer_format(text, "%s: every other law would have a negative coefficient",
                      drag_law_name(c->law));
    if (law_terms(c->law) < DRAG_RATES)
        buffer_format(text, "; a further term explains less than %.2g %% of the energy loss",
                      fmax(100 * fraction, 0.1));
}

/* Finds the simplest law and those that remain possible beside it, and stores them with the
 * evidence in words in result->drag. Returns the index of the best law. */
int law_choose(const struct law_evidence *e, struct fit *result)
{
    struct drag_fit *drag = &result->drag;
    const int simple = simplest_law(e, drag), best = simple < 0 ? LAW_LINEAR - 1 : simple;
    const struct drag_candidate *c = &drag->candidate[best];
    struct buffer text = {0};
    drag->best = c->law;
    drag->remaining = simple < 0 ? 1u << best : remaining_laws(e, drag, simple);
    const int next = next_best(drag, best, false), part = next_best(drag, best, true);
    drag->delta = next < 0 ? INFINITY : drag->candidate[next].bic - c->bic;
    drag->p_value = NAN;
    if (part >= 0)
        drag->p_value = term_chance(e, part, best);
    else if (next >= 0 && law_contains(law_at(next), c->law))
        drag->p_value = term_chance(e, best, next);
    const bool decided = drag->remaining == 1u << best;
    result->preferred = decided ? c->law : LAW_UNDECIDED;
    if (simple < 0)
        buffer_format(&text, "%s: every law would have a negative coefficient",
                      drag_law_name(c->law));
    else if (decided)
        say_claimed(e, best, drag, &text);
    else
        say_undecided(e, best, drag, &text);
    snprintf(drag->said, sizeof drag->said, "%.*s", (int)text.len, text.data ? text.data : "");
    buffer_free(&text);
    return best;
}
