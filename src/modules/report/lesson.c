/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands that take a student through a lesson, step by step (lab, check, hint, skip, again). */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>
#include "modules/report/lab.h"
#include "modules/report/lesson.h"

#include <hooke/base/numeric.h>
#include <hooke/base/unit.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- steps ---- */

/* Replies with the current step of the open lesson and its number, or that the lesson is finished,
 * and the record `lesson`. The step's command is printed only where no prompt offers it for
 * editing. */
static void say_step(const struct session *session, struct reply *reply)
{
    const struct lesson *lesson = session_lesson(session);
    struct lesson_step step;
    struct buffer text = {0}, command = {0};
    int width, height;
    session_size(session, &width, &height);
    const bool there = lesson_step(lesson, lesson->step, &step);
    if (!there) {
        reply_line(reply, "the lesson is finished; 'lab seed=N' repeats it with other numbers");
    } else {
        buffer_format(&text, "%d/%d: ", lesson->step + 1, lesson->steps);
        lesson_expand(session, step.says, false, &text);
        lesson_expand(session, step.command, true, &command);
        reply_paragraph(reply, buffer_text(&text), width);
        if (!session->front.interactive || lesson_asks_mass(session))
            reply_line(reply, "  type: %s", buffer_view(&command));
        if (!step.done)
            reply_line(reply, "  then: check VALUE   (or hint, skip)");
    }
    reply_begin(reply, "lesson");
    reply_int(reply, "step", lesson->step + 1);
    reply_int(reply, "steps", lesson->steps);
    reply_string(reply, "state", there ? "waits" : "over");
    reply_end(reply);
    buffer_free(&text);
    buffer_free(&command);
}

/* Makes `step` the current one, writes its recording if it needs one, and prints it. If the lesson
 * moves forward, stores in lesson->passed where in the log the previous step ended. Returns false
 * with *error. */
static bool go_to_step(struct session *session, int step, struct reply *reply, struct error *error)
{
    struct lesson *lesson = session_lesson(session);
    if (step > lesson->step)
        lesson->passed[lesson->step] = session->history.count;
    lesson->step = step;
    lesson->begun = session->history.count;
    session_changed(session);
    if (!lesson_files(session, reply, error))
        return false;
    say_step(session, reply);
    lesson->asks_mass = lesson_asks_mass(session);
    return true;
}

void lesson_label(const struct session *session, struct buffer *text)
{
    const struct lesson *lesson = session_lesson(session);
    if (lesson && lesson->step < lesson->steps)
        buffer_format(text, "lab %d/%d", lesson->step + 1, lesson->steps);
}

/* Prints the step's command if it needs a mass that was given before, and undo took it back. */
static void ask_mass_again(const struct session *session, struct lesson *lesson,
                           struct reply *reply)
{
    const bool asks = lesson_asks_mass(session);
    struct lesson_step step;
    struct buffer command = {0};
    if (asks && !lesson->asks_mass && lesson_step(lesson, lesson->step, &step)) {
        lesson_expand(session, step.command, true, &command);
        reply_line(reply, "the mass is not set: type: %s", buffer_view(&command));
    }
    buffer_free(&command);
    lesson->asks_mass = asks;
}

/* Warns if the next step cannot be begun. */
void lesson_follow(struct session *session, struct reply *reply)
{
    struct error error = {0};
    struct lesson_step step;
    struct lesson *lesson = session_lesson(session);
    if (!lesson || !lesson_step(lesson, lesson->step, &step))
        return;
    if (!step.done || !lesson_done(session, step.wanted))
        ask_mass_again(session, lesson, reply);
    else if (!go_to_step(session, lesson->step + 1, reply, &error))
        reply_warning(reply, "%s", error.text);
}

/* Returns true if a lesson has a step that waits; otherwise sets *error. */
static bool require_lesson(const struct session *session, struct error *error)
{
    struct lesson_step step;
    if (session_lesson(session) &&
        lesson_step(session_lesson(session), session_lesson(session)->step, &step))
        return true;
    error_set(error, ERROR_COMMAND, "no lesson is active");
    return error_hint(error, "'lab' begins one");
}

/* Returns true, and tells the user, if the lesson's first step asks for a recording and a suitable
 * one is loaded already: one of the user's own, or the one that the lesson generates with the same
 * seed. */
