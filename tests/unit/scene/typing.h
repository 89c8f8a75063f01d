/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed scenes from text, as a command line would read it: one line each. */
#pragma once

#include <hooke/base/number.h>
#include <hooke/scene.h>
#include <stdio.h>
#include <string.h>

static inline struct text typing_word(struct text *rest)
{
    *rest = text_trim(*rest);
    size_t n = 0;
    while (n < rest->len && !strchr(" =", rest->data[n]))
        n++;
    struct text word = {rest->data, n};
    *rest = text_trim((struct text){rest->data + n, rest->len - n});
    return word;
}

/* var NAME = V | param NAME = V | NAME' = E | NAME'' = E | force E | potential E | observe NAME = E
 */
static inline struct typed_line typing_line(struct text text)
{
    struct typed_line line = {.kind = TYPED_EQUATION};
    struct text rest = text, word = typing_word(&rest);
    static const char *const kind[] = {
        [TYPED_VAR] = "var",     [TYPED_PARAM] = "param",         [TYPED_EQUATION] = "",
        [TYPED_FORCE] = "force", [TYPED_POTENTIAL] = "potential", [TYPED_OBSERVE] = "observe"};
    for (size_t i = 0; i < COUNT_OF(kind); i++)
        if (text_is(word, kind[i]))
            line.kind = (enum typed_kind)i;
    if (line.kind == TYPED_EQUATION)
        for (; word.len > 0 && word.data[word.len - 1] == '\''; word.len--)
            line.order++;
    if (line.kind != TYPED_FORCE && line.kind != TYPED_POTENTIAL) {
        line.name = line.kind == TYPED_EQUATION ? word : typing_word(&rest);
        if (rest.len > 0 && rest.data[0] == '=')
            rest = text_trim((struct text){rest.data + 1, rest.len - 1});
    }
    line.expr = rest;
    if (line.kind == TYPED_VAR || line.kind == TYPED_PARAM)
        real_parse(rest, &line.value);
    return line;
}

static inline const struct model *type_line(struct typed_models *models, const struct model *from,
                                            const char *text, struct error *error)
{
    const struct typed_line line = typing_line(text_of(text));
    return typed_add(models, from, &line, error);
}

/* Lines up to NULL on top of a scene; prints what went wrong. */
static inline bool type_scene(struct typed_models *models, struct scene *scene,
                              const char *const *lines)
{
    struct error error = {0};
    for (; *lines; lines++) {
        const struct model *model = type_line(models, scene->model, *lines, &error);
        if (!model) {
            fprintf(stderr, "%s: %s (%s)\n", *lines, error.text, error.hint);
            return false;
        }
        scene_remodel(scene, model);
    }
    return true;
}
