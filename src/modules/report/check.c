/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compares a hand-in, the folder that `report` wrote, with the report that its session.hk gives
 * when it is run again. */
#define _GNU_SOURCE /* memmem */
#include "modules/recording/known/handed_in.h"
#include "modules/report/check.h"
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>
#include <hooke/base/safe_text.h>
#include <hooke/command/handler.h>

#include <hooke/base/fields.h>

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define HANDED_MAX (1u << 28) /* [byte] largest file of a hand-in that is read */

/* Longest part of a line that a difference quotes: a page holds figures of many kilobytes. */
enum { QUOTE_MAX_BYTES = 160 };

/* Reports a difference in `file` of the checked folder: `what` differs, with a detail (cut at
 * QUOTE_MAX_BYTES and made safe to print). Adds a line and, except in CSV, an object to the list of
 * differences. */
void check_differs(struct check *check, const char *file, const char *what, struct text detail)
{
    struct reply *reply = check->reply;
    struct buffer safe = {0};
    size_t length = detail.len < QUOTE_MAX_BYTES ? detail.len : QUOTE_MAX_BYTES;
    while (length < detail.len && length > 0 && ((unsigned char)detail.data[length] & 0xC0) == 0x80)
        length--; /* inside a character of UTF-8 */
    safe_text(&safe, (struct text){detail.data, length}, false);
    if (length < detail.len)
        buffer_put(&safe, TEXT(" ..."));
    check->differences++;
    reply_line(reply, "differs: %s: %s%s%s", file, what, safe.len ? ": " : "", buffer_view(&safe));
    if (reply->format != FORMAT_CSV) {
        reply_object(reply, NULL);
        reply_string(reply, "file", file);
        reply_string(reply, "what", what);
        reply_string(reply, "detail", buffer_view(&safe));
        reply_close(reply);
    }
    buffer_free(&safe);
}

/* ---- documents ---- */

/* Returns the recording if its values were read from recording-N.csv of the folder, because neither
 * its file nor a copy of that was found, else NULL. */
static const struct recording *recording_from_folder(const struct session *session, int index)
{
    const struct recording *recording = session->recording[index]->recording;
    return strcmp(recording->format, HANDED_IN) == 0 ? recording : NULL;
}

/* Returns true if the line describes such a recording: number of rows and separator are those of
 * recording-N.csv and differ from those of the file. */
bool check_describes_recording(const struct session *session, struct text line)
{
    for (int i = 0; i < session->recordings; i++) {
        struct buffer description = {0};
        if (recording_from_folder(session, i))
            recording_describe(recording_from_folder(session, i), &description);
        const char *end = strchr(buffer_view(&description), ',');
        const bool found =
            end && description.data &&
            memmem(line.data, line.len, description.data, (size_t)(end - description.data));
        buffer_free(&description);
        if (found)
            return true;
    }
    return false;
}

/* Returns true if a line of the text, without blanks around it, is `wanted`. */
bool check_has_line(struct text text, struct text wanted)
{
    struct text line;
    while (text.len > 0 && text_split(&text, '\n', &line))
        if (text_equal(text_trim(line), wanted))
            return true;
    return false;
}

/* Reports lines of a document that contain digits and are missing in the one that was handed in.
 * Numbers, figures and commands must be unchanged; answers, headings and words may differ. */
static void compare_lines(struct check *check, const char *file, struct text handed,
                          struct text repeated)
{
    struct text line;
    while (repeated.len > 0 && text_split(&repeated, '\n', &line)) {
        line = text_trim(line);
        bool digit = false;
        for (size_t i = 0; i < line.len; i++)
            digit |= line.data[i] >= '0' && line.data[i] <= '9';
        if (digit && line.data[0] != '#' && !text_starts(line, TEXT("<h")) &&
            !check_has_line(handed, line) &&
            !check_describes_recording(check->report.session, line))
            check_differs(check, file, "this line is missing", line);
    }
}

/* ---- files ---- */

static bool ends_in(const char *name, const char *end)
{
    const size_t n = strlen(name), m = strlen(end);
    return n >= m && strcmp(name + n - m, end) == 0;
}

/* Reads the file `name` of the folder into content, unless it is not a regular file, as a pipe
 * could keep its reader waiting. Returns NULL, or the reason why it was not read; *error is set
 * only if reading failed. */
