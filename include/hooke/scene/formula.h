/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compiles and evaluates expressions that users type, computes their bounds, and makes programs. */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/quantity.h>

struct catalog;
struct suggestion;

/* ---- expressions ----
 *
 * + - * / ^ ( ), unary -, numbers, pi, functions, and names that a scope knows. Compiled once
 * (operator precedence parsing with constant folding) into a stack program; values are SI numbers.
 * `^` binds tighter than unary minus and to the right: -2^2 = -4. A name may have a hyphen inside
 * (phase-error) where the scope knows it as a whole. Inside of parentheses and calls < <= > >=
 * compare, to 1 or 0: (x < 0)*k*x. A NaN operand of a comparison gives NaN.
 *
 * x^n is multiplications where n is an integer or half of one and |n| <= 16, rounded after each:
 * the bits of |n| from the highest down, r r for each and r x for a 1, for the half times sqrt(x),
 * and 1/that for n < 0; else pow().
 */

struct expr_scope {
    const void *context;
    /* Slot of a name; false if unknown. */
    bool (*find)(const void *context, struct text name, int *slot);
    double (*load)(const void *context, int slot);
    /* Offers every known name for "did you mean"; may be NULL. */
    void (*offer)(const void *context, struct suggestion *suggestion);
    /* Set if a run's names are wrapped. Returns the slot in the run's own scope (run_scope), or -1
     * for what does not move. NULL keeps slots unchanged. */
    int (*moving)(const void *context, int slot);
    /* Returns the quantity of a name, or QUANTITY_OTHER if it is unknown. If it is set, numbers and
     * parentheses may carry units. If it is NULL, an expression ends before a unit. */
    enum quantity (*quantity)(const void *context, int slot);
};

struct expr;
struct dimension;

extern const struct catalog function_catalog; /* sin, cos, …: help and completion */

/*
 * Compiles the longest expression at the start of `text`; *used [byte] is where it stops (at a
 * unit, a comma, a colon, "+-", a comparison or the end). Takes memory from `arena`. scope may be
 * NULL (constants only). Fails with an error at an unknown name (with a suggestion), a malformed
 * number, a missing operand or parenthesis, or a limit of depth or size.
 */
const struct expr *expr_compile(struct text text, const struct expr_scope *scope,
                                struct arena *arena, size_t *used, struct error *error);
/*
 * A unit binds to the number or the parenthesis before it: y0 + 1 cm, 0.5*m + 50 g, (3 + 1) s.
 * Numbers with units keep their dimension (hooke/scene/dimension.h); what does not go together is
 * an error that shows both readings. The value is in SI.
 */
const struct dimension *expr_dimension(const struct expr *expr);
/* Adds a hint, while the text of the expression exists, on how it was read and how it could be
 * meant: `1/30 s`. Always returns false. */
bool expr_hint_readings(const struct expr *expr, struct error *error);
/* Both sides of a comparison: refuses those of different dimensions, converts *right between Hz and
 * rad/s. */
bool expr_compare(const struct expr *left, const struct expr **right, struct arena *arena,
                  struct error *error);
/* NaN and infinities pass through. */
double expr_value(const struct expr *expr, const struct expr_scope *scope);
/* Returns true if the formula, as it is written, is linear in these names together: a0 + a1 x1 + a2
 * x2, where other names occur only in the a. */
bool expr_linear(const struct expr *expr, const int *slot, int count);

/* ---- bounds ---- */

/* All numbers from lo to hi; both NAN: none, because the value is not a number. */
struct interval {
    double lo, hi;
};

/* Bounds of a function of one argument on a stretch of it, of its first and of its second
 * derivative there. */
struct jet {
    struct interval value, slope, bend;
};

/*
 * The bounds that follow from those of the names, jet [slot]; rounding is inside. At a jump the
 * slope is unbounded, at a corner the second derivative (Moore 1966, Interval Analysis; natural
 * extension, forward mode).
 */
struct jet expr_jet(const struct expr *expr, const struct jet *jet);
/*
 * As expr_jet(), over an argument within `half` of where the names are centre [slot]: what each
 * part of the expression is there and its slope bound it, too (the mean value form, Moore 1966).
 * t*t - 2*a*t + a*a is as narrow as (t - a)^2.
 */
struct jet expr_jet_about(const struct expr *expr, const struct jet *jet, const struct jet *centre,
                          double half);
/*
 * Search for the zeros of a function of x on a stretch. It finds every zero, as proved by bounds of
 * the function, or reports the position from which they do not decide.
 */
struct root_search {
    void *context;
    double (*value)(void *context, double x);
    struct jet (*bounds)(void *context, double a, double b);
    /* Takes the zeros in the order of x, with the sign beyond, or 0 where the function only touches
     * 0. Returns false to end the search. */
    bool (*found)(void *context, double x, int sign);
    /* Returns true if the value at x is 0 within errors; may be NULL. */
    bool (*touches)(void *context, double x);
    double touch_tolerance; /* extreme values that are no farther from 0 are asked for, too */
    double min;             /* stretches are not cut below this length */
    int budget;             /* bounds asked for, beside some for each root */

    /* Sign of the last value other than 0. The caller sets it for the time before the stretch; it
     * is then that at the end. */
    int sign;

    int used, count;
    bool unsure; /* the bounds did not decide from here on */
    double unsure_from;
    bool nonzero; /* some value inside was not 0; only ever set */
    bool stopped, touched;
    double last_touch;
};

