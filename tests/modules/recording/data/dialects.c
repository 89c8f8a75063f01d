/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Look-alikes of what instruments and people write: each is loaded and compared, or refused for the
 * right reason. */
#include "modules/recording/data/fixture.h"

#define MOTION "Motion Sensor Data File Sep 20, 2018 1:40 PM"

static const struct {
    const char *text, *options;
    const char *format, *time, *value, *unit;
    size_t rows, dropped;
    int columns, header_lines;
    char separator, decimal;
    double t0, t1, y0, y1; /* [s], SI or as in the file */
    const char *warning;   /* part of one, or NULL */
} good[] = {
    /* The lab's own, in all its variations. */
    {MOTION "\r\nTime (s)\tDistance (cm)\tDist Error "
            "(cm)\r\n0.430\t16.500\t0.239\r\n0.440\t16.509\t0.239\r\n0.450\t16.565\t0.239",
     "", "motion-sensor", "Time", "Distance", "cm", 3, 0, 3, 2, '\t', '.', 0.43, 0.45, 0.165,
     0.16565, NULL},
    {MOTION "\nTime (s)\tVelocity (cm/s)\n0.000\tNaN\n0.017\t55.648\n0.033\t55.162\n0.050\t38.793",
     "", "motion-sensor", "Time", "Velocity", "cm/s", 4, 0, 2, 2, '\t', '.', 0, 0.05, NAN, 0.38793,
     "1 value is missing (first: line 3)"},
    {"0.430\t16.500\t0.239\n0.440\t16.509\t0.239\n0.450\t16.565\t0.239", "", "motion-sensor",
     "Time", "Distance", "cm", 3, 0, 3, 0, '\t', '.', 0.43, 0.45, 0.165, 0.16565,
     "header is missing"},
    {"Time (s)\tDistance (cm)\tDist Error "
     "(cm)\n-0.010\t16.5\t0.239\n0.000\t16.6\t0.239\n0.010\t16.7\t0.239\n",
     "", "motion-sensor", "Time", "Distance", "cm", 3, 0, 3, 1, '\t', '.', -0.01, 0.01, 0.165,
     0.167, NULL},
    /* Line ends. */
    {"t [s],y [m]\r\r\n0,1.5\r\r\n1,2.5\r\r\n2,3.5\r\r\n", "", "table", "t", "y", "m", 3, 0, 2, 1,
     ',', '.', 0, 2, 1.5, 3.5, NULL},
    {"t [s],y [m]\r0,1.5\r1,2.5\r2,3.5\r", "", "table", "t", "y", "m", 3, 0, 2, 1, ',', '.', 0, 2,
     1.5, 3.5, NULL},
    {"t [s],y [m]\n0,1.5\n1,2.5\n2,3.5\r", "", "table", "t", "y", "m", 3, 0, 2, 1, ',', '.', 0, 2,
     1.5, 3.5, NULL},
    /* By index, with and without a separator at the end of rows. */
    {"Sample\tDistance(cm)\n0\t20.5\t\n1\t20.6\t\n2\t20.7\t\n3\t20.8\t\n", "rate=100",
     "motion-index", "Sample", "Distance", "cm", 4, 0, 2, 1, '\t', '.', 0, 0.03, 0.205, 0.208,
     NULL},
    {"Sampleid,Distance\n0,20.5\n1,20.6\n2,20.7\n", "rate=50 unit=cm", "motion-index", "Sampleid",
     "Distance", "cm", 3, 0, 2, 1, ',', '.', 0, 0.04, 0.205, 0.207, NULL},
    {"0\t20.5\n1\t20.6\n2\t20.7\n", "rate=100 unit=cm", "hand-made", "column 1", "column 2", "cm",
     3, 0, 2, 0, '\t', '.', 0, 0.02, 0.205, 0.207, NULL},
    {"Sample,x (m)\n10,1\n11,2\n12,4\n13,8\n14,5\n15,6\n16,7\n17,8\n18,9\n19,1\n20,3\n22,7\n",
     "rate=10", "table", "Sample", "x", "m", 12, 0, 2, 1, ',', '.', 1, 2.2, 1, 7, "1 gap"},
    /* Capstone: byte order mark, semicolons, decimal comma, quotes, run numbers, shorter runs. */
    {"\xEF\xBB\xBF\"Time (s) Run #1\";\"Position (m) Run "
     "#1\"\r\n0,00;0,1720\r\n0,01;0,1840\r\n0,02;0,1950\r\n",
     "", "capstone", "Time Run #1", "Position Run #1", "m", 3, 0, 2, 1, ';', ',', 0, 0.02, 0.172,
     0.195, NULL},
    {"\xEF\xBB\xBF\"Position (mm) Run #1\";\"Position (mm) Run "
     "#2\"\r\n60,5;33,0\r\n58,4;33,5\r\n56,2;34,0\r\n;34,5\r\n;35,0\r\n",
     "rate=100 y=2", "capstone", NULL, "Position Run #2", "mm", 5, 0, 2, 1, ';', ',', 0, 0.04,
     0.033, 0.035, NULL},
    {"\"Time (s) Run #1\",\"Position (m) Run #1\",\"Time (s) Run #2\",\"Position (m) Run "
     "#2\"\n0,1.5,5,2.5\n1,1.6,6,2.6\n2,1.7,7,2.7\n",
     "y=4", "capstone", "Time Run #2", "Position Run #2", "m", 3, 0, 4, 1, ',', '.', 5, 7, 2.5, 2.7,
     NULL},
    /* A single column with a decimal comma is not two columns. */
    {"\"Position (mm) Run #1\"\r\n38,0169\r\n40,4689\r\n42,5546\r\n", "rate=100", "capstone", NULL,
     "Position Run #1", "mm", 3, 0, 1, 1, '\n', ',', 0, 0.02, 0.0380169, 0.0425546, NULL},
    {"38,0169\n40,4689\n42,0546\n44,10\n", "rate=100 unit=mm", "hand-made", NULL, "column 1", "mm",
     4, 0, 1, 0, '\n', ',', 0, 0.03, 0.0380169, 0.0441, NULL},
    /* phyphox: quoted headers, exponents, the axis that moves. */
    {"\"Time (s)\",\"Acceleration x (m/s^2)\",\"Acceleration y (m/s^2)\",\"Acceleration z "
     "(m/s^2)\"\n"
     "2.535E1,3.25E-2,7.16E-1,-9.42E-2\n2.540E1,4.60E-2,-8.83E-1,-1.03E-1\n2.545E1,6.66E-2,1.028E0,"
     "-1.18E-1\n",
     "", "phyphox", "Time", "Acceleration y", "m/s^2", 3, 0, 4, 1, ',', '.', 25.35, 25.45, 0.716,
     1.028, NULL},
    /* Graphical Analysis, in two countries. */
    {"Latest: Time (s),Latest: Position (m)\n0,0.5\n0.05,0.6\n0.10,0.7\n", "", "graphical-analysis",
     "Latest: Time", "Latest: Position", "m", 3, 0, 2, 1, ',', '.', 0, 0.1, 0.5, 0.7, NULL},
    {"Run 1: Time (s);Run 1: Position (m)\n0;0,5\n0,05;0,6\n0,10;0,7\n", "", "graphical-analysis",
     "Run 1: Time", "Run 1: Position", "m", 3, 0, 2, 1, ';', ',', 0, 0.1, 0.5, 0.7, NULL},
    /* Tracker: a track name alone, subscripts, empty cells, no units. */
    {"mass_A\r\nt\tx\ty\r\n0.0\t0.41\t-1.41\r\n0.033\t\t-1.42\r\n0.067\t0.42\t-1.43\r\n0.1\t0.43\t-"
     "1.44\r\n",
     "", "tracker", "t", "x", "", 4, 0, 3, 2, '\t', '.', 0, 0.1, 0.41, 0.43,
     "x: 1 value is missing (first: line 4)"},
    {"t_{1}\tx_{1}\ty_{1}\tamp\n0.0\t0.41\t-1.41\t5.5\n0.033\t0.4\t-1.42\t5\n0.067\t0.42\t-1.43\t4."
     "0\n",
     "", "tracker", "t_{1}", "x_{1}", "", 3, 0, 4, 1, '\t', '.', 0, 0.067, 0.41, 0.42, "no unit"},
    {"mass_A\n0.0\t0.5\n0.1\t0.6\n0.2\t0.7\n", "unit=m", "hand-made", "column 1", "column 2", "m",
     3, 0, 2, 1, '\t', '.', 0, 0.2, 0.5, 0.7, "taken as the time"},
    /* Vernier's text format: names, short names, units. */
    {"Vernier Format 2\nMotion readings\nData "
     "Set\nTime\tTop\nt\td\ns\tcm\n\n0.021\t8.66\n0.041\t9.07\n0.061\t9.45\n#\n# A = "
     "0.0319+/-0.0008\n",
     "", "vernier-text", "Time", "Top", "cm", 3, 0, 2, 7, '\t', '.', 0.021, 0.061, 0.0866, 0.0945,
     NULL},
    /* LabVIEW .lvm: a header closed twice, a Comment column that only the header has, or one full
       of words. */
    {"LabVIEW "
     "Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t1\t\nX0\t0.0E+0\t\nDelta_"
     "X\t0.001\t\n"
     "***End_of_Header***\t\nX_Value\tAcc\tComment\n0.000\t0.5\n0.001\t0.6\n0.002\t0.7\n\n",
     "", "labview", "X_Value", "Acc", "", 3, 0, 2, 9, '\t', '.', 0, 0.002, 0.5, 0.7, NULL},
    {"X_Value\tPos (mm)\tComment\n0.0\t1.8\tLOST\n0.1\t1.5\tOK\n0.2\t1.6\tOK\n", "", "table",
     "X_Value", "Pos", "mm", 3, 0, 3, 1, '\t', '.', 0, 0.2, 0.0018, 0.0016,
     "Comment contains words"},
    {"X_Value\tPos (mm)\tComment\n0.0\t1.8\tLOST\n0.1\t1.5\n0.2\t1.6\n0.3\t1.7\n", "", "table",
     "X_Value", "Pos", "mm", 4, 0, 2, 1, '\t', '.', 0, 0.3, 0.0018, 0.0017,
     "1 row has words after the last column"},
    /* PicoScope: units on a line of their own, a blank line, times before zero. */
    {"Time,Channel A\n(ms),(V)\n\n-20.0,0.5\n-10.0,0.6\n0.0,0.7\n", "", "picoscope", "Time",
     "Channel A", "V", 3, 0, 2, 3, ',', '.', -0.02, 0, 0.5, 0.7, NULL},
    /* Leybold's names; CR CR LF; decimal comma with tabs. */
    {"MIN=0\r\r\nSCALE=1\r\r\nt / s\tWeg / "
     "mm\r\r\n0\t-4,1667E-4\r\r\n0,1\t0,5\r\r\n0,2\t-0,0012\r\r\n",
     "", "table", "t", "Weg", "mm", 3, 0, 2, 3, '\t', ',', 0, 0.2, -4.1667e-7, -1.2e-6, NULL},
    /* By hand: no header, ms and whole numbers, blanks, blanks and tabs mixed, comments anywhere,
       ragged rows. */
    {"0;-68\n0,01;-56\n0,02;-42\n0,03;-30\n", "unit=mm", "hand-made", "column 1", "column 2", "mm",
     4, 0, 2, 0, ';', ',', 0, 0.03, -0.068, -0.03, NULL},
    {"10\t-2040\t-96\r\n32\t-2040\t-128\r\n55\t-1684\t-132\r\n79\t-1436\t-144\r", "tunit=ms",
     "hand-made", "column 1", "column 2", "", 4, 0, 3, 0, '\t', '.', 0.01, 0.079, -2040, -1436,
     NULL},
    {"  time (s)   x (cm)\n   0.0    1.5\n   0.1    2.5\n   0.2    3.5  \n", "", "table", "time",
     "x", "cm", 3, 0, 2, 1, ' ', '.', 0, 0.2, 0.015, 0.035, NULL},
    {"t amplitude xerr\n1.2\t0.274  0.001\n3.6\t0.269 0.001\n6.0 0.263\t0.001\n", "", "table", "t",
     "amplitude", "", 3, 0, 3, 1, ' ', '.', 1.2, 6, 0.274, 0.263, NULL},
    {"# made by hand\n# t [s], y [mm]\n0.0, 1.5\n# a remark\n0.1, 2.5\n\n0.2, 3.5\n", "", "table",
     "t", "y", "mm", 3, 0, 2, 2, ',', '.', 0, 0.2, 0.0015, 0.0035, NULL},
    {"t,y\n0.0,1.5\n0.1\n0.2,2.5\n0.3,3.5\nend of part,one,two\n0.4,4.5\n", "", "tracker", "t", "y",
     "", 4, 2, 2, 1, ',', '.', 0, 0.4, 1.5, 4.5,
     "2 lines dropped that are not 2 numbers (first: line 3, '0.1')"},
    {"t,y\n0.0\n0.1,1.5\n0.2,2.5\n0.3,3.5\n", "", "tracker", "t", "y", "", 3, 1, 2, 1, ',', '.',
     0.1, 0.3, 1.5, 3.5, "(first: line 2, '0.0')"},
    {"t,y\n0.0,1.5\n0.1,oops\n0.2,2.5\n0.3,3.5\n0.4,4.5\n", "", "tracker", "t", "y", "", 5, 0, 2, 1,
     ',', '.', 0, 0.4, 1.5, 4.5,
     "y: 1 cell is not a number and taken as missing (first: line 3, 'oops')"},
    /* At rest in whole numbers for long, then the decimal comma shows. */
    {"t;y\n0;5\n1;5\n2;5\n3;5\n3,5;5,5\n4;6\n", "", "tracker", "t", "y", "", 6, 0, 2, 1, ';', ',',
     0, 4, 5, 6, NULL},
    /* Latin-1 and UTF-8 in headers, and what could steer a terminal. */
    {"Zeit (s);Beschleunigung (m/s\xB2)\n0,0;1,5\n0,1;2,5\n0,2;3,5\n", "", "table", "Zeit",
     "Beschleunigung", "m/s²", 3, 0, 2, 1, ';', ',', 0, 0.2, 1.5, 3.5, NULL},
    {"Zeit [s];Winkel [°]\n0,0;90\n0,1;0\n0,2;180\n", "", "table", "Zeit", "Winkel", "°", 3, 0, 2,
     1, ';', ',', 0, 0.2, 1.5707963267948966, 3.1415926535897931, NULL},
    {"t (s),\x1B[2Jx (cm)\n0,1.5\n1,2.5\n2,3.5\n", "", "table", "t", "\\x1b[2Jx", "cm", 3, 0, 2, 1,
     ',', '.', 0, 2, 0.015, 0.035, NULL},
    /* Quoted numbers, a quoted name that holds the separator, unit in the name, other decimals. */
    {"\"elapsed_ms\",\"x, left (mm)\"\n\"0\",\"+1.5\"\n\"10\",\"2.5\"\n\"20\",\".5\"\n", "",
     "table", "elapsed", "x, left", "mm", 3, 0, 2, 1, ',', '.', 0, 0.02, 0.0015, 0.0005, NULL},
    {"time [us],y [cm/s^2]\n0,100\n500000,200\n1000000,300\n", "", "table", "time", "y", "cm/s^2",
     3, 0, 2, 1, ',', '.', 0, 1, 1, 3, NULL},
    /* What the user says. */
    {"a,b,c\n1,5,9\n2,6,1\n4,7,2\n", "t=c y=B rate=10", "table", "c", "b", "", 2, 1, 3, 1, ',', '.',
     0.1, 0.2, 6, 7, NULL},
    {"t,pressure,dist\n0,5,1.5\n1,6,2.5\n2,7,3.5\n", "y=pres", "table", "t", "pressure", "", 3, 0,
     3, 1, ',', '.', 0, 2, 5, 7, NULL},
    {"0,01;1,5\n0,02;2,5\n0,03;3,5\n", "sep=; decimal=,", "hand-made", "column 1", "column 2", "",
     3, 0, 2, 0, ';', ',', 0.01, 0.03, 1.5, 3.5, NULL},
    {"5,01\n6,02\n7,03\n", "sep=, decimal=.", "hand-made", "column 1", "column 2", "", 3, 0, 2, 0,
     ',', '.', 5, 7, 1, 3, NULL},
    {"5,1\n7,2\n9,3\n", "", "hand-made", "column 1", "column 2", "", 3, 0, 2, 0, ',', '.', 5, 9, 1,
     3, "decimal=comma"},
    {"5,1\n7,2\n9,3\n", "decimal=, rate=1", "hand-made", NULL, "column 1", "", 3, 0, 1, 0, '\n',
     ',', 0, 2, 5.1, 9.3, NULL},
    {"t,y (cm)\n0,1\n1,2\n2,4\n", "unit=mm tunit=ms", "table", "t", "y", "mm", 3, 0, 2, 1, ',', '.',
     0, 0.002, 0.001, 0.004, NULL},
    {"Time (h);y (m)\n0;1\n0,5;2\n1;3\n", "", "table", "Time", "y", "m", 3, 0, 2, 1, ';', ',', 0,
     3600, 1, 3, NULL},
    {"t,y\n0,1\n0,2\n0.5,3\n0.5,4\n1,5\n1,6\n", "", "tracker", "t", "y", "", 3, 3, 2, 1, ',', '.',
     0, 1, 1, 5, "3 rows repeat the previous time"},
    {"Time (s),Dist Error (cm),Dist (cm),Pos (cm)\n0,1,7,1\n1,2,7,2\n2,3,7,4\n", "", "table",
     "Time", "Pos", "cm", 3, 0, 4, 1, ',', '.', 0, 2, 0.01, 0.04, NULL},
    {"t\tx\ty\tfunc\n0\t1\t10\t5\n1\t2\t30\t70\n2\t4\t80\t9\n", "", "tracker", "t", "x", "", 3, 0,
     4, 1, '\t', '.', 0, 2, 1, 4, NULL},
    {"t,y\n0,1\n1,2\n2,3,9\n3,4\n4,5\n", "", "tracker", "t", "y", "", 4, 1, 2, 1, ',', '.', 0, 4, 1,
     5, "'2,3,9'"},
    {"t\ta\tb\tc\n0\t1\t10\t5\n1\t2\t30\t7\n2\t4\t80\t9\n", "", "table", "t", "b", "", 3, 0, 4, 1,
     '\t', '.', 0, 2, 10, 80, NULL},
    {"t [s],az [g]\n0,1.5\n1,2.5\n2,3.5\n", "", "table", "t", "az", "g", 3, 0, 2, 1, ',', '.', 0, 2,
     1.5, 3.5, "'g' of az is unknown"},
    {"t [s],mass [g]\n0,1.5\n1,2.5\n2,3.5\n", "", "table", "t", "mass", "g", 3, 0, 2, 1, ',', '.',
     0, 2, 0.0015, 0.0035, NULL},
    {"t,flat,y\n0,7,1\n1,7,2\n2,7,4\n", "", "table", "t", "y", "", 3, 0, 3, 1, ',', '.', 0, 2, 1, 4,
     NULL},
    {"t,pos\n0,7\n1,7\n2,7\n", "", "table", "t", "pos", "", 3, 0, 2, 1, ',', '.', 0, 2, 7, 7,
     "pos has the same value in every row"},
    {"rise,wave\n0.0,7\n0.5,8\n1.0,7\n1.5,8\n", "", "table", "rise", "wave", "", 4, 0, 2, 1, ',',
     '.', 0, 1.5, 7, 8, "rise increases and is taken as the time"},
    {"t,y\n0,1e999\n1,2\n2,3\n3,inf\n4,4\n", "", "tracker", "t", "y", "", 5, 0, 2, 1, ',', '.', 0,
     4, NAN, 4, "y: 2 values are missing (first: line 2)"},
};

