/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A device's clock that does not go on: it starts again after a reset, wraps round where its
 * counter is full, or a digit of a stamp is garbled on the way. What comes after a new start goes
 * on where the arrivals say; a single stamp that the next ones do not go on from is none. Stamps
 * that rise are as they are.
 */
#include "data/table/table.h"

#include <hooke/base/numeric.h>

#include <math.h>

enum { AHEAD = 5 };  /* stamps that tell a new start from a single wrong one */
#define RISING 0.9   /* of the steps of a clock */
#define GAP 1.5      /* steps: there are lines between */
#define FAR 8        /* steps: it may be garbled, if the next ones say so */
#define EVEN 0.25    /* of the usual step: a device that samples evenly … */
#define EVEN_MIN 0.8 /* … does so for that part of the steps */

/* Where the counters of small boards are full: 16 and 32 bit; microseconds sent as ms and s. */
static const double full[] = {65536, 4294967296, 4294967.296, 4294.967296, 256};

static double usual_step(const double *v, size_t n, double *scratch, bool *rises)
{
    size_t steps = 0, up = 0, all = 0;
    double before = NAN;
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(v[i]))
            continue;
        all += isnan(before) ? 0 : 1;
        up += v[i] >= before ? 1 : 0;
        if (v[i] > before)
            scratch[steps++] = v[i] - before;
        before = v[i];
    }
    *rises = steps > 1 && (double)up >= RISING * (double)all;
    return steps > 0 ? quantile(scratch, steps, 0.5) : NAN;
}

double clock_pace(const struct arrivals *a, const double *v, double *scratch)
{
    bool rises = false;
    const double usual = usual_step(v, a->n, scratch, &rises);
    double counted = 0, passed = 0;
    size_t last = a->n;
    for (size_t i = 0; i < a->n; i++) {
        if (!isfinite(v[i]))
            continue;
        if (last < a->n && v[i] >= v[last] && v[i] - v[last] <= FAR * usual) {
            counted += v[i] - v[last];
            passed += a->arrival[i] - a->arrival[last];
        }
        last = i;
    }
    return passed > 0 ? counted / passed : NAN;
}

/* Do the stamps behind `at` go on from it, rather than from the one before, `was`? */
static bool goes_on_from(const struct arrivals *a, const double *v, size_t at, double was,
                         double usual)
{
    int from_it = 0, from_before = 0, seen = 0;
    for (size_t j = at + 1; j < a->n && seen < AHEAD; j++) {
        if (!isfinite(v[j]))
            continue;
        const double steps = FAR * usual * (a->order[j] - a->order[at] + 1);
        seen++;
        from_it += v[j] >= v[at] && v[j] - v[at] <= steps;
        from_before += v[j] >= was && v[j] - was <= steps;
    }
    return from_it > from_before || (from_it == 0 && from_before == 0 && v[at] > was);
}

/* [count] between the last stamp and the first after a new start. */
static double step_over(double was, double now, double passed, double usual, bool *wrapped)
{
    const double most = fmax(2 * passed, 0) + FAR * usual;
    for (size_t i = 0; i < COUNT_OF(full); i++) {
        const double step = now + full[i] - was;
        if (was < full[i] && now >= 0 && step > 0 && step <= most) {
            *wrapped = true;
            return step;
        }
    }
    return fmax(passed, usual);
}

bool clock_mend(const struct arrivals *a, bool trusted, struct arena *arena, double *v,
                struct clock_mended *mended)
{
    double *scratch = arena_array(arena, a->n + 1, sizeof *scratch), offset = 0, was = NAN;
    *mended = (struct clock_mended){.after = arena_array(arena, a->n + 1, sizeof(bool))};
    if (!scratch || !mended->after)
        return false;
    bool rises = false;
    const double pace = clock_pace(a, v, scratch), usual = usual_step(v, a->n, scratch, &rises);
    size_t last = 0;
    for (size_t i = 0; rises && i < a->n; i++) {
        mended->after[i] = false;
        if (!isfinite(v[i]))
            continue;
        const double now = v[i];
        const bool odd = now < was || now - was > FAR * usual;
        if (odd && !goes_on_from(a, v, i, was, usual)) {
            mended->wrong++;
            v[i] = NAN;
            continue;
        }
        if (now < was && trusted) {
            bool wrapped = false;
            const double passed = pace * (a->arrival[i] - a->arrival[last]);
            offset += was - now + step_over(was, now, passed > 0 ? passed : 0, usual, &wrapped);
            mended->starts += wrapped ? 0 : 1;
            mended->wraps += wrapped ? 1 : 0;
            mended->after[i] = !wrapped;
        }
        was = now;
        last = i;
        v[i] = now + offset;
    }
    return true;
}

size_t clock_lost(const struct arrivals *a, const double *t, const bool *after, double *scratch,
                  bool *known)
{
    size_t lost = 0, even = 0;
    for (size_t i = 0; i + 1 < a->n; i++)
        scratch[i] = t[i + 1] - t[i];
    const double usual = a->n > 1 ? quantile(scratch, a->n - 1, 0.5) : NAN;
    for (size_t i = 0; i + 1 < a->n; i++) {
        const double steps = (t[i + 1] - t[i]) / usual, whole = nearbyint(steps),
                     between = a->order[i + 1] - a->order[i]; /* with those that were garbled */
        even += fabs(steps - whole) < EVEN ? 1 : 0;
        if (steps > GAP && steps < 1e9 && whole > between && !(after && after[i + 1]) &&
            !(a->pause && a->pause[i + 1]))
            lost += (size_t)(whole - between);
    }
    *known = (double)even >= EVEN_MIN * (double)(a->n - 1);
    return *known ? lost : 0;
}
