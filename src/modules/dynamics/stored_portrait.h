/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The phase portrait that a session shows. */
#pragma once

#include <hooke/session.h>
#include "modules/dynamics/portrait.h"

/* The portrait that was made last, and its request. Nothing of it is the user's. */
struct stored_portrait {
    bool known; /* complete; a portrait that was stopped is made again */
    struct scene scene;
    struct portrait_request request;
    struct portrait portrait;
};

/* That of the session, which knows none at first. Returns NULL if out of memory. */
struct stored_portrait *stored_portrait(const struct session *session);
/* Returns true if the portrait is of that scene with these values and variables. */
bool portrait_is_of(const struct stored_portrait *stored, const struct portrait_request *request);
/* Returns the stored portrait, or makes it if it is another one; it remains valid until the next
 * one is made. Returns NULL after an error. */
const struct portrait *session_portrait(const struct session *session,
                                        const struct portrait_request *request,
                                        struct error *error);
void stored_portrait_clear(struct stored_portrait *stored);