static void same_number(double a, double b, const char *text)
{
    if (!(isnan(a) && isnan(b)) && !near(a, b, 1e-12 * (fabs(b) + 1e-3)))
        fail_msg("%.17g is not %.17g in\n%s", a, b, text);
}

TEST(dialects_are_read)
{
    for (size_t i = 0; i < COUNT_OF(good); i++) {
        struct recording *r = fixture_good(good[i].text, good[i].options);
        const struct column *value = &r->column[r->value];
        if (r->rows != good[i].rows || r->dropped != good[i].dropped ||
            r->columns != good[i].columns || r->header_lines != good[i].header_lines ||
            r->decimal != good[i].decimal || r->separator != good[i].separator)
            fail_msg("rows %zu dropped %zu columns %d header %d decimal %c separator %d in\n%s",
                     r->rows, r->dropped, r->columns, r->header_lines, r->decimal, r->separator,
                     good[i].text);
        assert_string_equal(r->format, good[i].format);
        assert_int_equal(r->time >= 0, good[i].time != NULL);
        if (good[i].time)
            assert_string_equal(r->column[r->time].name, good[i].time);
        assert_string_equal(value->name, good[i].value);
        assert_string_equal(value->unit, good[i].unit);
        assert_int_equal(r->source, !good[i].time                      ? TIME_RATE
                                    : strstr(good[i].options, "rate=") ? TIME_INDEX
                                                                       : TIME_COLUMN);
        same_number(r->t[0], good[i].t0, good[i].text);
        same_number(r->t[r->rows - 1], good[i].t1, good[i].text);
        if (!strstr(good[i].text, "Run #2"))
            same_number(r->y[0], good[i].y0, good[i].text);
        same_number(r->y[r->rows - 1], good[i].y1, good[i].text);
        same_number(r->dt, (good[i].t1 - good[i].t0) / (double)(r->rows - 1), good[i].text);
        if (strcmp(r->column[r->value].unit, "V") == 0 &&
            r->column[r->value].quantity != QUANTITY_VOLTAGE)
            fail_msg("V is no voltage in\n%s", good[i].text);
        if (good[i].warning && !fixture_warns(r, good[i].warning))
            fail_msg("no warning '%s' but %s in\n%s", good[i].warning,
                     r->warnings ? r->warning[r->warnings - 1] : "none", good[i].text);
        recording_destroy(r);
    }
}

