/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the law by which an oscillation decays (drag_laws()): the equation of motion under each law
 * is integrated (equation.c) and fitted to all samples (law_fit.c), starting from the averaged
 * envelope. Which samples take part, and whether the baseline wanders, is judged by the residuals
 * of the most general law, not by those of the damped sine. */
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include "modules/recording/law/drag.h"

#include <string.h>

/* Rounds between samples in use and fits. */
enum { ROUNDS = 4 };

/* Samples above which the final fits are as rough as the search (see the next constants). */
#define LONG_RECORDING_SAMPLES 100000
/* A step that promises to gain fewer variances is taken without evaluation: in the search, and in
 * the end. */
#define SEARCH_PROMISE_VARIANCES 100.0
#define FINAL_PROMISE_VARIANCES 1e-3
#define REJECT_AT 5.0 /* robust standard deviations from which on a sample is left out */
/* Samples stay clipped only if at least this part of them is off the law. */
#define CLIPPED_OFF_MIN_FRACTION 0.2
/* Periods in a block of a wandering baseline. */
#define BASELINE_PERIODS 3
/* The baseline wanders if a block's own baseline removes more than this multiple of the variance of
 * the residuals. */
#define WANDERING_VARIANCE_RATIO 2.0

/* Sets index[] to the parameters of the equation of motion that a law and a restoring force leave
 * free: start, speed, omega, the rates of the law, and beta for a Duffing spring. Returns their
 * number. */
int drag_indices(enum drag_law law, enum restoring_force force, int index[LAW_PARAMETERS])
{
    int count = FIRST_RATE;
    index[START] = EQUATION_START;
    index[SPEED] = EQUATION_SPEED;
    index[OMEGA] = EQUATION_OMEGA;
    for (int k = 0; k < DRAG_RATES; k++)
        if (law >> k & 1)
            index[count++] = EQUATION_RATE + k;
    if (force == RESTORING_CUBIC)
        index[count++] = EQUATION_CUBIC;
    return count;
}

/* ---- the fits ---- */

/* Sets the start values of law i: of a single law from the rates of the envelope; of a sum from the
 * best fit of a law that it contains, with its further rate at 0. */
static void begin_law(struct drag_fitting *f, int i)
{
    const enum drag_law law = (enum drag_law)(i + 1);
    struct law_fit *fit = &f->fit[i];
    int part = -1;
    for (int j = 0; j < i; j++)
        if (((j + 1) & (i + 1)) == j + 1 && f->fit[j].converged &&
            (part < 0 || f->fit[j].rss < f->fit[part].rss))
            part = j;
    *fit = (struct law_fit){.motion = part >= 0 ? f->fit[part].motion : f->start,
                            .omega = f->start.value[EQUATION_OMEGA]};
    fit->parameters = drag_indices(law, f->start.force, fit->index);
    for (int k = 0; k < DRAG_RATES && part < 0; k++)
        fit->motion.value[EQUATION_RATE + k] = law >> k & 1 ? f->rate[k] : 0;
}

/* Tries a few sizes of a single rate and starts from the best. */
static void drag_fit_scan(const struct drag_fitting *f, struct law_fit *fit)
{
    static const double sizes[] = {0.4, 0.7, 1, 1.5, 2.5};
    double *rate = &fit->motion.value[fit->index[FIRST_RATE]], guess = *rate, best = guess,
           min = HUGE_VAL;
    for (size_t k = 0; k < COUNT_OF(sizes); k++) {
        *rate = guess * sizes[k];
        const double sum = law_squares(&f->samples, fit);
        if (sum < min) {
            min = sum;
            best = *rate;
        }
    }
    *rate = best;
}

/* Fits law i, from its last answer if `again`, else from a new start; a single law that fails is
 * tried from other sizes. trust is that of law_descend(). */
static void fit_law(struct drag_fitting *f, int i, bool again, double trust)
{
    struct law_fit *fit = &f->fit[i];
    const bool begins = !again || !fit->converged;
    if (begins)
        begin_law(f, i);
    if (law_descend(&f->samples, trust, f->rounding, fit) || !begins ||
        fit->parameters > FIRST_RATE + 1)
        return;
    begin_law(f, i);
    drag_fit_scan(f, fit);
    law_descend(&f->samples, trust, f->rounding, fit);
}

/* Fits all laws. */
static void fit_laws(struct drag_fitting *f, bool again, double trust)
{
    for (int i = 0; i < DRAG_LAWS && !cancelled(f->samples.cancel); i++)
        fit_law(f, i, again, trust);
}

