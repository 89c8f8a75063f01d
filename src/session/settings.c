/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The settings, which are not part of the scene: the catalog of settings.def, and reading, showing
 * and copying of values. */
#include <hooke/run.h>
#include <hooke/run/timing.h>
#include <hooke/figure.h>
#include <hooke/result.h>
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/session/subject.h>

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

static const struct row format_rows[] = {
    [FORMAT_TEXT] = {"text", "", "lines to read", "", NULL},
    [FORMAT_CSV] = {"csv", "", "comma-separated rows with a header", "", NULL},
    [FORMAT_JSON] = {"json", "", "one JSON object per line", "", NULL},
};
const struct catalog format_choice_catalog = CATALOG("format", format_rows);

#define CHARSET_SYMBOLS
#include "lists/charsets.def"
#undef CHARSET_SYMBOLS
#define ROW(name, brief)                                                                           \
    {                                                                                              \
        name, "", brief, "", NULL                                                                  \
    }
static const struct charset_choice charset_rows[] = {
    {ROW("auto", "braille if the terminal supports it"), NULL},
    {ROW("ascii", "plain ASCII"), &charset_ascii},
    {ROW("block", "block characters"), &charset_block},
    {ROW("braille", "braille dots, 2x4 per cell"), &charset_braille},
#include "lists/charsets.def"
};
#undef ROW
const struct catalog charset_choice_catalog = CATALOG("charset", charset_rows);

/* Returns the functions of the first character set that puts figures into words, or NULL. */
const struct figure_words *charset_words(void)
{
    const struct figure_words *words = NULL;
    for (size_t i = 0; i < COUNT_OF(charset_rows) && !words; i++)
        words = charset_rows[i].charset ? charset_rows[i].charset->words : NULL;
    return words;
}

static const struct row color_rows[] = {
    [COLOR_AUTO] = {"auto", "", "on terminals, unless NO_COLOR is set", "", NULL},
    [COLOR_ALWAYS] = {"always", "", "always", "", NULL},
    [COLOR_NEVER] = {"never", "", "never", "", NULL},
};
static const struct catalog color_choice_catalog = CATALOG("color", color_rows);

static const struct row sync_rows[] = {
    [SYNC_AUTO] = {"auto", "", "on if the terminal answers", "", NULL},
    [SYNC_ON] = {"on", "", "the next frame waits until the terminal has shown the last one", "",
                 NULL},
    [SYNC_OFF] = {"off", "", "frames do not wait", "", NULL},
};
static const struct catalog sync_choice_catalog = CATALOG("kind of synchronisation", sync_rows);

static const struct row timing_rows[] = {
    [TIMING_OFF] = {"off", "", "no times are measured", "", NULL},
    [TIMING_QUICK] = {"quick", "", "3 to 5 samples of at least 0.2 ms", "", NULL},
    [TIMING_FULL] = {"full", "", "15 samples of at least 1 ms", "", NULL},
};
const struct catalog timing_catalog = CATALOG("timing", timing_rows);

static const struct row view_rows[] = {
    [VIEW_PAGE] = {"page", "", "the live view fills, then starts a new page: few bytes", "", NULL},
    [VIEW_SCROLL] = {"scroll", "", "the live view scrolls by whole cells", "", NULL},
};
static const struct row sums_rows[] = {
    [SUMS_PLAIN] = {"plain", "", "plain sums, as in textbooks", "", NULL},
    [SUMS_COMPENSATED] = {"compensated", "",
                          "rounding errors grow as slowly as random ones (Brouwer's law)",
                          "Kahan 1965", NULL},
};
static const struct row turning_rows[] = {
    [TURNING_ON] =
        {"on", "",
         "steps end at turning points and switches, in extra steps: methods keep their order", "",
         NULL},
    [TURNING_OFF] = {"off", "", "steps cross them: methods run as published", "", NULL},
};
const struct catalog turning_catalog = CATALOG("treatment of turning points", turning_rows);

static const struct row pager_rows[] = {
    [PAGER_OFF] = {"off", "", "the terminal scrolls", "", NULL},
    [PAGER_ON] = {"on", "", "runs $PAGER, or less, with it; can be set only at a prompt", "", NULL},
};
static const struct catalog pager_catalog = CATALOG("kind of paging", pager_rows);

