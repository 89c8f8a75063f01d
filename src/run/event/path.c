/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The step just taken as a polynomial, and bounds of it. */
#include <hooke/scene/typed.h>
#include "run/event/watch.h"

#include <float.h>

#define ROUNDING (64 * DBL_EPSILON) /* of the sizes of a polynomial's terms */
#define TAIL 10 /* times its last terms: what is left out of a polynomial through samples */

/* Values at even shares of a stretch, degree + 1 of them: the polynomial c about its middle, in its
 * length (Newton). */
static void fit(const double *value, size_t stride, int degree, double *c, size_t apart)
{
    double difference[DENSE_DEGREE + 1], out[DENSE_DEGREE + 1] = {0};
    for (int i = 0; i <= degree; i++)
        difference[i] = value[(size_t)i * stride];
    for (int k = 1; k <= degree; k++)
        for (int i = degree; i >= k; i--)
            difference[i] = (difference[i] - difference[i - 1]) / k;
    for (int k = degree; k >= 0; k--) {
        const double shift = degree / 2. - k;
        for (int i = degree - k; i > 0; i--)
            out[i] = degree * out[i - 1] + shift * out[i];
        out[0] = shift * out[0] + difference[k];
    }
    for (int i = 0; i <= degree; i++)
        c[(size_t)i * apart] = out[i];
}

/* sum c_k s^k about s = 0, where |s| <= r: even powers are above 0. */
static struct interval range(const double *c, int degree, double r)
{
    struct interval out = {c[0], c[0]};
    double power = 1;
    for (int k = 1; k <= degree; k++) {
        power *= r;
        const double max = c[k] * power;
        out.lo += k % 2 ? -fabs(max) : fmin(max, 0);
        out.hi += k % 2 ? fabs(max) : fmax(max, 0);
    }
    return out;
}

static void differentiate(double *c, int degree)
{
    for (int k = 1; k <= degree; k++)
        c[k - 1] = k * c[k];
}

/* Bounds of the polynomial c, which is lost, for |s| <= r; `width` of a whole stretch over which
 * `error` is spread. */
static struct jet bounds(double *c, int degree, double r, double error)
{
    struct jet jet;
    const double bend = 4. / 3 * degree * degree * (double)degree * degree,
                 slope = 2. * degree * degree;
    jet.value = range(c, degree, r);
    differentiate(c, degree);
    jet.slope = range(c, degree - 1, r);
    if (degree > 1) {
        differentiate(c, degree - 1);
        jet.bend = range(c, degree - 2, r);
    } else {
        jet.bend = (struct interval){0, 0};
    }
    jet.value = (struct interval){jet.value.lo - error, jet.value.hi + error};
    jet.slope = (struct interval){jet.slope.lo - slope * error, jet.slope.hi + slope * error};
    jet.bend = (struct interval){jet.bend.lo - bend * error, jet.bend.hi + bend * error};
    return jet;
}

struct jet path_fit(const double *value, int degree, double a, double b)
{
    double c[DENSE_DEGREE + 1], sum = 0, power = 1;
    fit(value, 1, degree, c, 1);
    double tail = 0;
    for (int k = 0; k <= degree; k++, power /= 2) {
        sum += fabs(c[k]) * power;
        tail += k > degree - 6 ? fabs(c[k]) * power : 0;
    }
    struct jet jet = bounds(c, degree, 0.5, TAIL * tail + ROUNDING * sum);
    const double scale = 1 / (b - a);
    jet.slope = (struct interval){jet.slope.lo * scale, jet.slope.hi * scale};
    jet.bend = (struct interval){jet.bend.lo * scale * scale, jet.bend.hi * scale * scale};
    return jet;
}

/* ---- of the step ---- */

void path_begin(struct step_path *path, const struct inside *inside)
{
    const struct run *run = inside->run;
    path->inside = *inside;
    path->end_t = run->t;
    path->known = false;
    copy_state(path->end, run->y, run->system.n);
}

