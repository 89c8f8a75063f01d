/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Figures as they look: small drawings compared exactly. */
#include "cmocka_testing.h"

#include <hooke/figure.h>

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

struct samples {
    double x[1000], y[1000];
};

static const char drawn_sine_ascii[] = "+- y [cm] ----------------- -- verlet -+\n"
                                       "|  5+-.          .-_          .-_      |\n"
                                       "|   | '\\        /' '.        /  \\_     |\n"
                                       "|   |  \\_      .'   |       /'   |     |\n"
                                       "|   |   |      |    '|     _/    '.    |\n"
                                       "|  0+   '.    /'     |     |      |    |\n"
                                       "|   |    |   _/       \\   .'      '\\   |\n"
                                       "|   |    '\\  /        '.  /        \\_  |\n"
                                       "| -5+     '-'          '.'          '. |\n"
                                       "|   ++-------+-------+-------+-------+ |\n"
                                       "|   0.0     2.5     5.0     7.5   10.0 |\n"
                                       "+------------------------------ t [s] -+\n";

static const char drawn_sine_braille[] = "┌─ y [cm] ───────────────── -- verlet ─┐\n"
                                         "│  5┤⠢⡀          ⡠⠢⡀          ⡠⠢⡀      │\n"
                                         "│   │ ⠸⡀        ⡸  ⠸⡀        ⡸  ⠸⡀     │\n"
                                         "│   │  ⢱       ⢰⠁   ⢱       ⢰⠁   ⢱     │\n"
                                         "│   │  ⠈⡆      ⡎    ⠈⡆      ⡎    ⠈⡆    │\n"
                                         "│  0┤   ⠸⡀    ⡸      ⠸⡀    ⡸      ⠸⡀   │\n"
                                         "│   │    ⢇   ⢀⠇       ⢇   ⢀⠇       ⢇   │\n"
                                         "│   │    ⠘⡄  ⡜        ⠘⡄  ⡜        ⠘⡄  │\n"
                                         "│ -5┤     ⠈⠢⠊          ⠈⠢⠊          ⠈⠢ │\n"
                                         "│   └┬───────┬───────┬───────┬───────┬ │\n"
                                         "│   0.0     2.5     5.0     7.5   10.0 │\n"
                                         "└────────────────────────────── t [s] ─┘\n";

static const char drawn_sine_block[] = "┌─ y [cm] ───────────────── -- verlet ─┐\n"
                                       "│  5┤▄▖          ▄▄▖          ▄▄▖      │\n"
                                       "│   │ ▝▖        ▞  ▝▖        ▞  ▝▖     │\n"
                                       "│   │  ▚       ▗▘   ▚       ▗▘   ▚     │\n"
                                       "│   │   ▌      ▌     ▌      ▌     ▌    │\n"
                                       "│  0┤   ▐     ▐      ▐     ▐      ▐    │\n"
                                       "│   │    ▚   ▗▘       ▚   ▗▘       ▚   │\n"
                                       "│   │    ▝▖  ▞        ▝▖  ▞        ▝▖  │\n"
                                       "│ -5┤     ▝▀▀          ▝▀▀          ▝▀ │\n"
                                       "│   └┬───────┬───────┬───────┬───────┬ │\n"
                                       "│   0.0     2.5     5.0     7.5   10.0 │\n"
                                       "└────────────────────────────── t [s] ─┘\n";

static const char drawn_overlay_ascii[] = "+- 1 y [cm] -------- -- verlet  # euler  o data -+\n"
                                          "|  10+                                           |\n"
                                          "|    |                ##             ####        |\n"
                                          "|   5+o.            #o.o_#          #_o._#       |\n"
                                          "|    |  o.         #/'  '\\#         o'   o_      |\n"
                                          "|    |   '.       _o     o\\        /'     \\o     |\n"
                                          "|   0+- - o\\- - -_/ - - - -\\o - - o'- - - -'. -  |\n"
                                          "|    |     'o   .o         #\\_  _/#         'o   |\n"
                                          "|  -5+      #'-o'           #'o-o#          ##'o |\n"
                                          "|    |                        ###            ##  |\n"
                                          "| -10+                                         # |\n"
                                          "|    ++---------+----------+---------+---------+ |\n"
                                          "|    0.0       2.5        5.0       7.5     10.0 |\n"
                                          "+---------------------------------------- t [s] -+\n";

