/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Better hints for errors about unknown words: what a word means elsewhere in the program, or what
 * a newcomer probably meant by it. */
#include "command/finding.h"
#include "command/session/topics.h"

#include <hooke/base/statement.h>
#include <hooke/command.h>
#include <hooke/plot.h>
#include <hooke/report.h>

#include <string.h>
#include <strings.h>

/* ---- words of the field and of other programs ---- */

static const struct row words[] = {
#define WORD_TEXT(id, word, brief, says, lines, others) {word, "", says, "", others},
#include "lists/help.def"
};
const struct catalog word_catalog = CATALOG("word", words);

/* ---- names of other catalogs ---- */

/* Use of settings and parameters, as in the table below. */
#define SETTING_HINT "'%1 = VALUE' as a command of its own sets it"

/* Text that shows how to use a name of the catalog; %1 stands for the name. */
static const struct use {
    const struct catalog *catalog;
    const char *use;
} uses[] = {
    {&method_catalog, "'method %1' chooses it"},
    {&preset_catalog, "'scene %1' chooses it"},
    {&plot_catalog, "'plot %1' draws it"},
    {&quantity_catalog, "'measure %1' measures it"},
    {&setting_catalog, SETTING_HINT},
    {&list_catalog, "'list %1' shows them"},
    {&layout_catalog, "'layout %1' shows it"},
    {&observable_catalog, "'print %1' shows it for a run"},
    {&result_catalog, "'plot COLUMN against COLUMN of %1' draws its result"},
    {&guide_catalog, "'help %1' shows how"},
    {&command_catalog,
     "'%1' is a command: 'help %1'"}, /* the last, since put_uses() may leave it out */
};

/* Returns true if the kind of the unknown word begins with `wanted`; kind is NULL for other
 * errors. */
static bool is_kind(const char *kind, const char *wanted)
{
    return kind && text_starts(text_of(kind), text_of(wanted));
}

/* Appends the text with %1 replaced by the name. */
static void put_use(const char *use, struct text name, struct buffer *text)
{
    for (const char *cursor = use; *cursor; cursor++)
        if (cursor[0] == '%' && cursor[1] == '1') {
            buffer_put(text, name);
            cursor++;
        } else {
            buffer_char(text, *cursor);
        }
}

/* Appends at most two uses of a name, in the order of the catalogs, except for the catalog that was
 * to be chosen from (kind). guessed leaves out commands. Returns false if there are none. */
static bool put_uses(struct text name, const char *kind, bool guessed, struct buffer *text)
{
    int count = 0;
    for (size_t i = 0; i < COUNT_OF(uses) - guessed && count < 2; i++) {
        const struct row *row = catalog_find(uses[i].catalog, name);
        /* A result or an observable does not replace a choice, and expressions know it if it
         * exists. */
        if (!row || text_starts(text_of(kind), text_of(uses[i].catalog->kind)) ||
            (uses[i].catalog == &result_catalog && !is_kind(kind, "plot")) ||
            (uses[i].catalog == &observable_catalog && *kind && !is_kind(kind, "command") &&
             !is_kind(kind, "plot") && !is_kind(kind, "quantity")))
            continue;
        buffer_put(text, count++ ? TEXT(", ") : TEXT(""));
        put_use(uses[i].use, text_of(row->name), text);
    }
    return count > 0;
}

/* Appends the hint for a name that is a setting or a parameter of the scene. */
static void put_setting(const struct session *session, struct text name, struct buffer *text)
{
    if (catalog_find(&setting_catalog, name) ||
        catalog_find(scene_params(&session->setup.scene), name))
        put_use(SETTING_HINT, name, text);
}

/* Returns true if `where` contains the word, in upper or lower case. */
bool text_mentions(const char *where, struct text word)
{
    for (const char *cursor = where; cursor && *cursor; cursor++)
        if (strncasecmp(cursor, word.data, word.len) == 0)
            return true;
    return false;
}

/* Returns true if the text contains the word between blanks. */
static bool mentions_whole(const char *where, struct text word)
{
    const char *cursor = strchr(where, ' ');
    while (cursor &&
           !(strncmp(cursor + 1, word.data, word.len) == 0 && cursor[1 + word.len] == ' '))
        cursor = strchr(cursor + 1, ' ');
    return cursor;
}

