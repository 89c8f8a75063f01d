/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types of equilibria. A centre is claimed only if the flow of two variables preserves areas, or is
 * reversed by a reflection that the equilibrium lies on (Devaney 1976), or if energy is
 * constant. */
#include "modules/dynamics/orbits/forms.h"

#include <hooke/base/catalog.h>
#include <hooke/scene/interval.h>
#include <hooke/scene/typed.h>
#include <math.h>

#include <hooke/base/numeric.h>

#include "modules/solving/compute/algebra.h"
#include "modules/dynamics/orbits/solutions.h"

#define REAL_PART_ZERO 1e-13 /* real part relative to the largest eigenvalue that counts as 0 */
/* Largest width of the bounds of a slope, relative to the largest slope, from which eigenvalues are
 * computed. */
static const double slope_uncertainty_max = 1e-3;
/* Uncertainty of the state of an equilibrium without a proof, relative to its values and sizes. */
static const double unproven_position_error = 1e-14;
/* Largest width, relative to the largest slope a natural size away, of slopes that are 0 but for
 * rounding. */
static const double slope_rounding_max = 1e-9;
#define SYMMETRY_SAMPLES 16              /* number of states at which symmetries are tested */
#define SYMMETRY_ROUNDING_RELATIVE 1e-11 /* rounding, as a part of the largest rate or slope */

static const struct row rows[] = {
    [EQUILIBRIUM_STABLE_NODE] = {"stable node", "", "all approach it without turning", "", NULL},
    [EQUILIBRIUM_STABLE_FOCUS] = {"stable focus", "", "all spiral into it", "", NULL},
    [EQUILIBRIUM_UNSTABLE_NODE] = {"unstable node", "", "all leave it, without turning", "", NULL},
    [EQUILIBRIUM_UNSTABLE_FOCUS] = {"unstable focus", "", "all spiral away from it", "", NULL},
    [EQUILIBRIUM_SADDLE] = {"saddle", "", "some approach it, most leave it", "", NULL},
    [EQUILIBRIUM_CENTRE] = {"centre", "", "closed orbits around it", "", NULL},
    [EQUILIBRIUM_DEGENERATE] = {"degenerate", "", "linear theory does not decide", "", NULL},
    [EQUILIBRIUM_STABLE] = {"stable", "", "all approach it", "", NULL},
    [EQUILIBRIUM_UNSTABLE] = {"unstable", "", "all leave it", "", NULL},
};
const struct catalog equilibrium_catalog = CATALOG("type", rows);

/* Takes the middle of the bounds at the single state y. */
void mean_field(const struct system *bounded, const double *y, double *rate, double *jacobian)
{
    const int n = bounded->n;
    struct interval point[FIELD_VARIABLES] = {{0}}, bound[FIELD_VARIABLES] = {{0}},
                    slopes[FIELD_VARIABLES * FIELD_VARIABLES] = {{0}};
    for (int i = 0; i < n; i++)
        point[i].lo = point[i].hi = y[i];
    system_bounds(bounded, point, bound, jacobian ? slopes : NULL);
    for (int i = 0; i < n; i++)
        rate[i] = interval_middle(bound[i]);
    for (int i = 0; jacobian && i < n * n; i++)
        jacobian[i] = interval_middle(slopes[i]);
}

/* Only scenes with typed forces on top of built-in terms have to be rewritten. */
bool scene_with_bounds(const struct scene *scene, const struct system *system,
                       struct typed_models **models, struct system *bounded, struct error *error)
{
    struct scene written;
    *models = NULL;
    *bounded = *system;
    return !typed_base(scene->model) ||
           ((*models = typed_create(error)) && typed_written(*models, scene, &written, error) &&
            scene_bind_motion(&written, bounded, error));
}

/* ---- symmetries of the plane ---- */

/* A system of two variables around an equilibrium. */
struct plane {
    const struct system *bounded;
    const double *size, *centre; /* [2] */
};

