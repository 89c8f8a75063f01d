/* SPDX-License-Identifier: GPL-3.0-or-later */
/* statement: how a line is cut into statements, words and names. */
#pragma once

#include <hooke/base/error.h>

/* Moves the next statement from *line to *statement and drops comments. Returns false if nothing is
 * left, with `error` set if a quoted string does not end. */
bool next_statement(struct text *line, struct text *statement, struct error *error);
/* Returns true for letters and the underscore, with which names begin. */
bool is_name_start(char c);
/* Returns true for what names consist of: letters, digits and the underscore. */
bool is_name_char(char c);
/* Moves the beginning of the text beyond its leading blanks, ends of lines too. */
void text_skip_blanks(struct text *text);
/* Returns what follows the first `count` bytes and the blanks behind them. */
struct text text_behind(struct text text, size_t count);
/* Returns the word at the start, up to a blank, quote, semicolon or one of `stops`. */
struct text peek_word(struct text text, const char *stops);
/* Returns the name at the start: a letter, then letters, digits, _ and -; empty if there is none.
 */
struct text peek_name(struct text text);
/* Returns the length [byte] of the string that starts at text.at[0], with both quotes, or 0 if it
 * does not end. */
size_t text_quoted(struct text text);
