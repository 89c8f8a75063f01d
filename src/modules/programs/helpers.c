/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Functions that a program calls, out of hooke's own source: what they need of it, and no more. A
 * source is cut into items, each a definition with the comment above it.
 */
#include "modules/programs/program.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* ---- sources ---- */

#define SOURCE(name, path)                                                                         \
    __asm__(".pushsection .rodata\nprogram_" #name ":\n.incbin \"" path                            \
            "\"\n.byte 0\n.popsection\n");                                                         \
    extern const char program_##name[];
SOURCE(wide, "src/base/elementary/wide.h")
SOURCE(circle_series, "include/hooke/base/circle.h")
SOURCE(circle_near, "src/base/elementary/circle.h")
SOURCE(tables_rows, "src/base/elementary/tables.h")
SOURCE(tables, "src/base/elementary/tables.c")
SOURCE(exponential_parts, "src/base/elementary/exponential.h")
SOURCE(logarithm_parts, "src/base/elementary/logarithm.h")
SOURCE(exponential, "src/base/elementary/exponential.c")
SOURCE(logarithm, "src/base/elementary/logarithm.c")
SOURCE(circle, "src/base/elementary/circle.c")
SOURCE(arc, "src/base/elementary/arc.c")
SOURCE(expressions, "src/scene/formula/expr.h")
SOURCE(function_rows, "src/scene/formula/functions.c")
SOURCE(elimination, "src/method/step/lu_body.h")
SOURCE(factor, "src/method/control/factor.h")
SOURCE(own, "src/modules/programs/own.h")
SOURCE(own_adaptive, "src/modules/programs/own_adaptive.h")
SOURCE(own_python, "src/modules/programs/own.py")

/* What is defined before what uses it. */
static const char *const sources[] = {
    program_elimination,
    program_factor,
    program_own,
    program_own_adaptive,
    program_wide,
    program_circle_series,
    program_circle_near,
    program_tables_rows,
    program_tables,
    program_exponential_parts,
    program_logarithm_parts,
    program_exponential,
    program_logarithm,
    program_circle,
    program_arc,
    program_expressions,
    program_function_rows,

};

/* What is called from outside. */
static const char *const roots[] = {"fixed_",    "function_", "power",    "solve_",
                                    "propagate", "turning_",  "adaptive_"};

enum { NAMES = 4 };

struct source_item {
    struct text text, comment;
    struct text name[NAMES];
    int names;
    bool needed, root, function;
};

#define WORDS 256 /* between two looks */

struct source_items {
    struct source_item *item;
    int count, capacity;
};

/* ---- cutting ---- */

static struct text word_at(struct text text, size_t at)
{
    size_t len = 0;
    while (at + len < text.len && is_name_char(text.at[at + len]))
        len++;
    return (struct text){text.at + at, len};
}

/* Goes on to the next word of a text, outside of comments. */
static bool next_word(struct text text, size_t *at, struct text *word)
{
    while (*at < text.len) {
        const struct text rest = {text.at + *at, text.len - *at};
        if (text_starts(rest, TEXT("/*"))) {
            const char *end = strstr(rest.at + 2, "*/");
            *at = end ? (size_t)(end + 2 - text.at) : text.len;
            continue;
        }
        *word = word_at(text, *at);
        *at += word->len > 0 ? word->len : 1;
        if (word->len > 0 && is_name_start(word->at[0]))
            return true;
    }
    return false;
}

static void take_name(struct source_item *item, struct text name)
{
    if (item->names < NAMES)
        item->name[item->names++] = name;
}

/* What it defines: a macro, a tag, a function, or objects. */
static void name_item(struct source_item *item)
{
    const struct text text = item->text;
    size_t at = 0;
    int depth = 0;
    struct text word;
    if (text_starts(text, TEXT("#define "))) {
        take_name(item, word_at(text, 8));
        return;
    }
    bool tag = false;
    for (; at < text.len; at++) {
        const char c = text.at[at];
        depth += (c == '{') - (c == '}');
        word = word_at(text, at);
        if (depth > 0 || word.len == 0 || !is_name_start(c))
            continue;
        at += word.len;
        while (at < text.len && text.at[at] == ' ')
            at++;
        const char behind = at < text.len ? text.at[at] : '\0';
        if (tag && behind == '{')
            take_name(item, word);
        tag = text_is(word, "struct") || text_is(word, "enum");
        if (behind == '(' && !text_is(word, "__attribute__")) {
            take_name(item, word);
            item->function = true;
            return;
        }
        if (behind == '=' || behind == '[')
            take_name(item, word);
        at--;
    }
}