/* Chooses a random state within one size of the centre. */
static void sample_state(const struct plane *plane, uint64_t *seed, double *y)
{
    for (int i = 0; i < 2; i++)
        y[i] = plane->centre[i] + plane->size[i] * (2 * random_fraction(seed) - 1);
}

/* Returns true if the divergence is 0 at all sampled states. */
static bool keeps_areas(const struct plane *plane)
{
    uint64_t seed = 11;
    bool keeps = true;
    for (int k = 0; k < SYMMETRY_SAMPLES && keeps; k++) {
        double y[2] = {0}, rate[2], jacobian[4] = {0};
        sample_state(plane, &seed, y);
        mean_field(plane->bounded, y, rate, jacobian);
        keeps = fabs(jacobian[0] + jacobian[3]) <=
                SYMMETRY_ROUNDING_RELATIVE * fmax(fabs(jacobian[0]), fabs(jacobian[3]));
    }
    return keeps;
}

/* Returns true if R f(R y) = -f(y) at all sampled states, for the reflection R with matrix r about
 * the centre. */
static bool is_reversed_by(const struct plane *plane, const double r[4])
{
    const double *centre = plane->centre;
    uint64_t seed = 13;
    bool same = true;
    for (int k = 0; k < SYMMETRY_SAMPLES && same; k++) {
        double y[2] = {0}, other[2], f[2] = {0}, g[2] = {0};
        sample_state(plane, &seed, y);
        for (int i = 0; i < 2; i++)
            other[i] =
                centre[i] + r[2 * i] * (y[0] - centre[0]) + r[2 * i + 1] * (y[1] - centre[1]);
        mean_field(plane->bounded, y, f, NULL);
        mean_field(plane->bounded, other, g, NULL);
        for (int i = 0; i < 2; i++)
            same = same && fabs(r[2 * i] * g[0] + r[2 * i + 1] * g[1] + f[i]) <=
                               SYMMETRY_ROUNDING_RELATIVE * (fabs(f[0]) + fabs(f[1]));
    }
    return same;
}

/* Returns true if a system of two variables keeps areas or is reversible about this state, so that
 * it is a centre if its eigenvalues are imaginary. */
static bool has_centres(const struct vector_field *field, const struct system *bounded,
                        const double *centre)
{
    static const double reflection[][4] = {
        {1, 0, 0, -1}, {-1, 0, 0, 1}, {0, 1, 1, 0}, {0, -1, -1, 0}};
    const struct plane plane = {bounded, field->size, centre};
    bool has = field->n == 2 && keeps_areas(&plane);
    for (size_t i = 0; i < COUNT_OF(reflection) && !has && field->n == 2; i++)
        has = is_reversed_by(&plane, reflection[i]);
    return has;
}

/* ---- types ---- */

/* Returns the type of an equilibrium that has `zero` eigenvalues on the imaginary axis. `centre` is
 * true if it is known to be a centre. */
static enum equilibrium_type type_beside(const struct solution *s, int zero, bool centre)
{
    if (s->unstable > 0 && s->unstable + zero < s->values)
        return EQUILIBRIUM_SADDLE;
    if (s->unstable > 0 && s->values > 2)
        return EQUILIBRIUM_UNSTABLE;
    return centre ? EQUILIBRIUM_CENTRE : EQUILIBRIUM_DEGENERATE;
}

/* Returns the type of an equilibrium from its eigenvalues. With eigenvalues on the imaginary axis,
 * type_beside() decides; a centre is only reported for conservative motion or where has_centres()
 * proves it. Beyond two variables stable and unstable nodes and foci are not distinguished. */
