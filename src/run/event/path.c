/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The step just taken as polynomials, and bounds of them: struct step_path of watch.h. */
#include <hooke/scene/typed.h>
#include "run/event/watch.h"

#include <float.h>

/* Rounding error relative to the sizes of a polynomial's terms. */
#define POLYNOMIAL_ROUNDING (64 * DBL_EPSILON)
/* Terms that a polynomial through samples leaves out are taken to be below this many times its last
 * terms. */
#define TAIL_FACTOR 10

/* Sets the coefficients c, `apart` numbers from each other, of the polynomial through degree + 1
 * values at even distances, `stride` numbers from each other (Newton's divided differences). Its
 * variable is the distance from the middle, in units of the whole interval. */
static void polynomial_fit(const double *value, size_t stride, int degree, double *c, size_t apart)
{
    double difference[DENSE_DEGREE + 1], coefficient[DENSE_DEGREE + 1] = {0};
    for (int i = 0; i <= degree; i++)
        difference[i] = value[(size_t)i * stride];
    for (int k = 1; k <= degree; k++)
        for (int i = degree; i >= k; i--)
            difference[i] = (difference[i] - difference[i - 1]) / k;
    for (int k = degree; k >= 0; k--) {
        const double shift = degree / 2. - k;
        for (int i = degree - k; i > 0; i--)
            coefficient[i] = degree * coefficient[i - 1] + shift * coefficient[i];
        coefficient[0] = shift * coefficient[0] + difference[k];
    }
    for (int i = 0; i <= degree; i++)
        c[(size_t)i * apart] = coefficient[i];
}

/* Returns bounds of sum c_k s^k for |s| <= r: odd powers may have either sign, even ones only that
 * of c_k. */
static struct interval polynomial_range(const double *c, int degree, double r)
{
    struct interval bounds = {c[0], c[0]};
    double power = 1;
    for (int k = 1; k <= degree; k++) {
        power *= r;
        const double max = c[k] * power;
        bounds.lo += k % 2 ? -fabs(max) : fmin(max, 0);
        bounds.hi += k % 2 ? fabs(max) : fmax(max, 0);
    }
    return bounds;
}

/* Replaces the coefficients c by those of the derivative, one fewer. */
static void polynomial_differentiate(double *c, int degree)
{
    for (int k = 1; k <= degree; k++)
        c[k - 1] = k * c[k];
}

/* Returns bounds of the polynomial c, which is overwritten, and of its derivatives for |s| <= r.
 * They are widened by its error, which is `error` over one of `pieces` parts of the step and larger
 * for derivatives (Markov's inequality). */
static struct jet polynomial_bounds(double *c, int degree, double r, double error, int pieces)
{
    struct jet jet;
    const double square = (double)degree * degree * pieces * pieces;
    const double bend = 4. / 3 * square * degree * degree, slope = 2. * degree * degree * pieces;
    jet.value = polynomial_range(c, degree, r);
    polynomial_differentiate(c, degree);
    jet.slope = polynomial_range(c, degree - 1, r);
    if (degree > 1) {
        polynomial_differentiate(c, degree - 1);
        jet.bend = polynomial_range(c, degree - 2, r);
    } else {
        jet.bend = (struct interval){0, 0};
    }
    jet.value = (struct interval){jet.value.lo - error, jet.value.hi + error};
    jet.slope = (struct interval){jet.slope.lo - slope * error, jet.slope.hi + slope * error};
    jet.bend = (struct interval){jet.bend.lo - bend * error, jet.bend.hi + bend * error};
    return jet;
}

/* The error of the polynomial is estimated by its last terms. */
struct jet path_fit(const double *value, int degree, double a, double b)
{
    double c[DENSE_DEGREE + 1] = {0}, sum = 0, power = 1;
    polynomial_fit(value, 1, degree, c, 1);
    double tail = 0;
    for (int k = 0; k <= degree; k++, power /= 2) {
        sum += fabs(c[k]) * power;
        tail += k > degree - 6 ? fabs(c[k]) * power : 0;
    }
    struct jet jet =
        polynomial_bounds(c, degree, 0.5, TAIL_FACTOR * tail + POLYNOMIAL_ROUNDING * sum, 1);
    const double scale = 1 / (b - a);
    jet.slope = (struct interval){jet.slope.lo * scale, jet.slope.hi * scale};
    jet.bend = (struct interval){jet.bend.lo * scale * scale, jet.bend.hi * scale * scale};
    return jet;
}

