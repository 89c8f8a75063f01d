/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Chooses the ticks of axes and writes their labels. The positions follow Talbot, Lin, Hanrahan, An
 * Extension of Wilkinson's Algorithm for Positioning Tick Labels on Axes (2010), restricted to
 * labels that are multiples of their step (skip j = 1) and that fill the range, so that the search
 * is over steps only. The data range is scaled to the magnitude 1 first, so that 1e-300 and 1e300
 * need no special cases. */
#include "figure/internal.h"

#include <stdio.h>
#include <string.h>

/* First digits of steps, the most readable first (Q in the paper). */
static const double nice[] = {1, 5, 2, 2.5, 4, 3};

static double square(double x)
{
    return x * x;
}

/* Returns the score of `count` labels over [low, high] for data over [a, b], larger is better: 0.25
 * simplicity + 0.2 coverage + 0.5 density + 0.05 legibility (section 4 of the paper). q is the
 * index of the step's first digit in nice[]. */
static double tick_score(size_t q, double low, double high, int count, double a, double b, int want)
{
    double zero = low <= 0 && high >= 0 ? 1 : 0;
    double simplicity = zero - (double)q / (double)(COUNT_OF(nice) - 1);
    /* a single label is taken only where there is no room for two */
    if (count < 2)
        return simplicity - 100;
    double coverage = 1 - 0.5 * (square(b - high) + square(a - low)) / square(0.1 * (b - a));
    double have = (count - 1) / (high - low);
    double wish = (want > 1 ? want - 1 : 1) / (fmax(high, b) - fmin(low, a));
    double density = 2 - fmax(have / wish, wish / have);
    double legibility = nice[q] == 2.5 ? 0 : 1; /* one more digit to read */
    return 0.25 * simplicity + 0.2 * coverage + 0.5 * density + 0.05 * legibility;
}

/* Tries steps of about the range's magnitude, with labels inside of the range or (loose) just
 * outside, and returns the ticks of the best score; count is 0 if no labels are possible. */
struct ticks ticks_search(double range_begin, double range_end, int want, int max, bool loose)
{
    struct ticks ticks = {0};
    double largest = fmax(fabs(range_begin), fabs(range_end));

    if (!(range_begin < range_end) || !isfinite(largest) || largest < 1e-300)
        return ticks;
    int magnitude = (int)floor(log10(largest) + 1e-12);
    int exponent = magnitude >= 5 || magnitude <= -4 ? 3 * (int)floor(magnitude / 3.0) : 0;
    double scale = pow(10, magnitude), a = range_begin / scale, b = range_end / scale;
    double best = -INFINITY;

    if (!(b - a > 1e-14))
        return ticks;
    int power = (int)floor(log10(b - a));
    for (int z = power - 2; z <= power + 1; z++) {
        for (size_t q = 0; q < COUNT_OF(nice); q++) {
            double step = nice[q] * pow(10, z);
            for (int ends = 0; ends < (loose ? 4 : 1);
                 ends++) { /* bit 0: a label below a, bit 1: one above b */
                double first = ends & 1 ? floor(a / step) : ceil(a / step - 1e-9);
                double last = ends & 2 ? ceil(b / step) : floor(b / step + 1e-9);
                if (last < first || last - first >= max)
                    continue;
                int count = (int)(last - first) + 1;
                double score = tick_score(q, first * step, last * step, count, a, b, want);
                if (score <= best)
                    continue;
                /* power of ten of the step's first digit, as labelled */
                int digit = z + magnitude - exponent;
                int decimals = (nice[q] == 2.5 ? 1 : 0) - digit;
                best = score;
                ticks = (struct ticks){.first = first * step * scale,
                                       .step = step * scale,
                                       .count = count,
                                       .decimals = decimals > 0 ? decimals : 0,
                                       .exponent = exponent};
            }
        }
    }
    return ticks;
}

#define LABEL_DIGITS_MAX 5 /* digits of a label above which an offset is split off */

/* Returns the exponent of the largest power of ten that is at most x; the allowance is for rounding
 * of log10. */
static int decimal_exponent(double x)
{
    return (int)floor(log10(x) + 1e-9);
}

/* Splits a common offset off the labels if the range is so narrow that labels would need more than
 * LABEL_DIGITS_MAX digits. The offset is rounded down to a power of ten about the length of the
 * range, so that no label is negative. Sets offset, offset_power and offset_decimals (format of the
 * offset) and exponent and decimals (format of the remaining labels); otherwise changes nothing. */