static const struct row opinion_rows[] = {
    [OPINIONS_AUTO] = {"auto", "", "a second solution, with up to a quarter of the run's work", "",
                       NULL},
    [OPINIONS_FULL] = {"full", "", "a second solution to the end, at any cost", "", NULL},
    [OPINIONS_WARN] =
        {"warn", "",
         "like auto, but a run without a correct digit is a warning, not an error (chaos)", "",
         NULL},
    [OPINIONS_OFF] = {"off", "", "none", "", NULL},
};
const struct catalog opinion_catalog = CATALOG("kind of second opinion", opinion_rows);

static const struct row record_rows[] = {
    [RECORD_AUTO] = {"auto", "", "every step; very long runs are decimated, but keep their peaks",
                     "", NULL},
    [RECORD_ALL] = {"all", "", "every step, if memory suffices", "", NULL},
    [RECORD_EVERY] =
        {"every", "",
         "every N: every N-th step; every TIME: at even times, interpolated within steps", "",
         NULL},
};
static const struct catalog record_catalog = CATALOG("rule", record_rows);

static const struct catalog sums_catalog = CATALOG("kind of sum", sums_rows);

static const struct catalog view_choice_catalog = CATALOG("kind of view", view_rows);

static const struct row phase_rows[] = {
    [PHASE_SCALED] = {"scaled", "",
                      "v/omega0 in the unit of y, so that a conservative motion is a circle", "",
                      NULL},
    [PHASE_RAW] = {"raw", "", "v", "", NULL},
};
const struct catalog phase_axes_catalog = CATALOG("kind of axes", phase_rows);

/* Reads the tolerance, or off (0). Returns false with the error set. */
static bool parse_tol(struct settings *settings, struct text value, struct error *error)
{
    double tol;
    if (text_is(value, "off")) {
        settings->tol = 0;
        return true;
    }
    if (real_parse(value, &tol) != REAL_OK || !(tol > 0 && tol < 1)) {
        error_at(error, value, "tol must be a number between 0 and 1, or off");
        return error_hint(error, "for example tol = 1e-8");
    }
    settings->tol = tol;
    return true;
}

/* Appends the tolerance that is really used if tol is below rounding. */
void put_tol_floor(struct buffer *text, double tol)
{
    const double floor = 10 * DBL_EPSILON;
    if (tol > 0 && tol < floor)
        buffer_format(text, " (below rounding: %.2g is used)", floor);
}

/* Appends the tolerance as parse_tol() reads it. */
static void show_tol(const struct settings *settings, struct buffer *text)
{
    if (settings->tol > 0)
        buffer_real(text, settings->tol);
    else
        buffer_put(text, TEXT("off"));
}

/* Reads the rule by which rows are recorded: auto, all, every N steps, or every TIME with its unit.
 * Returns false with the error set. */
static bool parse_record(struct settings *settings, struct text value, struct error *error)
{
    struct text word = peek_word(value, "");
    struct text rest = text_trim(text_after(value, word.len));
    double every;
    if (rest.len == 0 && (text_is(word, "auto") || text_is(word, "all"))) {
        settings->record =
            (struct recording_rule){text_is(word, "all") ? RECORD_ALL : RECORD_AUTO, 1, 0};
        return true;
    }
    if (text_is(word, "every") && real_parse(rest, &every) == REAL_OK && every >= 1 &&
        every <= 1e15 && every == floor(every)) {
        settings->record = (struct recording_rule){RECORD_EVERY, (int64_t)every, 0};
        return true;
    }
    const struct text number = peek_word(rest, ""),
                      unit_text = {rest.data + number.len, rest.len - number.len};
    const struct unit *unit = unit_find(text_trim(unit_text));
    double time;
    if (text_is(word, "every") && real_parse(number, &every) == REAL_OK && unit &&
        unit->quantity == QUANTITY_TIME && unit_convert(unit, QUANTITY_TIME, every, &time) &&
        time > 0 && time <= 1e300) {
        settings->record = (struct recording_rule){RECORD_TIMES, 1, time};
        return true;
    }
    error_at(error, value, "record must be auto, all, every N (steps), or every TIME");
    return error_hint(error, "for example: set record every 10; set record every 0.1 s");
}

