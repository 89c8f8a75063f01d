/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The history: every line and statement as typed, and what it did. `history`, the file of `record`,
 * labels of undo and the script of the report are read from it. */
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>
#include <hooke/base/safe_text.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- writing ---- */

/* Adds an entry at the end; the capacity doubles if it is used up. Returns NULL if out of
 * memory. */
static struct entry *new_entry(struct history *log)
{
    if (log->count - log->first == log->capacity) {
        const size_t capacity = log->capacity ? 2 * log->capacity : 64;
        struct entry *larger = realloc(log->entry, capacity * sizeof *larger);
        if (!larger)
            return NULL;
        log->entry = larger;
        log->capacity = capacity;
    }
    struct entry *entry = &log->entry[log->count++ - log->first];
    *entry = (struct entry){.flags = 0};
    return entry;
}

/* Appends text and sets *offset to its position, counted from the beginning of the session. Returns
 * false if out of memory; the existing text stays. */
static bool put_text(struct history *log, struct text text, size_t *offset)
{
    *offset = log->text_first + log->text.len;
    buffer_put(&log->text, text);
    const bool ok = !log->text.failed;
    log->text.failed = false; /* the existing text stays readable */
    return ok;
}

/* Adds the entry of a line that was read. Returns false with the error set if out of memory. */
bool history_line(struct session *session, struct text line, bool sourced, size_t *index,
                  struct error *error)
{
    struct history *log = &session->history;
    *index = log->count;
    struct entry *entry = new_entry(log);
    if (!entry)
        return error_memory(error);
    if (!put_text(log, line, &entry->text)) {
        log->count--;
        return error_memory(error);
    }
    entry->len = line.len;
    entry->flags = ENTRY_LINE | (sourced ? ENTRY_SOURCED : 0);
    log->lines += !sourced && text_trim(line).len > 0;
    return true;
}

/* Adds the entry of a statement, whose text is that of its line. Returns false with the error
 * set. */
bool history_begin(struct session *session, size_t line, struct text line_text,
                   struct text statement, size_t *index, struct error *error)
{
    struct history *log = &session->history;
    *index = log->count;
    struct entry *entry = new_entry(log);
    if (!entry)
        return error_memory(error);
    const struct entry *line_entry = history_entry(session, line);
    entry->text = line_entry->text + (size_t)(statement.data - line_text.data);
    entry->len = statement.len;
    entry->flags = line_entry->flags & ENTRY_SOURCED;
    return true;
}

/* Ends the entry of a statement: adds flags, and its full text only if it differs from what was
 * typed. */
void history_end(struct session *session, size_t index, struct text full, size_t output,
                 unsigned flags)
{
    struct history *log = &session->history;
    struct entry *entry = history_entry(session, index);
    const bool is_nested = (flags & ENTRY_WITHIN) != 0;
    entry->flags |= flags;
    entry->output = output;
    if (!is_nested && log->happened.len > 0) {
        full = (struct text){log->happened.data, log->happened.len - 1};
        entry->flags |= ENTRY_HAPPENED;
        entry->output = 0;
    }
    if (!text_equal(full, history_text(session, entry))) {
        entry->full_len = full.len;
        if (!put_text(log, full, &entry->full))
            entry->flags |= ENTRY_LOST;
    }
    log->done += (flags & ENTRY_DONE) != 0;
    if (!is_nested) {
        entry->flags |= log->happened.failed ? ENTRY_LOST : 0;
        buffer_free(&log->happened);
    }
}

bool history_is_typed(const struct session *session, const struct entry *entry)
{
    return (entry->flags & ENTRY_LINE) && !(entry->flags & ENTRY_SOURCED) &&
           text_trim(history_text(session, entry)).len > 0;
}

