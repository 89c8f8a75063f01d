/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A precision study for programs. */
#include <hooke/report.h>

#include <math.h>
#include <stdlib.h>

/* The fastest for each error, all that tie with it, and what comes next. */
static void reply_fastest(const struct precision *precision, struct reply *reply)
{
    struct precision_cost *cost = calloc((size_t)precision->curves + 1, sizeof *cost);
    for (int level = 1; cost && level <= LEVELS; level++) {
        const double error = pow(10, -level);
        const int count = precision_fastest(precision, error, cost, NULL);
        int tied = 1;
        if (count == 0 || isnan(cost->minimum))
            continue;
        while (tied < count && cost[tied].tied)
            tied++;
        const bool follows = tied < count;
        reply_begin(reply, "fastest");
        reply_real(reply, "error", error);
        reply_string(reply, "method", precision->curve[cost->curve].by.method->row.name);
        reply_real(reply, "time_min", cost->minimum);
        reply_array(reply, "tied_with");
        for (int i = 1; i < tied; i++)
            reply_string(reply, NULL, precision->curve[cost[i].curve].by.method->row.name);
        reply_close(reply);
        reply_string(reply, "next",
                     follows ? precision->curve[cost[tied].curve].by.method->row.name : NULL);
        reply_real(reply, "next_times", follows ? cost[tied].minimum / cost->minimum : NAN);
        reply_end(reply);
    }
    free(cost);
}

void reply_precision(const struct session *session, const struct precision *precision,
                     struct arena *arena, struct reply *reply)
{
    const struct precision_row *rows = precision_rows(precision, arena);
    struct buffer reference = {0};
    if (!rows)
        return;
    reference_describe(&precision->reference, &reference);
    reply_result(session, reply, "precision", &precision_columns, rows, (size_t)precision->points,
                 NULL, buffer_view(&reference));
    buffer_free(&reference);
    reply_records(reply, "precision", &precision_columns, rows, (size_t)precision->points);
    reply_fastest(precision, reply);
}
