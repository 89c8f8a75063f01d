/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The phase portrait of two variables: directions, nullclines, equilibria, separatrices, lines of
 * equal energy. portrait_make() computes all of it for a request. */
#pragma once

#include "modules/dynamics/dynamics.h"

/* Scene, plane and region of a portrait. */
struct portrait_request {
    const struct scene *scene;
    int variable[2];                   /* variables across and up */
    double box[2][2];                  /* SI, ranges of both */
    double all[DYNAMICS_VARIABLES][2]; /* SI, search region of equilibria */
    double state[DYNAMICS_VARIABLES];  /* SI, values of the other variables in the plane */
    double t;                          /* [s] time, if the scene is driven */
    bool energy;                       /* lines of equal energy are wanted, too */
    const struct cancel *cancel;
};

/* Lines in the plane; NAN in x and y is a gap between two of them. Freed by whoever holds it. */
struct polyline {
    double *x, *y; /* [n] SI */
    size_t n, capacity;
};

#define CROSSINGS_MAX 12 /* largest number of crossings that are stored of a separatrix */

/* Separatrix of a saddle along the eigenvector of its only growing or its only decaying
 * direction. */
struct separatrix {
    int equilibrium; /* index in `found` */
    bool stable;     /* it leads to the saddle, not away from it */
    int side;        /* sign of the direction along the eigenvector in which it leaves */
    const char *end; /* place where it ends: "frame", "equilibrium", or "goes on" if it was not
                        followed on */
    int target;      /* index of the equilibrium, or -1 if there is none */
    /* Crossings with the lines variable = value through equilibria, in order along it. */
    int crossings;
    struct portrait_crossing {
        int variable; /* variable across (0) or up (1) */
        double value; /* its value, and that of the other variable */
        double other;
    } crossing[CROSSINGS_MAX];
};

/* Appends a point. Returns false if out of memory. */
bool polyline_put(struct polyline *line, double x, double y);

/* Kinds of lines of a portrait. */
enum portrait_line {
    PORTRAIT_NULLCLINE, /* nullcline of the variable across; the next one is that of the other */
    PORTRAIT_NULLCLINE_UP,
    PORTRAIT_SEPARATRIX, /* stable separatrices */
    PORTRAIT_SEPARATRIX_UNSTABLE,
    PORTRAIT_ENERGY,
    PORTRAIT_LINES
};

/* A portrait, freed by portrait_free(). */
struct portrait {
    struct polyline line[PORTRAIT_LINES];
    struct equilibria found;
    struct separatrix *separatrix;
    int separatrices;
    bool cancelled; /* true if it was stopped and holds only the parts that were finished */
    int64_t evals;
    double seconds;
};

/* Computes the portrait. With a drive, lines and directions are those at time t, equilibria those
 * of the mean, and there are no separatrices. Returns false with `error` filled if the scene has no
 * portrait or if out of memory. */
bool portrait_make(const struct portrait_request *request, struct portrait *portrait,
                   struct error *error);
void portrait_free(struct portrait *portrait);

/* Appends the trajectory from `start` [n] over `span` [s], backwards if that is negative, until it
 * leaves the box. Returns false if out of memory. */
bool portrait_trajectory(const struct portrait_request *request, const double *start, double span,
                         struct polyline *line);
