/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The promise of the writer, "the old file or the new one, whole", while each of its system calls
 * fails, is cut short or is the last one that the program makes; and against full disks, folders
 * without permission and hostile names.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "faults/failing_calls.h"
#include <hooke/base/file.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- the folder ----
 */

#define SIZE 150000

static int enter_folder(void **state)
{
    const char *base = getenv("TMPDIR");
    char *folder = malloc(256);
    if (!folder)
        return -1;
    snprintf(folder, 256, "%s/hooke-writer-XXXXXX", base && *base ? base : "/tmp");
    *state = folder;
    return mkdtemp(folder) && chmod(folder, 0755) == 0 && chdir(folder) == 0 ? 0 : -1;
}

/* What is in the folder besides `target` and `victim`: how many, and removes it; none may be there
 * under another name.
 */
static int sweep(void)
{
    int strays = 0;
    DIR *folder = opendir(".");
    assert_non_null(folder);
    for (struct dirent *entry; (entry = readdir(folder));) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0 ||
            strcmp(entry->d_name, "target") == 0 || strcmp(entry->d_name, "victim") == 0)
            continue;
        assert_true(strncmp(entry->d_name, ".hooke-", 7) == 0);
        assert_int_equal(unlink(entry->d_name), 0);
        strays++;
    }
    closedir(folder);
    return strays;
}

static int leave_folder(void **state)
{
    fault.kind = FAULT_NONE;
    unlink("target");
    unlink("victim");
    const int result = chdir("/") == 0 ? rmdir(*state) : -1;
    free(*state);
    return result;
}

static void make(const char *path, char letter)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i < SIZE; i++)
        fputc(letter, file);
    assert_int_equal(fclose(file), 0);
}

/* The one letter that the whole file consists of; 0: there is no file. Anything else is a failure.
 */
static char letter_of(const char *path)
{
    struct buffer b = {0};
    struct error error = {0};
    if (access(path, F_OK) != 0)
        return '\0';
    assert_true(file_read(path, 1u << 24, &b, &error));
    assert_int_equal(b.len, SIZE);
    for (size_t i = 0; i < b.len; i++)
        assert_int_equal(b.data[i], b.data[0]);
    const char letter = b.data[0];
    buffer_free(&b);
    return letter;
}

static bool put(const char *path, char letter, struct write_policy policy, struct error *error)
{
    static char piece[SIZE / 15];
    struct writer writer;
    memset(piece, letter, sizeof piece);
    if (!writer_open(&writer, path, policy, error))
        return false;
    for (int i = 0; i < 15; i++)
        writer_put(&writer, (struct text){piece, sizeof piece});
    return writer_commit(&writer, error);
}

/* ---- every system call ---- */

static const struct scenario {
    const char *name;
    bool replace, no_tmpfile, no_noreplace;
} scenarios[] = {
    {"create", false, false, false},
    {"replace", true, false, false},
    {"create by name", false, true, false},
    {"replace by name", true, true, false},
    {"create by name and link", false, true, true},
};

static void prepare(const struct scenario *scenario, enum fault_kind kind, int at, int number)
{
    fault.kind = FAULT_NONE;
    unlink("target");
    if (scenario->replace)
        make("target", 'o');
    fault.at = at;
    fault.number = number;
    fault.calls = 0;
    fault.struck = "";
    fault.no_tmpfile = scenario->no_tmpfile;
    fault.no_noreplace = scenario->no_noreplace;
    fault.kind = kind;
}

/* Runs with the fault at the first, second, … call until none is struck any more; returns how many
 * calls there were. */
static int strike_all(const struct scenario *scenario, enum fault_kind kind, int number,
                      int *failures)
{
    for (int at = 0;; at++) {
        struct error error = {0};
        prepare(scenario, kind, at, number);
        const bool done =
            put("target", 'n', (struct write_policy){.force = scenario->replace, .confine = true},
                &error);
        const bool over = fault.calls <= at;
        fault.kind = FAULT_NONE;
        const char now = letter_of("target"), before = scenario->replace ? 'o' : '\0';
        const int strays = sweep();
        *failures += !done;
        /* A folder that cannot be synced is reported, though the file is there. */
        const bool published = strcmp(fault.struck, "fsync") == 0 && now == 'n';
        const bool torn = done ? now != 'n' : now != before && !published;
        /* Interruptions are no failures; a file or a folder that is not on the disk is. */
        const bool stores =
            strcmp(fault.struck, "fsync") == 0 || strcmp(fault.struck, "write") == 0;
        if (kind == FAULT_ERRNO && stores &&
            done != (number == EINTR || (number == EINVAL && now == 'n')))
            fail_msg("%s: %s (call %d) failing with %d: done %d", scenario->name, fault.struck, at,
                     number, done);
        const bool silent = !done && (error.code != ERROR_IO || error.text[0] == '\0');
        const bool littered = strays > 0 && strcmp(fault.struck, "unlinkat") != 0;
        if (torn || silent || littered || (over && !done))
            fail_msg("%s: %s (call %d) failing with %d: done %d, file '%c', %d strays, '%s'",
                     scenario->name, fault.struck, at, number, done, now ? now : '-', strays,
                     error.text);
        if (over)
            return at;
    }
}

