/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The error estimate of adaptive runs in text: when it is computed, its line, and warnings. */
#include <hooke/run/opinion.h>

#include <hooke/command/handler.h>

#include <math.h>

/* Has the error of a run estimated, as far as the setting and the reply ask for it. Records have
 * the error among their fields, which justifies more work. */
void seek_opinion(const struct session *session, struct run *run, const struct reply *reply)
{
    const int kind = session->setup.settings.opinion;
    /* records have the error among their fields */
    const bool recorded = reply_wants_records(reply);
    enum opinion_effort effort;
    if (kind == OPINIONS_FULL)
        effort = OPINION_WHOLE;
    else
        effort = recorded ? OPINION_DEMANDED : OPINION_BRIEF;
    if (run->missed.t_begin == run->missed.t_end)
        run_missed_burst(run, &run->missed);
    if (kind == OPINIONS_FULL || (kind != OPINIONS_OFF && (recorded || !reply->quiet)))
        run_second_opinion(run, effort, session->front.cancel);
}

/* Appends how the error of the planned run will be estimated. */
void plan_opinion(const struct session *session, const struct system *system,
                  const struct plan *plan, struct buffer *text)
{
    const int kind = session->setup.settings.opinion;
    if (!plan->adaptive)
        return;
    buffer_format(text, "%-10s", "error");
    if (kind == OPINIONS_OFF)
        buffer_put(text, TEXT("not estimated, because of 'set opinion off'\n"));
    else if (plan->exact_known)
        buffer_put(text, TEXT("from the closed form, compared at some of the recorded rows\n"));
    else if (kind == OPINIONS_FULL)
        buffer_put(
            text,
            TEXT("from a second solution to the end, which is about as much work as the run\n"));
    else
        buffer_format(
            text,
            "from a second solution, %.0f %% of the run's work; half of it, or\n"
            "          %.0f evaluations, if no digit may be correct ('set opinion off': none)\n",
            100 * OPINION_BRIEF_SHARE, OPINION_BUDGET_DOUBT / system->n);
}

/* Appends the name of the solution that the run was compared with. */
static void put_solution(const struct opinion *opinion, struct buffer *text)
{
    if (opinion->method)
        buffer_format(text, "%s at tol = %s", opinion->method->row.name,
                      SHOWN_SHORT(opinion->tol, 2));
    else
        buffer_put(text, TEXT("the closed form"));
}

/* Appends that solution and how far it went: "dop853 at tol = 1e-7 up to t = 3 s". */
static void put_witness(const struct run *run, struct buffer *text)
{
    const struct opinion *opinion = &run->opinion;
    const bool at_event = !isnan(run_opinion_event(run));
    put_solution(opinion, text);
    if (opinion->t != run->t && (opinion->method || at_event))
        buffer_format(text, " up to t = %s, unknown beyond%s",
                      SHOWN_VALUE(opinion->t, QUANTITY_TIME, 4),
                      at_event ? ": whether the next event happens may depend on errors"
                               : " ('set opinion full' goes to the end)");
}

/* Returns true if the closed form of the scene is known. */
static bool is_exact_available(const struct run *run)
{
    const struct method *method = method_find("exact");
    enum drag drag = DRAG_DEFAULT;
    struct error ignored;
    return method && method_applies(method, &run->system, &drag, &ignored);
}

/* Reports the time from which no digit is certain: because the second solution differs, or because
 * variables came to rest within their tolerance. Returns true if `set opinion warn` makes this a
 * warning, else false with the error set. */
