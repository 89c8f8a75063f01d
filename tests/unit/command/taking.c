/* SPDX-License-Identifier: GPL-3.0-or-later */
/* An argument given to the wrong command: the message names one that takes it. */
#include "cmocka_testing.h"

#include <hooke/method.h>
#include <hooke/scene/formula.h>
#include "command/finding.h"
#include "unit/command/testing.h"

static const struct command *command_number(size_t i)
{
    return command_at(catalog_row(&command_catalog, i));
}

static const struct argument *find_named(const struct command *command, struct text name)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form != FORM_PLACE && text_is(name, command->argument[i].name))
            return &command->argument[i];
    return NULL;
}

/* Parses a statement without executing it. True: it was refused, with the hint that a user sees. */
static bool refused(struct bench *b, const struct command *command, const char *statement,
                    struct error *error)
{
    struct names names = {.session = b->session};
    const struct expr_scope scope = names_scope(&names);
    struct arena arena = {0};
    struct text line = text_of(statement);
    struct parser parser = {b->session, &scope, &arena, line};
    const size_t word = strlen(command->row.name);
    parser.rest = (struct text){line.data + word, line.len - word};
    struct arguments *arguments = arena_alloc(&arena, sizeof *arguments);
    assert_non_null(arguments);
    arguments->scope = &scope;
    arguments->arena = &arena;
    arguments->command = command;
    const bool ok = parse_arguments(&parser, command, arguments, error);
    if (!ok)
        explain_unknown(b->session, line, error);
    arena_reset(&arena);
    return !ok;
}

/* How many commands it says, each in quotes with what follows: 'plot --full'; takes: one of them
 * takes that name. */
static int commands_said(const char *hint, struct text name, bool *takes)
{
    int count = 0;
    *takes = false;
    for (const char *at = strchr(hint, '\''); at; at = strchr(at, '\'')) {
        const struct text rest = text_of(++at);
        const struct command *said =
            command_at(catalog_find(&command_catalog, peek_word(rest, "'")));
        const char *end = strchr(at, '\'');
        count += said != NULL;
        *takes |= said && find_named(said, name);
        if (!end) /* a derivative: x' = EXPR */
            break;
        at = end + 1;
    }
    return count;
}

/* Every command is given what the others take: as an option and as NAME=VALUE. */
TEST(says_which_takes_it)
{
    struct bench b;
    int pairs = 0, settings = 0;
    bench_open(&b, false);
    for (size_t i = 0; i < command_catalog.count; i++)
        for (size_t j = 0; j < command_catalog.count; j++)
            for (int k = 0; k < command_number(j)->arguments; k++) {
                const struct command *to = command_number(i);
                const struct argument *of = &command_number(j)->argument[k];
                const struct text name = text_of(of->name);
                if ((of->form != FORM_OPTION && of->form != FORM_KEY) || find_named(to, name))
                    continue;
                char statement[128];
                struct error error = {0};
                bool takes;
                snprintf(statement, sizeof statement, "%s %s%s%s", to->row.name,
                         of->form == FORM_OPTION ? "--" : "", of->name,
                         of->form == FORM_KEY ? "=1" : "");
                if (!refused(&b, to, statement, &error) || !strstr(error.text, " has no "))
                    continue;
                const int said = commands_said(error.hint, name, &takes);
                const bool sets = catalog_find(&setting_catalog, name) &&
                                  strstr(error.hint, "= VALUE' as a command of its own sets it");
                if (!(takes || sets) || said > 3 || strlen(error.hint) > 260)
                    fail_msg("%s: %s (%s), %d commands", statement, error.text, error.hint, said);
                pairs++;
                settings += sets;
            }
    print_message("%d pairs, %d of settings\n", pairs, settings);
    assert_true(pairs > 2000);
    assert_true(settings > 50);
    bench_close(&b);
}

/* Gives every command each keyword of the other commands. An error that marks the keyword must have
 * a hint that quotes a command. */
TEST(hints_at_commands_with_a_keyword)
{
    struct bench b;
    int pairs = 0;
    bench_open(&b, false);
    for (size_t i = 0; i < command_catalog.count; i++)
        for (size_t j = 0; j < command_catalog.count; j++)
            for (int k = 0; k < command_number(j)->arguments; k++) {
                const struct command *to = command_number(i);
                const struct argument *of = &command_number(j)->argument[k];
                const struct text name = text_of(of->name);
                if (of->form != FORM_WORD || find_named(to, name) || of->name[0] == '>')
                    continue;
                char statement[128];
                struct error error = {0};
                bool takes;
                snprintf(statement, sizeof statement, "%s %s", to->row.name, of->name);
                if (!refused(&b, to, statement, &error) || error.where.len != name.len ||
                    memcmp(error.where.data, of->name, name.len) != 0)
                    continue;
                const int said = commands_said(error.hint, name, &takes);
                /* A name without a value yet: the hint names the command that gives it one. A
                 * choice: the hint lists the words. */
                const bool known = strstr(error.text, " has no value: ") ||
                                   strstr(error.text, "there is no run") ||
                                   strstr(error.hint, " is one of: ");
                if (!(known ? error.hint[0] != '\0' : strchr(error.hint, '\'') != NULL) ||
                    said > 3 || strlen(error.hint) > 260)
                    fail_msg("%s: %s (%s), %d commands", statement, error.text, error.hint, said);
                pairs++;
            }
    print_message("%d pairs\n", pairs);
    assert_true(pairs > 200);
    bench_close(&b);
}

/* No guess is the word itself. */
TEST(never_suggests_what_was_typed)
{
    struct bench b;
    bench_open(&b, false);
    for (size_t i = 0; i < command_catalog.count; i++)
        for (size_t j = 0; j < method_catalog.count; j++) {
            const char *name = catalog_row(&method_catalog, j)->name;
            char statement[128], guess[128];
            struct error error = {0};
            snprintf(statement, sizeof statement, "%s %s", command_number(i)->row.name, name);
            snprintf(guess, sizeof guess, "did you mean '%s'", name);
            if (refused(&b, command_number(i), statement, &error) && strstr(error.hint, guess))
                fail_msg("%s: %s", statement, error.hint);
        }
    bench_close(&b);
}

/* The cases of which the issue speaks. */
TEST(says_it_of_these)
{
    static const struct {
        const char *line, *says;
    } cases[] = {
        {"sweep gamma=0:1:0.1 duration=20", "'duration = VALUE' as a command of its own sets it"},
        {"run symplectic-euler", "'method symplectic-euler' chooses it"},
        {"window all", "usage: window [auto|TIME]; 'trail all'"},
        {"run all", "run all"},
        {"run dt=5 ms", "'dt = VALUE' as a command of its own sets it"},
        {"compare gamma=1 euler", "'gamma = VALUE' as a command of its own sets it"},
        {"order --bootstrap", "'fit --bootstrap"},
        {"print --grid", "'plot WHAT.. --grid'"},
    };
    (void)state;
    struct bench b;
    bench_open(&b, false);
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        if (is_left_out(cases[i].line))
            continue;
        assert_false(type(&b, cases[i].line));
        assert_says(&b.err, cases[i].says);
    }
    bench_close(&b);
}

RUN_TESTS(NULL, NULL)