/* Returns the law with the smallest sum of squares, or -1 if none converged. */
static int nearest_law(const struct drag_fitting *f)
{
    int best = -1;
    for (int i = 0; i < DRAG_LAWS; i++)
        if (f->fit[i].converged && (best < 0 || f->fit[i].rss < f->fit[best].rss))
            best = i;
    return best;
}

/* ---- which samples, which baseline ---- */

/* Sets a baseline of one block, a constant or a straight line. */
static void baseline_single(struct drag_fitting *f, int terms)
{
    struct baseline *baseline = &f->samples.baseline;
    *baseline = (struct baseline){.blocks = 1, .edge = f->edge, .terms = terms};
    f->edge[0] = 0;
    f->edge[1] = f->motion->samples.n;
}

/* Returns a baseline with a parabola in every BASELINE_PERIODS periods; edge receives the blocks'
 * limits (indices of samples). */
static struct baseline baseline_in_blocks(const struct drag_fitting *f, size_t *edge)
{
    const struct samples *x = &f->motion->samples;
    const double span = x->t[x->n - 1] - x->t[0], omega = f->start.value[EQUATION_OMEGA];
    const double count =
        fmin(floor(omega * span / TWO_PI / BASELINE_PERIODS), (double)(x->n / BASELINE_MIN));
    struct baseline baseline = {
        .blocks = (size_t)fmax(count, 1), .edge = edge, .terms = BASELINE_TERMS};
    edge[0] = 0;
    for (size_t k = 1; k < baseline.blocks; k++) {
        const size_t index = samples_index(x, x->t[0] + span * (double)k / (double)baseline.blocks);
        edge[k] = index > edge[k - 1] ? index : edge[k - 1] + 1;
    }
    edge[baseline.blocks] = x->n;
    return baseline;
}

/* Returns true if the residuals of law `index` require a baseline in every block. Compares the
 * variance that the additional terms remove with the variance left, as an F test does. */
static bool baseline_wanders(struct drag_fitting *f, int index, size_t *edge)
{
    struct law_samples local = f->samples;
    local.baseline = baseline_in_blocks(f, edge);
    struct law_fit trial = f->fit[index];
    const double joint_squares = law_squares(&f->samples, &trial),
                 local_squares = law_squares(&local, &trial);
    const double more =
        (double)(BASELINE_TERMS * local.baseline.blocks) - f->samples.baseline.terms;
    const double left = (double)trial.used - (double)(BASELINE_TERMS * local.baseline.blocks);
    if (!(more > 0) || !(left > 0) ||
        local_squares < (double)trial.used * INTEGRATION_ROUNDING_SQUARED * f->size * f->size)
        return false;
    return (joint_squares - local_squares) / more >
           (WANDERING_VARIANCE_RATIO + 3 * sqrt(2 / more)) * local_squares / left;
}

/* Decides which samples are used, by the residuals of the nearest law: those within REJECT_AT
 * robust standard deviations of their segment. Samples that were clipped remain left out if many of
 * them deviate. Returns the number of samples whose use changed. */
static size_t judge_samples(struct drag_fitting *f, const double *residual)
{
    struct motion *m = f->motion;
    const struct samples *x = &m->samples;
    size_t changed = 0, deviating = 0;
    for (size_t k = 0; k < m->segments; k++) {
        struct swing_segment *s = &m->segment[k];
        for (size_t i = s->begin; i < s->end; i++)
            m->scratch[i - s->begin] = fabs(residual[i]);
        s->scale = MAD_TO_SIGMA * values_quantile(m->scratch, s->end - s->begin, 0.5);
    }
    for (size_t k = 0; k < m->segments; k++)
        m->scratch[k] = m->segment[k].scale;
    const double typical =
        fmax(values_quantile(m->scratch, m->segments, 0.5), m->quantum / sqrt(12.0));
    for (int twice = 0; twice < 2; twice++) {
        const bool clips = (double)deviating > CLIPPED_OFF_MIN_FRACTION * (double)m->clipped;
        for (size_t k = 0; k < m->segments; k++) {
            const double max = REJECT_AT * fmax(m->segment[k].scale, typical) + 1e-7 * f->size;
            for (size_t i = m->segment[k].begin; i < m->segment[k].end; i++) {
                const bool far = fabs(residual[i]) > max;
                deviating += twice == 0 && far && !x->use[i];
                if (twice == 0 || (m->clipped > 0 && clips && !x->use[i]))
                    continue;
                changed += f->use[i] != !far;
                f->use[i] = !far;
            }
        }
    }
    return changed;
}

/* Fits the laws only to the part in which the body moves, to find a start for the fit of all
 * samples. The point at which friction stops a body is a periodic function of the friction, with a
 * tooth for each half period, so that samples at rest are fitted in every tooth; the moving part
 * finds the right one. Returns false if the body does not come to rest. */