/* Appends the rule as parse_record() reads it. */
static void show_record(const struct settings *settings, struct buffer *text)
{
    if (settings->record.rule == RECORD_EVERY)
        buffer_format(text, "every %lld", (long long)settings->record.every);
    else if (settings->record.rule == RECORD_TIMES) {
        buffer_put(text, TEXT("every "));
        buffer_real(text, settings->record.interval);
        buffer_put(text, TEXT(" s"));
    } else
        buffer_put(text, settings->record.rule == RECORD_ALL ? TEXT("all") : TEXT("auto"));
}

/* Reads the size of plots as WIDTHxHEIGHT [cell], or auto (0x0). Returns false with the error
 * set. */
static bool parse_size(struct settings *settings, struct text value, struct error *error)
{
    struct text rest = value, width;
    double w, h;
    if (text_is(value, "auto")) {
        settings->width = settings->height = 0;
        return true;
    }
    if (!text_split(&rest, 'x', &width) || real_parse(width, &w) != REAL_OK ||
        real_parse(rest, &h) != REAL_OK || w < 1 || h < 1 || w > 1000 || h > 1000 ||
        w != floor(w) || h != floor(h))
        return error_at(error, value,
                        "size must be WIDTHxHEIGHT in characters from 1x1 to 1000x1000, or auto");
    settings->width = (int)w;
    settings->height = (int)h;
    return true;
}

/* Appends the size as parse_size() reads it. */
static void show_size(const struct settings *settings, struct buffer *text)
{
    if (settings->width > 0)
        buffer_format(text, "%dx%d", settings->width, settings->height);
    else
        buffer_put(text, TEXT("auto"));
}

/* Reads the number of significant digits. Returns false with the error set. */
static bool parse_digits(struct settings *settings, struct text value, struct error *error)
{
    double digits;
    if (real_parse(value, &digits) != REAL_OK || digits < 1 || digits > 17 ||
        digits != floor(digits))
        return error_at(error, value, "digits must be a whole number from 1 to 17");
    settings->digits = (int)digits;
    return true;
}

static void show_digits(const struct settings *settings, struct buffer *text)
{
    buffer_format(text, "%d", settings->digits);
}

/* Reads the frame rate of the live view. Returns false with the error set. */
static bool parse_fps(struct settings *settings, struct text value, struct error *error)
{
    double fps;
    if (real_parse(value, &fps) != REAL_OK || !(fps >= 0.1 && fps <= 60))
        return error_at(error, value, "fps must be a number from 0.1 to 60 frames per second");
    settings->fps = fps;
    return true;
}

static void show_fps(const struct settings *settings, struct buffer *text)
{
    buffer_real(text, settings->fps);
}

#define FIELD(name) offsetof(struct settings, name), .bytes = sizeof((struct settings *)0)->name
#define FIELDS(first, count)                                                                       \
    offsetof(struct settings, first), .bytes = (count) * sizeof((struct settings *)0)->first
#define BRIEF(name, unit, brief)                                                                   \
    {                                                                                              \
        name, unit, brief, "", NULL                                                                \
    }

#define MODULE_CATALOGS
#include "lists/settings.def"
#undef MODULE_CATALOGS

/* Indices of the settings of modules in of_modules of struct settings. */
enum {
#define MODULE_SETTING(name, ...) MODULE_SETTING_##name,
#include "lists/settings.def"
#undef MODULE_SETTING
    MODULE_SETTINGS
};
_Static_assert(MODULE_SETTINGS <= COUNT_OF(((struct settings *)0)->of_modules),
               "of_modules holds the settings of all modules");

static const struct setting settings_rows[] = {
#define SETTING(type, field, initial, ...) {.offset = FIELD(field), __VA_ARGS__},
#define SETTING_PAIR(type, field, second, initial, ...) {.offset = FIELDS(field, 2), __VA_ARGS__},
#include "session/settings.def"
#define MODULE_SETTING(name, ...) {.offset = FIELD(of_modules[MODULE_SETTING_##name]), __VA_ARGS__},
#include "lists/settings.def"
#undef MODULE_SETTING
};
const struct catalog setting_catalog = CATALOG("setting", settings_rows);