/* Macros that are written as what they are, where a compiler chooses among machines. */
static const struct {
    const char *as, *to;
} words[] = {{"INLINE", "static inline"}, {"INSTANCE", "static inline"}, {"FUSED", "false"}};

static bool is_written_out(struct text text)
{
    for (size_t i = 0; i < COUNT_OF(words); i++)
        if (text_starts(text, TEXT("#define ")) && text_is(word_at(text, 8), words[i].as))
            return true;
    return false;
}

static void keep_item(struct source_items *items, struct text text, struct text comment)
{
    const bool declares = text.len > 0 && !memchr(text.at, '{', text.len) && text.at[0] != '#' &&
                          !memchr(text.at, '=', text.len);
    if (text_starts(text, TEXT("extern ")) || declares ||
        text_starts(text, TEXT("static const struct function ")) ||
        text_starts(text, TEXT("const struct catalog ")) || is_written_out(text))
        return;
    if (items->count == items->capacity) {
        const int capacity = 2 * items->capacity + 64;
        struct source_item *more = realloc(items->item, (size_t)capacity * sizeof *more);
        if (!more)
            return; /* the program would lack it: its compiler says so */
        items->item = more;
        items->capacity = capacity;
    }
    struct source_item *item = &items->item[items->count++];
    *item = (struct source_item){.text = text, .comment = comment};
    name_item(item);
}

static struct text line_of(const char *at)
{
    return (struct text){at, strcspn(at, "\n")};
}

/* The end of a definition that begins there, behind its last line. */
static const char *definition_end(const char *at)
{
    const bool macro = *at == '#';
    int depth = 0;
    for (;; at++) {
        const struct text line = line_of(at);
        bool comment = false;
        char last = '\0';
        for (size_t i = 0; i < line.len; i++) {
            const char c = line.at[i];
            comment |= c == '/' && line.at[i + 1] == '*';
            if (!comment && c != ' ')
                last = c;
            depth += comment ? 0 : (c == '{') - (c == '}');
            comment &= !(c == '/' && i > 0 && line.at[i - 1] == '*');
        }
        at += line.len;
        if (*at == '\0' || (macro ? line.len == 0 || line.at[line.len - 1] != '\\'
                                  : depth == 0 && (last == ';' || last == '}')))
            return at;
    }
}

static void cut(struct source_items *items, const char *at)
{
    const char *comment = NULL, *behind = NULL;
    int skipped = 0; /* conditions, of one machine or another */
    for (; *at; at += *at == '\n') {
        const struct text line = line_of(at);
        const bool condition = text_starts(line, TEXT("#if"));
        if (skipped > 0 || (condition && !text_starts(line, TEXT("#ifndef HOOKE_")))) {
            skipped += condition - text_starts(line, TEXT("#endif"));
            at += line.len;
        } else if (text_starts(line, TEXT("/*"))) {
            comment = at;
            at = strstr(at, "*/") + 2;
            behind = at;
            at += strcspn(at, "\n");
        } else if (line.len == 0) {
            comment = NULL; /* of a chapter */
        } else if (line.at[0] == '#' && (!text_starts(line, TEXT("#define ")) ||
                                         text_starts(line, TEXT("#define HOOKE_")))) {
            at += line.len;
        } else {
            const char *end = definition_end(at);
            keep_item(items, (struct text){at, (size_t)(end - at)},
                      comment ? (struct text){comment, (size_t)(behind - comment)}
                              : (struct text){0});
            comment = NULL;
            at = end;
        }
    }
}

/* ---- what is needed ---- */

static struct source_item *item_named(const struct source_items *items, struct text name)
{
    for (int i = 0; i < items->count; i++)
        for (int k = 0; k < items->item[i].names; k++)
            if (text_equal(items->item[i].name[k], name))
                return &items->item[i];
    return NULL;
}

static bool is_root(struct text name)
{
    for (size_t i = 0; i < COUNT_OF(roots); i++)
        if (text_starts(name, text_of(roots[i])))
            return true;
    return false;
}

