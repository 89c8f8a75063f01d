/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Picture files of random sessions, read as a person reads them: from the numbers beside the ticks
 * and the unit in the title of an axis. Every line of a curve lies on the samples of its run, every
 * mark on one of its recording, every sample lies on the line or under a mark: against time and in
 * the phase plane, forwards and backwards, on linear and on logarithmic axes.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/axes_testing.h"
#include "unit/command/testing.h"
#include "modules/pictures/svg_testing.h"
#include <hooke/data.h>
#include <hooke/plot/drawing.h>

#define POINTS 60000
/* [pt] a point of a path to the samples */
#define NEAR 0.1
/* [pt] a sample to a mark: of dense data there is one for each eighth of a point */
#define MARKED 0.2
/* [pt] a sample to the path: what passes beside ink is left out, in grains of a twelfth of a point
 */
#define INK 0.225

/* ---- axes and paths ---- */

struct path {
    double x[POINTS], y[POINTS];
    bool joined[POINTS]; /* to the point before */
    bool marks;          /* circles, or lines without length */
    int n;
    int curve; /* by its color */
};

struct panel {
    double left, right, top, bottom;
    struct read_axis x, y;
    int paths, first; /* of the sheet */
};

#define PATHS 12

struct sheet {
    struct path path[PATHS];
    int paths;
    struct panel panel[3];
    int panels;
};

static int curve_of_color(const char *stroke)
{
    static const char *const colors[] = {"#0072b2", "#1a1a1a", "#e69f00", "#009e73"};
    for (int i = 0; i < (int)COUNT_OF(colors); i++)
        if (strcmp(stroke, colors[i]) == 0)
            return i;
    return -1;
}

/* Marks: circles, or lines without length. */
static bool are_marks(const struct svg_path *path)
{
    for (int i = 0; i < path->n; i++)
        if (path->joined[i] && (path->x[i] != path->x[i - 1] || path->y[i] != path->y[i - 1]))
            return false;
    return true;
}

/* "y − 2.2 cm [10⁻³ cm]": the unit with its power, and the offset in it. */
static void read_title(const char *title, struct read_axis *axis)
{
    static const struct {
        const char *name;
        double value;
    } units[] = {{"m", 1},     {"cm", 1e-2},     {"mm", 1e-3},     {"µm", 1e-6},
                 {"nm", 1e-9}, {"s", 1},         {"ms", 1e-3},     {"J", 1},
                 {"mJ", 1e-3}, {"µJ", 1e-6},     {"nJ", 1e-9},     {"kJ", 1e3},
                 {"m·s⁻¹", 1}, {"cm·s⁻¹", 1e-2}, {"mm·s⁻¹", 1e-3}, {"µm·s⁻¹", 1e-6}};
    const char *bracket = strrchr(title, '['), *unit = bracket ? bracket + 1 : "";
    double power = 1;
    axis->unit = 1;
    axis->offset = 0;
    if (strncmp(unit, "10", 2) == 0) {
        power = svg_value(unit);
        unit += strcspn(unit, " ]");
        unit += *unit == ' ';
    }
    bool known = !bracket;
    for (size_t i = 0; i < COUNT_OF(units); i++)
        if (strcspn(unit, "]") == strlen(units[i].name) &&
            strncmp(unit, units[i].name, strlen(units[i].name)) == 0) {
            axis->unit = units[i].value * power;
            known = true;
        }
    /* not read */
    if (!known)
        axis->n = 0;
    const char *minus = strstr(title, " − "), *plus = strstr(title, " + ");
    if (minus || plus)
        axis->offset =
            strtod(minus ? minus + strlen(" − ") : plus + 3, NULL) * (minus ? 1 : -1) / power;
}

static void add_tick(struct read_axis *axis, double at, const char *label)
{
    if (axis->n == TICKS_MAX)
        return;
    axis->at[axis->n] = at;
    axis->value[axis->n++] = svg_value(label);
}

