/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Closed lists of words that arguments choose from: separators, decimal marks, quantities to
 * measure, groups of `show`, kinds of `list`; and the choice of a row by name. */
#include <hooke/method.h>
#include <hooke/language.h>
#include <hooke/module.h>

#include <stdio.h>

/* A row of a list in which only name and description matter. */
#define ROW(name, brief)                                                                           \
    {                                                                                              \
        name, "", brief, "", NULL                                                                  \
    }

static const struct row separators[] = {ROW("tab", "tabulator"), ROW("comma", ","),
                                        ROW("semicolon", ";"), ROW("blank", "blanks")};
const struct catalog separator_catalog = CATALOG("separator", separators);

static const struct row decimals[] = {ROW("point", "1.5"), ROW("comma", "1,5")};
const struct catalog decimal_catalog = CATALOG("decimal mark", decimals);

static const struct row quantities[] = {
    [MEASURE_PERIOD] = ROW("period", "from phases, crossings or whole cycles"),
    [MEASURE_FREQUENCY] = ROW("frequency", "1/period"),
    [MEASURE_AMPLITUDE] =
        ROW("amplitude", "half the swing about the local offset, at one or several times"),
    [MEASURE_DECAY] =
        ROW("decay", "gamma, 1/e time, decrement and Q from several readings of the amplitude"),
    [MEASURE_ENERGY] = ROW("energy", "mean energy, and how it changes"),
    [MEASURE_DRIFT] = ROW("drift", "error of the energy balance of a run"),
    [MEASURE_REYNOLDS] = ROW("reynolds", "Reynolds number at the largest speed"),
    [MEASURE_K] = ROW("k", "spring constant from the period and the mass"),
    [MEASURE_SPRING] =
        ROW("spring", "k and the spring's effective mass from T^2 against m of several recordings"),
    [MEASURE_SPECTRUM] = ROW("spectrum", "frequency and amplitude of the significant lines"),
    [MEASURE_REPEAT] =
        ROW("repeat", "mean, scatter and uncertainty to quote for several recordings or windows"),
};
const struct catalog quantity_catalog = CATALOG("quantity to measure", quantities);

static const struct row shows[] = {
    [SHOW_ALL] = ROW("all", "all names"),
    [SHOW_SCENE] = ROW("scene", "parameters and quantities derived from them"),
    [SHOW_RUN] = ROW("run", "state of the current run"),
    [SHOW_DATA] = ROW("data", "the current recording"),
    [SHOW_PLOT] = ROW("plot", "settings of plots and text"),
    [SHOW_FILES] = ROW("files", "files read and written"),
};
const struct catalog show_catalog = CATALOG("group", shows);

#define LISTED_FUNCTIONS
#include "lists/listed.def"
#undef LISTED_FUNCTIONS
static const struct list_kind lists[] = {
    [LIST_COMMANDS] = {.row = ROW("commands", "")},
    [LIST_SCENES] = {.row = ROW("scenes", "")},
    [LIST_METHODS] = {.row = ROW("methods", "")},
    [LIST_PARAMETERS] = {.row = ROW("parameters", "")},
    [LIST_DERIVED] = {.row = ROW("derived", "")},
    [LIST_OBSERVABLES] = {.row = ROW("observables", "")},
    [LIST_SETTINGS] = {.row = ROW("settings", "")},
    [LIST_UNITS] = {.row = ROW("units", "")},
    [LIST_FUNCTIONS] = {.row = ROW("functions", "")},
    [LIST_LIMITS] = {.row = ROW("limits", "")},
    [LIST_MEASUREMENTS] = {.row = ROW("measurements", "")},
    [LIST_EVENTS] = {.row = ROW("events", "")},
    [LIST_RUNS] = {.row = ROW("runs", "")},
#include "lists/listed.def"
};
const struct catalog list_catalog = CATALOG("list", lists);

/* Finds a row by its name or, for statements typed at the prompt, by a unique beginning of it (of
 * at least three letters for methods). Returns NULL if there is none. */
const struct row *catalog_choose(const struct session *session, const struct catalog *catalog,
                                 struct text name)
{
    /* Shorter beginnings of methods are too easily typed by mistake. */
    const size_t min = catalog == &method_catalog ? 3 : 1;
    return session->execution.typed ? catalog_prefix(catalog, name, min)
                                    : catalog_find(catalog, name);
}

/* Returns false with an error if a module that this program was built without would add a row of
 * this name to the catalog. */
bool choice_is_in(const struct catalog *catalog, struct text name, struct error *error)
{
    char what[64];
    snprintf(what, sizeof what, "%s %.*s", catalog->kind, (int)name.len, name.data);
    return module_is_in(what, name, error);
}
