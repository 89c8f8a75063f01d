/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every command: described, explained, refusing what it does not know, completed. */
#include "cmocka_testing.h"

#include <hooke/base/unit.h>
#include <hooke/scene/formula.h>
#include "unit/command/testing.h"

static const struct command *command_number(size_t i)
{
    return (const struct command *)(const void *)catalog_row(&command_catalog, i);
}

struct found {
    struct buffer names;
    int count;
};

static void collect(void *context, const char *candidate, const char *brief)
{
    struct found *found = context;
    assert_non_null(brief);
    buffer_format(&found->names, " %s ", candidate);
    found->count++;
}

TEST(every_command_is_described)
{
    struct bench b;
    bench_open(&b, false);
    b.session->front.watched = true; /* long lines are broken by the log, not by help */
    assert_true(command_catalog.count >= 40);
    for (size_t i = 0; i < command_catalog.count; i++) {
        const struct command *c = command_number(i);
        struct buffer usage = {0};
        char line[64];
        if (!c->row.brief[0] || !c->text[0] || !c->group[0])
            fail_msg("%s lacks an explanation", c->row.name);
        const char *second = strchr(c->examples, '\n');
        if (!second || strchr(second + 1, '\n'))
            fail_msg("%s has not two examples", c->row.name);
        struct text see = text_of(c->see), word;
        while (text_split(&see, ' ', &word))
            if (!catalog_find(&command_catalog, word) && !is_left_out(word.data))
                fail_msg("%s: see also '%.*s'", c->row.name, (int)word.len, word.data);
        for (size_t j = i + 1; j < command_catalog.count; j++)
            assert_string_not_equal(c->row.name, command_number(j)->row.name);
        snprintf(line, sizeof line, "help %s", c->row.name);
        type_ok(&b, line);
        command_usage(c, &usage);
        assert_says(&b.out, usage.data);
        buffer_free(&usage);
    }
    bench_close(&b);
}

/* An option that no command has, and a quote without end: an error with a caret, for every command
 * that does not take any text. */
TEST(every_command_refuses_nonsense)
{
    struct bench b;
    bench_open(&b, false);
    for (size_t i = 0; i < command_catalog.count; i++) {
        const struct command *c = command_number(i);
        struct buffer usage = {0};
        char line[64];
        command_usage(c, &usage);
        const bool takes_text = strcmp(c->group, "EQUATIONS") == 0 || strstr(usage.data, "TEXT") ||
                                strstr(usage.data, "WORD") || strstr(usage.data, "VALUE");
        buffer_free(&usage);
        if (takes_text && strcmp(c->row.name, "load") != 0)
            continue;
        snprintf(line, sizeof line, "%s --nonsense", c->row.name);
        if (type(&b, line))
            fail_msg("'%s' was accepted", line);
        assert_says(&b.err, "has no option 'nonsense'");
        assert_says(&b.err, "^~~~~~~~");
        snprintf(line, sizeof line, "%s 'x", c->row.name);
        assert_false(type(&b, line));
        assert_says(&b.err, "is not closed");
    }
    assert_int_equal(b.session->undo.undos, 0);
    bench_close(&b);
}

/* A slip of the finger in its name is answered with the name, the beginning of it is completed; in
 * a script only the whole name will do. */
TEST(every_command_is_suggested_and_completed)
{
    struct bench b;
    bench_open(&b, false);
    for (size_t i = 0; i < command_catalog.count; i++) {
        const char *name = command_number(i)->row.name;
        const struct source script = {.name = "s.hk", .line = 7};
        char line[64], wanted[64];
        struct found found = {.count = 0};
        size_t start;
        snprintf(line, sizeof line, "%.*sq%s", (int)strlen(name) - 1, name,
                 name + strlen(name) - 1);
        snprintf(wanted, sizeof wanted, "'%s'", name);
        buffer_clear(&b.err);
        b.session->execution.status = 0;
        assert_false(command_exec(b.session, text_of(line), &script, &b.reply));
        assert_int_equal(b.session->execution.status, 1);
        assert_says(&b.err, "s.hk:7:1: error: ");
        assert_says(&b.err, "did you mean ");
        assert_says(&b.err, wanted);
        snprintf(wanted, sizeof wanted, " %s ", name);
        command_complete(b.session, (struct text){name, strlen(name) - 1}, strlen(name) - 1, &start,
                         collect, &found);
        assert_says(&found.names, wanted);
        buffer_free(&found.names);
    }
    bench_close(&b);
}