const struct setting *setting_by_name(struct text name)
{
    return (const struct setting *)(const void *)catalog_find(&setting_catalog, name);
}

int setting_of_module(const struct settings *settings, const char *name)
{
    const struct setting *setting = setting_by_name(text_of(name));
    assert(setting && setting->choices);
    return *(const int *)(const void *)((const char *)settings + setting->offset);
}

const struct setting *setting_at(size_t i)
{
    return (const struct setting *)(const void *)catalog_row(&setting_catalog, i);
}

const struct setting *setting_from(const struct row *row)
{
    return (const struct setting *)(const void *)row;
}

bool setting_same(const struct setting *setting, const struct settings *a, const struct settings *b)
{
    return memcmp((const char *)a + setting->offset, (const char *)b + setting->offset,
                  setting->bytes) == 0;
}

void setting_copy(const struct setting *setting, const struct settings *source,
                  struct settings *target)
{
    memcpy((char *)target + setting->offset, (const char *)source + setting->offset,
           setting->bytes);
}

/* Copies the settings of how results look from source. */
void settings_display(struct settings *settings, const struct settings *source)
{
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = &settings_rows[i];
        if (setting->display)
            setting_copy(setting, source, settings);
    }
}

/* Sets all settings to those of a new session. */
void session_default_settings(struct settings *settings)
{
    *settings = (struct settings){
#define SETTING(type, field, initial, ...) .field = initial,
#define SETTING_PAIR(type, field, second, initial, ...) .field = initial, .second = initial,
#include "session/settings.def"
    };
}

/* Returns the flag that the user has set the setting; NULL if the setting has none. */
static bool *chosen_flag(const struct setting *setting, struct settings *settings)
{
    return setting->chosen ? (bool *)(void *)((char *)settings + setting->chosen) : NULL;
}

bool setting_is_chosen(const struct setting *setting, const struct settings *settings)
{
    return !setting->chosen ||
           *(const bool *)(const void *)((const char *)settings + setting->chosen);
}

void setting_choose(const struct setting *setting, bool chosen, struct settings *settings)
{
    bool *flag = chosen_flag(setting, settings);
    if (flag)
        *flag = chosen;
}

/* Sets duration and tolerance by the preset, unless the user has set them. */
void settings_of_scene(struct settings *settings, const struct preset *preset)
{
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = &settings_rows[i];
        if (!setting->natural || setting_is_chosen(setting, settings))
            continue;
        const double value = setting->natural(preset);
        memcpy((char *)settings + setting->offset, &value, sizeof value);
    }
}

/* Returns the row of the present choice, or NULL if the setting has no plain choices. */
const struct row *setting_choice(const struct setting *setting, const struct settings *settings)
{
    int index;
    if (!setting->choices || setting->parse)
        return NULL;
    memcpy(&index, (const char *)settings + setting->offset, sizeof index);
    return catalog_row(setting->choices, (size_t)index);
}

/* Appends the value, exactly or with the digits that are shown. */
static void put_setting(const struct setting *setting, const struct settings *settings, bool exact,
                        struct buffer *text)
{
    if (setting->show) {
        setting->show(settings, text);
    } else if (setting->choices) {
        buffer_put(text, text_of(setting_choice(setting, settings)->name));
    } else {
        double value;
        memcpy(&value, (const char *)settings + setting->offset, sizeof value);
        if (exact)
            buffer_exact(text, (struct measured){value, 0}, setting->quantity);
        else
            buffer_measured(text, (struct measured){value, 0}, setting->quantity, settings->digits);
    }
}

void setting_show(const struct setting *setting, const struct settings *settings,
                  struct buffer *text)
{
    put_setting(setting, settings, false, text);
}

void setting_exact(const struct setting *setting, const struct settings *settings,
                   struct buffer *text)
{
    put_setting(setting, settings, true, text);
}
