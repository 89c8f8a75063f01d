/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Private to the terminal layer: sensors, simulated and at devices. */
#ifndef HOOKE_TERMINAL_SENSOR_SENSOR_H
#define HOOKE_TERMINAL_SENSOR_SENSOR_H

#include "terminal/terminal.h"

#include <termios.h>

/*
 * What a cheap sensor before the scene would send, on standard output, in real time, until it is
 * interrupted, nobody reads any more, or for= is over: text at the start, then a line a sample.
 * words: KEY=VALUE of the sensor, or of the scene's parameters. Returns the exit status.
 */
int simulate_sensor(struct session *session, const char *scene, const struct task *word, int words);

/* feed.c */
extern const struct feed_access sensor_feed;

/* device.c: a source of lines, opened and locked; a serial line is raw and has that speed. */
struct device {
    int fd;
    bool serial, grows; /* grows: a file, whose end is none */
    struct termios before;
};

bool device_open(struct device *device, const char *path, long baud, bool safe,
                 struct error *error);
void device_close(struct device *device);

#endif