static void every_row_is_explained(struct bench *b, const struct catalog *catalog)
{
    for (size_t i = 0; i < catalog->count; i++) {
        char line[80];
        snprintf(line, sizeof line, "help %s", catalog_row(catalog, i)->name);
        type_ok(b, line);
        assert_says(&b->out, catalog_row(catalog, i)->brief);
    }
}

/* Every name that can be chosen is found by help, completion and apropos. */
TEST(every_row_has_help)
{
    const struct catalog *const catalogs[] = {&setting_catalog,    &method_catalog,
                                              &preset_catalog,     &unit_catalog,
                                              &observable_catalog, &function_catalog};
    struct bench b;
    bench_open(&b, false);
    b.session->front.watched = true; /* long lines are broken by the log, not by help */
    for (size_t c = 0; c < COUNT_OF(catalogs); c++)
        every_row_is_explained(&b, catalogs[c]);
    for (const struct model *const *model = scene_models; *model; model++) {
        every_row_is_explained(&b, (*model)->params);
        every_row_is_explained(&b, (*model)->derived);
    }
    bench_close(&b);
}

/* What F1 asks for: the word at the cursor |, inside an argument the argument. */
TEST(help_is_about_the_cursor)
{
    static const char *const cases[][2] = {
        {"|", "help"},
        {"compare|", "help compare"},
        {"comp|are euler", "help compare"},
        {"compare eu|ler dt=5", "help compare euler"},
        {"compare euler dt=5|", "help compare dt="},
        {"compare euler d|t=5 ms", "help compare dt="},
        {"compare euler dt=5   |", "help compare dt="},
        {"compare  |", "help compare"},
        {"measure per|iod of run 1", "help measure period"},
        {"run 5; measure period  |", "help measure period"},
        {"run 5|; measure period", "help run"},
        {"run until y < 0|", "help run"},
        {"fit --rob|ust", "help fit --robust"},
        {"plot phase,ene|rgy", "help plot energy"},
        {"sweep gam|ma=0:1", "help sweep gamma="},
        {"gamma = 5|", "help gamma"},
        {"gamma = 2*ome|ga0", "help omega0"},
        {"x' = -k*x|", "help x"},
        {"set opinion|", "help set opinion"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct buffer line = {0};
        char typed[64];
        const size_t cursor = strcspn(cases[i][0], "|");
        const char *about = strchr(cases[i][1], ' ');
        if (about && is_left_out(about))
            continue;
        snprintf(typed, sizeof typed, "%.*s%s", (int)cursor, cases[i][0], cases[i][0] + cursor + 1);
        help_line(text_of(typed), cursor, &line);
        if (strcmp(buffer_view(&line), cases[i][1]) != 0)
            fail_msg("at %s F1 asks '%s', not '%s'", cases[i][0], buffer_view(&line), cases[i][1]);
        buffer_free(&line);
    }
}

/* Every argument that has a name is explained, as the command's and nothing else of that name. */
TEST(every_argument_is_explained)
{
    static const char *const marks[] = {[FORM_KEY] = "=", [FORM_OPTION] = "", [FORM_WORD] = ""};
    struct bench b;
    bench_open(&b, false);
    b.session->front.watched = true;
    for (size_t c = 0; c < command_catalog.count; c++)
        for (int i = 0; i < command_number(c)->arguments; i++) {
            const struct argument *argument = &command_number(c)->argument[i];
            char line[96], said[96];
            if (argument->form == FORM_PLACE || argument->name[0] == '>' ||
                (argument->form == FORM_KEY && type_is(argument, TYPE_IS_ANY_KEY)))
                continue;
            const char *name = command_number(c)->row.name;
            snprintf(line, sizeof line, "help %s %s%s%s", name,
                     argument->form == FORM_OPTION ? "--" : "", argument->name,
                     marks[argument->form]);
            snprintf(said, sizeof said, ", an argument of %s", name);
            buffer_clear(&b.out);
            type_ok(&b, line);
            assert_says(&b.out, said);
        }
    bench_close(&b);
}

/* ---- completion ---- */

static void complete(struct bench *b, const char *line, struct found *found, size_t *start,
                     bool *file)
{
    *found = (struct found){.count = 0};
    *file = command_complete(b->session, text_of(line), strlen(line), start, collect, found);
    buffer_put(&found->names, TEXT(""));
}

TEST(completion_follows_the_type)
{
    static const struct {
        const char *line, *with, *without;
        size_t start;
        bool file;
    } cases[] = {
        {"", " run ", " euler ", 0, false},
        {"co", " continue ", " run ", 0, false},
        {"echo a; me", " method ", " m ", 8, false},
        {"ga", " gamma ", " y0 ", 0, false},
        {"set ", " gamma ", " run ", 4, false},
        {"set m 5 ", " kg ", " cm ", 8, false},
        {"set m 5 k", " kg ", " g ", 8, false},
        {"m = 200 ", " g ", " cm ", 8, false},
        {"m = ", " k ", " kg ", 4, false},
        {"set charset ", " braille ", " kg ", 12, false},
        {"method ", " verlet ", " run ", 7, false},
        {"method verlet d", " drag= ", " tol= ", 14, false},
        {"method verlet drag=", " implicit ", " verlet ", 19, false},
        {"method verlet dt=5 ", " ms ", " kg ", 19, false},
        {"compare euler ", " rk4 ", " run ", 14, false},
        {"compare euler dt=1 ms,2 ", " ms ", " kg ", 24, false},
        {"run 5 ", " s ", " kg ", 6, false},
        {"run --", " --force ", " s ", 4, false},
        {"run until ", " energy ", " s ", 10, false},
        {"measure ", " period ", " run ", 8, false},
        {"measure period of ", " data ", " period ", 18, false},
        {"measure period of ", " momentum ", " k ", 18, false},
        {"measure period of run ", " 1 ", " data ", 22, false},
        {"plot position run ", " all ", " data ", 18, false},
        {"plot ", " phase ", " m ", 5, false},
        {"plot y at ", " top ", " phase ", 10, false},
        {"plot y against v at top --", " --next ", " --kept ", 24, false},
        {"set record ", " every ", " kg ", 11, false},
        {"help sym", " symplectic-euler ", " run ", 5, false},
        {"list ", " methods ", " euler ", 5, false},
        {"load ", " as= ", " run ", 5, true},
        {"save ", " --force ", " run ", 5, true},
        {"load \"my f", "", " as= ", 5, true},
        {"load my\\ f", "", " as= ", 5, true},
        {"load scene ", "", " as= ", 11, true},
        {"run; plot position > 'my f", "", " run ", 21, true},
        {"plot position title=\"my f", "", " run ", 0, false},
        {"export x.csv ", " energy ", " m ", 13, false},
        {"export x.csv table ", " of ", " compare ", 19, false},
        {"export x.csv table of ", " measurements ", " of ", 22, false},
        {"compare euler > ", "", " rk4 ", 16, true},
        {"sweep k=1:2 > ", "", " measure= ", 14, true},
        {"plot error against dt of ", " events ", " position ", 25, false},
        {"print sq", " sqrt ", " y ", 6, false},
        {"scene ", " damped ", " euler ", 6, false},
        {"echo 'a; ", "", " run ", 0, false},
        {"sweep ga", " gamma= ", " run ", 6, false},
        {"sweep k=1:2 me", " measure= ", " gamma= ", 12, false},
        {"sweep k=1:2 measure=y,", " amplitude ", " gamma= ", 22, false},
        {"sweep k=1:2 measure=", " energy ", " gamma= ", 20, false},
        {"sweep y0=1 ", " cm ", " N/m ", 11, false},
        {"sweep y0=1 cm:5 ", " mm ", " kg ", 16, false},
        {"sweep T0=1:2 ", " dt= ", " omega_d= ", 13, false},
        {"sweep k=1:2 a", " at ", " gamma= ", 12, false},
        {"sweep k=1:2 at ", " period ", " gamma= ", 15, false},
        {"sweep k=1:2 at period sk", " skip= ", " gamma= ", 22, false},
    };
    struct bench b;
    bench_open(&b, true);
    type_ok(&b, "event top when v falling do record; run 1 s");
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct found found;
        size_t start = 0;
        bool file;
        if (is_left_out(cases[i].line))
            continue;
        complete(&b, cases[i].line, &found, &start, &file);
        if (!strstr(found.names.data, cases[i].with) ||
            strstr(found.names.data, cases[i].without) || start != cases[i].start ||
            file != cases[i].file)
            fail_msg("'%s': start %zu, file %d:%s", cases[i].line, start, file, found.names.data);
        buffer_free(&found.names);
    }
    size_t start;
    struct found none = {.count = 0};
    if (!is_left_out("load")) {
        assert_string_equal(command_complete(b.session, TEXT("load "), 5, &start, collect, &none),
                            "");
        assert_string_equal(
            command_complete(b.session, TEXT("load scene 'a"), 13, &start, collect, &none), ".ode");
    }
    buffer_free(&none.names);
    bench_close(&b);
}

