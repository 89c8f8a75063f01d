/* SPDX-License-Identifier: GPL-3.0-or-later */
/* collect, stop */
#ifndef COMMAND_ROWS
#include "command/data/collect.h"
#include "command/data/recording_text.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define LOOK_NS 50000000   /* between looks at what has come */
#define SILENT_S 2.0       /* then it is said what is waited for */
#define BAUD 115200        /* unless it is said */
#define LINES_MAX 50000000 /* unless it is said; the file has a limit of its own */
#define PERIODS_SHOWN 8    /* of which the last is told */
#define NAMES_MAX 10000    /* files beside each other */

enum collect_end { END_BY_FEED, END_STOPPED, END_IN_TIME };

/* One that is under way. */
struct collection {
    struct session *session;
    struct reply *reply;
    const char *source, *path;         /* path: of its file */
    const char *from_shown, *to_shown; /* both, safe to show */
    struct load_options options;
    struct text put_options; /* as they stand behind load */
    struct trigger trigger;
    double length, before; /* [s] HUGE_VAL: no end */
    bool again;            /* goes on with a file there is */
    double from;           /* [s] its time goes on from there */
    long baud;
    uint64_t max, there; /* lines; that were there before */
    struct collecting state;
    struct collect_view view;
    struct feed_look look;
    enum collect_end how;
    bool said_silent, said_none;
};

static struct text text_given(const struct arguments *args, const char *name)
{
    const struct argument_value *one = argument_value(args, name);
    return one->count ? one->item->text : (struct text){NULL, 0};
}

static double value_given(const struct arguments *args, const char *name, double otherwise)
{
    return has_argument(args, name) ? argument_value(args, name)->item->value.value : otherwise;
}

/* ---- what is wanted ---- */

/* As they stand in a statement, those of `load` or all. */
static void put_options(const struct arguments *args, bool all, struct buffer *out)
{
    static const char *const keys[] = {"t",   "y",    "unit",    "tunit",  "rate", "decimal",
                                       "sep", "baud", "trigger", "before", "for",  "max"};
    for (size_t i = 0; i < (all ? COUNT_OF(keys) : 7); i++) {
        const struct argument_value *key = argument_value(args, keys[i]);
        if (key->count == 0)
            continue;
        buffer_format(out, " %s=", keys[i]);
        if (isfinite(key->item->value.value) && key->item->value.value != 0 && !key->item->unit &&
            !key->item->row && text_is(key->item->text, ""))
            buffer_real(out, key->item->value.value);
        else
            buffer_word(out, key->item->text);
    }
}

