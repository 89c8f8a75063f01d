/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Mends time stamps of a device's clock that go back: the clock starts again after a reset,
 * overflows when its counter is full, or a digit of a stamp is garbled. After a new start the times
 * continue as the arrivals tell; a single stamp from which the next ones do not continue is
 * dropped. Rising stamps are unchanged. */
#include "modules/collect/lines.h"

#include <hooke/base/numeric.h>

#include <math.h>

/* A counter that overflows after fewer steps is not taken for a clock. */
enum { WRAP_STEPS_MIN = 64 };
/* whole periods after which a sawtooth is taken for a signal and not for a clock */
enum { SAWTOOTH_CYCLES = 4 };
enum { AHEAD = 5 }; /* stamps after which a new start is distinguished from a single wrong stamp */
/* Fraction of steps that must rise: in a column known to be a clock, and in a column whose meaning
 * is unknown. */
#define RISING_KNOWN 0.6
#define RISING_UNNAMED 0.9
/* [usual steps] a longer time between two lines means that lines are missing */
#define GAP_STEPS 1.5
#define GARBLED_STEPS 8 /* [usual steps] a stamp farther off may be garbled */
/* [usual steps] deviation from a whole number of steps that an even clock may have */
#define EVEN_STEP_TOLERANCE 0.25
#define EVEN_MIN 0.8 /* fraction of the steps that must be even */

/* Values at which the counters of small boards overflow: 16 and 32 bit; microseconds sent as ms
 * and s. */
static const double full[] = {65536, 4294967296, 4294967.296, 4294.967296, 256};

/* Steps between the stamps of a column. */
struct clock_steps {
    double usual; /* median of the steps that rise, or NAN if none does */
    /* numbers of steps that rise, that go back, and of all steps */
    size_t rises, back, all;
    bool whole; /* all stamps are whole numbers */
};

/* Counts the steps between the stamps v [n]; unknown ones (NAN) are skipped. scratch is [n]. */
static struct clock_steps clock_steps_count(const double *v, size_t n, double *scratch)
{
    struct clock_steps steps = {.usual = NAN, .whole = true};
    size_t rising = 0;
    double previous = NAN;
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(v[i]))
            continue;
        steps.all += isnan(previous) ? 0 : 1;
        steps.rises += v[i] >= previous ? 1 : 0;
        steps.back += v[i] < previous ? 1 : 0;
        steps.whole = steps.whole && v[i] == floor(v[i]);
        if (v[i] > previous)
            scratch[rising++] = v[i] - previous;
        previous = v[i];
    }
    if (rising > 0)
        steps.usual = values_quantile(scratch, rising, 0.5);
    return steps;
}

/* Returns the rate of the clock [count/s], from steps that rise by plausible amounts. */
double clock_pace(const struct arrivals *a, const double *v, double *scratch)
{
    const double usual = clock_steps_count(v, a->n, scratch).usual;
    double counted = 0, passed = 0;
    size_t last = a->n;
    for (size_t i = 0; i < a->n; i++) {
        if (!isfinite(v[i]))
            continue;
        if (last < a->n && v[i] >= v[last] && v[i] - v[last] <= GARBLED_STEPS * usual) {
            counted += v[i] - v[last];
            passed += a->arrival[i] - a->arrival[last];
        }
        last = i;
    }
    return passed > 0 ? counted / passed : NAN;
}

/* Returns true if the stamps behind `index` continue from its stamp rather than from the stamp
 * `was` at `last`. If both are possible the nearer prediction counts. In the very last line a new
 * start is recognized by its value, which is 0 or the first one. */
static bool continues_from(const struct arrivals *a, const double *v, size_t index, size_t last,
                           double was, double usual)
{
    int from_it = 0, from_before = 0, seen = 0;
    for (size_t j = index + 1; j < a->n && seen < AHEAD; j++) {
        if (!isfinite(v[j]))
            continue;
        const double lines = a->order[j] - a->order[index],
                     most = GARBLED_STEPS * usual * (lines + 1), since_it = v[j] - v[index],
                     since_before = v[j] - was;
        const bool after_it = since_it >= 0 && since_it <= most,
                   after_before = since_before >= 0 && since_before <= most;
        const double miss = fabs(since_it - usual * lines),
                     miss_before = fabs(since_before - usual * (a->order[j] - a->order[last]));
        seen++;
        from_it += after_it && (!after_before || miss < miss_before);
        from_before += after_before && (!after_it || miss_before < miss);
    }
    if (seen == 0)
        return v[index] == 0 || v[index] == v[0] || v[index] > was;
    return from_it > from_before || (from_it == from_before && v[index] > was);
}

/* Returns the step [count] from the last stamp `was` to the first stamp `now` after a restart:
 * across the overflow of a counter (*wrapped is set) if one explains it, else the time that passed
 * by the arrivals [count]. */
static double step_across_restart(double was, double now, double passed,
                                  const struct clock_steps *steps, bool *wrapped)
{
    const double most = fmax(2 * passed, 0) + GARBLED_STEPS * steps->usual;
    for (size_t i = 0; i < COUNT_OF(full); i++) {
        const double step = now + full[i] - was;
        const bool possible = full[i] >= WRAP_STEPS_MIN * steps->usual &&
                              (!steps->whole || full[i] == floor(full[i]));
        if (possible && was < full[i] && now >= 0 && step > 0 && step <= most) {
            *wrapped = true;
            return step;
        }
    }
    const double step = fmax(passed, steps->usual);
    return steps->whole ? nearbyint(step) : step;
}

