/* SPDX-License-Identifier: GPL-3.0-or-later */
/* drag: the variants of drag that a session can choose for a method, in a header without the
 * methods themselves. */
#pragma once

/* Ways in which a step treats drag (forces that depend on velocity): the method's default, by the
 * exact flow of linear and quadratic drag, implicitly, or explicitly. The row of a method lists
 * those that it supports. */
enum drag { DRAG_DEFAULT, DRAG_EXACT, DRAG_IMPLICIT, DRAG_EXPLICIT, DRAG_COUNT };
