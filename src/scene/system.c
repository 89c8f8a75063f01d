/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Systems: a scene is bound to its parameters by scene_bind(), and then gives derivatives,
 * Jacobians, energies and powers to integrators. */
#include <hooke/base/unit.h>
#include <hooke/base/elementary.h>

#include <math.h>
#include <string.h>

#include "scene/model/params.h"
#include "scene/typed/typed.h"

/* Returns the number of accelerations or, for a first-order scene, of derivatives that terms add
 * to. */
static int term_rows(const struct system *system)
{
    return system->order == 2 ? system->n / 2 : system->n;
}

/* Sets a to the sum of the terms whose flags under `mask` are `wanted`, in the order of their
 * table. */
static void add_terms(const struct system *system, unsigned mask, unsigned wanted, double t,
                      const double *y, double *a)
{
    /* -0 is the number to which adding x gives x, to the bit. */
    for (int i = 0; i < term_rows(system); i++)
        a[i] = -0.0;
    if (mask == 0 && system->typed.row && system->typed.row->add) {
        system->typed.row->add(system->typed.c, t, y, a);
        return;
    }
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

/* Sums the Jacobians of all terms; rows of positions have a 1 at their velocity. */
void system_jacobian(const struct system *system, double t, const double *y, double *jac)
{
    int n = system->n, positions = n - term_rows(system);
    memset(jac, 0, (size_t)n * (size_t)n * sizeof *jac);
    for (int i = 0; i < positions; i++)
        jac[i * n + positions + i] = 1;
    if (system->typed.row && system->typed.row->jacobian) {
        system->typed.row->jacobian(system->typed.c, t, y, jac + positions * n);
        return;
    }
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->jacobian)
            system->term[i].row->jacobian(system->term[i].c, t, y, jac + positions * n);
}

double *system_new_jacobian(const struct system *system, double t, const double *y)
{
    double *jac = malloc((size_t)system->n * (size_t)system->n * sizeof *jac);
    if (jac)
        system_jacobian(system, t, y, jac);
    return jac;
}

/* Sums m v^2 / 2, with the ratios of masses of typed scenes. */
double system_kinetic(const struct system *system, const double *y)
{
    double sum = 0;
    const int rows = term_rows(system);
    for (int i = rows; i < system->n; i++) {
        const double part = 0.5 * system->mass * y[i] * y[i];
        sum += system->order == 2 && system->ratio[i - rows] > 0 ? system->ratio[i - rows] * part
                                                                 : part;
    }
    return sum;
}

/* Sums the potentials of all terms that have one. */
double system_potential(const struct system *system, const double *y)
{
    double sum = 0;
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->potential)
            sum += system->term[i].row->potential(system->term[i].c, y);
    return sum;
}

/* Returns true if each term has a potential or depends on velocity. */
bool system_has_potential(const struct system *system)
{
    for (int i = 0; i < system->terms; i++)
        if (!system->term[i].row->potential && !(system->term[i].row->flags & TERM_VELOCITY))
            return false;
    return true;
}

/* Returns the power of one term [W], 0 if it has a potential. */
static double term_power(const struct system *system, const struct bound_term *term, double t,
                         const double *y)
{
    const int rows = term_rows(system);
    double a[LIMIT_VARIABLES] = {0}, sum = 0;
    if (term->row->power)
        return term->row->power(term->c, t, y);
    if (system->order != 2 || !term_has_power(term->row))
        return 0;
    term->row->add(term->c, t, y, a);
    for (int i = 0; i < rows; i++)
        sum += system->mass * a[i] * y[rows + i];
    return sum;
}

/* Returns the power of the terms whose flags under `mask` are `wanted`. */
static double power_of(const struct system *system, unsigned mask, unsigned wanted, double t,
                       const double *y)
{
    double sum = 0;
    for (int i = 0; i < system->terms; i++)
        if ((system->term[i].row->flags & mask) == wanted)
            sum += term_power(system, &system->term[i], t, y);
    return sum;
}

double system_power(const struct system *system, double t, const double *y)
{
    return power_of(system, 0, 0, t, y);
}

double system_dissipation(const struct system *system, double t, const double *y)
{
    return power_of(system, TERM_TIME | TERM_VELOCITY, TERM_VELOCITY, t, y);
}

/*
 * The solution is v E / (1 + c |v| phi), E = exp(-gamma h), phi = (1 - E) / gamma. Where E would
 * grow (gamma h < 0) numerator and denominator are divided by it.
 */
struct drag_flow oscillator_drag_flow(const struct oscillator *oscillator, double h)
{
    double gamma = oscillator->damping, x = gamma * h, decay = fixed_exp(-fabs(x));
    double phi = x != 0 ? -fixed_expm1(-fabs(x)) / fabs(gamma) : fabs(h);
    return (struct drag_flow){x < 0 ? 1 : decay, x < 0 ? decay : 1,
                              oscillator->quadratic * copysign(phi, h)};
}

struct variable system_variable(const struct system *system, int i)
{
    return system->model->variable[i];
}

/* ---- binding ---- */

