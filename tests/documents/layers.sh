#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The house of the source: layers, symbols (release builds only: sanitizers add their own).
[ "${CONFIG:-release}" = release ] && exec scripts/check-layers "${LIBHOOKE:-build/libhooke.a}"
exec scripts/check-layers
