/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Any bytes as a script in a session of its own: made, played and destroyed within the program, in
 * a folder of its own, without a way out of it (--safe), and a moment for each line.
 */
#pragma once

#include "fuzz/tokens.h"
#include <hooke/base/cancel.h>
#include "terminal/folder.h"

#include <dirent.h>
#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <time.h>

#ifndef SCRIPTED_NS
#define SCRIPTED_NS 2000000 /* for a line; for those of one input in 64 ten times that */
#endif
#ifndef SCRIPTED_CLOCK
#define SCRIPTED_CLOCK CLOCK_MONOTONIC
#endif

enum {
    SCRIPTED_FILE = 1 << 20, /* [byte] of a file */
    SCRIPTED_SWEEP = 500,    /* inputs until what they wrote goes */
    SCRIPTED_SEED_LINES = 12,
};

static struct cancel scripted_cancel;
static timer_t scripted_timer;

/* The disk is another test's. */
int fsync(int fd)
{
    (void)fd;
    return 0;
}

int fdatasync(int fd)
{
    (void)fd;
    return 0;
}

static void scripted_on_time(int number)
{
    (void)number;
    atomic_store_explicit(&scripted_cancel.requested, 1, memory_order_relaxed);
}

static void scripted_write(const char *name, const char *unit, double phase)
{
    FILE *file = fopen(name, "w");
    if (!file)
        abort();
    fprintf(file, "time\t%s\ns\t%s\n", *unit == 'c' ? "distance" : "velocity", unit);
    for (int i = 0; i < 200; i++)
        fprintf(file, "%.2f\t%.4f\n", 0.02 * i, 20 + 5 * cos(8.66 * 0.02 * i + phase));
    fclose(file);
}

/* Only what was promised to be written: names without a folder are in this one. */
static void scripted_sweep(void)
{
    DIR *folder = opendir(".");
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            nftw(entry->d_name, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    if (folder)
        closedir(folder);
    scripted_write("swing.txt", "cm", 0);
    scripted_write("speed.txt", "m/s", 1);
}

static void scripted_settle(void)
{
    static char folder[] = "/tmp/hooke-fuzz-XXXXXX";
    static unsigned long inputs;
    if (inputs == 0) {
        struct rlimit small = {SCRIPTED_FILE, SCRIPTED_FILE};
        struct sigaction action = {.sa_handler = scripted_on_time};
        struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGRTMIN};
        tokens_begin();
        if (!make_folder(folder) || chdir(folder) != 0 || sigaction(SIGRTMIN, &action, NULL) != 0 ||
            timer_create(SCRIPTED_CLOCK, &event, &scripted_timer) != 0)
            abort();
        setrlimit(RLIMIT_FSIZE, &small);
        signal(SIGXFSZ, SIG_IGN);
        setenv("HOME", folder, 1);
        unsetenv("XDG_STATE_HOME");
        unsetenv("XDG_CONFIG_HOME");
    }
    if (inputs++ % SCRIPTED_SWEEP == 0)
        scripted_sweep();
}

/* From now on there is so much time; 0: no end. */
static inline void scripted_time(long ns)
{
    const struct itimerspec moment = {
        .it_value = {.tv_sec = ns / 1000000000, .tv_nsec = ns % 1000000000}};
    timer_settime(scripted_timer, 0, &moment, NULL);
    atomic_store(&scripted_cancel.requested, 0);
}

static bool scripted_swallow(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

static bool scripted_confirm(void *context, const char *question)
{
    (void)context;
    return strlen(question) % 2;
}

/* Returns NULL if out of memory. */
static struct session *scripted_create(uint64_t choice, struct reply *reply)
{
    struct front front = {.cancel = &scripted_cancel,
                          .interactive = choice % 4 == 0,
                          .confirm = scripted_confirm,
                          .utf8 = choice % 3,
                          .width = choice % 5 ? 0 : 20 + (int)(choice % 97),
                          .height = choice % 5 ? 0 : 6 + (int)(choice % 31)};
    struct session *session = session_create(&front);
    if (session) {
        session->options.safe = session->options.keep_going = true;
        reply_init(reply, (struct sink){scripted_swallow, scripted_swallow, NULL});
    }
    return session;
}

/* All its lines, whatever they give. */
static inline void scripted_play(struct session *session, struct reply *reply, struct text rest,
                                 uint64_t choice)
{
    struct script script;
    struct text line;
    script_begin(&script, session, "fuzz", NULL);
    while (text_split(&rest, '\n', &line) && !session->execution.quit) {
        fuzz_units += text_trim(line).len > 0;
        scripted_time(choice % 64 ? SCRIPTED_NS : 10 * SCRIPTED_NS);
        if (!script_feed(&script, session, line, reply)) {
            script_end(&script, session, reply);
            script_begin(&script, session, "fuzz", NULL);
        }
    }
    scripted_time(SCRIPTED_NS);
    script_end(&script, session, reply);
    scripted_time(0);
}

static inline void scripted_destroy(struct session *session, struct reply *reply)
{
    reply_free(reply);
    session_destroy(session);
}

/* Some lines of the tests' scripts that follow each other. */
static inline size_t scripted_seed(size_t i, uint8_t *data, size_t max)
{
    size_t len = 0;
    tokens_begin();
    for (size_t n = SCRIPTED_SEED_LINES * i; n < SCRIPTED_SEED_LINES * (i + 1) && n < tokens.lines;
         n++) {
        const struct text line = tokens.line[n];
        if (line.len + 1 > max - len)
            break;
        memcpy(data + len, line.data, line.len);
        data[len + line.len] = '\n';
        len += line.len + 1;
    }
    return len;
}
