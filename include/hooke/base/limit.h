/* SPDX-License-Identifier: GPL-3.0-or-later */
/* base: limits, in one table that the man page shows. */
#pragma once

#define LIMIT_LINE (1u << 20)          /* bytes in a command line */
#define LIMIT_TOKENS 4096              /* words in a statement */
#define LIMIT_EXPR_DEPTH 200           /* parentheses and operators nested in an expression */
#define LIMIT_EXPR_SIZE 4096           /* operations in an expression */
#define LIMIT_SOURCE_DEPTH 16          /* files that source files */
#define LIMIT_NAME 63                  /* bytes in a name */
#define LIMIT_RUNS 256                 /* runs kept */
#define LIMIT_RECORDINGS 64            /* recordings kept */
#define LIMIT_MODULES 24               /* modules of a build */
#define LIMIT_UNDO 200                 /* undo levels */
#define LIMIT_HISTORY 100000           /* lines and statements kept of those typed */
#define LIMIT_REQUESTS 65536           /* things asked of a run: go on, back, change */
#define LIMIT_CHANGES 8192             /* times at which parameters of a run were changed */
#define LIMIT_MEASUREMENTS 1024        /* measurements kept: the oldest go */
#define LIMIT_FITS 256                 /* fits kept: the oldest go */
#define LIMIT_HISTORY_TEXT (1u << 24)  /* bytes of all lines and statements kept */
#define LIMIT_VARIABLES 64             /* state variables of a scene */
#define LIMIT_COLUMNS 1024             /* columns of a data file */
#define LIMIT_FILE (1u << 30)          /* bytes of a data file */
#define LIMIT_SAMPLES (1u << 20)       /* samples of a trace before it is decimated */
#define LIMIT_STEPS 9007199254740992.0 /* 2^53: t0 + i dt is exact in i up to here */
#define LIMIT_SCRIPT (1u << 26)        /* bytes of a file of commands */
#define LIMIT_LET 128                  /* variables made by let */
#define LIMIT_RESULTS 128              /* results by name (fit_gamma …): the oldest go */
#define LIMIT_CHECKPOINTS 64           /* checkpoints */
#define LIMIT_OWN 32                   /* scenes of the user's own, by name */
#define LIMIT_SYMBOL 31                /* bytes in the name of a variable or scene of one's own */
#define LIMIT_PARAMETERS 192           /* typed scene: with initial values and t0 */
#define LIMIT_OBSERVED 192             /* quantities that a typed scene observes */
#define LIMIT_EVENTS 16                /* events looked for at once */
#define LIMIT_EVENT_TEXT 4096          /* bytes of an event's formula, and of its commands */
#define LIMIT_EVENT_RECORDS 1000000    /* kept of a run: one more is STOP_FULL */
#define LIMIT_OVERLAY 4                /* runs laid over another: as have marks of their own */
#define LIMIT_LOG 2000                 /* lines of the log pane */
#define LIMIT_ORBITS 64                /* periodic orbits kept: the oldest go */
#define LIMIT_BRANCHES 32              /* branches kept: the oldest go */
#define LIMIT_BRANCH_POINTS 20000      /* points that a branch goes on for, each way */
#define LIMIT_MODES 5                  /* damped sines fitted at once */