static bool is_loaded(const struct session *session, struct reply *reply)
{
    struct lesson_step step;
    const struct lesson *lesson = session_lesson(session);
    const struct recording *recording = session_recording(session);
    long seed;
    bool is_disk;
    if (!recording || !lesson_step(lesson, 0, &step) || !step.done || !text_is(step.wanted, "load"))
        return false;
    if (lesson_generated(recording, &seed, &is_disk) &&
        (seed != lesson->seed || is_disk != step.disk))
        return false;
    reply_line(reply, "the recording is %s, which is already loaded", recording->name);
    return true;
}

/* Executes `lab figure N [> FILE]`: draws the figures of question N as the report does, by running
 * the plot commands that one would type, which are shown before their output. Returns false with
 * *error if N is missing, the question has no figure, or a command fails. */
static bool draw_question(struct session *session, const struct arguments *args,
                          struct reply *reply, struct error *error)
{
    const struct argument_value *number = argument_value(args, "NUMBER"),
                                *file = argument_value(args, ">");
    struct report *report = arena_alloc(args->arena, sizeof *report);
    struct session *view = arena_alloc(args->arena, sizeof *view);
    struct buffer lines = {0};
    static const struct source prompt = {.name = NULL};
    if (!report || !view)
        return error_memory(error);
    if (!number->count) {
        error_set(error, ERROR_COMMAND, "'lab figure' needs the number of a question");
        return error_hint(error, "for example: lab figure 5");
    }
    *view = *session;
    *report = (struct report){.session = session, .view = view, .arena = args->arena};
    bool ok = collect_values(report, error) && sort_material(report, error) &&
              question_figures(report, (int)number->item->value.value,
                               file->count ? file->item->text : TEXT(""),
                               has_argument(args, "force"), &lines, error);
    if (ok) {
        struct script script;
        struct text rest = buffer_text(&lines), line;
        script_begin(&script, session, "lab", args->where ? args->where : &prompt);
        while (!script.stopped && text_split(&rest, '\n', &line) && line.len > 0) {
            if (reply->format == FORMAT_TEXT)
                reply_line(reply, "hooke> %.*s", (int)line.len, line.data);
            script_feed(&script, session, line, reply);
        }
        ok = script_end(&script, session, reply);
    }
    buffer_free(&lines);
    return ok;
}

