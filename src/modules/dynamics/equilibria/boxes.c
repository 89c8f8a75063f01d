/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "modules/dynamics/equilibria/boxes.h"

#include <stdlib.h>
#include <string.h>

static const size_t first_room = 256;

bool box_queue_add(struct box_queue *queue, const struct state_box *box)
{
    if (queue->end == queue->room && queue->first > queue->room / 2) {
        queue->end -= queue->first;
        memmove(queue->box, queue->box + queue->first, queue->end * sizeof *queue->box);
        queue->first = 0;
    }
    if (queue->end == queue->room) {
        const size_t room = queue->room > 0 ? 2 * queue->room : first_room;
        struct state_box *more = realloc(queue->box, room * sizeof *more);
        if (!more)
            return false;
        queue->box = more;
        queue->room = room;
    }
    queue->box[queue->end++] = *box;
    return true;
}

bool box_queue_take(struct box_queue *queue, struct state_box *box)
{
    if (queue->first == queue->end)
        return false;
    *box = queue->box[queue->first++];
    return true;
}

bool box_lies_in(int n, const struct interval *box, const struct interval *other)
{
    bool inside = true;
    for (int i = 0; i < n; i++)
        inside = inside && box[i].lo >= other[i].lo && box[i].hi <= other[i].hi;
    return inside;
}

bool boxes_meet(int n, const struct interval *box, const struct interval *other)
{
    bool meet = true;
    for (int i = 0; i < n; i++)
        meet = meet && box[i].lo <= other[i].hi && box[i].hi >= other[i].lo;
    return meet;
}
