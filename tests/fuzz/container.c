/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Any bytes as a file with others in it: archives, workbooks, XML documents. The first byte says
 * what the rest is: the file itself, or what stands in a whole one, so that checksums and
 * directories are right. Where a library is absent the file is refused, which is all that is tried.
 */
#define CORPUS "container"
#define UNIT "files"
#define FUZZ_SEEDS
#include "fuzz/replay.h"
#include "fuzz/loaded.h"
#include "modules/recording/data/archive_writers.h"

enum kind { ITSELF, GZIP, ZIP, ZIP_OF_GZIP, OPEN_DOCUMENT, SHEET, STRINGS, WORKBOOK, KINDS };

static const char sheet[] =
    "<worksheet><sheetData><row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" "
    "t=\"s\"><v>1</v>"
    "</c></row><row r=\"2\"><c r=\"A2\" s=\"1\"><v>0</v></c><c r=\"B2\"><v>1.5</v></c></row>"
    "<row r=\"3\"><c r=\"A3\"><v>0.02</v></c><c r=\"B3\"><v>2.5</v></c></row><row r=\"4\"><c "
    "r=\"A4\">"
    "<v>0.04</v></c><c r=\"B4\" "
    "t=\"inlineStr\"><is><t>3.5</t></is></c></row></sheetData></worksheet>";

static const char content[] =
    "<office:document-content><office:body><office:spreadsheet><table:table table:name=\"Swing\">"
    "<table:table-row><table:table-cell><text:p>Time (s)</text:p></table:table-cell>"
    "<table:table-cell><text:p>Position (cm)</text:p></table:table-cell></table:table-row>"
    "<table:table-row table:number-rows-repeated=\"3\"><table:table-cell "
    "office:value-type=\"float\" office:value=\"0.02\"/><table:table-cell "
    "table:number-columns-repeated=\"2\" office:value-type=\"float\" office:value=\"1.5\"/>"
    "</table:table-row></table:table></office:spreadsheet></office:body>"
    "</office:document-content>";

static void wrap(enum kind kind, const char *text, struct buffer *out)
{
    struct buffer inner = {0};
    const struct file tables[] = {{"a.csv", text}, {"b/c.txt", table}};
    const struct file document[] = {{"mimetype", "application/vnd.oasis.opendocument.spreadsheet"},
                                    {"content.xml", text}};
    const struct file workbook[] = {
        {"xl/workbook.xml", kind == WORKBOOK
                                ? text
                                : "<workbook xmlns:r=\"x\"><sheets><sheet name=\"S\" sheetId=\"1\" "
                                  "r:id=\"rId1\"/></sheets></workbook>"},
        {"xl/_rels/workbook.xml.rels",
         "<Relationships><Relationship Id=\"rId1\" Target=\"worksheets/s.xml\"/></Relationships>"},
        {"xl/sharedStrings.xml",
         kind == STRINGS ? text : "<sst><si><t>Time (s)</t></si><si><t>y (cm)</t></si></sst>"},
        {"xl/worksheets/s.xml", kind == SHEET ? text : sheet}};
    switch (kind) {
    case GZIP:
        put_gzip(out, text_of(text));
        break;
    case ZIP:
        put_zip(out, tables, COUNT_OF(tables));
        break;
    case ZIP_OF_GZIP:
        put_zip(&inner, tables, COUNT_OF(tables));
        put_gzip(out, buffer_text(&inner));
        break;
    case OPEN_DOCUMENT:
        put_zip(out, document, COUNT_OF(document));
        break;
    default:
        put_zip(out, workbook, COUNT_OF(workbook));
    }
    buffer_free(&inner);
}

/* What each kind holds when it is right, then whole files. */
size_t fuzz_seed(size_t i, uint8_t *data, size_t max)
{
    static const char *const inner[] = {[ITSELF] = cmbl,
                                        [GZIP] = table,
                                        [ZIP] = table,
                                        [ZIP_OF_GZIP] = table,
                                        [OPEN_DOCUMENT] = content,
                                        [SHEET] = sheet,
                                        [STRINGS] = "<sst><si><t>Time (s)</t></si></sst>",
                                        [WORKBOOK] = "<workbook><sheets/></workbook>",
                                        [KINDS] = labx};
    struct buffer file = {0};
    if (i > 2 * KINDS)
        return 0;
    buffer_char(&file, (char)(i < KINDS ? i : ITSELF));
    if (i <= KINDS)
        buffer_put(&file, text_of(inner[i]));
    else if (i == 2 * KINDS)
        put_workbook(&file, sheet);
    else
        wrap((enum kind)(i - KINDS), inner[i - KINDS], &file);
    const size_t len = file.len < max ? file.len : max;
    memcpy(data, file.data, len);
    buffer_free(&file);
    return len;
}

#define FUZZ_MUTATOR
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
    uint64_t random = seed * 2654435761u + 88172645463325252u;
    if (size < 2 || fuzz_random(&random) % 64 == 0)
        return fuzz_seed((size_t)(fuzz_random(&random) % (2 * KINDS + 1)), data, max);
    return LLVMFuzzerMutate(data, size, max);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct buffer text = {0}, file = {0};
    if (size < 1)
        return 0;
    const enum kind kind = data[0] % KINDS;
    buffer_put(&text, (struct text){(const char *)data + 1, size - 1});
    if (kind == ITSELF)
        load(buffer_view(&text), text.len);
    else
        wrap(kind, buffer_view(&text), &file);
    if (kind != ITSELF)
        load(file.data, file.len);
    buffer_free(&text);
    buffer_free(&file);
    return 0;
}
