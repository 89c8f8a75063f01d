/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command basins: reads the grid of starts, and replies attractors, their shares and a map in
 * letters. */
#ifndef COMMAND_ROWS
#include <hooke/base/unit.h>
#include <hooke/run/timing.h>
#include <hooke/report.h>
#include <hooke/scene/poles.h>
#include "modules/dynamics/chaos.h"
#include <hooke/language/grid.h>
#include "modules/dynamics/handlers.h"

#include <math.h>
#include <stdio.h>

#define MAP_ROWS 20    /* largest number of rows of a map */
#define MAP_ROWS_MIN 5 /* rows that a map has even in a short answer */
#define MAP_COLUMNS 64 /* largest number of columns of a map */

/* All that the answer is written from. */
struct map {
    const struct basins_request *request;
    const struct basins *basins;
    const struct system *system;
    int answer, width; /* [row] [cell] room for the answer; answer is 0 if all is to be shown */
    bool timed;        /* run times are shown */
};

/* ---- the two axes ---- */

/* Reads one argument NAME=FROM:TO:STEP into request->axis[axis]. Returns false with *error. */
static bool read_side(struct session *session, const struct arguments *args, struct text argument,
                      const struct system *system, struct basins_request *request, int axis,
                      struct error *error)
{
    struct parser parser = {session, args->scope, args->arena, argument};
    const int i = read_variable(&parser, argument, system, "basins", "-2:2:0.1", error);
    if (i < 0)
        return false;
    if (axis == 2)
        return error_at(error, argument, "basins need two variables");
    if (axis == 1 && request->axis[0].variable == i)
        return error_at(error, argument, "'%s' is given twice", system->model->variable[i].name);
    const struct variable variable = system_variable(system, i);
    struct value_grid range = {.quantity = variable.quantity};
    snprintf(range.name, sizeof range.name, "%s", variable.name);
    if (!parse_grid(&parser, &range, error))
        return false;
    if (range.log)
        return error_at(error, argument, "%s: starts must be in equal steps", variable.name);
    request->axis[axis].variable = i;
    request->axis[axis].low = range.first;
    request->axis[axis].high = range.last;
    request->axis[axis].count = range.count;
    return true;
}

enum { CANCEL_ROWS = 65536 }; /* number of rows between two looks at Ctrl-C */

/* Largest table of a search that was stopped: more rows would keep the user waiting. */
static const int64_t stopped_table_rows_max = 400000;

/* ---- what is said ---- */

/* Returns the character of a fate on the map: A to Z for attractors. */
static char fate_letter(int fate)
{
    if (fate >= 0)
        return (char)('A' + fate);
    if (fate == BASIN_ESCAPES)
        return '.';
    return fate == BASIN_UNDECIDED ? '?' : ' ';
}

/* Appends the map, at most MAP_COLUMNS wide and `max` rows high, with its axes. Axis 0 goes to the
 * right, axis 1 up, hence the last row first. Each letter is the fate of one start; if the grid has
 * more starts than the map has places, only starts at equal distances are shown. */
static void put_map(struct buffer *output, const struct map *map, int max)
{
    const int x_count = map->request->axis[0].count, y_count = map->request->axis[1].count;
    const int columns = int_min(x_count, MAP_COLUMNS), rows = int_min(y_count, max);
    for (int r = rows - 1; r >= 0; r--) {
        const int64_t b = rows > 1 ? (int64_t)r * (y_count - 1) / (rows - 1) : 0;
        buffer_format(output, "%10.4g ", basins_value(map->request, 1, b));
        for (int c = 0; c < columns; c++) {
            const int64_t a = columns > 1 ? (int64_t)c * (x_count - 1) / (columns - 1) : 0;
            buffer_char(output, fate_letter(map->basins->fate[a * y_count + b]));
        }
        buffer_char(output, '\n');
    }
    buffer_format(output, "%10s %-*.4g%.4g  %s, %s up\n", "", columns > 10 ? columns - 4 : 8,
                  map->request->axis[0].low, map->request->axis[0].high,
                  system_variable(map->system, map->request->axis[0].variable).name,
                  system_variable(map->system, map->request->axis[1].variable).name);
}

static const char *const kind_name[] = {"equilibrium", "orbit", "response", "irregular"};

