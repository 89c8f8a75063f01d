/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Mutations of command lines: tokens and lines are deleted, repeated, swapped, replaced. New ones
 * are names from the rows (commands, what stands after them, settings, parameters, methods, units,
 * functions, …), numbers at the edges, and lines of the scripts that the tests have.
 */
#pragma once

#include <hooke/run.h>
#include <hooke/method.h>
#include <hooke/base/file.h>
#include <hooke/base/unit.h>
#include <hooke/command.h>
#include <hooke/plot.h>
#include <hooke/scene/formula.h>

#include <ctype.h>
#include <glob.h>

enum { TOKEN_WORDS = 4096, TOKEN_LINES = 8192, TOKEN_SPANS = 1024, TOKEN_CATALOGS = 128 };

static struct {
    const char *word[TOKEN_WORDS];
    size_t words;
    struct text line[TOKEN_LINES];
    size_t lines;
    const struct catalog *catalog[TOKEN_CATALOGS];
    size_t catalogs;
    uint64_t random;
} tokens;

static void tokens_add(const char *word)
{
    if (word && *word && tokens.words < TOKEN_WORDS)
        tokens.word[tokens.words++] = word;
}

/* Once. */
static void tokens_add_catalog(const struct catalog *catalog)
{
    for (size_t i = 0; i < tokens.catalogs; i++)
        if (tokens.catalog[i] == catalog)
            return;
    if (!catalog || tokens.catalogs == TOKEN_CATALOGS)
        return;
    tokens.catalog[tokens.catalogs++] = catalog;
    for (size_t i = 0; i < catalog->count; i++)
        tokens_add(catalog_row(catalog, i)->name);
}

/* What stands after commands: --force, dt=, to, and what can be chosen there. */
static void tokens_add_arguments(const struct command *command)
{
    static char text[1 << 14];
    static size_t used;
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        tokens_add_catalog(argument->choices);
        tokens_add(argument->lead);
        if (argument->form == FORM_PLACE || sizeof text - used < LIMIT_NAME + 8)
            continue;
        char *at = text + used;
        used += 1 + (size_t)snprintf(at, sizeof text - used, "%s%s%s",
                                     argument->form == FORM_OPTION ? "--" : "", argument->name,
                                     argument->form == FORM_KEY ? "=" : "");
        tokens_add(at);
    }
}

/* Its text stays, for the lines point into it. */
static void tokens_add_lines(const char *pattern)
{
    glob_t found;
    if (glob(pattern, 0, NULL, &found) != 0)
        return;
    for (size_t i = 0; i < found.gl_pathc; i++) {
        struct buffer text = {0};
        struct error error;
        struct text line;
        if (!file_read(found.gl_pathv[i], 1 << 20, &text, &error))
            continue;
        for (struct text rest = buffer_text(&text); text_split(&rest, '\n', &line);)
            if (line.len > 0 && line.data[0] != '#' && tokens.lines < TOKEN_LINES)
                tokens.line[tokens.lines++] = line;
        static struct buffer kept[256];
        static size_t count;
        if (count < COUNT_OF(kept))
            kept[count++] = text;
    }
    globfree(&found);
}

/* Looks for the scripts where it is started, or in FUZZ_TOP. */
static void tokens_begin(void)
{
    static const struct catalog *const catalogs[] = {
        &command_catalog, &setting_catalog,  &param_catalog,  &method_catalog,
        &unit_catalog,    &function_catalog, &preset_catalog, &observable_catalog};
    static const char *const edges[] = {
        "0",          "-0",   "1e-300",    "1e300",    "1e308", "4.9e-324", "9007199254740993",
        "2147483648", "-1",   "1e9",       "0.1",      "1/0",   "..",       "''",
        "{",          "}",    "(",         ")",        "[",     "]",        "+-",
        "\\",         "\"",   ";",         "\n",       "|",     ">",        "\xc2\xb5",
        "\xff",       "a.hk", "swing.txt", "speed.txt"};
    const char *top = getenv("FUZZ_TOP");
    static const char *const scripts[] = {"tests/cli/*.hk", "examples/*.hk", "examples/*/*.hk",
                                          "tests/fuzz/corpus/command/*"};
    if (tokens.words > 0)
        return;
    for (size_t i = 0; i < COUNT_OF(catalogs); i++)
        tokens_add_catalog(catalogs[i]);
    for (size_t i = 0; i < command_catalog.count; i++)
        tokens_add_arguments(command_at(catalog_row(&command_catalog, i)));
    for (size_t i = 0; i < setting_catalog.count; i++)
        tokens_add_catalog(setting_at(i)->choices);
    for (size_t i = 0; i < COUNT_OF(edges); i++)
        tokens_add(edges[i]);
    for (size_t i = 0; i < COUNT_OF(scripts); i++) {
        char path[300];
        snprintf(path, sizeof path, "%s/%s", top ? top : ".", scripts[i]);
        tokens_add_lines(path);
    }
    if (tokens.lines == 0)
        abort();
}

