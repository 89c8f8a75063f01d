/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The store of references of the scenes that were studied last, and the functions that describe,
 * copy and free a reference. */
#include <hooke/base/unit.h>
#include "modules/comparison/compute/errors.h"

#include <stdlib.h>
#include <string.h>

void reference_free(struct reference *reference)
{
    free(reference->y);
    reference->y = NULL;
}

/* Returns false, and frees the reference, if the solution does not last over the span. */
bool reference_exists(const struct system *system, struct reference *reference,
                      const struct cancel *cancel, struct error *error)
{
    const double t0 = system->t0;
    reference->singular =
        system_singularity(system, t0, system->start, t0 + reference->span, cancel);
    if (isnan(reference->singular.t))
        return true;
    reference_free(reference);
    error_set(error, ERROR_NUMERICAL,
              "the solution %s at t = %.6g s, so errors cannot be measured beyond that time",
              singularity_text(&reference->singular), reference->singular.t);
    return error_hint(error, "use a shorter duration: duration = %.3g s",
                      0.9 * fabs(reference->singular.t - t0));
}

/* Writes what the reference is and how accurate, with its doubts. */
void reference_describe(const struct reference *reference, struct buffer *text)
{
    if (reference->exact) {
        buffer_format(text, "the closed form, accurate to %s", SHOWN_SHORT(reference->accuracy, 2));
        return;
    }
    buffer_format(text, "%s and %s, which agree to %s", reference->method[0]->row.name,
                  reference->method[1]->row.name, SHOWN_SHORT(reference->accuracy, 2));
    if (reference->dissenting_method[0])
        buffer_format(text,
                      ", but %s and %s agree with each other and differ from it by %s, even after "
                      "it was repeated with shorter steps; which one is right is unknown",
                      reference->dissenting_method[0]->row.name,
                      reference->dissenting_method[1]->row.name, SHOWN_SHORT(reference->apart, 2));
    if (reference->meaning != reference->span) {
        buffer_format(text, " until t0 + %s; from then on they differ",
                      SHOWN_QUANTITY(fabs(reference->meaning), QUANTITY_TIME, 3));
        buffer_put(
            text,
            reference->sudden
                ? TEXT(", and later values are meaningless (one of them missed something there, or "
                       "the steps do not resolve it)")
                : TEXT(", and later values are meaningless (chaos multiplies rounding errors)"));
    }
}

/* Returns true if both scenes have the same solution. Models are compared by address, since a typed
 * model is never changed: each typed line makes another one. */
static bool same_scene(const struct scene *a, const struct scene *b)
{
    return a->model == b->model && memcmp(a->value, b->value, sizeof a->value) == 0 &&
           memcmp(a->atol, b->atol, sizeof a->atol) == 0;
}

/* Returns the entry of the scene and span, or NULL if there is none or `references` is NULL. */
static struct stored_reference *stored_reference_find(struct references *references,
                                                      const struct scene *scene, double span)
{
    for (size_t i = 0; references && i < REFERENCES_STORED; i++) {
        struct stored_reference *stored = &references->stored[i];
        if (stored->used > 0 && stored->span == span && same_scene(&stored->scene, scene))
            return stored;
    }
    return NULL;
}

const struct reference *references_find(struct references *references, const struct scene *scene,
                                        double span)
{
    const struct stored_reference *stored = stored_reference_find(references, scene, span);
    return stored && stored->reference.y ? &stored->reference : NULL;
}

/* Copies a reference with its states. Returns false if out of memory; target->y is NULL then. */
static bool reference_copy(const struct reference *source, struct reference *target)
{
    const size_t size = (size_t)STUDY_TIMES * (size_t)source->n;
    *target = *source;
    target->y = malloc(size * sizeof *target->y);
    if (target->y)
        memcpy(target->y, source->y, size * sizeof *target->y);
    return target->y;
}

/* Stores a copy of the reference, or the reason `why` there is none, in place of the entry that was
 * not used for the longest time. Stores nothing if out of memory. */
static void stored_reference_keep(struct references *references, const struct scene *scene,
                                  double span, const struct reference *reference,
                                  const struct error *why)
{
    struct stored_reference *oldest = &references->stored[0];
    for (size_t i = 1; i < REFERENCES_STORED; i++)
        if (references->stored[i].used < oldest->used)
            oldest = &references->stored[i];
    reference_free(&oldest->reference);
    *oldest = (struct stored_reference){.scene = *scene, .span = span, .used = ++references->uses};
    if (why) {
        oldest->why = *why;
        oldest->reference.singular = reference->singular;
    } else if (!reference_copy(reference, &oldest->reference)) {
        oldest->used = 0;
    }
}

/* Gets the stored reference of the scene, or computes and stores it. */
bool references_get(struct references *references, const struct scene *scene,
                    const struct system *system, double span, const struct cancel *cancel,
                    struct reference *reference, struct error *error)
{
    struct stored_reference *stored = stored_reference_find(references, scene, span);
    if (stored) {
        stored->used = ++references->uses;
        *reference = (struct reference){.singular = {.t = NAN}};
        if (!stored->reference.y) {
            reference->singular = stored->reference.singular;
            *error = stored->why;
            return false;
        }
        if (!reference_copy(&stored->reference, reference))
            return error_memory(error);
        reference->stored = true;
        return true;
    }
    const bool ok = study_reference(system, span, cancel, reference, error);
    if (references && (ok || error->code == ERROR_NUMERICAL))
        stored_reference_keep(references, scene, span, reference, ok ? NULL : error);
    return ok;
}

/* Computes a reference again that finer runs disagreed with, and replaces *reference and its stored
 * copy. Steps are at most half as long as before (reference->bound), even if `step` is longer, as
 * the result would otherwise be the same. If the copy fails, `used` is 0, which means that nothing
 * is stored. */
bool references_again(struct references *references, const struct scene *scene,
                      const struct system *system, double span, double step,
                      const struct cancel *cancel, struct reference *reference, struct error *error)
{
    struct reference anew;
    if (!study_reference_again(system, span, fmin(step, reference->bound / 2), cancel, &anew,
                               error))
        return false;
    anew.again = true;
    reference_free(reference);
    *reference = anew;
    struct stored_reference *stored = stored_reference_find(references, scene, span);
    if (stored) {
        reference_free(&stored->reference);
        stored->used = reference_copy(reference, &stored->reference) ? stored->used : 0;
    }
    return true;
}

/* Frees all stored references and zeroes the structure. */
void references_free(struct references *references)
{
    if (references->uses == 0) /* pages that were never touched stay so */
        return;
    for (size_t i = 0; i < REFERENCES_STORED; i++)
        reference_free(&references->stored[i].reference);
    *references = (struct references){0};
}
