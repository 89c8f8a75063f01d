/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pictures: what the SVG says, read back, and the files that come of it. */
#include "cmocka_testing.h"

#include "modules/pictures/surface/cairo_api.h"
#include "long_form.h"
#include "modules/pictures/svg_testing.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MANY ((size_t)(is_long() ? 1000000 : 150000))

static struct picture_size {
    double width, height;
} page = {PICTURE_WIDTH, PICTURE_HEIGHT};

/* ---- what an SVG says ---- */

static struct {
    struct svg_element box[400];
    int boxes;
    long lines, fills;
    double lowest, highest; /* of the first curve */
    double bottom, top;     /* of its band, an area of many corners */
} heard;

static void read_picture(const char *svg)
{
    static struct svg_path path;
    struct svg_element element;
    memset(&heard, 0, sizeof heard);
    heard.highest = heard.top = INFINITY;
    for (const char *at = NULL; svg_next(svg, &at, &element, &path);) {
        if (element.is_text) {
            assert_in_range(heard.boxes, 0, COUNT_OF(heard.box) - 1);
            heard.box[heard.boxes++] = element;
            continue;
        }
        heard.fills += element.filled && !element.stroke[0];
        for (int i = 0; i < path.n; i++) {
            assert_true(fabs(path.x[i]) < 1e4 && fabs(path.y[i]) < 1e4);
            if (!path.joined[i])
                continue;
            heard.lines++;
            if (element.filled && !element.stroke[0] && path.n > 200) {
                heard.bottom = fmax(heard.bottom, path.y[i]);
                heard.top = fmin(heard.top, path.y[i]);
            }
            if (strcmp(element.stroke, "#0072b2") != 0)
                continue;
            heard.lowest = fmax(heard.lowest, path.y[i]);
            heard.highest = fmin(heard.highest, path.y[i]);
        }
    }
}

static void draw(const struct figure *figure, enum picture kind, struct buffer *out)
{
    struct error error = {0};
    const size_t before = out->len;
    assert_true(figure_picture(figure, kind, page.width, page.height, out, &error));
    if (kind == PICTURE_SVG)
        read_picture(out->data + before);
}

static bool said(const char *text)
{
    for (int i = 0; i < heard.boxes; i++)
        if (strcmp(heard.box[i].text, text) == 0)
            return true;
    return false;
}

static void expect_said(const char *text)
{
    if (!said(text))
        fail_msg("the picture does not say '%s'", text);
}

static void expect_apart(void)
{
    for (int i = 0; i < heard.boxes; i++) {
        const struct svg_element *a = &heard.box[i];
        if (a->left < 0 || a->right > page.width || a->top < 0 || a->bottom > page.height)
            fail_msg("%g x %g pt: '%s' leaves the page", page.width, page.height, a->text);
        for (int j = 0; j < i; j++) {
            const struct svg_element *b = &heard.box[j];
            if (a->left < b->right && b->left < a->right && a->top < b->bottom &&
                b->top < a->bottom)
                fail_msg("%g x %g pt: '%s' lies on '%s'", page.width, page.height, a->text,
                         b->text);
        }
    }
}

/* ---- files ---- */

/* Every tag is closed in the right order, attributes are quoted. */
static void expect_xml(struct text xml)
{
    char open[64][32];
    int depth = 0, elements = 0;
    for (size_t i = 0; i < xml.len; i++) {
        if (xml.data[i] != '<')
            continue;
        size_t end = ++i;
        for (bool quoted = false; end < xml.len && (quoted || xml.data[end] != '>'); end++) {
            quoted ^= xml.data[end] == '"';
            assert_true(xml.data[end] != '<');
        }
        assert_true(end < xml.len);
        char name[32] = "";
        size_t from = i + (xml.data[i] == '/'), len = 0;
        while (from + len < end && len < sizeof name - 1 && !strchr(" />\n", xml.data[from + len]))
            len++;
        memcpy(name, xml.data + from, len);
        if (xml.data[i] == '/') {
            assert_true(depth > 0);
            assert_string_equal(name, open[--depth]);
        } else if (xml.data[i] != '?' && xml.data[end - 1] != '/') {
            assert_in_range(depth, 0, 63);
            memcpy(open[depth++], name, sizeof name);
        }
        elements++;
        i = end;
    }
    assert_int_equal(depth, 0);
    assert_in_range(elements, 10, 1000000);
}

