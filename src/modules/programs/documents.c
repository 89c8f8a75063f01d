/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes documents that are not programs: scenes for XPPAUT, and equations as LaTeX. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "modules/documents/documents.h"
#include "modules/programs/program.h"

#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

/* Gives name i of the program the text of the buffer, which is freed. Returns false with an error
 * if out of memory. */
static bool set_name(struct scene_program *p, int i, struct buffer *name)
{
    p->name[i] = name->failed ? NULL : arena_text(p->arena, buffer_text(name));
    buffer_free(name);
    return p->name[i] || error_memory(p->error);
}

/* ---- XPPAUT ---- */

/* Appends a number to each name that XPPAUT reserves, or that differs from an earlier one only in
 * case, which XPPAUT ignores. Returns false with an error if out of memory. */
static bool make_names_distinct(struct scene_program *p)
{
    static const char *const own[] = {"t", "pi", "sum", "delay", "shift", "int", "ran", "normal"};
    for (int i = 1; i < p->written.names; i++) {
        bool taken = false;
        for (int k = 1; k < i; k++)
            taken = taken || strcasecmp(p->name[k], p->name[i]) == 0;
        for (size_t k = 0; k < COUNT_OF(own); k++)
            taken = taken || strcasecmp(own[k], p->name[i]) == 0;
        struct buffer name = {0};
        buffer_format(&name, "%s_%d", p->name[i], i);
        if (taken ? !set_name(p, i, &name) : (buffer_free(&name), false))
            return false;
    }
    return true;
}

/* Returns XPPAUT's word for the method, or for the nearest one that it has. */
static const char *xpp_method(const struct scene_program *p)
{
    struct runge_kutta table;
    if (p->plan.adaptive)
        return "5dp";
    if (method_is_backward_euler(p->method))
        return "backeul";
    return method_runge_kutta(p->method, &table) && table.stages == 1 ? "euler" : "rungekutta";
}

/* Appends a line such as "par k=4", for name i. */
static void put_assigned(struct scene_program *p, const char *word, int i, double value)
{
    buffer_format(p->output, "%s %s=", word, p->name[i]);
    buffer_real(p->output, value);
    buffer_char(p->output, '\n');
}

/* Appends observed quantities and right-hand sides in XPPAUT's form, NAME=FORMULA and
 * NAME'=FORMULA. */
static void put_xpp_equations(struct scene_program *p)
{
    const struct written *w = &p->written;
    const int n = program_n(p), positions = n - w->rows;
    for (int i = w->observed; i < w->names; i++) {
        buffer_format(p->output, "%s=", p->name[i]);
        program_expr(p, w->observe[i - w->observed]);
        buffer_char(p->output, '\n');
    }
    for (int i = 0; i < n; i++) {
        buffer_format(p->output, "%s'=", program_state(p, i));
        if (i < positions)
            buffer_put(p->output, text_of(program_state(p, i + positions)));
        else if (w->all[i - positions])
            program_expr(p, w->all[i - positions]);
        else
            buffer_char(p->output, '0');
        buffer_char(p->output, '\n');
    }
}

/* Writes the scene as an .ode file for XPPAUT. Returns false with an error if out of memory. */
bool program_xpp(struct scene_program *p)
{
    const struct written *w = &p->written;
    const struct system *system = &w->system;
    struct buffer *output = p->output;
    if (!make_names_distinct(p))
        return false;
    put_xpp_equations(p);
    p->rates = program_take_text(p);
    program_title(p, "# ");
    buffer_format(output, "\n%s", p->rates);
    for (int i = w->params; i < w->observed; i++)
        if (program_reads(p, i))
            put_assigned(p, "par", i, p->scene->value[i - w->params]);
    for (int i = 0; i < system->n; i++)
        put_assigned(p, "init", 1 + i, system->start[i]);
    buffer_format(output, "@ meth=%s, dt=", xpp_method(p));
    buffer_real(output, p->settings.dt);
    buffer_put(output, TEXT(", total="));
    buffer_real(output, p->duration);
    buffer_put(output, TEXT(", t0="));
    buffer_real(output, system->t0);
    if (p->plan.adaptive) {
        buffer_put(output, TEXT(", toler="));
        buffer_real(output, p->settings.tol);
        buffer_put(output, TEXT(", atoler="));
        buffer_real(output, p->settings.tol * system->scale[0]);
    }
    buffer_format(output, "\n@ maxstor=%lld, bounds=1e12, xp=t, yp=%s\ndone\n",
                  (long long)(p->plan.adaptive ? 100000 : p->plan.whole + 10), program_state(p, 0));
    return true;
}

/* ---- LaTeX ---- */

