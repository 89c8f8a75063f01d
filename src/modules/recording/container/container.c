/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Converts a file's bytes to parts of text: dispatches by kind of container, and decodes UTF-16. */
#include <hooke/base/safe_text.h>
#include "modules/recording/container/container.h"

#include "modules/recording/table/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Adds an empty part of this name, made safe to show, and returns it. Allocates the list on first
 * use. Returns NULL if out of memory or if there are PARTS_MAX parts. */
struct container_part *contents_add(struct contents *contents, struct text name)
{
    if (!contents->part)
        contents->part = calloc(PARTS_MAX, sizeof *contents->part);
    if (!contents->part || contents->parts == PARTS_MAX)
        return NULL;
    struct container_part *part = &contents->part[contents->parts++];
    struct buffer safe = {0};
    safe_text(&safe, name, false);
    const size_t len = safe.failed ? 0 : text_fitting(buffer_text(&safe), LIMIT_NAME);
    if (len > 0)
        memcpy(part->name, safe.data, len);
    part->name[len] = '\0';
    buffer_free(&safe);
    return part;
}

void contents_free(struct contents *contents)
{
    for (size_t i = 0; i < contents->parts; i++)
        buffer_free(&contents->part[i].text);
    free(contents->part);
    *contents = (struct contents){0};
}

/* Tabs and line ends in a cell become spaces, as they would separate cells and rows. */
void put_cell(struct buffer *text, struct text cell)
{
    cell = text_trim(cell);
    for (size_t i = 0; i < cell.len; i++)
        buffer_char(text, strchr("\t\r\n", cell.data[i]) ? ' ' : cell.data[i]);
}

/* Converts days since 1970-01-01 to a date (Hinnant 2013, chrono-compatible low-level date
 * algorithms: civil_from_days). */
static void civil_date(int64_t day, int64_t *year, int *month, int *date)
{
    day += 719468;
    const int64_t era = (day >= 0 ? day : day - 146096) / 146097, of_era = day - era * 146097;
    const int64_t y = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
    const int64_t of_year = of_era - (365 * y + y / 4 - y / 100), m = (5 * of_year + 2) / 153;
    *date = (int)(of_year - (153 * m + 2) / 5 + 1);
    *month = (int)(m < 10 ? m + 3 : m - 9);
    *year = y + era * 400 + (*month <= 2);
}

/* Appends a time of `days` since 1970, rounded to microseconds, as 12:34:56.123456, preceded by the
 * date if with_date. */
void put_stamp(struct buffer *text, double days, bool with_date)
{
    double day = floor(days), micro = nearbyint((days - day) * 86400e6);
    if (micro >= 86400e6) {
        day++;
        micro = 0;
    }
    if (with_date && fabs(day) < 1e9) {
        int64_t year;
        int month, date;
        civil_date((int64_t)day, &year, &month, &date);
        buffer_format(text, "%04d-%02d-%02dT", (int)year, month, date);
    }
    const int64_t all = (int64_t)micro;
    buffer_format(text, "%02d:%02d:%02d.%06d", (int)(all / 3600000000), (int)(all / 60000000 % 60),
                  (int)(all / 1000000 % 60), (int)(all % 1000000));
}

/* ---- UTF-16 ---- */

/* Converts UTF-16, without its byte order mark, to UTF-8. big tells the byte order. Returns false
 * with the error if cancelled or out of memory. */
static bool from_utf16(struct text bytes, bool big, const struct cancel *cancel,
                       struct buffer *output, struct error *error)
{
    const unsigned char *octets = (const unsigned char *)bytes.data;
    uint32_t high = 0;
    for (size_t i = 2; i + 1 < bytes.len; i += 2) {
        if (i % LOOK_EACH_ROWS == 0 && !unpacking_goes_on(cancel, error))
            return false;
        const uint32_t unit = big ? (uint32_t)(octets[i] << 8 | octets[i + 1])
                                  : (uint32_t)(octets[i + 1] << 8 | octets[i]);
        if (unit >= 0xD800 && unit < 0xDC00) {
            high = unit;
            continue;
        }
        const bool is_low = unit >= 0xDC00 && unit < 0xE000;
        const uint32_t pair = high ? 0x10000 + ((high - 0xD800) << 10) + (unit - 0xDC00) : 0xFFFD;
        buffer_codepoint(output, is_low ? pair : unit);
        high = 0;
    }
    buffer_put(output, TEXT(""));
    return !output->failed || error_memory(error);
}

/* Returns the offset at which numbers with one byte per character begin after UTF-16 text, as when
 * one program appends to the file of another, or bytes.len if there are none. They are recognised
 * by more consecutive units, both of whose bytes are characters of numbers, than any script has. */
