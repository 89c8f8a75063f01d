/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes expressions as text of other languages. Signs are moved out of products, which changes no
 * bit: -k/m*y is written as -(k/m*y), and after a sum as a - b. */
#include <stdlib.h>
#include <string.h>

#include <hooke/base/catalog.h>
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include "modules/programs/compute/written.h"
#include "scene/formula/program/program.h"

static const struct row dialects[] = {
    [DIALECT_C] = {"c", "", "a program in C", "ISO/IEC 9899:2011", NULL},
    [DIALECT_PYTHON] = {"py", "", "a program in Python", "", NULL},
    [DIALECT_OCTAVE] = {"m", "", "a program for Octave and MATLAB", "", NULL},
    [DIALECT_XPP] = {"ode", "", "a scene for XPPAUT", "Ermentrout 2002", NULL},
    [DIALECT_TEX] = {"tex", "", "the equations as LaTeX", "", NULL},
};

const struct catalog dialect_catalog = CATALOG("kind of program", dialects);

/* ---- words ---- */

/* Forms of functions, in the order of `dialects` separated by ~, in which $1, $2, $3 are arguments.
 * An empty form is a call by the function's own name; so are functions without a row. */
static const struct {
    const char *name, *forms;
} calls[] = {
    {"sin", "~~~~\\sin\\left($1\\right)"},
    {"cos", "~~~~\\cos\\left($1\\right)"},
    {"tan", "~~~~\\tan\\left($1\\right)"},
    {"asin", "~~~~\\arcsin\\left($1\\right)"},
    {"acos", "~~~~\\arccos\\left($1\\right)"},
    {"atan", "~~~~\\arctan\\left($1\\right)"},
    {"sinh", "~~~~\\sinh\\left($1\\right)"},
    {"cosh", "~~~~\\cosh\\left($1\\right)"},
    {"tanh", "~~~~\\tanh\\left($1\\right)"},
    {"exp", "~~~~\\exp\\left($1\\right)"},
    {"log10", "~~~~\\log_{10}\\left($1\\right)"},
    {"log", "~~~ln($1)~\\ln\\left($1\\right)"},
    {"sqrt", "~~~~\\sqrt{$1}"},
    {"abs", "fabs($1)~~~~\\left|$1\\right|"},
    {"sign", "~~~~\\operatorname{sgn}\\left($1\\right)"},
    {"step", "heaviside($1)~heaviside($1)~double(($1) >= 0)~heav($1)~\\theta\\left($1\\right)"},
    {"floor", "~~~flr($1)~\\left\\lfloor $1\\right\\rfloor"},
    {"ceil", "~~~(-flr(-($1)))~\\left\\lceil $1\\right\\rceil"},
    {"round",
     "~round_half($1)~~(sign($1)*flr(abs($1)+0.5))~\\operatorname{round}\\left($1\\right)"},
    {"cbrt", "~~nthroot($1, 3)~(sign($1)*abs($1)^(1/3))~\\sqrt[3]{$1}"},
    {"atan2", "~~~atan2($1,$2)~\\operatorname{atan2}\\left($1, $2\\right)"},
    {"hypot", "~~~sqrt(($1)^2+($2)^2)~\\sqrt{\\left($1\\right)^2 + \\left($2\\right)^2}"},
    {"min", "fmin($1, $2)~~~min($1,$2)~\\min\\left($1, $2\\right)"},
    {"max", "fmax($1, $2)~~~max($1,$2)~\\max\\left($1, $2\\right)"},
    {"mod", "~($1 % ($2))~~mod($1,$2)~\\left($1\\bmod $2\\right)"},
    {"if", "(($1) > 0 ? $2 : $3)~($2 if $1 > 0 else $3)~choose($1, $2, $3)~"
           "(if(($1)>0)then($2)else($3))~"
           "\\begin{cases} $2 & \\text{if } $1 \\\\ $3 & \\text{else} \\end{cases}"},
};

static const char *const pi_word[DIALECTS] = {"3.141592653589793", "pi", "pi", "pi", "\\pi"};

/* Appends a number so that the language reads the same double: pi by name, in TeX as a product with
 * a power of ten, and large integers of C and Python with ".0", as these are divided by other
 * rules. */
