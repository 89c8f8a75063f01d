/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The sheets of an .xlsx workbook (ECMA-376, part 1, chapter 18) as tables of text. Dates and
 * times, which are numbers with a format, become stamps; formulas are represented by their stored
 * values. The XML documents of the workbook are parsed in turn: list of sheets, their paths,
 * formats, shared strings, sheets. */
#include <hooke/base/number.h>
#include "modules/recording/container/container.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Formats and styles of cells that are used at most. */
#define STYLES_MAX 4096
#define EPOCH_1900 25569.0 /* [day] 1970-01-01 in Excel's count */
#define EPOCH_1904 24107.0 /* [day] the same in the count of old Macintosh files */
/* Cells of a sheet at most. */
#define CELLS_MAX 20000000
#define WORDS_MAX (1u << 21) /* shared strings: twice the rows that a sheet may have */
/* A workbook's text may have this many times the size of its XML, plus EXPANSION_FREE bytes. */
#define GROWTH_MAX 4

/* Meaning of a number by its format: number, date, or time of day. */
enum cell_style { STYLE_NUMBER, STYLE_DATE, STYLE_TIME };

/* A workbook that is being read. */
struct workbook {
    const struct archive_content *content;
    const char *shown;
    struct error *error;
    struct arena arena;
    /* sheets in the workbook's order; name, identifier of the relation, path in the archive */
    struct {
        char *name, *relation, *path;
    } sheet[PARTS_MAX];
    int sheets;
    double epoch; /* [day] 1970-01-01 in the workbook's count */
    struct {      /* number formats that the workbook defines */
        long id;
        enum cell_style style;
    } format[STYLES_MAX];
    int formats;
    unsigned char style[STYLES_MAX]; /* [styles] enum cell_style of each cell style */
    int styles;
    bool in_cell_styles; /* the parser is inside the list of cell styles */
    struct text *word;   /* [words] shared strings */
    size_t words, capacity;
    struct buffer text; /* text of the current element */
    bool keep;          /* the text of the current element is collected */
    /* State of the sheet that is being read. */
    struct buffer *output;
    int column, filled; /* column of the current cell; cells written in this row */
    char type[16];      /* type of the current cell: n, s (shared string), str, e (error) … */
    enum cell_style cell_style;
    size_t cells; /* cells read so far */
    size_t left;  /* [byte] that the text of the remaining sheets may have */
};

bool workbook_wanted(const char *path)
{
    /* A sheet may have any name; the relations of sheets are in a folder of their own. */
    const size_t len = strlen(path);
    const bool sheet = strncmp(path, "xl/worksheets/", 14) == 0 && !strchr(path + 14, '/') &&
                       strcmp(path + len - 4, ".xml") == 0;
    return sheet || strcmp(path, "xl/workbook.xml") == 0 ||
           strcmp(path, "xl/_rels/workbook.xml.rels") == 0 ||
           strcmp(path, "xl/sharedStrings.xml") == 0 || strcmp(path, "xl/styles.xml") == 0;
}

/* Handles text: collects it if it belongs to a wanted element. */
static bool keep_text(void *context, struct text text)
{
    struct workbook *book = context;
    if (book->keep)
        buffer_put(&book->text, text);
    return !book->text.failed || error_memory(book->error);
}

/* Begins to collect text of the document. */
static void begin_text(struct workbook *book)
{
    buffer_clear(&book->text);
    book->keep = true;
}

/* Handles the end of an element by doing nothing. */
static bool ignore_end(void *context, const char *name)
{
    (void)context, (void)name;
    return true;
}

/* ---- which sheets there are ---- */

/* Handles an element of the workbook's main document, and collects the names of sheets and the
 * epoch of dates. `context` is the struct workbook. Returns false with book->error if out of
 * memory. */
