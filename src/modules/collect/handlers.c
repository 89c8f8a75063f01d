/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands collect and stop. A collection appends lines of a sensor to a file (feed), follows them
 * (collect_follow.c) and ends as a recording (collect_end.c). */
#ifndef COMMAND_ROWS
#include <hooke/base/file.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/statement.h>
#include "modules/collect/handlers.h"
#include "modules/recording/fits.h"
#include "modules/recording/recording_text.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define BAUD_DEFAULT 115200 /* Baud rate unless one is given. */
#define LINES_MAX 50000000  /* most lines without max=; the file has a limit of its own */
#define NAMES_MAX 10000     /* largest number in the name of a file */

/* Returns the value of an argument in SI units, or `otherwise` if it was not given. */
static double value_given(const struct arguments *args, const char *name, double otherwise)
{
    return has_argument(args, name) ? argument_value(args, name)->item->value.value : otherwise;
}

static const struct unit *unit_given(const struct arguments *args, const char *name)
{
    return has_argument(args, name) ? argument_value(args, name)->item->unit : NULL;
}

/* ---- arguments ---- */

/* Appends the options as a statement has them: those of `load`, or all. */
static void put_options(const struct arguments *args, bool all, struct buffer *output)
{
    static const char *const keys[] = {"t",   "y",    "unit",    "tunit",  "rate", "decimal",
                                       "sep", "baud", "trigger", "before", "for",  "max"};
    for (size_t i = 0; i < (all ? COUNT_OF(keys) : 7); i++) {
        const struct argument_value *key = argument_value(args, keys[i]);
        if (key->count == 0)
            continue;
        buffer_format(output, " %s=", keys[i]);
        buffer_word(output, key->item->text);
    }
}