static const struct {
    const char *text;
    size_t len; /* 0: up to the NUL */
    const char *options;
    enum error_code code;
    const char *says, *hints;
} bad[] = {
    {"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1 workbook", 0, "", ERROR_IO, "Excel workbook", "CSV"},
    {"\xFF\xFEt\0,\0", 6, "", ERROR_IO, "no table", "sep="},
    {"t,y\n0,1\n1,\0002\n2,3\n", 16, "", ERROR_IO, "NUL byte in line 3, column 3", "CSV"},
    {"", 0, "", ERROR_IO, "is empty", ""},
    {" \n\t\r\n", 0, "", ERROR_IO, "no table", ""},
    {"Dear lab partner,\nI lost the data.\n", 0, "", ERROR_IO, "no table of numbers", "sep="},
    {"t,y\n0,1\n", 0, "", ERROR_IO, "only 1 usable row", ""},
    {"Sample,Distance (cm)\n0,1.5\n1,2.5\n2,3.5\n", 0, "", ERROR_IO,
     "no time column (the file has sample numbers); give the sampling rate", "2 Distance"},
    {"\"Position (mm) Run #1\"\n1,5\n2,5\n3,5\n", 0, "", ERROR_IO, "rate=100", "Position Run #1"},
    {"length period\n1.474 2.421\n1.301 2.284\n1.147 2.148\n", 0, "", ERROR_IO, "no time column",
     "1 length, 2 period"},
    {"Time,Distance\n0,01,5,3\n0,02,5,4\n0,03,5,6\n", 0, "", ERROR_IO,
     "could be separators or decimal marks", "semicolons"},
    {"0,01,5,30\n0,02,5,40\n0,03,5,60\n", 0, "", ERROR_IO, "could be separators or decimal marks",
     "semicolons"},
    {"t,y\n0,1\n1,2\n2,3\n", 0, "y=speed", ERROR_COMMAND, "there is no column 'speed'", "1 t, 2 y"},
    {"t,y\n0,1\n1,2\n2,3\n", 0, "y=3", ERROR_COMMAND, "there is no column '3'", "1 t, 2 y"},
    {"t,pos a,pos b\n0,1,1\n1,2,2\n2,3,3\n", 0, "y=pos", ERROR_COMMAND,
     "more than one column 'pos'", "2 pos a, 3 pos b"},
    {"t,y\n0,1\n1,2\n2,3\n", 0, "y=t", ERROR_COMMAND, "both the time and the value", ""},
    {"t,y (cm)\n0,1\n1,2\n2,3\n", 0, "t=y y=t", ERROR_COMMAND, "which is not a known unit of time",
     "tunit=s"},
    {"time (score),y (cm)\n0,1\n1,2\n2,3\n", 0, "", ERROR_IO, "which is not a known unit of time",
     "tunit=s"},
    {"t,y\n0,1\n1,2\n2,3\n", 0, "tunit=cm", ERROR_COMMAND, "tunit= needs a time", ""},
    {"t,y\n0,1\n1,2\n2,3\n", 0, "tunit=ms rate=10", ERROR_COMMAND, "together with rate=", ""},
    {"t,y\n0,1\n1,2\n2,3\n", 0, "sep=, decimal=,", ERROR_COMMAND, "cannot be both", ""},
    {"t\n0\n1\n2\n", 0, "", ERROR_IO, "no column of values", "1 t"},
};

