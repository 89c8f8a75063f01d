/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes the set-up as commands: only differences from a new session, with numbers that read back
 * to the same doubles. */
#include <hooke/method.h>
#include <hooke/base/file.h>
#include <hooke/data.h>
#include <hooke/result.h>
#include <hooke/base/number.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Writes the command that chooses the preset, or begins a typed scene (new), and its lines. */
void scene_kind_script(const struct scene *scene, struct buffer *text)
{
    buffer_format(text, "scene %s%s\n", typed_base(scene->model) ? "" : "new ",
                  scene->preset->row.name);
    scene_script(scene, "\n", text);
}

/* Writes the scene with its lines, chosen parameters and absolute tolerances. The command `scene`
 * is left out for the first preset, which is the default, unless always is set. */
static void save_scene(const struct scene *scene, bool always, struct buffer *text)
{
    const struct row *first = catalog_row(&preset_catalog, 0);
    if (always || &scene->preset->row != first)
        scene_kind_script(scene, text);
    else
        scene_script(scene, "\n", text);
    for (size_t i = 0; i < scene_params(scene)->count; i++) {
        const struct param_row *param = param_at(scene, (int)i);
        if (!scene->chosen[i])
            continue;
        buffer_format(text, "%s = ", param->row.name);
        buffer_exact(text, (struct measured){scene->value[i], scene->uncertainty[i]},
                     param->quantity);
        buffer_char(text, '\n');
    }
    atol_script(scene, "\n", text);
}

/* Writes the command `method` if anything about the method was chosen. */
static void save_method(const struct setup *setup, struct buffer *text)
{
    if (!setup->method_chosen && !setup->fixed && setup->drag == DRAG_DEFAULT)
        return;
    const char *const name = setup->method_chosen ? setup->method->row.name : "";
    buffer_format(text, "method%s%s", setup->method_chosen ? " " : "", name);
    if (setup->fixed) {
        buffer_put(text, TEXT(" dt="));
        buffer_exact(text, (struct measured){setup->settings.dt, 0}, QUANTITY_TIME);
    }
    if (setup->drag != DRAG_DEFAULT)
        buffer_format(text, " drag=%s", catalog_row(&drag_catalog, (size_t)setup->drag - 1)->name);
    buffer_char(text, '\n');
    if (setup->fixed && !setup->settings.dt_chosen)
        buffer_put(text, TEXT("unset dt\n"));
}

/* Writes `set NAME VALUE`. */
static void save_setting(const struct setting *setting, const struct settings *settings,
                         struct buffer *text)
{
    buffer_format(text, "set %s ", setting->row.name);
    setting_exact(setting, settings, text);
    buffer_char(text, '\n');
}

/* Purpose of the commands, which decides what is written. */
enum save_extent {
    SAVE_MOTION,  /* only what trajectories depend on */
    SAVE_FILE,    /* a file that the user saves */
    SAVE_SESSION, /* also settings of display, and scenes that are not the present one */
};

/* Writes `set NAME VALUE` for settings that differ from those of a new session and belong to the
 * extent. */
static void save_settings(const struct settings *settings, enum save_extent extent,
                          struct buffer *text)
{
    struct settings defaults;
    session_default_settings(&defaults);
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = setting_at(i);
        bool wanted;
        if (extent == SAVE_SESSION)
            wanted = !setting->typed;
        else
            wanted = extent == SAVE_FILE ? !setting->display : setting->of_run || setting->chosen;
        if (wanted && setting_is_chosen(setting, settings) &&
            (setting->chosen || !setting_same(setting, settings, &defaults)))
            save_setting(setting, settings, text);
    }
}

/* Returns a preset in which name has no meaning, so that a variable of that name can be made there;
 * NULL if there is none. */
static const struct row *scene_without(struct text name)
{
    const char *kind;
    for (size_t i = 0; i < preset_catalog.count; i++) {
        struct scene scene;
        const struct row *row = catalog_row(&preset_catalog, i);
        scene_init(&scene, preset_from(row));
        if (!scene_has_name(&scene, name, &kind))
            return row;
    }
    return NULL;
}

