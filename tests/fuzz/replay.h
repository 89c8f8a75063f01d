/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What every fuzz target has. Under libFuzzer (-DFUZZING) that is a count at the end; without it a
 * main() that replays the corpus and goes on with mutations of it, of a fixed seed, as an ordinary
 * test: QUICK_SECONDS of processor time (1), in the long form FUZZ_SECONDS (600).
 *
 * CORPUS: its folder below tests/fuzz/corpus. UNIT: what fuzz_units counts. With FUZZ_MUTATOR the
 * target has LLVMFuzzerCustomMutator(); with FUZZ_SEEDS, fuzz_seed(): inputs that are made, not
 * kept.
 */
#pragma once

#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed);
/* The i-th input that is made, of at most `max` bytes; 0: there are no more. */
size_t fuzz_seed(size_t i, uint8_t *data, size_t max);

#ifndef QUICK_INPUTS /* of the quick form, at most */
#define QUICK_INPUTS ULONG_MAX
#endif
#ifndef QUICK_SECONDS /* of processor time, of the quick form */
#define QUICK_SECONDS 1
#endif
#ifndef UNIT
#define UNIT "inputs"
#endif

static unsigned long fuzz_units;

static inline uint64_t fuzz_random(uint64_t *state) /* xorshift64*, Vigna 2016 */
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 2685821657736338717u;
}

/* A number that belongs to the input: what is chosen by it is the same again (FNV-1a). */
static inline uint64_t fuzz_hash(const uint8_t *data, size_t size)
{
    uint64_t sum = 14695981039346656037u;
    for (size_t i = 0; i < size; i++)
        sum = (sum ^ data[i]) * 1099511628211u;
    return sum ^ sum >> 32;
}

#ifdef FUZZING

static void fuzz_say_units(void)
{
    fprintf(stderr, "stat::units: %lu %s\n", fuzz_units, UNIT);
}

__attribute__((constructor)) static void fuzz_count(void)
{
    atexit(fuzz_say_units);
}

#else

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <time.h>
#include "long_form.h"

enum { REPLAY_ROOM = 1 << 16, REPLAY_FILES = 512, REPLAY_SECONDS = 600, REPLAY_ENDLESS = 30 };

static struct {
    uint64_t random;
    struct replay_input {
        uint8_t *at;
        size_t size;
    } seed[REPLAY_FILES];
    int seeds, output, top; /* descriptors: of what is said, of the folder it began in */
    uint8_t data[REPLAY_ROOM];
    size_t size;
    timer_t endless;
} replay;

/* Flips, overwrites, cuts and doubles bytes. */
static size_t replay_mutate(uint8_t *data, size_t size, size_t capacity, uint64_t *state)
{
    static const char *const words[] = {"1e400", "nan",  "-",   "(",    ")",  "\"",   "'",
                                        ";",     "#",    "+-",  ",",    ":",  "=",    "\t",
                                        "\r\n",  "\xff", "0x1", "9e99", "..", "\x1b["};
    for (uint64_t times = fuzz_random(state) % 6; times > 0 && size > 0; times--) {
        size_t at = (size_t)(fuzz_random(state) % size);
        switch (fuzz_random(state) % 5) {
        case 0:
            data[at] = (uint8_t)fuzz_random(state);
            break;
        case 1:
            data[at] ^= (uint8_t)(1u << (fuzz_random(state) % 8));
            break;
        case 2:
            size = at;
            break;
        case 3: {
            size_t len = size - at < capacity - size ? size - at : capacity - size;
            memcpy(data + size, data + at, len);
            size += len;
            break;
        }
        default: {
            const char *word = words[fuzz_random(state) % (sizeof words / sizeof words[0])];
            size_t len = strlen(word);
            if (size + len <= capacity) {
                memmove(data + at + len, data + at, size - at);
                memcpy(data + at, word, len);
                size += len;
            }
        }
        }
    }
    return size;
}

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max)
{
    return replay_mutate(data, size, max, &replay.random);
}

static size_t replay_next(void)
{
#ifdef FUZZ_MUTATOR
    return LLVMFuzzerCustomMutator(replay.data, replay.size, REPLAY_ROOM,
                                   (unsigned)fuzz_random(&replay.random));
#else
    return LLVMFuzzerMutate(replay.data, replay.size, REPLAY_ROOM);
#endif
}

/* ---- the input that ends it: crash-CORPUS where it began ---- */

