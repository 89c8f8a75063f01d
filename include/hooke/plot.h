/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * plot: figures of a session, panes that make sense, cursors, a recording beside a run.
 */
#pragma once

#include <hooke/data/series.h>
#include <hooke/figure.h>
#include <hooke/session.h>

struct catalog;

/* ---- figures of the session ---- */

/* Those that others ask for by themselves; rows that stand behind them need no name here. */
enum plot_kind {
    PLOT_POSITION,
    PLOT_ENERGY,
    PLOT_PHASE,
    PLOT_VELOCITY,
    PLOT_ERROR,
    PLOT_ORBIT, /* one coordinate against another */
    PLOT_ACCELERATION,
};

enum plot_across { ACROSS_TIME, ACROSS_STATE, ACROSS_FREQUENCY, ACROSS_OTHER };
/* The variable on the vertical axis: of first order the rate is the second value. */
enum plot_vertical { VERTICAL_FIRST, VERTICAL_RATE, VERTICAL_SECOND };
/* Kind of recorded values that such a plot shows without conversion. */
enum plot_recorded { RECORDED_OTHER, RECORDED_POSITION, RECORDED_VELOCITY, RECORDED_ACCELERATION };

struct reply;
struct drawing; /* a figure while it is built up: hooke/plot/drawing.h */
struct figure_request;

/* The plane of a plot whose points are states of the scene. */
struct plot_plane {
    const struct scene *scene; /* the scene that was drawn */
    int variable[2];           /* variables on the axes, horizontal first */
    double box[2][2];
    double state[LIMIT_VARIABLES]; /* SI; gives the variables that are not shown */
};

/* Functions that move the cursors' point on such a plane. */
struct plane_row {
    /* Gives the plane as it was drawn last. Returns false if none was drawn of this scene. */
    bool (*drawn)(const struct session *session, struct plot_plane *plane);
    /* Moves the point to the next, or the previous, special state. */
    bool (*next)(const struct session *session, const struct plot_plane *plane, bool forward,
                 double point[2], struct error *error);
    /* Appends what is special where the point stands. */
    void (*say)(const struct session *session, const struct plot_plane *plane, struct buffer *text);
};

/* One kind of curves in the figure of a study. */
struct study_layer {
    const char *y;     /* column on the vertical axis, or NULL behind the last layer */
    const char *part;  /* word in column `part` of its rows, or NULL if all rows are */
    const char *value; /* column whose value stands behind a curve's name, or NULL */
    const char *named; /* name of that value, such as "slope" */
    double max;        /* larger values are left out, unless it is 0 */
    bool line;         /* a line with a gap at each row without numbers; otherwise points */
    bool guide;        /* a thin straight line from the first to the last row with numbers */
};

/* Describes how the table of a study is drawn. */
enum { STUDY_LAYERS_MAX = 4 };
struct study_picture {
    const char *table, *made_by; /* kind of the table, and what makes one */
    const char *x;               /* column on the horizontal axis */
    const char *group;           /* column of names that tell curves apart, or NULL */
    struct study_layer layer[STUDY_LAYERS_MAX];
    const char *shade;             /* column shown as shades over x and the first layer's y */
    const char *x_label, *y_label; /* names of the axes, or NULL for those of the columns */
    const char *note;              /* explanation of the lines, or NULL */
    bool log_x, log_y;             /* axes that are logarithmic */
    bool equal;                    /* one length for a unit on both axes */
};