static void ticks_split_offset(struct ticks *ticks)
{
    double last = ticks->first + (ticks->count - 1) * ticks->step,
           largest = fmax(fabs(ticks->first), fabs(last));
    if (ticks->count < 2 ||
        decimal_exponent(largest) - decimal_exponent(ticks->step) < LABEL_DIGITS_MAX)
        return;
    int power = decimal_exponent(last - ticks->first), digit = decimal_exponent(ticks->step);
    double unit = pow(10, power);
    double units = ticks->first / unit;
    ticks->offset = floor(units + fmax(1e-9, 1e-15 * fabs(units))) * unit;
    if (ticks->offset == 0)
        return;
    ticks->offset_power =
        largest < 1e-3 || largest > 1e9 ? decimal_exponent(fabs(ticks->offset)) : 0;
    power -= ticks->offset_power;
    ticks->offset_decimals = power < 0 ? -power : 0;
    power += ticks->offset_power;
    ticks->exponent = digit < -2 || power >= LABEL_DIGITS_MAX ? digit : 0;
    double digits = ticks->step / pow(10, ticks->exponent);
    for (ticks->decimals = 0; ticks->decimals < 12 && fabs(digits - nearbyint(digits)) > 1e-6;
         digits *= 10)
        ticks->decimals++;
}

/* Returns the number of parts into which ticks without labels divide a step, so that they are round
 * numbers. */
int tick_parts(const struct ticks *ticks)
{
    const double digit = ticks->step > 0 ? ticks->step / pow(10, decimal_exponent(ticks->step)) : 0;
    if (digit > 2.6 && digit < 3.4)
        return 3;
    return (digit > 1.6 && digit < 2.4) || (digit > 3.6 && digit < 4.4) ? 4 : 5;
}

/* Returns at most `max` ticks inside of the range, about `want`, with an offset where labels would
 * be long. */
struct ticks ticks_linear(double range_begin, double range_end, int want, int max)
{
    struct ticks ticks = ticks_search(range_begin, range_end, want, max, false);
    ticks_split_offset(&ticks);
    return ticks;
}

/* Returns ticks at powers of ten inside of the range, at every decade or at every 2nd, 3rd, 5th ...
 * until at most `max` remain. */
struct ticks ticks_log(double range_begin, double range_end, int max)
{
    static const int steps[] = {1, 2, 3, 5, 10, 20, 50, 100, 200, 500};

    if (!(range_begin > 0 && range_begin < range_end) || !isfinite(range_end))
        return (struct ticks){0};
    double low = log10(range_begin) - 1e-9, high = log10(range_end) + 1e-9;
    for (size_t i = 0; i < COUNT_OF(steps); i++) {
        double first = ceil(low / steps[i]), last = floor(high / steps[i]);
        if (last >= first && last - first < max)
            return (struct ticks){
                .first = first * steps[i], .step = steps[i], .count = (int)(last - first) + 1};
    }
    return (struct ticks){0};
}

double tick_value(const struct ticks *ticks, int i, bool log)
{
    double value = ticks->first + i * ticks->step;
    if (log)
        return pow(10, value);
    return fabs(value) < 1e-6 * ticks->step ? 0 : value;
}

/* Writes a number with a fixed number of decimals, through an integer, because printf's %f would
 * follow the locale. Returns its length. */
static int decimal_text(double value, int decimals, char output[TICK_TEXT_SIZE])
{
    long long unit = 1;
    for (int d = 0; d < decimals; d++)
        unit *= 10;
    long long digits = llround(fabs(value) * (double)unit);
    const char *sign = value < 0 && digits ? "-" : "";
    if (!decimals)
        return snprintf(output, TICK_TEXT_SIZE, "%s%lld", sign, digits);
    return snprintf(output, TICK_TEXT_SIZE, "%s%lld.%0*lld", sign, digits / unit, decimals,
                    digits % unit);
}

/* Writes the offset of an axis as a title shows it, such as "- 2.2326" or "+ 1.5e-9". Returns its
 * length. */
int offset_text(const struct ticks *ticks, char output[TICK_TEXT_SIZE])
{
    char text[TICK_TEXT_SIZE];
    const int power = ticks->offset_power;
    int length = decimal_text(fabs(ticks->offset) / pow(10, power), ticks->offset_decimals, text);
    /* A mantissa needs no trailing zeros. */
    while (power != 0 && strchr(text, '.') && strchr("0.", text[length - 1])) {
        const bool point = text[--length] == '.';
        text[length] = '\0';
        if (point)
            break;
    }
    if (power != 0)
        snprintf(text + length, sizeof text - (size_t)length, "e%d", power);
    return snprintf(output, TICK_TEXT_SIZE, "%c %.*s", ticks->offset < 0 ? '+' : '-',
                    TICK_TEXT_SIZE - 3, text);
}

/* Writes the label of tick i, without the offset and in units of the axis's power of ten. Returns
 * its length. */
int tick_text(const struct ticks *ticks, int i, bool log, char output[TICK_TEXT_SIZE])
{
    double value = (tick_value(ticks, i, log) - ticks->offset) / pow(10, ticks->exponent);
    int decimals = ticks->decimals;

    if (log) {
        int power = (int)lround(ticks->first + i * ticks->step);
        double last = ticks->first + (ticks->count - 1) * ticks->step;
        if (ticks->first < -3 || last > 4) /* one form for all labels of an axis */
            return snprintf(output, TICK_TEXT_SIZE, "1e%d", power);
        decimals = power < 0 ? -power : 0;
    }
    return decimal_text(value, decimals, output);
}
