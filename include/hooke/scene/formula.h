/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * formula: expressions that users type (struct expr), their bounds and zeros, comparisons (struct
 * condition), and programs for expressions that are evaluated often (struct program).
 *
 * expr_compile() compiles a text in a scope of names; expr_value() evaluates the result. Compiled
 * expressions live in the caller's arena. Values are in SI units.
 */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/quantity.h>

struct catalog;
struct suggestion;

/*
 * ---- expressions ----
 *
 * An expression has + - * / ^, parentheses, unary -, numbers, pi, functions, and names of a scope.
 * It is compiled once, by operator precedence with constant folding, into a program for a stack.
 * `^` binds tighter than unary minus, and to the right: -2^2 = -4. A name may contain a hyphen
 * (phase-error) if the scope knows it in this form. In parentheses and arguments < <= > >= compare
 * and give 1 or 0: (x < 0)*k*x; a NaN operand gives NaN.
 *
 * If n is an integer or half of one and |n| <= 16, x^n is made of multiplications, each rounded.
 * For the bits of the integer part of |n| from the highest down, r (1 at first) is squared, then
 * multiplied by x if the bit is 1. A half multiplies r by sqrt(x). For n < 0 the result is 1/r. All
 * other powers are those of pow().
 */

/* The names that an expression may use, as callbacks of the owner of their values. The owner gives
 * each name a number, its slot. */
struct expr_scope {
    /* First argument of all callbacks. */
    const void *context;
    /* Finds the slot of a name. Returns false if the name is unknown. */
    bool (*find)(const void *context, struct text name, int *slot);
    /* Returns the current value [SI] of a name. */
    double (*load)(const void *context, int slot);
    /* Offers every known name to suggestion_offer(); may be NULL. */
    void (*offer)(const void *context, struct suggestion *suggestion);
    /* Returns the slot that a name has in the scope of the run (run_scope()), whose values move
     * (change) during the run, or -1 for a name that is constant during the run. Set by scopes that
     * contain other names than those of a run; NULL if all slots are those of run_scope(). */
    int (*moving)(const void *context, int slot);
    /* Returns the quantity of a name, or QUANTITY_OTHER if unknown. If this is set, numbers and
     * parentheses may carry units; if it is NULL, an expression ends before a unit. */
    enum quantity (*quantity)(const void *context, int slot);
};

struct expr; /* A compiled expression; immutable, in memory of an arena. */
struct dimension;

/* Functions of expressions (sin, cos, …), for help and completion. */
extern const struct catalog function_catalog;

/* Compiles the longest expression at the start of `text` and sets *used to its length [byte]; it
 * ends at a unit, a comma, a colon, "+-", a comparison or the end. The result is in memory of the
 * arena. `scope` may be NULL for constants only. Returns NULL, with `error` set, at an unknown
 * name, a malformed number, a missing operand or parenthesis, a sum of different dimensions, or if
 * the expression has too many operations. */
const struct expr *expr_compile(struct text text, const struct expr_scope *scope,
                                struct arena *arena, size_t *used, struct error *error);
/* Returns the dimension of an expression. A unit in it belongs to the number or parenthesis before
 * it: y0 + 1 cm, 0.5*m + 50 g, (3 + 1) s. The value of the expression is in SI units nevertheless.
 */
const struct dimension *expr_dimension(const struct expr *expr);
/* Adds to `error` a hint about how the expression was read and how the user may have meant it:
 * `1/30 s` is read as 1/(30 s), and may have been meant as (1/30) s. The text that was compiled
 * must still exist. Always returns false. */
bool expr_hint_readings(const struct expr *expr, struct error *error);
/* Checks that both sides of a comparison have the same dimension. If one is in Hz and the other in
 * rad/s, replaces *right by an expression in the arena that converts it. Returns false, with
 * `error` set, if the dimensions differ or if out of memory. */
bool expr_compare(const struct expr *left, const struct expr **right, struct arena *arena,
                  struct error *error);
/* Returns the value of the expression in `scope`, which must know the same names as the scope in
 * which it was compiled. Infinities and NaN are propagated. */
double expr_value(const struct expr *expr, const struct expr_scope *scope);
/* Returns true if the expression, in the form in which it is written, is linear in the `count`
 * names whose slots are slot [count]: a0 + a1 x1 + a2 x2 + …, where the coefficients a contain only
 * other names. */
bool expr_linear(const struct expr *expr, const int *slot, int count);

/* ---- bounds ---- */

/* The numbers from lo to hi; both NAN for the empty interval. Arithmetic is in
 * <hooke/scene/interval.h>. */
struct interval {
    double lo, hi;
};

/* Bounds of a function of one argument, and of its first derivative (`slope`) and its second one
 * (`bend`), over an interval of the argument. */
struct jet {
    struct interval value, slope, bend;
};

