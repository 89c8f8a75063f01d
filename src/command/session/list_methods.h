/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_COMMAND_SESSION_LIST_METHODS_H
#define HOOKE_COMMAND_SESSION_LIST_METHODS_H

#include <hooke/result.h>

struct cancel;
struct catalog;
struct row;

extern const struct catalog method_kind_catalog; /* stiff, adaptive, ... */

/* Those methods that all of the words choose ("stiff adaptive", "order 4"; none: all) as a table,
 * each with its record; stable: its limit of omega0 dt. False: a word is unknown, no method is all
 * of that, or it was cancelled. */
bool list_methods(struct text words, const struct cancel *cancel,
                  void (*record)(const struct row *row, double stable, struct reply *reply),
                  struct reply *reply, struct error *error);

#endif
