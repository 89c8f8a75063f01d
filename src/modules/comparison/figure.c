/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws a precision study as a work-precision diagram: error against time or evaluations, both
 * logarithmic. Each method is a curve; settings that failed are drawn in a row at the top. */
#include <hooke/base/safe_text.h>
#include <hooke/plot/drawing.h>
#include "modules/comparison/comparison.h"
#include "modules/comparison/plots.h"

#include <math.h>
#include <string.h>

/* height at which an error of 0 is drawn, half an ulp of 1, as a logarithmic axis has no 0 */
#define MIN_ERROR 1.1102230246251565e-16

enum { LETTERS = 26, LEVEL_STEP = 3 /* [decade] between errors whose fastest method is named */ };

char precision_letter(int curve)
{
    if (curve < LETTERS)
        return (char)('a' + curve);
    return curve < 2 * LETTERS ? (char)('A' + curve - LETTERS) : '?';
}

/* Returns the mark of the settings of a method that failed: its capital letter, or '!' if capitals
 * are letters of other curves. */
static char failure_letter(const struct precision *precision, int curve)
{
    return precision->curves > LETTERS ? '!' : (char)('A' + curve);
}

/* ---- where the marks are ---- */

/* Returns true if the horizontal axis is time, false if it is evaluations because nothing was timed
 * or the user asked for them. */
static bool is_over_time(const struct precision *precision)
{
    for (int i = 0; i < precision->points && !precision->by_evals; i++)
        if (isfinite(precision->point[i].time.minimum))
            return true;
    return false;
}

/* Returns the shortest time of an evaluation of the method in its timed points [s], or NAN. */
static double evaluation_seconds(const struct precision *precision, int curve)
{
    double least = NAN;
    for (int i = 0; i < precision->points; i++)
        if (precision->point[i].curve == curve)
            least = fmin(least,
                         precision->point[i].time.minimum / (double)precision->point[i].cost.evals);
    return least;
}

/* Returns the horizontal position of a point: its computing time [s] if `timed` is set, else its
 * number of evaluations. For a solve that was given up both are extrapolated to the whole duration.
 * Returns NAN if unknown. */
static double point_work(const struct precision *precision, const struct precision_point *point,
                         bool timed)
{
    const double evals = (double)point->cost.evals / point->part;
    double work = evals;
    if (timed && precision_meaningful(point))
        work = point->time.minimum;
    else if (timed)
        work = point->seconds > 0 ? point->seconds / point->part
                                  : evals * evaluation_seconds(precision, point->curve);
    return work > 0 && isfinite(work) ? work : NAN;
}

/* Returns the height at which failed settings are drawn: the power of ten above all errors. */
static double failure_height(const struct precision *precision)
{
    double top = 0;
    for (int i = 0; i < precision->points; i++)
        if (precision_meaningful(&precision->point[i]))
            top = fmax(top, precision->point[i].errors.max);
    if (!(top > 0))
        return 1;
    return pow(10, ceil(log10(top)) + (top > 0.1 ? 1 : 0));
}

/* A diagram while it is made. */
struct diagram {
    const struct precision *precision;
    struct arena *arena;
    bool timed;               /* the horizontal axis is time [s], otherwise evaluations */
    double top;               /* height at which failed settings are drawn */
    double work[2], error[2]; /* smallest and largest value on either axis */
    /* [2 * curves] first those of the methods, then those of their failed settings */
    struct curve *curve;
    struct figure_guide *guide;
    struct figure_label *label;
    int guides, labels; /* number of entries of the arrays above */
};

