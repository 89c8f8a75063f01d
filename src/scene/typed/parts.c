/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Programs of typed terms: typed_part_create() makes them of the expressions, and the functions of
 * a term's row run them. */
#include "scene/typed/typed.h"

#include <stdlib.h>
#include <string.h>

#define FRAME_MAX 16384 /* doubles */
#define ADDED_FEW 256   /* number of elements of the Jacobian of 16 variables */

/* ---- evaluation ---- */

const struct typed_term *typed_term_of(const double *c)
{
    const struct typed_term *term;
    memcpy(&term, c, sizeof term);
    return term;
}

/* Runs the program in a frame on the stack, or in allocated memory if it is large. */
void typed_evaluate(const struct program *program, const double *c, double t, const double *y,
                    double *result)
{
    double few[PROGRAM_FEW], *frame = program_place(program, few);
    for (int i = 0; !frame && i < program->outputs; i++)
        result[i] = NAN;
    if (frame) {
        program_prepare(program, frame);
        program_run(program, t, y, c + 1, result, frame);
    }
    if (frame != few)
        free(frame);
}

/* Adds `count` outputs of a program to sum; NAN if out of memory. */
static void typed_sum(const struct program *program, const double *c, double t, const double *y,
                      int count, double *sum)
{
    double few[ADDED_FEW],
        *value = count <= ADDED_FEW ? few : malloc((size_t)count * sizeof *value);
    if (value)
        typed_evaluate(program, c, t, y, value);
    for (int i = 0; i < count; i++)
        sum[i] += value ? value[i] : NAN;
    if (value != few)
        free(value);
}

void typed_add_force(const double *c, double t, const double *y, double *a)
{
    const struct typed_term *term = typed_term_of(c);
    typed_sum(term->add, c, t, y, typed_rows(term->typed), a);
}

void typed_add_jacobian(const double *c, double t, const double *y, double *jac)
{
    const struct typed_term *term = typed_term_of(c);
    typed_sum(term->jacobian, c, t, y, typed_rows(term->typed) * term->typed->model.n, jac);
}

/* Returns the typed potential [J] of a term (struct term_row). */
static double potential(const double *c, const double *y)
{
    const struct typed_term *term = typed_term_of(c);
    double value[1];
    typed_evaluate(term->potential, c, 0, y, value);
    return value[0];
}

/* Reads the ratios of masses, which are behind the values of the bound term. */
void typed_masses(const double *c, double *mass)
{
    const struct typed_term *term = typed_term_of(c);
    const int rows = typed_rows(term->typed);
    const bool differ = typed_ratios_fit(term);
    for (int i = 0; i < rows; i++) {
        const double ratio = differ ? c[TERM_VALUES - 1 - i] : 0;
        mass[i] = ratio > 0 ? ratio * c[1] : c[1];
    }
}

/* Returns the power [W] of a term (struct term_row). */
static double power(const double *c, double t, const double *y)
{
    const struct typed_term *term = typed_term_of(c);
    const int rows = typed_rows(term->typed);
    double rate[LIMIT_VARIABLES] = {0}, mass[LIMIT_VARIABLES] = {0}, sum = 0;
    typed_masses(c, mass);
    typed_evaluate(term->add, c, t, y, rate);
    for (int i = 0; i < rows; i++)
        sum += mass[i] * rate[i] * y[rows + i];
    return sum;
}

/* ---- making programs ---- */

/* State while a part is made. */
struct part_making {
    const struct typed *typed;
    struct typed_part *part;
    struct equations *equations;
    const bool *bound;   /* [names] the name is a parameter that is 0 */
    const double *value; /* [names] all 0 */
    struct error *error;
};

/* Use of a program: in each step, so that values that depend on parameters only are retained when
 * the scene is bound; often; or rarely, so that it has no machine code. */
enum use { STEPS, LOOKS, RARELY };

/* Makes a program of the last `count` outputs. Returns NULL with an error, also if it is too large.
 */
static struct program *part_program_make(const struct part_making *m, int count, enum use use)
{
    const struct steady_names steady = {1 + m->typed->model.n, m->part->steady,
                                        use == STEPS ? TERM_VALUES - 1 - m->part->steady : 0};
    struct program *program =
        program_create_keeping(m->equations, equations_count(m->equations) - count, count, m->bound,
                               m->value, &steady, use != RARELY, m->error);
    if (program)
        m->part->steady += program->keeps;
    if (!program || program_frame(program) <= FRAME_MAX)
        return program;
    error_set(m->error, ERROR_COMMAND,
              "the equations are too large: they need %zu intermediate values, at most %d are "
              "possible",
              program_frame(program), FRAME_MAX);
    program_destroy(program);
    return NULL;
}