/* Appends a line about attractor k: its share of the starts, its kind and a state on it. */
static void put_basin(struct buffer *output, const struct map *map, int k)
{
    const struct basin *b = &map->basins->basin[k];
    const double share = 100.0 * (double)b->count / (double)map->basins->finished,
                 error = 100 * basins_error(b->count, map->basins->finished);
    buffer_format(output, "  %c  %.4g +- %.2g %%  %s", fate_letter(k), share, error,
                  kind_name[b->kind]);
    if (b->multiple > 0)
        buffer_format(output, " of %d period%s of the drive", b->multiple, plural_s(b->multiple));
    else if (b->period > 0)
        buffer_format(output, " of period %s", SHOWN_QUANTITY(b->period, QUANTITY_TIME, 7));
    buffer_put(output, b->kind == BASIN_EQUILIBRIUM ? TEXT(" at ") : TEXT(" through "));
    for (int i = 0; i < map->system->n; i++) {
        buffer_put(output, i > 0 ? TEXT(", ") : TEXT(""));
        put_variable(output, map->system, i, b->state[i], 6);
    }
    if (b->kind == BASIN_IRREGULAR)
        buffer_put(output, TEXT(", does not repeat"));
    else
        buffer_format(output, ", %s",
                      b->stable ? "stable" : "unstable (reached only from special starts)");
    buffer_char(output, '\n');
}

/* Appends the whole answer: attractors, other fates, map, effort. If the room is limited (to
 * map->answer rows, 0 if not), the map gets the rows that the text leaves, from MAP_ROWS_MIN to
 * MAP_ROWS. */
static void put_basins(struct buffer *output, const struct map *map)
{
    enum { BELOW = 3 /* [row] lines below the map: its axis, and the effort */ };
    const struct basins *b = map->basins;
    buffer_format(output, "%d attractor%s of %lld starts\n", b->count, b->count == 1 ? "" : "s",
                  (long long)b->finished);
    for (int k = 0; k < b->count; k++)
        put_basin(output, map, k);
    if (b->escaping > 0)
        buffer_format(output, "  .  %.4g %%  escapes\n",
                      100.0 * (double)b->escaping / (double)b->finished);
    if (b->undecided > 0)
        buffer_format(output, "  ?  %.4g %%  not decided\n",
                      100.0 * (double)b->undecided / (double)b->finished);
    int max =
        map->answer ? map->answer - text_rows(buffer_text(output), map->width) - BELOW : MAP_ROWS;
    put_map(output, map, int_min(int_max(max, MAP_ROWS_MIN), MAP_ROWS));
    buffer_format(output, "checked every %s", SHOWN_QUANTITY(b->strobe, QUANTITY_TIME, 6));
    if (b->steps > 0)
        buffer_format(output, " by %d steps of rk4, %lld evaluations", b->steps,
                      4 * b->steps * (long long)b->checks);
    else
        buffer_format(output, ", %lld checks", (long long)b->checks);
    buffer_format(output, map->timed ? ", %d thread%s, %.3g s" : ", %d thread%s", b->threads,
                  plural_s(b->threads), b->seconds);
}

/* Adds the record of attractor k. */
static void reply_basin(struct reply *reply, const struct map *map, int k)
{
    const struct basin *b = &map->basins->basin[k];
    const char name[2] = {fate_letter(k), 0};
    reply_begin(reply, "basin");
    reply_string(reply, "attractor", name);
    reply_real(reply, "share", (double)b->count / (double)map->basins->finished);
    reply_real(reply, "uncertainty", basins_error(b->count, map->basins->finished));
    reply_int(reply, "count", b->count);
    reply_string(reply, "type", kind_name[b->kind]);
    reply_quantity(reply, "period", b->kind == BASIN_EQUILIBRIUM ? NAN : b->period, "s");
    reply_bool(reply, "stable", b->stable);
    reply_real(reply, "growth", b->growth);
    reply_state(reply, map->system, "state", b->state);
    reply_end(reply);
}

/* Adds a record for starts that reach no attractor, unless there are none. */
static void reply_other_fate(struct reply *reply, const struct basins *basins, const char *name,
                             int64_t count)
{
    if (count == 0)
        return;
    reply_begin(reply, "basin");
    reply_string(reply, "attractor", name);
    reply_real(reply, "share", (double)count / (double)basins->finished);
    reply_real(reply, "uncertainty", basins_error(count, basins->finished));
    reply_int(reply, "count", count);
    reply_end(reply);
}

