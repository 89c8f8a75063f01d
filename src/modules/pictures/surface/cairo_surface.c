/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws pictures through cairo: PDF pages, PNG files, and pixels for terminals. */
#include "modules/pictures/surface/cairo_api.h"
#include "modules/pictures/surface/surface.h"

#include <hooke/base/numeric.h>

#ifdef HAVE_CAIRO

#define PICTURE_FONT "DejaVu Sans"

/* A surface that passes everything to cairo. */
struct cairo_surface {
    struct surface surface;
    const struct cairo_api *api;
    cairo_t *cairo;
};

/* Builds the path of the surface with cairo, then fills and strokes it. */
static void cairo_path_paint(struct surface *surface, const struct brush *brush)
{
    const struct cairo_surface *canvas = (struct cairo_surface *)(void *)surface;
    const struct cairo_api *api = canvas->api;
    const double *color = brush->color;
    double dashes[COUNT_OF(brush->dashes->length)];
    const int n = brush->dashes ? brush->dashes->n : 0;
    for (int i = 0; i < n; i++)
        dashes[i] = brush->dash * brush->dashes->length[i];
    api->set_source_rgba(canvas->cairo, color[0], color[1], color[2],
                         brush->opacity > 0 ? brush->opacity : 1);
    api->set_dash(canvas->cairo, dashes, n, 0);
    api->new_path(canvas->cairo);
    for (size_t i = 0; i < surface->points; i++) {
        const struct path_point *point = &surface->path[i];
        if (point->kind == PATH_MOVE) {
            api->move_to(canvas->cairo, point->x, point->y);
        } else if (point->kind == PATH_LINE) {
            api->line_to(canvas->cairo, point->x, point->y);
        } else if (point->kind == PATH_CLOSE) {
            api->close_path(canvas->cairo);
        } else {
            api->new_sub_path(canvas->cairo);
            api->arc(canvas->cairo, point->x, point->y, point->radius, 0, TWO_PI);
        }
    }
    if (brush->fill)
        api->fill_preserve(canvas->cairo);
    api->set_line_width(canvas->cairo, brush->width);
    if (brush->width > 0)
        api->stroke(canvas->cairo);
}

/* Restricts drawing to the box (left, top, right, bottom); NULL ends that. */
static void cairo_box_clip(struct surface *surface, const double box[4])
{
    const struct cairo_surface *canvas = (struct cairo_surface *)(void *)surface;
    if (!box) {
        canvas->api->restore(canvas->cairo);
        return;
    }
    canvas->api->save(canvas->cairo);
    canvas->api->new_path(canvas->cairo);
    canvas->api->rectangle(canvas->cairo, box[0], box[1], box[2] - box[0], box[3] - box[1]);
    canvas->api->clip(canvas->cairo);
}

/* Returns the width [pt] of a text, and sets the size of the font as a side effect. */
static double cairo_text_width(struct surface *surface, double size, const char *text)
{
    const struct cairo_surface *canvas = (struct cairo_surface *)(void *)surface;
    cairo_text_extents_t extents = {0};
    canvas->api->set_font_size(canvas->cairo, size);
    canvas->api->text_extents(canvas->cairo, text, &extents);
    return extents.x_advance;
}

/* Draws a text at (text->x, text->y), turned by 90 degrees or aligned (0 left, 1 right) as the text
 * demands. */
static void cairo_text_put(struct surface *surface, const struct surface_text *text)
{
    const struct cairo_surface *canvas = (struct cairo_surface *)(void *)surface;
    const struct cairo_api *api = canvas->api;
    const double width = cairo_text_width(surface, text->size, text->text);
    api->set_source_rgba(canvas->cairo, text->color[0], text->color[1], text->color[2], 1);
    api->new_path(canvas->cairo);
    api->save(canvas->cairo);
    api->translate(canvas->cairo, text->x, text->y);
    if (text->turned)
        api->rotate(canvas->cairo, -PI / 2);
    api->move_to(canvas->cairo, -text->align * width, 0);
    api->show_text(canvas->cairo, text->text);
    api->restore(canvas->cairo);
}