static const char drawn_overlay_braille[] = "┌─ 1 y [cm] ──────── -- verlet  # euler  o data ─┐\n"
                                            "│  10┤                                           │\n"
                                            "│    │                ##             #####       │\n"
                                            "│   5┤o⢄            #o⠤o⡀#          ##⡠o⢄##      │\n"
                                            "│    │  o⡀         ⢀⠔⠁  ⠈⢆#         o⠊   o⡄      │\n"
                                            "│    │   ⠱⡀       ⢀o     o⢣        ⡰⠁     ⠘o     │\n"
                                            "│   0┤┈ ┈ o⡄┈ ┈ ┈⢀⠎ ┈ ┈ ┈ ┈⢣o ┈ ┈ o⠁┈ ┈ ┈ ┈⠈⢆ ┈  │\n"
                                            "│    │     ⠘o   ⡠o         #⠱⡀  ⢀⠔⠁         ⠈o   │\n"
                                            "│  -5┤      #⠑o⠊#           #⠈o⠒o#           #⠑o │\n"
                                            "│    │                        ###            ##  │\n"
                                            "│ -10┤                                         # │\n"
                                            "│    └┬─────────┬──────────┬─────────┬─────────┬ │\n"
                                            "│    0.0       2.5        5.0       7.5     10.0 │\n"
                                            "└──────────────────────────────────────── t [s] ─┘\n";

static const char drawn_constant[] = "+- y [cm] ---------------+\n"
                                     "| 5.5+                   |\n"
                                     "|    |                   |\n"
                                     "| 5.0+.................. |\n"
                                     "|    |                   |\n"
                                     "| 4.5+                   |\n"
                                     "|    ++--------+-------+ |\n"
                                     "|     0        2       4 |\n"
                                     "+---------------- t [s] -+\n";

static const char drawn_gap[] = "+- y [cm] ---------------+\n"
                                "| 2.0+    /        \\     |\n"
                                "|    |   /          \\    |\n"
                                "| 1.5+  /            \\   |\n"
                                "|    | /'            '\\  |\n"
                                "| 1.0+-'              '- |\n"
                                "|    ++--------+-------+ |\n"
                                "|     0        2       4 |\n"
                                "+---------------- t [s] -+\n";

static const char drawn_two[] = "+- y [cm] ---------------+\n"
                                "| 2.0+               _.- |\n"
                                "|    |           _.-'    |\n"
                                "| 1.5+       _.-'        |\n"
                                "|    |   _.-'            |\n"
                                "| 1.0+.-'                |\n"
                                "|    ++--------+-------+ |\n"
                                "|    0.0      0.5    1.0 |\n"
                                "+---------------- t [s] -+\n";

static const char drawn_one[] = "+- y [cm] ---------------+\n"
                                "| 1.1+                   |\n"
                                "|    |                   |\n"
                                "| 1.0+         .         |\n"
                                "|    |                   |\n"
                                "| 0.9+                   |\n"
                                "|    ++--------+-------+ |\n"
                                "|    -1        0       1 |\n"
                                "+---------------- t [s] -+\n";

static const char drawn_none[] = "+- y [cm] ---------------+\n"
                                 "| 1.0+                   |\n"
                                 "|    |                   |\n"
                                 "| 0.5+                   |\n"
                                 "|    |                   |\n"
                                 "| 0.0+                   |\n"
                                 "|    ++--------+-------+ |\n"
                                 "|    0.0      0.5    1.0 |\n"
                                 "+---------------- t [s] -+\n";

