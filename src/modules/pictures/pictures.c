/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module pictures: `plot > FILE` writes figures as SVG, PDF and PNG. */
#include "modules/pictures/pictures.h"

#include <hooke/base/catalog.h>
#include <hooke/module.h>

static const struct row picture_rows[] = {
    [PICTURE_SVG] = {"svg", "", "a picture for the web and for documents", "", NULL},
    [PICTURE_PDF] = {"pdf", "", "a page for documents and paper", "", NULL},
    [PICTURE_PNG] = {"png", "", "a picture made of pixels", "", NULL},
};

static const struct catalog picture_catalog = CATALOG("picture", picture_rows);
static const struct catalog *const catalogs[] = {&picture_catalog, NULL};

/* Writes a figure as a picture of kind `kind`, a row of picture_rows. */
static bool write_picture(const struct figure *figure, size_t kind, double width, double height,
                          struct buffer *output, struct error *error)
{
    return figure_picture(figure, (enum picture)kind, width, height, output, error);
}

const struct module pictures_module = {
    .row = {"pictures", "", "figures as SVG, PDF and PNG files", "", NULL},
    .needs = "",
    .pictures =
        {
            .files = ".svg .pdf .png",
            .where = "a picture in a file that ends in .svg, .pdf or .png",
            .kinds = &picture_catalog,
            .write = write_picture,
        },
    .catalogs = catalogs,
};
