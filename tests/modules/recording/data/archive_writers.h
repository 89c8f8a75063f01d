/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Archives, workbooks and XML documents, made byte by byte. */
#pragma once

#include <hooke/base/text.h>

#include <string.h>

static const char table[] =
    "Time (s),Position (cm)\n0.00,1.5\n0.02,2.5\n0.04,3.5\n0.06,2.5\n0.08,1.5\n";

/* ---- writers: entries and streams that are stored, not compressed ---- */

static inline uint32_t crc32(struct text bytes)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < bytes.len; i++) {
        crc ^= (unsigned char)bytes.data[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return ~crc;
}

static inline void put_number(struct buffer *out, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        buffer_char(out, (char)((uint64_t)value >> (8 * i) & 0xFF));
}

static inline void put_gzip(struct buffer *out, struct text bytes)
{
    buffer_put(out, (struct text){"\x1F\x8B\x08\0\0\0\0\0\0\xFF", 10});
    for (size_t at = 0; at < bytes.len;) {
        const size_t len = bytes.len - at < 65535 ? bytes.len - at : 65535;
        buffer_char(out, at + len == bytes.len);
        put_number(out, (uint32_t)len, 2);
        put_number(out, ~(uint32_t)len, 2);
        buffer_put(out, (struct text){bytes.data + at, len});
        at += len;
    }
    put_number(out, crc32(bytes), 4);
    put_number(out, (uint32_t)bytes.len, 4);
}

struct file {
    const char *path, *text;
};

static inline void put_zip(struct buffer *out, const struct file *file, size_t files)
{
    struct buffer directory = {0};
    for (size_t i = 0; i < files; i++) {
        const struct text bytes = text_of(file[i].text);
        const uint32_t at = (uint32_t)out->len, len = (uint32_t)bytes.len,
                       name = (uint32_t)strlen(file[i].path);
        struct buffer common = {0};
        put_number(&common, 20, 2);
        put_number(&common, 0, 8);
        put_number(&common, crc32(bytes), 4);
        put_number(&common, len, 4);
        put_number(&common, len, 4);
        put_number(&common, name, 2);
        put_number(&common, 0, 2);
        buffer_put(out, (struct text){"PK\3\4", 4});
        buffer_put(out, buffer_text(&common));
        buffer_format(out, "%s", file[i].path);
        buffer_put(out, bytes);
        buffer_put(&directory, (struct text){"PK\1\2", 4});
        put_number(&directory, 20, 2);
        buffer_put(&directory, buffer_text(&common));
        put_number(&directory, 0, 4);
        put_number(&directory, 0, 2);
        put_number(&directory, 0, 4);
        put_number(&directory, at, 4);
        buffer_format(&directory, "%s", file[i].path);
        buffer_free(&common);
    }
    const uint32_t start = (uint32_t)out->len;
    buffer_put(out, buffer_text(&directory));
    buffer_put(out, (struct text){"PK\5\6\0\0\0\0", 8});
    put_number(out, (uint32_t)files, 2);
    put_number(out, (uint32_t)files, 2);
    put_number(out, (uint32_t)directory.len, 4);
    put_number(out, start, 4);
    put_number(out, 0, 2);
    buffer_free(&directory);
}

static const char cmbl[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\" "
    "?>\n<Document>\n<DataSet>\n<DataSetName>Latest</DataSetName>\n"
    "<DataColumn>\n<DataObjectName>Time</DataObjectName>\n<DataObjectShortName>t</"
    "DataObjectShortName>\n"
    "<ColumnUnits>s</ColumnUnits>\n<ColumnCells>\n0\n0.02\n0.04\n0.06\n0.08\n</ColumnCells>\n</"
    "DataColumn>\n"
    "<DataColumn>\n<DataObjectName>Position</DataObjectName>\n<ColumnUnits>cm</ColumnUnits>\n"
    "<ColumnCells>\n1.5\n2.5\n3.5\n2.5\nZ\n</ColumnCells>\n</DataColumn>\n</DataSet>\n</"
    "Document>\n";

static const char labx[] =
    "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<cassylab version=\"2.0\"><allchannels><channels "
    "count=\"2\">"
    "<channel><quantity>Zeit</quantity><symbol>t</symbol><unit>s</unit><values "
    "count=\"5\"><value>0</value>"
    "<value>0.02</value><value>0.04</value><value>0.06</value><value>0.08</value></values></"
    "channel>"
    "<channel><quantity>Weg</quantity><symbol>s</symbol><unit>cm</unit><values "
    "count=\"5\"><value>1.5</value>"
    "<value>2.5</value><value>3.5</value><value>2.5</value><value>1.5</value></values></channel>"
    "</channels></allchannels></cassylab>\n";

static inline void put_workbook(struct buffer *bytes, const char *sheet)
{
    const struct file files[] = {
        {"[Content_Types].xml", "<Types/>"},
        {"xl/workbook.xml",
         "<workbook xmlns:r=\"x\"><sheets><sheet name=\"Swing\" sheetId=\"1\" r:id=\"rId1\"/>"
         "</sheets></workbook>"},
        {"xl/_rels/workbook.xml.rels",
         "<Relationships><Relationship Id=\"rId1\" Target=\"worksheets/swing.xml\"/>"
         "</Relationships>"},
        {"xl/styles.xml",
         "<styleSheet><numFmts><numFmt numFmtId=\"164\" formatCode=\"hh:mm:ss.000\"/></numFmts>"
         "<cellStyleXfs><xf numFmtId=\"0\"/></cellStyleXfs><cellXfs><xf numFmtId=\"0\"/>"
         "<xf numFmtId=\"164\"/></cellXfs></styleSheet>"},
        {"xl/sharedStrings.xml",
         "<sst><si><t>Time (s)</t></si><si><r><t>Position</t></r><r><t> (cm)</t></r></si></sst>"},
        {"xl/worksheets/swing.xml", sheet},
    };
    put_zip(bytes, files, COUNT_OF(files));
}
