/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Records become rows of tables: names of columns, units, gaps; what is kept of them. */
#include "cmocka_testing.h"

#include <hooke/base/catalog.h>
#include <hooke/result.h>

#include <math.h>
#include <string.h>

static bool out(void *context, struct text text)
{
    buffer_put(context, text);
    return true;
}

static bool all(void *context, struct stored_table *stored)
{
    (void)context;
    (void)stored;
    return true;
}

static bool none(void *context, struct stored_table *stored)
{
    (void)context;
    (void)stored;
    return false;
}

static void say_swing(struct reply *reply, double period, const char *note)
{
    reply_begin(reply, "swing");
    reply_quantity(reply, "period", period, "s");
    reply_string(reply, "note", note);
    reply_measured(reply, "mass", (struct measured){2, 0.5}, QUANTITY_MASS);
    reply_array(reply, "window");
    reply_real(reply, NULL, 1);
    reply_real(reply, NULL, 3);
    reply_close(reply);
    reply_array(reply, "parameters");
    reply_object(reply, NULL);
    reply_string(reply, "name", "k");
    reply_int(reply, "value", 7);
    reply_close(reply);
    reply_object(reply, NULL);
    reply_bool(reply, "held", true);
    reply_close(reply);
    reply_close(reply);
    reply_null(reply, "never");
    reply_end(reply);
}

TEST(fields_are_columns_called_by_their_path)
{
    struct buffer said = {0}, text = {0};
    struct table_store made = {0}, store = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){out, out, &said});
    reply.store = &made;
    reply.muted = true;
    say_swing(&reply, 1.5, NULL);
    say_swing(&reply, NAN, "a,b");
    for (int i = 0; i < 9; i++)
        say_swing(&reply, i, "more");
    assert_int_equal(said.len, 0);
    table_store_take(&store, &made, all, NULL);
    assert_int_equal(made.count, 0);
    const struct stored_table *stored = table_store_find(&store, TEXT("swing"));
    assert_non_null(stored);
    assert_int_equal(stored->table.rows, 11);
    struct table table = stored->table;
    table.rows = 3;
    table_put(&table, table_csv, &text);
    assert_string_equal(buffer_view(&text),
                        "period [s],note,mass [kg],mass_uncertainty [kg],window.1,window.2,"
                        "parameters.k.value,parameters.2.held,never\n"
                        "1.5,,2,0.5,1,3,7,true,\n"
                        ",\"a,b\",2,0.5,1,3,7,true,\n"
                        "0,more,2,0.5,1,3,7,true,\n");
    table_store_free(&store);
    buffer_free(&text);
    buffer_free(&said);
    reply_free(&reply);
}

TEST(the_last_of_a_kind_is_kept_and_a_whole_table_as_it_is)
{
    static const double x[] = {1, 2};
    static const struct table_column column[] = {{.name = "x", .unit = "m", .value = x}};
    const struct table whole = {.column = column, .columns = 1, .rows = 2};
    struct table_store made = {0}, store = {0};
    struct arena arena = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){out, out, NULL});
    reply.muted = true;
    for (int i = 0; i < 2; i++) {
        reply.store = &made;
        say_swing(&reply, i, NULL);
        table_store_take(&store, &made, i ? none : all, NULL);
    }
    assert_int_equal(store.count, 1);
    assert_true(store.table[0]->table.column[0].value[0] == 0);
    assert_true(table_store_put(&made, "swing", &arena, &whole));
    say_swing(&reply, 5, NULL);
    table_store_take(&store, &made, all, NULL);
    assert_int_equal(store.count, 1);
    assert_int_equal(store.table[0]->table.columns, 1);
    assert_int_equal(store.table[0]->table.rows, 2);
    table_store_free(&store);
    reply_free(&reply);
}

static void assert_same(const struct table *a, const struct table *b)
{
    assert_int_equal(a->rows, b->rows);
    assert_int_equal(a->columns, b->columns);
    assert_int_equal(a->keys, b->keys);
    for (int i = 0; i < a->keys; i++)
        assert_true(strcmp(a->key[i].key, b->key[i].key) == 0 &&
                    strcmp(a->key[i].value, b->key[i].value) == 0);
    for (int c = 0; c < a->columns; c++) {
        assert_string_equal(a->column[c].name, b->column[c].name);
        assert_string_equal(a->column[c].unit, b->column[c].unit);
        assert_int_equal(!a->column[c].value, !b->column[c].value);
        for (size_t i = 0; i < a->rows; i++)
            if (a->column[c].value)
                assert_memory_equal(&a->column[c].value[i], &b->column[c].value[i], sizeof(double));
            else
                assert_string_equal(a->column[c].text[i], b->column[c].text[i]);
    }
}

TEST(what_is_written_reads_back_the_same)
{
    static const struct table_key keys[] = {{"hooke", "1"}, {"note", "a = \"b\" \\ \xc3\xa9"}};
    static const double number[] = {0.1, -0.0, 1e-310, 1.7976931348623157e308, NAN, 3};
    static const char *const word[] = {"a,b\n\"c\"", "=1+1", "'=x",
                                       "",           "1e5",  "\xf0\x9f\x98\x80\t"};
    static const char *const more[] = {"-", "inf", "''@", "true", " x ", "nan"};
    static const struct table_column column[] = {{"x y", "m/s^2", number, NULL, false},
                                                 {"a b", "", NULL, word, false},
                                                 {"state.y", "", NULL, more, false}};
    static table_format *const formats[] = {table_csv, table_tsv, table_json};
    static const char *const names[] = {"csv", "tsv", "json"};
    for (size_t f = 0; f < COUNT_OF(formats); f++)
        for (size_t rows = 0; rows <= 6; rows += 6) {
            const struct table written = {keys, 2, column, 3, rows, NULL, 0};
            struct table read;
            struct arena arena = {0};
            struct buffer text = {0};
            struct error error = {0};
            table_put(&written, formats[f], &text);
            assert_true(table_recognise(buffer_text(&text)));
            if (!table_parse(buffer_text(&text), NULL, &arena, &read, &error))
                fail_msg("%s: %s", names[f], error.text);
            if (rows > 0)
                assert_same(&written, &read);
            for (size_t cut = 12; cut < text.len; cut++) /* no reading past an end */
                table_parse((struct text){text.data, cut}, NULL, &arena, &read, &error);
            arena_reset(&arena);
            buffer_free(&text);
        }
}

RUN_TESTS(NULL, NULL)