/* Returns bounds of an expression and of its derivatives from those of its names, jet [slot],
 * rounding included (natural interval extension in forward mode; Moore 1966, Interval Analysis). At
 * a jump of the expression its slope is unbounded, at a corner its second derivative. */
struct jet expr_jet(const struct expr *expr, const struct jet *jet);
/* Returns tighter bounds than expr_jet() for an interval of the argument that extends by `half` on
 * each side of its centre; centre [slot] holds the bounds of the names at the centre alone. In
 * every subexpression the value at the centre and the bounds of the slope give second bounds, of
 * which the narrower are used (mean value form, Moore 1966): t*t - 2*a*t + a*a becomes as narrow as
 * (t - a)^2. */
struct jet expr_jet_about(const struct expr *expr, const struct jet *jet, const struct jet *centre,
                          double half);
/* A search for all zeros of a function f(x) on an interval. Set the members up to `sign`, then call
 * roots_find(). Bounds of f prove that no zero is missed; `unsure` is set where they cannot prove
 * it within the budget. */
struct root_search {
    void *context;
    /* Returns f(x). */
    double (*value)(void *context, double x);
    /* Returns bounds of f on [a, b]. */
    struct jet (*bounds)(void *context, double a, double b);
    /* Receives each zero x in ascending order, with the sign of f just after it, or 0 if f touches
     * 0 without changing its sign. Returns false to end the search. */
    bool (*found)(void *context, double x, int sign);
    /* Returns true if f(x) is 0 within the errors of its computation; may be NULL. */
    bool (*touches)(void *context, double x);
    /* Extreme values of f whose magnitude is at most this are passed to touches(). */
    double touch_tolerance;
    double min; /* Length of the shortest intervals: shorter ones are not divided further. */
    int budget; /* Number of calls of bounds() that are allowed, in addition to 64 for each zero. */

    /* Sign of f, -1, 0 or 1. The caller sets the sign just before the interval, 0 if it is not
     * known; the search leaves the sign of the last nonzero value in the interval. */
    int sign;

    /* Results of the search: numbers of calls of bounds() and of zeros found. */
    int used, count;
    bool unsure; /* Zeros at x > unsure_from may have been missed. */
    double unsure_from;
    /* Some value in the interval was not 0; the search sets this and never clears it. */
    bool nonzero;
    /* found() has ended the search; f has touched 0 without changing its sign, the last time at
     * last_touch. */
    bool stopped, touched;
    double last_touch;
};

/* Returns a zero between a and b, where f has the values fa and fb of different signs, to within
 * `min` (Chandrupatla 1997, Adv. Eng. Software 28:145: inverse quadratic interpolation or
 * bisection). At the returned x the value is 0 or has the sign of fb. value(context, x) returns
 * f(x). */
double root_between(double (*value)(void *context, double x), void *context, double a, double fa,
                    double b, double fb, double min);

/* Searches [a, b] for zeros and calls roots->found() for each; fa and fb are the values of f at a
 * and b. */
void roots_find(struct root_search *roots, double a, double fa, double b, double fb);

/* Returns a copy of the expression, in the arena, for another scope and for fixed values of some
 * names. slot(context, s) is called for each name, where s is its slot in `scope`: it returns the
 * slot of the name in the new scope, or a value < 0 to replace the name by its current value.
 * Returns NULL if out of memory. */
const struct expr *expr_settle(const struct expr *expr, const struct expr_scope *scope,
                               int (*slot)(void *context, int slot), void *context,
                               struct arena *arena);

/*
 * ---- programs: compiled forms of expressions that are evaluated often ----
 *
 * A struct equations is a graph of several expressions in the same names, which have the numbers 0
 * to names - 1, their slots in a scope. Each expression is an output, numbered from 0. Common
 * subexpressions are computed once, and derivatives can be added. program_create() makes a program
 * for some of its outputs, with some names replaced by values; it takes microseconds, so that it is
 * called again for other values. Then call program_prepare() once for each frame of work memory,
 * and program_eval(). A program has two forms with the same bits: operations on the doubles of the
 * frame and, where the machine allows it, machine code.
 *
 * The result has the bits of expr_value(), except for one rule of scenes: a term whose coefficient
 * is 0 is absent. Its coefficient is 0 if a factor is the number 0 once the values are inserted
 * (not a variable that happens to be 0), or if a numerator is a replaced name that is 0. The term
 * is then 0 even if its other factors are infinite or NaN, and adding it does not even change the
 * sign of a zero. Observed quantities do not follow this rule.
 */

/* Largest number of operations of one set of equations with their derivatives. */
#define PROGRAM_SIZE (1 << 17)

struct equations; /* Several expressions as a graph; created and owned by the caller. */
/* A compiled form of some outputs; immutable, so that several threads may use it, each with a frame
 * of its own. */
struct program;

