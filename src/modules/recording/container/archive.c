/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Unpacks archives in memory by libarchive, which is loaded when an archive is met. */
#include <hooke/base/library.h>
#include <hooke/base/safe_text.h>
#include "modules/recording/container/container.h"

#include <stdlib.h>
#include <string.h>

void archive_content_free(struct archive_content *content)
{
    for (size_t i = 0; i < content->entries; i++) {
        free(content->entry[i].path);
        buffer_free(&content->entry[i].bytes);
    }
    content->entries = 0;
}

const struct buffer *archive_content_find(const struct archive_content *content, const char *path)
{
    for (size_t i = 0; i < content->entries; i++)
        if (strcmp(content->entry[i].path, path) == 0)
            return &content->entry[i].bytes;
    return NULL;
}

#ifdef HAVE_ARCHIVE
#include <archive.h>
#include <archive_entry.h>

#define ARCHIVE_LIBRARY "libarchive.so.13"
/* Bytes that are unpacked between two checks. */
#define PIECE_BYTES 65536u

#define ARCHIVE_FUNCTIONS(X)                                                                       \
    X(archive_read_new)                                                                            \
    X(archive_read_free)                                                                           \
    X(archive_read_support_filter_gzip)                                                            \
    X(archive_read_support_format_zip)                                                             \
    X(archive_read_support_format_raw)                                                             \
    X(archive_read_open_memory)                                                                    \
    X(archive_read_next_header)                                                                    \
    X(archive_read_data)                                                                           \
    X(archive_entry_pathname)                                                                      \
    X(archive_entry_is_encrypted)                                                                  \
    X(archive_filter_bytes)                                                                        \
    X(archive_error_string)

/* The loaded library and its functions. */
struct archive_api {
#define MEMBER(name) __typeof__(name) *name;
    ARCHIVE_FUNCTIONS(MEMBER)
#undef MEMBER
    struct library library;
};

/* Loads libarchive. Returns false with the error and a hint if it is not installed. */
static bool load_archive_library(struct archive_api *api, const char *shown, struct error *error)
{
    static const struct library_symbol functions[] = {
#define SYMBOL(name) {#name, offsetof(struct archive_api, name)},
        ARCHIVE_FUNCTIONS(SYMBOL)
#undef SYMBOL
    };
    const char *missing;
    if (library_load(&api->library, ARCHIVE_LIBRARY, functions, COUNT_OF(functions), api, &missing))
        return true;
    error_set(error, ERROR_IO, "%s is an archive, which libarchive reads, but %s cannot be loaded",
              shown, ARCHIVE_LIBRARY);
    return error_hint(error, "install libarchive13, or unpack the file first");
}

/* An archive that is being unpacked. */
struct unpacking {
    const struct archive_api *api;
    struct archive *archive;
    const char *shown;
    struct intake *intake; /* may be NULL */
    size_t unpacked;       /* [byte] unpacked so far */
    size_t max;            /* [byte] limit of that */
    const struct cancel *cancel;
};

/* Sets the error of a damaged archive with libarchive's message. Returns false. */
static bool refuse_damaged(const struct unpacking *u, struct error *error)
{
    struct buffer why = {0};
    const char *message = u->api->archive_error_string(u->archive);
    safe_text(&why, text_of(message ? message : "unknown reason"), false);
    error_set(error, ERROR_IO, "%s is damaged or cut short: %.100s", u->shown,
              why.data ? why.data : "");
    buffer_free(&why);
    return error_hint(error, "transfer the file again, or export the data as CSV");
}

/* Returns true if `more` further bytes are too many in relation to the packed bytes that were read
 * so far; unbounded expansion is thus detected early. */
static bool is_bomb(const struct unpacking *u, size_t more)
{
    const int64_t packed = u->api->archive_filter_bytes(u->archive, -1);
    const uint64_t grown = EXPANSION_MAX * (uint64_t)(packed > 0 ? packed : 0) + EXPANSION_FREE;
    return u->unpacked + more > u->max || u->unpacked + more > grown;
}

