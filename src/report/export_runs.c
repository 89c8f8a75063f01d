/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Exports runs as a table: chooses runs, columns and rows, and evaluates the columns. export_runs()
 * is the entry; the functions before it are its stages. */
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include <hooke/scene/typed.h>

#include <math.h>

/* Reads every=N (rows) or every=TIME into a thinning; without it all rows are kept. Returns false
 * with an error for another quantity or a fraction of a row. */
bool thinning_begin(struct thinning *thinning, const struct argument_value *every,
                    struct error *error)
{
    *thinning = (struct thinning){.step = 1};
    if (every->count == 0)
        return true;
    const struct item *item = every->item;
    *thinning = (struct thinning){.step = item->value.value, .by_time = item->unit != NULL};
    if (item->unit && item->unit->quantity != QUANTITY_TIME)
        return error_at(error, item->text,
                        "every= needs a number of rows or a time, not '%.*s' (%s)",
                        (int)item->text.len, item->text.data, quantity_name(item->unit->quantity));
    if (item->unit || (item->value.value >= 1 && item->value.value == floor(item->value.value)))
        return true;
    error_at(error, item->text, "every= needs a whole number of rows, or a time with its unit");
    return error_hint(error, "for example every=10 or every=100ms");
}

/* Returns true if row i, `elapsed` [s] after the first, is kept. Rows must be asked for in
 * ascending order. */
bool thinning_keeps(struct thinning *thinning, size_t i, double elapsed)
{
    const double index = (thinning->by_time ? elapsed : (double)i) / thinning->step;
    const bool keeps = index >= (double)thinning->next - 1e-9 * (1 + fabs(index));
    if (keeps)
        thinning->next = (int64_t)floor(index + 1e-6) + 1;
    return keeps;
}

/* Sets mark[i] for the rows of a run that are written. Returns their number. */
static size_t select_rows(const struct run *run, struct thinning thinning, bool *mark)
{
    const size_t n = trace_count(run->trace);
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        mark[i] = thinning_keeps(&thinning, i,
                                 fabs(trace_time(run->trace, i) - trace_time(run->trace, 0)));
        count += mark[i];
    }
    return count;
}

/* Lists the indices of the runs that the argument run= names (all of them for run=all), in
 * ascending order, or of the current run if it was not given; index has room for all runs. Returns
 * their number. */
static int list_runs(const struct session *session, const struct argument_value *runs, int *index)
{
    int count = 0;
    for (int r = 0; r < session->runs.count; r++) {
        bool wanted = runs->count == 0 && r == session->runs.current;
        for (int i = 0; i < runs->count; i++)
            wanted |= runs->item[i].index < 0 || runs->item[i].index == r;
        if (wanted)
            index[count++] = r;
    }
    return count;
}

/* Adds a column to the list unless it is there already. */
static void add_column(struct chosen_column one, struct chosen_column *list, int *count)
{
    for (int i = 0; i < *count; i++)
        if (list[i].observable == one.observable && list[i].variable == one.variable)
            return;
    list[(*count)++] = one;
}

/* Lists in list [*count] the columns to write, each once: t, then those that the argument names or,
 * without it, the state, the energy (in scenes of second order) and the observed expressions.
 * Returns false with an error if a name is unknown. */
static bool list_columns(const struct system *system, const struct argument_value *column,
                         struct chosen_column *list, int *count, struct error *error)
{
    const struct model *model = system->model;
    struct chosen_column one;
    if (!chosen_find(model, TEXT("t"), &one, error))
        return false;
    add_column(one, list, count);
    for (int i = 0; i < column->count; i++) {
        if (!chosen_find(model, column->item[i].text, &one, error))
            return false;
        add_column(one, list, count);
    }
    for (int v = 0; v < model->n && !column->count; v++)
        add_column((struct chosen_column){NULL, v}, list, count);
    if (!column->count && model->order == 2)
        add_column((struct chosen_column){observable_energy(system), -1}, list, count);
    for (int v = 0; v < model_observed(model) && !column->count; v++)
        add_column((struct chosen_column){NULL, model->n + v}, list, count);
    return true;
}

