/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The promise of the folder writer, "the old folder or the new one, whole", while each of its
 * system calls fails, is cut short or is the last one that the program makes; and that it never
 * removes what is not its own.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "faults/failing_calls.h"
#include <hooke/base/file.h>

#include <dirent.h>
#include <stdlib.h>
#include <sys/wait.h>

#define FILES 3
#define SIZE 9000

static const char *const names[FILES] = {"one.txt", "two.txt", "three.txt"};

static int enter_folder(void **state)
{
    const char *base = getenv("TMPDIR");
    char *folder = malloc(256);
    if (!folder)
        return -1;
    snprintf(folder, 256, "%s/hooke-folder-XXXXXX", base && *base ? base : "/tmp");
    *state = folder;
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static void remove_folder(const char *path)
{
    DIR *list = opendir(path);
    char name[512];
    for (struct dirent *entry; list && (entry = readdir(list));) {
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            unlink(name);
    }
    if (list)
        closedir(list);
    rmdir(path);
}

/* How many hidden folders are here besides `target`; removes them. */
static int sweep(void)
{
    int strays = 0;
    DIR *list = opendir(".");
    assert_non_null(list);
    for (struct dirent *entry; (entry = readdir(list));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 &&
            strcmp(entry->d_name, "target") != 0) {
            assert_true(strncmp(entry->d_name, ".hooke-", 7) == 0);
            remove_folder(entry->d_name);
            strays++;
        }
    closedir(list);
    return strays;
}

static int leave_folder(void **state)
{
    fault.kind = FAULT_NONE;
    remove_folder("target");
    sweep();
    const int result = chdir("/") == 0 ? rmdir(*state) : -1;
    free(*state);
    return result;
}

static bool own(const char *name)
{
    const size_t len = strlen(name);
    return len > 4 && strcmp(name + len - 4, ".txt") == 0;
}

static bool put(const char *path, char letter, struct write_policy policy, struct error *error)
{
    static char content[SIZE];
    struct folder folder;
    memset(content, letter, sizeof content);
    if (!folder_open(&folder, path, policy, own, error))
        return false;
    for (int i = 0; i < FILES; i++)
        if (!folder_put(&folder, names[i], (struct text){content, sizeof content}, error)) {
            folder_abandon(&folder);
            return false;
        }
    return folder_commit(&folder, error);
}

/* The one letter that all files of the folder consist of; 0: there is no folder. Anything else is a
 * failure. */
static char letter_of(const char *path)
{
    char letter = '\0', name[64];
    if (access(path, F_OK) != 0)
        return '\0';
    for (int i = 0; i < FILES; i++) {
        struct buffer content = {0};
        struct error error = {0};
        snprintf(name, sizeof name, "%s/%s", path, names[i]);
        assert_true(file_read(name, 1u << 20, &content, &error));
        assert_int_equal(content.len, SIZE);
        letter = i ? letter : content.data[0];
        for (size_t c = 0; c < content.len; c++)
            assert_int_equal(content.data[c], letter);
        buffer_free(&content);
    }
    return letter;
}

static const struct scenario {
    const char *name;
    bool replace, no_exchange;
} scenarios[] = {
    {"create", false, false}, {"replace", true, false}, {"replace in turn", true, true}};

static void prepare(const struct scenario *scenario, enum fault_kind kind, int at, int number)
{
    struct error error = {0};
    fault.kind = FAULT_NONE;
    fault.no_noreplace = false;
    remove_folder("target");
    if (scenario->replace)
        assert_true(
            put("target", 'o', (struct write_policy){.force = false, .confine = false}, &error));
    fault.at = at;
    fault.number = number;
    fault.calls = 0;
    fault.struck = "";
    fault.no_noreplace = scenario->no_exchange;
    fault.kind = kind;
}

static void every_call_fails(void **state)
{
    (void)state;
    static const int numbers[] = {ENOSPC, EIO,   EDQUOT, EMFILE, EACCES,
                                  EINTR,  EROFS, EEXIST, EINVAL};
    for (size_t s = 0; s < COUNT_OF(scenarios); s++)
        for (size_t i = 0; i < COUNT_OF(numbers); i++) {
            int failures = 0;
            for (int at = is_long() ? 0 : (int)i % 3;; at += is_long() ? 1 : 3) {
                struct error error = {0};
                prepare(&scenarios[s], FAULT_ERRNO, at, numbers[i]);
                const bool done = put(
                    "target", 'n',
                    (struct write_policy){.force = scenarios[s].replace, .confine = true}, &error);
                const bool over = fault.calls <= at;
                fault.kind = FAULT_NONE;
                const char now = letter_of("target"), before = scenarios[s].replace ? 'o' : '\0';
                const int strays = sweep();
                failures += !done;
                const bool published = strcmp(fault.struck, "fsync") == 0 && now == 'n';
                const bool torn = done ? now != 'n' : now != before && !published;
                const bool silent = !done && (error.code != ERROR_IO || error.text[0] == '\0');
                /* What cannot be listed, looked at or removed stays behind, hidden. */
                const bool cleaning = strcmp(fault.struck, "unlinkat") == 0 ||
                                      strcmp(fault.struck, "openat") == 0 ||
                                      strcmp(fault.struck, "fstatat") == 0;
                if (torn || silent || (strays > 0 && !cleaning) || strays > 1 || (over && !done))
                    fail_msg(
                        "%s: %s (call %d) failing with %d: done %d, folder '%c', %d strays, '%s'",
                        scenarios[s].name, fault.struck, at, numbers[i], done, now ? now : '-',
                        strays, error.text);
                if (over) {
                    assert_true(at > 20); /* or the faults do not reach the writer */
                    break;
                }
            }
            assert_true(failures > (is_long() ? 3 : 0));
        }
}

static void every_write_is_cut_short(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT_OF(scenarios); s++)
        for (int at = 0, over = 0; !over; at++) {
            struct error error = {0};
            prepare(&scenarios[s], FAULT_SHORT, at, 0);
            assert_true(put("target", 'n',
                            (struct write_policy){.force = scenarios[s].replace, .confine = true},
                            &error));
            over = fault.calls <= at;
            assert_int_equal(letter_of("target"), 'n');
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
                strays_sweep_path(".");
                const char now = letter_of("target"), before = scenarios[s].replace ? 'o' : '\0';
                assert_true(now == before || now == 'n');
                assert_true(killed || now == 'n');
                seen_old = seen_old || now == before;
                seen_new = seen_new || (killed && now == 'n');
                assert_int_equal(sweep(), 0);
            }
            assert_true(seen_old && seen_new);
        }
}