static const char *read_regular(const struct check *check, const char *name, struct buffer *content,
                                struct error *error)
{
    struct buffer path = {0};
    struct stat st;
    const char *why = NULL;
    buffer_format(&path, "%s/%s", check->folder, name);
    if (stat(buffer_view(&path), &st) != 0)
        why = "it is missing";
    else if (!S_ISREG(st.st_mode))
        why = S_ISDIR(st.st_mode) ? "it is a folder" : "it is not a file";
    else if (!file_read(buffer_view(&path), HANDED_MAX, content, error))
        why = "it cannot be read";
    buffer_free(&path);
    return why;
}

/* Reads a file of the folder, and reports one that is not read. */
static bool read_handed(struct check *check, const char *name, struct buffer *content)
{
    struct error error = {0};
    const char *why = read_regular(check, name, content, &error);
    if (why)
        check_differs(check, name, why, text_of(error.text));
    check->missing_files += why != NULL;
    return !why;
}

/* Returns true if the folder has an entry of that name. Reports of older versions have no copies of
 * recordings. */
static bool is_handed(const struct check *check, const char *name)
{
    struct buffer path = {0};
    struct stat st;
    buffer_format(&path, "%s/%s", check->folder, name);
    const bool found = stat(buffer_view(&path), &st) == 0;
    buffer_free(&path);
    return found;
}

/* Compares the file `name` that the repeated session gives with that of the folder, and counts
 * differences by kind. `context` is the struct check. It is report->put of the repeated report;
 * always returns true. */
static bool compare_file(void *context, const char *name, struct text repeated, struct error *error)
{
    struct check *check = context;
    struct buffer handed = {0};
    const bool copy = text_starts(text_of(name), TEXT("recording-")) && strchr(name + 10, '-');
    const bool prose = ends_in(name, ".md") || ends_in(name, ".html") || ends_in(name, ".tex");
    const bool figure = text_starts(text_of(name), TEXT("figure-"));
    (void)error;
    if (strcmp(name, "report.md") == 0)
        buffer_put(&check->repeated, repeated);
    if (strcmp(name, "session.hk") == 0 || (copy && !is_handed(check, name)) ||
        !read_handed(check, name, &handed)) {
        buffer_free(&handed);
        return true;
    }
    const int differences = check->differences;
    check->files++;
    check->figures += figure && !ends_in(name, ".txt");
    if (copy && !text_equal(buffer_text(&handed), repeated))
        check_differs(check, name, "the session loads a different file", TEXT(""));
    else if (copy)
        ; /* the same bytes */
    else if (strcmp(name, "values.csv") == 0)
        check_values(check, buffer_text(&handed), repeated);
    else if (prose)
        compare_lines(check, name, buffer_text(&handed), repeated);
    else if (!figure)
        check_data(check, name, buffer_text(&handed), repeated);
    else if (!text_equal(buffer_text(&handed), repeated))
        check_differs(check, name, "the session gives a different figure", TEXT(""));
    const int added = check->differences - differences;
    check->wrong_values += strcmp(name, "values.csv") == 0 ? added : 0;
    check->wrong_figures += figure && !ends_in(name, ".txt") ? added : 0;
    check->changed_lines += prose ? added : 0;
    buffer_free(&handed);
    return true;
}

/* ---- the session, run again ---- */

/* Keeps the first error message of the repeated session in check->failure. */
static bool store_first_error(void *context, struct text text)
{
    struct check *check = context;
    struct text line;
    const char *found = text.len ? memmem(text.data, text.len, "error: ", 7) : NULL;
    if (found && check->failure.len == 0 && text_split(&text, '\n', &line))
        buffer_put(&check->failure, line);
    return true;
}

/* Runs session.hk of the folder in `session` without showing or writing anything. Returns NULL, or
 * the reason why the script was not read; check->failure has the first error. */
static const char *run_session_file(struct check *check, struct session *session)
{
    struct buffer path = {0}, script = {0};
    struct error error = {0};
    struct reply silent;
    const int format = session->setup.settings.format;
    buffer_format(&path, "%s/session.hk", check->folder);
    const char *why = read_regular(check, "session.hk", &script, &error);
    if (why) {
        buffer_put(&check->failure, text_of(error.text));
    } else {
        const bool fails = memmem(script.data, script.len, "hooke --keep-going", 18) != NULL;
        reply_init(&silent, (struct sink){sink_nothing, store_first_error, check});
        session->options.checking = check->folder;
        session->options.keep_going = true;
        script_file(session, buffer_view(&path), NULL, &silent);
        reply_free(&silent);
        if (fails) /* its first lines announce that it ends in an error */
            buffer_clear(&check->failure);
    }
    session->setup.settings.format = format;
    buffer_free(&path);
    buffer_free(&script);
    return why;
}

/* Tells the user if a recording of the session was read from the folder, because the file that it
 * was loaded from is missing or has another checksum. Returns true if so. */
