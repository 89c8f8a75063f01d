/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes documents in three markups at once: Markdown, HTML and LaTeX. Blocks are opened and
 * closed; text that users have entered goes through document_name() and is always escaped. */
#include <hooke/base/safe_text.h>
#include "modules/documents/document.h"

#include <string.h>

static const struct {
    const char *md, *md_end, *html, *html_end, *tex, *tex_end;
} blocks[] = {
    [BLOCK_TITLE] = {"# ", "\n\n", "<h1>", "</h1>\n", "\\begin{center}\\LARGE ", "\\end{center}\n"},
    [BLOCK_PART] = {"## ", "\n\n", "<h2>", "</h2>\n", "\n\\section*{", "}\n"},
    [BLOCK_SECTION] = {"### ", "\n\n", "<h3>", "</h3>\n", "\n\\subsection*{", "}\n"},
    [BLOCK_QUESTION] = {"#### ", "\n\n", "<h4>", "</h4>\n", "\n\\subsubsection*{", "}\n"},
    [BLOCK_TOGETHER] = {"", "", "<section>\n", "</section>\n", "", ""},
    [BLOCK_PARAGRAPH] = {"", "\n\n", "<p>", "</p>\n", "\n", "\n\n"},
    [BLOCK_LIST] = {"", "\n", "<ul>\n", "</ul>\n", "\\begin{itemize}\n", "\\end{itemize}\n"},
    [BLOCK_ITEM] = {"- ", "\n", "<li>", "</li>\n", "\\item ", "\n"},
    [BLOCK_TABLE] = {"", "\n", "<table>\n<thead>\n", "</tbody>\n</table>\n", "",
                     "\\bottomrule\n\\end{longtable}\n}\n"},
    [BLOCK_ROW] = {"|", "\n", "<tr>", "</tr>\n", "", "\\\\\n"},
    [BLOCK_CELL] = {" ", " |", "<td>", "</td>", "", ""},
    [BLOCK_HEAD] = {" ", " |", "<th>", "</th>", "", ""},
};

#define TEMPLATE_TEXT(id, name, says, explains, lines, others)                                     \
    const char document_##id[] = lines "\n";
#include "texts/modules/documents/templates.def"

/* ---- escaping ---- */

/* Appends text with the given signs replaced. */
void buffer_replaced(struct buffer *output, struct text text, const struct sign *signs,
                     size_t count)
{
    for (size_t i = 0; i < text.len; i++) {
        struct text as = {text.data + i, 1};
        for (size_t k = 0; k < count; k++)
            as = signs[k].c == text.data[i] ? text_of(signs[k].as) : as;
        buffer_put(output, as);
    }
}

void buffer_html(struct buffer *output, struct text text)
{
    static const struct sign signs[] = {
        {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}};
    buffer_replaced(output, text, signs, COUNT_OF(signs));
}

/* Appends text with the characters escaped that Markdown interprets. */
void buffer_markdown(struct buffer *output, struct text text)
{
    for (size_t i = 0; i < text.len; i++) {
        if (strchr("\\`*_<>[]|#~&", text.data[i]))
            buffer_char(output, '\\');
        buffer_char(output, text.data[i]);
    }
}

/* Returns the length of the longest run of a character. */
static size_t longest_run(struct text text, char c)
{
    size_t longest = 0, run = 0;
    for (size_t i = 0; i < text.len; i++) {
        run = text.data[i] == c ? run + 1 : 0;
        longest = run > longest ? run : longest;
    }
    return longest;
}

static void put_many(struct buffer *output, char c, size_t count)
{
    while (count-- > 0)
        buffer_char(output, c);
}

/* ---- the document ---- */

/* Writes the beginning of the three formats (Markdown, HTML, LaTeX), with the title, which is
 * escaped. */
void document_begin(struct document *document, const char *title)
{
    buffer_put(
        &document->html,
        TEXT("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
             "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>"));
    buffer_html(&document->html, text_of(title));
    buffer_put(&document->html, TEXT("</title>\n<style>\n"));
    buffer_put(&document->html, text_of(document_style));
    buffer_put(&document->html, TEXT("</style>\n</head>\n<body>\n"));
    buffer_put(&document->tex, text_of(document_preamble));
    document_put(document, BLOCK_TITLE, title);
}

