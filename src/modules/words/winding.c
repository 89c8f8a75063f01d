/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Counts how often a curve in a plane winds around its centre. */
#include "modules/words/internal.h"

#include <hooke/base/numeric.h>

/* The origin is the centre if the curve winds around it at least this fraction of the times that it
 * winds around the middle. */
#define ORIGIN_TURNS_MIN 0.9

/* A centre with the units of both directions. */
struct frame {
    struct curve_point centre, half;
};

/* Returns the direction of a point from the centre. */
static double direction_angle(const struct frame *f, struct curve_point p)
{
    return atan2((p.y - f->centre.y) / f->half.y, (p.x - f->centre.x) / f->half.x);
}

/* Returns the distance of a point from the centre, in units of x. */
static double frame_distance(const struct frame *f, struct curve_point p)
{
    return hypot(p.x - f->centre.x, (p.y - f->centre.y) * (f->half.x / f->half.y));
}

/* Returns how often the curve winds around the frame's centre, counterclockwise positive. Sets
 * *last to the distance from the centre at the end of the last complete turn, interpolated in the
 * angle; a first pass counts the turns, a second one finds that end. */
static double turns_about(const struct frame *f, const struct points *p, double *last)
{
    double sum = 0;
    for (int pass = 0; pass < 2; pass++) {
        const double whole = pass ? TWO_PI * floor(fabs(sum) / TWO_PI) : HUGE_VAL;
        double turned = 0;
        for (size_t i = 1; points_go_on(p, i); i++) {
            const double step = remainder(direction_angle(f, point_at(p, i)) -
                                              direction_angle(f, point_at(p, i - 1)),
                                          TWO_PI),
                         previous = fabs(turned);
            turned += step;
            if (fabs(turned) >= whole && previous < whole) {
                const double part = (whole - previous) / fabs(step);
                *last = (1 - part) * frame_distance(f, point_at(p, i - 1)) +
                        part * frame_distance(f, point_at(p, i));
            }
        }
        sum = turned;
    }
    return sum / TWO_PI;
}

/* Finds how often a curve in a plane winds around its centre: the origin if it winds around that
 * about as often, otherwise the middle of its extent. `equal` means that both axes have the same
 * scale. Sets nothing for less than one turn. */
void read_winding(const struct points *points, bool equal, struct curve_reading *reading)
{
    struct curve_point low = point_at(points, 0), high = low;
    for (size_t i = 1; points_go_on(points, i); i++) {
        low.x = fmin(low.x, points->x[i]);
        low.y = fmin(low.y, points->y[i]);
        high.x = fmax(high.x, points->x[i]);
        high.y = fmax(high.y, points->y[i]);
    }
    struct frame box = {{0.5 * (low.x + high.x), 0.5 * (low.y + high.y)},
                        {0.5 * (high.x - low.x), 0.5 * (high.y - low.y)}};
    if (equal)
        box.half.x = box.half.y = fmax(box.half.x, box.half.y);
    if (!(box.half.x > 0 && box.half.y > 0))
        return;
    const struct frame origin = {{0, 0}, box.half};
    double far[2] = {NAN, NAN};
    const double about_box = turns_about(&box, points, &far[0]),
                 about_origin = turns_about(&origin, points, &far[1]);
    const bool use_origin = fabs(about_origin) >= ORIGIN_TURNS_MIN * fabs(about_box);
    const struct frame *frame = use_origin ? &origin : &box;
    reading->winds = use_origin ? about_origin : about_box;
    if (!(fabs(reading->winds) >= 1))
        return;
    reading->course = COURSE_WINDS;
    reading->about_origin = use_origin;
    reading->centre = frame->centre;
    reading->distance[0] = frame_distance(frame, point_at(points, 0));
    reading->distance[1] = far[use_origin];
}
