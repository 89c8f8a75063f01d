/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes text safe to print on a terminal: control characters and hidden code points become visible
 * escapes. */
#include <hooke/base/safe_text.h>
#include "base/internal.h"

#include <stdio.h>
#include <string.h>

/* Code points that are invisible or change how other text is shown: Unicode's Cc, Zl, Zp and those
 * of Cf that reorder, join or hide. */
static const struct {
    uint32_t first, last;
} hidden_ranges[] = {
    {0x0080, 0x009F}, {0x00AD, 0x00AD},   {0x061C, 0x061C},   {0x115F, 0x1160},
    {0x180E, 0x180E}, {0x200B, 0x200F},   {0x2028, 0x202E},   {0x2060, 0x206F},
    {0x3164, 0x3164}, {0xFDD0, 0xFDEF},   {0xFEFF, 0xFEFF},   {0xFFA0, 0xFFA0},
    {0xFFF0, 0xFFFB}, {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE0FFF},
};

/* Returns true for hidden code points and for the noncharacters U+xxFFFE and U+xxFFFF. */
bool codepoint_hidden(uint32_t codepoint)
{
    if ((codepoint & 0xFFFE) == 0xFFFE)
        return true;
    for (size_t i = 0; i < COUNT_OF(hidden_ranges); i++)
        if (codepoint >= hidden_ranges[i].first && codepoint <= hidden_ranges[i].last)
            return true;
    return false;
}

/* Returns the first character of text as it is shown, in piece if it has to be escaped. Sets *used
 * to the number of bytes that it stands for. */
static struct text visible_text(struct text text, bool keep_layout, char piece[16], size_t *used)
{
    const uint32_t codepoint = text_codepoint(text, used);
    const unsigned char byte = (unsigned char)text.data[0];
    const bool invalid = codepoint == CODEPOINT_INVALID && *used == 1;
    int len;
    if (keep_layout && (byte == '\n' || byte == '\t'))
        return (struct text){text.data, 1};
    if (invalid || codepoint < 0x20 || codepoint == 0x7F)
        len = snprintf(piece, 16, "\\x%02x", byte);
    else if (codepoint_hidden(codepoint))
        len = snprintf(piece, 16, "<U+%04X>", (unsigned)codepoint);
    else
        return (struct text){text.data, *used};
    return (struct text){piece, (size_t)len};
}

/* Appends the text with hidden and control characters made visible; keep_layout leaves newlines and
 * tabs. Runs of plain ASCII are copied at once. */
void safe_text(struct buffer *output, struct text text, bool keep_layout)
{
    char piece[16];
    for (size_t used; text.len > 0; text.data += used, text.len -= used) {
        for (used = 0; used < text.len && text.data[used] >= ' ' && text.data[used] < 0x7F;)
            used++;
        buffer_put(output, used > 0 ? (struct text){text.data, used}
                                    : visible_text(text, keep_layout, piece, &used));
    }
}

/* Writes the name to output with hidden characters made visible; one that is too long ends with
 * "...". Returns output. */
const char *safe_name(struct text name, char output[SAFE_NAME_SIZE])
{
    char piece[16];
    size_t len = 0;
    for (size_t used; name.len > 0; name.data += used, name.len -= used) {
        struct text shown = visible_text(name, false, piece, &used);
        if (len + shown.len > SAFE_NAME_SIZE - 4) {
            shown = TEXT("...");
            used = name.len;
        }
        memcpy(output + len, shown.data, shown.len);
        len += shown.len;
    }
    output[len] = '\0';
    return output;
}
