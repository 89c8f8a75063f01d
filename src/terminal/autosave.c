/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Sessions saved on their own. A file is named after the process that writes it, so that those of
 * living sessions are left alone. It is replaced whole, and restored whole or not at all, from
 * nothing but commands that recreate a session.
 */
#include "terminal/terminal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define SAVED_BYTES ((size_t)64 << 20)
#define STALE_SECONDS 60 /* a temporary file of this age belongs to nobody */

/* ---- the files there are
 * ---------------------------------------------------------------------------------- */

struct autosaved {
    char name[64];
    time_t time;
    bool living; /* its process is still there */
};

struct saved_list {
    struct autosaved *item; /* the newest first */
    int count;
};

/* session-20261121-114700-1234.hk */
static bool read_name(const char *name, struct autosaved *saved)
{
    long pid;
    int used = 0;
    if (strlen(name) >= sizeof saved->name ||
        sscanf(name, AUTOSAVE_PREFIX "%*8[0-9]-%*6[0-9]-%9ld.hk%n", &pid, &used) != 1 ||
        used == 0 || name[used] != '\0' || pid <= 0) {
        return false;
    }
    memcpy(saved->name, name, strlen(name) + 1); /* fits: checked above */
    saved->living = kill((pid_t)pid, 0) == 0 || errno == EPERM;
    return true;
}

static int by_time(const void *a, const void *b)
{
    const struct autosaved *x = a, *y = b;
    return x->time != y->time ? (x->time < y->time ? 1 : -1) : strcmp(y->name, x->name);
}

/* What a writer leaves behind that was killed between naming its temporary file and putting it in
 * place. */
static bool is_stale_temporary(const char *name, const struct stat *status)
{
    return (strncmp(name, "." AUTOSAVE_PREFIX, sizeof AUTOSAVE_PREFIX) == 0 ||
            strncmp(name, ".history.", 9) == 0) &&
           strstr(name, ".hooke-") && time(NULL) - status->st_mtime > STALE_SECONDS;
}

/* Caller frees item. sweep: stale temporaries are removed on the way. */
static struct saved_list list_saved(const char *folder, bool sweep)
{
    struct saved_list list = {0};
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        struct autosaved saved;
        struct stat status;
        if (fstatat(dirfd(directory), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0 ||
            !S_ISREG(status.st_mode)) {
            continue;
        }
        if (sweep && is_stale_temporary(entry->d_name, &status)) {
            unlinkat(dirfd(directory), entry->d_name, 0);
        }
        struct autosaved *more = read_name(entry->d_name, &saved)
                                     ? realloc(list.item, (size_t)(list.count + 1) * sizeof *more)
                                     : NULL;
        if (more) {
            list.item = more;
            saved.time = status.st_mtime;
            list.item[list.count++] = saved;
        }
    }
    if (directory) {
        closedir(directory);
    }
    if (list.count > 1) {
        qsort(list.item, (size_t)list.count, sizeof *list.item, by_time);
    }
    return list;
}

/* ---- writing
 * ---------------------------------------------------------------------------------------------- */

void autosave_begin(struct autosave *autosave, const struct session *session)
{
    const char *wish = getenv("HOOKE_AUTOSAVE");
    double seconds;
    *autosave = (struct autosave){.session = session,
                                  .saved = session->changes,
                                  .interval = (int64_t)AUTOSAVE_SECONDS * 1000000000};
    if (wish && real_parse(text_of(wish), &seconds) == REAL_OK && seconds >= 0.1 &&
        seconds <= 86400) {
        autosave->interval = (int64_t)(seconds * 1e9);
    }
    char *folder = state_path("", true);
    if (!folder) {
        return;
    }
    struct saved_list list = list_saved(folder, true);
    for (int i = AUTOSAVE_KEPT; i < list.count; i++) {
        struct buffer path = {0};
        buffer_format(&path, "%s%s", folder, list.item[i].name);
        if (!list.item[i].living && !path.failed) {
            unlink(path.data);
        }
        buffer_free(&path);
    }
    free(list.item);
    free(folder);
    const time_t now = time(NULL);
    struct tm local;
    char stamp[32] = "";
    char name[64];
    localtime_r(&now, &local);
    strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
    snprintf(name, sizeof name, AUTOSAVE_PREFIX "%s-%ld.hk", stamp, (long)getpid());
    autosave->path = state_path(name, true);
}

void autosave_end(struct autosave *autosave)
{
    free(autosave->path);
    autosave->path = NULL;
}

static bool has_changed(const struct autosave *autosave)
{
    return autosave->session->changes != autosave->saved ||
           autosave->session->live.state == LIVE_RUNNING;
}