/* ---- files ---- */

/* Appends what cairo writes to the buffer `context`. */
static cairo_status_t append_bytes(void *context, const unsigned char *data, unsigned int length)
{
    struct buffer *buffer = context;
    buffer_put(buffer, (struct text){(const char *)data, length});
    return buffer->failed ? CAIRO_STATUS_WRITE_ERROR : CAIRO_STATUS_SUCCESS;
}

/* Creates cairo's own surface of width x height [pt]: a PDF that is written to `output`, or an
 * image in memory with PICTURE_PIXELS_EACH pixels a point. */
static cairo_surface_t *make_surface(const struct cairo_api *api, enum picture kind, double width,
                                     double height, struct buffer *output)
{
    if (kind != PICTURE_PDF)
        return api->image_surface_create(CAIRO_FORMAT_RGB24, (int)(PICTURE_PIXELS_EACH * width),
                                         (int)(PICTURE_PIXELS_EACH * height));
    cairo_surface_t *surface =
        api->pdf_surface_create_for_stream(append_bytes, output, width, height);
    /* no date, so that the same figure gives the same file */
    api->pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, NULL);
    return surface;
}

/* Appends the rows of an image of width x height pixels without padding. */
static void put_pixels(const struct cairo_api *api, cairo_surface_t *surface, int width, int height,
                       struct buffer *output)
{
    api->surface_flush(surface);
    const unsigned char *pixel = api->image_surface_get_data(surface);
    const size_t stride = (size_t)api->image_surface_get_stride(surface);
    for (int y = 0; y < height; y++)
        buffer_put(output,
                   (struct text){(const char *)pixel + stride * (size_t)y, 4 * (size_t)width});
}

/* Draws a figure of width x height [pt] on white paper and appends it to output as PNG, raw pixels
 * or PDF. Returns false with an error if out of memory. */
bool cairo_picture(const struct cairo_api *api, const struct figure *figure, enum picture kind,
                   double width, double height, struct buffer *output, struct error *error)
{
    static const struct surface_kind surface_kind = {cairo_path_paint, cairo_box_clip,
                                                     cairo_text_put, cairo_text_width};
    cairo_surface_t *surface = make_surface(api, kind, width, height, output);
    struct cairo_surface canvas = {{.kind = &surface_kind}, api, api->create(surface)};
    if (kind != PICTURE_PDF)
        api->scale(canvas.cairo, PICTURE_PIXELS_EACH, PICTURE_PIXELS_EACH);
    api->set_source_rgb(canvas.cairo, 1, 1, 1);
    api->paint(canvas.cairo);
    api->set_line_cap(canvas.cairo, CAIRO_LINE_CAP_ROUND);
    api->set_line_join(canvas.cairo, CAIRO_LINE_JOIN_ROUND);
    api->select_font_face(canvas.cairo, PICTURE_FONT, CAIRO_FONT_SLANT_NORMAL,
                          CAIRO_FONT_WEIGHT_NORMAL);
    bool drawn = picture_draw(&canvas.surface, figure, width, height) &&
                 api->status(canvas.cairo) == CAIRO_STATUS_SUCCESS;
    surface_free(&canvas.surface);
    api->destroy(canvas.cairo);
    if (drawn && kind == PICTURE_PNG)
        drawn =
            api->surface_write_to_png_stream(surface, append_bytes, output) == CAIRO_STATUS_SUCCESS;
    if (drawn && kind == PICTURE_PIXELS)
        put_pixels(api, surface, (int)(PICTURE_PIXELS_EACH * width),
                   (int)(PICTURE_PIXELS_EACH * height), output);
    api->surface_finish(surface);
    drawn = drawn && api->surface_status(surface) == CAIRO_STATUS_SUCCESS && !output->failed;
    api->surface_destroy(surface);
    return drawn || error_memory(error); /* only memory can have failed */
}
#endif
