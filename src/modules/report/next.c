/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Suggests what a student of the lab does next with the recording that was loaded last. The prompt
 * offers the line of report_next(), and an empty Enter takes it. */
#include <hooke/data.h>
#include <hooke/command/handler.h>
#include "modules/report/lesson.h"

#include "modules/recording/fits.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define LONG_S 30     /* [s] longer recordings are of the decay, shorter ones of the period */
#define STEP_S 0.01   /* [s] time step of the lab sheet */
#define UNDAMPED_S 10 /* [s] length of runs of the lab sheet's first session */
#define DAMPED_S 20   /* [s] length of runs of its second session */
#define REPORT_FOLDER "lab-report" /* Folder that is handed in. */

/* The recording in use, and what was done with it since it was loaded. */
struct lab {
    const struct session *session;
    const struct recording *recording;
    char name[LIMIT_NAME + 16]; /* subject of its measurements: "data swing3" */
    size_t loaded;              /* statement of the log that loaded it, counted from 1 */
    bool decays;                /* the recording is long, so that its decay is to be measured */
};

/* Returns true if a subject that begins with `subject` was measured after that statement of the
 * log. quantity NULL matches any quantity. */
static bool is_measured(const struct session *session, const char *subject, const char *quantity,
                        size_t previous_statement)
{
    for (int i = session->measurements; i-- > 0;) {
        const struct measurement *m = &session->measurement[i];
        if (m->statement > previous_statement &&
            text_starts(text_of(m->source), text_of(subject)) &&
            (!quantity || strcmp(m->quantity, quantity) == 0))
            return true;
    }
    return false;
}

/* Returns the statement of the last fit of the recording, or 0 if there was none. */
static size_t last_fit(const struct lab *lab)
{
    const struct fits *fits = fits_of(lab->session);
    int i = fits->stored_fits;
    while (i > 0 && strcmp(fits->stored_fit[i - 1].subject, lab->name) != 0)
        i--;
    const size_t statement = i > 0 ? fits->stored_fit[i - 1].statement : 0;
    return statement > lab->loaded ? statement : 0;
}

/* Returns the statement that changed a parameter of the scene last, or 0. */
static size_t last_change(const struct session *session)
{
    const struct setup *setup = &session->setup;
    size_t last = 0;
    for (size_t i = 0; i < scene_params(&setup->scene)->count; i++)
        last = setup->origin[i] > last ? setup->origin[i] : last;
    return last;
}

/* Returns true if a run was made after that statement, by this method unless it is NULL. */
static bool has_run(const struct session *session, const char *method, size_t previous_statement)
{
    for (int i = session->runs.count; i-- > 0;) {
        const struct run_slot *slot = session->runs.slot[i];
        if (slot->statement > previous_statement &&
            (!method || strcmp(slot->run->method->row.name, method) == 0))
            return true;
    }
    return false;
}

/* Returns the length of the used part of the recording [s]. */
static double recording_span(const struct recording *recording)
{
    return recording->window[1] - recording->window[0];
}

/* Suggests to plot and measure: period and amplitude, or the decay of a long recording. */
static void put_measuring(const struct lab *lab, struct buffer *line)
{
    buffer_format(line, "plot position data %s; measure period; ", lab->recording->name);
    if (!lab->decays) {
        buffer_put(line, TEXT("measure frequency; measure amplitude"));
        return;
    }
    /* six readings, as the sheet asks, the first and the last away from the ends */
    buffer_put(line, TEXT("measure amplitude at="));
    lesson_readings(lab->recording, line);
    buffer_put(line, TEXT("; measure decay"));
}

/* Suggests a fit, and what follows from it once the mass has been set. */
static void put_fit(const struct lab *lab, struct buffer *line)
{
    const struct setup *setup = &lab->session->setup;
    const int mass = scene_param(&setup->scene, "m");
    buffer_put(line, TEXT("fit damped"));
    if (mass >= 0 && setup->origin[mass] > lab->loaded) /* it is known what hangs there */
        buffer_put(line, lab->decays ? TEXT("; measure k; measure reynolds") : TEXT("; measure k"));
}

/* Suggests to take the fit over; the undamped simulation takes the amplitude alone. */
static void put_adopt(const struct lab *lab, struct buffer *line)
{
    const double *window = lab->recording->window;
    if (lab->decays) /* a window in which gamma equals that of the overlaid run */
        buffer_format(line, "fit damped window=%g:%g; adopt", window[0], window[0] + DAMPED_S);
    else
        buffer_put(line, TEXT("adopt amplitude; gamma = 0"));
}