static bool fit_motion_first(struct drag_fitting *f)
{
    const struct samples *x = &f->motion->samples;
    const size_t rest = samples_quiet(x, TWO_PI / f->start.value[EQUATION_OMEGA]);
    if (rest >= x->n)
        return false;
    memset(f->use + rest, 0, x->n - rest);
    fit_laws(f, false, FINAL_PROMISE_VARIANCES);
    memcpy(f->use + rest, x->use + rest, x->n - rest);
    return true;
}

/* Chooses the samples to use and fits the laws, in turn, until hardly any sample changes (less than
 * 0.1 %) or ROUNDS are done. Once, if the residuals of the nearest law require it, the baseline is
 * fitted in blocks (edge [blocks + 1] receives their limits). Finally fits all laws anew if the
 * choice has changed or the recording is short. Returns false if no law converged or if cancelled.
 */
static bool settle_samples(struct drag_fitting *f, size_t *edge)
{
    struct motion *m = f->motion;
    bool local = false, changes = fit_motion_first(f);
    fit_laws(f, changes, SEARCH_PROMISE_VARIANCES);
    for (int round = 0; round < ROUNDS; round++) {
        const int index = nearest_law(f);
        if (index < 0 || !law_residuals(&f->samples, &f->fit[index], m->residual, NULL, NULL))
            return false;
        const size_t changed = judge_samples(f, m->residual);
        const bool now = !local && baseline_wanders(f, index, edge);
        if (now)
            f->samples.baseline = baseline_in_blocks(f, edge);
        local = local || now;
        changes = changes || now || changed > 0;
        if (!now && (double)changed < 1e-3 * (double)m->samples.n)
            break;
        fit_law(f, index, true, SEARCH_PROMISE_VARIANCES);
    }
    if (changes || m->samples.n < LONG_RECORDING_SAMPLES)
        fit_laws(f, true,
                 m->samples.n < LONG_RECORDING_SAMPLES ? FINAL_PROMISE_VARIANCES
                                                       : SEARCH_PROMISE_VARIANCES);
    return nearest_law(f) >= 0;
}

/* ---- the whole ---- */

/* Sets the start of the search: the damped sine at t0, integrated start.order times to a position,
 * as position, speed and omega0. */
static void begin_drag_fitting(const struct motion *m, struct drag_fitting *f)
{
    const struct harmonic *h = &m->harmonic;
    const double back = f->t0 - h->origin, e = exp(-0.5 * h->gamma * back);
    const double c = e * cos(h->omega * back), s = e * sin(h->omega * back);
    double p = h->a * c + h->b * s, q = h->b * c - h->a * s;
    const double damping = -0.5 * h->gamma, square = h->omega * h->omega + damping * damping;
    for (int k = 0; k < f->start.order; k++) { /* integrate exp(damping s) (p cos + q sin) */
        const double was = p;
        p = (damping * was - h->omega * q) / square;
        q = (damping * q + h->omega * was) / square;
    }
    f->start.value[EQUATION_START] = p;
    f->start.value[EQUATION_SPEED] = damping * p + h->omega * q;
    f->start.value[EQUATION_OMEGA] = sqrt(square);
}

/* Estimates the rates of all terms from the envelope: A' = -(gamma/2) A - (4 b omega/(3 pi)) A^2 -
 * 2 f/(pi omega) (Nayfeh & Mook 1979, 3.3). span [s] is the length of the series. */
static void guess_rates(const struct envelope_rates rates[3], double span, struct drag_fitting *f)
{
    const double *value = f->start.value, omega = value[EQUATION_OMEGA];
    const double a = hypot(value[EQUATION_START], value[EQUATION_SPEED] / omega);
    const double gamma = fmax(rates[0].gamma, 1e-6 * omega);
    const double mean = a * -expm1(-0.5 * gamma * span) / (0.5 * gamma * span);
    f->rate[0] = gamma;
    f->rate[1] = fmax(rates[1].q, 1e-6 * omega) * 3 * PI / (4 * omega * a);
    f->rate[2] = 0.25 * PI * omega * gamma * mean;
    f->size = a * pow(omega, f->start.order);
    f->rounding = INTEGRATION_ROUNDING_SQUARED * f->size * f->size;
}

