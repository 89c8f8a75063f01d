/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The file of a session: random sessions come back from it bit for bit, as they were when it was
 * last written whole, wherever it is torn or damaged. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/resume/testing.h"
#include "unit/command/random_session.h"
#include "modules/dynamics/dynamics.h"

#include "modules/recording/fits.h"
#include <hooke/base/fields.h>
#include <hooke/run/store.h>
#include "modules/dynamics/dynamics_results.h"

/* ---- all there is, as text ---- */

static void put_bits(struct buffer *text, const char *name, const void *bytes, size_t count)
{
    buffer_format(text, "%s %016llx\n", name,
                  (unsigned long long)bytes_sum((struct text){bytes, count}));
}

static void put_computed(const struct run_slot *slot, struct buffer *text)
{
    const struct run *run = slot->run;
    struct buffer rows = {0};
    struct ledger ledger;
    const struct request **list;
    int count;
    run_store_rows(run, 0, run_recorded(run), &rows);
    buffer_format(text, "%zu rows of %d\n", run_recorded(run), run->number);
    put_bits(text, "rows", rows.data, rows.len);
    for (size_t i = 0; i < run_event_records(run); i++)
        put_bits(text, "event", run_event_record(run, i), sizeof *run_event_record(run, i));
    put_bits(text, "cost", &run->cost, sizeof run->cost);
    buffer_format(text, "stop %d seconds %a opinion %a %a %a\n", (int)run->stop, run->seconds,
                  run->opinion.error, run->opinion.max, run->opinion.lost);
    assert_true(journal_list(slot->last, 0, &list, &count));
    for (int i = 0; i < count; i++)
        buffer_format(text, "%d from %lld at %a to %a end %lld '%s' met %lld back %lld\n",
                      (int)list[i]->kind, (long long)list[i]->start_step, list[i]->from_t,
                      list[i]->t, (long long)list[i]->end,
                      list[i]->condition ? list[i]->condition : "", (long long)list[i]->met,
                      (long long)list[i]->rows);
    free(list);
    run_ledger(run, &ledger);
    put_bits(text, "ledger", &ledger, sizeof ledger);
    buffer_free(&rows);
}

static void put_results(const struct session *session, struct buffer *text)
{
    for (int i = 0; i < session->results.count; i++)
        buffer_format(text, "%s = %a +- %a\n", session->results.value[i].name,
                      session->results.value[i].value, session->results.value[i].uncertainty);
    for (int i = 0; i < session->measurements; i++)
        buffer_format(text, "%s of %s: %a\n", session->measurement[i].quantity,
                      session->measurement[i].source, session->measurement[i].value.value);
    for (int i = 0; i < fits_of(session)->stored_fits; i++)
        buffer_format(text, "fit %s of %s: %a\n", fits_of(session)->stored_fit[i].fit.model,
                      fits_of(session)->stored_fit[i].subject,
                      fits_of(session)->stored_fit[i].fit.period.value);
    if (fits_of(session)->has_fit)
        buffer_format(text, "last fit %s of %s: %a, %zu samples\n", fits_of(session)->fit.model,
                      fits_of(session)->fit_of, fits_of(session)->fit.rms,
                      fits_of(session)->fit_samples);
    for (int i = 0; i < session->studies.found.count; i++) {
        buffer_format(text, "table %s\n", session->studies.found.table[i]->kind);
        table_put(&session->studies.found.table[i]->table, table_csv, text);
    }
}

static void put_recorded(const struct recording *recording, struct buffer *text)
{
    put_bits(text, "t", recording->t, recording->rows * sizeof *recording->t);
    put_bits(text, "y", recording->y, recording->rows * sizeof *recording->y);
    const char *slash = strrchr(recording->path, '/');
    buffer_format(text, "'%s' %s\n", slash ? slash + 1 : recording->path, recording->format);
}

static void put_found(const struct dynamics *d, struct buffer *text)
{
    if (!d)
        return;
    buffer_format(text, "found of %s\n", d->equations);
    put_bits(text, "equilibria", d->equilibria.solution,
             (size_t)d->equilibria.count * sizeof *d->equilibria.solution);
    for (int i = 0; i < d->orbits; i++) {
        put_bits(text, "orbit", &d->orbit[i].solution, sizeof d->orbit[i].solution);
        put_bits(text, "sample", d->orbit[i].sample,
                 (size_t)(d->orbit[i].samples * (d->n + 1)) * sizeof *d->orbit[i].sample);
    }
    for (int i = 0; i < d->branches; i++) {
        const struct stored_branch *b = d->branch[i];
        buffer_format(text, "branch %d of %s\n", b->number, b->origin);
        put_bits(text, "points", b->branch.point,
                 (size_t)b->branch.count * sizeof *b->branch.point);
        put_bits(text, "special", b->special, (size_t)b->specials * sizeof *b->special);
    }
}

