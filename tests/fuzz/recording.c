/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Any bytes as an instrument's file: a recording or an error, never a crash; what loads can be
 * analysed. */
#define CORPUS "recording"
#define UNIT "files"
#include "fuzz/replay.h"
#include "fuzz/loaded.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    load(data, size);
    return 0;
}
