/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The style sheet of pictures: colours, dashes, and lengths for a size of page. */
#include "modules/pictures/style.h"

#include "modules/pictures/pictures.h"

#include <math.h>

const double style_black[3] = {0, 0, 0}, style_white[3] = {1, 1, 1},
             style_gray[3] = {0.35, 0.35, 0.35}, style_grid[3] = {0.85, 0.85, 0.85};

/* Palette of Okabe and Ito, Color Universal Design (2008), without yellow, which is hardly visible
 * on paper: blue, nearly black, orange, green, sky blue, vermilion, purple. In this order
 * neighbours differ in grey, too. */
const double style_palette[][3] = {{0, 0.447, 0.698},  {0.1, 0.1, 0.1},       {0.902, 0.624, 0},
                                   {0, 0.62, 0.451},   {0.337, 0.706, 0.914}, {0.835, 0.369, 0},
                                   {0.8, 0.475, 0.655}};
const size_t style_palette_count = COUNT_OF(style_palette);

const struct style_dashes style_dashes[] = {
    {{0}, 0}, {{6, 4}, 2}, {{0, 2.6}, 2}, {{7, 3.5, 0, 3.5}, 4}, {{3, 4}, 2}, {{12, 4}, 2}};
const size_t style_dashes_count = COUNT_OF(style_dashes);

#define SCALE_MIN 0.6 /* gives text of 6 pt; smaller text is not legible on paper */
#define SCALE_MAX 2.5 /* gives text of 25 pt */

/* Lengths grow with the fourth root of the area, that is the root of the page's width. */
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
