/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names, units and numbers as physics prints them, for pictures; text figures remain ASCII. */
#pragma once

#include <hooke/figure/layout.h>

/* Appends a name with symbols: "v/omega0" as v/ω₀, "x1" as x₁, "x^2" as x², with numbers as
 * put_number_symbols() writes them. */
void put_name_symbols(struct buffer *output, struct text name);
/* Appends a text whose numbers and signs become symbols: "-2" as −2, "1e-06" as 10⁻⁶, "2.5e3" as
 * 2.5×10³, "<=" as ≤, "+-" as ±. */
void put_number_symbols(struct buffer *output, struct text text);
/* Appends a unit with symbols: "m/s^2" as m·s⁻², "1/s" as s⁻¹, "um" as µm, "deg" as °. */
void put_unit_symbols(struct buffer *output, struct text unit);
