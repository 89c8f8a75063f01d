/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The figure of the last map of basins: a letter for each attractor, in pictures above a colour of
 * its own. It is drawn from the table that the command basins has stored. */
#include <hooke/base/numeric.h>
#include <hooke/plot/drawing.h>
#include "modules/dynamics/plots.h"

#include <math.h>
#include <string.h>

#define FATE_LETTERS 26
#define FATE_KINDS (FATE_LETTERS + 2) /* the letters, "escapes" and "undecided" */
#define PICTURE_LETTERS_X 40          /* number of columns of letters in a picture */
#define PICTURE_LETTERS_Y 20          /* number of rows */
#define TEXT_LETTERS_Y 60             /* more rows than any screen has */

/* Characters of the kinds of fates. */
static const char marks[FATE_KINDS + 1] = "ABCDEFGHIJKLMNOPQRSTUVWXYZ.?";

/* The stored table as a grid: a row for each start, the second variable varies fastest. */
struct grid {
    const struct table *table;
    size_t width, height; /* number of starts across and up */
    struct axis side[2];  /* axes across and up, which reach half a step beyond the starts */
};

/* Returns the last stored table of a kind, or NULL if there is none. */
static const struct table *found_table(const struct session *session, struct text kind)
{
    const struct stored_table *stored = table_store_find(&session->studies.found, kind);
    return stored ? &stored->table : NULL;
}

bool basins_known(const struct session *session)
{
    return found_table(session, TEXT("basins")) != NULL;
}

/* Returns the index in `marks` of the fate of start (a, b), or FATE_KINDS if it is missing. */
static int fate_at(const struct grid *g, size_t a, size_t b)
{
    const char *fate = g->table->column[2].text[a * g->height + b];
    if (fate[1] == '\0' && fate[0] >= 'A' && fate[0] <= 'Z')
        return fate[0] - 'A';
    if (strcmp(fate, "escapes") == 0)
        return FATE_LETTERS;
    return strcmp(fate, "not decided") == 0 ? FATE_LETTERS + 1 : FATE_KINDS;
}

/* Returns the value of an axis at an index. */
static double value_at(const struct grid *g, int axis, size_t place)
{
    return g->table->column[axis].value[axis == 0 ? place * g->height : place];
}

/* Returns the factor between the unit of an axis and SI. */
static double unit_factor(const struct axis *side)
{
    return side->factor > 0 ? side->factor : 1;
}

/* Returns the legend of fate number `kind`, such as "equilibrium at 1, 0 (49.4 %)", from the table
 * `basin`, with the state in the units of the axes; kinds from FATE_LETTERS on are starts that
 * escape or are not decided. The text is in the drawing's arena. Returns NULL if out of memory. */
static const char *label_of(struct drawing *d, const struct grid *g, int kind)
{
    const struct table *basins = found_table(d->session, TEXT("basin"));
    struct buffer text = {0};
    const char *type = NULL;
    double share = NAN;
    const char name[] = {marks[kind], '\0'}, *fate = name;
    if (kind >= FATE_LETTERS)
        fate = kind == FATE_LETTERS ? "escapes" : "not decided";
    size_t row = 0;
    while (basins && row < basins->rows &&
           !(basins->column[0].text && basins->column[0].text[row] &&
             strcmp(basins->column[0].text[row], fate) == 0))
        row++;
    for (int c = 0; basins && row < basins->rows && c < basins->columns; c++) {
        if (strcmp(basins->column[c].name, "share") == 0 && basins->column[c].value)
            share = basins->column[c].value[row];
        if (strcmp(basins->column[c].name, "type") == 0 && basins->column[c].text)
            type = basins->column[c].text[row];
    }
    type = type && *type ? type : NULL;
    buffer_put(&text, text_of(type ? type : fate));
    for (int c = 0, n = 0; type && c < basins->columns && n < 2; c++)
        for (int axis = 0; axis < 2; axis++)
            if (strncmp(basins->column[c].name, "state.", 6) == 0 && basins->column[c].value &&
                strcmp(basins->column[c].name + 6, g->table->column[axis].name) == 0)
                buffer_format(&text, "%s%.3g", n++ == 0 ? " at " : ", ",
                              basins->column[c].value[row] / unit_factor(&g->side[axis]));
    if (isfinite(share))
        buffer_format(&text, " (%.3g %%)", 100 * share);
    const char *label = text.failed ? NULL : arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return label;
}

