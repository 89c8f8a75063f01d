/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which members of a session its file keeps as they are. */
#include "session/store/store.h"

#define OF_SESSION(member) FIELD_OF(struct session, member)
const struct field store_session[] = {
    OF_SESSION(current_run),    OF_SESSION(next_run),      OF_SESSION(next_id),
    OF_SESSION(said_method),    OF_SESSION(said_assumed),  OF_SESSION(current_recording),
    OF_SESSION(data_is_latest), OF_SESSION(has_fit),       OF_SESSION(fit_of),
    OF_SESSION(fit_zero),       OF_SESSION(fit_free),      OF_SESSION(fit_modes),
    OF_SESSION(adopted.known),  OF_SESSION(adopted.exact), OF_SESSION(adopted.of),
    OF_SESSION(studied_runs),   OF_SESSION(live.speed),    OF_SESSION(setup.method_chosen),
    OF_SESSION(setup.drag),     OF_SESSION(setup.fixed),   OF_SESSION(setup.origin),
};
const size_t store_session_count = COUNT_OF(store_session);

#define OF_VIEW(member) FIELD_OF(struct view, member)
const struct field store_view[] = {
    OF_VIEW(layout), OF_VIEW(full),   OF_VIEW(x),       OF_VIEW(y),        OF_VIEW(window),
    OF_VIEW(trail),  OF_VIEW(paging), OF_VIEW(overlay), OF_VIEW(overlays), OF_VIEW(cursors),
    OF_VIEW(start),  OF_VIEW(starts), OF_VIEW(start_n),
};
const size_t store_view_count = COUNT_OF(store_view);

#define ARRAY_OF(array, counted, limit)                                                            \
    {                                                                                              \
#array, offsetof(struct session, array), sizeof *((struct session *)0)->array,             \
            offsetof(struct session, counted), limit                                               \
    }
const struct store_array store_arrays[] = {
    ARRAY_OF(setup.let, setup.lets, LIMIT_LET),
    ARRAY_OF(result, results, LIMIT_RESULTS),
    ARRAY_OF(measurement, measurements, 0),
    ARRAY_OF(stored_fit, stored_fits, 0),
};
const size_t store_array_count = COUNT_OF(store_arrays);

#define OF_LESSON(member) FIELD_OF(struct lesson, member)
const struct field store_lesson[] = {
    OF_LESSON(step),
    OF_LESSON(steps),
    OF_LESSON(begun),
    OF_LESSON(seed),
};
const size_t store_lesson_count = COUNT_OF(store_lesson);
