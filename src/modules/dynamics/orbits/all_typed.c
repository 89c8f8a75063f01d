/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Converts built-in scenes to typed ones (typed_written): writes the lines that a user would type,
 * from the texts in the rows of the scene's terms, so that their equations have bounds. */
#include <hooke/base/catalog.h>
#include <hooke/base/number.h>
#include <ctype.h>
#include <string.h>

#include "modules/dynamics/orbits/forms.h"

/* The lines of the typed scene while they are written. */
struct writing {
    const struct scene *scene;
    struct system system;
    struct arena arena;
    struct typed_line *line;
    int lines;
    struct error *error;
};

/* Returns the number of equations: half of the variables for those of second order. */
static int equation_count(const struct system *system)
{
    return system->order == 2 ? system->n / 2 : system->n;
}

/* Copies the text of a buffer into the arena and frees the buffer. Returns false with an error if
 * out of memory. */
static bool take_buffer_text(struct writing *w, struct buffer *buffer, struct text *text)
{
    text->data = buffer->failed ? NULL : arena_text(&w->arena, buffer_text(buffer));
    text->len = text->data ? strlen(text->data) : 0;
    buffer_free(buffer);
    return text->data || error_memory(w->error);
}

/* Appends an empty line of that kind and name, and returns it. */
static struct typed_line *writing_line_append(struct writing *w, enum typed_kind kind,
                                              struct text name)
{
    struct typed_line *line = &w->line[w->lines++];
    *line = (struct typed_line){.kind = kind, .name = name, .expr = TEXT("")};
    return line;
}

/* Returns the name of variable i. */
static struct text variable_name(const struct writing *w, int i)
{
    return text_of(w->system.model->variable[i].name);
}

/* Sets *name to the name of variable i with a prime: its derivative. Returns false if out of
 * memory. */
static bool derivative_name(struct writing *w, int i, struct text *name)
{
    struct buffer buffer = {0};
    buffer_format(&buffer, "%s'", w->system.model->variable[i].name);
    return take_buffer_text(w, &buffer, name);
}

/* Returns the length of the name at the beginning of the text. */
static size_t name_length(struct text text)
{
    size_t n = 0;
    while (n < text.len && (isalnum((unsigned char)text.data[n]) || text.data[n] == '_'))
        n++;
    return n;
}

/* Returns true if the name occurs in one of the expressions. */
static bool is_name_used(const struct writing *w, const char *wanted)
{
    for (int i = 0; i < w->lines; i++)
        for (struct text rest = w->line[i].expr; rest.len > 0;) {
            const struct text name = {rest.data, name_length(rest)};
            if (text_is(name, wanted))
                return true;
            const size_t length = name.len > 0 ? name.len : 1;
            rest = text_after(rest, length);
        }
    return false;
}

/* ---- lines; parameters come last, as the equations tell which are needed ---- */

/* Appends a summand of an equation. */
static void put_part(struct buffer *output, const char *part)
{
    buffer_format(output, "%s%s", output->len > 0 && part[0] != '-' ? "+" : "", part);
}

/* Writes the equation of a row: what the built-in terms contribute, and the typed forces. */
static bool write_equation(struct writing *w, int row)
{
    const struct system *system = &w->system;
    const struct model *model = w->scene->model;
    struct buffer text = {0};
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->equation[row])
            put_part(&text, system->term[i].row->equation[row]);
    for (int i = 0; i < typed_lines(model); i++) {
        const struct typed_line *line = typed_line(model, i);
        if (line->kind == TYPED_FORCE &&
            text_equal(line->name,
                       row == 0 && line->name.len == 0 ? line->name : variable_name(w, row))) {
            buffer_format(&text, "%s(%.*s)/", text.len > 0 ? "+" : "", (int)line->expr.len,
                          line->expr.data);
            buffer_real(&text, system->mass);
        }
    }
    struct typed_line *line = writing_line_append(w, TYPED_EQUATION, variable_name(w, row));
    if (text.len == 0)
        buffer_put(&text, TEXT("0"));
    line->order = system->order;
    return take_buffer_text(w, &text, &line->expr);
}

/* Writes velocities as observed quantities under the names that typed forces use, then the typed
 * observables and parameters. Returns false if out of memory. */
static bool write_observed(struct writing *w)
{
    const struct model *model = w->scene->model;
    for (int i = 0; i < w->system.n / 2 && w->system.order == 2; i++) {
        const struct text velocity = variable_name(w, w->system.n / 2 + i),
                          variable = variable_name(w, i);
        const bool usual = velocity.len == variable.len + 1 && velocity.data[0] == 'v' &&
                           text_equal((struct text){velocity.data + 1, variable.len}, variable);
        struct typed_line *line = usual ? NULL : writing_line_append(w, TYPED_OBSERVE, velocity);
        if (line && !derivative_name(w, i, &line->expr))
            return false;
    }
    for (int i = 0; i < typed_lines(model); i++) {
        const enum typed_kind kind = typed_line(model, i)->kind;
        if (kind == TYPED_OBSERVE || kind == TYPED_PARAM)
            w->line[w->lines++] = *typed_line(model, i);
    }
    return true;
}

/* Writes the initial values. Returns false if out of memory. */
static bool write_start(struct writing *w)
{
    const int rows = equation_count(&w->system);
    for (int i = 0; i < w->system.n; i++) {
        struct text name = variable_name(w, i);
        if (i >= rows && !derivative_name(w, i - rows, &name))
            return false;
        struct typed_line *line = writing_line_append(w, TYPED_VAR, name);
        line->value = w->system.start[i];
        line->quantity = w->system.model->variable[i].quantity;
    }
    return true;
}

/* Writes the built-in parameters that occur in an equation. */
static void write_params(struct writing *w)
{
    const struct model *base = typed_base(w->scene->model);
    for (size_t i = 0; i < base->params->count; i++) {
        const struct param_row *row = param_at(w->scene, (int)i);
        if (strcmp(row->row.name, "t0") == 0 || !is_name_used(w, row->row.name))
            continue;
        struct typed_line *line = writing_line_append(w, TYPED_PARAM, text_of(row->row.name));
        line->value = w->scene->value[i];
        line->quantity = row->quantity;
    }
}

/* Writes all lines. Returns false with an error if out of memory. */
static bool write_lines(struct writing *w)
{
    const size_t max = 3 * (size_t)w->system.n + w->scene->model->params->count +
                       (size_t)typed_lines(w->scene->model);
    w->line = arena_array(&w->arena, max, sizeof *w->line);
    if (!w->line)
        return error_memory(w->error);
    bool fine = write_observed(w) && write_start(w);
    for (int row = 0; fine && row < equation_count(&w->system); row++)
        fine = write_equation(w, row);
    if (fine)
        write_params(w);
    return fine;
}

/* Writes the lines of the scene and makes a typed model of them. */
bool typed_written(struct typed_models *models, const struct scene *scene, struct scene *written,
                   struct error *error)
{
    struct writing w = {.scene = scene, .error = error};
    const struct model *model = NULL;
    if (!scene_bind_motion(scene, &w.system, error))
        return false;
    if (write_lines(&w))
        model = typed_make(models, TEXT("written"), w.line, w.lines, NULL, error);
    arena_reset(&w.arena);
    if (!model)
        return false;
    *written = *scene;
    scene_remodel(written, model);
    return true;
}
