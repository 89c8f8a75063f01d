/* SPDX-License-Identifier: GPL-3.0-or-later */
/* statement: splits lines of the command language into statements, words, names and quoted strings,
 * without knowing any command. All results are slices of the text passed in. */
#pragma once

#include <hooke/base/error.h>

/* Moves the next statement of *line, up to `;` or a comment, to *statement without its outer
 * blanks; a comment is removed from *line. An empty line gives an empty statement. Returns false,
 * with `error` set, if a quoted string is not closed. */
bool next_statement(struct text *line, struct text *statement, struct error *error);
/* Returns true for ASCII letters and the underscore, with which names begin. */
bool is_name_start(char c);
/* Returns true for the characters of names: ASCII letters, digits and the underscore. */
bool is_name_char(char c);
/* Removes leading blanks, tabs and ends of lines from *text. */
void text_skip_blanks(struct text *text);
/* Returns the text after its first `count` bytes and the blanks that follow them; count <=
 * text.len. */
struct text text_behind(struct text text, size_t count);
/* Returns the word at the start of the text: everything before the first blank, string, semicolon
 * or character of `stops`. May be empty. */
struct text peek_word(struct text text, const char *stops);
/* Returns the name at the start of the text: a letter or underscore, then letters, digits,
 * underscores and hyphens between them. Empty if there is none. */
struct text peek_name(struct text text);
/* Returns the length [byte], both quotes included, of the quoted string that begins the text, or 0
 * if it is not closed. text.data[0] must be the quote. */
size_t text_quoted(struct text text);
/* Appends the text as a quoted string that is read as this text: in ', or in " with escapes if it
 * contains a '. */
void buffer_quote(struct buffer *output, struct text text);
