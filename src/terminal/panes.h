/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by the files of the panes front end. */
#pragma once

#include "terminal/terminal.h"

#include <stdio.h>

/* ---- what the terminal sends (input.c)
 * ------------------------------------------------------------------------------------- Bytes wait
 * here undecoded. Two things are taken out before readline sees them: pastes, and the reply to our
 * question.
 */

#define REPLY_TEXT "\033[0n"
/* time for which the possible beginning of such a sequence is held back */
#define HELD_NS 100000000

struct input {
    struct buffer bytes;
    size_t head;     /* [byte] taken already */
    int64_t arrived; /* [clock_ns] the last of them */
    bool closed;     /* the terminal is gone */
};

enum input_item { INPUT_NONE, INPUT_BYTE, INPUT_PASTE, INPUT_REPLY };

/* Reads the available bytes. gone means that poll() has reported that the terminal has hung up. */
void input_read(struct input *input, bool gone);
/* The next item; of a paste, `paste` points at its text until the next call. */
enum input_item input_next(struct input *input, int64_t now, unsigned char *byte,
                           struct text *paste);
/* Returns the time [clock_ns] at which something held back becomes a byte, or INT64_MAX if nothing
 * is held. */
int64_t input_due(const struct input *input);
bool input_pending(const struct input *input);
/* Takes the reply out from wherever it stands; the other bytes stay. */
bool input_strip_reply(struct input *input);
void input_clear(struct input *input);
void input_free(struct input *input);

/* ---- how often it is drawn (pacing.c)
 * ----------------------------------------------------------------------------------------- After
 * an animated frame the terminal is asked ESC[5n; the next one waits for its answer. So a slow link
 * never has more than one frame under way, and what is typed is seen at once.
 */

enum shown { SHOWN_NOTHING, SHOWN_PART, SHOWN_ALL };

struct pacing {
    int64_t next;      /* [clock_ns] earliest time of the next animated frame */
    int64_t requested; /* [clock_ns] 0: no question is open */
    int64_t delay;     /* [ns] between the last question and its answer */
    int missing;       /* questions without an answer, in a row */
};

/* The link counts as slow until it has answered for the first time. */
#define PACING_BEGIN                                                                               \
    {                                                                                              \
        .delay = INT64_MAX                                                                         \
    }

/* Earliest time of the next animated frame [clock_ns]. */
int64_t pacing_due(const struct pacing *pacing, const struct session *session);
/* [byte] one frame may send: over a slow link few, so that what is typed never waits for long. */
int pacing_bytes(const struct pacing *pacing);
/* A frame, or a part of one, has been drawn. Asks, where that is wanted, unless nothing had to be
 * sent. */
void pacing_drawn(struct pacing *pacing, const struct session *session, int64_t now,
                  enum shown shown);
void pacing_replied(struct pacing *pacing, int64_t now);

/* ---- the terminal under ncurses (screen.c) ---- */

struct terminal_screen {
    void *handle; /* SCREEN of ncurses, or NULL if not shown */
    bool color_wanted;
    bool color_begun;
    bool utf8;
    int width, height;    /* [cell] */
    struct canvas canvas; /* canvas of that size */
    struct canvas shown;  /* present contents of the terminal */
    int next;             /* row to go on with after a part */
    bool stale;           /* the terminal may show something else */
};

/* A string that terminfo knows under this name, also an extended one; "" if there is none. */
const char *screen_capability(const char *name);
bool screen_begin(struct terminal_screen *screen);
void screen_end(struct terminal_screen *screen);
/* Gives the terminal back for a while, and takes it again. */
void screen_leave(struct terminal_screen *screen);
void screen_return(struct terminal_screen *screen);
void screen_color(struct terminal_screen *screen, bool wanted);
/* Takes the terminal back from somebody who had it while the program was stopped. */
void screen_retake(struct terminal_screen *screen);
/* The next screen_show sends everything. */
void screen_repaint(struct terminal_screen *screen);
/* Reads the size from the terminal and adapts to it. */
void screen_resize(struct terminal_screen *screen);
/* Sends what differs from `shown`, from row `first_row` on, at most about so many bytes: the rest
 * comes with the next call.
 */
enum shown screen_show(struct terminal_screen *screen, int first_row, int bytes, int cursor_x,
                       int cursor_y);