/* Returns true if the first `count` outputs of a program are the number 0. */
static bool all_zero(const struct program *program, int count)
{
    double value;
    for (int i = 0; i < count; i++)
        if (!program_constant(program, i, &value) || value != 0)
            return false;
    return true;
}

/* Returns the flags of a term's row that follow from what its programs depend on. */
static unsigned flags_of(const struct typed_term *term, bool affine, bool kinks)
{
    const struct typed *typed = term->typed;
    const int n = typed->model.n, rows = typed_rows(typed), entries = rows * n;
    unsigned flags = 0;
    if (affine && !program_depends_on(term->jacobian, 0, entries, 0, 1 + n))
        flags |= TERM_LINEAR;
    if (program_depends(term->add, 0, rows, 0))
        flags |= TERM_TIME;
    if (typed->model.order == 2 && program_depends_on(term->add, 0, rows, 1 + rows, rows))
        flags |= TERM_VELOCITY;
    if (kinks && typed->model.order == 2 && n == 2)
        flags |= TERM_KINK;
    return flags;
}

/* Makes the program of the expressions [rows], unless all are 0; sets *first to the index of their
 * outputs. Returns false with an error. */
static bool make_add(const struct part_making *m, struct typed_term *term,
                     const struct expr *const *expr, int *first)
{
    static const struct op zero = {.kind = OP_NUMBER, .number = 0};
    const struct expr nothing = {.op = (struct op *)(uintptr_t)&zero, .count = 1};
    const int rows = typed_rows(m->typed);
    term->typed = m->typed;
    term->part = m->part;
    *first = equations_count(m->equations);
    for (int i = 0; i < rows; i++)
        if (!equations_add(m->equations, expr[i] ? expr[i] : &nothing, m->error))
            return false;
    term->add = part_program_make(m, rows, STEPS);
    if (term->add && all_zero(term->add, rows)) {
        program_destroy(term->add);
        term->add = NULL;
        return true;
    }
    return term->add;
}

/* Makes the Jacobian and the row of a term whose program `add` was made of the outputs from `first`
 * on. Returns false with an error. */
static bool make_term(const struct part_making *m, struct typed_term *term, int first, enum use use)
{
    const int n = m->typed->model.n, rows = typed_rows(m->typed);
    int state[LIMIT_VARIABLES];
    if (!term->add)
        return true;
    for (int i = 0; i < n; i++)
        state[i] = 1 + i;
    if (!equations_derive(m->equations, first, rows, state, n, m->error))
        return false;
    term->jacobian = part_program_make(m, rows * n, use);
    bool affine, kinks;
    if (!term->jacobian || !typed_look(m->typed, term->add, &affine, &kinks, m->error))
        return false;
    term->row.flags = flags_of(term, affine, kinks);
    term->row.add = typed_add_force;
    term->row.jacobian = all_zero(term->jacobian, rows * n) ? NULL : typed_add_jacobian;
    return true;
}

/* Makes the term of the sum of all groups, in the order in which they would be added. Returns false
 * with an error. */
static bool sum_term_make(const struct part_making *m, struct typed_part *part)
{
    const struct typed *typed = m->typed;
    struct arena arena = {0};
    const struct expr **whole = arena_array(&arena, (size_t)typed_rows(typed), sizeof *whole);
    bool fine = true;
    int first;
    if (!whole) {
        error_memory(m->error);
        return false;
    }
    for (int g = 0; fine && g < GROUPS; g++)
        for (int i = 0; fine && part->term[g].add && i < typed_rows(typed); i++) {
            const struct expr *more = typed->group[g][i];
            if (more)
                whole[i] = whole[i] ? typed_join(&arena, whole[i], more, OP_ADD, m->error) : more;
            fine = !more || whole[i];
        }
    fine = fine && make_add(m, &part->all, whole, &first) && make_term(m, &part->all, first, STEPS);
    arena_reset(&arena);
    return fine;
}

/* Makes the programs of the antiderivatives of the forces that depend on positions only, if these
 * are found. Returns false only with an error. */
static bool make_integrals(const struct part_making *m, struct typed_term *force, int first)
{
    const int rows = typed_rows(m->typed);
    int position[LIMIT_VARIABLES];
    struct error error = {.code = ERROR_NONE};
    for (int i = 0; i < rows; i++)
        position[i] = 1 + i;
    if (equations_integrate(m->equations, first, rows, position, false, &error) &&
        !(force->parts = part_program_make(m, 3 * rows, LOOKS)))
        return false;
    if (rows > 1 && error.code == ERROR_NONE &&
        equations_integrate(m->equations, first, rows, position, true, &error) &&
        !(force->axes = part_program_make(m, rows, LOOKS)))
        return false;
    if (error.code != ERROR_NONE)
        *m->error = error;
    return error.code == ERROR_NONE;
}

