/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a derived number was computed with: which of these values were stated without an
 * uncertainty and count as exact, and how uncertain the others make it. */
#ifndef HOOKE_COMMAND_INPUTS_H
#define HOOKE_COMMAND_INPUTS_H

#include "internal.h"

#define INPUTS_MOST 16

struct inputs {
    const char *exact[INPUTS_MOST]; /* names, each once */
    int exacts;
    double relative; /* uncertainty of a product or quotient of all of them (GUM 5.1.6) */
};

/* The name has to last as long as the inputs. Zero enters nothing. */
void inputs_use(struct inputs *inputs, const char *name, struct measured value);
/* Parameters of the scene; names: "m rho area", those that it has. */
void inputs_use_params(struct inputs *inputs, const struct scene *scene, const char *names);
/* Every parameter but those that are free that the motion depends on. */
void inputs_use_motion(struct inputs *inputs, const struct scene *scene, const bool *is_free);
/* The value, more uncertain by all of the inputs. */
struct measured inputs_widen(const struct inputs *inputs, struct measured value);

/* A line that begins with a newline and says which are exact; nothing where none is. */
void inputs_put(const struct inputs *inputs, struct buffer *text);
/* The array `exact` of the open record. */
void inputs_reply(const struct inputs *inputs, struct reply *reply);
/* For the report: the names, and back again (the text has to last). */
void inputs_keep(const struct inputs *inputs, struct exact_names *names);
void inputs_recall(struct inputs *inputs, const struct exact_names *names);

#endif