static bool reply_lost(const struct session *session, const struct run *run, struct reply *reply,
                       struct error *error)
{
    const struct opinion *opinion = &run->opinion;
    const double sunk = run_opinion_sunk(run);
    struct buffer text = {0};
    if (isnan(sunk)) {
        buffer_put(&text, TEXT("there "));
        put_solution(opinion, &text);
        buffer_format(&text, " differs from run %d by more than half the size of the motion",
                      run->number);
    } else {
        buffer_format(
            &text, "values came to rest within the tolerance, and their errors grow from t = %s on",
            SHOWN_VALUE(sunk, QUANTITY_TIME, 4));
    }
    const bool ok = session->setup.settings.opinion == OPINIONS_WARN;
    error_set(error, ERROR_NUMERICAL, "no digit is certain from t = %s on: %s",
              SHOWN_VALUE(opinion->lost, QUANTITY_TIME, 4), buffer_view(&text));
    buffer_free(&text);
    if (ok)
        reply_warning(reply, "%s", error->text);
    else
        error_hint(error,
                   is_exact_available(run)
                       ? "'method exact' is the closed form; run %d is kept"
                       : "a smaller tol moves that time later; for chaotic motion 'set opinion "
                         "warn' makes this a warning; run %d is kept",
                   run->number);
    return ok;
}

/* Warns of an error far above the tolerance; not if all variables are below their tolerances, which
 * another line reports and a smaller tol would not help. */
static void reply_large(const struct run *run, double times, struct reply *reply)
{
    double error_floor[LIMIT_VARIABLES];
    if (run_below_tolerance(run, error_floor) < run->system.n)
        reply_warning(reply,
                      "the error is about %s times the tolerance: errors of single steps have "
                      "grown along the run; a smaller tol reduces it",
                      SHOWN_SHORT(times, 1));
}

/* Appends the estimated error to the run's line, with warnings. Returns false with the error set if
 * no digit is certain. */
bool reply_opinion(const struct session *session, struct run *run, struct reply *reply,
                   struct error *error)
{
    const double spikes =
        10; /* ratio from which the largest error along the run is reported, too */
    const struct opinion *opinion = &run->opinion;
    const int digits = opinion->method ? 1 : 2;
    const bool asked = !reply->quiet && session->setup.settings.opinion != OPINIONS_OFF &&
                       run->plan.adaptive && run->steps > 0 && !stop_is_failure(run->stop);
    if (!isnan(run_opinion_sunk(run)))
        return reply_lost(session, run, reply, error);
    if (asked && isnan(opinion->t))
        reply_line(reply, "error not known: the second solution used up its allowed work "
                          "before the first comparison");
    if (!run_opinion_known(run))
        return true;
    const double times = opinion->error / run->controller.tol;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "error %s%s, %s tol", opinion->method ? "about " : "",
                  SHOWN_SHORT(opinion->error, digits), SHOWN_SHORT(times, digits));
    if (opinion->max > spikes * opinion->error)
        buffer_format(text, " (up to %s along the run)", SHOWN_SHORT(opinion->max, 1));
    buffer_put(text, TEXT(", by "));
    put_witness(run, text);
    bool ok = true;
    if (!isnan(opinion->lost))
        ok = reply_lost(session, run, reply, error);
    else if (times > OPINION_WRONG && !run->warned_error)
        reply_large(run, times, reply);
    run->warned_error |= times > OPINION_WRONG;
    return ok;
}

/* Replies which variables have no certain digit; at most three are named in text, JSON has a list
 * of them. */
void reply_below_tolerance(const struct run *run, struct reply *reply)
{
    enum { NAMED = 3 };
    double error_floor[LIMIT_VARIABLES];
    if (reply->quiet)
        return;
    const int count = run_below_tolerance(run, error_floor);
    struct buffer names = {0};
    int first = -1;
    for (int i = 0, named = 0; i < run->system.n && named < NAMED; i++) {
        if (!(error_floor[i] > 0))
            continue;
        first = first < 0 && !(run->system.atol[i] > 0) ? i : first;
        buffer_format(&names, "%s%s", named++ > 0 ? ", " : "",
                      system_variable(&run->system, i).name);
    }
    if (count > NAMED)
        buffer_format(&names, " and %d more", count - NAMED);
    if (count > 0) {
        const char *const advice = first < 0 ? "; a smaller tol may help" : "";
        reply_line(reply, "no digit of %s is certain: %s tolerance or error%s", buffer_view(&names),
                   count > 1 ? "they are below their" : "it is below its", advice);
        if (first >= 0)
            reply_line(reply, "'atol %s = VALUE' sets a smaller tolerance",
                       system_variable(&run->system, first).name);
    }
    buffer_free(&names);
}
