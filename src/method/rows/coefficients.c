/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Coefficients of methods row by row, for `help METHOD`. */
#include <hooke/method/coefficients.h>
#include "method/step/step.h"

#include <math.h>
#include <string.h>

/* Sets a row without a time. Returns false if value is NULL, so that the next kind of row is
 * tried. */
static bool set_values(struct coefficient_row *row, const char *label, const double *value,
                       int count)
{
    *row = (struct coefficient_row){.label = label, .time = NAN, .count = count};
    if (value)
        memcpy(row->value, value, (size_t)count * sizeof *value);
    return value != NULL;
}

/* Sets a row of a tableau. Returns true. */
static bool set_stage(struct coefficient_row *row, double time, const double *value, int count)
{
    set_values(row, "", value, count);
    row->time = time;
    return true;
}

/* Sets the row that is number i among those of the `rows` arrays that the method has. Returns false
 * if there are fewer. */
static bool set_named(struct coefficient_row *row, int i, int count, int rows,
                      const char *const label[], const double *const value[])
{
    for (int k = 0; k < rows; k++)
        if (value[k] && i-- == 0)
            return set_values(row, label[k], value[k], count);
    return false;
}

/* Lists the stages a, then b and the embedded weights. */
static bool tableau_coefficients(const struct tableau *t, int i, struct coefficient_row *row)
{
    if (i < t->stages)
        return set_stage(row, t->c[i], tableau_row(t, i), i);
    return set_named(row, i - t->stages, t->stages, 2, (const char *const[]){"b", "b^"},
                     (const double *const[]){t->b, t->b_hat});
}

/* Lists the stages a, then b and the embedded weights. */
static bool implicit_coefficients(const struct implicit_tableau *t, int i,
                                  struct coefficient_row *row)
{
    if (i < t->stages)
        return set_stage(row, t->c[i], t->a + i * t->stages, t->stages);
    return set_named(row, i - t->stages, t->stages, 2, (const char *const[]){"b", "b^"},
                     (const double *const[]){t->b, t->b_hat});
}

/* Lists the stages a, then the weights of position and velocity, and the embedded ones. */
static bool nystrom_coefficients(const struct nystrom *t, int i, struct coefficient_row *row)
{
    if (i < t->stages)
        return set_stage(row, t->c[i], t->a + i * (i - 1) / 2, i);
    return set_named(row, i - t->stages, t->stages, 4, (const char *const[]){"b", "d", "b^", "d^"},
                     (const double *const[]){t->b, t->d, t->embedded_b, t->embedded_d});
}

/* Lists the stages a, the rows of c, gamma, then d, m and the embedded weights. */
static bool rosenbrock_coefficients(const struct rosenbrock *t, int i, struct coefficient_row *row)
{
    if (i < t->stages)
        return set_stage(row, t->alpha[i], t->a + i * (i - 1) / 2, i);
    i -= t->stages;
    if (i < t->stages - 1) /* the first row of the triangle is empty */
        return set_values(row, "c", t->c + (i + 1) * i / 2, i + 1);
    if (i == t->stages - 1)
        return set_values(row, "gamma", &t->gamma, 1);
    return set_named(row, i - t->stages, t->stages, 3, (const char *const[]){"d", "m", "m^"},
                     (const double *const[]){t->d, t->m, t->b_hat});
}

/* Lists two rows, drifts and kicks; the one that a step begins with is the first. */
static bool splitting_coefficients(const struct splitting *s, int i, struct coefficient_row *row)
{
    if (i > 1 || s->count > 2 * COEFFICIENTS_MAX)
        return false;
    *row = (struct coefficient_row){.label = s->kick_first == (i == 0) ? "kick" : "drift",
                                    .time = NAN};
    for (int k = i; k < s->count; k += 2)
        row->value[row->count++] = splitting_weight(s, k);
    return true;
}

/* Lists the values of backward differentiation, or predictor and corrector. */
static bool multistep_coefficients(const struct multistep *m, int i, struct coefficient_row *row)
{
    if (m->values)
        return i == 0 && set_values(row, "y", m->values, m->steps + 1);
    return set_named(row, i, m->steps, 2, (const char *const[]){"predict", "correct"},
                     (const double *const[]){m->predict, m->correct});
}

/* Fills in row i by the family of the method. Returns false if there is none. */
bool method_coefficients(const struct method *method, int i, struct coefficient_row *row)
{
    if (method->tableau)
        return tableau_coefficients(method->tableau, i, row);
    if (method->implicit)
        return implicit_coefficients(method->implicit, i, row);
    if (method->nystrom)
        return nystrom_coefficients(method->nystrom, i, row);
    if (method->rosenbrock)
        return rosenbrock_coefficients(method->rosenbrock, i, row);
    if (method->splitting)
        return splitting_coefficients(method->splitting, i, row);
    return method->multistep && multistep_coefficients(method->multistep, i, row);
}