static const char drawn_phase_braille[] = "┌─ phase v [cm/s] ─────── 2 T ─┐\n"
                                          "│  4┤        ⢀⡠⠤⠤⠢⠤⠤⢄⡀         │\n"
                                          "│   │      ⡠⠊⠁       ⠈⠑⢄       │\n"
                                          "│  2┤    ⢠⠊             ⠑⡄     │\n"
                                          "│   │   ⢠⠃               ⠘⡄    │\n"
                                          "│   │   ⡸                 ⡇    │\n"
                                          "│  0┤   ⢱                 ●    │\n"
                                          "│   │   ⠘⡄               ⢠⠃    │\n"
                                          "│ -2┤    ⠘⢄             ⡠⠃     │\n"
                                          "│   │     ⠈⠒⢄⡀       ⢀⡠⠊       │\n"
                                          "│ -4┤        ⠈⠑⠒⠒⠤⠒⠒⠊⠁         │\n"
                                          "│   └─┬──────────┬──────────┬─ │\n"
                                          "│    -5          0          5  │\n"
                                          "└───────────────────── y [cm] ─┘\n";

static const char drawn_phase_ascii[] = "+- phase v [cm/s] ------- 2 T -+\n"
                                        "|  4+        __..-..__         |\n"
                                        "|   |      .'         '.       |\n"
                                        "|  2+    .'             '.     |\n"
                                        "|   |   .'               '.    |\n"
                                        "|   |   |                 |    |\n"
                                        "|  0+   |                 @    |\n"
                                        "|   |   '.               .'    |\n"
                                        "| -2+    '.             .'     |\n"
                                        "|   |     '-.         .'       |\n"
                                        "| -4+        '---.--''         |\n"
                                        "|   +-+----------+----------+- |\n"
                                        "|    -5          0          5  |\n"
                                        "+--------------------- y [cm] -+\n";

static const char drawn_log[] = "+- error ------------------------- -- rk4 -+\n"
                                "|   1e0+                              _.-  |\n"
                                "|      |                          _.-'     |\n"
                                "|      |                     _.-''         |\n"
                                "|  1e-5+                 _.-'              |\n"
                                "|      |             _.-'                  |\n"
                                "|      |        __.-'                      |\n"
                                "| 1e-10+    _.-'                           |\n"
                                "|      | .-'                               |\n"
                                "|      +-+---------+----------+---------+- |\n"
                                "|      0.001     0.01        0.1        1  |\n"
                                "+- 2 values <= 0 not shown ------- dt [s] -+\n";

static const char drawn_leaving[] = "┌─ y [cm] ──────────── -- verlet  # euler ─┐\n"
                                    "│  5┤⠢⡄         ↑ ⢀⠔⠢⡀ #      #  ⡠⠒⢄  #    │\n"
                                    "│   │ ⠘⡄        #⢠⠃  ⠱⡀#      # ⡜  ⠈⢆ #    │\n"
                                    "│   │  ⠸⡀       ⢀⠇    ⢣#      #⢰⠁   ⠈⡆#    │\n"
                                    "│   │   ⢣       ⡜     ⠈⡆      ⢀⠇     ⠸⡀    │\n"
                                    "│  0┤   ⠈⡆     ⢰⠁      ⠸⡀     ⡜       ⢣    │\n"
                                    "│   │    ⠸⡀   ⢀⠇#      #⢣    ⢰⠁       ⠈⡆   │\n"
                                    "│   │    #⠱⡀  ⡜ #      #⠈⢆  ⢠⠃#       #⠘⡄  │\n"
                                    "│ -5┤     ↓⠑⠤⠊  #      # ⠈⠢⠔⠁ #       # ⠘⠢ │\n"
                                    "│   └┬────────┬────────┬────────┬────────┬ │\n"
                                    "│   0.0      2.5      5.0      7.5    10.0 │\n"
                                    "└─ euler leaves at 1.42 s ───────── t [s] ─┘\n";

