/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The tests of derivatives once more, each of which is evaluated on many lanes, too. */
#include "modules/lanes/lane_programs.h"

#include "numerics/scene/slopes.c"
