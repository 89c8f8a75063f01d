/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/base.h>

static const struct limit limits[] = {
    {{"line", "byte", "length of a command line", "", NULL}, LIMIT_LINE},
    {{"tokens", "", "words in a statement", "", NULL}, LIMIT_TOKENS},
    {{"expr-depth", "", "parentheses and operators nested in an expression", "", NULL},
     LIMIT_EXPR_DEPTH},
    {{"expr-size", "", "operations in an expression", "", NULL}, LIMIT_EXPR_SIZE},
    {{"source-depth", "", "files that source files", "", NULL}, LIMIT_SOURCE_DEPTH},
    {{"name", "byte", "length of a name", "", NULL}, LIMIT_NAME},
    {{"runs", "", "runs kept", "", NULL}, LIMIT_RUNS},
    {{"recordings", "", "recordings kept", "", NULL}, LIMIT_RECORDINGS},
    {{"undo", "", "undo levels", "", NULL}, LIMIT_UNDO},
    {{"variables", "", "state variables of a scene", "", NULL}, LIMIT_VARIABLES},
    {{"columns", "", "columns of a data file", "", NULL}, LIMIT_COLUMNS},
    {{"file", "byte", "size of a data file", "", NULL}, LIMIT_FILE},
    {{"samples", "", "samples of a trace before it is decimated", "", NULL}, LIMIT_SAMPLES},
    {{"steps", "", "steps of a run", "", NULL}, LIMIT_STEPS},
};

const struct catalog limit_catalog = CATALOG("limit", limits);