/* Extends the range so that it holds the value. */
static void range_extend(double range[2], double value)
{
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

/* Fills two curves of the diagram of error over work for method c: its valid points, and its failed
 * settings as marks at the top edge. Extends the ranges d->work and d->error by them. Returns false
 * if out of memory. */
static bool add_method(struct diagram *d, int c)
{
    const struct precision *precision = d->precision;
    const struct precision_curve *source = &precision->curve[c];
    const size_t n = (size_t)source->count + 1;
    double *x = arena_array(d->arena, 4 * n, sizeof *x), *y = x + n, *failed_x = x + 2 * n,
           *failed_y = x + 3 * n;
    if (!x)
        return false;
    struct curve *curve = &d->curve[c], *failed = &d->curve[precision->curves + c];
    *curve =
        (struct curve){.x = x, .y = y, .points = true, .joined = true, .mark = precision_letter(c)};
    *failed = (struct curve){.x = failed_x,
                             .y = failed_y,
                             .points = true,
                             .mark = failure_letter(precision, c),
                             .look = c + 1};
    for (int i = source->first; i < source->first + source->count; i++) {
        const struct precision_point *point = &precision->point[i];
        const double work = point_work(precision, point, d->timed);
        if (isnan(work))
            continue;
        range_extend(d->work, work);
        if (precision_meaningful(point)) {
            x[curve->n] = work;
            y[curve->n] = fmax(point->errors.max, MIN_ERROR);
            range_extend(d->error, y[curve->n++]);
        } else {
            failed_x[failed->n] = work;
            failed_y[failed->n++] = d->top;
        }
    }
    return true;
}

/* ---- guides and labels ---- */

/* Adds the line of slope -order of a method, through the centre of its fitted points, unless
 * nothing was fitted. */
static void add_slope(struct diagram *d, int c)
{
    const struct precision_curve *source = &d->precision->curve[c];
    const double order = source->choice.method->order, excess = 1.6;
    double x = 0, y = 0, range[2] = {HUGE_VAL, 0};
    int n = 0;
    for (int i = source->first; i < source->first + source->count; i++) {
        const struct precision_point *point = &d->precision->point[i];
        const double work = point_work(d->precision, point, d->timed);
        if (!point->asymptotic || isnan(work))
            continue;
        x += log(work);
        y += log(point->errors.max);
        range_extend(range, work);
        n++;
    }
    if (n == 0 || !(order > 0) || isnan(source->expected))
        return;
    struct figure_guide *guide = &d->guide[d->guides++];
    for (int end = 0; end < 2; end++) {
        guide->x[end] = end ? range[1] * excess : range[0] / excess;
        guide->y[end] = exp(y / n - order * (log(guide->x[end]) - x / n));
    }
}

/* Labels the fastest method for an error, with those that tie, at its time (or evaluations) and
 * joins tied ones by a line. With `named`, labels have names instead of letters. Returns false if
 * out of memory. */
static bool add_fastest(struct diagram *d, double error, bool named)
{
    const struct precision *precision = d->precision;
    const int shown_max = named ? 2 : 3; /* the table below has the others */
    struct precision_cost *cost =
        arena_array(d->arena, (size_t)precision->curves + 1, sizeof *cost);
    struct buffer text = {0};
    if (!cost)
        return false;
    const int ranked = precision_fastest(precision, error, cost, NULL);
    int tied = 1;
    while (d->timed && tied < ranked && cost[tied].tied)
        tied++;
    const double first = d->timed ? cost[0].minimum : cost[0].evals;
    if (ranked == 0 || !(first > 0) || (!d->timed && precision->by_evals && isnan(first)))
        return true;
    for (int i = 0; i < tied && i < shown_max; i++) {
        const char letter[2] = {precision_letter(cost[i].curve), '\0'};
        buffer_format(&text, "%s%s", i ? named ? " = " : "=" : "",
                      named ? precision->curve[cost[i].curve].choice.method->row.name : letter);
    }
    if (tied > shown_max && named)
        buffer_format(&text, " = %d more", tied - shown_max);
    else if (tied > shown_max)
        buffer_char(&text, '+');
    d->label[d->labels++] =
        (struct figure_label){first, error, arena_text(d->arena, buffer_text(&text))};
    buffer_free(&text);
    if (tied > 1)
        d->guide[d->guides++] =
            (struct figure_guide){{first, cost[tied - 1].minimum}, {error, error}, false};
    return d->label[d->labels - 1].text != NULL;
}

/* Allocates guides and labels and labels the fastest method of every third decade of error. Returns
 * false if out of memory. */
static bool add_labels(struct diagram *d, bool named)
{
    const int levels = 16 / LEVEL_STEP + 1; /* no error is below 1e-16 */
    d->guide = arena_array(d->arena, (size_t)(d->precision->curves + levels + 1), sizeof *d->guide);
    d->label = arena_array(d->arena, (size_t)levels, sizeof *d->label);
    bool ok = d->guide && d->label;
    for (int level = LEVEL_STEP; level < 16 && ok; level += LEVEL_STEP)
        ok = add_fastest(d, pow(10, -level), named);
    return ok;
}

/* Moves the left end of the time axis so far that every label has room, assuming a picture of the
 * usual size (`named`) or a text figure of 80 columns. */
static void make_room(struct diagram *d, bool named)
{
    /* Width of a letter as a fraction of the width of the figure, letters of space behind a label,
     * and the largest fraction that a label may take. */
    const double letter = named ? 0.0105 : 1.0 / 66, margin = 2.5, part_max = 0.6;
    const double upper = log10(d->work[1]);
    double lower = log10(d->work[0]);
    for (int i = 0; i < d->labels; i++) {
        const double part =
            fmin(letter * (text_width(text_of(d->label[i].text)) + margin), part_max);
        lower = fmin(lower, (log10(d->label[i].x) - part * upper) / (1 - part));
    }
    d->work[0] = pow(10, lower);
}

/* Adds the shaded band of errors below the accuracy of the reference, and the slopes of the orders
 * where there is room for them. */
static void add_guides(struct diagram *d, bool named)
{
    const struct precision *precision = d->precision;
    enum { SLOPES_MAX = 4 /* methods whose slopes a text figure has room for */ };
    if (precision->reference.accuracy > d->error[0])
        d->guide[d->guides++] = (struct figure_guide){
            {d->work[0], d->work[1]}, {d->error[0], precision->reference.accuracy}, true};
    for (int c = 0; c < precision->curves && (named || precision->curves <= SLOPES_MAX); c++)
        add_slope(d, c);
}

/* Returns the note below the diagram, or NULL if out of memory: the reasons, at most 8 different
 * ones, for which points have no error (these points are marks at the top, or capital letters in a
 * diagram of characters, where `named` is false), the shade, and the thin lines of a picture. */
static const char *diagram_note(const struct diagram *d, bool named)
{
    const struct precision *precision = d->precision;
    const char *where = named ? "at the top: " : "capitals: ", *seen[8];
    struct buffer text = {0};
    int count = 0;
    for (int i = 0; i < precision->points; i++) {
        const char *why = precision_failure(precision, &precision->point[i]);
        int k = 0;
        while (k < count && strcmp(seen[k], why) != 0)
            k++;
        if (*why && k == count && count < (int)COUNT_OF(seen))
            seen[count++] = why;
    }
    for (int i = 0; i < count; i++)
        buffer_format(&text, "%s%s", i ? ", " : where, seen[i]);
    const char *shaded = precision->reference.exact ? "rounding" : "below the reference";
    if (precision->reference.accuracy > d->error[0])
        buffer_format(&text, "%sshaded: %s", text.len ? "; " : "", shaded);
    if (named)
        buffer_format(&text, "%sthin: slopes of the orders", text.len ? "; " : "");
    const char *note = arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return note;
}

/* Returns the diagram described in sentences for screen readers, with the fastest method for each
 * labelled error, or NULL if out of memory. */
static const char *diagram_words(const struct diagram *d)
{
    const struct precision *precision = d->precision;
    const char *unit = d->timed ? " s" : "";
    struct buffer text = {0};
    buffer_format(&text,
                  "error from %.2g to %.2g against %s from %.2g to %.2g%s, both logarithmic,",
                  d->error[0], d->top, d->timed ? "the time of a solve" : "evaluations", d->work[0],
                  d->work[1], unit);
    for (int c = 0; c < precision->curves; c++)
        buffer_format(&text, "%s %s", c ? "," : " of", precision->curve[c].choice.method->row.name);
    buffer_char(&text, '.');
    for (int i = 0; i < d->labels; i++)
        buffer_format(&text, " For an error of %.0e %s: %s, %.3g%s.", d->label[i].y,
                      d->timed ? "fastest" : "fewest evaluations", d->label[i].text, d->label[i].x,
                      unit);
    const char *words = arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return words;
}

/* ---- the figure ---- */

/* Draws the diagram into *figure, with memory from the arena. If `named`, labels have names of
 * methods instead of letters, as pictures need. Returns false with an error if out of memory. */
static bool make_diagram(const struct precision *precision, bool named, struct arena *arena,
                         struct figure *figure, struct error *error)
{
    const size_t curves = 2 * (size_t)precision->curves;
    struct diagram d = {.precision = precision,
                        .arena = arena,
                        .timed = is_over_time(precision),
                        .top = failure_height(precision),
                        .work = {HUGE_VAL, 0},
                        .error = {HUGE_VAL, 0},
                        .curve = arena_array(arena, curves + 1, sizeof *d.curve)};
    bool ok = d.curve != NULL;
    for (int c = 0; c < precision->curves && ok; c++)
        ok = add_method(&d, c);
    if (d.work[1] == 0)
        d.work[0] = d.work[1] = 1;
    if (d.error[1] == 0)
        d.error[0] = d.error[1] = d.top / 10;
    const double air = fmax(log10(d.work[1] / d.work[0]), 1); /* 3 % of the width on either side */
    d.work[0] /= pow(10, 0.03 * air);
    d.work[1] *= pow(10, 0.03 * air);
    d.error[0] = pow(10, floor(log10(d.error[0] * 1.001)));
    if (!ok || !add_labels(&d, named))
        return error_memory(error);
    make_room(&d, named);
    add_guides(&d, named);
    *figure = (struct figure){.title = "precision",
                              .curve = d.curve,
                              .curves = (int)curves,
                              .x = {.label = d.timed ? "time of a solve" : "evaluations",
                                    .unit = d.timed ? "s" : "",
                                    .log = true,
                                    .fixed = true,
                                    .first_value = d.work[0],
                                    .last_value = d.work[1]},
                              .y = {.label = "error",
                                    .log = true,
                                    .fixed = true,
                                    .first_value = d.error[0],
                                    .last_value = 1.8 * d.top},
                              .plane = true,
                              .note = diagram_note(&d, named),
                              .words = diagram_words(&d),
                              .caption = precision->reference.exact ? "against the closed form"
                                                                    : "against two methods",
                              .guide = d.guide,
                              .guides = d.guides,
                              .label = d.label,
                              .labels = d.labels};
    return true;
}

bool precision_figure(const struct precision *precision, struct arena *arena, struct figure *figure,
                      struct error *error)
{
    return make_diagram(precision, false, arena, figure, error);
}

bool precision_known(const struct session *session)
{
    return session_precision(session);
}

/* Draws the diagram of the last precision study into *figure. */
bool precision_plot(struct drawing *d, struct figure *figure)
{
    const struct precision *precision = session_precision(d->session);
    if (!precision) {
        error_set(d->error, ERROR_COMMAND, "there is no precision study to plot");
        return error_hint(d->error, "type: precision");
    }
    return precision_figure(precision, d->arena, figure, d->error);
}

void precision_plot_legend(const struct session *session, int width, struct buffer *text)
{
    precision_legend(session_precision(session), width, text);
}

/* Changes a figure made by precision_plot(), whose curves are marked by letters, for a picture,
 * which has room for names: curves get the names of their methods as labels, and the figure the
 * notes, guides and labels of a diagram with names. Returns false if out of memory. */
bool precision_name_curves(const struct session *session, struct arena *arena,
                           struct figure *figure, struct error *error)
{
    const struct precision *precision = session_precision(session);
    struct figure named;
    struct curve *curve = arena_array(arena, (size_t)figure->curves, sizeof *curve);
    if (!curve || !make_diagram(precision, true, arena, &named, error))
        return error_memory(error);
    memcpy(curve, figure->curve, (size_t)figure->curves * sizeof *curve);
    for (int i = 0; i < precision->curves; i++) {
        if (!curve[i].label)
            curve[i].label = precision->curve[i].choice.method->row.name;
        curve[precision->curves + i].mark = '*'; /* a picture has the method's mark, no letter */
    }
    figure->curve = curve;
    figure->x.first_value = named.x.first_value;
    figure->note = named.note;
    figure->words = named.words;
    figure->guide = named.guide;
    figure->guides = named.guides;
    figure->label = named.label;
    figure->labels = named.labels;
    return true;
}