/* Returns true if the description of any row mentions the word. */
static bool is_mentioned(struct text word)
{
    for (size_t i = 0; i < COUNT_OF(uses); i++)
        for (size_t j = 0; j < uses[i].catalog->count; j++)
            if (text_mentions(catalog_row(uses[i].catalog, j)->brief, word))
                return true;
    return false;
}

/* Returns what was typed around `where` up to the next blank or bracket, such as dE/E0 or
 * symplectic-euler. */
static struct text whole_word(struct text statement, struct text where)
{
    size_t len = (size_t)(where.data - statement.data);
    while (len < statement.len && !memchr(" \t=,;()'\"", statement.data[len], 9))
        len++;
    return (struct text){where.data, len - (size_t)(where.data - statement.data)};
}

#define SENTENCE_MIN 3   /* blanks from which a statement counts as a sentence */
#define MEANINGS_SHOWN 3 /* most meanings and commands in a hint */
#define USAGE_SHORT 48   /* [byte] longest usage that is shown together with other hints */

/* Returns the form in which the word was typed. */
static enum argument_form form_of(struct text statement, struct text where)
{
    struct text rest = {where.data + where.len,
                        (size_t)(statement.data + statement.len - where.data) - where.len};
    text_skip_blanks(&rest);
    if (where.data - statement.data >= 2 && where.data[-1] == '-' && where.data[-2] == '-')
        return FORM_OPTION;
    return rest.len > 0 && rest.data[0] == '=' ? FORM_KEY : FORM_WORD;
}

/* Returns true if the command has an argument of that name, in whatever form. */
static bool takes_name(const struct command *command, struct text name)
{
    int i = 0;
    while (i < command->arguments && !text_is(name, command->argument[i].name))
        i++;
    return i < command->arguments;
}

/* Returns true for commands with a to=FILE key, such as collect. They never replace a file, since a
 * sensor sends its lines only once. */
static bool overwrites_nothing(const struct command *command)
{
    int i = 0;
    while (i < command->arguments &&
           !(command->argument[i].type == TYPE_FILE && command->argument[i].form == FORM_KEY &&
             strcmp(command->argument[i].name, "to") == 0))
        i++;
    return i < command->arguments;
}

/* Appends what the word at `where` could mean: things of another kind with that name, its probable
 * meaning, and other commands that take it as an argument. `command` is the command of the
 * statement, or NULL; `kind` is the kind of name that was expected, or NULL; `guessed` is true if a
 * suggestion was made already. */
static void put_meanings(const struct session *session, const struct command *command,
                         struct text statement, struct text where, const char *kind, bool guessed,
                         struct buffer *text)
{
    const struct text word = whole_word(statement, where),
                      called = is_kind(kind, "command") ? called_word(statement) : TEXT(""),
                      names[] = {word, where, called};
    for (size_t i = 0; kind && i < COUNT_OF(names) && text->len == 0; i++)
        if (names[i].len > 0 && !put_uses(names[i], kind, guessed, text)) {
            const struct row *row = catalog_find(&word_catalog, names[i]);
            if (row)
                put_filled(row->brief, is_kind(kind, "command") ? statement : TEXT(""), text);
        }
    if (!command || where.data == statement.data)
        return;
    const enum argument_form form = form_of(statement, where);
    if (form == FORM_OPTION && text_is(where, "force") && overwrites_nothing(command))
        buffer_put(text, TEXT("to= needs a new file name; existing files are not overwritten"));
    struct buffer takers = {0}, usage = {0};
    if (form == FORM_KEY && !kind) { /* one of the other commands, or of the session */
        const struct row *row =
            takes_name(command, where) ? NULL : catalog_find(&word_catalog, where);
        put_setting(session, where, text);
        buffer_put(text, row && text->len == 0 ? text_of(row->brief) : TEXT(""));
    }
    if (!(guessed && form == FORM_WORD) &&
        put_takers(command, form == FORM_WORD ? word : where, form,
                   MEANINGS_SHOWN - (text->len > 0), &takers) &&
        (text->len == 0 || form != FORM_WORD)) {
        command_usage(command, &usage);
        if (form == FORM_WORD && usage.len < USAGE_SHORT)
            buffer_format(text, "usage: %s", buffer_view(&usage));
        buffer_format(text, "%s%s", text->len ? "; " : "", buffer_view(&takers));
    }
    buffer_free(&takers);
    buffer_free(&usage);
}

