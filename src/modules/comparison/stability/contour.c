/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Traces zero lines by marching squares: signs at the nodes of a grid, roots on its edges, edges
 * linked cell by cell. */
#include "modules/comparison/stability/contour.h"

#include <math.h>
#include <stdlib.h>

enum { HALVINGS = 46 /* number of halvings of an edge, after which a root is known to rounding */ };

/* State of the tracing. Edges are numbered by edge_number(). */
struct march {
    const struct contour_field *field;
    int nx, ny;   /* number of cells in x and y */
    bool *inside; /* [(nx + 1) * (ny + 1)] true for nodes at which the field is <= 0 */
    /* [edges] the edges at which the line continues on either side, or -1 */
    int (*link)[2];
    double (*root)[2]; /* [edges] point at which the line crosses the edge */
};

/* Returns the coordinate of node i on an axis, 0 for x and 1 for y. */
static double node_coordinate(const struct march *m, int axis, int i)
{
    const struct contour_field *f = m->field;
    return f->lower[axis] + (f->upper[axis] - f->lower[axis]) * i / f->cells[axis];
}

/* Returns true if the field is <= 0 at a point. */
static bool is_inside(const struct march *m, double x, double y)
{
    return m->field->value(m->field->context, x, y) <= 0;
}

/* Returns the stored result of is_inside() at a node. */
static bool node_is_inside(const struct march *m, int i, int j)
{
    return m->inside[(size_t)j * (size_t)(m->nx + 1) + (size_t)i];
}

/* Returns the number of the edge from node i, j to the right or, if `vertical`, upwards. */
static int edge_number(const struct march *m, int i, int j, bool vertical)
{
    return vertical ? m->nx * (m->ny + 1) + j * (m->nx + 1) + i : j * m->nx + i;
}

/* Finds by bisection where the boundary of a region crosses the edge of a grid cell that begins at
 * node (i, j) and runs up if `vertical`, else to the right; one end must be inside. Sets root {x,
 * y}. */
static void find_root(const struct march *m, int i, int j, bool vertical, double root[2])
{
    double a[2] = {node_coordinate(m, 0, i), node_coordinate(m, 1, j)},
           b[2] = {node_coordinate(m, 0, i + !vertical), node_coordinate(m, 1, j + vertical)};
    const bool first = node_is_inside(m, i, j);
    for (int k = 0; k < HALVINGS; k++) {
        const double middle[2] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
        double *end = is_inside(m, middle[0], middle[1]) == first ? a : b;
        end[0] = middle[0];
        end[1] = middle[1];
    }
    root[0] = (a[0] + b[0]) / 2;
    root[1] = (a[1] + b[1]) / 2;
}

/* Links two edges of a cell that a line crosses. */
static void link_edges(struct march *m, int a, int b)
{
    m->link[a][m->link[a][0] >= 0] = b;
    m->link[b][m->link[b][0] >= 0] = a;
}

/* Links the edges of grid cell (i, j) that the boundary crosses: two of them, or four at a saddle,
 * where the value in the middle decides which corners are cut off. */
static void link_cell(struct march *m, int i, int j)
{
    const bool corner[4] = {node_is_inside(m, i, j), node_is_inside(m, i + 1, j),
                            node_is_inside(m, i + 1, j + 1), node_is_inside(m, i, j + 1)};
    const int edge[4] = {edge_number(m, i, j, false), edge_number(m, i + 1, j, true),
                         edge_number(m, i, j + 1, false), edge_number(m, i, j, true)};
    int crossed[4], n = 0;
    for (int k = 0; k < 4; k++)
        if (corner[k] != corner[(k + 1) % 4])
            crossed[n++] = edge[k];
    if (n == 2)
        link_edges(m, crossed[0], crossed[1]);
    if (n != 4)
        return;
    const bool middle = is_inside(m, (node_coordinate(m, 0, i) + node_coordinate(m, 0, i + 1)) / 2,
                                  (node_coordinate(m, 1, j) + node_coordinate(m, 1, j + 1)) / 2);
    const int turned = middle == corner[0]; /* corners 1 and 3 are cut off, else 0 and 2 */
    link_edges(m, crossed[0], crossed[turned ? 1 : 3]);
    link_edges(m, crossed[2], crossed[turned ? 3 : 1]);
}

