/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What killed programs leave goes, what somebody writes and what is a user's stays, whoever sweeps
 * meanwhile.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "faults/failing_calls.h"
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>

#include <stdlib.h>
#include <sys/wait.h>

static int enter_folder(void **state)
{
    char *folder = strdup("/tmp/hooke-strays-XXXXXX");
    *state = folder;
    return folder && mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state)
{
    char command[64];
    fault.no_tmpfile = fault.no_noreplace = false;
    snprintf(command, sizeof command, "rm -rf %s", (char *)*state);
    free(*state);
    return chdir("/") == 0 && system(command) == 0 ? 0 : -1;
}

static int make(const char *name)
{
    const int fd = open(name, O_WRONLY | O_CREAT | O_EXCL, 0600);
    assert_true(fd >= 0);
    return fd;
}

static bool is_there(const char *name)
{
    struct stat st;
    return lstat(name, &st) == 0;
}

static void only_strays_go(void **state)
{
    (void)state;
    static const char *const theirs[] = {
        ".hooke-",           ".hooke-0badcafe",  ".hooke-0badcafe.", ".hooke-0badcaf.x",
        ".hooke-0BADCAFE.x", ".hooke-notes.txt", "hooke-0badcafe.x", ".hooke-0badcafe-x"};
    static const char *const strays[] = {".hooke-0badcafe.x", ".hooke-0badcaff~x"};
    for (size_t i = 0; i < COUNT_OF(theirs); i++)
        close(make(theirs[i]));
    for (size_t i = 0; i < COUNT_OF(strays); i++)
        close(make(strays[i]));
    assert_int_equal(symlink("/etc/passwd", ".hooke-00000001.x"), 0);
    assert_int_equal(mkfifo(".hooke-00000002.x", 0600), 0);
    assert_int_equal(mkdir(".hooke-00000003.x", 0700), 0);
    assert_int_equal(mkdir(".hooke-00000003.x/mine", 0700), 0);
    assert_int_equal(mkdir(".hooke-00000004.x", 0700), 0);
    close(make(".hooke-00000004.x/part.csv"));
    const int written = make(".hooke-00000005.x");
    assert_true(file_lock(written, false));
    strays_sweep_path(".");
    for (size_t i = 0; i < COUNT_OF(theirs); i++)
        assert_true(is_there(theirs[i]));
    for (size_t i = 0; i < COUNT_OF(strays); i++)
        assert_false(is_there(strays[i]));
    assert_true(is_there(".hooke-00000001.x") && is_there(".hooke-00000002.x"));
    assert_true(is_there(".hooke-00000003.x/mine"));
    assert_false(is_there(".hooke-00000004.x"));
    assert_true(is_there(".hooke-00000005.x"));
    close(written);
    strays_sweep_path(".");
    assert_false(is_there(".hooke-00000005.x"));
}

/* The only copy of a folder that had to make room comes back to its place. */
static void an_old_folder_comes_back(void **state)
{
    (void)state;
    assert_int_equal(mkdir(".hooke-00000001~report", 0700), 0);
    close(make(".hooke-00000001~report/values.csv"));
    strays_sweep_path(".");
    assert_true(is_there("report/values.csv"));
    assert_int_equal(mkdir(".hooke-00000002~report", 0700), 0);
    close(make(".hooke-00000002~report/old.csv"));
    strays_sweep_path(".");
    assert_true(is_there("report/values.csv") && !is_there(".hooke-00000002~report"));
}

static bool own(const char *name)
{
    return strcmp(name, "part.csv") == 0;
}

static bool write_both(void)
{
    const struct write_policy policy = {.force = true};
    struct error error;
    struct writer writer;
    struct folder folder;
    if (!writer_open(&writer, "file.csv", policy, &error))
        return false;
    writer_put(&writer, TEXT("1\n"));
    if (!writer_commit(&writer, &error) || !folder_open(&folder, "report", policy, own, &error))
        return false;
    if (!folder_put(&folder, "part.csv", TEXT("1\n"), &error)) {
        folder_abandon(&folder);
        return false;
    }
    return folder_commit(&folder, &error);
}

static void sweepers_leave_writers_alone(void **state)
{
    (void)state;
    pid_t sweeper[2];
    for (size_t i = 0; i < COUNT_OF(sweeper); i++) {
        sweeper[i] = fork();
        assert_true(sweeper[i] >= 0);
        while (sweeper[i] == 0)
            strays_sweep_path(".");
    }
    const int64_t begin = clock_ns();
    int failures = 0, tries = 0;
    for (; tries <= 3 || clock_seconds(begin) < (is_long() ? 20 : 0.8); tries++) {
        fault.no_tmpfile = tries % 2;
        fault.no_noreplace = tries / 2 % 2;
        failures += !write_both();
    }
    for (size_t i = 0; i < COUNT_OF(sweeper); i++) {
        kill(sweeper[i], SIGKILL);
        waitpid(sweeper[i], NULL, 0);
    }
    print_message("# %d files and folders written beside two sweepers\n", tries);
    assert_int_equal(failures, 0);
    assert_true(is_there("file.csv") && is_there("report/part.csv"));
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(only_strays_go),
        IN_FOLDER(an_old_folder_comes_back),
        IN_FOLDER(sweepers_leave_writers_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
