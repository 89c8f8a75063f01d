/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command `sweep`: reads the statement, computes the sweep by study_sweep() and replies with
 * it. */
#ifndef COMMAND_ROWS
#include <hooke/run/parallel.h>
#include <hooke/run/timing.h>
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/language/grid.h>
#include "modules/sweep/reading.h"
#include "modules/sweep/handlers.h"
#include "modules/sweep/swept.h"

#include <math.h>
#include <string.h>

/* ---- reading NAME=FROM:TO[:STEP|:xFACTOR], measure=…, options ---- */

/* Returns false with an error if dt or tol is not positive along the whole axis. */
static bool check_above_0(const struct sweep_axis *axis, struct text name, struct error *error)
{
    const bool setting = axis->target == SWEEP_DT || axis->target == SWEEP_TOL;
    if (!setting || (axis->begin > 0 && axis->end > 0))
        return true;
    error_at(error, name, "all values of %s must be > 0", axis->name);
    return error_hint(error, axis->target == SWEEP_DT ? "for example dt=1ms:100ms:x2"
                                                      : "for example tol=1e-9:1e-3:x10");
}

/* Reads FROM:TO[:STEP|:xFACTOR] of the quantity `name` into an axis. Returns false with an error if
 * the quantity cannot be swept (tol, if the method has fixed steps) or if the range is invalid. */
static bool read_axis(struct parser *parser, struct text name, struct sweep_axis *axis,
                      struct error *error)
{
    if (!sweep_axis_find(&parser->session->setup.scene, name, axis))
        return unknown_parameter(parser->session, name, TEXT(""), error);
    const struct method *method = parser->session->setup.method;
    if (axis->target == SWEEP_TOL && !(method->flags & METHOD_ADAPTIVE)) {
        error_at(error, name, "%s has fixed steps and does not use tol", method->row.name);
        return error_hint(error, "'sweep dt=1ms:100ms:x2' varies them; 'method dopri5' adapts");
    }
    struct value_grid grid = {.quantity = axis->quantity};
    memcpy(grid.name, axis->name, sizeof grid.name);
    if (!parse_grid(parser, &grid, error))
        return false;
    axis->begin = grid.first;
    axis->end = grid.last;
    axis->count = grid.count;
    axis->log = grid.log;
    return check_above_0(axis, name, error);
}

/* Reads an integer, named `what` in errors. Returns false with an error. */
static bool read_whole_number(struct parser *parser, const char *what, int64_t *number,
                              struct error *error)
{
    struct item item = {0};
    if (!parse_integer(parser, what, false, &item, error))
        return false;
    *number = (int64_t)item.value.value;
    return true;
}

/* Reads the I/N of --shard, the I-th of N equal parts of all points, into the request. Returns
 * false with an error unless 1 <= I <= N. */
static bool read_shard(struct parser *parser, struct sweep_request *request, struct error *error)
{
    const struct text all = text_trim(parser->rest);
    struct text rest = all, part;
    double number, total;
    if (!text_split(&rest, '/', &part) || real_parse(part, &number) != REAL_OK ||
        real_parse(rest, &total) != REAL_OK || !(number >= 1 && number <= total && total <= 1e9) ||
        number != floor(number) || total != floor(total)) {
        error_at(error, all, "--shard needs a part and the number of parts, as in --shard 2/8");
        return false;
    }
    request->shard = (int64_t)number;
    request->shards = (int64_t)total;
    return true;
}

/* Reads the file of --resume, which must end the option. Returns false with an error. */
static bool read_file_name(struct parser *parser, struct text *file, struct error *error)
{
    struct item item = {0};
    if (!parse_word(parser, "", &item, error) || !refuse_rest(parser, NULL, error))
        return false;
    *file = item.text;
    return file->len > 0 || error_at(error, parser->rest, "--resume needs a file");
}

/* Reads one option of `sweep` that begins with -- into *request or *options; the parser's text is
 * this option alone. --full is accepted without effect here. Returns false with an error if it is
 * unknown or invalid. */
