/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sensors, simulated and at devices. */
#pragma once

#include "terminal/parts.h"

#include <termios.h>

/*
 * What a cheap sensor before the scene would send, on standard output, in real time, until it is
 * interrupted, nobody reads any more, or for= is over: text at the start, then a line a sample.
 * Words: the scene, then KEY=VALUE of the sensor, or of the scene's parameters. Returns the exit
 * status.
 */
int simulate_sensor(struct session *session, const char *const *word, int words,
                    struct reply *reply);

/* feed.c */
extern const struct feed_access sensor_feed;

/* device.c: a source of lines, opened and locked; a serial line is raw and has that speed. */
struct device {
    int fd;
    bool serial, grows; /* grows: a file, whose end is none */
    struct termios old_modes;
};

bool device_open(struct device *device, const char *path, long baud, bool safe,
                 struct error *error);
void device_close(struct device *device);
