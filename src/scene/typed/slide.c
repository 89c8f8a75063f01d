/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sliding along switches: the motion between the fields on both sides of a switch, each with the
 * fraction that keeps the argument at the switch (Filippov 1988, Differential Equations with
 * Discontinuous Righthand Sides, 4; for several switches the equivalent control of Utkin 1992,
 * Sliding Modes in Control and Optimization, 2). system_slide() makes a system that slides,
 * sliding_return() puts states back onto the switches. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/typed/typed.h"

/* A row of the matrix depends on the rows before if less than this part of its square is left. */
#define ROW_INDEPENDENCE_MIN 1e-12
#define DIFFERENCE_STEP 1e-5 /* Step of finite differences as a part of a variable's size. */
/* Largest number of corrections of a state if rates of arguments have to be 0, too. */
#define SECOND_CORRECTIONS_MAX 3
/* Step of differences of arguments, most of which are linear, as a part of all variables' sizes. */
#define ARGUMENT_STEP 1e-2
/* The same for differences of fields; both formulas are of fourth order. */
#define FAR_FIELD 1e-4

/* Returns the sliding whose address is the first value of a bound term. */
static const struct sliding *sliding_of(const double *c)
{
    const struct sliding *sliding;
    memcpy(&sliding, c, sizeof sliding);
    return sliding;
}

/* Computes the rate of each argument along the field f. */
static void argument_rates(const struct sliding *s, double t, const double *y, const double *f,
                           double *rate)
{
    const int n = s->side[0].n;
    double a[LIMIT_VARIABLES], b[LIMIT_VARIABLES], earlier[LIMIT_SWITCHES], later[LIMIT_SWITCHES];
    for (int i = 0; i < n; i++) {
        a[i] = y[i] - s->time_shift * f[i];
        b[i] = y[i] + s->time_shift * f[i];
    }
    switch_arguments(&s->side[0], t - s->time_shift, a, earlier);
    switch_arguments(&s->side[0], t + s->time_shift, b, later);
    for (int k = 0; k < s->count; k++)
        rate[k] = (later[s->switch_index[k]] - earlier[s->switch_index[k]]) / (2 * s->time_shift);
}

/* Returns the time [s] in which a motion by `direction` moves as far as variables are large, or
 * `otherwise` if there is no motion. */
static double motion_time(const struct system *system, const double *y, const double *direction,
                          double otherwise)
{
    double sum = 0;
    for (int i = 0; i < system->n; i++) {
        const double change = direction[i] / fmax(system->scale[i], fabs(y[i]));
        sum += change * change;
    }
    return sum > 0 ? sqrt(system->n / sum) : otherwise;
}

/* First and second derivatives of the arguments along (time, direction): differences of the fourth
 * order. */
static void argument_differences(const struct sliding *s, double t, double time, const double *y,
                                 const double *direction, double *first, double *second)
{
    const struct system *side = &s->side[0];
    const double h = ARGUMENT_STEP * motion_time(side, y, direction, s->time_shift / ARGUMENT_STEP);
    double shifted[LIMIT_VARIABLES], a[5][LIMIT_SWITCHES];
    for (int k = 0; k < 5; k++) {
        for (int i = 0; i < side->n; i++)
            shifted[i] = y[i] + (k - 2) * h * direction[i];
        switch_arguments(side, t + (k - 2) * h * time, shifted, a[k]);
    }
    for (int i = 0; i < s->count; i++) {
        const int k = s->switch_index[i];
        first[i] = (8 * (a[3][k] - a[1][k]) - (a[4][k] - a[0][k])) / (12 * h);
        second[i] = (16 * (a[3][k] - 2 * a[2][k] + a[1][k]) - (a[4][k] - 2 * a[2][k] + a[0][k])) /
                    (12 * h * h);
    }
}