/* ---- the front end ---- */

enum line_from {
    LINE_TYPED,
    LINE_KEY,    /* the same for the session, but it was not entered */
    LINE_SILENT, /* looks at the screen only: neither shown in the log nor remembered */
};

struct panes {
    struct front_program *program;
    struct input input;
    struct pacing pacing;
    struct terminal_screen screen;
    bool color;         /* the terminal shows colours, and NO_COLOR is not set */
    struct buffer line; /* a complete line that waits to be executed */
    enum line_from line_from;
    bool line_waits;
    struct buffer aside; /* text that was half typed when a page came to be read */
    int aside_point;     /* [byte] of the cursor in it */
    /* message on what a key could not do, shown instead of the numbers until the next line */
    struct buffer notice;
    bool echo_stale;   /* the prompt has changed */
    bool screen_stale; /* more than that has */
    bool interrupted;  /* Ctrl-C while a run goes on */
    bool running;      /* true inside front.slice, while a run is in progress */
};

#define PANES_PROMPT "hooke> "

static inline struct session *panes_session(const struct panes *panes)
{
    return panes->program->session;
}

bool panes_over(const struct panes *panes);
/* Draws, waits for something to happen, at most until then [clock_ns], and reads what there is or
 * saves. */
void panes_wait(struct panes *panes, int64_t deadline);
/* The same without drawing or saving. Returns true if something was typed. */
bool panes_read(struct panes *panes, int64_t deadline);
void panes_save(struct panes *panes, bool line);
/* Everything that has been typed: keys to readline, complete lines to the session, one after the
 * other. */
void panes_process(struct panes *panes);
/* A command line to be executed as soon as readline has returned. */
void panes_enqueue(struct panes *panes, struct text line, enum line_from origin);
/* The lowest row as it is now; `scratch` holds a text it may need. */
void panes_prompt(const struct panes *panes, struct prompt_line *prompt, struct buffer *scratch);
/* Shows the panes, in at most about `bytes` bytes. With only_prompt it draws the row of the prompt
 * alone, so that an echo costs little on a slow link. */
enum shown panes_show(struct panes *panes, bool only_prompt, int bytes);
/* Everything is sent again, whatever the terminal shows. */
void panes_repaint(struct panes *panes);

/* ---- readline (edit.c) ---- */

/* The panes in use, because readline's callbacks have no context. NULL if there are none. */
extern struct panes *panes_active;

/* Begins to edit, with the output of readline discarded. Returns false if it has no thread for
 * that. */
bool edit_begin(FILE *nowhere);
void edit_end(void);
void edit_key(struct panes *panes, unsigned char byte); /* a typed key, for readline */
/* Enqueues the lines that a key has ended, while none waits to be executed; keys are taken only
 * where there are no more. Returns true if there was one. */
bool edit_take_line(struct panes *panes);
/* Whatever is being edited: gone, with every state readline may be in. */
void edit_clear(struct panes *panes);
/* Puts half typed text aside while a page is read. It comes back with the panes. */
void edit_put_aside(struct panes *panes);
/* A paste goes into the line as it is and waits for Enter; in the middle of a search it means
 * nothing. */
void edit_paste(struct panes *panes, struct text paste);

/* ---- what is longer than the log (reading.c) ---- */

/* Describes the position of the page, or the notice, and the keys. */
void reading_prompt(const struct session *session, struct text notice, struct buffer *text);
/* The command that shows what was said since on the whole screen; none where the log can, or where
 * more was typed already. */
void reading_command(const struct panes *panes, uint64_t said_before, struct buffer *line);
/* The line at the top of the page, counted from the newest: what a new size is to begin with. */
int reading_line(const struct session *session);

/* ---- what the session asks for (watch.c) ---- */

void watch_offer(struct panes *panes, struct front *front);

/* ---- keys (keys.c) ---- */

/* Binds them in every keymap of readline; the inputrc, read afterwards, may bind them differently.
 */
void keys_bind(void);
/* Chooses the keymap: that of the cursors while they stand on the plot. */
void keys_choose(const struct session *session);
bool keys_on_plot(void); /* they act on the cursors now */
bool keys_on_text(void); /* they scroll what is read on the whole screen */

#define READING_FIND "scroll find " /* a line that begins so is none of the session's */
