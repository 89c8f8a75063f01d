/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The rows of the setting `timing`. */
#include <hooke/base/catalog.h>
#include <hooke/run/timing.h>

static const struct row timing_rows[] = {
    [TIMING_OFF] = {"off", "", "no times are measured", "", NULL},
    [TIMING_QUICK] = {"quick", "", "3 to 5 samples of at least 0.2 ms", "", NULL},
    [TIMING_FULL] = {"full", "", "15 samples of at least 1 ms", "", NULL},
};

const struct catalog timing_catalog = CATALOG("timing", timing_rows);