/* Sets up the fits of all laws. Returns false if out of memory. */
static bool prepare_drag_fitting(struct motion *m, enum quantity quantity, struct arena *arena,
                                 struct drag_fitting *f)
{
    const size_t n = m->samples.n;
    *f = (struct drag_fitting){.motion = m, .t0 = m->samples.t0};
    f->start.t0 = f->t0;
    f->start.order = quantity_order(quantity) > 0 ? quantity_order(quantity) : 0;
    f->use = arena_alloc(arena, n);
    f->edge = arena_array(arena, 2, sizeof *f->edge);
    if (!f->use || !f->edge)
        return false;
    memcpy(f->use, m->samples.use, n);
    f->samples = (struct law_samples){.samples = &m->samples,
                                      .use = f->use,
                                      .middle = m->harmonic.c,
                                      .cancel = m->samples.cancel};
    baseline_single(f, m->harmonic.drifts ? 2 : 1);
    begin_drag_fitting(m, f);
    return true;
}

/* Chooses the restoring force, under which the laws of damping are then fitted, and its start
 * values; sin y is tried only for angles. Returns false if no force can be fitted. */
static bool choose_force(struct drag_fitting *f, enum quantity quantity, struct drag_fit *drag)
{
    const bool angle = quantity == QUANTITY_ANGLE || quantity == QUANTITY_ANGULAR_FREQUENCY ||
                       quantity == QUANTITY_ANGULAR_ACCELERATION || quantity == QUANTITY_OTHER;
    struct law_fit best;
    if (!restoring_choose(f, angle, drag, &best))
        return false;
    if (best.motion.force == RESTORING_LINEAR)
        return true;
    f->start = best.motion;
    for (int k = 0; k < DRAG_RATES; k++) {
        f->start.value[EQUATION_RATE + k] = 0;
        f->rate[k] = best.motion.value[EQUATION_RATE + k] > 0 ? best.motion.value[EQUATION_RATE + k]
                                                              : f->rate[k];
    }
    return true;
}

/* Fits all laws of damping to the motion and chooses one by BIC: first the samples, the baseline
 * and, if `forces` is set, the restoring force. rates[] are start values from the envelope. Stores
 * everything in *result. Returns false with the error. */
bool drag_laws(struct motion *m, enum quantity quantity, bool forces,
               const struct envelope_rates rates[3], struct arena *arena, struct fit *result,
               struct error *error)
{
    struct drag_fitting f;
    size_t *edge = arena_array(arena, m->samples.n / BASELINE_MIN + 2, sizeof *edge);
    if (!edge || !prepare_drag_fitting(m, quantity, arena, &f))
        return error_memory(error);
    guess_rates(rates, m->samples.t[m->samples.n - 1] - f.t0, &f);
    struct drag_fit *drag = &result->drag;
    *drag = (struct drag_fit){.candidates = DRAG_LAWS};
    if (forces && !choose_force(&f, quantity, drag))
        return error_set(error, ERROR_NUMERICAL,
                         "no restoring force could be fitted because the search did not converge");
    const bool settled = settle_samples(&f, edge);
    if (cancelled(m->samples.cancel))
        return error_set(error, ERROR_CANCELLED, "the fit was stopped");
    const int widest = settled ? nearest_law(&f) : -1;
    struct drag_factors factors;
    if (widest < 0 || !law_residuals(&f.samples, &f.fit[widest], m->residual, NULL, NULL) ||
        !drag_factors(&f, &f.fit[widest], &factors))
        return error_set(error, ERROR_NUMERICAL,
                         "no law of damping could be fitted because the search did not converge");
    struct law_evidence evidence = {.fit = f.fit};
    /* Slow changes (sway) reduce the number of independent residuals; beyond DRAG_WIDENED the
     * windows are the independent data. */
    evidence.variance = factors.amplitude * fmax(factors.sigma * factors.sigma, f.rounding);
    drag->independent = fmax((double)f.fit[widest].used / factors.amplitude, 2);
    const bool by_windows = factors.amplitude > DRAG_WIDENED && factors.windows >= DRAG_WINDOWS_MIN;
    evidence.freedom = by_windows ? factors.windows : drag->independent;
    for (int i = 0; i < DRAG_LAWS; i++) {
        drag_describe(&f.fit[i], i, factors.sigma * sqrt(factors.amplitude), &drag->candidate[i]);
        drag->candidate[i].bic = (f.fit[i].parameters - FIRST_RATE) * log(drag->independent) +
                                 (f.fit[i].rss - f.fit[widest].rss) / evidence.variance;
    }
    drag_losses(&f, &f.fit[widest], evidence.loss);
    const int best = law_choose(&evidence, result);
    if (!drag_report_offset(&f, &f.fit[best], &factors, arena, result))
        return error_memory(error);
    drag_report(&f, best, &factors, result);
    /* The samples left out are then those of this fit. */
    m->clipped = m->clipped < result->rejected ? m->clipped : 0;
    m->rejected = result->rejected;
    memcpy(m->samples.use, f.use, m->samples.n);
    m->harmonic.drifts = m->harmonic.drifts && f.samples.baseline.blocks == 1;
    return true;
}