/* Cubic through the ends and the slopes there. */
static void through_ends(struct step_path *path)
{
    const struct inside *inside = &path->inside;
    const double *before = inside->run->private_state->before, h = inside->h;
    struct sliding sliding = {0};
    struct system frozen;
    const struct step last = inside_step(inside, &sliding, &frozen);
    double f0[LIMIT_VARIABLES], f1[LIMIT_VARIABLES];
    system_derivative(last.system, last.t - last.h, before, f0);
    system_derivative(last.system, last.t, path->end, f1);
    sliding_free(&sliding);
    path->degree = 3;
    for (int i = 0; i < inside->run->system.n; i++) {
        const double rise = path->end[i] - before[i], bent = h * (f1[i] - f0[i]),
                     sum = h * (f0[i] + f1[i]);
        path->c[0][i] = (before[i] + path->end[i]) / 2 - bent / 8;
        path->c[1][i] = 1.5 * rise - sum / 4;
        path->c[2][i] = bent / 2;
        path->c[3][i] = sum - 2 * rise;
    }
}

/* Bent to go through the middle: as much is not known. */
static void through_middle(struct step_path *path)
{
    double middle[LIMIT_VARIABLES];
    inside_state(&path->inside, 0.5, middle);
    path->degree = 4;
    for (int i = 0; i < path->inside.run->system.n; i++) {
        const double off = middle[i] - path->c[0][i]; /* times (1 - 4 s^2)^2 */
        path->c[0][i] += off;
        path->c[2][i] -= 8 * off;
        path->c[4][i] = 16 * off;
        path->error[i] = fabs(off);
    }
}

/* The error of each variable: rounding. */
static void judge(struct step_path *path)
{
    for (int i = 0; i < path->inside.run->system.n; i++) {
        double sum = 0, power = 1;
        for (int k = 0; k <= path->degree; k++, power /= 2)
            sum += fabs(path->c[k][i]) * power;
        path->error[i] = ROUNDING * sum;
    }
}

static void through_samples(struct step_path *path, int degree)
{
    double sample[DENSE_DEGREE + 1][LIMIT_VARIABLES];
    for (int k = 0; k <= degree; k++)
        path_state(path, (double)k / degree, sample[k]);
    path->degree = degree;
    for (int i = 0; i < path->inside.run->system.n; i++)
        fit(&sample[0][i], LIMIT_VARIABLES, degree, &path->c[0][i], LIMIT_VARIABLES);
    judge(path);
}

void path_make(struct step_path *path)
{
    const bool side = path->inside.run->private_state->side != NULL;
    if (path->known)
        return;
    path->known = true;
    if (path->inside.method.dense) {
        through_samples(path, method_dense_degree(&path->inside.method));
        return;
    }
    through_ends(path);
    if (side)
        through_middle(path);
    else
        judge(path);
}

double path_time(const struct step_path *path, double theta)
{
    return theta >= 1 ? path->end_t : path->inside.t + theta * path->inside.h;
}

void path_state(const struct step_path *path, double theta, double *y)
{
    const struct run *run = path->inside.run;
    if (theta <= 0 || theta >= 1)
        copy_state(y, theta <= 0 ? run->private_state->before : path->end, run->system.n);
    else
        inside_state(&path->inside, theta, y);
}

void path_estimate(const struct step_path *path, double theta, double *y)
{
    for (int i = 0; i < path->inside.run->system.n; i++) {
        y[i] = path->c[path->degree][i];
        for (int k = path->degree; k-- > 0;)
            y[i] = y[i] * (theta - 0.5) + path->c[k][i];
    }
}

struct jet path_jet(const struct step_path *path, int variable, double a, double b)
{
    const int degree = path->degree;
    const double shift = (a + b) / 2 - 0.5;
    double c[DENSE_DEGREE + 1];
    for (int k = 0; k <= degree; k++)
        c[k] = path->c[k][variable];
    if (shift != 0) /* about the middle of a and b: Horner's scheme again and again */
        for (int i = 0; i < degree; i++)
            for (int k = degree - 1; k >= i; k--)
                c[k] += shift * c[k + 1];
    return bounds(c, degree, (b - a) / 2, path->error[variable]);
}
