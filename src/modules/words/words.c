/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module words: figures in sentences and tables, for screen readers. Its charset makes all
 * plots words. */
#include <hooke/module.h>
#include "modules/words/internal.h"

static const struct figure_words words = {
    .describe = describe_figure,
    .print = words_print,
    .print_heat = words_heat,
    .draw = words_draw,
};

extern const struct charset words_charset;
const struct charset words_charset = {.dots = {1, 4}, .plain = true, .words = &words};

const struct module words_module = {
    .row = {"words", "", "plots in sentences and tables, for screen readers", "", NULL},
    .needs = "",
};