/* Makes a name of the source's first `max` characters; all but letters, digits and _ become -. */
static void plain_name(struct text source, size_t max, char name[LIMIT_NAME + 1])
{
    size_t len = 0;
    for (; len < source.len && len < max; len++) {
        const char c = source.data[len];
        const bool plain =
            (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
        name[len] = plain ? c : '-';
    }
    name[len] = '\0';
}

/* Returns the name of a new file, NAME-N.txt, named after as= or the source; NULL if there is none
 * or out of memory. */
static const char *new_file_name(const struct arguments *args, const char *source)
{
    const struct text as = argument_text(args, "as");
    char stem[LIMIT_NAME + 1];
    plain_name(as.len ? as : text_last_component(text_of(source)), LIMIT_NAME - 8, stem);
    for (int i = 1; i < NAMES_MAX; i++) {
        struct buffer name = {0};
        struct stat st;
        buffer_format(&name, "%s-%d.txt", stem[0] && stem[0] != '-' ? stem : "collected", i);
        char *path = arena_text(args->arena, buffer_text(&name));
        buffer_free(&name);
        if (!path || lstat(path, &st) != 0)
            return path;
    }
    return NULL;
}

/* Reads the options of a collection. Returns false with an error. */
static bool read_options(const struct arguments *args, struct collection *c, struct error *error)
{
    const struct argument_value *decimal = argument_value(args, "decimal"),
                                *sep = argument_value(args, "sep");
    c->options = (struct load_options){.time = argument_text(args, "t"),
                                       .value = argument_text(args, "y"),
                                       .unit = unit_given(args, "unit"),
                                       .time_unit = unit_given(args, "tunit"),
                                       .rate = value_given(args, "rate", 0)};
    if (decimal->count)
        c->options.decimal = decimal_letters[decimal->item->index];
    if (sep->count)
        c->options.separator = separator_letters[sep->item->index];
    c->length = value_given(args, "for", HUGE_VAL);
    c->pretrigger = value_given(args, "before", 0);
    c->baud = (long)value_given(args, "baud", BAUD_DEFAULT);
    c->max = (uint64_t)value_given(args, "max", LINES_MAX);
    struct buffer options = {0};
    put_options(args, false, &options);
    char *copy = arena_text(args->arena, buffer_text(&options));
    buffer_free(&options);
    if (!copy)
        return error_memory(error);
    c->put_options = text_of(copy);
    if (!(c->length > 0))
        return error_at(error, argument_text(args, "for"), "for= needs a time above 0");
    if (!has_argument(args, "trigger"))
        return true;
    struct parser parser = {c->session, args->scope, args->arena, argument_text(args, "trigger")};
    return trigger_read(&parser, &c->trigger, error);
}

/* ---- the file ---- */

/* Opens the file c->path for appending. A new file gets a head: the statement that repeats the
 * collection, and the calibration; with c->again, an existing file is extended after a line that
 * marks the pause. Returns the file descriptor, or -1 with an error if the source does not exist or
 * is the same file, if a new file exists already, or if writing fails. */
static int open_collected_file(const struct collection *c, const struct arguments *args,
                               struct error *error)
{
    struct stat st, own;
    if (strcmp(c->source, STANDARD_INPUT) != 0 &&
        (stat(c->source, &st) != 0 ||
         (stat(c->path, &own) == 0 && st.st_ino == own.st_ino && st.st_dev == own.st_dev))) {
        error_set(error, ERROR_IO, "cannot collect from %s: %s", c->from_shown,
                  access(c->source, F_OK) != 0 ? strerror(errno)
                                               : "the lines would be written to it");
        return -1;
    }
    if (!c->again && lstat(c->path, &st) == 0) {
        error_set(error, ERROR_IO, "%s exists", c->to_shown);
        error_hint(error, "to=FILE names another file; 'collect continue' extends the current one");
        return -1;
    }
    const int fd = append_open(c->path, session_policy(c->session, false), 0666, error);
    if (fd >= 0 && c->again && !append_lines(fd, TEXT(COLLECTED_PAUSE "\n"), false, error)) {
        close(fd);
        return -1;
    }
    if (fd < 0 || c->again)
        return fd;
    struct buffer head = {0};
    buffer_format(&head, "%s: seconds, tab, a line as it came\n%scollect ", COLLECTED_HEAD,
                  COLLECTED_STATEMENT);
    buffer_word(&head, strcmp(c->source, STANDARD_INPUT) == 0 ? TEXT("-") : text_of(c->source));
    put_options(args, true, &head);
    buffer_char(&head, '\n');
    if (c->calibration.known) {
        buffer_put(&head, TEXT(COLLECTED_CALIBRATION));
        calibration_put(&c->calibration, &head);
        buffer_char(&head, '\n');
    }
    struct error why = {.code = ERROR_NONE};
    const bool ok =
        !head.failed ? append_lines(fd, buffer_text(&head), false, &why) : error_memory(&why);
    buffer_free(&head);
    if (ok)
        return fd;
    close(fd);
    unlink(c->path);
    error_set(error, why.code, "cannot collect into %s: %s", c->to_shown, why.text);
    return -1;
}

/* ---- a collection ---- */

/* Returns a path with control characters made visible, or NULL if out of memory. */
static const char *visible_path(const struct arguments *args, const char *path)
{
    struct buffer safe = {0};
    safe_text(&safe, text_of(path), false);
    const char *copy = arena_text(args->arena, buffer_text(&safe));
    buffer_free(&safe);
    return copy;
}

/* Runs a collection from beginning to end: opens file and source, follows the lines until the
 * collection ends, and makes the recording. While it runs, session->growing and part->now point to
 * its state. Returns false with an error if file or source cannot be opened or collect_finish()
 * fails. */
static bool collection_start(struct collection *c, const struct arguments *args,
                             struct error *error)
{
    struct session *session = c->session;
    const struct feed_access *feed = session->front.feed;
    struct collect_part *part = session_part(session, &collect_module);
    if (!part)
        return error_memory(error);
    if (!feed)
        return error_set(error, ERROR_COMMAND, "this program cannot collect data");
    c->from_shown = visible_path(args, c->source);
    c->to_shown = visible_path(args, c->path);
    if (!c->from_shown || !c->to_shown)
        return error_memory(error);
    const int file = open_collected_file(c, args, error);
    if (file < 0)
        return false;
    const struct feed_request request = {.source = c->source,
                                         .file = file,
                                         .baud = c->baud,
                                         .t_begin = c->t_begin,
                                         .max = c->max,
                                         .safe = session->options.safe};
    if (c->again && session->setup.calibration.decided && !collect_put_calibration(c, error)) {
        close(file);
        return false;
    }
    c->options.calibration = &c->calibration;
    c->view = (struct collect_view){.path = c->path, .options = &c->options, .fd = -1};
    c->state = (struct collecting){
        .growing = {.steady = NAN, .middle = NAN, .swing = NAN, .t_end = NAN, .late = NAN},
        .period = NAN,
        .amplitude = NAN,
        .fit = {.t = NAN}};
    c->trigger.after_line = c->after_line;
    c->state.feed = feed->open(&request, error);
    if (!c->state.feed) {
        if (!c->again)
            unlink(c->path);
        return false;
    }
    c->how = END_STOPPED;
    if (session->front.watched)
        reply_line(c->reply, "collecting into %s (Ctrl-C or 'stop' ends it and keeps it)",
                   c->to_shown);
    part->now = &c->state;
    session->growing = &c->state.growing;
    const bool interrupted = collect_follow(c);
    feed->close(c->state.feed, &c->look);
    c->state.feed = NULL;
    if (interrupted)
        feed->heeded(); /* the Ctrl-C has done its work and must not stop the fit below */
    if (fits_of(session)->live)
        collect_fit_last(c);
    part->now = NULL;
    session->growing = NULL;
    collect_view_free(&c->view);
    collect_live_free(c);
    return collect_finish(c, args, error);
}

/* ---- the commands ---- */

/* Handles collect pause, continue and stop during a collection. Returns false with an error for
 * others. */
static bool steer_collection(struct session *session, const struct arguments *args,
                             struct reply *reply, struct error *error)
{
    struct collecting *now = session_collecting(session);
    const bool pause = has_argument(args, "pause"), continues = has_argument(args, "continue");
    if (!pause && !continues && !has_argument(args, "stop"))
        return error_set(error, ERROR_COMMAND,
                         "a recording is already being collected; 'stop' ends and keeps it");
    if (!pause && !continues) {
        now->stop = true;
        return true;
    }
    session->front.feed->pause(now->feed, pause);
    now->state = pause ? COLLECT_PAUSED : COLLECT_GOES_ON;
    reply_line(reply, pause ? "paused: arriving data are dropped; 'collect continue' resumes"
                            : "collecting continues");
    return true;
}

/* Parses the statement that collected the current recording again, into *again. Returns false with
 * an error if it was not collected. */
static bool parse_statement_again(struct session *session, const struct arguments *args,
                                  struct arguments *again, struct error *error)
{
    const struct recording *recording = session_recording(session);
    if (!recording || !recording->collected || recording->collected->statement.len == 0) {
        error_set(error, ERROR_COMMAND, "the current recording was not collected");
        return error_hint(error, "collect SOURCE, or 'data use NAME'");
    }
    char *copy = arena_text(args->arena, recording->collected->statement);
    if (!copy)
        return error_memory(error);
    struct parser parser = {session, args->scope, args->arena, text_of(copy)};
    const struct text word = peek_word(parser.rest, "");
    parser.rest = (struct text){word.data + word.len, parser.rest.len - word.len};
    if (!text_is(word, "collect"))
        return error_set(error, ERROR_COMMAND, "%s does not say how it was collected",
                         recording->name);
    *again = (struct arguments){.command = args->command,
                                .word = word,
                                .scope = args->scope,
                                .arena = args->arena,
                                .where = args->where};
    return parse_arguments(&parser, args->command, again, error) &&
           (has_argument(again, "SOURCE") ||
            error_set(error, ERROR_COMMAND, "%s does not say from which device it was collected",
                      recording->name));
}

/* Prepares to continue the file of a recording; its time has advanced by the time since the file
 * was changed. Returns false if the file is gone. */
static bool continue_file(struct collection *c, const struct recording *recording)
{
    struct stat st;
    struct timespec now;
    if (stat(recording->path, &st) != 0 || clock_gettime(CLOCK_REALTIME, &now) != 0)
        return false;
    const double elapsed =
        difftime(now.tv_sec, st.st_mtim.tv_sec) + 1e-9 * (double)(now.tv_nsec - st.st_mtim.tv_nsec);
    c->again = true;
    c->path = recording->path;
    c->there = recording->collected->lines;
    c->after_line = recording->line[recording->rows - 1];
    c->t_begin = recording->collected->last + (elapsed > 0 ? elapsed : 0);
    return true;
}

/* Chooses the names of the file and of the recording. Returns false with an error. */
static bool choose_names(struct collection *c, const struct arguments *args, struct error *error)
{
    const struct text path = argument_text(args, "to"), as = argument_text(args, "as");
    if (!c->path)
        c->path = path.len ? arena_text(args->arena, path) : new_file_name(args, c->source);
    if (!c->path)
        return error_set(error, ERROR_IO, "the file has no name; give one with to=FILE");
    if (as.len > 0 && (as.len > LIMIT_NAME || peek_name(as).len != as.len))
        return error_at(
            error, as,
            "a name begins with a letter, followed by at most %d letters, digits, _ and -",
            LIMIT_NAME);
    const struct text file = text_last_component(text_of(c->path));
    const size_t end = file.len > 4 ? file.len - 4 : file.len;
    char name[LIMIT_NAME + 1];
    plain_name(as.len ? as : (struct text){file.data, end}, LIMIT_NAME, name);
    const char *kept = arena_text(args->arena, text_of(name));
    c->options.name = text_of(kept ? kept : "");
    return kept || error_memory(error);
}

/* Collects from a source, anew with the statement of the current recording (again), or at the end
 * of its file (continue). */
HANDLER(collect)
{
    struct collection c = {.session = session, .reply = reply};
    if (session_collecting(session))
        return steer_collection(session, args, reply, error);
    struct arguments *again = arena_alloc(args->arena, sizeof *again);
    const bool continues = has_argument(args, "continue"),
               anew = continues || has_argument(args, "again");
    if (!again)
        return error_memory(error);
    if (session->live.state == LIVE_RUNNING || session->execution.reacting)
        return error_set(error, ERROR_COMMAND, "a run is in progress; pause it first");
    if (has_argument(args, "pause") || has_argument(args, "stop"))
        return error_set(error, ERROR_COMMAND, "nothing is being collected");
    if (anew && !parse_statement_again(session, args, again, error))
        return false;
    if (continues && !continue_file(&c, session_recording(session)))
        return error_set(error, ERROR_IO, "its file no longer exists");
    const struct arguments *const wishes = anew ? again : args;
    const struct text source = argument_text(wishes, "SOURCE");
    const bool input = text_is(source, "-");
    if (source.len == 0)
        return error_set(error, ERROR_COMMAND,
                         "'collect' needs a SOURCE: a device, a pipe, or -") ||
               error_hint(error, "'load FILE' reads an existing recording");
    if (input && !check_input(session, source, error))
        return false;
    const struct recording *previous = anew ? session_recording(session) : NULL;
    if (session->setup.calibration.decided)
        c.calibration = session->setup.calibration;
    else
        c.calibration = previous ? previous->calibration : c.calibration;
    c.source = arena_text(args->arena, input ? TEXT(STANDARD_INPUT) : source);
    if (!c.source)
        return error_memory(error);
    return read_options(wishes, &c, error) && choose_names(&c, args, error) &&
           collection_start(&c, wishes, error);
}

/* Stops the collection or the live run that is in progress. */
HANDLER(stop)
{
    UNUSED(args);
    UNUSED(error);
    if (session_collecting(session))
        session_collecting(session)->stop = true;
    else if (session->live.state == LIVE_RUNNING)
        session->live.pausing = true;
    else
        reply_line(reply, "nothing is running");
    return true;
}
#endif

COMMAND(collect, .group = "DATA", .flags = COMMAND_CHANGES | COMMAND_ANYTIME,
        ARGUMENTS(WORD("again", TYPE_NONE, .group = 1), WORD("pause", TYPE_NONE, .group = 1),
                  WORD("continue", TYPE_NONE, .group = 1), WORD("stop", TYPE_NONE, .group = 1),
                  PLACE("SOURCE", TYPE_FILE, .group = 1), KEY("baud", TYPE_INTEGER),
                  KEY("rate", TYPE_VALUE, .quantity = QUANTITY_FREQUENCY),
                  KEY("for", TYPE_VALUE, .quantity = QUANTITY_TIME), KEY("max", TYPE_INTEGER),
                  KEY("trigger", TYPE_TEXT), KEY("before", TYPE_VALUE, .quantity = QUANTITY_TIME),
                  KEY("to", TYPE_FILE), KEY("as", TYPE_TEXT), KEY("t", TYPE_TEXT),
                  KEY("y", TYPE_TEXT), KEY("unit", TYPE_UNIT),
                  KEY("tunit", TYPE_UNIT, .quantity = QUANTITY_TIME),
                  KEY("decimal", TYPE_CHOICE, .choices = &decimal_catalog),
                  KEY("sep", TYPE_CHOICE, .choices = &separator_catalog)))

COMMAND(stop, .group = "DATA", .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED)
