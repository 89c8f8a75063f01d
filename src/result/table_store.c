/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Stores tables by the kind of their rows, and collects records as rows of such tables:
 * store_row_begin(), a store_cell_...() for each field, store_row_end(). table_store_take() then
 * moves the tables to the session. */
#include <hooke/base/number.h>
#include <hooke/result.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A column that grows. It holds numbers or texts; both are NULL while all its cells are empty. */
struct cells {
    const char *name, *unit;
    double *value;
    const char **text;
};

/* The columns of a stored table while rows are added. */
struct column_growth {
    struct cells *cells;
    /* `next` is where the search for a column begins: fields of records come in the same order */
    int columns, column_capacity, next;
    size_t rows, capacity;
    bool failed;
};

struct stored_table *table_store_find(const struct table_store *store, struct text kind)
{
    for (int i = 0; i < store->count; i++)
        if (text_is(kind, store->table[i]->kind))
            return store->table[i];
    return NULL;
}

/* Frees a stored table with its memory. */
static void stored_table_destroy(struct stored_table *stored)
{
    arena_reset(&stored->arena);
    free(stored);
}

void table_store_free(struct table_store *store)
{
    for (int i = 0; i < store->count; i++)
        stored_table_destroy(store->table[i]);
    free(store->table);
    *store = (struct table_store){0};
}

/* Adds a table to the store, which then owns it, and frees an earlier one of its kind. Returns
 * false, and does not take the table, if out of memory. */
static bool stored_table_add(struct table_store *store, struct stored_table *stored)
{
    struct stored_table *previous = table_store_find(store, text_of(stored->kind));
    for (int i = 0; i < store->count && previous; i++)
        if (store->table[i] == previous) {
            stored_table_destroy(previous);
            store->table[i] = stored;
            return true;
        }
    struct stored_table **tables =
        realloc(store->table, ((size_t)store->count + 1) * sizeof(struct stored_table *));
    if (!tables)
        return false;
    store->table = tables;
    store->table[store->count++] = stored;
    return true;
}

/* Stores a table, whose memory is in the arena, and takes over the arena. Returns false if out of
 * memory; the arena is unchanged then. */
bool table_store_put(struct table_store *store, const char *kind, struct arena *arena,
                     const struct table *table)
{
    struct stored_table *stored = malloc(sizeof *stored);
    if (stored)
        *stored = (struct stored_table){kind, *arena, *table, NULL};
    if (stored && stored_table_add(store, stored)) {
        *arena = (struct arena){0};
        return true;
    }
    free(stored);
    return false;
}

/* ---- a row ---- */

/* Begins a row of the table of this kind and makes it the current one (store->row). A missing table
 * is created. The row is dropped (store->row is NULL) if out of memory, or if the table is
 * finished, so that it has no `growth`. */
void store_row_begin(struct table_store *store, const char *kind)
{
    struct stored_table *stored = table_store_find(store, text_of(kind));
    struct arena arena = {0};
    struct column_growth *growth = stored ? NULL : arena_alloc(&arena, sizeof *growth);
    const char *name = growth ? arena_text(&arena, text_of(kind)) : NULL;
    if (name && table_store_put(store, name, &arena, &(struct table){0})) {
        *growth = (struct column_growth){0};
        stored = table_store_find(store, text_of(kind));
        stored->growth = growth;
    }
    arena_reset(&arena);
    store->row = stored && stored->growth ? stored : NULL;
    if (store->row)
        store->row->growth->next = 0;
}

/* Doubles the number of rows for which columns have memory; new cells are empty. Returns false if
 * out of memory. */
static bool columns_grow_rows(struct arena *arena, struct column_growth *stored)
{
    const size_t capacity = stored->capacity ? 2 * stored->capacity : 4;
    for (int c = 0; c < stored->columns; c++) {
        struct cells *cells = &stored->cells[c];
        double *value = cells->value ? arena_array(arena, capacity, sizeof *value) : NULL;
        const char **text = cells->text ? arena_array(arena, capacity, sizeof *text) : NULL;
        if ((cells->value && !value) || (cells->text && !text))
            return false;
        for (size_t i = 0; i < capacity; i++) {
            if (value)
                value[i] = i < stored->rows ? cells->value[i] : NAN;
            if (text)
                text[i] = i < stored->rows ? cells->text[i] : "";
        }
        cells->value = value;
        cells->text = text;
    }
    stored->capacity = capacity;
    return true;
}

