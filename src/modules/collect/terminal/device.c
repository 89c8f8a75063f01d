/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The source of a sensor's lines (serial device, pipe, growing file, standard input): opened for
 * reading only, locked for this program, and restored when closed. */
#include <hooke/base/safe_text.h>
#include "modules/collect/terminal/sensor.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

static const struct {
    long baud;
    speed_t speed;
} speeds[] = {{1200, B1200},     {2400, B2400},     {4800, B4800},     {9600, B9600},
              {19200, B19200},   {38400, B38400},   {57600, B57600},   {115200, B115200},
              {230400, B230400}, {460800, B460800}, {921600, B921600}, {1000000, B1000000}};

/* Finds the speed of termios for a baud rate. Returns false with an error if there is none. */
static bool find_speed(long baud, speed_t *speed, struct error *error)
{
    for (size_t i = 0; i < COUNT_OF(speeds); i++)
        if (speeds[i].baud == baud) {
            *speed = speeds[i].speed;
            return true;
        }
    return error_set(error, ERROR_COMMAND,
                     "baud= must be 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, "
                     "460800, 921600 or 1000000, not %ld",
                     baud);
}

/* Fills `error` with the path and the reason. Returns false. */
static bool device_refuse(const char *path, const char *why, struct error *error)
{
    struct buffer safe = {0};
    safe_text(&safe, text_of(path), false);
    error_set(error, ERROR_IO, "cannot collect from %s: %s", buffer_view(&safe), why);
    buffer_free(&safe);
    return false;
}

/* Adds a hint with the group that may read the device, which is defined by the system. */
static void hint_group(const char *path, struct error *error)
{
    struct stat st;
    const struct group *group = NULL;
    FILE *groups = stat(path, &st) == 0 && st.st_mode & S_IRGRP ? fopen("/etc/group", "re") : NULL;
    while (groups && (group = fgetgrent(groups)) && group->gr_gid != st.st_gid)
        ;
    if (groups)
        fclose(groups);
    if (group)
        error_hint(error,
                   "it belongs to the group '%.40s': 'sudo usermod -aG %.40s $USER', then log in "
                   "again",
                   group->gr_name, group->gr_name);
}

/* Sets a serial line to raw mode and the speed, to be restored when closed or at an abnormal end.
 * Returns false with an error. */
static bool make_raw(struct device *device, const char *path, long baud, struct error *error)
{
    struct termios modes;
    speed_t speed = B0;
    if (!find_speed(baud, &speed, error))
        return false;
    if (tcgetattr(device->fd, &device->old_modes) != 0)
        return device_refuse(path, strerror(errno), error);
    modes = device->old_modes;
    cfmakeraw(&modes);
    cfsetispeed(&modes, speed);
    cfsetospeed(&modes, speed);
    modes.c_cflag |= CLOCAL | CREAD;
    modes.c_cc[VMIN] = 1;
    modes.c_cc[VTIME] = 0;
    crash_line(device->fd, &device->old_modes);
    device->serial = true;
    if (tcsetattr(device->fd, TCSANOW, &modes) != 0)
        return device_refuse(path, strerror(errno), error);
    ioctl(device->fd, TIOCEXCL); /* others cannot open it meanwhile */
    return true;
}

/* Checks the opened source device->fd, locks it against other programs that collect from it and, if
 * it is a terminal, sets raw mode and the speed `baud`. Sets device->grows for regular files, which
 * are followed as they grow. `safe` (option --safe) refuses character devices. Returns false with
 * an error. */
static bool prepare_source(struct device *device, const char *path, long baud, bool safe,
                           struct error *error)
{
    struct stat st;
    if (fstat(device->fd, &st) != 0)
        return device_refuse(path, strerror(errno), error);
    if (S_ISDIR(st.st_mode))
        return device_refuse(path,
                             strcmp(path, STANDARD_INPUT) == 0
                                 ? "standard input is closed, or is a directory"
                                 : "it is a directory",
                             error);
    device->grows = S_ISREG(st.st_mode);
    if (safe && S_ISCHR(st.st_mode))
        return device_refuse(path, "--safe does not allow devices", error);
    if (!device->grows && strcmp(path, STANDARD_INPUT) != 0 && !file_lock(device->fd, false))
        return device_refuse(path, "another program is collecting from it", error);
    return !isatty(device->fd) || make_raw(device, path, baud, error);
}

/* Opens a source; `safe` refuses devices. Returns false with an error, and a hint about
 * permissions. */
bool device_open(struct device *device, const char *path, long baud, bool safe, struct error *error)
{
    *device = (struct device){.fd = -1};
    if (strcmp(path, STANDARD_INPUT) == 0)
        device->fd = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
    else
        device->fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (device->fd < 0) {
        const int number = errno;
        if (number == EBUSY)
            return device_refuse(path, "another program is collecting from it", error);
        device_refuse(path,
                      number == ENXIO ? "it is a socket; socat turns it into a pipe: socat -u "
                                        "UNIX-CONNECT:PATH - | hooke -c 'collect -'"
                                      : strerror(number),
                      error);
        if (number == EACCES)
            hint_group(path, error);
        return false;
    }
    if (prepare_source(device, path, baud, safe, error))
        return true;
    device_close(device);
    return false;
}

/* Restores the modes of a serial line and closes the source. */
void device_close(struct device *device)
{
    if (device->serial) {
        ioctl(device->fd, TIOCNXCL);
        tcsetattr(device->fd, TCSANOW, &device->old_modes);
        crash_line(-1, NULL);
    }
    if (device->fd >= 0)
        close(device->fd);
    *device = (struct device){.fd = -1};
}
