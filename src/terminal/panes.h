/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by the files of the panes front end. */
#pragma once

#include "terminal/terminal.h"

#include <stdio.h>

/* ---- what the terminal sends (input.c): bytes wait here until readline takes them; pastes and
 * replies are taken out before ---- */

/* Reply of the terminal to ESC[5n, "I am well". */
#define REPLY_TEXT "\033[0n"
/* [ns] time for which the possible beginning of such a sequence is held back */
#define HELD_NS 100000000

/* Bytes from the terminal that have not been handled. */
struct input {
    struct buffer bytes;
    size_t head;     /* [byte] number of bytes taken already */
    int64_t arrived; /* [clock_ns] time at which the last bytes arrived */
    bool closed;     /* the terminal is gone */
};

/* Kinds of input: nothing, one byte, a paste, the terminal's answer. */
enum input_item { INPUT_NONE, INPUT_BYTE, INPUT_PASTE, INPUT_REPLY };

/* Reads the available bytes. gone means that poll() has reported that the terminal has hung up. */
void input_read(struct input *input, bool gone);
/* Takes the next item. A paste's text is valid until the next call; *byte is set for INPUT_BYTE. */
enum input_item input_next(struct input *input, int64_t now, unsigned char *byte,
                           struct text *paste);
/* Returns the time [clock_ns] at which something held back becomes a byte, or INT64_MAX if nothing
 * is held. */
int64_t input_due(const struct input *input);
/* Returns true if a key waits to be handled, not only a reply or a paste. */
bool input_pending(const struct input *input);
/* Removes the terminal's reply from the waiting bytes. Returns false if there is none. */
bool input_strip_reply(struct input *input);
/* Discards the waiting bytes. */
void input_clear(struct input *input);
void input_free(struct input *input);

/* ---- how often frames are drawn (pacing.c): after each frame the terminal is asked ESC[5n, and
 * the next frame waits for its answer, so that on a slow link only one frame is under way and keys
 * are echoed at once ---- */

/* Part of the screen that screen_show() has sent. */
enum shown { SHOWN_NOTHING, SHOWN_PART, SHOWN_ALL };

/* State of the frame rate. */
struct pacing {
    int64_t next;      /* [clock_ns] earliest time of the next animated frame */
    int64_t requested; /* [clock_ns] time of the open question, or 0 if there is none */
    int64_t delay;     /* [ns] between the last question and its answer */
    int missing;       /* number of successive questions without an answer */
};

/* The link counts as slow until it has answered for the first time. */
#define PACING_BEGIN                                                                               \
    {                                                                                              \
        .delay = INT64_MAX                                                                         \
    }

/* Returns the earliest time [clock_ns] of the next animated frame. */
int64_t pacing_due(const struct pacing *pacing, const struct session *session);
/* Returns the number of bytes that one frame may send: few over a slow link, so that keys are
 * echoed without delay. */
int pacing_bytes(const struct pacing *pacing);
/* Notes that a frame, or a part of one, was drawn, and asks the terminal for an answer if that is
 * wanted and something was sent. */
void pacing_drawn(struct pacing *pacing, const struct session *session, int64_t now,
                  enum shown shown);
/* Notes the terminal's answer. */
void pacing_replied(struct pacing *pacing, int64_t now);

/* ---- the terminal under ncurses (screen.c) ---- */

/* The screen under ncurses. */
struct terminal_screen {
    void *handle; /* SCREEN of ncurses, or NULL if not shown */
    bool color_wanted;
    bool color_begun;
    bool utf8;
    int width, height;    /* [cell] */
    struct canvas canvas; /* canvas of that size */
    struct canvas shown;  /* cells that the terminal shows at present */
    int next;             /* row with which the next call continues after SHOWN_PART */
    /* the terminal may show something else than `shown`: everything is sent */
    bool stale;
};

/* Returns the string that terminfo has under this name, also an extended one, or "". */
const char *screen_capability(const char *name);
/* Takes the terminal. Returns false if ncurses cannot. */
bool screen_begin(struct terminal_screen *screen);
/* Gives the terminal back and frees the screen. */
void screen_end(struct terminal_screen *screen);
/* Gives the terminal back while the program is stopped; screen_return() takes it again. */
void screen_leave(struct terminal_screen *screen);
void screen_return(struct terminal_screen *screen);
/* Chooses whether colours are shown. */
void screen_color(struct terminal_screen *screen, bool wanted);
/* Takes the terminal back after the program was stopped and continued by others. */
void screen_retake(struct terminal_screen *screen);
/* Makes the next screen_show() send everything. */
void screen_repaint(struct terminal_screen *screen);
/* Reads the size from the terminal and adapts to it. */
void screen_resize(struct terminal_screen *screen);
/* Sends the rows from first_row on that differ from `shown`, at most about `bytes` bytes; later
 * calls send the others. */
