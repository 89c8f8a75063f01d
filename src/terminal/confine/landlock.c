/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Lets the kernel enforce --safe (Landlock, Linux 5.13 and later; Salaün 2021). Even if a hostile
 * file takes over this program, it cannot write elsewhere, run programs or use the network. Reading
 * is not restricted. The numbers are those of the kernel, so that the program needs no newer
 * headers than the system has.
 */
#define _GNU_SOURCE /* O_PATH */
#include "terminal/terminal.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

/* Numbers of the system calls, the same for all processors except alpha. */
#ifdef SYS_landlock_create_ruleset
enum {
    CREATE = SYS_landlock_create_ruleset,
    ADD = SYS_landlock_add_rule,
    RESTRICT = SYS_landlock_restrict_self
};
#else
enum { CREATE = 444, ADD, RESTRICT };
#endif

/* Flag that asks for the version, and the kind of rule. */
enum { ASK_VERSION = 1, RULE_PATH_BENEATH = 1 };

/* Rights to use a path, as the kernel numbers them (landlock(7)). */
#define ACCESS_EXECUTE (UINT64_C(1) << 0)
#define WRITE_FILE (UINT64_C(1) << 1)
#define ACCESS_REMOVE (UINT64_C(3) << 4)
#define MAKE_FOLDER (UINT64_C(1) << 7)
#define MAKE_FILE (UINT64_C(1) << 8)
#define MAKE_OTHERS (UINT64_C(0x1e40)) /* devices, sockets, pipes, links */
/* Right to move files to other folders, from version 2 on. */
#define ACCESS_REFER (UINT64_C(1) << 13)
#define ACCESS_TRUNCATE (UINT64_C(1) << 14) /* Right to truncate files, from version 3 on. */
/* Rights to bind and to connect by TCP, from version 4 on. */
#define ACCESS_NETWORK (UINT64_C(3))

/* Argument of the kernel: rights that are denied unless a rule allows them. */
struct ruleset {
    uint64_t files, network;
};

/* Rule of the kernel: rights that are allowed beneath a folder (a descriptor). */
struct beneath {
    uint64_t allowed;
    int32_t folder;
} __attribute__((packed));

/* Returns the version of Landlock that the kernel has, or 0 for none. */
int confine_version(void)
{
    const long version = syscall(CREATE, NULL, (size_t)0, ASK_VERSION);
    return version > 0 ? (int)version : 0;
}

/* Adds a rule to the Landlock rule set `rules` that allows the rights `allowed` beneath a path. A
 * path that cannot be opened because it does not exist or is not accessible needs no rule. Returns
 * false with errno set if the kernel refuses it. */
static bool allow_beneath(int rules, const char *path, uint64_t allowed)
{
    struct beneath beneath = {.allowed = allowed};
    beneath.folder = open(path, O_PATH | O_CLOEXEC);
    if (beneath.folder < 0) /* nothing can be written to a path that does not exist */
        return errno == ENOENT || errno == ENOTDIR || errno == EACCES;
    const bool ok = syscall(ADD, rules, RULE_PATH_BENEATH, &beneath, 0) == 0;
    const int number = errno;
    close(beneath.folder);
    errno = number;
    return ok;
}

/* Allows writing beneath the folders (NULL is skipped) and to /dev/null and the terminal. */
static bool allow_all(int rules, uint64_t writing, const char *const *folder, int folders)
{
    static const char *const devices[] = {"/dev/null", "/dev/tty"};
    bool ok = true;
    for (int i = 0; ok && i < folders; i++)
        ok = !folder[i] || allow_beneath(rules, folder[i], writing);
    for (size_t i = 0; ok && i < COUNT_OF(devices); i++)
        ok = allow_beneath(rules, devices[i], WRITE_FILE);
    return ok;
}

/* Lets the kernel deny writing outside of the folders, running programs and TCP, as far as its
 * version can. Returns false with an error if it cannot. */
bool confine_writing(const char *const *folder, int folders, struct error *error)
{
    const int version = confine_version();
    const uint64_t refer = version >= 2 ? ACCESS_REFER : 0;
    const uint64_t writing = WRITE_FILE | ACCESS_REMOVE | MAKE_FOLDER | MAKE_FILE | refer |
                             (version >= 3 ? ACCESS_TRUNCATE : 0);
    const struct ruleset ruleset = {writing | ACCESS_EXECUTE | MAKE_OTHERS,
                                    version >= 4 ? ACCESS_NETWORK : 0};
    const size_t size = version >= 4 ? sizeof ruleset : sizeof ruleset.files;
    if (version == 0)
        return error_set(error, ERROR_IO, "this kernel has no Landlock");
    const int rules = (int)syscall(CREATE, &ruleset, size, 0);
    const bool ok = rules >= 0 && allow_all(rules, writing, folder, folders) &&
                    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && syscall(RESTRICT, rules, 0) == 0;
    if (!ok)
        error_set(error, ERROR_IO, "Landlock: %s", strerror(errno));
    if (rules >= 0)
        close(rules);
    return ok;
}

/* Appends the line of --version that tells whether the kernel enforces --safe. */
void confine_say(struct buffer *text)
{
    const int version = confine_version();
    if (version > 0)
        buffer_format(text, "--safe is also enforced by the kernel (Landlock %d)\n", version);
    else
        buffer_put(text,
                   TEXT("--safe is enforced only by hooke, because this kernel has no Landlock\n"));
}
