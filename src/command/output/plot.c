/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command plot: draws a figure as text, in pixels, or into a file. */
#ifndef COMMAND_ROWS
#include <hooke/base/file.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/module.h>
#include <hooke/report.h>
#include <hooke/plot.h>
#include <hooke/command/handler.h>
#include <hooke/command/figure_arguments.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* [row] Rows of a screen beside a figure (state line, numbers, prompt, hint, and two more after
 * 'layout log'), and the smallest height of a figure. */
#define OTHER_ROWS 6
#define MIN_ROWS 8

/* Returns true if the text ends with `end` and has more before it. */
static bool ends_with(struct text text, const char *end)
{
    const size_t len = strlen(end);
    return text.len > len && text_is((struct text){text.data + text.len - len, len}, end);
}

/* A file of text, or of a kind of pictures that a module draws. */
struct figure_file {
    const struct picture_writer *writer; /* NULL for text */
    size_t kind;                         /* place in writer->kinds */
};

/* Chooses the kind of file by the ending of its name and sets *file to the writer of pictures;
 * leaves *file zero for text (.txt). `kind` is only used in hints. Returns false with the error set
 * for other endings or if the module of pictures is missing. */
static bool choose_file(struct text path, enum plot_kind kind, struct figure_file *file,
                        struct error *error)
{
    const struct picture_writer *writer = module_pictures();
    size_t dot = path.len;
    while (dot > 0 && path.data[dot - 1] != '.' && path.data[dot - 1] != '/')
        dot--;
    const struct text end = {path.data + dot, path.len - dot};
    const bool has_end = dot >= 2 && path.data[dot - 1] == '.';
    const struct row *row = writer && has_end ? catalog_find(writer->kinds, end) : NULL;
    char what[LIMIT_NAME];
    snprintf(what, sizeof what, "plot .%.*s", (int)end.len, end.data);
    if (ends_with(path, ".txt"))
        return true;
    if (has_end && !module_is_in(what, path, error))
        return false;
    if (!row) {
        if (writer)
            error_at(error, path, "figures can be %s, or text in .txt", writer->where);
        else
            error_at(error, path, "figures can be text in a file that ends in .txt");
        return error_hint(error, "plot %s > figure%s", plot_row(kind)->row.name,
                          writer ? ".svg" : ".txt");
    }
    *file = (struct figure_file){writer, (size_t)catalog_index(writer->kinds, row)};
    return true;
}

/* Writes the content to the file behind >. Returns false with the error set. */
static bool write_file(const struct session *session, const struct arguments *args,
                       const struct buffer *content, struct reply *reply, struct error *error)
{
    const struct item *file = argument_value(args, ">")->item;
    const char *path = arena_text(args->arena, file->text);
    struct buffer shown = {0};
    const bool ok = path && !content->failed
                        ? file_write(path, buffer_text(content),
                                     session_policy(session, has_argument(args, "force")), error)
                        : error_memory(error);
    safe_text(&shown, file->text, false);
    if (ok)
        reply_line(reply, "figure written to %s", buffer_view(&shown));
    else if (!error->where.data)
        error->where = file->text;
    buffer_free(&shown);
    return ok;
}

/* Tells how a figure that fills the whole screen can be shown in a pane. */
static void reply_where(const struct session *session, const struct figure_request *request,
                        struct reply *reply)
{
    if (!request->columns && plot_offered(session, request->kind))
        reply_line(reply, "'focus %s full' keeps it in a pane", plot_row(request->kind)->row.name);
}

/* Reports the largest width of the adopted fit's band. Plots that draw their own bands report them
 * themselves. */