static bool holds(struct text text, const char *wanted)
{
    return memmem(text.data, text.len, wanted, strlen(wanted)) != NULL;
}

static void expect_svg(const struct buffer *out)
{
    struct text svg = buffer_text(out);
    assert_true(holds(svg, "<svg "));
    assert_true(holds(svg, "width=\"640pt\" height=\"400pt\" viewBox=\"0 0 640 400\""));
    static const char *const strange[] = {"nan", "NaN", "inf", "1e+", "e-3"};
    bool inside = false; /* of a tag */
    for (size_t i = 0; i < svg.len; i++) {
        inside = svg.data[i] == '<' || (inside && svg.data[i] != '>');
        for (size_t s = 0; inside && s < COUNT_OF(strange); s++)
            if (strncmp(svg.data + i, strange[s], strlen(strange[s])) == 0)
                fail_msg("the file holds %s", strange[s]);
    }
    expect_xml(svg);
}

/* ---- figures ---- */

static double *wave(size_t n, double periods, double amplitude)
{
    double *value = malloc((n ? n : 1) * sizeof *value);
    assert_non_null(value);
    for (size_t i = 0; i < n; i++)
        value[i] = amplitude * cos(6.283185307179586 * periods * (double)i / (double)n);
    return value;
}

static double *steps(size_t n, double to)
{
    double *value = malloc((n ? n : 1) * sizeof *value);
    assert_non_null(value);
    for (size_t i = 0; i < n; i++)
        value[i] = to * (double)i / (double)n;
    return value;
}

/* A run, another that grows, and data. */
struct drawing {
    double *x, *y, *grown;
    struct curve curve[3];
    struct figure figure;
};

static void drawing_init(struct drawing *s)
{
    *s = (struct drawing){
        .x = steps(1000, 10), .y = wave(1000, 13, 0.05), .grown = wave(1000, 13, 0.05)};
    for (size_t i = 0; i < 1000; i++)
        s->grown[i] *= exp(0.5 * s->x[i]);
    s->curve[0] = (struct curve){.label = "verlet", .x = s->x, .y = s->y, .n = 1000};
    s->curve[1] = (struct curve){.label = "euler", .x = s->x, .y = s->grown, .n = 1000, .panel = 1};
    s->curve[2] =
        (struct curve){.label = "data <&>\033", .x = s->x, .y = s->y, .n = 100, .points = true};
    s->figure = (struct figure){.title = "position",
                                .x = {.label = "t", .unit = "s"},
                                .y = {.label = "y", .unit = "cm", .factor = 0.01},
                                .curve = s->curve,
                                .curves = 3,
                                .zero_line = true,
                                .has_point = true,
                                .point = {9.99, 0.05},
                                .note = "first 10 of 20 s",
                                .caption = "equal axes"};
}

static void drawing_free(struct drawing *s)
{
    free(s->x);
    free(s->y);
    free(s->grown);
}

static void test_says_what_the_text_figure_says(void **state)
{
    static const char *const texts[] = {"position", "verlet", "euler", "data <&>\\x1b",
                                        "y [cm]",   "t [s]",  "0",     "6",
                                        "−6",       "−2",     "10",    "equal axes"};
    struct drawing s;
    struct buffer out = {0};
    (void)state;
    drawing_init(&s);
    draw(&s.figure, PICTURE_SVG, &out);
    for (size_t i = 0; i < COUNT_OF(texts); i++)
        expect_said(texts[i]);
    bool noted = false;
    for (int i = 0; i < heard.boxes; i++)
        noted |= strncmp(heard.box[i].text, "euler leaves at ", 16) == 0 &&
                 strstr(heard.box[i].text, "of 1000 samples), first 10 of 20 s");
    assert_true(noted);
    expect_apart();
    expect_svg(&out);
    buffer_free(&out);
    drawing_free(&s);
}

