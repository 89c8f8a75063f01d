/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Chooses the columns of time and value: those that are named, else by names, units and numbers. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include "modules/recording/table/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Names of columns, in several languages: times, row numbers, positions. */
#define TIME_WORDS "t time times zeit tiempo tempo temps tid elapsed timestamp x_value"
#define INDEX_WORDS "sample samples sampleid index idx frame nr no"
#define PLACE_WORDS                                                                                \
    "x y s z pos position distance dist displacement height weg ort abstand auslenkung distancia " \
    "posicion posición "                                                                          \
    "desplazamiento posizione spostamento distanza elongation hauteur"
#define SIZE_WORDS "absolute magnitude total" /* magnitudes of vectors, which hide the sign */
#define TIME_STEPS_UP_MIN 0.9                 /* least share of rising steps in a column of times */

/* Statistics of the numbers of a column. */
struct profile {
    size_t numbers;
    double low, high, variance;
    /* shares of steps that are > 0, < 0, exactly 1, near the mean step */
    double rising, falling, by_one, even;
    bool ahead; /* the last number is above the first */
    bool whole; /* all are whole numbers */
};

/* A profile is a guess, taken from stretches of STRETCH_ROWS rows of a long recording. */
#define STRETCH_ROWS 1024u
#define STRETCHES_MAX 256u

static size_t row_after(size_t row, size_t rows)
{
    const size_t stride = rows / (STRETCH_ROWS * STRETCHES_MAX) + 1;
    return (row + 1) % STRETCH_ROWS == 0 ? row + 1 + (stride - 1) * STRETCH_ROWS : row + 1;
}

/* Computes the statistics of a column; NAN cells are skipped. */
static struct profile profile_of(const struct recording *recording, const double *value)
{
    struct profile p = {.low = HUGE_VAL, .high = -HUGE_VAL, .whole = true};
    double mean = 0, squares = 0, previous = NAN, first = NAN, climbed = 0;
    size_t rising = 0, falling = 0, by_one = 0, even = 0, counted = 0;
    for (size_t i = 0; i < recording->rows; i = row_after(i, recording->rows)) {
        const double x = value[i];
        previous = i % STRETCH_ROWS == 0 ? NAN : previous;
        if (!isfinite(x))
            continue;
        const double apart = x - mean; /* Welford 1962 */
        mean += apart / (double)++p.numbers;
        squares += apart * (x - mean);
        p.low = x < p.low ? x : p.low;
        p.high = x > p.high ? x : p.high;
        p.whole = p.whole && x == floor(x);
        rising += x > previous;
        falling += x < previous;
        by_one += x - previous == 1;
        climbed += isnan(previous) ? 0 : x - previous;
        counted += isnan(previous) ? 0 : 1;
        first = p.numbers == 1 ? x : first;
        previous = x;
    }
    p.ahead = previous > first;
    const double steps = counted > 0 ? (double)counted : 1, step = climbed / steps;
    previous = NAN;
    for (size_t i = 0; i < recording->rows; i = row_after(i, recording->rows)) {
        previous = i % STRETCH_ROWS == 0 ? NAN : previous;
        if (isfinite(value[i])) {
            even += fabs(value[i] - previous - step) <= 0.5 * step;
            previous = value[i];
        }
    }
    p.variance = p.numbers > 1 ? squares / (double)(p.numbers - 1) : 0;
    p.rising = (double)rising / steps;
    p.falling = (double)falling / steps;
    p.by_one = (double)by_one / steps;
    p.even = (double)even / steps;
    return p;
}

static bool profile_rises(const struct profile *p)
{
    return p->numbers > 1 && p->ahead && p->rising >= TIME_STEPS_UP_MIN;
}

static bool is_constant(const struct profile *p)
{
    return !(p->high > p->low);
}

static bool is_time(const struct column *column)
{
    return column->quantity == QUANTITY_TIME ||
           (column->quantity == QUANTITY_OTHER && name_has_word(column->name, TIME_WORDS));
}