/* Row that describes a plot, which can also be a pane of the screen (src/plot/plots.c). */
struct plot_row {
    struct row row;
    enum plot_across horizontal; /* the horizontal axis */
    enum plot_vertical vertical; /* state that the vertical axis shows, if it shows the state */
    /* observable on the vertical axis, or NULL for state variables or something else */
    const char *observable;
    const char *label; /* label of the vertical axis, if not the names of the variables */
    /* label of the magnitude on a logarithmic axis, or NULL if the plot has no values of
     * both signs */
    const char *log_label;
    /* title of the figure; name of the vertical axis in a pane, or NULL for its usual one */
    const char *title, *pane_label;
    /* Requirements of the plot. */
    /* Returns true if the plot makes sense for the model; NULL accepts any model. */
    bool (*fits)(const struct model *model);
    const char *needs; /* requirement that other models lack, for the message */
    /* Returns true if the session has what the plot shows. If NULL, the plot needs a run that
     * fits or such a recording. */
    bool (*offered)(const struct session *session);
    enum plot_recorded recorded;
    bool any_recording; /* shows any recording if there is no run */
    bool of_motion;     /* shows velocities of a recording, which are computed from its positions */
    /* draws what is left of a recording beside a fit or a run; NULL if it is no such plot */
    bool (*residual)(struct drawing *d, const struct recording *recording);
    bool of_study; /* Shows the results of a study, not runs; its figure fails if there is none. */
    /* Command whose `> FILE.svg` writes it, or NULL for the one of its own name, if any. */
    const char *command;
    /* Description of how the table of its study is drawn, in place of `figure`, or NULL. */
    const struct study_picture *picture;
    /* Computes that table as records of the reply for these methods (rows of the catalog; with
     * none given, those that were studied last or the current one). NULL if no words may follow
     * the plot's name. */
    bool (*study)(struct session *session, const struct row *const *method, int methods,
                  struct reply *reply, struct error *error);
    bool whole;    /* its axes hold all points: ranges are refused */
    bool of_scene; /* shows the scene, and its run if there is one */
    /* Make its curves; if NULL they are columns of the trace. With `figure`, which makes the
     * whole figure, nothing else is called. */
    bool (*run_curve)(struct drawing *d, const struct run *run, struct curve *curve);
    bool (*data_curve)(struct drawing *d, const struct series *series, struct curve *curve);
    bool (*figure)(struct drawing *d, struct figure *figure);
    /* Writes the plot's own note; NULL if it has none. */
    void (*note)(const struct drawing *d, struct buffer *text);
    struct axis (*axis)(const struct drawing *d); /* horizontal, in place of the usual; or NULL */
    const struct plane_row *plane;                /* NULL where its points are no states */
    /* Adds the numbers behind the figure to the reply. NULL if there are none. */
    void (*reply)(const struct session *session, const struct figure_request *request,
                  struct reply *reply);
    /* Gives curves that have only marks their names, for pictures and in words; may be NULL. */
    bool (*name_curves)(const struct session *session, struct arena *arena, struct figure *figure,
                        struct error *error);
    /* Appends lines of that width [cell] that stand below the figure in cells; may be NULL. */
    void (*legend)(const struct session *session, int width, struct buffer *text);
    const char *planned; /* a line of `plan` while its pane has the focus; NULL if there is none */
    bool takes_column;   /* a column may follow its name: what is drawn of it */
    bool coordinates;    /* all of one quantity, on one axis */
    /* shows an energy that all runs have, which is the kinetic energy if some have no potential */
    bool energy;
    bool scaled; /* 'set phase-axes': v over omega0 */
    bool equal;  /* axes of the same scale */
    /* Its limits. */
    bool periods; /* each period has to be seen: the window is limited to what the width can show */
    bool positive;   /* never below zero: curves of different size get a logarithmic axis */
    bool from_zero;  /* zero belongs to the vertical range, without a line */
    bool flat;       /* drawn from zero where it hardly varies */
    bool in_layouts; /* some layout has it: any other takes the first place of each */
};

extern const struct catalog plot_catalog; /* struct plot_row, at the enum's place */

const struct plot_row *plot_row(enum plot_kind kind);
bool plot_is_timed(enum plot_kind kind);      /* the horizontal axis is the time */
bool plot_is_plane(enum plot_kind kind);      /* one part of the state against another */
bool plot_shows_state(enum plot_kind kind);   /* variables on its vertical axis */
bool plot_of_recordings(enum plot_kind kind); /* some recordings have one */
/* Returns true if such a plot makes sense for a model; not every model has velocities or a
 * second coordinate. */
