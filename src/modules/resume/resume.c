/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module resume: sessions that save themselves in files and can be restored. */
#include "modules/resume/store/reading.h"

#include <hooke/module.h>

static const struct store_tools tools = {
    .put_array = store_put_array,
    .put_scene = store_put_scene,
    .note = reader_note,
    .array = reader_array,
    .scene = reader_scene,
    .move = reader_move,
    .bytes = reader_bytes,
};

const struct module resume_module = {
    .row = {"resume", "", "saves sessions continuously and restores them: --resume", "", NULL},
    .needs = "",
    .keeps = &tools,
};