static bool is_unnamed(const struct column *column, int i)
{
    char plain[LIMIT_NAME + 1];
    snprintf(plain, sizeof plain, "column %d", i + 1);
    return !strcmp(column->name, plain);
}

/* Returns true if column i numbers the rows. */
static bool is_index(const struct recording *recording, const struct profile *p, int i)
{
    const struct column *column = &recording->column[i];
    /* The only column is what was recorded, even if it counts. */
    return recording->columns > 1 && p->whole && profile_rises(p) &&
           p->by_one >= TIME_STEPS_UP_MIN && !is_time(column) &&
           (name_has_word(column->name, INDEX_WORDS) ||
            (i == 0 && is_unnamed(column, i) && (p->low == 0 || p->low == 1)));
}

/* Returns true if column i belongs to the chosen run, to all runs, or if none is chosen. */
static bool in_run(const struct recording *recording, int i)
{
    const int run = recording->column[i].run;
    return run < 0 || recording->taken < 0 || run == recording->taken;
}

/* ---- what the user says ---- */

static void list_columns(const struct recording *recording, struct error *error)
{
    struct buffer names = {0};
    for (int i = 0; i < recording->columns && names.len < 200; i++)
        buffer_format(&names, "%s%d %s", i ? ", " : "", i + 1, recording->column[i].name);
    error_hint(error, "columns: %s%s", buffer_view(&names), names.len >= 200 ? ", …" : "");
    buffer_free(&names);
}

static bool starts_with(const char *name, struct text wanted)
{
    return strlen(name) >= wanted.len && strncasecmp(name, wanted.data, wanted.len) == 0;
}

/* Returns how many columns `wanted` may mean, by name, number from 1 or, within the run, by the
 * beginning of its name with or without the run's; sets *column to the last of them. */
static int match_column(const struct recording *recording, struct text wanted, int *column)
{
    struct text name = text_trim(wanted);
    double number;
    int found = 0;
    if (name.len >= 2 && strchr("'\"", name.data[0]) && name.data[name.len - 1] == name.data[0])
        name = (struct text){name.data + 1, name.len - 2};
    for (int i = 0; i < recording->columns; i++)
        if (strlen(recording->column[i].name) == name.len &&
            starts_with(recording->column[i].name, name)) {
            *column = i;
            return 1;
        }
    if (real_parse(name, &number) == REAL_OK && number >= 1 && number <= recording->columns &&
        number == floor(number)) {
        *column = (int)number - 1;
        return 1;
    }
    for (int i = 0; i < recording->columns && name.len > 0; i++) {
        const struct column *one = &recording->column[i];
        /* "Run 1: " */
        const size_t prefix_len = one->run >= 0 ? strlen(recording->run[one->run].name) + 2 : 0;
        if (in_run(recording, i) &&
            (starts_with(one->name, name) || (prefix_len > 0 && prefix_len < strlen(one->name) &&
                                              starts_with(one->name + prefix_len, name)))) {
            *column = i;
            found++;
        }
    }
    return found;
}

/* Sets *column to the column meant by `wanted`. Returns false with the error unless it is one. */
static bool find_column(const struct recording *recording, struct text wanted, int *column,
                        struct error *error)
{
    char shown[SHORT_NAME];
    const int found = match_column(recording, wanted, column);
    if (found == 1 && in_run(recording, *column))
        return true;
    if (found == 1) {
        error_at(error, wanted, "column '%s' does not belong to %s",
                 recording->column[*column].name, recording->run[recording->taken].name);
        return error_hint(error, "give the run or the column, not both");
    }
    error_at(error, wanted, "%s column '%s'", found ? "more than one" : "there is no",
             short_name(text_trim(wanted), shown));
    list_columns(recording, error);
    return false;
}

/* ---- what the file says ---- */

