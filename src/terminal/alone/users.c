/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lists users for readline's ~NAME from /etc/passwd alone, in the static program: the C library's
 * own functions would load libraries of the system that it was linked on. */
#include <pwd.h>
#include <stdio.h>
#include <string.h>

static FILE *users;

void endpwent(void)
{
    if (users)
        fclose(users);
    users = NULL;
}

void setpwent(void)
{
    endpwent();
    users = fopen("/etc/passwd", "re");
}

struct passwd *getpwent(void)
{
    if (!users)
        setpwent();
    return users ? fgetpwent(users) : NULL;
}

/* Returns the user of this name, or NULL. */
struct passwd *getpwnam(const char *name)
{
    struct passwd *user;
    setpwent();
    while ((user = getpwent()) && strcmp(user->pw_name, name) != 0)
        ;
    endpwent();
    return user;
}

/* Returns the user of this number, or NULL. */
struct passwd *getpwuid(uid_t uid)
{
    struct passwd *user;
    setpwent();
    while ((user = getpwent()) && user->pw_uid != uid)
        ;
    endpwent();
    return user;
}
