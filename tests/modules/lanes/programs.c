/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The tests of programs once more, each of whose programs is evaluated on many lanes, too. */
#include "modules/lanes/lane_programs.h"

#include "numerics/scene/program.c"
