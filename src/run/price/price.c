/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Prices in instructions of what a run does, and the two lists that `plan` makes of them: computed
 * and left out. The constants were counted by callgrind (x86-64, gcc -O2); tests/growth/prices.py
 * counts them again. They hold within a factor of about 1.5, which suffices for a decision. */
#include <hooke/base/catalog.h>
#include <hooke/base/number.h>
#include <hooke/run/price.h>
#include <hooke/run/unresolved.h>
#include <hooke/scene/typed.h>

#include "run/energy/work.h"
#include "run/event/watch.h"
#include "run/price/evaluation.h"

#include <math.h>
#include <stdio.h>

/* ---- parts of a run ---- */

/* Instructions to set up a run, to compile typed equations for it, and for its summary. */
static const double setting_up = 10e3, setting_up_typed = 160e3, summary = 20e3;

/* Returns the instructions of all steps, in the way that they will be made: propagator, adaptive or
 * implicit, multistep, general, or by a kernel. */
static double steps_price(const struct run_scenario *s, const struct run_work *work)
{
    const struct method *method = s->method;
    const double n = s->system->n, propagator = 16e3, per_propagated = 4, kernel_step = 6,
                 general_step = 40, stop_at_kinks = 130, multistep = 500, typed_splitting = 110;
    const bool general = s->settings->kernel == KERNEL_GENERAL || s->settings->compensated;
    if (s->plan->propagates)
        return propagator + per_propagated * work->steps;
    if (s->plan->adaptive || method->flags & METHOD_IMPLICIT || method->rosenbrock)
        return work->evals * solver_evaluation_price(s->system, method, s->plan->adaptive);
    if (method->flags & METHOD_MULTISTEP)
        return work->evals * (multistep + evaluation_price_called(s->system));
    const double turning = method_turns(method, s->system) ? stop_at_kinks : 0;
    if (general || !method_kernel(method, s->system, s->settings->drag))
        return work->steps * (general_step + turning) +
               work->evals * (8 * n + evaluation_price_called(s->system));
    const bool splits_typed = method->splitting && typed_lines(s->system->model) > 0;
    return work->steps * (kernel_step + turning + (splits_typed ? typed_splitting : 0)) +
           work->evals * (4 * n + evaluation_price(s->system));
}

/* Returns the predicted number of instructions for recording the rows of all steps. Steps in blocks
 * are computed in the trace and only checked; long runs are thinned; runs with events, and adaptive
 * runs without a kernel, record one step at a time. */
static double rows_price(const struct run_scenario *s, const struct run_work *work)
{
    /* measured instructions per step */
    static const double in_place = 3.3, in_place_adaptive = 30, one_by_one = 135, thinned = 30;
    const bool has_kernel =
        s->settings->kernel != KERNEL_GENERAL && method_controlled_kernel(s->method, s->system);
    if (s->events || (s->plan->adaptive && !has_kernel))
        return one_by_one * work->steps;
    const bool thins = s->settings->record.rule == RECORD_AUTO && work->steps >= LIMIT_SAMPLES;
    double each;
    if (s->plan->adaptive)
        each = in_place_adaptive;
    else
        each = s->plan->propagates ? 0 : in_place;
    return (each + (thins ? thinned : 0)) * work->steps;
}

/* Returns the predicted number of instructions of run_diagnose(). Rows of fixed steps are compared
 * with their slopes by run_find_strange_steps(); of adaptive steps only the lengths are compared.
 * The constants are measured instructions per row. */
static double strange_price(const struct run_scenario *s, const struct run_work *work)
{
    const struct recording_rule *record = &s->settings->record;
    const double each = 100 + 200 * (double)s->system->n, a_block = 450,
                 a_change = 3 * (double)s->system->n, a_length = 16;
    const double rows = fmin(work->steps, LIMIT_SAMPLES);
    if (run_is_never_singular(s->system))
        return 0;
    if (s->plan->adaptive)
        return a_length * rows;
    if (record->rule == RECORD_TIMES || (record->rule == RECORD_EVERY && record->every > 1))
        return 0;
    bool picks;
    const size_t max = run_rows_looked_max(s->system, s->method, work->evals, rows, &picks);
    const double looked = rows / (1 + floor(rows / (double)max));
    return looked * (each + 3 * evaluation_price_called(s->system)) +
           (picks && looked < work->steps ? a_block * looked + a_change * work->steps : 0);
}