/* The labels in the middle stand where logarithms put them; of two, both are powers of ten. */
static bool is_log(const struct read_axis *axis)
{
    struct read_axis log = *axis;
    const int last = axis->n - 1, middle = axis->n / 2;
    double reach;
    if (axis->n < 2 || !(axis->value[0] > 0) || !(axis->value[last] > 0) || axis->offset != 0)
        return false;
    const double decades = log10(axis->value[last] / axis->value[0]);
    if (last == 1)
        return fabs(decades) > 0.5 && fabs(decades - round(decades)) < 1e-6;
    log.log = true;
    const double value = axis->value[middle] * axis->unit;
    return fabs(read_place(&log, value, &reach) - axis->at[middle]) <
           fabs(read_place(axis, value, &reach) - axis->at[middle]);
}

/* Everything between two frames of a file: grid and curves, then the frame, then ticks and titles.
 */
static void read_sheet(const char *svg, struct sheet *sheet)
{
    static struct svg_path path;
    struct svg_element element;
    struct panel *panel = NULL;
    struct read_axis *tick = NULL; /* whose label comes next */
    double at_tick = 0;
    int titles = 0, begun = 0;
    sheet->paths = sheet->panels = 0;
    for (const char *at = NULL; svg_next(svg, &at, &element, &path);) {
        const bool black = strcmp(element.stroke, "#000000") == 0 && !element.filled;
        if (element.is_text) {
            if (tick)
                add_tick(tick, at_tick, element.text);
            else if (panel && titles < 2)
                read_title(element.text, titles++ == 0 ? &panel->y : &panel->x);
            tick = NULL;
            continue;
        }
        tick = NULL;
        if (curve_of_color(element.stroke) >= 0 && !element.filled && sheet->paths < PATHS) {
            struct path *kept = &sheet->path[sheet->paths++];
            assert_true(path.n <= POINTS);
            memcpy(kept->x, path.x, sizeof kept->x);
            memcpy(kept->y, path.y, sizeof kept->y);
            memcpy(kept->joined, path.joined, sizeof kept->joined);
            kept->n = path.n;
            kept->marks = are_marks(&path);
            kept->curve = curve_of_color(element.stroke);
        } else if (black && path.n >= 4 && sheet->panels < 3) {
            panel = &sheet->panel[sheet->panels++];
            *panel = (struct panel){.left = path.x[0],
                                    .right = path.x[1],
                                    .top = path.y[0],
                                    .bottom = path.y[2],
                                    .first = begun,
                                    .paths = sheet->paths - begun};
            begun = sheet->paths;
            titles = 0;
        } else if (black && panel && path.n == 2) {
            const bool vertical = path.y[0] == path.y[1];
            struct read_axis *axis = vertical ? &panel->y : &panel->x;
            const double length = fabs(vertical ? path.x[1] - path.x[0] : path.y[1] - path.y[0]);
            tick = length < 3 ? NULL : axis;
            at_tick = vertical ? path.y[0] : path.x[0];
        }
    }
    for (int i = 0; i < sheet->panels; i++) {
        sheet->panel[i].x.log = is_log(&sheet->panel[i].x);
        sheet->panel[i].y.log = is_log(&sheet->panel[i].y);
    }
    for (int i = sheet->panels - 2; i >= 0; i--)
        if (sheet->panel[i].x.n == 0) /* labels of a common axis stand below the lower panel */
            sheet->panel[i].x = sheet->panel[i + 1].x;
}

/* ---- samples ---- */

struct picture_samples {
    double *x, *y, *t;
    size_t n;
    double from, to; /* [s] all of this is to be seen */
};

static double *column_of(const struct run *run, const char *name)
{
    struct error error;
    double *out = malloc(trace_count(run->trace) * sizeof *out);
    const struct observable *what = (const void *)catalog_find(&observable_catalog, text_of(name));
    assert_non_null(out);
    assert_non_null(what);
    assert_true(run_column(run, what, out, &error));
    return out;
}