/* Appends the right form of statements such as np.sin(1), run for 10 s, plot y(t), plot run.csv.
 * Returns false if the statement is none of these. */
static bool put_misplaced(const struct session *session, const char *kind, struct text statement,
                          struct text where, struct buffer *text)
{
    static const char fillers[] = " for with using the a an at by in ";
    const char *end = statement.data + statement.len, *next = where.data + where.len;
    const struct text rest = {next, (size_t)(end - next)}, called = called_word(where);
    if (is_kind(kind, "name") && rest.len > 1 && rest.data[0] == '.' &&
        is_name_start(rest.data[1])) {
        const struct text name = peek_name((struct text){next + 1, rest.len - 1});
        buffer_format(text, "names are used without a prefix: '%.*s'", (int)name.len, name.data);
    } else if (is_kind(kind, "name") && where.len < 6 && where.data > statement.data &&
               where.data[-1] == ' ' && mentions_whole(fillers, where) && text_trim(rest).len > 0) {
        const struct text preceding =
            text_trim((struct text){statement.data, (size_t)(where.data - statement.data)});
        const struct text following = text_trim(rest);
        buffer_format(text, "'%.*s %.*s'", (int)preceding.len, preceding.data, (int)following.len,
                      following.data);
    } else if (is_kind(kind, "plot") && called.len > 0 &&
               (model_variable(session->setup.scene.model, called) >= 0 ||
                catalog_find(&observable_catalog, called))) {
        buffer_format(text, "'plot %.*s'", (int)called.len, called.data);
    } else if (is_kind(kind, "plot") && where.len > 2 && memchr(where.data, '.', where.len)) {
        buffer_put(text, text_of(catalog_find(&word_catalog, TEXT("open"))->brief));
    }
    return text->len > 0;
}

/* Returns true if the statement is an expression of a scene's law, which cannot use variables of
 * let. */
static bool is_law(const struct command *command, struct text statement)
{
    const struct text name = peek_name(statement);
    return command ? strcmp(command->group, "EQUATIONS") == 0 &&
                         command->completes != COMPLETES_VARIABLE &&
                         command->completes != COMPLETES_PARAMETER
                   : name.len < statement.len && name.data[name.len] == '\'';
}

/* Appends hints about at most two other words of a sentence such as "i have a spring and a
 * recording", but not about the few words behind a misspelt command. */
static void put_sentence(struct text statement, bool guessed, struct buffer *text)
{
    struct text rest = statement;
    int blanks = 0;
    for (size_t i = 0; i < statement.len; i++)
        blanks += statement.data[i] == ' ';
    if (guessed && blanks < SENTENCE_MIN)
        return;
    for (int count = 0; rest.len > 0 && count < 2;) {
        const struct text word = peek_word(rest, ",;?.!");
        struct buffer use = {0};
        if (word.len > 2 && word.data > statement.data && put_uses(word, "", false, &use) &&
            !(text->len > 0 && strstr(buffer_view(text), buffer_view(&use)))) {
            buffer_format(text, "%s%s", count++ ? "; " : "", buffer_view(&use));
        }
        buffer_free(&use);
        rest.data += word.len + (word.len < rest.len);
        rest.len -= word.len + (word.len < rest.len);
        text_skip_blanks(&rest);
    }
}

/* Returns true for `save figure FILE` and `save picture FILE`. */
static bool saves_figure(struct text statement)
{
    statement = text_after(statement, peek_word(statement, "").len);
    text_skip_blanks(&statement);
    const struct text word = peek_word(statement, "");
    return text_is(word, "figure") || text_is(word, "picture");
}

/* Returns the plot of a study that the statement asks for, such as `plot order`, or NULL. `own` is
 * the statement's command, or NULL. */
