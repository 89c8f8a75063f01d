/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads lessons and their steps, generates their recordings, and finds whether a step was done. */
#include "modules/report/lesson.h"
#include <hooke/base/file.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/statement.h>
#include <hooke/command/handler.h>
#include <hooke/session/read.h>

#include <stdio.h>
#include <stdlib.h>

#include <hooke/base/numeric.h>
#include <hooke/session/log.h>

extern const struct module report_module;

/* The texts of examples/lessons are part of the program, so that it finds them wherever it is. */
#define LESSON(name)                                                                               \
    __asm__(".pushsection .rodata\nlesson_" #name ":\n"                                            \
            ".incbin \"examples/lessons/" #name ".hk\"\n.byte 0\n.popsection\n");                  \
    extern const char lesson_##name[];
#include "lists/lessons.def"
#undef LESSON

static const struct {
    const char *name, *text;
} lessons[] = {
#define LESSON(name) {#name, lesson_##name},
#include "lists/lessons.def"
#undef LESSON
};
#define LESSON(name) " " #name ","
static const char lesson_names[] =
#include "lists/lessons.def"
    ;

#define LESSON_MAX (1u << 16) /* [byte] largest file of a lesson */
/* True parameters of generated recordings: [g], [g], [N/m], [cm], [1/s], [cm]. */
enum { BARE_MASS, DISK_MASS, SPRING, AMPLITUDE, DRAG, OFFSET, TRUTHS };

/* Computes the true parameters of the recordings of a seed, uniformly in their ranges. */
static void true_parameters(long seed, double value[TRUTHS])
{
    static const double lower[TRUTHS] = {180, 0, 13, 4.2, 0.02, 20},
                        upper[TRUTHS] = {220, 0, 17, 5.6, 0.03, 24};
    uint64_t state = (uint64_t)seed;
    for (int i = 0; i < TRUTHS; i++)
        value[i] = lower[i] + (upper[i] - lower[i]) * random_fraction(&state);
    value[BARE_MASS] = floor(10 * value[BARE_MASS]) / 10;
    value[DISK_MASS] = value[BARE_MASS] + 16.6;
}

/* Appends a generated recording as a sensor would write it: 10 ms apart, with Gaussian noise of
 * 0.02 cm; 10 s of the bare mass, or 120 s of the mass with the disk. `seed` chooses the true
 * parameters and the noise. */
static void put_generated_recording(long seed, bool disk, struct buffer *output)
{
    double v[TRUTHS];
    true_parameters(seed, v);
    const double mass = v[disk ? DISK_MASS : BARE_MASS] / 1000;
    const double gamma = disk ? v[DRAG] : 0.008;
    const double omega = sqrt(v[SPRING] / mass - gamma * gamma / 4);
    uint64_t state = (uint64_t)seed + (disk ? 1000003 : 1000033);
    buffer_put(output, TEXT("Time (s)\tDistance (cm)\n"));
    for (int i = 0; i <= (disk ? 12000 : 1000); i++) {
        const double t = 0.01 * i, a = random_fraction(&state), b = random_fraction(&state);
        const double noise = 0.02 * sqrt(-2 * log(1 - a)) * cos(2 * PI * b); /* [cm] */
        buffer_format(output, "%.2f\t%.3f\n", t,
                      v[OFFSET] + v[AMPLITUDE] * exp(-gamma * t / 2) * cos(omega * t) + noise);
    }
}

/* The mass is rounded to 0.1 g, as the student reads it from scales. */
double lesson_mass(long seed, bool disk)
{
    double v[TRUTHS];
    true_parameters(seed, v);
    return v[disk ? DISK_MASS : BARE_MASS];
}

/* The name is compared, too, since a student gives a mass for a copy with another name. */
bool lesson_generated(const struct recording *recording, long *seed, bool *is_disk)
{
    const struct text file = text_last_component(text_of(recording->path));
    struct buffer generated = {0};
    *is_disk = text_starts(file, TEXT("disk-"));
    *seed = file.len > 5 ? strtol(file.data + 5, NULL, 10)
                         : 0; /* the digits after "bare-" or "disk-" */
    buffer_format(&generated, "%s-%ld.txt", *is_disk ? "disk" : "bare", *seed);
    bool is_same = text_equal(file, buffer_text(&generated));
    buffer_clear(&generated);
    if (is_same) {
        put_generated_recording(*seed, *is_disk, &generated);
        is_same = !generated.failed && recording->sum == bytes_sum(buffer_text(&generated));
    }
    buffer_free(&generated);
    return is_same;
}

/* Appends the text with $seed and file names filled in, which are the same in the whole lesson. */
static void put_expanded(struct text text, long seed, struct buffer *output)
{
    while (text.len > 0) {
        size_t len = 1;
        if (text_starts(text, TEXT("$seed"))) {
            buffer_format(output, "%ld", seed);
            len = 5;
        } else if (text_starts(text, TEXT("$bare_file")) || text_starts(text, TEXT("$disk_file"))) {
            buffer_format(output, "%.4s-%ld.txt", text.data + 1, seed);
            len = 10;
        } else {
            buffer_char(output, text.data[0]);
        }
        text = text_after(text, len);
    }
}

/* Reads step `number`, counted from 0, of the lesson into *step. Its lines begin with #: (text), #>
 * (command), #! (hint), #? (condition); a recording, #@, is named before the step to which it
 * belongs. Returns false if there is no such step. */
bool lesson_step(const struct lesson *lesson, int number, struct lesson_step *step)
{
    struct text rest = buffer_text(&lesson->text), line;
    int index = -1;
    bool bare = false, disk = false;
    *step = (struct lesson_step){.done = false};
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        const struct text body = line.len > 2 ? text_trim(text_after(line, 2)) : TEXT("");
        if (text_starts(line, TEXT("#@"))) {
            bare |= text_is(body, "bare");
            disk |= text_is(body, "disk");
        } else if (text_starts(line, TEXT("#:"))) {
            index++;
            if (index == number)
                *step = (struct lesson_step){.says = body, .bare = bare, .disk = disk};
            bare = disk = false;
        }
        if (index != number)
            continue;
        if (text_starts(line, TEXT("#>")))
            step->command = body;
        else if (text_starts(line, TEXT("#!")))
            step->hint = body;
        else if (text_starts(line, TEXT("#?"))) {
            struct text kind = peek_word(body, "");
            step->done = text_is(kind, "done");
            step->measured = text_is(kind, "measured");
            step->wanted = text_trim(text_after(body, kind.len));
        }
    }
    return index >= number;
}

