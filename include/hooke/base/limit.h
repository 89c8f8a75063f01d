/* SPDX-License-Identifier: GPL-3.0-or-later */
/* limit: largest sizes and counts that the program accepts. Exceeding one is an error with a
 * message, except where the comment says that the oldest items are dropped. limit_catalog
 * (<hooke/base/catalog.h>) shows most of them to users. */
#pragma once

#define LIMIT_LINE (1u << 20)          /* bytes of a command line */
#define LIMIT_TOKENS 4096              /* words of a statement */
#define LIMIT_EXPR_DEPTH 200           /* nesting of parentheses and operators in an expression */
#define LIMIT_EXPR_SIZE 4096           /* operations of an expression */
#define LIMIT_SOURCE_DEPTH 16          /* nesting of `source` */
#define LIMIT_NAME 63                  /* bytes of a name */
#define LIMIT_RUNS 256                 /* runs of a session */
#define LIMIT_RECORDINGS 64            /* recordings of a session */
#define LIMIT_MODULES 24               /* modules of a build */
#define LIMIT_UNDO 200                 /* levels of undo */
#define LIMIT_HISTORY 100000           /* lines and statements of the history */
#define LIMIT_REQUESTS 65536           /* requests in a run's journal: continue, go back, change */
#define LIMIT_CHANGES 8192             /* times at which a run's parameters changed */
#define LIMIT_MEASUREMENTS 1024        /* measurements; the oldest are dropped */
#define LIMIT_FITS 256                 /* fits; the oldest are dropped */
#define LIMIT_HISTORY_TEXT (1u << 24)  /* bytes of the whole history */
#define LIMIT_VARIABLES 64             /* state variables of a scene */
#define LIMIT_COLUMNS 1024             /* columns of a data file */
#define LIMIT_FILE (1u << 30)          /* bytes of a data file */
#define LIMIT_SAMPLES (1u << 20)       /* rows of a run before every second one is dropped */
#define LIMIT_STEPS 9007199254740992.0 /* 2^53: t0 + i dt is exact in i up to here */
#define LIMIT_SCRIPT (1u << 26)        /* bytes of a script */
#define LIMIT_LET 128                  /* variables defined by `let` */
#define LIMIT_RESULTS 128              /* results by name (fit_gamma …); oldest are dropped */
#define LIMIT_CHECKPOINTS 64           /* checkpoints of a session */
#define LIMIT_OWN 32                   /* scenes that the user has named */
#define LIMIT_SYMBOL 31                /* bytes of the name of a user's variable or scene */
#define LIMIT_PARAMETERS 192           /* parameters of a typed scene, initial values included */
#define LIMIT_OBSERVED 192             /* `observe` lines of a typed scene */
#define LIMIT_EVENTS 16                /* events defined at once */
#define LIMIT_EVENT_TEXT 4096          /* bytes of an event's formula, and of its commands */
#define LIMIT_EVENT_RECORDS 1000000    /* events recorded in a run; one more stops it */
#define LIMIT_OVERLAY 4                /* other runs in a plot: each has a mark of its own */
#define LIMIT_LOG 2000                 /* lines that the log pane can show */
#define LIMIT_ORBITS 64                /* periodic orbits; the oldest are dropped */
#define LIMIT_BRANCHES 32              /* branches; the oldest are dropped */
#define LIMIT_BRANCH_POINTS 20000      /* points of a branch in each direction */
#define LIMIT_MODES 5                  /* damped sines of one fit */