/* Appends a name as a TeX symbol: "k3" as k_{3}, "omega" as the Greek letter, "length" upright. */
static void put_symbol(struct buffer *output, const char *name)
{
    static const char *const greek[] = {
        "alpha", "beta",  "gamma", "delta",  "epsilon", "zeta", "eta", "theta", "kappa", "lambda",
        "mu",    "nu",    "xi",    "rho",    "sigma",   "tau",  "phi", "chi",   "psi",   "omega",
        "Gamma", "Delta", "Theta", "Lambda", "Sigma",   "Phi",  "Psi", "Omega"};
    size_t len = strcspn(name, "_");
    if (name[len] == '\0')
        while (len > 1 && isdigit((unsigned char)name[len - 1]))
            len--;
    const struct text stem = {name, len};
    bool letter = false;
    for (size_t i = 0; i < COUNT_OF(greek); i++)
        letter = letter || text_is(stem, greek[i]);
    if (letter)
        buffer_char(output, '\\');
    buffer_format(output, !letter && len > 1 ? "\\mathrm{%.*s}" : "%.*s", (int)len, name);
    name += len + (name[len] == '_');
    if (*name == '\0')
        return;
    buffer_put(output, TEXT("_{"));
    for (; *name; name++)
        buffer_put(output, *name == '_' ? TEXT("\\_") : (struct text){name, 1});
    buffer_char(output, '}');
}

/* Makes the symbols of all names; velocities are positions with a dot. Returns false with an error
 * if out of memory. */
static bool tex_names(struct scene_program *p)
{
    const int half = program_n(p) / 2;
    for (int i = 0; i < p->written.names; i++) {
        struct buffer name = {0};
        if (program_moves(p) && i > half && i <= 2 * half) {
            buffer_put(&name, TEXT("\\dot{"));
            put_symbol(&name, p->written.name[i - half]);
            buffer_char(&name, '}');
        } else {
            put_symbol(&name, p->written.name[i]);
        }
        if (!set_name(p, i, &name))
            return false;
    }
    return true;
}

/* Appends "symbol = value unit". */
static void put_measured(struct scene_program *p, const char *symbol, double value,
                         const char *unit)
{
    struct buffer text = {0};
    buffer_real(&text, value);
    buffer_format(&text, "%s%s", unit[0] ? " " : "", unit);
    buffer_format(p->output, "%s = ", symbol);
    buffer_siunitx(p->output, buffer_text(&text));
    p->output->failed |= text.failed;
    buffer_free(&text);
}

/* Appends the equations and the observed quantities as lines of an align* environment. */
static void put_tex_equations(struct scene_program *p)
{
    const struct written *w = &p->written;
    buffer_put(p->output, TEXT("\\begin{align*}\n"));
    for (int row = 0; row < w->rows; row++) {
        buffer_format(p->output, "  \\%s{%s} &= ", program_moves(p) ? "ddot" : "dot",
                      program_state(p, row));
        if (w->all[row])
            program_expr(p, w->all[row]);
        else
            buffer_char(p->output, '0');
        buffer_put(p->output,
                   row + 1 < w->names - w->observed + w->rows ? TEXT(" \\\\\n") : TEXT("\n"));
    }
    for (int i = w->observed; i < w->names; i++) {
        buffer_format(p->output, "  %s &= ", p->name[i]);
        program_expr(p, w->observe[i - w->observed]);
        buffer_put(p->output, i + 1 < w->names ? TEXT(" \\\\\n") : TEXT("\n"));
    }
    buffer_put(p->output, TEXT("\\end{align*}\n"));
}

/* Appends the values of the parameters that are used, and of the initial state. */
static void put_tex_values(struct scene_program *p)
{
    const struct written *w = &p->written;
    const struct system *system = &w->system;
    struct buffer symbol = {0};
    buffer_put(p->output, TEXT("\\begin{align*}\n"));
    for (int i = w->params; i < w->observed; i++) {
        if (!program_reads(p, i))
            continue;
        const struct param_row *row = param_at(p->scene, i - w->params);
        p->output->failed |= symbol.failed;
        buffer_clear(&symbol);
        buffer_format(&symbol, "  %s &", p->name[i]);
        put_measured(p, buffer_view(&symbol), p->scene->value[i - w->params], row->row.unit);
        buffer_put(p->output, TEXT(" \\\\\n"));
    }
    for (int i = 0; i < system->n; i++) {
        const struct variable variable = system->model->variable[i];
        p->output->failed |= symbol.failed;
        buffer_clear(&symbol);
        buffer_format(&symbol, "  %s(t_0) &", program_state(p, i));
        put_measured(p, buffer_view(&symbol), system->start[i], quantity_unit(variable.quantity));
        buffer_put(p->output, i + 1 < system->n ? TEXT(" \\\\\n") : TEXT("\n"));
    }
    buffer_put(p->output, TEXT("\\end{align*}\n"));
    p->output->failed |= symbol.failed;
    buffer_free(&symbol);
}

/* Writes a LaTeX document with equations, parameters and initial values. Returns false with an
 * error if out of memory. */
bool program_tex(struct scene_program *p)
{
    if (!tex_names(p))
        return false;
    put_tex_equations(p);
    p->rates = program_take_text(p);
    program_title(p, "% ");
    buffer_format(p->output,
                  "\n\\documentclass{article}\n\\usepackage{amsmath,siunitx}\n"
                  "\\begin{document}\n%s",
                  p->rates);
    put_tex_values(p);
    buffer_format(p->output, "Integrated by \\texttt{%s} with $", p->method->row.name);
    if (p->plan.adaptive)
        put_measured(p, "\\mathrm{tol}", p->settings.tol, "");
    else
        put_measured(p, "\\Delta t", p->settings.dt, "s");
    put_measured(p, "$, from $t_0", p->written.system.t0, "s");
    put_measured(p, "$ to $t", p->written.system.t0 + p->duration, "s");
    buffer_put(p->output, TEXT("$.\n\\end{document}\n"));
    return true;
}