/* Returns the larger of two sizes. */
static size_t size_max(size_t a, size_t b)
{
    return a > b ? a : b;
}

struct lesson *session_lesson(const struct session *session)
{
    struct lesson *lesson = session_part_if_made(session, &report_module);
    return lesson && lesson->waits ? lesson : NULL;
}

/* Returns true if `command` (its first words) was executed since the present step of the lesson
 * began and not undone. */
bool lesson_done(const struct session *session, struct text command)
{
    struct buffer script = {0};
    bool done = false;
    history_put(session, session_lesson(session)->begun, HISTORY_IN_FORCE, &script);
    struct text rest = buffer_text(&script), line;
    while (rest.len > 0 && text_split(&rest, '\n', &line))
        done |= text_starts(line, command) &&
                (line.len == command.len || line.data[command.len] == ' ');
    buffer_free(&script);
    return done;
}

/* Returns the statement of the log, counted from 1, that moved the session back or forth last, or
 * 0. Measurements made before it may be of parameters that were taken back. */
static size_t last_undo(const struct session *session)
{
    static const char *const words[] = {"undo", "redo", "restore"};
    for (size_t i = session->history.count; i-- > session->history.first;) {
        const struct entry *entry = history_entry(session, i);
        const struct text word = peek_word(history_text(session, entry), "");
        for (size_t k = 0; k < COUNT_OF(words); k++)
            if (!(entry->flags & ENTRY_LINE) && (entry->flags & ENTRY_DONE) &&
                text_is(word, words[k]))
                return i + 1;
    }
    return 0;
}

/* Returns the position in the log [statement] after which measurement m must have been made to
 * count for the step: the latest of the end of an earlier step that wanted the same quantity, the
 * loading of the recording, and, for results that depend on parameters, the last change of a
 * parameter, also by undo, redo or restore. */