static size_t narrow_numbers(struct text bytes, const struct cancel *cancel)
{
    enum { UNITS = 16 };
    size_t units = 0;
    for (size_t i = 2; i + 1 < bytes.len && !cancelled_at(cancel, i); i += 2) {
        bool both = bytes.data[i] && bytes.data[i + 1];
        for (size_t k = i; k < i + 2; k++)
            both = both && strchr("0123456789.,;\t\r\n -+eE", bytes.data[k]);
        units = both ? units + 1 : 0;
        if (units == UNITS)
            return i - 2 * (UNITS - 1);
    }
    return bytes.len;
}

/* Adds a part with this text, converted to UTF-8. The part takes over the memory of `bytes` if no
 * conversion is needed. Returns false with the error; parts beyond PARTS_MAX are silently left
 * out. */
static bool add_text(struct contents *contents, struct text name, struct buffer *bytes,
                     struct error *error)
{
    struct container_part *part = contents_add(contents, name);
    if (!part)
        return contents->parts == PARTS_MAX || error_memory(error);
    const struct text raw = buffer_text(bytes);
    const bool wide = packing_of(raw) == PACKING_UTF16;
    const size_t narrow = wide ? narrow_numbers(raw, contents->cancel) : raw.len;
    if (narrow < raw.len) {
        error_set(error, ERROR_IO,
                  "the file begins in UTF-16, but has one byte per character from byte %zu on",
                  narrow + 1);
        return error_hint(error, "split the file there, or export the data again as UTF-8");
    }
    if (wide)
        return from_utf16(raw, raw.data[0] == '\xFE', contents->cancel, &part->text, error);
    part->text = *bytes;
    *bytes = (struct buffer){0};
    return true;
}

/* ---- zip ---- */

/* Returns true if the path has one of the blank-separated endings, in any case. */
static bool ends_in(const char *path, const char *endings)
{
    const char *dot = strrchr(path, '.');
    struct text rest = text_of(endings), one;
    while (dot && text_split(&rest, ' ', &one))
        if (strlen(dot + 1) == one.len && strncasecmp(dot + 1, one.data, one.len) == 0)
            return true;
    return false;
}

/* Returns true for tables of text, but not for what an app writes about itself (phyphox' meta
 * folder) or for a Mac's shadow files. */
static bool is_table_entry(const char *path)
{
    return ends_in(path, "csv txt tsv dat asc lvm") && strncmp(path, "meta/", 5) != 0 &&
           !strstr(path, "/meta/") && strncmp(path, "__MACOSX", 8) != 0;
}

static bool is_wanted(const char *path)
{
    return is_table_entry(path) || workbook_wanted(path);
}

/* Returns the name of a file in an archive without its folder and its ending. */
static struct text entry_name(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
               *dot = strrchr(name, '.');
    return (struct text){name, dot && dot > name ? (size_t)(dot - name) : strlen(name)};
}

/* Returns true if a zip archive is complete: it ends in its directory, the end record of which may
 * be followed by at most 65535 bytes of comment (APPNOTE 4.3.16). */
static bool has_directory(struct text bytes)
{
    enum { END = 22, REMARKS = 65535 };
    const size_t first = bytes.len > END + REMARKS ? bytes.len - END - REMARKS : 0;
    for (size_t position = bytes.len; position-- > first;) {
        const unsigned char *end = (const unsigned char *)bytes.data + position;
        if (text_starts(text_after(bytes, position), TEXT("PK\5\6")) &&
            bytes.len - position >= END &&
            bytes.len - position >= (size_t)(END + end[END - 2] + 256 * end[END - 1]))
            return true;
    }
    return false;
}

/* Adds the tables of text in a zip archive, or the sheets of an .xlsx workbook, to `contents` as
 * parts. `bytes` is the archive and `shown` its name for messages. Returns false with the error set
 * if the archive is damaged or contains no table. */
static bool from_zip(struct text bytes, const char *shown, struct contents *contents,
                     struct error *error)
{
    struct archive_content *content = calloc(1, sizeof *content);
    if (!content)
        return error_memory(error);
    content->cancel = contents->cancel;
    bool done = archive_unpack(bytes, shown, is_wanted, NULL, content, error);
    if (done && !has_directory(bytes)) {
        error_set(error, ERROR_IO,
                  "%s is cut short: the directory at the end of the archive is missing", shown);
        done = error_hint(error, "transfer the file again, or export the data as CSV");
    }
    if (done && archive_content_find(content, "xl/workbook.xml")) {
        contents->container = "xlsx";
        done = workbook_sheets(content, shown, contents, error);
    } else if (done) {
        contents->container = "zip";
        for (size_t i = 0; i < content->entries && done; i++)
            if (is_table_entry(content->entry[i].path))
                done = add_text(contents, entry_name(content->entry[i].path),
                                &content->entry[i].bytes, error);
    }
    archive_content_free(content);
    free(content);
    if (done && contents->parts == 0) {
        error_set(
            error, ERROR_IO,
            "%s is a zip archive without a table of text (.csv, .txt, .tsv, .dat) or a workbook",
            shown);
        error_hint(error, "open it in the program that made it and export the data as CSV");
        done = false;
    }
    return done;
}

