/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The style sheet of pictures. */
#include "modules/pictures/style.h"

#include "modules/pictures/pictures.h"

#include <math.h>

const double style_black[3] = {0, 0, 0}, style_white[3] = {1, 1, 1},
             style_gray[3] = {0.35, 0.35, 0.35}, style_grid[3] = {0.85, 0.85, 0.85};

/*
 * Okabe and Ito, Color Universal Design (2008), without the yellow, which paper swallows: blue,
 * nearly black, orange, green, sky blue, vermilion, purple, so that those beside each other differ
 * in grey, too. Data over a run are black on blue.
 */
const double style_palette[][3] = {{0, 0.447, 0.698},  {0.1, 0.1, 0.1},       {0.902, 0.624, 0},
                                   {0, 0.62, 0.451},   {0.337, 0.706, 0.914}, {0.835, 0.369, 0},
                                   {0.8, 0.475, 0.655}};
const size_t style_palette_count = COUNT_OF(style_palette);

const struct style_dashes style_dashes[] = {
    {{0}, 0}, {{6, 4}, 2}, {{0, 2.6}, 2}, {{7, 3.5, 0, 3.5}, 4}, {{3, 4}, 2}, {{12, 4}, 2}};
const size_t style_dashes_count = COUNT_OF(style_dashes);

#define SCALE_MIN 0.6 /* 6 pt of text: less is not read on paper */
#define SCALE_MAX 2.5

struct picture_style picture_style(double width, double height)
{
    const double area = width * height / ((double)PICTURE_WIDTH * PICTURE_HEIGHT);
    const double scale = fmin(fmax(pow(area, 0.25), SCALE_MIN), SCALE_MAX);
    return (struct picture_style){
#define LENGTH(name, value, brief) .name = scale * (value),
        STYLE_LENGTHS(LENGTH)
#undef LENGTH
    };
}
