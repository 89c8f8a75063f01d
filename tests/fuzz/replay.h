/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A fuzz target without libFuzzer: replays the corpus and a fixed number of mutations of it, as an
 * ordinary test. CORPUS is its folder below tests/fuzz/corpus, MUTATIONS how many of each file the
 * quick form tries.
 */
#ifndef REPLAY_H
#define REPLAY_H
#ifndef FUZZING

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "long_form.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static uint64_t replay_random(uint64_t *state) /* xorshift64*, Vigna 2016 */
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 2685821657736338717u;
}

/* Flips, overwrites, cuts and doubles bytes. */
static size_t replay_mutate(uint8_t *data, size_t size, size_t capacity, uint64_t *state)
{
    static const char *const words[] = {"1e400", "nan",  "-",   "(",    ")",  "\"",   "'",
                                        ";",     "#",    "+-",  ",",    ":",  "=",    "\t",
                                        "\r\n",  "\xff", "0x1", "9e99", "..", "\x1b["};
    for (uint64_t times = replay_random(state) % 6; times > 0 && size > 0; times--) {
        size_t at = replay_random(state) % size;
        switch (replay_random(state) % 5) {
        case 0:
            data[at] = (uint8_t)replay_random(state);
            break;
        case 1:
            data[at] ^= (uint8_t)(1u << (replay_random(state) % 8));
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
            const char *word = words[replay_random(state) % (sizeof words / sizeof words[0])];
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

int main(void)
{
    const char *folder = "tests/fuzz/corpus/" CORPUS;
    struct dirent **entry = NULL;
    int files = scandir(folder, &entry, NULL, alphasort);
    /* the target may change the working directory */
    int corpus = open(folder, O_RDONLY | O_DIRECTORY);
    enum { ROOM = 1 << 16 };
    static uint8_t original[ROOM / 2];
    static uint8_t data[ROOM];
    long rounds = is_long() ? 200000 : MUTATIONS;
    uint64_t state = 20261121;
    int replayed = 0;
    for (int i = 0; i < files; i++) {
        int fd = entry[i]->d_name[0] == '.' ? -1 : openat(corpus, entry[i]->d_name, O_RDONLY);
        free(entry[i]);
        if (fd < 0) {
            continue;
        }
        ssize_t got = read(fd, original, sizeof original);
        close(fd);
        size_t size = got > 0 ? (size_t)got : 0;
        LLVMFuzzerTestOneInput(original, size);
        for (long r = 0; r < rounds; r++) {
            memcpy(data, original, size);
            LLVMFuzzerTestOneInput(data, replay_mutate(data, size, sizeof data, &state));
        }
        replayed++;
    }
    free(entry);
    close(corpus);
    printf("%s 1 - " CORPUS ": %d files and %ld mutations of each\n1..1\n",
           replayed > 0 ? "ok" : "not ok", replayed, rounds);
    return replayed > 0 ? 0 : 1;
}

#endif
#endif
