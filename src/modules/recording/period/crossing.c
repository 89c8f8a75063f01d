/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Crossings of a level, placed by interpolation or by local fits. */
#include "modules/recording/series/internal.h"

#include <hooke/scene.h>

#include <float.h>
#include <math.h>

/* [periods] Half width of the window whose samples place a crossing. */
#define HALF_WIDTH 0.1
/* Change of the wave's shape within the window by decay and drift, relative to the swing. */
#define SHAPE_CHANGE_FRACTION 0.01
/* Noise relative to the amplitude below which interpolation is better than averaging. */
#define NOISE_FREE 1e-6

/* The series and the settings for all its crossings. */
struct context {
    const struct series *series;
    double level, mean, noise;
    double omega; /* [rad/s] frequency, 0 if unknown */
    double half;  /* [s] half width of the window around a crossing */
    bool exact;   /* the series has no noise */
};

bool overview_is_exact(const struct overview *o)
{
    return o->noise <= NOISE_FREE * 0.5 * (o->high - o->low);
}

/* Returns the value at t of the polynomial through the `count` (at most 6) samples from `first` on
 * (Neville's algorithm). */
static double interpolate(const struct series *s, size_t first, size_t count, double t)
{
    double p[6] = {0};
    for (size_t i = 0; i < count; i++) {
        p[i] = s->y[first + i];
    }
    for (size_t k = 1; k < count; k++) {
        for (size_t i = 0; i + k < count; i++) {
            double a = s->t[first + i], b = s->t[first + i + k];
            p[i] = ((t - b) * p[i] + (a - t) * p[i + 1]) / (a - b);
        }
    }
    return p[0];
}

/* Context of above_level(): the samples of the polynomial. */
struct polynomial {
    const struct context *context;
    size_t first, count;
};

/* Returns by how much the polynomial exceeds the level at t. */
static double above_level(void *context, double t)
{
    const struct polynomial *p = context;
    return interpolate(p->context->series, p->first, p->count, t) - p->context->level;
}

/* Places a crossing without noise: the root between samples i - 1 and i of the quintic through the
 * six samples around them. Returns false if there is none. */
static bool place_exact(const struct context *c, size_t i, struct crossing *crossing)
{
    const struct series *s = c->series;
    const size_t count = s->n < 6 ? s->n : 6;
    const size_t first = i < 3 ? 0 : i - 3;
    struct polynomial p = {c, first + count > s->n ? s->n - count : first, count};
    const double a = s->t[i - 1], b = s->t[i], fa = s->y[i - 1] - c->level, fb = s->y[i] - c->level;
    crossing->t =
        root_between(above_level, &p, a, fa, b, fb, 4 * DBL_EPSILON * fmax(fabs(a), fabs(b)));
    crossing->uncertainty = fabs(c->noise / ((fb - fa) / (b - a)));
    return isfinite(crossing->t);
}

/* Places a crossing in noise near `centre` [s]: fits y - mean = p cos(omega s) + q sin(omega
 * s)/omega, s = t - centre, to the samples within c->half, and moves to its crossing. Such a line
 * is curved like a sine (a plain line if omega is unknown), so that the window may be wide. The
 * later passes leave out samples five sigma off (missed echoes). Returns false if there are too
 * few. */
static bool place_fit(const struct context *c, double centre, struct crossing *crossing)
{
    const struct series *s = c->series;
    double p = 0, q = 0, target = c->level - c->mean;
    bool fitted = false;
    for (int pass = 0; pass < 4; pass++) {
        struct samples all = {.t = s->t, .n = s->n};
        size_t first = samples_index(&all, centre - c->half), used = 0;
        double cc = 0, cs = 0, ss = 0, cy = 0, sy = 0;
        for (size_t i = first; i < s->n && s->t[i] <= centre + c->half; i++) {
            double x = s->t[i] - centre, u = cos(c->omega * x),
                   v = c->omega > 0 ? sin(c->omega * x) / c->omega : x;
            double y = s->y[i] - c->mean;
            if (fitted && pass > 1 &&
                fabs(y - p * u - q * v) >
                    5 * c->noise + SHAPE_CHANGE_FRACTION * fabs(q) * c->half) {
                continue;
            }
            cc += u * u;
            cs += u * v;
            ss += v * v;
            cy += u * y;
            sy += v * y;
            used++;
        }
        double det = cc * ss - cs * cs;
        if (used < 3 || !(det > 1e-12 * cc * ss)) {
            return false;
        }
        p = (ss * cy - cs * sy) / det;
        q = (cc * sy - cs * cy) / det;
        double x = 0;
        for (int k = 0; k < 5; k++) {
            double u = cos(c->omega * x), v = c->omega > 0 ? sin(c->omega * x) / c->omega : x;
            x -= (p * u + q * v - target) / (q * u - p * c->omega * c->omega * v);
        }
        if (!(fabs(x) <= c->half)) {
            return false;
        }
        centre += x;
        crossing->uncertainty = c->noise * sqrt(ss / det) / fabs(q);
        /* p and q at the new centre: the value there is the target, the slope is computed. */
        double slope = q * cos(c->omega * x) - p * c->omega * sin(c->omega * x);
        p = target;
        q = slope;
        fitted = true;
    }
    crossing->t = centre;
    return true;
}

/* Finds the crossings of `level` by changes of side beyond the hysteresis, and places each by
 * interpolation or fit. Stores up to `capacity` of them in result, and returns the number found. */
size_t series_crossings(const struct series *s, const struct overview *o, double level,
                        struct crossing *result, size_t capacity)
{
    double amplitude = 0.5 * (o->high - o->low), hysteresis = fmax(4 * o->noise, 0.05 * amplitude);
    struct context c = {.series = s, .level = level, .mean = level, .noise = o->noise};
    if (s->n < 4 || !(amplitude > 0)) {
        return 0;
    }
    double dt = (s->t[s->n - 1] - s->t[0]) / (double)(s->n - 1);
    c.exact = o->noise <= NOISE_FREE * amplitude;
    c.half = 5 * dt;
    if (o->oscillates) {
        c.omega = TWO_PI / o->period;
        c.mean = o->mean;
        c.half = fmax(HALF_WIDTH * o->period, 2 * dt);
    }
    size_t count = 0, last_clear = 0; /* `last_clear` is the last sample clearly on the old side */
    int side = 0;
    for (size_t i = 0; i < s->n; i++) {
        double deviation = s->y[i] - level;
        const int now = level_side(deviation, hysteresis);
        if (now == 0) {
            continue;
        }
        if (side == -now) {
            /* Noise may cross the level several times in between: start from the middle of first
             * and last. */
            size_t first = 0, last = 0;
            for (size_t k = last_clear + 1; k <= i; k++) {
                if ((s->y[k] >= level) != (s->y[k - 1] >= level)) {
                    first = first ? first : k;
                    last = k;
                }
            }
            struct crossing crossing = {.rising = now > 0};
            double centre = 0.25 * (s->t[first - 1] + s->t[first] + s->t[last - 1] + s->t[last]);
            if (c.exact ? place_exact(&c, last, &crossing) : place_fit(&c, centre, &crossing)) {
                if (count < capacity) {
                    result[count] = crossing;
                }
                count++;
            }
        }
        side = now;
        last_clear = i;
    }
    return count;
}
