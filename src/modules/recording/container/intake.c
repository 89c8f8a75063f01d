/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Examines a file while it is read, so that one without a table is refused from its beginning: the
 * cost of a refusal does not grow with the size that a hostile or mistaken file claims. */
#include "modules/recording/container/container.h"
#include <hooke/base/file.h>
#include <hooke/base/fields.h>
#include "modules/recording/table/table.h"

#include <string.h>

#define BYTE_ORDER_MARK TEXT("\xEF\xBB\xBF")
#define LINE_BYTES (16u << 20)        /* [byte] a longer line cannot be a row */
#define PATIENCE_NS 2000000000        /* [ns] time in which a slow pipe must reach its end */
#define ENOUGH_BYTES (2 * HEAD_BYTES) /* [byte] the table has to begin within these */

/* ---- kinds of files ---- */

/* Returns true if the text begins like an XML document of a known program. */
static bool is_xml(struct text text)
{
    if (text_starts(text, BYTE_ORDER_MARK))
        text = text_after(text, 3);
    text = text_trim(text);
    return text_starts(text, TEXT("<?xml")) || text_starts(text, TEXT("<Document")) ||
           text_starts(text, TEXT("<cassylab"));
}

enum {
    /* [byte] read to recognise the kind; blanks may precede a document's first element */
    HEAD = 512
};

/* Returns how the content of a file is packed: compares its first bytes with signatures, then looks
 * for XML and JSON. */
enum packing packing_of(struct text bytes)
{
    const struct text head = {bytes.data, bytes.len < HEAD ? bytes.len : HEAD};
    static const struct {
        const char *start;
        enum packing packing;
    } signatures[] = {{"\x1F\x8B", PACKING_GZIP},        {"PK\x03\x04", PACKING_ZIP},
                      {"\xD0\xCF\x11\xE0", PACKING_XLS}, {"\xFF\xFE", PACKING_UTF16},
                      {"\xFE\xFF", PACKING_UTF16},       {"# Created by Octave", PACKING_OCTAVE}};
    for (size_t i = 0; i < COUNT_OF(signatures); i++)
        if (text_starts(head, text_of(signatures[i].start)))
            return signatures[i].packing;
    if (is_xml(head))
        return PACKING_XML;
    return table_recognise(head) && head.data[0] == '{' ? PACKING_JSON : PACKING_NONE;
}

/* ---- refusals ---- */

static const struct {
    const char *start, *what;
} binaries[] = {
    {"%PDF", "a PDF document"},
    {"\x89PNG", "a picture (PNG)"},
    {"{\\rtf", "a rich text document (.rtf)"},
};

/* Returns false with the error if the text begins like a known kind of binary file. */
static bool refuse_known(struct text text, const char *name, struct error *error)
{
    for (size_t i = 0; i < COUNT_OF(binaries); i++)
        if (text_starts(text, text_of(binaries[i].start))) {
            error_set(error, ERROR_IO, "%s is %s, not a text file", name, binaries[i].what);
            return error_hint(
                error, "open it in the program that made it and export it as CSV (UTF-8 text)");
        }
    return true;
}

/* Sets the error of a NUL byte at offset nul, with its line and column. Returns false. */
static bool refuse_nul(struct text text, size_t nul, const char *name, struct error *error)
{
    struct text rest = {text.data, nul + 1}, line = {0};
    size_t number = 0;
    while (table_line(&rest, &line))
        number++;
    error_set(error, ERROR_IO, "%s is not a text file: NUL byte in line %zu, column %zu", name,
              number, line.len);
    return error_hint(error, "export the data as CSV text");
}

/* Returns false with the error for binary files of known kinds, and for a NUL byte at or after
 * `offset`. */
static bool refuse_binary_from(struct text text, size_t offset, const char *name,
                               struct error *error)
{
    const char *nul =
        offset < text.len ? memchr(text.data + offset, '\0', text.len - offset) : NULL;
    return refuse_known(text, name, error) &&
           (!nul || refuse_nul(text, (size_t)(nul - text.data), name, error));
}

/* Refuses an empty text, too. */
bool refuse_binary(struct text text, const char *name, struct error *error)
{
    return refuse_binary_from(text, 0, name, error) &&
           (text_trim(text).len > 0 || error_set(error, ERROR_IO, "%s is empty", name));
}

