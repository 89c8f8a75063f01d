/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Lines as they came: the device's clock, or the line through the arrivals, against the truth that
 * made them; broken streams end in counts and a word.
 */
#include "modules/collect/lines.h"
#include "modules/recording/data/fixture.h"
#include "unit/random_testing.h"

#include <hooke/base/numeric.h>

struct stream {
    double rate, from;     /* [Hz] [s] */
    int n, lose_at, lose;  /* lines; so many are lost at one place */
    double jitter, packet; /* [s] */
    double stall;          /* [s] in the middle nothing is heard for so long, then all at once */
    bool wander;           /* a person presses a key */
    double taken[20000];   /* when each that came was taken [s] */
    int came;
    struct buffer file;
};

static double value_at(double t)
{
    return 30 + 5 * cos(8.7 * t);
}

static void make(struct stream *s)
{
    uint64_t seed = 5;
    double t = s->from;
    buffer_format(&s->file, "%s\n%scollect pipe\n", COLLECTED_HEAD, COLLECTED_STATEMENT);
    collected_put(&s->file, 0, TEXT("sensor ready"));
    for (int i = 0; i < s->n; i++) {
        char line[40];
        t = s->wander ? t + 2 * random_fraction(&seed) / s->rate : s->from + i / s->rate;
        double arrival = t + s->jitter * random_fraction(&seed);
        const double middle = s->from + 0.5 * s->n / s->rate;
        if (arrival > middle && arrival < middle + s->stall)
            arrival = middle + s->stall;
        if (s->packet > 0)
            arrival = s->packet * ceil(arrival / s->packet);
        if (s->lose > 0 && i >= s->lose_at && i < s->lose_at + s->lose)
            continue;
        snprintf(line, sizeof line, "%.3f", value_at(t));
        collected_put(&s->file, arrival, text_of(line));
        s->taken[s->came++] = t;
    }
}

static struct recording *taken_from(struct stream *s, const struct load_options *options)
{
    static const struct load_options none;
    struct error error = {0};
    make(s);
    struct recording *r = collected_read(buffer_text(&s->file), options ? options : &none, &error);
    if (!r)
        fail_msg("%s", error.text);
    assert_non_null(r->collected);
    return r;
}

/* The times are true but for one delay common to all, within `tolerance` [s]. */
static void times_are(const struct recording *r, const struct stream *s, double tolerance)
{
    double mean = 0, worst = 0;
    assert_int_equal(r->rows, s->came);
    for (int i = 0; i < s->came; i++)
        mean += (r->t[i] - s->taken[i]) / s->came;
    for (int i = 0; i < s->came; i++)
        worst = fmax(worst, fabs(r->t[i] - s->taken[i] - mean));
    if (worst > tolerance)
        fail_msg("a time is %.3g s wrong, %.3g allowed", worst, tolerance);
}

TEST(arrivals_lie_on_the_line_of_the_device)
{
    static const struct {
        struct stream s;
        double tolerance, uncertainty;
    } cases[] = {
        {{.rate = 100, .from = 1, .n = 1000, .jitter = 0.004}, 1e-3, 5},
        {{.rate = 100, .from = 1, .n = 1000, .jitter = 0.030}, 4e-3, 5},
        {{.rate = 1000, .from = 0.3, .n = 10000, .jitter = 1e-4, .packet = 0.016}, 2e-3, 5},
        {{.rate = 500, .from = 1, .n = 850, .jitter = 4e-4, .stall = 0.08}, 1e-3, 5},
        {{.rate = 20, .from = 0, .n = 200, .jitter = 0.002}, 1e-3, 5},
        {{.rate = 100, .from = 1, .n = 5000, .jitter = 2e-3, .lose_at = 2500, .lose = 1}, 1e-3, 5},
        {{.rate = 100, .from = 1, .n = 5000, .jitter = 2e-3, .lose_at = 1010, .lose = 300},
         1e-3,
         5},
        {{.rate = 1000, .from = 1, .n = 9000, .packet = 0.016, .lose_at = 4000, .lose = 40},
         3e-3,
         5},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct stream *s = malloc(sizeof *s);
        assert_non_null(s);
        *s = cases[i].s;
        struct recording *r = taken_from(s, NULL);
        if (r->collected->clock != CLOCK_ARRIVAL || r->collected->lost != (size_t)s->lose)
            fail_msg("case %zu: clock %d, %zu lost, jitter %g, rate %g", i,
                     (int)r->collected->clock, r->collected->lost, r->collected->jitter,
                     r->collected->rate.value);
        assert_int_equal(r->collected->skipped, 1);
        assert_int_equal(r->collected->garbled, 0);
        times_are(r, s, cases[i].tolerance);
        const struct measured rate = r->collected->rate;
        if (!(fabs(rate.value - s->rate) < cases[i].uncertainty * rate.uncertainty + 1e-9) ||
            !(rate.uncertainty < 0.01 * s->rate))
            fail_msg("case %zu: %.9g +- %.3g Hz of %.9g", i, rate.value, rate.uncertainty, s->rate);
        recording_destroy(r);
        buffer_free(&s->file);
        free(s);
    }
}