/* Chooses the column of values, constant ones only if `flat`. Returns false if there is none. */
static bool quantity_column_pick(struct recording *recording, const struct profile *profile,
                                 bool flat)
{
    static const enum quantity order[] = {QUANTITY_LENGTH,
                                          QUANTITY_OTHER,
                                          QUANTITY_ANGLE,
                                          QUANTITY_VELOCITY,
                                          QUANTITY_ANGULAR_FREQUENCY,
                                          QUANTITY_ACCELERATION};
    int best = -1;
    size_t best_rank = COUNT_OF(order) + 3;
    for (int i = 0; i < recording->columns; i++) {
        const struct column *column = &recording->column[i];
        if (i == recording->time || !in_run(recording, i) || profile[i].numbers < 2 ||
            is_time(column) || is_index(recording, &profile[i], i) ||
            name_has_word(column->name, ERROR_WORDS) || is_constant(&profile[i]) != flat)
            continue;
        const enum quantity quantity =
            column->quantity == QUANTITY_VOLTAGE ? QUANTITY_OTHER : column->quantity;
        size_t rank = 0;
        while (rank < COUNT_OF(order) && order[rank] != quantity)
            rank++;
        if ((quantity == QUANTITY_OTHER && !name_has_word(column->name, PLACE_WORDS)) ||
            name_has_word(column->name, SIZE_WORDS))
            rank = COUNT_OF(order) + 1;
        /* Values in the first rows only were typed into the table. */
        if (rank > COUNT_OF(order) && 2 * profile[i].numbers < recording->rows)
            rank++;
        /* The first position is chosen; of accelerations and others the one that moves most. */
        if (rank < best_rank ||
            (rank == best_rank && rank > 1 && profile[i].variance > profile[best].variance)) {
            best = i;
            best_rank = rank;
        }
    }
    recording->value = best;
    return best >= 0;
}

/* Returns the time column nearest to the left of the value, else the first, or -1; in the run if
 * `own`. */
static int time_among(const struct recording *recording, const struct profile *profile, bool own)
{
    int first = -1, left = -1;
    for (int i = 0; i < recording->columns; i++) {
        /* Coarse clocks repeat themselves; one that mostly goes back is none. */
        if (!is_time(&recording->column[i]) || !profile[i].ahead ||
            profile[i].falling > 1 - TIME_STEPS_UP_MIN || (own && !in_run(recording, i)))
            continue;
        first = first < 0 ? i : first;
        left = i < recording->value ? i : left;
    }
    return left >= 0 ? left : first;
}

/* Returns true if the newest row comes first: a time falls and none rises. */
static bool runs_backwards(const struct recording *recording, const struct profile *profile)
{
    bool falls = false;
    for (int i = 0; i < recording->columns; i++) {
        if (!is_time(&recording->column[i]) || profile[i].numbers < 3)
            continue;
        if (profile[i].ahead)
            return false;
        falls |= profile[i].falling >= TIME_STEPS_UP_MIN;
    }
    return falls;
}

/* Returns the time column of the run, else that of another run; -1 if there is none. */
static int time_column(const struct recording *recording, const struct profile *profile)
{
    const int own = time_among(recording, profile, true);
    return own >= 0 ? own : time_among(recording, profile, false);
}

/* Returns true if column i could be the time although neither its name nor its unit tells so. */
static bool could_be_time(const struct recording *recording, const struct profile *profile, int i)
{
    const struct column *column = &recording->column[i];
    return in_run(recording, i) && column->quantity == QUANTITY_OTHER && !column->unit[0] &&
           profile[i].numbers > 0 && !is_index(recording, &profile[i], i) &&
           !name_has_word(column->name, PLACE_WORDS " " ERROR_WORDS);
}

/* Returns the only column whose numbers look like a clock, or -1 if there is none or several. */
static int only_clock(const struct recording *recording, const struct profile *profile)
{
    static bool (*const is_clock[])(const double *, size_t) = {rises_evenly, is_along_line};
    for (size_t pass = 0; pass < COUNT_OF(is_clock); pass++) {
        int found = -1, count = 0;
        for (int i = 0; i < recording->columns; i++)
            if (could_be_time(recording, profile, i) &&
                is_clock[pass](recording->column[i].value, recording->rows)) {
                found = i;
                count++;
            }
        if (count > 0)
            return count == 1 ? found : -1;
    }
    return -1;
}

