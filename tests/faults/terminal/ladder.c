/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Every writer of the program, while each of its system calls fails, is cut short or is the last
 * one that the program makes: what is there afterwards is the old or the new, whole; a failure is
 * told; and nothing is left behind after the next start.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "faults/failing_calls.h"
#include "modules/resume/terminal/autosave.h"
#include "terminal/folder.h"
#include "unit/command/testing.h"

#include <readline/history.h>
#include <sys/wait.h>

enum { SAID = 4, UNSAID = 9 }; /* exit statuses of a child that fails */

/* ---- the writers ---- */

static struct bench bench;
static const char *lines[4]; /* of the row that is tried */

static bool act_typed(struct error *error)
{
    for (size_t i = 0; i < COUNT_OF(lines) && lines[i]; i++)
        if (!type(&bench, lines[i]))
            return error_set(error, ERROR_IO, "%s", buffer_view(&bench.err));
    return true;
}

static bool act_history(struct error *error)
{
    return history_append("m = 200 g", error);
}

static bool act_history_load(struct error *error)
{
    (void)error;
    history_load();
    return true;
}

static bool act_split(struct error *error)
{
    struct split split;
    struct streams streams = {.split = &split};
    if (!split_begin(&split, "there", true, error))
        return false;
    for (int i = 0; i < 3; i++) {
        split_part(&streams, "run");
        split_takes(&split, TEXT("a,b\n1,2\n"));
    }
    return split_end(&split, error);
}

