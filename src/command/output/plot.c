/* SPDX-License-Identifier: GPL-3.0-or-later */
/* plot */
#ifndef COMMAND_ROWS
#include <hooke/report.h>
#include <hooke/plot.h>
#include <hooke/command/handler.h>
#include "command/data/measuring.h"
#include <hooke/command/figure_arguments.h>

#include <math.h>
#include <string.h>

/* of a screen: state line, numbers, prompt; the hint and two more once 'layout log' is typed */
#define OTHER_ROWS 6
#define MIN_ROWS 8

static bool ends_with(struct text text, const char *end)
{
    const size_t len = strlen(end);
    return text.len > len && text_is((struct text){text.at + text.len - len, len}, end);
}

/* By what the name ends in: text, or a row of the picture catalog. */
static bool choose_picture(struct text path, enum plot_kind kind, bool *text, enum picture *picture,
                           struct error *error)
{
    size_t dot = path.len;
    while (dot > 0 && path.at[dot - 1] != '.' && path.at[dot - 1] != '/')
        dot--;
    const struct text end = {path.at + dot, path.len - dot};
    const struct row *row = catalog_find(&picture_catalog, end);
    *text = ends_with(path, ".txt");
    if (*text)
        return true;
    if (!row || dot < 2 || path.at[dot - 1] != '.') {
        error_at(
            error, path,
            "a figure is a picture in a file that ends in .svg, .pdf or .png, or text in .txt");
        return error_hint(error, "plot %s > figure.svg", plot_row(kind)->row.name);
    }
    *picture = (enum picture)catalog_index(&picture_catalog, row);
    return true;
}

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
    else if (!error->where.at)
        error->where = file->text;
    buffer_free(&shown);
    return ok;
}

/* Where a figure that is read on the whole screen can be kept in sight. */
static void reply_where(const struct session *session, const struct figure_request *request,
                        struct reply *reply)
{
    if (!request->columns && plot_offered(session, request->kind))
        reply_line(reply, "'focus %s full' keeps it in a pane", plot_row(request->kind)->row.name);
}

/* How wide the band is at most. */
static void report_band(const struct figure *figure, struct reply *reply)
{
    const struct curve *curve = figure_band(figure);
    double max = 0, at = 0;
    for (size_t i = 0; curve && i < curve->n; i++)
        if (curve->spread[i] > max) {
            max = curve->spread[i];
            at = curve->x[i];
        }
    if (!curve)
        return;
    const struct unit *unit = unit_find(text_of(figure->y.unit));
    const enum quantity quantity = unit ? unit->quantity : QUANTITY_NUMBER;
    struct buffer text = {0};
    buffer_put(&text, TEXT("95 % of the fit: at most +- "));
    buffer_quantity(&text, max, quantity, 3);
    buffer_put(&text, TEXT(", at t = "));
    buffer_quantity(&text, at, QUANTITY_TIME, 4);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    reply_begin(reply, "band");
    reply_real(reply, "level", 0.95);
    reply_measured(reply, "largest", (struct measured){max, NAN}, quantity);
    reply_measured(reply, "at", (struct measured){at, NAN}, QUANTITY_TIME);
    reply_end(reply);
}

/* The lines of spectra in words and as records; with names where there are several curves. */
void spectrum_report(const struct figure_peaks *peaks, int curves, struct reply *reply)
{
    for (int i = 0; i < peaks->count; i++) {
        const struct figure_peak *peak = &peaks->peak[i];
        struct buffer text = {0};
        if (curves > 1 && peak->label)
            buffer_format(&text, "%s: ", peak->label);
        put_measured(&text, "line at f", peak->line.frequency, QUANTITY_FREQUENCY);
        put_measured(&text, "   A", peak->line.amplitude, peak->quantity);
        reply_text(reply, buffer_text(&text));
        buffer_free(&text);
        reply_begin(reply, "peak");
        reply_string(reply, "of", peak->label);
        reply_measured(reply, "frequency", peak->line.frequency, QUANTITY_FREQUENCY);
        reply_measured(reply, "amplitude", peak->line.amplitude, peak->quantity);
        reply_end(reply);
    }
}

/* Words of the user's in place of those that the figure has. */
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
                        figure->curves, figure->curves == 1 ? "" : "s", label->count);
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
        const char **to, **also;
    } words[] = {{title, &figure->title, NULL},
                 {x, &figure->x.label, &second[0].label},
                 {y, &figure->y.label, &second[1].label}};
    for (size_t i = 0; i < COUNT_OF(words); i++) {
        if (!words[i].value->count)
            continue;
        *words[i].to = arena_text(args->arena, words[i].value->item->text);
        if (words[i].also)
            *words[i].also = *words[i].to;
        ok &= *words[i].to != NULL;
    }
    for (int i = 0; i < label->count; i++) {
        curve[i].label = arena_text(args->arena, label->item[i].text);
        ok &= curve[i].label != NULL;
    }
    figure->grid = has_argument(args, "grid");
    return ok || error_memory(error);
}