static double segment_distance(double x, double y, const double a[2], const double b[2])
{
    const double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    double part = square > 0 ? ((x - a[0]) * dx + (y - a[1]) * dy) / square : 0;
    part = fmin(fmax(part, 0), 1);
    return hypot(x - a[0] - part * dx, y - a[1] - part * dy);
}

static bool in_panel(const struct panel *panel, const double at[2])
{
    return at[0] >= panel->left && at[0] <= panel->right && at[1] >= panel->top &&
           at[1] <= panel->bottom;
}

/* Places are known to half of 0.01 pt: within the outermost ticks and a little
 * beyond. */
static bool agrees(const struct panel *panel, const struct path *path,
                   const struct picture_samples *series, char problem[200])
{
    const size_t n = series->n;
    double(*spot)[2] = malloc(n * sizeof *spot), reach;
    bool fine = true;
    assert_non_null(spot);
    for (size_t i = 0; i < n; i++) {
        spot[i][0] = read_place(&panel->x, series->x[i], &reach);
        spot[i][1] = read_place(&panel->y, series->y[i], &reach);
    }
    for (int p = 0; p < path->n && fine; p += 1 + path->n / 500) {
        const double at[2] = {path->x[p], path->y[p]};
        double min = HUGE_VAL;
        for (size_t i = 0; i < n && in_panel(panel, at) && min > NEAR; i++)
            min = fmin(min, segment_distance(at[0], at[1], spot[i > 0 && !path->marks ? i - 1 : i],
                                             spot[i]));
        if (min > NEAR && in_panel(panel, at)) {
            fine = false;
            snprintf(problem, 200, "line at %.2f, %.2f pt, %.2f pt from any sample", at[0], at[1],
                     min);
        }
    }
    const double within = path->marks ? MARKED : INK;
    for (size_t i = 0; i < n && fine; i += 1 + n / 300) {
        double min = HUGE_VAL;
        if (!in_panel(panel, spot[i]) || series->t[i] < series->from || series->t[i] > series->to)
            continue;
        for (int p = 0; p < path->n && min > within; p++) {
            const double to[2] = {path->x[p], path->y[p]};
            const double from[2] = {path->x[p - (p > 0)], path->y[p - (p > 0)]};
            min = fmin(min,
                       segment_distance(spot[i][0], spot[i][1], path->joined[p] ? from : to, to));
        }
        if (min > within) {
            fine = false;
            snprintf(problem, 200,
                     "nothing at %g, %g: the axes put it at %.2f, %.2f pt, %.2f pt from the line",
                     series->x[i], series->y[i], spot[i][0], spot[i][1], min);
        }
    }
    free(spot);
    return fine;
}

/* ---- random sessions ---- */

static void say(struct bench *bench, char told[1000], const char *line)
{
    snprintf(told + strlen(told), 1000 - strlen(told), "%s; ", line);
    type_ok(bench, line);
}

/* What a session is made of. */
struct made {
    int runs;      /* 0: only a recording is drawn */
    bool recorded; /* a recording is named in the plots */
    bool spring;   /* its exact solution is known: errors can be drawn */
    char told[1000];
};

static void make_session(struct bench *bench, struct dice *dice, struct made *made)
{
    static const char *const methods[] = {"euler", "symplectic-euler", "verlet", "rk4",
                                          "backward-euler"};
    static const char *const scenes[] = {"spring", "damped", "driven", "drag", "duffing"};
    const int scene = dice_below(dice, (int)COUNT_OF(scenes));
    char line[200];
    *made = (struct made){.runs = dice_below(dice, 4), .spring = scene == 0};
    made->recorded = made->runs == 0 || dice_below(dice, 3) == 0;
    snprintf(line, sizeof line, "scene %s", scenes[scene]);
    say(bench, made->told, line);
    for (int i = 0; i < made->runs; i++) {
        /* backwards drag of the square has a pole */
        const bool back = scene < 3 && dice_below(dice, 4) == 0;
        snprintf(line, sizeof line, "method %s dt=%.3g ms; y0 = %.3g m; run %.3g s",
                 methods[dice_below(dice, (int)COUNT_OF(methods))], dice_between(dice, 2, 20),
                 exp(dice_between(dice, log(1e-3), log(3))),
                 exp(dice_between(dice, log(1), log(40))) * (back ? -0.2 : 1));
        say(bench, made->told, line);
    }
    if (made->recorded) {
        write_swing(dice, "swing.txt");
        say(bench, made->told, "load swing.txt");
    }
}