/* Computes the rate of each argument along the motion on one side, and the rate of that rate. */
static void argument_changes(const struct sliding *s, const struct system *side, double t,
                             const double *y, double *rate, double *second)
{
    static const double weight[] = {1. / 12, -8. / 12, 0, 8. / 12, -1. / 12};
    double f[LIMIT_VARIABLES], shifted[LIMIT_VARIABLES], shifted_rate[LIMIT_VARIABLES],
        bend[LIMIT_VARIABLES] = {0};
    double more[LIMIT_SLIDING], ignored[LIMIT_SLIDING];
    system_derivative(side, t, y, f);
    const double h = FAR_FIELD * motion_time(side, y, f, s->time_shift / FAR_FIELD);
    for (int k = -2; k <= 2; k++) {
        for (int i = 0; i < side->n; i++)
            shifted[i] = y[i] + k * h * f[i];
        system_derivative(side, t + k * h, shifted, shifted_rate);
        for (int i = 0; i < side->n; i++)
            bend[i] += weight[k + 2] / h * shifted_rate[i];
    }
    argument_differences(s, t, 1, y, f, rate, second);
    argument_differences(s, t, 0, y, bend, more, ignored);
    for (int i = 0; i < s->count; i++)
        second[i] += more[i];
}

/*
 * The fields around a point. Where no jump changes the rate of an argument, as those of forces do
 * not change that of a position, `rate` and `jump_rate` are of its second derivative (relative
 * degree 2; Fridman, Levant 2002, Higher Order Sliding Modes, in Sliding Mode Control in
 * Engineering, 3): it stays where both are 0.
 */
struct sliding_fields {
    double field[LIMIT_VARIABLES];               /* field below all switches */
    double jump[LIMIT_SLIDING][LIMIT_VARIABLES]; /* change of the field above each switch */
    double rate[LIMIT_SLIDING];                  /* rate of each argument along `field`, */
    double jump_rate[LIMIT_SLIDING]
                    [LIMIT_SLIDING]; /* and what each jump adds to that of argument [i] */
    bool second[LIMIT_SLIDING];
    double first[LIMIT_SLIDING]; /* rate of those whose second derivative it is */
};

/* Fills the members of *fields for second derivatives. */
static void second_fields_find(const struct sliding *s, double t, const double *y,
                               struct sliding_fields *fields)
{
    double rate[LIMIT_SLIDING], first[LIMIT_SLIDING], lower[LIMIT_SLIDING], upper[LIMIT_SLIDING];
    argument_changes(s, &s->side[0], t, y, first, lower);
    for (int j = 0; j < s->count; j++) {
        argument_changes(s, &s->side[1 + j], t, y, rate, upper);
        for (int i = 0; i < s->count; i++)
            if (fields->second[i])
                fields->jump_rate[i][j] = upper[i] - lower[i];
    }
    for (int i = 0; i < s->count; i++)
        if (fields->second[i]) {
            fields->rate[i] = lower[i];
            fields->first[i] = first[i];
        }
}

/* Fills *fields at the state y. An argument whose rate no jump changes is treated by its second
 * derivative. */
static void fields_find(const struct sliding *s, double t, const double *y,
                        struct sliding_fields *fields)
{
    const int n = s->side[0].n;
    bool any = false;
    system_derivative(&s->side[0], t, y, fields->field);
    argument_rates(s, t, y, fields->field, fields->rate);
    for (int i = 0; i < s->count; i++)
        fields->second[i] = true;
    for (int j = 0; j < s->count; j++) {
        double rate[LIMIT_SLIDING];
        system_derivative(&s->side[1 + j], t, y, fields->jump[j]);
        argument_rates(s, t, y, fields->jump[j], rate);
        for (int i = 0; i < n; i++)
            fields->jump[j][i] -= fields->field[i];
        for (int i = 0; i < s->count; i++) {
            fields->jump_rate[i][j] = rate[i] - fields->rate[i];
            fields->second[i] = fields->second[i] && fields->jump_rate[i][j] == 0;
        }
    }
    for (int i = 0; i < s->count; i++)
        any = any || fields->second[i];
    if (any)
        second_fields_find(s, t, y, fields);
}

