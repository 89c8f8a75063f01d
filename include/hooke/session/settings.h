/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The settings that are not part of the scene. */
#pragma once

#include <hooke/base/catalog.h>
#include <hooke/base/quantity.h>
#include <hooke/run/record.h>

struct charset;
struct figure_words;
struct preset;

/* ---- settings ---- */

/* A choice of `set charset`; modules bring more in their charsets.def. */
struct charset_choice {
    struct row row;
    const struct charset *charset; /* NULL for the one that suits the terminal */
};
/* Returns the functions that put figures into words, or NULL if no module of this build has any. */
const struct figure_words *charset_words(void);
enum color_choice { COLOR_AUTO, COLOR_ALWAYS, COLOR_NEVER };
enum phase_axes { PHASE_SCALED, PHASE_RAW };
enum sync_choice {
    /* Decides whether the next frame waits until the terminal has answered. */
    SYNC_AUTO,
    SYNC_ON,
    SYNC_OFF
};
enum view_choice {
    /* the live view sweeps, then pages; or scrolls by whole cells */
    VIEW_PAGE,
    VIEW_SCROLL
};

enum sums { SUMS_PLAIN, SUMS_COMPENSATED };
enum turning { TURNING_ON, TURNING_OFF };
enum pager { PAGER_OFF, PAGER_ON };
enum opinion_choice { OPINIONS_AUTO, OPINIONS_FULL, OPINIONS_WARN, OPINIONS_OFF };

struct settings {
#define SETTING(type, field, ...) type field;
#define SETTING_PAIR(type, field, second, ...) type field, second;
#include "session/settings.def"
    int of_modules[8]; /* choices of settings of modules, in the order of their list */
    /* set by the user; otherwise tol and duration are those of the scene */
    bool dt_chosen, tol_chosen, duration_chosen;
};

/* Use of the setting by methods, for `set`. */
enum setting_use { USE_ANY, USE_STEP, USE_TOLERANCE };

struct setting {
    struct row row;
    enum quantity quantity;
    size_t offset, bytes; /* position and size of the field in struct settings */
    size_t chosen;        /* 0, or the offset of the bool that says the user has set it */
    /* Value if the user has not set it; NULL if it is that of a new session. */
    double (*natural)(const struct preset *preset);
    bool plots; /* `show plot` shows it although it belongs to the experiment */
    enum setting_use use;
    bool of_run; /* a run keeps its own */
    /* concerns only how results look, not the experiment: neither saved nor undone */
    bool display;
    bool typed; /* only at a prompt: no file, no -c and no saved session can set it */
    /* If there are choices and no `parse`, the field is an int, the index of one. */
    const struct catalog *choices;
    /* Bounds of a number, min < x <= max; max is 0 if it is not a number. */
    double min, max;
    /* Functions for other types of fields; otherwise NULL. */
    bool (*parse)(struct settings *settings, struct text value, struct error *error);
    void (*show)(const struct settings *settings, struct buffer *text);
};

extern const struct catalog setting_catalog;
/* Finds a setting by its exact name or alias; returns NULL if there is none. */
const struct setting *setting_by_name(struct text name);
const struct setting *setting_at(size_t i);
/* Returns the choice of a setting of a module, which has to be in this build. */
int setting_of_module(const struct settings *settings, const char *name);
const struct setting *setting_from(const struct row *row); /* row of the catalog */

bool setting_same(const struct setting *setting, const struct settings *a,
                  const struct settings *b);
void setting_copy(const struct setting *setting, const struct settings *source,
                  struct settings *target);
/* struct row at the enum's place: text, csv, json */
extern const struct catalog format_choice_catalog;

/* Time [s] that no run reaches; finite, so that the time left is a number. */
#define T_UNREACHABLE 1e300

/* ---- values of settings ---- */

/* Returns the choice that is set, or NULL if the value is more than a choice, or none. */
const struct row *setting_choice(const struct setting *setting, const struct settings *settings);
void setting_show(const struct setting *setting, const struct settings *settings,
                  struct buffer *text);
/* As a command that reads back exactly. */
void setting_exact(const struct setting *setting, const struct settings *settings,
                   struct buffer *text);

extern const struct catalog charset_choice_catalog, phase_axes_catalog, turning_catalog;
extern const struct catalog opinion_catalog;