void dialect_number(struct buffer *output, enum dialect dialect, double number)
{
    char z[REAL_TEXT_SIZE];
    const size_t len = real_format(number, z), digits = strcspn(z, "e");
    const bool whole = !memchr(z, '.', digits);
    if (number == 3.14159265358979323846) {
        buffer_put(output, text_of(pi_word[dialect]));
    } else if (dialect == DIALECT_TEX && digits < len) {
        const char *power = z + digits + 1 + (z[digits + 1] == '+');
        if (digits > 1 || z[0] != '1')
            buffer_format(output, "%.*s \\cdot ", (int)digits, z);
        buffer_format(output, "10^{%s}", power);
    } else {
        buffer_put(output, text_of(z));
        /* integers of Python and C are divided by other rules */
        if (whole && digits == len && fabs(number) >= 1e9 && isfinite(number) &&
            (dialect == DIALECT_C || dialect == DIALECT_PYTHON))
            buffer_put(output, TEXT(".0"));
    }
}

/* ---- parts of an expression ---- */

/* Operations by how tightly they bind, loosest first. */
enum { COMPARISON, SUM, PRODUCT, FACTOR, ATOM };

/* Ways in which an operand can be 0: the number 0, a name whose value is 0, or a product with such
 * a factor, which is left out. They are used to leave out of sums and products what hooke leaves
 * out when it evaluates the formula. */
enum zero_kind { NOT_ZERO, NUMBER_ZERO, NAME_ZERO, TERM_ZERO };

/* An operand as text. A minus sign in front of it is `negative` and not part of the text. */
struct piece {
    struct text text;
    int binds; /* strength with which its last operation binds */
    bool negative;
    enum zero_kind zero;
    bool number; /* it is a number, `value` */
    double value;
};

/* State of writing an expression, as on a stack machine. */
struct printer {
    struct arena arena;
    enum dialect dialect;
    const char *const *name;
    const bool *zero;
    bool failed; /* set if out of memory */
    struct piece stack[LIMIT_EXPR_DEPTH + 1];
};

/* Moves a buffer's text to the arena. Returns "" and sets p->failed if out of memory. */
static struct text printed_text_keep(struct printer *p, struct buffer *buffer)
{
    const char *text = buffer->failed ? NULL : arena_text(&p->arena, buffer_text(buffer));
    buffer_free(buffer);
    p->failed |= !text;
    return text_of(text ? text : "");
}

/* Appends an operand with its sign, in parentheses if it binds less tightly than `binds`, the
 * precedence that its place in the formula needs (SUM to ATOM). */
static void put_piece(struct printer *p, struct buffer *output, const struct piece *piece,
                      int binds)
{
    const bool enclosed = piece->binds < binds || (piece->negative && binds > SUM);
    const bool signs = piece->negative && piece->binds == SUM;
    const bool tex = p->dialect == DIALECT_TEX;
    const struct text opening = tex ? TEXT("\\left(") : TEXT("(");
    const struct text closing = tex ? TEXT("\\right)") : TEXT(")");
    buffer_put(output, enclosed ? opening : TEXT(""));
    buffer_put(output, piece->negative ? TEXT("-") : TEXT(""));
    buffer_put(output, signs ? opening : TEXT(""));
    buffer_put(output, piece->text);
    buffer_put(output, signs ? closing : TEXT(""));
    buffer_put(output, enclosed ? closing : TEXT(""));
}

/* Returns the operand 0 that a product with 0 leaves. */
static struct piece zero_piece(void)
{
    return (struct piece){
        .text = TEXT("0"), .binds = ATOM, .zero = TERM_ZERO, .number = true, .value = 0};
}

/* Returns the number `value` as an operand in the printer's language: its digits without sign (kept
 * by the printer), how tightly it binds (a TeX power of ten is a product), its sign and whether it
 * is 0. */
static struct piece number_piece(struct printer *p, double value)
{
    struct buffer text = {0};
    dialect_number(&text, p->dialect, fabs(value));
    const bool scaled =
        p->dialect == DIALECT_TEX && memchr(text.data ? text.data : "", '\\', text.len);
    const bool pi = value == 3.14159265358979323846;
    const enum zero_kind zero = value == 0 ? NUMBER_ZERO : NOT_ZERO;
    return (struct piece){.text = printed_text_keep(p, &text),
                          .binds = scaled && !pi ? PRODUCT : ATOM,
                          .negative = signbit(value) != 0,
                          .zero = zero,
                          .number = true,
                          .value = value};
}

/* ---- operations ---- */