/* Makes the terms of all groups, and that of their sum if there are several. Returns false with an
 * error. */
static bool make_groups(const struct part_making *m, struct typed_part *part)
{
    const struct typed *typed = m->typed;
    size_t row = typed->terms.count;
    int there = 0, first[GROUPS] = {0}; /* groups with a program; outputs of each group */
    for (int g = 0; g < GROUPS; g++)
        row -= typed->group[g] != NULL;
    for (int g = 0; g < GROUPS; g++) {
        struct typed_term *term = &part->term[g];
        if (!typed->group[g])
            continue;
        term->row = typed->row[row++];
        if (!make_add(m, term, typed->group[g], &first[g]))
            return false;
        there += term->add != NULL;
        if ((g != GROUP_FORCE || !typed->potential) && typed->model.order == 2)
            term->row.power = power;
    }
    const bool whole = there >= 2 && !typed->base;
    for (int g = 0; g < GROUPS; g++)
        if (typed->group[g] && !make_term(m, &part->term[g], first[g], whole ? RARELY : STEPS))
            return false;
    struct typed_term *force = &part->term[GROUP_FORCE];
    if (force->add && !typed->potential && typed->model.order == 2 && !typed->base &&
        !(force->row.flags & TERM_LINEAR) && !make_integrals(m, force, first[GROUP_FORCE]))
        return false;
    typed_found_rows(part);
    return !whole || sum_term_make(m, part);
}

/* Makes the programs of the observed quantities and of the typed potential. Returns false with an
 * error. */
static bool observed_make(const struct part_making *m, struct typed_part *part)
{
    const struct typed *typed = m->typed;
    struct typed_term *force = &part->term[GROUP_FORCE];
    int position[LIMIT_VARIABLES];
    for (int i = 0; i < typed->observes; i++)
        if (!equations_add(m->equations, typed->observe[i], m->error))
            return false;
    part->all.typed = typed;
    part->all.part = part;
    equations_exact(m->equations, true);
    const bool fine = typed->observes == 0 ||
                      (part->all.observe = part_program_make(m, typed->observes, LOOKS)) != NULL;
    equations_exact(m->equations, false);
    if (!fine)
        return false;
    if (!typed->potential)
        return true;
    const int rows = typed_rows(typed), first = equations_count(m->equations);
    for (int i = 0; i < rows; i++)
        position[i] = 1 + i;
    if (!equations_add(m->equations, typed->potential, m->error) ||
        !(force->potential = part_program_make(m, 1, LOOKS)) ||
        !equations_derive(m->equations, first, 1, position, rows, m->error) ||
        !(part->all.slope = part_program_make(m, rows, RARELY)))
        return false;
    force->typed = typed;
    force->part = part;
    force->row.potential = potential;
    force->row.flags |= TERM_CONSERVATIVE;
    return true;
}

/* Frees the programs of a term. */
static void term_free(struct typed_term *term)
{
    struct program *const program[] = {term->add,     term->jacobian, term->potential, term->slope,
                                       term->observe, term->parts,    term->axes};
    for (size_t i = 0; i < COUNT_OF(program); i++)
        program_destroy(program[i]);
}

/* Frees the part with all its programs. */
void typed_part_destroy(struct typed_part *part)
{
    for (int g = 0; g < GROUPS; g++)
        term_free(&part->term[g]);
    term_free(&part->all);
    term_free(&part->frozen);
    program_destroy(part->argument);
    free(part);
}

/* Makes the groups, the observed quantities and the frozen equations, all of the same names. */
struct typed_part *typed_part_create(const struct typed *typed, uint64_t zeros, struct error *error)
{
    const int names = typed_names(typed);
    struct typed_part *part = calloc(1, sizeof *part);
    bool *bound = calloc((size_t)names, sizeof *bound);
    double *value = calloc((size_t)names, sizeof *value);
    struct part_making m = {typed, part, NULL, bound, value, error};
    bool fine = part && bound && value;
    if (fine)
        part->steady = 1 + typed->reads;
    if (!fine)
        error_memory(error);
    else
        fine = (m.equations = equations_create(names, error)) != NULL;
    for (int i = 0; fine && i < typed->reads; i++)
        bound[typed_first_read(typed) + i] = zeros >> i & 1;
    for (int i = 0; fine && i < typed->observes; i++)
        fine =
            equations_let(m.equations, typed_first_observed(typed) + i, typed->observe[i], error);
    fine = fine && make_groups(&m, part) && observed_make(&m, part) &&
           typed_freeze(typed, zeros, part, error);
    equations_destroy(m.equations);
    free(bound);
    free(value);
    if (fine) {
        part->zeros = zeros;
        return part;
    }
    if (part)
        typed_part_destroy(part);
    return NULL;
}
