/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as an instrument's file: a recording or an error, never a crash; what loads can be analysed. */
#include <hooke/analysis.h>

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#define CORPUS "fuzz_recording"
#include "replay.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    int fd = memfd_create("recording", MFD_CLOEXEC);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size) {
        return 0;
    }
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    struct load_options options = {.rate = 100};
    struct error error = {0};
    struct recording *recording = recording_load(path, &options, &error);
    if (recording) {
        struct arena arena = {0};
        struct series series;
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
    close(fd);
    return 0;
}