/* Returns a + b, or a - b if `minus`; operands that are 0 are left out. */
static struct piece sum_of(struct printer *p, const struct piece *a, struct piece b, bool minus)
{
    if (b.zero)
        return *a;
    b.negative ^= minus;
    if (a->zero)
        return b;
    struct buffer text = {0};
    put_piece(p, &text, a, SUM);
    buffer_put(&text, b.negative ? TEXT(" - ") : TEXT(" + "));
    b.negative = false;
    put_piece(p, &text, &b, PRODUCT);
    return (struct piece){.text = printed_text_keep(p, &text),
                          .binds = SUM,
                          .zero = a->zero < b.zero ? a->zero : b.zero};
}

/* Returns a*b, or a/b if is_quotient. A product with 0 is 0, as is a quotient whose numerator is a
 * parameter or term that is 0; a written number 0 is divided. */
static struct piece product_of(struct printer *p, struct piece a, struct piece b, bool is_quotient)
{
    if (is_quotient ? a.zero >= NAME_ZERO : a.zero || b.zero)
        return zero_piece();
    const bool negative = a.negative != b.negative, tex = p->dialect == DIALECT_TEX;
    a.negative = b.negative = false;
    struct buffer text = {0};
    if (tex && is_quotient) {
        buffer_format(&text, "\\frac{%.*s}{%.*s}", (int)a.text.len, a.text.data, (int)b.text.len,
                      b.text.data);
    } else {
        put_piece(p, &text, &a, PRODUCT);
        struct text sign;
        if (is_quotient)
            sign = TEXT("/");
        else if (!tex)
            sign = TEXT("*");
        else
            sign = b.number ? TEXT(" \\cdot ") : TEXT(" ");
        buffer_put(&text, sign);
        put_piece(p, &text, &b, tex ? PRODUCT : FACTOR);
    }
    return (struct piece){.text = printed_text_keep(p, &text),
                          .binds = tex && is_quotient ? FACTOR : PRODUCT,
                          .negative = negative};
}

/* Returns true if the text is a name. */
static bool text_is_word(struct text text)
{
    for (size_t i = 0; i < text.len; i++)
        if (!is_name_char(text.data[i]))
            return false;
    return text.len > 0;
}

/* Returns x^n: in C and Python as a product or by power() for small n, which gives the same bits as
 * hooke, otherwise by pow(); in other languages by an operator. */
static struct piece power_of(struct printer *p, const struct piece *x, const struct piece *n)
{
    struct buffer text = {0};
    int binds = ATOM;
    const bool computes = p->dialect == DIALECT_C || p->dialect == DIALECT_PYTHON;
    const bool brief = n->number && power_is_short(n->value);
    if (n->number && n->value == 0.5 && p->dialect != DIALECT_TEX) {
        buffer_put(&text, TEXT("sqrt("));
        put_piece(p, &text, x, SUM);
        buffer_char(&text, ')');
    } else if (computes && brief && text_is_word(x->text) && !x->negative &&
               (n->value == 2 || n->value == 3)) {
        for (int i = 0; i < (int)n->value; i++)
            buffer_format(&text, "%s%.*s", i ? "*" : "", (int)x->text.len, x->text.data);
        binds = PRODUCT;
    } else if (computes) {
        buffer_put(&text, brief ? TEXT("power(") : TEXT("pow("));
        put_piece(p, &text, x, SUM);
        buffer_put(&text, TEXT(", "));
        put_piece(p, &text, n, SUM);
        buffer_char(&text, ')');
    } else {
        const bool tex = p->dialect == DIALECT_TEX;
        put_piece(p, &text, x, ATOM);
        buffer_put(&text, tex ? TEXT("^{") : TEXT("^"));
        put_piece(p, &text, n, tex ? SUM : ATOM);
        buffer_put(&text, tex ? TEXT("}") : TEXT(""));
        binds = FACTOR;
    }
    return (struct piece){.text = printed_text_keep(p, &text), .binds = binds};
}

/* Returns the operand for "a kind b", a comparison with the value 1 or 0, in the printer's
 * language: in parentheses and, in C, converted to double. */