static enum equilibrium_type type_of(const struct solution *s, const struct vector_field *field,
                                     const struct system *bounded, bool conservative)
{
    int zero = 0, turning = 0;
    for (int i = 0; i < s->values; i++) {
        zero += s->value[i].re == 0;
        turning += s->value[i].im != 0;
    }
    if (zero > 0)
        return type_beside(s, zero,
                           zero == s->values && turning == s->values &&
                               (conservative || has_centres(field, bounded, s->state)));
    if (s->unstable > 0 && s->unstable < s->values)
        return EQUILIBRIUM_SADDLE;
    if (s->values > 2)
        return s->unstable == 0 ? EQUILIBRIUM_STABLE : EQUILIBRIUM_UNSTABLE;
    if (turning > 0)
        return s->unstable == 0 ? EQUILIBRIUM_STABLE_FOCUS : EQUILIBRIUM_UNSTABLE_FOCUS;
    return s->unstable == 0 ? EQUILIBRIUM_STABLE_NODE : EQUILIBRIUM_UNSTABLE_NODE;
}

/* Returns the Poincare-Hopf index, the sign of det J, from the real eigenvalues (pairs have a
 * positive product), or 0 if an eigenvalue is 0. */
static int index_of(const struct solution *s)
{
    int negative_count = 0;
    for (int i = 0; i < s->values; i++) {
        if (s->value[i].re == 0 && s->value[i].im == 0)
            return 0;
        negative_count += s->value[i].im == 0 && s->value[i].re < 0;
    }
    return negative_count % 2 ? -1 : 1;
}

/* Multiplies the complex vector re + i im, each [n], by a phase, in place, so that its largest
 * component becomes real and positive. Among equally large components the first is taken, so that
 * the result does not depend on rounding. */
static void complex_vector_rotate(int n, double *re, double *im)
{
    int pivot = 0;
    for (int i = 1; i < n; i++)
        if (hypot(re[i], im[i]) > (1 + 1e-9) * hypot(re[pivot], im[pivot]))
            pivot = i;
    const double size = hypot(re[pivot], im[pivot]), c = re[pivot] / size, s = im[pivot] / size;
    for (int i = 0; i < n; i++) {
        const double x = re[i], y = im[i];
        re[i] = x * c + y * s;
        im[i] = i == pivot ? 0 : y * c - x * s;
    }
}

/* Sets form->re and im to the eigenvectors of the Jacobian [n x n] for the eigenvalues in
 * *solution, with the largest component real; the second of a complex pair is the conjugate of the
 * first. Vectors that are not found are NAN. */
static void find_vectors(int n, const double *jacobian, const struct solution *solution,
                         struct equilibrium_form *form)
{
    for (int k = 0; k < n; k++) {
        const struct eigenvalue *value = solution->value;
        const bool second = k > 0 && value[k].im != 0 && value[k].re == value[k - 1].re &&
                            value[k].im == -value[k - 1].im;
        bool fine = second || matrix_eigenvector(n, jacobian, value[k], form->re[k], form->im[k]);
        if (fine && !second)
            complex_vector_rotate(n, form->re[k], form->im[k]);
        for (int i = 0; i < n; i++) {
            fine = fine && (second || isfinite(form->re[k][i]));
            if (second || !fine) {
                form->re[k][i] = second ? form->re[k - 1][i] : NAN;
                form->im[k][i] = second ? -form->im[k - 1][i] : NAN;
            }
        }
    }
}

/* Sets real parts that are 0 but for rounding to 0, and counts the growing eigenvalues. */
static void round_real_parts(struct solution *s)
{
    double size = 0;
    for (int i = 0; i < s->values; i++)
        size = fmax(size, hypot(s->value[i].re, s->value[i].im));
    for (int i = 0; i < s->values; i++) {
        if (fabs(s->value[i].re) <= REAL_PART_ZERO * size)
            s->value[i].re = 0;
        s->unstable += s->value[i].re > 0;
    }
}

/* Returns the largest width of the bounds of the slopes [n][n], infinite if one has no bounds. */
static double widest_slope(int n, const struct interval *slopes)
{
    double widest = 0;
    for (int i = 0; i < n * n; i++)
        widest = isfinite(slopes[i].hi - slopes[i].lo) ? fmax(widest, slopes[i].hi - slopes[i].lo)
                                                       : HUGE_VAL;
    return widest;
}

