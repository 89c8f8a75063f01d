/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Removes files and folders that killed programs left behind under hidden names, which share a
 * prefix. Each is locked while a program writes it, so one that can be locked has no owner; a
 * process number would be meaningless after a reboot or in a container. If the file system has no
 * locks, nothing is removed.
 */
#define _GNU_SOURCE /* F_OFD_GETLK, renameat2 */
#include "base/internal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

/* A hidden name is this prefix, random hex digits, a mark and the base name. */
#define STRAY_PREFIX ".hooke-"
#define PREFIX_LEN (sizeof STRAY_PREFIX - 1)
#define STRAY_HEX_DIGITS 8
/* Index of the mark in a name; the base name follows it. */
#define STRAY_MARK_INDEX (PREFIX_LEN + STRAY_HEX_DIGITS)

/* Makes a hidden name from random digits, the mark and base. Returns false if the system has no
 * random numbers. */
bool stray_name(char name[STRAY_NAME_SIZE], const char *base, char mark)
{
    uint32_t random;
    if (getrandom(&random, sizeof random, 0) != (ssize_t)sizeof random)
        return false;
    snprintf(name, STRAY_NAME_SIZE, STRAY_PREFIX "%08x%c%.*s", random, mark,
             (int)(STRAY_NAME_SIZE - STRAY_MARK_INDEX - 2), base);
    return true;
}

/* Returns true for names that stray_name() makes. */
static bool is_hidden_name(const char *name)
{
    return strncmp(name, STRAY_PREFIX, PREFIX_LEN) == 0 &&
           strspn(name + PREFIX_LEN, "0123456789abcdef") == STRAY_HEX_DIGITS &&
           (name[STRAY_MARK_INDEX] == STRAY_NEW || name[STRAY_MARK_INDEX] == STRAY_OLD) &&
           name[STRAY_MARK_INDEX + 1] != '\0';
}

/* Results of name_status(). */
enum { NAME_LOST, NAME_KEPT, NAME_UNKNOWN };

/* Tells if the open file still has that name in the folder, or has lost it to another file or none;
 * NAME_UNKNOWN if the system does not tell. */
static int name_status(int folder, const char *name, int fd)
{
    struct stat opened, named;
    if (fstat(fd, &opened) != 0)
        return NAME_UNKNOWN;
    if (fstatat(folder, name, &named, AT_SYMLINK_NOFOLLOW) != 0)
        return errno == ENOENT ? NAME_LOST : NAME_UNKNOWN;
    return opened.st_dev == named.st_dev && opened.st_ino == named.st_ino ? NAME_KEPT : NAME_LOST;
}

/* Locks the file and checks that it still has its name; another program may be removing it. */
bool stray_is_held(int folder, const char *name, int fd)
{
    if (!file_lock(fd, false) && errno == EWOULDBLOCK) /* it is being removed */
        return false;
    return name_status(folder, name, fd) != NAME_LOST;
}

/* Returns true if nobody writes the file: this program could lock it, it still has its name, and no
 * other process holds a record lock. */
static bool is_abandoned(int folder, const char *name, int fd)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    return file_lock(fd, false) && name_status(folder, name, fd) == NAME_KEPT &&
           (fcntl(fd, F_OFD_GETLK, &lock) != 0 || lock.l_type == F_UNLCK);
}

/* Accepts every name, for folder_empty(). */
static bool accept_any_name(const char *name)
{
    (void)name;
    return true;
}

/* Removes one hidden file or folder of this user that nobody writes. An old folder that a killed
 * program had moved aside gets its name back if that is free. */
static void sweep_stray(int folder, const char *name)
{
    struct stat st;
    if (fstatat(folder, name, &st, AT_SYMLINK_NOFOLLOW) != 0 || st.st_uid != geteuid() ||
        !(S_ISREG(st.st_mode) || S_ISDIR(st.st_mode)))
        return;
    const bool is_folder = S_ISDIR(st.st_mode);
    const int fd =
        openat(folder, name,
               (is_folder ? O_RDONLY | O_DIRECTORY : O_RDWR | O_NONBLOCK) | O_NOFOLLOW | O_CLOEXEC);
    if (fd < 0)
        return;
    if (is_abandoned(folder, name, fd)) {
        /* an old folder whose replacement never got its name is restored */
        const bool restored =
            is_folder && name[STRAY_MARK_INDEX] == STRAY_OLD &&
            fstatat(folder, name + STRAY_MARK_INDEX + 1, &st, AT_SYMLINK_NOFOLLOW) != 0 &&
            renameat(folder, name, folder, name + STRAY_MARK_INDEX + 1) == 0;
        if (is_folder && !restored)
            folder_empty(fd, accept_any_name);
        if (!restored)
            unlinkat(folder, name, is_folder ? AT_REMOVEDIR : 0);
    }
    close(fd);
}

/* Removes abandoned hidden files of the folder. */
void strays_sweep(int folder)
{
    const int list_fd = openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *list = list_fd < 0 ? NULL : fdopendir(list_fd);
    for (struct dirent *entry; list && (entry = readdir(list));)
        if (is_hidden_name(entry->d_name))
            sweep_stray(folder, entry->d_name);
    if (list)
        closedir(list);
    else if (list_fd >= 0)
        close(list_fd);
}

void strays_sweep_path(const char *path)
{
    const int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        strays_sweep(folder);
        close(folder);
    }
}
