/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One oscillation as many instruments write it: each file is generated, loaded, and every sample
 * compared with what was written; what cannot be read has to be refused for the true reason. The
 * files are imitations made here.
 */
#include <hooke/base/safe_text.h>
#include "modules/recording/data/fixture.h"

enum clock {
    SECONDS,
    COUNT,
    NONE,
    CLOCK,
    CLOCK_COLON,
    CLOCK_MINUTES,
    CLOCK_NOON,
    ISO,
    ISO_BLANK,
    ISO_Z,
    GERMAN,
    TWO_COLUMNS,
    US,
    EPOCH
};
enum encoding { UTF8, UTF8_MARK, UTF16_LITTLE, UTF16_BIG, LATIN1 };

struct dialect {
    const char *instrument, *head;
    char separator, decimal;
    enum clock clock;
    double per_second; /* what stands in the file for 1 s */
    int t_digits;
    double per_metre; /* … and for 1 m */
    int y_digits;
    const char *prefix, *infix, *suffix, *tail, *options, *refused;
    enum encoding encoding;
    bool crlf, backwards, unitless;
    double t0;         /* [s] of the first sample */
    const char *group; /* between thousands of the times */
};

enum { ROWS = 120 };
#define STEP 0.02
#define PERIOD 0.7

static double place(int i) /* [m] */
{
    return 0.2 + 0.05 * cos(2 * 3.14159265358979323846 * STEP * i / PERIOD);
}

static void put_grouped(struct buffer *out, double x, int digits, char decimal, const char *group)
{
    char text[64];
    snprintf(text, sizeof text, "%.*f", digits, x);
    const size_t whole = strcspn(text, ".");
    for (size_t i = 0; text[i]; i++) {
        if (group && i > 0 && i < whole && (whole - i) % 3 == 0)
            buffer_format(out, "%s", group);
        buffer_char(out, text[i] == '.' ? decimal : text[i]);
    }
}

static void put_number(struct buffer *out, double x, int digits, char decimal)
{
    put_grouped(out, x, digits, decimal, NULL);
}

static void put_time(struct buffer *out, const struct dialect *d, int i)
{
    const double t = d->t0 + STEP * i, day = 45045 + t; /* 12:30:45 */
    const int h = (int)(day / 3600), m = (int)(day / 60) % 60, s = (int)day % 60,
              ms = (int)(day * 1000 + 0.5) - (int)day * 1000;
    switch (d->clock) {
    case SECONDS:
        put_grouped(out, t * d->per_second, d->t_digits, d->decimal, d->group);
        break;
    case COUNT:
        buffer_format(out, "%d", i + (int)d->t0);
        break;
    case NONE:
        return;
    case CLOCK:
        buffer_format(out, "%02d:%02d:%02d.%03d", h, m, s, ms);
        break;
    case CLOCK_COLON:
        buffer_format(out, "%02d:%02d:%02d:%03d", h, m, s, ms);
        break;
    case CLOCK_MINUTES:
        buffer_format(out, "%02d:%02d.%03d", m, s, ms);
        break;
    case CLOCK_NOON:
        buffer_format(out, "%d:%02d:%02d.%03d PM", h, m, s, ms);
        break;
    case ISO:
        buffer_format(out, "2024-01-05T%02d:%02d:%02d.%03d", h, m, s, ms);
        break;
    case ISO_BLANK:
        buffer_format(out, "2024-01-05 %02d:%02d:%02d.%03d", h, m, s, ms);
        break;
    case ISO_Z:
        buffer_format(out, "2024-01-05T%02d:%02d:%02d.%03d+01:00", h, m, s, ms);
        break;
    case GERMAN:
        buffer_format(out, "05.01.2024 %02d:%02d:%02d,%03d", h, m, s, ms);
        break;
    case TWO_COLUMNS:
        buffer_format(out, "2024-01-05%c%02d:%02d:%02d.%03d", d->separator, h, m, s, ms);
        break;
    case US:
        buffer_format(out, "1/5/2024 %02d:%02d:%02d.%03d", h, m, s, ms);
        break;
    case EPOCH:
        put_number(out, 1704457845.0 * d->per_second + t * d->per_second, d->t_digits, d->decimal);
        break;
    }
}

