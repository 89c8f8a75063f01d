/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pictures as files: their catalog, and the way to cairo. */
#include "figure/surface/cairo_api.h"
#include "figure/surface/surface.h"

#include <math.h>
#include <stdlib.h>

static const struct row picture_rows[] = {
    [PICTURE_SVG] = {"svg", "", "a picture for the web and for documents", "", NULL},
    [PICTURE_PDF] = {"pdf", "", "a page for documents and paper", "", NULL},
    [PICTURE_PNG] = {"png", "", "a picture of pixels", "", NULL},
};

const struct catalog picture_catalog = CATALOG("picture", picture_rows);

#ifdef HAVE_CAIRO

#define LIBRARY "libcairo.so.2"
#define ROOM ((size_t)48 << 20) /* libraries, fonts and a page: four times what was measured */
#define BYTES 48                /* of pixels and their file, a square point */

bool cairo_load(struct cairo_api *api, const char *library, struct error *error)
{
    static const struct library_symbol functions[] = {
#define SYMBOL(name) {"cairo_" #name, offsetof(struct cairo_api, name)},
        CAIRO_FUNCTIONS(SYMBOL)
#undef SYMBOL
    };
    const char *missing;
    *api = (struct cairo_api){0};
    if (library_load(&api->library, library, functions, COUNT_OF(functions), api, &missing))
        return true;
    if (missing)
        return error_set(error, ERROR_COMMAND, "%s has no %s: it is too old to draw pictures",
                         library, missing);
    error_set(error, ERROR_COMMAND, "pictures are drawn by cairo, but %s cannot be loaded",
              library);
    return error_hint(error, "install libcairo2, or write a picture into a file that ends in .svg");
}

void cairo_unload(struct cairo_api *api)
{
    library_unload(&api->library);
}

/* fontconfig and pixman crash on every fourth allocation that fails, and nobody outside can hinder
 * that: they are asked only where there is more than they need. area: [pt^2] of pixels. */
static bool is_room(double area)
{
    void *volatile room = malloc(ROOM + (size_t)(BYTES * area));
    free(room);
    return room != NULL;
}

static bool has_cairo(enum picture kind, struct error *error)
{
    struct cairo_api api;
    (void)kind;
    if (!cairo_load(&api, LIBRARY, error))
        return false;
    cairo_unload(&api);
    return true;
}

static bool through_cairo(const struct figure *figure, enum picture kind, double width,
                          double height, struct buffer *out, struct error *error)
{
    struct cairo_api api;
    if (!is_room(kind == PICTURE_PDF ? 0 : width * height))
        return error_memory(error);
    if (!cairo_load(&api, LIBRARY, error))
        return false;
    bool done = cairo_picture(&api, figure, kind, width, height, out, error);
    cairo_unload(&api);
    return done;
}
#else
static bool has_cairo(enum picture kind, struct error *error)
{
    error_set(error, ERROR_COMMAND, "this hooke was built without cairo, which draws %s",
              kind == PICTURE_PDF ? "pdf files" : "pixels");
    return error_hint(
        error, "install libcairo2-dev and build it again, or write a picture into a file that ends "
               "in .svg");
}

static bool through_cairo(const struct figure *figure, enum picture kind, double width,
                          double height, struct buffer *out, struct error *error)
{
    (void)figure, (void)width, (void)height, (void)out;
    return has_cairo(kind, error);
}
#endif

static bool as_svg(const struct figure *figure, double width, double height, struct buffer *out,
                   struct error *error)
{
    struct svg_surface svg;
    svg_begin(&svg, width, height, picture_style(width, height).font, figure->title, out);
    const bool drawn = picture_draw(&svg.surface, figure, width, height);
    svg_end(&svg);
    const bool failed = !drawn || svg.surface.failed;
    surface_free(&svg.surface);
    return !failed || error_memory(error);
}

#define LENGTH_MIN 60 /* [pt] of a page */
#define LENGTH_MAX 5000

static double page_length(double wanted, double usual)
{
    return !(wanted > 0) ? usual : fmin(fmax(wanted, LENGTH_MIN), LENGTH_MAX);
}

bool picture_offered(enum picture kind, struct error *error)
{
    return kind == PICTURE_SVG || has_cairo(kind, error);
}

bool figure_picture(const struct figure *figure, enum picture kind, double width, double height,
                    struct buffer *out, struct error *error)
{
    width = page_length(width, PICTURE_WIDTH);
    height = page_length(height, PICTURE_HEIGHT);
    return kind == PICTURE_SVG ? as_svg(figure, width, height, out, error)
                               : through_cairo(figure, kind, width, height, out, error);
}
