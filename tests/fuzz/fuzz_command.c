/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as a script: replies and errors, never a crash, and nothing written outside a folder of
 * its own. */
#include <hooke/command.h>

#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#define CORPUS "fuzz_command"
#define MUTATIONS 20
#include "terminal/folder.h"
#include "fuzz/replay.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static bool swallow(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

static struct cancel cancel;

static void on_alarm(int number)
{
    (void)number;
    atomic_store_explicit(&cancel.requested, 1, memory_order_relaxed);
}

/* Scripts may write files: they get a folder of their own, small files, no way out (--safe), and a
 * moment of time. */
static void settle(void)
{
    static char folder[] = "/tmp/hooke-fuzz-XXXXXX";
    static bool done;
    if (!done) {
        done = true;
        struct rlimit small = {1 << 20, 1 << 20};
        if (!make_folder(folder) || chdir(folder) != 0) {
            abort();
        }
        setrlimit(RLIMIT_FSIZE, &small);
        signal(SIGXFSZ, SIG_IGN);
        signal(SIGALRM, on_alarm);
    }
    atomic_store(&cancel.requested, 0);
    struct itimerval moment = {.it_value = {.tv_usec = 50000}};
    setitimer(ITIMER_REAL, &moment, NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    settle();
    struct front front = {.cancel = &cancel, .interactive = false, .utf8 = true};
    struct session *session = session_create(&front);
    if (!session) {
        return 0;
    }
    session->safe = true;
    session->keep_going = true;
    struct reply reply;
    reply_init(&reply, (struct sink){swallow, swallow, NULL});
    struct script script;
    script_begin(&script, session, "fuzz", NULL);
    struct text rest = {(const char *)data, size};
    struct text line;
    while (text_split(&rest, '\n', &line) && script_feed(&script, session, line, &reply)) {
    }
    script_end(&script, session, &reply);
    struct buffer saved = {0};
    session_save(session, &saved);
    buffer_free(&saved);
    reply_free(&reply);
    session_destroy(session);
    return 0;
}