static bool need(const struct source_items *items, struct text text, bool from_outside,
                 const struct cancel *cancel)
{
    struct text word;
    bool more = false;
    for (size_t at = 0, i = 1; next_word(text, &at, &word); i++) {
        if (i % WORDS == 0 && cancelled(cancel))
            return false;
        struct source_item *item = from_outside && !is_root(word) ? NULL : item_named(items, word);
        /* a variable may have the name of a function */
        if (!item || (item->function && !(at < text.len && text.at[at] == '(')))
            continue;
        item->root |= from_outside && item->function;
        more |= !item->needed;
        item->needed = true;
    }
    return more;
}

static bool has_word(struct text text, struct text wanted)
{
    struct text word;
    for (size_t at = 0; next_word(text, &at, &word);)
        if (text_equal(word, wanted))
            return true;
    return false;
}

/* ---- writing ---- */

static void put_item(struct buffer *out, const struct source_items *items, struct text text,
                     struct text program, const struct cancel *cancel)
{
    size_t at = 0;
    while (at < text.len && !cancelled(cancel)) {
        const struct text rest = {text.at + at, text.len - at}, word = word_at(text, at);
        if (text_starts(rest, TEXT("fused_here() ? "))) {
            at += (size_t)(strstr(rest.at, " : ") + 3 - rest.at);
            continue;
        }
        if (word.len == 0 || !is_name_start(word.at[0])) {
            buffer_put(out, (struct text){rest.at, word.len ? word.len : 1});
            at += word.len ? word.len : 1;
            continue;
        }
        const char *as = NULL;
        for (size_t i = 0; i < COUNT_OF(words); i++)
            as = text_is(word, words[i].as) ? words[i].to : as;
        const struct source_item *item = as || is_root(word) ? NULL : item_named(items, word);
        if (item && has_word(program, word))
            buffer_put(out, TEXT("fixed_")); /* the scene has the name */
        buffer_put(out, as ? text_of(as) : word);
        at += word.len;
    }
}

static bool is_static(struct text text)
{
    return text_starts(text, TEXT("static ")) || text_starts(text, TEXT("INLINE ")) ||
           text_starts(text, TEXT("INSTANCE ")) || text.at[0] == '#' ||
           text_starts(text, TEXT("struct ")) || text_starts(text, TEXT("enum "));
}

static void put_c(struct scene_program *p, const struct source_items *items, struct text program,
                  struct buffer *declared)
{
    const struct cancel *cancel = p->session->front.cancel;
    bool any = false;
    for (int i = 0; i < items->count; i++) {
        const struct source_item *item = &items->item[i];
        if (!item->needed || cancelled(cancel))
            continue;
        if (!any)
            buffer_put(p->out, TEXT("\n/* ---- hooke's own functions: the same bits on every "
                                    "machine ---- */\n\n"));
        any = true;
        if (item->comment.len > 0) {
            buffer_put(p->out, item->comment);
            buffer_char(p->out, '\n');
        }
        if (!is_static(item->text))
            buffer_put(p->out, TEXT("static "));
        put_item(p->out, items, item->text, program, cancel);
        buffer_put(p->out, item->text.at[0] == '#' ? TEXT("\n") : TEXT("\n\n"));
        if (!item->root)
            continue;
        const size_t head = strcspn(item->text.at, "{");
        buffer_put(declared, is_static(item->text) ? TEXT("") : TEXT("static "));
        put_item(declared, items, text_trim((struct text){item->text.at, head}), program, cancel);
        declared->len -= declared->data && declared->data[declared->len - 1] == '\n';
        buffer_put(declared, TEXT(";\n"));
    }
    if (any)
        p->out->len--;
}

/* ---- Python ---- */

static const char *const of_math[] = {"acos",  "asin",     "atan", "atan2", "ceil",  "copysign",
                                      "cos",   "cosh",     "exp",  "expm1", "floor", "frexp",
                                      "hypot", "isfinite", "log",  "log10", "pi",    "sin",
                                      "sinh",  "sqrt",     "tan",  "tanh",  "ulp"};

enum { PYTHON_ITEMS = 32 };

struct python_items {
    struct text text[PYTHON_ITEMS], name[PYTHON_ITEMS];
    bool needed[PYTHON_ITEMS];
    int count;
};