/* What completion offers behind `before`, one after another, is read by the parser: no word of it
 * is unknown there, or one too many. */
static int check_offers(struct bench *b, const struct command *command, const char *before)
{
    struct found found;
    size_t start;
    bool file;
    complete(b, before, &found, &start, &file);
    struct text rest = buffer_text(&found.names), offer;
    int wrong = 0;
    while (rest.len > 0 && text_split(&rest, ' ', &offer)) {
        char line[256];
        struct arena arena = {0};
        struct arguments arguments = {.command = command, .arena = &arena};
        struct error error = {0};
        if (offer.len == 0)
            continue;
        snprintf(line, sizeof line, "%.*s%.*s", (int)start, before, (int)offer.len, offer.data);
        const struct text all = text_of(line);
        const size_t name = strlen(command->row.name);
        struct names names = {.session = b->session, .expects_run = true};
        const struct expr_scope scope = names_scope(&names);
        struct parser parser = {b->session, &scope, &arena, {all.data + name, all.len - name}};
        arguments.scope = &scope;
        if (!parse_arguments(&parser, command, &arguments, &error) &&
            (strstr(error.text, "unknown") || strstr(error.text, "unexpected") ||
             strstr(error.text, " has no "))) {
            print_message("# '%s': %s\n", line, error.text);
            wrong++;
        }
        arena_reset(&arena);
    }
    buffer_free(&found.names);
    return wrong;
}

