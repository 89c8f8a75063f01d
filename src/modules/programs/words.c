/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The words of the templates: numbers, names and formulas of a scene, tables of a method. An empty
 * text removes the line of a template that consists of it. Functions append to p->output. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "modules/programs/program.h"

#include <math.h>
#include <string.h>

/* Returns the unit of state variable i. */
static const char *variable_unit(const struct scene_program *p, int i)
{
    return quantity_unit(p->written.system.model->variable[i].quantity);
}

/* Appends numbers separated by commas. */
static void put_list(struct scene_program *p, const double *value, int count)
{
    for (int i = 0; i < count; i++) {
        buffer_put(p->output, i ? TEXT(", ") : TEXT(""));
        buffer_real(p->output, value[i]);
    }
}

/* ---- the scene ---- */

/* Appends the description of the program as a comment. */
static void put_title(struct scene_program *p)
{
    const char *comment;
    if (p->dialect == DIALECT_C)
        comment = " * ";
    else
        comment = p->dialect == DIALECT_PYTHON ? "# " : "% ";
    program_title(p, comment);
}

/* Appends a comment with unit and explanation, if there are any. */
static void put_comment(struct scene_program *p, const char *unit, const char *brief)
{
    const bool c = p->dialect == DIALECT_C;
    if (!unit[0] && !brief[0])
        return;
    if (c)
        buffer_put(p->output, TEXT(" /* "));
    else
        buffer_put(p->output, p->dialect == DIALECT_PYTHON ? TEXT("  # ") : TEXT("  % "));
    if (unit[0])
        buffer_format(p->output, "[%s]%s", unit, brief[0] ? " " : "");
    buffer_format(p->output, "%s%s", brief, c ? " */" : "");
}

/* Returns the sign that ends a statement. */
static const char *statement_terminator(const struct scene_program *p)
{
    return p->dialect == DIALECT_PYTHON ? "" : ";";
}

/* Appends the definitions of the parameters that are used. */
static void put_constants(struct scene_program *p)
{
    const struct written *w = &p->written;
    for (int i = w->params, count = 0; i < w->observed; i++) {
        const struct param_row *row = param_at(p->scene, i - w->params);
        const bool typed = strcmp(row->row.brief, "typed by the user") == 0;
        if (!program_reads(p, i))
            continue;
        const char *const type = p->dialect == DIALECT_C ? "static const double " : "";
        buffer_format(p->output, "%s%s%s = ", count++ ? "\n" : "", type, p->name[i]);
        buffer_real(p->output, p->scene->value[i - w->params]);
        buffer_put(p->output, text_of(statement_terminator(p)));
        put_comment(p, row->row.unit, typed ? "" : row->row.brief);
    }
}

/* Appends the names of the state variables. */
static void put_variables(struct scene_program *p)
{
    for (int i = 0; i < program_n(p); i++)
        buffer_format(p->output, "%s%s", i ? ", " : "", p->written.name[1 + i]);
}

/* Appends the heading of the CSV that the program prints. */
static void program_heading_put(struct scene_program *p)
{
    for (int i = 0; i < 1 + program_n(p); i++)
        buffer_format(p->output, "%s%s", i ? "," : "", p->written.name[i]);
}

/* Appends the format of a row for printf(). */
static void put_format(struct scene_program *p)
{
    for (int i = 0; i < 1 + program_n(p); i++)
        buffer_put(p->output, i ? TEXT(",%.17g") : TEXT("%.17g"));
}

/* Appends the label of an axis for the first variable. */
static void put_label(struct scene_program *p)
{
    const char *unit = variable_unit(p, 0);
    buffer_put(p->output, text_of(p->written.name[1]));
    if (unit[0])
        buffer_format(p->output, " [%s]", unit);
}

/* Appends the initial state. */
static void program_start_put(struct scene_program *p)
{
    for (int i = 0; i < program_n(p); i++) {
        struct text separator;
        if (!i)
            separator = TEXT("");
        else
            separator = p->dialect == DIALECT_OCTAVE ? TEXT("; ") : TEXT(", ");
        buffer_put(p->output, separator);
        buffer_real(p->output, p->written.system.start[i]);
    }
}

