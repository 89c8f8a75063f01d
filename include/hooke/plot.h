/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * plot: figures of a session (runs, recordings, studies), the rows that describe plots, cursors,
 * and the comparison of a recording with a run. A study is a command that computes a table of
 * results from the scene, such as compare or sweep, which stores the table in the session.
 *
 * A caller fills a struct figure_request and calls session_figure(), which returns a struct figure
 * in the arena (<hooke/figure.h>). A new plot is a row of plot_catalog (src/plot/plots.c).
 */
#pragma once

#include <hooke/data/series.h>
#include <hooke/figure.h>
#include <hooke/session.h>

struct catalog;

/* ---- figures of the session ---- */

/* Plots that code refers to by name: the first rows of plot_catalog; further rows need no name
 * here. */
enum plot_kind {
    PLOT_POSITION,
    PLOT_ENERGY,
    PLOT_PHASE,
    PLOT_VELOCITY,
    PLOT_ERROR,
    PLOT_ORBIT, /* One coordinate or column against another. */
    PLOT_ACCELERATION,
};

/* Kind of the horizontal axis. */
enum plot_across { ACROSS_TIME, ACROSS_STATE, ACROSS_FREQUENCY, ACROSS_OTHER };
/* Variables on the vertical axis. VERTICAL_FIRST stands for positions, VERTICAL_RATE for velocities
 * (the second variable of a first-order scene), VERTICAL_SECOND for second derivatives. */
enum plot_vertical { VERTICAL_FIRST, VERTICAL_RATE, VERTICAL_SECOND };
/* Kind of values of a recording that a plot shows without conversion. */
enum plot_recorded { RECORDED_OTHER, RECORDED_POSITION, RECORDED_VELOCITY, RECORDED_ACCELERATION };

struct reply;
struct drawing; /* A figure that is being made, <hooke/plot/drawing.h>. */
struct figure_request;

/* The plane of a plot whose points are states of the scene, such as a portrait. */
struct plot_plane {
    const struct scene *scene; /* Scene that was drawn. */
    int variable[2];           /* Variables on the axes, the horizontal one first. */
    /* Ranges [SI] of these variables. */
    double box[2][2];
    double state[LIMIT_VARIABLES]; /* [SI] values of all variables, for those that are not shown. */
};

/* Functions of a plot on whose plane (struct plot_plane) the cursors move a point. */
struct plane_row {
    /* Fills *plane with the plane of the last figure of this plot. Returns false if no figure of
     * the current scene was drawn. */
    bool (*drawn)(const struct session *session, struct plot_plane *plane);
    /* Moves the point to the next (forward) or previous special state, such as an equilibrium.
     * Returns false with `error` set. */
    bool (*next)(const struct session *session, const struct plot_plane *plane, bool forward,
                 double point[2], struct error *error);
    /* Appends a description of the special state at the point, if there is one. */
    void (*say)(const struct session *session, const struct plot_plane *plane, struct buffer *text);
};

/* One kind of curves in a figure that is drawn from the table of a study; members name columns of
 * that table. */
struct study_layer {
    const char *y; /* Column on the vertical axis; NULL ends the layers. */
    /* Only rows with this word in the column "part" are drawn; NULL draws all rows. */
    const char *part;
    /* Column whose value is appended to the name of the curve in the legend, or NULL. */
    const char *value;
    const char *named; /* Name of the appended value, such as "slope". */
    double max;        /* Values above `max` are not drawn; 0 means no limit. */
    bool line;         /* A line with a gap at each row without numbers; otherwise points. */
    bool guide;        /* A thin straight line from the first to the last row with numbers. */
};

