/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One description of columns gives the records, the table to files and the table for people. */
#include "cmocka_testing.h"

#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/result.h>

#include <float.h>
#include <math.h>

struct pendulum {
    const char *maker;
    char note[8];
    double length, period[2]; /* [m], [s] */
    int swings;
    int64_t samples;
    bool damped;
    enum quantity quantity;
};

static const struct pendulum pendulums[] = {
    {"Foucault", "Paris", 67, {16.5, NAN}, 3, 12345678901, false, QUANTITY_LENGTH},
    {NULL, "", 0.25, {1.003, NAN}, 0, 0, true, QUANTITY_LENGTH},
};

static double frequency(const void *row)
{
    return 1 / ((const struct pendulum *)row)->period[0];
}

static const char *maker(const void *row)
{
    return ((const struct pendulum *)row)->maker;
}

static int64_t twice(const void *row)
{
    return 2 * ((const struct pendulum *)row)->swings;
}

static enum quantity length_quantity(const void *row)
{
    return ((const struct pendulum *)row)->quantity;
}

static const char *swings_heading(const void *first)
{
    return ((const struct pendulum *)first)->damped ? "damped swings" : "swings";
}

static bool is_damped(const void *row)
{
    return ((const struct pendulum *)row)->damped;
}

static void note_cell(struct text_table *table, const void *row)
{
    cell_text(table, ((const struct pendulum *)row)->note[0] ? "noted" : "");
}

#define AT(member) .offset = offsetof(struct pendulum, member)

/* clang-format off */
static const struct result_column rows[] = {
    {.name = "maker", .kind = COLUMN_NAME, .text = maker, .heading = "by", .index = 2},
    {.name = "length", AT(length), .quantity_of = length_quantity, .heading = "l", .index = 1},
    {.name = "period", AT(period[0]), .quantity = QUANTITY_TIME, .look = cell_error,
     .heading = "T", .index = 3},
    {.name = "period_end", AT(period[1]), .quantity = QUANTITY_TIME,
     .heading = "T end", .index = 4, .flags = COLUMN_IF_ANY},
    {.name = "frequency", .real = frequency, .quantity = QUANTITY_FREQUENCY,
     .heading = "f", .index = 5, .flags = COLUMN_IF_ANY | COLUMN_WIDE, .any = is_damped, .digits = 5},
    {.name = "swings", .kind = COLUMN_INT, AT(swings), .head = swings_heading,
     .index = 6, .flags = COLUMN_IF_ANY},
    {.name = "half_swings", .kind = COLUMN_COUNT, .number = twice, .flags = COLUMN_NO_RECORD},
    {.name = "samples", .kind = COLUMN_COUNT, AT(samples), .flags = COLUMN_NO_FILE},
    {.name = "damped", .kind = COLUMN_BOOL, AT(damped)},
    {.name = "note", .kind = COLUMN_CHARS, AT(note), .cell = note_cell, .index = 7,
     .heading = "note"}};
/* clang-format on */

static const struct result_columns columns = RESULT_COLUMNS(rows, struct pendulum);

/* ---- records ---- */

static bool collect(void *context, struct text text)
{
    buffer_put(context, text);
    return true;
}

static void records(enum output_format format, struct buffer *out)
{
    struct reply reply;
    reply_init(&reply, (struct sink){collect, collect, out});
    reply_command_begin(&reply, format);
    reply_records(&reply, "pendulum", &columns, pendulums, COUNT_OF(pendulums));
    reply_command_end(&reply, "pendulum");
    reply_free(&reply);
}

TEST(records_have_every_key_and_null_for_what_is_missing)
{
    struct buffer out = {0};
    records(FORMAT_JSON, &out);
    assert_string_equal(buffer_view(&out),
                        "{\"kind\":\"pendulum\",\"maker\":\"Foucault\",\"length\":67,\"period\":16."
                        "5,\"period_end\":null,"
                        "\"frequency\":0.06060606060606061,\"swings\":3,\"samples\":12345678901,"
                        "\"damped\":false,\"note\":\"Paris\"}\n"
                        "{\"kind\":\"pendulum\",\"maker\":null,\"length\":0.25,\"period\":1.003,"
                        "\"period_end\":null,"
                        "\"frequency\":0.9970089730807579,\"swings\":0,\"samples\":0,\"damped\":"
                        "true,\"note\":null}\n");
    buffer_clear(&out);
    records(FORMAT_CSV, &out);
    assert_string_equal(buffer_view(&out),
                        "kind,maker,length,period,period_end,frequency,swings,samples,damped,note\n"
                        "pendulum,Foucault,67,16.5,,0.06060606060606061,3,12345678901,false,Paris\n"
                        "pendulum,,0.25,1.003,,0.9970089730807579,0,0,true,\n");
    buffer_clear(&out);
    records(FORMAT_TEXT, &out);
    assert_int_equal(out.len, 0);
    buffer_free(&out);
}

/* ---- files ---- */

