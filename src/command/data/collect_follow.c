/* SPDX-License-Identifier: GPL-3.0-or-later */
/* collect, while lines come: what is shown, waited for and said. */
#include "command/data/collect.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#define LOOK_NS 50000000 /* between looks at what has come */
#define SILENT_S 2.0     /* then it is said what is waited for */
#define PERIODS_SHOWN 8  /* of which the last is told */

int collect_own_place(const struct session *session)
{
    for (int i = 0; i < session->recordings; i++)
        if (session->recording[i]->growing)
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
    int place = collect_own_place(c->session);
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
    const bool waits = c->trigger.wanted && isnan(c->trigger.t) && !c->never.text[0];
    if (!c->session->front.watched && !waits)
        return;
    struct recording *recording = collect_view_read(&c->view, c->look.lines);
    if (!recording)
        return;
    if (waits && trigger_look(&c->trigger, recording, &c->never))
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
        collect_own_place(c->session) < 0 && c->view.problem.text[0]) {
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

bool collect_follow(struct collection *c)
{
    const struct front *front = &c->session->front;
    const struct timespec moment = {.tv_nsec = LOOK_NS};
    bool interrupted = false;
    for (;;) {
        front->feed->look(c->state.feed, &c->look);
        look_at_recording(c);
        say_waiting(c);
        tell_state(c);
        if (c->look.end != FEED_GOES_ON || c->state.stop || c->session->quit || interrupted ||
            c->never.text[0])
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