static void put_row(struct buffer *out, const struct dialect *d, int i)
{
    buffer_format(out, "%s", d->prefix ? d->prefix : "");
    put_time(out, d, i);
    if (d->clock != NONE)
        buffer_format(out, "%s", d->infix ? d->infix : (char[]){d->separator, '\0'});
    put_grouped(out, place(i) * d->per_metre, d->y_digits, d->decimal, d->group);
    buffer_format(out, "%s\n", d->suffix ? d->suffix : "");
}

static void write_plain(const struct dialect *d, struct buffer *out)
{
    buffer_format(out, "%s", d->head ? d->head : "");
    for (int i = 0; i < ROWS; i++)
        put_row(out, d, d->backwards ? ROWS - 1 - i : i);
    buffer_format(out, "%s", d->tail ? d->tail : "");
}

static void encode(const struct dialect *d, const struct buffer *plain, struct buffer *out)
{
    struct text rest = buffer_text(plain);
    if (d->encoding == UTF8_MARK)
        buffer_put(out, TEXT("\xEF\xBB\xBF"));
    if (d->encoding == UTF16_LITTLE)
        buffer_put(out, TEXT("\xFF\xFE"));
    if (d->encoding == UTF16_BIG)
        buffer_put(out, TEXT("\xFE\xFF"));
    for (size_t used; rest.len > 0; rest.data += used, rest.len -= used) {
        uint32_t c = text_codepoint(rest, &used);
        if (c == '\n' && d->crlf) {
            if (d->encoding == UTF16_LITTLE)
                buffer_put(out, (struct text){"\r\0", 2});
            else if (d->encoding == UTF16_BIG)
                buffer_put(out, (struct text){"\0\r", 2});
            else
                buffer_char(out, '\r');
        }
        const char low = (char)(c & 0xFF), high = (char)(c >> 8);
        if (d->encoding == UTF16_LITTLE)
            buffer_put(out, (struct text){(char[]){low, high}, 2});
        else if (d->encoding == UTF16_BIG)
            buffer_put(out, (struct text){(char[]){high, low}, 2});
        else if (d->encoding == LATIN1)
            buffer_char(out, low);
        else
            buffer_put(out, (struct text){rest.data, used});
    }
}

#define CM .per_metre = 100, .y_digits = 3
#define M .per_metre = 1, .y_digits = 5
#define MM .per_metre = 1000, .y_digits = 2
#define UM .per_metre = 1e6, .y_digits = 0
#define S .per_second = 1, .t_digits = 3
#define MS .per_second = 1000, .t_digits = 0