/* Appends the statements that assign the elements of the array `state` to the variables' names; in
 * C only for those that are read, and a statement that marks t as unused where nothing depends on
 * it. */
static void put_unpack(struct scene_program *p)
{
    const bool c = p->dialect == DIALECT_C;
    for (int i = 0; !c && i < program_n(p); i++)
        buffer_format(p->output, "%s%s", i ? ", " : "    ", program_state(p, i));
    if (!c)
        buffer_put(p->output, program_n(p) == 1 ? TEXT(", = state") : TEXT(" = state"));
    for (int i = 0, count = 0; c && i < program_n(p); i++) {
        if (!program_reads(p, 1 + i))
            continue;
        buffer_format(p->output, "%s    const double %s = state[%d];", count++ ? "\n" : "",
                      program_state(p, i), i);
        put_comment(p, variable_unit(p, i), "");
    }
    if (c && !program_reads(p, 0))
        buffer_format(p->output, "%s    (void)t; /* nothing depends on the time */",
                      p->output->data[p->output->len - 1] == ';' ||
                              p->output->data[p->output->len - 1] == '/'
                          ? "\n"
                          : "");
}

/* Returns true if drag is solved exactly by a function of its own, apart from the other forces. */
static bool takes_drag_apart(const struct scene_program *p)
{
    return p->method->splitting && p->written.system.velocity && p->drag == DRAG_EXACT;
}

/* Appends the functions of Python's module math that the formulas call. */
static void put_imports(struct scene_program *p)
{
    static const char *const functions[] = {"acos", "asin", "atan",  "atan2", "ceil", "cos",
                                            "cosh", "exp",  "floor", "hypot", "log",  "log10",
                                            "pow",  "sin",  "sinh",  "sqrt",  "tan",  "tanh"};
    int count = 0;
    for (size_t i = 0; i < COUNT_OF(functions); i++)
        if (program_uses(p, functions[i], '('))
            buffer_format(p->output, "%s%s", count++ ? ", " : "", functions[i]);
    if (program_uses(p, "pi", '\0'))
        buffer_format(p->output, "%spi", count ? ", " : "");
}

/* ---- the run ---- */

/* Appends the absolute tolerances of all variables. */
static void put_absolute(struct scene_program *p)
{
    const struct system *system = &p->written.system;
    double value[LIMIT_VARIABLES];
    for (int i = 0; i < system->n; i++)
        value[i] = system->atol[i] > 0 ? system->atol[i] : p->settings.tol * system->scale[i];
    put_list(p, value, system->n);
}

/* Appends the natural sizes of all variables. */
static void put_sizes(struct scene_program *p)
{
    put_list(p, p->written.system.scale, program_n(p));
}

/* ---- the method ---- */

/* Returns true, and the table, if the program contains the method's Butcher table; libraries have
 * their own. */
static bool has_table(const struct scene_program *p, struct runge_kutta *table)
{
    const bool library = p->plan.adaptive && p->dialect != DIALECT_C;
    return !library && method_runge_kutta(p->method, table) && table->stages > 1;
}

/* Finds the fraction *top / *bottom with the smallest denominator, at most a million, that equals x
 * as a double, by the continued fraction of x. Returns false, with both unchanged, if there is
 * none. */
static bool fraction_of(double x, long *top, long *bottom)
{
    long p0 = 0, q0 = 1, p1 = 1, q1 = 0;
    double rest = fabs(x);
    for (int i = 0; i < 20; i++) {
        const double whole = floor(rest);
        const long p2 = (long)whole * p1 + p0, q2 = (long)whole * q1 + q0;
        if (whole > 1e6 || p2 > 1000000 || q2 > 1000000)
            return false;
        if ((double)p2 / (double)q2 == fabs(x)) {
            *top = x < 0 ? -p2 : p2;
            *bottom = q2;
            return true;
        }
        p0 = p1, q0 = q1, p1 = p2, q1 = q2;
        rest = 1 / (rest - whole);
    }
    return false;
}

/* Appends `count` weights separated by commas, as fractions such as 35/384 where these are the same
 * doubles and the decimal is not short, in lines of little more than line_max characters. */