static void every_call_fails(void **state)
{
    (void)state;
    static const int numbers[] = {ENOSPC, EIO,   EDQUOT, EMFILE, EACCES,
                                  EINTR,  EROFS, EEXIST, EINVAL};
    for (size_t s = 0; s < COUNT_OF(scenarios); s++)
        for (size_t i = 0; i < COUNT_OF(numbers); i++) {
            int failures = 0;
            const int calls = strike_all(&scenarios[s], FAULT_ERRNO, numbers[i], &failures);
            assert_true(calls > 12); /* or the faults do not reach the writer */
            assert_true(failures > 3);
        }
}

static void every_write_is_cut_short(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT_OF(scenarios); s++) {
        int failures = 0;
        strike_all(&scenarios[s], FAULT_SHORT, 0, &failures);
        assert_int_equal(failures, 0);
    }
}

static void every_call_is_the_last(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT_OF(scenarios); s++)
        for (int kind = FAULT_KILL_BEFORE; kind <= FAULT_KILL_AFTER; kind++) {
            bool killed = true, seen_old = false, seen_new = false;
            for (int at = 0; killed; at++) {
                prepare(&scenarios[s], FAULT_NONE, at, 0);
                const pid_t child = fork();
                assert_true(child >= 0);
                if (child == 0) {
                    struct error error;
                    fault.kind = (enum fault_kind)kind;
                    _exit(put("target", 'n',
                              (struct write_policy){.force = scenarios[s].replace, .confine = true},
                              &error)
                              ? 0
                              : 1);
                }
                int status;
                assert_int_equal(waitpid(child, &status, 0), child);
                killed = WIFSIGNALED(status);
                assert_true(killed ? WTERMSIG(status) == SIGKILL : WEXITSTATUS(status) == 0);
                const char now = letter_of("target"), before = scenarios[s].replace ? 'o' : '\0';
                const int strays = sweep();
                assert_true(now == before || now == 'n');
                assert_true(killed || now == 'n');
                seen_old = seen_old || now == before;
                seen_new = seen_new || (killed && now == 'n');
                if (!scenarios[s].replace && !scenarios[s].no_tmpfile)
                    assert_int_equal(strays, 0);
                assert_true(strays <= 1);
            }
            if (!seen_old || !seen_new)
                fail_msg("%s, kind %d: never seen the %s file", scenarios[s].name, kind,
                         seen_old ? "new" : "old");
        }
}

static void killed_at_random_moments(void **state)
{
    (void)state;
    const int rounds = is_long() ? 2000 : 60;
    unsigned random = 1;
    prepare(&scenarios[0], FAULT_NONE, 0, 0);
    for (int i = 0; i < rounds; i++) {
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            struct error error;
            for (char letter = 'a';; letter = letter == 'z' ? 'a' : (char)(letter + 1))
                if (!put("target", letter, (struct write_policy){.force = true, .confine = false},
                         &error))
                    _exit(1);
        }
        random = random * 1103515245u + 12345u;
        usleep(random / 65536 % 8000);
        int status;
        kill(child, SIGKILL);
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status));
        letter_of("target"); /* absent or whole */
        strays_sweep_path(".");
        assert_int_equal(sweep(), 0);
    }
}

/* ---- real trouble ---- */

