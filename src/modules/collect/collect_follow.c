/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Follows a collection while lines arrive: shows them, waits for the trigger, tells the user what
 * is missing, and ends at the time limit. collect_follow() is the loop. */
#include "modules/collect/handlers.h"
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>
#include "modules/recording/fits.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define LOOK_NS 50000000 /* [ns] interval between two readings of the file */
#define SILENT_S 2.0     /* [s] silence after which the user is told what is missing */

/* Returns the index of the growing recording among the session's recordings, or -1. */
int collect_own_place(const struct session *session)
{
    for (int i = 0; i < session->recordings; i++)
        if (session->recording[i]->growing)
            return i;
    return -1;
}

/* Adds `recording`, the first readable rows, to the session as the growing recording, in place of
 * one of the same name. Takes over the recording, and frees it if out of memory. */
static void show_first_rows(struct collection *c, struct recording *recording)
{
    struct error ignored;
    const int same = session_find_recording(c->session, c->options.name);
    if (same >= 0)
        session_drop_recording(c->session, same);
    snprintf(recording->name, sizeof recording->name, "%.*s", (int)c->options.name.len,
             c->options.name.data);
    struct buffer options = {0};
    buffer_put(&options, c->put_options);
    if (!growth_begin(&c->live.growth, recording))
        recording_destroy(recording);
    else if (session_add_recording(c->session, recording, buffer_view(&options), &ignored))
        c->session->recording[c->session->recordings - 1]->growing = true;
    buffer_free(&options);
}

/* Adds new rows to the growing recording, or replaces it if its columns have changed. Takes over
 * `more`. */
static void collection_show(struct collection *c, struct recording *more)
{
    int place = collect_own_place(c->session);
    bool other = false;
    if (place >= 0) {
        struct recording *grown = c->session->recording[place]->recording;
        recording_grow(grown, &c->live.growth, more, &other);
        session_changed(c->session);
        if (other)
            session_drop_recording(c->session, place);
    }
    if (place < 0 || other)
        show_first_rows(c, more);
    else
        recording_destroy(more);
    place = collect_own_place(c->session);
    if (place >= 0)
        collect_find(c, c->session->recording[place]->recording);
}

/* Appends the calibration to the file. Returns false with an error if that fails. */
bool collect_put_calibration(const struct collection *c, struct error *error)
{
    struct buffer line = {0};
    buffer_put(&line, TEXT(COLLECTED_CALIBRATION));
    calibration_put(&c->calibration, &line);
    buffer_char(&line, '\n');
    const int fd = append_open(c->path, session_policy(c->session, false), 0666, error);
    const bool ok = fd >= 0 && append_lines(fd, buffer_text(&line), true, error);
    if (fd >= 0)
        close(fd);
    buffer_free(&line);
    return ok;
}

/* Adopts a calibration that the user made while data are collected: writes it to the collected
 * file, drops the recording made so far, and restarts reading the file from its beginning, so that
 * all values are converted anew. Does nothing if the calibration is unchanged. */
static void apply_new_calibration(struct collection *c)
{
    const struct calibration *wanted = &c->session->setup.calibration;
    struct error error;
    if (!wanted->decided || memcmp(wanted, &c->calibration, sizeof *wanted) == 0)
        return;
    c->calibration = *wanted;
    if (!collect_put_calibration(c, &error))
        reply_warning(c->reply, "the calibration was not written to the file: %s", error.text);
    collect_view_restart(&c->view);
    c->live.laid.model = NULL; /* the run beside the data is computed again */
    const int place = collect_own_place(c->session);
    if (place >= 0)
        session_drop_recording(c->session, place);
}

/* Reads new rows if they are shown or a trigger is awaited; looks for the trigger and shows them.
 */
static void read_new_rows(struct collection *c)
{
    apply_new_calibration(c);
    const bool waits = c->trigger.wanted && isnan(c->trigger.t) && !c->never.text[0];
    const bool shows = c->session->front.watched || fits_of(c->session)->live;
    if (!shows && !waits)
        return;
    struct recording *recording = collect_view_read(&c->view, c->look.lines);
    if (!recording)
        return;
    if (waits && trigger_look(&c->trigger, recording, &c->never))
        reply_note(c->reply, "trigger: %.*s at t = %.6g s", (int)c->trigger.name.len,
                   c->trigger.name.data, c->trigger.t);
    if (shows)
        collection_show(c, recording);
    else
        recording_destroy(recording);
}