/* Adds a table that `export` wrote as JSON, converted to CSV, as a part. Returns false with the
 * error. */
static bool from_json(struct text bytes, struct contents *contents, struct error *error)
{
    struct arena arena = {0};
    struct table table;
    struct buffer text = {0};
    bool done = table_parse(bytes, contents->cancel, &arena, &table, error);
    if (done) {
        table_put(&table, table_csv, &text);
        done = unpacking_goes_on(contents->cancel, error);
    }
    if (done) {
        contents->container = "json";
        done = add_text(contents, TEXT(""), &text, error);
    }
    arena_reset(&arena);
    buffer_free(&text);
    return done;
}

/* ---- what is what ---- */

static bool unpack(const char *path, struct intake *intake, struct buffer *bytes,
                   struct contents *contents, struct error *error);

/* Returns true for gzip, zip and the old format of Excel workbooks. */
static bool is_archive(struct text bytes)
{
    const enum packing packing = packing_of(bytes);
    return packing == PACKING_GZIP || packing == PACKING_ZIP || packing == PACKING_XLS;
}

/* Unpacks a gzip file and adds its content as parts; archives within it are refused. Returns false
 * with the error. */
static bool from_gzip(const char *path, const struct intake *intake, struct text bytes,
                      struct contents *contents, struct error *error)
{
    const char *shown = intake->shown;
    struct intake inside = {.shown = shown, .options = intake->options};
    struct archive_content *content = calloc(1, sizeof *content);
    if (!content)
        return error_memory(error);
    content->cancel = contents->cancel;
    bool done = archive_unpack(bytes, shown, NULL, &inside, content, error);
    if (done && content->entries == 0)
        done = error_set(error, ERROR_IO, "%s is an empty archive", shown);
    if (done && is_archive(buffer_text(&content->entry[0].bytes)))
        done = error_set(error, ERROR_IO,
                         "%s contains an archive or a workbook inside an archive; unpack it first",
                         shown);
    else if (done)
        done = unpack(path, &inside, &content->entry[0].bytes, contents, error);
    contents->container = contents->container ? contents->container : "gzip";
    archive_content_free(content);
    free(content);
    return done;
}

/* Adds the content of `bytes`, the file at `path`, as parts. It takes over the memory of `bytes` if
 * they are the text itself. Returns false with the error. */
static bool unpack(const char *path, struct intake *intake, struct buffer *bytes,
                   struct contents *contents, struct error *error)
{
    const struct text text = buffer_text(bytes);
    switch (packing_of(text)) {
    case PACKING_GZIP:
        return from_gzip(path, intake, text, contents, error);
    case PACKING_ZIP:
        return from_zip(text, intake->shown, contents, error);
    case PACKING_XLS:
        contents->container = "xls";
        return workbook_old_sheets(path, intake->shown, contents, error);
    case PACKING_XML:
        return xml_tables(text, intake->shown, contents, error);
    case PACKING_JSON:
        return from_json(text, contents, error);
    case PACKING_OCTAVE:
        if (!octave_tables(text, intake->shown, contents, error))
            return false;
        if (contents->parts > 0)
            return true;
        break;
    case PACKING_UTF16:
    case PACKING_NONE:
        break;
    }
    return add_text(contents, TEXT(""), bytes, error);
}

/* Reads the file while examining it, then unpacks it into parts in *contents. `shown` is the name
 * for messages. Returns false with the error, with nothing to free. */
bool contents_read(const char *path, const char *shown, const struct load_options *options,
                   struct contents *contents, struct error *error)
{
    struct buffer bytes = {0};
    struct intake intake = {.shown = shown, .options = options};
    *contents = (struct contents){.cancel = options->cancel};
    const bool done =
        intake_read(path, &intake, &bytes, error) && unpack(path, &intake, &bytes, contents, error);
    contents->grew = intake.grew;
    contents->sum = intake.sum;
    buffer_free(&bytes);
    if (!done)
        contents_free(contents);
    return done;
}
