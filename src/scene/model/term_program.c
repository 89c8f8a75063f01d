/* SPDX-License-Identifier: GPL-3.0-or-later */
/* terms_program(): programs of the sum of built-in terms of one coordinate, from the texts of their
 * forces. */
#include "scene/model/forces.h"
#include "scene/typed/typed.h"

/* Scope of the text of one term: t, q, v are names 0 to 2, and its coefficient cJ is the name
 * first + term TERM_COEFFICIENTS + J. */
struct term_scope {
    int first, term;
};

/* Sets *slot to that of a name in this scope; returns false if it is none. */
static bool coefficient_slot_find(const void *context, struct text name, int *slot)
{
    static const char state[] = "tqv";
    const struct term_scope *scope = context;
    for (int i = 0; i < 3 && name.len == 1; i++)
        if (name.data[0] == state[i]) {
            *slot = i;
            return true;
        }
    if (name.len != 2 || name.data[0] != 'c')
        return false;
    *slot = scope->first + scope->term * TERM_COEFFICIENTS + (name.data[1] - '0');
    return true;
}

bool terms_have_text(const struct system *system)
{
    bool have = system->order == 2 && system->n == 2;
    for (int i = 0; have && i < system->terms; i++)
        have = !system->term[i].row->bind || system->term[i].row->text;
    return have;
}

/* Returns true for a built-in term whose flags under `mask` are `wanted`. */
static bool is_wanted(const struct term_row *row, unsigned mask, unsigned wanted)
{
    return row->bind && (row->flags & mask) == wanted;
}

/* Compiles the sum of the terms that are wanted, in memory of the arena. Returns NULL if there is
 * none, or with an error. */
static const struct expr *sum_of_terms(const struct system *system, unsigned mask, unsigned wanted,
                                       int first, struct arena *arena, struct error *error)
{
    const struct expr *sum = NULL;
    for (int i = 0; i < system->terms; i++) {
        const struct term_row *row = system->term[i].row;
        const struct term_scope names = {first, i};
        const struct expr_scope scope = {.context = &names, .find = coefficient_slot_find};
        size_t used;
        if (!is_wanted(row, mask, wanted))
            continue;
        const struct expr *more = expr_compile(text_of(row->text), &scope, arena, &used, error);
        sum = sum && more ? typed_join(arena, sum, more, OP_ADD, error) : more;
        if (!sum)
            return NULL;
    }
    return sum;
}

/* Compiles the sum of the terms as equations, and derives it if slopes are wanted. */
struct program *terms_program(const struct system *system, unsigned mask, unsigned wanted,
                              int first, bool slopes, struct error *error)
{
    static const int state[] = {1, 2};
    struct arena arena = {0};
    struct program *program = NULL;
    struct equations *equations =
        equations_create(first + TERM_COEFFICIENTS * system->terms, error);
    const struct expr *sum =
        equations ? sum_of_terms(system, mask, wanted, first, &arena, error) : NULL;
    if (sum && equations_add(equations, sum, error) &&
        (!slopes || equations_derive(equations, 0, 1, state, 2, error)))
        program = program_create(equations, slopes, 1 + slopes, NULL, NULL, false, error);
    equations_destroy(equations);
    arena_reset(&arena);
    return program;
}
