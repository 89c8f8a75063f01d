/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by store.c, which writes runs as bytes and reads them, and store_sound.c,
 * which checks that what was read is valid. */
#pragma once

#include <hooke/run/store.h>
#include "run/private.h"

#include <math.h>

/* Reads the settings from the fields of a stored run. Returns false if they are missing or if no
 * run can have them. */
bool run_settings_take(struct text fields, struct run_settings *settings);
/* Returns true if everything that was read of a run, except for its rows, is within the limits on
 * which other code relies. */
bool run_is_sound(const struct run *run);