/* Returns false with an error if there are arguments that only `lab figure` has. */
static bool refuse_figure_arguments(const struct arguments *args, struct error *error)
{
    static const char *const names[] = {"NUMBER", ">", "force"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (argument_value(args, names[i])->count || has_argument(args, names[i])) {
            error_at(error, argument_value(args, names[i])->where,
                     "only 'lab figure N' takes this");
            return error_hint(error, "for example: lab figure 5 > energy.svg");
        }
    return true;
}

/* Opens a lesson, repeats the current step, draws the figures of a question, or ends the lesson
 * (`lab off`). */
HANDLER(lab)
{
    const struct argument_value *name = argument_value(args, "NAME"),
                                *seed = argument_value(args, "seed");
    if (name->count && text_is(name->item->text, "figure"))
        return draw_question(session, args, reply, error);
    if (!refuse_figure_arguments(args, error))
        return false;
    if (name->count && text_is(name->item->text, "off")) {
        struct lesson *lesson = session_lesson(session);
        if (lesson)
            lesson_free(lesson);
        session_changed(session);
        reply_line(reply, "the lesson has ended");
        return true;
    }
    struct lesson *waiting = session_lesson(session);
    const bool is_waiting = waiting && waiting->step < waiting->steps;
    if (is_waiting && !name->count && !seed->count) {
        reply_line(reply, "the lesson continues here; 'lab off' ends it");
        return go_to_step(session, waiting->step, reply, error);
    }
    if (is_waiting && waiting->step > 0) {
        error_set(error, ERROR_COMMAND, "a lesson is in progress at step %d of %d",
                  waiting->step + 1, waiting->steps);
        return error_hint(error, "'lab off' ends it, 'lab' alone repeats its step");
    }
    const long number = seed->count ? (long)seed->item->value.value : 1;
    return lesson_open(session, name->count ? name->item->text : TEXT("lab"), number, args,
                       error) &&
           go_to_step(session, is_loaded(session, reply), reply, error);
}

/* ---- checks ---- */

/* Returns true if the unit of an answer fits the quantity. A bare number is taken in the SI unit;
 * 1/s fits each kind of frequency. */
static bool fits_unit(const struct item *item, enum quantity quantity)
{
    return item->quantity == QUANTITY_OTHER || item->quantity == QUANTITY_NUMBER ||
           quantity == QUANTITY_OTHER || item->quantity == quantity ||
           (item->quantity == QUANTITY_RATE &&
            (quantity == QUANTITY_FREQUENCY || quantity == QUANTITY_ANGULAR_FREQUENCY));
}

/* Adds other forms in which the wanted value[0] may be given: a period as a frequency, a decay as
 * the time in which the amplitude falls to 1/e, a growth as a factor. Returns the number of forms,
 * at least 1. */
static int equivalent_values(const struct lesson_step *step, struct named_value value[3])
{
    const double x = value[0].value, relative = value[0].uncertainty / x;
    int count = 1;
    if (step->done || !step->measured)
        return count;
    if (text_is(step->wanted, "decay"))
        value[count++] = (struct named_value){
            .value = 2 / x, .uncertainty = 2 / x * relative, .quantity = QUANTITY_TIME};
    if (text_is(step->wanted, "period")) {
        value[count++] = (struct named_value){
            .value = 1 / x, .uncertainty = relative / x, .quantity = QUANTITY_FREQUENCY};
        value[count++] = (struct named_value){.value = 2 * PI / x,
                                              .uncertainty = 2 * PI * relative / x,
                                              .quantity = QUANTITY_ANGULAR_FREQUENCY};
    }
    if (text_is(step->wanted, "drift"))
        value[count++] =
            (struct named_value){.value = x + 1, .uncertainty = NAN, .quantity = QUANTITY_NUMBER};
    return count;
}

/* Verdicts on an answer. If it has several forms, the last one that applies to any of them counts.
 */
enum verdict { ANSWER_OTHER_UNIT, ANSWER_VAGUE, ANSWER_WRONG, ANSWER_RIGHT };

/* Compares the user's answer with the wanted value. It is right within three uncertainties (of both
 * values) or, if the answer has none, within its first digits. An answer with a large uncertainty
 * is refused as vague, since nearly every value would be right. */
static enum verdict answer_verdict(const struct item *item, const struct named_value *wanted)
{
    const double stated = item->value.uncertainty;
    const double own = isfinite(wanted->uncertainty) ? fabs(wanted->uncertainty) : 0;
    const double rounding = stated > 0 ? 0 : LESSON_DIGITS * fabs(wanted->value);
    if (!fits_unit(item, wanted->quantity))
        return ANSWER_OTHER_UNIT;
    if (stated > fmax(LESSON_VAGUE_RATIO * own, LESSON_VAGUE * fabs(item->value.value)))
        return ANSWER_VAGUE;
    return fabs(item->value.value - wanted->value) <= fmax(3 * hypot(own, stated), rounding)
               ? ANSWER_RIGHT
               : ANSWER_WRONG;
}

/* Appends the kinds of answers that a step takes: "time [s] or frequency [Hz]". */
static void put_kinds(const struct named_value *value, int count, struct buffer *output)
{
    for (int i = 0; i < count; i++) {
        const char *unit = quantity_unit(value[i].quantity);
        if (i > 0 && value[i].quantity == value[i - 1].quantity)
            continue;
        buffer_put(output, i > 0 ? TEXT(" or ") : TEXT(""));
        if (*unit)
            buffer_format(output, "%s [%s]", quantity_name(value[i].quantity), unit);
        else
            buffer_put(output, TEXT("a number without unit"));
    }
}

/* Tells why an answer is not correct, and adds the record `lesson`. */
static void say_wrong(const struct session *session, const struct item *item, enum verdict verdict,
                      const struct named_value *value, int count, struct reply *reply)
{
    struct buffer kinds = {0};
    put_kinds(value, count, &kinds);
    if (verdict == ANSWER_OTHER_UNIT)
        reply_line(reply, "not correct: its unit is that of %s; this step takes %s",
                   quantity_name(item->quantity), buffer_view(&kinds));
    else
        reply_line(reply, "not correct: outside the stated uncertainty ('hint' helps, 'again' "
                          "shows the step again)");
    reply_begin(reply, "lesson");
    reply_int(reply, "step", session_lesson(session)->step + 1);
    reply_int(reply, "steps", session_lesson(session)->steps);
    reply_string(reply, "state", "wrong");
    reply_end(reply);
    buffer_free(&kinds);
}

/* Checks the student's answer and goes to the next step if it is right. Messages never reveal the
 * wanted value. */
HANDLER(check)
{
    const struct argument_value *value = argument_value(args, "VALUE");
    struct lesson_step step;
    struct named_value found[3] = {{.error_floor = 0}};
    if (!require_lesson(session, error) ||
        !lesson_step(session_lesson(session), session_lesson(session)->step, &step))
        return false;
    if (step.done ? !lesson_done(session, step.wanted) : !lesson_found(session, &step, found)) {
        struct buffer command = {0};
        lesson_expand(session, step.command, true, &command);
        error_set(
            error, ERROR_COMMAND,
            "not yet: this step's command has not been executed, or a parameter has changed since");
        error_hint(error, "type: %s", buffer_view(&command));
        buffer_free(&command);
        return false;
    }
    if (!step.done && !value->count)
        return error_set(error, ERROR_COMMAND, "'check' needs the value that you read");
    enum verdict verdict = step.done ? ANSWER_RIGHT : ANSWER_OTHER_UNIT;
    const int ways = equivalent_values(&step, found);
    for (int i = 0; i < ways && verdict != ANSWER_RIGHT; i++) {
        const enum verdict one = answer_verdict(value->item, &found[i]);
        verdict = one > verdict ? one : verdict;
    }
    if (verdict == ANSWER_VAGUE) {
        error_set(error, ERROR_COMMAND,
                  "its uncertainty is too large for a check: above %g %% of the value, and above "
                  "%d times that of the measurement",
                  100 * LESSON_VAGUE, LESSON_VAGUE_RATIO);
        return error_hint(error, "give the uncertainty that the measurement printed");
    }
    if (verdict != ANSWER_RIGHT) {
        say_wrong(session, value->item, verdict, found, ways, reply);
        return true;
    }
    reply_line(reply, "right");
    return go_to_step(session, session_lesson(session)->step + 1, reply, error);
}

/* Prints the hint of the step, or its command if it has none. */
HANDLER(hint)
{
    UNUSED(args);
    struct lesson_step step;
    if (!require_lesson(session, error) ||
        !lesson_step(session_lesson(session), session_lesson(session)->step, &step))
        return false;
    struct buffer hint = {0};
    lesson_expand(session, step.hint.len ? step.hint : step.command, !step.hint.len, &hint);
    reply_line(reply, "%s%s", step.hint.len ? "" : "type: ", buffer_view(&hint));
    buffer_free(&hint);
    return true;
}

/* Goes to the next step without an answer. */
HANDLER(skip)
{
    UNUSED(args);
    return require_lesson(session, error) &&
           go_to_step(session, session_lesson(session)->step + 1, reply, error);
}

/* Repeats the step; measurements made before no longer count as its answer. */
HANDLER(again)
{
    UNUSED(args);
    if (!require_lesson(session, error))
        return false;
    session_lesson(session)->counted = session->history.count;
    return go_to_step(session, session_lesson(session)->step, reply, error);
}
#endif

COMMAND(lab, .group = "SESSION", .flags = COMMAND_UNRECORDED | COMMAND_NESTS,
        ARGUMENTS(PLACE("NAME", TYPE_FILE), PLACE("NUMBER", TYPE_INTEGER),
                  KEY("seed", TYPE_INTEGER), WORD(">", TYPE_FILE), OPTION("force", TYPE_NONE)))

COMMAND(check, .group = "SESSION", .flags = COMMAND_UNRECORDED,
        ARGUMENTS(PLACE("VALUE", TYPE_EXPR)))

COMMAND(hint, .group = "SESSION", .flags = COMMAND_UNRECORDED)

COMMAND(skip, .group = "SESSION", .flags = COMMAND_UNRECORDED)

COMMAND(again, .group = "SESSION", .flags = COMMAND_UNRECORDED)
