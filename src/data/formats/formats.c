/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The formats. Each is a file of its own, NAME.def, that ends in its row; it is included twice,
 * first for its functions and then, with FORMAT_ROW defined, for its row, so that all rows are one
 * array. <formats.def> is the Makefile's list of these files.
 */
#include "data/table/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include <formats.def>

#define FORMAT_ROW
static const struct format formats[] = {
#include <formats.def>
};

const struct catalog format_catalog = CATALOG("format", formats);