/* NAME-N.txt that is not there yet, of the source's own name or as=. */
static const char *free_name(const struct arguments *args, const char *source)
{
    const struct text as = text_given(args, "as"),
                      of = as.len ? as : text_last_component(text_of(source));
    char stem[LIMIT_NAME + 1];
    size_t len = 0;
    for (size_t i = 0; i < of.len && len < LIMIT_NAME - 8; i++) {
        const char c = of.at[i];
        const bool plain =
            (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
        stem[len++] = plain ? c : '-';
    }
    stem[len] = '\0';
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

static bool read_wishes(const struct arguments *args, struct collection *c, struct error *error)
{
    const struct item *unit =
                          has_argument(args, "unit") ? argument_value(args, "unit")->item : NULL,
                      *tunit =
                          has_argument(args, "tunit") ? argument_value(args, "tunit")->item : NULL;
    const struct argument_value *decimal = argument_value(args, "decimal"),
                                *sep = argument_value(args, "sep");
    c->options =
        (struct load_options){.time = text_given(args, "t"),
                              .value = text_given(args, "y"),
                              .unit = unit ? unit->unit : NULL,
                              .time_unit = tunit ? tunit->unit : NULL,
                              .rate = value_given(args, "rate", 0),
                              .decimal = decimal->count ? decimal_letters[decimal->item->index] : 0,
                              .separator = sep->count ? separator_letters[sep->item->index] : 0};
    c->length = value_given(args, "for", HUGE_VAL);
    c->before = value_given(args, "before", 0);
    c->baud = (long)value_given(args, "baud", BAUD);
    c->max = (uint64_t)value_given(args, "max", LINES_MAX);
    struct buffer options = {0};
    put_options(args, false, &options);
    char *copy = arena_text(args->arena, buffer_text(&options));
    buffer_free(&options);
    if (!copy)
        return error_memory(error);
    c->put_options = text_of(copy);
    if (!(c->length > 0))
        return error_at(error, text_given(args, "for"), "for= needs a time above 0");
    if (!has_argument(args, "trigger"))
        return true;
    struct parser parser = {c->session, args->scope, args->arena, text_given(args, "trigger")};
    return trigger_read(&parser, &c->trigger, error);
}

/* ---- its file ---- */

/* Its head, with the statement that makes it again. -1: the error says why. */
static int begin_file(const struct collection *c, const struct arguments *args, struct error *error)
{
    struct stat st, own;
    if (strcmp(c->source, STANDARD_INPUT) != 0 &&
        (stat(c->source, &st) != 0 ||
         (stat(c->path, &own) == 0 && st.st_ino == own.st_ino && st.st_dev == own.st_dev))) {
        error_set(error, ERROR_IO, "cannot collect from %s: %s", c->from_shown,
                  access(c->source, F_OK) != 0 ? strerror(errno)
                                               : "it is where the lines would go");
        return -1;
    }
    if (!c->again && lstat(c->path, &st) == 0) {
        error_set(error, ERROR_IO, "%s exists", c->to_shown);
        error_hint(error, "to=FILE names another; 'collect continue' goes on with the current one");
        return -1;
    }
    const int fd = append_open(c->path, session_policy(c->session, false), 0666, error);
    if (fd < 0 || c->again)
        return fd;
    struct buffer head = {0};
    buffer_format(&head, "%s: seconds, tab, a line as it came\n%scollect ", COLLECTED_HEAD,
                  COLLECTED_STATEMENT);
    buffer_word(&head, strcmp(c->source, STANDARD_INPUT) == 0 ? TEXT("-") : text_of(c->source));
    put_options(args, true, &head);
    buffer_char(&head, '\n');
    const bool ok =
        !head.failed ? append_lines(fd, buffer_text(&head), false, error) : error_memory(error);
    buffer_free(&head);
    if (ok)
        return fd;
    close(fd);
    return -1;
}

/* ---- while it comes ---- */

static int own_place(const struct collection *c)
{
    for (int i = 0; i < c->session->recordings; i++)
        if (c->session->recording[i]->growing)
            return i;
    return -1;
}

static void read_period(struct collection *c, const struct recording *recording)
{
    struct arena arena = {0};
    struct series series;
    struct error ignored;
    struct period period;
    struct period_reading reading;
    c->state.period = c->state.amplitude = NAN;
    c->state.quantity = recording->column[recording->value].quantity;
    if (recording_series(recording, &arena, 16, &series, &ignored) &&
        series_period(&series, &arena, &period, &ignored)) {
        c->state.period = period.period.value;
        const double from = series.t[series.n - 1] - PERIODS_SHOWN * period.period.value;
        for (size_t i = 0; i < series.n; i++)
            if (series.t[i] >= from) {
                series = (struct series){series.t + i, series.y + i, series.n - i, series.quantity,
                                         series.cancel};
                break;
            }
        if (series_period_readings(&series, 1, &arena, &reading, &ignored))
            c->state.amplitude = reading.amplitude.value;
    }
    arena_reset(&arena);
}

/* Takes the place of what was seen before. */
static void show(struct collection *c, struct recording *recording)
{
    struct error ignored;
    snprintf(recording->name, sizeof recording->name, "%.*s", (int)c->options.name.len,
             c->options.name.at);
    int place = own_place(c);
    if (place < 0) {
        const int same = session_find_recording(c->session, c->options.name);
        if (same >= 0)
            session_drop_recording(c->session, same);
        struct buffer options = {0};
        buffer_put(&options, c->put_options);
        if (session_add_recording(c->session, recording, buffer_view(&options), &ignored)) {
            place = c->session->recordings - 1;
            c->session->recording[place]->growing = true;
        }
        buffer_free(&options);
    } else {
        recording_destroy(c->session->recording[place]->recording);
        c->session->recording[place]->recording = recording;
        session_changed(c->session);
    }
    if (place >= 0)
        read_period(c, c->session->recording[place]->recording);
}

static void look_at_recording(struct collection *c)
{
    const bool waits = c->trigger.wanted && isnan(c->trigger.t);
    if (!c->session->front.watched && !waits)
        return;
    struct recording *recording = collect_view_read(&c->view, c->look.lines);
    if (!recording)
        return;
    if (waits && trigger_look(&c->trigger, recording))
        reply_note(c->reply, "trigger: %.*s at t = %.6g s", (int)c->trigger.name.len,
                   c->trigger.name.at, c->trigger.t);
    if (c->session->front.watched)
        show(c, recording);
    else
        recording_destroy(recording);
}

/* What is waited for, once, when nothing comes, or nothing that can be read. */
static void say_waiting(struct collection *c)
{
    const struct feed_look *look = &c->look;
    if (!c->said_silent && look->lines == 0 && look->now - c->from > SILENT_S) {
        c->said_silent = true;
        if (look->bytes == 0)
            reply_note(c->reply,
                       "%s has said nothing for %.0f s: waiting for its first line; "
                       "Ctrl-C ends it",
                       c->source, SILENT_S);
        else
            reply_note(c->reply,
                       "%s has sent %llu bytes, but no end of line: is baud=%ld its speed? "
                       "waiting; Ctrl-C ends it",
                       c->from_shown, (unsigned long long)look->bytes, c->baud);
    }
    if (!c->said_none && look->lines > 20 && look->now - look->first > SILENT_S &&
        own_place(c) < 0 && c->view.problem.text[0]) {
        c->said_none = true;
        reply_note(c->reply, "no sample yet in %llu lines: %s", (unsigned long long)look->lines,
                   c->view.problem.text);
    }
}

static void tell_state(struct collection *c)
{
    struct collecting *state = &c->state;
    const bool waits = c->trigger.wanted && isnan(c->trigger.t);
    const double start = waits ? NAN : c->trigger.wanted ? c->trigger.t : c->look.first;
    if (state->state != COLLECT_PAUSED)
        state->state = waits ? COLLECT_WAITING : COLLECT_GOES_ON;
    state->lines = c->look.lines + c->there;
    state->seconds = isnan(start) ? 0 : c->look.now - start;
    if (state->seconds >= c->length && state->state == COLLECT_GOES_ON) {
        state->stop = true;
        c->how = END_IN_TIME;
    }
    const struct front *front = &c->session->front;
    if (!front->watched && front->progress && c->session->typed)
        front->progress(front->context, NULL,
                        isfinite(c->length) ? fmin(1, state->seconds / c->length) : 0);
}

/* Until it ends; true: by a Ctrl-C. */
static bool follow(struct collection *c)
{
    const struct front *front = &c->session->front;
    const struct timespec moment = {.tv_nsec = LOOK_NS};
    bool interrupted = false;
    for (;;) {
        front->feed->look(c->state.feed, &c->look);
        look_at_recording(c);
        say_waiting(c);
        tell_state(c);
        if (c->look.end != FEED_GOES_ON || c->state.stop || c->session->quit || interrupted)
            break;
        if (front->watched && front->slice)
            interrupted = !front->slice(front->context, c->session, clock_ns() + LOOK_NS);
        else
            nanosleep(&moment, NULL);
        interrupted = interrupted || cancelled(front->cancel);
    }
    if (!front->watched && front->progress)
        front->progress(front->context, NULL, 2);
    return interrupted;
}

/* ---- at its end ---- */

static const char *status_of(const struct collection *c)
{
    if (c->look.lines == 0 && c->there == 0)
        return "silent";
    switch (c->look.end) {
    case FEED_UNPLUGGED:
        return "unplugged";
    case FEED_FULL:
    case FEED_FAILED:
        return "full";
    case FEED_ENDED:
        return "ok";
    case FEED_GOES_ON:
        break;
    }
    return c->how == END_IN_TIME ? "ok" : "stopped";
}

static void reply_collected(const struct collection *c, const struct recording *recording)
{
    static const char *const clocks[] = {
        [CLOCK_DEVICE] = "device", [CLOCK_ARRIVAL] = "arrival", [CLOCK_UNEVEN] = "arrival"};
    const struct collected *known = recording->collected;
    struct reply *reply = c->reply;
    reply_begin(reply, "collect");
    reply_string(reply, "name", recording->name);
    reply_string(reply, "source", c->source);
    reply_int(reply, "rows", (int64_t)recording->rows);
    reply_int(reply, "lost", (int64_t)known->lost);
    reply_int(reply, "garbled", (int64_t)known->garbled);
    reply_int(reply, "skipped", (int64_t)known->skipped);
    reply_real(reply, "t_start", recording->t[0]);
    reply_real(reply, "t_end", recording->t[recording->rows - 1]);
    reply_real(reply, "rate", recording->rate);
    reply_real(reply, "jitter", known->clock == CLOCK_DEVICE ? NAN : known->jitter);
    reply_string(reply, "clock", clocks[known->clock]);
    reply_string(reply, "status", status_of(c));
    reply_string(reply, "file", c->path);
    reply_end(reply);
}

static void say_end(const struct collection *c, const struct recording *recording)
{
    const struct collected *known = recording->collected;
    reply_line(c->reply, "collected from %s into %s: %zu lines, %zu samples (%s)", c->from_shown,
               c->to_shown, known->lines, recording->rows, status_of(c));
    if (known->skipped + known->garbled + known->lost > 0)
        reply_line(c->reply, "%zu skipped before the first sample, %zu garbled, %zu lost",
                   known->skipped, known->garbled, known->lost);
    if (c->look.end == FEED_FAILED)
        reply_warning(c->reply, "%s took no more (%s): what it has is whole", c->to_shown,
                      c->look.failure);
    if (c->look.end == FEED_UNPLUGGED)
        reply_warning(c->reply, "%s is gone: 'collect continue' goes on when it is back",
                      c->from_shown);
}

/* What was collected becomes a recording as any other, which `load` gives again. */
static bool finish(struct collection *c, const struct arguments *args, struct error *error)
{
    struct session *session = c->session;
    struct load_options options = c->options;
    const int growing = own_place(c);
    if (growing >= 0)
        session_drop_recording(session, growing);
    if (c->look.lines + c->there == 0) {
        if (!c->again)
            unlink(c->path); /* it has a heading, and nothing else */
        error_set(error, ERROR_IO, "nothing came from %s", c->from_shown);
        return error_hint(error, "is it connected and switched on? 'cat' shows what it says");
    }
    struct recording *recording = recording_load(c->path, &options, error);
    if (!recording)
        return error_hint(error,
                          "its lines are kept in %.60s: 'load' with y=, sep= or decimal= "
                          "may read them",
                          c->to_shown);
    const int same = session_find_recording(session, text_of(recording->name));
    if (same >= 0)
        session_drop_recording(session, same);
    struct error ignored;
    if (c->trigger.wanted && isfinite(c->trigger.t))
        recording_window(recording, c->trigger.t - c->before, HUGE_VAL, &ignored);
    char *load_options = arena_text(args->arena, c->put_options);
    if (!load_options)
        recording_destroy(recording);
    if (!load_options || !session_add_recording(session, recording, load_options, error))
        return load_options ? false : error_memory(error);
    struct buffer *happened = &session->history.happened;
    buffer_put(happened, TEXT("load "));
    buffer_word(happened, text_of(c->path));
    buffer_format(happened, "%s\n", load_options);
    say_end(c, recording);
    reply_description(recording, c->reply);
    reply_collected(c, recording);
    return true;
}

static const char *shown(const struct arguments *args, const char *path)
{
    struct buffer safe = {0};
    safe_text(&safe, text_of(path), false);
    const char *copy = arena_text(args->arena, buffer_text(&safe));
    buffer_free(&safe);
    return copy;
}

static bool collect(struct collection *c, const struct arguments *args, struct error *error)
{
    struct session *session = c->session;
    const struct feed_access *feed = session->front.feed;
    if (!feed)
        return error_set(error, ERROR_COMMAND, "nothing can be collected here");
    c->from_shown = shown(args, c->source);
    c->to_shown = shown(args, c->path);
    if (!c->from_shown || !c->to_shown)
        return error_memory(error);
    const int file = begin_file(c, args, error);
    if (file < 0)
        return false;
    const struct feed_request request = {.source = c->source,
                                         .file = file,
                                         .baud = c->baud,
                                         .from = c->from,
                                         .max = c->max,
                                         .safe = session->safe};
    c->view = (struct collect_view){.path = c->path, .options = &c->options, .fd = -1};
    c->state = (struct collecting){.period = NAN, .amplitude = NAN};
    c->trigger.after = c->from;
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
    session->collecting = &c->state;
    const bool interrupted = follow(c);
    session->collecting = NULL;
    feed->close(c->state.feed);
    c->state.feed = NULL;
    collect_view_free(&c->view);
    if (interrupted)
        feed->heeded();
    return finish(c, args, error);
}

/* ---- the commands ---- */

/* What is typed while it goes on. */
static bool steer(struct session *session, const struct arguments *args, struct reply *reply,
                  struct error *error)
{
    struct collecting *now = session->collecting;
    const bool pause = has_argument(args, "pause"), on = has_argument(args, "continue");
    if (!pause && !on && !has_argument(args, "stop"))
        return error_set(error, ERROR_COMMAND,
                         "a recording is being collected: 'stop' ends it, and keeps it");
    if (!pause && !on) {
        now->stop = true;
        return true;
    }
    session->front.feed->pause(now->feed, pause);
    now->state = pause ? COLLECT_PAUSED : COLLECT_GOES_ON;
    reply_line(reply, pause ? "paused: what comes now is dropped; 'collect continue' goes on"
                            : "collecting goes on");
    return true;
}

/* The statement that collected the current recording, parsed anew. */
static bool repeat(struct session *session, const struct arguments *args, struct arguments *again,
                   struct error *error)
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
    parser.rest = (struct text){word.at + word.len, parser.rest.len - word.len};
    if (!text_is(word, "collect"))
        return error_set(error, ERROR_COMMAND, "its file does not say how it was collected");
    *again = (struct arguments){.command = args->command,
                                .word = word,
                                .scope = args->scope,
                                .arena = args->arena,
                                .where = args->where};
    return parse_arguments(&parser, args->command, again, error) &&
           (has_argument(again, "SOURCE") ||
            error_set(error, ERROR_COMMAND, "its file does not say what it was collected from"));
}

/* Its time goes on as the clock on the wall did. */
static bool go_on_after(struct collection *c, const struct recording *recording)
{
    struct stat st;
    struct timespec now;
    if (stat(recording->path, &st) != 0 || clock_gettime(CLOCK_REALTIME, &now) != 0)
        return false;
    const double since =
        difftime(now.tv_sec, st.st_mtim.tv_sec) + 1e-9 * (double)(now.tv_nsec - st.st_mtim.tv_nsec);
    c->again = true;
    c->path = recording->path;
    c->there = recording->collected->lines;
    c->from = recording->collected->last + (since > 0 ? since : 0);
    return true;
}

static bool name_it(struct collection *c, const struct arguments *args, struct error *error)
{
    const struct text to = text_given(args, "to"), as = text_given(args, "as");
    if (!c->path)
        c->path = to.len ? arena_text(args->arena, to) : free_name(args, c->source);
    if (!c->path)
        return error_set(error, ERROR_IO, "no name for the file: to=FILE gives it one");
    if (as.len > 0 && (as.len > LIMIT_NAME || peek_name(as).len != as.len))
        return error_at(error, as,
                        "a name is a letter, then letters, digits, _ and -, at most %d of them",
                        LIMIT_NAME);
    const struct text file = text_last_component(text_of(c->path));
    const size_t end = file.len > 4 ? file.len - 4 : file.len;
    char *name = arena_text(args->arena, as.len ? as : (struct text){file.at, end});
    if (!name)
        return error_memory(error);
    for (size_t i = 0; name[i]; i++)
        name[i] = (name[i] >= '0' && name[i] <= '9') || (name[i] >= 'A' && name[i] <= 'Z') ||
                          (name[i] >= 'a' && name[i] <= 'z') || name[i] == '_' || name[i] == '-'
                      ? name[i]
                      : '-';
    c->options.name = text_of(name);
    if (c->options.name.len > LIMIT_NAME)
        c->options.name.len = LIMIT_NAME;
    return true;
}

HANDLER(collect)
{
    struct collection c = {.session = session, .reply = reply};
    if (session->collecting)
        return steer(session, args, reply, error);
    struct arguments *again = arena_alloc(args->arena, sizeof *again);
    const bool on = has_argument(args, "continue"), anew = on || has_argument(args, "again");
    if (!again)
        return error_memory(error);
    if (session->live.state == LIVE_RUNNING || session->reacting)
        return error_set(error, ERROR_COMMAND, "a run goes on: pause it before");
    if (has_argument(args, "pause") || has_argument(args, "stop"))
        return error_set(error, ERROR_COMMAND, "nothing is being collected");
    if (anew && !repeat(session, args, again, error))
        return false;
    if (on && !go_on_after(&c, session_recording(session)))
        return error_set(error, ERROR_IO, "its file is gone");
    const struct text source = text_given(anew ? again : args, "SOURCE");
    const bool input = text_is(source, "-");
    if (source.len == 0)
        return error_set(error, ERROR_COMMAND, "collect needs a SOURCE: a device, a pipe, or -");
    if (input && !check_input(session, source, error))
        return false;
    c.source = arena_text(args->arena, input ? TEXT(STANDARD_INPUT) : source);
    return c.source ? read_wishes(anew ? again : args, &c, error) && name_it(&c, args, error) &&
                          collect(&c, anew ? again : args, error)
                    : error_memory(error);
}

HANDLER(stop)
{
    UNUSED(args);
    UNUSED(error);
    if (session->collecting)
        session->collecting->stop = true;
    else if (session->live.state == LIVE_RUNNING)
        session->live.pausing = true;
    else
        reply_line(reply, "nothing is running");
    return true;
}
#endif

COMMAND(
    collect,
    .row = {"collect", "", "a recording from a sensor, line by line as it comes", "", NULL},
    .group = "DATA",
    .text = "SOURCE is a serial line (/dev/ttyACM0), a named pipe, a file that grows, or - for "
            "standard input in batch; socat makes a pipe of a socket. Lines are read as 'load' "
            "reads them. Times are those of the device where it sends any, else of the robust line "
            "through the arrivals of its lines, with their jitter. Each line is in FILE at once, "
            "as it came; at the end that is loaded. for= counts from the first line, or from "
            "trigger=, of which before= is kept. Ctrl-C or 'stop' ends it and keeps it; again: "
            "the same into another file; continue: into the same, also after --resume. While it "
            "goes on, pause drops what comes.",
    .examples = "collect /dev/ttyACM0 baud=9600 for=10s unit=cm\ncollect /tmp/sensor "
                "trigger=\"y rising 22 cm\" before=0.5s for=10s to=swing.txt",
    .see = "load stop pause measure fit", .flags = COMMAND_CHANGES | COMMAND_ANYTIME,
    ARGUMENTS(WORD("again", TYPE_NONE, .group = 1), WORD("pause", TYPE_NONE, .group = 1),
              WORD("continue", TYPE_NONE, .group = 1), WORD("stop", TYPE_NONE, .group = 1),
              PLACE("SOURCE", TYPE_FILE, .group = 1), KEY("baud", TYPE_INTEGER),
              KEY("rate", TYPE_VALUE, .quantity = QUANTITY_FREQUENCY),
              KEY("for", TYPE_VALUE, .quantity = QUANTITY_TIME), KEY("max", TYPE_INTEGER),
              KEY("trigger", TYPE_TEXT), KEY("before", TYPE_VALUE, .quantity = QUANTITY_TIME),
              KEY("to", TYPE_FILE), KEY("as", TYPE_TEXT), KEY("t", TYPE_TEXT), KEY("y", TYPE_TEXT),
              KEY("unit", TYPE_UNIT), KEY("tunit", TYPE_UNIT, .quantity = QUANTITY_TIME),
              KEY("decimal", TYPE_CHOICE, .choices = &decimal_catalog),
              KEY("sep", TYPE_CHOICE, .choices = &separator_catalog)))

COMMAND(stop, .row = {"stop", "", "end what is being collected, and keep it", "", NULL},
        .group = "DATA",
        .text = "What came is a recording then, as after 'load'. A run that goes on is paused.",
        .examples = "stop\ncollect again", .see = "collect pause",
        .flags = COMMAND_ANYTIME | COMMAND_UNRECORDED)
