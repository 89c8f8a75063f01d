/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Any bytes as what the terminal sends to the panes: keys, sequences, pastes, lines. The panes run
 * within this program: poll() below hands them a few bytes at a time, and leaves when there are no
 * more. What they draw goes nowhere.
 */
#include "terminal/panes.h"
#include "terminal/parts.h"

#define CORPUS "keys"
#define UNIT "keys"
#define FUZZ_SEEDS
#define FUZZ_MUTATOR
#include "fuzz/replay.h"
#include "fuzz/scripted.h"

#include <fcntl.h>
#include <locale.h>
#include <poll.h>

#include <readline/history.h>
#include <readline/readline.h>

enum {
    KEYS_CHUNK = 40, /* [byte] at once, where not all of it comes so */
    KEYS_NS = 5000000,
    KEYS_IDLE = 3,
    KEYS_SHORTEST = 8 /* [byte] at most, of an input: this, or up to 32 times as much */
};

static struct {
    struct text rest;
    uint64_t random;
    int pipe[2], idle;
    bool at_once;
    struct session *session;
} keys;

static void on_time(int number)
{
    (void)number;
    atomic_store_explicit(&interrupt.requested, 1, memory_order_relaxed);
}

int poll(struct pollfd *ready, nfds_t count, int timeout)
{
    if (strlen(rl_line_buffer) != (size_t)rl_end || rl_point < 0 || rl_point > rl_end)
        abort(); /* the line is not whole */
    for (nfds_t i = 0; i < count; i++)
        ready[i].revents = 0;
    scripted_time(KEYS_NS);
    if (keys.rest.len == 0) {
        if (++keys.idle > KEYS_IDLE)
            keys.session->execution.quit = true;
        return 0;
    }
    if (timeout == 0 && fuzz_random(&keys.random) % 2)
        return 0;
    const size_t wish =
        keys.at_once ? SIZE_MAX : 1 + (size_t)(fuzz_random(&keys.random) % KEYS_CHUNK);
    const ssize_t put =
        write(keys.pipe[1], keys.rest.data, wish < keys.rest.len ? wish : keys.rest.len);
    if (put > 0)
        keys.rest = (struct text){keys.rest.data + put, keys.rest.len - (size_t)put};
    ready[0].revents = POLLIN;
    return 1;
}

static void settle(void)
{
    static bool done;
    scripted_settle();
    if (done)
        return;
    done = true;
    const int nowhere = open("/dev/null", O_WRONLY);
    struct sigaction action = {.sa_handler = on_time};
    if (nowhere < 0 || dup2(nowhere, STDOUT_FILENO) < 0 || pipe2(keys.pipe, O_NONBLOCK) != 0 ||
        dup2(keys.pipe[0], STDIN_FILENO) < 0 || sigaction(SIGRTMIN, &action, NULL) != 0)
        abort();
    /* UTF-8 where the environment does not say otherwise */
    if (!getenv("LC_ALL"))
        setenv("LC_ALL", "C.UTF-8", 1);
    setlocale(LC_CTYPE, "");
    setenv("TERM", "xterm-256color", 1);
    setenv("INPUTRC", "/dev/null", 1);
    setenv("HOOKE_AUTOSAVE", "86400", 1);
}

/* A sequence is one key. */
static unsigned long count_keys(const uint8_t *data, size_t size)
{
    unsigned long count = 0;
    for (size_t i = 0; i < size; i++, count++) {
        if (data[i] != 033 || i + 1 >= size)
            continue;
        i++;
        if (data[i] == '[' || data[i] == 'O')
            for (i++; i < size && (data[i] < 0x40 || data[i] > 0x7e);)
                i++;
    }
    return count;
}

/* ---- what can be typed ---- */