static bool act_output(struct error *error)
{
    struct streams streams = {0};
    const int out = open("there", O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (out < 0 || dup2(out, STDOUT_FILENO) < 0)
        return error_set(error, ERROR_IO, "no output");
    const struct sink sink = streams_sink(&streams);
    for (int i = 0; i < 30000; i++)
        sink.output(sink.context, TEXT("a line of results\n"));
    return streams_flush(&streams) || error_set(error, ERROR_IO, "%d", streams.failure);
}

static bool act_autosave(struct error *error)
{
    struct autosave autosave;
    autosave_begin(&autosave, bench.session);
    autosave.saved--;
    const bool ok = autosave_write(&autosave, error);
    autosave_end(&autosave);
    return ok;
}

/* A session can be taken up again, whole unless the program was killed, or there is none. */
static bool can_resume(bool killed)
{
    int status;
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct buffer messages = {0};
        struct error error = {0};
        const bool resumed = autosave_resume(&bench.session, NULL, &messages, &error);
        if (resumed)
            _exit(killed || bench.session->runs.count == 2 ? 0 : 1);
        _exit(strstr(error.text, "no saved session") ? 0 : 2);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/* What is there: its name, what it may be instead of the bytes that were there before or would be
 * there without the fault, and where the status says nothing. */
static const struct ladder {
    const char *name, *lines[4];
    bool (*act)(struct error *error);
    const char *before; /* a line that makes what is there; "=NAME": a file of one line */
    const char *end;    /* of a file of any bytes that is whole; NULL: it has those bytes */
    bool silent;        /* no failure is told */
    bool any;           /* what cannot be whole: only the status counts */
} rows[] = {
    {"export csv", {"export there.csv t,y,v --force"}, .before = "export there.csv y"},
    {"export json", {"export there.json --force"}, .before = "export there.json y"},
    {"export html, new", {"export there.html y"}, .before = NULL},
    {"plot svg", {"plot position > there.svg --force"}, .before = "plot phase > there.svg"},
    {"plot pdf", {"plot position > there.pdf --force"}, .before = "=there.pdf", .end = "%%EOF\n"},
    {"plot png",
     {"plot position > there.png --force"},
     .before = "=there.png",
     .end = "IEND\xae\x42\x60\x82"},
    {"plot txt", {"plot position > there.txt --force"}, .before = "plot phase > there.txt"},
    {"save", {"save there.hk --force"}, .before = "save there.hk"},
    {"redirect", {"runs > there.csv --force"}, .before = "export there.csv y"},
    {"screenshot", {"screenshot there.txt --force"}, .before = "plot phase > there.txt"},
    {"report, new", {"report there"}, .before = NULL},
    {"report", {"report there --force"}, .before = "=there/report.md"},
    {"split", .act = act_split},
    {"record", {"record there.hk", "k = 6 N/m"}, .before = "save there.hk"},
    {"record, to its end",
     {"record there.hk", "k = 6 N/m", "record off"},
     .before = "save there.hk"},
    {"history", .act = act_history, .before = "save there"},
    {"history cut back", .act = act_history_load, .before = "long history", .silent = true},
    {"standard output", .act = act_output, .any = true},
    {"session", .act = act_autosave, .any = true},
};

/* ---- what is there ---- */

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static int is_name(const struct dirent *entry)
{
    return strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
}

/* All names and bytes; hidden: only how many strays there are. */
static void look(const char *path, struct buffer *out, int *strays)
{
    struct dirent **entry;
    struct error error;
    const int count = scandir(path, &entry, is_name, by_name);
    for (int i = 0; i < count; i++) {
        char name[600];
        struct stat st;
        snprintf(name, sizeof name, "%s/%s", path, entry[i]->d_name);
        assert_int_equal(lstat(name, &st), 0);
        buffer_format(out, "%s\n", name);
        *strays += strncmp(entry[i]->d_name, ".hooke-", 7) == 0;
        if (S_ISDIR(st.st_mode))
            look(name, out, strays);
        else
            assert_true(file_read(name, 1u << 24, out, &error));
        free(entry[i]);
    }
    if (count >= 0)
        free(entry);
}

static void remove_all(void)
{
    assert_int_equal(nftw(".", remove_entry, 8, FTW_DEPTH | FTW_PHYS) <= 0, 1);
}

/* ---- one fault ---- */

static void make_history(void)
{
    mkdir("hooke", 0700);
    FILE *file = fopen("hooke/history", "w");
    assert_non_null(file);
    for (int i = 0; i < 2 * HISTORY_LINES; i++)
        fprintf(file, "m = %d g\n", i);
    assert_int_equal(fclose(file), 0);
}

static void make_old(const char *path)
{
    if (strchr(path, '/'))
        assert_int_equal(mkdir("there", 0700), 0);
    FILE *file = fopen(path, "w");
    assert_true(file && fputs("old\n", file) >= 0 && fclose(file) == 0);
}

/* Runs in a child, which has the session as it was. Returns its exit status, 128 + signal. */
static int in_child(const struct ladder *row, enum fault_kind kind, int at, int number, int *calls)
{
    int ends[2], status;
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct error error = {0};
        memcpy(lines, row->lines, sizeof lines);
        fault.at = at;
        fault.number = number;
        fault.calls = 0;
        fault.kind = kind;
        const bool ok = row->act ? row->act(&error) : act_typed(&error);
        fault.kind = FAULT_NONE;
        fault.torn = false;
        if (write(ends[1], &fault.calls, sizeof fault.calls) < 0)
            _exit(1);
        _exit(ok ? 0 : error.text[0] ? SAID : UNSAID);
    }
    close(ends[1]);
    if (read(ends[0], calls, sizeof *calls) != (ssize_t)sizeof *calls)
        *calls = at + 1; /* killed: it was struck */
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

static void prepare(const struct ladder *row)
{
    remove_all();
    if (row->before && strcmp(row->before, "long history") == 0) {
        make_history();
    } else if (row->before && row->before[0] == '=') {
        make_old(row->before + 1);
    } else if (row->before) {
        assert_true(type(&bench, row->before));
        if (row->act == act_history)
            assert_true(mkdir("hooke", 0700) == 0 && rename("there", "hooke/history") == 0);
    }
}

static bool is_whole(const struct ladder *row, const struct buffer *now)
{
    const size_t len = strlen(row->end);
    return now->len > len && memcmp(now->data + now->len - len, row->end, len) == 0;
}

static bool same(const struct buffer *a, const struct buffer *b)
{
    return text_equal(buffer_text(a), buffer_text(b));
}

static struct {
    int tried, failed, left, torn, lies, strays;
} total;

/* The fault strikes the call number `at`. False: there are not so many. */
static bool strike(const struct ladder *row, enum fault_kind kind, int at, int number,
                   const struct buffer *old, const struct buffer *new)
{
    struct buffer now = {0};
    int calls, strays = 0, left = 0;
    prepare(row);
    const int status = in_child(row, kind, at, number, &calls);
    const bool struck = calls > at;
    look(".", &now, &left);
    strays_sweep_path(".");
    strays_sweep_path("hooke");
    buffer_clear(&now);
    look(".", &now, &strays);
    const bool is_new = row->end ? is_whole(row, &now) && !same(&now, old) : same(&now, new);
    const bool torn = row->act == act_autosave ? !can_resume(status > 128)
                                               : !row->any && !is_new && !same(&now, old);
    const bool lie = (!row->any && !row->silent && status == 0 && !is_new) || status == UNSAID ||
                     (status > 128 && kind != FAULT_KILL_BEFORE && kind != FAULT_KILL_AFTER);
    total.tried += struck;
    total.failed += status != 0;
    total.left += left > 0;
    total.torn += torn;
    total.lies += lie;
    total.strays += strays;
    if (torn || lie || strays > 0)
        print_message("# %s: kind %d, call %d, errno %d: status %d%s%s%s\n", row->name, (int)kind,
                      at, number, status, torn ? ", torn" : "", lie ? ", a lie" : "",
                      strays ? ", a stray" : "");
    buffer_free(&now);
    return struck;
}

static void climb(const struct ladder *row)
{
    static const struct {
        enum fault_kind kind;
        int number;
    } faults[] = {{FAULT_ERRNO, ENOSPC},  {FAULT_ERRNO, EIO},   {FAULT_ERRNO, EINTR},
                  {FAULT_ERRNO, EACCES},  {FAULT_SHORT, 0},     {FAULT_TORN, ENOSPC},
                  {FAULT_KILL_BEFORE, 0}, {FAULT_KILL_AFTER, 0}};
    struct buffer old = {0}, new = {0};
    int calls, ignored = 0;
    prepare(row);
    look(".", &old, &ignored);
    if (in_child(row, FAULT_ERRNO, 1 << 30, 0, &calls) != 0) { /* without cairo */
        print_message("# %s: not here\n", row->name);
        buffer_free(&old);
        return;
    }
    look(".", &new, &ignored);
    for (size_t i = 0; i < COUNT_OF(faults); i++) {
        /* A sample is other calls for each fault. */
        const int step = is_long() ? 1 : calls / 2 + 1;
        int at = is_long() ? 0 : (int)i % step;
        while (strike(row, faults[i].kind, at, faults[i].number, &old, &new))
            at += step;
    }
    buffer_free(&old);
    buffer_free(&new);
}

TEST(every_writer)
{
    char folder[] = "/tmp/hooke-ladder-XXXXXX";
    assert_non_null(make_folder(folder));
    assert_int_equal(chdir(folder), 0);
    setenv("XDG_STATE_HOME", folder, 1);
    bench_open(&bench, false);
    screenshot_offer(&bench.session->front);
    assert_true(type(&bench, "run 1 s; note first; method rk4; run 1 s"));
    fault.dry = true;
    type(&bench,
         "plot position > warm.pdf; plot position > warm.png"); /* the fonts are known now */
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        climb(&rows[i]);
    bench_close(&bench);
    remove_all();
    assert_int_equal(chdir("/"), 0);
    print_message("# %d faults: %d failures told or killed, %d times something left behind; %d "
                  "torn, %d lies, %d strays after the next start\n",
                  total.tried, total.failed, total.left, total.torn, total.lies, total.strays);
    assert_true(total.tried > 100 && total.failed > 50 && total.left > 5);
    assert_int_equal(total.torn + total.lies + total.strays, 0);
}

RUN_TESTS(NULL, NULL)