static size_t measured_since(const struct session *session, const struct lesson_step *step,
                             const struct measurement *m)
{
    const struct lesson *lesson = session_lesson(session);
    size_t last_change = lesson->counted;
    struct lesson_step earlier;
    for (int i = lesson->step - 1; i >= 0 && lesson_step(lesson, i, &earlier); i--)
        if (text_equal(earlier.wanted, step->wanted) && lesson->passed[i] > last_change)
            last_change = lesson->passed[i];
    if (session->recordings > 0 && text_starts(text_of(m->source), TEXT("data ")))
        last_change =
            size_max(last_change, session->recording[session->current_recording]->statement);
    const bool by_scene = !text_starts(text_of(m->source), TEXT("data ")) ||
                          text_is(step->wanted, "k") || text_is(step->wanted, "reynolds");
    for (size_t i = 0; by_scene && i < scene_params(&session->setup.scene)->count; i++)
        last_change = size_max(last_change, session->setup.origin[i]);
    return by_scene ? size_max(last_change, last_undo(session)) : last_change;
}

/* Finds the value that the step asks for: the latest measurement that is recent enough, or a value
 * of the scene by its name. Returns false if it has not been measured. */
bool lesson_found(const struct session *session, const struct lesson_step *step,
                  struct named_value *value)
{
    if (!step->measured)
        return names_value(session, step->wanted, value);
    if (lesson_lacks_mass(session, step))
        return false;
    for (int i = session->measurements - 1; i >= 0; i--) {
        const struct measurement *m = &session->measurement[i];
        if (!text_is(step->wanted, m->quantity) || m->statement <= measured_since(session, step, m))
            continue;
        *value = (struct named_value){
            .value = m->value.value, .uncertainty = m->value.uncertainty, .quantity = m->unit};
        return true;
    }
    return false;
}

/* Writes the generated recording that the current step needs, if it needs one, to the current
 * folder. A file with the same content is not written again. Returns false with *error. */
bool lesson_files(struct session *session, struct reply *reply, struct error *error)
{
    struct lesson_step step;
    const struct lesson *lesson = session_lesson(session);
    if (!lesson_step(lesson, lesson->step, &step) || (!step.bare && !step.disk))
        return true;
    struct buffer wanted = {0}, there = {0};
    struct error missing;
    char name[64];
    snprintf(name, sizeof name, "%s-%ld.txt", step.disk ? "disk" : "bare", lesson->seed);
    put_generated_recording(lesson->seed, step.disk, &wanted);
    bool ok = !wanted.failed || error_memory(error);
    if (ok && (!file_read(name, 1u << 24, &there, &missing) ||
               !text_equal(buffer_text(&there), buffer_text(&wanted)))) {
        ok = file_write(name, buffer_text(&wanted), session_policy(session, false), error);
        if (ok)
            reply_line(reply, "%s written: a generated recording", name);
        else if (there.len > 0) /* the file is not the generated recording */
            error_hint(error,
                       "if %s is your own recording, load it; for another generated recording "
                       "type: lab off; lab seed=%ld",
                       name, lesson->seed + 1);
    }
    buffer_free(&wanted);
    buffer_free(&there);
    return ok;
}

void lesson_free(void *part)
{
    struct lesson *lesson = part;
    buffer_free(&lesson->text);
    *lesson = (struct lesson){.waits = false};
}

/* Checks all lines of a lesson. Returns false with *error that names the first wrong line. */
static bool check_lines(struct text rest, struct error *error)
{
    struct text line;
    int steps = 0;
    for (int number = 1; rest.len > 0 && text_split(&rest, '\n', &line); number++) {
        const struct text body =
            line.len > 2 ? text_trim((struct text){line.data + 2, line.len - 2}) : TEXT("");
        const struct text kind = peek_word(body, "");
        const int len = (int)(line.len < 60 ? line.len : 60);
        if (text_starts(line, TEXT("#:")) && ++steps > LESSON_STEPS)
            return error_set(error, ERROR_COMMAND, "a lesson has at most %d steps", LESSON_STEPS);
        if (text_starts(line, TEXT("#@")) && !text_is(body, "bare") && !text_is(body, "disk")) {
            error_set(error, ERROR_COMMAND, "line %d of the lesson: '%.*s' is not a recording",
                      number, len, line.data);
            return error_hint(error, "the recordings are bare, disk");
        }
        if (text_starts(line, TEXT("#?")) &&
            ((!text_is(kind, "done") && !text_is(kind, "measured") && !text_is(kind, "value")) ||
             kind.len == body.len)) {
            error_set(error, ERROR_COMMAND,
                      "line %d of the lesson: '%.*s' is not a known condition", number, len,
                      line.data);
            return error_hint(error, "#? done COMMAND, #? measured NAME or #? value NAME");
        }
    }
    return true;
}