/* Largest number of layers of a study's figure. */
enum { STUDY_LAYERS_MAX = 4 };
/* Description of a figure that is drawn from the table of a study. */
struct study_picture {
    const char *table, *made_by; /* Kind of the table, and the command that makes it. */
    const char *x;               /* Column on the horizontal axis. */
    const char *group;           /* Column of names that distinguish curves, or NULL. */
    struct study_layer layer[STUDY_LAYERS_MAX];
    const char *shade; /* Column shown as shades over x and the first layer's y, or NULL. */
    const char *x_label, *y_label; /* Names of the axes, or NULL for those of the columns. */
    const char *note;              /* Explanation of the lines, or NULL. */
    bool log_x, log_y;             /* Logarithmic axes. */
    bool equal;                    /* A unit has the same length on both axes. */
};

/* A plot, which can also be a pane of the screen: a row of plot_catalog (src/plot/plots.c). Zero
 * members are the defaults. */
struct plot_row {
    struct row row;              /* Name of the plot, as in `plot NAME`. */
    enum plot_across horizontal; /* Kind of the horizontal axis. */
    enum plot_vertical vertical; /* Variables on the vertical axis, if it shows the state. */
    /* Observable on the vertical axis, or NULL for state variables or something else. */
    const char *observable;
    const char *label; /* Label of the vertical axis, or NULL for the names of the variables. */
    /* Label of the magnitude on a logarithmic axis, or NULL if the values do not have both signs.
     */
    const char *log_label;
    /* Title of the figure, and label of the vertical axis in a pane (NULL for the
     * usual label). */
    const char *title, *pane_label;
    /* Returns true if the plot makes sense for the model; NULL accepts any model. */
    bool (*fits)(const struct model *model);
    const char *needs; /* Property that models must have for fits(), for messages. */
    /* Returns true if the session has the data that the plot shows. If NULL, the plot needs a run
     * of a model that fits, or a recording that it can show. */
    bool (*offered)(const struct session *session);
    /* Kind of recorded values that the plot shows. */
    enum plot_recorded recorded;
    bool any_recording; /* The plot shows recordings of any quantity if there is no run. */
    bool of_motion;     /* Velocities are computed from the positions of a recording. */
    /* Draws the differences of a recording from a fit or a run (residuals); NULL for other plots.
     */
    bool (*residual)(struct drawing *d, const struct recording *recording);
    /* The plot shows results of a study instead of runs; making its figure fails without them. */
    bool of_study;
    /* Command for which `> FILE.svg` writes this plot; NULL stands for the command with the name of
     * the plot, if there is one. */
    const char *command;
    /* Description by which the table of the study is drawn, instead of by figure(); or NULL. */
    const struct study_picture *picture;
    /* Executes the study: computes its table, as records of the reply, for method [methods], which
     * are rows of method_catalog. With methods = 0 it takes the methods that were studied last, or
     * the current method. NULL if no methods may follow the plot's name. Returns false with `error`
     * set. */
    bool (*study)(struct session *session, const struct row *const *method, int methods,
                  struct reply *reply, struct error *error);
    bool whole;    /* The axes always contain all points; options for ranges are refused. */
    bool of_scene; /* The plot shows the scene, and a run of the scene if there is one. */
    /* run_curve() makes the curve of a run; if NULL, curves are variables or the observable.
     * data_curve() makes the curve of a recording; if NULL, the curve is the series. figure(), if
     * not NULL, makes the whole figure, and the other two are not called. All return false with
     * d->error set. */
    bool (*run_curve)(struct drawing *d, const struct run *run, struct curve *curve);
    bool (*data_curve)(struct drawing *d, const struct series *series, struct curve *curve);
    bool (*figure)(struct drawing *d, struct figure *figure);
    /* Appends the plot's own note; NULL if it has none. */
    void (*note)(const struct drawing *d, struct buffer *text);
    /* Returns the horizontal axis if it is not the usual one, or NULL. */
    struct axis (*axis)(const struct drawing *d);
    /* Functions for the point of the cursors; NULL if points are not states. */
    const struct plane_row *plane;
    /* Replies with the numbers that the figure shows; NULL if the plot has none. */
    void (*reply)(const struct session *session, const struct figure_request *request,
                  struct reply *reply);
    /* Gives names to curves that only have marks, for pictures and words; may be NULL. */
    bool (*name_curves)(const struct session *session, struct arena *arena, struct figure *figure,
                        struct error *error);
    /* Appends lines, `width` cells wide, that are shown below a text figure; may be NULL. */
    void (*legend)(const struct session *session, int width, struct buffer *text);
    const char *planned; /* Line that `plan` adds while this plot's pane has the focus, or NULL. */
    bool takes_column;   /* The name of a column, to be drawn, may follow the name of the plot. */
    bool coordinates;    /* All coordinates of one quantity are drawn on one axis. */
    /* The plot shows the total energy or, if some of its runs have no potential, the kinetic
     * energy of all. */
    bool energy;
    bool scaled; /* The setting phase-axes applies, by which v/omega0 can be drawn instead of v. */
    bool equal;  /* A unit has the same length on both axes. */
    /* Each period has to be visible, so that the window is limited to the number of periods that
     * the width can show. */
    bool periods;
    bool positive; /* Values are never negative; curves of different size get a logarithmic axis. */
    bool from_zero; /* The vertical range includes zero, without a line. */
    bool flat;      /* The vertical range includes zero if the curves hardly vary. */
    /* Some layout of the screen contains the plot. A plot that is in no layout replaces the first
     * pane while it has the focus. */
    bool in_layouts;
};