/* Replaces x [count] by the x nearest to it that solves matrix x = right; rows that depend on those
 * before are left out (Gram-Schmidt). */
static void sliding_solve(int count, double (*matrix)[LIMIT_SLIDING], const double *right,
                          double *x)
{
    double q[LIMIT_SLIDING][LIMIT_SLIDING];
    for (int i = 0; i < count; i++) {
        double row_square = 0, left_square = 0, residual = right[i];
        for (int k = 0; k < count; k++)
            row_square += matrix[i][k] * matrix[i][k];
        memcpy(q[i], matrix[i], sizeof q[i]);
        for (int j = 0; j < i; j++) {
            double projection = 0;
            for (int k = 0; k < count; k++)
                projection += q[i][k] * q[j][k];
            for (int k = 0; k < count; k++)
                q[i][k] -= projection * q[j][k];
        }
        for (int k = 0; k < count; k++) {
            left_square += q[i][k] * q[i][k];
            residual -= matrix[i][k] * x[k];
        }
        const bool is_independent = left_square > ROW_INDEPENDENCE_MIN * row_square;
        for (int k = 0; k < count; k++) {
            x[k] += is_independent ? residual / left_square * q[i][k] : 0;
            q[i][k] = is_independent ? q[i][k] / sqrt(left_square) : 0;
        }
    }
}

/* Sets fraction [count] to the fraction of the field above each switch, with which all arguments
 * stay where they are. */
static void find_fractions(const struct sliding *s, double t, const double *y,
                           struct sliding_fields *fields, double *fraction)
{
    double right[LIMIT_SLIDING] = {0};
    fields_find(s, t, y, fields);
    for (int i = 0; i < s->count; i++) {
        fraction[i] = 0.5;
        right[i] = -fields->rate[i];
    }
    sliding_solve(s->count, fields->jump_rate, right, fraction);
}

/* Adds the accelerations or derivatives of the sliding motion to a (struct term_row). */
static void sliding_add_rates(const double *c, double t, const double *y, double *a)
{
    const struct sliding *s = sliding_of(c);
    const struct system *system = &s->side[0];
    const int rows = system->order == 2 ? system->n / 2 : system->n, first = system->n - rows;
    struct sliding_fields fields;
    double fraction[LIMIT_SLIDING];
    find_fractions(s, t, y, &fields, fraction);
    for (int i = 0; i < rows; i++) {
        double sum = fields.field[first + i];
        for (int j = 0; j < s->count; j++)
            sum += fraction[j] * fields.jump[j][first + i];
        a[i] += sum;
    }
}

/* Adds the Jacobian of the sliding motion, by central differences (struct term_row). */
static void jacobian(const double *c, double t, const double *y, double *jac)
{
    const struct system *system = &sliding_of(c)->side[0];
    const int n = system->n, rows = system->order == 2 ? n / 2 : n;
    double shifted[LIMIT_VARIABLES];
    memcpy(shifted, y, (size_t)n * sizeof *y);
    for (int j = 0; j < n; j++) {
        const double step = DIFFERENCE_STEP * fmax(system->scale[j], fabs(y[j]));
        double lower[LIMIT_VARIABLES] = {0}, upper[LIMIT_VARIABLES] = {0};
        shifted[j] = y[j] - step;
        sliding_add_rates(c, t, shifted, lower);
        shifted[j] = y[j] + step;
        sliding_add_rates(c, t, shifted, upper);
        shifted[j] = y[j];
        for (int i = 0; i < rows; i++)
            jac[i * n + j] += (upper[i] - lower[i]) / (2 * step);
    }
}

static const struct term_row sliding_row = {
    .row = {"sliding", "", "along switches", "Filippov 1988", NULL},
    .add = sliding_add_rates,
    .jacobian = jacobian};

