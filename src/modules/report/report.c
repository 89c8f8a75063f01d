/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module report: what the lab asks to hand in (hand_in.c), its check (check.c), and lessons
 * (lesson.c). --check runs hand_ins_check(). */
#include <hooke/module.h>
#include "modules/report/check.h"
#include "modules/report/lesson.h"

const struct module report_module = {
    .row = {"report", "", "reports for the lab, their check, and lessons", "", NULL},
    .needs = "documents pictures recording",
    .part_size = sizeof(struct lesson),
    .part_free = lesson_free,
    .store = {.put = lesson_put, .read = lesson_read},
    .prompt = {.typed = lesson_follow, .next = report_next, .label = lesson_label},
    .option =
        {
            .word = "check",
            .shown = " DIR ...",
            .brief = "run session.hk of each hand-in again and compare its values and figures;\n"
                     "                           status: the number of hand-ins that differ, at "
                     "most 125",
            .wants = "folders",
            .takes_first = true,
            .run = hand_ins_check,
        },
};
