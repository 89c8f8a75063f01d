/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A few periods of a motion that drag or friction damps: the stated period covers the times between
 * crossings of the motion itself, which is integrated here.
 */

#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/detect_recordings.h"

/* y'' = -omega^2 y - linear v - quadratic |v| v - cubic v^3 - friction omega^2 sign(v) */
struct damping {
    double omega, linear, quadratic, cubic, friction;
};

struct state {
    double y, v;
};

static struct state slope_of(const struct damping *d, struct state s, double sign)
{
    const double v = s.v;
    return (struct state){v, -d->omega * d->omega * (s.y + d->friction * sign) - d->linear * v -
                                 d->quadratic * fabs(v) * v - d->cubic * v * v * v};
}

static struct state moved(struct state s, struct state slope, double h)
{
    return (struct state){s.y + h * slope.y, s.v + h * slope.v};
}

/* Makes one step of the classical method of Runge and Kutta. Friction keeps its sign within it, and
 * holds what comes to rest where the spring cannot move it. */
static struct state step_of(const struct damping *d, struct state s, double h)
{
    const double sign = s.v > 0 ? 1 : -1;
    if (d->friction > 0 && s.v == 0 && fabs(s.y) <= d->friction)
        return s;
    const struct state a = slope_of(d, s, s.v == 0 ? (s.y > 0 ? -1 : 1) : sign),
                       b = slope_of(d, moved(s, a, 0.5 * h), sign),
                       c = slope_of(d, moved(s, b, 0.5 * h), sign),
                       e = slope_of(d, moved(s, c, h), sign);
    struct state next = moved(s, a, h / 6);
    next = moved(moved(moved(next, b, h / 3), c, h / 3), e, h / 6);
    if (d->friction > 0 && next.v * s.v < 0 && fabs(next.y) <= d->friction)
        next.v = 0;
    return next;
}

/* Integrates a recording; low and high [s] are the extremes of the times between its up-crossings.
 */
static struct drawn integrate(const struct damping *damping, double amplitude, double periods,
                              double samples, double *low, double *high)
{
    const double period = 2 * PI / damping->omega, phase = random_between(-PI, PI);
    struct drawn d = draw((size_t)(periods * samples) + 1, samples / period);
    struct state s = {amplitude * cos(phase), -amplitude * damping->omega * sin(phase)};
    const int steps = 10 + (int)(1000 / samples);
    const double h = period / samples / steps;
    double before = NAN;
    *low = HUGE_VAL;
    *high = 0;
    for (size_t i = 0; i < d.n; i++) {
        d.y[i] = s.y;
        for (int k = 0; k < steps; k++) {
            const struct state next = step_of(damping, s, h);
            if (s.y <= 0 && next.y > 0) {
                const double t = d.t[i] + h * (k - s.y / (next.y - s.y));
                *low = fmin(*low, isnan(before) ? *low : t - before);
                *high = fmax(*high, isnan(before) ? *high : t - before);
                before = t;
            }
            s = next;
        }
    }
    return d;
}

enum { LINEAR, QUADRATIC, CUBIC, MIXED, STRONG, FRICTION, DAMPINGS };

/* Draws a damping of a kind that takes about 1 - 1/(1 + loss) of the amplitude in the span. */
static struct damping damping_of(int kind, double omega, double amplitude, double periods,
                                 double loss)
{
    const double span = periods * 2 * PI / omega,
                 quadratic = loss / span * 3 * PI / (4 * omega * amplitude);
    struct damping d = {.omega = omega};
    switch (kind) {
    case LINEAR:
        d.linear = 2 * log(1 + loss) / span;
        break;
    case QUADRATIC:
        d.quadratic = quadratic;
        break;
    case CUBIC:
        d.cubic = ((1 + loss) * (1 + loss) - 1) * 4 / (3 * span * pow(omega * amplitude, 2));
        break;
    case MIXED:
        d.quadratic = 0.5 * quadratic;
        d.linear = log(1 + loss) / span;
        break;
    case STRONG:
        d.quadratic = 3 * quadratic;
        break;
    default:
        d.friction = 0.9 * amplitude / (4 * periods);
    }
    return d;
}

/* How far a period lies outside of the times between crossings, in its uncertainties. */
static double periods_off(const struct period *p, double low, double high)
{
    const double off = fmax(fmax(low - p->period.value, p->period.value - high), 0);
    return off / p->period.uncertainty;
}

TEST(periods_of_a_few_damped_swings)
{
    const int runs = is_long() ? 1200 : 96;
    int within = 0, beyond = 0;
    random_state = 811;
    for (int run = 0; run < runs; run++) {
        const int kind = run % DAMPINGS;
        const double omega = 2 * PI / random_between(0.5, 2), amplitude = random_between(1, 10),
                     periods = random_between(3.2, 7), samples = of_random_size(20, 150),
                     noise = of_random_size(5e-4, 0.03);
        const struct damping damping =
            damping_of(kind, omega, amplitude, periods, random_between(0.3, 4));
        double low, high;
        struct drawn d = integrate(&damping, amplitude, periods, samples, &low, &high);
        /* under friction the crossings move against the turning points, which are 2 pi/omega apart
         */
        low = kind == FRICTION ? 2 * PI / omega : low;
        high = kind == FRICTION ? 2 * PI / omega : high;
        add_noise(&d, noise * amplitude);
        const struct series series = {.t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
        struct period p = {.period = {NAN, NAN}};
        struct arena arena = {0};
        struct error error = {0};
        const bool found = series_period(&series, &arena, &p, &error);
        const double off = found ? periods_off(&p, low, high) : HUGE_VAL;
        within += off <= 3;
        if (off > 3)
            print_message("damping %d, %.3g periods, noise %.2g: T %.8g +- %.2g for %.8g..%.8g, "
                          "%s %s\n",
                          kind, periods, noise, p.period.value, p.period.uncertainty, low, high,
                          p.how, found ? p.warning : error.text);
        beyond += off > 4 && found && !p.warning[0];
        arena_reset(&arena);
        free(d.t);
        free(d.y);
    }
    print_message("%d of %d periods within 3 standard uncertainties\n", within, runs);
    assert_true(100 * within >= 95 * runs);
    assert_true(500 * beyond <= runs);
}

RUN_TESTS(NULL, NULL)
