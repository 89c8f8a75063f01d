/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The terminal is given back usable at every end: fatal signals, and readline without memory. */
#include "terminal/terminal.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#define RESCUE_RESERVE_BYTES ((size_t)1 << 19)

/* All of it is static: a handler may neither allocate nor trust the stack or the heap. */
static struct {
    volatile sig_atomic_t known, armed; /* the modes; the text too */
    volatile sig_atomic_t has_line;
    struct termios modes, line_modes;
    int line;
    char text[512];
    size_t len;
    void (*last_act)(void);
    void *reserve; /* memory for it */
    char stack[1 << 16];
} rescue;

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
    /* SA_RESETHAND makes this end the program, with a core where those are wanted */
    raise(number);
}

void crash_signal(int number)
{
    struct sigaction action = {.sa_flags = (int)(SA_ONSTACK | SA_RESETHAND | SA_NODEFER)};
    sigemptyset(&action.sa_mask);
    action.sa_handler = on_fatal;
    sigaction(number, &action, NULL);
}

void crash_stack(stack_t *previous)
{
    const stack_t stack = {.ss_sp = rescue.stack, .ss_size = sizeof rescue.stack};
    sigaltstack(&stack, previous); /* an endless recursion leaves no other */
}

/* Catches the signals that end the program, once there are modes to restore. Signals that are
 * caught or ignored already stay so, but for those of a faulty program: a sanitizer catches these,
 * and would not give the terminal back. */
static void watch_signals(void)
{
    /* All other signals end a program that does not catch them. */
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

void crash_modes(void)
{
    struct termios modes;
    watch_signals();
    if (tcgetattr(STDIN_FILENO, &modes) == 0) {
        rescue.modes = modes;
        rescue.known = 1;
    }
}

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

/* ---- memory for readline: it calls these two and would end the program on its own ---- */

void *xmalloc(size_t size);
void *xrealloc(void *old, size_t size);

void crash_last_act(void (*act)(void))
{
    rescue.last_act = act;
    free(rescue.reserve);
    rescue.reserve = act ? malloc(RESCUE_RESERVE_BYTES) : NULL;
}

static void *checked(void *memory)
{
    if (memory) {
        return memory;
    }
    void (*act)(void) = rescue.last_act;
    rescue.last_act = NULL; /* it may end up here again */
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
    return checked(malloc(size ? size : 1));
}

void *xrealloc(void *old, size_t size)
{
    return checked(realloc(old, size ? size : 1));
}