bool plot_fits(enum plot_kind kind, const struct model *model);
/* Returns true if the plot makes sense for this session; for example, an error plot needs a
 * reference. */
bool plot_offered(const struct session *session, enum plot_kind kind);
/* Returns the quantity on an axis of the plot for the session's run or scene. */
enum quantity plot_quantity(const struct session *session, enum plot_kind kind, bool x);

/* The pane that commands and zooming act on. */
enum plot_kind view_focus(const struct view *view);
void view_focus_on(struct view *view, enum plot_kind kind);

/* The part of the time that plots over each other share. */
struct figure_window {
    struct axis axis;    /* common axis of all plots, fixed */
    double shown, total; /* [s] of what there is: how long the window is, and all of it */
};

/* Range that an axis shall show. An open end is where the curves end; if both ends are open the
 * range is as narrow as the curves. */
struct figure_range {
    double end[2]; /* ends, NAN where open */
    /* quantity of the unit that was given, or QUANTITY_OTHER if the axis decides */
    enum quantity quantity;
    struct text text; /* as typed, for messages */
};

/* A side of a portrait: a variable and its range, SI. */
struct figure_side {
    int variable;
    double range[2];
};

#define PEAKS_EACH 3 /* lines that are named of one spectrum */
#define PEAKS_MAX 16 /* and in all */

struct figure_peak {
    const char *label; /* label of the curve */
    struct spectrum_peak line;
    enum quantity quantity; /* quantity of the amplitude */
};

struct figure_peaks {
    struct figure_peak peak[PEAKS_MAX];
    int count;
};

struct figure_request {
    enum plot_kind kind;
    const int *run; /* places in the session */
    int runs;
    int recording;                   /* place, -1 if there is none */
    const struct row *const *method; /* [methods] of a study's plot: rows of the catalog */
    int methods;                     /* number of methods, 0 if none was named */
    /* Columns drawn instead in PLOT_POSITION and PLOT_ORBIT: names of variables and observables, or
     * NULL if the kind of plot decides. horizontal_column is for PLOT_ORBIT. */
    const struct text *column;
    int columns;
    struct text horizontal_column;
    const struct table *table; /* table that has these columns, or NULL for columns of runs */
    const char *title;         /* title of the table */
    /* Event at whose moments points are drawn, or empty to draw the whole course. */
    struct text event;
    /* then the columns at the event after the one where `against` is taken: a return map */
    bool next;
    double window[2];                 /* [s] NAN: choose */
    const struct figure_range *x, *y; /* ranges of the axes, or NULL if automatic */
    struct figure_side side[2];       /* sides of a portrait */
    int sides;
    struct text band; /* band of the adopted fit's uncertainty as typed, or empty for none */
    bool stored_band; /* draw the band that the session keeps, if it belongs to this run */
    bool full;        /* all of it: the whole time, all curves on one axis */
    int width;        /* [cell] that will be drawn on */
    bool log;         /* vertical axis */
    const struct charset *charset; /* NULL counts as charset_ascii */
    double trail; /* number of periods in phase plot and orbit; 0 stands for 2, HUGE_VAL for all */
    /* Shows the newest part instead of the first one on a fixed time axis, for a lasting view. */
    bool follow;
    /* no other plot shares the time axis: each period has to be seen only where this one needs
     * it */
    bool alone;
    bool running; /* the end moves: nothing that is written depends on it */
    double span;  /* [s] length of time shown, or 0 for as much as the width can show */
    int pages;    /* the window moves on by span / pages */
    double t_end; /* [s] the axis reaches to here at least, where known; NAN */
    struct figure_peaks *peaks; /* takes the lines of spectra; NULL if nobody asks */
    /* Window that all time plots of a screen share, or NULL to choose one for this plot. */
    const struct figure_window *shared;
};

/* Chooses the window for such a time plot and all that share it; returns false if there is nothing
 * to show, or no memory. */
bool session_window(const struct session *session, const struct figure_request *request,
                    struct arena *arena, struct figure_window *window);

