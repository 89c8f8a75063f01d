/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sensors for the module collect: a simulated one, and sources of lines. */
#pragma once

#include "terminal/parts.h"

#include <termios.h>

/*
 * Writes to standard output, in real time, what a cheap sensor observing the scene would send: text
 * at the start, then one line per sample. Ends when interrupted, when the reader closes the pipe,
 * or after for=. The words name the scene, then give KEY=VALUE for the sensor or the scene's
 * parameters. Returns the exit status.
 */
int simulate_sensor(struct session *session, const char *const *word, int words,
                    struct reply *reply);

/* Functions by which the session reads a sensor. */
extern const struct feed_access sensor_feed;

/* Source of lines (device.c), opened and locked; a serial line is in raw mode with the given
 * speed. */
struct device {
    int fd;
    bool serial, grows; /* grows is true for a file, whose end may still move */
    struct termios old_modes;
};

/* Opens the source at `path`. Returns false with an error; nothing is open then. */
bool device_open(struct device *device, const char *path, long baud, bool safe,
                 struct error *error);
/* Restores the modes of the source and closes it. */
void device_close(struct device *device);