static const char drawn_huge[] = "+- y [1e300 m] --------------+\n"
                                 "|  1+              .-_       |\n"
                                 "|   |             /'  '-_    |\n"
                                 "|   |           _/       '._ |\n"
                                 "|  0+'-.       /'          ' |\n"
                                 "|   |   '-_  _/              |\n"
                                 "| -1+      '-'               |\n"
                                 "|   ++------+-------+------+ |\n"
                                 "|    1      2       3      4 |\n"
                                 "+-------------------- t [s] -+\n";

static const char drawn_tiny[] = "+- y [1e-300 m] -------------+\n"
                                 "| 4+              .--.__     |\n"
                                 "|  |           _-'      '-.. |\n"
                                 "|  |        _.'              |\n"
                                 "| 2+   __.-'                 |\n"
                                 "|  |--'                      |\n"
                                 "| 0+                         |\n"
                                 "|  ++-------+------+-------+ |\n"
                                 "|   1       2      3       4 |\n"
                                 "+-------------------- t [s] -+\n";

static const char drawn_shrunk_8[] = "+- y [cm] - -- verlet -+\n"
                                     "|  5+-.    /\\    /-_   |\n"
                                     "|   | \\_  / '\\  .' \\   |\n"
                                     "|  0+  \\ .'  \\_ /  '\\  |\n"
                                     "| -5+  '-/    \\/    '. |\n"
                                     "|   ++-------+-------+ |\n"
                                     "|    0       5      10 |\n"
                                     "+-------------- t [s] -+\n";

static const char drawn_shrunk_5[] = "+- y [cm] - -- verlet -+\n"
                                     "|'\\     .'-_    _-'.   |\n"
                                     "|  \\   /'  '.  _/  '\\  |\n"
                                     "|   '.-'    '-.'     \\_|\n"
                                     "+-------------- t [s] -+\n";

static const char drawn_shrunk_3[] = "'-_     /'-_     .'-.\n"
                                     "  \\_  _/   '.   /'  '\\\n"
                                     "   '..'     '-_/     '-_\n";

static const char drawn_shrunk_narrow[] = "+- y [cm] -+\n"
                                          "|\\  ||  /. |\n"
                                          "| | || .'| |\n"
                                          "| |.' || | |\n"
                                          "| '/  ||  \\|\n"
                                          "|+--------+|\n"
                                          "|0       10|\n"
                                          "+-- t [s] -+\n";

static const char drawn_noted[] = "┌─ y [cm] ───────────────── -- verlet ─┐\n"
                                  "│      5┤⠒⢄        ⡔⠒⠢⡀       ⡠⠒⠒⢄     │\n"
                                  "│       │  ⢣     ⢀⠎   ⠘⡄     ⡰⠁  ⠈⢢    │\n"
                                  "│      0┤   ⠣⡀  ⢀⠎     ⠘⡄   ⡰⠁     ⢣   │\n"
                                  "│     -5┤    ⠑⠤⠤⠊       ⠈⠢⠤⠜        ⠑⠤ │\n"
                                  "│       └┬─────────────┬─────────────┬ │\n"
                                  "│        0             5            10 │\n"
                                  "└─ 14 periods: envelope ─────── t [s] ─┘\n";

static void expect(const struct figure *figure, int width, int height,
                   const struct charset *charset, const char *drawing)
{
    struct buffer out = {0};
    assert_true(figure_print(figure, width, height, charset, false, &out));
    if (strcmp(out.data, drawing) != 0) {
        print_message("drawn:\n%sexpected:\n%s", out.data, drawing);
        fail();
    }
    buffer_free(&out);
}

/* y = 0.05 m cos(2 pi t / 4 s) for 10 s */
static void swing(struct samples *s, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        s->x[i] = 10.0 * (double)i / (double)(n - 1);
        s->y[i] = 0.05 * cos(PI / 2 * s->x[i]);
    }
}

