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
    const char *word; /* option that resumes a session, or NULL if the module keeps nothing */
    /* Begin and end to keep the session in a file. */
    void (*begin)(struct session *session);
    void (*end)(void);
    int64_t (*due)(
        void); /* [clock_ns] time at which keep() has something to do, or INT64_MAX if never */
    /* Writes if that is due. line means that a line was executed, which makes it due unless writing
     * takes long. Returns false with an error to report. */
    bool (*keep)(bool line, struct error *error);
    bool (*write)(struct error *error); /* writes at once, whether or not it is due */
    /* returns true for names of stored sessions, false for names of files */
    bool (*is_name)(const char *word);
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

/* Lets each part set callbacks of a new front end. */
void terminal_offer(struct front *front, struct streams *streams);
/* Lets each part look at a key. Returns the key for readline, or NO_KEY if a part has taken it. */
int terminal_key(int key);
/* Returns NULL if no module keeps sessions. */
const struct session_keeper *session_keeper(void);
/* Returns the time [clock_ns] at which the session should be saved, or INT64_MAX. */
int64_t keeper_due(void);
/* Saves the session if that is due; `line` tells that a line was executed. Returns false with an
 * error to report; true if no module keeps sessions. */
bool keeper_keep(bool line, struct error *error);