/* Creates an empty set of equations in `names` names; free it by equations_destroy(). Returns NULL,
 * with `error` set, if out of memory. If a later call fails, nothing more can be added, and what
 * was added before remains valid. */
struct equations *equations_create(int names, struct error *error);
/* Frees the equations; NULL is allowed. Programs made from them remain valid. */
void equations_destroy(struct equations *equations);
/* Defines name number `name` as an expression of other names, which replaces it in all expressions
 * that are added later. Returns false with `error` set. */
bool equations_let(struct equations *equations, int name, const struct expr *expr,
                   struct error *error);
/* Adds an expression as the next output. Returns false with `error` set. */
bool equations_add(struct equations *equations, const struct expr *expr, struct error *error);
/* Adds as outputs the partial derivatives [count][names] of the outputs first to first + count - 1
 * with respect to the names whose numbers are name [names]. Functions with branches (abs, sign,
 * min, max, step, if, comparisons, roundings) have the derivative of the current branch; that of
 * abs is 0 at 0. Returns false with `error` set. */
bool equations_derive(struct equations *equations, int first, int count, const int *name, int names,
                      struct error *error);
/* Makes products in derivatives that are added after this call 0 if one factor is 0, even if the
 * other is infinite. Then the infinite slope of sqrt at 0, or that of a branch not taken, does not
 * affect derivatives that do not depend on it. */
void equations_keep_limits(struct equations *equations);
/* Programs that are created after this call use plain IEEE arithmetic, without the rule of absent
 * terms, if `exact` is true. */
void equations_exact(struct equations *equations, bool exact);
int equations_count(const struct equations *equations); /* Returns the number of outputs. */

/* Compiles the outputs first to first + count - 1, count >= 1. Name i is replaced by value[i] if
 * bound[i]; both arrays have [names] elements and may be NULL if no name is replaced. With
 * `native`, the program is machine code where possible. The equations may be changed or destroyed
 * afterwards. Free the program by program_destroy(). Returns NULL, with `error` set, if out of
 * memory or if the program would be too large. */
struct program *program_create(const struct equations *equations, int first, int count,
                               const bool *bound, const double *value, bool native,
                               struct error *error);
/* Frees a program; NULL is allowed. */
void program_destroy(struct program *program);
/* Returns true if the program is machine code. */
bool program_native(const struct program *program);
/* Returns the number of operations, where a product and the sum that it enters count as one. */
int program_operations(const struct program *program);
/* Returns true, with *value set, if the output does not depend on any input. */
bool program_constant(const struct program *program, int output, double *value);
/* Returns true if any of `count` outputs from `first` depends on the name, in the form in which
 * they are written. */
bool program_depends(const struct program *program, int first, int count, int name);

/* Returns the number of doubles of a frame, the work memory of the program. A frame is used by one
 * thread at a time. */
size_t program_frame(const struct program *program);
/* Initialises a frame before the first program_eval() with it; does nothing for machine code. */
void program_prepare(const struct program *program, double *frame);
/* Computes output [count] from input [names], in which the values of replaced names are ignored;
 * frame [program_frame()] is work memory. `input` may be the frame itself; `output` must not
 * overlap `input`. Returns output[0]. Never allocates. */
double program_eval(const struct program *program, const double *input, double *output,
                    double *frame);

/* The first two outputs of a program. */
struct leading {
    double first, second;
};
/* The function of a program, for kernels that call it directly. The names have the numbers 0 (t), 1
 * to n (state variables) and above (parameters of a typed term). x0, x1 and x2 are the values of
 * names 0, 1 and 2, which are passed in registers instead of an array. `state` is the array of the
 * state, where state[i - 1] is name i, from which further state variables are read; `steady` is the
 * array of the parameters. Outputs 0 and 1 are returned in registers (output 1 is arbitrary if
 * there is only one), further ones are stored in `output`. Arrays that are not used may be NULL. */
typedef struct leading program_function(const struct program *program, double x0, double x1,
                                        double x2, const double *state, const double *steady,
                                        double *output, double *frame);
/* Returns the function of the program: machine code, or one that interprets its operations. */
program_function *program_code(const struct program *program);

/* A comparison, as in `run until y < 1 cm`: left < right if `less`, else left > right; with
 * or_equal, <= or >=. */
struct condition {
    const struct expr *left, *right;
    bool less, or_equal;
};

/* Compiles the comparison at the start of `text` and sets *used to its length [byte]; its memory is
 * the arena's. Returns false with `error` set. */
bool condition_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                       struct condition *condition, size_t *used, struct error *error);
/* Returns left - right if `less`, else right - left. The condition is true where this is < 0, or <=
 * 0 with or_equal. */
double condition_value(const struct condition *condition, const struct expr_scope *scope);
/* Returns true if the condition is true for `value`, a result of condition_value(). */
bool condition_holds(const struct condition *condition, double value);
