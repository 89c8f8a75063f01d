/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes images as sixels: colours are reduced to the most frequent ones, then each band of six
 * rows is written colour by colour. */
#include "modules/pixels/sixel.h"

#include <stdlib.h>
#include <string.h>

#define CHANNEL_BITS 4 /* bits of each of red, green and blue by which colours are counted */
#define COLOUR_BINS (1 << 3 * CHANNEL_BITS)

/* Pixels of similar colour. */
struct bin {
    /* number of pixels, and sums of their red, green and blue */
    uint64_t count, sum[3];
    int color; /* index in the palette */
};

/* Colours of an image. */
struct palette {
    struct bin bin[COLOUR_BINS];
    unsigned char color[SIXEL_COLORS][3]; /* [percent] */
    int count;
};

/* Returns the pixel at column x of a row, 0x00RRGGBB. */
static uint32_t pixel_at(const unsigned char *row, int x)
{
    uint32_t word;
    memcpy(&word, row + 4 * (size_t)x, sizeof word);
    return word;
}

/* Returns red, green or blue (i 0, 1, 2) of a pixel. */
static int pixel_channel(uint32_t word, int i)
{
    return (int)(word >> (16 - 8 * i) & 0xff);
}

/* Returns the index of a pixel's bin. */
static size_t pixel_bin(uint32_t word)
{
    size_t bin = 0;
    for (int i = 0; i < 3; i++)
        bin = bin << CHANNEL_BITS | (size_t)pixel_channel(word, i) >> (8 - CHANNEL_BITS);
    return bin;
}

/* Orders bins by their number of pixels, the largest first, then by address, so that the order is
 * always the same. */
static int by_count(const void *a, const void *b)
{
    const struct bin *x = *(struct bin *const *)a, *y = *(struct bin *const *)b;
    if (x->count != y->count)
        return x->count < y->count ? 1 : -1;
    return (x > y) - (x < y);
}

/* Returns the mean of a channel of a bin in percent. */
static unsigned char bin_percent(const struct bin *bin, int i)
{
    const double mean = (double)bin->sum[i] / (double)bin->count;
    return (unsigned char)(mean * 100 / 255 + 0.5);
}

/* Returns the index of the palette's colour that is nearest to the mean colour of a bin. */
static int nearest_color(const struct palette *palette, const struct bin *bin)
{
    int best = 0, least = 1 << 30;
    for (int c = 0; c < palette->count; c++) {
        int distance = 0;
        for (int i = 0; i < 3; i++) {
            const int difference = bin_percent(bin, i) - palette->color[c][i];
            distance += difference * difference;
        }
        if (distance < least) {
            least = distance;
            best = c;
        }
    }
    return best;
}

/* Makes the colours of the bins with the most pixels the palette, at most SIXEL_COLORS, and assigns
 * every bin its nearest colour. Returns false if out of memory. */
static bool choose_palette(struct palette *palette)
{
    struct bin **order = malloc(COLOUR_BINS * sizeof *order);
    int n = 0;
    if (!order)
        return false;
    for (size_t i = 0; i < COLOUR_BINS; i++)
        if (palette->bin[i].count)
            order[n++] = &palette->bin[i];
    qsort(order, (size_t)n, sizeof *order, by_count);
    palette->count = n < SIXEL_COLORS ? n : SIXEL_COLORS;
    for (int c = 0; c < palette->count; c++)
        for (int i = 0; i < 3; i++)
            palette->color[c][i] = bin_percent(order[c], i);
    for (int k = 0; k < n; k++)
        order[k]->color = k < palette->count ? k : nearest_color(palette, order[k]);
    free(order);
    return true;
}

/* Appends `count` columns of the same six pixels, as a repetition if that is shorter. */
static void put_sixels(struct buffer *output, int count, int bits)
{
    if (count > 3)
        buffer_format(output, "!%d%c", count, 63 + bits);
    else
        for (int i = 0; i < count; i++)
            buffer_char(output, (char)(63 + bits));
}

/* Appends a band of up to six rows of pixels, `stride` bytes apart: for each colour in it a line of
 * characters, whose bits tell which rows have that colour. The empty end of a line is left out. */
static void put_band(const struct palette *palette, const unsigned char *pixel, size_t stride,
                     int width, int rows, struct buffer *output)
{
    uint64_t present = 0;
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < width; x++)
            present |= UINT64_C(1)
                       << palette->bin[pixel_bin(pixel_at(pixel + stride * (size_t)y, x))].color;
    for (int c = 0; c < palette->count; c++) {
        if (!(present >> c & 1))
            continue;
        int run = 0, last = 0;
        buffer_format(output, "#%d", c);
        for (int x = 0; x < width; x++) {
            int bits = 0;
            for (int y = 0; y < rows; y++)
                if (palette->bin[pixel_bin(pixel_at(pixel + stride * (size_t)y, x))].color == c)
                    bits |= 1 << y;
            if (run > 0 && bits != last) {
                put_sixels(output, run, last);
                run = 0;
            }
            last = bits;
            run++;
        }
        if (last)
            put_sixels(output, run, last);
        buffer_char(output, '$');
    }
    buffer_char(output, '-');
}

_Static_assert(SIXEL_COLORS <= 64, "a band's colours are the bits of a word");

/* Appends an image of width x height pixels, with rows `stride` bytes apart, as a complete sixel
 * sequence. Returns false if out of memory. */
bool sixel_write(const unsigned char *pixel, size_t stride, int width, int height,
                 struct buffer *output)
{
    struct palette *palette = calloc(1, sizeof *palette);
    for (int y = 0; palette && y < height; y++)
        for (int x = 0; x < width; x++) {
            const uint32_t word = pixel_at(pixel + stride * (size_t)y, x);
            struct bin *bin = &palette->bin[pixel_bin(word)];
            bin->count++;
            for (int i = 0; i < 3; i++)
                bin->sum[i] += (uint64_t)pixel_channel(word, i);
        }
    const bool ok = palette && choose_palette(palette);
    if (ok) {
        buffer_format(output, "\033P0;1q\"1;1;%d;%d", width, height);
        for (int c = 0; c < palette->count; c++)
            buffer_format(output, "#%d;2;%d;%d;%d", c, palette->color[c][0], palette->color[c][1],
                          palette->color[c][2]);
        for (int y = 0; y < height; y += 6)
            put_band(palette, pixel + stride * (size_t)y, stride, width,
                     height - y < 6 ? height - y : 6, output);
        buffer_put(output, TEXT("\033\\"));
    }
    free(palette);
    return ok && !output->failed;
}
