/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "result/outlet.h"

#include <string.h>

static const struct {
    const char *md, *md_end, *html, *html_end;
} blocks[] = {
    [BLOCK_TITLE] = {"# ", "\n\n", "<h1>", "</h1>\n"},
    [BLOCK_PART] = {"## ", "\n\n", "<h2>", "</h2>\n"},
    [BLOCK_SECTION] = {"### ", "\n\n", "<h3>", "</h3>\n"},
    [BLOCK_QUESTION] = {"#### ", "\n\n", "<h4>", "</h4>\n"},
    [BLOCK_TOGETHER] = {"", "", "<section>\n", "</section>\n"},
    [BLOCK_PARAGRAPH] = {"", "\n\n", "<p>", "</p>\n"},
    [BLOCK_LIST] = {"", "\n", "<ul>\n", "</ul>\n"},
    [BLOCK_ITEM] = {"- ", "\n", "<li>", "</li>\n"},
    [BLOCK_TABLE] = {"", "\n", "<table>\n<thead>\n", "</tbody>\n</table>\n"},
    [BLOCK_ROW] = {"|", "\n", "<tr>", "</tr>\n"},
    [BLOCK_CELL] = {" ", " |", "<td>", "</td>"},
    [BLOCK_HEAD] = {" ", " |", "<th>", "</th>"},
};

static const char style[] =
    "@page { size: A4; margin: 18mm }\n"
    "body { font: 11pt/1.45 sans-serif; color: #111; background: #fff; max-width: 46em; margin: "
    "2em auto; "
    "padding: 0 1em }\n"
    "h1 { font-size: 1.6em } h2 { border-bottom: 1px solid #999; margin-top: 2em } h3 { "
    "margin-top: 1.6em }\n"
    "h1, h2, h3, h4 { line-height: 1.25; break-after: avoid }\n"
    "table { border-collapse: collapse; margin: 1em 0; font-size: 0.9em }\n"
    "th, td { border-bottom: 1px solid #ccc; padding: 0.2em 0.9em 0.2em 0; text-align: left; "
    "vertical-align: top }\n"
    "thead th { border-bottom: 1px solid #333 } tr { break-inside: avoid }\n"
    "section { break-inside: avoid } figure { margin: 1.2em 0 0.2em; break-after: avoid; "
    "break-inside: avoid } img { "
    "width: 100%; max-width: 40em; height: auto }\n"
    "pre { font: 8pt/1.15 monospace; overflow: auto }\n"
    "code { font-family: monospace; overflow-wrap: anywhere }\n"
    ".answer { border: 1px solid #bbb; min-height: 7em; margin: 0.5em 0 1.5em}\n"
    "@media print { pre { white-space: pre-wrap } body { margin: 0; padding: 0; max-width: none; "
    "font-size: 10pt } }\n";

/* ---- escaping ---- */

void buffer_html(struct buffer *out, struct text text)
{
    static const struct {
        char c;
        const char *entity;
    } entities[] = {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}};
    for (size_t i = 0; i < text.len; i++) {
        const char *entity = NULL;
        for (size_t e = 0; e < COUNT_OF(entities); e++)
            if (entities[e].c == text.at[i])
                entity = entities[e].entity;
        if (entity)
            buffer_put(out, text_of(entity));
        else
            buffer_char(out, text.at[i]);
    }
}

static void put_md(struct buffer *out, struct text text)
{
    for (size_t i = 0; i < text.len; i++) {
        if (strchr("\\`*_[]<>&|~", text.at[i]))
            buffer_char(out, '\\');
        buffer_char(out, text.at[i]);
    }
}

static size_t longest_run(struct text text, char c)
{
    size_t longest = 0, run = 0;
    for (size_t i = 0; i < text.len; i++) {
        run = text.at[i] == c ? run + 1 : 0;
        longest = run > longest ? run : longest;
    }
    return longest;
}

static void put_many(struct buffer *out, char c, size_t count)
{
    while (count-- > 0)
        buffer_char(out, c);
}

/* ---- the document ---- */

void document_begin(struct document *document, const char *title)
{
    buffer_put(
        &document->html,
        TEXT("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>"));
    buffer_html(&document->html, text_of(title));
    buffer_put(&document->html, TEXT("</title>\n<style>\n"));
    buffer_put(&document->html, TEXT(style));
    buffer_put(&document->html, TEXT("</style>\n</head>\n<body>\n"));
    document_put(document, BLOCK_TITLE, title);
}

void document_end(struct document *document)
{
    buffer_put(&document->html, TEXT("</body>\n</html>\n"));
}