static bool report_taken(struct check *check, int index)
{
    const struct session *session = check->report.session;
    const struct recording *recording = session->recording[index]->recording;
    const struct text file = text_last_component(text_of(recording->path));
    struct buffer content = {0}, copy = {0};
    struct error ignored;
    const bool found = file_read(recording->path, HANDED_MAX, &content, &ignored),
               same = found &&
                      (recording->sum == 0 || bytes_sum(buffer_text(&content)) == recording->sum);
    buffer_free(&content);
    if (same && !recording_from_folder(session, index))
        return false;
    buffer_format(&copy,
                  recording_from_folder(session, index) ? "recording-%d.csv" : "recording-%d-%.*s",
                  index + 1, (int)file.len, file.data);
    reply_line(check->reply, "the file of %s %s; %s was used instead", recording->name,
               found ? "has other content here" : "was not found", buffer_view(&copy));
    buffer_free(&copy);
    return true;
}

/* Reads name, answers and checksum from the documents; a missing one counts as empty here, since
 * compare_file() reports it. */
static void read_answers(struct check *check)
{
    static const char *const names[] = {"report.md", "report.html"};
    struct buffer content[2] = {{0}};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        struct error ignored = {0};
        if (read_regular(check, names[i], &content[i], &ignored))
            buffer_clear(&content[i]);
    }
    check_answers(check, buffer_text(&content[0]), buffer_text(&content[1]));
    buffer_free(&content[0]);
    buffer_free(&content[1]);
}

/* Adds the fields of the record `check` after its list of differences. `taken` is the number of
 * recordings that were read from the folder. */
static void put_record(struct check *check, struct text folder, int taken)
{
    struct reply *reply = check->reply;
    struct buffer safe = {0};
    safe_text(&safe, buffer_text(&check->name), false);
    reply_string(reply, "folder", folder.data ? folder.data : "");
    reply_bool(reply, "agrees", check->differences == 0);
    reply_int(reply, "values", check->values);
    reply_int(reply, "figures", check->figures);
    reply_int(reply, "files", check->files);
    reply_int(reply, "moved", taken);
    reply_string(reply, "name", buffer_view(&safe));
    reply_bool(reply, "complete", check->missing_files == 0 && check->empty_answers == 0);
    reply_int(reply, "values_right",
              check->values > check->wrong_values ? check->values - check->wrong_values : 0);
    reply_int(reply, "figures_agree",
              check->figures > check->wrong_figures ? check->figures - check->wrong_figures : 0);
    reply_int(reply, "changed", check->changed_lines);
    reply_int(reply, "answers", check->answers);
    reply_string(reply, "empty", buffer_view(&check->empty));
    reply_string(reply, "copy", check->copy ? check->copy : "");
    reply_end(reply);
    buffer_free(&safe);
}

/* Prints the summary of a checked folder and completes its record. */
static void check_conclude(struct check *check)
{
    struct reply *reply = check->reply;
    struct buffer safe = {0}, verdict = {0};
    const int n = check->differences;
    const struct session *session = check->report.session;
    int taken = 0;
    for (int i = 0; i < session->recordings; i++)
        taken += report_taken(check, i);
    safe_text(&safe, text_of(check->folder), false);
    if (n > 0)
        buffer_format(&verdict, "%d difference%s from the results of session.hk", n,
                      n == 1 ? "" : "s");
    else
        buffer_put(&verdict, TEXT("all agree with session.hk"));
    if (check->empty_answers > 0)
        reply_line(reply, "%s: %d answer%s empty: %s", buffer_view(&safe), check->empty_answers,
                   check->empty_answers == 1 ? " is" : "s are", buffer_view(&check->empty));
    if (check->copy)
        reply_line(reply, "%s: apart from name and answers its report is the same as that of %s",
                   buffer_view(&safe), check->copy);
    reply_line(reply, "%s: %d values, %d figures, %d files: %s", buffer_view(&safe), check->values,
               check->figures, check->files, buffer_view(&verdict));
    if (reply->format != FORMAT_CSV)
        reply_close(reply);
    put_record(check, buffer_text(&safe), taken);
    buffer_free(&safe);
    buffer_free(&verdict);
}

/* Makes the report of the repeated session, whose files compare_file() compares with those of the
 * folder. `view` is scratch memory. */