static void describe_all(const struct session *session, struct buffer *text)
{
    describe(session, (unsigned)-1, text);
    for (int i = 0; i < session->runs.count; i++)
        put_computed(session->runs.slot[i], text);
    for (int i = 0; i < session->recordings; i++)
        put_recorded(session->recording[i]->recording, text);
    put_results(session, text);
    const struct dynamics_part *part = session_part_if_made(session, &dynamics_module);
    put_found(part ? part->found : NULL, text);
    buffer_format(text, "next run %d\n", session->runs.next_number);
    history_put(session, 0, HISTORY_RECORD, text);
    assert_false(text->failed);
}

/* ---- sessions ---- */

/*
 * Commands that random sessions do not play: those that take seconds (they keep a table, as order
 * does), of the front end (tests/terminal), record (unit/command/sessions plays under it), report
 * (reads only), recipe (its lines are played), steps of a lesson (modules/resume/session), collect
 * and stop, which wait for a device (those of the module collect).
 */
static const char unplayed[] = " selftest precision stress pause clear panes plain redraw "
                               "screenshot scroll quit record report recipe lab check hint skip "
                               "again collect stop ";

static bool played[256]; /* by their place in the rows: those that succeeded */

static void note_played(const struct session *session)
{
    for (size_t i = session->history.first; i < session->history.count; i++) {
        const struct entry *entry = history_entry(session, i);
        struct text text = text_trim(history_text(session, entry)), name = peek_name(text);
        const char after = text.data[name.len < text.len ? name.len : 0];
        size_t blank = name.len;
        while (blank < text.len && text.data[blank] == ' ')
            blank++;
        if (after == '\'')
            name = TEXT("equation");
        else if (blank < text.len && text.data[blank] == '=')
            name = TEXT("set");
        const struct row *row = catalog_find(&command_catalog, name);
        if (row && entry->flags & ENTRY_DONE && !(entry->flags & ENTRY_LINE))
            played[catalog_index(&command_catalog, row)] = true;
    }
}

struct kept {
    struct bench b;
    struct stored stored;
    struct buffer file, typed;
};

static void begin(struct kept *kept, uint64_t seed)
{
    *kept = (struct kept){.file = {0}};
    bench_open(&kept->b, false);
    random_state = seed;
    type_ok(&kept->b, "duration = 4 ms"); /* a condition that stays false ends after 1000 of them */
    if (dice(2))
        type_ok(&kept->b, "load swing.txt as=one; load speed.txt as=two");
}

static void play_one(struct kept *kept)
{
    if (dice(4) == 0) {
        const char *line = dice(2) ? other_command() : study_or_result();
        const bool ok = type(&kept->b, line);
        buffer_format(&kept->typed, "%s%s\n", line, ok ? "" : " # fails");
    } else {
        play_statement(&kept->b, &kept->typed);
    }
}

static void end(struct kept *kept)
{
    note_played(kept->b.session);
    bench_close(&kept->b);
    stored_free(&kept->stored);
    buffer_free(&kept->file);
    buffer_free(&kept->typed);
}

static int long_or(int many, int few)
{
    return is_long() ? many : few;
}

/* And it goes on from there as the other does. */
static void assert_goes_on(struct kept *kept, struct bench *again)
{
    static const char *const lines[] = {"continue 0.4 s", "step 3",         "change k 17",
                                        "back 2",         "continue 0.3 s", "run 0.2 s",
                                        "measure energy", "measure energy"};
    struct buffer wanted = {0}, got = {0};
    for (size_t i = 0; i < COUNT_OF(lines); i++) {
        const bool ok = type(&kept->b, lines[i]);
        if (type(again, lines[i]) != ok)
            fail_msg("%s'%s': %s%s", said(&kept->typed), lines[i], said(&kept->b.err),
                     said(&again->err));
        buffer_clear(&wanted);
        buffer_clear(&got);
        for (int r = 0; r < kept->b.session->runs.count; r++)
            put_run(kept->b.session->runs.slot[r], PART_STOPS, &wanted);
        for (int r = 0; r < again->session->runs.count; r++)
            put_run(again->session->runs.slot[r], PART_STOPS, &got);
        assert_same(&wanted, &got, lines[i], &kept->typed);
    }
    buffer_free(&wanted);
    buffer_free(&got);
}