static const struct dialect dialects[] = {
    {"MotionSensor.vi",
     "Motion Sensor Data File Sep 20, 2018 1:40 PM\nTime (s)\tDistance (cm)\tDist Error (cm)\n",
     '\t', '.', SECONDS, S, CM, .suffix = "\t0.239", .crlf = true},
    {"PASCO Capstone, US", "\"Time (s) Run #1\",\"Position (m) Run #1\"\n", ',', '.', SECONDS, S, M,
     .encoding = UTF8_MARK, .crlf = true},
    {"PASCO Capstone, Europe", "\"Time (s) Run #1\";\"Position (m) Run #1\"\n", ';', ',', SECONDS,
     S, M, .encoding = UTF8_MARK, .crlf = true},
    {"PASCO SPARKvue", "\"Date and Time\",\"Time (s) Run 1\",\"Position (m) Run 1\"\n", ',', '.',
     SECONDS, S, M, .prefix = "1/5/2024 12:30:45,"},
    {"phyphox, CSV", "\"Time (s)\",\"Distance (cm)\"\n", ',', '.', SECONDS, .per_second = 1,
     .t_digits = 9, CM},
    {"phyphox, decimal comma", "\"Time (s)\";\"Distance (cm)\"\n", ';', ',', SECONDS,
     .per_second = 1, .t_digits = 9, CM},
    {"Vernier Graphical Analysis", "Latest: Time (s),Latest: Position (m)\n", ',', '.', SECONDS, S,
     M},
    {"Vernier Logger Pro, text",
     "Vernier Format 2\nUntitled.cmbl 1/5/2024 12:30:45\nLatest\nTime\tPosition\nt\tx\ns\tm\n\n",
     '\t', '.', SECONDS, S, M},
    {"Tracker", "mass_A\nt\tx\n", '\t', '.', SECONDS, S, CM, .options = "unit=cm"},
    {"LabVIEW measurement",
     "LabVIEW "
     "Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***"
     "End_of_Header***"
     "\t\n\t\nChannels\t1\t\nSamples\t120\t\nX0\t0.0E+0\t\nDelta_X\t0.02\t\nY_Unit_Label\tcm\t\n***"
     "End_of_Header***"
     "\t\nX_Value\tDistance\tComment\n",
     '\t', '.', SECONDS, S, CM},
    {"Leybold CASSY Lab 1", "MIN=0\nMAX=10\nSCALE=1\nDEC=2\nDEF=\"Zeit\" t / s\t\"Weg\" s_A1 / m\n",
     '\t', ',', SECONDS, S, M, .crlf = true},
    {"PicoScope", "Time,Channel A\n(ms),(mV)\n\n", ',', '.', SECONDS, .per_second = 1000,
     .t_digits = 3, MM, .options = "unit=mm", .t0 = -1},
    {"by hand, blanks", "", ' ', '.', SECONDS, S, CM, .options = "unit=cm"},
    {"by hand, semicolons", "t;x\n", ';', ',', SECONDS, S, CM, .options = "unit=cm"},
    {"spreadsheet, ms and mm as names", "ms,mm\n", ',', '.', SECONDS, MS, MM},
    {"spreadsheet, s and cm as names", "s\tcm\n", '\t', '.', SECONDS, S, CM},
    {"pandas with its index", ",time_s,x_cm\n", ',', '.', SECONDS, S, CM, .prefix = "0,"},
    {"numpy savetxt", "# t [s] x [cm]\n", ' ', '.', SECONDS, S, CM},
    {"gnuplot data with % comments", "% a pendulum\n% t [s]  x [cm]\n", ' ', '.', SECONDS, S, CM},
    {"Excel, sep= line", "sep=;\nTime (s);Position (cm)\n", ';', ',', SECONDS, S, CM, .crlf = true},
    {"Excel, Unicode text", "Time (s)\tPosition (cm)\n", '\t', ',', SECONDS, S, CM,
     .encoding = UTF16_LITTLE, .crlf = true},
    {"UTF-16, big end first", "Time (s)\tPosition (cm)\n", '\t', '.', SECONDS, S, CM,
     .encoding = UTF16_BIG},
    {"Latin-1 header", "Zeit (s);Höhe (cm)\n", ';', ',', SECONDS, S, CM, .encoding = LATIN1},
    {"Sensor Logger", "time,seconds_elapsed,distance_m\n", ',', '.', SECONDS, S, M,
     .prefix = "1704457845000000000,"},
    {"Physics Toolbox", "time,x (m)\n", ',', '.', CLOCK_COLON, S, M},
    {"Science Journal", "relative_time,Distance (cm)\n", ',', '.', SECONDS, MS, CM,
     .options = "tunit=ms"},
    {"Arduino serial monitor, time stamps", "", ' ', '.', CLOCK, S, CM, .infix = " -> ",
     .options = "unit=cm"},
    {"Arduino, labelled", "", ' ', '.', SECONDS, MS, CM,
     .prefix = "Time: ", .infix = " ms, Distance: ", .suffix = " cm"},
    {"Arduino serial plotter", "", ',', '.', SECONDS, MS, CM, .prefix = "ms:", .infix = ",cm:"},
    {"key=value", "", ' ', '.', SECONDS, S, CM,
     .prefix = "t=", .infix = " x=", .options = "unit=cm"},
    {"Arduino, chatter before", "Booting HC-SR04 v1.2\nready\nms,cm\n", ',', '.', SECONDS, MS, CM},
    {"data logger, ISO", "Timestamp,Distance (cm)\n", ',', '.', ISO, S, CM},
    {"data logger, ISO with blank", "Timestamp,Distance (cm)\n", ',', '.', ISO_BLANK, S, CM},
    {"data logger, ISO with zone", "Timestamp;Distance (cm)\n", ';', '.', ISO_Z, S, CM},
    {"data logger, German dates", "Zeitstempel;Abstand (cm)\n", ';', ',', GERMAN, S, CM},
    {"data logger, US dates", "Date/Time,Distance (cm)\n", ',', '.', US, S, CM},
    {"data logger, date and time apart", "Date,Time,Distance (cm)\n", ',', '.', TWO_COLUMNS, S, CM},
    {"data logger, blanks, date and time apart", "Date Time cm\n", ' ', '.', TWO_COLUMNS, S, CM},
    {"data logger, clock", "Time,Distance (cm)\n", ',', '.', CLOCK, S, CM},
    {"data logger, clock at midnight", "Time,Distance (cm)\n", ',', '.', CLOCK, S, CM, .t0 = 0},
    {"data logger, minutes and seconds", "Time\tDistance (cm)\n", '\t', '.', CLOCK_MINUTES, S, CM},
    {"data logger, PM", "Time\tDistance (cm)\n", '\t', '.', CLOCK_NOON, S, CM},
    {"epoch in s", "timestamp,distance_cm\n", ',', '.', EPOCH, S, CM},
    {"epoch in ms", "timestamp,distance_cm\n", ',', '.', EPOCH, MS, CM},
    {"NI ELVISmx oscilloscope",
     "waveform,A,B\nt0,05/01/2024 12:30:45.000000,05/01/2024 12:30:45.000000\ndelta "
     "t,2.000000E-2,2.000000E-2\n\ntime,A,B\n",
     ',', '.', ISO_BLANK, S, CM, .suffix = ",0.5", .options = "unit=cm"},
    {"Keysight", "x-axis,1\nsecond,Volt\n", ',', '.', SECONDS, .per_second = 1, .t_digits = 6, CM,
     .options = "unit=cm"},
    {"Siglent",
     "Record Length,Analog:120\nSample Interval,0.02\nVertical Units,V\nSource,CH1\nSecond,Value\n",
     ',', '.', SECONDS, .per_second = 1, .t_digits = 6, CM, .options = "unit=cm"},
    {"Siglent SDS1000X-E",
     "Record Length,Analog:120\nSample Rate,50.0\nVertical Scale,CH1: 0.05\nVertical "
     "Offset,CH1:0.00000\n"
     "Horizontal Scale, 0.200000000\nSecond,Volt\n",
     ',', '.', SECONDS, .per_second = 1, .t_digits = 11, CM, .options = "unit=cm", .t0 = -1},
    {"Hantek, dso-via-scpi", "nr,time,ch1,ch2\n", ',', '.', SECONDS, .per_second = 1, .t_digits = 6,
     CM, .prefix = "3,", .suffix = ",-0.02", .options = "t=2 y=3 unit=cm"},
    {"Rigol DS1000E", "Time,X(CH1)\nSecond,Volt\n", ',', '.', SECONDS, .per_second = 1,
     .t_digits = 6, CM, .suffix = ",", .options = "unit=cm"},
    {"Rigol DS1000Z", "X,CH1,Start,Increment,\nSequence,Volt,-1.000000e+00,2.000000e-02,\n", ',',
     '.', COUNT, S, CM, .suffix = ",,,", .options = "unit=cm"},
    {"Rigol MSO5000", "Time(s),CH1V,t0 =-1.000000e+00,tInc = 2.000000e-02,\n", ',', '.', NONE, S,
     CM, .suffix = ",,,", .options = "unit=cm"},
    {"Digilent WaveForms",
     "#Digilent WaveForms Oscilloscope Acquisition\n#Sample rate: 50Hz\n#Samples: 120\n\nTime "
     "(s),Channel 1 (V)\n",
     ',', '.', SECONDS, .per_second = 1, .t_digits = 6, CM, .options = "unit=cm"},
    {"sigrok-cli",
     "; CSV generated by libsigrok 0.5.2\n; Channels (1/1): A0\n; Samplerate: 50 Hz\n", ',', '.',
     NONE, S, CM, .options = "unit=cm"},
    {"Audacity-like, # rate", "# rate: 50 Hz\n", ',', '.', NONE, S, CM, .options = "unit=cm"},
    {"MATLAB, no header", "", '\t', '.', SECONDS, S, CM, .options = "unit=cm"},
    {"thousands, English", "time_us\tx_mm\n", '\t', '.', SECONDS, .per_second = 1e6, .t_digits = 1,
     MM, .t0 = 2, .group = ","},
    {"thousands, German", "time_us;x_mm\n", ';', ',', SECONDS, .per_second = 1e6, .t_digits = 1, MM,
     .t0 = 2, .group = "."},
    {"thousands, narrow blanks", "time_us;x_mm\n", ';', ',', SECONDS, .per_second = 1e6,
     .t_digits = 1, MM, .t0 = 2, .group = "\xE2\x80\xAF"},
    {"thousands, English, quoted, no decimals", "\"t (ms)\",\"x (um)\"\n", ',', '.', SECONDS, MS,
     UM, .prefix = "\"", .infix = "\",\"", .suffix = "\"", .group = ","},
    {"thousands, German, no decimals", "t (ms);x (\xC2\xB5m)\n", ';', ',', SECONDS, MS, UM,
     .group = "."},
    {"LibreOffice, German, commas and quotes", "\"Zeit (s)\",\"Weg (cm)\"\n", ',', ',', SECONDS, S,
     CM, .prefix = "\"", .infix = "\",\"", .suffix = "\""},
    {"Excel, German words", "Zeit in ms;Weg in cm\n", ';', ',', SECONDS, MS, CM, .crlf = true},
    {"Excel, unit behind a comma", "Zeit, s;Weg, cm\n", ';', ',', SECONDS, S, CM},
    {"R&S HMO, in s", "in s,C1 in V\n", ',', '.', SECONDS, S, CM, .options = "unit=cm"},
    {"quotients, path s", "t/ms\ts/mm\n", '\t', '.', SECONDS, MS, MM},
    {"inches", "t (s),height (in)\n", ',', '.', SECONDS, S, .per_metre = 1 / 0.0254, .y_digits = 4},
    {"micrometres, Latin-1", "t (\xC2\xB5s)\tx (\xC2\xB5m)\n", '\t', '.', SECONDS,
     .per_second = 1e6, .t_digits = 0, UM, .encoding = LATIN1},
    {"units in brackets between blanks", "time  distance\n[s]  [mm]\n", ' ', '.', SECONDS, S, MM},
    {"separator at the end of each row", "t (s);x (cm);\n", ';', '.', SECONDS, S, CM,
     .suffix = ";"},
    {"Fortran", "   t [s]   x [cm]\n", ' ', '.', SECONDS, S, CM, .suffix = "D+00"},
    {"missing values as NA", "t [s],x [cm],note\n", ',', '.', SECONDS, S, CM, .suffix = ",NA"},
    {"a row of dashes", "t [s]   x [cm]\n-----   ------\n", ' ', '.', SECONDS, S, CM},
    {"blank columns before", ",,\n,Time (s),Position (cm)\n", ',', '.', SECONDS, S, CM,
     .prefix = ","},
    {"newest first", "Time (s),Position (cm)\n", ',', '.', SECONDS, S, CM, .backwards = true},
    {"line counter before", "No.,Time (s),Position (cm)\n", ',', '.', SECONDS, S, CM,
     .prefix = "7,"},
    {"trailing remarks", "Time (s),Position (cm)\n", ',', '.', SECONDS, S, CM,
     .tail = "end of measurement\n"},
    {"quoted numbers", "\"Time (s)\",\"Position (cm)\"\n", ',', '.', SECONDS, S, CM, .prefix = "\"",
     .infix = "\",\"", .suffix = "\""},
    {"microseconds", "micros,cm\n", ',', '.', SECONDS, .per_second = 1e6, .t_digits = 0, CM},
    {"index and no time", "Sample\tDistance(cm)\n", '\t', '.', COUNT, S, CM, .options = "rate=50"},
    {"index and no rate", "Sample\tDistance(cm)\n", '\t', '.', COUNT, S, CM, .refused = "rate="},
    {"pipes", "t [s]|x [cm]\n", '|', '.', SECONDS, S, CM, .refused = "no table"},
    {"HTML", "<html><table><tr><td>t</td></tr>\n", ',', '.', SECONDS, S, CM, .prefix = "<tr><td>",
     .infix = "</td><td>", .suffix = "</td></tr>", .refused = "no table"},
    {"RTF", "{\\rtf1\n", '\t', '.', SECONDS, S, CM, .refused = "rich text"},
    {"PDF", "%PDF-1.4\n", '\t', '.', SECONDS, S, CM, .refused = "PDF"},
};