static void report_band(const struct figure *figure, enum plot_kind kind, struct reply *reply)
{
    const struct curve *curve = plot_row(kind)->figure ? NULL : figure_band(figure);
    double max = 0, max_position = 0;
    for (size_t i = 0; curve && i < curve->n; i++)
        if (curve->spread[i] > max) {
            max = curve->spread[i];
            max_position = curve->x[i];
        }
    if (!curve)
        return;
    const struct unit *unit = unit_find(text_of(figure->y.unit));
    const enum quantity quantity = unit ? unit->quantity : QUANTITY_NUMBER;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "95 %% band of the fit: at most +- %s, at t = %s",
                  SHOWN_QUANTITY(max, quantity, 3), SHOWN_QUANTITY(max_position, QUANTITY_TIME, 4));
    reply_begin(reply, "band");
    reply_real(reply, "level", 0.95);
    reply_measured(reply, "largest", (struct measured){max, NAN}, quantity);
    reply_measured(reply, "at", (struct measured){max_position, NAN}, QUANTITY_TIME);
    reply_end(reply);
}

/* Returns the label without a unit at its end, as in "time (s)" or "y [cm]", and sets the axis to
 * that unit, so that it is printed once. The label is returned unchanged if the unit is unknown or
 * of another quantity than the axis. */
static struct text take_unit(struct text label, struct axis *axis)
{
    const struct unit *present = axis->unit ? unit_find(text_of(axis->unit)) : NULL;
    size_t open = label.len;
    while (open > 0 && label.data[open - 1] != '(' && label.data[open - 1] != '[')
        open--;
    if (!present || open == 0 || !strchr(")]", label.data[label.len - 1]))
        return label;
    const struct unit *unit = unit_find((struct text){label.data + open, label.len - open - 1});
    if (!unit || unit->quantity != present->quantity)
        return label;
    axis->unit = unit->row.name;
    axis->factor = unit->factor;
    return text_trim((struct text){label.data, open - 1});
}

/* Replaces the figure's title, axis labels and names of curves by the arguments title=, xlabel=,
 * ylabel= and label=, and sets its grid. Curves and second axes are copied to the arena first,
 * since the originals are const. Returns false with the error set if more labels than curves are
 * given or if out of memory. */
static bool choose_words(const struct arguments *args, struct figure *figure, struct error *error)
{
    const struct argument_value *title = argument_value(args, "title"),
                                *x = argument_value(args, "xlabel"),
                                *y = argument_value(args, "ylabel"),
                                *label = argument_value(args, "label");
    struct curve *curve = arena_array(args->arena, (size_t)figure->curves + 1, sizeof *curve);
    struct axis *second = arena_array(args->arena, 2, sizeof *second);
    if (!curve || !second)
        return error_memory(error);
    if (label->count > figure->curves)
        return error_at(error, label->where, "the figure has %d curve%s, got %d labels",
                        figure->curves, plural_s(figure->curves), label->count);
    if (label->count) {
        memcpy(curve, figure->curve, (size_t)figure->curves * sizeof *curve);
        figure->curve = curve;
    }
    if (figure->second && (x->count || y->count)) {
        memcpy(second, figure->second, 2 * sizeof *second);
        figure->second = second;
    }
    bool ok = true;
    const struct {
        const struct argument_value *value;
        struct axis *axis, *also;
    } labels[] = {{x, &figure->x, &second[0]}, {y, &figure->y, &second[1]}};
    for (size_t i = 0; i < COUNT_OF(labels); i++) {
        struct axis *axis = labels[i].axis, *also = labels[i].also;
        if (!labels[i].value->count)
            continue;
        const struct text typed = labels[i].value->item->text;
        axis->label = arena_text(args->arena, take_unit(typed, axis));
        also->label = arena_text(args->arena, take_unit(typed, also));
        ok &= axis->label && also->label;
    }
    if (title->count) {
        figure->title = arena_text(args->arena, title->item->text);
        ok &= figure->title != NULL;
    }
    for (int i = 0; i < label->count; i++) {
        curve[i].label = arena_text(args->arena, label->item[i].text);
        ok &= curve[i].label != NULL;
    }
    figure->grid = added_argument(args, "grid");
    return ok || error_memory(error);
}