static bool read_option(struct parser *parser, struct sweep_request *request,
                        struct sweep_options *options, struct error *error)
{
    const struct text all = parser->rest;
    const struct text name = peek_name(text_after(all, 2));
    int64_t threads = 0;
    parser->rest = (struct text){name.data + name.len, all.len - 2 - name.len};
    text_skip_blanks(&parser->rest);
    if (text_is(name, "force")) {
        options->force = true;
        return refuse_rest(parser, NULL, error);
    }
    if (text_is(name, "full"))
        return refuse_rest(parser, NULL, error);
    if (text_is(name, "dry-run")) {
        options->dry = true;
        return refuse_rest(parser, NULL, error);
    }
    if (text_is(name, "resume"))
        return read_file_name(parser, &options->file, error);
    if (text_is(name, "shard"))
        return read_shard(parser, request, error);
    if (!text_is(name, "threads")) {
        error_at(error, all, "sweep has no option '%.*s'", (int)(name.len < 64 ? name.len : 64),
                 name.data);
        return error_hint(error, "the options are --threads N, --shard I/N, --resume FILE, "
                                 "--dry-run, --full and --force");
    }
    struct item shown = {0};
    if (!read_whole_number(parser, "--threads", &threads, error) ||
        !refuse_rest(parser, &shown, error))
        return false;
    if (threads > PARALLEL_THREADS_MAX)
        return error_at(error, all, "at most %d threads", PARALLEL_THREADS_MAX);
    request->threads = (int)threads;
    return true;
}

/* Reads the number of skip= (events to leave out, at least 0) or keep= (events to record, at least
 * 1), whichever `name` is, into the section. Returns false with an error. */
static bool read_count(struct parser *parser, struct text name, struct sweep_section *section,
                       struct error *error)
{
    const bool skip = text_is(name, "skip");
    int64_t *count = skip ? &section->skip : &section->keep;
    const struct text where = text_trim(parser->rest);
    struct item item = {0};
    if (!parse_integer(parser, skip ? "skip" : "keep", true, &item, error) ||
        !refuse_rest(parser, &item, error))
        return false;
    *count = (int64_t)item.value.value;
    return *count >= !skip ||
           error_at(error, where, "%s= needs at least %d", skip ? "skip" : "keep", !skip);
}

/* Reads axes, event, measures and options of a statement into request and options; `rest` is the
 * text that follows the word `sweep`. Returns false with an error. Without axes the statement is
 * valid only with --resume FILE, whose head names them. */
bool read_sweep(struct session *session, const struct arguments *args, struct text rest,
                struct sweep_request *request, struct sweep_options *options, struct error *error)
{
    bool measured = false;
    while (text_skip_blanks(&rest), rest.len > 0) {
        if (text_is(peek_name(rest), "at") && request->axes > 0) {
            if (!read_section(session, args, next_section(&rest), &request->section, error))
                return false;
            continue;
        }
        const struct text argument = next_key_argument(&rest), name = peek_name(argument);
        struct parser parser = {
            session, args->scope, args->arena, {argument.data + name.len, argument.len - name.len}};
        text_skip_blanks(&parser.rest);
        if (text_starts(argument, TEXT("--"))) {
            parser.rest = argument;
            if (!read_option(&parser, request, options, error))
                return false;
            continue;
        }
        if (name.len == 0 || !text_starts(parser.rest, TEXT("="))) {
            error_at(error, argument, "'sweep' needs NAME=FROM:TO");
            return error_hint(error, "for example: sweep omega=6:12:0.1 measure=amplitude");
        }
        parser.rest = text_after(parser.rest, 1);
        if (text_is(name, "measure")) {
            if (!read_measures(&parser, request, error))
                return false;
            measured = true;
            continue;
        }
        if (text_is(name, "skip") || text_is(name, "keep")) {
            if (!read_count(&parser, name, &request->section, error))
                return false;
            continue;
        }
        if (request->axes == 2)
            return error_at(error, argument, "'sweep' needs one or two parameters");
        struct sweep_axis *axis = &request->axis[request->axes];
        if (!read_axis(&parser, name, axis, error))
            return false;
        if (request->axes++ == 1 && strcmp(request->axis[0].name, axis->name) == 0)
            return error_at(error, argument, "'%s' is given twice", axis->name);
    }
    if (request->axes == 0 && options->file.len == 0)
        return error_set(error, ERROR_COMMAND,
                         "sweep needs a parameter, as in sweep omega=6:12:0.1");
    return request->axes == 0 || finish_section(request, measured, error);
}

