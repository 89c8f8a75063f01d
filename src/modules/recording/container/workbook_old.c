/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The sheets of an .xls workbook as tables of text, by FreeXL, which is loaded when one is met. */
#include <hooke/base/library.h>
#include <hooke/base/number.h>
#include "modules/recording/container/container.h"

#ifdef HAVE_FREEXL
#include <freexl.h>

#define FREEXL_LIBRARY "libfreexl.so.1"

#define FREEXL_FUNCTIONS(X)                                                                        \
    X(freexl_open)                                                                                 \
    X(freexl_close)                                                                                \
    X(freexl_get_info)                                                                             \
    X(freexl_get_worksheet_name)                                                                   \
    X(freexl_select_active_worksheet)                                                              \
    X(freexl_worksheet_dimensions)                                                                 \
    X(freexl_get_cell_value)

/* The loaded library and its functions. */
struct freexl_api {
#define MEMBER(name) __typeof__(name) *name;
    FREEXL_FUNCTIONS(MEMBER)
#undef MEMBER
    struct library library;
};

/* Loads FreeXL. Returns false with the error and a hint if it is not installed. */
static bool load_freexl_library(struct freexl_api *api, const char *shown, struct error *error)
{
    static const struct library_symbol functions[] = {
#define SYMBOL(name) {#name, offsetof(struct freexl_api, name)},
        FREEXL_FUNCTIONS(SYMBOL)
#undef SYMBOL
    };
    const char *missing;
    if (library_load(&api->library, FREEXL_LIBRARY, functions, COUNT_OF(functions), api, &missing))
        return true;
    error_set(error, ERROR_IO,
              "%s is an Excel workbook (.xls), which FreeXL reads, but %s cannot be loaded", shown,
              FREEXL_LIBRARY);
    return error_hint(error, "install libfreexl1, or save it as .xlsx or CSV");
}

/* Appends the value of a cell. */
static void cell_value_put(struct buffer *output, const FreeXL_CellValue *cell)
{
    switch (cell->type) {
    case FREEXL_CELL_INT:
        buffer_format(output, "%d", cell->value.int_value);
        break;
    case FREEXL_CELL_DOUBLE:
        buffer_real(output, cell->value.double_value);
        break;
    case FREEXL_CELL_TEXT:
    case FREEXL_CELL_SST_TEXT:
    case FREEXL_CELL_DATE:
    case FREEXL_CELL_DATETIME:
    case FREEXL_CELL_TIME:
        put_cell(output, text_of(cell->value.text_value));
        break;
    default:
        break;
    }
}

/* Adds the sheet with that index as a part. Returns false with the error if it is damaged. */
static bool read_sheet(const struct freexl_api *api, const void *book, unsigned short index,
                       const char *shown, struct contents *contents, struct error *error)
{
    const char *name = NULL;
    unsigned rows = 0;
    unsigned short columns = 0;
    api->freexl_get_worksheet_name(book, index, &name);
    if (api->freexl_select_active_worksheet(book, index) != FREEXL_OK ||
        api->freexl_worksheet_dimensions(book, &rows, &columns) != FREEXL_OK)
        return true;
    struct container_part *part = contents_add(contents, text_of(name ? name : ""));
    if (!part)
        return contents->parts == PARTS_MAX || error_memory(error);
    buffer_put(&part->text, TEXT(""));
    for (unsigned row = 0; row < rows && !part->text.failed; row++) {
        if (!unpacking_goes_on(contents->cancel, error))
            return false;
        for (unsigned short column = 0; column < columns; column++) {
            FreeXL_CellValue cell;
            if (column > 0)
                buffer_char(&part->text, '\t');
            const int status = api->freexl_get_cell_value(book, row, column, &cell);
            if (status == FREEXL_OK)
                cell_value_put(&part->text, &cell);
            else if (status != FREEXL_ILLEGAL_CELL_ROW_COL)
                return error_set(error, ERROR_IO, "%s is damaged: row %u of its sheet %d", shown,
                                 row + 1, index + 1);
        }
        buffer_char(&part->text, '\n');
    }
    return !part->text.failed || error_memory(error);
}

/* Opens the file by FreeXL and reads each sheet. */
bool workbook_old_sheets(const char *path, const char *shown, struct contents *contents,
                         struct error *error)
{
    struct freexl_api api;
    const void *book = NULL;
    unsigned sheets = 0, password = FREEXL_BIFF_PLAIN;
    if (!load_freexl_library(&api, shown, error))
        return false;
    bool done = api.freexl_open(path, &book) == FREEXL_OK;
    if (!done) {
        error_set(error, ERROR_IO, "%s is not a readable Excel workbook (.xls), or is cut short",
                  shown);
        error_hint(error, "open it in the program that made it and save it as .xlsx or CSV");
    } else if (!book) { /* bug of FreeXL 1.0.6, which returns success without a workbook */
        error_set(error, ERROR_IO,
                  "FreeXL cannot read %s and reports no error; empty text cells, as phyphox writes "
                  "them, cause this",
                  shown);
        done = error_hint(error, "export CSV instead, or open it and save it as .xlsx");
    } else {
        api.freexl_get_info(book, FREEXL_BIFF_PASSWORD, &password);
        api.freexl_get_info(book, FREEXL_BIFF_SHEET_COUNT, &sheets);
        if (password == FREEXL_BIFF_OBFUSCATED)
            done = error_set(error, ERROR_IO, "%s is locked by a password", shown);
        for (unsigned i = 0; i < sheets && i < PARTS_MAX && done; i++)
            done = read_sheet(&api, book, (unsigned short)i, shown, contents, error);
        if (done && contents->parts == 0)
            done = error_set(error, ERROR_IO, "%s is a workbook without sheets", shown);
    }
    if (book)
        api.freexl_close(book);
    library_unload(&api.library);
    return done;
}
#else
/* Opens the .xls file at path by FreeXL and adds each sheet as a part. `shown` is the name for
 * messages. Returns false with the error. */
bool workbook_old_sheets(const char *path, const char *shown, struct contents *contents,
                         struct error *error)
{
    (void)path, (void)contents;
    error_set(error, ERROR_IO,
              "%s is an Excel workbook (.xls), and this hooke was built without FreeXL", shown);
    return error_hint(error,
                      "install libfreexl-dev and build it again, or save it as .xlsx or CSV");
}
#endif
