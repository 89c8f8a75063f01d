/* SPDX-License-Identifier: GPL-3.0-or-later */
/* State of the collection in progress, for the screen and for commands that are typed meanwhile. */
#pragma once

#include <hooke/module.h>

struct unit;

/* A collection in progress, as others see it. */
struct collecting {
    struct growing growing;
    /* WAITING means waiting for the trigger */
    enum { COLLECT_WAITING, COLLECT_GOES_ON, COLLECT_PAUSED } state;
    bool stop; /* the user has asked to stop */
    /* number of lines that have come */
    uint64_t lines;
    double seconds;           /* [s] since the first line, or the trigger, without pauses */
    double period, amplitude; /* [s], SI of the last few periods; NAN if unknown */
    enum quantity quantity;   /* quantity of the amplitude */
    struct {
        double t;                         /* [s] of the newest sample; NAN if there is no fit */
        struct measured period, gamma, k; /* NAN if not determined; k also if the mass is unknown */
    } fit;
    struct { /* a calibration that waits for its points */
        bool waits;
        int taken; /* number of readings taken, of two */
        double truth[2], read[2], scatter[2];
        size_t samples;                               /* number of samples in the first reading */
        const struct unit *truth_unit[2], *read_unit; /* NULL if there is none */
    } aim;
    struct feed *feed;
};

/* The module's part of a session. */
struct collect_part {
    struct collecting *now; /* NULL if nothing is collected */
};

extern const struct module collect_module;

/* Returns what is being collected in the session, or NULL. */
struct collecting *session_collecting(const struct session *session);

/* Appends time, lines, period and fit to the state line, with the number of lines if `counts` is
 * set, with blanks between numbers and units if `blanks` is set. Returns false if nothing is
 * collected. */
bool collect_state(const struct session *session, bool counts, bool blanks, struct buffer *output);
/* Appends "calibrate take" where a calibration waits for a point. */
bool collect_next(const struct session *session, struct buffer *line);
