/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Runs tests/cli/NAME.hk: one file is one test. Each line is executed as if it stood in a script;
 * comments beside it (or on lines of their own directly below) say what has to come of it:
 *
 *   # expect: TEXT    some line of its output contains TEXT
 *   # error: TEXT     it fails, and the message contains TEXT
 *   # warning: TEXT   a message that is no error contains TEXT
 *   # never: TEXT     neither output nor messages contain TEXT
 *
 * A line without `# error:` has to succeed, on a small stack.
 * Every line starts where the one before left the session. Files are written in a folder of their
 * own. A file with the line `# needs: NAME` is skipped where the build is without that method or
 * module. tests/stories holds what people do from start to end, tests/modules/MODULE/cli the
 * scenarios of modules. TESTS names another folder than tests.
 */
#include <hooke/method.h>
#include <hooke/base/file.h>
#include <hooke/command.h>
#include <hooke/module.h>

#include "painted_stack.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct capture {
    struct buffer out, err;
};

static bool take_out(void *context, struct text text)
{
    buffer_put(&((struct capture *)context)->out, text);
    return true;
}

static bool take_err(void *context, struct text text)
{
    buffer_put(&((struct capture *)context)->err, text);
    return true;
}

static bool contains(const struct buffer *buffer, struct text wanted)
{
    return buffer->data && wanted.len > 0 &&
           memmem(buffer->data, buffer->len, wanted.data, wanted.len);
}

static bool mark(struct text *line, const char *name, struct text *value)
{
    char key[32];
    snprintf(key, sizeof key, "# %s: ", name);
    const char *at = line->len ? memmem(line->data, line->len, key, strlen(key)) : NULL;
    if (!at)
        return false;
    *value = (struct text){at + strlen(key), line->len - (size_t)(at - line->data) - strlen(key)};
    /* The next mark on the same line ends this one. */
    const char *next = memmem(value->data, value->len, " # ", 3);
    const struct text rest = next ? (struct text){next, value->len - (size_t)(next - value->data)}
                                  : (struct text){NULL, 0};
    if (next)
        value->len = (size_t)(next - value->data);
    *value = text_trim(*value);
    *line = rest;
    return true;
}

struct scenario {
    const char *file;
    int number; /* of the line */
    bool failed;
    struct session *session;
    struct reply reply;
    struct capture capture;
};

static void complain(struct scenario *s, const char *what, struct text wanted)
{
    s->failed = true;
    printf("# %s:%d: %s '%.*s'\n", s->file, s->number, what, (int)wanted.len, wanted.data);
    struct text rest = buffer_text(&s->capture.out), line;
    while (text_split(&rest, '\n', &line) && rest.data)
        printf("#   out: %.*s\n", (int)line.len, line.data);
    rest = buffer_text(&s->capture.err);
    while (text_split(&rest, '\n', &line) && rest.data)
        printf("#   err: %.*s\n", (int)line.len, line.data);
}

/* Checks all marks of one line against the output of the statement before them. Returns whether an
 * error was announced.
 */
static bool check_marks(struct scenario *s, struct text marks)
{
    struct text value, line;
    bool error = false;
    for (line = marks; mark(&line, "expect", &value);)
        if (!contains(&s->capture.out, value))
            complain(s, "no output with", value);
    for (line = marks; mark(&line, "error", &value);) {
        error = true;
        if (!contains(&s->capture.err, value))
            complain(s, "no error with", value);
    }
    for (line = marks; mark(&line, "warning", &value);)
        if (!contains(&s->capture.err, value))
            complain(s, "no warning with", value);
    for (line = marks; mark(&line, "never", &value);)
        if (contains(&s->capture.out, value) || contains(&s->capture.err, value))
            complain(s, "unwanted", value);
    return error;
}

static bool starts_mark(struct text text)
{
    static const char *const names[] = {"# expect: ", "# error: ", "# warning: ", "# never: "};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (text_starts(text, text_of(names[i])))
            return true;
    return false;
}

/* The line without its marks: a message quotes the line, and would contain what it is asked for. */
static struct text without_marks(struct text line)
{
    size_t i = 0;
    while (i < line.len && !starts_mark((struct text){line.data + i, line.len - i}))
        i++;
    return text_trim((struct text){line.data, i});
}

/*
 * [byte] No statement uses more of the stack: builds that are not optimised have larger frames. The
 * aim is 64 KiB, which all but a few keep.
 */
#define STACK_MAX (144 << 10)

static struct depth {
    size_t used;
    int number;
    char file[64];
} deepest;

struct statement {
    struct scenario *scenario;
    const struct source *where;
    struct text line;
    bool ok;
};

static void *execute(void *context)
{
    struct statement *statement = context;
    struct scenario *s = statement->scenario;
    statement->ok = command_exec(s->session, statement->line, statement->where, &s->reply);
    return NULL;
}

static bool execute_line(struct scenario *s, const struct source *where, struct text line)
{
    struct statement statement = {s, where, line, false};
    const size_t used = painted_run(execute, &statement);
    if (used > deepest.used) {
        deepest = (struct depth){used, s->number, ""};
        snprintf(deepest.file, sizeof deepest.file, "%s", s->file);
    }
    if (used > STACK_MAX) {
        s->failed = true;
        printf("# %s:%d: used %zu bytes of stack, more than %d\n", s->file, s->number, used,
               STACK_MAX);
    }
    return statement.ok;
}