enum shown screen_show(struct terminal_screen *screen, int first_row, int bytes, int cursor_x,
                       int cursor_y);

/* ---- the front end ---- */

/* Origin of a command line. */
enum line_from {
    LINE_TYPED,
    LINE_KEY,    /* a key: executed like a typed line, but not added to the history */
    LINE_SILENT, /* a key that changes only the view: neither logged nor added to the history */
};

/* State of the panes front end. */
struct panes {
    struct front_program *program;
    struct input input;
    struct pacing pacing;
    struct terminal_screen screen;
    bool color;         /* the terminal shows colours, and NO_COLOR is not set */
    struct buffer line; /* complete line to execute, if line_waits */
    enum line_from line_from;
    bool line_waits;
    struct buffer aside; /* half typed line that is kept while a page is read */
    int aside_point;     /* [byte] position of the cursor in it */
    /* message on what a key could not do, shown instead of the numbers until the next line */
    struct buffer notice;
    bool echo_stale;   /* the prompt has changed */
    bool screen_stale; /* more than the prompt has changed */
    bool interrupted;  /* Ctrl-C was typed: what is being executed must stop */
    bool running;      /* true inside front.slice, while a run is in progress */
};

#define PANES_PROMPT "hooke> "

static inline struct session *panes_session(const struct panes *panes)
{
    return panes->program->session;
}

/* Returns true if the panes must end: the user quits, a signal ends the program, or the terminal is
 * gone. */
bool panes_over(const struct panes *panes);
/* Draws what is due, waits at most until `deadline` [clock_ns] for keys or signals, and reads or
 * saves. */
void panes_wait(struct panes *panes, int64_t deadline);
/* The same without drawing or saving. Returns true if something was typed. */
bool panes_read(struct panes *panes, int64_t deadline);
/* Saves the session if that is due; `line` tells that a line was executed. */
void panes_save(struct panes *panes, bool line);
/* Handles everything that was typed: passes keys to readline and executes complete lines. */
void panes_process(struct panes *panes);
/* Sets the line to be executed next. */
void panes_enqueue(struct panes *panes, struct text line, enum line_from origin);
/* Fills `prompt` with the present contents of the lowest row; `scratch` holds a text it may need.
 */
void panes_prompt(const struct panes *panes, struct prompt_line *prompt, struct buffer *scratch);
/* Shows the panes, in at most about `bytes` bytes. With only_prompt it draws the row of the prompt
 * alone, so that an echo costs little on a slow link. */
enum shown panes_show(struct panes *panes, bool only_prompt, int bytes);
/* Makes the next frame send everything, whatever the terminal shows. */
void panes_repaint(struct panes *panes);

/* ---- readline (edit.c) ---- */

/* The panes in use, because readline's callbacks have no context. NULL if there are none. */
extern struct panes *panes_active;

/* Begins to edit, with the output of readline discarded. Returns false if it has no thread for
 * that. */
bool edit_begin(FILE *nowhere);
/* Ends editing and readline's thread. */
void edit_end(void);
void edit_key(struct panes *panes, unsigned char byte); /* a typed key, for readline */
/* Enqueues the lines that a key has ended, while none waits to be executed; keys are taken only
 * where there are no more. Returns true if there was one. */
bool edit_take_line(struct panes *panes);
/* Discards the line being edited, with every state that readline may be in. */
void edit_clear(struct panes *panes);
/* Puts half typed text aside while a page is read. It comes back with the panes. */
void edit_put_aside(struct panes *panes);
/* Inserts a paste unchanged into the line, where it waits for Enter. It is ignored in the middle of
 * a search. */
void edit_paste(struct panes *panes, struct text paste);

/* ---- pages of text that is longer than the log (reading.c) ---- */

/* Describes the position of the page, or the notice, and the keys. */
void reading_prompt(const struct session *session, struct text notice, struct buffer *text);
/* Appends the command that shows the messages since said_before on the whole screen, or nothing if
 * the log has room for them or something was typed meanwhile. */
void reading_command(const struct panes *panes, uint64_t said_before, struct buffer *line);
/* Returns the line at the top of the page, counted from the newest, at which the page begins after
 * a change of size. */
int reading_line(const struct session *session);

/* ---- what the session asks for (watch.c) ---- */

/* Sets the callbacks of the panes that the session calls. */
void watch_offer(struct panes *panes, struct front *front);

/* ---- keys (keys.c) ---- */

/* Binds the keys in every keymap of readline; the inputrc, read afterwards, may bind them
 * differently. */
void keys_bind(void);
/* Chooses the keymap: that of the plot while cursors are shown, that of the page, or that of the
 * prompt. */
void keys_choose(const struct session *session);
bool keys_on_plot(void); /* Returns true while keys move the cursors. */
bool keys_on_text(void); /* Returns true while keys scroll the page. */

/* beginning of a line that searches the page and is not logged */
#define READING_FIND "scroll find "
