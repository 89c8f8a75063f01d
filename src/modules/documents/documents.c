/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module documents: tables and documents as Markdown, HTML and LaTeX. */
#include <hooke/module.h>

const struct module documents_module = {
    .row = {"documents", "", "tables and documents as Markdown, HTML and LaTeX", "", NULL},
    .needs = "",
};