static struct figure of(const struct curve *curve, int curves)
{
    return (struct figure){
        .x = {.label = "t", .unit = "s"},
        .y = {.label = "y", .unit = "cm", .factor = 0.01},
        .curve = curve,
        .curves = curves,
    };
}

TEST(test_sine)
{
    struct samples s;
    struct curve curve = {.label = "verlet", .x = s.x, .y = s.y, .n = 1000};
    struct figure figure = of(&curve, 1);
    (void)state;
    swing(&s, 1000);
    expect(&figure, 40, 12, &charset_ascii, drawn_sine_ascii);
    expect(&figure, 40, 12, &charset_braille, drawn_sine_braille);
    expect(&figure, 40, 12, &charset_block, drawn_sine_block);
}

TEST(test_overlays_have_their_own_marks)
{
    struct samples s, wide, data;
    struct curve curve[] = {
        {.label = "verlet", .x = s.x, .y = s.y, .n = 1000},
        {.label = "euler", .x = wide.x, .y = wide.y, .n = 1000},
        {.label = "data", .x = data.x, .y = data.y, .n = 20, .points = true},
    };
    struct figure figure = of(curve, 3);
    (void)state;
    swing(&s, 1000);
    swing(&wide, 1000);
    swing(&data, 20);
    for (int i = 0; i < 1000; i++)
        wide.y[i] *= 1 + 0.07 * wide.x[i];
    figure.title = "1";
    figure.zero_line = true;
    expect(&figure, 50, 14, &charset_ascii, drawn_overlay_ascii);
    expect(&figure, 50, 14, &charset_braille, drawn_overlay_braille);
}

/* Each point of a cloud is a dot of its own: nothing lies between them. */
TEST(test_clouds)
{
    static const double x[] = {0, 10, 0, 10, 5}, y[] = {0, 1, 1, 0, 0.5};
    const struct curve curve = {
        .label = "section", .x = x, .y = y, .n = 5, .points = true, .cloud = true};
    const struct figure figure = of(&curve, 1);
    (void)state;
    static const struct charset *const charsets[] = {&charset_ascii, &charset_block,
                                                     &charset_braille};
    for (size_t set = 0; set < COUNT_OF(charsets); set++) {
        struct canvas canvas;
        struct figure_layout layout;
        int dots = 0;
        assert_true(canvas_init(&canvas, 60, 20));
        assert_true(figure_draw(&figure, &canvas, 0, 0, 60, 20, charsets[set]));
        figure_layout(&figure, 60, 20, charsets[set], &layout);
        for (int row = 0; row < layout.rows; row++)
            for (int column = 0; column < layout.columns; column++) {
                const struct cell *cell =
                    &canvas.cell[(layout.top + row) * canvas.width + layout.left + column];
                dots += cell->style == STYLE_CURVE_1 && cell->codepoint != ' ';
            }
        assert_int_equal(dots, 5);
        canvas_free(&canvas);
    }
}

TEST(test_constant_and_few_samples)
{
    static const double x[] = {0, 1, 2, 3, 4}, constant[] = {0.05, 0.05, 0.05, 0.05, 0.05};
    static const double gap[] = {0.01, 0.02, NAN, 0.02, 0.01};
    struct curve curve = {.x = x, .y = constant, .n = 5};
    struct figure figure = of(&curve, 1);
    (void)state;
    expect(&figure, 26, 9, &charset_ascii, drawn_constant);
    curve.y = gap;
    expect(&figure, 26, 9, &charset_ascii, drawn_gap);
    curve.n = 2;
    expect(&figure, 26, 9, &charset_ascii, drawn_two);
    curve.n = 1;
    expect(&figure, 26, 9, &charset_ascii, drawn_one);
    curve.n = 0;
    expect(&figure, 26, 9, &charset_ascii, drawn_none);
}