/* Freezes the system on both sides of each switch along which it slides, and gives it the sliding
 * row. */
bool system_slide(const struct system *system, const double *branch, const bool *slides,
                  double time_offset, struct sliding *sliding, struct system *frozen)
{
    double lower_branch[LIMIT_SWITCHES];
    memcpy(lower_branch, branch, (size_t)system->switches * sizeof *lower_branch);
    sliding->count = 0;
    sliding->time_shift = time_offset;
    system_freeze(system, lower_branch, frozen);
    for (int i = 0; i < system->switches; i++) {
        if (!slides[i])
            continue;
        if (!sliding->side)
            sliding->side = malloc((LIMIT_SLIDING + 1) * sizeof *sliding->side);
        if (!sliding->side || sliding->count == LIMIT_SLIDING)
            return false;
        const int k = sliding->count++;
        sliding->switch_index[k] = i;
        sliding->level[k] = switch_kind_of(system, i) == SWITCH_WHOLE ? lower_branch[i] + 1 : 0;
        lower_branch[i]++;
        system_freeze(system, lower_branch, &sliding->side[1 + k]);
        lower_branch[i]--;
    }
    if (sliding->count == 0)
        return true;
    sliding->side[0] = *frozen;
    frozen->sliding = sliding;
    if (sliding_rests(sliding)) {
        sliding_freeze_rest(frozen);
        return true;
    }
    frozen->terms = 0;
    frozen->typed.row = &sliding_row;
    memcpy(frozen->typed.c, &sliding, sizeof sliding);
    return true;
}

void sliding_free(struct sliding *sliding)
{
    free(sliding->side);
}

/* Moves y by amount[j] times direction[j], for each switch. */
static void state_move(const struct sliding *s, const double *amount,
                       double (*direction)[LIMIT_VARIABLES], double *y)
{
    for (int j = 0; j < s->count; j++)
        for (int i = 0; i < s->side[0].n && isfinite(amount[j]); i++)
            y[i] += amount[j] * direction[j][i];
}

/* Sets direction[j] to the derivative of the field along jump j, which is the Jacobian times the
 * jump, by central differences over s->near: [1/s] times the unit of the jump. */
static void follow_jumps(const struct sliding *s, const struct sliding_fields *fields, double t,
                         const double *y, double (*direction)[LIMIT_VARIABLES])
{
    const int n = s->side[0].n;
    const double h = s->time_shift;
    for (int j = 0; j < s->count; j++) {
        double a[LIMIT_VARIABLES], b[LIMIT_VARIABLES], lower[LIMIT_VARIABLES],
            upper[LIMIT_VARIABLES];
        for (int i = 0; i < n; i++) {
            a[i] = y[i] - h * fields->jump[j][i];
            b[i] = y[i] + h * fields->jump[j][i];
        }
        system_derivative(&s->side[0], t, a, lower);
        system_derivative(&s->side[0], t, b, upper);
        for (int i = 0; i < n; i++)
            direction[j][i] = (upper[i] - lower[i]) / (2 * h);
    }
}

/* Corrects the arguments whose second derivative only the jumps change, along directions that
 * follow_jumps() finds. Returns false if none of them is off. */
static bool second_correct(const struct sliding *s, const struct sliding_fields *fields, double t,
                           const double *miss, double *y)
{
    double right[LIMIT_SLIDING] = {0}, correction[LIMIT_SLIDING] = {0},
           rows[LIMIT_SLIDING][LIMIT_SLIDING] = {{0}};
    double direction[LIMIT_SLIDING][LIMIT_VARIABLES];
    bool has_error = false;
    for (int i = 0; i < s->count; i++) {
        if (!fields->second[i])
            continue;
        right[i] = miss[i];
        memcpy(rows[i], fields->jump_rate[i], sizeof rows[i]);
        has_error = has_error || miss[i] != 0;
    }
    if (!has_error)
        return false;
    follow_jumps(s, fields, t, y, direction);
    sliding_solve(s->count, rows, right, correction);
    state_move(s, correction, direction, y);
    return true;
}