TEST(others_are_refused)
{
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        struct error error;
        struct recording *r = fixture_load(
            bad[i].text, bad[i].len ? bad[i].len : strlen(bad[i].text), bad[i].options, &error);
        if (r)
            fail_msg("loaded: %s", bad[i].text);
        if (error.code != bad[i].code || !strstr(error.text, bad[i].says) ||
            !strstr(error.hint, bad[i].hints))
            fail_msg("%d '%s' hint '%s' for\n%s", error.code, error.text, error.hint, bad[i].text);
    }
    struct error error = {0};
    assert_null(recording_load(fixture_path("no such file"), NULL, &error));
    assert_int_equal(error.code, ERROR_IO);
}

/* Adding a format is a row: probing goes over the table, so each row must be able to say "not
 * mine". */
TEST(formats_are_rows)
{
    assert_non_null(catalog_find(&format_catalog, TEXT("motion-sensor")));
    assert_non_null(catalog_find(&format_catalog, TEXT("motion-index")));
    assert_non_null(catalog_find(&format_catalog, TEXT("table")));
    for (size_t i = 0; i < format_catalog.count; i++) {
        const struct format *format = format_at(i);
        assert_non_null(format->probe);
        assert_non_null(format->read);
        assert_true(format->row.brief[0] != '\0');
    }
}

TEST(names_come_from_files)
{
    static const struct {
        const char *file, *options, *name;
    } cases[] = {
        {"swing3.txt", "", "swing3"},
        {"position data.txt", "", "position-data"},
        {"a [x] (y).tar.csv", "", "a-x-y-.tar"},
        {"\xC3\xA9t\xC3\xA9.csv", "", "t"},
        {".csv", "", ".csv"},
        {"swing.txt", "as=first", "first"},
    };
    const char text[] = "t,y\n0,1\n1,2\n";
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct error error = {0};
        struct load_options options = fixture_options(cases[i].options);
        struct recording *r =
            recording_load(fixture_file(cases[i].file, text, sizeof text - 1), &options, &error);
        assert_non_null(r);
        assert_string_equal(r->name, cases[i].name);
        recording_destroy(r);
    }
}

RUN_TESTS(fixture_setup, fixture_teardown)
