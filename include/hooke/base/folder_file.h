/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Files of a folder that are written in parts. */
#pragma once

#include <hooke/base/error.h>

struct folder;
struct writer;

/* Opens a new file of a folder that is being filled; writer_commit() ends it. Returns false with an
 * error if it cannot be made. */
bool folder_file_open(const struct folder *folder, const char *name, struct writer *file,
                      struct error *error);
