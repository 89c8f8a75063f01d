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

/* Sums of fixed steps, plain or compensated (Kahan 1965). */
enum sums { SUMS_PLAIN, SUMS_COMPENSATED };
/* Steps end at turning points where a force has a kink, or go across. */
enum turning { TURNING_ON, TURNING_OFF };
/* Long output goes to a pager. */
enum pager { PAGER_OFF, PAGER_ON };
/* Effort for the estimated error of adaptive runs: up to a quarter of the run's work; up to its
 * end; the first, where a run without a correct digit is a warning instead of an error (chaos);
 * none. */
enum opinion_choice { OPINIONS_AUTO, OPINIONS_FULL, OPINIONS_WARN, OPINIONS_OFF };

/* Values of all settings. Each row of settings.def defines a field, or a pair of fields. */
struct settings {
#define SETTING(type, field, ...) type field;
#define SETTING_PAIR(type, field, second, ...) type field, second;
#include "session/settings.def"
    int of_modules[8]; /* Choices of the modules' settings, in the order of their list. */
    /* The user has set it; otherwise it follows the scene (tol, duration) or is the default. */
    bool dt_chosen, tol_chosen, duration_chosen;
};

/* Methods that use a setting, about which `set` tells the user: all, those with fixed steps, those
 * with a tolerance. */
enum setting_use { USE_ANY, USE_STEP, USE_TOLERANCE };

/* A setting: a row of setting_catalog. */
struct setting {
    struct row row;
    /* Quantity of its value. */
    enum quantity quantity;
    size_t offset, bytes; /* Offset and size [byte] of its field in struct settings. */
    size_t chosen;        /* Offset of the bool that tells that the user has set it, or 0. */
    /* Returns the value that follows from the scene while the user has not set it; NULL if the
     * default does not depend on the scene. */
    double (*natural)(const struct preset *preset);
    bool plots; /* `show plot` shows it although it belongs to the experiment. */
    enum setting_use use;
    bool of_run; /* A run has its own copy. */
    /* It concerns only the display: neither saved nor undone. */
    bool display;
    bool typed; /* It can only be set at a prompt, not by a file, -c or a saved session. */
    /* Choices, or NULL. Without parse() the field is an int, the index of a choice. */
    const struct catalog *choices;
    /* Bounds of a number, min < x <= max; max is 0 if it is not a number. */
    double min, max;
    /* Functions that read and write fields of other types, else NULL. parse() returns false with
     * `error` set. */
    bool (*parse)(struct settings *settings, struct text value, struct error *error);
    void (*show)(const struct settings *settings, struct buffer *text);
};

/* All settings, those of modules included. */
extern const struct catalog setting_catalog;
/* Returns the setting with exactly this name or alias, or NULL. */
const struct setting *setting_by_name(struct text name);
/* Returns setting i of the catalog. */
const struct setting *setting_at(size_t i);
/* Returns the index of the choice of a module's setting, which must be in this build. */
int setting_of_module(const struct settings *settings, const char *name);
/* Returns the setting whose struct row this is; it must be in setting_catalog. */
const struct setting *setting_from(const struct row *row);

/* Returns true if both have the same value of the setting. */
bool setting_same(const struct setting *setting, const struct settings *a,
                  const struct settings *b);
/* Copies the value of one setting. */
void setting_copy(const struct setting *setting, const struct settings *source,
                  struct settings *target);
/* Names of enum output_format, struct row at its index: text, csv, json. */
extern const struct catalog format_choice_catalog;

/* Time [s] that no run reaches; finite, so that the remaining time is a number. */
#define T_UNREACHABLE 1e300

/* ---- text of values ---- */

/* Returns the choice that is set, or NULL if the value is not just a choice. */
const struct row *setting_choice(const struct setting *setting, const struct settings *settings);
/* Appends the value for people. */
void setting_show(const struct setting *setting, const struct settings *settings,
                  struct buffer *text);
/* Appends the value so that a command reads the same bits back. */
void setting_exact(const struct setting *setting, const struct settings *settings,
                   struct buffer *text);

/* Names of the enums above, struct row at their index. */
extern const struct catalog charset_choice_catalog, phase_axes_catalog, turning_catalog;
extern const struct catalog opinion_catalog;
