/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Parts that modules add to the terminal. Their files in src/modules/NAME/terminal belong to the
 * terminal layer and not to the library; one of them defines the row NAME_terminal.
 */
#pragma once

#include "terminal/terminal.h"

/* Returned in place of a key that belongs to an answer of the terminal and not to what is typed. */
#define NO_KEY (-2)

/* Keeps the session of the program in a file as it goes. One module does, with all functions. */
struct session_keeper {
    const char *word; /* the option that takes up what was kept; NULL if the module keeps nothing */
    void (*begin)(struct session *session);
    void (*end)(void);
    int64_t (*due)(
        void); /* [clock_ns] time at which keep() has something to do, or INT64_MAX if never */
    /* Writes if that is due. line means that a line was executed, which makes it due unless writing
     * takes long. Returns false with an error to report. */
    bool (*keep)(bool line, struct error *error);
    bool (*write)(struct error *error); /* the same at once, whatever is due */
    bool (*is_name)(const char *word);  /* tells names of what was kept from names of files */
    /* Replaces the session by a stored one, the newest if name is NULL. messages receives a
     * description of what was done. Returns false with the session unchanged. */
    bool (*resume)(struct session **session, const char *name, struct buffer *messages,
                   struct error *error);
};

/* Each function may be NULL. */
struct terminal_part {
    struct session_keeper keeper;
    /* Sets the callbacks of a new front end that the module serves. */
    void (*offer)(struct front *front, struct streams *streams);
    /* Looks at a key before readline does. Returns it, another one, or NO_KEY. */
    int (*key)(int key);
    struct module_option option;
};

/* The parts of the modules of this build, then NULL. */
extern const struct terminal_part *const terminal_parts[];

void terminal_offer(struct front *front, struct streams *streams);
int terminal_key(int key);
/* Returns NULL if no module keeps sessions. */
const struct session_keeper *session_keeper(void);
int64_t keeper_due(void);
/* Returns true where nothing keeps the session. */
bool keeper_keep(bool line, struct error *error);
