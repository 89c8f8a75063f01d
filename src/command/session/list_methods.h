/* SPDX-License-Identifier: GPL-3.0-or-later */
#pragma once

#include <hooke/result.h>

struct cancel;
struct catalog;
struct row;

extern const struct catalog method_kind_catalog; /* stiff, adaptive, ... */

/* Lists the methods that all of the words choose ("stiff adaptive", "order 4"), or all methods if
 * there are no words, as a table, each with its record; `stable` is its limit of omega0 dt. Returns
 * false if a word is unknown, if no method matches, or if it was cancelled. */
bool list_methods(struct text words, const struct cancel *cancel,
                  void (*record)(const struct row *row, double stable, struct reply *reply),
                  struct reply *reply, struct error *error);