TEST(test_phase)
{
    struct samples s;
    struct curve curve = {.x = s.y, .y = s.x, .n = 1000};
    struct figure figure = of(&curve, 1);
    (void)state;
    for (int i = 0; i < 1000; i++) {
        s.x[i] = 0.04 * cos(2 * PI * i / 999);
        s.y[i] = 0.04 * sin(2 * PI * i / 999);
    }
    figure.title = "phase";
    figure.caption = "2 T";
    figure.x = (struct axis){.label = "y", .unit = "cm", .factor = 0.01};
    figure.y = (struct axis){.label = "v", .unit = "cm/s", .factor = 0.01};
    figure.equal = figure.has_point = true;
    figure.point[0] = 0.04;
    expect(&figure, 32, 14, &charset_braille, drawn_phase_braille);
    expect(&figure, 32, 14, &charset_ascii, drawn_phase_ascii);
}

TEST(test_log_axes)
{
    static const double dt[] = {1e-3, 1e-2, 1e-1, 1, 0}, error[] = {1e-12, 1e-8, 1e-4, 1, 0};
    struct curve curve = {.label = "rk4", .x = dt, .y = error, .n = 5};
    struct figure figure = {
        .x = {.label = "dt", .unit = "s", .log = true},
        .y = {.label = "error", .unit = "", .log = true},
        .curve = &curve,
        .curves = 1,
    };
    (void)state;
    expect(&figure, 44, 12, &charset_ascii, drawn_log);
}

TEST(test_a_curve_that_leaves_is_said_in_the_frame)
{
    struct samples s, wild;
    struct curve curve[] = {
        {.label = "verlet", .x = s.x, .y = s.y, .n = 1000},
        {.label = "euler", .x = wild.x, .y = wild.y, .n = 1000, .panel = 1},
    };
    struct figure figure = of(curve, 2);
    (void)state;
    swing(&s, 1000);
    swing(&wild, 1000);
    for (int i = 0; i < 1000; i++)
        wild.y[i] *= exp(0.3 * wild.x[i] * wild.x[i]);
    expect(&figure, 44, 12, &charset_braille, drawn_leaving);
}

TEST(test_extreme_values)
{
    static const double x[] = {1, 2, 3, 4}, y[] = {1e-300, -1e300, 1e300, 1e-300},
                        small[] = {1e-300, 2e-300, 4e-300, 3e-300};
    struct curve curve = {.x = x, .y = y, .n = 4};
    struct figure figure = {.x = {.label = "t", .unit = "s"},
                            .y = {.label = "y", .unit = "m"},
                            .curve = &curve,
                            .curves = 1};
    (void)state;
    expect(&figure, 30, 10, &charset_ascii, drawn_huge);
    curve.y = small;
    expect(&figure, 30, 10, &charset_ascii, drawn_tiny);
}

/* Tick labels go first, then the frame; a single cell still shows the curve. */
TEST(test_shrinking)
{
    struct samples s;
    struct curve curve = {.label = "verlet", .x = s.x, .y = s.y, .n = 1000};
    struct figure figure = of(&curve, 1);
    (void)state;
    swing(&s, 1000);
    expect(&figure, 24, 8, &charset_ascii, drawn_shrunk_8);
    expect(&figure, 24, 5, &charset_ascii, drawn_shrunk_5);
    expect(&figure, 24, 3, &charset_ascii, drawn_shrunk_3);
    expect(&figure, 12, 8, &charset_ascii, drawn_shrunk_narrow);
    expect(&figure, 1, 1, &charset_ascii, "\\\n");
}

TEST(test_notes_and_gutter)
{
    struct samples s;
    struct curve curve = {.label = "verlet", .x = s.x, .y = s.y, .n = 1000};
    struct figure figure = of(&curve, 1);
    (void)state;
    swing(&s, 1000);
    figure.note = "14 periods: envelope";
    figure.gutter = 6;
    expect(&figure, 40, 8, &charset_braille, drawn_noted);
}

RUN_TESTS(NULL, NULL)
