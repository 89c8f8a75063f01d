/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Prices of evaluations: the operators and functions in the text of the forces are counted.
 * Built-in terms have that text in their rows, typed ones in their lines. The constants were
 * measured, see price.c. */
#include "run/price/evaluation.h"

#include <hooke/scene/typed.h>

#include <ctype.h>

/* Instructions for an operator in a built-in term, whose constants are computed beforehand; for one
 * in an interpreted program; and for a function such as sin or exp. */
static const double per_operator = 1.2, per_operator_typed = 6, per_function = 95;

/* Returns true for functions that are one instruction or a few. */
static bool is_cheap(struct text name)
{
    static const char *const cheap[] = {"abs", "sign", "sqrt", "hypot", "min", "max", "if"};
    for (size_t i = 0; i < COUNT_OF(cheap); i++)
        if (text_is(name, cheap[i]))
            return true;
    return false;
}

/* Returns the price of evaluating an expression, by its text, if an operator has the price
 * an_operator. */
static double text_price(struct text text, double an_operator)
{
    double price = 0;
    for (size_t i = 0; i < text.len; i++) {
        const char c = text.data[i];
        if (c == '+' || c == '-' || c == '*' || c == '/' || c == '^')
            price += an_operator;
        size_t begin = i;
        while (c == '(' && begin > 0 && isalnum((unsigned char)text.data[begin - 1]))
            begin--;
        if (begin < i)
            price +=
                is_cheap((struct text){text.data + begin, i - begin}) ? an_operator : per_function;
    }
    return price;
}

/* Returns the price of all typed equations and forces; 0 for other scenes. A potential is
 * differentiated, which doubles its price. */
static double typed_price(const struct model *model)
{
    double price = 0;
    for (int i = 0; i < typed_lines(model); i++) {
        const struct typed_line *line = typed_line(model, i);
        if (line->kind == TYPED_EQUATION || line->kind == TYPED_FORCE)
            price += text_price(line->expr, per_operator_typed);
        else if (line->kind == TYPED_POTENTIAL)
            price += 2 * text_price(line->expr, per_operator_typed);
    }
    return price;
}

/* Adds up the prices of all formulas of the system. */
double evaluation_price(const struct system *system)
{
    double price = typed_price(system->model);
    for (int i = 0; i < system->terms; i++)
        for (int k = 0; k < LIMIT_MODEL_ROWS; k++) {
            const char *equation = system->term[i].row->equation[k];
            price += equation ? text_price(text_of(equation), per_operator) : 0;
        }
    return price;
}

double evaluation_price_called(const struct system *system)
{
    static const double call = 60, a_term = 40, a_program = 70;
    return call + a_term * system->terms + evaluation_price(system) +
           (typed_lines(system->model) > 0 ? a_program : 0);
}

/* Chooses constants by the kind of the method; they were measured for each. */
double solver_evaluation_price(const struct system *system, const struct method *method,
                               bool adaptive)
{
    const double n = system->n, forces = evaluation_price(system);
    if (method->rosenbrock && method_step_kernel(method, system))
        return 15 + 70 * n + forces;
    if (method->flags & METHOD_IMPLICIT)
        return 270 + 150 * n + 25 * n * n + forces;
    if (adaptive && method_controlled_kernel(method, system))
        return 50 + 18 * n + forces;
    return adaptive ? 140 + 15 * n + forces : 60 + 8 * n + forces;
}

double exact_state_price(const struct system *system)
{
    static const double linear = 3800, driven = 8800, own = 7300;
    if (system->model->exact)
        return own;
    return system->autonomous ? linear : driven;
}