/* Returns false with the error set if arguments were given that only pictures have (size, grid). */
static bool refuse_in_text(const struct arguments *args, struct error *error)
{
    static const char *const names[] = {"size", "grid"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        const struct argument_value *given = added_argument(args, names[i]);
        if (given) {
            error_at(error, given->where, "%s works only for pictures", names[i]);
            return error_hint(error, "for example: plot position size=12x8 --grid > figure.svg");
        }
    }
    return true;
}

/* Returns true if pixels were asked for and can be shown. If they cannot, the figure is drawn in
 * text, and the reply says why. */
static bool shows_pixels(const struct session *session, const struct arguments *args,
                         struct reply *reply)
{
    struct error error = {0};
    const struct front *front = &session->front;
    if (!added_argument(args, "pixels") || reply->format != FORMAT_TEXT)
        return false;
    if (!front->pixels)
        error_set(&error, ERROR_COMMAND,
                  "pixels cannot be shown in panes; 'plain' leaves the panes");
    else if (front->pixels(front, NULL, 0, 0, &error))
        return true;
    reply_note(reply, "%s%s%s", error.text, *error.hint ? "; " : "", error.hint);
    return false;
}

/* Appends the numbers of the figure behind it. */
static void reply_numbers(const struct session *session, const struct figure_request *request,
                          const struct figure *figure, struct reply *reply)
{
    if (plot_row(request->kind)->reply)
        plot_row(request->kind)->reply(session, request, reply);
    report_band(figure, request->kind, reply);
}

/* Writes the figure to a file, as text or by the module that draws pictures. Returns false with the
 * error set. */
static bool write_figure(const struct session *session, const struct arguments *args,
                         const struct figure_request *request, const struct figure_file *file,
                         struct figure *figure, struct reply *reply, struct error *error)
{
    const struct argument_value *size = added_argument(args, "size");
    double page[2] = {0, 0};
    int width, height;
    struct buffer content = {0};
    for (int i = 0; i < 2 && size; i++)
        page[i] = size->item->range[i] * POINTS_PER_METRE;
    session_size(session, &width, &height);
    bool ok = true;
    if (!file->writer)
        ok = figure_print(figure, width, height, request->charset, false, &content) ||
             error_memory(error);
    else
        ok = label_curves(session, request, args->arena, figure, error) &&
             file->writer->write(figure, file->kind, page[0], page[1], &content, error);
    ok = ok && write_file(session, args, &content, reply, error);
    if (ok)
        reply_numbers(session, request, figure, reply);
    buffer_free(&content);
    return ok;
}

/* Moves the names of the curves from the frame of a study's figure to lines below it if they do not
 * fit beside the title in `width` cells. Then appends those lines to *lines, removes the names from
 * the curves (a copy in the arena), and returns the number of lines. Returns 0 if the legend stays
 * in the frame or if out of memory. */
static int move_legend(struct figure *figure, int width, struct arena *arena, struct buffer *lines)
{
    enum { BESIDE = 14 /* [cell] of the frame: blanks, brackets, corners */, GAP = 3 };
    const int title = text_width(text_of(figure->title)) + text_width(text_of(figure->y.label)) +
                      text_width(text_of(figure->y.unit));
    struct curve *curve = arena_array(arena, (size_t)figure->curves + 1, sizeof *curve);
    int used = 0, count = 1;
    for (int i = 0; i < figure->curves; i++)
        used += text_width(text_of(figure->curve[i].label)) + GAP + 1;
    if (!curve || used <= width - BESIDE - title)
        return 0;
    used = 0;
    for (int i = 0; i < figure->curves; i++) {
        const char mark[] = {figure_mark(figure, i), '\0'};
        const struct text label = text_of(figure->curve[i].label);
        const int cells = text_width(label) + 3;
        curve[i] = figure->curve[i];
        curve[i].label = NULL;
        if (!label.len)
            continue;
        if (used && used + GAP + cells > width) {
            buffer_char(lines, '\n');
            used = 0;
            count++;
        }
        const int gap = used ? GAP : 0;
        buffer_format(lines, "%*s%s %s", gap, "", *mark ? mark : "--", label.data);
        used += GAP + cells;
    }
    buffer_char(lines, '\n');
    figure->curve = curve;
    return count;
}

