/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Derived quantities of the oscillator, which follow from its parameters, with the uncertainty that
 * the parameters give them, and which can be set if they have an inverse. The values of typed
 * scenes are those of the oscillator that was recognised in them. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "scene/model/params.h"

double scene_reynolds(const struct scene *scene, double speed)
{
    if (scene->model != &oscillator_model)
        return NAN;
    return scene->value[P_rho] * speed * scene->value[P_length] / scene->value[P_eta];
}

/* Returns the kind of flow through a pipe at this Reynolds number. */
const char *reynolds_regime(double reynolds)
{
    if (reynolds < 2300)
        return "laminar";
    if (reynolds <= 4000)
        return "transitional";
    return reynolds > 4000 ? "turbulent" : "undefined";
}

/* ---- values; NaN if the scene has no such quantity ---- */

/* Binds a typed scene. Returns true if it is a single oscillator. */
static bool typed_motion(const struct scene *scene, struct system *system)
{
    struct error ignored;
    return scene->model->typed && scene_bind(scene, system, &ignored) && system->oscillator.whole;
}

/* Returns a parameter of the oscillator; NaN for a scene that is not based on the oscillator. */
static double oscillator_param(const struct scene *scene, enum param index)
{
    return typed_base(scene->model) == &oscillator_model ? scene->value[index] : NAN;
}

static double omega0(const struct scene *scene)
{
    struct system system;
    if (typed_motion(scene, &system))
        return system.oscillator.stiffness > 0 ? sqrt(system.oscillator.stiffness) : NAN;
    double k = oscillator_param(scene, P_k);
    return k > 0 ? sqrt(k) / sqrt(scene->value[P_m]) : NAN;
}

static double damping(const struct scene *scene)
{
    struct system system;
    return typed_motion(scene, &system) ? system.oscillator.damping
                                        : oscillator_param(scene, P_gamma);
}

static double T0(const struct scene *scene)
{
    return TWO_PI / omega0(scene);
}

static double f0(const struct scene *scene)
{
    return omega0(scene) / TWO_PI;
}

static double zeta(const struct scene *scene)
{
    return damping(scene) / 2 / omega0(scene);
}

static double Q(const struct scene *scene)
{
    double gamma = damping(scene);
    return gamma > 0 ? omega0(scene) / gamma : NAN;
}

static double tau(const struct scene *scene)
{
    double gamma = damping(scene);
    return gamma > 0 ? 2 / gamma : NAN;
}

static double omega_d(const struct scene *scene)
{
    double omega = omega0(scene), s = damping(scene) / 2;
    return omega > fabs(s) ? sqrt((omega - s) * (omega + s)) : NAN;
}

static double T_d(const struct scene *scene)
{
    return TWO_PI / omega_d(scene);
}

/* Returns the position of rest [m]; NaN if there is none or if it is the root of a cubic. */
static double equilibrium(const struct scene *scene)
{
    struct system system;
    if (typed_motion(scene, &system))
        return system.oscillator.stiffness != 0
                   ? -system.oscillator.gravity / system.oscillator.stiffness
                   : NAN;
    double k = oscillator_param(scene, P_k),
           weight = oscillator_param(scene, P_m) * oscillator_param(scene, P_g);
    return k != 0 && (weight == 0 || oscillator_param(scene, P_k3) == 0) ? -weight / k : NAN;
}

/* Returns the amplitude [m] of the free oscillation from the start. */
static double amplitude(const struct scene *scene)
{
    struct system system;
    if (typed_motion(scene, &system))
        return fixed_hypot(system.start[0] - equilibrium(scene), system.start[1] / omega0(scene));
    return fixed_hypot(oscillator_param(scene, P_y0) - equilibrium(scene),
                       oscillator_param(scene, P_v0) / omega0(scene));
}

double scene_start_energy(const struct scene *scene)
{
    struct system system;
    struct error error;
    if (!scene_bind(scene, &system, &error))
        return NAN;
    return system_kinetic(&system, system.start) + system_potential(&system, system.start);
}

static double E0(const struct scene *scene)
{
    return scene_start_energy(scene);
}

static double Re(const struct scene *scene)
{
    return scene_reynolds(scene, amplitude(scene) * omega0(scene));
}

/*
 * First-order propagation of independent uncertainties (GUM 5.1.2), each sensitivity a central
 * difference over a step small enough for its truncation and large enough for its rounding to be
 * invisible in an uncertainty.
 */
struct measured scene_propagate(const struct scene *scene, double (*value)(const struct scene *))
{
    double variance = 0;
    for (size_t i = 0; i < scene_params(scene)->count; i++) {
        double u = scene->uncertainty[i], x = scene->value[i];
        if (!(u > 0))
            continue;
        double step = 1e-5 * fmax(fabs(x), u);
        struct scene raised = *scene, lowered = *scene;
        raised.value[i] = x + step;
        lowered.value[i] = x - step;
        double part = (value(&raised) - value(&lowered)) / (raised.value[i] - lowered.value[i]) * u;
        variance += part * part;
    }
    return (struct measured){value(scene), sqrt(variance)};
}

/* ---- inverses: the value of the target parameter with which the quantity has this value; NaN if
 * it cannot have it ---- */

/* Returns the parameter that gives the coefficient `total` the value `target`. Typed forces add
 * their share to the coefficient, which is subtracted; NaN if that share depends on the
 * parameter. */
