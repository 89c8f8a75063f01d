/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes programs from templates: c.template, python.template and octave.template, which explain
 * their words. */
#include <hooke/base/cancel.h>
#include <hooke/base/statement.h>
#include "modules/programs/program.h"

#include <string.h>

#define TEMPLATE(name)                                                                             \
    __asm__(".pushsection .rodata\nprogram_" #name ":\n.incbin \"src/modules/programs/" #name      \
            ".template\"\n.byte 0\n.popsection\n");                                                \
    extern const char program_##name[];
TEMPLATE(c)
TEMPLATE(python)
TEMPLATE(octave)

/* Returns the text of a language's template. */
static const char *template_of(enum dialect dialect)
{
    if (dialect == DIALECT_C)
        return program_c;
    return dialect == DIALECT_PYTHON ? program_python : program_octave;
}

/* ---- names ---- */

/* Returns true if the text has that word, followed by next_char, or by no other letter if it is
 * '\0'. */
static bool has_word(const char *text, const char *word, size_t len, char next_char)
{
    for (const char *cursor = text; (cursor = strstr(cursor, word)); cursor++)
        if ((cursor == text || !is_name_char(cursor[-1])) &&
            (next_char ? cursor[len] == next_char : !is_name_char(cursor[len])))
            return true;
    return false;
}

/* Returns true if the name looks like one of the C library: types, reentrant functions, limits,
 * float and long functions. */
static bool is_like_library(const char *name)
{
    static const char *const ends[] = {"_t", "_r", "_l", "_MAX", "_MIN", "_unlocked"};
    static const char *const begins[] = {"M_", "FP_", "SEEK_"};
    const size_t len = strlen(name);
    char stem[LIMIT_SYMBOL + 1] = {0};
    for (size_t i = 0; i < COUNT_OF(ends); i++)
        if (len > strlen(ends[i]) && strcmp(name + len - strlen(ends[i]), ends[i]) == 0)
            return true;
    for (size_t i = 0; i < COUNT_OF(begins); i++)
        if (strncmp(name, begins[i], strlen(begins[i])) == 0)
            return true;
    if (len < 3 || len > LIMIT_SYMBOL || !strchr("fl", name[len - 1]))
        return false;
    memcpy(stem, name, len - 1);
    return has_word(strstr(program_c, "<<words>>"), stem, len - 1, '\0');
}

bool program_takes(enum dialect dialect, const char *name)
{
    return has_word(strstr(template_of(dialect), "<<words>>"), name, strlen(name), '\0') ||
           (dialect == DIALECT_C && is_like_library(name));
}

/* ---- expansion ---- */

bool program_uses(const struct scene_program *p, const char *name, char next_char)
{
    return has_word(p->rates, name, strlen(name), next_char) ||
           has_word(p->observed, name, strlen(name), next_char);
}

bool program_reads(const struct scene_program *p, int i)
{
    return program_uses(p, p->name[i], '\0');
}

/* Splits off the next line. */
static struct text next_line(const char **rest)
{
    const size_t len = strcspn(*rest, "\n");
    const struct text line = {*rest, len};
    *rest += len + ((*rest)[len] != '\0');
    return line;
}

/* Returns true if the text of a template's word is not empty. A word such as "sqrt(" holds if the
 * formulas call that function. */
static bool word_holds(struct scene_program *p, struct text word)
{
    struct buffer text = {0}, *output = p->output;
    char name[LIMIT_SYMBOL + 1] = {0};
    if (word.data[word.len - 1] == '(') {
        memcpy(name, word.data, word.len - 1 < LIMIT_SYMBOL ? word.len - 1 : LIMIT_SYMBOL);
        return program_uses(p, name, '(');
    }
    p->output = &text;
    program_word(p, word);
    p->output = output;
    const bool any = text.len > 0;
    output->failed |= text.failed;
    buffer_free(&text);
    return any;
}

/* Returns true if all words after <<if hold, and none of those after a '!'. */
static bool conditions_hold(struct scene_program *p, struct text words)
{
    struct text word;
    bool all = true;
    while (all && text_split(&words, ' ', &word)) {
        const bool no = word.len > 0 && word.data[0] == '!';
        if (word.len > 0)
            all = word_holds(p, text_after(word, no)) != no;
    }
    return all;
}

/* Appends a line of a template, with each <<WORD>> replaced by program_word(). A line that becomes
 * empty is left out, and a blank line where the style of the language allows no further one. */
static void put_line(struct scene_program *p, struct text line)
{
    struct buffer *const output = p->output;
    const size_t start = output->len;
    const char *const blanks = p->dialect == DIALECT_PYTHON ? "\n\n\n" : "\n\n";
    const size_t most = strlen(blanks);
    if (line.len == 0 && start >= most && memcmp(output->data + start - most, blanks, most) == 0)
        return;
    for (size_t i = 0; i < line.len; i++) {
        const char *const end = strstr(line.data + i, ">>");
        if (line.data[i] != '<' || line.data[i + 1] != '<' || !end) {
            buffer_char(output, line.data[i]);
            continue;
        }
        program_word(p, (struct text){line.data + i + 2, (size_t)(end - line.data) - i - 2});
        i = (size_t)(end - line.data) + 1;
    }
    if (line.len == 0 || output->len > start)
        buffer_char(output, '\n');
}

/* Removes the import of Python's module math if the program does not use it. */
static void drop_unused_import(struct buffer *output)
{
    char *const line = output->data ? strstr(output->data, "import math\n") : NULL;
    const size_t len = strlen("import math\n");
    if (!line || strstr(line, "math."))
        return;
    memmove(line, line + len, output->len - (size_t)(line - output->data) - len + 1);
    output->len -= len;
}

/* Copies the template from the line after <<begin>> to the line <<words>>, behind which it lists
 * the words that variables cannot be called by. A line <<if ...>> decides whether the lines up to
 * the next one are copied. */
bool program_write(struct scene_program *p)
{
    const char *rest = strstr(template_of(p->dialect), "<<begin>>\n");
    bool active = true;
    next_line(&rest);
    while (!p->output->failed && !cancelled(p->session->front.cancel)) {
        const struct text line = next_line(&rest);
        if (text_is(line, "<<words>>")) {
            drop_unused_import(p->output);
            return true;
        }
        if (text_starts(line, TEXT("<<if")))
            active = conditions_hold(p, (struct text){line.data + 4, line.len - 6});
        else if (active)
            put_line(p, line);
    }
    return false;
}