/* Sets miss [s->count] to the distance of each switch argument from its level at time t and state
 * y, and *fields to the rates there. Returns true if one is not exactly 0, or if the rate of an
 * argument is not 0 where it has to be, so that the state must be corrected. */
static bool is_off_switches(const struct sliding *s, double t, const double *y,
                            struct sliding_fields *fields, double *miss)
{
    double argument[LIMIT_SWITCHES];
    bool has_error = false;
    fields_find(s, t, y, fields);
    switch_arguments(&s->side[0], t, y, argument);
    for (int k = 0; k < s->count; k++) {
        miss[k] = s->level[k] - argument[s->switch_index[k]];
        has_error = has_error || miss[k] != 0 || (fields->second[k] && fields->first[k] != 0);
    }
    return has_error;
}

/* Corrects the state by a step of Newton's iteration. */
static void newton_correct(const struct sliding *s, struct sliding_fields *fields, double t,
                           double *miss, double *y)
{
    double correction[LIMIT_SLIDING] = {0};
    if (second_correct(s, fields, t, miss, y))
        is_off_switches(s, t, y, fields, miss);
    for (int k = 0; k < s->count; k++)
        miss[k] = fields->second[k] ? -fields->first[k] : miss[k];
    sliding_solve(s->count, fields->jump_rate, miss, correction);
    state_move(s, correction, fields->jump, y);
}

/* Corrects y until all arguments are at their switches. Returns true if it moved. */
bool sliding_return(const struct sliding *s, double t, double *y)
{
    struct sliding_fields fields;
    double miss[LIMIT_SLIDING];
    bool moved = false, twice = true;
    if (sliding_rests(s)) {
        moved = y[1] != 0;
        y[1] = 0;
        return moved;
    }
    for (int k = 0; k < SECOND_CORRECTIONS_MAX && twice && is_off_switches(s, t, y, &fields, miss);
         k++) {
        newton_correct(s, &fields, t, miss, y);
        moved = true;
        twice = false;
        for (int i = 0; i < s->count; i++)
            twice = twice || fields.second[i];
    }
    return moved;
}

/* Returns true if the argument of switch i has too large a rate to stay at the switch. */
bool sliding_passes(const struct sliding *s, int i, double t, const double *y, double tolerance)
{
    struct sliding_fields fields;
    if (sliding_rests(s))
        return false;
    fields_find(s, t, y, &fields);
    for (int k = 0; k < s->count; k++) {
        double max = 0;
        for (int j = 0; j < s->count; j++)
            max = fmax(max, fabs(fields.jump_rate[k][j]));
        if (s->switch_index[k] == i && fields.second[k])
            return !(fabs(fields.first[k]) <= max * tolerance);
    }
    return false;
}

/* Computes guards of the switches along which the motion slides: the product of both sides'
 * shares. */
void sliding_guards(const struct sliding *s, double t, const double *y, double *guard)
{
    struct sliding_fields fields;
    double fraction[LIMIT_SLIDING];
    find_fractions(s, t, y, &fields, fraction);
    for (int k = 0; k < s->count; k++)
        guard[s->switch_index[k]] = fraction[k] * (1 - fraction[k]);
}

/* Returns the branch on the side whose fraction is larger. */
double sliding_leaves(const struct sliding *s, int i, double t, const double *y)
{
    struct sliding_fields fields;
    double fraction[LIMIT_SLIDING];
    find_fractions(s, t, y, &fields, fraction);
    for (int k = 0; k < s->count; k++)
        if (s->switch_index[k] == i)
            return s->level[k] - (switch_kind_of(&s->side[0], i) == SWITCH_WHOLE) +
                   (fraction[k] > 0.5);
    return NAN;
}
