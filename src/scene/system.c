/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene bound to its coefficients, and what integrators ask of it. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "params.h"

/* Accelerations or, for a first-order scene, derivatives: what a term adds to. */
static int term_rows(const struct system *system)
{
    return system->order == 2 ? system->n / 2 : system->n;
}

/* Adds up the terms whose flags under `mask` are `wanted`, in table order. */
static void add_terms(const struct system *system, unsigned mask, unsigned wanted, double t, const double *y, double *a)
{
    memset(a, 0, (size_t)term_rows(system) * sizeof *a);
    for (int i = 0; i < system->terms; i++) {
        const struct bound_term *term = &system->term[i];
        if ((term->row->flags & mask) == wanted)
            term->row->add(term->c, t, y, a);
    }
}

void system_acceleration(const struct system *system, double t, const double *y, double *a)
{
    add_terms(system, 0, 0, t, y, a);
}

void system_force(const struct system *system, double t, const double *y, double *a)
{
    add_terms(system, TERM_VELOCITY, 0, t, y, a);
}

void system_drag(const struct system *system, double t, const double *y, double *a)
{
    add_terms(system, TERM_VELOCITY, TERM_VELOCITY, t, y, a);
}

void system_derivative(const struct system *system, double t, const double *y, double *dydt)
{
    int positions = system->n - term_rows(system);
    memcpy(dydt, y + system->n - positions, (size_t)positions * sizeof *y);
    add_terms(system, 0, 0, t, y, dydt + positions);
}

void system_jacobian(const struct system *system, double t, const double *y, double *jac)
{
    int n = system->n, positions = n - term_rows(system);
    memset(jac, 0, (size_t)n * (size_t)n * sizeof *jac);
    for (int i = 0; i < positions; i++)
        jac[i * n + positions + i] = 1;
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->jacobian)
            system->term[i].row->jacobian(system->term[i].c, t, y, jac + positions * n);
}

double system_kinetic(const struct system *system, const double *y)
{
    double sum = 0;
    for (int i = term_rows(system); i < system->n; i++)
        sum += 0.5 * system->mass * y[i] * y[i];
    return sum;
}

double system_potential(const struct system *system, const double *y)
{
    double sum = 0;
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->potential)
            sum += system->term[i].row->potential(system->term[i].c, y);
    return sum;
}

static double power_without(const struct system *system, unsigned flags, double t, const double *y)
{
    double sum = 0;
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->power && !(system->term[i].row->flags & flags))
            sum += system->term[i].row->power(system->term[i].c, t, y);
    return sum;
}

double system_power(const struct system *system, double t, const double *y)
{
    return power_without(system, 0, t, y);
}

double system_dissipation(const struct system *system, double t, const double *y)
{
    return power_without(system, TERM_TIME, t, y);
}

/*
 * v' = -gamma v - c |v| v has the solution v E / (1 + c |v| phi), E = exp(-gamma h), phi = (1 - E) / gamma. Where E
 * would grow (gamma h < 0) numerator and denominator are divided by it. Backwards in time quadratic drag has a pole.
 */
double oscillator_drag_flow(const struct oscillator *oscillator, double v, double h)
{
    double gamma = oscillator->damping, c = oscillator->quadratic, x = gamma * h;
    double decay = exp(-fabs(x));
    double phi = x != 0 ? -expm1(-fabs(x)) / fabs(gamma) : fabs(h);
    double below = (x < 0 ? decay : 1) + c * fabs(v) * copysign(phi, h);
    if (below <= 0)
        return copysign(HUGE_VAL, v);
    return (x < 0 ? v : v * decay) / below;
}

struct variable system_variable(const struct system *system, int i)
{
    int rows = term_rows(system), place = i % rows;
    struct variable variable = {.quantity = system->order != 2 ? QUANTITY_NUMBER
                                            : i < rows         ? QUANTITY_LENGTH
                                                               : QUANTITY_VELOCITY};
    char letter = i < rows ? 'y' : 'v';
    if (place == 0)
        snprintf(variable.name, sizeof variable.name, "%c", letter);
    else
        snprintf(variable.name, sizeof variable.name, "%c%d", letter, place + 1);
    return variable;
}