/* Builds the figure; all memory from the arena. */
bool session_figure(const struct session *session, const struct figure_request *request,
                    struct arena *arena, struct figure *figure, struct error *error);
/* Coordinates of the same quantity, which share the plot of the position: those of a second-order
 * scene, the values of one of first order; at most as many as have marks of their own. */
int plot_coordinates(const struct model *model);
/* Place of the recording that belongs into such a plot without being asked for: the current one,
 * where it overlaps the run; -1 if there is none. */
int figure_recording(const struct session *session, enum plot_kind kind);

/* ---- cursors ---- */

/* Readings of the two cursors, computed from struct cursors. NAN marks unknown values. */
struct cursor_reading {
    double dt;                 /* [s] B - A */
    double periods;            /* number of periods between them */
    struct measured period;    /* [s] */
    struct measured frequency; /* [Hz] */
    double theory;             /* [s] period of the scene, with its linear damping */
    const char *theory_name;   /* T0, T_d; period in other scenes than those of an oscillator */
    double deviation;          /* (period - theory)/theory */
    /* logarithmic decrement from the amplitudes at A and B, Q = pi/decrement */
    double decrement, quality;
};

/* Computes the readings. Returns false if the cursors are hidden or not both set. Cheap enough
 * to be called for each frame. */
bool session_cursor_reading(const struct session *session, struct cursor_reading *reading);
/* The same in four lines for people, as `cursor` prints them; without a newline at the end. */
void session_cursor_lines(const struct session *session, struct buffer *text);

/* Finds the plane that the point of the cursors moves on: the plane of the focused plot. Returns
 * false if that plot has none or has not been drawn yet. */
bool cursor_plane(const struct session *session, struct plot_plane *plane);
/* Writes the command that begins a trajectory at the point, such as "start x=1,y=0.5". */
void cursor_plane_start(const struct session *session, struct buffer *line);
/* Two lines for people: where it stands, and what is there. */
void cursor_plane_lines(const struct session *session, struct buffer *text);

/* Finds the positions of the cursors again after a command that has changed what they point at. */
void cursors_refresh(struct session *session);

/* ---- a recording beside a run (compared.c) ---- */

/*
 * Rms distance of the run from the recording where they overlap in time and hold the same quantity.
 * The recording alone decides which samples are bad, however far off the run is: those that the fit
 * of a damped sine leaves out; where none describes it, those that find_faults() masks.
 */
struct data_distance {
    double rms;     /* NAN if they do not overlap */
    size_t bad;     /* samples left out: missed echoes would hide how well the run fits */
    int derivative; /* derivative that was recorded: 0 position, 1 velocity, 2 acceleration */
    enum quantity quantity; /* quantity of the rms, which is the recording's own */
    /* The recorded Y is compared with gain Y + at_zero of the run's first variable. For a
     * voltage or a force (scaled) both are fitted by least squares, and NAN if the recording
     * does not follow the run. */
    bool scaled;
    double gain, at_zero;
    /* Mean of the recording minus the run where it is most of the rms, else NAN. */
    double offset;
};
/* A sensor's quantity that moves with the position in a proportion that nobody knows: a voltage, a
 * force. */
bool quantity_is_scaled(enum quantity quantity);
/* "1 V = 2.31 cm, 0 V at y = 1.2 cm" */
void put_scale(const struct data_distance *data, const struct run *run, struct buffer *text);
/* Numbers whose unit is missing or unknown are taken as positions, in metres or radians, and said
 * to be: by adopt and wherever they are compared with a run. */
bool recorded_bare(const struct recording *recording);
/* Appends "has no unit", or "has the unit 'au', which is not known". */
void put_bare(const struct recording *recording, struct buffer *text);
/* Returns the same for a recording and the first coordinate of a run (if run is NULL, by the
 * quantity alone), or -1 if it is neither. */
int recorded_derivative(const struct recording *recording, const struct run *run);
struct variable run_derivative(const struct run *run, int derivative); /* its name and quantity */
struct data_distance run_data_distance(const struct run *run, struct recording *recording);