/* ---- polynomials of the step ---- */

/* Begins the path of the step that has just been made: copies its description and the run's present
 * time and state as its end. Its polynomials are made when needed (path_make()). */
void path_begin(struct step_path *path, const struct inside *inside)
{
    const struct run *run = inside->run;
    path->inside = *inside;
    path->end_t = run->t;
    path->known = false;
    path->resolved = true;
    copy_state(path->end, run->y, run->system.n);
}

/* Makes the cubic through the ends and the slopes there. */
static void through_ends(struct step_path *path)
{
    const struct inside *inside = &path->inside;
    const double *y_begin = inside->run->private_state->previous_state, h = inside->h;
    struct sliding sliding = {0};
    struct system frozen;
    const struct step last = inside_step(inside, &sliding, &frozen);
    double f0[LIMIT_VARIABLES], f1[LIMIT_VARIABLES];
    system_derivative(last.system, last.t - last.h, y_begin, f0);
    system_derivative(last.system, last.t, path->end, f1);
    sliding_free(&sliding);
    path->degree = 3;
    path->pieces = 1;
    for (int i = 0; i < inside->run->system.n; i++) {
        const double rise = path->end[i] - y_begin[i], bent = h * (f1[i] - f0[i]),
                     sum = h * (f0[i] + f1[i]);
        path->piece->c[0][i] = (y_begin[i] + path->end[i]) / 2 - bent / 8;
        path->piece->c[1][i] = 1.5 * rise - sum / 4;
        path->piece->c[2][i] = bent / 2;
        path->piece->c[3][i] = sum - 2 * rise;
    }
}

/* Returns the sum of the magnitudes of the terms from the `first` on at |theta - middle| = r. */
static double terms_size(const struct path_piece *piece, int variable, int first, int degree,
                         double r)
{
    double sum = 0, power = 1;
    for (int k = 0; k <= degree; k++, power *= r)
        sum += k >= first ? fabs(piece->c[k][variable]) * power : 0;
    return sum;
}

/* Sets the errors of polynomials that are exact but for rounding. */
static void set_rounding(struct step_path *path)
{
    for (int i = 0; i < path->inside.run->system.n; i++)
        path->piece->error[i] =
            POLYNOMIAL_ROUNDING * terms_size(path->piece, i, 0, path->degree, 0.5);
}

/* Makes one polynomial of that degree through states of the method's dense output, which is such a
 * polynomial itself. */
static void through_samples(struct step_path *path, int degree)
{
    double sample[DENSE_DEGREE + 1][LIMIT_VARIABLES];
    for (int k = 0; k <= degree; k++)
        path_state(path, (double)k / degree, sample[k]);
    path->degree = degree;
    path->pieces = 1;
    for (int i = 0; i < path->inside.run->system.n; i++)
        polynomial_fit(&sample[0][i], LIMIT_VARIABLES, degree, &path->piece->c[0][i],
                       LIMIT_VARIABLES);
    set_rounding(path);
}

/* ---- steps without dense output, whose inner states are steps from its beginning ---- */

/* Returns the value of a variable in a piece at the distance s from its middle. */
static double piece_value(const struct path_piece *piece, int variable, int degree, double s)
{
    double y = piece->c[degree][variable];
    for (int k = degree; k-- > 0;)
        y = y * s + piece->c[k][variable];
    return y;
}

/* Returns true if the polynomial of part k of `pieces` equal parts of the step also follows the
 * path at one more point, at an uneven fraction: a motion whose period is a fraction of the step
 * may be the same at all even ones. Allowed are the polynomial's error and the share `resolved` of
 * the motion. */
