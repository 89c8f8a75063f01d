/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What `help` alone offers: ways to begin, of the core and of modules, each with lines that can be
 * pasted one after another. */
#include "command/session/topics.h"

#define TOPIC(word, says, explains, lines)                                                         \
    {                                                                                              \
        .row = {word, "", says, "", NULL}, .text = explains, .recipe = lines                       \
    }

static const struct guide_topic topics[] = {
    TOPIC("start", "a first run: scene, values, method, plot, numbers",
          "A session has a scene (what moves), values, a method (how it is integrated) and runs. "
          "NAME = VALUE sets a value, with a unit where it has one; 'show all' lists them, 'list "
          "scenes' what else there is. After 'run' the plot, its numbers and its table are there. "
          "'undo' takes back what was changed.",
          "scene damped; m = 200 g; gamma = 0.2; y0 = 4 cm\n"
          "method rk4 dt=10ms; run 10 s\n"
          "plot position\n"
          "plot velocity; plot phase; plot energy\n"
          "measure period; measure decay\n"
          "print T_d"),
    TOPIC(
        "recording", "a sensor's file: load, cut, clean, period, amplitude, decay",
        "'load FILE' reads what sensors and spreadsheets write (text, csv, xlsx, ods, zip, sound); "
        "t= y= unit= say which column is what where the header does not. 'data' shows, cuts and "
        "cleans it; whatever is measured of runs can be measured of recordings, with an "
        "uncertainty. The first line makes a file to try the others with.",
        "scene damped; method rk4; run 30 s; export swing.csv t,y --force; drop all\n"
        "load swing.csv\n"
        "data window 2:28\n"
        "measure period of swing; measure amplitude of swing\n"
        "fit damped\n"
        "plot position data swing"),
    TOPIC(
        "fit", "k, gamma, the drag of a recording; the run laid over it",
        "'fit damped' finds period, decay and amplitude, 'fit drag' decides between linear, "
        "quadratic and dry friction, 'fit scene free=k,gamma' fits what the scene integrates, "
        "'fit EXPR' any formula. 'adopt' takes the answer into the scene, so that the next run "
        "lies on the "
        "data. k needs the mass: m = 200.0 +- 0.1 g.",
        "scene damped; gamma = 0.1; method rk4; run 30 s; export swing.csv t,y --force; drop all\n"
        "load swing.csv; m = 200.0 +- 0.1 g\n"
        "fit drag\n"
        "adopt; run 30 s\n"
        "plot position --band\n"
        "plot residual"),
    TOPIC("methods", "which method for what: stable steps, stiff scenes, many digits",
          "The lab's: euler (energy grows), backward-euler (dies), symplectic-euler (bounded). For "
          "long conservative runs verlet or pefrl, for a few digits rk4, for many dopri5 or dop853 "
          "with tol=, for stiff scenes radau5 or rodas5p. 'stability' finds the largest dt, 'help "
          "NAME' has formula, order and source, 'list methods' all of them.",
          "stability euler symplectic-euler verlet rk4\n"
          "help verlet\n"
          "scene stiff-vanderpol; method radau5 tol=1e-6; run\n"
          "plot position"),
    TOPIC("compare", "methods side by side: error, energy, run time, order",
          "'compare' runs several methods in the same steps, 'precision' plots error against run "
          "time over many steps and tolerances and says which is fastest for an error, 'order' "
          "measures the order. Their tables are written by 'export FILE table'.",
          "scene damped; duration = 10 s\n"
          "compare euler backward-euler symplectic-euler rk4 dt=10ms\n"
          "plot energy run all\n"
          "precision euler verlet rk4 dopri5\n"
          "order verlet\n"
          "export order.csv table --force"),
    TOPIC(
        "screen", "panes, keys, zoom, cursors; a prompt without panes",
        "'panes' shows plots above the prompt, 'plain' is a prompt alone; over a slow line take "
        "plain. F1 helps on the word at the cursor, F5 runs and pauses, F6 changes the layout, F7 "
        "puts cursors on the plot (arrows, Tab, Enter keeps a measurement, q leaves), PgUp and "
        "PgDn scroll the log. All keys have commands:",
        "run 10 s; layout quad\n"
        "focus energy; range y 0:40mJ\n"
        "zoom 2; pan 1 s\n"
        "window 5 s"),
    TOPIC(
        "equations", "scenes of your own: var, param, x' = ..., force, event",
        "'scene new NAME' begins one; 'var' names what moves with its start, 'param' its "
        "constants, then each law as on paper, of first or second order. 'force EXPR' adds to a "
        "built-in scene, 'observe' names a quantity, 'event' a moment. Every method, fit and study "
        "works on them, and on what 'load scene FILE.ode' makes of files of XPPAUT.",
        "scene new vdp; param mu = 1\n"
        "var x = 2; var y = 0\n"
        "x' = y; y' = mu*(1 - x^2)*y - x\n"
        "method dopri5 tol=1e-9\n"
        "event top when y falling do record\n"
        "run 30 s\n"
        "plot y against x\n"
        "list events"),
    TOPIC("sweep", "resonance curves and maps: a run for each value",
          "NAME=FROM:TO:STEP for one or two parameters; measure= says what is kept of each run: "
          "amplitude, period, max(z), energy ... One parameter draws a curve, two a map.",
          "scene driven; method rk4; duration = 60 s\n"
          "sweep omega=6:12:0.1 measure=amplitude\n"
          "sweep omega=6:12:0.2 gamma=0.1:1:0.1 measure=amplitude\n"
          "export map.csv table --force"),
    TOPIC(
        "output", "tables, pictures, the lab's report, saved sessions, scripts",
        "'plot ... > FILE' writes a picture (.svg .pdf .png) or text, 'export' columns of runs, "
        "recordings, events, measurements and tables of studies, 'report' the folder that the lab "
        "hands in. 'save' writes the commands of the set-up, 'record' all that succeed; 'hooke "
        "FILE.hk' runs them, --format json for programs.",
        "scene damped; method rk4; run 10 s\n"
        "plot position > position.svg --force\n"
        "export run.csv t,y,v,energy --force\n"
        "measure period; export values.csv measurements --force\n"
        "report handin --force\n"
        "save session.hk --force"),
#include "lists/topics.def"
};

const struct catalog guide_catalog = CATALOG("topic", topics);
