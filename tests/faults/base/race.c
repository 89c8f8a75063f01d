/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * --safe while somebody exchanges a folder for a link to one outside, as fast as that goes: what is
 * looked at is what is written to, so that nothing lands outside.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include <hooke/base/cancel.h>
#include <hooke/base/file.h>

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define RACES (is_long() ? 60000 : 4000) /* of each kind */

static const struct write_policy safe = {.force = true, .confine = true};

static bool own(const char *name)
{
    return strcmp(name, "part.csv") == 0;
}

static bool write_file(void)
{
    struct writer writer;
    struct error error;
    if (!writer_open(&writer, "where/file.csv", safe, &error))
        return false;
    writer_put(&writer, TEXT("1\n"));
    return writer_commit(&writer, &error);
}

static bool write_lines(void)
{
    struct error error;
    const int fd = append_open("where/lines.hk", safe, 0600, &error);
    const bool done = fd >= 0 && append_lines(fd, TEXT("m = 1\n"), false, &error);
    if (fd >= 0)
        close(fd);
    return done;
}

static bool write_folder(void)
{
    struct folder folder;
    struct error error;
    if (!folder_open(&folder, "where/report", safe, own, &error))
        return false;
    return folder_put(&folder, "part.csv", TEXT("1\n"), &error) ? folder_commit(&folder, &error)
                                                                : (folder_abandon(&folder), false);
}

/* How many names there are in a folder. */
static int count(const char *path)
{
    int names = -2;
    DIR *list = opendir(path);
    assert_non_null(list);
    while (readdir(list))
        names++;
    closedir(list);
    return names;
}

static pid_t exchange_for_ever(void)
{
    const pid_t child = fork();
    assert_true(child >= 0);
    while (child == 0)
        renameat2(AT_FDCWD, "where", AT_FDCWD, "link", RENAME_EXCHANGE);
    return child;
}

/* At least so many, and until both ends were seen: where both share a core, they take turns. */
static void race(bool (*act)(void), int races, const char *what)
{
    const pid_t child = exchange_for_ever();
    const int64_t begin = clock_ns();
    int inside = 0, tried = 0;
    while (tried < races || ((inside < 20 || tried - inside < 20) && clock_seconds(begin) < 20)) {
        inside += act();
        tried++;
    }
    const int landed = count("../outside");
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    print_message("# %s: %d races, %d written inside, %d names outside\n", what, tried, inside,
                  landed);
    assert_int_equal(landed, 0);
    assert_true(inside >= 20 && tried - inside >= 20);
}

TEST(nothing_lands_outside)
{
    char folder[] = "/tmp/hooke-race-XXXXXX", command[64];
    assert_non_null(mkdtemp(folder));
    assert_int_equal(chdir(folder), 0);
    assert_true(mkdir("outside", 0700) == 0 && mkdir("here", 0700) == 0 && chdir("here") == 0);
    assert_true(mkdir("where", 0700) == 0 && symlink("../outside", "link") == 0);
    if (renameat2(AT_FDCWD, "where", AT_FDCWD, "link", RENAME_EXCHANGE) == 0) {
        race(write_lines, RACES, "record");
        race(write_file, RACES, "export");
        race(write_folder, RACES / 4, "report");
    } else {
        print_message("# names cannot be exchanged here\n");
        assert_int_equal(chdir("/"), 0);
        skip();
    }
    snprintf(command, sizeof command, "rm -rf %s", folder);
    assert_int_equal(chdir("/"), 0);
    assert_int_equal(system(command), 0);
}

RUN_TESTS(NULL, NULL)
