/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pixels as DEC terminals take them (VT330/VT340 Programmer Reference, volume 2, 1987,
 * chapter 14): bands of six rows, a character for each column and colour. */
#pragma once

#include <hooke/base/text.h>

/* most colours of an image */
#define SIXEL_COLORS 64

/*
 * Appends the image as a whole sequence, from ESC P to ESC \, with at most SIXEL_COLORS colours,
 * the most frequent ones. The rows in `pixel` have `stride` bytes, with four bytes per pixel, in
 * the machine's words 0x00RRGGBB. Returns false if out of memory.
 */
bool sixel_write(const unsigned char *pixel, size_t stride, int width, int height,
                 struct buffer *output);