static void put_weights_of(struct scene_program *p, const double *weight, int count)
{
    enum { SHORT_DECIMAL = 4 }; /* characters of decimals that need no fraction, such as 0.25 */
    static const size_t line_max = 64;
    size_t start = p->output->len;
    for (int i = 0; i < count; i++) {
        char decimal[REAL_TEXT_SIZE];
        long top, bottom;
        const bool wraps = p->output->len - start > line_max;
        struct text separator;
        if (!i)
            separator = TEXT("");
        else if (!wraps)
            separator = TEXT(", ");
        else
            separator = p->dialect == DIALECT_OCTAVE ? TEXT(", ...\n    ") : TEXT(",\n    ");
        buffer_put(p->output, separator);
        start = wraps ? p->output->len : start;
        if (real_format(weight[i], decimal) <= SHORT_DECIMAL ||
            !fraction_of(weight[i], &top, &bottom))
            buffer_put(p->output, text_of(decimal));
        else
            buffer_format(p->output, "%ld%s/%ld", top, p->dialect == DIALECT_C ? ".0" : "", bottom);
    }
}

/* Appends the nodes c of the Butcher table. */
static void put_nodes(struct scene_program *p)
{
    struct runge_kutta table;
    if (has_table(p, &table))
        put_weights_of(p, table.c, table.stages);
}

/* Appends the matrix a of the Butcher table row by row; in Octave as a full square matrix. Appends
 * nothing if the method has no table. */
static void put_matrix(struct scene_program *p)
{
    static const double zero[64] = {0};
    struct runge_kutta table;
    const bool c = p->dialect == DIALECT_C, octave = p->dialect == DIALECT_OCTAVE;
    if (!has_table(p, &table))
        return;
    for (int s = 0; s < table.stages; s++) {
        const char *opening;
        if (c)
            opening = "{";
        else
            opening = octave ? "" : "[";
        buffer_format(p->output, "%s    %s", s ? "\n" : "", opening);
        put_weights_of(p, table.a + s * (s - 1) / 2, s);
        if (octave) {
            buffer_put(p->output, s ? TEXT(", ") : TEXT(""));
            put_weights_of(p, zero, table.stages - s);
        }
        struct text closing;
        if (c && s == 0)
            closing = TEXT("0},");
        else if (c)
            closing = TEXT("},");
        else
            closing = octave ? TEXT("") : TEXT("],");
        buffer_put(p->output, closing);
    }
}

/* Appends the weights of the Butcher table or of a splitting. */
static void put_weights(struct scene_program *p)
{
    struct runge_kutta table;
    double weight[SPLITTING_WEIGHTS];
    bool kick;
    const int count = method_splitting(p->method, weight, &kick);
    if (has_table(p, &table))
        put_weights_of(p, table.b, table.stages);
    else
        put_weights_of(p, weight, count);
}

/* Appends the weights of the embedded method. */
static void put_weights_low(struct scene_program *p)
{
    struct runge_kutta table;
    if (has_table(p, &table))
        put_weights_of(p, table.b_hat, table.stages);
}

/* ---- all ---- */

/* Returns the library function that makes adaptive steps in Python or Octave. */
static const char *solver_name(const struct scene_program *p)
{
    const int order = p->method->order;
    const bool python = p->dialect == DIALECT_PYTHON;
    if (p->method->flags & METHOD_IMPLICIT)
        return python ? "Radau" : "ode15s";
    if (!python)
        return "ode45";
    if (order <= 3)
        return "RK23";
    return order >= 7 ? "DOP853" : "RK45";
}

/* Appends the value of a template's word that is a number; a word that is a condition is itself
 * appended if the condition holds, else nothing. Returns false if there is no such word. */
