/* SPDX-License-Identifier: GPL-3.0-or-later */
/* settings: the settings of a session that are not part of the scene: their values (struct
 * settings), their description as rows (struct setting, setting_catalog), and their text.
 * src/session/settings.def lists them with their defaults. */
#pragma once

#include <hooke/base/catalog.h>
#include <hooke/base/quantity.h>
#include <hooke/run/record.h>

struct charset;
struct figure_words;
struct preset;

/* ---- values of choices ---- */

/* A choice of `set charset`; modules add choices in their charsets.def. */
struct charset_choice {
    struct row row;
    const struct charset *charset; /* NULL for the one that suits the terminal. */
};
/* Returns the functions that describe figures in words, or NULL if no module of this build has any.
 */
const struct figure_words *charset_words(void);
/* Use of colours in plots: on terminals unless NO_COLOR is set, always, or never. */
enum color_choice { COLOR_AUTO, COLOR_ALWAYS, COLOR_NEVER };
/* Axes of the phase plot: v/omega0 or v. */
enum phase_axes { PHASE_SCALED, PHASE_RAW };
/* Pace of the frames of the live view. */
enum sync_choice {
    SYNC_AUTO, /* As SYNC_ON if the terminal answers, else as SYNC_OFF. */
    SYNC_ON,   /* The next frame waits until the terminal has shown the last one. */
    SYNC_OFF   /* Frames do not wait. */
};
/* View of a live run. */
enum view_choice {
    VIEW_PAGE,  /* It fills the plot, then begins a new page: few bytes for slow lines. */
    VIEW_SCROLL /* It scrolls by whole cells. */
};

/* Addition of increments to the state in fixed steps: plain, or with compensation for rounding
 * errors (Kahan 1965). */
enum sums { SUMS_PLAIN, SUMS_COMPENSATED };
/* Steps end at turning points where a force has a kink, or go across. */
enum turning { TURNING_ON, TURNING_OFF };
/* Long output goes to a pager. */
enum pager { PAGER_OFF, PAGER_ON };
/* Effort for the estimated error of adaptive runs. OPINIONS_AUTO allows a second solution up to a
 * quarter of the run's work, OPINIONS_FULL one to the end of the run at any cost. OPINIONS_WARN is
 * OPINIONS_AUTO with a warning instead of an error for a run without a correct digit (chaotic
 * motion). OPINIONS_OFF allows none. */
enum opinion_choice { OPINIONS_AUTO, OPINIONS_FULL, OPINIONS_WARN, OPINIONS_OFF };

/* Values of all settings. Each row of settings.def defines a member, or a pair of members. */
struct settings {
#define SETTING(type, field, ...) type field;
#define SETTING_PAIR(type, field, second, ...) type field, second;
#include "session/settings.def"
    /* Values of the modules' settings (indices of choices), in the order of their list. */
    int of_modules[8];
    /* The user has set dt, tol or duration. If not, tol and duration are those of the scene, and dt
     * is the default. */
    bool dt_chosen, tol_chosen, duration_chosen;
};

/* Methods to which a setting applies: all, those with fixed steps, or those with a tolerance. The
 * command `set` tells the user if the current method ignores the setting. */
enum setting_use { USE_ANY, USE_STEP, USE_TOLERANCE };

/* A setting: a row of setting_catalog. */
struct setting {
    struct row row;
    /* Quantity of its value. */
    enum quantity quantity;
    size_t offset, bytes; /* Offset and size [byte] of its value in struct settings. */
    /* Offset in struct settings of the bool that is true if the user has set the value, or 0 if
     * there is no such bool. */
    size_t chosen;
    /* Returns the value that follows from the scene while the user has not set it; NULL if the
     * default does not depend on the scene. */
    double (*natural)(const struct preset *preset);
    /* `show plot` lists it among settings of the display, although it is not `display`. */
    bool plots;
    enum setting_use use;
    bool of_run; /* The rows or steps of a run depend on it, so that each run has its own copy. */
    /* It concerns only the display: undo does not change it, and saved sessions do not contain it.
     */
    bool display;
    /* It can be set only by a person at a prompt, not by a file, by option -c or by a saved
     * session. */
    bool typed;
    /* Catalog of the choices, or NULL. The value is an int, the index of a choice, unless parse()
     * is set. */
    const struct catalog *choices;
    /* Bounds of a number x, min < x <= max; max is 0 if the value is not a number. */
    double min, max;
    /* Functions for values that are neither numbers nor plain choices, else NULL. parse() reads the
     * value from the text `value`, or returns false with `error` set; show() appends the value. */
    bool (*parse)(struct settings *settings, struct text value, struct error *error);
    void (*show)(const struct settings *settings, struct buffer *text);
};

/* All settings, those of modules included. */
extern const struct catalog setting_catalog;
/* Returns the setting with exactly this name or alias, or NULL. */
const struct setting *setting_by_name(struct text name);
/* Returns setting i of the catalog. */
const struct setting *setting_at(size_t i);
/* Returns the value (index of a choice) of the setting `name` of a module, which must be in this
 * build. */
int setting_of_module(const struct settings *settings, const char *name);
/* Returns the setting whose struct row this is; it must be in setting_catalog. */
const struct setting *setting_from(const struct row *row);

/* Returns true if the setting has the same value in a and b. */
bool setting_same(const struct setting *setting, const struct settings *a,
                  const struct settings *b);
/* Copies the value of one setting from `source` to `target`. */
void setting_copy(const struct setting *setting, const struct settings *source,
                  struct settings *target);
/* Names of enum output_format, struct row at its index: text, csv, json. */
extern const struct catalog format_choice_catalog;

/* Time [s] that no run reaches; finite, so that the remaining time is a number. */
#define T_UNREACHABLE 1e300

/* ---- text of values ---- */

/* Returns the row of the choice that is set, or NULL if the setting has no choices or has parse(),
 * so that its value is more than a choice. */
const struct row *setting_choice(const struct setting *setting, const struct settings *settings);
/* Appends the value for people, numbers with the number of digits of the setting `digits`. */
void setting_show(const struct setting *setting, const struct settings *settings,
                  struct buffer *text);
/* Appends the value in a form from which the command `set` reads exactly the same value. */
void setting_exact(const struct setting *setting, const struct settings *settings,
                   struct buffer *text);

/* Names of the enums above, struct row at their index. */
extern const struct catalog charset_choice_catalog, phase_axes_catalog, turning_catalog;
extern const struct catalog opinion_catalog;
