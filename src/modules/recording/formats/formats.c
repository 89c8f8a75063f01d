/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The catalog of formats. Each format is a file, NAME.def, that ends in its row. It is included
 * twice, first for its functions and then, with FORMAT_ROW defined, for its row, so that all rows
 * are one array. "lists/formats.def" is the list of these files, which scripts/modules writes. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "modules/recording/table/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "lists/formats.def"

#define FORMAT_ROW
static const struct format formats[] = {
#include "lists/formats.def"
};

const struct catalog format_catalog = CATALOG("format", formats);

const struct format *format_by_name(struct text name)
{
    return (const struct format *)(const void *)catalog_find(&format_catalog, name);
}

const struct format *format_at(size_t i)
{
    return (const struct format *)(const void *)catalog_row(&format_catalog, i);
}