/* Stores the map as a table with a row for each start. Of very many starts this takes a while, so
 * that it can be stopped. */
static void store_map(const struct map *map, struct reply *reply)
{
    static const char *const names[] = {"A", "B", "C", "D", "E", "F", "G", "H", "I",
                                        "J", "K", "L", "M", "N", "O", "P", "Q", "R",
                                        "S", "T", "U", "V", "W", "X", "Y", "Z"};
    struct table_builder table = {.rows = (size_t)map->basins->total};
    const int64_t y_count = map->request->axis[1].count;
    double *value[2];
    for (int a = 0; a < 2; a++) {
        const struct variable v = system_variable(map->system, map->request->axis[a].variable);
        value[a] = table_add_reals(&table, v.name, "", v.quantity);
    }
    const char **fate = table_add_texts(&table, "attractor");
    for (size_t i = 0; !table.failed && i < table.rows; i++) {
        if (i % CANCEL_ROWS == 0 && !map->basins->cancelled && cancelled(map->request->cancel))
            table.failed = true;
        const int f = map->basins->fate[i];
        value[0][i] = basins_value(map->request, 0, (int64_t)i / y_count);
        value[1][i] = basins_value(map->request, 1, (int64_t)i % y_count);
        if (f >= 0)
            fate[i] = names[f];
        else if (f == BASIN_ESCAPES)
            fate[i] = "escapes";
        else
            fate[i] = f == BASIN_UNDECIDED ? "not decided" : "missing";
    }
    table_finish(&table, reply, "basins");
}

/* Replies text, records and table. */
static void reply_map(const struct map *map, struct reply *reply)
{
    put_basins(reply_buffer(reply), map);
    for (int k = 0; k < map->basins->count; k++)
        reply_basin(reply, map, k);
    reply_other_fate(reply, map->basins, "escapes", map->basins->escaping);
    reply_other_fate(reply, map->basins, "not decided", map->basins->undecided);
    if (reply->store && (!map->basins->cancelled || map->basins->total <= stopped_table_rows_max))
        store_map(map, reply);
}

/* Reads the axes, finds the basins and replies them; if stopped, those of the finished starts. */
HANDLER(basins)
{
    const struct argument_value *sides = argument_value(args, "NAME=FROM:TO:STEP");
    struct scene scene = session->setup.scene;
    struct basins_request request = {.scene = &scene,
                                     .cancel = session->front.cancel,
                                     .progress = report_fraction,
                                     .context = &session->front};
    struct system system = {.model = scene.model, .n = scene.model->n};
    struct basins basins;
    double box[LIMIT_VARIABLES][2];
    int axes = 0;
    struct text rest = sides->item->text;
    for (rest = text_trim(rest); rest.len > 0; rest = text_trim(rest)) {
        const struct text side = next_key_argument(&rest);
        if (!text_is(side, "--full") &&
            !read_side(session, args, side, &system, &request, axes++, error))
            return false;
    }
    if (axes < 2)
        return error_set(error, ERROR_COMMAND, "basins need two variables, as in %s=-2:2:0.1",
                         system.model->variable[0].name);
    for (int i = 0; i < system.n; i++)
        box[i][0] = box[i][1] = NAN;
    for (int a = 0; a < axes; a++) {
        box[request.axis[a].variable][0] = request.axis[a].low;
        box[request.axis[a].variable][1] = request.axis[a].high;
    }
    if (!scene_bind_inside(&scene, box, &system, error) || !basins_find(&request, &basins, error))
        return false;
    if (basins.finished > 0) {
        int width, height;
        session_size(session, &width, &height);
        const struct map map = {&request, &basins,
                                &system,  asks_full(args) ? 0 : answer_rows(session),
                                width,    session->setup.settings.timing != TIMING_OFF};
        reply_map(&map, reply);
    }
    const bool stopped = basins.cancelled || cancelled(request.cancel);
    const long long finished = basins.finished, total = basins.total;
    basins_free(&basins);
    return !stopped || error_set(error, ERROR_CANCELLED, "stopped: %lld of %lld starts finished",
                                 finished, total);
}
#endif

COMMAND(basins, .group = "DYNAMICS", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("NAME=FROM:TO:STEP", TYPE_REST, .flags = ARG_REQUIRED),
                  OPTION("full", TYPE_NONE)))