static void refused(const char *path, struct write_policy policy, const char *why)
{
    struct error error = {0};
    assert_false(put(path, 'n', policy, &error));
    assert_int_equal(error.code, ERROR_IO);
    if (!strstr(error.text, why))
        fail_msg("'%s' is not in '%s'", why, error.text);
    assert_int_equal(sweep(), 0);
}

static void what_is_there_stays(void **state)
{
    (void)state;
    const struct write_policy plain = {.force = false}, force = {.force = true};
    struct error error = {0};
    assert_true(put("target//", 'a', plain, &error));
    refused("target", plain, "target exists; add --force");
    assert_int_equal(letter_of("target"), 'a');
    /* A file that is not its own, a link and a folder inside: nothing is replaced. */
    FILE *file = fopen("target/answers.odt", "w");
    assert_non_null(file);
    fclose(file);
    refused("target", force, "it also holds answers.odt");
    assert_int_equal(unlink("target/answers.odt"), 0);
    assert_int_equal(symlink("/etc/passwd", "target/link.txt"), 0);
    refused("target", force, "it also holds link.txt");
    assert_int_equal(unlink("target/link.txt"), 0);
    assert_int_equal(mkdir("target/folder.txt", 0777), 0);
    refused("target", force, "it also holds folder.txt");
    assert_int_equal(rmdir("target/folder.txt"), 0);
    assert_int_equal(letter_of("target"), 'a');
    assert_true(put("target", 'b', force, &error));
    assert_int_equal(letter_of("target"), 'b');
    assert_int_equal(sweep(), 0);
    refused(".", force, "name a new folder");
    refused("..", force, "name a new folder");
    refused("/", force, "");
    refused("", force, "the name is empty");
    refused("no/such", force, "No such file");
    refused("target/one.txt", force, "not a folder");
    refused("../outside", (struct write_policy){.force = true, .confine = true},
            "outside the current directory");
    assert_int_equal(access("../outside", F_OK), -1);
    remove_folder("target");
    assert_int_equal(symlink("/tmp", "target"), 0);
    refused("target", force, "not a folder");
    assert_int_equal(unlink("target"), 0);
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(every_call_fails),
        IN_FOLDER(every_write_is_cut_short),
        IN_FOLDER(every_call_is_the_last),
        IN_FOLDER(what_is_there_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
