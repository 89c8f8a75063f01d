/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A result as records, as a table to a file and as a table for people, from one description of its
 * columns. */
#include <hooke/base/catalog.h>
#include <hooke/base/unit.h>
#include <hooke/result.h>

#include <math.h>

/* ---- values of a row ---- */

static const void *row_at(const struct result_columns *columns, const void *rows, size_t i)
{
    return (const char *)rows + i * columns->size;
}

static const void *member(const struct result_column *column, const void *row)
{
    if (column->pointer_offset > 0)
        row = *(const void *const *)((const char *)row + column->pointer_offset - 1);
    return (const char *)row + column->offset;
}

static double real_of(const struct result_column *column, const void *row)
{
    return column->real ? column->real(row) : *(const double *)member(column, row);
}

static int64_t count_of(const struct result_column *column, const void *row)
{
    if (column->kind == COLUMN_INT)
        return *(const int *)member(column, row);
    return column->number ? column->number(row) : *(const int64_t *)member(column, row);
}

static bool bool_of(const struct result_column *column, const void *row)
{
    return *(const bool *)member(column, row);
}

static const char *text_in(const struct result_column *column, const void *row)
{
    const void *value_address = member(column, row);
    switch (column->kind) {
    case COLUMN_NAME:
        return column->text ? column->text(row) : *(const char *const *)value_address;
    case COLUMN_ROW: {
        const struct row *named = *(const struct row *const *)value_address;
        return named ? named->name : NULL;
    }
    case COLUMN_CHOICE: {
        const int index = *(const int *)value_address - column->choice_first;
        return index >= 0 ? catalog_row(column->choices, (size_t)index)->name : NULL;
    }
    default:
        return *(const char *)value_address ? value_address : NULL;
    }
}

static enum quantity quantity_in(const struct result_column *column, const void *row)
{
    return column->quantity_of ? column->quantity_of(row) : column->quantity;
}

/* ---- records ---- */

static void put_parts(struct reply *reply, const struct result_column *column, const void *row)
{
    size_t count = 0;
    const void *parts = column->list(row, &count);
    reply_array(reply, column->name);
    for (size_t i = 0; i < count; i++) {
        reply_object(reply, NULL);
        reply_columns(reply, column->part, row_at(column->part, parts, i));
        reply_close(reply);
    }
    reply_close(reply);
}

void reply_columns(struct reply *reply, const struct result_columns *columns, const void *row)
{
    for (const struct result_column *c = columns->column; c < columns->column + columns->count;
         c++) {
        if (c->flags & COLUMN_NO_RECORD || (c->defined && !c->defined(row)))
            continue;
        if (c->record) {
            c->record(reply, c->name, row);
            continue;
        }
        switch (c->kind) {
        case COLUMN_REAL:
            reply_quantity(reply, c->name, real_of(c, row), quantity_unit(quantity_in(c, row)));
            break;
        case COLUMN_INT:
        case COLUMN_COUNT:
            reply_int(reply, c->name, count_of(c, row));
            break;
        case COLUMN_BOOL:
            reply_bool(reply, c->name, bool_of(c, row));
            break;
        case COLUMN_MEASURED:
            reply_if_known(reply, c->name, *(const struct measured *)member(c, row),
                           quantity_in(c, row));
            break;
        case COLUMN_NAME:
        case COLUMN_CHARS:
        case COLUMN_ROW:
        case COLUMN_CHOICE:
            reply_string(reply, c->name, text_in(c, row));
            break;
        case COLUMN_OBJECT:
            reply_object(reply, c->name);
            reply_columns(reply, c->part, member(c, row));
            reply_close(reply);
            break;
        case COLUMN_LIST:
            put_parts(reply, c, row);
            break;
        }
    }
}

void reply_records(struct reply *reply, const char *kind, const struct result_columns *columns,
                   const void *rows, size_t count)
{
    for (size_t i = 0; i < count && (reply_wants_records(reply) || reply->store); i++) {
        reply_begin(reply, kind);
        reply_columns(reply, columns, row_at(columns, rows, i));
        reply_end(reply);
    }
}

/* ---- a table to a file ---- */

