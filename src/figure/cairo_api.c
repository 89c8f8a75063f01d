/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pictures as files: their catalog, and the way to cairo. */
#include "cairo_api.h"

static const struct row picture_rows[] = {
    [PICTURE_SVG] = {"svg", "", "a picture for the web and for documents", "", NULL},
    [PICTURE_PDF] = {"pdf", "", "a page for documents and paper", "", NULL},
    [PICTURE_PNG] = {"png", "", "a picture of pixels", "", NULL},
};

const struct catalog picture_catalog = CATALOG("picture", picture_rows);

#ifdef HAVE_CAIRO
#include <dlfcn.h>
#include <string.h>

#define LIBRARY "libcairo.so.2"

bool cairo_load(struct cairo_api *api, const char *library, struct error *error)
{
    static const struct {
        const char *name;
        size_t place;
    } functions[] = {
#define PLACE_OF(name) {"cairo_" #name, offsetof(struct cairo_api, name)},
        CAIRO_FUNCTIONS(PLACE_OF)
#undef PLACE_OF
    };

    *api = (struct cairo_api){0};
    /* It stays in memory: fontconfig and pixman keep caches that only they can find. */
    api->library = dlopen(library, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!api->library) {
        error_set(error, ERROR_COMMAND, "pictures are drawn by cairo, but %s cannot be loaded", library);
        return error_hint(error, "install libcairo2, or write a text figure into a file that ends in .txt");
    }
    for (size_t i = 0; i < COUNT_OF(functions); i++) {
        void *symbol = dlsym(api->library, functions[i].name);
        if (!symbol) {
            cairo_unload(api);
            return error_set(error, ERROR_COMMAND, "%s has no %s: it is too old to draw pictures", library,
                             functions[i].name);
        }
        /* ISO C has no cast from an object pointer to a function pointer: the bytes are copied. */
        memcpy((char *)api + functions[i].place, &symbol, sizeof symbol);
    }
    return true;
}

void cairo_unload(struct cairo_api *api)
{
    if (api->library)
        dlclose(api->library);
    api->library = NULL;
}

bool figure_picture(const struct figure *figure, enum picture kind, double width, double height, struct buffer *out,
                    struct error *error)
{
    struct cairo_api api;
    if (!cairo_load(&api, LIBRARY, error))
        return false;
    bool done = picture_with(&api, figure, kind, width, height, out, error);
    cairo_unload(&api);
    return done;
}
#else
bool figure_picture(const struct figure *figure, enum picture kind, double width, double height, struct buffer *out,
                    struct error *error)
{
    (void)figure, (void)width, (void)height, (void)out;
    error_set(error, ERROR_COMMAND, "this hooke was built without cairo, which draws %s files",
              picture_rows[kind].name);
    return error_hint(error, "install libcairo2-dev and build it again, or write a text figure into a file that ends "
                             "in .txt");
}
#endif
