/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Restores the terminal whenever the program ends: at fatal signals, and when readline is out of
 * memory. Front ends call crash_modes() and crash_arm() when they change the terminal,
 * crash_disarm() when they have restored it. */
#include "terminal/terminal.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

/* [byte] memory that is freed for the last act when memory has run out */
#define RESCUE_RESERVE_BYTES ((size_t)1 << 19)

/* Memory that the handlers need. It is static, because a handler may neither allocate nor trust the
 * stack or the heap. */
static struct {
    /* `known` tells that modes is valid, `armed` that text is, too */
    volatile sig_atomic_t known, armed;
    volatile sig_atomic_t has_line;
    /* modes of the terminal and of a serial line (descriptor `line`) to restore */
    struct termios modes, line_modes;
    int line;
    /* escape sequences to write */
    char text[512];
    size_t len;
    void (*last_act)(void);
    void *reserve; /* memory that it may use, freed before */
    /* stack of the handlers */
    char stack[1 << 16];
} rescue;

/* Arms the handlers: an abnormal end writes the text and restores the modes noted by crash_modes().
 */
void crash_arm(struct text text)
{
    rescue.armed = 0;
    rescue.len = text.len < sizeof rescue.text ? text.len : 0;
    memcpy(rescue.text, text.data, rescue.len);
    rescue.armed = rescue.known;
}

void crash_disarm(void)
{
    rescue.armed = 0;
}

/* Writes the armed text and restores the modes; may be called in a signal handler. */
void crash_restore(void)
{
    if (rescue.armed) {
        ssize_t ignored = write(STDOUT_FILENO, rescue.text, rescue.len);
        (void)ignored;
        tcsetattr(STDIN_FILENO, TCSANOW, &rescue.modes);
    }
}

void crash_end(void)
{
    crash_restore();
    if (rescue.has_line)
        tcsetattr(rescue.line, TCSANOW, &rescue.line_modes);
}

static void on_fatal(int number)
{
    crash_end();
    /* SA_RESETHAND has restored the default action, which ends the program, with a core if enabled
     */
    raise(number);
}

void crash_signal(int number)
{
    struct sigaction action = {.sa_flags = (int)(SA_ONSTACK | SA_RESETHAND | SA_NODEFER)};
    sigemptyset(&action.sa_mask);
    action.sa_handler = on_fatal;
    sigaction(number, &action, NULL);
}

/* Makes the calling thread handle fatal signals on the static stack. */
void crash_stack(stack_t *previous)
{
    const stack_t stack = {.ss_sp = rescue.stack, .ss_size = sizeof rescue.stack};
    sigaltstack(&stack, previous); /* an endless recursion leaves no room on the usual stack */
}

/* Catches, once, all signals that end the program, so that the terminal is restored first. Signals
 * that are caught or ignored already are left alone, except those of program errors: a sanitizer
 * catches these and would not restore the terminal. */
static void watch_signals(void)
{
    /* Signals that do not end a program, or that signals.c handles. */
    static const int harmless[] = {SIGINT,  SIGHUP,  SIGTERM, SIGPIPE, SIGXFSZ, /* signals.c */
                                   SIGKILL, SIGSTOP, SIGTSTP, SIGTTIN, SIGTTOU,
                                   SIGCONT, SIGCHLD, SIGURG,  SIGWINCH};
    static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL};
    static bool is_watching;
    if (is_watching)
        return;
    is_watching = true;
    crash_stack(NULL);
    for (int number = 1; number <= SIGRTMAX; number++) {
        struct sigaction now;
        bool ends = sigaction(number, NULL, &now) == 0 && now.sa_handler == SIG_DFL;
        for (size_t i = 0; i < COUNT_OF(faults); i++)
            ends |= number == faults[i];
        for (size_t i = 0; i < COUNT_OF(harmless); i++)
            ends &= number != harmless[i];
        if (ends)
            crash_signal(number);
    }
}

/* Notes the present modes of the terminal, and begins to catch fatal signals. */
void crash_modes(void)
{
    struct termios modes;
    watch_signals();
    if (tcgetattr(STDIN_FILENO, &modes) == 0) {
        rescue.modes = modes;
        rescue.known = 1;
    }
}

/* Registers a serial line whose modes are restored at an abnormal end; modes NULL ends this. */
void crash_line(int fd, const struct termios *modes)
{
    rescue.has_line = 0;
    if (!modes)
        return;
    watch_signals();
    rescue.line = fd;
    rescue.line_modes = *modes;
    rescue.has_line = 1;
}

/* ---- memory for readline, which calls these two functions and would end the program itself ----
 */

void *xmalloc(size_t size);
void *xrealloc(void *old, size_t size);

/* Sets what is done before the program ends because readline is out of memory, such as saving the
 * session. NULL means nothing. */
void crash_last_act(void (*act)(void))
{
    rescue.last_act = act;
    free(rescue.reserve);
    rescue.reserve = act ? malloc(RESCUE_RESERVE_BYTES) : NULL;
}

/* Returns the memory, or ends the program with status 1 after the last act if it is NULL. */
static void *memory_or_end(void *memory)
{
    if (memory) {
        return memory;
    }
    void (*act)(void) = rescue.last_act;
    rescue.last_act = NULL; /* the act itself may run out of memory */
    free(rescue.reserve);
    rescue.reserve = NULL;
    if (act) {
        act();
    }
    crash_end();
    static const char message[] = "hooke: error: out of memory\n";
    ssize_t ignored = write(STDERR_FILENO, message, sizeof message - 1);
    (void)ignored;
    _exit(1);
}

void *xmalloc(size_t size)
{
    return memory_or_end(malloc(size ? size : 1));
}

void *xrealloc(void *old, size_t size)
{
    return memory_or_end(realloc(old, size ? size : 1));
}
