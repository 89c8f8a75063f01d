/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One sine whose envelope is an exponential times a polynomial: the period of a few swings that
 * drag or friction damps by another law than the exponential.
 */
#include "analysis/period/cycle.h"
#include "analysis/period/track.h"

#include <math.h>
#include <string.h>

enum {
    OFFSET,
    DRIFT,
    PHASE,
    OMEGA,
    ENVELOPE, /* the first coefficient of the polynomial */
    POWERS_MAX = 4,
    UNKNOWNS = ENVELOPE + POWERS_MAX + 1,
    WIDTH = UNKNOWNS + 1, /* row of the normal equations; the last one belongs to the residual */
    ROWS_MAX = 2048,      /* more rows are averaged */
    PASSES = 8,
};

/* y = offset + drift u + exp(-gamma half u/2) P(u) cos(phase + omega u), u = (t - origin)/half. */
struct bent_sine {
    double origin, half, gamma; /* [s], [s], [1/s] */
    double x[UNKNOWNS];
    int unknowns;
    double omega_sigma, phase_step; /* standard uncertainty of omega, and how far it moved last */
};

/* Returns the value at a time and sets the derivatives. */
static double bent_value(const struct bent_sine *b, double t, double derivative[UNKNOWNS])
{
    const double u = (t - b->origin) / b->half, angle = b->x[PHASE] + b->x[OMEGA] * u,
                 e = exp(-0.5 * b->gamma * b->half * u), c = e * cos(angle);
    double envelope = 0, power = 1;
    for (int k = ENVELOPE; k < b->unknowns; k++, power *= u) {
        envelope += b->x[k] * power;
        derivative[k] = power * c;
    }
    derivative[OFFSET] = 1;
    derivative[DRIFT] = u;
    derivative[PHASE] = -envelope * e * sin(angle);
    derivative[OMEGA] = u * derivative[PHASE];
    return b->x[OFFSET] + b->x[DRIFT] * u + envelope * c;
}

/* Makes one step of Gauss and Newton. Returns false if the rows do not determine the parameters. */
static bool improve_bent_sine(const struct series *rows, struct bent_sine *b)
{
    static const double independent = 1e-10;
    double a[WIDTH * WIDTH] = {0}, step[UNKNOWNS], unit[UNKNOWNS] = {0}, d[UNKNOWNS], square = 0,
                     product = 0, before = 0;
    const int n = b->unknowns;
    for (size_t i = 0; i < rows->n; i++) {
        const double r = rows->y[i] - bent_value(b, rows->t[i], d);
        square += r * r;
        product += r * before;
        before = r;
        for (int j = 0; j < n; j++) {
            for (int k = 0; k <= j; k++)
                a[WIDTH * j + k] += d[j] * d[k];
            a[WIDTH * n + j] += d[j] * r;
        }
    }
    if (!cholesky(n, WIDTH, a, independent, a))
        return false;
    for (int j = 0; j < n; j++)
        step[j] = a[WIDTH * n + j];
    unit[OMEGA] = 1;
    cholesky_forward(n, WIDTH, a, step);
    cholesky_backward(n, WIDTH, a, step);
    cholesky_forward(n, WIDTH, a, unit);
    double inverse = 0;
    for (int j = 0; j < n; j++) {
        b->x[j] += step[j];
        inverse += unit[j] * unit[j];
    }
    b->phase_step = hypot(step[PHASE], step[OMEGA]);
    const double widen = square > 0 ? autocorrelation_factor(product / square) : 1;
    b->omega_sigma = sqrt(widen * square / (double)(rows->n - (size_t)n) * inverse);
    return b->x[OMEGA] > 0;
}

/* Fits an envelope of a degree, from a damped sine on. Returns false if it does not converge. */
static bool fit_bent_sine(const struct motion *m, const struct series *rows, int powers,
                          struct bent_sine *b)
{
    static const double converged = 1e-6; /* [rad] */
    const struct harmonic *h = &m->harmonic;
    const double first = rows->t[0], last = rows->t[rows->n - 1], origin = 0.5 * (first + last),
                 s = origin - h->origin, turn = h->omega * s, e = exp(-0.5 * h->gamma * s);
    *b = (struct bent_sine){.origin = origin,
                            .half = 0.5 * (last - first),
                            .gamma = h->gamma,
                            .unknowns = ENVELOPE + 1 + powers};
    b->x[OFFSET] = h->c + h->d * s;
    b->x[DRIFT] = h->d * b->half;
    b->x[PHASE] = turn - atan2(h->b, h->a);
    b->x[OMEGA] = h->omega * b->half;
    b->x[ENVELOPE] = e * hypot(h->a, h->b);
    b->phase_step = HUGE_VAL;
    for (int pass = 0; pass < PASSES && b->phase_step > converged; pass++)
        if (!improve_bent_sine(rows, b))
            return false;
    return b->phase_step <= converged;
}