static size_t size_min(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Drops entries, in units of typed lines, from the beginning of the history when one of its limits
 * is exceeded twofold, until both are kept, and the text that no remaining entry uses. log->first
 * and text_first count what was dropped. */
void history_trim(struct session *session)
{
    struct history *log = &session->history;
    const size_t entries = log->count - log->first, bytes = log->text.len;
    if (entries <= 2 * LIMIT_HISTORY && bytes <= 2 * LIMIT_HISTORY_TEXT)
        return;
    const size_t enough = bytes > LIMIT_HISTORY_TEXT ? bytes - LIMIT_HISTORY_TEXT : 0;
    size_t drop = 0, kept_offset = SIZE_MAX;
    while (drop < entries &&
           (entries - drop > LIMIT_HISTORY || log->entry[drop].text - log->text_first < enough ||
            !(log->entry[drop].flags & ENTRY_LINE))) {
        log->lines_gone += history_is_typed(session, &log->entry[drop]);
        drop++;
    }
    for (size_t i = drop; i < entries; i++) {
        const struct entry *entry = &log->entry[i];
        kept_offset =
            size_min(kept_offset, size_min(entry->text, entry->full_len ? entry->full : SIZE_MAX));
    }
    kept_offset = size_min(kept_offset == SIZE_MAX ? bytes : kept_offset - log->text_first, bytes);
    memmove(log->entry, log->entry + drop, (entries - drop) * sizeof *log->entry);
    memmove(log->text.data, log->text.data + kept_offset, bytes - kept_offset);
    log->text.len -= kept_offset;
    log->text_first += kept_offset;
    log->first += drop;
}

void history_free(struct session *session)
{
    struct history *log = &session->history;
    struct error ignored;
    record_close(session, &ignored);
    buffer_free(&log->text);
    buffer_free(&log->happened);
    free(log->entry);
}

/* ---- reading ---- */

struct entry *history_entry(const struct session *session, size_t index)
{
    return &session->history.entry[index - session->history.first];
}

/* Returns text at an offset counted from the beginning of the session. */
static struct text text_at(const struct history *log, size_t offset, size_t len)
{
    return (struct text){log->text.data + (offset - log->text_first), len};
}

struct text history_text(const struct session *session, const struct entry *entry)
{
    return text_at(&session->history, entry->text, entry->len);
}

/* Returns the entry as a file has to have it, or as typed if that is the same. */
static struct text full_text(const struct session *session, const struct entry *entry)
{
    return entry->full_len ? text_at(&session->history, entry->full, entry->full_len)
                           : history_text(session, entry);
}

/* Returns true if a reading of the history includes this entry. */
static bool entry_is_read(const struct entry *entry, enum history_reading reading)
{
    if (entry->flags & (ENTRY_LINE | ENTRY_UNRECORDED))
        return false;
    if (reading == HISTORY_IN_FORCE && (entry->flags & ENTRY_UNDONE))
        return false;
    if (reading != HISTORY_SCRIPT)
        return !(entry->flags & ENTRY_SOURCED) && (entry->flags & (ENTRY_DONE | ENTRY_HAPPENED));
    return !(entry->flags & (ENTRY_NESTS | ENTRY_WRITES)) &&
           (entry->flags & (ENTRY_DONE | ENTRY_CHANGED));
}

/* Returns the full text without the part that sends the result to a file. */
static struct text script_text(const struct session *session, const struct entry *entry)
{
    struct text full = full_text(session, entry);
    full.len -= entry->output;
    return text_trim(full);
}

/* Returns the line number of a statement in the script, with its text in *line, or 0 if the script
 * lacks it. Counts the lines of all script entries before it. */
int history_script_line(const struct session *session, size_t statement, struct text *line)
{
    const struct history *log = &session->history;
    int number = 1;
    if (statement <= log->first || statement > log->count ||
        !entry_is_read(history_entry(session, statement - 1), HISTORY_SCRIPT))
        return 0;
    for (size_t i = log->first; i + 1 < statement; i++) {
        const struct entry *entry = history_entry(session, i);
        struct text rest = script_text(session, entry), ignored;
        while (entry_is_read(entry, HISTORY_SCRIPT) && text_split(&rest, '\n', &ignored))
            number++;
    }
    struct text rest = script_text(session, history_entry(session, statement - 1));
    text_split(&rest, '\n', line);
    return number;
}

/* Appends the entries that a reading includes, from number `first` on. */
void history_put(const struct session *session, size_t first, enum history_reading reading,
                 struct buffer *text)
{
    const struct history *log = &session->history;
    for (size_t i = first > log->first ? first : log->first; i < log->count; i++) {
        const struct entry *entry = history_entry(session, i);
        if (!entry_is_read(entry, reading))
            continue;
        buffer_put(text, reading == HISTORY_SCRIPT ? script_text(session, entry)
                                                   : text_trim(full_text(session, entry)));
        buffer_char(text, '\n');
        text->failed |= (entry->flags & ENTRY_LOST) != 0;
    }
}

/* Returns true if a statement of the script failed. */
bool history_fails(const struct session *session)
{
    for (size_t i = session->history.first; i < session->history.count; i++) {
        const struct entry *entry = history_entry(session, i);
        if (entry_is_read(entry, HISTORY_SCRIPT) && !(entry->flags & (ENTRY_DONE | ENTRY_HAPPENED)))
            return true;
    }
    return false;
}

/* Fills label with the text of a statement, shortened to LIMIT_NAME bytes at whole characters. */
void history_label(const struct session *session, size_t index, char label[LIMIT_NAME + 1])
{
    struct buffer text = {0};
    const bool there = index >= session->history.first && index < session->history.count;
    safe_text(&text,
              there ? text_trim(history_text(session, history_entry(session, index)))
                    : TEXT("a statement that was dropped"),
              false);
    size_t len = text.len <= LIMIT_NAME ? text.len : LIMIT_NAME - 3;
    while (len < text.len && len > 0 && ((unsigned char)text.data[len] & 0xc0) == 0x80)
        len--;
    const char *const ellipsis = len < text.len ? "..." : "";
    snprintf(label, LIMIT_NAME + 1, "%.*s%s", (int)len, text.data ? text.data : "", ellipsis);
    buffer_free(&text);
}

/* ---- the file of `record` ---- */

/* Begins to append statements to a file; the record of another file is closed only after the new
 * one is open. Returns false with the error set. */
bool record_open(struct session *session, const char *path, struct error *error)
{
    char *copy = strdup(path);
    const int fd = copy ? append_open(path, session_policy(session, true), 0666, error) : -1;
    if (fd < 0) {
        free(copy);
        return copy ? false : error_memory(error);
    }
    if (!record_close(session, error)) { /* closes the record of another file */
        close(fd);
        free(copy);
        return false;
    }
    session->transcript.fd = fd;
    session->transcript.path = copy;
    session->transcript.synced = 0;
    return true;
}

/* Sets the error that the file of `record` cannot be appended to, for the reason why; statement is
 * the first that it lacks, or "". Returns false. */
static bool fail_to_append(const struct session *session, const struct error *why,
                           const char *statement, struct error *error)
{
    struct buffer path = {0};
    safe_text(&path, text_of(session->transcript.path), false);
    error_set(error, ERROR_IO, "cannot append to %.200s: %s%s%s", buffer_view(&path), why->text,
              *statement ? "; commands are recorded only up to: " : "", statement);
    buffer_free(&path);
    return false;
}

/* Writes what is not on the disk yet, and closes the file. Returns false with the error set if that
 * failed. */
bool record_close(struct session *session, struct error *error)
{
    struct error why = {0};
    bool ok = true;
    if (session->transcript.owed && !append_lines(session->transcript.fd, TEXT(""), true, &why))
        ok = fail_to_append(session, &why, "", error);
    if (session->transcript.fd >= 0)
        close(session->transcript.fd);
    free(session->transcript.path);
    session->transcript.fd = -1;
    session->transcript.path = NULL;
    session->transcript.owed = false;
    return ok;
}

/* Appends statements to the file of `record`, which it locks meanwhile, since several programs may
 * record into it. Returns false with the error set, and ends the recording. */
bool record_append(struct session *session, size_t first, struct error *error)
{
    if (session->transcript.fd < 0)
        return true;
    struct buffer text = {0};
    struct error why = {0};
    history_put(session, first, HISTORY_RECORD, &text);
    bool ok = !text.failed || error_memory(&why);
    if (ok && text.len > 0) {
        const bool locked = file_lock(session->transcript.fd, true);
        const bool sync =
            !session->transcript.synced || clock_seconds(session->transcript.synced) >= 1;
        ok = append_lines(session->transcript.fd, buffer_text(&text), sync, &why);
        if (locked)
            file_unlock(session->transcript.fd);
        session->transcript.owed = !sync;
        session->transcript.synced = sync ? clock_ns() : session->transcript.synced;
    }
    buffer_free(&text);
    if (!ok) {
        char lost[LIMIT_NAME + 1];
        struct error ignored;
        history_label(session, first, lost);
        fail_to_append(session, &why, lost, error);
        record_close(session, &ignored);
    }
    return ok;
}