TEST(no_line_is_drawn_through_what_is_uneven)
{
    struct stream *s = calloc(1, sizeof *s);
    assert_non_null(s);
    *s = (struct stream){.rate = 10, .from = 1, .n = 600, .wander = true};
    struct recording *r = taken_from(s, NULL);
    assert_int_equal(r->collected->clock, CLOCK_UNEVEN);
    times_are(r, s, 2e-6);
    recording_destroy(r);
    buffer_free(&s->file);
    free(s);
}

static struct recording *of_lines(const char *lines, double step, struct error *error)
{
    static const struct load_options none;
    struct buffer file = {0};
    struct text rest = text_of(lines), line;
    buffer_format(&file, "%s\n", COLLECTED_HEAD);
    for (double t = 0; text_split(&rest, '\n', &line); t += step)
        collected_put(&file, t, line);
    struct recording *r = collected_read(buffer_text(&file), &none, error);
    buffer_free(&file);
    return r;
}

TEST(the_clock_of_the_device_is_taken_where_there_is_one)
{
    static const struct {
        const char *before, *between, *behind;
        double per_second;
        int decimals;
    } cases[] = {{"", ",", "", 1000, 0},       {"", "\t", "", 1e6, 0},
                 {"", ";", "", 1, 3},          {"t=", " y=", "", 1, 3},
                 {"ms:", ",cm:", "", 1000, 0}, {"", " ", "", 1000, 0},
                 {"time:", ",y:", "", 1, 2},   {"Time: ", " ms, y: ", " cm", 1000, 0}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct buffer lines = {0};
        struct error error = {0};
        for (int k = 0; k < 400; k++) {
            buffer_format(&lines, "%s%.*f%s%.3f%s\n", cases[i].before, cases[i].decimals,
                          0.02 * k * cases[i].per_second, cases[i].between, value_at(0.02 * k),
                          cases[i].behind);
        }
        struct recording *r = of_lines(buffer_view(&lines), 0.02003, &error);
        if (!r)
            fail_msg("%s|%s: %s", cases[i].before, cases[i].between, error.text);
        if (r->collected->clock != CLOCK_DEVICE || fabs(r->t[r->rows - 1] - 0.02 * 399) > 1e-9)
            fail_msg("%s|%s: clock %d, the last sample at %.6g s", cases[i].before,
                     cases[i].between, (int)r->collected->clock, r->t[r->rows - 1]);
        assert_int_equal(r->rows, 400);
        recording_destroy(r);
        buffer_free(&lines);
    }
}

/* Every line is a sample, or in one of the counts. */
TEST(what_is_broken_is_counted)
{
    static const struct {
        const char *broken;
        int garbled;
    } cases[] = {{"", 0},
                 {"2\xFF.30", 1},
                 {"\xFF\xFF\xFF\xFF", 1},
                 {"2\x1B[2J", 1},
                 {"nan", 1},
                 {"-", 1},
                 {"21.3 22.4", 1},
                 {"hello", 1},
                 {"21..3", 1},
                 {"\x07 21.3", 1},
                 {"# remark", 0},
                 {"1e999", 1},
                 {"21.3 garb", 1},
                 {"\\x41", 1},
                 {"\xE2\x80\xAE"
                  "21",
                  1},
                 {",", 1},
                 {"0x1.8p", 1},
                 {"\r", 0},
                 {"   ", 0},
                 {"--21", 1},
                 {"21,3,4,5,6", 1},
                 {"\xC3\xA4\xC3", 1}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct buffer lines = {0};
        struct error error = {0};
        for (int k = 0; k < 200; k++) {
            buffer_format(&lines, "%.3f\n", value_at(0.02 * k));
            if (k == 100)
                buffer_format(&lines, "%s\n", cases[i].broken);
        }
        struct recording *r = of_lines(buffer_view(&lines), 0.02, &error);
        if (!r)
            fail_msg("'%s': %s", cases[i].broken, error.text);
        size_t good = 0;
        for (size_t k = 0; k < r->rows; k++)
            good += isfinite(r->y[k]) ? 1 : 0;
        if (good != 200 || r->collected->garbled != (size_t)cases[i].garbled)
            fail_msg("'%s': %zu rows of %zu lines, %zu samples, %zu garbled", cases[i].broken,
                     r->rows, r->collected->lines, good, r->collected->garbled);
        recording_destroy(r);
        buffer_free(&lines);
    }
}

