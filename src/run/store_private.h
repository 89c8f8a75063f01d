/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the two files of runs as bytes share. */
#ifndef HOOKE_RUN_STORE_PRIVATE_H
#define HOOKE_RUN_STORE_PRIVATE_H

#include <hooke/run/store.h>
#include "run/private.h"

#include <math.h>

/* The settings among a run's fields; false: they are not there, or none that a run can have. */
bool run_settings_take(struct text fields, struct run_settings *settings);
/* All but its rows, of which there are so many, can be what a run has come to. */
bool run_is_sound(const struct run *run);

#endif