static void put_key(struct buffer *out)
{
    static const char *const names[] = {"\033[A",  "\033[B",  "\033[C", "\033[D", "\033[5~",
                                        "\033[6~", "\033[H",  "\033[F", "\033OP", "\033[3~",
                                        "\033[Z",  "\t",      "\r",     "\177",   "\033\r",
                                        "\022",    "\033[0n", "?",      "/"};
    switch (tokens_choose(7)) {
    case 0:
        buffer_char(out, (char)(1 + tokens_choose(31)));
        break;
    case 1: /* with Alt */
        buffer_format(out, "\033%c", (char)(1 + tokens_choose(127)));
        break;
    case 2: /* any that a terminal may have */
        buffer_format(out, "\033%c%zu;%zu%c", "[O"[tokens_choose(2)], tokens_choose(30),
                      tokens_choose(9), (char)(0x40 + tokens_choose(0x3f)));
        break;
    case 3: {
        const struct text line = tokens.line[tokens_choose(tokens.lines)];
        buffer_format(out, tokens_choose(4) ? "%.*s\r" : "\033[200~%.*s\n\033[201~", (int)line.len,
                      line.data);
        break;
    }
    case 4: /* completed */
        buffer_format(out, "%s\t", tokens.word[tokens_choose(tokens.words)]);
        break;
    case 5:
        buffer_char(out, (char)(' ' + tokens_choose(95)));
        break;
    default:
        buffer_format(out, "%s", names[tokens_choose(COUNT_OF(names))]);
    }
}

size_t fuzz_seed(size_t i, uint8_t *data, size_t max)
{
    struct buffer out = {0};
    if (i >= 64)
        return 0;
    tokens_begin();
    tokens.random = (i + 1) * 88172645463325252u;
    for (size_t n = 0; n <= i % 24; n++)
        put_key(&out);
    const size_t len = out.len < max ? out.len : max;
    memcpy(data, out.data, len);
    buffer_free(&out);
    return len;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
    tokens_begin();
    tokens.random = seed * 2654435761u + 88172645463325252u;
    if (size == 0)
        return fuzz_seed(tokens_choose(64), data, max);
    const size_t most = (size_t)KEYS_SHORTEST << tokens_choose(6);
    max = most < max ? most : max;
    size = size < max ? size : max;
    if (tokens_choose(4) == 0)
        return LLVMFuzzerMutate(data, size, max);
    struct buffer out = {0};
    const size_t at = tokens_choose(size), cut = tokens_choose(4) ? 0 : tokens_choose(size - at);
    buffer_put(&out, (struct text){(const char *)data, at});
    for (size_t times = 1 + tokens_choose(6); times > 0; times--)
        put_key(&out);
    buffer_put(&out, (struct text){(const char *)data + at + cut, size - at - cut});
    const size_t len = out.len < max ? out.len : max;
    memcpy(data, out.data, len);
    buffer_free(&out);
    return len;
}

/* Nothing of one input is in the next one's history. */
static const char *const typed_before[] = {"run 1 s", "k = 20 N/m; show", "help run"};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const struct options options;
    struct streams streams = {0};
    struct reply reply;
    char left[256];
    settle();
    keys.random = fuzz_hash(data, size) | 1;
    struct session *session = scripted_create(keys.random, &reply);
    if (!session)
        abort();
    fuzz_units += count_keys(data, size);
    session->front.cancel = &interrupt;
    keys.session = session;
    keys.rest = (struct text){(const char *)data, size};
    keys.idle = 0;
    keys.at_once = keys.random >> 3 & 1;
    char number[16];
    snprintf(number, sizeof number, "%d", 6 + (int)(keys.random >> 8) % 60);
    setenv("LINES", number, 1);
    snprintf(number, sizeof number, "%d", 20 + (int)(keys.random >> 16) % 120);
    setenv("COLUMNS", number, 1);
    reply.sink = panes_sink(session);
    clear_history();
    for (size_t i = 0; i < COUNT_OF(typed_before); i++)
        add_history(typed_before[i]);
    const struct session_keeper *keeper = session_keeper();
    if (keeper)
        keeper->begin(session);
    struct front_program program = {
        .session = session, .options = &options, .streams = &streams, .reply = &reply};
    panes_run(&program);
    scripted_time(0);
    atomic_store(&interrupt.requested, 0);
    while (read(keys.pipe[0], left, sizeof left) > 0) {
    }
    if (keeper)
        keeper->end();
    buffer_free(&program.offer);
    buffer_free(&program.later);
    buffer_free(&program.passed);
    streams_free(&streams);
    scripted_destroy(session, &reply);
    return 0;
}
