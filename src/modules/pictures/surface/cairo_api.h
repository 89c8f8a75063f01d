/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of cairo that pictures need, looked up in the shared library when a picture is
 * drawn: linking cairo would make every start of the program much slower, and few runs draw a
 * picture. The types are those of cairo's own header, so that a wrong call does not compile. Tests
 * put functions of their own into the table. */
#pragma once

#include <hooke/base/library.h>
#include "modules/pictures/pictures.h"

#ifdef HAVE_CAIRO
#include <cairo-pdf.h>
#include <cairo.h>

#define CAIRO_FUNCTIONS(X)                                                                         \
    X(pdf_surface_create_for_stream)                                                               \
    X(pdf_surface_set_metadata)                                                                    \
    X(image_surface_create)                                                                        \
    X(image_surface_get_data)                                                                      \
    X(image_surface_get_stride)                                                                    \
    X(surface_flush)                                                                               \
    X(surface_write_to_png_stream)                                                                 \
    X(surface_finish)                                                                              \
    X(surface_status)                                                                              \
    X(surface_destroy)                                                                             \
    X(create)                                                                                      \
    X(status)                                                                                      \
    X(destroy)                                                                                     \
    X(save)                                                                                        \
    X(restore)                                                                                     \
    X(scale)                                                                                       \
    X(translate)                                                                                   \
    X(rotate)                                                                                      \
    X(rectangle)                                                                                   \
    X(clip)                                                                                        \
    X(move_to)                                                                                     \
    X(line_to)                                                                                     \
    X(arc)                                                                                         \
    X(new_path)                                                                                    \
    X(new_sub_path)                                                                                \
    X(close_path)                                                                                  \
    X(set_source_rgb)                                                                              \
    X(set_source_rgba)                                                                             \
    X(set_line_width)                                                                              \
    X(set_line_cap)                                                                                \
    X(set_line_join)                                                                               \
    X(set_dash)                                                                                    \
    X(stroke)                                                                                      \
    X(fill_preserve)                                                                               \
    X(paint)                                                                                       \
    X(select_font_face)                                                                            \
    X(set_font_size)                                                                               \
    X(text_extents)                                                                                \
    X(show_text)

/* Pointers to the functions of cairo, without the prefix cairo_, and the library. */
struct cairo_api {
#define MEMBER(name) __typeof__(cairo_##name) *name;
    CAIRO_FUNCTIONS(MEMBER)
#undef MEMBER
    struct library library;
};

/* Loads the library of this name and looks up all functions. Returns false with *error that tells
 * what is missing. */
bool cairo_load(struct cairo_api *api, const char *library, struct error *error);
/* Unloads the library; the table must not be used after it. */
void cairo_unload(struct cairo_api *api);

/* Draws a figure, of width x height points, as any kind but SVG, with a loaded table, and appends
 * it to the output. Returns false with *error if out of memory. */
bool cairo_picture(const struct cairo_api *api, const struct figure *figure, enum picture kind,
                   double width, double height, struct buffer *output, struct error *error);
#endif