static bool workbook_start(void *context, const char *name, const char **attributes)
{
    struct workbook *book = context;
    const char *old =
        strcmp(name, "workbookPr") == 0 ? xml_attribute(attributes, "date1904") : NULL;
    if (old && (strcmp(old, "1") == 0 || strcmp(old, "true") == 0))
        book->epoch = EPOCH_1904;
    if (strcmp(name, "sheet") != 0 || book->sheets == PARTS_MAX)
        return true;
    const char *title = xml_attribute(attributes, "name"),
               *relation = xml_attribute(attributes, "r:id");
    book->sheet[book->sheets].name = arena_text(&book->arena, text_of(title ? title : ""));
    book->sheet[book->sheets].relation =
        arena_text(&book->arena, text_of(relation ? relation : ""));
    book->sheets++;
    return (book->sheet[book->sheets - 1].name && book->sheet[book->sheets - 1].relation) ||
           error_memory(book->error);
}

/* Handles an element of the relations: sets the path of each sheet, whose relation has its Id.
 * Always returns true; a sheet without a path is left out later. */
static bool relation_start(void *context, const char *name, const char **attributes)
{
    struct workbook *book = context;
    const char *id = xml_attribute(attributes, "Id"), *target = xml_attribute(attributes, "Target");
    if (strcmp(name, "Relationship") != 0 || !id || !target)
        return true;
    for (int i = 0; i < book->sheets; i++)
        if (strcmp(book->sheet[i].relation, id) == 0) {
            struct buffer path = {0};
            buffer_format(&path, "%s%s", target[0] == '/' ? "" : "xl/",
                          target + (target[0] == '/'));
            book->sheet[i].path = path.failed ? NULL : arena_text(&book->arena, buffer_text(&path));
            buffer_free(&path);
        }
    return true;
}

/* ---- formats: which numbers are dates ---- */

/* Returns whether a number format shows a date, a time or a number, by the letters of dates and
 * times outside of quotes, brackets and escapes. */
static enum cell_style style_of_code(const char *code)
{
    bool date = false, time = false, quoted = false, bracket = false;
    for (; *code; code++) {
        quoted ^= *code == '"';
        bracket = *code == '[' || (bracket && *code != ']');
        if (*code == '\\' && code[1])
            code++;
        else if (!quoted && !bracket) {
            date |= strchr("yYdD", *code) != NULL;
            time |= strchr("hHsS", *code) != NULL;
        }
    }
    if (date)
        return STYLE_DATE;
    return time ? STYLE_TIME : STYLE_NUMBER;
}

/* Returns the meaning of a number format: one that the workbook defines or a built-in one
 * (ECMA-376, 18.8.30: 14 to 17 and 22 are dates, 18 to 21 and 45 to 47 times). */
static enum cell_style style_of_id(const struct workbook *book, long id)
{
    for (int i = 0; i < book->formats; i++)
        if (book->format[i].id == id)
            return book->format[i].style;
    if ((id >= 14 && id <= 17) || id == 22)
        return STYLE_DATE;
    return (id >= 18 && id <= 21) || (id >= 45 && id <= 47) ? STYLE_TIME : STYLE_NUMBER;
}

/* Handles the start of an element of the styles, collecting number formats and cell styles. */
static bool style_start(void *context, const char *name, const char **attributes)
{
    struct workbook *book = context;
    const char *id = xml_attribute(attributes, "numFmtId"),
               *code = xml_attribute(attributes, "formatCode");
    book->in_cell_styles |= strcmp(name, "cellXfs") == 0;
    if (strcmp(name, "numFmt") == 0 && id && code && book->formats < STYLES_MAX) {
        book->format[book->formats].id = strtol(id, NULL, 10);
        book->format[book->formats++].style = style_of_code(code);
    } else if (strcmp(name, "xf") == 0 && book->in_cell_styles && book->styles < STYLES_MAX) {
        book->style[book->styles++] =
            (unsigned char)style_of_id(book, id ? strtol(id, NULL, 10) : 0);
    }
    return true;
}

static bool style_end(void *context, const char *name)
{
    struct workbook *book = context;
    book->in_cell_styles &= strcmp(name, "cellXfs") != 0;
    return true;
}

/* ---- shared strings ---- */