/* Opens a lesson, a built-in one by its name or else the file `name`, and makes it the session's.
 * `seed` chooses the numbers in it. Text of files is made safe to print. Returns false with *error,
 * and the lesson that was open remains, if it cannot be read, has an invalid line or no steps. */
bool lesson_open(struct session *session, struct text name, long seed, const struct arguments *args,
                 struct error *error)
{
    struct buffer text = {0};
    struct lesson_step step;
    bool found = false;
    for (size_t i = 0; i < COUNT_OF(lessons) && !found; i++) {
        found = text_is(name, lessons[i].name);
        if (found)
            put_expanded(text_of(lessons[i].text), seed, &text);
    }
    if (!found) {
        struct buffer raw = {0}, safe = {0};
        const char *path = script_path(args->where, name, args->arena);
        if (!path || !file_read(path, LESSON_MAX, &raw, error)) {
            error_hint(error, "the lessons are%s or a FILE.hk", lesson_names);
            return false;
        }
        struct text rest = buffer_text(&raw), line;
        while (rest.len > 0 && text_split(&rest, '\n', &line)) {
            safe_text(&safe, text_trim(line), true);
            buffer_char(&safe, '\n');
        }
        put_expanded(buffer_text(&safe), seed, &text);
        text.failed |= safe.failed;
        buffer_free(&safe);
        buffer_free(&raw);
    }
    if (!text.failed && !check_lines(buffer_text(&text), error)) {
        buffer_free(&text);
        return false;
    }
    struct lesson *lesson = text.failed ? NULL : session_part(session, &report_module);
    struct lesson opened = {
        .waits = true, .text = text, .seed = seed, .counted = session->history.count};
    while (lesson && lesson_step(&opened, opened.steps, &step))
        opened.steps++;
    if (lesson && opened.steps > 0) {
        lesson_free(lesson);
        *lesson = opened;
        return true;
    }
    buffer_free(&text);
    if (!lesson)
        return error_memory(error);
    return error_set(error, ERROR_COMMAND, "this file has no steps: a line '#: TEXT' begins one");
}

/* ---- in a session's file ---- */

static const struct field fields[] = {
    FIELD_OF(struct lesson, step),   FIELD_OF(struct lesson, steps),
    FIELD_OF(struct lesson, begun),  FIELD_OF(struct lesson, counted),
    FIELD_OF(struct lesson, passed), FIELD_OF(struct lesson, seed),
};

/* Writes nothing if no lesson is open. */
void lesson_put(const void *part, struct buffer *output)
{
    const struct lesson *lesson = part;
    if (!lesson->waits)
        return;
    const size_t begun = field_begin(output, "report");
    fields_put(output, fields, COUNT_OF(fields), lesson);
    field_text(output, "text", buffer_text(&lesson->text));
    field_end(output, begun);
}

/* Restores the lesson from a session file. Checks its numbers, since the file may have been edited;
 * a lesson with wrong ones is left out with a note. */
void lesson_read(struct reader *reader)
{
    struct text stored, text;
    struct lesson lesson = {.waits = true};
    if (!field_find(reader->state, "report", &stored))
        return;
    struct lesson *stored_lesson = session_part(reader->session, &report_module);
    const bool ok = stored_lesson && field_find(stored, "text", &text) &&
                    fields_get(stored, fields, COUNT_OF(fields), &lesson) && lesson.step >= 0 &&
                    lesson.step <= lesson.steps && lesson.steps <= LESSON_STEPS;
    if (ok)
        buffer_put(&lesson.text, text);
    if (!ok || lesson.text.failed) {
        store_tools()->note(reader, "the lesson is not resumed");
        buffer_free(&lesson.text);
        return;
    }
    *stored_lesson = lesson;
}