/* ---- binding ---- */

static double clamp_scale(double scale)
{
    return scale > DBL_MAX ? DBL_MAX : scale > 0 ? scale : 1; /* nothing moves: any scale will do */
}

/*
 * Natural sizes, for error norms. `rate` is 1/time: sqrt|k/m| where there is a spring, else what the other forces set.
 * The answer to a drive is taken no closer to resonance than a tenth of the spring's own frequency squared.
 */
static void set_scale(struct system *system)
{
    const struct oscillator *o = &system->oscillator;
    double y0 = fabs(system->start[0]), v0 = fabs(system->start[1]), g = fabs(o->gravity), f = fabs(o->drive);
    double rate = sqrt(fabs(o->stiffness));
    if (rate == 0)
        rate = fmax(fmax(fabs(o->damping), sqrt(fabs(o->quadratic)) * fmax(sqrt(fabs(o->quadratic)) * v0, sqrt(g))),
                    f > 0 ? o->omega : 0);
    if (rate == 0)
        rate = 1;
    double length = fmax(fmax(y0, v0 / rate), g / rate / rate), speed = length * rate;
    if (f > 0) {
        double detuning = (rate - o->omega) * (rate + o->omega);
        double answer = f / fmax(hypot(detuning, o->damping * o->omega), 0.1 * rate * rate);
        length = fmax(length, answer);
        speed = fmax(speed, answer * fmax(rate, o->omega));
    }
    system->scale[0] = clamp_scale(length);
    system->scale[1] = clamp_scale(speed);
}

/* Coefficients, and the forces at the start and at full swing, must be finite. */
static bool check_term(const struct system *system, const struct bound_term *term, struct error *error)
{
    bool fine = true;
    for (int i = 0; i < TERM_COEFFICIENTS; i++)
        fine = fine && isfinite(term->c[i]);
    if (!fine)
        return error_set(error, ERROR_COMMAND, "a coefficient of the %s term overflows", term->row->row.name);
    const double *states[] = {system->start, system->scale};
    for (size_t i = 0; i < COUNT_OF(states); i++) {
        double a[LIMIT_VARIABLES] = {0};
        term->row->add(term->c, system->t0, states[i], a);
        if (!isfinite(a[0])) {
            char position[REAL_TEXT_SIZE], speed[REAL_TEXT_SIZE];
            real_format(states[i][0], position);
            real_format(states[i][1], speed);
            return error_set(error, ERROR_COMMAND, "the %s force overflows at y = %s m, v = %s m/s",
                             term->row->row.name, position, speed);
        }
    }
    return true;
}

bool scene_bind(const struct scene *scene, struct system *system, struct error *error)
{
    const double *param = scene->value;
    if (!params_coherent(param, error))
        return false;
    *system = (struct system){.n = 2, .order = 2, .mass = param[P_m], .t0 = param[P_t0], .oscillator.whole = true};
    system->start[0] = param[P_y0];
    system->start[1] = param[P_v0];
    unsigned all = ~0u, any = 0;
    for (size_t i = 0; i < term_catalog.count; i++) {
        struct bound_term *term = &system->term[system->terms];
        *term = (struct bound_term){.row = (const struct term_row *)catalog_row(&term_catalog, i)};
        if (!term->row->bind(param, term->c, &system->oscillator))
            continue;
        system->terms++;
        all &= term->row->flags;
        any |= term->row->flags;
    }
    system->linear = all & TERM_LINEAR;
    system->conservative = all & TERM_CONSERVATIVE;
    system->velocity = any & TERM_VELOCITY;
    system->autonomous = !(any & TERM_TIME);
    set_scale(system);
    for (int i = 0; i < system->terms; i++)
        if (!check_term(system, &system->term[i], error))
            return false;
    return true;
}
