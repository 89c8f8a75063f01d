/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the numbers line: energy, its error, the number of the run, the keys. Fields have fixed
 * columns, so that a new number changes few cells. */
#include <hooke/run.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include "view/internal.h"

#include <stdio.h>

#define LEAD_CELLS 2 /* Cells of the line before the first field. */
/* [cell] width of the screen from which the long list of keys is shown */
#define KEYS_LONG 110

/* Returns the value of an observable at the present state of a run. */
static double present_value(const struct run *run, const char *name)
{
    const struct row *row = catalog_find(&observable_catalog, text_of(name));
    return run_observable(run, observable_from(row));
}

/* Appends "E=1.741 mJ" with four digits, in the unit that suits the initial energy while both are
 * of similar size, so that the unit does not change all the time. */
static void put_energy(struct buffer *output, const struct run *run, double energy)
{
    double start = system_kinetic(&run->system, run->system.start) +
                   system_potential(&run->system, run->system.start);
    enum quantity quantity = observable_quantity(observable_energy(&run->system), &run->system);
    const struct unit *unit = unit_display(
        quantity,
        fabs(energy) < 100 * fabs(start) && fabs(start) < 100 * fabs(energy) ? start : energy);
    const double factor = unit ? unit->factor : 1;
    buffer_format(output, "%s=%#.4g", run->system.energy ? "E" : "Ekin", energy / factor);
    if (unit)
        buffer_format(output, " %s", unit->row.name);
}

/* Appends "dE/E0=-3.1e-6", the relative error of the energy or, where drag or a drive changes the
 * energy, of its balance. */
static void put_error(struct buffer *output, const struct run *run, double error)
{
    int exponent = error != 0 ? (int)floor(log10(fabs(error))) : 0;
    double mantissa = error / pow(10, exponent);
    if (fabs(mantissa) >= 9.95) {
        mantissa /= 10;
        exponent++;
    }
    buffer_format(output, "%s=%+.1fe%d", run->plan.ledger ? "E bal" : "dE/E0", mantissa, exponent);
}

/* Writes a field with a blank on both sides from column x on, at least `min` wide, if it fits.
 * Returns the column of the next field, or x if it does not fit. */
static int put_field(const struct screen *screen, int x, int y, struct text text, int min,
                     enum style style)
{
    int width = larger(text_width(text), min);
    if (!text.len || x + width + 2 > screen->canvas->width)
        return x;
    for (int i = 0; i < width + 2; i++)
        canvas_put(screen->canvas, x + i, y, ' ', STYLE_PLAIN);
    canvas_text(screen->canvas, x + 1, y, text, style);
    return x + width + 3;
}

/* Writes energy, error and run number as far as they fit. Returns the column after them. */
static int put_numbers(const struct screen *screen, int x, int y)
{
    const struct run *run = session_run(screen->session);
    if (!run)
        return x;
    double energy = run_observable(run, observable_energy(&run->system)),
           error = present_value(run, "energy-error");
    struct buffer full = {0}, brief = {0}, runs = {0};
    if (isfinite(energy)) {
        put_energy(&full, run, energy);
        if (isfinite(error)) {
            put_error(&brief, run, error);
            buffer_format(&full, "  %s", brief.data ? brief.data : "");
        }
    }
    const int width = 25; /* "E=1.741 mJ  dE/E0=-3.1e-6" */
    int next = put_field(screen, x, y, buffer_text(&full), width, STYLE_PLAIN);
    if (next == x)
        next = put_field(screen, x, y, buffer_text(&brief), 0, STYLE_PLAIN);
    buffer_format(&runs, "run %d/%d", run->number,
                  screen->session->runs.slot[screen->session->runs.count - 1]->run->number);
    next = put_field(screen, next, y, buffer_text(&runs), 0, STYLE_PLAIN);
    buffer_free(&full);
    buffer_free(&brief);
    buffer_free(&runs);
    return next;
}

/* Draws the numbers line into row y: `hint` if there is one, else energy, error, run and the keys.
 */
void numbers_draw(const struct screen *screen, struct text hint, int y)
{
    static const char long_keys[] = "F1 help  F5 run/pause  F6 layout  F7 cursors  PgUp log",
                      keys[] = "F1 help  F5 run  F7 cursors";
    int width = screen->canvas->width;
    uint32_t line_glyph;
    if (screen->charset->words)
        line_glyph = ' ';
    else
        line_glyph = screen->charset->plain ? '-' : 0x2500;

    for (int x = 0; x < width; x++)
        canvas_put(screen->canvas, x, y, line_glyph, STYLE_DIM);
    if (hint.len) {
        canvas_put(screen->canvas, LEAD_CELLS, y, ' ', STYLE_PLAIN);
        line_draw(screen, LEAD_CELLS + 1, y, width - LEAD_CELLS - 2, hint, STYLE_PLAIN);
        canvas_put(screen->canvas, smaller(LEAD_CELLS + 1 + text_width(hint), width - 1), y, ' ',
                   STYLE_PLAIN);
        return;
    }
    int x = put_numbers(screen, LEAD_CELLS, y);
    if (screen->session->view.scroll > 0) {
        char text[48];
        const int max = screen_log_max(screen->session, width, screen->canvas->height);
        snprintf(text, sizeof text, "PgDn: %d newer lines",
                 smaller(screen->session->view.scroll, max));
        put_field(screen, x, y, text_of(text), 0, STYLE_BOLD);
    } else {
        put_field(screen, x, y, text_of(width < KEYS_LONG ? keys : long_keys), 0, STYLE_DIM);
    }
}
