/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared between the files of base only. */
#pragma once

#include <hooke/base/file.h>

#include <sys/types.h>

/* ---- writing: shared by files and folders ---- */

#define WRITER_CHUNK ((size_t)65536) /* [byte] of the write-behind buffer */
#define NAME_ATTEMPTS 100            /* attempts to find a temporary name that nobody has taken */

/* false, always */
#define WRITER_REFUSED "nothing may be written while a hand-in is checked"
bool writer_refuse(const struct writer *writer, struct error *error, const char *why);
bool writer_refuse_existing(const struct writer *writer, struct error *error);
/* Opens the folder of writer->path and points at the last component. With confine, the folder has
 * to be below the current one. */
bool writer_open_folder(struct writer *writer, bool confine, struct error *error);
/* Returns true if the name is free, or is a regular file that force may replace. Sets *mode to its
 * permissions, or to 0 for a new file. */
bool writer_allows(const struct writer *writer, mode_t *mode, struct error *error);
int file_synced(int fd); /* 0 or an errno */

/* ---- hidden names beside the target (strays.c) ---- */

/* Returns true if the opened file is locked, and still has that name. */
bool stray_is_held(int folder, const char *name, int fd);
/* Removes what killed programs left in a folder. */
void strays_sweep(int folder);
/* Regular files whose names are `own` go. */
void folder_empty(int fd, folder_owns *own);