TEST(a_session_comes_back_bit_for_bit)
{
    struct buffer wanted = {0}, got = {0}, notes = {0};
    write_recordings();
    for (int i = 0; i < long_or(1000, 12); i++) {
        struct kept kept;
        struct bench again;
        begin(&kept, 5000 + (uint64_t)i);
        for (int k = 0; k < LINES; k++) {
            play_one(&kept);
            if (dice(4) == 0)
                bench_store(kept.b.session, &kept.stored, &kept.file);
        }
        describe_all(kept.b.session, &wanted);
        bench_store(kept.b.session, &kept.stored, &kept.file);
        buffer_clear(&notes);
        if (!bench_restore(&again, buffer_text(&kept.file), &notes) || notes.len > 0)
            fail_msg("session %d: %s%s", i, said(&kept.typed), said(&notes));
        describe_all(again.session, &got);
        assert_same(&wanted, &got, "kept", &kept.typed);
        assert_goes_on(&kept, &again);
        bench_close(&again);
        end(&kept);
    }
    buffer_free(&wanted);
    buffer_free(&got);
    buffer_free(&notes);
}

/* Of what was typed the oldest goes, and what is left is numbered as before: in this session, and
 * as it comes back from a file, whether that was written along the way or at the end. */
TEST(what_was_typed_is_bounded)
{
    enum { WIDTH = 900000, TYPED = 50 };
    static char line[WIDTH + 32];
    struct kept kept;
    struct bench again;
    struct stored late = {0};
    struct buffer late_file = {0}, wanted = {0}, notes = {0};
    begin(&kept, 1);
    const struct history *log = &kept.b.session->history;
    for (int i = 0; i < TYPED; i++) {
        snprintf(line, sizeof line, "%*s let A%d = %d", WIDTH, "", i, i);
        type_ok(&kept.b, line);
        bench_store(kept.b.session, &kept.stored, &kept.file);
        assert_true(log->text.len <= 2 * LIMIT_HISTORY_TEXT + sizeof line);
    }
    assert_true(log->first > 0 && log->text_first > 0 && log->count > log->first);
    bench_store(kept.b.session, &late, &late_file);
    assert_true(late_file.len < 2 * LIMIT_HISTORY_TEXT + 100000);
    type_ok(&kept.b, "history 2");
    buffer_put(&wanted, buffer_text(&kept.b.out));
    assert_true(strstr(said(&wanted), "let A49 = 49") != NULL);
    for (int i = 0; i < 2; i++) {
        if (!bench_restore(&again, buffer_text(i ? &late_file : &kept.file), &notes) || notes.len)
            fail_msg("%s", said(&notes));
        type_ok(&again, "history 2");
        assert_string_equal(said(&again.out), said(&wanted));
        type_ok(&again, "print A49");
        bench_close(&again);
    }
    for (int i = 0; i < TYPED; i++)
        type_ok(&kept.b, "undo"); /* their statements are gone: their names, too */
    stored_free(&late);
    buffer_free(&late_file);
    buffer_free(&wanted);
    buffer_free(&notes);
    end(&kept);
}

/* ---- what is torn ---- */

#define STORES 8

TEST(a_torn_file_is_as_it_was_last_whole)
{
    static struct buffer at[STORES];
    struct buffer got = {0}, notes = {0};
    size_t whole[STORES];
    write_recordings();
    for (int i = 0; i < long_or(500, 6); i++) {
        struct kept kept;
        begin(&kept, 7000 + (uint64_t)i);
        for (int s = 0; s < STORES; s++) {
            for (int k = 0; k < LINES / STORES; k++)
                play_one(&kept);
            describe_all(kept.b.session, &at[s]);
            bench_store(kept.b.session, &kept.stored, &kept.file);
            whole[s] = kept.file.len;
        }
        for (int cut = 0; cut < 4; cut++) {
            struct bench again;
            const size_t len = whole[0] + (size_t)dice((int)(kept.file.len - whole[0] + 1));
            int last = 0;
            while (last + 1 < STORES && whole[last + 1] <= len)
                last++;
            buffer_clear(&notes);
            if (!bench_restore(&again, (struct text){kept.file.data, len}, &notes) || notes.len > 0)
                fail_msg("session %d cut at %zu: %s", i, len, said(&notes));
            describe_all(again.session, &got);
            assert_same(&at[last], &got, "torn", &kept.typed);
            bench_close(&again);
        }
        end(&kept);
    }
    for (int s = 0; s < STORES; s++)
        buffer_free(&at[s]);
    buffer_free(&got);
    buffer_free(&notes);
}