/* Reads all rows that are still unread and fits all data once more, before the collection ends. */
void collect_fit_last(struct collection *c)
{
    /* view.lines is 0 after a reading that has not reached the end of the file. Times `due` of 0
     * allow the next reading and the next fit at once. */
    do {
        c->view.due = c->live.fit_due = 0;
        read_new_rows(c);
    } while (c->view.lines == 0 && collect_own_place(c->session) >= 0);
    const int place = collect_own_place(c->session);
    if (place < 0)
        return;
    struct recording *all = c->session->recording[place]->recording;
    if (c->state.fit.t != all->t[all->rows - 1]) { /* rows that were read but not fitted */
        c->live.fit_due = 0;
        collect_find(c, all);
    }
}

/* Tells the user, once each, that nothing arrives from the source, or that no line can be read as a
 * sample. */
static void report_waiting(struct collection *c)
{
    const struct feed_look *look = &c->look;
    if (!c->said_silent && look->lines == 0 && look->now - c->t_begin > SILENT_S) {
        c->said_silent = true;
        if (look->bytes == 0)
            reply_note(
                c->reply,
                "%s has sent nothing for %.0f s; waiting for its first line (Ctrl-C ends this)",
                c->source, SILENT_S);
        else
            reply_note(c->reply,
                       "%s has sent %llu bytes but no line end; baud=%ld may be wrong; waiting "
                       "(Ctrl-C ends this)",
                       c->from_shown, (unsigned long long)look->bytes, c->baud);
    }
    if (!c->said_none && look->lines > 20 && look->now - look->first > SILENT_S &&
        collect_own_place(c->session) < 0 && c->view.problem.text[0]) {
        c->said_none = true;
        reply_note(c->reply, "there is no sample yet in %llu lines: %s",
                   (unsigned long long)look->lines, c->view.problem.text);
    }
}

/* Sets the time at which the axes of the panes end, if it is known. */
static void update_end(struct collection *c)
{
    const int place = collect_own_place(c->session);
    const struct recording *shown = place >= 0 ? c->session->recording[place]->recording : NULL;
    double t_begin;
    if (c->trigger.wanted)
        t_begin = c->trigger.t;
    else
        t_begin = shown && !c->again ? shown->t[0] : NAN;
    const double end = t_begin + c->length + c->idle;
    c->state.growing.t_end = end < HUGE_VAL ? end : NAN;
}

/* Updates the state line, the time limit of the feed, and the progress; stops the collection at its
 * end. */
static void update_state(struct collection *c)
{
    struct collecting *state = &c->state;
    const bool waits = c->trigger.wanted && isnan(c->trigger.t);
    /* Uses the clock of the arrivals, because a device's clock may have started hours ago. */
    /* - */
    const double start = c->trigger.wanted ? c->trigger.arrival : c->look.first;
    if (state->state != COLLECT_PAUSED)
        state->state = waits ? COLLECT_WAITING : COLLECT_GOES_ON;
    else if (c->look.now > start)
        c->idle += c->look.now - fmax(start, c->looked);
    c->looked = c->look.now;
    state->lines = c->look.lines + c->there;
    state->seconds = isnan(start) ? 0 : c->look.now - start - c->idle;
    update_end(c);
    const double end = start + c->length + c->idle;
    c->session->front.feed->limit(
        state->feed, end < HUGE_VAL && state->state == COLLECT_GOES_ON ? end : HUGE_VAL);
    if (state->seconds >= c->length && state->state == COLLECT_GOES_ON) {
        state->stop = true;
        c->how = END_IN_TIME;
    }
    const struct front *front = &c->session->front;
    if (!front->watched && front->progress && c->session->execution.typed)
        front->progress(front->context, NULL,
                        isfinite(c->length) ? fmin(1, state->seconds / c->length) : 0);
}

/* Waits for lines, handles them every LOOK_NS and serves the front end, until the collection ends.
 * Returns true if Ctrl-C ended it. */
bool collect_follow(struct collection *c)
{
    const struct front *front = &c->session->front;
    const struct timespec moment = {.tv_nsec = LOOK_NS};
    bool interrupted = false;
    for (;;) {
        front->feed->look(c->state.feed, &c->look);
        read_new_rows(c);
        report_waiting(c);
        update_state(c);
        if (c->look.end != FEED_GOES_ON || c->state.stop || c->session->execution.quit ||
            interrupted || c->never.text[0])
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