/* ---- letters ---- */

/* The curve of one kind of fate. */
struct letters {
    struct curve *curve; /* NULL if no start has that fate */
    double *x, *y;       /* coordinates of the curve, for as many letters as it may get */
};

/* Adds the curve of a kind of fate, with room for `most` letters, and sets *l to its places.
 * Returns false if out of memory. */
static bool begin_letters(struct drawing *d, const struct grid *g, int kind, size_t most,
                          struct letters *l)
{
    l->curve = &d->curve[d->curves++];
    l->x = arena_array(d->arena, 2 * most, sizeof *l->x);
    if (!l->x)
        return false;
    l->y = l->x + most;
    *l->curve = (struct curve){.label = label_of(d, g, kind),
                               .points = true,
                               .plain = true,
                               .mark = marks[kind],
                               .thinned = true,
                               .x = l->x,
                               .y = l->y};
    return l->curve->label;
}

/* Adds a letter at a position. */
static void put_letter(struct letters *l, double x, double y)
{
    l->x[l->curve->n] = x;
    l->y[l->curve->n++] = y;
}

/* Draws columns x rows letters evenly over the map of basins, each that of the nearest start's
 * fate. A fate that gets no letter this way gets one at its first start. Returns false with
 * d->error if out of memory. */
static bool put_letters(struct drawing *d, const struct grid *g, size_t columns, size_t rows)
{
    struct letters fate_letters[FATE_KINDS + 1] = {{NULL, NULL, NULL}};
    size_t first[FATE_KINDS + 1];
    bool there[FATE_KINDS + 1] = {false};
    for (size_t k = g->table->rows; k-- > 0;) {
        const int kind = fate_at(g, k / g->height, k % g->height);
        there[kind] = true;
        first[kind] = k;
    }
    for (int kind = 0; kind < FATE_KINDS; kind++)
        if (there[kind] && !begin_letters(d, g, kind, columns * rows + 1, &fate_letters[kind]))
            return error_memory(d->error);
    for (size_t k = 0; k < columns * rows; k++) {
        const double u = ((double)(k / rows) + 0.5) / (double)columns,
                     v = ((double)(k % rows) + 0.5) / (double)rows;
        const int kind =
            fate_at(g, (size_t)(u * (double)g->width), (size_t)(v * (double)g->height));
        if (kind < FATE_KINDS)
            put_letter(
                &fate_letters[kind],
                g->side[0].first_value + u * (g->side[0].last_value - g->side[0].first_value),
                g->side[1].first_value + v * (g->side[1].last_value - g->side[1].first_value));
    }
    for (int kind = 0; kind < FATE_KINDS; kind++)
        if (there[kind] && fate_letters[kind].curve->n == 0)
            put_letter(&fate_letters[kind], value_at(g, 0, first[kind] / g->height),
                       value_at(g, 1, first[kind] % g->height));
    return true;
}

/* ---- colours below them ---- */

/* Returns the map of the starts, coloured by their attractors; starts that end in none have no
 * colour. Returns NULL if out of memory. */
static const struct heat *fate_map(struct drawing *d, const struct grid *g)
{
    struct heat *heat = arena_alloc(d->arena, sizeof *heat);
    const size_t rows = g->table->rows;
    double *value = arena_array(d->arena, rows + 1, sizeof *value),
           *side = arena_array(d->arena, g->width + g->height, sizeof *side);
    if (!heat || !value || !side)
        return NULL;
    for (size_t k = 0; k < rows; k++) {
        const int kind = fate_at(g, k / g->height, k % g->height);
        value[k] = kind < FATE_LETTERS ? kind : NAN;
    }
    for (size_t i = 0; i < g->width; i++)
        side[i] = value_at(g, 0, i);
    for (size_t i = 0; i < g->height; i++)
        side[g->width + i] = value_at(g, 1, i);
    *heat = (struct heat){.title = "basins",
                          .unit = "",
                          .value = value,
                          .x = {.value = side, .count = (int)g->width},
                          .y = {.value = side + g->width, .count = (int)g->height},
                          .letters = marks};
    return heat;
}