enum kind { POSITION, VELOCITY, ENERGY, ERROR, PHASE, KINDS };

static const char *const kind_names[] = {"position", "velocity", "energy", "error", "phase"};

static bool is_drawn(const struct made *made, enum kind kind)
{
    return made->runs > 0 ? kind != ERROR || made->spring : kind == POSITION;
}

static void plot_line(struct dice *dice, const struct made *made, enum kind kind, char line[200])
{
    int n = snprintf(line, 200, "plot %s%s", kind_names[kind], made->runs ? " run" : "");
    for (int i = 1; i <= made->runs; i++)
        n += snprintf(line + n, 200 - (size_t)n, " %d", i);
    if (made->recorded && kind == POSITION)
        n += snprintf(line + n, 200 - (size_t)n, " data swing");
    if (dice_below(dice, 4) == 0 && kind != PHASE && !made->recorded)
        n += snprintf(line + n, 200 - (size_t)n, " x=%.3g:%.3g", dice_between(dice, -1, 0),
                      dice_between(dice, 0.5, 5));
    if (dice_below(dice, 5) == 0 && kind != PHASE)
        n += snprintf(line + n, 200 - (size_t)n, " y=%.3g:%.3g", -dice_between(dice, 0.001, 1),
                      dice_between(dice, 0.001, 1));
    if ((kind == ENERGY || kind == ERROR) && dice_below(dice, 3) == 0 && !strstr(line, "y="))
        n += snprintf(line + n, 200 - (size_t)n, " --log");
    if (dice_below(dice, 6) == 0)
        n += snprintf(line + n, 200 - (size_t)n, " --full");
    if (dice_below(dice, 2))
        n += snprintf(line + n, 200 - (size_t)n, " size=%.1fx%.1f", dice_between(dice, 8, 40),
                      dice_between(dice, 6, 30));
    snprintf(line + n, 200 - (size_t)n, " > figure.svg --force");
}

/* ---- what a curve has to hold ---- */

static struct picture_samples recording_samples(const struct recording *recording)
{
    struct picture_samples out = {.from = -HUGE_VAL, .to = HUGE_VAL};
    struct arena arena = {0};
    struct series series;
    struct error error;
    assert_true(recording_series(recording, &arena, 1, &series, &error));
    out.n = series.n;
    out.x = malloc(series.n * sizeof *out.x);
    out.y = malloc(series.n * sizeof *out.y);
    assert_true(out.x && out.y);
    memcpy(out.x, series.t, series.n * sizeof *out.x);
    memcpy(out.y, series.y, series.n * sizeof *out.y);
    out.t = out.x;
    arena_reset(&arena);
    return out;
}

/* Of the phase plot the last two periods of each run, wherever it ended; of everything else all. */
static struct picture_samples run_samples(const struct bench *bench, enum kind kind, int index,
                                          const char *line)
{
    static const char *const columns[] = {"y", "v", "energy", "error", "v"};
    const struct run *run = bench->session->runs.slot[index]->run,
                     *first = bench->session->runs.slot[0]->run;
    struct picture_samples out = {.t = column_of(run, "t"),
                                  .y = column_of(run, columns[kind]),
                                  .n = trace_count(run->trace),
                                  .from = -HUGE_VAL,
                                  .to = HUGE_VAL};
    out.x = kind == PHASE ? column_of(run, "y") : out.t;
    for (size_t i = 0; i < out.n && kind == ERROR && strstr(line, "--log"); i++)
        out.y[i] = fabs(out.y[i]);
    if (kind == PHASE) {
        const double stiffness = first->system.oscillator.stiffness;
        for (size_t i = 0; i < out.n && stiffness > 0; i++)
            out.y[i] /= sqrt(stiffness);
        const double end = out.t[out.n - 1], trail = 2 * run_rhythm(first) * (1 - 1e-9);
        const bool all = strstr(line, "--full") || isnan(trail);
        out.from = all ? -HUGE_VAL : end < out.t[0] ? end : end - trail;
        out.to = all ? HUGE_VAL : end < out.t[0] ? end + trail : end;
    }
    return out;
}