TEST(a_file_has_units_and_leaves_cells_empty)
{
    struct arena arena = {0};
    struct buffer out = {0};
    struct table table;
    assert_true(columns_table(&columns, pendulums, COUNT_OF(pendulums), &arena, &table));
    table_put(&table, table_csv, &out);
    assert_string_equal(
        buffer_view(&out),
        "maker,length [m],period [s],period_end [s],frequency [Hz],swings,half_swings,damped,note\n"
        "Foucault,67,16.5,,0.06060606060606061,3,6,false,Paris\n"
        ",0.25,1.003,,0.9970089730807579,0,0,true,\n");
    buffer_free(&out);
    arena_reset(&arena);
}

/* ---- people ---- */

static void seen(const struct pendulum *from, size_t count, bool wide, const char *expected)
{
    struct arena arena = {0};
    struct buffer out = {0};
    struct text_table table = {.arena = &arena, .gap = 2};
    columns_text(&columns, from, count, wide, &table);
    assert_false(table.failed);
    text_table_put(&table, &out);
    assert_string_equal(buffer_view(&out), expected);
    buffer_free(&out);
    arena_reset(&arena);
}

TEST(people_see_columns_in_their_places_where_a_row_has_a_value)
{
    seen(pendulums, 2, false,
         "l      by        T        swings  note\n"
         "67 m   Foucault  1.6e+01  3       noted\n"
         "25 cm            1.0e+00  0\n");
    /* The second alone has no swings, and is damped. */
    seen(pendulums + 1, 1, true,
         "l      by  T        f           note\n"
         "25 cm      1.0e+00  997.01 mHz\n");
    seen(pendulums, 1, true,
         "l     by        T        swings  note\n"
         "67 m  Foucault  1.6e+01  3       noted\n");
    seen(pendulums, 0, true, "l  by  T  note\n");
}

/* Gaps shrink first; then columns that are the same in all rows fold, as many as are needed. */
TEST(a_table_fits_where_rows_have_the_same)
{
    static const char *const cells[] = {"name", "dt",   "size", "kind", "a",    "1 s", "12",
                                        "fine", "long", "1 s",  "345",  "fine", NULL};
    static const struct {
        int max;
        const char *expected;
    } cases[] = {
        {0, "name   dt    size   kind\na      1 s   12     fine\nlong   1 s   345    fine\n"},
        {21, "name  dt   size  kind\na     1 s  12    fine\nlong  1 s  345   fine\n"},
        {18, "name dt  size kind\na    1 s 12   fine\nlong 1 s 345  fine\n"},
        {17, "name size kind\na    12   fine\nlong 345  fine\nin each row: dt 1\ns\n"},
        {10, "name size\na    12\nlong 345\nin each\nrow: dt 1\ns, kind\nfine\n"},
        {5, "name size\na    12\nlong 345\nin\neach\nrow:\ndt 1\ns,\nkind\nfine\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct arena arena = {0};
        struct buffer out = {0};
        struct text_table table = {.arena = &arena, .columns = 4, .gap = 3, .max = cases[i].max};
        for (int c = 0; cells[c]; c++)
            cell_text(&table, cells[c]);
        text_table_put(&table, &out);
        assert_string_equal(buffer_view(&out), cases[i].expected);
        buffer_free(&out);
        arena_reset(&arena);
    }
}

/* Columns are left out from the largest rank down, of one rank from the right; those that only have
 * a place where there is much room silently, the others by name, in lines that fit. */
TEST(a_table_leaves_out_columns_by_rank)
{
    static const char *const cells[] = {"name", "error", "status", "phase", "ns",   "a",
                                        "0.1",  "ok",    "3 deg",  "17",    "long", "0.2",
                                        "lost", "4 deg", "18",     NULL};
    static const struct {
        int max;
        const char *expected;
    } cases[] = {
        {28,
         "name error status phase ns\na    0.1   ok     3 deg 17\nlong 0.2   lost   4 deg 18\n"},
        {24, "name error status phase\na    0.1   ok     3 deg\nlong 0.2   lost   4 deg\n"},
        {20, "name error status\na    0.1   ok\nlong 0.2   lost\nleft out because of\nthe width: "
             "phase\n"},
        {14, "name status\na    ok\nlong lost\nleft out\nbecause of the\nwidth: phase,\nerror\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct arena arena = {0};
        struct buffer out = {0};
        struct text_table table = {.arena = &arena,
                                   .columns = 5,
                                   .gap = 3,
                                   .max = cases[i].max,
                                   .rank = {0, 2, 1, 2, TABLE_RANK_WIDE}};
        for (int c = 0; cells[c]; c++)
            cell_text(&table, cells[c]);
        text_table_put(&table, &out);
        assert_string_equal(buffer_view(&out), cases[i].expected);
        buffer_free(&out);
        arena_reset(&arena);
    }
}

/* ---- parts, choices, rows ---- */

struct clock {
    const struct unit *unit;
    int use; /* from 1: of the rows of `uses` */
    struct pendulum pendulum;
    struct pendulum spare[2];
    int spares;
    const struct pendulum *model;
};

static const struct row uses[] = {{"tower", "", "", "", NULL}, {"ship", "", "", "", NULL}};
static const struct catalog use_catalog = CATALOG("use", uses);

static const struct result_column of_part[] = {
    {.name = "length", AT(length), .quantity = QUANTITY_LENGTH},
    {.name = "swings", .kind = COLUMN_INT, AT(swings)}};
static const struct result_columns part_columns = RESULT_COLUMNS(of_part, struct pendulum);

static const void *list_spares(const void *row, size_t *count)
{
    *count = (size_t)((const struct clock *)row)->spares;
    return ((const struct clock *)row)->spare;
}

static const struct result_column of_clock[] = {
    {.name = "unit", .kind = COLUMN_ROW, .offset = offsetof(struct clock, unit)},
    {.name = "use",
     .kind = COLUMN_CHOICE,
     .offset = offsetof(struct clock, use),
     .choices = &use_catalog,
     .choice_first = 1},
    {.name = "pendulum",
     .kind = COLUMN_OBJECT,
     .offset = offsetof(struct clock, pendulum),
     .part = &part_columns},
    {.name = "spares", .kind = COLUMN_LIST, .part = &part_columns, .list = list_spares},
    {.name = "maker",
     .kind = COLUMN_NAME,
     .pointer_offset = COLUMN_IN(struct clock, model),
     .offset = offsetof(struct pendulum, maker)},
    {.name = "note",
     .kind = COLUMN_CHARS,
     .pointer_offset = COLUMN_IN(struct clock, model),
     .offset = offsetof(struct pendulum, note)}};
static const struct result_columns clock_columns = RESULT_COLUMNS(of_clock, struct clock);

TEST(parts_are_objects_and_lists_and_rows_give_their_names)
{
    const struct clock clocks[] = {{unit_find(text_of("ms")),
                                    2,
                                    {.length = 1, .swings = 3},
                                    {{.length = 2}, {.length = 4}},
                                    2,
                                    &pendulums[0]},
                                   {NULL, 0, {.length = NAN}, {{0}}, 0, &pendulums[1]}};
    struct buffer out = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){collect, collect, &out});
    reply_command_begin(&reply, FORMAT_JSON);
    reply_records(&reply, "clock", &clock_columns, clocks, COUNT_OF(clocks));
    reply_command_end(&reply, "clock");
    reply_free(&reply);
    assert_string_equal(buffer_view(&out),
                        "{\"kind\":\"clock\",\"unit\":\"ms\",\"use\":\"ship\",\"pendulum\":{"
                        "\"length\":1,\"swings\":3},\"spares\":[{\"length\":2,\"swings\":0},{"
                        "\"length\":4,\"swings\":0}],\"maker\":\"Foucault\",\"note\":\"Paris\"}\n"
                        "{\"kind\":\"clock\",\"unit\":null,\"use\":null,\"pendulum\":{\"length\":"
                        "null,\"swings\":0},\"spares\":[],\"maker\":null,\"note\":null}\n");
    buffer_free(&out);
}