static const struct plot_row *study_plot_of(const struct command *own, struct text statement)
{
    if (!own || !text_is(text_of(own->row.name), "plot"))
        return NULL;
    statement = text_after(statement, peek_word(statement, "").len);
    text_skip_blanks(&statement);
    const struct row *row = catalog_find(&plot_catalog, peek_word(statement, ""));
    const struct plot_row *plot =
        row ? plot_row((enum plot_kind)catalog_index(&plot_catalog, row)) : NULL;
    return plot && plot->study ? plot : NULL;
}

/* Does the work of explain_unknown() for a statement without leading blanks. Collects what may
 * help: the right form of a statement that is nearly right, or advice for `save plot`, for `> FILE`
 * after a command without a table and for `all` as a method, else the meanings of the word
 * error->where; then, if the command is unknown, hints about other words of the sentence. This text
 * replaces the hint. If there is none, a hint where a name exists or one to use `apropos` is added.
 * error->unknown is the kind of name that was not found: "" if the word may be of any kind, NULL if
 * the error is not about a name. */
static void explain_word(const struct session *session, struct text statement, struct error *error)
{
    const struct text where = error->where;
    const char *kind = error->unknown;
    const bool advised = error->hint_kind == HINT_ADVICE, guessed = error->hint_kind == HINT_GUESS;
    struct buffer text = {0};
    /* `own` is the statement's command, or NULL. `command` is the same one if it tells which kind
     * of word is wanted, else NULL. */
    const struct command *own =
        command_at(catalog_choose(session, &command_catalog, peek_word(statement, "")));
    const struct command *command = (kind && !*kind) || advised ? NULL : own;
    /* `law` means that the name is unknown in an equation; `known`, that a better hint exists. */
    const bool name = is_kind(kind, "name"), law = name && is_law(own, statement);
    const bool known = (is_kind(kind, "unit") && advised) ||
                       (is_kind(kind, "command") && put_rewritten(session, statement, &text)) ||
                       put_misplaced(session, kind, statement, where, &text);
    const struct row *picture = catalog_find(&word_catalog, TEXT("picture"));
    const struct plot_row *studied = study_plot_of(own, statement);
    if (!kind && picture && own && text_is(text_of(own->row.name), "save") &&
        (text_is(where, "plot") || saves_figure(statement)))
        buffer_put(&text, text_of(picture->brief));
    else if (!kind && own && text_is(where, ">"))
        buffer_format(&text, "%s does not produce a table; 'export FILE table' writes the last one",
                      own->row.name);
    else if (is_kind(kind, "plot") && text_is(where, "plot"))
        buffer_put(&text, TEXT("leave out the last 'plot'"));
    else if (is_kind(kind, "plot") && studied)
        buffer_format(&text, "'plot %s' takes names of methods; 'list methods' lists them",
                      studied->row.name);
    else if (is_kind(kind, "method") && text_is(where, "all"))
        buffer_put(&text, TEXT("name each method; 'list methods' shows them"));
    else if (!known && !law)
        put_meanings(session, command, statement, where, kind, guessed, &text);
    if (is_kind(kind, "command") && text.len == 0)
        put_sentence(statement, guessed, &text);
    if (!kind && own && text_is(text_of(own->row.name), "plot") &&
        catalog_find(&plot_catalog, where)) {
        buffer_put(&text, text.len ? TEXT("; ") : TEXT(""));
        put_use("'plot %1' draws it separately", where, &text);
    }
    if (is_kind(kind, "method") && text.len == 0 && !error->hint[0])
        buffer_put(&text, TEXT("'list methods' lists them"));
    if (text.len > 0) {
        error->hint[0] = '\0';
        error_hint(error, "%s", buffer_view(&text));
    } else if (name) {
        put_named(session, law, where, &text);
        if (text.len > 0)
            error_hint(error, "%s", buffer_view(&text));
    } else if (kind && error->hint_kind <= HINT_LIST && where.len > 2 && is_mentioned(where)) {
        error_hint(error, "'apropos %.*s' searches for it", (int)where.len, where.data);
    }
    buffer_free(&text);
}

/* Improves the hint of an error about a word in the statement; other errors stay unchanged. */
void explain_unknown(const struct session *session, struct text statement, struct error *error)
{
    const struct text where = error->where;
    if (!where.data || where.data < statement.data || where.data > statement.data + statement.len ||
        error->code != ERROR_COMMAND)
        return;
    text_skip_blanks(&statement);
    explain_word(session, statement, error);
}
