/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The forces of a scene as expressions (written_make(), written_free()), and expressions as text of
 * other languages (expr_text()). */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/scene/model.h>

struct cancel;
struct catalog;

/* ---- expressions in other languages ----
 *
 * The operations in the order of the expression, so that a language of IEEE doubles gives the bits
 * of expr_value(), but for functions of its own library.
 */

/* Languages and formats in which programs are written. */
enum dialect { DIALECT_C, DIALECT_PYTHON, DIALECT_OCTAVE, DIALECT_XPP, DIALECT_TEX, DIALECTS };

/* their endings and explanations, indexed by enum dialect */
extern const struct catalog dialect_catalog;

/* Appends a number. In C and Python it is a double in any expression. */
void dialect_number(struct buffer *output, enum dialect dialect, double number);
/* Appends an expression, in C with "y^3" as y*y*y. name [names] has the text of each name. zero
 * [names] is true for names that are 0, whose products are left out; it may be NULL. Returns false
 * if out of memory. */
bool expr_text(const struct expr *expr, enum dialect dialect, const char *const *name,
               const bool *zero, struct buffer *output);
/* ---- the forces of a scene ---- */

/* The terms of each acceleration, or of each derivative in a scene of first order, in the order in
 * which hooke adds them, so that sums have hooke's bits. The names are t, the state [n], the
 * parameters, and the observed quantities, in this order. */
struct written {
    struct arena arena; /* memory of all expressions */
    const struct scene *scene;
    struct system system; /* the scene, bound */
    /* numbers of rows and of names; index of the first parameter among the names */
    int rows, names,
        params; /* numbers of rows and of names; index of the first parameter among the names */
    const char **name; /* [names] */
    bool *zero;        /* [names] parameters that are 0 */
    /* [rows] sum of all terms, of those without and of those with velocity (for splittings); NULL
     * if there are none */
    const struct expr *all[LIMIT_VARIABLES], *force[LIMIT_VARIABLES], *drag[LIMIT_VARIABLES];
    const struct expr *split[LIMIT_VARIABLES]; /* force plus drag, as splittings add them */
    /* magnitude of dry friction, which is in none of these sums, or NULL */
    const struct expr *dry;
    int observed;                /* index of the first observed quantity among the names */
    const struct expr **observe; /* [names - observed] */
    const struct cancel *cancel; /* stops the writing; the caller checks it, too */
};

/* Makes the expressions of a scene. With `as_typed` built-in terms have the form that readers know,
 * otherwise the one that is computed. Returns false with an error. written_free() must be called in
 * any case. */
bool written_make(struct written *written, const struct scene *scene, bool as_typed,
                  struct error *error);
/* Frees all expressions. */
void written_free(struct written *written);
