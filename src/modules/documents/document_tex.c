/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/base/number.h>
#include "modules/documents/document.h"

#include <string.h>

/* ---- escaping ---- */

/* Signs that mean something to TeX, those that its oldest fonts lack, and what would join to a dash
 * or be read as the argument of the line end before it. */
void buffer_latex(struct buffer *out, struct text text)
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
    buffer_replaced(out, text, signs, COUNT_OF(signs));
}

void buffer_tex(struct buffer *out, struct text text)
{
    struct buffer known = {0};
    for (size_t i = 0; i < text.len; i++) {
        const unsigned char c = (unsigned char)text.at[i];
        buffer_char(&known, c < 0x20 ? ' ' : c >= 0xC4 ? '?' : text.at[i]);
        while (c >= 0xC4 && i + 1 < text.len && ((unsigned char)text.at[i + 1] & 0xC0) == 0x80)
            i++; /* the rest of a letter beyond Latin-1 */
    }
    buffer_latex(out, buffer_text(&known));
    out->failed |= known.failed;
    buffer_free(&known);
}

void put_tex_code(struct buffer *out, struct text code)
{
    struct text line;
    buffer_put(out, TEXT("\n{\\ttfamily\\scriptsize\\raggedright\n"));
    while (text_split(&code, '\n', &line)) {
        size_t blanks = 0;
        while (blanks < line.len && line.at[blanks] == ' ')
            blanks++;
        buffer_put(out, TEXT("\\mbox{}"));
        for (size_t i = 0; i < blanks; i++)
            buffer_char(out, '~');
        buffer_tex(out, (struct text){line.at + blanks, line.len - blanks});
        buffer_put(out, TEXT("\\par\n"));
    }
    buffer_put(out, TEXT("}\n"));
}

/* ---- values ---- */

static void put_unit(struct buffer *out, struct text name)
{
    static const struct {
        const char *name, *tex;
    } units[] = {{"m", "\\metre"},    {"s", "\\second"}, {"g", "\\gram"}, {"N", "\\newton"},
                 {"J", "\\joule"},    {"W", "\\watt"},   {"V", "\\volt"}, {"Hz", "\\hertz"},
                 {"rad", "\\radian"}, {"Pa", "\\pascal"}},
      prefixes[] = {{"m", "\\milli"}, {"c", "\\centi"}, {"k", "\\kilo"}, {"u", "\\micro"}};
    for (size_t i = 0; i < COUNT_OF(units); i++)
        if (text_is(name, units[i].name)) {
            buffer_put(out, text_of(units[i].tex));
            return;
        }
    for (size_t i = 0; name.len > 1 && i < COUNT_OF(prefixes); i++)
        if (name.at[0] == prefixes[i].name[0]) {
            buffer_put(out, text_of(prefixes[i].tex));
            put_unit(out, (struct text){name.at + 1, name.len - 1});
            return;
        }
    buffer_put(out, TEXT("\\text{"));
    buffer_tex(out, name);
    buffer_char(out, '}');
}

/* "kg/m^3": factors, each behind * or /. */
static void put_units(struct buffer *out, struct text units)
{
    bool per = false;
    while (units.len > 0) {
        size_t len = 0;
        while (len < units.len && !strchr("*/^", units.at[len]))
            len++;
        const struct text name = {units.at, len};
        if (!text_is(name, "1")) {
            buffer_put(out, per ? TEXT("\\per") : TEXT(""));
            put_unit(out, name);
        }
        if (len + 1 < units.len && units.at[len] == '^') {
            buffer_put(out, units.at[len + 1] == '2' ? TEXT("\\squared") : TEXT("\\cubed"));
            len += 2;
        }
        per = len < units.len && units.at[len] == '/';
        len += len < units.len;
        units = (struct text){units.at + len, units.len - len};
    }
}

void buffer_siunitx(struct buffer *out, struct text measured)
{
    size_t end = measured.len; /* of the number */
    while (end > 0 && measured.at[end - 1] != ' ')
        end--;
    double ignored;
    const struct text last = {measured.at + end, measured.len - end};
    const bool has_unit = end > 0 && real_parse(last, &ignored) != REAL_OK;
    const struct text number = {measured.at, has_unit ? end - 1 : measured.len};
    buffer_put(out, has_unit ? TEXT("\\SI{") : TEXT("\\num{"));
    buffer_put(out, number);
    buffer_char(out, '}');
    if (!has_unit)
        return;
    buffer_char(out, '{');
    put_units(out, last);
    buffer_char(out, '}');
}

/* ---- tables ---- */

bool begin_longtable(struct buffer *out, size_t from, int columns)
{
    struct buffer heading = {0};
    if (from <= out->len && out->data)
        buffer_put(&heading, (struct text){out->data + from, out->len - from});
    out->len = from;
    buffer_put(out,
               TEXT("\n{\\footnotesize\\setlength{\\tabcolsep}{3pt}\n\\begin{longtable}[l]{@{}"));
    if (columns == 5) /* of long texts */
        buffer_put(out, TEXT(">{\\raggedright}p{3.5cm}l>{\\raggedright}p{1.7cm}"
                             ">{\\raggedright}p{3.4cm}>{\\raggedright\\arraybackslash}p{3.4cm}"));
    for (int i = 0; columns != 5 && i < columns; i++)
        buffer_char(out, 'l');
    buffer_put(out, TEXT("@{}}\n\\toprule\n"));
    buffer_put(out, buffer_text(&heading));
    buffer_put(out, TEXT("\\midrule\n\\endhead\n"));
    const bool ok = !heading.failed;
    buffer_free(&heading);
    return ok;
}