static size_t tokens_choose(size_t count)
{
    return (size_t)(fuzz_random(&tokens.random) % count);
}

/* Names and numbers are one token, anything else is one byte. */
static size_t tokens_cut(struct text in, struct text *span)
{
    size_t count = 0;
    for (size_t i = 0, end; i < in.len && count < TOKEN_SPANS; i = end) {
        for (end = i + 1; isalnum((unsigned char)in.data[i]) && end < in.len &&
                          (isalnum((unsigned char)in.data[end]) || strchr("._", in.data[end]));)
            end++;
        span[count++] = (struct text){in.data + i, end - i};
    }
    return count;
}

static bool tokens_is_break(struct text span)
{
    return span.data[0] == '\n' || span.data[0] == ';';
}

struct token_range {
    size_t from, end;
};

/* A token, or a statement, or some tokens. */
static struct token_range tokens_range(const struct text *span, size_t count)
{
    struct token_range range = {tokens_choose(count), 0};
    range.end = range.from + 1;
    switch (tokens_choose(4)) {
    case 0:
        while (range.from > 0 && !tokens_is_break(span[range.from - 1]))
            range.from--;
        while (range.end < count && !tokens_is_break(span[range.end - 1]))
            range.end++;
        break;
    case 1:
        range.end += tokens_choose(count - range.from);
        break;
    default:
        break;
    }
    return range;
}

/* Something new. */
static void tokens_put_new(struct buffer *out)
{
    const struct text line = tokens.line[tokens_choose(tokens.lines)];
    struct text span[TOKEN_SPANS];
    const size_t count = tokens_cut(line, span);
    switch (tokens_choose(5)) {
    case 0:
        buffer_format(out, "%.*s\n", (int)line.len, line.data);
        break;
    case 1:
        for (struct token_range some = tokens_range(span, count); some.from < some.end;)
            buffer_put(out, span[some.from++]);
        break;
    case 2:
        buffer_format(out, "%.3g", (double)(tokens_choose(2000)) / (1 + (double)tokens_choose(99)));
        break;
    default:
        buffer_format(out, "%s%s", tokens.word[tokens_choose(tokens.words)],
                      tokens_choose(2) ? " " : "");
    }
}

static void tokens_put(struct buffer *out, const struct text *span, struct token_range range)
{
    for (size_t i = range.from; i < range.end; i++)
        buffer_put(out, span[i]);
}

static void tokens_change(struct text in, struct buffer *out)
{
    struct text span[TOKEN_SPANS];
    const size_t count = tokens_cut(in, span);
    if (count == 0) {
        tokens_put_new(out);
        return;
    }
    const struct token_range a = tokens_range(span, count), b = tokens_range(span, count);
    tokens_put(out, span, (struct token_range){0, a.from});
    switch (tokens_choose(6)) {
    case 0: /* deleted */
        break;
    case 1: /* repeated */
        tokens_put(out, span, a);
        tokens_put(out, span, a);
        break;
    case 2: /* what stands elsewhere comes here */
        tokens_put(out, span, b);
        break;
    case 3:
        tokens_put(out, span, a);
        tokens_put_new(out);
        break;
    default:
        tokens_put_new(out);
    }
    tokens_put(out, span, (struct token_range){a.end, count});
}

static inline size_t tokens_mutate(uint8_t *data, size_t size, size_t max, unsigned seed)
{
    tokens_begin();
    tokens.random = seed * 2654435761u + 88172645463325252u;
    if (tokens_choose(8) == 0)
        return LLVMFuzzerMutate(data, size, max);
    struct buffer now = {0};
    buffer_put(&now, (struct text){(const char *)data, size});
    for (size_t times = 1 + tokens_choose(3); times > 0; times--) {
        struct buffer next = {0};
        tokens_change(buffer_text(&now), &next);
        buffer_free(&now);
        now = next;
    }
    const size_t len = now.failed ? 0 : now.len < max ? now.len : max;
    if (len > 0)
        memcpy(data, now.data, len);
    buffer_free(&now);
    return len;
}

/* A target that has one of its own says so before. */
#ifndef FUZZ_MUTATOR
#define FUZZ_MUTATOR
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max, unsigned seed)
{
    return tokens_mutate(data, size, max, seed);
}
#endif