/* Handles the start of an element of the shared strings. */
static bool word_start(void *context, const char *name, const char **attributes)
{
    struct workbook *book = context;
    (void)attributes;
    if (strcmp(name, "si") == 0)
        buffer_clear(&book->text);
    book->keep = strcmp(name, "t") == 0;
    return true;
}

/* Handles the end of an element of the shared strings; adds a string that is complete. */
static bool word_end(void *context, const char *name)
{
    struct workbook *book = context;
    book->keep = false;
    if (strcmp(name, "si") != 0)
        return true;
    if (book->words == WORDS_MAX)
        return error_set(book->error, ERROR_IO, "%s has more than %u shared strings", book->shown,
                         WORDS_MAX);
    if (book->words == book->capacity) {
        const size_t capacity = 2 * book->capacity + 256;
        struct text *grown = realloc(book->word, capacity * sizeof *grown);
        if (!grown)
            return error_memory(book->error);
        book->word = grown;
        book->capacity = capacity;
    }
    const char *copy = arena_text(&book->arena, buffer_text(&book->text));
    if (!copy)
        return error_memory(book->error);
    book->word[book->words++] = text_of(copy);
    return true;
}

/* ---- a sheet ---- */

/* Returns the column of a reference such as "BC12", counted from 0, or -1. */
static int column_of(const char *reference)
{
    int column = 0;
    for (; *reference >= 'A' && *reference <= 'Z' && column < (int)LIMIT_COLUMNS * 26; reference++)
        column = column * 26 + (*reference - 'A' + 1);
    return column - 1;
}

/* Begins a cell: sets its column, type and style from its attributes. Returns false with the error
 * if there are too many columns or cells. */
static bool cell_start(struct workbook *book, const char **attributes)
{
    const char *reference = xml_attribute(attributes, "r"), *type = xml_attribute(attributes, "t"),
               *style = xml_attribute(attributes, "s");
    const long index = style ? strtol(style, NULL, 10) : -1;
    book->column = reference ? column_of(reference) : book->column + 1;
    if (book->column < 0 || book->column >= (int)LIMIT_COLUMNS || ++book->cells > CELLS_MAX)
        return error_set(book->error, ERROR_IO,
                         "%s has a sheet with more than %d columns or %d cells", book->shown,
                         (int)LIMIT_COLUMNS, CELLS_MAX);
    snprintf(book->type, sizeof book->type, "%s", type ? type : "n");
    book->cell_style =
        index >= 0 && index < book->styles ? (enum cell_style)book->style[index] : STYLE_NUMBER;
    buffer_clear(&book->text);
    return true;
}

/* Handles the start of an element of a sheet: row, cell, value or text. */
static bool sheet_start(void *context, const char *name, const char **attributes)
{
    struct workbook *book = context;
    if (strcmp(name, "row") == 0) {
        book->column = -1;
        book->filled = 0;
    } else if (strcmp(name, "c") == 0) {
        return cell_start(book, attributes);
    } else if (strcmp(name, "v") == 0) {
        begin_text(book);
    } else if (strcmp(name, "t") == 0) { /* text with several fonts has several pieces */
        book->keep = true;
    }
    return true;
}

/* Appends the value of the current cell: a shared string (type "s"), a time stamp, or its text;
 * errors (type "e") remain empty. */
static void put_value(struct workbook *book)
{
    const struct text value = text_trim(buffer_text(&book->text));
    double number;
    if (strcmp(book->type, "s") == 0) {
        if (real_parse(value, &number) == REAL_OK && number >= 0 && number < (double)book->words)
            put_cell(book->output, book->word[(size_t)number]);
    } else if (strcmp(book->type, "n") == 0 && book->cell_style != STYLE_NUMBER &&
               real_parse(value, &number) == REAL_OK) {
        put_stamp(book->output, number - book->epoch, book->cell_style == STYLE_DATE);
    } else if (strcmp(book->type, "e") != 0) {
        put_cell(book->output, value);
    }
}

/* Returns false with the error if the text is too large. Shared strings, sheets that are listed
 * twice and empty columns can make much text of little XML. */
