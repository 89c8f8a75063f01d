/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The end of a collection: the collected file becomes an ordinary recording, and what came is
 * reported. */
#include "modules/collect/handlers.h"
#include "modules/recording/recording_text.h"

#include <math.h>
#include <unistd.h>

/* Returns the word for how a collection ended, as its record has it: "silent" if nothing came,
 * "untriggered" if a trigger was awaited in vain, else by what ended the source or, if it goes on,
 * the collection. */
static const char *collection_status(const struct collection *c)
{
    if (c->look.lines == 0 && c->there == 0)
        return "silent";
    if (c->trigger.wanted && isnan(c->trigger.t))
        return "untriggered";
    switch (c->look.end) {
    case FEED_UNPLUGGED:
        return "unplugged";
    case FEED_FULL:
    case FEED_FAILED:
        return "full";
    case FEED_ENDED:
    case FEED_IN_TIME:
        return "ok";
    case FEED_GOES_ON:
        break;
    }
    return c->how == END_IN_TIME ? "ok" : "stopped";
}

/* Writes the record of a finished collection. What is not known is null: the number of lost samples
 * if the device does not number them, the jitter if the device gives the times. */
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
    if (known->lost_known || known->lost > 0)
        reply_int(reply, "lost", (int64_t)known->lost);
    else
        reply_real(reply, "lost", NAN);
    reply_int(reply, "garbled", (int64_t)known->garbled);
    reply_int(reply, "skipped", (int64_t)known->skipped);
    reply_int(reply, "repeated", (int64_t)known->repeated);
    reply_int(reply, "remarks", (int64_t)known->remarks);
    reply_int(reply, "samples", (int64_t)known->samples);
    reply_int(reply, "lines", (int64_t)known->lines);
    reply_real(reply, "t_start", recording->window[0]);
    reply_real(reply, "t_end", recording->t[recording->rows - 1]);
    reply_real(reply, "rate", recording->rate);
    reply_real(reply, "jitter", known->clock == CLOCK_DEVICE ? NAN : known->jitter);
    reply_string(reply, "clock", clocks[known->clock]);
    reply_string(reply, "status", collection_status(c));
    reply_string(reply, "file", c->path);
    reply_end(reply);
}

/* Reports in a line how many lines and samples came, how many were not used and why, and how it
 * ended; warns if the device was unplugged. */
static void report_end(const struct collection *c, const struct recording *recording)
{
    const struct collected *known = recording->collected;
    const struct {
        size_t count;
        const char *what;
    } counts[] = {{known->skipped, "skipped before the first sample"},
                  {known->garbled, "garbled"},
                  {known->repeated, "repeated"},
                  {known->remarks, "remarks"}};
    struct buffer others = {0};
    for (size_t i = 0; i < COUNT_OF(counts); i++)
        if (counts[i].count > 0)
            buffer_format(&others, ", %zu %s", counts[i].count, counts[i].what);
    reply_line(c->reply, "collected from %s into %s: %zu lines, %zu samples%s (%s)", c->from_shown,
               c->to_shown, known->lines, known->samples, buffer_view(&others),
               collection_status(c));
    buffer_free(&others);
    if (c->look.end == FEED_UNPLUGGED)
        reply_warning(c->reply,
                      "%s was disconnected%s%s; 'collect continue' resumes when it is back",
                      c->from_shown, c->look.failure[0] ? ": " : "", c->look.failure);
}

/* Looks for the trigger in the complete recording and begins its window there, c->pretrigger [s]
 * before it. Returns false with an error if the trigger never came, unless the user has stopped
 * waiting for it, which is only a warning. */