/* Returns false with an error if the runs do not all have the same variables. */
static bool same_model(const struct session *session, const int *index, int count,
                       struct error *error)
{
    const struct run *first = session->runs.slot[index[0]]->run;
    for (int i = 1; i < count; i++) {
        const struct run *run = session->runs.slot[index[i]]->run;
        if (models_alike(run->system.model, first->system.model))
            continue;
        error_set(error, ERROR_COMMAND,
                  "run %d (%s) and run %d (%s) have different variables and cannot share a file",
                  first->number, first->scene.preset->row.name, run->number,
                  run->scene.preset->row.name);
        return error_hint(error, "export FILE run %d", first->number);
    }
    return true;
}

/* Sets export->table to a table of the given runs (the current one if none is given), in
 * export->arena: a row for each recorded time that `every` selects, with columns t and those of
 * `column`; several runs follow each other, with the number of the run as first column. Returns
 * false with an error if there is no run, if runs have different variables, if an argument is
 * invalid, or if out of memory. */
bool export_runs(const struct session *session, const struct argument_value *runs,
                 const struct argument_value *column, const struct argument_value *every,
                 struct export *export, struct error *error)
{
    struct arena *arena = export->arena;
    int index[LIMIT_RUNS];
    const int count = list_runs(session, runs, index);
    if (count == 0) {
        error_set(error, ERROR_COMMAND, "there is no run to export");
        return error_hint(error, "type: run; or: export FILE data");
    }
    struct keys keys;
    struct thinning thinning;
    const struct system *system = &session->runs.slot[index[0]]->run->system;
    const struct model *model = system->model;
    if (!same_model(session, index, count, error) || !thinning_begin(&thinning, every, error) ||
        !keys_begin(&keys, export, error))
        return false;
    struct chosen_column *list =
        arena_array(arena, (size_t)column->count + (size_t)(model->n + model_observed(model)) + 2,
                    sizeof *list);
    size_t rows = 0, largest = 0;
    bool **mark = arena_array(arena, (size_t)count, sizeof *mark);
    if (!list || !mark)
        return error_memory(error);
    for (int r = 0; r < count; r++) {
        const struct run *run = session->runs.slot[index[r]]->run;
        const size_t n = trace_count(run->trace);
        if (!(mark[r] = arena_array(arena, n, sizeof **mark)))
            return error_memory(error);
        rows += select_rows(run, thinning, mark[r]);
        largest = n > largest ? n : largest;
    }
    /* A run without potential energy determines which energy all runs show. */
    for (int r = 1; r < count && system->energy; r++)
        system = &session->runs.slot[index[r]]->run->system;
    int columns = 0;
    if (!list_columns(system, column, list, &columns, error))
        return false;
    /* Several runs get a leading column with the number of the run. */
    const int lead = count > 1;
    struct table_column *exported = arena_array(arena, (size_t)(columns + lead), sizeof *exported);
    const bool whole = count == 1 && rows == largest; /* all rows of one run */
    double *work = arena_array(arena, whole ? 0 : largest, sizeof *work);
    if (!exported || !work)
        return error_memory(error);
    /* The columns of all runs follow each other in one array; only marked rows are copied. */
    for (int c = 0; c < columns + lead; c++) {
        double *value = arena_array(arena, rows, sizeof *value), *all = whole ? value : work;
        size_t n = 0;
        if (!value)
            return error_memory(error);
        for (int r = 0; r < count; r++) {
            const struct run *run = session->runs.slot[index[r]]->run;
            if (c >= lead && !chosen_values(run, &list[c - lead], all, error))
                return false;
            for (size_t i = 0; i < trace_count(run->trace); i++)
                if (mark[r][i])
                    value[n++] = c < lead ? run->number : all[i];
        }
        exported[c] = (struct table_column){.name = "run", .unit = "", .value = value};
        if (c < lead)
            continue;
        const struct variable variable = chosen_variable(system, &list[c - lead]);
        if (!(exported[c].name = arena_text(arena, text_of(variable.name))))
            return error_memory(error);
        exported[c].unit = chosen_unit(system, &list[c - lead]);
    }
    keys_add_runs(&keys, session, index, count);
    export->table = (struct table){.column = exported, .columns = columns + lead, .rows = rows};
    return keys_finish(&keys, export, error);
}