/* Writes the user's variables as `let` commands. They come before the scene, in which such a name
 * may mean something else; each is preceded by a `scene` command if the present scene would not
 * allow it. Returns true if the scene at the end is not the first preset. */
static bool save_let(const struct setup *setup, struct buffer *text)
{
    const struct row *now = catalog_row(&preset_catalog, 0), *first = now;
    for (int i = 0; i < setup->lets; i++) {
        const struct named_value *let = &setup->let[i];
        const struct row *scene = scene_without(text_of(let->name));
        if (scene && scene != now)
            buffer_format(text, "scene %s\n", scene->name);
        now = scene ? scene : now;
        buffer_format(text, "let %s = ", let->name);
        buffer_exact(text, (struct measured){let->value, let->uncertainty}, let->quantity);
        buffer_char(text, '\n');
    }
    return now != first;
}

/* ---- recordings ---- */

/* Writes the command that leaves out rejected samples. */
static void save_cleaned(const struct recording *recording, struct buffer *text)
{
    buffer_put(text, recording->cleaned ? TEXT("data clean apply\n") : TEXT(""));
}

/* Writes the window, unless it is the whole recording; cleaning may change it, too. */
static void save_window(const struct recording *recording, struct buffer *text)
{
    if (!recording->cleaned && recording->window[0] == recording->t[0] &&
        recording->window[1] == recording->t[recording->rows - 1])
        return;
    buffer_put(text, TEXT("data window "));
    buffer_real(text, recording->window[0]);
    buffer_char(text, ':');
    buffer_real(text, recording->window[1]);
    buffer_char(text, '\n');
}

/* Writes the value that is subtracted from all samples, unless it is 0. */
static void save_zero(const struct recording *recording, struct buffer *text)
{
    if (recording->zero == 0)
        return;
    buffer_put(text, TEXT("data zero "));
    buffer_real(text, recording->zero);
    buffer_char(text, '\n');
}

/* Writes the mass of the oscillator that was recorded, if it is known. */
static void save_mass(const struct recording *recording, struct buffer *text)
{
    if (!(recording->mass.value > 0))
        return;
    buffer_put(text, TEXT("data mass "));
    buffer_exact(text, recording->mass, QUANTITY_MASS);
    buffer_char(text, '\n');
}

#define IN_RECORDING(member, least, most) FIELD_IN(struct recording, member, least, most)
const struct recording_field recording_fields[RECORDING_FIELDS] = {
    {IN_RECORDING(cleaned, 0, 0), save_cleaned},
    {IN_RECORDING(window, -DBL_MAX, DBL_MAX), save_window},
    {IN_RECORDING(zero, -DBL_MAX, DBL_MAX), save_zero},
    {FIELD_CALLED_AS("mass", struct recording, mass, FIELD_REALS, 0, DBL_MAX), save_mass},
    {IN_RECORDING(velocity, 0, 0), NULL},
};

/* Appends the command `load` for the recording, with its options and a checksum of its file, and
 * the commands that set its other fields, such as its mass. */
static void save_recording(const struct recording_slot *slot, struct buffer *text)
{
    const struct recording *recording = slot->recording;
    const bool input = strcmp(recording->path, STANDARD_INPUT) == 0;
    buffer_put(text, TEXT("load "));
    buffer_word(text, input ? TEXT("-") : text_of(recording->path));
    buffer_put(text, text_of(slot->options));
    if (recording->sum != 0)
        buffer_format(text, " sum=%016llx", (unsigned long long)recording->sum);
    buffer_char(text, '\n');
    for (int i = 0; i < RECORDING_FIELDS; i++)
        if (recording_fields[i].save)
            recording_fields[i].save(recording, text);
}

/* Writes differences of the screen from that of a new session, without cursors, which belong to
 * runs. */
