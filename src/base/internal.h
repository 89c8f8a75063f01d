/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the files of base share for writing files and folders (append.c, folder.c,
 * writer.c, strays.c). */
#pragma once

#include <hooke/base/file.h>

#include <sys/types.h>

/* ---- writing: shared by files and folders ---- */

#define WRITER_CHUNK ((size_t)65536) /* [byte] of the write-behind buffer */
#define NAME_ATTEMPTS 100            /* attempts to find a temporary name that nobody has taken */

/* The reason for writer_refuse() while nothing may be written at all. */
#define WRITER_REFUSED "nothing may be written while a hand-in is checked"
/* Set the error that the writer's path cannot be written: for a reason, or because it exists.
 * Return false. */
bool writer_refuse(const struct writer *writer, struct error *error, const char *why);
bool writer_refuse_existing(const struct writer *writer, struct error *error);
/* Opens the folder of writer->path, and sets writer->base to the last component. With confine, the
 * folder has to be the current one or below it. Returns false with the error set. */
bool writer_open_folder(struct writer *writer, bool confine, struct error *error);
/* Returns true if the name is free, or is a regular file that force may replace. Sets *mode to its
 * permissions, or to 0 for a new file. Returns false with the error set. */
bool writer_allows(const struct writer *writer, mode_t *mode, struct error *error);
int file_synced(int fd); /* waits until the file is on the disk; returns 0 or an errno */

/* ---- hidden names beside the target (strays.c) ---- */

/* Locks the opened file. Returns true if this program now holds the lock and the file still has
 * that name in the folder. */
bool stray_is_held(int folder, const char *name, int fd);
/* Removes files and folders that killed programs left in a folder under hidden names. */
void strays_sweep(int folder);
/* Removes regular files for whose names own returns true. */
void folder_empty(int fd, folder_owns *own);