/* The texts for formats are those that buffers get, however long. */
TEST(values_in_formats_are_those_of_buffers)
{
    static const double values[] = {0,        -DBL_MAX,  DBL_TRUE_MIN,
                                    -1.0 / 3, 2e-5,      1e5 / 7,
                                    NAN,      -INFINITY, -1.2345678901234567e-300};
    (void)state;
    for (size_t v = 0; v < COUNT_OF(values); v++)
        for (enum quantity quantity = 0; quantity < QUANTITY_COUNT; quantity++)
            for (int digits = 0; digits < 20; digits++)
                for (size_t u = 0; u < COUNT_OF(values); u++) {
                    const struct measured measured = {values[v], fabs(values[u])};
                    struct buffer wanted = {0}, got = {0};
                    buffer_measured(&wanted, measured, quantity, digits);
                    buffer_quantity(&wanted, values[v], quantity, digits);
                    buffer_short(&wanted, values[v], digits);
                    buffer_format(&got, "%s%s%s", SHOWN_MEASURED(measured, quantity, digits),
                                  SHOWN_QUANTITY(values[v], quantity, digits),
                                  SHOWN_SHORT(values[v], digits));
                    assert_string_equal(buffer_view(&got), buffer_view(&wanted));
                    buffer_free(&wanted);
                    buffer_free(&got);
                }
}

/* Text in the reply's own buffer ends its line before anything else is said. */
TEST(lines_in_the_reply_come_in_their_order)
{
    struct buffer out = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){collect, collect, &out});
    reply_command_begin(&reply, FORMAT_TEXT);
    buffer_put(reply_buffer(&reply), TEXT("one"));
    reply_warning(&reply, "two");
    buffer_put(reply_buffer(&reply), TEXT("three\n"));
    reply_line(&reply, "four");
    buffer_put(reply_buffer(&reply), TEXT("five"));
    reply_command_end(&reply, "count");
    assert_string_equal(buffer_view(&out), "one\nwarning: two\nthree\nfour\nfive\n");
    reply_free(&reply);
    buffer_free(&out);
}

RUN_TESTS(NULL, NULL)