/* Appends a point. Returns false if out of memory. */
static bool contour_add(struct contour *contour, double x, double y)
{
    if (contour->n == contour->capacity) {
        const size_t capacity = contour->capacity ? 2 * contour->capacity : 512;
        double *wider = realloc(contour->x, capacity * sizeof *wider);
        contour->x = wider ? wider : contour->x;
        double *higher = wider ? realloc(contour->y, capacity * sizeof *higher) : NULL;
        contour->y = higher ? higher : contour->y;
        if (!higher)
            return false;
        contour->capacity = capacity;
    }
    contour->x[contour->n] = x;
    contour->y[contour->n++] = y;
    return true;
}

/* Appends the line that continues from an edge, which ends with a point of NAN, and removes its
 * links. Returns false if out of memory. */
static bool follow_line(struct march *m, int edge, struct contour *contour)
{
    const int first = edge;
    bool ok = contour_add(contour, m->root[edge][0], m->root[edge][1]);
    for (int next; ok && (next = m->link[edge][m->link[edge][0] < 0]) >= 0; edge = next) {
        m->link[edge][m->link[edge][0] < 0] = -1;
        m->link[next][m->link[next][0] != edge] = -1;
        ok = contour_add(contour, m->root[next][0], m->root[next][1]);
        if (next == first)
            break;
    }
    return ok && contour_add(contour, (double)NAN, (double)NAN);
}

/* Evaluates the field at all nodes. Returns false if cancelled. */
static bool find_signs(struct march *m, const struct cancel *cancel)
{
    for (int j = 0; j <= m->ny; j++)
        for (int i = 0; i <= m->nx; i++) {
            if (cancelled(cancel))
                return false;
            m->inside[(size_t)j * (size_t)(m->nx + 1) + (size_t)i] =
                is_inside(m, node_coordinate(m, 0, i), node_coordinate(m, 1, j));
        }
    return true;
}

/* Finds the roots on all edges whose ends have different signs, and links them. Returns false if
 * cancelled. */
static bool find_roots(struct march *m, const struct cancel *cancel)
{
    for (int j = 0; j <= m->ny; j++)
        for (int i = 0; i <= m->nx; i++)
            for (int vertical = 0; vertical < 2; vertical++) {
                if (cancelled(cancel))
                    return false;
                if ((vertical ? j < m->ny : i < m->nx) &&
                    node_is_inside(m, i, j) != node_is_inside(m, i + !vertical, j + vertical))
                    find_root(m, i, j, vertical, m->root[edge_number(m, i, j, vertical)]);
            }
    for (int j = 0; j < m->ny; j++)
        for (int i = 0; i < m->nx; i++)
            link_cell(m, i, j);
    return true;
}

/* Finds the lines on which the field changes its sign, by bisection on edges of the grid. */
bool contour_trace(const struct contour_field *field, const struct cancel *cancel,
                   struct contour *contour)
{
    struct march m = {.field = field, .nx = field->cells[0], .ny = field->cells[1]};
    const size_t nodes = (size_t)(m.nx + 1) * (size_t)(m.ny + 1), edges = 2 * nodes;
    m.inside = malloc(nodes * sizeof *m.inside);
    m.link = malloc(edges * sizeof *m.link);
    m.root = malloc(edges * sizeof *m.root);
    bool ok = m.inside && m.link && m.root;
    for (size_t e = 0; ok && e < edges; e++)
        m.link[e][0] = m.link[e][1] = -1;
    ok = ok && find_signs(&m, cancel) && find_roots(&m, cancel);
    /* Lines that end at the border first, then those that are closed. */
    for (int closed = 0; closed < 2; closed++)
        for (int e = 0; ok && e < (int)edges; e++)
            if (m.link[e][0] >= 0 && (closed || m.link[e][1] < 0))
                ok = follow_line(&m, e, contour);
    free(m.inside);
    free(m.link);
    free(m.root);
    return ok;
}

void contour_free(struct contour *contour)
{
    free(contour->x);
    free(contour->y);
    *contour = (struct contour){NULL, NULL, 0, 0};
}