/* ---- the figure ---- */

/* Returns the description for screen readers: "Attractor reached by each start, over x from -2 to 2
 * and v from -2 to 2: A equilibrium at ...", or NULL if out of memory. */
static const char *words_of(const struct drawing *d, const struct grid *g)
{
    struct buffer text = {0};
    buffer_put(&text, TEXT("Attractor reached by each start"));
    buffer_format(&text, ", over %s from %.4g to %.4g", g->table->column[0].name, value_at(g, 0, 0),
                  value_at(g, 0, g->width - 1));
    buffer_format(&text, " and %s from %.4g to %.4g", g->table->column[1].name, value_at(g, 1, 0),
                  value_at(g, 1, g->height - 1));
    for (int i = 0; i < d->curves; i++)
        if (d->curve[i].label)
            buffer_format(&text, "%s %c %s", i == 0 ? ":" : ",", d->curve[i].mark,
                          d->curve[i].label);
    buffer_char(&text, '.');
    const char *words = text.failed ? NULL : arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return words;
}

/* Returns axis 0 or 1 of the map, half a step longer than the starts at both ends, so that each
 * start is in the middle of its cell; a single start gets a cell of width 1. */
static struct axis side_of(const struct grid *g, int axis)
{
    const struct table_column *column = &g->table->column[axis];
    const size_t n = axis == 0 ? g->width : g->height;
    const double first = value_at(g, axis, 0), last = value_at(g, axis, n - 1),
                 half = n > 1 ? (last - first) / (double)(n - 1) / 2 : 0.5;
    struct axis side = {.label = column->name,
                        .unit = column->unit,
                        .first_value = first - half,
                        .last_value = last + half,
                        .fixed = true};
    axis_suit(&side, column_quantity(column), fmax(fabs(first), fabs(last)));
    return side;
}

/* Makes the figure from the stored table: letters, in a picture above a coloured map. The starts of
 * one value on the first axis follow each other in the table, which gives the size of the grid.
 * Returns false with d->error. */
bool basins_figure(struct drawing *d, struct figure *figure)
{
    struct grid g = {.table = found_table(d->session, TEXT("basins"))};
    if (!g.table || g.table->columns < 3 || !g.table->column[2].text || g.table->rows == 0) {
        error_set(d->error, ERROR_COMMAND, "there are no basins to plot");
        return error_hint(d->error, "type: basins NAME=FROM:TO:STEP NAME=FROM:TO:STEP");
    }
    const double *first = g.table->column[0].value;
    for (g.height = 1; g.height < g.table->rows && first[g.height] == first[0];)
        g.height++;
    g.width = g.table->rows / g.height;
    for (int axis = 0; axis < 2; axis++)
        g.side[axis] = side_of(&g, axis);
    const bool picture =
        d->request->charset == &charset_braille && d->request->width == PICTURE_COLUMNS;
    const int width = d->request->width; /* more than columns: none stays empty */
    const size_t columns = picture ? PICTURE_LETTERS_X : (size_t)int_max(width, 1);
    d->curve = arena_array(d->arena, FATE_KINDS + 1, sizeof *d->curve);
    if (!d->curve)
        return error_memory(d->error);
    d->curves = 0;
    const struct heat *colours = picture ? fate_map(d, &g) : NULL;
    if (picture && !colours)
        return error_memory(d->error);
    if (!put_letters(d, &g, columns, picture ? PICTURE_LETTERS_Y : TEXT_LETTERS_Y))
        return false;
    *figure = (struct figure){.title = "basins",
                              .plane = true,
                              .curve = d->curve,
                              .curves = d->curves,
                              .heat = colours,
                              .x = g.side[0],
                              .y = g.side[1],
                              .words = words_of(d, &g)};
    return figure->words || error_memory(d->error);
}
