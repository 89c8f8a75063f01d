/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The forces of a scene as text of other languages. */
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

enum dialect { DIALECT_C, DIALECT_PYTHON, DIALECT_OCTAVE, DIALECT_XPP, DIALECT_TEX, DIALECTS };

/* struct row at the enum's place */
extern const struct catalog dialect_catalog;

/* A number, in C and Python one that is a double whatever stands beside it. */
void dialect_number(struct buffer *output, enum dialect dialect, double number);
/* Writes an expression; in C "y^3" becomes y*y*y. name [names] replaces each name; zero [names]
 * marks names that are 0, whose products are left out, as programs do; it may be NULL. Returns
 * false if out of memory. */
bool expr_text(const struct expr *expr, enum dialect dialect, const char *const *name,
               const bool *zero, struct buffer *output);
/* ---- the forces of a scene ---- */

/*
 * Terms of each acceleration, or of each derivative in a scene of first order, in the order in
 * which hooke adds them, so that the sums have hooke's bits. The names are t, the state [n], the
 * parameters, and the observed quantities.
 */
struct written {
    struct arena arena;
    const struct scene *scene;
    struct system system;
    int rows, names, params; /* params is the index of the first parameter among the names */
    const char **name;       /* [names] */
    bool *zero;              /* [names] parameters that are 0 */
    /* [rows] NULL: nothing is added. force and drag: without and with velocity, for splittings */
    const struct expr *all[LIMIT_VARIABLES], *force[LIMIT_VARIABLES], *drag[LIMIT_VARIABLES];
    const struct expr *split[LIMIT_VARIABLES]; /* force, then drag, as splittings add them */
    /* Dry friction, which is in none of them; NULL if there is none. */
    const struct expr *dry;
    int observed;                /* the first name of what is observed */
    const struct expr **observe; /* [names - observed] */
    const struct cancel *cancel; /* Stops the writing; the caller that began it checks it, too. */
};

/* The texts of another dialect, a built-in term as the reader knows it: as_typed, else as it is
 * computed. To be given back by written_free(), whatever it returns. */
bool written_make(struct written *written, const struct scene *scene, bool as_typed,
                  struct error *error);
void written_free(struct written *written);