static void compare_folder(struct check *check, struct session *session, struct session *view)
{
    struct error error = {0};
    if (check->failure.len > 0)
        check_differs(check, "session.hk", "the session ends in an error",
                      buffer_text(&check->failure));
    *view = *session;
    check->report = (struct report){.session = session,
                                    .view = view,
                                    .arena = &check->arena,
                                    .put = compare_file,
                                    .context = check};
    if (session->runs.count == 0 && session->recordings == 0)
        check_differs(check, "session.hk", "the session has neither a run nor a recording",
                      TEXT(""));
    else if (!report_write(&check->report, &error))
        check_differs(check, "session.hk", "the session writes no report", text_of(error.text));
    document_free(&check->report.document);
}

/* Frees the check and all that it owns. */
static void check_free(struct check *check)
{
    buffer_free(&check->failure);
    buffer_free(&check->empty);
    buffer_free(&check->repeated);
    buffer_free(&check->name);
    arena_reset(&check->arena);
    free(check);
}

/* Returns true if both reports have the same checksum and are not the same folder. */
static bool is_copy(const struct checked *one, const struct checked *other)
{
    struct stat a, b;
    const bool same_folder = stat(one->folder, &a) == 0 && stat(other->folder, &b) == 0 &&
                             a.st_dev == b.st_dev && a.st_ino == b.st_ino;
    return one->sum == other->sum && !same_folder;
}

/* Checks the hand-in in folder checked[index] by running its session again; the folders before it
 * are searched for the same report. Replies with the differences. Returns 0 if all agrees,
 * ERROR_COMMAND if something differs, ERROR_USAGE if there is no session to run or no memory. */
static int check_folder(struct session *session, struct checked *checked, int index,
                        struct reply *reply)
{
    struct check *check = calloc(1, sizeof *check);
    struct session *view = malloc(sizeof *view);
    int status = ERROR_USAGE;
    if (check && view) {
        check->folder = checked[index].folder;
        check->reply = reply;
        const char *unread = run_session_file(check, session);
        reply_command_begin(reply, (enum output_format)session->setup.settings.format);
        reply_begin(reply, "check");
        if (reply->format != FORMAT_CSV)
            reply_array(reply, "differences");
        check->report.session = session;
        if (unread)
            check_differs(check, "session.hk", unread, buffer_text(&check->failure));
        else
            compare_folder(check, session, view);
        check->missing_files += unread != NULL;
        read_answers(check);
        checked[index].sum = check->sum;
        for (int i = 0; i < index && check->sum != 0 && !check->copy; i++)
            check->copy = is_copy(&checked[index], &checked[i]) ? checked[i].folder : NULL;
        check_conclude(check);
        reply_command_end(reply, "check");
        if (!unread)
            status = check->differences ? ERROR_COMMAND : 0;
    }
    free(view);
    if (check)
        check_free(check);
    return status;
}

/* Copies the names of the folders, without slashes at their ends, into the arena. */
static struct checked *copy_folders(struct arena *arena, const char *const *folder, int folders)
{
    struct checked *checked = arena_alloc(arena, (size_t)folders * sizeof *checked);
    for (int i = 0; checked && i < folders; i++) {
        struct text name = text_of(folder[i]);
        while (name.len > 1 && name.data[name.len - 1] == '/')
            name.len--;
        checked[i] = (struct checked){.folder = arena_text(arena, name)};
        if (!checked[i].folder)
            return NULL;
    }
    return checked;
}

/* Checks `folders` reports that were handed in, each in a new session, so that none sees the runs
 * of another, and replies with the differences. Returns the exit status: 0 if all agree; for one
 * folder ERROR_COMMAND or ERROR_USAGE; for several the number of those that differ, at most
 * CHECK_STATUS_MAX; ERROR_COMMAND if stopped. */
int hand_ins_check(struct session *session, const char *const *folder, int folders,
                   struct reply *reply)
{
    struct arena arena = {0};
    int failing = 0, status = 0;
    struct checked *checked = copy_folders(&arena, folder, folders);
    int count = 0;
    for (; checked && count < folders && !cancelled(session->front.cancel); count++) {
        struct session *fresh = session_create(&session->front);
        if (!fresh)
            break;
        fresh->options.safe = session->options.safe;
        fresh->options.verbose = session->options.verbose;
        fresh->setup.settings.format = session->setup.settings.format;
        status = check_folder(fresh, checked, count, reply);
        failing += status != 0;
        session_destroy(fresh);
    }
    arena_reset(&arena);
    if (folders > 1 && count == folders)
        reply_line(reply, "%d hand-ins: %d agree, %d differ", folders, folders - failing, failing);
    if (count < folders)
        return ERROR_COMMAND;
    if (folders > 1)
        status = failing < CHECK_STATUS_MAX ? failing : CHECK_STATUS_MAX;
    return status;
}