/* Returns the instructions for one step of the energy balance. */
static double balance_row_price(const struct run_scenario *s)
{
    /* The work in a long step of an adaptive run is found by solving the equations again. */
    static const double integrated = 3600, work_typed = 4000, solved = 20e3, solved_typed = 50e3,
                        plain = 21, several = 65, work_linear = 55, work = 105, across_kink = 90;
    const struct system *system = s->system;
    const double forces = evaluation_price(system);
    if (typed_lines(system->model) > 0 && s->plan->ledger)
        return s->plan->adaptive ? solved_typed : work_typed;
    if (typed_lines(system->model) > 0)
        return typed_potential_is_integrated(system) ? integrated
                                                     : 2 * evaluation_price_called(system);
    if (s->plan->ledger && s->plan->adaptive)
        return solved;
    if (s->plan->ledger) {
        const double step = system->linear ? work_linear : work;
        return step + 0.7 * forces + (system->kinks ? across_kink : 0);
    }
    return system->n == 2 ? plain + forces / 4 : several * system->n;
}

/* Returns true if rows are more than a step apart. */
static bool has_apart_rows(const struct run_scenario *s, const struct run_work *work)
{
    const struct recording_rule *record = &s->settings->record;
    return record->rule == RECORD_TIMES || (record->rule == RECORD_EVERY && record->every > 1) ||
           (record->rule == RECORD_AUTO && !(work->steps < LIMIT_SAMPLES));
}

/* Returns true if the balance is kept while the run steps, because its rows are more than a step
 * apart and its steps cannot be repeated. */
static bool keeps_balance(const struct run_scenario *s, const struct run_work *work)
{
    return has_apart_rows(s, work) &&
           (s->settings->record.rule == RECORD_TIMES || s->settings->compensated || s->events);
}

/* Returns true if the summary of the run shows the energy balance of all steps. */
static bool shows_balance(const struct run_scenario *s, const struct run_work *work)
{
    return s->system->energy &&
           (keeps_balance(s, work) || ledger_is_brief(s->plan, (int64_t)work->steps));
}

/* Returns the instructions for the balance of all steps, which are repeated where rows are more
 * than a step apart. */
static double balance_price(const struct run_scenario *s, const struct run_work *work)
{
    const bool again = has_apart_rows(s, work) && !keeps_balance(s, work);
    return balance_row_price(s) * work->steps + (again ? steps_price(s, work) : 0);
}

/* Returns the instructions of run_missed_burst(); 0 if it does not search this run. */
static double bursts_price(const struct run_scenario *s, const struct run_work *work)
{
    static const double built_in = 270, a_look = 1750, ways_max = 256;
    const double ways = fmin(work->steps, ways_max);
    if (s->system->autonomous || has_apart_rows(s, work) ||
        (!s->plan->adaptive && !run_force_may_pulse(s->system)))
        return 0;
    return typed_lines(s->system->model) > 0
               ? a_look * (double)run_burst_looks(s->system, (size_t)ways, (int64_t)work->evals)
               : built_in * ways;
}

/* Returns the instructions of run_force_unresolved(): 512 evaluations at other times than those of
 * steps, and some in each step that is examined for pulses. */
static double unresolved_price(const struct run_scenario *s, const struct run_work *work)
{
    const bool looks = !s->plan->adaptive && !run_force_is_slow(s->system, s->settings->dt) &&
                       !(s->method->flags & METHOD_EXACT);
    int probes;
    const int64_t probed =
        run_probed_steps(s->system, (int64_t)work->steps, (int64_t)work->evals, &probes);
    return looks
               ? (512 + (double)probed * (probes + 3)) * (135 + evaluation_price_called(s->system))
               : 0;
}

/* Returns the instructions of the second opinion. */
static double opinion_price(const struct run_scenario *s, const struct run_work *work)
{
    static const double begun = 50e3; /* stiffness, a look for variables at rest */
    const struct method *smooth = method_find("dop853"),
                        *second = work->second ? work->second : smooth;
    return (work->second ? begun : 0) + work->second_rows * exact_state_price(s->system) +
           work->second_evals * solver_evaluation_price(s->system, second, true) +
           work->rest_evals * solver_evaluation_price(s->system, smooth, true);
}

/* ---- lists ---- */

/* One item of a list. */
struct entry {
    char what[160];
    double price; /* instructions; NAN if it is listed without a price */
};

enum { ENTRIES_MAX = 16 };

/* A list of what a run computes or leaves out, with prices. */
struct list {
    struct entry entry[ENTRIES_MAX];
    int count;
    bool of_the_run;  /* "of the run" follows the first percentage */
    const char *note; /* text after the last entry */
};