static bool program_value_put(struct scene_program *p, struct text word)
{
    const double t0 = p->written.system.t0, t_end = t0 + p->duration, dt = p->settings.dt;
    const struct oscillator *o = &p->written.system.oscillator;
    const bool fixed = !p->plan.adaptive, partial = fixed && p->plan.partial != 0;
    const bool rows = !fixed && p->settings.record.rule == RECORD_TIMES;
    const bool every = !fixed && p->settings.record.rule == RECORD_EVERY;
    const int n = program_n(p);
    struct runge_kutta table = {0};
    double weight[SPLITTING_WEIGHTS], most;
    int order = 1;
    bool kick;
    const int parts = method_splitting(p->method, weight, &kick);
    const bool tables = has_table(p, &table);
    const bool euler = fixed && method_runge_kutta(p->method, &table) && table.stages == 1;
    method_error_control(p->method, p->settings.tol, &most, &order);
    const struct {
        const char *name;
        bool holds;
    } conditions[] = {{"fixed", fixed},
                      {"adaptive", !fixed},
                      {"partial", partial},
                      {"ends", partial || t0 + (double)p->plan.whole * dt != t_end},
                      {"turns", p->turns},
                      {"flow", takes_drag_apart(p)},
                      /* Python raises where a function has no finite number */
                      {"raises", strpbrk(p->rates, "(%") || strpbrk(p->observed, "(%")},
                      {"euler", euler},
                      {"tables", tables},
                      {"split", parts > 0},
                      {"implicit", fixed && method_is_backward_euler(p->method)}};
    const struct {
        const char *name;
        double value;
    } numbers[] = {{"n", n},
                   {"half", n / 2},
                   {"columns", n + 1},
                   {"t0", t0},
                   {"dt", dt},
                   {"t_end", t_end},
                   {"tol", p->settings.tol},
                   {"interval", p->settings.record.interval},
                   {"every", (double)p->settings.record.every},
                   {"stages", table.stages},
                   {"order", order},
                   {"count", parts},
                   {"kick", !kick},
                   {"damping", o->damping},
                   {"quadratic", o->quadratic}};
    for (size_t i = 0; i < COUNT_OF(conditions); i++)
        if (text_is(word, conditions[i].name)) {
            buffer_put(p->output, conditions[i].holds ? word : TEXT(""));
            return true;
        }
    for (size_t i = 0; i < COUNT_OF(numbers); i++)
        if (text_is(word, numbers[i].name)) {
            if (text_is(word, "interval") ? rows : !text_is(word, "every") || every)
                buffer_real(p->output, numbers[i].value);
            return true;
        }
    if (text_is(word, "steps"))
        buffer_format(p->output, "%lld", (long long)p->plan.whole + partial);
    return text_is(word, "steps");
}

/* Appends the text of a template's word whose text needs no function. Returns false if there is no
 * such word. */
static bool program_text_put(struct scene_program *p, struct text word)
{
    const bool partial = !p->plan.adaptive && p->plan.partial != 0;
    const struct {
        const char *name, *text;
    } texts[] = {
        {"method", p->method->row.name},
        {"solver", solver_name(p)},
        {"rates", p->rates},
        {"observed", p->observed},
        {"step", p->turns ? "turning_step" : "step"},
        {"length", partial ? "h" : "dt"},
        {"at_times", p->settings.record.rule == RECORD_TIMES ? ", t_eval=times" : ""},
        {"without_drag", takes_drag_apart(p) ? " without drag, which drag_flow() knows" : ""}};
    for (size_t i = 0; i < COUNT_OF(texts); i++)
        if (text_is(word, texts[i].name)) {
            buffer_put(p->output, text_of(texts[i].text));
            return true;
        }
    return false;
}

/* Appends what a word of a template denotes. Returns false if there is no such word. */
bool program_word(struct scene_program *p, struct text word)
{
    static const struct {
        const char *name;
        void (*put)(struct scene_program *p);
    } words[] = {{"title", put_title},
                 {"constants", put_constants},
                 {"variables", put_variables},
                 {"heading", program_heading_put},
                 {"format", put_format},
                 {"label", put_label},
                 {"start", program_start_put},
                 {"unpack", put_unpack},
                 {"imports", put_imports},
                 {"absolute", put_absolute},
                 {"sizes", put_sizes},
                 {"nodes", put_nodes},
                 {"matrix", put_matrix},
                 {"weights", put_weights},
                 {"weights_low", put_weights_low}};
    if (program_text_put(p, word) || program_value_put(p, word))
        return true;
    for (size_t i = 0; i < COUNT_OF(words); i++)
        if (text_is(word, words[i].name)) {
            words[i].put(p);
            return true;
        }
    return false;
}
