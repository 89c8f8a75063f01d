/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Which drag makes the oscillation die out: y = c + E(s) (p cos(omega s) + q sin(omega s)) with the averaged envelope E
 * of each law, fitted to all samples, and the choice between them. Averaging is good to the square of the relative loss
 * in a period.
 */
#include "internal.h"

#include <gsl/gsl_cdf.h>
#include <stdio.h>

enum { P, Q, OFFSET, OMEGA, FIRST_RATE, WINDOWS_LEAST = 8, WINDOWS_MOST = 256 };

#define DELTA_LEAST 6.0  /* of BIC, and */
#define CHANCE_MOST 0.01 /* of the F-test, for a second term */
#define HIDDEN 0.1       /* chance below which a second term may be there although it is not shown to be */
#define AVERAGED 1e-10   /* mean square to which averaging is good: no law is better than that */

static const struct law {
    enum drag_law law;
    bool has[3]; /* gamma, q, f */
} laws[DRAG_LAWS] = {
    {LAW_LINEAR, {true, false, false}},
    {LAW_QUADRATIC, {false, true, false}},
    {LAW_MIXED, {true, true, false}},
    {LAW_FRICTION, {false, false, true}},
};
enum { LINEAR, QUADRATIC, MIXED };

struct drag_curve {
    const struct law *law;
    double t0;
};

static struct envelope_rates rates_of(const struct law *law, const double *x)
{
    double rate[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++)
        if (law->has[i])
            rate[i] = *x++;
    return (struct envelope_rates){rate[0], rate[1], rate[2]};
}

static bool evaluate(void *context, const double *x, const double *t, size_t n, double *value, double *derivative)
{
    const struct drag_curve *o = context;
    struct envelope_rates rates = rates_of(o->law, x + FIRST_RATE);
    size_t count = FIRST_RATE + (size_t)o->law->has[0] + o->law->has[1] + o->law->has[2];
    for (size_t i = 0; i < n; i++) {
        double s = t[i] - o->t0, by[3], e = envelope_value(&rates, s, by);
        double c = cos(x[OMEGA] * s), d = sin(x[OMEGA] * s), swing = x[P] * c + x[Q] * d;
        value[i] = x[OFFSET] + e * swing;
        if (!isfinite(value[i]))
            return false;
        if (!derivative)
            continue;
        double *row = derivative + i * count;
        row[P] = e * c;
        row[Q] = e * d;
        row[OFFSET] = 1;
        row[OMEGA] = e * s * (x[Q] * c - x[P] * d);
        for (int k = 0, at = FIRST_RATE; k < 3; k++)
            if (o->law->has[k])
                row[at++] = by[k] * swing;
    }
    return true;
}

/* ---- uncertainties ---- */

/* Of what changes by g [parameters] with the parameters; widened by the factor of the variance. */
static double deviation(const struct curve_fit *f, const double *g, double factor)
{
    double sum = 0;
    for (int i = 0; i < f->parameters; i++)
        for (int j = 0; j < f->parameters; j++)
            sum += g[i] * f->formal[i] * f->correlation[i][j] * f->formal[j] * g[j];
    return sqrt(factor * fmax(sum, 0));
}

/*
 * By how much slow changes of the amplitude (sway) make the variance of rates larger than independent residuals would:
 * the residuals' part in phase with the oscillation, window by window of two periods, against their own size, with its
 * correlation from window to window.
 */
static double amplitude_factor(const struct series *x, double t0, const struct curve_fit *f)
{
    double omega = f->value[OMEGA].value, p = f->value[P].value, q = f->value[Q].value, a = hypot(p, q);
    double span = x->t[x->n - 1] - x->t[0], product = 0, square = 0, expected = 0, before = 0;
    double windows = 0;
    size_t count = (size_t)fmin(WINDOWS_MOST, 0.25 * omega * span / PI), i = 0;
    for (size_t k = 0; k < count; k++) {
        double end = x->t[0] + span * (double)(k + 1) / (double)count, in_phase = 0, norm = 0;
        for (; i < x->n && (x->t[i] <= end || k + 1 == count); i++) {
            double s = x->t[i] - t0, u = (p * cos(omega * s) + q * sin(omega * s)) / a;
            in_phase += u * f->residual[i];
            norm += u * u;
        }
        if (!(norm > 0))
            continue;
        in_phase /= sqrt(norm);
        square += in_phase * in_phase;
        product += in_phase * before;
        expected += f->sigma * f->sigma;
        before = in_phase;
        windows++;
    }
    if (windows < WINDOWS_LEAST || !(expected > 0))
        return autocorrelation_factor(f->autocorrelation);
    double left = windows / fmax(windows - 3, 1); /* up to three parameters of the envelope are fitted */
    return fmax(1, square / expected * left * autocorrelation_factor(product / square));
}

