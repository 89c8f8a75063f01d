/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lines f(x, y) = 0: marching squares (Lorensen, Cline 1987, in the plane) on cells that are cut in
 * four where the bounds of f contain 0, so that small closed lines are not lost. Points on sides of
 * cells are found by bisection; neighbouring cells find the same points, by which segments are
 * joined to lines. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "modules/dynamics/portrait/portrait.h"

#define CELLS_PER_SIDE 32              /* cells along a side of the box at first */
#define SIGN_CHANGE_CELLS_PER_SIDE 256 /* finest cells where f changes its sign in a cell */
#define DOUBTFUL_CELLS_PER_SIDE 1024   /* finest cells where only the bounds of f contain 0 */
#define HALVINGS_MAX 46                /* bisections of a side, to rounding */
#define CELLS_EXAMINED_MAX 150000      /* largest number of cells */

/* A part of a line within one cell. */
struct level_segment {
    double x[2], y[2];
    bool used; /* it is part of a line already */
};

/* State of level_lines(). */
struct marching {
    const struct level_request *request;
    struct level_segment *segment;
    size_t segments, capacity;
    int cells;   /* number of cells examined */
    bool failed; /* memory ran out */
};

/* ---- points and segments ---- */

/* Returns f at (x, y). */
static double value_at(const struct marching *m, double x, double y)
{
    return m->request->value(m->request->context, x, y);
}

/* Finds by bisection the point where a level line crosses the side of a cell from a to b, each {x,
 * y, value}; the values must have different signs. Both cells that share the side find the same
 * point, since the search starts from its lower end. Sets point {x, y}. Returns false at a pole,
 * where the value at the sign change exceeds those at the ends. */
static bool side_crossing(const struct marching *m, const double a[3], const double b[3],
                          double point[2])
{
    double low[3], high[3];
    memcpy(low, a[0] < b[0] || (a[0] == b[0] && a[1] < b[1]) ? a : b, sizeof low);
    memcpy(high, low[0] == a[0] && low[1] == a[1] ? b : a, sizeof high);
    const double bound = fmax(fabs(low[2]), fabs(high[2]));
    for (int k = 0; k < HALVINGS_MAX && low[2] != 0; k++) {
        const double x = low[0] + (high[0] - low[0]) / 2, y = low[1] + (high[1] - low[1]) / 2;
        const double v = value_at(m, x, y);
        double *side = (v < 0) == (low[2] < 0) && v != 0 ? low : high;
        side[0] = x;
        side[1] = y;
        side[2] = v;
    }
    const double *nearest = fabs(low[2]) <= fabs(high[2]) ? low : high;
    point[0] = nearest[0];
    point[1] = nearest[1];
    return fabs(nearest[2]) <= bound;
}

/* Appends a segment from a to b; sets m->failed if out of memory. */
static void add_level_segment(struct marching *m, const double a[2], const double b[2])
{
    if (m->segments == m->capacity) {
        const size_t capacity = m->capacity > 0 ? 2 * m->capacity : 256;
        struct level_segment *more = realloc(m->segment, capacity * sizeof *more);
        if (!more) {
            m->failed = true;
            return;
        }
        m->segment = more;
        m->capacity = capacity;
    }
    m->segment[m->segments++] = (struct level_segment){{a[0], b[0]}, {a[1], b[1]}, false};
}

/* ---- cells ---- */

/* Adds the segments of the level line in one cell. The corners, in turn, are {x, y, value}, and 0
 * counts as positive. A cell with four crossings has a saddle, and the value in its middle decides
 * how they are joined. */
static void march_cell(struct marching *m, double corner[4][3])
{
    double crossings[4][2];
    int count = 0;
    for (int i = 0; i < 4; i++) {
        const double *a = corner[i], *b = corner[(i + 1) % 4];
        if (isfinite(a[2]) && isfinite(b[2]) && (a[2] < 0) != (b[2] < 0) &&
            side_crossing(m, a, b, crossings[count]))
            count++;
    }
    if (count == 2) {
        add_level_segment(m, crossings[0], crossings[1]);
    } else if (count == 4) { /* a saddle of f, whose middle decides */
        const double middle =
            value_at(m, (corner[0][0] + corner[2][0]) / 2, (corner[0][1] + corner[2][1]) / 2);
        const int first = (middle < 0) == (corner[0][2] < 0) ? 0 : 3;
        add_level_segment(m, crossings[first], crossings[(first + 1) % 4]);
        add_level_segment(m, crossings[(first + 2) % 4], crossings[(first + 3) % 4]);
    }
}