void document_end(struct document *document)
{
    buffer_put(&document->html, TEXT("</body>\n</html>\n"));
    buffer_put(&document->tex, TEXT("\\end{document}\n"));
}

void document_free(struct document *document)
{
    buffer_free(&document->md);
    buffer_free(&document->html);
    buffer_free(&document->tex);
}

/* Opens a block. In LaTeX a cell that is not the first of its row is preceded by "&"; the place
 * after the opening of a table is noted in document->table, since the columns of a long table are
 * known only once its heading has been written (document->heads counts them). */
void document_open(struct document *document, enum block block)
{
    document->in_table |= block == BLOCK_TABLE;
    document->heads = block == BLOCK_TABLE ? 0 : document->heads + (block == BLOCK_HEAD);
    buffer_put(&document->md, text_of(blocks[block].md));
    buffer_put(&document->html, text_of(blocks[block].html));
    const bool cell = block == BLOCK_CELL || block == BLOCK_HEAD;
    document->cells = block == BLOCK_ROW ? 0 : document->cells + cell;
    buffer_put(&document->tex, cell && document->cells > 1 ? TEXT(" & ") : TEXT(""));
    buffer_put(&document->tex, text_of(blocks[block].tex));
    if (block == BLOCK_TABLE)
        document->table = document->tex.len;
}

/* Closes a block. */
void document_close(struct document *document, enum block block)
{
    document->in_table &= block != BLOCK_TABLE;
    buffer_put(&document->md, text_of(blocks[block].md_end));
    buffer_put(&document->html, text_of(blocks[block].html_end));
    buffer_put(&document->tex, text_of(blocks[block].tex_end));
}

/* Appends words of the program, escaped, to Markdown, HTML and, if `tex` is set, LaTeX. "+-"
 * becomes the sign. */
static void document_words_put(struct document *document, struct text words, bool tex)
{
    struct buffer text = {0};
    for (size_t i = 0; i < words.len; i++)
        if (words.data[i] == '+' && i + 1 < words.len && words.data[i + 1] == '-')
            buffer_codepoint(&text, 0xB1), i++;
        else
            buffer_char(&text, words.data[i]);
    buffer_markdown(&document->md, buffer_text(&text));
    buffer_html(&document->html, buffer_text(&text));
    if (tex)
        buffer_tex(&document->tex, buffer_text(&text));
    document->md.failed |= text.failed;
    buffer_free(&text);
}

/* Writes formatted words of the program, escaped for each markup. */
void document_say(struct document *document, const char *format, ...)
{
    struct buffer words = {0};
    va_list args;
    va_start(args, format);
    buffer_vformat(&words, format, args);
    va_end(args);
    document_words_put(document, buffer_text(&words), true);
    document->md.failed |= words.failed;
    buffer_free(&words);
}

/* Writes a value with `digits` significant digits, its uncertainty and its unit, escaped, in
 * Markdown and HTML, and as a command of siunitx in LaTeX. */
void document_measured(struct document *document, struct measured value, enum quantity quantity,
                       int digits)
{
    struct buffer words = {0};
    buffer_measured(&words, value, quantity, digits);
    document_words_put(document, buffer_text(&words), false);
    buffer_siunitx(&document->tex, buffer_text(&words));
    document->md.failed |= words.failed;
    buffer_free(&words);
}

/* Writes a name that users chose, marked as code, to all formats of the document. In Markdown it is
 * enclosed in one backtick more than the longest run in it, so that it cannot end its own
 * quotation; in a table cell bars are escaped, since they would end the cell even there. */
void document_name(struct document *document, struct text name)
{
    struct buffer safe = {0};
    safe_text(&safe, name, false);
    const struct text text = buffer_text(&safe);
    const size_t ticks = longest_run(text, '`') + 1;
    put_many(&document->md, '`', ticks);
    buffer_put(&document->md, ticks > 1 ? TEXT(" ") : TEXT(""));
    for (size_t i = 0; i < text.len; i++) {
        buffer_put(&document->md,
                   document->in_table && text.data[i] == '|' ? TEXT("\\") : TEXT(""));
        buffer_char(&document->md, text.data[i]);
    }
    buffer_put(&document->md, ticks > 1 || text.len == 0 ? TEXT(" ") : TEXT(""));
    put_many(&document->md, '`', ticks);
    buffer_put(&document->html, TEXT("<code>"));
    buffer_html(&document->html, text);
    buffer_put(&document->html, TEXT("</code>"));
    buffer_put(&document->tex, TEXT("\\texttt{"));
    buffer_tex(&document->tex, text);
    buffer_char(&document->tex, '}');
    document->md.failed |= safe.failed;
    buffer_free(&safe);
}

