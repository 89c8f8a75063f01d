/* SPDX-License-Identifier: GPL-3.0-or-later */
/* drawing: a figure of a session that is being made (struct drawing), for the functions of plots
 * (struct plot_row) that make curves and axes. Functions that fail return false, or NULL, with
 * d->error set, mostly because memory ran out. The memory of results is that of d->arena. */
#pragma once

#include <hooke/plot/curves.h>

#include <hooke/plot.h>
#include <hooke/session/subject.h>

/* Smallest number of columns per period that is readable in ASCII. */
#define PERIOD_COLUMNS_ASCII 8
/* Smallest number of columns per period for characters with dots (block elements, braille). */
#define PERIOD_COLUMNS_DOTS 5
/* Smallest number of columns per period in pictures, which have PICTURE_COLUMNS columns. */
#define PERIOD_COLUMNS_PICTURE 2
/* Largest number of variables and observables drawn of one run; each needs a mark of its own. */
#define DRAWN_COLUMNS (LIMIT_OVERLAY + 1)
#define FRAME_COLUMNS 10 /* [cell] width that labels and frame need */

/* A figure that is being made. */
struct drawing {
    const struct session *session;
    const struct figure_request *request; /* Description of the figure. */
    struct arena *arena;                  /* Owner of the figure's memory. */
    /* Receives the reason of a failure. */
    struct error *error;
    /* [curves] curves so far. */
    struct curve *curve;
    int curves;
    const struct model *model; /* Model of the runs, or NULL if there are none. */
    int coordinates;           /* Number of curves that are drawn of each run. */
    /* Columns, if the request names them. */
    struct chosen_column column[DRAWN_COLUMNS], horizontal_column;
    double omega0; /* Divisor of v on the axis: omega0 [rad/s], or 1. */
    /* Period [s] of the first run; NAN if it has none. */
    double period;
    double window[2];    /* Window of time [s]. */
    double shown, total; /* Length [s] of the window, and of all times that could be shown. */
    /* Strongest line of the spectra; frequency 0 if there is none. */
    struct spectrum_peak line;
    /* Velocities and energies of the recording, if the plot needs them. */
    struct data_motion motion;
};

/* Returns the first of the variables that a plot of this kind has on its vertical axis. */
const struct variable *vertical_variable(const struct model *model, enum plot_kind kind);

/* Returns the row of the plot. */
static inline const struct plot_row *kind_of(const struct drawing *d)
{
    return plot_row(d->request->kind);
}

/* Returns the recording of the request, or NULL. */
static inline const struct recording *recording_of(const struct drawing *d)
{
    return d->request->recording >= 0 ? d->session->recording[d->request->recording]->recording
                                      : NULL;
}

/* Sets d->column and d->coordinates to the columns that the request names. They must have one unit,
 * because they share an axis. */
bool drawing_columns(struct drawing *d, const struct system *system);
/* Returns the name of curve i of one run, or NULL if out of memory. */
const char *drawing_label(const struct drawing *d, int i);

/* Adds points for the columns at the times of the request's event. */
bool drawing_event_records(struct drawing *d, const struct run_slot *slot);
/* Adds curves of the state of an adaptive run over time, or of one variable against another, that
 * are smooth between the selected rows. Sets *drawn to false if smooth curves are not possible, so
 * that the caller has to draw the rows, else to true. */
bool drawing_smooth(struct drawing *d, const struct run *run, const struct chosen_rows *rows,
                    const char *label, bool *drawn);
/* Returns the name of the run in a legend, or NULL if out of memory. */
const char *drawing_run_label(const struct drawing *d, const struct run *run);

/* Returns true if the plot shows the values of the recording itself, not derivatives of them; `run`
 * may be NULL if no run is drawn. */
bool recording_shows(const struct recording *recording, const struct run *run, enum plot_kind kind);
/* Appends, while data are being collected, the time by which the newest velocity is older than the
 * newest sample. */
void drawing_put_delay(const struct drawing *d, struct buffer *text);
/* Returns true if velocities or energies have to be computed from the recording's positions. */
bool drawing_needs_motion(const struct drawing *d, const struct recording *recording);
/* Adds the curve of the recording or, in plots of residuals, of its residuals. */
bool drawing_recording(struct drawing *d, const struct recording *recording);
/* Computes the velocities or energies of a recording into d->motion. If no run is drawn, the
 * recording counts as that of an oscillator. */
bool drawing_find_motion(struct drawing *d, const struct recording *recording);

/* Sets unit and factor of an axis of this quantity so that values of this size [SI] have short
 * labels. An axis of a quantity without units is unchanged. */
void axis_suit(struct axis *axis, enum quantity quantity, double size);
/* Returns the label of the vertical axis of a panel, or NULL if out of memory. */
const char *drawing_y_label(const struct drawing *d, int panel);
/* Draws columns of the request's table. */
bool drawing_table(struct drawing *d, struct figure *figure);
/* Draws the last table of a study as *picture describes. */
bool drawing_study(struct drawing *d, const struct study_picture *picture, struct figure *figure);
/* Returns the last table of this kind that the session has stored, or NULL if there is none. */
const struct table *drawing_stored(const struct session *session, const char *kind);
/* Returns the quantity of a column by its unit, or QUANTITY_NUMBER if it has none. */
enum quantity column_quantity(const struct table_column *column);
/* Sets the axes of the figure to the ranges of the request; quantity [2] are those of x and y. */
bool drawing_ranges(const struct drawing *d, struct figure *figure,
                    const enum quantity quantity[2]);
/* Chooses ranges, logarithmic axes and panels of the figure; quantity [2] are those of x and y. */
bool drawing_scales(struct drawing *d, struct figure *figure, const enum quantity quantity[2]);
/* Makes the curve of a recording in the phase plot: v against y, about the equilibrium, in the
 * units of the plot. */
bool drawing_phase_data(struct drawing *d, const struct series *series, struct curve *curve);

/* Returns the period [s] of the run's scene or, if it is unknown, one estimated from the natural
 * sizes of position and velocity; NAN if there is neither. */
double run_rhythm(const struct run *run);
bool run_goes_back(const struct run *run); /* Returns true if the time decreases from row to row. */
/* Returns an automatic axis in a unit that suits values of this size [SI]. */
struct axis quantity_axis(const char *label, enum quantity quantity, double size);
struct axis time_axis(const double window[2]); /* Returns a fixed time axis for a window [s]. */
/* Chooses d->window; d->model and d->period must be set. */
void drawing_window(struct drawing *d);
/* Returns the number of periods that phase plot and orbit show; HUGE_VAL for all. */
double drawing_trail(const struct drawing *d);
/* Returns true if a phase plot shows all periods of a run because its motion grows or shrinks, as a
 * spiral. d->period and d->total must be set. */
bool drawing_shows_spiral(const struct drawing *d);
/* Adds labels at the start and at the end of such a spiral. Returns false, with d->error set, if
 * out of memory. */
bool drawing_label_turns(const struct drawing *d, struct figure *figure);
/* Returns the selection of rows that are drawn in a window [s]. If only state variables are drawn
 * over time and there are many rows, it contains only rows with extremes. */
struct row_request drawing_rows(const struct drawing *d, const double window[2]);