static double without_typed(const struct scene *scene, enum param index, double target,
                            double (*total)(const struct system *))
{
    struct system system;
    if (!typed_motion(scene, &system))
        return target;
    struct scene other = *scene;
    other.value[index] += target - total(&system);
    const double reached = typed_motion(&other, &system) ? total(&system) : NAN;
    return fabs(reached - target) <= 1e-9 * fabs(target) ? other.value[index] : NAN;
}

static double whole_stiffness(const struct system *system)
{
    return system->mass * system->oscillator.stiffness;
}

static double whole_damping(const struct system *system)
{
    return system->oscillator.damping;
}

static double omega0_inverse(const struct scene *scene, double value)
{
    return value > 0 ? without_typed(scene, P_k, scene->value[P_m] * value * value, whole_stiffness)
                     : NAN;
}

static double T0_inverse(const struct scene *scene, double value)
{
    return omega0_inverse(scene, TWO_PI / value);
}

static double f0_inverse(const struct scene *scene, double value)
{
    return omega0_inverse(scene, TWO_PI * value);
}

static double zeta_inverse(const struct scene *scene, double value)
{
    return without_typed(scene, P_gamma, 2 * value * omega0(scene), whole_damping);
}

static double Q_inverse(const struct scene *scene, double value)
{
    return value > 0 ? without_typed(scene, P_gamma, omega0(scene) / value, whole_damping) : NAN;
}

static double tau_inverse(const struct scene *scene, double value)
{
    return value > 0 ? without_typed(scene, P_gamma, 2 / value, whole_damping) : NAN;
}

/* name, unit, quantity, brief, citation, inverse and target parameter (or NULL). */
#define DERIVED_ROWS(ROW)                                                                          \
    ROW(omega0, "rad/s", ANGULAR_FREQUENCY, "angular frequency without damping, sqrt(k/m)", "",    \
        omega0_inverse, "k")                                                                       \
    ROW(T0, "s", TIME, "period without damping, 2 pi/omega0", "", T0_inverse, "k")                 \
    ROW(f0, "Hz", FREQUENCY, "frequency without damping, omega0/(2 pi)", "", f0_inverse, "k")      \
    ROW(zeta, "", NUMBER, "damping ratio gamma/(2 omega0): 1 is critical", "", zeta_inverse,       \
        "gamma")                                                                                   \
    ROW(Q, "", NUMBER, "quality factor omega0/gamma", "", Q_inverse, "gamma")                      \
    ROW(tau, "s", TIME, "time in which the amplitude falls to 1/e, 2/gamma", "", tau_inverse,      \
        "gamma")                                                                                   \
    ROW(omega_d, "rad/s", ANGULAR_FREQUENCY,                                                       \
        "angular frequency with damping, sqrt(omega0^2 - gamma^2/4)", "", NULL, NULL)              \
    ROW(T_d, "s", TIME, "period with damping, 2 pi/omega_d", "", NULL, NULL)                       \
    ROW(equilibrium, "m", LENGTH, "position of rest, -m g/k", "", NULL, NULL)                      \
    ROW(amplitude, "m", LENGTH, "initial amplitude about the position of rest", "", NULL, NULL)    \
    ROW(E0, "J", ENERGY, "energy at the start", "", NULL, NULL)                                    \
    ROW(Re, "", NUMBER, "Reynolds number at the largest speed, amplitude * omega0",                \
        "Reynolds 1883", NULL, NULL)

DERIVED_ROWS(MEASURED)
static const struct derived_row rows[] = {DERIVED_ROWS(DERIVED_ROW)};

const struct catalog derived_catalog = CATALOG("derived quantity", rows);

/* Copies the rows of the oscillator that the names of the model leave free, without their
 * inverses. */
bool derived_for_typed(const struct model *model, struct arena *arena, struct catalog *derived)
{
    struct derived_row *made = arena_array(arena, COUNT_OF(rows), sizeof *made);
    size_t count = 0;
    for (size_t i = 0; made && i < COUNT_OF(rows); i++) {
        const struct text name = text_of(rows[i].row.name);
        if (catalog_find(model->params, name) || model_state(model, name) >= 0 ||
            text_is(name, "Re"))
            continue;
        struct derived_row *row = &made[count++];
        *row = rows[i];
        row->inverse = NULL;
        row->target = NULL;
        if (row->quantity == QUANTITY_LENGTH) {
            row->quantity = model->variable[0].quantity;
            row->row.unit = quantity_unit(row->quantity);
        }
    }
    *derived = derived_catalog;
    derived->rows = made;
    derived->count = count;
    return made;
}

/* Sets the target parameter with which the quantity has this value and uncertainty. */
bool scene_set_derived(struct scene *scene, const struct derived_row *row, struct measured value,
                       struct error *error)
{
    char got[REAL_TEXT_SIZE];
    real_format(value.value, got);
    if (!row->inverse)
        return error_set(error, ERROR_COMMAND, "%s follows from the parameters and cannot be set",
                         row->row.name);
    double target = row->inverse(scene, value.value);
    if (!isfinite(target))
        return error_set(error, ERROR_COMMAND,
                         "%s cannot be %s%s%s here: no finite %s gives this value", row->row.name,
                         got, *row->row.unit ? " " : "", row->row.unit, row->target);
    double uncertainty = 0;
    if (value.uncertainty > 0) {
        double step = 1e-5 * fmax(fabs(value.value), value.uncertainty);
        double slope =
            (row->inverse(scene, value.value + step) - row->inverse(scene, value.value - step)) /
            (2 * step);
        uncertainty = fabs(slope) * value.uncertainty;
    }
    return scene_set(scene, scene_param(scene, row->target), (struct measured){target, uncertainty},
                     error);
}