/* What only a picture has: its size, a grid. */
static bool refuse_in_text(const struct arguments *args, struct error *error)
{
    static const char *const names[] = {"size", "grid"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (argument_value(args, names[i])->count) {
            error_at(error, argument_value(args, names[i])->where, "%s is for a picture", names[i]);
            return error_hint(error, "for example: plot position size=12x8 --grid > figure.svg");
        }
    return true;
}

/* Asked for pixels: can they be shown? If not, the figure is drawn in text, and why is said. */
static bool shows_pixels(const struct session *session, const struct arguments *args,
                         struct reply *reply)
{
    struct error error = {0};
    const struct front *front = &session->front;
    if (!has_argument(args, "pixels") || reply->format != FORMAT_TEXT)
        return false;
    if (!front->pixels)
        error_set(&error, ERROR_COMMAND, "pixels are not shown among panes; 'plain' leaves them");
    else if (front->pixels(front, NULL, 0, 0, &error))
        return true;
    reply_note(reply, "%s%s%s", error.text, *error.hint ? "; " : "", error.hint);
    return false;
}

/* Behind the figure: what it holds in numbers. */
static void reply_numbers(const struct session *session, const struct figure_request *request,
                          const struct figure *figure, struct reply *reply)
{
    if (plot_row(request->kind)->reply)
        plot_row(request->kind)->reply(session, reply);
    spectrum_report(request->peaks, request->runs + (request->recording >= 0), reply);
    report_band(figure, reply);
}

/* picture NULL: as text. */
static bool into_file(const struct session *session, const struct arguments *args,
                      const struct figure_request *request, const enum picture *picture,
                      struct figure *figure, struct reply *reply, struct error *error)
{
    const struct argument_value *size = argument_value(args, "size");
    double page[2] = {0, 0};
    int width, height;
    struct buffer content = {0};
    for (int i = 0; i < 2 && size->count; i++)
        page[i] = size->item->range[i] * POINTS_PER_METRE;
    session_size(session, &width, &height);
    bool ok = true;
    if (!picture)
        ok = figure_print(figure, width, height, request->charset, false, &content) ||
             error_memory(error);
    else
        ok = label_methods(session, request, args->arena, figure, error) &&
             figure_picture(figure, *picture, page[0], page[1], &content, error);
    ok = ok && write_file(session, args, &content, reply, error);
    if (ok)
        reply_numbers(session, request, figure, reply);
    buffer_free(&content);
    return ok;
}

static bool as_text(const struct session *session, const struct figure_request *request,
                    const struct figure *figure, int width, int height, struct reply *reply,
                    struct error *error)
{
    const struct front *front = &session->front;
    const enum color_choice choice = (enum color_choice)session->setup.settings.color;
    const bool color =
        choice == COLOR_ALWAYS || (choice == COLOR_AUTO && front->color && !front->watched);
    struct buffer text = {0};
    const bool ok = figure_print(figure, width, height, request->charset,
                                 color && reply->format == FORMAT_TEXT, &text) ||
                    error_memory(error);
    if (ok && plot_row(request->kind)->study && request->charset != CHARSET_WORDS)
        precision_legend(session->precision, width, &text);
    if (ok)
        reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return ok;
}

HANDLER(plot)
{
    const struct argument_value *file = argument_value(args, ">");
    struct figure_peaks peaks = {0};
    struct figure_request request = {.peaks = &peaks};
    struct figure figure;
    int width, height;
    bool text = true;
    enum picture picture = PICTURE_SVG;
    if (!choose_figure(args, &request, error) ||
        (file->count && !choose_picture(file->item->text, request.kind, &text, &picture, error)) ||
        (text && !refuse_in_text(args, error)))
        return false;
    session_size(session, &width, &height);
    const bool in_log = session->front.watched && !file->count;
    if (in_log && !session->setup.settings.height)
        height = height > MIN_ROWS + OTHER_ROWS ? height - OTHER_ROWS : MIN_ROWS;
    const bool pixels = !file->count && shows_pixels(session, args, reply), drawn = !text || pixels;
    request.charset = drawn ? CHARSET_BRAILLE : session_charset(session);
    request.width = drawn                              ? PICTURE_COLUMNS
                    : request.charset == CHARSET_WORDS ? WORDS_COLUMNS
                                                       : width;
    if (!make_figure(session, args, &request, &figure, error) ||
        !choose_words(args, &figure, error))
        return false;
    if (file->count)
        return into_file(session, args, &request, text ? NULL : &picture, &figure, reply, error);
    if ((pixels || request.charset == CHARSET_WORDS) &&
        !label_methods(session, &request, args->arena, &figure, error))
        return false;
    if (pixels ? !session->front.pixels(&session->front, &figure, width, height, error)
               : !as_text(session, &request, &figure, width, height, reply, error))
        return false;
    reply_numbers(session, &request, &figure, reply);
    if (in_log)
        reply_where(session, &request, reply);
    return true;
}
#endif

COMMAND(
    plot,
    .row = {"plot", "", "draw position, velocity, phase, energy, a spectrum, ...; or any columns",
            "", "p"},
    .group = "PLOT",
    .text =
        "A kind of plot, or names of what moves and is observed: 'plot x', 'plot x,y', 'plot y "
        "against x';\n"
        "with 'at EVENT' as points where that event happened, a Poincare section; with --next what "
        "is drawn upwards is "
        "taken where it\nhappened the next time: 'plot z against z at top --next' is a return "
        "map.\n"
        "'plot error against dt of precision' is of the columns of a result, 'export FILE table of "
        "NAME' has\n"
        "them: points, in a curve for each method or event.\n"
        "Of the current run and of the recording where they overlap in time, unless told; all of "
        "the time, unless\n"
        "a window is given: more periods than the width can show are an envelope, and the frame "
        "says how many.\n"
        "'plot portrait' is of the scene, run or not: directions, where either variable rests, "
        "equilibria as\n"
        "letters by kind (large: stable), separatrices, with the numbers where they cross the "
        "lines "
        "through\n"
        "equilibria; q=-3:3 v=-2:2 are its sides, of any two variables.\n"
        "The phase plot shows the last 2 periods ('trail' says how many). Curves whose sizes "
        "differ by more than\n"
        "a factor of 10 get a logarithmic axis where nothing is negative, else a panel for each "
        "size; --full puts\n"
        "all on one axis, whole. x= and y= fix the axes, values with units: y=0:35J, y=2cm: with "
        "an open end,\n"
        "y=: as narrow as what is drawn; the frame says which curve leaves where and how far. An "
        "energy that\n"
        "hardly varies is drawn from zero otherwise. A file that ends in .svg, .pdf or .png "
        "becomes a picture,\n"
        "one in .txt holds the text. size=12x8 is a picture's page in cm (22.6x14.1 unless told), "
        "text "
        "and lines\n"
        "go with it; --grid adds lines at its ticks. title=, xlabel=, ylabel= and label=A,B, for "
        "the "
        "curves in turn,\n"
        "are words in place of those that are drawn (title=\"\": none); names of Greek letters are "
        "letters in a\n"
        "picture, the unit stays behind the label. --band draws a run of what 'adopt' took with "
        "the 95 % band "
        "of\n"
        "that fit's uncertainty, to first order in its parameters, of position or velocity; it is\n"
        "computed only then. 'set band on' shows it in panes, 'export FILE --band' writes it. "
        "--pixels shows a\n"
        "picture in terminals that say that they can (kitty, iTerm2, sixel; not among panes), "
        "text in others.\n"
        "In pictures points have error bars: amplitudes and periods those of their fits, "
        "recordings those of a\n"
        "column named error, yerr, sigma .. in the unit of the values. One that is the same in "
        "100 samples or more\n"
        "is a calibration, as 0.239 cm of the lab's sensor, and is not drawn.",
    .examples =
        "compare euler symplectic-euler; plot energy run all y=0:40mJ; plot momentum against y\n"
        "load bare.txt; m = 200 g; fit drag; adopt; run; plot position --band size=12x8 title=\"\" "
        "> band.svg",
    .see = "set export measure", .flags = COMMAND_ANYTIME,
    ARGUMENTS(PLACE("WHAT", TYPE_COLUMN, .flags = ARG_REQUIRED | ARG_MANY | ARG_OF,
                    .choices = &plot_catalog),
              FIGURE_ARGUMENTS, OPTION("pixels", TYPE_NONE), KEY("size", TYPE_SIZE),
              KEY("title", TYPE_TEXT), KEY("xlabel", TYPE_TEXT), KEY("ylabel", TYPE_TEXT),
              KEY("label", TYPE_TEXT, .flags = ARG_MANY), OPTION("grid", TYPE_NONE),
              WORD(">", TYPE_FILE), OPTION("force", TYPE_NONE)))