/* Prints the figure as text of that size, with colour if wanted, and the legend below. Returns
 * false with the error set. */
static bool print_figure(const struct session *session, const struct figure_request *request,
                         struct figure *figure, int width, int height, struct arena *arena,
                         struct reply *reply, struct error *error)
{
    const struct front *front = &session->front;
    const enum color_choice choice = (enum color_choice)session->setup.settings.color;
    int colors = choice == COLOR_AUTO && !front->watched ? front->colors : 0;
    if (choice == COLOR_ALWAYS)
        colors = front->colors ? front->colors : 8;
    struct buffer *text = reply_buffer(reply), legend = {0};
    if (plot_row(request->kind)->picture && !request->charset->words)
        height -= move_legend(figure, width, arena, &legend);
    if (!figure_print(figure, width, height, request->charset,
                      reply->format == FORMAT_TEXT ? colors : 0, text))
        return error_memory(error);
    buffer_put(text, buffer_text(&legend));
    buffer_free(&legend);
    if (plot_row(request->kind)->legend && !request->charset->words)
        plot_row(request->kind)->legend(session, width, text);
    return true;
}

/* Chooses the figure and its output (file, pixels or text), makes it with a fitting number of
 * columns, and writes it. */
HANDLER(plot)
{
    const struct argument_value *file = argument_value(args, ">");
    struct figure_peaks peaks = {0};
    struct figure_request request = {.peaks = &peaks};
    struct figure figure;
    struct figure_file chosen = {0};
    int width, height;
    if (!choose_figure(args, &request, error) ||
        (file->count && !choose_file(file->item->text, request.kind, &chosen, error)) ||
        (!chosen.writer && !refuse_in_text(args, error)))
        return false;
    session_size(session, &width, &height);
    const bool in_log = session->front.watched && !file->count;
    if (in_log && !session->setup.settings.height)
        height = height > MIN_ROWS + OTHER_ROWS ? height - OTHER_ROWS : MIN_ROWS;
    const bool pixels = !file->count && shows_pixels(session, args, reply),
               drawn = chosen.writer || pixels;
    request.charset = drawn ? &charset_braille : session_charset(session);
    if (drawn)
        request.width = PICTURE_COLUMNS;
    else
        request.width = request.charset->words ? WORDS_COLUMNS : width;
    if (!make_figure(session, args, &request, &figure, reply, error) ||
        !choose_words(args, &figure, error))
        return false;
    if (file->count)
        return write_figure(session, args, &request, &chosen, &figure, reply, error);
    if ((pixels || request.charset->words) &&
        !label_curves(session, &request, args->arena, &figure, error))
        return false;
    if (pixels
            ? !session->front.pixels(&session->front, &figure, width, height, error)
            : !print_figure(session, &request, &figure, width, height, args->arena, reply, error))
        return false;
    reply_numbers(session, &request, &figure, reply);
    if (in_log)
        reply_where(session, &request, reply);
    return true;
}
#endif

COMMAND(plot, .row.alias = "p", .group = "PLOT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("WHAT", TYPE_COLUMN, .flags = ARG_REQUIRED | ARG_MANY | ARG_OF,
                        .choices = &plot_catalog),
                  FIGURE_ARGUMENTS, PLOT_ARGUMENTS KEY("title", TYPE_TEXT),
                  KEY("xlabel", TYPE_TEXT), KEY("ylabel", TYPE_TEXT),
                  KEY("label", TYPE_TEXT, .flags = ARG_MANY), WORD(">", TYPE_FILE),
                  OPTION("force", TYPE_NONE)))
