/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Files that a test writes for itself, in a folder of their own, and options written as users type
 * them. */
#pragma once

#include <hooke/base/number.h>
#include <hooke/base/unit.h>

#include "cmocka_testing.h"

#include "modules/recording/table/load.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char fixture_folder[] = "/tmp/hooke-data-XXXXXX";

static int fixture_setup(void **state)
{
    (void)state;
    return mkdtemp(fixture_folder) ? 0 : -1;
}

static int fixture_teardown(void **state)
{
    (void)state;
    DIR *folder = opendir(fixture_folder);
    char path[600];
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        snprintf(path, sizeof path, "%s/%s", fixture_folder, entry->d_name);
        unlink(path);
    }
    if (folder)
        closedir(folder);
    return rmdir(fixture_folder);
}

static const char *fixture_path(const char *name)
{
    static char path[300];
    snprintf(path, sizeof path, "%s/%s", fixture_folder, name);
    return path;
}

static const char *fixture_file(const char *name, const char *text, size_t len)
{
    const char *path = fixture_path(name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, len, file), len);
    assert_int_equal(fclose(file), 0);
    return path;
}

/* "t=2 y=x unit=cm tunit=ms rate=100 decimal=, sep=; run=2" with sep=tab and sep=blank for what
 * cannot be written. */
static struct load_options fixture_options(const char *written)
{
    struct load_options options = {0};
    struct text rest = text_of(written), word;
    while (text_split(&rest, ' ', &word)) {
        struct text key, value = word;
        if (word.len == 0)
            continue;
        assert_true(text_split(&value, '=', &key));
        if (text_is(key, "t"))
            options.time = value;
        else if (text_is(key, "y"))
            options.value = value;
        else if (text_is(key, "run"))
            options.run = value;
        else if (text_is(key, "as"))
            options.name = value;
        else if (text_is(key, "unit"))
            assert_non_null(options.unit = unit_find(value));
        else if (text_is(key, "tunit"))
            assert_non_null(options.time_unit = unit_find(value));
        else if (text_is(key, "rate"))
            assert_int_equal(real_parse(value, &options.rate), REAL_OK);
        else if (text_is(key, "decimal"))
            options.decimal = value.data[0];
        else if (text_is(key, "sep"))
            options.separator = text_is(value, "tab")     ? '\t'
                                : text_is(value, "blank") ? ' '
                                                          : value.data[0];
        else
            fail_msg("unknown option in %s", written);
    }
    return options;
}

static inline struct recording *fixture_load(const char *text, size_t len, const char *written,
                                             struct error *error)
{
    struct load_options options = fixture_options(written);
    *error = (struct error){0};
    return recording_load(fixture_file("file.txt", text, len), &options, error);
}

/* Loads or fails the test with the reason. */
static inline struct recording *fixture_good(const char *text, const char *written)
{
    struct error error;
    struct recording *recording = fixture_load(text, strlen(text), written, &error);
    if (!recording)
        fail_msg("not loaded: %s\n%s", error.text, text);
    return recording;
}

static inline bool fixture_warns(const struct recording *recording, const char *part)
{
    for (int i = 0; i < recording->warnings; i++)
        if (strstr(recording->warning[i], part))
            return true;
    return false;
}

static inline bool near(double a, double b, double tolerance)
{
    return fabs(a - b) <= tolerance;
}
