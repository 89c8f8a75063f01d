/* SPDX-License-Identifier: GPL-3.0-or-later */
/* timing: values of the setting `timing`, which chooses how run times are measured and shown. */
#pragma once

struct catalog;

/* The choices. */
enum timing {
    /* Nothing is measured, and no reply contains a time, so that replies are reproducible. */
    TIMING_OFF,
    /* 3 to 5 measurements of at least 0.2 ms each. */
    TIMING_QUICK,
    /* 15 measurements of at least 1 ms each. */
    TIMING_FULL
};

/* Names of the choices, struct row at the index of the enum: off, quick, full. */
extern const struct catalog timing_catalog;
