/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a student of the lab does next with the recording that was loaded last: offered at the
 * prompt, where an empty Enter takes it. */
#include <hooke/command/handler.h>
#include "command/session/lesson.h"

#include <hooke/session/log.h>

#include <string.h>

#define LONG_S 30 /* [s] a recording for the decay, above it; for the period, below it */
#define STEP_S 0.01
#define UNDAMPED_S 10 /* [s] runs of the lab sheet's first session, and of its second */
#define DAMPED_S 20

struct done { /* since the recording was loaded; one statement a line */
    const struct session *session;
    const struct recording *recording;
    struct text script;
    bool decays; /* it is the long one */
};

/* A stage follows the last statement that begins with `after`, until one begins with `until`, or
 * with what ends a later stage. */
struct stage {
    const char *after, *until;
    enum { EITHER, FIRST, SECOND } part; /* of the lab: without damping, with it */
    void (*put)(const struct done *done, struct buffer *line);
};

/* Where the last statement stands that begins so; NULL: none does. */
static const char *last(struct text script, const char *beginning)
{
    const char *found = NULL;
    struct text line;
    const size_t len = strlen(beginning);
    while (script.len > 0 && text_split(&script, '\n', &line))
        if (text_starts(line, text_of(beginning)) && (line.len == len || line.at[len] == ' '))
            found = line.at;
    return found;
}

static double span(const struct recording *recording)
{
    return recording->window[1] - recording->window[0];
}

static void put_measuring(const struct done *done, struct buffer *line)
{
    buffer_format(line, "plot position data %s; measure period; ", done->recording->name);
    if (!done->decays) {
        buffer_put(line, TEXT("measure frequency; measure amplitude"));
        return;
    }
    /* six readings, as the sheet asks, the first and the last away from the ends */
    const double from = done->recording->window[0], gap = span(done->recording) / 6;
    buffer_put(line, TEXT("measure amplitude at="));
    for (int i = 0; i < 6; i++)
        buffer_format(line, "%s%.0f", i ? "," : "", floor(from + (i + 0.25) * gap));
    buffer_put(line, TEXT("; measure decay"));
}

static bool mass_said(struct text script)
{
    struct text line;
    bool said = false;
    while (script.len > 0 && text_split(&script, '\n', &line)) {
        const bool set = text_starts(line, TEXT("set m "));
        line = text_starts(line, TEXT("m")) ? text_trim((struct text){line.at + 1, line.len - 1})
                                            : TEXT("");
        said |= set || text_starts(line, TEXT("="));
    }
    return said;
}

static void put_fit(const struct done *done, struct buffer *line)
{
    buffer_put(line, TEXT("fit damped"));
    if (mass_said(done->script))
        buffer_put(line,
                   done->decays ? TEXT("; measure k; measure reynolds") : TEXT("; measure k"));
}

static void put_adopt(const struct done *done, struct buffer *line)
{
    const double *window = done->recording->window;
    if (done->decays) /* where gamma is what it is in the run, which is laid over it */
        buffer_format(line, "fit damped window=%g:%g; adopt", window[0], window[0] + DAMPED_S);
    else
        buffer_put(line, TEXT("adopt amplitude; gamma = 0"));
}

static void put_run(const struct done *done, struct buffer *line)
{
    const double most = done->decays ? DAMPED_S : UNDAMPED_S;
    const double whole = floor(span(done->recording) + 0.5);
    buffer_format(line, "method %s dt=%g ms; run %g s", done->decays ? "rk4" : "euler",
                  1000 * STEP_S, whole >= 1 && whole < most ? whole : most);
}

static void put_plots(const struct done *done, struct buffer *line)
{
    const struct run *run = session_run(done->session);
    if (done->decays)
        buffer_format(line,
                      "plot position run %d data %s; plot energy; measure decay of run %d; "
                      "measure decay of energy",
                      run->number, done->recording->name, run->number);
    else
        buffer_put(line, TEXT("plot position; plot velocity; plot phase"));
}

static void put_energy(const struct done *done, struct buffer *line)
{
    (void)done;
    buffer_put(line, TEXT("plot energy; measure energy; measure drift"));
}

static void put_compare(const struct done *done, struct buffer *line)
{
    const int number = done->session->next_run;
    buffer_format(line,
                  "compare euler symplectic-euler; plot energy run %d %d; plot phase run %d %d",
                  number, number + 1, number, number + 1);
}

static void put_report(const struct done *done, struct buffer *line)
{
    (void)done;
    buffer_put(line, TEXT("report lab-report"));
}

static const struct stage stages[] = {
    {"load", "plot position data", EITHER, put_measuring},
    {"load", "fit", EITHER, put_fit},
    {"fit", "adopt", EITHER, put_adopt},
    {"adopt", "run", EITHER, put_run},
    {"run", "plot position", EITHER, put_plots},
    {"run", "plot energy", FIRST, put_energy},
    {"run", "compare", FIRST, put_compare},
    {"run", "report", SECOND, put_report},
};

void command_next(const struct session *session, struct buffer *line)
{
    struct buffer script = {0};
    struct lesson_step step;
    if (session->lesson && session->lesson->step < session->lesson->steps) {
        /* once: what it has to say is then read, and checked */
        if (lesson_step(session->lesson, session->lesson->step, &step)) {
            struct text rest = step.command, first = TEXT("");
            text_split(&rest, ';', &first);
            if (first.len > 0 && !lesson_done(session, text_trim(first)))
                buffer_put(line, step.command);
        }
        return;
    }
    if (session->collecting && session->collecting->aim.waits) {
        buffer_put(line, TEXT("calibrate take"));
        return;
    }
    struct done done = {session, session_recording(session), {0}, false};
    if (!done.recording)
        return;
    history_put(session, 0, HISTORY_RECORD, &script);
    done.script = buffer_text(&script);
    const char *loaded = last(done.script, "load");
    if (loaded && !script.failed) {
        done.script.len -= (size_t)(loaded - done.script.at);
        done.script.at = loaded;
        done.decays = span(done.recording) > LONG_S;
        const int part = done.decays ? SECOND : FIRST;
        const struct stage *due = NULL;
        const char *due_after = NULL;
        for (size_t i = 0; i < COUNT_OF(stages); i++) {
            const char *after = last(done.script, stages[i].after);
            const char *until = last(done.script, stages[i].until);
            if (stages[i].part != EITHER && (int)stages[i].part != part)
                continue;
            if (!after || (after[0] == 'r' && !session_run(session)))
                break;
            const bool is_done = until && until >= after;
            if (is_done && due && until > due_after)
                due = NULL; /* it was passed over */
            if (!is_done && !due) {
                due = &stages[i];
                due_after = after;
            }
        }
        if (due)
            due->put(&done, line);
    }
    buffer_free(&script);
}
