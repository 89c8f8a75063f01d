/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions and the table of the force terms, all from terms.def. */
#include "scene/model/forces.h"
#include "scene/model/params.h"

#define TERM_BODIES
#include "scene/model/terms.def"
#undef TERM_BODIES

#define TERM_ROW(term, term_flags, text, source)                                                   \
    .row = {#term, "m/s^2", (text), (source), NULL}, .flags = (term_flags),                        \
    .equation = {term##_equation}, .force = FORCE_##term, .bind = term##_bind, .add = term##_add,  \
    .jacobian = term##_jacobian

static const struct term_row rows[] = {
#define CONSERVATIVE_TERM(name, flags, brief, citation)                                            \
    {TERM_ROW(name, (flags) | TERM_CONSERVATIVE, brief, citation), .potential = name##_potential},
#define POWERED_TERM(name, flags, brief, citation)                                                 \
    {TERM_ROW(name, flags, brief, citation), .power = name##_power},
#include "scene/model/terms.def"
};

_Static_assert(COUNT_OF(rows) <= TERM_MAX, "a system holds every term");

const struct catalog term_catalog = CATALOG("force term", rows);