static void save_view(const struct view *view, struct buffer *text)
{
    const struct {
        const char *axis;
        const double *range;
    } ranges[] = {{"x", view->x}, {"y", view->y}};
    if (view->layout != LAYOUT_TRIO)
        buffer_format(text, "layout %s\n",
                      catalog_row(&layout_catalog, (size_t)view->layout)->name);
    if (view->window > 0) {
        buffer_put(text, TEXT("window "));
        buffer_exact(text, (struct measured){view->window, 0}, QUANTITY_TIME);
        buffer_char(text, '\n');
    }
    if (view->trail != VIEW_TRAIL_PERIODS) {
        buffer_put(text, TEXT("trail "));
        buffer_put(text, isinf(view->trail) ? TEXT("all") : TEXT(""));
        if (isfinite(view->trail))
            buffer_real(text, view->trail);
        buffer_char(text, '\n');
    }
    if (view->focus)
        buffer_format(text, "focus %s\n", view->focus->name);
    /* written without the name of a pane, which may have nothing to show in a new session */
    if (view->full)
        buffer_put(text, TEXT("focus full\n"));
    for (size_t i = 0; i < COUNT_OF(ranges); i++) {
        if (isnan(ranges[i].range[0]))
            continue;
        buffer_format(text, "range %s ", ranges[i].axis);
        buffer_real(text, ranges[i].range[0]);
        buffer_char(text, ':');
        buffer_real(text, ranges[i].range[1]);
        buffer_char(text, '\n');
    }
}

/* Writes all recordings, and then which of them use the velocity of another one. */
static void save_recordings(const struct session *session, struct buffer *text)
{
    for (int i = 0; i < session->recordings; i++)
        save_recording(session->recording[i], text);
    for (int i = 0; i < session->recordings; i++) {
        const struct recording *recording = session->recording[i]->recording;
        if (session_find_recording(session, text_of(recording->velocity)) >= 0)
            buffer_format(text, "data use %s\ndata join %s\n", recording->name,
                          recording->velocity);
    }
}

/* Returns true if a recording uses another one as its velocity. */
static bool uses_other_velocity(const struct session *session)
{
    for (int i = 0; i < session->recordings; i++)
        if (session->recording[i]->recording->velocity[0])
            return true;
    return false;
}

/* Writes `data use` unless loading has made the current recording current already. */
static void save_current_recording(const struct session *session, struct buffer *text)
{
    if (session->current_recording >= 0 &&
        (uses_other_velocity(session) || session->current_recording != session->recordings - 1))
        buffer_format(text, "data use %s\n", session_recording(session)->name);
}

/* Writes the scenes that the user has typed, without parameters. */
static void save_owns(const struct setup *setup, struct buffer *text)
{
    for (int i = 0; i < setup->owns; i++) {
        struct scene scene;
        scene_init(&scene, setup->own[i]);
        scene_kind_script(&scene, text);
    }
}

/* Writes variables, scenes, events, method, settings and calibration, in an order in which they can
 * be read. */
static void save_setup(const struct session *session, enum save_extent extent, struct buffer *text)
{
    const struct setup *setup = &session->setup;
    const struct calibration *calibration = &setup->calibration;
    bool elsewhere = save_let(setup, text);
    if (extent == SAVE_SESSION && setup->owns > 0) {
        save_owns(setup, text);
        elsewhere = true;
    }
    save_scene(&setup->scene, elsewhere, text);
    events_save(setup->events, text);
    save_method(setup, text);
    save_settings(&setup->settings, extent, text);
    if (extent != SAVE_MOTION && calibration->known) {
        buffer_put(text, TEXT("calibrate y "));
        calibration_put(calibration, text);
        buffer_char(text, '\n');
    } else if (extent == SAVE_SESSION && calibration->decided) {
        buffer_put(text, TEXT("calibrate off\n"));
    }
}

void session_save_motion(const struct session *session, struct buffer *text)
{
    save_setup(session, SAVE_MOTION, text);
}

void session_save_setup(const struct session *session, struct buffer *text)
{
    save_setup(session, SAVE_SESSION, text);
}

/* Writes set-up and recordings, for the file of the command save. */
void session_save(const struct session *session, struct buffer *text)
{
    buffer_put(text, TEXT("# set-up saved by hooke " HOOKE_VERSION "\n"));
    save_setup(session, SAVE_FILE, text);
    save_recordings(session, text);
    save_current_recording(session, text);
    if (!session->view.focus) /* other panes show runs, which are not saved */
        save_view(&session->view, text);
}