/* Returns the column of this name, which is added if it is new, or NULL if out of memory. */
static struct cells *find_or_add_column(struct arena *arena, struct column_growth *growth,
                                        const char *name, const char *unit)
{
    for (int i = 0; i < growth->columns; i++) {
        const int c = (growth->next + i) % growth->columns;
        if (strcmp(growth->cells[c].name, name) != 0)
            continue;
        growth->next = c + 1;
        return &growth->cells[c];
    }
    if (growth->columns == growth->column_capacity) {
        const int capacity = growth->column_capacity ? 2 * growth->column_capacity : 16;
        struct cells *more = arena_array(arena, (size_t)capacity, sizeof *more);
        if (!more)
            return NULL;
        if (growth->columns)
            memcpy(more, growth->cells, (size_t)growth->columns * sizeof *more);
        growth->cells = more;
        growth->column_capacity = capacity;
    }
    const char *copy = arena_text(arena, text_of(name)), *its = arena_text(arena, text_of(unit));
    if (!copy || !its)
        return NULL;
    growth->next = growth->columns + 1;
    growth->cells[growth->columns] = (struct cells){copy, its, NULL, NULL};
    return &growth->cells[growth->columns++];
}

/* Returns the cell's column, with room for the present row, or NULL if nothing is collected or if
 * out of memory. */
static struct cells *growing_column(struct table_store *store, const char *name, const char *unit)
{
    struct column_growth *growth = store->row ? store->row->growth : NULL;
    struct arena *arena = store->row ? &store->row->arena : NULL;
    if (!growth || growth->failed)
        return NULL;
    if (growth->rows >= growth->capacity && !columns_grow_rows(arena, growth))
        growth->failed = true;
    struct cells *cells = growth->failed ? NULL : find_or_add_column(arena, growth, name, unit);
    growth->failed |= !cells;
    return cells;
}

void store_cell_none(struct table_store *store, const char *name)
{
    growing_column(store, name, "");
}

/* Sets the cell of the current row in column `name`; its first number fixes a column's unit. */
void store_cell_real(struct table_store *store, const char *name, const char *unit, double value)
{
    struct cells *cells = growing_column(store, name, unit);
    if (!cells)
        return;
    struct arena *arena = &store->row->arena;
    struct column_growth *growth = store->row->growth;
    if (cells->text) { /* a number in a column of texts */
        char z[REAL_TEXT_SIZE];
        const char *copy = arena_text(arena, (struct text){z, real_format(value, z)});
        cells->text[growth->rows] = copy ? copy : "";
        return;
    }
    if (!cells->value) {
        cells->unit = arena_text(arena, text_of(unit));
        cells->value = arena_array(arena, growth->capacity, sizeof *cells->value);
        for (size_t i = 0; cells->value && i < growth->capacity; i++)
            cells->value[i] = NAN;
    }
    if (cells->value && cells->unit)
        cells->value[growth->rows] = value;
    else
        growth->failed = true;
}

/* Sets the cell of the current row in column `name`; ignored in a column of numbers. */
void store_cell_text(struct table_store *store, const char *name, const char *text)
{
    struct cells *cells = growing_column(store, name, "");
    if (!cells || cells->value)
        return;
    struct arena *arena = &store->row->arena;
    struct column_growth *growth = store->row->growth;
    if (!cells->text) {
        cells->text = arena_array(arena, growth->capacity, sizeof *cells->text);
        for (size_t i = 0; cells->text && i < growth->capacity; i++)
            cells->text[i] = "";
    }
    const char *copy = arena_text(arena, text_of(text));
    if (cells->text && copy)
        cells->text[growth->rows] = copy;
    else
        growth->failed = true;
}

void store_row_end(struct table_store *store)
{
    if (store->row)
        store->row->growth->rows++;
    store->row = NULL;
}

/* ---- finished tables ---- */

/* Turns the columns that have grown row by row into stored->table; a column without any value
 * becomes NAN. Does nothing if the table is finished. Returns false if out of memory, also if that
 * happened while the columns grew. */
static bool stored_table_finish(struct stored_table *stored)
{
    const struct column_growth *growth = stored->growth;
    if (!growth)
        return true;
    struct table_column *column =
        arena_array(&stored->arena, (size_t)growth->columns + 1, sizeof *column);
    bool ok = column && !growth->failed;
    for (int c = 0; ok && c < growth->columns; c++) {
        const struct cells *cells = &growth->cells[c];
        const bool empty = !cells->value && !cells->text;
        double *none = empty ? arena_array(&stored->arena, growth->capacity, sizeof *none) : NULL;
        for (size_t i = 0; none && i < growth->capacity; i++)
            none[i] = NAN;
        ok = !empty || none;
        column[c] = (struct table_column){cells->name, cells->unit, empty ? none : cells->value,
                                          cells->text, false};
    }
    stored->table =
        (struct table){.column = column, .columns = growth->columns, .rows = growth->rows};
    stored->growth = NULL;
    return ok;
}

/* Moves the tables of `source` that wanted() accepts to `store`, after finishing those that still
 * grow. Frees the others, also those for which memory is missing, and `source`. */
void table_store_take(struct table_store *store, struct table_store *source,
                      bool (*wanted)(void *context, struct stored_table *stored), void *context)
{
    for (int i = 0; i < source->count; i++)
        if (!stored_table_finish(source->table[i]) || !wanted(context, source->table[i]) ||
            !stored_table_add(store, source->table[i]))
            stored_table_destroy(source->table[i]);
    source->count = 0;
    table_store_free(source);
}
