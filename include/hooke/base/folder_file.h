/* SPDX-License-Identifier: GPL-3.0-or-later */
/* folder_file: writes a file of a new folder (struct folder of <hooke/base/file.h>) piece by piece.
 */
#pragma once

#include <hooke/base/error.h>

struct folder;
struct writer;

/* Opens the file `name`, which must be new, in a folder that folder_open() has opened, and
 * sets *file to its writer. Append with writer_put(), and end with writer_commit() before
 * folder_commit(). Returns false with `error` set if the file cannot be created or if out of
 * memory. */
bool folder_file_open(const struct folder *folder, const char *name, struct writer *file,
                      struct error *error);
