/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Table of the limits of the program, for `list limits` and for help. */
#include <hooke/base/catalog.h>
#include <hooke/base/limit.h>

static const struct limit limits[] = {
    {{"line", "byte", "length of a command line", "", NULL}, LIMIT_LINE},
    {{"tokens", "", "words in a statement", "", NULL}, LIMIT_TOKENS},
    {{"expr-depth", "", "nesting depth of an expression", "", NULL}, LIMIT_EXPR_DEPTH},
    {{"expr-size", "", "operations in an expression", "", NULL}, LIMIT_EXPR_SIZE},
    {{"source-depth", "", "depth of files that source other files", "", NULL}, LIMIT_SOURCE_DEPTH},
    {{"name", "byte", "length of a name", "", NULL}, LIMIT_NAME},
    {{"runs", "", "runs kept", "", NULL}, LIMIT_RUNS},
    {{"recordings", "", "recordings kept", "", NULL}, LIMIT_RECORDINGS},
    {{"undo", "", "undo levels", "", NULL}, LIMIT_UNDO},
    {{"variables", "", "state variables of a scene", "", NULL}, LIMIT_VARIABLES},
    {{"columns", "", "columns of a data file", "", NULL}, LIMIT_COLUMNS},
    {{"file", "byte", "size of a data file", "", NULL}, LIMIT_FILE},
    {{"samples", "", "samples of a run before it is decimated", "", NULL}, LIMIT_SAMPLES},
    {{"steps", "", "steps of a run", "", NULL}, LIMIT_STEPS},
    {{"requests", "", "continuations, rewinds and changes of one run", "", NULL}, LIMIT_REQUESTS},
    {{"changes", "", "changes of parameters in one run", "", NULL}, LIMIT_CHANGES},
    {{"event-records", "", "events recorded in a run", "", NULL}, LIMIT_EVENT_RECORDS},
    {{"events", "", "events defined at once", "", NULL}, LIMIT_EVENTS},
    {{"event-text", "byte", "length of an event's formula, and of its commands", "", NULL},
     LIMIT_EVENT_TEXT},
    {{"overlay", "", "other runs drawn in the panes", "", NULL}, LIMIT_OVERLAY},
    {{"let", "", "variables made by let", "", NULL}, LIMIT_LET},
    {{"checkpoints", "", "checkpoints kept", "", NULL}, LIMIT_CHECKPOINTS},
    {{"own-scenes", "", "scenes of your own", "", NULL}, LIMIT_OWN},
    {{"symbol", "byte", "length of a name of your own variable or scene", "", NULL}, LIMIT_SYMBOL},
    {{"parameters", "", "parameters of a typed scene, including initial values and t0", "", NULL},
     LIMIT_PARAMETERS},
    {{"observed", "", "quantities that a typed scene observes", "", NULL}, LIMIT_OBSERVED},
    {{"modes", "", "damped sines fitted at once", "", NULL}, LIMIT_MODES},
    {{"measurements", "", "measurements kept; older ones are dropped", "", NULL},
     LIMIT_MEASUREMENTS},
    {{"results", "", "results kept by name; older ones are dropped", "", NULL}, LIMIT_RESULTS},
    {{"fits", "", "fits kept; older ones are dropped", "", NULL}, LIMIT_FITS},
    {{"orbits", "", "periodic orbits kept; older ones are dropped", "", NULL}, LIMIT_ORBITS},
    {{"branches", "", "branches kept; older ones are dropped", "", NULL}, LIMIT_BRANCHES},
    {{"branch-points", "", "points of a branch in each direction", "", NULL}, LIMIT_BRANCH_POINTS},
    {{"history", "", "lines and statements in the history", "", NULL}, LIMIT_HISTORY},
    {{"history-text", "byte", "text of the history", "", NULL}, LIMIT_HISTORY_TEXT},
    {{"log", "", "lines kept for the log pane", "", NULL}, LIMIT_LOG},
    {{"script", "byte", "size of a file of commands", "", NULL}, LIMIT_SCRIPT},
};

const struct catalog limit_catalog = CATALOG("limit", limits);
