/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Contents of a file as text: archives, workbooks and XML documents become one or more tables of
 * text, UTF-16 becomes UTF-8. Everything after this sees lines of text only. The libraries that
 * read containers are loaded when such a file is met; without them the file is refused with the
 * name of the missing library.
 */
#pragma once

#include "modules/recording/table/load.h"
#include <hooke/base/cancel.h>
#include <hooke/result.h>

#define PARTS_MAX 256
#define PACKED_MAX (64u << 20)     /* bytes of an archive, a workbook, an XML document */
#define UNPACKED_MAX (128u << 20)  /* bytes of all entries of a zip archive or a workbook */
#define EXPANSION_MAX 64           /* an archive may grow to this many times its size … */
#define EXPANSION_FREE (16u << 20) /* … beyond this number of bytes, which are always allowed */

/* Kind of a file, told from its first bytes (intake.c). */
enum packing {
    PACKING_NONE,
    PACKING_UTF16,
    PACKING_GZIP,
    PACKING_ZIP,
    PACKING_XLS,
    PACKING_XML,
    PACKING_JSON,
    PACKING_OCTAVE
};

enum packing packing_of(struct text bytes);

/* A file that is being read, or what comes out of gzip. */
struct intake {
    const char *shown; /* its name for messages */
    const struct load_options *options;
    enum packing packing;
    size_t line; /* [byte] offset at which the current line begins */
    bool sought; /* there is a table in the beginning */
    /* text that was being written: its last line is left out, as it may be half of one */
    bool grew;
    uint64_t sum; /* checksum of all bytes that were read, or 0 above SUMMED_BYTES */
};

/* The look of a read_watch whose context is a struct intake: refuses what is no text and no
 * container, what no table begins in, lines without end, containers that are too large. */
bool intake_look(void *context, struct text content, size_t offset, uintmax_t size,
                 struct error *error);
bool intake_read(const char *path, struct intake *intake, struct buffer *bytes,
                 struct error *error);

struct container_part {
    /* name of the entry, sheet or data set, made safe; "" for the file itself */
    char name[LIMIT_NAME + 1];
    struct buffer text; /* UTF-8 */
};

struct contents {
    const char *container;       /* "gzip", "zip", "xlsx" …, or NULL for a plain file */
    struct container_part *part; /* [PARTS_MAX] */
    uint64_t sum;                /* checksum of the file's bytes, or 0 if not computed */
    size_t parts;                /* number of parts, at least 1 after contents_read() */
    bool grew; /* the file grew while it was read, so that its last line is left out */
    const struct cancel *cancel; /* taken from the options the file was read with */
};

/* Called in long loops over a container. Returns false with `error` set if reading was stopped. */
static inline bool unpacking_goes_on(const struct cancel *cancel, struct error *error)
{
    return !cancelled(cancel) || error_set(error, ERROR_CANCELLED, "reading was stopped");
}

/*
 * Reads the file at `path` and unpacks it. Messages call it `shown`. Fails with ERROR_IO, the
 * reason and advice if the file is not readable, damaged or too large, if its container is unknown,
 * or if a library is missing.
 */
bool contents_read(const char *path, const char *shown, const struct load_options *options,
                   struct contents *contents, struct error *error);
void contents_free(struct contents *contents);

/* Adds a part. Returns NULL if out of memory or if there are PARTS_MAX parts (further ones are left
 * out). */
struct container_part *contents_add(struct contents *contents, struct text name);

/* Entry of a zip or gzip archive in memory (archive.c). */
struct archive_entry {
    char *path; /* as in the archive, NUL-terminated */
    struct buffer bytes;
};

struct archive_content {
    const struct cancel *cancel; /* ends the unpacking */
    struct archive_entry entry[PARTS_MAX];
    size_t entries;
};

/* Unpacks the entries for which `wanted` is true, or all if it is NULL. intake examines what is
 * unpacked, unless NULL. */
bool archive_unpack(struct text bytes, const char *shown, bool (*wanted)(const char *path),
                    struct intake *intake, struct archive_content *content, struct error *error);
void archive_content_free(struct archive_content *content);
/* Returns NULL if there is no such entry. */
const struct buffer *archive_content_find(const struct archive_content *content, const char *path);

/* Handlers for a document, element by element (xml.c). They return false to stop (the error is then
 * theirs). */
struct xml_reader {
    void *context;
    const struct cancel *cancel;
    bool (*start)(void *context, const char *name, const char **attributes);
    bool (*end)(void *context, const char *name);
    bool (*text)(void *context, struct text text);
};

bool xml_read(struct text document, const char *shown, const struct xml_reader *reader,
              struct error *error);
/* Returns the value of an attribute, or NULL if the element has no such attribute. */
const char *xml_attribute(const char **attributes, const char *name);

/* xml_tables.c: Logger Pro (.cmbl) and CASSY Lab 2 (.labx). */
bool xml_tables(struct text document, const char *shown, struct contents *contents,
                struct error *error);
/* Adds vectors of a text file of Octave, side by side (octave.c). Adds no part where the file is to
 * be read as any other text. */
bool octave_tables(struct text text, const char *shown, struct contents *contents,
                   struct error *error);
/* Add the sheets of .xlsx and .xls (workbook.c, workbook_old.c). */
bool workbook_sheets(const struct archive_content *content, const char *shown,
                     struct contents *contents, struct error *error);
/* the entries of an .xlsx that hold sheets, words and formats */
bool workbook_wanted(const char *path);
bool workbook_old_sheets(const char *path, const char *shown, struct contents *contents,
                         struct error *error);

/* A cell of a table of text: what would end it becomes a blank. */
void put_cell(struct buffer *text, struct text cell);
/* A day of the Gregorian calendar counted from 1970-01-01, with its fraction, as a date or a time
 * of day. */
void put_stamp(struct buffer *text, double days, bool with_date);