/* Curves read off the picture. */
static int check_picture(struct bench *bench, enum kind kind, const struct made *made,
                         const char *line)
{
    static struct sheet sheet;
    FILE *file = fopen("figure.svg", "rb");
    char *svg = NULL, problem[200];
    size_t size = 0;
    int read = 0;
    bool seen[PATHS] = {false}, readable = true;
    assert_non_null(file);
    assert_true(getdelim(&svg, &size, '\0', file) > 0);
    assert_int_equal(fclose(file), 0);
    read_sheet(svg, &sheet);
    if (sheet.panels < 1)
        fail_msg("%sthere is no frame", made->told);
    for (int p = 0; p < sheet.panels; p++) {
        const struct panel *panel = &sheet.panel[p];
        /* too few labels to read by */
        if (panel->x.n < 2 || panel->y.n < 2)
            readable = false;
        if (!readable)
            continue;
        if (!read_axis_is_even(&panel->x, 0.01) || !read_axis_is_even(&panel->y, 0.01))
            fail_msg("%sthe numbers of an axis do not stand at even distances", made->told);
        for (int i = panel->first; i < panel->first + panel->paths; i++) {
            const struct path *path = &sheet.path[i];
            /* of the legend */
            if (path->y[0] < panel->top - 4 || path->curve > made->runs)
                continue;
            const bool recorded = path->curve == made->runs;
            /* shapes along a line */
            if (recorded != path->marks)
                continue;
            const struct picture_samples series =
                recorded ? recording_samples(bench->session->recording[0]->recording)
                         : run_samples(bench, kind, path->curve, line);
            if (!agrees(panel, path, &series, problem))
                fail_msg("%s%s %d: %s", made->told, recorded ? "recording" : "run", path->curve + 1,
                         problem);
            if (series.t != series.x)
                free(series.t);
            free(series.x);
            free(series.y);
            seen[path->curve] = true;
            read++;
        }
    }
    for (int c = 0; c < made->runs && readable && !strstr(line, "x=") && !strstr(line, "y="); c++)
        if (!seen[c] && trace_count(bench->session->runs.slot[c]->run->trace) > 2)
            fail_msg("%srun %d is not drawn", made->told, c + 1);
    free(svg);
    return read;
}

static void every_sample_is_where_the_axes_put_it(void **state)
{
    (void)state;
    const unsigned sessions = is_long() ? 200 : 16;
    int drawn[KINDS] = {0}, read[KINDS] = {0};
    for (unsigned seed = 1; seed <= sessions; seed++) {
        struct dice dice = {seed};
        struct bench bench;
        struct made made;
        bench_open(&bench, false);
        make_session(&bench, &dice, &made);
        const size_t before = strlen(made.told);
        for (enum kind kind = POSITION; kind < KINDS; kind++) {
            char line[200];
            if (!is_drawn(&made, kind))
                continue;
            made.told[before] = '\0';
            plot_line(&dice, &made, kind, line);
            say(&bench, made.told, line);
            read[kind] += check_picture(&bench, kind, &made, line);
            drawn[kind] += made.runs + (made.recorded && kind == POSITION);
        }
        bench_close(&bench);
    }
    for (enum kind kind = POSITION; kind < KINDS; kind++) {
        printf("# %s: %d curves, %d of them read off the file\n", kind_names[kind], drawn[kind],
               read[kind]);
        assert_true(read[kind] > drawn[kind] / 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_sample_is_where_the_axes_put_it, enter_folder,
                                        leave_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
