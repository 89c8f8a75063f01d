/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The folders that the tests of a terminal give the program: gone when the test program has ended.
 */
#pragma once

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FOLDERS_MAX 32

static struct {
    pid_t owner; /* not the programs it starts */
    char path[FOLDERS_MAX][64];
    int count;
} test_folders;

static inline int remove_entry(const char *path, const struct stat *status, int kind,
                               struct FTW *where)
{
    (void)status;
    (void)kind;
    (void)where;
    return remove(path);
}

static inline void remove_folders(void)
{
    while (getpid() == test_folders.owner && test_folders.count > 0) {
        nftw(test_folders.path[--test_folders.count], remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    }
}

/* mkdtemp(), to be removed at the end. */
static inline char *make_folder(char *template)
{
    if (test_folders.owner == 0) {
        test_folders.owner = getpid();
        atexit(remove_folders);
    }
    if (test_folders.count == FOLDERS_MAX || strlen(template) >= sizeof test_folders.path[0] ||
        !mkdtemp(template)) {
        return NULL;
    }
    snprintf(test_folders.path[test_folders.count++], sizeof test_folders.path[0], "%s", template);
    return template;
}
