/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions and the table of the force terms, all from terms.def. */
#include <math.h>

#include "params.h"

/* Not every term needs all that a row's function is given. */
#define UNUSED __attribute__((__unused__))
#define TERM_BIND(name) static bool name##_bind(const double *param, double *c, struct oscillator *oscillator)
#define TERM_ADD(name) static void name##_add(const double *c, UNUSED double t, UNUSED const double *y, double *a)
#define TERM_JACOBIAN(name)                                                                                            \
    static void name##_jacobian(const double *c, UNUSED double t, UNUSED const double *y, double *jac)
#define TERM_POTENTIAL(name) static double name##_potential(const double *c, const double *y)
#define TERM_POWER(name) static double name##_power(const double *c, UNUSED double t, const double *y)

#define TERM_BODIES
#include "terms.def"
#undef TERM_BODIES

#define TERM_ROW(term, term_flags, text, source)                                                                       \
    .row = {#term, "m/s^2", (text), (source), NULL}, .flags = (term_flags), .bind = term##_bind, .add = term##_add,    \
    .jacobian = term##_jacobian

static const struct term_row rows[] = {
#define CONSERVATIVE_TERM(name, flags, brief, citation)                                                                \
    {TERM_ROW(name, (flags) | TERM_CONSERVATIVE, brief, citation), .potential = name##_potential},
#define POWERED_TERM(name, flags, brief, citation) {TERM_ROW(name, flags, brief, citation), .power = name##_power},
#include "terms.def"
};

_Static_assert(COUNT_OF(rows) <= TERM_MAX, "a system holds every term");

const struct catalog term_catalog = CATALOG("force term", rows);
