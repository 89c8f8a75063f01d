/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The phase portrait that a session shows, which is computed again only when the scene or the plane
 * changes. */
#pragma once

#include <hooke/session.h>
#include "modules/dynamics/portrait.h"

/* The portrait that was made last, and its request. It is a cache: never saved nor undone. */
struct stored_portrait {
    bool known; /* true if it is complete; one that was stopped is made again */
    struct scene scene;
    struct portrait_request request;
    struct portrait portrait;
};

/* Returns the stored portrait of the session, at first an unknown one, or NULL if out of memory. */
struct stored_portrait *stored_portrait(const struct session *session);
/* Returns true if the stored portrait has the same scene, values, variables and kind of lines as
 * the request; its region may differ. */
bool portrait_is_of(const struct stored_portrait *stored, const struct portrait_request *request);
/* Returns the stored portrait if it fits the request, else makes it; it remains valid until the
 * next one is made. Returns NULL with *error on failure. */
const struct portrait *session_portrait(const struct session *session,
                                        const struct portrait_request *request,
                                        struct error *error);
/* Frees the portrait. */
void stored_portrait_clear(struct stored_portrait *stored);