/* Suggests a run of the length of the recording, at most that of the lab sheet. */
static void put_run(const struct lab *lab, struct buffer *line)
{
    const double most = lab->decays ? DAMPED_S : UNDAMPED_S;
    const double whole_seconds = floor(recording_span(lab->recording) + 0.5);
    const double duration = whole_seconds >= 1 && whole_seconds < most ? whole_seconds : most;
    buffer_format(line, "method %s dt=%g ms; run %g s", lab->decays ? "rk4" : "euler",
                  1000 * STEP_S, duration);
}

/* Suggests the plots and measurements of the run that the lab asks for. */
static void put_plots(const struct lab *lab, struct buffer *line)
{
    const struct run *run = session_run(lab->session);
    if (lab->decays)
        buffer_format(line,
                      "plot position run %d data %s; plot energy; measure decay of run %d; "
                      "measure decay of energy",
                      run->number, lab->recording->name, run->number);
    else
        buffer_put(line, TEXT("plot position; plot velocity; plot phase; plot energy; measure "
                              "energy; measure drift"));
}

/* Suggests to compare two methods and to plot both runs; their numbers are the next ones. */
static void put_compare(const struct lab *lab, struct buffer *line)
{
    const int number = lab->session->runs.next_number;
    buffer_format(line,
                  "compare euler symplectic-euler; plot energy run %d %d; plot phase run %d %d",
                  number, number + 1, number, number + 1);
}

/* Suggests what remains of the command of the lesson's current step. A measurement is suggested
 * once, so that its result is read and checked. */
static void put_step(const struct session *session, struct buffer *line)
{
    const struct lesson *lesson = session_lesson(session);
    struct lesson_step step;
    struct named_value found;
    struct buffer command = {0};
    if (!lesson_step(lesson, lesson->step, &step) ||
        (step.measured && lesson_found(session, &step, &found)))
        return;
    lesson_expand(session, step.command, true, &command);
    lesson_remaining(session, buffer_text(&command), lesson->begun, lesson_set_since, line);
    buffer_free(&command);
}

/* Returns the place in the log at which the recording in use was loaded. */
static size_t loaded_since(const struct session *session, struct text name)
{
    (void)name;
    return session->recording[session->current_recording]->statement;
}

/* Appends the first command of the lab sheet that has not been executed with the recording:
 * measure, fit, adopt, run, plots, and a comparison of methods or the report. */
static void put_due(const struct lab *lab, struct buffer *line)
{
    const struct session *session = lab->session;
    const struct adopted_fit *adopted = &fits_of(session)->adopted;
    const size_t fit = last_fit(lab), change = last_change(session);
    if (!is_measured(session, lab->name, NULL, lab->loaded))
        put_measuring(lab, line);
    else if (fit == 0)
        put_fit(lab, line);
    else if (adopted->statement < fit || strcmp(adopted->subject, lab->name) != 0)
        put_adopt(lab, line);
    else if (!has_run(session, NULL, change))
        put_run(lab, line);
    else if (!is_measured(session, "run ", lab->decays ? "decay" : "drift", change))
        put_plots(lab, line);
    else if (!lab->decays && !has_run(session, "symplectic-euler", change))
        put_compare(lab, line);
    else if (lab->decays && access(REPORT_FOLDER, F_OK) != 0)
        buffer_put(line, TEXT("report " REPORT_FOLDER));
}

/* Suggests in *line the next command: what remains of the current step of a lesson, otherwise the
 * next step with the recording. Returns false if there is nothing to suggest. */
bool report_next(const struct session *session, struct buffer *line)
{
    const struct lesson *lesson = session_lesson(session);
    struct lab lab = {session, session_recording(session), "", 0, false};
    if (lesson && lesson->step < lesson->steps) {
        put_step(session, line);
        return true;
    }
    if (lab.recording) {
        snprintf(lab.name, sizeof lab.name, "data %s", lab.recording->name);
        lab.loaded = session->recording[session->current_recording]->statement;
        lab.decays = recording_span(lab.recording) > LONG_S;
        struct buffer due = {0};
        put_due(&lab, &due);
        lesson_remaining(session, buffer_text(&due), session->history.count, loaded_since, line);
        buffer_free(&due);
    }
    return line->len > 0;
}
