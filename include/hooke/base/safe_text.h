/* SPDX-License-Identifier: GPL-3.0-or-later */
/* safe_text: text that came from outside, and how wide it is on a terminal. */
#pragma once

#include <hooke/base/text.h>

/*
 * Appends a text with everything that could command a terminal made visible: C0, DEL, C1, invalid
 * UTF-8, line and paragraph separators, bidirectional and zero-width controls become \xNN or
 * <U+NNNN>; newline and tab, too, unless keep_layout.
 */
void safe_text(struct buffer *output, struct text text, bool keep_layout);
#define SAFE_NAME_SIZE 160
/* Writes a name from outside for use in a message: made visible as by safe_text(), and cut with
 * "..." if it is long. Returns `output`. */
const char *safe_name(struct text name, char output[SAFE_NAME_SIZE]);
/* Returns the message of an errno, in English whatever the locale: "No space left on device". */
const char *system_message(int number);
/* Returns true for a code point from U+0080 on that is invisible or changes how others are shown.
 */
bool codepoint_hidden(uint32_t codepoint);

#define CODEPOINT_INVALID 0xFFFDu /* the replacement character */

/* Decodes one code point of UTF-8 at the start of the text. *used [byte]: its length. Returns
 * CODEPOINT_INVALID with *used = 1 for an invalid byte. */
uint32_t text_codepoint(struct text text, size_t *used);
/* Returns the columns that it takes on a terminal, 0, 1 or 2, whatever the locale. */
int codepoint_width(uint32_t codepoint);
int text_width(struct text text); /* [column] */
/*
 * Returns the beginning of a line that fits into `width` columns: whole items (separated by commas,
 * colons, bars, double blanks), or whole words where these would leave less than half. *cut is set
 * if something is left out; then there is room for a blank and a mark.
 */
struct text text_in_room(struct text text, int width, bool *cut);
/* Appends the words of a text in lines of at most `width` columns, without the last newline. */
void buffer_folded(struct buffer *buffer, struct text text, int width);