/* Guesses the time if no column is named so: the first if it rises, the second after row numbers,
 * else the only one that looks like a clock. Returns -1 if none does. */
static int guessed_time(const struct recording *recording, const struct profile *profile)
{
    const int index = recording->columns > 2 && is_index(recording, profile, 0) ? 1 : 0;
    const struct column *first = &recording->column[index];
    const bool could = recording->columns > 1 && in_run(recording, index) &&
                       first->quantity == QUANTITY_OTHER && profile_rises(&profile[index]) &&
                       !is_index(recording, &profile[index], index);
    if (could && ((index == 0 && is_unnamed(first, 0)) || profile[index].even >= TIME_STEPS_UP_MIN))
        return index;
    return recording->columns > 1 && !(recording->header_rate > 0) ? only_clock(recording, profile)
                                                                   : -1;
}

static int index_column(const struct recording *recording, const struct profile *profile)
{
    for (int i = 0; i < recording->columns; i++)
        if (recording->columns > 1 && in_run(recording, i) && is_index(recording, &profile[i], i))
            return i;
    return -1;
}

/* Sets the error of a recording without a time column. Returns false. */
static bool no_time(const struct recording *recording, const struct profile *profile,
                    struct error *error)
{
    for (int i = 0; i < recording->columns; i++)
        if (is_time(&recording->column[i]) && profile[i].numbers > 1) {
            error_set(error, ERROR_IO,
                      "the times in column '%s' do not increase (%.0f %% of the steps go back)",
                      recording->column[i].name, 100 * profile[i].falling);
            return error_hint(error, "give t=COLUMN, or the sampling rate, for example rate=100");
        }
    bool counts = index_column(recording, profile) >= 0;
    error_set(error, ERROR_IO,
              "no time column%s; give the sampling rate, for example load FILE rate=100",
              counts ? " (the file has sample numbers)" : "");
    list_columns(recording, error);
    return false;
}

/* Chooses the time column, or the sampling rate, and sets recording->source. */
static bool choose_time(struct recording *recording, const struct profile *profile,
                        const struct load_options *options, struct error *error)
{
    recording->source = options->rate > 0 ? TIME_INDEX : TIME_COLUMN;
    if (options->time.len > 0)
        return find_column(recording, options->time, &recording->time, error);
    int named = time_column(recording, profile);
    if (options->rate > 0) {
        if (named >= 0)
            recording_warn(recording, "rate= is used instead of the time column '%s'",
                           recording->column[named].name);
        recording->time = index_column(recording, profile);
        if (recording->time >= 0 &&
            count_wraps(recording->column[recording->time].value, recording->rows))
            recording->time = -1;
        recording->source = recording->time >= 0 ? TIME_INDEX : TIME_RATE;
        return true;
    }
    recording->time = named >= 0 ? named : guessed_time(recording, profile);
    if (recording->header_rate > 0 && (recording->time < 0 || recording->header_rules)) {
        recording->time = recording->header_rules ? -1 : index_column(recording, profile);
        recording->source = recording->time >= 0 ? TIME_INDEX : TIME_RATE;
        recording_warn(
            recording,
            "the times are computed from the sampling rate in the file's header, %.6g Hz",
            recording->header_rate);
        return true;
    }
    if (recording->time < 0)
        return no_time(recording, profile, error);
    if (!in_run(recording, recording->time))
        recording_warn(recording, "%s has no times; those of '%s' are used",
                       recording->run[recording->taken].name,
                       recording->column[recording->time].name);
    if (named < 0)
        recording_warn(recording,
                       "%s increases and is taken as the time; t=COLUMN chooses another column",
                       recording->column[recording->time].name);
    return true;
}

/* Chooses the column of values: the named one, else the likeliest. */
static bool choose_value(struct recording *recording, const struct profile *profile,
                         const struct load_options *options, struct error *error)
{
    if (options->value.len > 0)
        return find_column(recording, options->value, &recording->value, error);
    if (!quantity_column_pick(recording, profile, false) &&
        !quantity_column_pick(recording, profile, true)) {
        error_set(error, ERROR_IO, "no column of values was found; choose one with y=COLUMN");
        list_columns(recording, error);
        return false;
    }
    return true;
}