/* Returns true if the column v [n] is a periodic signal rather than a clock: it falls back
 * regularly, after equal numbers of lines and to nearly equal values, in at least SAWTOOTH_CYCLES
 * cycles. Counters that overflow do so, too, but count as clocks; they are recognized by the size
 * of the fall. `steps` holds the usual step of the column. */
static bool is_sawtooth(const double *v, size_t n, const struct clock_steps *steps)
{
    size_t begun = 0, first = 0, shortest = n, longest = 0, cycles = 0;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 1; i < n; i++) {
        bool wrapped = false;
        if (!(v[i] < v[i - 1]))
            continue;
        step_across_restart(v[i - 1], v[i], 0, steps, &wrapped);
        if (wrapped)
            return false;
        low = fmin(low, v[i]);
        high = fmax(high, v[i]);
        if (begun > 0) {
            cycles++;
            shortest = i - begun < shortest ? i - begun : shortest;
            longest = i - begun > longest ? i - begun : longest;
        } else {
            first = i;
        }
        begun = i;
    }
    return cycles >= SAWTOOTH_CYCLES && longest - shortest <= 1 && first <= longest &&
           n - begun <= longest && high - low <= steps->usual;
}

/* Returns true if the usual step is the step nearly everywhere. */
static bool steps_are_even(const double *v, size_t n, const struct clock_steps *steps)
{
    size_t even = 0;
    for (size_t i = 1; i < n; i++)
        even += fabs(v[i] - v[i - 1] - steps->usual) <= 0.5 * steps->usual ? 1 : 0;
    return (double)even >= RISING_UNNAMED * (double)steps->rises;
}

/* Repairs the time stamps v [n], n = a->n, in place: single wrong ones become NAN, and after a
 * restart or an overflow of the clock an offset makes the times continue. `trusted` means that v is
 * known to be a clock; otherwise the column must look like one before steps back are repaired.
 * *mended counts the repairs and flags restarts per line (in the arena). Returns false if out of
 * memory. */
bool clock_mend(const struct arrivals *a, bool trusted, struct arena *arena, double *v,
                struct clock_mended *mended)
{
    double *scratch = arena_array(arena, a->n + 1, sizeof *scratch), offset = 0, was = NAN;
    *mended = (struct clock_mended){.is_restart = arena_array(arena, a->n + 1, sizeof(bool))};
    if (!scratch || !mended->is_restart)
        return false;
    const double pace = clock_pace(a, v, scratch);
    const struct clock_steps steps = clock_steps_count(v, a->n, scratch);
    const double usual = steps.usual, rise_count = (double)steps.rises, all = (double)steps.all;
    const bool one_start = steps.back == 1 && steps.rises > 2 && steps_are_even(v, a->n, &steps),
               rises = steps.rises > 1 && (rise_count >= RISING_UNNAMED * all || one_start ||
                                           (trusted && rise_count >= RISING_KNOWN * all));
    const bool is_clock = rises && (trusted || !is_sawtooth(v, a->n, &steps));
    size_t last = 0;
    for (size_t i = 0; rises && i < a->n; i++) {
        mended->is_restart[i] = false;
        if (!isfinite(v[i]))
            continue;
        const double now = v[i];
        const bool odd = now < was || now - was > GARBLED_STEPS * usual;
        if (odd && !continues_from(a, v, i, last, was, usual)) {
            mended->wrong++;
            v[i] = NAN;
            continue;
        }
        if (now < was && is_clock) {
            bool wrapped = false;
            const double passed = pace * (a->arrival[i] - a->arrival[last]);
            offset += was - now +
                      step_across_restart(was, now, passed > 0 ? passed : 0, &steps, &wrapped);
            mended->starts += wrapped ? 0 : 1;
            mended->wraps += wrapped ? 1 : 0;
            mended->is_restart[i] = !wrapped;
        }
        was = now;
        last = i;
        v[i] = now + offset;
    }
    return true;
}

/* Counts the lines lost between times that rise: gaps of several usual steps, less the lines that
 * came, except at restarts and pauses. Sets *known to false, and returns 0, if steps are uneven. */
size_t clock_lost(const struct arrivals *a, const double *t, const bool *is_restart,
                  double *scratch, bool *known)
{
    size_t lost = 0, even = 0;
    for (size_t i = 0; i + 1 < a->n; i++)
        scratch[i] = t[i + 1] - t[i];
    const double usual = a->n > 1 ? values_quantile(scratch, a->n - 1, 0.5) : NAN;
    for (size_t i = 0; i + 1 < a->n; i++) {
        const double steps = (t[i + 1] - t[i]) / usual, whole = nearbyint(steps),
                     /* number of lines that came, garbled ones included */
            received = a->order[i + 1] - a->order[i];
        even += fabs(steps - whole) < EVEN_STEP_TOLERANCE ? 1 : 0;
        if (steps > GAP_STEPS && steps < 1e9 && whole > received &&
            !(is_restart && is_restart[i + 1]) && !(a->pause && a->pause[i + 1]))
            lost += (size_t)(whole - received);
    }
    *known = (double)even >= EVEN_MIN * (double)(a->n - 1);
    return *known ? lost : 0;
}