/* Sets the error that a term has no finite value for a row at the state y. Returns false. */
static bool overflows(const struct system *system, const struct bound_term *term, int row,
                      const double *y, struct error *error)
{
    struct buffer state_text = {0};
    for (int i = 0; i < system->n; i++) {
        buffer_format(&state_text, "%s%s = ", i > 0 ? ", " : "", system->model->variable[i].name);
        buffer_quantity(&state_text, y[i], system->model->variable[i].quantity, 4);
    }
    const char *where = state_text.data ? state_text.data : "?";
    if (term->row->bind)
        error_set(error, ERROR_COMMAND, "the %s force overflows at %s", term->row->row.name, where);
    else
        error_set(error, ERROR_COMMAND, "%s%s has no finite value at %s",
                  system->model->variable[row].name, system->order == 2 ? "''" : "'", where);
    buffer_free(&state_text);
    return false;
}

/* Returns the number of values of a bound term. */
static int coefficients(const struct term_row *row)
{
    return row->bind ? TERM_COEFFICIENTS : TERM_VALUES;
}

bool bound_term_equal(const struct bound_term *a, const struct bound_term *b)
{
    return a->row == b->row && memcmp(a->c, b->c, (size_t)coefficients(a->row) * sizeof *a->c) == 0;
}

/* Returns true if the coefficients are finite, and also the forces at the start and at full swing,
 * if `started`. Otherwise sets an error. */
static bool check_term(const struct system *system, const struct bound_term *term, bool started,
                       struct error *error)
{
    double rest = 0; /* becomes NAN if one is not finite */
    for (int i = 0; i < TERM_COEFFICIENTS; i++)
        rest += term->c[i] - term->c[i];
    /* Values of typed terms contain pointers and retained values, so that they are not checked. */
    if (term->row->bind && rest != 0)
        return error_set(error, ERROR_COMMAND, "a coefficient of the %s term overflows",
                         term->row->row.name);
    /* Typed terms may have a pole at full swing. */
    const double *states[] = {system->start, system->scale};
    for (size_t i = 0; started && i < (system->model->typed ? 1 : COUNT_OF(states)); i++) {
        const int rows = term_rows(system);
        double a[LIMIT_VARIABLES];
        a[0] = 0;
        for (int row = 1; row < rows; row++)
            a[row] = 0;
        term->row->add(term->c, system->t0, states[i], a);
        for (int row = 0; row < rows; row++)
            if (!isfinite(a[row]))
                return overflows(system, term, row, states[i], error);
    }
    return true;
}

/* Adds the built-in terms whose coefficients are not 0. */
static void bind_rows(const double *param, struct system *system)
{
    const struct catalog *terms = system->model->terms;
    const struct term_row *const rows = terms->rows;
    if (terms == &term_catalog) {
        terms_bind(param, system);
        return;
    }
    for (const struct term_row *row = rows; row < rows + terms->count; row++) {
        struct bound_term *term = &system->term[system->terms];
        if (!row->bind) /* a typed term, which typed_bind() adds */
            continue;
        term->row = row;
        memset(term->c, 0, TERM_COEFFICIENTS * sizeof *term->c);
        system->terms += row->bind(param, term->c, &system->oscillator);
    }
}

/* Derives the properties of the system from the flags of its terms. */
void system_sum_up(struct system *system)
{
    unsigned all = ~0u, any = 0;
    for (int i = 0; i < system->terms; i++) {
        all &= system->term[i].row->flags;
        any |= system->term[i].row->flags &
               (system->dry && i == system->terms - 1 ? ~(unsigned)TERM_VELOCITY : ~0u);
    }
    system->linear = all & TERM_LINEAR;
    system->conservative = system->order == 2 && all & TERM_CONSERVATIVE;
    system->velocity = any & TERM_VELOCITY;
    system->autonomous = !(any & TERM_TIME);
    system->kinks = system->order == 2 && system->n == 2 &&
                    (any & TERM_KINK || system->oscillator.quadratic != 0);
    if (system->n > 2 && system->oscillator.quadratic != 0) /* |v| is not that of each coordinate */
        system->oscillator.drag_whole = false;
}

/* Returns true if steps of fixed size end at switches, too. An oscillator with |v| v has turning
 * points instead. */
static bool has_pieces(const struct system *system)
{
    return !system->steps_across_kinks && system->switches > 0 &&
           (system->dry || !system->model->typed || !typed_turns_only(system));
}

/* Makes steps end at kinks and switches, also if the scene asks to step across them. */
void system_turn_at_kinks(struct system *system)
{
    const bool dry =
        !system->dry && system->terms > 0 && system->term[system->terms - 1].row->flags & TERM_DRY;
    system->steps_across_kinks = false;
    system->switches += dry;
    system->pieces = has_pieces(system) || dry;
    if (!dry)
        return;
    system->dry = true;
    system_sum_up(system);
}

/* Moves the term of dry friction, if there is one, behind all other terms, and counts its switch as
 * the last one. For methods that step across kinks it is not counted as a switch. */