/* ---- what it says ---- */

/* Adds the finished points to the reply as rows of a table. Only the first shard has the header, so
 * that shards one after another are the whole table. */
static void reply_points(const struct swept *swept, const struct table *table, struct reply *reply)
{
    const struct sweep *sweep = swept->sweep;
    for (size_t first = 0, end; first < table->rows; first = end + 1) {
        for (end = first;
             end < table->rows && (swept->section || sweep->status[end] != SWEEP_MISSING);)
            end++;
        reply_table_rows(reply, "sweep", table, first, end - first, first > 0 || sweep->first == 0);
    }
}

/* Returns the sweep together with the measures that are shown: the requested columns, which are
 * formulas of the computed measures, or without formulas the measures themselves. */
static struct swept swept_of(const struct sweep_request *request, const struct sweep *sweep)
{
    struct swept swept = {.sweep = sweep,
                          .measure = request->measure,
                          .model = request->scene->model,
                          .measures = request->measures,
                          .section = request->section.wanted ? &request->section : NULL};
    if (request->columns > 0) {
        swept.measure = request->shown;
        swept.measures = request->columns;
    }
    return swept;
}

/* Stores the table of results as "sweep" for plots and replies, and replies with text or records.
 * If out of memory the table is left out. */
static void reply_sweep(struct session *session, const struct swept *swept,
                        const struct arguments *args, struct reply *reply)
{
    struct arena own = {0};
    struct table table;
    const bool made = swept_table(swept, &own, &table);
    if (made && reply->store)
        table_store_put(reply->store, "sweep", &own, &table);
    if (reply_wants_text(reply)) {
        const int rows = asks_full(args) ? 0 : answer_rows(session);
        (swept->section ? diagram_text : sweep_text)(session, swept, rows, args->arena,
                                                     reply_buffer(reply));
    } else if (reply->format != FORMAT_TEXT && made) {
        reply_points(swept, &table, reply);
    }
    arena_reset(&own);
}

/* Writes the points as CSV, below a line of column names. */
bool sweep_rows(const struct sweep_request *request, const struct sweep *sweep, struct buffer *rows)
{
    const struct swept swept = swept_of(request, sweep);
    struct arena arena = {0};
    struct table table;
    const bool ok = swept_table(&swept, &arena, &table);
    if (ok)
        table_put(&table, table_csv, rows);
    arena_reset(&arena);
    return ok && !rows->failed;
}

/* Returns the request before its statement is read. */
struct sweep_request sweep_request_begin(struct session *session)
{
    return (struct sweep_request){.scene = &session->setup.scene,
                                  .method = session->setup.method,
                                  .settings = session_run_settings(session),
                                  .duration = session->setup.settings.duration,
                                  .section = {.skip = -1, .keep = -1},
                                  .shard = 1,
                                  .shards = 1,
                                  .cancel = session->front.cancel,
                                  .progress = report_fraction,
                                  .context = &session->front,
                                  .measure = {{.kind = SWEEP_AMPLITUDE, .column = SWEEP_VARIABLE}},
                                  .measures = 1};
}

/* Computes a sweep and replies with it. A sweep stopped by Ctrl-C replies with the finished points
 * and stores them with its statement for `continue`. Returns false with an error, also if
 * stopped. */