static void test_many_names_fit(void **state)
{
    struct drawing s;
    struct curve curve[60];
    char name[60][32];
    struct buffer out = {0};
    (void)state;
    drawing_init(&s);
    for (int i = 0; i < 60; i++) {
        snprintf(name[i], sizeof name[i], "symplectic-euler-%d", i);
        curve[i] = s.curve[0];
        curve[i].label = name[i];
    }
    s.figure.curve = curve;
    s.figure.curves = 60;
    draw(&s.figure, PICTURE_SVG, &out);
    expect_said("symplectic-euler-10");
    assert_false(said("symplectic-euler-59"));
    int shown = 0;
    for (int i = 0; i < 60; i++)
        shown += said(name[i]);
    snprintf(name[0], sizeof name[0], "and %d more", 60 - shown);
    expect_said(name[0]);
    expect_apart();
    expect_svg(&out);
    buffer_free(&out);
    drawing_free(&s);
}

#ifdef HAVE_CAIRO
static void test_png_and_pdf(void **state)
{
    static const uint8_t head[24] = {0x89, 'P', 'N', 'G', '\r', '\n', 26,  '\n',
                                     0,    0,   0,   13,  'I',  'H',  'D', 'R',
                                     0,    0,   5,   0,   0,    0,    0x3, 0x20}; /* 1280 x 800 */
    struct drawing s;
    struct buffer png = {0}, pdf = {0}, again = {0};
    (void)state;
    drawing_init(&s);
    draw(&s.figure, PICTURE_PNG, &png);
    assert_true(png.len > 5000);
    assert_memory_equal(png.data, head, sizeof head);
    assert_memory_equal(png.data + png.len - 8, "IEND", 4);
    draw(&s.figure, PICTURE_PDF, &pdf);
    assert_memory_equal(pdf.data, "%PDF-1.", 7);
    assert_memory_equal(pdf.data + pdf.len - 6, "%%EOF\n", 6);
    assert_true(holds(buffer_text(&pdf), "/MediaBox"));
    draw(&s.figure, PICTURE_PDF, &again); /* no date, nothing of the moment */
    assert_false(holds(buffer_text(&pdf), "CreationDate"));
    assert_int_equal(pdf.len, again.len);
    assert_memory_equal(pdf.data, again.data, pdf.len);
    buffer_free(&png);
    buffer_free(&pdf);
    buffer_free(&again);
    drawing_free(&s);
}

#endif

static size_t picture_size(const double *x, const double *y, bool points, struct axis axis)
{
    struct curve curve = {.label = "a", .x = x, .y = y, .n = MANY, .points = points};
    struct figure figure = {
        .title = "many", .x = axis, .y = {.label = "y"}, .curve = &curve, .curves = 1};
    struct buffer out = {0};
    draw(&figure, PICTURE_SVG, &out);
    size_t size = out.len;
#ifdef HAVE_CAIRO
    buffer_clear(&out);
    draw(&figure, PICTURE_PDF, &out);
    size = out.len > size ? out.len : size;
#endif
    buffer_free(&out);
    return size;
}

static void test_many_samples_stay_small_and_keep_peaks(void **state)
{
    double *t = steps(MANY, 100), *y = wave(MANY, 20000, 1), *v = wave(MANY, 20000.25, 1),
           *noise = steps(MANY, 1);
    struct axis axis = {.label = "t"};
    uint32_t random = 1;
    (void)state;
    for (size_t i = 0; i < MANY; i++) {
        random = random * 1664525 + 1013904223;
        noise[i] = (random >> 8) * 0x1p-24;
        y[i] *= exp(-t[i] / 50);
        v[i] *= exp(-t[i] / 50);
    }
    assert_in_range(picture_size(t, y, false, axis), 3000, 200000);
    assert_in_range(picture_size(v, y, false, axis), 3000,
                    200000); /* a spiral that fills the plot */
    assert_in_range(picture_size(t, noise, false, axis), 3000, 200000);
    assert_in_range(picture_size(t, y, true, axis), 3000, 200000);
    for (size_t i = 0; i < MANY; i++)
        y[i] = 0;
    /* Of a million samples two. */
    struct curve curve = {.x = t, .y = y, .n = MANY};
    struct figure figure = {.x = axis,
                            .y = {.fixed = true, .first_value = -2.2, .last_value = 2.2},
                            .curve = &curve,
                            .curves = 1};
    struct buffer out = {0};
    y[MANY * 2 / 3] = y[MANY / 8] = 1e-3;
    draw(&figure, PICTURE_SVG, &out);
    const double highest = heard.highest, lowest = heard.lowest;
    y[MANY * 2 / 3] = 2.1;
    y[MANY / 8] = -2.1;
    draw(&figure, PICTURE_SVG, &out);
    assert_true(heard.highest < highest - 5 && heard.lowest > lowest + 5);
    curve.points = true;
    draw(&figure, PICTURE_SVG, &out);
    assert_true(heard.highest < highest - 5 && heard.lowest > lowest + 5);
    curve.points = false;
    /* A band that is wide at one sample: both edges have it. */
    for (size_t i = 0; i < MANY; i++)
        y[i] = 0, noise[i] = i == MANY / 2 ? 2.1 : 1e-3;
    curve.spread = noise;
    draw(&figure, PICTURE_SVG, &out);
    assert_true(heard.top < highest - 5 && heard.bottom > lowest + 5);
    curve.spread = NULL;
    figure.x = (struct axis){.fixed = true, .first_value = 200, .last_value = 300};
    draw(&figure, PICTURE_SVG, &out);
    assert_true(isinf(heard.highest));
    buffer_free(&out);
    free(t);
    free(y);
    free(v);
    free(noise);
}

