/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The terminal part of the module collect: lines from devices, and the option --simulate-sensor. */
#include "modules/collect/terminal/sensor.h"

static void offer(struct front *front, struct streams *streams)
{
    (void)streams;
    front->feed = &sensor_feed;
}

const struct terminal_part collect_terminal = {
    .offer = offer,
    .option =
        {
            .word = "simulate-sensor",
            .shown = " SCENE ",
            .brief = "a sensor on standard output: [rate=100] [noise=0.03cm] [seed=1] [for=10s] "
                     "[NAME=VALUE]",
            .wants = "a scene",
            .takes_first = true,
            .run = simulate_sensor,
        },
};