/* ---- the choice ---- */

static bool is_better(const struct curve_fit *fit, int a, int b)
{
    return b < 0 || (fit[a].converged && (!fit[b].converged || fit[a].rss < fit[b].rss));
}

/* With variance [y^2] of one independent residual; best: the law that the fit's values are those of. */
static int choose(const struct curve_fit *fit, double variance, struct fit *out)
{
    struct drag_fit *drag = &out->drag;
    int best = -1, next = -1;
    double least = HUGE_VAL;
    for (int i = 0; i < DRAG_LAWS; i++) {
        int rates = fit[i].parameters - FIRST_RATE;
        least = fmin(least, fit[i].rss);
        drag->candidate[i].law = laws[i].law;
        drag->candidate[i].converged = fit[i].converged;
        drag->candidate[i].bic = rates * log(drag->independent); /* the other parameters are the same for all */
        if (i != MIXED && is_better(fit, i, best)) {
            next = best;
            best = i;
        } else if (i != MIXED && is_better(fit, i, next)) {
            next = i;
        }
    }
    for (int i = 0; i < DRAG_LAWS; i++)
        drag->candidate[i].bic += (fit[i].rss - least) / variance;
    const double *mixed = (const double[]){fit[MIXED].value[FIRST_RATE].value, fit[MIXED].value[FIRST_RATE + 1].value};
    double gain = (fit[best].rss - fit[MIXED].rss) / variance, freedom = fmax(drag->independent - 6, 1);
    double over_single = drag->candidate[best].bic - drag->candidate[MIXED].bic;
    double over_next = drag->candidate[next].bic - drag->candidate[best].bic;
    bool physical = fit[MIXED].converged && mixed[0] > 0 && mixed[1] > 0;
    drag->p_value = fit[MIXED].converged ? gsl_cdf_fdist_Q(fmax(gain, 0), 1, freedom) : NAN;
    const char *name = drag_law_name(laws[best].law), *other = drag_law_name(laws[next].law);
    if (physical && over_single >= DELTA_LEAST && drag->p_value < CHANCE_MOST) {
        out->preferred = LAW_MIXED;
        drag->delta = over_single;
        snprintf(drag->said, sizeof drag->said,
                 "mixed: its second term lowers BIC by %.3g against %s alone (%g needed), F-test p = %.1g (%g needed)",
                 over_single, name, DELTA_LEAST, drag->p_value, CHANCE_MOST);
        return MIXED;
    }
    drag->delta = over_next;
    bool alone = over_next >= DELTA_LEAST && !(physical && drag->p_value < HIDDEN);
    out->preferred = alone ? laws[best].law : LAW_UNDECIDED;
    snprintf(
        drag->said, sizeof drag->said,
        "%s: BIC of %s is lower by %.3g than that of %s (%g needed); a second term %s (BIC %+.3g, F-test p = %.1g)",
        drag_law_name(out->preferred), name, over_next, other, DELTA_LEAST,
        !physical                ? "would be negative"
        : drag->p_value < HIDDEN ? "may be there"
                                 : "is not needed",
        -over_single, drag->p_value);
    return best;
}

/* ---- the report ---- */

/* How often the position was differentiated to give such values: the amplitude is that much larger. */
static double growth(enum quantity quantity, double omega)
{
    return quantity == QUANTITY_VELOCITY ? omega : quantity == QUANTITY_ACCELERATION ? omega * omega : 1;
}

static void describe(const struct curve_fit *f, const struct law *law, enum quantity quantity, double factor,
                     struct drag_candidate *out)
{
    double p = f->value[P].value, q = f->value[Q].value, omega = f->value[OMEGA].value, square = p * p + q * q;
    double a = sqrt(square) / growth(quantity, omega); /* of the position */
    struct measured *to[3] = {&out->gamma, &out->quadratic, &out->friction};
    /* k = q/A0 of A' = -k A^2 is 4 b Omega/(3 pi); m = f A0 of A' = -m is 2 F/(pi Omega) */
    const double scale[3] = {1, 3 * PI / (4 * omega), 0.5 * PI * omega}, power[3] = {0, -1, 1};
    for (int k = 0, at = FIRST_RATE; k < 3; k++) {
        *to[k] = (struct measured){0, 0};
        if (!law->has[k])
            continue;
        double g[CURVE_PARAMETERS] = {0}, rate = f->value[at].value, unit = scale[k] * pow(a, power[k]);
        g[at] = unit;
        g[P] = power[k] * rate * unit * p / square;
        g[Q] = power[k] * rate * unit * q / square;
        *to[k] = (struct measured){rate * unit, deviation(f, g, factor)};
        at++;
    }
}