static void replay_keep(void)
{
    int fd = openat(replay.top, "crash-" CORPUS, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (fd < 0 || write(fd, replay.data, replay.size) != (ssize_t)replay.size)
        return;
    dprintf(replay.output, "# the input is in crash-" CORPUS "\n");
}

static void replay_on_end(int number)
{
    dprintf(replay.output, "# signal %d\n", number);
    replay_keep();
    signal(number, SIG_DFL);
    raise(number);
}

void __sanitizer_set_death_callback(void (*act)(void)) __attribute__((weak));

static void replay_catch(void)
{
    const int ends[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGRTMAX};
    if (__sanitizer_set_death_callback)
        __sanitizer_set_death_callback(replay_keep);
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++)
        if (!__sanitizer_set_death_callback || ends[i] == SIGRTMAX)
            signal(ends[i], replay_on_end);
    /* not alarm(), which the program takes for itself */
    struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGRTMAX};
    if (timer_create(CLOCK_PROCESS_CPUTIME_ID, &event, &replay.endless) != 0)
        abort();
}

/* ---- inputs ---- */

static void replay_add(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size + 1);
    if (!copy || replay.seeds == REPLAY_FILES)
        abort();
    memcpy(copy, data, size);
    replay.seed[replay.seeds++] = (struct replay_input){copy, size};
}

/* Returns how many are files: those are all tried. */
static int replay_read(void)
{
    struct dirent **entry = NULL;
    const int files = scandir("tests/fuzz/corpus/" CORPUS, &entry, NULL, alphasort);
    const int corpus = open("tests/fuzz/corpus/" CORPUS, O_RDONLY | O_DIRECTORY);
    for (int i = 0; i < files; i++) {
        int fd = entry[i]->d_name[0] == '.' ? -1 : openat(corpus, entry[i]->d_name, O_RDONLY);
        const ssize_t got = fd < 0 ? -1 : read(fd, replay.data, REPLAY_ROOM / 2);
        if (got >= 0)
            replay_add(replay.data, (size_t)got);
        if (fd >= 0)
            close(fd);
        free(entry[i]);
    }
    free(entry);
    if (corpus >= 0)
        close(corpus);
    const int kept = replay.seeds;
#ifdef FUZZ_SEEDS
    size_t size;
    for (size_t i = 0; (size = fuzz_seed(i, replay.data, REPLAY_ROOM)) > 0; i++)
        replay_add(replay.data, size);
#endif
    return kept;
}

static void replay_one(void)
{
    const struct itimerspec end = {.it_value.tv_sec = REPLAY_ENDLESS};
    timer_settime(replay.endless, 0, &end, NULL);
    LLVMFuzzerTestOneInput(replay.data, replay.size);
}

static double replay_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Every input once, then mutations; a file by its name: that alone. */
int main(int argc, char **argv)
{
    const char *wish = getenv("FUZZ_SECONDS"), *seed = getenv("FUZZ_SEED");
    const double most = !is_long() ? QUICK_SECONDS : wish ? strtod(wish, NULL) : REPLAY_SECONDS;
    unsigned long inputs = 0;
    replay.random = seed ? strtoull(seed, NULL, 10) : 20261121;
    replay.output = dup(STDOUT_FILENO);
    replay.top = open(".", O_RDONLY | O_DIRECTORY);
    if (argc > 1) {
        FILE *file = fopen(argv[1], "rb");
        replay.size = file ? fread(replay.data, 1, REPLAY_ROOM, file) : 0;
        return file ? (fclose(file), LLVMFuzzerTestOneInput(replay.data, replay.size)) : 2;
    }
    const int files = replay_read();
    replay_catch();
    const double begin = replay_seconds();
    for (int i = 0; i < files; i++, inputs++) {
        memcpy(replay.data, replay.seed[i].at, replay.size = replay.seed[i].size);
        replay_one();
    }
    /* a chain of up to 8 mutations of each */
    for (; replay.seeds > 0 && replay_seconds() - begin < most &&
           (is_long() || inputs < QUICK_INPUTS);
         inputs++) {
        if (inputs % 8 == 0) {
            const struct replay_input *from =
                &replay.seed[fuzz_random(&replay.random) % (uint64_t)replay.seeds];
            memcpy(replay.data, from->at, replay.size = from->size);
        }
        replay.size = replay_next();
        replay_one();
    }
    timer_delete(replay.endless);
    const double took = replay_seconds() - begin;
    const unsigned long units = fuzz_units ? fuzz_units : inputs;
    dprintf(replay.output,
            "%s 1 - " CORPUS ": %d files\n# %lu inputs, %lu " UNIT ", %.0f a second\n1..1\n",
            replay.seeds > 0 ? "ok" : "not ok", files, inputs, units, (double)units / took);
    for (int i = 0; i < replay.seeds; i++)
        free(replay.seed[i].at);
    close(replay.top);
    return replay.seeds > 0 ? 0 : 1;
}

#endif
