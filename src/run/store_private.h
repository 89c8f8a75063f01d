/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by the two files that store runs as bytes. */
#pragma once

#include <hooke/run/store.h>
#include "run/private.h"

#include <math.h>

/* Reads the settings from a run's fields; returns false if they are missing or if no run can have
 * them. */
bool run_settings_take(struct text fields, struct run_settings *settings);
/* All but its rows, of which there are so many, can be what a run has come to. */
bool run_is_sound(const struct run *run);