static long lines_of(const double *y, size_t n)
{
    double x[16];
    for (size_t i = 0; i < n; i++)
        x[i] = (double)i;
    struct curve curve = {.label = "a", .x = x, .y = y, .n = n};
    struct figure figure = {.x = {.label = "t", .fixed = true, .first_value = 0, .last_value = 9},
                            .y = {.label = "y", .fixed = true, .first_value = 0, .last_value = 9},
                            .curve = &curve,
                            .curves = 1};
    struct buffer out = {0};
    draw(&figure, PICTURE_SVG, &out);
    expect_svg(&out);
    buffer_free(&out);
    return heard.lines;
}

static void test_gaps_and_lone_samples(void **state)
{
    double y[10] = {1, 3, 2, 5, 3, 7, 4, 8, 5, 6};
    (void)state;
    long none = lines_of(y, 0);
    assert_int_equal(lines_of(y, 10) - none, 9);
    assert_int_equal(lines_of(y, 1) - none, 1); /* a dot */
    y[5] = NAN;
    assert_int_equal(lines_of(y, 10) - none, 7);
    y[7] = INFINITY; /* 6 is alone between 5 and 7 */
    assert_int_equal(lines_of(y, 10) - none, 4 + 1 + 1);
    y[8] = 1e308; /* beyond the frame: what leads there is cut off at it */
    assert_int_equal(lines_of(y, 10) - none, 4 + 1 + 1);
    for (size_t i = 0; i < 10; i++)
        y[i] = NAN;
    assert_int_equal(lines_of(y, 10) - none, 0);
}

static void test_a_growing_run_leaves_with_arrows(void **state)
{
    struct drawing s;
    struct buffer out = {0};
    (void)state;
    drawing_init(&s);
    draw(&s.figure, PICTURE_SVG, &out);
    long arrows = heard.fills;
    assert_true(said("5") && !said("500")); /* it does not set the range */
    s.figure.curves = 1;
    draw(&s.figure, PICTURE_SVG, &out);
    assert_int_equal(arrows - heard.fills, 2); /* up and down */
    buffer_free(&out);
    drawing_free(&s);
}

static void test_any_values(void **state)
{
    static const double strange[] = {0,      1,   -1,       1e300,     -1e300, 1.7e308,
                                     1e-310, NAN, INFINITY, -INFINITY, 1e-5,   3};
    double x[8], y[8];
    uint32_t random = 7;
    (void)state;
    for (int trial = 0; trial < 300; trial++) {
        for (size_t i = 0; i < 8; i++) {
            random = random * 1664525 + 1013904223;
            x[i] = strange[(random >> 8) % COUNT_OF(strange)];
            y[i] = strange[(random >> 16) % COUNT_OF(strange)];
        }
        struct curve curve[2] = {
            {.label = "a", .x = x, .y = y, .n = 8, .panel = trial % 3 == 0},
            {.x = y, .y = x, .n = 8, .points = true, .mark = trial % 2 ? 'q' : '\0'}};
        struct figure figure = {
            .title = trial % 4 ? "any" : NULL,
            .x = {.log = trial % 5 == 0, .unit = "s"},
            .y = {.label = "y", .log = trial % 7 == 0, .factor = trial % 6 ? 0.01 : 0},
            .curve = curve,
            .curves = trial % 3,
            .equal = trial % 2,
            .zero_line = true,
            .has_point = true,
            .point = {x[0], y[0]}};
        struct buffer out = {0};
        draw(&figure, PICTURE_SVG, &out);
        expect_svg(&out);
        buffer_free(&out);
    }
}