static bool sweep_in_memory(struct session *session, const struct arguments *args,
                            const struct sweep_request *request, struct text statement,
                            struct reply *reply, struct error *error)
{
    struct sweep sweep;
    const bool ok = study_sweep(request, &sweep, error);
    if (session->setup.settings.timing == TIMING_OFF)
        sweep.seconds = NAN;
    report_fraction(&session->front, 2);
    const bool stopped = !ok && error->code == ERROR_CANCELLED;
    if (sweep.finished > 0 && (ok || stopped)) {
        struct swept swept = swept_of(request, &sweep);
        struct sweep_attractor attractor[SWEEP_ATTRACTORS];
        for (int m = 0; m < swept.measures && reply->format == FORMAT_TEXT && ok; m++)
            if (swept.measure[m].kind == SWEEP_ATTRACTOR)
                swept.attractors = sweep_attractors(request, &sweep, m, attractor);
        swept.attractor = attractor;
        reply_sweep(session, &swept, args, reply);
    }
    if (stopped && sweep.finished > 0) {
        sweep_keep_stopped(session, statement, &sweep);
        error_hint(error, "'continue' computes the other points");
    }
    sweep_free(&sweep);
    return ok;
}

/* Reads, computes and answers the sweep of a statement. `previous` holds points that are finished
 * already, or is NULL. With --dry-run only the cost is estimated, with --resume results go into a
 * file. Returns false with an error, also if stopped. */
bool sweep_statement(struct session *session, const struct arguments *args, struct text statement,
                     const struct sweep *previous, struct reply *reply, struct error *error)
{
    struct sweep_request request = sweep_request_begin(session);
    struct sweep_options options = {.force = false};
    double steps, seconds;
    if (!read_sweep(session, args, statement, &request, &options, error))
        return false;
    request.previous = previous && previous->value ? previous : NULL;
    reply_unchosen(session, reply);
    study_sweep_predict(&request, &steps, &seconds);
    if (!previous && !options.dry && options.file.len == 0 &&
        !allow_long(session, seconds, steps, options.force, error))
        return false;
    reply_assumed(session, request.settings.tol > 0, true, reply);
    reply_shorter(session, reply);
    if (options.dry)
        return sweep_cost(session, &request, reply, error);
    if (options.file.len == 0) {
        struct sweep stretch;
        study_sweep_stretch(&request, &stretch);
        session->studies.points =
            (double)(stretch.count - (request.previous ? request.previous->finished : 0));
        return sweep_in_memory(session, args, &request, statement, reply, error);
    }
    options.force |= previous != NULL;
    const bool ok = sweep_into_file(session, args, &request, &options, reply, error);
    if (!ok && error->code == ERROR_CANCELLED)
        sweep_keep_stopped(session, statement, &(struct sweep){.count = 0});
    return ok;
}

/* Executes `sweep`. */
HANDLER(sweep)
{
    const bool ok = sweep_statement(session, args, argument_value(args, "NAME=RANGE")->item->text,
                                    NULL, reply, error);
    session->studies.points = 0;
    if (ok)
        sweep_forget_stopped(session);
    return ok;
}
#endif

COMMAND(sweep, .group = "STUDY", .flags = COMMAND_TABLES, .completes = COMPLETES_GRID,
        ARGUMENTS(PLACE("NAME=RANGE", TYPE_REST, .flags = ARG_REQUIRED), WORD("at", TYPE_EVENT),
                  KEY("skip", TYPE_INTEGER), KEY("keep", TYPE_INTEGER),
                  KEY("measure", TYPE_TEXT, .flags = ARG_MANY), OPTION("threads", TYPE_INTEGER),
                  OPTION("shard", TYPE_TEXT), OPTION("resume", TYPE_FILE),
                  OPTION("dry-run", TYPE_NONE), OPTION("force", TYPE_NONE),
                  OPTION("full", TYPE_NONE)))