static bool is_followed(const struct step_path *path, int k, int pieces, double resolved)
{
    static const double uneven = 0.6180339887498949; /* fraction of the part */
    const struct path_piece *piece = &path->piece[k];
    const double length = 1. / pieces;
    double y[LIMIT_VARIABLES];
    bool fine = true;
    path_state(path, (k + uneven) * length, y);
    for (int i = 0; i < path->inside.run->system.n && fine; i++) {
        const double value = piece_value(piece, i, path->degree, (uneven - 0.5) * length);
        fine = fabs(y[i] - value) <=
               piece->error[i] + resolved * terms_size(piece, i, 1, path->degree, length / 2);
    }
    return fine;
}

/* Replaces the cubic over a step by a quartic that also goes through the state in the middle. The
 * change is taken as its error. Returns false if that is too large a share of the motion, so that
 * the path is not resolved. */
static bool through_middle(struct step_path *path)
{
    /* the omitted terms are of a higher order and far smaller */
    static const double resolved = 1e-4;
    double middle[LIMIT_VARIABLES];
    bool fine = true;
    path_state(path, 0.5, middle);
    path->degree = 4;
    for (int i = 0; i < path->inside.run->system.n; i++) {
        struct path_piece *piece = path->piece;
        const double deviation = middle[i] - piece->c[0][i]; /* times (1 - 4 s^2)^2 */
        fine = fine && !(fabs(deviation) > resolved * terms_size(piece, i, 1, 3, 0.5) +
                                               POLYNOMIAL_ROUNDING * fabs(piece->c[0][i]));
        piece->c[0][i] += deviation;
        piece->c[2][i] -= 8 * deviation;
        piece->c[4][i] = 16 * deviation;
        piece->error[i] =
            fabs(deviation) + POLYNOMIAL_ROUNDING * terms_size(piece, i, 0, path->degree, 0.5);
    }
    return fine && is_followed(path, 0, 1, resolved);
}

/* Fits the polynomial of part k of `pieces` equal parts of the step. Its error is bounded by its
 * last terms, as the next one, (theta - a) … (theta - b), is below 1e-2 of the largest power.
 * Returns false if these are too large a share of the motion: the second derivative, whose error is
 * 1e4 times as large, must show how the path bends. */
static bool fit_piece(struct step_path *path, int k, int pieces)
{
    static const double left_out = 0.1, smooth = 1e-2, resolved = 1e-7;
    /* relative error of a value, in the last terms */
    static const double sample_noise = 2e4 * DBL_EPSILON;
    double sample[DENSE_DEGREE + 1][LIMIT_VARIABLES];
    struct path_piece *piece = &path->piece[k];
    const double length = 1. / pieces;
    bool fine = true;
    for (int j = 0; j <= DENSE_DEGREE; j++)
        path_state(path, length * (k + (double)j / DENSE_DEGREE), sample[j]);
    for (int i = 0; i < path->inside.run->system.n; i++) {
        polynomial_fit(&sample[0][i], LIMIT_VARIABLES, DENSE_DEGREE, &piece->c[0][i],
                       LIMIT_VARIABLES);
        double power = 1;
        for (int j = 0; j <= DENSE_DEGREE; j++, power *= pieces)
            piece->c[j][i] *= power;
        const double last = terms_size(piece, i, DENSE_DEGREE - 1, DENSE_DEGREE, length / 2),
                     motion = terms_size(piece, i, 1, DENSE_DEGREE, length / 2);
        fine = fine && last <= resolved * motion + sample_noise * fabs(piece->c[0][i]);
        piece->error[i] = (last <= smooth * motion ? left_out * last : TAIL_FACTOR * motion) +
                          POLYNOMIAL_ROUNDING * (fabs(piece->c[0][i]) + motion);
    }
    return fine && is_followed(path, k, pieces, resolved);
}

/* Doubles the number of parts until polynomials of DENSE_DEGREE resolve all of them, or up to
 * PATH_PIECES_MAX parts; then path->resolved may be false. */
