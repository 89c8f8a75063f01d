/* SPDX-License-Identifier: GPL-3.0-or-later */
/* All that can be chosen by name: one meaning each, explained by help, completed where it stands.
 * A row that is added is tested here the moment it exists. */
#include "cmocka_testing.h"

#include "unit/command/testing.h"

#include <hooke/base/unit.h>
#include <hooke/plot.h>

#include "command/finding.h"
#include "command/session/topics.h"
#include <hooke/report.h>
#include <hooke/scene/formula.h>

static const struct catalog *const catalogs[] = {
    &command_catalog,  &setting_catalog, &method_catalog,   &observable_catalog,
    &preset_catalog,   &unit_catalog,    &function_catalog, &plot_catalog,
    &quantity_catalog, &drag_catalog,    &layout_catalog,   &snap_catalog,
    &term_catalog,     &param_catalog,   &derived_catalog,  &table_format_catalog,
    &result_catalog};

/* Names that two catalogs share, and why nobody is misled. Every other name is the only one. */
static const struct {
    const char *names, *reason;
} shared[] = {
    {"amplitude energy energy-error energy_error error period spectrum",
     "one quantity: observed, drawn, measured, swept"},
    {"k", "the fit 'k' measures the parameter k"},
    {"exact", "the exact solution: stepped by, printed, of the drag alone"},
    {"spring drag vanderpol friction damped",
     "a force, what it depends on, the scene that shows it"},
    {"potential record timing precision scene", "a command, and what it sets, makes or fits"},
    {"runs", "a command, and the table of what it shows"},
    {"peak", "what a cursor snaps to, and lines of a spectrum"},
    {"plot", "the layout is that of the command's figure alone"},
    {"phase", "'plot phase' is of v against y, phase = 0 is that of the drive: by INTERFACE.md"},
    {"m g s min", "a unit stands behind a number"},
    {"min max step", "a function stands before a parenthesis"},
    {"log", "'layout log', log(x)"},
};

/* Those above, then those of modules; NULL beyond the last. */
static const struct catalog *catalog_number(size_t i)
{
    if (i < COUNT_OF(catalogs))
        return catalogs[i];
    i -= COUNT_OF(catalogs);
    for (size_t m = 0; module_list[m]; m++)
        for (const struct catalog *const *own = module_list[m]->catalogs; own && *own; own++)
            if (i-- == 0)
                return *own;
    return NULL;
}

static bool is_shared(const char *name, bool *used)
{
    bool found = false;
    const size_t len = strlen(name);
    for (size_t i = 0; i < COUNT_OF(shared); i++) {
        const char *const names = shared[i].names;
        for (const char *at = strstr(names, name); at; at = strstr(at + 1, name))
            if ((at == names || at[-1] == ' ') && (!at[len] || at[len] == ' '))
                found = used[i] = true;
    }
    return found;
}

/* Returns true if both catalogs have the name of a command, of the result that its row names as
 * what the command makes, or of the plot of that. */
static bool is_of_one_command(const char *name, const struct catalog *a, const struct catalog *b)
{
    const struct catalog *const kind[] = {&command_catalog, &result_catalog, &plot_catalog};
    const struct row *row = catalog_find(&result_catalog, text_of(name));
    const char *made_by = row ? ((const struct result_row *)(const void *)row)->type : NULL;
    if (!made_by || !text_is(peek_word(text_of(made_by), ""), name))
        return false;
    int kinds = 0;
    for (size_t i = 0; i < COUNT_OF(kind); i++)
        kinds += (kind[i] == a) + (kind[i] == b);
    return kinds == 2;
}

TEST(every_name_has_one_meaning)
{
    bool used[COUNT_OF(shared)] = {false};
    struct buffer wrong = {0};
    for (size_t c = 0; catalog_number(c); c++)
        for (size_t i = 0; i < catalog_number(c)->count; i++)
            for (size_t d = 0; catalog_number(d); d++) {
                const char *name = catalog_row(catalog_number(c), i)->name;
                const struct row *other = catalog_find(catalog_number(d), text_of(name));
                if (!other || other == catalog_row(catalog_number(c), i))
                    continue;
                if (c == d || (!is_shared(name, used) &&
                               !is_of_one_command(name, catalog_number(c), catalog_number(d))))
                    buffer_format(&wrong, "\n'%s' is a %s and a %s", name, catalog_number(c)->kind,
                                  catalog_number(d)->kind);
            }
    for (size_t i = 0; i < COUNT_OF(shared); i++)
        if (!used[i])
            buffer_format(&wrong, "\nnothing shares '%s' any more", shared[i].names);
    if (wrong.len)
        fail_msg("%s", buffer_view(&wrong));
    buffer_free(&wrong);
}

TEST(every_name_is_explained)
{
    struct bench b;
    bench_open(&b, false);
    for (size_t c = 0; catalog_number(c); c++)
        for (size_t i = 0; i < catalog_number(c)->count; i++) {
            const struct row *row = catalog_row(catalog_number(c), i);
            char line[128];
            snprintf(line, sizeof line, "help %s", row->name);
            type_ok(&b, line);
            if (!row->brief[0])
                fail_msg("%s %s has no explanation", catalog_number(c)->kind, row->name);
        }
    bench_close(&b);
}

struct found {
    const char *name;
    bool offered;
};

static void look(void *context, const char *candidate, const char *brief)
{
    struct found *found = context;
    assert_non_null(brief);
    found->offered |= strcmp(candidate, found->name) == 0;
}

/* Where names of a catalog stand. */
static const struct {
    const struct catalog *catalog;
    const char *before;
} places[] = {
    {&command_catalog, ""},          {&setting_catalog, "set "},
    {&method_catalog, "method "},    {&method_catalog, "compare "},
    {&preset_catalog, "scene "},     {&plot_catalog, "plot "},
    {&plot_catalog, "focus "},       {&layout_catalog, "layout "},
    {&param_catalog, "set "},        {&plot_catalog, "help "},
    {&guide_catalog, "help "},       {&word_catalog, "help "},
    {&snap_catalog, "cursor snap "}, {&result_catalog, "export x.csv table of "},
};

TEST(every_name_is_completed)
{
    struct bench b;
    bench_open(&b, false);
    for (size_t p = 0; p < COUNT_OF(places); p++)
        for (size_t i = 0; !is_left_out(places[p].before) && i < places[p].catalog->count; i++) {
            struct found found = {catalog_row(places[p].catalog, i)->name, false};
            char line[128];
            size_t start;
            const int len = snprintf(line, sizeof line, "%s%.2s", places[p].before, found.name);
            command_complete(b.session, text_of(line), (size_t)len, &start, look, &found);
            if (!found.offered)
                fail_msg("'%s' does not offer %s", line, found.name);
        }
    bench_close(&b);
}

RUN_TESTS(NULL, NULL)
