/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as a file that is loaded: as it is; by index; another run than the first. What loads
 * can be analysed. */
#pragma once

#include "modules/recording/series/analysis.h"
#include "modules/recording/table/load.h"

#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

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

static void load(const void *data, size_t size)
{
    int fd = memfd_create("recording", MFD_CLOEXEC);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size) {
        return;
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
}
