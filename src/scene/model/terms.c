/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The table of the oscillator's force terms, from terms.def. */
#include <hooke/base/catalog.h>
#include "scene/model/forces.h"
#include "scene/model/params.h"

#include <string.h>

#define TERM_BODIES
#include "scene/model/terms.def"
#undef TERM_BODIES

/* Dry friction has no text, because at rest it depends on all other forces. */
#define friction_text NULL

#define TERM_ROW(term, term_flags, description, source)                                            \
    .row = {#term, "m/s^2", (description), (source), NULL}, .flags = (term_flags),                 \
    .equation = {term##_equation}, .force = FORCE_##term, .bind = term##_bind, .add = term##_add,  \
    .jacobian = term##_jacobian, .text = term##_text

static const struct term_row rows[] = {
#define CONSERVATIVE_TERM(name, flags, brief, citation)                                            \
    {TERM_ROW(name, (flags) | TERM_CONSERVATIVE, brief, citation), .potential = name##_potential},
#define POWERED_TERM(name, flags, brief, citation) {TERM_ROW(name, flags, brief, citation)},
#include "scene/model/terms.def"
};

_Static_assert(COUNT_OF(rows) <= TERM_MAX, "a system holds every term");

const struct catalog term_catalog = CATALOG("force term", rows);

/* Calls the bind function of each row in turn; a term stays if that returns true. */
void terms_bind(const double *param, struct system *system)
{
    const struct term_row *row = rows;
    struct bound_term *term = system->term;
#define BIND_TERM(name)                                                                            \
    term->row = row++;                                                                             \
    memset(term->c, 0, TERM_COEFFICIENTS * sizeof *term->c);                                       \
    term += name##_bind(param, term->c, &system->oscillator);
#define CONSERVATIVE_TERM(name, ...) BIND_TERM(name)
#define POWERED_TERM(name, ...) BIND_TERM(name)
#include "scene/model/terms.def"
    system->terms = (int)(term - system->term);
}
