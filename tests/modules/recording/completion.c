/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The names of the module's catalogs are completed where they stand. */
#include "cmocka_testing.h"

#include "unit/command/testing.h"

#include "modules/recording/fit/fit.h"

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

static const struct {
    const struct catalog *catalog;
    const char *before;
} places[] = {{&fit_catalog, "fit "}, {&quantity_catalog, "measure "}};

TEST(every_name_is_completed)
{
    struct bench b;
    bench_open(&b, false);
    for (size_t p = 0; p < COUNT_OF(places); p++)
        for (size_t i = 0; i < places[p].catalog->count; i++) {
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
