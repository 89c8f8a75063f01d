/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Private to the terminal layer: sensors, simulated and at devices. */
#ifndef HOOKE_TERMINAL_SENSOR_SENSOR_H
#define HOOKE_TERMINAL_SENSOR_SENSOR_H

#include "terminal/terminal.h"

/*
 * What a cheap sensor before the scene would send, on standard output, in real time, until it is
 * interrupted, nobody reads any more, or for= is over: text at the start, then a line a sample.
 * words: KEY=VALUE of the sensor, or of the scene's parameters. Returns the exit status.
 */
int simulate_sensor(struct session *session, const char *scene, const struct task *word, int words);

#endif