/* All plots: struct plot_row, the first at the index of enum plot_kind. */
extern const struct catalog plot_catalog;
/* The same rows for arguments that name a pane, so that errors speak of panes. */
extern const struct catalog pane_catalog;

/* Returns the row of a plot. */
const struct plot_row *plot_row(enum plot_kind kind);
bool plot_is_timed(enum plot_kind kind); /* Returns true if the horizontal axis is the time. */
/* Returns true if the plot shows state variables against each other. */
bool plot_is_plane(enum plot_kind kind);
/* Returns true if the vertical axis shows state variables. */
bool plot_shows_state(enum plot_kind kind);
bool plot_of_recordings(enum plot_kind kind); /* Returns true if the plot can show recordings. */
/* Returns true if the plot makes sense for a model: not every model has velocities or a second
 * coordinate. */
bool plot_fits(enum plot_kind kind, const struct model *model);
/* Returns true if the session has what the plot shows; an error plot, for example, needs a
 * reference. */
bool plot_offered(const struct session *session, enum plot_kind kind);
/* Returns the quantity on the horizontal (`x` true) or vertical axis of the plot of the session's
 * run or scene. */
enum quantity plot_quantity(const struct session *session, enum plot_kind kind, bool x);

/* Return, and set, the focus: the plot on whose pane commands and zooming act. */
enum plot_kind view_focus(const struct view *view);
void view_focus_on(struct view *view, enum plot_kind kind);

/* A window of time that several plots share. */
struct figure_window {
    struct axis axis;    /* Common time axis, fixed. */
    double shown, total; /* Duration [s] of the window, and of all the time that could be shown. */
};

/* Range that the user gives for an axis. At an open end the axis ends with the curves; if both ends
 * are open the axis shows exactly the range of the curves. */
struct figure_range {
    double end[2]; /* Ends, NAN if open. */
    /* Quantity of the unit that was given, or QUANTITY_OTHER if the axis decides. */
    enum quantity quantity;
    struct text text; /* Text as typed, for messages. */
};

/* One side of a portrait: a variable and its range [SI]. */
struct figure_side {
    int variable;    /* Index of the variable in the state. */
    double range[2]; /* Begin and end. */
};

#define PEAKS_EACH 3 /* Largest number of peaks (lines) that are reported of one spectrum. */
#define PEAKS_MAX 16 /* Largest number of peaks that are reported of all spectra of a figure. */

