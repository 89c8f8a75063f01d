/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names, units and numbers of pictures are printed as physics does. */
#include <hooke/base/unit.h>

#include "cmocka_testing.h"

#include "modules/pictures/symbols.h"

#include <string.h>

static void expect(void (*put)(struct buffer *, struct text), const char *from, const char *wanted)
{
    struct buffer out = {0};
    put(&out, text_of(from));
    assert_string_equal(out.data ? out.data : "", wanted);
    buffer_free(&out);
}

TEST(test_numbers)
{
    expect(put_number_symbols, "-2.5", "−2.5");
    expect(put_number_symbols, "1e-6", "10⁻⁶");
    expect(put_number_symbols, "1e12", "10¹²");
    expect(put_number_symbols, "-2.5e-06", "−2.5×10⁻⁶");
    expect(put_number_symbols, "1.0e+00", "1.0×10⁰");
    expect(put_number_symbols, "euler leaves at 5.08 s, up to 1e+308 J",
           "euler leaves at 5.08 s, up to 10³⁰⁸ J");
    expect(put_number_symbols, "3 values <= 0 not shown", "3 values ≤ 0 not shown");
    expect(put_number_symbols, "0.5 +- 0.1", "0.5 ± 0.1");
    expect(put_number_symbols, "symplectic-euler-2 of 2020-01-02",
           "symplectic-euler-2 of 2020-01-02");
    expect(put_number_symbols, "rk4 dt=1e-3 s", "rk4 dt=10⁻³ s");
    expect(put_number_symbols, "1easy 2em", "1easy 2em");
    expect(put_number_symbols, "x -", "x -");
    expect(put_number_symbols, "- 2.2", "− 2.2");
    expect(put_number_symbols, "1e", "1e");
    expect(put_number_symbols, "", "");
}

TEST(test_names)
{
    expect(put_name_symbols, "v/omega0", "v/ω₀");
    expect(put_name_symbols, "theta1, theta2", "θ₁, θ₂");
    expect(put_name_symbols, "dE/E0", "dE/E₀");
    expect(put_name_symbols, "x12", "x₁₂");
    expect(put_name_symbols, "rk4 run2", "rk4 run2");
    expect(put_name_symbols, "growth - 1", "growth − 1");
    expect(put_name_symbols, "x^2*y", "x²·y");
    expect(put_name_symbols, "omega_d, thetas, my_x1", "omega_d, thetas, my_x1");
    expect(put_name_symbols, "größe1 é2", "größe1 é2");
    expect(put_name_symbols, "|error|", "|error|");
}

TEST(test_units)
{
    expect(put_unit_symbols, "cm", "cm");
    expect(put_unit_symbols, "m/s", "m·s⁻¹");
    expect(put_unit_symbols, "m/s^2", "m·s⁻²");
    expect(put_unit_symbols, "N/m^3", "N·m⁻³");
    expect(put_unit_symbols, "1/s", "s⁻¹");
    expect(put_unit_symbols, "kg*m^2", "kg·m²");
    expect(put_unit_symbols, "kg m^2 / s^2", "kg·m²·s⁻²");
    expect(put_unit_symbols, "m s^-2", "m·s⁻²");
    expect(put_unit_symbols, "um", "µm");
    expect(put_unit_symbols, "us", "µs");
    expect(put_unit_symbols, "deg/s", "°·s⁻¹");
    expect(put_unit_symbols, "1/(m s)", "m⁻¹·s⁻¹");
    expect(put_unit_symbols, "%", "%");
    expect(put_unit_symbols, "(", "");
    expect(put_unit_symbols, "", "");
}

/* Every unit of the catalogue gives something that is not longer than a title has room for. */
TEST(test_every_unit)
{
    for (size_t i = 0; i < unit_catalog.count; i++) {
        struct buffer out = {0};
        const char *name = catalog_row(&unit_catalog, i)->name;
        put_unit_symbols(&out, text_of(name));
        assert_true(out.len > 0);
        assert_null(strpbrk(out.data, "/^*"));
        buffer_free(&out);
    }
}

RUN_TESTS(NULL, NULL)
