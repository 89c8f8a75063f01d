/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a session chooses beside a method: it needs no more of methods. */
#ifndef HOOKE_METHOD_DRAG_H
#define HOOKE_METHOD_DRAG_H

/* How drag (forces that depend on velocity) enters a step; which of them a method knows, its row
 * says. */
enum drag { DRAG_DEFAULT, DRAG_EXACT, DRAG_IMPLICIT, DRAG_EXPLICIT, DRAG_COUNT };

#endif