/* A peak of a spectrum that was drawn, also called a line. */
struct figure_peak {
    const char *label; /* Label of the curve. */
    struct spectrum_peak line;
    enum quantity quantity; /* Quantity of the amplitude. */
};

/* The peaks of all spectra of a figure. */
struct figure_peaks {
    struct figure_peak peak[PEAKS_MAX]; /* [count] */
    int count;
};

/* The description of a figure to be made, owned by the caller. Zero members are the defaults,
 * except `recording` and NAN where stated. */
struct figure_request {
    enum plot_kind kind; /* Plot to be drawn. */
    const int *run;      /* [runs] indices of the runs in the session. */
    int runs;
    int recording; /* Index of the recording, or -1. */
    /* [methods] methods for the plot of a study: rows of the catalog. */
    const struct row *const *method;
    int methods; /* Number of methods. */
    /* [columns] names of the variables and observables that PLOT_POSITION and PLOT_ORBIT draw, or
     * NULL if the plot decides. horizontal_column is the one on the x axis of PLOT_ORBIT. */
    const struct text *column;
    int columns;
    struct text horizontal_column;
    const struct table *table; /* Table that has these columns, or NULL for columns of runs. */
    const char *title;         /* Title of the table. */
    /* Event at whose times points are drawn, or empty to draw the whole course. */
    struct text event;
    /* The value of the column at each event is drawn against its value at the event before (return
     * map); needs `event`. */
    bool next;
    double window[2];                 /* [s] window of time, NAN to choose */
    const struct figure_range *x, *y; /* Ranges of the axes, or NULL if automatic. */
    struct figure_side side[2];       /* [sides] sides of a portrait. */
    int sides;
    /* The option --band as typed, which draws the confidence band of the adopted fit; or empty. */
    struct text band;
    bool stored_band; /* The band that the session has stored is drawn, if it belongs to the run. */
    bool full;        /* The figure shows all times, and all curves on one axis. */
    int width;        /* Width [cell] on which the figure will be drawn. */
    bool log;         /* The vertical axis is logarithmic. */
    const struct charset *charset; /* Characters; NULL stands for charset_ascii. */
    double trail; /* Number of periods in phase plot and orbit; 0 stands for 2, HUGE_VAL for all. */
    bool whole_spiral; /* A phase plot of a growing or shrinking motion shows all of its periods. */
    /* The window shows the newest part of the run instead of the first one, for a live view. */
    bool follow;
    /* The screen shows no other plot beside this one. The window may then be longer than one in
     * which each period is visible, unless this plot needs that (plot_row.periods). */
    bool alone;
    bool running; /* The run is in progress, so that texts must not depend on its present end. */
    double span;  /* Duration [s] of the window, or 0 for as long as the width can show. */
    int pages;    /* The window of a live view (`follow`) moves in jumps of span / pages. */
    double t_end; /* Time [s] to which the axis extends at least; NAN if unknown. */
    struct figure_peaks *peaks; /* Receives the peaks of spectra; may be NULL. */
    /* Window that all time plots of a screen share, or NULL to choose one for this plot. */
    const struct figure_window *shared;
};

/* Chooses a window of time for the plot of the request that other time plots can share
 * (request->shared). Returns false if there is nothing to show or if out of memory. */
bool session_window(const struct session *session, const struct figure_request *request,
                    struct arena *arena, struct figure_window *window);

/* Makes the figure, whose memory is the arena's. Returns false with `error` set. */
bool session_figure(const struct session *session, const struct figure_request *request,
                    struct arena *arena, struct figure *figure, struct error *error);
/* Returns the number of coordinates that share the plot of the position: those of a second-order
 * scene, or the variables of a first-order one, of the same quantity; at most the number of
 * marks that distinguish curves. */
int plot_coordinates(const struct model *model);
/* Returns the index of the recording that the plot shows by default: the current one if it overlaps
 * the run; -1 if there is none. */
