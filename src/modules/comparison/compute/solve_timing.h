/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Times of solves, with nothing recorded (timing.c).
 *
 * Repeats are chained through the data (a start that depends on the last result), batched until a
 * sample is long enough for the clock, and reported as minimum and median. One warm-up solve is
 * discarded. Nothing is allocated or written in the timed region.
 */
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct buffer;

#define TIMING_SAMPLES 15 /* number of samples of one solve with `timing full` */

/* Processor time of one solve, in seconds; NAN if it was not timed. */
struct timing_result {
    double minimum, median;
    double spread; /* relative difference of the second shortest sample from the shortest */
    /* Mean number of other threads that ran meanwhile. Above TIMING_OTHERS the time may be up to
     * TIMING_CONTENTION times too long: processors share units, caches and memory. */
    double others;
    int samples;
    bool few; /* fewer samples than the protocol of the setting `timing` has */
};

#define TIMING_SPREAD 0.1 /* spread above which a time is flagged and not ranked */

/* Fewest samples that show whether a time can be trusted. */
enum { TIMING_SAMPLES_MIN = 3 };

/* Largest factor by which other threads may change a time, and the mean number of them that is
 * negligible. */
#define TIMING_CONTENTION 2.2
#define TIMING_OTHERS 0.25

/* Appends a line that says how busy the machine was, if more than TIMING_OTHERS threads ran beside
 * the timed one. */
void timing_put_machine(double others, struct buffer *text);

/* Returns true if the time can be trusted: at least TIMING_SAMPLES_MIN samples were taken and the
 * two shortest differ by at most TIMING_SPREAD. */
bool timing_is_sound(const struct timing_result *time);

/* Returns the shortest time per step [ns], or NAN if it was not timed. */
double timing_step_ns(const struct timing_result *time, int64_t steps);