int64_t autosave_due(struct autosave *autosave)
{
    if (!has_changed(autosave)) {
        autosave->due = 0;
    } else if (autosave->due == 0) {
        autosave->due = clock_ns() + autosave->interval;
    }
    return autosave->due ? autosave->due : INT64_MAX;
}

static bool write_session(struct autosave *autosave, struct error *error)
{
    if (!autosave->path) {
        return error_set(error, ERROR_IO, "HOME is not set");
    }
    struct buffer text = {0};
    struct writer writer;
    session_autosave(autosave->session, &text);
    bool ok = text.failed ? error_memory(error)
                          : writer_open(&writer, autosave->path,
                                        (struct write_policy){.force = true}, error);
    if (ok) {
        writer_put(&writer, buffer_text(&text));
        ok = writer_commit(&writer, error);
    }
    buffer_free(&text);
    return ok;
}

bool autosave_write(struct autosave *autosave, struct error *error)
{
    struct error why = {0};
    if (!has_changed(autosave)) {
        return true;
    }
    autosave->due = 0;
    const uint64_t changes = autosave->session->changes;
    if (write_session(autosave, &why)) {
        autosave->saved = changes;
        return true;
    }
    const bool tell = !autosave->warned;
    autosave->warned = true;
    if (tell) {
        error_set(error, ERROR_IO, "the session cannot be saved on its own: %s", why.text);
    }
    return !tell;
}

/* ---- restoring
 * -------------------------------------------------------------------------------------------- */

static bool drop(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

static bool keep(void *context, struct text text)
{
    buffer_put(context, text);
    return true;
}

/* Executes the lines; the first that fails ends it. */
static bool execute(struct session *session, const char *name, struct text content,
                    struct error *error)
{
    struct buffer said = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){drop, keep, &said});
    struct source where = {.name = name};
    bool ok = true;
    for (struct text line; ok && content.len > 0 && text_split(&content, '\n', &line);) {
        where.line++;
        line = text_trim(line);
        if (line.len == 0 || line.at[0] == '#') {
            continue;
        }
        buffer_clear(&said);
        if (!command_exec(session, line, &where, &reply)) {
            struct text rest = text_trim(buffer_text(&said)), first = TEXT("");
            text_split(&rest, '\n', &first);
            ok = error_set(error, ERROR_COMMAND, "%.*s", (int)first.len, first.at);
        }
    }
    reply_free(&reply);
    buffer_free(&said);
    return ok;
}

static char *choose_saved(const char *folder, const char *name, struct error *error)
{
    struct saved_list list = list_saved(folder, false);
    const char *found = NULL;
    for (int i = 0; i < list.count && !found; i++) {
        const size_t len = strlen(list.item[i].name);
        const bool named =
            name && (strcmp(name, list.item[i].name) == 0 ||
                     (strlen(name) + 3 == len && strncmp(name, list.item[i].name, len - 3) == 0));
        if (name ? named : !list.item[i].living) {
            found = list.item[i].name;
        }
    }
    struct buffer path = {0};
    if (found) {
        buffer_format(&path, "%s%s", folder, found);
    } else {
        error_set(error, ERROR_USAGE, "there is no saved session%s%s in %s", name ? " " : "",
                  name ? name : "", folder);
        for (int i = 0; i < list.count && i < AUTOSAVE_KEPT; i++) {
            const size_t used = strlen(error->hint);
            snprintf(error->hint + used, sizeof error->hint - used, "%s%s",
                     i ? " " : "there are: ", list.item[i].name);
        }
    }
    free(list.item);
    return path.data;
}

bool autosave_resume(struct session **session, const char *name, struct buffer *messages,
                     struct error *error)
{
    char *folder = state_path("", false);
    if (!folder) {
        return error_set(error, ERROR_USAGE, "there is no saved session: HOME is not set");
    }
    struct buffer content = {0};
    struct session *restored = NULL;
    char *path = choose_saved(folder, name, error);
    const char *shown = path ? strrchr(path, '/') + 1 : "";
    bool ok = path && file_read(path, SAVED_BYTES, &content, error);
    if (ok && !(restored = session_create(&(*session)->front))) {
        ok = error_memory(error);
    }
    if (ok) {
        restored->safe = (*session)->safe;
        restored->keep_going = (*session)->keep_going;
        restored->restoring = true;
        ok = execute(restored, shown, buffer_text(&content), error);
        restored->restoring = false;
    }
    if (ok) {
        buffer_format(messages, "%s restored: %d run%s, %d recording%s", shown, restored->runs,
                      restored->runs == 1 ? "" : "s", restored->recordings,
                      restored->recordings == 1 ? "" : "s");
        session_destroy(*session);
        *session = restored;
    } else {
        session_destroy(restored);
    }
    buffer_free(&content);
    free(path);
    free(folder);
    return ok;
}
