/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A figure of the session while it is built up. */
#pragma once

#include <hooke/plot/curves.h>

#include <hooke/plot.h>
#include <hooke/session/subject.h>

#define PERIOD_COLUMNS_ASCII 8 /* least columns a period that can still be followed */
#define PERIOD_COLUMNS_DOTS 5
#define PERIOD_COLUMNS_PICTURE 2 /* the same for pictures, as part of PICTURE_COLUMNS */
/* columns drawn of one run, at most the number of marks */
#define DRAWN_COLUMNS (LIMIT_OVERLAY + 1)
#define FRAME_COLUMNS 10 /* [cell] of the width that labels and frame take */

/* Drawing in progress. */
struct drawing {
    const struct session *session;
    const struct figure_request *request;
    struct arena *arena;
    struct error *error;
    struct curve *curve;
    int curves;
    const struct model *model; /* model of the runs; NULL if there are none */
    int coordinates;           /* curves that one run has */
    struct chosen_column column[DRAWN_COLUMNS], horizontal_column; /* if the request names them */
    double omega0; /* [rad/s] divisor of v, or 1 for none */
    /* [s] of the first run, NAN if there is none */
    double period;
    double window[2];    /* [s] */
    double shown, total; /* [s] */
    /* the strongest line of the spectrum, or the highest of several; frequency 0 if there is
     * none */
    struct spectrum_peak line;
    struct data_motion motion; /* motion of the recording, if the plot needs it */
};

/* Returns the first of the coordinates that are drawn on the vertical axis. */
const struct variable *vertical_variable(const struct model *model, enum plot_kind kind);

static inline const struct plot_row *kind_of(const struct drawing *d)
{
    return plot_row(d->request->kind);
}

static inline const struct recording *recording_of(const struct drawing *d)
{
    return d->request->recording >= 0 ? d->session->recording[d->request->recording]->recording
                                      : NULL;
}

/* Finds what the request names, of one unit, since it shares the axis. */
bool drawing_columns(struct drawing *d, const struct system *system);
/* Name of what is drawn of one run, i of its coordinates. Returns NULL if out of memory. */
const char *drawing_label(const struct drawing *d, int i);

/* The columns where the event of the request happened. */
bool drawing_event_records(struct drawing *d, const struct run_slot *slot);
/* Draws the state of an adaptive run over time, or one part of it against another, with curves
 * between its rows. Sets *drawn if it has drawn them. */
bool drawing_smooth(struct drawing *d, const struct run *run, const struct chosen_rows *rows,
                    const char *label, bool *drawn);
/* Name of the run in a legend; NULL if out of memory. */
const char *drawing_run_label(const struct drawing *d, const struct run *run);

/* Adds the curve of the recording, or of what is left of it (figure_recording.c). */
/* Returns true if this kind of plot shows the values that the recording holds, not derivatives of
 * them. run may be NULL if no run is shown beside the recording. */
bool recording_shows(const struct recording *recording, const struct run *run, enum plot_kind kind);
/* Velocities or energies have to be found from the positions of the recording. */
/* Writes by how much the newest velocity lags behind the newest sample while data is being
 * collected. */
void drawing_put_delay(const struct drawing *d, struct buffer *text);
bool drawing_needs_motion(const struct drawing *d, const struct recording *recording);
bool drawing_recording(struct drawing *d, const struct recording *recording);
/* Finds which derivatives of the motion a recording has; without a run it is taken for an
 * oscillator. */
bool drawing_find_motion(struct drawing *d, const struct recording *recording);

/* The unit in which numbers of this size are short; without one the axis is left as it is. */
void axis_suit(struct axis *axis, enum quantity quantity, double size);
/* Returns the label of the vertical axis; NULL if out of memory. */
const char *drawing_y_label(const struct drawing *d, int panel);
/* Draws columns of the request's table (table.c). */
bool drawing_table(struct drawing *d, struct figure *figure);
/* Draws the last table of a study (study.c). */
bool drawing_study(struct drawing *d, const struct study_picture *picture, struct figure *figure);
/* The last table of that kind; NULL if there is none. */
const struct table *drawing_stored(const struct session *session, const char *kind);
/* Returns the quantity of a column, or QUANTITY_NUMBER if it has no unit of its own. */
enum quantity column_quantity(const struct table_column *column);
/* Ranges that were asked for; quantities of x and y. */
bool drawing_ranges(const struct drawing *d, struct figure *figure,
                    const enum quantity quantity[2]);
/* Ranges, logarithm and panels (figure_scales.c); quantities of x and y. */
bool drawing_scales(struct drawing *d, struct figure *figure, const enum quantity quantity[2]);
/* v against y: about the equilibrium, in the units of the phase plot. */
bool drawing_phase_data(struct drawing *d, const struct series *series, struct curve *curve);

/* [s] that the scene, or the sizes of what moves, lead to expect of a run; NAN if there is none. */
double run_rhythm(const struct run *run);
bool run_goes_back(const struct run *run); /* time falls from row to row */
/* Returns an automatic axis in the unit that suits a value of this size. */
struct axis quantity_axis(const char *label, enum quantity quantity, double size);
struct axis time_axis(const double window[2]); /* [s] fixed */
/* Chooses the window of time; the model and the period are known. */
void drawing_window(struct drawing *d);
double drawing_trail(const struct drawing *d); /* periods */
/* Returns which rows of a run are drawn in a window: where nothing but states over the time of the
 * axis is, of many rows only the extremes. */
struct row_request drawing_rows(const struct drawing *d, const double window[2]);