/* Adds an item, unless its price is 0 or the list is full. */
static void list_add(struct list *list, double price, const char *what)
{
    if (price == 0 || list->count == ENTRIES_MAX)
        return;
    struct entry *entry = &list->entry[list->count++];
    snprintf(entry->what, sizeof entry->what, "%s", what);
    entry->price = price;
}

/* Appends words in lines of at most 79 columns, the first of which begins with a heading of ten
 * columns. A percent sign stays on the line of its number. */
static void put_wrapped(const char *heading, struct text words, struct buffer *text)
{
    enum { INDENT = 10, COLUMNS = 79 };
    size_t column = INDENT;
    buffer_format(text, "%-*s", INDENT, heading);
    for (size_t i = 0; i < words.len;) {
        size_t end = i;
        while (end < words.len &&
               (words.data[end] != ' ' || (end + 1 < words.len && words.data[end + 1] == '%')))
            end++;
        if (column > INDENT && column + 1 + end - i > COLUMNS) {
            buffer_format(text, "\n%-*s", INDENT, "");
            column = INDENT;
        } else if (column > INDENT) {
            buffer_char(text, ' ');
            column++;
        }
        buffer_put(text, (struct text){words.data + i, end - i});
        column += end - i;
        i = end + 1;
    }
    buffer_char(text, '\n');
}

/* Appends the entries of a list, with prices in percent of `whole`. */
static void list_put(const struct list *list, const char *heading, double whole,
                     struct buffer *text)
{
    struct buffer words = {0};
    for (int i = 0; i < list->count; i++) {
        const struct entry *entry = &list->entry[i];
        const double percent = 100 * entry->price / whole;
        buffer_format(&words, "%s%s", i > 0 ? "; " : "", entry->what);
        if (isnan(entry->price))
            continue;
        buffer_put(&words, percent < 0.1 ? TEXT(" below ") : TEXT(" "));
        buffer_short(&words, fmax(percent, 0.1), 2);
        buffer_put(&words, TEXT(" %"));
        if (list->of_the_run && i == 0)
            buffer_put(&words, TEXT(" of the run"));
    }
    buffer_put(&words, text_of(list->note));
    put_wrapped(heading, buffer_text(&words), text);
    buffer_free(&words);
}

/* Adds the prices [instruction] of what the run will compute to the list, each with its words:
 * steps, rows, set-up and summary, checks, and the energy balance if the scene has one. */
static void add_computed(const struct run_scenario *s, const struct run_work *work,
                         struct list *list)
{
    const bool adaptive = s->plan->adaptive;
    char steps[80];
    if (adaptive && work->tried > 0 && !work->whole)
        snprintf(steps, sizeof steps, "about %.0f steps (estimated from the first %lld)",
                 work->steps, (long long)work->tried);
    else
        snprintf(steps, sizeof steps, "%.15g step%s", work->steps, work->steps == 1 ? "" : "s");
    list_add(list, steps_price(s, work), steps);
    list_add(list, rows_price(s, work), "rows");
    list_add(list, (typed_lines(s->system->model) > 0 ? setting_up_typed : setting_up) + summary,
             "set-up and summary");
    list_add(list, strange_price(s, work), "steps across singularities");
    list_add(list, bursts_price(s, work), "search for short pulses");
    list_add(list, unresolved_price(s, work), "search for forces faster than steps");
    if (shows_balance(s, work)) {
        const char *purpose;
        if (keeps_balance(s, work))
            purpose = "energy balance, kept between rows";
        else
            purpose = s->plan->ledger ? "energy balance of the summary" : "dE/E0 of the summary";
        list_add(list, balance_price(s, work), purpose);
    } else if (s->system->energy && ledger_is_sampled(s->system, s->plan))
        list_add(list, balance_row_price(s) * LEDGER_SAMPLE, "dE/E0 of a sample of rows");
    if (adaptive && s->opinion > 0)
        list_add(list, opinion_price(s, work),
                 s->plan->exact_known ? "error by the closed form" : "second solution");
    if (s->events)
        list_add(list, NAN, "events, in each step");
}

/* Adds the names of the forces whose coefficient is 0, as one item. */
static void add_absent_forces(const struct system *system, struct list *list)
{
    struct buffer names = {0};
    for (size_t i = 0; i < system->model->terms->count; i++) {
        const struct row *row = catalog_row(system->model->terms, i);
        bool is_bound = typed_base(system->model) == NULL && typed_lines(system->model) > 0;
        for (int k = 0; k < system->terms; k++)
            is_bound |= &system->term[k].row->row == row;
        if (!is_bound)
            buffer_format(&names, "%s%s", names.len > 0 ? ", " : "", row->name);
    }
    if (names.len > 0) {
        buffer_put(&names, TEXT(": coefficient 0"));
        list_add(list, NAN, buffer_view(&names));
    }
    buffer_free(&names);
}