void document_free(struct document *document)
{
    buffer_free(&document->md);
    buffer_free(&document->html);
}

void document_open(struct document *document, enum block block)
{
    document->in_table |= block == BLOCK_TABLE;
    document->heads = block == BLOCK_TABLE ? 0 : document->heads + (block == BLOCK_HEAD);
    buffer_put(&document->md, text_of(blocks[block].md));
    buffer_put(&document->html, text_of(blocks[block].html));
}

void document_close(struct document *document, enum block block)
{
    document->in_table &= block != BLOCK_TABLE;
    buffer_put(&document->md, text_of(blocks[block].md_end));
    buffer_put(&document->html, text_of(blocks[block].html_end));
}

void document_say(struct document *document, const char *format, ...)
{
    struct buffer words = {0}, text = {0};
    va_list args;
    va_start(args, format);
    buffer_vformat(&words, format, args);
    va_end(args);
    for (size_t i = 0; i < words.len; i++)
        if (words.data[i] == '+' && words.data[i + 1] == '-') /* the text ends in NUL */
            buffer_codepoint(&text, 0xB1), i++;
        else
            buffer_char(&text, words.data[i]);
    put_md(&document->md, buffer_text(&text));
    buffer_html(&document->html, buffer_text(&text));
    document->md.failed |= words.failed || text.failed;
    buffer_free(&words);
    buffer_free(&text);
}

/*
 * In Markdown between more backticks than it holds itself, so that it cannot end its own quotation.
 * A table cell ends at a bar even there, unless it is escaped, and the escape is taken away.
 */
void document_name(struct document *document, struct text name)
{
    struct buffer safe = {0};
    safe_text(&safe, name, false);
    const struct text text = buffer_text(&safe);
    const size_t ticks = longest_run(text, '`') + 1;
    put_many(&document->md, '`', ticks);
    buffer_put(&document->md, ticks > 1 ? TEXT(" ") : TEXT(""));
    for (size_t i = 0; i < text.len; i++) {
        buffer_put(&document->md, document->in_table && text.at[i] == '|' ? TEXT("\\") : TEXT(""));
        buffer_char(&document->md, text.at[i]);
    }
    buffer_put(&document->md, ticks > 1 || text.len == 0 ? TEXT(" ") : TEXT(""));
    put_many(&document->md, '`', ticks);
    buffer_put(&document->html, TEXT("<code>"));
    buffer_html(&document->html, text);
    buffer_put(&document->html, TEXT("</code>"));
    document->md.failed |= safe.failed;
    buffer_free(&safe);
}

void document_link(struct document *document, const char *file, const char *words)
{
    buffer_format(&document->md, "[%s](%s)", words, file);
    buffer_format(&document->html, "<a href=\"%s\">%s</a>", file, words);
}

void document_put(struct document *document, enum block block, const char *words)
{
    document_open(document, block);
    document_say(document, "%s", words);
    document_close(document, block);
}

void document_heading_ends(struct document *document)
{
    document_close(document, BLOCK_ROW);
    buffer_char(&document->md, '|');
    for (int i = 0; i < document->heads; i++)
        buffer_put(&document->md, TEXT("---|"));
    buffer_char(&document->md, '\n');
    buffer_put(&document->html, TEXT("</thead>\n<tbody>\n"));
}

void document_figure(struct document *document, const char *picture, const char *alternative,
                     struct text text)
{
    if (!picture) {
        document_code(document, text);
        return;
    }
    buffer_format(&document->md, "![%s](%s)\n\n", alternative, picture);
    buffer_format(&document->html, "<figure><img src=\"%s\" alt=\"%s\"></figure>\n", picture,
                  alternative);
}

void document_code(struct document *document, struct text code)
{
    const size_t ticks = longest_run(code, '`') + 3;
    const bool ends = code.len > 0 && code.at[code.len - 1] == '\n';
    put_many(&document->md, '`', ticks);
    buffer_char(&document->md, '\n');
    buffer_put(&document->md, code);
    buffer_put(&document->md, ends ? TEXT("") : TEXT("\n"));
    put_many(&document->md, '`', ticks);
    buffer_put(&document->md, TEXT("\n\n"));
    buffer_put(&document->html, TEXT("<pre>"));
    buffer_html(&document->html, code);
    buffer_put(&document->html, TEXT("</pre>\n"));
}

void document_answer(struct document *document)
{
    buffer_put(&document->md, TEXT("Answer:\n\n&nbsp;\n\n"));
    buffer_put(&document->html, TEXT("<div class=\"answer\"></div>\n"));
}