static bool output_is_bounded(struct workbook *book)
{
    if (book->output->failed)
        return error_memory(book->error);
    if (book->output->len <= book->left)
        return true;
    error_set(book->error, ERROR_IO,
              "refused: %s has sheets that unpack to more than %d times their size", book->shown,
              GROWTH_MAX);
    return error_hint(book->error, "save the sheet with the data as CSV");
}

/* Handles the end of an element of a sheet: writes a cell, preceded by tabs for skipped columns, or
 * ends a row. Returns false with the error if out of memory or if the output is too large. */
static bool sheet_end(void *context, const char *name)
{
    struct workbook *book = context;
    if (strcmp(name, "v") == 0 || strcmp(name, "t") == 0) {
        book->keep = false;
    } else if (strcmp(name, "c") == 0) {
        for (; book->filled < book->column; book->filled++)
            buffer_char(book->output, '\t');
        put_value(book);
        return output_is_bounded(book);
    } else if (strcmp(name, "row") == 0) {
        buffer_char(book->output, '\n');
    }
    return !book->output->failed || error_memory(book->error);
}

/* Adds sheet i as a part, unless the archive lacks it or it was read under another name. Returns
 * false with the error. */
static bool read_sheet(struct workbook *book, int i, struct contents *contents)
{
    const struct xml_reader reader = {book, book->content->cancel, sheet_start, sheet_end,
                                      keep_text};
    const struct buffer *sheet =
        book->sheet[i].path ? archive_content_find(book->content, book->sheet[i].path) : NULL;
    for (int k = 0; k < i && sheet; k++)
        if (book->sheet[k].path && strcmp(book->sheet[k].path, book->sheet[i].path) == 0)
            return true; /* the same sheet was read under another name */
    if (!sheet)
        return true;
    struct container_part *part = contents_add(contents, text_of(book->sheet[i].name));
    if (!part)
        return contents->parts == PARTS_MAX || error_memory(book->error);
    book->output = &part->text;
    buffer_put(book->output, TEXT(""));
    const bool done = xml_read(buffer_text(sheet), book->shown, &reader, book->error);
    book->left -= book->output->len < book->left ? book->output->len : book->left;
    return done;
}

/* Parses a document of the archive with these handlers, if it exists. */
static bool read_document(struct workbook *book, const char *path,
                          bool (*start)(void *context, const char *name, const char **attributes),
                          bool (*end)(void *context, const char *name))
{
    const struct xml_reader reader = {book, book->content->cancel, start, end, keep_text};
    const struct buffer *document = archive_content_find(book->content, path);
    book->keep = false;
    return !document || xml_read(buffer_text(document), book->shown, &reader, book->error);
}

/* Parses the documents of the .xlsx workbook in *content, then adds each sheet as a part to
 * *contents. `shown` is the name for messages. Returns false with the error. */
bool workbook_sheets(const struct archive_content *content, const char *shown,
                     struct contents *contents, struct error *error)
{
    struct workbook *book = calloc(1, sizeof *book);
    if (!book)
        return error_memory(error);
    book->content = content;
    book->shown = shown;
    book->error = error;
    book->epoch = EPOCH_1900;
    book->left = EXPANSION_FREE;
    for (size_t i = 0; i < content->entries; i++)
        book->left += GROWTH_MAX * content->entry[i].bytes.len;
    bool done = read_document(book, "xl/workbook.xml", workbook_start, ignore_end) &&
                read_document(book, "xl/_rels/workbook.xml.rels", relation_start, ignore_end) &&
                read_document(book, "xl/styles.xml", style_start, style_end) &&
                read_document(book, "xl/sharedStrings.xml", word_start, word_end);
    for (int i = 0; i < book->sheets && done; i++)
        done = read_sheet(book, i, contents);
    if (done && contents->parts == 0)
        done = error_set(error, ERROR_IO, "%s is a workbook without sheets", shown);
    buffer_free(&book->text);
    free(book->word);
    arena_reset(&book->arena);
    free(book);
    return done;
}