/* Draws the level lines in a cell `box`, {x, y} by {low, high}, and calls itself for its quarters
 * until cells are fine enough: finer where the sign changes at the corners, or where it is not
 * known that there is no zero. `cells` is the number of such cells along a side of the entire
 * region. Stops at CELLS_EXAMINED_MAX cells or when cancelled. */
static void examine_cells(struct marching *m, const double box[2][2], int cells)
{
    const struct level_request *request = m->request;
    if (m->failed || m->cells++ >= CELLS_EXAMINED_MAX || cancelled(request->cancel))
        return;
    if (request->may_be_zero && !request->may_be_zero(request->context, box))
        return;
    double corner[4][3];
    int negative_count = 0;
    for (int i = 0; i < 4; i++) {
        corner[i][0] = box[0][i == 1 || i == 2];
        corner[i][1] = box[1][i >= 2];
        corner[i][2] = value_at(m, corner[i][0], corner[i][1]);
        negative_count += corner[i][2] < 0;
    }
    const bool changes = negative_count > 0 && negative_count < 4;
    if (cells >=
        (changes || !request->may_be_zero ? SIGN_CHANGE_CELLS_PER_SIDE : DOUBTFUL_CELLS_PER_SIDE)) {
        if (changes)
            march_cell(m, corner);
        return;
    }
    const double x[] = {box[0][0], box[0][0] + (box[0][1] - box[0][0]) / 2, box[0][1]},
                 y[] = {box[1][0], box[1][0] + (box[1][1] - box[1][0]) / 2, box[1][1]};
    for (int i = 0; i < 4; i++)
        examine_cells(m, (const double[2][2]){{x[i % 2], x[i % 2 + 1]}, {y[i / 2], y[i / 2 + 1]}},
                      2 * cells);
}

/* ---- lines ---- */

/* Takes a segment that is not used yet and has an end at (*x, *y), and moves (*x, *y) to its other
 * end. Returns NULL if there is none. */
static const struct level_segment *level_segment_next(struct marching *m, double *x, double *y)
{
    for (size_t i = 0; i < m->segments; i++) {
        struct level_segment *s = &m->segment[i];
        for (int end = 0; end < 2 && !s->used; end++)
            if (s->x[end] == *x && s->y[end] == *y) {
                s->used = true;
                *x = s->x[!end];
                *y = s->y[!end];
                return s;
            }
    }
    return NULL;
}

/* Joins segments with common ends to lines, which are appended to *line with a gap after each. Each
 * line begins with an unused segment, is followed from its first end, reversed, and then followed
 * from its second end. Returns false if out of memory. */
static bool level_segments_join(struct marching *m, struct polyline *line)
{
    for (size_t i = 0; i < m->segments; i++) {
        struct level_segment *first = &m->segment[i];
        if (first->used)
            continue;
        first->used = true;
        /* backwards to where the line begins, then forwards */
        double x = first->x[0], y = first->y[0], begin[2] = {x, y};
        const size_t first_point = line->n;
        while (level_segment_next(m, &x, &y))
            if (!polyline_put(line, x, y))
                return false;
        for (size_t a = first_point, b = line->n; a + 1 < b; a++) {
            const double sx = line->x[a], sy = line->y[a];
            line->x[a] = line->x[--b];
            line->y[a] = line->y[b];
            line->x[b] = sx;
            line->y[b] = sy;
        }
        x = first->x[1];
        y = first->y[1];
        if (!polyline_put(line, begin[0], begin[1]) || !polyline_put(line, x, y))
            return false;
        while (level_segment_next(m, &x, &y))
            if (!polyline_put(line, x, y))
                return false;
        if (!polyline_gap(line))
            return false;
    }
    return true;
}

/* Examines a grid of CELLS_PER_SIDE x CELLS_PER_SIDE cells, and joins the segments that are found.
 * Returns false if out of memory. */
bool level_lines(const struct level_request *request, struct polyline *line)
{
    struct marching m = {.request = request};
    const double(*box)[2] = request->box;
    double side[2][CELLS_PER_SIDE + 1];
    for (int k = 0; k < 2; k++)
        for (int i = 0; i <= CELLS_PER_SIDE; i++)
            side[k][i] = i == CELLS_PER_SIDE
                             ? box[k][1]
                             : box[k][0] + i * (box[k][1] - box[k][0]) / CELLS_PER_SIDE;
    for (int i = 0; i < CELLS_PER_SIDE; i++)
        for (int j = 0; j < CELLS_PER_SIDE; j++)
            examine_cells(
                &m,
                (const double[2][2]){{side[0][i], side[0][i + 1]}, {side[1][j], side[1][j + 1]}},
                CELLS_PER_SIDE);
    const bool fine = !m.failed && level_segments_join(&m, line);
    free(m.segment);
    return fine;
}
