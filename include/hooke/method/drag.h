/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Choices that a session makes beside a method; it needs nothing else of methods. */
#pragma once

/* Ways in which drag (forces that depend on velocity) enters a step. The row of a method lists
 * those that it supports. */
enum drag { DRAG_DEFAULT, DRAG_EXACT, DRAG_IMPLICIT, DRAG_EXPLICIT, DRAG_COUNT };
