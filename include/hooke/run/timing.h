/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Definition of how times are measured and shown: the setting `timing`. */
#pragma once

struct catalog;

enum timing {
    TIMING_OFF, /* nothing is measured, and no answer holds a time */
    TIMING_QUICK,
    TIMING_FULL
};

extern const struct catalog timing_catalog; /* struct row at the enum's place: off, quick, full */
