/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes pictures of figures: SVG directly, other kinds through cairo, which is loaded on demand and
 * runs in a process of its own. */
#include "modules/pictures/surface/cairo_api.h"
#include "modules/pictures/surface/surface.h"

#include <hooke/base/child.h>

#include <math.h>

#ifdef HAVE_CAIRO

#define CAIRO_LIBRARY "libcairo.so.2"
/* Time that a picture may take [s], 1000 times that of the largest known. */
#define PICTURE_SECONDS_MAX 60

/* Loads the library and looks up all functions of CAIRO_FUNCTIONS into *api. Returns false with an
 * error if the library is missing, or too old to have all of them. */
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
    error_set(error, ERROR_COMMAND, "pictures need cairo, but %s cannot be loaded", library);
    return error_hint(error, "install libcairo2, or write a picture into a file that ends in .svg");
}

void cairo_unload(struct cairo_api *api)
{
    library_unload(&api->library);
}

/* A picture that the other process has to draw. */
struct cairo_work {
    const struct figure *figure; /* figure, or NULL to test only if the library is installed */
    enum picture kind;
    double width, height; /* [pt] */
};

/* Loads cairo and draws the picture, in the other process. */
static bool cairo_work_run(const void *context, struct buffer *output, struct error *error)
{
    const struct cairo_work *work = context;
    struct cairo_api api;
    return cairo_load(&api, CAIRO_LIBRARY, error) &&
           (!work->figure || cairo_picture(&api, work->figure, work->kind, work->width,
                                           work->height, output, error));
}

/* Returns true if the user has pressed Ctrl-C while the figure was drawn. */
static bool work_stopped(const void *context)
{
    const struct cairo_work *work = context;
    return work->figure && figure_stopped(work->figure);
}

/* Draws a picture with cairo in another process, since fontconfig and pixman may crash or hang when
 * an allocation fails. Returns false with *error, and a hint if the process failed. */
static bool through_cairo(const struct figure *figure, enum picture kind, double width,
                          double height, struct buffer *output, struct error *error)
{
    const struct cairo_work job = {figure, kind, width, height};
    const struct child child = {cairo_work_run, work_stopped, &job,
                                "the picture could not be drawn", PICTURE_SECONDS_MAX};
    const bool done = child_run(&child, output, error);
    if (!done && error->code == ERROR_IO)
        error_hint(error, "a file that ends in .svg needs no system library");
    return done;
}

/* Returns true if cairo can be loaded in another process; otherwise sets *error. */
static bool has_cairo(enum picture kind, struct error *error)
{
    struct buffer nothing = {0};
    const bool done = through_cairo(NULL, kind, 0, 0, &nothing, error);
    buffer_free(&nothing);
    return done;
}
#else
static bool has_cairo(enum picture kind, struct error *error)
{
    error_set(error, ERROR_COMMAND, "this hooke was built without cairo, which is needed for %s",
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

/* Appends the figure as an SVG document. Returns false with *error if out of memory. */
static bool svg_picture(const struct figure *figure, double width, double height,
                        struct buffer *output, struct error *error)
{
    struct svg_surface svg;
    svg_begin(&svg, width, height, picture_style(width, height).font, figure->title, output);
    const bool drawn = picture_draw(&svg.surface, figure, width, height);
    svg_end(&svg);
    const bool failed = !drawn || svg.surface.failed;
    surface_free(&svg.surface);
    return !failed || error_memory(error);
}

#define LENGTH_MIN 60   /* [pt] smallest width and height of a page */
#define LENGTH_MAX 5000 /* [pt] largest width and height of a page */

/* Returns the wanted length within these limits, or the usual one if none is wanted. */
static double page_length(double wanted, double usual)
{
    return !(wanted > 0) ? usual : fmin(fmax(wanted, LENGTH_MIN), LENGTH_MAX);
}

bool picture_offered(enum picture kind, struct error *error)
{
    return kind == PICTURE_SVG || has_cairo(kind, error);
}

bool figure_picture(const struct figure *figure, enum picture kind, double width, double height,
                    struct buffer *output, struct error *error)
{
    width = page_length(width, PICTURE_WIDTH);
    height = page_length(height, PICTURE_HEIGHT);
    return kind == PICTURE_SVG ? svg_picture(figure, width, height, output, error)
                               : through_cairo(figure, kind, width, height, output, error);
}
