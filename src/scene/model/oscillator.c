/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The oscillator: the spring and all that can be hung on it. Its parameters and terms are
 * terms.def. */
#include "scene/model/params.h"

/* Sets the natural sizes system->scale of position and velocity: the largest of several motions,
 * from the start, to the equilibrium, in the wells of a cubic force (coefficient `cubic`), on a van
 * der Pol limit cycle (coefficient mu, width `width`), and in response to the drive, which is taken
 * no closer to resonance than a tenth of the spring's frequency squared. `rate` [1/s] is sqrt|k/m|
 * if there is a spring, else that of the other forces. The limit cycle of a strong van der Pol term
 * mostly creeps, which reduces the speed. */
void oscillator_scale(struct system *system, double cubic, double mu, double width)
{
    const struct oscillator *o = &system->oscillator;
    double y0 = fabs(system->start[0]), v0 = fabs(system->start[1]), g = fabs(o->gravity),
           f = fabs(o->drive);
    if (cubic > 0 && o->stiffness < 0)
        y0 = fmax(y0, sqrt(-o->stiffness / cubic));
    if (mu > 0 && o->stiffness > 0)
        y0 = fmax(y0, 2 * width);
    double rate = sqrt(fabs(o->stiffness));
    if (rate == 0) { /* largest displacement: cubic y^4/4 = v^2/2 */
        y0 = fmax(y0, cubic > 0 ? sqrt(v0 * sqrt(2 / cubic)) : 0);
        rate = sqrt(fabs(cubic)) * y0;
    }
    if (rate == 0)
        rate = fmax(fmax(fabs(o->damping),
                         sqrt(fabs(o->quadratic)) * fmax(sqrt(fabs(o->quadratic)) * v0, sqrt(g))),
                    f > 0 ? o->omega : 0);
    if (rate == 0 && v0 > 0)
        rate = o->friction / v0;
    if (rate == 0)
        rate = 1;
    double length = fmax(fmax(y0, v0 / rate), g / rate / rate), speed = length * rate;
    if (f > 0) {
        double detuning = (rate - o->omega) * (rate + o->omega);
        double answer = f / fmax(fixed_hypot(detuning, o->damping * o->omega), 0.1 * rate * rate);
        length = fmax(length, answer);
        speed = fmax(speed, answer * fmax(rate, o->omega));
    }
    if (mu > rate && o->stiffness > 0)
        speed *= rate / mu;
    system->scale[0] = scale_clamp(length);
    system->scale[1] = scale_clamp(speed);
}

/* Sets the start, the mass and the natural sizes (struct model's begin). */
static void oscillator_scales(const double *param, struct system *system)
{
    system->t0 = param[P_t0];
    system->mass = param[P_m];
    system->start[0] = param[P_y0];
    system->start[1] = param[P_v0];
    oscillator_scale(system, param[P_k3] / param[P_m], param[P_mu], param[P_width]);
}

static const struct variable variables[] = {{"y", QUANTITY_LENGTH}, {"v", QUANTITY_VELOCITY}};

const struct model oscillator_model = {
    .row = {"oscillator", "", "a mass moving along a line: spring, damping, drag, gravity, drive",
            "", NULL},
    .order = 2,
    .n = 2,
    .variable = variables,
    .params = &param_catalog,
    .terms = &term_catalog,
    .derived = &derived_catalog,
    .coherent = params_coherent,
    .begin = oscillator_scales,
};
