/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Include once in a test program: these definitions of the system calls that write files stand
 * before those of libc, and the call number fault.at fails with fault.number, is cut short, or is
 * the last one the process makes.
 */
#pragma once

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

enum fault_kind {
    FAULT_NONE,
    FAULT_ERRNO,
    FAULT_SHORT,
    FAULT_TORN, /* half a write, and every later one fails */
    FAULT_KILL_BEFORE,
    FAULT_KILL_AFTER
};

static struct {
    enum fault_kind kind;
    int at, calls, number;
    const char *struck; /* name of the call that failed */
    bool no_tmpfile, no_noreplace, torn;
    bool dry; /* nothing is put on the disk: thousands of files would take long */
} fault;

static bool strikes(const char *name)
{
    if (fault.kind == FAULT_NONE || fault.calls++ != fault.at)
        return false;
    fault.struck = name;
    if (fault.kind == FAULT_KILL_BEFORE)
        raise(SIGKILL);
    errno = fault.number;
    return fault.kind == FAULT_ERRNO;
}

static void afterwards(void)
{
    if (fault.kind == FAULT_KILL_AFTER && fault.calls == fault.at + 1)
        raise(SIGKILL);
}

static void find_real(void *function, const char *name)
{
    void *symbol = dlsym(RTLD_NEXT, name);
    memcpy(function, &symbol, sizeof symbol);
}

#define INTERPOSE(type, name, parameters, arguments)                                               \
    type name parameters                                                                           \
    {                                                                                              \
        static type(*real) parameters;                                                             \
        if (!real)                                                                                 \
            find_real(&real, #name);                                                               \
        if (strikes(#name))                                                                        \
            return (type)-1;                                                                       \
        type result = real arguments;                                                              \
        afterwards();                                                                              \
        return result;                                                                             \
    }

INTERPOSE(int, ftruncate, (int fd, off_t size), (fd, size))
INTERPOSE(int, flock, (int fd, int operation), (fd, operation))
INTERPOSE(int, dup, (int fd), (fd))
INTERPOSE(int, close, (int fd), (fd))
INTERPOSE(int, access, (const char *path, int mode), (path, mode))
INTERPOSE(int, fchmod, (int fd, mode_t mode), (fd, mode))
INTERPOSE(int, unlinkat, (int folder, const char *path, int flags), (folder, path, flags))
INTERPOSE(int, mkdirat, (int folder, const char *path, mode_t mode), (folder, path, mode))
INTERPOSE(int, linkat, (int a, const char *from, int b, const char *to, int flags),
          (a, from, b, to, flags))
INTERPOSE(ssize_t, getrandom, (void *bytes, size_t count, unsigned flags), (bytes, count, flags))
INTERPOSE(int, fstatat,
          (int folder, const char *restrict path, struct stat *restrict st, int flags),
          (folder, path, st, flags))

static int sync_with(int (**real)(int), const char *name, int fd)
{
    if (!*real)
        find_real(real, name);
    if (strikes(name))
        return -1;
    const int result = fault.dry ? 0 : (*real)(fd);
    afterwards();
    return result;
}

int fsync(int fd)
{
    static int (*real)(int);
    return sync_with(&real, "fsync", fd);
}

int fdatasync(int fd)
{
    static int (*real)(int);
    return sync_with(&real, "fdatasync", fd);
}

ssize_t write(int fd, const void *bytes, size_t count)
{
    static ssize_t (*real)(int, const void *, size_t);
    if (!real)
        find_real(&real, "write");
    if (strikes("write"))
        return -1;
    if (fault.torn) {
        errno = fault.number;
        return -1;
    }
    const bool here = fault.calls == fault.at + 1 && count > 1;
    const bool cut = here && (fault.kind == FAULT_SHORT || fault.kind == FAULT_TORN);
    fault.torn = cut && fault.kind == FAULT_TORN;
    const ssize_t result = real(fd, bytes, cut ? count / 2 : count);
    afterwards();
    return result;
}

int renameat2(int a, const char *from, int b, const char *to, unsigned flags)
{
    static int (*real)(int, const char *, int, const char *, unsigned);
    if (!real)
        find_real(&real, "renameat2");
    if (strikes("renameat2"))
        return -1;
    const bool unknown = fault.no_noreplace && flags != 0;
    const int result = unknown ? -1 : real(a, from, b, to, flags);
    if (unknown)
        errno = EINVAL;
    afterwards();
    return result;
}

int openat(int folder, const char *path, int flags, ...)
{
    static int (*real)(int, const char *, int, ...);
    va_list args;
    va_start(args, flags);
    const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(args, mode_t) : 0;
    va_end(args);
    if (!real)
        find_real(&real, "openat");
    if (strikes("openat"))
        return -1;
    const bool unknown = fault.no_tmpfile && (flags & O_TMPFILE) == O_TMPFILE;
    const int result = unknown ? -1 : real(folder, path, flags, mode);
    if (unknown)
        errno = EOPNOTSUPP;
    afterwards();
    return result;
}