TEST(offers_are_accepted)
{
    struct bench b;
    int wrong = 0;
    bench_open(&b, true);
    type_ok(&b, "event top when v falling do record; run 1 s");
    for (size_t i = 0; i < command_catalog.count; i++) {
        const struct command *command = command_number(i);
        char line[128];
        snprintf(line, sizeof line, "%s ", command->row.name);
        wrong += check_offers(&b, command, line);
        snprintf(line, sizeof line, "%s --", command->row.name);
        wrong += check_offers(&b, command, line);
        for (int a = 0; a < command->arguments; a++) {
            const struct argument *argument = &command->argument[a];
            if (argument->form == FORM_PLACE || argument->name[0] == '>')
                continue;
            snprintf(line, sizeof line, "%s %s%s%s", command->row.name,
                     argument->form == FORM_OPTION ? "--" : "", argument->name,
                     argument->form == FORM_KEY ? "=" : " ");
            wrong += check_offers(&b, command, line);
        }
    }
    assert_int_equal(wrong, 0);
    bench_close(&b);
}

TEST(completion_survives_anything)
{
    static const char bytes[] = "run set m=5 ;'\"#,>--\\ y<\t:";
    struct bench b;
    uint32_t random = 1;
    bench_open(&b, true);
    for (int i = 0; i < 20000; i++) {
        char line[24];
        struct found found = {.count = 0};
        size_t len = 0, start;
        for (; len < sizeof line - 1; len++) {
            random = random * 1664525u + 1013904223u;
            line[len] = bytes[(random >> 16) % (sizeof bytes - 1)];
        }
        const size_t cursor = (random >> 8) % (len + 1);
        command_complete(b.session, (struct text){line, len}, cursor, &start, collect, &found);
        assert_true(found.count == 0 || start <= cursor);
        buffer_free(&found.names);
    }
    bench_close(&b);
}

RUN_TESTS(NULL, NULL)
