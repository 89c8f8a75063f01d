/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Files that grow by whole lines: while each of the system calls fails or is cut short, beside
 * other programs that add to them, and where something else stands in their place.
 */
#include "cmocka_testing.h"

#include "faults/failing_calls.h"
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>

#include <stdlib.h>
#include <sys/wait.h>

#define BEFORE "k = 1 N/m\n"
#define LINES "m = 200 g\nrun 10 s\n"

static int enter_folder(void **state)
{
    char *folder = strdup("/tmp/hooke-append-XXXXXX");
    *state = folder;
    return folder && mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state)
{
    fault.kind = FAULT_NONE;
    fault.torn = false;
    unlink("lines");
    rmdir("inside");
    const int result = chdir("/") == 0 ? rmdir(*state) : -1;
    free(*state);
    return result;
}

static void make(const char *text)
{
    const int fd = open("lines", O_WRONLY | O_CREAT | O_TRUNC, 0600);
    assert_true(fd >= 0 && write(fd, text, strlen(text)) == (ssize_t)strlen(text));
    close(fd);
}

static void expect(const char *text)
{
    struct buffer content = {0};
    struct error error;
    assert_true(file_read("lines", 1u << 20, &content, &error));
    assert_string_equal(content.data, text);
    buffer_free(&content);
}

static bool add(struct error *error)
{
    const int fd = append_open("lines", (struct write_policy){.confine = true}, 0600, error);
    if (fd < 0)
        return false;
    file_lock(fd, false);
    const bool done = append_lines(fd, TEXT(LINES), true, error);
    close(fd);
    return done;
}

static int strike_all(enum fault_kind kind, int number)
{
    int failures = 0;
    for (int at = 0;; at++) {
        struct error error = {0};
        fault.kind = FAULT_NONE;
        make(BEFORE);
        fault.at = at;
        fault.number = number;
        fault.calls = 0;
        fault.torn = false;
        fault.struck = "";
        fault.kind = kind;
        const bool done = add(&error), over = fault.calls <= at;
        const bool close_failed = strcmp(fault.struck, "close") == 0;
        fault.kind = FAULT_NONE;
        fault.torn = false;
        failures += !done;
        if (!done && (error.code != ERROR_IO || !error.text[0]))
            fail_msg("call %d: nothing is said", at);
        if (!close_failed)
            expect(done ? BEFORE LINES : BEFORE);
        if (over) {
            assert_true(done && at >= 6); /* or the faults do not reach it */
            return failures;
        }
    }
}

static void lines_stay_whole(void **state)
{
    (void)state;
    static const int numbers[] = {ENOSPC, EIO, EDQUOT, EFBIG};
    for (size_t i = 0; i < COUNT_OF(numbers); i++) {
        assert_true(strike_all(FAULT_ERRNO, numbers[i]) >= 3);
        assert_int_equal(strike_all(FAULT_TORN, numbers[i]), 1);
    }
    assert_int_equal(strike_all(FAULT_SHORT, 0), 0);
}

/* A signal between: the calls that it interrupts are made again. */
static void signals_pass(void **state)
{
    (void)state;
    struct error error;
    make(BEFORE);
    const int fd = append_open("lines", (struct write_policy){.force = false}, 0600, &error);
    assert_true(fd >= 0);
    for (int at = 0; at < 2; at++) { /* write, fsync */
        fault.at = at;
        fault.number = EINTR;
        fault.calls = 0;
        fault.kind = FAULT_ERRNO;
        assert_true(append_lines(fd, TEXT(LINES), true, &error));
        fault.kind = FAULT_NONE;
    }
    expect(BEFORE LINES LINES);
    close(fd);
}

static void half_a_line_is_ended(void **state)
{
    (void)state;
    struct error error;
    make("m = 2");
    assert_true(add(&error));
    expect("m = 2\n" LINES);
}

/* What another program has added meanwhile is never cut off with what this one could not. */
static void others_keep_theirs(void **state)
{
    (void)state;
    struct error error;
    make(BEFORE);
    const int fd = append_open("lines", (struct write_policy){.force = false}, 0600, &error);
    const int other = append_open("lines", (struct write_policy){.force = false}, 0600, &error);
    assert_true(fd >= 0 && other >= 0);
    assert_true(file_lock(fd, false));
    assert_false(file_lock(other, false));
    const int64_t begin = clock_ns();
    assert_false(file_lock(other, true));
    assert_true(clock_seconds(begin) > 0.1 && clock_seconds(begin) < 30);
    file_unlock(fd);
    assert_true(file_lock(other, true));
    fault.at = fault.calls = 0;
    fault.number = ENOSPC;
    fault.kind = FAULT_ERRNO;
    assert_false(append_lines(fd, TEXT(LINES), true, &error));
    fault.kind = FAULT_NONE;
    assert_true(append_lines(other, TEXT("g = 0\n"), true, &error));
    expect(BEFORE "g = 0\n");
    close(fd);
    close(other);
}

static void refused(const char *path, struct write_policy policy, const char *why)
{
    struct error error = {0};
    assert_int_equal(append_open(path, policy, 0600, &error), -1);
    assert_int_equal(error.code, ERROR_IO);
    if (!strstr(error.text, why))
        fail_msg("'%s' is not in '%s'", why, error.text);
}

static void only_files(void **state)
{
    (void)state;
    const struct write_policy plain = {.force = false}, safe = {.confine = true};
    assert_int_equal(mkfifo("lines", 0600), 0);
    refused("lines", plain, "named pipe");
    unlink("lines");
    assert_int_equal(symlink("/tmp/elsewhere", "lines"), 0);
    refused("lines", plain, "symbolic link");
    unlink("lines");
    assert_int_equal(mkdir("inside", 0700), 0);
    refused("inside", plain, "directory");
    refused("../outside", safe, "outside the current directory");
    refused("/dev/null", plain, "device");
    refused("no/such", plain, "No such file");
    refused("lines", (struct write_policy){.refuse = true}, "checked");
    assert_int_equal(access("lines", F_OK), -1);
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(lines_stay_whole),   IN_FOLDER(signals_pass), IN_FOLDER(half_a_line_is_ended),
        IN_FOLDER(others_keep_theirs), IN_FOLDER(only_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