static struct piece comparison_of(struct printer *p, enum op_kind kind, const struct piece *a,
                                  const struct piece *b)
{
    static const char *const tex[] = {[OP_LESS] = " < ",
                                      [OP_GREATER] = " > ",
                                      [OP_LESS_EQUAL] = " \\le ",
                                      [OP_GREATER_EQUAL] = " \\ge "};
    static const char *const sign[] = {[OP_LESS] = " < ",
                                       [OP_GREATER] = " > ",
                                       [OP_LESS_EQUAL] = " <= ",
                                       [OP_GREATER_EQUAL] = " >= "};
    struct buffer text = {0};
    const bool c = p->dialect == DIALECT_C;
    buffer_put(&text, c ? TEXT("(double)(") : TEXT("("));
    put_piece(p, &text, a, SUM);
    buffer_put(&text, text_of((p->dialect == DIALECT_TEX ? tex : sign)[kind]));
    put_piece(p, &text, b, SUM);
    buffer_char(&text, ')');
    return (struct piece){.text = printed_text_keep(p, &text), .binds = c ? FACTOR : ATOM};
}

/* Returns the form of a function, empty for a call by its own name. */
static struct text form_of(struct text name, enum dialect dialect)
{
    struct text form = {0}, forms = {0};
    for (size_t i = 0; i < COUNT_OF(calls); i++)
        if (text_is(name, calls[i].name))
            forms = text_of(calls[i].forms);
    for (int i = 0; i <= (int)dialect; i++)
        if (!text_split(&forms, '~', &form))
            return (struct text){0};
    return form;
}

/* Returns a call of a function on its operands, in the form that the language has for it ($1, $2
 * denote operands), or by the function's name if it has none. */
static struct piece call_of(struct printer *p, const struct function *function,
                            const struct piece *operand)
{
    const struct text name = text_of(function->row.name), form = form_of(name, p->dialect);
    if (function->two == function_power)
        return power_of(p, &operand[0], &operand[1]);
    struct buffer text = {0};
    if (form.len == 0)
        buffer_format(&text, "%s(", function->row.name);
    for (int i = 0; form.len == 0 && i < function_arity(function); i++) {
        buffer_put(&text, i ? TEXT(", ") : TEXT(""));
        put_piece(p, &text, &operand[i], COMPARISON);
    }
    if (form.len == 0)
        buffer_char(&text, ')');
    for (size_t i = 0; i < form.len; i++)
        if (form.data[i] == '$')
            put_piece(p, &text, &operand[form.data[++i] - '1'], COMPARISON);
        else
            buffer_char(&text, form.data[i]);
    return (struct piece){.text = printed_text_keep(p, &text), .binds = ATOM};
}

/* Returns the text of an operation on its operands, as an operand of the next one. A minus sign
 * does not change a product that was left out (TERM_ZERO), because its 0 has no sign in formulas of
 * hooke. */
static struct piece apply_operation(struct printer *p, const struct op *op,
                                    const struct piece *operand)
{
    struct piece a = operand[0];
    switch (op->kind) {
    case OP_NEG:
        a.negative ^= a.zero != TERM_ZERO;
        a.value = -a.value;
        return a;
    case OP_ADD:
    case OP_SUB:
        return sum_of(p, &a, operand[1], op->kind == OP_SUB);
    case OP_MUL:
    case OP_DIV:
        return product_of(p, a, operand[1], op->kind == OP_DIV);
    case OP_POW:
        return power_of(p, &a, &operand[1]);
    case OP_CALL:
        return call_of(p, op->function, operand);
    default:
        return comparison_of(p, op->kind, &a, &operand[1]);
    }
}

/* Appends an expression in a dialect, without products of what is 0. name[slot] is the text of a
 * name and zero[slot], unless zero is NULL, true if its value is 0. Returns false if out of
 * memory. */
bool expr_text(const struct expr *expr, enum dialect dialect, const char *const *name,
               const bool *zero, struct buffer *output)
{
    struct printer *p = calloc(1, sizeof *p);
    if (!p)
        return false;
    p->dialect = dialect;
    int top = 0;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NUMBER) {
            p->stack[top++] = number_piece(p, op->number);
        } else if (op->kind == OP_NAME) {
            p->stack[top] = (struct piece){.text = text_of(name[op->slot]), .binds = ATOM};
            if (zero && zero[op->slot]) {
                p->stack[top] = number_piece(p, 0);
                p->stack[top].zero = NAME_ZERO;
            }
            top++;
        } else {
            top -= op_arity(op);
            p->stack[top] = apply_operation(p, op, &p->stack[top]);
            top++;
        }
    }
    put_piece(p, output, &p->stack[0], COMPARISON);
    const bool fine = !p->failed && !output->failed;
    arena_reset(&p->arena);
    free(p);
    return fine;
}