/* Returns the largest magnitude in the middle of the bounds of the slopes [n][n]. */
static double largest_slope(int n, const struct interval *slopes)
{
    double largest = 0;
    for (int i = 0; i < n * n; i++)
        largest = fmax(largest, fabs(interval_middle(slopes[i])));
    return largest;
}

/* Returns true if the bounds of the slopes [n][n] at a state are narrow, relative to the largest
 * slope, or, if all are about 0, relative to the largest slope a natural size away. */
static bool slopes_are_known(const struct vector_field *field, const struct system *bounded,
                             const double *state, const struct interval *slopes)
{
    const int n = field->n;
    const double widest = widest_slope(n, slopes);
    struct interval there[FIELD_VARIABLES] = {{0}}, rate[FIELD_VARIABLES],
                    away[FIELD_VARIABLES * FIELD_VARIABLES];
    if (widest <= slope_uncertainty_max * largest_slope(n, slopes))
        return true;
    for (int i = 0; i < n; i++)
        there[i].lo = there[i].hi = state[i] + field->size[i];
    system_bounds(bounded, there, rate, away);
    return widest <= slope_rounding_max * largest_slope(n, away);
}

/* Marks eigenvalues and eigenvectors as unknown, since slopes are infinite or uncertain. */
static void form_without_slopes(int n, struct solution *solution, struct equilibrium_form *form)
{
    *form = (struct equilibrium_form){.type = EQUILIBRIUM_DEGENERATE};
    for (int k = 0; k < n; k++) {
        solution->value[k] = (struct eigenvalue){NAN, 0};
        for (int i = 0; i < n; i++)
            form->re[k][i] = form->im[k][i] = NAN;
    }
}

/* Classifies an equilibrium, solution->state: sets its eigenvalues, residual and extremes in
 * *solution, and type, index and eigenvectors in *form. The Jacobian is the middle of its interval
 * bounds, over a small region if the zero is multiple and its position uncertain. `conservative`
 * allows the type of a centre. Where the bounds do not determine the Jacobian the form has no
 * eigenvalues. Returns false if the eigenvalues cannot be computed. */
bool equilibrium_form(const struct vector_field *field, const struct system *bounded,
                      bool conservative, struct solution *solution, struct equilibrium_form *form)
{
    const int n = field->n;
    double jacobian[FIELD_VARIABLES * FIELD_VARIABLES], copy[FIELD_VARIABLES * FIELD_VARIABLES];
    struct interval region[FIELD_VARIABLES] = {{0}}, rate[FIELD_VARIABLES],
                    slopes[FIELD_VARIABLES * FIELD_VARIABLES];
    for (int i = 0; i < n; i++) {
        const double uncertainty =
            solution->multiple
                ? unproven_position_error * (fabs(solution->state[i]) + field->size[i])
                : 0;
        region[i] =
            (struct interval){solution->state[i] - uncertainty, solution->state[i] + uncertainty};
    }
    system_bounds(bounded, region, rate, slopes);
    for (int i = 0; i < n * n; i++)
        copy[i] = jacobian[i] = interval_middle(slopes[i]);
    for (int i = 0; i < n; i++) {
        solution->residual = fmax(solution->residual, fabs(interval_middle(rate[i])));
        solution->top[i] = solution->bottom[i] = solution->state[i];
    }
    solution->values = n;
    solution->trivial = NAN;
    if (!slopes_are_known(field, bounded, solution->state, slopes)) {
        form_without_slopes(n, solution, form);
        return true;
    }
    if (!matrix_eigenvalues(n, copy, solution->value))
        return false;
    round_real_parts(solution);
    *form = (struct equilibrium_form){.type = type_of(solution, field, bounded, conservative),
                                      .index = index_of(solution)};
    find_vectors(n, jacobian, solution, form);
    return true;
}