static void bind_dry(struct system *system)
{
    for (int i = 0; i < system->terms; i++) {
        if (!(system->term[i].row->flags & TERM_DRY))
            continue;
        const struct bound_term dry = system->term[i];
        for (int k = i; k < system->terms - 1; k++)
            system->term[k] = system->term[k + 1];
        system->term[system->terms - 1] = dry;
        system->dry = !system->steps_across_kinks;
        system->switches += system->dry;
        system_sum_up(system);
        if (system->steps_across_kinks)
            system->oscillator.drag_whole = false;
        return;
    }
}

/* Makes *system one of the model without terms. Clears only members that are read, since the struct
 * has ten kilobytes and a sweep binds millions of systems. */
static void system_clear(const struct model *model, struct system *system)
{
    system->model = model;
    system->n = model->n;
    system->order = model->order;
    system->terms = system->switches = 0;
    system->extended = false;
    system->dry = system->pieces = false;
    system->sliding = NULL;
    system->energy = false;
    system->typed.row = NULL;
    system->mass = system->t0 = 0;
    memset(system->ratio, 0, (size_t)(model->n / 2) * sizeof *system->ratio);
    memset(system->start, 0, (size_t)model->n * sizeof *system->start);
    memset(system->scale, 0, (size_t)model->n * sizeof *system->scale);
    system->oscillator = (struct oscillator){
        .whole = typed_base(model) == &oscillator_model,
        .drag_whole = model->order == 2,
    };
}

/* Copies only the terms that there are, because a system is large. */
void system_copy(struct system *target, const struct system *source)
{
    const size_t terms =
                     offsetof(struct system, term) + (size_t)source->terms * sizeof *source->term,
                 typed = source->typed.row ? offsetof(struct system, typed)
                                           : offsetof(struct system, linear);
    memcpy(target, source, terms);
    target->typed.row = source->typed.row;
    memcpy((char *)target + typed, (const char *)source + typed, sizeof *source - typed);
}

/* Binds the scene without looking for a potential. Natural sizes of typed scenes take a trial
 * run; without `sized` they are 1, and forces at the start are not checked. Returns false with
 * an error. */
static bool bind_motion(const struct scene *scene, bool sized, struct system *system,
                        struct error *error)
{
    const struct model *model = scene->model;
    const double *param = scene->value;
    if (model->coherent && !model->coherent(param, error))
        return false;
    system_clear(model, system);
    memcpy(system->atol, scene->atol, (size_t)model->n * sizeof *system->atol);
    bind_rows(param, system);
    if (model->typed)
        system_sum_up(system);
    system->steps_across_kinks = scene->steps_across_kinks;
    if (typed_base(
            model)) /* sizes are those without what was typed, unless that is an oscillator, too */
        model->begin(param, system);
    if (model->typed && !typed_bind(model->typed, param, system, error))
        return false;
    system_sum_up(system);
    system->switches = model->typed ? typed_switches(system) : 0;
    bind_dry(system);
    system->pieces = has_pieces(system);
    if (model->typed && !typed_base(model) && !sized)
        typed_start(param, system);
    else if (model->typed && (!typed_base(model) || system->oscillator.whole))
        model->begin(param, system);
    for (int i = 0; i < system->terms; i++)
        if (!check_term(system, &system->term[i], sized, error))
            return false;
    return !model->typed || typed_check(system, error);
}

bool scene_bind_motion(const struct scene *scene, struct system *system, struct error *error)
{
    return bind_motion(scene, true, system, error);
}

bool scene_bind_rates(const struct scene *scene, struct system *system)
{
    struct error ignored;
    return bind_motion(scene, false, system, &ignored);
}

/* Binds the motion, and looks for a potential of typed forces. */
bool scene_bind(const struct scene *scene, struct system *system, struct error *error)
{
    if (!scene_bind_motion(scene, system, error))
        return false;
    if (scene->model->typed && typed_find_potential(system))
        system_sum_up(system);
    system->energy = system->order == 2 && (!scene->model->typed || typed_has_energy(system));
    return true;
}

/* Returns true if a shift by 2 pi changes no derivative, at random states, and one by 1 does. */
bool variable_is_angle(const struct system *system, int variable)
{
    const int n = system->n;
    uint64_t seed = 17;
    bool matters = false;
    for (int k = 0; k < 8; k++) {
        double y[LIMIT_VARIABLES], rate[2][LIMIT_VARIABLES], size = 0;
        for (int i = 0; i < n; i++)
            y[i] = system->start[i] + system->scale[i] * (2 * random_fraction(&seed) - 1);
        const double t = system->t0 + random_fraction(&seed), saved_value = y[variable];
        system_derivative(system, t, y, rate[0]);
        y[variable] = saved_value + TWO_PI;
        system_derivative(system, t, y, rate[1]);
        for (int i = 0; i < n; i++)
            size = fmax(size, fabs(rate[0][i]));
        for (int i = 0; i < n; i++)
            if (!(fabs(rate[1][i] - rate[0][i]) <= 1e-12 * (size + DBL_MIN)))
                return false;
        y[variable] = saved_value + 1;
        system_derivative(system, t, y, rate[1]);
        for (int i = 0; i < n; i++)
            matters = matters || fabs(rate[1][i] - rate[0][i]) > 1e-9 * size;
    }
    return matters;
}
