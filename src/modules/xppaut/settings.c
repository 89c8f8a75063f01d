/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads settings of .ode files, in lines `@` and in sets, as NAME=VALUE of which the last one
 * holds, and chooses the method. */
#include <hooke/base/number.h>
#include <string.h>

#include "modules/xppaut/ode.h"

/* Returns true for characters that separate settings. */
static bool is_setting_end(char c)
{
    return c == ' ' || c == ',' || c == '\r' || c == ';' || c == '{' || c == '}';
}

/* Skips separators, `all` or only blanks. */
static void setting_separators_skip(struct text *rest, bool all)
{
    while (rest->len > 0 && (all ? is_setting_end(rest->data[0]) : rest->data[0] == ' '))
        *rest = (struct text){rest->data + 1, rest->len - 1};
}

/* Splits off a word, which ends at '=', too, if it is a `name`. */
static struct text setting_word_take(struct text *rest, bool name)
{
    size_t len = 0;
    while (len < rest->len && !is_setting_end(rest->data[len]) && !(name && rest->data[len] == '='))
        len++;
    const struct text taken = {rest->data, len};
    *rest = (struct text){rest->data + len, rest->len - len};
    return taken;
}

/* Splits the next NAME=VALUE off *rest; *value is empty for a NAME without a value. Returns false
 * if none is left. */
bool ode_pair(struct text *rest, struct text *name, struct text *value)
{
    *value = TEXT("");
    setting_separators_skip(rest, true);
    *name = setting_word_take(rest, true);
    setting_separators_skip(rest, false);
    if (rest->len > 0 && rest->data[0] == '=') {
        *rest = (struct text){rest->data + 1, rest->len - 1};
        setting_separators_skip(rest, false);
        *value = setting_word_take(rest, false);
        return true;
    }
    return name->len > 0;
}

/* Reads the number of NAME=VALUE. Returns false with an error that names the line. */
bool ode_number(int line, struct text name, struct text value, double *number, struct error *error)
{
    if (real_parse(value, number) == REAL_OK && isfinite(*number))
        return true;
    const int shown = (int)(name.len < 40 ? name.len : 40);
    return ode_error(error, line, "%.*s=%.*s: this needs a number", shown, name.data,
                     (int)(value.len < 40 ? value.len : 40), value.data);
}

/* Settings of XPPAUT. A name in the file needs only to begin with the name here. */
static const struct known {
    const char *name;
    /* offsets in struct ode_settings of the number and its flag; `has` is 0 for settings that are
     * not used, with a note if that matters */
    size_t number, has;
    const char *note;
} known[] = {
    {"total", offsetof(struct ode_settings, total), offsetof(struct ode_settings, has_total), NULL},
    {"dtmin", 0, 0, NULL},
    {"dtmax", 0, 0, NULL},
    {"dt", offsetof(struct ode_settings, dt), offsetof(struct ode_settings, has_dt), NULL},
    {"t0", offsetof(struct ode_settings, t0), offsetof(struct ode_settings, has_t0), NULL},
    {"tol", offsetof(struct ode_settings, tol), offsetof(struct ode_settings, has_tol), NULL},
    {"nout", offsetof(struct ode_settings, every), offsetof(struct ode_settings, has_every), NULL},
    {"njmp", offsetof(struct ode_settings, every), offsetof(struct ode_settings, has_every), NULL},
    {"trans", 0, 0, "the transient is recorded, too"},
    {"fold", 0, 0, "angles are not reduced to one turn"},
    {"tor_per", 0, 0, NULL},
    {"delay", 0, 0, NULL},
};

/* Stores the letter of the method. */
static bool set_method(struct ode_settings *settings, int line, struct text value)
{
    if (value.len == 0)
        return true;
    settings->method = value.data[0];
    settings->has_method = true;
    settings->line = line;
    return true;
}

/* Stores a setting of a line `@` or of a named set. *note becomes the reason why it has no effect,
 * or NULL. Names of other settings of XPPAUT (windows, tools) are ignored. Returns false with an
 * error. */
bool ode_setting(struct ode_settings *settings, int line, struct text name, struct text value,
                 const char **note, struct error *error)
{
    *note = NULL;
    if (text_starts(name, TEXT("meth")))
        return set_method(settings, line, value);
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        const struct known *row = &known[i];
        if (!text_starts(name, text_of(row->name)))
            continue;
        bool *has = row->has ? (bool *)(void *)((char *)settings + row->has) : NULL;
        double number;
        *note = row->note;
        if (!has)
            return true;
        if (!ode_number(line, name, value, &number, error))
            return false;
        memcpy((char *)settings + row->number, &number, sizeof number);
        *has = true;
        return true;
    }
    return true; /* settings of windows and of other tools */
}

/* ---- the method ---- */

static const struct {
    char letter;
    const char *name, *meant; /* `meant` describes XPPAUT's method if it is another one */
    bool adapts;
} methods[] = {
    {'r', "rk4", NULL, false},
    {'e', "euler", NULL, false},
    {'m', "heun", NULL, false},
    {'a', "abm4", NULL, false},
    {'b', "backward-euler", NULL, false},
    {'q', "dopri5", "qualrk, a Runge-Kutta pair", true},
    {'5', "dopri5", NULL, true},
    {'8', "dop853", NULL, true},
    {'g', "radau5", "gear, backward differences", true},
    {'c', "radau5", "cvode, backward differences", true},
    {'s', "rodas4", "stiff, a Rosenbrock pair", true},
    {'2', "rodas4", "a Rosenbrock pair", true},
    {'y', "dop853", "symplectic, for scenes of second order", true},
    {'v', "rk4", "volterra, for integral equations", false},
};

/* Sets method, tolerance, times and steps of the scene from the file's settings, otherwise from
 * XPPAUT's defaults. Returns false with an error for maps, or if a duration or step is not above 0.
 */
bool ode_method(const struct ode_settings *settings, struct ode_scene *scene, struct error *error)
{
    if (settings->has_method && settings->method == 'd')
        return ode_error(error, settings->line,
                         "method discrete: scenes have continuous time, so maps are not possible");
    size_t i = 0;
    while (i < COUNT_OF(methods) && settings->has_method && methods[i].letter != settings->method)
        i++;
    i = i < COUNT_OF(methods) ? i : 0; /* an unknown letter means the default, as in XPPAUT */
    scene->method = methods[i].name;
    scene->meant = methods[i].meant;
    scene->adapts = methods[i].adapts;
    scene->tol = methods[i].adapts && settings->has_tol && settings->tol > 0 && settings->tol < 1
                     ? settings->tol
                     : 0;
    scene->t0 = settings->t0;
    scene->total = settings->has_total ? settings->total : 20; /* XPPAUT's own defaults */
    scene->dt = settings->has_dt ? settings->dt : 0.05;
    scene->every = settings->has_every && settings->every >= 1 && settings->every <= 1e9
                       ? (int)settings->every
                       : 1;
    if (!(scene->total > 0) || !(scene->dt > 0) || !isfinite(scene->t0))
        return error_set(error, ERROR_IO, "total and dt must be above 0");
    return true;
}