static void through_pieces(struct step_path *path)
{
    path->degree = DENSE_DEGREE;
    for (path->pieces = 1;; path->pieces *= 2) {
        path->resolved = true;
        for (int k = 0; k < path->pieces && (path->resolved || path->pieces == PATH_PIECES_MAX);
             k++)
            path->resolved &= fit_piece(path, k, path->pieces);
        if (path->resolved || path->pieces == PATH_PIECES_MAX)
            return;
    }
}

/* Chooses the polynomial by what the method has: dense output, cubic, or pieces through inner
 * states. */
void path_make(struct step_path *path)
{
    const bool side = path->inside.run->private_state->side != NULL;
    if (path->known)
        return;
    path->known = true;
    if (!side && path->inside.method.dense) {
        through_samples(path, method_dense_degree(&path->inside.method));
        return;
    }
    through_ends(path);
    if (!side)
        set_rounding(path);
    else if (!through_middle(path))
        through_pieces(path);
}

double path_time(const struct step_path *path, double theta)
{
    return theta >= 1 ? path->end_t : path->inside.t + theta * path->inside.h;
}

/* Returns the states that were computed at both ends, and those of inside_state() between them. */
void path_state(const struct step_path *path, double theta, double *y)
{
    const struct run *run = path->inside.run;
    if (theta <= 0 || theta >= 1)
        copy_state(y, theta <= 0 ? run->private_state->previous_state : path->end, run->system.n);
    else
        inside_state(&path->inside, theta, y);
}

/* Returns the part of the step in which theta is, and sets *s to its distance from the middle of
 * the part. */
static int piece_at(const struct step_path *path, double theta, double *s)
{
    const int last = path->pieces - 1, k = (int)(theta * path->pieces), piece = k < last ? k : last;
    *s = theta - (piece + 0.5) / path->pieces;
    return piece;
}

void path_estimate(const struct step_path *path, double theta, double *y)
{
    double s;
    const struct path_piece *piece = &path->piece[piece_at(path, theta, &s)];
    for (int i = 0; i < path->inside.run->system.n; i++)
        y[i] = piece_value(piece, i, path->degree, s);
}

/* Returns the bounds of a variable for theta from a to b, both in part k, by its polynomial about
 * the middle of a and b. */
static struct jet piece_jet(const struct step_path *path, int k, int variable, double a, double b)
{
    const int degree = path->degree;
    const double shift = (a + b) / 2 - (k + 0.5) / path->pieces;
    double c[DENSE_DEGREE + 1] = {0};
    for (int j = 0; j <= degree; j++)
        c[j] = path->piece[k].c[j][variable];
    if (shift != 0) /* shift to the middle of a and b by repeated Horner's scheme */
        for (int i = 0; i < degree; i++)
            for (int j = degree - 1; j >= i; j--)
                c[j] += shift * c[j + 1];
    return polynomial_bounds(c, degree, (b - a) / 2, path->piece[k].error[variable], path->pieces);
}

/* Returns the smallest interval that contains both. */
static struct interval path_interval_hull(struct interval a, struct interval b)
{
    return (struct interval){fmin(a.lo, b.lo), fmax(a.hi, b.hi)};
}

/* Joins the bounds of all pieces between a and b. */
struct jet path_jet(const struct step_path *path, int variable, double a, double b)
{
    const int pieces = path->pieces;
    double s;
    const int first = piece_at(path, a, &s), last = piece_at(path, b, &s);
    if (first == last)
        return piece_jet(path, first, variable, a, b);
    struct jet all = piece_jet(path, first, variable, a, (first + 1.) / pieces);
    for (int k = first + 1; k <= last; k++) {
        const double s_begin = (double)k / pieces, s_end = fmin((k + 1.) / pieces, b);
        const struct jet jet = piece_jet(path, k, variable, s_begin, fmax(s_begin, s_end));
        all = (struct jet){path_interval_hull(all.value, jet.value),
                           path_interval_hull(all.slope, jet.slope),
                           path_interval_hull(all.bend, jet.bend)};
    }
    return all;
}
