/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How languages look, and what stands above everything: the title, the constants. */
#include "modules/programs/program.h"

#include <math.h>
#include <string.h>

static const struct syntax syntaxes[] = {
    {.dialect = DIALECT_C,
     .comment = "/* ",
     .comment_end = " */",
     .variable = "double ",
     .constant = "const double ",
     .global = "static const double ",
     .function = "static double ",
     .begin = "\n{\n",
     .result = "return",
     .end = "}\n",
     .none = "void",
     .stop = ";",
     .count = "(double)(i + 1)",
     .last = "i == steps - 1",
     .newline = "\n            ",
     .if_then = "if (",
     .if_end = ") "},
    {.dialect = DIALECT_PYTHON,
     .comment = "# ",
     .comment_end = "",
     .variable = "",
     .constant = "",
     .global = "",
     .function = "def ",
     .begin = ":\n",
     .result = "return",
     .end = "\n",
     .none = "",
     .stop = "",
     .count = "(i + 1)",
     .last = "i == steps - 1",
     .newline = "\n            ",
     .if_then = "if ",
     .if_end = ": "},
    {.dialect = DIALECT_OCTAVE,
     .comment = "% ",
     .comment_end = "",
     .variable = "",
     .constant = "",
     .global = "",
     .none = "",
     .stop = ";",
     .count = "i",
     .last = "i == steps",
     .newline = " ...\n            ",
     .if_then = "if ",
     .if_end = "\n        "},
    {.dialect = DIALECT_XPP, .comment = "# ", .comment_end = ""},
    {.dialect = DIALECT_TEX, .comment = "% ", .comment_end = ""},
};

const struct syntax *program_syntax(enum dialect dialect)
{
    size_t i = 0;
    while (syntaxes[i].dialect != dialect)
        i++;
    return &syntaxes[i];
}

/* ---- what stands above everything ---- */

static void put_name_and_unit(struct buffer *out, const char *label, double value, const char *unit)
{
    buffer_put(out, text_of(label));
    buffer_real(out, value);
    buffer_format(out, "%s%s", unit[0] ? " " : "", unit);
}

static void put_equation(struct scene_program *p, int row)
{
    struct buffer text = {0};
    buffer_format(&text, "%s%s = ", p->written.name[1 + row], program_moves(p) ? "''" : "'");
    if (!p->written.all[row] ||
        !expr_text(p->written.all[row], DIALECT_XPP, p->written.name, p->written.zero, &text))
        buffer_put(&text, p->written.all[row] ? TEXT("") : TEXT("0"));
    if (p->written.dry)
        buffer_put(&text, TEXT(", and dry friction"));
    buffer_format(p->out, "   %s\n", buffer_view(&text));
    p->out->failed |= text.failed;
    buffer_free(&text);
}

void program_title(struct scene_program *p)
{
    const char *brief = p->scene->preset->row.brief;
    buffer_format(p->out, "%s: %s\n", p->scene->preset->row.name, brief);
    for (int row = 0; row < p->written.rows; row++)
        put_equation(p, row);
    buffer_format(p->out, "by %s: %s\n", p->method->row.name, p->method->row.brief);
    put_name_and_unit(p->out, p->plan.adaptive ? "tol = " : "dt = ",
                      p->plan.adaptive ? p->settings.tol : p->settings.dt,
                      p->plan.adaptive ? "" : "s");
    put_name_and_unit(p->out, ", from t = ", p->written.system.t0, "s");
    put_name_and_unit(p->out, " to ", p->written.system.t0 + p->duration, "s");
    buffer_format(p->out, "; written by hooke %s\n", HOOKE_VERSION);
}

/* Every line of a text as a comment. */
static void put_commented(struct scene_program *p, struct text text, const char *before)
{
    struct text line;
    while (text_split(&text, '\n', &line))
        if (line.len > 0)
            buffer_format(p->out, "%s%.*s\n", before, (int)line.len, line.at);
}

void program_front(struct scene_program *p)
{
    static const char *const how[] = {
        [DIALECT_C] = "hooke's bits by: gcc -O2 -ffp-contract=off FILE.c -lm && ./a.out >run.csv\n",
        [DIALECT_PYTHON] = "python3 FILE.py >run.csv, python3 FILE.py --plot\n",
        [DIALECT_OCTAVE] = "octave FILE.m >run.csv\n"};
    struct scene_program plain = *p;
    struct buffer text = {0};
    plain.out = &text;
    program_title(&plain);
    buffer_put(&text, text_of(how[p->syntax->dialect]));
    const bool c = p->syntax->dialect == DIALECT_C;
    buffer_put(p->out, c ? TEXT("/*\n") : TEXT(""));
    put_commented(p, buffer_text(&text), c ? " * " : p->syntax->comment);
    buffer_put(p->out, c ? TEXT(" */\n") : TEXT(""));
    p->out->failed |= text.failed;
    buffer_free(&text);
}

/* ---- constants ---- */

static void put_constant(struct scene_program *p, const char *name, double value, const char *unit,
                         const char *brief)
{
    const struct syntax *s = p->syntax;
    char z[REAL_TEXT_SIZE];
    real_format(value, z);
    const bool whole = s->dialect == DIALECT_PYTHON && !strpbrk(z, ".eni");
    if (s->dialect == DIALECT_C && program_shadows(name))
        buffer_format(p->out, "#define %s %s_ /* a function of the C library has its name */\n",
                      name, name);
    buffer_format(p->out, "%s%s = %s%s%s", s->global, name, z, whole ? ".0" : "", s->stop);
    if (unit[0] || brief[0])
        buffer_format(p->out, "%s%s%s%s%s%s%s%s", s->dialect == DIALECT_PYTHON ? "  " : " ",
                      s->comment, unit[0] ? "[" : "", unit, unit[0] ? "]" : "",
                      unit[0] && brief[0] ? " " : "", brief, s->comment_end);
    buffer_char(p->out, '\n');
}

void program_constants(struct scene_program *p)
{
    const struct written *w = &p->written;
    const bool c = p->syntax->dialect == DIALECT_C;
    for (int i = w->params; i < w->observed; i++) {
        if (!p->reads[i])
            continue;
        const struct param_row *row = param_at(p->scene, i - w->params);
        const bool typed = strcmp(row->row.brief, "typed by the user") == 0;
        put_constant(p, p->name[i], p->scene->value[i - w->params], row->row.unit,
                     typed ? "" : row->row.brief);
    }
    buffer_char(p->out, '\n');
    if (p->plan.adaptive) {
        if (p->syntax->dialect != DIALECT_OCTAVE)
            program_adaptive_constants(p);
        return;
    }
    put_constant(p, "dt", p->settings.dt, "s", "time step");
    if (p->written.system.t0 != 0)
        put_constant(p, "t0", p->written.system.t0, "s", "start");
    buffer_format(p->out, "%ssteps = %lld%s\n", c ? "static const long " : "",
                  (long long)p->plan.whole + p->partial, p->syntax->stop);
}