static bool side_by_side(const struct recording *recording)
{
    for (int i = 0; i < recording->columns; i++)
        if (recording->column[i].run >= 0)
            return true;
    return false;
}

/* Chooses among runs side by side: the requested one, the named column's, or the first with
 * values. */
static bool choose_run(struct recording *recording, const struct profile *profile,
                       const struct load_options *options, struct error *error)
{
    int column = -1;
    if (!side_by_side(recording)) /* runs below each other are found from the times */
        return true;
    recording->taken = -1;
    if (options->run.len > 0)
        return run_find(recording, options->run, &recording->taken, error);
    if (options->value.len > 0 && match_column(recording, options->value, &column) == 1)
        recording->taken = recording->column[column].run;
    for (int i = 0; i < recording->columns && recording->taken < 0; i++)
        if (profile[i].numbers > 1 && !is_time(&recording->column[i]))
            recording->taken = recording->column[i].run;
    return true;
}

/* Drops the empty cells in which a run ends that is shorter than its neighbours. */
static void cut_run(struct recording *recording)
{
    const double *value = recording->column[recording->value].value,
                 *time = recording->source == TIME_COLUMN && in_run(recording, recording->time)
                             ? recording->column[recording->time].value
                             : value;
    while (side_by_side(recording) && recording->rows > 0 && isnan(value[recording->rows - 1]) &&
           isnan(time[recording->rows - 1]))
        recording->rows--;
}

int recording_clock(const struct recording *recording)
{
    for (int i = 0; i < recording->columns; i++)
        if (is_time(&recording->column[i]))
            return i;
    return recording->columns > 1 && is_unnamed(&recording->column[0], 0) ? 0 : -1;
}

int recording_counter(struct recording *recording)
{
    struct profile *profile =
        arena_array(&recording->arena, (size_t)recording->columns, sizeof *profile);
    for (int i = 0; profile && i < recording->columns; i++)
        profile[i] = profile_of(recording, recording->column[i].value);
    return profile ? index_column(recording, profile) : -1;
}

bool recording_choose(struct recording *recording, const struct load_options *options,
                      struct error *error)
{
    if (!enough_rows(recording, error))
        return false;
    struct profile *profile =
        arena_array(&recording->arena, (size_t)recording->columns, sizeof *profile);
    if (!profile)
        return error_memory(error);
    unwrap_clock(recording, recording_clock(recording));
    for (int i = 0; i < recording->columns; i++) {
        if (cancelled(recording->cancel))
            return error_set(error, ERROR_CANCELLED, "reading was stopped");
        profile[i] = profile_of(recording, recording->column[i].value);
    }
    if (runs_backwards(recording, profile)) {
        recording_reverse(recording);
        for (int i = 0; i < recording->columns; i++)
            profile[i] = profile_of(recording, recording->column[i].value);
    }
    if (!choose_run(recording, profile, options, error))
        return false;
    /* The value is chosen first, as it decides between runs; a guessed time is then not taken as
     * value. */
    recording->time = guessed_time(recording, profile);
    if (time_column(recording, profile) >= 0 || options->rate > 0)
        recording->time = -1;
    if (options->time.len > 0 && !find_column(recording, options->time, &recording->time, error))
        return false;
    if (options->rate > 0 && options->value.len == 0 && options->time.len == 0)
        recording->time = index_column(recording, profile);
    if (!choose_value(recording, profile, options, error) ||
        !choose_time(recording, profile, options, error))
        return false;
    if (recording->time == recording->value)
        return error_set(error, ERROR_COMMAND, "column '%s' cannot be both the time and the value",
                         recording->column[recording->value].name);
    const struct column *value = &recording->column[recording->value];
    if (profile[recording->value].numbers == 0)
        return error_set(error, ERROR_IO, "column '%s' has no numbers", value->name);
    cut_run(recording);
    if (is_constant(&profile[recording->value]))
        recording_warn(recording, "%s has the same value in every row", value->name);
    return true;
}