static bool fill_values(const struct result_columns *columns, const struct result_column *column,
                        const void *rows, size_t count, struct arena *arena,
                        struct table_column *table_column)
{
    const bool numbers = column->kind <= COLUMN_COUNT;
    double *value = numbers ? arena_array(arena, count + 1, sizeof *value) : NULL;
    const char **text = numbers ? NULL : arena_array(arena, count + 1, sizeof *text);
    if (!value && !text)
        return false;
    for (size_t i = 0; i < count; i++) {
        const void *row = row_at(columns, rows, i);
        if (value)
            value[i] =
                column->kind == COLUMN_REAL ? real_of(column, row) : (double)count_of(column, row);
        else if (column->kind == COLUMN_BOOL)
            text[i] = bool_of(column, row) ? "true" : "false";
        else if (column->kind != COLUMN_CHARS)
            text[i] = text_in(column, row);
        else if (!(text[i] = arena_text(arena, text_of(member(column, row)))))
            return false;
        if (text && !text[i])
            text[i] = "";
    }
    table_column->name = column->name;
    table_column->unit =
        column->kind == COLUMN_REAL && count > 0 ? quantity_unit(quantity_in(column, rows)) : "";
    table_column->value = value;
    table_column->text = text;
    table_column->detail = column->flags & COLUMN_DETAIL;
    return true;
}

static bool is_only_recorded(enum column_kind kind)
{
    return kind == COLUMN_MEASURED || kind == COLUMN_OBJECT || kind == COLUMN_LIST;
}

bool columns_table(const struct result_columns *columns, const void *rows, size_t count,
                   struct arena *arena, struct table *table)
{
    struct table_column *table_column =
        arena_array(arena, (size_t)columns->count, sizeof *table_column);
    int used = 0;
    for (int i = 0; table_column && i < columns->count; i++) {
        const struct result_column *column = &columns->column[i];
        if (column->flags & COLUMN_NO_FILE || column->record || is_only_recorded(column->kind))
            continue;
        if (!fill_values(columns, column, rows, count, arena, &table_column[used++]))
            return false;
    }
    *table = (struct table){
        .column = table_column, .columns = used, .rows = count, .digits = columns->digits};
    return table_column != NULL;
}

/* ---- a table for people ---- */

static bool has_value(const struct result_column *column, const void *row)
{
    if (column->any)
        return column->any(row);
    switch (column->kind) {
    case COLUMN_REAL:
        return isfinite(real_of(column, row));
    case COLUMN_INT:
    case COLUMN_COUNT:
        return count_of(column, row) != 0;
    case COLUMN_BOOL:
        return bool_of(column, row);
    default:
        return text_in(column, row) != NULL;
    }
}

static bool column_is_shown(const struct result_columns *columns,
                            const struct result_column *column, const void *rows, size_t count,
                            bool wide)
{
    bool any = !(column->flags & COLUMN_IF_ANY);
    for (size_t i = 0; i < count && !any; i++)
        any = has_value(column, row_at(columns, rows, i));
    return any && (wide || !(column->flags & COLUMN_WIDE));
}

static void column_cell_put(const struct result_column *column, const void *row,
                            struct text_table *table)
{
    if (column->cell)
        column->cell(table, row);
    else if (column->kind == COLUMN_REAL && column->look)
        column->look(table, real_of(column, row));
    else if (column->kind == COLUMN_REAL)
        cell_quantity(table, real_of(column, row), quantity_in(column, row),
                      column->digits ? column->digits : 3);
    else if (column->kind <= COLUMN_COUNT)
        cell_count(table, count_of(column, row));
    else if (column->kind == COLUMN_BOOL)
        cell_text(table, bool_of(column, row) ? "yes" : "no");
    else
        cell_text(table, text_in(column, row));
}

/* The columns for people in their order; places are small, and each is taken once. */
static int columns_shown(const struct result_columns *columns, const void *rows, size_t count,
                         bool wide, const struct result_column *shown[TABLE_COLUMNS_MAX])
{
    int used = 0;
    for (int index = 1; index <= TABLE_COLUMNS_MAX; index++)
        for (const struct result_column *c = columns->column; c < columns->column + columns->count;
             c++)
            if (c->index == index && used < TABLE_COLUMNS_MAX &&
                column_is_shown(columns, c, rows, count, wide))
                shown[used++] = c;
    return used;
}

static int column_rank(const struct result_column *column)
{
    const int usual = column->flags & COLUMN_WIDE ? TABLE_RANK_WIDE : 2;
    return column->rank ? column->rank : usual;
}

void columns_text(const struct result_columns *columns, const void *rows, size_t count, bool wide,
                  struct text_table *table)
{
    const struct result_column *shown[TABLE_COLUMNS_MAX];
    table->columns = columns_shown(columns, rows, count, wide, shown);
    for (int c = 0; c < table->columns; c++)
        table->rank[c] = column_rank(shown[c]);
    for (int c = 0; c < table->columns; c++)
        cell_text(table, shown[c]->head && count > 0 ? shown[c]->head(rows) : shown[c]->heading);
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < table->columns; c++)
            column_cell_put(shown[c], row_at(columns, rows, i), table);
}