/* Returns true if `name` is a column of each row: time or a state variable. */
static bool is_state(const struct system *system, const char *name)
{
    bool found = text_is(TEXT("t"), name);
    for (int i = 0; i < system->n; i++)
        found |= text_is(text_of(system_variable(system, i).name), name);
    return found;
}

/* Groups of observables by what they need: nothing, the energy balance, or the closed form. */
enum column_kind { COLUMNS_PLAIN, COLUMNS_BALANCE, COLUMNS_EXACT };

static enum column_kind column_kind(const struct observable *o)
{
    if (o->needs & NEED_EXACT)
        return COLUMNS_EXACT;
    return o->needs & NEED_WORK ? COLUMNS_BALANCE : COLUMNS_PLAIN;
}

/* Adds an item with `price` to the list: the names of all observables of this kind that are defined
 * for the run, followed by `note`. Adds nothing if there are none. */
static void add_columns(const struct run_scenario *s, enum column_kind kind, double price,
                        const char *note, struct list *list)
{
    struct buffer names = {0};
    int count = 0;
    for (size_t i = 0; i < observable_catalog.count; i++) {
        const struct observable *o = observable_at(i);
        if (column_kind(o) == kind && !is_state(s->system, o->row.name) &&
            !(o->needs & NEED_POWER && s->system->conservative) &&
            observable_defined(o, s->system, s->plan->exact_known))
            buffer_format(&names, "%s%s", count++ > 0 ? ", " : "", o->row.name);
    }
    buffer_put(&names, text_of(note));
    if (count > 0)
        list_add(list, price, buffer_view(&names));
    buffer_free(&names);
}

/* Returns the largest price of following the solution of a run that fails (diagnose.c). */
static double follow_price(const struct run_scenario *s, const struct run_work *work)
{
    static const double evals = 12;
    return (double)run_follow_steps(work->evals) * evals *
           solver_evaluation_price(s->system, method_find("dop853"), true);
}

/* Returns how many rows the recording rule asks for. */
static double recorded_rows(const struct run_scenario *s, const struct run_work *work)
{
    const struct recording_rule *record = &s->settings->record;
    if (record->rule == RECORD_TIMES)
        return fabs(s->span) / record->interval;
    return record->rule == RECORD_EVERY ? work->steps / (double)record->every : work->steps;
}

/* Adds what the run leaves out, with the price if it were requested. */
static void add_left_out(const struct run_scenario *s, const struct run_work *work,
                         struct list *list)
{
    const double rows = fmin(recorded_rows(s, work), LIMIT_SAMPLES);
    const double column = 40 + evaluation_price_called(s->system);
    add_absent_forces(s->system, list);
    if (shows_balance(s, work))
        add_columns(s, COLUMNS_BALANCE, rows * column, "", list);
    else if (s->system->energy)
        add_columns(s, COLUMNS_BALANCE, balance_price(s, work),
                    has_apart_rows(s, work) ? " (by repeating the steps)" : "", list);
    add_columns(s, COLUMNS_EXACT, rows * exact_state_price(s->system), "", list);
    add_columns(s, COLUMNS_PLAIN, rows * column, ", each", list);
    if (!run_is_never_singular(s->system))
        list_add(list, follow_price(s, work),
                 "search for a singularity (if a step is suspicious) up to");
    if (s->plan->adaptive && s->opinion == 0)
        list_add(list, NAN, "second solution (set opinion off)");
    if (!s->plan->adaptive && s->system->order == 2 && s->system->oscillator.whole)
        list_add(list, NAN, "stable dt (only if the amplitude grows)");
}

/* Appends both lists, with prices in percent of the run. */
void run_prices_describe(const struct run_scenario *s, const struct run_work *work,
                         struct buffer *text)
{
    struct list computed = {.of_the_run = true, .note = ""},
                left_out = {.note = "; computed on demand"};
    if (isnan(work->steps))
        return;
    add_computed(s, work, &computed);
    add_left_out(s, work, &left_out);
    double whole = 0;
    for (int i = 0; i < computed.count; i++)
        whole += isnan(computed.entry[i].price) ? 0 : computed.entry[i].price;
    list_put(&computed, "computed", whole, text);
    if (left_out.count > 0)
        list_put(&left_out, "left out", whole, text);
}