int figure_recording(const struct session *session, enum plot_kind kind);

/* ---- cursors ---- */

/* Readings of the two cursors A and B, computed from struct cursors; NAN marks unknown values. */
struct cursor_reading {
    double dt;                 /* Time [s] from A to B. */
    double periods;            /* Number of periods between A and B. */
    struct measured period;    /* [s] */
    struct measured frequency; /* [Hz] */
    double theory;             /* [s] period of the scene, with its linear damping */
    const char *theory_name;   /* Name of this period: T0 or T_d for an oscillator, else period. */
    double deviation;          /* (period - theory)/theory */
    /* Logarithmic decrement from the amplitudes at A and B, and Q = pi/decrement. */
    double decrement, quality;
};

/* Computes the readings, fast enough for each frame. Returns false if the cursors are hidden or not
 * both set. */
bool session_cursor_reading(const struct session *session, struct cursor_reading *reading);
/* Appends the readings in four lines, as `cursor` prints them, without a newline at the end. */
void session_cursor_lines(const struct session *session, struct buffer *text);

/* Finds the plane of the focused plot, on which the point of the cursors moves. Returns false if
 * that plot has none or has not been drawn yet. */
bool cursor_plane(const struct session *session, struct plot_plane *plane);
/* Appends the command that begins a trajectory at the point, such as "start x=1,y=0.5". */
void cursor_plane_start(const struct session *session, struct buffer *line);
/* Appends two lines: the position of the point, and a description of the special state there. */
void cursor_plane_lines(const struct session *session, struct buffer *text);

/* Moves the cursors to valid positions after a command has changed their run or recording. */
void cursors_refresh(struct session *session);

/* ---- comparison of a recording with a run (compared.c) ---- */

/* Root mean square distance of a run from a recording, where they overlap in time and have the same
 * quantity. Bad samples are left out. The recording alone decides which samples are bad: those that
 * the fit of a damped sine rejects or, if no such fit describes the recording, those that the
 * search for faults masks. */
struct data_distance {
    double rms;     /* Distance in the recording's quantity [SI]; NAN if there is no overlap. */
    size_t bad;     /* Number of samples that were left out as bad. */
    int derivative; /* Derivative that was recorded: 0 position, 1 velocity, 2 acceleration. */
    enum quantity quantity; /* Quantity of the rms, the recording's. */
    /* If `scaled`, the recording is a voltage or force Y, and gain Y + at_zero is compared with the
     * run's first variable. Both numbers are fitted by least squares, and are NAN if the recording
     * does not follow the run. */
    bool scaled;
    double gain, at_zero;
    /* Mean difference of recording and run if that makes up most of the rms, else NAN. */
    double offset;
};
/* Returns true for quantities of sensors that are proportional to the position by an unknown
 * factor: a voltage, a force. */
bool quantity_is_scaled(enum quantity quantity);
/* Appends the scale that was fitted: "1 V = 2.31 cm, 0 V at y = 1.2 cm". */
void put_scale(const struct data_distance *data, const struct run *run, struct buffer *text);
/* Returns true if a recording is bare: its unit is missing or unknown. Its numbers are then taken
 * as positions in metres or radians, which commands that compare them with a run report to the
 * user. */
bool recorded_bare(const struct recording *recording);
/* Appends the reason why the recording is bare: "has no unit", or "has the unit 'au', which is not
 * known". */
void put_bare(const struct recording *recording, struct buffer *text);
/* Returns the derivative of a run's first coordinate that was recorded, 0 to 2, or -1 if none; if
 * `run` is NULL, by the recording's quantity alone. */
int recorded_derivative(const struct recording *recording, const struct run *run);
/* Returns name and quantity of derivative 0, 1 or 2 of the run's first coordinate. */
struct variable run_derivative(const struct run *run, int derivative);
/* Computes the distance of a run from a recording. */
struct data_distance run_data_distance(const struct run *run, struct recording *recording);