/* ---- while it is read ---- */

/* Returns false with the error if UTF-16 text has a NUL character at or after byte `offset`. */
static bool refuse_wide_nul(struct text bytes, size_t offset, const char *name, struct error *error)
{
    for (size_t i = offset - offset % 2; i + 1 < bytes.len; i += 2)
        if (!bytes.data[i] && !bytes.data[i + 1]) {
            error_set(error, ERROR_IO,
                      "%s is not a text file: it begins in UTF-16, NUL character at byte %zu", name,
                      i + 1);
            return error_hint(error, "export the data as CSV text");
        }
    return true;
}

/* Returns false with the error if a container is larger than PACKED_MAX. */
static bool refuse_large(const struct intake *intake, uintmax_t size, struct error *error)
{
    if (size <= PACKED_MAX)
        return true;
    error_set(error, ERROR_IO,
              "%s has %ju bytes; of archives, workbooks and XML documents at most %u are read",
              intake->shown, size, PACKED_MAX);
    return error_hint(error, "unpack it, or export the data as CSV");
}

/* Returns false with the error if the current line is too long. `offset` is where the new bytes
 * begin; updates intake->line. */
static bool refuse_endless_line(struct intake *intake, struct text text, size_t offset,
                                struct error *error)
{
    for (size_t i = text.len; i > offset && i > intake->line; i--)
        if (text.data[i - 1] == '\n' || text.data[i - 1] == '\r')
            intake->line = i;
    if (text.len - intake->line <= LINE_BYTES)
        return true;
    error_set(error, ERROR_IO,
              "%s is not a table: the line that begins at byte %zu is longer than %u bytes",
              intake->shown, intake->line + 1, LINE_BYTES);
    return error_hint(error, "export the data as CSV text");
}

/* Examines the content read so far, of which the bytes from `offset` on are new and `size` is the
 * file's size or 0, and refuses as early as possible what cannot be a table. `context` is the
 * struct intake. Returns false with the error. */
bool intake_look(void *context, struct text content, size_t offset, uintmax_t size,
                 struct error *error)
{
    struct intake *intake = context;
    const char *name = intake->shown;
    if (cancelled(intake->options->cancel))
        return error_set(error, ERROR_CANCELLED, "reading was stopped");
    const bool enough = content.len >= ENOUGH_BYTES && !intake->sought;
    const enum packing packing = offset < HEAD ? packing_of(content) : intake->packing;
    intake->packing = packing;
    if (packing == PACKING_UTF16)
        return refuse_wide_nul(content, offset, name, error);
    if (packing != PACKING_NONE &&
        !refuse_large(intake, size > content.len ? size : content.len, error))
        return false;
    if (packing != PACKING_NONE && packing != PACKING_XML)
        return true;
    if (!refuse_binary_from(content, offset, name, error))
        return false;
    if (packing == PACKING_XML)
        return true;
    intake->sought |= enough;
    return (!enough || table_begins(content, name, intake->options, error)) &&
           refuse_endless_line(intake, content, offset, error);
}

/* Reads the file at path (or standard input) into bytes while examining it. If the file grew
 * meanwhile, its incomplete last line is cut off. Sets intake->sum, a checksum, and intake->grew.
 * Returns false with the error. */
bool intake_read(const char *path, struct intake *intake, struct buffer *bytes, struct error *error)
{
    const bool input = strcmp(path, STANDARD_INPUT) == 0;
    struct read_watch watch = {
        .context = intake, .look = intake_look, .patience = input ? 0 : PATIENCE_NS};
    if (!file_read_watched(path, LIMIT_FILE, &watch, bytes, error)) {
        if (watch.endless)
            error_hint(
                error,
                "'collect' reads lines as they arrive; 'load -' reads standard input to its end");
        return false;
    }
    intake->sum = bytes->len <= SUMMED_BYTES ? bytes_sum(buffer_text(bytes)) : 0;
    intake->grew = watch.grew && intake->packing == PACKING_NONE;
    /* Cuts the incomplete last line off. */
    for (bool whole = !intake->grew; !whole && bytes->len > 0;
         whole = whole || bytes->data[bytes->len - 1] == '\n')
        bytes->data[--bytes->len] = '\0';
    return true;
}