/* Functions and classes, with two empty lines between them. */
static void cut_python(struct python_items *items)
{
    for (const char *at = program_own_python; (at = strstr(at, "\n\n\n"));) {
        at += 3;
        const char *end = strstr(at, "\n\n\n");
        const struct text text = {at, end ? (size_t)(end + 1 - at) : strlen(at)};
        if (items->count == PYTHON_ITEMS)
            return; /* the program would lack it: Python says so */
        items->name[items->count] = word_at(text, strcspn(at, " ") + 1);
        items->text[items->count++] = text;
    }
}

static bool calls_it(struct text program, struct text wanted)
{
    struct text word;
    for (size_t at = 0; next_word(program, &at, &word);)
        if (text_equal(word, wanted) && at < program.len && program.at[at] == '(')
            return true;
    return false;
}

/* Is there a function of that name in the program itself? */
static bool defines(struct text program, struct text name)
{
    struct text word;
    bool definition = false;
    for (size_t at = 0; next_word(program, &at, &word);) {
        if (definition && text_equal(word, name))
            return true;
        definition = text_is(word, "def");
    }
    return false;
}

static void need_python(struct python_items *items, struct text program, struct text text,
                        const struct cancel *cancel)
{
    for (int i = 0; i < items->count; i++) {
        if (items->needed[i] || cancelled(cancel) || !calls_it(text, items->name[i]) ||
            defines(program, items->name[i]))
            continue;
        items->needed[i] = true;
        need_python(items, program, items->text[i], cancel);
    }
}

static void put_python(struct text program, struct buffer *declared, const struct cancel *cancel)
{
    struct python_items items = {0};
    struct buffer own = {0}, text = {0};
    cut_python(&items);
    need_python(&items, program, program, cancel);
    for (int i = 0; i < items.count; i++)
        if (items.needed[i])
            buffer_format(&own, "\n\n%.*s", (int)items.text[i].len, items.text[i].at);
    buffer_put(&text, program);
    buffer_put(&text, buffer_text(&own));
    int count = 0;
    for (size_t i = 0; i < COUNT_OF(of_math); i++)
        if (!cancelled(cancel) && has_word(buffer_text(&text), text_of(of_math[i])))
            buffer_format(declared, "%s%s", count++ ? ", " : "from math import ", of_math[i]);
    buffer_format(declared, "%simport sys\n", count ? "\n" : "");
    buffer_put(declared, buffer_text(&own));
    declared->failed |= own.failed || text.failed;
    buffer_free(&own);
    buffer_free(&text);
}

/* ---- both ---- */

static void insert(struct buffer *out, size_t at, struct text text)
{
    struct buffer all = {0};
    if (out->failed)
        return;
    buffer_put(&all, (struct text){out->data, at});
    buffer_put(&all, text);
    buffer_put(&all, (struct text){out->data + at, out->len - at});
    buffer_free(out);
    *out = all;
}

void program_helpers(struct scene_program *p, size_t declared)
{
    const struct cancel *cancel = p->session->front.cancel; /* whoever began looks, too */
    struct buffer front = {0};
    struct text program = {0};
    char *copy = p->out->failed ? NULL : arena_text(p->arena, buffer_text(p->out));
    if (!copy) {
        p->out->failed = true;
        return;
    }
    program = (struct text){copy + declared, strlen(copy + declared)};
    if (p->syntax->dialect == DIALECT_PYTHON) {
        put_python(program, &front, cancel);
    } else if (p->syntax->dialect == DIALECT_C) {
        struct source_items items = {0};
        for (size_t i = 0; i < COUNT_OF(sources); i++)
            cut(&items, sources[i]);
        bool any = need(&items, program, true, cancel);
        if (any)
            buffer_put(&front, TEXT("#include <stdbool.h>\n#include <stdint.h>\n"
                                    "#include <string.h>\n\n"));
        for (bool more = any; more;) {
            more = false;
            for (int i = 0; i < items.count; i++)
                more = (items.item[i].needed && need(&items, items.item[i].text, false, cancel)) ||
                       more;
        }
        put_c(p, &items, program, &front);
        free(items.item);
    }
    p->out->failed |= front.failed;
    insert(p->out, declared, buffer_text(&front));
    buffer_free(&front);
}
