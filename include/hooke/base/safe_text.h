/* SPDX-License-Identifier: GPL-3.0-or-later */
/* safe_text: shows text from files, arguments and errno without letting it command the terminal;
 * decodes UTF-8, and measures and breaks text by its width in terminal columns. */
#pragma once

#include <hooke/base/text.h>

/* Appends a text with everything that could control a terminal made visible: control characters
 * (C0, DEL, C1), invalid UTF-8, line and paragraph separators, and bidirectional and zero-width
 * controls are written as \xNN or <U+NNNN>. With keep_layout, newlines and tabs are left unchanged.
 */
void safe_text(struct buffer *output, struct text text, bool keep_layout);
/* Size [byte] of a name that safe_name() writes, with its NUL. */
#define SAFE_NAME_SIZE 160
/* Writes a name for use in a message: made visible as by safe_text() and shortened with "..." if it
 * does not fit. Returns `output`. */
const char *safe_name(struct text name, char output[SAFE_NAME_SIZE]);
/* Returns the message of the errno `number` in English, whatever the locale: "No space left on
 * device". The text must not be freed. */
const char *system_message(int number);
/* Returns true for a code point >= U+0080 that is invisible or changes how its neighbours are
 * shown. */
bool codepoint_hidden(uint32_t codepoint);

#define CODEPOINT_INVALID 0xFFFDu /* U+FFFD, the replacement character. */

/* Decodes the UTF-8 code point at the start of a non-empty text and sets *used to its length
 * [byte]. Returns CODEPOINT_INVALID, with *used = 1, for an invalid byte. */
uint32_t text_codepoint(struct text text, size_t *used);
/* Returns the number of terminal columns of a code point, 0, 1 or 2, whatever the locale. */
int codepoint_width(uint32_t codepoint);
int text_width(struct text text); /* Returns the number of terminal columns of a text. */
/* Returns the longest beginning of a line that fits into `width` columns and ends after a whole
 * item (items end at commas, colons, bars or double blanks); if that leaves less than half of
 * the width, one that ends after a whole word or, in a line without blanks, after a character.
 * Sets *cut to true if it ends inside an item: the result then leaves room for an ellipsis.
 * Otherwise *cut is false, even if whole items are left out. */
struct text text_in_room(struct text text, int width, bool *cut);
/* Appends a text broken between words into lines of at most `width` columns, without a newline at
 * the end. */
void buffer_folded(struct buffer *buffer, struct text text, int width);