static void test_any_size(void **state)
{
    static const double sizes[][2] = {{-1, 3},   {60, 60},   {60, 5000},
                                      {700, 60}, {1e9, NAN}, {90, 140}};
    struct drawing s;
    struct error error = {0};
    (void)state;
    drawing_init(&s);
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        struct buffer out = {0};
        assert_true(figure_picture(&s.figure, PICTURE_SVG, sizes[i][0], sizes[i][1], &out, &error));
        expect_xml(buffer_text(&out));
        buffer_free(&out);
    }
    drawing_free(&s);
}

/* ---- any page ---- */

static double between(uint32_t *random, double from, double to)
{
    *random = *random * 1664525 + 1013904223;
    return from + (to - from) * (*random >> 8) * 0x1p-24;
}

static double chosen_end(uint32_t *random)
{
    const double kind = between(random, 0, 4);
    const double size = pow(10, between(random, kind < 1 ? -12 : -3, kind < 1 ? 12 : 3));
    return between(random, 0, 1) < 0.3 ? -size : size;
}

static void chosen_axis(uint32_t *random, struct axis *axis)
{
    static const char *const units[] = {"s", "m/s^2", "", "kg m/s"};
    static const char *const labels[] = {"y", "v/omega0", "", "a name that is rather long"};
    const double from = chosen_end(random), narrow = between(random, 0, 1);
    *axis = (struct axis){.label = labels[(size_t)between(random, 0, 3.999)],
                          .unit = units[(size_t)between(random, 0, 3.999)],
                          .fixed = true,
                          .first_value = from,
                          .last_value =
                              from + fabs(narrow < 0.3 ? from * pow(10, between(random, -9, 0))
                                                       : chosen_end(random))};
    if (between(random, 0, 1) < 0.25)
        *axis = (struct axis){.label = axis->label,
                              .unit = axis->unit,
                              .fixed = true,
                              .log = true,
                              .first_value = fabs(from),
                              .last_value = fabs(from) * pow(10, between(random, 0.2, 30))};
}

/* Of several pages, pieces of text do not meet and do not leave; ticks are where the axis puts
 * their numbers, which the test of pictures in tests/unit/command reads. */
static void test_texts_are_apart_on_any_page(void **state)
{
    static const struct picture_size sizes[] = {{170, 113}, {227, 170}, {340, 227}, {1134, 850},
                                                {255, 397}, {640, 400}, {340, 113}};
    static const char *const names[] = {"rk4", "symplectic-euler", "a recording of mine (2)"};
    const double x[2] = {0, 1}, y[2] = {0, 1};
    uint32_t random = 5;
    (void)state;
    for (int trial = 0; trial < 700; trial++) {
        struct curve curve[3];
        for (size_t i = 0; i < COUNT_OF(curve); i++)
            curve[i] = (struct curve){.label = names[i], .x = x, .y = y, .n = 2, .panel = i == 1};
        struct axis second[2];
        struct figure figure = {.title = trial % 3 ? "position" : NULL,
                                .curve = curve,
                                .curves = 1 + trial % 3,
                                .grid = true,
                                .caption = trial % 2 ? "equal axes" : NULL,
                                .note = trial % 5 ? NULL : "first 10 of 20 s",
                                .plane = trial % 4 == 1};
        struct buffer out = {0};
        chosen_axis(&random, &figure.x);
        chosen_axis(&random, &figure.y);
        second[0] = figure.x;
        chosen_axis(&random, &second[1]);
        figure.second = trial % 4 == 1 || trial % 4 == 2 ? second : NULL;
        page = sizes[trial % (int)COUNT_OF(sizes)];
        draw(&figure, PICTURE_SVG, &out);
        expect_apart();
        int numbers = 0;
        for (int i = 0; i < heard.boxes; i++)
            numbers +=
                strspn(heard.box[i].text, "0123456789−.⁻⁰¹²³⁴⁵⁶⁷⁸⁹") == strlen(heard.box[i].text);
        if (numbers < 4)
            fail_msg("trial %d, %g x %g pt: %d labels", trial, page.width, page.height, numbers);
        buffer_free(&out);
    }
    page = (struct picture_size){PICTURE_WIDTH, PICTURE_HEIGHT};
}