/* Sets the error of an archive that expands too much. Returns false. */
static bool refuse_bomb(const struct unpacking *u, size_t more, struct error *error)
{
    if (u->unpacked + more > u->max)
        error_set(error, ERROR_IO, "%s unpacks to more than %zu bytes, the most that can be read",
                  u->shown, u->max);
    else
        error_set(error, ERROR_IO, "refused: %s unpacks to more than %d times its size", u->shown,
                  EXPANSION_MAX);
    return error_hint(error, "unpack it yourself if you trust it");
}

/* Unpacks the current entry into bytes, piece by piece. Returns false with the error if it is
 * damaged, too large or too strongly compressed (a bomb), if no table begins in it, or if
 * cancelled. */
static bool read_entry(struct unpacking *u, struct buffer *bytes, struct error *error)
{
    char piece[PIECE_BYTES];
    for (la_ssize_t got; (got = u->api->archive_read_data(u->archive, piece, sizeof piece)) != 0;) {
        if (got < 0)
            return refuse_damaged(u, error);
        const size_t old_len = bytes->len;
        if (is_bomb(u, (size_t)got))
            return refuse_bomb(u, (size_t)got, error);
        u->unpacked += (size_t)got;
        buffer_put(bytes, (struct text){piece, (size_t)got});
        if (bytes->failed)
            return error_memory(error);
        if (!unpacking_goes_on(u->cancel, error) ||
            (u->intake && !intake_look(u->intake, buffer_text(bytes), old_len, 0, error)))
            return false;
    }
    buffer_put(bytes, TEXT(""));
    return !bytes->failed || error_memory(error);
}

/* Unpacks the entries that are wanted, all if `wanted` is NULL. Returns false with the error. */
static bool read_entries(struct unpacking *u, bool (*wanted)(const char *path),
                         struct archive_content *content, struct error *error)
{
    struct archive_entry *entry;
    int status;
    while (content->entries < PARTS_MAX &&
           (status = u->api->archive_read_next_header(u->archive, &entry)) != ARCHIVE_EOF) {
        if (status != ARCHIVE_OK && status != ARCHIVE_WARN)
            return refuse_damaged(u, error);
        const char *path = u->api->archive_entry_pathname(entry);
        if (!path || (wanted && !wanted(path)))
            continue;
        if (u->api->archive_entry_is_encrypted(entry) > 0)
            return error_set(error, ERROR_IO, "%s is locked by a password", u->shown);
        struct archive_entry *one = &content->entry[content->entries];
        one->path = strdup(path);
        if (!one->path)
            return error_memory(error);
        content->entries++;
        if (!read_entry(u, &one->bytes, error))
            return false;
    }
    return true;
}

/* Opens the archive in memory, gzip or zip by its first bytes, and reads its entries. */
bool archive_unpack(struct text bytes, const char *shown, bool (*wanted)(const char *path),
                    struct intake *intake, struct archive_content *content, struct error *error)
{
    struct archive_api api;
    if (!load_archive_library(&api, shown, error))
        return false;
    struct unpacking u = {&api,
                          api.archive_read_new(),
                          shown,
                          intake,
                          0,
                          intake ? LIMIT_FILE : UNPACKED_MAX,
                          content->cancel};
    bool done = u.archive || error_memory(error);
    if (done) {
        api.archive_read_support_filter_gzip(u.archive);
        if (text_starts(bytes, TEXT("\x1F\x8B")))
            api.archive_read_support_format_raw(u.archive);
        else
            api.archive_read_support_format_zip(u.archive);
        done = (api.archive_read_open_memory(u.archive, bytes.data, bytes.len) == ARCHIVE_OK ||
                refuse_damaged(&u, error)) &&
               read_entries(&u, wanted, content, error);
        api.archive_read_free(u.archive);
    }
    library_unload(&api.library);
    return done;
}
#else
/* Opens the archive in memory, gzip or zip by its first bytes, and reads the entries for which
 * wanted() returns true (all if NULL) into *content. `shown` is the name for messages; `intake`,
 * unless NULL, examines the bytes as they are unpacked. Returns false with the error. */
bool archive_unpack(struct text bytes, const char *shown, bool (*wanted)(const char *path),
                    struct intake *intake, struct archive_content *content, struct error *error)
{
    (void)bytes, (void)wanted, (void)intake, (void)content;
    error_set(error, ERROR_IO, "%s is an archive, and this hooke was built without libarchive",
              shown);
    return error_hint(error, "install libarchive-dev and build it again, or unpack the file first");
}
#endif