static bool await_trigger(struct collection *c, struct recording *recording, struct error *error)
{
    struct trigger *trigger = &c->trigger;
    struct error ignored;
    struct buffer missed = {0};
    const bool waits = trigger->wanted && isnan(trigger->t);
    if (waits && trigger_look(trigger, recording, &c->never))
        reply_note(c->reply, "trigger: %.*s at t = %.6g s", (int)trigger->name.len,
                   trigger->name.data, trigger->t);
    /* The times of the complete recording are final, so the trigger's time is read again. */
    for (size_t i = recording->rows; isfinite(trigger->t) && i > 0; i--)
        if (recording->line[i - 1] >= trigger->line)
            trigger->t = recording->t[i - 1];
    if (trigger->wanted && isfinite(trigger->t))
        recording_window(recording, trigger->t - c->pretrigger, HUGE_VAL, &ignored);
    if (!waits || isfinite(trigger->t))
        return true;
    trigger_missed(trigger, recording, &missed);
    const bool gave_up = c->look.end == FEED_GOES_ON && !c->never.text[0];
    if (gave_up)
        reply_warning(c->reply, "%s", buffer_view(&missed));
    else if (c->never.text[0])
        *error = c->never;
    else
        error_set(error, ERROR_IO, "%s", buffer_view(&missed));
    buffer_free(&missed);
    if (!gave_up && !error->hint[0])
        error_hint(error, "its lines are kept in %.100s; 'load' reads them", c->to_shown);
    return gave_up;
}

/* Reports lines that no format can read: how many came, and how to read them. Returns false. */
static bool report_unread(const struct collection *c, struct error *error)
{
    const struct error why = *error;
    error_set(error, why.code, "%llu %s from %s, but no recording: %s",
              (unsigned long long)(c->look.lines + c->there),
              c->look.lines + c->there == 1 ? "line arrived" : "lines arrived", c->from_shown,
              why.text);
    return error_hint(error,
                      "its lines are kept in %.60s; 'load' with y=, sep= or decimal= may read "
                      "them; or baud=%ld may be wrong",
                      c->to_shown, c->baud);
}

/* Turns the collected file into a recording of the session and reports it; later `record` writes
 * `load FILE`. Returns false with an error if nothing came, nothing can be read, or the file could
 * not be written completely. */
bool collect_finish(struct collection *c, const struct arguments *args, struct error *error)
{
    struct session *session = c->session;
    struct load_options options = c->options;
    const int growing = collect_own_place(c->session);
    if (growing >= 0)
        session_drop_recording(session, growing);
    if (c->look.lines + c->there == 0) {
        if (!c->again)
            unlink(c->path); /* the file has only its heading */
        error_set(error, ERROR_IO, "no data arrived from %s", c->from_shown);
        return error_hint(error,
                          "check that it is connected and switched on; 'cat' shows what it sends");
    }
    struct recording *recording = recording_load(c->path, &options, error);
    if (!recording)
        return report_unread(c, error);
    const int same = session_find_recording(session, text_of(recording->name));
    if (same >= 0)
        session_drop_recording(session, same);
    if (!await_trigger(c, recording, error)) {
        reply_collected(c, recording);
        recording_destroy(recording);
        return false;
    }
    char *load_options = arena_text(args->arena, c->put_options);
    if (!load_options)
        recording_destroy(recording);
    if (!load_options || !session_add_recording(session, recording, load_options, error))
        return load_options ? false : error_memory(error);
    struct buffer *happened = &session->history.happened;
    buffer_put(happened, TEXT("load "));
    buffer_word(happened, text_of(c->path));
    buffer_format(happened, "%s\n", load_options);
    if (recording->window[0] > recording->t[0])
        buffer_format(happened, "data window %.17g:\n", recording->window[0]);
    report_end(c, recording);
    reply_description(recording, c->reply);
    reply_collected(c, recording);
    collect_say_fit(c);
    if (c->look.end != FEED_FAILED)
        return true;
    error_set(error, ERROR_IO,
              "%s could not take more data (%s); what it contains is complete, but %llu %s lost",
              c->to_shown, c->look.failure, (unsigned long long)c->look.unwritten,
              c->look.unwritten == 1 ? "line is" : "lines are");
    return error_hint(error, "it is now a recording; 'collect continue' extends it");
}
