/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The set-up as commands: only what differs from a new session, numbers that read back to the same doubles. */
#include "internal.h"

#include <string.h>

static void save_scene(const struct scene *scene, struct buffer *text)
{
    if (scene->preset != (const struct preset *)(const void *)catalog_row(&preset_catalog, 0))
        buffer_format(text, "scene %s\n", scene->preset->row.name);
    for (size_t i = 0; i < param_catalog.count; i++) {
        const struct param_row *param = (const struct param_row *)(const void *)catalog_row(&param_catalog, i);
        if (!scene->given[i])
            continue;
        buffer_format(text, "%s = ", param->row.name);
        buffer_exact(text, (struct measured){scene->value[i], scene->uncertainty[i]}, param->quantity);
        buffer_char(text, '\n');
    }
}

static void save_method(const struct setup *setup, struct buffer *text)
{
    if (strcmp(setup->method->row.name, "euler") == 0 && !setup->fixed && setup->drag == DRAG_DEFAULT)
        return;
    buffer_format(text, "method %s", setup->method->row.name);
    if (setup->fixed) {
        buffer_put(text, TEXT(" dt="));
        buffer_exact(text, (struct measured){setup->settings.dt, 0}, QUANTITY_TIME);
    }
    if (setup->drag != DRAG_DEFAULT)
        buffer_format(text, " drag=%s", catalog_row(&drag_catalog, (size_t)setup->drag - 1)->name);
    buffer_char(text, '\n');
}

static void save_settings(const struct settings *settings, struct buffer *text)
{
    struct settings defaults;
    session_default_settings(&defaults);
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = (const struct setting *)(const void *)catalog_row(&setting_catalog, i);
        struct buffer now = {0}, before = {0};
        setting_exact(setting, settings, &now);
        setting_exact(setting, &defaults, &before);
        if (!setting->display && !text_equal(buffer_text(&now), buffer_text(&before)))
            buffer_format(text, "set %s %s\n", setting->row.name, buffer_view(&now));
        text->failed |= now.failed || before.failed;
        buffer_free(&now);
        buffer_free(&before);
    }
}

static void save_let(const struct setup *setup, struct buffer *text)
{
    for (int i = 0; i < setup->lets; i++) {
        const struct named_value *let = &setup->let[i];
        buffer_format(text, "let %s = ", let->name);
        buffer_exact(text, (struct measured){let->value, let->uncertainty}, let->quantity);
        buffer_char(text, '\n');
    }
}

static void save_recording(const struct held_recording *held, struct buffer *text)
{
    const struct recording *recording = held->recording;
    buffer_put(text, TEXT("load "));
    buffer_word(text, text_of(recording->path));
    buffer_put(text, text_of(held->options));
    buffer_char(text, '\n');
    if (recording->window[0] != recording->t[0] || recording->window[1] != recording->t[recording->rows - 1]) {
        buffer_put(text, TEXT("data window "));
        buffer_real(text, recording->window[0]);
        buffer_char(text, ':');
        buffer_real(text, recording->window[1]);
        buffer_char(text, '\n');
    }
    if (recording->zero != 0) {
        buffer_put(text, TEXT("data zero "));
        buffer_real(text, recording->zero);
        buffer_char(text, '\n');
    }
}

void session_save(const struct session *session, struct buffer *text)
{
    buffer_put(text, TEXT("# set-up saved by hooke " HOOKE_VERSION "\n"));
    save_scene(&session->setup.scene, text);
    save_method(&session->setup, text);
    save_settings(&session->setup.settings, text);
    save_let(&session->setup, text);
    for (int i = 0; i < session->recordings; i++)
        save_recording(session->recording[i], text);
    if (session->current_recording >= 0 && session->current_recording != session->recordings - 1)
        buffer_format(text, "data use %s\n", session_recording(session)->name);
}