/* The values of a fit that has one law, with the names of the damped sine. */
static void report(const struct curve_fit *f, const struct law *law, double factor, struct fit *out)
{
    double p = f->value[P].value, q = f->value[Q].value, a = hypot(p, q);
    double of_amplitude[CURVE_PARAMETERS] = {p / a, q / a}, of_phase[CURVE_PARAMETERS] = {q / (a * a), -p / (a * a)};
    struct envelope_rates rates =
        rates_of(law, (const double[]){f->value[FIRST_RATE].value,
                                       f->parameters > FIRST_RATE + 1 ? f->value[FIRST_RATE + 1].value : 0});
    out->amplitude = (struct measured){a, deviation(f, of_amplitude, factor)};
    out->phase = (struct measured){atan2(-q, p), deviation(f, of_phase, factor)};
    out->offset = (struct measured){f->value[OFFSET].value, f->value[OFFSET].uncertainty};
    out->omega = (struct measured){f->value[OMEGA].value, fmax(f->value[OMEGA].uncertainty, out->omega.uncertainty)};
    out->period.value = TWO_PI / out->omega.value;
    out->period.uncertainty = out->period.value * out->omega.uncertainty / out->omega.value;
    out->gamma = out->drag.candidate[law - laws].gamma;
    out->quadratic_rate = rates.q;
    out->friction_rate = rates.f;
    out->rms = sqrt(f->rss / (double)f->used);
    out->iterations = f->iterations;
    out->autocorrelation = f->autocorrelation;
}

/* The samples that take part, without the drift of the offset. */
static bool used_samples(const struct samples *x, double drift, struct arena *arena, struct series *used)
{
    double *t = arena_array(arena, x->n, sizeof *t), *y = arena_array(arena, x->n, sizeof *y);
    *used = (struct series){.t = t, .y = y};
    for (size_t i = 0; i < x->n && t && y; i++) {
        if (x->use[i]) {
            t[used->n] = x->uniform ? x->t0 + (double)i * x->dt : x->t[i];
            y[used->n] = x->y[i] - drift * (t[used->n] - x->t0);
            used->n++;
        }
    }
    return t && y;
}

bool drag_laws(const struct motion *m, enum quantity quantity, const struct envelope_rates rates[3],
               struct arena *arena, const struct cancel *cancel, struct fit *out, struct error *error)
{
    static const char *const names[] = {"p", "q", "offset", "omega", "rate 1", "rate 2"};
    const struct curve_options options = {.cancel = cancel};
    const struct harmonic *h = &m->harmonic;
    struct curve_fit fit[DRAG_LAWS];
    struct series used;
    if (!used_samples(&m->samples, h->d, arena, &used))
        return error_memory(error);
    double t0 = m->samples.t0, back = t0 - h->origin, e = exp(-0.5 * h->gamma * back);
    double c = e * cos(h->omega * back), s = e * sin(h->omega * back);
    for (int i = 0; i < DRAG_LAWS; i++) {
        struct drag_curve o = {&laws[i], t0};
        struct fit_curve curve = {FIRST_RATE, names, &o, evaluate};
        /* Dry friction begins with the mean slope of what the linear law gives. */
        const struct envelope_rates r = i < 3 ? rates[i] : (struct envelope_rates){.f = 0.3 * rates[LINEAR].gamma};
        const double rate[3] = {r.gamma, r.q, r.f};
        double start[CURVE_PARAMETERS] = {h->a * c + h->b * s, h->b * c - h->a * s, h->c + h->d * back, h->omega};
        for (int k = 0; k < 3; k++)
            if (laws[i].has[k])
                start[curve.parameters++] = rate[k];
        if (!curve_fit(&curve, &used, start, &options, arena, &fit[i], error))
            return false;
    }
    if (!fit[LINEAR].converged)
        return error_set(error, ERROR_NUMERICAL, "the fit of drag %s", fit[LINEAR].said);
    double n = (double)used.n, a = out->amplitude.value;
    int widest = fit[MIXED].converged ? MIXED : LINEAR;
    double factor = amplitude_factor(&used, t0, &fit[widest]);
    double variance = factor * fmax(fit[widest].sigma * fit[widest].sigma, AVERAGED * a * a);
    out->drag = (struct drag_fit){.candidates = DRAG_LAWS, .independent = fmax(n / factor, 2)};
    int best = choose(fit, variance, out);
    for (int i = 0; i < DRAG_LAWS; i++)
        describe(&fit[i], &laws[i], quantity, factor, &out->drag.candidate[i]);
    for (int i = LINEAR; i <= MIXED; i++)
        out->evidence[i] = out->drag.candidate[i].bic;
    report(&fit[best], &laws[best], factor, out);
    return true;
}
