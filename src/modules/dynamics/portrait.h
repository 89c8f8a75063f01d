/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The phase portrait of two variables: where they go, where either of them rests, equilibria,
 * separatrices, lines of equal energy.
 */
#pragma once

#include "modules/dynamics/dynamics.h"

struct portrait_request {
    const struct scene *scene;
    int variable[2];                   /* variables across and up */
    double box[2][2];                  /* SI, ranges of both */
    double all[DYNAMICS_VARIABLES][2]; /* SI, search region of equilibria */
    double state[DYNAMICS_VARIABLES];  /* SI, values of the other variables in the plane */
    double t;                          /* [s] time, if the scene is driven */
    bool energy;                       /* asks for lines of equal energy, too */
    const struct cancel *cancel;
};

/* Lines with gaps: NAN in both. */
struct polyline {
    double *x, *y; /* [n] SI */
    size_t n, capacity;
};

#define CROSSINGS_MAX 12

/* Separatrix of a saddle along the eigenvector of its only growing or its only decaying
 * direction. */
struct separatrix {
    int equilibrium; /* index in `found` */
    bool stable;     /* leads to the saddle, not away from it */
    int side;        /* 1 or -1, along the eigenvector */
    const char *end; /* "frame", "equilibrium", "goes on" */
    int target;      /* index of the equilibrium, or -1 if there is none */
    /* Crossings with the lines variable = value through equilibria, in order along it. */
    int crossings;
    struct portrait_crossing {
        int variable; /* variable across (0) or up (1) */
        double value; /* its value, and that of the other variable */
        double other;
    } crossing[CROSSINGS_MAX];
};

bool polyline_put(struct polyline *line, double x, double y); /* Returns false if out of memory. */

enum portrait_line {
    PORTRAIT_NULLCLINE, /* nullcline of the variable across; the next one is that of the other */
    PORTRAIT_NULLCLINE_UP,
    PORTRAIT_SEPARATRIX, /* stable separatrices */
    PORTRAIT_SEPARATRIX_UNSTABLE,
    PORTRAIT_ENERGY,
    PORTRAIT_LINES
};

struct portrait {
    struct polyline line[PORTRAIT_LINES];
    struct equilibria found;
    struct separatrix *separatrix;
    int separatrices;
    bool cancelled; /* holds the parts that were finished */
    int64_t evals;
    double seconds;
};

/* Computes the portrait. With a drive, lines and directions are those at time t, equilibria those
 * of the mean, and there are no separatrices. Returns false with `error` filled if the scene has no
 * portrait or if out of memory. */
bool portrait_make(const struct portrait_request *request, struct portrait *portrait,
                   struct error *error);
void portrait_free(struct portrait *portrait);

/* A trajectory from `start` [n] on over `span` [s] (of any sign) until it leaves the box: into the
 * line. Returns false if out of memory. */
bool portrait_trajectory(const struct portrait_request *request, const double *start, double span,
                         struct polyline *line);