/* ---- streams that are broken ---- */

enum fault {
    NONE,
    RESET,
    RESET_SAYS,
    FULL_16,
    FULL_32,
    FULL_US,
    AHEAD,
    BACK,
    LOSES,
    PAUSES,
    TWICE
};

static const struct broken_stream {
    const char *name, *line;               /* of t [ms] and y [cm] */
    enum { STAMPED, BARE, COUNTED } first; /* y alone; a number in place of t */
    enum fault fault;                      /* at line 150 of 300 */
    const char *also;                      /* a line between those of every tenth */
    int samples, skipped, garbled, repeated, remarks, lost;
    enum collected_clock clock;
} broken_streams[] = {
    {.name = "tabs", .line = "%.0f\t%.3f", .samples = 300},
    {.name = "exponents", .line = "%.6E,%.6e", .samples = 300},
    {.name = "key=value", .line = "t=%.0f y=%.3f", .samples = 300},
    {.name = "JSON", .line = "{\"t\":%.0f,\"y\":%.3f}", .samples = 300},
    {.name = "JSON that is cut",
     .line = "{\"t\":%.0f,\"y\":%.3f}",
     .also = "{\"t\":77,\"y\":",
     .samples = 300,
     .garbled = 30},
    {.name = "a missing key",
     .line = "t=%.0f y=%.3f",
     .also = "t=7",
     .samples = 300,
     .garbled = 30},
    {.name = "quotes", .line = "\"%.0f\",\"%.3f\"", .samples = 300},
    {.name = "a comma at the end", .line = "%.0f,%.3f,", .samples = 300},
    {.name = "blanks before", .line = "   %.0f,%.3f", .samples = 300},
    {.name = "one column", .line = "%.3f", .first = BARE, .samples = 300, .clock = CLOCK_ARRIVAL},
    {.name = "an escape",
     .line = "%.0f,%.3f",
     .also = "\x1B[31m7,8",
     .samples = 300,
     .garbled = 30},
    {.name = "a title", .line = "%.0f,%.3f", .also = "\x1B]0;x\x07", .samples = 300, .garbled = 30},
    {.name = "XON", .line = "%.0f,%.3f", .also = "\x11", .samples = 300, .garbled = 30},
    {.name = "a column more", .line = "%.0f,%.3f", .also = "7,8,9", .samples = 300, .garbled = 30},
    {.name = "a column less",
     .line = "%.0f,%.3f,1.5",
     .also = "7,8",
     .samples = 300,
     .garbled = 30},
    {.name = "words", .line = "%.0f,%.3f", .also = "boot", .samples = 300, .garbled = 30},
    {.name = "remarks", .line = "%.0f,%.3f", .also = "# ok", .samples = 300, .remarks = 30},
    {.name = "blank lines", .line = "%.0f,%.3f", .also = "  ", .samples = 300},
    {.name = "units", .line = "%.0f,%.3f", .also = "7 ms,8 cm", .samples = 300, .garbled = 30},
    {.name = "hexadecimal", .line = "%.0f,%.3f", .also = "0x7,0x8", .samples = 300, .garbled = 30},
    {.name = "noise", .line = "%.0f,%.3f", .also = "\xFF\xFE\xFF", .samples = 300, .garbled = 30},
    {.name = "a reset", .line = "%.0f,%.3f", .fault = RESET, .samples = 300},
    {.name = "a reset, told",
     .line = "%.0f,%.3f",
     .fault = RESET_SAYS,
     .samples = 300,
     .garbled = 2},
    {.name = "16 bit are full", .line = "%.0f,%.3f", .fault = FULL_16, .samples = 300},
    {.name = "32 bit are full", .line = "%.0f,%.3f", .fault = FULL_32, .samples = 300},
    {.name = "32 bit of us", .line = "%.3f,%.3f", .fault = FULL_US, .samples = 300},
    {.name = "a stamp ahead", .line = "%.0f,%.3f", .fault = AHEAD, .samples = 299, .garbled = 1},
    {.name = "a stamp behind", .line = "%.0f,%.3f", .fault = BACK, .samples = 299, .garbled = 1},
    {.name = "lost lines", .line = "%.0f,%.3f", .fault = LOSES, .samples = 297, .lost = 3},
    {.name = "lost lines, no clock",
     .line = "%.3f",
     .first = BARE,
     .fault = LOSES,
     .samples = 297,
     .lost = 3,
     .clock = CLOCK_ARRIVAL},
    {.name = "lost lines, counted",
     .line = "%d,%.3f",
     .first = COUNTED,
     .fault = LOSES,
     .samples = 297,
     .lost = 3,
     .clock = CLOCK_ARRIVAL},
    {.name = "a pause", .line = "%.0f,%.3f", .fault = PAUSES, .samples = 297},
    {"a pause, no clock", "%.3f", BARE, PAUSES, NULL, 297, 0, 0, 0, 0, 0, CLOCK_ARRIVAL},
    {"a pause, counted", "%d,%.3f", COUNTED, PAUSES, NULL, 297, 0, 0, 0, 0, 0, CLOCK_ARRIVAL},
    {.name = "a line twice", .line = "%.0f,%.3f", .fault = TWICE, .samples = 300, .repeated = 1},
};