/*
 * The root between a and b, where the values fa and fb have different signs: inverse quadratic
 * interpolation where that is safe, else bisection (Chandrupatla 1997, Adv. Eng. Software 28:145).
 * It is known to `min`; where it returns, the value is 0 or has the sign of fb.
 */
double root_between(double (*value)(void *context, double x), void *context, double a, double fa,
                    double b, double fb, double min);

/* Finds the roots from a, where the value is fa, to b. */
void roots_find(struct root_search *roots, double a, double fa, double b, double fb);

/*
 * The same expression where the names that move have the slots that `slot` says, and others, for
 * which it is < 0, are the numbers that they are now. Returns NULL if out of memory.
 */
const struct expr *expr_settle(const struct expr *expr, const struct expr_scope *scope,
                               int (*slot)(void *context, int slot), void *context,
                               struct arena *arena);

/* ---- programs ----
 *
 * Expressions that are evaluated often. Equations hold several in the same names (0 … names - 1,
 * the slots of their scope) as a graph: what they share is computed once; derivatives are added to
 * it. A program is some of them with some names known and the rest as inputs; making it again for
 * other values takes microseconds. It has two forms that give the same bits: operations on the
 * doubles of a frame and, where the machine can, machine code.
 *
 * The result is that of expr_value() bit for bit but for the rule of the scene that a term whose
 * coefficient is 0 is absent: where a factor is the number 0 once the known names are in (not a
 * variable that happens to be 0), or a numerator is a known name that is 0, the term is 0 even for
 * an infinite or NaN rest, and adding or subtracting it leaves no trace, not even in the sign of a
 * zero. What is observed follows no such rule.
 */

#define PROGRAM_SIZE (1 << 17) /* operations of equations with their derivatives */

struct equations;
struct program;

/* Creates an empty set of equations. If a later call fails, nothing more can be added, and what was
 * added before stays valid. Returns NULL if out of memory. */
struct equations *equations_create(int names, struct error *error);
void equations_destroy(struct equations *equations);
/* Makes the name mean this expression of earlier names from this call on. */
bool equations_let(struct equations *equations, int name, const struct expr *expr,
                   struct error *error);
/* One more output. */
bool equations_add(struct equations *equations, const struct expr *expr, struct error *error);
/* More outputs: for each of `count` outputs from `first` its partial derivatives by the names,
 * [count][names]. Those of abs, sign, min, max, step, if, comparisons and roundings are those of
 * the branch taken; abs has 0 at 0. */
bool equations_derive(struct equations *equations, int first, int count, const int *name, int names,
                      struct error *error);
/* Keeps a factor of 0 in a derivative at 0 from this call on. The infinite slope of sqrt at 0
 * then does not spoil what does not depend on it, nor does that of a branch spoil what does not
 * take it. */
void equations_keep_limits(struct equations *equations);
/* Programs that are made from here on follow IEEE arithmetic, without the rule of absent terms. */
void equations_exact(struct equations *equations, bool exact);
int equations_count(const struct equations *equations); /* outputs */

/*
 * Compiles `count` outputs from `first`, at least one. bound, value [names] tell which names are
 * known, and their values; they may be NULL. With `native` the program is machine code where
 * possible. The equations may change or go away afterwards. Returns NULL if out of memory or if the
 * program would be too large.
 */
struct program *program_create(const struct equations *equations, int first, int count,
                               const bool *bound, const double *value, bool native,
                               struct error *error);
void program_destroy(struct program *program);
bool program_native(const struct program *program);
/* a product and the sum that it goes into count as one */
int program_operations(const struct program *program);
/* depends on no input */
bool program_constant(const struct program *program, int output, double *value);
/* Returns true if any of `count` outputs from `first` depends on the input as written. */
bool program_depends(const struct program *program, int first, int count, int name);

/* Doubles of a frame. It serves one thread at a time. */
size_t program_frame(const struct program *program);
/* Once for each frame; costs nothing where the program is machine code. */
void program_prepare(const struct program *program, double *frame);
/* input [names], those of known names are not read; it may be the frame itself. output [count],
 * apart from the input. Returns the first output. Never allocates. */
double program_eval(const struct program *program, const double *input, double *output,
                    double *frame);

/*
 * A program's own function, for kernels: names 0, 1, 2 as numbers, so that a state of two needs no
 * memory; name i >= 3 is state[i - 1], those that are given (of a typed term: the values behind t
 * and the state) follow in an array of their own. Outputs 0 and 1 are returned, as calling
 * conventions do it (of a single one the second is anything), the others stored. What has no such
 * names or outputs may be NULL.
 */
struct leading {
    double first, second;
};
typedef struct leading program_function(const struct program *program, double x0, double x1,
                                        double x2, const double *state, const double *steady,
                                        double *output, double *frame);
program_function *program_code(const struct program *program);

/* A comparison `expr < expr` (also <= > >=), as in `run until y < 0`. The sides may carry units: y
 * < 1 cm. */
struct condition {
    const struct expr *left, *right;
    bool less, or_equal;
};

bool condition_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                       struct condition *condition, size_t *used, struct error *error);
/* left - right, with the sign such that the condition holds where the value is < 0 (or <= 0). */
double condition_value(const struct condition *condition, const struct expr_scope *scope);
bool condition_holds(const struct condition *condition, double value);
