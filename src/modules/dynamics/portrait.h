/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The phase portrait of two variables: where they go, where either of them rests, equilibria,
 * separatrices, lines of equal energy.
 */
#pragma once

#include "modules/dynamics/dynamics.h"

struct portrait_request {
    const struct scene *scene;
    int variable[2];                   /* across and up */
    double box[2][2];                  /* of them, SI */
    double all[DYNAMICS_VARIABLES][2]; /* search region of equilibria, all variables */
    double state[DYNAMICS_VARIABLES];  /* of the others: what they are in the plane that is shown */
    double t;                          /* [s] when: of a scene that is driven */
    bool energy;                       /* lines of equal energy, too */
    const struct cancel *cancel;
};

/* Lines with gaps: NAN in both. */
struct polyline {
    double *x, *y; /* [n] SI */
    size_t n, capacity;
};

#define CROSSINGS_MAX 12

/* From a saddle along an eigenvector: of the only growing, or the only decaying direction. */
struct separatrix {
    int equilibrium; /* place among those found */
    bool stable;     /* goes to the saddle; else it leaves it */
    int side;        /* 1 or -1: along the eigenvector */
    const char *end; /* "frame", "equilibrium", "goes on" */
    int target;      /* the equilibrium, or -1 if there is none */
    /* where it crosses the lines variable = value through equilibria, in the order of the way */
    int crossings;
    struct portrait_crossing {
        int variable; /* 0: across, 1: up; has this */
        double value; /* and the other variable */
        double other;
    } crossing[CROSSINGS_MAX];
};

bool polyline_put(struct polyline *line, double x, double y); /* Returns false if out of memory. */

enum portrait_line {
    PORTRAIT_NULLCLINE, /* of the variable across */
    PORTRAIT_NULLCLINE_UP,
    PORTRAIT_SEPARATRIX, /* stable ones */
    PORTRAIT_SEPARATRIX_UNSTABLE,
    PORTRAIT_ENERGY,
    PORTRAIT_LINES
};

struct portrait {
    struct polyline line[PORTRAIT_LINES];
    struct equilibria found;
    struct separatrix *separatrix;
    int separatrices;
    bool cancelled; /* what there was until then is there */
    int64_t evals;
    double seconds;
};

/* False: the scene has no such thing, or no memory. Forced: lines and directions at time t, the
 * equilibria those of the mean, no separatrices. */
bool portrait_make(const struct portrait_request *request, struct portrait *portrait,
                   struct error *error);
void portrait_free(struct portrait *portrait);

/* A trajectory from `start` [n] on over `span` [s] (of any sign) until it leaves the box: into the
 * line. Returns false if out of memory. */
bool portrait_trajectory(const struct portrait_request *request, const double *start, double span,
                         struct polyline *line);
