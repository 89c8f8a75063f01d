/* SPDX-License-Identifier: GPL-3.0-or-later */
/* list methods (list_methods.c). */
#pragma once

#include <hooke/result.h>

struct cancel;
struct catalog;
struct row;

extern const struct catalog method_kind_catalog; /* stiff, adaptive, ... */

/* Lists the methods that all of the words choose ("stiff adaptive", "order 4"), or all methods if
 * there are no words: a table, and for each method a call of `record` with its largest stable
 * omega0 dt. Returns false with the error set if a word is unknown, if no method matches, or if it
 * was cancelled. */
bool list_methods(struct text words, const struct cancel *cancel,
                  void (*record)(const struct row *row, double stable, struct reply *reply),
                  struct reply *reply, struct error *error);