static int failures;

static void complain(const struct dialect *d, const char *what, double got, double wanted)
{
    print_message("%s: %s is %.9g, wanted %.9g\n", d->instrument, what, got, wanted);
    failures++;
}

static void compare(const struct dialect *d, const struct recording *r)
{
    if (r->rows != ROWS) {
        complain(d, "rows", (double)r->rows, ROWS);
        return;
    }
    const double per_second = d->clock == SECONDS || d->clock == EPOCH ? d->per_second : 1000;
    const double t_bound =
        0.51 * pow(10, -(d->clock == SECONDS || d->clock == EPOCH ? d->t_digits : 0)) / per_second +
        3e-7;
    const double scale = d->unitless ? d->per_metre : 1,
                 y_bound = 0.51 * pow(10, -d->y_digits) / d->per_metre * scale + 1e-12;
    for (int i = 0; i < ROWS; i++) {
        if (fabs(r->t[i] - r->t[0] - STEP * i) > 2 * t_bound) {
            complain(d, "a time", r->t[i] - r->t[0], STEP * i);
            return;
        }
        if (!(fabs(r->y[i] - place(i) * scale) <= y_bound)) {
            complain(d, "a value", r->y[i], place(i) * scale);
            return;
        }
    }
}

TEST(every_dialect_is_read_as_it_was_written)
{
    failures = 0;
    for (size_t i = 0; i < COUNT_OF(dialects); i++) {
        const struct dialect *d = &dialects[i];
        struct buffer plain = {0}, bytes = {0};
        struct error error = {0};
        write_plain(d, &plain);
        encode(d, &plain, &bytes);
        const char *path = fixture_file("recording.csv", bytes.data, bytes.len);
        struct load_options options = fixture_options(d->options ? d->options : "");
        struct recording *r = recording_load(path, &options, &error);
        if (d->refused && r) {
            print_message("%s: read, though it should be refused (%s)\n", d->instrument,
                          d->refused);
            failures++;
        } else if (d->refused && !strstr(error.text, d->refused)) {
            print_message("%s: refused with '%s', which does not say '%s'\n", d->instrument,
                          error.text, d->refused);
            failures++;
        } else if (!d->refused && !r) {
            print_message("%s: refused: %s\n", d->instrument, error.text);
            failures++;
        } else if (r) {
            compare(d, r);
        }
        recording_destroy(r);
        buffer_free(&plain);
        buffer_free(&bytes);
    }
    print_message("%zu dialects\n", COUNT_OF(dialects));
    assert_int_equal(failures, 0);
}

RUN_TESTS(fixture_setup, fixture_teardown)