/* Whatever is changed in it: it comes back, and what does not is named; nothing is refused whole
 * but what has no whole part. */
TEST(damage_is_named)
{
    struct buffer notes = {0};
    int named = 0;
    write_recordings();
    for (int i = 0; i < long_or(500, 6); i++) {
        struct kept kept;
        begin(&kept, 9000 + (uint64_t)i);
        for (int s = 0; s < STORES; s++) {
            for (int k = 0; k < LINES / STORES; k++)
                play_one(&kept);
            bench_store(kept.b.session, &kept.stored, &kept.file);
        }
        for (int hit = 0; hit < 4; hit++) {
            struct bench again;
            const size_t where =
                strlen(STORE_HEADER) + (size_t)dice((int)(kept.file.len - strlen(STORE_HEADER)));
            kept.file.data[where] ^= (char)(1 << dice(8));
            buffer_clear(&notes);
            assert_true(bench_restore(&again, buffer_text(&kept.file), &notes));
            named += notes.len > 0;
            bench_close(&again);
        }
        end(&kept);
    }
    assert_true(named > 0);
    buffer_free(&notes);
}

/* The current run is damaged, and what was adopted is made by commands. */
TEST(an_adopted_fit_without_its_run)
{
    struct kept kept;
    struct bench again;
    struct buffer notes = {0};
    write_recordings();
    begin(&kept, 3);
    type_ok(&kept.b,
            "load swing.txt as=one; scene spring; fit sine; adopt; scene pendulum; run 0.1 s");
    bench_store(kept.b.session, &kept.stored, &kept.file);
    for (size_t i = 0; i + 100 < kept.file.len; i++)
        if (memcmp(kept.file.data + i, "\xF0HR\nR", 5) == 0)
            kept.file.data[i + 60] ^= 1;
    assert_true(bench_restore(&again, buffer_text(&kept.file), &notes));
    assert_true(notes.len > 0 && again.session->runs.count == 0);
    bench_close(&again);
    buffer_free(&notes);
    end(&kept);
}

/* ---- which commands were played ---- */

static bool is_unplayed(const char *name)
{
    char word[64];
    snprintf(word, sizeof word, " %s ", name);
    return strstr(unplayed, word) != NULL;
}

/* Plays the examples of a command's row; what they leave is kept as it is. */
static void play_examples(const struct command *command)
{
    struct text examples = text_of(command->examples), line;
    while (text_split(&examples, '\n', &line)) {
        struct kept kept;
        struct bench again;
        struct buffer typed = {0}, wanted = {0}, got = {0}, notes = {0};
        begin(&kept, 7);
        buffer_put(&typed, line);
        type_ok(&kept.b, buffer_view(&typed));
        bench_store(kept.b.session, &kept.stored, &kept.file);
        describe_all(kept.b.session, &wanted);
        assert_true(bench_restore(&again, buffer_text(&kept.file), &notes));
        describe_all(again.session, &got);
        assert_same(&wanted, &got, "restored", &typed);
        bench_close(&again);
        end(&kept);
        buffer_free(&typed);
        buffer_free(&wanted);
        buffer_free(&got);
        buffer_free(&notes);
    }
}

TEST(every_command_is_played)
{
    int wrong = 0;
    assert_true(command_catalog.count <= COUNT_OF(played));
    for (size_t i = 0; i < command_catalog.count; i++) {
        const char *name = catalog_row(&command_catalog, i)->name;
        for (uint64_t seed = 20000; seed < 20040 && !played[i] && !is_unplayed(name); seed++) {
            struct kept kept;
            begin(&kept, seed);
            for (int k = 0; k < LINES; k++)
                play_one(&kept);
            end(&kept);
        }
        if (!played[i] && !is_unplayed(name))
            play_examples(command_at(catalog_row(&command_catalog, i)));
        if (played[i] == is_unplayed(name)) {
            print_error("%s is %s by random sessions\n", name,
                        played[i] ? "said to be unplayed, but played" : "never played");
            wrong++;
        }
    }
    assert_int_equal(wrong, 0);
}

RUN_TESTS(enter_folder, leave_folder)
