/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The formats of files for tables: those of the core, then those of modules (lists/tables.def). A
 * row's name is the ending of the file's name. */
#include <hooke/report.h>

#define TABLE_KIND(name, brief, citation, function) extern table_format function;
#include "lists/tables.def"
#undef TABLE_KIND

static const struct table_kind kinds[] = {
    {{"csv", "", "comma-separated values, with the set-up in # lines", "RFC 4180", NULL},
     table_csv},
    {{"tsv", "", "like csv, separated by tabs", "", NULL}, table_tsv},
    {{"json", "", "one JSON object of columns with their values", "RFC 8259", NULL}, table_json},
#define TABLE_KIND(name, brief, citation, function) {{name, "", brief, citation, NULL}, function},
#include "lists/tables.def"
};

const struct catalog table_format_catalog = CATALOG("table format", kinds);
