/* SPDX-License-Identifier: GPL-3.0-or-later */
/* LaTeX of documents: escaping, preformatted text, values with units for siunitx, tables. */
#include <hooke/base/number.h>
#include "modules/documents/document.h"

#include <string.h>

/* ---- escaping ---- */

/* Appends text as LaTeX: replaces characters that TeX interprets or its oldest fonts lack, and
 * those that would form a dash (-) or be read as the argument of the preceding line end ([ and *).
 */
void buffer_latex(struct buffer *output, struct text text)
{
    static const struct sign signs[] = {
        {'\\', "\\textbackslash{}"},
        {'{', "\\{"},
        {'}', "\\}"},
        {'$', "\\$"},
        {'&', "\\&"},
        {'#', "\\#"},
        {'_', "\\_"},
        {'%', "\\%"},
        {'^', "\\textasciicircum{}"},
        {'~', "\\textasciitilde{}"},
        {'<', "\\textless{}"},
        {'>', "\\textgreater{}"},
        {'|', "\\textbar{}"},
        {'"', "\\textquotedbl{}"},
        {'\'', "\\textquotesingle{}"},
        {'`', "\\textasciigrave{}"},
        {'-', "{-}"},
        {'[', "{[}"},
        {'*', "{*}"},
    };
    buffer_replaced(output, text, signs, COUNT_OF(signs));
}

/* Appends text (UTF-8) escaped for LaTeX; control characters become blanks, letters beyond Latin-1,
 * whose first byte is 0xC4 or more, one question mark each. */
void buffer_tex(struct buffer *output, struct text text)
{
    struct buffer known = {0};
    for (size_t i = 0; i < text.len; i++) {
        const unsigned char c = (unsigned char)text.data[i];
        char shown;
        if (c < 0x20)
            shown = ' ';
        else if (c >= 0xC4)
            shown = '?';
        else
            shown = text.data[i];
        buffer_char(&known, shown);
        while (c >= 0xC4 && i + 1 < text.len && ((unsigned char)text.data[i + 1] & 0xC0) == 0x80)
            i++; /* further bytes of a letter beyond Latin-1 */
    }
    buffer_latex(output, buffer_text(&known));
    output->failed |= known.failed;
    buffer_free(&known);
}

/* Appends preformatted text, line by line in a font of equal widths. Leading blanks are kept as "~"
 * after an empty box, since TeX drops blanks at the start of a line. */
void put_tex_code(struct buffer *output, struct text code)
{
    struct text line;
    buffer_put(output, TEXT("\n{\\ttfamily\\scriptsize\\raggedright\n"));
    while (text_split(&code, '\n', &line)) {
        size_t blanks = 0;
        while (blanks < line.len && line.data[blanks] == ' ')
            blanks++;
        buffer_put(output, TEXT("\\mbox{}"));
        for (size_t i = 0; i < blanks; i++)
            buffer_char(output, '~');
        buffer_tex(output, text_after(line, blanks));
        buffer_put(output, TEXT("\\par\n"));
    }
    buffer_put(output, TEXT("}\n"));
}

/* ---- values ---- */

/* Appends a unit in siunitx: prefix and name ("mm" as \\milli\\metre), or the text itself if it is
 * unknown. Units are compared first, so that "m" is a metre. */
static void put_unit(struct buffer *output, struct text name)
{
    static const struct {
        const char *name, *tex;
    } units[] = {{"m", "\\metre"},    {"s", "\\second"}, {"g", "\\gram"}, {"N", "\\newton"},
                 {"J", "\\joule"},    {"W", "\\watt"},   {"V", "\\volt"}, {"Hz", "\\hertz"},
                 {"rad", "\\radian"}, {"Pa", "\\pascal"}},
      prefixes[] = {{"m", "\\milli"}, {"c", "\\centi"}, {"k", "\\kilo"}, {"u", "\\micro"}};
    for (size_t i = 0; i < COUNT_OF(units); i++)
        if (text_is(name, units[i].name)) {
            buffer_put(output, text_of(units[i].tex));
            return;
        }
    for (size_t i = 0; name.len > 1 && i < COUNT_OF(prefixes); i++)
        if (name.data[0] == prefixes[i].name[0]) {
            buffer_put(output, text_of(prefixes[i].tex));
            put_unit(output, text_after(name, 1));
            return;
        }
    buffer_put(output, TEXT("\\text{"));
    buffer_tex(output, name);
    buffer_char(output, '}');
}

/* Writes units such as "kg/m^3": factors separated by * or /. A / divides by the next factor only,
 * and a 1 (as in "1/s") is left out. Powers are 2 or 3. */
static void put_units(struct buffer *output, struct text units)
{
    bool is_denominator = false;
    while (units.len > 0) {
        size_t len = 0;
        while (len < units.len && !strchr("*/^", units.data[len]))
            len++;
        const struct text name = {units.data, len};
        if (!text_is(name, "1")) {
            buffer_put(output, is_denominator ? TEXT("\\per") : TEXT(""));
            put_unit(output, name);
        }
        if (len + 1 < units.len && units.data[len] == '^') {
            buffer_put(output, units.data[len + 1] == '2' ? TEXT("\\squared") : TEXT("\\cubed"));
            len += 2;
        }
        is_denominator = len < units.len && units.data[len] == '/';
        len += len < units.len;
        units = text_after(units, len);
    }
}

/* Appends "15.100 +- 0.008 N/m" as \\SI{15.100 +- 0.008}{\\newton\\per\\metre}. The last word is
 * the unit unless it is a number; then \\num{...} is written. */
void buffer_siunitx(struct buffer *output, struct text measured)
{
    size_t end = measured.len; /* end of the number */
    while (end > 0 && measured.data[end - 1] != ' ')
        end--;
    double ignored;
    const struct text last = {measured.data + end, measured.len - end};
    const bool has_unit = end > 0 && real_parse(last, &ignored) != REAL_OK;
    const struct text number = {measured.data, has_unit ? end - 1 : measured.len};
    buffer_put(output, has_unit ? TEXT("\\SI{") : TEXT("\\num{"));
    buffer_put(output, number);
    buffer_char(output, '}');
    if (!has_unit)
        return;
    buffer_char(output, '{');
    put_units(output, last);
    buffer_char(output, '}');
}

/* ---- tables ---- */

/* Inserts the beginning of a long table at position `begin` of the output, before its heading,
 * which is all that has been written since and is to be repeated on each page. Tables with 5
 * columns are those of long texts, which need columns of fixed widths. Returns false if out of
 * memory. */
bool begin_longtable(struct buffer *output, size_t begin, int columns)
{
    struct buffer heading = {0};
    if (begin <= output->len && output->data)
        buffer_put(&heading, (struct text){output->data + begin, output->len - begin});
    output->len = begin;
    buffer_put(output,
               TEXT("\n{\\footnotesize\\setlength{\\tabcolsep}{3pt}\n\\begin{longtable}[l]{@{}"));
    if (columns == 5) /* a table of long texts */
        buffer_put(output,
                   TEXT(">{\\raggedright}p{3.5cm}l>{\\raggedright}p{1.7cm}"
                        ">{\\raggedright}p{3.4cm}>{\\raggedright\\arraybackslash}p{3.4cm}"));
    for (int i = 0; columns != 5 && i < columns; i++)
        buffer_char(output, 'l');
    buffer_put(output, TEXT("@{}}\n\\toprule\n"));
    buffer_put(output, buffer_text(&heading));
    buffer_put(output, TEXT("\\midrule\n\\endhead\n"));
    const bool ok = !heading.failed;
    buffer_free(&heading);
    return ok;
}