/* Writes a link to a file. */
void document_link(struct document *document, const char *file, const char *words)
{
    buffer_format(&document->md, "[%s](%s)", words, file);
    buffer_format(&document->html, "<a href=\"%s\">%s</a>", file, words);
    buffer_put(&document->tex, TEXT("\\texttt{"));
    buffer_tex(&document->tex, text_of(words));
    buffer_char(&document->tex, '}');
}

void document_put(struct document *document, enum block block, const char *words)
{
    document_open(document, block);
    document_say(document, "%s", words);
    document_close(document, block);
}

/* Closes the first row of a table as its heading: adds the line of dashes in Markdown and the begin
 * of the body in HTML. LaTeX needs the number of columns before the heading, so its table is opened
 * here, at the position that document->table remembers. */
void document_heading_ends(struct document *document)
{
    document_close(document, BLOCK_ROW);
    buffer_char(&document->md, '|');
    for (int i = 0; i < document->heads; i++)
        buffer_put(&document->md, TEXT("---|"));
    buffer_char(&document->md, '\n');
    buffer_put(&document->html, TEXT("</thead>\n<tbody>\n"));
    document->tex.failed |= !begin_longtable(&document->tex, document->table, document->heads);
}

/* Writes a figure: Markdown refers to its files, HTML contains it, LaTeX includes the PDF or, if
 * there is none, the text. */
void document_figure(struct document *document, const struct document_picture *picture)
{
    buffer_put(&document->md, TEXT("!["));
    buffer_markdown(&document->md, text_of(picture->alternative));
    buffer_format(&document->md, "](%s.svg)\n\n[The same as text](%s.txt)\n\n", picture->name,
                  picture->name);
    buffer_put(&document->html, TEXT("<figure><img alt=\""));
    buffer_html(&document->html, text_of(picture->alternative));
    buffer_put(&document->html, TEXT("\" src=\"data:image/svg+xml;base64,"));
    buffer_base64(&document->html, picture->svg);
    buffer_put(&document->html,
               TEXT("\"></figure>\n<details><summary>The same as text</summary>\n<pre>"));
    buffer_html(&document->html, picture->text);
    buffer_put(&document->html, TEXT("</pre>\n</details>\n"));
    if (picture->pdf)
        buffer_format(&document->tex,
                      "\n\\begin{center}\n\\includegraphics[width=0.8\\linewidth]{%s.pdf}\n"
                      "\\end{center}\n",
                      picture->name);
    else
        put_tex_code(&document->tex, picture->text);
}

/* Writes a block of preformatted text. In Markdown the fence has three backticks more than the
 * longest run of them in the text, so that the text cannot end it. */
void document_code(struct document *document, struct text code)
{
    const size_t ticks = longest_run(code, '`') + 3;
    const bool ends = code.len > 0 && code.data[code.len - 1] == '\n';
    put_many(&document->md, '`', ticks);
    buffer_char(&document->md, '\n');
    buffer_put(&document->md, code);
    buffer_put(&document->md, ends ? TEXT("") : TEXT("\n"));
    put_many(&document->md, '`', ticks);
    buffer_put(&document->md, TEXT("\n\n"));
    buffer_put(&document->html, TEXT("<pre>"));
    buffer_html(&document->html, code);
    buffer_put(&document->html, TEXT("</pre>\n"));
    put_tex_code(&document->tex, code);
}

void document_answer(struct document *document)
{
    buffer_put(&document->md, TEXT("Answer:\n\n&nbsp;\n\n"));
    buffer_put(&document->html, TEXT("<div class=\"answer\"></div>\n"));
    buffer_put(&document->tex, TEXT("\n\\noindent Answer:\\par\\vspace{3cm}\n"));
}
