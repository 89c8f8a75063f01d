/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session whose output and messages end up in buffers. Included after <cmocka.h>. */
#pragma once

#include <hooke/base/statement.h>
#include <hooke/command.h>
#include <hooke/module.h>
#include <hooke/plot.h>
#include <hooke/report.h>

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct bench {
    struct session *session;
    struct reply reply;
    struct buffer out, err;
    bool full; /* the output refuses to take anything */
};

static bool bench_out(void *context, struct text text)
{
    struct bench *bench = context;
    if (!bench->full)
        buffer_put(&bench->out, text);
    return !bench->full;
}

static bool bench_err(void *context, struct text text)
{
    buffer_put(&((struct bench *)context)->err, text);
    return true;
}

static inline void bench_open(struct bench *bench, bool interactive)
{
    *bench = (struct bench){.full = false};
    bench->session = session_create(&(struct front){.interactive = interactive});
    reply_init(&bench->reply, (struct sink){bench_out, bench_err, bench});
    assert_non_null(bench->session);
}

static inline void bench_close(struct bench *bench)
{
    session_destroy(bench->session);
    reply_free(&bench->reply);
    buffer_free(&bench->out);
    buffer_free(&bench->err);
}

/* Executes a line as if typed; out and err hold what it said. */
static inline bool type(struct bench *bench, const char *line)
{
    buffer_clear(&bench->out);
    buffer_clear(&bench->err);
    return command_exec(bench->session, text_of(line), NULL, &bench->reply);
}

static inline void type_ok(struct bench *bench, const char *line)
{
    if (!type(bench, line))
        fail_msg("'%s' failed: %s", line, bench->err.data ? bench->err.data : "");
}

/* Returns true if a statement of the line begins with the command of a module that this build is
 * without. */
static inline bool is_left_out(const char *line)
{
    struct text rest = text_of(line), statement;
    bool is_out = false;
    while (text_split(&rest, ';', &statement)) {
        char name[LIMIT_NAME + 1];
        struct error error;
        text_skip_blanks(&statement);
        const struct text word = peek_name(statement);
        snprintf(name, sizeof name, "%.*s", (int)word.len, word.data);
        is_out |= !module_is_in(name, word, &error);
    }
    return is_out;
}

static inline const char *said(const struct buffer *buffer)
{
    return buffer->data ? buffer->data : "";
}

static inline void assert_says(const struct buffer *buffer, const char *wanted)
{
    if (!strstr(said(buffer), wanted))
        fail_msg("'%s' is not in:\n%s", wanted, said(buffer));
}

/* A folder of its own for files that are written; the tests of one program share it. */
static char bench_folder[] = "/tmp/hooke-command-XXXXXX";

static inline int enter_folder(void **state)
{
    (void)state;
    return mkdtemp(bench_folder) && chdir(bench_folder) == 0 ? 0 : -1;
}

static inline int leave_folder(void **state)
{
    (void)state;
    DIR *folder = opendir(".");
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            unlink(entry->d_name);
    if (folder)
        closedir(folder);
    return chdir("/") == 0 ? rmdir(bench_folder) : -1;
}

static inline void write_file(const char *name, const char *bytes, size_t len)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, len, file), len);
    assert_int_equal(fclose(file), 0);
}

/* ---- the file of a session, in memory ---- */
