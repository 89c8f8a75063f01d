/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Contents of a file as text: archives, workbooks and XML documents become one or more tables of
 * text, UTF-16 becomes UTF-8. contents_read() does it all, contents_free() frees the result;
 * readers of tables see lines of text only. The libraries for containers are loaded when such a
 * file is met; without them the file is refused with the name of the missing library. */
#pragma once

#include "modules/recording/table/load.h"
#include <hooke/base/cancel.h>
#include <hooke/result.h>

/* Largest number of parts of a container that are used. */
#define PARTS_MAX 256
#define PACKED_MAX (64u << 20)    /* [byte] size of an archive, a workbook, an XML document */
#define UNPACKED_MAX (128u << 20) /* [byte] all entries of a zip archive or a workbook */
/* An archive may expand to this many times its size plus EXPANSION_FREE bytes. */
#define EXPANSION_MAX 64
#define EXPANSION_FREE (16u << 20)

/* Kind of a file, recognised by its first bytes (intake.c). */
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

/* Returns the kind of a file that begins with these bytes. */
enum packing packing_of(struct text bytes);

/* A file that is being read, or the content of a gzip file that is being unpacked. */
struct intake {
    const char *shown; /* name of the file for messages */
    const struct load_options *options;
    enum packing packing;
    size_t line; /* [byte] offset of the start of the current line */
    bool sought; /* the beginning was searched for a table */
    /* The text was still being written: its last line, which may be incomplete, is left out. */
    bool grew;
    uint64_t sum; /* checksum of all bytes, or 0 above SUMMED_BYTES */
};

/* Examines what was read so far (the look of a read_watch whose context is a struct intake).
 * Returns false with the error for content that is neither text nor a known container, that does
 * not begin with a table, that has a line without end, and for containers that are too large. */
bool intake_look(void *context, struct text content, size_t offset, uintmax_t size,
                 struct error *error);
/* Reads the file at `path` into bytes, examining it meanwhile. Returns false with the error. */
bool intake_read(const char *path, struct intake *intake, struct buffer *bytes,
                 struct error *error);

/* One table of text: an entry of an archive, a sheet, a data set. */
struct container_part {
    /* Name of the entry, sheet or data set, safe to show; "" for the file itself. */
    char name[LIMIT_NAME + 1];
    struct buffer text; /* UTF-8 */
};

/* All tables of a file. */
struct contents {
    const char *container;       /* "gzip", "zip", "xlsx" …, or NULL for a plain file */
    struct container_part *part; /* [PARTS_MAX] */
    uint64_t sum;                /* checksum of the file's bytes, or 0 if not computed */
    size_t parts;                /* number of parts, at least 1 after contents_read() */
    bool grew;                   /* the file grew while it was read; its last line is left out */
    const struct cancel *cancel; /* taken from the options the file was read with */
};

/* Returns false with the error if reading was cancelled. Long loops over a container call it. */
static inline bool unpacking_goes_on(const struct cancel *cancel, struct error *error)
{
    return !cancelled(cancel) || error_set(error, ERROR_CANCELLED, "reading was stopped");
}

/* Reads and unpacks the file at `path`, which messages call `shown`. Returns false with ERROR_IO,
 * the reason and advice if the file is unreadable, damaged or too large, if its container is
 * unknown, or if a library is missing. */
bool contents_read(const char *path, const char *shown, const struct load_options *options,
                   struct contents *contents, struct error *error);
void contents_free(struct contents *contents);

/* Adds an empty part. Returns NULL if out of memory or if there are PARTS_MAX parts; callers leave
 * further parts out without an error. */
struct container_part *contents_add(struct contents *contents, struct text name);

/* Entry of a zip or gzip archive in memory (archive.c). */
struct archive_entry {
    char *path; /* as in the archive, NUL-terminated */
    struct buffer bytes;
};

/* Unpacked entries of an archive; archive_content_free() frees them. */
struct archive_content {
    const struct cancel *cancel; /* ends the unpacking */
    struct archive_entry entry[PARTS_MAX];
    size_t entries;
};

/* Unpacks the entries for which `wanted` is true, or all if it is NULL, from an archive in memory.
 * intake, unless NULL, examines the unpacked bytes. Returns false with the error for archives that
 * are damaged, locked or expand too much, or if libarchive is missing. */
bool archive_unpack(struct text bytes, const char *shown, bool (*wanted)(const char *path),
                    struct intake *intake, struct archive_content *content, struct error *error);
void archive_content_free(struct archive_content *content);
/* Returns the bytes of the entry with that path, or NULL if there is none. */
const struct buffer *archive_content_find(const struct archive_content *content, const char *path);

/* Handlers of a document's elements and text (xml.c). A handler returns false to stop, after it has
 * set the error. */
struct xml_reader {
    void *context;
    const struct cancel *cancel;
    bool (*start)(void *context, const char *name, const char **attributes);
    bool (*end)(void *context, const char *name);
    bool (*text)(void *context, struct text text);
};

/* Parses a document and calls the reader's handlers. Returns false with the error if it is not
 * valid XML or suspicious, if a handler stops, or if expat is missing. */
bool xml_read(struct text document, const char *shown, const struct xml_reader *reader,
              struct error *error);
/* Returns the value of an attribute, or NULL if the element does not have it. */
const char *xml_attribute(const char **attributes, const char *name);

/* Adds the data sets of Logger Pro (.cmbl) or CASSY Lab 2 (.labx) as parts (xml_tables.c). */
bool xml_tables(struct text document, const char *shown, struct contents *contents,
                struct error *error);
/* Adds tables of the vectors in a text file of Octave (octave.c). Adds no part if the file is to be
 * read as ordinary text. */
bool octave_tables(struct text text, const char *shown, struct contents *contents,
                   struct error *error);
/* Adds the sheets of an .xlsx workbook, given its entries, as parts (workbook.c). */
bool workbook_sheets(const struct archive_content *content, const char *shown,
                     struct contents *contents, struct error *error);
/* Returns true for the entries of an .xlsx that hold sheets, words and formats. */
bool workbook_wanted(const char *path);
/* Adds the sheets of the .xls workbook at `path` as parts, by FreeXL (workbook_old.c). */
bool workbook_old_sheets(const char *path, const char *shown, struct contents *contents,
                         struct error *error);

/* Appends a cell of a table of text; tabs and line ends in it become blanks. */
void put_cell(struct buffer *text, struct text cell);
/* Appends days since 1970-01-01 (Gregorian calendar), with their fraction, as a date and time or,
 * unless with_date, as a time of day. */
void put_stamp(struct buffer *text, double days, bool with_date);