static void run_lines(struct scenario *s, struct text content)
{
    struct text rest = content, line;
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        const struct source where = {.name = s->file, .line = ++s->number};
        line = text_trim(line);
        if (line.len == 0 || starts_mark(line))
            continue;
        buffer_clear(&s->capture.out);
        buffer_clear(&s->capture.err);
        const bool ok = execute_line(s, &where, without_marks(line));
        bool expected = check_marks(s, line);
        /* Marks on the lines below belong to the same statement. */
        for (struct text after = rest, next;
             after.len > 0 && text_split(&after, '\n', &next) && starts_mark(text_trim(next));)
            expected |= check_marks(s, text_trim(next));
        if (ok && expected)
            complain(s, "succeeded:", line);
        else if (!ok && !expected)
            complain(s, "failed:", line);
    }
}

/* Whether the build has a method or a module of that name. */
static bool is_here(struct text name)
{
    bool here = catalog_find(&method_catalog, name);
    for (size_t i = 0; module_list[i]; i++)
        here = here || text_is(name, module_list[i]->row.name);
    return here;
}

/* The first line `# needs: NAME` whose name this build is without; text_of(NULL): none. */
static struct text missing_name(struct text content)
{
    static const char needs[] = "# needs: ";
    for (struct text line; content.len > 0 && text_split(&content, '\n', &line);) {
        if (!text_starts(line, text_of(needs)))
            continue;
        const size_t len = strlen(needs);
        const struct text name = text_trim((struct text){line.data + len, line.len - len});
        if (!is_here(name))
            return name;
    }
    return (struct text){NULL, 0};
}

/* Prints its line of TAP. Returns whether nothing failed. */
static bool run_file(const char *folder, const char *name, int number)
{
    struct buffer path = {0}, content = {0};
    struct error error;
    struct scenario s = {.file = name};
    buffer_format(&path, "%s/%s", folder, name);
    reply_init(&s.reply, (struct sink){take_out, take_err, &s.capture});
    s.session = session_create(&(struct front){.input = false}); /* no screen: no line is broken */
    struct text missing = {NULL, 0};
    const char *kind = strrchr(folder, '/') + 1;
    if (!s.session || !file_read(path.data, 1 << 20, &content, &error))
        s.failed = true;
    else if (!(missing = missing_name(buffer_text(&content))).data)
        run_lines(&s, buffer_text(&content));
    if (missing.data)
        printf("ok %d - %s/%s # SKIP built without %.*s\n", number, kind, name, (int)missing.len,
               missing.data);
    else
        printf("%s %d - %s/%s\n", s.failed ? "not ok" : "ok", number, kind, name);
    session_destroy(s.session);
    reply_free(&s.reply);
    buffer_free(&s.capture.out);
    buffer_free(&s.capture.err);
    buffer_free(&path);
    buffer_free(&content);
    return !s.failed;
}

static int is_script(const struct dirent *entry)
{
    const size_t len = strlen(entry->d_name);
    return len > 3 && strcmp(entry->d_name + len - 3, ".hk") == 0;
}

/* The scripts write files: into a fresh folder that is removed with all that is in it. */
static void remove_folder(const char *path)
{
    DIR *folder = opendir(".");
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            unlink(entry->d_name);
    if (folder)
        closedir(folder);
    if (chdir("/") == 0)
        rmdir(path);
}

enum { FOLDERS_MAX = LIMIT_MODULES + 2 };

/* Folders of scenarios: cli and stories, then that of each module that is in. */
static int folders_of(const char *tests, char *path[FOLDERS_MAX])
{
    static const char *const own[] = {"cli", "stories"};
    const size_t owns = COUNT_OF(own);
    int folders = 0;
    for (size_t i = 0; i < owns || module_list[i - owns]; i++) {
        struct buffer name = {0};
        if (i < owns)
            buffer_format(&name, "%s/%s", tests, own[i]);
        else
            buffer_format(&name, "%s/modules/%s/cli", tests, module_list[i - owns]->row.name);
        if ((path[folders] = realpath(buffer_view(&name), NULL)))
            folders++;
        buffer_free(&name);
    }
    if (folders == 0)
        printf("1..1\nnot ok 1 - scenarios below the folder %s\n", tests);
    return folders;
}

int main(void)
{
    char *path[FOLDERS_MAX], work[] = "/tmp/hooke-cli-XXXXXX";
    const char *tests = getenv("TESTS");
    struct dirent **entries[FOLDERS_MAX];
    int failures = 0, files = 0, count[FOLDERS_MAX] = {0};
    const int folders = folders_of(tests ? tests : "tests", path);
    if (folders == 0 || !mkdtemp(work) || chdir(work) != 0)
        return 1;
    for (int f = 0; f < folders; f++)
        files += count[f] = scandir(path[f], &entries[f], is_script, alphasort);
    printf("1..%d\n", files);
    for (int f = 0, number = 0; f < folders; f++) {
        for (int i = 0; i < count[f]; i++) {
            failures += !run_file(path[f], entries[f][i]->d_name, ++number);
            free(entries[f][i]);
        }
        free(entries[f]);
        free(path[f]);
    }
    printf("# at most %zu bytes of stack, in %s:%d\n", deepest.used, deepest.file, deepest.number);
    remove_folder(work);
    return failures > 0 || files <= 0;
}