static void a_full_disk_is_told(void **state)
{
    (void)state;
    struct rlimit old, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    static const rlim_t sizes[] = {0, 1, 4096, 65536, 65537, SIZE - 1};
    for (size_t s = 0; s < COUNT_OF(scenarios); s++)
        for (size_t i = 0; i < COUNT_OF(sizes); i++) {
            struct error error = {0};
            prepare(&scenarios[s], FAULT_NONE, 0, 0);
            small = (struct rlimit){sizes[i], old.rlim_max};
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
            const bool done =
                put("target", 'n',
                    (struct write_policy){.force = scenarios[s].replace, .confine = false}, &error);
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
            assert_false(done);
            assert_int_equal(error.code, ERROR_IO);
            assert_string_equal(error.text, "cannot write target: File too large");
            assert_int_equal(letter_of("target"), scenarios[s].replace ? 'o' : '\0');
            assert_int_equal(sweep(), 0);
        }
    signal(SIGXFSZ, handler);
}

static void a_folder_without_permission_is_told(void **state)
{
    (void)state;
    prepare(&scenarios[1], FAULT_NONE, 0, 0);
    assert_int_equal(chmod(".", 0555), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct error error = {0};
        if (geteuid() == 0 &&
            (setgid(65534) != 0 || setuid(65534) != 0)) /* root may write everywhere */
            _exit(3);
        if (put("other", 'n', (struct write_policy){.force = false, .confine = false}, &error) ||
            strcmp(error.text, "cannot write other: Permission denied") != 0)
            _exit(1);
        _exit(put("target", 'n', (struct write_policy){.force = true, .confine = false}, &error)
                  ? 2
                  : 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(chmod(".", 0755), 0);
    assert_true(WIFEXITED(status));
    if (WEXITSTATUS(status) == 3) {
        print_message("cannot become another user\n");
        skip();
    }
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_int_equal(letter_of("target"), 'o');
}

static void hostile_names(void **state)
{
    (void)state;
    static char longest[256], too_long[257], endless[5001];
    memset(longest, 'L', 255);
    memset(too_long, 'T', 256);
    memset(endless, 'E', 5000);
    const char *const names[] = {
        "-rf",
        "--force",
        "-",
        "*",
        "?",
        "[a]",
        "~",
        "~root",
        "$HOME",
        "$(id)",
        "`id`",
        "a b",
        " ",
        "\t",
        "\n",
        "a\nb",
        "\r",
        "\033[2J",
        "\a",
        "\x7f",
        "\xff\xfe",
        "\xC2\x9B"
        "1m",
        "\xE2\x80\xAE"
        "txt.csv",
        "%s%n",
        "a;b",
        "a|b",
        ">a",
        "a&",
        "'",
        "\"",
        "\\",
        "...",
        "..a",
        ".hidden",
        "con",
        "nul:",
        "a:b",
        longest,
        too_long,
        endless,
        "victim/",
        "victim/.",
        "./victim/../x",
        "",
        "/",
        "//",
        ".",
        "..",
        "./.",
        "../victim-not",
        "../../x",
        "/x",
    };
    assert_true(COUNT_OF(names) >= 40);
    prepare(&scenarios[0], FAULT_NONE, 0, 0);
    make("victim", 'v');
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (int forced = 0; forced <= 1; forced++) {
            struct error error = {0};
            const struct write_policy policy = {.force = forced, .confine = true};
            const bool done = put(names[i], 'n', policy, &error);
            if (done) {
                assert_int_equal(letter_of(names[i]), 'n');
                assert_int_equal(unlink(names[i]), 0);
                /* The same name as a link to the victim is refused, whatever is asked. */
                assert_int_equal(symlink("victim", names[i]), 0);
                assert_false(put(names[i], 'n', policy, &error));
                assert_int_equal(unlink(names[i]), 0);
                /* a hard link: force replaces this name only */
                assert_int_equal(link("victim", names[i]), 0);
                assert_int_equal(put(names[i], 'n', policy, &error), forced);
                assert_int_equal(unlink(names[i]), 0);
            } else {
                assert_int_equal(error.code, ERROR_IO);
                for (const char *c = error.text; *c; c++)
                    assert_true((unsigned char)*c >= 0x20 && *c != 0x7F);
            }
            assert_int_equal(done, i < 38);
            assert_int_equal(letter_of("victim"), 'v');
            assert_int_equal(sweep(), 0);
        }
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(every_call_fails),       IN_FOLDER(every_write_is_cut_short),
        IN_FOLDER(every_call_is_the_last), IN_FOLDER(killed_at_random_moments),
        IN_FOLDER(a_full_disk_is_told),    IN_FOLDER(a_folder_without_permission_is_told),
        IN_FOLDER(hostile_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