static double stamp_of(enum fault fault, int k)
{
    const double t = 20 * k;
    switch (fault) {
    case RESET:
    case RESET_SAYS:
        return k < 150 ? t + 740 : t - 3000;
    case FULL_16:
        return fmod(65536 - 3000 + t, 65536);
    case FULL_32:
        return fmod(4294967296.0 - 3000 + t, 4294967296.0);
    case FULL_US:
        return fmod(4294967.296 - 3000 + t, 4294967.296);
    case AHEAD:
        return k == 150 ? 20000000 : t;
    case BACK:
        return k == 150 ? 77 : t;
    default:
        return t;
    }
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
static void put_stream(const struct broken_stream *s, struct buffer *file)
{
    char line[100];
    buffer_format(file, "%s\n", COLLECTED_HEAD);
    for (int k = 0; k < 300; k++) {
        const double at = 0.02 * k + 1e-4 * (k * 7 % 5);
        if ((s->fault == LOSES || s->fault == PAUSES) && k >= 150 && k < 153)
            continue;
        if (s->fault == PAUSES && k == 153)
            buffer_put(file, TEXT(COLLECTED_PAUSE "\n"));
        if (s->fault == RESET_SAYS && k == 150) {
            collected_put(file, at - 0.02, TEXT("sensor ready"));
            collected_put(file, at - 0.01, TEXT("time,distance"));
        }
        const double y = value_at(0.02 * k);
        if (s->first == STAMPED)
            snprintf(line, sizeof line, s->line, stamp_of(s->fault, k), y);
        else if (s->first == COUNTED)
            snprintf(line, sizeof line, s->line, k, y);
        else
            snprintf(line, sizeof line, s->line, y);
        collected_put(file, at, text_of(line));
        if (s->fault == TWICE && k == 150)
            collected_put(file, at, text_of(line));
        if (s->also && k % 10 == 9)
            collected_put(file, at, text_of(s->also));
    }
}
#pragma GCC diagnostic pop

/* Each line is a sample or in one of the counts; times go on where the device's clock does not. */
TEST(every_line_is_in_one_of_the_counts)
{
    static const struct load_options none;
    for (size_t i = 0; i < COUNT_OF(broken_streams); i++) {
        const struct broken_stream *s = &broken_streams[i];
        struct buffer file = {0};
        struct error error = {0};
        put_stream(s, &file);
        struct recording *r = collected_read(buffer_text(&file), &none, &error);
        if (!r)
            fail_msg("%s: %s", s->name, error.text);
        const struct collected *c = r->collected;
        const size_t sum = c->samples + c->skipped + c->garbled + c->repeated + c->remarks;
        if (c->lines != sum || (int)c->samples != s->samples || (int)c->skipped != s->skipped ||
            (int)c->garbled != s->garbled || (int)c->repeated != s->repeated ||
            (int)c->remarks != s->remarks || (int)c->lost != s->lost || !c->lost_known)
            fail_msg("%s: %zu lines, %zu samples, %zu skipped, %zu garbled, %zu repeated, %zu "
                     "remarks, %zu lost",
                     s->name, c->lines, c->samples, c->skipped, c->garbled, c->repeated, c->remarks,
                     c->lost);
        if (c->clock != s->clock)
            fail_msg("%s: clock %d", s->name, (int)c->clock);
        for (size_t k = 0; k < r->rows; k++) /* within the jitter of the arrivals after a reset */
            if (fabs(r->t[k] - r->t[0] - 0.02 * (r->line[k] - r->line[0])) > 1e-3 && !s->also &&
                s->fault != LOSES && s->fault != PAUSES && s->fault != TWICE &&
                s->fault != RESET_SAYS)
                fail_msg("%s: sample %zu at %.6g s", s->name, k, r->t[k] - r->t[0]);
        if (!(fabs(r->t[r->rows - 1] - r->t[0] - 0.02 * 299) < 2e-3))
            fail_msg("%s: %.6g s of 5.98 s", s->name, r->t[r->rows - 1] - r->t[0]);
        recording_destroy(r);
        buffer_free(&file);
    }
}

/* Each number is in the unit that stands behind it. */
TEST(units_in_the_lines_are_converted)
{
    struct error error = {0};
    struct recording *r = of_lines("t: 0 ms, y: 1 cm\nt: 20 ms, y: 25 mm\nt: 40 ms, y: 4 V\n"
                                   "t: 0.06 s, y: 1 cm\nt: 80 ms, y: 5\nt: 100 ms, y: 2 cm\n",
                                   0.02, &error);
    static const double wanted[] = {0.01, 0.025, NAN, 0.01, 0.05, 0.02};
    if (!r)
        fail_msg("%s", error.text);
    assert_int_equal(r->rows, 6);
    for (size_t i = 0; i < 6; i++)
        if (isnan(wanted[i]) ? !isnan(r->y[i]) : !(fabs(r->y[i] - wanted[i]) < 1e-15))
            fail_msg("row %zu: %g", i, r->y[i]);
    assert_true(fabs(r->t[3] - 0.06) < 1e-15);
    recording_destroy(r);
    r = of_lines("A1: 0.0 mV DC\nA1: 3.0 V DC\nA1: 500.0 mV DC\nA1: -1.0 V DC\n", 0.02, &error);
    assert_non_null(r);
    assert_int_equal(r->rows, 4);
    assert_true(fabs(r->y[1] - 3) < 1e-12 && fabs(r->y[2] - 0.5) < 1e-12);
    recording_destroy(r);
}

/* The number of lost lines is known only if the times or a stated rate tell it. `known` and `lost`
 * are the expected report for lines that arrive in packets, with wandering or jittering times, or
 * too few to tell; lines were lost where .lose is set. */
TEST(lost_lines_are_said_not_to_be_known)
{
    static const struct load_options none, paced = {.rate = 100};
    static const struct {
        struct stream s;
        const struct load_options *options;
        bool known;
        size_t lost;
    } cases[] = {
        {{.rate = 1000, .from = 1, .n = 9000, .packet = 0.016, .lose_at = 4000, .lose = 1},
         &none,
         false,
         0},
        {{.rate = 10, .from = 1, .n = 600, .wander = true}, &none, false, 0},
        {{.rate = 20, .from = 1, .n = 60, .jitter = 1e-3, .lose_at = 31, .lose = 1},
         &none,
         true,
         1},
        {{.rate = 20, .from = 1, .n = 9}, &none, false, 0},
        {{.rate = 100.02, .from = 1, .n = 900, .jitter = 1e-3, .lose_at = 400, .lose = 7},
         &paced,
         true,
         7},
        {{.rate = 50, .from = 1, .n = 900, .jitter = 1e-3}, &paced, false, 0},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct stream *s = malloc(sizeof *s);
        assert_non_null(s);
        *s = cases[i].s;
        struct recording *r = taken_from(s, cases[i].options);
        if (r->collected->lost_known != cases[i].known || r->collected->lost != cases[i].lost)
            fail_msg("case %zu: %zu lost, %s", i, r->collected->lost,
                     r->collected->lost_known ? "known" : "not known");
        if (cases[i].options == &paced && cases[i].known)
            assert_true(fabs(r->t[r->rows - 1] - r->t[0] - 0.01 * 899) < 1e-9);
        recording_destroy(r);
        buffer_free(&s->file);
        free(s);
    }
}

TEST(a_line_without_end_is_cut)
{
    struct buffer file = {0};
    static char line[1000000];
    memset(line, '1', sizeof line);
    collected_put(&file, 0, (struct text){line, sizeof line});
    assert_true(file.len < COLLECTED_LINE + 40 && strstr(file.data, "\\...\n"));
    buffer_free(&file);
}

RUN_TESTS(fixture_setup, fixture_teardown)
