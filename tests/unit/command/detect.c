/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One detector of oscillation: what one command refuses, all do, for the same reason; what one
 * accepts, all do. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/command/testing.h"
#include "unit/detect_recordings.h"

enum { ASKED = 4 };

static const char *const asked[ASKED] = {"data clean", "fit", "measure period", "measure decay"};

static void load(struct bench *bench, struct drawn (*draw_one)(void))
{
    struct drawn d = draw_one();
    FILE *file = fopen("rec.csv", "w");
    assert_non_null(file);
    fprintf(file, "t (s),y (cm)\n");
    for (size_t i = 0; i < d.n; i++)
        fprintf(file, "%.17g,%.17g\n", d.t[i], d.y[i]);
    assert_int_equal(fclose(file), 0);
    free(d.t);
    free(d.y);
    type_ok(bench, "load rec.csv");
}

/* Why the command says that it does not oscillate; "": it says no such thing. */
static void reason_of(struct bench *bench, const char *command, char reason[160])
{
    static const char words[] = "does not oscillate: ";
    type(bench, command);
    const char *at = strstr(said(&bench->err), words);
    at = at ? at : strstr(said(&bench->out), words);
    snprintf(reason, 160, "%.*s", at ? (int)strcspn(at + sizeof words - 1, ";\n") : 0,
             at ? at + sizeof words - 1 : "");
}

/* All commands agree, in the short form the first with one of the others; true: it oscillates. */
static bool judged_alike(struct bench *bench, const struct kind *kind, size_t turn, int run)
{
    char first[160], other[160];
    reason_of(bench, asked[0], first);
    for (int i = 1; i < ASKED; i++) {
        if (!is_long() && i != 1 + (int)(turn % (ASKED - 1)))
            continue;
        reason_of(bench, asked[i], other);
        if (strcmp(first, other) != 0)
            fail_msg("%s %d: '%s' says '%s', '%s' says '%s'", kind->name, run, asked[0], first,
                     asked[i], other);
    }
    return !first[0];
}

static void count_of(const struct kind *kind, size_t kinds, int *oscillate, int *all)
{
    const int runs = is_long() ? (int)(40 / kinds) : 1;
    struct bench bench;
    bench_open(&bench, false);
    random_state = 71;
    *oscillate = *all = 0;
    for (size_t k = 0; k < kinds; k++)
        for (int run = 0; run < runs; run++) {
            load(&bench, kind[k].draw);
            *oscillate += judged_alike(&bench, &kind[k], k, run);
            ++*all;
        }
    bench_close(&bench);
}

TEST(what_does_not_oscillate_is_refused_by_all)
{
    int oscillate, all;
    count_of(still, COUNT_OF(still), &oscillate, &all);
    assert_int_equal(oscillate, 0);
}

TEST(what_oscillates_is_accepted_by_all)
{
    int oscillate, all;
    count_of(moving, COUNT_OF(moving), &oscillate, &all);
    assert_int_equal(oscillate, all);
}

RUN_TESTS(enter_folder, leave_folder)
