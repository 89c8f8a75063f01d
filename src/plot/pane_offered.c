/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which panes make sense for a session. */
#include <hooke/plot.h>

static bool has_series(const struct session *session)
{
    return session_run(session) || session_recording(session);
}

static bool has_mechanics(const struct session *session)
{
    const struct run *run = session_run(session);
    return run ? run->system.order == 2 : figure_recording(session, PLOT_VELOCITY) >= 0;
}

static bool has_phase(const struct session *session)
{
    const struct run *run = session_run(session);
    return run ? plot_fits(PLOT_PHASE, run->system.model) : has_mechanics(session);
}

static bool has_orbit(const struct session *session)
{
    const struct run *run = session_run(session);
    return run && plot_fits(PLOT_ORBIT, run->system.model);
}

static bool has_exact(const struct session *session)
{
    const struct run *run = session_run(session);
    return run && run->plan.exact_known;
}

static bool has_residual(const struct session *session)
{
    return figure_recording(session, PLOT_RESIDUAL) >= 0;
}

bool pane_offered(const struct session *session, enum pane pane)
{
    switch (((const struct pane_row *)(const void *)catalog_row(&pane_catalog, (size_t)pane))->of) {
    case PANE_OF_SERIES:
        return has_series(session);
    case PANE_OF_MECHANICS:
        return has_mechanics(session);
    case PANE_OF_PHASE:
        return has_phase(session);
    case PANE_OF_ORBIT:
        return has_orbit(session);
    case PANE_OF_EXACT:
        return has_exact(session);
    case PANE_OF_RESIDUAL:
        return has_residual(session);
    }
    return false;
}
