/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as an instrument's file: a recording or an error, never a crash; what loads can be
 * analysed. */
#include <hooke/analysis.h>

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#define CORPUS "fuzz_recording"
#define MUTATIONS 20
#include "fuzz/replay.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void analyse(struct recording *recording)
{
    struct arena arena = {0};
    struct series series;
    struct error error = {0};
    struct buffer text = {0};
    recording_describe(recording, &text);
    if (recording_series(recording, &arena, 8, &series, &error)) {
        struct overview overview;
        series_overview(&series, &arena, &overview);
        struct period period;
        series_period(&series, &arena, &period, &error);
    }
    buffer_free(&text);
    arena_reset(&arena);
    recording_destroy(recording);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    int fd = memfd_create("recording", MFD_CLOEXEC);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size) {
        return 0;
    }
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    /* As it is; by index; another run than the first. */
    static const struct load_options options[] = {{.rate = 0}, {.rate = 100}, {.run = {"2", 1}}};
    for (size_t i = 0; i < COUNT_OF(options); i++) {
        struct error error = {0};
        struct recording *recording = recording_load(path, &options[i], &error);
        if (recording)
            analyse(recording);
    }
    close(fd);
    return 0;
}