/* ---- what fails ---- */

#ifdef HAVE_CAIRO

static cairo_status_t no_memory(cairo_t *cairo)
{
    (void)cairo;
    return CAIRO_STATUS_NO_MEMORY;
}

static cairo_status_t no_bytes(cairo_surface_t *surface, cairo_write_func_t write, void *closure)
{
    (void)surface;
    (void)closure;
    assert_non_null(write);
    return CAIRO_STATUS_NO_MEMORY;
}

static void test_without_memory(void **state)
{
    struct drawing s;
    struct error error = {0};
    struct cairo_api api, failing;
    (void)state;
    drawing_init(&s);
    assert_true(cairo_load(&api, "libcairo.so.2", &error));
    for (enum picture kind = PICTURE_PDF; kind <= PICTURE_PNG; kind++) {
        struct buffer out = {0};
        failing = api;
        failing.status = no_memory;
        assert_false(cairo_picture(&failing, &s.figure, kind, 600, 400, &out, &error));
        assert_non_null(strstr(error.text, "memory"));
        buffer_free(&out);
        out = (struct buffer){.failed = true}; /* no room for what cairo writes */
        assert_false(cairo_picture(&api, &s.figure, kind, 600, 400, &out, &error));
        assert_non_null(strstr(error.text, "memory"));
        buffer_free(&out);
    }
    struct buffer out = {0};
    failing = api;
    failing.surface_write_to_png_stream = no_bytes;
    assert_false(cairo_picture(&failing, &s.figure, PICTURE_PNG, 600, 400, &out, &error));
    buffer_free(&out);
    cairo_unload(&api);
    drawing_free(&s);
}

static void test_without_the_library(void **state)
{
    struct cairo_api api;
    struct error error = {0};
    (void)state;
    assert_false(cairo_load(&api, "libno-such-cairo.so.2", &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    assert_non_null(strstr(error.text, "libno-such-cairo.so.2 cannot be loaded"));
    assert_non_null(strstr(error.hint, "install libcairo2"));
    assert_false(cairo_load(&api, "libm.so.6", &error));
    assert_non_null(strstr(error.text, "libm.so.6 has no cairo_"));
    assert_null(api.library.handle);
}

/* Fonts are kept in a way that leak checkers do not see: they are let go. */
static int forget_fonts(void **state)
{
    static const struct {
        const char *library, *function;
    } caches[] = {{"libcairo.so.2", "cairo_debug_reset_static_data"},
                  {"libfontconfig.so.1", "FcFini"}};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(caches); i++) {
        void *library = dlopen(caches[i].library, RTLD_NOW | RTLD_NOLOAD);
        void *symbol = library ? dlsym(library, caches[i].function) : NULL;
        void (*forget)(void);
        memcpy(&forget, &symbol, sizeof forget);
        if (symbol)
            forget();
        if (library)
            dlclose(library);
    }
    return 0;
}

#else
static int forget_fonts(void **state)
{
    (void)state;
    return 0;
}

static void test_built_without_cairo(void **state)
{
    const struct figure figure = {.title = "nothing"};
    struct buffer out = {0};
    struct error error = {0};
    (void)state;
    assert_false(figure_picture(&figure, PICTURE_PDF, 0, 0, &out, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    assert_non_null(strstr(error.text, "without cairo, which is needed for pdf files"));
    assert_non_null(strstr(error.hint, "install libcairo2-dev"));
    assert_int_equal(out.len, 0);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_says_what_the_text_figure_says),
        cmocka_unit_test(test_many_names_fit),
        cmocka_unit_test(test_many_samples_stay_small_and_keep_peaks),
        cmocka_unit_test(test_gaps_and_lone_samples),
        cmocka_unit_test(test_a_growing_run_leaves_with_arrows),
        cmocka_unit_test(test_any_values),
        cmocka_unit_test(test_any_size),
        cmocka_unit_test(test_texts_are_apart_on_any_page),
#ifdef HAVE_CAIRO
        cmocka_unit_test(test_png_and_pdf),
        cmocka_unit_test(test_without_memory),
        cmocka_unit_test(test_without_the_library),
#else
        cmocka_unit_test(test_built_without_cairo),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, forget_fonts);
}