static bool bent_sine_period(const struct motion *m, struct arena *arena, struct measured *period)
{
    struct series rows;
    struct bent_sine simple, bent;
    if (!samples_average(&m->samples, m->samples.n / ROWS_MAX + 1, arena, &rows) ||
        rows.n < 2 * UNKNOWNS || !fit_bent_sine(m, &rows, POWERS_MAX - 1, &simple) ||
        !fit_bent_sine(m, &rows, POWERS_MAX, &bent))
        return false;
    period->value = TWO_PI * bent.half / bent.x[OMEGA];
    period->uncertainty =
        period->value / bent.x[OMEGA] * hypot(bent.omega_sigma, bent.x[OMEGA] - simple.x[OMEGA]);
    return true;
}

/* ---- what the envelope leaves open ---- */

bool motion_is_decaying(const struct motion *m)
{
    static const double left_max = 0.04; /* power that the fit may leave, as a share */
    static const double decay_min = 0.1; /* least change of ln A */
    const struct harmonic *h = &m->harmonic;
    const double span = m->samples.t[m->samples.n - 1] - m->samples.t[0];
    double power = 0;
    if (!h->converged || !(0.5 * fabs(h->gamma) * span > decay_min))
        return false;
    for (size_t i = 0; i < m->samples.n; i++)
        power += m->samples.use[i] * (m->samples.y[i] - h->c) * (m->samples.y[i] - h->c);
    return h->rss < left_max * power;
}

/* The uncertainty of a period whose envelope is not exponential [s]. */
struct envelope_doubt {
    double halves; /* half the difference of the periods of both halves, where it is no chance */
    double late;   /* the delay of the end against the start that friction may cause */
};

/* Finds what the damped sines of the two halves of a series say of one period for the whole. */
static struct envelope_doubt envelope_doubt(const struct motion *m)
{
    struct measured half[2], rate[2];
    for (size_t i = 0; i < 2; i++) {
        const size_t n = m->samples.n;
        const struct samples part = samples_part(&m->samples, i * (n / 2), i ? n : n / 2);
        struct harmonic h = {.omega = m->harmonic.omega, .gamma = m->harmonic.gamma};
        h.origin = 0.5 * (part.t[0] + part.t[part.n - 1]);
        if (!harmonic_fit(&part, FREE_GAMMA, &h, m->scratch) || !h.converged)
            return (struct envelope_doubt){0, 0};
        const double sigma = harmonic_sigma(&h, FREE_GAMMA);
        half[i] = (struct measured){TWO_PI / h.omega, TWO_PI / (h.omega * h.omega) * sigma *
                                                          sqrt(h.inverse[RATE_OMEGA][RATE_OMEGA])};
        rate[i] =
            (struct measured){0.5 * h.gamma, 0.5 * sigma * sqrt(h.inverse[RATE_GAMMA][RATE_GAMMA])};
    }
    const double difference = fabs(half[0].value - half[1].value),
                 rise = rate[1].value - rate[0].value;
    struct envelope_doubt doubt = {0, 0};
    if (difference > HALVES_DIFFER * hypot(half[0].uncertainty, half[1].uncertainty))
        doubt.halves = 0.5 * difference;
    if (rise > HALVES_DIFFER * hypot(rate[0].uncertainty, rate[1].uncertainty)) {
        const double span = m->samples.t[m->samples.n - 1] - m->samples.t[0];
        doubt.late = friction_delay(2 * rise, m->harmonic.omega, span) * m->overview.period;
    }
    return doubt;
}

void period_widen_by_envelope(const struct motion *m, bool is_poor, struct arena *arena,
                              struct period *period)
{
    static const double same_period = 0.05, contradicts = 3;
    if (!m->overview.oscillates ||
        !(fabs(period->period.value * m->harmonic.omega / TWO_PI - 1) < same_period))
        return;
    const bool decays = motion_is_decaying(m), phases = strcmp(period->how, "phases") == 0;
    if (!decays && strcmp(period->how, "one damped sine") != 0)
        return;
    const struct envelope_doubt doubt = envelope_doubt(m);
    struct measured bent;
    period->period.uncertainty = fmax(period->period.uncertainty, doubt.halves);
    if (decays && !m->tracked && (doubt.halves > 0 || is_poor) &&
        bent_sine_period(m, arena, &bent)) {
        const double off = fabs(bent.value - period->period.value);
        if (!phases && bent.uncertainty < period->period.uncertainty)
            period->period = bent;
        else if (off > contradicts * bent.uncertainty)
            period->period.uncertainty = hypot(period->period.uncertainty, off);
    }
    period_widen_by_friction(period, doubt.late);
}
