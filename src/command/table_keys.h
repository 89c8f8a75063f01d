/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the numbers of a table were made with: its `# key = value` lines. */
#ifndef HOOKE_COMMAND_TABLE_KEYS_H
#define HOOKE_COMMAND_TABLE_KEYS_H

#include "export.h"

struct keys {
    struct arena *arena;
    struct table_key *key;
    int count;
    bool failed;
};

bool keys_begin(struct keys *keys, struct export *export, struct error *error);
void keys_add(struct keys *keys, const char *name, struct buffer *value); /* frees the value */
void keys_add_text(struct keys *keys, const char *name, const char *text);
void keys_add_scene(struct keys *keys, const struct scene *scene);
void keys_add_runs(struct keys *keys, const struct session *session, const int *place, int count);
/* The table has them. */
bool keys_finish(const struct keys *keys, struct export *export, struct error *error);

#endif
