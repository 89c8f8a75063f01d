/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which members of a session its file keeps as they are. */
#include <hooke/session/stored.h>

#include <float.h>
#include <math.h>

#define OF_SESSION(member) FIELD_OF(struct session, member)
#define IN_SESSION(member, least, most) FIELD_IN(struct session, member, least, most)
const struct field store_session[] = {
    IN_SESSION(current_run, -1, LIMIT_RUNS - 1),
    OF_SESSION(next_run),
    IN_SESSION(next_id, 0, 0x1p62),
    OF_SESSION(said_method),
    OF_SESSION(said_assumed),
    IN_SESSION(current_recording, -1, LIMIT_RECORDINGS - 1),
    OF_SESSION(data_is_latest),
    OF_SESSION(has_fit),
    OF_SESSION(fit_of),
    IN_SESSION(fit_zero, -DBL_MAX, DBL_MAX),
    OF_SESSION(fit_free),
    IN_SESSION(fit_modes, 0, MODES_MAX),
    OF_SESSION(adopted.known),
    OF_SESSION(adopted.exact),
    OF_SESSION(adopted.of),
    OF_SESSION(studied_runs),
    IN_SESSION(live.speed, DBL_TRUE_MIN, INFINITY),
    OF_SESSION(setup.method_chosen),
    IN_SESSION(setup.drag, DRAG_DEFAULT, DRAG_COUNT - 1),
    OF_SESSION(setup.fixed),
    OF_SESSION(setup.origin),
};
const size_t store_session_count = COUNT_OF(store_session);

#define OF_VIEW(member) FIELD_OF(struct view, member)
#define IN_VIEW(member, least, most) FIELD_IN(struct view, member, least, most)
const struct field store_view[] = {
    IN_VIEW(layout, 0, LAYOUT_LOG),
    OF_VIEW(full),
    OF_VIEW(x),
    OF_VIEW(y),
    IN_VIEW(window, 0, DBL_MAX),
    IN_VIEW(trail, 0, INFINITY),
    OF_VIEW(paging),
    OF_VIEW(overlay),
    IN_VIEW(overlays, 0, LIMIT_OVERLAY),
    OF_VIEW(cursors),
    OF_VIEW(start),
    IN_VIEW(starts, 0, LIMIT_STARTS),
    IN_VIEW(start_n, 0, STARTS_VARIABLES),
};
const size_t store_view_count = COUNT_OF(store_view);

#define QUANTITY_OF(type, member)                                                                  \
    {                                                                                              \
#member, offsetof(type, member), sizeof(enum quantity), FIELD_QUANTITY, 0, 0               \
    }

#define OF_VALUE(member) FIELD_OF(struct named_value, member)
static const struct field named_value_members[] = {
    OF_VALUE(name),        OF_VALUE(value),
    OF_VALUE(uncertainty), QUANTITY_OF(struct named_value, quantity),
    OF_VALUE(below),
};

#define OF_MEASUREMENT(member) FIELD_OF(struct measurement, member)
static const struct field measurement_members[] = {
    OF_MEASUREMENT(quantity), OF_MEASUREMENT(exact),
    OF_MEASUREMENT(value),    QUANTITY_OF(struct measurement, unit),
    OF_MEASUREMENT(periods),  OF_MEASUREMENT(at),
    OF_MEASUREMENT(energy),   OF_MEASUREMENT(statement),
    OF_MEASUREMENT(of),
};

#define OF_FIT(member) FIELD_OF(struct stored_fit, member)
static const struct field stored_fit_members[] = {
    OF_FIT(fit.period),
    OF_FIT(fit.omega),
    OF_FIT(fit.gamma),
    OF_FIT(fit.amplitude),
    OF_FIT(fit.phase),
    OF_FIT(fit.offset),
    OF_FIT(fit.rms),
    OF_FIT(fit.used),
    OF_FIT(fit.rejected),
    OF_FIT(fit.window),
    OF_FIT(fit.halves),
    OF_FIT(fit.half_periods),
    OF_FIT(fit.preferred),
    OF_FIT(fit.converged),
    OF_FIT(fit.iterations),
    OF_FIT(fit.autocorrelation),
    OF_FIT(fit.warning),
    OF_FIT(fit.warnings),
    OF_FIT(fit.t0),
    OF_FIT(fit.drift),
    OF_FIT(fit.drag),
    OF_FIT(fit.covariance),
    QUANTITY_OF(struct stored_fit, quantity),
    OF_FIT(k),
    OF_FIT(exact),
    OF_FIT(statement),
    OF_FIT(of),
};

#define OF_ENTRY(member) FIELD_OF(struct entry, member)
const struct field store_entry[] = {
    OF_ENTRY(text),     OF_ENTRY(len),    OF_ENTRY(full),
    OF_ENTRY(full_len), OF_ENTRY(output), OF_ENTRY(flags),
};
const size_t store_entry_count = COUNT_OF(store_entry);

#define ARRAY_OF(array, counted, limit, members)                                                   \
    {                                                                                              \
#array, offsetof(struct session, array), sizeof *((struct session *)0)->array,             \
            offsetof(struct session, counted), limit, members, COUNT_OF(members)                   \
    }
const struct store_array store_arrays[] = {
    [STORE_LETS] = ARRAY_OF(setup.let, setup.lets, LIMIT_LET, named_value_members),
    [STORE_RESULTS] = ARRAY_OF(result, results, LIMIT_RESULTS, named_value_members),
    [STORE_MEASUREMENTS] = ARRAY_OF(measurement, measurements, 0, measurement_members),
    [STORE_FITS] = ARRAY_OF(stored_fit, stored_fits, 0, stored_fit_members),
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
